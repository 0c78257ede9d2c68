//! A scalar program as a list of operations on doubles, with running bounds on their rounding errors.
//!
//! In: a program and the wanted outputs. Out: their values, or values with error bounds: a first-order
//! analysis of every addition, multiplication, division and call, from given errors of the inputs. The bounds
//! are valid for any order of the terms of a sum and of the factors of a product.

use crate::derive::partials::partial;
use crate::math::exact::Exact;
use crate::math::functions::{Function, Operator};
use crate::math::number::Comparison;
use crate::math::special;
use crate::model::bodies::{Domain, Parameter, ParameterType, Signature};
use crate::sample::inputs::Places;
use crate::scalar::{Id, Node, Program};
use crate::vector::Graph;
use crate::verify::source::Source;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Half the distance from 1 to the next double.
const UNIT: f64 = f64::EPSILON / 2.0;

/// A double with a bound on its distance to the exact value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounded {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// A value in doubled precision, high + low.
#[derive(Clone, Copy, Debug)]
struct Pair {
    high: f64,
    low: f64,
    /// A bound on the distance to the exact value.
    error: f64,
    /// A bound on |high|, such that UNIT · scale bounds |low|.
    scale: f64,
}

impl Pair {
    fn new(x: Bounded) -> Pair {
        Pair { high: x.value, low: 0.0, error: x.error, scale: x.value.abs() }
    }

    fn value(self) -> f64 {
        self.high + self.low
    }

    /// Rounds to a double.
    fn rounded(self) -> Bounded {
        let value = self.value();
        Bounded { value, error: self.error + UNIT * value.abs() }
    }

    /// The sum of pairs: the loss of each addition of highs is computed exactly, only lows are rounded.
    fn sum(pairs: &[Pair]) -> Pair {
        let (mut high, mut low, mut error, mut scale) = (0.0f64, 0.0, 0.0, 0.0);
        for pair in pairs {
            let sum = high + pair.high;
            let second = sum - high;
            low += ((high - (sum - second)) + (pair.high - second)) + pair.low;
            high = sum;
            error += pair.error;
            scale += pair.scale;
        }
        let count = pairs.len() as f64;
        // Two terms are added in one order only, so the result bounds the sizes of its parts.
        scale = if pairs.len() > 2 { scale * (count + 1.0) } else { 2.0 * high.abs().max(low.abs() / UNIT) };
        Pair { high, low, error: error + count * UNIT * UNIT * scale, scale }
    }

    fn product(self, other: Pair) -> Pair {
        let high = self.high * other.high;
        let low = self.high.mul_add(other.high, -high) + (self.high * other.low + self.low * other.high);
        let scale = 3.0 * self.scale * other.scale;
        let (x, y) = (self.value().abs(), other.value().abs());
        let through = x * other.error + y * self.error + self.error * other.error;
        let underflow = if scale == 0.0 { 0.0 } else { 4.0 * f64::MIN_POSITIVE };
        Pair { high, low, error: through + 4.0 * UNIT * UNIT * scale + underflow, scale }
    }

    /// Normalised, so that the low is below the rounding of the high.
    fn normal(self) -> Pair {
        let high = self.high + self.low;
        let second = high - self.high;
        let low = (self.high - (high - second)) + (self.low - second);
        Pair { high, low, scale: high.abs(), ..self }
    }

    fn recip(self) -> Pair {
        let x = self.normal();
        let high = 1.0 / x.high;
        let low = high * ((-high).mul_add(x.high, 1.0) - high * x.low);
        let least = x.high.abs() - x.error;
        let through = if least > 0.0 { x.error / (x.high.abs() * least) } else { f64::INFINITY };
        let scale = 3.0 * high.abs();
        Pair { high, low, error: through + 8.0 * UNIT * UNIT * scale + f64::MIN_POSITIVE, scale }
    }

    fn sqrt(self) -> Pair {
        let x = self.normal();
        let high = x.high.sqrt();
        let low = ((-high).mul_add(high, x.high) + x.low) / (2.0 * high);
        let through = if x.high > x.error { x.error / (x.high - x.error).sqrt() } else { f64::INFINITY };
        let scale = 3.0 * high;
        Pair { high, low, error: through + 8.0 * UNIT * UNIT * scale + f64::MIN_POSITIVE, scale }
    }
}

struct Coefficient {
    value: f64,
    /// The part below the value's last digit, for doubled precision.
    low: f64,
    /// The relative error of rounding the coefficient to a double.
    inexact: f64,
    is_unit: bool,
}

impl Coefficient {
    fn new(exact: &Exact) -> Coefficient {
        let value = exact.to_f64();
        let inexact = if Exact::from_f64(value).as_ref() == Some(exact) { 0.0 } else { UNIT };
        let rest = Exact::from_f64(value).filter(|_| exact.whole().is_some());
        let low = rest.map_or(0.0, |rounded| (exact - &rounded).to_f64());
        Coefficient { value, low, inexact, is_unit: exact.is_unit() }
    }

    /// The double that a kernel uses outside of products.
    fn rounded(&self) -> Pair {
        Pair::new(Bounded { value: self.value, error: self.inexact * self.value.abs() })
    }

    /// The pair that a kernel uses in doubled precision.
    fn pair(&self) -> Pair {
        let (size, known) = (self.value.abs(), self.low != 0.0);
        let error = if known { 16.0 * UNIT * UNIT * size } else { self.inexact * size };
        Pair { high: self.value, low: self.low, error, scale: size }
    }
}

enum Operation {
    Constant(Coefficient),
    Input(usize),
    Difference(usize, usize),
    /// An input and a number.
    Offset(usize, Coefficient),
    Sum(Coefficient, Vec<(Coefficient, usize)>),
    Product(Vec<(usize, u32)>),
    Recip(usize),
    Quotient(usize, usize),
    Call(Function, Vec<usize>),
    Select(usize, usize, usize),
    Known(bool),
    Compare(Comparison, usize, usize),
    And(usize, usize),
    Or(usize, usize),
    Not(usize),
}

impl Operation {
    fn signed_sum(x: usize, sign: &Exact, y: usize) -> Operation {
        let terms = vec![(Coefficient::new(&Exact::ONE), x), (Coefficient::new(sign), y)];
        Operation::Sum(Coefficient::new(&Exact::ZERO), terms)
    }
}

/// The results of running a program in doubles.
pub(crate) struct Run {
    pub(crate) outputs: Vec<f64>,
    /// A hash of the outcomes of all conditions and branching functions.
    pub(crate) choices: u64,
    /// The arguments of every sine, cosine and tangent, in radians.
    pub(crate) phases: Vec<f64>,
}

/// The operations that the wanted outputs depend on.
pub(crate) struct Tape {
    operations: Vec<Operation>,
    /// The operations computed in doubled precision.
    doubled: Vec<bool>,
    outputs: Vec<usize>,
    partials: BTreeMap<Function, Partials>,
}

impl Tape {
    /// Collects the operations of these outputs.
    pub(crate) fn new(program: &Program, layout: &Places, outputs: &[Id]) -> Tape {
        let mut live = vec![false; program.graph.len()];
        for output in outputs {
            live[output.index()] = true;
        }
        let nodes: Vec<(Id, &Node)> = program.graph.iter().collect();
        for (id, node) in nodes.iter().rev() {
            if live[id.index()] {
                for operand in node.operands() {
                    live[operand.index()] = true;
                }
            }
        }
        let mut places = vec![usize::MAX; nodes.len()];
        let mut tape = Tape {
            operations: Vec::new(),
            doubled: Vec::new(),
            outputs: Vec::new(),
            partials: BTreeMap::new(),
        };
        for (id, node) in nodes.into_iter().filter(|(id, _)| live[id.index()]) {
            let at = |id: &Id| places[id.index()];
            let operation = match node {
                Node::Constant(value) => Operation::Constant(Coefficient::new(value)),
                Node::Input(slot) => Operation::Input(layout.place(*slot)),
                Node::Difference(a, b) => Operation::Difference(layout.place(*a), layout.place(*b)),
                Node::Offset(a, number) => Operation::Offset(layout.place(*a), Coefficient::new(number)),
                Node::Sum(constant, terms) => Operation::Sum(
                    Coefficient::new(constant),
                    terms.iter().map(|(c, x)| (Coefficient::new(c), at(x))).collect(),
                ),
                Node::Product(factors) => {
                    Operation::Product(factors.iter().map(|(x, n)| (at(x), *n)).collect())
                }
                Node::Multiple(c, x) => {
                    Operation::Sum(Coefficient::new(&Exact::ZERO), vec![(Coefficient::new(c), at(x))])
                }
                Node::Held(x) => Operation::Product(vec![(at(x), 1)]),
                Node::Written(operator, x, y) => match operator {
                    Operator::Add => Operation::signed_sum(at(x), &Exact::ONE, at(y)),
                    Operator::Subtract => Operation::signed_sum(at(x), &-Exact::ONE, at(y)),
                    Operator::Multiply => Operation::Product(vec![(at(x), 1), (at(y), 1)]),
                    Operator::Divide => Operation::Quotient(at(x), at(y)),
                },
                Node::Recip(x) => Operation::Recip(at(x)),
                Node::Call(function, x) => {
                    tape.partials.entry(*function).or_insert_with(|| Partials::new(*function));
                    Operation::Call(*function, x.iter().map(at).collect())
                }
                Node::Select(c, x, y) => Operation::Select(at(c), at(x), at(y)),
                Node::Known(truth) => Operation::Known(*truth),
                Node::Compare(comparison, x, y) => Operation::Compare(*comparison, at(x), at(y)),
                Node::And(a, b) => Operation::And(at(a), at(b)),
                Node::Or(a, b) => Operation::Or(at(a), at(b)),
                Node::Not(a) => Operation::Not(at(a)),
            };
            places[id.index()] = tape.operations.len();
            tape.operations.push(operation);
            tape.doubled.push(program.graph.is_doubled(id));
        }
        tape.outputs = outputs.iter().map(|id| places[id.index()]).collect();
        tape
    }

    /// The outputs in doubles, with the branches taken.
    pub(crate) fn values(&self, inputs: &[f64]) -> Run {
        let mut v: Vec<f64> = Vec::with_capacity(self.operations.len());
        let mut pairs: BTreeMap<usize, Pair> = BTreeMap::new();
        let mut choices = 0xcbf2_9ce4_8422_2325u64;
        let mut phases = Vec::new();
        let truth = |x: bool| if x { 1.0 } else { 0.0 };
        for (index, operation) in self.operations.iter().enumerate() {
            if self.doubled[index] {
                let pair = doubled_precision(
                    operation,
                    &|x| Bounded { value: v[x], error: 0.0 },
                    &pairs,
                    inputs,
                    None,
                );
                pairs.insert(index, pair);
                v.push(pair.value());
                continue;
            }
            let value = match operation {
                Operation::Constant(c) => c.value,
                Operation::Input(at) => inputs[*at],
                Operation::Difference(a, b) => inputs[*a] - inputs[*b],
                Operation::Offset(at, number) => inputs[*at] + number.value,
                Operation::Sum(constant, terms) => {
                    terms.iter().fold(constant.value, |sum, (c, x)| sum + c.value * v[*x])
                }
                Operation::Product(factors) => factors
                    .iter()
                    .fold(1.0, |product, (x, n)| (0..*n).fold(product, |product, _| product * v[*x])),
                Operation::Recip(x) => 1.0 / v[*x],
                Operation::Quotient(x, y) => v[*x] / v[*y],
                Operation::Call(function, x) => {
                    let x: Vec<f64> = x.iter().map(|x| v[*x]).collect();
                    let choice = match function {
                        Function::Abs | Function::Signum => Some(x[0] < 0.0),
                        Function::Min | Function::Max => Some(x[0] < x[1]),
                        _ => None,
                    };
                    if let Some(choice) = choice {
                        choices = (choices ^ u64::from(choice)).wrapping_mul(0x0100_0000_01b3);
                    }
                    phases.extend(phase(*function, &x));
                    (function.row().value)(&x)
                }
                Operation::Select(c, x, y) => v[if v[*c] != 0.0 { *x } else { *y }],
                Operation::Known(known) => truth(*known),
                Operation::Compare(comparison, x, y) => {
                    let holds = holds(*comparison, v[*x], v[*y]);
                    choices = (choices ^ u64::from(holds)).wrapping_mul(0x0100_0000_01b3);
                    truth(holds)
                }
                Operation::And(a, b) => v[*a].min(v[*b]),
                Operation::Or(a, b) => v[*a].max(v[*b]),
                Operation::Not(a) => 1.0 - v[*a],
            };
            v.push(value);
        }
        Run { outputs: self.outputs.iter().map(|at| v[*at]).collect(), choices, phases }
    }

    /// The outputs with error bounds, for inputs with these errors.
    pub(crate) fn bounds(&self, inputs: &[f64], errors: &[f64]) -> Vec<Bounded> {
        let mut v: Vec<Bounded> = Vec::with_capacity(self.operations.len());
        // The pairs of doubled operations; `v` contains their rounded values.
        let mut pairs: BTreeMap<usize, Pair> = BTreeMap::new();
        for (index, (operation, doubled)) in self.operations.iter().zip(&self.doubled).enumerate() {
            let mut bounded = if *doubled {
                let pair = doubled_precision(operation, &|x| v[x], &pairs, inputs, Some(errors));
                pairs.insert(index, pair);
                pair.rounded()
            } else {
                self.bounded(operation, &v, inputs, errors)
            };
            if bounded.error.is_nan() {
                bounded.error = f64::INFINITY;
            }
            v.push(bounded);
        }
        self.outputs.iter().map(|at| v[*at]).collect()
    }

    fn bounded(&self, operation: &Operation, v: &[Bounded], inputs: &[f64], errors: &[f64]) -> Bounded {
        let truth = |value: bool, certain: bool| Bounded {
            value: if value { 1.0 } else { 0.0 },
            error: if certain { 0.0 } else { 1.0 },
        };
        match operation {
            Operation::Constant(c) => Bounded { value: c.value, error: c.inexact * c.value.abs() },
            Operation::Input(at) => Bounded { value: inputs[*at], error: errors[*at] },
            Operation::Difference(a, b) => {
                let value = inputs[*a] - inputs[*b];
                Bounded { value, error: errors[*a] + errors[*b] + UNIT * value.abs() }
            }
            Operation::Offset(at, number) => {
                let value = inputs[*at] + number.value;
                let error = errors[*at] + number.inexact * number.value.abs() + UNIT * value.abs();
                Bounded { value, error }
            }
            Operation::Sum(constant, terms) => sum(constant, terms, v),
            Operation::Product(factors) => {
                let mut product: Option<Bounded> = None;
                for (x, n) in factors {
                    for _ in 0..*n {
                        product = Some(product.map_or(v[*x], |product| multiply(product, v[*x])));
                    }
                }
                product.unwrap_or(Bounded { value: 1.0, error: 0.0 })
            }
            // (x + e)/(y + d) − x/y = (e − d x/y)/(y + d)
            Operation::Quotient(x, y) => {
                let (x, y) = (v[*x], v[*y]);
                let value = x.value / y.value;
                let least = y.value.abs() - y.error;
                let through =
                    if least > 0.0 { (x.error + y.error * value.abs()) / least } else { f64::INFINITY };
                Bounded { value, error: through * 1.001 + UNIT * value.abs() + f64::MIN_POSITIVE }
            }
            Operation::Recip(x) => {
                let (x, value) = (v[*x], 1.0 / v[*x].value);
                let least = x.value.abs() - x.error;
                let through = if least > 0.0 { x.error / (x.value.abs() * least) } else { f64::INFINITY };
                Bounded { value, error: through + UNIT * value.abs() + f64::MIN_POSITIVE }
            }
            Operation::Call(function, x) => {
                let x: Vec<Bounded> = x.iter().map(|x| v[*x]).collect();
                let values: Vec<f64> = x.iter().map(|x| x.value).collect();
                let value = (function.row().value)(&values);
                let through = self.partials.get(function).map_or(f64::INFINITY, |p| p.through(&x));
                Bounded { value, error: through + rounding(*function) * value.abs() }
            }
            Operation::Select(c, x, y) => {
                let (condition, x, y) = (v[*c], v[*x], v[*y]);
                let chosen = if condition.value != 0.0 { x } else { y };
                if condition.error == 0.0 {
                    return chosen;
                }
                let apart = (x.value - y.value).abs();
                Bounded { value: chosen.value, error: apart + x.error.max(y.error) }
            }
            Operation::Known(known) => truth(*known, true),
            Operation::Compare(comparison, x, y) => {
                let (x, y) = (v[*x], v[*y]);
                let certain =
                    (x.value - y.value).abs() > x.error + y.error || (x.error == 0.0 && y.error == 0.0);
                truth(holds(*comparison, x.value, y.value), certain)
            }
            Operation::And(a, b) => {
                let (a, b) = (v[*a], v[*b]);
                let decided = [a, b].iter().any(|x| x.value == 0.0 && x.error == 0.0);
                truth(a.value != 0.0 && b.value != 0.0, decided || a.error + b.error == 0.0)
            }
            Operation::Or(a, b) => {
                let (a, b) = (v[*a], v[*b]);
                let decided = [a, b].iter().any(|x| x.value != 0.0 && x.error == 0.0);
                truth(a.value != 0.0 || b.value != 0.0, decided || a.error + b.error == 0.0)
            }
            Operation::Not(a) => Bounded { value: 1.0 - v[*a].value, error: v[*a].error },
        }
    }
}

/// An operation in doubled precision.
fn doubled_precision(
    operation: &Operation,
    v: &dyn Fn(usize) -> Bounded,
    pairs: &BTreeMap<usize, Pair>,
    inputs: &[f64],
    errors: Option<&[f64]>,
) -> Pair {
    let at = |x: &usize| pairs.get(x).copied().unwrap_or_else(|| Pair::new(v(*x)));
    let error = |at: usize| errors.map_or(0.0, |errors| errors[at]);
    match operation {
        Operation::Difference(a, b) => Pair::sum(&[
            Pair::new(Bounded { value: inputs[*a], error: error(*a) }),
            Pair::new(Bounded { value: -inputs[*b], error: error(*b) }),
        ]),
        Operation::Offset(at, number) => {
            Pair::sum(&[Pair::new(Bounded { value: inputs[*at], error: error(*at) }), number.rounded()])
        }
        Operation::Sum(constant, terms) => {
            let scaled = |(c, x): &(Coefficient, usize)| {
                if c.is_unit {
                    let x = at(x);
                    return Pair { high: c.value * x.high, low: c.value * x.low, ..x };
                }
                c.pair().product(at(x))
            };
            let constant = (constant.value != 0.0).then(|| constant.rounded());
            let terms: Vec<Pair> = terms.iter().map(scaled).chain(constant).collect();
            if let [term] = terms.as_slice() { *term } else { Pair::sum(&terms) }
        }
        Operation::Product(factors) => {
            let mut all = factors.iter().flat_map(|(x, n)| std::iter::repeat_n(at(x), *n as usize));
            let first = all.next().expect("a product has factors");
            all.fold(first, Pair::product)
        }
        Operation::Recip(x) => at(x).recip(),
        Operation::Quotient(x, y) => at(x).product(at(y).recip()),
        Operation::Call(_, x) => at(&x[0]).sqrt(),
        Operation::Select(c, x, y) => {
            let (condition, x, y) = (v(*c), at(x), at(y));
            let chosen = if condition.value != 0.0 { x } else { y };
            if condition.error == 0.0 {
                return chosen;
            }
            let apart = (x.value() - y.value()).abs();
            Pair { error: apart + x.error.max(y.error), ..chosen }
        }
        _ => unreachable!("only sums, products, quotients, roots and selections are doubled"),
    }
}

/// The phase of a periodic function.
fn phase(function: Function, x: &[f64]) -> Option<f64> {
    match function {
        Function::Sin | Function::Cos | Function::Tan | Function::Sinc(_) => Some(x[0]),
        Function::CosSqrt(_) => Some(x[0].max(0.0).sqrt()),
        _ => None,
    }
}

/// A bound on the change of a periodic function if its argument changes by `error`. `ends`, the bound from
/// the ends of the interval, is too small if they are a large part of a period apart.
fn over_a_period(function: Function, x: &[Bounded], ends: f64) -> f64 {
    let Bounded { value, error } = x[0];
    match function {
        // |f″| ≤ 1 and |f| ≤ 1.
        Function::Sin | Function::Cos => (ends + error * error).min(error).min(2.0),
        // A pole lies between the ends.
        Function::Tan if error >= FRAC_PI_2 || (value - error).tan() > (value + error).tan() => f64::INFINITY,
        // Every order is largest at zero.
        Function::CosSqrt(n) if (value + error).max(0.0).sqrt() - (value - error).max(0.0).sqrt() > 0.1 => {
            let largest = special::cos_sqrt_series(u32::from(n) + 1, 1)[0].to_f64().abs();
            ends.max(largest * error)
        }
        Function::Sinc(n) if error > 0.1 => ends.max(error / f64::from(n + 2)),
        _ => ends,
    }
}

fn holds(comparison: Comparison, x: f64, y: f64) -> bool {
    match comparison {
        Comparison::Less => x < y,
        Comparison::LessEqual => x <= y,
        Comparison::Equal => x == y,
    }
}

/// Every product and coefficient rounds once; each of n additions, in any order, by at most the sum of sizes.
fn sum(constant: &Coefficient, terms: &[(Coefficient, usize)], v: &[Bounded]) -> Bounded {
    let (mut value, mut size) = (constant.value, constant.value.abs());
    let mut error = constant.inexact * size;
    for (c, x) in terms {
        let term = c.value * v[*x].value;
        let rounded = if c.is_unit { 0.0 } else { UNIT };
        value += term;
        size += term.abs();
        error += c.value.abs() * v[*x].error + (c.inexact + rounded) * term.abs();
    }
    let additions = terms.len() + usize::from(constant.value != 0.0) - 1;
    error += match additions {
        0 => 0.0,
        1 => UNIT * value.abs(),
        n => UNIT * (n - 1) as f64 * size + UNIT * value.abs(),
    };
    Bounded { value, error }
}

fn multiply(x: Bounded, y: Bounded) -> Bounded {
    let value = x.value * y.value;
    let through = x.value.abs() * y.error + y.value.abs() * x.error + x.error * y.error;
    let underflow = if value.abs() < f64::MIN_POSITIVE && value != 0.0 { f64::MIN_POSITIVE } else { 0.0 };
    Bounded { value, error: through + UNIT * value.abs() + underflow }
}

/// The relative error of a function's value.
fn rounding(function: Function) -> f64 {
    match function {
        Function::CosSqrt(n) | Function::AngleRatio(n) | Function::Sinc(n) => {
            UNIT * f64::from(16 + 16 * u32::from(n))
        }
        _ => UNIT * function.units(),
    }
}

/// The partial derivatives of a function of the table.
struct Partials {
    function: Function,
    layout: Places,
    graph: Graph,
    derivatives: Vec<usize>,
}

impl Partials {
    fn new(function: Function) -> Partials {
        let row = function.row();
        let parameter = |k| Parameter {
            name: format!("x{k}"),
            ty: ParameterType::Real,
            domain: Domain::Any,
            value: None,
        };
        let signature =
            Signature { parameters: (0..row.arity).map(parameter).collect(), ..Signature::default() };
        let mut graph = Graph::new(signature.clone());
        let x: Vec<_> = (0..row.arity).map(|k| graph.entry(signature.parameter_slot(k, 0))).collect();
        let result = graph.call(function, &x);
        let derivatives =
            (0..row.arity).map(|k| partial(&mut graph, function, &x, result, k).index()).collect();
        Partials { function, layout: Places::new(&signature), graph, derivatives }
    }

    /// Σ |∂f/∂xₖ| · error of xₖ, the maximum over the ends of the arguments' intervals; for periodic
    /// functions, the maximum within the intervals.
    fn through(&self, x: &[Bounded]) -> f64 {
        if x.iter().all(|x| x.error == 0.0) {
            return 0.0;
        }
        if self.function == Function::Signum {
            return if x[0].value.abs() > x[0].error { 0.0 } else { 2.0 };
        }
        let source: Source<f64> = Source::new(&self.graph, &self.layout, self.derivatives.iter().copied());
        let mut worst = 0.0f64;
        for corner in 0..1u32 << x.len() {
            let point: Vec<f64> = x
                .iter()
                .enumerate()
                .map(|(k, x)| if corner >> k & 1 == 0 { x.value - x.error } else { x.value + x.error })
                .collect();
            let values = source.evaluate(&point);
            let mut change = 0.0;
            for (k, x) in x.iter().enumerate().filter(|(_, x)| x.error != 0.0) {
                change += source.get(&values, self.derivatives[k]).real().abs() * x.error;
            }
            worst = if f64::is_nan(change) { f64::INFINITY } else { worst.max(change) };
        }
        over_a_period(self.function, x, worst)
    }
}

#[cfg(test)]
mod tests {
    use super::super::big::Big;
    use super::*;
    use crate::math::functions::FunctionDomain;
    use crate::math::number::Arithmetic;
    use crate::math::random::Random;

    /// Measures the errors of functions against the stated bounds.
    #[test]
    fn functions_are_as_near_as_stated() {
        let mut random = Random::new(5);
        for function in Function::ALL {
            let row = function.row();
            for _ in 0..60 {
                let size = random.decades(-6, 1);
                let x: Vec<f64> = (0..row.arity)
                    .map(|k| match row.domain {
                        FunctionDomain::Unit | FunctionDomain::Inside => random.uniform(-1.0, 1.0),
                        FunctionDomain::AtLeast(low) | FunctionDomain::Above(low) => {
                            low + random.uniform(0.0, 1.0) * size
                        }
                        FunctionDomain::All => random.uniform(-size, size),
                        FunctionDomain::NotAllZero => random.uniform(-size, size),
                        FunctionDomain::HalfPlane if k == 1 => random.uniform(-2.0, 2.0),
                        _ => random.uniform(0.0, 1.0) * size,
                    })
                    .collect();
                let value = (row.value)(&x);
                let wide: Vec<Big> = x.iter().map(|x| Big::from_f64(*x)).collect();
                let error = (Big::call(function, &wide) - Big::from_f64(value)).to_f64().abs();
                let stated = rounding(function) * value.abs();
                assert!(
                    error <= stated,
                    "{function:?}({x:?}) = {value}: {} units",
                    error / (UNIT * value.abs())
                );
            }
        }
    }
}
