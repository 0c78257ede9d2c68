//! Batches: all forces of one kernel in an island.
//!
//! A batch stores the parameters and body indices of its forces; the trait hides the kernel's type. Assembly
//! evaluates the forces one by one, with only the required derivatives, and adds them to the system of the
//! step.

use crate::kernel::{Bodies, BodyKind, Kernel, Linear, Measure, Saddle};
use crate::system::assemble::{Assembly, Derivatives, Local, NOWHERE, Need, Rows, Wants};
use crate::system::lane_batch;
use crate::system::order::Joint;
use nalgebra::{RealField, zero};
use std::any::Any;

/// The assembly to add to; islands of particles have 3 × 3 blocks.
pub(crate) enum Sums<'a, R: RealField> {
    Three(&'a mut Assembly<R, 3>),
    Six(&'a mut Assembly<R, 6>),
}

/// The forces of a kernel, with the kernel's type erased.
pub(crate) trait Batch<R: RealField>: Send {
    fn assemble(&mut self, bodies: &Bodies<'_, R>, out: Sums<'_, R>);
    /// Whether the forces have multipliers.
    fn has_multipliers(&self) -> bool;
    /// Whether the forces are rigid rows, whose multipliers are unknowns.
    fn is_rigid(&self) -> bool;
    /// The number of rows of each force.
    fn rows(&self) -> usize;
    /// An empty batch in lanes, a `Box<dyn LaneBatch<R, L>>` for this L, to be downcast.
    fn in_lanes(&self, lanes: usize) -> Box<dyn Any>;
    /// Whether the forces have an energy and no multipliers.
    fn is_energy(&self) -> bool;
    /// Before a step: starts with λ of the last accepted step.
    fn begin(&mut self);
    /// After a solution: λ at the solution of the linearised system. Rotation makes the pose's error
    /// quadratic in the angle, which stiff joints would turn into large forces; the relative error of λ is at
    /// most that of the linearisation.
    fn predict(&mut self, out: Sums<'_, R>);
    /// After an accepted step: stores λ.
    fn keep(&mut self);
    /// After a change of state: the next step computes λ from its pose.
    fn forget(&mut self);
    /// Updates the positions of blocks in the system.
    fn place(&mut self, block: &dyn Fn((BodyKind, usize), (BodyKind, usize)) -> Option<usize>);
    /// Updates the nodes of rigid rows, and the positions of their blocks: those of a body in the rows, and of
    /// the rows in the equations of a body.
    fn place_rows(
        &mut self,
        nodes: Vec<usize>,
        block: &dyn Fn(usize, (BodyKind, usize)) -> Option<[usize; 2]>,
    );
    /// The energy of all forces, and the largest constraint violation.
    fn measure(&self, bodies: &Bodies<'_, R>) -> Measure<R>;
    /// An empty batch of the same kernel.
    fn empty(&self) -> Box<dyn Batch<R>>;
    /// Appends a copy of a force to a batch of the same kernel, with renumbered bodies.
    fn copy_to(&self, at: usize, other: &mut dyn Batch<R>, body: &dyn Fn(BodyKind, usize) -> usize);
    /// Removes a force; the last force takes its index.
    fn remove(&mut self, at: usize);
    /// The forces' entries in the world's table, in order.
    fn entries(&self) -> &[usize];
    #[cfg(feature = "serde")]
    fn name(&self) -> &'static str;
    fn kinds(&self) -> &'static [BodyKind];
    fn indices(&self, at: usize) -> &[usize];
    fn indices_mut(&mut self, at: usize) -> &mut [usize];
    /// The parameters of a force.
    #[cfg(feature = "serde")]
    fn numbers(&self, at: usize) -> Vec<R>;
    /// λ of all forces, if known.
    #[cfg(feature = "serde")]
    fn multipliers(&self) -> Option<&[R]>;
    /// Sets λ; returns whether the number of values is right.
    #[cfg(feature = "serde")]
    fn set_multipliers(&mut self, multipliers: Vec<R>) -> bool;
    /// Appends a force with these parameters; returns whether the numbers of values are right.
    #[cfg(feature = "serde")]
    fn push_numbers(&mut self, numbers: &[R], indices: &[usize], entry: usize) -> bool;
    fn as_any(&self) -> &dyn Any;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

/// Whether some of the forces are rigid rows.
pub(crate) fn has_rows<R: RealField>(batches: &[Box<dyn Batch<R>>]) -> bool {
    batches.iter().any(|batch| batch.is_rigid())
}

/// The joints of rigid rows, in the order of batches and forces, for bodies with these nodes.
pub(crate) fn joints<R: RealField>(
    batches: &[Box<dyn Batch<R>>],
    nodes: &[Vec<Option<usize>>; 2],
) -> Vec<Joint> {
    let of = |batch: &dyn Batch<R>, at: usize| {
        let bodies = batch.kinds().iter().zip(batch.indices(at));
        let mut bodies: Vec<usize> =
            bodies.filter_map(|(&kind, &index)| nodes[kind as usize][index]).collect();
        bodies.sort_unstable();
        bodies.dedup();
        Joint { bodies, rows: batch.rows() }
    };
    let rigid = batches.iter().filter(|batch| batch.is_rigid());
    rigid.flat_map(|batch| (0..batch.entries().len()).map(move |at| of(batch.as_ref(), at))).collect()
}

pub(crate) struct Forces<K: Kernel> {
    /// Whether these are rigid rows.
    pub(crate) rigid: bool,
    kernel: K,
    force: K::Force,
    step: K::Step,
    pub(crate) params: Vec<K::Params>,
    pub(crate) indices: Vec<K::Indices>,
    entries: Vec<usize>,
    /// The block position of each pair of bodies, for each force.
    places: Vec<u32>,
    /// Of rigid rows: the node of each force, and the positions of its blocks with each body.
    joints: Vec<usize>,
    row_places: Vec<Option<[usize; 2]>>,
    saddle: K::Saddle,
    /// Jᵀ times multipliers, and zeros for its derivative by velocities.
    pull: (Vec<K::Real>, Vec<K::Real>),
    /// λ of each force after the last accepted step, and in the present step; each with its validity. Of rigid
    /// rows −λ, with which they pull by Jᵀ.
    kept: (Vec<K::Real>, bool),
    held: (Vec<K::Real>, bool),
    /// Whether a solution of the present step has predicted λ.
    predicted: bool,
    /// λ and its slopes for each force, from the last evaluation.
    linear: Vec<K::Real>,
}

impl<K: Kernel> Default for Forces<K> {
    fn default() -> Forces<K> {
        Forces {
            rigid: false,
            kernel: K::default(),
            force: K::Force::default(),
            step: K::Step::default(),
            params: Vec::new(),
            indices: Vec::new(),
            entries: Vec::new(),
            places: Vec::new(),
            joints: Vec::new(),
            row_places: Vec::new(),
            saddle: K::Saddle::default(),
            pull: (Vec::new(), Vec::new()),
            kept: (Vec::new(), false),
            held: (Vec::new(), false),
            predicted: false,
            linear: Vec::new(),
        }
    }
}

impl<K: Kernel> Forces<K> {
    /// No forces yet; rigid rows or others.
    pub(crate) fn new(rigid: bool) -> Forces<K> {
        Forces { rigid, ..Forces::default() }
    }

    pub(crate) fn push(&mut self, params: K::Params, indices: K::Indices, entry: usize) {
        self.params.push(params);
        self.indices.push(indices);
        self.entries.push(entry);
        self.kept.0.extend(std::iter::repeat_n(zero::<K::Real>(), K::ROWS));
        self.kept.1 = false;
    }

    fn add_all<const D: usize>(&mut self, bodies: &Bodies<'_, K::Real>, out: &mut Assembly<K::Real, D>) {
        let pairs = K::BODIES.len() * K::BODIES.len();
        let need = out.need();
        self.linear.clear();
        let forces = self.params.iter().zip(&self.indices).zip(self.places.chunks_exact(pairs));
        for (at, ((params, indices), places)) in forces.enumerate() {
            let (force, derivatives) = match need {
                Need::Force => {
                    (K::evaluate_force(&mut self.force, bodies, *indices, params), Derivatives::None)
                }
                Need::Step { step, factor } => {
                    let (all, known) = &mut self.held;
                    let held = &mut all[at * K::ROWS..][..K::ROWS];
                    if K::ROWS > 0 && !*known {
                        let here = K::evaluate_step(&mut self.step, bodies, *indices, params, step, held);
                        held.copy_from_slice(here.multipliers);
                    }
                    let Linear { force, matrix, multipliers, slopes } =
                        K::evaluate_step(&mut self.step, bodies, *indices, params, step, held);
                    self.linear.extend_from_slice(multipliers);
                    self.linear.extend_from_slice(slopes);
                    (force, Derivatives::Step(matrix, factor))
                }
                Need::Derivatives => {
                    self.kernel.evaluate(bodies, *indices, params);
                    (self.kernel.force(), Derivatives::Apart(self.kernel.dfdx(), self.kernel.dfdv()))
                }
            };
            let local = Local { indices: indices.as_ref(), places, force, derivatives };
            out.add::<K>(bodies, &local);
        }
        self.held.1 |= matches!(need, Need::Step { .. });
    }

    /// Adds rigid rows: Jᵀ times their multipliers as a force, with its derivative; J as rows and columns; and
    /// what J times the solution has to be: −Ċ.
    fn add_rows<const D: usize>(&mut self, bodies: &Bodies<'_, K::Real>, out: &mut Assembly<K::Real, D>) {
        let (pairs, count) = (K::BODIES.len() * K::BODIES.len(), K::BODIES.len());
        let Forces { pull: (force, none), saddle, .. } = self;
        force.resize(K::DOFS, zero());
        none.resize(if out.wants.drift { K::DOFS * K::DOFS } else { 0 }, zero());
        for (at, (params, &indices)) in self.params.iter().zip(&self.indices).enumerate() {
            let held = &self.held.0[at * K::ROWS..][..K::ROWS];
            let Saddle { jacobian, geometric, .. } = K::saddle(saddle, bodies, indices, params, held);
            force.fill(zero());
            for (row, &multiplier) in jacobian.chunks_exact(K::DOFS).zip(held) {
                force.iter_mut().zip(row).for_each(|(sum, &entry)| *sum += entry * multiplier);
            }
            let derivatives = match out.wants {
                Wants { drift: true, .. } => Derivatives::Apart(geometric, none),
                Wants { matrix: true, .. } => Derivatives::Step(geometric, out.stiffness),
                _ => Derivatives::None,
            };
            let places = &self.places[at * pairs..][..pairs];
            let local = Local { indices: indices.as_ref(), places, force, derivatives };
            out.add::<K>(bodies, &local);
            let rows =
                Rows { joint: self.joints[at], jacobian, places: &self.row_places[at * count..][..count] };
            out.add_rows::<K>(bodies, indices.as_ref(), &rows);
        }
        self.held.1 = true;
    }

    fn predict_all<const D: usize>(&mut self, out: &Assembly<K::Real, D>) {
        if self.rigid {
            for (&joint, held) in self.joints.iter().zip(self.held.0.chunks_exact_mut(K::ROWS)) {
                let solution = &out.system.rhs[joint];
                held.iter_mut().zip(solution.iter()).for_each(|(held, &x)| *held -= x / out.damping);
            }
            self.predicted = true;
            return;
        }
        if K::ROWS == 0 || self.linear.is_empty() {
            return;
        }
        self.predicted = true;
        let step = out.stiffness / out.damping;
        let known =
            self.linear.chunks_exact(K::ROWS * (K::DOFS + 1)).zip(self.held.0.chunks_exact_mut(K::ROWS));
        for ((linear, held), indices) in known.zip(&self.indices) {
            let (multipliers, mut slopes) = linear.split_at(K::ROWS);
            for (held, &multiplier) in held.iter_mut().zip(multipliers) {
                let mut change = zero::<K::Real>();
                for (&kind, &index) in K::BODIES.iter().zip(indices.as_ref()) {
                    let (own, rest) = slopes.split_at(kind.dofs());
                    slopes = rest;
                    if let Some(node) = out.nodes[kind as usize][index] {
                        let solution = &out.system.rhs[node];
                        change += own
                            .iter()
                            .zip(solution.iter())
                            .fold(zero::<K::Real>(), |sum, (&a, &x)| sum + a * x);
                    }
                }
                *held = multiplier + change / step;
                if K::ONE_SIDED {
                    *held = held.min(zero::<K::Real>());
                }
            }
        }
    }
}

impl<K: Kernel> Batch<K::Real> for Forces<K> {
    fn assemble(&mut self, bodies: &Bodies<'_, K::Real>, out: Sums<'_, K::Real>) {
        match (out, self.rigid) {
            (Sums::Three(out), false) => self.add_all(bodies, out),
            (Sums::Six(out), false) => self.add_all(bodies, out),
            (Sums::Three(out), true) => self.add_rows(bodies, out),
            (Sums::Six(out), true) => self.add_rows(bodies, out),
        }
    }

    fn has_multipliers(&self) -> bool {
        K::ROWS > 0
    }

    fn is_rigid(&self) -> bool {
        self.rigid
    }

    fn rows(&self) -> usize {
        K::ROWS
    }

    fn in_lanes(&self, lanes: usize) -> Box<dyn Any> {
        lane_batch::empty::<K>(self.rigid, lanes)
    }

    fn is_energy(&self) -> bool {
        K::HAS_POTENTIAL && K::ROWS == 0
    }

    fn begin(&mut self) {
        self.held.0.clone_from(&self.kept.0);
        self.held.1 = self.kept.1;
        if self.rigid && !self.kept.1 {
            self.held.0.fill(zero());
        }
        self.predicted = false;
    }

    fn predict(&mut self, out: Sums<'_, K::Real>) {
        match out {
            Sums::Three(out) => self.predict_all(out),
            Sums::Six(out) => self.predict_all(out),
        }
    }

    fn keep(&mut self) {
        self.kept.1 = self.predicted;
        if self.predicted {
            self.kept.0.copy_from_slice(&self.held.0);
        }
    }

    fn forget(&mut self) {
        self.kept.1 = false;
    }

    fn place(&mut self, block: &dyn Fn((BodyKind, usize), (BodyKind, usize)) -> Option<usize>) {
        self.places.clear();
        for indices in &self.indices {
            let bodies = || K::BODIES.iter().copied().zip(indices.as_ref().iter().copied());
            let pairs = bodies().flat_map(|row| bodies().map(move |column| (row, column)));
            self.places.extend(pairs.map(|(row, column)| block(row, column).map_or(NOWHERE, |at| at as u32)));
        }
    }

    fn place_rows(
        &mut self,
        nodes: Vec<usize>,
        block: &dyn Fn(usize, (BodyKind, usize)) -> Option<[usize; 2]>,
    ) {
        self.row_places.clear();
        for (indices, &node) in self.indices.iter().zip(&nodes) {
            let bodies = K::BODIES.iter().copied().zip(indices.as_ref().iter().copied());
            self.row_places.extend(bodies.map(|body| block(node, body)));
        }
        self.joints = nodes;
    }

    fn measure(&self, bodies: &Bodies<'_, K::Real>) -> Measure<K::Real> {
        let mut sum = Measure::<K::Real>::default();
        if K::HAS_POTENTIAL {
            for (params, indices) in self.params.iter().zip(&self.indices) {
                let one = K::measure(bodies, *indices, params);
                if !self.rigid {
                    sum.energy += one.energy;
                }
                sum.max_violation = sum.max_violation.max(one.max_violation);
            }
        }
        sum
    }

    fn empty(&self) -> Box<dyn Batch<K::Real>> {
        Box::new(Forces::<K>::new(self.rigid))
    }

    fn copy_to(&self, at: usize, other: &mut dyn Batch<K::Real>, body: &dyn Fn(BodyKind, usize) -> usize) {
        let mut indices = self.indices[at];
        for (&kind, index) in K::BODIES.iter().zip(indices.as_mut()) {
            *index = body(kind, *index);
        }
        if let Some(other) = other.as_any_mut().downcast_mut::<Forces<K>>() {
            other.push(self.params[at].clone(), indices, self.entries[at]);
        }
    }

    fn remove(&mut self, at: usize) {
        self.params.swap_remove(at);
        self.indices.swap_remove(at);
        self.entries.swap_remove(at);
        let (kept, last) = (&mut self.kept.0, self.entries.len() * K::ROWS);
        kept.copy_within(last.., at * K::ROWS);
        kept.truncate(last);
    }

    fn entries(&self) -> &[usize] {
        &self.entries
    }

    #[cfg(feature = "serde")]
    fn name(&self) -> &'static str {
        K::NAME
    }

    fn kinds(&self) -> &'static [BodyKind] {
        K::BODIES
    }

    fn indices(&self, at: usize) -> &[usize] {
        self.indices[at].as_ref()
    }

    fn indices_mut(&mut self, at: usize) -> &mut [usize] {
        self.indices[at].as_mut()
    }

    #[cfg(feature = "serde")]
    fn numbers(&self, at: usize) -> Vec<K::Real> {
        let mut numbers = Vec::new();
        K::write_params(&self.params[at], &mut numbers);
        numbers
    }

    #[cfg(feature = "serde")]
    fn multipliers(&self) -> Option<&[K::Real]> {
        (K::ROWS > 0 && self.kept.1).then_some(&self.kept.0)
    }

    #[cfg(feature = "serde")]
    fn set_multipliers(&mut self, multipliers: Vec<K::Real>) -> bool {
        let fits = multipliers.len() == self.entries.len() * K::ROWS;
        if fits {
            self.kept = (multipliers, true);
        }
        fits
    }

    #[cfg(feature = "serde")]
    fn push_numbers(&mut self, numbers: &[K::Real], indices: &[usize], entry: usize) -> bool {
        let mut own = K::Indices::default();
        let mut rest = numbers.iter().copied();
        let params = K::read_params(&mut rest);
        let Some(params) = params.filter(|_| rest.next().is_none() && own.as_ref().len() == indices.len())
        else {
            return false;
        };
        own.as_mut().copy_from_slice(indices);
        self.push(params, own, entry);
        true
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
