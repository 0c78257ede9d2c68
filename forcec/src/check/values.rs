//! Values of expressions during elaboration; the leaves of a value are nodes of the graph.
//!
//! Promise: a composite value never contains `Poison`, so values of checked types need no further checks.

use crate::check::builtins::matrices::Matrix3;
use crate::check::builtins::quaternions::Quaternion;
use crate::check::types::Type;
use crate::model::bodies::BodyKind;
use crate::vector::{Real, Truth, Vector};
use std::rc::Rc;

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Value {
    /// An erroneous value; it causes no further errors.
    Poison,
    Real(Real),
    /// A condition that the kernel evaluates.
    Truth(Truth),
    /// A condition that is known at compile time.
    Known(bool),
    /// An integer; always known at compile time.
    Integer(i64),
    /// A vector of 2 or 4 entries.
    Few(Rc<[Real]>),
    /// A vector of 3 entries.
    Vector(Vector),
    /// The transpose of a vector.
    Row(Rc<Value>),
    /// A 2×2 matrix, row by row.
    Matrix2([Real; 4]),
    Matrix3(Matrix3),
    Quat(Quaternion),
    /// The rotation matrix of a quaternion.
    Rotation(Quaternion),
    /// A body argument, by its index.
    Body(u16, BodyKind),
    /// Force and torque.
    Wrench(Vector, Vector),
    Tuple(Rc<Composite>),
    Array(Rc<Composite>),
}

/// The elements of a tuple or an array.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Composite {
    /// The elements; an array has at least one.
    pub(crate) elements: Vec<Value>,
    /// 1 plus the number of leaves of all elements.
    pub(crate) size: u64,
}

impl Composite {
    pub(crate) fn new(elements: Vec<Value>) -> Rc<Composite> {
        let size = elements.iter().map(Value::size).fold(1, u64::saturating_add);
        Rc::new(Composite { elements, size })
    }
}

impl Value {
    /// The value of a block without a final expression.
    pub(crate) fn unit() -> Value {
        Value::Tuple(Composite::new(Vec::new()))
    }

    /// A tuple, or `Poison` if an element is `Poison`.
    pub(crate) fn tuple(elements: Vec<Value>) -> Value {
        if elements.contains(&Value::Poison) { Value::Poison } else { Value::Tuple(Composite::new(elements)) }
    }

    /// An array, or `Poison` if an element is `Poison`.
    pub(crate) fn array(elements: Vec<Value>) -> Value {
        if elements.contains(&Value::Poison) { Value::Poison } else { Value::Array(Composite::new(elements)) }
    }

    /// Number of leaves.
    pub(crate) fn size(&self) -> u64 {
        match self {
            Value::Tuple(composite) | Value::Array(composite) => composite.size,
            _ => 1,
        }
    }

    pub(crate) fn is_poison(&self) -> bool {
        *self == Value::Poison
    }

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

    // Accessors for values whose type was checked.

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
