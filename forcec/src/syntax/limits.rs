//! Limits on nesting, checked on the tokens with a stack of our own before anything recursive sees them.
//!
//! In: tokens. Out: nothing, or the message about the place that is nested too deeply or runs on for too long.
//! Promise: what passes is parsed, walked and dropped within the stack of [`crate::syntax::with_deep_stack`].

use crate::source::diagnostic::Diagnostic;
use crate::syntax::bytes_of;
use proc_macro2::{Delimiter, TokenStream, TokenTree, token_stream};

/// Brackets within brackets.
const DEEPEST: usize = 256;

/// What depends on the stack there is.
pub(super) struct Limits {
    /// Tokens from the start of a statement to any token in it, brackets that stand beside the way not counted.
    longest: usize,
    /// Operators in a row. Prefixes of types take the most stack a token.
    operators: usize,
}

/// On a stack of our own.
pub(super) const OWN: Limits = Limits { longest: 40_000, operators: 2_000 };

/// On the stack of rustc, where macros read their tokens: 8 MiB, and a compiler that is not optimised.
#[cfg(feature = "expand")]
pub(super) const MACRO: Limits = Limits { longest: 6_000, operators: 200 };

/// Letters of a name.
const LONGEST_NAME: usize = 255;

struct Level {
    tokens: token_stream::IntoIter,
    /// Tokens on the way to the bracket.
    start: usize,
    /// Tokens on the way to here.
    here: usize,
    /// Operators in a row up to here.
    operators: usize,
    /// The last token was a block in braces.
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
