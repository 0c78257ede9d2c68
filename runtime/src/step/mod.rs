//! Methods of integration: one step of one island, without step control.
//!
//! Poses are relative to the start of the step: x₀ + δx, exp(δθ) q₀, with δ̇x = v and δ̇θ = dexp⁻¹_δθ(ω). A
//! method takes the state from the start to the end of the step. Kinematic bodies move at their velocity.
//!
//! All implicit methods solve (M − hγ D − s K) δ = b, with K = ∂f/∂x, D = ∂f/∂v, and s = (hγ)² in most
//! methods. The forces include the gyroscopic torque −ω × Iω with its derivatives. The rotational diagonal
//! block of K contains `[τ]× − I [α]×`, because the inertia turns with the body; τ is the total torque, or Iα
//! in a stage with multipliers.

mod alpha;

use crate::kernel::BodyKind;
use crate::kernel::bodies::{Particle, Rigid};
use crate::report::{Report, span};
use crate::state::{Poses, Store, moved};
use crate::system::assemble::{Assembly, Frame, Wants, add_angular, add_linear, angular, linear};
use crate::system::batch::{Batch, Sums};
use crate::system::iterative::{Solver, Workspace};
use nalgebra::{Matrix3, RealField, SVector, Vector3, convert};
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

/// The block products per node above which iterations are cheaper than elimination: about the number for a
/// square cloth of 200 × 200 particles.
const DEAR: usize = 20_000;

/// γ of SDIRK.
pub(crate) const SDIRK: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// The largest number of linearisations of a stage.
const LINEARISATIONS: usize = 3;

/// The rotation, rad, above which a stage is linearised again. At this rotation the error opens a joint by
/// 1e-4 of its arm, which the next step corrects.
const FAR: f64 = 0.016;

/// The same for an energy, whose derivatives contain the full error.
const NEAR: f64 = 0.002;

/// The data of a method, reused in every step.
pub(crate) struct Model<R: RealField, const D: usize> {
    pub(crate) assembly: Assembly<R, D>,
    pub(crate) space: Workspace<R, D>,
    /// Velocities at the start of the step.
    pub(crate) start: Vec<SVector<R, D>>,
    pub(crate) velocity: Vec<SVector<R, D>>,
    /// Poses of a stage.
    pose: Vec<SVector<R, D>>,
    /// The result of each stage, for poses and for velocities.
    pub(crate) stages: [[Vec<SVector<R, D>>; 6]; 2],
    /// The rates of the generalised-α method: a and v̇.
    pub(crate) rates: [Vec<SVector<R, D>>; 2],
    /// The two polynomial terms of dense output, for poses and for velocities.
    dense: [[Vec<SVector<R, D>>; 2]; 2],
    /// The change of poses and velocities in a whole step.
    change: [Vec<SVector<R, D>>; 2],
    /// ∂f/∂t, and the matrix B of each body in the Rosenbrock method.
    driven: Vec<SVector<R, D>>,
    bends: Vec<Matrix3<R>>,
}

impl<R: RealField + Copy, const D: usize> Model<R, D> {
    pub(crate) fn new(assembly: Assembly<R, D>) -> Model<R, D> {
        Model {
            assembly,
            space: Workspace::default(),
            start: Vec::new(),
            velocity: Vec::new(),
            pose: Vec::new(),
            stages: Default::default(),
            rates: Default::default(),
            dense: Default::default(),
            change: Default::default(),
            driven: Vec::new(),
            bends: Vec::new(),
        }
    }

    /// Adds K to the matrix of a Rosenbrock method: A −= hγ K B.
    fn bend(&mut self, step: R) {
        let half = convert::<f64, R>(0.5);
        self.bends.clear();
        self.bends.extend(self.start.iter().map(|v| {
            let matrix = Matrix3::identity() / step - angular(v).cross_matrix() * half;
            matrix.try_inverse().unwrap_or_else(|| Matrix3::identity() * step)
        }));
        let Assembly { system, tangent, .. } = &mut self.assembly;
        let mut blocks = std::mem::take(&mut system.blocks);
        system.each_block(|place, _, column| {
            for row in 0..D {
                let k = SVector::<R, D>::from(tangent[place].0[row]);
                let mut bent = k * step;
                if D == 6 {
                    let turned = self.bends[column].tr_mul(&angular(&k));
                    (3..D).for_each(|j| bent[j] = turned[j - 3]);
                }
                for j in 0..D {
                    blocks[place].0[row][j] -= bent[j] * step;
                }
            }
        });
        system.blocks = blocks;
    }

    /// A body at a fraction `share` of the last step; `None` unless that was a step of `Rodas4`.
    pub(crate) fn between(
        &self,
        kind: BodyKind,
        index: usize,
        share: R,
        saved: Rigid<R>,
    ) -> Option<Rigid<R>> {
        let node = self.assembly.nodes[kind as usize].get(index).copied()??;
        let at = |part: usize| {
            let [third, fourth] = self.dense[part].each_ref().map(|terms| terms.get(node));
            let bend = (third? + fourth? * share) * (R::one() - share);
            Some((self.change[part].get(node)? + bend) * share)
        };
        let (pose, velocity) = (at(0)?, at(1)?);
        let body = moved(&saved, linear(&pose), angular(&pose));
        Some(Rigid {
            velocity: saved.velocity + linear(&velocity),
            angular_velocity: saved.angular_velocity + angular(&velocity),
            ..body
        })
    }

    /// B x for one node.
    fn bent(&self, node: usize, step: R, x: &SVector<R, D>) -> SVector<R, D> {
        let mut bent = x * step;
        if D == 6 {
            let turned = self.bends[node] * angular(x);
            (3..D).for_each(|j| bent[j] = turned[j - 3]);
        }
        bent
    }
}

/// One step of one island.
pub(crate) struct Stepper<'a, R: RealField, const D: usize> {
    pub(crate) store: &'a mut Store<R>,
    /// The bodies at the start of the step.
    pub(crate) saved: &'a Poses<R>,
    pub(crate) batches: &'a mut [Box<dyn Batch<R>>],
    pub(crate) model: &'a mut Model<R, D>,
    pub(crate) gravity: Vector3<R>,
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
        match integrator {
            Integrator::LinearlyImplicitEuler => self.implicit_euler(h, true),
            Integrator::PaperEuler => self.implicit_euler(h, false),
            Integrator::Sdirk2 => self.sdirk2(h),
            Integrator::GeneralizedAlpha => self.generalized_alpha(h),
            Integrator::Rodas4 => self.rodas4(h),
            Integrator::SymplecticEuler => self.symplectic_euler(h),
            Integrator::RungeKutta4 => self.runge_kutta(h),
        }
    }

    fn implicit_euler(&mut self, h: R, exact: bool) -> Option<Outcome<R>> {
        self.assemble(h, h * h, Wants { matrix: true, exact, drift: true, ..Wants::default() });
        let Assembly { system, force, drift, .. } = &mut self.model.assembly;
        for ((b, f), kv) in system.rhs.iter_mut().zip(force).zip(drift) {
            *b = (*f + *kv * h) * h;
        }
        self.solve()?;
        let residual = self.residual();
        let Model { assembly, velocity, pose, .. } = &mut *self.model;
        for ((v, x), change) in velocity.iter_mut().zip(pose).zip(&assembly.system.rhs) {
            *v += *change;
            *x = *v * h;
        }
        self.set(h);
        Some(Outcome { residual, error: None })
    }

    /// Alexander's method: v₁ = v₀ + hγ a₁, v₂ = v₀ + h(1−γ) a₁ + hγ a₂, and likewise for poses. The second
    /// pose increment θ includes dexp⁻¹: θ = h(1−γ) ω₁ + hγ (ω₂ − ½ θ × ω₂).
    ///
    /// The initial guess of the first stage is v₀ and x₀ ⊕ hγ v₀, that of the second v₁ and x₀ ⊕ h v₁.
    pub(crate) fn sdirk2(&mut self, h: R) -> Option<Outcome<R>> {
        let gamma = convert::<f64, R>(SDIRK);
        let step = h * gamma;
        let Model { start, stages: [_, [origin, middle, ..]], .. } = &mut *self.model;
        origin.clone_from(start);
        middle.clone_from(start);
        let first = self.stage(step, step, step * step, |_, v| v * step)?;
        let Model { start, velocity, stages: [_, [origin, middle, ..]], .. } = &mut *self.model;
        middle.clone_from(velocity);
        let share = (R::one() - gamma) / gamma;
        for ((origin, v0), v1) in origin.iter_mut().zip(start).zip(middle) {
            *origin = *v0 + (*v1 - *v0) * share;
        }
        let second = self.stage(h, step, step * step, |v1, v2| {
            let mut x = v1 * (h - step) + v2 * step;
            let bend = angular(&x).cross(&angular(v2)) * (step * convert::<f64, R>(0.5));
            add_angular(&mut x, -bend);
            x
        })?;
        self.set(h);
        Some(Outcome { residual: first.max(second), error: None })
    }

    /// Solves one stage: v = o + a `step` with o = `stages[1][0]`, and the pose `at(stages[1][1], v)`;
    /// returns the residual. `velocity` contains the initial guess; `stiffness` / `step` is the change of the
    /// pose per change of v.
    ///
    /// The stage is linearised at the guess. For forces with an arm the error is quadratic in the rotation
    /// from the guess; after a large rotation the stage is linearised again at the solution.
    pub(crate) fn stage(
        &mut self,
        time: R,
        step: R,
        stiffness: R,
        at: impl Fn(&SVector<R, D>, &SVector<R, D>) -> SVector<R, D>,
    ) -> Option<R> {
        let Model { velocity, pose, stages: [_, [_, before, ..]], .. } = &mut *self.model;
        for ((x, v), before) in pose.iter_mut().zip(velocity).zip(before) {
            *x = at(before, v);
        }
        let held = self.batches.iter().any(|batch| batch.has_multipliers());
        let far = if held && !self.batches.iter().any(|batch| batch.is_energy()) { FAR } else { NEAR };
        for left in (0..LINEARISATIONS).rev() {
            self.set(time);
            let Model { assembly, velocity, stages: [_, [origin, ..]], .. } = &mut *self.model;
            for ((lag, v), origin) in assembly.lag.iter_mut().zip(velocity).zip(origin) {
                *lag = *v - *origin;
            }
            let wants = Wants { matrix: true, exact: true, lag: true, held, ..Wants::default() };
            self.assemble(step, stiffness, wants);
            let Assembly { system, force, lag, .. } = &mut self.model.assembly;
            for ((b, f), momentum) in system.rhs.iter_mut().zip(force).zip(lag) {
                *b = *f * step - *momentum;
            }
            self.solve()?;
            for batch in self.batches.iter_mut() {
                batch.predict(self.model.assembly.sums());
            }
            let Model { assembly, velocity, pose, stages: [_, [_, before, ..]], .. } = &mut *self.model;
            let mut turned = R::zero();
            for (((x, v), change), before) in
                pose.iter_mut().zip(velocity).zip(&assembly.system.rhs).zip(before)
            {
                *v += *change;
                turned = turned.max(angular(change).norm_squared());
                *x = at(before, v);
            }
            if left == 0 || turned.sqrt() * (stiffness / step) <= convert(far) {
                break;
            }
        }
        // Earlier solutions are only guesses.
        Some(self.residual())
    }

    fn symplectic_euler(&mut self, h: R) -> Option<Outcome<R>> {
        self.accelerate();
        let Model { assembly, velocity, pose, .. } = &mut *self.model;
        for ((v, x), a) in velocity.iter_mut().zip(pose).zip(&assembly.system.rhs) {
            *v += *a * h;
            *x = *v * h;
        }
        self.set(h);
        Some(Outcome { residual: R::zero(), error: None })
    }

    fn runge_kutta(&mut self, h: R) -> Option<Outcome<R>> {
        let number = convert::<f64, R>;
        let nodes = self.model.start.len();
        let mut total = std::mem::take(&mut self.model.change);
        for sum in &mut total {
            sum.clear();
            sum.resize(nodes, SVector::zeros());
        }
        for (weight, next) in [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)] {
            self.accelerate();
            let (weight, next) = (number(weight / 6.0) * h, number(next) * h);
            let Model { assembly, start, velocity, pose, .. } = &mut *self.model;
            for node in 0..nodes {
                let rate = pose_rate(&pose[node], &velocity[node]);
                let acceleration = assembly.system.rhs[node];
                total[0][node] += rate * weight;
                total[1][node] += acceleration * weight;
                pose[node] = rate * next;
                velocity[node] = start[node] + acceleration * next;
            }
            self.set(next);
        }
        let Model { start, velocity, pose, .. } = &mut *self.model;
        for node in 0..nodes {
            pose[node] = total[0][node];
            velocity[node] = start[node] + total[1][node];
        }
        self.model.change = total;
        self.set(h);
        Some(Outcome { residual: R::zero(), error: None })
    }

    /// A Rosenbrock method for u = (uδ, uv): with B = (1/(hγ) − ½[ω₀]×)⁻¹ in the rotational block and hγ
    /// elsewhere, uδ = B (rδ + uv) and (M₀ − hγ D − hγ K B) uv = hγ (M₀ rv + K B rδ).
    fn rodas4(&mut self, h: R) -> Option<Outcome<R>> {
        let number = convert::<f64, R>;
        let step = h * number(rodas::GAMMA);
        let nodes = self.model.start.len();
        for stage in self.model.stages.iter_mut().flatten() {
            stage.resize(nodes, SVector::zeros());
        }
        let wants = Wants { matrix: true, exact: true, drift: true, tangent: true, ..Wants::default() };
        self.assemble(step, R::zero(), wants);
        self.model.bend(step);
        self.model.assembly.system.factor();
        self.model.driven.clone_from(&self.model.assembly.driven);
        let mut residual = R::zero();
        for stage in 0..6 {
            if stage > 0 {
                let Model { start, velocity, pose, stages, .. } = &mut *self.model;
                for node in 0..nodes {
                    pose[node] = weighted(&stages[0], rodas::STATES[stage], node);
                    velocity[node] = start[node] + weighted(&stages[1], rodas::STATES[stage], node);
                }
                self.set(number(rodas::TIMES[stage]) * h);
                self.assemble(R::zero(), R::zero(), Wants::default());
            }
            residual = residual.max(self.rosenbrock_stage(stage, h, step));
        }
        let Model { start, velocity, pose, stages, dense, change, .. } = &mut *self.model;
        for part in 0..2 {
            for (terms, weights) in dense[part].iter_mut().zip(&rodas::DENSE) {
                terms.clear();
                terms.extend((0..nodes).map(|node| weighted(&stages[part], weights, node)));
            }
            let last = |node| weighted(&stages[part], rodas::STATES[5], node) + stages[part][5][node];
            change[part].clear();
            change[part].extend((0..nodes).map(last));
        }
        let mut error = R::zero();
        for node in 0..nodes {
            pose[node] = change[0][node];
            velocity[node] = start[node] + change[1][node];
            error = error.max(stages[0][5][node].amax()).max(stages[1][5][node].amax() * h);
        }
        self.set(h);
        Some(Outcome { residual, error: Some(error) })
    }

    /// Solves one stage for u at the present state; returns the residual.
    fn rosenbrock_stage(&mut self, stage: usize, h: R, step: R) -> R {
        let time = convert::<f64, R>(rodas::DRIVEN[stage]) * h;
        let Model { assembly, velocity, pose, stages, driven, .. } = &mut *self.model;
        let mut rates = std::mem::take(&mut stages[0][stage]);
        let mut right = std::mem::take(&mut assembly.system.rhs);
        for (node, rate) in rates.iter_mut().enumerate() {
            let earlier = weighted(&stages[0], rodas::RATES[stage], node) / h;
            *rate = pose_rate(&pose[node], &velocity[node]) + earlier;
            right[node] = driven[node] * time;
        }
        each_mass(self.store, &assembly.nodes, |node, mass, body| {
            let force = &assembly.force[node];
            let earlier = weighted(&stages[1], rodas::RATES[stage], node) / h;
            add_linear(&mut right[node], linear(force) + linear(&earlier) * mass);
            if let Some((index, moments)) = body {
                let rate = Frame::new(&self.store.rigid[index], moments).accelerate(&angular(force));
                let inertia = Frame::new(&self.saved.rigid[index], moments).inertia();
                add_angular(&mut right[node], inertia * (rate + angular(&earlier)));
            }
        });
        for (node, rate) in rates.iter_mut().enumerate() {
            *rate = self.model.bent(node, step, rate);
        }
        let Assembly { system, tangent, .. } = &mut self.model.assembly;
        system.add_product(tangent, &rates, &mut right);
        right.iter_mut().for_each(|right| *right *= step);
        system.rhs = right;
        system.solve_again();
        let residual = system.residual();
        for (node, rate) in rates.iter_mut().enumerate() {
            *rate += self.model.bent(node, step, &self.model.assembly.system.rhs[node]);
        }
        self.model.stages[0][stage] = rates;
        self.model.stages[1][stage].copy_from_slice(&self.model.assembly.system.rhs);
        residual
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
    pub(crate) fn set(&mut self, time: R) {
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
        out.add_bodies(self.store, self.gravity);
        self.report.assembly += timer.elapsed();
    }

    /// Computes accelerations at the present state into the right-hand side.
    fn accelerate(&mut self) {
        self.assemble(R::zero(), R::zero(), Wants::default());
        let Assembly { system, force, nodes, .. } = &mut self.model.assembly;
        let rhs = &mut system.rhs;
        each_mass(self.store, nodes, |node, mass, body| {
            rhs[node] = SVector::zeros();
            add_linear(&mut rhs[node], linear(&force[node]) / mass);
            if let Some((index, moments)) = body {
                let frame = Frame::new(&self.store.rigid[index], moments);
                add_angular(&mut rhs[node], frame.accelerate(&angular(&force[node])));
            }
        });
    }

    /// Solves the system with the selected method; `None` after a breakdown.
    fn solve(&mut self) -> Option<()> {
        let timer = Instant::now();
        let _span = span("solve");
        let Model { assembly, space, .. } = &mut *self.model;
        let system = &mut assembly.system;
        let tolerance = R::default_epsilon().sqrt() * convert(0.1);
        let dear = system.products() > DEAR * system.nodes();
        let method = match self.solver {
            Solver::Automatic if dear => Solver::BiCgStab,
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

    /// The relative residual of the last solution.
    fn residual(&mut self) -> R {
        let timer = Instant::now();
        let residual = self.model.assembly.system.residual();
        self.report.solve += timer.elapsed();
        residual
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

/// δ̇ of a pose: v, and dexp⁻¹_θ(ω) = ω − ½ θ×ω + (1 − |θ|/2 cot(|θ|/2)) / |θ|² θ×(θ×ω).
fn pose_rate<R: RealField + Copy, const D: usize>(
    pose: &SVector<R, D>,
    velocity: &SVector<R, D>,
) -> SVector<R, D> {
    let number = convert::<f64, R>;
    let (turn, spin) = (angular(pose), angular(velocity));
    let square = turn.norm_squared();
    // For smaller angles the series is exact to rounding: its next term is |θ|⁴/30240.
    let factor = if square < number(1e-4) {
        number(1.0 / 12.0) + square * number(1.0 / 720.0)
    } else {
        let half = square.sqrt() * number(0.5);
        (R::one() - half / half.tan()) / square
    };
    let across = turn.cross(&spin);
    let mut rate = *velocity;
    add_angular(&mut rate, turn.cross(&across) * factor - across * number(0.5));
    rate
}

/// Σ wⱼ uⱼ over the earlier stages.
fn weighted<R: RealField + Copy, const D: usize>(
    stages: &[Vec<SVector<R, D>>; 6],
    weights: &[f64],
    node: usize,
) -> SVector<R, D> {
    let mut sum = SVector::zeros();
    for (stage, &weight) in stages.iter().zip(weights) {
        sum += stage[node] * convert::<f64, R>(weight);
    }
    sum
}

/// The coefficients of RODAS, Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, IV.10.
mod rodas {
    /// γ
    pub(crate) const GAMMA: f64 = 0.25;
    /// αᵢ: the time of each stage.
    pub(crate) const TIMES: [f64; 6] = [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];
    /// γᵢ: the factor of h ∂f/∂t in each stage.
    pub(crate) const DRIVEN: [f64; 6] = [0.25, -0.1043, 0.1035, -0.03620000000000023, 0.0, 0.0];
    /// aᵢⱼ: the state of each stage. The last adds the difference to the embedded method of order three.
    pub(crate) const STATES: [&[f64]; 6] = [
        &[],
        &[1.544],
        &[0.9466785280815826, 0.2557011698983284],
        &[3.314825187068521, 2.896124015972201, 0.9986419139977817],
        &[1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895],
        &[1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895, 1.0],
    ];
    /// cᵢⱼ
    pub(crate) const RATES: [&[f64]; 6] = [
        &[],
        &[-5.6688],
        &[-2.430093356833875, -0.2063599157091915],
        &[-0.1073529058151375, -9.594562251023355, -20.47028614809616],
        &[7.496443313967647, -10.24680431464352, -33.99990352819905, 11.7089089320616],
        &[8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054],
    ];
    /// The coefficients of dense output.
    pub(crate) const DENSE: [[f64; 5]; 2] = [
        [10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823, 1.025137723295662],
        [-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386, -6.594389125716872],
    ];
}
