//! C syntax of statements.
//!
//! In: statements of a kernel. Out: lines of C99 of at most 100 columns.

use crate::emit::c::{WIDTH, real};
use crate::emit::{decimal, lane, slot_path, spelled, template};
use crate::kernel::Precision;
use crate::layout::Lanes;
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::{Signature, Slot};
use crate::names::{Arguments, Target};
use crate::schedule::print::{Dialect, together};
use crate::schedule::{Output, Part, Variable};
use std::cmp::Ordering;
use std::ops::Range;
use std::slice::from_ref;

pub(crate) fn literal(value: &Exact, precision: Precision) -> String {
    let suffix = if precision == Precision::F32 { "f" } else { "" };
    match decimal(value, precision) {
        Some(decimal) => format!("{decimal}{suffix}"),
        None if value.is_negative() => format!("-HUGE_VAL{}", suffix.to_uppercase()),
        None => format!("HUGE_VAL{}", suffix.to_uppercase()),
    }
}

/// If zeroing single entries of an array takes more lines than this, the whole array is cleared.
const FEW: usize = 40;

/// The context that C syntax depends on.
pub(crate) struct C<'a> {
    signature: &'a Signature,
    pub(crate) names: Arguments,
    pub(crate) precision: Precision,
    lanes: Lanes,
    /// The struct of the results; `None` if results are added to the caller's values.
    pub(crate) results: Option<String>,
    /// The fields of the prepared values, if the statements compute them.
    pub(crate) prepared: Vec<String>,
}

impl C<'_> {
    pub(crate) fn new(signature: &Signature, precision: Precision, lanes: Lanes) -> C<'_> {
        let names = Arguments::new(signature, Target::C);
        C { signature, names, precision, lanes, results: None, prepared: Vec::new() }
    }

    fn place(&self, output: Output) -> String {
        let (Output { part, row, column }, lane) = (output, lane(self.lanes));
        if let Some(field) = self.prepared.get(row) {
            return format!("prepared->{field}{lane}");
        }
        let field = self.names.result(part);
        if part.is_list() {
            format!("out->{field}[{row}]{lane}")
        } else {
            format!("out->{field}[{row}][{column}]{lane}")
        }
    }

    /// Sets the same runs of columns in each of some rows to zero, in every instance.
    fn zeros_of_several(&self, part: Part, rows: &Range<usize>, columns: &[Range<usize>]) -> Vec<String> {
        let zero = self.literal(&Exact::ZERO);
        let each = |index: &str, range: &Range<usize>| {
            format!("for (int {index} = {}; {index} < {}; {index}++)", range.start, range.end)
        };
        let lanes = format!("for (int lane = 0; lane < {0}; lane++)", self.lanes);
        let name = self.names.result(part);
        if part.is_list() {
            let line = format!("    {lanes} out->{name}[i][lane] = {zero};");
            return vec![each("i", rows), line];
        }
        let run = |run: &Range<usize>| {
            let loops = format!("{} {}", each("i", rows), each("j", run));
            [loops, format!("    {lanes} out->{name}[i][j][lane] = {zero};")]
        };
        columns.iter().flat_map(run).collect()
    }

    pub(crate) fn ty(&self, variable: &Variable) -> &'static str {
        if variable.truth { "int" } else { real(self.precision) }
    }

    pub(crate) fn declare(&self, variable: &Variable) -> String {
        format!("const {} {}", self.ty(variable), variable.name)
    }

    pub(crate) fn assign(left: &str, value: &str) -> Vec<String> {
        C::set(left, "=", value)
    }

    fn set(left: &str, by: &str, value: &str) -> Vec<String> {
        let line = format!("{left} {by} {value};");
        if line.len() <= WIDTH { vec![line] } else { vec![format!("{left} {by}"), format!("    {value};")] }
    }

    fn choose(left: &str, by: &str, [c, x, y]: [&str; 3]) -> Vec<String> {
        let value = format!("{c} ? {x} : {y}");
        if "    ;".len() + value.len() <= WIDTH {
            return C::set(left, by, &value);
        }
        vec![format!("{left} {by}"), format!("    {c}"), format!("        ? {x}"), format!("        : {y};")]
    }

    /// A loop, on one line if it fits.
    fn body(each: String, statement: String) -> Vec<String> {
        if each.len() + 1 + statement.len() <= WIDTH {
            return vec![format!("{each} {statement}")];
        }
        vec![each, format!("    {statement}")]
    }

    /// Sets the same runs of columns in each of some rows to zero.
    fn zeros(&self, part: Part, rows: &Range<usize>, columns: &[Range<usize>]) -> Vec<String> {
        const CHAIN: usize = 4;
        if !self.lanes.is_one() {
            return self.zeros_of_several(part, rows, columns);
        }
        let zero = self.literal(&Exact::ZERO);
        let width: usize = columns.iter().map(Range::len).sum();
        let each = |index: &str, range: &Range<usize>| {
            format!("for (int {index} = {}; {index} < {}; {index}++)", range.start, range.end)
        };
        let name = self.names.result(part);
        if part.is_list() && rows.len() > CHAIN {
            return vec![format!("{} out->{name}[i] = {zero};", each("i", rows))];
        }
        if let [run] = columns {
            if width > CHAIN && rows.len() == 1 {
                return vec![format!("{} out->{name}[{}][j] = {zero};", each("j", run), rows.start)];
            }
            if width * rows.len() > 2 * CHAIN {
                return vec![each("i", rows), format!("    {} out->{name}[i][j] = {zero};", each("j", run))];
            }
        }
        let entries = rows.clone().flat_map(|row| {
            columns.iter().cloned().flatten().map(move |column| Output::new(part, row, column))
        });
        let places: Vec<String> = entries.map(|output| self.place(output)).collect();
        let chain = if width > 1 { width.min(CHAIN) } else { CHAIN };
        // A line never mixes rows, unless each row has only one entry.
        let lines =
            places.chunks(if width > 1 { width } else { places.len() }).flat_map(|row| row.chunks(chain));
        lines.flat_map(|line| C::assign(&line.join(" = "), &zero)).collect()
    }
}

impl Dialect for C<'_> {
    fn signature(&self) -> &Signature {
        self.signature
    }

    fn literal(&self, value: &Exact) -> String {
        literal(value, self.precision)
    }

    fn fused(&self) -> String {
        spelled("fma{f}({0}, {1}, {2})", self.precision)
    }

    fn known(&self, value: bool) -> String {
        u8::from(value).to_string()
    }

    fn input(&self, slot: Slot) -> String {
        match self.signature.known(slot) {
            Some(value) => self.literal(&value),
            None => slot_path(self.signature, &self.names, slot, "->", self.lanes),
        }
    }

    fn function(&self, function: Function) -> String {
        template(function.row().c, function, self.precision)
    }

    fn define(&self, variable: &Variable, _bare: bool, value: &str) -> Vec<String> {
        C::assign(&self.declare(variable), value)
    }

    fn store(&self, output: Output, by: &str, value: &str) -> Vec<String> {
        C::set(&self.place(output), by, value)
    }

    fn define_select(&self, variable: &Variable, _bare: bool, select: [&str; 3]) -> Vec<String> {
        C::choose(&self.declare(variable), "=", select)
    }

    fn store_select(&self, output: Output, by: &str, select: [&str; 3]) -> Vec<String> {
        C::choose(&self.place(output), by, select)
    }

    fn zero(&self, part: Part, rows: &[(usize, Vec<Range<usize>>)], first: bool) -> Vec<String> {
        let whole = 0..part.shape(self.signature).1;
        let lines = |(rows, runs): (Range<usize>, &[Range<usize>])| {
            // gcc stores a whole row wide and then the nonzero entries; with zeros in between it makes no
            // wide stores.
            self.zeros(part, &rows, if first { from_ref(&whole) } else { runs })
        };
        let lines: Vec<String> = together(rows).into_iter().flat_map(lines).collect();
        // Scattered single zeros cost gcc minutes of compile time, and a loop that clears the whole array is
        // as fast.
        if first || lines.len() <= FEW {
            return lines;
        }
        self.zeros(part, &(0..part.shape(self.signature).0), from_ref(&whole))
    }

    fn columns(&self, variable: &Variable, values: &[String]) -> Vec<String> {
        let mut lines = vec![format!("{}[{}] = {{", self.declare(variable), values.len())];
        let mut line = String::new();
        for value in values {
            if !line.is_empty() && line.len() + value.len() + "     ,".len() > WIDTH {
                lines.push(format!("    {}", line.trim_end()));
                line.clear();
            }
            line.push_str(&format!("{value}, "));
        }
        lines.push(format!("    {}", line.trim_end()));
        lines.push("};".to_owned());
        lines
    }

    fn scaled(&self, part: Part, row: usize, factor: &str, columns: &Variable) -> Vec<String> {
        let (columns, count) = (&columns.name, part.shape(self.signature).1);
        let part = self.names.result(part);
        let each = format!("for (int j = 0; j < {count}; j++)");
        C::body(each, format!("out->{part}[{row}][j] = {factor} * {columns}[j];"))
    }

    fn negated(&self, part: Part, rows: &Range<usize>, of: Part, from: usize) -> Vec<String> {
        let count = part.shape(self.signature).1;
        let [part, of] = [part, of].map(|part| self.names.result(part));
        let each = format!("for (int j = 0; j < {count}; j++)");
        if rows.len() == 1 {
            let row = rows.start;
            return C::body(each, format!("out->{part}[{row}][j] = -out->{of}[{from}][j];"));
        }
        let other = match rows.start.cmp(&from) {
            Ordering::Less => format!("i + {}", from - rows.start),
            Ordering::Equal => "i".to_owned(),
            Ordering::Greater => format!("i - {}", rows.start - from),
        };
        let mut lines = vec![format!("for (int i = {}; i < {}; i++)", rows.start, rows.end)];
        let body = C::body(each, format!("out->{part}[i][j] = -out->{of}[{other}][j];"));
        lines.extend(body.into_iter().map(|line| format!("    {line}")));
        lines
    }

    fn leave(&self, condition: &str) -> Vec<String> {
        let zero = self.results.as_ref().map(|results| format!("    *out = ({results}){{ 0 }};"));
        let head = [format!("if ({condition}) {{")].into_iter().chain(zero);
        head.chain(["    return;", "}"].map(str::to_owned)).collect()
    }

    fn remark(&self, text: &str) -> Vec<String> {
        vec![format!("/* {text} */")]
    }
}
