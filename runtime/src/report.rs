//! The report of a step, and tracing spans for profilers.

use std::time::Duration;

/// The results of a step. Numbers are sums over the islands that were stepped, except those called largest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// The number of islands that were stepped.
    pub awake: usize,
    /// The number of sleeping islands after the call.
    pub asleep: usize,
    /// The number of islands stopped by failed steps, in this call or earlier.
    pub quarantined: usize,
    /// The number of accepted steps.
    pub accepted: usize,
    /// The number of discarded steps.
    pub rejected: usize,
    /// The number of islands that needed semi-definite derivatives.
    pub semi_definite: usize,
    /// The number of islands that needed capped stiffness.
    pub capped: usize,
    /// The iterations of iterative solvers.
    pub iterations: usize,
    /// The breakdowns of iterative solvers.
    pub breakdowns: usize,
    /// The largest relative residual |b − A x| / |b| of an accepted step.
    pub residual: f64,
    /// The energy, J: kinetic, potential in gravity (zero at the world's origin), of constraints and
    /// energies.
    pub energy: f64,
    /// The largest |C| of any constraint; unilateral rows count only while they push.
    pub max_violation: f64,
    /// The time for assembly, summed over threads.
    pub assembly: Duration,
    /// The time for solving, summed over threads.
    pub solve: Duration,
}

impl Report {
    /// Adds the report of another island.
    pub(crate) fn add(&mut self, other: &Report) {
        self.awake += other.awake;
        self.accepted += other.accepted;
        self.rejected += other.rejected;
        self.semi_definite += other.semi_definite;
        self.capped += other.capped;
        self.iterations += other.iterations;
        self.breakdowns += other.breakdowns;
        self.residual = self.residual.max(other.residual);
        self.energy += other.energy;
        self.max_violation = self.max_violation.max(other.max_violation);
        self.assembly += other.assembly;
        self.solve += other.solve;
    }
}

/// A span for profilers, until it is dropped.
#[cfg(feature = "tracing")]
pub(crate) fn span(name: &'static str) -> tracing::span::EnteredSpan {
    tracing::trace_span!("forcec", part = name).entered()
}

/// A substitute for spans: the feature `tracing` is off.
#[cfg(not(feature = "tracing"))]
pub(crate) struct NoSpan;

/// A substitute for spans: the feature `tracing` is off.
#[cfg(not(feature = "tracing"))]
pub(crate) fn span(_name: &'static str) -> NoSpan {
    NoSpan
}
