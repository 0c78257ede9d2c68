//! Rust: one file for a force file, with a module a kernel and precision.
//!
//! In: a [`File`]. Out: text that rustc, rustfmt and clippy accept as it stands: no `unsafe`, no silenced lint, every
//! public item documented. A kernel's module reads bodies through `super` and by index only, so that any struct with
//! indexable fields serves.

use crate::bodies::{Parameter, ParameterType, Signature, Slot};
use crate::exact::Exact;
use crate::identifiers::{Arguments, Target, kernel_name};
use crate::kernel::{File, Kernel, Precision};
use crate::ops::Function;
use crate::rounding::rounding;
use crate::schedule::print::{self, Dialect, together};
use crate::schedule::split::Section;
use crate::schedule::{Output, Part, Statement, Variable};
use crate::targets::parts::{Needed, needed};
use crate::targets::routine::{Routine, Way, routine};
use crate::targets::{
    body, decimal, field_summary, kinds, lane, lane_loop, parameter_summary, reads, rust_body, sentence,
    slot_path, template,
};
use std::f64::consts;
use std::ops::Range;

/// The width rustfmt breaks lines at.
const WIDTH: usize = 100;

/// What stands in a module is indented by this.
const INDENT: &str = "    ";

/// The whole file: body types, then the kernels.
pub fn module(file: &File) -> String {
    let mut text = String::new();
    for line in file.docs.iter().map(|line| line.trim_end()) {
        text.push_str(&format!("{}\n", format!("//! {line}").trim_end()));
    }
    if !file.docs.is_empty() {
        text.push_str("//!\n");
    }
    text.push_str(&format!("//! Made by forcec from `{}.rs`; the code is yours.\n", file.stem));
    for &precision in &file.precisions {
        let lanes = file.kernels.first().map_or(1, |kernel| kernel.lanes);
        for kind in kinds(file.kernels.iter().map(|kernel| &kernel.schedule.signature)) {
            let row = kind.row();
            let fields = row.fields.iter().map(|field| {
                (
                    field.name.to_owned(),
                    format!("[{}; {}]", number(precision, lanes), field.length),
                    field_summary(field).to_owned(),
                )
            });
            text.push('\n');
            text.push_str(&structure(
                &rust_body(row, precision, lanes),
                row.summary,
                fields.collect(),
                true,
                "",
            ));
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

/// The module of one kernel, which reads its body types through `super`.
pub fn kernel_module(kernel: &Kernel, precision: Precision) -> String {
    let schedule = &kernel.schedule;
    let signature = &schedule.signature;
    let mut text = documentation(kernel, precision);
    text.push_str(&format!("pub mod {} {{\n", module_name(kernel, precision)));
    text.push_str(&imports(signature, precision, kernel.lanes));
    text.push_str(&constants(kernel));
    if signature.has_given() {
        let names = Arguments::new(signature, Target::Rust).parameters;
        let fields = signature.given().map(|(index, parameter)| {
            (
                names[index].clone(),
                array(&parameter.ty, precision, kernel.lanes),
                parameter_summary(parameter),
            )
        });
        let short = signature.given().all(|(_, p)| p.ty.extents().iter().all(|&n| n <= 32));
        text.push('\n');
        text.push_str(&structure(
            "Params",
            "the parameters, in source order",
            fields.collect(),
            short,
            "    ",
        ));
    }
    let fields = schedule.parts.iter().map(|&part| {
        let (rows, columns) = part.shape(signature);
        let number = number(precision, kernel.lanes);
        let row = if part.is_list() { number } else { format!("[{number}; {columns}]") };
        (part.to_string(), format!("[{row}; {rows}]"), part.row().summary.to_owned())
    });
    let extents = schedule.parts.iter().map(|part| part.shape(signature));
    let short = extents.map(|(rows, columns)| rows.max(columns)).max().unwrap_or(0) <= 32;
    text.push('\n');
    text.push_str(&structure("Output", "the results", fields.collect(), short, "    "));
    for function in schedule.families() {
        let definition = routine(function, precision).expect("a family is defined");
        text.push('\n');
        text.push_str(&special(function, &definition, precision));
    }
    let dialect = Rust::new(signature, precision, 8, kernel.lanes);
    let sections = schedule.sections();
    let parts = if kernel.lanes == 1 && sections.len() > 1 {
        parts(kernel, &sections, &dialect)
    } else {
        String::new()
    };
    text.push_str(&parts);
    text.push_str("\n    /// Computes every entry of `out`.\n");
    text.push_str(&evaluate_head(kernel, precision));
    if kernel.lanes > 1 {
        let (zeros, rest) = lane_loop(schedule);
        text.push_str(&body(&dialect, schedule, zeros, "        "));
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
    } else if sections.len() == 1 {
        text.push_str(&body(&dialect, schedule, &schedule.statements, "        "));
    } else {
        text.push_str("        let mut shared = Shared::default();\n");
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
                part_name(index, section),
                passed.collect::<Vec<_>>().join(", ")
            );
            text.push_str(&call);
        }
    }
    text.push_str("    }\n}\n");
    text
}

/// An argument of a part of a long kernel, as it is declared.
fn declared(kernel: &Kernel, needed: &Needed, precision: Precision) -> String {
    match *needed {
        Needed::Body(body, name) => format!("{name}: &{}", body.kind.row().name),
        Needed::Parameters => "params: &Params".to_owned(),
        Needed::Extra(extra, name) => extra_argument(extra, name, kernel.lanes, precision),
        Needed::Shared(true) => "shared: &mut Shared".to_owned(),
        Needed::Shared(false) => "shared: &Shared".to_owned(),
        Needed::Results => "out: &mut Output".to_owned(),
    }
}

fn part_name(index: usize, section: &Section) -> String {
    format!("{}_{}", section.part, index + 1)
}

/// What stands before a long kernel: the struct of the values that its parts hand on, and the parts.
fn parts(kernel: &Kernel, sections: &[Section], dialect: &Rust) -> String {
    let schedule = &kernel.schedule;
    let space = "        ";
    let mut text = "\n    /// What parts of the kernel hand on to later ones.\n    #[derive(Default)]\n    struct Shared {\n".to_owned();
    for name in sections.iter().flat_map(|section| &section.hands_on) {
        let variable = &schedule.variables[name.index()];
        let ty = if variable.truth { "bool" } else { dialect.precision.name() };
        text.push_str(&format!("{space}{}: {ty},\n", variable.name));
    }
    text.push_str("    }\n");
    for (index, section) in sections.iter().enumerate() {
        let needed = needed(schedule, section, &dialect.names);
        let declared = needed.iter().map(|it| declared(kernel, it, dialect.precision));
        text.push_str(&format!(
            "\n    /// Part {} of {}.\n    #[inline(never)]\n",
            index + 1,
            sections.len()
        ));
        text.push_str(&head(&format!("fn {}", part_name(index, section)), &declared.collect::<Vec<_>>()));
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

/// What a program may want to know of a kernel: names, sizes, operations, which entries are always zero.
fn constants(kernel: &Kernel) -> String {
    let schedule = &kernel.schedule;
    let signature = &schedule.signature;
    let freedoms = signature.freedoms();
    let count = schedule.operations();
    let counts = [count.add, count.mul, count.div, count.sqrt, count.call, count.neg];
    let matrices = schedule.parts.iter().filter(|part| !part.is_list());
    let mut nonzero: Vec<(Part, Vec<Vec<u8>>)> = matrices
        .map(|part| {
            let (rows, columns) = part.shape(signature);
            (*part, vec![vec![b'.'; columns]; rows])
        })
        .collect();
    for statement in &schedule.statements {
        let (part, rows) = match statement {
            Statement::Store(output, _) => (output.part, output.row..output.row + 1),
            Statement::Scaled { part, row, .. } => (*part, *row..*row + 1),
            Statement::Negated { part, rows, .. } => (*part, rows.clone()),
            _ => continue,
        };
        let Some((_, matrix)) = nonzero.iter_mut().find(|(found, _)| *found == part) else { continue };
        for row in rows.clone() {
            match statement {
                Statement::Store(output, _) => matrix[row][output.column] = b'x',
                Statement::Negated { from, .. } => matrix[row] = matrix[from + row - rows.start].clone(),
                _ => matrix[row].fill(b'x'),
            }
        }
    }
    let bodies = signature.bodies.iter().map(|body| body.name.clone());
    let parameters = signature.given().map(|(_, parameter)| parameter.name.clone());
    let mut text = String::new();
    let mut constant = |summary: &str, declared: &str, value: &str| {
        let line = format!("    pub const {declared} = {value};");
        // A value of one line stands below where it does not fit beside.
        let fits = line.lines().next().is_some_and(|line| line.chars().count() <= WIDTH);
        let space = if fits { " " } else { "\n        " };
        text.push_str(&format!("\n    /// {summary}\n    pub const {declared} ={space}{value};\n"));
    };
    let mut names = |summary: &str, name: &str, items: &mut dyn Iterator<Item = String>| {
        let items: Vec<String> = items.map(|item| format!("{item:?}")).collect();
        let declared = format!("{name}: [&str; {}]", items.len());
        constant(summary, &declared, &list(&items, INDENT));
    };
    names("What the kernel computes.", "FORMULAS", &mut kernel.formulas.iter().cloned());
    names("The bodies, in argument order.", "BODIES", &mut bodies.into_iter());
    names("The parameters, in the order of the fields.", "PARAMETERS", &mut parameters.into_iter());
    let coordinates = signature.coordinate_names();
    names("The coordinates, in the order of `force`.", "COORDINATES", &mut coordinates.into_iter());
    for (part, rows) in nonzero {
        let summary = format!("Rows of `{part}`; `.` where an entry is always zero.");
        let mut rows = rows.into_iter().map(|row| String::from_utf8_lossy(&row).into_owned());
        names(&summary, &format!("{}_NONZERO", part.name().to_ascii_uppercase()), &mut rows);
    }
    for table in kernel.packing.iter().flat_map(|packing| &packing.tables) {
        let summary = format!(
            "Where the entries of `{0}` stand: k > 0 is `entries[k - 1]`, k < 0 is `-entries[-k - 1]`, 0 is zero.",
            table.part
        );
        let text = |row: &[i32]| row.iter().map(i32::to_string).collect::<Vec<String>>();
        let (count, columns) = (table.entries.len() / table.columns.max(1), table.columns);
        let name = format!("{}_PLACES", table.part.name().to_ascii_uppercase());
        if table.part.is_list() {
            constant(&summary, &format!("{name}: [i32; {count}]"), &list(&text(&table.entries), INDENT));
        } else {
            let inner = format!("{INDENT}    ");
            let rows: Vec<String> = table.rows().map(|row| list(&text(row), &inner)).collect();
            constant(&summary, &format!("{name}: [[i32; {columns}]; {count}]"), &list(&rows, INDENT));
        }
    }
    constant("The name of the force function.", "NAME: &str", &format!("{:?}", kernel.name));
    constant("Degrees of freedom: the length of `force`.", "FREEDOMS: usize", &freedoms.to_string());
    let counts: Vec<String> = counts.iter().map(ToString::to_string).collect();
    constant(
        "Additions, multiplications, divisions, square roots, calls and negations.",
        "OPERATIONS: [usize; 6]",
        &list(&counts, INDENT),
    );
    text
}

/// An array as rustfmt would set it as the value of a constant or a variable.
fn list(items: &[String], indent: &str) -> String {
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
            // A space follows every item but the last.
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

/// The name of a kernel's module.
pub fn module_name(kernel: &Kernel, precision: Precision) -> String {
    let suffix = if precision == Precision::F32 { "_f32" } else { "" };
    kernel_name(&kernel.name, Target::Rust, suffix)
}

fn documentation(kernel: &Kernel, precision: Precision) -> String {
    let mut lines: Vec<String> = kernel.docs.clone();
    if !lines.is_empty() {
        lines.push(String::new());
    }
    lines.push("```text".to_owned());
    lines.extend(kernel.summary());
    lines.extend(rounding(kernel, precision).lines());
    lines.push("```".to_owned());
    lines.iter().map(|line| format!("{}\n", format!("/// {line}").trim_end())).collect()
}

fn imports(signature: &Signature, precision: Precision, lanes: usize) -> String {
    let mut names: Vec<String> = Vec::new();
    for kind in kinds(std::iter::once(signature)) {
        let (name, own) = (kind.row().name, rust_body(kind.row(), precision, lanes));
        names.push(if own == name { own } else { format!("{own} as {name}") });
    }
    names.sort();
    match names.as_slice() {
        [] => String::new(),
        [single] => format!("    use super::{single};\n"),
        several => format!("    use super::{{{}}};\n", several.join(", ")),
    }
}

/// A documented struct; `derives` says whether the standard library knows the default of its arrays.
fn structure(
    name: &str,
    summary: &str,
    fields: Vec<(String, String, String)>,
    derives: bool,
    indent: &str,
) -> String {
    let default = if derives { ", Default" } else { "" };
    let mut lines = vec![
        format!("/// {}", sentence(summary)),
        "#[repr(C)]".to_owned(),
        format!("#[derive(Clone, Copy, Debug{default}, PartialEq)]"),
        format!("pub struct {name} {{"),
    ];
    for (field, ty, summary) in &fields {
        lines.push(format!("    /// {}", sentence(summary)));
        lines.push(format!("    pub {field}: {ty},"));
    }
    lines.push("}".to_owned());
    if !derives {
        lines.extend(["", &format!("impl Default for {name} {{")].map(str::to_owned));
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

/// A number of each of so many instances.
fn number(precision: Precision, lanes: usize) -> String {
    if lanes > 1 { format!("[{precision}; {lanes}]") } else { precision.to_string() }
}

fn array(ty: &ParameterType, precision: Precision, lanes: usize) -> String {
    ty.extents().iter().rev().fold(number(precision, lanes), |inner, n| format!("[{inner}; {n}]"))
}

/// The declaration of an extra argument; a lone one is the same for all instances.
fn extra_argument(extra: &Parameter, name: &str, lanes: usize, precision: Precision) -> String {
    let (borrowed, lanes) = if extra.ty == ParameterType::Real { ("", 1) } else { ("&", lanes) };
    format!("{name}: {borrowed}{}", array(&extra.ty, precision, lanes))
}

fn evaluate_head(kernel: &Kernel, precision: Precision) -> String {
    let signature = &kernel.schedule.signature;
    let reads = reads(&kernel.schedule, &kernel.schedule.statements);
    let unused = |read: bool| if read { "" } else { "_" };
    let mut arguments: Vec<String> = Vec::new();
    let names = Arguments::new(signature, Target::Rust);
    for ((body, name), read) in signature.bodies.iter().zip(names.bodies).zip(reads.bodies) {
        arguments.push(format!("{}{name}: &{}", unused(read), body.kind.row().name));
    }
    if signature.has_given() {
        arguments.push(format!("{}params: &Params", unused(reads.parameters)));
    }
    for (index, extra) in signature.given_extras() {
        let declared = extra_argument(extra, &names.extras[index], kernel.lanes, precision);
        arguments.push(format!("{}{declared}", unused(reads.extras[index])));
    }
    arguments.push("out: &mut Output".to_owned());
    head("pub fn evaluate", &arguments)
}

/// The head of a function of a module.
fn head(name: &str, arguments: &[String]) -> String {
    let line = format!("    {name}({}) {{", arguments.join(", "));
    if line.len() <= WIDTH {
        return format!("{line}\n");
    }
    let arguments: String = arguments.iter().map(|argument| format!("        {argument},\n")).collect();
    format!("    {name}(\n{arguments}    ) {{\n")
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
    let write = |text: &mut String, (statements, result): &Way, indent: usize, end: [&str; 2]| {
        let dialect = Rust::new(&empty, precision, indent, 1);
        let space = " ".repeat(indent);
        for statement in statements {
            for line in print::statement(&dialect, &routine.variables, statement) {
                text.push_str(&format!("{space}{line}\n"));
            }
        }
        let result = print::expression(&dialect, &routine.variables, result);
        text.push_str(&format!("{space}{}{result}{}\n", end[0], end[1]));
    };
    if let Some((condition, near)) = &routine.near {
        let dialect = Rust::new(&empty, precision, 8, 1);
        let condition = print::expression(&dialect, &routine.variables, condition);
        text.push_str(&format!("        if {condition} {{\n"));
        write(&mut text, near, 12, ["return ", ";"]);
        text.push_str("        }\n");
    }
    write(&mut text, &routine.far, 8, ["", ""]);
    text.push_str("    }\n");
    text
}

/// The constants of the standard library.
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

/// Further numbers that clippy wants written as constants.
const FURTHER: [f64; 2] = [1.618_033_988_749_895, 0.577_215_664_901_532_9];

/// A positive number. One that clippy would take for a constant is that constant, or else its bits.
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

/// How Rust spells statements, as rustfmt would set them at this indentation.
struct Rust<'a> {
    signature: &'a Signature,
    names: Arguments,
    precision: Precision,
    indent: usize,
    lanes: usize,
}

impl Rust<'_> {
    fn new(signature: &Signature, precision: Precision, indent: usize, lanes: usize) -> Rust<'_> {
        Rust { signature, names: Arguments::new(signature, Target::Rust), precision, indent, lanes }
    }

    fn place(&self, output: Output) -> String {
        let (Output { part, row, column }, lane) = (output, lane(self.lanes));
        if part.is_list() {
            format!("out.{part}[{row}]{lane}")
        } else {
            format!("out.{part}[{row}][{column}]{lane}")
        }
    }

    fn assign(&self, left: &str, value: &str) -> Vec<String> {
        /// rustfmt's `fn_call_width`.
        const CALL: usize = 60;
        let call = format!("{}::mul_add(", self.precision);
        let arguments = value.strip_prefix(&call).and_then(|rest| rest.strip_suffix(')'));
        // Names and signs alone, so that what stands between commas is an argument.
        let plain = |arguments: &&str| !arguments.contains('(') && arguments.len() > CALL;
        if let Some(arguments) = arguments.filter(plain) {
            let mut lines = vec![format!("{left} = {call}")];
            lines.extend(arguments.split(", ").map(|argument| format!("    {argument},")));
            lines.push(");".to_owned());
            return lines;
        }
        let line = format!("{left} = {value};");
        if self.indent + line.len() <= WIDTH {
            return vec![line];
        }
        vec![format!("{left} ="), format!("    {value};")]
    }

    fn choose(&self, left: &str, [c, x, y]: [&str; 3]) -> Vec<String> {
        /// rustfmt's `single_line_if_else_max_width`.
        const SINGLE_LINE: usize = 50;
        let value = format!("if {c} {{ {x} }} else {{ {y} }}");
        if value.len() <= SINGLE_LINE {
            return self.assign(left, &value);
        }
        vec![
            format!("{left} = if {c} {{"),
            format!("    {x}"),
            "} else {".to_owned(),
            format!("    {y}"),
            "};".to_owned(),
        ]
    }

    /// The same runs of columns in each of some rows become zero.
    fn zeros(&self, part: Part, rows: &Range<usize>, columns: &[Range<usize>]) -> Vec<String> {
        let (height, width) = part.shape(self.signature);
        let zero = if self.lanes > 1 { format!("[0.0; {}]", self.lanes) } else { "0.0".to_owned() };
        // An entry, some entries or all entries of a place of so many reals become zero.
        let fill = |place: &str, whole: &str, count: usize, range: &Range<usize>| match range.len() {
            length if length == count && count > 1 => format!("{whole} = [{zero}; {count}];"),
            1 => format!("{place}[{}] = {zero};", range.start),
            _ => format!("{place}[{}..{}].fill({zero});", range.start, range.end),
        };
        let name = part.name();
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
    fn literal(&self, value: &Exact) -> String {
        let size = positive(&value.abs(), self.precision);
        if value.is_negative() { format!("-{size}") } else { size }
    }

    fn receiver(&self, value: &Exact) -> String {
        let text = self.literal(value);
        if text.contains("::") { text } else { format!("{text}_{}", self.precision) }
    }

    fn fused(&self) -> String {
        super::spelled("{p}::mul_add({0}, {1}, {2})", self.precision)
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

    fn define(&self, variable: &Variable, value: &str) -> Vec<String> {
        self.assign(&format!("let {}", variable.name), value)
    }

    fn store(&self, output: Output, value: &str) -> Vec<String> {
        self.assign(&self.place(output), value)
    }

    fn define_select(&self, variable: &Variable, select: [&str; 3]) -> Vec<String> {
        self.choose(&format!("let {}", variable.name), select)
    }

    fn store_select(&self, output: Output, select: [&str; 3]) -> Vec<String> {
        self.choose(&self.place(output), select)
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
        let (part, columns) = (part.name(), &columns.name);
        vec![format!("out.{part}[{row}] = {columns}.map(|column| {factor} * column);")]
    }

    fn negated(&self, part: Part, rows: &Range<usize>, from: usize) -> Vec<String> {
        let part = part.name();
        let pairs = rows.clone().zip(from..);
        pairs.map(|(row, other)| format!("out.{part}[{row}] = out.{part}[{other}].map(|x| -x);")).collect()
    }

    fn leave(&self, condition: &str) -> Vec<String> {
        let lines = ["    *out = Output::default();", "    return;", "}"];
        std::iter::once(format!("if {condition} {{")).chain(lines.map(str::to_owned)).collect()
    }

    fn remark(&self, text: &str) -> Vec<String> {
        vec![format!("// {text}")]
    }
}
