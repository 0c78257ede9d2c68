//! Forward-mode derivatives of reals and vectors in time, Ċ = J V, or along a direction.
//!
//! In: nodes that depend on pose and velocity. Out: the rates, nodes that also depend on the velocities or
//! the direction. The rate of a let is a let: `d` has `d_dot`.

use crate::derive::forward::{RotatedArm, Variable, partial_of_product};
use crate::derive::partials::partial;
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::{Role, Slot};
use crate::vector::{Graph, Node, Real, Vector};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};

/// The motion that rates are taken along.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Motion {
    /// The poses move with the velocities; the velocities are constant.
    Velocities,
    /// The poses move along a direction, the argument at this slot.
    Pose(Slot),
    /// The velocities move along a direction, the argument at this slot.
    Velocity(Slot),
}

/// A graph with a cache of rates.
pub struct Rates<'g> {
    graph: &'g mut Graph,
    motion: Motion,
    memo: FxHashMap<u32, Rate>,
}

#[derive(Clone, Copy)]
enum Rate {
    Real(Real),
    Vector(Vector),
    None,
}

impl Rates<'_> {
    /// Creates an empty cache, for bodies that move with their velocities.
    pub fn new(graph: &mut Graph) -> Rates<'_> {
        Rates::along(graph, Motion::Velocities)
    }

    /// Creates an empty cache.
    pub fn along(graph: &mut Graph, motion: Motion) -> Rates<'_> {
        Rates { graph, motion, memo: FxHashMap::default() }
    }

    /// dx/dt
    pub fn real(&mut self, x: Real) -> Real {
        self.prepare(x.0);
        self.real_of(x)
    }

    /// dv/dt
    pub fn vector(&mut self, v: Vector) -> Vector {
        self.prepare(v.0);
        self.vector_of(v)
    }

    fn real_of(&self, x: Real) -> Real {
        match self.memo[&x.0] {
            Rate::Real(rate) => rate,
            _ => unreachable!("a real has a real rate"),
        }
    }

    fn vector_of(&self, v: Vector) -> Vector {
        match self.memo[&v.0] {
            Rate::Vector(rate) => rate,
            _ => unreachable!("a vector has a vector rate"),
        }
    }

    fn prepare(&mut self, root: u32) {
        let mut open = vec![root];
        let mut missing = BTreeSet::new();
        while let Some(index) = open.pop() {
            if !self.memo.contains_key(&index) && missing.insert(index) {
                open.extend(self.graph.node(index as usize).operands());
            }
        }
        for index in missing {
            let rate = self.rate(index);
            self.memo.insert(index, rate);
        }
    }

    fn rate(&mut self, index: u32) -> Rate {
        let node = self.graph.node(index as usize).clone();
        match node {
            Node::Known(_) | Node::Compare(..) | Node::And(..) | Node::Or(..) | Node::Not(_) => Rate::None,
            Node::Triple(slot) => Rate::Vector(self.triple(slot)),
            Node::Difference(first, second) => {
                let rates = [self.velocity(first), self.velocity(second)];
                Rate::Vector(match rates {
                    [Some(first), Some(second)] => self.graph.difference(first, second),
                    _ => {
                        let (first, second) = (self.triple(first), self.triple(second));
                        self.graph.vector_sub(first, second)
                    }
                })
            }
            Node::VectorOffset(v, _) => Rate::Vector(self.vector_of(v)),
            Node::VectorSum(terms) => {
                let rates = terms.iter().map(|(c, v)| (c.clone(), self.vector_of(*v))).collect();
                Rate::Vector(self.graph.vector_sum(rates))
            }
            Node::Scale(s, v) => {
                let (ds, dv) = (self.real_of(s), self.vector_of(v));
                let (first, second) = (self.graph.scale(ds, v), self.graph.scale(s, dv));
                Rate::Vector(self.graph.vector_add(first, second))
            }
            Node::Cross(u, v) => {
                let (du, dv) = (self.vector_of(u), self.vector_of(v));
                let (first, second) = (self.graph.cross(du, v), self.graph.cross(u, dv));
                Rate::Vector(self.graph.vector_add(first, second))
            }
            Node::Rotate(quaternion, inverse, v) => {
                let inner = self.vector_of(v);
                let mut rate = self.graph.rotate(quaternion, inverse, inner);
                if let Some(spin) = self.spin(quaternion) {
                    let turned = if inverse {
                        let across = self.graph.cross(v, spin);
                        self.graph.rotate(quaternion, true, across)
                    } else {
                        let rotated = self.graph.rotate(quaternion, false, v);
                        self.graph.cross(spin, rotated)
                    };
                    rate = self.graph.vector_add(rate, turned);
                }
                Rate::Vector(rate)
            }
            Node::TurnVector(turn) => {
                let (u, w) = self.graph.turn(&turn);
                let mut terms = Vec::new();
                for (turned, spin) in self.turn_rates(&turn) {
                    terms.push((turned.coefficient.clone(), turned.vector_part(self.graph, spin, u, w)));
                }
                Rate::Vector(self.graph.vector_sum(terms))
            }
            Node::Pack(entries) => {
                let rates = entries.map(|x| self.real_of(x));
                Rate::Vector(self.graph.pack(rates))
            }
            Node::VectorSelect(condition, u, v) => {
                let (du, dv) = (self.vector_of(u), self.vector_of(v));
                Rate::Vector(self.graph.vector_select(condition, du, dv))
            }
            Node::VectorLet(v) => {
                let rate = self.vector_of(v);
                if matches!(self.graph.node(v.index()), Node::Rotate(..)) {
                    // No let for ω × r of an arm: simplification rewrites f·(ω × r) as ω·(r × f).
                    return Rate::Vector(rate);
                }
                let name = self.rate_name(index);
                Rate::Vector(self.graph.let_vector(&name, rate))
            }
            _ => Rate::Real(self.rate_of_real(index, &node)),
        }
    }

    fn rate_of_real(&mut self, index: u32, node: &Node) -> Real {
        match node {
            Node::Entry(slot) => self.entry(*slot),
            Node::Sum(_, terms) => {
                let rates: Vec<(Exact, Real)> =
                    terms.iter().map(|(c, x)| (c.clone(), self.real_of(*x))).collect();
                self.sum(rates)
            }
            Node::Product(factors) => {
                let mut rates = Vec::new();
                for (k, &(factor, exponent)) in factors.iter().enumerate() {
                    let rate = self.real_of(factor);
                    if !self.graph.is_zero(rate) {
                        let partial = partial_of_product(self.graph, factors, k);
                        rates.push((Exact::from(i64::from(exponent)), self.graph.mul(partial, rate)));
                    }
                }
                self.sum(rates)
            }
            Node::Dot(u, v) => {
                let (du, dv) = (self.vector_of(*u), self.vector_of(*v));
                let rates = vec![(Exact::ONE, self.graph.dot(du, *v)), (Exact::ONE, self.graph.dot(*u, dv))];
                self.sum(rates)
            }
            Node::Component(v, axis) => {
                let rate = self.vector_of(*v);
                self.graph.component(rate, *axis)
            }
            Node::Norm(v) => {
                let rate = self.vector_of(*v);
                let unit = self.graph.normalize(*v);
                self.graph.dot(unit, rate)
            }
            Node::TurnReal(turn) => {
                let (u, _) = self.graph.turn(turn);
                let mut terms = Vec::new();
                for (turned, spin) in self.turn_rates(turn) {
                    terms.push((-&turned.coefficient, self.graph.dot(u, spin)));
                }
                self.graph.sum(Exact::ZERO, terms)
            }
            Node::Call(function @ (Function::Min | Function::Max), arguments) => {
                let (x, y) = (arguments[0], arguments[1]);
                let (dx, dy) = (self.real_of(x), self.real_of(y));
                let below =
                    if *function == Function::Min { self.graph.less(x, y) } else { self.graph.less(y, x) };
                self.graph.select(below, dx, dy)
            }
            Node::Call(function, arguments) => {
                let mut rates = Vec::new();
                for (k, argument) in arguments.iter().enumerate() {
                    let rate = self.real_of(*argument);
                    if !self.graph.is_zero(rate) {
                        let partial = partial(self.graph, *function, arguments, Real(index), k);
                        rates.push((Exact::ONE, self.graph.mul(partial, rate)));
                    }
                }
                self.sum(rates)
            }
            Node::Select(condition, x, y) => {
                let (dx, dy) = (self.real_of(*x), self.real_of(*y));
                self.graph.select(*condition, dx, dy)
            }
            Node::Offset(x, _) => self.real_of(*x),
            Node::Let(x) => {
                let rate = self.real_of(*x);
                let name = self.rate_name(index);
                self.graph.let_real(&name, rate)
            }
            _ => self.graph.zero(),
        }
    }

    fn rate_name(&self, index: u32) -> String {
        let name = self.graph.name(index as usize).unwrap_or("rate");
        match self.motion {
            Motion::Velocities => format!("{name}_dot"),
            Motion::Pose(_) => format!("{name}_dx"),
            Motion::Velocity(_) => format!("{name}_dv"),
        }
    }

    /// The argument entry that is the rate of a position or velocity.
    fn velocity(&self, slot: Slot) -> Option<Slot> {
        match self.graph.signature.role(slot)? {
            Role::Orientation => None,
            role => self.moves(slot, role),
        }
    }

    /// The argument entry that is the rate of a body's field.
    fn moves(&self, slot: Slot, role: Role) -> Option<Slot> {
        let signature = &self.graph.signature;
        let (blocks, direction) = match (self.motion, role) {
            (Motion::Velocities, Role::Position) => {
                return signature.body_slot(slot.argument, Role::Velocity);
            }
            (Motion::Velocities, Role::Orientation) => {
                return signature.body_slot(slot.argument, Role::AngularVelocity);
            }
            (Motion::Velocities, _) => return None,
            (Motion::Pose(direction), _) => (signature.pose_blocks(), direction),
            (Motion::Velocity(direction), _) => (signature.velocity_blocks(), direction),
        };
        let place = blocks.iter().position(|block| block.body == slot.argument && block.role == role)?;
        Some(Slot { offset: direction.offset + 3 * place as u32, ..direction })
    }

    /// The angular velocity that turns an orientation.
    fn spin(&mut self, slot: Slot) -> Option<Vector> {
        if self.graph.signature.role(slot) != Some(Role::Orientation) {
            return None;
        }
        let slot = self.moves(slot, Role::Orientation)?;
        Some(self.graph.triple(slot))
    }

    /// The turning factors of a product of quaternions, each with its angular velocity, rotated by R.
    fn turn_rates(&mut self, turn: &[(Slot, bool)]) -> Vec<(RotatedArm, Vector)> {
        let slots: BTreeSet<Slot> = turn.iter().map(|(slot, _)| *slot).collect();
        let mut rates = Vec::new();
        for slot in slots {
            let Some(spin) = self.spin(slot) else { continue };
            for turned in RotatedArm::places(turn, Variable::Rotation(slot)) {
                let spin = turned.rotate(self.graph, spin);
                rates.push((turned, spin));
            }
        }
        rates
    }

    fn triple(&mut self, slot: Slot) -> Vector {
        if let Some(velocity) = self.velocity(slot) {
            return self.graph.triple(velocity);
        }
        let Some(spin) = self.spin(slot) else { return self.graph.zero_vector() };
        // u̇ = ½ (w ω + ω × u)
        let half = Exact::ratio(1, 2);
        let w = self.graph.entry(Slot { offset: 3, ..slot });
        let imaginary = self.graph.triple(slot);
        let (along, across) = (self.graph.scale(w, spin), self.graph.cross(spin, imaginary));
        self.graph.vector_sum(vec![(half.clone(), along), (half, across)])
    }

    fn entry(&mut self, slot: Slot) -> Real {
        let base = Slot { offset: 0, ..slot };
        if slot.offset < 3 {
            let rate = self.triple(base);
            return self.graph.component(rate, slot.offset as u8);
        }
        let Some(spin) = self.spin(base) else { return self.graph.zero() };
        // ẇ = −½ u·ω
        let imaginary = self.graph.triple(base);
        let along = self.graph.dot(imaginary, spin);
        self.graph.scaled(Exact::ratio(-1, 2), along)
    }

    /// A sum in which u·v + u·w is replaced by u·(v + w).
    fn sum(&mut self, terms: Vec<(Exact, Real)>) -> Real {
        let flat = self.graph.sum(Exact::ZERO, terms);
        let Node::Sum(constant, terms) = self.graph.node(flat.index()).clone() else { return flat };
        let mut terms = terms.to_vec();
        loop {
            let mut uses: BTreeMap<Vector, usize> = BTreeMap::new();
            for (_, term) in &terms {
                if let Node::Dot(u, v) = *self.graph.node(term.index()) {
                    *uses.entry(u).or_default() += 1;
                    if u != v {
                        *uses.entry(v).or_default() += 1;
                    }
                }
            }
            let best =
                uses.into_iter().filter(|(_, n)| *n > 1).max_by_key(|(v, n)| (*n, std::cmp::Reverse(*v)));
            let Some((common, _)) = best else { break };
            let mut others = Vec::new();
            terms.retain(|(c, term)| match *self.graph.node(term.index()) {
                Node::Dot(u, v) if u == common || v == common => {
                    others.push((c.clone(), if u == common { v } else { u }));
                    false
                }
                _ => true,
            });
            let other = self.graph.vector_sum(others);
            let merged = self.graph.dot(common, other);
            let stuck = !matches!(self.graph.node(self.graph.split(merged).1.index()), Node::Dot(..));
            terms.push((Exact::ONE, merged));
            if stuck {
                break;
            }
        }
        self.graph.sum(constant, terms)
    }
}
