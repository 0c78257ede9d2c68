//! Forces of one kernel, side by side.
//!
//! A batch holds parameters and bodies of all forces of one kernel in an island; behind the trait its type is forgotten.
//! Assembling evaluates them one after the other, no more of each than is needed, and adds what they give to the system of
//! the step.

use crate::assemble::{Assembly, Derivatives, Local, NOWHERE, Need};
use crate::kernel::{Bodies, BodyKind, Kernel, Measure};
use nalgebra::RealField;
use std::any::Any;

/// Where a batch adds to: particles alone take blocks of 3 × 3.
pub(crate) enum Sums<'a, R: RealField> {
    Three(&'a mut Assembly<R, 3>),
    Six(&'a mut Assembly<R, 6>),
}

/// Forces of a kernel that only the batch itself knows.
pub(crate) trait Batch<R: RealField>: Send {
    fn assemble(&mut self, bodies: &Bodies<'_, R>, out: Sums<'_, R>);
    /// Finds anew where blocks lie.
    fn place(&mut self, block: &dyn Fn((BodyKind, usize), (BodyKind, usize)) -> Option<usize>);
    /// Energy of all, and the largest gap.
    fn measure(&self, bodies: &Bodies<'_, R>) -> Measure<R>;
    /// A batch of the same kernel without forces.
    fn empty(&self) -> Box<dyn Batch<R>>;
    /// Appends a copy of a force to a batch of the same kernel, its bodies renumbered.
    fn copy_to(&self, at: usize, other: &mut dyn Batch<R>, body: &dyn Fn(BodyKind, usize) -> usize);
    /// Removes a force; the last one takes its place.
    fn remove(&mut self, at: usize);
    /// The handles' entries of the forces, in order.
    fn entries(&self) -> &[usize];
    #[cfg(feature = "serde")]
    fn name(&self) -> &'static str;
    fn kinds(&self) -> &'static [BodyKind];
    fn indices(&self, at: usize) -> &[usize];
    fn indices_mut(&mut self, at: usize) -> &mut [usize];
    /// The parameters of a force.
    #[cfg(feature = "serde")]
    fn numbers(&self, at: usize) -> Vec<R>;
    /// Appends a force by its parameters; whether there were as many as it takes.
    #[cfg(feature = "serde")]
    fn push_numbers(&mut self, numbers: &[R], indices: &[usize], entry: usize) -> bool;
    fn as_any(&self) -> &dyn Any;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

pub(crate) struct Forces<K: Kernel> {
    kernel: K,
    force: K::Force,
    step: K::Step,
    pub(crate) params: Vec<K::Params>,
    indices: Vec<K::Indices>,
    entries: Vec<usize>,
    /// For each force a place for each pair of its bodies.
    places: Vec<u32>,
}

impl<K: Kernel> Default for Forces<K> {
    fn default() -> Forces<K> {
        Forces {
            kernel: K::default(),
            force: K::Force::default(),
            step: K::Step::default(),
            params: Vec::new(),
            indices: Vec::new(),
            entries: Vec::new(),
            places: Vec::new(),
        }
    }
}

impl<K: Kernel> Forces<K> {
    pub(crate) fn push(&mut self, params: K::Params, indices: K::Indices, entry: usize) {
        self.params.push(params);
        self.indices.push(indices);
        self.entries.push(entry);
    }

    fn add_all<const D: usize>(&mut self, bodies: &Bodies<'_, K::Real>, out: &mut Assembly<K::Real, D>) {
        let pairs = K::BODIES.len() * K::BODIES.len();
        let need = out.need();
        let forces = self.params.iter().zip(&self.indices).zip(self.places.chunks_exact(pairs));
        for ((params, indices), places) in forces {
            let (force, derivatives) = match need {
                Need::Force => {
                    (K::evaluate_force(&mut self.force, bodies, *indices, params), Derivatives::None)
                }
                Need::Step { step, factor } => {
                    let (force, matrix) = K::evaluate_step(&mut self.step, bodies, *indices, params, step);
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
    }
}

impl<K: Kernel> Batch<K::Real> for Forces<K> {
    fn assemble(&mut self, bodies: &Bodies<'_, K::Real>, out: Sums<'_, K::Real>) {
        match out {
            Sums::Three(out) => self.add_all(bodies, out),
            Sums::Six(out) => self.add_all(bodies, out),
        }
    }

    fn place(&mut self, block: &dyn Fn((BodyKind, usize), (BodyKind, usize)) -> Option<usize>) {
        self.places.clear();
        for indices in &self.indices {
            let bodies = || K::BODIES.iter().copied().zip(indices.as_ref().iter().copied());
            let pairs = bodies().flat_map(|row| bodies().map(move |column| (row, column)));
            self.places.extend(pairs.map(|(row, column)| block(row, column).map_or(NOWHERE, |at| at as u32)));
        }
    }

    fn measure(&self, bodies: &Bodies<'_, K::Real>) -> Measure<K::Real> {
        let mut sum = Measure::<K::Real>::default();
        if K::HAS_POTENTIAL {
            for (params, indices) in self.params.iter().zip(&self.indices) {
                let one = K::measure(bodies, *indices, params);
                sum.energy += one.energy;
                sum.gap = sum.gap.max(one.gap);
            }
        }
        sum
    }

    fn empty(&self) -> Box<dyn Batch<K::Real>> {
        Box::new(Forces::<K>::default())
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
