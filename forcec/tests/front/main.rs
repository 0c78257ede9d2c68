//! The front end on texts.

mod any_text;
mod bounds;
mod hostile;
mod meaning;
mod messages;
mod values;
mod wrong;

use forcec::internals::check::{self, Checked};
use forcec::internals::source::diagnostic::Diagnostics;
use forcec::internals::source::span::Source;
use forcec::internals::syntax::{self, ast};

/// Parses and checks a text.
fn compile(text: &str) -> Result<(ast::File, Checked), Diagnostics> {
    let file = syntax::parse(&Source::new("force.rs", text))?;
    let checked = check::check(&file)?;
    Ok((file, checked))
}

fn accepted(text: &str) -> (ast::File, Checked) {
    compile(text).unwrap_or_else(|diagnostics| panic!("{text}\n{diagnostics}"))
}

/// Most of what the language has.
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
