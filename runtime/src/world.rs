//! Bodies and the forces between them.
//!
//! In go bodies with mass and inertia, and forces named by their parameters; handles come out and stay valid when others
//! are removed. Bodies lie in arrays that kernels read in place. Positions count from `origin`, which is in double
//! precision whatever the world computes in. How a world moves stands in [`step`](crate::step).

use crate::batch::{Assembly, Batch, Forces};
use crate::error::Error;
use crate::kernel::{Bodies, BodyKind, Kernel, Parameters};
use crate::system::System;
use crate::{Particle, Rigid};
use nalgebra::{RealField, Vector3};
use std::collections::BTreeSet;

/// A body of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Body {
    pub(crate) kind: BodyKind,
    pub(crate) index: usize,
    generation: u32,
}

/// A force of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Force {
    index: usize,
    generation: u32,
}

/// How a body answers to forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion<R> {
    /// By its mass, kg, and its principal moments of inertia along the axes of body space, kg·m²; a particle has none.
    Dynamic(R, Vector3<R>),
    /// Not at all: it goes on at its velocity, which is zero for a fixed body.
    Kinematic,
}

#[derive(Clone, Debug)]
pub(crate) struct Slot<R> {
    generation: u32,
    alive: bool,
    pub(crate) motion: Motion<R>,
}

struct Place {
    generation: u32,
    /// Batch, and place in it; none once it is removed.
    at: Option<(usize, usize)>,
}

/// Bodies, forces and what a step needs of storage.
pub struct World<R: RealField + Copy = f64> {
    /// Acceleration of every body, m/s².
    pub gravity: Vector3<R>,
    /// Where positions count from, m.
    pub origin: Vector3<f64>,
    pub(crate) rigid: Vec<Rigid<R>>,
    pub(crate) particles: Vec<Particle<R>>,
    pub(crate) slots: [Vec<Slot<R>>; 2],
    pub(crate) batches: Vec<Box<dyn Batch<R>>>,
    places: Vec<Place>,
    pub(crate) assembly: Assembly<R>,
    pub(crate) scratch: crate::step::Scratch<R>,
    changed: bool,
}

impl<R: RealField + Copy> Default for World<R> {
    fn default() -> World<R> {
        World {
            gravity: Vector3::zeros(),
            origin: Vector3::zeros(),
            rigid: Vec::new(),
            particles: Vec::new(),
            slots: [Vec::new(), Vec::new()],
            batches: Vec::new(),
            places: Vec::new(),
            assembly: Assembly::default(),
            scratch: crate::step::Scratch::default(),
            changed: true,
        }
    }
}

impl<R: RealField + Copy> World<R> {
    /// Adds a rigid body; its orientation is normalised.
    pub fn add_rigid(&mut self, mut state: Rigid<R>, motion: Motion<R>) -> Result<Body, Error> {
        check_rigid(&mut state)?;
        if let Motion::Dynamic(mass, inertia) = motion {
            check_mass(mass)?;
            inertia.iter().try_for_each(|&moment| check_mass(moment))?;
        }
        Ok(insert(&mut self.rigid, &mut self.slots[0], BodyKind::Rigid, state, motion, &mut self.changed))
    }

    /// Adds a particle.
    pub fn add_particle(&mut self, state: Particle<R>, motion: Motion<R>) -> Result<Body, Error> {
        check_particle(&state)?;
        if let Motion::Dynamic(mass, _) = motion {
            check_mass(mass)?;
        }
        Ok(insert(
            &mut self.particles,
            &mut self.slots[1],
            BodyKind::Particle,
            state,
            motion,
            &mut self.changed,
        ))
    }

    /// A rigid body's state.
    pub fn rigid(&self, body: Body) -> Result<&Rigid<R>, Error> {
        self.check(body, BodyKind::Rigid)?;
        Ok(&self.rigid[body.index])
    }

    /// Puts a rigid body into a state.
    pub fn set_rigid(&mut self, body: Body, mut state: Rigid<R>) -> Result<(), Error> {
        self.check(body, BodyKind::Rigid)?;
        check_rigid(&mut state)?;
        self.rigid[body.index] = state;
        Ok(())
    }

    /// A particle's state.
    pub fn particle(&self, body: Body) -> Result<&Particle<R>, Error> {
        self.check(body, BodyKind::Particle)?;
        Ok(&self.particles[body.index])
    }

    /// Puts a particle into a state.
    pub fn set_particle(&mut self, body: Body, state: Particle<R>) -> Result<(), Error> {
        self.check(body, BodyKind::Particle)?;
        check_particle(&state)?;
        self.particles[body.index] = state;
        Ok(())
    }

    /// Removes a body and every force on it.
    pub fn remove_body(&mut self, body: Body) -> Result<(), Error> {
        self.check(body, body.kind)?;
        for index in 0..self.places.len() {
            let Some((batch, at)) = self.places[index].at else { continue };
            let batch = &self.batches[batch];
            let touches = |(&kind, &index): (&BodyKind, &usize)| kind == body.kind && index == body.index;
            if batch.kinds().iter().zip(batch.indices(at)).any(touches) {
                self.remove_force(Force { index, generation: self.places[index].generation })?;
            }
        }
        let slot = &mut self.slots[body.kind as usize][body.index];
        slot.alive = false;
        slot.motion = Motion::Kinematic;
        match body.kind {
            BodyKind::Rigid => self.rigid[body.index] = Rigid::default(),
            BodyKind::Particle => self.particles[body.index] = Particle::default(),
        }
        self.changed = true;
        Ok(())
    }

    /// Adds a force, named by its parameters, between bodies in argument order.
    pub fn add<P, const N: usize>(&mut self, params: P, bodies: [Body; N]) -> Result<Force, Error>
    where
        P: Parameters,
        P::Kernel: Kernel<Real = R>,
    {
        self.add_kernel::<P::Kernel>(params, &bodies)
    }

    /// Adds a force of a kernel, whose parameters may be none.
    pub fn add_kernel<K: Kernel<Real = R>>(
        &mut self,
        params: K::Params,
        bodies: &[Body],
    ) -> Result<Force, Error> {
        if !bodies.iter().map(|body| body.kind).eq(K::BODIES.iter().copied()) {
            return Err(Error::WrongBodies(K::NAME));
        }
        let mut indices = K::Indices::default();
        for (index, &body) in indices.as_mut().iter_mut().zip(bodies) {
            self.check(body, body.kind)?;
            *index = body.index;
        }
        let batch = match self.batches.iter_mut().position(|batch| batch.as_any().is::<Forces<K>>()) {
            Some(batch) => batch,
            None => {
                self.batches.push(Box::new(Forces::<K>::new()));
                self.batches.len() - 1
            }
        };
        let at = self.batches[batch].len();
        if let Some(forces) = self.batches[batch].as_any().downcast_mut::<Forces<K>>() {
            forces.push(params, indices);
        }
        self.changed = true;
        let index = match self.places.iter().position(|place| place.at.is_none()) {
            Some(free) if self.places.len() > 2 * self.force_count() => free,
            _ => {
                self.places.push(Place { generation: 0, at: None });
                self.places.len() - 1
            }
        };
        self.places[index].at = Some((batch, at));
        Ok(Force { index, generation: self.places[index].generation })
    }

    /// Removes a force.
    pub fn remove_force(&mut self, force: Force) -> Result<(), Error> {
        let place = self.places.get_mut(force.index).filter(|place| place.generation == force.generation);
        let place = place.ok_or(Error::UnknownHandle)?;
        let (batch, at) = place.at.take().ok_or(Error::UnknownHandle)?;
        place.generation += 1;
        self.batches[batch].remove(at);
        let last = Some((batch, self.batches[batch].len()));
        if let Some(moved) = self.places.iter_mut().find(|place| place.at == last) {
            moved.at = Some((batch, at));
        }
        self.changed = true;
        Ok(())
    }

    /// How many forces there are.
    pub fn force_count(&self) -> usize {
        self.batches.iter().map(|batch| batch.len()).sum()
    }

    /// Kinetic energy of all bodies and their potential in gravity, zero at the origin; forces have no known potential.
    pub fn mechanical_energy(&self) -> R {
        let half = nalgebra::convert::<f64, R>(0.5);
        let mut energy = R::zero();
        for (body, slot) in self.rigid.iter().zip(&self.slots[0]) {
            if let Motion::Dynamic(mass, inertia) = slot.motion {
                let spin = body.orientation.inverse_transform_vector(&body.angular_velocity);
                energy +=
                    half * (mass * body.velocity.norm_squared() + spin.dot(&inertia.component_mul(&spin)));
                energy -= mass * self.gravity.dot(&body.position);
            }
        }
        for (body, slot) in self.particles.iter().zip(&self.slots[1]) {
            if let Motion::Dynamic(mass, _) = slot.motion {
                energy +=
                    half * mass * body.velocity.norm_squared() - mass * self.gravity.dot(&body.position);
            }
        }
        energy
    }

    pub(crate) fn bodies(&self) -> Bodies<'_, R> {
        Bodies { rigid: &self.rigid, particles: &self.particles }
    }

    /// Numbers the nodes anew if bodies or forces have changed.
    pub(crate) fn prepare(&mut self) {
        if !std::mem::take(&mut self.changed) {
            return;
        }
        let mut count = 0;
        for (nodes, slots) in self.assembly.nodes.iter_mut().zip(&self.slots) {
            nodes.clear();
            nodes.extend(slots.iter().map(|slot| match slot.motion {
                Motion::Dynamic(..) => {
                    count += 1;
                    Some(count - 1)
                }
                Motion::Kinematic => None,
            }));
        }
        let mut neighbours = vec![BTreeSet::new(); count];
        for batch in &self.batches {
            for at in 0..batch.len() {
                let bodies = batch.kinds().iter().zip(batch.indices(at));
                let nodes: Vec<usize> =
                    bodies.filter_map(|(&kind, &index)| self.assembly.nodes[kind as usize][index]).collect();
                for &a in &nodes {
                    neighbours[a].extend(nodes.iter().filter(|&&b| b != a));
                }
            }
        }
        let (system, place) = System::new(neighbours);
        self.assembly.system = system;
        for node in self.assembly.nodes.iter_mut().flatten().flatten() {
            *node = place[*node];
        }
        self.assembly.force.resize(count, nalgebra::Vector6::zeros());
        self.assembly.drift.resize(count, nalgebra::Vector6::zeros());
    }

    fn check(&self, body: Body, kind: BodyKind) -> Result<(), Error> {
        let slot = self.slots[body.kind as usize].get(body.index);
        let known = slot.is_some_and(|slot| slot.alive && slot.generation == body.generation);
        if known && body.kind == kind { Ok(()) } else { Err(Error::UnknownHandle) }
    }
}

fn insert<S, R>(
    states: &mut Vec<S>,
    slots: &mut Vec<Slot<R>>,
    kind: BodyKind,
    state: S,
    motion: Motion<R>,
    changed: &mut bool,
) -> Body {
    *changed = true;
    if let Some(index) = slots.iter().position(|slot| !slot.alive) {
        let generation = slots[index].generation + 1;
        states[index] = state;
        slots[index] = Slot { generation, alive: true, motion };
        return Body { kind, index, generation };
    }
    states.push(state);
    slots.push(Slot { generation: 0, alive: true, motion });
    Body { kind, index: slots.len() - 1, generation: 0 }
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
