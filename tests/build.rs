//! Writes the file that `tests/originals.rs` includes: a table of the library's functions and kernels, called with flat
//! lists of reals; the functions of some files again, over dual numbers; and random functions, as texts and as Rust.
//! Writes the file that `tests/lanes.rs` includes: its checks of each kernel of the library.
//!
//! Rust's types require two changes of a function's text: a literal becomes a dual number, and `a * b` becomes
//! `times(a, b)`, because nalgebra multiplies only its own reals from the left.

use proc_macro2::{Ident, TokenStream};
use quote::{ToTokens, format_ident, quote};
use std::path::{Path, PathBuf};
use syn::visit_mut::{VisitMut, visit_expr_mut};

/// The files whose functions are differentiated by dual numbers.
const DIFFERENTIATED: [&str; 3] = ["joints", "solids", "springs"];

#[path = "random.rs"]
mod random;

/// How many random functions there are.
const RANDOM: u64 = 200;

const KINDS: [&str; 3] = ["constraint", "energy", "force"];

fn main() {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    let folder = Path::new("../constraints");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the library is there")
        .map(|e| e.expect("readable").path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
    paths.sort();
    let (mut rows, mut duals, mut modules) = (Vec::new(), Vec::new(), Vec::new());
    let mut checks = Vec::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).expect("readable");
        let file = syn::parse_file(&text).expect("Rust");
        let stem = path.file_stem().expect("named").to_string_lossy().into_owned();
        let module = format_ident!("{stem}");
        let library = quote!(forcec_constraints::#module);
        let forces: Vec<Force> = file.items.iter().filter_map(Force::read).collect();
        checks.extend(forces.iter().map(|force| {
            let (double, single) = (&force.name, format_ident!("{}_f32", force.name));
            quote!(check::<#library::#double::Output, #library::#single::Output>)
        }));
        rows.extend(forces.iter().map(|force| force.row(&library)));
        if DIFFERENTIATED.contains(&stem.as_str()) {
            duals.extend(forces.iter().map(|force| force.dual(&quote!(#module))));
            let items = file.items.into_iter().filter_map(dual);
            modules.push(quote! {
                #[allow(clippy::all, reason = "the functions are the library's, which has its own checks")]
                mod #module { use super::dual::prelude::*; #(#items)* }
            });
        }
    }
    println!("cargo::rerun-if-changed=random.rs");
    let texts: Vec<String> = (0..RANDOM).map(random::function).collect();
    let functions: Vec<syn::ItemFn> = texts.iter().map(|text| syn::parse_str(text).expect("Rust")).collect();
    let names = functions.iter().map(|function| &function.sig.ident);
    let values = names.map(|name| {
        quote!(|x: &mut plain::Flat<'_>| {
            plain::flat(random::#name(x.take(), x.take(), x.take(), x.take(), x.take(), x.take()))
        })
    });
    let functions = functions.iter().map(|function| syn::ItemFn {
        attrs: Vec::new(),
        vis: syn::parse_quote!(pub(super)),
        ..function.clone()
    });
    let text = quote! {
        fn randoms() -> Vec<Random> { vec![#(Random { text: #texts, value: #values }),*] }
        #[allow(clippy::all, unused_parens, unused_variables, reason = "the functions are drawn at random")]
        mod random { use forcec_runtime::prelude::*; #(#functions)* }
        fn library() -> Vec<Original> { vec![#(#rows),*] }
        fn duals() -> Vec<Differentiated> { vec![#(#duals),*] }
        #(#modules)*
    };
    let count = checks.len();
    let checks = quote!(const CHECKS: [fn(); #count] = [#(#checks),*];);
    for (name, text) in [("originals.rs", text), ("lanes.rs", checks)] {
        let file = syn::parse2(text).expect("Rust");
        std::fs::write(out.join(name), prettyplease::unparse(&file))
            .expect("the build folder can be written");
    }
}

/// A force function.
struct Force {
    name: Ident,
    kind: String,
    options: String,
    arguments: Vec<(Ident, String, bool)>,
}

impl Force {
    fn read(item: &syn::Item) -> Option<Force> {
        let syn::Item::Fn(function) = item else { return None };
        let attribute = function.attrs.iter().find(|a| KINDS.iter().any(|kind| a.path().is_ident(kind)))?;
        let options = match &attribute.meta {
            syn::Meta::List(list) => list.tokens.to_string(),
            _ => String::new(),
        };
        let arguments = function.sig.inputs.iter().map(|argument| {
            let syn::FnArg::Typed(argument) = argument else { panic!("no methods") };
            let syn::Pat::Ident(name) = &*argument.pat else { panic!("plain names") };
            let (ty, reference) = match &*argument.ty {
                syn::Type::Reference(reference) => (reference.elem.to_token_stream(), true),
                ty => (ty.to_token_stream(), false),
            };
            (name.ident.clone(), ty.to_string(), reference)
        });
        Some(Force {
            name: function.sig.ident.clone(),
            kind: attribute.path().to_token_stream().to_string(),
            options,
            arguments: arguments.collect(),
        })
    }

    fn call(&self) -> impl Iterator<Item = TokenStream> {
        self.arguments
            .iter()
            .map(|(_, _, reference)| if *reference { quote!(&x.take()) } else { quote!(x.take()) })
    }

    /// The function and its kernel, in the library.
    fn row(&self, module: &TokenStream) -> TokenStream {
        let name = &self.name;
        let text = name.to_string();
        let call = self.call();
        let body = |ty: &str| ty == "Rigid" || ty == "Particle";
        let bodies: Vec<&Ident> = self.arguments.iter().filter(|a| body(&a.1)).map(|a| &a.0).collect();
        let mut fields: Vec<Ident> =
            self.arguments.iter().filter(|a| !body(&a.1)).map(|a| a.0.clone()).collect();
        if self.kind == "constraint" {
            fields.extend([format_ident!("stiffness"), format_ident!("damping")]);
        }
        let params =
            (!fields.is_empty()).then(|| quote!(&#module::#name::Params { #(#fields: x.take()),* },));
        quote! {
            Original {
                name: #text,
                value: |x: &mut plain::Flat<'_>| plain::flat(#module::#name(#(#call),*)),
                kernel: |x: &mut plain::Flat<'_>| {
                    #(let #bodies = x.take();)*
                    let mut out = #module::#name::Output::default();
                    #module::#name::evaluate(#(&#bodies,)* #params &mut out);
                    out.dfdx.as_flattened().to_vec()
                },
            }
        }
    }

    /// The function over dual numbers.
    fn dual(&self, module: &TokenStream) -> TokenStream {
        let (name, kind) = (&self.name, &self.kind);
        let text = name.to_string();
        let call = self.call();
        let unilateral = self.options.contains("unilateral");
        let per_row = self.options.contains("per_row");
        let bodies = self.arguments.iter().filter_map(|(_, ty, _)| match ty.as_str() {
            "Rigid" => Some(quote!(true)),
            "Particle" => Some(quote!(false)),
            _ => None,
        });
        quote! {
            Differentiated {
                name: #text,
                kind: #kind,
                unilateral: #unilateral,
                per_row: #per_row,
                rigid: &[#(#bodies),*],
                value: |x: &mut dual::Flat<'_>| dual::flat(#module::#name(#(#call),*)),
            }
        }
    }
}

/// An item over dual numbers; `use` items are left out.
fn dual(item: syn::Item) -> Option<syn::Item> {
    let syn::Item::Fn(mut function) = item else { return None };
    function.attrs.clear();
    function.vis = syn::parse_quote!(pub(super));
    Duals.visit_block_mut(&mut function.block);
    Some(syn::Item::Fn(function))
}

/// An expression without brackets around it.
fn bare(expr: &syn::Expr) -> &syn::Expr {
    match expr {
        syn::Expr::Paren(paren) => bare(&paren.expr),
        other => other,
    }
}

struct Duals;

impl VisitMut for Duals {
    fn visit_expr_mut(&mut self, expr: &mut syn::Expr) {
        visit_expr_mut(self, expr);
        *expr = match &*expr {
            syn::Expr::Lit(literal) if matches!(literal.lit, syn::Lit::Float(_)) => {
                syn::parse_quote!(real(#literal))
            }
            syn::Expr::Cast(cast) => {
                let value = &cast.expr;
                syn::parse_quote!(real(#value as f64))
            }
            syn::Expr::Path(path) if path.path.is_ident("PI") => syn::parse_quote!(real(PI)),
            syn::Expr::Binary(syn::ExprBinary { left, op: syn::BinOp::Mul(_), right, .. }) => {
                let (left, right) = (bare(left), bare(right));
                syn::parse_quote!(times(#left, #right))
            }
            _ => return,
        };
    }
}
