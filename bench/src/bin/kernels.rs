//! `cargo run --release -p forcec-bench --bin kernels`: how long the kernels of the library take, in C, in Rust, by hand,
//! and by peers. `bench/README.md` says how to read the table.

use forcec_bench::kernels::{FLAGS, Plan, RUST_FLAGS, Row, STATES, measure};
use forcec_bench::{machine, peers};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "usage: kernels [--rounds N] [--flags \"FLAGS OF GCC\"] [--peers DIR] [--csv FILE] \
                     [--document FILE] [KERNEL …]";

/// What the command line asks for.
struct Request {
    plan: Plan,
    csv: Option<PathBuf>,
    document: Option<PathBuf>,
}

fn request() -> Result<Request, String> {
    let flags = |text: &str| text.split_whitespace().map(str::to_owned).collect();
    let plan = Plan { only: Vec::new(), rounds: 201, flags: flags(FLAGS), peers: Vec::new() };
    let mut request = Request { plan, csv: None, document: None };
    let plan = &mut request.plan;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(USAGE);
        match argument.as_str() {
            "--rounds" => {
                plan.rounds = value()?.parse().ok().filter(|rounds| *rounds > 0).ok_or(USAGE)?;
            }
            "--flags" => plan.flags = flags(&value()?),
            "--peers" => plan.peers = peers::read(Path::new(&value()?))?,
            "--csv" => request.csv = Some(value()?.into()),
            "--document" => request.document = Some(value()?.into()),
            name if name.starts_with('-') => return Err(USAGE.to_owned()),
            name => plan.only.push(name.to_owned()),
        }
    }
    // With peers, what they have and nothing else.
    if plan.only.is_empty() {
        plan.only = plan.peers.iter().map(|peer| peer.kernel.clone()).collect();
    }
    Ok(request)
}

fn main() -> ExitCode {
    match request().and_then(|request| answer(&request)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn answer(Request { plan, csv, document }: &Request) -> Result<(), String> {
    let folder = std::env::temp_dir().join(format!("forcec-bench-{}", std::process::id()));
    let rows = measure(plan, &folder);
    let heading = format!("{}\nns a call, {} rounds of {STATES} states\n", setting(plan), plan.rounds);
    println!("{heading}");
    if plan.peers.is_empty() && csv.is_none() && document.is_none() {
        print!("{}", times(&rows));
    } else {
        let lines = peers::lines(plan, rows, &folder);
        let (summary, table) = (peers::summary(&lines), peers::table(&lines));
        print!("{summary}\n{table}");
        let write = |path: &Path, text: String| {
            std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
        };
        if let Some(path) = csv {
            write(path, peers::csv(&lines))?;
        }
        if let Some(path) = document {
            let old =
                std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
            let blocks = [
                ("peers-setting", format!("```text\n{heading}```\n")),
                ("peers-summary", summary),
                ("peers", table),
            ];
            write(path, peers::print_into(&old, &blocks)?)?;
        }
    }
    std::fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))
}

/// The machine, the date, the versions and flags.
fn setting(plan: &Plan) -> String {
    let mut versions: Vec<String> =
        plan.peers.iter().map(|peer| format!("{} {}", peer.name, peer.version)).collect();
    versions.sort();
    versions.dedup();
    let mut text = format!("{}\n", machine::machine());
    text += &format!("{}: {}\n", machine::first_line("gcc", &["--version"]), plan.flags.join(" "));
    text += &format!("{}: {RUST_FLAGS}\n", machine::rustc());
    if !versions.is_empty() {
        text += &format!("{}\n", versions.join(", "));
    }
    text
}

fn times(rows: &[Row]) -> String {
    let mut text = String::from(
        "| kernel | code | median | quartiles | least | by hand = 1 | quartiles | error |\n\
         |---|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for row in rows {
        let ratio = row.ratio.map_or("| | ".to_owned(), |ratio| {
            format!("| {:.2} | {:.2} … {:.2} ", ratio.median, ratio.low, ratio.high)
        });
        let time = row.time.map_or("wrong | | ".to_owned(), |time| {
            format!("{:.1} | {:.1} … {:.1} | {:.1} ", time.median, time.low, time.high, time.least)
        });
        text += &format!("| `{}` | {} | {time}{ratio}| {:.0e} |\n", row.kernel, row.maker.name, row.error);
    }
    text
}
