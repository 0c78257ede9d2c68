//! From statements to text.
//!
//! In: a [`File`] of scheduled kernels. Out: files of C99 or Rust. A target is a [`Dialect`] for the statements and a
//! frame around them; the layout of every struct comes from the signature, numbers and the
//! special functions are spelled here for both.

pub mod c;
mod parts;
mod routine;
pub mod rust;

use crate::kernel::{File, Kernel, Precision, Target};
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::{
    Body, BodyKind, BodyRow, Domain, Field, Parameter, ParameterType, Role, Signature, Slot, indices,
};
use crate::names::Arguments;
use crate::schedule::print::{self, Dialect};
use crate::schedule::{Expression, Schedule, Statement};

/// A generated file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Generated {
    /// Its name, with extension.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// What the head line of every generated file but `forcec.h` begins with.
pub(crate) const MADE: &str = "Made by forcec from ";

/// The head line of `forcec.h`.
const COMMON: &str = "What every kernel made by forcec includes: bodies and special functions.";

/// Whether a text is that of a generated file: the comment it begins with has a head line of ours.
pub(crate) fn is_made(text: &str) -> bool {
    let comment = |line: &&str| ["//", "/*", " *"].iter().any(|mark| line.starts_with(mark));
    let bare = |line: &str| line.trim_start_matches(['/', '*', '!', ' ']).trim_end().to_owned();
    let ours =
        |line: String| line == COMMON || line.starts_with(MADE) && line.ends_with("; the code is yours.");
    text.lines().take_while(comment).map(bare).any(ours)
}

/// Every file of a target, in a fixed order.
pub fn emit(file: &File, target: Target) -> Vec<Generated> {
    let named = |name: String, text: String| Generated { name, text };
    match target {
        Target::C => vec![
            named(format!("{}.h", file.name()), c::header(file)),
            named(format!("{}.c", file.name()), c::source(file)),
            named("forcec.h".to_owned(), c::header_common()),
        ],
        Target::Rust => vec![named(format!("{}.rs", file.name()), rust::module(file))],
    }
}

/// The text of one kernel, as it stands in the file of the target that holds its code.
pub fn kernel(kernel: &Kernel, target: Target, precision: Precision) -> String {
    match target {
        Target::C => c::definition(kernel, precision),
        Target::Rust => rust::kernel_module(kernel, precision),
    }
}

/// The shortest decimal that reads back as the nearest number of the precision; `None` where that is infinite.
fn decimal(value: &Exact, precision: Precision) -> Option<String> {
    match precision {
        Precision::F64 => Some(value.to_f64()).filter(|x| x.is_finite()).map(|x| format!("{x:?}")),
        Precision::F32 => Some(value.to_f32()).filter(|x| x.is_finite()).map(|x| format!("{x:?}")),
    }
}

/// A function's template with everything but the arguments filled in.
fn template(template: &str, function: Function, precision: Precision) -> String {
    let order = function.order().map(|n| n.to_string()).unwrap_or_default();
    spelled(template, precision).replace("{n}", &order)
}

/// A template with the precision filled in.
fn spelled(template: &str, precision: Precision) -> String {
    let (lower, upper) = match precision {
        Precision::F64 => ("", ""),
        Precision::F32 => ("f", "_F32"),
    };
    template.replace("{p}", precision.name()).replace("{f}", lower).replace("{F}", upper)
}

/// A slot as an expression: `a->position[2]`, `params->m[0][1]`; `arrow` reaches from an argument to its fields.
fn slot_path(signature: &Signature, names: &Arguments, slot: Slot, arrow: &str, lanes: usize) -> String {
    let argument = slot.argument as usize;
    let lane = lane(lanes);
    let Some(parameter) = signature.parameter(slot) else {
        let field = &signature.bodies[argument].kind.row().fields[slot.field as usize];
        return format!("{}{arrow}{}[{}]{lane}", names.bodies[argument], field.name, slot.offset);
    };
    let mut path = match signature.extra(slot) {
        Some(extra) => names.extras[extra].clone(),
        None => format!("{}{arrow}{}", names.given, names.parameters[argument - signature.bodies.len()]),
    };
    for index in indices(&parameter.ty.extents(), slot.offset) {
        path.push_str(&format!("[{index}]"));
    }
    // A lone extra is the same for all; of another, Rust's loop has a copy of its own.
    let own = parameter.ty == ParameterType::Real || arrow == ".";
    let shared = signature.extra(slot).is_some() && own;
    if shared { path } else { path + lane }
}

/// What stands behind a place of which every instance has its own.
fn lane(lanes: usize) -> &'static str {
    if lanes > 1 { "[lane]" } else { "" }
}

/// The statements of a kernel of several instances: those before the loop over them, which clear, and those in it.
fn lane_loop(schedule: &Schedule) -> (Vec<&Statement>, Vec<&Statement>) {
    schedule.statements.iter().partition(|statement| matches!(statement, Statement::Zero { .. }))
}

/// Whether statements do anything: headings do not.
fn acts(statements: &[&Statement]) -> bool {
    statements.iter().any(|statement| !matches!(statement, Statement::Heading(_)))
}

/// Whether this turns the direction of writing.
pub(crate) fn turns(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Text as its reader sees it: characters that turn the direction of writing, which compilers refuse, are named by their
/// numbers; other control characters become spaces.
fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            c if turns(c) => shown.push_str(&format!("(U+{:04X})", u32::from(c))),
            c if c.is_control() => shown.push(' '),
            c => shown.push(c),
        }
    }
    shown
}

/// Statements of a schedule, a blank line before every heading but the first.
fn body<'a>(
    dialect: &dyn Dialect,
    schedule: &Schedule,
    statements: impl IntoIterator<Item = &'a Statement>,
    indent: &str,
) -> String {
    let mut text = String::new();
    for statement in statements {
        if matches!(statement, Statement::Heading(_)) && !text.is_empty() {
            text.push('\n');
        }
        for line in print::statement(dialect, &schedule.variables, statement) {
            text.push_str(&format!("{indent}{line}\n"));
        }
    }
    text
}

/// Which arguments are read.
struct Reads {
    bodies: Vec<bool>,
    /// Whether any parameter is.
    parameters: bool,
    extras: Vec<bool>,
    /// Whether results are read or written.
    results: bool,
}

/// Which arguments statements of a kernel read.
fn reads<'a>(schedule: &Schedule, statements: impl IntoIterator<Item = &'a Statement>) -> Reads {
    let signature = &schedule.signature;
    let mut bodies = vec![false; signature.bodies.len()];
    let mut extras = vec![false; signature.extras.len()];
    let (mut parameters, mut results) = (false, false);
    let mut pending: Vec<&Expression> = Vec::new();
    for statement in statements {
        results |= statement.stores();
        pending.extend(statement.expressions());
        while let Some(expression) = pending.pop() {
            if let Expression::Input(slot) = expression {
                match (bodies.get_mut(slot.argument as usize), signature.extra(*slot)) {
                    (Some(read), _) => *read = true,
                    (_, Some(extra)) => extras[extra] = true,
                    _ => parameters |= signature.known(*slot).is_none(),
                }
            }
            pending.extend(expression.children());
        }
    }
    Reads { bodies, parameters, extras, results }
}

/// The body types that some of these signatures use, in the order of the table.
fn kinds<'a>(signatures: impl Iterator<Item = &'a Signature>) -> Vec<BodyKind> {
    let mut kinds: Vec<BodyKind> =
        signatures.flat_map(|signature| signature.bodies.iter().map(|body: &Body| body.kind)).collect();
    kinds.sort();
    kinds.dedup();
    kinds
}

/// What a stored field of a body is.
fn field_summary(field: &Field) -> &'static str {
    match field.role {
        Role::Position => "position, world frame",
        Role::Orientation => "unit quaternion x, y, z, w, from body to world frame",
        Role::Velocity => "velocity, world frame",
        Role::AngularVelocity => "angular velocity, world frame",
    }
}

/// What a parameter is.
fn parameter_summary(parameter: &Parameter) -> String {
    fn kind(ty: &ParameterType) -> String {
        match ty {
            ParameterType::Real => "real".to_owned(),
            ParameterType::Vector(n) => format!("vector of {n}"),
            ParameterType::Matrix(n) => format!("{n} by {n} matrix, row by row"),
            ParameterType::Quaternion => "quaternion x, y, z, w".to_owned(),
            ParameterType::Array(n, element) => match **element {
                ParameterType::Array(..) => format!("{n} by {}", kind(element)),
                _ => format!("{n} times: {}", kind(element)),
            },
        }
    }
    let domain = match parameter.domain {
        Domain::Any => String::new(),
        Domain::Range(low, high) => format!(", {low} to {high}"),
        Domain::Unit => ", of length one".to_owned(),
    };
    format!("{}{domain}", kind(&parameter.ty))
}

/// How a matrix is stored by a layout that looks for symmetric ones.
fn stored_as(triangle: bool) -> &'static str {
    if triangle { "symmetric: the upper triangle, row by row" } else { "in full" }
}

/// The text with its first letter in upper case, unless that begins a formula such as dF/dX, and a full stop.
fn sentence(text: &str) -> String {
    if text.chars().nth(1).is_some_and(char::is_uppercase) {
        return format!("{text}.");
    }
    let mut letters = text.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    format!("{first}{}.", letters.as_str())
}

/// A body type's name in Rust, of one instance or of several.
pub(crate) fn rust_body(row: &BodyRow, precision: Precision, lanes: usize) -> String {
    let precise = match precision {
        Precision::F64 => "",
        Precision::F32 => "F32",
    };
    let several = if lanes > 1 { format!("X{lanes}") } else { String::new() };
    format!("{}{precise}{several}", row.name)
}
