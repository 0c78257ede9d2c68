//! Advice on formulations: measures the behaviour of a force function in a solver.
//!
//! In: a definition. Out: [`Advice`], measurements and warnings at source positions. The same definition
//! gives the same advice. `docs/language.md` lists the measurements and the states.

mod approach;
mod measure;
mod model;
mod pendulum;
mod text;

#[cfg_attr(not(feature = "internals"), allow(unused_imports, reason = "tests use it"))]
pub use crate::lint::pendulum::{DAMPING, STIFFNESS, Steps};
pub use approach::{Approach, Growth};
#[cfg_attr(not(feature = "internals"), allow(unused_imports, reason = "tests use it"))]
pub use measure::STEP;
pub use measure::{Damping, Stiffness};
pub use text::render;

use crate::math::random::Random;
use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::span::Span;
use crate::vector::definition::{Definition, Law};
use model::Model;

/// The number of random states.
const STATES: usize = 40;
/// The distance of nearby states from a satisfied constraint, along a random direction, m or rad.
pub const GAP: f64 = 0.01;
/// The relative error above which a first-order expansion is reported.
const NONLINEAR: f64 = 0.5;
/// The factor by which the stable step must shrink for a warning.
const SHORTER: f64 = 10.0;
/// At a satisfied constraint, an operand within this distance counts as singular.
const AT: f64 = 2.0 * GAP;

/// A measurement at random states, and near states at which a constraint is satisfied.
#[derive(Clone, Copy, Debug)]
pub struct Both<T> {
    /// At random states.
    pub random: Option<T>,
    /// Near satisfied states; `None` unless the function is a constraint.
    pub near: Option<T>,
}

/// The measurements and warnings for a force function.
#[derive(Clone, Debug)]
pub struct Advice {
    /// The name of the function.
    pub name: String,
    /// The position of the name.
    pub span: Span,
    /// The law: `constraint`, `energy` or `force`.
    pub kind: &'static str,
    /// The relative error of the first-order expansion over [`STEP`].
    pub nonlinearity: Both<f64>,
    /// The stiffness.
    pub stiffness: Both<Stiffness>,
    /// The damping; `None` if velocities have no effect.
    pub damping: Option<Damping>,
    /// The singular places, each with measurements near the place.
    pub singular: Vec<(Span, Approach)>,
    /// The largest stable steps of a hanging body; `None` for a force, or if the body is not supported.
    pub steps: Option<Steps>,
    /// The warnings.
    pub warnings: Vec<Diagnostic>,
}

/// Measures a function.
pub fn advise(definition: &Definition) -> Advice {
    let model = Model::new(definition);
    let drawn = model.draw(STATES, 1);
    let near = if model.is_constraint() { near(&model, &drawn) } else { Vec::new() };
    let kind = match definition.law {
        Law::Constraint { .. } => "constraint",
        Law::Energy(_) => "energy",
        Law::Force(_) => "force",
    };
    let approaches = definition.singular.iter();
    let mut advice = Advice {
        name: definition.name.clone(),
        span: definition.span,
        kind,
        nonlinearity: Both {
            random: measure::nonlinearity(&model, &drawn),
            near: measure::nonlinearity(&model, &near),
        },
        stiffness: Both {
            random: measure::stiffness(&model, &drawn),
            near: measure::stiffness(&model, &near),
        },
        damping: measure::damping(&model, &drawn),
        singular: approaches
            .filter_map(|place| Some((place.warning.span?, approach::approach(&model, place, &drawn, &near))))
            .collect(),
        steps: if kind == "force" { None } else { crate::lint::pendulum::largest_steps(&model) },
        warnings: Vec::new(),
    };
    advice.warnings = warnings(definition, &advice);
    advice
}

/// States near those at which a constraint is satisfied.
fn near(model: &Model, drawn: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut random = Random::new(2);
    let all = 0..model.dofs();
    let satisfied = drawn.iter().filter_map(|state| model.satisfied(state, &all));
    let moved = satisfied.map(|state| model.moved(&state, &(model.direction(&mut random, &all) * GAP)));
    moved.filter(|state| model.at(state).is_finite()).collect()
}

fn warnings(definition: &Definition, advice: &Advice) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    let places = definition.singular.iter().zip(&advice.singular);
    let at_zero = |approach: &Approach| approach.satisfied.is_some_and(|distance| distance <= AT);
    for (place, (_, approach)) in places {
        let mut warning = place.warning.clone();
        warning.label = text::label(approach, at_zero(approach));
        warnings.extend(Some(warning).filter(|_| !place.allowed));
    }
    let here = |message: String, label: &str| Diagnostic::warning(definition.span, message, label);
    let name = &definition.name;
    if let Some(near) = advice.nonlinearity.near.filter(|near| *near > NONLINEAR) {
        let message =
            format!("near C = 0 `{name}` leaves its first-order expansion by {}", text::percent(near));
        let label = "over a step of 1/60 s at speeds of a few m/s and rad/s";
        let warning = here(message, label).lint(Lint::Nonlinear);
        warnings.push(warning.help("formulate with rows that change more evenly"));
    }
    if let Some(damping) = advice.damping.filter(|damping| damping.active > 0) {
        let (active, all) = (damping.active, damping.states);
        let message = format!("velocities let `{name}` bring in energy, at {active} of {all} states");
        let label = "(F(V) − F(0))·V is above zero there";
        let warning = here(message, label).lint(Lint::EnergyGain);
        warnings.push(warning.help("see whether a sign or the domain of a parameter is wrong"));
    }
    if let Some(steps) = &advice.steps {
        let seconds = |step: Option<f64>| step.unwrap_or(0.0);
        let much_less = |step: Option<f64>, than: Option<f64>| seconds(step) * SHORTER < seconds(than);
        let undamped = steps.full[0];
        let damped = steps.full.iter().zip(DAMPING).skip(1).find(|(step, _)| much_less(**step, undamped));
        if let Some((step, (label, _))) = damped {
            let message = format!(
                "with {label} the largest stable step of `{name}` is {}, without {}",
                text::seconds(*step),
                text::seconds(undamped)
            );
            let label = "the directions that it damps along turn too fast";
            warnings.push(
                here(message, label)
                    .lint(Lint::DampedStep)
                    .help("damp less, or formulate with rows that pull along steadier directions"),
            );
        }
        if let Some(step) = steps.gauss_newton.first().filter(|step| much_less(**step, undamped)) {
            let message = format!(
                "with a Gauss–Newton stiffness the largest stable step of `{name}` is {}, with ∂F/∂X {}",
                text::seconds(*step),
                text::seconds(undamped)
            );
            let label = "−ks JᵀJ leaves out what holds the body across the rows";
            let warning = here(message, label).lint(Lint::GaussNewton);
            warnings.push(warning.help("solve with the kernel's own ∂F/∂X"));
        }
    }
    warnings.retain(|warning| warning.lint.is_none_or(|lint| !definition.allowed.contains(&lint)));
    warnings
}
