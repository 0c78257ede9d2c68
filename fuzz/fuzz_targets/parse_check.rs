//! The front end on any bytes: a tree or messages, never a panic.
#![no_main]

use forcec::internals::source::span::Source;
use forcec::internals::{check, syntax};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let source = Source::new("fuzz.rs", text);
    let outcome = syntax::parse(&source).and_then(|file| check::check(&file));
    if let Err(diagnostics) = outcome {
        assert!(diagnostics.has_errors() && !diagnostics.render(false).is_empty());
    }
});
