//! The problems of the comparison by dual numbers of num-dual, called from C: no derivative is derived before the run.
//!
//! In: a kernel's arguments in their memory order. Out: the force and its derivatives, as the emitted kernels write them.
//! A constraint is evaluated in dual numbers of dual numbers: the inner ones give J, and so F, whose outer parts are
//! ∂F/∂X. Both are seeded with D of the stored coordinates, `D_k q = e_k q / 2` for a quaternion. An energy of particles
//! is evaluated in numbers with a gradient and a Hessian.

use nalgebra::SVector;
use num_dual::{Derivative, Dual2SVec64, DualNum, DualSVec, DualSVec64, DualVec};

type Inner<const N: usize> = DualSVec<DualSVec64<N>, N>;

/// A number of any kind.
trait Number: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

/// A kernel's results.
#[repr(C)]
pub struct Out<const N: usize> {
    force: [f64; N],
    dfdx: [[f64; N]; N],
    dfdv: [[f64; N]; N],
}

/// Where a body is; a particle's orientation is none.
#[derive(Clone, Copy)]
struct Body<T> {
    first: usize,
    position: [T; 3],
    orientation: Option<[T; 4]>,
}

impl<T: Number> Body<T> {
    /// The body with D in its coordinates.
    fn varied<const N: usize>(&self) -> Body<DualSVec<T, N>> {
        let dual = |x: T, row: &[(usize, T)]| {
            let mut eps = SVector::<T, N>::from_element(T::from(0.0));
            for (k, entry) in row {
                eps[self.first + k] = *entry;
            }
            DualVec::new(x, Derivative::some(eps))
        };
        let one = T::from(1.0);
        let position = [0, 1, 2].map(|k| dual(self.position[k], &[(k, one)]));
        let turned = |[x, y, z, w]: [T; 4]| {
            let rows = [(x, [w, z, -y]), (y, [-z, w, x]), (z, [y, -x, w]), (w, [-x, -y, -z])];
            rows.map(|(entry, [a, b, c])| dual(entry, &[(3, a * 0.5), (4, b * 0.5), (5, c * 0.5)]))
        };
        Body { first: self.first, position, orientation: self.orientation.map(turned) }
    }

    /// q v for an orientation, which a rigid body has.
    fn turn(&self, v: &[f64]) -> [T; 3] {
        let zero = T::from(0.0);
        let [x, y, z, w] = self.orientation.unwrap_or([zero, zero, zero, T::from(1.0)]);
        let (u, v) = ([x, y, z], [0, 1, 2].map(|k| T::from(v[k])));
        let t = cross(u, v).map(|entry| entry * 2.0);
        let s = cross(u, t);
        [0, 1, 2].map(|k| v[k] + t[k] * w + s[k])
    }
}

fn cross<T: Number>(v: [T; 3], w: [T; 3]) -> [T; 3] {
    [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]]
}

fn dot<T: Number>(v: [T; 3], w: [T; 3]) -> T {
    v[0] * w[0] + v[1] * w[1] + v[2] * w[2]
}

fn sub<T: Number>(v: [T; 3], w: [T; 3]) -> [T; 3] {
    [0, 1, 2].map(|k| v[k] - w[k])
}

/// Bodies from their structs, six or thirteen numbers each, and their velocities.
fn read<const N: usize, const B: usize, const L: usize>(
    structs: [&[f64; L]; B],
) -> ([Body<f64>; B], [f64; N]) {
    let dofs = N / B;
    let mut velocity = [0.0; N];
    let mut bodies = [Body { first: 0, position: [0.0; 3], orientation: None }; B];
    for (i, values) in structs.iter().enumerate() {
        let position = [values[0], values[1], values[2]];
        let orientation = (dofs == 6).then(|| [3, 4, 5, 6].map(|k| values[k]));
        bodies[i] = Body { first: i * dofs, position, orientation };
        velocity[i * dofs..(i + 1) * dofs].copy_from_slice(&values[L - dofs..]);
    }
    (bodies, velocity)
}

/// F = −Jᵀ (ks C + kd J V) and its derivatives.
fn penalty<const N: usize, const B: usize, const L: usize, const R: usize>(
    structs: [&[f64; L]; B],
    (stiffness, damping): (f64, f64),
    rows: impl Fn([Body<Inner<N>>; B]) -> [Inner<N>; R],
    out: &mut Out<N>,
) {
    let (bodies, velocity) = read::<N, B, L>(structs);
    let rows = rows(bodies.map(|body| body.varied::<N>().varied::<N>()));
    let zero = DualSVec64::<N>::from(0.0);
    let mut force = [zero; N];
    out.dfdv = [[0.0; N]; N];
    for row in rows {
        let jacobian = row.eps.0.unwrap_or_else(|| SVector::from_element(zero));
        let rate = jacobian.iter().zip(velocity).fold(zero, |sum, (entry, v)| sum + *entry * v);
        let tension = row.re * stiffness + rate * damping;
        for i in 0..N {
            force[i] -= jacobian[i] * tension;
            for j in 0..N {
                out.dfdv[i][j] -= damping * jacobian[i].re * jacobian[j].re;
            }
        }
    }
    for (i, entry) in force.iter().enumerate() {
        out.force[i] = entry.re;
        out.dfdx[i] = entry.eps.0.map_or([0.0; N], |eps| eps.into());
    }
}

/// F = −D E of particles and its derivatives.
fn gradient<const N: usize, const B: usize>(
    structs: [&[f64; 6]; B],
    energy: impl Fn([[Dual2SVec64<N>; 3]; B]) -> Dual2SVec64<N>,
    out: &mut Out<N>,
) {
    let mut positions = structs.map(|values| [0, 1, 2].map(|k| Dual2SVec64::<N>::from(values[k])));
    for (i, position) in positions.iter_mut().enumerate() {
        for (k, entry) in position.iter_mut().enumerate() {
            let mut row = nalgebra::RowSVector::<f64, N>::zeros();
            row[3 * i + k] = 1.0;
            entry.v1 = Derivative::some(row);
        }
    }
    let energy = energy(positions);
    out.dfdv = [[0.0; N]; N];
    let (first, second) = (
        energy.v1.0.unwrap_or_else(nalgebra::RowSVector::<f64, N>::zeros),
        energy.v2.0.unwrap_or_else(nalgebra::SMatrix::<f64, N, N>::zeros),
    );
    for i in 0..N {
        out.force[i] = -first[i];
        for j in 0..N {
            out.dfdx[i][j] = -second[(i, j)];
        }
    }
}

/// pb − pa of two anchors.
fn gap<T: Number>([a, b]: &[Body<T>; 2], arm_a: &[f64], arm_b: &[f64]) -> [T; 3] {
    let (d, rb, ra) = (sub(b.position, a.position), b.turn(arm_b), a.turn(arm_a));
    [0, 1, 2].map(|k| d[k] + rb[k] - ra[k])
}

/// A ball joint.
#[unsafe(no_mangle)]
pub extern "C" fn dual_point_to_point(a: &[f64; 13], b: &[f64; 13], p: &[f64; 8], out: &mut Out<12>) {
    penalty([a, b], (p[6], p[7]), |bodies| gap(&bodies, &p[..3], &p[3..6]), out);
}

/// A rod.
#[unsafe(no_mangle)]
pub extern "C" fn dual_distance(a: &[f64; 13], b: &[f64; 13], p: &[f64; 9], out: &mut Out<12>) {
    let rows = |bodies: [Body<Inner<12>>; 2]| {
        let gap = gap(&bodies, &p[..3], &p[3..6]);
        [dot(gap, gap).sqrt() - p[6]]
    };
    penalty([a, b], (p[7], p[8]), rows, out);
}

/// A hinge.
#[unsafe(no_mangle)]
pub extern "C" fn dual_hinge(a: &[f64; 13], b: &[f64; 13], p: &[f64; 17], out: &mut Out<12>) {
    let rows = |bodies: [Body<Inner<12>>; 2]| {
        let [x, y, z] = gap(&bodies, &p[..3], &p[3..6]);
        let axis = bodies[0].turn(&p[6..9]);
        let (n1, n2) = (bodies[1].turn(&p[9..12]), bodies[1].turn(&p[12..15]));
        [x, y, z, dot(axis, n1), dot(axis, n2)]
    };
    penalty([a, b], (p[15], p[16]), rows, out);
}

/// A spring of two particles.
#[unsafe(no_mangle)]
pub extern "C" fn dual_spring(p0: &[f64; 6], p1: &[f64; 6], p: &[f64; 3], out: &mut Out<6>) {
    let rows = |[a, b]: [Body<Inner<6>>; 2]| {
        let d = sub(b.position, a.position);
        [dot(d, d).sqrt() - p[0]]
    };
    penalty([p0, p1], (p[1], p[2]), rows, out);
}

/// A tetrahedron after Neo and Hooke.
#[unsafe(no_mangle)]
pub extern "C" fn dual_neo_hookean(
    p0: &[f64; 6],
    p1: &[f64; 6],
    p2: &[f64; 6],
    p3: &[f64; 6],
    p: &[f64; 12],
    out: &mut Out<12>,
) {
    let energy = |[x0, x1, x2, x3]: [[Dual2SVec64<12>; 3]; 4]| {
        let (e1, e2, e3) = (sub(x1, x0), sub(x2, x0), sub(x3, x0));
        let f = [0, 1, 2].map(|c| [0, 1, 2].map(|k| e1[k] * p[c] + e2[k] * p[3 + c] + e3[k] * p[6 + c]));
        let stretch = dot(f[0], f[0]) + dot(f[1], f[1]) + dot(f[2], f[2]);
        let log_j = dot(f[0], cross(f[1], f[2])).ln();
        ((stretch - 3.0) * (0.5 * p[10]) - log_j * p[10] + log_j * log_j * (0.5 * p[11])) * p[9]
    };
    gradient([p0, p1, p2, p3], energy, out);
}

/// Bending of two triangles.
#[unsafe(no_mangle)]
pub extern "C" fn dual_dihedral(
    p0: &[f64; 6],
    p1: &[f64; 6],
    p2: &[f64; 6],
    p3: &[f64; 6],
    p: &[f64; 2],
    out: &mut Out<12>,
) {
    let energy = |[x0, x1, x2, x3]: [[Dual2SVec64<12>; 3]; 4]| {
        let (edge, side_a, side_b) = (sub(x1, x0), sub(x2, x0), sub(x3, x0));
        let (na, nb) = (cross(edge, side_a), cross(side_b, edge));
        let turn = (dot(edge, edge).sqrt() * dot(side_b, na)).atan2(dot(na, nb)) - p[1];
        turn * turn * (0.5 * p[0])
    };
    gradient([p0, p1, p2, p3], energy, out);
}

/// A triangle after St. Venant and Kirchhoff.
#[unsafe(no_mangle)]
pub extern "C" fn dual_stvk_triangle(
    p0: &[f64; 6],
    p1: &[f64; 6],
    p2: &[f64; 6],
    p: &[f64; 7],
    out: &mut Out<9>,
) {
    let energy = |[x0, x1, x2]: [[Dual2SVec64<9>; 3]; 3]| {
        let (e1, e2) = (sub(x1, x0), sub(x2, x0));
        let [wu, wv] = [0, 1].map(|c| [0, 1, 2].map(|k| e1[k] * p[c] + e2[k] * p[2 + c]));
        let (uu, vv, uv) = ((dot(wu, wu) - 1.0) * 0.5, (dot(wv, wv) - 1.0) * 0.5, dot(wu, wv) * 0.5);
        let trace = uu + vv;
        ((uu * uu + vv * vv + uv * uv * 2.0) * p[5] + trace * trace * (0.5 * p[6])) * p[4]
    };
    gradient([p0, p1, p2], energy, out);
}
