//! `work-precision`: run time per simulated second against the error of the final state, one curve per
//! integrator.
//!
//! Input: scenes with a known final state, and measurements of peers. Output: points, as tables, CSV and
//! log-log plots. The error is the root mean square distance of all bodies from a reference at the end; for
//! freely turning robots the error is the largest change of a robot's energy. Unusable points stay in the
//! output and are marked.

mod measure;
pub mod peers;
mod plot;
mod problems;
mod tables;

pub use measure::{Measured, Point, State, measure};
pub use problems::{PROBLEMS, Problem};

use crate::run::{INTEGRATORS, among, named};
use crate::{machine, write};
use forcec_runtime::Integrator;
use std::path::{Path, PathBuf};

/// Options of the command.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// Names of scenes; if empty, all scenes.
    #[arg(value_parser = named(&PROBLEMS, |problem| (problem.name, problem.about)))]
    pub problems: Vec<&'static Problem>,
    /// Two steps and two tolerances, once each.
    #[arg(long)]
    pub quick: bool,
    /// Points that would take longer than this are left out, s; of a cloth six times as long.
    #[arg(long, default_value_t = 5.0)]
    pub budget: f64,
    /// Only this integrator; repeat for several.
    #[arg(long = "integrator", value_parser = among(&INTEGRATORS))]
    pub integrators: Vec<Integrator>,
    /// Writes all points of a scene into a file there.
    #[arg(long, value_name = "DIR")]
    pub csv: Option<PathBuf>,
    /// Writes a plot of each scene there.
    #[arg(long, value_name = "DIR")]
    pub svg: Option<PathBuf>,
    /// Reads what `bench/peers/simulations.sh` measured there.
    #[arg(long, value_name = "DIR")]
    pub peers: Option<PathBuf>,
}

/// Measures, prints and writes the requested results.
pub fn run(options: &Options) -> Result<(), String> {
    all(options, &|text| println!("{text}\n"), &|path| path.display().to_string()).map(|_| ())
}

/// The same for a document in a folder, with links to the plots: the text for the blocks between marks, by
/// name.
pub fn draw(options: &Options, into: &Path, figures: &Path) -> Result<Vec<(String, String)>, String> {
    let options = Options { svg: Some(figures.to_owned()), ..options.clone() };
    all(&options, &|_| (), &|path| path.strip_prefix(into).unwrap_or(path).display().to_string())
}

fn all(
    options: &Options,
    say: &dyn Fn(&str),
    link: &dyn Fn(&Path) -> String,
) -> Result<Vec<(String, String)>, String> {
    let peers = options.peers.as_deref().map(peers::read).transpose()?.unwrap_or_default();
    let chosen: Vec<&Problem> =
        if options.problems.is_empty() { PROBLEMS.iter().collect() } else { options.problems.clone() };
    for folder in options.csv.iter().chain(&options.svg) {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let mut setting = format!("{}\n{}\n", machine::machine(), machine::rustc());
    let versions = peers::versions(&peers);
    setting += &if versions.is_empty() { String::new() } else { format!("{}\n", versions.join(", ")) };
    say(&setting);

    let mut blocks = vec![("work-setting".to_owned(), format!("```text\n{setting}```\n"))];
    let mut all = Vec::new();
    for problem in chosen {
        let measured = measure(problem, &peers, options);
        let mut text = tables::table(problem, &measured);
        say(&format!("{}: {}\n\n{text}", problem.name, problem.about));
        let name = problem.name;
        if let Some(folder) = &options.csv {
            write(&folder.join(format!("{name}.csv")), &tables::csv(problem, &measured))?;
        }
        if let Some(folder) = &options.svg {
            let path = folder.join(format!("{name}.svg"));
            write(&path, &plot::plot(problem, &measured))?;
            text += &format!("\n![{}: time against error]({})\n", problem.about, link(&path));
        }
        blocks.push((format!("work-{name}"), text));
        all.push((problem, measured));
    }
    if let Some(text) = tables::compared(&all) {
        say(&text);
        blocks.push(("work-compared".to_owned(), text));
    }
    Ok(blocks)
}
