//! Programs around emitted kernels: they read states as doubles, call every kernel at each, and write its outputs.
//!
//! In: a force file as it is printed. Out: the text of a program in the target's language. The stream of doubles is, for
//! every kernel in order, for each of its precisions, for every state, the inputs in memory order; the answer
//! likewise. Structs are filled and read as memory, so that a field out of order shows.

use forcec::bodies::{Body, ParameterType, Signature};
use forcec::identifiers::kernel_name;
use forcec::kernel::{File, Precision, Target};
use forcec::outputs::{Array, Part};
use std::fmt::Write;

/// How many reals a kernel takes.
pub fn inputs(signature: &Signature) -> usize {
    argument_lengths(signature).into_iter().sum()
}

/// How many reals each argument of a kernel has: bodies, all parameters together, and what else there is.
fn argument_lengths(signature: &Signature) -> Vec<usize> {
    let stored = |body: &Body| body.kind.row().fields.iter().map(|field| field.length as usize).sum();
    let mut lengths: Vec<usize> = signature.bodies.iter().map(stored).collect();
    if signature.has_given() {
        lengths.push(signature.given().map(|(_, parameter)| parameter.ty.length() as usize).sum());
    }
    lengths.extend(signature.given_extras().map(|(_, extra)| extra.ty.length() as usize));
    lengths
}

/// How many reals a kernel gives.
pub fn outputs(signature: &Signature, parts: &[Part]) -> usize {
    parts.iter().map(|part| part.length(signature)).sum()
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

/// A C program over the kernels of one file, `states` states each. What computes several instances at once is given as
/// many states; what is left over is poison. What is packed is unpacked by the tables of the header.
pub fn c(file: &File, states: usize) -> String {
    let mut text = format!("#include \"{}.h\"\n{C_HEAD}", file.name());
    let mut calls = String::new();
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            let signature = &kernel.schedule.signature;
            let real = if precision == Precision::F64 { "double" } else { "float" };
            let named = |part: &str| kernel_name(&kernel.name, Target::C, &format!("{part}_{precision}"));
            let (name, parameters, results) = (named(""), named("_params"), named("_out"));
            let (lanes, lengths) = (kernel.lanes, argument_lengths(signature));
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
            let arguments = arguments.join(", ");
            let result = format!("(({real} *)&results)[k * {lanes} + lane]");
            let give = match &kernel.packing {
                None => format!(
                    "            for (int k = 0; k < (int)(sizeof results / sizeof({real}) / {lanes}); k++)\n\
                     \x20               give_{precision}(&{result}, sizeof({real}));\n"
                ),
                Some(packing) => {
                    let table = |table: &Array<i32>| {
                        let name = named(&format!("_{}", table.part));
                        format!(
                            "            for (int entry = 0; entry < {}; entry++) {{\n\
                             \x20               const int place = ((const int *){name})[entry], k = abs(place) - 1;\n\
                             \x20               {real} x = place == 0 ? 0 : {result};\n\
                             \x20               x = place < 0 ? -x : x;\n\
                             \x20               give_{precision}(&x, sizeof x);\n            }}\n",
                            table.entries.len()
                        )
                    };
                    packing.tables.iter().map(table).collect()
                }
            };
            let _ = write!(
                text,
                "\nstatic void run_{name}(void)\n{{\n{declared}    static {results} results;\n    \
                 static {real} given[{lanes}][{at} + 1];\n    \
                 for (int state = 0; state < {states}; state += {lanes}) {{\n        \
                 memset(given, 0xff, sizeof given);\n        \
                 for (int lane = 0; lane < {lanes} && state + lane < {states}; lane++)\n            \
                 take_{precision}(given[lane], {at} * sizeof({real}));\n        \
                 for (int lane = 0; lane < {lanes}; lane++) {{\n{filled}        }}\n        \
                 for (int lane = 0; lane < {lanes} && state + lane < {states}; lane++) {{\n{shared}            \
                 memset(&results, 0xff, sizeof results);\n            {name}({arguments});\n{give}        }}\n    }}\n}}\n"
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

/// The memory of a struct of reals.
fn reals<S, R: Real>(value: &mut S) -> &mut [R] {
    let length = size_of::<S>() / size_of::<R>();
    assert_eq!(length * size_of::<R>(), size_of::<S>());
    // SAFETY: `repr(C)` structs of arrays of one real type, as C has them.
    unsafe { std::slice::from_raw_parts_mut(std::ptr::from_mut(value).cast::<R>(), length) }
}

/// Fills one of several instances.
fn fill<S, R: Real>(value: &mut S, lanes: usize, lane: usize, given: &[R]) {
    let reals = reals::<S, R>(value);
    given.iter().enumerate().for_each(|(k, x)| reals[k * lanes + lane] = *x);
}
";

/// A Rust program over the kernels of one file, which it expects beside it, `states` states each; as [`c`].
pub fn rust(file: &File, states: usize) -> String {
    let stem = &file.name();
    let mut text = format!("mod {stem};\n{RUST_HEAD}");
    let mut calls = String::new();
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            let signature = &kernel.schedule.signature;
            let (lanes, lengths) = (kernel.lanes, argument_lengths(signature));
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
            let arguments: String = arguments.iter().map(|argument| format!("{argument}, ")).collect();
            let give = match &kernel.packing {
                None => format!("            found.chunks({lanes}).for_each(|lanes| lanes[lane].give());\n"),
                Some(packing) => {
                    let table = |table: &Array<i32>| {
                        let name = format!("{}_PLACES", table.part.name().to_ascii_uppercase());
                        let flat = if table.part.is_list() { ".iter()" } else { ".as_flattened()" };
                        format!(
                            "            for &place in {stem}::{module}::{name}{flat} {{\n                \
                             let at = |k: i32| found[k as usize * {lanes} + lane];\n                \
                             let x = match place {{\n                    0 => 0.0,\n                    \
                             1.. => at(place - 1),\n                    _ => -at(-place - 1),\n                \
                             }};\n                x.give();\n            }}\n"
                        )
                    };
                    packing.tables.iter().map(table).collect()
                }
            };
            let _ = write!(
                text,
                "\nfn run_{module}() {{\n    for state in (0..{states}usize).step_by({lanes}) {{\n{declared}        \
                 let count = {lanes}.min({states} - state);\n        \
                 let mut given = [[{precision}::POISON; {at} + 1]; {lanes}];\n        \
                 given[..count].iter_mut().for_each(|given| given[..{at}].fill_with(Real::take));\n        \
                 for lane in 0..{lanes} {{\n{filled}        }}\n        \
                 for lane in 0..count {{\n{shared}            \
                 let mut results = {stem}::{module}::Output::default();\n            \
                 reals::<_, {precision}>(&mut results).fill(Real::POISON);\n            \
                 {stem}::{module}::evaluate({arguments}&mut results);\n            \
                 let found = reals::<_, {precision}>(&mut results);\n{give}        }}\n    }}\n}}\n"
            );
            let _ = writeln!(calls, "    run_{module}();");
        }
    }
    let _ = write!(text, "\nfn main() {{\n{calls}}}\n");
    text
}
