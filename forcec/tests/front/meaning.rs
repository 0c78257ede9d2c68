//! Valid programs mean the same on both graphs.

use super::values::{agreed, zero};
use super::{PROGRAM, accepted};
use forcec::internals::vector::definition::Law;

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

#[test]
fn the_tree_prints() {
    let (file, _) = accepted("#[energy]\nfn f(a: Particle) -> Real { 2.0 * a.position.norm_squared() }\n");
    let expected = "energy f\n  argument a: Particle\n  returns Real\n  value\n    *\n      number 2\n      method norm_squared\n        field position\n          a\n";
    assert_eq!(file.to_string(), expected);
}
