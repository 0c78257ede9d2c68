//! Rust: one file for each force file, with one module per kernel and precision.
//!
//! In: a [`File`]. Out: code that rustc, rustfmt and clippy accept unchanged: no `unsafe`, no silenced lint
//! except `too_many_arguments`, and documentation on every public item. A kernel's module reads bodies
//! through `super` and by index only, so that any struct with indexable fields can replace them.

mod constants;
mod dialect;

use crate::emit::meaning::parameter_comment;
use crate::emit::parts::{Needed, needed};
use crate::emit::routine::{Routine, Step, routine};
use crate::emit::{
    MADE, NO_EDIT, acts, body, field_summary, kinds, lane_loop, reads, rust_body, sentence, template, visible,
};
use crate::kernel::{File, Kernel, Precision};
use crate::layout::Lanes;
use crate::math::functions::Function;
use crate::model::bodies::{BodyRow, Parameter, ParameterType, Signature};
use crate::model::outputs::Part;
use crate::names::{Arguments, Target, kernel_name};
use crate::rounding::rounding;
use crate::schedule::sections::Section;
use crate::schedule::{Statement, print};
use constants::constants;
use dialect::Rust;
use std::collections::BTreeSet;

/// The line width of rustfmt.
const WIDTH: usize = 100;

/// The largest number of arguments that clippy accepts, and the attribute of a function with more arguments.
const FEW: usize = 7;
const MANY: &str = "    #[allow(clippy::too_many_arguments, reason = \"they are what a step takes\")]\n";

/// The indentation of items in a module.
const INDENT: &str = "    ";

/// The whole file: body types, then the kernels.
pub fn module(file: &File) -> String {
    let mut text = String::new();
    for line in prose(&file.docs) {
        text.push_str(&format!("{}\n", format!("//! {line}").trim_end()));
    }
    if !file.docs.is_empty() {
        text.push_str("//!\n");
    }
    text.push_str(&format!("//! {MADE}`{}.rs`{NO_EDIT}\n", visible(&file.stem)));
    for &precision in &file.precisions {
        let lanes = file.kernels.first().map_or(Lanes::One, |kernel| kernel.lanes);
        for kind in kinds(file.kernels.iter().map(|kernel| &kernel.schedule.signature)) {
            text.push('\n');
            text.push_str(&body_type(kind.row(), precision, lanes));
        }
    }
    for kernel in &file.kernels {
        for &precision in &file.precisions {
            text.push('\n');
            text.push_str(&kernel_module(kernel, precision));
        }
    }
    text
}

/// The definition of a body type.
pub(crate) fn body_type(row: &BodyRow, precision: Precision, lanes: Lanes) -> String {
    let entries = |length| format!("[{}; {length}]", number(precision, lanes));
    let fields = row.fields.iter();
    let fields = fields.map(|f| (f.name.to_owned(), entries(f.length), field_summary(f).to_owned()));
    structure(&rust_body(row, precision, lanes), row.summary, fields.collect(), true, lanes, "")
}

/// The module of one kernel, which reads its body types through `super`.
pub fn kernel_module(kernel: &Kernel, precision: Precision) -> String {
    let schedule = &kernel.schedule;
    let signature = &schedule.signature;
    let mut text = documentation(kernel, precision);
    text.push_str(&format!("pub mod {} {{\n", module_name(kernel, precision)));
    text.push_str(&imports(signature, precision, kernel.lanes));
    text.push_str(&constants(kernel));
    text.push_str(&parameters(kernel, kernel.given(), precision));
    if kernel.once().is_some() {
        text.push_str(&parameters(kernel, signature, precision));
    }
    text.push('\n');
    text.push_str(&output(kernel, precision));
    let families: BTreeSet<Function> = schedule
        .families()
        .into_iter()
        .chain(kernel.once().iter().flat_map(|once| once.schedule.families()))
        .collect();
    for function in families {
        let definition = routine(function, precision).expect("a family is defined");
        text.push('\n');
        text.push_str(&special(function, &definition, precision));
    }
    let mut dialect = Rust::new(signature, precision, 8, kernel.lanes);
    dialect.adds = schedule.adds;
    let sections = schedule.sections();
    let parts = if kernel.lanes.is_one() && sections.len() > 1 {
        parts(kernel, &sections, &dialect)
    } else {
        String::new()
    };
    text.push_str(&parts);
    text.push_str(&prepare(kernel, precision));
    let computes =
        if schedule.adds { "Adds the results to those of `out`" } else { "Computes every entry of `out`" };
    // The runtime calls generic kernels within functions for certain CPU features.
    let inline = if kernel.lanes == Lanes::Generic { "inline(always)" } else { "inline" };
    text.push_str(&format!("\n    /// {computes}.\n    #[{inline}]\n"));
    text.push_str(&evaluate_head(kernel, precision));
    if !kernel.lanes.is_one() {
        let (zeros, rest) = lane_loop(schedule);
        text.push_str(&body(&dialect, schedule, zeros, "        "));
        if acts(&rest) {
            text.push_str(&format!("        for lane in 0..{} {{\n", kernel.lanes));
            let dialect = Rust::new(signature, precision, 12, kernel.lanes);
            let read = reads(schedule, &schedule.statements).extras;
            for (index, _) in
                signature.given_extras().filter(|(k, extra)| read[*k] && extra.ty != ParameterType::Real)
            {
                let name = &dialect.names.extras[index];
                text.push_str(&format!("            let {name} = {name}.map(|entry| entry[lane]);\n"));
            }
            text.push_str(&body(&dialect, schedule, rest, "            "));
            text.push_str("        }\n");
        }
    } else if sections.len() == 1 {
        text.push_str(&body(&dialect, schedule, &schedule.statements, "        "));
    } else {
        if sections.iter().any(Section::shares) {
            text.push_str("        let mut shared = Shared::default();\n");
        }
        for (index, section) in sections.iter().enumerate() {
            let reference = |needed: &Needed| match needed {
                Needed::Shared(true) => "&mut ",
                Needed::Shared(false) => "&",
                _ => "",
            };
            let needed = needed(schedule, section, &dialect.names);
            let passed = needed.iter().map(|it| format!("{}{}", reference(it), it.name()));
            let call = format!(
                "        {}({});\n",
                part_name(kernel, index, section),
                passed.collect::<Vec<_>>().join(", ")
            );
            text.push_str(&call);
        }
    }
    text.push_str("    }\n}\n");
    text
}

/// The struct of parameters, or the struct of prepared values.
fn parameters(kernel: &Kernel, signature: &Signature, precision: Precision) -> String {
    if !signature.has_given() {
        return String::new();
    }
    let names = Arguments::new(signature, Target::Rust);
    let fields = signature.given().map(|(index, parameter)| {
        let summary = parameter_comment(kernel, signature, index);
        let summary = summary.unwrap_or_else(|| parameter.name.replace('_', " "));
        (names.parameters[index].clone(), array(&parameter.ty, precision, kernel.lanes), summary)
    });
    let short = signature.given().all(|(_, p)| p.ty.extents().iter().all(|&n| n <= 32));
    let summary = if signature.prepared {
        "what the kernel reads at every call: parameters, and values computed of them"
    } else {
        "the parameters, in source order"
    };
    format!("\n{}", structure(struct_of(&names), summary, fields.collect(), short, kernel.lanes, INDENT))
}

/// The struct of the argument for parameters.
fn struct_of(names: &Arguments) -> &'static str {
    if names.given == "prepared" { "Prepared" } else { "Params" }
}

/// The type of the argument for parameters.
fn type_of(names: &Arguments, lanes: Lanes) -> String {
    format!("{}{}", struct_of(names), generic(lanes, "<L>"))
}

/// A list of const parameters or arguments, for kernels that have a const parameter.
fn generic(lanes: Lanes, list: &'static str) -> &'static str {
    if lanes == Lanes::Generic { list } else { "" }
}

/// The declaration of the const parameter.
const DECLARED: &str = "<const L: usize>";

/// The function that computes a kernel's prepared values; empty for a kernel without prepared values.
fn prepare(kernel: &Kernel, precision: Precision) -> String {
    let Some(once) = kernel.once() else { return String::new() };
    let schedule = &once.schedule;
    let signature = &schedule.signature;
    let (indent, space) = if kernel.lanes.is_one() { (8, "        ") } else { (12, "            ") };
    let mut dialect = Rust::new(signature, precision, indent, kernel.lanes);
    let fields = Arguments::new(&kernel.schedule.signature, Target::Rust).parameters;
    let (kept, values) = fields.split_at(once.kept.len());
    dialect.prepared = values.to_vec();
    let mut text =
        "\n    /// Computes what depends on parameters alone, once for all calls with these.\n    #[inline]\n"
            .to_owned();
    let arguments = ["params: &Params", "prepared: &mut Prepared"].map(str::to_owned);
    text.push_str(&head("pub fn prepare", &arguments));
    for (field, parameter) in kept.iter().zip(&once.kept) {
        let source = &dialect.names.parameters[*parameter];
        if signature.parameters[*parameter].value.is_none() {
            text.push_str(&format!("        prepared.{field} = params.{source};\n"));
        }
    }
    let statements = body(&dialect, schedule, &schedule.statements, space);
    if kernel.lanes.is_one() {
        text.push_str(&statements);
    } else {
        text.push_str(&format!("        for lane in 0..{} {{\n{statements}        }}\n", kernel.lanes));
    }
    text + "    }\n"
}

/// The struct of the results; values that results are added to are borrowed.
fn output(kernel: &Kernel, precision: Precision) -> String {
    let schedule = &kernel.schedule;
    let signature = &schedule.signature;
    let names = Arguments::new(signature, Target::Rust);
    let borrow = if schedule.adds { "&'a mut " } else { "" };
    let field = |part: &Part| {
        let (rows, columns) = part.shape(signature);
        let number = number(precision, kernel.lanes);
        let row = if part.is_list() { number } else { format!("[{number}; {columns}]") };
        let name = names.result(*part).to_owned();
        (name, format!("{borrow}[{row}; {rows}]"), part.summary(signature))
    };
    let fields: Vec<(String, String, String)> = schedule.parts.iter().map(field).collect();
    if schedule.adds {
        let mut text =
            "    /// What the results are added to, entries that are not always zero.\n    #[repr(C)]\n    \
                        #[derive(Debug, PartialEq)]\n    pub struct Output<'a> {\n"
                .to_owned();
        for (name, ty, summary) in fields {
            text.push_str(&format!("        /// {}\n        pub {name}: {ty},\n", sentence(&summary)));
        }
        return text + "    }\n";
    }
    let extents = schedule.parts.iter().map(|part| part.shape(signature));
    let short = extents.map(|(rows, columns)| rows.max(columns)).max().unwrap_or(0) <= 32;
    structure("Output", "the results", fields, short, kernel.lanes, INDENT)
}

/// The type of the argument that the results are written to.
fn results(kernel: &Kernel) -> &'static str {
    match kernel.lanes {
        Lanes::Generic => "&mut Output<L>",
        _ if kernel.schedule.adds => "&mut Output<'_>",
        _ => "&mut Output",
    }
}

/// The declaration of an argument of a part of a long kernel.
fn declared(kernel: &Kernel, needed: &Needed, precision: Precision) -> String {
    match *needed {
        Needed::Body(body, name) => format!("{name}: &{}", body.kind.row().name),
        Needed::Parameters(name) => {
            let names = Arguments::new(&kernel.schedule.signature, Target::Rust);
            format!("{name}: &{}", type_of(&names, kernel.lanes))
        }
        Needed::Extra(extra, name) => extra_argument(extra, name, kernel.lanes, precision),
        Needed::Shared(true) => "shared: &mut Shared".to_owned(),
        Needed::Shared(false) => "shared: &Shared".to_owned(),
        Needed::Results => format!("out: {}", results(kernel)),
    }
}

fn part_name(kernel: &Kernel, index: usize, section: &Section) -> String {
    let names = Arguments::new(&kernel.schedule.signature, Target::Rust);
    format!("{}_{}", names.result(section.part), index + 1)
}

/// The definitions before a long kernel: the struct of the values that its parts share, and the parts.
fn parts(kernel: &Kernel, sections: &[Section], dialect: &Rust) -> String {
    let schedule = &kernel.schedule;
    let space = "        ";
    let mut text = String::new();
    if sections.iter().any(Section::shares) {
        text.push_str("\n    /// What parts of the kernel hand on to later ones.\n    #[derive(Default)]\n    struct Shared {\n");
        for name in sections.iter().flat_map(|section| &section.hands_on) {
            let variable = &schedule.variables[name.index()];
            let ty = if variable.truth { "bool" } else { dialect.precision.name() };
            text.push_str(&format!("{space}{}: {ty},\n", variable.name));
        }
        text.push_str("    }\n");
    }
    for (index, section) in sections.iter().enumerate() {
        let needed = needed(schedule, section, &dialect.names);
        let declared = needed.iter().map(|it| declared(kernel, it, dialect.precision));
        text.push_str(&format!(
            "\n    /// Part {} of {}.\n    #[inline(never)]\n",
            index + 1,
            sections.len()
        ));
        text.push_str(&head(
            &format!("fn {}", part_name(kernel, index, section)),
            &declared.collect::<Vec<_>>(),
        ));
        let mut lines = Vec::new();
        for name in &section.takes {
            let name = &schedule.variables[name.index()].name;
            lines.extend(dialect.assign(&format!("let {name}"), &format!("shared.{name}")));
        }
        lines.iter().for_each(|line| text.push_str(&format!("{space}{line}\n")));
        text.push_str(&body(dialect, schedule, section.written(schedule), space));
        for name in &section.hands_on {
            let name = &schedule.variables[name.index()].name;
            text.push_str(&format!("{space}shared.{name} = {name};\n"));
        }
        text.push_str("    }\n");
    }
    text
}

/// The name of a kernel's module.
pub fn module_name(kernel: &Kernel, precision: Precision) -> String {
    let suffix = if precision == Precision::F32 { "_f32" } else { "" };
    kernel_name(&kernel.name, Target::Rust, suffix)
}

fn documentation(kernel: &Kernel, precision: Precision) -> String {
    let mut lines = prose(&kernel.docs);
    if !lines.is_empty() {
        lines.push(String::new());
    }
    lines.push("```text".to_owned());
    lines.extend(kernel.summary());
    lines.extend(rounding(kernel, precision).lines());
    lines.push("```".to_owned());
    lines.iter().map(|line| format!("{}\n", format!("/// {line}").trim_end())).collect()
}

/// A doc comment that is safe for rustdoc: code blocks that rustdoc would compile and run become text blocks,
/// and an unclosed code block is closed.
fn prose(docs: &[String]) -> Vec<String> {
    let mut lines = Vec::new();
    let mut open: Option<String> = None;
    for line in docs {
        let line = visible(line).replace('\t', "    ");
        let text = line.trim_start();
        let indent = line.len() - text.len();
        let mark = text.chars().next().filter(|mark| ['`', '~'].contains(mark) && indent < 4);
        let length = mark.map_or(0, |mark| text.chars().take_while(|c| *c == mark).count());
        let (fence, info) = (&text[..length], text[length..].trim());
        match &open {
            Some(begun) => {
                if fence.starts_with(begun.as_str()) && info.is_empty() {
                    open = None;
                }
                lines.push(line);
            }
            None if length >= 3 && !(mark == Some('`') && info.contains('`')) => {
                open = Some(fence.to_owned());
                lines.push(format!(
                    "{}{fence}{}",
                    " ".repeat(indent),
                    if is_code(info) { "text" } else { info }
                ));
            }
            // Four spaces would begin a code block.
            None => lines.push(format!("{}{text}", " ".repeat(indent.min(3)))),
        }
    }
    lines.extend(open);
    lines
}

/// Whether rustdoc takes a code block with this info string for Rust.
fn is_code(info: &str) -> bool {
    let words =
        ["rust", "should_panic", "no_run", "compile_fail", "test_harness", "standalone_crate", "custom"];
    let mut parts = info.split([',', ' ', '\t', '{', '}']).filter(|part| !part.is_empty());
    parts.all(|part| {
        let begins = ["ignore", "edition", "E0"].iter().any(|word| part.starts_with(word));
        begins || words.contains(&part)
    })
}

fn imports(signature: &Signature, precision: Precision, lanes: Lanes) -> String {
    let mut names: Vec<String> = Vec::new();
    for kind in kinds(std::iter::once(signature)) {
        let (name, own) = (kind.row().name, rust_body(kind.row(), precision, lanes));
        names.push(if own == name || lanes == Lanes::Generic { own } else { format!("{own} as {name}") });
    }
    names.sort();
    match names.as_slice() {
        [] => String::new(),
        [single] => format!("    use super::{single};\n"),
        several => format!("    use super::{{{}}};\n", several.join(", ")),
    }
}

/// A documented struct; `derives` is true if the standard library implements `Default` for its arrays, unless
/// their length is a const parameter.
fn structure(
    name: &str,
    summary: &str,
    fields: Vec<(String, String, String)>,
    derives: bool,
    lanes: Lanes,
    indent: &str,
) -> String {
    let derives = derives && lanes != Lanes::Generic;
    let (declared, passed) = (generic(lanes, DECLARED), generic(lanes, "<L>"));
    let default = if derives { ", Default" } else { "" };
    let mut lines = vec![
        format!("/// {}", sentence(summary)),
        "#[repr(C)]".to_owned(),
        format!("#[derive(Clone, Copy, Debug{default}, PartialEq)]"),
        format!("pub struct {name}{declared} {{"),
    ];
    for (field, ty, summary) in &fields {
        lines.push(format!("    /// {}", sentence(summary)));
        lines.push(format!("    pub {field}: {ty},"));
    }
    lines.push("}".to_owned());
    if !derives {
        lines.extend(["", &format!("impl{declared} Default for {name}{passed} {{")].map(str::to_owned));
        /// rustfmt's `struct_lit_width`.
        const STRUCT: usize = 18;
        let zero = |ty: &str| ty.replace("f64", "0.0").replace("f32", "0.0");
        let zeros: Vec<String> =
            fields.iter().map(|(field, ty, _)| format!("{field}: {}", zero(ty))).collect();
        lines.push("    fn default() -> Self {".to_owned());
        let line = zeros.join(", ");
        if line.len() <= STRUCT {
            lines.push(format!("        Self {{ {line} }}"));
        } else {
            lines.push("        Self {".to_owned());
            lines.extend(zeros.iter().map(|zero| format!("            {zero},")));
            lines.push("        }".to_owned());
        }
        lines.extend(["    }", "}"].map(str::to_owned));
    }
    lines
        .iter()
        .map(|line| if line.is_empty() { "\n".to_owned() } else { format!("{indent}{line}\n") })
        .collect()
}

/// The type of a number: one value per instance.
fn number(precision: Precision, lanes: Lanes) -> String {
    if lanes.is_one() { precision.to_string() } else { format!("[{precision}; {lanes}]") }
}

fn array(ty: &ParameterType, precision: Precision, lanes: Lanes) -> String {
    ty.extents().iter().rev().fold(number(precision, lanes), |inner, n| format!("[{inner}; {n}]"))
}

/// The declaration of an extra argument; a scalar is the same for all instances.
fn extra_argument(extra: &Parameter, name: &str, lanes: Lanes, precision: Precision) -> String {
    let (borrowed, lanes) = if extra.ty == ParameterType::Real { ("", Lanes::One) } else { ("&", lanes) };
    format!("{name}: {borrowed}{}", array(&extra.ty, precision, lanes))
}

fn evaluate_head(kernel: &Kernel, precision: Precision) -> String {
    let signature = &kernel.schedule.signature;
    let reads = reads(&kernel.schedule, &kernel.schedule.statements);
    let unused = |read: bool| if read { "" } else { "_" };
    let mut arguments: Vec<String> = Vec::new();
    let names = Arguments::new(signature, Target::Rust);
    for ((body, name), read) in signature.bodies.iter().zip(&names.bodies).zip(reads.bodies) {
        let ty = match kernel.lanes {
            Lanes::Generic => {
                format!("{}<{precision}, L>", rust_body(body.kind.row(), precision, kernel.lanes))
            }
            _ => body.kind.row().name.to_owned(),
        };
        arguments.push(format!("{}{name}: &{ty}", unused(read)));
    }
    if signature.has_given() {
        let (name, ty) = (names.given, type_of(&names, kernel.lanes));
        arguments.push(format!("{}{name}: &{ty}", unused(reads.parameters)));
    }
    for (index, extra) in signature.given_extras() {
        let declared = extra_argument(extra, &names.extras[index], kernel.lanes, precision);
        arguments.push(format!("{}{declared}", unused(reads.extras[index])));
    }
    arguments.push(format!("{}out: {}", unused(reads.results), results(kernel)));
    head(&format!("pub fn evaluate{}", generic(kernel.lanes, DECLARED)), &arguments)
}

/// The head of a function in a module.
fn head(name: &str, arguments: &[String]) -> String {
    let line = format!("    {name}({}) {{", arguments.join(", "));
    let many = if arguments.len() > FEW { MANY } else { "" };
    if line.len() <= WIDTH {
        return format!("{many}{line}\n");
    }
    let arguments: String = arguments.iter().map(|argument| format!("        {argument},\n")).collect();
    format!("{many}    {name}(\n{arguments}    ) {{\n")
}

/// The definition of a special function.
fn special(function: Function, routine: &Routine, precision: Precision) -> String {
    let empty = Signature::default();
    let name = template(function.row().rust, function, precision);
    let name = name.split('(').next().unwrap_or_default();
    let arguments: Vec<String> =
        routine.variables[..routine.arguments].iter().map(|v| format!("{}: {precision}", v.name)).collect();
    let mut text = format!("    /// {}\n", sentence(&routine.summary));
    text.push_str(&format!("    fn {name}({}) -> {precision} {{\n", arguments.join(", ")));
    let expression = |expression, indent| {
        print::expression(&Rust::new(&empty, precision, indent, Lanes::One), &routine.variables, expression)
    };
    let write = |text: &mut String, statement: &Statement, indent: usize| {
        let dialect = Rust::new(&empty, precision, indent, Lanes::One);
        let space = " ".repeat(indent);
        for line in print::statement(&dialect, &routine.variables, statement) {
            text.push_str(&format!("{space}{line}\n"));
        }
    };
    for step in &routine.steps {
        match step {
            Step::Do(statement) => write(&mut text, statement, 8),
            Step::Return(condition, statements, result) => {
                text.push_str(&format!("        if {} {{\n", expression(condition, 8)));
                statements.iter().for_each(|statement| write(&mut text, statement, 12));
                text.push_str(&format!("            return {};\n        }}\n", expression(result, 12)));
            }
        }
    }
    text.push_str(&format!("        {}\n    }}\n", expression(&routine.result, 8)));
    text
}
