//! Steps of a world through time.
//!
//! Every method solves (M − hγ D − (hγ)² K) δ = b with K = ∂f/∂x and D = ∂f/∂v. Among the forces is the gyroscopic torque
//! −ω × Iω with its derivatives; the rotational diagonal block of K carries the inertia term `[τ]× − I [α]×`, since the
//! inertia turns with the body: τ is the whole torque, α = I⁻¹τ. Rotations are advanced by the exponential map.
//!
//! A step is accepted if the solution is finite and the residual small; else the state is restored and the time is
//! covered in halves, up to ten times over.

use crate::batch::Assembly;
use crate::error::Error;
use crate::world::{Motion, World};
use crate::{Particle, Rigid};
use nalgebra::{Matrix3, RealField, UnitQuaternion, Vector3, Vector6, convert};

/// A method of integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// (M − hD − h²K) δv = h (f₀ + h K v₀), of order one.
    LinearlyImplicitEuler,
    /// The same without the derivatives of gyroscopic torque and turning inertia: A = I − hW(∂f/∂v + h ∂f/∂x) as in
    /// D'Amora et al., IBM Systems Journal 45(1), 2006. For comparison.
    PaperEuler,
    /// Two stages with γ = 1 − 1/√2, L-stable, of order two; each stage is linearised at its predicted pose.
    #[default]
    Sdirk2,
    /// v += h M⁻¹f, then x ⊕= h v, of order one; explicit.
    SymplecticEuler,
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepReport<R> {
    /// Steps that were accepted to cover the time.
    pub accepted: usize,
    /// Steps that were discarded.
    pub rejected: usize,
    /// The largest relative residual |b − A x| / |b| of an accepted solution.
    pub residual: R,
}

/// State before a step and what its first stage gave.
#[derive(Debug)]
pub(crate) struct Scratch<R: RealField> {
    rigid: Vec<Rigid<R>>,
    particles: Vec<Particle<R>>,
    first: Vec<Vector6<R>>,
}

impl<R: RealField> Default for Scratch<R> {
    fn default() -> Scratch<R> {
        Scratch { rigid: Vec::new(), particles: Vec::new(), first: Vec::new() }
    }
}

/// How often a step may be halved.
const HALVINGS: u32 = 10;

impl<R: RealField + Copy> World<R> {
    /// Moves the world on by a time `h`, s. Zero changes nothing; where no step is good, the state is the last good one.
    pub fn step(&mut self, h: R, integrator: Integrator) -> Result<StepReport<R>, Error> {
        if !h.is_finite() {
            return Err(Error::NotFinite("step"));
        }
        if h < R::zero() {
            return Err(Error::NegativeStep);
        }
        let mut report = StepReport { accepted: 0, rejected: 0, residual: R::zero() };
        if h == R::zero() {
            return Ok(report);
        }
        self.prepare();
        let half = convert::<f64, R>(0.5);
        let (mut size, mut depth, mut left) = (h, 0, 1_u32);
        while left > 0 {
            self.scratch.rigid.clone_from(&self.rigid);
            self.scratch.particles.clone_from(&self.particles);
            match self.attempt(size, integrator) {
                Some(residual) => {
                    report.accepted += 1;
                    report.residual = report.residual.max(residual);
                    left -= 1;
                }
                None => {
                    self.restore();
                    report.rejected += 1;
                    if depth == HALVINGS {
                        return Err(Error::StepFailed);
                    }
                    (size, depth, left) = (size * half, depth + 1, left * 2);
                }
            }
        }
        Ok(report)
    }

    /// One step without control: the residual, or nothing if it is no good.
    fn attempt(&mut self, h: R, integrator: Integrator) -> Option<R> {
        let zero = R::zero();
        let residual = match integrator {
            Integrator::LinearlyImplicitEuler | Integrator::PaperEuler => {
                self.assemble(h, integrator == Integrator::LinearlyImplicitEuler);
                let Assembly { system, force, drift, .. } = &mut self.assembly;
                for ((b, f), kv) in system.rhs.iter_mut().zip(force).zip(drift) {
                    *b = (*f + *kv * h) * h;
                }
                let residual = self.assembly.system.solve();
                self.change_velocities();
                self.advance(h, zero);
                residual
            }
            Integrator::SymplecticEuler => {
                self.assemble(zero, false);
                let Assembly { system, force, .. } = &mut self.assembly;
                for (b, f) in system.rhs.iter_mut().zip(force) {
                    *b = *f * h;
                }
                let residual = self.assembly.system.solve();
                self.change_velocities();
                self.advance(h, zero);
                residual
            }
            Integrator::Sdirk2 => self.sdirk2(h),
        };
        let finite = self.assembly.system.rhs.iter().all(|x| x.iter().all(|x| x.is_finite()));
        // Of single precision a thousand roundings, of double precision far more than that.
        let bound = R::default_epsilon().sqrt().min(convert(1e-4));
        let good = finite && residual.is_finite() && residual <= bound && self.is_finite();
        good.then_some(residual)
    }

    /// Alexander's method: v₁ = v₀ + hγ a₁, v₂ = v₀ + h(1−γ) a₁ + hγ a₂, and so for the pose.
    ///
    /// Both stages start from a guess and are linear about it: the first from v₀ and x₀ ⊕ hγ v₀, the second from v₁ and
    /// x₀ ⊕ h v₁. The second pose increment θ carries dexp⁻¹: θ = h(1−γ) ω₁ + hγ (ω₂ − ½ θ × ω₂).
    fn sdirk2(&mut self, h: R) -> R {
        let gamma = convert::<f64, R>(1.0 - std::f64::consts::FRAC_1_SQRT_2);
        let step = h * gamma;
        let back = (R::one() - gamma) / gamma;
        self.advance(step, R::zero());
        self.assemble(step, true);
        let Assembly { system, force, .. } = &mut self.assembly;
        for (b, f) in system.rhs.iter_mut().zip(force) {
            *b = *f * step;
        }
        let first = self.assembly.system.solve();
        self.scratch.first.clone_from(&self.assembly.system.rhs);
        self.change_velocities();

        self.poses_from_saved();
        self.advance(h, R::zero());
        self.assemble(step, true);
        let Assembly { system, force, .. } = &mut self.assembly;
        for (b, f) in system.rhs.iter_mut().zip(force) {
            *b = *f * step;
        }
        self.add_momentum(back - R::one());
        let second = self.assembly.system.solve();
        self.change_velocities();

        self.poses_from_saved();
        self.advance(h, step);
        first.max(second)
    }

    /// Forces, M − `step` D − `step`² K and K v at the present state.
    fn assemble(&mut self, step: R, exact: bool) {
        let mut out = std::mem::take(&mut self.assembly);
        out.damping = step;
        out.stiffness = step * step;
        out.system.clear();
        out.force.fill(Vector6::zeros());
        out.drift.fill(Vector6::zeros());
        let mut batches = std::mem::take(&mut self.batches);
        for batch in &mut batches {
            batch.assemble(&self.bodies(), &mut out);
        }
        self.batches = batches;
        for (index, slot) in self.slots[0].iter().enumerate() {
            let (Motion::Dynamic(mass, inertia), Some(node)) = (slot.motion, out.nodes[0][index]) else {
                continue;
            };
            let body = &self.rigid[index];
            let inertia = world_inertia(body, inertia);
            let spin = body.angular_velocity;
            let momentum = inertia * spin;
            let mut force = out.force[node];
            let mut rows = force.fixed_rows_mut::<3>(0);
            rows += self.gravity * mass;
            let mut rows = force.fixed_rows_mut::<3>(3);
            rows += momentum.cross(&spin);
            out.force[node] = force;
            let block = out.system.block(node, node);
            for i in 0..3 {
                block[(i, i)] += mass;
            }
            let mut turning = block.fixed_view_mut::<3, 3>(3, 3);
            turning += inertia;
            if !exact {
                continue;
            }
            let torque = Vector3::new(force[3], force[4], force[5]);
            let (Some(inverse), w, l) = (inertia.try_inverse(), spin.cross_matrix(), momentum.cross_matrix())
            else {
                continue;
            };
            let gyroscopic = w * (l - inertia * w);
            let stiffness = gyroscopic + torque.cross_matrix() - inertia * (inverse * torque).cross_matrix();
            turning -= (l - w * inertia) * step + stiffness * (step * step);
            let mut rows = out.drift[node].fixed_rows_mut::<3>(3);
            rows += stiffness * spin;
        }
        for (index, slot) in self.slots[1].iter().enumerate() {
            let (Motion::Dynamic(mass, _), Some(node)) = (slot.motion, out.nodes[1][index]) else { continue };
            let mut rows = out.force[node].fixed_rows_mut::<3>(0);
            rows += self.gravity * mass;
            let block = out.system.block(node, node);
            for i in 0..3 {
                block[(i, i)] += mass;
                block[(i + 3, i + 3)] = R::one();
            }
        }
        self.assembly = out;
    }

    /// Adds `scale` M δ₁ to the right-hand side.
    fn add_momentum(&mut self, scale: R) {
        let rhs = &mut self.assembly.system.rhs;
        for (kind, slots) in self.slots.iter().enumerate() {
            for (index, slot) in slots.iter().enumerate() {
                let (Motion::Dynamic(mass, inertia), Some(node)) =
                    (slot.motion, self.assembly.nodes[kind][index])
                else {
                    continue;
                };
                let first = self.scratch.first[node] * scale;
                let mut rows = rhs[node].fixed_rows_mut::<3>(0);
                rows += first.fixed_rows::<3>(0) * mass;
                if kind == 0 {
                    let turn = world_inertia(&self.rigid[index], inertia) * first.fixed_rows::<3>(3);
                    let mut rows = rhs[node].fixed_rows_mut::<3>(3);
                    rows += turn;
                }
            }
        }
    }

    /// v += the solution.
    fn change_velocities(&mut self) {
        let change = &self.assembly.system.rhs;
        for (body, node) in self.rigid.iter_mut().zip(&self.assembly.nodes[0]) {
            if let Some(node) = *node {
                body.velocity += change[node].fixed_rows::<3>(0);
                body.angular_velocity += change[node].fixed_rows::<3>(3);
            }
        }
        for (body, node) in self.particles.iter_mut().zip(&self.assembly.nodes[1]) {
            if let Some(node) = *node {
                body.velocity += change[node].fixed_rows::<3>(0);
            }
        }
    }

    /// x ⊕= h v; where `last` is not zero, v₁ for the time h − `last` and v₂ for `last`, as `sdirk2` ends.
    fn advance(&mut self, h: R, last: R) {
        let half = convert::<f64, R>(0.5);
        let earlier = h - last;
        let change = &self.assembly.system.rhs;
        for (body, node) in self.rigid.iter_mut().zip(&self.assembly.nodes[0]) {
            let (mut way, mut turn) = (body.velocity * h, body.angular_velocity * h);
            if let (Some(node), true) = (*node, last != R::zero()) {
                way -= change[node].fixed_rows::<3>(0) * earlier;
                turn -= change[node].fixed_rows::<3>(3) * earlier;
                turn -= turn.cross(&body.angular_velocity) * (half * last);
            }
            body.position += way;
            let turned = UnitQuaternion::from_scaled_axis(turn) * body.orientation;
            body.orientation = UnitQuaternion::new_normalize(turned.into_inner());
        }
        for (body, node) in self.particles.iter_mut().zip(&self.assembly.nodes[1]) {
            let mut way = body.velocity * h;
            if let (Some(node), true) = (*node, last != R::zero()) {
                way -= change[node].fixed_rows::<3>(0) * earlier;
            }
            body.position += way;
        }
    }

    fn poses_from_saved(&mut self) {
        for (body, saved) in self.rigid.iter_mut().zip(&self.scratch.rigid) {
            body.position = saved.position;
            body.orientation = saved.orientation;
        }
        for (body, saved) in self.particles.iter_mut().zip(&self.scratch.particles) {
            body.position = saved.position;
        }
    }

    fn restore(&mut self) {
        self.rigid.copy_from_slice(&self.scratch.rigid);
        self.particles.copy_from_slice(&self.scratch.particles);
    }

    fn is_finite(&self) -> bool {
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

/// R I Rᵀ.
fn world_inertia<R: RealField + Copy>(body: &Rigid<R>, inertia: Vector3<R>) -> Matrix3<R> {
    let turn = body.orientation.to_rotation_matrix();
    turn.matrix() * Matrix3::from_diagonal(&inertia) * turn.matrix().transpose()
}
