//! From vectors to the fewest scalars: lowering, then passes on the scalar graph.
//!
//! In: [`Derived`]. Out: a [`Program`], and what every pass saved. Each pass rewrites the network of a program into one
//! that computes the same values; the order of the passes is the order of [`PASSES`].

mod accurate;
pub mod extract;
pub mod lower;
pub mod network;
pub mod polynomial;
mod reciprocals;
pub mod resubstitute;
pub mod search;

use crate::derive::Derived;
pub use crate::plan::Effort;
use crate::plan::{Mode, Plan};
use crate::scalar::{Operations, Program};
use network::Network;
use std::rc::Rc;

/// A pass of the optimiser.
pub struct Pass {
    /// Its name in reports.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    run: fn(&mut Network, Plan),
}

impl Pass {
    /// Applies the pass.
    pub fn run(&self, network: &mut Network, plan: Plan) {
        (self.run)(network, plan);
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
        run: |network, plan| {
            let rounds = plan.effort.rounds(network.operations().total());
            search::search(network, rounds, EXTRACTION_STEPS, plan.mode == Mode::Fast);
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

/// Lowers and optimises. Mode `strict` leaves what was lowered as it is.
pub fn optimize(derived: Derived, plan: Plan) -> Optimized {
    let mut lowered = lower::lower(derived, plan.mode == Mode::Accurate);
    let mut report = vec![("lower", lowered.operations())];
    match plan.mode {
        Mode::Strict => return Optimized { program: lowered, report },
        Mode::Fast => {
            lowered = reciprocals::share(&lowered);
            report.push(("reciprocals", lowered.operations()));
        }
        Mode::Balanced | Mode::Accurate => {}
    }
    let mut network = Network::new(&Rc::new(lowered));
    for pass in &PASSES {
        pass.run(&mut network, plan);
        report.push((pass.name, network.operations()));
    }
    let mut program = network.program();
    accurate::mark(&mut program);
    Optimized { program, report }
}
