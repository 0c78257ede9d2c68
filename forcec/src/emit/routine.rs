//! The special functions as statements, recorded from the code that evaluates them.
//!
//! In: a function and a precision. Out: a [`Routine`]: its arguments, its early returns, and the statements
//! of both branches. Coefficients that round to zero in the precision are omitted from the series.

use crate::kernel::Precision;
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::math::number::{Arithmetic, Choice, Comparison};
use crate::math::special;
use crate::schedule::{Expression, Name, Statement, Variable};
use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::rc::Rc;

/// A special function that the generated code defines.
pub(crate) struct Routine {
    /// A description of the function.
    pub(crate) summary: String,
    /// The number of arguments; the arguments are the first variables.
    pub(crate) arguments: usize,
    /// Arguments and temporaries.
    pub(crate) variables: Vec<Variable>,
    /// The statements before the final result.
    pub(crate) steps: Vec<Step>,
    /// The final result.
    pub(crate) result: Expression,
}

/// A step of a routine.
pub(crate) enum Step {
    /// Defines a temporary.
    Do(Statement),
    /// If the condition is true, executes the statements and returns the result.
    Return(Expression, Vec<Statement>, Expression),
}

/// The definition of a function; `None` for functions that every target provides.
pub(crate) fn routine(function: Function, precision: Precision) -> Option<Routine> {
    match precision {
        Precision::F64 => record::<false>(function),
        Precision::F32 => record::<true>(function),
    }
}

fn record<const SINGLE: bool>(function: Function) -> Option<Routine> {
    let below = |x: Expression, y: Expression| Expression::Compare(Comparison::Less, Box::new([x, y]));
    let recorder = Recorder::default();
    let (summary, arguments, result) = match function {
        Function::CosSqrt(order) => {
            let n = u32::from(order);
            let [s] = recorder.arguments::<SINGLE, 1>(["s"]);
            if let Some(switch) = special::cos_sqrt_switch(n) {
                let condition = below(s.value.clone(), Expression::Literal(switch));
                recorder.choice(condition, || special::cos_sqrt_near(n, s.clone()));
            }
            (format!("{}cos sqrt(s), s >= 0", derivative(n, "s")), 1, special::cos_sqrt_far(n, s))
        }
        Function::AngleRatio(order) => {
            let n = u32::from(order);
            let [m, w] = recorder.arguments::<SINGLE, 2>(["m", "w"]);
            let switch = Expression::Literal(special::angle_ratio_switch());
            let bound = Expression::Quotient(vec![switch, w.value.clone(), w.value.clone()], vec![]);
            let zero = Expression::Literal(Exact::ZERO);
            let condition =
                Expression::And(Box::new([below(zero, w.value.clone()), below(m.value.clone(), bound)]));
            recorder.choice(condition, || special::angle_ratio_near(n, m.clone(), w.clone()));
            let summary = format!("{}atan2(sqrt(m), w) / sqrt(m), m >= 0", derivative(n, "m"));
            (summary, 2, special::angle_ratio_far(n, m, w))
        }
        _ => {
            let [x] = recorder.arguments::<SINGLE, 1>(["x"]);
            let formula = match function {
                Function::Asinh(_) => "asinh x",
                Function::Acosh(_) => "acosh x, x >= 1",
                Function::Atanh(_) => "atanh x, |x| < 1",
                Function::Sinc(_) => "sin(x) / x, 1 at 0",
                Function::Erf => "erf x",
                Function::Erfc => "erfc x",
                Function::ErfSlope => "d/dx erf x",
                Function::Logistic => "1 / (1 + exp(-x))",
                Function::LogisticSlope => "exp(x) / (1 + exp(x))^2",
                Function::Softplus => "ln(1 + exp(x))",
                _ => "ln cosh x",
            };
            let order = u32::from(function.order().unwrap_or_default());
            let result = special::evaluate(function, &[x])?;
            (format!("{}{formula}", derivative(order, "x")), 1, result)
        }
    };
    let (variables, steps) = (recorder.variables.take(), recorder.steps.take());
    Some(Routine { summary, arguments, variables, steps, result: result.value })
}

fn derivative(n: u32, by: &str) -> String {
    match n {
        0 => String::new(),
        1 => format!("d/d{by} "),
        _ => format!("d^{n}/d{by}^{n} "),
    }
}

#[derive(Clone, Default)]
struct Recorder {
    variables: Rc<RefCell<Vec<Variable>>>,
    steps: Rc<RefCell<Vec<Step>>>,
}

impl Recorder {
    fn arguments<const SINGLE: bool, const COUNT: usize>(
        &self,
        names: [&str; COUNT],
    ) -> [Trace<SINGLE>; COUNT] {
        names.map(|name| Trace { value: Expression::Name(self.variable(name)), recorder: Some(self.clone()) })
    }

    fn variable(&self, name: &str) -> Name {
        let mut variables = self.variables.borrow_mut();
        variables.push(Variable { name: name.to_owned(), truth: false });
        Name(variables.len() as u32 - 1)
    }

    /// Records an early return: the statements and the result of the branch where the condition is true.
    fn choice<const SINGLE: bool>(&self, condition: Expression, compute: impl FnOnce() -> Trace<SINGLE>) {
        let before = self.steps.take();
        let result = compute().value;
        let within = self.steps.replace(before);
        let statements = within.into_iter().filter_map(|step| match step {
            Step::Do(statement) => Some(statement),
            Step::Return(..) => None,
        });
        let chosen = Step::Return(condition, statements.collect(), result);
        self.steps.borrow_mut().push(chosen);
    }
}

/// A number that records the expression it was computed by; `SINGLE` rounds constants to `f32`.
#[derive(Clone)]
struct Trace<const SINGLE: bool> {
    value: Expression,
    recorder: Option<Recorder>,
}

impl<const SINGLE: bool> Trace<SINGLE> {
    fn is_zero(&self) -> bool {
        matches!(&self.value, Expression::Literal(value) if value.is_zero())
    }

    fn join(self, other: Self, join: impl FnOnce(Expression, Expression) -> Expression) -> Self {
        Trace { value: join(self.value, other.value), recorder: self.recorder.or(other.recorder) }
    }
}

impl<const SINGLE: bool> Arithmetic for Trace<SINGLE> {
    fn exact(value: &Exact) -> Self {
        let vanishes = SINGLE && value.to_f32() == 0.0;
        let value = Expression::Literal(if vanishes { Exact::ZERO } else { value.clone() });
        Trace { value, recorder: None }
    }

    fn digits() -> u32 {
        if SINGLE { f32::MANTISSA_DIGITS } else { f64::MANTISSA_DIGITS }
    }

    fn call(function: Function, arguments: &[Self]) -> Self {
        let recorder = arguments.iter().find_map(|x| x.recorder.clone());
        Trace {
            value: Expression::Call(function, arguments.iter().map(|x| x.value.clone()).collect()),
            recorder,
        }
    }

    fn named(self, name: &str) -> Self {
        match (&self.recorder, self.value.is_atom()) {
            (Some(recorder), false) => {
                let name = recorder.variable(name);
                recorder.steps.borrow_mut().push(Step::Do(Statement::Let(name, self.value)));
                Trace { value: Expression::Name(name), recorder: self.recorder }
            }
            _ => self,
        }
    }
}

impl<const SINGLE: bool> Choice for Trace<SINGLE> {
    /// Branches do not nest.
    fn if_less(x: &Self, y: &Self, less: impl FnOnce() -> Self, otherwise: impl FnOnce() -> Self) -> Self {
        let condition = Expression::Compare(Comparison::Less, Box::new([x.value.clone(), y.value.clone()]));
        if let Some(recorder) = x.recorder.as_ref().or(y.recorder.as_ref()) {
            recorder.choice(condition, less);
        }
        otherwise()
    }
}

impl<const SINGLE: bool> Add for Trace<SINGLE> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        if self.is_zero() {
            return other;
        }
        self.join(other, |x, y| {
            let mut terms = match x {
                Expression::Sum(terms) => terms,
                x => vec![(false, x)],
            };
            terms.push(match y {
                Expression::Literal(value) if value.is_negative() => (true, Expression::Literal(-value)),
                y => (false, y),
            });
            Expression::Sum(terms)
        })
    }
}

impl<const SINGLE: bool> Sub for Trace<SINGLE> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.join(other, |x, y| Expression::Sum(vec![(false, x), (true, y)]))
    }
}

impl<const SINGLE: bool> Mul for Trace<SINGLE> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if self.is_zero() {
            return self;
        }
        if matches!(&self.value, Expression::Literal(value) if value.is_unit() && value.is_negative()) {
            return -other;
        }
        self.join(other, |x, y| match x {
            Expression::Quotient(mut over, under) if under.is_empty() => {
                over.push(y);
                Expression::Quotient(over, under)
            }
            x => Expression::Quotient(vec![x, y], vec![]),
        })
    }
}

impl<const SINGLE: bool> Div for Trace<SINGLE> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self.join(other, |x, y| {
            let under = match y {
                Expression::Quotient(over, under) if under.is_empty() => over,
                y => vec![y],
            };
            match x {
                Expression::Quotient(over, none) if none.is_empty() => Expression::Quotient(over, under),
                x => Expression::Quotient(vec![x], under),
            }
        })
    }
}

impl<const SINGLE: bool> Neg for Trace<SINGLE> {
    type Output = Self;
    fn neg(self) -> Self {
        Trace { value: Expression::Negative(Box::new(self.value)), ..self }
    }
}
