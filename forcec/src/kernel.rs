//! What the targets print: scheduled kernels, and the file they stand in.

pub use crate::identifiers::Target;
use crate::layouts::{Layout, Packing};
use crate::outputs::{Part, Piece};
use crate::schedule::Schedule;
use std::fmt;

/// A floating point format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Precision {
    /// Doubles.
    F64,
    /// Floats.
    F32,
}

impl Precision {
    /// Its name, which is Rust's and the suffix of C names.
    pub fn name(self) -> &'static str {
        match self {
            Precision::F64 => "f64",
            Precision::F32 => "f32",
        }
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One force function, ready to be printed.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// Its name in the source.
    pub name: String,
    /// Its doc comment, a line each, without the leading space.
    pub docs: Vec<String>,
    /// What it computes, a line each: `F = -J^T (stiffness C + damping dC/dt)`.
    pub formulas: Vec<String>,
    /// Its statements; they know the arguments.
    pub schedule: Schedule,
    /// How its results are laid out.
    pub layout: Layout,
    /// Where the entries of its results stand, if it does not write them as full arrays.
    pub packing: Option<Packing>,
    /// How many instances it computes at once.
    pub lanes: usize,
}

impl Kernel {
    /// A kernel of one instance whose results are full arrays.
    pub fn dense(name: String, docs: Vec<String>, formulas: Vec<String>, schedule: Schedule) -> Kernel {
        Kernel { name, docs, formulas, schedule, layout: Layout::Dense, packing: None, lanes: 1 }
    }
}

/// One force file, ready to be printed.
#[derive(Clone, Debug)]
pub struct File {
    /// The name of the force file, without extension.
    pub stem: String,
    /// The doc comment of the force file.
    pub docs: Vec<String>,
    /// Its kernels, in source order.
    pub kernels: Vec<Kernel>,
    /// The precisions asked for, in order.
    pub precisions: Vec<Precision>,
}

impl File {
    /// The name of the generated files, without extension: that of the force file, and the layout of its kernels.
    pub fn name(&self) -> String {
        let suffix =
            self.kernels.first().map_or_else(String::new, |kernel| kernel.layout.suffix(kernel.lanes));
        format!("{}{suffix}", self.stem)
    }
}

impl Kernel {
    /// What a reader is told before the code: formulas, sizes, operation counts.
    pub fn summary(&self) -> Vec<String> {
        let mut lines = self.formulas.clone();
        let count = self.schedule.operations();
        let freedoms = self.schedule.signature.freedoms();
        let (outputs, nonzero) = match &self.packing {
            Some(packing) => (packing.places().count(), packing.nonzero),
            None => {
                let lengths = self.schedule.parts.iter().map(|part| part.length(&self.schedule.signature));
                (lengths.sum(), self.schedule.nonzero)
            }
        };
        lines.push(format!(
            "{} operations: {} add, {} mul, {} div, {} sqrt, {} call; {} negations.",
            count.total(),
            count.add,
            count.mul,
            count.div,
            count.sqrt,
            count.call,
            count.neg
        ));
        lines.push(format!(
            "{freedoms} degrees of freedom; of {outputs} outputs {} are not zero, {} of these distinct up to sign.",
            nonzero, self.schedule.distinct
        ));
        lines.extend(self.packing.iter().flat_map(|packing| &packing.remarks).cloned());
        if self.lanes > 1 {
            lines.push(format!("{} instances at once; operations are those of one.", self.lanes));
        }
        lines
    }

    /// The matrices among the results, each with whether its upper triangle is stored and nothing else.
    pub fn triangles(&self) -> impl Iterator<Item = (Part, bool)> + '_ {
        let matrices = self.packing.iter().flat_map(|packing| &packing.tables).map(|table| table.part);
        let pieces = &self.schedule.signature.pieces;
        let triangle = move |part: Part| (part, pieces.contains(&Piece::Triangle(part)));
        matrices.filter(|part| !part.is_list()).map(triangle)
    }

    /// The first paragraph of the doc comment.
    pub fn brief(&self) -> impl Iterator<Item = &str> {
        let lines = self.docs.iter().map(|line| line.trim_end());
        lines.skip_while(|line| line.is_empty()).take_while(|line| !line.is_empty())
    }
}
