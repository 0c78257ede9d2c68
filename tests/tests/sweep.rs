//! Any two values of any two options, on small kernels of many kinds: compilers find nothing, and results
//! equal those of the dense kernel. `sweep`, a program of this crate, tests the options on every function.

use forcec_tests::sweep::{failures, rows, subjects};

/// Graphs have no more nodes than this.
const SMALL: usize = 40;

#[test]
fn options_go_together() {
    let subjects = subjects(&["../constraints", "unseen", "cases"], &|_, nodes| nodes <= SMALL);
    let rows = rows(&subjects, false);
    let count = rows.len();
    let failures = failures(rows, env!("CARGO_TARGET_TMPDIR"));
    assert!(failures.is_empty(), "{} of {count} rows fail:\n{}", failures.len(), failures.join("\n\n"));
}
