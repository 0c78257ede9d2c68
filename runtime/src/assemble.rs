//! Assembly: forces and derivatives of an island's batches and bodies, added up into the system of a step.
//!
//! In go bodies and what kernels give; out come f, M − hγ D − s K in blocks, where asked for K apart from it and K v. Where
//! a step has failed, a guard tames the derivatives of each force before they are added.

use crate::bodies::Rigid;
use crate::kernel::{Bodies, BodyKind};
use crate::sparse::System;
use crate::store::Store;
use nalgebra::{DMatrix, Matrix3, RealField, SMatrix, SVector, Vector3, Vector6, convert};

/// What is done to a force whose exact derivatives led nowhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Guard<R> {
    /// Nothing.
    #[default]
    None,
    /// ∂F/∂X is made symmetric, and its positive eigenvalues zero.
    SemiDefinite,
    /// The same, and a force whose stiffness exceeds this much is scaled down to it.
    Capped(R),
}

/// What assembly of a step adds up.
#[derive(Clone, Debug)]
pub(crate) struct Assembly<R: RealField, const D: usize> {
    /// M − `damping` D − `stiffness` K
    pub(crate) system: System<R, D>,
    /// K apart, block by block as in the system; empty unless a method asks for it.
    pub(crate) tangent: Vec<SMatrix<R, D, D>>,
    /// F of each node.
    pub(crate) force: Vec<SVector<R, D>>,
    /// K v of each node.
    pub(crate) drift: Vec<SVector<R, D>>,
    /// What of K v comes from bodies that no force moves: the rate of F by time.
    pub(crate) driven: Vec<SVector<R, D>>,
    /// In goes how much faster each node is than where a stage started from, out comes that in momentum.
    pub(crate) lag: Vec<SVector<R, D>>,
    /// The node of each rigid body and each particle; none if it is not moved by forces.
    pub(crate) nodes: [Vec<Option<usize>>; 2],
    /// Factors of D and K in the matrix.
    pub(crate) damping: R,
    pub(crate) stiffness: R,
    /// What to do beside the forces.
    pub(crate) wants: Wants,
    pub(crate) guard: Guard<R>,
    /// Work by time of what has no potential: forces, loads and bodies that are moved.
    pub(crate) power: R,
    /// How many times too stiff a force was, of those that were scaled down.
    pub(crate) capped: R,
    /// Whether a mass is lost in rounding beside the stiffness that holds it.
    pub(crate) swamped: bool,
}

/// What of an assembly is wanted beside f and the matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Wants {
    /// The derivatives of gyroscopic torque and turning inertia.
    pub(crate) exact: bool,
    /// K v.
    pub(crate) drift: bool,
    /// K apart.
    pub(crate) tangent: bool,
    /// Momenta.
    pub(crate) lag: bool,
}

impl<R: RealField + Copy, const D: usize> Default for Assembly<R, D> {
    fn default() -> Assembly<R, D> {
        Assembly {
            system: System::default(),
            tangent: Vec::new(),
            force: Vec::new(),
            drift: Vec::new(),
            driven: Vec::new(),
            lag: Vec::new(),
            nodes: [Vec::new(), Vec::new()],
            damping: R::zero(),
            stiffness: R::zero(),
            wants: Wants::default(),
            guard: Guard::None,
            power: R::zero(),
            capped: R::zero(),
            swamped: false,
        }
    }
}

/// Force and derivatives of one force, the bodies in argument order.
pub(crate) struct Local<'a, R> {
    pub(crate) kinds: &'static [BodyKind],
    pub(crate) indices: &'a [usize],
    /// Where the blocks of the bodies' pairs lie in the system.
    pub(crate) places: &'a [u32],
    pub(crate) force: &'a [R],
    pub(crate) dfdx: &'a [R],
    pub(crate) dfdv: &'a [R],
    pub(crate) has_potential: bool,
}

/// Stands for a block that is in no system.
pub(crate) const NOWHERE: u32 = u32::MAX;

impl<R: RealField + Copy, const D: usize> Assembly<R, D> {
    /// Empties the sums.
    pub(crate) fn clear(&mut self) {
        self.system.clear();
        for vectors in [&mut self.force, &mut self.drift, &mut self.driven] {
            vectors.fill(SVector::zeros());
        }
        if self.wants.tangent {
            self.tangent.resize(self.system.blocks.len(), SMatrix::zeros());
            self.tangent.fill(SMatrix::zeros());
        }
        self.power = R::zero();
        self.capped = R::zero();
        self.swamped = false;
    }

    /// Adds one force.
    #[inline]
    pub(crate) fn add(&mut self, bodies: &Bodies<'_, R>, local: &Local<'_, R>) {
        match self.guard {
            Guard::None => self.add_exact(bodies, local),
            Guard::SemiDefinite => self.add_guarded(bodies, local, None),
            Guard::Capped(most) => self.add_guarded(bodies, local, Some(most)),
        }
    }

    fn add_guarded(&mut self, bodies: &Bodies<'_, R>, local: &Local<'_, R>, most: Option<R>) {
        let order = local.force.len();
        let mut dfdx = semi_definite(local.dfdx, order);
        let (mut dfdv, mut force) = (local.dfdv.to_vec(), local.force.to_vec());
        let largest = dfdx.iter().fold(R::zero(), |most, x| most.max(x.abs()));
        if let Some(most) = most.filter(|&most| largest > most) {
            let scale = most / largest;
            self.capped = self.capped.max(R::one() / scale);
            for numbers in [&mut dfdx, &mut dfdv, &mut force] {
                numbers.iter_mut().for_each(|x| *x *= scale);
            }
        }
        self.add_exact(bodies, &Local { force: &force, dfdx: &dfdx, dfdv: &dfdv, ..*local });
    }

    #[inline]
    fn add_exact(&mut self, bodies: &Bodies<'_, R>, local: &Local<'_, R>) {
        let order = local.force.len();
        let count = local.kinds.len();
        let mut row = 0;
        for (i, (&kind, &index)) in local.kinds.iter().zip(local.indices).enumerate() {
            let height = kind.freedoms();
            let node = self.nodes[kind as usize][index];
            if !local.has_potential || node.is_none() {
                let velocity = velocity(bodies, kind, index);
                let power = (0..height).fold(R::zero(), |sum, k| sum + local.force[row + k] * velocity[k]);
                // A body that is moved gives what the force takes from it.
                match node {
                    Some(_) => self.power += power,
                    None if local.has_potential => self.power -= power,
                    None => {}
                }
            }
            let Some(node) = node else {
                row += height;
                continue;
            };
            for k in 0..height {
                self.force[node][k] += local.force[row + k];
            }
            let mut column = 0;
            for (j, (&other, &index)) in local.kinds.iter().zip(local.indices).enumerate() {
                let at = row * order + column;
                let place = local.places[i * count + j];
                if self.wants.drift {
                    let velocity = velocity(bodies, other, index);
                    for k in 0..height {
                        let entries = &local.dfdx[at + k * order..][..other.freedoms()];
                        let sum =
                            entries.iter().zip(velocity.iter()).fold(R::zero(), |sum, (&k, &v)| sum + k * v);
                        self.drift[node][k] += sum;
                        if place == NOWHERE {
                            self.driven[node][k] += sum;
                        }
                    }
                }
                if place != NOWHERE {
                    let block = (place as usize, at, order);
                    match (kind, other) {
                        (BodyKind::Rigid, BodyKind::Rigid) => self.add_block::<6, 6>(block, local),
                        (BodyKind::Rigid, BodyKind::Particle) => self.add_block::<6, 3>(block, local),
                        (BodyKind::Particle, BodyKind::Rigid) => self.add_block::<3, 6>(block, local),
                        (BodyKind::Particle, BodyKind::Particle) => self.add_block::<3, 3>(block, local),
                    }
                }
                column += other.freedoms();
            }
            row += height;
        }
    }

    #[inline]
    fn add_block<const HEIGHT: usize, const WIDTH: usize>(
        &mut self,
        (place, at, order): (usize, usize, usize),
        local: &Local<'_, R>,
    ) {
        let block = &mut self.system.blocks[place];
        for i in 0..HEIGHT.min(D) {
            let dfdx = &local.dfdx[at + i * order..][..WIDTH];
            let dfdv = &local.dfdv[at + i * order..][..WIDTH];
            for j in 0..WIDTH.min(D) {
                block[(i, j)] -= self.damping * dfdv[j] + self.stiffness * dfdx[j];
            }
        }
        if self.wants.tangent {
            let block = &mut self.tangent[place];
            for i in 0..HEIGHT.min(D) {
                let dfdx = &local.dfdx[at + i * order..][..WIDTH];
                for j in 0..WIDTH.min(D) {
                    block[(i, j)] += dfdx[j];
                }
            }
        }
    }

    /// Adds inertia, gravity, loads and the torque of turning bodies, after all forces.
    pub(crate) fn add_bodies(&mut self, store: &Store<R>, gravity: Vector3<R>) {
        for (index, (body, member)) in store.rigid.iter().zip(&store.members[0]).enumerate() {
            let (Some((mass, moments)), Some(node)) = (member.inertia(), self.nodes[0][index]) else {
                continue;
            };
            let (inertia, inverse) = world_inertia(body, moments);
            let spin = body.angular_velocity;
            let momentum = inertia * spin;
            self.add_load(node, member.load, body.velocity, spin);
            add_linear(&mut self.force[node], gravity * mass);
            add_angular(&mut self.force[node], momentum.cross(&spin));
            self.add_mass(node, mass);
            if self.wants.lag {
                let lag = self.lag[node];
                self.lag[node] = lag * mass;
                let momentum = inertia * angular(&lag);
                (3..D).for_each(|i| self.lag[node][i] = momentum[i - 3]);
            }
            let mut turning = inertia;
            if self.wants.exact {
                let torque = angular(&self.force[node]);
                let (w, l) = (spin.cross_matrix(), momentum.cross_matrix());
                let wi = w * inertia;
                let with_inertia = ((inverse * torque).cross_matrix() * inertia).transpose();
                let stiffness = w * (l + wi.transpose()) + torque.cross_matrix() + with_inertia;
                turning -= (l - wi) * self.damping + stiffness * self.stiffness;
                if self.wants.drift {
                    add_angular(&mut self.drift[node], stiffness * spin);
                }
                if self.wants.tangent {
                    add_turning(&mut self.tangent[node], &stiffness);
                }
            }
            add_turning(&mut self.system.blocks[node], &turning);
        }
        for (index, (body, member)) in store.particles.iter().zip(&store.members[1]).enumerate() {
            let (Some((mass, _)), Some(node)) = (member.inertia(), self.nodes[1][index]) else { continue };
            self.add_load(node, member.load, body.velocity, Vector3::zeros());
            add_linear(&mut self.force[node], gravity * mass);
            self.add_mass(node, mass);
            for i in 3..D {
                self.system.blocks[node][(i, i)] += R::one();
            }
            if self.wants.lag {
                self.lag[node] *= mass;
            }
        }
    }

    fn add_mass(&mut self, node: usize, mass: R) {
        let block = &mut self.system.blocks[node];
        for i in 0..3 {
            self.swamped |= block[(i, i)] * R::default_epsilon() > mass;
            block[(i, i)] += mass;
        }
    }

    fn add_load(&mut self, node: usize, load: Vector6<R>, velocity: Vector3<R>, spin: Vector3<R>) {
        let (force, torque) = (load.fixed_rows::<3>(0).into_owned(), load.fixed_rows::<3>(3).into_owned());
        add_linear(&mut self.force[node], force);
        add_angular(&mut self.force[node], torque);
        self.power += force.dot(&velocity) + torque.dot(&spin);
    }
}

/// The symmetric part of a matrix given row by row, its positive eigenvalues made zero.
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

/// R I Rᵀ and its inverse.
pub(crate) fn world_inertia<R: RealField + Copy>(
    body: &Rigid<R>,
    moments: Vector3<R>,
) -> (Matrix3<R>, Matrix3<R>) {
    let turn = body.orientation.to_rotation_matrix();
    let turn = turn.matrix();
    let scaled = |scale: Vector3<R>| {
        let mut columns = *turn;
        for (mut column, &scale) in columns.column_iter_mut().zip(scale.iter()) {
            column *= scale;
        }
        columns * turn.transpose()
    };
    (scaled(moments), scaled(moments.map(|moment| R::one() / moment)))
}

/// The first three entries.
pub(crate) fn linear<R: RealField + Copy, const D: usize>(x: &SVector<R, D>) -> Vector3<R> {
    Vector3::new(x[0], x[1], x[2])
}

/// The last three of six entries; nothing turns where there are three.
pub(crate) fn angular<R: RealField + Copy, const D: usize>(x: &SVector<R, D>) -> Vector3<R> {
    if D == 6 { Vector3::new(x[3], x[4], x[5]) } else { Vector3::zeros() }
}

pub(crate) fn add_linear<R: RealField + Copy, const D: usize>(x: &mut SVector<R, D>, change: Vector3<R>) {
    for i in 0..3 {
        x[i] += change[i];
    }
}

pub(crate) fn add_angular<R: RealField + Copy, const D: usize>(x: &mut SVector<R, D>, change: Vector3<R>) {
    for i in 3..D {
        x[i] += change[i - 3];
    }
}

fn add_turning<R: RealField + Copy, const D: usize>(block: &mut SMatrix<R, D, D>, change: &Matrix3<R>) {
    for i in 3..D {
        for j in 3..D {
            block[(i, j)] += change[(i - 3, j - 3)];
        }
    }
}
