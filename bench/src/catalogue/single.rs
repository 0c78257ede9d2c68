//! Far from the origin, in double and in single precision.

use super::{Verdict, time, watch};
use crate::scenes::{Chain, ROD, box_inertia, c10, critical_damping};
use forcec_constraints::joints::point_to_point_f32;
use forcec_runtime::nalgebra::Vector3;
use forcec_runtime::{Motion, RigidF32, World};

pub(super) fn double_far(quick: bool) -> Verdict {
    let gap =
        |origin| watch(&mut Chain { origin, ..Chain::default() }.scene(), time(quick), |_| 1.0 / 120.0).gap;
    let (near, far) = (gap([0.0; 3]), gap([1e6, -1e6, 1e6]));
    let change = (far / near - 1.0).abs();
    Verdict { passes: change <= 0.01, text: format!("gap {near:.4e} → {far:.4e} m") }
}

/// The largest gap of the base chain in single precision, m.
fn single_gap(origin: [f64; 3], stiffness: f64, h: f64, time: f64) -> f64 {
    let mut world = World::<f32>::default();
    world.gravity = Vector3::new(0.0, 0.0, -9.81);
    let origin = Vector3::from(origin);
    let mut last = (world.add_rigid_at(origin, RigidF32::default(), Motion::Kinematic).expect("a pin"), 0.0);
    let inertia = box_inertia(1.0, ROD);
    for k in 0..10 {
        let spin = Vector3::new(3.0, 0.0, 0.5_f32);
        let position = Vector3::new(0.25 + 0.5 * k as f32, 0.0, 0.0);
        let state = RigidF32 {
            position,
            velocity: spin.cross(&position),
            angular_velocity: spin,
            ..RigidF32::default()
        };
        let motion = Motion::Dynamic(1.0, inertia.map(|moment| moment as f32));
        let body = world.add_rigid_at(origin, state, motion).expect("a rod");
        let moving = if k == 0 { 1.0 } else { 2.0 };
        let damping = critical_damping(stiffness, moving * (1.0 + 0.0625 / inertia.z));
        let params = point_to_point_f32::Params {
            arm_a: [last.1, 0.0, 0.0],
            arm_b: [-0.25, 0.0, 0.0],
            stiffness: stiffness as f32,
            damping: damping as f32,
        };
        world.add(params, [last.0, body]).expect("a joint");
        last = (body, 0.25);
    }
    let steps = (time / h).round() as usize;
    (0..steps)
        .map(|_| world.step(h as f32).map_or(f64::NAN, |report| report.max_violation))
        .fold(0.0, |most, gap| if gap.is_nan() { gap } else { most.max(gap) })
}

pub(super) fn single_far(quick: bool) -> Verdict {
    let gap = |far: f64, stiffness| single_gap([far, -far, far], stiffness, 1.0 / 120.0, time(quick));
    let pairs = [(gap(0.0, 1e6), gap(1e3, 1e6)), (gap(0.0, 1e8), gap(1e5, 1e8))];
    let text = pairs.map(|(near, far)| format!("{near:.4e} → {far:.4e} m"));
    Verdict { passes: pairs.iter().all(|(near, far)| *far <= 1.1 * near), text: text.join(", ") }
}

pub(super) fn single_and_double(quick: bool) -> Verdict {
    let single = single_gap([0.0; 3], 1e6, 1e-3, time(quick));
    let double = watch(&mut c10(1e6), time(quick), |_| 1e-3).gap;
    let change = (single / double - 1.0).abs();
    Verdict { passes: change <= 0.03, text: format!("gap {double:.4e} m in f64, {single:.4e} m in f32") }
}
