//! Programs with one sign flipped: what a check must catch.
//!
//! In: a program. Out: the places where a sign can be flipped, and the program with one of them flipped. A place is one
//! term of a sum that some output needs, or one output.

use crate::math::exact::Exact;
use crate::scalar::{Graph, Id, Node, Program};

/// A sign that can be flipped.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mutation {
    /// A term of a sum; the constant is the term after the last.
    Term(Id, usize),
    /// An output, counted in the order they are stored.
    Output(usize),
}

/// Every sign that can be flipped; the sign of a lone term is not one, for its users are mutated themselves.
pub fn mutations(program: &Program) -> Vec<Mutation> {
    let mut all = Vec::new();
    let live = program.live();
    for (id, node) in program.graph.iter().filter(|(id, _)| live[id.index()]) {
        if let Node::Sum(constant, terms) = node {
            let count = terms.len() + usize::from(!constant.is_zero());
            if count > 1 {
                all.extend((0..count).map(|term| Mutation::Term(id, term)));
            }
        }
    }
    let outputs = program.outputs().enumerate();
    all.extend(
        outputs.filter(|(_, id)| !program.graph.is_zero(*id)).map(|(index, _)| Mutation::Output(index)),
    );
    all
}

/// The program with one of its signs flipped, chosen by the seed; itself if it has none.
pub fn mutate(program: &Program, seed: u64) -> Program {
    let all = mutations(program);
    match all.len() as u64 {
        0 => program.clone(),
        count => apply(program, all[(seed % count) as usize]),
    }
}

/// The program with this sign flipped.
pub fn apply(program: &Program, mutation: Mutation) -> Program {
    let mut graph = Graph::default();
    let mut map: Vec<Id> = Vec::with_capacity(program.graph.len());
    for (id, node) in program.graph.iter() {
        let at = |id: &Id| map[id.index()];
        let copy = match node {
            Node::Sum(constant, terms) => {
                let flipped = |term: usize, c: &Exact| {
                    if mutation == Mutation::Term(id, term) { -c } else { c.clone() }
                };
                let rest = terms.iter().enumerate().map(|(k, (c, x))| (flipped(k, c), at(x))).collect();
                graph.sum(flipped(terms.len(), constant), rest)
            }
            node => graph.copy(node, at),
        };
        map.push(copy);
    }
    let mut mutated = program.clone();
    let mut index = 0;
    mutated.map_outputs(|id| {
        let copy = map[id.index()];
        index += 1;
        if mutation == Mutation::Output(index - 1) { graph.neg(copy) } else { copy }
    });
    mutated.graph = graph;
    mutated
}
