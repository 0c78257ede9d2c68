//! The types of values, and their names in messages.

use crate::model::bodies::{BodyKind, ParameterType};
use std::fmt;

/// The type of a value.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Type {
    /// The type of an erroneous expression; it agrees with every type.
    Poison,
    /// `Real`
    Real,
    /// `bool`
    Truth,
    /// `usize`, `i32` and other integers; known at compile time
    Integer,
    /// `Vec2`, `Vec3`, `Vec4`
    Vector(u32),
    /// The transpose of a vector.
    Row(u32),
    /// `Mat2`, `Mat3`
    Matrix(u32),
    /// `Quat`
    Quat,
    /// The type that `to_rotation_matrix` returns, before `into_inner`.
    Rotation,
    /// `Rigid`, `Particle`
    Body(BodyKind),
    /// `Wrench`
    Wrench,
    Tuple(Vec<Type>),
    /// `[T; n]`
    Array(Box<Type>, u32),
}

/// Every named type except the body types.
pub(crate) static NAMED: [(&str, Type); 14] = [
    ("Real", Type::Real),
    ("Vec2", Type::Vector(2)),
    ("Vec3", Type::Vector(3)),
    ("Vec4", Type::Vector(4)),
    ("Mat2", Type::Matrix(2)),
    ("Mat3", Type::Matrix(3)),
    ("Quat", Type::Quat),
    ("Wrench", Type::Wrench),
    ("bool", Type::Truth),
    ("usize", Type::Integer),
    ("i32", Type::Integer),
    ("u32", Type::Integer),
    ("i64", Type::Integer),
    ("isize", Type::Integer),
];

impl Type {
    /// The type with this name.
    pub(crate) fn named(name: &str) -> Option<Type> {
        let simple = NAMED.iter().find(|(known, _)| *known == name).map(|(_, ty)| ty.clone());
        simple.or_else(|| BodyKind::named(name).map(Type::Body))
    }

    /// Names of all types.
    pub(crate) fn names() -> impl Iterator<Item = &'static str> {
        NAMED.iter().map(|(name, _)| *name).chain(crate::model::bodies::BODIES.iter().map(|row| row.name))
    }

    /// Whether a value of this type is allowed where `wanted` is expected.
    pub(crate) fn agrees(&self, wanted: &Type) -> bool {
        match (self, wanted) {
            (Type::Poison, _) | (_, Type::Poison) => true,
            (Type::Tuple(a), Type::Tuple(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.agrees(b))
            }
            (Type::Array(a, n), Type::Array(b, m)) => n == m && a.agrees(b),
            _ => self == wanted,
        }
    }

    /// Whether the type is or contains `Poison`.
    pub(crate) fn is_poisoned(&self) -> bool {
        match self {
            Type::Poison => true,
            Type::Tuple(types) => types.iter().any(Type::is_poisoned),
            Type::Array(element, _) => element.is_poisoned(),
            _ => false,
        }
    }

    /// The type of a parameter, if allowed for parameters.
    pub(crate) fn parameter(&self) -> Option<ParameterType> {
        Some(match self {
            Type::Real => ParameterType::Real,
            Type::Vector(n) => ParameterType::Vector(*n),
            Type::Matrix(n) => ParameterType::Matrix(*n),
            Type::Quat => ParameterType::Quaternion,
            Type::Array(element, n) => ParameterType::Array(*n, Box::new(element.parameter()?)),
            _ => return None,
        })
    }

    /// Number of reals in a parameter of this type.
    pub(crate) fn reals(&self) -> u64 {
        match self {
            Type::Vector(n) => u64::from(*n),
            Type::Matrix(n) => u64::from(n * n),
            Type::Quat => 4,
            Type::Array(element, n) => element.reals().saturating_mul(u64::from(*n)),
            _ => 1,
        }
    }

    /// Number of constraint rows in a value of this type, if rows can have it.
    pub(crate) fn rows(&self) -> Option<u64> {
        match self {
            Type::Real => Some(1),
            Type::Vector(n) => Some(u64::from(*n)),
            Type::Tuple(types) if !types.is_empty() => {
                types.iter().try_fold(0u64, |sum, ty| sum.checked_add(ty.rows()?))
            }
            Type::Array(element, n) => element.rows()?.checked_mul(u64::from(*n)),
            _ => None,
        }
    }

    /// The type in messages: a source name in backticks, or words.
    pub(crate) fn said(&self) -> String {
        match self {
            Type::Integer => "an integer".to_owned(),
            Type::Row(n) => format!("a transposed `Vec{n}`"),
            Type::Rotation => "a rotation".to_owned(),
            Type::Tuple(types) if types.is_empty() => "no value".to_owned(),
            ty => format!("`{ty}`"),
        }
    }
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Type::Poison => f.write_str("?"),
            Type::Real => f.write_str("Real"),
            Type::Truth => f.write_str("bool"),
            Type::Integer => f.write_str("usize"),
            Type::Vector(n) => write!(f, "Vec{n}"),
            Type::Row(n) => write!(f, "RowVec{n}"),
            Type::Matrix(n) => write!(f, "Mat{n}"),
            Type::Quat => f.write_str("Quat"),
            Type::Rotation => f.write_str("Rotation"),
            Type::Body(kind) => f.write_str(kind.row().name),
            Type::Wrench => f.write_str("Wrench"),
            Type::Tuple(types) => {
                let types: Vec<String> = types.iter().map(Type::to_string).collect();
                write!(f, "({}{})", types.join(", "), if types.len() == 1 { "," } else { "" })
            }
            Type::Array(element, n) => write!(f, "[{element}; {n}]"),
        }
    }
}
