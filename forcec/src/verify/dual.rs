//! Hyper-dual numbers: forward-mode first and second derivatives, as an author could apply them to the
//! source.
//!
//! A number has a value, derivatives along two motions, and the mixed second derivative (J. A. Fike and J. J.
//! Alonso, The development of hyper-dual numbers for exact second-derivative calculations, AIAA 2011-886).
//! Operations follow the rules of calculus, functions the formulas of textbooks; nothing comes from the
//! compiler's derivatives. A number that changes along neither motion is a constant, and so are functions of
//! constants.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::math::number::{Arithmetic, Comparison, Number};
use crate::verify::big::Big;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The component type of dual numbers.
pub(crate) trait Scalar: Number + 'static {
    /// A number that every format represents exactly.
    fn of(value: f64) -> Self;
    /// The nearest double.
    fn wide(&self) -> f64;
}

impl Scalar for f64 {
    fn of(value: f64) -> f64 {
        value
    }

    fn wide(&self) -> f64 {
        *self
    }
}

impl Scalar for f32 {
    fn of(value: f64) -> f32 {
        value as f32
    }

    fn wide(&self) -> f64 {
        f64::from(*self)
    }
}

impl Scalar for Big {
    fn of(value: f64) -> Big {
        Big::from_f64(value)
    }

    fn wide(&self) -> f64 {
        self.to_f64()
    }
}

/// x + x₁ε₁ + x₂ε₂ + x₁₂ε₁ε₂ with ε₁² = ε₂² = 0.
#[derive(Clone, Debug)]
pub(crate) struct Dual<F> {
    /// The value.
    pub(crate) value: F,
    /// The derivatives along the first and the second motion.
    pub(crate) along: [F; 2],
    /// The mixed derivative along both motions.
    pub(crate) mixed: F,
}

impl<F: Scalar> Dual<F> {
    /// A number with zero derivatives.
    pub(crate) fn constant(value: F) -> Dual<F> {
        let zero = || F::of(0.0);
        Dual { value, along: [zero(), zero()], mixed: zero() }
    }

    fn is_constant(&self) -> bool {
        let zero = F::of(0.0);
        let [first, second] = &self.along;
        [first, second, &self.mixed].into_iter().all(|x| F::holds(Comparison::Equal, x, &zero))
    }

    /// f(x), from f, f′ and f″ at the value.
    fn chain(&self, value: F, slope: F, curvature: F) -> Dual<F> {
        if self.is_constant() {
            return Dual::constant(value);
        }
        let [first, second] = self.along.clone();
        let mixed = slope.clone() * self.mixed.clone() + curvature * (first.clone() * second.clone());
        Dual { value, along: [slope.clone() * first, slope * second], mixed }
    }

    /// f(x, y), from its value, (f_x, f_y) and (f_xx, f_xy, f_yy).
    fn chain_of_two(x: &Dual<F>, y: &Dual<F>, value: F, slopes: [F; 2], curvatures: [F; 3]) -> Dual<F> {
        if x.is_constant() && y.is_constant() {
            return Dual::constant(value);
        }
        let [fx, fy] = slopes;
        let [fxx, fxy, fyy] = curvatures;
        let along = [0, 1].map(|k| fx.clone() * x.along[k].clone() + fy.clone() * y.along[k].clone());
        let product = |a: &F, b: &F| a.clone() * b.clone();
        let [x1, x2] = &x.along;
        let [y1, y2] = &y.along;
        let mixed = fx * x.mixed.clone()
            + fy * y.mixed.clone()
            + fxx * product(x1, x2)
            + fxy * (product(x1, y2) + product(x2, y1))
            + fyy * product(y1, y2);
        Dual { value, along, mixed }
    }

    /// xʸ for constant y: f, f′, f″ are powers of x.
    fn power(&self, exponent: &F) -> Dual<F> {
        let power = |below: f64| {
            let exponent = exponent.clone() - F::of(below);
            F::call(Function::Powf, &[self.value.clone(), exponent])
        };
        let slope = exponent.clone() * power(1.0);
        let curvature = exponent.clone() * (exponent.clone() - F::of(1.0)) * power(2.0);
        self.chain(power(0.0), slope, curvature)
    }

    fn less(&self, other: &Dual<F>) -> bool {
        F::holds(Comparison::Less, &self.value, &other.value)
    }
}

impl<F: Scalar> Add for Dual<F> {
    type Output = Dual<F>;
    fn add(self, other: Dual<F>) -> Dual<F> {
        let ([a, b], [c, d]) = (self.along, other.along);
        Dual { value: self.value + other.value, along: [a + c, b + d], mixed: self.mixed + other.mixed }
    }
}

impl<F: Scalar> Sub for Dual<F> {
    type Output = Dual<F>;
    fn sub(self, other: Dual<F>) -> Dual<F> {
        let ([a, b], [c, d]) = (self.along, other.along);
        Dual { value: self.value - other.value, along: [a - c, b - d], mixed: self.mixed - other.mixed }
    }
}

impl<F: Scalar> Neg for Dual<F> {
    type Output = Dual<F>;
    fn neg(self) -> Dual<F> {
        Dual { value: -self.value, along: self.along.map(|x| -x), mixed: -self.mixed }
    }
}

impl<F: Scalar> Mul for Dual<F> {
    type Output = Dual<F>;
    // (x y)′ = x′ y + x y′
    fn mul(self, other: Dual<F>) -> Dual<F> {
        let product = |a: &F, b: &F| a.clone() * b.clone();
        let (x, y) = (&self, &other);
        let along = [0, 1].map(|k| product(&x.along[k], &y.value) + product(&x.value, &y.along[k]));
        let mixed = product(&x.mixed, &y.value)
            + product(&x.along[0], &y.along[1])
            + product(&x.along[1], &y.along[0])
            + product(&x.value, &y.mixed);
        Dual { value: product(&x.value, &y.value), along, mixed }
    }
}

impl<F: Scalar> Div for Dual<F> {
    type Output = Dual<F>;
    // q = x / y: q′ = (x′ − q y′) / y
    fn div(self, other: Dual<F>) -> Dual<F> {
        let y = other.value.clone();
        let value = self.value / y.clone();
        let along =
            [0, 1].map(|k| (self.along[k].clone() - value.clone() * other.along[k].clone()) / y.clone());
        let mixed = (self.mixed
            - along[0].clone() * other.along[1].clone()
            - along[1].clone() * other.along[0].clone()
            - value.clone() * other.mixed)
            / y;
        Dual { value, along, mixed }
    }
}

impl<F: Scalar> Arithmetic for Dual<F> {
    fn exact(value: &Exact) -> Dual<F> {
        Dual::constant(F::exact(value))
    }

    fn call(function: Function, arguments: &[Dual<F>]) -> Dual<F> {
        let values: Vec<F> = arguments.iter().map(|x| x.value.clone()).collect();
        let value = || F::call(function, &values);
        let of = |f: Function| F::call(f, &values);
        let (zero, one, two) = (F::of(0.0), F::of(1.0), F::of(2.0));
        let x = |k: usize| values[k].clone();
        let square = |x: F| x.clone() * x;
        match function {
            Function::Pi => Dual::constant(value()),
            Function::Abs | Function::Signum => {
                let negative = F::holds(Comparison::Less, &values[0], &zero);
                match function {
                    Function::Signum => Dual::constant(value()),
                    _ if negative => -arguments[0].clone(),
                    _ => Dual { value: value(), ..arguments[0].clone() },
                }
            }
            Function::Min | Function::Max => {
                let (x, y) = (&arguments[0], &arguments[1]);
                let first = if function == Function::Min { x.less(y) } else { y.less(x) };
                let chosen = if first { x } else { y };
                Dual { value: value(), ..chosen.clone() }
            }
            Function::Sqrt => {
                // f′ = 1 / (2 f), f″ = −f′ / (2 x)
                let root = value();
                let slope = one / (two.clone() * root.clone());
                arguments[0].chain(root, slope.clone(), -slope / (two * x(0)))
            }
            Function::Cbrt => {
                // f′ = f / (3 x), f″ = −2 f′ / (3 x)
                let root = value();
                let thrice = F::of(3.0) * x(0);
                let slope = root.clone() / thrice.clone();
                arguments[0].chain(root, slope.clone(), -(two * slope) / thrice)
            }
            Function::Powf if arguments[1].is_constant() => arguments[0].power(&values[1]),
            Function::Powf => {
                let (base, exponent) = (x(0), x(1));
                let (power, ln) = (value(), F::call(Function::Ln, std::slice::from_ref(&base)));
                let below = F::call(Function::Powf, &[base.clone(), exponent.clone() - one.clone()]);
                let slopes = [exponent.clone() * below.clone(), power.clone() * ln.clone()];
                let second = F::call(Function::Powf, &[base, exponent.clone() - two]);
                let curvatures = [
                    exponent.clone() * (exponent.clone() - one.clone()) * second,
                    below * (one + exponent * ln.clone()),
                    power.clone() * ln.clone() * ln,
                ];
                Dual::chain_of_two(&arguments[0], &arguments[1], power, slopes, curvatures)
            }
            Function::Exp => arguments[0].chain(value(), value(), value()),
            Function::ExpM1 => arguments[0].chain(value(), of(Function::Exp), of(Function::Exp)),
            Function::Ln | Function::Ln1p => {
                let from = if function == Function::Ln { x(0) } else { one.clone() + x(0) };
                let slope = one / from;
                arguments[0].chain(value(), slope.clone(), -square(slope))
            }
            Function::Sin => arguments[0].chain(value(), of(Function::Cos), -value()),
            Function::Cos => arguments[0].chain(value(), -of(Function::Sin), -value()),
            Function::Tan => {
                let tangent = value();
                let slope = one + square(tangent.clone());
                arguments[0].chain(tangent.clone(), slope.clone(), two * tangent * slope)
            }
            Function::Asin | Function::Acos => {
                // f′ = ±1 / √(1 − x²), f″ = x f′ / (1 − x²)
                let rest = one.clone() - square(x(0));
                let slope = one / F::call(Function::Sqrt, std::slice::from_ref(&rest));
                let slope = if function == Function::Asin { slope } else { -slope };
                arguments[0].chain(value(), slope.clone(), x(0) * slope / rest)
            }
            Function::Atan => {
                // f′ = 1 / (1 + x²), f″ = −2 x f′²
                let slope = one.clone() / (one + square(x(0)));
                arguments[0].chain(value(), slope.clone(), -(two * x(0) * square(slope)))
            }
            Function::Atan2 => {
                // of y and x: f_y = x / r², f_x = −y / r²
                let (y, x) = (x(0), x(1));
                let norm = square(x.clone()) + square(y.clone());
                let slopes = [x.clone() / norm.clone(), -y.clone() / norm.clone()];
                let both = two * x.clone() * y.clone() / square(norm.clone());
                let cross = (square(y) - square(x)) / square(norm);
                let curvatures = [-both.clone(), cross, both];
                Dual::chain_of_two(&arguments[0], &arguments[1], value(), slopes, curvatures)
            }
            Function::Sinh => arguments[0].chain(value(), of(Function::Cosh), value()),
            Function::Cosh => arguments[0].chain(value(), of(Function::Sinh), value()),
            Function::Tanh => {
                let tangent = value();
                let slope = one - square(tangent.clone());
                arguments[0].chain(tangent.clone(), slope.clone(), -(two * tangent * slope))
            }
            Function::Hypot => {
                // f_x = x / r, f_xx = y² / r³, f_xy = −x y / r³
                let (x, y, r) = (x(0), x(1), value());
                let slopes = [x.clone() / r.clone(), y.clone() / r.clone()];
                let cube = r.clone() * r.clone() * r.clone();
                let curvatures =
                    [square(y.clone()) / cube.clone(), -(x.clone() * y) / cube.clone(), square(x) / cube];
                Dual::chain_of_two(&arguments[0], &arguments[1], r, slopes, curvatures)
            }
            Function::HypotSlope => {
                // f_x = y²/r³, f_y = −x y/r³, f_xx = −3 x y²/r⁵, f_xy = y (2 x² − y²)/r⁵, f_yy = x (2 y² − x²)/r⁵
                let (x, y, r) = (x(0), x(1), of(Function::Hypot));
                let (square_x, square_y) = (square(x.clone()), square(y.clone()));
                let cube = r.clone() * square(r.clone());
                let fifth = cube.clone() * square(r);
                let slopes = [square_y.clone() / cube.clone(), -(x.clone() * y.clone()) / cube];
                let curvatures = [
                    -(F::of(3.0) * x.clone() * square_y.clone()) / fifth.clone(),
                    y * (two.clone() * square_x.clone() - square_y.clone()) / fifth.clone(),
                    x * (two * square_y - square_x) / fifth,
                ];
                Dual::chain_of_two(&arguments[0], &arguments[1], value(), slopes, curvatures)
            }
            Function::Erf | Function::Erfc => {
                let slope = of(Function::ErfSlope);
                let slope = if function == Function::Erf { slope } else { -slope };
                arguments[0].chain(value(), slope.clone(), -(two * x(0) * slope))
            }
            Function::ErfSlope => {
                // f′ = −2 x f, f″ = (4 x² − 2) f
                let curvature = (F::of(4.0) * square(x(0)) - two.clone()) * value();
                arguments[0].chain(value(), -(two * x(0) * value()), curvature)
            }
            Function::Logistic | Function::LogisticSlope => {
                // f′ = f (1 − f), f″ = f′ (1 − 2 f), f‴ = f′ (1 − 6 f′)
                let slope = of(Function::LogisticSlope);
                let curvature = slope.clone() * (one.clone() - two * of(Function::Logistic));
                match function {
                    Function::Logistic => arguments[0].chain(value(), slope, curvature),
                    _ => {
                        let third = slope.clone() * (one - F::of(6.0) * slope.clone());
                        arguments[0].chain(slope, curvature, third)
                    }
                }
            }
            Function::Softplus => {
                arguments[0].chain(value(), of(Function::Logistic), of(Function::LogisticSlope))
            }
            Function::LnCosh => {
                let slope = of(Function::Tanh);
                arguments[0].chain(value(), slope.clone(), one - square(slope))
            }
            // The members of a family are derivatives of each other by definition.
            Function::Asinh(n) => {
                arguments[0].chain(value(), of(Function::Asinh(n + 1)), of(Function::Asinh(n + 2)))
            }
            Function::Acosh(n) => {
                arguments[0].chain(value(), of(Function::Acosh(n + 1)), of(Function::Acosh(n + 2)))
            }
            Function::Atanh(n) => {
                arguments[0].chain(value(), of(Function::Atanh(n + 1)), of(Function::Atanh(n + 2)))
            }
            Function::Sinc(n) => {
                arguments[0].chain(value(), of(Function::Sinc(n + 1)), of(Function::Sinc(n + 2)))
            }
            Function::CosSqrt(n) => {
                arguments[0].chain(value(), of(Function::CosSqrt(n + 1)), of(Function::CosSqrt(n + 2)))
            }
            Function::AngleRatio(n) => {
                // f_w = c / (m + w²)ⁿ⁺¹ with c = (−1)ⁿ⁺¹ n!, f_mw and f_ww its derivatives
                let (w, norm) = (x(1), x(0) + square(x(1)));
                let factorial: f64 = (1..=n).map(f64::from).product();
                let c = if n % 2 == 0 { -factorial } else { factorial };
                let power = (0..n).fold(norm.clone(), |power, _| power * norm.clone());
                let slope = F::of(c) / power;
                let steeper = F::of(-f64::from(n + 1)) * slope.clone() / norm;
                let slopes = [of(Function::AngleRatio(n + 1)), slope];
                let curvatures = [of(Function::AngleRatio(n + 2)), steeper.clone(), two * w * steeper];
                Dual::chain_of_two(&arguments[0], &arguments[1], value(), slopes, curvatures)
            }
        }
    }
}

impl<F: Scalar> Number for Dual<F> {
    fn holds(comparison: Comparison, x: &Dual<F>, y: &Dual<F>) -> bool {
        F::holds(comparison, &x.value, &y.value)
    }
}
