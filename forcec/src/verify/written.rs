//! Evaluates the source as written, in the kernel's own precision, with dual numbers.
//!
//! In: a verbatim definition and a state. Out: every output of a kernel, computed as an author would with
//! dual numbers: C, E or F operation by operation, J and its derivative from the parts of the dual numbers, λ
//! and the rest by definition. Bodies move by x ← x + δx, q ← exp(δθ/2) q. No code is shared with derivation
//! or optimisation. The rounding error of this evaluation is the standard for the rounding error of kernels.

use crate::math::number::Comparison;
use crate::model::bodies::Role;
use crate::model::outputs::Part;
use crate::sample::inputs::{Coordinate, Places};
use crate::vector::definition::Definition;
use crate::verify::dual::{Dual, Scalar};
use crate::verify::oracle::{Output, Statement, field_bits};
use crate::verify::source::{Fields, Source, Values};

/// The source of a kernel, prepared for evaluation in one precision.
pub(crate) struct Written<'d, F> {
    places: &'d Places,
    source: Source<'d, Dual<F>>,
    outputs: Vec<Output>,
    law: Statement,
    pose_bits: Vec<Fields>,
    velocity_bits: Vec<Fields>,
}

/// The source at one state: rows and their derivatives.
pub(crate) struct Text<'w, 'd, F> {
    written: &'w Written<'d, F>,
    inputs: Vec<F>,
    /// C, E or F.
    rows: Vec<F>,
    /// For each row, the derivatives along pose coordinates; `along_velocity` has a force's along velocities.
    jacobian: Vec<Vec<F>>,
    along_velocity: Vec<Vec<F>>,
    /// D_j (D_i row) at [i][j], for each row.
    second: Vec<Vec<Vec<F>>>,
    multipliers: Vec<F>,
    active: Vec<bool>,
}

/// The quantity that is differentiated.
enum Of<'m, F> {
    Force,
    Multipliers,
    /// F with these values for λ.
    Held(&'m [F]),
}

impl<'d, F: Scalar> Written<'d, F> {
    pub(crate) fn new(definition: &'d Definition, places: &'d Places) -> Written<'d, F> {
        let (outputs, law) = Statement::of(definition, places);
        let wanted = outputs.iter().map(|output| output.node());
        Written {
            places,
            source: Source::new(&definition.graph, places, wanted),
            outputs,
            law,
            pose_bits: field_bits(places, &places.pose),
            velocity_bits: field_bits(places, &places.velocity),
        }
    }

    /// Evaluates the source at a state; `second` requests second derivatives.
    pub(crate) fn at(&self, inputs: Vec<F>, second: bool) -> Text<'_, 'd, F> {
        let point: Vec<Dual<F>> = inputs.iter().cloned().map(Dual::constant).collect();
        let values = self.source.evaluate(&point);
        let rows: Vec<F> = self.rows(&values).into_iter().map(|row| row.value).collect();
        let n = self.places.pose.len();
        let mut text = Text {
            written: self,
            inputs,
            jacobian: rows.iter().map(|_| Vec::with_capacity(n)).collect(),
            along_velocity: rows.iter().map(|_| Vec::new()).collect(),
            second: Vec::new(),
            rows,
            multipliers: Vec::new(),
            active: Vec::new(),
        };
        if self.law == Statement::Force || !second {
            self.first(&mut text, &values, &point);
        } else {
            self.both(&mut text, &values, &point);
        }
        text.multiply();
        text
    }

    fn rows(&self, values: &Values<Dual<F>>) -> Vec<Dual<F>> {
        Output::rows(&self.outputs, &self.source, values)
    }

    /// Computes first derivatives only.
    fn first(&self, text: &mut Text<F>, values: &Values<Dual<F>>, point: &[Dual<F>]) {
        let derivative = |coordinate: &Coordinate, bits: Fields| {
            let mut moved = point.to_vec();
            seed(&mut moved, &[coordinate]);
            self.rows(&self.source.update(values, &moved, bits)).into_iter().map(|row| row.along[0].clone())
        };
        for (coordinate, bits) in self.places.pose.iter().zip(&self.pose_bits) {
            let column = derivative(coordinate, *bits);
            text.jacobian.iter_mut().zip(column).for_each(|(row, x)| row.push(x));
        }
        if self.law == Statement::Force {
            for (coordinate, bits) in self.places.velocity.iter().zip(&self.velocity_bits) {
                let column = derivative(coordinate, *bits);
                text.along_velocity.iter_mut().zip(column).for_each(|(row, x)| row.push(x));
            }
        }
    }

    /// Computes first and second derivatives. Only two rotations of one body do not commute.
    fn both(&self, text: &mut Text<F>, values: &Values<Dual<F>>, point: &[Dual<F>]) {
        let pose = &self.places.pose;
        let n = pose.len();
        text.second = vec![vec![vec![F::of(0.0); n]; n]; text.rows.len()];
        for i in 0..n {
            for j in 0..n {
                let turns = pose[i].role == Role::Orientation && pose[i].start == pose[j].start;
                if j > i && !turns {
                    continue;
                }
                let mut moved = point.to_vec();
                seed(&mut moved, &[&pose[i], &pose[j]]);
                let bits = self.pose_bits[i] | self.pose_bits[j];
                let rows = self.rows(&self.source.update(values, &moved, bits));
                for (r, row) in rows.into_iter().enumerate() {
                    if i == j {
                        text.jacobian[r].push(row.along[0].clone());
                    }
                    if !turns {
                        text.second[r][j][i] = row.mixed.clone();
                    }
                    text.second[r][i][j] = row.mixed;
                }
            }
        }
    }
}

/// Seeds the derivatives of a state along a coordinate, or along two, of which the second is applied first:
/// two rotations of one body are exp(ε₁ e_i/2) exp(ε₂ e_j/2) q.
fn seed<F: Scalar>(point: &mut [Dual<F>], coordinates: &[&Coordinate]) {
    for (motion, coordinate) in coordinates.iter().enumerate() {
        let field = &mut point[coordinate.start..];
        if coordinate.role == Role::Orientation {
            let turned = half_turn(coordinate.axis, [0, 1, 2, 3].map(|k| field[k].value.clone()));
            field.iter_mut().zip(turned).for_each(|(x, turned)| x.along[motion] = turned);
        } else {
            field[coordinate.axis].along[motion] = F::of(1.0);
        }
    }
    if let [first, second] = coordinates
        && first.role == Role::Orientation
        && first.start == second.start
    {
        let field = &mut point[first.start..];
        let turned = half_turn(first.axis, [0, 1, 2, 3].map(|k| field[k].along[1].clone()));
        field.iter_mut().zip(turned).for_each(|(x, turned)| x.mixed = turned);
    }
}

/// ½ e q for the unit vector e of an axis, stored x, y, z, w: (u, w) becomes ½ (w e + e × u, −e·u).
fn half_turn<F: Scalar>(axis: usize, q: [F; 4]) -> [F; 4] {
    let half = |x: &F| F::of(0.5) * x.clone();
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut turned = [(); 4].map(|()| F::of(0.0));
    turned[axis] = half(&q[3]);
    turned[next] = -half(&q[last]);
    turned[last] = half(&q[next]);
    turned[3] = -half(&q[axis]);
    turned
}

/// Σ x y, without an initial zero.
fn inner<F: Scalar>(pairs: impl Iterator<Item = (F, F)>) -> F {
    pairs.map(|(x, y)| x * y).reduce(|sum, x| sum + x).unwrap_or_else(|| F::of(0.0))
}

impl<F: Scalar> Text<'_, '_, F> {
    fn velocity(&self, coordinate: usize) -> F {
        let Coordinate { start, axis, .. } = self.written.places.velocity[coordinate];
        self.inputs[start + axis].clone()
    }

    fn dofs(&self) -> usize {
        self.written.places.pose.len()
    }

    /// ks and kd of a row.
    fn gains(&self, row: usize) -> (F, F) {
        let Statement::Constraint { per_row, .. } = self.written.law else { return (F::of(0.0), F::of(0.0)) };
        let places = self.written.places;
        let parameters = places.signature.parameters.len();
        let offset = if per_row { row } else { 0 };
        let gain = |parameter: usize| self.inputs[places.parameter(parameter) + offset].clone();
        (gain(parameters - 2), gain(parameters - 1))
    }

    /// Ċ of a row, J V.
    fn rate(&self, row: usize) -> F {
        inner(self.jacobian[row].iter().enumerate().map(|(k, x)| (x.clone(), self.velocity(k))))
    }

    /// D(J V) V of a row.
    fn drift(&self, row: usize) -> F {
        let second = self.second[row].iter().enumerate();
        let entries = second.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, x)| (i, j, x)));
        inner(entries.map(|(i, j, x)| (x.clone() * self.velocity(i), self.velocity(j))))
    }

    /// λ of every row: ks C + kd Ċ; for an energy, 1.
    fn multiply(&mut self) {
        for row in 0..self.rows.len() {
            let (multiplier, active) = match self.written.law {
                Statement::Constraint { unilateral, .. } => {
                    let (stiffness, damping) = self.gains(row);
                    let multiplier = stiffness * self.rows[row].clone() + damping * self.rate(row);
                    let negative = |x: &F| F::holds(Comparison::Less, x, &F::of(0.0));
                    let active = !unilateral || negative(&self.rows[row]) && negative(&multiplier);
                    (if active { multiplier } else { F::of(0.0) }, active)
                }
                _ => (F::of(1.0), true),
            };
            self.multipliers.push(multiplier);
            self.active.push(active);
        }
    }

    /// F for these multipliers.
    fn force(&self, multipliers: &[F]) -> Vec<F> {
        if self.written.law == Statement::Force {
            return self.rows.clone();
        }
        let term = |k: usize| move |(row, multiplier): (&Vec<F>, &F)| (row[k].clone(), multiplier.clone());
        (0..self.dofs()).map(|k| -inner(self.jacobian.iter().zip(multipliers).map(term(k)))).collect()
    }

    /// ∂λ/∂X_j or ∂λ/∂V_j of a row.
    fn multiplier_along(&self, row: usize, j: usize, pose: bool) -> F {
        if !self.active[row] || !matches!(self.written.law, Statement::Constraint { .. }) {
            return F::of(0.0);
        }
        let (stiffness, damping) = self.gains(row);
        let slope = self.jacobian[row][j].clone();
        if !pose {
            return damping * slope;
        }
        let rate = inner((0..self.dofs()).map(|k| (self.second[row][k][j].clone(), self.velocity(k))));
        stiffness * slope + damping * rate
    }

    /// The derivatives of the quantity `of` along every coordinate of the pose or the velocity, row by row.
    fn along(&self, of: &Of<F>, pose: bool) -> Vec<Vec<F>> {
        let (n, rows) = (self.dofs(), self.rows.len());
        if self.written.law == Statement::Force {
            return if pose { self.jacobian.clone() } else { self.along_velocity.clone() };
        }
        let changes: Vec<Vec<F>> =
            (0..rows).map(|row| (0..n).map(|j| self.multiplier_along(row, j, pose)).collect()).collect();
        let multipliers: &[F] = match of {
            Of::Multipliers => return changes,
            Of::Held(given) => given,
            Of::Force => &self.multipliers,
        };
        // D_j F_i = −Σ (D_j J_i) λ + J_i D_j λ
        let entry = |i: usize, j: usize| {
            let terms = (0..rows).filter(|row| self.active[*row]).flat_map(|row| {
                let turn = pose.then(|| (self.second[row][i][j].clone(), multipliers[row].clone()));
                turn.into_iter().chain([(self.jacobian[row][i].clone(), changes[row][j].clone())])
            });
            -inner(terms)
        };
        (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
    }

    /// The entries of an extra argument.
    fn extra(&self, name: &str) -> Vec<F> {
        let places = self.written.places;
        let slot =
            places.signature.extra_slot(name, 0).expect("an output that needs this argument was requested");
        let length = places.signature.parameter(slot).map_or(0, |extra| extra.ty.length() as usize);
        self.inputs[places.place(slot)..][..length].to_vec()
    }

    /// h ∂/∂V + h² ∂/∂X
    fn stepped(&self, of: &Of<F>) -> Vec<F> {
        let h = &self.extra("step")[0];
        let (along_x, along_v) = (self.along(of, true).concat(), self.along(of, false).concat());
        let square = h.clone() * h.clone();
        let pairs = along_v.into_iter().zip(along_x);
        pairs.map(|(dv, dx)| h.clone() * dv + square.clone() * dx).collect()
    }

    fn times(&self, matrix: &[Vec<F>], direction: &[F]) -> Vec<F> {
        matrix.iter().map(|row| inner(row.iter().cloned().zip(direction.iter().cloned()))).collect()
    }

    /// An output, row by row.
    pub(crate) fn part(&self, part: Part) -> Vec<F> {
        match part {
            Part::Value => self.rows.clone(),
            Part::Rate => (0..self.rows.len()).map(|row| self.rate(row)).collect(),
            Part::Jacobian => self.jacobian.concat(),
            Part::Drift => (0..self.rows.len()).map(|row| self.drift(row)).collect(),
            Part::Multiplier => self.multipliers.clone(),
            Part::Force => self.force(&self.multipliers),
            Part::Dfdx => self.along(&Of::Force, true).concat(),
            Part::Dfdv => self.along(&Of::Force, false).concat(),
            Part::Impulse => {
                let h = &self.extra("step")[0];
                let velocities: Vec<F> = (0..self.dofs()).map(|k| self.velocity(k)).collect();
                let change = self.times(&self.along(&Of::Force, true), &velocities);
                let force = self.force(&self.multipliers).into_iter().zip(change);
                force.map(|(f, df)| h.clone() * (f + h.clone() * df)).collect()
            }
            Part::Matrix => self.stepped(&Of::Force),
            Part::MultiplierStep => self.stepped(&Of::Multipliers),
            Part::Held => self.stepped(&Of::Held(&self.extra("multipliers"))),
            Part::Pull => self.force(&self.extra("multipliers")).into_iter().map(|x| -x).collect(),
            Part::Geometric => {
                let multipliers = self.extra("multipliers");
                let columns = (0..self.dofs()).flat_map(|i| (0..self.dofs()).map(move |j| (i, j)));
                let rows = |i: usize, j: usize| self.second.iter().map(move |row| row[i][j].clone());
                columns.map(|(i, j)| inner(rows(i, j).zip(multipliers.iter().cloned()))).collect()
            }
            Part::DfdxProduct => self.times(&self.along(&Of::Force, true), &self.extra("direction")),
            Part::DfdvProduct => self.times(&self.along(&Of::Force, false), &self.extra("direction")),
            Part::List(_) | Part::Block(_) => unreachable!("a program computes results, not their pieces"),
        }
    }
}

/// Whether an output needs second derivatives of the rows.
pub(crate) fn is_second(part: Part) -> bool {
    !matches!(
        part,
        Part::Value
            | Part::Rate
            | Part::Jacobian
            | Part::Multiplier
            | Part::Pull
            | Part::Force
            | Part::Dfdv
            | Part::DfdvProduct
    )
}
