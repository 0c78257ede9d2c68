//! The invalid and suspicious inputs of `tests/wrong`.
//!
//! A file has many cases, each below a line `// case: NAME`; a blank line separates cases. A line that starts with
//! `//~` is not part of a case: such lines state the diagnostics of the line above. `renderings/NAME.rs` is a case by
//! itself.
//!
//! One file for this package and for the tests of `forcec`, which name it by its path.

use std::path::{Path, PathBuf};

/// The line break that ends a case, and the start of the next case.
pub const SEPARATOR: &str = "\n// case: ";

/// The force files of `tests/wrong` or of a folder in it, in alphabetical order.
pub fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/wrong").join(folder);
    let entries = std::fs::read_dir(folder).expect("a folder of force files");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a folder can be read").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
    paths.sort();
    paths
}

/// A case without its annotations.
pub fn stripped(annotated: &str) -> String {
    annotated.split_inclusive('\n').filter(|line| !line.starts_with("//~")).collect()
}

/// The name and the text of every case.
pub fn cases() -> Vec<(String, String)> {
    let read = |path: &PathBuf| std::fs::read_to_string(path).expect("a force file");
    let mut cases = Vec::new();
    for path in files("") {
        let text = read(&path);
        let named = text.split(SEPARATOR).skip(1).filter_map(|case| case.split_once('\n'));
        cases.extend(named.map(|(name, annotated)| (name.to_owned(), stripped(annotated))));
    }
    let stem = |path: &PathBuf| path.file_stem().expect("a file has a name").to_string_lossy().into_owned();
    cases.extend(files("renderings").iter().map(|path| (stem(path), read(path))));
    cases
}
