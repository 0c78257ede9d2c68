//! The exact oracle: force and derivatives from the source, by difference quotients in 320 bits.
//!
//! In: a verbatim definition and a state. Out: F, ∂F/∂X and ∂F/∂V as docs/mathematics.md defines them, to
//! about thirty digits. The oracle shares no code with derivation or optimisation: C, E or F is evaluated as
//! written, J is the difference quotient along each tangent coordinate, x ← x + δx and q ← exp(δθ/2) q, and
//! ∂F/∂X is the difference quotient of that F. Steps of 2⁻¹⁰⁴ make one-sided quotients with a truncation
//! error of about 2⁻¹⁰⁴ and a rounding error of about 2⁻¹¹⁰, far below a double's 2⁻⁵³. ∂F/∂X takes about N +
//! N²/2 evaluations of C, each limited to the nodes that depend on the moved coordinates.

mod point;

use crate::math::number::Number;
use crate::model::bodies::{Role, Slot};
use crate::sample::inputs::{Coordinate, Places};
use crate::sample::states::State;
use crate::vector::definition::{Definition, Law, Row};
use crate::verify::big::Big;
use crate::verify::source::{self, Fields, Source, Values, field_bit};
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// The step is 2 to the minus this power.
const STEP: i32 = 104;
/// The truncation error of a quotient, as a power of two of the largest value in the source: 2⁻¹⁰⁴ times half
/// a second derivative, at most 2¹² times that value. The rounding error, 2⁻³¹⁰ over two steps, is smaller.
const TRUNCATION: i32 = 12 - STEP;
/// Above 2 to this power, products in a kernel's derivatives may overflow doubles; such states are singular.
const LARGEST: i32 = 200;

/// The source of a kernel, prepared for differentiation.
pub(crate) struct Oracle<'d> {
    places: &'d Places,
    source: Source<'d, Big>,
    outputs: Vec<Output>,
    law: Statement,
    /// The bit of the field of each coordinate.
    pose_bits: Vec<Fields>,
    velocity_bits: Vec<Fields>,
    /// The power of two that scales steps of positions and velocities to the distances of bodies.
    shift: i32,
}

/// A node that has one row or three.
#[derive(Clone, Copy)]
pub(super) enum Output {
    Real(usize),
    Vector(usize),
}

/// The kind of law.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Statement {
    Constraint { unilateral: bool, per_row: bool },
    Energy,
    Force,
}

impl Statement {
    /// The rows of a definition, for the moving bodies, and the kind of law.
    pub(super) fn of(definition: &Definition, places: &Places) -> (Vec<Output>, Statement) {
        match &definition.law {
            Law::Constraint { rows, unilateral, per_row } => {
                let output = |row: &Row| match row {
                    Row::Real(x) => Output::Real(x.index()),
                    Row::Vector(v) => Output::Vector(v.index()),
                };
                let law = Statement::Constraint { unilateral: *unilateral, per_row: *per_row };
                (rows.iter().map(output).collect(), law)
            }
            Law::Energy(energy) => (vec![Output::Real(energy.index())], Statement::Energy),
            Law::Force(forces) => {
                let moving = places.signature.moving().map(|(body, _)| &forces[body]);
                let blocks = moving.flat_map(|f| std::iter::once(f.force).chain(f.torque));
                (blocks.map(|v| Output::Vector(v.index())).collect(), Statement::Force)
            }
        }
    }
}

impl Output {
    pub(super) fn node(self) -> usize {
        match self {
            Output::Real(node) | Output::Vector(node) => node,
        }
    }

    /// The values of rows.
    pub(super) fn rows<N: Number>(outputs: &[Output], source: &Source<N>, values: &Values<N>) -> Vec<N> {
        let mut rows = Vec::new();
        for output in outputs {
            match *output {
                Output::Real(node) => rows.push(source.get(values, node).real().clone()),
                Output::Vector(node) => rows.extend(source.get(values, node).vector().iter().cloned()),
            }
        }
        rows
    }
}

/// The bit of the field of each coordinate.
pub(super) fn field_bits(places: &Places, coordinates: &[Coordinate]) -> Vec<Fields> {
    let bit = |c: &Coordinate| {
        let slot = places.signature.body_slot(c.body, c.role);
        slot.map_or(0, |slot: Slot| field_bit(places, slot))
    };
    coordinates.iter().map(bit).collect()
}

/// Why a state cannot be used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Singular {
    /// A value or derivative does not exist.
    Value,
    /// The difference stencil crosses a branch.
    Branch,
}

/// The exact values at one state.
pub(crate) struct Point<'o, 'd> {
    oracle: &'o Oracle<'d>,
    inputs: Vec<Big>,
    values: Values<'static, Big>,
    /// C, E or F as written.
    pub(crate) rows: Vec<Big>,
    /// ∂row/∂coordinate; empty for a force.
    jacobian: Vec<Vec<Big>>,
    /// λ; for an energy, 1.
    multipliers: Vec<Big>,
    /// `Less` for a row that pushes, `Equal` on the switch, `Greater` for an inactive row.
    activity: Vec<Ordering>,
    /// F.
    pub(crate) force: Vec<Big>,
    /// A bound on the truncation and rounding errors in F and its derivatives.
    pub(crate) noise: f64,
}

/// Columns of ∂F/∂X or ∂F/∂V along directions of the tangent space, with a bound on their error.
pub(crate) struct Columns {
    pub(crate) columns: Vec<Vec<Big>>,
    pub(crate) noise: f64,
}

impl Columns {
    /// The entries row by row.
    pub(crate) fn by_row(&self) -> Vec<Big> {
        let rows = 0..self.columns.first().map_or(0, Vec::len);
        rows.flat_map(|row| self.columns.iter().map(move |column| column[row].clone())).collect()
    }

    /// The matrix times a direction.
    fn times(&self, direction: &[Big]) -> Vec<Big> {
        let mut sum = vec![Big::zero(); self.columns.first().map_or(0, Vec::len)];
        for (column, d) in self.columns.iter().zip(direction).filter(|(_, d)| !d.is_zero()) {
            for (s, x) in sum.iter_mut().zip(column) {
                *s = s.clone() + x.clone() * d.clone();
            }
        }
        sum
    }
}

/// The quantity that is differentiated.
enum Of {
    /// F
    Force,
    /// λ
    Multipliers,
    /// F with these values added to λ.
    Held(Vec<Big>),
    /// Jᵀ times these values.
    Pull(Vec<Big>),
}

impl Of {
    fn pick(&self, oracle: &Oracle<'_>, jacobian: &[Vec<Big>], mut multipliers: Vec<Big>) -> Vec<Big> {
        match self {
            Of::Force => {}
            Of::Multipliers => return multipliers,
            Of::Pull(given) => {
                let opposite: Vec<Big> = given.iter().map(|x| -x.clone()).collect();
                return oracle.force(jacobian, &opposite);
            }
            Of::Held(more) => {
                multipliers.iter_mut().zip(more).for_each(|(x, more)| *x = x.clone() + more.clone());
            }
        }
        oracle.force(jacobian, &multipliers)
    }
}

/// Rows after a step along each of two coordinates, if the steps commute: all pairs but rotations of one
/// body.
#[derive(Default)]
struct TwoSteps(BTreeMap<(usize, usize), Vec<Big>>);

impl TwoSteps {
    fn keep(&mut self, pose: &[Coordinate], first: usize, second: usize, rows: &[Big]) {
        let turns = pose[first].role == Role::Orientation && pose[first].start == pose[second].start;
        if second > first && !turns {
            self.0.insert((first, second), rows.to_vec());
        }
    }

    fn take(&mut self, first: usize, second: usize) -> Option<Vec<Big>> {
        self.0.remove(&(second, first))
    }
}

impl<'d> Oracle<'d> {
    pub(crate) fn new(definition: &'d Definition, places: &'d Places) -> Oracle<'d> {
        let (outputs, law) = Statement::of(definition, places);
        let wanted = outputs.iter().map(|output| output.node());
        Oracle {
            places,
            source: Source::new(&definition.graph, places, wanted),
            outputs,
            law,
            pose_bits: field_bits(places, &places.pose),
            velocity_bits: field_bits(places, &places.velocity),
            shift: Big::from_f64(places.signature.scale.length.unwrap_or(1.0))
                .exponent()
                .map_or(0, |e| e - 1),
        }
    }

    /// The approximate cost of all columns of ∂F/∂X at one state, in 320-bit additions.
    pub(crate) fn cost(&self) -> u64 {
        let n = self.places.pose.len() as u64;
        match self.law {
            Statement::Force => n * self.source.cost(),
            // Half of the pairs of steps; each evaluates about half of the source.
            _ => n * n / 4 * self.source.cost() + 4 * n * n * self.outputs.len() as u64,
        }
    }

    /// Whether the rows are those of a constraint.
    pub(crate) fn is_constraint(&self) -> bool {
        matches!(self.law, Statement::Constraint { .. })
    }

    /// Whether the function is an energy.
    pub(crate) fn is_energy(&self) -> bool {
        self.law == Statement::Energy
    }

    /// The rows, λ and F at a state.
    pub(crate) fn point(&self, state: &State) -> Result<Point<'_, 'd>, Singular> {
        self.point_at(state.values.iter().map(|x| Big::from_f64(*x)).collect())
    }

    /// The same with quaternions normalised to length one: kernels may use |q| = 1 in derivatives, so the
    /// exact derivatives must not depend on the rounding of q.
    pub(crate) fn unit_point(&self, state: &State) -> Result<Point<'_, 'd>, Singular> {
        let mut inputs: Vec<Big> = state.values.iter().map(|x| Big::from_f64(*x)).collect();
        for at in crate::verify::quaternions(self.places) {
            let squares = inputs[at..at + 4].iter().map(|x| x.clone() * x.clone());
            let length = squares.reduce(|sum, square| sum + square).map(|square| square.sqrt());
            let length = length.unwrap_or_else(|| Big::from_f64(1.0));
            for x in &mut inputs[at..at + 4] {
                *x = x.clone() / length.clone();
            }
        }
        self.point_at(inputs)
    }

    /// The same for 320-bit inputs.
    pub(crate) fn point_at(&self, inputs: Vec<Big>) -> Result<Point<'_, 'd>, Singular> {
        let mut values = self.source.evaluate(&inputs);
        self.source.mark_edges(&mut values);
        let rows = self.rows(&values);
        if !all_finite(&rows) {
            return Err(Singular::Value);
        }
        let gains = if self.is_constraint() { 2 } else { 0 };
        let parameters = self.places.signature.parameters.len();
        let end = if gains > 0 { self.places.parameter(parameters - gains) } else { inputs.len() };
        let mut largest = inputs[..end].iter().filter_map(Big::exponent).max().unwrap_or(0);
        for value in values.own() {
            largest = match value {
                source::Value::Real(x) => x.exponent().map_or(largest, |e| e.max(largest)),
                source::Value::Vector(v) => v.iter().filter_map(Big::exponent).fold(largest, i32::max),
                source::Value::Truth(_) => largest,
            };
        }
        if largest > LARGEST {
            return Err(Singular::Value);
        }
        let noise = 2f64.powi(largest.max(-LARGEST)) * 2f64.powi(TRUNCATION);
        let mut point = Point {
            oracle: self,
            inputs,
            values,
            rows,
            jacobian: Vec::new(),
            multipliers: Vec::new(),
            activity: Vec::new(),
            force: Vec::new(),
            noise,
        };
        if self.law == Statement::Force {
            point.force = point.rows.clone();
            return Ok(point);
        }
        point.jacobian = point.jacobian_at(&point.values, &point.inputs, &point.rows, None)?;
        let velocities = self.velocities(&point.inputs);
        (point.multipliers, point.activity) =
            self.multipliers(&point.inputs, &point.rows, &point.jacobian, &velocities);
        point.force = self.force(&point.jacobian, &point.multipliers);
        // The effect on F of an error of size `noise` in rows, J and dC/dt.
        let size = |x: &Big| x.to_f64().abs();
        let entry = point.jacobian.iter().flatten().map(size).fold(0.0, f64::max);
        let push: f64 = point.multipliers.iter().map(size).sum();
        let speed: f64 = velocities.iter().map(size).sum();
        let gains: f64 = (0..point.rows.len())
            .map(|row| self.gains(&point.inputs, row))
            .map(|(stiffness, damping)| size(&stiffness) + size(&damping) * speed)
            .sum();
        point.noise = noise * (1.0 + push + entry * gains);
        if !all_finite(&point.force) || !point.noise.is_finite() {
            return Err(Singular::Value);
        }
        Ok(point)
    }

    fn rows(&self, values: &Values<Big>) -> Vec<Big> {
        Output::rows(&self.outputs, &self.source, values)
    }

    fn velocities(&self, inputs: &[Big]) -> Vec<Big> {
        self.places.velocity.iter().map(|c| inputs[c.start + c.axis].clone()).collect()
    }

    /// ks and kd of a row; zero unless the law is a constraint.
    fn gains(&self, inputs: &[Big], row: usize) -> (Big, Big) {
        let Statement::Constraint { per_row, .. } = self.law else { return (Big::zero(), Big::zero()) };
        let parameters = self.places.signature.parameters.len();
        let offset = if per_row { row } else { 0 };
        let gain = |parameter: usize| inputs[self.places.parameter(parameter) + offset].clone();
        (gain(parameters - 2), gain(parameters - 1))
    }

    /// λ of every row, and its activity.
    fn multipliers(
        &self,
        inputs: &[Big],
        rows: &[Big],
        jacobian: &[Vec<Big>],
        velocities: &[Big],
    ) -> (Vec<Big>, Vec<Ordering>) {
        let mut multipliers = Vec::new();
        let mut activity = Vec::new();
        for (row, c) in rows.iter().enumerate() {
            let Statement::Constraint { unilateral, .. } = self.law else {
                multipliers.push(Big::integer(1));
                activity.push(Ordering::Less);
                continue;
            };
            let (stiffness, damping) = self.gains(inputs, row);
            let rate = inner(&jacobian[row], velocities);
            let multiplier = stiffness * c.clone() + damping * rate;
            let side = match (unilateral, c.sign()) {
                (true, Ordering::Less) => multiplier.sign(),
                (true, side) => side,
                (false, _) => Ordering::Less,
            };
            multipliers.push(if side == Ordering::Less { multiplier } else { Big::zero() });
            activity.push(side);
        }
        (multipliers, activity)
    }

    /// −Jᵀ λ
    fn force(&self, jacobian: &[Vec<Big>], multipliers: &[Big]) -> Vec<Big> {
        let mut force = vec![Big::zero(); self.places.pose.len()];
        for (row, multiplier) in jacobian.iter().zip(multipliers).filter(|(_, m)| !m.is_zero()) {
            for (f, j) in force.iter_mut().zip(row) {
                if !j.is_zero() {
                    *f = f.clone() - j.clone() * multiplier.clone();
                }
            }
        }
        force
    }

    /// The power of two that scales a step along a coordinate.
    pub(crate) fn shift(&self, coordinate: &Coordinate) -> i32 {
        match coordinate.role {
            Role::Position | Role::Velocity => self.shift,
            Role::Orientation | Role::AngularVelocity => 0,
        }
    }

    /// The inputs after a step along one coordinate.
    fn moved(&self, inputs: &[Big], coordinate: &Coordinate) -> Vec<Big> {
        let mut direction = vec![0.0; 3];
        direction[coordinate.axis] = 2f64.powi(self.shift(coordinate));
        let mut moved = inputs.to_vec();
        step(&mut moved, coordinate, &direction);
        moved
    }
}

/// A step of a field along a direction, given by its three coordinates.
fn step(inputs: &mut [Big], coordinate: &Coordinate, direction: &[f64]) {
    let field = &mut inputs[coordinate.start..];
    if coordinate.role != Role::Orientation {
        for (x, d) in field.iter_mut().zip(direction).filter(|(_, d)| **d != 0.0) {
            *x = x.clone() + Big::from_f64(*d).scaled(-STEP);
        }
        return;
    }
    // exp(a) = cos |a| + a sin |a| / |a| with a = δθ/2; |a|⁴ is negligible in 320 bits.
    let a: Vec<Big> = direction.iter().map(|d| Big::from_f64(*d).scaled(-STEP - 1)).collect();
    let square = inner(&a, &a);
    let cosine = Big::integer(1) - square.clone().scaled(-1);
    let ratio = Big::integer(1) - square / Big::integer(6);
    let turn = [0, 1, 2].map(|k| a[k].clone() * ratio.clone());
    let q = [0, 1, 2, 3].map(|k| field[k].clone());
    for (stored, turned) in field.iter_mut().zip(multiply(&turn, &cosine, &q)) {
        *stored = turned;
    }
}

/// The quaternion (u, w) times q, stored x, y, z, w.
fn multiply(u: &[Big; 3], w: &Big, q: &[Big; 4]) -> [Big; 4] {
    let v = [q[0].clone(), q[1].clone(), q[2].clone()];
    let [x, y, z] = source::cross(u, &v);
    let along = |k: usize, cross: Big| w.clone() * v[k].clone() + u[k].clone() * q[3].clone() + cross;
    [along(0, x), along(1, y), along(2, z), w.clone() * q[3].clone() - source::dot(u, &v)]
}

pub(crate) fn inner(x: &[Big], y: &[Big]) -> Big {
    let mut sum = Big::zero();
    for (a, b) in x.iter().zip(y).filter(|(a, b)| !a.is_zero() && !b.is_zero()) {
        sum = sum + a.clone() * b.clone();
    }
    sum
}

fn all_finite(x: &[Big]) -> bool {
    x.iter().all(|x| x.is_finite() && x.to_f64().is_finite())
}

/// Fails if a step crossed a branch or has no derivative.
fn regular(values: &Values<Big>) -> Result<(), Singular> {
    match (values.crossed, values.at_edge) {
        (true, _) => Err(Singular::Branch),
        (_, true) => Err(Singular::Value),
        _ => Ok(()),
    }
}

/// (after − before)/step, with the step multiplied by 2 to the power `shift`.
fn quotient(after: &[Big], before: &[Big], shift: i32) -> Vec<Big> {
    after.iter().zip(before).map(|(a, b)| (a.clone() - b.clone()).scaled(STEP - shift)).collect()
}

/// The changes under a rigid motion, each with the size of its terms.
pub(crate) struct Work {
    /// The rows of C, or E.
    pub(crate) rows: (f64, f64),
    /// The elastic energy of the rows at damping 0, or E.
    pub(crate) elastic: (f64, f64),
}
