//! Worlds of bodies and forces.
//!
//! A world takes bodies with mass and inertia, and forces with their parameters, and returns handles, which
//! stay valid when other bodies or forces are removed. A world divides bodies into islands, which are stepped
//! independently: see [`Settings`] for the method and [`Report`] for the results.

mod groups;
mod law;
mod partition;
#[cfg(feature = "serde")]
pub(crate) mod save;
mod worlds;

pub use law::Law;
pub use worlds::Worlds;

use crate::error::Error;
use crate::island::control::StepRequest;
use crate::island::{Activity, Island};
use crate::kernel::{BodyKind, Kernel, Parameters};
use crate::outside::LoadAt;
use crate::report::Report;
use crate::settings::Settings;
use crate::state::{Body, Member, Motion, as_f64, as_particle, as_rigid, moved};
use crate::system::assemble::Fallback;
use crate::system::batch::Forces;
use crate::world::groups::Groups;
use crate::{Particle, Rigid, Wrench};
use nalgebra::{RealField, Vector3, Vector6, convert};

/// A handle of a force in a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Force {
    entry: usize,
    generation: u32,
}

/// An entry in a table of handles.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Entry<P> {
    pub(crate) generation: u32,
    /// `None` after removal.
    pub(crate) place: Option<P>,
}

/// The location of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Place {
    /// The island, and the index among its bodies of the same type.
    Island(usize, usize),
    /// The index among the kinematic bodies.
    Frame(usize),
}

/// A kinematic body.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Frame<R: RealField> {
    pub(crate) entry: usize,
    pub(crate) origin: Vector3<f64>,
    pub(crate) state: Rigid<R>,
}

/// Bodies, forces, and the storage for steps.
pub struct World<R: RealField + Copy = f64> {
    /// The acceleration of all dynamic bodies, m/s².
    pub gravity: Vector3<R>,
    /// The method and parameters of steps.
    pub settings: Settings<R>,
    pub(crate) islands: Vec<Island<R>>,
    pub(crate) frames: Vec<Frame<R>>,
    pub(crate) bodies: Vec<Entry<Place>>,
    /// For each force its island, its batch in the island, and its index in the batch.
    pub(crate) forces: Vec<Entry<(usize, usize, usize)>>,
    /// Free entries.
    pub(crate) free_bodies: Vec<usize>,
    pub(crate) free_forces: Vec<usize>,
    /// The indices of awake islands, in order.
    pub(crate) awake: Vec<usize>,
    /// The indices of moving kinematic bodies, in order.
    pub(crate) moving_frames: Vec<usize>,
    /// The numbers of sleeping and of quarantined islands.
    pub(crate) resting: [usize; 2],
    /// Whether the lists of awake islands and moving kinematic bodies must be updated.
    pub(crate) dirty: bool,
    pub(crate) groups: Groups<R>,
    /// Counts structures of islands.
    pub(crate) structures: u64,
}

impl<R: RealField + Copy> Default for World<R> {
    fn default() -> World<R> {
        World {
            gravity: Vector3::zeros(),
            settings: Settings::default(),
            islands: Vec::new(),
            frames: Vec::new(),
            bodies: Vec::new(),
            forces: Vec::new(),
            free_bodies: Vec::new(),
            free_forces: Vec::new(),
            awake: Vec::new(),
            moving_frames: Vec::new(),
            resting: [0; 2],
            dirty: true,
            groups: Groups::default(),
            structures: 0,
        }
    }
}

impl<R: RealField + Copy> World<R> {
    /// Adds a rigid body; normalises its orientation.
    pub fn add_rigid(&mut self, state: Rigid<R>, motion: Motion<R>) -> Result<Body, Error> {
        self.add_rigid_at(Vector3::zeros(), state, motion)
    }

    /// Adds a rigid body with a position relative to an origin, m. Connected bodies share the origin of one
    /// of them, so single precision is accurate far from zero; points in space among a force's parameters are
    /// relative to this origin too.
    pub fn add_rigid_at(
        &mut self,
        origin: Vector3<f64>,
        mut state: Rigid<R>,
        motion: Motion<R>,
    ) -> Result<Body, Error> {
        check_rigid(&mut state)?;
        if let Motion::Dynamic(mass, inertia) = motion {
            check_mass(mass)?;
            inertia.iter().try_for_each(|&moment| check_mass(moment))?;
        }
        self.insert(BodyKind::Rigid, origin, state, motion)
    }

    /// Adds a particle.
    pub fn add_particle(&mut self, state: Particle<R>, motion: Motion<R>) -> Result<Body, Error> {
        self.add_particle_at(Vector3::zeros(), state, motion)
    }

    /// Adds a particle with a position relative to an origin, like [`World::add_rigid_at`].
    pub fn add_particle_at(
        &mut self,
        origin: Vector3<f64>,
        state: Particle<R>,
        motion: Motion<R>,
    ) -> Result<Body, Error> {
        check_particle(&state)?;
        if let Motion::Dynamic(mass, _) = motion {
            check_mass(mass)?;
        }
        self.insert(BodyKind::Particle, origin, as_rigid(&state), motion)
    }

    /// The state of a rigid body, with its position relative to zero; [`World::position`] is exact far away.
    pub fn rigid(&self, body: Body) -> Result<Rigid<R>, Error> {
        self.state(body, BodyKind::Rigid)
    }

    /// The state of a particle; the position is relative to zero.
    pub fn particle(&self, body: Body) -> Result<Particle<R>, Error> {
        Ok(as_particle(&self.state(body, BodyKind::Particle)?))
    }

    /// The position of a body, m.
    pub fn position(&self, body: Body) -> Result<Vector3<f64>, Error> {
        let (origin, state) = self.local(body)?;
        Ok(origin + state.position.map(as_f64))
    }

    /// Sets the state of a rigid body, and wakes its island.
    pub fn set_rigid(&mut self, body: Body, mut state: Rigid<R>) -> Result<(), Error> {
        check_rigid(&mut state)?;
        self.set_state(body, BodyKind::Rigid, state)
    }

    /// Sets the state of a particle, and wakes its island.
    pub fn set_particle(&mut self, body: Body, state: Particle<R>) -> Result<(), Error> {
        check_particle(&state)?;
        self.set_state(body, BodyKind::Particle, as_rigid(&state))
    }

    /// Sets a constant force, and a torque about the centre of mass, in the world frame, until the next call.
    pub fn set_load(&mut self, body: Body, load: Wrench<R>) -> Result<(), Error> {
        let load = checked_load(&load)?;
        if let Place::Island(island, index) = self.place(body)? {
            let island = &mut self.islands[island];
            island.store.members[body.kind as usize][index].load = load;
            self.dirty |= island.activity == Activity::Asleep;
            island.load_version += 1;
            island.wake_for_load();
        }
        Ok(())
    }

    /// Removes a body and all its forces.
    pub fn remove_body(&mut self, body: Body) -> Result<(), Error> {
        let place = self.place(body)?;
        for entry in 0..self.forces.len() {
            let Some((island, batch, at)) = self.forces[entry].place else { continue };
            let island = &self.islands[island];
            let batch = &island.batches[batch];
            let touches = |(&kind, &index): (&BodyKind, &usize)| {
                kind == body.kind && island.store.members[kind as usize][index].entry == body.entry
            };
            if batch.kinds().iter().zip(batch.indices(at)).any(touches) {
                self.remove_force(Force { entry, generation: self.forces[entry].generation })?;
            }
        }
        match place {
            Place::Frame(index) => {
                self.dirty = true;
                self.frames.swap_remove(index);
                if let Some(moved) = self.frames.get(index) {
                    self.bodies[moved.entry].place = Some(Place::Frame(index));
                }
            }
            Place::Island(number, index) => {
                let island = &mut self.islands[number];
                let last = island.store.members[body.kind as usize].len() - 1;
                island.store.remove(body.kind, index);
                for batch in &mut island.batches {
                    for at in 0..batch.entries().len() {
                        let kinds = batch.kinds();
                        for (&kind, own) in kinds.iter().zip(batch.indices_mut(at)) {
                            if kind == body.kind && *own == last {
                                *own = index;
                            }
                        }
                    }
                }
                (island.changed, island.maybe_split) = (true, true);
                island.wake();
                if let Some(moved) = island.store.members[body.kind as usize].get(index)
                    && moved.motion != Motion::Kinematic
                {
                    self.bodies[moved.entry].place = Some(Place::Island(number, index));
                }
            }
        }
        let entry = &mut self.bodies[body.entry];
        (entry.place, entry.generation) = (None, entry.generation + 1);
        self.free_bodies.push(body.entry);
        self.dirty = true;
        Ok(())
    }

    /// Adds a force with these parameters between bodies, in argument order.
    pub fn add<P, const N: usize>(&mut self, params: P, bodies: [Body; N]) -> Result<Force, Error>
    where
        P: Parameters,
        P::Kernel: Kernel<Real = R>,
    {
        self.add_kernel::<P::Kernel>(params, &bodies)
    }

    /// Adds a constraint that holds by this law. Rigid and compliant constraints, energies and other forces may
    /// act on the same bodies.
    pub fn add_constraint<P, const N: usize>(
        &mut self,
        law: Law<R>,
        params: P,
        bodies: [Body; N],
    ) -> Result<Force, Error>
    where
        P: Parameters,
        P::Kernel: Kernel<Real = R>,
    {
        self.add_by::<P::Kernel>(law, params, &bodies)
    }

    /// Adds a force of kernel `K`, also for kernels without parameters.
    pub fn add_kernel<K: Kernel<Real = R>>(
        &mut self,
        params: K::Params,
        bodies: &[Body],
    ) -> Result<Force, Error> {
        self.add_by::<K>(Law::Penalty, params, bodies)
    }

    fn add_by<K: Kernel<Real = R>>(
        &mut self,
        law: Law<R>,
        params: K::Params,
        bodies: &[Body],
    ) -> Result<Force, Error> {
        if !bodies.iter().map(|body| body.kind).eq(K::BODIES.iter().copied()) {
            return Err(Error::WrongBodies(K::NAME));
        }
        check_params::<K>(&params)?;
        let (params, rigid) = law.apply::<K>(params)?;
        let mut home = None;
        for &body in bodies {
            if let Place::Island(island, _) = self.place(body)? {
                home = Some(home.map_or(island, |home| self.join(home, island)));
            }
        }
        let home = home.ok_or(Error::NothingMoves(K::NAME))?;
        let mut indices = K::Indices::default();
        for (index, &body) in indices.as_mut().iter_mut().zip(bodies) {
            *index = match self.place(body)? {
                Place::Island(_, index) => index,
                Place::Frame(frame) => self.local_copy(home, body, frame),
            };
        }
        let entry = claim(&mut self.forces, &mut self.free_forces);
        let island = &mut self.islands[home];
        let batch = island.batch_like(&Forces::<K>::new(rigid));
        let at = island.batches[batch].entries().len();
        if let Some(forces) = island.batches[batch].as_any_mut().downcast_mut::<Forces<K>>() {
            forces.push(params, indices, entry);
        }
        self.forces[entry].place = Some((home, batch, at));
        island.changed = true;
        island.wake();
        self.dirty = true;
        Ok(Force { entry, generation: self.forces[entry].generation })
    }

    /// Changes the parameters of a force, and wakes its island.
    pub fn set_params<P>(&mut self, force: Force, params: P) -> Result<(), Error>
    where
        P: Parameters,
        P::Kernel: Kernel<Real = R>,
    {
        check_params::<P::Kernel>(&params)?;
        let (island, batch, at) = self.force_place(force)?;
        let island = &mut self.islands[island];
        let batch = island.batches[batch].as_any_mut().downcast_mut::<Forces<P::Kernel>>();
        batch.ok_or(Error::WrongBodies(P::Kernel::NAME))?.params[at] = params;
        self.dirty |= island.activity == Activity::Asleep;
        island.wake();
        Ok(())
    }

    /// Removes a force.
    pub fn remove_force(&mut self, force: Force) -> Result<(), Error> {
        let (number, batch, at) = self.force_place(force)?;
        let island = &mut self.islands[number];
        island.batches[batch].remove(at);
        if let Some(&moved) = island.batches[batch].entries().get(at) {
            self.forces[moved].place = Some((number, batch, at));
        }
        (island.changed, island.maybe_split) = (true, true);
        island.wake();
        let entry = &mut self.forces[force.entry];
        (entry.place, entry.generation) = (None, entry.generation + 1);
        self.free_forces.push(force.entry);
        self.dirty = true;
        Ok(())
    }

    /// The number of forces.
    pub fn force_count(&self) -> usize {
        self.forces.len() - self.free_forces.len()
    }

    /// Puts the island of a body to sleep: its bodies stop and keep their velocities, until a call, a change
    /// of a force or a body, or a moving kinematic body wakes the island.
    pub fn sleep(&mut self, body: Body) -> Result<(), Error> {
        if let Place::Island(island, _) = self.place(body)? {
            let activity = &mut self.islands[island].activity;
            *activity = if *activity == Activity::Awake { Activity::Asleep } else { *activity };
            self.dirty = true;
        }
        Ok(())
    }

    /// Wakes the island of a body, also from quarantine.
    pub fn wake(&mut self, body: Body) -> Result<(), Error> {
        if let Place::Island(island, _) = self.place(body)? {
            self.islands[island].wake();
            self.islands[island].activity = Activity::Awake;
            self.dirty = true;
        }
        Ok(())
    }

    /// Whether the island of a body is asleep.
    pub fn is_asleep(&self, body: Body) -> Result<bool, Error> {
        Ok(self.activity(body)? == Activity::Asleep)
    }

    /// Whether the island of a body stopped because all attempts at a step failed.
    pub fn is_quarantined(&self, body: Body) -> Result<bool, Error> {
        Ok(self.activity(body)? == Activity::Quarantined)
    }

    /// A body at a fraction `alpha`, 0 to 1, of the last step of `Rodas4`, its position relative to zero.
    /// That step ends with the last call of [`World::step`] and may begin during it. `None` for other
    /// methods.
    pub fn interpolate(&self, body: Body, alpha: R) -> Result<Option<Rigid<R>>, Error> {
        Ok(match self.place(body)? {
            Place::Frame(_) => None,
            Place::Island(island, index) => {
                let island = &self.islands[island];
                let state = island.interpolate(body.kind, index, alpha);
                state.map(|state| from_origin(island.origin, state))
            }
        })
    }

    /// The energy, J: kinetic, potential in gravity (zero at the origin), and of constraints and energies.
    pub fn energy(&self) -> f64 {
        let energy = |island: &Island<R>| island.measure(self.gravity).in_world(self.gravity, island.origin);
        self.islands.iter().map(energy).sum()
    }

    /// Advances the world by `h`, s; zero changes nothing.
    ///
    /// An island in which all attempts fail stops from then on; the report counts these islands.
    pub fn step(&mut self, h: R) -> Result<Report, Error>
    where
        R: Send + Sync,
    {
        self.advance(h, None)
    }

    /// Advances the world with loads that depend on time and state, in addition to those of
    /// [`World::set_load`]: a force and a torque about the centre of mass, in the world frame, for each dynamic
    /// body.
    ///
    /// `loads` gets the time since the beginning of the call, s, and the body in its state then. Methods call
    /// it in each stage, so that the order of the method holds. Every island is awake.
    pub fn step_with(
        &mut self,
        h: R,
        loads: impl Fn(R, Body, &Rigid<R>) -> Wrench<R> + Sync,
    ) -> Result<Report, Error>
    where
        R: Send + Sync,
    {
        for island in &mut self.islands {
            self.dirty |= island.activity == Activity::Asleep;
            island.wake_for_load();
        }
        self.advance(h, Some(&loads))
    }

    fn advance(&mut self, h: R, loads: Option<LoadAt<'_, R>>) -> Result<Report, Error>
    where
        R: Send + Sync,
    {
        World::check_step(h)?;
        let _span = crate::report::span("step");
        self.prepare();
        let mut report = Report::default();
        if h > R::zero() {
            let request = StepRequest {
                h,
                fallback: Fallback::None,
                gravity: self.gravity,
                loads,
                settings: &self.settings,
            };
            self.groups.update(&self.islands, &self.awake, &self.settings);
            self.groups.advance(&mut self.islands, &self.awake, &request, |one| report.add(one));
            for &frame in &self.moving_frames {
                let state = self.frames[frame].state;
                self.frames[frame].state = moved(&state, state.velocity * h, state.angular_velocity * h);
            }
            if self.awake.iter().any(|&number| self.islands[number].activity != Activity::Awake) {
                self.count();
            }
        }
        [report.asleep, report.quarantined] = self.resting;
        Ok(report)
    }

    fn check_step(h: R) -> Result<(), Error> {
        match h {
            h if !h.is_finite() => Err(Error::NotFinite("step")),
            h if h < R::zero() => Err(Error::NegativeStep),
            _ => Ok(()),
        }
    }

    fn insert(
        &mut self,
        kind: BodyKind,
        origin: Vector3<f64>,
        state: Rigid<R>,
        motion: Motion<R>,
    ) -> Result<Body, Error> {
        if !origin.iter().all(|x| x.is_finite()) {
            return Err(Error::NotFinite("origin"));
        }
        let entry = claim(&mut self.bodies, &mut self.free_bodies);
        let body = Body { kind, entry, generation: self.bodies[entry].generation };
        self.bodies[entry].place = Some(match motion {
            Motion::Kinematic => {
                self.frames.push(Frame { entry, origin, state });
                Place::Frame(self.frames.len() - 1)
            }
            Motion::Dynamic(..) => {
                let mut island = Island::new(origin);
                island.store.push(kind, state, Member::new(body, motion));
                self.islands.push(island);
                Place::Island(self.islands.len() - 1, 0)
            }
        });
        self.dirty = true;
        Ok(body)
    }

    pub(crate) fn place(&self, body: Body) -> Result<Place, Error> {
        let entry = self.bodies.get(body.entry).filter(|entry| entry.generation == body.generation);
        entry.and_then(|entry| entry.place).ok_or(Error::UnknownHandle)
    }

    pub(crate) fn force_place(&self, force: Force) -> Result<(usize, usize, usize), Error> {
        let entry = self.forces.get(force.entry).filter(|entry| entry.generation == force.generation);
        entry.and_then(|entry| entry.place).ok_or(Error::UnknownHandle)
    }

    fn activity(&self, body: Body) -> Result<Activity, Error> {
        Ok(match self.place(body)? {
            Place::Island(island, _) => self.islands[island].activity,
            Place::Frame(_) => Activity::Awake,
        })
    }

    /// The origin of a body's position, and its state.
    fn local(&self, body: Body) -> Result<(Vector3<f64>, Rigid<R>), Error> {
        Ok(match self.place(body)? {
            Place::Frame(frame) => (self.frames[frame].origin, self.frames[frame].state),
            Place::Island(island, index) => {
                let island = &self.islands[island];
                (island.origin, island.store.get(body.kind, index))
            }
        })
    }

    fn state(&self, body: Body, kind: BodyKind) -> Result<Rigid<R>, Error> {
        let (origin, state) = self.local(body)?;
        if body.kind == kind { Ok(from_origin(origin, state)) } else { Err(Error::UnknownHandle) }
    }

    fn set_state(&mut self, body: Body, kind: BodyKind, state: Rigid<R>) -> Result<(), Error> {
        let place = self.place(body)?;
        if body.kind != kind {
            return Err(Error::UnknownHandle);
        }
        match place {
            Place::Frame(frame) => {
                self.dirty = true;
                self.frames[frame].state = Rigid {
                    position: (state.position.map(as_f64) - self.frames[frame].origin).map(convert),
                    ..state
                };
                for island in &mut self.islands {
                    if island.store.members[kind as usize].iter().any(|member| member.entry == body.entry) {
                        island.wake();
                    }
                }
            }
            Place::Island(island, index) => {
                let island = &mut self.islands[island];
                let position = (state.position.map(as_f64) - island.origin).map(convert);
                island.store.set(kind, index, Rigid { position, ..state });
                self.dirty |= island.activity == Activity::Asleep;
                island.wake();
            }
        }
        Ok(())
    }
}

fn from_origin<R: RealField + Copy>(origin: Vector3<f64>, state: Rigid<R>) -> Rigid<R> {
    Rigid { position: (origin + state.position.map(as_f64)).map(convert), ..state }
}

/// Returns a free entry.
fn claim<P>(entries: &mut Vec<Entry<P>>, free: &mut Vec<usize>) -> usize {
    free.pop().unwrap_or_else(|| {
        entries.push(Entry { generation: 0, place: None });
        entries.len() - 1
    })
}

fn check_params<K: Kernel>(params: &K::Params) -> Result<(), Error> {
    let mut numbers: Vec<K::Real> = Vec::new();
    K::write_params(params, &mut numbers);
    if numbers.iter().all(nalgebra::ComplexField::is_finite) {
        Ok(())
    } else {
        Err(Error::NotFinite(K::NAME))
    }
}

fn check_mass<R: RealField + Copy>(mass: R) -> Result<(), Error> {
    match mass {
        mass if !mass.is_finite() => Err(Error::NotFinite("mass or inertia")),
        mass if mass <= R::zero() => Err(Error::NotPositive),
        _ => Ok(()),
    }
}

fn check_vector<R: RealField + Copy>(v: &Vector3<R>, name: &'static str) -> Result<(), Error> {
    if v.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Error::NotFinite(name)) }
}

/// A load as a vector.
fn checked_load<R: RealField + Copy>(load: &Wrench<R>) -> Result<Vector6<R>, Error> {
    check_vector(&load.force, "load")?;
    check_vector(&load.torque, "load")?;
    let (f, t) = (load.force, load.torque);
    Ok(Vector6::new(f.x, f.y, f.z, t.x, t.y, t.z))
}

fn check_rigid<R: RealField + Copy>(state: &mut Rigid<R>) -> Result<(), Error> {
    check_vector(&state.position, "position")?;
    check_vector(&state.velocity, "velocity")?;
    check_vector(&state.angular_velocity, "angular velocity")?;
    let q = state.orientation.quaternion();
    if !q.coords.iter().all(|x| x.is_finite()) {
        return Err(Error::NotFinite("orientation"));
    }
    let norm = q.norm();
    if norm < nalgebra::convert::<f64, R>(1e-6) {
        return Err(Error::NoOrientation);
    }
    state.orientation = nalgebra::UnitQuaternion::new_unchecked(*q / norm);
    Ok(())
}

fn check_particle<R: RealField + Copy>(state: &Particle<R>) -> Result<(), Error> {
    check_vector(&state.position, "position")?;
    check_vector(&state.velocity, "velocity")
}
