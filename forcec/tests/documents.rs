//! The documents: what they say was printed is what the code prints, what they tell the reader to run runs.
//!
//! A block between `<!-- printed: NAME -->` and `<!-- end -->` belongs to this test. `FORCEC_BLESS=1` prints all blocks anew.

#![cfg(feature = "cli")]

use forcec::Mode;
use forcec::compile::{Compiled, Stages, compile};
use forcec::diagnostic::Diagnostics;
use forcec::identities::IDENTITIES;
use forcec::kernel::{File, Precision, Target};
use forcec::ops::Function;
use forcec::optimize::PASSES;
use forcec::outputs::Part;
use forcec::rounding::observed::compare;
use forcec::rounding::upward;
use forcec::scalar::Operations;
use forcec::span::Source;
use forcec::targets;
use forcec::verify::Family;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const DOCUMENTS: [&str; 8] = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/language.md",
    "docs/mathematics.md",
    "docs/rust.md",
    "examples/README.md",
];

/// The kernels of the README's table.
const COUNTED: [&str; 8] = [
    "point_to_point",
    "distance",
    "hinge",
    "hinge_motor",
    "sphere_plane_friction",
    "spring",
    "dihedral",
    "neo_hookean",
];

/// The kernels whose passes are listed.
const PASSED: [&str; 5] = ["point_to_point", "distance", "hinge", "dihedral", "neo_hookean"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn compiled(path: &str, names: &[&str]) -> Compiled {
    let source = Source::new(path, read(path));
    compile(&source, &|name| names.contains(&name), forcec::Effort::Default)
        .unwrap_or_else(|errors| panic!("{errors}"))
}

/// The force files of the library, in order.
fn force_files() -> Vec<String> {
    let entries = fs::read_dir(root().join("constraints")).unwrap();
    let mut files: Vec<String> = entries
        .map(|entry| format!("constraints/{}", entry.unwrap().file_name().to_str().unwrap()))
        .filter(|file| file.ends_with(".rs"))
        .collect();
    files.sort();
    files
}

/// The named kernels of the library, in the order of the names.
fn library(names: &[&str]) -> Vec<Stages> {
    let mut found: Vec<Stages> =
        force_files().iter().flat_map(|file| compiled(file, names).functions).collect();
    let place = |stages: &Stages| names.iter().position(|name| *name == stages.kernel.name);
    found.sort_by_key(place);
    assert_eq!(found.len(), names.len(), "every kernel of {names:?} is in the library");
    found
}

fn table(heading: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let number = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_digit());
    let rows: Vec<Vec<String>> = rows.into_iter().collect();
    let line = |cells: &mut dyn Iterator<Item = String>| {
        format!("| {} |\n", cells.collect::<Vec<String>>().join(" | "))
    };
    let mut text = line(&mut heading.iter().map(|cell| (*cell).to_owned()));
    let rule = |column: usize| if rows.iter().all(|row| number(&row[column])) { "--:" } else { "---" };
    text.push_str(&format!("|{}|\n", (0..heading.len()).map(rule).collect::<Vec<&str>>().join("|")));
    for row in rows {
        text.push_str(&line(&mut row.into_iter().map(|cell| cell.replace('|', "\\|"))));
    }
    text
}

fn code(text: &str) -> String {
    format!("`{text}`")
}

fn total(operations: &Operations) -> String {
    operations.total().to_string()
}

/// The text of a block.
fn printed(name: &str) -> String {
    match name {
        "ball-joint" => fenced("rust", &function("constraints/joints.rs", "point_to_point")),
        "kernel" => fenced("c", &kernel_excerpt()),
        "counts" => counts(),
        "passes" => passes(),
        "pass-list" => table(
            &["pass", "what it does"],
            PASSES.iter().map(|pass| vec![code(pass.name), pass.summary.to_owned()]),
        ),
        "modes" => table(
            &["mode", "what it does", "flags of a C compiler"],
            Mode::ALL
                .iter()
                .map(|(name, mode, summary)| vec![code(name), (*summary).to_owned(), code(mode.flags())]),
        ),
        "derivatives" => derivatives(),
        "rounding" => rounding(),
        "functions" => functions(),
        "identities" => table(
            &["name", "left", "right"],
            IDENTITIES.iter().map(|i| vec![i.name.to_owned(), code(i.left), code(i.right)]),
        ),
        "warning" => {
            let compiled = compiled("constraints/joints.rs", &["point_to_point_norm"]);
            let place = |offset| compiled.source.line_column(offset).0;
            let span = compiled.functions[0].definition.span;
            let end = place(compiled.source.text[span.end as usize..].find("\n}").unwrap() as u32 + span.end);
            let near = compiled.warnings.into_iter();
            let near = near
                .filter(|w| w.span.is_some_and(|at| (place(span.start)..=end).contains(&place(at.start))));
            fenced("text", &Diagnostics::new(compiled.source.clone(), near.collect()).render(false))
        }
        _ => panic!("no block is called `{name}`"),
    }
}

fn fenced(language: &str, text: &str) -> String {
    format!("```{language}\n{}\n```\n", text.trim_end())
}

/// A function of a file with its doc comment and attributes.
fn function(path: &str, name: &str) -> String {
    let text = read(path);
    let paragraph = text.split("\n\n").skip_while(|part| !part.contains(&format!("fn {name}(")));
    paragraph.take(1).collect()
}

/// The head of the ball joint's kernel and the end of what computes the force.
fn kernel_excerpt() -> String {
    let compiled = compiled("constraints/joints.rs", &["point_to_point"]);
    let file = File {
        stem: "joints".to_owned(),
        docs: Vec::new(),
        kernels: compiled.functions.into_iter().map(|stages| stages.kernel).collect(),
        precisions: vec![Precision::F64],
    };
    let files = targets::emit(&file, Target::C);
    let text = files.into_iter().find(|file| file.name == "joints.c").unwrap().text;
    let (_, kernel) = text.split_once("#include \"joints.h\"\n\n").expect("the file includes its header");
    let (head, body) = kernel.split_once("    /* F */\n").expect("the kernel has its headings");
    let (force, _) = body.split_once("\n    /* dF/dX */").expect("the kernel has its headings");
    let last: Vec<&str> = force.lines().skip_while(|line| !line.contains("= b->position[2]")).collect();
    assert!(!last.is_empty(), "the force ends with its z entries");
    format!("{head}    /* … */\n{}\n    /* … */\n}}", last.join("\n"))
}

fn counts() -> String {
    let heading = ["kernel", "add", "mul", "div", "sqrt", "call", "total", "outputs"];
    table(
        &heading,
        library(&COUNTED).iter().map(|stages| {
            let schedule = &stages.kernel.schedule;
            let n = schedule.operations();
            let numbers = [n.add, n.mul, n.div, n.sqrt, n.call, n.total(), schedule.nonzero];
            let numbers = numbers.iter().map(ToString::to_string);
            std::iter::once(code(&stages.kernel.name)).chain(numbers).collect()
        }),
    )
}

fn passes() -> String {
    let kernels = library(&PASSED);
    let mut heading = vec!["kernel"];
    heading.extend(kernels[0].report.iter().map(|step| step.pass));
    heading.push("kernel");
    table(
        &heading,
        kernels.iter().map(|stages| {
            let mut row = vec![code(&stages.kernel.name)];
            row.extend(stages.report.iter().map(|step| total(&step.operations)));
            row.push(total(&stages.kernel.schedule.operations()));
            row
        }),
    )
}

fn derivatives() -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for function in Function::ALL {
        let row = function.row();
        let name = if function.order().is_some() { format!("`{}` n", row.name) } else { code(row.name) };
        if rows.last().is_none_or(|last| last[0] != name) {
            rows.push(vec![name, row.formula.to_owned()]);
        }
    }
    table(&["function", "derivative"], rows)
}

/// Bounds of rounding errors and the errors, of every kernel of the library.
fn rounding() -> String {
    let mut heading = vec!["kernel".to_owned()];
    for precision in [Precision::F64, Precision::F32] {
        heading.extend(Part::DEFAULT.map(|part| format!("{}, {precision}", part.row().title)));
    }
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    let mut rows = Vec::new();
    for path in force_files() {
        let source = Source::new(&path, read(&path));
        let compiled = compile(&source, &|_| true, forcec::Effort::Default);
        for Stages { kernel, .. } in compiled.unwrap_or_else(|errors| panic!("{errors}")).functions {
            let mut row = vec![code(&kernel.name)];
            for precision in [Precision::F64, Precision::F32] {
                for found in compare(&kernel, precision, &[Family::Random]) {
                    let told =
                        if found.states > found.unbounded { upward(found.bound) } else { "none".to_owned() };
                    let open = found.unbounded;
                    let open = if open > 0 { format!(" ({open} without)") } else { String::new() };
                    row.push(match (found.bound, open.is_empty()) {
                        (0.0, true) => "0".to_owned(),
                        _ => format!("{told}{open}, {}", upward(found.observed)),
                    });
                }
            }
            rows.push(row);
        }
    }
    table(&heading, rows)
}

/// The methods, a table for each type.
fn functions() -> String {
    let rows = forcec::check::reference();
    let mut types: Vec<&str> = Vec::new();
    for [on, ..] in &rows {
        if !types.contains(&on.as_str()) {
            types.push(on);
        }
    }
    let mut text = String::new();
    for ty in types {
        let several = ty.contains(',');
        let of_type = rows.iter().filter(|[on, ..]| on == ty).map(|[_, written, result, summary]| {
            let written = match written.starts_with('.') {
                true => written.clone(),
                false if several => format!("Self::{written}"),
                false => format!("{ty}::{written}"),
            };
            vec![code(&written), code(result), summary.clone()]
        });
        let title: Vec<String> = ty
            .split(", ")
            .map(|name| if name.starts_with(char::is_uppercase) { code(name) } else { format!("a {name}") })
            .collect();
        text.push_str(&format!(
            "On {}:\n\n{}\n",
            title.join(", "),
            table(&["write", "returns", "what it is"], of_type)
        ));
    }
    text.trim_end().to_owned() + "\n"
}

const BEGIN: &str = "\n<!-- printed: ";
const END: &str = "<!-- end -->";

/// The document with every block printed anew.
fn reprinted(text: &str) -> String {
    let mut result = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(BEGIN) {
        let head = &rest[start + BEGIN.len()..];
        let (name, body) = head.split_once(" -->\n").expect("the marker ends its line");
        let end = body.find(END).unwrap_or_else(|| panic!("the block `{name}` ends"));
        result.push_str(&rest[..start]);
        result.push_str(&format!("{BEGIN}{name} -->\n{}{END}", printed(name)));
        rest = &body[end + END.len()..];
    }
    result + rest
}

#[test]
fn printed_blocks_are_what_the_code_prints() {
    for path in DOCUMENTS {
        let text = read(path);
        let expected = reprinted(&text);
        if std::env::var_os("FORCEC_BLESS").is_some() {
            fs::write(root().join(path), &expected).unwrap();
        } else if text != expected {
            let differs = text.lines().zip(expected.lines()).find(|(x, y)| x != y);
            let (found, wanted) = differs.unwrap_or(("the end", "more, or less"));
            panic!(
                "{path} is out of date; run with FORCEC_BLESS=1\n  found:    {found}\n  expected: {wanted}"
            );
        }
    }
}

/// The fenced block that follows a marker.
fn block<'a>(text: &'a str, marker: &str) -> &'a str {
    let start = text.find(marker).unwrap_or_else(|| panic!("`{marker}` is there")) + marker.len();
    let body = text[start..].split_once("\n```").expect("a block follows").1;
    body.split_once('\n').unwrap().1.split_once("```").expect("the block ends").0
}

#[test]
fn the_example_of_the_readme_runs() {
    let readme = read("README.md");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    for name in ["bands.rs", "main.c"] {
        fs::write(folder.join(name), block(&readme, &format!("<!-- file: {name} -->"))).unwrap();
    }
    let commands =
        block(&readme, "<!-- commands -->").replace("forcec ", &format!("{} ", env!("CARGO_BIN_EXE_forcec")));
    let output = Command::new("sh").args(["-e", "-c", &commands]).current_dir(&folder).output().unwrap();
    let (out, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{out}{errors}");
    assert_eq!(errors, "", "nothing warns");
    let expected = block(&readme, "<!-- output -->");
    assert!(out.ends_with(expected), "the program prints\n{out}\nand not\n{expected}");
}

/// The recipe for snapshots, followed in a crate of its own: the first run writes them, the second compares, and a change of
/// the force file fails with the line that changed.
#[test]
fn the_recipe_for_snapshots_works() {
    let document = read("docs/rust.md");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("snapshots");
    let _ = fs::remove_dir_all(&folder);
    for name in ["src", "tests", "forces"] {
        fs::create_dir_all(folder.join(name)).unwrap();
    }
    let repository = root().canonicalize().unwrap();
    let path = format!("path = \"{}/forcec\", version = \"0.1\"", repository.display());
    let dependencies = block(&document, "<!-- file: Cargo.toml -->").replace("version = \"0.1\"", &path);
    // The version of insta that this repository uses, without its default features, is there without a network.
    let dependencies =
        dependencies.replace("insta = \"1\"", "insta = { version = \"1\", default-features = false }");
    let package = "[package]\nname = \"snapshots\"\nedition = \"2024\"\n\n[workspace]\n\n";
    fs::write(folder.join("Cargo.toml"), format!("{package}{dependencies}")).unwrap();
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
    fs::write(folder.join("src/lib.rs"), "").unwrap();
    fs::write(folder.join("tests/kernels.rs"), block(&document, "<!-- file: tests/kernels.rs -->")).unwrap();
    let force = read("examples/c/bands.rs");
    fs::write(folder.join("forces/bands.rs"), &force).unwrap();
    let run = |commands: &str| {
        let output = Command::new("sh")
            .args(["-e", "-c", commands])
            .current_dir(&folder)
            .env("CARGO_NET_OFFLINE", "true")
            .env("CARGO_TARGET_DIR", repository.join("target"))
            .env_remove("INSTA_UPDATE")
            .env("CI", "true")
            .output()
            .unwrap();
        let (out, errors) =
            (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        (output.status.success(), format!("{out}{errors}"))
    };
    let (passed, text) = run(block(&document, "<!-- commands -->"));
    assert!(passed, "{text}");
    let snapshot = fs::read_to_string(folder.join("tests/snapshots/kernels__rubber_band.snap")).unwrap();
    assert!(snapshot.contains("void rubber_band_f64("), "{snapshot}");
    let (passed, text) = run("cargo test");
    assert!(passed, "{text}");
    fs::write(folder.join("forces/bands.rs"), force.replace("strain > 0.0", "strain > 0.1")).unwrap();
    let (passed, text) = run("cargo test");
    assert!(!passed && text.contains("rubber_band"), "{text}");
}

/// The anchor GitHub gives a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect()
}

#[test]
fn links_lead_somewhere() {
    for path in DOCUMENTS {
        let text = read(path);
        let folder = Path::new(path).parent().unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            if link.starts_with("https://") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { PathBuf::from(path) } else { folder.join(file) };
            assert!(root().join(&target).exists(), "{path} links to {link}");
            if !heading.is_empty() {
                let text = read(target.to_str().unwrap());
                let mut headings = text.lines().filter(|line| line.starts_with('#'));
                let found = headings.any(|line| anchor(line.trim_start_matches('#').trim()) == heading);
                assert!(found, "{path} links to {link}");
            }
        }
    }
}
