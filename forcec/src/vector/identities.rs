//! Identities of functions, as data: a name, two sides in the force language, and the code that applies each.
//!
//! A rule must be valid wherever its left side is defined and finite. A test compiles both sides of every
//! rule, compares their values at sampled points and checks that the rule fires.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::vector::{Graph, Node, Real};

/// An identity of functions.
pub struct Identity {
    /// The name in reports.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub name: &'static str,
    /// The left side, in the force language, over the reals `x` and `y`.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub left: &'static str,
    /// The right side.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub right: &'static str,
    apply: fn(&mut Graph, Function, &[Real]) -> Option<Real>,
}

/// Applies the first identity that matches a call.
pub(crate) fn apply(graph: &mut Graph, function: Function, arguments: &[Real]) -> Option<Real> {
    if arguments.is_empty() {
        return None;
    }
    IDENTITIES.iter().find_map(|identity| (identity.apply)(graph, function, arguments))
}

macro_rules! identity {
    ($name:literal, $left:literal => $right:literal, $apply:expr) => {
        Identity { name: $name, left: $left, right: $right, apply: $apply }
    };
}

/// Functions with f(−x) = −f(x).
fn is_odd(function: Function) -> bool {
    use Function::{Asin, Asinh, Atan, Atanh, Cbrt, Erf, Sin, Sinc, Sinh, Tan, Tanh};
    match function {
        Sin | Tan | Asin | Atan | Sinh | Tanh | Cbrt | Erf => true,
        Asinh(n) | Atanh(n) => n % 2 == 0,
        Sinc(n) => n % 2 == 1,
        _ => false,
    }
}

/// Functions with f(−x) = f(x).
fn is_even(function: Function) -> bool {
    use Function::{Abs, Asinh, Atanh, Cos, Cosh, ErfSlope, LnCosh, LogisticSlope, Sinc};
    match function {
        Cos | Cosh | Abs | ErfSlope | LogisticSlope | LnCosh => true,
        Asinh(n) | Atanh(n) => n % 2 == 1,
        Sinc(n) => n % 2 == 0,
        _ => false,
    }
}

/// −x without its minus sign, if x is written with one.
fn without_minus(g: &mut Graph, x: Real) -> Option<Real> {
    let (coefficient, _) = g.split(x);
    let negative = coefficient.is_negative() || g.value(x).is_some_and(Exact::is_negative);
    negative.then(|| g.neg(x))
}

/// f(0), for the functions with an exact value there.
fn at_zero(function: Function) -> Option<Exact> {
    use Function::{Abs, Cos, CosSqrt, Cosh, Erfc, Exp, ExpM1, Ln1p, LnCosh, Logistic, Sinc, Sqrt};
    match function {
        _ if is_odd(function) => Some(Exact::ZERO),
        Abs | Sqrt | ExpM1 | Ln1p | LnCosh => Some(Exact::ZERO),
        Exp | Cos | Cosh | CosSqrt(0) | Sinc(0) | Erfc => Some(Exact::ONE),
        Logistic => Some(Exact::ratio(1, 2)),
        CosSqrt(1) => Some(Exact::ratio(-1, 2)),
        _ => None,
    }
}

/// The identities of functions, in the order in which they are tried.
pub static IDENTITIES: &[Identity] = &[
    identity!("at zero", "x.sin() + (x - x).exp() - (0.0 * y).tan()" => "x.sin() + 1.0", |g, f, x| {
        let zero = x.len() == 1 && g.is_zero(x[0]);
        at_zero(f).filter(|_| zero).map(|value| g.constant(value))
    }),
    identity!("logarithm of one", "(x / x).ln() + y" => "y", |g, f, x| {
        (f == Function::Ln && g.value(x[0]).is_some_and(Exact::is_one)).then(|| g.zero())
    }),
    identity!("odd function", "(-x).atan() + (-y).sin()" => "-(x.atan() + y.sin())", |g, f, x| {
        if !is_odd(f) {
            return None;
        }
        let opposite = without_minus(g, x[0])?;
        let value = g.call(f, &[opposite]);
        Some(g.neg(value))
    }),
    identity!("even function", "(-x).cos() + (-y).abs() + (-y).cosh()" => "x.cos() + y.abs() + y.cosh()", |g, f, x| {
        if !is_even(f) {
            return None;
        }
        let opposite = without_minus(g, x[0])?;
        Some(g.call(f, &[opposite]))
    }),
    identity!("absolute value of a number", "(3.0 * 1.0).abs() * x" => "3.0 * x", |g, f, x| {
        let value = g.value(x[0]).filter(|_| f == Function::Abs)?.abs();
        Some(g.constant(value))
    }),
    identity!("absolute value twice", "x.abs().abs()" => "x.abs()", |g, f, x| {
        (f == Function::Abs && matches!(g.node(x[0].index()), Node::Call(Function::Abs | Function::Sqrt, _)))
            .then_some(x[0])
    }),
    identity!("root of a square", "(x * x).sqrt()" => "x.abs()", |g, f, x| match g.node(x[0].index()) {
        Node::Product(factors) if f == Function::Sqrt && factors.len() == 1 && factors[0].1 == 2 => {
            let base = factors[0].0;
            Some(g.call(Function::Abs, &[base]))
        }
        _ => None,
    }),
    identity!("root of a square number", "(9.0 * 0.25).sqrt() * x" => "1.5 * x", |g, f, x| {
        let value = g.value(x[0]).filter(|value| f == Function::Sqrt && !value.is_negative())?.clone();
        let root = Exact::from_f64(value.to_f64().sqrt())?;
        (&root * &root == value).then(|| g.constant(root))
    }),
    identity!("exponential of a logarithm", "x.abs().ln().exp()" => "x.abs()", |g, f, x| match g.node(x[0].index()) {
        Node::Call(Function::Ln, inner) if f == Function::Exp => Some(inner[0]),
        _ => None,
    }),
    identity!("logarithm of an exponential", "x.exp().ln()" => "x", |g, f, x| match g.node(x[0].index()) {
        Node::Call(Function::Exp, inner) if f == Function::Ln => Some(inner[0]),
        _ => None,
    }),
    identity!("softplus", "x.exp().ln_1p() + (1.0 + y.exp()).ln()" => "x.softplus() + y.softplus()", |g, f, x| {
        let u = match f {
            Function::Ln1p => g.exponent(x[0]),
            Function::Ln => g.one_and_exponential(x[0]).and_then(|(a, b, u)| (a && b).then_some(u)),
            _ => None,
        }?;
        Some(g.call(Function::Softplus, &[u]))
    }),
    identity!("whole power", "x.powf(3.0)" => "x.powi(3)", |g, f, x| {
        let n = g.value(*x.get(1)?).filter(|_| f == Function::Powf)?.to_i64()?;
        let n = i32::try_from(n).ok().filter(|n| n.abs() <= 64)?;
        Some(g.powi(x[0], n))
    }),
    identity!("half power", "x.abs().powf(0.5)" => "x.abs().sqrt()", |g, f, x| {
        let half = f == Function::Powf && g.value(x[1]) == Some(&Exact::ratio(1, 2));
        half.then(|| g.call(Function::Sqrt, &[x[0]]))
    }),
    identity!("smaller of equals", "x.min(x) + y.max(y)" => "x + y", |_, f, x| {
        (matches!(f, Function::Min | Function::Max) && x[0] == x[1]).then_some(x[0])
    }),
    identity!("smaller of numbers", "(1.0 + 1.0).min(3.0) * x + (1.0 + 1.0).max(3.0)" => "2.0 * x + 3.0", |g, f, x| {
        if !matches!(f, Function::Min | Function::Max) {
            return None;
        }
        let first = g.value(x[0])? < g.value(x[1])?;
        Some(if first == (f == Function::Min) { x[0] } else { x[1] })
    }),
    identity!("sign of a number", "(-3.0 * 1.0).signum() * x" => "-x", |g, f, x| {
        let negative = g.value(x[0]).filter(|_| f == Function::Signum)?.is_negative();
        Some(g.constant(Exact::from(if negative { -1 } else { 1 })))
    }),
    identity!("hypotenuse of one leg", "x.hypot(0.0)" => "x.abs()", |g, f, x| {
        (f == Function::Hypot && g.is_zero(x[1])).then(|| g.call(Function::Abs, &[x[0]]))
    }),
];
