//! Built-in functions and methods: the form of a row of the table, and lookup, listing and suggestions.
//!
//! The rows are in [`crate::check::builtins::rows`]: one table for calls, suggestions and the reference.

pub(crate) mod matrices;
pub(crate) mod quaternions;
pub(crate) mod rows;

use crate::check::builtins::rows::TABLE;
use crate::check::elaborator::Elaborator;
use crate::check::types::Type;
use crate::check::values::Value;
use crate::source::span::Span;

/// Whether a built-in is called on a type or on a value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Place {
    /// `Vec3::zeros()`
    Type,
    /// `v.norm()`
    Value,
}

/// The type of a receiver, argument or result; may depend on the receiver.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Shape {
    /// `Real`
    Real,
    /// An integer that fits `i32`.
    Small,
    /// A vector of any length.
    Vectors,
    /// A vector of this length.
    Vector(u32),
    /// The transpose of a vector.
    Rows,
    /// A matrix of any size.
    Matrices,
    /// A matrix of this size.
    Matrix(u32),
    /// `Quat`
    Quat,
    /// A rotation matrix.
    Rotation,
    /// The type of the receiver.
    Same,
    /// A vector with one entry per column of the receiver.
    Line,
    /// An array with one vector per column of the receiver.
    Columns,
    /// An array with one transposed vector per row of the receiver.
    Transposed,
    /// `(Real, Real)`
    Pair,
    /// A square matrix as large as the receiver, a vector.
    Square,
    /// The transpose of the receiver, a vector or a transposed vector.
    Flipped,
}

impl Shape {
    /// Whether a receiver of this type matches the shape.
    fn covers(self, ty: &Type) -> bool {
        match (self, ty) {
            (Shape::Vectors, Type::Vector(_)) | (Shape::Matrices, Type::Matrix(_)) => true,
            (Shape::Rows, Type::Row(_)) => true,
            _ => self.of(ty) == *ty && !matches!(self, Shape::Same | Shape::Small),
        }
    }

    /// Whether an argument of this type is accepted for the receiver type `on`.
    pub(crate) fn accepts(self, ty: &Type, on: &Type) -> bool {
        ty.agrees(&self.of(on))
    }

    /// The type if the receiver has type `on`.
    pub(crate) fn of(self, on: &Type) -> Type {
        let n = match on {
            Type::Vector(n) | Type::Row(n) | Type::Matrix(n) => *n,
            _ => 3,
        };
        match self {
            Shape::Real => Type::Real,
            Shape::Small => Type::Integer,
            Shape::Vectors | Shape::Line => Type::Vector(n),
            Shape::Vector(n) => Type::Vector(n),
            Shape::Rows => Type::Row(n),
            Shape::Matrices | Shape::Square => Type::Matrix(n),
            Shape::Matrix(n) => Type::Matrix(n),
            Shape::Quat => Type::Quat,
            Shape::Rotation => Type::Rotation,
            Shape::Same => on.clone(),
            Shape::Columns => Type::Array(Box::new(Type::Vector(n)), n),
            Shape::Transposed => Type::Array(Box::new(Type::Row(n)), n),
            Shape::Pair => Type::Tuple(vec![Type::Real, Type::Real]),
            Shape::Flipped => match on {
                Type::Vector(n) => Type::Row(*n),
                _ => Type::Vector(n),
            },
        }
    }

    /// The type in messages.
    pub(crate) fn said(self, on: &Type) -> String {
        self.of(on).said()
    }

    /// The type in a call that a message shows.
    pub(crate) fn written(self, on: &Type) -> String {
        if self == Shape::Small { self.listed().to_owned() } else { self.of(on).to_string() }
    }

    /// The type in the reference.
    fn listed(self) -> &'static str {
        match self {
            Shape::Real => "Real",
            Shape::Small => "i32",
            Shape::Vectors => "Vec2, Vec3, Vec4",
            Shape::Vector(2) => "Vec2",
            Shape::Vector(3) => "Vec3",
            Shape::Vector(_) => "Vec4",
            Shape::Rows => "transposed vector",
            Shape::Matrices => "Mat2, Mat3",
            Shape::Matrix(2) => "Mat2",
            Shape::Matrix(_) => "Mat3",
            Shape::Quat => "Quat",
            Shape::Rotation => "rotation",
            Shape::Same => "Self",
            Shape::Line => "vector",
            Shape::Columns => "&[vector; n]",
            Shape::Transposed => "&[transposed vector; n]",
            Shape::Pair => "(Real, Real)",
            Shape::Square => "matrix",
            Shape::Flipped => "transpose",
        }
    }
}

/// One built-in, a row of the table.
pub(crate) struct Builtin {
    pub(crate) name: &'static str,
    pub(crate) place: Place,
    /// The type of the receiver.
    pub(crate) on: Shape,
    pub(crate) arguments: &'static [Shape],
    pub(crate) result: Shape,
    /// A short description for the reference.
    pub(crate) summary: &'static str,
    /// Computes the value from the receiver and the arguments, whose types were checked.
    pub(crate) apply: fn(&mut Elaborator<'_>, &[Value], Span) -> Value,
}

/// All rows of the table.
pub(crate) fn all() -> impl Iterator<Item = &'static Builtin> {
    TABLE.into_iter().flatten()
}

/// The row with this name for a type.
pub(crate) fn find(place: Place, name: &str, on: &Type) -> Option<&'static Builtin> {
    all().find(|row| row.place == place && row.name == name && row.on.covers(on))
}

/// Names of the built-ins for a type.
pub(crate) fn names(place: Place, on: &Type) -> impl Iterator<Item = &'static str> {
    all().filter(move |row| row.place == place && row.on.covers(on)).map(|row| row.name)
}

/// Number of arguments of the method with this name, if there is one.
pub(crate) fn method_arguments(name: &str) -> Option<usize> {
    all().find(|row| row.place == Place::Value && row.name == name).map(|row| row.arguments.len())
}

/// What to write instead of a method of Rust or nalgebra that the force language lacks.
pub(crate) fn instead(name: &str, on: &Type) -> Option<&'static str> {
    Some(match (name, on) {
        ("magnitude" | "length" | "len", Type::Vector(_)) => "write `.norm()`",
        ("magnitude_squared" | "length_squared", Type::Vector(_)) => "write `.norm_squared()`",
        ("normalized" | "unit", Type::Vector(_)) => "write `.normalize()`",
        ("abs", Type::Vector(_)) => "write `.norm()` for the length, or `.x.abs()` for an entry",
        ("try_inverse", Type::Matrix(_)) => "write `.inverse()`",
        ("norm", Type::Matrix(_)) => "write `.norm_squared().sqrt()`",
        ("column" | "row", Type::Matrix(_)) => {
            "write `m * Vec3::x()` for a column, or `m[(row, column)]` for an entry"
        }
        ("transform_vector" | "rotate" | "transform_point", Type::Quat) => "write `q * v`",
        ("norm" | "normalize", Type::Quat) => "a quaternion is taken as unit already",
        ("to_f64" | "into" | "clone" | "to_owned", _) => "leave it out",
        ("square" | "squared" | "sqr", Type::Real) => "write `.powi(2)`",
        ("pow", Type::Real) => "write `.powi(2)`, or `.powf(y)` for a real exponent",
        ("log" | "log10" | "log2", Type::Real) => "write `.ln()`, divided by `(10.0).ln()` for another base",
        ("exp2", Type::Real) => "write `(2.0).powf(x)`",
        ("mul_add", Type::Real) => "write `x * y + z`; the compiler fuses where it is asked to",
        ("to_radians", Type::Real) => "write `x * PI / 180.0`",
        ("to_degrees", Type::Real) => "write `x * 180.0 / PI`",
        ("expit" | "sigmoid", Type::Real) => "write `.logistic()`",
        ("ln1p" | "log1p", Type::Real) => "write `.ln_1p()`",
        ("expm1", Type::Real) => "write `.exp_m1()`",
        ("floor" | "ceil" | "round" | "trunc" | "fract" | "rem_euclid", Type::Real) => {
            "a force is differentiable; it has no steps"
        }
        ("iter" | "into_iter" | "len" | "map" | "sum", Type::Array(..)) => {
            "write `for i in 0..n` and index with `i`"
        }
        _ => return None,
    })
}

/// The table for the reference: receiver, call, result, description.
#[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
pub fn reference() -> Vec<[String; 4]> {
    all()
        .map(|row| {
            let arguments: Vec<&str> = row.arguments.iter().map(|shape| shape.listed()).collect();
            let arguments = arguments.join(", ");
            let written = match row.place {
                Place::Type => format!("{}({arguments})", row.name),
                Place::Value => format!(".{}({arguments})", row.name),
            };
            [row.on.listed().to_owned(), written, row.result.listed().to_owned(), row.summary.to_owned()]
        })
        .collect()
}
