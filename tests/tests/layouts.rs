//! Every layout, for one instance and for several, prepared or not, as C and as Rust: compilers and linters
//! find nothing, and results equal the program in 320 bits. Kernels for several instances get a number of
//! states that does not fill the last call; the unused lanes are NaN, and must not affect other lanes.

use forcec::internals::compile::{Request, Stages};
use forcec::internals::emit;
use forcec::internals::kernel::{Precision, Target};
use forcec::{Mode, Plan};
use forcec_tests::cases::{Miss, Reference, STATES, compare, judge};
use forcec_tests::{ForceFile, driver, folder, laid_out, lint, parallel, requested, run};
use std::path::Path;

const STRICT: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2"];

fn measure(file: &ForceFile, precisions: &[Precision], folder: &Path) -> Vec<(Precision, Miss)> {
    let printable = file.printable(precisions);
    let name = printable.name();
    for target in Target::ALL {
        for generated in emit::emit(&printable, target) {
            std::fs::write(folder.join(generated.name), generated.text).unwrap();
        }
    }
    std::fs::write(folder.join("driver.c"), driver::c(&printable, STATES)).unwrap();
    run(folder, "cc", &[&STRICT[..], &["-c", &format!("{name}.c"), "-o", "kernels.o"]].concat());
    run(folder, "cc", &["-std=c99", "-O1", "driver.c", "kernels.o", "-lm", "-o", "driver_c"]);
    let mut found = compare(file, &folder.join("driver_c"), precisions, Reference::Source);
    lint(folder, &name);
    std::fs::write(folder.join("driver.rs"), driver::rust(&printable, STATES)).unwrap();
    run(folder, "rustc", &["--edition", "2024", "-C", "opt-level=0", "-A", "warnings", "driver.rs"]);
    found.extend(compare(file, &folder.join("driver"), precisions, Reference::Program));
    found
}

#[test]
fn layouts_equal_their_mathematics() {
    let base = env!("CARGO_TARGET_TMPDIR");
    let found = parallel(laid_out(), |(file, precisions): (ForceFile, &[Precision])| {
        let name = file.printable(precisions).name();
        measure(&file, precisions, &folder(base, &format!("layout_{name}")))
    });
    judge(&found.into_iter().flatten().collect::<Vec<(Precision, Miss)>>());
}

/// Preparation stores only values that save work, and a kernel with no value that depends on parameters alone
/// says so.
#[test]
fn what_is_prepared_saves_operations() {
    let (mut prepared, mut plain) = (0, 0);
    for request in [Mode::Balanced, Mode::Strict].map(|mode| Plan { mode, ..Plan::default() }) {
        let request = Request { prepare: true, ..Request::from(request) };
        for stages in ["springs", "solids", "cloth"].map(|stem| requested(stem, request.clone())) {
            for Stages { kernel, .. } in stages.compiled.functions {
                let Some(once) = kernel.once() else {
                    assert!(kernel.summary().iter().any(|line| line.contains("nothing to prepare")));
                    plain += 1;
                    continue;
                };
                let (whole, every) = (once.whole.total(), kernel.schedule.operations().total());
                assert!(
                    whole - every >= once.values(),
                    "{}: {} values, {whole} to {every}",
                    kernel.name,
                    once.values()
                );
                prepared += 1;
            }
        }
    }
    assert!(prepared > 20 && plain > 0, "{prepared} prepared, {plain} not");
}
