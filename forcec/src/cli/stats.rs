//! `forcec stats`: operations, lines, non-zeros and compile time of every kernel.

use super::{Input, Outcome, print};
use crate::compile::Stages;
use crate::kernel::{File, Precision, Target};
use crate::targets::emit;
use serde_json::{Value, json};

#[derive(clap::Args)]
pub(super) struct Stats {
    #[command(flatten)]
    input: Input,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

const COLUMNS: [&str; 11] =
    ["kernel", "add", "mul", "div", "sqrt", "call", "neg", "total", "lines", "non-zero", "ms"];

impl Stats {
    pub(super) fn run(self) -> Outcome {
        let units = self.input.compile()?;
        let functions: Vec<&Stages> = units.iter().flat_map(|unit| &unit.compiled.functions).collect();
        if self.json {
            let kernels: Vec<Value> = functions.iter().map(|function| row_json(function)).collect();
            return print(&format!("{:#}\n", json!({ "kernels": kernels })));
        }
        let rows: Vec<Vec<String>> = functions.iter().map(|function| row(function)).collect();
        let width =
            |k: usize| rows.iter().map(|row| row[k].len()).chain([COLUMNS[k].len()]).max().unwrap_or(0);
        let widths: Vec<usize> = (0..COLUMNS.len()).map(width).collect();
        let line = |cells: &mut dyn Iterator<Item = &str>| {
            let mut text = String::new();
            for (k, cell) in cells.enumerate() {
                let width = widths[k];
                text.push_str(&if k == 0 { format!("{cell:<width$}") } else { format!("  {cell:>width$}") });
            }
            text + "\n"
        };
        let mut text = line(&mut COLUMNS.into_iter());
        for row in &rows {
            text.push_str(&line(&mut row.iter().map(String::as_str)));
        }
        print(&text)
    }
}

/// Lines of the C source of a kernel in double precision, and its entries that are not zero.
fn lines(function: &Stages) -> usize {
    let file = File {
        stem: function.kernel.name.clone(),
        docs: Vec::new(),
        kernels: vec![function.kernel.clone()],
        precisions: vec![Precision::F64],
    };
    emit(&file, Target::C).iter().filter(|f| f.name.ends_with(".c")).map(|f| f.text.lines().count()).sum()
}

fn row(function: &Stages) -> Vec<String> {
    let schedule = &function.kernel.schedule;
    let ops = schedule.operations();
    let numbers = [
        ops.add,
        ops.mul,
        ops.div,
        ops.sqrt,
        ops.call,
        ops.neg,
        ops.total(),
        lines(function),
        schedule.nonzero,
    ];
    let mut row = vec![function.kernel.name.clone()];
    row.extend(numbers.iter().map(ToString::to_string));
    row.push(format!("{:.1}", function.time.as_secs_f64() * 1e3));
    row
}

fn row_json(function: &Stages) -> Value {
    let schedule = &function.kernel.schedule;
    let ops = schedule.operations();
    json!({
        "name": function.kernel.name,
        "ops": {
            "add": ops.add, "mul": ops.mul, "div": ops.div, "sqrt": ops.sqrt, "call": ops.call, "neg": ops.neg,
            "total": ops.total(),
        },
        "once": function.kernel.once().map(|once| once.schedule.operations().total()),
        "prepared": function.kernel.once().map(|once| once.values()),
        "lines": lines(function),
        "non_zeros": schedule.nonzero,
        "distinct": schedule.distinct,
        "outputs": function.program.outputs().count(),
        "compile_ms": function.time.as_secs_f64() * 1e3,
    })
}
