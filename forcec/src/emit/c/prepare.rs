//! The C function that computes a kernel's prepared values.
//!
//! In: a kernel with prepared values. Out: a function that maps its parameters to the struct that every call
//! reads.

use crate::emit::body;
use crate::emit::c::dialect::C;
use crate::emit::c::{comment, named, star, wrapped};
use crate::kernel::{Kernel, Precision};
use crate::names::{Arguments, Target};

/// The function head.
pub(crate) fn head(kernel: &Kernel, precision: Precision, defines: bool) -> String {
    let star = star(kernel, defines);
    let arguments = [
        format!("const {} {star}params", named(kernel, "_params", precision)),
        format!("{} {star}prepared", named(kernel, "_prepared", precision)),
    ];
    wrapped(&format!("void {}(", named(kernel, "_prepare", precision)), &arguments, ")")
}

/// The function with its comment; empty for a kernel without prepared values.
pub(crate) fn definition(kernel: &Kernel, precision: Precision) -> String {
    let Some(once) = kernel.once() else { return String::new() };
    let schedule = &once.schedule;
    let signature = &schedule.signature;
    let mut dialect = C::new(signature, precision, kernel.lanes);
    let fields = Arguments::new(&kernel.schedule.signature, Target::C).parameters;
    let (kept, values) = fields.split_at(once.kept.len());
    dialect.prepared = values.to_vec();
    let remark = format!("Computes what {} reads at every call.", named(kernel, "", precision));
    let mut text = comment(&[remark], "");
    text.push_str(&format!("{}\n{{\n", head(kernel, precision, true)));
    for (field, parameter) in kept.iter().zip(&once.kept) {
        let extents = signature.parameters[*parameter].ty.extents();
        let mut extents: Vec<String> = extents.iter().map(u32::to_string).collect();
        extents.extend((!kernel.lanes.is_one()).then(|| kernel.lanes.to_string()));
        let source = &dialect.names.parameters[*parameter];
        if signature.parameters[*parameter].value.is_none() {
            copy(&extents, field, source)
                .into_iter()
                .for_each(|line| text.push_str(&format!("    {line}\n")));
        }
    }
    if !kernel.lanes.is_one() {
        text.push_str(&format!("    for (int lane = 0; lane < {}; lane++) {{\n", kernel.lanes));
        text.push_str(&body(&dialect, schedule, &schedule.statements, "        "));
        text.push_str("    }\n");
    } else {
        text.push_str(&body(&dialect, schedule, &schedule.statements, "    "));
    }
    text + "}\n\n"
}

/// Copies a parameter unchanged, entry by entry.
fn copy(extents: &[String], field: &str, source: &str) -> Vec<String> {
    let indices: Vec<String> = (0..extents.len()).map(|depth| format!("i{depth}")).collect();
    let place: String = indices.iter().map(|index| format!("[{index}]")).collect();
    let each = extents.iter().zip(&indices);
    let loops = each.map(|(extent, i)| format!("for (int {i} = 0; {i} < {extent}; {i}++)"));
    let mut lines: Vec<String> =
        loops.enumerate().map(|(depth, each)| format!("{}{each}", "    ".repeat(depth))).collect();
    let indent = "    ".repeat(extents.len());
    lines.push(format!("{indent}prepared->{field}{place} = params->{source}{place};"));
    lines
}
