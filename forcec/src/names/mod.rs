//! Identifiers: the names in kernels in C and in Rust, derived from the names in a source.
//!
//! In: names as the author wrote them, ASCII identifiers of Rust. Out: unique names that are not keywords or
//! macros, shadow nothing, and cause no compiler warning. A valid name is kept. Any other name is converted
//! to the style of the target; if the result is taken, it gets the suffix `_`, or else a number.

pub(crate) mod values;

use crate::model::bodies::Signature;
use crate::model::outputs::{Part, Piece};
use rustc_hash::FxHashSet;
use std::sync::LazyLock;

/// A language that kernels are printed in.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Target {
    /// C99
    C,
    /// Rust
    Rust,
}

impl Target {
    /// All languages.
    pub const ALL: [Target; 2] = [Target::C, Target::Rust];

    /// The name in options.
    pub fn name(self) -> &'static str {
        match self {
            Target::C => "c",
            Target::Rust => "rust",
        }
    }
}

/// Keywords of C up to C23, of C++ up to C++26 and of common extensions, and macros with the form of names
/// that `<math.h>` or compilers define. Macros of `<complex.h>`, `<errno.h>` and `<stdio.h>` are included
/// because a program may include these headers first.
const C_WORDS: &str = "alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t \
    char8_t class co_await co_return co_yield compl concept const const_cast consteval constexpr constinit continue \
    contract_assert decltype default delete do double dynamic_cast else enum explicit export extern false float for \
    friend goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private \
    protected public register reinterpret_cast requires restrict return short signed sizeof static static_assert \
    static_cast struct switch template this thread_local throw true try typedef typeid typename typeof typeof_unqual \
    union unsigned using virtual void volatile wchar_t while xor xor_eq \
    unix linux i386 I complex imaginary noreturn errno signgam math_errhandling EOF NULL stdin stdout stderr \
    NAN INFINITY HUGE HUGE_VAL HUGE_VALF HUGE_VALL HUGE_VAL_F32 HUGE_VAL_F64 HUGE_VAL_F128 HUGE_VAL_F32X \
    HUGE_VAL_F64X SNAN SNANF SNANL SNANF32 SNANF64 SNANF128 SNANF32X SNANF64X MAXFLOAT FP_FAST_FMA FP_FAST_FMAF \
    FP_FAST_FMAL FP_ILOGB0 FP_ILOGBNAN FP_INFINITE FP_INT_DOWNWARD FP_INT_TONEAREST FP_INT_TONEARESTFROMZERO \
    FP_INT_TOWARDZERO FP_INT_UPWARD FP_LLOGB0 FP_LLOGBNAN FP_NAN FP_NORMAL FP_SUBNORMAL FP_ZERO MATH_ERREXCEPT \
    MATH_ERRNO DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS X_TLOSS BIG_ENDIAN LITTLE_ENDIAN PDP_ENDIAN BYTE_ORDER \
    EXIT_FAILURE EXIT_SUCCESS FD_SETSIZE MB_CUR_MAX NFDBITS RAND_MAX WCONTINUED WEXITED WNOHANG WNOWAIT WSTOPPED \
    WUNTRACED FORCEC_PI FORCEC_PI_F32 FORCEC_APART";

/// The constants of `<math.h>`, without the suffixes of the GNU library.
const C_CONSTANTS: &str = "M_E M_LOG2E M_LOG10E M_LN2 M_LN10 M_PI M_PI_2 M_PI_4 M_1_PI M_2_PI M_2_SQRTPI M_SQRT2 \
    M_SQRT1_2 M_TWOPI M_3PI_4 M_SQRTPI M_SQRT3 M_LN2LO M_LN2HI M_IVLN10 M_LOG2_E M_INVLN2";

/// Keywords of Rust.
const RUST_WORDS: &str = "abstract as async await become box break const continue crate do dyn else enum extern false \
    final fn for gen if impl in let loop macro match mod move mut override priv pub ref return self static struct \
    super trait true try type typeof unsafe unsized use virtual where while yield";

/// Functions of `<math.h>`, without the suffixes `f` and `l`, and other words that are unsuitable as local
/// names: they would shadow a function, headers of some platforms define them, or clippy warns about them.
const LOCAL_WORDS: &str = "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 \
    fabs fdim floor fma fmax fmin fmod frexp gamma hypot ilogb ldexp lgamma llrint llround log log10 log1p log2 logb \
    lrint lround modf nan nearbyint nextafter nexttoward pow remainder remquo rint round scalbln scalbn signbit sin \
    sinh sqrt tan tanh tgamma trunc j0 j1 jn y0 y1 yn drem finite significand scalb exp10 pow10 sincos isnan isinf \
    isfinite isnormal fpclassify abs labs div index main printf malloc free time clock near far min max small hyper \
    interface evaluate f32 f64 usize core std foo baz quux sinc erf_slope logistic logistic_slope softplus ln_cosh";

/// Whether a Rust module and its file can have this name.
pub(crate) fn is_module(stem: &str) -> bool {
    let letters = stem.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    let first = stem.bytes().next().is_some_and(|byte| !byte.is_ascii_digit());
    letters && first && stem != "_" && stem != "Self" && !is_in(stem, RUST_WORDS)
}

fn is_in(word: &str, list: &str) -> bool {
    list.split_ascii_whitespace().any(|entry| entry == word)
}

/// Whether this is a macro: a constant of `<math.h>`, or the include guard of a generated header.
fn is_macro(name: &str) -> bool {
    let gnu = ["", "f", "l", "f32", "f64", "f128", "f32x", "f64x"];
    let constant = |end: &&str| name.strip_suffix(*end).is_some_and(|base| is_in(base, C_CONSTANTS));
    name.starts_with("M_") && gnu.iter().any(constant) || name.starts_with("FORCEC_") && name.ends_with("_H")
}

/// Whether a field of a struct must not have this name. A field conflicts only with other fields.
fn is_no_field(name: &str, target: Target) -> bool {
    let keyword = target == Target::Rust && is_in(name, RUST_WORDS);
    keyword || is_in(name, C_WORDS) || ["out", "params"].contains(&name) || is_macro(name)
}

/// Whether a body or temporary must not have this name: in some target, it would shadow a function or type.
pub(crate) fn is_no_local(name: &str) -> bool {
    static WORDS: LazyLock<FxHashSet<String>> = LazyLock::new(|| {
        let words = [C_WORDS, RUST_WORDS, LOCAL_WORDS, "out params prepared shared lane"].into_iter();
        let words = words.flat_map(str::split_ascii_whitespace).map(str::to_owned);
        let functions = LOCAL_WORDS.split_ascii_whitespace();
        let precise = functions.flat_map(|name| [format!("{name}f"), format!("{name}l")]);
        words.chain(precise).collect()
    });
    // Names of ours: in C, types and functions end in the precision; in Rust, special functions in the order.
    let precise = || name.ends_with("_f64") || name.ends_with("_f32");
    const FAMILIES: [&str; 6] = ["cos_sqrt_", "angle_ratio_", "asinh_", "acosh_", "atanh_", "sinc_"];
    let order = || FAMILIES.iter().find_map(|family| name.strip_prefix(family));
    WORDS.contains(name) || is_macro(name) || precise() || order().is_some_and(|order| order.len() == 1)
}

/// A name in the style of a target, not necessarily a free one: without adjacent underscores, which C++
/// reserves; in C without an underscore before a leading capital; in Rust in snake case, as rustc suggests.
/// Characters that are neither letters nor digits become underscores, and a name without letters gets one.
pub(crate) fn spelled(name: &str, target: Target) -> String {
    let mut text = String::new();
    let mut before = '_';
    for letter in name.chars() {
        let letter = if letter.is_ascii_alphanumeric() { letter } else { '_' };
        if letter.is_ascii_uppercase() {
            match target {
                Target::C if text == "_" => text.clear(),
                Target::Rust if before.is_ascii_lowercase() || before.is_ascii_digit() => text.push('_'),
                _ => {}
            }
        }
        if letter != '_' || !text.ends_with('_') {
            text.push(if target == Target::Rust { letter.to_ascii_lowercase() } else { letter });
        }
        before = letter;
    }
    if text.contains(|c: char| c.is_ascii_alphabetic()) { text } else { format!("x{text}") }
}

/// Unique names in one scope. Each name is given as the author wrote it and in the style of the target.
fn distinct(names: &[(&str, String)], reserved: impl Fn(&str) -> bool) -> Vec<String> {
    // Of two equal names, the first is kept.
    let mut taken: FxHashSet<String> = FxHashSet::default();
    let mut stay = |(name, spelled): &(&str, String)| {
        name == spelled && !reserved(name) && taken.insert(spelled.clone())
    };
    let stays: Vec<bool> = names.iter().map(&mut stay).collect();
    let mut free = |spelled: &str| {
        let stem = spelled.trim_end_matches('_');
        let numbers = (2..).map(|number| format!("{stem}_{number}"));
        let mut candidates = [spelled.to_owned(), format!("{stem}_")].into_iter().chain(numbers);
        candidates.find(|name| !reserved(name) && taken.insert(name.clone())).expect("numbers do not end")
    };
    let names = names.iter().zip(stays);
    names.map(|((_, spelled), stays)| if stays { spelled.clone() } else { free(spelled) }).collect()
}

/// Names of a kernel's arguments in a target.
#[derive(Clone, Debug, Default)]
pub struct Arguments {
    /// The bodies, in one scope with `params`, `out` and the temporaries.
    pub bodies: Vec<String>,
    /// The argument that contains the parameters.
    pub given: &'static str,
    /// The parameters, fields of a struct.
    pub parameters: Vec<String>,
    /// The extra arguments, in the same scope as the bodies.
    pub extras: Vec<String>,
    /// The outputs that a layout stores in place of others, fields of a struct.
    pub pieces: Vec<String>,
}

impl Arguments {
    /// Chooses the names of a signature's arguments.
    pub fn new(signature: &Signature, target: Target) -> Arguments {
        // In Rust, an unread body gets a leading underscore, so no other body may have one.
        let bare = |name: &str| spelled(name.trim_start_matches('_'), target);
        let bodies = signature.bodies.iter().map(|body| (body.name.as_str(), bare(&body.name)));
        let parameters = signature.parameters.iter().map(|parameter| parameter.name.as_str());
        let parameters = parameters.map(|name| (name, spelled(name, target)));
        let extras = signature.extras.iter().map(|extra| (extra.name.as_str(), extra.name.clone()));
        // Extra arguments first, so that bodies do not change their names.
        let mut extras = distinct(&extras.chain(bodies).collect::<Vec<_>>(), is_no_local);
        let locals = extras.split_off(signature.extras.len());
        let fields = |names: &[(&str, String)]| distinct(names, |name| is_no_field(name, target));
        let pieces: Vec<String> = signature.pieces.iter().map(Piece::name).collect();
        let pieces: Vec<_> = pieces.iter().map(|name| (name.as_str(), spelled(name, target))).collect();
        Arguments {
            bodies: locals,
            extras,
            given: if signature.prepared { "prepared" } else { "params" },
            parameters: fields(&parameters.collect::<Vec<_>>()),
            pieces: fields(&pieces),
        }
    }

    /// The field of an output.
    pub fn result(&self, part: Part) -> &str {
        match part {
            Part::List(place) | Part::Block(place) => &self.pieces[place as usize],
            part => part.name(),
        }
    }
}

/// The name of an item of a kernel in a target: in C with a suffix such as `_f64` or `_params_f64`, in Rust
/// without a suffix or with `_f32`.
pub fn kernel_name(kernel: &str, target: Target, suffix: &str) -> String {
    let name = spelled(kernel, target);
    match suffix {
        "" if is_in(&name, RUST_WORDS) => format!("{name}_"),
        "" => name,
        _ => format!("{}{suffix}", name.trim_end_matches('_')),
    }
}

/// Names of all items that are defined for a kernel of this name, including the C tables of its layout.
pub(crate) fn defined_for(kernel: &str, tables: &[String]) -> Vec<(Target, String)> {
    let c = ["_f64", "_params_f64", "_out_f64", "_prepare_f64", "_prepared_f64", "_anchored_f64"];
    let c = c.into_iter().chain(tables.iter().map(String::as_str)).map(|suffix| (Target::C, suffix));
    let suffixes = c.chain(["", "_f32"].map(|suffix| (Target::Rust, suffix)));
    suffixes.map(|(target, suffix)| (target, kernel_name(kernel, target, suffix))).collect()
}

#[cfg(test)]
mod tests {
    use super::{Arguments, Target, kernel_name};
    use crate::model::bodies::{Body, BodyKind, Domain, Parameter, ParameterType, Signature};

    fn fields(names: &[&str], target: Target) -> Vec<String> {
        let field = |name: &&str| Parameter {
            name: (*name).to_owned(),
            ty: ParameterType::Real,
            domain: Domain::Any,
            value: None,
        };
        let parameters = names.iter().map(field).collect();
        Arguments::new(&Signature { bodies: vec![], parameters, rows: 0, ..Signature::default() }, target)
            .parameters
    }

    fn bodies(names: &[&str], target: Target) -> Vec<String> {
        let bodies = names.iter().map(|name| Body {
            name: (*name).to_owned(),
            kind: BodyKind::PARTICLE,
            fixed: false,
        });
        Arguments::new(
            &Signature { bodies: bodies.collect(), parameters: vec![], rows: 0, ..Signature::default() },
            target,
        )
        .bodies
    }

    #[test]
    fn what_collides_gets_an_underscore_or_else_a_number() {
        let names = ["double", "double_", "template", "params", "sin", "linux", "M_PIf", "I", "M_x"];
        let expected =
            ["double_2", "double_", "template_", "params_", "sin", "linux_", "M_PIf_", "I_", "M_x"];
        assert_eq!(fields(&names, Target::C), expected);
        let names = ["sin", "sin_", "sqrtf", "f_out_f64", "foo", "wheel", "K", "_wheel"];
        let expected = ["sin_2", "sin_", "sqrtf_", "f_out_f64_", "foo_", "wheel", "K", "wheel_"];
        assert_eq!(bodies(&names, Target::C), expected);
        assert_eq!(bodies(&["a", "a", "lane"], Target::Rust), ["a", "a_", "lane_"]);
    }

    #[test]
    fn what_c_reserves_is_spelled_otherwise() {
        let names = ["__x", "_X", "a__b", "_x", "_1", "__", "FORCEC_H", "restLength"];
        let expected = ["_x_", "X", "a_b", "_x", "x_1", "x_", "FORCEC_H_", "restLength"];
        assert_eq!(fields(&names, Target::C), expected);
    }

    #[test]
    fn rust_has_snake_case() {
        let names = ["K", "k", "restLength", "EA", "M_PI", "Type", "gen", "dX1Y", "_K", "__x", "stiffness"];
        let expected =
            ["k_", "k", "rest_length", "ea", "m_pi", "type_", "gen_", "d_x1_y", "_k", "_x", "stiffness"];
        assert_eq!(fields(&names, Target::Rust), expected);
        assert_eq!(fields(&["k_", "K", "k"], Target::Rust), ["k_", "k_2", "k"]);
        assert_eq!(kernel_name("Match", Target::Rust, ""), "match_");
        assert_eq!(kernel_name("Match", Target::Rust, "_f32"), "match_f32");
        assert_eq!(kernel_name("int", Target::Rust, ""), "int");
        assert_eq!(kernel_name("int_", Target::C, "_out_f64"), "int_out_f64");
    }
}
