//! Computes the contacts between two shapes.
//!
//! In: two solids with overlapping boxes. Out: the parameters of a [`point_contact`] for each point where the
//! solids touch or soon will. Round shapes are a core with a radius, so rolling does not change their gap.

use crate::collision::contact::point_contact;
use crate::collision::{Settings, Solid, Surface};
use crate::error::Error;
use crate::state::Motion;
use crate::world::Force;
use nalgebra::Vector3;
use parry3d_f64::query::details::ContactManifoldsWorkspace;
use parry3d_f64::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d_f64::shape::SharedShape;

/// The number of steps for which contacts are predicted.
pub(super) const AHEAD: f64 = 2.0;

/// The contacts between two shapes.
#[derive(Default)]
pub(super) struct Pair {
    /// Each point stores its sliding speed of the last update.
    manifolds: Vec<ContactManifold<(), Option<f64>>>,
    workspace: Option<ContactManifoldsWorkspace>,
    /// Whether the boxes overlap in this update.
    pub(super) met: bool,
    pub(super) points: Vec<point_contact::Params>,
    /// The deepest penetration, m.
    pub(super) depth: f64,
    /// At least as many forces as points, after `apply`.
    pub(super) forces: Vec<Force>,
}

impl Pair {
    /// Finds the points where two solids touch or will touch within the next steps.
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
        // A sleeping body wakes at touch only.
        let (reach, margin) = if a.rests || b.rests { (h, 0.0) } else { (ahead, settings.margin) };
        let radii = [radius(&a.shape), radius(&b.shape)];
        for manifold in &mut self.manifolds {
            // The pose of a part in a compound shape.
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
                // The damper resists only separation that the spring or gravity can cause in a step; faster
                // separation ends the contact.
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
                    // Extrapolated to the middle of the step, limited to half and double the present speed.
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

    /// The acceleration at a point along a direction, per unit force along that direction.
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

/// The radius around the core of a round shape; zero for other shapes.
fn radius(shape: &SharedShape) -> f64 {
    match shape.as_ball() {
        Some(ball) => ball.radius,
        None => shape.as_polygonal_feature_map().map_or(0.0, |(_, radius)| radius),
    }
}

/// The stiffness or damping of two surfaces in series.
fn series(a: &Surface, b: &Surface, part: impl Fn(&Surface) -> Option<f64>) -> Option<f64> {
    match (part(a), part(b)) {
        (Some(a), Some(b)) => Some(a * b / (a + b)),
        (one, other) => one.or(other),
    }
}
