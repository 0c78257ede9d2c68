//! Statements as text, in any language whose operators have the associativity and precedence of C and Rust.
//!
//! In: a statement. Out: its lines, without indentation. A [`Dialect`] contains the differences between
//! languages. Parentheses are placed here, for all languages: a pinned difference and a sum within a sum keep
//! their parentheses.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::math::number::Comparison;
use crate::model::bodies::{Signature, Slot};
use crate::model::outputs::spans;
use crate::schedule::{Expression, Output, Part, Statement, Variable};
use std::ops::Range;

/// The syntax of a language for the elements of statements.
pub trait Dialect {
    /// The arguments and results.
    fn signature(&self) -> &Signature;
    /// A number.
    fn literal(&self, value: &Exact) -> String;
    /// A number as the receiver of a method call.
    fn receiver(&self, value: &Exact) -> String {
        self.literal(value)
    }
    /// A boolean constant.
    fn known(&self, value: bool) -> String;
    /// An argument entry.
    fn input(&self, slot: Slot) -> String;
    /// The template of a function: `{0}` and `{1}` are replaced by the arguments.
    fn function(&self, function: Function) -> String;
    /// The template of x y + z with one rounding.
    fn fused(&self) -> String {
        "fma({0}, {1}, {2})".to_owned()
    }
    /// The operators for logical and, or, not.
    fn logic(&self) -> [&'static str; 3] {
        ["&&", "||", "!"]
    }
    /// Defines a temporary; `bare` means that the value contains only numeric literals, whose type no
    /// language infers.
    fn define(&self, variable: &Variable, bare: bool, value: &str) -> Vec<String>;
    /// Assigns a value to an output with the operator `by`: `=`, `+=` or `-=`.
    fn store(&self, output: Output, by: &str, value: &str) -> Vec<String>;
    /// Defines a temporary as one of two values, which may be bare too.
    fn define_select(&self, variable: &Variable, bare: bool, select: [&str; 3]) -> Vec<String>;
    /// Assigns one of two values to an output.
    fn store_select(&self, output: Output, by: &str, select: [&str; 3]) -> Vec<String>;
    /// Sets runs of columns in some rows to zero; with `first`, the whole rows may be set to zero.
    fn zero(&self, part: Part, rows: &[(usize, Vec<Range<usize>>)], first: bool) -> Vec<String>;
    /// Defines a temporary row.
    fn columns(&self, variable: &Variable, values: &[String]) -> Vec<String>;
    /// Sets a row of outputs to a factor times a temporary row.
    fn scaled(&self, part: Part, row: usize, factor: &str, columns: &Variable) -> Vec<String>;
    /// Sets rows of outputs to the negatives of the rows of the result `of` that start at row `from`.
    fn negated(&self, part: Part, rows: &Range<usize>, of: Part, from: usize) -> Vec<String>;
    /// If the condition is true, sets every output to zero and returns.
    fn leave(&self, condition: &str) -> Vec<String>;
    /// A comment on a line of its own.
    fn remark(&self, text: &str) -> Vec<String>;
}

/// The lines of a statement.
pub fn statement(dialect: &dyn Dialect, variables: &[Variable], statement: &Statement) -> Vec<String> {
    let printer = Printer { dialect, variables, typed: false };
    match statement {
        Statement::Let(name, Expression::Select(parts)) => {
            let texts = printer.select(parts);
            let bare = printer.is_bare(&parts[1]) && printer.is_bare(&parts[2]);
            dialect.define_select(&variables[name.index()], bare, texts.each_ref().map(String::as_str))
        }
        Statement::Store(output, value) => printer.store(*output, "=", value),
        Statement::Add(output, false, value) => printer.store(*output, "+=", value),
        Statement::Add(output, true, value) => printer.store(*output, "-=", value),
        Statement::Let(name, value) => {
            dialect.define(&variables[name.index()], printer.is_bare(value), &printer.text(value))
        }
        Statement::Zero { part, rows, first } => dialect.zero(*part, rows, *first),
        Statement::Columns(name, values) => {
            let values: Vec<String> = values.iter().map(|value| printer.text(value)).collect();
            dialect.columns(&variables[name.index()], &values)
        }
        Statement::Scaled { part, row, factor, columns } => {
            dialect.scaled(*part, *row, &printer.text(factor), &variables[columns.index()])
        }
        Statement::Negated { part, rows, of, from } => dialect.negated(*part, rows, *of, *from),
        Statement::Heading(part, body) => {
            let signature = dialect.signature();
            let mut title = part.titled(signature);
            if let Some(body) = body {
                title += &format!(", rows of {}", signature.bodies[usize::from(*body)].name);
            }
            dialect.remark(&title)
        }
        Statement::Leave(holds) => dialect.leave(&printer.text(holds)),
    }
}

/// Groups consecutive rows with the same runs of columns.
pub fn together(rows: &[(usize, Vec<Range<usize>>)]) -> Vec<(Range<usize>, &[Range<usize>])> {
    let below = |x: &(usize, Vec<Range<usize>>), y: &(usize, Vec<Range<usize>>)| x.0 + 1 == y.0 && x.1 == y.1;
    let block = |rows: &'_ [(usize, Vec<Range<usize>>)]| rows[0].0..rows[0].0 + rows.len();
    rows.chunk_by(below).map(|rows| (block(rows), rows[0].1.as_slice())).collect()
}

/// The text of an expression.
pub fn expression(dialect: &dyn Dialect, variables: &[Variable], expression: &Expression) -> String {
    Printer { dialect, variables, typed: false }.text(expression)
}

/// The precedence of the context of an expression.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Open,
    Logic,
    Comparison,
    Sum,
    Product,
    Prefix,
    Postfix,
}

struct Printer<'a> {
    dialect: &'a dyn Dialect,
    variables: &'a [Variable],
    /// Whether numeric literals carry their type.
    typed: bool,
}

impl Printer<'_> {
    /// Whether an expression contains only numbers; parameters that are replaced by numbers count as numbers.
    fn is_bare(&self, expression: &Expression) -> bool {
        let mut pending = vec![expression];
        while let Some(expression) = pending.pop() {
            let bare = match expression {
                Expression::Input(slot) => self.dialect.signature().known(*slot).is_some(),
                Expression::Call(..) | Expression::Name(_) | Expression::Fused(_) => false,
                _ => !expression.is_truth(),
            };
            if !bare {
                return false;
            }
            pending.extend(expression.children());
        }
        true
    }

    fn text(&self, expression: &Expression) -> String {
        let mut text = String::new();
        self.write(&mut text, expression, Binding::Open);
        text
    }

    fn store(&self, output: Output, by: &str, value: &Expression) -> Vec<String> {
        match value {
            Expression::Select(parts) => {
                let texts = self.select(parts);
                self.dialect.store_select(output, by, texts.each_ref().map(String::as_str))
            }
            value => self.dialect.store(output, by, &self.text(value)),
        }
    }

    fn select(&self, parts: &[Expression; 3]) -> [String; 3] {
        parts.each_ref().map(|part| self.text(part))
    }

    fn write(&self, out: &mut String, expression: &Expression, context: Binding) {
        if let Expression::Input(slot) = expression
            && let Some(value) = self.dialect.signature().known(*slot)
        {
            return self.write(out, &Expression::Literal(value), context);
        }
        let own = match expression {
            Expression::Literal(value) if value.is_negative() => Binding::Prefix,
            Expression::Negative(_) | Expression::Not(_) => Binding::Prefix,
            Expression::Difference(_) if context != Binding::Open => Binding::Open,
            Expression::Difference(_) | Expression::Sum(_) => Binding::Sum,
            Expression::Quotient(..) => Binding::Product,
            Expression::Compare(..) => Binding::Comparison,
            Expression::And(_) | Expression::Or(_) => Binding::Logic,
            Expression::Select(_) => Binding::Open,
            _ => Binding::Postfix,
        };
        let parentheses = own < context || own == context && own < Binding::Prefix && own > Binding::Open;
        if parentheses {
            out.push('(');
        }
        match expression {
            Expression::Literal(value) if context == Binding::Postfix || self.typed => {
                out.push_str(&self.dialect.receiver(value))
            }
            Expression::Literal(value) => out.push_str(&self.dialect.literal(value)),
            Expression::Known(value) => out.push_str(&self.dialect.known(*value)),
            Expression::Input(slot) => out.push_str(&self.dialect.input(*slot)),
            Expression::Name(name) => out.push_str(&self.variables[name.index()].name),
            Expression::Negative(x) => {
                out.push('-');
                // −(x y) is written −x y: the same value.
                let product = matches!(&**x, Expression::Quotient(over, _) if !over.is_empty());
                self.write(out, x, if product { Binding::Sum } else { Binding::Prefix });
            }
            Expression::Difference(pair) => self.binary(out, pair, " - ", Binding::Sum),
            Expression::Sum(terms) => {
                for (index, (negative, term)) in terms.iter().enumerate() {
                    out.push_str(match (index, negative) {
                        (0, false) => "",
                        (0, true) => "-",
                        (_, false) => " + ",
                        (_, true) => " - ",
                    });
                    self.write(out, term, Binding::Sum);
                }
            }
            Expression::Quotient(over, under) => {
                for (index, factor) in over.iter().enumerate() {
                    out.push_str(if index > 0 { " * " } else { "" });
                    // A sign may precede the first factor of a product.
                    let signed =
                        index == 0 && matches!(factor, Expression::Negative(_) | Expression::Literal(_));
                    self.write(out, factor, if signed { Binding::Prefix } else { Binding::Product });
                }
                if over.is_empty() {
                    out.push_str(&self.dialect.literal(&Exact::ONE));
                }
                match under.as_slice() {
                    [] => {}
                    [single] => {
                        out.push_str(" / ");
                        self.write(out, single, Binding::Product);
                    }
                    several => {
                        out.push_str(" / (");
                        for (index, factor) in several.iter().enumerate() {
                            out.push_str(if index > 0 { " * " } else { "" });
                            self.write(out, factor, Binding::Product);
                        }
                        out.push(')');
                    }
                }
            }
            Expression::Call(function, arguments) => {
                self.fill(out, &self.dialect.function(*function), arguments)
            }
            Expression::Fused(parts) => self.fill(out, &self.dialect.fused(), &parts[..]),
            Expression::Select(parts) => {
                let [condition, x, y] = self.select(parts);
                out.push_str(&format!("{condition} ? {x} : {y}"));
            }
            Expression::Compare(comparison, pair) => {
                let sign = match comparison {
                    Comparison::Less => " < ",
                    Comparison::LessEqual => " <= ",
                    Comparison::Equal => " == ",
                };
                self.binary(out, pair, sign, Binding::Comparison);
            }
            Expression::And(pair) => {
                self.binary(out, pair, &format!(" {} ", self.dialect.logic()[0]), Binding::Logic)
            }
            Expression::Or(pair) => {
                self.binary(out, pair, &format!(" {} ", self.dialect.logic()[1]), Binding::Logic)
            }
            Expression::Not(x) => {
                out.push_str(self.dialect.logic()[2]);
                self.write(out, x, Binding::Prefix);
            }
        }
        if parentheses {
            out.push(')');
        }
    }

    fn binary(&self, out: &mut String, pair: &[Expression; 2], sign: &str, context: Binding) {
        self.write(out, &pair[0], context);
        out.push_str(sign);
        self.write(out, &pair[1], context);
    }

    fn fill(&self, out: &mut String, template: &str, arguments: &[Expression]) {
        let mut rest = template;
        while let Some(open) = rest.find('{') {
            out.push_str(&rest[..open]);
            let close = open + 2;
            let index: usize = rest[open + 1..close].parse().expect("a template numbers its arguments");
            let method = rest[close + 1..].starts_with('.');
            let argument = &arguments[index];
            let printer = Printer { typed: method && self.is_bare(argument), ..*self };
            printer.write(out, argument, if method { Binding::Postfix } else { Binding::Open });
            rest = &rest[close + 1..];
        }
        out.push_str(rest);
    }
}

/// The text form of a schedule: plain assignments.
pub(super) struct Plain<'a>(pub(super) &'a Signature);

impl Dialect for Plain<'_> {
    fn signature(&self) -> &Signature {
        self.0
    }

    fn literal(&self, value: &Exact) -> String {
        value.to_string()
    }

    fn known(&self, value: bool) -> String {
        value.to_string()
    }

    fn input(&self, slot: Slot) -> String {
        match self.0.known(slot) {
            Some(value) => self.literal(&value),
            None => self.0.slot_name(slot),
        }
    }

    fn function(&self, function: Function) -> String {
        let row = function.row();
        let order = function.order().map(|n| format!("_{n}")).unwrap_or_default();
        let arguments: Vec<String> = (0..row.arity).map(|i| format!("{{{i}}}")).collect();
        let arguments = arguments.join(", ");
        if row.arity == 0 { row.name.to_owned() } else { format!("{}{order}({arguments})", row.name) }
    }

    fn logic(&self) -> [&'static str; 3] {
        ["and", "or", "not "]
    }

    fn define(&self, variable: &Variable, _bare: bool, value: &str) -> Vec<String> {
        vec![format!("{} = {value}", variable.name)]
    }

    fn store(&self, output: Output, by: &str, value: &str) -> Vec<String> {
        vec![format!("{} {by} {value}", output.named(self.0))]
    }

    fn define_select(&self, variable: &Variable, bare: bool, [c, x, y]: [&str; 3]) -> Vec<String> {
        self.define(variable, bare, &format!("if {c} then {x} else {y}"))
    }

    fn store_select(&self, output: Output, by: &str, [c, x, y]: [&str; 3]) -> Vec<String> {
        self.store(output, by, &format!("if {c} then {x} else {y}"))
    }

    fn zero(&self, part: Part, rows: &[(usize, Vec<Range<usize>>)], _first: bool) -> Vec<String> {
        let line = |(rows, runs): (Range<usize>, &[Range<usize>])| {
            format!("{} = 0", spans(part, &rows, runs, self.0))
        };
        together(rows).into_iter().map(line).collect()
    }

    fn columns(&self, variable: &Variable, values: &[String]) -> Vec<String> {
        vec![format!("{} = [{}]", variable.name, values.join(", "))]
    }

    fn scaled(&self, part: Part, row: usize, factor: &str, columns: &Variable) -> Vec<String> {
        let row = spans(part, &(row..row + 1), &[], self.0);
        vec![format!("{row} = {factor} * {}", columns.name)]
    }

    fn negated(&self, part: Part, rows: &Range<usize>, of: Part, from: usize) -> Vec<String> {
        let others = from..from + rows.len();
        let [rows, others] = [(part, rows), (of, &others)].map(|(part, rows)| spans(part, rows, &[], self.0));
        vec![format!("{rows} = -{others}")]
    }

    fn leave(&self, condition: &str) -> Vec<String> {
        vec![format!("if {condition} then all is 0")]
    }

    fn remark(&self, text: &str) -> Vec<String> {
        vec![format!("# {text}")]
    }
}
