//! Values while elaborating: what an expression stands for, its leaves nodes of the graph.
//!
//! Promise: a composite value never holds a poisoned one, so that a value whose type was checked can be taken apart
//! without asking again.

use crate::check::builtins::matrices::Matrix3;
use crate::check::builtins::quaternions::Quaternion;
use crate::check::types::Type;
use crate::model::bodies::BodyKind;
use crate::vector::{Real, Truth, Vector};
use std::rc::Rc;

/// A value.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Value {
    /// Something a message was given for.
    Poison,
    /// A real.
    Real(Real),
    /// A truth that the kernel finds out.
    Truth(Truth),
    /// A truth that is known while compiling.
    Known(bool),
    /// An integer; always known.
    Integer(i64),
    /// A vector of two or four.
    Few(Rc<[Real]>),
    /// A vector of three.
    Vector(Vector),
    /// The transpose of a vector.
    Row(Rc<Value>),
    /// A 2×2 matrix, row by row.
    Matrix2([Real; 4]),
    /// A 3×3 matrix.
    Matrix3(Matrix3),
    /// A quaternion.
    Quat(Quaternion),
    /// The rotation matrix of a quaternion.
    Rotation(Quaternion),
    /// A body argument, by its index.
    Body(u16, BodyKind),
    /// Force and torque.
    Wrench(Vector, Vector),
    /// A tuple.
    Tuple(Rc<Composite>),
    /// An array.
    Array(Rc<Composite>),
}

/// The elements of a tuple or an array.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Composite {
    /// The elements; an array has at least one.
    pub(crate) elements: Vec<Value>,
    /// How many leaves there are below.
    pub(crate) size: u64,
}

impl Composite {
    pub(crate) fn new(elements: Vec<Value>) -> Rc<Composite> {
        let size = elements.iter().map(Value::size).fold(1, u64::saturating_add);
        Rc::new(Composite { elements, size })
    }
}

impl Value {
    /// The value of a block without one.
    pub(crate) fn unit() -> Value {
        Value::Tuple(Composite::new(Vec::new()))
    }

    /// A tuple, poisoned if an element is.
    pub(crate) fn tuple(elements: Vec<Value>) -> Value {
        if elements.contains(&Value::Poison) { Value::Poison } else { Value::Tuple(Composite::new(elements)) }
    }

    /// An array of one type, poisoned if an element is.
    pub(crate) fn array(elements: Vec<Value>) -> Value {
        if elements.contains(&Value::Poison) { Value::Poison } else { Value::Array(Composite::new(elements)) }
    }

    /// How many leaves it has.
    pub(crate) fn size(&self) -> u64 {
        match self {
            Value::Tuple(composite) | Value::Array(composite) => composite.size,
            _ => 1,
        }
    }

    pub(crate) fn is_poison(&self) -> bool {
        *self == Value::Poison
    }

    /// Its type.
    pub(crate) fn ty(&self) -> Type {
        match self {
            Value::Poison => Type::Poison,
            Value::Real(_) => Type::Real,
            Value::Truth(_) | Value::Known(_) => Type::Truth,
            Value::Integer(_) => Type::Integer,
            Value::Few(entries) => Type::Vector(entries.len() as u32),
            Value::Vector(_) => Type::Vector(3),
            Value::Row(vector) => match vector.ty() {
                Type::Vector(n) => Type::Row(n),
                _ => Type::Poison,
            },
            Value::Matrix2(_) => Type::Matrix(2),
            Value::Matrix3(_) => Type::Matrix(3),
            Value::Quat(_) => Type::Quat,
            Value::Rotation(_) => Type::Rotation,
            Value::Body(_, kind) => Type::Body(*kind),
            Value::Wrench(..) => Type::Wrench,
            Value::Tuple(composite) => Type::Tuple(composite.elements.iter().map(Value::ty).collect()),
            Value::Array(composite) => {
                let element = composite.elements.first().map_or(Type::Poison, Value::ty);
                Type::Array(Box::new(element), composite.elements.len() as u32)
            }
        }
    }

    // Taking apart a value whose type was checked.

    pub(crate) fn real(&self) -> Real {
        match self {
            Value::Real(x) => *x,
            other => unreachable!("checked to be a real: {other:?}"),
        }
    }

    pub(crate) fn integer(&self) -> i64 {
        match self {
            Value::Integer(n) => *n,
            other => unreachable!("checked to be an integer: {other:?}"),
        }
    }

    pub(crate) fn vector(&self) -> Vector {
        match self {
            Value::Vector(v) => *v,
            other => unreachable!("checked to be a vector of three: {other:?}"),
        }
    }

    pub(crate) fn quat(&self) -> &Quaternion {
        match self {
            Value::Quat(q) | Value::Rotation(q) => q,
            other => unreachable!("checked to be a rotation: {other:?}"),
        }
    }

    pub(crate) fn elements(&self) -> &[Value] {
        match self {
            Value::Tuple(composite) | Value::Array(composite) => &composite.elements,
            other => unreachable!("checked to be a tuple or array: {other:?}"),
        }
    }
}
