//! Any two values of any two options, on small kernels of many kinds: compilers find nothing, and what is computed is what
//! the dense kernel computes. `sweep`, a program of this crate, tries them on every function.

use forcec_tests::sweep::{failures, rows, subjects};

/// Kernels have no more statements than this.
const SHORT: usize = 100;

#[test]
fn options_go_together() {
    let mut subjects = subjects(&["../constraints", "unseen", "cases"]);
    subjects.retain(|subject| subject.length <= SHORT);
    let rows = rows(&subjects, false);
    let count = rows.len();
    let failures = failures(rows, env!("CARGO_TARGET_TMPDIR"));
    assert!(failures.is_empty(), "{} of {count} rows fail:\n{}", failures.len(), failures.join("\n\n"));
}
