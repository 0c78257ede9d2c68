//! Stage 1, source text → syntax tree.
//!
//! In: the text of a force file, any text at all. Out: an [`ast::File`], or all syntax errors. Promise: no
//! input panics, hangs or overflows the stack. syn parses the text; for Rust syntax outside the force
//! language, the error says what to write instead.

pub mod ast;
mod attributes;
mod expressions;
mod items;
mod limits;
mod print;
mod reader;
mod stated;
mod statements;
mod types;

pub(crate) use types::OTHER_NAMES;

use crate::source::diagnostic::{Diagnostic, Diagnostics};
use crate::source::span::{Source, Span};
use proc_macro2::{LexError, TokenStream, TokenTree};
use reader::Reader;
use std::cell::Cell;
use std::str::FromStr;
use std::sync::Mutex;

/// The stack size for parsing and checking. The limits on nesting and on the length of an expression are
/// chosen so that an unoptimised build stays within it.
const STACK: usize = 1 << 30;

/// The longest text accepted, in bytes.
const LONGEST_TEXT: usize = 16 << 20;

thread_local! {
    static DEEP: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` on a thread whose stack suffices for the recursion that the limits allow. If the caller
/// already runs on such a thread, it runs `work` there.
pub fn with_deep_stack<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if DEEP.get() {
        return work();
    }
    let work = Mutex::new(Some(work));
    let deep = || {
        DEEP.set(true);
        let work = work.lock().ok().and_then(|mut work| work.take());
        work.map(|work| work())
    };
    std::thread::scope(|scope| {
        // If address space is scarce, a smaller stack still suffices for ordinary files.
        let started = [STACK, STACK / 4, STACK / 16].into_iter().find_map(|size| {
            let thread = std::thread::Builder::new().name("forcec".to_owned()).stack_size(size);
            thread.spawn_scoped(scope, deep).ok()
        });
        let result = match started {
            Some(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
            None => work.lock().ok().and_then(|mut work| work.take()).map(|work| work()),
        };
        result.expect("the work is taken once")
    })
}

/// Parses a force file; returns all syntax errors if there are any.
pub fn parse(source: &Source) -> Result<ast::File, Diagnostics> {
    with_deep_stack(|| {
        let list = match tokens(&source.text) {
            Err(diagnostic) => vec![diagnostic],
            Ok(tokens) => match syn::parse2::<syn::File>(tokens) {
                Err(error) => syn_errors(&error, &mut bytes_of, &source.text),
                Ok(file) => return from_items(source.clone(), &file.attrs, &file.items, bytes_of),
            },
        };
        Err(report(source.clone(), list))
    })
}

/// The syntax tree of items that are already parsed: the entry point of the macros. Their spans belong to
/// rustc; only `locate` converts them.
pub fn from_items(
    source: Source,
    attributes: &[syn::Attribute],
    items: &[syn::Item],
    locate: impl FnMut(proc_macro2::Span) -> Span,
) -> Result<ast::File, Diagnostics> {
    let mut reader = Reader::new(locate);
    reader.file(attributes, items);
    if reader.diagnostics.is_empty() {
        let Reader { docs, functions, constants, modules, unexplained, .. } = reader;
        Ok(ast::File { source, docs, functions, constants, modules, unexplained })
    } else {
        Err(report(source, reader.diagnostics))
    }
}

/// The options in the attribute above an item, or the errors in them.
#[cfg(feature = "expand")]
pub(crate) fn options(
    item: &syn::Item,
    locate: impl FnMut(proc_macro2::Span) -> Span,
) -> Result<Vec<crate::options::Choice>, Vec<Diagnostic>> {
    let mut reader = Reader::new(locate);
    let attributes = match item {
        syn::Item::Mod(module) => &module.attrs[..],
        _ => &[],
    };
    let stated = reader.attributes(attributes).options;
    if !reader.diagnostics.is_empty() {
        return Err(reader.diagnostics);
    }
    Ok(stated.into_iter().map(|stated| stated.choice).collect())
}

/// Checks the tokens of a macro against the limits on nesting and length.
#[cfg(feature = "expand")]
pub(crate) fn check_limits(tokens: TokenStream) -> Result<(), Diagnostic> {
    limits::check(tokens, &limits::MACRO)
}

/// Maximum number of errors in a report.
const MOST_ERRORS: usize = 100;

/// Sorts the errors of a stage and keeps at most `MOST_ERRORS`.
pub(crate) fn report(source: Source, list: Vec<Diagnostic>) -> Diagnostics {
    let mut report = Diagnostics::new(source, list);
    let more = report.list.len().saturating_sub(MOST_ERRORS);
    if more > 0 {
        report.list.truncate(MOST_ERRORS);
        report.list.push(Diagnostic::file(format!("{more} more errors are not shown")));
    }
    report
}

/// Position of a token of a text that [`tokenise`] read.
fn bytes_of(span: proc_macro2::Span) -> Span {
    let range = span.byte_range();
    Span { start: range.start as u32, end: range.end as u32 }
}

/// Whether a text has a force attribute; other Rust files are skipped. Comments and strings do not count. A
/// text that cannot be tokenised counts if it contains the text of a force attribute.
pub fn mentions_forces(text: &str) -> bool {
    const NAMES: [&str; 4] = ["constraint", "energy", "force", "forces"];
    if !text.contains('#') || !NAMES.iter().any(|name| text.contains(name)) {
        return false;
    }
    let Ok(tokens) = tokenise(text) else {
        return NAMES.iter().any(|name| text.contains(&format!("#[{name}")));
    };
    let mut pending = vec![tokens.into_iter()];
    let mut after_hash = false;
    while let Some(stream) = pending.last_mut() {
        match stream.next() {
            None => {
                pending.pop();
                after_hash = false;
            }
            Some(TokenTree::Group(group)) => {
                if after_hash && attribute_name(group.stream()).is_some_and(|n| NAMES.contains(&n.as_str())) {
                    return true;
                }
                after_hash = false;
                pending.push(group.stream().into_iter());
            }
            Some(TokenTree::Punct(punct)) => after_hash = punct.as_char() == '#',
            Some(_) => after_hash = false,
        }
    }
    false
}

/// The last segment of the path at the start of an attribute.
fn attribute_name(tokens: TokenStream) -> Option<String> {
    let mut name = None;
    for token in tokens {
        match token {
            TokenTree::Ident(ident) => name = Some(ident.to_string()),
            TokenTree::Punct(punct) if punct.as_char() == ':' => {}
            _ => break,
        }
    }
    name
}

/// Tokenises a text; a byte order mark and a `#!` line become spaces, so that positions stay the same.
fn tokenise(text: &str) -> Result<TokenStream, LexError> {
    let mut text = std::borrow::Cow::Borrowed(text);
    if text.starts_with('\u{feff}') {
        text.to_mut().replace_range(..3, "   ");
    }
    let start = text.len() - text.trim_start_matches(' ').len();
    if text[start..].starts_with("#!") && !text[start + 2..].trim_start().starts_with('[') {
        let end = text.find('\n').unwrap_or(text.len());
        text.to_mut().replace_range(start..end, &" ".repeat(end - start));
    }
    TokenStream::from_str(&text)
}

/// Tokenises a text and checks the limits.
fn tokens(text: &str) -> Result<TokenStream, Diagnostic> {
    if text.len() > LONGEST_TEXT {
        return Err(Diagnostic::file(format!("a force file is at most {} MiB long", LONGEST_TEXT >> 20)));
    }
    let tokens = tokenise(text).map_err(|error| lexical_error(text, &error))?;
    limits::check(tokens.clone(), &limits::OWN)?;
    Ok(tokens)
}

fn lexical_error(text: &str, error: &LexError) -> Diagnostic {
    let start = (error.span().byte_range().start).min(text.len());
    let rest = &text[start..];
    let character = rest.chars().next();
    let span = Span { start: start as u32, end: (start + character.map_or(0, char::len_utf8)) as u32 };
    let diagnostic = |message: String, label: &str| Diagnostic::error(span, message, label);
    match character {
        Some(bracket @ ('(' | '[' | '{')) => {
            diagnostic(format!("`{bracket}` is never closed"), "the bracket that is opened here")
        }
        Some(bracket @ (')' | ']' | '}')) => {
            // Tokenising the text before this bracket fails at the open bracket that does not match.
            let open = tokenise(&text[..start]).err().map(|error| error.span().byte_range().start);
            let open = open.filter(|open| *open < start && text[*open..].starts_with(['(', '[', '{']));
            let line = |offset: usize| Source::new("", text).line_column(offset as u32).0;
            match open {
                Some(open) if bracket == '}' => {
                    let opening = &text[open..=open];
                    let span = Span { start: open as u32, end: open as u32 + 1 };
                    let message = format!("`{opening}` is never closed");
                    Diagnostic::error(span, message, "the bracket that is opened here")
                        .help(format!("`{bracket}` on line {} comes first", line(start)))
                }
                Some(open) => {
                    let label = format!("`{}` on line {} is open here", &text[open..=open], line(open));
                    diagnostic(format!("unmatched `{bracket}`"), &label)
                }
                None => diagnostic(format!("unmatched `{bracket}`"), "no bracket is open here"),
            }
        }
        Some('"') => diagnostic("the quotation mark is never closed".to_owned(), "text begins here"),
        Some('\'') => diagnostic("a stray quotation mark".to_owned(), "neither a character nor a lifetime"),
        Some('/') if rest.starts_with("//") || rest.contains("*/") => {
            diagnostic("a carriage return without a line feed".to_owned(), "a doc comment that has one")
                .help("end lines with a line feed, or with both")
        }
        Some('/') => diagnostic("the comment is never closed".to_owned(), "`/*` without `*/`"),
        Some(digit) if digit.is_ascii_digit() => {
            diagnostic("a number that is malformed".to_owned(), "not a Rust literal")
                .help("write numbers as `2.0`, `1e-3` or, for indices, `3`")
        }
        Some(other) => {
            let shown =
                if other.is_control() { other.escape_unicode().to_string() } else { other.to_string() };
            diagnostic(format!("unexpected character `{shown}`"), "not part of any Rust token")
        }
        None => diagnostic("the text ends within a token".to_owned(), "the end"),
    }
}

/// What to write instead of syntax from other languages, guessed from syn's message and the text around it.
fn instead(message: &str, text: &str, span: Span) -> Option<&'static str> {
    let before = text.get(..span.start as usize)?.trim_end();
    let here = text.get(span.start as usize..)?;
    if message.contains("chained") {
        Some("write `a < b && b < c`")
    } else if before.ends_with('?') {
        Some("for a choice write `if condition { x } else { y }`")
    } else if before.ends_with("--") || before.ends_with('+') && here.starts_with('+') {
        Some("write `i += 1` or `i -= 1`")
    } else if before.ends_with("for (") || before.ends_with("for (int") {
        Some("write `for i in 0..n { … }`")
    } else if message == "expected `:`" {
        Some("write the type behind a `:`, as in `x: Real`")
    } else if message == "expected `,`" && here.starts_with('=') {
        Some("an argument has no default: whoever calls the kernel gives every value")
    } else {
        None
    }
}

/// Converts the messages of syn.
fn syn_errors(
    error: &syn::Error,
    locate: &mut dyn FnMut(proc_macro2::Span) -> Span,
    text: &str,
) -> Vec<Diagnostic> {
    error
        .into_iter()
        .map(|error| {
            let mut span = locate(error.span());
            if span == Span::default() {
                // syn has no position for the end of the input.
                span = Span { start: text.len() as u32, end: text.len() as u32 };
            }
            let mut diagnostic = Diagnostic::error(span, error.to_string(), "this is not Rust");
            diagnostic.help = instead(&diagnostic.message, text, span).map(str::to_owned);
            diagnostic
        })
        .collect()
}
