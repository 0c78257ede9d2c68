//! Generalised forces from a force function: C, E or F → F, on the vector graph.
//!
//! In: a checked [`Definition`]. Out: [`Derived`]: the forces as vectors, and the variables along which ∂F/∂X
//! and ∂F/∂V are formed. docs/mathematics.md, "Forces", gives the formulas: F = −Jᵀ(ks C + kd Ċ) for a
//! constraint, F = −D E for an energy, the returned F for a force.
//!
//! If positions enter only through differences, and these are fewer than the moving bodies, the differences
//! are the variables. Each body's block is then a signed copy or sum, so action and reaction cost no
//! operations.

pub mod block;
pub mod forward;
pub mod partials;
pub mod rate;
pub mod reverse;

use crate::derive::forward::{TangentDerivatives, Variable};
use crate::derive::reverse::gradient;
use crate::math::exact::Exact;
use crate::model::bodies::{Block, Role, Slot};
use crate::model::outputs::{Axis, Extra, Part};
use crate::vector::definition::{Definition, Law, Row};
use crate::vector::{Formulation, Graph, Node, Real, Truth, Vector};
use rate::{Motion, Rates};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Σ coefficient · item
pub type Combination<T> = Vec<(Exact, T)>;

/// The forces of a kernel and the variables of their derivatives.
pub struct Derived {
    /// The graph, with derivatives computed on demand.
    pub tangent: TangentDerivatives,
    /// Forces per block of the pose.
    pub forces: Vec<(Block, Combination<Vector>)>,
    /// h F per block if an output needs the step h; the same as `forces` if they contain h, or without h.
    pub impulses: Vec<(Block, Combination<Vector>)>,
    /// For each block of the pose, the variables that move with the block.
    pub pose: Vec<(Block, Combination<Variable>)>,
    /// For each block of the velocity, the variables that move with the block.
    pub velocity: Vec<(Block, Combination<Variable>)>,
    /// Whether ∂F/∂X is symmetric by construction, as for an energy of positions alone.
    pub symmetric: bool,
    /// For each force, and for each impulse: the variable whose adjoint the vector is.
    pub pieces: [BTreeMap<Vector, Variable>; 2],
    /// The rows of C and their rates; E and its rate if an output has rows; empty for a force.
    pub rows: Vec<(Real, Real)>,
    /// The rates of Ċ at constant velocities; empty unless an output needs them.
    pub drifts: Vec<Real>,
    /// The nodes that were made for the drifts.
    pub drift_nodes: Range<usize>,
    /// λ of each row of C, and h λ.
    pub multipliers: Vec<(Real, Real)>,
    /// Jᵀ λ̂ with multipliers λ̂ from an argument; empty unless an output needs it.
    pub pull: Vec<(Block, Combination<Vector>)>,
    /// h F with multipliers from an argument; empty unless an output needs it.
    pub held: Vec<(Block, Combination<Vector>)>,
    /// Maps the multipliers in `held` to the nodes of λ, whose derivatives they have there.
    pub substituted: BTreeMap<u32, u32>,
    /// For each block, the variables of a time step, which moves the pose by h w and the velocity by w.
    pub steps: Vec<(Block, Combination<Variable>)>,
    /// The requested ones of h F + h² ∂F/∂X V, ∂F/∂X p and ∂F/∂V p, per block.
    pub along: BTreeMap<Part, Vec<(Block, Combination<Vector>)>>,
    /// The number of nodes that come from the source; later nodes are derived.
    pub stated: usize,
    /// The requested outputs, in the order of the table.
    pub wanted: Vec<Part>,
}

/// Derives the forces and the requested derivatives; `formulation` selects how derivatives are written. If
/// every requested output of F contains the step h, the forces are impulses h F: h multiplies the gains, E or
/// the returned F.
pub fn derive(definition: &Definition, wanted: &[Part], formulation: Formulation) -> Derived {
    let mut graph = definition.graph.clone();
    let stated = graph.len();
    graph.assume_unit_quaternions();
    graph.formulation = formulation;
    let bodies = graph.signature.clone();
    let mut rows = Vec::new();
    let mut reals = Vec::new();
    let mut vectors = Vec::new();
    let mut direct = BTreeMap::new();
    let mut symmetric = false;
    let steps = wanted.iter().any(|part| part.row().extras.contains(&Extra::Step));
    let time = if steps { bodies.extra_slot("step", 0).map(|slot| graph.entry(slot)) } else { None };
    let bare = |part: &Part| {
        let row = part.row();
        row.of_constraints || row.rows == Axis::Coordinate && !row.extras.contains(&Extra::Step)
    };
    let step = time.filter(|_| !wanted.iter().any(bare));
    // λ, and the given multipliers that replace λ.
    let (mut multipliers, mut held) = (Vec::new(), FixedMultipliers::default());
    match &definition.law {
        Law::Constraint { rows: constraint, unilateral, per_row } => {
            let gains = Gains { first: bodies.parameters.len() - 2, per_row: *per_row, step };
            let mut number = 0;
            for row in constraint {
                let count = row.count();
                let name = |label: &str| {
                    if constraint.len() == 1 { label.to_owned() } else { format!("{label}_{number}") }
                };
                match *row {
                    Row::Vector(c) if !unilateral => {
                        let c = graph.let_vector(&name("c"), c);
                        let rate = Rates::new(&mut graph).vector(c);
                        let rate = graph.let_vector(&name("c_dot"), rate);
                        let stiff = gains.scale(&mut graph, 0, number, c);
                        let damped = gains.scale(&mut graph, 1, number, rate);
                        let multiplier = graph.vector_add(stiff, damped);
                        let multiplier = graph.let_vector(&name("lambda"), multiplier);
                        let opposite = graph.vector_neg(multiplier);
                        vectors.push((c, opposite));
                        multipliers.extend((0..3).map(|axis| graph.component(multiplier, axis)));
                        held.vectors.push((c, multiplier, number));
                        for axis in 0..3 {
                            rows.push((graph.component(c, axis), graph.component(rate, axis)));
                        }
                    }
                    _ => {
                        let parts = match *row {
                            Row::Real(c) => vec![c],
                            Row::Vector(v) => (0..3).map(|axis| graph.component(v, axis)).collect(),
                        };
                        for (k, c) in parts.into_iter().enumerate() {
                            let label = if constraint.len() == 1 && count == 1 {
                                String::new()
                            } else {
                                format!("_{}", number + k)
                            };
                            let c = graph.let_real(&format!("c{label}"), c);
                            let rate = Rates::new(&mut graph).real(c);
                            let rate = graph.let_real(&format!("c{label}_dot"), rate);
                            let (pull, active) = gains.pull(&mut graph, number + k, c, rate, *unilateral);
                            let multiplier =
                                active.map_or(pull, |active| where_true(&mut graph, active, pull));
                            let multiplier = graph.let_real(&format!("lambda{label}"), multiplier);
                            reals.push((c, graph.neg(multiplier)));
                            multipliers.push(multiplier);
                            held.reals.push((c, pull, active, number + k));
                            rows.push((c, rate));
                        }
                    }
                }
                number += count;
            }
        }
        Law::Energy(energy) => {
            let opposite = graph.constant(-Exact::ONE);
            reals.push((*energy, step.map_or(opposite, |h| graph.neg(h))));
            if wanted.iter().any(|part| part.row().rows == Axis::Row) {
                let rate = Rates::new(&mut graph).real(*energy);
                rows.push((*energy, rate));
            }
            symmetric = bodies.pose_blocks().iter().all(|block| block.role == Role::Position);
        }
        Law::Force(forces) => {
            for (body, force) in forces.iter().enumerate() {
                let body = body as u16;
                let mut scaled = |v: Vector| step.map_or(v, |h| graph.scale(h, v));
                direct.insert(Block { body, role: Role::Position }, scaled(force.force));
                if let Some(torque) = force.torque {
                    direct.insert(Block { body, role: Role::Orientation }, scaled(torque));
                }
            }
        }
    }
    let before_drifts = graph.len();
    let drifts = if wanted.contains(&Part::Drift) {
        let mut rates = Rates::new(&mut graph);
        rows.iter().map(|(_, rate)| rates.real(*rate)).collect()
    } else {
        Vec::new()
    };
    let drift_nodes = before_drifts..graph.len();
    let difference_variables = difference_variables(
        &graph,
        reals
            .iter()
            .map(|r| r.0.index())
            .chain(vectors.iter().map(|v| v.0.index()))
            .chain(reals.iter().map(|r| r.1.index()).chain(vectors.iter().map(|v| v.1.index())))
            .chain(direct.values().map(|v| v.index())),
    );
    let pulls = [Part::Pull, Part::Geometric].iter().any(|part| wanted.contains(part));
    let pull = pulls.then(|| held.given(&mut graph));
    let held = time.filter(|_| wanted.contains(&Part::Held)).map(|h| held.pushing(&mut graph, h));
    let multipliers: Vec<(Real, Real)> = match time {
        Some(h) => multipliers.into_iter().map(|x| (x, graph.mul(h, x))).collect(),
        None => multipliers.into_iter().map(|x| (x, x)).collect(),
    };
    let mut tangent = TangentDerivatives::new(graph, difference_variables);
    let pose = columns(&tangent, &bodies.pose_blocks());
    let velocity = columns(&tangent, &bodies.velocity_blocks());
    let mut variables: Vec<Variable> = pose.iter().flat_map(|(_, c)| c.iter().map(|(_, v)| *v)).collect();
    variables.sort();
    variables.dedup();
    let mut pieces = BTreeMap::new();
    let forces: Vec<(Block, Combination<Vector>)> = if direct.is_empty() {
        let found = gradient(&mut tangent, &reals, &vectors, &variables);
        let found: BTreeMap<Variable, Vector> =
            found.into_iter().map(|(variable, v)| (variable, named(&mut tangent, variable, v))).collect();
        pieces.extend(found.iter().map(|(variable, v)| (*v, *variable)));
        shares(&pose, &found)
    } else {
        let blocks = bodies.pose_blocks().into_iter();
        blocks.map(|block| (block, vec![(Exact::ONE, direct[&block])])).collect()
    };
    let mut pushes = BTreeMap::new();
    let impulses = match time.filter(|_| step.is_none()) {
        None => {
            pushes.clone_from(&pieces);
            forces.clone()
        }
        Some(h) => {
            let mut scaled = |(c, v): &(Exact, Vector)| {
                let impulse = tangent.graph.scale(h, *v);
                if let Some(variable) = pieces.get(v).copied() {
                    pushes.insert(impulse, variable);
                }
                (c.clone(), impulse)
            };
            let forces = forces.iter();
            forces.map(|(block, sum)| (*block, sum.iter().map(&mut scaled).collect())).collect()
        }
    };
    let pull = pull.map_or_else(Vec::new, |(reals, vectors)| {
        shares(&pose, &gradient(&mut tangent, &reals, &vectors, &variables))
    });
    let (held, substituted) = held.map_or_else(Default::default, |((reals, vectors), substituted)| {
        (shares(&pose, &gradient(&mut tangent, &reals, &vectors, &variables)), substituted)
    });
    let steps = tangent.step_with(time, &pose, &velocity);
    let along = along(&mut tangent, wanted, &forces, &impulses, time);
    let (wanted, pieces) = (wanted.to_vec(), [pieces, pushes]);
    Derived {
        tangent,
        forces,
        impulses,
        pose,
        velocity,
        symmetric,
        pieces,
        rows,
        drifts,
        drift_nodes,
        multipliers,
        pull,
        held,
        substituted,
        steps,
        along,
        stated,
        wanted,
    }
}

/// The force on each block of the pose, from the forces on the variables.
fn shares(
    pose: &[(Block, Combination<Variable>)],
    found: &BTreeMap<Variable, Vector>,
) -> Vec<(Block, Combination<Vector>)> {
    let share = |(c, variable): &(Exact, Variable)| found.get(variable).map(|v| (c.clone(), *v));
    pose.iter().map(|(block, moves)| (*block, moves.iter().filter_map(share).collect())).collect()
}

/// The requested derivatives of the forces along one direction, without the matrix.
fn along(
    tangent: &mut TangentDerivatives,
    wanted: &[Part],
    forces: &[(Block, Combination<Vector>)],
    impulses: &[(Block, Combination<Vector>)],
    step: Option<Real>,
) -> BTreeMap<Part, Vec<(Block, Combination<Vector>)>> {
    let mut found = BTreeMap::new();
    for &part in wanted {
        let direction = tangent.graph.signature.extra_slot("direction", 0);
        let motion = match (part, direction) {
            (Part::Impulse, _) => Motion::Velocities,
            (Part::DfdxProduct, Some(direction)) => Motion::Pose(direction),
            (Part::DfdvProduct, Some(direction)) => Motion::Velocity(direction),
            _ => continue,
        };
        let sums = if part == Part::Impulse { impulses } else { forces };
        let mut rates = Rates::along(&mut tangent.graph, motion);
        let mut rate = |(c, v): &(Exact, Vector)| (c.clone(), *v, rates.vector(*v));
        let pairs: Vec<Vec<(Exact, Vector, Vector)>> =
            sums.iter().map(|(_, pieces)| pieces.iter().map(&mut rate).collect()).collect();
        let mut value = |(c, force, rate): (Exact, Vector, Vector)| match (part, step) {
            (Part::Impulse, Some(h)) => {
                let change = tangent.graph.scale(h, rate);
                (c, tangent.graph.vector_add(force, change))
            }
            _ => (c, rate),
        };
        let blocks = sums.iter().map(|(block, _)| *block).zip(pairs);
        let blocks = blocks.map(|(block, pieces)| (block, pieces.into_iter().map(&mut value).collect()));
        found.insert(part, blocks.collect());
    }
    found
}

/// Names a force after the bodies that it acts on.
fn named(tangent: &mut TangentDerivatives, variable: Variable, force: Vector) -> Vector {
    let signature = &tangent.graph.signature;
    let body = |slot: Slot| signature.bodies.get(slot.argument as usize).map_or("world", |b| b.name.as_str());
    let name = match variable {
        Variable::Triple(slot) => format!("force_{}", body(slot)),
        Variable::Difference(first, second) => format!("force_{}_{}", body(first), body(second)),
        Variable::Rotation(slot) => format!("torque_{}", body(slot)),
        Variable::Step(_) => unreachable!("a force acts on a pose"),
    };
    tangent.graph.let_vector(&name, force)
}

/// x where the truth is true, else zero.
fn where_true(graph: &mut Graph, truth: Truth, x: Real) -> Real {
    let zero = graph.zero();
    graph.select(truth, x, zero)
}

/// Rows of C, each with its λ and its number; for a one-sided row λ while active, and whether it is active.
#[derive(Default)]
struct FixedMultipliers {
    reals: Vec<(Real, Real, Option<Truth>, usize)>,
    vectors: Vec<(Vector, Vector, usize)>,
}

/// Rows of C, each with an adjoint.
type Adjoints = (Vec<(Real, Real)>, Vec<(Vector, Vector)>);

impl FixedMultipliers {
    /// The rows of C, each with its given multiplier: their gradient is Jᵀ λ̂.
    fn given(&self, graph: &mut Graph) -> Adjoints {
        let slot = |graph: &Graph, number: usize| {
            let slot = graph.signature.extra_slot("multipliers", number as u32);
            slot.expect("an output that needs this argument was requested")
        };
        let reals = self.reals.iter().map(|(c, .., number)| (*c, graph.entry(slot(graph, *number))));
        let reals = reals.collect();
        let vectors = self.vectors.iter().map(|(c, _, number)| (*c, graph.triple(slot(graph, *number))));
        (reals, vectors.collect())
    }

    /// The rows of C, each with −h times its given multiplier, zero for an inactive row; and a map from given
    /// multipliers to the nodes of λ.
    fn pushing(&self, graph: &mut Graph, h: Real) -> (Adjoints, BTreeMap<u32, u32>) {
        let (mut reals, mut vectors) = self.given(graph);
        let mut substituted = BTreeMap::new();
        for ((_, adjoint), (_, pull, active, _)) in reals.iter_mut().zip(&self.reals) {
            substituted.insert(adjoint.0, pull.0);
            let own = active.map_or(*adjoint, |active| where_true(graph, active, *adjoint));
            let push = graph.mul(h, own);
            *adjoint = graph.neg(push);
        }
        for ((_, adjoint), (_, multiplier, _)) in vectors.iter_mut().zip(&self.vectors) {
            substituted.insert(adjoint.0, multiplier.0);
            let push = graph.scale(h, *adjoint);
            *adjoint = graph.vector_neg(push);
        }
        ((reals, vectors), substituted)
    }
}

/// The positions of a constraint's `stiffness` and `damping` among the parameters.
struct Gains {
    first: usize,
    per_row: bool,
    /// The factor of both gains, if any.
    step: Option<Real>,
}

impl Gains {
    fn gain(&self, g: &mut Graph, which: usize, row: usize) -> Real {
        let offset = if self.per_row { row as u32 } else { 0 };
        let slot = g.signature.parameter_slot(self.first + which, offset);
        let gain = g.entry(slot);
        let Some(h) = self.step else { return gain };
        let scaled = g.mul(h, gain);
        let row = if self.per_row { format!("_{row}") } else { String::new() };
        g.let_real(&format!("step_{}{row}", ["stiffness", "damping"][which]), scaled)
    }

    fn scale(&self, g: &mut Graph, which: usize, row: usize, v: Vector) -> Vector {
        if !self.per_row {
            let gain = self.gain(g, which, row);
            return g.scale(gain, v);
        }
        let entries = [0, 1, 2].map(|axis| {
            let gain = self.gain(g, which, row + axis);
            let entry = g.component(v, axis as u8);
            g.mul(gain, entry)
        });
        g.pack(entries)
    }

    /// ks C + kd Ċ, and for a one-sided row the condition under which it pushes: C < 0 and ks C + kd Ċ < 0.
    fn pull(
        &self,
        g: &mut Graph,
        row: usize,
        c: Real,
        rate: Real,
        unilateral: bool,
    ) -> (Real, Option<Truth>) {
        let (stiffness, damping) = (self.gain(g, 0, row), self.gain(g, 1, row));
        let (stiff, damped) = (g.mul(stiffness, c), g.mul(damping, rate));
        let pull = g.add(stiff, damped);
        if !unilateral {
            return (pull, None);
        }
        let pull = g.let_real("pull", pull);
        let zero = g.zero();
        let (touching, pushing) = (g.less(c, zero), g.less(pull, zero));
        (pull, Some(g.and(touching, pushing)))
    }
}

/// The differences that serve as variables. A role's differences qualify if the role enters through nothing
/// else, every difference is of two bodies, and there are fewer differences than moving bodies.
fn difference_variables(graph: &Graph, roots: impl Iterator<Item = usize>) -> BTreeSet<(Slot, Slot)> {
    let mut open: Vec<u32> = roots.map(|r| r as u32).collect();
    let mut seen = vec![false; graph.len()];
    let mut differences: BTreeMap<Role, BTreeSet<(Slot, Slot)>> = BTreeMap::new();
    let mut bare = BTreeSet::new();
    let mut moved: BTreeMap<Role, BTreeSet<u16>> = BTreeMap::new();
    let role = |slot: Slot| graph.signature.role(slot);
    while let Some(index) = open.pop() {
        if std::mem::replace(&mut seen[index as usize], true) {
            continue;
        }
        let node = graph.node(index as usize);
        match *node {
            Node::Triple(slot) | Node::Entry(slot) => bare.extend(role(slot)),
            Node::Difference(first, second) => match (role(first), role(second)) {
                (Some(a), Some(b)) if a == b => {
                    differences.entry(a).or_default().insert((first, second));
                    moved.entry(a).or_default().extend([first.argument, second.argument]);
                }
                (a, b) => bare.extend(a.into_iter().chain(b)),
            },
            _ => {}
        }
        open.extend(node.operands());
    }
    let usable =
        |role: &Role, set: &BTreeSet<(Slot, Slot)>| !bare.contains(role) && set.len() < moved[role].len();
    differences.into_iter().filter(|(role, set)| usable(role, set)).flat_map(|(_, set)| set).collect()
}

/// The variables that move with each block: its stored triple or orientation, or the differences with it.
fn columns(tangent: &TangentDerivatives, blocks: &[Block]) -> Vec<(Block, Combination<Variable>)> {
    let mut columns = Vec::new();
    for block in blocks {
        let direct = tangent.variable(block.body, block.role);
        let mut moves = Vec::new();
        if let Variable::Triple(slot) = direct {
            for &(first, second) in &tangent.difference_variables {
                if first == slot {
                    moves.push((Exact::ONE, Variable::Difference(first, second)));
                }
                if second == slot {
                    moves.push((-Exact::ONE, Variable::Difference(first, second)));
                }
            }
        }
        if moves.is_empty() {
            moves.push((Exact::ONE, direct));
        }
        columns.push((*block, moves));
    }
    columns
}
