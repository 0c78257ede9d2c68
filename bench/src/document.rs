//! `document`: measures the tables of the documents and prints these tables again.
//!
//! Input: names of steps. Output: documents in which the text between the marks of each step is replaced by
//! the machine, the date, the versions and a table. A step is a row of [`STEPS`]; a new table or figure needs
//! a new row.

use crate::catalogue::{self, CASES};
use crate::kernels::{self, BY_HAND, FLAGS, Plan, RUST_FLAGS, STATES};
use crate::{
    chain, compile_all, in_folder, layouts, machine, modes, nodes, on_threads, peers, sleeping,
    work_precision, write, yardsticks as mechanisms,
};
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

/// Options of the command.
#[derive(clap::Args, Debug, Default)]
pub struct Options {
    /// Names of steps; if empty, all steps that need no peers.
    steps: Vec<String>,
    /// Few rounds and short runs, for a quick trial.
    #[arg(long)]
    quick: bool,
    /// Folder in which `bench/peers/setup.sh` and `simulations.sh` stored kernels from other tools and
    /// measurements of engines; adds the step `peers`.
    #[arg(long, value_name = "DIR")]
    peers: Option<PathBuf>,
    /// The folder of the documents.
    #[arg(long, value_name = "DIR", default_value = "docs")]
    into: PathBuf,
}

/// A measured part of a document.
pub struct Step {
    /// Name of the step.
    pub name: &'static str,
    /// File name of the document.
    pub document: &'static str,
    /// Names of the printed blocks; a name with a file extension is a file in the folder of the document.
    pub prints: &'static [&'static str],
    /// Runs the measurement: one text for each entry of `prints`; an empty text leaves the block unchanged.
    run: fn(&Options) -> Result<Vec<String>, String>,
}

/// Every step, in order.
pub const STEPS: [Step; 9] = [
    Step { name: "kernels", document: "benchmarks.md", prints: &["kernels"], run: kernels },
    Step { name: "layouts", document: "benchmarks.md", prints: &["layouts"], run: layouts },
    Step { name: "modes", document: "benchmarks.md", prints: &MODES, run: modes },
    Step { name: "growth", document: "benchmarks.md", prints: &["growth"], run: growth },
    Step { name: "sleeping", document: "benchmarks.md", prints: &["sleeping"], run: sleeping },
    Step { name: "catalogue", document: "catalogue.md", prints: &["catalogue"], run: catalogue },
    Step { name: "yardsticks", document: "simulations.md", prints: &["yardsticks"], run: yardsticks },
    Step { name: "simulations", document: "simulations.md", prints: &SIMULATIONS, run: simulations },
    Step {
        name: PEERS,
        document: "benchmarks.md",
        prints: &["peers-setting", "peers-summary", "peers"],
        run: by_peers,
    },
];

/// The block of modes, and the plots of some kernels.
const MODES: [&str; 4] = [
    "modes",
    "figures/modes-point_to_point.svg",
    "figures/modes-distance.svg",
    "figures/modes-neo_hookean.svg",
];

/// The blocks of simulations.
const SIMULATIONS: [&str; 12] = [
    "work-setting",
    "work-compared",
    "work-c10",
    "work-c10-stiff",
    "work-ben25-soft",
    "work-ben25",
    "work-ben25-free",
    "work-ben25-rigid",
    "work-ben25-rigid-free",
    "work-t-handle",
    "work-cloth",
    "work-bar",
];

/// The step that needs kernels from other tools.
const PEERS: &str = "peers";

/// Runs steps and writes the part of each step into the document as soon as the step ends.
pub fn document(options: &Options) -> Result<(), String> {
    if let Some(unknown) = options.steps.iter().find(|name| STEPS.iter().all(|step| step.name != **name)) {
        let names: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        return Err(format!("no step `{unknown}`; there are {}", names.join(", ")));
    }
    let wanted = |step: &&Step| match options.steps.as_slice() {
        [] => step.name != PEERS || options.peers.is_some(),
        names => names.iter().any(|name| name == step.name),
    };
    for step in STEPS.iter().filter(wanted) {
        let started = Instant::now();
        let texts = (step.run)(options)?;
        let path = options.into.join(step.document);
        let mut text =
            std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        for (name, printed) in step.prints.iter().zip(texts).filter(|(_, printed)| !printed.is_empty()) {
            if name.contains('.') {
                write(&options.into.join(name), &printed)?;
            } else {
                text = peers::print_into(&text, &[(name, printed)])?;
            }
        }
        write(&path, &text)?;
        println!("{}: {}, {:.0} s", step.name, path.display(), started.elapsed().as_secs_f64());
    }
    Ok(())
}

/// The machine, the date, the versions and the flags.
pub fn setting(plan: &Plan) -> String {
    let peers = plan.peers.iter().map(|peer| (peer.name.as_str(), peer.version.as_str()));
    let versions = machine::versions(peers);
    let mut text = machine::machine() + "\n";
    text += &format!("{}: {}\n", machine::first_line("gcc", &["--version"]), plan.flags.join(" "));
    text += &format!("{}: {RUST_FLAGS}\n", machine::rustc());
    if !versions.is_empty() {
        text += &format!("{}\n", versions.join(", "));
    }
    text + &format!("\nns a call, {} rounds of {STATES} states\n", plan.rounds)
}

/// A setting as a fenced block of a document.
fn fenced(text: &str) -> String {
    format!("```text\n{text}```\n")
}

/// A table of a measurement in Rust alone, with the machine and the compiler.
fn of_rust(table: &str) -> String {
    let setting = format!("{}; {}\n", machine::machine(), machine::rustc());
    format!("{}\n\n{table}", fenced(&setting).trim_end())
}

/// The plan for these options, with default flags.
fn plan(options: &Options) -> Plan {
    let flags = FLAGS.split(' ').map(str::to_owned).collect();
    Plan { only: Vec::new(), rounds: if options.quick { 3 } else { 51 }, flags, peers: Vec::new() }
}

fn kernels(options: &Options) -> Result<Vec<String>, String> {
    let mut plan = plan(options);
    if options.quick {
        plan.only = BY_HAND.map(str::to_owned).to_vec();
    }
    let rows = in_folder("kernels", |folder| kernels::measure(&plan, folder))?;
    Ok(vec![format!("{}\n{}", fenced(&setting(&plan)), kernels::table(&rows))])
}

fn layouts(options: &Options) -> Result<Vec<String>, String> {
    let plan = plan(options);
    let kernel = BY_HAND[0];
    let rows = in_folder("layouts", |folder| layouts::measure(kernel, plan.rounds, folder))?;
    Ok(vec![format!("{}\n{}", fenced(&(setting(&plan) + kernel + "\n")), layouts::table(&rows))])
}

fn modes(options: &Options) -> Result<Vec<String>, String> {
    let mut plan = plan(options);
    let plotted = MODES[1..].iter().filter_map(|name| name.split_once('-')?.1.strip_suffix(".svg"));
    let plotted: Vec<&str> = plotted.collect();
    let only = if options.quick { plotted.as_slice() } else { &[] };
    // gcc may fuse only in the mode `fast`.
    plan.flags.push("-ffp-contract=off|fast".to_owned());
    let points = in_folder("modes", |folder| modes::measure(only, plan.rounds, folder))?;
    let mut texts = vec![format!("{}\n{}", fenced(&setting(&plan)), modes::table(&points))];
    texts.extend(plotted.iter().map(|kernel| modes::plot(&points, kernel)));
    Ok(texts)
}

fn growth(options: &Options) -> Result<Vec<String>, String> {
    let links = if options.quick { &[220][..] } else { &[220, 2200, 22_000] };
    Ok(vec![of_rust(&growth_table(links))])
}

/// Compile time against kernel size: chains with the given numbers of helper functions; 22,000 helpers make
/// 1e6 nodes.
pub fn growth_table(links: &[usize]) -> String {
    let mut text = String::from("| nodes | seconds | µs a node |\n|--:|--:|--:|\n");
    for links in links {
        let source = chain(*links);
        let started = Instant::now();
        let compiled = compile_all(&source);
        let (seconds, nodes) = (started.elapsed().as_secs_f64(), nodes(&compiled));
        let _ = writeln!(text, "| {nodes} | {seconds:.2} | {:.1} |", seconds * 1e6 / nodes as f64);
    }
    text
}

fn sleeping(options: &Options) -> Result<Vec<String>, String> {
    let sizes = if options.quick { &[(2, 20)][..] } else { &[(100, 10_000)] };
    // On one thread, so that the cost of sleeping bodies cannot hide on another thread.
    let rows = sizes.iter().map(|&(awake, asleep)| on_threads(1, || sleeping::measure(awake, asleep, 200)));
    Ok(vec![of_rust(&sleeping::table(&rows.collect::<Vec<_>>()))])
}

fn catalogue(options: &Options) -> Result<Vec<String>, String> {
    let mut text = format!("{}\n", catalogue::HEAD);
    for case in &CASES {
        let _ = writeln!(text, "{}", catalogue::row(case, &(case.run)(options.quick)));
    }
    Ok(vec![of_rust(&text)])
}

fn simulations(options: &Options) -> Result<Vec<String>, String> {
    let peers =
        options.peers.as_ref().map(|folder| folder.join("simulations")).filter(|folder| folder.is_dir());
    let own = work_precision::Options { quick: options.quick, budget: 1.0, peers, ..Default::default() };
    let drawn = work_precision::draw(&own, &options.into, &options.into.join("figures"))?;
    let find = |name: &&str| drawn.iter().find(|(known, _)| known == name).map(|(_, text)| text.clone());
    Ok(SIMULATIONS.iter().map(find).map(Option::unwrap_or_default).collect())
}

fn yardsticks(options: &Options) -> Result<Vec<String>, String> {
    Ok(vec![of_rust(&mechanisms::table(options.quick))])
}

fn by_peers(options: &Options) -> Result<Vec<String>, String> {
    let folder = options.peers.as_ref().ok_or("the step `peers` needs `--peers DIR`; see bench/README.md")?;
    let mut plan = Plan { peers: peers::read(&folder.join("kernels"))?, ..plan(options) };
    plan.only = plan.peers.iter().map(|peer| peer.kernel.clone()).collect();
    let lines = in_folder("peers", |folder| peers::lines(&plan, kernels::measure(&plan, folder), folder))?;
    Ok(vec![fenced(&setting(&plan)), peers::summary(&lines), peers::table(&lines)])
}
