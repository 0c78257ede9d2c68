//! States for checking a kernel, drawn from a seed.
//!
//! In: the indices of inputs, a family and a number. Out: a value for every input; a seed gives the same bits
//! on every platform. Parameters stay within their stated domains. The norm of a stored quaternion is as near
//! to 1 as doubles near the drawn rotation allow, about 1e-18, so errors from |q| ≠ 1 are below rounding.

use crate::math::random::Random;
use crate::model::bodies::{Domain, ParameterType, Role};
use crate::sample::inputs::Places;
use std::fmt;

/// A family of states.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Family {
    /// All values are of order one.
    Random,
    /// All velocities are zero.
    Rest,
    /// All orientations are the identity.
    Identity,
    /// Bodies are almost coincident, almost aligned or almost opposite.
    NearSingular,
    /// Bodies are 1e4 to 1e6 from the origin.
    Far,
    /// Stiffness 1e8 to 1e10, damping 1e4 to 1e6; without these, some real parameters scaled by 1e2 to 1e8.
    Stiff,
    /// Slivers and needles of three or more points, aspect 1e2 to 1e4, and two points that almost coincide.
    Degenerate,
    /// Bodies as far apart as a length that the source names.
    Named,
    /// States near branch boundaries, on either side, and near zeros of norms and of sums with a number, 1e-3
    /// to 1e-12 of the scale away. A drawn state is random; a search moves it to a boundary.
    Edges,
}

impl Family {
    /// All families, in the order of reports.
    pub const ALL: [Family; 9] = [
        Family::Random,
        Family::Rest,
        Family::Identity,
        Family::NearSingular,
        Family::Far,
        Family::Stiff,
        Family::Degenerate,
        Family::Named,
        Family::Edges,
    ];

    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Family::Random => "random",
            Family::Rest => "at rest",
            Family::Identity => "identity orientation",
            Family::NearSingular => "near-singular",
            Family::Far => "far",
            Family::Stiff => "stiff",
            Family::Degenerate => "degenerate",
            Family::Named => "named lengths",
            Family::Edges => "edges",
        }
    }

    /// Whether this signature has such states: slivers need three bodies, `Named` needs named lengths.
    #[cfg(feature = "verify")]
    pub(crate) fn applies(self, places: &Places) -> bool {
        let signature = &places.signature;
        match self {
            Family::Degenerate => signature.bodies.len() >= 3,
            Family::Named => !signature.scale.named.is_empty(),
            _ => true,
        }
    }

    /// Number of states of this family, if others have `states`.
    #[cfg(feature = "verify")]
    pub(crate) fn states(self, states: usize) -> usize {
        match self {
            Family::Degenerate | Family::Named => states.div_ceil(2),
            _ => states,
        }
    }

    /// Whether even a well-behaved function may lose digits, because states are near singular ones.
    pub fn is_near(self) -> bool {
        matches!(self, Family::NearSingular | Family::Degenerate | Family::Edges)
    }

    /// Whether rounding leaves most digits of a well-behaved function: neither far nor near singular states.
    pub fn is_ordinary(self) -> bool {
        matches!(self, Family::Random | Family::Rest | Family::Identity)
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

fn normalized(v: &[f64]) -> Vec<f64> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.iter().map(|x| x / norm).collect()
}

/// |q|² − 1 with a single rounding.
pub(crate) fn excess(q: &[f64]) -> f64 {
    let mut terms = vec![-1.0];
    for &x in q {
        let square = x * x;
        terms.extend([square, x.mul_add(x, -square)]);
    }
    terms.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
    // Compensated summation: the rounding errors of the additions are added at the end.
    let (mut sum, mut lost) = (0.0f64, 0.0f64);
    for x in terms {
        let next = sum + x;
        let back = next - sum;
        lost += (sum - (next - back)) + (x - back);
        sum = next;
    }
    sum + lost
}

/// The quaternion near q whose stored bits have the norm nearest to 1.
pub(crate) fn unit_quaternion(q: &[f64]) -> Vec<f64> {
    let mut q = normalized(q);
    // From the largest entry down, each changes by the number of ulps that brings the norm nearest to 1; ulps
    // of the smallest entries are the finest.
    let mut order = vec![0, 1, 2, 3];
    order.sort_by(|&i: &usize, &j: &usize| q[j].abs().total_cmp(&q[i].abs()));
    order.retain(|&k| q[k].abs() > 1e-3);
    for k in order {
        let unit = q[k].abs().next_up() - q[k].abs();
        let steps = (-excess(&q) / (2.0 * q[k] * unit)).round().clamp(-64.0, 64.0);
        q[k] += steps * unit;
    }
    let mut best = q.clone();
    for choice in 0..81u32 {
        let mut candidate = q.clone();
        for (k, x) in candidate.iter_mut().enumerate() {
            *x = match choice / 3u32.pow(k as u32) % 3 {
                0 => *x,
                1 => x.next_up(),
                _ => x.next_down(),
            };
        }
        if excess(&candidate).abs() < excess(&best).abs() {
            best = candidate;
        }
    }
    best
}

/// A state, and the length below which its geometry changes.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub(crate) values: Vec<f64>,
    pub(crate) scale: f64,
}

/// Draws a state. `gains` says that the last two parameters are the stiffness and damping of a constraint.
pub(crate) fn draw(places: &Places, gains: bool, family: Family, index: usize, random: &mut Random) -> State {
    let named = &places.signature.scale.named;
    let length = match family {
        Family::Named if !named.is_empty() => named[index % named.len()],
        _ => places.signature.scale.length.unwrap_or(1.0),
    };
    let mut state = State { values: vec![0.0; places.length], scale: length };
    bodies(places, &mut state.values, random);
    let parameters = places.signature.parameters.len();
    for (p, parameter) in places.signature.parameters.iter().enumerate() {
        let at = places.parameter(p);
        let values = &mut state.values[at..at + parameter.ty.length() as usize];
        if gains && p + 2 >= parameters {
            let stiffness = p + 2 == parameters;
            for x in values {
                *x = match (family, stiffness) {
                    (Family::Stiff, true) => random.decades(8, 10),
                    (Family::Stiff, false) => random.decades(4, 6),
                    (_, true) => random.decades(0, 3),
                    (_, false) => random.decades(-1, 2),
                };
            }
            continue;
        }
        fill(&parameter.ty, parameter.domain, values, random);
        if parameter.domain == Domain::Any
            && let Some(power) = places.signature.scale.powers.get(p).filter(|power| **power != 0.0)
        {
            let factor = power_of(length, *power);
            values.iter_mut().for_each(|x| *x *= factor);
        }
        let free = parameter.ty == ParameterType::Real && parameter.domain == Domain::Any;
        if free && family == Family::Stiff && !gains && random.chance(2) {
            values[0] *= random.decades(2, 8);
        }
    }
    for (e, extra) in places.signature.extras.iter().enumerate() {
        let at = places.parameter(parameters + e);
        for x in &mut state.values[at..at + extra.ty.length() as usize] {
            // A time step is positive.
            *x = if extra.name == "step" { random.decades(-4, 0) } else { random.uniform(-2.0, 2.0) };
        }
    }
    if length != 1.0 {
        each(places, &mut state.values, &[Role::Position, Role::Velocity], |_, x| {
            x.iter_mut().for_each(|x| *x *= length);
        });
    }
    stated(places, &mut state.values, random);
    match family {
        Family::Random | Family::Stiff | Family::Named | Family::Edges => {}
        Family::Degenerate => degenerate(places, &mut state, index, random),
        Family::Rest => {
            each(places, &mut state.values, &[Role::Velocity, Role::AngularVelocity], |_, v| v.fill(0.0))
        }
        Family::Identity => each(places, &mut state.values, &[Role::Orientation], |_, q| {
            q.copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
        }),
        Family::Far => {
            let distance = random.decades(4, 6) * length;
            let offset: Vec<f64> = random.unit(3).iter().map(|x| x * distance).collect();
            each(places, &mut state.values, &[Role::Position], |_, x| {
                x.iter_mut().zip(&offset).for_each(|(x, o)| *x += o);
            });
        }
        Family::NearSingular => {
            state.scale = random.decades(-8, -2);
            let near = state.scale;
            match index % 3 {
                0 => coincide(places, &mut state, random),
                1 => align(places, &mut state, random, false),
                _ => align(places, &mut state, random, true),
            }
            state.scale = near * length;
        }
    }
    known(places, &mut state.values);
    state
}

/// Sets inputs whose values are known at compile time.
fn known(places: &Places, values: &mut [f64]) {
    let roles = [Role::Velocity, Role::AngularVelocity];
    for (body, argument) in places.signature.bodies.iter().enumerate().filter(|(_, body)| body.fixed) {
        for field in
            roles.into_iter().filter_map(|role| argument.kind.field(role).and(places.field(body, role)))
        {
            values[field..field + 3].fill(0.0);
        }
    }
    let parameters = places.signature.parameters.iter().chain(&places.signature.extras);
    for (p, parameter) in parameters.enumerate() {
        for (k, value) in parameter.value.iter().flatten().enumerate() {
            values[places.parameter(p) + k] = value.to_f64();
        }
    }
}

fn bodies(places: &Places, values: &mut [f64], random: &mut Random) {
    let roles = [Role::Position, Role::Orientation, Role::Velocity, Role::AngularVelocity];
    each(places, values, &roles, |role, field| match role {
        Role::Orientation => field.copy_from_slice(&unit_quaternion(&random.unit(4))),
        Role::AngularVelocity => field.fill_with(|| random.uniform(-3.0, 3.0)),
        _ => field.fill_with(|| random.uniform(-2.0, 2.0)),
    });
}

/// lengthᵖᵒʷᵉʳ for whole and half powers, without library calls, so the same on every platform.
fn power_of(length: f64, power: f64) -> f64 {
    let halves = (2.0 * power).round();
    let root = length.sqrt();
    let product = (0..halves.abs().min(64.0) as u32).fold(1.0, |product, _| product * root);
    if halves < 0.0 { 1.0 / product } else { product }
}

/// Draws the fields with stated ranges.
fn stated(places: &Places, values: &mut [f64], random: &mut Random) {
    for field in &places.signature.scale.fields {
        if let Some(at) = places.field(usize::from(field.body), field.role) {
            values[at..at + 3].fill_with(|| random.uniform(field.low, field.high));
        }
    }
}

/// Projects changed values to valid ones: quaternions and unit vectors to length one, others to their ranges;
/// known values are restored.
#[cfg(feature = "verify")]
pub(crate) fn project(places: &Places, values: &mut [f64]) {
    each(places, values, &[Role::Orientation], |_, q| {
        let unit = unit_quaternion(q);
        q.copy_from_slice(&unit);
    });
    for field in &places.signature.scale.fields {
        if let Some(at) = places.field(usize::from(field.body), field.role) {
            values[at..at + 3].iter_mut().for_each(|x| *x = x.clamp(field.low, field.high));
        }
    }
    for (p, parameter) in places.signature.parameters.iter().enumerate() {
        let at = places.parameter(p);
        let values = &mut values[at..at + parameter.ty.length() as usize];
        match (parameter.ty.innermost(), parameter.domain) {
            (ParameterType::Quaternion, _) => values.chunks_mut(4).for_each(|q| {
                let unit = unit_quaternion(q);
                q.copy_from_slice(&unit);
            }),
            (_, Domain::Range(low, high)) => values.iter_mut().for_each(|x| *x = x.clamp(low, high)),
            (ParameterType::Vector(n), Domain::Unit) => values.chunks_mut(*n as usize).for_each(|v| {
                let unit = normalized(v);
                v.copy_from_slice(&unit);
            }),
            _ => {}
        }
    }
    known(places, values);
}

/// Flattens three or more bodies to a sliver or a needle, or moves two bodies almost together.
fn degenerate(places: &Places, state: &mut State, index: usize, random: &mut Random) {
    let starts: Vec<usize> =
        (0..places.signature.bodies.len()).filter_map(|body| places.field(body, Role::Position)).collect();
    let (Some(&first), Some(&second)) =
        (starts.get(index % starts.len().max(1)), starts.get((index + 1) % starts.len().max(1)))
    else {
        return;
    };
    let aspect = 1.0 / random.decades(2, 4);
    let centre = [0, 1, 2].map(|k| state.values[first + k]);
    let axis = random.unit(3);
    if index % 3 == 2 {
        let way = random.unit(3);
        for k in 0..3 {
            state.values[second + k] = centre[k] + aspect * state.scale * way[k];
        }
    } else {
        // Shrinks the component along the axis, or the components across it.
        for at in starts {
            let apart = [0, 1, 2].map(|k| state.values[at + k] - centre[k]);
            let along: f64 = apart.iter().zip(&axis).map(|(x, a)| x * a).sum();
            for k in 0..3 {
                let (flat, across) = (along * axis[k], apart[k] - along * axis[k]);
                let kept =
                    if index.is_multiple_of(3) { aspect * flat + across } else { flat + aspect * across };
                state.values[at + k] = centre[k] + kept;
            }
        }
    }
    state.scale *= aspect;
}

/// Changes every field with one of these roles, body by body.
fn each(places: &Places, values: &mut [f64], roles: &[Role], mut change: impl FnMut(Role, &mut [f64])) {
    for body in 0..places.signature.bodies.len() {
        for &role in roles {
            if let Some(at) = places.field(body, role) {
                let length = if role == Role::Orientation { 4 } else { 3 };
                change(role, &mut values[at..at + length]);
            }
        }
    }
}

/// Draws a parameter within its domain.
fn fill(ty: &ParameterType, domain: Domain, values: &mut [f64], random: &mut Random) {
    match (ty, domain) {
        (ParameterType::Array(_, element), _) => {
            for part in values.chunks_mut((element.length() as usize).max(1)) {
                fill(element, domain, part, random);
            }
        }
        (ParameterType::Quaternion, _) => values.copy_from_slice(&unit_quaternion(&random.unit(4))),
        (_, Domain::Range(low, high)) => {
            let (low, high) = (low.max(-1e3), high.min(low.max(-1e3) + 2e3));
            let wide = low > 0.0 && high / low > 1e3;
            for x in values {
                *x = random.uniform(low, high);
                if wide {
                    // Ranges of many decades also get small values.
                    *x = (*x * random.decades(-3, 0).min(1.0)).clamp(low, high);
                }
            }
        }
        (ParameterType::Vector(n), Domain::Unit) => values.copy_from_slice(&random.unit(*n as usize)),
        (_, Domain::Unit) => values.fill_with(|| if random.chance(2) { 1.0 } else { -1.0 }),
        (ParameterType::Real, Domain::Any) => {
            let sign = if random.chance(8) { -1.0 } else { 1.0 };
            values[0] = sign * random.uniform(0.1, 2.0);
        }
        (ParameterType::Matrix(n), Domain::Any) => {
            // Mostly near the identity, because matrices are often inverses of rest shapes.
            let spread = if random.chance(4) { 2.0 } else { 0.5 };
            for (k, x) in values.iter_mut().enumerate() {
                let diagonal = k % (*n as usize + 1) == 0;
                *x = random.uniform(-spread, spread) + if diagonal { 1.0 } else { 0.0 };
            }
        }
        (_, Domain::Any) => values.fill_with(|| random.uniform(-2.0, 2.0)),
    }
}

/// Shrinks positions about one point, and vectors without a stated domain about zero.
fn coincide(places: &Places, state: &mut State, random: &mut Random) {
    let length = places.signature.scale.length.unwrap_or(1.0);
    let centre: Vec<f64> = (0..3).map(|_| length * random.uniform(-2.0, 2.0)).collect();
    let scale = state.scale;
    each(places, &mut state.values, &[Role::Position], |_, x| {
        x.iter_mut().zip(&centre).for_each(|(x, c)| *x = c + scale * *x);
    });
    for (p, parameter) in places.signature.parameters.iter().enumerate() {
        if parameter.domain == Domain::Any && parameter.ty == ParameterType::Vector(3) {
            let at = places.parameter(p);
            state.values[at..at + 3].iter_mut().for_each(|x| *x *= scale);
        }
    }
}

/// Makes orientations differ by a small rotation or almost half a turn, and vectors of three almost parallel.
fn align(places: &Places, state: &mut State, random: &mut Random, opposite: bool) {
    let scale = state.scale;
    let first = random.unit(4);
    let axis = random.unit(3);
    let mut number = 0;
    each(places, &mut state.values, &[Role::Orientation], |_, q| {
        let mut turn: Vec<f64> = random.unit(3).iter().map(|x| x * scale).collect();
        turn.push(1.0);
        if opposite && number % 2 == 1 {
            turn = axis.iter().zip(random.unit(3)).map(|(a, n)| a + scale * n).collect();
            turn.push(scale);
        }
        number += 1;
        q.copy_from_slice(&unit_quaternion(&product(&turn, &first)));
    });
    let direction = random.unit(3);
    for (p, parameter) in places.signature.parameters.iter().enumerate() {
        if parameter.ty == ParameterType::Vector(3) && !matches!(parameter.domain, Domain::Range(..)) {
            let at = places.parameter(p);
            let v = &mut state.values[at..at + 3];
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            let near: Vec<f64> = direction.iter().zip(random.unit(3)).map(|(d, n)| d + scale * n).collect();
            v.copy_from_slice(&normalized(&near));
            if parameter.domain == Domain::Any {
                v.iter_mut().for_each(|x| *x *= length);
            }
        }
    }
}

/// The product of quaternions stored x, y, z, w.
fn product(p: &[f64], q: &[f64]) -> Vec<f64> {
    vec![
        p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1],
        p[3] * q[1] + p[1] * q[3] + p[2] * q[0] - p[0] * q[2],
        p[3] * q[2] + p[2] * q[3] + p[0] * q[1] - p[1] * q[0],
        p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2],
    ]
}

/// The seed of one draw.
pub(crate) fn seed(seed: u64, family: Family, number: u64) -> u64 {
    let mut random = Random::new(seed ^ ((family as u64) << 56) ^ (number << 32));
    random.next()
}
