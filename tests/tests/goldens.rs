//! The output of every stage for small force files, as snapshots.
//!
//! An input is a file `tests/golden/NAME.rs` that shows one behaviour; its first line lists the stages to
//! snapshot: `// stages: graph, derivative, c`, its second may name a layout, lanes and `prepare`. The name of an
//! optimiser pass means the scalar graph after the pass.
//! To add a case, add a file. To accept a change, run
//!
//! ```text
//! INSTA_UPDATE=always cargo test -p forcec-tests --test goldens
//! ```
//!
//! and read the diff. Without the variable the test writes nothing (`.cargo/config.toml`), and fails if a snapshot differs.

use forcec::internals::compile::{Compiled, Request, Stages, compile};
use forcec::internals::derive::derive;
use forcec::internals::emit;
use forcec::internals::kernel::{File, Precision, Target};
use forcec::internals::optimize::{LOWER, PASSES};
use forcec::internals::show::formula::Dialect;
use forcec::internals::show::graphs;
use forcec::internals::source::span::Source;
use forcec::{Layout, Plan};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const STAGES: [&str; 9] =
    ["warnings", "ast", "graph", "derivative", "optimized", "schedule", "header", "c", "rust"];

/// The force files in a folder of the repository, in sorted order.
fn force_files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
    paths.sort();
    paths
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

fn compiled(path: &Path) -> Compiled {
    let name = path.file_name().unwrap().to_string_lossy();
    let source = Source::new(name, std::fs::read_to_string(path).unwrap());
    let request = request(&source.text);
    compile(&source, &|_| true, request).unwrap_or_else(|diagnostics| panic!("{diagnostics}"))
}

/// The request in the second line of an input, if any: `// layout: packed, 4`, with a number of instances.
fn request(text: &str) -> Request {
    let line = text.lines().nth(1).and_then(|line| line.strip_prefix("// layout: "));
    let Some((layout, lanes)) = line.and_then(|line| line.split_once(", ")) else {
        return Request::default();
    };
    let (lanes, prepare) = lanes.strip_suffix(", prepare").map_or((lanes, false), |lanes| (lanes, true));
    let layout = Layout::named(layout).expect("a layout");
    Request { layout, lanes: lanes.parse().expect("a number of instances"), prepare, ..Request::default() }
}

/// The stages an input asks for in its first line.
fn wanted(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap();
    let first = text.lines().next().unwrap_or_default();
    let list = first.strip_prefix("// stages: ").unwrap_or_else(|| panic!("{}: no stages", path.display()));
    let stages: Vec<String> = list.split(", ").map(str::to_owned).collect();
    for stage in &stages {
        let known = STAGES.contains(&stage.as_str()) || up_to(stage).is_some();
        assert!(known, "{}: no stage `{stage}`", path.display());
    }
    stages
}

/// The passes of the optimiser up to this one.
fn up_to(pass: &str) -> Option<Plan> {
    let names: Vec<&str> = [LOWER].into_iter().chain(PASSES.iter().map(|pass| pass.name)).collect();
    let place = names.iter().position(|name| *name == pass)?;
    Plan::from(forcec::Effort::Default).with_passes(names[..=place].iter().copied()).ok()
}

/// One stage of every force function in a file.
fn stage(compiled: &Compiled, stem: &str, stage: &str) -> String {
    let each = |show: &dyn Fn(&Stages) -> String| {
        let parts = compiled.functions.iter().map(|function| match compiled.functions.len() {
            1 => show(function),
            _ => format!("== {}\n{}\n", function.kernel.name, show(function)),
        });
        parts.collect::<String>()
    };
    let emitted = |target: Target, ending: &str| {
        let file = File {
            stem: stem.to_owned(),
            docs: compiled.docs.clone(),
            kernels: compiled.functions.iter().map(|function| function.kernel.clone()).collect(),
            precisions: vec![Precision::F64],
        };
        let name = format!("{}.{ending}", file.name());
        let file = emit::emit(&file, target).into_iter().find(|file| file.name == name);
        file.expect("the target writes it").text
    };
    match stage {
        "warnings" => {
            let warnings = compiled.warnings.clone();
            forcec::internals::source::diagnostic::Diagnostics::new(compiled.source.clone(), warnings)
                .to_string()
        }
        "ast" => each(&|function| function.ast.clone()),
        "graph" => each(&|function| function.definition.graph.to_string()),
        "derivative" => each(&|function| {
            graphs::derivative(
                &mut derive(&function.definition, &function.outputs(), function.formulation),
                Dialect::Text,
            )
        }),
        "optimized" => each(&|function| function.program.to_string()),
        "schedule" => each(&|function| function.kernel.schedule.to_string()),
        "header" => emitted(Target::C, "h"),
        "c" => emitted(Target::C, "c"),
        "rust" => emitted(Target::Rust, "rs"),
        pass => {
            let plan = up_to(pass).expect("checked when it was read");
            let compiled = compile(&compiled.source, &|_| true, plan).expect("it compiled before");
            let programs = compiled.functions.iter().map(|function| function.program.to_string());
            programs.collect()
        }
    }
}

fn assert_snapshot(name: &str, text: &str) {
    insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
        insta::assert_snapshot!(name, text);
    });
}

#[test]
fn stages() {
    let mut expected: BTreeSet<String> = ["library_operations".to_owned()].into();
    let mut failed = Vec::new();
    for path in force_files("golden") {
        let (stem, compiled) = (stem(&path), compiled(&path));
        for name in wanted(&path) {
            let snapshot = format!("{stem}.{name}");
            let text = stage(&compiled, &stem, &name);
            // Every difference is shown before the test fails.
            if std::panic::catch_unwind(|| assert_snapshot(&snapshot, &text)).is_err() {
                failed.push(snapshot.clone());
            }
            expected.insert(snapshot);
        }
    }
    assert!(failed.is_empty(), "these differ: {}", failed.join(", "));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots");
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        // Those of other tests carry the name of the test before two underscores.
        let known =
            name.contains("__") || name.strip_suffix(".snap").is_none_or(|name| expected.contains(name));
        assert!(known, "`{name}` belongs to no input: remove it");
    }
}

/// Exact, so that no change to the count of any kernel goes unseen.
#[test]
fn library_operations() {
    let mut table = String::new();
    let mut line = |cells: [&str; 8]| {
        table.push_str(&format!("{:<24}", cells[0]));
        cells[1..].iter().for_each(|cell| table.push_str(&format!("{cell:>6}")));
        table.push('\n');
    };
    line(["kernel", "add", "mul", "div", "sqrt", "call", "neg", "total"]);
    for path in force_files("../constraints") {
        for function in compiled(&path).functions {
            let ops = function.kernel.schedule.operations();
            let counts = [ops.add, ops.mul, ops.div, ops.sqrt, ops.call, ops.neg, ops.total()];
            let [add, mul, div, sqrt, call, neg, total] = counts.map(|count| count.to_string());
            line([&function.kernel.name, &add, &mul, &div, &sqrt, &call, &neg, &total]);
        }
    }
    assert_snapshot("library_operations", &table);
}
