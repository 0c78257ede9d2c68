//! `forcec stats`: operations, lines, non-zeros and compile time of every kernel.

use crate::cli::{Input, Outcome, print};
use crate::compile::{self, Request, Stages};
use crate::driver::scene::Scene;
use crate::emit::emit;
use crate::kernel::{File, Precision, Target};
use crate::layout::Layout;
use crate::options::plan::Plan;
use crate::source::span::Source;
use crate::verify::render::columns;
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
        if let Some(path) = &self.input.scene {
            return self.scene(&self.input.scene(path, false)?);
        }
        let units = self.input.compile(false)?;
        let functions: Vec<&Stages> = units.iter().flat_map(|unit| &unit.compiled.functions).collect();
        if self.json {
            let kernels: Vec<Value> = functions.iter().map(|function| row_json(function)).collect();
            return print(&format!("{:#}\n", json!({ "kernels": kernels })));
        }
        let rows: Vec<Vec<String>> = functions.iter().map(|function| row(function)).collect();
        print(&table(&COLUMNS, rows))
    }

    /// Compares the kernels of a scene with full kernels, and lists functions without a kernel.
    fn scene(&self, scene: &Scene) -> Outcome {
        let functions: Vec<&Stages> = scene.units.iter().flat_map(|unit| &unit.compiled.functions).collect();
        let full: Vec<Option<(usize, usize)>> = costs_of_full(scene);
        if self.json {
            let kernel = |(function, full): (&&Stages, &Option<(usize, usize)>)| {
                let mut row = row_json(function);
                row["name"] = json!(function.kernel.name);
                row["function"] = json!(function.definition.name);
                row["entries"] = json!(function.kernel.schedule.entries());
                row["full"] = json!(full.map(|(ops, entries)| json!({ "ops": ops, "entries": entries })));
                row
            };
            let kernels: Vec<Value> = functions.iter().zip(&full).map(kernel).collect();
            return print(&format!("{:#}\n", json!({ "kernels": kernels, "left_out": scene.left_out })));
        }
        let line = |name: &str, (ops, entries): (usize, usize), full: Option<(usize, usize)>| {
            let of = |full: Option<usize>| full.map_or_else(|| "-".to_owned(), |full| full.to_string());
            let change = full.map_or_else(|| "-".to_owned(), |(full, _)| change(ops, full));
            let (full_ops, full_entries) = (full.map(|full| full.0), full.map(|full| full.1));
            vec![
                name.to_owned(),
                ops.to_string(),
                of(full_ops),
                change,
                entries.to_string(),
                of(full_entries),
            ]
        };
        let mut rows = Vec::new();
        let (mut own, mut all) = ((0, 0), (0, 0));
        for (function, full) in functions.iter().zip(full) {
            let cost = cost(function);
            own = (own.0 + cost.0, own.1 + cost.1);
            all = full.map_or(all, |full| (all.0 + full.0, all.1 + full.1));
            rows.push(line(&function.kernel.name, cost, full));
        }
        rows.push(line("total", own, Some(all)));
        let mut text = table(&["kernel", "operations", "of full", "change", "outputs", "of full"], rows);
        if functions.iter().any(|function| function.kernel.layout == Layout::System) {
            text.push_str("\na kernel of the layout `system` also makes a step's matrix and impulse of F, dF/dX and dF/dV, which the full kernel leaves to others\n");
        }
        if scene.again > 0 {
            text.push_str(&format!("\nasked for again, and written once: {}\n", scene.again));
        }
        if !scene.left_out.is_empty() {
            text.push_str(&format!("\nforce functions left out: {}\n", scene.left_out.join(", ")));
        }
        print(&text)
    }
}

/// The costs of a scene's full kernels, in the same mode; `None` for duplicates.
fn costs_of_full(scene: &Scene) -> Vec<Option<(usize, usize)>> {
    let kernels = scene.units.iter().flat_map(|unit| {
        unit.compiled.functions.iter().map(|function| (&unit.compiled.source, &function.definition.name))
    });
    let cost = |((source, name), plan): ((&Source, &String), &Option<Plan>)| {
        let full = Request { plan: (*plan)?, settled: true, ..Request::default() };
        let compiled = compile::compile(source, &|own| own == name, full).ok()?;
        compiled.functions.first().map(cost)
    };
    kernels.zip(&scene.full).map(cost).collect()
}

/// The operations of a kernel, and the number of entries that it writes.
fn cost(function: &Stages) -> (usize, usize) {
    let schedule = &function.kernel.schedule;
    (schedule.operations().total(), schedule.entries())
}

/// The relative difference in percent.
fn change(cost: usize, full: usize) -> String {
    match full {
        0 => "-".to_owned(),
        _ => match (100.0 * (cost as f64 / full as f64 - 1.0)).round() {
            0.0 => "0 %".to_owned(),
            less if less < 0.0 => format!("−{} %", -less),
            more => format!("+{more} %"),
        },
    }
}

/// Rows below headings, with a left-aligned first column.
fn table(headings: &[&str], mut rows: Vec<Vec<String>>) -> String {
    rows.insert(0, headings.iter().map(|&heading| heading.to_owned()).collect());
    columns(&rows, |column| column == 0)
}

/// The number of lines in the C source of a kernel in double precision.
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
