//! The vector graph: a force function as written by the author, on reals, 3-vectors and rotations.
//!
//! One hash-consed arena of typed nodes. Ids are `Copy`, and operands precede their users, so that a pass is
//! one loop. This module defines the nodes and the arena; the submodules define the constructors, grouped by
//! the kind of node. Constructors keep nodes canonical: sums collect like terms with exact coefficients,
//! signs and numbers move outward, products merge powers, differences of points are pinned, and an expression
//! bound by a `let` is replaced by that let. Simplification assumes real numbers: 0·x = 0 and x/x = 1. A
//! graph made by [`Graph::verbatim`] simplifies nothing: it represents the source as written, and is the
//! reference for all checks.

mod balance;
mod combinations;
pub mod definition;
pub mod identities;
mod joins;
mod lets;
mod points;
mod reals;
mod truths;
mod vectors;

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::math::number::Comparison;
use crate::model::bodies::{Signature, Slot};
use indexmap::IndexSet;
use rustc_hash::{FxBuildHasher, FxHashMap};
use smallvec::{SmallVec, smallvec};
use std::collections::BTreeMap;
use std::fmt;

macro_rules! id {
    ($(#[$doc:meta])* $name:ident, $letter:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub(crate) u32);

        impl $name {
            /// Position in the arena.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}{}", $letter, self.0)
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}{}", $letter, self.0)
            }
        }
    };
}

id!(/// A real-valued node.
    Real, "r");
id!(/// A vector-valued node.
    Vector, "v");
id!(/// A truth-valued node.
    Truth, "b");

/// A product of stored unit quaternions, left to right, each with a flag for its inverse.
pub type Turn = Box<[(Slot, bool)]>;

/// A node of the graph.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// A number.
    Constant(Exact),
    /// An entry of an argument.
    Entry(Slot),
    /// constant + Σ coefficient · real
    Sum(Exact, Box<[(Exact, Real)]>),
    /// Π real^exponent
    Product(Box<[(Real, i32)]>),
    /// u · v
    Dot(Vector, Vector),
    /// An entry of a vector, 0, 1 or 2.
    Component(Vector, u8),
    /// |v|
    Norm(Vector),
    /// w of the product of stored unit quaternions, each with a flag for its inverse.
    TurnReal(Turn),
    /// A row of the function table.
    Call(Function, Box<[Real]>),
    /// if the condition is true the first, else the second
    Select(Truth, Real, Real),
    /// entry + number, pinned: an argument entry plus a nonzero number.
    Offset(Real, Exact),
    /// An intermediate value named by the author or kept by differentiation: opaque to simplification.
    Let(Real),

    /// Three consecutive entries of an argument.
    Triple(Slot),
    /// The pinned difference of two points, first − second: no pass may regroup across it.
    Difference(Slot, Slot),
    /// triple + numbers, pinned: a point plus a constant vector from the source.
    VectorOffset(Vector, Box<[Exact; 3]>),
    /// Σ coefficient · vector; empty is the zero vector
    VectorSum(Box<[(Exact, Vector)]>),
    /// s v
    Scale(Real, Vector),
    /// u × v
    Cross(Vector, Vector),
    /// q·v, or q⁻¹·v when inverse, for the unit quaternion stored at the slot
    Rotate(Slot, bool, Vector),
    /// (x, y, z) of the product of stored unit quaternions.
    TurnVector(Turn),
    /// A vector from its entries.
    Pack([Real; 3]),
    /// if the condition is true the first, else the second
    VectorSelect(Truth, Vector, Vector),
    /// A named intermediate vector.
    VectorLet(Vector),

    /// A boolean constant.
    Known(bool),
    /// A comparison.
    Compare(Comparison, Real, Real),
    /// Logical and.
    And(Truth, Truth),
    /// Logical or.
    Or(Truth, Truth),
    /// Logical not.
    Not(Truth),
}

impl Node {
    /// Whether the value is one of two branches, each with its own derivative.
    pub fn branches(&self) -> bool {
        use Function::{Abs, Max, Min, Signum};
        matches!(self, Node::Select(..) | Node::VectorSelect(..) | Node::Call(Abs | Signum | Min | Max, _))
    }

    /// Whether the node is a real or a vector rather than a boolean.
    pub fn is_value(&self) -> bool {
        use Node::{And, Compare, Known, Not, Or};
        !matches!(self, Known(_) | Compare(..) | And(..) | Or(..) | Not(_))
    }

    /// The operands of the node, booleans included, as positions in the arena.
    pub fn operands(&self) -> SmallVec<[u32; 4]> {
        match self {
            Node::Constant(_)
            | Node::Entry(_)
            | Node::Triple(_)
            | Node::TurnReal(_)
            | Node::TurnVector(_)
            | Node::Difference(..)
            | Node::Known(_) => {
                smallvec![]
            }
            Node::Sum(_, terms) => terms.iter().map(|(_, x)| x.0).collect(),
            Node::Product(factors) => factors.iter().map(|(x, _)| x.0).collect(),
            Node::Dot(u, v) | Node::Cross(u, v) => smallvec![u.0, v.0],
            Node::Component(v, _)
            | Node::Norm(v)
            | Node::Rotate(_, _, v)
            | Node::VectorOffset(v, _)
            | Node::VectorLet(v) => smallvec![v.0],
            Node::Call(_, arguments) => arguments.iter().map(|x| x.0).collect(),
            Node::Select(c, x, y) => smallvec![c.0, x.0, y.0],
            Node::Let(x) | Node::Offset(x, _) => smallvec![x.0],
            Node::VectorSum(terms) => terms.iter().map(|(_, v)| v.0).collect(),
            Node::Scale(s, v) => smallvec![s.0, v.0],
            Node::Pack(entries) => entries.iter().map(|x| x.0).collect(),
            Node::VectorSelect(c, u, v) => smallvec![c.0, u.0, v.0],
            Node::Compare(_, x, y) => smallvec![x.0, y.0],
            Node::And(a, b) | Node::Or(a, b) => smallvec![a.0, b.0],
            Node::Not(a) => smallvec![a.0],
        }
    }
}

/// The arena of nodes.
#[derive(Clone)]
pub struct Graph {
    nodes: IndexSet<Node, FxBuildHasher>,
    /// The let of each expression that a let binds.
    held: FxHashMap<u32, u32>,
    /// The names of the lets.
    names: BTreeMap<u32, String>,
    /// The names of helpers, for the values that they return.
    helpers: BTreeMap<u32, String>,
    /// The arguments that slots refer to.
    pub signature: Signature,
    simplify: bool,
    /// The cost of arithmetic on long numbers, in steps.
    folding: u64,
    /// Whether quaternions may be assumed to have length one: in derivatives, never in values.
    unit_quaternions: bool,
    /// The formulation of derivatives in this graph.
    pub formulation: Formulation,
}

/// A formulation of derivatives. All formulations are equivalent; which one is shortest depends on the
/// kernel.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Formulation {
    /// Derivatives of scalar factors use reverse mode, for all variables at once: the contribution to a
    /// vector is one sum, and every arm is crossed with this sum. Otherwise they use forward mode: a sum of
    /// products for every variable.
    pub backward: bool,
    /// Outer products with the same left side are joined even if their right sides, when expanded, would
    /// share terms.
    pub closed: bool,
    /// A real common to all terms of a left side moves to the right side, so that left sides equal those of
    /// other blocks.
    pub bare: bool,
}

/// The formulations to try, in order.
pub static FORMULATIONS: [Formulation; 4] = [
    Formulation { backward: false, closed: true, bare: true },
    Formulation { backward: false, closed: true, bare: false },
    Formulation { backward: true, closed: true, bare: false },
    Formulation { backward: true, closed: false, bare: false },
];

impl Graph {
    /// An empty graph over the given arguments.
    pub fn new(signature: Signature) -> Graph {
        Graph {
            nodes: IndexSet::default(),
            held: FxHashMap::default(),
            names: BTreeMap::new(),
            helpers: BTreeMap::new(),
            signature,
            simplify: true,
            folding: 0,
            unit_quaternions: false,
            formulation: FORMULATIONS[0],
        }
    }

    /// An empty graph that keeps every operation as written.
    pub fn verbatim(signature: Signature) -> Graph {
        Graph { simplify: false, ..Graph::new(signature) }
    }

    /// Whether the constructors simplify.
    pub fn simplifies(&self) -> bool {
        self.simplify
    }

    /// Assumes unit quaternions in all nodes created from now on, which belong to derivatives.
    pub fn assume_unit_quaternions(&mut self) {
        self.unit_quaternions = true;
    }

    /// The number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether the graph has no nodes.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The node at a position of the arena.
    pub fn node(&self, index: usize) -> &Node {
        &self.nodes[index]
    }

    /// All nodes, operands before users.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = &Node> {
        self.nodes.iter()
    }

    /// The numbers in a node, operands excluded.
    fn numbers(&self, index: usize) -> impl Iterator<Item = &Exact> {
        let none: &[(Exact, Real)] = &[];
        let (own, reals, vectors): (&[Exact], _, &[(Exact, Vector)]) = match self.node(index) {
            Node::Constant(value) | Node::Offset(_, value) => (std::slice::from_ref(value), none, &[]),
            Node::VectorOffset(_, numbers) => (numbers.as_slice(), none, &[]),
            Node::Sum(constant, terms) => (std::slice::from_ref(constant), terms, &[]),
            Node::VectorSum(terms) => (&[], none, terms),
            _ => (&[], none, &[]),
        };
        own.iter().chain(reals.iter().map(|(c, _)| c)).chain(vectors.iter().map(|(c, _)| c))
    }

    /// Whether a number in a node exceeds the range that any kernel can print.
    pub fn is_beyond(&self, index: usize) -> bool {
        self.numbers(index).any(Exact::is_beyond)
    }

    /// The cost of arithmetic on long numbers, in steps of elaboration.
    pub fn folding(&self) -> u64 {
        self.folding
    }

    /// The name of a let.
    pub fn name(&self, index: usize) -> Option<&str> {
        self.names.get(&(index as u32)).map(String::as_str)
    }

    /// The name of the helper that returned a value.
    pub fn helper(&self, index: usize) -> Option<&str> {
        self.helpers.get(&(index as u32)).map(String::as_str)
    }

    /// Records that a helper returned a value: a name for readers, without effect on the graph.
    pub fn returned_by(&mut self, index: usize, helper: &str) {
        self.helpers.entry(index as u32).or_insert_with(|| helper.to_owned());
    }

    fn intern(&mut self, node: Node) -> u32 {
        let (index, new) = self.nodes.insert_full(node);
        if new && self.simplify {
            self.folding +=
                self.numbers(index).map(|number| (number.bits() / LONG_NUMBER) as u64).sum::<u64>();
        }
        let index = u32::try_from(index).expect("the budget keeps a graph below 2^32 nodes");
        self.held.get(&index).copied().unwrap_or(index)
    }

    fn real(&mut self, node: Node) -> Real {
        Real(self.intern(node))
    }

    fn vector(&mut self, node: Node) -> Vector {
        Vector(self.intern(node))
    }

    fn truth(&mut self, node: Node) -> Truth {
        Truth(self.intern(node))
    }

    fn at(&self, real: Real) -> &Node {
        &self.nodes[real.index()]
    }

    fn vector_at(&self, vector: Vector) -> &Node {
        &self.nodes[vector.index()]
    }

    fn truth_at(&self, truth: Truth) -> &Node {
        &self.nodes[truth.index()]
    }
}

/// Arithmetic on a number of this many bits costs about one step of elaboration.
const LONG_NUMBER: usize = 128;

/// Longer sums are not merged into other sums but become one term: accumulating n terms stays linear.
const LONGEST_SUM: usize = 32;
