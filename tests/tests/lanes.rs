//! The functions that a runtime calls for several instances at once and for rigid constraints, on every kernel
//! of the library, at random states.
//!
//! F and the rows of an instance have the same bits for every number of instances, and are those of the kernels
//! for one instance up to rounding. J, the drift and the geometric stiffness agree with difference quotients of
//! C, J V and Jᵀ λ.

use forcec_runtime::nalgebra::{ComplexField, RealField, UnitQuaternion, Vector3, convert};
use forcec_runtime::{Bodies, BodiesLanes, BodyKind, Kernel, Particle, ParticleLanes, Rigid, RigidLanes};
use forcec_tests::{Random, parallel};
use std::array::from_fn;

/// States of each kernel.
const STATES: usize = 8;

/// The bodies of one instance.
#[derive(Clone)]
struct State<R: RealField> {
    rigid: Vec<Rigid<R>>,
    particles: Vec<Particle<R>>,
}

/// Some numbers of order one.
fn numbers<R: RealField>(random: &mut Random, count: usize) -> Vec<R> {
    (0..count).map(|_| convert(random.uniform(-1.5, 1.5))).collect()
}

impl<R: RealField + Copy> State<R> {
    fn draw<K: Kernel>(random: &mut Random) -> State<R> {
        let mut state = State { rigid: Vec::new(), particles: Vec::new() };
        let mut vector = || Vector3::from_vec(numbers(random, 3));
        for kind in K::BODIES {
            let (position, velocity) = (vector(), vector());
            match kind {
                BodyKind::Rigid => state.rigid.push(Rigid {
                    position,
                    orientation: UnitQuaternion::from_scaled_axis(vector()),
                    velocity,
                    angular_velocity: vector(),
                }),
                BodyKind::Particle => state.particles.push(Particle { position, velocity }),
            }
        }
        state
    }

    fn bodies(&self) -> Bodies<'_, R> {
        Bodies { rigid: &self.rigid, particles: &self.particles }
    }

    /// The velocities in the order of F.
    fn velocity<K: Kernel>(&self) -> Vec<R> {
        let (mut rigid, mut particles) = (self.rigid.iter(), self.particles.iter());
        let mut velocity = Vec::new();
        for kind in K::BODIES {
            match kind {
                BodyKind::Rigid => {
                    let body = rigid.next().unwrap();
                    velocity.extend(body.velocity.iter().chain(body.angular_velocity.iter()));
                }
                BodyKind::Particle => velocity.extend(particles.next().unwrap().velocity.iter()),
            }
        }
        velocity
    }

    /// The bodies moved by `step` along a direction in the order of F.
    fn moved<K: Kernel>(&self, direction: &[R], step: R) -> State<R> {
        let mut state = self.clone();
        let (mut rigid, mut particles) = (state.rigid.iter_mut(), state.particles.iter_mut());
        let mut vectors = direction.chunks(3).map(|vector| Vector3::from_column_slice(vector) * step);
        let mut vector = || vectors.next().unwrap();
        for kind in K::BODIES {
            match kind {
                BodyKind::Rigid => {
                    let body = rigid.next().unwrap();
                    body.position += vector();
                    body.orientation = UnitQuaternion::from_scaled_axis(vector()) * body.orientation;
                }
                BodyKind::Particle => particles.next().unwrap().position += vector(),
            }
        }
        state
    }
}

/// The bodies of L instances.
struct StateLanes<R, const L: usize> {
    rigid: Vec<RigidLanes<R, L>>,
    particles: Vec<ParticleLanes<R, L>>,
}

impl<R: RealField + Copy, const L: usize> StateLanes<R, L> {
    fn new(states: [&State<R>; L]) -> StateLanes<R, L> {
        let rigid = (0..states[0].rigid.len()).map(|body| RigidLanes {
            position: from_fn(|k| states.map(|state| state.rigid[body].position[k])),
            orientation: from_fn(|k| states.map(|state| state.rigid[body].orientation[k])),
            velocity: from_fn(|k| states.map(|state| state.rigid[body].velocity[k])),
            angular_velocity: from_fn(|k| states.map(|state| state.rigid[body].angular_velocity[k])),
        });
        let particles = (0..states[0].particles.len()).map(|body| ParticleLanes {
            position: from_fn(|k| states.map(|state| state.particles[body].position[k])),
            velocity: from_fn(|k| states.map(|state| state.particles[body].velocity[k])),
        });
        StateLanes { rigid: rigid.collect(), particles: particles.collect() }
    }

    fn bodies(&self) -> BodiesLanes<'_, R, L> {
        BodiesLanes { rigid: &self.rigid, particles: &self.particles }
    }
}

/// The numbers of one instance.
fn lane<R: Copy, const L: usize>(entries: &[[R; L]], lane: usize) -> Vec<R> {
    entries.iter().map(|entry| entry[lane]).collect()
}

/// Each body in the next place of its array.
fn indices<K: Kernel>() -> K::Indices {
    let (mut indices, mut counts) = (K::Indices::default(), [0; 2]);
    for (index, kind) in indices.as_mut().iter_mut().zip(K::BODIES) {
        let count = &mut counts[usize::from(*kind == BodyKind::Particle)];
        *index = *count;
        *count += 1;
    }
    indices
}

fn params<K: Kernel>(random: &mut Random) -> K::Params {
    K::read_params(&mut std::iter::repeat_with(|| convert(random.uniform(0.5, 1.5)))).unwrap()
}

/// An instance of a system with one force.
type Instance<K> = (State<<K as Kernel>::Real>, <K as Kernel>::Params);

/// F of the kernel for one instance.
fn force<K: Kernel>((state, params): &Instance<K>) -> Vec<K::Real> {
    K::evaluate_force(&mut K::Force::default(), &state.bodies(), indices::<K>(), params).to_vec()
}

/// Random instances in which F is finite; a solid may be drawn inside out, where its energy has no value.
fn draw<K: Kernel>() -> Vec<Instance<K>> {
    const TRIES: usize = 100;
    let mut random = Random::new(7);
    let drawn = (0..TRIES).map(|_| (State::draw::<K>(&mut random), params::<K>(&mut random)));
    let drawn = drawn.filter(|instance| force::<K>(instance).iter().all(ComplexField::is_finite));
    let drawn: Vec<_> = drawn.take(STATES).collect();
    assert_eq!(drawn.len(), STATES, "{}", K::NAME);
    drawn
}

/// F and C, J, drift of each instance, L instances at once.
fn by_lanes<K: Kernel, const L: usize>(instances: &[Instance<K>]) -> Vec<[Vec<K::Real>; 4]> {
    let mut found = Vec::new();
    for some in instances.chunks_exact(L) {
        let states = StateLanes::new(from_fn::<_, L, _>(|lane| &some[lane].0));
        let each = from_fn::<_, L, _>(|lane| &some[lane].1);
        let (mut out, mut rows) = (K::LaneForce::<L>::default(), K::LaneRows::<L>::default());
        let (bodies, indices) = (states.bodies(), indices::<K>());
        let force = K::force_lanes(&mut out, &bodies, indices, &K::gather_params(each));
        let rows = K::rows_lanes(&mut rows, &bodies, indices, &K::gather_row_params(each));
        let all = [force, rows.value, rows.jacobian, rows.drift];
        found.extend((0..L).map(|k| all.map(|entries| lane(entries, k))));
    }
    found
}

/// Asserts that F does not differ from F of the kernel for one instance by more than roundings.
fn right_force<K: Kernel>(instance: &Instance<K>, [found, ..]: &[Vec<K::Real>; 4], rounding: f64) {
    let force = force::<K>(instance);
    let size = force.iter().fold(convert(1.0), |size: K::Real, x| size.max(x.abs()));
    let near = |(x, y): (&K::Real, &K::Real)| (*x - *y).abs() <= size * convert(rounding);
    assert_eq!(found.len(), K::DOFS, "{}", K::NAME);
    assert!(found.iter().zip(&force).all(near), "{}: {found:?}, expected {force:?}", K::NAME);
}

/// C, J and the drift of one instance.
struct Rows {
    value: Vec<f64>,
    jacobian: Vec<f64>,
    drift: Vec<f64>,
}

impl Rows {
    fn of<K: Kernel<Real = f64>, const L: usize>(states: [&State<f64>; L], params: &K::Params) -> [Rows; L] {
        let states = StateLanes::new(states);
        let params = K::gather_row_params::<L>([params; L]);
        let mut out = K::LaneRows::<L>::default();
        let rows = K::rows_lanes(&mut out, &states.bodies(), indices::<K>(), &params);
        from_fn(|k| Rows {
            value: lane(rows.value, k),
            jacobian: lane(rows.jacobian, k),
            drift: lane(rows.drift, k),
        })
    }

    /// J v
    fn times(&self, v: &[f64]) -> Vec<f64> {
        times(&self.jacobian, v)
    }

    /// Jᵀ λ
    fn pull(&self, multipliers: &[f64]) -> Vec<f64> {
        let count = self.jacobian.len() / multipliers.len();
        let rows = || self.jacobian.chunks(count).zip(multipliers);
        (0..count).map(|column| rows().map(|(row, multiplier)| row[column] * multiplier).sum()).collect()
    }
}

/// The product of a matrix, row by row, and a vector.
fn times(matrix: &[f64], v: &[f64]) -> Vec<f64> {
    matrix.chunks(v.len()).map(|row| row.iter().zip(v).map(|(x, y)| x * y).sum()).collect()
}

fn assert_near(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let size = expected.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    let near = found.iter().zip(expected).all(|(x, y)| (x - y).abs() <= tolerance * size);
    assert!(near, "{what}: {found:?}, expected {expected:?}");
}

/// Asserts that the rows are those of the measured constraint, and their derivatives difference quotients.
fn right_rows<K: Kernel<Real = f64>>((state, params): &Instance<K>, random: &mut Random) {
    /// Errors of the quotients are about STEP² and 1e-16/STEP.
    const STEP: f64 = 1e-5;
    const NEAR: f64 = 1e-7;
    let named = |what: &str| format!("{}, {what}", K::NAME);
    let velocity = state.velocity::<K>();
    let (direction, multipliers) = (numbers(random, K::DOFS), numbers(random, K::ROWS));
    let [rows] = Rows::of::<K, 1>([state], params);
    assert_eq!((rows.value.len(), rows.jacobian.len()), (K::ROWS, K::ROWS * K::DOFS));
    let side = |x: f64| if K::ONE_SIDED { x.min(0.0) } else { x };
    let violation = rows.value.iter().fold(0.0_f64, |most, x| most.max(side(*x).abs()));
    let measured = K::measure(&state.bodies(), indices::<K>(), params).max_violation;
    assert_near(&named("C"), &[violation], &[measured], 1e-14);
    let pattern = K::JACOBIAN_NONZERO.concat();
    assert!(pattern.bytes().zip(&rows.jacobian).all(|(mark, x)| mark == b'x' || *x == 0.0), "{}", K::NAME);

    let quotient = |direction: &[f64], value: &dyn Fn(&Rows) -> Vec<f64>| -> Vec<f64> {
        let [ahead, behind] = [STEP, -STEP].map(|step| state.moved::<K>(direction, step));
        let [ahead, behind] = Rows::of::<K, 2>([&ahead, &behind], params).map(|rows| value(&rows));
        ahead.iter().zip(behind).map(|(x, y)| (x - y) / (2.0 * STEP)).collect()
    };
    let rate = quotient(&direction, &|rows| rows.value.clone());
    assert_near(&named("J"), &rows.times(&direction), &rate, NEAR);
    assert_near(&named("drift"), &rows.drift, &quotient(&velocity, &|rows| rows.times(&velocity)), NEAR);

    let mut out = K::Saddle::default();
    let saddle = K::saddle(&mut out, &state.bodies(), indices::<K>(), params, &multipliers);
    assert_near(&named("C"), saddle.value, &rows.value, 1e-14);
    assert_near(&named("J"), saddle.jacobian, &rows.jacobian, 1e-14);
    let turned = quotient(&direction, &|rows| rows.pull(&multipliers));
    assert_near(&named("geometric stiffness"), &times(saddle.geometric, &direction), &turned, NEAR);
}

/// The checks of a kernel in both precisions.
fn check<K: Kernel<Real = f64>, Single: Kernel<Real = f32>>() {
    let (instances, single) = (draw::<K>(), draw::<Single>());
    let alone = by_lanes::<K, 1>(&instances);
    assert_eq!(alone, by_lanes::<K, 2>(&instances), "{}", K::NAME);
    assert_eq!(alone, by_lanes::<K, 4>(&instances), "{}", K::NAME);
    assert_eq!(alone, by_lanes::<K, 8>(&instances), "{}", K::NAME);
    let alone_single = by_lanes::<Single, 1>(&single);
    assert_eq!(alone_single, by_lanes::<Single, 8>(&single), "{}", Single::NAME);
    instances.iter().zip(&alone).for_each(|(instance, found)| right_force::<K>(instance, found, 1e-14));
    single
        .iter()
        .zip(&alone_single)
        .for_each(|(instance, found)| right_force::<Single>(instance, found, 1e-6));
    if K::ROWS > 0 {
        let mut random = Random::new(8);
        instances.iter().for_each(|instance| right_rows::<K>(instance, &mut random));
    } else {
        let [rows] = Rows::of::<K, 1>([&instances[0].0], &instances[0].1);
        assert!(rows.value.is_empty() && rows.jacobian.is_empty() && rows.drift.is_empty(), "{}", K::NAME);
    }
}

#[test]
fn lanes_and_rows_are_those_of_the_kernels() {
    parallel(CHECKS.to_vec(), |check| check());
}

include!(concat!(env!("OUT_DIR"), "/lanes.rs"));
