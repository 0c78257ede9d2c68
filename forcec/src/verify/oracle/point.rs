//! The exact oracle at one state: derivatives of F, and all outputs that kernels may compute.
//!
//! In: a point with its rows, λ and F. Out: difference quotients along coordinates, columns of matrices, and
//! outputs by name; or an error if the state cannot be used.

use crate::model::bodies::Role;
use crate::model::outputs::Part;
use crate::sample::inputs::Coordinate;
use crate::verify::big::Big;
use crate::verify::oracle::{
    Columns, Of, Output, Point, STEP, Singular, Statement, TwoSteps, Work, all_finite, inner, multiply,
    quotient, regular, step,
};
use crate::verify::search::Decider;
use crate::verify::source::{self, Values};
use std::cmp::Ordering;

impl Point<'_, '_> {
    /// Whether some force is not zero.
    pub(crate) fn pushes(&self) -> bool {
        self.force.iter().any(|f| !f.is_zero())
    }

    /// The branches that determine the force here, each with its side.
    pub(crate) fn branches(&self) -> Vec<(Decider, bool)> {
        let oracle = self.oracle;
        let pushes = |row: usize| self.activity.get(row).is_none_or(|side| *side == Ordering::Less);
        let mut branches = Vec::new();
        if let Statement::Constraint { unilateral: true, .. } = oracle.law {
            branches.extend((0..self.rows.len()).map(|row| (Decider::Row(row), pushes(row))));
        }
        let mut row = 0;
        let mut roots = Vec::new();
        for output in &oracle.outputs {
            let (node, count) = match *output {
                Output::Real(node) => (node, 1),
                Output::Vector(node) => (node, 3),
            };
            if (row..row + count).any(pushes) {
                roots.push(node);
            }
            row += count;
        }
        let nodes = oracle.source.branches(&self.values, roots).into_iter();
        branches.extend(nodes.map(|(node, side)| (Decider::Node(node), side)));
        branches
    }

    /// Whether some derivative exists only while arguments are constant, as that of `max(x, 0).sqrt()`. The
    /// exact derivative exists then; a kernel may return the result of IEEE arithmetic.
    pub(crate) fn has_edges(&self) -> bool {
        self.values.has_edges()
    }

    /// J at inputs with known values and rows. `shared` stores rows that later columns of ∂F/∂X need again.
    pub(super) fn jacobian_at(
        &self,
        values: &Values<Big>,
        inputs: &[Big],
        rows: &[Big],
        mut shared: Option<(usize, &mut TwoSteps)>,
    ) -> Result<Vec<Vec<Big>>, Singular> {
        let oracle = self.oracle;
        let mut jacobian = vec![Vec::with_capacity(oracle.places.pose.len()); rows.len()];
        for (k, coordinate) in oracle.places.pose.iter().enumerate() {
            let met = shared.as_mut().and_then(|(column, steps)| steps.take(*column, k));
            let after = match met {
                Some(after) => after,
                None => {
                    let moved = oracle.moved(inputs, coordinate);
                    let next = oracle.source.update(values, &moved, oracle.pose_bits[k]);
                    regular(&next)?;
                    let after = oracle.rows(&next);
                    if !all_finite(&after) {
                        return Err(Singular::Value);
                    }
                    if let Some((column, steps)) = &mut shared {
                        steps.keep(&oracle.places.pose, *column, k, &after);
                    }
                    after
                }
            };
            for (row, entry) in jacobian.iter_mut().zip(quotient(&after, rows, oracle.shift(coordinate))) {
                row.push(entry);
            }
        }
        Ok(jacobian)
    }

    /// The quantity `of` after the pose moved.
    fn force_at(
        &self,
        of: &Of,
        values: &Values<Big>,
        inputs: &[Big],
        shared: Option<(usize, &mut TwoSteps)>,
    ) -> Result<Vec<Big>, Singular> {
        let oracle = self.oracle;
        regular(values)?;
        let rows = oracle.rows(values);
        if !all_finite(&rows) {
            return Err(Singular::Value);
        }
        if oracle.law == Statement::Force {
            return Ok(rows);
        }
        let jacobian = self.jacobian_at(values, inputs, &rows, shared)?;
        let velocities = oracle.velocities(inputs);
        let (multipliers, activity) = oracle.multipliers(inputs, &rows, &jacobian, &velocities);
        if activity != self.activity {
            return Err(Singular::Branch);
        }
        Ok(of.pick(oracle, &jacobian, multipliers))
    }

    /// The quantity `of` at this point.
    fn here(&self, of: &Of) -> Vec<Big> {
        match of {
            Of::Force => self.force.clone(),
            _ => of.pick(self.oracle, &self.jacobian, self.multipliers.clone()),
        }
    }

    /// ∂F/∂X, all columns.
    pub(crate) fn dfdx(&self) -> Result<Columns, Singular> {
        self.along_pose(&Of::Force)
    }

    fn along_pose(&self, of: &Of) -> Result<Columns, Singular> {
        let (oracle, here) = (self.oracle, self.here(of));
        let mut steps = TwoSteps::default();
        let mut columns = Vec::new();
        for (j, coordinate) in oracle.places.pose.iter().enumerate() {
            let inputs = oracle.moved(&self.inputs, coordinate);
            let values = oracle.source.update(&self.values, &inputs, oracle.pose_bits[j]);
            let force = self.force_at(of, &values, &inputs, Some((j, &mut steps)))?;
            columns.push(quotient(&force, &here, oracle.shift(coordinate)));
        }
        self.columns(columns)
    }

    /// ∂F/∂X along one direction.
    pub(crate) fn dfdx_along(&self, direction: &[f64]) -> Result<Columns, Singular> {
        let oracle = self.oracle;
        let mut inputs = self.inputs.clone();
        for (block, along) in oracle.places.pose.chunks(3).zip(direction.chunks(3)) {
            step(&mut inputs, &block[0], along);
        }
        let all = oracle.pose_bits.iter().fold(0, |all, bit| all | bit);
        let values = oracle.source.update(&self.values, &inputs, all);
        let force = self.force_at(&Of::Force, &values, &inputs, None)?;
        self.columns(vec![quotient(&force, &self.force, 0)])
    }

    /// The second difference of the rows in time, along the motion with constant velocities.
    fn drift(&self) -> Result<Vec<Big>, Singular> {
        let oracle = self.oracle;
        let all = oracle.pose_bits.iter().fold(0, |all, bit| all | bit);
        let after = |sign: f64| {
            let mut inputs = self.inputs.clone();
            for (pose, velocity) in oracle.places.pose.chunks(3).zip(oracle.places.velocity.chunks(3)) {
                let along = velocity.iter().map(|c| sign * self.inputs[c.start + c.axis].to_f64());
                step(&mut inputs, &pose[0], &along.collect::<Vec<f64>>());
            }
            let values = oracle.source.update(&self.values, &inputs, all);
            regular(&values)?;
            Ok(oracle.rows(&values))
        };
        let (next, last) = (after(1.0)?, after(-1.0)?);
        let changes = next
            .into_iter()
            .zip(last)
            .zip(&self.rows)
            .map(|((next, last), here)| (next - here.clone()) - (here.clone() - last));
        let drift: Vec<Big> = changes.map(|change| change.scaled(2 * STEP)).collect();
        if all_finite(&drift) { Ok(drift) } else { Err(Singular::Value) }
    }

    /// ∂F/∂V, all columns.
    pub(crate) fn dfdv(&self) -> Result<Columns, Singular> {
        self.along_velocity(&Of::Force)
    }

    fn along_velocity(&self, of: &Of) -> Result<Columns, Singular> {
        let (oracle, here) = (self.oracle, self.here(of));
        let mut columns = Vec::new();
        for (k, coordinate) in oracle.places.velocity.iter().enumerate() {
            let force = match oracle.law {
                Statement::Energy => here.clone(),
                Statement::Force => {
                    let inputs = oracle.moved(&self.inputs, coordinate);
                    let values = oracle.source.update(&self.values, &inputs, oracle.velocity_bits[k]);
                    self.force_at(of, &values, &inputs, None)?
                }
                Statement::Constraint { .. } => {
                    // C and J do not depend on velocities.
                    let inputs = oracle.moved(&self.inputs, coordinate);
                    let velocities = oracle.velocities(&inputs);
                    let (multipliers, activity) =
                        oracle.multipliers(&inputs, &self.rows, &self.jacobian, &velocities);
                    if activity != self.activity {
                        return Err(Singular::Branch);
                    }
                    of.pick(oracle, &self.jacobian, multipliers)
                }
            };
            columns.push(quotient(&force, &here, oracle.shift(coordinate)));
        }
        self.columns(columns)
    }

    /// An output, row by row.
    pub(crate) fn part(&self, part: Part) -> Result<Vec<Big>, Singular> {
        let stepped = |of: &Of| {
            let h = self.extra("step")[0].clone();
            let (along_x, along_v) = (self.along_pose(of)?.by_row(), self.along_velocity(of)?.by_row());
            let pairs = Iterator::zip(along_v.into_iter(), along_x);
            Ok(pairs.map(|(dv, dx)| h.clone() * (dv + h.clone() * dx)).collect())
        };
        Ok(match part {
            Part::Value => self.rows.clone(),
            Part::Rate => {
                let velocities = self.oracle.velocities(&self.inputs);
                self.jacobian.iter().map(|row| inner(row, &velocities)).collect()
            }
            Part::Jacobian => self.jacobian.concat(),
            Part::Drift => self.drift()?,
            Part::Force => self.force.clone(),
            Part::Dfdx => self.dfdx()?.by_row(),
            Part::Dfdv => self.dfdv()?.by_row(),
            Part::Impulse => {
                let (h, velocities) = (self.extra("step"), self.oracle.velocities(&self.inputs));
                let step: Vec<Big> = velocities.iter().map(|v| h[0].clone() * v.clone()).collect();
                let change = self.dfdx()?.times(&step);
                let next = self.force.iter().zip(change).map(|(f, df)| h[0].clone() * (f.clone() + df));
                next.collect()
            }
            Part::Matrix => stepped(&Of::Force)?,
            Part::Multiplier => self.multipliers.clone(),
            Part::MultiplierStep => stepped(&Of::Multipliers)?,
            Part::Held => {
                let rows = self.extra("multipliers").iter().zip(&self.multipliers).zip(&self.activity);
                // An inactive row has multiplier zero.
                let more = rows.map(|((given, own), side)| match side {
                    Ordering::Less => given.clone() - own.clone(),
                    _ => Big::zero(),
                });
                stepped(&Of::Held(more.collect()))?
            }
            Part::Pull => self.here(&Of::Pull(self.extra("multipliers").to_vec())),
            Part::Geometric => self.along_pose(&Of::Pull(self.extra("multipliers").to_vec()))?.by_row(),
            Part::DfdxProduct => self.dfdx()?.times(self.extra("direction")),
            Part::DfdvProduct => self.dfdv()?.times(self.extra("direction")),
            Part::List(_) | Part::Block(_) => unreachable!("a program computes results, not their pieces"),
        })
    }

    /// The entries of an extra argument.
    fn extra(&self, name: &str) -> &[Big] {
        let places = self.oracle.places;
        let slot =
            places.signature.extra_slot(name, 0).expect("an output that needs this argument was requested");
        let length = places.signature.parameter(slot).map_or(0, |extra| extra.ty.length() as usize);
        &self.inputs[places.place(slot)..][..length]
    }

    fn columns(&self, columns: Vec<Vec<Big>>) -> Result<Columns, Singular> {
        if columns.iter().all(|column| all_finite(column)) {
            Ok(Columns { columns, noise: self.noise })
        } else {
            Err(Singular::Value)
        }
    }

    /// The changes under a motion of all bodies along a tangent vector: of the rows, and of ½ Σ ks C² over
    /// the rows that push; for an energy, of E; for a force, its work. Each with the size of its terms.
    pub(crate) fn work(&self, generator: &[Big]) -> Work {
        let sized = |x: &[Big], y: &[Big]| {
            let terms: Vec<f64> = x.iter().zip(y).map(|(a, b)| (a.to_f64() * b.to_f64()).abs()).collect();
            (inner(x, y).to_f64().abs(), terms.iter().sum::<f64>())
        };
        if self.oracle.law == Statement::Force {
            let (change, size) = sized(&self.force, generator);
            return Work { rows: (change, size), elastic: (change, size) };
        }
        let mut rows = (0.0f64, 0.0f64);
        let mut elastic = Big::zero();
        let mut size = 0.0;
        for (r, gradient) in self.jacobian.iter().enumerate() {
            let (change, terms) = sized(gradient, generator);
            rows = (rows.0.max(change), rows.1.max(terms));
            let weight = match self.oracle.law {
                Statement::Constraint { unilateral, .. } => {
                    let (stiffness, _) = self.oracle.gains(&self.inputs, r);
                    let pull = stiffness * self.rows[r].clone();
                    let pushes = self.rows[r].is_negative() && pull.is_negative();
                    if unilateral && !pushes { Big::zero() } else { pull }
                }
                _ => Big::integer(1),
            };
            size += weight.to_f64().abs() * terms;
            elastic = elastic + weight * inner(gradient, generator);
        }
        Work { rows, elastic: (elastic.to_f64().abs(), size) }
    }

    /// The state rotated about the origin by the unit quaternion (u, w).
    pub(crate) fn rotated(&self, u: &[Big; 3], w: &Big) -> Vec<Big> {
        let places = self.oracle.places;
        let mut inputs = self.inputs.clone();
        for block in places.pose.chunks(3).chain(places.velocity.chunks(3)) {
            let Coordinate { role, start, .. } = block[0];
            let field = &mut inputs[start..];
            if role == Role::Orientation {
                let q = [0, 1, 2, 3].map(|k| field[k].clone());
                field.iter_mut().zip(multiply(u, w, &q)).for_each(|(x, turned)| *x = turned);
            } else {
                let v = [0, 1, 2].map(|k| field[k].clone());
                field.iter_mut().zip(source::rotate(u, w, v)).for_each(|(x, turned)| *x = turned);
            }
        }
        inputs
    }
}
