//! The pattern of the saddle point system of rigid rows, and the turns of its elimination.
//!
//! In: the degrees of freedom of bodies, and the joints between them. Out: where each block is in the matrix
//! and where each body and joint is in vectors, in an order of elimination; blocks have the sizes of bodies, 6
//! or 3, and of joints, 1 to 6. [`factor`](crate::system::factor) works on it.

use crate::system::order::{Joint, Role, eliminate, predecessors, roles};
use std::collections::BTreeSet;

/// A body or a joint.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) size: usize,
    pub(super) is_joint: bool,
    /// Whether ε is added.
    pub(super) closes: bool,
    /// Where its entries begin in vectors.
    pub(super) offset: usize,
    /// Where its diagonal block begins in the matrix.
    pub(super) diagonal: usize,
    /// Its blocks: `blocks[first..end]`.
    pub(super) first: usize,
    pub(super) end: usize,
    /// Where its targets begin.
    pub(super) targets: usize,
}

/// A block right of the diagonal.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Right {
    /// The column: a later node.
    pub(super) node: usize,
    pub(super) at: usize,
}

/// The pattern of a system, the same for all instances.
#[derive(Clone, Debug, PartialEq, Default)]
pub(crate) struct Plan {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<Right>,
    /// Where each pair of a node's blocks, (j, k ≥ j), is subtracted.
    pub(super) targets: Vec<usize>,
    /// The node of each body, then of each joint.
    pub(super) place: Vec<usize>,
    pub(super) bodies: usize,
    /// The lengths of vectors and of the matrix.
    pub(super) length: usize,
    pub(super) entries: usize,
    /// The number of rows of joints that close loops.
    pub(super) closing: usize,
    /// The order of elimination: a node alone, or a body together with the joint that holds it.
    pub(super) turns: Vec<Turn>,
}

/// A step of the elimination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Turn {
    Node(usize),
    /// A body that is coupled with its joint alone, and the joint with at most one other body, of the same
    /// size.
    Pair(Pair),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub(super) size: usize,
    pub(super) rows: usize,
    /// Where the entries of the body and of the joint begin in vectors.
    pub(super) body: usize,
    pub(super) joint: usize,
    /// Where the blocks begin in the matrix: body, Jᵀ, joint.
    pub(super) mass: usize,
    pub(super) jacobian: usize,
    pub(super) schur: usize,
    pub(super) above: Option<Above>,
}

/// The body that a joint hangs on: its entries in vectors, J, and its own block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Above {
    pub(super) body: usize,
    pub(super) jacobian: usize,
    pub(super) mass: usize,
}

/// A block of J in the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) at: usize,
    /// Whether the body was eliminated first, so that the block is Jᵀ.
    pub(crate) transposed: bool,
}

impl Plan {
    /// The plan for bodies with these degrees of freedom, and joints between them.
    pub(crate) fn new(dofs: &[usize], joints: &[Joint]) -> Plan {
        let bodies = dofs.len();
        let mut coupled = vec![BTreeSet::new(); bodies + joints.len()];
        for (k, joint) in joints.iter().enumerate() {
            for &body in &joint.bodies {
                coupled[body].insert(bodies + k);
                coupled[bodies + k].insert(body);
            }
        }
        let roles = roles(dofs, joints);
        let rows = eliminate(&coupled, &predecessors(bodies, joints, &roles));
        let mut plan = Plan { place: vec![0; coupled.len()], bodies, ..Plan::default() };
        for (at, (node, _)) in rows.iter().enumerate() {
            plan.place[*node] = at;
        }
        for (node, _) in &rows {
            let joint = node.checked_sub(bodies);
            let size = joint.map_or_else(|| dofs[*node], |k| joints[k].rows);
            let closes = joint.is_some_and(|k| roles[k] == Role::Closes);
            plan.closing += if closes { size } else { 0 };
            let (offset, diagonal) = (plan.length, plan.entries);
            plan.length += size;
            plan.entries += size * size;
            let is_joint = joint.is_some();
            plan.nodes.push(Node { size, is_joint, closes, offset, diagonal, first: 0, end: 0, targets: 0 });
        }
        for (at, (_, later)) in rows.iter().enumerate() {
            plan.nodes[at].first = plan.blocks.len();
            let mut later: Vec<usize> = later.iter().map(|&node| plan.place[node]).collect();
            later.sort_unstable();
            for node in later {
                plan.blocks.push(Right { node, at: plan.entries });
                plan.entries += plan.nodes[at].size * plan.nodes[node].size;
            }
            plan.nodes[at].end = plan.blocks.len();
        }
        for at in 0..plan.nodes.len() {
            plan.nodes[at].targets = plan.targets.len();
            let later: Vec<usize> = plan.right(at).iter().map(|block| block.node).collect();
            for (k, &row) in later.iter().enumerate() {
                for &column in &later[k..] {
                    let target = plan.block(row, column);
                    plan.targets.push(target);
                }
            }
        }
        let mut before = vec![0; plan.nodes.len()];
        plan.blocks.iter().for_each(|block| before[block.node] += 1);
        let mut paired = vec![false; plan.nodes.len()];
        for at in 0..plan.nodes.len() {
            if std::mem::replace(&mut paired[at], true) {
                continue;
            }
            let turn = plan.pair(at, &before);
            if let Turn::Pair(_) = turn {
                paired[plan.right(at)[0].node] = true;
            }
            plan.turns.push(turn);
        }
        plan
    }

    /// A body with its joint, or a node alone; `before` counts the nodes before each that are coupled with it.
    fn pair(&self, at: usize, before: &[usize]) -> Turn {
        let body = &self.nodes[at];
        let [to_joint] = self.right(at) else { return Turn::Node(at) };
        // The joint would come before another body that has to precede it.
        if before[to_joint.node] > 1 {
            return Turn::Node(at);
        }
        let joint = &self.nodes[to_joint.node];
        let above = match self.right(to_joint.node) {
            [] => None,
            [up] if self.nodes[up.node].size == body.size => {
                let other = &self.nodes[up.node];
                Some(Above { body: other.offset, jacobian: up.at, mass: other.diagonal })
            }
            _ => return Turn::Node(at),
        };
        if body.is_joint || !joint.is_joint || joint.closes || joint.size > body.size {
            return Turn::Node(at);
        }
        Turn::Pair(Pair {
            size: body.size,
            rows: joint.size,
            body: body.offset,
            joint: joint.offset,
            mass: body.diagonal,
            jacobian: to_joint.at,
            schur: joint.diagonal,
            above,
        })
    }

    /// Whether the matrix has blocks that neither masses nor J set.
    pub(crate) fn has_fill(&self) -> bool {
        self.turns.iter().any(
            |turn| matches!(turn, Turn::Node(at) if !self.right(*at).is_empty() || self.nodes[*at].is_joint),
        )
    }

    fn right(&self, node: usize) -> &[Right] {
        &self.blocks[self.nodes[node].first..self.nodes[node].end]
    }

    /// Where a block begins; `row` ≤ `column`, which must be coupled.
    fn block(&self, row: usize, column: usize) -> usize {
        if row == column {
            return self.nodes[row].diagonal;
        }
        let right = self.right(row);
        right[right.partition_point(|block| block.node < column)].at
    }

    /// The length of vectors.
    pub(crate) fn length(&self) -> usize {
        self.length
    }

    /// Where the entries of a body begin in vectors.
    pub(crate) fn body(&self, body: usize) -> usize {
        self.nodes[self.place[body]].offset
    }

    /// Where the rows of a joint begin in vectors.
    pub(crate) fn joint(&self, joint: usize) -> usize {
        self.nodes[self.place[self.bodies + joint]].offset
    }

    /// Where the diagonal block of a body begins in the matrix.
    pub(crate) fn mass(&self, body: usize) -> usize {
        self.nodes[self.place[body]].diagonal
    }

    /// Where the rows of a joint meet a body.
    pub(crate) fn jacobian(&self, joint: usize, body: usize) -> Place {
        let (row, column) = (self.place[self.bodies + joint], self.place[body]);
        Place { at: self.block(row.min(column), row.max(column)), transposed: column < row }
    }

    /// Whether joints close loops.
    pub(crate) fn has_loops(&self) -> bool {
        self.closing > 0
    }
}
