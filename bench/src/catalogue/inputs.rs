//! Values that a world must refuse or survive: not finite, without length, or garbage.

use super::{Verdict, hash};
use crate::scenes::{ROD, Scene, box_inertia, c10};
use forcec_constraints::joints::point_to_point;
use forcec_runtime::nalgebra::Quaternion;
use forcec_runtime::prelude::{Quat, Rigid, Vec3};
use forcec_runtime::{Error, Motion, Report, World};

pub(super) fn quaternions(_: bool) -> Verdict {
    let mut world = World::<f64>::default();
    let mut add = |w: f64| {
        let orientation = Quat::new_unchecked(Quaternion::new(w, 0.0, 0.0, 0.0));
        world.add_rigid(Rigid { orientation, ..Rigid::default() }, Motion::Kinematic)
    };
    let refused = add(0.0) == Err(Error::NoOrientation) && add(1e-160) == Err(Error::NoOrientation);
    let body = add(1.1);
    let norm = body.and_then(|body| world.rigid(body)).map_or(f64::NAN, |state| state.orientation.norm());
    Verdict { passes: refused && (norm - 1.0).abs() < 1e-15, text: format!("refused {refused}, norm {norm}") }
}

pub(super) fn steps(_: bool) -> Verdict {
    let mut scene = c10(1e6);
    let before = hash(&scene);
    let zero = scene.world.step(0.0).is_ok() && hash(&scene) == before;
    let negative = scene.world.step(-1e-3) == Err(Error::NegativeStep) && hash(&scene) == before;
    Verdict { passes: zero && negative, text: format!("identity {zero}, error {negative}") }
}

pub(super) fn flat(_: bool) -> Verdict {
    let motion = Motion::Dynamic(1.0, Vec3::new(1.0, 0.0, 1.0));
    let refused = World::<f64>::default().add_rigid(Rigid::default(), motion);
    Verdict { passes: refused == Err(Error::NotPositive), text: format!("{refused:?}") }
}

/// Two chains apart from each other in one world, and how many bodies the first has.
fn two_chains() -> (Scene, usize) {
    let mut scene = c10(1e6);
    let count = scene.bodies.len();
    let end = Vec3::x() * ROD[0];
    let mut last = (scene.pin(Vec3::y() * 5.0), Vec3::zeros());
    for k in 0..count {
        let position = Vec3::new(0.25 + 0.5 * k as f64, 5.0, 0.0);
        let body = scene.rigid(Rigid { position, ..Rigid::default() }, 1.0, box_inertia(1.0, ROD), ROD);
        scene.joint([last.0, body], [last.1, -end], 1e6, 700.0);
        last = (body, end);
    }
    (scene, count)
}

pub(super) fn not_finite(_: bool) -> Verdict {
    let mut good = two_chains().0;
    let (mut bad, count) = two_chains();
    let victim = bad.bodies[count];
    let mut state = bad.world.rigid(victim).expect("a body");
    state.velocity.x = f64::NAN;
    let states = bad.world.set_rigid(victim, state).is_err();
    state.velocity.x = f64::INFINITY;
    let states = states && bad.world.set_rigid(victim, state).is_err();
    let params = |arm: f64, stiffness: f64| point_to_point::Params {
        arm_a: [arm; 3],
        arm_b: [0.0; 3],
        stiffness,
        damping: 1.0,
    };
    let ends = [bad.bodies[count], bad.bodies[count + 1]];
    let parameters = bad.world.add(params(0.0, f64::NAN), ends).is_err()
        && bad.world.add(params(0.0, f64::INFINITY), ends).is_err();
    let steps = bad.world.step(f64::NAN).is_err() && bad.world.step(f64::INFINITY).is_err();
    // A force that overflows.
    bad.world.add(params(1e200, 1e200), ends).expect("finite parameters");
    let mut quarantined = 0;
    for k in 0..60 {
        good.advance(k as f64 / 60.0, 1.0 / 60.0);
        quarantined = bad.advance(k as f64 / 60.0, 1.0 / 60.0).quarantined;
    }
    let same = good.positions()[..count] == bad.positions()[..count];
    let stopped = bad.world.is_quarantined(victim) == Ok(true);
    Verdict {
        passes: states && parameters && steps && quarantined == 1 && stopped && same,
        text: format!(
            "state refused {states}, parameter {parameters}, h {steps}; force: {quarantined} quarantined, the other island the same bits: {same}"
        ),
    }
}

pub(super) fn garbage(_: bool) -> Verdict {
    let mut ends = Vec::new();
    for what in ["position", "velocity", "spin", "stiffness"] {
        let mut scene = c10(1e6);
        let body = scene.bodies[4];
        let mut state = scene.world.rigid(body).expect("a body");
        let mut refused = false;
        match what {
            "position" => state.position.x = 1e300,
            "velocity" => state.velocity.x = 1e300,
            "spin" => state.angular_velocity.x = 1e300,
            _ => {
                let params = point_to_point::Params {
                    arm_a: [1.0; 3],
                    arm_b: [0.0; 3],
                    stiffness: 1e300,
                    damping: 1e300,
                };
                refused |= scene.world.add(params, [scene.bodies[3], body]).is_err();
            }
        }
        refused |= scene.world.set_rigid(body, state).is_err();
        let report = scene.world.step(1.0 / 60.0);
        let quarantined = report.as_ref().is_ok_and(|report: &Report| report.quarantined == 1);
        let finite = scene.positions().iter().all(|x| x.iter().all(|x| x.is_finite()));
        ends.push((what, refused || quarantined || report.is_err(), finite));
    }
    let text = ends.iter().map(|(what, caught, finite)| format!("{what}: caught {caught}, finite {finite}"));
    Verdict {
        passes: ends.iter().all(|(_, caught, finite)| *caught && *finite),
        text: text.collect::<Vec<_>>().join("; "),
    }
}
