//! Forces of one kernel in L islands of equal structure, evaluated in lanes.
//!
//! In: bodies in lanes. Out: generalised forces, added to a vector; for rigid rows J in a matrix, and C, Ċ or
//! what J V̇ has to be in the vector. The trait hides the kernel's type.

use crate::kernel::{BodiesLanes, BodyKind, Kernel, Rows};
use crate::system::batch::{Batch, Forces};
use crate::system::lanes::{Lanes, Operation, wide};
use crate::system::plan::{Place, Plan};
use nalgebra::{RealField, zero};
use std::any::Any;

/// What is computed of rigid rows, into the rows of a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// J into the matrix, and minus the drift, which J V̇ has to be.
    Saddle,
    /// C.
    Value,
    /// Ċ = J V.
    Rate,
    /// Ċ of kinematic bodies alone, times what is there.
    Driven,
}

/// The forces of a kernel in L islands.
pub(crate) trait LaneBatch<R: RealField + Copy, const L: usize>: Send {
    /// Adds F to the entries of bodies; nothing for rigid rows. Returns the power of forces without
    /// potential, and, if kinematic bodies move, of these on the others.
    fn add_forces(
        &mut self,
        bodies: &BodiesLanes<'_, R, L>,
        vector: &mut [Lanes<R, L>],
        driven: bool,
        arch: pulp::Arch,
    ) -> Lanes<R, L>;
    /// Computes rows; nothing for other forces.
    fn rows(&mut self, row: Row, bodies: &BodiesLanes<'_, R, L>, out: RowSums<'_, R, L>, arch: pulp::Arch);
    /// The sum of the rows of a vector.
    fn sum(&self, vector: &[Lanes<R, L>]) -> Lanes<R, L>;
    /// Whether these are rigid rows.
    fn is_rigid(&self) -> bool;
    /// Reads the parameters of the batches of L islands, of this kernel and of equal structure.
    fn gather(&mut self, each: &[&dyn Batch<R>; L]);
    /// Whether the matrix has to be cleared before J is written.
    fn adds(&self) -> bool;
    /// Where the entries of each force are; `joint` is the first joint of the batch.
    fn place(&mut self, plan: &Plan, nodes: &[Vec<Option<usize>>; 2], joint: usize);
}

/// The matrix, and the vector whose rows are set.
pub(crate) struct RowSums<'a, R, const L: usize> {
    pub(crate) matrix: &'a mut [Lanes<R, L>],
    pub(crate) vector: &'a mut [Lanes<R, L>],
}

pub(crate) struct LaneForces<K: Kernel, const L: usize> {
    rigid: bool,
    indices: Vec<K::Indices>,
    params: Vec<K::LaneParams<L>>,
    row_params: Vec<K::RowParams<L>>,
    force: K::LaneForce<L>,
    rows: K::LaneRows<L>,
    /// Where the entries of each body are in vectors, for each force; `None` for kinematic bodies.
    bodies: Vec<Option<usize>>,
    /// Where the rows of each force are in vectors.
    joints: Vec<usize>,
    /// Where the rows meet each body in the matrix.
    blocks: Vec<Option<Place>>,
    /// Whether a force may act twice on a body.
    doubled: bool,
}

impl<K: Kernel, const L: usize> LaneForces<K, L> {
    pub(crate) fn new(rigid: bool) -> LaneForces<K, L> {
        LaneForces {
            rigid,
            indices: Vec::new(),
            params: Vec::new(),
            row_params: Vec::new(),
            force: K::LaneForce::default(),
            rows: K::LaneRows::default(),
            bodies: Vec::new(),
            joints: Vec::new(),
            blocks: Vec::new(),
            doubled: false,
        }
    }
}

impl<K: Kernel, const L: usize> LaneBatch<K::Real, L> for LaneForces<K, L> {
    fn add_forces(
        &mut self,
        bodies: &BodiesLanes<'_, K::Real, L>,
        vector: &mut [Lanes<K::Real, L>],
        driven: bool,
        arch: pulp::Arch,
    ) -> Lanes<K::Real, L> {
        if self.rigid {
            return Lanes::all(zero());
        }
        wide::<K::Real, L, _>(arch, AddForces { forces: self, bodies, vector, driven })
    }

    fn rows(
        &mut self,
        row: Row,
        bodies: &BodiesLanes<'_, K::Real, L>,
        out: RowSums<'_, K::Real, L>,
        arch: pulp::Arch,
    ) {
        if self.rigid {
            wide::<K::Real, L, _>(arch, AddRows { forces: self, row, bodies, out });
        }
    }

    fn is_rigid(&self) -> bool {
        self.rigid
    }

    fn sum(&self, vector: &[Lanes<K::Real, L>]) -> Lanes<K::Real, L> {
        let rows = self.joints.iter().flat_map(|&joint| &vector[joint..joint + K::ROWS]);
        rows.fold(Lanes::all(zero()), |sum, x| sum + *x)
    }

    fn adds(&self) -> bool {
        self.rigid && self.doubled
    }

    fn gather(&mut self, each: &[&dyn Batch<K::Real>; L]) {
        let each: Option<Vec<&Forces<K>>> =
            each.iter().map(|batch| (*batch).as_any().downcast_ref::<Forces<K>>()).collect();
        let Some(each) = each else { return };
        let at = |k: usize| std::array::from_fn(|lane| &each[lane].params[k]);
        let count = each[0].params.len();
        self.indices.clone_from(&each[0].indices);
        if self.rigid {
            self.row_params = (0..count).map(|k| K::gather_row_params(at(k))).collect();
        } else {
            self.params = (0..count).map(|k| K::gather_params(at(k))).collect();
        }
    }

    fn place(&mut self, plan: &Plan, nodes: &[Vec<Option<usize>>; 2], joint: usize) {
        let rigid = self.rigid;
        let count = self.indices.len();
        self.joints =
            if rigid { (joint..joint + count).map(|k| plan.joint(k)).collect() } else { Vec::new() };
        (self.bodies, self.blocks, self.doubled) = (Vec::new(), Vec::new(), false);
        for (k, indices) in self.indices.iter().enumerate() {
            let twice = |k: usize| indices.as_ref()[..k].contains(&indices.as_ref()[k]);
            self.doubled |= (0..K::BODIES.len()).any(twice);
            for (&kind, &index) in K::BODIES.iter().zip(indices.as_ref()) {
                let node = nodes[kind as usize][index];
                self.bodies.push(node.map(|node| plan.body(node)));
                self.blocks.push(node.filter(|_| rigid).map(|node| plan.jacobian(joint + k, node)));
            }
        }
    }
}

struct AddForces<'a, K: Kernel, const L: usize> {
    forces: &'a mut LaneForces<K, L>,
    bodies: &'a BodiesLanes<'a, K::Real, L>,
    vector: &'a mut [Lanes<K::Real, L>],
    driven: bool,
}

impl<K: Kernel, const L: usize> Operation for AddForces<'_, K, L> {
    type Output = Lanes<K::Real, L>;

    #[inline(always)]
    fn run(self) -> Lanes<K::Real, L> {
        let AddForces { forces, bodies, vector, driven } = self;
        let LaneForces { indices, params, force, bodies: places, .. } = forces;
        let mut power = Lanes::all(zero());
        for ((&indices, params), places) in
            indices.iter().zip(params).zip(places.chunks_exact(K::BODIES.len()))
        {
            let mut rest = K::force_lanes(force, bodies, indices, params);
            for ((&kind, place), &index) in K::BODIES.iter().zip(places).zip(indices.as_ref()) {
                let (own, after) = rest.split_at(kind.dofs());
                rest = after;
                if let Some(place) = *place {
                    for (sum, force) in vector[place..].iter_mut().zip(own) {
                        *sum += Lanes(*force);
                    }
                    if !K::HAS_POTENTIAL {
                        power += along(bodies, kind, index, own);
                    }
                } else if K::HAS_POTENTIAL && driven {
                    power -= along(bodies, kind, index, own);
                }
            }
        }
        power
    }
}

struct AddRows<'a, K: Kernel, const L: usize> {
    forces: &'a mut LaneForces<K, L>,
    row: Row,
    bodies: &'a BodiesLanes<'a, K::Real, L>,
    out: RowSums<'a, K::Real, L>,
}

impl<K: Kernel, const L: usize> Operation for AddRows<'_, K, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let AddRows { forces, row, bodies, out } = self;
        let LaneForces { indices, row_params, rows, joints, blocks, doubled, .. } = forces;
        let each = indices.iter().zip(&*row_params).zip(&*joints).zip(blocks.chunks_exact(K::BODIES.len()));
        for (((&indices, params), &joint), blocks) in each {
            let Rows { value, jacobian, drift } = K::rows_lanes(rows, bodies, indices, params);
            let vector = &mut out.vector[joint..joint + K::ROWS];
            match row {
                Row::Value => vector.iter_mut().zip(value).for_each(|(x, value)| *x = Lanes(*value)),
                Row::Saddle => {
                    vector.iter_mut().zip(drift).for_each(|(x, drift)| *x = -Lanes(*drift));
                    let mut column = 0;
                    for (kind, place) in K::BODIES.iter().zip(blocks) {
                        if let Some(place) = *place {
                            add_block::<K, L>(out.matrix, place, &jacobian[column..], kind.dofs(), *doubled);
                        }
                        column += kind.dofs();
                    }
                }
                Row::Driven => {
                    for (x, row) in vector.iter_mut().zip(jacobian.chunks_exact(K::DOFS)) {
                        *x = *x * rate::<K, L>(bodies, indices, row, |k| blocks[k].is_none());
                    }
                }
                Row::Rate => {
                    for (x, row) in vector.iter_mut().zip(jacobian.chunks_exact(K::DOFS)) {
                        *x = rate::<K, L>(bodies, indices, row, |_| true);
                    }
                }
            }
        }
    }
}

/// Sets the rows of J of one body, or adds them; `jacobian` begins at its first column.
#[inline(always)]
fn add_block<K: Kernel, const L: usize>(
    matrix: &mut [Lanes<K::Real, L>],
    place: Place,
    jacobian: &[[K::Real; L]],
    dofs: usize,
    adds: bool,
) {
    let block = &mut matrix[place.at..place.at + K::ROWS * dofs];
    for i in 0..K::ROWS {
        for j in 0..dofs {
            let at = if place.transposed { j * K::ROWS + i } else { i * dofs + j };
            let entry = Lanes(jacobian[i * K::DOFS + j]);
            block[at] = if adds { block[at] + entry } else { entry };
        }
    }
}

/// A row of J times V, of all bodies or of the kinematic ones.
#[inline(always)]
fn rate<K: Kernel, const L: usize>(
    bodies: &BodiesLanes<'_, K::Real, L>,
    indices: K::Indices,
    row: &[[K::Real; L]],
    of: impl Fn(usize) -> bool,
) -> Lanes<K::Real, L> {
    let (mut sum, mut rest) = (Lanes::all(zero()), row);
    for (k, (&kind, &index)) in K::BODIES.iter().zip(indices.as_ref()).enumerate() {
        let (own, after) = rest.split_at(kind.dofs());
        rest = after;
        if of(k) {
            sum += along(bodies, kind, index, own);
        }
    }
    sum
}

/// The product of a body's velocity and a row of its coordinates.
#[inline(always)]
fn along<R: RealField + Copy, const L: usize>(
    bodies: &BodiesLanes<'_, R, L>,
    kind: BodyKind,
    index: usize,
    row: &[[R; L]],
) -> Lanes<R, L> {
    let product = |row: &[[R; L]], velocity: &[[R; L]; 3]| {
        Lanes(row[0]) * Lanes(velocity[0])
            + Lanes(row[1]) * Lanes(velocity[1])
            + Lanes(row[2]) * Lanes(velocity[2])
    };
    match kind {
        BodyKind::Rigid => {
            let body = &bodies.rigid[index];
            product(row, &body.velocity) + product(&row[3..], &body.angular_velocity)
        }
        BodyKind::Particle => product(row, &bodies.particles[index].velocity),
    }
}

/// An empty batch in lanes, a `Box<dyn LaneBatch<R, L>>` for this L, to be downcast.
pub(crate) fn empty<K: Kernel>(rigid: bool, lanes: usize) -> Box<dyn Any> {
    type Boxed<R, const L: usize> = Box<dyn LaneBatch<R, L>>;
    match lanes {
        1 => Box::new(Box::new(LaneForces::<K, 1>::new(rigid)) as Boxed<K::Real, 1>),
        2 => Box::new(Box::new(LaneForces::<K, 2>::new(rigid)) as Boxed<K::Real, 2>),
        4 => Box::new(Box::new(LaneForces::<K, 4>::new(rigid)) as Boxed<K::Real, 4>),
        _ => Box::new(Box::new(LaneForces::<K, 8>::new(rigid)) as Boxed<K::Real, 8>),
    }
}
