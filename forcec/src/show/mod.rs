//! The stages as text: formulas and graphs.

pub mod formula;
pub mod graphs;
