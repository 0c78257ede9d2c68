//! The order in which bodies and joints of rigid rows are eliminated from
//!
//! ```text
//! M a + Jᵀ μ = f,   J a = γ
//! ```
//!
//! In: which nodes are coupled, and which bodies each joint acts on. Out: an elimination order of small fill in
//! which every pivot exists. A spanning tree decides which joint holds which body: such a joint has a pivot
//! once this body is eliminated. The other joints close loops; they wait until all their bodies are
//! eliminated, and their rows may repeat what others say. A tree has no fill.

use std::collections::BTreeSet;

/// The rigid rows of a constraint.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Joint {
    /// The nodes of its moving bodies.
    pub(crate) bodies: Vec<usize>,
    pub(crate) rows: usize,
}

/// What must precede a joint in the elimination.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Holds this body in the spanning tree.
    Holds(usize),
    /// Closes a loop.
    Closes,
}

/// The role of each joint, for bodies with these numbers of degrees of freedom.
pub(crate) fn roles(dofs: &[usize], joints: &[Joint]) -> Vec<Role> {
    let mut roles = vec![Role::Closes; joints.len()];
    let mut of_body = vec![Vec::new(); dofs.len()];
    for (k, joint) in joints.iter().enumerate() {
        joint.bodies.iter().for_each(|&body| of_body[body].push(k));
    }
    let mut reached = vec![false; dofs.len()];
    let mut used = vec![false; joints.len()];
    let mut queue = Vec::new();
    let mut hold = |k: usize, reached: &mut Vec<bool>, queue: &mut Vec<usize>| {
        let free =
            joints[k].bodies.iter().copied().find(|&body| !reached[body] && dofs[body] >= joints[k].rows);
        if let Some(body) = free.filter(|_| !std::mem::replace(&mut used[k], true)) {
            roles[k] = Role::Holds(body);
            reached[body] = true;
            queue.push(body);
        }
    };
    // Joints with the world come first, then each remaining mechanism from its first body.
    for k in (0..joints.len()).filter(|&k| joints[k].bodies.len() == 1) {
        hold(k, &mut reached, &mut queue);
    }
    let mut next = 0;
    for root in 0..=dofs.len() {
        while next < queue.len() {
            for &k in &of_body[queue[next]] {
                hold(k, &mut reached, &mut queue);
            }
            next += 1;
        }
        if root < dofs.len() && !std::mem::replace(&mut reached[root], true) {
            queue.push(root);
        }
    }
    roles
}

/// The elimination order of nodes, by smallest degree among those whose predecessors are eliminated, and for
/// each node the later nodes that it is coupled with when it is eliminated.
pub(crate) fn eliminate(
    coupled: &[BTreeSet<usize>],
    predecessors: &[Vec<usize>],
) -> Vec<(usize, BTreeSet<usize>)> {
    let mut coupled = coupled.to_vec();
    let mut waiting: Vec<usize> = predecessors.iter().map(Vec::len).collect();
    let mut successors = vec![Vec::new(); coupled.len()];
    for (node, before) in predecessors.iter().enumerate() {
        before.iter().for_each(|&other| successors[other].push(node));
    }
    let mut queue: BTreeSet<(usize, usize)> = (0..coupled.len())
        .filter(|&node| waiting[node] == 0)
        .map(|node| (coupled[node].len(), node))
        .collect();
    let mut rows = Vec::with_capacity(coupled.len());
    while let Some((_, node)) = queue.pop_first() {
        let near = std::mem::take(&mut coupled[node]);
        for &other in &near {
            let set = &mut coupled[other];
            let queued = queue.remove(&(set.len(), other));
            set.remove(&node);
            set.extend(near.iter().filter(|&&third| third != other));
            if queued {
                queue.insert((set.len(), other));
            }
        }
        rows.push((node, near));
        for &other in &successors[node] {
            waiting[other] -= 1;
            if waiting[other] == 0 {
                queue.insert((coupled[other].len(), other));
            }
        }
    }
    rows
}

/// The nodes that precede each node: none for bodies, which come first, then joints by their roles.
pub(crate) fn predecessors(bodies: usize, joints: &[Joint], roles: &[Role]) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new(); bodies];
    all.extend(joints.iter().zip(roles).map(|(joint, role)| match role {
        Role::Holds(body) => vec![*body],
        Role::Closes => joint.bodies.clone(),
    }));
    all
}
