//! Functions that some or all libraries lack; each order of derivative is a separate primitive.
//!
//! The literal derivative of (1 − cos t)/t² loses every digit near t = 0. Here, a power series is used where
//! the closed form cancels, and a recurrence elsewhere; both are accurate to a few units of rounding of a
//! double. Intermediate values stay in range where the result does. The code is generic over [`Arithmetic`],
//! so that the targets print exactly the computation that is evaluated here.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::math::number::{Arithmetic, Choice, Comparison, Number};
use std::sync::OnceLock;

/// The value of a function that is defined by its code here. `None` for functions that all libraries have,
/// and for the families of cos √s and of angles, which choose by more than one comparison.
pub fn evaluate<N: Choice>(function: Function, x: &[N]) -> Option<N> {
    let x = || x[0].clone();
    Some(match function {
        Function::Asinh(n) => asinh(n, x()),
        Function::Acosh(n) => acosh(n, x()),
        Function::Atanh(n) => atanh(n, x()),
        Function::Sinc(n) => sinc(u32::from(n), x()),
        Function::Erf => erf(x()),
        Function::Erfc => erfc(x()),
        Function::ErfSlope => {
            let slope = || times_gauss(number(TWO_OVER_ROOT_PI), x());
            N::if_less(&vanishing(), &of(Function::Abs, x()), || integer(0), slope)
        }
        Function::Logistic => integer::<N>(1) / (integer::<N>(1) + of(Function::Exp, -x())),
        Function::LogisticSlope => {
            let small = of(Function::Exp, -of(Function::Abs, x())).named("small");
            let sum = (integer::<N>(1) + small.clone()).named("sum");
            small / (sum.clone() * sum)
        }
        Function::Softplus => {
            let positive = N::call(Function::Max, &[x(), integer(0)]);
            positive + of(Function::Ln1p, of(Function::Exp, -of(Function::Abs, x())))
        }
        Function::LnCosh => ln_cosh(x()),
        _ => return None,
    })
}

/// Whether a target prints the code of a function with kernels.
pub fn is_printed(function: Function) -> bool {
    let family = matches!(function, Function::CosSqrt(_) | Function::AngleRatio(_));
    family || evaluate(function, &[0.5]).is_some()
}

/// The value of a function of one argument.
fn of<N: Arithmetic>(function: Function, x: N) -> N {
    N::call(function, &[x])
}

fn integer<N: Arithmetic>(n: i64) -> N {
    N::exact(&Exact::from(n))
}

/// A number from its decimal digits.
fn number<N: Arithmetic>(digits: &str) -> N {
    N::exact(&decimal(digits))
}

fn decimal(digits: &str) -> Exact {
    Exact::parse(digits).expect("digits with a point")
}

fn ln_2<N: Arithmetic>() -> N {
    number("0.6931471805599453094172321214581765680755001343602552541207")
}

const TWO_OVER_ROOT_PI: &str = "1.128379167095512573896158903121545171688101258657997713688";

/// For x beyond this, e^(−x²) is zero in every precision.
fn vanishing<N: Arithmetic>() -> N {
    integer(30)
}

/// For x beyond this, x² + 1 and x² − 1 round to x² in every precision.
fn large<N: Arithmetic>() -> N {
    integer(1 << 28)
}

/// asinh x = ±ln(1 + (a + a²/(1 + √(1 + a²)))), a = |x|; 1/√(1 + x²), −x/√(1 + x²)³, (2x² − 1)/√(1 + x²)⁵.
fn asinh<N: Choice>(n: u8, x: N) -> N {
    let one = integer::<N>(1);
    if n < 2 {
        let a = of(Function::Abs, x.clone()).named("a");
        let root = || {
            let square = (a.clone() * a.clone()).named("square");
            (square.clone(), of(Function::Sqrt, one.clone() + square))
        };
        return match n {
            0 => N::if_less(
                &a,
                &large(),
                || {
                    let (square, root) = root();
                    let sum = a.clone() + square / (one.clone() + root);
                    of(Function::Signum, x.clone()) * of(Function::Ln1p, sum)
                },
                || of(Function::Signum, x.clone()) * (of(Function::Ln, a.clone()) + ln_2()),
            ),
            _ => N::if_less(&a, &large(), || one.clone() / root().1, || one.clone() / a.clone()),
        };
    }
    let square = (one.clone() + x.clone() * x.clone()).named("square");
    let root = of(Function::Sqrt, square.clone());
    match n {
        2 => -(x / root / square),
        _ => (integer::<N>(2) * x.clone() * x - one) / square.clone() / square / root,
    }
}

/// acosh x = ln(1 + (t + √(t (t + 2)))) with t = x − 1, 1/√(x² − 1), −x/√(x² − 1)³, (2x² + 1)/√(x² − 1)⁵,
/// with x² − 1 computed as (x − 1)(x + 1).
fn acosh<N: Choice>(n: u8, x: N) -> N {
    let one = integer::<N>(1);
    let (below, above) = (|| x.clone() - one.clone(), || x.clone() + one.clone());
    if n == 0 {
        return N::if_less(
            &x,
            &large(),
            || {
                let t = below().named("t");
                let root = of(Function::Sqrt, t.clone() * (t.clone() + integer(2)));
                of(Function::Ln1p, t + root)
            },
            || of(Function::Ln, x.clone()) + ln_2(),
        );
    }
    if n == 1 {
        return one.clone() / (of(Function::Sqrt, below()) * of(Function::Sqrt, above()));
    }
    let square = (below() * above()).named("square");
    let root = of(Function::Sqrt, square.clone());
    match n {
        2 => -(x / root / square),
        _ => (integer::<N>(2) * x.clone() * x.clone() + one.clone()) / square.clone() / square / root,
    }
}

/// atanh x = ±½ ln(1 + 2a/(1 − a)) with a = |x|, 1/d, 2x/d², (2 + 6x²)/d³ with d = (1 − x)(1 + x).
fn atanh<N: Arithmetic>(n: u8, x: N) -> N {
    let (one, two) = (integer::<N>(1), integer::<N>(2));
    if n == 0 {
        let a = of(Function::Abs, x.clone()).named("a");
        let half = N::exact(&Exact::ratio(1, 2)) * of(Function::Signum, x);
        return half * of(Function::Ln1p, two * a.clone() / (one - a));
    }
    let d = (one.clone() - x.clone()) * (one.clone() + x.clone());
    match n {
        1 => one / d,
        2 => {
            let d = d.named("d");
            two * x / (d.clone() * d)
        }
        _ => {
            let d = d.named("d");
            (two + integer::<N>(6) * x.clone() * x) / (d.clone() * d.clone() * d)
        }
    }
}

/// dⁿ/dxⁿ sin(x)/x: near 0 by its power series, elsewhere by f⁽ⁿ⁾ = (sin⁽ⁿ⁾ x − n f⁽ⁿ⁻¹⁾)/x, the n-th
/// derivative of x f = sin x.
fn sinc<N: Choice>(n: u32, x: N) -> N {
    static SERIES: Table = Table::new();
    let a = of(Function::Abs, x.clone());
    let switch = if n == 0 { Exact::ratio(1, 1 << 20) } else { Exact::from(2) };
    N::if_less(
        &a,
        &N::exact(&switch),
        || {
            let square = (x.clone() * x.clone()).named("square");
            let series = SERIES.row(n, |n| sinc_series(n, if n == 0 { 2 } else { 14 }));
            let sum = horner(series, square);
            if n % 2 == 1 { sum * x.clone() } else { sum }
        },
        || {
            let sine = of(Function::Sin, x.clone());
            if n == 0 {
                return sine / x.clone();
            }
            let sine = sine.named("sine");
            let cosine = of(Function::Cos, x.clone()).named("cosine");
            let mut value = sine.clone() / x.clone();
            for k in 1..=n {
                value = value.named(&format!("y_{}", k - 1));
                let value_below = if k == 1 { value } else { integer::<N>(i64::from(k)) * value };
                let wave = if k % 2 == 1 { cosine.clone() } else { sine.clone() };
                let wave = if (k / 2) % 2 == 1 { -wave } else { wave };
                value = (wave - value_below) / x.clone();
            }
            value
        },
    )
}

/// The first coefficients of the power series of dⁿ/dxⁿ sin(x)/x in x², divided by x if n is odd:
/// Σ (−1)ᵏ (2k)!/((2k − n)! (2k + 1)!) x²ᵏ⁻ⁿ.
fn sinc_series(n: u32, terms: u32) -> Vec<Exact> {
    let first = n.div_ceil(2);
    let coefficient = |k: u32| {
        // (2k)!/(2k − n)!, over (2k + 1)!
        let falling = (2 * k - n + 1..=2 * k).fold(Exact::ONE, |f, j| &f * &Exact::from(i64::from(j)));
        let over = (1..=2 * k + 1).fold(Exact::ONE, |f, j| &f * &Exact::ratio(1, u64::from(j)));
        let value = &falling * &over;
        if k % 2 == 1 { -value } else { value }
    };
    (first..first + terms).map(coefficient).collect()
}

/// c e^(−x²) for |x| ≤ 30. Rounding x² loses digits of the exponential, so x is first rounded to half its
/// digits, which makes its square exact; a second factor corrects the difference.
fn times_gauss<N: Arithmetic>(c: N, x: N) -> N {
    // Adding and subtracting 3·2ᵏ leaves multiples of 2^(k + 2 − digits): 26 digits of x < 32, 12 of x < 16.
    let shift = integer::<N>(3 << if N::digits() > 24 { 30 } else { 14 });
    let shifted = (x.clone() + shift.clone()).named("shifted");
    let high = (shifted - shift).named("high");
    let product = (c * of(Function::Exp, -(high.clone() * high.clone()))).named("product");
    let rest = of(Function::ExpM1, (high.clone() - x.clone()) * (x + high));
    product.clone() + product * rest
}

/// erfc x for x ≥ ½, as e^(−x²) P(s)/(1 + 2x) with s = (x − 3.5)/(x + 2.5): Shepherd and Laframboise,
/// Chebyshev approximation of (1 + 2x) exp(x²) erfc x, Math. Comp. 36 (1981), for x ≥ ½ in powers of s.
fn erfc_tail<N: Arithmetic>(x: N) -> N {
    const COEFFICIENTS: [f64; 23] = [
        1.2423492448711544,
        -0.12000786868938904,
        -0.024899113240524604,
        0.05674654966876823,
        -0.03662799043760799,
        0.012587446516850075,
        -0.0011965769232149073,
        -0.000884886069467466,
        0.0002904648460476749,
        6.401263391755595e-05,
        -4.11671885216092e-05,
        -7.071173073796166e-06,
        5.783337803216008e-06,
        1.2984720674421247e-06,
        -8.089513023668731e-07,
        -2.9715505534539495e-07,
        9.884116147462327e-08,
        6.537971640280044e-08,
        -7.047535214513998e-09,
        -1.1321780442171676e-08,
        -5.269399507249189e-10,
        1.0922768378567788e-09,
        1.6016206423914574e-10,
    ];
    static POLYNOMIAL: Table = Table::new();
    let polynomial = POLYNOMIAL
        .row(0, |_| COEFFICIENTS.map(|c| Exact::from_f64(c).expect("coefficients are finite")).to_vec());
    let s = (x.clone() - N::exact(&Exact::ratio(7, 2))) / (x.clone() + N::exact(&Exact::ratio(5, 2)));
    let sum = horner(polynomial, s.named("s"));
    let quotient = (sum / (integer::<N>(1) + integer::<N>(2) * x.clone())).named("quotient");
    times_gauss(quotient, x)
}

/// erf x for |x| ≤ 1 by its power series, 2/√π Σ (−1)ᵏ/(k! (2k + 1)) x²ᵏ⁺¹.
fn erf_near<N: Arithmetic>(x: N) -> N {
    static SERIES: Table = Table::new();
    let series = SERIES.row(0, |_| {
        let mut factor = decimal(TWO_OVER_ROOT_PI);
        let mut series = Vec::new();
        for k in 0..18 {
            series.push(&factor * &Exact::ratio(1, 2 * k + 1));
            factor = &factor * &Exact::ratio(-1, k + 1);
        }
        series
    });
    let square = (x.clone() * x.clone()).named("square");
    horner(series, square).named("quotient") * x
}

fn erf<N: Choice>(x: N) -> N {
    let a = of(Function::Abs, x.clone()).named("a");
    let sign = || of(Function::Signum, x.clone());
    let far = || sign() * (integer::<N>(1) - erfc_tail(a.clone()));
    let beyond = || N::if_less(&vanishing(), &a, sign, far);
    N::if_less(&a, &integer(1), || erf_near(x.clone()), beyond)
}

fn erfc<N: Choice>(x: N) -> N {
    let one = integer::<N>(1);
    let a = of(Function::Abs, x.clone()).named("a");
    let sign = || of(Function::Signum, x.clone());
    let far = || {
        let sign = sign().named("sign");
        one.clone() - sign.clone() + sign * erfc_tail(a.clone())
    };
    let beyond = || N::if_less(&vanishing(), &a, || one.clone() - sign(), far);
    let near = || one.clone() - erf_near(x.clone());
    N::if_less(&a, &N::exact(&Exact::ratio(1, 2)), near, beyond)
}

/// ln cosh x: near 0 ln(1 + e²/(2 + 2e)) with e = e^|x| − 1, elsewhere |x| + ln(1 + e^(−2|x|)) − ln 2.
fn ln_cosh<N: Choice>(x: N) -> N {
    let a = of(Function::Abs, x).named("a");
    let two = integer::<N>(2);
    N::if_less(
        &a,
        &integer(1),
        || {
            let e = of(Function::ExpM1, a.clone()).named("e");
            of(Function::Ln1p, e.clone() * e.clone() / (two.clone() + two.clone() * e))
        },
        || {
            let small = of(Function::Exp, -(two.clone() * a.clone()));
            a.clone() + (of(Function::Ln1p, small) - ln_2())
        },
    )
}

/// dⁿ/dsⁿ cos √s for s ≥ 0.
pub fn cos_sqrt<N: Number>(n: u32, s: N) -> N {
    match cos_sqrt_switch(n) {
        Some(switch) if N::holds(Comparison::Less, &s, &N::exact(&switch)) => cos_sqrt_near(n, s),
        _ => cos_sqrt_far(n, s),
    }
}

/// [`cos_sqrt_near`] is used for s below this; `None` if the closed form is always used.
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

/// [`angle_ratio_near`] is used for w > 0 and m/w² below this.
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

/// Σ cⱼ xʲ by Horner's method.
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
