//! Arbitrary text causes no panic, hang or overflow.

use super::{PROGRAM, compile};
use forcec::internals::check;
use forcec::internals::source::diagnostic::Severity;
use forcec::internals::syntax;

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

/// A program that is too large is refused at the loop or call that exceeds the limit, without a long run
/// time; a slightly smaller program is accepted.
#[test]
fn budgets() {
    let started = std::time::Instant::now();
    let refused = |text: &str, place: &str| {
        let message = compile(text).map(|_| ()).unwrap_err().to_string();
        assert!(message.contains(place), "{message}");
    };
    let energy = |body: &str| format!("#[energy]\nfn f(a: Particle, k: Real) -> Real {{ {body} }}\n");
    for size in [12u32, 16, 24, 31] {
        // Calls that share nothing: twice as many with every helper.
        let helpers: String = (0..size)
            .map(|i| format!("fn f{}(x: Real) -> Real {{ f{i}(x) * f{i}(x + {i}.5 * x.cos()) }}\n", i + 1))
            .collect();
        let text = format!(
            "fn f0(x: Real) -> Real {{ x.sin() }}\n{helpers}{}",
            energy(&format!("k * f{size}(a.position.x)"))
        );
        match size {
            12 => assert!(compile(&text).is_ok()),
            _ => refused(&text, &format!("the call of `f{size}` unrolls to more than 250000 nodes")),
        }
        // Calls that share almost everything.
        let helpers: String = (0..size)
            .map(|i| format!("fn f{}(x: Real) -> Real {{ f{i}(x) * f{i}(x + 1.0) }}\n", i + 1))
            .collect();
        let text = format!(
            "fn f0(x: Real) -> Real {{ x.sin() }}\n{helpers}{}",
            energy(&format!("k * f{size}(a.position.x)"))
        );
        assert!(compile(&text).is_ok());
    }
    let body = "{ s = (s * k + a.position.x).sin(); } s";
    refused(
        &energy(&format!("let mut s = k; for i in 0..9_000_000 {body}")),
        "9000000 iterations; at most 1000000",
    );
    refused(
        &energy(&format!("let mut s = k; for i in 0..900_000 {body}")),
        "the loop over `i` unrolls to more than",
    );
    let nothing =
        "let mut n = 0; for i in 0..900_000 { n = (i % 7) * (i % 5) + (i % 3); n += 1; } k * (n as Real)";
    refused(&energy(nothing), "the loop over `i` takes more than 10000000 steps");
    let many: String = (0..300)
        .map(|i| {
            energy(&format!("let mut s = k; for i in 0..900_000 {body}"))
                .replace("fn f(", &format!("fn g{i}("))
        })
        .collect();
    refused(&many, "the loop over `i` unrolls");
    let (_, checked) =
        compile(&energy(&format!("let mut s = k; for i in 0..40_000 {body}"))).expect("it is not too large");
    assert!(checked.definitions[0].graph.len() > 100_000);
    let seconds = started.elapsed().as_secs_f64();
    assert!(seconds < 60.0, "{seconds} s");
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
