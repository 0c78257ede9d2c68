//! Every library kernel as Rust: rustc and clippy give no warning, rustfmt changes nothing, and results equal the
//! program in 320 bits.

use forcec::internals::emit;
use forcec::internals::kernel::{Precision, Target};
use forcec_tests::cases::{Miss, Reference, STATES, compare, judge};
use forcec_tests::{ForceFile, driver, folder, library, lint, parallel, run, special};
use std::path::Path;

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

fn measure(file: &ForceFile, folder: &Path) -> Vec<(Precision, Miss)> {
    let printable = file.printable(&PRECISIONS);
    let generated = emit::emit(&printable, Target::Rust);
    let [generated] = generated.as_slice() else { panic!("Rust is one file") };
    std::fs::write(folder.join(&generated.name), &generated.text).unwrap();
    lint(folder, &printable.name());
    std::fs::write(folder.join("driver.rs"), driver::rust(&printable, STATES)).unwrap();
    run(folder, "rustc", &["--edition", "2024", "-C", "opt-level=1", "-A", "warnings", "driver.rs"]);
    compare(file, &folder.join("driver"), &PRECISIONS, Reference::Program)
}

#[test]
fn kernels_are_clean_and_equal_their_program() {
    let base = env!("CARGO_TARGET_TMPDIR");
    let files = library().into_iter().map(|file| ("library", file));
    let files: Vec<(&str, ForceFile)> =
        files.chain(special().into_iter().map(|file| ("special", file))).collect();
    let found =
        parallel(files, |(kind, file)| measure(&file, &folder(base, &format!("rust_{kind}_{}", file.stem))));
    let found: Vec<(Precision, Miss)> = found.into_iter().flatten().collect();
    judge(&found);
}
