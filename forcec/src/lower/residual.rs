//! Where digits are lost, for mode `accurate`.
//!
//! In: what was lowered of a derivation. Out: the scalars that are sums whose terms can cancel; `accurate.rs` follows them
//! back to the inputs.

use crate::derive::Combination;
use crate::lower::{Lowered, Lowering};
use crate::model::bodies::Block;
use crate::scalar::Id;
use crate::vector::{Node, Real, Vector};
use std::collections::BTreeSet;

impl Lowering {
    /// Where digits are lost: in the rows of a constraint and their rates; of an energy or a force in every sum that
    /// its author wrote, in dot and in cross products, as far as forces are made of them.
    pub(crate) fn residual(
        &mut self,
        rows: &[(Real, Real)],
        forces: &[(Block, Combination<Vector>)],
        stated: usize,
    ) -> Vec<Id> {
        let mut lost: Vec<Id> = rows.iter().flat_map(|(c, rate)| [*c, *rate]).map(|x| self.real(x)).collect();
        if rows.is_empty() {
            let mut open: Vec<u32> = forces.iter().flat_map(|(_, v)| v.iter().map(|(_, v)| v.0)).collect();
            let mut seen = BTreeSet::new();
            while let Some(index) = open.pop() {
                if !seen.insert(index) {
                    continue;
                }
                let node = self.lie.graph.node(index as usize);
                open.extend(node.operands());
                let cancels =
                    matches!(node, Node::Sum(..) | Node::VectorSum(_) | Node::Dot(..) | Node::Cross(..));
                match self.lowered.get(&index) {
                    Some(Lowered::Real(id)) if cancels && (index as usize) < stated => lost.push(*id),
                    Some(Lowered::Vector(ids)) if cancels && (index as usize) < stated => lost.extend(ids),
                    _ => {}
                }
            }
        }
        lost.into_iter().map(|id| self.scalar.split(id).1).collect()
    }
}
