//! Physical invariants: balance of forces and torques, equivariance, symmetry of the derivatives.
//!
//! In: the exact values and the kernel's outputs with error bounds, state by state. Out: a verdict for each
//! invariant. The rows of C (or E, or F) are tested under the six rigid motions first. If the rows do not
//! change, the kernel's force must balance; if only ½ Σ ks C² does not change, it must balance at damping 0;
//! else nothing is required. One state that breaks the symmetry suffices. Invariants at damping 0 are skipped
//! if another damping is compiled in.

use crate::math::exact::Exact;
use crate::math::random::Random;
use crate::model::bodies::Role;
use crate::sample::inputs::Places;
use crate::sample::states::{Family, State};
use crate::verify::big::Big;
use crate::verify::oracle::{Oracle, Point};
use crate::verify::report::{Entry, Invariant, Verdict, ratio};
use crate::verify::tape::{Bounded, Tape};

/// The relative change below which a function counts as unchanged: far above the effect of |q| ≠ 1.
const UNCHANGED: f64 = 1e-13;
const UNIT: f64 = f64::EPSILON / 2.0;

/// The largest violation so far.
#[derive(Clone, Default)]
struct Worst {
    found: Option<Entry>,
}

impl Worst {
    fn see(&mut self, error: f64, tolerance: f64, entry: impl FnOnce() -> Entry) {
        let here = ratio(error, tolerance);
        if self.found.as_ref().is_none_or(|found| here > found.ratio()) {
            self.found = Some(entry());
        }
    }

    fn is_violation(&self) -> bool {
        self.found.as_ref().is_some_and(|entry| entry.ratio() > 1.0)
    }
}

/// The results for one rigid motion, for the function and for the kernel.
#[derive(Clone)]
struct Motion {
    rows_unchanged: bool,
    elastic_unchanged: bool,
    damped: Worst,
    undamped: Worst,
}

/// The results over all states so far.
pub(crate) struct Invariants {
    motions: Vec<Motion>,
    equivariant: bool,
    turned: Worst,
    damping_symmetric: Worst,
    torque_skew: Worst,
}

/// The inputs of the tests at one state.
pub(crate) struct Seen<'a> {
    pub(crate) oracle: &'a Oracle<'a>,
    pub(crate) places: &'a Places,
    pub(crate) tape: &'a Tape,
    pub(crate) names: &'a [String],
    pub(crate) point: &'a Point<'a, 'a>,
    pub(crate) state: &'a State,
    pub(crate) family: Family,
    /// The kernel's outputs force, dfdx and dfdv.
    pub(crate) outputs: &'a [Bounded],
    /// The errors of the inputs.
    pub(crate) errors: &'a [f64],
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Invariants {
    pub(crate) fn new() -> Invariants {
        let motion = Motion {
            rows_unchanged: true,
            elastic_unchanged: true,
            damped: Worst::default(),
            undamped: Worst::default(),
        };
        Invariants {
            motions: vec![motion; 6],
            equivariant: true,
            turned: Worst::default(),
            damping_symmetric: Worst::default(),
            torque_skew: Worst::default(),
        }
    }

    /// Tests the invariants at one state.
    pub(crate) fn see(&mut self, seen: &Seen, turn: Option<&mut Random>) {
        let undamped = seen.undamped();
        self.balance(seen, &undamped);
        if seen.oracle.is_constraint() {
            self.symmetric_damping(seen);
        }
        if undamped.is_possible && (seen.oracle.is_constraint() || seen.oracle.is_energy()) {
            self.torque_skew(seen, &undamped);
        }
        if let Some(random) = turn {
            self.equivariance(seen, random);
        }
    }

    /// Σ f = 0 and Σ τ + x × f = 0.
    fn balance(&mut self, seen: &Seen, undamped: &Undamped) {
        for (number, motion) in self.motions.iter_mut().enumerate() {
            let generator = generator(seen.places, &seen.state.values, number);
            let exact: Vec<Big> = generator.iter().map(|x| Big::from_f64(*x)).collect();
            let work = seen.point.work(&exact);
            motion.rows_unchanged &= work.rows.0 <= UNCHANGED * work.rows.1 + seen.point.noise;
            let elastic_unchanged = work.elastic.0 <= UNCHANGED * work.elastic.1 + seen.point.noise;
            motion.elastic_unchanged &= elastic_unchanged && (undamped.is_possible || motion.rows_unchanged);
            let own = crate::verify::oracle::inner(&seen.point.force, &exact).to_f64().abs();
            let kinds = [
                (&mut motion.damped, seen.outputs, seen.state, own),
                (&mut motion.undamped, &undamped.outputs, &undamped.state, work.elastic.0),
            ];
            for (worst, outputs, state, own) in kinds {
                let terms = generator.iter().zip(outputs).map(|(g, f)| (g * f.value, g.abs() * f.error));
                let (mut sum, mut size, mut bound) = (0.0, 0.0, 0.0);
                for (term, error) in terms {
                    sum += term;
                    size += f64::abs(term);
                    bound += error;
                }
                let tolerance =
                    bound + 2.0 * UNIT * generator.len() as f64 * size + 2.0 * own + seen.point.noise;
                worst.see(sum.abs(), tolerance, || {
                    let (what, axis) = if number < 3 { ("force", number) } else { ("torque", number - 3) };
                    seen.entry(format!("total {what} {}", AXES[axis]), 0.0, sum, tolerance, state)
                });
            }
        }
    }

    /// ∂F/∂V = (∂F/∂V)ᵀ
    fn symmetric_damping(&mut self, seen: &Seen) {
        let n = seen.names.len();
        let dfdv = &seen.outputs[n + n * n..];
        for i in 0..n {
            for j in 0..i {
                let (a, b) = (dfdv[i * n + j], dfdv[j * n + i]);
                let (error, tolerance) =
                    ((a.value - b.value).abs(), a.error + b.error + 2.0 * UNIT * a.value.abs());
                self.damping_symmetric.see(error, tolerance, || {
                    let name = format!("dfdv[{}][{}]", seen.names[i], seen.names[j]);
                    seen.entry(name, b.value, a.value, tolerance, seen.state)
                });
            }
        }
    }

    /// X − Xᵀ = −[τ]× between the rotations of each body, 0 elsewhere.
    fn torque_skew(&mut self, seen: &Seen, undamped: &Undamped) {
        let n = seen.names.len();
        let pose = &seen.places.pose;
        let (force, dfdx) = undamped.outputs.split_at(n);
        for i in 0..n {
            for j in 0..i {
                let (a, b) = (dfdx[i * n + j], dfdx[j * n + i]);
                let mut expected = b;
                if pose[i].role == Role::Orientation && pose[i].start == pose[j].start {
                    // −[τ]× at (i, j) is Σ εᵢⱼₖ τₖ; here i > j.
                    let (row, column) = (pose[i].axis, pose[j].axis);
                    let axis = 3 - row - column;
                    let sign = if (row + 1) % 3 == column { 1.0 } else { -1.0 };
                    let torque = force[i - row + axis];
                    expected.value += sign * torque.value;
                    expected.error += torque.error + UNIT * expected.value.abs();
                }
                let error = (a.value - expected.value).abs();
                let tolerance = a.error + expected.error + 2.0 * UNIT * a.value.abs();
                self.torque_skew.see(error, tolerance, || {
                    let name = format!("dfdx[{}][{}]", seen.names[i], seen.names[j]);
                    seen.entry(name, expected.value, a.value, tolerance, &undamped.state)
                });
            }
        }
    }

    /// F, ∂F/∂X and ∂F/∂V at a rotated state equal the rotated F, ∂F/∂X and ∂F/∂V.
    fn equivariance(&mut self, seen: &Seen, random: &mut Random) {
        let drawn: Vec<Big> = random.unit(4).into_iter().map(Big::from_f64).collect();
        let norm = crate::verify::oracle::inner(&drawn, &drawn).sqrt();
        let q: Vec<Big> = drawn.into_iter().map(|x| x / norm.clone()).collect();
        let (u, w) = ([q[0].clone(), q[1].clone(), q[2].clone()], q[3].clone());
        let turned = seen.point.rotated(&u, &w);
        let values: Vec<f64> = turned.iter().map(Big::to_f64).collect();
        let Ok(point) = seen.oracle.point_at(turned) else { return };
        let size = seen.point.force.iter().map(|f| f.to_f64().abs()).fold(0.0, f64::max);
        for (block, f) in seen.point.force.chunks(3).enumerate() {
            let f = [f[0].clone(), f[1].clone(), f[2].clone()];
            let expected = crate::verify::source::rotate(&u, &w, f);
            for (axis, expected) in expected.into_iter().enumerate() {
                let change = (point.force[3 * block + axis].clone() - expected).to_f64().abs();
                self.equivariant &= change <= UNCHANGED * size + seen.point.noise + point.noise;
            }
        }
        if !self.equivariant {
            return;
        }
        // The kernel's inputs are the rotated state, rounded to doubles.
        let mut errors = crate::verify::input_errors(seen.places, &values);
        for (error, (x, y)) in errors.iter_mut().zip(values.iter().zip(&seen.state.values)) {
            if x != y {
                *error += f64::EPSILON * x.abs();
            }
        }
        let state = State { values, scale: seen.state.scale };
        let found = seen.tape.bounds(&state.values, &errors);
        let columns = [0, 1, 2].map(|k| {
            let mut unit = [Big::zero(), Big::zero(), Big::zero()];
            unit[k] = Big::integer(1);
            crate::verify::source::rotate(&u, &w, unit).map(|x| x.to_f64())
        });
        let rotation = |i: usize, k: usize| columns[k][i];
        let n = seen.names.len();
        for i in 0..n {
            let (block, axis) = (i - i % 3, i % 3);
            let terms = (0..3).map(|k| (rotation(axis, k), seen.outputs[block + k]));
            let expected = combine(terms);
            let names = || format!("force[{}] turned", seen.names[i]);
            self.turned_entry(seen, &state, expected, found[i], names);
            for j in 0..n {
                let (other, second) = (j - j % 3, j % 3);
                for (array, start) in [("dfdx", n), ("dfdv", n + n * n)] {
                    let terms = (0..9).map(|m| {
                        let (k, l) = (m / 3, m % 3);
                        let entry = seen.outputs[start + (block + k) * n + other + l];
                        (rotation(axis, k) * rotation(second, l), entry)
                    });
                    let name = || format!("{array}[{}][{}] turned", seen.names[i], seen.names[j]);
                    self.turned_entry(seen, &state, combine(terms), found[start + i * n + j], name);
                }
            }
        }
    }

    fn turned_entry(
        &mut self,
        seen: &Seen,
        state: &State,
        expected: Bounded,
        found: Bounded,
        name: impl FnOnce() -> String,
    ) {
        let tolerance = expected.error + found.error + seen.point.noise;
        let error = (expected.value - found.value).abs();
        self.turned
            .see(error, tolerance, || seen.entry(name(), expected.value, found.value, tolerance, state));
    }

    /// The verdict for each invariant.
    pub(crate) fn finish(self, oracle: &Oracle, places: &Places) -> Vec<Invariant> {
        let (translations, rotations) = self.motions.split_at(3);
        let plain = |name, applies: bool, worst: Worst, detail: &str| Invariant {
            name,
            verdict: match (applies, worst.is_violation()) {
                (false, _) => Verdict::NotApplicable,
                (true, true) => Verdict::Violated,
                (true, false) => Verdict::Holds,
            },
            detail: if applies { detail.to_owned() } else { String::new() },
            worst: worst.found.filter(|_| applies),
        };
        let mut equivariance = plain("rotation equivariance", true, self.turned, "");
        if !self.equivariant {
            equivariance.verdict = Verdict::NotInvariant;
            equivariance.worst = None;
        }
        let constraint = oracle.is_constraint();
        let at_rest = if constraint { "at damping 0" } else { "" };
        let symmetric = oracle.is_energy() || (constraint && can_be_undamped(places));
        vec![
            balance("force balance", translations),
            balance("torque balance", rotations),
            equivariance,
            plain("dfdv symmetric", constraint, self.damping_symmetric, ""),
            plain("dfdx symmetric up to torque", symmetric, self.torque_skew, at_rest),
        ]
    }
}

/// The verdict over three motions, which may be invariant in different senses.
fn balance(name: &'static str, motions: &[Motion]) -> Invariant {
    let mut kept: Vec<(&str, &Motion)> = AXES.into_iter().zip(motions).collect();
    kept.retain(|(_, motion)| motion.elastic_unchanged);
    let worst = |motion: &Motion| {
        if motion.rows_unchanged { motion.damped.found.clone() } else { motion.undamped.found.clone() }
    };
    let worst = kept.iter().filter_map(|(_, motion)| worst(motion));
    let worst = worst.max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    let verdict = match &worst {
        _ if kept.is_empty() => Verdict::NotInvariant,
        Some(entry) if entry.ratio() > 1.0 => Verdict::Violated,
        _ => Verdict::Holds,
    };
    let mut detail = Vec::new();
    if kept.len() < 3 && !kept.is_empty() {
        detail.push(format!("along {}", kept.iter().map(|(axis, _)| *axis).collect::<Vec<_>>().join(", ")));
    }
    if kept.iter().any(|(_, motion)| !motion.rows_unchanged) {
        detail.push("at damping 0".to_owned());
    }
    Invariant { name, verdict, detail: detail.join(", "), worst }
}

/// Σ coefficient · entry with a bound; coefficients are accurate to a few units of rounding.
fn combine(terms: impl Iterator<Item = (f64, Bounded)>) -> Bounded {
    let mut sum = Bounded { value: 0.0, error: 0.0 };
    for (c, x) in terms {
        sum.value += c * x.value;
        sum.error += c.abs() * x.error + 16.0 * UNIT * (c * x.value).abs();
    }
    sum
}

/// A rigid motion of all bodies as a tangent vector: three translations, three rotations about the origin.
fn generator(places: &Places, inputs: &[f64], number: usize) -> Vec<f64> {
    let axis = number % 3;
    let entry = |c: &crate::sample::inputs::Coordinate| match (number < 3, c.role) {
        (true, Role::Position) | (false, Role::Orientation) => f64::from(u8::from(c.axis == axis)),
        (false, Role::Position) if c.axis == (axis + 1) % 3 => -inputs[c.start + (axis + 2) % 3],
        (false, Role::Position) if c.axis == (axis + 2) % 3 => inputs[c.start + (axis + 1) % 3],
        _ => 0.0,
    };
    places.pose.iter().map(entry).collect()
}

/// A state at damping 0 and the kernel's outputs there.
struct Undamped {
    state: State,
    outputs: Vec<Bounded>,
    /// Whether the damping is 0: false if another damping is compiled into the kernel.
    is_possible: bool,
}

/// Whether the damping can be 0: it is an argument, or a compiled-in 0.
fn can_be_undamped(places: &Places) -> bool {
    let damping = places.signature.parameters.last().and_then(|damping| damping.value.as_ref());
    damping.is_none_or(|set| set.iter().all(Exact::is_zero))
}

impl Seen<'_> {
    fn undamped(&self) -> Undamped {
        let mut state = self.state.clone();
        if !self.oracle.is_constraint() {
            return Undamped { state, outputs: self.outputs.to_vec(), is_possible: true };
        }
        if !can_be_undamped(self.places) {
            return Undamped { state, outputs: self.outputs.to_vec(), is_possible: false };
        }
        let damping = self.places.parameter(self.places.signature.parameters.len() - 1);
        state.values[damping..].fill(0.0);
        let outputs = self.tape.bounds(&state.values, self.errors);
        Undamped { state, outputs, is_possible: true }
    }

    fn entry(&self, name: String, expected: f64, computed: f64, tolerance: f64, state: &State) -> Entry {
        Entry {
            name,
            expected,
            computed,
            error: (expected - computed).abs(),
            tolerance,
            family: self.family,
            inputs: self.places.inputs(&state.values),
        }
    }
}
