//! The functions and constants of a file by name, and the types of functions.

use crate::check::types::Type;
use crate::model::bodies::BodyKind;
use crate::names::{Target, defined_for};
use crate::source::diagnostic::Diagnostic;
use crate::source::span::Span;
use crate::syntax::ast::{Constant, File, Function, FunctionKind, Name};
use std::collections::BTreeMap;

/// The definitions of a file.
pub(crate) struct Program<'a> {
    /// The source text, for messages that quote it.
    text: &'a str,
    pub(crate) functions: &'a [Function],
    pub(crate) constants: &'a [Constant],
    /// Names of the `#[forces]` modules of the file.
    pub(crate) modules: &'a [String],
    function_names: BTreeMap<&'a str, usize>,
    constant_names: BTreeMap<&'a str, usize>,
    /// The types of every function; empty until they are resolved.
    pub(crate) signatures: Vec<FunctionType>,
}

/// The types of arguments and result.
#[derive(Clone, Debug)]
pub(crate) struct FunctionType {
    pub(crate) arguments: Vec<Type>,
    pub(crate) output: Type,
}

/// The name of the built-in constant π.
pub(crate) const PI: &str = "PI";

impl<'a> Program<'a> {
    /// The tables of a file; of two items with the same name, the first is used.
    pub(crate) fn new(file: &'a File, diagnostics: &mut Vec<Diagnostic>) -> Program<'a> {
        let mut program = Program {
            text: &file.source.text,
            functions: &file.functions,
            constants: &file.constants,
            modules: &file.modules,
            function_names: BTreeMap::new(),
            constant_names: BTreeMap::new(),
            signatures: Vec::new(),
        };
        let mut names: BTreeMap<&str, &Name> = BTreeMap::new();
        let mut define = |name: &'a Name, what: &str| {
            if let Some(kind) = built_in(&name.text) {
                diagnostics.push(
                    Diagnostic::error(
                        name.span,
                        format!("`{}` is built in", name.text),
                        format!("{kind} has this name already"),
                    )
                    .help("choose another name"),
                );
            } else if let Some(first) = names.insert(&name.text, name) {
                diagnostics.push(
                    Diagnostic::error(
                        name.span,
                        format!("`{}` is defined twice", name.text),
                        format!("the {what} that comes second"),
                    )
                    .help("choose another name"),
                );
                names.insert(&name.text, first);
            } else {
                return true;
            }
            false
        };
        for (index, function) in file.functions.iter().enumerate() {
            if define(&function.name, "function") {
                program.function_names.insert(&function.name.text, index);
            }
        }
        for (index, constant) in file.constants.iter().enumerate() {
            if define(&constant.name, "constant") {
                program.constant_names.insert(&constant.name.text, index);
            }
        }
        meetings(&file.functions, diagnostics);
        program
    }

    /// The source text of a span, if it is a numeric literal.
    pub(crate) fn literal(&self, span: Span) -> Option<&'a str> {
        let text = self.text.get(span.start as usize..span.end as usize)?;
        let digits = text.starts_with(|c: char| c.is_ascii_digit());
        (digits && text.chars().all(|c| c.is_ascii_digit() || matches!(c, '.' | '_'))).then_some(text)
    }

    pub(crate) fn function(&self, name: &str) -> Option<usize> {
        self.function_names.get(name).copied()
    }

    pub(crate) fn constant(&self, name: &str) -> Option<usize> {
        self.constant_names.get(name).copied()
    }

    /// Names of all functions, for suggestions.
    pub(crate) fn callable(&self) -> impl Iterator<Item = &'a str> {
        self.function_names.keys().copied()
    }

    /// The names of constants, for suggestions.
    pub(crate) fn constant_names(&self) -> impl Iterator<Item = &'a str> {
        self.constant_names.keys().copied().chain([PI])
    }
}

/// Reports kernels that define an item of an earlier kernel again.
fn meetings(functions: &[Function], diagnostics: &mut Vec<Diagnostic>) {
    let mut defined: BTreeMap<(Target, String), &str> = BTreeMap::new();
    for kernel in functions.iter().filter(|function| function.kind != FunctionKind::Helper) {
        let name = kernel.name.text.as_str();
        let mut meets = None;
        for item in defined_for(name, &[]) {
            let first = *defined.entry(item.clone()).or_insert(name);
            meets = meets.or((first != name).then_some((first, item.1)));
        }
        let Some((first, item)) = meets else { continue };
        diagnostics.push(
            Diagnostic::error(
                kernel.name.span,
                format!("kernels of `{name}` and `{first}` would have the same name"),
                format!("both define `{item}`"),
            )
            .help("choose another name"),
        );
    }
}

/// The kind of a built-in with this name.
fn built_in(name: &str) -> Option<&'static str> {
    if BodyKind::named(name).is_some() {
        return Some("a body type");
    }
    if Type::named(name).is_some() {
        return Some("a type");
    }
    if name.starts_with("forcec_") {
        return Some("what is in `forcec.h`");
    }
    (name == PI).then_some("a constant")
}
