//! Booleans: comparisons and logical operators, evaluated where the operands are constants.

use crate::math::number::Comparison;
use crate::vector::{Graph, Node, Real, Truth};

impl Graph {
    /// A boolean constant.
    pub fn known(&mut self, value: bool) -> Truth {
        self.truth(Node::Known(value))
    }

    /// The value of a node that is a boolean constant.
    pub fn truth_value(&self, truth: Truth) -> Option<bool> {
        match self.truth_at(truth) {
            Node::Known(value) => Some(*value),
            _ => None,
        }
    }

    /// A comparison.
    pub fn compare(&mut self, comparison: Comparison, x: Real, y: Real) -> Truth {
        if self.simplify
            && let (Some(a), Some(b)) = (self.value(x), self.value(y))
        {
            let holds = match comparison {
                Comparison::Less => a < b,
                Comparison::LessEqual => a <= b,
                Comparison::Equal => a == b,
            };
            return self.known(holds);
        }
        self.truth(Node::Compare(comparison, x, y))
    }

    /// x < y
    pub fn less(&mut self, x: Real, y: Real) -> Truth {
        self.compare(Comparison::Less, x, y)
    }

    /// a ∧ b
    pub fn and(&mut self, a: Truth, b: Truth) -> Truth {
        if self.simplify {
            match (self.truth_value(a), self.truth_value(b)) {
                (Some(false), _) | (_, Some(false)) => return self.known(false),
                (Some(true), _) => return b,
                (_, Some(true)) => return a,
                _ if a == b => return a,
                _ => {}
            }
        }
        self.truth(Node::And(a, b))
    }

    /// a ∨ b
    pub fn or(&mut self, a: Truth, b: Truth) -> Truth {
        if self.simplify {
            match (self.truth_value(a), self.truth_value(b)) {
                (Some(true), _) | (_, Some(true)) => return self.known(true),
                (Some(false), _) => return b,
                (_, Some(false)) => return a,
                _ if a == b => return a,
                _ => {}
            }
        }
        self.truth(Node::Or(a, b))
    }

    /// ¬a
    pub fn not(&mut self, a: Truth) -> Truth {
        if self.simplify {
            match *self.truth_at(a) {
                Node::Known(value) => return self.known(!value),
                Node::Not(inner) => return inner,
                _ => {}
            }
        }
        self.truth(Node::Not(a))
    }
}
