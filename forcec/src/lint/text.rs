//! Prints advice as a few lines per function.
//!
//! In: advice and its source. Out: text for people.

use crate::lint::pendulum::SMALLEST;
use crate::lint::{Advice, Approach, Both, DAMPING, Growth, Stiffness};
use crate::source::span::Source;

/// The lines for one function.
pub fn render(advice: &Advice, source: &Source) -> String {
    let (line, _) = source.line_column(advice.span.start);
    let mut text = format!("{} ({}), {}:{line}\n", advice.name, advice.kind, source.name);
    let mut say = |label: &str, what: String| text.push_str(&format!("  {label:<14}{what}\n"));
    let both = |both: Both<String>| match (both.random, both.near) {
        (Some(random), Some(near)) => Some(format!("{random} at random states, {near} near C = 0")),
        (Some(random), None) => Some(format!("{random} at random states")),
        (None, Some(near)) => Some(format!("{near} near C = 0")),
        (None, None) => None,
    };
    let Both { random, near } = advice.nonlinearity;
    if let Some(nonlinearity) = both(Both { random: random.map(percent), near: near.map(percent) }) {
        say("nonlinear", nonlinearity);
    }
    let Both { random, near } = advice.stiffness;
    if let Some(stiffness) = both(Both { random: random.map(definite), near: near.map(definite) }) {
        say("−∂F/∂X", stiffness);
    }
    let beyond = |stiffness: Option<Stiffness>| stiffness.and_then(|s| s.beyond).map(percent);
    if let Some(beyond) = both(Both { random: beyond(random), near: beyond(near) }) {
        say("beyond ks JᵀJ", beyond);
    }
    say(
        "damping",
        advice.damping.map_or("none".to_owned(), |damping| {
            let all = damping.states;
            let energy = match damping.active {
                0 if damping.idle == all => "does no work".to_owned(),
                0 => "dissipates".to_owned(),
                active => format!("brings in energy at {active} of {all} states"),
            };
            let symmetric = match damping.asymmetry {
                asymmetry if asymmetry < 1e-9 => "symmetric".to_owned(),
                asymmetry => format!("{} off symmetric", percent(asymmetry)),
            };
            let indefinite = match damping.indefinite {
                0 => String::new(),
                some => format!(", indefinite at {some} of {all}"),
            };
            let (rank, dofs) = damping.rank;
            format!("{energy}; ∂F/∂V {symmetric}{indefinite}, of rank {rank} of {dofs}")
        }),
    );
    // Singular places from one unrolled loop share a line: the smallest distance at C = 0, and their number.
    let mut places: Vec<(String, Option<f64>, usize)> = Vec::new();
    for (span, approach) in &advice.singular {
        let (line, column) = source.line_column(span.start);
        let what = source.text.get(span.start as usize..span.end as usize).unwrap_or_default();
        let what = what.split_whitespace().collect::<Vec<_>>().join(" ");
        let place = format!("{line}:{column} `{what}`: {}", growth(approach));
        match places.iter_mut().find(|(other, ..)| *other == place) {
            Some((_, satisfied, times)) => {
                let both = satisfied.iter().chain(&approach.satisfied).copied();
                *satisfied = both.reduce(f64::min);
                *times += 1;
            }
            None => places.push((place, approach.satisfied, 1)),
        }
    }
    for (place, satisfied, times) in places {
        let satisfied = satisfied.map_or(String::new(), |d| format!("; {d:.1e} from there where C = 0"));
        let times = if times == 1 { String::new() } else { format!(" ({times} times)") };
        say("singular", format!("{place}{satisfied}{times}"));
    }
    if let Some(steps) = &advice.steps {
        let list = |steps: &[Option<f64>]| {
            let all =
                steps.iter().zip(DAMPING).map(|(step, (label, _))| format!("{label} {}", seconds(*step)));
            all.collect::<Vec<_>>().join(", ")
        };
        match steps.full.as_slice() {
            [step] => say("stable step", seconds(*step)),
            steps => say("stable step", list(steps)),
        }
        if !steps.gauss_newton.is_empty() {
            say("  by ks JᵀJ", list(&steps.gauss_newton));
        }
    }
    text
}

/// A percentage with two digits.
pub(super) fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    match percent {
        percent if percent < 1e-6 => "0 %".to_owned(),
        percent if percent < 0.01 => "below 0.01 %".to_owned(),
        percent if percent < 9.95 => format!("{} %", (percent * 100.0).round() / 100.0),
        percent => format!("{percent:.0} %"),
    }
}

/// A time with two digits.
pub(super) fn seconds(step: Option<f64>) -> String {
    step.map_or(format!("below {SMALLEST:.4} s"), |step| {
        let digits = (1.0 - step.log10().floor()).max(0.0) as usize;
        format!("{step:.digits$} s")
    })
}

fn definite(stiffness: Stiffness) -> String {
    match stiffness.indefinite {
        (0, _) => "semi-definite".to_owned(),
        (some, all) => {
            let smallest = stiffness.smallest;
            let smallest =
                if smallest < -0.01 { format!("{smallest:.2}") } else { format!("{smallest:.0e}") };
            format!("indefinite at {some} of {all} (down to {smallest})")
        }
    }
}

/// The growth near a singular place, with d the distance from the place.
fn growth(approach: &Approach) -> String {
    let Some(Growth { force, stiffness, damping, damped_stiffness }) = approach.growth else {
        return "no motion was found that leads there while it acts".to_owned();
    };
    let sizes = [
        ("F", Some(force.max(0.0))),
        ("∂F/∂X", Some(stiffness.max(0.0))),
        ("∂F/∂V", damping),
        ("what damping adds to ∂F/∂X", damped_stiffness.map(|p| p.max(0.0))),
    ];
    let shown = sizes.into_iter().filter_map(|(name, p)| Some(format!("{name} {}", power(p?)?)));
    let shown: Vec<String> = shown.collect();
    if shown.is_empty() {
        "all stays bounded towards it".to_owned()
    } else {
        format!("towards it {}", shown.join(", "))
    }
}

/// The power of d, rounded to a multiple of one half; `None` if bounded.
fn power(p: f64) -> Option<String> {
    let halves = (2.0 * p).round() as i64;
    let written = |halves: i64| match (halves / 2, halves % 2) {
        (0, _) => "√d".to_owned(),
        (1, 0) => "d".to_owned(),
        (n, 0) => format!("d^{n}"),
        (n, _) => format!("d^{n}.5"),
    };
    match halves {
        0 => None,
        halves if halves > 0 => Some(format!("grows as 1/{}", written(halves))),
        halves => Some(format!("vanishes as {}", written(-halves))),
    }
}

/// The label of a warning about a singular place.
pub(super) fn label(approach: &Approach, at_zero: bool) -> String {
    let place = if at_zero { "C = 0 here; " } else { "" };
    format!("{place}{}", growth(approach))
}
