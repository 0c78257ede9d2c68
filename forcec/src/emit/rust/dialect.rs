//! Rust syntax of statements, formatted like rustfmt.
//!
//! In: statements of a kernel, numbers, lists. Out: lines of at most 100 columns that pass clippy.

use crate::emit::rust::WIDTH;
use crate::emit::{decimal, lane, slot_path, spelled, template};
use crate::kernel::Precision;
use crate::layout::Lanes;
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::{Signature, Slot};
use crate::names::{Arguments, Target};
use crate::schedule::print::{Dialect, together};
use crate::schedule::{Output, Part, Variable};
use std::f64::consts;
use std::ops::Range;

/// The mathematical constants of the standard library.
const CONSTANTS: [(f64, &str); 19] = [
    (consts::E, "E"),
    (consts::FRAC_1_PI, "FRAC_1_PI"),
    (consts::FRAC_1_SQRT_2, "FRAC_1_SQRT_2"),
    (consts::FRAC_2_PI, "FRAC_2_PI"),
    (consts::FRAC_2_SQRT_PI, "FRAC_2_SQRT_PI"),
    (consts::FRAC_PI_2, "FRAC_PI_2"),
    (consts::FRAC_PI_3, "FRAC_PI_3"),
    (consts::FRAC_PI_4, "FRAC_PI_4"),
    (consts::FRAC_PI_6, "FRAC_PI_6"),
    (consts::FRAC_PI_8, "FRAC_PI_8"),
    (consts::LN_2, "LN_2"),
    (consts::LN_10, "LN_10"),
    (consts::LOG10_2, "LOG10_2"),
    (consts::LOG2_10, "LOG2_10"),
    (consts::LOG10_E, "LOG10_E"),
    (consts::LOG2_E, "LOG2_E"),
    (consts::PI, "PI"),
    (consts::SQRT_2, "SQRT_2"),
    (consts::TAU, "TAU"),
];

/// Further numbers that clippy reports as approximate constants.
const FURTHER: [f64; 2] = [1.618_033_988_749_895, 0.577_215_664_901_532_9];

/// A positive number. A number that clippy takes for a known constant is written as that constant, or else as
/// its bits.
fn positive(value: &Exact, precision: Precision) -> String {
    let Some(text) = decimal(value, precision) else {
        return format!("{precision}::INFINITY");
    };
    let nearest = |constant: f64| Exact::from_f64(constant).and_then(|exact| decimal(&exact, precision));
    if let Some((_, name)) = CONSTANTS.iter().find(|(constant, _)| nearest(*constant).as_ref() == Some(&text))
    {
        return format!("core::{precision}::consts::{name}");
    }
    let digits = text.len().saturating_sub(2);
    let alike =
        |constant: f64| constant.to_string().starts_with(&text) || format!("{constant:.digits$}") == text;
    let known = CONSTANTS.iter().map(|(constant, _)| *constant).chain(FURTHER);
    if text.len() > 3 && known.into_iter().any(alike) {
        return match precision {
            Precision::F64 => format!("f64::from_bits({:#x})", value.to_f64().to_bits()),
            Precision::F32 => format!("f32::from_bits({:#x})", value.to_f32().to_bits()),
        };
    }
    text
}

/// The context that Rust syntax depends on, formatted like rustfmt at this indentation.
pub(crate) struct Rust<'a> {
    signature: &'a Signature,
    pub(crate) names: Arguments,
    pub(crate) precision: Precision,
    indent: usize,
    lanes: Lanes,
    /// Whether results are added to the caller's values.
    pub(crate) adds: bool,
    /// The fields of the prepared values, if the statements compute them.
    pub(crate) prepared: Vec<String>,
}

impl Rust<'_> {
    pub(crate) fn new(signature: &Signature, precision: Precision, indent: usize, lanes: Lanes) -> Rust<'_> {
        let names = Arguments::new(signature, Target::Rust);
        Rust { signature, names, precision, indent, lanes, adds: false, prepared: Vec::new() }
    }

    fn place(&self, output: Output) -> String {
        let (Output { part, row, column }, lane) = (output, lane(self.lanes));
        if let Some(field) = self.prepared.get(row) {
            return format!("prepared.{field}{lane}");
        }
        let field = self.names.result(part);
        if part.is_list() {
            format!("out.{field}[{row}]{lane}")
        } else {
            format!("out.{field}[{row}][{column}]{lane}")
        }
    }

    pub(crate) fn assign(&self, left: &str, value: &str) -> Vec<String> {
        self.set(left, "=", value)
    }

    /// The declaration of a temporary; typed if its value contains only numbers, because rustc could not
    /// infer the type.
    fn declare(&self, variable: &Variable, bare: bool) -> String {
        let ty = if bare { format!(": {}", self.precision) } else { String::new() };
        format!("let {}{ty}", variable.name)
    }

    /// The lines of a fused multiply-add that rustfmt breaks, including nested ones; `None` if the call fits
    /// on one line.
    fn broken(&self, value: &str) -> Option<Vec<String>> {
        /// rustfmt's `fn_call_width`.
        const CALL: usize = 60;
        let (sign, call) = value.strip_prefix('-').map_or(("", value), |call| ("-", call));
        let name = format!("{}::mul_add(", self.precision);
        let inside = call.strip_prefix(&name)?.strip_suffix(')').filter(|inside| inside.len() > CALL)?;
        let mut lines = vec![format!("{sign}{name}")];
        for argument in arguments(inside)? {
            let own = self.broken(argument).unwrap_or_else(|| vec![argument.to_owned()]);
            let last = own.len() - 1;
            let end = |line: usize| if line == last { "," } else { "" };
            lines.extend(own.iter().enumerate().map(|(at, line)| format!("    {line}{}", end(at))));
        }
        lines.push(")".to_owned());
        Some(lines)
    }

    fn set(&self, left: &str, by: &str, value: &str) -> Vec<String> {
        if let Some(mut lines) = self.broken(value) {
            lines[0].insert_str(0, &format!("{left} {by} "));
            if let Some(last) = lines.last_mut() {
                last.push(';');
            }
            return lines;
        }
        let line = format!("{left} {by} {value};");
        if self.indent + line.len() <= WIDTH {
            return vec![line];
        }
        vec![format!("{left} {by}"), format!("    {value};")]
    }

    fn choose(&self, left: &str, by: &str, [c, x, y]: [&str; 3]) -> Vec<String> {
        /// rustfmt's `single_line_if_else_max_width`.
        const SINGLE_LINE: usize = 50;
        let value = format!("if {c} {{ {x} }} else {{ {y} }}");
        if value.len() <= SINGLE_LINE {
            return self.set(left, by, &value);
        }
        vec![
            format!("{left} {by} if {c} {{"),
            format!("    {x}"),
            "} else {".to_owned(),
            format!("    {y}"),
            "};".to_owned(),
        ]
    }

    /// Sets the same runs of columns in each of some rows to zero.
    fn zeros(&self, part: Part, rows: &Range<usize>, columns: &[Range<usize>]) -> Vec<String> {
        let (height, width) = part.shape(self.signature);
        let zero = if self.lanes.is_one() { "0.0".to_owned() } else { format!("[0.0; {}]", self.lanes) };
        // Sets one entry, some entries or all `count` entries of an array to zero.
        let fill = |place: &str, whole: &str, count: usize, range: &Range<usize>| match range.len() {
            length if length == count && count > 1 => format!("{whole} = [{zero}; {count}];"),
            1 => format!("{place}[{}] = {zero};", range.start),
            _ => format!("{place}[{}..{}].fill({zero});", range.start, range.end),
        };
        let name = self.names.result(part);
        if part.is_list() {
            let place = format!("out.{name}");
            return vec![fill(&place, &place, height, rows)];
        }
        let whole = rows.len() == height;
        if whole && columns.iter().all(|run| run.len() == width) {
            return vec![format!("out.{name} = [[{zero}; {width}]; {height}];")];
        }
        if rows.len() == 1 {
            let place = format!("out.{name}[{}]", rows.start);
            return columns.iter().map(|run| fill(&place, &place, width, run)).collect();
        }
        let range = if whole { String::new() } else { format!("[{}..{}]", rows.start, rows.end) };
        let mut lines = vec![format!("for row in &mut out.{name}{range} {{")];
        lines.extend(columns.iter().map(|run| format!("    {}", fill("row", "*row", width, run))));
        lines.push("}".to_owned());
        lines
    }
}

impl Dialect for Rust<'_> {
    fn signature(&self) -> &Signature {
        self.signature
    }

    fn literal(&self, value: &Exact) -> String {
        let size = positive(&value.abs(), self.precision);
        if value.is_negative() { format!("-{size}") } else { size }
    }

    fn receiver(&self, value: &Exact) -> String {
        let text = self.literal(value);
        if text.contains("::") { text } else { format!("{text}_{}", self.precision) }
    }

    fn fused(&self) -> String {
        spelled("{p}::mul_add({0}, {1}, {2})", self.precision)
    }

    fn known(&self, value: bool) -> String {
        value.to_string()
    }

    fn input(&self, slot: Slot) -> String {
        match self.signature.known(slot) {
            Some(value) => self.literal(&value),
            None => slot_path(self.signature, &self.names, slot, ".", self.lanes),
        }
    }

    fn function(&self, function: Function) -> String {
        template(function.row().rust, function, self.precision)
    }

    fn define(&self, variable: &Variable, bare: bool, value: &str) -> Vec<String> {
        self.assign(&self.declare(variable, bare), value)
    }

    fn store(&self, output: Output, by: &str, value: &str) -> Vec<String> {
        self.set(&self.place(output), by, value)
    }

    fn define_select(&self, variable: &Variable, bare: bool, select: [&str; 3]) -> Vec<String> {
        self.choose(&self.declare(variable, bare), "=", select)
    }

    fn store_select(&self, output: Output, by: &str, select: [&str; 3]) -> Vec<String> {
        self.choose(&self.place(output), by, select)
    }

    fn zero(&self, part: Part, rows: &[(usize, Vec<Range<usize>>)], _first: bool) -> Vec<String> {
        together(rows).into_iter().flat_map(|(rows, runs)| self.zeros(part, &rows, runs)).collect()
    }

    fn columns(&self, variable: &Variable, values: &[String]) -> Vec<String> {
        let indent = " ".repeat(self.indent);
        let text = format!("{indent}let {} = {};", variable.name, list(values, &indent));
        text.lines().map(|line| line[self.indent..].to_owned()).collect()
    }

    fn scaled(&self, part: Part, row: usize, factor: &str, columns: &Variable) -> Vec<String> {
        let (part, columns) = (self.names.result(part), &columns.name);
        vec![format!("out.{part}[{row}] = {columns}.map(|column| {factor} * column);")]
    }

    fn negated(&self, part: Part, rows: &Range<usize>, of: Part, from: usize) -> Vec<String> {
        let [part, of] = [part, of].map(|part| self.names.result(part));
        let pairs = rows.clone().zip(from..);
        pairs.map(|(row, other)| format!("out.{part}[{row}] = out.{of}[{other}].map(|x| -x);")).collect()
    }

    fn leave(&self, condition: &str) -> Vec<String> {
        let zero = (!self.adds).then_some("    *out = Output::default();");
        let lines = zero.into_iter().chain(["    return;", "}"]).map(str::to_owned);
        std::iter::once(format!("if {condition} {{")).chain(lines).collect()
    }

    fn remark(&self, text: &str) -> Vec<String> {
        vec![format!("// {text}")]
    }
}

/// The arguments between the parentheses of a call; `None` if `inside` is not the inside of a single call.
fn arguments(inside: &str) -> Option<Vec<&str>> {
    let (mut depth, mut start, mut found) = (0, 0, Vec::new());
    for (at, c) in inside.char_indices() {
        match c {
            '(' => depth += 1,
            ')' if depth == 0 => return None,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                found.push(inside[start..at].trim_start());
                start = at + 1;
            }
            _ => {}
        }
    }
    found.push(inside[start..].trim_start());
    Some(found)
}

/// An array formatted like rustfmt formats the value of a constant or a variable.
pub(crate) fn list(items: &[String], indent: &str) -> String {
    /// rustfmt's `array_width`.
    const ARRAY: usize = 60;
    /// rustfmt's `short_array_element_width_threshold`.
    const SHORT: usize = 10;
    let inner = format!("{indent}    ");
    let line = items.join(", ");
    let width = |text: &str| text.chars().count();
    let single = items.len() == 1 && inner.len() + width(&line) + "[];".len() <= WIDTH;
    if width(&line) <= ARRAY || single {
        return format!("[{line}]");
    }
    let mut text = String::from("[\n");
    if items.iter().any(|item| width(item) > SHORT) {
        items.iter().for_each(|item| text.push_str(&format!("{inner}{item},\n")));
    } else {
        let mut line = String::new();
        for (index, item) in items.iter().enumerate() {
            // A space follows every item except the last.
            let end = if index + 1 == items.len() { " ,".len() } else { " , ".len() };
            if !line.is_empty() && inner.len() + width(&line) + width(item) + end > WIDTH {
                text.push_str(&format!("{inner}{line}\n"));
                line.clear();
            }
            let space = if line.is_empty() { "" } else { " " };
            line.push_str(&format!("{space}{item},"));
        }
        text.push_str(&format!("{inner}{line}\n"));
    }
    text.push_str(&format!("{indent}]"));
    text
}
