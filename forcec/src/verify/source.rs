//! Evaluates a vector graph node by node, as written, in any number type.
//!
//! In: a graph, the wanted nodes and a value for every slot. Out: the value of each node. A point that
//! differs from an evaluated point in a few arguments recomputes only the dependent nodes, and reports
//! whether a condition, or the side of a `min`, `max`, `abs` or `signum`, changed.

use crate::math::exact::Exact;
use crate::math::functions::{Function, FunctionDomain};
use crate::math::number::{Comparison, Number, power};
use crate::model::bodies::Slot;
use crate::sample::inputs::Places;
use crate::vector::{Graph, Node, Real};
use std::cmp::Ordering;

/// The value of a node.
#[derive(Clone, Debug)]
pub(crate) enum Value<N> {
    Real(N),
    Vector([N; 3]),
    Truth(bool),
}

impl<N> Value<N> {
    /// The number. Panics for other types, which a typed graph excludes.
    pub(crate) fn real(&self) -> &N {
        match self {
            Value::Real(x) => x,
            _ => panic!("the graph expects a real"),
        }
    }

    /// The vector. Panics for other types.
    pub(crate) fn vector(&self) -> &[N; 3] {
        match self {
            Value::Vector(v) => v,
            _ => panic!("the graph expects a vector"),
        }
    }

    pub(crate) fn truth(&self) -> bool {
        match self {
            Value::Truth(truth) => *truth,
            _ => panic!("the graph expects a truth"),
        }
    }
}

/// A set of arguments, with one bit per body field; fields share bits if there are more than 128.
pub(crate) type Fields = u128;

/// The bit of the field that contains a slot.
pub(crate) fn field_bit(layout: &Places, slot: Slot) -> Fields {
    let first = Slot { offset: 0, ..slot };
    1 << (layout.place(first) % 128)
}

struct Step<'g, N> {
    node: &'g Node,
    /// The index of the node in the graph.
    index: usize,
    depends: Fields,
    /// The constants of the node, converted to N, in order.
    numbers: Vec<N>,
}

/// The wanted part of a graph, prepared for evaluation.
pub(crate) struct Source<'g, N> {
    layout: &'g Places,
    steps: Vec<Step<'g, N>>,
    /// The steps of the wanted nodes.
    wanted: Vec<usize>,
    /// The step of each node of the graph.
    places: Vec<usize>,
}

/// The values of a source at a point; values that are not recomputed come from the point before.
pub(crate) struct Values<'p, N> {
    before: Option<&'p Values<'p, N>>,
    own: Vec<Option<Value<N>>>,
    /// Whether some choice differs from the choice at the point before.
    pub(crate) crossed: bool,
    /// The contributing steps at the edge of their function's smooth domain; untaken arms do not contribute.
    edges: Vec<usize>,
    /// Whether an argument of such a step changed.
    pub(crate) at_edge: bool,
}

impl<N> Values<'_, N> {
    fn at(&self, step: usize) -> &Value<N> {
        match (&self.own[step], self.before) {
            (Some(value), _) => value,
            (None, Some(before)) => before.at(step),
            (None, None) => panic!("operands come before users"),
        }
    }

    /// Whether some step has no derivative unless its arguments are constant.
    pub(crate) fn has_edges(&self) -> bool {
        !self.edges.is_empty()
    }

    /// The values computed at this point.
    pub(crate) fn own(&self) -> impl Iterator<Item = &Value<N>> {
        self.own.iter().flatten()
    }
}

fn slots(node: &Node) -> Vec<Slot> {
    match node {
        Node::Entry(slot) | Node::Triple(slot) | Node::Rotate(slot, ..) => vec![*slot],
        Node::Difference(first, second) => vec![*first, *second],
        Node::TurnReal(turn) | Node::TurnVector(turn) => turn.iter().map(|(slot, _)| *slot).collect(),
        _ => vec![],
    }
}

impl<'g, N: Number> Source<'g, N> {
    /// The part of a graph that the wanted nodes depend on.
    pub(crate) fn new(graph: &'g Graph, layout: &'g Places, wanted: impl IntoIterator<Item = usize>) -> Self {
        let wanted: Vec<usize> = wanted.into_iter().collect();
        let mut live = vec![false; graph.len()];
        for &index in &wanted {
            live[index] = true;
        }
        for index in (0..graph.len()).rev() {
            if live[index] {
                for operand in graph.node(index).operands().into_iter().map(|o| o as usize) {
                    live[operand] = true;
                }
            }
        }
        let mut steps: Vec<Step<N>> = Vec::new();
        let mut places = vec![usize::MAX; graph.len()];
        for (index, node) in graph.nodes().enumerate().filter(|(index, _)| live[*index]) {
            let through = node.operands().into_iter().map(|operand| steps[places[operand as usize]].depends);
            let direct = slots(node).into_iter().map(|slot| field_bit(layout, slot));
            let depends = through.chain(direct).fold(0, |all, fields| all | fields);
            let numbers = match node {
                Node::Constant(value) | Node::Offset(_, value) => vec![N::exact(value)],
                Node::VectorOffset(_, numbers) => numbers.iter().map(N::exact).collect(),
                Node::Sum(constant, terms) => {
                    std::iter::once(constant).chain(terms.iter().map(|(c, _)| c)).map(N::exact).collect()
                }
                Node::VectorSum(terms) => terms.iter().map(|(c, _)| N::exact(c)).collect(),
                _ => vec![],
            };
            places[index] = steps.len();
            steps.push(Step { node, index, depends, numbers });
        }
        let wanted = wanted.into_iter().map(|node| places[node]).collect();
        Source { layout, steps, wanted, places }
    }

    /// The approximate cost of one evaluation, in 320-bit additions.
    pub(crate) fn cost(&self) -> u64 {
        let cost = |node: &Node| match node {
            Node::Sum(_, terms) => 2 * terms.len() as u64,
            Node::Product(factors) => factors.iter().map(|(_, n)| 2 + u64::from(n.unsigned_abs() / 2)).sum(),
            Node::Dot(..) => 6,
            Node::VectorSum(terms) => 3 * terms.len() as u64,
            Node::Scale(..) => 4,
            Node::Cross(..) => 10,
            Node::Rotate(..) => 36,
            Node::Norm(_) | Node::Call(Function::Sqrt | Function::Hypot, _) => 100,
            Node::Call(Function::Abs | Function::Min | Function::Max | Function::Signum, _) => 1,
            Node::Call(..) => 800,
            _ => 1,
        };
        self.steps.iter().map(|step| cost(step.node)).sum()
    }

    /// The nodes with their indices in the graph, operands before users.
    pub(crate) fn nodes(&self) -> impl DoubleEndedIterator<Item = (usize, &'g Node)> {
        self.steps.iter().map(|step| (step.index, step.node))
    }

    /// The arguments that a node depends on.
    pub(crate) fn depends(&self, node: usize) -> Fields {
        self.steps[self.places[node]].depends
    }

    /// The branches that contribute to the values of some nodes, each with its side: a selection by its
    /// condition, with the condition's value; other branching nodes by themselves, with whether the argument
    /// is negative or the first argument is returned. Conditions do not contribute to values.
    pub(crate) fn branches(
        &self,
        values: &Values<N>,
        roots: impl IntoIterator<Item = usize>,
    ) -> Vec<(usize, bool)> {
        let mut reached = vec![false; self.steps.len()];
        for root in roots {
            reached[self.places[root]] = true;
        }
        let mut branches = Vec::new();
        for at in (0..self.steps.len()).rev().filter(|at| self.steps[*at].node.is_value()) {
            if !reached[at] {
                continue;
            }
            let Step { node, index, .. } = &self.steps[at];
            let mut reach = |operand: usize| reached[self.places[operand]] = true;
            match node {
                Node::Select(c, x, y) => {
                    let holds = self.get(values, c.index()).truth();
                    branches.push((c.index(), holds));
                    reach(if holds { x.index() } else { y.index() });
                }
                Node::VectorSelect(c, u, v) => {
                    let holds = self.get(values, c.index()).truth();
                    branches.push((c.index(), holds));
                    reach(if holds { u.index() } else { v.index() });
                }
                Node::Call(Function::Min | Function::Max, x) => {
                    let first = self.first(node, values);
                    branches.push((*index, first));
                    reach(x[usize::from(!first)].index());
                }
                _ => {
                    if node.branches() {
                        branches.push((*index, self.side(node, values) == Some(Ordering::Less)));
                    }
                    node.operands().into_iter().for_each(|operand| reach(operand as usize));
                }
            }
        }
        branches.sort_unstable();
        branches.dedup();
        branches
    }

    /// Whether `min` or `max` returns its first argument.
    fn first(&self, node: &Node, values: &Values<N>) -> bool {
        let wanted =
            if matches!(node, Node::Call(Function::Max, _)) { Ordering::Greater } else { Ordering::Less };
        self.side(node, values) == Some(wanted)
    }

    /// The value of a node at a point.
    pub(crate) fn get<'v>(&self, values: &'v Values<'_, N>, node: usize) -> &'v Value<N> {
        values.at(self.places[node])
    }

    /// All values at a point.
    pub(crate) fn evaluate(&self, point: &[N]) -> Values<'static, N> {
        let mut values = Values {
            before: None,
            own: Vec::with_capacity(self.steps.len()),
            crossed: false,
            edges: Vec::new(),
            at_edge: false,
        };
        for step in &self.steps {
            let value = self.value(step, &values, point);
            values.own.push(Some(value));
        }
        values
    }

    /// Records the contributing steps that have no derivative at this point.
    pub(crate) fn mark_edges(&self, values: &mut Values<N>) {
        let reached = self.reached(values);
        let steps = self.steps.iter().enumerate().filter(|(index, _)| reached[*index]);
        values.edges =
            steps.filter(|(_, step)| self.is_singular(step.node, values)).map(|(index, _)| index).collect();
    }

    /// All values at a point that differs from `before` in the fields `changed`.
    pub(crate) fn update<'p>(
        &self,
        before: &'p Values<'p, N>,
        point: &[N],
        changed: Fields,
    ) -> Values<'p, N> {
        let mut values = Values {
            before: Some(before),
            own: (0..self.steps.len()).map(|_| None).collect(),
            crossed: false,
            edges: before.edges.clone(),
            at_edge: before.at_edge,
        };
        for (index, step) in self.steps.iter().enumerate() {
            if step.depends & changed == 0 {
                continue;
            }
            let value = self.value(step, &values, point);
            values.crossed |= match (&value, before.at(index)) {
                (Value::Truth(now), Value::Truth(then)) => now != then,
                _ => false,
            };
            values.crossed |= self.side(step.node, &values) != self.side(step.node, before);
            values.own[index] = Some(value);
            if values.edges.contains(&index) {
                values.at_edge |= self.arguments_moved(step.node, before, &values);
            }
        }
        values
    }

    /// The steps that contribute to the wanted nodes, without untaken arms.
    fn reached(&self, values: &Values<N>) -> Vec<bool> {
        let mut reached = vec![false; self.steps.len()];
        for step in &self.wanted {
            reached[*step] = true;
        }
        for index in (0..self.steps.len()).rev() {
            if !reached[index] {
                continue;
            }
            let node = self.steps[index].node;
            let arms = match *node {
                Node::Select(c, x, y) => Some((c, x.index(), y.index())),
                Node::VectorSelect(c, u, v) => Some((c, u.index(), v.index())),
                _ => None,
            };
            let untaken = arms
                .filter(|(_, x, y)| x != y)
                .map(|(condition, x, y)| if self.get(values, condition.index()).truth() { y } else { x });
            for operand in node.operands().into_iter().map(|operand| operand as usize) {
                if Some(operand) != untaken {
                    reached[self.places[operand]] = true;
                }
            }
        }
        reached
    }

    fn arguments_moved(&self, node: &Node, before: &Values<N>, after: &Values<N>) -> bool {
        let same = |x: &N, y: &N| N::holds(Comparison::Equal, x, y);
        let mut operands = node.operands().into_iter().map(|operand| operand as usize);
        operands.any(|operand| match (self.get(before, operand), self.get(after, operand)) {
            (Value::Real(x), Value::Real(y)) => !same(x, y),
            (Value::Vector(x), Value::Vector(y)) => !x.iter().zip(y).all(|(x, y)| same(x, y)),
            _ => false,
        })
    }

    /// The side of a comparison or of a function with two branches. `Equal` is a side of its own: derivatives
    /// on both sides differ, and either is right.
    fn side(&self, node: &Node, values: &Values<N>) -> Option<Ordering> {
        let real = |x: Real| self.get(values, x.index()).real();
        let zero;
        let (x, y) = match node {
            Node::Call(Function::Abs | Function::Signum, arguments) => {
                zero = N::exact(&Exact::ZERO);
                (real(arguments[0]), &zero)
            }
            Node::Call(Function::Min | Function::Max, arguments) => (real(arguments[0]), real(arguments[1])),
            Node::Compare(_, x, y) => (real(*x), real(*y)),
            _ => return None,
        };
        let holds = |comparison| N::holds(comparison, x, y);
        match (holds(Comparison::LessEqual), holds(Comparison::Equal)) {
            (true, false) => Some(Ordering::Less),
            (_, true) => Some(Ordering::Equal),
            (false, _) => Some(Ordering::Greater),
        }
    }

    /// Whether a node is at the edge of its differentiable domain.
    fn is_singular(&self, node: &Node, values: &Values<N>) -> bool {
        let zero = N::exact(&Exact::ZERO);
        let above = |x: &N, bound: f64| {
            let bound = Exact::from_f64(bound).unwrap_or(Exact::ZERO);
            N::holds(Comparison::Less, &N::exact(&bound), x)
        };
        let below = |x: &N, bound: f64| {
            let bound = Exact::from_f64(bound).unwrap_or(Exact::ZERO);
            N::holds(Comparison::Less, x, &N::exact(&bound))
        };
        let is_zero = |x: &N| N::holds(Comparison::Equal, x, &zero);
        match node {
            Node::Norm(v) => self.get(values, v.index()).vector().iter().all(is_zero),
            Node::Call(function, arguments) => {
                let x: Vec<&N> = arguments.iter().map(|x| self.get(values, x.index()).real()).collect();
                match function.row().smooth {
                    FunctionDomain::All => false,
                    FunctionDomain::AtLeast(bound) => below(x[0], bound),
                    FunctionDomain::Above(bound) => !above(x[0], bound),
                    FunctionDomain::Unit | FunctionDomain::Inside => {
                        let size = N::call(Function::Abs, &[x[0].clone()]);
                        !N::holds(Comparison::Less, &size, &N::exact(&Exact::ONE))
                    }
                    FunctionDomain::NotAllZero => x.iter().all(|x| is_zero(x)),
                    FunctionDomain::HalfPlane => {
                        N::holds(Comparison::Less, x[0], &zero) || x.iter().all(|x| is_zero(x))
                    }
                }
            }
            _ => false,
        }
    }

    fn value(&self, step: &Step<N>, values: &Values<N>, point: &[N]) -> Value<N> {
        let place = |slot: &Slot| self.layout.place(*slot);
        let triple = |slot: &Slot| [0, 1, 2].map(|axis| point[place(slot) + axis].clone());
        macro_rules! real {
            ($id:expr) => {
                self.get(values, $id.index()).real().clone()
            };
        }
        macro_rules! vector {
            ($id:expr) => {
                self.get(values, $id.index()).vector().clone()
            };
        }
        macro_rules! truth {
            ($id:expr) => {
                self.get(values, $id.index()).truth()
            };
        }
        // (u, w)(v, s) = (w v + s u + u×v, w s − u·v)
        let turned = |turn: &[(Slot, bool)]| {
            let factors = turn.iter().map(|(slot, inverse)| {
                let [x, y, z] = triple(slot);
                let w = point[place(slot) + 3].clone();
                (if *inverse { [-x, -y, -z] } else { [x, y, z] }, w)
            });
            let product = factors.reduce(|(u, w), (v, s)| {
                let vector = add(add(scale(&w, v.clone()), scale(&s, u.clone())), cross(&u, &v));
                (vector, w * s - dot(&u, &v))
            });
            product.expect("a product of quaternions has factors")
        };
        match step.node {
            Node::Constant(_) => Value::Real(step.numbers[0].clone()),
            Node::Entry(slot) => Value::Real(point[place(slot)].clone()),
            Node::Sum(constant, terms) => {
                let mut sum = (!constant.is_zero()).then(|| step.numbers[0].clone());
                for ((c, x), number) in terms.iter().zip(&step.numbers[1..]) {
                    let term = if c.is_one() { real!(x) } else { number.clone() * real!(x) };
                    sum = Some(match sum {
                        Some(sum) => sum + term,
                        None => term,
                    });
                }
                Value::Real(sum.unwrap_or_else(|| step.numbers[0].clone()))
            }
            Node::Product(factors) => {
                let mut product: Option<N> = None;
                for (x, n) in factors {
                    product = Some(match (product, *n) {
                        // x/y is a single division.
                        (Some(product), -1) => product / real!(x),
                        (Some(product), n) => product * powi(real!(x), n),
                        (None, n) => powi(real!(x), n),
                    });
                }
                Value::Real(product.unwrap_or_else(|| N::exact(&Exact::ONE)))
            }
            Node::Dot(u, v) => Value::Real(dot(&vector!(u), &vector!(v))),
            Node::Component(v, axis) => {
                Value::Real(self.get(values, v.index()).vector()[*axis as usize].clone())
            }
            Node::Norm(v) => {
                let v = vector!(v);
                Value::Real(N::call(Function::Sqrt, &[dot(&v, &v)]))
            }
            Node::Call(function, arguments) => {
                let arguments: Vec<N> = arguments.iter().map(|x| real!(x)).collect();
                Value::Real(N::call(*function, &arguments))
            }
            Node::Select(c, x, y) => Value::Real(if truth!(c) { real!(x) } else { real!(y) }),
            Node::Let(x) => Value::Real(real!(x)),
            Node::Offset(x, _) => Value::Real(real!(x) + step.numbers[0].clone()),
            Node::Triple(slot) => Value::Vector(triple(slot)),
            Node::Difference(first, second) => Value::Vector(subtract(triple(first), triple(second))),
            Node::VectorOffset(v, _) => {
                let v = vector!(v);
                Value::Vector([0, 1, 2].map(|k| v[k].clone() + step.numbers[k].clone()))
            }
            Node::VectorSum(terms) => {
                let mut sum: Option<[N; 3]> = None;
                for ((c, v), number) in terms.iter().zip(&step.numbers) {
                    let v = vector!(v);
                    let term = if c.is_one() { v } else { scale(number, v) };
                    sum = Some(match sum {
                        Some(sum) => add(sum, term),
                        None => term,
                    });
                }
                let zero = || N::exact(&Exact::ZERO);
                Value::Vector(sum.unwrap_or_else(|| [zero(), zero(), zero()]))
            }
            Node::Scale(s, v) => Value::Vector(scale(&real!(s), vector!(v))),
            Node::Cross(u, v) => Value::Vector(cross(&vector!(u), &vector!(v))),
            Node::Rotate(slot, inverse, v) => {
                let [x, y, z] = triple(slot);
                let w = point[place(slot) + 3].clone();
                let axis = if *inverse { [-x, -y, -z] } else { [x, y, z] };
                Value::Vector(rotate(&axis, &w, vector!(v)))
            }
            Node::TurnReal(turn) => Value::Real(turned(turn).1),
            Node::TurnVector(turn) => Value::Vector(turned(turn).0),
            Node::Pack(entries) => Value::Vector(entries.map(|x| real!(x))),
            Node::VectorSelect(c, u, v) => Value::Vector(if truth!(c) { vector!(u) } else { vector!(v) }),
            Node::VectorLet(v) => Value::Vector(vector!(v)),
            Node::Known(truth) => Value::Truth(*truth),
            Node::Compare(comparison, x, y) => {
                Value::Truth(N::holds(*comparison, self.get(values, x.index()).real(), &real!(y)))
            }
            Node::And(a, b) => Value::Truth(truth!(a) && truth!(b)),
            Node::Or(a, b) => Value::Truth(truth!(a) || truth!(b)),
            Node::Not(a) => Value::Truth(!truth!(a)),
        }
    }
}

/// xⁿ
fn powi<N: Number>(x: N, n: i32) -> N {
    let power = power(x, n.unsigned_abs());
    if n < 0 { N::exact(&Exact::ONE) / power } else { power }
}

pub(crate) fn dot<N: Number>(u: &[N; 3], v: &[N; 3]) -> N {
    let term = |k: usize| u[k].clone() * v[k].clone();
    term(0) + term(1) + term(2)
}

pub(crate) fn cross<N: Number>(u: &[N; 3], v: &[N; 3]) -> [N; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| u[i].clone() * v[j].clone() - u[j].clone() * v[i].clone())
}

fn scale<N: Number>(s: &N, v: [N; 3]) -> [N; 3] {
    v.map(|x| s.clone() * x)
}

fn add<N: Number>(u: [N; 3], v: [N; 3]) -> [N; 3] {
    let ([a, b, c], [d, e, f]) = (u, v);
    [a + d, b + e, c + f]
}

fn subtract<N: Number>(u: [N; 3], v: [N; 3]) -> [N; 3] {
    let ([a, b, c], [d, e, f]) = (u, v);
    [a - d, b - e, c - f]
}

/// v + 2w(u×v) + 2u×(u×v)
pub(crate) fn rotate<N: Number>(u: &[N; 3], w: &N, v: [N; 3]) -> [N; 3] {
    let twice = |v: [N; 3]| v.map(|x| x.clone() + x);
    let turned = twice(cross(u, &v));
    let second = cross(u, &turned);
    add(add(v, scale(w, turned)), second)
}
