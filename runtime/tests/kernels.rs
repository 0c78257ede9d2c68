//! Code that the macros generate in a program: callable functions, kernels in modules, and the traits that
//! connect functions and kernels. All generated code compiles without a warning.

#![cfg(feature = "macros")]
#![deny(warnings, clippy::all)]

use forcec_runtime::{Bodies, BodyKind, Kernel, Linear, Parameters};

mod alone {
    // Only the names that the function itself needs are imported.
    use forcec_runtime::prelude::{Particle, Real, constraint, domain};

    #[domain(rest_length = 0.1..2.0)]
    #[constraint]
    pub(crate) fn spring(p0: Particle, p1: Particle, rest_length: Real) -> Real {
        (p1.position - p0.position).norm() - rest_length
    }

    // A private function with an unused kernel.
    #[constraint(real = f32, unilateral)]
    fn floor(p: Particle) -> Real {
        p.position.z
    }

    #[test]
    fn private_functions_can_be_called() {
        let p = Particle { position: [0.0, 0.0, 2.0].into(), ..Particle::default() };
        assert_eq!(floor(p), 2.0);
    }
}

/// Kernels with options: with results that the runtime calls and with results that it ignores, used and
/// unused.
mod chosen {
    use super::*;
    use forcec_runtime::prelude::*;

    #[constraint(fixed(q), set(damping = 0.0, at = [0.0, 0.0, 0.5]), outputs(value, jacobian), real = f64)]
    fn tie(p: Particle, q: Particle, at: Vec3) -> Vec3 {
        p.position - q.position - at
    }

    #[constraint(layout = "system", lanes = 4, mode = fast)]
    fn joint(p: Particle, q: Rigid) -> Vec3 {
        p.position - q.position
    }

    #[constraint(set(stiffness = 100.0, damping = 0))]
    fn known(p: Particle) -> Vec3 {
        p.position
    }

    #[constraint(per_row, set(stiffness = [1.0, 2.0, 4.0]))]
    fn by_row(p: Particle) -> Vec3 {
        p.position
    }

    #[test]
    fn options_make_kernels() {
        let p = Particle { position: [1.0, 2.0, 3.0].into(), ..Particle::default() };
        let mut out = tie_fixed_q_set_at_damping::Output::default();
        let params = tie_fixed_q_set_at_damping::Params { stiffness: 1.0 };
        tie_fixed_q_set_at_damping::evaluate(&p, &Particle::default(), &params, &mut out);
        assert_eq!((out.value, out.jacobian[0]), ([1.0, 2.0, 2.5], [1.0, 0.0, 0.0]));

        let mut out = joint_system_x4::Output::default();
        let params = joint_system_x4::Params { stiffness: [1.0; 4], damping: [0.0; 4] };
        let (p4, q4) = Default::default();
        joint_system_x4::evaluate(&p4, &q4, &params, 0.5, &mut out);
        assert_eq!(out.matrix[0][0], [-0.25; 4]);
    }

    /// Parameters set to constants also apply where a world measures the energy of a constraint.
    #[test]
    fn energy_knows_what_is_set() {
        type Known = known_set_stiffness_damping::Output;
        let particles = [Particle { position: [1.0, 1.0, 1.0].into(), ..Particle::default() }];
        let bodies = Bodies { rigid: &[], particles: &particles };
        assert_eq!(Known::measure(&bodies, [0], &()).energy, 150.0);
        let params = by_row_set_stiffness::Params { damping: [0.0; 3] };
        assert_eq!(by_row_set_stiffness::Output::measure(&bodies, [0], &params).energy, 3.5);
    }
}

#[forcec_runtime::forces]
mod fields {
    //! Fields.

    use forcec_runtime::prelude::*;

    const HALF: Real = 0.5;

    /// One half of something.
    fn half(x: Real) -> Real {
        HALF * x
    }

    /// Weight of a body that is tied to a rail, with more parameters than clippy likes.
    #[energy]
    pub(crate) fn rail(
        body: Rigid,
        weight: Real,
        stiffness: Real,
        origin: Vec3,
        along: Vec3,
        up: Vec3,
        series: [Real; 3],
        offset: Real,
    ) -> Real {
        let d = body.position - origin;
        let across = d - along * along.dot(&d);
        let mut sum = offset;
        for k in 0..3 {
            sum += series[k] * (k as Real);
        }
        weight * up.dot(&d) + half(stiffness * across.norm_squared()) + sum
    }

    /// A particle on a body.
    #[constraint(real = f64)]
    pub(crate) fn peg(p: Particle, b: Rigid, arm: Vec3) -> Vec3 {
        (b.position - p.position) + b.orientation * arm
    }

    /// A body turned home.
    #[force(real = f64)]
    pub(crate) fn homing(body: Rigid, p: Particle) -> (Wrench, Vec3) {
        (
            Wrench { force: p.position - body.position, torque: -body.angular_velocity },
            body.position - p.position,
        )
    }
}

mod single {
    use forcec_runtime::prelude_f32::*;

    /// Weight, all of it in single precision.
    #[energy(real = f32)]
    pub(crate) fn lift(p: Particle, mass: Real) -> Real {
        9.81 * mass * p.position.z
    }
}

#[test]
fn kernels_are_evaluated_in_place() {
    use forcec_runtime::prelude::*;
    let rigid = [Rigid::default(); 2];
    let mut particles = [Particle::default(); 3];
    particles[1].position = Vec3::new(3.0, 0.0, 0.0);
    let bodies = Bodies { rigid: &rigid, particles: &particles };

    let mut out = <alone::spring::Params as Parameters>::Kernel::default();
    let params = alone::spring::Params { rest_length: 1.0, stiffness: 10.0, damping: 0.0 };
    Kernel::evaluate(&mut out, &bodies, [2, 1], &params);
    assert_eq!(out.force(), [20.0, 0.0, 0.0, -20.0, 0.0, 0.0]);
    assert!((out.dfdx()[0] + 10.0).abs() < 1e-14, "{}", out.dfdx()[0]);
    assert_eq!(alone::spring::Output::NAME, "spring");
    assert_eq!(alone::spring::Output::BODIES, [BodyKind::Particle, BodyKind::Particle]);

    let mut out = fields::homing::Output::default();
    Kernel::evaluate(&mut out, &bodies, [1, 1], &());
    assert_eq!(out.force(), [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, -3.0, 0.0, 0.0]);
    assert_eq!(fields::homing::Output::DOFS, 9);
    assert_eq!(fields::homing::Output::DFDX_NONZERO[0], "x.....x..");
    assert_eq!(out.dfdv()[3 * 9 + 3], -1.0);

    assert_eq!(fields::rail(rigid[0], 1.0, 1.0, Vec3::zeros(), Vec3::x(), Vec3::z(), [1.0; 3], 0.5), 3.5);
    assert_eq!(fields::rail_f32::DOFS, 6);
}

/// Asserts that F alone, and F with the matrix of a step, equal the results of the whole kernel.
fn agree<K: Kernel<Real = f64>>(bodies: &Bodies<'_, f64>, indices: K::Indices, params: &K::Params) {
    let (mut whole, mut force, mut step) = (K::default(), K::Force::default(), K::Step::default());
    whole.evaluate(bodies, indices, params);
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (1.0 + a.abs());
    let alone = K::evaluate_force(&mut force, bodies, indices, params);
    assert!(alone.iter().zip(whole.force()).all(|(a, b)| near(*a, *b)), "{}", K::NAME);
    let h = 0.25;
    // At the kernel's own λ the matrix equals the matrix of the whole kernel; the kernel returns λ.
    let any = vec![0.0; K::ROWS];
    let multipliers = K::evaluate_step(&mut step, bodies, indices, params, h, &any).multipliers.to_vec();
    assert_eq!(multipliers.len(), K::ROWS);
    let Linear { force: in_step, matrix, slopes, .. } =
        K::evaluate_step(&mut step, bodies, indices, params, h, &multipliers);
    assert_eq!(slopes.len(), K::ROWS * K::DOFS);
    assert!(in_step.iter().zip(whole.force()).all(|(a, b)| near(*a, *b)), "{}", K::NAME);
    assert_eq!(matrix.len(), K::DOFS * K::DOFS);
    let sums = whole.dfdv().iter().zip(whole.dfdx()).map(|(v, x)| h * v + h * h * x);
    assert!(matrix.iter().zip(sums).all(|(a, b)| near(*a, b)), "{}", K::NAME);
    // The matrix is an affine function of the multipliers.
    let own = matrix.to_vec();
    let twice: Vec<f64> = multipliers.iter().map(|x| 2.0 * x).collect();
    let twice = K::evaluate_step(&mut step, bodies, indices, params, h, &twice).matrix.to_vec();
    let none = K::evaluate_step(&mut step, bodies, indices, params, h, &any).matrix;
    assert_eq!(twice != none, K::ROWS > 0, "{}", K::NAME);
    assert!(own.iter().zip(twice.iter().zip(none)).all(|(a, (b, c))| near(*a, 0.5 * (b + c))), "{}", K::NAME);
}

#[test]
fn kernels_with_fewer_results_agree() {
    use forcec_runtime::prelude::*;
    let turned = |x: f64| Rigid {
        position: Vec3::new(x, 0.5, -x),
        velocity: Vec3::new(0.1, x, 0.3),
        angular_velocity: Vec3::new(x, -1.0, 2.0),
        orientation: Quat::from_scaled_axis(Vec3::new(0.3, x, -0.2)),
    };
    let rigid = [turned(0.4), turned(-1.2)];
    let mut particles = [Particle::default(); 3];
    particles[1].position = Vec3::new(3.0, 0.5, 0.0);
    particles[2].velocity = Vec3::new(0.0, 1.0, 2.0);
    let bodies = Bodies { rigid: &rigid, particles: &particles };
    let spring = alone::spring::Params { rest_length: 1.0, stiffness: 10.0, damping: 3.0 };
    agree::<alone::spring::Output>(&bodies, [2, 1], &spring);
    agree::<fields::homing::Output>(&bodies, [1, 1], &());
    let peg = fields::peg::Params { arm: [0.1, -0.4, 0.2], stiffness: 10.0, damping: 3.0 };
    agree::<fields::peg::Output>(&bodies, [2, 1], &peg);
}

#[test]
fn single_precision_is_single_throughout() {
    use forcec_runtime::prelude_f32::*;
    let p = Particle { position: Vec3::z(), ..Particle::default() };
    assert_eq!(single::lift(p, 2.0), 19.62_f32);
    let mut out = single::lift_f32::Output::default();
    single::lift_f32::evaluate(&p, &single::lift_f32::Params { mass: 2.0 }, &mut out);
    assert_eq!(out.force, [0.0, 0.0, -19.62_f32]);
}

/// Functions that `macro_rules!` generates: an argument expression stays one value, and types, names and
/// visibilities are preserved.
mod by_macros {
    use forcec_runtime::prelude::*;

    macro_rules! product {
        ($name:ident, $e:expr) => {
            #[domain(k = 0.0..1e3)]
            #[energy]
            pub(super) fn $name(p: Particle, k: Real) -> Real {
                let scale = 1.0;
                p.position.x * $e * k * scale
            }
        };
    }
    product!(product, 1.0 + 2.0);

    macro_rules! typed {
        ($visibility:vis $name:ident, $ty:ty, $x:ident, $e:expr) => {
            #[force]
            $visibility fn $name(p: Particle, k: Real, $x: $ty) -> Vec3 {
                -($e) * p.velocity - k * p.velocity
            }
        };
    }
    typed!(pub(super) drag, Real, x, x * x);

    macro_rules! module {
        ($module:ident, $e:expr) => {
            #[forces]
            mod $module {
                use forcec_runtime::prelude::*;
                #[energy]
                pub(super) fn weight(p: Particle) -> Real {
                    p.position.x * $e
                }
            }
        };
    }
    module!(weights, 1.0 + 2.0);

    #[test]
    fn a_function_and_its_kernel_are_the_same() {
        let p = Particle { position: Vec3::x() * 5.0, velocity: Vec3::x() };
        assert_eq!(product(p, 1.0), 15.0);
        let mut out = product::Output::default();
        product::evaluate(&p, &product::Params { k: 1.0 }, &mut out);
        assert_eq!(out.force[0], -3.0);
        assert_eq!(drag(p, 1.0, 3.0).x, -10.0);
        assert_eq!(weights::weight(p), 15.0);
        let mut out = weights::weight::Output::default();
        weights::weight::evaluate(&p, &mut out);
        assert_eq!(out.force[0], -3.0);
    }
}

/// Warnings of forcec are allowed with lint names unknown to rustc.
mod answered {
    use forcec_runtime::prelude::*;

    #[energy]
    #[allow(singular, unused_variables, reason = "never short")]
    pub(crate) fn rod(p: Particle, idle: Real) -> Real {
        p.position.norm()
    }

    #[forces]
    #[allow(singular, reason = "never short")]
    mod rods {
        use forcec_runtime::prelude::*;

        #[allow(singular, nonlinear, reason = "never short")]
        fn length(v: Vec3) -> Real {
            v.norm() * PI
        }

        #[constraint]
        #[allow(gauss_newton, reason = "never short")]
        pub(crate) fn rod(p: Particle) -> Real {
            length(p.position)
        }
    }
}

/// Functions that nalgebra lacks.
#[test]
fn functions_of_the_language() {
    use forcec_runtime::prelude::*;
    let (u, v) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0));
    assert_eq!(u.outer(&v)[(0, 2)], 6.0);
    let m = Mat3::new(2.0, 1.0, 0.0, 0.0, 3.0, 1.0, 1.0, 0.0, 1.0);
    assert!((m * m.inverse() - Mat3::identity()).norm() < 1e-15);
    let m = Mat2::new(2.0, 1.0, 3.0, 4.0);
    assert!((m * m.inverse() - Mat2::identity()).norm() < 1e-15);
    // Quaternions are stored x, y, z, w.
    let q = Quat::from_scaled_axis(Vec3::x() * PI);
    assert!((q[0] - 1.0).abs() < 1e-15 && q[3].abs() < 1e-15);
}
