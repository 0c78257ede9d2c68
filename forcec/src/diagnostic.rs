//! Errors and warnings: values with a place, rendered once, at the edge of the program.
//!
//! In: a message, a span, what is true there and what to write instead. Out: the text rustc users know.

use crate::span::{Source, Span};
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::fmt;

/// How bad it is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Severity {
    /// The input cannot be compiled.
    Error,
    /// The input compiles, but something at this place deserves a look.
    Warning,
}

/// One message at one place.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// One lower-case sentence, source words in backticks.
    pub message: String,
    /// Where; `None` for the file as a whole.
    pub span: Option<Span>,
    /// What is true at that place.
    pub label: String,
    /// What to write instead.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error at a place; the label says what is true there.
    pub fn error(span: Span, message: impl Into<String>, label: impl Into<String>) -> Diagnostic {
        Diagnostic {
            severity: Severity::Error,
            message: message.into(),
            span: Some(span),
            label: label.into(),
            help: None,
        }
    }

    /// A warning at a place.
    pub fn warning(span: Span, message: impl Into<String>, label: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(span, message, label) }
    }

    /// An error about a file as a whole.
    pub fn file(message: impl Into<String>) -> Diagnostic {
        Diagnostic {
            severity: Severity::Error,
            message: message.into(),
            span: None,
            label: String::new(),
            help: None,
        }
    }

    /// The same message with a hint on what to write.
    pub fn help(mut self, help: impl Into<String>) -> Diagnostic {
        self.help = Some(help.into());
        self
    }
}

/// Everything one stage has to say about one source text.
#[derive(Clone, Debug)]
pub struct Diagnostics {
    /// The text the spans point into.
    pub source: Source,
    /// The messages, in the order of their places.
    pub list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// The messages sorted by place, each once.
    pub fn new(source: Source, mut list: Vec<Diagnostic>) -> Diagnostics {
        list.sort_by_key(|d| (d.span.map(|s| (s.start, s.end)), d.severity, d.message.clone()));
        list.dedup();
        Diagnostics { source, list }
    }

    /// Whether any of them is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// The rendered text, with terminal colours or without.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let reports: Vec<String> = self.list.iter().map(|d| renderer.render(&self.report(d))).collect();
        reports.join("\n\n")
    }

    fn report<'a>(&'a self, diagnostic: &'a Diagnostic) -> Vec<Group<'a>> {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let title = level.primary_title(diagnostic.message.as_str());
        let mut group = match diagnostic.span {
            Some(span) => {
                let length = self.source.text.len();
                let range = (span.start as usize).min(length)..(span.end as usize).min(length);
                let annotation = AnnotationKind::Primary.span(range).label(diagnostic.label.as_str());
                let snippet = Snippet::source(self.source.text.as_str())
                    .path(self.source.name.as_str())
                    .annotation(annotation);
                title.element(snippet)
            }
            None => title.element(annotate_snippets::Origin::path(self.source.name.as_str())),
        };
        if let Some(help) = &diagnostic.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        vec![group]
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostics {}
