//! Invalid and suspicious inputs get the right messages, at the right columns.
//!
//! The cases are in `tests/wrong`. The diagnostics of a line of a case are stated below the line:
//!
//! ```text
//!     let d = b.positon - a.position;
//! //~           ^^^^^^^ no such field on `Particle`
//! //~ ERROR unknown field `positon`
//! //~ HELP did you mean `position`?
//! ```
//!
//! The first line has the label at its columns, or after the numbers of the columns where `//~` is in the way. All
//! diagnostics of a case must be stated. `renderings` has cases whose complete output is compared. `FORCEC_BLESS=1`
//! writes annotations and renderings.

#[path = "../../../tests/src/wrong.rs"]
pub(crate) mod inputs;

use forcec::internals::check;
use forcec::internals::source::diagnostic::{Diagnostic, Diagnostics, Severity};
use forcec::internals::source::span::Source;
use forcec::internals::syntax;

/// The errors of a text, or the warnings if the text is valid.
fn diagnostics(name: &str, text: &str) -> Diagnostics {
    let source = Source::new(name, text);
    let found = match syntax::parse(&source).and_then(|file| check::check(&file)) {
        Err(errors) => {
            assert!(errors.has_errors(), "{name} is rejected without an error");
            errors
        }
        Ok(checked) => Diagnostics::new(source, checked.warnings),
    };
    assert!(!found.list.is_empty(), "{name} gets no message");
    found
}

/// The lines that state a diagnostic at a column.
fn annotation(diagnostic: &Diagnostic, code: &str, column: usize) -> String {
    let width = code.chars().count().max(1);
    let columns = match column {
        1..4 => format!(" {column}-{}", column + width - 1),
        _ => " ".repeat(column - 4) + &"^".repeat(width),
    };
    let severity = match diagnostic.severity {
        Severity::Error => "ERROR",
        Severity::Warning => "WARNING",
    };
    let lint = diagnostic.lint.map(|lint| format!("[{}]", lint.name())).unwrap_or_default();
    let help = diagnostic.help.iter().map(|help| format!("//~ HELP {help}\n")).collect::<String>();
    format!("//~{columns} {}\n//~ {severity}{lint} {}\n{help}", diagnostic.whole_label(), diagnostic.message)
}

/// A case with its diagnostics below its lines.
fn annotated(name: &str, text: &str) -> String {
    let found = diagnostics(name, text);
    let mut written = 0;
    let mut lines = String::new();
    for (number, line) in (1..).zip(text.split_inclusive('\n')) {
        lines.push_str(line);
        for (diagnostic, span) in found.list.iter().filter_map(|own| Some((own, own.span?))) {
            let (place, column) = found.source.line_column(span.start);
            if place == number {
                lines += &annotation(diagnostic, &text[span.start as usize..span.end as usize], column);
                written += 1;
            }
        }
    }
    assert_eq!(written, found.list.len(), "{name} belongs in `renderings`: a message is at no line");
    lines
}

/// Each line of the code, with its number in the file and its diagnostics.
fn stated(file: &str) -> Vec<(usize, &str, Vec<String>)> {
    let mut lines: Vec<(usize, &str, Vec<String>)> = Vec::new();
    for (number, line) in (1..).zip(file.lines()) {
        let continues = ["//~ ERROR", "//~ WARNING", "//~ HELP"].iter().any(|start| line.starts_with(start));
        match lines.last_mut() {
            Some((_, _, own)) if continues && !own.is_empty() => {
                own.last_mut().expect("it is not empty").extend(["\n", line])
            }
            Some((_, _, own)) if line.starts_with("//~") => own.push(line.to_owned()),
            _ => lines.push((number, line, Vec::new())),
        }
    }
    lines
}

/// The differences between a file as written and the same file with the diagnostics found.
fn differences(path: &str, written: &str, found: &str) -> String {
    let mut text = String::new();
    for ((number, code, written), (_, _, found)) in stated(written).into_iter().zip(stated(found)) {
        let missing = written.iter().filter(|own| !found.contains(own)).map(|own| ("missing", own));
        let unexpected = found.iter().filter(|own| !written.contains(own)).map(|own| ("unexpected", own));
        for (difference, own) in missing.chain(unexpected) {
            text += &format!("{path}:{number}: {difference}\n{code}\n{own}\n\n");
        }
    }
    text
}

#[test]
fn wrong_inputs_get_their_messages() {
    let bless = std::env::var_os("FORCEC_BLESS").is_some();
    let (mut failures, mut count) = (String::new(), 0);
    for path in inputs::files("") {
        let shown = format!("tests/wrong/{}", path.file_name().expect("a file").to_string_lossy());
        let written = std::fs::read_to_string(&path).expect("a force file");
        let mut parts = written.split(inputs::SEPARATOR);
        let mut found = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (name, case) = part.split_once('\n').expect("a case has lines");
            found += inputs::SEPARATOR;
            found += &format!("{name}\n{}", annotated(name, &inputs::stripped(case)));
            count += 1;
        }
        if bless {
            std::fs::write(&path, found).expect("to write the annotations");
        } else if written != found {
            failures += &format!("{shown} is not as FORCEC_BLESS=1 writes it\n\n");
            failures += &differences(&shown, &written, &found);
        }
    }
    assert!(count >= 174, "{count} cases");
    assert!(failures.is_empty(), "\n{failures}");
}

#[test]
fn messages_are_rendered_in_full() {
    let bless = std::env::var_os("FORCEC_BLESS").is_some();
    let (mut failures, paths) = (String::new(), inputs::files("renderings"));
    for path in &paths {
        let name = format!("tests/wrong/renderings/{}", path.file_name().expect("a file").to_string_lossy());
        let text = std::fs::read_to_string(path).expect("a force file");
        let found = format!("{}\n", diagnostics(&name, &text));
        let expected = path.with_extension("stderr");
        if bless {
            std::fs::write(&expected, &found).expect("to write the message");
        } else if std::fs::read_to_string(&expected).unwrap_or_default() != found {
            failures += &format!("{name} gets another message:\n{found}\n");
        }
    }
    assert!(paths.len() >= 15, "{} renderings", paths.len());
    assert!(failures.is_empty(), "\n{failures}");
}
