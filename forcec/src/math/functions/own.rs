//! Rows of functions with our own code: printed with the kernel where a target lacks the function.

use crate::math::functions::FunctionDomain::{Above, All, AtLeast, Inside};
use crate::math::functions::{Cost, Function, FunctionRow};
use crate::math::special;

/// A row whose value is computed by the code that is printed for it.
macro_rules! own {
    ($function:expr, $name:literal, $domain:expr, $smooth:expr, $formula:literal,
     $c:expr, $rust:expr) => {
        row!(
            $name / 1,
            $domain,
            $smooth,
            $formula,
            |x| special::evaluate($function, x).expect("defined by its code"),
            $c,
            $rust
        )
    };
}
/// The rows of a function and its derivatives, by order.
macro_rules! orders {
    ($function:ident, $name:literal, $domain:expr, $smooth:expr, $c:literal, $rust:literal) => {
        [
            orders!($function, 0, $name, $domain, $smooth, $c, $rust),
            orders!($function, 1, $name, $smooth, $smooth),
            orders!($function, 2, $name, $smooth, $smooth),
            orders!($function, 3, $name, $smooth, $smooth),
        ]
    };
    ($function:ident, $n:literal, $name:literal, $domain:expr, $smooth:expr) => {
        orders!(
            $function,
            $n,
            $name,
            $domain,
            $smooth,
            concat!("forcec_", $name, "_{n}_{p}({0})"),
            concat!($name, "_{n}({0})")
        )
    };
    ($function:ident, $n:literal, $name:literal, $domain:expr, $smooth:expr, $c:expr, $rust:expr) => {
        own!(Function::$function($n), $name, $domain, $smooth, "the next of the family", $c, $rust)
    };
}
pub(crate) static ASINH: [FunctionRow; 4] = orders!(Asinh, "asinh", All, All, "asinh{f}({0})", "asinh({0})");
pub(crate) static ACOSH: [FunctionRow; 4] =
    orders!(Acosh, "acosh", AtLeast(1.0), Above(1.0), "acosh{f}({0})", "acosh({0})");
pub(crate) static ATANH: [FunctionRow; 4] =
    orders!(Atanh, "atanh", Inside, Inside, "atanh{f}({0})", "atanh({0})");
pub(crate) static SINC: [FunctionRow; 4] =
    orders!(Sinc, "sinc", All, All, "forcec_sinc_{p}({0})", "sinc({0})");
pub(crate) static ERF: FunctionRow =
    own!(Function::Erf, "erf", All, All, "2/√π exp(−x²)", "erf{f}({0})", "erf({0})");
pub(crate) static ERFC: FunctionRow =
    own!(Function::Erfc, "erfc", All, All, "−2/√π exp(−x²)", "erfc{f}({0})", "erfc({0})");
pub(crate) static ERF_SLOPE: FunctionRow =
    own!(Function::ErfSlope, "erf_slope", All, All, "−2 x r", "forcec_erf_slope_{p}({0})", "erf_slope({0})");
pub(crate) static LOGISTIC: FunctionRow = own!(
    Function::Logistic,
    "logistic",
    All,
    All,
    "exp x / (1 + exp x)²",
    "forcec_logistic_{p}({0})",
    "logistic({0})"
);
pub(crate) static LOGISTIC_SLOPE: FunctionRow = own!(
    Function::LogisticSlope,
    "logistic_slope",
    All,
    All,
    "−r tanh(x/2)",
    "forcec_logistic_slope_{p}({0})",
    "logistic_slope({0})"
);
pub(crate) static SOFTPLUS: FunctionRow = own!(
    Function::Softplus,
    "softplus",
    All,
    All,
    "1 / (1 + exp(−x))",
    "forcec_softplus_{p}({0})",
    "softplus({0})"
);
pub(crate) static LN_COSH: FunctionRow =
    own!(Function::LnCosh, "ln_cosh", All, All, "tanh x", "forcec_ln_cosh_{p}({0})", "ln_cosh({0})");
