//! The front end on library files whose tokens were moved about: the bytes are edits, three each.
#![no_main]

use forcec::internals::source::span::Source;
use forcec::internals::{check, syntax};
use libfuzzer_sys::fuzz_target;

const FILES: [&str; 7] = [
    include_str!("../../constraints/cloth.rs"),
    include_str!("../../constraints/contacts.rs"),
    include_str!("../../constraints/control.rs"),
    include_str!("../../constraints/fields.rs"),
    include_str!("../../constraints/joints.rs"),
    include_str!("../../constraints/solids.rs"),
    include_str!("../../constraints/springs.rs"),
];

/// Words and single characters.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let word = |c: char| c.is_alphanumeric() || c == '_';
        let end = if word(first) { rest.find(|c| !word(c)).unwrap_or(rest.len()) } else { first.len_utf8() };
        let (token, after) = rest.split_at(end);
        tokens.push(token);
        rest = after;
    }
    tokens
}

fuzz_target!(|input: (u8, Vec<(u8, u16, u16)>)| {
    let (file, edits) = input;
    let mut tokens = tokens(FILES[file as usize % FILES.len()]);
    for (kind, at, from) in edits.into_iter().take(16) {
        let (at, from) = (at as usize % tokens.len(), from as usize % tokens.len());
        match kind % 4 {
            0 => tokens[at] = tokens[from],
            1 => tokens.swap(at, from),
            2 => tokens.insert(at, tokens[from]),
            _ if tokens.len() > 1 => drop(tokens.remove(at)),
            _ => {}
        }
    }
    let source = Source::new("fuzz.rs", tokens.concat());
    let _ = syntax::parse(&source).and_then(|file| check::check(&file));
});
