//! Partial derivatives of the functions in the function table, as nodes of the vector graph.
//!
//! In: a function, its arguments and its value. Out: the derivative by one argument, in a form that is
//! accurate wherever the function is. The derivative of a member of a family is the next member.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::vector::{Graph, Real};

/// ∂f/∂(argument k); x are the arguments and r is the value f(x).
pub fn partial(g: &mut Graph, function: Function, x: &[Real], r: Real, k: usize) -> Real {
    match function {
        Function::Pi => g.zero(),
        Function::Abs => g.call(Function::Signum, &[x[0]]),
        Function::Sqrt => {
            let i = g.powi(r, -1);
            g.scaled(Exact::ratio(1, 2), i)
        }
        Function::Cbrt => {
            let i = g.powi(r, -2);
            g.scaled(Exact::ratio(1, 3), i)
        }
        Function::Powf => {
            if k == 0 {
                let one = g.one();
                let below = g.sub(x[1], one);
                let power = g.call(Function::Powf, &[x[0], below]);
                g.mul(x[1], power)
            } else {
                let ln = g.call(Function::Ln, &[x[0]]);
                g.mul(r, ln)
            }
        }
        Function::Exp => r,
        Function::Ln => g.powi(x[0], -1),
        Function::Ln1p => {
            let one = g.one();
            let s = g.add(one, x[0]);
            g.powi(s, -1)
        }
        Function::ExpM1 => g.call(Function::Exp, &[x[0]]),
        Function::Sin => g.call(Function::Cos, &[x[0]]),
        Function::Cos => {
            let s = g.call(Function::Sin, &[x[0]]);
            g.neg(s)
        }
        Function::Tan => {
            let one = g.one();
            let s = g.powi(r, 2);
            g.add(one, s)
        }
        Function::Asin => {
            let c = cosine_of_asin(g, x[0]);
            g.powi(c, -1)
        }
        Function::Acos => {
            let c = cosine_of_asin(g, x[0]);
            let i = g.powi(c, -1);
            g.neg(i)
        }
        Function::Atan => {
            let one = g.one();
            let s = g.powi(x[0], 2);
            let d = g.add(one, s);
            g.powi(d, -1)
        }
        Function::Atan2 => {
            let squares = [g.powi(x[0], 2), g.powi(x[1], 2)];
            let norm = g.add(squares[0], squares[1]);
            let quotient = g.div(x[1 - k], norm);
            if k == 0 { quotient } else { g.neg(quotient) }
        }
        Function::Sinh => g.call(Function::Cosh, &[x[0]]),
        Function::Cosh => g.call(Function::Sinh, &[x[0]]),
        Function::Tanh => {
            let c = g.call(Function::Cosh, &[x[0]]);
            g.powi(c, -2)
        }
        Function::Asinh(n) => g.call(Function::Asinh(n + 1), x),
        Function::Acosh(n) => g.call(Function::Acosh(n + 1), x),
        Function::Atanh(n) => g.call(Function::Atanh(n + 1), x),
        Function::Sinc(n) => g.call(Function::Sinc(n + 1), x),
        Function::Erf => g.call(Function::ErfSlope, &[x[0]]),
        Function::Erfc => {
            let slope = g.call(Function::ErfSlope, &[x[0]]);
            g.neg(slope)
        }
        Function::ErfSlope => {
            let product = g.mul(x[0], r);
            g.scaled(Exact::from(-2), product)
        }
        Function::Logistic => g.call(Function::LogisticSlope, &[x[0]]),
        Function::LogisticSlope => {
            let half = g.scaled(Exact::ratio(1, 2), x[0]);
            let tangent = g.call(Function::Tanh, &[half]);
            let product = g.mul(r, tangent);
            g.neg(product)
        }
        Function::Softplus => g.call(Function::Logistic, &[x[0]]),
        Function::LnCosh => g.call(Function::Tanh, &[x[0]]),
        Function::Hypot => g.call(Function::HypotSlope, &[x[k], x[1 - k]]),
        Function::HypotSlope => {
            let across = g.call(Function::HypotSlope, &[x[1], x[0]]);
            let length = g.call(Function::Hypot, &[x[0], x[1]]);
            let (first, sign) = if k == 0 { (across, 1) } else { (r, -1) };
            let product = g.mul(first, across);
            let quotient = g.div(product, length);
            g.scaled(Exact::from(sign), quotient)
        }
        Function::Min => chosen(g, x, k, true),
        Function::Max => chosen(g, x, k, false),
        Function::Signum => g.zero(),
        Function::CosSqrt(n) => g.call(Function::CosSqrt(n + 1), x),
        Function::AngleRatio(n) if k == 0 => g.call(Function::AngleRatio(n + 1), x),
        Function::AngleRatio(n) => {
            let square = g.powi(x[1], 2);
            let norm = g.add(x[0], square);
            let power = g.powi(norm, -1 - i32::from(n));
            let factorial = [1, 1, 2, 6, 24][usize::from(n)];
            g.scaled(Exact::from(if n % 2 == 0 { -factorial } else { factorial }), power)
        }
    }
}

/// √((1 − x)(1 + x)), which is accurate near ±1, where 1 − x² loses digits.
fn cosine_of_asin(g: &mut Graph, x: Real) -> Real {
    let one = g.one();
    let (below, above) = (g.sub(one, x), g.add(one, x));
    let product = g.mul(below, above);
    g.call(Function::Sqrt, &[product])
}

/// 1 where min or max returns argument k, else 0.
fn chosen(g: &mut Graph, x: &[Real], k: usize, first: bool) -> Real {
    let (zero, one) = (g.zero(), g.one());
    let (on, off) = if k == 0 { (one, zero) } else { (zero, one) };
    let takes_first = if first { g.less(x[0], x[1]) } else { g.less(x[1], x[0]) };
    g.select(takes_first, on, off)
}
