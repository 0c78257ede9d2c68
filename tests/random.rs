//! Random force functions of every operator and of functions that are no rounded polynomials, from a seed.
//!
//! In: a number. Out: the text of a function of that number. The build script compiles them as Rust over nalgebra, and
//! `tests/originals.rs` compares their bits with kernels of mode `strict`.

#[allow(dead_code, reason = "only numbers below a limit are drawn here")]
#[path = "../forcec/src/math/random.rs"]
mod generator;

use generator::Random;

fn choose(random: &mut Random, texts: &[&'static str]) -> &'static str {
    texts[random.below(texts.len())]
}

/// `$r` and `$v` are a real and a vector of less depth.
const REALS: [&str; 20] = [
    "($r + $r)",
    "($r - $r)",
    "($r * $r)",
    "($r / (1.5 + ($r).powi(2)))",
    "(1.0 / (1.5 + ($r).powi(4)) * $r)",
    "(-$r)",
    "(($r - 1000.0) / 3.0)",
    "(2.0 * $r)",
    "($r).sin()",
    "(($r).cos()).exp()",
    "(($r).abs() + 0.5).sqrt()",
    "(0.5 + ($r).powi(2)).ln()",
    "(1.5 + ($r).sin()).powf(1.5)",
    "($r).powi(3)",
    "(2.0 + ($r).powi(2)).powi(-2)",
    "($r).max($r)",
    "(if $r < $r { $r } else { $r })",
    "($v).dot(&$v)",
    "($v).norm_squared()",
    "($v).norm()",
];

const VECTORS: [&str; 9] = [
    "($v + $v)",
    "($v - $v)",
    "($v * $r)",
    "($v).cross(&$v)",
    "(a.orientation * $v)",
    "(m * $v)",
    "(-$v)",
    "($v / 3.0)",
    "(a.orientation.inverse() * $v)",
];

fn expression(random: &mut Random, depth: u32, vector: bool) -> String {
    if depth == 0 || random.below(8) == 0 {
        let leaves: &[&str] = if vector {
            &["a.position", "b.position", "(b.position - a.position)", "u", "<w>"]
        } else {
            &["h", "k", "s", "u.y", "a.position.x", "b.position.z", "m[(0, 1)]", "<t>"]
        };
        return choose(random, leaves).to_owned();
    }
    let template = choose(random, if vector { &VECTORS } else { &REALS });
    let mut text = String::new();
    let mut rest = template;
    while let Some(at) = rest.find('$') {
        text.push_str(&rest[..at]);
        text.push_str(&expression(random, depth - 1, rest[at..].starts_with("$v")));
        rest = &rest[at + 2..];
    }
    text + rest
}

/// The text of the function of a number; it is called `random_N`.
pub(crate) fn function(number: u64) -> String {
    let mut random = Random::new(number.wrapping_mul(0x5851_f42d_4c95_7f2d));
    let kind = choose(&mut random, &["energy", "constraint"]);
    // What is read before the names exist reads arguments in their place.
    let open = |text: String| text.replace("<t>", "k").replace("<w>", "u");
    let t = open(expression(&mut random, 2, false));
    let w = open(expression(&mut random, 2, true));
    let value = expression(&mut random, 4, false).replace("<t>", "t").replace("<w>", "w");
    format!(
        "#[{kind}]\npub fn random_{number}(a: Rigid, b: Particle, k: Real, s: Real, u: Vec3, m: Mat3) -> Real {{\n    \
         let h: Real = 0.7;\n    let t: Real = {t};\n    let w = {w};\n    {value}\n}}\n"
    )
}
