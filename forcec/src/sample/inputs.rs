//! The inputs of a kernel as one row of numbers.
//!
//! In: a signature. Out: the index of every slot in a flat list of reals, arguments in order, fields in
//! memory order; and the tangent coordinates with the indices of their fields.

use crate::model::bodies::{Role, Signature, Slot};
use std::fmt;

/// Indices of a signature's slots.
pub struct Places {
    /// The signature of the kernel.
    pub signature: Signature,
    starts: Vec<Vec<usize>>,
    /// The length of the list.
    pub length: usize,
    /// The coordinates of the pose, in the order of the generalised forces.
    pub pose: Vec<Coordinate>,
    /// The coordinates of the velocity, in the same order.
    pub velocity: Vec<Coordinate>,
}

/// One tangent coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Coordinate {
    /// Index of the body.
    pub body: u16,
    /// The role of its field.
    pub role: Role,
    /// The axis of the translation or rotation.
    pub axis: usize,
    /// Index of its field.
    pub start: usize,
}

impl Places {
    /// Indices for a signature.
    pub fn new(signature: &Signature) -> Places {
        let mut length = 0;
        let mut place = |reals: usize| {
            length += reals;
            length - reals
        };
        let mut starts: Vec<Vec<usize>> = Vec::new();
        for body in &signature.bodies {
            starts.push(body.kind.row().fields.iter().map(|field| place(field.length as usize)).collect());
        }
        for parameter in signature.parameters.iter().chain(&signature.extras) {
            starts.push(vec![place(parameter.ty.length() as usize)]);
        }
        let mut places =
            Places { signature: signature.clone(), starts, length, pose: Vec::new(), velocity: Vec::new() };
        for (blocks, pose) in [(signature.pose_blocks(), true), (signature.velocity_blocks(), false)] {
            let coordinates = blocks.iter().flat_map(|block| {
                let slot = signature.body_slot(block.body, block.role);
                let start = slot.map_or(0, |slot| places.place(slot));
                (0..3).map(move |axis| Coordinate { body: block.body, role: block.role, axis, start })
            });
            let coordinates: Vec<Coordinate> = coordinates.collect();
            *(if pose { &mut places.pose } else { &mut places.velocity }) = coordinates;
        }
        places
    }

    /// Index of a slot.
    pub fn place(&self, slot: Slot) -> usize {
        self.starts[slot.argument as usize][slot.field as usize] + slot.offset as usize
    }

    /// Every slot, in the order of the list.
    pub fn slots(&self) -> impl Iterator<Item = Slot> + '_ {
        let bodies = self.signature.bodies.iter().map(|body| {
            let fields = body.kind.row().fields.iter();
            fields.map(|field| field.length).collect::<Vec<_>>()
        });
        let parameters = self.signature.parameters.iter().chain(&self.signature.extras);
        let lengths = bodies.chain(parameters.map(|parameter| vec![parameter.ty.length() as u32]));
        lengths.enumerate().flat_map(|(argument, fields)| {
            fields.into_iter().enumerate().flat_map(move |(field, length)| {
                (0..length).map(move |offset| Slot { argument: argument as u16, field: field as u8, offset })
            })
        })
    }

    /// Index of a body's field, if the body has it.
    pub fn field(&self, body: usize, role: Role) -> Option<usize> {
        self.signature.body_slot(body as u16, role).map(|slot| self.place(slot))
    }

    /// Index of a parameter; extra arguments are counted after the parameters.
    pub fn parameter(&self, parameter: usize) -> usize {
        self.starts[self.signature.bodies.len() + parameter][0]
    }

    /// Every field and parameter with its values, for display.
    pub fn inputs(&self, values: &[f64]) -> Inputs {
        let mut inputs = Vec::new();
        for (b, body) in self.signature.bodies.iter().enumerate() {
            for (field, &at) in body.kind.row().fields.iter().zip(&self.starts[b]) {
                let name = format!("{}.{}", body.name, field.name);
                inputs.push((name, values[at..at + field.length as usize].to_vec()));
            }
        }
        let parameters = self.signature.parameters.iter().chain(&self.signature.extras);
        for (p, parameter) in parameters.enumerate() {
            let at = self.parameter(p);
            inputs.push((parameter.name.clone(), values[at..at + parameter.ty.length() as usize].to_vec()));
        }
        Inputs(inputs)
    }
}

/// All inputs of a kernel: each field and parameter with its reals, in memory order.
#[derive(Clone, PartialEq, Debug)]
pub struct Inputs(pub Vec<(String, Vec<f64>)>);

impl fmt::Display for Inputs {
    /// One line per entry; the digits reproduce the same doubles.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, values) in &self.0 {
            match values.as_slice() {
                [value] => writeln!(f, "{name} = {value:?}")?,
                values => writeln!(f, "{name} = {values:?}")?,
            }
        }
        Ok(())
    }
}
