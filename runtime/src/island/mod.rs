//! Islands: bodies connected by forces, stepped independently of all others.
//!
//! An island owns its dynamic bodies, with positions relative to an origin in double precision, the forces
//! between them, and the system of a step. Every island has copies of the kinematic bodies that its forces
//! refer to.

pub(crate) mod bundle;
pub(crate) mod control;
mod engine;
mod topology;

use crate::kernel::BodyKind;
use crate::outside::Outside;
use crate::report::Report;
use crate::settings::Settings;
use crate::state::{Member, Motion, Poses, Store, as_f64};
use crate::step::packed::Packed;
use crate::step::{Integrator, Outcome, Stepper};
use crate::system::assemble::Fallback;

use crate::system::batch::{Batch, has_rows};
use engine::Engine;
use nalgebra::{RealField, Vector3, convert};

/// The state of activity of an island.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Activity {
    #[default]
    Awake,
    Asleep,
    /// Stopped at the last good state, because all attempts at a step failed.
    Quarantined,
}

pub(crate) struct Island<R: RealField + Copy> {
    /// The origin of positions.
    pub(crate) origin: Vector3<f64>,
    pub(crate) store: Store<R>,
    pub(crate) batches: Vec<Box<dyn Batch<R>>>,
    pub(crate) activity: Activity,
    /// Whether bodies or forces were added or removed.
    pub(crate) changed: bool,
    /// Whether something was removed, so the island may have split.
    pub(crate) maybe_split: bool,
    pub(crate) control: Control<R>,
    /// For implicit methods; `None` until one is used.
    engine: Option<Engine<R>>,
    /// For explicit methods; `None` until one is used.
    packed: Option<Box<Packed<R, 1>>>,
    /// The data that `packed` has read.
    packed_version: u64,
    packed_loads: u64,
    /// Counts changes of parameters or masses, of loads, of states by calls, and of structure.
    pub(crate) data_version: u64,
    pub(crate) load_version: u64,
    pub(crate) state_version: u64,
    pub(crate) structure_version: u64,
    /// −λ of rows that close loops, after the last accepted step.
    pub(crate) multipliers: Vec<R>,
    /// The neighbours of each node, for cuts.
    neighbours: Vec<Vec<usize>>,
    /// States before the whole call, and before a step.
    frame: Poses<R>,
    saved: Poses<R>,
}

/// The memory of step control.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Control<R> {
    /// The energy of the present state, if known.
    pub(crate) energy: Option<Energy<R>>,
    /// The largest recent kinetic and elastic energy.
    pub(crate) most: R,
    /// The size of the last accepted step.
    pub(crate) size: Option<R>,
    /// The time for which the island has been slow.
    pub(crate) still: R,
    /// The number of steps that were cut.
    pub(crate) cuts: u64,
    /// Whether the rates stored in the bodies belong to the present state.
    pub(crate) warm: bool,
}

/// The energy of an island; the potential of gravity is zero at the island's origin.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Energy<R> {
    /// Kinetic plus elastic energy.
    pub(crate) moving: R,
    pub(crate) total: R,
    /// The sum of the absolute terms.
    pub(crate) terms: R,
    pub(crate) max_violation: R,
    /// The mass of the dynamic bodies, kg.
    pub(crate) mass: f64,
}

impl<R: RealField + Copy> Energy<R> {
    /// The total, with the potential of gravity zero at the world's origin.
    pub(crate) fn in_world(&self, gravity: Vector3<R>, origin: Vector3<f64>) -> f64 {
        as_f64(self.total) - self.mass * gravity.map(as_f64).dot(&origin)
    }
}

impl<R: RealField + Copy> Island<R> {
    pub(crate) fn new(origin: Vector3<f64>) -> Island<R> {
        Island {
            origin,
            store: Store::default(),
            batches: Vec::new(),
            activity: Activity::Awake,
            changed: true,
            maybe_split: false,
            control: Control {
                energy: None,
                most: R::zero(),
                size: None,
                still: R::zero(),
                cuts: 0,
                warm: false,
            },
            engine: None,
            packed: None,
            packed_version: 0,
            packed_loads: 0,
            data_version: 1,
            load_version: 1,
            state_version: 1,
            structure_version: 0,
            multipliers: Vec::new(),
            neighbours: Vec::new(),
            frame: Poses::default(),
            saved: Poses::default(),
        }
    }

    /// After a change of bodies or forces: invalidates the memory of step control and ends sleep.
    pub(crate) fn wake(&mut self) {
        self.control.energy = None;
        self.data_version += 1;
        self.state_version += 1;
        self.forget();
        self.wake_for_load();
    }

    /// After a change of loads: ends sleep; the known energy stays valid.
    pub(crate) fn wake_for_load(&mut self) {
        self.control.still = R::zero();
        if self.activity == Activity::Asleep {
            self.activity = Activity::Awake;
        }
    }

    /// After a step: falls asleep if the island was slow for long enough.
    pub(crate) fn rest(&mut self, h: R, settings: &Settings<R>) {
        let Some(sleep) = settings.sleep else { return };
        let slow = |v: &Vector3<R>| v.norm_squared() < sleep.speed * sleep.speed;
        let rigid = self.store.rigid.iter().all(|body| slow(&body.velocity) && slow(&body.angular_velocity));
        let resting = rigid && self.store.particles.iter().all(|body| slow(&body.velocity));
        self.control.still = if resting { self.control.still + h } else { R::zero() };
        if self.control.still >= sleep.time && self.activity == Activity::Awake {
            self.activity = Activity::Asleep;
        }
    }

    /// The index of the batch with the same kernel and law; adds one if necessary.
    pub(crate) fn batch_like(&mut self, model: &dyn Batch<R>) -> usize {
        let wanted = (model.as_any().type_id(), model.is_rigid());
        let kind = |batch: &dyn Batch<R>| (batch.as_any().type_id(), batch.is_rigid());
        match self.batches.iter().position(|batch| kind(batch.as_ref()) == wanted) {
            Some(batch) => batch,
            None => {
                self.batches.push(model.empty());
                self.batches.len() - 1
            }
        }
    }

    /// Ends what a change of bodies or forces makes invalid; `version` is that of the new structure.
    pub(crate) fn prepare(&mut self, version: u64) {
        if !std::mem::take(&mut self.changed) {
            return;
        }
        self.batches.retain(|batch| !batch.entries().is_empty());
        self.control.energy = None;
        (self.engine, self.packed) = (None, None);
        self.data_version += 1;
        self.structure_version = version;
    }

    /// Energy and the largest constraint violation at the present state.
    pub(crate) fn measure(&self, gravity: Vector3<R>) -> Energy<R> {
        let half = convert::<f64, R>(0.5);
        let (mut kinetic, mut potential, mut terms, mut max_violation) =
            (R::zero(), R::zero(), R::zero(), R::zero());
        let mut all = 0.0;
        let mut fall = |mass: R, position: Vector3<R>| {
            all += as_f64(mass);
            let energy = -mass * gravity.dot(&position);
            potential += energy;
            terms += energy.abs();
        };
        for (body, member) in self.store.rigid.iter().zip(&self.store.members[0]) {
            if let Some((mass, moments)) = member.inertia() {
                let spin = body.orientation.inverse_transform_vector(&body.angular_velocity);
                let turning = spin.dot(&moments.component_mul(&spin));
                kinetic += half * (mass * body.velocity.norm_squared() + turning);
                fall(mass, body.position);
            }
        }
        for (body, member) in self.store.particles.iter().zip(&self.store.members[1]) {
            if let Some((mass, _)) = member.inertia() {
                kinetic += half * mass * body.velocity.norm_squared();
                fall(mass, body.position);
            }
        }
        let mut moving = kinetic;
        for batch in &self.batches {
            let one = batch.measure(&self.store.bodies());
            moving += one.energy;
            terms += one.energy.abs();
            max_violation = max_violation.max(one.max_violation);
        }
        Energy { moving, total: moving + potential, terms: terms + kinetic, max_violation, mass: all }
    }

    /// The same, cached until the state changes.
    pub(crate) fn energy(&mut self, gravity: Vector3<R>) -> Energy<R> {
        let energy = self.control.energy.unwrap_or_else(|| self.measure(gravity));
        self.control.energy = Some(energy);
        energy
    }

    /// Saves the states before a call, for restoring them.
    pub(crate) fn save_frame(&mut self) {
        self.store.save(&mut self.frame);
    }

    pub(crate) fn restore_frame(&mut self) {
        self.store.restore(&self.frame);
        self.control.energy = None;
        self.forget();
    }

    /// Invalidates what bodies and forces store from the last step.
    fn forget(&mut self) {
        self.control.warm = false;
        self.multipliers.clear();
        self.batches.iter_mut().for_each(|batch| batch.forget());
    }

    /// Attempts one step from the present state, which is saved.
    pub(crate) fn attempt(
        &mut self,
        h: R,
        fallback: Fallback<R>,
        outside: &Outside<'_, R>,
        settings: &Settings<R>,
        report: &mut Report,
    ) -> Option<Outcome<R>> {
        self.store.save(&mut self.saved);
        if settings.integrator.is_explicit() {
            return Some(self.attempt_packed(h, outside, settings.integrator));
        }
        let mut engine = match self.engine.take() {
            Some(engine) => engine,
            None => self.build(),
        };
        self.batches.iter_mut().for_each(|batch| batch.begin());
        let has_rows = has_rows(&self.batches);
        // Rows of parts would not be those of the whole.
        let parts = if has_rows { Vec::new() } else { self.cut(settings) };
        let Island { store, saved, batches, control, .. } = self;
        // Forces are not balanced across parts.
        let (solver, warm) = (settings.solver, control.warm && parts.is_empty());
        let outcome = match &mut engine {
            Engine::Three(model) => {
                model.assembly.fallback = fallback;
                model.assembly.system.parts = parts;
                Stepper { store, saved, batches, model, outside, clock: R::zero(), solver, warm, report }
                    .step(h, settings.integrator)
            }
            Engine::Six(model) => {
                model.assembly.fallback = fallback;
                model.assembly.system.parts = parts;
                Stepper { store, saved, batches, model, outside, clock: R::zero(), solver, warm, report }
                    .step(h, settings.integrator)
            }
        };
        self.engine = Some(engine);
        if has_rows && outcome.is_some() {
            self.in_lanes(|packed, store| {
                packed.project();
                packed.scatter(0, store);
            });
        }
        outcome
    }

    fn attempt_packed(&mut self, h: R, outside: &Outside<'_, R>, integrator: Integrator) -> Outcome<R> {
        self.in_lanes(|packed, store| {
            let stepped = packed.step(h, outside, integrator);
            packed.scatter(0, store);
            stepped.outcome(0, packed.has_rows())
        })
    }

    /// Works on the present state in the form of lanes, of which there is one.
    fn in_lanes<T>(&mut self, work: impl FnOnce(&mut Packed<R, 1>, &mut Store<R>) -> T) -> T {
        let Island { store, batches, origin, packed, packed_version, packed_loads, multipliers, .. } = self;
        let (data_version, load_version) = (&self.data_version, &self.load_version);
        if packed.is_none() {
            (*packed_version, *packed_loads) = (0, 0);
        }
        let packed = packed.get_or_insert_with(|| Box::new(Packed::new(store, batches, pulp::Arch::new())));
        if std::mem::replace(packed_version, *data_version) != *data_version {
            packed.gather(&[(store, batches, *origin)]);
        }
        if std::mem::replace(packed_loads, *load_version) != *load_version {
            packed.read_loads(0, store);
        }
        packed.read(0, store, multipliers);
        work(packed, store)
    }

    /// Saves the states before a step.
    pub(crate) fn save(&mut self) {
        self.store.save(&mut self.saved);
    }

    /// What islands that step in lanes must have in common: which bodies move, and which forces act on them.
    pub(crate) fn structure(&self) -> impl Ord + use<R> {
        let moves = self.store.members.each_ref().map(|members| {
            members.iter().map(|member| member.motion != Motion::Kinematic).collect::<Vec<bool>>()
        });
        let batch = |batch: &dyn Batch<R>| {
            let indices = (0..batch.entries().len()).flat_map(|at| batch.indices(at).to_vec());
            (batch.as_any().type_id(), batch.is_rigid(), indices.collect::<Vec<usize>>())
        };
        (moves, self.batches.iter().map(|it| batch(it.as_ref())).collect::<Vec<_>>())
    }

    pub(crate) fn restore(&mut self) {
        self.store.restore(&self.saved);
    }

    /// After an accepted step: stores multipliers and rates, but no rates of modified forces.
    pub(crate) fn keep(&mut self, integrator: Integrator, fallback: Fallback<R>) {
        self.batches.iter_mut().for_each(|batch| batch.keep());
        if let Some(packed) = self.packed.as_ref().filter(|_| integrator.is_explicit()) {
            packed.write_multipliers(0, &mut self.multipliers);
        }
        let has_rows = has_rows(&self.batches);
        let alpha = integrator == Integrator::GeneralizedAlpha && !has_rows;
        self.control.warm = alpha && fallback == Fallback::None;
        if self.control.warm {
            match &self.engine {
                Some(Engine::Three(model)) => model.keep_rates(&mut self.store),
                Some(Engine::Six(model)) => model.keep_rates(&mut self.store),
                None => {}
            }
        }
    }

    /// The power of forces without potential in the last assembly, and the largest factor by which a force
    /// was too stiff: infinite if a mass is negligible in rounding.
    pub(crate) fn assembled(&self) -> (R, R) {
        let (power, capped, mass_negligible) = match &self.engine {
            Some(Engine::Three(model)) => {
                (model.assembly.power, model.assembly.capped, model.assembly.mass_negligible)
            }
            Some(Engine::Six(model)) => {
                (model.assembly.power, model.assembly.capped, model.assembly.mass_negligible)
            }
            None => (R::zero(), R::zero(), false),
        };
        (power, if mass_negligible { R::one() / R::zero() } else { capped })
    }

    /// A body within the last step of `Rodas4`, at a fraction of its time.
    pub(crate) fn interpolate(&self, kind: BodyKind, index: usize, alpha: R) -> Option<crate::Rigid<R>> {
        let saved = self.saved.get(kind, index)?;
        match &self.engine {
            Some(Engine::Three(model)) => model.interpolate(kind, index, alpha, saved),
            Some(Engine::Six(model)) => model.interpolate(kind, index, alpha, saved),
            None => None,
        }
    }

    /// The work of loads in the step, with the mean of the velocities before and after.
    pub(crate) fn load_work(&self, h: R) -> R {
        let half = convert::<f64, R>(0.5);
        let work = |(kind, index, member): (BodyKind, usize, &Member<R>)| {
            let (before, after) = (self.saved.get(kind, index)?, self.store.get(kind, index));
            let turning = (before.angular_velocity + after.angular_velocity) * half;
            let moving = (before.velocity + after.velocity) * half;
            let load = &member.load;
            Some(load.fixed_rows::<3>(0).dot(&moving) + load.fixed_rows::<3>(3).dot(&turning))
        };
        self.store.iter().filter_map(work).fold(R::zero(), |sum, power| sum + power) * h
    }
}
