//! `forcec build`: force files to kernels on disk.

use crate::cli::options::{Options, PRINTED};
use crate::cli::{Failure, Input, Outcome, complain};
use crate::driver::files;
use crate::kernel::Target;
use crate::source::span::shown;
use std::path::PathBuf;

#[derive(clap::Args)]
pub(super) struct Build {
    #[command(flatten)]
    input: Input,
    /// The folder the kernels are written to; created if it does not exist
    #[arg(long, value_name = "DIR", required_unless_present = "scene")]
    out: Option<PathBuf>,
    #[command(flatten)]
    printed: Options<PRINTED>,
    /// Write nothing; exit 1 if a file on disk differs from what would be written
    #[arg(long)]
    check: bool,
    /// Write nothing and exit 1 if there is a warning
    #[arg(long)]
    deny_warnings: bool,
}

impl Build {
    pub(super) fn run(self) -> Outcome {
        let printed = self.printed.request();
        let (units, scene) = match &self.input.scene {
            Some(path) => {
                let scene = self.input.scene(path, self.deny_warnings)?;
                (scene.units, Some((scene.out, scene.request)))
            }
            None => (self.input.compile(self.deny_warnings)?, None),
        };
        // Options of the command line override those of the scene.
        let (out, printed) = match (self.out, scene) {
            (out, Some((own, request))) => (out.unwrap_or(own), request.with(&self.printed.0)),
            (out, None) => (out.unwrap_or_default(), printed),
        };
        let scene_file = self.input.scene.as_deref();
        let outputs = files::outputs(
            &units,
            &out,
            &printed.targets_or(Target::C),
            &printed.precisions_or_double(),
            scene_file,
        );
        let outputs = outputs.map_err(Failure::Input)?;
        if !self.check {
            return files::write(&out, &outputs).map_err(Failure::Input);
        }
        let mut differ = false;
        for output in &outputs {
            let state = match std::fs::read(&output.path) {
                Ok(old) if old == output.text.as_bytes() => continue,
                Ok(_) => "differs".to_owned(),
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => "is missing".to_owned(),
                Err(error) => format!("cannot be read: {error}"),
            };
            complain(&format!("{} {state}", shown(&output.path)));
            differ = true;
        }
        if differ { Err(Failure::Check) } else { Ok(()) }
    }
}
