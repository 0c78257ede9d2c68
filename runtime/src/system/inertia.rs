//! The inertia of bodies: mass, gravity, loads and gyroscopic torques in the system of a step.
//!
//! Input: bodies, and an assembly with all forces. Output: the same assembly with the terms of each dynamic
//! body added. Also R I Rᵀ of a rigid body, and the linear and angular parts of vectors with three or six
//! entries per node.

use crate::kernel::BodyKind;
use crate::kernel::bodies::{Rigid, Wrench};
use crate::outside::Outside;
use crate::state::{Member, Store};
use crate::system::assemble::Assembly;
use nalgebra::{Matrix3, RealField, SVector, Vector3, Vector6, convert};

impl<R: RealField + Copy, const D: usize> Assembly<R, D> {
    /// Adds inertia, gravity, loads and gyroscopic torques, after all forces; `clock` is the time since the
    /// start of the step.
    pub(crate) fn add_bodies(&mut self, store: &Store<R>, outside: &Outside<'_, R>, clock: R) {
        let gravity = outside.gravity;
        let load = |kind: BodyKind, index: usize, member: &Member<R>| {
            let mut load = member.load;
            if let Some(loads) = outside.loads {
                let mut body = store.get(kind, index);
                body.position += outside.origin.map(convert::<f64, R>);
                let Wrench { force, torque } = loads(outside.time + clock, member.handle(kind), &body);
                for i in 0..3 {
                    load[i] += force[i];
                    load[3 + i] += torque[i];
                }
            }
            load
        };
        for (index, (body, member)) in store.rigid.iter().zip(&store.members[0]).enumerate() {
            let (Some((mass, moments)), Some(node)) = (member.inertia(), self.nodes[0][index]) else {
                continue;
            };
            let frame = Frame::new(body, moments);
            let inertia = frame.inertia();
            let spin = body.angular_velocity;
            let momentum = inertia * spin;
            self.add_load(node, load(BodyKind::Rigid, index, member), body.velocity, spin);
            add_linear(&mut self.force[node], gravity * mass);
            add_angular(&mut self.force[node], momentum.cross(&spin));
            if self.wants.momentum {
                let change = self.momentum[node];
                self.momentum[node] = change * mass;
                let turned = inertia * angular(&change);
                (3..D).for_each(|i| self.momentum[node][i] = turned[i - 3]);
            }
            if !self.wants.matrix {
                continue;
            }
            self.add_mass(node, mass);
            let mut turning = inertia;
            if self.wants.exact {
                let torque = if self.wants.held {
                    angular(&self.momentum[node]) / self.damping
                } else {
                    angular(&self.force[node])
                };
                let spun = crossed(&spin, &inertia);
                let l = momentum.cross_matrix();
                let with_inertia = crossed(&frame.accelerate(&torque), &inertia).transpose();
                let stiffness =
                    crossed(&spin, &(l + spun.transpose())) + torque.cross_matrix() + with_inertia;
                turning -= (l - spun) * self.damping + stiffness * self.stiffness;
                if self.wants.drift {
                    add_angular(&mut self.drift[node], stiffness * spin);
                }
                if self.wants.tangent {
                    self.tangent[node].add_turning(&stiffness);
                }
            }
            self.system.blocks[node].add_turning(&turning);
        }
        for (index, (body, member)) in store.particles.iter().zip(&store.members[1]).enumerate() {
            let (Some((mass, _)), Some(node)) = (member.inertia(), self.nodes[1][index]) else { continue };
            self.add_load(node, load(BodyKind::Particle, index, member), body.velocity, Vector3::zeros());
            add_linear(&mut self.force[node], gravity * mass);
            if self.wants.momentum {
                self.momentum[node] *= mass;
            }
            if self.wants.matrix {
                self.add_mass(node, mass);
                for i in 3..D {
                    self.system.blocks[node].0[i][i] += R::one();
                }
            }
        }
    }

    fn add_mass(&mut self, node: usize, mass: R) {
        let block = &mut self.system.blocks[node];
        for i in 0..3 {
            self.mass_negligible |= block.0[i][i] * R::default_epsilon() > mass;
            block.0[i][i] += mass;
        }
    }

    fn add_load(&mut self, node: usize, load: Vector6<R>, velocity: Vector3<R>, spin: Vector3<R>) {
        let (force, torque) = (load.fixed_rows::<3>(0).into_owned(), load.fixed_rows::<3>(3).into_owned());
        add_linear(&mut self.force[node], force);
        add_angular(&mut self.force[node], torque);
        self.power += force.dot(&velocity) + torque.dot(&spin);
    }
}

/// The principal axes and moments of a body.
pub(crate) struct Frame<R> {
    turn: Matrix3<R>,
    moments: Vector3<R>,
}

impl<R: RealField + Copy> Frame<R> {
    pub(crate) fn new(body: &Rigid<R>, moments: Vector3<R>) -> Frame<R> {
        Frame { turn: body.orientation.to_rotation_matrix().into_inner(), moments }
    }

    /// R I Rᵀ
    pub(crate) fn inertia(&self) -> Matrix3<R> {
        let (turn, moments) = (&self.turn, &self.moments);
        let entry = |i: usize, j: usize| {
            (0..3).fold(R::zero(), |sum, k| sum + turn[(i, k)] * moments[k] * turn[(j, k)])
        };
        let (xy, xz, yz) = (entry(0, 1), entry(0, 2), entry(1, 2));
        Matrix3::new(entry(0, 0), xy, xz, xy, entry(1, 1), yz, xz, yz, entry(2, 2))
    }

    /// R I⁻¹ Rᵀ τ
    pub(crate) fn accelerate(&self, torque: &Vector3<R>) -> Vector3<R> {
        self.turn * self.turn.tr_mul(torque).component_div(&self.moments)
    }
}

/// [x]× M, column by column.
fn crossed<R: RealField + Copy>(x: &Vector3<R>, matrix: &Matrix3<R>) -> Matrix3<R> {
    let column = |j: usize| x.cross(&matrix.column(j));
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

/// The first three entries.
pub(crate) fn linear<R: RealField + Copy, const D: usize>(x: &SVector<R, D>) -> Vector3<R> {
    Vector3::new(x[0], x[1], x[2])
}

/// The last three of six entries; zero if there are three.
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
