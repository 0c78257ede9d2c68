//! Limits on nesting, checked on the tokens with an explicit stack before any recursive pass.
//!
//! In: tokens. Out: nothing, or an error at the position that is too deep or too long. Promise: tokens that
//! pass can be parsed, traversed and dropped within the stack of [`crate::syntax::with_deep_stack`].

use crate::source::diagnostic::Diagnostic;
use crate::syntax::bytes_of;
use proc_macro2::{Delimiter, TokenStream, TokenTree, token_stream};

/// Maximum nesting depth of brackets.
const DEEPEST: usize = 256;

/// Limits that depend on the available stack.
pub(super) struct Limits {
    /// Maximum number of tokens up to any token of a statement, without the contents of closed brackets.
    longest: usize,
    /// Maximum number of consecutive operators; prefixes of types take the most stack.
    operators: usize,
}

/// The limits for the deep stack.
pub(super) const OWN: Limits = Limits { longest: 40_000, operators: 2_000 };

/// The limits for the stack of rustc, on which macros read their tokens: 8 MiB, in an unoptimised compiler.
#[cfg(feature = "expand")]
pub(super) const MACRO: Limits = Limits { longest: 6_000, operators: 200 };

/// Maximum number of letters of a name.
const LONGEST_NAME: usize = 255;

struct Level {
    tokens: token_stream::IntoIter,
    /// Tokens up to the enclosing bracket.
    start: usize,
    /// Tokens up to the current token.
    here: usize,
    /// Consecutive operators up to the current token.
    operators: usize,
    /// Whether the last token was a block in braces.
    after_block: bool,
}

pub(super) fn check(tokens: TokenStream, limits: &Limits) -> Result<(), Diagnostic> {
    let level = |tokens: TokenStream, start| Level {
        tokens: tokens.into_iter(),
        start,
        here: start,
        operators: 0,
        after_block: false,
    };
    let mut levels = vec![level(tokens, 0)];
    while let Some(current) = levels.last_mut() {
        let Some(token) = current.tokens.next() else {
            levels.pop();
            continue;
        };
        let new_statement = match &token {
            TokenTree::Ident(ident) => {
                current.after_block && !["else", "as", "in", "if"].iter().any(|word| ident == word)
            }
            TokenTree::Punct(punct) => {
                matches!(punct.as_char(), ';' | ',') || punct.as_char() == '#' && current.after_block
            }
            TokenTree::Group(_) | TokenTree::Literal(_) => current.after_block,
        };
        current.here = if new_statement { current.start } else { current.here + 1 };
        if current.here > limits.longest {
            let label = format!("more than {} tokens without a `;` or `,` end here", limits.longest);
            return Err(Diagnostic::error(bytes_of(token.span()), "an expression is too long", label)
                .help("name its parts with `let`"));
        }
        if let TokenTree::Ident(name) = &token
            && name.to_string().chars().count() > LONGEST_NAME
        {
            let label = format!("more than {LONGEST_NAME} letters");
            return Err(Diagnostic::error(bytes_of(name.span()), "a name is too long", label)
                .help("choose a shorter name"));
        }
        let operator = matches!(token, TokenTree::Punct(_));
        current.operators = if operator { current.operators + 1 } else { 0 };
        if current.operators > limits.operators {
            let label = format!("more than {} operators in a row end here", limits.operators);
            return Err(Diagnostic::error(bytes_of(token.span()), "an expression is too long", label)
                .help("leave out operators that cancel"));
        }
        current.after_block = false;
        if let TokenTree::Group(group) = token {
            current.after_block = group.delimiter() == Delimiter::Brace;
            let start = current.here;
            if levels.len() > DEEPEST {
                let label = format!("the {}th bracket within another", levels.len());
                return Err(Diagnostic::error(
                    bytes_of(group.span_open()),
                    "brackets are nested too deeply",
                    label,
                )
                .help("name inner parts with `let`"));
            }
            levels.push(level(group.stream(), start));
        }
    }
    Ok(())
}
