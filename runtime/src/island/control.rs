//! Step control: advances an island by accepted steps, or stops it and reports the failure.
//!
//! A step is accepted if the solver's residual is small, the state is finite, and energy grew by no more than
//! the work done from outside. A rejected step is discarded and retried with half its size, up to ten times.
//! If that fails, the island retries the whole time with semi-definite derivatives, then also with capped
//! stiffness; if that fails too, the island is quarantined at its previous state. A method with an error
//! estimate controls its steps by the estimate instead.

use crate::island::{Activity, Energy, Island};
use crate::outside::{LoadAt, Outside};
use crate::report::Report;
use crate::settings::Settings;
use crate::state::as_f64;
use crate::step::{Integrator, Outcome};
use crate::system::assemble::Fallback;
use crate::system::batch::has_rows;
use nalgebra::{RealField, Vector3, convert};

/// A request to advance an island by a time.
pub(crate) struct StepRequest<'a, R: RealField> {
    /// The whole time, s.
    pub(crate) h: R,
    pub(crate) fallback: Fallback<R>,
    pub(crate) gravity: Vector3<R>,
    pub(crate) loads: Option<LoadAt<'a, R>>,
    pub(crate) settings: &'a Settings<R>,
}

/// The largest number of halvings.
const HALVINGS: u32 = 10;

/// The largest factor by which a capped force may be too stiff; beyond, too little of the force is left.
const MOST_CAPPED: f64 = 1e6;

/// The decay time of the largest past energy, s: as long as a swing may pause.
const MEMORY: f64 = 0.5;

/// The capped stiffness, in units of mass / step².
const CAP: f64 = 100.0;

impl<R: RealField + Copy> Island<R> {
    /// Advances the island by `h` in accepted steps, or quarantines it.
    pub(crate) fn advance(&mut self, request: &StepRequest<'_, R>) -> Report {
        let h = request.h;
        let mut report = Report { awake: 1, ..Report::default() };
        self.save_frame();
        let advanced = (0..3).any(|backup| {
            let fallback = match backup {
                0 => Fallback::None,
                1 => Fallback::SemiDefinite,
                _ => Fallback::Capped(self.cap(h)),
            };
            report.semi_definite = usize::from(backup > 0);
            report.capped = usize::from(backup > 1);
            let request = StepRequest { fallback, ..*request };
            let advanced = if self.steps_by_error(&request) {
                self.advance_by_error(&request, &mut report)
            } else {
                self.advance_by_halving(&request, &mut report)
            };
            if !advanced {
                self.restore_frame();
                self.control.size = None;
            }
            advanced
        });
        if !advanced {
            self.activity = Activity::Quarantined;
        }
        self.summarize(request, report)
    }

    /// Adds energy and violation to a report, and falls asleep after rest.
    fn summarize(&mut self, request: &StepRequest<'_, R>, mut report: Report) -> Report {
        let energy = self.energy(request.gravity);
        report.energy = energy.in_world(request.gravity, self.origin);
        report.max_violation = as_f64(energy.max_violation);
        self.rest(request.h, request.settings);
        report
    }

    /// Whether an error estimate controls the size of steps.
    fn steps_by_error(&self, request: &StepRequest<'_, R>) -> bool {
        match request.settings.integrator {
            Integrator::Rodas4 => true,
            Integrator::RungeKutta4 => has_rows(&self.batches),
            _ => false,
        }
    }

    /// Whether the first step to attempt is the whole one.
    pub(crate) fn starts_whole(&self, request: &StepRequest<'_, R>) -> bool {
        let number = convert::<f64, R>;
        let enough = |size: R| {
            if self.steps_by_error(request) {
                size >= request.h * number(0.999)
            } else {
                request.h <= size * number(2.0)
            }
        };
        self.control.size.is_none_or(enough)
    }

    /// After a whole step, of which the state before is saved: the report if the step is accepted, else
    /// restores the state.
    pub(crate) fn finish_whole(
        &mut self,
        request: &StepRequest<'_, R>,
        before: Energy<R>,
        outcome: Outcome<R>,
    ) -> Option<Report> {
        let mut report = Report { awake: 1, ..Report::default() };
        let error = self.settle(request.h, request, before, Some(outcome), &mut report).ok()?;
        self.control.size = if self.steps_by_error(request) {
            let size = request.h * factor(error, request, convert(5.0));
            self.control.size.filter(|known| *known >= size).or(Some(size))
        } else {
            Some(request.h)
        };
        Some(self.summarize(request, report))
    }

    /// The stiffness above which forces are scaled down.
    fn cap(&self, h: R) -> R {
        let masses = self.store.members.iter().flatten().filter_map(|member| member.inertia());
        let lightest = masses.map(|(mass, _)| mass).reduce(|a, b| a.min(b)).unwrap_or(R::one());
        lightest * convert::<f64, R>(CAP) / (h * h)
    }

    fn advance_by_halving(&mut self, request: &StepRequest<'_, R>, report: &mut Report) -> bool {
        let (half, two) = (convert::<f64, R>(0.5), convert::<f64, R>(2.0));
        let (mut size, mut depth, mut left) = (request.h, 0, 1_u32);
        let halve = |size: &mut R, depth: &mut u32, left: &mut u32| {
            (*size, *depth, *left) = (*size * half, *depth + 1, *left * 2);
        };
        // Starts at most at twice the last accepted size.
        while depth < HALVINGS && self.control.size.is_some_and(|last| size > last * two) {
            halve(&mut size, &mut depth, &mut left);
        }
        let mut time = R::zero();
        while left > 0 {
            if self.try_step(time, size, request, report).is_ok() {
                left -= 1;
                time += size;
                self.control.size = Some(size);
            } else if depth < HALVINGS {
                halve(&mut size, &mut depth, &mut left);
            } else {
                return false;
            }
        }
        true
    }

    fn advance_by_error(&mut self, request: &StepRequest<'_, R>, report: &mut Report) -> bool {
        let number = convert::<f64, R>;
        let h = request.h;
        let smallest = h * number(f64::from(2_u32.pow(2 * HALVINGS)).recip());
        let mut left = h;
        let mut size = self.control.size.unwrap_or(h).min(h);
        let mut most = number(5.0);
        loop {
            // The last two steps share the remaining time.
            let last = size >= left * number(0.999);
            let step = if last { left } else { size.min(left) };
            let tried = self.try_step(h - left, step, request, report);
            match tried {
                Ok(error) => {
                    size = step * factor(error, request, most);
                    most = number(5.0);
                    if !last || self.control.size.is_none_or(|known| known < size) {
                        self.control.size = Some(size);
                    }
                    if last {
                        return true;
                    }
                    left -= step;
                }
                Err(error) => {
                    let by = error.map_or(number(0.25), |error| factor(error, request, most));
                    (size, most) = (step * by, R::one());
                    if size < smallest {
                        return false;
                    }
                }
            }
        }
    }

    /// Attempts one step; returns its error if accepted. Else restores the state; returns a too large error.
    fn try_step(
        &mut self,
        time: R,
        h: R,
        request: &StepRequest<'_, R>,
        report: &mut Report,
    ) -> Result<R, Option<R>> {
        let before = self.energy(request.gravity);
        let outside = Outside { gravity: request.gravity, time, loads: request.loads, origin: self.origin };
        let outcome = self.attempt(h, request.fallback, &outside, request.settings, report);
        self.settle(h, request, before, outcome, report)
    }

    /// Accepts a step, or restores the state before it; see [`Island::try_step`].
    fn settle(
        &mut self,
        h: R,
        request: &StepRequest<'_, R>,
        before: Energy<R>,
        outcome: Option<Outcome<R>>,
        report: &mut Report,
    ) -> Result<R, Option<R>> {
        match self.judge(h, request, before, outcome) {
            Ok((outcome, after, most)) => {
                self.control.energy = Some(after);
                self.control.most = most;
                self.keep(request.settings.integrator, request.fallback);
                report.accepted += 1;
                report.residual = report.residual.max(as_f64(outcome.residual));
                Ok(outcome.error.unwrap_or(R::zero()))
            }
            Err(error) => {
                self.restore();
                // After a halved step failed, the next attempt does not use the stored rates.
                self.control.warm &= h == request.h;
                report.rejected += 1;
                Err(error)
            }
        }
    }

    /// An accepted step with the energy after it and the largest energy so far; else the error if too large.
    fn judge(
        &self,
        h: R,
        request: &StepRequest<'_, R>,
        before: Energy<R>,
        outcome: Option<Outcome<R>>,
    ) -> Result<(Outcome<R>, Energy<R>, R), Option<R>> {
        let number = convert::<f64, R>;
        let &StepRequest { gravity, settings, .. } = request;
        let (power, capped) =
            if settings.integrator.is_explicit() { (R::zero(), R::zero()) } else { self.assembled() };
        // In single precision a thousand roundings, in double precision far more.
        let bound = R::default_epsilon().sqrt().min(number(1e-4));
        let solved = outcome.filter(|outcome| outcome.residual.is_finite() && outcome.residual <= bound);
        let solved = solved.filter(|_| capped <= number(MOST_CAPPED) && self.store.is_finite());
        let outcome = solved.ok_or(None)?;
        let after = self.measure(gravity);
        let grown = after.total - before.total;
        if !grown.is_finite() {
            return Err(None);
        }
        let faded = self.control.most / (R::one() + h / number(MEMORY));
        let most = faded.max(before.moving).max(after.moving);
        if let Some(error) = outcome.error.filter(|error| *error > settings.tolerance || !error.is_finite()) {
            return Err(Some(error).filter(|error| error.is_finite()));
        }
        // An error estimate of forces is more sensitive than energy, one of rigid rows alone is not.
        if settings.integrator == Integrator::Rodas4 {
            return Ok((outcome, after, most));
        }
        let noise = (before.terms + after.terms) * R::default_epsilon() * number(100.0);
        let allowed = |share: R| most * share * (h / request.h) + noise;
        let most_grown = allowed(settings.energy_growth);
        if let Some(work) = outcome.work {
            let gained = grown - work > most_grown;
            let lost = settings.energy_loss.is_some_and(|share| work - grown > allowed(share));
            return if gained || lost { Err(None) } else { Ok((outcome, after, most)) };
        }
        // The power is of some time within the step; loads are constant, so their work is known better.
        let work = power * h * number(2.0);
        let gained = grown > most_grown + work.max(R::zero()) && grown > most_grown + self.load_work(h);
        let lost = settings.energy_loss.is_some_and(|share| -grown > allowed(share) - work.min(R::zero()));
        if gained || lost { Err(None) } else { Ok((outcome, after, most)) }
    }
}

/// The factor to the next size of a step, at most `most`: the error is proportional to its fourth power.
fn factor<R: RealField + Copy>(error: R, request: &StepRequest<'_, R>, most: R) -> R {
    let number = convert::<f64, R>;
    let share = (error / request.settings.tolerance).max(number(1e-8));
    (number(0.9) / share.sqrt().sqrt()).max(number(0.2)).min(most)
}
