//! The output of the front end: one checked force function as values of a vector graph.

use crate::math::exact::Exact;
use crate::model::bodies::BodyKind;
use crate::model::outputs::Part;
use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::span::Span;
use crate::vector::{Graph, Real, Vector};

/// A checked force function.
#[derive(Clone)]
pub struct Definition {
    /// The name in the source.
    pub name: String,
    /// The doc comment, line by line, without the leading space.
    pub docs: Vec<String>,
    /// The source span of the name.
    pub span: Span,
    /// The graph of the values; `graph.signature` lists bodies and parameters. For a constraint, the last two
    /// parameters are `stiffness` and `damping`: one real each, or with `per_row` an array with one real per
    /// row.
    pub graph: Graph,
    /// The law that the function defines.
    pub law: Law,
    /// Numbers in the source that are out of range for floats, with their spans.
    pub extremes: Vec<(Exact, Span)>,
    /// The warnings that attributes of the function allow.
    pub allowed: Vec<Lint>,
    /// Points where the value or a derivative may not exist; empty for a graph that simplifies nothing.
    pub singular: Vec<Singular>,
    /// The nodes at which the function branches (selections, `abs`, `min`, `max`, `signum`) with their spans,
    /// in the order of nodes.
    pub branches: Vec<(usize, Span)>,
}

/// A place in the source where a value or its derivative may not exist.
#[derive(Clone, Debug)]
pub struct Singular {
    /// The operand that decides whether the value exists.
    pub operand: Real,
    /// The values of the operand at which the value or its derivative may not exist.
    pub ends: Vec<f64>,
    /// The warning to report.
    pub warning: Diagnostic,
    /// Whether an attribute allows the singularity.
    pub allowed: bool,
}

impl Definition {
    /// The derivatives that are symmetric for every function of this kind: ∂F/∂V of a constraint is −Jᵀ D J;
    /// if no body rotates, the derivatives of Jᵀ λ and ∂F/∂X of an energy are Hessians.
    pub fn symmetric(&self) -> &'static [Part] {
        let particles = self.graph.signature.moving().all(|(_, body)| body.kind == BodyKind::PARTICLE);
        match self.law {
            Law::Constraint { .. } if particles => &[Part::Dfdv, Part::Geometric],
            Law::Constraint { .. } => &[Part::Dfdv],
            Law::Energy(_) if particles => &[Part::Dfdx],
            _ => &[],
        }
    }
}

/// The law of a force function.
#[derive(Clone, Debug)]
pub enum Law {
    /// Rows of C, in order; a vector counts as three rows.
    Constraint {
        /// The rows.
        rows: Vec<Row>,
        /// Whether the rows are gaps, which push only while negative.
        unilateral: bool,
        /// Whether `stiffness` and `damping` have one entry per row.
        per_row: bool,
    },
    /// The energy E.
    Energy(Real),
    /// The force on each body, in order.
    Force(Vec<Generalised>),
}

impl Law {
    /// Whether the law has rows with multipliers: only a constraint has.
    pub fn has_multipliers(&self) -> bool {
        matches!(self, Law::Constraint { .. })
    }

    /// The number of rows of C; one for an energy, zero for a force.
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
    /// Three rows, stored as a vector.
    Vector(Vector),
}

impl Row {
    /// The number of rows.
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
