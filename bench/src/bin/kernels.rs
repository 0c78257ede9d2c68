//! `cargo run --release -p forcec-bench --bin kernels`: how long the kernels of the library take, in C, in Rust, by hand,
//! and by peers. `bench/README.md` says how to read the table.

use forcec_bench::document::setting;
use forcec_bench::kernels::{FLAGS, Plan, measure, table};
use forcec_bench::{in_folder, peers, write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str =
    "usage: kernels [--rounds N] [--flags \"FLAGS OF GCC\"] [--peers DIR] [--csv FILE] [KERNEL …]";

/// What the command line asks for.
struct Request {
    plan: Plan,
    csv: Option<PathBuf>,
}

fn request() -> Result<Request, String> {
    let flags = |text: &str| text.split_whitespace().map(str::to_owned).collect();
    let plan = Plan { only: Vec::new(), rounds: 201, flags: flags(FLAGS), peers: Vec::new() };
    let mut request = Request { plan, csv: None };
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
            name if name.starts_with('-') => return Err(USAGE.to_owned()),
            name => plan.only.push(name.to_owned()),
        }
    }
    // With peers, only the kernels that the peers have.
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

fn answer(Request { plan, csv }: &Request) -> Result<(), String> {
    in_folder("kernels", |folder| {
        let rows = measure(plan, folder);
        println!("{}", setting(plan));
        if plan.peers.is_empty() && csv.is_none() {
            print!("{}", table(&rows));
            return Ok(());
        }
        let lines = peers::lines(plan, rows, folder);
        print!("{}\n{}", peers::summary(&lines), peers::table(&lines));
        csv.as_ref().map_or(Ok(()), |path| write(path, &peers::csv(&lines)))
    })?
}
