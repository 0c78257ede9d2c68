//! How many instances a kernel computes at once.

use std::fmt;

/// The number of instances that a kernel computes at once. A kernel of several reads and writes structures of
/// arrays, with one number per instance.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Lanes {
    /// One instance, from plain numbers.
    One,
    /// This number of instances, at least two.
    Several(usize),
    /// Any number: the const parameter `L` of a Rust kernel. Only the macros generate such kernels.
    Generic,
}

impl Lanes {
    /// This number of instances.
    pub(crate) fn of(count: usize) -> Lanes {
        if count > 1 { Lanes::Several(count) } else { Lanes::One }
    }

    /// Whether the kernel computes one instance.
    pub(crate) fn is_one(self) -> bool {
        self == Lanes::One
    }
}

/// The number, as an expression of the target: `4`, `L`.
impl fmt::Display for Lanes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Lanes::One => f.write_str("1"),
            Lanes::Several(count) => write!(f, "{count}"),
            Lanes::Generic => f.write_str("L"),
        }
    }
}
