//! How a kernel is optimised: the optimization effort and the floating-point mode.

/// Optimization effort: how long to search for fewer operations.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Effort {
    /// Factoring only.
    Quick,
    /// A short search; it takes about as long as all other stages together.
    #[default]
    Default,
    /// A long search; it takes seconds per kernel.
    Max,
}

impl Effort {
    /// All efforts by name, lowest first.
    pub const ALL: [(&'static str, Effort); 3] =
        [("quick", Effort::Quick), ("default", Effort::Default), ("max", Effort::Max)];
}

/// Floating-point mode: how a kernel may change rounding.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Mode {
    /// Nothing is factored or regrouped; every quotient is a division.
    Strict,
    /// Factoring where the error stays small.
    #[default]
    Balanced,
    /// Factoring across names and small sums, fewer divisions.
    Fast,
    /// As `Balanced`, with doubled precision for everything that can cancel.
    Accurate,
}

impl Mode {
    /// All modes by name, with a description.
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

    /// The flags for a C compiler that match the mode.
    pub fn flags(self) -> &'static str {
        match self {
            Mode::Strict | Mode::Balanced => "-ffp-contract=off",
            Mode::Fast => "-ffp-contract=fast -march=native",
            Mode::Accurate => "-march=native",
        }
    }

    /// Names of all modes, separated by commas.
    pub fn names() -> String {
        let names: Vec<String> = Mode::ALL.iter().map(|(name, ..)| format!("`{name}`")).collect();
        names.join(", ")
    }

    /// The mode with this name.
    pub fn named(name: &str) -> Option<Mode> {
        Mode::ALL.iter().find(|(own, ..)| *own == name).map(|(_, mode, _)| *mode)
    }
}

/// How to optimise a kernel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Plan {
    /// Optimization effort.
    pub effort: Effort,
    /// Floating-point mode.
    pub mode: Mode,
    /// Whether sums of products use fused multiply-add.
    pub fma: bool,
    /// The passes of the optimiser that run, one bit per pass.
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
