//! From the scalar graph to ordered, named statements: what every target prints.
//!
//! In: a [`Program`]. Out: a [`Schedule`], in which dead code is gone, shared values have a name, every line is short
//! enough to read, and a row of outputs is stored as soon as its values are there. A schedule is a value: it can be
//! printed, counted and evaluated. The same program makes the same schedule everywhere.

mod build;
pub(crate) mod doubled;
mod eval;
mod exits;
mod fit;
mod items;
mod names;
pub mod print;
mod rows;
pub mod sections;
mod turns;
mod wrap;

use crate::math::exact::Exact;
use crate::math::functions::{Cost, Function};
use crate::math::number::Comparison;
use crate::math::special;
use crate::model::bodies::{Signature, Slot};
pub use crate::model::outputs::{Output, Part};
use crate::scalar::{Operations, Program};
use std::fmt;
use std::ops::Range;

/// A temporary, by its position in [`Schedule::variables`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Name(pub(crate) u32);

impl Name {
    /// Position among the variables.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What is known of a temporary.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Variable {
    /// Its name: unique, and an identifier in C, C++ and Rust.
    pub name: String,
    /// Whether it is a truth and not a number.
    pub truth: bool,
}

/// A small tree: what one statement computes. Operators associate to the left, as they do in C and Rust.
#[derive(Clone, PartialEq, Debug)]
pub enum Expression {
    /// A number; negative only where no sign could stand before it.
    Literal(Exact),
    /// A known truth.
    Known(bool),
    /// An entry of an argument.
    Input(Slot),
    /// A temporary.
    Name(Name),
    /// −x
    Negative(Box<Expression>),
    /// A pinned difference, never regrouped.
    Difference(Box<[Expression; 2]>),
    /// The terms in order, each with whether it is subtracted.
    Sum(Vec<(bool, Expression)>),
    /// Π over / Π under; 1 over an empty product.
    Quotient(Vec<Expression>, Vec<Expression>),
    /// x y + z, rounded once.
    Fused(Box<[Expression; 3]>),
    /// A row of the function table.
    Call(Function, Vec<Expression>),
    /// if the first holds the second, else the third: a statement of its own.
    Select(Box<[Expression; 3]>),
    /// A comparison.
    Compare(Comparison, Box<[Expression; 2]>),
    /// Both.
    And(Box<[Expression; 2]>),
    /// Either.
    Or(Box<[Expression; 2]>),
    /// Not.
    Not(Box<Expression>),
}

impl Expression {
    /// Whether this is one word: a name, an input or a number.
    pub fn is_atom(&self) -> bool {
        match self {
            Expression::Literal(_) | Expression::Known(_) | Expression::Input(_) | Expression::Name(_) => {
                true
            }
            Expression::Call(function, _) => function.row().cost == Cost::Free,
            _ => false,
        }
    }

    /// Whether this is a truth and not a number, if it is no name.
    pub(crate) fn is_truth(&self) -> bool {
        matches!(
            self,
            Expression::Known(_)
                | Expression::Compare(..)
                | Expression::And(_)
                | Expression::Or(_)
                | Expression::Not(_)
        )
    }

    /// The parts, in order.
    pub fn children(&self) -> Vec<&Expression> {
        match self {
            Expression::Literal(_) | Expression::Known(_) | Expression::Input(_) | Expression::Name(_) => {
                vec![]
            }
            Expression::Negative(x) | Expression::Not(x) => vec![x],
            Expression::Sum(terms) => terms.iter().map(|(_, x)| x).collect(),
            Expression::Quotient(over, under) => over.iter().chain(under).collect(),
            Expression::Call(_, arguments) => arguments.iter().collect(),
            Expression::Select(parts) | Expression::Fused(parts) => parts.iter().collect(),
            Expression::Difference(pair)
            | Expression::Compare(_, pair)
            | Expression::And(pair)
            | Expression::Or(pair) => pair.iter().collect(),
        }
    }

    /// The operations written in it: and, or, not count nothing, nor does the sign of a number.
    pub fn operations(&self) -> Operations {
        let mut count = Operations::default();
        match self {
            Expression::Negative(x) => {
                count.neg = usize::from(
                    !matches!(**x, Expression::Call(function, _) if function.row().cost == Cost::Free),
                )
            }
            Expression::Difference(_) => count.add = 1,
            Expression::Sum(terms) => {
                count.add = terms.len() - 1;
                count.neg = usize::from(terms[0].0);
            }
            Expression::Quotient(over, under) => {
                count.mul = over.len().saturating_sub(1) + under.len().saturating_sub(1);
                count.div = usize::from(!under.is_empty());
            }
            Expression::Call(function, _) => match function.row().cost {
                Cost::Free => {}
                Cost::Sqrt => count.sqrt = 1,
                Cost::Call => count.call = 1,
            },
            Expression::Fused(parts) => {
                (count.add, count.mul) = (1, 1);
                // The sign of a factor or of what is added is part of the operation.
                for part in parts.iter() {
                    let inside = match part {
                        Expression::Negative(x) => x,
                        part => part,
                    };
                    count += inside.operations();
                }
                return count;
            }
            Expression::Select(_) | Expression::Compare(..) => count.call = 1,
            _ => {}
        }
        for child in self.children() {
            count += child.operations();
        }
        count
    }
}

/// One step of a kernel.
#[derive(Clone, PartialEq, Debug)]
pub enum Statement {
    /// A temporary gets its value.
    Let(Name, Expression),
    /// An output gets its value.
    Store(Output, Expression),
    /// A value is added to an output, or if so told subtracted.
    Add(Output, bool, Expression),
    /// Outputs are zero.
    Zero {
        /// Which result.
        part: Part,
        /// The rows, and the runs of columns in each; a force counts as one column.
        rows: Vec<(usize, Vec<Range<usize>>)>,
        /// Whether the other entries of these rows are stored after this and row by row, so that the whole rows may be
        /// zero until then.
        first: bool,
    },
    /// A temporary row gets its values: one a column.
    Columns(Name, Vec<Expression>),
    /// A row of outputs is a multiple of a temporary row.
    Scaled {
        /// Which result.
        part: Part,
        /// Its row.
        row: usize,
        /// The temporary or entry of an argument that it is multiplied by, or its negative.
        factor: Expression,
        /// The temporary row.
        columns: Name,
    },
    /// Rows of outputs are the negatives of others.
    Negated {
        /// Which result.
        part: Part,
        /// Its rows.
        rows: Range<usize>,
        /// The result that the others are rows of.
        of: Part,
        /// The first of the others.
        from: usize,
    },
    /// Here begins what a result needs.
    Heading(Part),
    /// Where this holds every output is zero, and nothing is left to do.
    Leave(Expression),
}

impl Statement {
    /// The expressions written in it.
    pub fn expressions(&self) -> &[Expression] {
        match self {
            Statement::Let(_, value)
            | Statement::Store(_, value)
            | Statement::Add(_, _, value)
            | Statement::Leave(value) => std::slice::from_ref(value),
            Statement::Scaled { factor, .. } => std::slice::from_ref(factor),
            Statement::Columns(_, values) => values,
            Statement::Zero { .. } | Statement::Negated { .. } | Statement::Heading(_) => &[],
        }
    }
}

/// A kernel as statements.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// The arguments.
    pub signature: Signature,
    /// What is computed, in order.
    pub parts: Vec<Part>,
    /// The temporaries.
    pub variables: Vec<Variable>,
    /// The steps, in order.
    pub statements: Vec<Statement>,
    /// How many outputs are not plainly zero.
    pub nonzero: usize,
    /// How many of these differ in more than their sign.
    pub distinct: usize,
    /// Whether outputs are added to what is there, and zeros left alone.
    pub adds: bool,
    /// Whether some values are computed in doubled precision.
    pub doubled: bool,
}

/// What may be written how.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Style {
    /// No product is regrouped, and every quotient is a division: no reciprocal serves several.
    pub strict: bool,
    /// A product that only a sum reads is added to it by a fused multiplication.
    pub fma: bool,
    /// Every entry is stored for itself: no row is written by a loop.
    pub single: bool,
    /// Outputs are added to what is there, and zeros left alone.
    pub adds: bool,
}

/// The statements that compute a program's outputs.
pub fn schedule(program: &Program, style: Style) -> Schedule {
    let build = |guards: bool| {
        let mut items = crate::schedule::items::lower(program, style);
        let guards = if guards { crate::schedule::exits::guards(&mut items) } else { Vec::new() };
        (build::build(&program.signature, items, &guards, style), !guards.is_empty())
    };
    let (schedule, leaves) = build(!style.single);
    // A part of a long kernel cannot leave it.
    let schedule = if leaves && schedule.sections().len() > 1 { build(false).0 } else { schedule };
    Schedule { doubled: program.graph.iter().any(|(id, _)| program.graph.is_doubled(id)), ..schedule }
}

impl Schedule {
    /// How many entries it writes.
    pub fn entries(&self) -> usize {
        self.parts.iter().map(|part| part.length(&self.signature)).sum()
    }

    /// The operations written in the statements; those of a loop count as often as it runs.
    pub fn operations(&self) -> Operations {
        let count = |part: &Part| part.shape(&self.signature).1;
        let mut total = Operations::default();
        for statement in &self.statements {
            match statement {
                Statement::Scaled { part, factor, .. } => {
                    total.mul += count(part);
                    total.neg += count(part) * factor.operations().neg;
                }
                Statement::Negated { part, rows, .. } => total.neg += rows.len() * count(part),
                _ => {
                    total.add += usize::from(matches!(statement, Statement::Add(..)));
                    statement.expressions().iter().for_each(|value| total += value.operations());
                }
            }
        }
        total
    }

    /// How many temporaries and stores there are; a loop counts as one.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn lines(&self) -> usize {
        let counts = |s: &&Statement| !matches!(s, Statement::Zero { .. } | Statement::Heading(_));
        self.statements.iter().filter(counts).count()
    }

    /// The special functions that need a definition of their own, in order.
    pub fn families(&self) -> Vec<Function> {
        let mut found = std::collections::BTreeSet::new();
        let mut pending: Vec<&Expression> = Vec::new();
        for statement in &self.statements {
            pending.extend(statement.expressions());
            while let Some(expression) = pending.pop() {
                match expression {
                    Expression::Call(function, _) if special::is_printed(*function) => {
                        _ = found.insert(*function)
                    }
                    _ => {}
                }
                pending.extend(expression.children());
            }
        }
        found.into_iter().collect()
    }
}

impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for statement in &self.statements {
            for line in print::statement(&print::Plain(&self.signature), &self.variables, statement) {
                writeln!(f, "{line}")?;
            }
        }
        Ok(())
    }
}
