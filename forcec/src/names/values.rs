//! Descriptive names of values, built from the names of what they are computed from: `a_q_x`, `arm_a_world`,
//! `inv_length`, `gap_x_by_a_rx`.
//!
//! In: entries of arguments, and names of operands. Out: names that a reader of the source understands, or
//! nothing if the name would be long. An author's name counts with a constant length, so that renaming a value
//! does not change the names of other values.

use crate::math::functions::Function;
use crate::model::bodies::{Role, Signature, Slot};

/// The letter of a body's field in names.
fn letter(role: Role) -> &'static str {
    match role {
        Role::Position => "p",
        Role::Orientation => "q",
        Role::Velocity => "v",
        Role::AngularVelocity => "w",
    }
}

/// A name in messages, `jacobian[2][b.x]`, as an identifier: `jacobian_2_b_x`.
pub(crate) fn flat(name: &str) -> String {
    name.replace(['.', '['], "_").replace(']', "")
}

/// The name of an argument's entry: `a_q_x`, `arm_a_x`, `m_0_1`.
pub(crate) fn entry_name(signature: &Signature, slot: Slot) -> String {
    let name = signature.slot_name(slot);
    let name = match (signature.role(slot), name.split_once('.')) {
        (Some(role), Some((body, entry))) => {
            format!("{body}_{}_{}", letter(role), entry.rsplit('.').next().unwrap_or_default())
        }
        _ => name,
    };
    flat(&name)
}

/// The name of a vector or quaternion of an argument: `a_q`, `arm_a`.
pub(crate) fn whole_name(signature: &Signature, slot: Slot) -> String {
    match (signature.role(slot), signature.bodies.get(slot.argument as usize)) {
        (Some(role), Some(body)) => format!("{}_{}", body.name, letter(role)),
        _ => flat(&signature.whole_name(slot)),
    }
}

/// The name of the difference of two vectors of bodies: `b_minus_a` for positions, else `b_minus_a_v`.
pub(crate) fn difference_name(signature: &Signature, first: Slot, second: Slot) -> Option<String> {
    let body = |slot: Slot| signature.bodies.get(slot.argument as usize).map(|body| body.name.as_str());
    let role = signature.role(first)?;
    let kind = if role == Role::Position { String::new() } else { format!("_{}", letter(role)) };
    Some(format!("{}_minus_{}{kind}", body(first)?, body(second)?))
}

/// What differentiation adds to a name of the author.
const AFFIXES: [&str; 5] = ["minus_", "adjoint_", "_part", "_world", "_dot"];

/// A descriptive name, and the length that is assumed for it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct ValueName {
    pub(crate) text: String,
    length: usize,
}

impl ValueName {
    /// A name with a greater assumed length is rejected.
    const LONGEST: usize = 18;

    /// A longer name is rejected, too: with its middle cut out, it would help nobody.
    const LONGEST_TEXT: usize = 27;

    /// A name chosen by the author, perhaps with what differentiation adds to it.
    pub(crate) fn source(name: impl Into<String>) -> ValueName {
        const LENGTH: usize = 7;
        let text = name.into();
        let added = |affix: &&&str| text.starts_with(**affix) || text.ends_with(**affix);
        let added: usize = AFFIXES.iter().filter(added).map(|affix| affix.len()).sum();
        ValueName { text, length: LENGTH + added }
    }

    /// A name without a name of the author.
    pub(crate) fn plain(name: impl Into<String>) -> ValueName {
        let text = name.into();
        ValueName { length: text.len(), text }
    }

    /// The name if it is short.
    pub(crate) fn short(self) -> Option<ValueName> {
        (self.length <= ValueName::LONGEST && self.text.len() <= ValueName::LONGEST_TEXT).then_some(self)
    }

    /// The name with text after it.
    pub(crate) fn and(&self, text: &str) -> ValueName {
        ValueName { text: format!("{}{text}", self.text), length: self.length + text.len() }
    }

    /// The name with text before it.
    pub(crate) fn after(&self, text: &str) -> ValueName {
        ValueName { text: format!("{text}{}", self.text), length: self.length + text.len() }
    }

    /// This name, text and another name.
    pub(crate) fn join(&self, text: &str, other: &ValueName) -> ValueName {
        let length = self.length + text.len() + other.length;
        ValueName { text: format!("{}{text}{}", self.text, other.text), length }
    }

    /// The name of the opposite value.
    pub(crate) fn opposite(&self) -> ValueName {
        const MINUS: &str = "minus_";
        match self.text.strip_prefix(MINUS) {
            Some(rest) => {
                ValueName { text: rest.to_owned(), length: self.length.saturating_sub(MINUS.len()) }
            }
            None => self.after(MINUS),
        }
    }

    /// x^exponent; a negative exponent divides.
    pub(crate) fn power(&self, exponent: i64) -> ValueName {
        let power = match exponent.unsigned_abs() {
            1 => self.clone(),
            2 => self.and("_sq"),
            n => self.and(&format!("_pow{n}")),
        };
        if exponent < 0 { power.after("inv_") } else { power }
    }

    /// The product of two values; powers of one value are joined.
    pub(crate) fn times(&self, other: &ValueName) -> ValueName {
        let ((base, m), (own, n)) = (self.base(), other.base());
        if base == own {
            let length = self.length - (self.text.len() - base.len()).min(self.length);
            return ValueName { text: base.to_owned(), length }.power(m + n);
        }
        self.join("_", other)
    }

    /// The base and exponent in the name of a power.
    fn base(&self) -> (&str, i64) {
        if let Some(base) = self.text.strip_suffix("_sq") {
            return (base, 2);
        }
        let power = self.text.rsplit_once("_pow").and_then(|(base, n)| Some((base, n.parse().ok()?)));
        power.unwrap_or((&self.text, 1))
    }

    /// f(x)
    pub(crate) fn call(&self, function: Function) -> Option<ValueName> {
        function.order().is_none().then(|| self.after(&format!("{}_", function.row().name)))
    }
}
