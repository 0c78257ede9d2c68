//! Interval analysis: bounds of every real of a graph, derived from the stated domains of parameters.
//!
//! In: a graph. Out: an interval for every node, in one loop, operands before users. Promise: a node's value
//! lies in its interval wherever the value is defined; the bounds are not tight and ignore rounding.

use crate::math::functions::Function;
use crate::model::bodies::{Domain, Role, Slot};
use crate::vector::{Graph, Node, Real, Vector};

/// A closed interval, possibly without 0.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Interval {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether 0 is excluded, whatever the bounds are.
    pub(crate) nonzero: bool,
}

impl Interval {
    pub(crate) const ALL: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY, nonzero: false };

    pub(crate) fn new(low: f64, high: f64) -> Interval {
        let low = if low.is_nan() { f64::NEG_INFINITY } else { low };
        let high = if high.is_nan() { f64::INFINITY } else { high };
        Interval { low, high, nonzero: low > 0.0 || high < 0.0 }
    }

    fn point(value: f64) -> Interval {
        Interval::new(value, value)
    }

    fn except_zero(self, nonzero: bool) -> Interval {
        Interval { nonzero: self.nonzero || nonzero, ..self }
    }

    pub(crate) fn contains_zero(self) -> bool {
        self.low <= 0.0 && self.high >= 0.0 && !self.nonzero
    }

    /// The intersection.
    pub(crate) fn and(self, other: Interval) -> Interval {
        let interval = Interval::new(self.low.max(other.low), self.high.min(other.high));
        interval.except_zero(self.nonzero || other.nonzero)
    }

    fn or(self, other: Interval) -> Interval {
        let interval = Interval::new(self.low.min(other.low), self.high.max(other.high));
        Interval { nonzero: interval.nonzero || self.nonzero && other.nonzero, ..interval }
    }

    fn add(self, other: Interval) -> Interval {
        let interval = Interval::new(self.low + other.low, self.high + other.high);
        let positive = self.low >= 0.0 && other.low >= 0.0;
        let negative = self.high <= 0.0 && other.high <= 0.0;
        interval.except_zero((positive || negative) && (self.nonzero || other.nonzero))
    }

    fn mul(self, other: Interval) -> Interval {
        let times = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let products = [
            times(self.low, other.low),
            times(self.low, other.high),
            times(self.high, other.low),
            times(self.high, other.high),
        ];
        let low = products.iter().copied().fold(f64::INFINITY, f64::min);
        let high = products.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Interval::new(low, high).except_zero(self.nonzero && other.nonzero)
    }

    fn recip(self) -> Interval {
        if self.low < 0.0 && self.high > 0.0 || self.low == 0.0 && self.high == 0.0 {
            return Interval { nonzero: true, ..Interval::ALL };
        }
        let low = if self.high == 0.0 { f64::NEG_INFINITY } else { 1.0 / self.high };
        let high = if self.low == 0.0 { f64::INFINITY } else { 1.0 / self.low };
        Interval::new(low, high).except_zero(true)
    }

    fn abs(self) -> Interval {
        let high = self.low.abs().max(self.high.abs());
        let low = if self.low > 0.0 {
            self.low
        } else if self.high < 0.0 {
            -self.high
        } else {
            0.0
        };
        Interval::new(low, high).except_zero(self.nonzero)
    }

    fn powi(self, n: i32) -> Interval {
        if n < 0 {
            return self.powi(n.saturating_neg()).recip();
        }
        let base = if n % 2 == 0 { self.abs() } else { self };
        let power = |x: f64| x.powi(n);
        if n == 0 {
            return Interval::point(1.0);
        }
        Interval::new(power(base.low), power(base.high)).except_zero(self.nonzero)
    }

    fn monotone(self, f: impl Fn(f64) -> f64) -> Interval {
        Interval::new(f(self.low), f(self.high))
    }
}

/// The interval of every node (for a vector: of its length), and of every entry of a vector.
pub(crate) struct Ranges {
    reals: Vec<Interval>,
    entries: Vec<Option<[Interval; 3]>>,
}

impl Ranges {
    pub(crate) fn of(&self, real: Real) -> Interval {
        self.reals[real.index()]
    }

    fn entries(&self, v: Vector) -> [Interval; 3] {
        self.entries[v.index()].unwrap_or([Interval::ALL; 3])
    }
}

/// Computes the ranges of all nodes.
pub(crate) fn analyse(graph: &Graph) -> Ranges {
    let mut ranges =
        Ranges { reals: Vec::with_capacity(graph.len()), entries: Vec::with_capacity(graph.len()) };
    for node in graph.nodes() {
        match vector(graph, &ranges, node) {
            Some((length, entries)) => {
                ranges.reals.push(length);
                ranges.entries.push(Some(entries));
            }
            None => {
                let interval = real(graph, &ranges, node);
                ranges.reals.push(interval);
                ranges.entries.push(None);
            }
        }
    }
    ranges
}

/// Stated range of an entry, and whether its argument has unit length.
fn stated(graph: &Graph, slot: Slot) -> (Interval, bool) {
    let unit = (Interval::new(-1.0, 1.0), true);
    match (graph.signature.role(slot), graph.signature.parameter(slot)) {
        (Some(Role::Orientation), _) => unit,
        (Some(role), _) => match graph.signature.scale.field(slot.argument as usize, role) {
            Some((low, high)) => (Interval::new(low, high), false),
            None => (Interval::ALL, false),
        },
        (_, Some(parameter)) => match parameter.domain {
            Domain::Range(low, high) => (Interval::new(low, high), false),
            Domain::Unit => unit,
            Domain::Any if innermost_is_quaternion(&parameter.ty) => unit,
            Domain::Any => (Interval::ALL, false),
        },
        _ => (Interval::ALL, false),
    }
}

fn innermost_is_quaternion(ty: &crate::model::bodies::ParameterType) -> bool {
    match ty {
        crate::model::bodies::ParameterType::Array(_, element) => innermost_is_quaternion(element),
        ty => *ty == crate::model::bodies::ParameterType::Quaternion,
    }
}

/// √(x² + y² + z²)
fn length(entries: [Interval; 3]) -> Interval {
    let square = entries.map(|entry| entry.powi(2));
    square[0].add(square[1]).add(square[2]).monotone(f64::sqrt).except_zero(entries.iter().any(|e| e.nonzero))
}

fn within(length: Interval) -> [Interval; 3] {
    [Interval::new(-length.high, length.high); 3]
}

fn vector(graph: &Graph, ranges: &Ranges, node: &Node) -> Option<(Interval, [Interval; 3])> {
    let norm = |v: Vector| ranges.reals[v.index()];
    Some(match node {
        Node::Triple(slot) => {
            let (entry, unit) = stated(graph, *slot);
            let quaternion = graph.signature.role(*slot) == Some(Role::Orientation)
                || graph.signature.parameter(*slot).is_some_and(|p| innermost_is_quaternion(&p.ty));
            let most = Interval::new(0.0, 1.0);
            let length = match (unit, quaternion) {
                (true, false) => Interval::point(1.0),
                // Three of the four entries of a unit quaternion.
                (true, true) => most,
                _ => length([entry; 3]),
            };
            let entries = [0, 1, 2].map(|k| {
                let known = graph.signature.known(Slot { offset: slot.offset + k, ..*slot });
                known.map_or(entry, |value| Interval::point(value.to_f64()))
            });
            (length, entries)
        }
        Node::TurnVector(_) => (Interval::new(0.0, 1.0), within(Interval::new(0.0, 1.0))),
        Node::Difference(..) => (length([Interval::ALL; 3]), [Interval::ALL; 3]),
        Node::VectorOffset(v, numbers) => {
            let entries = ranges.entries(*v);
            let moved = [0, 1, 2].map(|k| entries[k].add(Interval::point(numbers[k].to_f64())));
            (length(moved), moved)
        }
        Node::VectorSum(terms) => {
            let mut sum = [Interval::point(0.0); 3];
            for (c, v) in terms {
                let c = Interval::point(c.to_f64());
                let entries = ranges.entries(*v);
                sum = std::array::from_fn(|k| sum[k].add(c.mul(entries[k])));
            }
            match terms.as_ref() {
                [(c, v)] => (norm(*v).mul(Interval::point(c.to_f64().abs())), sum),
                _ => {
                    let most = terms.iter().map(|(c, v)| c.to_f64().abs() * norm(*v).high).sum();
                    let least = length(sum);
                    (least.and(Interval::new(0.0, most)).except_zero(least.nonzero), sum)
                }
            }
        }
        // v/|v|
        Node::Scale(s, v) if is_reciprocal_length(graph, *s, *v) => {
            (Interval::point(1.0), within(Interval::point(1.0)))
        }
        Node::Scale(s, v) => {
            let s = ranges.of(*s);
            (s.abs().mul(norm(*v)), ranges.entries(*v).map(|entry| s.mul(entry)))
        }
        Node::Cross(u, v) => {
            let length = Interval::new(0.0, norm(*u).high * norm(*v).high);
            (length, within(length))
        }
        Node::Rotate(_, _, v) => (norm(*v), within(norm(*v))),
        Node::Pack(entries) => {
            let entries = entries.map(|entry| ranges.of(entry));
            (length(entries), entries)
        }
        Node::VectorSelect(_, u, v) => {
            let (u_entries, v_entries) = (ranges.entries(*u), ranges.entries(*v));
            (norm(*u).or(norm(*v)), std::array::from_fn(|k| u_entries[k].or(v_entries[k])))
        }
        Node::VectorLet(v) => (norm(*v), ranges.entries(*v)),
        _ => return None,
    })
}

fn is_reciprocal_length(graph: &Graph, s: Real, v: Vector) -> bool {
    let Node::Product(factors) = graph.node(s.index()) else { return false };
    let [(mut norm, -1)] = **factors else { return false };
    while let Node::Let(inner) = graph.node(norm.index()) {
        norm = *inner;
    }
    *graph.node(norm.index()) == Node::Norm(v)
}

fn real(graph: &Graph, ranges: &Ranges, node: &Node) -> Interval {
    let of = |real: &Real| ranges.of(*real);
    match node {
        Node::Constant(value) => Interval::point(value.to_f64()).except_zero(!value.is_zero()),
        Node::Entry(slot) => stated(graph, *slot).0,
        Node::TurnReal(_) => Interval::new(-1.0, 1.0),
        Node::Offset(x, number) => of(x).add(Interval::point(number.to_f64())),
        Node::Sum(constant, terms) => {
            let start = Interval::point(constant.to_f64()).except_zero(!constant.is_zero());
            terms.iter().fold(start, |sum, (c, term)| sum.add(of(term).mul(Interval::point(c.to_f64()))))
        }
        Node::Product(factors) => {
            factors.iter().fold(Interval::point(1.0), |product, (factor, n)| product.mul(of(factor).powi(*n)))
        }
        Node::Dot(u, v) => {
            let (a, b) = (ranges.reals[u.index()], ranges.reals[v.index()]);
            if u == v {
                return a.powi(2);
            }
            let most = a.high * b.high;
            let (x, y) = (ranges.entries(*u), ranges.entries(*v));
            let sum = (0..3).fold(Interval::point(0.0), |sum, k| sum.add(x[k].mul(y[k])));
            sum.and(Interval::new(-most, most))
        }
        Node::Component(v, axis) => ranges.entries(*v)[usize::from(*axis)],
        Node::Norm(v) => ranges.reals[v.index()],
        Node::Call(function, arguments) => {
            let arguments: Vec<Interval> = arguments.iter().map(of).collect();
            call(*function, &arguments)
        }
        Node::Select(_, x, y) => of(x).or(of(y)),
        Node::Let(x) => of(x),
        _ => Interval::ALL,
    }
}

fn call(function: Function, x: &[Interval]) -> Interval {
    use std::f64::consts::{FRAC_PI_2, PI};
    match function {
        Function::Pi => Interval::point(PI),
        Function::Abs => x[0].abs(),
        Function::Sqrt => {
            x[0].and(Interval::new(0.0, f64::INFINITY)).monotone(f64::sqrt).except_zero(x[0].nonzero)
        }
        Function::Cbrt => x[0].monotone(f64::cbrt).except_zero(x[0].nonzero),
        Function::Powf => Interval::new(0.0, f64::INFINITY).except_zero(x[0].nonzero),
        Function::Exp => x[0].monotone(f64::exp).except_zero(true),
        Function::Ln => x[0].and(Interval::new(0.0, f64::INFINITY)).monotone(f64::ln),
        Function::Ln1p => x[0].and(Interval::new(-1.0, f64::INFINITY)).monotone(f64::ln_1p),
        Function::ExpM1 => x[0].monotone(f64::exp_m1),
        Function::Sin => cosine(x[0].add(Interval::point(-FRAC_PI_2))).except_zero(
            // Strictly between 0 and π, or strictly between −π and 0.
            x[0].nonzero && (x[0].low >= 0.0 && x[0].high < PI || x[0].low > -PI && x[0].high <= 0.0),
        ),
        Function::Cos => cosine(x[0]),
        Function::Asin | Function::Atan => Interval::new(-FRAC_PI_2, FRAC_PI_2),
        Function::Acos => Interval::new(0.0, PI),
        Function::Atan2 if x[0].low >= 0.0 && x[1].low >= 0.0 => Interval::new(0.0, FRAC_PI_2),
        Function::Atan2 if x[0].low >= 0.0 => Interval::new(0.0, PI),
        Function::Atan2 => Interval::new(-PI, PI),
        Function::Sinh => x[0].monotone(f64::sinh).except_zero(x[0].nonzero),
        Function::Cosh => Interval::new(1.0, f64::INFINITY),
        Function::Tanh => x[0].monotone(f64::tanh).except_zero(x[0].nonzero),
        Function::Asinh(0) => {
            x[0].monotone(|x| (Function::Asinh(0).row().value)(&[x])).except_zero(x[0].nonzero)
        }
        Function::Acosh(0) | Function::LnCosh => Interval::new(0.0, f64::INFINITY),
        Function::Atanh(0) => Interval::ALL.except_zero(x[0].nonzero),
        Function::Asinh(1) | Function::Acosh(1) | Function::Atanh(1) => {
            Interval::new(0.0, f64::INFINITY).except_zero(true)
        }
        Function::Sinc(_) => Interval::new(-1.0, 1.0),
        Function::Erf => Interval::new(-1.0, 1.0).except_zero(x[0].nonzero),
        Function::Erfc => Interval::new(0.0, 2.0).except_zero(true),
        Function::ErfSlope => Interval::new(0.0, 1.13).except_zero(true),
        Function::Logistic | Function::LogisticSlope => Interval::new(0.0, 1.0).except_zero(true),
        Function::Softplus => Interval::new(x[0].low.max(0.0), f64::INFINITY).except_zero(true),
        Function::Hypot => length([x[0], x[1], Interval::point(0.0)]),
        Function::HypotSlope => Interval::new(-1.0, 1.0).except_zero(x[0].nonzero),
        Function::Min => least(x[0], x[1]),
        Function::Max => {
            let negative = |i: Interval| Interval { low: -i.high, high: -i.low, ..i };
            negative(least(negative(x[0]), negative(x[1])))
        }
        Function::Signum => Interval::new(-1.0, 1.0).except_zero(true),
        Function::Tan if x[0].low > -FRAC_PI_2 && x[0].high < FRAC_PI_2 => {
            x[0].monotone(f64::tan).except_zero(x[0].nonzero)
        }
        Function::CosSqrt(0) => cosine(x[0].and(Interval::new(0.0, f64::INFINITY)).monotone(f64::sqrt)),
        Function::Tan
        | Function::Asinh(_)
        | Function::Acosh(_)
        | Function::Atanh(_)
        | Function::CosSqrt(_)
        | Function::AngleRatio(_) => Interval::ALL,
    }
}

/// The range of the cosine over an interval, widened because the bounds are rounded.
fn cosine(x: Interval) -> Interval {
    use std::f64::consts::{PI, TAU};
    // Whether an angle start + 2πk lies in the interval.
    let meets = |start: f64| ((x.low - start) / TAU).ceil() * TAU + start <= x.high;
    let wide = !x.low.is_finite() || !x.high.is_finite() || x.high - x.low >= TAU || x.low.abs() > 1e6;
    if wide {
        return Interval::new(-1.0, 1.0);
    }
    let (first, last) = (x.low.cos(), x.high.cos());
    let low = if meets(PI) { -1.0 } else { (first.min(last) - 1e-9).max(-1.0) };
    let high = if meets(0.0) { 1.0 } else { (first.max(last) + 1e-9).min(1.0) };
    Interval::new(low, high)
}

fn least(x: Interval, y: Interval) -> Interval {
    let interval = Interval::new(x.low.min(y.low), x.high.min(y.high));
    Interval { nonzero: interval.nonzero || x.nonzero && y.nonzero, ..interval }
}
