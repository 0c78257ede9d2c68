//! The benchmark of kernels runs, and everybody computes the same. No time is judged.

use forcec_bench::kernels::{BY_HAND, FLAGS, Plan, measure};
use std::path::Path;

#[test]
fn kernels_by_hand_and_emitted_ones_are_right() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("kernels");
    let plan = Plan {
        only: BY_HAND.map(str::to_owned).to_vec(),
        rounds: 3,
        flags: FLAGS.split(' ').map(str::to_owned).collect(),
        peers: Vec::new(),
    };
    let rows = measure(&plan, &folder);
    for kernel in BY_HAND {
        for maker in ["hand", "C", "Rust"] {
            let row = rows.iter().find(|row| row.kernel == kernel && row.maker.name == maker);
            let row = row.unwrap_or_else(|| panic!("{kernel} by {maker}"));
            assert!(row.error <= 1e-12, "{kernel} by {maker}: {:e}", row.error);
            assert!(row.time.is_some_and(|time| time.least > 0.0) && row.ratio.is_some(), "{row:?}");
        }
    }
}
