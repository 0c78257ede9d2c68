//! `forcec build`: force files to kernels on disk.

use super::{Failure, Input, Outcome, RealArgument, TargetArgument, complain};
use crate::files;
use crate::kernel::{Precision, Target};
use std::path::PathBuf;

#[derive(clap::Args)]
pub(super) struct Build {
    #[command(flatten)]
    input: Input,
    /// The folder the kernels are written to; it is made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What to write; may be repeated
    #[arg(long, value_name = "TARGET", default_value = "c")]
    target: Vec<TargetArgument>,
    /// The precision of the kernels; may be repeated
    #[arg(long, value_name = "REAL", default_value = "f64")]
    real: Vec<RealArgument>,
    /// Write nothing; exit 1 if a file on disk differs from what would be written
    #[arg(long)]
    check: bool,
}

impl Build {
    pub(super) fn run(self) -> Outcome {
        let units = self.input.compile()?;
        let precisions: Vec<Precision> = [RealArgument::F64, RealArgument::F32]
            .into_iter()
            .filter(|real| self.real.contains(real))
            .map(Precision::from)
            .collect();
        let targets: Vec<Target> = [TargetArgument::C, TargetArgument::Rust]
            .into_iter()
            .filter(|target| self.target.contains(target))
            .map(Target::from)
            .collect();
        let outputs = files::outputs(&units, &self.out, &targets, &precisions).map_err(Failure::Input)?;
        if !self.check {
            return files::write(&self.out, &outputs).map_err(Failure::Input);
        }
        let mut differ = false;
        for output in &outputs {
            let state = match std::fs::read(&output.path) {
                Ok(old) if old == output.text.as_bytes() => continue,
                Ok(_) => "differs".to_owned(),
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => "is missing".to_owned(),
                Err(error) => format!("cannot be read: {error}"),
            };
            complain(&format!("{} {state}", output.path.display()));
            differ = true;
        }
        if differ { Err(Failure::Check) } else { Ok(()) }
    }
}
