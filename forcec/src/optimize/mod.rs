//! From vectors to the fewest scalars: lowering, then passes on the scalar graph.
//!
//! In: a definition's derivatives, in any formulation that is asked for. Out: a [`Program`], and what every pass saved.
//! Each pass rewrites the network of a program into one that computes the same values; the order of the passes is the
//! order of [`PASSES`]. Which of them run is part of a [`Plan`].

mod accurate;
pub mod extract;
pub mod network;
pub mod polynomial;
pub mod prepare;
mod reciprocals;
pub mod resubstitute;
pub mod search;
pub mod spread;

use crate::derive::Derived;
use crate::options::plan::{Effort, Mode, Plan};
use crate::scalar::{Program, Step};
use crate::vector::definition::Definition;
use crate::vector::{FORMULATIONS, Formulation};
use network::Network;
use std::rc::Rc;

impl Plan {
    /// The same with these passes alone, by name; or the first name that no pass has.
    ///
    /// Lowering is part of every plan, and may be named.
    pub fn with_passes<'n>(self, names: impl IntoIterator<Item = &'n str>) -> Result<Plan, &'n str> {
        let mut plan = Plan { passes: 0, ..self };
        for name in names.into_iter().filter(|name| *name != LOWER) {
            let place = PASSES.iter().position(|pass| pass.name == name).ok_or(name)?;
            plan.passes |= 1 << place;
        }
        Ok(plan)
    }

    fn passes(self) -> impl Iterator<Item = &'static Pass> {
        PASSES
            .iter()
            .enumerate()
            .filter(move |(place, _)| self.passes >> place & 1 == 1)
            .map(|(_, pass)| pass)
    }
}

/// What a pass is.
enum Work {
    /// Several formulations are lowered, and the one that is shortest before the search goes on.
    Choose,
    /// Rewrites a network.
    Rewrite(fn(&mut Network)),
    /// Searches for so many rounds, of which so many in a row may bring nothing; free of names.
    Search(fn(&mut Network, (usize, usize), bool)),
}

impl Effort {
    /// Rounds of search in a network of so many operations: fewer in larger ones, none in the largest; and how many of
    /// them in a row may bring nothing.
    fn rounds(self, operations: usize) -> (usize, usize) {
        let (most, budget, patience) = match self {
            Effort::Quick => (0, 0, 0),
            Effort::Default => (24, 12_000, 8),
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
    pub fn run(&self, network: &mut Network, plan: Plan, share: usize) {
        match self.work {
            Work::Choose => {}
            Work::Rewrite(rewrite) => rewrite(network),
            Work::Search(search) => {
                let rounds = plan.effort.rounds(share * network.operations().total());
                search(network, rounds, plan.mode == Mode::Fast);
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
pub static PASSES: [Pass; 6] = [
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
        name: "spread",
        summary: "values that floats do not hold where positions meet give factors to their users",
        work: Work::Rewrite(|network| {
            spread::spread(network);
        }),
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
        work: Work::Search(|network, (rounds, patience), free| {
            search::search(network, rounds, patience, EXTRACTION_STEPS, free);
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
    fn new(formulation: Formulation, derived: Derived, mode: Mode) -> Option<Candidate> {
        let mut lowered = Rc::new(crate::lower::lower(
            derived,
            mode == Mode::Accurate,
            crate::lower::MOST_OPERATIONS,
            None,
        )?);
        let mut network = Network::new(&lowered);
        let mut report =
            vec![Step { pass: LOWER, operations: lowered.operations(), distinct: network.distinct() }];
        if mode == Mode::Fast {
            lowered = Rc::new(reciprocals::share(&lowered));
            network = Network::new(&lowered);
            report.push(Step { pass: "reciprocals", operations: lowered.operations(), ..report[0] });
        }
        Some(Candidate { formulation, network, report })
    }

    fn run(&mut self, pass: &'static Pass, plan: Plan, share: usize) {
        pass.run(&mut self.network, plan, share);
        let (operations, distinct) = (self.network.operations(), self.network.distinct());
        self.report.push(Step { pass: pass.name, operations, distinct });
    }

    fn last(&self) -> usize {
        self.report.last().map_or(0, |step| step.operations.total())
    }
}

/// Lowers and optimises what `derive` makes of a formulation. Mode `strict` leaves what was lowered as it is, but for
/// what floats do not hold, and computes the values of the function as they are written in its source, if that is given. `None` if that is more than
/// [`crate::lower::MOST_OPERATIONS`].
pub fn optimize(
    derive: impl Fn(Formulation) -> Derived,
    plan: Plan,
    source: Option<&Definition>,
) -> Option<Optimized> {
    let effort = plan.effort;
    if plan.mode == Mode::Strict {
        let formulation = FORMULATIONS[0];
        let lowered =
            Rc::new(crate::lower::lower(derive(formulation), false, crate::lower::MOST_OPERATIONS, source)?);
        let mut network = Network::new(&lowered);
        let distinct = network.distinct();
        let report = vec![Step { pass: LOWER, operations: lowered.operations(), distinct }];
        let program =
            if spread::spread(&mut network) { network.program() } else { Rc::unwrap_or_clone(lowered) };
        return Some(Optimized { program, formulation, report });
    }
    let factored = |formulation: Formulation| {
        let mut candidate = Candidate::new(formulation, derive(formulation), plan.mode)?;
        for pass in plan.passes() {
            match pass.work {
                Work::Choose => candidate.report.push(Step { pass: pass.name, ..candidate.report[0] }),
                Work::Rewrite(_) => candidate.run(pass, plan, 1),
                Work::Search(_) => {}
            }
        }
        Some(candidate)
    };
    let mut candidates = vec![factored(FORMULATIONS[0])?];
    let lowered = candidates[0].report[0];
    // The first formulation is the shortest way from what is computed in doubled precision to the force.
    if plan.mode != Mode::Accurate && plan.passes().any(|pass| matches!(pass.work, Work::Choose)) {
        let tried = effort.formulations(lowered.operations.total());
        for formulation in &FORMULATIONS[1..tried] {
            let Some(candidate) = factored(*formulation) else { continue };
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
        candidates.iter_mut().for_each(|candidate| candidate.run(pass, plan, share));
    }
    let best = candidates.into_iter().min_by_key(Candidate::last).expect("the first formulation is tried");
    let mut report = best.report;
    report[0] = lowered;
    let mut program = best.network.program();
    accurate::mark(&mut program);
    Some(Optimized { program, formulation: best.formulation, report })
}
