//! An author's comments and file names in kernels: accepted by every compiler and never executed.

use forcec::internals::compile::{Request, compile};
use forcec::internals::emit;
use forcec::internals::kernel::{File, Precision, Target};
use forcec::internals::source::span::Source;
use std::collections::BTreeSet;

/// The printed output of all targets for a force file.
fn printed(stem: &str, text: &str, target: Target) -> String {
    let compiled = compile(&Source::new(format!("{stem}.rs"), text), &|_| true, Request::default());
    let compiled = compiled.unwrap_or_else(|errors| panic!("{errors}"));
    let kernels = compiled.functions.into_iter().map(|function| function.kernel);
    let file = File {
        stem: stem.to_owned(),
        docs: compiled.docs,
        kernels: kernels.collect(),
        precisions: vec![Precision::F64],
    };
    let files = emit::emit(&file, target).into_iter().filter(|file| file.name != "forcec.h");
    files.map(|file| file.text).collect()
}

#[test]
fn comments_hold_what_can_be_seen() {
    let text = "//! A\u{202e} file of odd\u{7} letters.\n\n#[doc = \"One\\rtwo \u{2066}three\u{2069}.\"]\n#[energy]\n\
                pub fn f(a: Particle) -> Real { a.position.z }\n";
    for target in Target::ALL {
        let printed = printed("odd\u{202e}\r", text, target);
        let odd = |c: &char| {
            c.is_control() && *c != '\n' || ('\u{200e}'..='\u{2069}').contains(c) && *c > '\u{2028}'
        };
        let odd: Vec<char> = printed.chars().filter(odd).collect();
        // A name of a header cannot contain these characters: `forcec build` refuses the file.
        assert!(target == Target::C || odd.is_empty(), "{odd:?} in {printed}");
        assert!(printed.contains("A(U+202E) file of odd  letters."), "{printed}");
        assert!(printed.contains("One two (U+2066)three(U+2069)."), "{printed}");
    }
}

/// A lone carriage return in a comment is an error in Rust too, and the message names the character.
#[test]
fn lone_carriage_returns_are_named() {
    for text in ["//! One\rtwo\n", "/// One\rtwo\n", "/** One\rtwo */\n"] {
        let text = format!("{text}#[energy]\npub fn f(a: Particle) -> Real {{ a.position.z }}\n");
        let errors = compile(&Source::new("f.rs", text), &|_| true, Request::default()).err();
        let errors = errors.expect("rustc refuses it too").to_string();
        assert!(errors.contains("carriage return"), "{errors}");
    }
}

/// Rustdoc sees no program in the comments of a kernel, and formulas are in a separate block.
#[test]
fn comments_are_no_programs() {
    let docs = [
        ("/// ```\n/// open", "```text"),
        ("/// ~~~ rust\n/// open", "~~~text"),
        ("/// ```should_panic,edition2021\n/// no\n/// ```", "```text"),
        ("/// ````c\n/// ```\n/// open", "````c"),
        ("/// So:\n///\n///     f(x)", "   f(x)"),
    ];
    for (docs, expected) in docs {
        let text = format!("{docs}\n#[energy]\npub fn f(a: Particle) -> Real {{ a.position.z }}\n");
        let text = printed("f", &text, Target::Rust);
        assert!(text.contains(&format!("/// {expected}\n")), "{docs}: {text}");
        let mut open: Option<&str> = None;
        for line in text
            .lines()
            .map_while(|line| line.strip_prefix("///").or(Some(line).filter(|l| !l.starts_with("pub mod"))))
        {
            let line = line.strip_prefix(' ').unwrap_or(line);
            assert!(open.is_some() || !line.starts_with("    "), "{text}");
            let fence = &line[..line.chars().take_while(|c| ['`', '~'].contains(c)).count()];
            match open {
                Some(begun) if fence.starts_with(begun) && line.trim() == fence => open = None,
                None if fence.len() >= 3 => {
                    assert!(["text", "c"].contains(&line[fence.len()..].trim()), "{text}");
                    open = Some(fence);
                }
                _ => {}
            }
        }
        assert_eq!(open, None, "{text}");
    }
}

/// Headers with different names have different guards, and no name of a kernel equals a guard macro.
#[test]
fn headers_have_guards_of_their_own() {
    let names = [
        "ball-joint",
        "ball_joint",
        "Ball_Joint",
        "BALL_JOINT",
        "ball joint",
        "ballx2djoint",
        "b\u{e4}ll",
        "b\u{f6}ll",
    ];
    let guards: BTreeSet<String> = names
        .iter()
        .map(|name| {
            let text =
                printed(name, "#[energy]\npub fn f(a: Particle) -> Real { a.position.z }\n", Target::C);
            let guard =
                text.lines().find_map(|line| line.strip_prefix("#ifndef ")).expect("a header has a guard");
            assert!(guard.starts_with("FORCEC_") && guard.ends_with("_H"), "{guard}");
            assert!(guard.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'), "{guard}");
            guard.to_owned()
        })
        .collect();
    assert_eq!(guards.len(), names.len(), "{guards:?}");
    assert!(guards.contains("FORCEC_BALL_JOINT_H"));
}
