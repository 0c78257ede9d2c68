//! Assembly: adds the forces of an island's batches and their derivatives to the system of a step.
//!
//! Input: bodies and the outputs of kernels. Output: f; on request M − hγ D − s K in blocks, K separately, and
//! K v; `inertia` adds the terms of bodies. Kernels compute only the requested outputs. After a failed step a
//! fallback limits the derivatives of each force.

use crate::kernel::{Bodies, BodyKind, Kernel};
use crate::system::block::Block;
use crate::system::sparse::System;
use nalgebra::{DMatrix, RealField, SVector, Vector3, Vector6, convert};

/// The modification of forces whose exact derivatives failed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Fallback<R> {
    /// No modification.
    #[default]
    None,
    /// Symmetrises ∂F/∂X and sets its positive eigenvalues to zero.
    SemiDefinite,
    /// The same, and scales down forces whose stiffness exceeds this limit.
    Capped(R),
}

/// The sums of an assembly.
#[derive(Clone, Debug)]
pub(crate) struct Assembly<R: RealField, const D: usize> {
    /// M − `damping` D − `stiffness` K
    pub(crate) system: System<R, D>,
    /// K alone, in the blocks of the system; empty unless requested.
    pub(crate) tangent: Vec<Block<R, D>>,
    /// F per node.
    pub(crate) force: Vec<SVector<R, D>>,
    /// K v per node.
    pub(crate) drift: Vec<SVector<R, D>>,
    /// The part of K v from kinematic bodies: ∂F/∂t.
    pub(crate) driven: Vec<SVector<R, D>>,
    /// In: the velocity of each node minus the stage's origin. Out: the same as momentum.
    pub(crate) momentum: Vec<SVector<R, D>>,
    /// The node of each rigid body and each particle; `None` for kinematic bodies.
    pub(crate) nodes: [Vec<Option<usize>>; 2],
    /// The factors of D and K in the matrix.
    pub(crate) damping: R,
    pub(crate) stiffness: R,
    /// The requested sums, in addition to F.
    pub(crate) wants: Wants,
    pub(crate) fallback: Fallback<R>,
    /// Joints that close loops; their rows may repeat others.
    pub(crate) closing: Vec<Closing>,
    /// Whether a node is a joint.
    pub(crate) is_joint: Vec<bool>,
    /// The power of forces without potential, loads and kinematic bodies.
    pub(crate) power: R,
    /// The largest factor by which a force was too stiff, over forces that were scaled down.
    pub(crate) capped: R,
    /// Whether a mass is negligible in rounding next to the stiffness on it.
    pub(crate) mass_negligible: bool,
}

/// The requested sums, in addition to F.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Wants {
    /// The matrix; otherwise the blocks keep their values.
    pub(crate) matrix: bool,
    /// The derivatives of gyroscopic torque and rotating inertia.
    pub(crate) exact: bool,
    /// K v.
    pub(crate) drift: bool,
    /// K separately.
    pub(crate) tangent: bool,
    /// Momenta.
    pub(crate) momentum: bool,
    /// Rotating inertia uses the torques that change momenta; forces with multipliers are out of balance.
    pub(crate) held: bool,
}

impl<R: RealField + Copy, const D: usize> Default for Assembly<R, D> {
    fn default() -> Assembly<R, D> {
        Assembly {
            system: System::default(),
            tangent: Vec::new(),
            force: Vec::new(),
            drift: Vec::new(),
            driven: Vec::new(),
            momentum: Vec::new(),
            nodes: [Vec::new(), Vec::new()],
            damping: R::zero(),
            stiffness: R::zero(),
            wants: Wants::default(),
            fallback: Fallback::None,
            closing: Vec::new(),
            is_joint: Vec::new(),
            power: R::zero(),
            capped: R::zero(),
            mass_negligible: false,
        }
    }
}

/// The required results of a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Need<R> {
    /// F
    Force,
    /// F, and h ∂F/∂V + h² ∂F/∂X for this step; `factor` scales it to `damping` ∂F/∂V + `stiffness` ∂F/∂X.
    Step { step: R, factor: R },
    /// F, ∂F/∂X and ∂F/∂V.
    Derivatives,
}

/// The derivatives of a force, row by row.
#[derive(Clone, Copy)]
pub(crate) enum Derivatives<'a, R> {
    None,
    /// A matrix and the factor that makes it `damping` ∂F/∂V + `stiffness` ∂F/∂X.
    Step(&'a [R], R),
    /// ∂F/∂X and ∂F/∂V
    Apart(&'a [R], &'a [R]),
}

/// The results of one force, with the bodies in argument order.
#[derive(Clone, Copy)]
pub(crate) struct Local<'a, R> {
    pub(crate) indices: &'a [usize],
    /// The block positions of the bodies' pairs in the system.
    pub(crate) places: &'a [u32],
    pub(crate) force: &'a [R],
    pub(crate) derivatives: Derivatives<'a, R>,
}

/// The rigid rows of a constraint.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a, R> {
    /// The node of its multipliers.
    pub(crate) joint: usize,
    /// J, row by row.
    pub(crate) jacobian: &'a [R],
    /// The positions of the blocks of each body, in the rows and in its own equations.
    pub(crate) places: &'a [Option<[usize; 2]>],
}

/// A joint that closes a loop: its node, and the bodies' nodes with the positions of their blocks in its rows.
#[derive(Clone, Debug)]
pub(crate) struct Closing {
    pub(crate) joint: usize,
    pub(crate) rows: usize,
    pub(crate) bodies: Vec<(usize, usize)>,
}

/// ε of rows that close loops, relative to what the rows feel of their bodies.
const REGULARIZATION: f64 = 1e-8;

/// Marks a pair without a block in the system.
pub(crate) const NOWHERE: u32 = u32::MAX;

impl<R: RealField + Copy, const D: usize> Assembly<R, D> {
    /// Sets the sums to zero.
    pub(crate) fn clear(&mut self) {
        self.force.fill(SVector::zeros());
        if self.wants.matrix {
            self.system.clear();
            self.mass_negligible = false;
        }
        if self.wants.drift {
            self.drift.fill(SVector::zeros());
            self.driven.fill(SVector::zeros());
        }
        if self.wants.tangent {
            self.tangent.resize(self.system.blocks.len(), Block::zeros());
            self.tangent.fill(Block::zeros());
        }
        self.power = R::zero();
        self.capped = R::zero();
    }

    /// The required results of each force.
    pub(crate) fn need(&self) -> Need<R> {
        let Wants { matrix, drift, tangent, .. } = self.wants;
        if self.fallback != Fallback::None || drift || tangent {
            Need::Derivatives
        } else if !matrix {
            Need::Force
        } else if self.stiffness > R::zero() {
            let step = self.stiffness / self.damping;
            Need::Step { step, factor: self.damping / step }
        } else {
            Need::Derivatives
        }
    }

    /// Adds one force.
    #[inline]
    pub(crate) fn add<K: Kernel<Real = R>>(&mut self, bodies: &Bodies<'_, R>, local: &Local<'_, R>) {
        match (self.fallback, local.derivatives) {
            (Fallback::SemiDefinite, Derivatives::Apart(dfdx, dfdv)) => {
                self.add_modified::<K>(bodies, local, [dfdx, dfdv], None);
            }
            (Fallback::Capped(most), Derivatives::Apart(dfdx, dfdv)) => {
                self.add_modified::<K>(bodies, local, [dfdx, dfdv], Some(most));
            }
            _ => self.add_exact::<K>(bodies, local),
        }
    }

    /// Adds the rows and columns of a joint, and −Ċ as what the rows of the solution have to be.
    pub(crate) fn add_rows<K: Kernel<Real = R>>(
        &mut self,
        bodies: &Bodies<'_, R>,
        indices: &[usize],
        rows: &Rows<'_, R>,
    ) {
        let node = rows.joint;
        self.momentum.get_mut(node).into_iter().for_each(|x| *x = SVector::zeros());
        if self.wants.matrix {
            for i in K::ROWS..D {
                self.system.blocks[node].0[i][i] = R::one();
            }
        }
        let mut column = 0;
        for ((&kind, &index), place) in K::BODIES.iter().zip(indices).zip(rows.places) {
            let velocity = velocity(bodies, kind, index);
            for i in 0..K::ROWS {
                let row = &rows.jacobian[i * K::DOFS + column..][..kind.dofs()];
                let rate = row.iter().zip(velocity.iter()).fold(R::zero(), |sum, (&j, &v)| sum + j * v);
                self.force[node][i] -= rate / self.damping;
                if let Some([own, across]) = place.filter(|_| self.wants.matrix) {
                    for (j, &entry) in row.iter().enumerate() {
                        self.system.blocks[own].0[i][j] += entry;
                        self.system.blocks[across].0[j][i] += entry;
                    }
                }
            }
            column += kind.dofs();
        }
    }

    /// Gives rows that close loops a pivot, after all else.
    pub(crate) fn regularize(&mut self) {
        let blocks = &mut self.system.blocks;
        for Closing { joint, rows, bodies } in &self.closing {
            for i in 0..*rows {
                let felt = bodies.iter().fold(R::zero(), |sum, &(body, place)| {
                    let each = (0..D).map(|j| blocks[place].0[i][j].powi(2) / blocks[body].0[j][j].abs());
                    each.fold(sum, |sum, x| sum + x)
                });
                blocks[*joint].0[i][i] -= felt * convert(REGULARIZATION);
            }
        }
    }

    fn add_modified<K: Kernel<Real = R>>(
        &mut self,
        bodies: &Bodies<'_, R>,
        local: &Local<'_, R>,
        [dfdx, dfdv]: [&[R]; 2],
        most: Option<R>,
    ) {
        let order = K::DOFS;
        let mut dfdx = semi_definite(dfdx, order);
        let (mut dfdv, mut force) = (dfdv.to_vec(), local.force.to_vec());
        let largest = dfdx.iter().fold(R::zero(), |most, x| most.max(x.abs()));
        if let Some(most) = most.filter(|&most| largest > most) {
            let scale = most / largest;
            self.capped = self.capped.max(R::one() / scale);
            for numbers in [&mut dfdx, &mut dfdv, &mut force] {
                numbers.iter_mut().for_each(|x| *x *= scale);
            }
        }
        let derivatives = Derivatives::Apart(&dfdx, &dfdv);
        self.add_exact::<K>(bodies, &Local { force: &force, derivatives, ..*local });
    }

    #[inline]
    fn add_exact<K: Kernel<Real = R>>(&mut self, bodies: &Bodies<'_, R>, local: &Local<'_, R>) {
        let order = K::DOFS;
        let count = K::BODIES.len();
        let mut row = 0;
        for (i, (&kind, &index)) in K::BODIES.iter().zip(local.indices).enumerate() {
            let height = kind.dofs();
            let node = self.nodes[kind as usize][index];
            if !K::HAS_POTENTIAL || node.is_none() {
                let velocity = velocity(bodies, kind, index);
                let power = (0..height).fold(R::zero(), |sum, k| sum + local.force[row + k] * velocity[k]);
                // A kinematic body supplies the power that the force takes from it.
                match node {
                    Some(_) => self.power += power,
                    None if K::HAS_POTENTIAL => self.power -= power,
                    None => {}
                }
            }
            let Some(node) = node else {
                row += height;
                continue;
            };
            for (sum, &force) in self.force[node].iter_mut().zip(&local.force[row..][..height]) {
                *sum += force;
            }
            if self.wants.drift {
                self.add_drift::<K>(bodies, local, node, row, i);
            }
            if matches!(local.derivatives, Derivatives::None) {
                row += height;
                continue;
            }
            let mut column = 0;
            for (&other, &place) in K::BODIES.iter().zip(&local.places[i * count..]) {
                if place != NOWHERE {
                    let block = (place as usize, row * order + column);
                    match (kind, other) {
                        (BodyKind::Rigid, BodyKind::Rigid) => self.add_block::<6, 6>(block, order, local),
                        (BodyKind::Rigid, BodyKind::Particle) => self.add_block::<6, 3>(block, order, local),
                        (BodyKind::Particle, BodyKind::Rigid) => self.add_block::<3, 6>(block, order, local),
                        (BodyKind::Particle, BodyKind::Particle) => {
                            self.add_block::<3, 3>(block, order, local)
                        }
                    }
                }
                column += other.dofs();
            }
            row += height;
        }
    }

    /// Adds a body's rows of K v.
    fn add_drift<K: Kernel<Real = R>>(
        &mut self,
        bodies: &Bodies<'_, R>,
        local: &Local<'_, R>,
        node: usize,
        row: usize,
        i: usize,
    ) {
        let Derivatives::Apart(dfdx, _) = local.derivatives else { return };
        let (order, count) = (K::DOFS, K::BODIES.len());
        let mut column = 0;
        for (j, (&other, &index)) in K::BODIES.iter().zip(local.indices).enumerate() {
            let velocity = velocity(bodies, other, index);
            for k in 0..K::BODIES[i].dofs() {
                let entries = &dfdx[(row + k) * order + column..][..other.dofs()];
                let sum = entries.iter().zip(velocity.iter()).fold(R::zero(), |sum, (&k, &v)| sum + k * v);
                self.drift[node][k] += sum;
                if local.places[i * count + j] == NOWHERE {
                    self.driven[node][k] += sum;
                }
            }
            column += other.dofs();
        }
    }

    /// Adds the block at an entry of the kernel's matrix.
    #[inline]
    fn add_block<const HEIGHT: usize, const WIDTH: usize>(
        &mut self,
        (place, at): (usize, usize),
        order: usize,
        local: &Local<'_, R>,
    ) {
        let from = (at, order, HEIGHT.min(D));
        match local.derivatives {
            Derivatives::None => {}
            Derivatives::Step(matrix, factor) => {
                for (sums, row) in self.system.blocks[place].0.iter_mut().zip(rows::<R, WIDTH>(matrix, from))
                {
                    add_row(sums, row, -factor);
                }
            }
            Derivatives::Apart(dfdx, dfdv) => {
                let rates = rows::<R, WIDTH>(dfdx, from).zip(rows::<R, WIDTH>(dfdv, from));
                if self.wants.matrix {
                    for (sums, (dfdx, dfdv)) in self.system.blocks[place].0.iter_mut().zip(rates) {
                        add_row(sums, dfdv, -self.damping);
                        add_row(sums, dfdx, -self.stiffness);
                    }
                }
                if self.wants.tangent {
                    for (sums, row) in self.tangent[place].0.iter_mut().zip(rows::<R, WIDTH>(dfdx, from)) {
                        add_row(sums, row, R::one());
                    }
                }
            }
        }
    }
}

/// The rows of a block that begins at an entry, in a matrix with `order` columns.
#[inline(always)]
fn rows<R, const WIDTH: usize>(
    matrix: &[R],
    (at, order, height): (usize, usize, usize),
) -> impl Iterator<Item = &[R; WIDTH]> {
    (0..height).filter_map(move |i| matrix[at + i * order..].first_chunk())
}

/// Adds the first entries of a row; reads all sums before writing any.
#[inline(always)]
fn add_row<R: RealField + Copy, const D: usize, const WIDTH: usize>(
    sums: &mut [R; D],
    row: &[R; WIDTH],
    factor: R,
) {
    let (mut all, row) = (*sums, *row);
    for (sum, entry) in all.iter_mut().zip(row) {
        *sum += factor * entry;
    }
    *sums = all;
}

/// The symmetric part of a row-major matrix, with positive eigenvalues set to zero.
fn semi_definite<R: RealField + Copy>(matrix: &[R], order: usize) -> Vec<R> {
    let half = convert::<f64, R>(0.5);
    let symmetric =
        DMatrix::from_fn(order, order, |i, j| (matrix[i * order + j] + matrix[j * order + i]) * half);
    if !symmetric.iter().all(|x| x.is_finite()) {
        return matrix.to_vec();
    }
    let mut eigen = symmetric.symmetric_eigen();
    eigen.eigenvalues.iter_mut().for_each(|value| *value = value.min(R::zero()));
    eigen.recompose().transpose().as_slice().to_vec()
}

fn velocity<R: RealField + Copy>(bodies: &Bodies<'_, R>, kind: BodyKind, index: usize) -> Vector6<R> {
    let (v, w) = match kind {
        BodyKind::Rigid => (bodies.rigid[index].velocity, bodies.rigid[index].angular_velocity),
        BodyKind::Particle => (bodies.particles[index].velocity, Vector3::zeros()),
    };
    Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
}
