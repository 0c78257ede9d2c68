//! The scalar graph: the computation of a kernel on reals only, in a canonical n-ary form.
//!
//! Sums have exact coefficients and a constant, products have positive powers, a division is a product with a
//! reciprocal. Signs and common sizes are moved out of sums, so that a − b and b − a share one node; a
//! multiple is a sum of one term. A difference of two inputs may be pinned: it is a leaf that no pass
//! regroups. Nodes are hash-consed and ordered by id, operands before users: equal inputs give equal graphs.

pub mod eval;
pub mod valuation;

use crate::math::exact::{self, Exact};
use crate::math::functions::{Cost, Function, Operator};
use crate::math::number::Comparison;
use crate::model::bodies::{Signature, Slot};
use crate::model::outputs::{self, Array, Output, Part};
use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;
use smallvec::{SmallVec, smallvec};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The id of a node of the scalar graph.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id(pub(crate) u32);

impl Id {
    /// Index in the arena.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "s{}", self.0)
    }
}

impl fmt::Debug for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "s{}", self.0)
    }
}

/// A node; conditions are in the same arena.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// A number.
    Constant(Exact),
    /// An entry of an argument.
    Input(Slot),
    /// first − second, pinned
    Difference(Slot, Slot),
    /// entry + number, pinned
    Offset(Slot, Exact),
    /// constant + Σ coefficient · id
    Sum(Exact, Box<[(Exact, Id)]>),
    /// Π id^exponent
    Product(Box<[(Id, u32)]>),
    /// number · x for a positive number, as a separate value, because it is a factor more than once.
    Multiple(Exact, Id),
    /// x as a separate value: no pass takes its definition apart.
    Held(Id),
    /// x op y as written in the source: no pass regroups it or folds numbers in it.
    Written(Operator, Id, Id),
    /// 1/x
    Recip(Id),
    /// A function of the function table.
    Call(Function, Box<[Id]>),
    /// The second operand if the first is true, else the third.
    Select(Id, Id, Id),
    /// A known truth value.
    Known(bool),
    /// A comparison.
    Compare(Comparison, Id, Id),
    /// a ∧ b
    And(Id, Id),
    /// a ∨ b
    Or(Id, Id),
    /// ¬a
    Not(Id),
}

impl Node {
    /// The nodes that this node reads, in order.
    pub fn operands(&self) -> SmallVec<[Id; 4]> {
        match self {
            Node::Constant(_) | Node::Input(_) | Node::Difference(..) | Node::Offset(..) | Node::Known(_) => {
                smallvec![]
            }
            Node::Sum(_, terms) => terms.iter().map(|(_, id)| *id).collect(),
            Node::Product(factors) => factors.iter().map(|(id, _)| *id).collect(),
            Node::Multiple(_, x) | Node::Held(x) | Node::Recip(x) | Node::Not(x) => smallvec![*x],
            Node::Call(_, arguments) => arguments.iter().copied().collect(),
            Node::Select(c, x, y) => smallvec![*c, *x, *y],
            Node::Written(_, x, y) | Node::Compare(_, x, y) | Node::And(x, y) | Node::Or(x, y) => {
                smallvec![*x, *y]
            }
        }
    }

    /// Entries of arguments that this node itself reads, in order.
    pub fn slots(&self) -> SmallVec<[Slot; 2]> {
        match self {
            Node::Input(slot) | Node::Offset(slot, _) => smallvec![*slot],
            Node::Difference(first, second) => smallvec![*first, *second],
            _ => smallvec![],
        }
    }
}

/// The arena of nodes.
#[derive(Clone, Default)]
pub struct Graph {
    nodes: IndexSet<Node, FxBuildHasher>,
    names: BTreeMap<Id, String>,
    residual: BTreeSet<Id>,
    doubled: BTreeSet<Id>,
}

impl Graph {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether the graph has no nodes.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The node with this id.
    pub fn node(&self, id: Id) -> &Node {
        &self.nodes[id.index()]
    }

    /// All nodes with their ids, operands before users.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (Id, &Node)> {
        self.nodes.iter().enumerate().map(|(i, node)| (Id(i as u32), node))
    }

    /// The name of a node from the source.
    pub fn name(&self, id: Id) -> Option<&str> {
        self.names.get(&id).map(String::as_str)
    }

    /// Names a node, unless it already has a name or is not an operation.
    pub fn set_name(&mut self, id: Id, name: &str) {
        let plain = match self.node(id) {
            Node::Constant(_) | Node::Input(_) | Node::Known(_) => true,
            Node::Sum(constant, terms) => terms.len() == 1 && constant.is_zero(),
            _ => false,
        };
        if !plain {
            self.names.entry(id).or_insert_with(|| name.to_owned());
        }
    }

    /// The values that lose digits by cancellation, if they were recorded.
    pub fn residual(&self) -> impl Iterator<Item = Id> + '_ {
        self.residual.iter().copied()
    }

    /// Records a value that loses digits by cancellation.
    pub fn set_residual(&mut self, id: Id) {
        if !matches!(self.node(id), Node::Constant(_) | Node::Input(_) | Node::Known(_)) {
            self.residual.insert(id);
        }
    }

    /// Whether a node is computed in doubled precision.
    pub fn is_doubled(&self, id: Id) -> bool {
        self.doubled.contains(&id)
    }

    /// Marks a node for computation in doubled precision.
    pub fn set_doubled(&mut self, id: Id) {
        self.doubled.insert(id);
    }

    /// Adds a node of another graph; `at` maps its operands.
    pub fn copy(&mut self, node: &Node, at: impl Fn(&Id) -> Id) -> Id {
        match node {
            Node::Constant(value) => self.constant(value.clone()),
            Node::Input(slot) => self.input(*slot),
            Node::Difference(first, second) => self.difference(*first, *second),
            Node::Offset(slot, number) => self.intern(Node::Offset(*slot, number.clone())),
            Node::Sum(constant, terms) => {
                self.sum(constant.clone(), terms.iter().map(|(c, x)| (c.clone(), at(x))).collect())
            }
            Node::Product(factors) => {
                let factors: Vec<(Id, u32)> = factors.iter().map(|(x, n)| (at(x), *n)).collect();
                self.product(&factors)
            }
            Node::Multiple(c, x) => self.held_multiple(c, at(x)),
            Node::Held(x) => self.held(at(x)),
            Node::Written(operator, x, y) => self.written(*operator, at(x), at(y)),
            Node::Recip(x) => self.recip(at(x)),
            Node::Call(function, arguments) => {
                let arguments: Vec<Id> = arguments.iter().map(at).collect();
                self.call(*function, &arguments)
            }
            Node::Select(c, x, y) => self.select(at(c), at(x), at(y)),
            Node::Known(value) => self.known(*value),
            Node::Compare(comparison, x, y) => self.compare(*comparison, at(x), at(y)),
            Node::And(a, b) => self.and(at(a), at(b)),
            Node::Or(a, b) => self.or(at(a), at(b)),
            Node::Not(a) => self.not(at(a)),
        }
    }

    /// Truncates the arena; undoes a rejected attempt.
    pub fn truncate(&mut self, length: usize) {
        self.nodes.truncate(length);
        self.names.split_off(&Id(length as u32));
    }

    fn intern(&mut self, node: Node) -> Id {
        let (index, _) = self.nodes.insert_full(node);
        Id(u32::try_from(index).expect("the budget keeps a graph below 2^32 nodes"))
    }

    /// A number as a node.
    pub fn constant(&mut self, value: Exact) -> Id {
        self.intern(Node::Constant(value))
    }

    /// 0
    pub fn zero(&mut self) -> Id {
        self.constant(Exact::ZERO)
    }

    /// 1
    pub fn one(&mut self) -> Id {
        self.constant(Exact::ONE)
    }

    /// The value of a node, if it is a number.
    pub fn value(&self, id: Id) -> Option<&Exact> {
        match self.node(id) {
            Node::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// Whether a node is the number 0.
    pub fn is_zero(&self, id: Id) -> bool {
        self.value(id).is_some_and(Exact::is_zero)
    }

    /// An entry of an argument as a node.
    pub fn input(&mut self, slot: Slot) -> Id {
        self.intern(Node::Input(slot))
    }

    /// first − second, pinned; stored with the greater slot first.
    pub fn difference(&mut self, first: Slot, second: Slot) -> Id {
        if first < second {
            let opposite = self.intern(Node::Difference(second, first));
            return self.scaled(-Exact::ONE, opposite);
        }
        self.intern(Node::Difference(first, second))
    }

    /// x + number, pinned if x is an entry of an argument.
    pub fn offset(&mut self, x: Id, number: Exact) -> Id {
        match *self.node(x) {
            Node::Input(slot) if !number.is_zero() => self.intern(Node::Offset(slot, number)),
            _ => self.sum(number, vec![(Exact::ONE, x)]),
        }
    }

    /// The coefficient of a node and the rest; a number has coefficient 1.
    pub fn split(&self, id: Id) -> (Exact, Id) {
        match self.node(id) {
            Node::Sum(constant, terms) if terms.len() == 1 && constant.is_zero() => terms[0].clone(),
            _ => (Exact::ONE, id),
        }
    }

    /// coefficient · id
    pub fn scaled(&mut self, coefficient: Exact, id: Id) -> Id {
        self.sum(Exact::ZERO, vec![(coefficient, id)])
    }

    /// coefficient · id as a separate value that no user takes apart.
    pub fn held_multiple(&mut self, coefficient: &Exact, id: Id) -> Id {
        let (inner, rest) = self.split(id);
        let coefficient = coefficient * &inner;
        let size = coefficient.abs();
        if size.is_one() || self.value(rest).is_some() {
            return self.scaled(coefficient, rest);
        }
        let held = self.intern(Node::Multiple(size, rest));
        if coefficient.is_negative() { self.neg(held) } else { held }
    }

    /// x op y as written in the source. Signs move outward, which is exact.
    pub fn written(&mut self, operator: Operator, x: Id, y: Id) -> Id {
        let sign = |graph: &mut Graph, id: Id| match graph.split(id) {
            (c, rest) if c.is_unit() && c.is_negative() => (true, rest),
            _ => match graph.value(id).cloned() {
                Some(value) if value.is_negative() => (true, graph.constant(value.abs())),
                _ => (false, id),
            },
        };
        let ((x_negative, x), (y_negative, y)) = (sign(self, x), sign(self, y));
        let (operator, negative) = match (operator, x_negative, y_negative) {
            (Operator::Add, false, true) => (Operator::Subtract, false),
            (Operator::Add, true, false) => (Operator::Subtract, true),
            (Operator::Subtract, false, true) => (Operator::Add, false),
            (Operator::Subtract, true, false) => (Operator::Add, true),
            (Operator::Add | Operator::Subtract, ..) => (operator, x_negative),
            (Operator::Multiply | Operator::Divide, ..) => (operator, x_negative != y_negative),
        };
        let written = self.intern(Node::Written(operator, x, y));
        if negative { self.neg(written) } else { written }
    }

    /// A product or multiple as a value that no pass takes apart; other nodes unchanged. Signs move outward.
    pub fn held(&mut self, id: Id) -> Id {
        let (coefficient, rest) = self.split(id);
        let atom = coefficient.is_unit() && !matches!(self.node(rest), Node::Product(_) | Node::Recip(_));
        if atom || self.value(rest).is_some() {
            return id;
        }
        let size = self.scaled(coefficient.abs(), rest);
        let held = self.intern(Node::Held(size));
        if coefficient.is_negative() { self.neg(held) } else { held }
    }

    /// −x
    pub fn neg(&mut self, id: Id) -> Id {
        self.scaled(-Exact::ONE, id)
    }

    /// x + y
    pub fn add(&mut self, x: Id, y: Id) -> Id {
        self.sum(Exact::ZERO, vec![(Exact::ONE, x), (Exact::ONE, y)])
    }

    /// x − y
    pub fn sub(&mut self, x: Id, y: Id) -> Id {
        self.sum(Exact::ZERO, vec![(Exact::ONE, x), (-Exact::ONE, y)])
    }

    /// x y
    pub fn mul(&mut self, x: Id, y: Id) -> Id {
        self.product(&[(x, 1), (y, 1)])
    }

    /// constant + Σ coefficient · term. Numbers and multiples are merged; sums of several terms stay atoms.
    pub fn sum(&mut self, constant: Exact, terms: Vec<(Exact, Id)>) -> Id {
        let mut constant = constant;
        let mut terms = terms;
        terms.retain_mut(|(coefficient, term)| match self.node(*term) {
            Node::Constant(value) => {
                constant = &constant + &(&*coefficient * value);
                false
            }
            Node::Sum(zero, inner) if inner.len() == 1 && zero.is_zero() => {
                (*coefficient, *term) = (&*coefficient * &inner[0].0, inner[0].1);
                true
            }
            _ => true,
        });
        let mut terms = exact::collect(terms);
        match terms.as_slice() {
            [] => return self.constant(constant),
            [(c, id)] if constant.is_zero() => {
                let (c, id) = (c.clone(), *id);
                return self.multiple(c, id);
            }
            _ => {}
        }
        // A sum and its multiples share one node: positive leading coefficient, common size moved out.
        let size = terms[0].0.abs();
        let even =
            terms.iter().all(|(c, _)| c.abs() == size) && (constant.is_zero() || constant.abs() == size);
        let mut content = if even { size } else { Exact::ONE };
        if terms[0].0.is_negative() {
            content = -content;
        }
        if content.is_one() {
            return self.intern(Node::Sum(constant, terms.into()));
        }
        let inverse = content.recip();
        for (c, _) in &mut terms {
            *c = &*c * &inverse;
        }
        let sum = self.intern(Node::Sum(&constant * &inverse, terms.into()));
        self.multiple(content, sum)
    }

    fn multiple(&mut self, coefficient: Exact, id: Id) -> Id {
        if coefficient.is_one() {
            return id;
        }
        self.intern(Node::Sum(Exact::ZERO, [(coefficient, id)].into()))
    }

    /// Π factor^exponent. Numbers move outward, and powers of the same factor are merged.
    pub fn product(&mut self, factors: &[(Id, u32)]) -> Id {
        let mut coefficient = Exact::ONE;
        let mut powers: SmallVec<[(Id, i64); 8]> = SmallVec::new();
        for &(factor, exponent) in factors {
            let (c, rest) = self.split(factor);
            if let Some(value) = self.value(rest) {
                coefficient = &coefficient * &(&c * value).powi(exponent.min(i32::MAX as u32) as i32);
                continue;
            }
            if !c.power_stays(exponent) && exponent > 1 {
                // Raised as a whole, so that no coefficient leaves the range if the power does not.
                if c.is_negative() && exponent % 2 == 1 {
                    coefficient = -coefficient;
                }
                powers.push((self.held_multiple(&c.abs(), rest), i64::from(exponent)));
                continue;
            }
            if !c.is_one() {
                coefficient = &coefficient * &c.powi(exponent as i32);
            }
            powers.push((rest, i64::from(exponent)));
        }
        if coefficient.is_zero() {
            return self.zero();
        }
        powers.sort();
        powers.dedup_by(|later, earlier| {
            let same = later.0 == earlier.0;
            if same {
                earlier.1 += later.1;
            }
            same
        });
        for i in 0..powers.len() {
            if let Node::Recip(base) = *self.node(powers[i].0)
                && let Some(j) = powers.iter().position(|(id, _)| *id == base)
            {
                let common = powers[i].1.min(powers[j].1);
                powers[i].1 -= common;
                powers[j].1 -= common;
            }
        }
        powers.retain(|(_, e)| *e != 0);
        let product = match powers.as_slice() {
            [] => return self.constant(coefficient),
            [(id, 1)] => *id,
            _ => self.intern(Node::Product(powers.iter().map(|(id, e)| (*id, *e as u32)).collect())),
        };
        self.scaled(coefficient, product)
    }

    /// 1/x
    pub fn recip(&mut self, x: Id) -> Id {
        let (coefficient, rest) = self.split(x);
        if let Some(value) = self.value(rest)
            && !value.is_zero()
        {
            let value = (&coefficient * value).recip();
            return self.constant(value);
        }
        let inverse = match *self.node(rest) {
            Node::Recip(inner) => inner,
            _ => self.intern(Node::Recip(rest)),
        };
        self.scaled(coefficient.recip(), inverse)
    }

    /// A call of a function of the table.
    pub fn call(&mut self, function: Function, arguments: &[Id]) -> Id {
        let mut arguments: Box<[Id]> = arguments.into();
        if function == Function::Hypot {
            // The function is symmetric.
            arguments.sort_unstable();
        }
        self.intern(Node::Call(function, arguments))
    }

    /// x if the condition is true, else y
    pub fn select(&mut self, condition: Id, x: Id, y: Id) -> Id {
        if x == y {
            return x;
        }
        match *self.node(condition) {
            Node::Known(known) => return if known { x } else { y },
            Node::Not(inner) => return self.select(inner, y, x),
            _ => {}
        }
        let (cx, rx) = self.split(x);
        let (cy, ry) = self.split(y);
        let (zero_x, zero_y) = (self.is_zero(x), self.is_zero(y));
        let content = match (zero_x, zero_y) {
            (true, _) => cy,
            (_, true) => cx,
            _ if cx == cy => cx,
            _ => Exact::ONE,
        };
        if content.is_one() {
            return self.intern(Node::Select(condition, x, y));
        }
        let select = self.intern(Node::Select(condition, rx, ry));
        self.scaled(content, select)
    }

    /// A known truth value as a node.
    pub fn known(&mut self, value: bool) -> Id {
        self.intern(Node::Known(value))
    }

    /// A comparison of x and y.
    pub fn compare(&mut self, comparison: Comparison, x: Id, y: Id) -> Id {
        self.intern(Node::Compare(comparison, x, y))
    }

    /// a ∧ b
    pub fn and(&mut self, a: Id, b: Id) -> Id {
        self.intern(Node::And(a.min(b), a.max(b)))
    }

    /// a ∨ b
    pub fn or(&mut self, a: Id, b: Id) -> Id {
        self.intern(Node::Or(a.min(b), a.max(b)))
    }

    /// ¬a
    pub fn not(&mut self, a: Id) -> Id {
        match *self.node(a) {
            Node::Not(inner) => inner,
            _ => self.intern(Node::Not(a)),
        }
    }

    /// Operations of a node without its operands.
    pub fn cost(&self, id: Id) -> Operations {
        let mut cost = Operations::default();
        match self.node(id) {
            Node::Constant(_) | Node::Input(_) | Node::Known(_) => {}
            Node::Difference(..) | Node::Offset(..) => cost.add = 1,
            Node::Sum(constant, terms) => {
                cost.add = terms.len() - 1 + usize::from(!constant.is_zero());
                cost.mul = terms.iter().filter(|(c, _)| !c.is_unit()).count();
                let positive = !constant.is_zero() && !constant.is_negative()
                    || terms.iter().any(|(c, _)| !c.is_negative() || !c.is_unit());
                cost.neg = usize::from(!positive);
            }
            Node::Product(factors) => cost.mul = factors.iter().map(|(_, e)| *e as usize).sum::<usize>() - 1,
            Node::Multiple(..) => cost.mul = 1,
            Node::Recip(_) => cost.div = 1,
            Node::Call(function, _) => match function.row().cost {
                Cost::Free => {}
                Cost::Sqrt => cost.sqrt = 1,
                Cost::Call => cost.call = 1,
            },
            Node::Select(..) | Node::Compare(..) => cost.call = 1,
            Node::Written(Operator::Add | Operator::Subtract, ..) => cost.add = 1,
            Node::Written(Operator::Multiply, ..) => cost.mul = 1,
            Node::Written(Operator::Divide, ..) => cost.div = 1,
            Node::Held(_) | Node::And(..) | Node::Or(..) | Node::Not(_) => {}
        }
        cost
    }
}

/// Operation counts.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Operations {
    /// Additions and subtractions.
    pub add: usize,
    /// Multiplications.
    pub mul: usize,
    /// Divisions.
    pub div: usize,
    /// Square roots.
    pub sqrt: usize,
    /// Everything else: functions, comparisons, selections.
    pub call: usize,
    /// Negations, which are not part of the total.
    pub neg: usize,
}

impl Operations {
    /// The total without negations.
    pub fn total(&self) -> usize {
        self.add + self.mul + self.div + self.sqrt + self.call
    }
}

impl std::ops::AddAssign for Operations {
    fn add_assign(&mut self, other: Operations) {
        self.add += other.add;
        self.mul += other.mul;
        self.div += other.div;
        self.sqrt += other.sqrt;
        self.call += other.call;
        self.neg += other.neg;
    }
}

/// A kernel after a pass of the optimiser.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PassReport {
    /// The name of the pass.
    pub pass: &'static str,
    /// The operation counts.
    pub operations: Operations,
    /// Number of nonzero outputs that are distinct up to sign.
    pub distinct: usize,
}

/// A kernel as a scalar graph with outputs.
#[derive(Clone)]
pub struct Program {
    /// The arguments of the kernel.
    pub signature: Signature,
    /// The arena of nodes.
    pub graph: Graph,
    /// The outputs, in the order of storage.
    pub arrays: Vec<Array<Id>>,
}

impl Program {
    /// All entries in the order of storage, output by output and row by row.
    pub fn outputs(&self) -> impl Iterator<Item = Id> + '_ {
        self.arrays.iter().flat_map(|array| &array.entries).copied()
    }

    /// Entries of an output, row by row; empty if it is not computed.
    pub fn part(&self, part: Part) -> &[Id] {
        outputs::entries(&self.arrays, part)
    }

    /// A program whose entries are all the same node.
    pub fn filled(signature: Signature, graph: Graph, parts: &[Part], id: Id) -> Program {
        let array = |part: &Part| Array::new(*part, &signature, vec![id; part.length(&signature)]);
        let arrays = parts.iter().map(array).collect();
        Program { signature, graph, arrays }
    }

    /// Changes one entry. Panics if its output is not computed.
    pub fn set(&mut self, output: Output, id: Id) {
        let array = self.arrays.iter_mut().find(|array| array.part == output.part);
        let array = array.expect("a result that is computed");
        array.entries[output.row * array.columns + output.column] = id;
    }

    /// The outputs, and the values that lose digits by cancellation.
    pub fn roots(&self) -> impl Iterator<Item = Id> + '_ {
        self.outputs().chain(self.graph.residual())
    }

    /// The same signature and outputs with an empty graph.
    pub fn outline(&self) -> Program {
        Program { signature: self.signature.clone(), graph: Graph::default(), arrays: self.arrays.clone() }
    }

    /// Replaces every output.
    pub fn map_outputs(&mut self, mut map: impl FnMut(Id) -> Id) {
        for output in self.arrays.iter_mut().flat_map(|array| &mut array.entries) {
            *output = map(*output);
        }
    }

    /// Whether each node is needed by an output.
    pub fn live(&self) -> Vec<bool> {
        let mut live = vec![false; self.graph.len()];
        for output in self.outputs() {
            live[output.index()] = true;
        }
        for index in (0..live.len()).rev() {
            if live[index] {
                for operand in self.graph.node(Id(index as u32)).operands() {
                    live[operand.index()] = true;
                }
            }
        }
        live
    }

    /// Operations of all nodes that outputs need, each counted once.
    pub fn operations(&self) -> Operations {
        let mut total = Operations::default();
        for (index, live) in self.live().into_iter().enumerate() {
            if live {
                total += self.graph.cost(Id(index as u32));
            }
        }
        total
    }
}
