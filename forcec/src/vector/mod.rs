//! The vector graph: a force function as the author wrote it, on reals, vectors of three and rotations.
//!
//! One hash-consed arena of typed nodes; ids are `Copy`, operands come before users, so a pass is one loop. Here are the
//! nodes and the arena; the constructors stand below, by what they make. They keep nodes canonical: sums collect like
//! terms with exact coefficients, signs and numbers move outward, products merge powers, differences of points are
//! pinned, and an expression that a `let` holds becomes that let. We simplify real numbers and say so: 0·x = 0 and
//! x/x = 1. A graph made by [`Graph::verbatim`] simplifies nothing: it is the source as written, the reference that
//! everything else is checked against.

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

/// A product of stored unit quaternions, left to right, each inverted or not.
pub type Turn = Box<[(Slot, bool)]>;

/// One node.
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
    /// w of the product of stored unit quaternions, each inverted or not.
    TurnReal(Turn),
    /// A row of the function table.
    Call(Function, Box<[Real]>),
    /// if the condition holds the first, else the second
    Select(Truth, Real, Real),
    /// entry + number, pinned: an entry of an argument, and a number that is not zero.
    Offset(Real, Exact),
    /// An intermediate that the author named, or that derivation keeps: opaque to simplification.
    Let(Real),

    /// Three consecutive entries of an argument.
    Triple(Slot),
    /// The pinned difference of two points, first − second: no pass may regroup across it.
    Difference(Slot, Slot),
    /// triple + numbers, pinned: a point and a place that the text names.
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
    /// if the condition holds the first, else the second
    VectorSelect(Truth, Vector, Vector),
    /// A named intermediate.
    VectorLet(Vector),

    /// A known truth.
    Known(bool),
    /// A comparison.
    Compare(Comparison, Real, Real),
    /// Both.
    And(Truth, Truth),
    /// Either.
    Or(Truth, Truth),
    /// Not.
    Not(Truth),
}

impl Node {
    /// Whether the value is one of two branches, each with a derivative of its own.
    pub fn branches(&self) -> bool {
        use Function::{Abs, Max, Min, Signum};
        matches!(self, Node::Select(..) | Node::VectorSelect(..) | Node::Call(Abs | Signum | Min | Max, _))
    }

    /// Whether it is a real or a vector, and no truth.
    pub fn is_value(&self) -> bool {
        use Node::{And, Compare, Known, Not, Or};
        !matches!(self, Known(_) | Compare(..) | And(..) | Or(..) | Not(_))
    }

    /// The nodes this one reads, truths included, as positions in the arena.
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

/// The arena.
#[derive(Clone)]
pub struct Graph {
    nodes: IndexSet<Node, FxBuildHasher>,
    /// Definitions that a let holds, and the let.
    held: FxHashMap<u32, u32>,
    /// Names of lets.
    names: BTreeMap<u32, String>,
    /// The arguments that slots refer to.
    pub signature: Signature,
    simplify: bool,
    /// Work on long numbers, in steps.
    folding: u64,
    /// Whether quaternions may be taken as of length one: in derivatives, never in values.
    unit_quaternions: bool,
    /// How derivatives are written here.
    pub formulation: Formulation,
}

/// How derivatives are written. All say the same; which is shortest depends on the kernel.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Formulation {
    /// The derivative of a factor is formed backward, for all variables at once, so that what it brings to a vector is
    /// one sum that every arm is crossed with; else forward, a sum of products for every variable.
    pub backward: bool,
    /// Outer products with one left side are joined even where their right sides, taken apart, would meet others.
    pub closed: bool,
    /// A real that all terms of a left side share stands on the right, so that left sides meet those of other blocks.
    pub bare: bool,
}

/// The formulations that are tried, in order.
pub static FORMULATIONS: [Formulation; 4] = [
    Formulation { backward: false, closed: true, bare: true },
    Formulation { backward: false, closed: true, bare: false },
    Formulation { backward: true, closed: true, bare: false },
    Formulation { backward: true, closed: false, bare: false },
];

impl Graph {
    /// An empty graph over these arguments.
    pub fn new(signature: Signature) -> Graph {
        Graph {
            nodes: IndexSet::default(),
            held: FxHashMap::default(),
            names: BTreeMap::new(),
            signature,
            simplify: true,
            folding: 0,
            unit_quaternions: false,
            formulation: FORMULATIONS[0],
        }
    }

    /// An empty graph that keeps every operation as it is written.
    pub fn verbatim(signature: Signature) -> Graph {
        Graph { simplify: false, ..Graph::new(signature) }
    }

    /// Whether the constructors simplify.
    pub fn simplifies(&self) -> bool {
        self.simplify
    }

    /// From here on quaternions have length one: what follows are derivatives.
    pub fn assume_unit_quaternions(&mut self) {
        self.unit_quaternions = true;
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there is none.
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

    /// The numbers that stand in a node itself.
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

    /// Whether a number in a node is beyond what any kernel can print.
    pub fn is_beyond(&self, index: usize) -> bool {
        self.numbers(index).any(Exact::is_beyond)
    }

    /// How much work there was on long numbers, in steps of elaboration.
    pub fn folding(&self) -> u64 {
        self.folding
    }

    /// The name of a let.
    pub fn name(&self, index: usize) -> Option<&str> {
        self.names.get(&(index as u32)).map(String::as_str)
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

/// Arithmetic on a number of so many bits takes about a step of elaboration.
const LONG_NUMBER: usize = 128;

/// A sum of more terms is a term itself where it is added to: accumulating n terms stays linear.
const LONGEST_SUM: usize = 32;
