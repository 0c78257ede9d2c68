//! The front end on texts: what is right means the same on both graphs, what is wrong gets its message, and nothing
//! panics, hangs or overflows.
//!
//! A wrong input is a file `tests/wrong/NAME.rs` with its message in `NAME.stderr`; `FORCEC_BLESS=1` writes messages.

use forcec::check::{self, Checked};
use forcec::definition::{Definition, Law, Row};
use forcec::diagnostic::{Diagnostics, Severity};
use forcec::span::Source;
use forcec::syntax::{self, ast};
use forcec::vector::{Comparison, Graph, Node};
use std::path::Path;

/// Parses and checks a text.
fn compile(text: &str) -> Result<(ast::File, Checked), Diagnostics> {
    let file = syntax::parse(&Source::new("force.rs", text))?;
    let checked = check::check(&file)?;
    Ok((file, checked))
}

fn accepted(text: &str) -> (ast::File, Checked) {
    compile(text).unwrap_or_else(|diagnostics| panic!("{text}\n{diagnostics}"))
}

// ---- values: a small evaluator of graphs at made-up arguments

/// A number between −1 and 1 that depends on its place only.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x1234_5678_9abc_def1);
    x ^= x >> 31;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 29;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn values(graph: &Graph, seed: u64) -> Vec<[f64; 3]> {
    use forcec::bodies::{Role, Slot};
    let raw = |slot: Slot, offset: u32| {
        let place = (u64::from(slot.argument) << 40) + (u64::from(slot.field) << 32) + u64::from(offset);
        noise(seed.wrapping_mul(7919) + place)
    };
    let entry = |slot: Slot, offset: u32| {
        let quaternion = graph.signature.role(slot) == Some(Role::Orientation)
            || graph
                .signature
                .parameter(slot)
                .is_some_and(|p| p.ty == forcec::bodies::ParameterType::Quaternion);
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
fn outputs(definition: &Definition, seed: u64) -> Vec<f64> {
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
fn agreed(text: &str) -> Vec<Vec<f64>> {
    let (file, checked) = accepted(text);
    let mut first = Vec::new();
    for definition in &checked.definitions {
        let verbatim = check::elaborate(&file, &definition.name);
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

/// Every row is zero, whatever the arguments: what `left` and `right` are is the same.
fn zero(arguments: &str, rows: &[(&str, &str)]) {
    for (left, right) in rows {
        for kind in ["Real", "Vec2", "Vec3", "Vec4"] {
            let text = format!("#[constraint]\nfn f({arguments}) -> {kind} {{ ({left}) - ({right}) }}\n");
            let Ok((file, checked)) = compile(&text) else { continue };
            agreed(&text);
            for seed in 0..5 {
                for definition in [&checked.definitions[0], &check::elaborate(&file, "f")] {
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

#[test]
fn vectors() {
    zero(
        "a: Particle, x: Real, u: Vec3, v: Vec3, p: Vec2, q: Vec2, s: Vec4",
        &[
            ("u.cross(&v).dot(&u)", "0.0"),
            ("Vec3::dot(&u, &v)", "u.x * v.x + u.y * v[1] + u[2] * v.z"),
            ("u.norm() * u.normalize()", "u"),
            ("p.norm() * p.normalize()", "p"),
            ("u / x", "x.recip() * u"),
            ("u.norm_squared()", "u.norm().powi(2)"),
            ("p.dot(&q)", "p.x * q.x + p.y * q.y"),
            ("s.norm()", "(s.x * s.x + s.y * s.y + s.z * s.z + s.w * s.w).sqrt()"),
            ("u.component_mul(&v)", "Vec3::new(u.x * v.x, u.y * v.y, u.z * v.z)"),
            ("(u * v.transpose()) * u", "u.outer(&v) * u"),
            ("u.outer(&v) * u", "u * v.dot(&u)"),
            ("(p.outer(&q)) * q", "p * q.norm_squared()"),
            ("Vec3::x() + Vec3::y() + Vec3::z() + Vec3::zeros()", "Vec3::new(1.0, 1.0, 1.0)"),
            ("Vec2::x() + 2.0 * Vec2::y()", "Vec2::new(1.0, 2.0)"),
            ("-(-u)", "&u"),
            ("(u.transpose() * u.outer(&v)).transpose()", "u.norm_squared() * v"),
            ("x.clamp(-0.1, 0.2)", "x.max(-0.1).min(0.2)"),
            ("x.sin_cos().0", "x.sin()"),
            ("Real::max(x, 0.0)", "if x > 0.0 { x } else { 0.0 }"),
            ("{ let (s, c) = x.sin_cos(); s * s + c * c }", "1.0"),
            ("2.0f64 * x + 1e0", "x + x + 1.0"),
        ],
    );
}

#[test]
fn matrices() {
    zero(
        "a: Particle, x: Real, u: Vec3, v: Vec3, p: Vec2, m: Mat3, n: Mat3, c: Mat2, d: Mat2",
        &[
            ("m * (n * u)", "(m * n) * u"),
            ("(m.transpose() * n) * u", "m.transpose() * (n * u)"),
            ("(m * n.transpose()) * u", "m * (n.transpose() * u)"),
            ("(m.transpose() * n.transpose()) * u", "(n * m).transpose() * u"),
            ("m.inverse() * (m * u)", "u"),
            ("m.transpose().inverse() * (m.transpose() * u)", "u"),
            ("c.inverse() * (c * p)", "p"),
            ("(c * d) * p", "c * (d * p)"),
            ("(c.transpose() * d).transpose() * p", "d.transpose() * (c * p)"),
            ("(m + n.transpose() * x) * u", "m * u + x * (n.transpose() * u)"),
            ("(m * n).determinant()", "m.determinant() * n.transpose().determinant()"),
            ("(c * d).determinant()", "c.determinant() * d.determinant()"),
            ("(m.transpose() * m).trace()", "m.norm_squared()"),
            ("(c.transpose() * c).trace()", "c.norm_squared()"),
            ("m[(1, 2)]", "(m * Vec3::z()).y"),
            ("m.transpose()[(2, 1)]", "m[(1, 2)]"),
            ("c[(0, 1)]", "(c * Vec2::y()).x"),
            ("Mat3::from_columns(&[u, v, u.cross(&v)]) * Vec3::y()", "v"),
            (
                "Mat3::from_rows(&[u.transpose(), v.transpose(), u.transpose()]) * Vec3::y()",
                "Vec3::new(u.y, v.y, u.y)",
            ),
            ("Mat2::from_columns(&[p, 2.0 * p]) * Vec2::y()", "2.0 * p"),
            ("Mat2::from_rows(&[p.transpose(), p.transpose()]) * Vec2::y()", "Vec2::new(p.y, p.y)"),
            ("Mat3::from_diagonal(&u) * v", "u.component_mul(&v)"),
            ("Mat3::identity() * u", "u"),
            (
                "Mat3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0) * Vec3::y()",
                "Vec3::new(2.0, 5.0, 8.0)",
            ),
            ("Mat2::new(1.0, 2.0, 3.0, 4.0) * Vec2::y()", "Vec2::new(2.0, 4.0)"),
            (
                "(if x > 0.0 { m } else { n.transpose() }) * u",
                "if x > 0.0 { m * u } else { n.transpose() * u }",
            ),
            ("{ let mut k = m; k[(0, 1)] += x; k * Vec3::y() }", "m * Vec3::y() + x * Vec3::x()"),
            ("{ let mut w = u; w.y = x; w[2] -= x; w }", "Vec3::new(u.x, x, u.z - x)"),
        ],
    );
}

#[test]
fn rotations() {
    zero(
        "a: Rigid, b: Rigid, x: Real, r: Quat, v: Vec3",
        &[
            ("a.orientation.to_rotation_matrix().into_inner() * v", "a.orientation * v"),
            ("(a.orientation * r.inverse()) * v", "a.orientation * (r.conjugate() * v)"),
            ("(a.orientation * Quat::from_scaled_axis(v)) * v", "a.orientation * v"),
            ("Quat::from_scaled_axis(0.3 * v).scaled_axis()", "0.3 * v"),
            ("Quat::from_scaled_axis(-0.3 * v).angle()", "0.3 * v.norm()"),
            ("a.orientation.angle_to(&b.orientation)", "(b.orientation * a.orientation.inverse()).angle()"),
            ("r.scaled_axis().norm()", "r.angle()"),
            ("Quat::from_scaled_axis(r.scaled_axis()) * v", "r * v"),
            ("r.imag().norm_squared() + r.w * r.w", "1.0"),
            ("Vec3::new(r.i, r.j, r.k)", "-r.inverse().imag()"),
            ("Quat::identity() * v", "v"),
            ("(Quat::identity() * r).imag()", "r.imag()"),
            ("(a.orientation / b.orientation) * (b.orientation * v)", "a.orientation * v"),
            ("Quat::from_scaled_axis(Vec3::z() * (PI / 2.0)) * Vec3::x()", "Vec3::y()"),
            (
                "(if x > 0.0 { a.orientation } else { r }) * v",
                "if x > 0.0 { a.orientation * v } else { r * v }",
            ),
        ],
    );
}

#[test]
fn control() {
    zero(
        "a: Particle, x: Real, y: Real, v: [Real; 4], w: [[Vec3; 2]; 3]",
        &[
            ("{ let mut s = 0.0; for i in 0..4 { s += v[i]; } s }", "v[0] + v[1] + v[2] + v[3]"),
            (
                "{ let mut s = 0.0; for i in 1..=3 { s += (i as Real) * v[i]; } s }",
                "v[1] + 2.0 * v[2] + 3.0 * v[3]",
            ),
            ("{ let mut s = 1.0; for i in 0..4 { if i % 2 == 0 { s *= v[i]; } } s }", "v[0] * v[2]"),
            (
                "{ let mut s = x; if y > 0.0 { s = y; } else if x > 0.1 { s -= 2.0; } s }",
                "if y > 0.0 { y } else if x > 0.1 { x - 2.0 } else { x }",
            ),
            (
                "{ let mut s = x; if y > 0.0 { if x > 0.0 { s = 1.0; } s += y; } s }",
                "if y > 0.0 { (if x > 0.0 { 1.0 } else { x }) + y } else { x }",
            ),
            (
                "{ let mut t = [x, y, x]; t[1] = 2.0; for i in 0..3 { t[i] += 1.0; } t[0] + t[1] * t[2] }",
                "x + 1.0 + 3.0 * (x + 1.0)",
            ),
            (
                "{ let mut t = (x, [y, x]); t.1[0] = x; if y < 0.0 { t.0 = y; } t.0 + (t.1)[0] }",
                "(if y < 0.0 { y } else { x }) + x",
            ),
            ("w[2][1] + w[0][0]", "w[0][0] + w[3 - 1][1]"),
            (
                "if x > 0.0 && !(y < 0.0) || x == y { 1.0 } else { 0.0 }",
                "if x > 0.0 { if y < 0.0 { 0.0 } else { 1.0 } } else { 0.0 }",
            ),
            (
                "{ let p = x > y; let q = if p { y < 0.0 } else { x > 0.0 }; if q { x } else { y } }",
                "if x > y { if y < 0.0 { x } else { y } } else { if x > 0.0 { x } else { y } }",
            ),
            ("{ let ((p, _), [q, r]) = ((x, y), [y, x]); p + q * r }", "x + x * y"),
            ("{ const N: usize = 2; let s = [1.5; N]; s[0] + s[N - 1] }", "3.0"),
            ("{ let x = x + 1.0; let x = x * 2.0; x }", "2.0 * (x + 1.0)"),
            ("{ let mut s = 0.0; for i in 0..3 { for j in 0..i { s += (i * 10 + j) as Real; } } s }", "51.0"),
        ],
    );
}

const PROGRAM: &str = r#"
//! Everything at once.
use forcec_runtime::prelude::*;
use std::f64::consts::PI;

const STEPS: usize = SIDE * 2;
const SIDE: usize = 2;
const WEIGHTS: [Real; STEPS] = [1.0, 2.0, 3.0, HALF];
const HALF: Real = 0.5 * std::f64::consts::PI;
const UP: Vec3 = Vec3::new(0.0, 0.0, 1.0);

/// Anchor of a body.
fn anchor(body: &Rigid, arm: &Vec3) -> Vec3 {
    body.position + body.orientation * arm
}

const fn twice(x: Real) -> Real {
    x + x
}

fn spread(p: (Vec3, Real), flag: bool) -> (Real, Vec3) {
    (if flag { p.1 } else { twice(p.1) }, p.0)
}

fn pick(values: [Real; STEPS], k: usize) -> Real {
    values[k + 1]
}

#[inline]
pub(crate) fn unused(b: Rigid, q: Quat, m: Mat3, w: Wrench) -> Wrench {
    Wrench { force: m * (q * w.force), torque: anchor(&b, &w.torque) }
}

/// A joint.
///
///  Indented.
#[constraint(per_row, unilateral, real = f32)]
#[domain(axis = unit, reach = 0.5..=PI, gains = -1.0..1.0)]
#[allow(clippy::too_many_arguments)]
pub fn joint(a: Rigid, b: Particle, arm: Vec3, axis: Vec3, reach: Real, gains: [Vec2; 3]) -> (Vec3, [Real; 2], (Vec2, Real)) {
    let d = b.position - anchor(&a, &arm);
    let (r, v) = spread((d, d.dot(&axis) / reach), reach > 1.0);
    (v, [r, pick(WEIGHTS, 1)], (gains[1], UP.dot(&d)))
}

#[forcec::energy]
fn gravity(p: Particle, mass: Real) -> Real {
    9.81 * mass * p.position.dot(&UP)
}

#[force]
fn drag(a: Rigid, p: Particle, k: Real) -> (Wrench, Vec3) {
    let force = -k * (a.velocity + a.angular_velocity.cross(&UP));
    (Wrench { torque: UP.cross(&force), force }, -force + joint_like(p.velocity))
}

fn joint_like(v: Vec3) -> Vec3 {
    let mut sum = Vec3::zeros();
    for _ in 0..STEPS {
        sum += v;
    }
    sum
}
"#;

#[test]
fn whole_program() {
    let numbers = agreed(PROGRAM);
    assert_eq!(numbers.iter().map(Vec::len).collect::<Vec<_>>(), [8, 1, 9]);
    let (_, checked) = accepted(PROGRAM);
    let joint = &checked.definitions[0];
    assert_eq!(joint.docs, ["A joint.", "", " Indented."]);
    let signature = &joint.graph.signature;
    let names: Vec<String> =
        signature.parameters.iter().map(|p| format!("{}: {:?}", p.name, p.domain)).collect();
    assert_eq!(
        names,
        [
            "arm: Any",
            "axis: Unit",
            &format!("reach: Range(0.5, {:?})", std::f64::consts::PI),
            "gains: Range(-1.0, 1.0)",
            "stiffness: Any",
            "damping: Any"
        ]
    );
    assert_eq!(signature.parameters[4].ty.extents(), [8]);
    assert!(matches!(joint.law, Law::Constraint { unilateral: true, per_row: true, .. }));
    let warnings: Vec<&str> = checked.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(warnings, [] as [&str; 0]);
}

#[test]
fn forces_on_one_body() {
    let numbers = agreed(
        "#[force]\nfn wind(p: Particle, v: Vec3, k: Real) -> Vec3 { k * (v - p.velocity) }\n\
         #[force]\nfn spin(a: Rigid, k: Real) -> Wrench { Wrench { force: Vec3::zeros(), torque: -k * a.angular_velocity } }\n\
         #[force]\nfn one(a: Rigid, k: Real) -> (Wrench,) { (Wrench { force: k * a.velocity, torque: Vec3::z() },) }\n",
    );
    assert_eq!(numbers.iter().map(Vec::len).collect::<Vec<_>>(), [3, 6, 6]);
}

#[test]
fn a_module_of_forces_is_read_in_place() {
    let text = "//! Docs.\nuse a::b;\n#[forces]\npub mod joints {\n    use super::*;\n    #[energy]\n    fn f(a: Particle) -> Real { a.position.x }\n}\n";
    let (file, checked) = accepted(text);
    assert_eq!((file.docs, checked.definitions[0].name.as_str()), (vec!["Docs.".to_owned()], "f"));
}

// ---- warnings

/// The messages of the warnings of an energy with this body.
fn warned(domain: &str, body: &str) -> Vec<String> {
    let text = format!(
        "#[energy]\n{domain}\nfn f(a: Particle, b: Particle, x: Real, y: Real, u: Vec3, m: Mat3, q: Quat) -> Real {{\n    {body}\n}}\n"
    );
    let (_, checked) = accepted(&text);
    let singular = checked.warnings.iter().filter(|w| !w.message.starts_with("unused"));
    singular.map(|w| w.message.clone()).collect()
}

#[test]
fn warnings_where_a_formula_can_be_singular() {
    for body in [
        "(a.position - b.position).norm()",
        "x / y",
        "y.recip()",
        "y.powi(-2)",
        "x.sqrt()",
        "x.abs().sqrt()",
        "x.ln()",
        "x.acos()",
        "u.normalize().dot(&b.position.normalize()).acos() * 0.0",
        "m.inverse().trace()",
        "(u / y).x",
        "x.atan2(y)",
        "x.powf(y)",
        "x.hypot(y)",
        "x.cbrt()",
        "(x - x.abs()).ln_1p()",
        "if x > 0.0 { 1.0 / y } else { 0.0 }",
        "if x >= 0.0 { 1.0 / x } else { 0.0 }",
        "1.0 / x.min(y).exp_m1()",
        "q.angle()",
        "q.imag().norm()",
        "(q * q).angle()",
    ] {
        assert!(!warned("", body).is_empty(), "no warning about {body}");
    }
}

#[test]
fn no_warning_where_it_is_written_safely() {
    for (domain, body) in [
        ("", "((a.position - b.position).norm_squared() + 1e-9).sqrt()"),
        ("", "x / y.max(1e-9)"),
        ("", "x / (1.0 + y * y)"),
        ("", "x / (y.abs() + 0.1)"),
        ("", "1.0 / y.exp()"),
        ("", "(x * x + 1.0).ln()"),
        ("", "(x / 2.0) * (y / PI)"),
        ("#[domain(y = 0.1..2.0)]", "x / y + y.sqrt() + y.ln() + y.powf(x) + x.atan2(y)"),
        ("#[domain(x = -0.5..0.5)]", "x.acos() + x.asin() + (x + 1.0).ln()"),
        ("#[domain(u = unit)]", "u.norm() + u.normalize().x"),
        ("#[domain(u = unit)]", "(u.dot(&u) * 0.5).acos()"),
        ("", "if x > 0.0 { x.ln() + 1.0 / x } else { 0.0 }"),
        ("", "if x < 0.5 { 0.0 } else { x.sqrt() }"),
        ("", "if x != 0.0 { y / x } else { 0.0 }"),
        ("", "if x > 0.0 && y > 0.1 { y.sqrt() / x } else { 0.0 }"),
        ("", "if u.norm_squared() > 0.0 { u.norm() } else { 0.0 }"),
        ("", "{ let d = u.norm_squared(); if d > 1e-6 { u.normalize().x / d } else { 0.0 } }"),
        ("", "if x > 0.0 && 1.0 / x > y { 1.0 } else { 0.0 }"),
        ("", "Quat::from_scaled_axis(u).scaled_axis().x"),
    ] {
        assert_eq!(warned(domain, body), [] as [String; 0], "{body}");
    }
}

#[test]
fn a_warning_is_given_once_however_often_a_helper_is_inlined() {
    let text = "fn inverse(x: Real) -> Real { 1.0 / x }\n#[energy]\nfn f(a: Particle) -> Real {\n    let p = a.position;\n    inverse(p.x) + inverse(p.y) + inverse(p.z)\n}\n";
    let (_, checked) = accepted(text);
    assert_eq!(checked.warnings.len(), 1);
}

// ---- wrong inputs

#[test]
fn wrong_inputs_get_their_messages() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/wrong");
    let bless = std::env::var_os("FORCEC_BLESS").is_some();
    let mut failures = Vec::new();
    let mut count = 0;
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .expect("the folder of wrong inputs")
        .map(|e| e.expect("an entry").path())
        .collect();
    files.sort();
    for path in files.into_iter().filter(|path| path.extension().is_some_and(|e| e == "rs")) {
        count += 1;
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).expect("a text");
        let source = Source::new(format!("tests/wrong/{name}"), text);
        let found = match syntax::parse(&source).and_then(|file| check::check(&file)) {
            Err(diagnostics) => {
                assert!(diagnostics.has_errors(), "{name}");
                diagnostics
            }
            Ok(checked) => {
                // A file named after a warning is accepted with it.
                assert!(name.starts_with("warning_"), "{name} is accepted");
                Diagnostics::new(source, checked.warnings)
            }
        };
        let found = format!("{found}\n");
        let expected = path.with_extension("stderr");
        if bless {
            std::fs::write(&expected, &found).expect("to write the message");
        } else if std::fs::read_to_string(&expected).unwrap_or_default() != found {
            failures.push(format!("{name}:\n{found}"));
        }
    }
    assert!(count >= 60, "{count} wrong inputs");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

// ---- any text at all

/// Neither a panic nor an overflow; returns whether there was no error.
fn survives(text: &str) -> bool {
    match compile(text) {
        Ok((_, checked)) => {
            assert!(checked.warnings.iter().all(|w| w.severity == Severity::Warning));
            true
        }
        Err(diagnostics) => {
            assert!(!diagnostics.to_string().is_empty());
            false
        }
    }
}

#[test]
fn deep_and_long_inputs() {
    let energy = |body: &str| format!("#[energy]\nfn f(_a: Particle, x: Real) -> Real {{ {body} }}\n");
    assert!(!survives(&"(".repeat(100_000)));
    assert!(!survives(&energy(&format!("{}x{}", "(".repeat(100_000), ")".repeat(100_000)))));
    assert!(!survives(&energy(&format!("{}x", "-".repeat(100_000)))));
    assert!(survives(&energy(&format!("{}x", "-".repeat(1500)))));
    assert!(survives(&energy(&format!("{}x", "& ".repeat(1500)))));
    assert!(!survives(&energy(&format!("x as {}Real", "&".repeat(39_000)))));
    assert!(!survives(&energy(&format!("{}x", "<".repeat(39_000)))));
    assert!(!survives(&energy(&format!("x as {}Real", "*const ".repeat(19_000)))));
    assert!(survives(&energy(&format!("{}x", "1.0 + ".repeat(15_000)))));
    let chain: String = (1..5000).map(|i| format!("else if x < {i}.0 {{ {i}.5 }} ")).collect();
    assert!(survives(&energy(&format!("if x < 0.0 {{ 0.5 }} {chain} else {{ 1.0 }}"))));
    assert!(survives(&energy(&format!("{}x{}", "{".repeat(250), "}".repeat(250)))));
    assert!(!survives(&energy(&format!("{}x{}", "{".repeat(300), "}".repeat(300)))));
    assert!(!survives(&energy(&format!("x as {}Real{}", "Vec<".repeat(9000), ">".repeat(9000)))));
    assert!(!survives(&energy(&format!("{}x", "|| ".repeat(13_000)))));
    assert!(!survives(&energy("let mut s = 0.0; for i in 0..1_000_000_000 { s += x; } s")));
    assert!(!survives(&energy("let mut s = 0.0; for i in 0..10_000 { for j in 0..10_000 { s += x; } } s")));
    assert!(!survives(&energy("let a = [x; 1_000_000_000]; a[0]")));
    assert!(!survives(&format!(
        "#[energy]\nfn f(_a: Particle, x: {}Real{}) -> Real {{ 1.0 }}\n",
        "[".repeat(250),
        "; 2]".repeat(250)
    )));
    assert!(!survives(&format!("fn f(x: {}Real) -> Real {{ 1.0 }}\n", "&'a ".repeat(13_000))));
    let doubled: String = (1..60).map(|i| format!("let t{i} = (t{0}, t{0});", i - 1)).collect();
    assert!(!survives(&energy(&format!("let t0 = x; {doubled} x"))));
    let helpers: String =
        (1..200).map(|i| format!("fn h{i}(x: Real) -> Real {{ h{0}(x) + h{0}(x) }}\n", i - 1)).collect();
    assert!(survives(&format!("fn h0(x: Real) -> Real {{ x.sin() }}\n{helpers}{}", energy("h199(x)"))));
    let deep: String = (1..40)
        .map(|i| format!("fn g{i}(x: Real) -> Real {{ {} g{}(x) }}\n", "-".repeat(3000), i - 1))
        .collect();
    assert!(!survives(&format!("fn g0(x: Real) -> Real {{ x }}\n{deep}{}", energy("g39(x)"))));
    let sums = "let mut s = 0.0; for i in 0..5000 { s += w[i] * w[i]; } s";
    assert!(survives(&format!("#[energy]\nfn f(_a: Particle, w: [Real; 5000]) -> Real {{ {sums} }}\n")));
}

#[test]
fn odd_texts() {
    let plain = "#[energy]\nfn f(_a: Particle, x: Real) -> Real { x }\n";
    for text in [
        String::new(),
        "// only\n/* comments */\n//! here\n".to_owned(),
        format!("\u{feff}{plain}"),
        format!("#!/usr/bin/env forcec\n{plain}"),
        format!("\u{feff}#!/usr/bin/env forcec\n{plain}"),
        plain.replace('\n', "\r\n"),
        format!("#![allow(dead_code)]\n{plain}"),
    ] {
        assert!(survives(&text), "{text}");
    }
    for text in
        ["fn f() { \0 }", "\u{0}", "fn", "#", "'", "\"", "/*", "r#\"", "0x", "1e", "😀", "fn f() -> \u{2028}"]
    {
        assert!(!survives(text), "{text}");
    }
    // Prefixes of a program end anywhere.
    for end in (0..PROGRAM.len()).step_by(7).filter(|end| PROGRAM.is_char_boundary(*end)) {
        survives(&PROGRAM[..end]);
    }
    // A program with one token left out, or one doubled.
    let words: Vec<&str> = PROGRAM.split_inclusive(' ').collect();
    for k in 0..words.len() {
        let without: String = words.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, w)| *w).collect();
        survives(&without);
        let doubled: String = words
            .iter()
            .enumerate()
            .flat_map(|(i, w)| std::iter::repeat_n(*w, if i == k { 2 } else { 1 }))
            .collect();
        survives(&doubled);
    }
}

#[test]
fn files_without_forces_are_passed_over() {
    for text in [
        "#[constraint]\nfn f() {}",
        "mod m { #[forcec_runtime::energy] fn f() {} }",
        "#[inline]\n#[force]\nfn f() {}",
        "#[forces] mod joints {}",
        "#[constraint(unilateral)] fn f() { \" }",
    ] {
        assert!(syntax::mentions_forces(text), "{text}");
    }
    for text in [
        "",
        "fn force() {}",
        "// #[force]\nfn f() {}",
        "/* #[energy] */",
        "const S: &str = \"#[constraint]\";",
        "#[derive(Clone)] struct force;",
        "fn f() { \" energy # }",
    ] {
        assert!(!syntax::mentions_forces(text), "{text}");
    }
}

#[test]
fn the_reference_lists_every_row_once() {
    let rows = check::reference();
    assert!(rows.len() > 70);
    for (k, row) in rows.iter().enumerate() {
        assert!(!rows[..k].contains(row), "{row:?}");
    }
}

#[test]
fn the_tree_prints() {
    let (file, _) = accepted("#[energy]\nfn f(a: Particle) -> Real { 2.0 * a.position.norm_squared() }\n");
    let expected = "energy f\n  argument a: Particle\n  returns Real\n  value\n    *\n      number 2\n      method norm_squared\n        field position\n          a\n";
    assert_eq!(file.to_string(), expected);
}
