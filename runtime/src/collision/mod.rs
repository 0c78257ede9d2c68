//! Contact between the rigid bodies of a world.
//!
//! Before each step of a world, [`Collisions::update`] finds the shapes that touch, and updates the
//! [`point_contact`](contact::point_contact()) forces between their bodies:
//!
//! ```
//! use forcec_runtime::collision::parry::shape::SharedShape;
//! use forcec_runtime::collision::{Collisions, Surface, motion};
//! use forcec_runtime::prelude::*;
//! use forcec_runtime::{Motion, World};
//!
//! let (mut world, mut collisions) = (World::default(), Collisions::default());
//! world.gravity = Vec3::z() * -9.81;
//! let ground = world.add_rigid(Rigid::default(), Motion::Kinematic)?;
//! collisions.add(ground, SharedShape::halfspace([0.0, 0.0, 1.0].into()), Surface::default());
//!
//! let cube = SharedShape::cuboid(0.5, 0.5, 0.5);
//! let state = Rigid { position: Vec3::z() * 0.6, ..Rigid::default() };
//! let body = world.add_rigid(state, motion(&cube, 1000.0))?;
//! collisions.add(body, cube, Surface::default());
//!
//! for _ in 0..100 {
//!     collisions.update(&mut world, 1.0 / 60.0)?;
//!     world.step(1.0 / 60.0)?;
//! }
//! assert!((world.rigid(body)?.position.z - 0.5).abs() < 1e-3);
//! # Ok::<(), forcec_runtime::Error>(())
//! ```
//!
//! Pairs come from a tree of bounding boxes, contact points from [`parry`]. Two shapes at rest, that is
//! fixed, asleep or quarantined, form no pair. A body that touches a sleeping island wakes it. Results are
//! deterministic.
//!
//! The step size determines the stiffness of a contact: implicit methods are stable, and a penetration
//! vanishes within a few steps, without bouncing.

pub mod contact;
mod narrow;

use crate::island::Activity;
use crate::state::{Body, Motion};
use crate::world::{Force, Place, World};
use crate::{Error, Rigid};
use contact::point_contact;
use narrow::Pair;
use parry::bounding_volume::BoundingVolume;
use parry::math::{Pose, Vector};
use parry::partitioning::{Bvh, BvhWorkspace};
use parry::shape::SharedShape;
pub use parry3d_f64 as parry;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// The contact properties of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Surface {
    /// The coefficient of friction μ; a contact uses the geometric mean of both.
    pub friction: f64,
    /// The stiffness per contact point, N/m, in series with the other surface's; `None` uses [`Settings`].
    pub stiffness: Option<f64>,
    /// The damping per contact point, N·s/m, in series with the other surface's; `None` uses [`Settings`].
    pub damping: Option<f64>,
}

impl Default for Surface {
    fn default() -> Surface {
        Surface { friction: 0.5, stiffness: None, damping: None }
    }
}

/// The parameters of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// The stiffness of a contact point in units of effective mass / step²: at rest under its own weight a
    /// body penetrates by gravity · step² / hardness, under a load by proportionally more. Values above ten
    /// may need several steps per impact.
    pub hardness: f64,
    /// Damping / stiffness in units of the step: a penetration vanishes within a few times this many steps.
    pub relaxation: f64,
    /// The speed, m/s, below which friction is reduced: bodies at rest on a slope creep.
    pub slip_speed: f64,
    /// The gap, m, below which contact forces exist before touching.
    pub margin: f64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { hardness: 10.0, relaxation: 1.0, slip_speed: 1e-3, margin: 5e-3 }
    }
}

/// The results and times of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Pairs of shapes whose boxes overlap, except pairs at rest.
    pub pairs: usize,
    /// Contact points with a force.
    pub points: usize,
    /// Added and removed forces.
    pub changes: usize,
    /// The deepest penetration, m.
    pub depth: f64,
    /// The time for finding pairs.
    pub broad: Duration,
    /// The time for finding contact points.
    pub narrow: Duration,
    /// The time for changing the forces of the world.
    pub forces: Duration,
}

/// A handle of a shape on a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Collider {
    index: usize,
    generation: u32,
}

/// A shape, with the last known state of its body.
struct Solid {
    body: Body,
    shape: SharedShape,
    /// The pose of the shape in body space.
    offset: Pose,
    surface: Surface,
    motion: Motion<f64>,
    state: Rigid,
    pose: Pose,
    /// The distance that rotation may move the shape within the next steps, m; NaN before the first update.
    turning: f64,
    /// Whether the body is at rest: fixed, asleep or quarantined.
    rests: bool,
    quarantined: bool,
}

/// The shapes of a world's bodies, and the contacts between them.
#[derive(Default)]
pub struct Collisions {
    /// How contacts are made.
    pub settings: Settings,
    solids: Vec<Option<Solid>>,
    generations: Vec<u32>,
    free: Vec<usize>,
    excluded: BTreeSet<(Body, Body)>,
    tree: Bvh,
    space: BvhWorkspace,
    pairs: BTreeMap<(usize, usize), Pair>,
    /// The pairs of this update.
    met: Vec<(usize, usize)>,
}

impl Collisions {
    /// Attaches a shape to a rigid body, with the shape's origin at the centre of mass. Half-spaces and
    /// height fields require kinematic bodies. Several shapes of one body do not collide with each other.
    pub fn add(&mut self, body: Body, shape: SharedShape, surface: Surface) -> Collider {
        self.add_at(body, Pose::identity(), shape, surface)
    }

    /// Attaches a shape to a rigid body at a pose in body space.
    pub fn add_at(&mut self, body: Body, offset: Pose, shape: SharedShape, surface: Surface) -> Collider {
        let solid = Solid {
            body,
            shape,
            offset,
            surface,
            motion: Motion::Kinematic,
            state: Rigid::default(),
            pose: Pose::identity(),
            turning: f64::NAN,
            rests: false,
            quarantined: false,
        };
        let index = self.free.pop().unwrap_or_else(|| {
            self.solids.push(None);
            self.generations.push(0);
            self.solids.len() - 1
        });
        self.solids[index] = Some(solid);
        Collider { index, generation: self.generations[index] }
    }

    /// Removes a shape. The shapes of a removed body disappear at the next update.
    pub fn remove(&mut self, world: &mut World, collider: Collider) -> Result<(), Error> {
        if self.generations.get(collider.index) != Some(&collider.generation) {
            return Err(Error::UnknownHandle);
        }
        self.take_out(world, collider.index);
        Ok(())
    }

    /// Disables contacts between two bodies, for example bodies connected by a joint.
    pub fn exclude(&mut self, a: Body, b: Body) {
        self.excluded.insert((a.min(b), a.max(b)));
    }

    /// Enables contacts between two bodies again.
    pub fn include(&mut self, a: Body, b: Body) {
        self.excluded.remove(&(a.min(b), a.max(b)));
    }

    /// Finds contacts and updates the forces of the world: persisting contacts get new parameters, others are
    /// added or removed. `h` is the next step of the world, s.
    ///
    /// Returns an error if two shapes have no contact algorithm.
    pub fn update(&mut self, world: &mut World, h: f64) -> Result<Contacts, Error> {
        if !h.is_finite() {
            return Err(Error::NotFinite("step"));
        }
        if h <= 0.0 {
            return if h < 0.0 { Err(Error::NegativeStep) } else { Ok(Contacts::default()) };
        }
        let mut contacts = Contacts::default();
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed();
        self.broad(world, h);
        contacts.broad = lap();
        self.narrow(h, world.gravity.norm())?;
        contacts.narrow = lap();
        self.apply(world, &mut contacts)?;
        contacts.forces = lap();
        Ok(contacts)
    }

    /// Updates the poses of the shapes, and finds shapes with overlapping boxes.
    fn broad(&mut self, world: &mut World, h: f64) {
        let ahead = narrow::AHEAD * h;
        for index in 0..self.solids.len() {
            let Some(solid) = &mut self.solids[index] else { continue };
            let Ok(moved) = solid.follow(world) else {
                self.take_out(world, index);
                continue;
            };
            if !moved {
                continue;
            }
            let mut bounds = solid.shape.compute_aabb(&solid.pose);
            let spin = solid.state.angular_velocity.norm();
            let arm = if spin > 0.0 {
                bounds.half_extents().length() + solid.offset.translation.length()
            } else {
                0.0
            };
            solid.turning = spin * arm * ahead;
            let way = vector(&(solid.state.velocity * ahead));
            bounds.mins = bounds.mins.min(bounds.mins + way);
            bounds.maxs = bounds.maxs.max(bounds.maxs + way);
            let bounds = bounds.loosened(self.settings.margin + solid.turning);
            self.tree.insert_or_update_partially(bounds, index as u32, 0.0);
        }
        self.tree.refit(&mut self.space);
        self.tree.optimize_incremental(&mut self.space);
        let Collisions { solids, excluded, tree, space, met, .. } = self;
        met.clear();
        tree.traverse_bvtt_single_tree::<false>(space, &mut |a, b| {
            let (a, b) = (a.min(b) as usize, a.max(b) as usize);
            let (Some(one), Some(other)) = (&solids[a], &solids[b]) else { return };
            let (first, second) = (one.body.min(other.body), one.body.max(other.body));
            let apart = first == second
                || (one.rests && other.rests)
                || (one.is_fixed() && other.is_fixed())
                || one.quarantined
                || other.quarantined
                || excluded.contains(&(first, second));
            if !apart {
                met.push((a, b));
            }
        });
        met.sort_unstable();
    }

    /// Finds the contact points of all pairs.
    fn narrow(&mut self, h: f64, gravity: f64) -> Result<(), Error> {
        for pair in self.pairs.values_mut() {
            pair.met = false;
        }
        for &key in &self.met {
            self.pairs.entry(key).or_default().met = true;
        }
        let Collisions { solids, settings, pairs, .. } = self;
        let find = |(&(a, b), pair): (&(usize, usize), &mut Pair)| match (&solids[a], &solids[b]) {
            (Some(a), Some(b)) if pair.met => pair.find(a, b, h, gravity, settings),
            _ => Ok(()),
        };
        #[cfg(feature = "rayon")]
        {
            use rayon::prelude::{IntoParallelRefMutIterator, ParallelIterator};
            pairs.par_iter_mut().try_for_each(find)
        }
        #[cfg(not(feature = "rayon"))]
        pairs.iter_mut().try_for_each(find)
    }

    /// Updates the forces of the world to the contact points.
    fn apply(&mut self, world: &mut World, contacts: &mut Contacts) -> Result<(), Error> {
        let Collisions { solids, pairs, .. } = self;
        let mut failed = None;
        pairs.retain(|&(a, b), pair| {
            let (Some(a), Some(b)) = (&solids[a], &solids[b]) else { return false };
            if !pair.met {
                // The contact stays while both bodies are at rest.
                let stays = a.rests && b.rests;
                if !stays {
                    contacts.changes += pair.forces.len();
                    pair.let_go(world);
                }
                return stays;
            }
            contacts.pairs += 1;
            contacts.points += pair.points.len();
            contacts.depth = contacts.depth.max(pair.depth);
            match pair.apply(world, [a.body, b.body]) {
                Ok(changes) => contacts.changes += changes,
                Err(error) => failed = failed.or(Some(error)),
            }
            true
        });
        failed.map_or(Ok(()), Err)
    }

    /// Removes a shape and its contacts.
    fn take_out(&mut self, world: &mut World, index: usize) {
        self.solids[index] = None;
        self.generations[index] += 1;
        self.free.push(index);
        self.tree.remove(index as u32);
        self.pairs.retain(|&(a, b), pair| {
            let stays = a != index && b != index;
            if !stays {
                pair.let_go(world);
            }
            stays
        });
    }
}

impl Solid {
    /// Updates the state of the body; returns whether it changed.
    fn follow(&mut self, world: &World) -> Result<bool, Error> {
        let state = world.rigid(self.body)?;
        let known = !self.turning.is_nan();
        let still = known && state == self.state;
        (self.rests, self.quarantined) = match world.place(self.body)? {
            Place::Frame(_) => {
                let halted = state.velocity == state.angular_velocity && state.velocity.norm_squared() == 0.0;
                (still && halted, false)
            }
            Place::Island(island, index) => {
                let island = &world.islands[island];
                self.motion = island.store.members[self.body.kind as usize][index].motion;
                (island.activity != Activity::Awake, island.activity == Activity::Quarantined)
            }
        };
        if !still {
            self.state = state;
            let q = state.orientation.coords;
            let rotation = parry::math::Rotation::from_xyzw(q.x, q.y, q.z, q.w);
            self.pose = Pose::from_parts(vector(&state.position), rotation) * self.offset;
        }
        Ok(!still)
    }

    fn is_fixed(&self) -> bool {
        self.motion == Motion::Kinematic
    }
}

impl Pair {
    /// Adds and changes forces; returns the number of added forces.
    fn apply(&mut self, world: &mut World, bodies: [Body; 2]) -> Result<usize, Error> {
        if self.points.is_empty() {
            return Ok(self.let_go(world));
        }
        // Forces without a contact point are kept idle, for later points.
        let idle =
            self.points.last().map(|point| point_contact::Params { stiffness: 0.0, damping: 0.0, ..*point });
        for (at, &force) in self.forces.iter().enumerate() {
            if let Some(params) = self.points.get(at).copied().or(idle) {
                tune(world, force, params)?;
            }
        }
        let before = self.forces.len();
        for &point in self.points.iter().skip(before) {
            self.forces.push(world.add(point, bodies)?);
        }
        Ok(self.forces.len() - before)
    }

    /// Removes all forces; returns their number, without those removed with a body.
    fn let_go(&mut self, world: &mut World) -> usize {
        let gone = self.forces.drain(..).filter(|&force| world.remove_force(force).is_ok());
        gone.count()
    }
}

/// Changes the parameters of a contact without waking bodies.
fn tune(world: &mut World, force: Force, params: point_contact::Params) -> Result<(), Error> {
    let (island, batch, at) = world.force_place(force)?;
    let batch = world.islands[island].batches[batch].as_any_mut();
    let batch = batch.downcast_mut::<crate::system::batch::Forces<point_contact::Output>>();
    batch.ok_or(Error::UnknownHandle)?.params[at] = params;
    Ok(())
}

/// Mass and inertia of a body with this shape and density, kg/m³. The shape's centre of mass must be its
/// origin, and its principal axes the coordinate axes, as for boxes, balls and capsules.
pub fn motion(shape: &SharedShape, density: f64) -> Motion<f64> {
    let properties = shape.mass_properties(density);
    let moments = properties.principal_inertia();
    Motion::Dynamic(properties.mass(), nalgebra::Vector3::new(moments.x, moments.y, moments.z))
}

fn vector(v: &nalgebra::Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}
