//! State and helpers for the readers of items, types, statements and expressions: positions, names, errors.

use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::span::Span;
use crate::syntax::ast::{Constant, Function, Name, Path};

/// Converts syn's tree to the syntax tree and collects errors.
pub(super) struct Reader<'a> {
    locate: Box<dyn FnMut(proc_macro2::Span) -> Span + 'a>,
    pub(super) diagnostics: Vec<Diagnostic>,
    /// The `//!` comment of the file.
    pub(super) docs: Vec<String>,
    pub(super) functions: Vec<Function>,
    pub(super) constants: Vec<Constant>,
    /// Names of the `#[forces]` modules.
    pub(super) modules: Vec<String>,
    /// The options that the attribute of the enclosing module states.
    pub(super) module_options: Vec<crate::syntax::ast::Stated>,
    /// The lints that attributes of the file and of the enclosing module allow.
    pub(super) allowed: Vec<Lint>,
    /// Lints that an attribute allows without a reason, with positions.
    pub(super) unexplained: Vec<(Lint, Span)>,
    /// The arena of the function being read.
    pub(super) expressions: crate::syntax::ast::Expressions,
}

impl<'a> Reader<'a> {
    pub(super) fn new(locate: impl FnMut(proc_macro2::Span) -> Span + 'a) -> Reader<'a> {
        Reader {
            locate: Box::new(locate),
            diagnostics: Vec::new(),
            docs: Vec::new(),
            functions: Vec::new(),
            constants: Vec::new(),
            modules: Vec::new(),
            module_options: Vec::new(),
            allowed: Vec::new(),
            unexplained: Vec::new(),
            expressions: Default::default(),
        }
    }

    /// Converts the span of a token; all spans are converted here.
    pub(super) fn at(&mut self, span: proc_macro2::Span) -> Span {
        (self.locate)(span)
    }

    /// The span from the opening to the closing bracket.
    pub(super) fn between(&mut self, delimiters: proc_macro2::extra::DelimSpan) -> Span {
        let open = self.at(delimiters.open());
        open.to(self.at(delimiters.close()))
    }

    pub(super) fn error(&mut self, span: Span, message: impl Into<String>, label: impl Into<String>) {
        self.diagnostics.push(Diagnostic::error(span, message, label));
    }

    pub(super) fn error_help(
        &mut self,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.diagnostics.push(Diagnostic::error(span, message, label).help(help));
    }

    /// An identifier, which must also be valid in C.
    pub(super) fn name(&mut self, ident: &syn::Ident) -> Name {
        let span = self.at(ident.span());
        let text = ident.to_string();
        if let Some(bare) = text.strip_prefix("r#") {
            self.error_help(
                span,
                format!("`{text}` is a raw identifier"),
                "kernels have no way to write this name",
                format!("call it `{bare}_`"),
            );
        } else if !text.is_ascii() {
            self.error_help(
                span,
                format!("`{text}` is not an ASCII identifier"),
                "C has no such names",
                "use the letters a to z, digits and `_`",
            );
        }
        Name { text, span }
    }

    /// A path without generic arguments.
    pub(super) fn path(&mut self, path: &syn::Path) -> Path {
        let mut segments = Vec::new();
        let mut span: Option<Span> = None;
        for segment in &path.segments {
            let name = self.name(&segment.ident);
            span = Some(span.map_or(name.span, |span| span.to(name.span)));
            segments.push(name.text);
            let arguments = match &segment.arguments {
                syn::PathArguments::None => continue,
                syn::PathArguments::AngleBracketed(arguments) => {
                    let open = self.at(arguments.lt_token.spans[0]);
                    open.to(self.at(arguments.gt_token.spans[0]))
                }
                syn::PathArguments::Parenthesized(arguments) => self.between(arguments.paren_token.span),
            };
            self.error_help(
                arguments,
                "generic arguments are not part of the force language",
                "every type is known here",
                "leave them out",
            );
        }
        let span = span.unwrap_or_default();
        if segments.is_empty() {
            segments.push(String::new());
        }
        Path { segments, span }
    }
}
