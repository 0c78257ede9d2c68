//! `forcec build`: force files to kernels on disk.

use super::files::{Output, write};
use super::{Failure, Input, Outcome, RealArgument, TargetArgument};
use crate::kernel::{Precision, Target};
use crate::targets::emit;
use std::collections::BTreeMap;
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
                        return Err(Failure::Input(format!(
                            "error: two force files would both be written to `{}`\n  = help: give the files \
                             different names, or build them into different folders",
                            path.display()
                        )));
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
            let state = match std::fs::read_to_string(&output.path) {
                Ok(old) if old == output.text => continue,
                Ok(_) => "differs",
                Err(_) => "is missing",
            };
            eprintln!("{} {state}", output.path.display());
            differ = true;
        }
        if differ { Err(Failure::Check) } else { Ok(()) }
    }
}
