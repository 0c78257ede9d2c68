//! Programs around emitted kernels: they read states as doubles, call every kernel at each, and write its outputs.
//!
//! In: a force file as it is printed. Out: the text of a program in the target's language. The stream of doubles is, for
//! every kernel in order, for each of its precisions, for every state, the inputs in memory order; the answer
//! likewise. Structs are filled and read as memory, so that a field out of order shows.

use forcec::bodies::Signature;
use forcec::identifiers::kernel_name;
use forcec::kernel::{File, Precision, Target};
use forcec::outputs::Part;
use std::fmt::Write;

/// How many reals a kernel takes.
pub fn inputs(signature: &Signature) -> usize {
    let bodies = signature.bodies.iter().flat_map(|body| body.kind.row().fields);
    let parameters = signature.given().map(|(_, parameter)| parameter.ty.length() as usize);
    bodies.map(|field| field.length as usize).sum::<usize>() + parameters.sum::<usize>()
}

/// How many reals a kernel gives.
pub fn outputs(signature: &Signature, parts: &[Part]) -> usize {
    parts.iter().map(|part| part.length(signature)).sum()
}

const C_HEAD: &str = "\
#include <stdio.h>
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

/// A C program over the kernels of one file, `states` states each.
pub fn c(file: &File, states: usize) -> String {
    let mut text = format!("#include \"{}.h\"\n{C_HEAD}", file.stem);
    let mut calls = String::new();
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            let signature = &kernel.schedule.signature;
            let named = |part: &str| kernel_name(&kernel.name, Target::C, &format!("{part}_{precision}"));
            let (name, parameters, results) = (named(""), named("_params"), named("_out"));
            let mut declared = String::new();
            let mut taken = String::new();
            let mut arguments: Vec<String> = Vec::new();
            for (index, body) in signature.bodies.iter().enumerate() {
                let _ = writeln!(declared, "    {}_{precision} body_{index};", body.kind.row().c_name);
                arguments.push(format!("body_{index}"));
            }
            if signature.has_given() {
                let _ = writeln!(declared, "    {parameters} parameters;");
                arguments.push("parameters".to_owned());
            }
            for argument in &arguments {
                let _ = writeln!(taken, "        take_{precision}(&{argument}, sizeof {argument});");
            }
            arguments.push("results".to_owned());
            let arguments: Vec<String> = arguments.iter().map(|argument| format!("&{argument}")).collect();
            let arguments = arguments.join(", ");
            let _ = write!(
                text,
                "\nstatic void run_{name}(void)\n{{\n{declared}    static {results} results;\n\
                 \x20   for (int state = 0; state < {states}; state++) {{\n{taken}\
                 \x20       memset(&results, 0xff, sizeof results);\n        {name}({arguments});\n\
                 \x20       give_{precision}(&results, sizeof results);\n    }}\n}}\n"
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

fn fill<S, R: Real>(value: &mut S) {
    reals::<S, R>(value).fill_with(R::take);
}
";

/// A Rust program over the kernels of one file, which it expects beside it, `states` states each.
pub fn rust(file: &File, states: usize) -> String {
    let stem = &file.stem;
    let mut text = format!("mod {stem};\n{RUST_HEAD}");
    let mut calls = String::new();
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            let signature = &kernel.schedule.signature;
            let named = |suffix| kernel_name(&kernel.name, Target::Rust, suffix);
            let (module, suffix) = match precision {
                Precision::F64 => (named(""), ""),
                Precision::F32 => (named("_f32"), "F32"),
            };
            let mut filled = String::new();
            let mut arguments: Vec<String> = Vec::new();
            for (index, body) in signature.bodies.iter().enumerate() {
                let ty = format!("{stem}::{}{suffix}", body.kind.row().name);
                let _ = writeln!(filled, "        let mut body_{index} = {ty}::default();");
                arguments.push(format!("body_{index}"));
            }
            if signature.has_given() {
                let _ = writeln!(filled, "        let mut parameters = {stem}::{module}::Params::default();");
                arguments.push("parameters".to_owned());
            }
            for argument in &arguments {
                let _ = writeln!(filled, "        fill::<_, {precision}>(&mut {argument});");
            }
            let arguments: String = arguments.iter().map(|argument| format!("&{argument}, ")).collect();
            let _ = write!(
                text,
                "\nfn run_{module}() {{\n    for _ in 0..{states} {{\n{filled}\
                 \x20       let mut results = {stem}::{module}::Output::default();\n\
                 \x20       reals::<_, {precision}>(&mut results).fill(Real::POISON);\n\
                 \x20       {stem}::{module}::evaluate({arguments}&mut results);\n\
                 \x20       reals::<_, {precision}>(&mut results).iter().for_each(|x| x.give());\n    }}\n}}\n"
            );
            let _ = writeln!(calls, "    run_{module}();");
        }
    }
    let _ = write!(text, "\nfn main() {{\n{calls}}}\n");
    text
}
