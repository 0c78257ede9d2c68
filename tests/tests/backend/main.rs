//! The back end: printed code compiles without a warning, computes the values of the program, and states its
//! operation counts correctly.

mod programs;
mod prose;

use forcec::internals::emit;
use forcec::internals::kernel::{File, Kernel, Precision, Target};
use forcec::internals::model::bodies::{Signature, Slot};
use forcec::internals::scalar::eval::{self, Outputs};
use forcec::internals::scalar::{Operations, Program};
use forcec::internals::schedule::meanings::Meanings;
use forcec::internals::schedule::{Style, schedule};
use forcec_tests::{driver, folder, lint, pipe, run};
use std::path::Path;

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

fn write(folder: &Path, target: Target) {
    for generated in emit::emit(&file(), target) {
        std::fs::write(folder.join(generated.name), generated.text).unwrap();
    }
}

/// The entries of a kernel's arguments, in memory order.
fn inputs(signature: &Signature) -> Vec<f64> {
    let mut slots: Vec<Slot> = Vec::new();
    for (argument, body) in (0..).zip(&signature.bodies) {
        for (field, row) in (0..).zip(body.kind.row().fields) {
            slots.extend((0..row.length).map(|offset| Slot { argument, field, offset }));
        }
    }
    for (index, parameter) in signature.parameters.iter().enumerate() {
        let offsets = 0..parameter.ty.length() as u32;
        slots.extend(offsets.map(|offset| signature.parameter_slot(index, offset)));
    }
    slots.into_iter().map(|slot| programs::input(signature, slot)).collect()
}

/// Runs a driver and compares its outputs, kernel by kernel in both precisions, with the schedules.
fn compare(driver: &Path) {
    let inputs =
        kernels().iter().flat_map(|(_, program)| inputs(&program.signature).repeat(2)).collect::<Vec<f64>>();
    let mut found = pipe(driver, &inputs).into_iter();
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
                let got = found.next().unwrap();
                let close = got == *expected
                    || (got - expected).abs() <= tolerance * expected.abs().max(1e-3)
                    || got.is_nan() && expected.is_nan();
                assert!(close, "{name}_{precision}, output {i}: {got} is not {expected}");
            }
        }
    }
    assert_eq!(found.next(), None);
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
    let folder = folder(env!("CARGO_TARGET_TMPDIR"), "backend_c");
    write(&folder, Target::C);
    std::fs::write(folder.join("driver.c"), driver::c(&file(), 1)).unwrap();
    run(&folder, "gcc", &[&STRICT[..], &["-O1", "-c", "made.c"]].concat());
    run(&folder, "gcc", &["-std=c99", "driver.c", "made.o", "-lm", "-o", "driver"]);
    std::fs::write(folder.join("both.cpp"), "#include \"made.h\"\nint main() { return 0; }\n").unwrap();
    run(
        &folder,
        "g++",
        &["-Wall", "-Wextra", "-Wpedantic", "-Werror", "both.cpp", "made.o", "-lm", "-o", "both"],
    );
    compare(&folder.join("driver"));
}

#[test]
fn rust_compiles_without_a_warning_and_computes_the_same() {
    let folder = folder(env!("CARGO_TARGET_TMPDIR"), "backend_rust");
    write(&folder, Target::Rust);
    lint(&folder, "made");
    std::fs::write(folder.join("driver.rs"), driver::rust(&file(), 1)).unwrap();
    run(&folder, "rustc", &["--edition", "2024", "-A", "warnings", "driver.rs"]);
    compare(&folder.join("driver"));
}

/// Counts operators and calls in the bodies of emitted functions, with loop bodies weighted by the number of
/// iterations, independently of the code generator.
fn recount(text: &str, freedoms: usize) -> Operations {
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
            times = freedoms;
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
        let freedoms = kernel.schedule.signature.dofs();
        let rust = emit::rust::kernel_module(&kernel, Precision::F32);
        let start = rust.find("pub fn evaluate").unwrap();
        assert_eq!(
            recount(rust[start..].split_once("{\n").unwrap().1, freedoms),
            operations,
            "{name} in Rust"
        );
        let file = File {
            stem: name.clone(),
            docs: vec![],
            kernels: vec![kernel],
            precisions: vec![Precision::F64],
        };
        let c = emit::c::source(&file);
        assert_eq!(recount(c.split_once("{\n").unwrap().1, freedoms), operations, "{name} in C");
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
        if std::env::var_os("FORCEC_BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        assert_eq!(
            text,
            std::fs::read_to_string(path).unwrap(),
            "{name}: FORCEC_BLESS=1 accepts the new text"
        );
    }
}
