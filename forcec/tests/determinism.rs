//! The same input gives the same bytes: two copies of the library in different folders, compiled from different working
//! folders with different environment variables.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn library() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../constraints")
}

/// A copy of the library under a folder of its own, which is returned.
fn checkout(folder: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("determinism").join(folder);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("constraints")).unwrap();
    for entry in fs::read_dir(library()).unwrap() {
        let entry = entry.unwrap();
        if entry.path().extension().is_none_or(|ending| ending != "rs") {
            continue;
        }
        fs::copy(entry.path(), folder.join("constraints").join(entry.file_name())).unwrap();
    }
    folder
}

fn build(from: &Path, input: &Path, out: &Path, environment: (&str, &str)) -> BTreeMap<String, Vec<u8>> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_forcec"));
    command.current_dir(from).env(environment.0, environment.1).arg("build").arg(input).arg("--out").arg(out);
    for option in ["--target", "c", "--target", "rust", "--real", "f64", "--real", "f32"] {
        command.arg(option);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let entries = fs::read_dir(from.join(out)).unwrap().map(|entry| entry.unwrap());
    entries.map(|e| (e.file_name().to_string_lossy().into_owned(), fs::read(e.path()).unwrap())).collect()
}

#[test]
fn two_checkouts_make_the_same_bytes() {
    let (one, two) = (checkout("one"), checkout("another/much deeper/checkout"));
    let first = build(&one, Path::new("constraints"), Path::new("out"), ("TZ", "UTC"));
    let second = build(
        &two.join("constraints"),
        &two.join("constraints"),
        Path::new("../generated/kernels"),
        ("RUST_BACKTRACE", "full"),
    );
    assert_eq!(first.keys().collect::<Vec<_>>(), second.keys().collect::<Vec<_>>());
    assert!(first.len() > 3 * 5, "C and Rust of every file of the library");
    for (name, bytes) in &first {
        assert!(bytes == &second[name], "`{name}` differs between the checkouts");
        let text = String::from_utf8_lossy(bytes);
        for trace in ["determinism", "constraints/", env!("CARGO_MANIFEST_DIR")] {
            assert!(!text.contains(trace), "`{name}` says where its source lies: `{trace}`");
        }
    }
}

#[test]
fn a_file_alone_makes_what_it_makes_in_company() {
    let folder = checkout("alone");
    let together = build(&folder, Path::new("constraints"), Path::new("together"), ("A", "B"));
    let alone = build(&folder, Path::new("constraints/joints.rs"), Path::new("alone"), ("A", "B"));
    assert!(alone.len() == 4);
    for (name, bytes) in alone {
        assert!(bytes == together[&name], "`{name}` depends on the other files of the build");
    }
}
