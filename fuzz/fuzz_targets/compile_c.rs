//! From any text to C: what passes the checks compiles.
#![no_main]

use forcec::compile::compile;
use forcec::kernel::{File, Precision, Target};
use forcec::span::Source;
use forcec::targets::emit;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let Ok(compiled) = compile(&Source::new("fuzz.rs", text), &|_| true, forcec::Effort::Quick) else { return };
    let file = File {
        stem: "fuzz".to_owned(),
        docs: compiled.docs,
        kernels: compiled.functions.into_iter().map(|function| function.kernel).collect(),
        precisions: vec![Precision::F64, Precision::F32],
    };
    for target in [Target::C, Target::Rust] {
        assert!(emit(&file, target).iter().all(|file| !file.text.is_empty()));
    }
});
