//! Every kernel as C: the code compiles without a warning, and results equal the mathematics of the source.
//! Each force file becomes one program that reads states and writes outputs; the oracle evaluates the source in 320-bit
//! arithmetic and differentiates it by difference quotients.

use forcec::internals::emit;
use forcec::internals::kernel::{Precision, Target};
use forcec_tests::cases::{Miss, Reference, STATES, compare, judge};
use forcec_tests::{ForceFile, driver, folder, library, parallel, run, special, unseen};
use std::time::Instant;

const STRICT: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2"];
const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

/// The errors of each kernel of a file, in both precisions.
fn measure(file: &ForceFile, folder: &std::path::Path) -> Vec<(Precision, Miss)> {
    let printable = file.printable(&PRECISIONS);
    for generated in emit::emit(&printable, Target::C) {
        std::fs::write(folder.join(generated.name), generated.text).unwrap();
    }
    std::fs::write(folder.join("driver.c"), driver::c(&printable, STATES)).unwrap();
    let source = format!("{}.c", printable.name());
    run(folder, "cc", &[&STRICT[..], &["-c", &source, "-o", "kernels.o"]].concat());
    run(folder, "cc", &["-std=c99", "-O1", "driver.c", "kernels.o", "-lm", "-o", "driver"]);
    compare(file, &folder.join("driver"), &PRECISIONS, Reference::Source)
}

#[test]
fn kernels_equal_their_mathematics() {
    let base = env!("CARGO_TARGET_TMPDIR");
    let files: Vec<(String, ForceFile)> =
        [("library", library()), ("unseen", unseen()), ("special", special())]
            .into_iter()
            .flat_map(|(kind, files)| {
                files.into_iter().map(move |file| (format!("c_{kind}_{}", file.stem), file))
            })
            .collect();
    let found: Vec<(Precision, Miss)> = parallel(files, |(name, file)| {
        let start = Instant::now();
        let found = measure(&file, &folder(base, &name));
        eprintln!("{name}: {:.1} s", start.elapsed().as_secs_f64());
        found
    })
    .into_iter()
    .flatten()
    .collect();
    judge(&found);
}
