//! Which values are computed in doubled precision: from the inputs up to the last sum whose terms can cancel.
//!
//! In: an optimised program that knows its residual, the values in which digits are lost. Out: the same program with
//! every sum, product, quotient and square root marked that these are made of. What a residual is a product or function
//! of is followed to the sums in it: after the last cancellation nothing is lost any more.

use crate::math::functions::Function;
use crate::scalar::{Id, Node, Program};

/// Marks what the residual of a program is made of.
pub(super) fn mark(program: &mut Program) {
    let graph = &mut program.graph;
    let mut wanted = vec![false; graph.len()];
    let mut doubled = vec![false; graph.len()];
    graph.residual().for_each(|id| wanted[id.index()] = true);
    for index in (0..graph.len()).rev() {
        if !wanted[index] {
            continue;
        }
        let node = graph.node(Id(index as u32));
        let cancels = matches!(node, Node::Difference(..) | Node::Offset(..))
            || matches!(node, Node::Sum(constant, terms) if terms.len() > 1 || !constant.is_zero());
        let computes = matches!(
            node,
            Node::Sum(..)
                | Node::Product(_)
                | Node::Multiple(..)
                | Node::Held(_)
                | Node::Recip(_)
                | Node::Call(Function::Sqrt, _)
                | Node::Select(..)
        );
        doubled[index] = cancels || doubled[index] && computes;
        let inside = doubled[index];
        let followed = match node {
            // A condition is no number.
            Node::Select(_, x, y) => [*x, *y].into_iter().collect(),
            _ if computes || matches!(node, Node::Call(..)) => node.operands(),
            _ => continue,
        };
        for operand in followed {
            wanted[operand.index()] = true;
            // What a function other than the square root is taken of is rounded for it.
            doubled[operand.index()] |= inside && computes;
        }
    }
    let marked = (0..doubled.len()).filter(|index| doubled[*index]).map(|index| Id(index as u32));
    marked.for_each(|id| graph.set_doubled(id));
}
