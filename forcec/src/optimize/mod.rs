//! From vectors to the fewest scalars: lowering, then passes on the scalar graph.
//!
//! In: a definition's derivatives, in any formulation that is asked for. Out: a [`Program`], and what every pass saved.
//! Each pass rewrites the network of a program into one that computes the same values; the order of the passes is the
//! order of [`PASSES`]. Which of them run is part of a [`Plan`].

pub mod extract;
pub mod lower;
pub mod network;
pub mod polynomial;
pub mod resubstitute;
pub mod search;

use crate::derive::Derived;
use crate::scalar::{Program, Step};
use crate::vector::{FORMULATIONS, Formulation};
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

    /// Rounds of search in a network of so many operations: fewer in larger ones, none in the largest; and how many of
    /// them in a row may bring nothing.
    fn rounds(self, operations: usize) -> (usize, usize) {
        let (most, budget, patience) = match self {
            Effort::Quick => (0, 0, 0),
            Effort::Default => (16, 12_000, 4),
            Effort::Max => (500, 400_000, 250),
        };
        (most.min(budget / operations.max(1)), patience)
    }

    /// How many formulations to try for a kernel of so many operations; the first is always tried.
    fn formulations(self, operations: usize) -> usize {
        let budget = match self {
            Effort::Quick => 0,
            Effort::Default => 6_000,
            Effort::Max => 100_000,
        };
        (budget / operations.max(1)).clamp(1, FORMULATIONS.len())
    }
}

/// How to optimise: how long, and with which passes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Plan {
    /// How long.
    pub effort: Effort,
    /// Which of [`PASSES`] run.
    runs: [bool; PASSES.len()],
}

impl From<Effort> for Plan {
    fn from(effort: Effort) -> Plan {
        Plan { effort, runs: [true; PASSES.len()] }
    }
}

impl Default for Plan {
    fn default() -> Plan {
        Plan::from(Effort::Default)
    }
}

impl Plan {
    /// The same with these passes alone, by name; or the first name that no pass has.
    ///
    /// Lowering is part of every plan, and may be named.
    pub fn with_passes<'n>(self, names: impl IntoIterator<Item = &'n str>) -> Result<Plan, &'n str> {
        let mut plan = Plan { runs: [false; PASSES.len()], ..self };
        for name in names.into_iter().filter(|name| *name != LOWER) {
            let place = PASSES.iter().position(|pass| pass.name == name).ok_or(name)?;
            plan.runs[place] = true;
        }
        Ok(plan)
    }

    fn passes(&self) -> impl Iterator<Item = &'static Pass> {
        PASSES.iter().zip(self.runs).filter(|(_, runs)| *runs).map(|(pass, _)| pass)
    }
}

/// What a pass is.
enum Work {
    /// Several formulations are lowered, and the one that is shortest before the search goes on.
    Choose,
    /// Rewrites a network.
    Rewrite(fn(&mut Network)),
    /// Searches for so many rounds, of which so many in a row may bring nothing.
    Search(fn(&mut Network, (usize, usize))),
}

/// A pass of the optimiser.
pub struct Pass {
    /// Its name in reports.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    work: Work,
}

impl Pass {
    /// Applies the pass to the network of one of so many formulations that share the effort.
    pub fn run(&self, network: &mut Network, effort: Effort, share: usize) {
        match self.work {
            Work::Choose => {}
            Work::Rewrite(rewrite) => rewrite(network),
            Work::Search(search) => {
                search(network, effort.rounds(share * network.operations().total()));
            }
        }
    }
}

/// Formulations that are longer than the shortest by no more than this part of it are searched, too.
const NEARLY: usize = 50;

/// What comes before every pass: from vectors to scalars.
pub const LOWER: &str = "lower";

/// How many divisors and products factoring may take out of one kernel.
const EXTRACTION_STEPS: usize = 1_000_000;

/// The passes after lowering, in order.
pub static PASSES: [Pass; 5] = [
    Pass {
        name: "formulate",
        summary: "derivatives are written in several ways; the one that is shortest before the search goes on",
        work: Work::Choose,
    },
    Pass {
        name: "collect",
        summary: "like terms meet, copies vanish, what is equal up to sign is one value",
        work: Work::Rewrite(Network::sweep),
    },
    Pass {
        name: "extract",
        summary: "the two-term sums and two-factor products that save most become values of their own",
        work: Work::Rewrite(|network| extract::extract(network, EXTRACTION_STEPS)),
    },
    Pass {
        name: "resubstitute",
        summary: "sums are divided by existing ones, and what that frees is factored again",
        work: Work::Rewrite(|network| {
            if resubstitute::resubstitute(network) {
                extract::extract(network, EXTRACTION_STEPS);
            }
        }),
    },
    Pass {
        name: "search",
        summary: "values are dissolved into their users and all is factored again, where that is shorter",
        work: Work::Search(|network, (rounds, patience)| {
            search::search(network, rounds, patience, EXTRACTION_STEPS);
        }),
    },
];

/// An optimised program with the operations after each pass.
pub struct Optimized {
    /// The program.
    pub program: Program,
    /// The formulation it was made of.
    pub formulation: Formulation,
    /// What it was after lowering and after each pass.
    pub report: Vec<Step>,
}

/// A formulation on its way through the passes.
struct Candidate {
    formulation: Formulation,
    network: Network,
    report: Vec<Step>,
}

impl Candidate {
    fn new(formulation: Formulation, derived: Derived) -> Candidate {
        let lowered = Rc::new(lower::lower(derived));
        let network = Network::new(&lowered);
        let step = Step { pass: LOWER, operations: lowered.operations(), distinct: network.distinct() };
        Candidate { formulation, network, report: vec![step] }
    }

    fn run(&mut self, pass: &'static Pass, effort: Effort, share: usize) {
        pass.run(&mut self.network, effort, share);
        let (operations, distinct) = (self.network.operations(), self.network.distinct());
        self.report.push(Step { pass: pass.name, operations, distinct });
    }

    fn last(&self) -> usize {
        self.report.last().map_or(0, |step| step.operations.total())
    }
}

/// Lowers and optimises what `derive` makes of a formulation.
pub fn optimize(derive: impl Fn(Formulation) -> Derived, plan: Plan) -> Optimized {
    let effort = plan.effort;
    let factored = |formulation: Formulation| {
        let mut candidate = Candidate::new(formulation, derive(formulation));
        for pass in plan.passes() {
            match pass.work {
                Work::Choose => candidate.report.push(Step { pass: pass.name, ..candidate.report[0] }),
                Work::Rewrite(_) => candidate.run(pass, effort, 1),
                Work::Search(_) => {}
            }
        }
        candidate
    };
    let mut candidates = vec![factored(FORMULATIONS[0])];
    let lowered = candidates[0].report[0];
    if plan.passes().any(|pass| matches!(pass.work, Work::Choose)) {
        let tried = effort.formulations(lowered.operations.total());
        for formulation in &FORMULATIONS[1..tried] {
            let candidate = factored(*formulation);
            if candidates.iter().all(|other| other.report[1..] != candidate.report[1..]) {
                candidates.push(candidate);
            }
        }
    }
    // The search may turn the order of those that are nearly the same.
    let shortest = candidates.iter().map(Candidate::last).min().unwrap_or(0);
    candidates.retain(|candidate| candidate.last() <= shortest + shortest / NEARLY);
    for pass in plan.passes().filter(|pass| matches!(pass.work, Work::Search(_))) {
        let share = candidates.len();
        candidates.iter_mut().for_each(|candidate| candidate.run(pass, effort, share));
    }
    let best = candidates.into_iter().min_by_key(Candidate::last).expect("the first formulation is tried");
    let mut report = best.report;
    report[0] = lowered;
    Optimized { program: best.network.program(), formulation: best.formulation, report }
}
