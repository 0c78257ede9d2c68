//! The benchmark of kernels runs, and everybody computes the same. No time is judged.

use forcec_bench::kernels::{BY_HAND, FLAGS, Maker, Plan, measure};
use std::path::Path;

#[test]
fn kernels_by_hand_agree_with_emitted_ones() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("kernels");
    let plan = Plan {
        only: BY_HAND.map(str::to_owned).to_vec(),
        rounds: 3,
        flags: FLAGS.split(' ').map(str::to_owned).collect(),
    };
    let rows = measure(&plan, &folder);
    for kernel in BY_HAND {
        for maker in [Maker::Hand, Maker::C, Maker::Rust] {
            let row = rows.iter().find(|row| row.kernel == kernel && row.maker == maker);
            let row = row.unwrap_or_else(|| panic!("{kernel} by {}", maker.name()));
            assert!(row.deviation <= 1e-12, "{kernel} by {}: {:e}", maker.name(), row.deviation);
            assert!(row.time.least > 0.0 && row.ratio.is_some(), "{row:?}");
        }
    }
}
