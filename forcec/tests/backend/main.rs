//! The back end: printed code compiles without a warning, computes the values of the program, and states its
//! operation counts correctly.

mod programs;
mod prose;

use forcec::internals::emit;
use forcec::internals::kernel::{File, Kernel, Precision, Target};
use forcec::internals::model::bodies::Slot;
use forcec::internals::names::Arguments;
use forcec::internals::scalar::eval::{self, Outputs};
use forcec::internals::scalar::{Operations, Program};
use forcec::internals::schedule::meanings::Meanings;
use forcec::internals::schedule::{Style, schedule};
use std::path::{Path, PathBuf};
use std::process::Command;

fn kernels() -> Vec<(String, Program)> {
    let own = [programs::spring(), programs::everything(), programs::rows()];
    let names = ["spring", "everything", "rows"].map(str::to_owned);
    let mut all: Vec<(String, Program)> = names.into_iter().zip(own).collect();
    all.extend((1..9).map(|seed| (format!("random_{seed}"), programs::random(seed, 40 * seed as usize))));
    all
}

fn file() -> File {
    let kernels = kernels().into_iter().map(|(name, program)| {
        let docs =
            vec![format!("The kernel `{name}` /* odd */ text."), String::new(), "More about it.".to_owned()];
        let formulas = vec!["F = -J^T (stiffness C + damping dC/dt)".to_owned()];
        Kernel::dense(name, docs, formulas, schedule(&program, Style::default(), &Meanings::default()))
    });
    File {
        stem: "made".to_owned(),
        docs: vec!["Kernels for tests.".to_owned()],
        kernels: kernels.collect(),
        precisions: vec![Precision::F64, Precision::F32],
    }
}

/// An empty folder of this name.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn write(folder: &Path, target: Target) {
    for generated in emit::emit(&file(), target) {
        std::fs::write(folder.join(generated.name), generated.text).unwrap();
    }
}

fn run(folder: &Path, program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).current_dir(folder).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {arguments:?}\n{text}{errors}");
    text
}

/// Compares printed outputs, one per line, kernel by kernel in both precisions.
fn compare(text: &str) {
    let mut lines = text.lines();
    for (name, program) in kernels() {
        let signature = program.signature.clone();
        let input = |slot: Slot| programs::input(&signature, slot);
        let schedule = schedule(&program, Style::default(), &Meanings::default());
        let wide = schedule.evaluate::<f64>(&input).unwrap();
        let narrow = schedule.evaluate::<f32>(&|slot| input(slot) as f32).unwrap();
        let narrow: Vec<f64> = narrow.iter().map(|x| f64::from(*x)).collect();
        for (precision, tolerance, expected) in
            [("f64", 1e-12, wide.iter().copied().collect::<Vec<_>>()), ("f32", 2e-3, narrow)]
        {
            for (i, expected) in expected.iter().enumerate() {
                let got: f64 = lines.next().unwrap().parse().unwrap();
                let close = got == *expected
                    || (got - expected).abs() <= tolerance * expected.abs().max(1e-3)
                    || got.is_nan() && expected.is_nan();
                assert!(close, "{name}_{precision}, output {i}: {got} is not {expected}");
            }
        }
    }
    assert_eq!(lines.next(), None);
}

#[test]
fn schedules_compute_what_the_program_means() {
    for (name, program) in kernels() {
        let signature = program.signature.clone();
        let input = |slot: Slot| programs::input(&signature, slot);
        let exact: Outputs<f64> = eval::evaluate(&program, &input);
        let scheduled = schedule(&program, Style::default(), &Meanings::default())
            .evaluate(&input)
            .expect("every output is written");
        for (i, (x, y)) in exact.iter().zip(scheduled.iter()).enumerate() {
            let close = x == y || (x - y).abs() <= 1e-9 * x.abs().max(1e-3) || x.is_nan() && y.is_nan();
            assert!(close, "{name}, output {i}: {y} is not {x}");
        }
    }
}

/// C or Rust that fills every argument of every kernel, calls it and prints the outputs.
fn driver(target: Target) -> String {
    let mut text = String::new();
    for kernel in file().kernels {
        let signature = &kernel.schedule.signature;
        let count = signature.dofs();
        for precision in [Precision::F64, Precision::F32] {
            let (real, name) = (if precision == Precision::F64 { "double" } else { "float" }, &kernel.name);
            let (mut fill, mut call) = (String::new(), Vec::new());
            let mut argument =
                |index: usize, ty: String, fields: Vec<(u8, String, usize)>, call_as: String| {
                    let values = |length: usize, field: u8| {
                        (0..length).map(move |offset| {
                            let slot = Slot { argument: index as u16, field, offset: offset as u32 };
                            format!("{:?}", programs::input(signature, slot))
                        })
                    };
                    match target {
                        Target::C => {
                            let all: Vec<String> =
                                fields.iter().flat_map(|(f, _, n)| values(*n, *f)).collect();
                            fill.push_str(&format!(
                                "static const {real} v_{call_as}[] = {{ {} }};\n",
                                all.join(", ")
                            ));
                            fill.push_str(&format!(
                                "{ty} {call_as}; memcpy(&{call_as}, v_{call_as}, sizeof {call_as});\n"
                            ));
                        }
                        Target::Rust => {
                            fill.push_str(&format!("let mut {call_as} = {ty}::default();\n"));
                            for (field, path, length) in fields {
                                for (offset, value) in values(length, field).enumerate() {
                                    fill.push_str(&format!(
                                        "{call_as}.{} = {value};\n",
                                        path.replace('@', &offset.to_string())
                                    ));
                                }
                            }
                        }
                    }
                    call.push(format!("&{call_as}"));
                };
            for (index, body) in signature.bodies.iter().enumerate() {
                let row = body.kind.row();
                let ty = match (target, precision) {
                    (Target::C, _) => format!("{}_{precision}", row.c_name),
                    (_, Precision::F64) => format!("made::{}", row.name),
                    _ => format!("made::{}F32", row.name),
                };
                let fields = row.fields.iter().enumerate();
                let fields =
                    fields.map(|(i, f)| (i as u8, format!("{}[@]", f.name), f.length as usize)).collect();
                argument(index, ty, fields, format!("body_{index}"));
            }
            let module = if precision == Precision::F64 { name.clone() } else { format!("{name}_f32") };
            if target == Target::C {
                let mut all = Vec::new();
                for (index, parameter) in signature.parameters.iter().enumerate() {
                    all.push((index + signature.bodies.len(), parameter.ty.length()));
                }
                let values: Vec<String> = all
                    .iter()
                    .flat_map(|&(index, length)| (0..length).map(move |offset| (index, offset)))
                    .map(|(index, offset)| Slot { argument: index as u16, field: 0, offset: offset as u32 })
                    .map(|slot| format!("{:?}", programs::input(signature, slot)))
                    .collect();
                text.push_str(&format!("static void run_{module}(void) {{\n{fill}"));
                text.push_str(&format!("static const {real} values[] = {{ {} }};\n", values.join(", ")));
                text.push_str(&format!(
                    "{name}_params_{precision} params; memcpy(&params, values, sizeof params);\n"
                ));
                text.push_str(&format!(
                    "static {name}_out_{precision} out; memset(&out, 0xff, sizeof out);\n"
                ));
                call.extend(["&params".to_owned(), "&out".to_owned()]);
                text.push_str(&format!("{name}_{precision}({});\n", call.join(", ")));
                let total = count + 2 * count * count;
                text.push_str(&format!("const {real} *all = (const {real} *)&out;\n"));
                text.push_str(&format!(
                    "for (int i = 0; i < {total}; i++) printf(\"%.17g\\n\", (double)all[i]);\n}}\n"
                ));
            } else {
                text.push_str(&format!("fn run_{module}() {{\n{fill}"));
                text.push_str(&format!("let mut params = made::{module}::Params::default();\n"));
                let fields = Arguments::new(signature, Target::Rust).parameters;
                for (index, (parameter, field)) in signature.parameters.iter().zip(fields).enumerate() {
                    for offset in 0..parameter.ty.length() as u32 {
                        let slot = signature.parameter_slot(index, offset);
                        let indices =
                            forcec::internals::model::bodies::indices(&parameter.ty.extents(), offset);
                        let indices: String = indices.iter().map(|i| format!("[{i}]")).collect();
                        let value = programs::input(signature, slot);
                        text.push_str(&format!("params.{field}{indices} = {value:?};\n"));
                    }
                }
                text.push_str(&format!("let mut out = made::{module}::Output::default();\n"));
                text.push_str(&format!(
                    "out.force = [1e9; {count}]; out.dfdx = [out.force; {count}]; out.dfdv = out.dfdx;\n"
                ));
                call.extend(["&params".to_owned(), "&mut out".to_owned()]);
                text.push_str(&format!("made::{module}::evaluate({});\n", call.join(", ")));
                text.push_str("for x in out.force.iter().chain(out.dfdx.iter().flatten()).chain(out.dfdv.iter().flatten()) {\n");
                text.push_str("println!(\"{x:?}\");\n}\n}\n");
            }
        }
    }
    let calls: Vec<String> = kernels()
        .iter()
        .flat_map(|(name, _)| [format!("    run_{name}();\n"), format!("    run_{name}_f32();\n")])
        .collect();
    match target {
        Target::C => format!(
            "#include <stdio.h>\n#include <string.h>\n#include \"made.h\"\n{text}int main(void) {{\n{}}}\n",
            calls.concat()
        ),
        Target::Rust => format!(
            "#![deny(missing_docs)]\n//! x\n/// y\npub mod made;\n{text}fn main() {{\n{}}}\n",
            calls.concat()
        ),
    }
}

const STRICT: [&str; 8] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wshadow",
    "-Werror",
];

#[test]
fn c_compiles_without_a_warning_and_computes_the_same() {
    let folder = folder("c");
    write(&folder, Target::C);
    std::fs::write(folder.join("driver.c"), driver(Target::C)).unwrap();
    let strict = STRICT.as_slice();
    run(&folder, "gcc", &[strict, &["-O1", "-c", "made.c"]].concat());
    run(&folder, "gcc", &["-std=c99", "driver.c", "made.o", "-lm", "-o", "driver"]);
    std::fs::write(folder.join("both.cpp"), "#include \"made.h\"\nint main() { return 0; }\n").unwrap();
    run(
        &folder,
        "g++",
        &["-Wall", "-Wextra", "-Wpedantic", "-Werror", "both.cpp", "made.o", "-lm", "-o", "both"],
    );
    compare(&run(&folder, "./driver", &[]));
}

#[test]
fn rust_compiles_without_a_warning_and_computes_the_same() {
    let folder = folder("rust");
    write(&folder, Target::Rust);
    std::fs::write(folder.join("driver.rs"), driver(Target::Rust)).unwrap();
    let library = "#![deny(missing_docs)]\n//! A crate.\n\npub mod made;\n";
    std::fs::write(folder.join("lib.rs"), library).unwrap();
    std::fs::write(folder.join("rustfmt.toml"), "").unwrap();
    run(&folder, "rustfmt", &["--edition", "2024", "--check", "made.rs"]);
    let edition = ["--edition", "2024", "-D", "warnings"];
    run(
        &folder,
        "clippy-driver",
        &[&edition[..], &["-D", "clippy::all", "--crate-type", "lib", "lib.rs"]].concat(),
    );
    run(&folder, "rustc", &["--edition", "2024", "-A", "warnings", "driver.rs"]);
    compare(&run(&folder, "./driver", &[]));
}

/// Counts operators and calls in the bodies of emitted functions, with loop bodies weighted by the number of
/// iterations, independently of the code generator.
fn recount(text: &str, dofs: usize) -> Operations {
    let mut total = Operations::default();
    let mut outer = 1;
    for line in text.lines().map(str::trim) {
        let (mut line, mut times) = (line, std::mem::replace(&mut outer, 1));
        while let Some((head, rest)) = line.strip_prefix("for (int ").and_then(|rest| rest.split_once(')')) {
            let bound = |sign: &str| -> usize {
                let (_, bound) = head.split_once(sign).unwrap();
                bound.split_once(';').unwrap().0.parse().unwrap()
            };
            times *= bound(" < ") - bound(" = ");
            line = rest.trim();
        }
        if line.is_empty() {
            outer = times;
            continue;
        }
        if let Some((_, closure)) = line.split_once(".map(|") {
            line = closure.split_once("| ").unwrap().1.strip_suffix(");").unwrap();
            times = dofs;
        }
        let mut count = Operations::default();
        if line.starts_with("for ")
            || line.starts_with("//")
            || line.starts_with("/*")
            || line.starts_with("row[")
        {
            continue;
        }
        // An index is not an operation.
        let line = line.replace("->", ".").replace("[i - ", "[").replace(".fill(", " ");
        let value = line.split_once(" = ").map_or(line.as_str(), |(_, value)| value);
        // A sign after `if` is not a subtraction.
        let value = value.strip_prefix("if ").unwrap_or(value);
        let tokens: Vec<char> = value.chars().collect();
        for (i, token) in tokens.iter().enumerate() {
            let before = tokens[..i].iter().rev().find(|c| **c != ' ');
            let after = tokens.get(i + 1).copied().unwrap_or(' ');
            let exponent = i > 0 && tokens[i - 1] == 'e' && after.is_ascii_digit();
            let after_text: String = tokens[i + 1..].iter().collect();
            let constant = ["core::", "f32::", "FORCEC_PI"].iter().any(|path| after_text.starts_with(path));
            let binary = before
                .is_some_and(|c| c.is_ascii_alphanumeric() || *c == ')' || *c == ']' || *c == '_')
                && i > 0
                && tokens[i - 1] == ' ';
            match token {
                '+' if !exponent => count.add += 1,
                '-' if exponent => {}
                '-' if binary => count.add += 1,
                '-' if !after.is_ascii_digit() && !constant => count.neg += 1,
                '*' => count.mul += 1,
                '/' => count.div += 1,
                '<' => count.call += 1,
                '=' if after == '=' => count.call += 1,
                '?' => count.call += 1,
                _ => {}
            }
        }
        for word in value.split(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '(') {
            let Some((head, _)) = word.split_once('(') else { continue };
            match head {
                "" | "from_bits" => {}
                "sqrt" | "sqrtf" => count.sqrt += 1,
                _ => count.call += 1,
            }
        }
        if line.contains("= if ") {
            count.call += 1;
        }
        (0..times).for_each(|_| total += count);
    }
    total
}

#[test]
fn operations_are_counted_on_the_text() {
    for (name, program) in kernels() {
        let schedule = schedule(&program, Style::default(), &Meanings::default());
        let kernel = Kernel::dense(name.clone(), vec![], vec![], schedule);
        let operations = kernel.schedule.operations();
        let dofs = kernel.schedule.signature.dofs();
        let rust = emit::rust::kernel_module(&kernel, Precision::F32);
        let start = rust.find("pub fn evaluate").unwrap();
        assert_eq!(recount(rust[start..].split_once("{\n").unwrap().1, dofs), operations, "{name} in Rust");
        let file = File {
            stem: name.clone(),
            docs: vec![],
            kernels: vec![kernel],
            precisions: vec![Precision::F64],
        };
        let c = emit::c::source(&file);
        assert_eq!(recount(c.split_once("{\n").unwrap().1, dofs), operations, "{name} in C");
    }
}

#[test]
fn the_same_program_makes_the_same_text() {
    for target in [Target::C, Target::Rust] {
        assert_eq!(emit::emit(&file(), target), emit::emit(&file(), target));
    }
}

#[test]
fn schedules_read_like_this() {
    for (name, program) in [("spring", programs::spring()), ("rows", programs::rows())] {
        let text = schedule(&program, Style::default(), &Meanings::default()).to_string();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/backend/{name}.schedule"));
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        assert_eq!(text, std::fs::read_to_string(path).unwrap(), "{name}: UPDATE=1 accepts the new text");
    }
}
