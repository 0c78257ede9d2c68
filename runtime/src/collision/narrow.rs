//! From two shapes to the parameters of their contacts.
//!
//! In go two solids whose boxes meet; out come the points where they touch or soon will, each as the parameters of a
//! [`point_contact`]. Round shapes are taken as a core with a radius around it, so that rolling keeps their gap.

use super::contact::point_contact;
use super::{Settings, Solid, Surface};
use crate::error::Error;
use crate::world::{Force, Motion};
use nalgebra::Vector3;
use parry3d_f64::query::details::ContactManifoldsWorkspace;
use parry3d_f64::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d_f64::shape::SharedShape;

/// How many steps ahead contacts are looked for.
pub(super) const AHEAD: f64 = 2.0;

/// Two shapes that meet.
#[derive(Default)]
pub(super) struct Pair {
    /// Each point remembers how fast it slid in the last update.
    manifolds: Vec<ContactManifold<(), Option<f64>>>,
    workspace: Option<ContactManifoldsWorkspace>,
    /// Their boxes met in this update.
    pub(super) met: bool,
    pub(super) points: Vec<point_contact::Params>,
    /// The deepest penetration, m.
    pub(super) depth: f64,
    /// At least as many as points, once these are applied.
    pub(super) forces: Vec<Force>,
}

impl Pair {
    /// Finds the points where two solids touch, or will within the next steps.
    pub(super) fn find(
        &mut self,
        a: &Solid,
        b: &Solid,
        h: f64,
        gravity: f64,
        settings: &Settings,
    ) -> Result<(), Error> {
        let ahead = AHEAD * h;
        let closing = (b.state.velocity - a.state.velocity).norm();
        let prediction = settings.margin + closing * ahead + a.turning + b.turning;
        DefaultQueryDispatcher
            .contact_manifolds(
                &a.pose.inv_mul(&b.pose),
                a.shape.as_ref(),
                b.shape.as_ref(),
                prediction,
                &mut self.manifolds,
                &mut self.workspace,
            )
            .map_err(|_| Error::NoContact)?;
        self.points.clear();
        self.depth = 0.0;
        // A sleeper is not woken before it is touched.
        let (reach, margin) = if a.rests || b.rests { (h, 0.0) } else { (ahead, settings.margin) };
        let radii = [radius(&a.shape), radius(&b.shape)];
        for manifold in &mut self.manifolds {
            // A part of a shape of several has a place in it.
            let places = [manifold.subshape_pos1(), manifold.subshape_pos2()];
            let [at_a, at_b] = [
                a.pose * places[0].copied().unwrap_or_default(),
                b.pose * places[1].copied().unwrap_or_default(),
            ];
            let normal = at_a.rotation * manifold.local_n1;
            for point in &mut manifold.points {
                let touch =
                    [at_a * point.local_p1 - normal * radii[0], at_b * point.local_p2 + normal * radii[1]];
                let normal = Vector3::new(normal.x, normal.y, normal.z);
                let [arm_a, arm_b] = [(a, touch[0]), (b, touch[1])]
                    .map(|(solid, p)| Vector3::new(p.x, p.y, p.z) - solid.state.position);
                let between = b.state.position - a.state.position;
                let gap = normal.dot(&(between + arm_b - arm_a)) - radii[0] - radii[1];
                let rb = arm_b - normal * radii[1];
                let ra = between + rb;
                let velocity = b.velocity_at(&rb) - a.velocity_at(&ra);
                let rate = normal.dot(&velocity);
                let sliding = (velocity - normal * rate).norm();
                let last = point.data.replace(sliding).unwrap_or(sliding);
                if gap + reach * rate.min(0.0) >= margin {
                    continue;
                }
                let mass = (a.mobility(&ra, &normal) + b.mobility(&rb, &normal)).recip();
                let stiffness = mass * settings.hardness / (h * h);
                let stiffness = series(&a.surface, &b.surface, |it| it.stiffness).unwrap_or(stiffness);
                // The damper holds what the spring may have pushed in a step, or gravity takes back; what is faster leaves.
                if mass * rate > (mass * gravity - stiffness * gap.min(0.0)) * h {
                    continue;
                }
                self.depth = self.depth.max(-gap);
                let damping = stiffness * settings.relaxation * h;
                self.points.push(point_contact::Params {
                    arm_a: a.state.orientation.inverse_transform_vector(&arm_a).into(),
                    arm_b: b.state.orientation.inverse_transform_vector(&arm_b).into(),
                    normal: normal.into(),
                    radius_a: radii[0],
                    radius_b: radii[1],
                    stiffness,
                    damping: series(&a.surface, &b.surface, |it| it.damping).unwrap_or(damping),
                    friction: (a.surface.friction * b.surface.friction).sqrt(),
                    // In the middle of the step, as much faster or slower as in the last, but not at once at rest.
                    speed: (1.5 * sliding - 0.5 * last)
                        .clamp(0.5 * sliding, 2.0 * sliding)
                        .max(settings.slip_speed),
                });
            }
        }
        Ok(())
    }
}

impl Solid {
    fn velocity_at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.state.velocity + self.state.angular_velocity.cross(arm)
    }

    /// How much a unit of force along a direction accelerates the point at an arm.
    fn mobility(&self, arm: &Vector3<f64>, direction: &Vector3<f64>) -> f64 {
        match self.motion {
            Motion::Kinematic => 0.0,
            Motion::Dynamic(mass, moments) => {
                let turn = self.state.orientation.inverse_transform_vector(&arm.cross(direction));
                mass.recip() + turn.dot(&turn.component_div(&moments))
            }
        }
    }
}

/// What lies around the core of a shape.
fn radius(shape: &SharedShape) -> f64 {
    match shape.as_ball() {
        Some(ball) => ball.radius,
        None => shape.as_polygonal_feature_map().map_or(0.0, |(_, radius)| radius),
    }
}

/// What two springs, or two dampers, give in series.
fn series(a: &Surface, b: &Surface, part: impl Fn(&Surface) -> Option<f64>) -> Option<f64> {
    match (part(a), part(b)) {
        (Some(a), Some(b)) => Some(a * b / (a + b)),
        (one, other) => one.or(other),
    }
}
