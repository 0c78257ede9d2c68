//! Attributes: kinds of functions, domains of parameters, and allowed lints; other attributes are for rustc.

use crate::source::diagnostic::Lint;
use crate::source::span::Span;
use crate::source::suggest;
use crate::syntax::ast::{self, DomainClause, FunctionKind, StatedDomain};
use crate::syntax::reader::Reader;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, Meta, Token};

/// Attributes of the force language.
const OURS: [&str; 4] = ["constraint", "energy", "force", "domain"];

/// The name of the length scale of all bodies in `#[domain(…)]`.
const LENGTH: &str = "length";

/// Attributes of rustc and its tools that have no effect on kernels.
const PASSED_OVER: [&str; 10] = [
    "inline",
    "cold",
    "must_use",
    "doc",
    "deprecated",
    "rustfmt",
    "clippy",
    "track_caller",
    "forces",
    "diagnostic",
];

/// The content of an item's attributes.
#[derive(Default)]
pub(super) struct Stated {
    pub(super) docs: Vec<String>,
    pub(super) kind: Option<(FunctionKind, Span)>,
    pub(super) options: Vec<ast::Stated>,
    pub(super) domains: Vec<DomainClause>,
    /// Allowed lints.
    pub(super) allowed: Vec<Lint>,
    /// Position of a `#[domain]`.
    pub(super) domain: Option<Span>,
    /// Whether a module has `#[forces]`.
    pub(super) forces: bool,
}

/// `name = value` or `body.field = value` within `#[domain(…)]`.
struct Clause {
    name: syn::Ident,
    field: Option<syn::Ident>,
    value: syn::Expr,
}

impl Parse for Clause {
    fn parse(input: ParseStream<'_>) -> syn::Result<Clause> {
        let name = input.parse()?;
        let point: Option<Token![.]> = input.parse()?;
        let field = if point.is_some() { Some(input.parse()?) } else { None };
        input.parse::<Token![=]>()?;
        Ok(Clause { name, field, value: input.parse()? })
    }
}

impl Reader<'_> {
    pub(super) fn attributes(&mut self, attributes: &[Attribute]) -> Stated {
        let mut stated = Stated::default();
        for attribute in attributes {
            let segments: Vec<String> =
                attribute.path().segments.iter().map(|segment| segment.ident.to_string()).collect();
            let ours = match segments.as_slice() {
                [name] => name.as_str(),
                [place, name] if place.starts_with("forcec") => name.as_str(),
                [place, ..] if PASSED_OVER.contains(&place.as_str()) => continue,
                _ => continue,
            };
            let hash = self.at(attribute.pound_token.span);
            let span = hash.to(self.between(attribute.bracket_token.span));
            match ours {
                "doc" => document(attribute, &mut stated.docs),
                "forces" => {
                    stated.forces = true;
                    self.options(attribute, ours, span, &[], &mut stated);
                }
                "constraint" | "energy" | "force" => self.kind(attribute, ours, span, &mut stated),
                "domain" => {
                    stated.domain.get_or_insert(span);
                    self.domain(attribute, span, &mut stated);
                }
                "cfg" | "cfg_attr" => self.error_help(
                    span,
                    "conditional compilation is not part of the force language",
                    "the compiler does not know the configuration of your crate",
                    "put what differs into a file of its own",
                ),
                "allow" | "expect" | "warn" | "deny" | "forbid" => self.level(attribute, ours, &mut stated),
                _ if PASSED_OVER.contains(&ours) => {}
                _ => {
                    if let Some(nearest) = suggest::nearest(ours, OURS) {
                        self.error_help(
                            span,
                            format!("unknown attribute `{ours}`"),
                            "nothing the compiler knows",
                            format!("did you mean `#[{nearest}]`?"),
                        );
                    }
                }
            }
        }
        stated
    }

    /// Reads `#[allow(singular, reason = "…")]`; lints of rustc are ignored.
    fn level(&mut self, attribute: &Attribute, level: &str, stated: &mut Stated) {
        let Ok(list) = attribute.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated) else {
            return;
        };
        let reasoned = list.iter().any(|meta| meta.path().is_ident("reason"));
        for ident in list.iter().filter_map(|meta| meta.path().get_ident()) {
            let (name, span) = (ident.to_string(), self.at(ident.span()));
            let lint = Lint::named(&name);
            match lint {
                Some(lint) if level == "allow" => {
                    stated.allowed.push(lint);
                    if !reasoned {
                        self.unexplained.push((lint, span));
                    }
                }
                Some(lint) if !lint.is_shared() => self.error_help(
                    span,
                    format!("`{name}` cannot be set to `{level}`"),
                    "a warning of forcec, not of rustc",
                    format!("write `#[allow({name}, reason = \"…\")]`, or deny warnings on the command line"),
                ),
                _ => {
                    let own = Lint::ALLOWED.into_iter().filter(|lint| !lint.is_shared());
                    let near = suggest::nearest(&name, own.map(Lint::name)).filter(|near| *near != name);
                    if let Some(near) = near {
                        let message = format!("unknown warning `{name}`");
                        let help = format!("did you mean `{near}`?");
                        self.error_help(span, message, "neither forcec nor rustc has it", help);
                    }
                }
            }
        }
    }

    fn kind(&mut self, attribute: &Attribute, name: &str, span: Span, stated: &mut Stated) {
        if let Some((before, _)) = stated.kind {
            self.error_help(
                span,
                "a function is one kind of force",
                format!("it is {} {before} already", if before == FunctionKind::Energy { "an" } else { "a" }),
                "keep one of the attributes",
            );
            return;
        }
        let flags: &[&str] = if name == "constraint" { &["unilateral", "per_row"] } else { &[] };
        let flags = self.options(attribute, name, span, flags, stated);
        let (unilateral, per_row) = (flags.contains(&"unilateral"), flags.contains(&"per_row"));
        let kind = match name {
            "constraint" => FunctionKind::Constraint { unilateral, per_row },
            "energy" => FunctionKind::Energy,
            _ => FunctionKind::Force,
        };
        stated.kind = Some((kind, span));
    }

    fn domain(&mut self, attribute: &Attribute, span: Span, stated: &mut Stated) {
        const HELP: &str = "write `#[domain(length = 0.1..2.0, axis = unit)]`";
        let clauses = match attribute.parse_args_with(Punctuated::<Clause, Token![,]>::parse_terminated) {
            Ok(clauses) => clauses,
            Err(error) => {
                let at = self.at(error.span());
                let at = if at == Span::default() { span } else { at };
                self.error_help(at, "a domain is malformed", error.to_string(), HELP);
                return;
            }
        };
        for clause in &clauses {
            let name = self.name(&clause.name);
            let field = clause.field.as_ref().map(|field| self.name(field));
            let (stated_domain, end) = match &clause.value {
                syn::Expr::Path(path) if path.path.is_ident("unit") => {
                    (StatedDomain::Unit, self.path(&path.path).span)
                }
                syn::Expr::Range(range) => {
                    let (Some(start), Some(end)) = (&range.start, &range.end) else {
                        let dots = match &range.limits {
                            syn::RangeLimits::HalfOpen(dots) => {
                                self.at(dots.spans[0]).to(self.at(dots.spans[1]))
                            }
                            syn::RangeLimits::Closed(dots) => {
                                self.at(dots.spans[0]).to(self.at(dots.spans[2]))
                            }
                        };
                        self.error_help(dots, "a domain has two ends", "one of them is missing", HELP);
                        continue;
                    };
                    let (start, end) = (self.expr(start), self.expr(end));
                    (StatedDomain::Range(start, end), self.expressions[end].span)
                }
                other if name.text == LENGTH && field.is_none() => {
                    let value = self.expr(other);
                    (StatedDomain::Scale(value), self.expressions[value].span)
                }
                other => {
                    let value = self.expr(other);
                    let at = self.expressions[value].span;
                    self.error_help(at, "a domain is a range or `unit`", "this is neither", HELP);
                    continue;
                }
            };
            let text = |field: &Option<ast::Name>| field.as_ref().map(|field| field.text.clone());
            let twice =
                |domain: &DomainClause| domain.name.text == name.text && text(&domain.field) == text(&field);
            if stated.domains.iter().any(twice) {
                let field = text(&field).map_or_else(String::new, |field| format!(".{field}"));
                self.error(
                    name.span,
                    format!("the domain of `{}{field}` is stated twice", name.text),
                    "the second time",
                );
                continue;
            }
            let span = name.span.to(end);
            stated.domains.push(DomainClause { name, field, stated: stated_domain, span });
        }
    }
}

/// Adds the lines of a doc comment, without the space after `///` and the asterisks of `/** … */`.
fn document(attribute: &Attribute, docs: &mut Vec<String>) {
    let Meta::NameValue(syn::MetaNameValue {
        value: syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }),
        ..
    }) = &attribute.meta
    else {
        return;
    };
    let text = text.value();
    if !text.contains('\n') {
        docs.push(text.strip_prefix(' ').unwrap_or(&text).trim_end().to_owned());
        return;
    }
    let lines = text.lines().map(|line| {
        let line = line.trim();
        line.strip_prefix("* ").or_else(|| line.strip_prefix('*')).unwrap_or(line).to_owned()
    });
    let lines: Vec<String> = lines.collect();
    let first = lines.iter().position(|line| !line.is_empty()).unwrap_or(0);
    let last = lines.iter().rposition(|line| !line.is_empty()).map_or(0, |last| last + 1);
    docs.extend_from_slice(lines.get(first..last).unwrap_or(&[]));
}
