//! A free body that turns over, or turns fast.

use super::{Seen, Verdict, watch};
use crate::scenes::t_handle;
use forcec_runtime::prelude::{Rigid, Vec3};

/// A free body with moments 1, 2, 3, stepped by `Rodas4` a frame at a time: observations of the run, the
/// change of angular momentum, and the number of times the middle axis turned over.
fn tumble(spin: Vec3, time: f64) -> (Seen, f64, usize) {
    let mut scene = t_handle();
    let body = scene.bodies[0];
    let state = Rigid { angular_velocity: spin, ..Rigid::default() };
    scene.world.set_rigid(body, state).expect("a state");
    let moments = Vec3::new(1.0, 2.0, 3.0);
    let momentum = |state: &Rigid| {
        let own = state.orientation.inverse() * state.angular_velocity;
        state.orientation * own.component_mul(&moments)
    };
    let start = momentum(&state);
    let (mut change, mut flips, mut up) = (0.0_f64, 0, true);
    let mut whole = Seen { finite: true, ..Seen::default() };
    let before = scene.world.energy();
    for _ in 0..(time * 60.0).round() as usize {
        let seen = watch(&mut scene, 1.0 / 60.0, |_| 1.0 / 60.0);
        whole.steps += 1;
        whole.accepted += seen.accepted;
        whole.rejected += seen.rejected;
        whole.quarantined += seen.quarantined;
        whole.finite &= seen.finite;
        whole.growth = whole.growth.max((scene.world.energy() / before - 1.0).abs());
        let state = scene.world.rigid(body).expect("the body");
        change = change.max((momentum(&state) - start).norm() / start.norm());
        let now = (state.orientation * Vec3::y()).y > 0.0;
        flips += usize::from(now != up);
        up = now;
    }
    (whole, change, flips)
}

pub(super) fn flips(_: bool) -> Verdict {
    let (seen, momentum, flips) = tumble(Vec3::new(0.01, 10.0, 0.0), 20.0);
    let frames = seen.steps as f64;
    Verdict {
        passes: seen.growth <= 1e-3 && momentum <= 1e-4 && (6..=8).contains(&flips),
        text: format!(
            "energy {:.1e}, momentum {momentum:.1e}, {flips} flips, {:.1} steps a frame",
            seen.growth,
            seen.accepted as f64 / frames
        ),
    }
}

pub(super) fn fast(_: bool) -> Verdict {
    let (seen, momentum, _) = tumble(Vec3::new(600.0, 600.0, 529.0), 1.0);
    Verdict {
        passes: seen.finite && seen.quarantined == 0 && momentum <= 1e-3,
        text: format!(
            "momentum {momentum:.1e}, {:.0} steps a frame",
            seen.accepted as f64 / seen.steps as f64
        ),
    }
}
