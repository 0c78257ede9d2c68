//! The bodies of an island, in arrays that kernels read in place.

use crate::kernel::bodies::{Particle, Rigid};
use crate::kernel::{Bodies, BodyKind};
use nalgebra::{Quaternion, RealField, UnitQuaternion, Vector3, Vector6, convert};

/// A handle of a body in a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Body {
    pub(crate) kind: BodyKind,
    pub(crate) entry: usize,
    pub(crate) generation: u32,
}

/// The response of a body to forces.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Motion<R: RealField> {
    /// Moves under forces, with mass, kg, and principal moments of inertia along the axes of body space,
    /// kg·m²; particles ignore the moments.
    Dynamic(R, Vector3<R>),
    /// Moves at its velocity, whatever forces act; a fixed body has velocity zero.
    Kinematic,
}

/// The data of a body, without its state.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Member<R: RealField> {
    /// The entry in the world's table of bodies, and its generation.
    pub(crate) entry: usize,
    pub(crate) generation: u32,
    pub(crate) motion: Motion<R>,
    /// A constant force and torque.
    pub(crate) load: Vector6<R>,
    /// The rates of the generalised-α method.
    pub(crate) rates: [Vector6<R>; 2],
}

impl<R: RealField + Copy> Member<R> {
    pub(crate) fn new(body: Body, motion: Motion<R>) -> Member<R> {
        let Body { entry, generation, .. } = body;
        Member { entry, generation, motion, load: Vector6::zeros(), rates: [Vector6::zeros(); 2] }
    }

    /// The handle, of a body of this type.
    pub(crate) fn handle(&self, kind: BodyKind) -> Body {
        Body { kind, entry: self.entry, generation: self.generation }
    }

    /// The mass and principal moments of a dynamic body.
    pub(crate) fn inertia(&self) -> Option<(R, Vector3<R>)> {
        match self.motion {
            Motion::Dynamic(mass, moments) => Some((mass, moments)),
            Motion::Kinematic => None,
        }
    }
}

/// The bodies with their data. A kinematic body may be in several islands.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Store<R: RealField> {
    pub(crate) rigid: Vec<Rigid<R>>,
    pub(crate) particles: Vec<Particle<R>>,
    /// The data of rigid bodies, then of particles.
    pub(crate) members: [Vec<Member<R>>; 2],
}

impl<R: RealField> Default for Store<R> {
    fn default() -> Store<R> {
        Store { rigid: Vec::new(), particles: Vec::new(), members: [Vec::new(), Vec::new()] }
    }
}

/// The states of all bodies, for restoring them.
#[derive(Clone, Debug)]
pub(crate) struct Poses<R: RealField> {
    pub(crate) rigid: Vec<Rigid<R>>,
    pub(crate) particles: Vec<Particle<R>>,
}

impl<R: RealField + Copy> Poses<R> {
    /// The state of a body; `None` if the index is out of range.
    pub(crate) fn get(&self, kind: BodyKind, index: usize) -> Option<Rigid<R>> {
        match kind {
            BodyKind::Rigid => self.rigid.get(index).copied(),
            BodyKind::Particle => self.particles.get(index).map(as_rigid),
        }
    }
}

impl<R: RealField> Default for Poses<R> {
    fn default() -> Poses<R> {
        Poses { rigid: Vec::new(), particles: Vec::new() }
    }
}

impl<R: RealField + Copy> Store<R> {
    pub(crate) fn save(&self, poses: &mut Poses<R>) {
        poses.rigid.clone_from(&self.rigid);
        poses.particles.clone_from(&self.particles);
    }

    pub(crate) fn restore(&mut self, poses: &Poses<R>) {
        self.rigid.copy_from_slice(&poses.rigid);
        self.particles.copy_from_slice(&poses.particles);
    }

    pub(crate) fn bodies(&self) -> Bodies<'_, R> {
        Bodies { rigid: &self.rigid, particles: &self.particles }
    }

    /// Numbers the dynamic bodies, rigid bodies first: the node of each body, and the degrees of freedom of each
    /// node.
    pub(crate) fn nodes(&self) -> ([Vec<Option<usize>>; 2], Vec<usize>) {
        let mut dofs = Vec::new();
        let nodes = [BodyKind::Rigid, BodyKind::Particle].map(|kind| {
            let number = |member: &Member<R>| {
                (member.motion != Motion::Kinematic).then(|| {
                    dofs.push(kind.dofs());
                    dofs.len() - 1
                })
            };
            self.members[kind as usize].iter().map(number).collect()
        });
        (nodes, dofs)
    }

    /// The number of dynamic bodies.
    pub(crate) fn moving(&self) -> usize {
        self.members.iter().flatten().filter(|member| member.motion != Motion::Kinematic).count()
    }

    /// Appends a body and returns its index; a particle is given as a rigid body without rotation.
    pub(crate) fn push(&mut self, kind: BodyKind, state: Rigid<R>, member: Member<R>) -> usize {
        match kind {
            BodyKind::Rigid => self.rigid.push(state),
            BodyKind::Particle => self.particles.push(as_particle(&state)),
        }
        let members = &mut self.members[kind as usize];
        members.push(member);
        members.len() - 1
    }

    pub(crate) fn get(&self, kind: BodyKind, index: usize) -> Rigid<R> {
        match kind {
            BodyKind::Rigid => self.rigid[index],
            BodyKind::Particle => as_rigid(&self.particles[index]),
        }
    }

    pub(crate) fn set(&mut self, kind: BodyKind, index: usize, state: Rigid<R>) {
        match kind {
            BodyKind::Rigid => self.rigid[index] = state,
            BodyKind::Particle => self.particles[index] = as_particle(&state),
        }
    }

    /// Removes a body; the last body of its type takes its index.
    pub(crate) fn remove(&mut self, kind: BodyKind, index: usize) {
        match kind {
            BodyKind::Rigid => _ = self.rigid.swap_remove(index),
            BodyKind::Particle => _ = self.particles.swap_remove(index),
        }
        self.members[kind as usize].swap_remove(index);
    }

    /// Every body: type, index and data.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (BodyKind, usize, &Member<R>)> {
        let of = |kind: BodyKind| {
            self.members[kind as usize].iter().enumerate().map(move |(index, member)| (kind, index, member))
        };
        of(BodyKind::Rigid).chain(of(BodyKind::Particle))
    }

    pub(crate) fn is_finite(&self) -> bool {
        let all = |v: &Vector3<R>| v.iter().all(|x| x.is_finite());
        let rigid = |b: &Rigid<R>| {
            all(&b.position)
                && all(&b.velocity)
                && all(&b.angular_velocity)
                && b.orientation.coords.iter().all(|x| x.is_finite())
        };
        self.rigid.iter().all(rigid) && self.particles.iter().all(|b| all(&b.position) && all(&b.velocity))
    }
}

pub(crate) fn as_particle<R: RealField + Copy>(state: &Rigid<R>) -> Particle<R> {
    Particle { position: state.position, velocity: state.velocity }
}

pub(crate) fn as_rigid<R: RealField + Copy>(state: &Particle<R>) -> Rigid<R> {
    Rigid { position: state.position, velocity: state.velocity, ..Rigid::default() }
}

/// A displaced pose: x + `way`, exp(`turn`) q.
#[inline]
pub(crate) fn moved<R: RealField + Copy>(pose: &Rigid<R>, way: Vector3<R>, turn: Vector3<R>) -> Rigid<R> {
    let mut orientation = exp(&turn) * pose.orientation;
    orientation.renormalize_fast();
    Rigid { position: pose.position + way, orientation, ..*pose }
}

/// exp(θ) = (θ/2 sin(α)/α, cos(α)), α = |θ|/2; for angles of typical steps by power series.
#[inline]
fn exp<R: RealField + Copy>(turn: &Vector3<R>) -> UnitQuaternion<R> {
    let number = convert::<f64, R>;
    let square = turn.norm_squared() * number(0.25);
    // The truncation error of the series is below 3e-17.
    if square > number(1.0 / 64.0) {
        return UnitQuaternion::from_scaled_axis(*turn);
    }
    let series = |factors: [f64; 6]| {
        factors.into_iter().rev().fold(R::zero(), |sum, factor| number(factor) - sum * square)
    };
    let sine = series([1.0, 1.0 / 6.0, 1.0 / 120.0, 1.0 / 5040.0, 1.0 / 362_880.0, 0.0]);
    let cosine = series([1.0, 0.5, 1.0 / 24.0, 1.0 / 720.0, 1.0 / 40_320.0, 1.0 / 3_628_800.0]);
    let axis = turn * (sine * number(0.5));
    UnitQuaternion::new_unchecked(Quaternion::new(cosine, axis.x, axis.y, axis.z))
}

pub(crate) fn as_f64<R: RealField + Copy>(x: R) -> f64 {
    x.to_subset_unchecked()
}
