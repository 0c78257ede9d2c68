//! The front end on thousands of damaged force files: it returns a tree or messages, and never panics.
//!
//! Bytes and tokens are changed at random from fixed seeds, so every run is the same; the targets of `fuzz/` run without
//! a limit.

use forcec::internals::compile::compile;
use forcec::internals::emit;
use forcec::internals::kernel::{File, Precision, Target};
use forcec::internals::source::span::Source;
use forcec::internals::{check, syntax};
use forcec_tests::Random;
use std::path::Path;
use std::time::Instant;

fn pick<'a, T>(random: &mut Random, items: &'a [T]) -> &'a T {
    &items[random.below(items.len())]
}

/// Texts short enough for many runs: every force function of the library and of the golden inputs.
fn seeds() -> Vec<String> {
    let mut paths = Vec::new();
    for folder in ["golden", "unseen", "../constraints"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        paths.extend(std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    }
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
    paths.sort();
    paths.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect()
}

/// Words, numbers, runs of spaces and single characters.
fn tokens(text: &str) -> Vec<&str> {
    let class = |c: char| if c.is_alphanumeric() || c == '_' { 0 } else { 1 + u32::from(c.is_whitespace()) };
    let (mut tokens, mut start) = (Vec::new(), 0);
    let mut last = None;
    for (at, character) in text.char_indices() {
        let class = class(character);
        if at > start && (last != Some(class) || class == 1) {
            tokens.push(&text[start..at]);
            start = at;
        }
        last = Some(class);
    }
    tokens.push(&text[start..]);
    tokens
}

const WORDS: [&str; 36] = [
    "Real",
    "Vec3",
    "Vec2",
    "Mat3",
    "Mat2",
    "Quat",
    "Rigid",
    "Particle",
    "Wrench",
    "0",
    "1",
    "3",
    "2.0",
    "1e300",
    "-1",
    "a",
    "p",
    "x",
    "position",
    "orientation",
    "norm",
    "if",
    "else",
    "for",
    "let",
    "mut",
    "fn",
    "(",
    ")",
    "[",
    "{",
    "+",
    "*",
    ",",
    "#[energy]",
    "🦀",
];

/// The text after a few edits of tokens.
fn by_tokens(random: &mut Random, text: &str, other: &str) -> String {
    let (mut tokens, others) = (tokens(text), tokens(other));
    for _ in 0..=random.below(3) {
        let at = random.below(tokens.len());
        match random.below(6) {
            0 => drop(tokens.remove(at)),
            1 => tokens.insert(at, *pick::<&str>(random, &WORDS)),
            2 => tokens[at] = *pick::<&str>(random, &WORDS),
            3 => {
                let with = random.below(tokens.len());
                tokens.swap(at, with);
            }
            4 => tokens[at] = *pick::<&str>(random, &others),
            _ => {
                // A word in the place of a word: the likeliest to be understood.
                let word = |token: &&str| token.starts_with(char::is_alphabetic);
                let words: Vec<usize> = (0..tokens.len()).filter(|k| word(&tokens[*k])).collect();
                if !words.is_empty() {
                    tokens[*pick(random, &words)] = tokens[*pick(random, &words)];
                }
            }
        }
        if tokens.is_empty() {
            break;
        }
    }
    tokens.concat()
}

/// The text after a few edits of bytes, with invalid UTF-8 replaced.
fn by_bytes(random: &mut Random, text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        match random.below(5) {
            0 => drop(bytes.drain(at..(at + random.below(40)).min(bytes.len()))),
            1 => bytes.insert(at, random.below(0x80) as u8),
            2 => bytes[at] ^= 1 << random.below(8),
            3 => bytes.truncate(at),
            _ => bytes[at] = *pick(random, b"(){}[]<>.,;:&|!#\"'\\/+-*=_ \n0e"),
        }
        if bytes.is_empty() {
            break;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn damaged_files_are_answered() {
    const RUNS: usize = if cfg!(debug_assertions) { 600 } else { 4000 };
    let seeds = seeds();
    let mut random = Random::new(1);
    let (mut parsed, mut checked, mut compiled) = (0, 0, 0);
    let mut slowest = (std::time::Duration::ZERO, String::new());
    for run in 0..RUNS {
        let (text, other) = (pick(&mut random, &seeds), pick(&mut random, &seeds));
        let text =
            if run % 4 == 0 { by_bytes(&mut random, text) } else { by_tokens(&mut random, text, other) };
        let started = Instant::now();
        let outcome = std::panic::catch_unwind(|| {
            let source = Source::new("damaged.rs", text.as_str());
            let file = match syntax::parse(&source) {
                Ok(file) => file,
                Err(diagnostics) => {
                    assert!(diagnostics.has_errors() && !diagnostics.render(false).is_empty());
                    return 0;
                }
            };
            let outcome = match check::check(&file) {
                Ok(outcome) => outcome,
                Err(diagnostics) => {
                    assert!(diagnostics.has_errors() && !diagnostics.render(false).is_empty());
                    return 1;
                }
            };
            // Checked files are compiled too: one function each, so that the time is spent on many files.
            let names: Vec<&str> = outcome.definitions.iter().map(|d| d.name.as_str()).collect();
            let Some(name) = names.get(run % names.len().max(1)) else { return 2 };
            let compiled = compile(&source, &|wanted| wanted == *name, forcec::Effort::Default)
                .expect("what passed the check compiles");
            let file = File {
                stem: "damaged".to_owned(),
                docs: compiled.docs,
                kernels: compiled.functions.into_iter().map(|function| function.kernel).collect(),
                precisions: vec![Precision::F64],
            };
            assert!(!emit::emit(&file, Target::C).is_empty() && !emit::emit(&file, Target::Rust).is_empty());
            3
        });
        let depth = outcome.unwrap_or_else(|_| panic!("run {run} on this text:\n{text}"));
        parsed += usize::from(depth >= 1);
        checked += usize::from(depth >= 2);
        compiled += usize::from(depth >= 3);
        slowest = slowest.max((started.elapsed(), text));
    }
    println!(
        "{RUNS} texts: {parsed} parsed, {checked} checked, {compiled} compiled; slowest {:?}",
        slowest.0
    );
    assert!(parsed > RUNS / 10 && compiled > RUNS / 50, "the damage is not too great: {parsed}, {compiled}");
    assert!(slowest.0.as_secs() < 10, "{:?} on this text:\n{}", slowest.0, slowest.1);
}
