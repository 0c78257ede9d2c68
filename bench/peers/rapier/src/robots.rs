// One text for both precisions: the module that includes it says which Rapier `rapier` is.

use super::{End, GRAVITY, Link, PATIENCE, SIDE, Setting};
use rapier::{Real, Vector};

fn vector(v: [f64; 3]) -> Vector {
    Vector::new(v[0] as Real, v[1] as Real, v[2] as Real)
}

/// Steps 25 robots for one second if driven, for ten if they turn freely.
pub(super) fn run(links: &[Link], setting: Setting, driven: bool, h: f64) -> Option<End> {
    let spin = if driven { Vector::ZERO } else { Vector::new(2.0, 1.0, 0.0) };
    let mut bodies = rapier::RigidBodySet::new();
    let (mut impulse, mut multibody) = (rapier::ImpulseJointSet::new(), rapier::MultibodyJointSet::new());
    let mut robots = Vec::new();
    for robot in 0..SIDE * SIDE {
        let at = vector([3.0 * (robot % SIDE) as f64, 3.0 * (robot / SIDE) as f64, 0.0]);
        let pin = bodies.insert(rapier::RigidBodyBuilder::fixed().translation(at));
        let mut handles: Vec<rapier::RigidBodyHandle> = Vec::new();
        for link in links {
            let centre = vector(link.centre);
            let mass = rapier::MassProperties::new(Vector::ZERO, link.mass as Real, vector(link.inertia));
            let body = rapier::RigidBodyBuilder::dynamic()
                .translation(at + centre)
                .linvel(spin.cross(centre))
                .angvel(spin)
                .additional_mass_properties(mass)
                .can_sleep(false);
            let body = bodies.insert(body);
            let (other, from) = link.parent.map_or((pin, Vector::ZERO), |parent| (handles[parent], vector(links[parent].centre)));
            let joint = rapier::SphericalJointBuilder::new()
                .local_anchor1(vector(link.joint) - from)
                .local_anchor2(vector(link.joint) - centre)
                .build();
            if setting.multibody {
                multibody.insert(other, body, joint, true);
            } else {
                impulse.insert(other, body, joint, true);
            }
            handles.push(body);
        }
        robots.push(handles);
    }

    let start = energy(&bodies, &robots, links);
    let gravity = vector([0.0, 0.0, -GRAVITY]);
    let mut parameters = rapier::IntegrationParameters {
        num_solver_iterations: setting.iterations,
        ..Default::default()
    };
    let mut pipeline = rapier::PhysicsPipeline::new();
    let (mut islands, mut broad, mut narrow) =
        (rapier::IslandManager::new(), rapier::BroadPhaseBvh::new(), rapier::NarrowPhase::new());
    let (mut colliders, mut soft, mut continuous) =
        (rapier::ColliderSet::new(), rapier::SoftBodySet::new(), rapier::CCDSolver::new());
    let mut step = |bodies: &mut rapier::RigidBodySet, multibody: &mut rapier::MultibodyJointSet, dt: f64| {
        parameters.dt = dt as Real;
        pipeline.step(
            gravity,
            &parameters,
            &mut islands,
            &mut broad,
            &mut narrow,
            bodies,
            &mut colliders,
            &mut impulse,
            multibody,
            &mut soft,
            &mut continuous,
            &(),
            &(),
        );
    };

    if setting.multibody {
        // A multibody learns in a step that its root is fixed; its first three velocities are then those of the pin's joint.
        step(&mut bodies, &mut multibody, 1e-7);
        for robot in &robots {
            let index = multibody.rigid_body_link(robot[0])?.multibody;
            let mut velocities = multibody.get_multibody_mut(index)?.generalized_velocity_mut();
            velocities.fill(0.0);
            (velocities[0], velocities[1], velocities[2]) = (spin.x, spin.y, spin.z);
        }
    }
    let mut end = End { time: 0.0, positions: Vec::new(), drift: 0.0 };
    let steps = (if driven { 1.0 } else { 10.0 } / h).round() as usize;
    for k in 0..steps {
        let clock = cpu_time::ThreadTime::now();
        if driven {
            drive(&mut bodies, &robots, links, (k as f64 + 0.5) * h);
        }
        step(&mut bodies, &mut multibody, h);
        end.time += clock.elapsed().as_secs_f64();
        if !driven {
            end.drift = end.drift.max((energy(&bodies, &robots, links) - start).abs());
        }
        if k == steps / 50 && end.time * steps as f64 > PATIENCE * (k + 1) as f64 {
            return None;
        }
    }
    end.positions = robots[0].iter().map(|&body| bodies[body].translation()).map(|p| [p.x as f64, p.y as f64, p.z as f64]).collect();
    Some(end)
}

fn drive(bodies: &mut rapier::RigidBodySet, robots: &[Vec<rapier::RigidBodyHandle>], links: &[Link], time: f64) {
    let mut torques = vec![Vector::ZERO; links.len()];
    for (k, link) in links.iter().enumerate() {
        let Some(parent) = link.parent else { continue };
        let (size, axis) = super::torque(k, link, time);
        let torque = if axis == 0 { Vector::X } else { Vector::Y } * size as Real;
        torques[k] += torque;
        torques[parent] -= torque;
    }
    for robot in robots {
        for (&body, torque) in robot.iter().zip(&torques) {
            let body = &mut bodies[body];
            body.reset_torques(true);
            body.add_torque(*torque, true);
        }
    }
}

/// The energy of one of them, on average, J.
fn energy(bodies: &rapier::RigidBodySet, robots: &[Vec<rapier::RigidBodyHandle>], links: &[Link]) -> f64 {
    let each = robots.iter().flat_map(|robot| robot.iter().zip(links)).map(|(&body, link)| {
        let body = &bodies[body];
        let spin = body.rotation().inverse() * body.angvel();
        let turning = spin.x as f64 * spin.x as f64 * link.inertia[0]
            + spin.y as f64 * spin.y as f64 * link.inertia[1]
            + spin.z as f64 * spin.z as f64 * link.inertia[2];
        let moving = link.mass * body.linvel().length_squared() as f64;
        0.5 * (moving + turning) + link.mass * GRAVITY * body.translation().z as f64
    });
    each.sum::<f64>() / robots.len() as f64
}
