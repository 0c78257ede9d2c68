//! The values of a function in the author's order of operations, for mode `strict`.
//!
//! In: a definition in a graph that simplifies nothing. Out: its rows of C, its E or its forces on the scalar
//! graph, one node per operation. Promise: the operations are those that rustc generates from the source with
//! nalgebra, in the same order: no factor moves, no sum is regrouped, every quotient is a division.

use crate::math::exact::Exact;
use crate::math::functions::{Function, Operator};
use crate::model::bodies::{Role, Signature, Slot};
use crate::scalar::{Graph, Id};
use crate::vector::definition::{Definition, Law, Row};
use crate::vector::{Node, Real, Vector};

#[derive(Clone, Copy)]
enum Value {
    Real(Id),
    Vector([Id; 3]),
}

/// The rows of C, the single value E, or the entries of F block by block.
pub(crate) fn rows(graph: &mut Graph, definition: &Definition) -> Vec<Id> {
    let vectors = &definition.graph;
    let mut roots: Vec<usize> = Vec::new();
    match &definition.law {
        Law::Constraint { rows, .. } => roots.extend(rows.iter().map(|row| match row {
            Row::Real(x) => x.index(),
            Row::Vector(v) => v.index(),
        })),
        Law::Energy(energy) => roots.push(energy.index()),
        Law::Force(forces) => {
            let blocks = vectors.signature.pose_blocks().into_iter();
            roots.extend(blocks.map(|block| {
                let force = &forces[usize::from(block.body)];
                let torque = force.torque.filter(|_| block.role == Role::Orientation);
                torque.unwrap_or(force.force).index()
            }));
        }
    }
    let mut live = vec![false; vectors.len()];
    roots.iter().for_each(|root| live[*root] = true);
    for index in (0..live.len()).rev() {
        if live[index] {
            vectors.node(index).operands().into_iter().for_each(|operand| live[operand as usize] = true);
        }
    }
    let mut writer = Writer { graph, signature: &vectors.signature, values: vec![None; live.len()] };
    for index in (0..live.len()).filter(|index| live[*index]) {
        let value = writer.value(vectors.node(index));
        writer.values[index] = Some(value);
    }
    let entries = |root: &usize| match writer.values[*root] {
        Some(Value::Real(id)) => vec![id],
        Some(Value::Vector(entries)) => entries.to_vec(),
        None => unreachable!("operands come before users"),
    };
    roots.iter().flat_map(entries).collect()
}

struct Writer<'g> {
    graph: &'g mut Graph,
    signature: &'g Signature,
    values: Vec<Option<Value>>,
}

impl Writer<'_> {
    fn real(&self, x: Real) -> Id {
        self.id(x.0)
    }

    /// The scalar of a real or a boolean.
    fn id(&self, index: u32) -> Id {
        match self.values[index as usize] {
            Some(Value::Real(id)) => id,
            _ => unreachable!("a real is one scalar"),
        }
    }

    fn vector(&self, v: Vector) -> [Id; 3] {
        match self.values[v.index()] {
            Some(Value::Vector(entries)) => entries,
            _ => unreachable!("a vector is three scalars"),
        }
    }

    fn add(&mut self, x: Id, y: Id) -> Id {
        self.graph.written(Operator::Add, x, y)
    }

    fn sub(&mut self, x: Id, y: Id) -> Id {
        self.graph.written(Operator::Subtract, x, y)
    }

    fn mul(&mut self, x: Id, y: Id) -> Id {
        self.graph.written(Operator::Multiply, x, y)
    }

    fn div(&mut self, x: Id, y: Id) -> Id {
        self.graph.written(Operator::Divide, x, y)
    }

    fn input(&mut self, slot: Slot) -> Id {
        match self.signature.folded(slot) {
            Some(value) => self.graph.constant(value),
            None => self.graph.input(slot),
        }
    }

    /// c x
    fn times(&mut self, c: &Exact, x: Id) -> Id {
        if c.is_unit() {
            return self.graph.scaled(c.clone(), x);
        }
        let number = self.graph.constant(c.clone());
        self.mul(number, x)
    }

    /// Σ coefficient · term, from the left; negative terms are subtracted.
    fn sum(&mut self, constant: &Exact, terms: &[(Exact, Id)]) -> Id {
        let mut sum =
            (!constant.is_zero() || terms.is_empty()).then(|| self.graph.constant(constant.clone()));
        for (c, x) in terms {
            let size = self.times(&c.abs(), *x);
            sum = Some(match (sum, c.is_negative()) {
                (None, false) => size,
                (None, true) => self.graph.neg(size),
                (Some(sum), false) => self.add(sum, size),
                (Some(sum), true) => self.sub(sum, size),
            });
        }
        sum.expect("an empty sum is a number")
    }

    /// xⁿ by repeated squaring from the lowest bit on, like `powi`.
    fn power(&mut self, x: Id, n: i32) -> Id {
        let mut product = None;
        let (mut square, mut rest) = (x, n.unsigned_abs());
        while rest > 0 {
            if rest % 2 == 1 {
                product = Some(product.map_or(square, |product| self.mul(product, square)));
            }
            rest /= 2;
            if rest > 0 {
                square = self.mul(square, square);
            }
        }
        let one = self.graph.one();
        let product = product.unwrap_or(one);
        if n < 0 { self.div(one, product) } else { product }
    }

    fn dot(&mut self, u: [Id; 3], v: [Id; 3]) -> Id {
        let [x, y, z] = [0, 1, 2].map(|k| self.mul(u[k], v[k]));
        let sum = self.add(x, y);
        self.add(sum, z)
    }

    fn cross(&mut self, u: [Id; 3], v: [Id; 3]) -> [Id; 3] {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
            let (first, second) = (self.mul(u[i], v[j]), self.mul(u[j], v[i]));
            self.sub(first, second)
        })
    }

    fn value(&mut self, node: &Node) -> Value {
        match node {
            Node::Triple(slot) => {
                Value::Vector([0, 1, 2].map(|k| self.input(Slot { offset: slot.offset + k, ..*slot })))
            }
            Node::VectorSum(terms) => Value::Vector([0, 1, 2].map(|k| {
                let terms: Vec<(Exact, Id)> =
                    terms.iter().map(|(c, v)| (c.clone(), self.vector(*v)[k])).collect();
                self.sum(&Exact::ZERO, &terms)
            })),
            Node::Scale(s, v) => {
                let s = self.real(*s);
                Value::Vector(self.vector(*v).map(|x| self.mul(s, x)))
            }
            Node::Cross(u, v) => Value::Vector(self.cross(self.vector(*u), self.vector(*v))),
            // ((2 u×v) w + u×(2 u×v)) + v
            Node::Rotate(quaternion, inverse, v) => {
                let [x, y, z, w] =
                    [0, 1, 2, 3].map(|k| self.input(Slot { offset: quaternion.offset + k, ..*quaternion }));
                let u = if *inverse { [x, y, z].map(|entry| self.graph.neg(entry)) } else { [x, y, z] };
                let v = self.vector(*v);
                let two = self.graph.constant(Exact::from(2));
                let turned = self.cross(u, v).map(|entry| self.mul(entry, two));
                let across = self.cross(u, turned);
                Value::Vector([0, 1, 2].map(|k| {
                    let along = self.mul(turned[k], w);
                    let sum = self.add(along, across[k]);
                    self.add(sum, v[k])
                }))
            }
            Node::Pack(entries) => Value::Vector(entries.map(|x| self.real(x))),
            Node::VectorSelect(condition, u, v) => {
                let condition = self.id(condition.0);
                let (u, v) = (self.vector(*u), self.vector(*v));
                Value::Vector([0, 1, 2].map(|k| self.graph.select(condition, u[k], v[k])))
            }
            Node::VectorLet(v) => Value::Vector(self.vector(*v)),
            node => Value::Real(self.real_of(node)),
        }
    }

    fn real_of(&mut self, node: &Node) -> Id {
        match node {
            Node::Constant(value) => self.graph.constant(value.clone()),
            Node::Entry(slot) => self.input(*slot),
            Node::Sum(constant, terms) => {
                let terms: Vec<(Exact, Id)> = terms.iter().map(|(c, x)| (c.clone(), self.real(*x))).collect();
                self.sum(constant, &terms)
            }
            Node::Product(factors) => {
                let mut product = None;
                for (x, n) in factors {
                    let x = self.real(*x);
                    product = Some(match (product, *n) {
                        (Some(product), -1) => self.div(product, x),
                        (Some(product), n) => {
                            let power = self.power(x, n);
                            self.mul(product, power)
                        }
                        (None, n) => self.power(x, n),
                    });
                }
                product.unwrap_or_else(|| self.graph.one())
            }
            Node::Dot(u, v) => self.dot(self.vector(*u), self.vector(*v)),
            Node::Component(v, axis) => self.vector(*v)[usize::from(*axis)],
            Node::Norm(v) => {
                let square = self.dot(self.vector(*v), self.vector(*v));
                self.graph.call(Function::Sqrt, &[square])
            }
            Node::Call(function, arguments) => {
                let arguments: Vec<Id> = arguments.iter().map(|x| self.real(*x)).collect();
                self.graph.call(*function, &arguments)
            }
            Node::Select(condition, x, y) => {
                let condition = self.id(condition.0);
                self.graph.select(condition, self.real(*x), self.real(*y))
            }
            Node::Let(x) => self.real(*x),
            Node::Known(value) => self.graph.known(*value),
            Node::Compare(comparison, x, y) => {
                let (x, y) = (self.real(*x), self.real(*y));
                self.graph.compare(*comparison, x, y)
            }
            Node::And(a, b) => self.graph.and(self.id(a.0), self.id(b.0)),
            Node::Or(a, b) => self.graph.or(self.id(a.0), self.id(b.0)),
            Node::Not(a) => self.graph.not(self.id(a.0)),
            other => unreachable!("{other:?} is not in a graph that simplifies nothing"),
        }
    }
}
