//! Programs with one flipped sign, to test whether a check detects an error.
//!
//! In: a program. Out: the signs that can be flipped, and the program with one of them flipped. A flip
//! applies to one term of a live sum, or to one output.

use crate::math::exact::Exact;
use crate::scalar::{Graph, Id, Node, Program};

/// A sign that can be flipped.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mutation {
    /// A term of a sum; the constant has the index after the last term.
    Term(Id, usize),
    /// An output, by its position in storage order.
    Output(usize),
}

/// All signs that can be flipped; a sum of one term is skipped, because its users are mutated themselves.
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

/// The program with one sign flipped, chosen by the seed; unchanged if it has none.
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
