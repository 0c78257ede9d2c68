//! Names that other languages keep for themselves, shadowing, nesting and every comparison.
//!
//! Tried here: a constant vector; helpers named like methods; shadowing; a block as a value; bodies and
//! parameters named after keywords and after what kernels hold.

use forcec_runtime::prelude::*;

const HALF: Real = 0.5;
const TINY: Real = 1e-6 * HALF;
const MANY: Real = 1_000.0;
const UP: Vec3 = Vec3::new(0.0, 0.0, 1.0);

/// A helper that shares its name with a method, and whose argument shares its name with a body.
fn norm(a: Vec3) -> Real {
    let a = a.component_mul(&a);
    (a.x + a.y + a[2] + TINY).sqrt()
}

/// Bodies in, an array out.
fn ends(bodies: (Rigid, Particle), arms: &[Vec3; 2]) -> [Vec3; 3] {
    let (body, point) = bodies;
    let start = body.position + body.orientation * arms[0];
    let end = body.position + body.orientation * arms[1];
    [start, end, point.position]
}

/// A wrench made in a helper.
fn push_at(force: Vec3, r: Vec3) -> Wrench {
    Wrench { force, torque: r.cross(&force) }
}

/// Keywords of C and C++ as parameters, and bodies named after what every kernel already has.
#[force]
#[domain(double = 0.1..1.0, int = 0.1..1.0, register = 0.5..1.5, class = -1.0..1.0)]
pub fn volatile(
    out: Rigid,
    params: Particle,
    double: Real,
    int: Real,
    register: Vec3,
    class: [Real; 2],
    stiffness: Real,
) -> (Wrench, Vec3) {
    let x = params.position - out.position;
    let force = x * (stiffness * double) + register * (int * class[0]);
    let dfdx = {
        let x = norm(x);
        let force = x.recip() * class[1];
        force + x
    };
    let t0 = register.norm() * dfdx;
    let force = force * t0 + params.velocity - out.velocity;
    (push_at(force, x.cross(&UP)), -force)
}

/// Every comparison, nested, over tuples and vectors.
#[energy]
#[domain(level = -1.0..1.0)]
#[allow(uncovered, reason = "no state drawn makes y exactly zero")]
pub fn new(this: Rigid, delete: Particle, level: Real, arms: [Vec3; 2]) -> Real {
    let (start, (end, point)) = (level, (level * 2.0, level * 3.0));
    let corners = ends((this, delete), &arms);
    let y = (corners[2] - corners[0]).dot(&(corners[2] - corners[1]));
    let (scale, offset) = if y > level && y >= start || !(y < end) {
        if y == 0.0 {
            (1.0, 0.0)
        } else if y != point && level <= 0.0 {
            (2.0, -y)
        } else {
            let (scale, (offset, _)) = (y, (scale_of(y), 3.0));
            (offset, scale)
        }
    } else {
        (HALF, 2.5e+1 / MANY)
    };
    let side = if scale < 1.0 { Vec3::x() } else { UP };
    scale * y * y + offset + (corners[2] - corners[0]).dot(&side)
}

fn scale_of(y: Real) -> Real {
    y.signum() * (1.0 + y.abs()).ln().cbrt().min(MANY)
}

/// Rows that do not depend on some bodies, a constant row, and the same row twice.
#[constraint]
pub fn union(a: Particle, b: Particle, c: Rigid, switch: Vec2) -> (Real, Vec4, Real, Real) {
    let edge = b.position - a.position;
    let row = edge.norm_squared() - switch.x;
    let mut sum = Vec2::zeros();
    sum += switch;
    sum *= 2.0;
    sum -= Vec2::y();
    sum /= 4.0;
    let mut four = Vec4::zeros();
    four += Vec4::new(edge.x, edge.y, edge.z, sum.dot(&switch));
    (row, four, c.position.z - sum.norm(), row)
}
