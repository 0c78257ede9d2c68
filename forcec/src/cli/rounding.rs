//! `forcec check --rounding`: bounds on rounding errors, with observed errors.
//!
//! In: kernels. Out: a table, or JSON, with one line for each kernel, precision and output.

use crate::kernel::{Kernel, Precision};
use crate::rounding::observed::{Comparison, compare};
use crate::rounding::upward;
use crate::sample::states::Family;
use crate::verify::render::columns;
use serde_json::{Value, json};

/// Groups of columns: ordinary and stiff states, near-singular states, far states.
const GROUPS: [(&str, &[Family]); 3] = [
    ("", &[Family::Random, Family::Rest, Family::Identity, Family::Stiff]),
    ("near", &[Family::NearSingular]),
    ("far", &[Family::Far]),
];

/// One output of one kernel, with a comparison per group.
struct Line {
    kernel: String,
    precision: Precision,
    groups: Vec<Comparison>,
}

fn lines(kernels: &[&Kernel]) -> Vec<Line> {
    let mut lines = Vec::new();
    for kernel in kernels {
        for precision in [Precision::F64, Precision::F32] {
            let groups = GROUPS.map(|(_, families)| compare(kernel, precision, families));
            lines.extend((0..groups[0].len()).map(|part| Line {
                kernel: kernel.name.clone(),
                precision,
                groups: groups.iter().map(|group| group[part]).collect(),
            }));
        }
    }
    // An output that is always zero has no rounding error.
    let zero = |line: &Line| line.groups.iter().all(|c| (c.bound, c.unbounded) == (0.0, 0));
    lines.retain(|line| !zero(line));
    lines
}

/// The table as text.
pub(super) fn table(kernels: &[&Kernel]) -> String {
    let mut rows = vec![["kernel", "real", "result"].map(str::to_owned).to_vec()];
    rows[0].extend(
        GROUPS
            .iter()
            .flat_map(|(name, _)| [format!("{name} bound").trim().to_owned(), "observed".to_owned()]),
    );
    rows[0].extend(["of bound", "no bound"].map(str::to_owned));
    for line in lines(kernels) {
        let mut row =
            vec![line.kernel, line.precision.name().to_owned(), line.groups[0].part.name().to_owned()];
        for group in &line.groups {
            let shown = group.states > group.unbounded;
            row.extend([group.bound, group.observed].map(|x| if shown { upward(x) } else { "-".to_owned() }));
        }
        let quotient = line.groups.iter().map(|group| group.quotient).fold(0.0, f64::max);
        row.push(format!("{quotient:.2}"));
        let count = |of: fn(&Comparison) -> usize| line.groups.iter().map(of).sum::<usize>();
        row.push(format!("{} of {}", count(|c| c.unbounded), count(|c| c.states)));
        rows.push(row);
    }
    columns(&rows, |column| column < 3)
}

/// The table as JSON.
pub(super) fn json(kernels: &[&Kernel]) -> Value {
    let group = |(name, comparison): (&str, &Comparison)| {
        json!({
            "states": if name.is_empty() { "ordinary" } else { name },
            "bound": comparison.bound,
            "observed": comparison.observed,
            "quotient": comparison.quotient,
            "compared": comparison.states,
            "unbounded": comparison.unbounded,
        })
    };
    let lines = lines(kernels).into_iter().map(|line| {
        let names = GROUPS.iter().map(|(name, _)| *name);
        json!({
            "kernel": line.kernel,
            "real": line.precision.name(),
            "result": line.groups[0].part.name(),
            "groups": names.zip(&line.groups).map(group).collect::<Vec<Value>>(),
        })
    });
    Value::Array(lines.collect())
}
