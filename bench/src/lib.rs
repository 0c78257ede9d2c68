//! Shared code of the benchmarks: texts to compile, the library and force files of any size, kernel timing,
//! and scenes.
//!
//! The benchmark `compile_time` and the test `time_per_node` both read them.

pub mod catalogue;
pub mod count;
pub mod document;
pub mod kernels;
pub mod layouts;
pub mod machine;
pub mod modes;
pub mod peers;
pub mod picture;
mod plot;
pub mod run;
pub mod scenes;
pub mod sleeping;
pub mod work_precision;
pub mod yardsticks;

use forcec::internals::compile::{Compiled, compile};
use forcec::internals::source::span::Source;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Does work whose islands are distributed over `threads` threads; without the feature `rayon` there is only
/// one thread.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    #[cfg(feature = "rayon")]
    {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads of this machine").install(work)
    }
    #[cfg(not(feature = "rayon"))]
    {
        let _ = threads;
        work()
    }
}

/// Writes a file; the message names it.
pub fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// A folder to build in, while something works in it.
pub fn in_folder<T>(name: &str, work: impl FnOnce(&Path) -> T) -> Result<T, String> {
    let folder = std::env::temp_dir().join(format!("forcec-{name}-{}", std::process::id()));
    let result = work(&folder);
    std::fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(result)
}

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
    match compile(source, &|_| true, forcec::Effort::Default) {
        Ok(compiled) => compiled,
        Err(diagnostics) => panic!("{diagnostics}"),
    }
}

/// Every helper takes all parameters, so the work of the front end is the number of parameters times the calls.
const MOST_PARAMETERS: usize = 200;

/// Helper functions that call each other, ten in a row, and an energy that is the sum of
/// their values, each for a particle's position and a parameter. The kernel of this force file has about 46 nodes per
/// link.
pub fn chain(links: usize) -> Source {
    let parameters = (links / 4).clamp(1, MOST_PARAMETERS);
    let mut text = String::from("//! Chains of helper functions.\n\n");
    let mut energy = String::from("0.0");
    for k in 0..links {
        // No two links are the same.
        let (c, d) = (k / parameters + 2, k % 5 + 3);
        let before = if k % 10 == 0 { "0.0".to_owned() } else { format!("link_{}(x, s)", k - 1) };
        let _ = writeln!(
            text,
            "fn link_{k}(x: Vec3, s: [Vec3; {parameters}]) -> Real {{\n    \
             let y = x.cross(&s[{}]) + Vec3::new(x.y * x.z, {c}.0 * x.x, {d}.0);\n    \
             {before} + (1.0 + y.norm_squared()).sqrt()\n}}\n",
            k % parameters
        );
        if k % 10 == 9 || k + 1 == links {
            energy.push_str(&format!(";\n    let energy = energy + link_{k}(p.position, s)"));
        }
    }
    let _ = writeln!(
        text,
        "#[energy]\npub fn chain(p: Particle, s: [Vec3; {parameters}]) -> Real {{\n    let energy = {energy};\n    energy\n}}"
    );
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
