//! The scenes of the simulation benchmarks: bodies, joints, what drives them and how they look.

mod chain;
mod mechanisms;
mod piles;
mod robots;
mod soft;

pub use chain::{Chain, ROD, c10, t_handle};
pub use mechanisms::{ANDREWS_TORQUE, andrews, bricard, four_bars, pendulum, ring};
pub use piles::{rubble, stack};
pub use robots::{ben25, fallen, robots};
pub use soft::{bar, cloth};

use forcec_constraints::joints::point_to_point;
use forcec_runtime::collision::parry::shape::SharedShape;
use forcec_runtime::collision::{Collisions, Contacts, Surface};
use forcec_runtime::prelude::{Particle, Rigid, Vec3};
use forcec_runtime::{Body, Law, Motion, Report, World};

/// Gravity, m/s².
pub const GRAVITY: f64 = 9.81;

/// A world and the data to step and draw the world.
pub struct Scene {
    /// Bodies and forces.
    pub world: World,
    /// Shapes that touch each other, where there are any.
    pub collisions: Option<Collisions>,
    /// The contacts of the last step.
    pub contacts: Contacts,
    /// Dynamic bodies, in order.
    pub bodies: Vec<Body>,
    /// Masses of these bodies, kg.
    pub masses: Vec<f64>,
    /// Data for drawing.
    pub look: Look,
    /// Update of the world for each step; the argument is the time at the middle of the step.
    pub drive: Option<Drive>,
    /// Duration, s.
    pub time: f64,
    /// Usual step, s.
    pub step: f64,
}

/// Data for drawing a scene.
#[derive(Default)]
pub struct Look {
    /// Half the sides of a rigid body's box, m, for each body that moves; empty for particles.
    pub boxes: Vec<[f64; 3]>,
    /// Triangles between particles.
    pub triangles: Vec<[Body; 3]>,
    /// Where something is pinned to the world, m.
    pub pins: Vec<Vec3>,
    /// The ground, if there is one.
    pub ground: Option<Ground>,
}

/// Ground over a square.
#[derive(Clone, Copy)]
pub struct Ground {
    /// Half its side, m, about the origin.
    pub half: f64,
    /// Its height at x and y, m.
    pub height: fn(f64, f64) -> f64,
}

/// Sets the loads of a world for a time.
pub type Drive = Box<dyn Fn(&mut World, f64)>;

impl Scene {
    /// Nothing but gravity.
    pub fn new(time: f64, step: f64) -> Scene {
        let mut world = World::default();
        world.gravity = Vec3::new(0.0, 0.0, -GRAVITY);
        Scene {
            world,
            collisions: None,
            contacts: Contacts::default(),
            bodies: Vec::new(),
            masses: Vec::new(),
            look: Look::default(),
            drive: None,
            time,
            step,
        }
    }

    /// Moves on by a step at a time.
    pub fn advance(&mut self, time: f64, h: f64) -> Report {
        if let Some(drive) = &self.drive {
            drive(&mut self.world, time + 0.5 * h);
        }
        if let Some(collisions) = &mut self.collisions {
            let contacts = collisions.update(&mut self.world, h);
            self.contacts = contacts.expect("shapes whose contacts are known");
        }
        self.world.step(h).expect("a step that is positive and finite")
    }

    /// Where its bodies are, m.
    pub fn positions(&self) -> Vec<Vec3> {
        self.bodies.iter().map(|&body| self.world.position(body).expect("a body of the scene")).collect()
    }

    /// Potential energy in gravity, zero at height zero, J.
    pub fn potential(&self) -> f64 {
        let heights = self.positions().into_iter().zip(&self.masses);
        heights.map(|(position, mass)| -mass * self.world.gravity.dot(&position)).sum()
    }

    /// Adds a rigid body with half the sides of its box, m.
    pub fn rigid(&mut self, state: Rigid, mass: f64, inertia: Vec3, half: [f64; 3]) -> Body {
        let body = self.world.add_rigid(state, Motion::Dynamic(mass, inertia)).expect("a sound body");
        self.bodies.push(body);
        self.masses.push(mass);
        self.look.boxes.push(half);
        body
    }

    /// Adds a body that stays where it is.
    pub fn pin(&mut self, position: Vec3) -> Body {
        self.look.pins.push(position);
        self.fixed(position)
    }

    /// The same, as the ground.
    fn ground(&mut self, ground: Ground) -> Body {
        self.look.ground = Some(ground);
        self.fixed(Vec3::zeros())
    }

    fn fixed(&mut self, position: Vec3) -> Body {
        let state = Rigid { position, ..Rigid::default() };
        self.world.add_rigid(state, Motion::Kinematic).expect("a sound pin")
    }

    /// Ties two bodies together by a ball joint, which is rigid if its stiffness is infinite; `arms`: its anchors
    /// in body space, m.
    pub fn joint(&mut self, bodies: [Body; 2], arms: [Vec3; 2], stiffness: f64, damping: f64) {
        let [arm_a, arm_b] = arms.map(Into::into);
        let rigid = stiffness.is_infinite();
        let law = if rigid { Law::Rigid } else { Law::Penalty };
        let [stiffness, damping] = if rigid { [0.0; 2] } else { [stiffness, damping] };
        let params = point_to_point::Params { arm_a, arm_b, stiffness, damping };
        self.world.add_constraint(law, params, bodies).expect("a joint of two bodies");
    }

    /// Gives a body a shape that others touch.
    pub fn shape(&mut self, body: Body, shape: SharedShape, surface: Surface) {
        self.collisions.get_or_insert_default().add(body, shape, surface);
    }

    fn particle(&mut self, position: Vec3, motion: Motion<f64>) -> Body {
        let state = Particle { position, ..Particle::default() };
        let body = self.world.add_particle(state, motion).expect("a sound particle");
        match motion {
            Motion::Dynamic(mass, _) => {
                self.bodies.push(body);
                self.masses.push(mass);
            }
            Motion::Kinematic => self.look.pins.push(position),
        }
        body
    }
}

/// A scene: name, description, and constructor.
pub type Row = (&'static str, &'static str, fn() -> Scene);

/// The scenes.
pub static SCENES: [Row; 14] = [
    ("c10", "ten rods end to end, pinned, turning about the pin", || c10(1e6)),
    ("ben25", "25 articulated robots, hanging, driven by torques", || ben25(1e7, true)),
    ("ben25-free", "the same, turning freely about their pins", || ben25(1e7, false)),
    ("ben25-rigid", "the 25 robots with rigid joints, driven", || ben25(f64::INFINITY, true)),
    ("fallen", "four robots with rigid joints that fall onto stiff ground", || fallen(4, 1e5)),
    ("four-bars", "40 four-bar linkages of rigid hinges", || four_bars(40)),
    ("bricard", "an over-constrained loop of six rigid hinges", bricard),
    ("squeezer", "Andrews' squeezing mechanism, driven by a motor", andrews),
    ("ring", "a ring of 100 rods with repeated rigid joints", || ring(100, f64::INFINITY)),
    ("t-handle", "a free body that spins about its middle axis", t_handle),
    ("cloth", "a cloth of 40 × 40 particles, held at two corners", || cloth(40)),
    ("bar", "a bar of 20 × 4 × 4 cells of tetrahedra, held at one end", || bar([20, 4, 4])),
    ("stack", "ten cubes on a plane, the top one 100 times as heavy", || stack(10, 100.0)),
    ("rubble", "512 boxes that fall into a bowl and come to rest", || rubble(512)),
];

/// Moments of inertia of a box with these half sides, kg·m².
pub fn box_inertia(mass: f64, half: [f64; 3]) -> Vec3 {
    let [x, y, z] = half.map(|half| half * half * mass / 3.0);
    Vec3::new(y + z, x + z, x + y)
}

/// Critical damping, N·s/m, of a joint between bodies with total inverse mass `mobility`, 1/kg.
pub fn critical_damping(stiffness: f64, mobility: f64) -> f64 {
    2.0 * (stiffness / mobility).sqrt()
}
