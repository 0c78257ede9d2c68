//! The command line from the user's side: the real program on real files, with exit codes, messages and
//! guarantees.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const SPRING: &str =
    "#[energy]\npub fn spring(p: Particle, k: Real) -> Real {\n    k * p.position.norm_squared()\n}\n";
const DRAG: &str = "#[force]\npub fn drag(p: Particle, c: Real) -> Vec3 {\n    -c * p.velocity\n}\n";
const WRONG: &str = "#[energy]\npub fn wrong(p: Particle) -> Real {\n    p.position.nrom()\n}\n";

/// A folder for one test, empty at the start.
struct Place {
    folder: PathBuf,
}

/// The result of one run.
struct Run {
    code: i32,
    out: String,
    err: String,
}

impl Place {
    fn new(name: &str) -> Place {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("command_line").join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Place { folder }
    }

    fn write(&self, path: &str, text: impl AsRef<[u8]>) -> &Place {
        let path = self.folder.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
        self
    }

    fn read(&self, path: &str) -> String {
        fs::read_to_string(self.folder.join(path)).unwrap()
    }

    /// The files in a folder, including hidden files; empty if the folder does not exist.
    fn files(&self, path: &str) -> Vec<String> {
        let Ok(entries) = fs::read_dir(self.folder.join(path)) else { return Vec::new() };
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_forcec"));
        command.args(line.split_whitespace()).current_dir(&self.folder).stdin(Stdio::null());
        command
    }

    fn run(&self, line: &str) -> Run {
        let Output { status, stdout, stderr } = self.command(line).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        let run = Run { code: status.code().expect("an exit code"), out: text(stdout), err: text(stderr) };
        assert!(!run.err.contains("panicked"), "{line}\n{}", run.err);
        assert!(!run.err.contains('\x1b') && !run.out.contains('\x1b'), "colours without a terminal: {line}");
        run
    }

    fn succeeds(&self, line: &str) -> Run {
        let run = self.run(line);
        assert_eq!(run.code, 0, "{line}\n{}", run.err);
        run
    }

    /// Runs a command that must fail with exit code 2 and print nothing to standard output; returns the
    /// message.
    fn refused(&self, line: &str) -> String {
        let run = self.run(line);
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{line}\n{}", run.err);
        run.err
    }
}

/// Asserts that a text contains these parts in this order.
fn assert_has(text: &str, parts: &[&str]) {
    let mut rest = text;
    for part in parts {
        let at = rest.find(part).unwrap_or_else(|| panic!("no `{part}` here, or too early:\n{text}"));
        rest = &rest[at + part.len()..];
    }
}

/// Whether file permissions restrict this process; permissions do not restrict root.
fn bound_by_permissions(folder: &Path) -> bool {
    fs::write(folder.join("probe"), "").is_err()
}

#[cfg(unix)]
fn set_mode(path: &Path, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

// ---- help and usage

#[test]
fn help_and_version_go_to_standard_output() {
    let place = Place::new("help");
    let help = place.succeeds("--help");
    assert_has(
        &help.out,
        &["build", "check", "lint", "show", "stats", "completions", "Examples:", "forcec build"],
    );
    assert_eq!(help.err, "");
    for command in ["build", "check", "lint", "show", "stats", "completions"] {
        assert_has(&place.succeeds(&format!("{command} --help")).out, &["Usage: forcec", "Example:"]);
    }
    let version = place.succeeds("--version").out;
    assert_eq!(version, format!("forcec {}\n", env!("CARGO_PKG_VERSION")));
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert_has(&place.succeeds(&format!("completions {shell}")).out, &["forcec"]);
    }
}

#[test]
fn bad_usage_is_refused() {
    let place = Place::new("usage");
    place.write("a.rs", SPRING);
    for line in [
        "",
        "biuld a.rs",
        "build",
        "build a.rs",
        "build a.rs --out o --target fortran",
        "build a.rs --out o --real f16",
        "show a.rs spring",
        "show a.rs spring --stage shcedule",
        "stats --jsno a.rs",
        "completions tcl",
    ] {
        place.refused(line);
    }
    assert_has(&place.refused("biuld a.rs"), &["build"]);
    assert!(place.files("o").is_empty());
}

// ---- build

#[test]
fn build_writes_the_files_of_each_target() {
    let place = Place::new("build");
    place.write("forces/spring.rs", SPRING);
    place.succeeds("build forces/spring.rs --out c");
    assert_eq!(place.files("c"), ["forcec.h", "spring.c", "spring.h"]);
    assert_has(&place.read("c/spring.h"), &["spring_f64"]);
    assert!(!place.read("c/spring.h").contains("spring_f32"));
    place.succeeds("build forces --out both/deep --target rust --target c --real f32 --real f64");
    assert_eq!(place.files("both/deep"), ["forcec.h", "spring.c", "spring.h", "spring.rs"]);
    assert_has(&place.read("both/deep/spring.h"), &["spring_f64", "spring_f32"]);
    let run = place.succeeds("build forces --out both/deep --target rust --target c --real f64 --real f32");
    assert_eq!((run.out.as_str(), run.err.as_str()), ("", ""));
    assert_eq!(place.read("c/forcec.h"), place.read("both/deep/forcec.h"));
}

#[test]
fn build_check_compares_and_writes_nothing() {
    let place = Place::new("build_check");
    place.write("spring.rs", SPRING);
    let missing = place.run("build spring.rs --out out --check");
    assert_eq!((missing.code, missing.out.as_str()), (1, ""));
    assert_has(
        &missing.err,
        &["out/forcec.h is missing", "out/spring.c is missing", "out/spring.h is missing"],
    );
    assert!(!place.folder.join("out").exists());
    place.succeeds("build spring.rs --out out");
    let equal = place.succeeds("build spring.rs --out out --check");
    assert_eq!((equal.out.as_str(), equal.err.as_str()), ("", ""));
    place.write("out/spring.c", "/* mine */");
    let differs = place.run("build spring.rs --out out --check");
    assert_eq!((differs.code, differs.err.as_str()), (1, "out/spring.c differs\n"));
    assert_eq!(place.read("out/spring.c"), "/* mine */");
    place.write("out/spring.c", b"\xff\xfe");
    assert_eq!(place.run("build spring.rs --out out --check").err, "out/spring.c differs\n");
    fs::remove_file(place.folder.join("out/spring.h")).unwrap();
    place.write("out/spring.h/x", "");
    assert_has(&place.run("build spring.rs --out out --check").err, &["out/spring.h cannot be read"]);
}

#[test]
fn an_unchanged_file_is_not_written_again() {
    let place = Place::new("unchanged");
    place.write("spring.rs", SPRING).succeeds("build spring.rs --out out");
    let written = || fs::metadata(place.folder.join("out/spring.c")).unwrap().modified().unwrap();
    let first = written();
    std::thread::sleep(std::time::Duration::from_millis(20));
    place.succeeds("build spring.rs --out out");
    assert_eq!(written(), first);
}

#[test]
fn a_failing_build_leaves_the_old_files() {
    let place = Place::new("atomic");
    place.write("forces/spring.rs", SPRING).succeeds("build forces --out out");
    let old = place.read("out/spring.c");
    place.write("forces/spring.rs", SPRING.replace("k *", "2.0 * k *")).write("forces/wrong.rs", WRONG);
    place.refused("build forces --out out");
    assert_eq!(place.read("out/spring.c"), old);
    assert_eq!(place.files("out"), ["forcec.h", "spring.c", "spring.h"]);
    // A folder has the name of one output file: no output file is replaced, and no temporary file is left
    // behind.
    fs::remove_file(place.folder.join("forces/wrong.rs")).unwrap();
    place.write("forces/tail.rs", DRAG).write("out/tail.h/x", "");
    assert_has(&place.refused("build forces --out out"), &["cannot write `out/tail.h`"]);
    assert_eq!(place.read("out/spring.c"), old);
    assert_eq!(place.files("out"), ["forcec.h", "spring.c", "spring.h", "tail.h"]);
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let place = Place::new("unwritable");
    place.write("spring.rs", SPRING).write("file", "");
    assert_has(
        &place.refused("build spring.rs --out file"),
        &["error: cannot write `file`: not a directory"],
    );
    assert_has(&place.refused("build spring.rs --out file/deep"), &["error: cannot write `file/deep`: "]);
    #[cfg(unix)]
    {
        fs::create_dir(place.folder.join("locked")).unwrap();
        set_mode(&place.folder.join("locked"), 0o555);
        if bound_by_permissions(&place.folder.join("locked")) {
            assert_has(
                &place.refused("build spring.rs --out locked"),
                &["cannot write `locked/", "ermission"],
            );
        }
        set_mode(&place.folder.join("locked"), 0o755);
    }
}

// ---- files that are not overwritten

/// Every file below a folder, with its contents.
fn texts(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(folder) = pending.pop() {
        for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            match fs::read(&entry) {
                Ok(text) => found.push((entry, text)),
                Err(_) => pending.push(entry),
            }
        }
    }
    found.sort();
    found
}

#[test]
fn no_output_replaces_an_input() {
    let place = Place::new("inputs");
    place.write("a.rs", SPRING).write("f/a.rs", SPRING).write("f/deep/b.rs", DRAG);
    place.write("s/a.rs", SPRING).write(
        "s/scene.toml",
        "forces = \"a.rs\"\nout = \".\"\ntarget = \"rust\"\n[[kernel]]\nfunction = \"spring\"\n",
    );
    let mut lines = vec![
        "build a.rs --out . --target rust",
        "build a.rs --out ./f/.. --target rust --target c",
        "build f/deep/../a.rs --out f --target rust",
        "build f --out f --target rust",
        "build f/deep --out f/deep --target rust",
        "build --scene s/scene.toml",
        "build --scene s/scene.toml --out s/../s",
        "build a.rs --out . --target rust --check",
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("f", place.folder.join("link")).unwrap();
        fs::create_dir(place.folder.join("o")).unwrap();
        std::os::unix::fs::symlink("../a.rs", place.folder.join("o/a.rs")).unwrap();
        fs::create_dir(place.folder.join("h")).unwrap();
        fs::hard_link(place.folder.join("a.rs"), place.folder.join("h/a.rs")).unwrap();
        lines.extend([
            "build f --out link --target rust",
            "build link/a.rs --out f --target rust",
            "build a.rs --out o --target rust",
            "build o/a.rs --out . --target rust",
            "build a.rs --out h --target rust",
        ]);
    }
    let before = texts(&place.folder);
    for line in lines {
        assert_has(
            &place.refused(line),
            &["error: the output `", "` is the input `", "= help: write into another folder"],
        );
        assert_eq!(texts(&place.folder), before, "{line}");
    }
    for out in [".", "./f/.."] {
        let build = forcec::Build::new().input(place.folder.join("a.rs")).out(place.folder.join(out));
        assert_has(&build.try_run().unwrap_err().to_string(), &["a.rs` is the input `"]);
    }
    let mut command = place.command("build a.rs --target rust --out");
    assert_eq!(command.arg(&place.folder).output().unwrap().status.code(), Some(2));
    assert_eq!(texts(&place.folder), before);
}

#[test]
fn no_output_replaces_what_forcec_did_not_make() {
    let place = Place::new("foreign");
    place
        .write("a.rs", SPRING)
        .write("a_packed.rs", SPRING)
        .write("main.rs", DRAG)
        .write("main.c", "int main(void) { return 0; }\n");
    place.write("forcec.h", "/* @generated by forcec 0.1.0, I think. */\n");
    place.write("late/a.c", "/* mine */\n/*\n * @generated by forcec 0.1.0 from a.rs. Do not edit.\n */\nint x;\n/*\n * @generated by forcec 0.1.0 from a.rs. Do not edit.\n */\n");
    place.write("late/a.h", b"\xff\xfe");
    let before = texts(&place.folder);
    for (line, file) in [
        ("build a.rs --out . --target rust --layout packed", "./a_packed.rs"),
        ("build main.rs --out .", "./main.c"),
        ("build a.rs --out .", "./forcec.h"),
        ("build a.rs --out late", "late/a.h"),
    ] {
        let help = "= help: write into another folder, or move the file away";
        assert_has(&place.refused(line), &[&format!("error: `{file}` was not made by forcec"), help]);
        assert_eq!(texts(&place.folder), before, "{line}");
    }
    let build = |file: &str| forcec::Build::new().input(place.folder.join(file)).out(place.folder.join("r"));
    place.write("r/mod.rs", "pub mod mine;\n").write("r/mine.rs", "");
    assert_has(&build("a.rs").try_run().unwrap_err().to_string(), &["mod.rs` was not made by forcec"]);
    assert_eq!(place.files("r"), ["mine.rs", "mod.rs"]);
    fs::remove_file(place.folder.join("r/mod.rs")).unwrap();
    // Generated files, a generated list of modules and empty files are replaced.
    build("a.rs").try_run().unwrap();
    place.write("r/mod.rs", "pub mod a;\n");
    build("main.rs").try_run().unwrap();
    assert_has(
        &place.read("r/mod.rs"),
        &["// @generated by forcec 0.1.0 from the files in this folder", "pub mod main;\n"],
    );
    place
        .write("docs.rs", format!("//! Bodies on springs.\n//!\n//! By hand.\n\n{SPRING}"))
        .write("o/docs.c", "");
    place.succeeds("build docs.rs --out o --target c --target rust");
    place.succeeds("build docs.rs --out o --target c --target rust --real f32");
    assert_has(&place.read("o/docs.c"), &["spring_f32"]);
}

#[test]
fn build_scripts_make_modules() {
    let place = Place::new("modules");
    for name in ["a-b", "fn", "mod", "gen", "self", "2d", "a b"] {
        place.write(&format!("{name}/{name}.rs"), SPRING);
        let build = || forcec::Build::new().input(place.folder.join(name)).out(place.folder.join("o"));
        let error = build().try_run().unwrap_err().to_string();
        assert_has(
            &error,
            &[&format!("error: `{name}` is not a valid module name"), "rename the force file"],
        );
        assert!(place.files("o").is_empty());
        let c = build().out(place.folder.join(name).join("c")).target(forcec::Target::C);
        c.try_run().unwrap();
    }
}

#[test]
fn outputs_differ_in_more_than_case() {
    let place = Place::new("case");
    place.write("f/a.rs", SPRING).write("f/A.rs", DRAG);
    assert_has(
        &place.refused("build f --out o"),
        &["would overwrite another file of this build", "different names"],
    );
    assert!(place.files("o").is_empty());
}

#[cfg(unix)]
#[test]
fn links_and_permissions_are_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let place = Place::new("kept");
    place.write("spring.rs", SPRING).succeeds("build spring.rs --out o");
    let path = |name: &str| place.folder.join(name);
    let mode = |name: &str| fs::metadata(path(name)).unwrap().permissions().mode() & 0o777;
    set_mode(&path("o/spring.c"), 0o600);
    fs::create_dir(path("elsewhere")).unwrap();
    fs::rename(path("o/spring.h"), path("elsewhere/spring.h")).unwrap();
    symlink("middle.h", path("o/spring.h")).unwrap();
    symlink("../elsewhere/spring.h", path("o/middle.h")).unwrap();
    fs::remove_file(path("o/forcec.h")).unwrap();
    symlink("../elsewhere/forcec.h", path("o/forcec.h")).unwrap();
    place.succeeds("build spring.rs --out o --real f32");
    assert_eq!(mode("o/spring.c"), 0o600);
    assert_has(&place.read("o/spring.c"), &["spring_f32"]);
    assert!(["o/spring.h", "o/middle.h", "o/forcec.h"].iter().all(|name| path(name).is_symlink()));
    assert_has(&place.read("elsewhere/spring.h"), &["spring_f32"]);
    assert_eq!(place.files("elsewhere"), ["forcec.h", "spring.h"]);
    assert_eq!(place.files("o"), ["forcec.h", "middle.h", "spring.c", "spring.h"]);
    // Two outputs behind links to one file; links in a circle.
    fs::remove_file(path("o/spring.c")).unwrap();
    symlink("spring.h", path("o/spring.c")).unwrap();
    assert_has(&place.refused("build spring.rs --out o"), &["is a link to another output"]);
    fs::remove_file(path("o/spring.c")).unwrap();
    symlink("spring.c", path("o/spring.c")).unwrap();
    assert_has(&place.refused("build spring.rs --out o"), &["`o/spring.c`: its links lead nowhere"]);
    assert_eq!(place.files("o"), ["forcec.h", "middle.h", "spring.c", "spring.h"]);
}

/// Of builds that run at the same time each succeeds, and each output file comes complete from one of the
/// builds.
#[test]
fn builds_into_one_folder_do_not_meet() {
    let place = Place::new("at_once");
    place.write("spring.rs", SPRING).write("drag.rs", DRAG);
    let (options, mut wanted) =
        (["--real f32", "--real f64", "--real f32 --real f64", "--mode strict --real f32"], Vec::new());
    for (index, options) in options.iter().enumerate() {
        place.succeeds(&format!("build . --out alone{index} {options}"));
        wanted.push(place.read(&format!("alone{index}/spring.c")));
    }
    for _ in 0..8 {
        let runs = options.iter().cycle().take(12);
        let runs = runs.map(|options| {
            place.command(&format!("build . --out o {options}")).stderr(Stdio::piped()).spawn().unwrap()
        });
        for run in runs.collect::<Vec<_>>() {
            let output = run.wait_with_output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
        let threads: Vec<_> = (0..12)
            .map(|k| {
                let real = [forcec::Precision::F32, forcec::Precision::F64][k % 2];
                let build =
                    forcec::Build::new().input(place.folder.join("spring.rs")).out(place.folder.join("t"));
                std::thread::spawn(move || build.real(real).try_run().map_err(|error| error.to_string()))
            })
            .collect();
        threads.into_iter().for_each(|thread| _ = thread.join().unwrap().unwrap());
        assert!(wanted.contains(&place.read("o/spring.c")));
        assert_eq!(place.files("o"), ["drag.c", "drag.h", "forcec.h", "spring.c", "spring.h"]);
        assert_eq!(place.files("t"), ["mod.rs", "spring.rs"]);
    }
}

/// The temporary file of a killed build is removed by the next build; files with similar names stay.
#[cfg(unix)]
#[test]
fn what_killed_builds_left_is_removed() {
    let place = Place::new("killed");
    place.write("spring.rs", SPRING);
    place
        .write("o/.spring.c.forcec-4711-0", "half")
        .write("o/.old.h.forcec-1-23", "")
        .write("o/.forcec-notes", "mine");
    place.write("o/x.forcec-1-2", "mine");
    place.succeeds("build spring.rs --out o");
    assert_eq!(place.files("o"), [".forcec-notes", "forcec.h", "spring.c", "spring.h", "x.forcec-1-2"]);
}

// ---- inputs

#[test]
fn folders_are_searched_in_sorted_order() {
    let place = Place::new("folders");
    let named = |name: &str| SPRING.replace("spring", name);
    place
        .write("f/z.rs", named("last"))
        .write("f/a/deep/x.rs", named("first"))
        .write("f/m.rs", named("middle"))
        .write("f/plain.rs", "fn main() { println!(\"#[energy]\"); }")
        .write("f/no_rust.rs", "}{ this is not Rust")
        .write("f/notes.txt", "#[energy]")
        .write("f/.hidden/h.rs", WRONG)
        .write("f/empty/readme.md", "");
    let order = |line: &str| -> Vec<String> {
        let json: serde_json::Value = serde_json::from_str(&place.succeeds(line).out).unwrap();
        json["kernels"].as_array().unwrap().iter().map(|k| k["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(order("stats --json f"), ["first", "middle", "last"]);
    assert_eq!(order("stats --json f/z.rs f f/../f/m.rs"), ["last", "first", "middle"]);
    assert_eq!(order("stats --json f --only last --only first"), ["first", "last"]);
    place.succeeds("build f --out out");
    assert_eq!(place.files("out"), ["forcec.h", "m.c", "m.h", "x.c", "x.h", "z.c", "z.h"]);
}

#[test]
fn inputs_without_force_functions_are_refused() {
    let place = Place::new("nothing");
    place.write("plain.rs", "fn main() {}").write("empty.rs", "");
    fs::create_dir(place.folder.join("folder")).unwrap();
    for path in ["plain.rs", "empty.rs", "folder"] {
        let message = place.refused(&format!("build {path} --out out"));
        assert_has(
            &message,
            &[&format!("error: no force function in `{path}`"), "= help: ", "#[constraint]"],
        );
    }
    assert!(place.files("out").is_empty());
}

#[test]
fn all_files_report_their_errors_at_once() {
    let place = Place::new("errors");
    place
        .write("a.rs", WRONG)
        .write("b.rs", WRONG.replace("nrom", "nomr"))
        .write("c.rs", b"#[energy]\npub fn \xff")
        .write("d.rs", "#[energy]\npub fn open(");
    let message = place.refused("check a.rs missing.rs b.rs c.rs gone d.rs");
    for part in [
        "error: unknown method `nrom`\n --> a.rs:3:16\n",
        "help: did you mean `norm`?",
        "b.rs:3:16",
        "error: `c.rs` is not UTF-8\n --> c.rs:2\n",
        "error: cannot read `missing.rs`: ",
        "error: cannot read `gone`: ",
        "d.rs:2:12",
    ] {
        assert_has(&message, &[part]);
    }
}

#[test]
fn kernels_and_files_have_one_name_each() {
    let place = Place::new("twice");
    place.write("one/a.rs", SPRING).write("two/b.rs", SPRING).write("two/c.rs", DRAG).write("one/c.rs", "");
    let message = place.refused("build one two --out out");
    assert_has(
        &message,
        &["error: two kernels are named `spring`\n --> one/a.rs:2:8\n --> two/b.rs:2:8\n", "= help: rename"],
    );
    place.write("meets/a.rs", SPRING.replace("spring", "spring_out"));
    let message = place.refused("build one meets --out out");
    assert_has(
        &message,
        &[
            "error: kernels of `spring_out` and `spring` would have the same name\n --> one/a.rs:2:8\n --> meets",
        ],
    );
    place.succeeds("build one two/c.rs --out out");
    // Two files with the same stem.
    place.write("one/c.rs", SPRING.replace("spring", "other"));
    let message = place.refused("build one two/c.rs --out out2");
    assert_has(
        &message,
        &["`two/c.rs` would overwrite another file of this build, `out2/c.", "= help: give the files"],
    );
    assert!(place.files("out2").is_empty());
    // A stem equal to the name of the common header.
    place.write("three/forcec.rs", SPRING);
    assert_has(
        &place.refused("build three --out out2"),
        &["`out2/forcec.h`", "= help: `forcec.h` holds the body types"],
    );
    place.succeeds("build three --out out2 --target rust");
}

#[test]
fn a_misspelt_name_gets_its_neighbour() {
    let place = Place::new("only");
    place.write("f/spring.rs", SPRING).write("f/drag.rs", DRAG);
    for line in ["build f --out o --only spirng", "check f --only spirng", "stats f --only spirng"] {
        assert_has(
            &place.refused(line),
            &["error: no force function `spirng`\n", "= help: did you mean `spring`?"],
        );
    }
    assert_has(
        &place.refused("show f darg --stage c"),
        &["error: no force function `darg`\n", "did you mean `drag`?"],
    );
    assert_has(&place.refused("stats f --only thruster"), &["`thruster`", "= help: `forcec stats`"]);
    place.succeeds("build f --only drag --out o");
    assert_eq!(place.files("o"), ["drag.c", "drag.h", "forcec.h"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_without_running_in_circles() {
    use std::os::unix::fs::symlink;
    let place = Place::new("links");
    place.write("f/spring.rs", SPRING).write("elsewhere/drag.rs", DRAG);
    let link = |to: &str, from: &str| symlink(to, place.folder.join(from)).unwrap();
    link("..", "f/up");
    link("loop", "f/loop");
    link("gone.rs", "f/dangling.rs");
    link("../elsewhere/drag.rs", "f/drag.rs");
    link("spring.rs", "f/again.rs");
    let table = place.succeeds("stats f").out;
    assert_eq!(table.matches("spring").count(), 1, "{table}");
    assert_has(&table, &["drag"]);
    assert_has(&place.refused("stats f/loop"), &["error: cannot read `f/loop`: "]);
    set_mode(&place.folder.join("elsewhere/drag.rs"), 0);
    if fs::read(place.folder.join("elsewhere/drag.rs")).is_err() {
        assert_has(&place.refused("stats f"), &["error: cannot read `f/drag.rs`: "]);
    }
}

// ---- output

#[test]
fn stats_has_the_promised_schema() {
    let place = Place::new("stats");
    place.write("spring.rs", SPRING).write("drag.rs", DRAG);
    let json: serde_json::Value =
        serde_json::from_str(&place.succeeds("stats spring.rs drag.rs --json").out).unwrap();
    let kernels = json["kernels"].as_array().unwrap();
    assert_eq!(kernels.len(), 2);
    for (kernel, name) in kernels.iter().zip(["spring", "drag"]) {
        assert_eq!(kernel["name"], name);
        let ops = kernel["ops"].as_object().unwrap();
        let mut keys: Vec<&str> = ops.keys().map(String::as_str).collect();
        keys.sort_unstable();
        assert_eq!(keys, ["add", "call", "div", "mul", "neg", "sqrt", "total"]);
        let sum: u64 =
            ["add", "mul", "div", "sqrt", "call"].iter().map(|key| ops[*key].as_u64().unwrap()).sum();
        assert_eq!(ops["total"], sum);
        assert!(sum > 0);
    }
    let table = place.succeeds("stats spring.rs drag.rs").out;
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 3);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "columns line up:\n{table}");
    assert_has(rows[0], &["kernel", "add", "mul", "div", "sqrt", "call", "neg", "total", "lines"]);
}

/// Formulas name every argument completely, print numbers in mathematical notation, and say where they are
/// cut off.
#[test]
fn formulas_are_true() {
    let place = Place::new("formulas");
    let text = "#[constraint]\npub fn link(a: Rigid, b: Rigid, arms: [Vec3; 2], rest: Quat, table: [[Real; 2]; 2]) -> Real {\n\
                let arm = a.orientation * arms[1];\n\
                let axis = b.orientation * rest * Vec3::new(-1.0, 0.0, 0.0);\n\
                arm.dot(axis) + 1e-6 * table[0][1]\n}\n";
    place.write("f.rs", text);
    let derivative = place.succeeds("show f.rs link --stage derivative").out;
    assert_has(&derivative, &["arm = a.orientation * arms[1]\n", "rest * (−1, 0, 0)", "1e-6 table[0][1]"]);
    assert_has(&place.succeeds("show f.rs link --stage graph").out, &["= arms[1]\n", "rotate rest "]);
    let latex = place.succeeds("show f.rs link --stage latex").out;
    assert_has(&latex, &["\\mathbf{arms}_{\\mathrm{1}}", "10^{-6}"]);
    place.succeeds("build f.rs --out k");
    assert_has(&place.read("k/f.c"), &["arm = a.orientation * arms[1]", "C = 1e-6 table[0][1] + arm · axis"]);
    assert_has(&place.read("k/f.h"), &["rest[4]; /* quaternion x, y, z, w */", "table[2][2];\n"]);
    let sum = ["p.position.norm_squared().sqrt().exp().sqrt().exp()"; 9].join(" * k + ");
    place.write("long.rs", format!("#[energy]\npub fn long(p: Particle, k: Real) -> Real {{\n{sum}\n}}\n"));
    place.succeeds("build long.rs --out k");
    assert_has(&place.read("k/long.c"), &["F = −∂E/∂X"]);
    assert!(place.read("k/long.c").contains(" * E"), "{}", place.read("k/long.c"));
    assert_has(&place.refused("show f.rs link --stage latex --explain"), &["write `--stage optimized`"]);
}

/// The documentation states which blocks of the Jacobian are symmetric by the law of a force.
#[test]
fn blocks_of_a_symmetric_matrix_are_related() {
    let place = Place::new("related");
    let text = "#[constraint]\npub fn lever(a: Rigid, b: Rigid, arm: Vec3, axis: Vec3) -> Real {\n\
                (b.position - a.position - a.orientation * arm).dot(b.orientation * axis)\n}\n";
    place.write("f.rs", text).succeeds("build f.rs --out k --layout blocks");
    assert_has(&place.read("k/f_blocks.c"), &["dfdv_a_a is symmetric", "dfdv_b_a = dfdv_a_bᵀ"]);
}

/// A name that C cannot include, or that C would confuse with a standard header, is refused as a name of a
/// force file.
#[test]
fn headers_must_not_conflict() {
    let place = Place::new("headers");
    place.write("math.rs", SPRING).write("a\"b.rs", SPRING).write("Features.rs", SPRING);
    assert_has(
        &place.refused("build math.rs --out k"),
        &["would hide the header <math.h>", "--> math.rs", "rename"],
    );
    assert_has(&place.refused("build a\"b.rs --out k"), &["C cannot include", "rename the force file"]);
    assert_has(&place.refused("build Features.rs --out k"), &["would hide the header <Features.h>"]);
    place.succeeds("build math.rs --out k --target rust");
}

#[test]
fn check_reports_every_kernel() {
    let place = Place::new("check");
    place.write("f/spring.rs", SPRING).write("f/drag.rs", DRAG);
    assert_has(&place.succeeds("check f").out, &["drag", "spring"]);
    let json: serde_json::Value = serde_json::from_str(&place.succeeds("check f --json").out).unwrap();
    let kernels = json["kernels"].as_array().unwrap();
    let names: Vec<&str> = kernels.iter().map(|kernel| kernel["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["drag", "spring"]);
    assert!(kernels.iter().all(|kernel| kernel["passed"] == true));
    // The verdict covers the requested precisions.
    let json = place.succeeds("check f --json --real f32 --mode strict").out;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let text = json["kernels"][1]["text"].as_array().unwrap();
    assert!(text.len() == 1 && text[0]["precision"] == "f32" && text[0]["failures"] == 0, "{text:?}");
    assert!(text[0]["states"].as_u64() >= Some(36) && text[0]["worst"]["ratio"].as_f64() <= Some(4.0));
    let table = place.succeeds("check f --real f64,f32").out;
    assert_has(&table, &["of text", "f32", "invariants:"]);
    assert!(table.lines().all(|line| line.chars().count() <= 120), "{table}");
    // The verdict reports uncovered states: no state of the far family lies within the ball.
    let ball =
        "#[energy]\npub fn ball(p: Particle) -> Real { (1000.0 - p.position.norm_squared()).sqrt() }\n";
    place.write("ball.rs", ball);
    assert_has(&place.succeeds("check ball.rs").out, &["pass*", "note: ball: family `far` is not covered"]);
    let json: serde_json::Value = serde_json::from_str(&place.succeeds("check ball.rs --json").out).unwrap();
    assert_eq!(json["kernels"][0]["not_covered"], serde_json::json!(["far"]));
}

#[test]
fn lint_warns_and_fails_only_on_request() {
    let place = Place::new("lint");
    let norm = "#[constraint]\npub fn meet(a: Particle, b: Particle) -> Real {\n    (b.position - a.position).norm()\n}\n";
    place.write("a.rs", norm).write("b.rs", SPRING).write("wrong.rs", WRONG);
    let run = place.succeeds("lint a.rs");
    assert_has(
        &run.out,
        &["meet (constraint), a.rs:2", "nonlinear", "near C = 0", "singular", "3:5", "stable step"],
    );
    assert_has(&run.err, &["--> a.rs:2:8", "--> a.rs:3:5", "C = 0 here"]);
    assert_eq!(place.run("lint a.rs --deny-warnings").code, 1);
    let run = place.succeeds("lint b.rs --deny-warnings --set k=1");
    assert_has(&run.out, &["spring (energy), b.rs:2", "stable step"]);
    assert_eq!(run.err, "");
    assert_has(
        &place.refused("lint a.rs b.rs --only meat"),
        &["no force function `meat`", "did you mean `meet`?"],
    );
    assert_has(&place.refused("lint wrong.rs"), &["unknown method `nrom`", "wrong.rs:3:16"]);
    place.refused("lint b.rs --layout packed");
    let run = place.succeeds("lint a.rs --fixed a");
    assert_has(&run.out, &["of rank 1 of 3"]);
    assert_has(&place.refused("lint a.rs --fixed a --fixed b"), &["no body of `meet` moves"]);
}

#[test]
fn show_prints_each_stage_of_one_function() {
    let place = Place::new("show");
    place.write("f/a.rs", format!("{SPRING}{DRAG}")).write("f/b.rs", SPRING.replace("spring", "other"));
    for stage in ["ast", "graph", "derivative", "optimized", "schedule", "rust", "c", "latex"] {
        let text = place.succeeds(&format!("show f drag --stage {stage}")).out;
        assert!(text.ends_with('\n') && text.len() > 10, "{stage}: {text}");
        assert!(!text.contains("spring") && !text.contains("other"), "{stage}: {text}");
    }
    assert_has(&place.succeeds("show f other --stage ast").out, &["energy other"]);
}

#[test]
fn warnings_go_to_standard_error() {
    let place = Place::new("warnings");
    place.write(
        "rod.rs",
        "#[constraint]\npub fn rod(p: Particle) -> Real {\n    p.position.norm() - 1.0\n}\n",
    );
    let run = place.succeeds("stats rod.rs --json");
    assert_has(&run.err, &["warning[singular]: ", " --> rod.rs:3:5"]);
    assert!(!run.out.contains("warning"));
    serde_json::from_str::<serde_json::Value>(&run.out).unwrap();
}

#[test]
fn warnings_are_answered_or_denied() {
    let place = Place::new("answered");
    let rod = "#[constraint]\npub fn rod(p: Particle) -> Real {\n    p.position.norm() - 1.0\n}\n";
    let reason = "#[allow(singular, nonlinear, damped_step, gauss_newton, reason = \"rods are long\")]\n";
    place.write("rod.rs", rod).write("long.rs", format!("{reason}{}", rod.replace("rod", "long")));
    place.write("scene.toml", "forces = [\"rod.rs\", \"long.rs\"]\n[[kernel]]\nfunction = \"long\"\n");
    for line in [
        "build rod.rs --out o --deny-warnings",
        "check rod.rs --deny-warnings",
        "build rod.rs --check --out o --deny-warnings",
    ] {
        let run = place.run(line);
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{line}");
        assert_has(&run.err, &["warning[singular]: `norm`", " --> rod.rs:3:5"]);
    }
    assert!(place.files("o").is_empty());
    for line in
        ["build long.rs --out o", "check long.rs", "lint long.rs", "build rod.rs long.rs --only long --out o"]
    {
        assert_eq!(place.succeeds(&format!("{line} --deny-warnings")).err, "", "{line}");
    }
    assert_eq!(place.succeeds("build --scene scene.toml --deny-warnings").err, "");
    place.write("scene.toml", "forces = \"rod.rs\"\n[[kernel]]\nfunction = \"rod\"\n");
    assert_eq!(place.run("check --scene scene.toml --deny-warnings").code, 1);
    place.write("bare.rs", rod.replace("#[", "#[allow(singular)]\n#["));
    let run = place.run("check bare.rs --deny-warnings");
    assert_has(
        &run.err,
        &["warning[missing_reason]: `singular` is allowed without a reason", "bare.rs:1:9", "reason ="],
    );
    assert_eq!(run.code, 1);
    assert!(!run.err.contains("norm"));
}

/// `--only` warns about the named function and about the functions that the named function calls.
#[test]
fn only_warns_of_what_it_names() {
    let place = Place::new("only");
    let text = "fn used(x: Real) -> Real {\n    1.0 / x\n}\nfn idle(x: Real, y: Real) -> Real {\n    1.0 / x\n}\n\
                #[energy]\npub fn one(p: Particle, k: Real) -> Real {\n    used(p.position.x)\n}\n\
                #[energy]\npub fn two(p: Particle) -> Real {\n    idle(p.position.x, 1.0)\n}\n";
    place.write("f.rs", text);
    let lines = |line: &str| -> Vec<String> {
        let err = place.succeeds(line).err;
        err.lines().filter_map(|line| line.trim_start().strip_prefix("--> ")).map(str::to_owned).collect()
    };
    assert_eq!(lines("check f.rs --only one"), ["f.rs:2:5", "f.rs:8:25"]);
    assert_eq!(lines("check f.rs --only two"), ["f.rs:4:18", "f.rs:5:5"]);
    assert_eq!(lines("check f.rs").len(), 4);
}

#[test]
fn paths_do_not_steer_the_terminal() {
    let place = Place::new("escapes");
    let name = "a\u{1b}[31m\u{202e}.rs";
    place.write(name, WRONG).write(
        "scene.toml",
        format!("forces = \"{}\"\n[[kernel]]\nfunction = \"wrong\"\n", "\\u001b[31m.rs"),
    );
    for line in [
        format!("build {name} --out o"),
        format!("build gone{name} --out o"),
        "build --scene scene.toml".to_owned(),
        "build . --out o".to_owned(),
    ] {
        let message = place.refused(&line);
        assert_has(&message, &["\\u{1b}[31m"]);
        assert!(!message.contains(['\x1b', '\u{202e}']), "{message}");
    }
    place.write(name, SPRING);
    let run = place.run(&format!("build {name} --out o --check --target rust"));
    assert_has(&run.err, &["o/a\\u{1b}[31m\\u{202e}.rs is missing"]);
}

#[test]
fn colours_need_a_terminal_whatever_the_environment_says() {
    let place = Place::new("colour");
    place.write("wrong.rs", WRONG);
    for (name, value) in [("NO_COLOR", "1"), ("NO_COLOR", ""), ("CLICOLOR", "1"), ("TERM", "xterm-256color")]
    {
        let output = place.command("stats wrong.rs").env(name, value).output().unwrap();
        assert!(!output.stderr.contains(&0x1b), "{name}={value}");
    }
}

#[test]
fn a_closed_pipe_is_not_an_error() {
    let place = Place::new("pipes");
    place.write("wrong.rs", WRONG).write("spring.rs", SPRING);
    let closed = || {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        writer
    };
    for line in ["--help", "completions bash", "show spring.rs spring --stage c", "stats spring.rs"] {
        let output = place.command(line).stdout(closed()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{line}");
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{line}");
    }
    let status = place.command("stats wrong.rs").stdout(Stdio::null()).stderr(closed()).status().unwrap();
    assert_eq!(status.code(), Some(2));
    let status = place.command("build spring.rs --out o --check").stderr(closed()).status().unwrap();
    assert_eq!(status.code(), Some(1));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let place = Place::new("full");
    place.write("spring.rs", SPRING);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for line in ["stats spring.rs", "--help", "build --help", "--version", "completions bash"] {
        let output = place.command(line).stdout(full.try_clone().unwrap()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert_has(&String::from_utf8_lossy(&output.stderr), &["error: cannot write to standard output: "]);
    }
}

// ---- multipliers

#[test]
fn only_constraints_have_multipliers() {
    let place = Place::new("multipliers");
    let rope = "#[constraint(unilateral)]\npub fn rope(p: Particle, multipliers: Real) -> Real {\n    \
                multipliers - p.position.norm_squared()\n}\n";
    place.write("rope.rs", rope).write("spring.rs", SPRING);
    let wrong = place.refused("build spring.rs --out never --outputs held_matrix");
    assert_has(
        &wrong,
        &["`spring` is not a constraint, and so has no `held_matrix`", "only constraints have"],
    );
    place.succeeds("check rope.rs --outputs force,multiplier,multiplier_step,held_matrix");
    place.succeeds("check rope.rs --outputs held_matrix --set step=1");
    place.succeeds("check rope.rs --outputs value,rate,jacobian,drift,held_matrix,pull,geometric");
    let wrong = place.refused("build spring.rs --out never --outputs drift,pull,geometric");
    assert_has(&wrong, &["`spring` is not a constraint, and so has no `drift`"]);
    place.succeeds("build rope.rs --out value --outputs value");
    assert!(!place.read("value/rope.h").contains(" rate["), "the value comes without its rate");
    place.succeeds("build rope.rs --out o --outputs multiplier,held_matrix --lanes 4");
    assert_has(&place.read("o/rope_x4.h"), &["held_matrix[3][3][4]", "const double multipliers[1][4]"]);
    place.write("tie.rs", "#[constraint]\npub fn tie(p: Particle) -> Vec3 {\n    p.position\n}\n");
    let wrong = place.refused("build tie.rs --out never --outputs held_matrix --set multipliers=0");
    assert_has(&wrong, &["multipliers are not known beforehand", "leave them an argument"]);
}

// ---- layouts

#[test]
fn layouts_and_preparation_go_together_or_say_why_not() {
    let place = Place::new("layouts");
    place.write("spring.rs", SPRING).write("drag.rs", DRAG);
    let refused = |options: &str| place.refused(&format!("build . --out never {options}"));
    let lanes = ["`accumulate` adds to what one instance is given", "= help: leave `lanes` out", "`blocks`"];
    assert_has(&refused("--layout accumulate --lanes 4"), &lanes);
    assert_has(&refused("--layout system --outputs force"), &["says itself what is computed"]);
    assert_has(
        &refused("--layout block"),
        &["[possible values: dense", "blocks, symmetric, accumulate]", "'blocks'"],
    );
    assert!(place.files("never").is_empty());
    place.succeeds("check . --prepare --layout accumulate --outputs impulse,matrix");
    place.succeeds("check . --outputs force,dfdx,dfdv,impulse,matrix,dfdx_product");
    place.succeeds("build . --out o --prepare --layout blocks --lanes 4");
    assert_has(&place.read("o/spring_blocks_x4.h"), &["double two_k[4];", "spring_blocks_x4_prepare_f64"]);
    assert_has(&place.read("o/drag_blocks_x4.c"), &["there is nothing to prepare"]);
    assert_has(
        &place.read("o/drag_blocks_x4.h"),
        &["all zero and not stored: dfdx_p_p.", "dfdv_p_p[3][3][4]"],
    );
    let stats = place.succeeds("stats . --prepare --json").out;
    let stats: serde_json::Value = serde_json::from_str(&stats).unwrap();
    assert_eq!([&stats["kernels"][1]["once"], &stats["kernels"][1]["prepared"]], [1, 1]);
    assert!(stats["kernels"][0]["once"].is_null());
}

// ---- values known at compile time

#[test]
fn known_values_are_not_arguments() {
    let place = Place::new("known");
    place.write(
        "tie.rs",
        "#[constraint]\npub fn tie(p: Particle, q: Particle) -> Vec3 {\n    q.position - p.position\n}\n",
    );
    place.write("spring.rs", SPRING);
    place.succeeds("check . --fixed q --set damping=0 --set k=0.3");
    place.succeeds("build . --out o --fixed q --set damping=0 --set k=0.3");
    assert_has(&place.read("o/tie.h"), &["double stiffness;", "tie_fixed_q_set_damping_params_f64"]);
    assert!(!place.read("o/tie.h").contains("double damping"));
    assert_has(&place.read("o/spring.c"), &["k = 0.3\n", "const double k = 0.3;"]);
    let refused = |known: &str| place.refused(&format!("build tie.rs --out never {known}"));
    assert_has(&refused("--fixed o"), &["error: no force function has a body `o`"]);
    assert_has(&refused("--set dampng=1"), &["no force function has a parameter `dampng`", "`damping`"]);
    assert_has(&refused("--set damping=[1,2]"), &["`damping` has 1 entry, and 2 are set", "tie.rs:2:8"]);
    assert_has(&refused("--set damping=0 --set damping=1"), &["`damping` is set twice"]);
    assert_has(&refused("--set damping=1e-400"), &["`1e-400` is below the least `f64`"]);
    assert_has(&refused("--layout system --set step=0"), &["the step is positive", "tie.rs:2:8"]);
    assert_has(&refused("--layout system --set step=-1"), &["the step is positive", "`step=0.01`"]);
    assert_has(&refused("--fixed p --fixed q"), &["no body of `tie` moves", "tie.rs:2:8"]);
    for wrong in ["damping", "damping=", "damping=[[1],[2,3]]", "damping=fast", "=1"] {
        assert_has(&refused(&format!("--set {wrong}")), &["is not NAME=NUMBER or NAME=[NUMBER, …]"]);
    }
    assert!(place.files("never").is_empty());
    // If a parameter has the name of a layout input, `--set` sets the parameter; a value outside the domain of
    // the parameter causes a warning.
    let march = "#[energy]\n#[domain(step = 0.5..2.0)]\npub fn march(p: Particle, step: Real) -> Real {\n    step * p.position.norm_squared()\n}\n";
    place.write("march.rs", march);
    let built = place.succeeds("build march.rs --out m --layout system --set step=-3");
    assert_has(&built.err, &["`step` is set to a value outside of its domain", "march.rs:2:10", "is -3"]);
    assert_has(&place.read("m/march_system.h"), &["double step,"]);
    assert_has(&place.read("m/march_system.c"), &["step = -3"]);
}
