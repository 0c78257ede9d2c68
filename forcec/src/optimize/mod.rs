//! From vectors to the fewest scalars: lowering, then passes on the scalar graph.
//!
//! In: [`Derived`]. Out: a [`Program`], and what every pass saved. Each pass takes a program and returns one that
//! computes the same values; the order of the passes is the order of [`PASSES`].

pub mod extract;
pub mod lower;
pub mod network;
pub mod resubstitute;

use crate::derive::Derived;
use crate::scalar::{Operations, Program};
use network::Network;

/// A pass of the optimiser.
pub struct Pass {
    /// Its name in reports.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    run: fn(&Program) -> Program,
}

impl Pass {
    /// Applies the pass.
    pub fn run(&self, program: &Program) -> Program {
        (self.run)(program)
    }
}

/// Steps of factoring a program of this size may take.
const EXTRACTION_STEPS: usize = 1_000_000;

/// The passes after lowering, in order.
pub static PASSES: [Pass; 3] = [
    Pass {
        name: "collect",
        summary: "sums and products used once become part of their user; like terms meet; equal up to sign is equal",
        run: |program| {
            let mut network = Network::new(program);
            network.sweep();
            network.program()
        },
    },
    Pass {
        name: "extract",
        summary: "the two-term sums and two-factor products that save most become values of their own",
        run: |program| {
            let mut network = Network::new(program);
            extract::extract(&mut network, EXTRACTION_STEPS);
            network.program()
        },
    },
    Pass {
        name: "resubstitute",
        summary: "sums are divided by existing ones, and what that frees is factored again",
        run: |program| {
            let mut network = Network::new(program);
            if resubstitute::resubstitute(&mut network) {
                extract::extract(&mut network, EXTRACTION_STEPS);
            }
            network.program()
        },
    },
];

/// An optimised program with the operations after each pass, lowering first.
pub struct Optimized {
    /// The program.
    pub program: Program,
    /// The lowered program before any pass.
    pub lowered: Operations,
    /// Operations after each pass.
    pub report: Vec<(&'static str, Operations)>,
}

/// Lowers and optimises. A pass that would cost operations is undone.
pub fn optimize(derived: Derived) -> Optimized {
    let mut program = lower::lower(derived);
    let lowered = program.operations();
    let mut report = Vec::new();
    for pass in &PASSES {
        let next = pass.run(&program);
        let (before, after) = (program.operations(), next.operations());
        if (after.total(), after.neg) <= (before.total(), before.neg) || pass.name == "collect" {
            program = next;
        }
        report.push((pass.name, program.operations()));
    }
    Optimized { program, lowered, report }
}
