//! Long kernels in Rust: the functions that they are written in, and the struct through which these hand on values.
//!
//! In: a kernel and its sections. Out: text that stands before `evaluate`, and how that calls it.

use crate::kernel::Kernel;
use crate::schedule::split::Section;
use crate::targets::rust::{Rust, extra_argument, head};
use crate::targets::{body, reads};

pub(super) fn part_name(index: usize, section: &Section) -> String {
    format!("{}_{}", section.part, index + 1)
}

/// An argument of a part of a long kernel: as it is declared, and as it is passed.
pub(super) struct Argument {
    pub(super) declared: String,
    pub(super) passed: String,
}

/// The arguments that a part needs.
pub(super) fn arguments(kernel: &Kernel, section: &Section, dialect: &Rust) -> Vec<Argument> {
    let schedule = &kernel.schedule;
    let argument = |declared: String, passed: &str| Argument { declared, passed: passed.to_owned() };
    let signature = &schedule.signature;
    let reads = reads(schedule, section.written(schedule));
    let bodies =
        signature.bodies.iter().zip(&dialect.names.bodies).zip(reads.bodies).filter(|(_, read)| *read);
    let bodies = bodies.map(|((body, name), _)| argument(format!("{name}: &{}", body.kind.row().name), name));
    let mut arguments: Vec<Argument> = bodies.collect();
    if reads.parameters {
        arguments.push(argument("params: &Params".to_owned(), "params"));
    }
    for (index, extra) in signature.given_extras().filter(|(index, _)| reads.extras[*index]) {
        let name = &dialect.names.extras[index];
        arguments.push(argument(extra_argument(extra, name, kernel.lanes, dialect.precision), name));
    }
    if section.shares() {
        let change = if section.hands_on.is_empty() { "" } else { "mut " };
        arguments.push(argument(format!("shared: &{change}Shared"), &format!("&{change}shared")));
    }
    if section.stores {
        arguments.push(argument("out: &mut Output".to_owned(), "out"));
    }
    arguments
}

/// What stands before a long kernel: the struct of the values that its parts hand on, and the parts.
pub(super) fn parts(kernel: &Kernel, sections: &[Section], dialect: &Rust) -> String {
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
        let declared = arguments(kernel, section, dialect).into_iter().map(|argument| argument.declared);
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
