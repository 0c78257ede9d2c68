//! Splits long kernels into several functions, because compile time grows faster than the length of a
//! function.
//!
//! In: a schedule. Out: its statements in sections of at most [`LONGEST`], split where few values are live,
//! each with the values it takes from earlier sections and hands on to later ones. A short kernel is one
//! section. The statements and their order do not change.

use crate::model::outputs::Part;
use crate::schedule::{Expression, Name, Schedule, Statement};
use std::ops::Range;

/// The largest number of statements in a section.
pub const LONGEST: usize = 1000;

/// The smallest number of statements in a section other than the last.
const SHORTEST: usize = LONGEST / 2;

/// A part of a kernel that becomes a function of its own.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Section {
    /// The result whose statements begin the section.
    pub part: Part,
    /// The statements of the section.
    pub statements: Range<usize>,
    /// Statements of earlier sections that the section repeats: argument entries with a short name.
    pub again: Vec<usize>,
    /// Statements that are omitted, because only later sections read their values, and those sections repeat
    /// the statements.
    pub unread: Vec<usize>,
    /// The values that the section takes from earlier sections.
    pub takes: Vec<Name>,
    /// The values that the section hands on to later sections.
    pub hands_on: Vec<Name>,
    /// Whether the section reads or writes results.
    pub stores: bool,
}

impl Section {
    /// The statements written in the section.
    pub fn written<'a>(&'a self, schedule: &'a Schedule) -> impl Iterator<Item = &'a Statement> {
        let again: Vec<&Statement> = self.again.iter().map(|at| &schedule.statements[*at]).collect();
        let own = self.statements.clone().filter(|at| !self.unread.contains(at));
        again.into_iter().chain(own.map(|at| &schedule.statements[at]))
    }

    /// Whether the section takes or hands on a value.
    pub fn shares(&self) -> bool {
        !self.takes.is_empty() || !self.hands_on.is_empty()
    }
}

/// The definition and the last read of a temporary.
#[derive(Clone, Copy)]
struct Life {
    from: usize,
    to: usize,
}

impl Schedule {
    /// The sections of the kernel: each becomes a function.
    pub fn sections(&self) -> Vec<Section> {
        let lives = self.lives();
        let ends = self.cuts(&lives);
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let mut part = self.parts.first().copied().unwrap_or(Part::Force);
        let mut sections = Vec::new();
        for (start, end) in starts.zip(ends.iter().copied()) {
            let statements = &self.statements[start..end];
            if let Some(Statement::Heading(first, _)) = statements.first() {
                part = *first;
            }
            let mut read: Vec<Name> = statements.iter().flat_map(Statement::reads).collect();
            read.sort_unstable();
            read.dedup();
            let unread = (start..end).filter(|at| {
                let name = self.statements[*at].defines();
                name.is_some_and(|name| {
                    self.is_input(lives[name.index()]) && read.binary_search(&name).is_err()
                })
            });
            let unread = unread.collect();
            read.retain(|name| lives[name.index()].from < start);
            let (again, takes): (Vec<Name>, Vec<Name>) =
                read.into_iter().partition(|name| self.is_input(lives[name.index()]));
            let defined = statements.iter().filter_map(Statement::defines);
            let hands_on = defined.filter(|name| {
                let life = lives[name.index()];
                life.to >= end && !self.is_input(life)
            });
            sections.push(Section {
                part,
                statements: start..end,
                again: again.into_iter().map(|name| lives[name.index()].from).collect(),
                unread,
                takes,
                hands_on: hands_on.collect(),
                stores: statements.iter().any(Statement::stores),
            });
            let headings = statements.iter().filter_map(|statement| match statement {
                Statement::Heading(part, _) => Some(*part),
                _ => None,
            });
            part = headings.fold(part, |_, last| last);
        }
        sections
    }

    fn lives(&self) -> Vec<Life> {
        let mut lives = vec![Life { from: 0, to: 0 }; self.variables.len()];
        for (index, statement) in self.statements.iter().enumerate() {
            for name in statement.reads() {
                lives[name.index()].to = index;
            }
            if let Some(name) = statement.defines() {
                lives[name.index()] = Life { from: index, to: index };
            }
        }
        lives
    }

    /// Whether a temporary is an argument entry, which every section can read itself.
    fn is_input(&self, life: Life) -> bool {
        matches!(self.statements[life.from], Statement::Let(_, Expression::Input(_)))
    }

    /// The ends of the sections.
    fn cuts(&self, lives: &[Life]) -> Vec<usize> {
        let count = self.statements.len();
        // The number of live values at the end of each statement; a row and its multiples stay in one
        // section.
        let mut change = vec![0i64; count + 1];
        let rows = self.statements.iter().map(|statement| matches!(statement, Statement::Columns(..)));
        let rows: Vec<bool> = rows.collect();
        for life in lives.iter().filter(|life| !self.is_input(**life)) {
            let weight = if rows[life.from] { i64::from(u32::MAX) } else { 1 };
            change[life.from] += weight;
            change[life.to] -= weight;
        }
        let mut alive = 0;
        let alive: Vec<i64> = change
            .into_iter()
            .map(|change| {
                alive += change;
                alive
            })
            .collect();
        let mut ends = Vec::new();
        let mut start = 0;
        while count - start > LONGEST {
            // The remaining statements may be too few for a section of their own.
            let latest = (start + LONGEST).min(count - 1);
            let after = |statement: &usize| (alive[*statement], std::cmp::Reverse(*statement));
            let cut =
                (start + SHORTEST..latest).min_by_key(after).expect("a section is longer than its least");
            start = cut + 1;
            ends.push(start);
        }
        ends.push(count);
        ends
    }
}

impl Statement {
    /// The temporary that the statement defines.
    pub fn defines(&self) -> Option<Name> {
        match self {
            Statement::Let(name, _) | Statement::Columns(name, _) => Some(*name),
            _ => None,
        }
    }

    /// The temporaries that the statement reads.
    pub fn reads(&self) -> Vec<Name> {
        let mut names = Vec::new();
        if let Statement::Scaled { columns, .. } = self {
            names.push(*columns);
        }
        let mut pending: Vec<&Expression> = self.expressions().iter().collect();
        while let Some(expression) = pending.pop() {
            match expression {
                Expression::Name(name) => names.push(*name),
                _ => pending.extend(expression.children()),
            }
        }
        names
    }

    /// Whether the statement writes results.
    pub fn stores(&self) -> bool {
        !matches!(self, Statement::Let(..) | Statement::Columns(..) | Statement::Heading(..))
    }
}
