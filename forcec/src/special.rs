//! The two families of special functions, each order of derivative a primitive of its own.
//!
//! Differentiating (1 − cos t)/t² as it is written loses every digit near t = 0. Here a power series serves where the
//! closed form cancels (`near`), and a recurrence elsewhere (`far`); both are accurate to a few units of rounding of a
//! double. Written over any [`Arithmetic`], so that the targets print the very computation that is evaluated here.

use crate::exact::Exact;
use crate::number::{Arithmetic, Number};
use crate::ops::Function;
use crate::vector::Comparison;
use std::sync::OnceLock;

/// dⁿ/dsⁿ cos √s for s ≥ 0.
pub fn cos_sqrt<N: Number>(n: u32, s: N) -> N {
    match cos_sqrt_switch(n) {
        Some(switch) if N::holds(Comparison::Less, &s, &N::exact(&switch)) => cos_sqrt_near(n, s),
        _ => cos_sqrt_far(n, s),
    }
}

/// Below this s [`cos_sqrt_near`] is used; `None` where the closed form always serves.
pub fn cos_sqrt_switch(n: u32) -> Option<Exact> {
    match n {
        0 => None,
        1 => Some(Exact::ONE),
        _ => Some(Exact::from(16)),
    }
}

/// [`cos_sqrt`] by its power series.
pub fn cos_sqrt_near<N: Arithmetic>(n: u32, s: N) -> N {
    static SERIES: Table = Table::new();
    horner(SERIES.row(n, |n| cos_sqrt_series(n, if n == 1 { 10 } else { 20 })), s)
}

/// [`cos_sqrt`] by recurrence, from 4s y″ + 2y′ + y = 0 differentiated n times:
/// y⁽ⁿ⁺²⁾ = −(y⁽ⁿ⁾ + (4n+2) y⁽ⁿ⁺¹⁾)/(4s).
pub fn cos_sqrt_far<N: Arithmetic>(n: u32, s: N) -> N {
    let t = N::call(Function::Sqrt, std::slice::from_ref(&s));
    if n == 0 {
        return N::call(Function::Cos, &[t]);
    }
    let t = t.named("t");
    let sine = N::call(Function::Sin, std::slice::from_ref(&t));
    let mut high = N::exact(&Exact::ratio(-1, 2)) * sine / t.clone();
    if n == 1 {
        return high;
    }
    let mut low = N::call(Function::Cos, &[t]).named("y_0");
    for k in 0..n - 1 {
        high = high.named(&format!("y_{}", k + 1));
        let factor = N::exact(&Exact::from(i64::from(4 * k + 2)));
        let next = -(low + factor * high.clone()) / (N::exact(&Exact::from(4)) * s.clone());
        (low, high) = (high, next);
    }
    high
}

/// The first coefficients of the power series of [`cos_sqrt`]: Σ (−1)^(j+n) (j+n)!/(j! (2j+2n)!) sʲ.
pub fn cos_sqrt_series(n: u32, terms: u32) -> Vec<Exact> {
    let ratio = |k: u32, j: u32| Exact::ratio(-i64::from(k), u64::from(j) * u64::from((2 * k - 1) * 2 * k));
    let mut coefficient = (1..=n).fold(Exact::ONE, |c, k| &c * &ratio(k, 1));
    let mut series = Vec::new();
    for j in 0..terms {
        let next = &coefficient * &ratio(j + n + 1, j + 1);
        series.push(std::mem::replace(&mut coefficient, next));
    }
    series
}

/// ∂ⁿ/∂mⁿ atan2(√m, w)/√m for m ≥ 0.
pub fn angle_ratio<N: Number>(n: u32, m: N, w: N) -> N {
    let zero = N::exact(&Exact::ZERO);
    let bound = N::exact(&angle_ratio_switch()) * w.clone() * w.clone();
    if N::holds(Comparison::Less, &zero, &w) && N::holds(Comparison::Less, &m, &bound) {
        angle_ratio_near(n, m, w)
    } else {
        angle_ratio_far(n, m, w)
    }
}

/// Below this m/w², and for w > 0, [`angle_ratio_near`] is used.
pub fn angle_ratio_switch() -> Exact {
    Exact::ratio(1, 4)
}

/// [`angle_ratio`] by its power series in x = m/w²: w^(−2n−1) Σ (−1)^(j+n) (j+n)!/(j! (2j+2n+1)) xʲ.
pub fn angle_ratio_near<N: Arithmetic>(n: u32, m: N, w: N) -> N {
    let square = (w.clone() * w.clone()).named("square");
    static SERIES: Table = Table::new();
    let series = SERIES.row(n, |n| angle_ratio_series(n, 28));
    let sum = horner(series, (m / square.clone()).named("x"));
    (0..n).fold(sum / w, |value, _| value / square.clone())
}

/// [`angle_ratio`] by recurrence, from m A′ = ½ (w/(m + w²) − A) differentiated n times:
/// A⁽ⁿ⁺¹⁾ = (½ w (−1)ⁿ n!/(m + w²)^(n+1) − (n + ½) A⁽ⁿ⁾)/m.
pub fn angle_ratio_far<N: Arithmetic>(n: u32, m: N, w: N) -> N {
    let half = |numerator: u32| N::exact(&Exact::ratio(i64::from(numerator), 2));
    let t = N::call(Function::Sqrt, std::slice::from_ref(&m)).named("t");
    let mut value = N::call(Function::Atan2, &[t.clone(), w.clone()]) / t;
    if n == 0 {
        return value;
    }
    let norm = (m.clone() + w.clone() * w.clone()).named("norm_squared");
    let mut term = half(1) * w / norm.clone();
    for k in 0..n {
        if k > 0 {
            term = N::exact(&Exact::from(-i64::from(k))) * term / norm.clone();
        }
        term = term.named(&format!("term_{k}"));
        value = value.named(&format!("a_{k}"));
        value = (term.clone() - half(2 * k + 1) * value) / m.clone();
    }
    value
}

/// The first coefficients of the power series of [`angle_ratio`].
pub fn angle_ratio_series(n: u32, terms: u32) -> Vec<Exact> {
    let mut factor = (1..=n).fold(Exact::ONE, |f, k| &f * &Exact::from(-i64::from(k)));
    let mut series = Vec::new();
    for j in 0..terms {
        series.push(&factor * &Exact::ratio(1, u64::from(2 * j + 2 * n + 1)));
        factor = &factor * &Exact::ratio(-i64::from(j + n + 1), u64::from(j + 1));
    }
    series
}

/// Σ cⱼ xʲ, from the highest power down.
fn horner<N: Arithmetic>(coefficients: &[Exact], x: N) -> N {
    let mut terms = coefficients.iter().enumerate().rev();
    let (_, last) = terms.next().expect("a series has a term");
    let mut sum = N::exact(last);
    for (power, coefficient) in terms {
        sum = sum * x.clone() + N::exact(coefficient);
        if power % 2 == 0 && power > 0 {
            sum = sum.named(&format!("sum_{power}"));
        }
    }
    sum
}

/// The series of the first orders, each computed once.
struct Table([OnceLock<Vec<Exact>>; 8]);

impl Table {
    const fn new() -> Table {
        Table([const { OnceLock::new() }; 8])
    }

    fn row(&'static self, n: u32, compute: impl Fn(u32) -> Vec<Exact>) -> &'static [Exact] {
        self.0[n as usize].get_or_init(|| compute(n))
    }
}
