//! Combinations of all options: a covering array over the table of options, applied to force functions of
//! this repository. The kernels are compiled by every available compiler with all warnings denied, run, and
//! compared with the dense kernel.
//!
//! Input: a selection of functions and a work folder. Output: one text per failure. An option added to the
//! table becomes part of the array automatically.

use crate::cases::{misses, try_cases};
use crate::covering::covering;
use crate::{folder, parallel, pipe};
use forcec::internals::compile::{Request, Stages, compile_file};
use forcec::internals::emit;
use forcec::internals::kernel::{File, Precision, Target};
use forcec::internals::model::outputs::Axis;
use forcec::internals::options::{Choice, OPTIONS, OptionRow, Takes};
use forcec::internals::source::span::Source;
use forcec::internals::syntax::ast;
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{Family, Subject as Probed};
use forcec::internals::{check, syntax};
use forcec::{Effort, Layout, Part};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Flags of the C compilers.
pub const STRICT: [&str; 8] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wshadow",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Werror",
];

/// Number of states per kernel and precision.
const STATES: usize = 5;

/// Factor on the tolerance of the oracle's cases, because modes round differently.
const SLACK: f64 = 10.0;

/// A value of an option.
#[derive(Clone, Debug)]
enum Level {
    /// The option is absent.
    Absent,
    /// These words of the option.
    Words(Vec<&'static str>),
    /// The last body.
    LastBody,
    /// The first parameter is set to the value in a state.
    First,
    /// The first parameter that accepts two is set to two in every entry.
    Two,
    /// All parameters are set to the values in a state.
    All,
}

/// The tested levels of an option.
fn levels(row: &OptionRow) -> Vec<Level> {
    let mut levels = vec![Level::Absent];
    let values = (row.values)();
    match row.takes {
        Takes::Nothing => levels.push(Level::Words(Vec::new())),
        Takes::One | Takes::Some => levels.extend(values.iter().map(|value| Level::Words(vec![value]))),
        Takes::Names => levels.push(Level::LastBody),
        Takes::Numbers => levels.extend([Level::First, Level::Two, Level::All]),
    }
    if row.takes == Takes::Some {
        levels.push(Level::Words(values));
    }
    let plain = |level: &Level| match level {
        Level::Words(words) => {
            let choice = row.read(words).unwrap_or_else(|wrong| panic!("{}: {}", row.name, wrong.message));
            Request::default().with([&choice]) == Request::default()
        }
        _ => false,
    };
    levels.retain(|level| !plain(level));
    levels
}

/// A force function on which rows are tested.
pub struct Subject {
    /// Name of the function, including the name of the file.
    pub name: String,
    stem: String,
    function: String,
    tree: ast::File,
    last_body: Option<String>,
    /// For each parameter the name, the value at a state, and whether the value two is valid for every entry.
    parameters: Vec<(String, Vec<f64>, bool)>,
    multipliers: bool,
    rows: bool,
}

/// The force functions in folders of this repository that a predicate selects by name and by number of graph
/// nodes.
pub fn subjects(folders: &[&str], wanted: &(dyn Fn(&str, usize) -> bool + Sync)) -> Vec<Subject> {
    let mut paths: Vec<PathBuf> = Vec::new();
    for name in folders {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
        let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        let mut own: Vec<PathBuf> =
            entries.map(|entry| entry.expect("a folder can be read").path()).collect();
        own.retain(|path| path.extension().is_some_and(|extension| extension == "rs"));
        own.sort();
        paths.extend(own);
    }
    let subjects = parallel(paths, |path| {
        let text = std::fs::read_to_string(&path).expect("a force file can be read");
        let stem = path.file_stem().expect("a file has a name").to_string_lossy().into_owned();
        let tree = syntax::parse(&Source::new(format!("{stem}.rs"), text)).unwrap_or_else(|e| panic!("{e}"));
        let mut definitions = check::check(&tree).unwrap_or_else(|e| panic!("{e}")).definitions;
        definitions.retain(|own| wanted(&format!("{stem}::{}", own.name), own.graph.len()));
        let chosen = |name: &str| definitions.iter().any(|own| own.name == name);
        let compiled = compile_file(&tree, &chosen, Request { settled: true, ..Effort::Quick.into() });
        let compiled = compiled.unwrap_or_else(|errors| panic!("{errors}"));
        let subject =
            |(stages, definition): (&Stages, &forcec::internals::vector::definition::Definition)| {
                let signature = &stages.program.signature;
                let probed = Probed { source: &stages.source, program: &stages.program };
                let state = Probe::new(&probed).draw(Family::Random, 3, 0);
                let fields = signature.bodies.iter().flat_map(|body| body.kind.row().fields);
                let mut at: usize = fields.map(|field| field.length as usize).sum();
                let parameter = |parameter: &forcec::internals::model::bodies::Parameter| {
                    let length = parameter.ty.length() as usize;
                    at += length;
                    let any = parameter.ty != forcec::internals::model::bodies::ParameterType::Quaternion;
                    (parameter.name.clone(), state[at - length..at].to_vec(), any)
                };
                Subject {
                    name: format!("{stem}::{}", definition.name),
                    stem: stem.clone(),
                    function: definition.name.clone(),
                    tree: tree.clone(),
                    last_body: signature
                        .bodies
                        .last()
                        .filter(|_| signature.bodies.len() > 1)
                        .map(|b| b.name.clone()),
                    parameters: signature.parameters.iter().map(parameter).collect(),
                    multipliers: definition.law.has_multipliers(),
                    rows: definition.law.rows() > 0,
                }
            };
        compiled.functions.iter().zip(&definitions).map(subject).collect::<Vec<Subject>>()
    });
    subjects.into_iter().flatten().collect()
}

impl Subject {
    /// The choice that a level of an option means for this function; `None` if the level does not apply to
    /// this function.
    fn choice(&self, row: &OptionRow, level: &Level) -> Option<Option<Choice>> {
        let value = |(name, value, _): &(String, Vec<f64>, bool)| format!("{name}={value:?}");
        let texts: Vec<String> = match level {
            Level::Absent => return Some(None),
            Level::Words(words) => words.iter().map(|&word| word.to_owned()).collect(),
            Level::LastBody => vec![self.last_body.clone()?],
            Level::First => vec![value(self.parameters.first()?)],
            Level::Two => vec![format!("{}=2", self.parameters.iter().find(|(.., any)| *any)?.0)],
            Level::All if self.parameters.is_empty() => return None,
            Level::All => self.parameters.iter().map(value).collect(),
        };
        let words: Vec<&str> = texts.iter().map(String::as_str).collect();
        Some(Some(row.read(&words).unwrap_or_else(|wrong| panic!("{}: {}", row.name, wrong.message))))
    }

    /// The request for the chosen levels of the options; `None` if the levels cannot be combined.
    fn request(&self, table: &[Vec<Level>], row: &[Option<usize>]) -> Option<Request> {
        let mut choices = Vec::new();
        for ((option, levels), level) in OPTIONS.iter().zip(table).zip(row) {
            if let Some(level) = level {
                choices.extend(self.choice(option, &levels[*level])?);
            }
        }
        let request = Request { settled: true, ..Request::default() }.with(&choices);
        let has = |part: &Part| {
            (self.multipliers || !part.row().of_constraints) && (self.rows || part.row().rows != Axis::Row)
        };
        (request.conflict().is_none() && request.parts().iter().all(has)).then_some(request)
    }

    fn compile(&self, request: Request) -> Result<Stages, String> {
        let compiled = compile_file(&self.tree, &|name| name == self.function, request);
        compiled.map_err(|errors| errors.to_string()).map(|mut compiled| compiled.functions.remove(0))
    }
}

/// A row of the array: a function and a request for the function.
pub struct Row<'s> {
    subject: &'s Subject,
    request: Request,
    title: String,
}

/// The tested rows: all pairs of option values, and with `each` every pair for every function.
pub fn rows(subjects: &[Subject], each: bool) -> Vec<Row<'_>> {
    let table: Vec<Vec<Level>> = OPTIONS.iter().map(levels).collect();
    let mut sizes: Vec<usize> = table.iter().map(Vec::len).collect();
    let row = |subject: &'_ Subject, row: &[usize]| {
        let open: Vec<Option<usize>> = row.iter().map(|level| Some(*level)).collect();
        let stated = OPTIONS.iter().zip(&table).zip(row).filter(|(_, level)| **level > 0);
        let stated = stated.map(|((option, levels), level)| match &levels[*level] {
            Level::Words(words) => format!(" --{} {}", option.name, words.join(",")),
            level => format!(" --{} ({level:?})", option.name),
        });
        (subject.request(&table, &open), format!("{}{}", subject.name, stated.collect::<String>()))
    };
    let whole = |subject, (request, title): (Option<Request>, String)| Row {
        subject,
        request: request.unwrap_or_else(|| panic!("{title} can be had")),
        title,
    };
    if each {
        sizes.insert(0, subjects.len());
        let valid = |row: &[Option<usize>]| match row[0] {
            Some(subject) => subjects[subject].request(&table, &row[1..]).is_some(),
            None => subjects.iter().any(|subject| subject.request(&table, &row[1..]).is_some()),
        };
        let rows = covering(&sizes, &valid);
        return rows.iter().map(|own| whole(&subjects[own[0]], row(&subjects[own[0]], &own[1..]))).collect();
    }
    let rows = covering(&sizes, &|row| subjects.iter().any(|subject| subject.request(&table, row).is_some()));
    let placed = rows.iter().enumerate().map(|(index, own)| {
        let turn = (0..subjects.len()).map(|at| &subjects[(index + at) % subjects.len()]);
        let mut fit = turn.filter(|subject| row(subject, own).0.is_some());
        let subject = fit.next().expect("some function has what a row wants");
        whole(subject, row(subject, own))
    });
    placed.collect()
}

/// Tests rows, prints failures, and returns the names of failed rows.
pub fn failures(rows: Vec<Row<'_>>, base: &str) -> Vec<String> {
    let clang = Command::new("clang").arg("--version").output().is_ok_and(|output| output.status.success());
    if !clang {
        eprintln!("clang is not installed: nothing here is compiled by it");
    }
    let rows = rows.into_iter().enumerate().collect();
    let found = parallel(rows, |(index, row): (usize, Row)| {
        let folder = folder(base, &format!("sweep_{index}"));
        match row.fails(&folder, clang) {
            Err(text) => {
                eprintln!("{}\n{text}\n", row.title);
                Some(row.title)
            }
            Ok(()) => {
                // Folders of passing rows are deleted, because some rows are large.
                let _ = std::fs::remove_dir_all(&folder);
                None
            }
        }
    });
    found.into_iter().flatten().collect()
}

impl Row<'_> {
    fn fails(&self, folder: &Path, clang: bool) -> Result<(), String> {
        let stages = self.subject.compile(self.request.clone())?;
        let plain = Request {
            known: self.request.known.clone(),
            outputs: self.request.parts().to_vec(),
            settled: true,
            ..Request::default()
        };
        let dense = self.subject.compile(Request { layout: Layout::Dense, ..plain })?;
        let precisions = self.request.precisions_or_double();
        let file = File {
            stem: self.subject.stem.clone(),
            docs: Vec::new(),
            kernels: vec![stages.kernel],
            precisions: precisions.clone(),
        };
        for target in self.request.targets_or(Target::C) {
            for generated in emit::emit(&file, target) {
                std::fs::write(folder.join(generated.name), generated.text)
                    .expect("the folder can be written");
            }
            match target {
                Target::C => compile_c(&file, folder, clang)?,
                Target::Rust => compile_rust(&file, folder)?,
            }
            compare(&dense, &precisions, &folder.join(format!("driver_{}", target.name())))?;
        }
        Ok(())
    }
}

fn compile_c(file: &File, folder: &Path, clang: bool) -> Result<(), String> {
    let (name, write) = (file.name(), |name: &str, text: &str| std::fs::write(folder.join(name), text));
    let source = format!("{name}.c");
    run(folder, "gcc", &[&STRICT[..], &["-O1", "-c", &source, "-o", "kernels.o"]].concat())?;
    if clang {
        run(folder, "clang", &[&STRICT[..], &["-fsyntax-only", &source]].concat())?;
    }
    let header = format!("#include \"{name}.h\"\n#include \"{name}.h\"\n");
    write("header.cpp", &header).expect("the folder can be written");
    for standard in ["-std=c++11", "-std=c++20"] {
        run(folder, "g++", &[&[standard], &STRICT[1..], &["-fsyntax-only", "header.cpp"]].concat())?;
    }
    write("driver.c", &crate::driver::c(file, STATES)).expect("the folder can be written");
    run(folder, "gcc", &["-std=c99", "driver.c", "kernels.o", "-lm", "-o", "driver_c"])
}

fn compile_rust(file: &File, folder: &Path) -> Result<(), String> {
    let (name, write) = (file.name(), |name: &str, text: &str| std::fs::write(folder.join(name), text));
    let source = format!("{name}.rs");
    let library = format!("#![deny(missing_docs)]\n//! A crate.\n\npub mod {name};\n");
    for (name, text) in [("lib.rs", library.as_str()), ("rustfmt.toml", "")] {
        write(name, text).expect("the folder can be written");
    }
    for edition in ["2021", "2024"] {
        let strict = ["--edition", edition, "-D", "warnings", "--crate-type", "lib", "--emit", "metadata"];
        run(folder, "rustc", &[&strict[..], &["lib.rs"]].concat())?;
    }
    run(folder, "rustfmt", &["--edition", "2024", "--check", &source])?;
    write("driver.rs", &crate::driver::rust(file, STATES)).expect("the folder can be written");
    let plain = ["--edition", "2024", "-C", "opt-level=0", "-A", "warnings", "-o", "driver_rust"];
    run(folder, "rustc", &[&plain[..], &["driver.rs"]].concat())
}

/// Runs a program that must succeed.
fn run(folder: &Path, program: &str, arguments: &[&str]) -> Result<(), String> {
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    let output = output.map_err(|error| format!("{program}: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let text = [output.stdout, output.stderr].concat();
    let text: Vec<String> = String::from_utf8_lossy(&text).lines().take(40).map(str::to_owned).collect();
    Err(format!("{program} {} in {}\n{}", arguments.join(" "), folder.display(), text.join("\n")))
}

/// Compares the results of a program with the dense kernel in 320 bits.
fn compare(dense: &Stages, precisions: &[Precision], program: &Path) -> Result<(), String> {
    let mut all = Vec::new();
    for precision in precisions {
        let Some(cases) = try_cases(dense, *precision, STATES) else { return Ok(()) };
        all.push((*precision, cases));
    }
    let calls = all.iter().flat_map(|(_, cases)| cases);
    let input = calls.flat_map(|case| crate::cases::given(&dense.program.signature, &case.inputs));
    let output = pipe(program, &input.collect::<Vec<f64>>());
    let mut rest = output.as_slice();
    let mut wrong = Vec::new();
    for (precision, cases) in &all {
        for case in cases {
            let (here, others) = rest.split_at(case.expected.len());
            rest = others;
            let misses = misses(dense, *precision, case, here).into_iter();
            wrong.extend(
                misses
                    .filter(|miss| miss.fails(*precision, SLACK))
                    .map(|miss| format!("{precision}: {miss}")),
            );
        }
    }
    wrong.truncate(5);
    if wrong.is_empty() { Ok(()) } else { Err(format!("{}\n{}", program.display(), wrong.join("\n"))) }
}
