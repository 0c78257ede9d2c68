//! From vectors to the fewest scalars: lowering, then passes on the scalar graph.
//!
//! In: [`Derived`]. Out: a [`Program`], and what every pass saved. Each pass rewrites the network of a program into one
//! that computes the same values; the order of the passes is the order of [`PASSES`].

pub mod extract;
pub mod lower;
pub mod network;
pub mod polynomial;
pub mod resubstitute;
pub mod search;

use crate::derive::Derived;
use crate::scalar::{Operations, Program};
use network::Network;
use std::rc::Rc;

/// How long to look for fewer operations.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Effort {
    /// Factoring alone.
    Quick,
    /// A short search: takes about as long as everything else together.
    #[default]
    Default,
    /// A long one: seconds a kernel.
    Max,
}

impl Effort {
    /// All of them, the least first, by name.
    pub const ALL: [(&'static str, Effort); 3] =
        [("quick", Effort::Quick), ("default", Effort::Default), ("max", Effort::Max)];

    /// Rounds of search in a network of so many operations: fewer in larger ones, none in the largest.
    fn rounds(self, operations: usize) -> usize {
        let (most, budget) = match self {
            Effort::Quick => (0, 0),
            Effort::Default => (8, 10_000),
            Effort::Max => (500, 400_000),
        };
        most.min(budget / operations.max(1))
    }
}

/// A pass of the optimiser.
pub struct Pass {
    /// Its name in reports.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    run: fn(&mut Network, Effort),
}

impl Pass {
    /// Applies the pass.
    pub fn run(&self, network: &mut Network, effort: Effort) {
        (self.run)(network, effort);
    }
}

/// How many divisors and products factoring may take out of one kernel.
const EXTRACTION_STEPS: usize = 1_000_000;

/// The passes after lowering, in order.
pub static PASSES: [Pass; 4] = [
    Pass {
        name: "collect",
        summary: "like terms meet, copies vanish, what is equal up to sign is one value",
        run: |network, _| network.sweep(),
    },
    Pass {
        name: "extract",
        summary: "the two-term sums and two-factor products that save most become values of their own",
        run: |network, _| extract::extract(network, EXTRACTION_STEPS),
    },
    Pass {
        name: "resubstitute",
        summary: "sums are divided by existing ones, and what that frees is factored again",
        run: |network, _| {
            if resubstitute::resubstitute(network) {
                extract::extract(network, EXTRACTION_STEPS);
            }
        },
    },
    Pass {
        name: "search",
        summary: "values are dissolved into their users and all is factored again, where that is shorter",
        run: |network, effort| {
            let rounds = effort.rounds(network.operations().total());
            search::search(network, rounds, EXTRACTION_STEPS);
        },
    },
];

/// An optimised program with the operations after each pass.
pub struct Optimized {
    /// The program.
    pub program: Program,
    /// Operations after lowering and after each pass.
    pub report: Vec<(&'static str, Operations)>,
}

/// Lowers and optimises.
pub fn optimize(derived: Derived, effort: Effort) -> Optimized {
    let lowered = Rc::new(lower::lower(derived));
    let mut report = vec![("lower", lowered.operations())];
    let mut network = Network::new(&lowered);
    for pass in &PASSES {
        pass.run(&mut network, effort);
        report.push((pass.name, network.operations()));
    }
    Optimized { program: network.program(), report }
}
