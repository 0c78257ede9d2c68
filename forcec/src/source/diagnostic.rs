//! Errors and warnings: values with a source position, rendered once, just before output.
//!
//! In: a message, a span, a label for the span and a help text. Out: text in the format of rustc.

use crate::source::span::{Source, Span};
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::fmt;

/// The severity of a diagnostic.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Severity {
    /// The input cannot be compiled.
    Error,
    /// The input compiles, but the position deserves attention.
    Warning,
}

/// The kinds of warnings.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Lint {
    /// A value or a derivative may not exist.
    Singular,
    /// A name is never read, or a value is never used.
    Unused,
    /// A parameter is set to a value outside its domain.
    OutsideDomain,
    /// A constraint deviates from its first-order expansion near its zero set.
    Nonlinear,
    /// A force depends on velocities and can add energy.
    EnergyGain,
    /// Damping reduces the largest stable step.
    DampedStep,
    /// A Gauss–Newton stiffness reduces the largest stable step.
    GaussNewton,
    /// A check has no state in one arm of a branch.
    Uncovered,
    /// An attribute allows lints without a reason.
    MissingReason,
}

impl Lint {
    /// The lints that `#[allow(…, reason = "…")]` accepts.
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

    /// The name in messages and attributes.
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

    /// The lint with this name, if an attribute can allow it.
    pub fn named(name: &str) -> Option<Lint> {
        Lint::ALLOWED.into_iter().find(|lint| lint.name() == name)
    }

    /// Whether rustc also has a lint with this name.
    pub fn is_shared(self) -> bool {
        self == Lint::Unused
    }
}

/// An error or a warning at one position.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// One lower-case sentence, source words in backticks.
    pub message: String,
    /// The position; `None` for the file as a whole.
    pub span: Option<Span>,
    /// The label at the position.
    pub label: String,
    /// What to write instead.
    pub help: Option<String>,
    /// The kind of the warning, if it has one.
    pub lint: Option<Lint>,
    /// How often the diagnostic occurs: in iterations of a loop, or in calls of a helper.
    pub times: usize,
}

impl Diagnostic {
    /// An error at a position; the label describes the code there.
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

    /// A warning at a position.
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

    /// Adds a help text on what to write instead.
    pub fn help(mut self, help: impl Into<String>) -> Diagnostic {
        self.help = Some(help.into());
        self
    }

    /// Sets the kind of a warning.
    pub fn lint(mut self, lint: Lint) -> Diagnostic {
        self.lint = Some(lint);
        self
    }

    /// The label with the number of occurrences.
    pub fn whole_label(&self) -> String {
        match self.times {
            1 => self.label.clone(),
            times => format!("{} ({times} times)", self.label),
        }
    }
}

/// All diagnostics of one stage about one source text.
#[derive(Clone, Debug)]
pub struct Diagnostics {
    /// The source text that the spans refer to.
    pub source: Source,
    /// The diagnostics, in source order.
    pub list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// Sorts diagnostics by position and merges equal ones; a merged warning counts its occurrences.
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

    /// Whether the list contains an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// Renders all diagnostics, with or without terminal colours.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        // Diagnostics are in source order: lines are counted once, and each diagnostic gets its own lines.
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

    /// A diagnostic with its lines; the first line starts at byte `start` and has number `line`.
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
