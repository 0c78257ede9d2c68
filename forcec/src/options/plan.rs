//! How a kernel is to be made: how long to look for fewer operations, and what may be done to rounding for them.

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
}

/// What a kernel may do to rounding.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Mode {
    /// Nothing is factored or regrouped, every quotient is a division.
    Strict,
    /// Factored where that keeps the error small.
    #[default]
    Balanced,
    /// Factored across names and small sums, divisions saved.
    Fast,
    /// Balanced, and what can cancel is computed in doubled precision.
    Accurate,
}

impl Mode {
    /// All of them by name, with what they do.
    pub const ALL: [(&'static str, Mode, &'static str); 4] = [
        ("strict", Mode::Strict, "nothing is factored or regrouped, every quotient is a division"),
        (
            "balanced",
            Mode::Balanced,
            "factored where that keeps the error small; differences of inputs stay as they are",
        ),
        ("fast", Mode::Fast, "factored across names too; one division for 1/√x and 1/x"),
        (
            "accurate",
            Mode::Accurate,
            "as balanced; what cancels is computed in doubled precision and rounded once",
        ),
    ];

    /// What to tell a C compiler, so that it keeps or uses what the mode allows.
    pub fn flags(self) -> &'static str {
        match self {
            Mode::Strict | Mode::Balanced => "-ffp-contract=off",
            Mode::Fast => "-ffp-contract=fast -march=native",
            Mode::Accurate => "-march=native",
        }
    }

    /// Their names, as a sentence lists them.
    pub fn names() -> String {
        let names: Vec<String> = Mode::ALL.iter().map(|(name, ..)| format!("`{name}`")).collect();
        names.join(", ")
    }

    /// The mode of this name.
    pub fn named(name: &str) -> Option<Mode> {
        Mode::ALL.iter().find(|(own, ..)| *own == name).map(|(_, mode, _)| *mode)
    }
}

/// How to make a kernel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Plan {
    /// How long to look for fewer operations.
    pub effort: Effort,
    /// What may be done to rounding.
    pub mode: Mode,
    /// Whether products that are added are written as fused multiplications and additions.
    pub fma: bool,
    /// Which of the passes of the optimiser run, a bit each.
    pub passes: u32,
}

impl Default for Plan {
    fn default() -> Plan {
        Plan { effort: Effort::Default, mode: Mode::Balanced, fma: false, passes: u32::MAX }
    }
}

impl From<Effort> for Plan {
    fn from(effort: Effort) -> Plan {
        Plan { effort, ..Plan::default() }
    }
}
