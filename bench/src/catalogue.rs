//! The stability catalogue: possible failures, case by case, and whether they occur.
//!
//! The base scene is [`c10`](crate::scenes::c10), ks 1e6, critical damping, 5 s, the default integrator.
//! **U** means: all values stay finite, no island is quarantined, energy grows by at most one percent of the
//! larger of the initial energy and the range of kinetic and elastic energy, and a repeated run gives
//! identical bits.

mod cases;
mod chains;
mod inputs;
mod islands;
mod kernels;
mod single;
mod spins;
mod structures;

use crate::scenes::Scene;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Duration;

pub use cases::CASES;

/// A case of the catalogue.
pub struct Case {
    /// Number of the case.
    pub number: usize,
    /// Description and requirement.
    pub title: &'static str,
    /// Runs the case, in a shorter form if `quick`.
    pub run: fn(quick: bool) -> Verdict,
}

/// Result of a case.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Whether the requirement is met.
    pub passes: bool,
    /// The measured values.
    pub text: String,
}

/// The head of the table.
pub const HEAD: &str = "| # | case | passes | measured |\n|--:|---|---|---|";

/// A row of the table.
pub fn row(case: &Case, verdict: &Verdict) -> String {
    let passes = if verdict.passes { "yes" } else { "**no**" };
    format!("| {} | {} | {passes} | {} |", case.number, case.title, verdict.text)
}

/// Observations of a run.
#[derive(Clone, Debug, Default)]
struct Seen {
    /// Growth of energy relative to the scale of energy.
    growth: f64,
    finite: bool,
    quarantined: usize,
    accepted: usize,
    rejected: usize,
    backups: usize,
    gap: f64,
    last_gap: f64,
    speed: f64,
    last_speed: f64,
    residual: f64,
    solve: Duration,
    steps: usize,
    hash: u64,
}

impl Seen {
    fn is_stable(&self) -> bool {
        self.finite && self.quarantined == 0 && self.growth <= 0.01
    }
}

impl std::fmt::Display for Seen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "energy +{:.1e}, gap {:.1e} m, {} of {} steps discarded",
            self.growth.max(0.0),
            self.gap,
            self.rejected,
            self.rejected + self.accepted
        )?;
        if self.backups > 0 {
            write!(f, ", {} back-ups", self.backups)?;
        }
        if self.quarantined > 0 {
            write!(f, ", quarantined")?;
        }
        Ok(())
    }
}

/// Runs a scene for a time with step sizes `h(k)`.
fn watch(scene: &mut Scene, time: f64, h: impl Fn(usize) -> f64) -> Seen {
    let mut seen = Seen { finite: true, ..Seen::default() };
    let start = scene.world.energy();
    let moving = start - scene.potential();
    let (mut low, mut high, mut most) = (moving, moving, start);
    let mut now = 0.0;
    while now < time - 1e-9 {
        let h = h(seen.steps);
        let report = scene.advance(now, h);
        now += h;
        seen.steps += 1;
        seen.accepted += report.accepted;
        seen.rejected += report.rejected;
        seen.backups += report.semi_definite + report.capped;
        seen.quarantined += report.quarantined;
        seen.residual = seen.residual.max(report.residual);
        seen.solve += report.solve;
        seen.gap = seen.gap.max(report.max_violation);
        seen.last_gap = report.max_violation;
        let moving = report.energy - scene.potential();
        (low, high, most) = (low.min(moving), high.max(moving), most.max(report.energy));
        seen.finite &= report.energy.is_finite();
        if !seen.finite || report.quarantined > 0 {
            break;
        }
        if scene.look.boxes.len() == scene.bodies.len() {
            let speed = |&body| scene.world.rigid(body).map_or(0.0, |state| state.velocity.norm());
            seen.last_speed = scene.bodies.iter().map(speed).fold(0.0, f64::max);
            seen.speed = seen.speed.max(seen.last_speed);
        }
    }
    let scale = start.abs().max(high - low).max(f64::MIN_POSITIVE);
    seen.growth = (most - start) / scale;
    seen.hash = hash(scene);
    seen
}

/// The bits of all positions.
fn hash(scene: &Scene) -> u64 {
    let mut hasher = DefaultHasher::new();
    for position in scene.positions() {
        position.iter().for_each(|x| x.to_bits().hash(&mut hasher));
    }
    hasher.finish()
}

/// Duration of the base scene, s.
fn time(quick: bool) -> f64 {
    if quick { 1.0 } else { 5.0 }
}

/// Whether a run is **U**; the run is made twice.
fn stable(make: &dyn Fn() -> Scene, time: f64, h: f64) -> Verdict {
    let seen = watch(&mut make(), time, |_| h);
    let again = watch(&mut make(), time, |_| h);
    let same = seen.hash == again.hash;
    let text = format!("{seen}{}", if same { "" } else { ", and differs from run to run" });
    Verdict { passes: seen.is_stable() && same, text }
}
