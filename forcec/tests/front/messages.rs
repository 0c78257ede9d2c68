//! Warnings where a formula can be singular and nowhere else, the length of a report, and the source ranges of
//! expressions.

use super::{PROGRAM, accepted, compile};
use forcec::internals::source::diagnostic::Diagnostics;
use forcec::internals::source::span::Source;
use forcec::internals::syntax;
use std::path::Path;

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
        "y / x.sin()",
        "y / x.cos()",
        "y / (x.sin() + 0.9)",
        "(x.cos() - 0.5).sqrt()",
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
        ("#[domain(x = 0.1..1.5)]", "y / x.sin() + y / x.cos() + y / x.tan()"),
        (
            "#[domain(x = -0.1..3.2)]",
            "(x.sin() + 0.2).sqrt() + 1.0 / (2.0 + (5.0 * y).sin()) + (1.5 + y.cos()).ln()",
        ),
        ("#[domain(x = 6.0..6.5)]", "1.0 / x.cos() + (x.sin() + 0.3).sqrt()"),
        ("", "if x > 1.0 && x < 0.0 { x.sqrt() + x.ln() } else { 0.0 }"),
        ("", "Vec3::zeros().norm() + (2.0 - 1.0).acos() + (1.0 - 1.0).sqrt()"),
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

#[test]
fn a_warning_says_how_often_it_was_met() {
    let text = "#[energy]\nfn f(a: Particle, r: [Vec3; 6]) -> Real {\n    let mut e = 0.0;\n    for i in 0..6 {\n        \
                e += (a.position - r[i]).norm() + r[i].norm();\n    }\n    e\n}\n";
    let (file, checked) = accepted(text);
    let told = Diagnostics::new(file.source, checked.warnings).to_string();
    assert_eq!(told.matches("warning[singular]").count(), 2, "{told}");
    assert!(told.contains("^ the length has no derivative where the vector is zero (6 times)\n"), "{told}");
}

#[test]
fn a_report_has_at_most_a_hundred_errors() {
    let sum: String = (0..102).map(|k| format!(" + x{k}")).collect();
    let text = format!("#[energy]\nfn f(a: Particle) -> Real {{ a.position.x{sum} }}\n");
    let errors = compile(&text).map(|_| ()).unwrap_err().list;
    assert_eq!((errors.len(), errors[100].message.as_str()), (101, "2 more errors are not shown"));
}

/// The source range of each expression is a complete expression, with all of its brackets.
#[test]
fn places_keep_their_brackets() {
    let brackets = "const TWO: Real = (2.0);\n#[energy]\nfn f(a: Particle, (k): Real, v: Vec3, t: (Real, Vec3), m: [Real; (2)]) -> Real {\n    \
        let s = (a.position).norm() / ((v.norm())) + (-(k)) * (t.0) - (m[(1)]) / (v[0]) + ((t).1.x);\n    \
        let mut c = ((if (k > 0.0) && (!(k < 1.0)) { (k) } else { ((1.0) / k) })) * (({ k }));\n    \
        c /= (k.abs()) + (f2((k), &(v))) * ((2 as Real)) + (([k; 2])[1]) + ((k, k).0) + (Vec3::new(k, k, k)).x;\n    \
        (s) + c / (k.sqrt())\n}\nfn f2(k: Real, v: Vec3) -> Real { (k) * (v.x) }\n";
    let brackets = brackets.replace("(k): Real", "k: Real");
    let mut texts = vec![brackets, PROGRAM.to_owned()];
    for folder in ["constraints", "tests/unseen", "tests/golden"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
        let paths = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        let files = paths.filter(|path| path.extension().is_some_and(|ending| ending == "rs"));
        texts.extend(files.map(|path| std::fs::read_to_string(path).expect("a text")));
    }
    let mut count = 0;
    for text in &texts {
        let file =
            syntax::parse(&Source::new("force.rs", text.as_str())).unwrap_or_else(|wrong| panic!("{wrong}"));
        for expr in file.functions.iter().flat_map(|function| function.expressions.iter()) {
            let place = &text[expr.span.start as usize..expr.span.end as usize];
            assert!(syn::parse_str::<syn::Expr>(place).is_ok(), "`{place}` in\n{text}");
            count += 1;
        }
    }
    assert!(count > 5000, "{count} expressions");
}
