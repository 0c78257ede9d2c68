//! Conditions under which an arm of a branch is active.
//!
//! In: the values of a source at a point, and an arm. Out: comparisons with their required outcomes, first
//! those that lead to the branch, then the branch's own; and those that keep the point where derivatives
//! exist.

use crate::math::functions::{Function, FunctionDomain};
use crate::math::number::Comparison;
use crate::vector::{Node, Truth};
use crate::verify::search::{Decider, Routes, Search, Term, Want, Wish};
use crate::verify::source::Values;

impl Search<'_> {
    /// The distance of each truth from being false and from being true.
    pub(super) fn truths(&self, values: &Values<f64>) -> Vec<[f64; 2]> {
        let mut misses = vec![[0.0; 2]; self.graph.len()];
        for (index, node) in self.source.nodes() {
            misses[index] = match node {
                Node::Known(truth) => [f64::from(u8::from(*truth)), f64::from(u8::from(!truth))],
                Node::Compare(..) => [false, true]
                    .map(|side| self.compared(node, side).map_or(0.0, |wish| self.miss(values, &wish))),
                Node::And(a, b) => {
                    let ([a, x], [b, y]) = (misses[a.index()], misses[b.index()]);
                    [a.min(b), x + y]
                }
                Node::Or(a, b) => {
                    let ([a, x], [b, y]) = (misses[a.index()], misses[b.index()]);
                    [a + b, x.min(y)]
                }
                Node::Not(a) => {
                    let [no, yes] = misses[a.index()];
                    [yes, no]
                }
                _ => continue,
            };
        }
        misses
    }

    /// The wish that makes a comparison true or false, as `side` says.
    pub(super) fn compared(&self, node: &Node, side: bool) -> Option<Wish> {
        let Node::Compare(comparison, x, y) = node else { return None };
        let want = match (comparison, side) {
            (Comparison::Equal, true) => Want::Zero,
            (Comparison::Equal, false) => Want::Apart,
            (_, true) => Want::Below,
            (_, false) => Want::Above,
        };
        let term = |index: usize| match self.graph.node(index) {
            Node::Constant(value) => Term::Number(value.to_f64()),
            _ => Term::Real(index),
        };
        Some(Wish { x: term(x.index()), y: term(y.index()), want })
    }

    /// Adds the wishes that give a truth this side.
    pub(super) fn wishes_of(&self, truth: usize, side: bool, misses: &[[f64; 2]], wishes: &mut Vec<Wish>) {
        let mut open = vec![(truth, side)];
        while let Some((truth, side)) = open.pop() {
            let node = self.graph.node(truth);
            let nearer = |a: &Truth, b: &Truth| {
                let side = usize::from(side);
                if misses[b.index()][side] < misses[a.index()][side] { b.index() } else { a.index() }
            };
            match (node, side) {
                (Node::Compare(..), _) => wishes.extend(self.compared(node, side)),
                (Node::And(a, b), true) | (Node::Or(a, b), false) => {
                    open.extend([(b.index(), side), (a.index(), side)]);
                }
                (Node::And(a, b), false) | (Node::Or(a, b), true) => open.push((nearer(a, b), side)),
                (Node::Not(a), _) => open.push((a.index(), !side)),
                _ => {}
            }
        }
    }

    /// The wish that gives a decider this side, unless the decider is a condition.
    pub(super) fn wish(&self, decider: Decider, side: bool) -> Option<Wish> {
        let node = match decider {
            Decider::Row(row) => {
                let want = if side { Want::Below } else { Want::Above };
                return Some(Wish { x: self.rows[row], y: Term::Number(0.0), want });
            }
            Decider::Node(node) => node,
        };
        let Node::Call(function, x) = self.graph.node(node) else { return None };
        let below = side != (*function == Function::Max);
        let want = if below { Want::Below } else { Want::Above };
        let y = x.get(1).map_or(Term::Number(0.0), |y| Term::Real(y.index()));
        Some(Wish { x: Term::Real(x[0].index()), y, want })
    }

    /// The nearest way to reach each node, such that its value contributes to a row.
    pub(super) fn routes(&self, values: &Values<f64>, misses: &[[f64; 2]]) -> Routes {
        let mut routes =
            Routes { distance: vec![f64::INFINITY; self.graph.len()], from: vec![None; self.graph.len()] };
        for (row, root) in self.rows.iter().enumerate() {
            let (Term::Real(root) | Term::Component(root, _)) = *root else { continue };
            let decider = Decider::Row(row);
            let wish = self.wish(decider, true).filter(|_| self.unilateral);
            let distance = wish.map_or(0.0, |wish| self.miss(values, &wish));
            if distance < routes.distance[root] {
                routes.distance[root] = distance;
                routes.from[root] = Some(decider);
            }
        }
        for (index, node) in self.source.nodes().rev().filter(|(_, node)| node.is_value()) {
            let here = routes.distance[index];
            if here == f64::INFINITY {
                continue;
            }
            let mut read = 0;
            self.values_read(node, |operand| {
                let way = here + self.arm(index, node, read, misses, values);
                read += 1;
                if way < routes.distance[operand] {
                    routes.distance[operand] = way;
                    routes.from[operand] = Some(Decider::Node(index));
                }
            });
        }
        routes
    }

    /// The distance of a branching node from selecting an operand, counted among its value operands.
    pub(super) fn arm(
        &self,
        index: usize,
        node: &Node,
        operand: usize,
        misses: &[[f64; 2]],
        values: &Values<f64>,
    ) -> f64 {
        match node {
            Node::Select(c, ..) | Node::VectorSelect(c, ..) => misses[c.index()][usize::from(operand == 0)],
            Node::Call(Function::Min | Function::Max, _) => {
                let wish = self.wish(Decider::Node(index), operand == 0);
                wish.map_or(0.0, |wish| self.miss(values, &wish))
            }
            _ => 0.0,
        }
    }

    /// Adds the wishes that make a node's value contribute.
    pub(super) fn wishes_to(
        &self,
        node: usize,
        routes: &Routes,
        misses: &[[f64; 2]],
        wishes: &mut Vec<Wish>,
    ) {
        let mut at = node;
        let mut backwards: Vec<Vec<Wish>> = Vec::new();
        while let Some(from) = routes.from[at] {
            let Decider::Node(user) = from else {
                backwards.push(self.wish(from, true).filter(|_| self.unilateral).into_iter().collect());
                break;
            };
            let mut here = Vec::new();
            match self.graph.node(user) {
                Node::Select(c, x, y) if x != y => {
                    self.wishes_of(c.index(), x.index() == at, misses, &mut here)
                }
                Node::VectorSelect(c, x, y) if x != y => {
                    self.wishes_of(c.index(), x.index() == at, misses, &mut here)
                }
                Node::Call(Function::Min | Function::Max, x) => {
                    here.extend(self.wish(from, x[0].index() == at));
                }
                _ => {}
            }
            backwards.push(here);
            at = user;
        }
        wishes.extend(backwards.into_iter().rev().flatten());
    }

    /// The wishes under which a decider is reached, and those that give the decider this side.
    pub(super) fn wishes(
        &self,
        values: &Values<f64>,
        decider: Decider,
        side: bool,
    ) -> (Vec<Wish>, Vec<Wish>) {
        let misses = self.truths(values);
        let routes = self.routes(values, &misses);
        let (mut before, mut own) = (Vec::new(), Vec::new());
        match decider {
            Decider::Row(_) => own.extend(self.wish(decider, side)),
            Decider::Node(node) if self.graph.node(node).is_value() => {
                self.wishes_to(node, &routes, &misses, &mut before);
                own.extend(self.wish(decider, side));
            }
            Decider::Node(truth) => {
                let users = self.source.nodes().filter(|(_, node)| match node {
                    Node::Select(c, x, y) => c.index() == truth && x != y,
                    Node::VectorSelect(c, u, v) => c.index() == truth && u != v,
                    _ => false,
                });
                let distance = |index: &usize| routes.distance[*index];
                let nearest =
                    users.map(|(index, _)| index).min_by(|a, b| distance(a).total_cmp(&distance(b)));
                if let Some(user) = nearest {
                    self.wishes_to(user, &routes, &misses, &mut before);
                }
                self.wishes_of(truth, side, &misses, &mut own);
            }
        }
        (before, own)
    }

    /// The wishes under which all contributing functions have values and derivatives.
    pub(super) fn domains(&self, values: &Values<f64>) -> Vec<Wish> {
        let mut reached = vec![false; self.graph.len()];
        self.roots.iter().for_each(|root| reached[*root] = true);
        let mut wishes = Vec::new();
        for (index, node) in self.source.nodes().rev() {
            if !reached[index] {
                continue;
            }
            let arms = match node {
                Node::Select(c, x, y) => Some((c.index(), x.index(), y.index())),
                Node::VectorSelect(c, x, y) => Some((c.index(), x.index(), y.index())),
                _ => None,
            };
            if let Some((c, x, y)) = arms {
                reached[c] = true;
                reached[if self.source.get(values, c).truth() { x } else { y }] = true;
                continue;
            }
            node.operands().into_iter().for_each(|operand| reached[operand as usize] = true);
            let Node::Call(function, arguments) = node else { continue };
            let Some(x) = arguments.first().map(|x| Term::Real(x.index())) else { continue };
            let wish = |want, bound| Wish { x, y: Term::Number(bound), want };
            match function.row().smooth {
                FunctionDomain::AtLeast(bound) | FunctionDomain::Above(bound) => {
                    wishes.push(wish(Want::Above, bound))
                }
                FunctionDomain::HalfPlane => wishes.push(wish(Want::Above, 0.0)),
                FunctionDomain::Unit | FunctionDomain::Inside => {
                    wishes.extend([wish(Want::Above, -1.0), wish(Want::Below, 1.0)])
                }
                FunctionDomain::All | FunctionDomain::NotAllZero => {}
            }
        }
        wishes
    }
}
