//! Programs built by hand and at random, for the back end to print.

use forcec::internals::math::exact::Exact;
use forcec::internals::math::functions::Function;
use forcec::internals::math::number::Comparison;
use forcec::internals::model::bodies::{
    Body, BodyKind, Domain, Parameter, ParameterType, Role, Signature, Slot,
};
use forcec::internals::model::outputs::{Output, Part};
use forcec::internals::scalar::{Graph, Id, Program};

fn body(name: &str, kind: BodyKind) -> Body {
    Body { name: name.to_owned(), kind, fixed: false }
}

fn parameter(name: &str, ty: ParameterType) -> Parameter {
    Parameter { name: name.to_owned(), ty, domain: Domain::Any, value: None }
}

fn program(signature: Signature, graph: Graph, zero: Id) -> Program {
    Program::filled(signature, graph, &Part::DEFAULT, zero)
}

fn entry(argument: u16, field: u8, offset: u32) -> Slot {
    Slot { argument, field, offset }
}

/// Rows written by loops: ∂F/∂V of rank one, half of the matrix the negative of the other half, with factors
/// named like loop variables; ∂F/∂X with negated rows between other rows, and with zeros.
pub(crate) fn rows() -> Program {
    let signature = Signature {
        bodies: vec![body("a", BodyKind::PARTICLE), body("b", BodyKind::PARTICLE)],
        parameters: ["j", "x", "i"].map(|name| parameter(name, ParameterType::Real)).to_vec(),
        rows: 0,
        ..Signature::default()
    };
    let mut g = Graph::default();
    let mut p = program(signature, Graph::default(), g.zero());
    let factors = [2, 3, 4].map(|a| g.input(entry(a, 0, 0)));
    let shared = g.add(factors[0], factors[2]);
    let columns: [Id; 6] = std::array::from_fn(|j| {
        let velocity = g.input(entry(j as u16 / 3, 1, j as u32 % 3));
        let column = g.mul(velocity, shared);
        g.set_name(column, &format!("column_{j}"));
        column
    });
    for (i, factor) in factors.into_iter().enumerate() {
        for (j, column) in columns.into_iter().enumerate() {
            let product = g.mul(factor, column);
            let product = if (i == 1) == (j == 2) { product } else { g.neg(product) };
            p.set(Output::new(Part::Dfdv, i, j), product);
            p.set(Output::new(Part::Dfdv, i + 3, j), g.neg(product));
            let sum = g.add(factor, column);
            if i != j && j != 4 {
                let (row, negated) = if i == 2 { (5, 2) } else { (i, i + 3) };
                p.set(Output::new(Part::Dfdx, row, j), sum);
                p.set(Output::new(Part::Dfdx, negated, j), g.neg(sum));
            }
        }
    }
    p.graph = g;
    p
}

/// A damped spring between two particles, as an author would write it.
pub(crate) fn spring() -> Program {
    let signature = Signature {
        bodies: vec![body("a", BodyKind::PARTICLE), body("b", BodyKind::PARTICLE)],
        parameters: vec![
            parameter("rest_length", ParameterType::Real),
            parameter("stiffness", ParameterType::Real),
            parameter("damping", ParameterType::Real),
        ],
        rows: 0,
        ..Signature::default()
    };
    let mut g = Graph::default();
    let zero = g.zero();
    let d: [Id; 3] = std::array::from_fn(|i| g.difference(entry(1, 0, i as u32), entry(0, 0, i as u32)));
    let v: [Id; 3] = std::array::from_fn(|i| g.difference(entry(1, 1, i as u32), entry(0, 1, i as u32)));
    let [rest, stiffness, damping] = [2, 3, 4].map(|a| g.input(entry(a, 0, 0)));
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        g.set_name(d[i], &format!("d_{axis}"));
    }
    let squares: Vec<_> = d.iter().map(|x| g.mul(*x, *x)).map(|x| (Exact::ONE, x)).collect();
    let square = g.sum(Exact::ZERO, squares);
    let length = g.call(Function::Sqrt, &[square]);
    g.set_name(length, "length");
    let inverse = g.recip(length);
    let n = d.map(|x| g.mul(x, inverse));
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        g.set_name(n[i], &format!("n_{axis}"));
    }
    let terms: Vec<_> = (0..3).map(|i| (Exact::ONE, g.mul(n[i], v[i]))).collect();
    let rate = g.sum(Exact::ZERO, terms);
    g.set_name(rate, "rate");
    let stretch = g.sub(length, rest);
    let elastic = g.mul(stiffness, stretch);
    let viscous = g.mul(damping, rate);
    let tension = g.add(elastic, viscous);
    g.set_name(tension, "tension");
    let slope = g.mul(tension, inverse);
    let radial = g.sub(stiffness, slope);
    let mut p = program(signature, Graph::default(), zero);
    for i in 0..3 {
        let force = g.mul(tension, n[i]);
        p.set(Output::new(Part::Force, i, 0), force);
        p.set(Output::new(Part::Force, i + 3, 0), g.neg(force));
        for j in 0..3 {
            let outer = g.mul(n[i], n[j]);
            let mut k = g.mul(radial, outer);
            if i == j {
                k = g.add(k, slope);
            }
            let c = g.mul(damping, outer);
            for (r, s) in [(0, 0), (0, 3), (3, 0), (3, 3)] {
                p.set(Output::new(Part::Dfdx, i + r, j + s), if r == s { g.neg(k) } else { k });
                p.set(Output::new(Part::Dfdv, i + r, j + s), if r == s { g.neg(c) } else { c });
            }
        }
    }
    p.graph = g;
    p
}

/// The arguments of [`everything`] and of [`random`]: every type, names that collide.
fn wide_signature() -> Signature {
    let array = ParameterType::Array(2, Box::new(ParameterType::Matrix(2)));
    Signature {
        bodies: vec![body("out", BodyKind::RIGID), body("sin", BodyKind::PARTICLE)],
        parameters: vec![
            parameter("double", ParameterType::Real),
            parameter("axis", ParameterType::Vector(3)),
            parameter("frame", ParameterType::Matrix(3)),
            parameter("blocks", array),
            parameter("a_name_that_is_really_rather_long", ParameterType::Quaternion),
        ],
        rows: 0,
        ..Signature::default()
    }
}

/// Every kind of node and every function, selections, long sums, powers, names that collide.
pub(crate) fn everything() -> Program {
    let signature = wide_signature();
    let mut g = Graph::default();
    let zero = g.zero();
    let mut p = program(signature, Graph::default(), zero);
    let x = g.input(entry(2, 0, 0));
    let axis: [Id; 3] = std::array::from_fn(|i| g.input(entry(3, 0, i as u32)));
    let frame: [Id; 9] = std::array::from_fn(|i| g.input(entry(4, 0, i as u32)));
    let blocks: [Id; 8] = std::array::from_fn(|i| g.input(entry(5, 0, i as u32)));
    let long: [Id; 4] = std::array::from_fn(|i| g.input(entry(6, 0, i as u32)));
    let quarter = g.scaled(Exact::ratio(1, 4), x);
    let square = g.mul(quarter, quarter);
    let above = g.sum(Exact::ONE, vec![(Exact::ONE, square)]);
    let (mut outputs, mut products) = (Vec::new(), Vec::new());
    for function in Function::ALL {
        let y = if function == Function::Acos { axis[1] } else { axis[0] };
        let first = if matches!(function, Function::Acosh(_)) { above } else { quarter };
        let arguments = [first, y];
        let value = g.call(function, &arguments[..function.row().arity]);
        outputs.push(value);
        products.push((Exact::ONE, g.mul(value, axis[2])));
    }
    // A few at a time within products, because separate terms would take too much space.
    for few in products.chunks(4) {
        outputs.push(g.sum(Exact::ZERO, few.to_vec()));
    }
    // Long sums and products, cut into lines.
    let mut terms = Vec::new();
    for (i, a) in frame.iter().enumerate() {
        for b in &blocks {
            terms.push((Exact::ratio(if i % 2 == 0 { 1 } else { -2 }, 3), g.mul(*a, *b)));
        }
    }
    let sum = g.sum(Exact::ratio(-1, 7), terms);
    outputs.push(sum);
    let factors: Vec<_> = frame.iter().chain(&blocks).map(|x| (*x, 1)).collect();
    outputs.push(g.product(&factors));
    // Powers and divisions.
    for n in 2..20 {
        outputs.push(g.product(&[(axis[0], n)]));
    }
    let shifted = g.add(axis[0], long[3]);
    let inverse = g.recip(shifted);
    outputs.push(g.product(&[(inverse, 3), (long[0], 1)]));
    let other = g.add(axis[1], long[3]);
    let other = g.recip(other);
    outputs.push(g.product(&[(other, 1), (long[1], 1), (long[2], 1)]));
    outputs.push(other);
    let last = g.add(axis[2], long[2]);
    let last = g.recip(last);
    outputs.push(g.product(&[(last, 2), (long[1], 1)]));
    // Constants that a linter knows, huge and small ones.
    for text in
        ["3.14159", "0.6931471805599453", "1e300", "1e-300", "123456789.123456789", "0.1", "1e-9", "2e16"]
    {
        let value = Exact::parse(text).unwrap();
        outputs.push(g.scaled(value.clone(), x));
        outputs.push(g.constant(-value));
    }
    let two = g.constant(Exact::from(2));
    let root = g.call(Function::Sqrt, &[two]);
    outputs.push(g.mul(root, x));
    let minus = g.constant(Exact::from(-2));
    outputs.push(g.call(Function::Exp, &[minus]));
    let clamped = g.call(Function::Max, &[x, zero]);
    outputs.push(g.call(Function::Min, &[clamped, two]));
    // Conditions.
    let less = g.compare(Comparison::Less, x, axis[0]);
    let not_more = g.compare(Comparison::LessEqual, axis[1], x);
    let same = g.compare(Comparison::Equal, axis[2], x);
    let both = g.and(less, not_more);
    let either = g.or(both, same);
    let not = g.not(not_more);
    let and_not = g.and(not, less);
    let product = g.mul(frame[0], frame[1]);
    let difference = g.sub(frame[0], frame[1]);
    outputs.push(g.select(less, product, difference));
    let chosen = g.select(either, product, zero);
    outputs.push(g.add(chosen, x));
    outputs.push(g.neg(chosen));
    let chosen = g.select(and_not, x, difference);
    outputs.push(g.neg(chosen));
    let chosen = g.select(same, sum, chosen);
    g.set_name(chosen, "J");
    outputs.push(chosen);
    // Names that collide.
    for (i, name) in ["y0", "I", "gamma", "int", "fn", "out", "λ_x", "__a__b", "x", "x", "params", "near"]
        .iter()
        .enumerate()
    {
        let value = g.mul(frame[i % 9], long[i % 4]);
        g.set_name(value, name);
        outputs.push(value);
    }
    let long_name = g.mul(frame[8], blocks[0]);
    g.set_name(long_name, "d_a_relative_velocity_of_the_anchors_x_d_b_ry");
    outputs.push(long_name);
    // Pinned differences, alone, negated and within sums.
    let pinned: Vec<_> = (0..3).map(|i| g.difference(entry(1, 0, i), entry(0, 0, i))).collect();
    outputs.push(pinned[0]);
    outputs.push(g.neg(pinned[0]));
    outputs.push(g.add(pinned[1], x));
    let negative = g.neg(pinned[2]);
    let negative = g.mul(negative, axis[1]);
    outputs.push(g.neg(negative));
    outputs.push(g.add(negative, x));
    let total = g.sum(Exact::ONE, vec![(Exact::from(-1), axis[0]), (Exact::from(-2), axis[1])]);
    outputs.push(total);
    outputs.push(g.product(&[(total, 2)]));
    let nested = g.mul(total, axis[2]);
    outputs.push(g.sub(x, nested));
    let count = p.signature.dofs();
    let mut places = (0..2 * count * count).filter(|i| i % 31 != 3 && !(40..46).contains(i));
    for (i, value) in outputs.into_iter().enumerate() {
        if i < 4 {
            p.set(Output::new(Part::Force, 2 * i, 0), value);
        }
        let place = places.next().expect("room");
        let part = if place < count * count { Part::Dfdx } else { Part::Dfdv };
        p.set(Output::new(part, place % (count * count) / count, place % count), value);
    }
    p.graph = g;
    p
}

/// A generator of its own: the values of these programs are far from overflow and from the edges of domains, as
/// those of few other sequences are.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) % bound as u64) as usize
    }
}

/// A program of random nodes.
pub(crate) fn random(seed: u64, size: usize) -> Program {
    let mut r = Random(seed.wrapping_mul(0x9E3779B97F4A7C15) + 1);
    let signature = wide_signature();
    let mut g = Graph::default();
    let zero = g.zero();
    let mut p = program(signature, Graph::default(), zero);
    let mut pool: Vec<Id> = Vec::new();
    for (argument, length) in [(2, 1), (3, 3), (4, 9), (5, 8), (6, 4)] {
        pool.extend((0..length).map(|i| g.input(entry(argument, 0, i))));
    }
    pool.extend((0..3).map(|i| g.difference(entry(0, 0, i), entry(1, 0, i))));
    let mut truths: Vec<Id> = Vec::new();
    let functions: Vec<Function> = Function::ALL
        .into_iter()
        .filter(|f| {
            use Function::{Acosh, Atanh, Cosh, Exp, ExpM1, Sinh, Tan};
            !matches!(f, Cosh | Sinh | Exp | ExpM1 | Tan | Acosh(_) | Atanh(_))
        })
        .collect();
    for step in 0..size {
        let recent = pool.len().min(if step % 3 == 0 { 1000 } else { 8 });
        let pick = |r: &mut Random| pool[pool.len() - 1 - r.below(recent)];
        let node = match r.below(12) {
            0..4 => {
                let count = 2 + r.below(if step % 10 == 0 { 12 } else { 3 });
                let terms = (0..count)
                    .map(|_| {
                        (
                            Exact::ratio([1, 1, 1, -1, -1, 2, -3][r.below(7)], 1 + r.below(2) as u64),
                            pick(&mut r),
                        )
                    })
                    .collect();
                let constant = Exact::from([0, 0, 1, -1][r.below(4)]);
                g.sum(constant, terms)
            }
            4..8 => {
                let count = 1 + r.below(3);
                let factors: Vec<_> =
                    (0..count).map(|_| (pick(&mut r), 1 + (r.below(8) / 6) as u32)).collect();
                g.product(&factors)
            }
            8 => {
                let x = pick(&mut r);
                let square = g.mul(x, x);
                let two = g.constant(Exact::from(2));
                let x = g.add(square, two);
                let inverse = g.recip(x);
                g.mul(inverse, pick(&mut r))
            }
            9 => {
                let function = functions[r.below(functions.len())];
                let mut argument = || {
                    // Into every domain.
                    let x = pick(&mut r);
                    let square = g.mul(x, x);
                    let two = g.constant(Exact::from(2));
                    let bound = g.add(square, two);
                    g.recip(bound)
                };
                let arguments: Vec<_> = (0..function.row().arity).map(|_| argument()).collect();
                g.call(function, &arguments)
            }
            10 => {
                let (x, y) = (pick(&mut r), pick(&mut r));
                let comparison = [Comparison::Less, Comparison::LessEqual][r.below(2)];
                truths.push(g.compare(comparison, x, y));
                continue;
            }
            _ => {
                if truths.is_empty() {
                    continue;
                }
                let mut truth = truths[r.below(truths.len())];
                let other = truths[r.below(truths.len())];
                if r.below(3) == 0 && truth != other {
                    truth = if r.below(2) == 0 { g.and(truth, other) } else { g.or(truth, other) };
                    if r.below(2) == 0 {
                        let not = g.not(truth);
                        truths.push(not);
                    }
                    truths.push(truth);
                }
                g.select(truth, pick(&mut r), pick(&mut r))
            }
        };
        if r.below(6) == 0 {
            let names = ["pa_x", "lambda", "relative_velocity_y", "d_relative_velocity_x_d_a_ry", "n"];
            g.set_name(node, names[r.below(names.len())]);
        }
        pool.push(node);
    }
    let count = p.signature.dofs();
    for row in 0..count {
        let mut pick = |g: &mut Graph| {
            let id = pool[pool.len() - 1 - r.below(pool.len().min(60))];
            match r.below(6) {
                0 => id,
                1 => g.neg(id),
                2 => g.scaled(Exact::from(-2), id),
                _ => zero,
            }
        };
        p.set(Output::new(Part::Force, row, 0), pick(&mut g));
        for column in 0..count {
            p.set(Output::new(Part::Dfdx, row, column), pick(&mut g));
            if seed.is_multiple_of(2) {
                p.set(Output::new(Part::Dfdv, row, column), pick(&mut g));
            }
        }
    }
    p.graph = g;
    p
}

/// The value of an argument's entry.
pub(crate) fn input(signature: &Signature, slot: Slot) -> f64 {
    let mut r =
        Random(u64::from(slot.argument) * 7919 + u64::from(slot.field) * 101 + u64::from(slot.offset) + 17);
    r.below(10);
    let value = 0.25 + r.below(1000) as f64 / 1024.0;
    if signature.role(slot) == Some(Role::Position) { value - 0.5 } else { value }
}
