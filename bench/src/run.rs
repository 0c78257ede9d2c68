//! `run SCENE`: steps a scene through time, prints a one-line report, and writes trajectories and a picture
//! to files.

use crate::picture::picture;
use crate::scenes::{Row, SCENES, Scene};
use crate::write;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use forcec_runtime::collision::Contacts;
use forcec_runtime::{Integrator, Report, Solver};
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Name of the scene.
    #[arg(value_parser = named(&SCENES, |row| (row.0, row.1)))]
    scene: &'static Row,
    /// Step size, s, in place of the scene's own; fractions such as `1/60` are allowed.
    #[arg(long, value_parser = fraction)]
    step: Option<f64>,
    /// Duration, s.
    #[arg(long)]
    time: Option<f64>,
    /// The method of integration.
    #[arg(long, value_parser = among(&INTEGRATORS))]
    integrator: Option<Integrator>,
    /// The method for linear systems.
    #[arg(long, value_parser = among(&SOLVERS))]
    solver: Option<Solver>,
    /// Writes a row a step: time, energy, gap, rejected steps, and the position of every body.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Writes the final world, all of it, as JSON.
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Writes a picture of the final state, with the energy over time below it.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// The integrators by name.
pub const INTEGRATORS: [(&str, Integrator); 7] = [
    ("linearly-implicit-euler", Integrator::LinearlyImplicitEuler),
    ("paper-euler", Integrator::PaperEuler),
    ("sdirk2", Integrator::Sdirk2),
    ("generalized-alpha", Integrator::GeneralizedAlpha),
    ("rodas4", Integrator::Rodas4),
    ("symplectic-euler", Integrator::SymplecticEuler),
    ("runge-kutta4", Integrator::RungeKutta4),
];

const SOLVERS: [(&str, Solver); 6] = [
    ("automatic", Solver::Automatic),
    ("direct", Solver::Direct),
    ("conjugate-gradients", Solver::ConjugateGradients),
    ("bicgstab", Solver::BiCgStab),
    ("cgs", Solver::Cgs),
    ("bicg", Solver::BiCg),
];

/// The value that a table assigns to a name.
pub(crate) fn among<T: Copy + Send + Sync + 'static>(
    table: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(table.iter().map(|(name, _)| *name))
        .map(|chosen| table.iter().find(|(name, _)| *name == chosen).expect("a name of the table").1)
}

/// The row of a table with this name.
pub(crate) fn named<T: Sync>(
    table: &'static [T],
    name: fn(&T) -> (&'static str, &'static str),
) -> impl TypedValueParser<Value = &'static T> {
    let names = table.iter().map(name).map(|(name, about)| PossibleValue::new(name).help(about));
    PossibleValuesParser::new(names)
        .map(move |chosen| table.iter().find(|row| name(row).0 == chosen).expect("a name of the table"))
}

/// A number, or a fraction of two numbers.
fn fraction(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().map_err(|error| error.to_string());
    let value = match text.split_once('/') {
        Some((above, below)) => number(above)? / number(below)?,
        None => number(text)?,
    };
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err("not a positive number".to_owned()) }
}

/// Runs a scene.
pub fn run(options: &Options) -> Result<(), String> {
    let (name, about, make) = options.scene;
    let mut scene = make();
    let settings = &mut scene.world.settings;
    settings.integrator = options.integrator.unwrap_or(settings.integrator);
    settings.solver = options.solver.unwrap_or(settings.solver);
    let (h, time) = (options.step.unwrap_or(scene.step), options.time.unwrap_or(scene.time));
    let steps = (time / h).round() as usize;
    println!(
        "{name}: {about}; {} bodies, {} forces, {steps} steps of {h:.3e} s",
        scene.bodies.len(),
        scene.world.force_count()
    );

    let mut table = head(&scene);
    let mut energies = vec![scene.world.energy()];
    let mut sum = Sum::default();
    let live = std::io::stdout().is_terminal();
    for step in 0..steps {
        let started = Instant::now();
        let report = scene.advance(step as f64 * h, h);
        sum.add(&report, &scene.contacts, started.elapsed());
        // Reports contain only awake bodies.
        let energy = if report.asleep == 0 { report.energy } else { scene.world.energy() };
        energies.push(energy);
        let now = (step + 1) as f64 * h;
        if options.csv.is_some() {
            row(&mut table, &scene, now, energy, &report);
        }
        if live && (step + 1 == steps || step % 16 == 0) {
            print!(
                "\r{now:8.3} s  energy {energy:12.5e} J  gap {:9.2e} m  awake {}  contacts {}  rejected {}  {:.0} µs a step ",
                report.max_violation,
                report.awake,
                scene.contacts.points,
                sum.rejected,
                micros(sum.total, step + 1)
            );
            std::io::stdout().flush().map_err(|error| error.to_string())?;
        }
    }
    println!(
        "{}{:.1} µs a step: contacts {:.1}, assembly {:.1}, solution {:.1}; {} steps discarded, {} back-ups, {} islands in \
         quarantine; largest gap {:.2e} m, deepest contact {:.2e} m; energy {:.6e} → {:.6e} J",
        if live { "\n" } else { "" },
        micros(sum.total, steps),
        micros(sum.contacts, steps),
        micros(sum.assembly, steps),
        micros(sum.solve, steps),
        sum.rejected,
        sum.backups,
        sum.quarantined,
        sum.gap,
        sum.depth,
        energies[0],
        energies[energies.len() - 1]
    );
    if let Some(path) = &options.csv {
        write(path, &table)?;
    }
    if let Some(path) = &options.save {
        write(path, &serde_json::to_string(&scene.world.save()).map_err(|error| error.to_string())?)?;
    }
    if let Some(path) = &options.svg {
        write(path, &picture(&scene, &energies, h))?;
    }
    Ok(())
}

/// Sums over all steps.
#[derive(Default)]
struct Sum {
    total: Duration,
    contacts: Duration,
    assembly: Duration,
    solve: Duration,
    rejected: usize,
    backups: usize,
    quarantined: usize,
    gap: f64,
    depth: f64,
}

impl Sum {
    fn add(&mut self, report: &Report, contacts: &Contacts, time: Duration) {
        self.total += time;
        self.contacts += contacts.broad + contacts.narrow + contacts.forces;
        self.assembly += report.assembly;
        self.solve += report.solve;
        self.rejected += report.rejected;
        self.backups += report.semi_definite + report.capped;
        self.quarantined = report.quarantined;
        self.gap = self.gap.max(report.max_violation);
        self.depth = self.depth.max(contacts.depth);
    }
}

fn micros(time: Duration, steps: usize) -> f64 {
    time.as_secs_f64() * 1e6 / steps.max(1) as f64
}

fn head(scene: &Scene) -> String {
    let mut text = "time,energy,gap,rejected".to_owned();
    for k in 0..scene.bodies.len() {
        let _ = write!(text, ",x{k},y{k},z{k}");
    }
    text.push('\n');
    text
}

fn row(text: &mut String, scene: &Scene, time: f64, energy: f64, report: &Report) {
    let (gap, rejected) = (report.max_violation, report.rejected);
    let _ = write!(text, "{time},{energy},{gap},{rejected}");
    for position in scene.positions() {
        let _ = write!(text, ",{},{},{}", position.x, position.y, position.z);
    }
    text.push('\n');
}
