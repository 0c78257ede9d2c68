//! `cargo run --release -p forcec-bench --bin kernels`: how long the kernels of the library take, in C, in Rust, and by
//! hand. `bench/README.md` says how to read the table.

use forcec_bench::kernels::{FLAGS, Plan, RUST_FLAGS, STATES, measure};
use std::process::ExitCode;

const USAGE: &str = "usage: kernels [--rounds N] [--flags \"FLAGS OF GCC\"] [KERNEL …]";

fn plan() -> Option<Plan> {
    let flags = |text: &str| text.split_whitespace().map(str::to_owned).collect();
    let mut plan = Plan { only: Vec::new(), rounds: 201, flags: flags(FLAGS) };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--rounds" => plan.rounds = arguments.next()?.parse().ok().filter(|rounds| *rounds > 0)?,
            "--flags" => plan.flags = flags(&arguments.next()?),
            name if name.starts_with('-') => return None,
            name => plan.only.push(name.to_owned()),
        }
    }
    Some(plan)
}

fn main() -> ExitCode {
    let Some(plan) = plan() else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let folder = std::env::temp_dir().join(format!("forcec-bench-{}", std::process::id()));
    let rows = measure(&plan, &folder);
    if let Err(error) = std::fs::remove_dir_all(&folder) {
        eprintln!("{}: {error}", folder.display());
    }
    println!("gcc {}; rustc {RUST_FLAGS}", plan.flags.join(" "));
    println!("ns a call, {} rounds of {STATES} states\n", plan.rounds);
    println!("| kernel | code | median | quartiles | least | by hand = 1 | quartiles | difference |");
    println!("|---|---|--:|--:|--:|--:|--:|--:|");
    for row in &rows {
        let (time, maker) = (row.time, row.maker.name());
        let ratio = row.ratio.map_or("| | ".to_owned(), |ratio| {
            format!("| {:.2} | {:.2} … {:.2} ", ratio.median, ratio.low, ratio.high)
        });
        println!(
            "| `{}` | {maker} | {:.1} | {:.1} … {:.1} | {:.1} {ratio}| {:.0e} |",
            row.kernel, time.median, time.low, time.high, time.least, row.deviation
        );
    }
    ExitCode::SUCCESS
}
