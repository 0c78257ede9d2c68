//! Reuses reciprocals: 1/x is the square of 1/√x, and 1/(x y) is the product of 1/x and 1/y.
//!
//! In and out: a program. For mode `fast` only, because each factor adds a rounding.

use crate::math::functions::Function;
use crate::scalar::{Graph, Id, Node, Program};
use rustc_hash::FxHashMap;

/// Replaces reciprocals that can be computed from other reciprocals.
pub(super) fn share(program: &Program) -> Program {
    let live = program.live();
    // Live reciprocals by operand; square roots that have a reciprocal, by the operand of the root.
    let mut known: FxHashMap<Id, Id> = FxHashMap::default();
    let mut roots: FxHashMap<Id, Id> = FxHashMap::default();
    for (id, node) in program.graph.iter().filter(|(id, _)| live[id.index()]) {
        if let Node::Recip(x) = node {
            known.insert(*x, id);
            if let Node::Call(Function::Sqrt, root) = program.graph.node(*x) {
                roots.insert(root[0], *x);
            }
        }
    }
    let mut graph = Graph::default();
    let mut map: Vec<Id> = Vec::with_capacity(live.len());
    for (id, node) in program.graph.iter() {
        let at = |x: &Id| map[x.index()];
        let copy = match node {
            Node::Recip(x) if known.contains_key(x) => match (roots.get(x), program.graph.node(*x)) {
                // The copy of the root is available only if the root precedes this node.
                (Some(root), _) if *root < id => {
                    let inverse = graph.recip(at(root));
                    graph.product(&[(inverse, 2)])
                }
                (_, Node::Product(factors)) if factors.iter().all(|(f, _)| known.contains_key(f)) => {
                    let powers: Vec<(Id, u32)> =
                        factors.iter().map(|(f, n)| (graph.recip(at(f)), *n)).collect();
                    graph.product(&powers)
                }
                _ => graph.recip(at(x)),
            },
            node => graph.copy(node, at),
        };
        if let Some(name) = program.graph.name(id) {
            graph.set_name(copy, name);
        }
        map.push(copy);
    }
    let mut shared = program.outline();
    shared.map_outputs(|id| map[id.index()]);
    shared.graph = graph;
    shared
}
