//! Text forms of the stages: formulas and graphs.

pub mod formula;
pub mod graphs;
