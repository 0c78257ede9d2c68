//! Bodies and parameters: the arguments of a kernel, as tables.
//!
//! A row describes a body type: its stored fields, their order, and how each field changes along the tangent.
//! `Signature` alone defines the layout of arguments: every target prints it, and graphs refer to entries by
//! `Slot`. It also contains the facts known at compile time: fixed bodies, and parameters with known values.

use crate::math::exact::Exact;
use crate::model::outputs::Piece;

/// How a stored field of a body changes along the body's tangent coordinates.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Role {
    /// x ← x + δx
    Position,
    /// q ← exp(δθ/2) q; stored x, y, z, w
    Orientation,
    /// v ← v + δv
    Velocity,
    /// ω ← ω + δω
    AngularVelocity,
}

/// One stored field of a body type.
#[derive(Debug)]
pub struct Field {
    /// Its name in the source and in the generated struct.
    pub name: &'static str,
    /// How it changes along the tangent.
    pub role: Role,
    /// Number of reals that it stores.
    pub length: u32,
}

/// A body type: one row of [`BODIES`].
#[derive(Debug)]
pub struct BodyRow {
    /// Its name in the source.
    pub name: &'static str,
    /// Its name in C, before the suffix of the precision.
    pub c_name: &'static str,
    /// Its stored fields, in memory order.
    pub fields: &'static [Field],
    /// Names of its tangent coordinates, in order; every three coordinates form one block.
    pub coordinates: &'static [&'static str],
    /// Its description in the generated documentation.
    pub summary: &'static str,
}

/// All body types.
pub static BODIES: [BodyRow; 2] = [
    BodyRow {
        name: "Rigid",
        c_name: "forcec_rigid",
        fields: &[
            Field { name: "position", role: Role::Position, length: 3 },
            Field { name: "orientation", role: Role::Orientation, length: 4 },
            Field { name: "velocity", role: Role::Velocity, length: 3 },
            Field { name: "angular_velocity", role: Role::AngularVelocity, length: 3 },
        ],
        coordinates: &["x", "y", "z", "rx", "ry", "rz"],
        summary: "a rigid body: centre of mass, unit quaternion x, y, z, w, and velocities in the world frame",
    },
    BodyRow {
        name: "Particle",
        c_name: "forcec_particle",
        fields: &[
            Field { name: "position", role: Role::Position, length: 3 },
            Field { name: "velocity", role: Role::Velocity, length: 3 },
        ],
        coordinates: &["x", "y", "z"],
        summary: "a point mass: position and velocity in the world frame",
    },
];

/// A body type, by its index in [`BODIES`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct BodyKind(u8);

impl BodyKind {
    /// `Rigid`
    pub const RIGID: BodyKind = BodyKind(0);
    /// `Particle`
    pub const PARTICLE: BodyKind = BodyKind(1);

    /// The body type with this name.
    pub fn named(name: &str) -> Option<BodyKind> {
        BODIES.iter().position(|row| row.name == name).map(|i| BodyKind(i as u8))
    }

    /// Its row in [`BODIES`].
    pub fn row(self) -> &'static BodyRow {
        &BODIES[self.0 as usize]
    }

    /// Number of degrees of freedom.
    pub fn dofs(self) -> usize {
        self.row().coordinates.len()
    }

    /// Index of the field with this role.
    pub fn field(self, role: Role) -> Option<u8> {
        self.row().fields.iter().position(|f| f.role == role).map(|i| i as u8)
    }
}

/// The type of a parameter.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum ParameterType {
    /// One real.
    Real,
    /// A vector of n reals.
    Vector(u32),
    /// An n × n matrix, row by row.
    Matrix(u32),
    /// A quaternion x, y, z, w.
    Quaternion,
    /// An array of elements of one type.
    Array(u32, Box<ParameterType>),
}

impl ParameterType {
    /// Extents of the array in C, outermost first; empty for a real.
    pub fn extents(&self) -> Vec<u32> {
        match self {
            ParameterType::Real => vec![],
            ParameterType::Vector(n) => vec![*n],
            ParameterType::Matrix(n) => vec![*n, *n],
            ParameterType::Quaternion => vec![4],
            ParameterType::Array(n, element) => {
                let mut extents = vec![*n];
                extents.extend(element.extents());
                extents
            }
        }
    }

    /// The innermost element type of an array.
    pub fn innermost(&self) -> &ParameterType {
        let mut innermost = self;
        while let ParameterType::Array(_, element) = innermost {
            innermost = element;
        }
        innermost
    }

    /// Number of reals it stores.
    pub fn length(&self) -> u64 {
        self.extents().iter().map(|&n| u64::from(n)).product()
    }
}

/// The domain of a parameter that `#[domain(…)]` states.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Domain {
    /// No stated domain.
    Any,
    /// Every entry lies in a closed range.
    Range(f64, f64),
    /// Vectors or quaternions of length one.
    Unit,
}

/// Stated range of every entry of a field of a body.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FieldDomain {
    /// Index of the body.
    pub body: u16,
    /// The role of the field.
    pub role: Role,
    /// The smallest value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

/// The length scale of a function. It has no effect on kernels; it decides where check states are drawn.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Scale {
    /// The typical distance of bodies, stated or guessed from domains of parameters; `None` if of order one.
    pub length: Option<f64>,
    /// Exponent of length of each parameter, inferred from sums and comparisons; 0 if unknown.
    pub powers: Vec<f64>,
    /// Further lengths, from domains and literals.
    pub named: Vec<f64>,
    /// Stated ranges of fields.
    pub fields: Vec<FieldDomain>,
}

impl Scale {
    /// Stated range of a field.
    pub fn field(&self, body: usize, role: Role) -> Option<(f64, f64)> {
        let field = self.fields.iter().find(|field| (usize::from(field.body), field.role) == (body, role));
        field.map(|field| (field.low, field.high))
    }
}

/// One body argument.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its name in the source.
    pub name: String,
    /// Its body type.
    pub kind: BodyKind,
    /// Whether it is fixed: it has a pose, but no velocity, no degrees of freedom and no force.
    pub fixed: bool,
}

/// One parameter.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name in the source.
    pub name: String,
    /// Its type.
    pub ty: ParameterType,
    /// Its stated domain.
    pub domain: Domain,
    /// Its value, entry by entry, if known at compile time; then it is not an argument of the kernel.
    pub value: Option<Vec<Exact>>,
}

/// A kernel's arguments: bodies first, then parameters, in source order; `stiffness` and `damping` last.
#[derive(Clone, Debug, Default)]
pub struct Signature {
    /// The body arguments.
    pub bodies: Vec<Body>,
    /// All parameters.
    pub parameters: Vec<Parameter>,
    /// Number of rows of C; 1 for an energy, 0 for a force.
    pub rows: usize,
    /// The extra arguments that some outputs require, such as a time step or a direction.
    pub extras: Vec<Parameter>,
    /// The outputs that a layout stores in place of others.
    pub pieces: Vec<Piece>,
    /// Whether the parameters include precomputed values, derived from the parameters of the source.
    pub prepared: bool,
    /// The length scale of states.
    pub scale: Scale,
}

/// One real entry of an argument: the argument, its field, and a flat offset in memory order. Arguments are
/// numbered bodies first, then parameters, then extra arguments; only bodies have more than one field.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Slot {
    /// Index of the argument.
    pub argument: u16,
    /// Index of the field.
    pub field: u8,
    /// Offset within the field.
    pub offset: u32,
}

/// One tangent block of three coordinates of a body.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Block {
    /// Index of the body.
    pub body: u16,
    /// The role: the translation or rotation of the pose, or of the velocity.
    pub role: Role,
}

impl Signature {
    /// Total number of degrees of freedom.
    pub fn dofs(&self) -> usize {
        self.moving().map(|(_, body)| body.kind.dofs()).sum()
    }

    /// Moving bodies, with their indices among the arguments.
    pub fn moving(&self) -> impl Iterator<Item = (usize, &Body)> {
        self.bodies.iter().enumerate().filter(|(_, body)| !body.fixed)
    }

    /// The value of an entry, if it is known at compile time.
    pub fn known(&self, slot: Slot) -> Option<Exact> {
        match self.bodies.get(slot.argument as usize) {
            Some(body) => {
                let moves = matches!(self.role(slot), Some(Role::Velocity | Role::AngularVelocity));
                (body.fixed && moves).then_some(Exact::ZERO)
            }
            None => Some(self.parameter(slot)?.value.as_ref()?[slot.offset as usize].clone()),
        }
    }

    /// The value of an entry if it is folded into expressions: 0, ±1, ±2 or ±½. Other known values stay named
    /// inputs: folding them would create more distinct coefficients, each with a multiplication of its own.
    pub fn folded(&self, slot: Slot) -> Option<Exact> {
        let simple = [(0, 1), (1, 1), (2, 1), (1, 2)].map(|(over, under)| Exact::ratio(over, under));
        self.known(slot).filter(|value| simple.contains(&value.abs()))
    }

    /// The parameters that are arguments because their values are unknown, with their indices.
    pub fn given(&self) -> impl Iterator<Item = (usize, &Parameter)> {
        self.parameters.iter().enumerate().filter(|(_, parameter)| parameter.value.is_none())
    }

    /// Whether the kernel has a parameter that is an argument.
    pub fn has_given(&self) -> bool {
        self.given().next().is_some()
    }

    /// The role of a slot's field; `None` for a parameter.
    pub fn role(&self, slot: Slot) -> Option<Role> {
        let body = self.bodies.get(slot.argument as usize)?;
        Some(body.kind.row().fields[slot.field as usize].role)
    }

    /// The first slot of a body's field; `None` if the body type stores no such field.
    pub fn body_slot(&self, body: u16, role: Role) -> Option<Slot> {
        let field = self.bodies[body as usize].kind.field(role)?;
        Some(Slot { argument: body, field, offset: 0 })
    }

    /// Slot of an entry of a parameter.
    pub fn parameter_slot(&self, parameter: usize, offset: u32) -> Slot {
        Slot { argument: (self.bodies.len() + parameter) as u16, field: 0, offset }
    }

    /// Slot of an entry of an extra argument.
    pub fn extra_slot(&self, extra: &str, offset: u32) -> Option<Slot> {
        let place = self.extras.iter().position(|own| own.name == extra)?;
        Some(self.parameter_slot(self.parameters.len() + place, offset))
    }

    /// The extra arguments without known values, with their indices.
    pub fn given_extras(&self) -> impl Iterator<Item = (usize, &Parameter)> {
        self.extras.iter().enumerate().filter(|(_, extra)| extra.value.is_none())
    }

    /// The parameter or extra argument that a slot belongs to, if any.
    pub fn parameter(&self, slot: Slot) -> Option<&Parameter> {
        let index = (slot.argument as usize).checked_sub(self.bodies.len())?;
        self.parameters.get(index).or_else(|| self.extras.get(index - self.parameters.len()))
    }

    /// Index of the extra argument that a slot belongs to, if any.
    pub fn extra(&self, slot: Slot) -> Option<usize> {
        (slot.argument as usize).checked_sub(self.bodies.len() + self.parameters.len())
    }

    /// The blocks of the pose, in the order of the generalised forces.
    pub fn pose_blocks(&self) -> Vec<Block> {
        self.blocks([Role::Position, Role::Orientation])
    }

    /// The blocks of the velocity, in the same order.
    pub fn velocity_blocks(&self) -> Vec<Block> {
        self.blocks([Role::Velocity, Role::AngularVelocity])
    }

    fn blocks(&self, roles: [Role; 2]) -> Vec<Block> {
        let mut blocks = Vec::new();
        for (body, argument) in self.moving() {
            for role in roles {
                if argument.kind.field(role).is_some() {
                    blocks.push(Block { body: body as u16, role });
                }
            }
        }
        blocks
    }

    /// The names of the N coordinates, `a.x` … `b.rz`.
    pub fn coordinate_names(&self) -> Vec<String> {
        let mut names = Vec::new();
        for (_, body) in self.moving() {
            names.extend(body.kind.row().coordinates.iter().map(|c| format!("{}.{c}", body.name)));
        }
        names
    }

    /// The name of a slot in messages: `a.position.x`, `arm_a.y`, `coefficients[2]`.
    pub fn slot_name(&self, slot: Slot) -> String {
        const AXES: [&str; 4] = ["x", "y", "z", "w"];
        if let Some(body) = self.bodies.get(slot.argument as usize) {
            let field = &body.kind.row().fields[slot.field as usize];
            return format!("{}.{}.{}", body.name, field.name, AXES[slot.offset as usize]);
        }
        let parameter = self.parameter(slot).expect("a slot names an argument");
        let mut name = parameter.name.clone();
        match parameter.ty {
            ParameterType::Real => {}
            ParameterType::Vector(_) | ParameterType::Quaternion => {
                name = format!("{name}.{}", AXES[slot.offset as usize]);
            }
            _ => {
                for index in indices(&parameter.ty.extents(), slot.offset) {
                    name = format!("{name}[{index}]");
                }
            }
        }
        name
    }

    /// The name of a vector or quaternion at a slot: the name of its first entry without the last index.
    pub fn whole_name(&self, slot: Slot) -> String {
        let mut name = self.slot_name(slot);
        name.truncate(name.rfind(['.', '[']).unwrap_or(name.len()));
        name
    }
}

/// The indices, outermost first, of a flat offset in an array of these extents.
pub fn indices(extents: &[u32], offset: u32) -> Vec<u32> {
    let mut rest = offset;
    let mut indices = Vec::new();
    for &extent in extents.iter().rev() {
        indices.push(rest % extent);
        rest /= extent;
    }
    indices.reverse();
    indices
}
