//! Kernels from other tools, and the cost of every maker's code apart from run time.
//!
//! Input: a folder that the scripts of `bench/peers` filled with one file per kernel, whose first line names
//! the tool, and the rows of a measurement. Output: tables of operations, lines, generation time, compile
//! time, run time and error, as text, CSV and blocks of a document.

use crate::count::{Size, size};
use crate::kernels::{Plan, Row, compile, printable, run};
use forcec::Effort;
use forcec::internals::names::Target;
use forcec::internals::source::span::Source;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// A kernel from another tool.
#[derive(Clone, Debug)]
pub struct Peer {
    /// Name of the tool.
    pub name: String,
    /// Version of the tool.
    pub version: String,
    /// How the problem was formulated for the tool.
    pub formulation: String,
    /// Name of the kernel.
    pub kernel: String,
    /// Name of the function.
    pub symbol: String,
    /// Path of the source file.
    pub source: PathBuf,
    /// Generation time in seconds, measured by the tool's script; `None` for a library, which does this work
    /// at run time.
    pub generation: Option<f64>,
}

/// Parses the first line of each file: `/* TOOL | VERSION | FORMULATION | KERNEL | SECONDS s */`. A library
/// has `-` in place of the seconds, and its file only calls functions of a `.so` in the folder.
pub fn read(folder: &Path) -> Result<Vec<Peer>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(failed)?.collect();
    let mut paths: Vec<PathBuf> = entries.map_err(failed)?.iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "c" || ending == "cc"));
    paths.sort();
    paths.iter().map(|path| peer(path).ok_or_else(|| format!("{}: no head", path.display()))).collect()
}

fn peer(path: &Path) -> Option<Peer> {
    let text = std::fs::read_to_string(path).ok()?;
    let head = text.lines().next()?.strip_prefix("/* ")?.strip_suffix(" s */")?;
    let mut parts = head.split(" | ").map(str::to_owned);
    Some(Peer {
        name: parts.next()?,
        version: parts.next()?,
        formulation: parts.next()?,
        kernel: parts.next()?,
        symbol: path.file_stem()?.to_str()?.to_owned(),
        source: path.canonicalize().ok()?,
        generation: match parts.next()?.as_str() {
            "-" => None,
            seconds => Some(seconds.parse().ok()?),
        },
    })
}

/// Libraries that the files link to.
pub fn libraries(peers: &[Peer]) -> Vec<PathBuf> {
    let folders: BTreeSet<&Path> = peers.iter().filter_map(|peer| peer.source.parent()).collect();
    let files = folders.into_iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten();
    let mut paths: Vec<PathBuf> = files.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "so"));
    paths.sort();
    paths
}

/// A row together with the cost of its code.
#[derive(Clone, Debug)]
pub struct Line {
    /// Time and error.
    pub row: Row,
    /// Operations and lines of the emitted C or C++; Rust is not counted.
    pub size: Option<Size>,
    /// Seconds to generate the code; `None` for hand-written code.
    pub generation: Option<f64>,
    /// Seconds in gcc or rustc; `None` for a library.
    pub compilation: Option<f64>,
}

/// The shortest of three times in seconds.
fn quickest(mut work: impl FnMut()) -> f64 {
    let timed = (0..3).map(|_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    });
    timed.collect::<Vec<f64>>().into_iter().fold(f64::INFINITY, f64::min)
}

/// Computes the cost of the code of each row. Builds in the folder of the measurement.
pub fn lines(plan: &Plan, rows: Vec<Row>, folder: &Path) -> Vec<Line> {
    let library = crate::library();
    std::fs::create_dir_all(folder.join("one")).expect("a folder to build in");
    rows.into_iter().map(|row| line(plan, row, &library, folder)).collect()
}

fn line(plan: &Plan, row: Row, library: &[Source], folder: &Path) -> Line {
    let wanted = |name: &str| name == row.kernel;
    let head = format!("pub fn {}(", row.kernel);
    let source = library.iter().find(|source| source.text.contains(&head)).expect("the kernel's file");
    let mut generated = Vec::new();
    let generation = quickest(|| {
        let compiled = forcec::internals::compile::compile(source, &wanted, Effort::Default)
            .expect("the library compiles");
        let (file, _) = printable(compiled);
        let target = if row.maker.name == "Rust" { Target::Rust } else { Target::C };
        generated = forcec::internals::emit::emit(&file, target);
    });
    for file in &generated {
        std::fs::write(folder.join("one").join(&file.name), &file.text).expect("a file to build");
    }
    let stem = source.name.trim_end_matches(".rs");
    let emitted = folder.join(format!("one/{stem}.c"));
    let path = row.maker.source.as_ref().unwrap_or(&emitted);
    let alone = || match row.maker.name.as_str() {
        "Rust" => {
            let start = Instant::now();
            let mut rustc = Command::new("rustc");
            rustc.args(["--edition", "2024", "--crate-type", "lib", "--emit", "obj"]);
            run(rustc.args(crate::kernels::RUST_FLAGS.split(' ')).arg(format!("one/{stem}.rs")), folder);
            start.elapsed().as_secs_f64()
        }
        _ => compile(plan, folder, path, "timed"),
    };
    let compilation = row.compilation.unwrap_or_else(alone);
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("hand/hand.h");
    let shared = std::fs::read_to_string(shared).expect("the header of the kernels by hand");
    let texts: &[&str] = if row.maker.name == "hand" { &[&shared, &text] } else { &[&text] };
    let peer = plan.peers.iter().find(|peer| peer.symbol == row.maker.symbol);
    let library = peer.is_some_and(|peer| peer.generation.is_none());
    let size = (row.maker.name != "Rust" && !library).then(|| size(texts, &row.maker.symbol));
    let own = row.maker.source.is_none().then_some(generation);
    let generation = own.or(peer.and_then(|peer| peer.generation));
    Line { row, size, generation, compilation: (!library).then_some(compilation) }
}

/// The rows of a kernel sorted by time, wrong kernels last.
fn of_kernel<'a>(lines: &'a [Line], kernel: &str) -> Vec<&'a Line> {
    let mut chosen: Vec<&Line> = lines.iter().filter(|line| line.row.kernel == kernel).collect();
    let time = |line: &Line| line.row.time.map_or(f64::INFINITY, |time| time.median);
    chosen.sort_by(|x, y| time(x).total_cmp(&time(y)));
    chosen
}

/// Distinct names in order of first appearance.
fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut result: Vec<&str> = Vec::new();
    for name in names {
        if !result.contains(&name) {
            result.push(name);
        }
    }
    result
}

/// The best formulation of every maker relative to the emitted C: median and quartiles of the ratio of times.
pub fn summary(lines: &[Line]) -> String {
    let makers = distinct(lines.iter().map(|line| line.row.maker.name.as_str()));
    let mut text = format!("| kernel | {} |\n|---|{}\n", makers.join(" | "), "--:|".repeat(makers.len()));
    for kernel in distinct(lines.iter().map(|line| line.row.kernel.as_str())) {
        let _ = write!(text, "| `{kernel}` |");
        let sorted = of_kernel(lines, kernel);
        for maker in &makers {
            let best = sorted.iter().find(|line| line.row.maker.name == *maker);
            let _ = match best.and_then(|line| line.row.to_ours) {
                Some(ratio) => write!(text, " {:.2} ({:.2} … {:.2}) |", ratio.median, ratio.low, ratio.high),
                None => write!(text, " {} |", if best.is_some() { "wrong" } else { "" }),
            };
        }
        text.push('\n');
    }
    text
}

const COLUMNS: &str = "| kernel | code | ns | quartiles | C = 1 | error | add | mul | div | sqrt | call | lines | generated, s | compiled, s |
|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|
";

/// All results, kernel by kernel.
pub fn table(lines: &[Line]) -> String {
    let mut text = COLUMNS.to_owned();
    for kernel in distinct(lines.iter().map(|line| line.row.kernel.as_str())) {
        for line in of_kernel(lines, kernel) {
            let (row, maker) = (&line.row, &line.row.maker);
            let _ = write!(
                text,
                "| `{kernel}` | {} |",
                format!("{} {}", maker.name, maker.formulation).trim_end()
            );
            let _ = match row.time {
                Some(time) => write!(text, " {:.1} | {:.1} … {:.1} |", time.median, time.low, time.high),
                None => write!(text, " wrong | |"),
            };
            let ratio = row.to_ours.map_or(String::new(), |ratio| format!("{:.2}", ratio.median));
            let _ = write!(text, " {ratio} | {:.0e} |", row.error);
            let _ = match line.size {
                Some(Size { operations: o, lines }) => {
                    write!(text, " {} | {} | {} | {} | {} | {lines} |", o.add, o.mul, o.div, o.sqrt, o.call)
                }
                None => write!(text, " | | | | | |"),
            };
            let generation = line.generation.map_or(String::new(), |seconds| format!("{seconds:.3}"));
            let compilation = line.compilation.map_or(String::new(), |seconds| format!("{seconds:.2}"));
            let _ = writeln!(text, " {generation} | {compilation} |");
        }
    }
    text
}

/// All results in machine-readable form; an empty field means a missing value.
pub fn csv(lines: &[Line]) -> String {
    let mut text = String::from(
        "kernel,code,formulation,ns_median,ns_low,ns_high,ns_least,to_c,error,add,mul,div,sqrt,call,neg,lines,generation_s,compilation_s\n",
    );
    for line in lines {
        let (row, maker) = (&line.row, &line.row.maker);
        let time =
            row.time.map_or(",,,".to_owned(), |t| format!("{},{},{},{}", t.median, t.low, t.high, t.least));
        let ratio = row.to_ours.map_or(String::new(), |ratio| ratio.median.to_string());
        let size = line.size.map_or(",,,,,,".to_owned(), |Size { operations: o, lines }| {
            format!("{},{},{},{},{},{},{lines}", o.add, o.mul, o.div, o.sqrt, o.call, o.neg)
        });
        let generation = line.generation.map_or(String::new(), |seconds| seconds.to_string());
        let compilation = line.compilation.map_or(String::new(), |seconds| seconds.to_string());
        let _ = writeln!(
            text,
            "{},{},{},{time},{ratio},{:e},{size},{generation},{compilation}",
            row.kernel, maker.name, maker.formulation, row.error
        );
    }
    text
}

/// The document with the text between `<!-- printed: NAME -->` and `<!-- end -->` replaced, for each name.
pub fn print_into(document: &str, blocks: &[(&str, String)]) -> Result<String, String> {
    let mut text = document.to_owned();
    for (name, block) in blocks {
        let mark = format!("<!-- printed: {name} -->\n");
        let start =
            text.find(&mark).ok_or_else(|| format!("no `{}` in the document", mark.trim()))? + mark.len();
        let length =
            text[start..].find("<!-- end -->").ok_or_else(|| format!("`{}` has no end", mark.trim()))?;
        text.replace_range(start..start + length, block);
    }
    Ok(text)
}
