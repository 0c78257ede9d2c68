//! Expansion of the macros of `forcec-macros`.
//!
//! In: the tokens of a force function, of a module of force functions, or the name of a force file. Out: the
//! functions without forcec's attributes, the modules that `forcec build --target rust` writes, and their
//! runtime traits; or all errors, each at its token. Functions remain in the output after an error, so that
//! editors still complete names in them.

mod manifest;
mod places;
mod plain;
mod runtime;

use crate::compile::{Asked, Stages, compile_all, elaborated, fitted, optimize_all};
use crate::emit::rust::{body_type, kernel_module, module_name};
use crate::emit::rust_body;
use crate::kernel::{Kernel, Precision};
use crate::layout::{Lanes, Layout};
use crate::macros::runtime::{COMPANIONS, Companion, ties};
use crate::model::outputs::Part;
use crate::names::is_module;
use crate::options::Request;
use crate::source::diagnostic::{Diagnostic, Diagnostics};
use crate::source::span::{Source, Span, shown};
use crate::syntax::{self, ast};
use crate::vector::definition::Definition;
use places::{Places, mixed};
use plain::{FORCES, is_named, is_pi, names_pi, plain, without_inner};
use proc_macro2::{Delimiter, Group, Ident, Literal, TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote, quote_spanned};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use syn::parse::{ParseStream, Parser};

/// `#[constraint]`, `#[energy]` or `#[force]`, by name, on one function.
pub fn function(name: &str, options: TokenStream, item: TokenStream) -> TokenStream {
    if let Some(error) = unfit(&item) {
        return error.into_iter().chain(item).collect();
    }
    let attribute = attribute(name, &options);
    let read = match syn::parse2::<syn::Item>(item.clone()) {
        Ok(syn::Item::Fn(function)) => function,
        Ok(other) => {
            let message = Diagnostic::error(
                Span::default(),
                format!("`#[{name}]` applies to functions"),
                "not a function",
            )
            .help("write it above `fn`; a module of force functions is marked `#[forces]`");
            return complaint(&message, first(&other), first(&other)).into_iter().chain(item).collect();
        }
        Err(error) => return error.to_compile_error().into_iter().chain(item).collect(),
    };
    let mut marked = attribute;
    marked.extend(item.clone());
    let items = match syn::parse2::<syn::Item>(marked.clone()) {
        Ok(item) => vec![item],
        Err(error) => return error.to_compile_error(),
    };
    let own = plain(item, true);
    let kernels = compiled(&items, marked, &Reading { name: &name_of(&read), alone: true });
    let pi = names_pi(&own).then(is_pi);
    quote!(#own #kernels #pi)
}

/// `#[domain(…)]` above the attribute that reads it: moves it below that attribute.
pub fn domain(options: TokenStream, item: TokenStream) -> TokenStream {
    if let Some(error) = unfit(&item) {
        return error.into_iter().chain(item).collect();
    }
    let mut tokens: Vec<TokenTree> = item.clone().into_iter().collect();
    let mark = |token: &TokenTree| matches!(token, TokenTree::Group(group) if is_named(group, &FORCES));
    if let Ok(syn::Item::Fn(function)) = syn::parse2::<syn::Item>(item.clone())
        && let Some(at) = tokens.iter().take(2 * function.attrs.len()).rposition(mark)
    {
        tokens.splice(at + 1..at + 1, quote!(#[domain(#options)]));
        return tokens.into_iter().collect();
    }
    let message = Diagnostic::error(
        Span::default(),
        "a domain belongs to a force function",
        "no attribute of one here",
    )
    .help("write `#[constraint]`, `#[energy]` or `#[force]` above it");
    let here = proc_macro2::Span::call_site();
    complaint(&message, here, here).into_iter().chain(item).collect()
}

/// `#[forces]` on a module.
pub fn module(options: TokenStream, item: TokenStream) -> TokenStream {
    if let Some(error) = unfit(&item) {
        return error.into_iter().chain(item).collect();
    }
    match syn::parse2::<syn::Item>(item.clone()) {
        Ok(syn::Item::Mod(module)) if module.content.is_some() => {}
        Ok(other) => {
            let message = Diagnostic::error(
                Span::default(),
                "`#[forces]` applies to modules of force functions",
                "not a module",
            )
            .help("write `#[forces] mod joints { … }`; for one function write `#[constraint]`, `#[energy]` or `#[force]`");
            return complaint(&message, first(&other), first(&other)).into_iter().chain(item).collect();
        }
        Err(error) => return error.to_compile_error().into_iter().chain(item).collect(),
    }
    let mut marked = attribute("forces", &options);
    marked.extend(item.clone());
    let read = match syn::parse2::<syn::Item>(marked.clone()) {
        Ok(read) => read,
        Err(error) => return error.to_compile_error(),
    };
    let kernels = compiled(&[read], marked, &Reading { name: "forces", alone: false });
    let mut own: Vec<TokenTree> = plain(item, false).into_iter().collect();
    // The body of the module is its last token.
    if let Some(TokenTree::Group(body)) = own.pop() {
        let (items, span) = (body.stream(), body.span());
        let pi = names_pi(&items).then(is_pi);
        let mut body = Group::new(Delimiter::Brace, quote!(#items #kernels #pi));
        body.set_span(span);
        own.push(body.into());
    }
    own.into_iter().collect()
}

/// `include_forces!("joints.rs")`: a module named after the file, with its items. The path is relative to the
/// calling file, as in `include_str!`.
pub fn file(input: TokenStream) -> TokenStream {
    let included = match Included::read(input) {
        Ok(included) => included,
        Err(errors) => return errors,
    };
    let at = included.path.span();
    let failed = |message: &str, label: String, help: &str| {
        complaint(&Diagnostic::error(Span::default(), message, label).help(help), at, at)
    };
    let path = resolve(&included.path);
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) => {
            let label = format!("`{}`: {error}", shown(&path));
            return failed(
                "cannot read the force file",
                label,
                "the path is relative to the file that contains it",
            );
        }
    };
    let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    if !is_module(&stem) {
        let label = format!("`{stem}` is not a valid module name");
        return failed("a force file names a module", label, "rename the file");
    }
    let name = format_ident!("{stem}");
    let shown = included.path.value();
    let result = with_own_tokens(|| {
        let file = syntax::parse(&Source::new(shown, text.clone()))?;
        Ok::<_, Diagnostics>((Functions::compile(&file, &included.request)?, file))
    });
    // Makes cargo rebuild when the file changes.
    let path = path.to_string_lossy();
    let watched = quote!(
        const _: &[u8] = ::core::include_bytes!(#path);
    );
    let (functions, ast) = match result {
        Ok(result) => result,
        Err(errors) => {
            let errors = errors.list.iter().map(|error| rendered(&errors.source, error, at));
            return quote!(#watched #(#errors)*);
        }
    };
    if functions.forces.is_empty() {
        let label = format!("`{path}` has none");
        return failed(
            "no force function",
            label,
            "mark one with `#[constraint]`, `#[energy]` or `#[force]`",
        );
    }
    let tokens = match TokenStream::from_str(&text) {
        Ok(tokens) => tokens,
        Err(error) => return syn::Error::from(error).to_compile_error(),
    };
    if let Some(error) = unfit(&tokens) {
        return error;
    }
    let file = match syn::parse2::<syn::File>(tokens.clone()) {
        Ok(file) => file,
        Err(error) => return error.to_compile_error(),
    };
    let own = plain(without_inner(tokens), false);
    let pi = names_pi(&own).then(is_pi);
    let docs = file.attrs.iter().filter(|attribute| attribute.path().is_ident("doc"));
    let visibilities = visibilities(&file.items);
    let kernels = kernels(&functions, &ast, &visibilities, "forces", &included.request);
    quote! {
        pub mod #name {
            #(#docs)*
            #watched
            #own
            #kernels
            #pi
        }
    }
}

/// The arguments `"joints.rs", real = f32`.
struct Included {
    path: syn::LitStr,
    request: Request,
}

impl Included {
    fn read(input: TokenStream) -> Result<Included, TokenStream> {
        let parser = |input: ParseStream<'_>| {
            let path: syn::LitStr = input.parse().map_err(|error| {
                syn::Error::new(
                    error.span(),
                    "`include_forces!` takes the path of a force file\n\n  = help: write `include_forces!(\"joints.rs\")`",
                )
            })?;
            input.parse::<Option<syn::Token![,]>>()?;
            Ok((path, input.parse::<TokenStream>()?))
        };
        let (path, options) = parser.parse2(input).map_err(|error| error.to_compile_error())?;
        if let Some(error) = unfit(&options) {
            return Err(error);
        }
        // The options are those of a module.
        let mut marked = attribute("forces", &options);
        let places = Places::new(marked.clone());
        marked.extend(quote!(
            mod forces {}
        ));
        let item = syn::parse2::<syn::Item>(marked).map_err(|error| error.to_compile_error())?;
        match syntax::options(&item, |span| places.of(span)) {
            Ok(choices) => Ok(Included { path, request: Request::default().with(&choices) }),
            Err(errors) => Err(errors
                .iter()
                .map(|error| {
                    let (start, end) = places.ends(error.span);
                    complaint(error, start, end)
                })
                .collect()),
        }
    }
}

/// The path of an included file, relative to the calling file; relative to the crate's folder if the calling
/// file is unknown, as in some editors.
fn resolve(path: &syn::LitStr) -> PathBuf {
    let written = PathBuf::from(path.value());
    if let Some(caller) = path.span().local_file() {
        let folder = caller.parent().unwrap_or(Path::new("")).to_owned();
        let folder = std::env::current_dir().map(|here| here.join(&folder)).unwrap_or(folder);
        return folder.join(written);
    }
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let source = root.join("src").join(&written);
    if source.exists() { source } else { root.join(written) }
}

/// Runs work that creates its own tokens on several threads, which the compiler's tokens do not allow.
fn with_own_tokens<T>(work: impl FnOnce() -> T) -> T {
    struct Restore;
    impl Drop for Restore {
        fn drop(&mut self) {
            proc_macro2::fallback::unforce();
        }
    }
    proc_macro2::fallback::force();
    let _restore = Restore;
    work()
}

/// The error about tokens that exceed the parser's limits.
fn unfit(tokens: &TokenStream) -> Option<TokenStream> {
    let error = syntax::check_limits(tokens.clone()).err()?;
    let here = proc_macro2::Span::call_site();
    Some(complaint(&error, here, here))
}

/// The input of a macro.
struct Reading<'a> {
    /// The name of the module of kernels.
    name: &'a str,
    /// Whether the input is a single function, which cannot use other items.
    alone: bool,
}

/// The kernels of items, or the errors.
fn compiled(items: &[syn::Item], tokens: TokenStream, reading: &Reading<'_>) -> TokenStream {
    let request = Request::default();
    let places = Places::new(tokens);
    let source = Source::new(reading.name, places.text.as_str());
    let result = syntax::from_items(source, &[], items, |span| places.of(span)).and_then(|ast| {
        match mixed(&ast, &places) {
            errors if errors.is_empty() => Ok((Functions::compile(&ast, &request)?, ast)),
            errors => Err(Diagnostics::new(ast.source, errors)),
        }
    });
    match result {
        Ok((functions, _)) if functions.forces.is_empty() => {
            let here = proc_macro2::Span::call_site();
            let message =
                Diagnostic::error(Span::default(), "no force function in this module", "there is none")
                    .help("mark one with `#[constraint]`, `#[energy]` or `#[force]`");
            complaint(&message, here, here)
        }
        Ok((functions, ast)) => kernels(&functions, &ast, &visibilities(items), reading.name, &request),
        Err(errors) => {
            let complaints = errors.list.into_iter().map(|mut error| {
                let (start, end) = places.ends(error.span);
                let unknown = error.message.starts_with("unknown function")
                    || error.message.starts_with("unknown name");
                if reading.alone && unknown && error.help.is_none() {
                    error.help = Some(
                        "a function alone sees no other items; write `#[forces] mod …` around all of them"
                            .to_owned(),
                    );
                }
                complaint(&error, start, end)
            });
            complaints.collect()
        }
    }
}

/// The compiled force functions of a file.
struct Functions {
    forces: Vec<Stages>,
    /// For each function, the kernels that the runtime calls.
    companions: HashMap<String, Vec<Companion>>,
}

impl Functions {
    /// Compiles kernels and fits them to their precisions: splits numbers that a precision cannot represent.
    fn compile(file: &ast::File, request: &Request) -> Result<Functions, Diagnostics> {
        let asked = elaborated(file, &|_| true, request.clone())?.functions;
        let mut forces = compile_all(file, asked.clone())?;
        let mut errors = Vec::new();
        let mut fit = |definition: &Definition, kernel: &mut Kernel| match fitted(
            definition,
            kernel,
            &precisions(file, &definition.name, request),
        ) {
            Ok(fitted) => *kernel = fitted,
            Err(error) => errors.push(error),
        };
        forces.iter_mut().for_each(|stages| fit(&stages.definition, &mut stages.kernel));
        let mut companions: HashMap<String, Vec<Companion>> = HashMap::new();
        for row in &COMPANIONS {
            let tied = asked.iter().zip(&forces).filter(|(_, stages)| is_tied(stages));
            let tied = tied.filter(|(asked, _)| (row.is_of)(&asked.definition.law));
            let wanted = tied.map(|(asked, _)| {
                let outputs = row.outputs.to_vec();
                let request = Request { outputs, prepare: false, settled: true, ..asked.request.clone() };
                Asked { request, ..asked.clone() }
            });
            for function in optimize_all(file, wanted.collect())? {
                let companions = companions.entry(function.definition.name.clone()).or_default();
                for form in row.forms {
                    let mut kernel = function.kernel(form.lanes);
                    fit(&function.definition, &mut kernel);
                    companions.push(Companion { form, kernel });
                }
            }
        }
        if errors.is_empty() {
            Ok(Functions { forces, companions })
        } else {
            Err(Diagnostics::new(file.source.clone(), errors))
        }
    }
}

/// The precisions in which the kernels of a function are printed.
fn precisions(file: &ast::File, name: &str, request: &Request) -> Vec<Precision> {
    let own = file.function(name).map(ast::Function::choices);
    let precisions = request.of(own.into_iter().flatten()).precisions;
    if precisions.is_empty() { Precision::ALL.to_vec() } else { precisions }
}

/// Whether the runtime can call a kernel: default outputs in full, one instance at a time, no fixed body.
fn is_tied(function: &Stages) -> bool {
    let (kernel, bodies) = (&function.kernel, &function.definition.graph.signature.bodies);
    let whole = function.outputs() == Part::DEFAULT
        && (kernel.layout, kernel.lanes) == (Layout::Dense, Lanes::One)
        && kernel.once().is_none();
    whole && bodies.iter().all(|body| !body.fixed)
}

/// The modules of kernels, their runtime traits, and imports of the modules next to the functions.
fn kernels(
    functions: &Functions,
    ast: &ast::File,
    visibilities: &HashMap<String, syn::Visibility>,
    name: &str,
    request: &Request,
) -> TokenStream {
    let inner = format_ident!("forcec_{}", name.trim_start_matches("r#"));
    let (mut modules, mut names) = (TokenStream::new(), TokenStream::new());
    // The modules of the companions, each with the names of their body types.
    let mut others: BTreeMap<&str, (BTreeSet<String>, TokenStream)> = BTreeMap::new();
    let mut bodies: Vec<Ident> = Vec::new();
    let mut several: Vec<String> = Vec::new();
    let parsed = |text: &str| {
        TokenStream::from_str(text).unwrap_or_else(|error| syn::Error::from(error).to_compile_error())
    };
    for function in &functions.forces {
        let (kernel, source) = (&function.kernel, &function.definition.name);
        for precision in precisions(ast, source, request) {
            modules.extend(parsed(&kernel_module(kernel, precision)));
            if let Some(companions) = functions.companions.get(source) {
                for Companion { form, kernel } in companions {
                    let (bodies, modules) = others.entry(form.module).or_default();
                    let own = kernel.schedule.signature.bodies.iter();
                    bodies.extend(own.map(|body| rust_body(body.kind.row(), precision, kernel.lanes)));
                    modules.extend(parsed(&kernel_module(kernel, precision)));
                }
                modules.extend(ties(function, companions, precision));
            }
            let module = format_ident!("{}", module_name(kernel, precision));
            let visibility = visibilities.get(source);
            // The kernel need not be called.
            names.extend(quote! {
                #visibility use #inner::#module;
                const _: () = _ = #module::NAME;
            });
            for body in &kernel.schedule.signature.bodies {
                let row = body.kind.row();
                if !kernel.lanes.is_one() {
                    let text = body_type(row, precision, kernel.lanes);
                    if !several.contains(&text) {
                        several.push(text);
                    }
                    continue;
                }
                let name = format_ident!("{}", rust_body(row, precision, kernel.lanes));
                if !bodies.contains(&name) {
                    bodies.push(name);
                }
            }
        }
    }
    let others = others.iter().map(|(module, (bodies, modules))| {
        let name = format_ident!("{module}");
        let bodies = bodies.iter().map(|body| format_ident!("{body}"));
        quote! {
            mod #name {
                use ::forcec_runtime::{#(#bodies),*};
                #modules
            }
        }
    });
    let several = several.iter().map(|text| parsed(text));
    let bodies = (!bodies.is_empty()).then(|| quote!(use ::forcec_runtime::{#(#bodies),*};));
    let kernels = quote! {
        #names
        mod #inner {
            #bodies
            #(#several)*
            #modules
            #(#others)*
        }
    };
    match manifest::runtime() {
        Some(name) => renamed(kernels, &name),
        None => kernels,
    }
}

/// Replaces `forcec_runtime` in generated tokens by the crate's name for the runtime.
fn renamed(tokens: TokenStream, name: &str) -> TokenStream {
    let token = |token| match token {
        TokenTree::Ident(ident) if ident == "forcec_runtime" => Ident::new(name, ident.span()).into(),
        TokenTree::Group(group) => {
            let mut inner = Group::new(group.delimiter(), renamed(group.stream(), name));
            inner.set_span(group.span());
            inner.into()
        }
        other => other,
    };
    tokens.into_iter().map(token).collect()
}

/// The visibility of each function.
fn visibilities(items: &[syn::Item]) -> HashMap<String, syn::Visibility> {
    let mut found = HashMap::new();
    let mut pending: Vec<&syn::Item> = items.iter().collect();
    while let Some(item) = pending.pop() {
        match item {
            syn::Item::Fn(function) => _ = found.insert(name_of(function), function.vis.clone()),
            syn::Item::Mod(module) => pending.extend(module.content.iter().flat_map(|(_, items)| items)),
            _ => {}
        }
    }
    found
}

fn name_of(function: &syn::ItemFn) -> String {
    function.sig.ident.to_string()
}

/// `#[name(options)]`
fn attribute(name: &str, options: &TokenStream) -> TokenStream {
    let name = format_ident!("{name}");
    if options.is_empty() { quote!(#[#name]) } else { quote!(#[#name(#options)]) }
}

fn first(item: &syn::Item) -> proc_macro2::Span {
    let tokens = item.to_token_stream().into_iter();
    tokens.map(|token| token.span()).next().unwrap_or_else(proc_macro2::Span::call_site)
}

/// A compile error with this text, from one token to another.
fn complaint(error: &Diagnostic, start: proc_macro2::Span, end: proc_macro2::Span) -> TokenStream {
    let mut message = format!("{}\n", error.message);
    if !error.label.is_empty() {
        message.push_str(&format!("\n  = note: {}", error.label));
    }
    if let Some(help) = &error.help {
        message.push_str(&format!("\n  = help: {help}"));
    }
    compile_error(message.trim_end(), start, end)
}

/// A compile error in a file that rustc does not read: includes the source lines.
fn rendered(source: &Source, error: &Diagnostic, at: proc_macro2::Span) -> TokenStream {
    let text = Diagnostics::new(source.clone(), vec![error.clone()]).render(false);
    compile_error(text.strip_prefix("error: ").unwrap_or(&text), at, at)
}

fn compile_error(message: &str, start: proc_macro2::Span, end: proc_macro2::Span) -> TokenStream {
    let mut message = Literal::string(message);
    message.set_span(end);
    let mut group = Group::new(Delimiter::Brace, TokenTree::from(message).into());
    group.set_span(end);
    let path = quote_spanned!(start=> ::core::compile_error!);
    path.into_iter().chain([TokenTree::from(group)]).collect()
}
