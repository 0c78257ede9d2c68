//! Every layout, for one instance and for several, as C and as Rust: compilers and linters find nothing, and what is computed
//! is what the program means in 320 bits. What computes several at once is given a number of states that does not fill
//! the last call; the lanes that are left over are not numbers, and no other lane may notice.

use forcec::kernel::{Precision, Target};
use forcec::targets;
use forcec_tests::cases::{Miss, Reference, STATES, compare, judge};
use forcec_tests::{ForceFile, driver, folder, laid_out, lint, parallel, run};
use std::path::Path;

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];
const STRICT: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2"];

fn measure(file: &ForceFile, folder: &Path) -> Vec<(Precision, Miss)> {
    let printable = file.printable(&PRECISIONS);
    let name = printable.name();
    for target in Target::ALL {
        for generated in targets::emit(&printable, target) {
            std::fs::write(folder.join(generated.name), generated.text).unwrap();
        }
    }
    std::fs::write(folder.join("driver.c"), driver::c(&printable, STATES)).unwrap();
    run(folder, "cc", &[&STRICT[..], &["-c", &format!("{name}.c"), "-o", "kernels.o"]].concat());
    run(folder, "cc", &["-std=c99", "-O1", "driver.c", "kernels.o", "-lm", "-o", "driver_c"]);
    let mut found = compare(file, &folder.join("driver_c"), &PRECISIONS, Reference::Source);
    lint(folder, &name);
    std::fs::write(folder.join("driver.rs"), driver::rust(&printable, STATES)).unwrap();
    run(folder, "rustc", &["--edition", "2024", "-C", "opt-level=1", "-A", "warnings", "driver.rs"]);
    found.extend(compare(file, &folder.join("driver"), &PRECISIONS, Reference::Program));
    found
}

#[test]
fn layouts_equal_their_mathematics() {
    let base = env!("CARGO_TARGET_TMPDIR");
    let found = parallel(laid_out(), |file: ForceFile| {
        let name = file.printable(&PRECISIONS).name();
        measure(&file, &folder(base, &format!("layout_{name}")))
    });
    judge(&found.into_iter().flatten().collect::<Vec<(Precision, Miss)>>());
}
