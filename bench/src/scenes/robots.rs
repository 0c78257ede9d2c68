//! Articulated robots.

use super::{GRAVITY, Scene, critical_damping};
use forcec_constraints::contacts::point_plane_friction;
use forcec_runtime::Wrench;
use forcec_runtime::prelude::{Rigid, Vec3};

/// A body of a robot.
#[derive(Clone, Copy, Debug)]
struct Link {
    parent: Option<usize>,
    mass: f64,
    inertia: [f64; 3],
    centre: Vec3,
    joint: Vec3,
}

/// The robot `ben`, a row a body.
fn ben() -> Vec<Link> {
    let text = include_str!("../../scenes/ben.csv");
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit() || c == '-'));
    let link = |row: &str| {
        let numbers: Vec<f64> = row.split(',').map(|x| x.parse().expect("a number")).collect();
        let at = |k: usize| [numbers[k], numbers[k + 1], numbers[k + 2]];
        let parent = (numbers[0] >= 0.0).then_some(numbers[0] as usize);
        Link { parent, mass: numbers[1], inertia: at(2), centre: at(5).into(), joint: at(8).into() }
    };
    rows.map(link).collect()
}

impl Link {
    /// Half the sides of the box that has these moments, m.
    fn half(&self) -> [f64; 3] {
        let [x, y, z] = self.inertia.map(|moment| 1.5 * moment / self.mass);
        [y + z - x, x + z - y, x + y - z].map(|square| square.max(1e-4).sqrt())
    }
}

/// 25 robots 3 m apart, head pinned, hanging; driven by torques, or turning about the pin as one rigid piece.
/// Joints of infinite stiffness are rigid.
pub fn ben25(stiffness: f64, driven: bool) -> Scene {
    robots(25, stiffness, driven)
}

/// Some robots, as in [`ben25`].
pub fn robots(count: usize, stiffness: f64, driven: bool) -> Scene {
    let links = ben();
    let mut scene = Scene::new(if driven { 1.0 } else { 10.0 }, 1.0 / 60.0);
    let spin = if driven { Vec3::zeros() } else { Vec3::new(2.0, 1.0, 0.0) };
    for robot in 0..count {
        let at = Vec3::new(3.0 * (robot % 5) as f64, 3.0 * (robot / 5) as f64, 0.0);
        let pin = scene.pin(at);
        let first = scene.bodies.len();
        for link in &links {
            let state = Rigid {
                position: at + link.centre,
                velocity: spin.cross(&link.centre),
                angular_velocity: spin,
                ..Rigid::default()
            };
            let body = scene.rigid(state, link.mass, link.inertia.into(), link.half());
            let arm_b = link.joint - link.centre;
            let mut mobility = 1.0 / link.mass + arm_b.norm_squared() / link.inertia[0];
            let (other, arm_a) = match link.parent {
                Some(parent) => {
                    let other = links[parent];
                    let arm = link.joint - other.centre;
                    mobility += 1.0 / other.mass + arm.norm_squared() / other.inertia[0];
                    (scene.bodies[first + parent], arm)
                }
                None => (pin, link.joint),
            };
            let damping = critical_damping(stiffness, mobility);
            scene.joint([other, body], [arm_a, arm_b], stiffness, damping);
        }
    }
    if driven {
        let bodies = scene.bodies.clone();
        scene.drive = Some(Box::new(move |world, time| {
            for robot in bodies.chunks_exact(links.len()) {
                let mut torques = vec![Vec3::zeros(); links.len()];
                for (k, link) in links.iter().enumerate() {
                    let Some(parent) = link.parent else { continue };
                    let turn = std::f64::consts::TAU * (0.5 + 0.05 * k as f64) * time + k as f64;
                    let axis = if k % 2 == 0 { Vec3::x() } else { Vec3::y() };
                    let torque = axis * (0.3 * link.mass * GRAVITY * 0.15 * turn.sin());
                    torques[k] += torque;
                    torques[parent] -= torque;
                }
                for (&body, torque) in robot.iter().zip(torques) {
                    let load = Wrench { force: Vec3::zeros(), torque };
                    world.set_load(body, load).expect("a body of the robot");
                }
            }
        }));
    }
    scene
}

/// Robots with rigid joints and without pins that fall onto ground of this stiffness per point, N/m.
///
/// Points are the corners of the bodies' boxes. Ground damps, and has friction.
pub fn fallen(count: usize, stiffness: f64) -> Scene {
    let links = ben();
    let mut scene = Scene::new(5.0, 1.0 / 60.0);
    for robot in 0..count {
        let at = Vec3::new(3.0 * (robot % 5) as f64, 3.0 * (robot / 5) as f64, 2.1);
        // Each falls in another way.
        let spin = Vec3::new(0.3, 0.2, 0.1) + Vec3::new(0.5, -0.3, 0.4) * robot as f64;
        let first = scene.bodies.len();
        for link in &links {
            let velocity = spin.cross(&link.centre);
            let position = at + link.centre;
            let state = Rigid { position, velocity, angular_velocity: spin, ..Rigid::default() };
            let half = link.half();
            let body = scene.rigid(state, link.mass, link.inertia.into(), half);
            if let Some(parent) = link.parent {
                let arms = [link.joint - links[parent].centre, link.joint - link.centre];
                scene.joint([scene.bodies[first + parent], body], arms, f64::INFINITY, 0.0);
            }
            for corner in 0..8 {
                let side = |axis: usize| if corner >> axis & 1 == 0 { -half[axis] } else { half[axis] };
                let params = point_plane_friction::Params {
                    arm: [side(0), side(1), side(2)],
                    origin: [0.0; 3],
                    normal: [0.0, 0.0, 1.0],
                    stiffness,
                    damping: 300.0,
                    friction: 0.8,
                    slip_speed: 0.05,
                };
                scene.world.add(params, [body]).expect("a point of a body");
            }
        }
    }
    scene
}
