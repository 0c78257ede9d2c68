//! Driver programs for emitted kernels: read states as doubles, call every kernel at each state, and write
//! the outputs.
//!
//! Input: a force file in printed form. Output: the text of a program in the target's language. The input
//! stream contains, for every kernel in order, for each precision of the kernel, for every state, the inputs
//! in memory order; the output stream has the same order. Structs are filled and read as raw memory, so that
//! a field in the wrong order causes an error.

use forcec::internals::kernel::{File, Kernel, Precision, Target};
use forcec::internals::layout::{Lanes, Place};
use forcec::internals::model::bodies::{Body, ParameterType, Signature};
use forcec::internals::model::outputs::{Array, Part};
use forcec::internals::names::{Arguments, kernel_name};
use std::fmt::Write;

/// Number of reals in the inputs of a kernel.
pub fn inputs(signature: &Signature) -> usize {
    argument_lengths(signature).into_iter().sum()
}

/// Number of reals of each argument of a kernel: each body, all parameters together, and the other arguments.
fn argument_lengths(signature: &Signature) -> Vec<usize> {
    let stored = |body: &Body| body.kind.row().fields.iter().map(|field| field.length as usize).sum();
    let mut lengths: Vec<usize> = signature.bodies.iter().map(stored).collect();
    if signature.has_given() {
        lengths.push(signature.given().map(|(_, parameter)| parameter.ty.length() as usize).sum());
    }
    lengths.extend(signature.given_extras().map(|(_, extra)| extra.ty.length() as usize));
    lengths
}

/// Number of reals in the outputs of a kernel.
pub fn outputs(signature: &Signature, parts: &[Part]) -> usize {
    parts.iter().map(|part| part.length(signature)).sum()
}

/// Positions of the results in the memory that a kernel writes.
struct Written {
    /// For each entry of the full results, row by row: the 1-based position in the written memory; 0 for an
    /// entry that is always zero.
    places: Vec<i32>,
    /// Number of written reals.
    length: usize,
}

impl Written {
    fn new(kernel: &Kernel) -> Written {
        let length = outputs(&kernel.schedule.signature, &kernel.schedule.parts);
        let places = match &kernel.packing {
            Some(packing) => packing.places().collect(),
            None => (1..=length as i32).collect(),
        };
        Written { places, length }
    }

    /// The fields of the results, each with its first position in the written memory.
    fn fields(&self, kernel: &Kernel, target: Target) -> Vec<(String, usize)> {
        let signature = &kernel.schedule.signature;
        let names = Arguments::new(signature, target);
        let mut end = 0;
        let field = |part: &Part| {
            end += part.length(signature);
            (names.result(*part).to_owned(), end - part.length(signature))
        };
        kernel.schedule.parts.iter().map(field).collect()
    }
}

const C_HEAD: &str = "\
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void take_f64(void *to, size_t bytes)
{
    if (fread(to, 1, bytes, stdin) != bytes) memset(to, 0xff, bytes);
}

static void take_f32(void *to, size_t bytes)
{
    for (size_t at = 0; at < bytes; at += sizeof(float)) {
        double wide;
        take_f64(&wide, sizeof wide);
        float x = (float)wide;
        memcpy((char *)to + at, &x, sizeof x);
    }
}

static void give_f64(const void *from, size_t bytes)
{
    fwrite(from, 1, bytes, stdout);
}

static void give_f32(const void *from, size_t bytes)
{
    for (size_t at = 0; at < bytes; at += sizeof(float)) {
        float x;
        memcpy(&x, (const char *)from + at, sizeof x);
        double wide = x;
        give_f64(&wide, sizeof wide);
    }
}
";

/// The number of instances per call of a kernel.
fn count(kernel: &Kernel) -> usize {
    match kernel.lanes {
        Lanes::Several(count) => count,
        _ => 1,
    }
}

/// A C program that calls the kernels of one file at `states` states each. A kernel for several instances
/// gets several states per call, and unused lanes are filled with poison. Results in another layout are moved
/// to their dense positions. A kernel that adds to its output is called twice.
pub fn c(file: &File, states: usize) -> String {
    let mut text = format!("#include \"{}.h\"\n{C_HEAD}", file.name());
    let mut calls = String::new();
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            let signature = kernel.given();
            let real = if precision == Precision::F64 { "double" } else { "float" };
            let named = |part: &str| kernel_name(&kernel.name, Target::C, &format!("{part}_{precision}"));
            let (name, parameters, results) = (named(""), named("_params"), named("_out"));
            let (lanes, lengths) = (count(kernel), argument_lengths(signature));
            let several = if lanes > 1 { format!("x{lanes}") } else { String::new() };
            let mut types: Vec<String> = Vec::new();
            let bodies = signature.bodies.iter().map(|body| body.kind.row().c_name);
            types.extend(bodies.map(|name| format!("{name}_{precision}{several}")));
            types.extend(signature.has_given().then_some(parameters));
            let (mut declared, mut filled, mut shared) = (String::new(), String::new(), String::new());
            let mut arguments: Vec<String> = Vec::new();
            let mut at = 0;
            for (index, (ty, length)) in types.iter().zip(&lengths).enumerate() {
                let _ = writeln!(declared, "    {ty} argument_{index};");
                let _ = writeln!(
                    filled,
                    "            for (int k = 0; k < {length}; k++) \
                     (({real} *)&argument_{index})[k * {lanes} + lane] = given[lane][{at} + k];"
                );
                arguments.push(format!("&argument_{index}"));
                at += length;
            }
            for (index, extra) in signature.given_extras() {
                let length = extra.ty.length() as usize;
                if extra.ty == ParameterType::Real {
                    let _ = writeln!(declared, "    {real} extra_{index};");
                    let _ = writeln!(shared, "            extra_{index} = given[lane][{at}];");
                    arguments.push(format!("extra_{index}"));
                } else {
                    let _ = writeln!(declared, "    {real} extra_{index}[{length}][{lanes}];");
                    let _ = writeln!(
                        filled,
                        "            for (int k = 0; k < {length}; k++) \
                         extra_{index}[k][lane] = given[lane][{at} + k];"
                    );
                    arguments.push(if lanes > 1 {
                        format!("extra_{index}")
                    } else {
                        format!("extra_{index}[0]")
                    });
                }
                at += length;
            }
            arguments.push("&results".to_owned());
            let mut call = String::new();
            if kernel.once().is_some() {
                let _ = writeln!(declared, "    {} prepared;", named("_prepared"));
                let parameters = &mut arguments[signature.bodies.len()];
                call = format!("{}({parameters}, &prepared); ", named("_prepare"));
                *parameters = "&prepared".to_owned();
            }
            let _ = writeln!(call, "{name}({});", arguments.join(", "));
            let written = Written::new(kernel);
            let (places, count) = (written.places.len(), written.length);
            let (mut before, mut after) = (String::new(), String::new());
            if kernel.layout.row().place == Place::Shared {
                // The tables of the header are the tables that users read.
                let _ = writeln!(declared, "    static int places[{places}];");
                let mut start = 0;
                for table in kernel.packing.iter().flat_map(|packing| &packing.tables) {
                    let table_name = named(&format!("_{}", table.part));
                    let _ = writeln!(
                        before,
                        "            memcpy(places + {start}, {table_name}, sizeof {table_name});"
                    );
                    start += table.entries.len();
                }
            } else {
                let list: String = written.places.iter().map(|place| format!("{place}, ")).collect();
                let _ = writeln!(declared, "    static const int places[] = {{ {list}0 }};");
            }
            for (part, triangle) in
                kernel.triangles().filter(|_| kernel.layout.row().place == Place::Triangle)
            {
                let constant = named(&format!("_{part}_triangle"));
                let _ = writeln!(before, "            if ({constant} != {}) abort();", u8::from(triangle));
            }
            if kernel.schedule.adds {
                // Results added twice to zeros are twice as large; entries that are always zero are not
                // written.
                let _ = writeln!(declared, "    static {real} memory[{count}], *const found = memory;");
                for (field, start) in written.fields(kernel, Target::C) {
                    let _ = writeln!(before, "            results.{field} = (void *)(memory + {start});");
                }
                let _ = write!(
                    before,
                    "            memset(memory, 0xff, sizeof memory);\n            \
                     for (int k = 0; k < {places}; k++) if (places[k]) memory[abs(places[k]) - 1] = 0;\n"
                );
                let _ = write!(
                    after,
                    "            {call}            for (int k = 0; k < {count}; k++) {{\n                \
                     int known = 0;\n                \
                     for (int p = 0; p < {places}; p++) known |= abs(places[p]) == k + 1;\n                \
                     if (known) memory[k] /= 2;\n                else if (memory[k] == memory[k]) abort();\n            }}\n"
                );
            } else {
                let _ = writeln!(declared, "    {real} *const found = ({real} *)&results;");
            }
            let give = format!(
                "            for (int entry = 0; entry < {places}; entry++) {{\n                \
                 const int place = places[entry], k = abs(place) - 1;\n                \
                 {real} x = place == 0 ? 0 : found[k * {lanes} + lane];\n                \
                 x = place < 0 ? -x : x;\n                give_{precision}(&x, sizeof x);\n            }}\n"
            );
            let _ = write!(
                text,
                "\nstatic void run_{name}(void)\n{{\n    static {results} results;\n{declared}    \
                 static {real} given[{lanes}][{at} + 1];\n    \
                 for (int state = 0; state < {states}; state += {lanes}) {{\n        \
                 memset(given, 0xff, sizeof given);\n        \
                 for (int lane = 0; lane < {lanes} && state + lane < {states}; lane++)\n            \
                 take_{precision}(given[lane], {at} * sizeof({real}));\n        \
                 for (int lane = 0; lane < {lanes}; lane++) {{\n{filled}        }}\n        \
                 for (int lane = 0; lane < {lanes} && state + lane < {states}; lane++) {{\n{shared}            \
                 memset(&results, 0xff, sizeof results);\n{before}            {call}{after}{give}        }}\n    }}\n}}\n"
            );
            let _ = writeln!(calls, "    run_{name}();");
        }
    }
    let _ = write!(text, "\nint main(void)\n{{\n{calls}    return 0;\n}}\n");
    text
}

const RUST_HEAD: &str = "\
use std::io::{Read, Write};

trait Real: Copy {
    const POISON: Self;
    fn take() -> Self;
    fn give(self);
}

impl Real for f64 {
    const POISON: f64 = f64::NAN;
    fn take() -> f64 {
        let mut bytes = [0xff; 8];
        let _ = std::io::stdin().read_exact(&mut bytes);
        f64::from_ne_bytes(bytes)
    }
    fn give(self) {
        let _ = std::io::stdout().write_all(&self.to_ne_bytes());
    }
}

impl Real for f32 {
    const POISON: f32 = f32::NAN;
    fn take() -> f32 {
        f64::take() as f32
    }
    fn give(self) {
        f64::from(self).give();
    }
}

/// The memory of a struct of reals as a slice.
fn reals<S, R: Real>(value: &mut S) -> &mut [R] {
    let length = size_of::<S>() / size_of::<R>();
    assert_eq!(length * size_of::<R>(), size_of::<S>());
    // SAFETY: `repr(C)` structs of arrays of one real type, with the same layout as in C.
    unsafe { std::slice::from_raw_parts_mut(std::ptr::from_mut(value).cast::<R>(), length) }
}

/// Fills one lane of a struct for several instances.
fn fill<S, R: Real>(value: &mut S, lanes: usize, lane: usize, given: &[R]) {
    let reals = reals::<S, R>(value);
    given.iter().enumerate().for_each(|(k, x)| reals[k * lanes + lane] = *x);
}
";

/// A Rust program for the kernels of one file, at `states` states each, like [`c`]; the module of the kernels
/// must be in the same folder.
pub fn rust(file: &File, states: usize) -> String {
    let stem = &file.name();
    let mut text = format!("mod {stem};\n{RUST_HEAD}");
    let mut calls = String::new();
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            let signature = kernel.given();
            let (lanes, lengths) = (count(kernel), argument_lengths(signature));
            let named = |suffix| kernel_name(&kernel.name, Target::Rust, suffix);
            let several = if lanes > 1 { format!("X{lanes}") } else { String::new() };
            let (module, suffix) = match precision {
                Precision::F64 => (named(""), several),
                Precision::F32 => (named("_f32"), format!("F32{several}")),
            };
            let mut types: Vec<String> = Vec::new();
            let bodies = signature.bodies.iter().map(|body| body.kind.row().name);
            types.extend(bodies.map(|name| format!("{stem}::{name}{suffix}")));
            types.extend(signature.has_given().then(|| format!("{stem}::{module}::Params")));
            let (mut declared, mut filled, mut shared) = (String::new(), String::new(), String::new());
            let mut arguments: Vec<String> = Vec::new();
            let mut at = 0;
            for (index, (ty, length)) in types.iter().zip(&lengths).enumerate() {
                let _ = writeln!(declared, "        let mut argument_{index} = {ty}::default();");
                let range = format!("{at}..{}", at + length);
                let _ = writeln!(
                    filled,
                    "            fill::<_, {precision}>(&mut argument_{index}, {lanes}, lane, &given[lane][{range}]);"
                );
                arguments.push(format!("&argument_{index}"));
                at += length;
            }
            for (index, extra) in signature.given_extras() {
                let length = extra.ty.length() as usize;
                if extra.ty == ParameterType::Real {
                    let _ = writeln!(shared, "            let extra_{index} = given[lane][{at}];");
                    arguments.push(format!("extra_{index}"));
                } else {
                    let entry =
                        if lanes > 1 { format!("[0.0; {lanes}]") } else { format!("0.0_{precision}") };
                    let _ = writeln!(declared, "        let mut extra_{index} = [{entry}; {length}];");
                    let range = format!("{at}..{}", at + length);
                    let _ = writeln!(
                        filled,
                        "            fill::<_, {precision}>(&mut extra_{index}, {lanes}, lane, &given[lane][{range}]);"
                    );
                    arguments.push(format!("&extra_{index}"));
                }
                at += length;
            }
            let prepared = kernel
                .once()
                .map(|_| std::mem::replace(&mut arguments[signature.bodies.len()], "&prepared".to_owned()));
            let arguments: String = arguments.iter().map(|argument| format!("{argument}, ")).collect();
            let path = format!("{stem}::{module}");
            let call = format!("            {path}::evaluate({arguments}&mut results);\n");
            if let Some(parameters) = prepared {
                let _ = writeln!(shared, "            let mut prepared = {path}::Prepared::default();");
                let _ = writeln!(shared, "            {path}::prepare({parameters}, &mut prepared);");
            }
            let written = Written::new(kernel);
            if kernel.layout.row().place == Place::Shared {
                // The tables of the module are the tables that users read.
                let table = |table: &Array<i32>| {
                    let flat = if table.part.is_list() { "as_slice" } else { "as_flattened" };
                    format!("{path}::{}_PLACES.{flat}(), ", table.part.name().to_ascii_uppercase())
                };
                let tables = kernel.packing.iter().flat_map(|packing| &packing.tables);
                let tables: String = tables.map(table).collect();
                let _ = writeln!(declared, "        let places: &[i32] = &[{tables}].concat();");
            } else {
                let places = written.places.iter().map(|place| format!("{place}, ")).collect::<String>();
                let _ = writeln!(declared, "        let places: &[i32] = &[{places}];");
            }
            for (part, triangle) in
                kernel.triangles().filter(|_| kernel.layout.row().place == Place::Triangle)
            {
                let constant = format!("{path}::{}_TRIANGLE", part.name().to_ascii_uppercase());
                let _ = writeln!(declared, "        const {{ assert!({constant} == {triangle}) }};");
            }
            let compute = if kernel.schedule.adds {
                let fields = written.fields(kernel, Target::Rust);
                let mut text = format!(
                    "            let mut memory = vec![{precision}::POISON; {}];\n            \
                     for place in places.iter().filter(|place| **place != 0) {{\n                \
                     memory[place.unsigned_abs() as usize - 1] = 0.0;\n            }}\n",
                    written.length
                );
                let results = &kernel.schedule.signature;
                let parts = kernel.schedule.parts.iter().map(|part| part.shape(results));
                for (index, ((_, start), (rows, columns))) in fields.iter().zip(parts).enumerate() {
                    let list = kernel.schedule.parts[index].is_list();
                    let row = if list { "0.0".to_owned() } else { format!("[0.0; {columns}]") };
                    let _ = write!(
                        text,
                        "            let mut field_{index} = [{row}; {rows}];\n            \
                         reals::<_, {precision}>(&mut field_{index}).copy_from_slice(&memory[{start}..][..{}]);\n",
                        rows * columns
                    );
                }
                let given: String = fields
                    .iter()
                    .enumerate()
                    .map(|(k, (name, _))| format!("{name}: &mut field_{k}, "))
                    .collect();
                let _ =
                    write!(text, "            let mut results = {path}::Output {{ {given}}};\n{call}{call}");
                for (index, (_, start)) in fields.iter().enumerate() {
                    let _ = writeln!(
                        text,
                        "            for (k, x) in reals::<_, {precision}>(&mut field_{index}).iter().enumerate() {{\n                \
                         let known = places.iter().any(|p| p.unsigned_abs() as usize == {start} + k + 1);\n                \
                         assert!(known || x.is_nan());\n                \
                         memory[{start} + k] = *x / 2.0;\n            }}"
                    );
                }
                text + "            let found = &memory;\n"
            } else {
                format!(
                    "            let mut results = {path}::Output::default();\n            \
                     reals::<_, {precision}>(&mut results).fill(Real::POISON);\n{call}            \
                     let found = reals::<_, {precision}>(&mut results);\n"
                )
            };
            let give = format!(
                "            for &place in places {{\n                \
                 let at = |k: i32| found[k as usize * {lanes} + lane];\n                \
                 let x = match place {{\n                    0 => 0.0,\n                    \
                 1.. => at(place - 1),\n                    _ => -at(-place - 1),\n                \
                 }};\n                x.give();\n            }}\n"
            );
            let _ = write!(
                text,
                "\nfn run_{module}() {{\n    for state in (0..{states}usize).step_by({lanes}) {{\n{declared}        \
                 let count = {lanes}.min({states} - state);\n        \
                 let mut given = [[{precision}::POISON; {at} + 1]; {lanes}];\n        \
                 given[..count].iter_mut().for_each(|given| given[..{at}].fill_with(Real::take));\n        \
                 for lane in 0..{lanes} {{\n{filled}        }}\n        \
                 for lane in 0..count {{\n{shared}{compute}{give}        }}\n    }}\n}}\n"
            );
            let _ = writeln!(calls, "    run_{module}();");
        }
    }
    let _ = write!(text, "\nfn main() {{\n{calls}}}\n");
    text
}
