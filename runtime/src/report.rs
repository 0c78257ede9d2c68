//! What a step did, and the spans by which a profiler sees it.

use std::time::Duration;

/// What a step did. Numbers are sums over the islands that were stepped, unless they are called largest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Islands that were stepped.
    pub awake: usize,
    /// Islands that sleep after it.
    pub asleep: usize,
    /// Islands that stand still after it since no step of theirs was good, in this call or before.
    pub quarantined: usize,
    /// Steps that were accepted to cover the time.
    pub accepted: usize,
    /// Steps that were discarded.
    pub rejected: usize,
    /// Islands that took the semi-definite back-up.
    pub semi_definite: usize,
    /// Islands that took the last back-up, which caps stiffness.
    pub capped: usize,
    /// Iterations of iterative solvers.
    pub iterations: usize,
    /// Iterative solvers that broke down.
    pub breakdowns: usize,
    /// The largest relative residual |b − A x| / |b| of an accepted step.
    pub residual: f64,
    /// Kinetic energy, the potential in gravity, zero at the world's origin, and that of constraints and energies, J.
    pub energy: f64,
    /// The largest |C| of any constraint.
    pub gap: f64,
    /// Time for assembling, added up over threads.
    pub assembly: Duration,
    /// Time for solving, added up over threads.
    pub solve: Duration,
}

impl Report {
    /// Adds another island's.
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
        self.gap = self.gap.max(other.gap);
        self.assembly += other.assembly;
        self.solve += other.solve;
    }
}

/// A span for profilers, while it lives.
#[cfg(feature = "tracing")]
pub(crate) fn span(name: &'static str) -> tracing::span::EnteredSpan {
    tracing::trace_span!("forcec", part = name).entered()
}

/// No span: the feature `tracing` is off.
#[cfg(not(feature = "tracing"))]
pub(crate) struct NoSpan;

/// No span: the feature `tracing` is off.
#[cfg(not(feature = "tracing"))]
pub(crate) fn span(_name: &'static str) -> NoSpan {
    NoSpan
}
