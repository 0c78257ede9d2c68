//! What the front end hands on: one checked force function as values of a vector graph.

use crate::math::exact::Exact;
use crate::model::bodies::BodyKind;
use crate::model::outputs::Part;
use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::span::Span;
use crate::vector::{Graph, Real, Vector};

/// A checked force function.
#[derive(Clone)]
pub struct Definition {
    /// Its name in the source.
    pub name: String,
    /// Its doc comment, a line each, without the leading space.
    pub docs: Vec<String>,
    /// Where its name stands.
    pub span: Span,
    /// The graph its values live in; `graph.signature` holds bodies and parameters. For a constraint the last two
    /// parameters are `stiffness` and `damping`: a real each, or with `per_row` an array of one real a row.
    pub graph: Graph,
    /// What the function states.
    pub law: Law,
    /// Numbers in its source that floats do not hold, where they stand.
    pub extremes: Vec<(Exact, Span)>,
    /// The warnings that its attributes answer.
    pub allowed: Vec<Lint>,
    /// Where its value or a derivative may not exist; none in a graph that simplifies nothing.
    pub singular: Vec<Singular>,
    /// The nodes at which the function branches, choices and `abs`, `min`, `max`, `signum`, and where they stand, in the
    /// order of nodes.
    pub branches: Vec<(usize, Span)>,
}

/// A place of the source where a value, or its derivative, may not exist.
#[derive(Clone, Debug)]
pub struct Singular {
    /// What decides.
    pub operand: Real,
    /// What the operand is worth there.
    pub ends: Vec<f64>,
    /// What there is to say about it.
    pub warning: Diagnostic,
    /// Whether an attribute says that it is known.
    pub allowed: bool,
}

impl Definition {
    /// The derivatives that are symmetric whatever the function computes: ∂F/∂V of a constraint is −Jᵀ D J; ∂F/∂X of an
    /// energy is a Hessian where nothing turns.
    pub fn symmetric(&self) -> &'static [Part] {
        let mut bodies = self.graph.signature.moving();
        match self.law {
            Law::Constraint { .. } => &[Part::Dfdv],
            Law::Energy(_) if bodies.all(|(_, body)| body.kind == BodyKind::PARTICLE) => &[Part::Dfdx],
            _ => &[],
        }
    }
}

/// What a force function states.
#[derive(Clone, Debug)]
pub enum Law {
    /// Rows of C, in order; a vector counts for three.
    Constraint {
        /// The rows.
        rows: Vec<Row>,
        /// Rows are gaps and push only while they are negative.
        unilateral: bool,
        /// `stiffness` and `damping` have an entry a row.
        per_row: bool,
    },
    /// The energy E.
    Energy(Real),
    /// The force on each body, in order.
    Force(Vec<Generalised>),
}

impl Law {
    /// Whether its rows pull by multipliers: those of a constraint do.
    pub fn has_multipliers(&self) -> bool {
        matches!(self, Law::Constraint { .. })
    }

    /// Rows of C; one for an energy, none for a force.
    pub fn rows(&self) -> usize {
        match self {
            Law::Constraint { rows, .. } => rows.iter().map(|row| row.count()).sum(),
            Law::Energy(_) => 1,
            Law::Force(_) => 0,
        }
    }
}

/// One or three rows of a constraint.
#[derive(Clone, Copy, Debug)]
pub enum Row {
    /// One row.
    Real(Real),
    /// Three rows, kept as a vector.
    Vector(Vector),
}

impl Row {
    /// How many rows.
    pub fn count(self) -> usize {
        match self {
            Row::Real(_) => 1,
            Row::Vector(_) => 3,
        }
    }
}

/// A generalised force on one body, world frame.
#[derive(Clone, Copy, Debug)]
pub struct Generalised {
    /// The force.
    pub force: Vector,
    /// The torque about the centre of mass; `None` for a particle.
    pub torque: Option<Vector>,
}
