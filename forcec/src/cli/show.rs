//! `forcec show`: one stage of one force function.

use super::{Failure, Input, Outcome, print};
use crate::derive::derive;
use crate::exact::Exact;
use crate::formula::Dialect;
use crate::kernel::{Precision, Target};
use crate::optimize::Effort;
use crate::specialize::Specialization;
use crate::targets::emit;
use crate::text;
use std::path::PathBuf;

#[derive(clap::ValueEnum, Clone, Copy)]
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
    /// How long to look for fewer operations
    #[arg(long, value_parser = super::effort, default_value = "default", value_name = "quick|default|max")]
    effort: Effort,
    /// A body that never moves; may be repeated
    #[arg(long, value_name = "BODY")]
    fixed: Vec<String>,
    /// A parameter whose value is known, as in `damping=0`; may be repeated
    #[arg(long, value_parser = Specialization::parse_value, value_name = "NAME=VALUE")]
    set: Vec<(String, Vec<Exact>)>,
    /// With `--stage optimized`: operations after every pass instead of the values
    #[arg(long)]
    explain: bool,
}

impl Show {
    pub(super) fn run(self) -> Outcome {
        let input = Input {
            paths: vec![self.path],
            only: vec![self.name.clone()],
            effort: self.effort,
            fixed: self.fixed,
            set: self.set,
        };
        let units = input.compile()?;
        let unit = units.iter().find(|unit| !unit.compiled.functions.is_empty());
        let unit = unit.ok_or_else(|| Failure::Input(format!("error: no force function `{}`", self.name)))?;
        let function = &unit.compiled.functions[0];
        let rendered = |target| {
            let files = emit(&unit.file(&[Precision::F64]), target);
            files
                .into_iter()
                .filter(|file| !file.name.ends_with(".h"))
                .map(|file| file.text)
                .collect::<String>()
        };
        print(&match self.stage {
            Stage::Ast => function.ast.clone(),
            Stage::Graph => function.definition.graph.to_string(),
            Stage::Derivative => text::derivative(&mut derive(&function.definition), Dialect::Text),
            Stage::Latex => text::derivative(&mut derive(&function.definition), Dialect::Latex),
            Stage::Optimized if self.explain => text::passes(&function.report),
            Stage::Optimized => function.program.to_string(),
            Stage::Schedule => function.kernel.schedule.to_string(),
            Stage::Rust => rendered(Target::Rust),
            Stage::C => rendered(Target::C),
        })
    }
}
