//! Maps tokens to positions in a text, and back.
//!
//! In: the compiler's tokens. Out: a text in which each token has a position; the tokens at a position; and
//! the author of a token, as far as the compiler reveals it.

use crate::source::diagnostic::Diagnostic;
use crate::source::span::Span;
use crate::syntax::ast;
use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use std::collections::{BTreeMap, HashMap};

/// The tokens of an input in order, with a text made of them; positions refer to this text.
#[derive(Default)]
pub(crate) struct Places {
    pub(crate) text: String,
    tokens: Vec<(Span, proc_macro2::Span)>,
    by_span: HashMap<String, usize>,
}

impl Places {
    pub(crate) fn new(tokens: TokenStream) -> Places {
        let mut places = Places::default();
        let mut pending = vec![tokens.into_iter()];
        // The closing brackets of the open groups.
        let mut closing: Vec<(&str, proc_macro2::Span)> = Vec::new();
        while let Some(stream) = pending.last_mut() {
            match stream.next() {
                Some(TokenTree::Group(group)) => {
                    let (open, close) = match group.delimiter() {
                        Delimiter::Parenthesis => ("(", ")"),
                        Delimiter::Brace => ("{", "}"),
                        Delimiter::Bracket => ("[", "]"),
                        Delimiter::None => ("", ""),
                    };
                    places.token(open, group.span_open());
                    closing.push((close, group.span_close()));
                    pending.push(group.stream().into_iter());
                }
                Some(token) => {
                    places.token(&token.to_string(), token.span());
                    // Joint punctuation stays joint: `**` differs from `* *`.
                    if matches!(&token, TokenTree::Punct(mark) if mark.spacing() == Spacing::Joint) {
                        places.text.pop();
                    }
                }
                None => {
                    pending.pop();
                    if let Some((close, span)) = closing.pop() {
                        places.token(close, span);
                    }
                }
            }
        }
        places
    }

    fn token(&mut self, text: &str, span: proc_macro2::Span) {
        self.by_span.entry(key(span)).or_insert(self.tokens.len());
        let from = self.text.len() as u32;
        self.text.push_str(text);
        self.tokens.push((Span { start: from, end: self.text.len() as u32 }, span));
        self.text.push(' ');
    }

    /// The position of a token.
    pub(crate) fn of(&self, span: proc_macro2::Span) -> Span {
        let index = self.by_span.get(&key(span));
        index.map_or_else(Span::default, |index| self.tokens[*index].0)
    }

    /// The token that begins at a position.
    fn token_at(&self, span: Span) -> Option<proc_macro2::Span> {
        let first = self.tokens.partition_point(|(token, _)| token.start < span.start);
        self.tokens.get(first).map(|(_, span)| *span)
    }

    /// The first and the last token in a range.
    pub(crate) fn ends(&self, span: Option<Span>) -> (proc_macro2::Span, proc_macro2::Span) {
        let here = proc_macro2::Span::call_site();
        let Some(span) = span.filter(|span| span.start < span.end) else { return (here, here) };
        let first = self.tokens.partition_point(|(token, _)| token.start < span.start);
        let last = self.tokens.partition_point(|(token, _)| token.end < span.end);
        let at = |index: usize| self.tokens.get(index).map_or(here, |(_, span)| *span);
        (at(first), at(last))
    }
}

/// Identifies a token by its start, and by the file or macro that it comes from.
fn key(span: proc_macro2::Span) -> String {
    let start = span.start();
    format!("{}:{} {span:?}", start.line, start.column)
}

/// The author of a token, by which rustc distinguishes equal names: the file, or one use of a macro.
fn writer(span: proc_macro2::Span) -> Option<String> {
    let text = format!("{span:?}");
    text.split_once(' ').map(|(writer, _)| writer.to_owned()).filter(|writer| writer.starts_with('#'))
}

/// An error for each variable that only rustc can tell from another of the same name, which is a macro's.
pub(crate) fn mixed(file: &ast::File, places: &Places) -> Vec<Diagnostic> {
    let mut errors = Vec::new();
    for function in &file.functions {
        let bound = function.bound();
        let mut writers: BTreeMap<&str, (String, bool)> = BTreeMap::new();
        let used = function.expressions.iter().filter_map(|expr| match &expr.kind {
            ast::ExprKind::Path(path) => Some((path.single()?, path.span)),
            _ => None,
        });
        let names = bound.iter().map(|name| (name.text.as_str(), name.span));
        for (name, span) in
            names.clone().chain(used.filter(|(name, _)| names.clone().any(|(own, _)| own == *name)))
        {
            let Some(writer) = places.token_at(span).and_then(writer) else { continue };
            let (first, reported) = writers.entry(name).or_insert_with(|| (writer.clone(), false));
            if *first != writer && !std::mem::replace(reported, true) {
                let message =
                    format!("`{name}` is the name of two variables, of a macro and of who calls it");
                let error = Diagnostic::error(span, message, "the kernel cannot tell them apart");
                errors.push(error.help("give the variable of the macro another name"));
            }
        }
    }
    errors
}
