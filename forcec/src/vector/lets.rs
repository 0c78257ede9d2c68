//! Named intermediates.
//!
//! In: a value and the author's name for it. Out: the value, bound by a let of that name. Promise: every
//! later occurrence of the bound expression becomes that let. Inputs, numbers and points are not bound.

use crate::math::exact::Exact;
use crate::vector::{Graph, Node, Real, Vector};

impl Graph {
    /// Binds a real to a name. Inputs and numbers are returned unchanged; of two names for one expression the
    /// first is used.
    pub fn let_real(&mut self, name: &str, value: Real) -> Real {
        let (coefficient, rest) = self.split(value);
        if !self.simplify
            || matches!(
                self.at(rest),
                Node::Constant(_) | Node::Entry(_) | Node::Let(_) | Node::Component(..)
            )
        {
            return value;
        }
        if self.holds_point(rest) {
            self.names.entry(rest.0).or_insert_with(|| name_of_multiple(name, &coefficient));
            return value;
        }
        let held = self.real(Node::Let(rest));
        self.held.insert(rest.0, held.0);
        self.names.entry(held.0).or_insert_with(|| name_of_multiple(name, &coefficient));
        self.scaled(coefficient, held)
    }

    /// Binds a vector to a name.
    pub fn let_vector(&mut self, name: &str, value: Vector) -> Vector {
        let (coefficient, rest) = self.split_vector(value);
        let plain = matches!(self.vector_at(rest), Node::Triple(_) | Node::VectorLet(_) | Node::VectorSum(_))
            && !matches!(self.vector_at(rest), Node::VectorSum(terms) if terms.len() > 1);
        if !self.simplify || plain {
            return value;
        }
        let is_point = |(_, v): &(Exact, Vector)| self.point(*v).is_some();
        let has_point = matches!(self.vector_at(rest), Node::VectorSum(terms) if terms.iter().any(is_point));
        let is_offset = matches!(*self.vector_at(rest), Node::VectorOffset(v, _) if self.point(v).is_some());
        if has_point || is_offset || self.holds_position(rest) {
            // A point in the world: not bound, for the same reason as in `holds_point`.
            self.names.entry(rest.0).or_insert_with(|| name_of_multiple(name, &coefficient));
            return value;
        }
        if let Node::Rotate(..) = self.vector_at(rest) {
            // The author's name replaces the name that `name_arm` generated.
            self.names.remove(&rest.0);
        }
        let held = self.vector(Node::VectorLet(rest));
        self.held.insert(rest.0, held.0);
        self.names.entry(held.0).or_insert_with(|| name_of_multiple(name, &coefficient));
        self.vector_sum(vec![(coefficient, held)])
    }

    /// Names a parameter that is rotated into the world after itself, so that readers recognise it.
    pub(super) fn name_arm(&mut self, rotated: Vector, arm: Vector) {
        let Node::Rotate(quaternion, false, _) = *self.vector_at(rotated) else { return };
        let Node::Triple(slot) = *self.vector_at(arm) else { return };
        if self.signature.role(quaternion).is_none() {
            return;
        }
        if let Some(parameter) = self.signature.parameter(slot) {
            let number = if slot.offset == 0 { String::new() } else { format!("_{}", slot.offset / 3) };
            let name = format!("{}_world{number}", parameter.name);
            self.names.entry(rotated.0).or_insert(name);
        }
    }
}

/// The name of x where the author named a multiple of x.
fn name_of_multiple(name: &str, coefficient: &Exact) -> String {
    if coefficient.is_one() {
        name.to_owned()
    } else if (-coefficient).is_one() {
        format!("minus_{name}")
    } else {
        format!("{name}_part")
    }
}
