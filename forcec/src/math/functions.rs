//! The function table: one row contains everything that the compiler knows about a function of reals.
//!
//! To add a function, add a variant and its row. The derivative may use the result of the function. The
//! spelling is a template: `{0}` and `{1}` are the arguments, `{p}` is the precision, `{f}` and `{F}` are the
//! suffixes of C's single precision, and `{n}` is the number within a family. Functions of two arguments are
//! paths in Rust, because clippy follows the receiver of a method with arguments through every `let`, in
//! exponential time. [`special`] defines the functions that a template calls `forcec_…` in C, or by a bare
//! name in Rust; their code is printed with the kernel.

use crate::math::special;

/// A function of reals. A number selects a derivative within a family; each derivative is a primitive.
/// Rotations by a vector and angles of quaternions use the families cos √s and atan2(√m, w)/√m.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Function {
    /// The constant π.
    Pi,
    /// |x|
    Abs,
    /// √x
    Sqrt,
    /// ∛x
    Cbrt,
    /// xʸ for real y
    Powf,
    /// eˣ
    Exp,
    /// ln x
    Ln,
    /// ln(1 + x)
    Ln1p,
    /// eˣ − 1
    ExpM1,
    /// sin x
    Sin,
    /// cos x
    Cos,
    /// tan x
    Tan,
    /// asin x
    Asin,
    /// acos x
    Acos,
    /// atan x
    Atan,
    /// atan2(y, x)
    Atan2,
    /// sinh x
    Sinh,
    /// cosh x
    Cosh,
    /// tanh x
    Tanh,
    /// dⁿ/dxⁿ asinh x
    Asinh(u8),
    /// dⁿ/dxⁿ acosh x
    Acosh(u8),
    /// dⁿ/dxⁿ atanh x
    Atanh(u8),
    /// dⁿ/dxⁿ sin(x)/x, 1 at 0
    Sinc(u8),
    /// The error function, 2/√π ∫₀ˣ e^(−t²) dt
    Erf,
    /// 1 − erf x
    Erfc,
    /// 2/√π e^(−x²)
    ErfSlope,
    /// 1/(1 + e⁻ˣ)
    Logistic,
    /// eˣ/(1 + eˣ)²
    LogisticSlope,
    /// ln(1 + eˣ)
    Softplus,
    /// ln cosh x
    LnCosh,
    /// √(x² + y²)
    Hypot,
    /// x/√(x² + y²)
    HypotSlope,
    /// min(x, y)
    Min,
    /// max(x, y)
    Max,
    /// ±1, the sign of x; of ±0 too
    Signum,
    /// dⁿ/dsⁿ cos √s
    CosSqrt(u8),
    /// ∂ⁿ/∂mⁿ atan2(√m, w)/√m
    AngleRatio(u8),
}

/// A binary operator.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Operator {
    /// x + y
    Add,
    /// x − y
    Subtract,
    /// x y
    Multiply,
    /// x / y
    Divide,
}

/// Where a function is defined, or smooth. Outside, the special families return arbitrary values.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum FunctionDomain {
    /// Every real.
    All,
    /// The first argument is at least this.
    AtLeast(f64),
    /// The first argument is above this.
    Above(f64),
    /// The first argument is at least −1 and at most 1.
    Unit,
    /// The first argument is strictly between −1 and 1.
    Inside,
    /// The arguments are not all zero.
    NotAllZero,
    /// The first argument is at least zero and the arguments are not all zero.
    HalfPlane,
}

/// Everything known about one function.
pub struct FunctionRow {
    /// Its name in messages and text forms; for a method, also its name in the source.
    pub name: &'static str,
    /// Number of arguments.
    pub arity: usize,
    /// Where the value exists.
    pub domain: FunctionDomain,
    /// Where the derivative exists.
    pub smooth: FunctionDomain,
    /// The partial derivatives of `r` by `x` and `y` in words; `derive/partials.rs` builds them.
    pub formula: &'static str,
    /// Evaluates the function.
    pub value: fn(&[f64]) -> f64,
    /// Template of a call in C.
    pub c: &'static str,
    /// Template of a call in Rust.
    pub rust: &'static str,
    /// The kind of operation that a call counts as.
    pub cost: Cost,
}

/// The kind of operation that a call counts as.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cost {
    /// No operation: a constant.
    Free,
    /// A square root.
    Sqrt,
    /// A function call.
    Call,
}

use FunctionDomain::{Above, All, AtLeast, HalfPlane, NotAllZero, Unit};
use own::{ACOSH, ASINH, ATANH, ERF, ERF_SLOPE, ERFC, LN_COSH, LOGISTIC, LOGISTIC_SLOPE, SINC, SOFTPLUS};

macro_rules! row {
    ($name:literal/$arity:literal, $domain:expr, $smooth:expr, $formula:literal, $value:expr,
     $c:expr, $rust:expr) => {
        FunctionRow {
            name: $name,
            arity: $arity,
            domain: $domain,
            smooth: $smooth,
            formula: $formula,
            value: $value,
            c: $c,
            rust: $rust,
            cost: Cost::Call,
        }
    };
}

// After the macro that its rows use.
mod own;

static PI: FunctionRow = FunctionRow {
    cost: Cost::Free,
    ..row!("PI" / 0, All, All, "0", |_| std::f64::consts::PI, "FORCEC_PI{F}", "core::{p}::consts::PI")
};
static ABS: FunctionRow =
    row!("abs" / 1, All, NotAllZero, "signum x", |x| x[0].abs(), "fabs{f}({0})", "{0}.abs()");
static SQRT: FunctionRow = FunctionRow {
    cost: Cost::Sqrt,
    ..row!("sqrt" / 1, AtLeast(0.0), Above(0.0), "1 / (2 r)", |x| x[0].sqrt(), "sqrt{f}({0})", "{0}.sqrt()")
};
static CBRT: FunctionRow =
    row!("cbrt" / 1, All, NotAllZero, "1 / (3 r²)", |x| x[0].cbrt(), "cbrt{f}({0})", "{0}.cbrt()");
static POWF: FunctionRow = row!(
    "powf" / 2,
    AtLeast(0.0),
    Above(0.0),
    "y powf(x, y − 1), r ln x",
    |x| x[0].powf(x[1]),
    "pow{f}({0}, {1})",
    "{p}::powf({0}, {1})"
);
static EXP: FunctionRow = row!("exp" / 1, All, All, "r", |x| x[0].exp(), "exp{f}({0})", "{0}.exp()");
static LN: FunctionRow =
    row!("ln" / 1, Above(0.0), Above(0.0), "1 / x", |x| x[0].ln(), "log{f}({0})", "{0}.ln()");
static LN_1P: FunctionRow = row!(
    "ln_1p" / 1,
    Above(-1.0),
    Above(-1.0),
    "1 / (1 + x)",
    |x| x[0].ln_1p(),
    "log1p{f}({0})",
    "{0}.ln_1p()"
);
static EXP_M1: FunctionRow =
    row!("exp_m1" / 1, All, All, "exp x", |x| x[0].exp_m1(), "expm1{f}({0})", "{0}.exp_m1()");
static SIN: FunctionRow = row!("sin" / 1, All, All, "cos x", |x| x[0].sin(), "sin{f}({0})", "{0}.sin()");
static COS: FunctionRow = row!("cos" / 1, All, All, "−sin x", |x| x[0].cos(), "cos{f}({0})", "{0}.cos()");
static TAN: FunctionRow = row!("tan" / 1, All, All, "1 + r²", |x| x[0].tan(), "tan{f}({0})", "{0}.tan()");
static ASIN: FunctionRow =
    row!("asin" / 1, Unit, Unit, "1 / √((1 − x)(1 + x))", |x| x[0].asin(), "asin{f}({0})", "{0}.asin()");
static ACOS: FunctionRow =
    row!("acos" / 1, Unit, Unit, "−1 / √((1 − x)(1 + x))", |x| x[0].acos(), "acos{f}({0})", "{0}.acos()");
static ATAN: FunctionRow =
    row!("atan" / 1, All, All, "1 / (1 + x²)", |x| x[0].atan(), "atan{f}({0})", "{0}.atan()");
static ATAN2: FunctionRow = row!(
    "atan2" / 2,
    NotAllZero,
    NotAllZero,
    "y / (x² + y²), −x / (x² + y²)",
    |x| x[0].atan2(x[1]),
    "atan2{f}({0}, {1})",
    "{p}::atan2({0}, {1})"
);
static SINH: FunctionRow =
    row!("sinh" / 1, All, All, "cosh x", |x| x[0].sinh(), "sinh{f}({0})", "{0}.sinh()");
static COSH: FunctionRow =
    row!("cosh" / 1, All, All, "sinh x", |x| x[0].cosh(), "cosh{f}({0})", "{0}.cosh()");
static TANH: FunctionRow =
    row!("tanh" / 1, All, All, "1 / cosh² x", |x| x[0].tanh(), "tanh{f}({0})", "{0}.tanh()");

static HYPOT: FunctionRow = row!(
    "hypot" / 2,
    All,
    NotAllZero,
    "x / r, y / r",
    |x| x[0].hypot(x[1]),
    "hypot{f}({0}, {1})",
    "{p}::hypot({0}, {1})"
);
/// A kernel computes this as a quotient by the hypotenuse that it already has. The derivative of this row
/// does not cancel, unlike 1/r − x²/r³, the derivative of the quotient.
static HYPOT_SLOPE: FunctionRow = row!(
    "hypot_slope" / 2,
    NotAllZero,
    NotAllZero,
    "(y/h)² / h, −r (y/h) / h with h = hypot(x, y)",
    |x| x[0] / x[0].hypot(x[1]),
    "({0} / hypot{f}({0}, {1}))",
    "({0} / {p}::hypot({0}, {1}))"
);
static MIN: FunctionRow = row!(
    "min" / 2,
    All,
    All,
    "x < y ? 1 : 0, x < y ? 0 : 1",
    |x| x[0].min(x[1]),
    "forcec_min_{p}({0}, {1})",
    "{p}::min({0}, {1})"
);
static MAX: FunctionRow = row!(
    "max" / 2,
    All,
    All,
    "y < x ? 1 : 0, y < x ? 0 : 1",
    |x| x[0].max(x[1]),
    "forcec_max_{p}({0}, {1})",
    "{p}::max({0}, {1})"
);
static SIGNUM: FunctionRow =
    row!("signum" / 1, All, NotAllZero, "0", |x| x[0].signum(), "copysign{f}(1.0{f}, {0})", "{0}.signum()");

macro_rules! cos_sqrt {
    ($n:literal) => {
        row!(
            "cos_sqrt" / 1,
            AtLeast(0.0),
            AtLeast(0.0),
            "the next of the family",
            |x| special::cos_sqrt($n, x[0]),
            "forcec_cos_sqrt_{n}_{p}({0})",
            "cos_sqrt_{n}({0})"
        )
    };
}
static COS_SQRT: [FunctionRow; 5] = [cos_sqrt!(0), cos_sqrt!(1), cos_sqrt!(2), cos_sqrt!(3), cos_sqrt!(4)];

macro_rules! angle_ratio {
    ($n:literal) => {
        row!(
            "angle_ratio" / 2,
            HalfPlane,
            HalfPlane,
            "the next of the family, (−1)ⁿ⁺¹ n! / (m + w²)ⁿ⁺¹",
            |x| special::angle_ratio($n, x[0], x[1]),
            "forcec_angle_ratio_{n}_{p}({0}, {1})",
            "angle_ratio_{n}({0}, {1})"
        )
    };
}
static ANGLE_RATIO: [FunctionRow; 4] = [angle_ratio!(0), angle_ratio!(1), angle_ratio!(2), angle_ratio!(3)];

impl Function {
    /// Every function that kernels call; families up to the order that forces and their derivatives reach.
    pub const ALL: [Function; 49] = [
        Function::Pi,
        Function::Abs,
        Function::Sqrt,
        Function::Cbrt,
        Function::Powf,
        Function::Exp,
        Function::Ln,
        Function::Ln1p,
        Function::ExpM1,
        Function::Sin,
        Function::Cos,
        Function::Tan,
        Function::Asin,
        Function::Acos,
        Function::Atan,
        Function::Atan2,
        Function::Sinh,
        Function::Cosh,
        Function::Tanh,
        Function::Asinh(0),
        Function::Asinh(1),
        Function::Asinh(2),
        Function::Acosh(0),
        Function::Acosh(1),
        Function::Acosh(2),
        Function::Atanh(0),
        Function::Atanh(1),
        Function::Atanh(2),
        Function::Sinc(0),
        Function::Sinc(1),
        Function::Sinc(2),
        Function::Erf,
        Function::Erfc,
        Function::ErfSlope,
        Function::Logistic,
        Function::LogisticSlope,
        Function::Softplus,
        Function::LnCosh,
        Function::Hypot,
        Function::Min,
        Function::Max,
        Function::Signum,
        Function::CosSqrt(0),
        Function::CosSqrt(1),
        Function::CosSqrt(2),
        Function::CosSqrt(3),
        Function::AngleRatio(0),
        Function::AngleRatio(1),
        Function::AngleRatio(2),
    ];

    /// Its row in the table.
    pub fn row(self) -> &'static FunctionRow {
        match self {
            Function::Pi => &PI,
            Function::Abs => &ABS,
            Function::Sqrt => &SQRT,
            Function::Cbrt => &CBRT,
            Function::Powf => &POWF,
            Function::Exp => &EXP,
            Function::Ln => &LN,
            Function::Ln1p => &LN_1P,
            Function::ExpM1 => &EXP_M1,
            Function::Sin => &SIN,
            Function::Cos => &COS,
            Function::Tan => &TAN,
            Function::Asin => &ASIN,
            Function::Acos => &ACOS,
            Function::Atan => &ATAN,
            Function::Atan2 => &ATAN2,
            Function::Sinh => &SINH,
            Function::Cosh => &COSH,
            Function::Tanh => &TANH,
            Function::Asinh(n) => &ASINH[n as usize],
            Function::Acosh(n) => &ACOSH[n as usize],
            Function::Atanh(n) => &ATANH[n as usize],
            Function::Sinc(n) => &SINC[n as usize],
            Function::Erf => &ERF,
            Function::Erfc => &ERFC,
            Function::ErfSlope => &ERF_SLOPE,
            Function::Logistic => &LOGISTIC,
            Function::LogisticSlope => &LOGISTIC_SLOPE,
            Function::Softplus => &SOFTPLUS,
            Function::LnCosh => &LN_COSH,
            Function::Hypot => &HYPOT,
            Function::HypotSlope => &HYPOT_SLOPE,
            Function::Min => &MIN,
            Function::Max => &MAX,
            Function::Signum => &SIGNUM,
            Function::CosSqrt(n) => &COS_SQRT[n as usize],
            Function::AngleRatio(n) => &ANGLE_RATIO[n as usize],
        }
    }

    /// An error bound of the library function, in units of half an ulp: 0 or 1 for exact or correctly rounded
    /// functions, else 4 ulp, twice the worst error in the manual of glibc 2.40. Measurements confirm this
    /// bound for our own functions; for cos √s, angles and sinc there is also an analysis.
    pub fn units(self) -> f64 {
        match self {
            Function::Abs | Function::Min | Function::Max | Function::Signum => 0.0,
            Function::Pi | Function::Sqrt => 1.0,
            _ => 8.0,
        }
    }

    /// Number within its family, if it is part of the name.
    pub fn order(self) -> Option<u8> {
        use Function::{Acosh, AngleRatio, Asinh, Atanh, CosSqrt, Sinc};
        match self {
            CosSqrt(n) | AngleRatio(n) => Some(n),
            Asinh(n) | Acosh(n) | Atanh(n) | Sinc(n) => Some(n).filter(|n| *n > 0),
            _ => None,
        }
    }
}
