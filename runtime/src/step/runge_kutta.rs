//! The classical Runge-Kutta method and the symplectic Euler method, in lanes, with rigid rows.
//!
//! In: packed islands, a step and loads. Out: the state at its end, projected. See [`packed`](super::packed).

use super::Integrator;
use super::packed::{Inertia, Packed, State, Stepped};
use crate::kernel::BodyKind;
use crate::kernel::bodies::RigidLanes;
use crate::outside::{LoadAt, Outside};
use crate::state::moved;
use crate::system::lane_batch::{Row, RowSums};
use crate::system::lanes::{Lanes, Operation, Three, arrays, cross, lanes, wide};
use nalgebra::{RealField, Vector3, convert};

/// The weight of each stage of the classical method, and how far the next stage is, in steps.
const CLASSICAL: [(f64, f64); 4] = [(1.0 / 6.0, 0.5), (1.0 / 3.0, 0.5), (1.0 / 3.0, 1.0), (1.0 / 6.0, 0.0)];

/// How often poses are projected at most.
const PROJECTIONS: usize = 3;

impl<R: RealField + Copy, const L: usize> Packed<R, L> {
    /// One step of an explicit method.
    pub(crate) fn step(&mut self, h: R, outside: &Outside<'_, R>, integrator: Integrator) -> Stepped<R, L> {
        match integrator {
            Integrator::SymplecticEuler => self.symplectic_euler(h, outside),
            _ => self.runge_kutta(h, outside),
        }
    }

    /// The classical method, of order four.
    fn runge_kutta(&mut self, h: R, outside: &Outside<'_, R>) -> Stepped<R, L> {
        let number = convert::<f64, R>;
        self.stage.copy_from(&self.state);
        let mut work = Lanes::zero();
        let mut at = R::zero();
        for (stage, (weight, next)) in CLASSICAL.into_iter().enumerate() {
            let (weight, next) = (number(weight) * h, number(next) * h);
            self.show(at);
            let power = self.accelerate(at, outside);
            work += power * Lanes::all(weight);
            let Packed { arch, inertia, state, stage: bodies, sums, vector, .. } = self;
            wide::<R, L, _>(
                *arch,
                Advance { inertia, state, bodies, sums, vector, weight, next, first: stage == 0 },
            );
            at = next;
        }
        std::mem::swap(&mut self.stage, &mut self.sums);
        self.finish(h, work)
    }

    /// v += h V̇, then x ⊕= h v.
    fn symplectic_euler(&mut self, h: R, outside: &Outside<'_, R>) -> Stepped<R, L> {
        self.stage.copy_from(&self.state);
        self.show(R::zero());
        let power = self.accelerate(R::zero(), outside);
        let Packed { arch, inertia, stage: bodies, vector, .. } = self;
        wide::<R, L, _>(*arch, Kick { inertia, bodies, vector, h });
        self.finish(h, power * Lanes::all(h))
    }

    /// Shows the stage to kernels: quaternions of length one, kinematic bodies at their time.
    fn show(&mut self, time: R) {
        let Packed { arch, stage, shown, .. } = self;
        wide::<R, L, _>(*arch, Show { stage, shown });
        self.drive(time);
    }

    /// Moves kinematic bodies in `shown`.
    fn drive(&mut self, time: R) {
        if !self.driven {
            return;
        }
        for (index, _) in self.inertia[0].iter().enumerate().filter(|(_, it)| it.place.is_none()) {
            for lane in 0..L {
                let start = self.state.rigid(index, lane);
                let body = moved(&start, start.velocity * time, start.angular_velocity * time);
                self.shown.set_rigid(index, lane, &body);
            }
        }
        for (index, _) in self.inertia[1].iter().enumerate().filter(|(_, it)| it.place.is_none()) {
            let (start, body) = (&self.state.particles[index], &mut self.shown.particles[index]);
            for i in 0..3 {
                for lane in 0..L {
                    body.position[i][lane] = start.position[i][lane] + start.velocity[i][lane] * time;
                }
            }
        }
    }

    /// V̇ and −λ at the shown state, into `vector`; returns the power of what has no potential.
    fn accelerate(&mut self, at: R, outside: &Outside<'_, R>) -> Lanes<R, L> {
        let Packed { arch, factors, inertia, shown, vector, clear, .. } = self;
        let gravity = outside.gravity;
        let mut power = wide::<R, L, _>(
            *arch,
            Bodies { inertia, shown, vector, matrix: &mut factors.matrix, gravity, clear: *clear },
        );
        if let Some(loads) = outside.loads {
            power += self.sample(at + outside.time, loads);
        }
        let Packed { arch, plan, factors, batches, shown, vector, copy, multipliers, driven, .. } = self;
        for batch in batches.iter_mut() {
            power += batch.add_forces(&shown.bodies(), vector, *driven, *arch);
            let sums = RowSums { matrix: &mut factors.matrix, vector };
            batch.rows(Row::Saddle, &shown.bodies(), sums, *arch);
        }
        factors.factor(plan, *arch);
        if plan.has_loops() {
            for ((x, epsilon), known) in vector.iter_mut().zip(&factors.epsilon).zip(&*multipliers) {
                *x -= *epsilon * *known;
            }
        }
        factors.solve(plan, vector, *arch);
        if plan.has_loops() {
            multipliers.clone_from(vector);
        }
        if *driven {
            copy.copy_from_slice(vector);
            for batch in batches.iter_mut().filter(|batch| batch.is_rigid()) {
                let sums = RowSums { matrix: &mut factors.matrix, vector: copy };
                batch.rows(Row::Driven, &shown.bodies(), sums, *arch);
                power += batch.sum(copy);
            }
        }
        power
    }

    /// Adds loads of this time; returns their power.
    fn sample(&mut self, time: R, loads: LoadAt<'_, R>) -> Lanes<R, L> {
        let mut power = Lanes::zero();
        for kind in [BodyKind::Rigid, BodyKind::Particle] {
            for (index, inertia) in self.inertia[kind as usize].iter().enumerate() {
                let Some((place, _)) = inertia.place else { continue };
                for lane in 0..L {
                    let mut body = self.shown.get(kind, index, lane);
                    body.position += self.origins[lane].map(convert::<f64, R>);
                    let load = loads(time, self.handles[kind as usize][index][lane], &body);
                    for i in 0..3 {
                        self.vector[place + i].0[lane] += load.force[i];
                    }
                    power.0[lane] += load.force.dot(&body.velocity);
                    if kind == BodyKind::Rigid {
                        for i in 0..3 {
                            self.vector[place + 3 + i].0[lane] += load.torque[i];
                        }
                        power.0[lane] += load.torque.dot(&body.angular_velocity);
                    }
                }
            }
        }
        power
    }

    /// Moves the state onto C = 0 and J V = 0.
    pub(crate) fn project(&mut self) {
        self.stage.copy_from(&self.state);
        self.show(R::zero());
        let Packed { arch, plan, factors, batches, inertia, shown, vector, clear, .. } = self;
        let gravity = Vector3::zeros();
        wide::<R, L, _>(
            *arch,
            Bodies { inertia, shown, vector, matrix: &mut factors.matrix, gravity, clear: *clear },
        );
        for batch in batches.iter_mut() {
            let sums = RowSums { matrix: &mut factors.matrix, vector };
            batch.rows(Row::Saddle, &shown.bodies(), sums, *arch);
        }
        factors.factor(plan, *arch);
        self.finish(R::zero(), Lanes::zero());
    }

    /// Normalises the state in `stage`, projects it, and makes it the state.
    fn finish(&mut self, h: R, work: Lanes<R, L>) -> Stepped<R, L> {
        self.show(h);
        let mut stepped = Stepped { gap: Lanes::zero(), work };
        if self.has_rows() {
            let enough = convert::<f64, R>(0.1) * R::default_epsilon().sqrt();
            for sweep in 0..=PROJECTIONS {
                let gap = self.gap();
                if sweep == 0 {
                    stepped.gap = gap;
                }
                let open: [bool; L] = gap.0.map(|gap| gap > enough);
                // The first projection is part of the method.
                let open = if sweep == 0 { [true; L] } else { open };
                if sweep == PROJECTIONS || !open.contains(&true) {
                    break;
                }
                self.factors.solve(&self.plan, &mut self.vector, self.arch);
                let Packed { arch, inertia, shown, vector, .. } = self;
                wide::<R, L, _>(*arch, Shift { inertia, shown, vector, open });
            }
            let Packed { arch, plan, factors, batches, inertia, shown, vector, .. } = self;
            vector.fill(Lanes::zero());
            for batch in batches.iter_mut() {
                batch.rows(
                    Row::Rate,
                    &shown.bodies(),
                    RowSums { matrix: &mut factors.matrix, vector },
                    *arch,
                );
            }
            factors.solve(plan, vector, *arch);
            wide::<R, L, _>(*arch, Push { inertia, shown, vector });
        }
        std::mem::swap(&mut self.state, &mut self.shown);
        stepped
    }

    /// C into `vector`, whose other entries become zero; returns the largest |C|.
    fn gap(&mut self) -> Lanes<R, L> {
        let Packed { arch, factors, batches, shown, vector, .. } = self;
        vector.fill(Lanes::zero());
        for batch in batches.iter_mut() {
            batch.rows(Row::Value, &shown.bodies(), RowSums { matrix: &mut factors.matrix, vector }, *arch);
        }
        vector.iter().fold(Lanes::zero(), |gap: Lanes<R, L>, c| gap.max_abs(*c))
    }
}

/// Each dynamic body of a type: its place in vectors and its index.
#[inline(always)]
fn dynamic<R: Copy, const L: usize>(
    inertia: &[Inertia<R, L>],
) -> impl Iterator<Item = (usize, usize, &Inertia<R, L>)> {
    inertia.iter().enumerate().filter_map(|(index, it)| Some((it.place?.0, index, it)))
}

struct Show<'a, R: RealField, const L: usize> {
    stage: &'a State<R, L>,
    shown: &'a mut State<R, L>,
}

impl<R: RealField + Copy, const L: usize> Operation for Show<'_, R, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (shown, stage) in self.shown.rigid.iter_mut().zip(&self.stage.rigid) {
            *shown = RigidLanes { orientation: arrays(unit(lanes(&stage.orientation))), ..*stage };
        }
        self.shown.particles.copy_from_slice(&self.stage.particles);
    }
}

/// Inertia, gravity, loads and gyroscopic torques; returns the power of loads. Clears the matrix and the
/// vector.
struct Bodies<'a, R: RealField, const L: usize> {
    inertia: &'a [Vec<Inertia<R, L>>; 2],
    shown: &'a State<R, L>,
    vector: &'a mut [Lanes<R, L>],
    matrix: &'a mut [Lanes<R, L>],
    gravity: Vector3<R>,
    /// Whether the matrix has entries that are not set.
    clear: bool,
}

impl<R: RealField + Copy, const L: usize> Operation for Bodies<'_, R, L> {
    type Output = Lanes<R, L>;

    #[inline(always)]
    fn run(self) -> Lanes<R, L> {
        let Bodies { inertia, shown, vector, matrix, gravity, clear } = self;
        if clear {
            matrix.fill(Lanes::zero());
        }
        vector.fill(Lanes::zero());
        let gravity: Three<R, L> = std::array::from_fn(|i| Lanes::all(gravity[i]));
        let mut power = Lanes::zero();
        for (body, own) in shown.rigid.iter().zip(&inertia[0]) {
            let Some((place, block)) = own.place else { continue };
            let (v, w) = (lanes(&body.velocity), lanes(&body.angular_velocity));
            let tensor = tensor(lanes(&body.orientation), own.moments);
            let momentum: Three<R, L> =
                std::array::from_fn(|i| tensor[i][0] * w[0] + tensor[i][1] * w[1] + tensor[i][2] * w[2]);
            let gyroscopic = cross(momentum, w);
            let zero = Lanes::zero();
            for i in 0..3 {
                for j in i + 1..6 {
                    matrix[block + 6 * i + j] = zero;
                }
                matrix[block + 7 * i] = own.mass;
                for j in i..3 {
                    matrix[block + 6 * (3 + i) + 3 + j] = tensor[i][j];
                }
                vector[place + i] = own.mass * gravity[i] + own.load[i];
                vector[place + 3 + i] = gyroscopic[i] + own.load[3 + i];
                power += own.load[i] * v[i] + own.load[3 + i] * w[i];
            }
        }
        for (body, own) in shown.particles.iter().zip(&inertia[1]) {
            let Some((place, block)) = own.place else { continue };
            let v = lanes(&body.velocity);
            for i in 0..3 {
                for j in i + 1..3 {
                    matrix[block + 3 * i + j] = Lanes::zero();
                }
                matrix[block + 4 * i] = own.mass;
                vector[place + i] = own.mass * gravity[i] + own.load[i];
                power += own.load[i] * v[i];
            }
        }
        power
    }
}

/// R I Rᵀ, upper triangle.
#[inline(always)]
pub(super) fn tensor<R: RealField + Copy, const L: usize>(
    [x, y, z, w]: [Lanes<R, L>; 4],
    moments: Three<R, L>,
) -> [Three<R, L>; 3] {
    let (one, two) = (Lanes::all(R::one()), Lanes::all(convert::<f64, R>(2.0)));
    let r = [
        [one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)],
        [two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x)],
        [two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y)],
    ];
    let scaled = r.map(|row| [row[0] * moments[0], row[1] * moments[1], row[2] * moments[2]]);
    let entry = |i: usize, j: usize| scaled[i][0] * r[j][0] + scaled[i][1] * r[j][1] + scaled[i][2] * r[j][2];
    let (xy, xz, yz) = (entry(0, 1), entry(0, 2), entry(1, 2));
    [[entry(0, 0), xy, xz], [xy, entry(1, 1), yz], [xz, yz, entry(2, 2)]]
}

/// ½ ω q, the rate of a quaternion x, y, z, w.
#[inline(always)]
fn spin<R: RealField + Copy, const L: usize>(w: Three<R, L>, q: [Lanes<R, L>; 4]) -> [Lanes<R, L>; 4] {
    let half = Lanes::all(convert::<f64, R>(0.5));
    let c = cross(w, [q[0], q[1], q[2]]);
    [
        half * (q[3] * w[0] + c[0]),
        half * (q[3] * w[1] + c[1]),
        half * (q[3] * w[2] + c[2]),
        -(half * (w[0] * q[0] + w[1] * q[1] + w[2] * q[2])),
    ]
}

/// q / |q|
#[inline(always)]
fn unit<R: RealField + Copy, const L: usize>(q: [Lanes<R, L>; 4]) -> [Lanes<R, L>; 4] {
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt().recip();
    q.map(|x| x * length)
}

/// x += factor y
#[inline(always)]
fn add_scaled<R: RealField + Copy, const L: usize, const N: usize>(
    x: &mut [[R; L]; N],
    factor: Lanes<R, L>,
    y: [Lanes<R, L>; N],
) {
    for (x, y) in x.iter_mut().zip(y) {
        *x = (Lanes(*x) + factor * y).0;
    }
}

/// Adds a stage's rates to the sums, and moves bodies to the next stage.
struct Advance<'a, R: RealField, const L: usize> {
    inertia: &'a [Vec<Inertia<R, L>>; 2],
    state: &'a State<R, L>,
    bodies: &'a mut State<R, L>,
    sums: &'a mut State<R, L>,
    vector: &'a [Lanes<R, L>],
    weight: R,
    next: R,
    /// Whether the sums begin with the state.
    first: bool,
}

impl<R: RealField + Copy, const L: usize> Operation for Advance<'_, R, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Advance { inertia, state, bodies, sums, vector, weight, next, first } = self;
        let (weight, next) = (Lanes::all(weight), Lanes::all(next));
        for (k, body) in bodies.rigid.iter_mut().enumerate() {
            let start = &state.rigid[k];
            let sum = &mut sums.rigid[k];
            if first {
                *sum = *start;
            }
            let Some((place, _)) = inertia[0][k].place else { continue };
            let (v, w) = (lanes(&body.velocity), lanes(&body.angular_velocity));
            let dq = spin(w, lanes(&body.orientation));
            let a: Three<R, L> = std::array::from_fn(|i| vector[place + i]);
            let alpha: Three<R, L> = std::array::from_fn(|i| vector[place + 3 + i]);
            add_scaled(&mut sum.position, weight, v);
            add_scaled(&mut sum.orientation, weight, dq);
            add_scaled(&mut sum.velocity, weight, a);
            add_scaled(&mut sum.angular_velocity, weight, alpha);
            *body = *start;
            add_scaled(&mut body.position, next, v);
            add_scaled(&mut body.orientation, next, dq);
            add_scaled(&mut body.velocity, next, a);
            add_scaled(&mut body.angular_velocity, next, alpha);
        }
        for (k, body) in bodies.particles.iter_mut().enumerate() {
            let start = &state.particles[k];
            let sum = &mut sums.particles[k];
            if first {
                *sum = *start;
            }
            let Some((place, _)) = inertia[1][k].place else { continue };
            let v = lanes(&body.velocity);
            let a: Three<R, L> = std::array::from_fn(|i| vector[place + i]);
            add_scaled(&mut sum.position, weight, v);
            add_scaled(&mut sum.velocity, weight, a);
            *body = *start;
            add_scaled(&mut body.position, next, v);
            add_scaled(&mut body.velocity, next, a);
        }
    }
}

/// v += h V̇, then x ⊕= h v.
struct Kick<'a, R: RealField, const L: usize> {
    inertia: &'a [Vec<Inertia<R, L>>; 2],
    bodies: &'a mut State<R, L>,
    vector: &'a [Lanes<R, L>],
    h: R,
}

impl<R: RealField + Copy, const L: usize> Operation for Kick<'_, R, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Kick { inertia, bodies, vector, h } = self;
        let h = Lanes::all(h);
        for (place, k, _) in dynamic(&inertia[0]) {
            let body = &mut bodies.rigid[k];
            add_scaled(&mut body.velocity, h, std::array::from_fn(|i| vector[place + i]));
            let alpha = std::array::from_fn(|i| vector[place + 3 + i]);
            add_scaled(&mut body.angular_velocity, h, alpha);
            add_scaled(&mut body.position, h, lanes(&body.velocity));
            body.orientation = arrays(turned(lanes(&body.orientation), lanes(&body.angular_velocity), h));
        }
        for (place, k, _) in dynamic(&inertia[1]) {
            let body = &mut bodies.particles[k];
            add_scaled(&mut body.velocity, h, std::array::from_fn(|i| vector[place + i]));
            add_scaled(&mut body.position, h, lanes(&body.velocity));
        }
    }
}

/// A rotation turned by θ = h ω, (cos |θ|/2, sin |θ|/2 θ/|θ|) q; in each instance by the scalar functions.
#[inline(always)]
fn turned<R: RealField + Copy, const L: usize>(
    q: [Lanes<R, L>; 4],
    w: Three<R, L>,
    h: Lanes<R, L>,
) -> [Lanes<R, L>; 4] {
    let mut out = q;
    for lane in 0..L {
        let pick = |x: &[Lanes<R, L>]| Vector3::new(x[0].0[lane], x[1].0[lane], x[2].0[lane]);
        let q = nalgebra::Quaternion::new(q[3].0[lane], q[0].0[lane], q[1].0[lane], q[2].0[lane]);
        let start = crate::Rigid {
            orientation: nalgebra::UnitQuaternion::new_unchecked(q),
            ..crate::Rigid::default()
        };
        let end = moved(&start, Vector3::zeros(), pick(&w) * h.0[lane]);
        (0..4).for_each(|i| out[i].0[lane] = end.orientation.coords[i]);
    }
    out
}

/// x −= δx, q turned by −δθ, in open instances.
struct Shift<'a, R: RealField, const L: usize> {
    inertia: &'a [Vec<Inertia<R, L>>; 2],
    shown: &'a mut State<R, L>,
    vector: &'a [Lanes<R, L>],
    open: [bool; L],
}

impl<R: RealField + Copy, const L: usize> Operation for Shift<'_, R, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Shift { inertia, shown, vector, open } = self;
        let zero = Lanes::zero();
        let by =
            |place: usize| -> Three<R, L> { std::array::from_fn(|i| zero.or_if(-vector[place + i], open)) };
        let one = Lanes::all(R::one());
        for (place, k, _) in dynamic(&inertia[0]) {
            let body = &mut shown.rigid[k];
            add_scaled(&mut body.position, one, by(place));
            let q = lanes(&body.orientation);
            let dq = spin(by(place + 3), q);
            let turned = unit(std::array::from_fn(|i| q[i] + dq[i]));
            body.orientation = arrays(std::array::from_fn(|i| q[i].or_if(turned[i], open)));
        }
        for (place, k, _) in dynamic(&inertia[1]) {
            let body = &mut shown.particles[k];
            add_scaled(&mut body.position, one, by(place));
        }
    }
}

/// V −= δ.
struct Push<'a, R: RealField, const L: usize> {
    inertia: &'a [Vec<Inertia<R, L>>; 2],
    shown: &'a mut State<R, L>,
    vector: &'a [Lanes<R, L>],
}

impl<R: RealField + Copy, const L: usize> Operation for Push<'_, R, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Push { inertia, shown, vector } = self;
        let back = Lanes::all(-R::one());
        let by = |place: usize| -> Three<R, L> { std::array::from_fn(|i| vector[place + i]) };
        for (place, k, _) in dynamic(&inertia[0]) {
            let body = &mut shown.rigid[k];
            add_scaled(&mut body.velocity, back, by(place));
            add_scaled(&mut body.angular_velocity, back, by(place + 3));
        }
        for (place, k, _) in dynamic(&inertia[1]) {
            let body = &mut shown.particles[k];
            add_scaled(&mut body.velocity, back, by(place));
        }
    }
}
