//! Reverse-mode gradients Σ adjoint · D(node) of several nodes at once.
//!
//! In: nodes with their adjoints, reals for reals and vectors for vectors. Out: for every variable reached,
//! the vector that multiplies its tangent. At a branch the gradient is formed forward, so that nothing from
//! the untaken side, not even a NaN, reaches the result.

use crate::derive::forward::{RotatedArm, TangentDerivatives, Variable, partial_of_product};
use crate::derive::partials::partial;
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::{Role, Slot};
use crate::vector::{Graph, Node, Real, Vector};
use std::collections::{BTreeMap, BTreeSet};

/// Accumulated adjoints by node.
#[derive(Default)]
struct Adjoints {
    reals: BTreeMap<u32, Vec<(Exact, Real)>>,
    vectors: BTreeMap<u32, Vec<(Exact, Vector)>>,
    variables: BTreeMap<Variable, Vec<(Exact, Vector)>>,
}

impl Adjoints {
    fn real(&mut self, node: Real, adjoint: Real) {
        self.reals.entry(node.0).or_default().push((Exact::ONE, adjoint));
    }

    fn vector(&mut self, node: Vector, adjoint: Vector) {
        self.vectors.entry(node.0).or_default().push((Exact::ONE, adjoint));
    }

    fn variable(&mut self, variable: Variable, coefficient: Exact, adjoint: Vector) {
        self.variables.entry(variable).or_default().push((coefficient, adjoint));
    }

    /// The last node with pending adjoints; all its users are done.
    fn last(&self) -> Option<u32> {
        let real = self.reals.last_key_value().map(|(k, _)| *k);
        let vector = self.vectors.last_key_value().map(|(k, _)| *k);
        real.max(vector)
    }
}

/// The gradient of Σ adjoint · real + Σ adjoint · vector; `variables` are those that branches depend on.
pub fn gradient(
    tangent: &mut TangentDerivatives,
    reals: &[(Real, Real)],
    vectors: &[(Vector, Vector)],
    variables: &[Variable],
) -> BTreeMap<Variable, Vector> {
    let mut adjoints = Adjoints::default();
    for &(node, adjoint) in reals {
        adjoints.real(node, adjoint);
    }
    for &(node, adjoint) in vectors {
        adjoints.vector(node, adjoint);
    }
    while let Some(index) = adjoints.last() {
        tangent.step();
        if let Some(terms) = adjoints.reals.remove(&index) {
            let adjoint = tangent.graph.sum(Exact::ZERO, terms);
            if !tangent.graph.is_zero(adjoint) {
                propagate_real(tangent, &mut adjoints, Real(index), adjoint, variables);
            }
        } else if let Some(terms) = adjoints.vectors.remove(&index) {
            let adjoint = tangent.graph.vector_sum(terms);
            if !tangent.graph.is_zero_vector(adjoint) {
                propagate_vector(tangent, &mut adjoints, Vector(index), adjoint, variables);
            }
        }
    }
    let variables = adjoints.variables;
    variables.into_iter().map(|(variable, terms)| (variable, tangent.graph.vector_sum(terms))).collect()
}

fn propagate_real(
    tangent: &mut TangentDerivatives,
    adjoints: &mut Adjoints,
    node: Real,
    adjoint: Real,
    variables: &[Variable],
) {
    if let Some(&other) = tangent.substituted.get(&node.0) {
        return adjoints.real(Real(other), adjoint);
    }
    let index = node.index();
    match tangent.graph.node(index).clone() {
        Node::Entry(slot) => {
            let base = Slot { offset: 0, ..slot };
            let variable = match tangent.graph.signature.role(slot) {
                Some(Role::Orientation) => Variable::Rotation(base),
                Some(_) => Variable::Triple(base),
                None => return,
            };
            let row = tangent.row(node, variable);
            let moved = tangent.graph.scale(adjoint, row);
            adjoints.variable(variable, Exact::ONE, moved);
        }
        Node::Sum(_, terms) => {
            for (c, x) in terms {
                let share = tangent.graph.scaled(c, adjoint);
                adjoints.real(x, share);
            }
        }
        Node::Product(factors) => {
            for (k, &(factor, exponent)) in factors.iter().enumerate() {
                let partial = partial_of_product(&mut tangent.graph, &factors, k);
                let share = tangent.graph.mul(adjoint, partial);
                let share = tangent.graph.scaled(Exact::from(i64::from(exponent)), share);
                adjoints.real(factor, share);
            }
        }
        Node::Dot(u, v) => {
            let (on_u, on_v) = (tangent.graph.scale(adjoint, v), tangent.graph.scale(adjoint, u));
            adjoints.vector(u, on_u);
            adjoints.vector(v, on_v);
        }
        Node::Component(v, axis) => {
            let basis = tangent.graph.basis(axis);
            let share = tangent.graph.scale(adjoint, basis);
            adjoints.vector(v, share);
        }
        Node::Norm(v) => {
            let unit = tangent.graph.normalize(v);
            let share = tangent.graph.scale(adjoint, unit);
            adjoints.vector(v, share);
        }
        Node::Select(..) | Node::Call(Function::Min | Function::Max, _) => {
            for &variable in variables {
                let row = tangent.row(node, variable);
                let moved = tangent.graph.scale(adjoint, row);
                adjoints.variable(variable, Exact::ONE, moved);
            }
        }
        Node::TurnReal(turn) => {
            let (u, _) = tangent.graph.turn(&turn);
            let moved = tangent.graph.scale(adjoint, u);
            turn_adjoint(tangent, adjoints, &turn, -Exact::ONE, |_, _| moved);
        }
        Node::Call(function, arguments) => {
            for (k, &argument) in arguments.iter().enumerate() {
                let partial = partial(&mut tangent.graph, function, &arguments, node, k);
                let share = tangent.graph.mul(adjoint, partial);
                adjoints.real(argument, share);
            }
        }
        Node::Offset(x, _) => adjoints.real(x, adjoint),
        Node::Let(x) => {
            let name = format!("adjoint_{}", tangent.graph.name(index).unwrap_or("value"));
            let held = tangent.graph.let_real(&name, adjoint);
            adjoints.real(x, held);
        }
        _ => {}
    }
}

fn propagate_vector(
    tangent: &mut TangentDerivatives,
    adjoints: &mut Adjoints,
    node: Vector,
    adjoint: Vector,
    variables: &[Variable],
) {
    if let Some(&other) = tangent.substituted.get(&node.0) {
        return adjoints.vector(Vector(other), adjoint);
    }
    let index = node.index();
    match tangent.graph.node(index).clone() {
        Node::Triple(slot) => match tangent.graph.signature.role(slot) {
            Some(Role::Orientation) => {
                let variable = Variable::Rotation(slot);
                let moved = transpose_times(tangent, node, variable, adjoint);
                adjoints.variable(variable, Exact::ONE, moved);
            }
            Some(_) => adjoints.variable(Variable::Triple(slot), Exact::ONE, adjoint),
            None => {}
        },
        Node::Difference(first, second) => {
            if tangent.difference_variables.contains(&(first, second)) {
                adjoints.variable(Variable::Difference(first, second), Exact::ONE, adjoint);
                return;
            }
            for (slot, sign) in [(first, Exact::ONE), (second, -Exact::ONE)] {
                if tangent.graph.signature.role(slot).is_some() {
                    adjoints.variable(Variable::Triple(slot), sign, adjoint);
                }
            }
        }
        Node::VectorOffset(v, _) => adjoints.vector(v, adjoint),
        Node::VectorSum(terms) => {
            for (c, v) in terms {
                let share = tangent.graph.vector_sum(vec![(c, adjoint)]);
                adjoints.vector(v, share);
            }
        }
        Node::Scale(s, v) => {
            let on_s = tangent.graph.dot(adjoint, v);
            let on_v = tangent.graph.scale(s, adjoint);
            adjoints.real(s, on_s);
            adjoints.vector(v, on_v);
        }
        Node::Cross(u, v) => {
            let on_u = tangent.graph.cross(v, adjoint);
            let on_v = tangent.graph.cross(adjoint, u);
            adjoints.vector(u, on_u);
            adjoints.vector(v, on_v);
        }
        Node::Rotate(quaternion, inverse, v) => {
            let g = &mut tangent.graph;
            let back = g.rotate(quaternion, !inverse, adjoint);
            if g.signature.role(quaternion).is_some() {
                // p·D(R v) = (R v × p)·δθ,  p·D(Rᵀ v) = (R p × v)·δθ
                let torque = if inverse {
                    g.cross(back, v)
                } else {
                    let rotated = g.rotate(quaternion, false, v);
                    cross_terms(g, rotated, adjoint)
                };
                adjoints.variable(Variable::Rotation(quaternion), Exact::ONE, torque);
            }
            adjoints.vector(v, back);
        }
        Node::TurnVector(turn) => {
            let (u, w) = tangent.graph.turn(&turn);
            turn_adjoint(tangent, adjoints, &turn, Exact::ONE, |g, turned| {
                turned.transposed(g, adjoint, u, w)
            });
        }
        Node::Pack(entries) => {
            for (axis, x) in entries.into_iter().enumerate() {
                let share = tangent.graph.component(adjoint, axis as u8);
                adjoints.real(x, share);
            }
        }
        Node::VectorSelect(..) => {
            for &variable in variables {
                let moved = transpose_times(tangent, node, variable, adjoint);
                adjoints.variable(variable, Exact::ONE, moved);
            }
        }
        Node::VectorLet(v) => {
            if tangent.graph.formulation.backward || matches!(tangent.graph.node(v.index()), Node::Rotate(..))
            {
                // No let for the adjoint of an arm, so that its only cross product simplifies.
                adjoints.vector(v, adjoint);
                return;
            }
            let name = format!("adjoint_{}", tangent.graph.name(index).unwrap_or("value"));
            let held = tangent.graph.let_vector(&name, adjoint);
            adjoints.vector(v, held);
        }
        _ => {}
    }
}

/// u × v; in forward formulations term by term for a sum v of scaled vectors, as for the other body.
fn cross_terms(g: &mut Graph, u: Vector, v: Vector) -> Vector {
    match g.node(v.index()).clone() {
        Node::VectorSum(terms)
            if !g.formulation.backward
                && terms.iter().all(|(_, t)| matches!(g.node(t.index()), Node::Scale(..))) =>
        {
            let terms = terms.iter().map(|(c, term)| (c.clone(), g.cross(u, *term))).collect();
            g.vector_sum(terms)
        }
        _ => g.cross(u, v),
    }
}

/// Adds the torque R⁻¹ `moved` for every factor of a product of quaternions that turns with a body.
fn turn_adjoint(
    tangent: &mut TangentDerivatives,
    adjoints: &mut Adjoints,
    turn: &[(Slot, bool)],
    sign: Exact,
    moved: impl Fn(&mut Graph, &RotatedArm) -> Vector,
) {
    let slots: BTreeSet<Slot> = turn.iter().map(|(slot, _)| *slot).collect();
    for slot in slots {
        if tangent.graph.signature.role(slot).is_none() {
            continue;
        }
        let variable = Variable::Rotation(slot);
        for turned in RotatedArm::places(turn, variable) {
            let moved = moved(&mut tangent.graph, &turned);
            let torque = turned.unrotate(&mut tangent.graph, moved);
            adjoints.variable(variable, &sign * &turned.coefficient, torque);
        }
    }
}

/// (D v)ᵀ x
fn transpose_times(tangent: &mut TangentDerivatives, v: Vector, variable: Variable, x: Vector) -> Vector {
    let matrix = tangent.matrix(v, variable);
    matrix.transpose_times(&mut tangent.graph, x)
}
