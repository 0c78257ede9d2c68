//! Items in the form that rustc compiles.
//!
//! In: the tokens of items of a force file. Out: the same tokens without forcec's attributes, plus attributes
//! that prevent warnings. All other tokens are unchanged, including invisible groups of macros within items.

use crate::source::diagnostic::Lint;
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::parse::{ParseStream, Parser};
use syn::punctuated::Punctuated;

/// The attributes of force functions.
pub(crate) const FORCES: [&str; 3] = ["constraint", "energy", "force"];

/// All attributes that rustc does not know.
const OURS: [&str; 5] = ["constraint", "energy", "force", "forces", "domain"];

/// The items without forcec's attributes, plus attributes that suppress warnings. `force`: the first item is
/// a force function whose attribute has been removed.
pub(crate) fn plain(tokens: TokenStream, mut force: bool) -> TokenStream {
    let mut items = TokenStream::new();
    let mut item: Vec<TokenTree> = Vec::new();
    let mut tokens = spliced(tokens).into_iter().peekable();
    while let Some(token) = tokens.next() {
        let hash = matches!(&token, TokenTree::Punct(mark) if mark.as_char() == '#');
        let mut marks = vec![token];
        if hash {
            marks.extend(
                tokens.next_if(|next| matches!(next, TokenTree::Punct(mark) if mark.as_char() == '!')),
            );
            let bracket = |next: &TokenTree| matches!(next, TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket);
            if let Some(TokenTree::Group(group)) = tokens.next_if(bracket) {
                force |= is_named(&group, &FORCES);
                if let Some(kept) = kept(group) {
                    item.extend(marks);
                    item.push(kept.into());
                }
                continue;
            }
        }
        let has =
            |word: &str| item.iter().any(|token| matches!(token, TokenTree::Ident(ident) if ident == word));
        let ends = match &marks[0] {
            TokenTree::Punct(mark) => mark.as_char() == ';',
            // Constants and imports may contain braces and continue after them.
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                has("fn") || !["use", "const", "static", "type"].into_iter().any(has)
            }
            _ => false,
        };
        if ends
            && has("mod")
            && !has("fn")
            && let TokenTree::Group(body) = &marks[0]
        {
            let mut inner = Group::new(Delimiter::Brace, plain(body.stream(), false));
            inner.set_span(body.span());
            marks[0] = inner.into();
        }
        item.extend(marks);
        if ends {
            items.extend(function_item(std::mem::take(&mut item), std::mem::take(&mut force)));
        }
    }
    items.extend(item);
    items
}

/// An item without forcec's attributes, with attributes and a use if the item is a function.
fn function_item(item: Vec<TokenTree>, force: bool) -> TokenStream {
    let tokens: TokenStream = item.into_iter().collect();
    let Ok(function) = syn::parse2::<syn::ItemFn>(tokens.clone()) else { return tokens };
    let many = (function.sig.inputs.len() > 7)
        .then(|| quote!(#[allow(clippy::too_many_arguments, reason = "they are the parameters of a force")]));
    let body = || function.block.to_token_stream();
    let loops = mentions(body(), &["for"]).then(
        || quote!(#[allow(clippy::needless_range_loop, reason = "the force language has no iterators")]),
    );
    let future = mentions(body(), &["erf", "erfc"]).then(
        || quote!(#[allow(unstable_name_collisions, reason = "the standard library's would be the same")]),
    );
    // The program may call the kernel only.
    let deprecated = function.attrs.iter().any(|attribute| attribute.path().is_ident("deprecated"));
    let name = &function.sig.ident;
    let generic = !function.sig.generics.params.is_empty();
    let used = (force && !deprecated && !generic).then(|| quote!(const _: () = _ = #name;));
    quote!(#many #loops #future #tokens #used)
}

/// The tokens of items without the invisible groups that macros insert; groups within an item remain.
fn spliced(tokens: TokenStream) -> TokenStream {
    let mut found = TokenStream::new();
    let mut pending = vec![tokens.into_iter()];
    while let Some(stream) = pending.last_mut() {
        match stream.next() {
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::None => {
                pending.push(group.stream().into_iter());
            }
            Some(token) => found.extend([token]),
            None => _ = pending.pop(),
        }
    }
    found
}

/// The tokens of a file without its inner attributes, which a module within a macro cannot have.
pub(crate) fn without_inner(tokens: TokenStream) -> TokenStream {
    let mut tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let is = |token: Option<&TokenTree>, sign: char| matches!(token, Some(TokenTree::Punct(mark)) if mark.as_char() == sign);
    let inner = |tokens: &[TokenTree]| is(tokens.first(), '#') && is(tokens.get(1), '!') && tokens.len() > 2;
    let mut head = 0;
    while inner(&tokens[head..]) {
        head += 3;
    }
    tokens.drain(..head);
    tokens.into_iter().collect()
}

/// The attribute for rustc: `None` for forcec's attributes, and `allow` without forcec's lints.
fn kept(attribute: Group) -> Option<Group> {
    if is_named(&attribute, &OURS) {
        return None;
    }
    let Ok(syn::Meta::List(list)) = syn::parse2::<syn::Meta>(attribute.stream()) else {
        return Some(attribute);
    };
    let words = Punctuated::<syn::Meta, syn::Token![,]>::parse_terminated.parse2(list.tokens.clone());
    let own = |meta: &syn::Meta| {
        let name = meta.path().get_ident().map(ToString::to_string);
        name.and_then(|name| Lint::named(&name)).is_some_and(|lint| !lint.is_shared())
    };
    match words {
        Ok(words) if list.path.is_ident("allow") && words.iter().any(own) => {
            let rest: Vec<&syn::Meta> = words.iter().filter(|meta| !own(meta)).collect();
            let lints = rest.iter().any(|meta| matches!(meta, syn::Meta::Path(_)));
            lints.then(|| Group::new(Delimiter::Bracket, quote!(allow(#(#rest),*))))
        }
        _ => Some(attribute),
    }
}

/// Whether an attribute, given by the contents of its brackets, has one of these names.
pub(crate) fn is_named(attribute: &Group, names: &[&str]) -> bool {
    let path = syn::Path::parse_mod_style;
    let path =
        |input: ParseStream<'_>| path(input).and_then(|path| input.parse::<TokenStream>().map(|_| path));
    path.parse2(attribute.stream()).is_ok_and(|path| is_path(&path, names))
}

/// Whether tokens use `PI` without a path, outside of imports.
pub(crate) fn names_pi(tokens: &TokenStream) -> bool {
    let (mut behind, mut import) = (false, false);
    tokens.clone().into_iter().any(|token| {
        let alone = !behind && !import;
        behind = matches!(&token, TokenTree::Punct(mark) if [':', '.'].contains(&mark.as_char()));
        match token {
            TokenTree::Ident(ident) if ident == "use" => import = true,
            TokenTree::Punct(mark) if mark.as_char() == ';' => import = false,
            TokenTree::Ident(ident) => return ident == "PI" && alone,
            TokenTree::Group(group) => return !import && names_pi(&group.stream()),
            _ => {}
        }
        false
    })
}

/// A compile-time check that `PI` is π for rustc as well, in either precision.
pub(crate) fn is_pi() -> TokenStream {
    quote! {
        const _: () = ::core::assert!(
            PI * 1e6 > 3141592.5 && PI * 1e6 < 3141593.0,
            "`PI` is another number here than π, which it is in the force language"
        );
    }
}

/// Whether the tokens contain one of these words.
fn mentions(tokens: TokenStream, words: &[&str]) -> bool {
    tokens.into_iter().any(|token| match token {
        TokenTree::Ident(ident) => words.iter().any(|word| ident == word),
        TokenTree::Group(group) => mentions(group.stream(), words),
        _ => false,
    })
}

fn is_path(path: &syn::Path, names: &[&str]) -> bool {
    let segments: Vec<String> = path.segments.iter().map(|part| part.ident.to_string()).collect();
    match segments.as_slice() {
        [name] => names.contains(&name.as_str()),
        [place, name] => place.starts_with("forcec") && names.contains(&name.as_str()),
        _ => false,
    }
}
