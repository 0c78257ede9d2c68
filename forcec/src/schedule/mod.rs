//! From the scalar graph to ordered, named statements, which every target prints.
//!
//! In: a [`Program`]. Out: a [`Schedule`] without dead code, in which shared values have names, every line is
//! short enough to read, and a row of outputs is stored as soon as its values are computed. A schedule is
//! plain data: it can be printed, counted and evaluated. Scheduling is deterministic: the same program gives
//! the same schedule on every machine.

mod build;
pub(crate) mod doubled;
mod eval;
mod exits;
mod expressions;
mod fit;
mod items;
pub mod meanings;
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
use meanings::Meanings;
use std::fmt;
use std::ops::Range;

/// A temporary, identified by its position in [`Schedule::variables`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Name(pub(crate) u32);

impl Name {
    /// Position among the variables.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Name and type of a temporary.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Variable {
    /// The name of the temporary: unique, and a valid identifier in C, C++ and Rust.
    pub name: String,
    /// Whether the temporary is a boolean rather than a number.
    pub truth: bool,
}

/// A small expression tree: the value of one statement. Operators associate to the left, as in C and Rust.
#[derive(Clone, PartialEq, Debug)]
pub enum Expression {
    /// A number; it is negative only where no minus sign can precede it.
    Literal(Exact),
    /// A boolean constant.
    Known(bool),
    /// An entry of an argument.
    Input(Slot),
    /// A temporary.
    Name(Name),
    /// −x
    Negative(Box<Expression>),
    /// A pinned difference: no pass regroups it.
    Difference(Box<[Expression; 2]>),
    /// The terms in order, each with a flag that is true for a subtracted term.
    Sum(Vec<(bool, Expression)>),
    /// Π over / Π under; an empty numerator is 1.
    Quotient(Vec<Expression>, Vec<Expression>),
    /// x y + z with one rounding.
    Fused(Box<[Expression; 3]>),
    /// A row of the function table.
    Call(Function, Vec<Expression>),
    /// If the first is true the second, else the third. A selection is always a statement of its own.
    Select(Box<[Expression; 3]>),
    /// A comparison.
    Compare(Comparison, Box<[Expression; 2]>),
    /// Logical and.
    And(Box<[Expression; 2]>),
    /// Logical or.
    Or(Box<[Expression; 2]>),
    /// Logical not.
    Not(Box<Expression>),
}

impl Expression {
    /// Whether the expression is a single token: a name, an input or a number.
    pub fn is_atom(&self) -> bool {
        match self {
            Expression::Literal(_) | Expression::Known(_) | Expression::Input(_) | Expression::Name(_) => {
                true
            }
            Expression::Call(function, _) => function.row().cost == Cost::Free,
            _ => false,
        }
    }

    /// Whether the expression is a boolean. Names are not looked up: the result for a name is false.
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

    /// The subexpressions, in order.
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

    /// The operations in the expression. Logical operators and the sign of a number cost nothing.
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
                // The sign of a factor or of the addend is part of the operation.
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

/// One statement of a kernel.
#[derive(Clone, PartialEq, Debug)]
pub enum Statement {
    /// Defines a temporary.
    Let(Name, Expression),
    /// Assigns a value to an output.
    Store(Output, Expression),
    /// Adds a value to an output, or subtracts it if the flag is set.
    Add(Output, bool, Expression),
    /// Sets outputs to zero.
    Zero {
        /// The result.
        part: Part,
        /// The rows, and the runs of columns in each; a force counts as one column.
        rows: Vec<(usize, Vec<Range<usize>>)>,
        /// Whether all other entries of these rows are stored afterwards and row by row, so that the whole
        /// rows may be set to zero here.
        first: bool,
    },
    /// Defines a temporary row with one value per column.
    Columns(Name, Vec<Expression>),
    /// Sets a row of outputs to a multiple of a temporary row.
    Scaled {
        /// The result.
        part: Part,
        /// The row of the result.
        row: usize,
        /// The factor: a temporary or an entry of an argument, or the negative of one.
        factor: Expression,
        /// The temporary row.
        columns: Name,
    },
    /// Sets rows of outputs to the negatives of other rows.
    Negated {
        /// The result that is written.
        part: Part,
        /// The rows that are written.
        rows: Range<usize>,
        /// The result whose rows are negated.
        of: Part,
        /// The first of the rows that are negated.
        from: usize,
    },
    /// Marks the start of the statements of an output, or of its rows of a body.
    Heading(Part, Option<u16>),
    /// If the condition is true, sets every output to zero and returns.
    Leave(Expression),
}

impl Statement {
    /// The expressions in the statement.
    pub fn expressions(&self) -> &[Expression] {
        match self {
            Statement::Let(_, value)
            | Statement::Store(_, value)
            | Statement::Add(_, _, value)
            | Statement::Leave(value) => std::slice::from_ref(value),
            Statement::Scaled { factor, .. } => std::slice::from_ref(factor),
            Statement::Columns(_, values) => values,
            Statement::Zero { .. } | Statement::Negated { .. } | Statement::Heading(..) => &[],
        }
    }
}

/// A kernel as a list of statements.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// The arguments.
    pub signature: Signature,
    /// The computed results, in order.
    pub parts: Vec<Part>,
    /// The temporaries.
    pub variables: Vec<Variable>,
    /// The statements, in order.
    pub statements: Vec<Statement>,
    /// The number of outputs other than the constant 0.
    pub nonzero: usize,
    /// The number of these that differ by more than their sign.
    pub distinct: usize,
    /// Whether results are added to the caller's values, so that zero entries are skipped.
    pub adds: bool,
    /// Whether some values are computed in doubled precision.
    pub doubled: bool,
}

/// Options that restrict how expressions are written.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Style {
    /// No product is regrouped, and every quotient is a division: reciprocals are never shared.
    pub strict: bool,
    /// A product that is read only by a sum is added by a fused multiply-add.
    pub fma: bool,
    /// Every entry is stored by its own statement: no loop writes rows.
    pub single: bool,
    /// Results are added to the caller's values, and zero entries are skipped.
    pub adds: bool,
}

/// Schedules a program: the statements that compute its outputs. `meanings` has names for their values.
pub fn schedule(program: &Program, style: Style, meanings: &Meanings) -> Schedule {
    let build = |guards: bool| {
        let mut items = crate::schedule::items::lower(program, style, meanings);
        let guards = if guards { crate::schedule::exits::guards(&mut items) } else { Vec::new() };
        (build::build(&program.signature, items, &guards, style, meanings), !guards.is_empty())
    };
    let (schedule, leaves) = build(!style.single);
    // A kernel split into several functions cannot return early from one of them.
    let schedule = if leaves && schedule.sections().len() > 1 { build(false).0 } else { schedule };
    Schedule { doubled: program.graph.iter().any(|(id, _)| program.graph.is_doubled(id)), ..schedule }
}

impl Schedule {
    /// The number of entries that the kernel writes.
    pub fn entries(&self) -> usize {
        self.parts.iter().map(|part| part.length(&self.signature)).sum()
    }

    /// The operations in the statements; operations in a loop count once per iteration.
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

    /// The number of definitions and stores; a loop counts as one.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn lines(&self) -> usize {
        let counts = |s: &&Statement| !matches!(s, Statement::Zero { .. } | Statement::Heading(..));
        self.statements.iter().filter(counts).count()
    }

    /// The special functions for which the generated code needs a definition, in order.
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
