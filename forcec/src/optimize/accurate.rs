//! Marks the values that mode `accurate` computes in doubled precision.
//!
//! In: an optimised program with its residual, the values in which digits cancel. Out: the same program, with
//! marks on the sums, products, quotients and square roots that compute the residual, from the inputs up to
//! the last sum whose terms can cancel. Nothing after the last cancellation loses digits, so nothing there is
//! marked.

use crate::math::functions::Function;
use crate::scalar::{Id, Node, Program};

/// Marks the operations that compute the residual of a program.
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
            // A condition is not a number.
            Node::Select(_, x, y) => [*x, *y].into_iter().collect(),
            _ if computes || matches!(node, Node::Call(..)) => node.operands(),
            _ => continue,
        };
        for operand in followed {
            wanted[operand.index()] = true;
            // The argument of a function other than the square root is rounded, so marking it would not help.
            doubled[operand.index()] |= inside && computes;
        }
    }
    let marked = (0..doubled.len()).filter(|index| doubled[*index]).map(|index| Id(index as u32));
    marked.for_each(|id| graph.set_doubled(id));
}
