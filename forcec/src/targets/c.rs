//! C99: one header and one source for a force file, and `forcec.h` for all.
//!
//! In: a [`File`]. Out: text that compiles without a warning as C99, with headers that C++ reads too; its only
//! dependency is `<math.h>`.

use crate::bodies::{BODIES, Parameter, ParameterType, Signature, Slot};
use crate::exact::Exact;
use crate::identifiers::{Arguments, Target, kernel_name};
use crate::kernel::{File, Kernel, Precision};
use crate::layouts::LANES;
use crate::ops::Function;
use crate::rounding::rounding;
use crate::schedule::print::{self, Dialect, together};
use crate::schedule::split::Section;
use crate::schedule::{Output, Part, Variable};
use crate::targets::parts::{Needed, needed};
use crate::targets::routine::{Routine, Way, routine};
use crate::targets::{
    body, decimal, field_summary, lane, lane_loop, parameter_summary, reads, slot_path, template,
};
use std::f64::consts::PI;
use std::ops::Range;
use std::slice::from_ref;

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

/// Keeps the parts of long kernels apart: compilers would put functions that are called once together again.
const APART: &str = "
/* Before a part of a long kernel: compilers take much longer for the whole in one. */
#if defined(__GNUC__)
#define FORCEC_APART __attribute__((noinline))
#elif defined(_MSC_VER)
#define FORCEC_APART __declspec(noinline)
#else
#define FORCEC_APART
#endif
";

/// A longer statement continues on the next line: 100 columns without the indentation of a function's body.
const WIDTH: usize = 96;

fn real(precision: Precision) -> &'static str {
    match precision {
        Precision::F64 => "double",
        Precision::F32 => "float",
    }
}

/// The extent of an array of so many instances.
fn extent(lanes: usize) -> String {
    if lanes > 1 { format!("[{lanes}]") } else { String::new() }
}

/// What stands behind the name of a body type of so many instances.
fn several_suffix(lanes: usize) -> String {
    if lanes > 1 { format!("x{lanes}") } else { String::new() }
}

/// `forcec.h`: bodies, constants and special functions, in both precisions.
pub fn header_common() -> String {
    let mut text = String::from(
        "/*\n * What every kernel made by forcec includes: bodies and special functions.\n */\n\
         #ifndef FORCEC_H\n#define FORCEC_H\n\n#include <math.h>\n\n",
    );
    let pi = Exact::from_f64(PI).expect("finite");
    for precision in PRECISIONS {
        let name = template("FORCEC_PI{F}", Function::Pi, precision);
        text.push_str(&format!("#define {name} {}\n", literal(&pi, precision)));
    }
    text.push_str(APART);
    for (lanes, precision) in LANES.into_iter().flat_map(|lanes| PRECISIONS.map(|p| (lanes, p))) {
        for row in &BODIES {
            let several = if lanes > 1 { format!("{lanes} times: ") } else { String::new() };
            text.push_str(&format!("\n/* {several}{} */\ntypedef struct {{\n", row.summary));
            for field in row.fields {
                let (real, summary) = (real(precision), field_summary(field));
                let (name, length, lanes) = (field.name, field.length, extent(lanes));
                text.push_str(&format!("    {real} {name}[{length}]{lanes}; /* {summary} */\n"));
            }
            text.push_str(&format!("}} {}_{precision}{};\n", row.c_name, several_suffix(lanes)));
        }
    }
    for precision in PRECISIONS {
        let (real, name) = (real(precision), precision.name());
        for (function, sign) in [("min", "<"), ("max", ">")] {
            text.push_str(&format!(
                "\nstatic inline {real} forcec_{function}_{name}({real} x, {real} y)\n\
                 {{\n    return x {sign} y ? x : y;\n}}\n"
            ));
        }
        for function in Function::ALL {
            if let Some(routine) = routine(function, precision) {
                text.push_str(&special(function, &routine, precision));
            }
        }
    }
    text.push_str("\n#endif\n");
    text
}

/// The definition of a special function.
fn special(function: Function, routine: &Routine, precision: Precision) -> String {
    let empty = Signature::default();
    let dialect = C::new(&empty, precision, 1);
    let real = real(precision);
    let name = template(function.row().c, function, precision);
    let name = name.split('(').next().unwrap_or_default();
    let arguments: Vec<String> =
        routine.variables[..routine.arguments].iter().map(|v| format!("{real} {}", v.name)).collect();
    let mut text =
        format!("\n/* {} */\nstatic inline {real} {name}({})\n{{\n", routine.summary, arguments.join(", "));
    let write = |text: &mut String, (statements, result): &Way, indent: &str| {
        for statement in statements {
            for line in print::statement(&dialect, &routine.variables, statement) {
                text.push_str(&format!("{indent}{line}\n"));
            }
        }
        text.push_str(&format!(
            "{indent}return {};\n",
            print::expression(&dialect, &routine.variables, result)
        ));
    };
    if let Some((condition, near)) = &routine.near {
        text.push_str(&format!(
            "    if ({}) {{\n",
            print::expression(&dialect, &routine.variables, condition)
        ));
        write(&mut text, near, "        ");
        text.push_str("    }\n");
    }
    write(&mut text, &routine.far, "    ");
    text.push_str("}\n");
    text
}

/// The header of a force file: parameter and output structs, and what to call.
pub fn header(file: &File) -> String {
    let guard: String =
        file.name().chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let guard = format!("FORCEC_{}_H", guard.to_ascii_uppercase());
    let mut text = comment(&file_remark(file), "");
    text.push_str(&format!("#ifndef {guard}\n#define {guard}\n\n#include \"forcec.h\"\n\n"));
    text.push_str("#ifdef __cplusplus\nextern \"C\" {\n#endif\n");
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            text.push('\n');
            text.push_str(&declaration(kernel, precision));
        }
    }
    text.push_str("\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n");
    text
}

/// A kernel's function or one of its structs.
fn named(kernel: &Kernel, part: &str, precision: Precision) -> String {
    kernel_name(&kernel.name, Target::C, &format!("{part}_{precision}"))
}

fn declaration(kernel: &Kernel, precision: Precision) -> String {
    let (real, lanes) = (real(precision), extent(kernel.lanes));
    let signature = &kernel.schedule.signature;
    let mut text = String::new();
    if signature.has_given() {
        text.push_str("typedef struct {\n");
        let names = Arguments::new(signature, Target::C).parameters;
        for (index, parameter) in signature.given() {
            let field = format!("{}{}{lanes}", names[index], extents(&parameter.ty));
            text.push_str(&format!("    {real} {field}; /* {} */\n", escape(&parameter_summary(parameter))));
        }
        text.push_str(&format!("}} {};\n\n", named(kernel, "_params", precision)));
    }
    text.push_str("typedef struct {\n");
    for &part in &kernel.schedule.parts {
        let (rows, columns) = part.shape(signature);
        let extents = if part.is_list() { format!("[{rows}]") } else { format!("[{rows}][{columns}]") };
        let summary = part.row().summary.replace('`', "");
        text.push_str(&format!("    {real} {part}{extents}{lanes}; /* {summary} */\n"));
    }
    text.push_str(&format!("}} {};\n\n", named(kernel, "_out", precision)));
    text.push_str(&tables(kernel, precision));
    text.push_str(&comment(&kernel.docs, ""));
    text.push_str(&format!("{};\n", prototype(kernel, precision, false)));
    text
}

/// Where the results of a packed kernel stand.
fn tables(kernel: &Kernel, precision: Precision) -> String {
    let Some(packing) = &kernel.packing else { return String::new() };
    let mut text = comment(
        &[
            "Where the entries of the full results stand: k > 0 is entries[k - 1], k < 0 is -entries[-k - 1],".to_owned(),
            "0 is zero.".to_owned(),
        ],
        "",
    );
    for table in &packing.tables {
        let name = named(kernel, &format!("_{}", table.part), precision);
        let row = |row: &[i32]| row.iter().map(i32::to_string).collect::<Vec<_>>().join(", ");
        let (rows, columns) = (table.entries.len() / table.columns.max(1), table.columns);
        if table.part.is_list() {
            text.push_str(&format!("static const int {name}[{rows}] = {{\n"));
            table.entries.chunks(12).for_each(|line| text.push_str(&format!("    {},\n", row(line))));
        } else {
            text.push_str(&format!("static const int {name}[{rows}][{columns}] = {{\n"));
            table.rows().for_each(|line| text.push_str(&format!("    {{ {} }},\n", row(line))));
        }
        text.push_str("};\n");
    }
    text + "\n"
}

fn extents(ty: &ParameterType) -> String {
    ty.extents().iter().map(|n| format!("[{n}]")).collect()
}

/// The head of the function; in its definition the arguments of several instances are told not to overlap, which C++ has no
/// word for.
fn prototype(kernel: &Kernel, precision: Precision, defines: bool) -> String {
    let signature = &kernel.schedule.signature;
    let several = several_suffix(kernel.lanes);
    let star = if defines && kernel.lanes > 1 { "*restrict " } else { "*" };
    let mut arguments: Vec<String> = Vec::new();
    for (body, name) in signature.bodies.iter().zip(Arguments::new(signature, Target::C).bodies) {
        arguments.push(format!("const {}_{precision}{several} {star}{name}", body.kind.row().c_name));
    }
    if signature.has_given() {
        arguments.push(format!("const {} {star}params", named(kernel, "_params", precision)));
    }
    for (index, extra) in signature.given_extras() {
        let name = &Arguments::new(signature, Target::C).extras[index];
        arguments.push(extra_argument(extra, name, kernel.lanes, precision));
    }
    arguments.push(format!("{} {star}out", named(kernel, "_out", precision)));
    wrapped(&format!("void {}(", named(kernel, "", precision)), &arguments, ")")
}

/// The declaration of an extra argument; a lone one is the same for all instances.
fn extra_argument(extra: &Parameter, name: &str, lanes: usize, precision: Precision) -> String {
    let real = real(precision);
    match extra.ty.extents().as_slice() {
        [] => format!("{real} {name}"),
        extents => format!("const {real} {name}[{}]{}", extents[0], extent(lanes)),
    }
}

/// A list of arguments on lines of at most 100 columns.
fn wrapped(head: &str, arguments: &[String], end: &str) -> String {
    let mut text = head.to_owned();
    let mut column = head.len();
    for (index, argument) in arguments.iter().enumerate() {
        let last = index + 1 == arguments.len();
        if index > 0 && column + argument.len() + 1 + end.len() > 100 {
            text.push_str(&format!("\n{}", " ".repeat(head.len())));
            column = head.len();
        } else if index > 0 {
            text.push(' ');
            column += 1;
        }
        text.push_str(argument);
        text.push_str(if last { end } else { "," });
        column += argument.len() + 1;
    }
    text
}

/// The source of a force file.
pub fn source(file: &File) -> String {
    let mut text = comment(&[made(file)], "");
    text.push_str(&format!("#include \"{}.h\"\n", file.name()));
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            text.push('\n');
            text.push_str(&definition(kernel, precision));
        }
    }
    text
}

/// The function of one kernel, with its comment.
pub fn definition(kernel: &Kernel, precision: Precision) -> String {
    let schedule = &kernel.schedule;
    let mut remark: Vec<String> = kernel.brief().map(str::to_owned).collect();
    if !remark.is_empty() {
        remark.push(String::new());
    }
    remark.extend(kernel.summary());
    remark.extend(rounding(kernel, precision).lines());
    let mut text = comment(&remark, "");
    text.push_str(&format!("{}\n{{\n", prototype(kernel, precision, true)));
    let reads = reads(schedule, &schedule.statements);
    let results = named(kernel, "_out", precision);
    let dialect = C { results, ..C::new(&schedule.signature, precision, kernel.lanes) };
    let extras = schedule.signature.given_extras().map(|(k, _)| (&dialect.names.extras[k], reads.extras[k]));
    for (name, read) in dialect.names.bodies.iter().zip(reads.bodies).chain(extras) {
        if !read {
            text.push_str(&format!("    (void){name};\n"));
        }
    }
    if !reads.parameters && schedule.signature.has_given() {
        text.push_str("    (void)params;\n");
    }
    let sections = schedule.sections();
    if kernel.lanes > 1 {
        // Compilers make wide instructions of a loop without loops in it.
        let (zeros, rest) = lane_loop(schedule);
        text.push_str(&body(&dialect, schedule, zeros, "    "));
        text.push_str(&format!("    for (int lane = 0; lane < {}; lane++) {{\n", kernel.lanes));
        text.push_str(&body(&dialect, schedule, rest, "        "));
        text.push_str("    }\n");
    } else if sections.len() == 1 {
        text.push_str(&body(&dialect, schedule, &schedule.statements, "    "));
    } else {
        text.insert_str(0, &parts(kernel, &sections, &dialect));
        text.push_str(&format!("    {} shared;\n", shared(kernel, precision)));
        for (index, section) in sections.iter().enumerate() {
            let reference = |needed: &Needed| if matches!(needed, Needed::Shared(_)) { "&" } else { "" };
            let names = needed(schedule, section, &dialect.names);
            let names: Vec<String> =
                names.iter().map(|needed| format!("{}{}", reference(needed), needed.name())).collect();
            let name = part_name(kernel, precision, index, section);
            text.push_str(&wrapped(&format!("    {name}("), &names, ");"));
            text.push('\n');
        }
    }
    text.push_str("}\n");
    text
}

/// The name of the struct through which the parts of a long kernel hand on values.
fn shared(kernel: &Kernel, precision: Precision) -> String {
    format!("{}_shared", named(kernel, "", precision))
}

fn part_name(kernel: &Kernel, precision: Precision, index: usize, section: &Section) -> String {
    format!("{}_{}_{}", named(kernel, "", precision), section.part, index + 1)
}

/// An argument of a part of a long kernel, as it is declared.
fn declared(kernel: &Kernel, needed: &Needed, precision: Precision) -> String {
    match *needed {
        Needed::Body(body, name) => format!("const {}_{precision} *{name}", body.kind.row().c_name),
        Needed::Parameters => format!("const {} *params", named(kernel, "_params", precision)),
        Needed::Extra(extra, name) => extra_argument(extra, name, kernel.lanes, precision),
        Needed::Shared(true) => format!("{} *shared", shared(kernel, precision)),
        Needed::Shared(false) => format!("const {} *shared", shared(kernel, precision)),
        Needed::Results => format!("{} *out", named(kernel, "_out", precision)),
    }
}

/// What stands before a long kernel: the struct of the values that its parts hand on, and the parts.
fn parts(kernel: &Kernel, sections: &[Section], dialect: &C) -> String {
    let schedule = &kernel.schedule;
    let precision = dialect.precision;
    let whole = named(kernel, "", precision);
    let mut text = format!("/* What parts of {whole} hand on to later ones. */\ntypedef struct {{\n");
    for name in sections.iter().flat_map(|section| &section.hands_on) {
        let variable = &schedule.variables[name.index()];
        text.push_str(&format!("    {} {};\n", dialect.ty(variable), variable.name));
    }
    text.push_str(&format!("}} {};\n\n", shared(kernel, precision)));
    for (index, section) in sections.iter().enumerate() {
        let needed = needed(schedule, section, &dialect.names);
        let declared: Vec<String> = needed.iter().map(|it| declared(kernel, it, precision)).collect();
        let head = format!("FORCEC_APART static void {}(", part_name(kernel, precision, index, section));
        text.push_str(&format!("/* Part {} of {} of {whole}. */\n", index + 1, sections.len()));
        text.push_str(&wrapped(&head, &declared, ")"));
        text.push_str("\n{\n");
        for name in &section.takes {
            let variable = &schedule.variables[name.index()];
            let lines = C::assign(&dialect.declare(variable), &format!("shared->{}", variable.name));
            lines.into_iter().for_each(|line| text.push_str(&format!("    {line}\n")));
        }
        text.push_str(&body(dialect, schedule, section.written(schedule), "    "));
        for name in &section.hands_on {
            let name = &schedule.variables[name.index()].name;
            let lines = C::assign(&format!("shared->{name}"), name);
            lines.into_iter().for_each(|line| text.push_str(&format!("    {line}\n")));
        }
        text.push_str("}\n\n");
    }
    text
}

fn file_remark(file: &File) -> Vec<String> {
    let mut lines = file.docs.clone();
    if !lines.is_empty() {
        lines.push(String::new());
    }
    lines.push(made(file));
    lines
}

fn made(file: &File) -> String {
    format!("Made by forcec from {}.rs; the code is yours.", file.stem)
}

/// A block comment; empty for no lines.
fn comment(lines: &[String], indent: &str) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let mut text = format!("{indent}/*\n");
    for line in lines {
        let line = escape(line);
        let line = line.trim_end();
        let space = if line.is_empty() { "" } else { " " };
        text.push_str(&format!("{indent} *{space}{line}\n"));
    }
    text.push_str(&format!("{indent} */\n"));
    text
}

/// Text that can stand in a comment.
fn escape(text: &str) -> String {
    text.replace("*/", "* /").replace("/*", "/ *").replace("??/", "? ?/")
}

fn literal(value: &Exact, precision: Precision) -> String {
    let suffix = if precision == Precision::F32 { "f" } else { "" };
    match decimal(value, precision) {
        Some(decimal) => format!("{decimal}{suffix}"),
        None if value.is_negative() => format!("-HUGE_VAL{}", suffix.to_uppercase()),
        None => format!("HUGE_VAL{}", suffix.to_uppercase()),
    }
}

/// How C spells statements.
struct C<'a> {
    signature: &'a Signature,
    names: Arguments,
    precision: Precision,
    lanes: usize,
    /// The struct of the results.
    results: String,
}

impl C<'_> {
    fn new(signature: &Signature, precision: Precision, lanes: usize) -> C<'_> {
        C { signature, names: Arguments::new(signature, Target::C), precision, lanes, results: String::new() }
    }

    fn place(&self, output: Output) -> String {
        let (Output { part, row, column }, lane) = (output, lane(self.lanes));
        if part.is_list() {
            format!("out->{part}[{row}]{lane}")
        } else {
            format!("out->{part}[{row}][{column}]{lane}")
        }
    }

    /// The same runs of columns in each of some rows become zero in every instance.
    fn zeros_of_several(&self, part: Part, rows: &Range<usize>, columns: &[Range<usize>]) -> Vec<String> {
        let zero = self.literal(&Exact::ZERO);
        let each = |index: &str, range: &Range<usize>| {
            format!("for (int {index} = {}; {index} < {}; {index}++)", range.start, range.end)
        };
        let lanes = each("lane", &(0..self.lanes));
        if part.is_list() {
            let line = format!("    {lanes} out->{part}[i][lane] = {zero};");
            return vec![each("i", rows), line];
        }
        let run = |run: &Range<usize>| {
            let loops = format!("{} {}", each("i", rows), each("j", run));
            [loops, format!("    {lanes} out->{part}[i][j][lane] = {zero};")]
        };
        columns.iter().flat_map(run).collect()
    }

    fn ty(&self, variable: &Variable) -> &'static str {
        if variable.truth { "int" } else { real(self.precision) }
    }

    fn declare(&self, variable: &Variable) -> String {
        format!("const {} {}", self.ty(variable), variable.name)
    }

    fn assign(left: &str, value: &str) -> Vec<String> {
        let line = format!("{left} = {value};");
        if line.len() <= WIDTH { vec![line] } else { vec![format!("{left} ="), format!("    {value};")] }
    }

    fn choose(left: &str, [c, x, y]: [&str; 3]) -> Vec<String> {
        let value = format!("{c} ? {x} : {y}");
        if "    ;".len() + value.len() <= WIDTH {
            return C::assign(left, &value);
        }
        vec![format!("{left} ="), format!("    {c}"), format!("        ? {x}"), format!("        : {y};")]
    }

    /// A loop on one line if that is short enough.
    fn body(each: String, statement: String) -> Vec<String> {
        if each.len() + 1 + statement.len() <= WIDTH {
            return vec![format!("{each} {statement}")];
        }
        vec![each, format!("    {statement}")]
    }

    /// The same runs of columns in each of some rows become zero.
    fn zeros(&self, part: Part, rows: &Range<usize>, columns: &[Range<usize>]) -> Vec<String> {
        const CHAIN: usize = 4;
        if self.lanes > 1 {
            return self.zeros_of_several(part, rows, columns);
        }
        let zero = self.literal(&Exact::ZERO);
        let width: usize = columns.iter().map(Range::len).sum();
        let each = |index: &str, range: &Range<usize>| {
            format!("for (int {index} = {}; {index} < {}; {index}++)", range.start, range.end)
        };
        let name = part.name();
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
        // A line never mixes rows, unless each has but one entry.
        let lines =
            places.chunks(if width > 1 { width } else { places.len() }).flat_map(|row| row.chunks(chain));
        lines.flat_map(|line| C::assign(&line.join(" = "), &zero)).collect()
    }
}

impl Dialect for C<'_> {
    fn literal(&self, value: &Exact) -> String {
        literal(value, self.precision)
    }

    fn fused(&self) -> String {
        super::spelled("fma{f}({0}, {1}, {2})", self.precision)
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

    fn define(&self, variable: &Variable, value: &str) -> Vec<String> {
        C::assign(&self.declare(variable), value)
    }

    fn store(&self, output: Output, value: &str) -> Vec<String> {
        C::assign(&self.place(output), value)
    }

    fn define_select(&self, variable: &Variable, select: [&str; 3]) -> Vec<String> {
        C::choose(&self.declare(variable), select)
    }

    fn store_select(&self, output: Output, select: [&str; 3]) -> Vec<String> {
        C::choose(&self.place(output), select)
    }

    fn zero(&self, part: Part, rows: &[(usize, Vec<Range<usize>>)], first: bool) -> Vec<String> {
        let whole = 0..part.shape(self.signature).1;
        let lines = |(rows, runs): (Range<usize>, &[Range<usize>])| {
            // gcc stores a whole row wide, and then what is not zero; it stores none wide when zeros stand among them.
            self.zeros(part, &rows, if first { from_ref(&whole) } else { runs })
        };
        together(rows).into_iter().flat_map(lines).collect()
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
        let each = format!("for (int j = 0; j < {count}; j++)");
        C::body(each, format!("out->{part}[{row}][j] = {factor} * {columns}[j];"))
    }

    fn negated(&self, part: Part, rows: &Range<usize>, from: usize) -> Vec<String> {
        let count = part.shape(self.signature).1;
        let back = rows.start - from;
        if rows.len() == 1 {
            let (row, each) = (rows.start, format!("for (int j = 0; j < {count}; j++)"));
            return C::body(each, format!("out->{part}[{row}][j] = -out->{part}[{from}][j];"));
        }
        vec![
            format!("for (int i = {}; i < {}; i++)", rows.start, rows.end),
            format!("    for (int j = 0; j < {count}; j++) out->{part}[i][j] = -out->{part}[i - {back}][j];"),
        ]
    }

    fn leave(&self, condition: &str) -> Vec<String> {
        let zero = format!("    *out = ({}){{ 0 }};", self.results);
        vec![format!("if ({condition}) {{"), zero, "    return;".to_owned(), "}".to_owned()]
    }

    fn remark(&self, text: &str) -> Vec<String> {
        vec![format!("/* {text} */")]
    }
}
