//! Which bodies and forces make up an island: copies from another island, parts without forces between
//! them, and cuts into parts of limited size.
//!
//! Input: islands with their bodies and forces. Output: the numbers of parts, or an island with additional
//! bodies and forces. The order of bodies and forces in the result depends on the input alone.

use super::Island;
use crate::kernel::BodyKind;
use crate::settings::Settings;
use crate::state::{Motion, Store};
use nalgebra::{RealField, Vector3, convert};
use std::collections::BTreeMap;

impl<R: RealField + Copy> Island<R> {
    /// Copies some bodies of another island, all forces on them, in order, and the kinematic bodies these
    /// need.
    pub(crate) fn take_from(&mut self, other: &Island<R>, wanted: &dyn Fn(BodyKind, usize) -> bool) {
        let shift: Vector3<R> = (other.origin - self.origin).map(convert);
        let mut places: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let bring = |store: &mut Store<R>, kind: BodyKind, index: usize| {
            let member = &other.store.members[kind as usize][index];
            let known = match member.motion {
                Motion::Dynamic(..) => None,
                Motion::Kinematic => {
                    store.members[kind as usize].iter().position(|own| own.entry == member.entry)
                }
            };
            known.unwrap_or_else(|| {
                let mut state = other.store.get(kind, index);
                state.position += shift;
                store.push(kind, state, member.clone())
            })
        };
        for (kind, index, member) in other.store.iter() {
            if member.motion != Motion::Kinematic && wanted(kind, index) {
                places.insert((kind as usize, index), bring(&mut self.store, kind, index));
            }
        }
        for batch in &other.batches {
            for at in 0..batch.entries().len() {
                let bodies = || batch.kinds().iter().copied().zip(batch.indices(at).iter().copied());
                let is_moved = |(kind, index): &(BodyKind, usize)| {
                    other.store.members[*kind as usize][*index].motion != Motion::Kinematic
                };
                if !bodies().filter(is_moved).any(|(kind, index)| wanted(kind, index)) {
                    continue;
                }
                for (kind, index) in bodies() {
                    places
                        .entry((kind as usize, index))
                        .or_insert_with(|| bring(&mut self.store, kind, index));
                }
                let own = self.batch_like(batch.as_ref());
                let place = |kind: BodyKind, index: usize| places[&(kind as usize, index)];
                batch.copy_to(at, self.batches[own].as_mut(), &place);
            }
        }
        self.changed = true;
    }

    /// If the island has split: the number of parts, and for each body of each type the number of its part.
    pub(crate) fn parts(&self) -> Option<(usize, [Vec<usize>; 2])> {
        let offset = self.store.rigid.len();
        let number = |kind: BodyKind, index: usize| index + if kind == BodyKind::Rigid { 0 } else { offset };
        let mut sets = Sets::new(offset + self.store.particles.len());
        for batch in &self.batches {
            for at in 0..batch.entries().len() {
                let bodies = batch.kinds().iter().zip(batch.indices(at));
                let mut moved = bodies
                    .filter(|&(&kind, &index)| {
                        self.store.members[kind as usize][index].motion != Motion::Kinematic
                    })
                    .map(|(&kind, &index)| number(kind, index));
                if let Some(first) = moved.next() {
                    moved.for_each(|other| sets.join(first, other));
                }
            }
        }
        let mut numbers = BTreeMap::new();
        let mut parts = [vec![usize::MAX; offset], vec![usize::MAX; self.store.particles.len()]];
        for (kind, index, member) in self.store.iter() {
            if member.motion != Motion::Kinematic {
                let next = numbers.len();
                let part = *numbers.entry(sets.root(number(kind, index))).or_insert(next);
                parts[kind as usize][index] = part;
            }
        }
        (numbers.len() > 1).then_some((numbers.len(), parts))
    }

    /// Divides nodes into parts of limited size, grown from a starting node that varies between steps.
    pub(super) fn cut(&mut self, settings: &Settings<R>) -> Vec<u32> {
        let count = self.neighbours.len();
        let Some(decoupling) = settings.decoupling.filter(|it| it.limit < count) else { return Vec::new() };
        self.control.cuts += 1;
        let start = mix(decoupling.seed ^ mix(self.control.cuts)) as usize % count;
        let mut order = Vec::with_capacity(count);
        let mut seen = vec![false; count];
        // Continues with nodes of unconnected pieces, which share only fixed bodies.
        for first in (start..count).chain(0..start) {
            if std::mem::replace(&mut seen[first], true) {
                continue;
            }
            let mut next = order.len();
            order.push(first);
            while let Some(&node) = order.get(next) {
                next += 1;
                for &other in &self.neighbours[node] {
                    if !std::mem::replace(&mut seen[other], true) {
                        order.push(other);
                    }
                }
            }
        }
        let mut parts = vec![0; count];
        for (k, node) in order.into_iter().enumerate() {
            parts[node] = (k / decoupling.limit.max(1)) as u32;
        }
        parts
    }
}

/// A hash of a number; Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014.
fn mix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Disjoint sets of numbers (union-find).
struct Sets(Vec<usize>);

impl Sets {
    fn new(count: usize) -> Sets {
        Sets((0..count).collect())
    }

    fn root(&mut self, mut node: usize) -> usize {
        while self.0[node] != node {
            self.0[node] = self.0[self.0[node]];
            node = self.0[node];
        }
        node
    }

    /// Joins two sets; the lower root remains the root.
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
