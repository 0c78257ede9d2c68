//! Constants out of bounds, and values that a precision cannot represent: a correct value, or a message at
//! the right place.

use forcec::{Layout, Options, Precision};

/// The kernel of `e` in C.
fn kernel(text: &str, options: &Options) -> String {
    match forcec::compile(text, options) {
        Ok(compiled) => compiled.kernel("e").to_owned(),
        Err(errors) => panic!("{text}\n{errors}"),
    }
}

/// The error message.
fn refused(text: &str, options: &Options) -> String {
    match forcec::compile(text, options) {
        Ok(compiled) => panic!("{text}\n{compiled}"),
        Err(errors) => errors.to_string(),
    }
}

fn single() -> Options {
    Options { real: Precision::F32, ..Options::default() }
}

/// An energy of a particle `a` and a parameter `k`.
fn energy(body: &str) -> String {
    format!("#[energy]\npub fn e(a: Particle, k: Real) -> Real {{\n    {body}\n}}\n")
}

/// The coefficient of −∂E/∂x of an energy that is a multiple of `a.position.x`.
fn coefficient(body: &str, options: &Options) -> f64 {
    let text = kernel(&energy(body), options);
    let line = text.lines().find_map(|line| line.trim().strip_prefix("out->force[0] = "));
    let number = line.expect("F is stored").trim_end_matches(';').trim_end_matches('f');
    -number.parse::<f64>().unwrap_or_else(|_| panic!("{number} is a number"))
}

#[test]
fn constants_fold_within_bounds() {
    let plain = Options::default();
    let root = "let mut z = 1.0; for _i in 0..25 { z = 0.5 * (z + 2.0 / z); } z * a.position.x";
    assert_eq!(coefficient(root, &plain), 2f64.sqrt());
    let limit = "let mut x = 0.1; for _i in 0..20000 { x = x / 3.0 + 1.0 / 7.0; } x * a.position.x";
    assert_eq!(coefficient(limit, &plain), 3.0 / 14.0);
    let close = "let z = 1.0000000001; z.powi(1000000000) * a.position.x";
    assert!((coefficient(close, &plain) - 1.105170918070122_f64).abs() < 1e-12);
    let squared = "let mut z = 1.0000000001; for _i in 0..30 { z = z * z; } z * a.position.x";
    assert!((coefficient(squared, &plain) - (2f64.powi(30) * 1e-10).exp()).abs() < 1e-9);
    let vector = "let mut v = a.position; for _i in 0..2000 { v = v / 3.0 + a.position / 7.0; } v.x";
    assert_eq!(coefficient(vector, &plain), 3.0 / 14.0);
    for beyond in [
        "let z = 1.1; z.powi(2000000000) * a.position.x",
        "let z = 0.5; z.powi(-2147483648) * a.position.x",
        "let mut z = 1.1; for _i in 0..60 { z = z * z; } z * a.position.x",
        "let mut v = a.position; for _i in 0..6000 { v = v * 0.5; } v.x",
    ] {
        let message = refused(&energy(beyond), &plain);
        assert!(message.contains("a constant is out of range") && message.contains("^"), "{message}");
    }
    // A scaled base is raised to the power as a whole if the power of the factor alone would leave the range:
    // in every precision, for any exponent.
    for (number, power) in [("3.4e-10", 50), ("3.4e-10", 2147483647), ("0.5", 2147483647)] {
        let text = kernel(&energy(&format!("k * (a.position.x * {number}).powi({power})")), &single());
        assert!(text.contains(&format!("{number}f * a->position[0]")), "{text}");
    }
}

#[test]
fn weights_of_any_power_are_balanced() {
    let curve = |weights: [&str; 5], end: &str| {
        let points = ["a", "b", "c", "d", "e"];
        let sum = points.iter().zip(weights).map(|(p, w)| format!("{p}.position * ({w})"));
        format!(
            "#[constraint]\npub fn e(a: Particle, b: Particle, c: Particle, d: Particle, e: Particle, t: Real) -> Vec3 {{\n    \
             let s = 1.0 - t;\n    {}{end}\n}}\n",
            sum.collect::<Vec<String>>().join(" + ")
        )
    };
    let weights =
        ["s.powi(4)", "4.0 * t * s.powi(3)", "6.0 * t * t * s * s", "4.0 * t.powi(3) * s", "t.powi(4)"];
    // The weights add up to one: with a point of the world, each position is first subtracted from another
    // position.
    let text = kernel(&curve(weights, " - a.position"), &Options::default());
    assert!(text.contains("e_minus_a_x = e->position[0] - a_p_x"), "{text}");
    kernel(&curve(weights, ""), &Options::default());
    for weights in
        ["1.0 + t.powi(4)|t * t.powi(4) - 1.0", "t.powi(9)|-t.powi(9)", "(1.0 + t).powi(8)|(t - 1.0).powi(8)"]
    {
        let (first, second) = weights.split_once('|').expect("two weights");
        let text = format!(
            "#[constraint]\npub fn e(a: Particle, b: Particle, t: Real) -> Vec3 {{\n    a.position * ({first}) + b.position * ({second})\n}}\n"
        );
        kernel(&text, &Options::default());
    }
}

#[test]
fn a_set_step_is_prepared() {
    let text = "#[constraint]\npub fn e(p: Particle, n: Vec3) -> Real {\n    n.dot(&p.position)\n}\n";
    let options = Options {
        layout: Layout::named("system").expect("a layout"),
        prepare: true,
        set: vec![("step".to_owned(), vec![0.01])],
        ..Options::default()
    };
    let compiled = forcec::compile(text, &options).expect("it compiles");
    assert!(compiled.kernel("e_set_step_system").contains("step"));
}

#[test]
fn numbers_fit_their_precision() {
    let double = Options::default();
    // Constants are refused at their place, and allowed where the precision can represent them.
    for (body, place) in [
        ("(a.position.norm_squared() + 1e-30 * 1e-30).sqrt()", "^^^^^^^^^^^^^ 1e-60 is 0 as `f32`"),
        ("a.position.x / 1e-45", "^^^^^ its inverse 1e45 is infinite as `f32`"),
        ("a.position.x * 1e30 * 1e30", "^^^^^^^^^^^^^^^^^^^^^^^^^^ 1e60 is infinite as `f32`"),
        ("(a.position.x - 1e-40).exp()", "^^^^^ 1e-40 is a subnormal of few digits as `f32`"),
        ("if a.position.x < 1e-50 { k * a.position.y } else { 0.0 }", "^^^^^ 1e-50 is 0 as `f32`"),
    ] {
        let message = refused(&energy(body), &single());
        assert!(message.contains("does not fit `f32`") && message.contains(place), "{message}");
        assert!(message.contains("build for `f64`"), "{message}");
        kernel(&energy(body), &double);
    }
    let message = refused(&energy("a.position.x + (a.position.y + 1e-300 * 1e-300).exp()"), &double);
    assert!(message.contains("about 1e-599 is 0 as `f64`"), "{message}");
    let set = Options { set: vec![("k".to_owned(), vec![1e-60])], ..single() };
    let message = refused(&energy("k * a.position.x"), &set);
    assert!(message.contains("`k` is set to a number that does not fit `f32`"), "{message}");
    let set = Options { real: Precision::F64, ..set };
    assert!(forcec::compile(&energy("k * a.position.x"), &set).is_ok());
    // Folded where only the product is needed, and separated again.
    assert_eq!(coefficient("1e-60 * a.position.x * 1e30 * 1e25", &single()) as f32, 1e-5);
    for fma in [false, true] {
        let options = Options { fma, outputs: forcec::Part::chosen(["force"]).expect("a name"), ..single() };
        let text = kernel(&energy("1e-60 * a.position.x * a.position.y * a.position.z * k"), &options);
        assert!(!text.contains(" 0.0f *") && !text.contains("HUGE"), "{text}");
        assert!(text.contains("e-31f") || text.contains("e-30f"), "{text}");
    }
}

/// A long but simple function compiles quickly; a function that is too long is refused at its place.
#[test]
fn long_inputs() {
    let started = std::time::Instant::now();
    let name = "n".repeat(65_536);
    let message = refused(
        &format!("#[energy]\npub fn {name}(a: Particle) -> Real {{ a.position.x }}\n"),
        &Options::default(),
    );
    assert!(message.contains("a name is too long"), "{}", &message[..200]);
    let parameters: String = (0..30_000).map(|k| format!(", k{k}: Real")).collect();
    let text = format!("#[energy]\npub fn e(a: Particle{parameters}) -> Real {{ k7 * a.position.x }}\n");
    let message = refused(&text, &Options::default());
    assert!(message.contains("a function has too many arguments"), "{}", &message[..200]);
    let lets: String = (0..20_000).map(|k| format!("let t{k} = k + {k}.0;\n    ")).collect();
    let compiled = forcec::compile(&energy(&format!("{lets}t7 * a.position.x")), &Options::default());
    let warnings = compiled.expect("it compiles").warnings;
    assert_eq!(warnings.list.len(), 19_999);
    assert!(warnings.to_string().contains(" --> forces.rs:20002:9"));
    // Derivatives of a chain of norms exceed the size limit of a program.
    for (count, fits) in [(4, true), (100, false)] {
        let chain = format!(
            "let mut v = a.position; for _i in 0..{count} {{ v = v - v * v.norm() * 0.1 + q * v; }} v.x"
        );
        let text = format!("#[energy]\npub fn e(a: Particle, q: Mat3) -> Real {{ {chain} }}\n");
        match forcec::compile(&text, &Options::default()) {
            Ok(_) => assert!(fits),
            Err(errors) => {
                assert!(!fits && errors.to_string().contains("more than 500000 operations"), "{errors}")
            }
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    assert!(seconds < 60.0, "{seconds} s");
}
