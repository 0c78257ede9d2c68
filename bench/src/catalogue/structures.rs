//! Bodies joined in other ways: a hub, a ring, a net, all bodies in one place, a stack.

use super::{Verdict, stable, time, watch};
use crate::scenes::{self, Scene, stack};
use forcec_constraints::joints::distance;
use forcec_runtime::Body;
use forcec_runtime::prelude::{Rigid, Vec3};

pub(super) fn hub(_: bool) -> Verdict {
    let mut scene = Scene::new(0.1, 1e-3);
    let pin = scene.pin(Vec3::zeros());
    let hub = scene.rigid(Rigid::default(), 100.0, Vec3::repeat(10.0), [0.5; 3]);
    scene.joint([pin, hub], [Vec3::zeros(); 2], 1e8, 2e3);
    for k in 0..10_000 {
        let turn = 0.01 * k as f64;
        let arm = Vec3::new(turn.cos(), turn.sin(), 1e-4 * k as f64);
        let spoke =
            scene.rigid(Rigid { position: arm, ..Rigid::default() }, 1.0, Vec3::repeat(0.1), [0.1; 3]);
        scene.joint([hub, spoke], [arm, Vec3::zeros()], 1e6, 2e3);
    }
    let seen = watch(&mut scene, 0.05, |_| 1e-3);
    let each = seen.solve.as_secs_f64() * 1e3 / (2 * (seen.accepted + seen.rejected)).max(1) as f64;
    Verdict {
        passes: seen.finite && seen.quarantined == 0 && each <= 6.0 && seen.residual <= 1e-8,
        text: format!("{each:.2} ms a solve, residual {:.0e}, {seen}", seen.residual),
    }
}

pub(super) fn ring(quick: bool) -> Verdict {
    let make = || scenes::ring(100, 1e6);
    let verdict = stable(&make, time(quick), 1.0 / 120.0);
    let residual = watch(&mut make(), 0.5, |_| 1.0 / 120.0).residual;
    Verdict {
        passes: verdict.passes && residual <= 1e-8,
        text: format!("{}, residual {residual:.0e}", verdict.text),
    }
}

pub(super) fn net(quick: bool) -> Verdict {
    let mut scene = Scene::new(5.0, 1.0 / 120.0);
    let side = 20;
    let grid: Vec<Body> = (0..side * side)
        .map(|k| {
            let position = Vec3::new((k % side) as f64 * 0.5, (k / side) as f64 * 0.5, 0.0);
            scene.rigid(Rigid { position, ..Rigid::default() }, 1.0, Vec3::repeat(0.02), [0.2, 0.2, 0.02])
        })
        .collect();
    let (x, y) = (Vec3::x() * 0.25, Vec3::y() * 0.25);
    for k in 0..side * side {
        if k % side + 1 < side {
            scene.joint([grid[k], grid[k + 1]], [x, -x], 1e6, 500.0);
        }
        if k + side < side * side {
            scene.joint([grid[k], grid[k + side]], [y, -y], 1e6, 500.0);
        }
    }
    for corner in [0, side - 1, side * (side - 1), side * side - 1] {
        let position = scene.world.position(grid[corner]).expect("a corner");
        let pin = scene.pin(position);
        scene.joint([pin, grid[corner]], [Vec3::zeros(); 2], 1e6, 500.0);
    }
    let steps = if quick { 100.0 } else { 1e4 };
    let seen = watch(&mut scene, steps / 120.0, |_| 1.0 / 120.0);
    Verdict { passes: seen.is_stable(), text: format!("{seen}, {} steps", seen.steps) }
}

pub(super) fn coincident(quick: bool) -> Verdict {
    let make = || {
        let mut scene = Scene::new(1.0, 1.0 / 120.0);
        let pin = scene.pin(Vec3::zeros());
        let mut last = pin;
        for _ in 0..5 {
            let body = scene.rigid(Rigid::default(), 1.0, Vec3::repeat(0.1), [0.1; 3]);
            scene.joint([last, body], [Vec3::zeros(); 2], 1e6, 500.0);
            scene.joint([pin, body], [Vec3::zeros(); 2], 1e6, 500.0);
            last = body;
        }
        scene
    };
    let joints = stable(&make, time(quick), 1.0 / 120.0);
    // A rod of length 1 with coincident anchors has no direction, which leads to quarantine.
    let mut scene = Scene::new(1.0, 1.0 / 120.0);
    let pin = scene.pin(Vec3::zeros());
    let body = scene.rigid(Rigid::default(), 1.0, Vec3::repeat(0.1), [0.1; 3]);
    let params = distance::Params {
        arm_a: [0.0; 3],
        arm_b: [0.0; 3],
        rest_length: 1.0,
        stiffness: 1e6,
        damping: 100.0,
    };
    scene.world.add(params, [pin, body]).expect("a rod");
    let rod = watch(&mut scene, 0.1, |_| 1.0 / 120.0);
    Verdict {
        passes: joints.passes && rod.finite && (rod.quarantined > 0 || rod.is_stable()),
        text: format!(
            "joints: {}; a rod without direction: {}",
            joints.text,
            if rod.quarantined > 0 { "quarantined" } else { "moves" }
        ),
    }
}

/// The deepest that a stack of cubes sinks in, the top one `top` times as heavy, m.
fn depth(count: usize, top: f64, time: f64) -> f64 {
    let mut scene = stack(count, top);
    let h = scene.step;
    let depths = (0..(time / h).round() as usize).map(|k| {
        scene.advance(k as f64 * h, h);
        scene.contacts.depth
    });
    depths.fold(0.0, f64::max)
}

pub(super) fn boxes(quick: bool) -> Verdict {
    let time = if quick { 2.0 } else { 60.0 };
    let (one, ten) = (depth(1, 1.0, time), depth(10, 100.0, time));
    Verdict {
        passes: one.max(ten) <= 0.01,
        text: format!("at 1/240 s the box sinks in by {one:.1e} m, the stack by {ten:.1e} m"),
    }
}
