//! The reference evaluation of a scalar program.
//!
//! In: a program and the values of its arguments. Out: every output. Any [`Number`] works: doubles for tests,
//! higher precision or error bounds for the verifier. Live nodes are evaluated once, operands before users.

use crate::math::exact::Exact;
use crate::math::functions::Operator;
use crate::math::number::{Number, power};
use crate::model::bodies::Slot;
use crate::model::outputs::{self, Array, Part};
use crate::scalar::{Graph, Id, Node, Program};

/// The outputs of a kernel, in the order of storage.
#[derive(Clone, PartialEq, Debug)]
pub struct Outputs<N>(pub Vec<Array<N>>);

impl<N> Outputs<N> {
    /// All entries, output by output and row by row.
    pub fn iter(&self) -> impl Iterator<Item = &N> {
        self.0.iter().flat_map(|array| &array.entries)
    }

    /// Entries of an output, row by row; empty if it is not computed.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn part(&self, part: Part) -> &[N] {
        outputs::entries(&self.0, part)
    }
}

/// The value of a node or an expression.
#[derive(Clone, Debug)]
pub(crate) enum Value<N> {
    Real(N),
    Truth(bool),
}

impl<N: Clone> Value<N> {
    /// The number. Panics on a truth value: the graph is typed by construction.
    pub(crate) fn real(&self) -> N {
        match self {
            Value::Real(x) => x.clone(),
            Value::Truth(_) => panic!("expected a number, found a truth"),
        }
    }

    /// The truth value. Panics on a number.
    pub(crate) fn truth(&self) -> bool {
        match self {
            Value::Truth(x) => *x,
            Value::Real(_) => panic!("expected a truth, found a number"),
        }
    }
}

/// The value of every node of a graph.
pub(crate) fn values<N: Number>(graph: &Graph, inputs: &dyn Fn(Slot) -> N) -> Vec<Value<N>> {
    let mut values: Vec<Value<N>> = Vec::with_capacity(graph.len());
    for (_, node) in graph.iter() {
        values.push(value(node, &values, inputs));
    }
    values
}

/// Evaluates every output of a program for these arguments.
pub fn evaluate<N: Number>(program: &Program, inputs: &dyn Fn(Slot) -> N) -> Outputs<N> {
    let live = program.live();
    let mut values: Vec<Value<N>> = Vec::with_capacity(live.len());
    for (id, node) in program.graph.iter() {
        let dead = Value::Truth(false);
        values.push(if live[id.index()] { value(node, &values, inputs) } else { dead });
    }
    let at = |id: &Id| values[id.index()].real();
    let array = |array: &Array<Id>| Array {
        part: array.part,
        columns: array.columns,
        entries: array.entries.iter().map(at).collect(),
    };
    Outputs(program.arrays.iter().map(array).collect())
}

fn value<N: Number>(node: &Node, values: &[Value<N>], inputs: &dyn Fn(Slot) -> N) -> Value<N> {
    let real = |id: &Id| values[id.index()].real();
    let truth = |id: &Id| values[id.index()].truth();
    Value::Real(match node {
        Node::Constant(value) => N::exact(value),
        Node::Input(slot) => inputs(*slot),
        Node::Difference(first, second) => inputs(*first) - inputs(*second),
        Node::Offset(slot, number) => inputs(*slot) + N::exact(number),
        Node::Sum(constant, terms) => {
            let mut sum = (!constant.is_zero()).then(|| N::exact(constant));
            for (coefficient, id) in terms {
                let x = real(id);
                let term = if coefficient.is_one() { x } else { N::exact(coefficient) * x };
                sum = Some(match sum {
                    Some(sum) => sum + term,
                    None => term,
                });
            }
            sum.unwrap_or_else(|| N::exact(constant))
        }
        Node::Product(factors) => {
            let powers = factors.iter().map(|(id, exponent)| power(real(id), *exponent));
            powers.reduce(|product, x| product * x).unwrap_or_else(|| N::exact(&Exact::ONE))
        }
        Node::Multiple(c, x) => N::exact(c) * real(x),
        Node::Held(x) => real(x),
        Node::Written(operator, x, y) => match operator {
            Operator::Add => real(x) + real(y),
            Operator::Subtract => real(x) - real(y),
            Operator::Multiply => real(x) * real(y),
            Operator::Divide => real(x) / real(y),
        },
        Node::Recip(x) => N::exact(&Exact::ONE) / real(x),
        Node::Call(function, arguments) => {
            N::call(*function, &arguments.iter().map(real).collect::<Vec<_>>())
        }
        Node::Select(condition, x, y) => real(if truth(condition) { x } else { y }),
        Node::Known(value) => return Value::Truth(*value),
        Node::Compare(comparison, x, y) => return Value::Truth(N::holds(*comparison, &real(x), &real(y))),
        Node::And(a, b) => return Value::Truth(truth(a) && truth(b)),
        Node::Or(a, b) => return Value::Truth(truth(a) || truth(b)),
        Node::Not(a) => return Value::Truth(!truth(a)),
    })
}
