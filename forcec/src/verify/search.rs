//! Searches for states on arms of branches that drawn states miss, and next to their edges.
//!
//! In: a function as written, evaluated in doubles, and an arm of a branch. Out: a state on the arm, or
//! `None`. An arm is active if every condition leading to it is satisfied; from a start the search satisfies
//! these conditions one after another, by steps along the gradient of the compared difference. The number of
//! steps is bounded, and equal starts give equal states. The exact oracle decides whether a state is regular.

mod wishes;

use crate::math::functions::Function;
use crate::math::random::Random;
use crate::model::bodies::{Domain, ParameterType, Role};
use crate::sample::inputs::Places;
use crate::sample::states::{Family, State, draw, project, seed};
use crate::source::span::Span;
use crate::vector::definition::{Definition, Law, Row};
use crate::vector::{Graph, Node};
use crate::verify::report::Branch;
use crate::verify::source::{Fields, Source, Values, field_bit};
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// The number of steps from one start.
const STEPS: usize = 48;
/// The number of node evaluations per kernel: about a second.
const BUDGET: u64 = 20_000_000;
/// The number of starts of a search.
const STARTS: usize = 12;

/// The number of times a step is halved.
const HALVINGS: i32 = 7;

/// The inputs that a search moves.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Movable {
    Bodies,
    Parameters,
    All,
}

/// A node or row that selects a branch.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Decider {
    /// A one-sided row; the side is whether the row pushes.
    Row(usize),
    /// A node of [`Source::branches`].
    Node(usize),
}

/// An operand of a comparison.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Term {
    Number(f64),
    Real(usize),
    Component(usize, usize),
}

/// The wanted relation of two terms.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Want {
    Below,
    Above,
    Zero,
    Apart,
}

/// A comparison with its wanted outcome.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Wish {
    x: Term,
    y: Term,
    want: Want,
}

impl Wish {
    fn holds(&self, gap: f64) -> bool {
        match self.want {
            Want::Below => gap < 0.0,
            Want::Above => gap > 0.0,
            Want::Zero => gap == 0.0,
            Want::Apart => gap != 0.0,
        }
    }
}

/// A state from which a search starts.
#[derive(Clone)]
pub(crate) struct Start {
    pub(crate) values: Vec<f64>,
    /// The typical distance between the bodies.
    length: f64,
}

/// A state at which a difference vanishes, and the motion of the inputs that changes the difference by one.
struct Edge {
    values: Vec<f64>,
    way: Vec<f64>,
    /// The change of the difference over the scale of the inputs.
    size: f64,
}

/// The search of states for one kernel.
pub(crate) struct Search<'d> {
    graph: &'d Graph,
    places: &'d Places,
    source: Source<'d, f64>,
    rows: Vec<Term>,
    roots: Vec<usize>,
    unilateral: bool,
    constraint: bool,
    starts: Vec<Start>,
    spent: Cell<u64>,
}

/// For each node, the distance to a state where its value counts, and the next node on the way.
struct Routes {
    distance: Vec<f64>,
    /// The user on the way to a node, or the row that contains the node.
    from: Vec<Option<Decider>>,
}

impl<'d> Search<'d> {
    pub(crate) fn new(
        definition: &'d Definition,
        places: &'d Places,
        constraint: bool,
        from: u64,
    ) -> Search<'d> {
        let vector = |v: usize| [0, 1, 2].map(|axis| Term::Component(v, axis));
        let (rows, unilateral): (Vec<Term>, bool) = match &definition.law {
            Law::Constraint { rows, unilateral, .. } => {
                let terms = rows.iter().flat_map(|row| match row {
                    Row::Real(x) => vec![Term::Real(x.index())],
                    Row::Vector(v) => vector(v.index()).to_vec(),
                });
                (terms.collect(), *unilateral)
            }
            Law::Energy(energy) => (vec![Term::Real(energy.index())], false),
            Law::Force(forces) => {
                let moving = places.signature.moving().map(|(body, _)| &forces[body]);
                let blocks = moving.flat_map(|f| std::iter::once(f.force).chain(f.torque));
                (blocks.flat_map(|v| vector(v.index())).collect(), false)
            }
        };
        let node = |term: &Term| match term {
            Term::Real(node) | Term::Component(node, _) => Some(*node),
            Term::Number(_) => None,
        };
        let roots: Vec<usize> = rows.iter().filter_map(node).collect();
        let source = Source::new(&definition.graph, places, roots.iter().copied());
        let named = places.signature.scale.named.len().min(8);
        let families = [(Family::Random, STARTS - 4), (Family::Rest, 2), (Family::NearSingular, 2)];
        let families = families.into_iter().chain((named > 0).then_some((Family::Named, named)));
        let starts = families.flat_map(|(family, count)| {
            (0..count).map(move |index| {
                let mut random = Random::new(seed(from, family, (1 << 21) + index as u64));
                let State { values, .. } = draw(places, constraint, family, index, &mut random);
                let scale = &places.signature.scale;
                let length = match family {
                    Family::Named => scale.named[index % scale.named.len()],
                    _ => scale.length.unwrap_or(1.0),
                };
                Start { values, length }
            })
        });
        let starts = starts.collect();
        let graph = &definition.graph;
        Search { graph, places, source, rows, roots, unilateral, constraint, starts, spent: Cell::new(0) }
    }

    /// All deciders: rows first, then nodes from the outputs inwards.
    pub(crate) fn deciders(&self) -> Vec<Decider> {
        let mut deciders: Vec<Decider> = Vec::new();
        let mut seen = BTreeSet::new();
        if self.unilateral {
            deciders.extend((0..self.rows.len()).map(Decider::Row));
        }
        let mut valued = vec![false; self.graph.len()];
        self.roots.iter().for_each(|root| valued[*root] = true);
        for (index, node) in self.source.nodes().rev().filter(|(_, node)| node.is_value()) {
            if !valued[index] {
                continue;
            }
            let decider = match node {
                Node::Select(c, x, y) => (x != y).then(|| c.index()),
                Node::VectorSelect(c, u, v) => (u != v).then(|| c.index()),
                _ => node.branches().then_some(index),
            };
            if let Some(decider) = decider.map(Decider::Node)
                && seen.insert(decider)
            {
                deciders.push(decider);
            }
            self.values_read(node, |operand| valued[operand] = true);
        }
        deciders
    }

    /// Visits the operands that contribute to a node's value, not its conditions.
    fn values_read(&self, node: &Node, mut read: impl FnMut(usize)) {
        for operand in node.operands().into_iter().map(|operand| operand as usize) {
            if self.graph.node(operand).is_value() {
                read(operand);
            }
        }
    }

    fn spend(&self, nodes: usize) -> bool {
        self.spent.set(self.spent.get() + nodes as u64);
        self.spent.get() < BUDGET
    }

    fn evaluate(&self, point: &[f64]) -> Values<'static, f64> {
        self.source.evaluate(point)
    }

    fn term(&self, values: &Values<f64>, term: Term) -> f64 {
        term_of(&self.source, values, term)
    }

    fn gap(&self, values: &Values<f64>, wish: &Wish) -> f64 {
        self.term(values, wish.x) - self.term(values, wish.y)
    }

    /// The distance of a wish from being satisfied: 0 if satisfied, at most 1 otherwise.
    fn miss(&self, values: &Values<f64>, wish: &Wish) -> f64 {
        let gap = self.gap(values, wish);
        if wish.holds(gap) {
            return 0.0;
        }
        let size = self.term(values, wish.x).abs() + self.term(values, wish.y).abs();
        let miss = gap.abs() / (gap.abs() + size + f64::MIN_POSITIVE);
        if miss.is_nan() { 1.0 } else { 0.1 + 0.9 * miss }
    }

    /// The movable inputs with their step sizes and fields.
    fn weights(&self, start: &Start, movable: Movable) -> Vec<(usize, f64, Fields)> {
        let signature = &self.places.signature;
        let mut weights = Vec::new();
        for (body, argument) in signature.bodies.iter().enumerate().filter(|_| movable != Movable::Parameters)
        {
            for field in argument.kind.row().fields {
                let (Some(at), Some(slot)) =
                    (self.places.field(body, field.role), signature.body_slot(body as u16, field.role))
                else {
                    continue;
                };
                let weight = match field.role {
                    Role::Velocity | Role::AngularVelocity if argument.fixed => continue,
                    Role::Position | Role::Velocity => start.length,
                    Role::Orientation | Role::AngularVelocity => 1.0,
                };
                let bit = field_bit(self.places, slot);
                weights.extend((at..at + field.length as usize).map(|at| (at, weight, bit)));
            }
        }
        let count = signature.parameters.len() - if self.constraint { 2 } else { 0 };
        for (p, parameter) in
            signature.parameters.iter().take(count).enumerate().filter(|_| movable != Movable::Bodies)
        {
            let at = self.places.parameter(p);
            let length = parameter.ty.length() as usize;
            let size = start.values[at..at + length].iter().map(|x| x.abs()).fold(0.0, f64::max);
            let weight = match (parameter.ty.innermost(), parameter.domain) {
                _ if parameter.value.is_some() => continue,
                (_, Domain::Range(low, high)) => 0.3 * (high - low).min(size.max(1e-3 * (high - low))),
                (ParameterType::Quaternion, _) | (_, Domain::Unit) => 0.3,
                (_, Domain::Any) => 0.3 * size,
            };
            let bit = field_bit(self.places, signature.parameter_slot(p, 0));
            weights.extend((at..at + length).map(|at| (at, weight, bit)));
        }
        weights.retain(|(_, weight, _)| *weight > 0.0 && weight.is_finite());
        weights
    }

    /// The motion of the inputs that changes a difference by one, and the difference's change over the
    /// weights.
    fn way(&self, part: &Part<'d>, start: &Start, wish: &Wish, movable: Movable) -> Option<(Vec<f64>, f64)> {
        let gap = part.gap(&start.values, wish)?;
        let mut way = vec![0.0; start.values.len()];
        let mut size = 0.0;
        let mut moved = start.values.clone();
        for (at, weight, bit) in self.weights(start, movable) {
            if part.depends & bit == 0 || !self.spend(part.nodes) {
                continue;
            }
            let before = moved[at];
            // Small enough for a slope, large enough to keep digits.
            moved[at] = before + 1e-6 * weight.max(1e-6 * before.abs());
            let step = moved[at] - before;
            let slope = part.gap(&moved, wish).map_or(0.0, |after| (after - gap) / step);
            moved[at] = before;
            if slope.is_finite() {
                way[at] = weight * weight * slope;
                size += (weight * slope) * (weight * slope);
            }
        }
        if size <= 0.0 || !size.is_finite() {
            return None;
        }
        way.iter_mut().for_each(|x| *x /= size);
        Some((way, size.sqrt()))
    }

    fn moved(&self, values: &[f64], way: &[f64], by: f64) -> Vec<f64> {
        let mut moved: Vec<f64> = values.iter().zip(way).map(|(x, way)| x + by * way).collect();
        project(self.places, &mut moved);
        moved
    }

    fn part(&self, wish: &Wish) -> Part<'d> {
        let nodes = [wish.x, wish.y].into_iter().filter_map(|term| match term {
            Term::Number(_) => None,
            Term::Real(node) | Term::Component(node, _) => Some(node),
        });
        let nodes: Vec<usize> = nodes.collect();
        let source = Source::new(self.graph, self.places, nodes.iter().copied());
        let depends = nodes.iter().fold(0, |all, node| all | source.depends(*node));
        Part { nodes: source.nodes().count(), source, depends }
    }

    /// A state, searched from a start, that reaches a decider with this side; without target, a regular
    /// state.
    fn reach(&self, start: &Start, target: Option<(Decider, bool)>, random: &mut Random) -> Option<Start> {
        let mut here = start.clone();
        let mut stuck = 0;
        for number in 0..STEPS {
            if !self.spend(2 * self.graph.len()) {
                return None;
            }
            let values = self.evaluate(&here.values);
            let mut wishes = Vec::new();
            if let Some((decider, side)) = target {
                let (before, own) = self.wishes(&values, decider, side);
                wishes.extend(before);
                wishes.extend(own);
            }
            let misses = |wish: &Wish| !wish.holds(self.gap(&values, wish));
            let unmet: Vec<Wish> = wishes.iter().copied().filter(misses).collect();
            let outside: Vec<Wish> = self.domains(&values).into_iter().filter(misses).collect();
            let blind = unmet.iter().any(|wish| self.gap(&values, wish).is_nan());
            let list = if unmet.is_empty() || (blind && !outside.is_empty()) { &outside } else { &unmet };
            let Some(wish) = list.get(number % list.len().max(1)) else { return Some(here) };
            let part = self.part(wish);
            let movable = [Movable::Bodies, Movable::Parameters, Movable::All][number % 3];
            let way =
                self.way(&part, &here, wish, movable).or_else(|| self.way(&part, &here, wish, Movable::All));
            let Some(((way, size), gap)) = way.zip(part.gap(&here.values, wish)) else {
                self.kick(&mut here, random);
                continue;
            };
            let beyond = (0.2 * gap.abs()).max(1e-3 * size);
            let aim = match wish.want {
                Want::Below => -beyond,
                Want::Above => beyond,
                Want::Zero => 0.0,
                Want::Apart => 1e-3 * size,
            };
            let nearer = |next: &Vec<f64>| {
                part.gap(next, wish).is_some_and(|after| (after - aim).abs() < (gap - aim).abs())
            };
            let tries = (0..HALVINGS).map(|k| self.moved(&here.values, &way, (aim - gap) * 0.5f64.powi(k)));
            match tries.into_iter().find(nearer) {
                Some(next) => (here.values, stuck) = (next, 0),
                // A random jump if no group of inputs brings the state nearer.
                None if stuck == 2 => {
                    self.kick(&mut here, random);
                    stuck = 0;
                }
                None => stuck += 1,
            }
        }
        None
    }

    /// Moves all inputs by random amounts.
    fn kick(&self, start: &mut Start, random: &mut Random) {
        let size = random.decades(-2, 2);
        for (at, weight, _) in self.weights(start, Movable::All) {
            start.values[at] += weight * size * random.uniform(-1.0, 1.0);
        }
        project(self.places, &mut start.values);
    }

    /// States that reach a decider with this side, searched from the starts and from earlier results.
    pub(crate) fn find(
        &mut self,
        decider: Decider,
        side: bool,
        count: usize,
        random: &mut Random,
    ) -> Vec<State> {
        let mut order: Vec<(f64, usize)> = Vec::new();
        for (index, start) in self.starts.iter().enumerate() {
            let values = self.evaluate(&start.values);
            let (before, own) = self.wishes(&values, decider, side);
            let miss = before.iter().chain(&own).map(|wish| self.miss(&values, wish)).sum();
            order.push((miss, index));
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut found: Vec<Start> = Vec::new();
        for (_, index) in order {
            if found.len() == count || !self.spend(0) {
                break;
            }
            found.extend(self.reach(&self.starts[index], Some((decider, side)), random));
        }
        // A row with velocities need not push; at rest it does.
        let mut states: Vec<State> = Vec::new();
        for start in &found {
            if self.unilateral {
                let mut rest = start.values.clone();
                for (body, _) in self.places.signature.bodies.iter().enumerate() {
                    for at in [Role::Velocity, Role::AngularVelocity]
                        .into_iter()
                        .filter_map(|r| self.places.field(body, r))
                    {
                        rest[at..at + 3].fill(0.0);
                    }
                }
                states.push(State { values: rest, scale: start.length });
            }
            states.push(State { values: start.values.clone(), scale: start.length });
        }
        self.starts.extend(found.into_iter().take(1));
        states
    }

    /// The state moved to where all functions have values and derivatives.
    pub(crate) fn regular(&self, state: &State, random: &mut Random) -> Option<State> {
        let length = self.places.signature.scale.length.unwrap_or(1.0);
        let start = Start { values: state.values.clone(), length: state.scale.min(length) };
        let found = self.reach(&start, None, random)?;
        Some(State { values: found.values, scale: state.scale })
    }

    /// States on both sides of a decider's edge, nearer and nearer, from a start that reaches the decider.
    fn near_decider(&self, decider: Decider, count: usize, turn: usize) -> Vec<State> {
        for start in self.starts.iter().rev() {
            let values = self.evaluate(&start.values);
            for side in [true, false] {
                let (before, own) = self.wishes(&values, decider, side);
                let met = before.iter().all(|wish| wish.holds(self.gap(&values, wish)));
                let turns: Vec<&Wish> =
                    own.iter().filter(|wish| !wish.holds(self.gap(&values, wish))).collect();
                if let (true, [wish, ..]) = (met, turns.as_slice())
                    && let Some(edge) = self.edge(start, wish)
                {
                    return self.around(&edge, start.length, count, turn);
                }
            }
        }
        Vec::new()
    }

    /// A zero of a wish's difference, by Newton's method.
    fn edge(&self, start: &Start, wish: &Wish) -> Option<Edge> {
        let part = self.part(wish);
        let mut here = start.clone();
        for number in 0..STEPS {
            let gap = part.gap(&here.values, wish)?;
            let (way, size) = self
                .way(&part, &here, wish, Movable::Bodies)
                .or_else(|| self.way(&part, &here, wish, Movable::All))?;
            if gap.abs() <= 1e-14 * size || number + 1 == STEPS {
                return (gap.abs() <= 1e-6 * size).then_some(Edge { values: here.values, way, size });
            }
            let next = self.moved(&here.values, &way, -gap);
            match part.gap(&next, wish) {
                Some(after) if after.abs() < gap.abs() => here.values = next,
                _ => return (gap.abs() <= 1e-6 * size).then_some(Edge { values: here.values, way, size }),
            }
        }
        None
    }

    /// States next to an edge, alternating between its sides, at 1e-3 to 1e-12 of the scale.
    fn around(&self, edge: &Edge, length: f64, count: usize, turn: usize) -> Vec<State> {
        let states = (0..count).map(|number| {
            let away = [1e-3, 1e-7, 1e-11, 1e-5, 1e-9, 1e-12][(number / 2 + turn) % 6];
            let sign = if number % 2 == 0 { 1.0 } else { -1.0 };
            let values = self.moved(&edge.values, &edge.way, sign * away * edge.size);
            State { values, scale: length * away }
        });
        states.collect()
    }

    /// About `count` states next to edges of deciders and next to zeros.
    pub(crate) fn edges(&self, deciders: &[Decider], count: usize) -> Vec<State> {
        let mut states = self.zeros(count / 2);
        let left = count - states.len().min(count);
        if let Some(each) = left.checked_div(deciders.len()) {
            // Both sides of each decider, or of as many deciders as there are states for.
            let stride = (2 * deciders.len()).div_ceil(left.max(2));
            for (turn, decider) in deciders.iter().step_by(stride).enumerate() {
                states.extend(self.near_decider(*decider, (each & !1).clamp(2, 6), turn));
            }
        }
        states
    }

    /// All branches for a report, with the numbers of states at which their arms were active.
    pub(crate) fn branches(
        &self,
        definition: &Definition,
        active: &BTreeMap<(Decider, bool), usize>,
    ) -> Vec<Branch> {
        let spans: BTreeMap<usize, Span> = definition.branches.iter().copied().collect();
        let mut chosen: BTreeMap<usize, usize> = BTreeMap::new();
        for (index, node) in self.source.nodes() {
            if let Node::Select(c, ..) | Node::VectorSelect(c, ..) = node {
                chosen.entry(c.index()).or_insert(index);
            }
        }
        let branch = |decider: Decider| {
            let states = [true, false].map(|side| active.get(&(decider, side)).copied().unwrap_or(0));
            let (what, arms, node) = match decider {
                Decider::Row(row) => (format!("row {}", row + 1), ["pushes", "idle"], None),
                Decider::Node(node) => match self.graph.node(node) {
                    Node::Call(function @ (Function::Min | Function::Max), _) => {
                        (function.row().name.to_owned(), ["first", "second"], Some(node))
                    }
                    Node::Call(function, _) => {
                        (function.row().name.to_owned(), ["below zero", "above"], Some(node))
                    }
                    _ => ("if".to_owned(), ["then", "else"], chosen.get(&node).copied()),
                },
            };
            Branch { what, arms, states, span: node.and_then(|node| spans.get(&node).copied()), line: None }
        };
        self.deciders().into_iter().map(branch).collect()
    }

    /// At most `most` states next to zeros of norms and of sums with a constant.
    pub(crate) fn zeros(&self, most: usize) -> Vec<State> {
        let mut states = Vec::new();
        for norms in [true, false] {
            let zeros = self.source.nodes().filter(|(_, node)| match node {
                Node::Norm(_) => norms,
                Node::Sum(constant, _) => !norms && !constant.is_zero(),
                _ => false,
            });
            for (number, (index, _)) in zeros.take(most).enumerate() {
                let wish = Wish { x: Term::Real(index), y: Term::Number(0.0), want: Want::Zero };
                let start = &self.starts[number % (STARTS - 4)];
                if let Some(edge) = self.edge(start, &wish) {
                    states.extend(self.around(&edge, start.length, 2, number));
                }
                if states.len() >= most || !self.spend(0) {
                    return states;
                }
            }
        }
        states
    }
}

fn term_of(source: &Source<'_, f64>, values: &Values<f64>, term: Term) -> f64 {
    match term {
        Term::Number(x) => x,
        Term::Real(node) => *source.get(values, node).real(),
        Term::Component(node, axis) => source.get(values, node).vector()[axis],
    }
}

/// The part of the source that one wish depends on.
struct Part<'d> {
    source: Source<'d, f64>,
    nodes: usize,
    depends: Fields,
}

impl Part<'_> {
    fn gap(&self, point: &[f64], wish: &Wish) -> Option<f64> {
        let values = self.source.evaluate(point);
        let gap = term_of(&self.source, &values, wish.x) - term_of(&self.source, &values, wish.y);
        gap.is_finite().then_some(gap)
    }
}
