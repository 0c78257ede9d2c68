//! From vectors to the fewest scalars: lowering, then passes on the scalar graph.
//!
//! In: [`Derived`]. Out: a [`Program`], and what every pass saved. Each pass rewrites the network of a program into one
//! that computes the same values; the order of the passes is the order of [`PASSES`].

pub mod extract;
pub mod lower;
pub mod network;
pub mod polynomial;
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
    run: fn(&mut Network),
}

impl Pass {
    /// Applies the pass.
    pub fn run(&self, network: &mut Network) {
        (self.run)(network);
    }
}

/// How many divisors and products factoring may take out of one kernel.
const EXTRACTION_STEPS: usize = 1_000_000;

/// The passes after lowering, in order.
pub static PASSES: [Pass; 3] = [
    Pass {
        name: "collect",
        summary: "like terms meet, copies vanish, what is equal up to sign is one value",
        run: Network::sweep,
    },
    Pass {
        name: "extract",
        summary: "the two-term sums and two-factor products that save most become values of their own",
        run: |network| extract::extract(network, EXTRACTION_STEPS),
    },
    Pass {
        name: "resubstitute",
        summary: "sums are divided by existing ones, and what that frees is factored again",
        run: |network| {
            if resubstitute::resubstitute(network) {
                extract::extract(network, EXTRACTION_STEPS);
            }
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
pub fn optimize(derived: Derived) -> Optimized {
    let lowered = lower::lower(derived);
    let mut report = vec![("lower", lowered.operations())];
    let mut network = Network::new(&lowered);
    for pass in &PASSES {
        pass.run(&mut network);
        report.push((pass.name, network.operations()));
    }
    Optimized { program: network.program(), report }
}
