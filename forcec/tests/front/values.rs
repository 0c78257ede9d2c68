//! Values of graphs at made-up arguments: whether simplified expressions equal the written expressions.

use super::{accepted, compile};
use forcec::Specialization;
use forcec::internals::check;
use forcec::internals::math::number::Comparison;
use forcec::internals::math::random::Random;
use forcec::internals::vector::definition::{Definition, Law, Row};
use forcec::internals::vector::{Graph, Node};

/// A number between −1 and 1 that depends only on the position of the argument.
fn noise(seed: u64) -> f64 {
    Random::new(seed).uniform(-1.0, 1.0)
}

fn values(graph: &Graph, seed: u64) -> Vec<[f64; 3]> {
    use forcec::internals::model::bodies::{Role, Slot};
    let raw = |slot: Slot, offset: u32| {
        let place = (u64::from(slot.argument) << 40) + (u64::from(slot.field) << 32) + u64::from(offset);
        noise(seed.wrapping_mul(7919) + place)
    };
    let entry = |slot: Slot, offset: u32| {
        let quaternion = graph.signature.role(slot) == Some(Role::Orientation)
            || graph
                .signature
                .parameter(slot)
                .is_some_and(|p| p.ty == forcec::internals::model::bodies::ParameterType::Quaternion);
        let length = if quaternion { (0..4).map(|k| raw(slot, k).powi(2)).sum::<f64>().sqrt() } else { 1.0 };
        raw(slot, offset) / length
    };
    let cross = |u: [f64; 3], v: [f64; 3]| {
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    // The product of stored quaternions.
    let product = |turn: &[(Slot, bool)]| {
        turn.iter().fold([0.0, 0.0, 0.0, 1.0], |p: [f64; 4], (slot, inverse)| {
            let sign = if *inverse { -1.0 } else { 1.0 };
            let [x, y, z, w] = [0, 1, 2, 3].map(|k| entry(*slot, slot.offset + k));
            let (u, v) = ([p[0], p[1], p[2]], [sign * x, sign * y, sign * z]);
            let t = cross(u, v);
            let [a, b, c] = std::array::from_fn(|k| p[3] * v[k] + w * u[k] + t[k]);
            [a, b, c, p[3] * w - dot(u, v)]
        })
    };
    let mut all: Vec<[f64; 3]> = Vec::new();
    for node in graph.nodes() {
        let real = |x: f64| [x, 0.0, 0.0];
        let truth = |b: bool| [f64::from(u8::from(b)), 0.0, 0.0];
        let at = |index: usize| all[index];
        let triple = |slot: &Slot| [0, 1, 2].map(|k| entry(*slot, slot.offset + k));
        let value = match node {
            Node::Constant(c) => real(c.to_f64()),
            Node::Entry(slot) => real(entry(*slot, slot.offset)),
            Node::Sum(c, terms) => {
                real(c.to_f64() + terms.iter().map(|(c, x)| c.to_f64() * at(x.index())[0]).sum::<f64>())
            }
            Node::Product(factors) => real(factors.iter().map(|(x, n)| at(x.index())[0].powi(*n)).product()),
            Node::Dot(u, v) => real(dot(at(u.index()), at(v.index()))),
            Node::Component(v, k) => real(at(v.index())[*k as usize]),
            Node::Norm(v) => real(dot(at(v.index()), at(v.index())).sqrt()),
            Node::Call(f, x) => {
                let x: Vec<f64> = x.iter().map(|x| at(x.index())[0]).collect();
                real((f.row().value)(&x))
            }
            Node::Select(c, x, y) => {
                if at(c.index())[0] != 0.0 {
                    at(x.index())
                } else {
                    at(y.index())
                }
            }
            Node::VectorSelect(c, x, y) => {
                if at(c.index())[0] != 0.0 {
                    at(x.index())
                } else {
                    at(y.index())
                }
            }
            Node::Let(x) => at(x.index()),
            Node::Offset(x, number) => real(at(x.index())[0] + number.to_f64()),
            Node::VectorOffset(v, place) => std::array::from_fn(|k| at(v.index())[k] + place[k].to_f64()),
            Node::VectorLet(x) => at(x.index()),
            Node::Triple(slot) => triple(slot),
            Node::Difference(p, q) => std::array::from_fn(|k| triple(p)[k] - triple(q)[k]),
            Node::VectorSum(terms) => {
                let sum = |k: usize| terms.iter().map(|(c, v)| c.to_f64() * at(v.index())[k]).sum();
                std::array::from_fn(sum)
            }
            Node::Scale(s, v) => at(v.index()).map(|x| at(s.index())[0] * x),
            Node::Cross(u, v) => cross(at(u.index()), at(v.index())),
            Node::Rotate(slot, inverse, v) => {
                let sign = if *inverse { -1.0 } else { 1.0 };
                let u = triple(slot).map(|x| sign * x);
                let w = entry(*slot, slot.offset + 3);
                let v = at(v.index());
                let t = cross(u, v);
                let ut = cross(u, t);
                std::array::from_fn(|k| v[k] + 2.0 * w * t[k] + 2.0 * ut[k])
            }
            Node::TurnReal(turn) => real(product(turn)[3]),
            Node::TurnVector(turn) => std::array::from_fn(|k| product(turn)[k]),
            Node::Pack(entries) => entries.map(|x| at(x.index())[0]),
            Node::Known(b) => truth(*b),
            Node::Compare(c, x, y) => {
                let (x, y) = (at(x.index())[0], at(y.index())[0]);
                truth(match c {
                    Comparison::Less => x < y,
                    Comparison::LessEqual => x <= y,
                    Comparison::Equal => x == y,
                })
            }
            Node::And(a, b) => truth(at(a.index())[0] * at(b.index())[0] != 0.0),
            Node::Or(a, b) => truth(at(a.index())[0] + at(b.index())[0] != 0.0),
            Node::Not(a) => truth(at(a.index())[0] == 0.0),
        };
        all.push(value);
    }
    all
}

/// The numbers a definition states, in order.
pub(crate) fn outputs(definition: &Definition, seed: u64) -> Vec<f64> {
    let values = values(&definition.graph, seed);
    match &definition.law {
        Law::Constraint { rows, .. } => rows
            .iter()
            .flat_map(|row| match row {
                Row::Real(x) => values[x.index()][..1].to_vec(),
                Row::Vector(v) => values[v.index()].to_vec(),
            })
            .collect(),
        Law::Energy(e) => vec![values[e.index()][0]],
        Law::Force(forces) => forces
            .iter()
            .flat_map(|f| [Some(f.force), f.torque].into_iter().flatten())
            .flat_map(|v| values[v.index()])
            .collect(),
    }
}

/// Both graphs of every function of a text give the same numbers; returns those of the first seed.
pub(crate) fn agreed(text: &str) -> Vec<Vec<f64>> {
    let (file, checked) = accepted(text);
    let mut first = Vec::new();
    for definition in &checked.definitions {
        let verbatim = check::elaborate(&file, &definition.name, &Specialization::default());
        for seed in 0..5 {
            let (x, y) = (outputs(definition, seed), outputs(&verbatim, seed));
            assert_eq!(x.len(), y.len());
            for (x, y) in x.iter().zip(&y) {
                let close = (x - y).abs() <= 1e-12 * (1.0 + x.abs()) || x.is_nan() && y.is_nan();
                assert!(close, "{}: {x} is not {y}\n{text}", definition.name);
            }
            if seed == 0 {
                first.push(x);
            }
        }
    }
    first
}

/// Asserts that every row is zero for all arguments: `left` equals `right`.
pub(crate) fn zero(arguments: &str, rows: &[(&str, &str)]) {
    for (left, right) in rows {
        for kind in ["Real", "Vec2", "Vec3", "Vec4"] {
            let text = format!("#[constraint]\nfn f({arguments}) -> {kind} {{ ({left}) - ({right}) }}\n");
            let Ok((file, checked)) = compile(&text) else { continue };
            agreed(&text);
            for seed in 0..5 {
                for definition in
                    [&checked.definitions[0], &check::elaborate(&file, "f", &Specialization::default())]
                {
                    for x in outputs(definition, seed) {
                        assert!(x.abs() < 1e-12, "{left} is not {right}: {x}");
                    }
                }
            }
            break;
        }
        let any = ["Real", "Vec2", "Vec3", "Vec4"].iter().any(|kind| {
            compile(&format!("#[constraint]\nfn f({arguments}) -> {kind} {{ ({left}) - ({right}) }}\n"))
                .is_ok()
        });
        let text = format!("#[constraint]\nfn f({arguments}) -> Real {{ ({left}) - ({right}) }}\n");
        assert!(any, "{}", compile(&text).map(|_| ()).unwrap_err());
    }
}
