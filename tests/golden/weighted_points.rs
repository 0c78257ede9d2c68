// stages: graph
/// Midpoint.
#[energy]
pub fn midpoint(a: Particle, b: Particle, c: Particle, k: Real) -> Real {
    let mid = 0.5 * (a.position + b.position);
    k * (c.position - mid).norm_squared()
}

/// Centroid.
#[energy]
pub fn centroid(a: Particle, b: Particle, c: Particle, k: Real) -> Real {
    let m = (a.position + b.position + c.position) / 3.0;
    let x = a.position - m;
    let y = b.position - m;
    k * (x.norm_squared() - 0.5).powi(2) + k * x.cross(&y).norm_squared()
}

/// Lerp.
#[constraint]
pub fn lerp(a: Particle, b: Particle, c: Particle, t: Real) -> Vec3 {
    let m = a.position + (b.position - a.position) * t;
    c.position - m
}

/// Lerp by weights.
#[constraint]
pub fn weights(a: Particle, b: Particle, c: Particle, t: Real) -> Vec3 {
    let m = a.position * (1.0 - t) + b.position * t;
    c.position - m
}

/// Barycentric.
#[constraint(unilateral)]
pub fn barycentric(p: Particle, a: Particle, b: Particle, c: Particle, u: Real, v: Real) -> Real {
    let w = 1.0 - u - v;
    let q = u * a.position + v * b.position + w * c.position;
    (p.position - q).norm() - 2.5
}

/// Dots.
#[constraint]
pub fn dots(a: Rigid, b: Rigid, n: Vec3) -> Real {
    n.dot(&a.position) - n.dot(&b.position)
}

/// Rotated apart.
#[constraint]
pub fn rotated(a: Rigid, b: Rigid, arm: Vec3) -> Vec3 {
    let la = a.orientation.inverse() * a.position;
    let lb = a.orientation.inverse() * b.position;
    la - lb + arm
}

/// Components.
#[energy]
pub fn components(a: Particle, b: Particle, k: Real) -> Real {
    let dx = a.position.x - b.position.x;
    let dy = a.position[1] - b.position[1];
    let s = (a.position.z + 0.1) - (b.position.z - 0.1);
    k * (dx * dx + 2.0 * dy * dy + s * s)
}

/// Chosen.
#[energy]
pub fn chosen(a: Particle, b: Particle, c: Particle, k: Real, t: Real) -> Real {
    let m = if t < 0.5 { a.position } else { b.position };
    k * (c.position - m).norm_squared()
}

/// Matrix.
#[energy]
pub fn matrix(a: Particle, b: Particle, c: Particle, m: Mat3) -> Real {
    let d = Mat3::from_columns(&[a.position, b.position, c.position]);
    let e = Mat3::from_columns(&[a.position, a.position, a.position]);
    (m * (d - e)).norm_squared()
}

/// Nested sums.
#[energy]
pub fn nested(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3, k: Real) -> Real {
    let pa = a.position + a.orientation * arm_a;
    let pb = b.position + b.orientation * arm_b;
    let mid = (pa + pb) / 2.0;
    k * (pa - mid).norm_squared() + k * (mid - b.position).norm()
}

/// Bilinear patch.
#[energy]
pub fn patch(p: Particle, a: Particle, b: Particle, c: Particle, d: Particle, u: Real, v: Real) -> Real {
    let x = (1.0 - u) * (1.0 - v) * a.position + u * (1.0 - v) * b.position;
    let y = (1.0 - u) * v * d.position + u * v * c.position;
    let x = x + y;
    (x - p.position).norm_squared()
}

/// Stretches.
#[force]
pub fn pulled(a: Particle, b: Particle, k: Real) -> (Vec3, Vec3) {
    let fa = k * a.position;
    let fb = k * b.position;
    (fb - fa, fa - fb)
}

/// Spline.
#[energy]
pub fn spline(a: Particle, b: Particle, c: Particle, d: Particle, p: Particle, t: Real) -> Real {
    let s = 1.0 - t;
    let w0 = s * s * s / 6.0;
    let w1 = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0;
    let w3 = t * t * t / 6.0;
    let w2 = (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0;
    let x = w0 * a.position + w1 * b.position + w2 * c.position + w3 * d.position;
    (x - p.position).norm_squared()
}

/// Height over a triangle along a normal.
#[energy]
pub fn height(p: Particle, a: Particle, b: Particle, c: Particle, n: Vec3, u: Real, v: Real) -> Real {
    let q = u * a.position + v * b.position + (1.0 - u - v) * c.position;
    let h = n.dot(&p.position) - n.dot(&q);
    h * h
}

/// Torques.
#[energy]
pub fn crossed(a: Particle, b: Particle, n: Vec3, m: Mat3) -> Real {
    let h = a.position.cross(&n) - b.position.cross(&n);
    let g = m * a.position - m * b.position;
    h.norm_squared() + g.norm_squared()
}

/// Named products.
#[energy]
pub fn measured(a: Particle, b: Particle, n: Vec3) -> Real {
    let da = n.dot(&a.position);
    let db = n.dot(&b.position);
    let gap = da - db;
    gap * gap
}
