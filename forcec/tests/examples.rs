//! The examples: the commands of their READMEs run in a copy of the folder, or in the folder itself if cargo builds it,
//! and print the documented output.

#![cfg(feature = "cli")]

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The text of a fenced block.
fn block<'a>(readme: &'a str, language: &str) -> &'a str {
    let (_, rest) =
        readme.split_once(&format!("```{language}\n")).unwrap_or_else(|| panic!("no {language} block"));
    rest.split_once("```").expect("the block ends").0
}

/// Runs the commands of an example's README in a folder, with this forcec first on the path, and compares the
/// output.
fn follow(name: &str, folder: &Path) {
    let readme = std::fs::read_to_string(root().join("examples").join(name).join("README.md")).unwrap();
    let own = Path::new(env!("CARGO_BIN_EXE_forcec")).parent().unwrap();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::iter::once(own.to_owned()).chain(std::env::split_paths(&path));
    let output = Command::new("sh")
        .args(["-e", "-c", block(&readme, "sh")])
        .current_dir(folder)
        .env("PATH", std::env::join_paths(path).unwrap())
        .env("CARGO_NET_OFFLINE", "true")
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}:\n{printed}{errors}");
    assert!(!errors.contains("warning"), "{name}:\n{errors}");
    let expected = block(&readme, "text");
    assert!(printed.ends_with(expected), "{name} prints\n{printed}and its README says\n{expected}");
}

/// A copy of an example's folder.
fn copy(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("examples").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    for entry in std::fs::read_dir(root().join("examples").join(name)).unwrap() {
        let entry = entry.unwrap();
        if entry.path().is_file() {
            std::fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
        }
    }
    folder
}

#[test]
fn command_line_to_c() {
    follow("c", &copy("c"));
}

#[test]
fn command_line_to_cpp() {
    follow("cpp", &copy("cpp"));
}

#[test]
fn scene() {
    follow("scene", &copy("scene"));
}

#[test]
fn attribute() {
    follow("attribute", &root().join("examples/attribute"));
}

#[test]
fn build_script() {
    follow("build-script", &root().join("examples/build-script"));
}

/// A mistake in a force file is shown by cargo at its place, with what to write.
#[test]
fn a_build_script_shows_mistakes_as_cargo_does() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("examples/mistake");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("forces")).unwrap();
    std::fs::create_dir_all(folder.join("src")).unwrap();
    let example = root().join("examples/build-script").canonicalize().unwrap();
    let repository = root().canonicalize().unwrap();
    let manifest = std::fs::read_to_string(example.join("Cargo.toml")).unwrap();
    let path = format!("\"{}/forcec\"", repository.display());
    let manifest = manifest.replace("\"../../forcec\"", &path) + "\n[workspace]\n";
    std::fs::write(folder.join("Cargo.toml"), manifest).unwrap();
    std::fs::copy(repository.join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
    for file in ["build.rs", "src/main.rs"] {
        std::fs::copy(example.join(file), folder.join(file)).unwrap();
    }
    let force = std::fs::read_to_string(example.join("forces/bands.rs")).unwrap();
    std::fs::write(folder.join("forces/bands.rs"), force.replace("norm_squared", "nrom_squared")).unwrap();
    let output = Command::new("cargo")
        .args(["build", "--offline", "--target-dir"])
        .arg(repository.join("target"))
        .current_dir(&folder)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "{errors}");
    println!("{errors}");
    let shown =
        "error: forcec-example-build-script@0.1.0: forces/bands.rs:14:30: unknown method `nrom_squared`";
    assert!(errors.contains(shown), "{errors}");
    assert!(errors.contains("did you mean `norm_squared`?"), "{errors}");
}
