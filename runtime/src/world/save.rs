//! Worlds as values that serde can write and read.
//!
//! A saved world contains everything that a step depends on, in order, so a loaded world continues bit for
//! bit. Forces are saved with the names of their kernels; `load` requires a list of these kernels.

use crate::error::Error;
use crate::island::{Activity, Control, Island};
use crate::kernel::{BodyKind, Kernel};
use crate::settings::Settings;
use crate::state::Store;
use crate::system::batch::{Batch, Forces};
use crate::world::{Entry, Frame, Place, World};
use nalgebra::{RealField, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A saved world.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "R: Serialize", deserialize = "R: Deserialize<'de>"))]
pub struct Saved<R: RealField + Copy> {
    gravity: Vector3<R>,
    settings: Settings<R>,
    islands: Vec<SavedIsland<R>>,
    frames: Vec<Frame<R>>,
    bodies: Vec<Entry<Place>>,
    forces: Vec<Entry<(usize, usize, usize)>>,
    free_bodies: Vec<usize>,
    free_forces: Vec<usize>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "R: Serialize", deserialize = "R: Deserialize<'de>"))]
struct SavedIsland<R: RealField + Copy> {
    origin: Vector3<f64>,
    store: Store<R>,
    activity: Activity,
    maybe_split: bool,
    control: Control<R>,
    batches: Vec<SavedBatch<R>>,
    multipliers: Vec<R>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct SavedBatch<R> {
    kernel: String,
    rigid: bool,
    forces: Vec<SavedForce<R>>,
    multipliers: Option<Vec<R>>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct SavedForce<R> {
    entry: usize,
    bodies: Vec<usize>,
    params: Vec<R>,
}

/// Creates an empty batch, of rigid rows or others.
type Empty<R> = fn(bool) -> Box<dyn Batch<R>>;

/// The kernels that a saved world may refer to.
pub struct Kernels<R> {
    empty: BTreeMap<&'static str, Empty<R>>,
}

impl<R> Default for Kernels<R> {
    fn default() -> Kernels<R> {
        Kernels { empty: BTreeMap::new() }
    }
}

impl<R: RealField + Copy> Kernels<R> {
    /// An empty list.
    pub fn new() -> Kernels<R> {
        Kernels::default()
    }

    /// Adds a kernel by its output, `Kernels::new().with::<ball::Output>()`; replaces one of the same name.
    pub fn with<K: Kernel<Real = R>>(mut self) -> Kernels<R> {
        self.empty.insert(K::NAME, |rigid| Box::new(Forces::<K>::new(rigid)));
        self
    }
}

impl<R: RealField + Copy> World<R> {
    /// Saves everything that a step depends on.
    pub fn save(&self) -> Saved<R> {
        let batch = |batch: &dyn Batch<R>| {
            let force = |(at, &entry): (usize, &usize)| SavedForce {
                entry,
                bodies: batch.indices(at).to_vec(),
                params: batch.numbers(at),
            };
            SavedBatch {
                kernel: batch.name().to_owned(),
                rigid: batch.is_rigid(),
                forces: batch.entries().iter().enumerate().map(force).collect(),
                multipliers: batch.multipliers().map(<[R]>::to_vec),
            }
        };
        let island = |island: &Island<R>| SavedIsland {
            origin: island.origin,
            store: island.store.clone(),
            activity: island.activity,
            maybe_split: island.maybe_split,
            control: island.control,
            batches: island.batches.iter().map(|it| batch(it.as_ref())).collect(),
            multipliers: island.multipliers.clone(),
        };
        Saved {
            gravity: self.gravity,
            settings: self.settings,
            islands: self.islands.iter().map(island).collect(),
            frames: self.frames.clone(),
            bodies: self.bodies.clone(),
            forces: self.forces.clone(),
            free_bodies: self.free_bodies.clone(),
            free_forces: self.free_forces.clone(),
        }
    }

    /// Restores a saved world; handles from before the save remain valid.
    pub fn load(saved: Saved<R>, kernels: &Kernels<R>) -> Result<World<R>, Error> {
        let mut world = World {
            gravity: saved.gravity,
            settings: saved.settings,
            frames: saved.frames,
            bodies: saved.bodies,
            forces: saved.forces,
            free_bodies: saved.free_bodies,
            free_forces: saved.free_forces,
            ..World::default()
        };
        for saved in saved.islands {
            let mut island = Island::new(saved.origin);
            island.store = saved.store;
            (island.activity, island.maybe_split, island.control) =
                (saved.activity, saved.maybe_split, saved.control);
            island.multipliers = saved.multipliers;
            for batch in saved.batches {
                island.batches.push(load_batch(batch, &island.store, kernels)?);
            }
            world.islands.push(island);
        }
        if world.holds_together() { Ok(world) } else { Err(Error::Damaged) }
    }

    /// Whether every index refers to an existing object.
    fn holds_together(&self) -> bool {
        let member = |place: Place, entry: usize| match place {
            Place::Frame(index) => self.frames.get(index).is_some_and(|frame| frame.entry == entry),
            Place::Island(island, index) => self.islands.get(island).is_some_and(|island| {
                let own = island.store.members.iter().filter_map(|members| members.get(index));
                own.into_iter().any(|member| member.entry == entry)
            }),
        };
        let bodies = self.bodies.iter().enumerate();
        let bodies = bodies.filter_map(|(entry, body)| Some((entry, body.place?)));
        let force = |entry: usize, (island, batch, at): (usize, usize, usize)| {
            let batch = self.islands.get(island).and_then(|island| island.batches.get(batch));
            batch.is_some_and(|batch| batch.entries().get(at) == Some(&entry))
        };
        let forces = self.forces.iter().enumerate();
        let forces = forces.filter_map(|(entry, force)| Some((entry, force.place?)));
        let sound = |island: &Island<R>| {
            let Store { rigid, particles, members } = &island.store;
            let known = members.iter().flatten().all(|member| member.entry < self.bodies.len());
            let batches = island.batches.iter().flat_map(|batch| batch.entries());
            known
                && rigid.len() == members[0].len()
                && particles.len() == members[1].len()
                && batches.into_iter().all(|&entry| entry < self.forces.len())
        };
        let free = |free: &[usize], count: usize| free.iter().all(|&entry| entry < count);
        self.islands.iter().all(sound)
            && free(&self.free_bodies, self.bodies.len())
            && free(&self.free_forces, self.forces.len())
            && bodies.into_iter().all(|(entry, place)| member(place, entry))
            && forces.into_iter().all(|(entry, place)| force(entry, place))
    }
}

fn load_batch<R: RealField + Copy>(
    saved: SavedBatch<R>,
    store: &Store<R>,
    kernels: &Kernels<R>,
) -> Result<Box<dyn Batch<R>>, Error> {
    let empty = kernels.empty.get(saved.kernel.as_str()).ok_or(Error::UnknownKernel)?;
    let mut batch = empty(saved.rigid);
    for force in saved.forces {
        let there = |(&kind, &index): (&BodyKind, &usize)| index < store.members[kind as usize].len();
        let fits = batch.kinds().len() == force.bodies.len()
            && batch.kinds().iter().zip(&force.bodies).all(there)
            && batch.push_numbers(&force.params, &force.bodies, force.entry);
        if !fits {
            return Err(Error::UnknownKernel);
        }
    }
    let fits = saved.multipliers.is_none_or(|multipliers| batch.set_multipliers(multipliers));
    if fits { Ok(batch) } else { Err(Error::Damaged) }
}
