//! Shapes that remember themselves, written with matrices on purpose.
//!
//! Tried here: an array of bodies as a helper's argument; `(i + j) as Real`; entries of matrices by loop
//! variables; unary minus on a matrix.

use forcec_runtime::prelude::*;

/// The matrix whose columns lead from the first point to the other three.
fn edges(p: [Particle; 4]) -> Mat3 {
    let units = [Vec3::x(), Vec3::y(), Vec3::z()];
    let mut columns = Mat3::identity() * 0.0;
    for k in 0..3 {
        columns += (p[k + 1].position - p[0].position).outer(&units[k]);
    }
    columns
}

/// As rigid as possible about a given turn: a star of three edges against their rest shape.
#[energy]
#[domain(weights = 0.1..1.0)]
pub fn rigid_star(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    p3: Particle,
    rest: Mat3,
    turn: Quat,
    weights: Vec3,
) -> Real {
    let now = edges([p0, p1, p2, p3]);
    let expected = turn.to_rotation_matrix().into_inner() * rest;
    let weighed = (now - expected) * Mat3::from_diagonal(&weights);
    0.5 * weighed.norm_squared() + 0.1 * (now * rest.inverse()).determinant().powi(2)
}

/// Triangle in the plane z = 0 with a fibre: strain as a 2×2 matrix.
#[energy]
#[domain(stiff = 1.0..10.0, fibre = unit)]
pub fn plane_triangle(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    rest: Mat2,
    stiff: Real,
    fibre: Vec2,
) -> Real {
    let e1 = p1.position - p0.position;
    let e2 = p2.position - p0.position;
    let now = Mat2::new(e1.x, e2.x, e1.y, e2.y);
    let gradient = now * rest.inverse();
    let strain = (gradient.transpose() * gradient - Mat2::identity()) / 2.0;
    let along = (fibre.outer(&fibre) * strain).trace();
    let shape = Mat2::from_columns(&[Vec2::x(), Vec2::y()]) + Mat2::from_diagonal(&Vec2::new(0.0, 1.0));
    let area = gradient.determinant() - 1.0;
    0.5 * stiff * ((strain * shape).norm_squared() + 3.0 * along * along) + area * area * strain[(0, 1)]
}

/// Box whose faces are planes (a, b, c, d) and whose corner is pushed back inside.
#[constraint(unilateral, per_row)]
pub fn corner_in_box(corner: Rigid, arm: Vec3, planes: [Vec4; 4]) -> (Vec3, Real) {
    let x = corner.position + corner.orientation * arm;
    let point = Vec4::new(x.x, x.y, x.z, 1.0);
    let first = Vec3::new(planes[0].dot(&point), planes[1].dot(&point), planes[2].dot(&point));
    let last = planes[3].component_mul(&point);
    (first, last.x + last.y + last.z + last.w)
}

/// Frame of a hull against another: rows of one, columns of the other, and a metric given by its entries.
#[energy]
#[domain(entries = 0.5..1.5)]
pub fn frame_mismatch(a: Rigid, b: Rigid, entries: [Mat2; 2], shear: Mat3) -> Real {
    let u = a.orientation * Vec3::x();
    let v = a.orientation * Vec3::y();
    let w = u.cross(&v);
    let rows = Mat3::from_rows(&[u.transpose(), v.transpose(), w.transpose()]);
    let columns = Mat3::from_columns(&[
        b.orientation * Vec3::x(),
        b.orientation * Vec3::y(),
        b.orientation * Vec3::z(),
    ]);
    let mixed = rows * columns * shear;
    let mut energy = 0.0;
    for k in 0..2 {
        let small = Mat2::from_rows(&[
            Vec2::new(mixed[(0, k)], mixed[(1, k)]).transpose(),
            Vec2::new(mixed[(k, 2)], 1.0).transpose(),
        ]);
        let metric = -small * entries[k] * small.transpose();
        for i in 0..2 {
            for j in 0..2 {
                energy += metric[(i, j)] * entries[k][(j, i)] / (1.0 + (i + j) as Real);
            }
        }
    }
    let minor = Mat3::new(1.0, u.x, 0.0, v.y, 2.0, w.z, 0.0, 0.5, 3.0);
    energy + minor.determinant() + (minor.inverse() * (a.position - b.position)).norm_squared()
}
