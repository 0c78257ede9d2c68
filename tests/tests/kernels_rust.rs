//! Every library kernel as Rust: rustc and clippy find nothing, rustfmt changes nothing, and it computes what the program
//! means in 320 bits.

use forcec::kernel::{Precision, Target};
use forcec::targets;
use forcec_tests::cases::{Miss, Reference, STATES, cases, judge, misses};
use forcec_tests::{ForceFile, driver, folder, library, parallel, pipe, run};
use std::path::Path;

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

fn measure(file: &ForceFile, folder: &Path) -> Vec<(Precision, Miss)> {
    let printable = file.printable(&PRECISIONS);
    let generated = targets::emit(&printable, Target::Rust);
    let [generated] = generated.as_slice() else { panic!("Rust is one file") };
    std::fs::write(folder.join(&generated.name), &generated.text).unwrap();
    let library = format!("#![deny(missing_docs)]\n//! A crate.\n\npub mod {};\n", file.stem);
    std::fs::write(folder.join("lib.rs"), library).unwrap();
    // Nothing above this folder may tell rustfmt or clippy what to accept.
    std::fs::write(folder.join("rustfmt.toml"), "").unwrap();
    std::fs::write(folder.join("clippy.toml"), "").unwrap();
    run(folder, "rustfmt", &["--edition", "2024", "--check", &generated.name]);
    let strict = ["--edition", "2024", "-D", "warnings", "--crate-type", "lib", "--emit", "metadata"];
    run(folder, "rustc", &[&strict[..], &[&generated.name]].concat());
    run(folder, "clippy-driver", &[&strict[..], &["-D", "clippy::all", "lib.rs"]].concat());
    std::fs::write(folder.join("driver.rs"), driver::rust(&printable, STATES)).unwrap();
    run(folder, "rustc", &["--edition", "2024", "-C", "opt-level=1", "-A", "warnings", "driver.rs"]);
    let mut input = Vec::new();
    let mut all = Vec::new();
    for function in &file.compiled.functions {
        for precision in PRECISIONS {
            let cases = cases(function, precision, Reference::Program);
            input.extend(cases.iter().flat_map(|case| case.inputs.iter().copied()));
            all.push((function, precision, cases));
        }
    }
    let output = pipe(&folder.join("driver"), &input);
    let mut output = output.as_slice();
    let mut found = Vec::new();
    for (function, precision, cases) in &all {
        for case in cases {
            let (here, rest) = output.split_at(case.expected.len());
            output = rest;
            found.extend(misses(function, *precision, case, here).into_iter().map(|miss| (*precision, miss)));
        }
    }
    assert!(output.is_empty(), "{}: the driver writes what was asked for", file.stem);
    found
}

#[test]
fn kernels_are_clean_and_equal_their_program() {
    let base = env!("CARGO_TARGET_TMPDIR");
    let found = parallel(library(), |file| measure(&file, &folder(base, &format!("rust_{}", file.stem))));
    let found: Vec<(Precision, Miss)> = found.into_iter().flatten().collect();
    judge(&found);
}
