//! What is wrong, or deserves a look, gets its message.
//!
//! A wrong input is a file `tests/wrong/NAME.rs` with its message in `NAME.stderr`; `FORCEC_BLESS=1` writes messages.

use super::accepted;
use forcec::check;
use forcec::diagnostic::Diagnostics;
use forcec::span::Source;
use forcec::syntax;
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
