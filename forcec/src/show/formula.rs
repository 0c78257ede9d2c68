//! Mathematics for people: nodes of the vector graph as formulas, in plain text or LaTeX.
//!
//! In: a vector graph and its roots. Out: one line per definition, operands first. A node gets its own line
//! if it has a name, or if several others use it and it is too long to repeat.

use crate::derive::block::Matrix;
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::math::number::Comparison;
use crate::model::bodies::{Role, Slot};
use crate::names::values::flat;
use crate::vector::{Graph, Node, Vector};
use std::collections::BTreeMap;

/// The notation of a formula.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Dialect {
    /// Unicode text.
    Text,
    /// LaTeX, inside `aligned`.
    Latex,
}

/// The precedence of the outermost operation of a formula.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Choice,
    Sum,
    Product,
    Power,
    Atom,
}

/// Formulas of one graph.
pub struct Formulas<'g> {
    graph: &'g Graph,
    dialect: Dialect,
    /// Nodes that are referred to by name.
    names: BTreeMap<u32, String>,
    /// Finished formulas.
    made: BTreeMap<u32, (String, Binding)>,
    /// Definitions to show, by node.
    lines: Vec<(u32, String)>,
}

/// Formulas of unnamed nodes that are longer than this and used twice get a name.
const INLINE: usize = 24;

impl<'g> Formulas<'g> {
    /// Builds all formulas below the roots.
    pub fn new(graph: &'g Graph, dialect: Dialect, roots: &[u32]) -> Formulas<'g> {
        let mut formulas =
            Formulas { graph, dialect, names: BTreeMap::new(), made: BTreeMap::new(), lines: Vec::new() };
        let mut uses: BTreeMap<u32, usize> = BTreeMap::new();
        let mut open = roots.to_vec();
        for root in roots {
            uses.entry(*root).or_default();
        }
        while let Some(index) = open.pop() {
            for operand in graph.node(index as usize).operands() {
                let seen = uses.entry(operand).or_default();
                *seen += 1;
                if *seen == 1 && !roots.contains(&operand) {
                    open.push(operand);
                }
            }
        }
        let within = |index: u32| match graph.node(index as usize) {
            Node::Let(x) => Some(x.0),
            Node::VectorLet(v) => Some(v.0),
            _ => None,
        };
        // The node inside a `let` takes the name of the `let` and is shown once.
        let called: BTreeMap<u32, &str> =
            uses.keys().filter_map(|let_| Some((within(*let_)?, graph.name(*let_ as usize)?))).collect();
        let mut taken: BTreeMap<String, usize> = BTreeMap::new();
        for (index, count) in uses {
            let (text, binding) = formulas.make(index);
            if within(index).is_some_and(|inner| formulas.names.contains_key(&inner)) {
                formulas.made.insert(index, (text, binding));
                continue;
            }
            // An argument already has a name, however long the name is.
            let argument = matches!(
                graph.node(index as usize),
                Node::Constant(_) | Node::Entry(_) | Node::Triple(_) | Node::Known(_)
            );
            let long = count > 1 && text.chars().count() > INLINE && !argument;
            let name = match called.get(&index).copied().or_else(|| graph.name(index as usize)) {
                Some(name) => name.to_owned(),
                None if long => "t".to_owned(),
                None => {
                    formulas.made.insert(index, (text, binding));
                    continue;
                }
            };
            let number = taken.entry(name.clone()).or_default();
            *number += 1;
            let unique = if *number == 1 && name != "t" { name } else { format!("{name}_{number}") };
            // A difference has parentheses inside other formulas, but needs none on its own line.
            let bare = match graph.node(index as usize) {
                Node::Difference(..) => text.trim_start_matches('(').trim_end_matches(')').to_owned(),
                _ => text,
            };
            formulas.lines.push((index, bare));
            let spelled = formulas.spell_name(&unique, formulas.is_vector(index));
            formulas.made.insert(index, (spelled.clone(), Binding::Atom));
            formulas.names.insert(index, spelled);
        }
        formulas
    }

    /// The definitions, operands first: name and formula.
    pub fn lines(&self) -> impl Iterator<Item = (&str, &str)> {
        self.lines.iter().map(|(index, text)| (self.names[index].as_str(), text.as_str()))
    }

    /// The formula of a node; named nodes appear by name.
    pub fn formula(&self, index: usize) -> &str {
        &self.made[&(index as u32)].0
    }

    /// Σ coefficient · node
    pub fn combination(&self, terms: &[(Exact, Vector)]) -> String {
        self.sum(&Exact::ZERO, terms.iter().map(|(c, v)| (c.clone(), v.0))).0
    }

    /// `s I + [k]× + Σ u vᵀ`
    pub fn matrix(&self, matrix: &Matrix) -> String {
        let latex = self.dialect == Dialect::Latex;
        let mut parts = Vec::new();
        if !self.graph.is_zero(matrix.identity) {
            let (text, binding) = &self.made[&matrix.identity.0];
            parts.push(format!("{} I", wrap(text, *binding, Binding::Product, self.dialect)));
        }
        if !self.graph.is_zero_vector(matrix.skew) {
            let text = &self.made[&matrix.skew.0].0;
            parts.push(if latex { format!("[{text}]_\\times") } else { format!("[{text}]×") });
        }
        for (u, v) in &matrix.outer {
            let factor = |v: &Vector| {
                let (text, binding) = &self.made[&v.0];
                wrap(text, *binding, Binding::Power, self.dialect)
            };
            let transpose = if latex { "^{\\mathsf T}" } else { "ᵀ" };
            parts.push(format!("{} {}{transpose}", factor(u), factor(v)));
        }
        if let Some(turned) = &matrix.turned {
            let simple =
                Matrix { identity: turned.identity, skew: turned.skew, outer: Vec::new(), turned: None };
            parts.push(format!("({}) R({})", self.matrix(&simple), self.turn(&turned.rotations)));
        }
        if parts.is_empty() { "0".to_owned() } else { parts.join(" + ") }
    }

    fn is_vector(&self, index: u32) -> bool {
        matches!(
            self.graph.node(index as usize),
            Node::Triple(_)
                | Node::Difference(..)
                | Node::VectorOffset(..)
                | Node::VectorSum(_)
                | Node::Scale(..)
                | Node::Cross(..)
                | Node::Rotate(..)
                | Node::TurnVector(_)
                | Node::Pack(_)
                | Node::VectorSelect(..)
                | Node::VectorLet(_)
        )
    }

    fn spell_name(&self, name: &str, vector: bool) -> String {
        match self.dialect {
            Dialect::Text => name.to_owned(),
            Dialect::Latex => {
                let (head, tail) = name.split_once('_').unwrap_or((name, ""));
                let font = if vector { "mathbf" } else { "mathit" };
                let head = format!("\\{font}{{{head}}}");
                if tail.is_empty() {
                    head
                } else {
                    format!("{head}_{{\\mathrm{{{}}}}}", tail.replace('_', "\\_"))
                }
            }
        }
    }

    fn slot(&self, slot: Slot, vector: bool) -> String {
        let signature = &self.graph.signature;
        let Some(role) = signature.role(slot) else {
            let name = if vector { signature.whole_name(slot) } else { signature.slot_name(slot) };
            return match self.dialect {
                Dialect::Text => name,
                Dialect::Latex => self.spell_name(&flat(&name), vector),
            };
        };
        let body = &signature.bodies[slot.argument as usize].name;
        match self.dialect {
            Dialect::Text if vector => signature.whole_name(slot),
            Dialect::Text => signature.slot_name(slot),
            Dialect::Latex => {
                let symbol = match role {
                    Role::Position => "\\mathbf{x}",
                    Role::Orientation => "\\mathbf{q}",
                    Role::Velocity => "\\mathbf{v}",
                    Role::AngularVelocity => "\\boldsymbol{\\omega}",
                };
                let axis = if vector {
                    String::new()
                } else {
                    format!(",{}", ["x", "y", "z", "w"][slot.offset as usize])
                };
                format!("{symbol}_{{\\mathrm{{{}}}{axis}}}", body.replace('_', "\\_"))
            }
        }
    }

    fn part(&self, index: u32, at_least: Binding) -> String {
        let (text, binding) = &self.made[&index];
        wrap(text, *binding, at_least, self.dialect)
    }

    fn make(&self, index: u32) -> (String, Binding) {
        use Binding::{Atom, Choice, Power, Product};
        let latex = self.dialect == Dialect::Latex;
        match self.graph.node(index as usize) {
            Node::Constant(value) => (signed(value, self.dialect), Atom),
            Node::Entry(slot) => (self.slot(*slot, false), Atom),
            Node::Triple(slot) => (self.slot(*slot, true), Atom),
            Node::Difference(p, q) => {
                (format!("({} {} {})", self.slot(*p, true), self.minus(), self.slot(*q, true)), Atom)
            }
            Node::Offset(x, number) => self.sum(number, [(Exact::ONE, x.0)].into_iter()),
            Node::VectorOffset(v, numbers) => {
                let place = numbers.iter().map(|number| signed(number, self.dialect));
                let place = place.collect::<Vec<String>>().join(", ");
                (format!("{} + ({place})", self.part(v.0, Binding::Product)), Binding::Sum)
            }
            Node::Sum(constant, terms) => self.sum(constant, terms.iter().map(|(c, x)| (c.clone(), x.0))),
            Node::VectorSum(terms) => self.sum(&Exact::ZERO, terms.iter().map(|(c, v)| (c.clone(), v.0))),
            Node::Product(factors) => {
                let power = |x: u32, e: i32| match e {
                    1 => self.part(x, Product),
                    _ if latex => format!("{}^{{{e}}}", self.part(x, Atom)),
                    _ => format!("{}^{e}", self.part(x, Atom)),
                };
                let above: Vec<String> =
                    factors.iter().filter(|f| f.1 > 0).map(|f| power(f.0.0, f.1)).collect();
                let below: Vec<String> =
                    factors.iter().filter(|f| f.1 < 0).map(|f| power(f.0.0, -f.1)).collect();
                let above = if above.is_empty() {
                    "1".to_owned()
                } else {
                    above.join(if latex { "\\," } else { " " })
                };
                if below.is_empty() {
                    return (above, Product);
                }
                let joined = below.join(if latex { "\\," } else { " " });
                if latex {
                    (format!("\\frac{{{above}}}{{{joined}}}"), Product)
                } else if below.len() > 1 {
                    (format!("{above} / ({joined})"), Product)
                } else {
                    let factor = factors.iter().find(|f| f.1 == -1);
                    let tight = factor.map_or(joined, |f| self.part(f.0.0, Power));
                    (format!("{above} / {tight}"), Product)
                }
            }
            Node::Dot(u, v) => {
                let dot = if latex { "\\cdot" } else { "·" };
                (format!("{} {dot} {}", self.part(u.0, Power), self.part(v.0, Power)), Product)
            }
            Node::Cross(u, v) => {
                let cross = if latex { "\\times" } else { "×" };
                (format!("{} {cross} {}", self.part(u.0, Power), self.part(v.0, Power)), Product)
            }
            Node::Scale(s, v) => {
                let space = if latex { "\\," } else { " " };
                (format!("{}{space}{}", self.part(s.0, Product), self.part(v.0, Power)), Product)
            }
            Node::Rotate(quaternion, inverse, v) => {
                let inverse = match (inverse, latex) {
                    (false, _) => "",
                    (true, true) => "^{-1}",
                    (true, false) => "⁻¹",
                };
                let product = if latex { "\\," } else { " * " };
                (
                    format!("{}{inverse}{product}{}", self.slot(*quaternion, true), self.part(v.0, Power)),
                    Product,
                )
            }
            Node::Component(v, axis) => {
                let axis = ["x", "y", "z"][*axis as usize];
                let vector = self.part(v.0, Atom);
                (if latex { format!("{{{vector}}}_{axis}") } else { format!("{vector}.{axis}") }, Atom)
            }
            Node::Pack(entries) => {
                let entries: Vec<&str> = entries.iter().map(|x| self.made[&x.0].0.as_str()).collect();
                (format!("({})", entries.join(", ")), Atom)
            }
            Node::Norm(v) => {
                let inner = &self.made[&v.0].0;
                (if latex { format!("\\lVert {inner}\\rVert") } else { format!("|{inner}|") }, Atom)
            }
            Node::TurnReal(turn) => {
                (format!("{}({})", if latex { "\\operatorname{Re}" } else { "Re" }, self.turn(turn)), Atom)
            }
            Node::TurnVector(turn) => {
                (format!("{}({})", if latex { "\\operatorname{Im}" } else { "Im" }, self.turn(turn)), Atom)
            }
            Node::Call(function, arguments) => {
                let arguments: Vec<&str> = arguments.iter().map(|x| self.made[&x.0].0.as_str()).collect();
                (call(*function, &arguments, self.dialect), Atom)
            }
            Node::Select(c, x, y) => (self.choice(c.0, x.0, y.0), Choice),
            Node::VectorSelect(c, u, v) => (self.choice(c.0, u.0, v.0), Choice),
            Node::Let(x) => self.made[&x.0].clone(),
            Node::VectorLet(v) => self.made[&v.0].clone(),
            Node::Known(value) => (value.to_string(), Atom),
            Node::Compare(comparison, x, y) => {
                let sign = match (comparison, latex) {
                    (Comparison::Less, _) => "<",
                    (Comparison::LessEqual, true) => "\\le",
                    (Comparison::LessEqual, false) => "≤",
                    (Comparison::Equal, _) => "=",
                };
                (format!("{} {sign} {}", self.part(x.0, Binding::Sum), self.part(y.0, Binding::Sum)), Choice)
            }
            Node::And(a, b) => {
                let and = if latex { "\\land" } else { "∧" };
                (format!("{} {and} {}", self.part(a.0, Atom), self.part(b.0, Atom)), Choice)
            }
            Node::Or(a, b) => {
                let or = if latex { "\\lor" } else { "∨" };
                (format!("{} {or} {}", self.part(a.0, Atom), self.part(b.0, Atom)), Choice)
            }
            Node::Not(a) => {
                (format!("{}{}", if latex { "\\lnot " } else { "¬" }, self.part(a.0, Atom)), Power)
            }
        }
    }

    fn turn(&self, turn: &[(Slot, bool)]) -> String {
        let factor = |(slot, inverse): &(Slot, bool)| {
            let mark = match (inverse, self.dialect) {
                (false, _) => "",
                (true, Dialect::Text) => "⁻¹",
                (true, Dialect::Latex) => "^{-1}",
            };
            format!("{}{mark}", self.slot(*slot, true))
        };
        turn.iter().map(factor).collect::<Vec<_>>().join(" ")
    }

    fn minus(&self) -> &'static str {
        if self.dialect == Dialect::Latex { "-" } else { "−" }
    }

    fn choice(&self, condition: u32, x: u32, y: u32) -> String {
        let [condition, x, y] = [condition, x, y].map(|i| self.made[&i].0.as_str());
        match self.dialect {
            Dialect::Text => format!("if {condition} then {x} else {y}"),
            Dialect::Latex => {
                format!("\\begin{{cases}} {x} & {condition} \\\\ {y} & \\text{{else}} \\end{{cases}}")
            }
        }
    }

    /// A multiple of a constant vector, as a constant vector.
    fn multiple(&self, factor: &Exact, index: u32) -> Option<String> {
        let Node::Pack(entries) = self.graph.node(index as usize) else { return None };
        let scaled = entries.iter().map(|entry| match self.graph.node(entry.index()) {
            Node::Constant(value) => Some(signed(&(factor * value), self.dialect)),
            _ => None,
        });
        let scaled: Option<Vec<String>> = scaled.collect();
        scaled.filter(|_| !self.names.contains_key(&index)).map(|entries| format!("({})", entries.join(", ")))
    }

    fn sum(&self, constant: &Exact, terms: impl Iterator<Item = (Exact, u32)>) -> (String, Binding) {
        let space = if self.dialect == Dialect::Latex { "\\," } else { " " };
        let mut parts: Vec<(bool, String)> = Vec::new();
        for (c, index) in terms {
            if let Some(text) = self.multiple(&c, index) {
                parts.push((false, text));
                continue;
            }
            let size = c.abs();
            let text = if size.is_one() {
                self.part(index, Binding::Product)
            } else {
                format!("{}{space}{}", number(&size, self.dialect), self.part(index, Binding::Product))
            };
            parts.push((c.is_negative(), text));
        }
        if !constant.is_zero() {
            parts.push((constant.is_negative(), number(&constant.abs(), self.dialect)));
        }
        // A positive term comes first, if there is one.
        if let Some(first) = parts.iter().position(|(negative, _)| !negative) {
            parts[..=first].rotate_right(1);
        }
        let binding = if parts.len() == 1 && !parts[0].0 { Binding::Product } else { Binding::Sum };
        let mut text = String::new();
        for (k, (negative, part)) in parts.iter().enumerate() {
            match (k, negative) {
                (0, false) => {}
                (0, true) => text.push_str(self.minus()),
                (_, false) => text.push_str(" + "),
                (_, true) => text.push_str(&format!(" {} ", self.minus())),
            }
            text.push_str(part);
        }
        if text.is_empty() { ("0".to_owned(), Binding::Atom) } else { (text, binding) }
    }
}

fn wrap(text: &str, binding: Binding, at_least: Binding, dialect: Dialect) -> String {
    if binding >= at_least {
        return text.to_owned();
    }
    match dialect {
        Dialect::Text => format!("({text})"),
        Dialect::Latex => format!("\\left({text}\\right)"),
    }
}

/// A number with the minus sign of its dialect.
fn signed(value: &Exact, dialect: Dialect) -> String {
    match (dialect, value.is_negative()) {
        (Dialect::Text, true) => format!("−{}", number(&value.abs(), dialect)),
        _ => number(value, dialect),
    }
}

fn number(value: &Exact, dialect: Dialect) -> String {
    let (numerator, denominator) = value.parts();
    if denominator == "1" && numerator.len() < 8 {
        return numerator;
    }
    if numerator.len() + denominator.len() > 6 {
        let digits = format!("{:?}", value.to_f64());
        return match (dialect, digits.split_once('e')) {
            (Dialect::Latex, Some(("1", power))) => format!("10^{{{power}}}"),
            (Dialect::Latex, Some((digits, power))) => format!("{digits} \\cdot 10^{{{power}}}"),
            _ => digits,
        };
    }
    match dialect {
        Dialect::Text => format!("{numerator}/{denominator}"),
        Dialect::Latex => format!("\\tfrac{{{numerator}}}{{{denominator}}}"),
    }
}

fn call(function: Function, arguments: &[&str], dialect: Dialect) -> String {
    let row = function.row();
    let list = arguments.join(", ");
    match (dialect, function) {
        (Dialect::Text, Function::Pi) => "π".to_owned(),
        (Dialect::Text, Function::Abs) => format!("|{list}|"),
        (Dialect::Latex, Function::Pi) => "\\pi".to_owned(),
        (Dialect::Latex, Function::Sqrt) => format!("\\sqrt{{{list}}}"),
        (Dialect::Latex, Function::Abs) => format!("\\left|{list}\\right|"),
        (Dialect::Latex, _) => {
            let name = row.name.replace('_', "\\_");
            let order = function.order().map_or(String::new(), |n| format!("_{{{n}}}"));
            format!("\\operatorname{{{name}}}{order}\\left({list}\\right)")
        }
        (Dialect::Text, _) => match function.order() {
            Some(n) => format!("{}{n}({list})", row.name),
            None => format!("{}({list})", row.name),
        },
    }
}
