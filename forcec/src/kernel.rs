//! The input of the targets: scheduled kernels, and the file that contains them.

use crate::layout::{Lanes, Layout, Packing};
use crate::math::exact::Exact;
use crate::math::number::Number;
pub use crate::math::number::Precision;
use crate::model::bodies::{Signature, Slot};
use crate::model::outputs::{Part, Piece};
pub use crate::names::Target;
use crate::scalar::Operations;
use crate::schedule::Schedule;

/// One force function, ready to be printed.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// Its name in the source.
    pub name: String,
    /// Lines of its doc comment, without the leading space.
    pub docs: Vec<String>,
    /// Its formulas, one per line: `F = -J^T (stiffness C + damping dC/dt)`.
    pub formulas: Vec<String>,
    /// Its statements, with its signature.
    pub schedule: Schedule,
    /// The layout of its outputs.
    pub layout: Layout,
    /// The map from outputs to stored entries; `None` if outputs are stored as full arrays.
    pub packing: Option<Packing>,
    /// Whether its rows are the difference of two anchors; `None` if it does not compute J.
    pub anchored: Option<bool>,
    /// Number of instances that it computes at once.
    pub lanes: Lanes,
    /// Whether it gets precomputed values in place of parameters.
    pub preparation: Preparation,
}

/// Whether a part of a kernel is precomputed.
#[derive(Clone, Debug)]
pub enum Preparation {
    /// Precomputation was not requested.
    Unasked,
    /// No operation depends on parameters alone.
    Nothing,
    /// The kernel reads parameters and precomputed values.
    Once(Box<Once>),
}

/// The precomputed part of a kernel.
#[derive(Clone, Debug)]
pub struct Once {
    /// The statements that compute the values from the parameters of the source.
    pub schedule: Schedule,
    /// Indices of the parameters that the kernel still reads; they come before the values.
    pub kept: Vec<usize>,
    /// Operations of every call without precomputation.
    pub whole: Operations,
}

impl Once {
    /// Number of precomputed values.
    pub fn values(&self) -> usize {
        self.schedule.entries()
    }
}

impl Kernel {
    /// The signature with the parameters of the source.
    pub fn given(&self) -> &Signature {
        self.once().map_or(&self.schedule.signature, |once| &once.schedule.signature)
    }

    /// The description of a parameter of the prepared kernel, if it is precomputed.
    pub fn summary_of(&self, signature: &Signature, parameter: usize) -> Option<String> {
        let kept = self.once().filter(|_| signature.prepared)?.kept.len();
        (parameter >= kept).then(|| "computed once".to_owned())
    }

    /// The precomputed part, if there is one.
    pub fn once(&self) -> Option<&Once> {
        match &self.preparation {
            Preparation::Once(once) => Some(once),
            _ => None,
        }
    }

    /// Evaluates the full outputs, row by row, for the arguments of the source. `None` if an entry is never
    /// written, which is a defect of the schedule.
    pub fn evaluate<N: Number>(&self, inputs: &dyn Fn(Slot) -> N) -> Option<Vec<N>> {
        let found = match self.once() {
            None => self.schedule.evaluate(inputs)?,
            Some(once) => {
                let values = once.schedule.evaluate(inputs)?;
                let values: Vec<&N> = values.iter().collect();
                let (given, signature) = (&once.schedule.signature, &self.schedule.signature);
                self.schedule.evaluate(&|slot| {
                    let Some(place) = (slot.argument as usize).checked_sub(signature.bodies.len()) else {
                        return inputs(slot);
                    };
                    match (once.kept.get(place), signature.extra(slot)) {
                        (Some(parameter), _) => inputs(given.parameter_slot(*parameter, slot.offset)),
                        (_, Some(extra)) => {
                            inputs(given.parameter_slot(given.parameters.len() + extra, slot.offset))
                        }
                        _ => values[place - once.kept.len()].clone(),
                    }
                })?
            }
        };
        let stored: Vec<N> = found.iter().cloned().collect();
        Some(match &self.packing {
            Some(packing) => packing.unpack(&stored, &N::exact(&Exact::ZERO)),
            None => stored,
        })
    }

    /// A kernel of one instance that stores its outputs as full arrays.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn dense(name: String, docs: Vec<String>, formulas: Vec<String>, schedule: Schedule) -> Kernel {
        Kernel {
            name,
            docs,
            formulas,
            schedule,
            layout: Layout::Dense,
            packing: None,
            anchored: None,
            lanes: Lanes::One,
            preparation: Preparation::Unasked,
        }
    }
}

/// One force file, ready to be printed.
#[derive(Clone, Debug)]
pub struct File {
    /// The name of the force file, without extension.
    pub stem: String,
    /// Lines of the doc comment of the force file.
    pub docs: Vec<String>,
    /// Its kernels, in source order.
    pub kernels: Vec<Kernel>,
    /// Requested precisions, in order.
    pub precisions: Vec<Precision>,
}

/// The total number of operations, in words.
fn operations(count: &Operations) -> String {
    match count.total() {
        1 => "1 operation".to_owned(),
        total => format!("{total} operations"),
    }
}

/// The operation counts by kind.
fn counted(count: &Operations) -> String {
    let Operations { add, mul, div, sqrt, call, neg } = count;
    format!("{add} add, {mul} mul, {div} div, {sqrt} sqrt, {call} call; {neg} negations")
}

impl File {
    /// The name of the generated files without extension: that of the force file, then the layout's suffix.
    pub fn name(&self) -> String {
        let suffix =
            self.kernels.first().map_or_else(String::new, |kernel| kernel.layout.suffix(kernel.lanes));
        format!("{}{suffix}", self.stem)
    }
}

impl Kernel {
    /// The comment before the code: formulas, sizes, operation counts.
    pub fn summary(&self) -> Vec<String> {
        let mut lines = self.formulas.clone();
        let count = self.schedule.operations();
        let dofs = self.schedule.signature.dofs();
        let (outputs, nonzero) = match &self.packing {
            Some(packing) => (packing.places().count(), packing.nonzero),
            None => (self.schedule.entries(), self.schedule.nonzero),
        };
        match &self.preparation {
            Preparation::Unasked => lines.push(format!("{}: {}.", operations(&count), counted(&count))),
            Preparation::Nothing => {
                lines.push(format!("{}: {}.", operations(&count), counted(&count)));
                lines.push(
                    "None of them depends on parameters alone: there is nothing to prepare.".to_owned(),
                );
            }
            Preparation::Once(once) => {
                let (first, values) = (once.schedule.operations(), once.values());
                lines.push(format!("{} every call: {}.", operations(&count), counted(&count)));
                lines.push(format!("{} once: {}.", operations(&first), counted(&first)));
                let prepared = if values == 1 { "is 1 value" } else { &format!("are {values} values") };
                lines.push(format!(
                    "Prepared {prepared}; without, every call takes {}.",
                    operations(&once.whole)
                ));
            }
        }
        lines.push(format!(
            "{dofs} degrees of freedom; {outputs} outputs: {} nonzero, {} distinct up to sign.",
            nonzero, self.schedule.distinct
        ));
        lines.extend(self.packing.iter().flat_map(|packing| &packing.remarks).cloned());
        if self.anchored == Some(true) {
            lines.push(
                "Anchored: J is ±(I, −[r]×) for a rigid body, r its arm; ±I for a particle.".to_owned(),
            );
        }
        if !self.lanes.is_one() {
            lines.push(format!("{} instances at once; operations are those of one.", self.lanes));
        }
        lines
    }

    /// The matrices among the outputs, each with whether only its upper triangle is stored.
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
