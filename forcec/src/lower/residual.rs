//! The scalars that lose digits by cancellation, for mode `accurate`.
//!
//! In: a lowered derivation. Out: the scalars that are sums whose terms can cancel; `accurate.rs` follows
//! these scalars back to the inputs.

use crate::derive::Combination;
use crate::lower::{Lowered, Lowering};
use crate::model::bodies::Block;
use crate::scalar::Id;
use crate::vector::{Node, Real, Vector};
use std::collections::BTreeSet;

impl Lowering {
    /// The sums that lose digits: for a constraint, the rows and their rates; for an energy or a force, every
    /// sum that the author wrote, and the dot and cross products, as far as the forces depend on them.
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
                let node = self.tangent.graph.node(index as usize);
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
