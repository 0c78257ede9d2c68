//! The table of built-in functions and methods.

use crate::check::builtins::matrices::{self, Matrix3};
use crate::check::builtins::quaternions::{self, Quaternion};
use crate::check::builtins::{Builtin, Place, Shape};
use crate::check::elaborator::Elaborator;
use crate::check::operators::{inner, quotient};
use crate::check::singular::risks::{AtZero, RiskKind};
use crate::check::values::Value;
use crate::math::exact::Exact;
use crate::math::functions::{Function, FunctionDomain};
use crate::source::span::Span;
use crate::vector::{Graph, Real};
use std::rc::Rc;

/// The table, grouped by kind of receiver.
pub(crate) static TABLE: [&[Builtin]; 7] =
    [REALS, VECTOR_TYPES, VECTORS, MATRIX_TYPES, MATRICES, QUATERNION_TYPES, QUATERNIONS];

/// Rows `on name(arguments) -> result, summary, handler`.
macro_rules! table {
    ($place:ident: $($on:expr, $name:literal ($($argument:expr),*) -> $result:expr, $summary:literal, $apply:expr;)*) => {
        &[$(Builtin {
            name: $name,
            place: Place::$place,
            on: $on,
            arguments: &[$($argument),*],
            result: $result,
            summary: $summary,
            apply: $apply,
        }),*]
    };
}

use Shape::{
    Columns, Flipped, Line, Matrices, Matrix, Pair, Quat, Real as R, Rotation, Rows, Same, Small, Square,
    Transposed, Vector, Vectors,
};

/// Calls a function of the function table and records where it can be singular.
fn function(e: &mut Elaborator<'_>, f: Function, x: &[Value], span: Span) -> Value {
    let arguments: Vec<Real> = x.iter().map(Value::real).collect();
    match f.row().smooth {
        FunctionDomain::NotAllZero if matches!(f, Function::Abs | Function::Signum) => {}
        FunctionDomain::All => {}
        _ if arguments.len() == 2 && f != Function::Powf => {
            let squares = inner(&mut e.graph, &arguments, &arguments);
            e.risk(RiskKind::Pair(f), squares, span);
        }
        _ if f == Function::Powf => {
            let kind = match e.graph.value(arguments[1]) {
                None => Some(RiskKind::Call(f)),
                Some(y) => match y.to_i64() {
                    None => Some(RiskKind::Power(AtZero::of(y))),
                    // A power with an integer exponent is also defined for negative bases.
                    Some(n) => (n < 0).then_some(RiskKind::NegativePower),
                },
            };
            if let Some(kind) = kind {
                e.risk(kind, arguments[0], span);
            }
        }
        _ => e.risk(RiskKind::Call(f), arguments[0], span),
    }
    Value::Real(e.graph.call(f, &arguments))
}

macro_rules! f {
    ($function:ident $($order:tt)?) => {
        |e, x, span| function(e, Function::$function $($order)?, x, span)
    };
}

/// Methods of reals.
static REALS: &[Builtin] = table![Value:
    R, "abs"() -> R, "absolute value", f!(Abs);
    R, "sqrt"() -> R, "square root", f!(Sqrt);
    R, "cbrt"() -> R, "cube root", f!(Cbrt);
    R, "recip"() -> R, "1 / x", |e, x, span| {
        e.risk(RiskKind::Division, x[0].real(), span);
        Value::Real(e.graph.powi(x[0].real(), -1))
    };
    R, "powi"(Small) -> R, "power with an integer exponent", |e, x, span| power(e, x, span);
    R, "powf"(R) -> R, "power with a real exponent, of a value that is not negative", f!(Powf);
    R, "exp"() -> R, "exponential", f!(Exp);
    R, "ln"() -> R, "natural logarithm", f!(Ln);
    R, "ln_1p"() -> R, "ln(1 + x)", f!(Ln1p);
    R, "exp_m1"() -> R, "exp(x) - 1", f!(ExpM1);
    R, "sin"() -> R, "sine", f!(Sin);
    R, "cos"() -> R, "cosine", f!(Cos);
    R, "sin_cos"() -> Pair, "sine and cosine", |e, x, _| {
        let sine = e.graph.call(Function::Sin, &[x[0].real()]);
        let cosine = e.graph.call(Function::Cos, &[x[0].real()]);
        Value::tuple(vec![Value::Real(sine), Value::Real(cosine)])
    };
    R, "tan"() -> R, "tangent", f!(Tan);
    R, "asin"() -> R, "arc sine", f!(Asin);
    R, "acos"() -> R, "arc cosine", f!(Acos);
    R, "atan"() -> R, "arc tangent", f!(Atan);
    R, "atan2"(R) -> R, "angle of the point (x, y), called on y", f!(Atan2);
    R, "sinh"() -> R, "hyperbolic sine", f!(Sinh);
    R, "cosh"() -> R, "hyperbolic cosine", f!(Cosh);
    R, "tanh"() -> R, "hyperbolic tangent", f!(Tanh);
    R, "asinh"() -> R, "inverse hyperbolic sine", f!(Asinh (0));
    R, "acosh"() -> R, "inverse hyperbolic cosine", f!(Acosh (0));
    R, "atanh"() -> R, "inverse hyperbolic tangent", f!(Atanh (0));
    R, "erf"() -> R, "error function", f!(Erf);
    R, "erfc"() -> R, "1 - erf(x), with all its digits where that is small", f!(Erfc);
    R, "sinc"() -> R, "sin(x) / x, 1 at 0", f!(Sinc (0));
    R, "versine"() -> R, "(1 - cos(x)) / x², ½ at 0", |e, x, _| {
        // ½ sinc²(x/2), which has no cancellation.
        let half = e.graph.scaled(Exact::ratio(1, 2), x[0].real());
        let sinc = e.graph.call(Function::Sinc(0), &[half]);
        let square = e.graph.powi(sinc, 2);
        Value::Real(e.graph.scaled(Exact::ratio(1, 2), square))
    };
    R, "logistic"() -> R, "1 / (1 + exp(-x))", f!(Logistic);
    R, "softplus"() -> R, "ln(1 + exp(x))", f!(Softplus);
    R, "ln_cosh"() -> R, "ln(cosh(x))", f!(LnCosh);
    R, "hypot"(R) -> R, "square root of x² + y²", f!(Hypot);
    R, "min"(R) -> R, "the smaller", f!(Min);
    R, "max"(R) -> R, "the larger", f!(Max);
    R, "clamp"(R, R) -> R, "x, or the bound it lies beyond", |e, x, _| {
        let above = e.graph.call(Function::Max, &[x[0].real(), x[1].real()]);
        Value::Real(e.graph.call(Function::Min, &[above, x[2].real()]))
    };
    R, "signum"() -> R, "1 or -1, the sign; of ±0 too", f!(Signum);
];

fn power(e: &mut Elaborator<'_>, x: &[Value], span: Span) -> Value {
    let Ok(n) = i32::try_from(x[1].integer()) else {
        return e.error(span, "an exponent out of range", "beyond the range of `i32`");
    };
    if n < 0 {
        e.risk(RiskKind::NegativePower, x[0].real(), span);
    }
    Value::Real(e.graph.powi(x[0].real(), n))
}

/// The entries of a vector.
fn entries(g: &mut Graph, vector: &Value) -> Vec<Real> {
    match vector {
        Value::Vector(v) => [0, 1, 2].map(|axis| g.component(*v, axis)).to_vec(),
        Value::Few(entries) => entries.to_vec(),
        other => unreachable!("checked to be a vector: {other:?}"),
    }
}

/// A vector from its entries.
fn from_entries(g: &mut Graph, entries: &[Real]) -> Value {
    match *entries {
        [x, y, z] => Value::Vector(g.pack([x, y, z])),
        _ => Value::Few(entries.into()),
    }
}

fn new_vector(e: &mut Elaborator<'_>, x: &[Value], _: Span) -> Value {
    let entries: Vec<Real> = x.iter().map(Value::real).collect();
    from_entries(&mut e.graph, &entries)
}

/// The unit vector along an axis.
fn unit_vector(e: &mut Elaborator<'_>, n: usize, axis: usize) -> Value {
    if n == 3 {
        return Value::Vector(e.graph.basis(axis as u8));
    }
    let (zero, one) = (e.graph.zero(), e.graph.one());
    Value::Few((0..n).map(|k| if k == axis { one } else { zero }).collect())
}

fn zero_vector(e: &mut Elaborator<'_>, n: usize) -> Value {
    if n == 3 {
        return Value::Vector(e.graph.zero_vector());
    }
    let zero = e.graph.zero();
    Value::Few(vec![zero; n].into())
}

/// Constructors of vectors.
static VECTOR_TYPES: &[Builtin] = table![Type:
    Vector(2), "new"(R, R) -> Same, "from its entries", new_vector;
    Vector(3), "new"(R, R, R) -> Same, "from its entries", new_vector;
    Vector(4), "new"(R, R, R, R) -> Same, "from its entries", new_vector;
    Vector(2), "zeros"() -> Same, "zero", |e, _, _| zero_vector(e, 2);
    Vector(3), "zeros"() -> Same, "zero", |e, _, _| zero_vector(e, 3);
    Vector(4), "zeros"() -> Same, "zero", |e, _, _| zero_vector(e, 4);
    Vector(2), "x"() -> Same, "unit vector along x", |e, _, _| unit_vector(e, 2, 0);
    Vector(2), "y"() -> Same, "unit vector along y", |e, _, _| unit_vector(e, 2, 1);
    Vector(3), "x"() -> Same, "unit vector along x", |e, _, _| unit_vector(e, 3, 0);
    Vector(3), "y"() -> Same, "unit vector along y", |e, _, _| unit_vector(e, 3, 1);
    Vector(3), "z"() -> Same, "unit vector along z", |e, _, _| unit_vector(e, 3, 2);
    Vector(4), "x"() -> Same, "unit vector along x", |e, _, _| unit_vector(e, 4, 0);
    Vector(4), "y"() -> Same, "unit vector along y", |e, _, _| unit_vector(e, 4, 1);
    Vector(4), "z"() -> Same, "unit vector along z", |e, _, _| unit_vector(e, 4, 2);
    Vector(4), "w"() -> Same, "unit vector along w", |e, _, _| unit_vector(e, 4, 3);
];

fn dot(g: &mut Graph, u: &Value, v: &Value) -> Real {
    match (u, v) {
        (Value::Vector(u), Value::Vector(v)) => g.dot(*u, *v),
        _ => {
            let (u, v) = (entries(g, u), entries(g, v));
            inner(g, &u, &v)
        }
    }
}

fn norm(g: &mut Graph, v: &Value) -> Real {
    match v {
        Value::Vector(v) => g.norm(*v),
        _ => {
            let square = dot(g, v, v);
            g.call(Function::Sqrt, &[square])
        }
    }
}

/// atan2(|u×v|, u·v)
fn angle_between(e: &mut Elaborator<'_>, x: &[Value], span: Span) -> Value {
    let g = &mut e.graph;
    let (u, v) = (x[0].vector(), x[1].vector());
    let cross = g.cross(u, v);
    let (sine, cosine) = (g.norm(cross), g.dot(u, v));
    let angle = g.call(Function::Atan2, &[sine, cosine]);
    e.risk(RiskKind::Parallel, sine, span);
    Value::Real(angle)
}

/// Methods of vectors.
static VECTORS: &[Builtin] = table![Value:
    Vectors, "dot"(Same) -> R, "inner product", |e, x, _| Value::Real(dot(&mut e.graph, &x[0], &x[1]));
    Vector(3), "cross"(Same) -> Same, "vector product", |e, x, _| {
        Value::Vector(e.graph.cross(x[0].vector(), x[1].vector()))
    };
    Vector(3), "angle"(Same) -> R, "angle between the two, 0 to π", angle_between;
    Vector(3), "angle_between"(Same) -> R, "the same", angle_between;
    Vectors, "norm"() -> R, "length", |e, x, span| {
        let norm = norm(&mut e.graph, &x[0]);
        e.risk(RiskKind::Norm, norm, span);
        Value::Real(norm)
    };
    Vectors, "norm_squared"() -> R, "squared length", |e, x, _| Value::Real(dot(&mut e.graph, &x[0], &x[0]));
    Vectors, "normalize"() -> Same, "vector of length one in the same direction", |e, x, span| {
        let norm = norm(&mut e.graph, &x[0]);
        e.risk(RiskKind::Normalize, norm, span);
        if let Value::Vector(v) = x[0] {
            return Value::Vector(e.graph.normalize(v));
        }
        quotient(&mut e.graph, &x[0], norm).unwrap_or(Value::Poison)
    };
    Vectors, "component_mul"(Same) -> Same, "product entry by entry", |e, x, _| {
        let g = &mut e.graph;
        let (u, v) = (entries(g, &x[0]), entries(g, &x[1]));
        let products: Vec<Real> = u.iter().zip(&v).map(|(u, v)| g.mul(*u, *v)).collect();
        from_entries(g, &products)
    };
    Vector(3), "outer"(Same) -> Square, "v wᵀ", |e, x, _| {
        Value::Matrix3(matrices::outer(&mut e.graph, x[0].vector(), x[1].vector()))
    };
    Vector(2), "outer"(Same) -> Square, "v wᵀ", |e, x, _| {
        let g = &mut e.graph;
        let (u, v) = (entries(g, &x[0]), entries(g, &x[1]));
        Value::Matrix2([0, 1, 2, 3].map(|k| g.mul(u[k / 2], v[k % 2])))
    };
    Vectors, "transpose"() -> Flipped, "row vector", |_, x, _| Value::Row(Rc::new(x[0].clone()));
    Rows, "transpose"() -> Flipped, "column vector", |_, x, _| match &x[0] {
        Value::Row(vector) => (**vector).clone(),
        other => unreachable!("checked to be a transpose: {other:?}"),
    };
];

/// Constructors of matrices.
static MATRIX_TYPES: &[Builtin] = table![Type:
    Matrix(2), "new"(R, R, R, R) -> Same, "from its entries, row by row", |_, x, _| {
        Value::Matrix2([0, 1, 2, 3].map(|k| x[k].real()))
    };
    Matrix(3), "new"(R, R, R, R, R, R, R, R, R) -> Same, "from its entries, row by row", |e, x, _| {
        let row = |k: usize| [x[3 * k].real(), x[3 * k + 1].real(), x[3 * k + 2].real()];
        Value::Matrix3(Matrix3::rows([0, 1, 2].map(|k| e.graph.pack(row(k)))))
    };
    Matrices, "from_columns"(Columns) -> Same, "from its columns", |e, x, _| from_lines(e, x[0].elements(), true);
    Matrices, "from_rows"(Transposed) -> Same, "from its rows, each transposed", |e, x, _| {
        let rows = x[0].elements().iter().map(|row| match row {
            Value::Row(vector) => (**vector).clone(),
            other => unreachable!("checked to be a transpose: {other:?}"),
        });
        let rows: Vec<Value> = rows.collect();
        from_lines(e, &rows, false)
    };
    Matrices, "from_diagonal"(Line) -> Same, "with these entries on the diagonal", |e, x, _| {
        let diagonal = entries(&mut e.graph, &x[0]);
        from_diagonal(e, &diagonal)
    };
    Matrix(2), "identity"() -> Same, "the unit matrix", |e, _, _| {
        let one = e.graph.one();
        from_diagonal(e, &[one; 2])
    };
    Matrix(3), "identity"() -> Same, "the unit matrix", |e, _, _| {
        let one = e.graph.one();
        from_diagonal(e, &[one; 3])
    };
    Matrix(2), "zeros"() -> Same, "zero", |e, _, _| {
        let zero = e.graph.zero();
        Value::Matrix2([zero; 4])
    };
    Matrix(3), "zeros"() -> Same, "zero", |e, _, _| {
        let zero = e.graph.zero_vector();
        Value::Matrix3(Matrix3::columns([zero; 3]))
    };
];

fn from_lines(e: &mut Elaborator<'_>, lines: &[Value], columns: bool) -> Value {
    if let [a, b] = lines {
        let (a, b) = (entries(&mut e.graph, a), entries(&mut e.graph, b));
        return Value::Matrix2(if columns { [a[0], b[0], a[1], b[1]] } else { [a[0], a[1], b[0], b[1]] });
    }
    Value::Matrix3(Matrix3 { lines: [0, 1, 2].map(|k| lines[k].vector()), columns })
}

fn from_diagonal(e: &mut Elaborator<'_>, diagonal: &[Real]) -> Value {
    match *diagonal {
        [x, y, z] => Value::Matrix3(matrices::diagonal(&mut e.graph, [x, y, z])),
        _ => {
            let zero = e.graph.zero();
            Value::Matrix2([diagonal[0], zero, zero, diagonal[1]])
        }
    }
}

fn determinant(g: &mut Graph, m: &Value) -> Real {
    match m {
        Value::Matrix2([a, b, c, d]) => {
            let (ad, bc) = (g.mul(*a, *d), g.mul(*b, *c));
            g.sub(ad, bc)
        }
        Value::Matrix3(m) => matrices::determinant(g, *m),
        other => unreachable!("checked to be a matrix: {other:?}"),
    }
}

/// Methods of matrices.
static MATRICES: &[Builtin] = table![Value:
    Matrices, "transpose"() -> Same, "rows for columns", |_, x, _| match &x[0] {
        Value::Matrix2([a, b, c, d]) => Value::Matrix2([*a, *c, *b, *d]),
        Value::Matrix3(m) => Value::Matrix3(m.transpose()),
        other => unreachable!("checked to be a matrix: {other:?}"),
    };
    Matrices, "determinant"() -> R, "determinant", |e, x, _| Value::Real(determinant(&mut e.graph, &x[0]));
    Matrices, "trace"() -> R, "sum of the diagonal", |e, x, _| Value::Real(match &x[0] {
        Value::Matrix2([a, _, _, d]) => e.graph.add(*a, *d),
        Value::Matrix3(m) => matrices::trace(&mut e.graph, *m),
        other => unreachable!("checked to be a matrix: {other:?}"),
    });
    Matrices, "inverse"() -> Same, "inverse", |e, x, span| {
        let (inverse, determinant) = match &x[0] {
            Value::Matrix2([a, b, c, d]) => {
                let determinant = determinant(&mut e.graph, &x[0]);
                let g = &mut e.graph;
                let adjugate = Value::Matrix2([*d, g.neg(*b), g.neg(*c), *a]);
                (quotient(g, &adjugate, determinant).unwrap_or(Value::Poison), determinant)
            }
            Value::Matrix3(m) => {
                let (inverse, determinant) = matrices::inverse(&mut e.graph, *m);
                (Value::Matrix3(inverse), determinant)
            }
            other => unreachable!("checked to be a matrix: {other:?}"),
        };
        e.risk(RiskKind::Inverse, determinant, span);
        inverse
    };
    Matrices, "norm_squared"() -> R, "sum of the squared entries", |e, x, _| Value::Real(match &x[0] {
        Value::Matrix2(entries) => inner(&mut e.graph, entries, entries),
        Value::Matrix3(m) => matrices::norm_squared(&mut e.graph, *m),
        other => unreachable!("checked to be a matrix: {other:?}"),
    });
];

/// Constructors of quaternions.
static QUATERNION_TYPES: &[Builtin] = table![Type:
    Quat, "identity"() -> Same, "no rotation", |_, _, _| Value::Quat(Quaternion::identity());
    Quat, "from_scaled_axis"(Vector(3)) -> Same, "rotation about an axis, by its length", |e, x, _| {
        Value::Quat(quaternions::from_scaled_axis(&mut e.graph, x[0].vector()))
    };
];

/// Methods of quaternions.
static QUATERNIONS: &[Builtin] = table![Value:
    Quat, "inverse"() -> Same, "the opposite rotation", |e, x, _| {
        Value::Quat(quaternions::inverse(&mut e.graph, x[0].quat()))
    };
    Quat, "conjugate"() -> Same, "the opposite rotation", |e, x, _| {
        Value::Quat(quaternions::inverse(&mut e.graph, x[0].quat()))
    };
    Quat, "to_rotation_matrix"() -> Rotation, "the matrix, once `into_inner` follows", |_, x, _| {
        Value::Rotation(x[0].quat().clone())
    };
    Rotation, "into_inner"() -> Matrix(3), "the matrix of a rotation", |e, x, _| {
        let g = &mut e.graph;
        Value::Matrix3(Matrix3::columns([0, 1, 2].map(|axis| {
            let basis = g.basis(axis);
            quaternions::rotate(g, x[0].quat(), basis)
        })))
    };
    Rotation, "inverse"() -> Same, "the opposite rotation", |e, x, _| {
        Value::Rotation(quaternions::inverse(&mut e.graph, x[0].quat()))
    };
    Rotation, "transpose"() -> Same, "the opposite rotation", |e, x, _| {
        Value::Rotation(quaternions::inverse(&mut e.graph, x[0].quat()))
    };
    Quat, "imag"() -> Vector(3), "the imaginary part", |e, x, _| {
        Value::Vector(quaternions::imaginary(&mut e.graph, x[0].quat()))
    };
    Quat, "angle"() -> R, "angle of the rotation, 0 to π", |e, x, span| angle(e, x[0].quat(), span);
    Quat, "angle_to"(Same) -> R, "angle of the rotation between the two, 0 to π", |e, x, span| {
        let inverse = quaternions::inverse(&mut e.graph, x[0].quat());
        let between = quaternions::product(&mut e.graph, x[1].quat(), &inverse);
        angle(e, &between, span)
    };
    Quat, "scaled_axis"() -> Vector(3), "axis times angle, angle 0 to π", |e, x, _| {
        Value::Vector(quaternions::scaled_axis(&mut e.graph, x[0].quat()))
    };
];

fn angle(e: &mut Elaborator<'_>, q: &Quaternion, span: Span) -> Value {
    let (angle, sine) = quaternions::angle(&mut e.graph, q);
    e.risk(RiskKind::Angle, sine, span);
    Value::Real(angle)
}
