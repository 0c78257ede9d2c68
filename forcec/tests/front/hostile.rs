//! Damaged and random inputs with random options, one after another: no panic, no hang, no excessive memory
//! use.
//!
//! A few thousand inputs run with the other tests. `FORCEC_INPUTS=1000000 FORCEC_COMPILED=10000
//! FORCEC_SEED=7` runs a million inputs through the front end and ten thousand through the whole compiler.

#[path = "../../../tests/src/any_options.rs"]
mod any_options;

use super::wrong::inputs;
use any_options::any_options;
use forcec::internals::math::random::Random;
use forcec::internals::source::span::Source;
use forcec::internals::{check, syntax};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Time limit for one input.
const LONGEST: Duration = Duration::from_secs(10);

/// Memory limit of the process, in kB.
const MEMORY: u64 = 2_000_000;

/// Texts that sometimes replace a number.
const NUMBERS: [&str; 18] = [
    "0.0",
    "1.0",
    "0.5",
    "-1.0",
    "1e-300",
    "1e300",
    "5e-324",
    "1e-30",
    "1e30",
    "2",
    "7",
    "1000",
    "2147483647",
    "-3",
    "1_000_000",
    "1.0000000001",
    "PI",
    "9007199254740993.0",
];

/// Lines that are sometimes inserted, with `x` replaced by an existing name.
const LINES: [&str; 10] = [
    "let mut z = 1.1; for _i in 0..30 { z = z * z; }",
    "let mut w = 0.1; for _i in 0..2000 { w = w / 3.0 + 1.0 / 7.0; }",
    "let c = (1e-20_f64 as Real).powi(40) * 1e300;",
    "let q = (x / 1e-10).powi(50);",
    "let mut s = x; for i in 0..40 { s = s * s.sin() + (i as Real) * x; }",
    "let t = (x * 0.5).powi(2147483647);",
    "let u = x.powf(-2.5) + x.powi(-2147483648);",
    "let d = 1.0 / (x - x);",
    "let (m, n) = (x, (x, [x; 300]));",
    "return x;",
];

/// Force functions, each with the helpers and constants of its file.
fn corpus() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    for folder in ["constraints", "tests/unseen", "tests/golden"] {
        let entries = std::fs::read_dir(root.join(folder)).expect("a folder of force files");
        let mut paths: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
        paths.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
        paths.sort();
        files.extend(paths.iter().map(|path| std::fs::read_to_string(path).expect("a force file")));
    }
    files.extend(inputs::cases().into_iter().map(|(_, text)| text));
    let mut texts = Vec::new();
    for text in files {
        // Items end with a line that is a single bracket, or with a line that ends with a semicolon.
        let (mut items, mut item) = (Vec::new(), String::new());
        for line in text.lines() {
            item.push_str(line);
            item.push('\n');
            if line == "}" || line.ends_with(';') && !line.starts_with(' ') {
                items.push(std::mem::take(&mut item));
            }
        }
        items.push(item);
        let is_force = |item: &&String| ["#[con", "#[ene", "#[for"].iter().any(|mark| item.contains(mark));
        let helpers: String = items.iter().filter(|item| !is_force(item)).map(String::as_str).collect();
        texts.extend(items.iter().filter(is_force).map(|force| format!("{helpers}{force}")));
    }
    texts
}

/// Words and single characters.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let end = if word(first) { rest.find(|c| !word(c)).unwrap_or(rest.len()) } else { first.len_utf8() };
        let (token, after) = rest.split_at(end);
        tokens.push(token);
        rest = after;
    }
    tokens
}

/// An input: a force function with at most `edits` edits, parts of two functions, or random text.
fn input(corpus: &[String], edits: usize, random: &mut Random) -> String {
    let (first, second) = (&corpus[random.below(corpus.len())], &corpus[random.below(corpus.len())]);
    if edits > 2 && random.below(50) == 0 {
        let any = |random: &mut Random| char::from_u32(random.below(0x3000) as u32).unwrap_or('\u{202e}');
        return (0..random.below(200)).map(|_| any(random)).collect();
    }
    let (mut tokens, others) = (tokens(first), tokens(second));
    for _ in 0..random.below(edits + 1) {
        let (at, from) = (random.below(tokens.len()), random.below(others.len()));
        // An input to be compiled keeps its words, and gets other numbers and lines.
        match random.below(9).max(if edits > 2 { 0 } else { 5 }) {
            0 => tokens[at] = tokens[random.below(tokens.len())],
            1 => tokens.insert(at, others[from]),
            2 if tokens.len() > 1 => drop(tokens.remove(at)),
            3 => tokens[at] = others[from],
            4 => {
                let end = (from + random.below(30)).min(others.len());
                tokens.splice(at..at, others[from..end].iter().copied());
            }
            5 => {
                if let Some(line) = tokens.iter().skip(at).position(|token| *token == ";") {
                    tokens.insert(at + line + 1, LINES[random.below(LINES.len())]);
                }
            }
            _ => {
                let number = |token: &&str| token.starts_with(|c: char| c.is_ascii_digit());
                if let Some(place) = tokens.iter().skip(at).position(number) {
                    tokens[at + place] = NUMBERS[random.below(NUMBERS.len())];
                }
            }
        }
        if tokens.is_empty() {
            break;
        }
    }
    tokens.concat()
}

/// The peak memory of this process in kB, where the system reports it.
fn most_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").trim().parse().ok()).unwrap_or(0)
}

fn wanted(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

#[test]
fn hostile_inputs() {
    let (inputs, compiled) = (wanted("FORCEC_INPUTS", 4000), wanted("FORCEC_COMPILED", 150));
    let corpus = corpus();
    assert!(corpus.len() > 150);
    // The current input, and its start time: in milliseconds from the start of the test, 0 for no input.
    let (current, since, started) = (Mutex::new(String::new()), AtomicU64::new(0), Instant::now());
    let now = || started.elapsed().as_millis() as u64 + 1;
    let (mut faults, mut slowest, mut passed) = (Vec::new(), (Duration::ZERO, String::new()), 0);
    let mut random = Random::new(wanted("FORCEC_SEED", 5));
    let done = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(20));
                let begun = since.load(Ordering::Relaxed);
                let (hangs, floods) =
                    (begun > 0 && now() - begun > 3 * LONGEST.as_millis() as u64, most_memory() > MEMORY);
                if hangs || floods {
                    // A thread cannot be stopped from outside.
                    eprintln!("hangs: {hangs}, floods: {floods}\n{}", current.lock().expect("a text"));
                    std::process::exit(101);
                }
            }
        });
        // A thread keeps all texts that the thread has parsed.
        let all = inputs + compiled;
        (0..all).step_by(1000).for_each(|first| {
            syntax::with_deep_stack(|| {
                for number in first..(first + 1000).min(all) {
                    let whole = number >= inputs;
                    let text = input(&corpus, if whole { 2 } else { 6 }, &mut random);
                    let options = any_options(&text, &mut |n| random.below(n));
                    *current.lock().expect("a text") = format!("{text}\n{options:?}");
                    since.store(now(), Ordering::Relaxed);
                    let begun = Instant::now();
                    let outcome = catch_unwind(AssertUnwindSafe(|| match whole {
                        true => forcec::compile(&text, &options).map(|_| ()),
                        false => syntax::parse(&Source::new("any.rs", text.as_str()))
                            .and_then(|file| check::check(&file))
                            .map(|_| ()),
                    }));
                    let time = begun.elapsed();
                    since.store(0, Ordering::Relaxed);
                    if time > slowest.0 {
                        slowest = (time, text.clone());
                    }
                    match outcome {
                        Err(_) => faults.push(format!("panics:\n{text}\n{options:?}")),
                        Ok(_) if time > LONGEST => {
                            faults.push(format!("takes {time:?}:\n{text}\n{options:?}"))
                        }
                        Ok(Err(errors)) => assert!(errors.has_errors() && !errors.to_string().is_empty()),
                        Ok(Ok(())) => passed += 1,
                    }
                    if number % 10_000 == 9_999 {
                        let (count, memory) = (faults.len(), most_memory());
                        eprintln!(
                            "{number}: {passed} pass, {count} faults, {memory} kB, slowest {:?}",
                            slowest.0
                        );
                    }
                }
            })
        });
        done.store(true, Ordering::Relaxed);
    });
    eprintln!("{passed} of {} pass; the slowest takes {:?}:\n{}", inputs + compiled, slowest.0, slowest.1);
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults[..faults.len().min(20)].join("\n\n"));
}
