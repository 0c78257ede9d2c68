//! Attributes: which function is a force, what its parameters may be, and what is left to rustc.

use super::ast::{DomainClause, FunctionKind, Precision, StatedDomain};
use super::reader::Reader;
use super::suggest;
use crate::plan::Mode;
use crate::span::Span;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, Meta, Token};

/// The attributes that are ours.
const OURS: [&str; 4] = ["constraint", "energy", "force", "domain"];

/// Attributes of rustc and its tools that change nothing here.
const PASSED_OVER: [&str; 15] = [
    "allow",
    "expect",
    "warn",
    "deny",
    "forbid",
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

/// What the attributes of an item say.
#[derive(Default)]
pub(super) struct Stated {
    pub(super) docs: Vec<String>,
    pub(super) kind: Option<(FunctionKind, Span)>,
    pub(super) precision: Option<Precision>,
    pub(super) mode: Option<Mode>,
    pub(super) fma: bool,
    pub(super) domains: Vec<DomainClause>,
    /// Where a `#[domain]` stands.
    pub(super) domain: Option<Span>,
    /// `#[forces]` on a module.
    pub(super) forces: bool,
}

/// `name = value` within `#[domain(…)]`.
struct Clause {
    name: syn::Ident,
    value: syn::Expr,
}

impl Parse for Clause {
    fn parse(input: ParseStream<'_>) -> syn::Result<Clause> {
        let name = input.parse()?;
        input.parse::<Token![=]>()?;
        Ok(Clause { name, value: input.parse()? })
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
                "forces" => stated.forces = true,
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

    fn kind(&mut self, attribute: &Attribute, name: &str, span: Span, stated: &mut Stated) {
        if let Some((before, _)) = stated.kind {
            self.error_help(
                span,
                "a function is one kind of force",
                format!("it is a {before} already"),
                "keep one of the attributes",
            );
            return;
        }
        let options = match &attribute.meta {
            Meta::Path(_) => Punctuated::new(),
            _ => match attribute.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated) {
                Ok(options) => options,
                Err(error) => {
                    let at = self.at(error.span());
                    let at = if at == Span::default() { span } else { at };
                    self.error_help(
                        at,
                        format!("the options of `#[{name}]` are malformed"),
                        error.to_string(),
                        "write them as in `#[constraint(unilateral, per_row)]`",
                    );
                    Punctuated::new()
                }
            },
        };
        let (mut unilateral, mut per_row) = (false, false);
        for option in &options {
            let path = self.path(option.path());
            let place = path.span;
            let text = path.last().to_owned();
            match (text.as_str(), option) {
                ("unilateral" | "per_row", Meta::Path(_)) if name == "constraint" => {
                    let flag = if text == "unilateral" { &mut unilateral } else { &mut per_row };
                    if *flag {
                        self.error(place, format!("`{text}` is stated twice"), "the second time");
                    }
                    *flag = true;
                }
                ("unilateral" | "per_row", Meta::Path(_)) => self.error_help(
                    place,
                    format!("`{text}` is an option of constraints"),
                    format!("this is `#[{name}]`"),
                    "an energy or a force is already all there is to it; leave the option out",
                ),
                ("real", Meta::NameValue(value)) => match &value.value {
                    syn::Expr::Path(path) if path.path.is_ident("f32") => {
                        stated.precision = Some(Precision::F32);
                    }
                    syn::Expr::Path(path) if path.path.is_ident("f64") => {
                        stated.precision = Some(Precision::F64);
                    }
                    _ => self.error_help(
                        place,
                        "unknown precision",
                        "neither `f32` nor `f64`",
                        "write `real = f32`",
                    ),
                },
                ("fma", Meta::Path(_)) => stated.fma = true,
                ("mode", Meta::NameValue(value)) => {
                    let mode = match &value.value {
                        syn::Expr::Path(path) => path.path.get_ident().map(ToString::to_string),
                        _ => None,
                    };
                    match mode.as_deref().map(Mode::named) {
                        Some(Some(mode)) => stated.mode = Some(mode),
                        _ => self.error_help(
                            place,
                            "unknown mode",
                            "what follows is none",
                            format!("the modes are {}", Mode::names()),
                        ),
                    }
                }
                ("unilateral" | "per_row" | "real" | "mode" | "fma", _) => {
                    let (form, help) = match text.as_str() {
                        "real" => ("it takes a precision", "write `real = f32`".to_owned()),
                        "mode" => ("it takes the name of a mode", "write `mode = fast`".to_owned()),
                        _ => ("it stands by itself", format!("write `{text}`")),
                    };
                    self.error_help(place, format!("the option `{text}` is malformed"), form, help);
                }
                _ => {
                    let known: &[&str] = match name {
                        "constraint" => &["unilateral", "per_row", "real", "mode", "fma"],
                        _ => &["real", "mode", "fma"],
                    };
                    let listed: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
                    let help = suggest::did_you_mean(&text, known.iter().copied())
                        .unwrap_or_else(|| format!("the options are {}", listed.join(", ")));
                    self.error_help(
                        place,
                        format!("unknown option `{text}`"),
                        format!("no option of `#[{name}]`"),
                        help,
                    );
                }
            }
        }
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
                other => {
                    let value = self.expr(other);
                    let at = self.expressions[value].span;
                    self.error_help(at, "a domain is a range or `unit`", "this is neither", HELP);
                    continue;
                }
            };
            if stated.domains.iter().any(|domain| domain.name.text == name.text) {
                self.error(
                    name.span,
                    format!("the domain of `{}` is stated twice", name.text),
                    "the second time",
                );
                continue;
            }
            let span = name.span.to(end);
            stated.domains.push(DomainClause { name, stated: stated_domain, span });
        }
    }
}

/// The lines of a doc comment, without the space after `///` and the stars of `/** … */`.
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
