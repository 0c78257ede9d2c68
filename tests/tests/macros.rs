//! Output of the macros for a token stream: the modules that `forcec build --target rust` writes, and the
//! messages of the command line at the same places.

use forcec::internals::compile::compile;
use forcec::internals::emit;
use forcec::internals::kernel::{Precision, Target};
use forcec::internals::source::span::Source;
use forcec::macros;
use forcec_tests::{ForceFile, library, parallel, unseen, wrong};
use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

fn text(folder: &str, stem: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder).join(format!("{stem}.rs"));
    std::fs::read_to_string(path).unwrap()
}

/// A text inside `#[forces] mod`, on the same lines.
fn in_module(text: &str) -> Option<TokenStream> {
    format!("mod forces {{ {text}\n}}").parse().ok()
}

fn formatted(item: &syn::ItemMod) -> String {
    let file = syn::File {
        shebang: None,
        frontmatter: None,
        attrs: Vec::new(),
        items: vec![syn::Item::Mod(item.clone())],
    };
    prettyplease::unparse(&file)
}

/// The public modules among some items and within private modules, each by name.
fn kernels(items: &[syn::Item], found: &mut BTreeMap<String, String>) {
    for item in items {
        let syn::Item::Mod(module) = item else { continue };
        // The items that a world needs in addition belong to another request.
        let others = ["values", "loads", "lane_loads", "lane_rows", "saddles", "steps"];
        if others.iter().any(|other| module.ident == format!("forcec_{other}")) {
            continue;
        }
        match module.vis {
            syn::Visibility::Public(_) => _ = found.insert(module.ident.to_string(), formatted(module)),
            _ => kernels(module.content.as_ref().map_or(&[], |(_, items)| items), found),
        }
    }
}

/// The files that the command line writes for a force file.
fn written(file: &ForceFile) -> BTreeMap<String, String> {
    let generated = emit::emit(&file.printable(&PRECISIONS), Target::Rust);
    let parsed = syn::parse_file(&generated[0].text).unwrap();
    let mut found = BTreeMap::new();
    kernels(&parsed.items, &mut found);
    found
}

fn expanded(tokens: TokenStream) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    kernels(&syn::parse2::<syn::File>(tokens).unwrap().items, &mut found);
    found
}

fn assert_equal(stem: &str, macros: &BTreeMap<String, String>, written: &BTreeMap<String, String>) {
    for (name, text) in macros {
        assert!(
            *text == written[name],
            "{stem}: `{name}` from the macro is not what the command line writes"
        );
    }
}

#[test]
fn modules_are_what_the_command_line_writes() {
    for (folder, files) in [("../constraints", library()), ("unseen", unseen())] {
        let counts = parallel(files, |file| {
            let module = in_module(&text(folder, &file.stem)).unwrap();
            let expanded = expanded(macros::module(TokenStream::new(), module));
            let written = written(&file);
            assert!(expanded.keys().eq(written.keys()), "{}: the same kernels", file.stem);
            assert_equal(&file.stem, &expanded, &written);
            expanded.len()
        });
        assert!(counts.iter().sum::<usize>() > 50, "{folder} has kernels");
    }
}

#[test]
fn functions_alone_are_what_the_command_line_writes() {
    let counts = parallel(library(), |file| {
        let parsed = syn::parse_file(&text("../constraints", &file.stem)).unwrap();
        let written = written(&file);
        let mut alone = 0;
        for item in parsed.items {
            let syn::Item::Fn(mut function) = item else { continue };
            let marks = ["constraint", "energy", "force"];
            let mark = function.attrs.iter().position(|a| marks.iter().any(|m| a.path().is_ident(m)));
            let Some(mark) = mark else { continue };
            let attribute = function.attrs.remove(mark);
            let options = match &attribute.meta {
                syn::Meta::List(list) => list.tokens.clone(),
                _ => TokenStream::new(),
            };
            let name = attribute.path().get_ident().unwrap().to_string();
            let output = macros::function(&name, options, function.to_token_stream());
            // A function that needs a helper reports the missing helper.
            if errors(output.clone()).is_empty() {
                let expanded = expanded(output);
                assert_eq!(expanded.len(), 2, "{}", function.sig.ident);
                assert_equal(&file.stem, &expanded, &written);
                alone += 1;
            }
        }
        alone
    });
    assert!(counts.iter().sum::<usize>() > 20, "some functions need no helper");
}

/// Options of an attribute, of a module and of the command line give the same kernels.
#[test]
fn options_make_what_the_command_line_makes() {
    const JOINT: &str = "fn joint(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 { \
                         a.position + a.orientation * arm_a - b.position - b.orientation * arm_b }";
    for options in [
        "outputs(value, jacobian), fixed(b), set(damping = 0.0, arm_b = [0.0, 0, -0.5])",
        "layout = \"packed\", lanes = 4, mode = fast, real = f32",
        "layout = system, set(step = 0.01), fma, effort = quick",
        "set(stiffness = 1e3, damping = 2.0, arm_a = [1, 2, 3], arm_b = 0.0)",
        "real(f32, f64), outputs = force",
    ] {
        let text = format!("#[constraint({options})]\n{JOINT}");
        let compiled = compile(&Source::new("joint.rs", text.as_str()), &|_| true, forcec::Effort::Default);
        let compiled = compiled.unwrap_or_else(|errors| panic!("{errors}"));
        let mut written = BTreeMap::new();
        for precision in PRECISIONS {
            let text = emit::kernel(&compiled.functions[0].kernel, Target::Rust, precision);
            kernels(&syn::parse_file(&text).unwrap().items, &mut written);
        }
        let alone = macros::function("constraint", options.parse().unwrap(), JOINT.parse().unwrap());
        let module = format!("mod joints {{ #[constraint] {JOINT} }}");
        let module = macros::module(options.parse().unwrap(), module.parse().unwrap());
        for output in [alone, module] {
            assert!(errors(output.clone()).is_empty(), "{options}: {output}");
            let expanded = expanded(output);
            assert_eq!(expanded.len(), if options.contains("real = ") { 1 } else { 2 }, "{options}");
            assert_equal(options, &expanded, &written);
        }
    }
}

/// A wrong option gives a message at its place with the correct form.
#[test]
fn wrong_options_are_named() {
    let function = "fn tie(a: Particle, b: Particle, length: Real) -> Real { \
                    (a.position - b.position).norm_squared() - length }";
    for (options, column, message) in [
        ("layout = packd", 10, "unknown layout `packd`"),
        ("real = f32, lanes = 3", 21, "unknown number of lanes `3`"),
        ("outputs(value, forc)", 16, "unknown output `forc`"),
        ("outputs(force), layout = system", 1, "the layout `system` says itself what is computed"),
        ("fixed(c)", 7, "no body `c`"),
        ("set(damping = 0.0, lenght = 1.0)", 20, "no parameter `lenght`"),
        ("set(length = [1.0, 2.0])", 5, "`length` has 1 entry, and 2 are set"),
        ("set(length = x)", 5, "the option `set` is malformed"),
        ("lanes(4)", 1, "the option `lanes` is malformed"),
        ("lanes", 1, "the option `lanes` is malformed"),
        ("fma, fma", 6, "`fma` is stated twice"),
        ("target = rust", 1, "unknown option `target`"),
    ] {
        let alone = macros::function("constraint", options.parse().unwrap(), function.parse().unwrap());
        let found = errors(alone);
        assert_eq!(found, [(1, column, message.to_owned())].into(), "{options}");
    }
    let included = macros::file("\"joints.rs\", layout = packd".parse().unwrap());
    assert_eq!(errors(included), [(1, 23, "unknown layout `packd`".to_owned())].into());
}

/// The messages of `compile_error!` and their positions.
fn errors(tokens: TokenStream) -> BTreeSet<(usize, usize, String)> {
    let mut found = BTreeSet::new();
    let mut pending = vec![tokens];
    while let Some(tokens) = pending.pop() {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        for (at, token) in tokens.iter().enumerate() {
            let TokenTree::Group(group) = token else { continue };
            let before = at.checked_sub(2).map(|name| tokens[name].to_string());
            if before.as_deref() != Some("compile_error") {
                pending.push(group.stream());
                continue;
            }
            let text: syn::LitStr = syn::parse2(group.stream()).unwrap();
            let start = tokens[at - 2].span().start();
            let message = text.value().lines().next().unwrap().to_owned();
            found.insert((start.line, start.column + 1, message));
        }
    }
    found
}

/// Every invalid input gives the same message in a macro as on the command line, at the same token.
#[test]
fn messages_have_the_positions_of_the_command_line() {
    let (mut compared, mut passed_over) = (0, Vec::new());
    for (name, text) in wrong::cases() {
        let Err(errors_there) =
            compile(&Source::new("force.rs", text.as_str()), &|_| true, forcec::Effort::Default)
        else {
            continue;
        };
        let module = in_module(&text).filter(|module| syn::parse2::<syn::Item>(module.clone()).is_ok());
        let Some(module) = module else {
            passed_over.push(name);
            continue;
        };
        let shift = |line: usize| if line == 1 { "mod forces { ".len() } else { 0 };
        let place = |offset| errors_there.source.line_column(offset);
        let expected: BTreeSet<(usize, usize, String)> = errors_there
            .list
            .iter()
            .filter_map(|error| {
                let (line, column) = place(error.span.filter(|span| span.start < span.end)?.start);
                Some((line, column + shift(line), error.message.clone()))
            })
            .collect();
        let here = errors(macros::module(TokenStream::new(), module));
        let missing: Vec<_> = expected.difference(&here).collect();
        assert!(missing.is_empty(), "{name}: the macro does not say {missing:?}; it says {here:?}");
        compared += 1;
    }
    println!("{compared} wrong inputs say the same; not made of Rust's items: {passed_over:?}");
    assert!(compared > 100, "{compared} wrong inputs");
}
