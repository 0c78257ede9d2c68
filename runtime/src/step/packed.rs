//! L islands of equal structure, stepped in lanes by explicit methods, with rigid rows.
//!
//! In: the stores of the islands; they are read when they change, and the state then stays here from step to
//! step. Out: the state after a step, for each instance the gap of rigid rows before it was projected, and
//! the work of forces without potential. Rigid rows hold by
//!
//! ```text
//! M V̇ = f + Jᵀλ,   J V̇ = −D(JV)·V
//! ```
//!
//! in every stage; after a step poses and velocities move onto C = 0 and J V = 0 by the least change in the
//! norm of M, with the factors of the last stage. Quaternions are integrated as numbers in R⁴ and read as
//! rotations whatever their length.

use crate::kernel::bodies::{Particle, ParticleLanes, Rigid, RigidLanes};
use crate::kernel::{BodiesLanes, BodyKind};
use crate::state::{Body, Motion, Store};
use crate::step::Outcome;
use crate::system::batch::{Batch, has_rows, joints};
use crate::system::factor::Factors;
use crate::system::lane_batch::LaneBatch;
use crate::system::lanes::{Lanes, Three};
use crate::system::plan::Plan;
use nalgebra::{Quaternion, RealField, UnitQuaternion, Vector3};

/// Bodies in lanes.
#[derive(Clone, Debug)]
pub(crate) struct State<R: RealField, const L: usize> {
    pub(crate) rigid: Vec<RigidLanes<R, L>>,
    pub(crate) particles: Vec<ParticleLanes<R, L>>,
}

impl<R: RealField, const L: usize> Default for State<R, L> {
    fn default() -> State<R, L> {
        State { rigid: Vec::new(), particles: Vec::new() }
    }
}

impl<R: RealField + Copy, const L: usize> State<R, L> {
    /// Copies bodies of the same number.
    pub(super) fn copy_from(&mut self, other: &State<R, L>) {
        self.rigid.copy_from_slice(&other.rigid);
        self.particles.copy_from_slice(&other.particles);
    }

    pub(super) fn bodies(&self) -> BodiesLanes<'_, R, L> {
        BodiesLanes { rigid: &self.rigid, particles: &self.particles }
    }

    pub(super) fn rigid(&self, index: usize, lane: usize) -> Rigid<R> {
        let body = &self.rigid[index];
        let vector = |x: &[[R; L]; 3]| Vector3::new(x[0][lane], x[1][lane], x[2][lane]);
        let q = &body.orientation;
        let q = Quaternion::new(q[3][lane], q[0][lane], q[1][lane], q[2][lane]);
        Rigid {
            position: vector(&body.position),
            orientation: UnitQuaternion::new_unchecked(q),
            velocity: vector(&body.velocity),
            angular_velocity: vector(&body.angular_velocity),
        }
    }

    /// A body by type; a particle as a rigid body without rotation.
    pub(super) fn get(&self, kind: BodyKind, index: usize, lane: usize) -> Rigid<R> {
        match kind {
            BodyKind::Rigid => self.rigid(index, lane),
            BodyKind::Particle => {
                let body = &self.particles[index];
                let vector = |x: &[[R; L]; 3]| Vector3::new(x[0][lane], x[1][lane], x[2][lane]);
                Rigid {
                    position: vector(&body.position),
                    velocity: vector(&body.velocity),
                    ..Rigid::default()
                }
            }
        }
    }

    pub(super) fn set_particle(&mut self, index: usize, lane: usize, state: &Particle<R>) {
        let body = &mut self.particles[index];
        for i in 0..3 {
            body.position[i][lane] = state.position[i];
            body.velocity[i][lane] = state.velocity[i];
        }
    }

    pub(super) fn set_rigid(&mut self, index: usize, lane: usize, state: &Rigid<R>) {
        let body = &mut self.rigid[index];
        for i in 0..3 {
            body.position[i][lane] = state.position[i];
            body.velocity[i][lane] = state.velocity[i];
            body.angular_velocity[i][lane] = state.angular_velocity[i];
        }
        for i in 0..4 {
            body.orientation[i][lane] = state.orientation.coords[i];
        }
    }
}

/// The mass, and for rigid bodies the principal moments, of a body; zero for kinematic bodies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia<R, const L: usize> {
    /// Where its entries are in vectors, and its block in the matrix.
    pub(super) place: Option<(usize, usize)>,
    pub(super) mass: Lanes<R, L>,
    pub(super) moments: Three<R, L>,
    pub(super) load: [Lanes<R, L>; 6],
}

/// What a step came to, per instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stepped<R, const L: usize> {
    /// The largest |C| of rigid rows before projection.
    pub(crate) gap: Lanes<R, L>,
    /// The work of forces without potential, loads and kinematic bodies, J.
    pub(crate) work: Lanes<R, L>,
}

impl<R: RealField + Copy, const L: usize> Stepped<R, L> {
    /// The outcome of one instance, with the gap as error where there are rigid rows.
    pub(crate) fn outcome(&self, lane: usize, has_rows: bool) -> Outcome<R> {
        let error = has_rows.then_some(self.gap.0[lane]);
        Outcome { residual: R::zero(), error, work: Some(self.work.0[lane]) }
    }
}

/// Bodies and forces of an island, and the origin of its positions.
pub(crate) type Source<'a, R> = (&'a Store<R>, &'a [Box<dyn Batch<R>>], Vector3<f64>);

/// L islands in lanes.
pub(crate) struct Packed<R: RealField + Copy, const L: usize> {
    pub(super) arch: pulp::Arch,
    pub(super) plan: Plan,
    pub(super) factors: Factors<R, L>,
    pub(super) batches: Vec<Box<dyn LaneBatch<R, L>>>,
    /// By type, and index among the bodies of the type.
    pub(super) inertia: [Vec<Inertia<R, L>>; 2],
    pub(super) handles: [Vec<[Body; L]>; 2],
    pub(super) origins: [Vector3<f64>; L],
    /// The state at the end of the last step.
    pub(crate) state: State<R, L>,
    /// The state of a stage, as kernels read it; the same with quaternions as integrated; sums of rates.
    pub(super) shown: State<R, L>,
    pub(super) stage: State<R, L>,
    pub(super) sums: State<R, L>,
    /// f and γ, then V̇ and −λ.
    pub(super) vector: Vec<Lanes<R, L>>,
    /// A copy of it.
    pub(super) copy: Vec<Lanes<R, L>>,
    /// −λ of the last stage, for rows that close loops.
    pub(super) multipliers: Vec<Lanes<R, L>>,
    /// Whether the matrix has entries that a stage does not set.
    pub(super) clear: bool,
    has_rows: bool,
    /// Whether a kinematic body moves.
    pub(super) driven: bool,
}

impl<R: RealField + Copy, const L: usize> Packed<R, L> {
    /// For islands with this structure; `gather` comes next.
    pub(crate) fn new(store: &Store<R>, batches: &[Box<dyn Batch<R>>], arch: pulp::Arch) -> Packed<R, L> {
        let (nodes, dofs) = store.nodes();
        let joints = joints(batches, &nodes);
        let plan = Plan::new(&dofs, &joints);
        let mut own: Vec<Box<dyn LaneBatch<R, L>>> = Vec::new();
        let mut first = 0;
        for batch in batches {
            if let Ok(mut lanes) = batch.in_lanes(L).downcast::<Box<dyn LaneBatch<R, L>>>() {
                lanes.gather(&[batch.as_ref(); L]);
                lanes.place(&plan, &nodes, first);
                own.push(*lanes);
            }
            first += if batch.is_rigid() { batch.entries().len() } else { 0 };
        }
        let zero = Lanes::zero();
        let inertia = nodes.map(|nodes| {
            let one = |node: Option<usize>| Inertia {
                place: node.map(|node| (plan.body(node), plan.mass(node))),
                mass: zero,
                moments: [zero; 3],
                load: [zero; 6],
            };
            nodes.into_iter().map(one).collect()
        });
        let length = plan.length();
        let clear = plan.has_fill() || own.iter().any(|batch| batch.adds());
        Packed {
            arch,
            factors: Factors::new(&plan),
            plan,
            batches: own,
            inertia,
            handles: [Vec::new(), Vec::new()],
            origins: [Vector3::zeros(); L],
            state: State::default(),
            shown: State::default(),
            stage: State::default(),
            sums: State::default(),
            vector: vec![zero; length],
            copy: vec![zero; length],
            multipliers: vec![zero; length],
            clear,
            has_rows: has_rows(batches),
            driven: false,
        }
    }

    /// Reads parameters and masses of the islands.
    pub(crate) fn gather(&mut self, each: &[Source<'_, R>; L]) {
        self.driven = false;
        for (k, own) in self.batches.iter_mut().enumerate() {
            own.gather(&std::array::from_fn(|lane| each[lane].1[k].as_ref()));
        }
        for (lane, (store, _, origin)) in each.iter().enumerate() {
            self.origins[lane] = *origin;
            self.gather_lane(lane, store);
        }
    }

    /// Reads masses of one island.
    fn gather_lane(&mut self, lane: usize, store: &Store<R>) {
        let zero = [R::zero(); L];
        let rigid = RigidLanes {
            position: [zero; 3],
            orientation: [zero; 4],
            velocity: [zero; 3],
            angular_velocity: [zero; 3],
        };
        let particle = ParticleLanes { position: [zero; 3], velocity: [zero; 3] };
        for state in [&mut self.state, &mut self.shown, &mut self.stage, &mut self.sums] {
            state.rigid.resize(store.rigid.len(), rigid);
            state.particles.resize(store.particles.len(), particle);
        }
        for (kind, own) in [BodyKind::Rigid, BodyKind::Particle].into_iter().zip(&mut self.handles) {
            for (index, member) in store.members[kind as usize].iter().enumerate() {
                let handle = member.handle(kind);
                own.resize(own.len().max(index + 1), [handle; L]);
                own[index][lane] = handle;
            }
        }
        for (inertia, members) in self.inertia.iter_mut().zip(&store.members) {
            for (own, member) in inertia.iter_mut().zip(members) {
                let (mass, moments) = member.inertia().unwrap_or((R::zero(), Vector3::zeros()));
                own.mass.0[lane] = mass;
                (0..3).for_each(|i| own.moments[i].0[lane] = moments[i]);
            }
        }
        self.driven |=
            store.rigid.iter().zip(&store.members[0]).any(|(body, member)| {
                let still = body.velocity == Vector3::zeros() && body.angular_velocity == Vector3::zeros();
                member.motion == Motion::Kinematic && !still
            }) || store.particles.iter().zip(&store.members[1]).any(|(body, member)| {
                member.motion == Motion::Kinematic && body.velocity != Vector3::zeros()
            });
    }

    /// Reads the state of one island, and the multipliers of rows that close loops.
    pub(crate) fn read(&mut self, lane: usize, store: &Store<R>, multipliers: &[R]) {
        for (index, body) in store.rigid.iter().enumerate() {
            self.state.set_rigid(index, lane, body);
        }
        for (index, body) in store.particles.iter().enumerate() {
            self.state.set_particle(index, lane, body);
        }
        for (k, own) in self.multipliers.iter_mut().enumerate() {
            own.0[lane] = multipliers.get(k).copied().unwrap_or(R::zero());
        }
    }

    /// Reads the loads of one island.
    pub(crate) fn read_loads(&mut self, lane: usize, store: &Store<R>) {
        for (inertia, members) in self.inertia.iter_mut().zip(&store.members) {
            for (own, member) in inertia.iter_mut().zip(members) {
                (0..6).for_each(|i| own.load[i].0[lane] = member.load[i]);
            }
        }
    }

    /// Reads the states of moving kinematic bodies of one island.
    pub(crate) fn read_driven(&mut self, lane: usize, store: &Store<R>) {
        if !self.driven {
            return;
        }
        for (index, body) in
            store.rigid.iter().enumerate().filter(|&(k, _)| self.inertia[0][k].place.is_none())
        {
            self.state.set_rigid(index, lane, body);
        }
        for (k, body) in store.particles.iter().enumerate() {
            if self.inertia[1][k].place.is_none() {
                self.state.set_particle(k, lane, body);
            }
        }
    }

    /// Writes the multipliers of rows that close loops; none if there are none.
    pub(crate) fn write_multipliers(&self, lane: usize, multipliers: &mut Vec<R>) {
        multipliers.clear();
        if self.plan.has_loops() {
            multipliers.extend(self.multipliers.iter().map(|x| x.0[lane]));
        }
    }

    /// Writes the state of one instance to a store.
    pub(crate) fn scatter(&self, lane: usize, store: &mut Store<R>) {
        for (index, body) in store.rigid.iter_mut().enumerate() {
            *body = self.state.rigid(index, lane);
        }
        for (body, own) in store.particles.iter_mut().zip(&self.state.particles) {
            for i in 0..3 {
                body.position[i] = own.position[i][lane];
                body.velocity[i] = own.velocity[i][lane];
            }
        }
    }

    /// Whether there are rigid rows.
    pub(crate) fn has_rows(&self) -> bool {
        self.has_rows
    }
}
