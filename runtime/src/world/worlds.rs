//! Many copies of a world, stepped side by side, for learning and planning.
//!
//! In: a world, the number of copies, and for each body the loads or states of all copies as slices. Out: the
//! states of all copies. Copies do not affect each other; explicit methods step them in lanes.

use crate::error::Error;
use crate::island::control::StepRequest;
use crate::island::{Activity, Island};
use crate::kernel::BodyKind;
use crate::report::Report;
use crate::settings::Settings;
use crate::state::{Body, Motion, moved};
use crate::system::assemble::Fallback;
use crate::world::groups::Groups;
use crate::world::{Entry, Place, World, check_rigid, checked_load, from_origin};
use crate::{Rigid, Wrench};
use nalgebra::{RealField, Vector3, convert};

/// Copies of a world.
pub struct Worlds<R: RealField + Copy = f64> {
    /// The acceleration of all dynamic bodies, m/s².
    pub gravity: Vector3<R>,
    /// The method and parameters of steps.
    pub settings: Settings<R>,
    copies: usize,
    /// The islands of the first copy, then of the second, …
    islands: Vec<Island<R>>,
    /// The islands of a copy.
    each: usize,
    bodies: Vec<Entry<Place>>,
    awake: Vec<usize>,
    groups: Groups<R>,
}

impl<R: RealField + Copy> Worlds<R> {
    /// This number of copies of a world in its present state.
    pub fn new(world: &mut World<R>, copies: usize) -> Worlds<R> {
        world.prepare();
        let template = &world.islands;
        let copy = |(number, island): (usize, &Island<R>)| {
            let mut copy = Island::new(island.origin);
            copy.take_from(island, &|_, _| true);
            copy.activity = island.activity;
            copy.prepare(number as u64 + 1);
            copy
        };
        let islands = (0..copies).flat_map(|_| template).enumerate().map(copy).collect();
        let mut worlds = Worlds {
            gravity: world.gravity,
            settings: world.settings,
            copies,
            islands,
            each: template.len(),
            bodies: world.bodies.clone(),
            awake: Vec::new(),
            groups: Groups::default(),
        };
        // Copies number bodies in another order.
        for number in 0..worlds.each.min(worlds.islands.len()) {
            for (_, index, member) in worlds.islands[number].store.iter() {
                if member.motion != Motion::Kinematic {
                    worlds.bodies[member.entry].place = Some(Place::Island(number, index));
                }
            }
        }
        worlds.count();
        worlds
    }

    /// The number of copies.
    pub fn copies(&self) -> usize {
        self.copies
    }

    /// Advances all copies by `h`, s. The report sums over copies.
    pub fn step(&mut self, h: R) -> Result<Report, Error>
    where
        R: Send + Sync,
    {
        World::check_step(h)?;
        let mut report = Report::default();
        if h > R::zero() {
            let Worlds { gravity, settings, islands, awake, groups, .. } = self;
            groups.update(islands, awake, settings);
            let request =
                StepRequest { h, fallback: Fallback::None, gravity: *gravity, loads: None, settings };
            groups.advance(islands, awake, &request, |one| report.add(one));
            for &number in &self.awake {
                self.islands[number].drive(h);
            }
            if self.awake.iter().any(|&number| self.islands[number].activity != Activity::Awake) {
                self.count();
            }
        }
        let resting = |activity: Activity| self.islands.iter().filter(|it| it.activity == activity).count();
        [report.asleep, report.quarantined] = [resting(Activity::Asleep), resting(Activity::Quarantined)];
        Ok(report)
    }

    /// The states of a rigid body in all copies, with positions relative to zero.
    pub fn rigid(&self, body: Body) -> Result<impl Iterator<Item = Rigid<R>> + '_, Error> {
        let (first, index) = self.place(body, BodyKind::Rigid)?;
        Ok((0..self.copies).map(move |copy| {
            let island = &self.islands[copy * self.each + first];
            from_origin(island.origin, island.store.rigid[index])
        }))
    }

    /// Sets the states of a rigid body, one per copy.
    ///
    /// Fails without a change if there are not as many states as copies, or if one is not finite.
    pub fn set_rigid(&mut self, body: Body, states: &[Rigid<R>]) -> Result<(), Error> {
        let (first, index) = self.place(body, BodyKind::Rigid)?;
        let mut states = self.one_per_copy(states)?.to_vec();
        states.iter_mut().try_for_each(check_rigid)?;
        for (copy, state) in states.into_iter().enumerate() {
            let island = &mut self.islands[copy * self.each + first];
            let position = (state.position.map(crate::state::as_f64) - island.origin).map(convert);
            island.store.rigid[index] = Rigid { position, ..state };
            island.wake();
        }
        self.count();
        Ok(())
    }

    /// Sets the load on a body, one per copy, until the next call.
    ///
    /// Fails without a change if there are not as many loads as copies, or if one is not finite.
    pub fn set_loads(&mut self, body: Body, loads: &[Wrench<R>]) -> Result<(), Error> {
        let (first, index) = self.place(body, body.kind)?;
        let loads = self.one_per_copy(loads)?.iter().map(checked_load).collect::<Result<Vec<_>, Error>>()?;
        let mut woken = false;
        for (copy, load) in loads.into_iter().enumerate() {
            let island = &mut self.islands[copy * self.each + first];
            island.store.members[body.kind as usize][index].load = load;
            island.load_version += 1;
            woken |= island.activity == Activity::Asleep;
            island.wake_for_load();
        }
        if woken {
            self.count();
        }
        Ok(())
    }

    fn one_per_copy<'a, T>(&self, all: &'a [T]) -> Result<&'a [T], Error> {
        if all.len() == self.copies { Ok(all) } else { Err(Error::WrongCount) }
    }

    fn place(&self, body: Body, kind: BodyKind) -> Result<(usize, usize), Error> {
        let entry = self.bodies.get(body.entry).filter(|entry| entry.generation == body.generation);
        match entry.and_then(|entry| entry.place) {
            Some(Place::Island(island, index)) if body.kind == kind => Ok((island, index)),
            _ => Err(Error::UnknownHandle),
        }
    }

    fn count(&mut self) {
        self.awake.clear();
        let awake = self.islands.iter().enumerate().filter(|(_, it)| it.activity == Activity::Awake);
        self.awake.extend(awake.map(|(number, _)| number));
    }
}

impl<R: RealField + Copy> Island<R> {
    /// Moves its kinematic bodies.
    fn drive(&mut self, h: R) {
        let store = &mut self.store;
        for kind in [BodyKind::Rigid, BodyKind::Particle] {
            for index in 0..store.members[kind as usize].len() {
                if store.members[kind as usize][index].motion == Motion::Kinematic {
                    let state = store.get(kind, index);
                    if state.velocity != Vector3::zeros() || state.angular_velocity != Vector3::zeros() {
                        let next = moved(&state, state.velocity * h, state.angular_velocity * h);
                        store.set(kind, index, next);
                    }
                }
            }
        }
    }
}
