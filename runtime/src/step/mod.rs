//! Methods of integration: one step of one island, without step control.
//!
//! Poses are relative to the start of the step: x₀ + δx, exp(δθ) q₀, with δ̇x = v and δ̇θ = dexp⁻¹_δθ(ω). A
//! method takes the state from the start to the end of the step. Kinematic bodies move at their velocity.
//!
//! All implicit methods solve (M − hγ D − s K) δ = b, with K = ∂f/∂x, D = ∂f/∂v, and s = (hγ)² in most
//! methods. The forces include the gyroscopic torque −ω × Iω with its derivatives. The rotational diagonal
//! block of K contains `[τ]× − I [α]×`, because the inertia turns with the body; τ is the total torque, or Iα

mod alpha;
mod implicit;
mod model;
pub(crate) mod packed;
mod rodas4;
mod runge_kutta;

pub(crate) use model::Model;

use crate::kernel::bodies::{Particle, Rigid};
use crate::outside::Outside;
use crate::report::{Report, span};
use crate::state::{Poses, Store, moved};
use crate::system::assemble::{Assembly, Wants};
use crate::system::batch::{Batch, Sums, has_rows};
use crate::system::inertia::{add_angular, add_linear, angular, linear};
use crate::system::iterative::Solver;
use nalgebra::{RealField, SVector, Vector3, convert};
use std::time::Instant;

/// A method of integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Integrator {
    /// (M − hD − h²K) δv = h (f₀ + h K v₀), of order one.
    LinearlyImplicitEuler,
    /// The same without the derivatives of gyroscopic torque and rotating inertia, for comparisons: A = I −
    /// hW(∂f/∂v + h ∂f/∂x), D'Amora et al., IBM Systems Journal 45(1), 2006.
    PaperEuler,
    /// Two stages with γ = 1 − 1/√2, L-stable, of order two; each stage is linearised at its predicted pose.
    #[default]
    Sdirk2,
    /// One stage per step, which balances forces at its end, of order two, with little damping of low
    /// frequencies: Chung and Hulbert, Journal of Applied Mechanics 60, 1993. After a change of bodies or
    /// forces, except loads, the first step is one of `Sdirk2`.
    GeneralizedAlpha,
    /// Six stages with one matrix, of order four, with step control by an error estimate: Hairer and Wanner,
    /// Solving Ordinary Differential Equations II, 1996.
    Rodas4,
    /// v += h M⁻¹f, then x ⊕= h v, of order one; explicit.
    SymplecticEuler,
    /// The classical Runge-Kutta method, of order four; explicit.
    RungeKutta4,
}

impl Integrator {
    /// Whether the method solves for accelerations alone.
    pub(crate) fn is_explicit(self) -> bool {
        matches!(self, Integrator::SymplecticEuler | Integrator::RungeKutta4)
    }
}

/// The block products per node above which iterations are cheaper than elimination: about the number for a
/// square cloth of 200 × 200 particles.
const MOST_PRODUCTS: usize = 20_000;

/// One step of one island.
pub(crate) struct Stepper<'a, R: RealField, const D: usize> {
    pub(crate) store: &'a mut Store<R>,
    /// The bodies at the start of the step.
    pub(crate) saved: &'a Poses<R>,
    pub(crate) batches: &'a mut [Box<dyn Batch<R>>],
    pub(crate) model: &'a mut Model<R, D>,
    pub(crate) outside: &'a Outside<'a, R>,
    /// The time of the present state since the start of the step.
    pub(crate) clock: R,
    pub(crate) solver: Solver,
    /// Whether the rates stored in the bodies belong to the present state.
    pub(crate) warm: bool,
    pub(crate) report: &'a mut Report,
}

/// The quality of a step.
pub(crate) struct Outcome<R> {
    /// The largest relative residual of the stages.
    pub(crate) residual: R,
    /// The estimated error at the end, m and rad, if the method estimates it.
    pub(crate) error: Option<R>,
    /// The work of forces without potential, loads and kinematic bodies, J, if the method computes it.
    pub(crate) work: Option<R>,
}

/// Wraps an assembly of either block size for batches.
pub(crate) trait BlockSize<R: RealField> {
    fn sums(&mut self) -> Sums<'_, R>;
}

impl<R: RealField> BlockSize<R> for Assembly<R, 3> {
    fn sums(&mut self) -> Sums<'_, R> {
        Sums::Three(self)
    }
}

impl<R: RealField> BlockSize<R> for Assembly<R, 6> {
    fn sums(&mut self) -> Sums<'_, R> {
        Sums::Six(self)
    }
}

impl<R: RealField + Copy, const D: usize> Stepper<'_, R, D>
where
    Assembly<R, D>: BlockSize<R>,
{
    /// Takes one step; `None` if a solver broke down.
    pub(crate) fn step(&mut self, h: R, integrator: Integrator) -> Option<Outcome<R>> {
        let nodes = self.model.assembly.system.nodes();
        let Model { start, velocity, pose, .. } = &mut *self.model;
        for vectors in [start, velocity, pose] {
            vectors.resize(nodes, SVector::zeros());
        }
        self.gather();
        let has_rows = has_rows(self.batches);
        match integrator {
            Integrator::GeneralizedAlpha | Integrator::Rodas4 if has_rows => self.sdirk2(h),
            Integrator::LinearlyImplicitEuler => self.implicit_euler(h, true),
            Integrator::PaperEuler => self.implicit_euler(h, false),
            Integrator::Sdirk2 => self.sdirk2(h),
            Integrator::GeneralizedAlpha => self.generalized_alpha(h),
            Integrator::Rodas4 => self.rodas4(h),
            // Explicit methods are those of `packed`.
            Integrator::SymplecticEuler | Integrator::RungeKutta4 => None,
        }
    }
    /// Reads the initial velocities from the bodies.
    fn gather(&mut self) {
        let Model { assembly, start, velocity, pose, .. } = &mut *self.model;
        for (body, node) in self.store.rigid.iter().zip(&assembly.nodes[0]) {
            if let Some(node) = *node {
                start[node] = SVector::zeros();
                add_linear(&mut start[node], body.velocity);
                add_angular(&mut start[node], body.angular_velocity);
            }
        }
        for (body, node) in self.store.particles.iter().zip(&assembly.nodes[1]) {
            if let Some(node) = *node {
                start[node] = SVector::zeros();
                add_linear(&mut start[node], body.velocity);
            }
        }
        velocity.copy_from_slice(start);
        pose.fill(SVector::zeros());
    }

    /// Sets bodies to the model's poses, relative to the saved ones, and velocities; moves kinematic bodies.
    fn set(&mut self, time: R) {
        self.clock = time;
        let Model { assembly, velocity, pose, .. } = &*self.model;
        for (k, (body, node)) in self.store.rigid.iter_mut().zip(&assembly.nodes[0]).enumerate() {
            let saved = &self.saved.rigid[k];
            *body = match *node {
                Some(node) => {
                    let body = moved(saved, linear(&pose[node]), angular(&pose[node]));
                    let (velocity, angular_velocity) = (linear(&velocity[node]), angular(&velocity[node]));
                    Rigid { velocity, angular_velocity, ..body }
                }
                None => moved(saved, saved.velocity * time, saved.angular_velocity * time),
            };
        }
        for (k, (body, node)) in self.store.particles.iter_mut().zip(&assembly.nodes[1]).enumerate() {
            let saved = &self.saved.particles[k];
            let (way, speed) = match *node {
                Some(node) => (linear(&pose[node]), linear(&velocity[node])),
                None => (saved.velocity * time, saved.velocity),
            };
            *body = Particle { position: saved.position + way, velocity: speed };
        }
    }

    /// Assembles the system at the present state.
    fn assemble(&mut self, damping: R, stiffness: R, wants: Wants) {
        let out = &mut self.model.assembly;
        (out.damping, out.stiffness, out.wants) = (damping, stiffness, wants);
        let timer = Instant::now();
        let _span = span("assembly");
        out.clear();
        for batch in self.batches.iter_mut() {
            batch.assemble(&self.store.bodies(), out.sums());
        }
        out.add_bodies(self.store, self.outside, self.clock);
        if wants.matrix {
            out.regularize();
        }
        self.report.assembly += timer.elapsed();
    }

    /// Solves the system with the selected method; `None` after a breakdown.
    fn solve(&mut self) -> Option<()> {
        let timer = Instant::now();
        let _span = span("solve");
        let Model { assembly, space, .. } = &mut *self.model;
        let system = &mut assembly.system;
        let tolerance = R::default_epsilon().sqrt() * convert(0.1);
        let iterate = system.products() > MOST_PRODUCTS * system.nodes();
        let has_rows = has_rows(self.batches);
        let method = match self.solver {
            // The system of rigid rows is not definite.
            _ if has_rows => Solver::Direct,
            Solver::Automatic if iterate => Solver::BiCgStab,
            Solver::Automatic => Solver::Direct,
            chosen => chosen,
        };
        let mut eliminates = method == Solver::Direct;
        let mut solved = eliminates;
        if !eliminates {
            let iterations = system.iterate(method, tolerance, space);
            solved = iterations.is_some();
            eliminates = !solved && self.solver == Solver::Automatic;
            self.report.iterations += iterations.unwrap_or(0);
            self.report.breakdowns += usize::from(!solved);
        }
        if eliminates {
            system.solve();
        }
        self.report.solve += timer.elapsed();
        (solved || eliminates).then_some(())
    }
}

/// Visits every dynamic body: its node and mass, for a rigid body also its index and principal moments.
fn each_mass<R: RealField + Copy>(
    store: &Store<R>,
    nodes: &[Vec<Option<usize>>; 2],
    mut visit: impl FnMut(usize, R, Option<(usize, Vector3<R>)>),
) {
    for (index, (member, node)) in store.members[0].iter().zip(&nodes[0]).enumerate() {
        if let (Some((mass, moments)), Some(node)) = (member.inertia(), *node) {
            visit(node, mass, Some((index, moments)));
        }
    }
    for (member, node) in store.members[1].iter().zip(&nodes[1]) {
        if let (Some((mass, _)), Some(node)) = (member.inertia(), *node) {
            visit(node, mass, None);
        }
    }
}
