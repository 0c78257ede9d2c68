//! Force functions: checks their arguments and return types, and converts them to definitions.

use crate::check::builtins::matrices::Matrix3;
use crate::check::builtins::quaternions::Quaternion;
use crate::check::elaborator::{Elaborator, LARGEST_VALUE, Purpose};
use crate::check::program::Program;
use crate::check::scales;
use crate::check::singular::{ranges, risks};
use crate::check::types::Type;
use crate::check::values::Value;
use crate::math::exact::Exact;
use crate::math::number::Comparison;
use crate::model::bodies::{
    Body, BodyKind, Domain, FieldDomain, Parameter, ParameterType, Role, Signature, Slot,
};
use crate::options::specialize::Specialization;
use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::suggest;
use crate::syntax::ast::{DomainClause, ExprId, Function, FunctionKind, Name, StatedDomain};
use crate::vector::Graph;
use crate::vector::definition::{Definition, Generalised, Law, Row};

/// Maximum number of arguments of a function.
const MOST_ARGUMENTS: usize = 1000;

/// The result of elaborating a force function.
pub(crate) struct Outcome {
    pub(crate) definition: Option<Definition>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// Steps of elaboration.
    pub(crate) steps: u64,
}

/// Elaborates a force function on a graph that `graph` creates.
pub(crate) fn define(
    program: &Program<'_>,
    recursive: &[bool],
    index: usize,
    graph: fn(Signature) -> Graph,
    known: &Specialization,
) -> Outcome {
    let function = &program.functions[index];
    let mut diagnostics = Vec::new();
    let signature = signature(program, recursive, index, known, &mut diagnostics);
    let returns = returns(program, index, &mut diagnostics);
    let Some(signature) = signature else { return Outcome { definition: None, diagnostics, steps: 0 } };
    let mut graph = graph(signature.clone());
    let arguments = arguments(&mut graph, &signature);
    let simplifies = graph.simplifies();
    let mut elaborator = Elaborator::new(program, recursive, graph);
    if !simplifies {
        elaborator = elaborator.without_limit();
    }
    elaborator.purpose = Some(Purpose { name: &function.name.text, kind: function.kind });
    let value = if recursive[index] { Value::Poison } else { elaborator.body(index, arguments) };
    if elaborator.diagnostics.is_empty()
        && (0..elaborator.graph.len()).any(|node| elaborator.graph.is_beyond(node))
    {
        elaborator.out_of_range(function.name.span);
    }
    let steps = elaborator.steps();
    let branches = std::mem::take(&mut elaborator.branches);
    let failed = !diagnostics.is_empty() || !elaborator.diagnostics.is_empty();
    diagnostics.append(&mut elaborator.diagnostics);
    if failed || !returns || value.is_poison() {
        return Outcome { definition: None, diagnostics, steps };
    }
    let extremes = std::mem::take(&mut elaborator.extremes);
    let mut graph = elaborator.graph;
    let mut singular = Vec::new();
    if simplifies {
        singular = risks::singular(&graph, &ranges::analyse(&graph), &elaborator.risks);
        diagnostics.extend(singular.iter().map(|place| place.warning.clone()));
        diagnostics.extend(function.domains.iter().filter_map(|clause| outside(clause, &signature)));
    }
    let law = law(function, &value);
    graph.signature.rows = law.rows();
    if let Law::Constraint { per_row, .. } = &law {
        let count = law.rows();
        for name in ADDED {
            let real = ParameterType::Real;
            let ty = if *per_row { ParameterType::Array(count as u32, Box::new(real)) } else { real };
            let added = parameter(function, known, name.to_owned(), ty, &mut diagnostics);
            graph.signature.parameters.push(added);
        }
    }
    let (name, docs) = (function.name.text.clone(), function.docs.clone());
    scales::guess(&mut graph);
    let span = function.name.span;
    let allowed = function.allowed.clone();
    let definition = Definition { name, docs, span, graph, law, allowed, extremes, singular, branches };
    Outcome { definition: Some(definition), diagnostics, steps }
}

/// Parameters that the compiler adds to a constraint.
const ADDED: [&str; 2] = ["stiffness", "damping"];

/// A parameter, with its value if the specialization sets one.
fn parameter(
    function: &Function,
    known: &Specialization,
    name: String,
    ty: ParameterType,
    diagnostics: &mut Vec<Diagnostic>,
) -> Parameter {
    let mut parameter = Parameter { name, ty, domain: Domain::Any, value: None };
    if let Err((message, help)) = known.give(&mut parameter) {
        let (place, label) = match function.sets(&parameter.name) {
            Some(place) => (place, "set here"),
            None => (function.name.span, "the function it is set for"),
        };
        diagnostics.push(Diagnostic::error(place, message, label).help(help));
    }
    parameter
}

/// The arguments of a kernel: bodies, then parameters with their domains.
fn signature(
    program: &Program<'_>,
    recursive: &[bool],
    index: usize,
    known: &Specialization,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Signature> {
    let function = &program.functions[index];
    let before = diagnostics.len();
    let mut signature = Signature::default();
    let mut poisoned = false;
    for (argument, ty) in function.arguments.iter().zip(&program.signatures[index].arguments) {
        let name = argument.name.text.clone();
        let span = argument.name.span;
        if ty.is_poisoned() {
            poisoned = true;
            continue;
        }
        if let Type::Body(kind) = ty {
            if !signature.parameters.is_empty() {
                diagnostics.push(
                    Diagnostic::error(span, format!("the body `{name}` stands behind a parameter"), "a body")
                        .help("write the bodies first, then the parameters"),
                );
            }
            signature.bodies.push(Body { name, kind: *kind, fixed: false });
            continue;
        }
        if matches!(function.kind, FunctionKind::Constraint { .. }) && ADDED.contains(&name.as_str()) {
            diagnostics.push(
                Diagnostic::error(
                    span,
                    format!("a constraint has a `{name}` already"),
                    "added by the compiler",
                )
                .help("choose another name, or leave the parameter out: the compiler multiplies by it"),
            );
        }
        let stored = ty.parameter();
        let Some(stored) = stored.filter(|_| ty.reals() <= LARGEST_VALUE) else {
            let label = match ty.parameter() {
                Some(_) => format!("{} reals; a parameter has at most {LARGEST_VALUE}", ty.reals()),
                None => format!("this is {}", ty.said()),
            };
            let help = match ty {
                Type::Integer => "write a `const` for what is known while compiling, or take a `Real`",
                Type::Truth => "take a `Real` and compare it",
                Type::Tuple(_) | Type::Wrench => "take its parts as parameters of their own",
                Type::Array(element, _) if matches!(**element, Type::Body(_)) => {
                    "take the bodies as arguments of their own"
                }
                _ => "parameters are `Real`, vectors, matrices, `Quat` and arrays of these",
            };
            diagnostics.push(
                Diagnostic::error(argument.ty.span, format!("`{name}` cannot be a parameter"), label)
                    .help(help),
            );
            continue;
        };
        signature.parameters.push(parameter(function, known, name, stored, diagnostics));
    }
    known.fix(&mut signature.bodies);
    if !signature.bodies.is_empty() && signature.dofs() == 0 {
        diagnostics.push(
            Diagnostic::error(
                function.name.span,
                format!("no body of `{}` moves", function.name.text),
                "all of them are fixed",
            )
            .help("leave one of them to move"),
        );
    }
    if signature.bodies.is_empty() && !poisoned && diagnostics.len() == before {
        diagnostics.push(
            Diagnostic::error(
                function.name.span,
                format!("`{}` acts on no body", function.name.text),
                "none of its arguments is a body",
            )
            .help("take a `Rigid` or a `Particle` as its first argument"),
        );
    }
    if function.arguments.len() > MOST_ARGUMENTS {
        diagnostics.push(
            Diagnostic::error(
                function.name.span,
                "a function has too many arguments",
                format!("{} of them; at most {MOST_ARGUMENTS}", function.arguments.len()),
            )
            .help("put parameters into arrays"),
        );
    }
    let mut elaborator = Elaborator::new(program, recursive, Graph::new(Signature::default()));
    elaborator.frame = crate::check::elaborator::Frame::new(&function.expressions, 0);
    for clause in &function.domains {
        domain(&mut elaborator, function, clause, &mut signature);
    }
    diagnostics.append(&mut elaborator.diagnostics);
    (diagnostics.len() == before && !poisoned).then_some(signature)
}

/// Stores the range of a field in the signature.
fn field_domain(
    e: &mut Elaborator<'_>,
    function: &Function,
    clause: &DomainClause,
    field: &Name,
    signature: &mut Signature,
) {
    let name = clause.name.text.as_str();
    let Some(body) = signature.bodies.iter().position(|body| body.name == name) else {
        let known = signature.bodies.iter().map(|body| body.name.as_str());
        let help = if signature.parameters.iter().any(|parameter| parameter.name == name) {
            Some(format!("a range holds for every entry of a parameter: write `{name} = …`"))
        } else {
            suggest::did_you_mean(name, known)
        };
        let label = format!("no body of `{}`", function.name.text);
        e.error_help(clause.name.span, format!("unknown body `{name}`"), label, help);
        return;
    };
    let fields = signature.bodies[body].kind.row().fields;
    let Some(found) = fields.iter().find(|own| own.name == field.text && own.role != Role::Orientation)
    else {
        let known: Vec<&str> =
            fields.iter().filter(|own| own.role != Role::Orientation).map(|own| own.name).collect();
        let (label, help) = match fields.iter().find(|own| own.name == field.text) {
            Some(_) => ("a quaternion of length one", "leave the clause out".to_owned()),
            None => ("no field of this body", format!("its fields are `{}`", known.join("`, `"))),
        };
        e.error_help(field.span, format!("`{}` has no range", field.text), label, Some(help));
        return;
    };
    let StatedDomain::Range(low, high) = clause.stated else {
        let help = format!("write `{name}.{} = -1.0..1.0`", field.text);
        e.error_help(clause.span, "the domain of a field is a range", "this is none", Some(help));
        return;
    };
    if let Some((low, high)) = range(e, function, clause, low, high) {
        let body = body as u16;
        signature.scale.fields.push(FieldDomain { body, role: found.role, low, high });
    }
}

/// Stores the length scale in the signature.
fn scale(
    e: &mut Elaborator<'_>,
    function: &Function,
    clause: &DomainClause,
    length: ExprId,
    signature: &mut Signature,
) {
    if function.arguments.iter().any(|argument| argument.name.text == clause.name.text) {
        e.error_help(
            clause.span,
            "one number is no domain of a parameter",
            format!(
                "`{}` is a parameter here, so that this is not the scale of all bodies",
                clause.name.text
            ),
            Some("write a range; for the scale, state `BODY.position = -1.0..1.0` of each body".to_owned()),
        );
        return;
    }
    let Some(length) = bound(e, function, length, "the scale of the bodies") else { return };
    if length > 0.0 {
        signature.scale.length = Some(length);
    } else {
        e.error_help(
            clause.span,
            "the scale of the bodies is not positive",
            format!("{length} is no length"),
            Some("write the length that bodies are apart by, as in `length = 1e-3`".to_owned()),
        );
    }
}

/// Bounds of a range; an error if they are not in order.
fn range(
    e: &mut Elaborator<'_>,
    function: &Function,
    clause: &DomainClause,
    low: ExprId,
    high: ExprId,
) -> Option<(f64, f64)> {
    const END: &str = "an end of a range";
    let (low, high) = (bound(e, function, low, END), bound(e, function, high, END));
    let (low, high) = (low?, high?);
    if low > high {
        e.error_help(
            clause.span,
            "an empty range",
            format!("{low} is above {high}"),
            Some("write the smaller end first".to_owned()),
        );
        return None;
    }
    Some((low, high))
}

/// Stores one clause of `#[domain(…)]` in the signature.
fn domain(e: &mut Elaborator<'_>, function: &Function, clause: &DomainClause, signature: &mut Signature) {
    let name = clause.name.text.as_str();
    match (clause.stated, &clause.field) {
        (_, Some(field)) => return field_domain(e, function, clause, field, signature),
        (StatedDomain::Scale(length), None) => return scale(e, function, clause, length, signature),
        _ => {}
    }
    let Some(parameter) = signature.parameters.iter_mut().find(|parameter| parameter.name == name) else {
        // An error about this parameter was reported earlier.
        if function.arguments.iter().any(|a| a.name.text == name)
            && !signature.bodies.iter().any(|b| b.name == name)
        {
            return;
        }
        let known = signature.parameters.iter().map(|parameter| parameter.name.as_str());
        let help = if signature.bodies.iter().any(|body| body.name == name) {
            Some(format!("state the range of a field, as in `{name}.position = -1.0..1.0`"))
        } else if name == "length" {
            Some("the scale of all bodies is one number, as in `length = 1e-3`".to_owned())
        } else {
            suggest::did_you_mean(name, known)
        };
        let label = format!("no parameter of `{}`", function.name.text);
        e.error_help(clause.name.span, format!("unknown parameter `{name}`"), label, help);
        return;
    };
    match clause.stated {
        StatedDomain::Unit => {
            if matches!(parameter.ty.innermost(), ParameterType::Vector(_) | ParameterType::Quaternion) {
                parameter.domain = Domain::Unit;
            } else {
                e.error_help(
                    clause.span,
                    format!("`{name}` cannot be a unit vector"),
                    "neither a vector nor a quaternion",
                    Some("state a range, as in `0.1..2.0`".to_owned()),
                );
            }
        }
        StatedDomain::Range(low, high) => {
            let Some((low, high)) = range(e, function, clause, low, high) else { return };
            if parameter.ty == ParameterType::Quaternion {
                e.error_help(
                    clause.span,
                    "a quaternion has no range",
                    "quaternions are taken as unit",
                    Some("leave the clause out".to_owned()),
                );
            } else {
                parameter.domain = Domain::Range(low, high);
            }
        }
        StatedDomain::Scale(_) => {}
    }
}

/// A warning if the value that is set for a parameter lies outside its domain.
fn outside(clause: &DomainClause, signature: &Signature) -> Option<Diagnostic> {
    let parameter = signature.parameters.iter().find(|parameter| parameter.name == clause.name.text)?;
    let value: Vec<f64> = parameter.value.as_ref()?.iter().map(Exact::to_f64).collect();
    let (found, is) = match (parameter.domain, parameter.ty.innermost()) {
        (Domain::Range(low, high), _) => (value.into_iter().find(|x| !(low..=high).contains(x))?, "is"),
        (Domain::Unit, ParameterType::Vector(n)) => {
            let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
            (value.chunks(*n as usize).map(norm).find(|norm| (norm - 1.0).abs() > 1e-6)?, "has the norm")
        }
        _ => return None,
    };
    let message = format!("`{}` is set to a value outside of its domain", parameter.name);
    let warning = Diagnostic::warning(clause.span, message, format!("what is set {is} {found}"));
    Some(warning.help("set another value, or state a wider domain").lint(Lint::OutsideDomain))
}

/// Evaluates a bound of a domain.
fn bound(e: &mut Elaborator<'_>, function: &Function, id: ExprId, what: &str) -> Option<f64> {
    let span = function.expressions[id].span;
    let value = e.expr(id);
    let value = e.expect(value, &Type::Real, span, &format!("{what} is `Real`"));
    let Value::Real(real) = value else { return None };
    let range = ranges::analyse(&e.graph).of(real);
    if range.low != range.high || !range.low.is_finite() {
        e.error_help(
            span,
            format!("{what} is not a plain number"),
            "its value is not known here",
            Some("write a number, or a multiple of `PI`".to_owned()),
        );
        return None;
    }
    Some(range.low)
}

/// Whether the function returns a type that its kind allows; if not, reports it.
fn returns(program: &Program<'_>, index: usize, diagnostics: &mut Vec<Diagnostic>) -> bool {
    let function = &program.functions[index];
    let FunctionTypeParts { bodies, output } = parts(program, index);
    let span = function.output.span;
    if output.is_poisoned() {
        return false;
    }
    let name = &function.name.text;
    // A missing value is reported for the function, a wrong type for its kind.
    let refused = |kind: &str, any: &str| match output {
        Type::Tuple(types) if types.is_empty() => format!("the {kind} `{name}` returns no value"),
        _ => format!("{any} does not return {}", output.said()),
    };
    let message = match function.kind {
        FunctionKind::Helper => return true,
        FunctionKind::Constraint { .. } => match output.rows() {
            Some(rows) if rows <= LARGEST_VALUE => return true,
            Some(rows) => Diagnostic::error(
                span,
                format!("the constraint `{name}` has too many rows"),
                format!("{rows} of them; at most {LARGEST_VALUE}"),
            ),
            None => {
                Diagnostic::error(span, refused("constraint", "a constraint"), "not the rows of a constraint")
                    .help("return `Real`, a vector, or a tuple or array of these")
            }
        },
        FunctionKind::Energy if *output == Type::Real => return true,
        FunctionKind::Energy => {
            Diagnostic::error(span, refused("energy", "an energy"), "an energy is one number")
                .help("return `Real`")
        }
        FunctionKind::Force => {
            let wanted: Vec<Type> = bodies
                .iter()
                .map(|kind| if *kind == BodyKind::RIGID { Type::Wrench } else { Type::Vector(3) })
                .collect();
            if wanted.is_empty() || *output == Type::Tuple(wanted.clone()) {
                return true;
            }
            let wanted = match wanted.as_slice() {
                [one] if one == output => return true,
                [one] => one.clone(),
                _ => Type::Tuple(wanted),
            };
            Diagnostic::error(
                span,
                refused("force", &format!("the force `{name}`")),
                "a force on every body, in order: `Wrench` for `Rigid`, `Vec3` for `Particle`",
            )
            .help(format!("return `{wanted}`"))
        }
    };
    diagnostics.push(message);
    false
}

struct FunctionTypeParts<'a> {
    bodies: Vec<BodyKind>,
    output: &'a Type,
}

fn parts<'a>(program: &'a Program<'_>, index: usize) -> FunctionTypeParts<'a> {
    let ty = &program.signatures[index];
    let bodies = ty.arguments.iter().filter_map(|ty| match ty {
        Type::Body(kind) => Some(*kind),
        _ => None,
    });
    FunctionTypeParts { bodies: bodies.collect(), output: &ty.output }
}

/// The law that a value of a checked type states.
fn law(function: &Function, value: &Value) -> Law {
    match function.kind {
        FunctionKind::Constraint { unilateral, per_row } => {
            let mut rows = Vec::new();
            flatten(value, &mut rows);
            Law::Constraint { rows, unilateral, per_row }
        }
        FunctionKind::Energy => Law::Energy(value.real()),
        FunctionKind::Force | FunctionKind::Helper => Law::Force(match value {
            Value::Tuple(composite) => composite.elements.iter().map(generalised).collect(),
            one => vec![generalised(one)],
        }),
    }
}

fn generalised(value: &Value) -> Generalised {
    match value {
        Value::Wrench(force, torque) => Generalised { force: *force, torque: Some(*torque) },
        other => Generalised { force: other.vector(), torque: None },
    }
}

fn flatten(value: &Value, rows: &mut Vec<Row>) {
    match value {
        Value::Vector(v) => rows.push(Row::Vector(*v)),
        Value::Few(entries) => rows.extend(entries.iter().map(|x| Row::Real(*x))),
        Value::Tuple(_) | Value::Array(_) => {
            value.elements().iter().for_each(|element| flatten(element, rows));
        }
        other => rows.push(Row::Real(other.real())),
    }
}

// ---- arguments as values

/// The arguments of a kernel as values.
fn arguments(graph: &mut Graph, signature: &Signature) -> Vec<Value> {
    let bodies = signature.bodies.iter().enumerate();
    let mut values: Vec<Value> = bodies.map(|(k, body)| Value::Body(k as u16, body.kind)).collect();
    for (k, parameter) in signature.parameters.iter().enumerate() {
        values.push(stored(graph, signature.parameter_slot(k, 0), &parameter.ty));
    }
    values
}

/// The value at a slot.
fn stored(g: &mut Graph, slot: Slot, ty: &ParameterType) -> Value {
    let at = |offset: u32| Slot { offset: slot.offset + offset, ..slot };
    match ty {
        ParameterType::Real => Value::Real(g.entry(slot)),
        ParameterType::Vector(3) => Value::Vector(g.triple(slot)),
        ParameterType::Vector(n) => Value::Few((0..*n).map(|k| g.entry(at(k))).collect()),
        ParameterType::Matrix(3) => Value::Matrix3(Matrix3::rows([0, 3, 6].map(|k| g.triple(at(k))))),
        ParameterType::Matrix(_) => Value::Matrix2([0, 1, 2, 3].map(|k| g.entry(at(k)))),
        ParameterType::Quaternion if g.simplifies() && is_identity(g, slot) => {
            Value::Quat(Quaternion::identity())
        }
        ParameterType::Quaternion => Value::Quat(Quaternion::stored(slot)),
        ParameterType::Array(n, element) => {
            let length = element.length() as u32;
            Value::array((0..*n).map(|k| stored(g, at(k * length), element)).collect())
        }
    }
}

/// Whether a quaternion argument is known to be the identity.
fn is_identity(g: &Graph, slot: Slot) -> bool {
    let entries = [Exact::ZERO, Exact::ZERO, Exact::ZERO, Exact::ONE];
    let at = |offset: u32| g.signature.known(Slot { offset: slot.offset + offset, ..slot });
    (0..).zip(entries).all(|(offset, entry)| at(offset) == Some(entry))
}

/// Symbolic values of these types. Integers have no symbolic value and become `Poison`.
pub(crate) fn symbolic(e: &mut Elaborator<'_>, types: &[Type]) -> Vec<Value> {
    let mut signature = Signature::default();
    for ty in types {
        bodies_of(ty, &mut signature);
    }
    e.graph = Graph::new(signature);
    let mut next_body = 0;
    types.iter().map(|ty| any(e, ty, &mut next_body)).collect()
}

fn bodies_of(ty: &Type, signature: &mut Signature) {
    match ty {
        Type::Body(kind) if signature.bodies.len() < MOST_ARGUMENTS => {
            signature.bodies.push(Body { name: String::new(), kind: *kind, fixed: false });
        }
        Type::Tuple(types) => types.iter().for_each(|ty| bodies_of(ty, signature)),
        Type::Array(element, n) if contains_body(element) => {
            (0..(*n).min(MOST_ARGUMENTS as u32)).for_each(|_| bodies_of(element, signature));
        }
        _ => {}
    }
}

fn contains_body(ty: &Type) -> bool {
    match ty {
        Type::Body(_) => true,
        Type::Tuple(types) => types.iter().any(contains_body),
        Type::Array(element, _) => contains_body(element),
        _ => false,
    }
}

fn any(e: &mut Elaborator<'_>, ty: &Type, next_body: &mut u16) -> Value {
    if let Some(parameter) = ty.parameter() {
        let count = e.graph.signature.parameters.len();
        if ty.reals() > LARGEST_VALUE || count > 10 * MOST_ARGUMENTS {
            return Value::Poison;
        }
        let slot = e.graph.signature.parameter_slot(count, 0);
        let new = Parameter { name: String::new(), ty: parameter.clone(), domain: Domain::Any, value: None };
        e.graph.signature.parameters.push(new);
        return stored(&mut e.graph, slot, &parameter);
    }
    match ty {
        Type::Body(kind) => {
            let body = *next_body;
            *next_body += 1;
            if usize::from(body) < e.graph.signature.bodies.len() {
                Value::Body(body, *kind)
            } else {
                Value::Poison
            }
        }
        Type::Truth => {
            let Value::Real(x) = any(e, &Type::Real, next_body) else { return Value::Poison };
            let zero = e.graph.zero();
            Value::Truth(e.graph.compare(Comparison::Less, zero, x))
        }
        Type::Wrench => match (any(e, &Type::Vector(3), next_body), any(e, &Type::Vector(3), next_body)) {
            (Value::Vector(force), Value::Vector(torque)) => Value::Wrench(force, torque),
            _ => Value::Poison,
        },
        Type::Tuple(types) => Value::tuple(types.iter().map(|ty| any(e, ty, next_body)).collect()),
        Type::Array(element, n) if u64::from(*n) <= MOST_ARGUMENTS as u64 => {
            Value::array((0..*n).map(|_| any(e, element, next_body)).collect())
        }
        _ => Value::Poison,
    }
}
