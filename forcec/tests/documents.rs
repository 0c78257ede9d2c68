//! The documents: blocks marked as printed equal the output of the code, and the commands for the reader
//! work.
//!
//! This test generates the blocks between `<!-- printed: NAME -->` and `<!-- end -->`. `FORCEC_BLESS=1`
//! updates all blocks.

#![cfg(feature = "cli")]

use forcec::Mode;
use forcec::internals::compile::{Compiled, Stages, compile};
use forcec::internals::emit;
use forcec::internals::kernel::{File, Precision, Target};
use forcec::internals::layout::LAYOUTS;
use forcec::internals::lint::{advise, render};
use forcec::internals::math::functions::Function;
use forcec::internals::model::bodies::{BODIES, BodyRow, Field, Role};
use forcec::internals::model::outputs::{Axis, Part, PartRow};
use forcec::internals::optimize::PASSES;
use forcec::internals::rounding::observed::compare;
use forcec::internals::rounding::upward;
use forcec::internals::scalar::Operations;
use forcec::internals::source::diagnostic::Diagnostics;
use forcec::internals::source::span::Source;
use forcec::internals::vector::identities::IDENTITIES;
use forcec::internals::verify::Family;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The documents with blocks that this test prints. `forcec-bench`, which measures, prints the other blocks.
const PRINTED: [&str; 5] =
    ["README.md", "ARCHITECTURE.md", "docs/language.md", "docs/lint.md", "docs/mathematics.md"];

/// The force file of `docs/lint.md`.
const GAP: &str = "examples/formulations/gap.rs";

/// The kernels in the table of the README.
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

/// Every Markdown file of the repository, in sorted order.
fn documents() -> Vec<String> {
    let (mut found, mut pending) = (Vec::new(), vec![PathBuf::new()]);
    while let Some(folder) = pending.pop() {
        for entry in fs::read_dir(root().join(&folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let path = folder.join(&name);
            if root().join(&path).is_dir() && !name.starts_with('.') && name != "target" {
                pending.push(path);
            } else if name.ends_with(".md") {
                found.push(path.to_str().unwrap().replace('\\', "/"));
            }
        }
    }
    found.sort();
    assert!(found.len() > 10, "the documents are where they are expected");
    found
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
            &["pass", "effect"],
            PASSES.iter().map(|pass| vec![code(pass.name), pass.summary.to_owned()]),
        ),
        "modes" => table(
            &["mode", "effect", "flags of a C compiler"],
            Mode::ALL
                .iter()
                .map(|(name, mode, summary)| vec![code(name), (*summary).to_owned(), code(mode.flags())]),
        ),
        "gap" => fenced("rust", &read(GAP)),
        "gap-lint" => {
            let compiled = compiled(GAP, &["meet", "meet_norm", "ball", "ball_norm"]);
            let all = compiled.functions.iter().map(|f| render(&advise(&f.definition), &compiled.source));
            fenced("text", &all.collect::<Vec<String>>().join("\n"))
        }
        "gap-warning" => {
            let compiled = compiled(GAP, &["meet_norm"]);
            let mut warnings = advise(&compiled.functions[0].definition).warnings;
            warnings.retain(|warning| warning.message.contains("100 × critical"));
            fenced("text", &Diagnostics::new(compiled.source.clone(), warnings).render(false))
        }
        "bodies" => bodies(),
        "outputs" => outputs(),
        "layouts" => table(
            &["layout", "what it holds"],
            LAYOUTS.iter().map(|row| vec![code(row.name), row.summary.to_owned()]),
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

/// The head of the ball joint's kernel and the last statements that compute the force.
fn kernel_excerpt() -> String {
    let compiled = compiled("constraints/joints.rs", &["point_to_point"]);
    let file = File {
        stem: "joints".to_owned(),
        docs: Vec::new(),
        kernels: compiled.functions.into_iter().map(|stages| stages.kernel).collect(),
        precisions: vec![Precision::F64],
    };
    let files = emit::emit(&file, Target::C);
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

/// The body types.
fn bodies() -> String {
    let field = |field: &Field| {
        let ty = if field.role == Role::Orientation { "Quat" } else { "Vec3" };
        code(&format!("{}: {ty}", field.name))
    };
    let row = |body: &BodyRow| {
        let coordinates = body.coordinates.join(", ");
        let fields: Vec<String> = body.fields.iter().map(field).collect();
        let coordinates = format!("{}: {coordinates}", body.coordinates.len());
        vec![code(body.name), fields.join(", "), coordinates]
    };
    table(&["body", "fields", "coordinates"], BODIES.iter().map(row))
}

/// The values of `--outputs`.
fn outputs() -> String {
    let row = |row: &PartRow| {
        let axis = |axis: Axis| if axis == Axis::Row { "[m]" } else { "[N]" };
        let shape = axis(row.rows).to_owned() + row.columns.map_or("", axis);
        vec![code(row.name), format!("{}: {}", code(&format!("{}{shape}", row.name)), row.summary)]
    };
    table(&["output", "field of `out`"], Part::choices().map(row))
}

/// Bounds of rounding errors and the actual errors, for every kernel of the library.
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
                    let bound =
                        if found.states > found.unbounded { upward(found.bound) } else { "none".to_owned() };
                    let open = found.unbounded;
                    let open = if open > 0 { format!(" ({open} without)") } else { String::new() };
                    row.push(match (found.bound, open.is_empty()) {
                        (0.0, true) => "0".to_owned(),
                        _ => format!("{bound}{open}, {}", upward(found.observed)),
                    });
                }
            }
            rows.push(row);
        }
    }
    table(&heading, rows)
}

/// The methods, one table per type.
fn functions() -> String {
    let rows = forcec::internals::check::reference();
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
            table(&["write", "returns", "description"], of_type)
        ));
    }
    text.trim_end().to_owned() + "\n"
}

const BEGIN: &str = "\n<!-- printed: ";
const END: &str = "<!-- end -->";

/// The document with every block printed again.
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
    for path in PRINTED {
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

/// The fenced block after a marker: the start of its text, and the text.
fn fence(text: &str) -> (usize, &str) {
    let start = text.find("\n```").expect("a block follows") + 1;
    let start = start + text[start..].find('\n').expect("the block begins") + 1;
    (start, text[start..].split_once("```").expect("the block ends").0)
}

/// The fenced block after this marker.
fn block<'a>(text: &'a str, marker: &str) -> &'a str {
    let start = text.find(marker).unwrap_or_else(|| panic!("`{marker}` is there")) + marker.len();
    fence(&text[start..]).1
}

/// Follows the instructions of a document in an empty folder and returns the expected document. Files between
/// `<!-- file: NAME -->` and the end of a block are written; `<!-- commands -->` are run and must succeed.
/// The commands' output must end with the block after `<!-- output -->`; files that the commands write appear
/// in the document as `<!-- made: NAME -->`.
fn followed(path: &str) -> String {
    let text = read(path);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("followed").join(path);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let own = Path::new(env!("CARGO_BIN_EXE_forcec")).parent().unwrap();
    let search = std::env::var_os("PATH").unwrap_or_default();
    let search = std::env::join_paths(std::iter::once(own.to_owned()).chain(std::env::split_paths(&search)));
    let (mut result, mut rest, mut printed, mut commands) = (String::new(), text.as_str(), String::new(), 0);
    while let Some(start) = rest.find("<!-- ") {
        let (marker, _) = rest[start + 5..].split_once(" -->").expect("a marker ends");
        let end = start + 5 + marker.len() + 4;
        result.push_str(&rest[..end]);
        rest = &rest[end..];
        if let Some(name) = marker.strip_prefix("file: ") {
            fs::write(folder.join(name), fence(rest).1).unwrap();
        } else if marker == "commands" {
            let mut shell = Command::new("sh");
            shell
                .args(["-e", "-c", fence(rest).1])
                .current_dir(&folder)
                .env("PATH", search.as_ref().unwrap());
            let output = shell.output().unwrap();
            printed = String::from_utf8_lossy(&output.stdout).into_owned();
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && errors.is_empty(), "{path}:\n{printed}{errors}");
            commands += 1;
        } else if marker == "output" {
            let (at, expected) = fence(rest);
            let lines: Vec<&str> = printed.lines().collect();
            let last = &lines[lines.len().saturating_sub(expected.lines().count())..];
            result.push_str(&rest[..at]);
            result.push_str(&(last.join("\n") + "\n"));
            rest = &rest[at + expected.len()..];
        } else if let Some(name) = marker.strip_prefix("made: ") {
            let stored = root().join(path).with_file_name(name);
            let made = fs::read_to_string(folder.join(name)).unwrap();
            if std::env::var_os("FORCEC_BLESS").is_some() {
                fs::write(&stored, &made).unwrap();
            }
            let same = fs::read_to_string(&stored).is_ok_and(|text| text == made);
            assert!(same, "{path}: {name} is not what its program writes; run with FORCEC_BLESS=1");
        }
    }
    assert!(commands > 0, "{path} has commands");
    result + rest
}

/// Asserts that the programs of a document run and print the documented output.
fn follow(path: &str) {
    let (text, expected) = (read(path), followed(path));
    if std::env::var_os("FORCEC_BLESS").is_some() {
        fs::write(root().join(path), &expected).unwrap();
    } else if text != expected {
        let differs = text.lines().zip(expected.lines()).find(|(x, y)| x != y);
        let (found, wanted) = differs.unwrap_or(("the end", "more, or less"));
        panic!("{path} says\n  {found}\nand its programs print\n  {wanted}");
    }
}

#[test]
fn the_example_of_the_readme_runs() {
    follow("README.md");
}

#[test]
fn the_tutorial_works() {
    follow("docs/tutorial.md");
}

#[test]
fn the_programs_of_the_guide_run() {
    follow("docs/integration.md");
}

/// The example force file of the reference compiles.
#[test]
fn the_force_file_of_the_reference_compiles() {
    let reference = read("docs/language.md");
    let source = Source::new("reference.rs", block(&reference, "## A force file"));
    let compiled =
        compile(&source, &|_| true, forcec::Effort::Quick).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!((compiled.names, compiled.warnings.len()), (vec!["point_to_point".to_owned()], 0));
}

/// The recipe for snapshots, followed in a separate crate: the first run writes the snapshots, the second run
/// compares, and a change of the force file fails and shows the changed line.
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
    // The version of insta that this repository uses, without default features, is available without a
    // network.
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

/// The anchors that GitHub and mdBook generate for the headings of a document; repeated headings get a
/// number.
fn anchors(text: &str) -> Vec<String> {
    let mut anchors: Vec<String> = Vec::new();
    let outside = text.split("\n```").step_by(2).flat_map(str::lines);
    for heading in outside.filter(|line| line.starts_with('#')) {
        let kept = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
        let anchor: String = kept.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect();
        let alike = |own: &&String| {
            own.rsplit_once('-').map_or(*own == &anchor, |(head, _)| head == anchor || *own == &anchor)
        };
        let before = anchors.iter().filter(alike).count();
        anchors.push(if before == 0 { anchor } else { format!("{anchor}-{before}") });
    }
    anchors
}

#[test]
fn links_lead_somewhere() {
    for path in documents() {
        let text = read(&path);
        let folder = Path::new(&path).parent().unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            if link.starts_with("https://") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { PathBuf::from(&path) } else { folder.join(file) };
            assert!(root().join(&target).exists(), "{path} links to {link}");
            if !heading.is_empty() {
                let found = anchors(&read(target.to_str().unwrap())).iter().any(|anchor| anchor == heading);
                assert!(found, "{path} links to {link}");
            }
        }
    }
}

/// The book contains every page and no other entries.
#[test]
fn the_book_has_every_page() {
    let summary = read("docs/SUMMARY.md");
    let mut listed: Vec<String> =
        summary.split("](").skip(1).map(|rest| format!("docs/{}", rest.split(')').next().unwrap())).collect();
    listed.sort();
    let pages =
        documents().into_iter().filter(|path| path.starts_with("docs/") && !path.ends_with("SUMMARY.md"));
    assert_eq!(listed, pages.collect::<Vec<String>>());
}
