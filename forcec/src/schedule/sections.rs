//! Long kernels as several functions: compilers take more than twice as long for twice as many statements in one.
//!
//! In: a schedule. Out: its statements in sections of at most [`LONGEST`], cut where few values are needed on both sides,
//! each with what it takes from earlier ones and hands on to later ones. A short kernel is one section. The statements
//! and their order stay as they are.

use crate::model::outputs::Part;
use crate::schedule::{Expression, Name, Schedule, Statement};
use std::ops::Range;

/// A section has no more statements than this.
pub const LONGEST: usize = 1000;

/// Nor does it have fewer than this, unless it is the last.
const SHORTEST: usize = LONGEST / 2;

/// A part of a kernel that is a function of its own.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Section {
    /// Which result its statements are written for, at their beginning.
    pub part: Part,
    /// Its statements.
    pub statements: Range<usize>,
    /// Statements of earlier sections that are written again: entries of arguments under a short name.
    pub again: Vec<usize>,
    /// Statements that are left out, since later sections alone read what they define and write them again.
    pub unread: Vec<usize>,
    /// The values it takes from earlier sections.
    pub takes: Vec<Name>,
    /// The values it hands on to later ones.
    pub hands_on: Vec<Name>,
    /// Whether it reads or writes results.
    pub stores: bool,
}

impl Section {
    /// The statements that are written in it.
    pub fn written<'a>(&'a self, schedule: &'a Schedule) -> impl Iterator<Item = &'a Statement> {
        let again: Vec<&Statement> = self.again.iter().map(|at| &schedule.statements[*at]).collect();
        let own = self.statements.clone().filter(|at| !self.unread.contains(at));
        again.into_iter().chain(own.map(|at| &schedule.statements[at]))
    }

    /// Whether it takes or hands on a value.
    pub fn shares(&self) -> bool {
        !self.takes.is_empty() || !self.hands_on.is_empty()
    }
}

/// Where a temporary is defined and where it is last read.
#[derive(Clone, Copy)]
struct Life {
    from: usize,
    to: usize,
}

impl Schedule {
    /// The functions that the statements are written in.
    pub fn sections(&self) -> Vec<Section> {
        let lives = self.lives();
        let ends = self.cuts(&lives);
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let mut part = self.parts.first().copied().unwrap_or(Part::Force);
        let mut sections = Vec::new();
        for (start, end) in starts.zip(ends.iter().copied()) {
            let statements = &self.statements[start..end];
            if let Some(Statement::Heading(first)) = statements.first() {
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
                Statement::Heading(part) => Some(*part),
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

    /// Whether a temporary is an entry of an argument, which every section can read itself.
    fn is_input(&self, life: Life) -> bool {
        matches!(self.statements[life.from], Statement::Let(_, Expression::Input(_)))
    }

    /// The ends of the sections.
    fn cuts(&self, lives: &[Life]) -> Vec<usize> {
        let count = self.statements.len();
        // How many values are needed on both sides of the end of each statement; no cut parts a row from its multiples.
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
            // What is left may be too short for a section of its own.
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
    /// The temporary that it gives a value.
    pub fn defines(&self) -> Option<Name> {
        match self {
            Statement::Let(name, _) | Statement::Columns(name, _) => Some(*name),
            _ => None,
        }
    }

    /// The temporaries that it reads.
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

    /// Whether it writes results.
    pub fn stores(&self) -> bool {
        !matches!(self, Statement::Let(..) | Statement::Columns(..) | Statement::Heading(_))
    }
}
