//! Errors and warnings: values with a place, rendered once, at the edge of the program.
//!
//! In: a message, a span, what is true there and what to write instead. Out: the text rustc users know.

use crate::source::span::{Source, Span};
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

/// The kinds of warnings.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Lint {
    /// A value, or a derivative, may not exist.
    Singular,
    /// Nothing reads a name, or uses a value.
    Unused,
    /// A parameter is set to a value outside of its domain.
    OutsideDomain,
    /// A constraint leaves its first-order expansion near where it is satisfied.
    Nonlinear,
    /// Velocities let a force bring in energy.
    EnergyGain,
    /// Damping shortens the largest stable step.
    DampedStep,
    /// A Gauss–Newton stiffness shortens the largest stable step.
    GaussNewton,
    /// An arm of a branch at which no state of a check is.
    Uncovered,
    /// An attribute allows warnings and does not say why.
    MissingReason,
}

impl Lint {
    /// Those that `#[allow(…, reason = "…")]` answers.
    pub const ALLOWED: [Lint; 8] = [
        Lint::Singular,
        Lint::Unused,
        Lint::OutsideDomain,
        Lint::Nonlinear,
        Lint::EnergyGain,
        Lint::DampedStep,
        Lint::GaussNewton,
        Lint::Uncovered,
    ];

    /// Its name in messages and attributes.
    pub fn name(self) -> &'static str {
        match self {
            Lint::Singular => "singular",
            Lint::Unused => "unused",
            Lint::OutsideDomain => "outside_domain",
            Lint::Nonlinear => "nonlinear",
            Lint::EnergyGain => "energy_gain",
            Lint::DampedStep => "damped_step",
            Lint::GaussNewton => "gauss_newton",
            Lint::Uncovered => "uncovered",
            Lint::MissingReason => "missing_reason",
        }
    }

    /// The lint of this name that can be allowed.
    pub fn named(name: &str) -> Option<Lint> {
        Lint::ALLOWED.into_iter().find(|lint| lint.name() == name)
    }

    /// Whether rustc has a lint of this name too.
    pub fn is_shared(self) -> bool {
        self == Lint::Unused
    }
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
    /// What kind of warning it is.
    pub lint: Option<Lint>,
    /// How many times it was met: in the passes of a loop, by the callers of a helper.
    pub times: usize,
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
            lint: None,
            times: 1,
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
            lint: None,
            times: 1,
        }
    }

    /// The same message with a hint on what to write.
    pub fn help(mut self, help: impl Into<String>) -> Diagnostic {
        self.help = Some(help.into());
        self
    }

    /// The same warning as one of a kind.
    pub fn lint(mut self, lint: Lint) -> Diagnostic {
        self.lint = Some(lint);
        self
    }

    /// What is true at its place, and how often it was met.
    fn whole_label(&self) -> String {
        match self.times {
            1 => self.label.clone(),
            times => format!("{} ({times} times)", self.label),
        }
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
    /// The messages sorted by place, each once; of a warning how many times it was met is told.
    pub fn new(source: Source, mut list: Vec<Diagnostic>) -> Diagnostics {
        let key = |d: &Diagnostic| (d.span.map(|s| (s.start, s.end)), d.severity, d.message.clone());
        list.sort_by_cached_key(|d| (key(d), d.label.clone(), d.help.clone()));
        list.dedup_by(|next, kept| {
            let same = key(next) == key(kept) && (&next.label, &next.help) == (&kept.label, &kept.help);
            if same && kept.severity == Severity::Warning {
                kept.times += next.times;
            }
            same
        });
        Diagnostics { source, list }
    }

    /// Whether any of them is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// The rendered text, with terminal colours or without.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        // Messages are in the order of their places: lines are counted once, and each message sees its own alone.
        let (mut counted, mut line) = (0, 1);
        let reports = self.list.iter().map(|diagnostic| {
            let text = self.source.text.as_bytes();
            let start = diagnostic.span.map_or(0, |span| (span.start as usize).min(text.len()));
            let start = text[..start].iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
            if start < counted {
                (counted, line) = (0, 1);
            }
            line += text[counted..start].iter().filter(|byte| **byte == b'\n').count();
            counted = start;
            renderer.render(&self.report(diagnostic, start, line))
        });
        reports.collect::<Vec<String>>().join("\n\n")
    }

    /// A message with the lines it is about, of which the first starts at this byte and has this number.
    fn report<'a>(&'a self, diagnostic: &'a Diagnostic, start: usize, line: usize) -> Vec<Group<'a>> {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let title = level.primary_title(diagnostic.message.as_str());
        let title = match diagnostic.lint {
            Some(lint) => title.id(lint.name()),
            None => title,
        };
        let mut group = match diagnostic.span {
            Some(span) => {
                let text = self.source.text.as_str();
                let range = (span.start as usize).min(text.len())..(span.end as usize).min(text.len());
                let end = text.as_bytes()[range.end..].iter().position(|byte| *byte == b'\n');
                let end = end.map_or(text.len(), |length| range.end + length);
                let range = range.start - start..range.end - start;
                let annotation = AnnotationKind::Primary.span(range).label(diagnostic.whole_label());
                let snippet = Snippet::source(&text[start..end])
                    .line_start(line)
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
