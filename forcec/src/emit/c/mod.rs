//! C99: a header and a source for each force file, and the common header `forcec.h`.
//!
//! In: a [`File`]. Out: code that compiles without warnings as C99, with headers that are valid C++ too; the
//! only dependency is `<math.h>`.

mod dialect;
mod prepare;

use crate::emit::meaning::parameter_comment;
use crate::emit::parts::{Needed, needed};
use crate::emit::routine::{Routine, Step, routine};
use crate::emit::{
    COMMON, MADE, NO_EDIT, acts, body, field_summary, lane_loop, reads, stored_as, template, visible,
};
use crate::kernel::{File, Kernel, Precision};
use crate::layout::{LANES, Lanes, Place};
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::{BODIES, Parameter, ParameterType, Signature};
use crate::model::outputs::Part;
use crate::names::{Arguments, Target, kernel_name};
use crate::rounding::rounding;
use crate::schedule::sections::Section;
use crate::schedule::{Statement, print};
use dialect::{C, literal};
use std::f64::consts::PI;

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

/// Keeps the parts of long kernels separate: compilers would inline functions that are called once.
const APART: &str = "
/* Long kernels are split into parts because compile time grows faster than linearly. */
#if defined(__GNUC__)
#define FORCEC_APART __attribute__((noinline))
#elif defined(_MSC_VER)
#define FORCEC_APART __declspec(noinline)
#else
#define FORCEC_APART
#endif
";

/// The comment in the header on results that are added to the caller's values.
const ADDED: [&str; 2] = [
    "The results are added to what these point to: row by row, entries that are not always zero.",
    "No two may overlap, nor may one overlap an argument.",
];

/// The line width: longer statements continue on the next line. 100 columns minus the indentation of a
/// function body.
const WIDTH: usize = 96;

fn real(precision: Precision) -> &'static str {
    match precision {
        Precision::F64 => "double",
        Precision::F32 => "float",
    }
}

/// The array extent for the given number of instances.
fn extent(lanes: Lanes) -> String {
    if lanes.is_one() { String::new() } else { format!("[{lanes}]") }
}

/// The suffix of a body type for the given number of instances.
fn several_suffix(lanes: Lanes) -> String {
    if lanes.is_one() { String::new() } else { format!("x{lanes}") }
}

/// The text of `forcec.h`: bodies, constants and special functions, in both precisions.
pub fn header_common() -> String {
    let mut text =
        format!("/*\n * {COMMON}\n */\n#ifndef FORCEC_H\n#define FORCEC_H\n\n#include <math.h>\n\n");
    let pi = Exact::from_f64(PI).expect("finite");
    for precision in PRECISIONS {
        let name = template("FORCEC_PI{F}", Function::Pi, precision);
        text.push_str(&format!("#define {name} {}\n", literal(&pi, precision)));
    }
    text.push_str(APART);
    for (lanes, precision) in
        LANES.map(Lanes::of).into_iter().flat_map(|lanes| PRECISIONS.map(|p| (lanes, p)))
    {
        for row in &BODIES {
            let several = if lanes.is_one() { String::new() } else { format!("{lanes} times: ") };
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
            // Functions in `<math.h>` are called from there.
            let own = function.row().c.starts_with("forcec_");
            if let Some(routine) = routine(function, precision).filter(|_| own) {
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
    let dialect = C::new(&empty, precision, Lanes::One);
    let real = real(precision);
    let name = template(function.row().c, function, precision);
    let name = name.split('(').next().unwrap_or_default();
    let arguments: Vec<String> =
        routine.variables[..routine.arguments].iter().map(|v| format!("{real} {}", v.name)).collect();
    let mut text =
        format!("\n/* {} */\nstatic inline {real} {name}({})\n{{\n", routine.summary, arguments.join(", "));
    let write = |text: &mut String, statement: &Statement, indent: &str| {
        for line in print::statement(&dialect, &routine.variables, statement) {
            text.push_str(&format!("{indent}{line}\n"));
        }
    };
    let expression = |expression| print::expression(&dialect, &routine.variables, expression);
    for step in &routine.steps {
        match step {
            Step::Do(statement) => write(&mut text, statement, "    "),
            Step::Return(condition, statements, result) => {
                text.push_str(&format!("    if ({}) {{\n", expression(condition)));
                statements.iter().for_each(|statement| write(&mut text, statement, "        "));
                text.push_str(&format!("        return {};\n    }}\n", expression(result)));
            }
        }
    }
    text.push_str(&format!("    return {};\n", expression(&routine.result)));
    text.push_str("}\n");
    text
}

/// The header of a force file: parameter and output structs, and function declarations.
pub fn header(file: &File) -> String {
    let guard = guard(&file.name());
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

/// The include guard of a header. Different names have different guards: any byte other than a lower-case
/// letter, a digit or `_` is written in hexadecimal, and only these escapes contain lower-case letters.
fn guard(name: &str) -> String {
    let letter = |byte: u8| match byte {
        b'a'..=b'z' | b'0'..=b'9' | b'_' => char::from(byte.to_ascii_uppercase()).to_string(),
        _ => format!("x{byte:02x}"),
    };
    format!("FORCEC_{}_H", name.bytes().map(letter).collect::<String>())
}

/// The name of a kernel's function or of one of its structs.
fn named(kernel: &Kernel, part: &str, precision: Precision) -> String {
    kernel_name(&kernel.name, Target::C, &format!("{part}_{precision}"))
}

fn declaration(kernel: &Kernel, precision: Precision) -> String {
    let (real, lanes) = (real(precision), extent(kernel.lanes));
    let signature = &kernel.schedule.signature;
    let mut text = parameters(kernel, kernel.given(), precision);
    if kernel.once().is_some() {
        text.push_str(&parameters(kernel, signature, precision));
    }
    text.push_str(&comment(&storage_remarks(kernel), ""));
    text.push_str("typedef struct {\n");
    let names = Arguments::new(signature, Target::C);
    for &part in &kernel.schedule.parts {
        let ((rows, columns), name) = (part.shape(signature), names.result(part));
        let field = match (kernel.schedule.adds, part.is_list()) {
            (false, true) => format!("{name}[{rows}]{lanes}"),
            (false, false) => format!("{name}[{rows}][{columns}]{lanes}"),
            (true, true) => format!("*{name}"),
            (true, false) => format!("(*{name})[{columns}]"),
        };
        let count = if kernel.schedule.adds { format!("; {rows} rows") } else { String::new() };
        let summary = part.summary(signature).replace('`', "");
        text.push_str(&format!("    {real} {field}; /* {summary}{count} */\n"));
    }
    text.push_str(&format!("}} {};\n\n", named(kernel, "_out", precision)));
    if let Some(anchored) = kernel.anchored {
        let (name, value) = (named(kernel, "_anchored", precision), u8::from(anchored));
        let is = if anchored { "is" } else { "is not" };
        let fact = format!("J {is} ±(I, −[r]×) for every rigid body and ±I for every particle");
        text.push_str(&format!("enum {{ {name} = {value} }}; /* {fact} */\n\n"));
    }
    text.push_str(&tables(kernel, precision));
    if kernel.once().is_some() {
        let remark = format!(
            "Computes what {} reads at every call, once for all calls with these parameters.",
            named(kernel, "", precision)
        );
        text.push_str(&comment(&[remark], ""));
        text.push_str(&format!("{};\n\n", prepare::head(kernel, precision, false)));
    }
    text.push_str(&comment(&kernel.docs, ""));
    text.push_str(&format!("{};\n", prototype(kernel, precision, false)));
    text
}

/// The struct of parameters, or the struct of prepared values.
fn parameters(kernel: &Kernel, signature: &Signature, precision: Precision) -> String {
    if !signature.has_given() {
        return String::new();
    }
    let (real, lanes) = (real(precision), extent(kernel.lanes));
    let names = Arguments::new(signature, Target::C);
    let mut text = "typedef struct {\n".to_owned();
    for (index, parameter) in signature.given() {
        let field = format!("{}{}{lanes}", names.parameters[index], extents(&parameter.ty));
        let comment = parameter_comment(kernel, signature, index);
        let comment = comment.map_or(String::new(), |text| format!(" /* {} */", escape(&text)));
        text.push_str(&format!("    {real} {field};{comment}\n"));
    }
    text + &format!("}} {};\n\n", named(kernel, &format!("_{}", names.given), precision))
}

/// The comment in the header on the storage of the outputs.
fn storage_remarks(kernel: &Kernel) -> Vec<String> {
    let mut lines = kernel.packing.as_ref().map_or(Vec::new(), |packing| packing.remarks.clone());
    if kernel.schedule.adds {
        lines.extend(ADDED.map(str::to_owned));
    }
    lines
}

/// Constants that a caller can check at compile time: which matrices are stored as their upper triangle, and
/// where the entries of a packed kernel are stored.
fn tables(kernel: &Kernel, precision: Precision) -> String {
    let Some(packing) = &kernel.packing else { return String::new() };
    match kernel.layout.row().place {
        Place::Triangle => {
            let line = |(part, triangle): (Part, bool)| {
                let name = named(kernel, &format!("_{part}_triangle"), precision);
                format!("enum {{ {name} = {} }}; /* {} */\n", u8::from(triangle), stored_as(triangle))
            };
            return kernel.triangles().map(line).collect::<String>() + "\n";
        }
        Place::Shared => {}
        Place::Itself | Place::Bodies => return String::new(),
    }
    let mut text = comment(
        &[
            "Positions of the entries of the full outputs: k > 0 is entries[k - 1], k < 0 is -entries[-k - 1],".to_owned(),
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

/// The function head. In the definition, the arguments of a kernel of several instances are `restrict`, a
/// keyword that C++ lacks.
fn prototype(kernel: &Kernel, precision: Precision, defines: bool) -> String {
    let signature = &kernel.schedule.signature;
    let (several, star) = (several_suffix(kernel.lanes), star(kernel, defines));
    let Arguments { bodies, given, extras, .. } = Arguments::new(signature, Target::C);
    let mut arguments: Vec<String> = Vec::new();
    for (body, name) in signature.bodies.iter().zip(bodies) {
        arguments.push(format!("const {}_{precision}{several} {star}{name}", body.kind.row().c_name));
    }
    if signature.has_given() {
        arguments.push(format!("const {} {star}{given}", named(kernel, &format!("_{given}"), precision)));
    }
    for (index, extra) in signature.given_extras() {
        arguments.push(extra_argument(extra, &extras[index], kernel.lanes, precision));
    }
    arguments.push(format!("{}{} {star}out", added(kernel), named(kernel, "_out", precision)));
    wrapped(&format!("void {}(", named(kernel, "", precision)), &arguments, ")")
}

/// The text between the type and the name of an argument.
fn star(kernel: &Kernel, defines: bool) -> &'static str {
    if defines && !kernel.lanes.is_one() { "*restrict " } else { "*" }
}

/// The qualifier before the result type: pointers to values that results are added to are `const`.
fn added(kernel: &Kernel) -> &'static str {
    if kernel.schedule.adds { "const " } else { "" }
}

/// The declaration of an extra argument; a scalar is the same for all instances.
fn extra_argument(extra: &Parameter, name: &str, lanes: Lanes, precision: Precision) -> String {
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
    let once = prepare::definition(kernel, precision);
    remark.extend(rounding(kernel, precision).lines());
    let mut text = comment(&remark, "");
    text.push_str(&format!("{}\n{{\n", prototype(kernel, precision, true)));
    let reads = reads(schedule, &schedule.statements);
    let mut dialect = C::new(&schedule.signature, precision, kernel.lanes);
    dialect.results = (!schedule.adds).then(|| named(kernel, "_out", precision));
    let extras = schedule.signature.given_extras().map(|(k, _)| (&dialect.names.extras[k], reads.extras[k]));
    for (name, read) in dialect.names.bodies.iter().zip(reads.bodies).chain(extras) {
        if !read {
            text.push_str(&format!("    (void){name};\n"));
        }
    }
    if !reads.parameters && schedule.signature.has_given() {
        text.push_str(&format!("    (void){};\n", dialect.names.given));
    }
    if !reads.results {
        text.push_str("    (void)out;\n");
    }
    let sections = schedule.sections();
    if !kernel.lanes.is_one() {
        // Compilers vectorise a loop that contains no inner loop.
        let (zeros, rest) = lane_loop(schedule);
        text.push_str(&body(&dialect, schedule, zeros, "    "));
        if acts(&rest) {
            text.push_str(&format!("    for (int lane = 0; lane < {}; lane++) {{\n", kernel.lanes));
            text.push_str(&body(&dialect, schedule, rest, "        "));
            text.push_str("    }\n");
        }
    } else if sections.len() == 1 {
        text.push_str(&body(&dialect, schedule, &schedule.statements, "    "));
    } else {
        text.insert_str(0, &parts(kernel, &sections, &dialect));
        if sections.iter().any(Section::shares) {
            text.push_str(&format!("    {} shared;\n", shared(kernel, precision)));
        }
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
    once + &text
}

/// The name of the struct through which the parts of a long kernel share values.
fn shared(kernel: &Kernel, precision: Precision) -> String {
    format!("{}_shared", named(kernel, "", precision))
}

fn part_name(kernel: &Kernel, precision: Precision, index: usize, section: &Section) -> String {
    let part = section.part.stem(&kernel.schedule.signature);
    format!("{}_{part}_{}", named(kernel, "", precision), index + 1)
}

/// The declaration of an argument of a part of a long kernel.
fn declared(kernel: &Kernel, needed: &Needed, precision: Precision) -> String {
    match *needed {
        Needed::Body(body, name) => format!("const {}_{precision} *{name}", body.kind.row().c_name),
        Needed::Parameters(name) => {
            format!("const {} *{name}", named(kernel, &format!("_{name}"), precision))
        }
        Needed::Extra(extra, name) => extra_argument(extra, name, kernel.lanes, precision),
        Needed::Shared(true) => format!("{} *shared", shared(kernel, precision)),
        Needed::Shared(false) => format!("const {} *shared", shared(kernel, precision)),
        Needed::Results => format!("{}{} *out", added(kernel), named(kernel, "_out", precision)),
    }
}

/// The definitions before a long kernel: the struct of the values that its parts share, and the parts.
fn parts(kernel: &Kernel, sections: &[Section], dialect: &C) -> String {
    let schedule = &kernel.schedule;
    let precision = dialect.precision;
    let whole = named(kernel, "", precision);
    let mut text = String::new();
    // C does not allow a struct without fields.
    if sections.iter().any(Section::shares) {
        text.push_str(&format!("/* What parts of {whole} hand on to later ones. */\ntypedef struct {{\n"));
        for name in sections.iter().flat_map(|section| &section.hands_on) {
            let variable = &schedule.variables[name.index()];
            text.push_str(&format!("    {} {};\n", dialect.ty(variable), variable.name));
        }
        text.push_str(&format!("}} {};\n\n", shared(kernel, precision)));
    }
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
    format!("{MADE}{}.rs{NO_EDIT}", file.stem)
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

/// Text that is safe inside a comment.
fn escape(text: &str) -> String {
    visible(text).replace("*/", "* /").replace("/*", "/ *").replace("??/", "? ?/")
}
