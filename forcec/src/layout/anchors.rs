//! Whether the rows of a constraint are the difference of two anchors.
//!
//! In: an optimised program. Out: whether its J is ±I for each particle and `±(I, −[r]×)` for each rigid body,
//! with r any vector, read off the entries of J; names play no role. A solver then needs r alone.

use super::Matrix;
use crate::math::exact::Exact;
use crate::model::bodies::BodyKind;
use crate::model::outputs::Part;
use crate::scalar::{Graph, Id, Program};

/// Whether J is that of anchors; `None` if the program does not compute J.
pub fn anchored(program: &Program) -> Option<bool> {
    let jacobian = program.arrays.iter().find(|array| array.part == Part::Jacobian)?;
    let rows: Vec<&[Id]> = jacobian.rows().collect();
    let Ok([x, y, z]) = <[&[Id]; 3]>::try_from(rows) else { return Some(false) };
    let graph = &program.graph;
    let mut start = 0;
    Some(program.signature.moving().all(|(_, body)| {
        let block = |from: usize| Matrix {
            columns: 3,
            entries: [x, y, z].iter().flat_map(|row| &row[from..from + 3]).copied().collect(),
        };
        let turns = (body.kind == BodyKind::RIGID).then(|| block(start + 3));
        let is_skew = |turn: &Matrix| turn.transposed().is(turn, graph, true);
        let holds = is_unit(graph, &block(start)) && turns.as_ref().is_none_or(is_skew);
        start += body.kind.dofs();
        holds
    }))
}

/// Whether the block is I or −I.
fn is_unit(graph: &Graph, block: &Matrix) -> bool {
    [Exact::ONE, -Exact::ONE].iter().any(|sign| {
        let on_diagonal = |k: usize| k.is_multiple_of(4);
        let number = |k| if on_diagonal(k) { sign } else { &Exact::ZERO };
        block.entries.iter().enumerate().all(|(k, id)| graph.value(*id) == Some(number(k)))
    })
}
