//! Texts to compile: the library, and force files of any size.
//!
//! The benchmark `compile_time` and the test `time_per_node` both read them.

use forcec::compile::{Compiled, compile};
use forcec::span::Source;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The force files of the library, in sorted order.
pub fn library() -> Vec<Source> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../constraints");
    let entries = std::fs::read_dir(&folder).expect("the folder of the library");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry of it").path()).collect();
    paths.sort();
    let read = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).expect("a force file");
        Source::new(path.file_name().unwrap_or_default().to_string_lossy(), text)
    };
    paths.iter().filter(|path| path.extension().is_some_and(|ending| ending == "rs")).map(read).collect()
}

/// Compiles everything in a source.
pub fn compile_all(source: &Source) -> Compiled {
    match compile(source, &|_| true) {
        Ok(compiled) => compiled,
        Err(diagnostics) => panic!("{diagnostics}"),
    }
}

/// A chain of helper functions over one particle, and an energy that adds up what each of them makes of the last:
/// a force file whose kernel grows in proportion to `links`.
///
/// Every link is a bounded, smooth function of a position and of its parameter, so that neither the text nor the
/// numbers in it give the optimiser a way out.
pub fn chain(links: usize) -> Source {
    let mut text = String::from("//! A chain of helper functions.\n\n");
    for k in 0..links {
        let (c, d) = (k % 7 + 2, k % 5 + 3);
        let _ = writeln!(
            text,
            "fn link_{k}(x: Vec3, s: Real) -> Vec3 {{\n    let y = x * s + Vec3::new(x.y * x.z, {c}.0 * x.x, s);\n    \
             y / (1.0 + y.norm_squared() / {d}.0).sqrt()\n}}\n"
        );
    }
    let parameters = (links / 4).max(1);
    let _ = writeln!(text, "#[energy]\npub fn chain(p: Particle, s: [Real; {parameters}]) -> Real {{");
    text.push_str("    let x = p.position;\n    let mut energy = 0.0;\n");
    for k in 0..links {
        let _ = writeln!(
            text,
            "    let x = link_{k}(x, s[{}]);\n    energy += x.norm_squared();",
            k % parameters
        );
    }
    text.push_str("    energy\n}\n");
    Source::new("chain.rs", text)
}

/// How many scalar nodes the kernels have.
pub fn nodes(compiled: &Compiled) -> usize {
    compiled
        .functions
        .iter()
        .map(|function| function.program.live().iter().filter(|live| **live).count())
        .sum()
}
