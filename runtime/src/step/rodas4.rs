//! RODAS, a Rosenbrock method with six stages and one matrix, of order four.
//!
//! Input: the bodies at the start of a step and its length h. Output: the bodies at its end, the largest
//! relative residual of the stages, an error estimate from the embedded method of order three, and the
//! polynomials of dense output in the model.

use super::{BlockSize, Model, Outcome, Stepper, each_mass};
use crate::system::assemble::{Assembly, Wants};
use crate::system::inertia::{Frame, add_angular, add_linear, angular, linear};
use nalgebra::{Matrix3, RealField, SVector, convert};

impl<R: RealField + Copy, const D: usize> Stepper<'_, R, D>
where
    Assembly<R, D>: BlockSize<R>,
{
    /// A Rosenbrock method for u = (uδ, uv): with B = (1/(hγ) − ½[ω₀]×)⁻¹ in the rotational block and hγ
    /// elsewhere, uδ = B (rδ + uv) and (M₀ − hγ D − hγ K B) uv = hγ (M₀ rv + K B rδ).
    pub(super) fn rodas4(&mut self, h: R) -> Option<Outcome<R>> {
        let number = convert::<f64, R>;
        let step = h * number(rodas::GAMMA);
        let nodes = self.model.start.len();
        for stage in self.model.stages.iter_mut().flatten() {
            stage.resize(nodes, SVector::zeros());
        }
        let wants = Wants { matrix: true, exact: true, drift: true, tangent: true, ..Wants::default() };
        self.assemble(step, R::zero(), wants);
        self.model.add_stiffness(step);
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
        Some(Outcome { residual, error: Some(error), work: None })
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
            *rate = self.model.map_rate(node, step, rate);
        }
        let Assembly { system, tangent, .. } = &mut self.model.assembly;
        system.add_product(tangent, &rates, &mut right);
        right.iter_mut().for_each(|right| *right *= step);
        system.rhs = right;
        system.solve_again();
        let residual = system.residual();
        for (node, rate) in rates.iter_mut().enumerate() {
            *rate += self.model.map_rate(node, step, &self.model.assembly.system.rhs[node]);
        }
        self.model.stages[0][stage] = rates;
        self.model.stages[1][stage].copy_from_slice(&self.model.assembly.system.rhs);
        residual
    }
}

impl<R: RealField + Copy, const D: usize> Model<R, D> {
    /// Adds K to the matrix of a Rosenbrock method: A −= hγ K B.
    fn add_stiffness(&mut self, step: R) {
        let half = convert::<f64, R>(0.5);
        self.rotation_maps.clear();
        self.rotation_maps.extend(self.start.iter().map(|v| {
            let matrix = Matrix3::identity() / step - angular(v).cross_matrix() * half;
            matrix.try_inverse().unwrap_or_else(|| Matrix3::identity() * step)
        }));
        let Assembly { system, tangent, .. } = &mut self.assembly;
        let mut blocks = std::mem::take(&mut system.blocks);
        system.each_block(|place, _, column| {
            for row in 0..D {
                let k = SVector::<R, D>::from(tangent[place].0[row]);
                let mut mapped = k * step;
                if D == 6 {
                    let turned = self.rotation_maps[column].tr_mul(&angular(&k));
                    (3..D).for_each(|j| mapped[j] = turned[j - 3]);
                }
                for j in 0..D {
                    blocks[place].0[row][j] -= mapped[j] * step;
                }
            }
        });
        system.blocks = blocks;
    }

    /// B x for one node.
    fn map_rate(&self, node: usize, step: R, x: &SVector<R, D>) -> SVector<R, D> {
        let mut mapped = x * step;
        if D == 6 {
            let turned = self.rotation_maps[node] * angular(x);
            (3..D).for_each(|j| mapped[j] = turned[j - 3]);
        }
        mapped
    }
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
    pub(super) const GAMMA: f64 = 0.25;
    /// αᵢ: the time of each stage.
    pub(super) const TIMES: [f64; 6] = [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];
    /// γᵢ: the factor of h ∂f/∂t in each stage.
    pub(super) const DRIVEN: [f64; 6] = [0.25, -0.1043, 0.1035, -0.03620000000000023, 0.0, 0.0];
    /// aᵢⱼ: the state of each stage. The last adds the difference to the embedded method of order three.
    pub(super) const STATES: [&[f64]; 6] = [
        &[],
        &[1.544],
        &[0.9466785280815826, 0.2557011698983284],
        &[3.314825187068521, 2.896124015972201, 0.9986419139977817],
        &[1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895],
        &[1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895, 1.0],
    ];
    /// cᵢⱼ
    pub(super) const RATES: [&[f64]; 6] = [
        &[],
        &[-5.6688],
        &[-2.430093356833875, -0.2063599157091915],
        &[-0.1073529058151375, -9.594562251023355, -20.47028614809616],
        &[7.496443313967647, -10.24680431464352, -33.99990352819905, 11.7089089320616],
        &[8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054],
    ];
    /// The coefficients of dense output.
    pub(super) const DENSE: [[f64; 5]; 2] = [
        [10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823, 1.025137723295662],
        [-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386, -6.594389125716872],
    ];
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
