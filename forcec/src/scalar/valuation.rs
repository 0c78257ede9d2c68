//! Valuations: how values vanish or grow as all positions meet: the power h of their distance d in c·dʰ.
//!
//! The square of 1/det of three edges has valuation −6 and overflows single precision at edges of 1e-7,
//! though the product that contains it is ordinary. Factoring uses valuations to choose separate values, the
//! schedule uses them to order factors. Unknown valuations count as 0; cancellation is ignored. As in
//! algebra, the valuation of a sum is at least the smallest valuation of its terms.

use crate::math::functions::Function;
use crate::model::bodies::{Domain, Role, Signature, Slot};
use crate::scalar::Node;
use std::ops::{Add, Neg};

/// A power of length, in halves.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Debug)]
pub struct Valuation(i32);

impl Valuation {
    /// The valuation of an ordinary value.
    pub const ZERO: Valuation = Valuation(0);
    /// The valuation of a length.
    const ONE: Valuation = Valuation(2);
    /// The largest valuation of either sign in single precision: d⁵ at distances of 1e-7.
    const WIDEST: i32 = 10;

    /// The valuation of an entry of an argument: 1 for positions and velocities, from the stated domain for
    /// parameters, 0 for all others.
    pub fn of_slot(signature: &Signature, slot: Slot) -> Valuation {
        match signature.role(slot) {
            Some(Role::Position | Role::Velocity) => Valuation::ONE,
            Some(_) => Valuation::ZERO,
            None => match signature.parameter(slot).map(|parameter| parameter.domain) {
                Some(Domain::Range(low, high)) => Valuation::of_number(low.abs().max(high.abs())),
                _ => Valuation::ZERO,
            },
        }
    }

    /// The valuation of a number, as a power of 1e-7.
    fn of_number(size: f64) -> Valuation {
        let halves = (-2.0 * size.log10() / 7.0).round();
        Valuation(if halves.is_finite() { halves as i32 } else { 0 })
    }

    /// The valuation of a difference of entries: points can coincide, even if one is a parameter.
    pub fn of_difference(signature: &Signature, first: Slot, second: Slot) -> Valuation {
        Valuation::of_slot(signature, first).max(Valuation::of_slot(signature, second))
    }

    /// The valuation of a sum, or of a selection.
    pub fn least(terms: impl IntoIterator<Item = Valuation>) -> Valuation {
        terms.into_iter().min().unwrap_or_default()
    }

    /// The valuation of a function call.
    pub fn of_call(function: Function, arguments: &[Valuation]) -> Valuation {
        let first = arguments.first().copied().unwrap_or_default();
        match function {
            Function::Abs | Function::Min | Function::Max | Function::Hypot => {
                Valuation::least(arguments.iter().copied())
            }
            Function::Sqrt => Valuation(first.0 / 2),
            Function::Cbrt => Valuation(first.0 / 3),
            // Near 0, these functions behave like their argument.
            Function::Sin
            | Function::Tan
            | Function::Asin
            | Function::Atan
            | Function::Sinh
            | Function::Tanh
            | Function::Asinh(0)
            | Function::Atanh(0)
            | Function::Erf
            | Function::Ln1p
            | Function::ExpM1 => first.max(Valuation::ZERO),
            _ => Valuation::ZERO,
        }
    }

    /// The valuation of a node that is neither a sum nor a product.
    pub fn of_node(signature: &Signature, node: &Node, operands: &[Valuation]) -> Valuation {
        match (node, operands) {
            (Node::Input(slot) | Node::Offset(slot, _), _) => Valuation::of_slot(signature, *slot),
            (Node::Difference(first, second), _) => Valuation::of_difference(signature, *first, *second),
            (Node::Recip(_), [x]) => -*x,
            (Node::Held(_) | Node::Multiple(..), [x]) => *x,
            (Node::Call(function, _), arguments) => Valuation::of_call(*function, arguments),
            (Node::Select(..), [_, x, y]) => *x.min(y),
            _ => Valuation::ZERO,
        }
    }

    /// Whether single precision can represent such values.
    pub fn is_held(self) -> bool {
        self.0.abs() <= Valuation::WIDEST
    }

    /// Whether a shared value may have it: single precision can represent it, or none of the users' values.
    pub fn suits(self, mut users: impl Iterator<Item = Valuation>) -> bool {
        self.is_held() || users.all(|user| !user.is_held())
    }

    /// Its distance from 0.
    pub fn size(self) -> u32 {
        self.0.unsigned_abs()
    }

    /// Whether single precision can represent it, or it lies between 0 and the other.
    pub fn is_on_the_way_to(self, other: Valuation) -> bool {
        self.is_held() || (other.0.min(0)..=other.0.max(0)).contains(&self.0)
    }
}

/// The valuation of a product.
impl Add for Valuation {
    type Output = Valuation;

    fn add(self, other: Valuation) -> Valuation {
        Valuation(self.0.saturating_add(other.0).clamp(-1 << 20, 1 << 20))
    }
}

/// The valuation of a reciprocal.
impl Neg for Valuation {
    type Output = Valuation;

    fn neg(self) -> Valuation {
        Valuation(-self.0)
    }
}

impl std::iter::Sum for Valuation {
    fn sum<I: Iterator<Item = Valuation>>(values: I) -> Valuation {
        values.fold(Valuation::ZERO, Add::add)
    }
}
