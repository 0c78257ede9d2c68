//! Forces of one kernel, side by side.
//!
//! A batch holds parameters and bodies of all forces of one kernel; behind the trait its type is forgotten. Assembling
//! evaluates them one after the other and adds what they give to the system of the step.

use crate::kernel::{Bodies, BodyKind, Kernel};
use crate::system::System;
use nalgebra::{RealField, Vector6};
use std::any::Any;

/// What assembly of a step adds up.
#[derive(Clone, Debug)]
pub(crate) struct Assembly<R: RealField> {
    /// (M − `damping` ∂F/∂V − `stiffness` ∂F/∂X) x = …
    pub(crate) system: System<R>,
    /// F of each node.
    pub(crate) force: Vec<Vector6<R>>,
    /// ∂F/∂X v of each node.
    pub(crate) drift: Vec<Vector6<R>>,
    /// The node of each rigid body and each particle; none if it is not moved by forces.
    pub(crate) nodes: [Vec<Option<usize>>; 2],
    pub(crate) damping: R,
    pub(crate) stiffness: R,
}

impl<R: RealField + Copy> Default for Assembly<R> {
    fn default() -> Assembly<R> {
        let zero = R::zero();
        Assembly {
            system: System::default(),
            force: Vec::new(),
            drift: Vec::new(),
            nodes: [Vec::new(), Vec::new()],
            damping: zero,
            stiffness: zero,
        }
    }
}

/// Forces of a kernel that only the batch itself knows.
pub(crate) trait Batch<R: RealField>: Send {
    fn assemble(&mut self, bodies: &Bodies<'_, R>, out: &mut Assembly<R>);
    fn remove(&mut self, at: usize);
    fn len(&self) -> usize;
    fn kinds(&self) -> &'static [BodyKind];
    fn indices(&self, at: usize) -> &[usize];
    fn as_any(&mut self) -> &mut dyn Any;
}

pub(crate) struct Forces<K: Kernel> {
    kernel: K,
    pub(crate) params: Vec<K::Params>,
    indices: Vec<K::Indices>,
}

impl<K: Kernel> Forces<K> {
    pub(crate) fn new() -> Forces<K> {
        Forces { kernel: K::default(), params: Vec::new(), indices: Vec::new() }
    }

    pub(crate) fn push(&mut self, params: K::Params, indices: K::Indices) {
        self.params.push(params);
        self.indices.push(indices);
    }
}

impl<K: Kernel> Batch<K::Real> for Forces<K> {
    fn assemble(&mut self, bodies: &Bodies<'_, K::Real>, out: &mut Assembly<K::Real>) {
        let order = K::FREEDOMS;
        for (params, &indices) in self.params.iter().zip(&self.indices) {
            self.kernel.evaluate(bodies, indices, params);
            let (force, dfdx, dfdv) = (self.kernel.force(), self.kernel.dfdx(), self.kernel.dfdv());
            let mut row = 0;
            for (&kind, &index) in K::BODIES.iter().zip(indices.as_ref()) {
                let height = kind.freedoms();
                let Some(node) = out.nodes[kind as usize][index] else {
                    row += height;
                    continue;
                };
                for i in 0..height {
                    out.force[node][i] += force[row + i];
                }
                let mut column = 0;
                for (&other, &index) in K::BODIES.iter().zip(indices.as_ref()) {
                    let width = other.freedoms();
                    let velocity = velocity(bodies, other, index);
                    for i in 0..height {
                        let at = (row + i) * order + column;
                        for (j, &dx) in dfdx[at..at + width].iter().enumerate() {
                            out.drift[node][i] += dx * velocity[j];
                        }
                    }
                    if let Some(right) = out.nodes[other as usize][index] {
                        let block = out.system.block(node, right);
                        for i in 0..height {
                            let at = (row + i) * order + column;
                            for j in 0..width {
                                block[(i, j)] -= out.damping * dfdv[at + j] + out.stiffness * dfdx[at + j];
                            }
                        }
                    }
                    column += width;
                }
                row += height;
            }
        }
    }

    fn remove(&mut self, at: usize) {
        self.params.swap_remove(at);
        self.indices.swap_remove(at);
    }

    fn len(&self) -> usize {
        self.params.len()
    }

    fn kinds(&self) -> &'static [BodyKind] {
        K::BODIES
    }

    fn indices(&self, at: usize) -> &[usize] {
        self.indices[at].as_ref()
    }

    fn as_any(&mut self) -> &mut dyn Any {
        self
    }
}

fn velocity<R: RealField + Copy>(bodies: &Bodies<'_, R>, kind: BodyKind, index: usize) -> Vector6<R> {
    let (v, w) = match kind {
        BodyKind::Rigid => (bodies.rigid[index].velocity, bodies.rigid[index].angular_velocity),
        BodyKind::Particle => (bodies.particles[index].velocity, nalgebra::Vector3::zeros()),
    };
    Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
}
