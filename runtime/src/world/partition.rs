//! Updates the partition of bodies and forces into islands.

use crate::Rigid;
use crate::island::{Activity, Island};
use crate::kernel::BodyKind;
use crate::state::{Member, Motion};
use crate::world::{Body, Frame, Place, World};
use nalgebra::{RealField, Vector3, convert};

impl<R: RealField + Copy> World<R> {
    /// Updates islands: splits those that fell apart, rebuilds changed systems, finds the awake ones.
    pub(crate) fn prepare(&mut self) {
        if self.dirty {
            self.moving_frames.clear();
            self.moving_frames.extend((0..self.frames.len()).filter(|&frame| self.frames[frame].moves()));
        }
        if !self.moving_frames.is_empty() {
            for number in 0..self.islands.len() {
                if self.islands[number].activity == Activity::Asleep && self.has_moving_frame(number) {
                    self.islands[number].wake();
                    self.dirty = true;
                }
            }
        }
        if std::mem::take(&mut self.dirty) {
            for number in 0..self.islands.len() {
                if std::mem::take(&mut self.islands[number].maybe_split) {
                    self.take_apart(number);
                }
            }
            for number in (0..self.islands.len()).rev() {
                if self.islands[number].store.moving() == 0 {
                    self.islands.swap_remove(number);
                    self.renumber(number);
                }
            }
            self.count();
            for k in 0..self.awake.len() {
                let number = self.awake[k];
                if self.islands[number].changed {
                    self.structures += 1;
                    self.islands[number].prepare(self.structures);
                    self.renumber(number);
                }
            }
        }
        for &number in &self.awake {
            let Island { origin, store, .. } = &mut self.islands[number];
            for kind in [BodyKind::Rigid, BodyKind::Particle] {
                for index in 0..store.members[kind as usize].len() {
                    let member = &store.members[kind as usize][index];
                    if member.motion == Motion::Kinematic
                        && let Some(Place::Frame(frame)) = self.bodies[member.entry].place
                    {
                        store.set(kind, index, self.frames[frame].local_to(*origin));
                    }
                }
            }
        }
    }

    /// Lists the awake islands and counts the others.
    pub(crate) fn count(&mut self) {
        self.awake.clear();
        self.resting = [0; 2];
        for (number, island) in self.islands.iter().enumerate() {
            match island.activity {
                Activity::Awake => self.awake.push(number),
                Activity::Asleep => self.resting[0] += 1,
                Activity::Quarantined => self.resting[1] += 1,
            }
        }
    }

    fn has_moving_frame(&self, island: usize) -> bool {
        let frame = |entry: usize| match self.bodies[entry].place {
            Some(Place::Frame(frame)) => Some(&self.frames[frame]),
            _ => None,
        };
        self.islands[island].store.iter().any(|(_, _, member)| frame(member.entry).is_some_and(Frame::moves))
    }

    /// Splits an island into its parts.
    fn take_apart(&mut self, number: usize) {
        let Some((count, parts)) = self.islands[number].parts() else { return };
        let whole = std::mem::replace(&mut self.islands[number], Island::new(Vector3::zeros()));
        for part in 0..count {
            let mut island = Island::new(whole.origin);
            island.take_from(&whole, &|kind, index| parts[kind as usize][index] == part);
            island.activity = whole.activity;
            let at = if part == 0 { number } else { self.islands.len() };
            if part == 0 {
                self.islands[number] = island;
            } else {
                self.islands.push(island);
            }
            self.renumber(at);
        }
    }

    /// Updates the handles of an island's bodies and forces; does nothing if the island does not exist.
    fn renumber(&mut self, number: usize) {
        let Some(island) = self.islands.get(number) else { return };
        for (_, index, member) in island.store.iter() {
            if member.motion != Motion::Kinematic {
                self.bodies[member.entry].place = Some(Place::Island(number, index));
            }
        }
        for (b, batch) in island.batches.iter().enumerate() {
            for (at, &entry) in batch.entries().iter().enumerate() {
                self.forces[entry].place = Some((number, b, at));
            }
        }
    }

    /// Merges two islands into the larger one; returns its index.
    pub(crate) fn join(&mut self, a: usize, b: usize) -> usize {
        if a == b {
            return a;
        }
        let size = |number: usize| self.islands[number].store.moving();
        let (home, guest) = if size(a) >= size(b) { (a, b) } else { (b, a) };
        let (activities, maybe_split) =
            ([home, guest].map(|it| self.islands[it].activity), self.islands[guest].maybe_split);
        let guest = std::mem::replace(&mut self.islands[guest], Island::new(Vector3::zeros()));
        let island = &mut self.islands[home];
        island.take_from(&guest, &|_, _| true);
        island.maybe_split |= maybe_split;
        island.activity =
            if activities.contains(&Activity::Quarantined) { Activity::Quarantined } else { Activity::Awake };
        island.wake();
        self.renumber(home);
        home
    }

    /// The index of a kinematic body in an island; copies the body if necessary.
    pub(crate) fn local_copy(&mut self, island: usize, body: Body, frame: usize) -> usize {
        let island = &mut self.islands[island];
        let members = &island.store.members[body.kind as usize];
        let own = members
            .iter()
            .position(|member| member.entry == body.entry && member.motion == Motion::Kinematic);
        own.unwrap_or_else(|| {
            let state = self.frames[frame].local_to(island.origin);
            let member = Member::new(body, Motion::Kinematic);
            island.store.push(body.kind, state, member)
        })
    }
}

impl<R: RealField + Copy> Frame<R> {
    fn moves(&self) -> bool {
        self.state.velocity != Vector3::zeros() || self.state.angular_velocity != Vector3::zeros()
    }

    /// The state, with the position relative to an origin.
    fn local_to(&self, origin: Vector3<f64>) -> Rigid<R> {
        let shift: Vector3<R> = (self.origin - origin).map(convert);
        Rigid { position: self.state.position + shift, ..self.state }
    }
}
