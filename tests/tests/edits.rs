//! Small edits cause small changes: the number of kernel lines that change with a constant, a parameter or a
//! name.
//!
//! Every library function gets every possible edit: each number is made larger by a quarter; a parameter is
//! added at the end, unused, and as an offset of the row of a constraint; each `let` is renamed.
//!
//! Kernels are compiled with `--effort quick`: the search of the other effort levels takes another path after
//! nearly any edit, and most lines of the kernel change.
//!
//! Some of these edits cause large changes in the kernel: a factor that was 1 in every derivative, ½ · 2,
//! becomes a multiplication in all terms; a name appears in every line that uses the variable, and a longer
//! name breaks lines at other places. The assertions are: the median edit of each kind but one changes at
//! most a tenth of the lines, for constants an eighth, and the number of edits above a tenth does not grow.
//! The test prints the edits above the limit.

use forcec::internals::compile::compile;
use forcec::internals::emit;
use forcec::internals::kernel::{Precision, Target};
use forcec::internals::source::span::Source;
use forcec_tests::{library, options_for, parallel};
use quote::{ToTokens, format_ident};
use std::path::Path;
use syn::visit_mut::{VisitMut, visit_expr_mut, visit_pat_ident_mut};

const KINDS: [&str; 3] = ["constraint", "energy", "force"];

/// The effect of one edit.
struct Edit {
    function: String,
    what: String,
    /// Changed lines of the kernel.
    changed: usize,
    /// Lines with changes apart from the renamed variable.
    structure: usize,
    lines: usize,
}

impl Edit {
    /// The fraction of changed lines; for a renamed `let`, of lines with changes apart from the name.
    fn share(&self) -> f64 {
        let changed = if self.what.starts_with("let") { self.structure } else { self.changed };
        changed as f64 / self.lines as f64
    }
}

/// The kernel of one function of a file.
fn kernel(file: &syn::File, name: &str) -> Option<String> {
    let source = Source::new("edited.rs", prettyplease::unparse(file));
    let compiled = compile(&source, &|wanted| wanted == name, forcec::Effort::Quick).ok()?;
    // Other options make another kernel, or a message: of some edits, for the whole file is compiled.
    let length = source.text.len();
    if length.is_multiple_of(32)
        && let Err(errors) = forcec::compile(&source.text, &options_for(&source.text, length as u64))
    {
        assert!(errors.has_errors(), "{errors}");
    }
    let text = emit::kernel(&compiled.functions.first()?.kernel, Target::C, Precision::F64);
    // The head repeats the source in formulas, and bounds that change with any number.
    text.split_once("\n */\n").map(|(_, code)| code.to_owned())
}

/// The number of lines of one text missing from the other text: the larger number of both directions.
fn changed(before: &str, after: &str) -> usize {
    let (x, y): (Vec<&str>, Vec<&str>) = (before.lines().collect(), after.lines().collect());
    let mut longest = vec![0; y.len() + 1];
    for line in &x {
        let mut diagonal = 0;
        for (column, other) in y.iter().enumerate() {
            let above = longest[column + 1];
            longest[column + 1] = if line == other { diagonal + 1 } else { above.max(longest[column]) };
            diagonal = above;
        }
    }
    x.len().max(y.len()) - longest[y.len()]
}

/// A kernel with every statement on one line.
fn statements(kernel: &str) -> String {
    kernel.split_whitespace().collect::<Vec<_>>().join(" ").replace("; ", ";\n")
}

/// Makes the number at one position larger by a quarter.
struct Larger {
    at: usize,
    met: usize,
    what: Option<String>,
}

impl VisitMut for Larger {
    fn visit_lit_float_mut(&mut self, literal: &mut syn::LitFloat) {
        let value: f64 = literal.base10_parse().unwrap();
        if value == 0.0 {
            return;
        }
        if self.met == self.at {
            self.what = Some(format!("{literal} → {:?}", value * 1.25));
            *literal = syn::LitFloat::new(&format!("{:?}", value * 1.25), literal.span());
        }
        self.met += 1;
    }
}

/// Renames the variable bound by the `let` at one position, and all variables of the same name.
struct Renamed {
    at: usize,
    names: Vec<String>,
    renaming: bool,
}

impl Renamed {
    fn wanted(&self, ident: &syn::Ident) -> bool {
        self.renaming && self.names.get(self.at).is_some_and(|name| ident == name)
    }
}

impl VisitMut for Renamed {
    fn visit_pat_ident_mut(&mut self, pattern: &mut syn::PatIdent) {
        let name = pattern.ident.to_string();
        if !self.renaming && !self.names.contains(&name) {
            self.names.push(name);
        } else if self.wanted(&pattern.ident) {
            pattern.ident = format_ident!("{name}_new");
        }
        visit_pat_ident_mut(self, pattern);
    }

    fn visit_expr_mut(&mut self, expr: &mut syn::Expr) {
        visit_expr_mut(self, expr);
        if let syn::Expr::Path(path) = expr
            && let Some(ident) = path.path.get_ident()
            && self.wanted(ident)
        {
            path.path = format_ident!("{ident}_new").into();
        }
        if let syn::Expr::Struct(wrench) = expr {
            // `force` alone is `force: force`.
            wrench.fields.iter_mut().for_each(|field| field.colon_token = Some(Default::default()));
        }
    }
}

/// Every edit of the functions of a file.
fn edits(stem: &str) -> Vec<Edit> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../constraints/{stem}.rs"));
    let file = syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap();
    let mut edits = Vec::new();
    for (index, item) in file.items.iter().enumerate() {
        let syn::Item::Fn(function) = item else { continue };
        let kind = function.attrs.iter().find_map(|a| KINDS.into_iter().find(|kind| a.path().is_ident(kind)));
        let Some(kind) = kind else { continue };
        let name = function.sig.ident.to_string();
        let before = kernel(&file, &name).expect("the library compiles");
        let mut measure = |what: String, edited: &syn::ItemFn, renamed: Option<&str>| {
            let mut file = file.clone();
            file.items[index] = syn::Item::Fn(edited.clone());
            let after = kernel(&file, &name).unwrap_or_else(|| panic!("{name}: {what} does not compile"));
            // The old name is restored at every use. Line breaks may still differ, so statements are compared.
            let restored = renamed.map_or(after.clone(), |old| after.replace(&format!("{old}_new"), old));
            let structure = changed(&statements(&before), &statements(&restored));
            let changed = changed(&before, &after);
            let lines = before.lines().count();
            edits.push(Edit { function: name.clone(), what, changed, structure, lines });
        };
        for at in 0.. {
            let (mut edited, mut larger) = (function.clone(), Larger { at, met: 0, what: None });
            larger.visit_block_mut(&mut edited.block);
            let Some(what) = larger.what else { break };
            measure(format!("constant: {what}"), &edited, None);
        }
        let mut added = function.clone();
        added.sig.inputs.push(syn::parse_quote!(extra: Real));
        measure("parameter: unused".to_owned(), &added, None);
        let returned = function.sig.output.to_token_stream().to_string();
        if let Some(syn::Stmt::Expr(value, None)) = added.block.stmts.last_mut() {
            let old = value.clone();
            if kind == "constraint" && returned == "-> Real" {
                *value = syn::parse_quote!((#old) - extra);
                measure("parameter: offset".to_owned(), &added, None);
            }
        }
        for at in 0.. {
            let (mut edited, mut renamed) =
                (function.clone(), Renamed { at, names: Vec::new(), renaming: false });
            renamed.visit_block_mut(&mut edited.block);
            let Some(name) = renamed.names.get(at).cloned() else { break };
            renamed.renaming = true;
            renamed.visit_block_mut(&mut edited.block);
            measure(format!("let: {name}"), &edited, Some(&name));
        }
    }
    edits
}

#[test]
fn small_edits_make_small_differences() {
    let stems = library().into_iter().map(|file| file.stem).collect();
    let all: Vec<Edit> = parallel(stems, |stem: String| edits(&stem)).into_iter().flatten().collect();
    let mut faults = Vec::new();
    // Kinds of edits, the limit for the median edit, and the number of edits that may change more than a
    // tenth of the lines: the current number. The median of constants exceeds a tenth.
    let bars = [
        ("constant", 0.125, 26),
        ("parameter: unused", 0.1, 0),
        ("parameter: offset", 0.1, 7),
        ("let", 0.1, 9),
    ];
    for (kind, middle, most) in bars {
        let mut of_kind: Vec<&Edit> = all.iter().filter(|edit| edit.what.starts_with(kind)).collect();
        of_kind.sort_by(|x, y| y.share().total_cmp(&x.share()));
        let more = of_kind.iter().filter(|edit| edit.share() > 0.1).count();
        let median = of_kind[of_kind.len() / 2].share();
        println!("{kind}: {} edits, {more} change more than a tenth; median {median:.3}", of_kind.len());
        for edit in of_kind.iter().take(more) {
            println!(
                "    {:.2}  {} of {}, {} in more than the name  {}: {}",
                edit.share(),
                edit.changed,
                edit.lines,
                edit.structure,
                edit.function,
                edit.what
            );
        }
        if median > middle {
            faults.push(format!("{kind}: the edit in the middle changes {median:.3} of the lines"));
        }
        if more > most {
            faults.push(format!("{kind}: {more} edits change more than a tenth of the lines"));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
