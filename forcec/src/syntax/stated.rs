//! Options of an attribute: `fma`, `lanes = 4`, `fixed(b)`, `set(damping = 0.0, arm_b = [0.0, 0.0, 0.5])`.
//!
//! In: an attribute, and the names of its own flags. Out: the flags that are present, and the options of the
//! table with the positions of their values; or the error in an option, at its position.

use crate::options::{OPTIONS, OptionRow, Takes, suggestion};
use crate::source::span::Span;
use crate::syntax::ast;
use crate::syntax::attributes::Stated;
use crate::syntax::reader::Reader;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::spanned::Spanned;
use syn::{Attribute, Expr, Lit, Meta, Token};

/// Options that attributes do not accept.
const ELSEWHERE: [&str; 1] = ["target"];

/// One value within the brackets of an option: `value`, `"value"`, or `damping = 0.0`.
struct Word {
    name: Option<syn::Ident>,
    value: Expr,
}

impl Parse for Word {
    fn parse(input: ParseStream<'_>) -> syn::Result<Word> {
        let name = input.peek(syn::Ident) && input.peek2(Token![=]);
        let name: Option<syn::Ident> = if name { Some(input.parse()?) } else { None };
        if name.is_some() {
            input.parse::<Token![=]>()?;
        }
        Ok(Word { name, value: input.parse()? })
    }
}

impl Reader<'_> {
    /// Reads the options of an attribute; returns those of `flags` that are present.
    pub(super) fn options<'f>(
        &mut self,
        attribute: &Attribute,
        name: &str,
        span: Span,
        flags: &[&'f str],
        stated: &mut Stated,
    ) -> Vec<&'f str> {
        if matches!(attribute.meta, Meta::Path(_)) {
            return Vec::new();
        }
        let options = match attribute.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated) {
            Ok(options) => options,
            Err(error) => {
                let at = self.at(error.span());
                let at = if at == Span::default() { span } else { at };
                let example =
                    if name == "constraint" { "unilateral, per_row" } else { "real = f32, mode = fast" };
                self.error_help(
                    at,
                    format!("the options of `#[{name}]` are malformed"),
                    error.to_string(),
                    format!("write them as in `#[{name}({example})]`"),
                );
                return Vec::new();
            }
        };
        let mut seen: Vec<String> = Vec::new();
        let mut found = Vec::new();
        for option in &options {
            let path = self.path(option.path());
            let (place, text) = (path.span, path.last().to_owned());
            if seen.contains(&text) {
                self.error(place, format!("`{text}` is stated twice"), "the second time");
                continue;
            }
            let flag = flags.iter().find(|flag| **flag == text);
            let row = OptionRow::named(&text).filter(|row| !ELSEWHERE.contains(&row.name));
            match (flag, row) {
                (Some(flag), _) if matches!(option, Meta::Path(_)) => found.push(*flag),
                (Some(_), _) => self.malformed(place, &text, "it stands by itself", &text),
                (None, Some(row)) => stated.options.extend(self.option(row, option, place)),
                (None, None) => self.unknown(place, &text, name, flags),
            }
            seen.push(text);
        }
        found
    }

    /// Reads an option of the table, or reports an error.
    fn option(&mut self, row: &'static OptionRow, option: &Meta, place: Span) -> Option<ast::Stated> {
        let words: Vec<Word> = match option {
            Meta::Path(_) => Vec::new(),
            Meta::NameValue(value) => vec![Word { name: None, value: value.value.clone() }],
            Meta::List(list) if row.is_list() => {
                match list.parse_args_with(Punctuated::<Word, Token![,]>::parse_terminated) {
                    Ok(words) => words.into_iter().collect(),
                    Err(error) => {
                        let at = self.at(error.span());
                        self.malformed(
                            if at == Span::default() { place } else { at },
                            row.name,
                            &error.to_string(),
                            row.example,
                        );
                        return None;
                    }
                }
            }
            Meta::List(_) => {
                self.malformed(place, row.name, &row.form(), row.example);
                return None;
            }
        };
        if words.is_empty() != (row.takes == Takes::Nothing) {
            self.malformed(place, row.name, &row.form(), row.example);
            return None;
        }
        let (mut texts, mut places) = (Vec::new(), Vec::new());
        for word in &words {
            let span = self.place(&word.value);
            let span = word.name.as_ref().map_or(span, |name| self.at(name.span()).to(span));
            let Some(text) = text(word, row.takes) else {
                self.malformed(span, row.name, &row.form(), row.example);
                return None;
            };
            texts.push(text);
            places.push(span);
        }
        match row.read(&texts.iter().map(String::as_str).collect::<Vec<_>>()) {
            Ok(choice) => {
                let span = places.iter().fold(place, |all, place| all.to(*place));
                Some(ast::Stated { choice, span, places, shared: false })
            }
            Err(wrong) => {
                let at = places.get(wrong.index).copied().unwrap_or(place);
                self.error_help(at, wrong.message, wrong.label, wrong.help);
                None
            }
        }
    }

    /// The span of a value, from its first to its last token.
    fn place(&mut self, value: &Expr) -> Span {
        match value {
            Expr::Array(array) => self.between(array.bracket_token.span),
            Expr::Unary(unary) => {
                let sign = self.at(unary.op.span());
                sign.to(self.place(&unary.expr))
            }
            other => self.at(other.span()),
        }
    }

    fn malformed(&mut self, place: Span, option: &str, form: &str, example: &str) {
        self.error_help(
            place,
            format!("the option `{option}` is malformed"),
            form,
            format!("write `{example}`"),
        );
    }

    fn unknown(&mut self, place: Span, text: &str, attribute: &str, flags: &[&str]) {
        if ["unilateral", "per_row"].contains(&text) {
            let help = match attribute {
                "forces" => "state it of each constraint",
                _ => "an energy or a force is already all there is to it; leave the option out",
            };
            let message = format!("`{text}` is an option of constraints");
            return self.error_help(place, message, format!("this is `#[{attribute}]`"), help);
        }
        let names = OPTIONS.iter().map(|row| row.name).filter(|name| !ELSEWHERE.contains(name));
        let known: Vec<&str> = flags.iter().copied().chain(names).collect();
        let help = suggestion(text, &known);
        self.error_help(
            place,
            format!("unknown option `{text}`"),
            format!("no option of `#[{attribute}]`"),
            help,
        );
    }
}

/// A value as text for the table.
fn text(word: &Word, takes: Takes) -> Option<String> {
    match (&word.name, &word.value) {
        (Some(name), value) if takes == Takes::Numbers => {
            let mut text = format!("{name}=");
            numbers(value, "", &mut text)?;
            Some(text)
        }
        (Some(_), _) => None,
        (None, _) if takes == Takes::Numbers => None,
        (None, Expr::Path(path)) => path.path.get_ident().map(ToString::to_string),
        (None, Expr::Lit(literal)) => match &literal.lit {
            Lit::Str(text) => Some(text.value()),
            Lit::Int(number) => Some(number.base10_digits().to_owned()),
            _ => None,
        },
        _ => None,
    }
}

/// Writes a number, or a nested array of numbers.
fn numbers(value: &Expr, sign: &str, text: &mut String) -> Option<()> {
    match value {
        Expr::Lit(literal) => {
            let digits = match &literal.lit {
                Lit::Float(number) => number.base10_digits(),
                Lit::Int(number) => number.base10_digits(),
                _ => return None,
            };
            text.push_str(&format!("{sign}{digits}"));
        }
        Expr::Unary(syn::ExprUnary { op: syn::UnOp::Neg(_), expr, .. }) if sign.is_empty() => {
            numbers(expr, "-", text)?;
        }
        Expr::Array(array) if sign.is_empty() => {
            for (index, element) in array.elems.iter().enumerate() {
                text.push(if index == 0 { '[' } else { ',' });
                numbers(element, "", text)?;
            }
            text.push(']');
        }
        _ => return None,
    }
    Some(())
}
