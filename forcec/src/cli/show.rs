//! `forcec show`: prints one stage of one force function.

use crate::cli::{Failure, Input, Outcome, Search, print};
use crate::derive::derive;
use crate::emit::emit;
use crate::kernel::{Precision, Target};
use crate::model::outputs::Part;
use crate::show::formula::Dialect;
use crate::show::graphs;
use std::path::PathBuf;

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The function as it was read
    Ast,
    /// The typed vector graph
    Graph,
    /// Forces and the blocks of their derivatives
    Derivative,
    /// The optimised scalar graph
    Optimized,
    /// Statements in order
    Schedule,
    /// The Rust kernel
    Rust,
    /// The C kernel
    C,
    /// C, F and the blocks, typeset
    Latex,
}

#[derive(clap::Args)]
pub(super) struct Show {
    /// A force file, or a folder that is searched
    path: PathBuf,
    /// The force function
    name: String,
    /// Which stage
    #[arg(long)]
    stage: Stage,
    #[command(flatten)]
    search: Search,
    /// With `--stage optimized`: operations and distinct outputs after every pass instead of the values
    #[arg(long)]
    explain: bool,
}

impl Show {
    pub(super) fn run(self) -> Outcome {
        if self.explain && self.stage != Stage::Optimized {
            let message = "error: `--explain` tells of the passes of the optimiser\n  = help: write `--stage optimized`";
            return Err(Failure::Input(message.to_owned()));
        }
        let input =
            Input { paths: vec![self.path], scene: None, only: vec![self.name.clone()], search: self.search };
        let units = input.compile(false)?;
        let unit = units.iter().find(|unit| !unit.compiled.functions.is_empty());
        let unit = unit.ok_or_else(|| Failure::Input(format!("error: no force function `{}`", self.name)))?;
        let function = &unit.compiled.functions[0];
        // Layouts of the default outputs are made of F, ∂F/∂X and ∂F/∂V.
        let whole = function.kernel.layout.row().computes.is_some();
        let parts = if whole { Part::DEFAULT.to_vec() } else { function.outputs() };
        let derived = || derive(&function.definition, &parts, function.formulation);
        let rendered = |target| {
            let files = unit.files(&[Precision::F64]).map_err(|errors| Failure::Input(errors.to_string()))?;
            Ok(files
                .iter()
                .flat_map(|file| emit(file, target))
                .filter(|file| !file.name.ends_with(".h"))
                .map(|file| file.text)
                .collect::<String>())
        };
        print(&match self.stage {
            Stage::Ast => function.ast.clone(),
            Stage::Graph => function.definition.graph.to_string(),
            Stage::Derivative => graphs::derivative(&mut derived(), Dialect::Text),
            Stage::Latex => graphs::derivative(&mut derived(), Dialect::Latex),
            Stage::Optimized if self.explain => graphs::passes(&function.report),
            Stage::Optimized => function.program.to_string(),
            Stage::Schedule => function.kernel.schedule.to_string(),
            Stage::Rust => rendered(Target::Rust)?,
            Stage::C => rendered(Target::C)?,
        })
    }
}
