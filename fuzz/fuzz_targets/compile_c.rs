//! From any text and any options to kernels: what passes the checks compiles, whatever is asked for.
#![no_main]

#[path = "../../tests/src/any_options.rs"]
mod any_options;

use forcec::Options;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: (Vec<u8>, &str)| {
    let (bytes, text) = input;
    let mut bytes = bytes.into_iter();
    let mut draw = |n: usize| bytes.next().map_or(0, usize::from) % n;
    for options in [Options::default(), any_options::any_options(text, &mut draw)] {
        match forcec::compile(text, &options) {
            Ok(compiled) => assert!(compiled.kernels.iter().all(|(_, kernel)| !kernel.is_empty())),
            Err(errors) => assert!(errors.has_errors() && !errors.render(false).is_empty()),
        }
    }
});
