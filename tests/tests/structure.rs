//! The pipeline order, read off the sources: no stage imports a later one, and files stay readable.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What every stage speaks: these modules import each other and no stage.
const VOCABULARY: [&str; 23] = [
    "bodies",
    "definition",
    "diagnostic",
    "eval",
    "exact",
    "identifiers",
    "identities",
    "layouts",
    "number",
    "ops",
    "options",
    "outputs",
    "places",
    "plan",
    "scalar",
    "span",
    "special",
    "specialize",
    "states",
    "suggest",
    "valuation",
    "vector",
    "verify",
];

/// The pipeline, in order: a module, and the earlier ones that it imports besides the vocabulary.
const PIPELINE: [(&str, &[&str]); 21] = [
    ("syntax", &[]),
    ("check", &["syntax"]),
    ("derive", &[]),
    ("formula", &["derive"]),
    ("text", &["derive", "formula"]),
    ("optimize", &["derive"]),
    ("prepare", &[]),
    ("schedule", &[]),
    ("kernel", &["schedule"]),
    ("rounding", &["kernel"]),
    ("targets", &["kernel", "rounding", "schedule"]),
    ("compile", &["syntax", "check", "derive", "formula", "optimize", "prepare", "schedule", "kernel"]),
    ("library", &["kernel", "targets", "compile"]),
    ("ties", &["kernel", "targets", "compile"]),
    ("manifest", &[]),
    ("expand", &["syntax", "kernel", "targets", "compile", "ties", "manifest"]),
    ("files", &["syntax", "kernel", "targets", "compile"]),
    ("scene", &["syntax", "check", "compile", "files"]),
    ("build", &["kernel", "compile", "files", "scene"]),
    ("lint", &["derive", "optimize"]),
    (
        "cli",
        &[
            "syntax", "check", "derive", "formula", "text", "optimize", "schedule", "kernel", "targets",
            "compile", "files", "scene", "lint", "rounding",
        ],
    ),
];

/// A stage may speak to one thing of a later one, or of one that stands beside it; each with its reason.
const EXCEPTIONS: [(&str, &str); 1] = [
    // What a kernel is off by is measured in the numbers of the checks; what is printed does without.
    ("rounding/observed.rs", "verify"),
];

/// Lines a file may have.
const LONGEST: usize = 700;

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../forcec/src")
}

/// Every Rust file, with its path from the source folder.
fn files() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut pending = vec![source()];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let name = path.strip_prefix(source()).unwrap().to_string_lossy().replace('\\', "/");
                found.insert(name, std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    assert!(found.len() > 50, "the sources are where they are expected");
    found
}

/// The module of the crate's root that a file belongs to.
fn module(file: &str) -> &str {
    file.split('/').next().unwrap().trim_end_matches(".rs")
}

/// A file's text without comments; our strings hold no `//` before a path.
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
            // Of a list, what stands before its first inner bracket or path in each part.
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

#[test]
fn every_module_has_a_place() {
    let text = &files()["lib.rs"];
    let declared: BTreeSet<&str> = text
        .lines()
        .filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';'))
        .collect();
    let known = VOCABULARY.into_iter().chain(PIPELINE.map(|(name, _)| name)).collect();
    assert_eq!(declared, known, "modules of the crate, and those of the lists in this test");
}

#[test]
fn no_stage_imports_a_later_one() {
    for (index, (stage, imported)) in PIPELINE.iter().enumerate() {
        let earlier: Vec<&str> = PIPELINE[..index].iter().map(|(name, _)| *name).collect();
        for name in *imported {
            assert!(
                earlier.contains(name),
                "the list says that `{stage}` imports `{name}`, which is not earlier"
            );
        }
    }
    let mut violations = Vec::new();
    for (file, text) in files() {
        let module = module(&file);
        if matches!(module, "lib" | "main") {
            continue;
        }
        let stage = PIPELINE.iter().find(|(name, _)| *name == module);
        for import in imports(&file, &text) {
            let stages = PIPELINE.iter().any(|(name, _)| *name == import);
            let listed = stage.is_some_and(|(_, imported)| imported.contains(&import.as_str()));
            // The command line is the only door to the checks; advice draws its states there.
            let checks = import == "verify" && !matches!(module, "cli" | "lint");
            let excepted = EXCEPTIONS.contains(&(file.as_str(), import.as_str()));
            if (stages && !listed || checks) && !excepted {
                violations.push(format!("forcec/src/{file} imports `{import}`"));
            }
        }
    }
    assert!(violations.is_empty(), "against the order of the pipeline:\n{}", violations.join("\n"));
}

/// What the lists allow is needed: otherwise they say nothing.
#[test]
fn every_listed_import_is_used() {
    let files = files();
    for (stage, imported) in PIPELINE.iter().filter(|(stage, _)| *stage != "cli") {
        let used: BTreeSet<String> = files
            .iter()
            .filter(|(file, _)| module(file) == *stage)
            .flat_map(|(file, text)| imports(file, text))
            .collect();
        for name in *imported {
            assert!(used.contains(*name), "`{stage}` does not import `{name}`: remove it from the list");
        }
    }
}

#[test]
fn files_are_short_and_say_what_they_do() {
    for (file, text) in files() {
        let lines = text.lines().count();
        assert!(
            lines <= LONGEST,
            "forcec/src/{file} has {lines} lines; more than {LONGEST} are too many to read"
        );
        assert!(text.starts_with("//! "), "forcec/src/{file} does not begin with what it takes and returns");
    }
}
