//! `forcec build`: force files to kernels on disk.

use super::files::{Output, Unit, write};
use super::{Failure, Input, Outcome, RealArgument, TargetArgument, complain};
use crate::kernel::{Precision, Target};
use crate::targets::emit;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

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
        let mut files: BTreeMap<PathBuf, String> = BTreeMap::new();
        for unit in &units {
            if unit.compiled.functions.is_empty() {
                continue;
            }
            for target in [TargetArgument::C, TargetArgument::Rust] {
                if !self.target.contains(&target) {
                    continue;
                }
                for generated in emit(&unit.file(&precisions), Target::from(target)) {
                    let path = self.out.join(&generated.name);
                    let old = files.insert(path.clone(), generated.text);
                    if old.is_some_and(|old| old != files[&path]) {
                        return Err(Failure::Input(collision(unit, &path)));
                    }
                }
            }
        }
        let outputs: Vec<Output> = files.into_iter().map(|(path, text)| Output { path, text }).collect();
        if !self.check {
            return write(&self.out, &outputs);
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

/// The message about a file that would be written twice.
fn collision(unit: &Unit, output: &Path) -> String {
    let help = if unit.path.file_stem().is_some_and(|stem| stem == "forcec") {
        "`forcec.h` holds the body types; rename the force file"
    } else {
        "give the files different names, or build them into different folders"
    };
    let (unit, output) = (unit.path.display(), output.display());
    format!(
        "error: the kernels of `{unit}` would overwrite another file of this build, `{output}`\n  = help: {help}"
    )
}
