//! The two families of special functions, each order of derivative a primitive of its own.
//!
//! Differentiating (1 − cos t)/t² as it is written loses every digit near t = 0. Here a power series serves where the
//! closed form cancels, and a recurrence elsewhere; both are accurate to a few units of rounding.

/// dⁿ/dsⁿ cos √s for s ≥ 0.
///
/// Series: Σ (−1)^(j+n) (j+n)!/(j! (2j+2n)!) sʲ. Recurrence, from 4s y″ + 2y′ + y = 0 differentiated n times:
/// y⁽ⁿ⁺²⁾ = −(y⁽ⁿ⁾ + (4n+2) y⁽ⁿ⁺¹⁾)/(4s).
pub fn cos_sqrt(n: u32, s: f64) -> f64 {
    if n > 0 && s < cos_sqrt_switch(n) {
        return series(&cos_sqrt_series(n), s);
    }
    let t = s.sqrt();
    let (mut low, mut high) = (t.cos(), -0.5 * t.sin() / t);
    if n == 0 {
        return low;
    }
    for k in 0..n - 1 {
        (low, high) = (high, -(low + f64::from(4 * k + 2) * high) / (4.0 * s));
    }
    high
}

/// Below this s the series of [`cos_sqrt`] is used.
pub fn cos_sqrt_switch(n: u32) -> f64 {
    if n == 1 { 1.0 } else { 16.0 }
}

/// The coefficients of the power series of [`cos_sqrt`], as many as its range needs.
pub fn cos_sqrt_series(n: u32) -> Vec<f64> {
    let terms = if n == 1 { 10 } else { 20 };
    let mut coefficient = (1..=n).fold(1.0, |c, k| -c * f64::from(k) / f64::from((2 * k - 1) * 2 * k));
    let mut series = Vec::new();
    for j in 0..terms {
        series.push(coefficient);
        let k = j + n + 1;
        coefficient *= -f64::from(k) / (f64::from(j + 1) * f64::from((2 * k - 1) * 2 * k));
    }
    series
}

/// ∂ⁿ/∂mⁿ atan2(√m, w)/√m for m ≥ 0.
///
/// With x = m/w² the series for w > 0 is w^(−2n−1) Σ (−1)^(j+n) (j+n)!/(j! (2j+2n+1)) xʲ. Recurrence, from
/// m A′ = ½ (w/(m + w²) − A) differentiated n times:
/// A⁽ⁿ⁺¹⁾ = (½ w (−1)ⁿ n!/(m + w²)^(n+1) − (n + ½) A⁽ⁿ⁾)/m.
pub fn angle_ratio(n: u32, m: f64, w: f64) -> f64 {
    let square = w * w;
    if w > 0.0 && m < ANGLE_RATIO_SWITCH * square {
        let power = (0..n).fold(1.0 / w, |p, _| p / square);
        return power * series(&angle_ratio_series(n), m / square);
    }
    let t = m.sqrt();
    let mut value = t.atan2(w) / t;
    let inverse = 1.0 / (m + square);
    let mut term = 0.5 * w * inverse;
    for k in 0..n {
        value = (term - (f64::from(k) + 0.5) * value) / m;
        term *= -f64::from(k + 1) * inverse;
    }
    value
}

/// Below this m/w² the series of [`angle_ratio`] is used.
pub const ANGLE_RATIO_SWITCH: f64 = 0.25;

/// The coefficients of the power series of [`angle_ratio`].
pub fn angle_ratio_series(n: u32) -> Vec<f64> {
    let mut factor = (1..=n).fold(1.0, |f, k| -f * f64::from(k));
    let mut series = Vec::new();
    for j in 0..28 {
        series.push(factor / f64::from(2 * j + 2 * n + 1));
        factor *= -f64::from(j + n + 1) / f64::from(j + 1);
    }
    series
}

fn series(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}
