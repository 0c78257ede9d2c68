//! The table of cases.

use super::chains::steady;
use super::{Case, chains, inputs, islands, kernels, single, spins, structures};
use crate::scenes::{Chain, ROD, box_inertia};

/// All of them, in order.
pub const CASES: [Case; 35] = [
    Case {
        number: 1, title: "ks 10^0 … 10^12 × h 10^−5 … 10^−1: **U** at every h", run: chains::sweep
    },
    Case {
        number: 2,
        title: "no damping, h = 1/60: **U**",
        run: |quick| steady(Chain { damping: 0.0, ..Chain::default() }, 1.0 / 60.0, quick),
    },
    Case {
        number: 3,
        title: "100 × critical damping, h = 1e-3: **U**",
        run: |quick| steady(Chain { damping: 100.0, ..Chain::default() }, 1e-3, quick),
    },
    Case {
        number: 4,
        title: "end mass 1e3, ks 1e7, h = 1/60: **U**",
        run: |quick| {
            let mass = |k, n| if k + 1 == n { 1e3 } else { 1.0 };
            steady(Chain { stiffness: 1e7, mass, ..Chain::default() }, 1.0 / 60.0, quick)
        },
    },
    Case { number: 5, title: "end mass 1e6, ks 1e10, h = 1/240: **U**", run: chains::heavy },
    Case {
        number: 6,
        title: "end mass 1e-6, h = 1/120: **U**",
        run: |quick| {
            let mass = |k, n| if k + 1 == n { 1e-6 } else { 1.0 };
            steady(Chain { mass, ..Chain::default() }, 1.0 / 120.0, quick)
        },
    },
    Case {
        number: 7,
        title: "masses alternate 1 and 1e4, h = 1/240: **U**",
        run: |quick| {
            let mass = |k, _| if k % 2 == 0 { 1.0 } else { 1e4 };
            steady(Chain { mass, ..Chain::default() }, 1.0 / 240.0, quick)
        },
    },
    Case {
        number: 8,
        title: "needles, inertia 1 : 1 : 1e-4, h = 1/120: **U**",
        run: |quick| {
            let moment = box_inertia(1.0, ROD).z;
            let inertia = [1e-4 * moment, moment, moment];
            steady(Chain { inertia, ..Chain::default() }, 1.0 / 120.0, quick)
        },
    },
    Case {
        number: 9,
        title: "chain of 1e4 links, h = 1e-3: **U**, solve ≤ 6 ms, linear in n within 30 %",
        run: chains::long,
    },
    Case { number: 10, title: "1e4 bodies on one hub: no fill-in, solve ≤ 6 ms", run: structures::hub },
    Case {
        number: 11,
        title: "ring of 100 bodies, redundant joints: **U**, residual ≤ 1e-8",
        run: structures::ring,
    },
    Case {
        number: 12,
        title: "20 × 20 net of joints, corners pinned, 1e4 steps: **U**",
        run: structures::net,
    },
    Case {
        number: 13,
        title: "chain stretched 1 m a joint: gap < 1 cm within 1 s, speed < 100 m/s",
        run: chains::stretched,
    },
    Case {
        number: 14,
        title: "T-handle, 20 s, frames of 1/60, RODAS4: energy 1e-3, momentum 1e-4, 7 ± 1 flips",
        run: spins::flips,
    },
    Case {
        number: 15,
        title: "asymmetric body at 1e3 rad/s, frames of 1/60, RODAS4: momentum 1e-3",
        run: spins::fast,
    },
    Case {
        number: 16,
        title: "double pendulum, no damping, 100 s, h = 1e-3: energy within 1e-3",
        run: chains::pendulum,
    },
    Case {
        number: 17,
        title: "C = x₁ − x₀ at zero length: finite force and derivatives",
        run: kernels::tie_at_zero,
    },
    Case {
        number: 18,
        title: "norm form at distances 1e-300 … 1e-8: **U**, or quarantined and reported",
        run: kernels::short,
    },
    Case { number: 19, title: "coincident bodies and anchors: **U**", run: structures::coincident },
    Case {
        number: 20,
        title: "angle at 0, 1e-12, π − 1e-12, π: derivative within 1e-6",
        run: kernels::angles,
    },
    Case {
        number: 21,
        title: "quaternion of norm 0, 1e-160: error; of norm 1.1: normalised",
        run: inputs::quaternions,
    },
    Case {
        number: 22,
        title: "NaN or infinity in state, parameter, force, h: error or quarantine; other islands bit-identical",
        run: inputs::not_finite,
    },
    Case { number: 23, title: "finite garbage, 1e300: error or quarantine", run: inputs::garbage },
    Case { number: 24, title: "1e6 m from the origin, f64: gap changes ≤ 1 %", run: single::double_far },
    Case {
        number: 25,
        title: "f32 at 1e3 m, and at 1e5 m with ks 1e8: gap ≤ 1.1 × that at the origin",
        run: single::single_far,
    },
    Case { number: 26, title: "f32 against f64, h = 1e-3: gap within 3 %", run: single::single_and_double },
    Case { number: 27, title: "h = 0: identity; h < 0: error", run: inputs::steps },
    Case { number: 28, title: "h alternates 1/60 and 1e-5: **U**", run: chains::uneven },
    Case { number: 29, title: "inertia with a zero entry: rejected", run: inputs::flat },
    Case {
        number: 30,
        title: "torque of 1e6 N·m for one step: recovers in ≤ 10 halvings",
        run: chains::kick,
    },
    Case {
        number: 31,
        title: "500 bodies cut at 50, seeds 1 … 20: gap ≤ 3 × uncut; same seed, same bits",
        run: islands::cuts,
    },
    Case { number: 32, title: "1, 2, 8 threads: the same bits", run: islands::threads },
    Case {
        number: 33,
        title: "1e4 sleep and wake cycles: energy within 1e-6 J; asleep < 2 % of awake",
        run: islands::sleepers,
    },
    Case {
        number: 34,
        title: "box on a plane, stack of 10 with the top 100 × heavier, penalty contact: ≤ 1 cm for 60 s",
        run: structures::boxes,
    },
    Case {
        number: 35,
        title: "a derivative's sign flipped: the check fails and names the entry",
        run: kernels::flipped,
    },
];
