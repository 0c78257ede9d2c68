//! Reports as text: a table for people, JSON for programs.
//!
//! In: reports. Out: one line per kernel with its worst errors; below, for every failed check, the failing
//! entries, their errors and the state; or a JSON object.

use crate::math::number::Precision;
use crate::model::outputs::{PARTS, Part};
use crate::sample::inputs::Inputs;
use crate::sample::states::Family;
use crate::verify::report::{Comparison, Entry, Invariant, Report, TextComparison, TextEntry, Verdict};
use std::fmt::Write;

/// The largest width of a table; longer names lose their middle.
const WIDTH: usize = 120;

/// With more outputs than this, all outputs share one column.
const MOST_PARTS: usize = 3;

/// The columns of a table.
struct Columns {
    parts: Vec<Part>,
    /// Whether each output has its own column.
    apart: bool,
    precisions: Vec<Precision>,
    /// Whether the table has columns for differences and invariants.
    physics: bool,
}

/// A table of kernels with a legend, followed by details of failures.
pub fn table(reports: &[Report]) -> String {
    let compared = |part: &Part| reports.iter().any(|r| r.comparisons.iter().any(|c| c.array == *part));
    let parts: Vec<Part> = PARTS.iter().map(|row| row.part).filter(compared).collect();
    let printed = |p: &Precision| reports.iter().any(|r| r.text.iter().any(|text| text.precision == *p));
    let columns = Columns {
        apart: parts.len() <= MOST_PARTS,
        parts,
        precisions: Precision::ALL.into_iter().filter(printed).collect(),
        physics: reports.iter().any(|report| !report.invariants.is_empty()),
    };
    let mut rows = vec![columns.headings()];
    rows.extend(reports.iter().map(|report| columns.line(report)));
    let rest: usize = (1..rows[0].len()).map(|column| 2 + width(&rows, column)).sum();
    for row in &mut rows {
        row[0] = shortened(&row[0], WIDTH.saturating_sub(rest).max(16));
    }
    // Text columns are left-aligned, number columns right-aligned.
    let last = rows[0].len() - usize::from(columns.physics);
    let mut text = self::columns(&rows, |column| !(2..last).contains(&column));
    if !reports.is_empty() {
        text.push('\n');
        columns.legend(&mut text);
    }
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
    for report in reports {
        branches(&mut text, report);
    }
    text
}

/// A name shortened to at most `most` characters.
fn shortened(name: &str, most: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= most {
        return name.to_owned();
    }
    let (before, behind) = (most / 2, most - most / 2 - 1);
    letters[..before].iter().chain(&['…']).chain(&letters[letters.len() - behind..]).collect()
}

fn width(rows: &[Vec<String>], column: usize) -> usize {
    rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)
}

/// One line per branch: the number of states at which each arm was active; then one line per arm that was
/// never active. Equal lines, which unrolled loops produce, are merged with their smallest numbers.
fn branches(text: &mut String, report: &Report) {
    let mut lines: Vec<(String, [usize; 2], [&str; 2], usize)> = Vec::new();
    for branch in &report.branches {
        let name = branch.name();
        match lines.iter_mut().find(|(other, ..)| *other == name) {
            Some((_, states, _, count)) => {
                *states = [states[0].min(branch.states[0]), states[1].min(branch.states[1])];
                *count += 1;
            }
            None => lines.push((name, branch.states, branch.arms, 1)),
        }
    }
    let lines: Vec<(String, [usize; 2], [&str; 2])> = lines
        .into_iter()
        .map(|(name, states, arms, count)| {
            (if count == 1 { name } else { format!("{name} (×{count})") }, states, arms)
        })
        .collect();
    if lines.is_empty() {
        return;
    }
    let arms =
        lines.iter().map(|(name, [x, y], [first, second])| format!("{name}: {first} {x}, {second} {y}"));
    let mut line = format!("branches of {}:", report.kernel);
    for (number, arm) in arms.enumerate() {
        if number > 0 {
            line.push(';');
        }
        if line.chars().count() + arm.chars().count() > WIDTH {
            let _ = writeln!(text, "{line}");
            line = "   ".to_owned();
        }
        line.push(' ');
        line.push_str(&arm);
    }
    let _ = writeln!(text, "{line}");
    for (name, states, arms) in lines {
        for arm in states.iter().zip(arms).filter(|(states, _)| **states == 0).map(|(_, arm)| arm) {
            let _ = writeln!(
                text,
                "note: {}: `{arm}` of {name} is not covered: no state was active there{}",
                report.kernel,
                if report.uncovered_allowed { ", which is allowed" } else { "" }
            );
        }
    }
}

/// Aligns rows of cells in columns; columns selected by `left` are left-aligned, others right-aligned.
pub(crate) fn columns(rows: &[Vec<String>], left: impl Fn(usize) -> bool) -> String {
    let count = rows.first().map_or(0, Vec::len);
    let widths: Vec<usize> = (0..count).map(|column| width(rows, column)).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
            let blank = " ".repeat(width - cell.chars().count());
            if left(column) { format!("{cell}{blank}") } else { format!("{blank}{cell}") }
        });
        text.push_str(cells.collect::<Vec<String>>().join("  ").trim_end());
        text.push('\n');
    }
    text
}

impl Report {
    /// The table of this kernel alone, with details of failures.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn table(&self) -> String {
        table(std::slice::from_ref(self))
    }

    /// The report as a JSON object.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn json(&self) -> String {
        object(self)
    }
}

fn size(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") }
}

impl Columns {
    fn headings(&self) -> Vec<String> {
        let parts: Vec<&str> =
            if self.apart { self.parts.iter().map(|part| part.name()).collect() } else { vec!["outputs"] };
        let text: &[&str] = match self.precisions.as_slice() {
            [] => &[],
            [_] => &["of text"],
            _ => &["of text", "f32"],
        };
        let physics: &[&str] = if self.physics { &["differences", "invariants"] } else { &[] };
        let names = ["kernel", "check", "states"].into_iter().chain(parts).chain(["hard", "of bound"]);
        names.chain(text.iter().chain(physics).copied()).map(str::to_owned).collect()
    }

    fn line(&self, report: &Report) -> Vec<String> {
        let outcome = match (report.passed, report.not_covered().is_empty()) {
            (false, _) => "FAIL",
            (true, true) => "pass",
            (true, false) => "pass*",
        };
        let mut cells = vec![report.kernel.clone(), outcome.to_owned(), report.states().to_string()];
        let cell = |error: Option<f64>| error.map_or_else(|| "-".to_owned(), size);
        let easy = |part: &Part| {
            let comparison = report.comparisons.iter().find(|c| c.array == *part);
            comparison.and_then(|c| c.relative(|family| !is_hard(family)))
        };
        if self.apart {
            cells.extend(self.parts.iter().map(|part| cell(easy(part))));
        } else {
            cells.push(cell(self.parts.iter().filter_map(easy).reduce(f64::max)));
        }
        let missing = report.not_covered();
        let hard = |family| is_hard(family) && !missing.contains(&family);
        cells.push(cell(report.comparisons.iter().filter_map(|c| c.relative(hard)).reduce(f64::max)));
        let worst = |c: &Comparison| c.worst.as_ref().map_or(0.0, Entry::ratio);
        cells.push(quotient(report.comparisons.iter().map(worst).fold(0.0, f64::max)));
        cells.extend(self.precisions.iter().map(|precision| {
            let text = report.text.iter().find(|text| text.precision == *precision);
            let worst = text.and_then(|text| text.worst.as_ref());
            worst.map_or_else(|| "-".to_owned(), |worst| quotient(worst.ratio))
        }));
        if self.physics {
            let differences = &report.differences;
            cells.push(match differences.disagree {
                0 => differences.agree.to_string(),
                n => format!("{n} disagree"),
            });
            let mut symbols: Vec<&str> = report.invariants.iter().map(symbol).collect();
            symbols.resize(INVARIANTS.len(), "·");
            cells.push(symbols.join(" "));
        }
        cells
    }

    /// Explains the columns.
    fn legend(&self, text: &mut String) {
        let names: Vec<&str> = self.parts.iter().map(|part| part.name()).collect();
        let names = if self.apart { names.join(", ") } else { "outputs".to_owned() };
        let mut lines = vec![
            format!("{names}: largest error over the largest entry, at states of order one and stiff ones"),
            "hard: the same over all outputs at near-singular and far states; -: no state tells".to_owned(),
            "of bound: largest error over what rounding explains; above 1 fails".to_owned(),
        ];
        if !self.precisions.is_empty() {
            let names: Vec<&str> = self.precisions.iter().map(|precision| precision.name()).collect();
            lines.push(format!(
                "of text: error of the printed kernel in {} over that of the source as written, less 8 ulp; above 4 fails",
                names.join(", then ")
            ));
        }
        if self.physics {
            lines.push("differences: entries that central differences confirm".to_owned());
            lines.push(format!("invariants: {}", INVARIANTS.join(", ")));
            lines.push(
                "  + holds, 0 holds at damping 0, ~ holds along some axes, · not invariant or not asked, ! violated"
                    .to_owned(),
            );
        }
        lines.push("pass*: a family of states is not covered, see the notes".to_owned());
        for line in lines {
            let _ = writeln!(text, "{line}");
        }
    }
}

/// The invariants, in the order of their symbols in the table.
const INVARIANTS: [&str; 5] =
    ["force balance", "torque balance", "rotation equivariance", "dfdv symmetric", "dfdx symmetric"];

fn is_hard(family: Family) -> bool {
    family == Family::Far || family.is_near()
}

fn quotient(x: f64) -> String {
    if x < 10.0 { format!("{x:.2}") } else { size(x) }
}

/// The verdict on an invariant as one character.
fn symbol(invariant: &Invariant) -> &'static str {
    match invariant.verdict {
        Verdict::NotApplicable | Verdict::NotInvariant => "·",
        Verdict::Violated => "!",
        Verdict::Holds if invariant.detail.is_empty() => "+",
        Verdict::Holds if invariant.detail == "at damping 0" => "0",
        Verdict::Holds => "~",
    }
}

fn details(text: &mut String, report: &Report) {
    let is_worse = report.text.iter().any(|text| text.failures() > 0);
    let what = match (report.worst_failure(), report.problems.is_empty()) {
        (Some(_), _) => "the kernel is not its source",
        (None, true) if is_worse => "the kernel is worse than its source as written",
        (None, _) => "the kernel cannot be checked",
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
    for comparison in report.text.iter().filter(|text| text.failures() > 0) {
        worse(text, comparison, report.seed);
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

/// The details of a comparison in which the kernel is worse than the source, with the state.
fn worse(text: &mut String, comparison: &TextComparison, seed: u64) {
    let TextComparison { precision, blocks, .. } = comparison;
    let lost: usize = comparison.broken.values().map(|broken| broken.lost).sum();
    let _ = write!(
        text,
        "  in {precision} {} of {blocks} blocks are worse than the source as written",
        comparison.failures()
    );
    let _ = match lost {
        0 => writeln!(text, "; the worst:"),
        _ => writeln!(text, ", {lost} of them not finite where the source is; the worst:"),
    };
    let Some(e) = &comparison.worst else { return };
    let _ = writeln!(
        text,
        "    {}: exact {:?}, kernel {:?}, source {:?} ({})",
        e.name, e.exact, e.kernel, e.text, e.family
    );
    let _ = writeln!(
        text,
        "    largest error of {}: kernel {:.1e}, source {:.1e}, allowed 4 times that and {:.1e}",
        e.block, e.error, e.text_error, e.allowed
    );
    let _ = writeln!(text, "  the state that shows it ({}, seed {seed}):", e.family);
    for input in e.inputs.to_string().lines() {
        let _ = writeln!(text, "    {input}");
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
    let branches = report.branches.iter().map(|b| {
        let arm = |k: usize| fields(&[("arm", string(b.arms[k])), ("states", b.states[k].to_string())]);
        fields(&[
            ("branch", string(&b.what)),
            ("line", b.line.map_or_else(|| "null".to_owned(), |line| line.to_string())),
            ("arms", array([arm(0), arm(1)].into_iter())),
            ("covered", (!b.is_uncovered()).to_string()),
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
    let written = report.text.iter().map(|text| {
        let broken = text.broken.iter().map(|((part, family), broken)| {
            fields(&[
                ("array", string(part.name())),
                ("family", string(family.name())),
                ("blocks", broken.blocks.to_string()),
                ("not_finite", broken.lost.to_string()),
                ("ratio", number(broken.ratio)),
                ("units", number(broken.units)),
            ])
        });
        fields(&[
            ("precision", string(text.precision.name())),
            ("states", text.states.to_string()),
            ("blocks", text.blocks.to_string()),
            ("failures", text.failures().to_string()),
            ("broken", array(broken)),
            ("worst", text.worst.as_ref().map_or_else(|| "null".to_owned(), text_entry)),
        ])
    });
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
        ("branches", array(branches)),
        ("oracle", array(comparisons)),
        ("differences", differences),
        ("text", array(written)),
        ("invariants", array(invariants)),
    ])
}

fn entry(entry: Option<&Entry>) -> String {
    let Some(e) = entry else { return "null".to_owned() };
    fields(&[
        ("name", string(&e.name)),
        ("expected", number(e.expected)),
        ("computed", number(e.computed)),
        ("error", number(e.error)),
        ("tolerance", number(e.tolerance)),
        ("family", string(e.family.name())),
        ("inputs", inputs(&e.inputs)),
    ])
}

fn text_entry(e: &TextEntry) -> String {
    fields(&[
        ("name", string(&e.name)),
        ("block", string(&e.block)),
        ("exact", number(e.exact)),
        ("kernel", number(e.kernel)),
        ("text", number(e.text)),
        ("error", number(e.error)),
        ("text_error", number(e.text_error)),
        ("allowed", number(e.allowed)),
        ("units", number(e.units)),
        ("ratio", number(e.ratio)),
        ("family", string(e.family.name())),
        ("inputs", inputs(&e.inputs)),
    ])
}

fn inputs(inputs: &Inputs) -> String {
    let values = |values: &[f64]| array(values.iter().map(|x| number(*x)));
    let inputs: Vec<(&str, String)> =
        inputs.0.iter().map(|(name, list)| (name.as_str(), values(list))).collect();
    fields(&inputs)
}

fn fields(fields: &[(&str, String)]) -> String {
    let fields: Vec<String> =
        fields.iter().map(|(name, value)| format!("{}: {value}", string(name))).collect();
    format!("{{{}}}", fields.join(", "))
}

fn array(items: impl Iterator<Item = String>) -> String {
    format!("[{}]", items.collect::<Vec<_>>().join(", "))
}

/// A JSON number; infinities and NaN are strings, because JSON has no such numbers.
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
