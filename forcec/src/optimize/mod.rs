//! From vectors to few scalar operations: lowering, then passes on the scalar graph.
//!
//! In: the derivatives of a definition, in any formulation. Out: a [`Program`], and the operation count after
//! each pass. Each pass rewrites the network of a program into one that computes the same values. [`PASSES`]
//! lists the passes in order; a [`Plan`] selects which of them run.

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
use crate::scalar::{PassReport, Program};
use crate::vector::definition::Definition;
use crate::vector::{FORMULATIONS, Formulation};
use network::Network;
use std::rc::Rc;

impl Plan {
    /// The same plan with only these passes, selected by name; an unknown name is returned as the error.
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

/// The kind of a pass.
enum Work {
    /// Lowers several formulations, and keeps the ones that are shortest before the search.
    Choose,
    /// Rewrites a network.
    Rewrite(fn(&mut Network)),
    /// Searches for (rounds, rounds in a row without improvement); the flag allows dissolving named values.
    Search(fn(&mut Network, (usize, usize), bool)),
}

impl Effort {
    /// The number of search rounds for a network of this size, fewer for larger networks; and the number of
    /// rounds in a row without improvement after which the search stops.
    fn rounds(self, operations: usize) -> (usize, usize) {
        let (most, budget, patience) = match self {
            Effort::Quick => (0, 0, 0),
            Effort::Default => (24, 12_000, 8),
            Effort::Max => (500, 400_000, 250),
        };
        (most.min(budget / operations.max(1)), patience)
    }

    /// The number of formulations to try for a kernel of this many operations; at least one.
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
    /// One line on the effect of the pass.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub summary: &'static str,
    work: Work,
}

impl Pass {
    /// Runs the pass on the network of one formulation; `share` formulations divide the effort.
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

/// Formulations are also searched if they exceed the shortest by at most 1/`NEARLY` of its operations.
const NEARLY: usize = 50;

/// The name of the step before all passes, from vectors to scalars.
pub const LOWER: &str = "lower";

/// The largest number of extractions from one kernel.
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

/// An optimised program, with the operation count after each pass.
pub struct Optimized {
    /// The program.
    pub program: Program,
    /// The formulation of the program's derivatives.
    pub formulation: Formulation,
    /// The operation count after lowering and after each pass.
    pub report: Vec<PassReport>,
}

/// A formulation with its network and report.
struct Candidate {
    formulation: Formulation,
    network: Network,
    report: Vec<PassReport>,
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
            vec![PassReport { pass: LOWER, operations: lowered.operations(), distinct: network.distinct() }];
        if mode == Mode::Fast {
            lowered = Rc::new(reciprocals::share(&lowered));
            network = Network::new(&lowered);
            report.push(PassReport { pass: "reciprocals", operations: lowered.operations(), ..report[0] });
        }
        Some(Candidate { formulation, network, report })
    }

    fn run(&mut self, pass: &'static Pass, plan: Plan, share: usize) {
        pass.run(&mut self.network, plan, share);
        let (operations, distinct) = (self.network.operations(), self.network.distinct());
        self.report.push(PassReport { pass: pass.name, operations, distinct });
    }

    fn last(&self) -> usize {
        self.report.last().map_or(0, |step| step.operations.total())
    }
}

/// Lowers and optimises the derivatives of a definition. Mode `strict` only rewrites values outside the range
/// of floats, and computes the function's values as written in `source`, if given. `None` above
/// [`crate::lower::MOST_OPERATIONS`] operations.
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
        let report = vec![PassReport { pass: LOWER, operations: lowered.operations(), distinct }];
        let program =
            if spread::spread(&mut network) { network.program() } else { Rc::unwrap_or_clone(lowered) };
        return Some(Optimized { program, formulation, report });
    }
    let factored = |formulation: Formulation| {
        let mut candidate = Candidate::new(formulation, derive(formulation), plan.mode)?;
        for pass in plan.passes() {
            match pass.work {
                Work::Choose => candidate.report.push(PassReport { pass: pass.name, ..candidate.report[0] }),
                Work::Rewrite(_) => candidate.run(pass, plan, 1),
                Work::Search(_) => {}
            }
        }
        Some(candidate)
    };
    let mut candidates = vec![factored(FORMULATIONS[0])?];
    let lowered = candidates[0].report[0];
    // The first formulation has the shortest path from the doubled values to the force.
    if plan.mode != Mode::Accurate && plan.passes().any(|pass| matches!(pass.work, Work::Choose)) {
        let tried = effort.formulations(lowered.operations.total());
        for formulation in &FORMULATIONS[1..tried] {
            let Some(candidate) = factored(*formulation) else { continue };
            if candidates.iter().all(|other| other.report[1..] != candidate.report[1..]) {
                candidates.push(candidate);
            }
        }
    }
    // The search may change the order of candidates of similar length.
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
