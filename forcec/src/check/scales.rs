//! Guesses the length scale of a function from its domains and literals.
//!
//! In: the graph of a function, with the domains of its parameters. Out: [`Scale`] in its signature.
//! Dimensional analysis: positions are lengths, sums and comparisons need equal exponents of length, products
//! add exponents. The guess only decides where states are drawn; unknown exponents stay unknown.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::{Domain, ParameterType, Role, Slot};
use crate::vector::{Graph, Node};

/// Maximum number of rounds; a round uses the exponents of parameters from earlier ones.
const ROUNDS: usize = 4;
/// Scales in this range are of order one and need no guess.
const ORDINARY: std::ops::Range<f64> = 1e-2..1e3;
/// Literals in this range do not define a scale.
const COMMON: std::ops::Range<f64> = 0.05..50.0;
/// Lengths whose powers stay in the range of doubles.
const POSSIBLE: std::ops::Range<f64> = 1e-15..1e15;
/// Maximum number of named lengths.
const MOST_NAMED: usize = 8;

/// Stores the guessed scale of a function in its signature.
pub(super) fn guess(graph: &mut Graph) {
    let mut powers =
        Powers { nodes: vec![None; graph.len()], parameters: vec![None; graph.signature.parameters.len()] };
    for _ in 0..ROUNDS {
        let before = powers.parameters.clone();
        powers.forward(graph);
        powers.backward(graph);
        if powers.parameters == before {
            break;
        }
    }
    let mut named: Vec<f64> = Vec::new();
    let mut largest: Option<f64> = None;
    for (parameter, power) in graph.signature.parameters.iter().zip(&powers.parameters) {
        let Some(power) = power.filter(|power| *power != 0.0) else { continue };
        let ends: Vec<f64> = match (parameter.domain, &parameter.value) {
            (_, Some(value)) => value.iter().map(Exact::to_f64).collect(),
            (Domain::Range(low, high), None) => vec![low, high],
            _ => continue,
        };
        let lengths: Vec<f64> = ends.iter().filter_map(|end| root(*end, power)).collect();
        largest = lengths.iter().copied().chain(largest).reduce(f64::max);
        named.extend(lengths);
    }
    for (index, node) in graph.nodes().enumerate() {
        let number = match node {
            Node::Sum(constant, _) if !constant.is_zero() => constant,
            Node::Constant(constant) => constant,
            _ => continue,
        };
        match powers.nodes[index] {
            Some(power) if power != 0.0 => named.extend(root(number.to_f64(), power)),
            _ => named.extend(root(number.to_f64(), 1.0).filter(|length| !COMMON.contains(length))),
        }
    }
    let guessed = largest.filter(|length| !ORDINARY.contains(length));
    let length = graph.signature.scale.length.or(guessed);
    let scale = length.unwrap_or(1.0);
    named.retain(|length| !(0.1 * scale..10.0 * scale).contains(length));
    // One length per decade is enough.
    let mut kept: Vec<f64> = Vec::new();
    for length in named {
        if kept.len() < MOST_NAMED && !kept.iter().any(|kept| (kept / 10.0..kept * 10.0).contains(&length)) {
            kept.push(length);
        }
    }
    let scale = &mut graph.signature.scale;
    scale.length = length;
    scale.powers = powers.parameters.iter().map(|power| power.unwrap_or(0.0)).collect();
    scale.named = kept;
}

/// The length L with L^`power` = |`number`|, if it is possible.
fn root(number: f64, power: f64) -> Option<f64> {
    let length = number.abs().powf(1.0 / power);
    // Two digits of a root are enough, and the same on every platform.
    let length = if power == 1.0 { length } else { format!("{length:.1e}").parse().unwrap_or(length) };
    (number != 0.0 && POSSIBLE.contains(&length)).then_some(length)
}

/// Exponents of length of nodes and parameters, as far as known.
struct Powers {
    nodes: Vec<Option<f64>>,
    parameters: Vec<Option<f64>>,
}

impl Powers {
    fn slot(&self, graph: &Graph, slot: Slot) -> Option<f64> {
        match graph.signature.role(slot) {
            Some(Role::Position | Role::Velocity) => Some(1.0),
            Some(Role::Orientation | Role::AngularVelocity) => Some(0.0),
            None => {
                let index = (slot.argument as usize).checked_sub(graph.signature.bodies.len())?;
                let parameter = graph.signature.parameters.get(index)?;
                let pure = *parameter.ty.innermost() == ParameterType::Quaternion
                    || parameter.domain == Domain::Unit;
                if pure { Some(0.0) } else { self.parameters[index] }
            }
        }
    }

    /// Infers exponents of results.
    fn forward(&mut self, graph: &Graph) {
        for (index, node) in graph.nodes().enumerate() {
            let of = |operand: usize| self.nodes[operand];
            // In a sum, a literal has the exponent of the other terms; as a factor, it has exponent 0.
            let factor = |operand: usize| match graph.node(operand) {
                Node::Constant(_) => Some(0.0),
                _ => of(operand),
            };
            let both = |x: usize, y: usize| Some(factor(x)? + factor(y)?);
            let either = |x: usize, y: usize| of(x).or(of(y));
            let power = match node {
                Node::Entry(slot) | Node::Triple(slot) => self.slot(graph, *slot),
                Node::Difference(first, second) => self.slot(graph, *first).or(self.slot(graph, *second)),
                Node::Sum(_, terms) => terms.iter().find_map(|(_, x)| of(x.index())),
                Node::Product(factors) => {
                    let mut sum = Some(0.0);
                    for (x, n) in factors {
                        sum = sum.zip(factor(x.index())).map(|(sum, power)| sum + power * f64::from(*n));
                    }
                    sum
                }
                Node::Dot(u, v) => both(u.index(), v.index()),
                Node::Cross(u, v) => both(u.index(), v.index()),
                Node::Scale(s, v) => both(s.index(), v.index()),
                Node::Component(v, _) | Node::Norm(v) | Node::VectorLet(v) | Node::Rotate(_, _, v) => {
                    of(v.index())
                }
                Node::Let(x) => of(x.index()),
                Node::Select(_, x, y) => either(x.index(), y.index()),
                Node::VectorSelect(_, u, v) => either(u.index(), v.index()),
                Node::VectorSum(terms) => terms.iter().find_map(|(_, v)| of(v.index())),
                Node::Pack(entries) => entries.iter().find_map(|x| of(x.index())),
                Node::TurnReal(_) | Node::TurnVector(_) => Some(0.0),
                Node::Call(function, x) => match function {
                    Function::Sqrt => of(x[0].index()).map(|power| power / 2.0),
                    Function::Cbrt => of(x[0].index()).map(|power| power / 3.0),
                    Function::Abs => of(x[0].index()),
                    Function::Min | Function::Max | Function::Hypot => either(x[0].index(), x[1].index()),
                    Function::Powf => factor(x[0].index()).filter(|power| *power == 0.0),
                    _ => Some(0.0),
                },
                _ => None,
            };
            self.nodes[index] = self.nodes[index].or(power);
        }
    }

    /// Infers exponents of operands, and across comparisons.
    fn backward(&mut self, graph: &Graph) {
        for index in (0..graph.len()).rev() {
            let node = graph.node(index);
            let own = self.nodes[index];
            let tell = |powers: &mut Powers, operand: usize, power: Option<f64>| {
                powers.nodes[operand] = powers.nodes[operand].or(power);
            };
            match node {
                Node::Entry(slot) | Node::Triple(slot) => {
                    if let Some(parameter) =
                        (slot.argument as usize).checked_sub(graph.signature.bodies.len())
                        && let Some(known) = self.parameters.get_mut(parameter)
                    {
                        *known = known.or(own);
                    }
                }
                Node::Difference(first, second) => {
                    for slot in [first, second] {
                        if let Some(parameter) =
                            (slot.argument as usize).checked_sub(graph.signature.bodies.len())
                            && let Some(known) = self.parameters.get_mut(parameter)
                        {
                            *known = known.or(own);
                        }
                    }
                }
                Node::Sum(_, terms) => terms.iter().for_each(|(_, x)| tell(self, x.index(), own)),
                Node::VectorSum(terms) => terms.iter().for_each(|(_, v)| tell(self, v.index(), own)),
                Node::Component(v, _) | Node::Norm(v) | Node::VectorLet(v) | Node::Rotate(_, _, v) => {
                    tell(self, v.index(), own);
                }
                Node::Let(x) => tell(self, x.index(), own),
                Node::Pack(entries) => entries.iter().for_each(|x| tell(self, x.index(), own)),
                Node::Select(_, x, y) => [x, y].into_iter().for_each(|x| tell(self, x.index(), own)),
                Node::VectorSelect(_, u, v) => [u, v].into_iter().for_each(|v| tell(self, v.index(), own)),
                Node::Dot(u, v) | Node::Cross(u, v) => self.factor(own, [u.index(), v.index()]),
                Node::Scale(s, v) => self.factor(own, [s.index(), v.index()]),
                Node::Product(factors) => {
                    let unknown: Vec<_> =
                        factors.iter().filter(|(x, _)| self.nodes[x.index()].is_none()).collect();
                    let known =
                        factors.iter().filter_map(|(x, n)| Some(self.nodes[x.index()]? * f64::from(*n)));
                    let known: f64 = known.sum();
                    if let (Some(own), [(x, n)]) = (own, unknown.as_slice())
                        && *n != 0
                    {
                        tell(self, x.index(), Some((own - known) / f64::from(*n)));
                    }
                }
                Node::Compare(_, x, y) => {
                    let either = self.nodes[x.index()].or(self.nodes[y.index()]);
                    tell(self, x.index(), either);
                    tell(self, y.index(), either);
                }
                Node::Call(function, x) => match function {
                    Function::Sqrt => tell(self, x[0].index(), own.map(|power| 2.0 * power)),
                    Function::Cbrt => tell(self, x[0].index(), own.map(|power| 3.0 * power)),
                    Function::Abs => tell(self, x[0].index(), own),
                    Function::Min | Function::Max | Function::Hypot => {
                        x.iter().for_each(|x| tell(self, x.index(), own));
                    }
                    Function::Atan2 => {
                        let either = x.iter().find_map(|x| self.nodes[x.index()]);
                        x.iter().for_each(|x| tell(self, x.index(), either));
                    }
                    Function::Powf | Function::Signum => {}
                    _ => x.iter().for_each(|x| tell(self, x.index(), Some(0.0))),
                },
                _ => {}
            }
        }
    }

    /// Infers the exponent of one factor of a product from the product and the other factor.
    fn factor(&mut self, own: Option<f64>, operands: [usize; 2]) {
        let Some(own) = own else { return };
        match operands.map(|operand| self.nodes[operand]) {
            [None, None] if operands[0] == operands[1] => self.nodes[operands[0]] = Some(own / 2.0),
            [None, Some(other)] => self.nodes[operands[0]] = Some(own - other),
            [Some(other), None] => self.nodes[operands[1]] = Some(own - other),
            _ => {}
        }
    }
}
