//! Reports as text: a table for people, JSON for programs.
//!
//! In: reports. Out: one line a kernel with its worst errors, and below it, where a check fails, what failed, by how much,
//! and the state that shows it; or one JSON object.

use super::report::{Comparison, Entry, Invariant, Report, Verdict};
use crate::outputs::{PARTS, Part};
use crate::states::Family;
use std::fmt::Write;

/// The columns before those of the results, behind them, and those of the invariants.
const HEADINGS: [&[&str]; 3] = [
    &["kernel", "check", "states", "singular"],
    &["near", "far", "of bound", "differences", "unresolved"],
    &["Σ force", "Σ torque", "turned", "dfdv", "dfdx"],
];

/// A table of many kernels, failures in full below it. `force`, `dfdx` and `dfdv` are the largest errors relative to the
/// largest entry at states of order one and stiff ones, `near` and `far` the same over all arrays at near-singular and far
/// states; `of bound` is the largest error relative to what rounding accounts for. Then the invariants: balance of forces
/// and torques, equivariance, symmetry of ∂F/∂V, symmetry of ∂F/∂X up to the torque.
pub fn table(reports: &[Report]) -> String {
    let compared = |part: &Part| reports.iter().any(|r| r.comparisons.iter().any(|c| c.array == *part));
    let parts: Vec<Part> = PARTS.iter().map(|row| row.part).filter(compared).collect();
    let [before, behind, physics] = HEADINGS;
    let names = before.iter().copied().chain(parts.iter().map(|part| part.name()));
    let names = names.chain(behind.iter().chain(physics).copied());
    let mut rows = vec![names.map(str::to_owned).collect::<Vec<String>>()];
    rows.extend(reports.iter().map(|report| line(report, &parts)));
    // Words stand to the left, numbers to the right.
    let words = rows[0].len() - physics.len();
    let mut text = columns(&rows, |column| !(2..words).contains(&column));
    for report in reports.iter().filter(|report| !report.passed) {
        text.push('\n');
        details(&mut text, report);
    }
    for report in reports {
        for family in report.coverage.iter().filter(|family| !family.is_covered()) {
            let _ = writeln!(
                text,
                "note: {}: family `{}` is not covered: of {} states {} are singular, {} unresolved",
                report.kernel,
                family.family,
                family.singular + family.checked,
                family.singular,
                family.unresolved
            );
        }
    }
    text
}

/// Rows of cells below each other; those of some columns stand to the left, others to the right.
pub(crate) fn columns(rows: &[Vec<String>], left: impl Fn(usize) -> bool) -> String {
    let count = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
            if left(column) { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        });
        text.push_str(cells.collect::<Vec<String>>().join("  ").trim_end());
        text.push('\n');
    }
    text
}

impl Report {
    /// This kernel's line under a heading, and what failed.
    pub fn table(&self) -> String {
        table(std::slice::from_ref(self))
    }

    /// The report as a JSON object.
    pub fn json(&self) -> String {
        object(self)
    }
}

fn size(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") }
}

/// `pass`, and what of it was not covered: `pass, near and far not covered`.
fn outcome(report: &Report) -> String {
    let names: Vec<&str> = report.not_covered().into_iter().map(short).collect();
    match names.as_slice() {
        _ if !report.passed => "FAIL".to_owned(),
        [] => "pass".to_owned(),
        [name] => format!("pass, {name} not covered"),
        [names @ .., last] => format!("pass, {} and {last} not covered", names.join(", ")),
    }
}

/// A family in a word.
fn short(family: Family) -> &'static str {
    match family {
        Family::Rest => "rest",
        Family::Identity => "identity",
        Family::NearSingular => "near",
        other => other.name(),
    }
}

fn line(report: &Report, parts: &[Part]) -> Vec<String> {
    let mut cells = vec![
        report.kernel.clone(),
        outcome(report),
        report.states().to_string(),
        report.singular().to_string(),
    ];
    let hard = |family| matches!(family, Family::NearSingular | Family::Far);
    let told = |error: Option<f64>| error.map_or_else(|| "-".to_owned(), size);
    cells.extend(parts.iter().map(|part| {
        let comparison = report.comparisons.iter().find(|c| c.array == *part);
        told(comparison.and_then(|c| c.relative(|family| !hard(family))))
    }));
    let missing = report.not_covered();
    for family in [Family::NearSingular, Family::Far] {
        let errors = report.comparisons.iter().filter_map(|c| c.relative(|of| of == family));
        cells.push(told(errors.reduce(f64::max).filter(|_| !missing.contains(&family))));
    }
    let worst = |c: &Comparison| c.worst.as_ref().map_or(0.0, Entry::ratio);
    let of_bound = report.comparisons.iter().map(worst).fold(0.0, f64::max);
    cells.push(if of_bound < 10.0 { format!("{of_bound:.2}") } else { size(of_bound) });
    let differences = &report.differences;
    cells.push(match differences.disagree {
        0 => format!("{} agree", differences.agree),
        n => format!("{n} disagree"),
    });
    cells.push(differences.unresolved.to_string());
    cells.extend(report.invariants.iter().map(physics));
    cells.extend(HEADINGS[2][report.invariants.len()..].iter().map(|_| "-".to_owned()));
    cells
}

/// An invariant in few words.
fn physics(invariant: &Invariant) -> String {
    let detail = invariant.detail.replace("at damping 0", "kd = 0").replace("along ", "");
    match invariant.verdict {
        Verdict::NotApplicable => "-".to_owned(),
        Verdict::Violated => "VIOLATED".to_owned(),
        verdict if detail.is_empty() => verdict.name().to_owned(),
        verdict => format!("{}: {detail}", verdict.name()),
    }
}

fn details(text: &mut String, report: &Report) {
    let what = match report.worst_failure() {
        Some(_) => "the kernel is not its source",
        None => "the kernel cannot be checked",
    };
    let _ = writeln!(text, "{}: {what}", report.kernel);
    for problem in &report.problems {
        let _ = writeln!(text, "  {problem}");
    }
    for comparison in report.comparisons.iter().filter(|c| c.failures > 0) {
        let _ = writeln!(
            text,
            "  {}: {} of {} entries differ from the exact oracle; the worst:",
            comparison.array, comparison.failures, comparison.entries
        );
        worst(text, comparison.worst.as_ref());
    }
    if report.differences.disagree > 0 {
        let _ = writeln!(
            text,
            "  differences of the kernel's own force contradict {} entries; the worst:",
            report.differences.disagree
        );
        worst(text, report.differences.worst.as_ref());
    }
    for invariant in report.invariants.iter().filter(|i| i.verdict == Verdict::Violated) {
        let _ = writeln!(text, "  {} is violated; the worst:", invariant.name);
        worst(text, invariant.worst.as_ref());
    }
    if let Some(entry) = report.worst_failure() {
        let _ =
            writeln!(text, "  the state that shows {} ({}, seed {}):", entry.name, entry.family, report.seed);
        for input in entry.inputs.to_string().lines() {
            let _ = writeln!(text, "    {input}");
        }
    }
}

fn worst(text: &mut String, entry: Option<&Entry>) {
    if let Some(e) = entry {
        let _ = writeln!(
            text,
            "    {}: expected {:?}, computed {:?}, error {:.1e}, rounding explains {:.1e} ({})",
            e.name, e.expected, e.computed, e.error, e.tolerance, e.family
        );
    }
}

/// Reports as a JSON object with one field, `kernels`.
pub fn json(reports: &[Report]) -> String {
    let objects: Vec<String> = reports.iter().map(object).collect();
    format!("{{\"kernels\": [{}]}}\n", objects.join(",\n"))
}

fn object(report: &Report) -> String {
    let coverage = report.coverage.iter().map(|c| {
        fields(&[
            ("family", string(c.family.name())),
            ("checked", c.checked.to_string()),
            ("singular", c.singular.to_string()),
            ("active", c.active.to_string()),
            ("unresolved", c.unresolved.to_string()),
            ("covered", c.is_covered().to_string()),
        ])
    });
    let comparisons = report.comparisons.iter().map(|c| {
        let relative =
            c.relative.iter().map(|(f, x)| (f.name(), x.map_or_else(|| "null".to_owned(), number)));
        let relative: Vec<(&str, String)> = relative.collect();
        fields(&[
            ("array", string(c.array.name())),
            ("entries", c.entries.to_string()),
            ("failures", c.failures.to_string()),
            ("relative_error", fields(&relative)),
            ("sharp_states", c.sharp.to_string()),
            ("worst", entry(c.worst.as_ref())),
        ])
    });
    let differences = fields(&[
        ("agree", report.differences.agree.to_string()),
        ("disagree", report.differences.disagree.to_string()),
        ("unresolved", report.differences.unresolved.to_string()),
        ("worst", entry(report.differences.worst.as_ref())),
    ]);
    let invariants = report.invariants.iter().map(|i| {
        fields(&[
            ("name", string(i.name)),
            ("verdict", string(i.verdict.name())),
            ("detail", string(&i.detail)),
            ("worst", entry(i.worst.as_ref())),
        ])
    });
    fields(&[
        ("name", string(&report.kernel)),
        ("passed", report.passed.to_string()),
        ("not_covered", array(report.not_covered().into_iter().map(|family| string(family.name())))),
        ("seed", report.seed.to_string()),
        ("problems", array(report.problems.iter().map(|p| string(p)))),
        ("states", array(coverage)),
        ("oracle", array(comparisons)),
        ("differences", differences),
        ("invariants", array(invariants)),
    ])
}

fn entry(entry: Option<&Entry>) -> String {
    let Some(e) = entry else { return "null".to_owned() };
    let inputs: Vec<(&str, String)> = e
        .inputs
        .0
        .iter()
        .map(|(name, values)| (name.as_str(), array(values.iter().map(|x| number(*x)))))
        .collect();
    fields(&[
        ("name", string(&e.name)),
        ("expected", number(e.expected)),
        ("computed", number(e.computed)),
        ("error", number(e.error)),
        ("tolerance", number(e.tolerance)),
        ("family", string(e.family.name())),
        ("inputs", fields(&inputs)),
    ])
}

fn fields(fields: &[(&str, String)]) -> String {
    let fields: Vec<String> =
        fields.iter().map(|(name, value)| format!("{}: {value}", string(name))).collect();
    format!("{{{}}}", fields.join(", "))
}

fn array(items: impl Iterator<Item = String>) -> String {
    format!("[{}]", items.collect::<Vec<_>>().join(", "))
}

/// A number; JSON has no infinities, so what is not finite is a string.
fn number(x: f64) -> String {
    if x.is_finite() { format!("{x:?}") } else { string(&x.to_string()) }
}

fn string(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => {
                quoted.push('\\');
                quoted.push(c);
            }
            c if c < ' ' => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
