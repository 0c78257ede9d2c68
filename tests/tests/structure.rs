//! The order of the stages, read from the sources: no folder imports itself through others; and files stay
//! short.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Largest allowed number of lines per file.
const LONGEST: usize = 700;

/// The crates with ordered folders, and the smallest number of files of each crate.
const CRATES: [(&str, usize); 2] = [("forcec", 50), ("runtime", 15)];

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src")
}

/// Every Rust file, with its path from the source folder.
fn files(name: &str, least: usize) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut pending = vec![source(name)];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let name = path.strip_prefix(source(name)).unwrap().to_string_lossy().replace('\\', "/");
                found.insert(name, std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    assert!(found.len() > least, "the sources are where they are expected");
    found
}

/// The module of the crate's root that a file belongs to.
fn module(file: &str) -> &str {
    file.split('/').next().unwrap().trim_end_matches(".rs")
}

/// A file's text without comments; string literals of these crates contain no `//` before a path.
fn code(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The modules of the crate's root that a file names, in `use` items and anywhere else.
fn imports(file: &str, text: &str) -> BTreeSet<String> {
    let code = code(text);
    let mut found = BTreeSet::new();
    // From a file directly below the root `super` is the root.
    let roots: &[&str] =
        if file.contains('/') && !file.ends_with("/mod.rs") { &["crate::"] } else { &["crate::", "super::"] };
    for (root, at) in roots.iter().flat_map(|root| code.match_indices(root).map(|(at, _)| (root.len(), at))) {
        let rest = &code[at + root..];
        let names = match rest.strip_prefix('{') {
            None => vec![rest],
            // For a list, the part of each item before the first inner bracket or path separator.
            Some(list) => parts(list),
        };
        for name in names {
            let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
            found.insert(name[..end].to_owned());
        }
    }
    found.remove(module(file));
    found
}

/// The parts of a list up to its closing bracket.
fn parts(list: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (at, character) in list.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth == 0 => {
                parts.push(list[start..at].trim());
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(list[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}

#[test]
fn imports_are_found() {
    let text = "use crate::{check, syntax::{a, b}};\nuse crate::scalar::Id; // use crate::comment\nfn f() { crate::text::g() }";
    let names = ["check", "scalar", "syntax", "text"].map(str::to_owned);
    assert_eq!(imports("optimize/mod.rs", text), names.into());
    assert_eq!(imports("text.rs", "use super::cli;"), ["cli".to_owned()].into());
    assert!(imports("cli/show.rs", "use super::print;").is_empty());
}

/// A folder is removed once all its imports are removed; the remaining folders import each other in a circle.
#[test]
fn no_folder_imports_itself_over_others() {
    for (name, least) in CRATES {
        let mut imported: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
        let files = files(name, least);
        let folders: BTreeSet<&str> = files.keys().map(|file| module(file)).collect();
        for (file, text) in files.iter().filter(|(file, _)| !matches!(module(file), "lib" | "main")) {
            let found = imported.entry(module(file).to_owned()).or_default();
            // Names in the crate root are re-exports of types from folders.
            let inner = imports(file, text).into_iter().filter(|name| folders.contains(name.as_str()));
            found.extend(inner.map(|name| (name, file.clone())));
        }
        while let Some(done) =
            imported.iter().find(|(_, imports)| imports.is_empty()).map(|(name, _)| name.clone())
        {
            imported.remove(&done);
            imported.values_mut().for_each(|imports| drop(imports.remove(&done)));
        }
        assert!(imported.is_empty(), "folders of {name} that import each other: {imported:#?}");
    }
}

#[test]
fn files_are_short_and_say_what_they_do() {
    for (name, least) in CRATES {
        for (file, text) in files(name, least) {
            let lines = text.lines().count();
            assert!(
                lines <= LONGEST,
                "{name}/src/{file} has {lines} lines; more than {LONGEST} are too many to read"
            );
            assert!(
                text.starts_with("//! "),
                "{name}/src/{file} does not begin with a comment on its inputs and outputs"
            );
        }
    }
}
