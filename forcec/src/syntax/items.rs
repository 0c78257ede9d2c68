//! Items: functions and constants; for any other item, the error says what to write instead.

use crate::source::span::Span;
use crate::syntax::ast::{self, Argument, Constant, Function, FunctionKind};
use crate::syntax::attributes::Stated;
use crate::syntax::reader::Reader;

impl Reader<'_> {
    pub(super) fn file(&mut self, attributes: &[syn::Attribute], items: &[syn::Item]) {
        let stated = self.attributes(attributes);
        self.docs = stated.docs;
        self.allowed = stated.allowed;
        for item in items {
            self.item(item);
        }
    }

    fn item(&mut self, item: &syn::Item) {
        let what = match item {
            syn::Item::Fn(function) => return self.function(function),
            syn::Item::Const(constant) => {
                self.attributes(&constant.attrs);
                if let Some(constant) = self.constant(constant) {
                    self.constants.push(constant);
                }
                return;
            }
            syn::Item::Use(item) => return self.imports(&item.tree, ""),
            syn::Item::Mod(module) => return self.module(module),
            syn::Item::Struct(item) => ("structs", self.at(item.struct_token.span)),
            syn::Item::Enum(item) => ("enums", self.at(item.enum_token.span)),
            syn::Item::Union(item) => ("unions", self.at(item.union_token.span)),
            syn::Item::Impl(item) => ("`impl` blocks", self.at(item.impl_token.span)),
            syn::Item::Trait(item) => ("traits", self.at(item.trait_token.span)),
            syn::Item::TraitAlias(item) => ("traits", self.at(item.trait_token.span)),
            syn::Item::Type(item) => ("type aliases", self.at(item.type_token.span)),
            syn::Item::Static(item) => ("statics", self.at(item.static_token.span)),
            syn::Item::ExternCrate(item) => ("`extern crate` items", self.at(item.extern_token.span)),
            syn::Item::ForeignMod(item) => ("foreign functions", self.at(item.abi.extern_token.span)),
            syn::Item::Macro(item) => ("macros", self.path(&item.mac.path).span),
            _ => ("such items", Span::default()),
        };
        let help = match what.0 {
            "structs" | "enums" | "unions" => "pass several values as a tuple, `(Real, Vec3)`",
            "`impl` blocks" | "traits" => "write helper functions, `fn name(value: Vec3) -> Real`",
            "type aliases" => "write the type out",
            "statics" => "write `const`",
            "macros" => "write a helper function",
            _ => "leave it out, or keep it in another file",
        };
        self.error_help(
            what.1,
            format!("{} are not part of the force language", what.0),
            "a force file holds functions, constants and `use`",
            help,
        );
    }

    /// Ignores imports, but an imported `PI` must be π.
    fn imports(&mut self, tree: &syn::UseTree, place: &str) {
        let (from, name) = match tree {
            syn::UseTree::Path(path) => return self.imports(&path.tree, &path.ident.to_string()),
            syn::UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.imports(tree, place));
            }
            syn::UseTree::Name(name) => (&name.ident, &name.ident),
            syn::UseTree::Rename(rename) => (&rename.ident, &rename.rename),
            syn::UseTree::Glob(_) => return,
        };
        if name == "PI" && !(from == "PI" && ["consts", "prelude"].contains(&place)) {
            let span = self.at(name.span());
            self.error_help(
                span,
                "another `PI` than π is imported",
                "in the force language `PI` is π",
                "import it under another name, or `std::f64::consts::PI`",
            );
        }
    }

    fn module(&mut self, module: &syn::ItemMod) {
        let stated = self.attributes(&module.attrs);
        match &module.content {
            Some((_, items)) if stated.forces => {
                let shared = stated.options.into_iter().map(|option| ast::Stated { shared: true, ..option });
                self.modules.push(module.ident.to_string());
                let inner = self.module_options.iter().cloned().chain(shared).collect();
                let outer = std::mem::replace(&mut self.module_options, inner);
                let around = self.allowed.clone();
                self.allowed.extend(stated.allowed);
                items.iter().for_each(|item| self.item(item));
                self.module_options = outer;
                self.allowed = around;
            }
            _ => {
                let name = self.at(module.ident.span());
                let span = self.at(module.mod_token.span).to(name);
                self.error_help(
                    span,
                    format!("`{}` is not a module of forces", module.ident),
                    "a force file holds functions, constants and `use`",
                    "write `#[forces]` above a module of force functions, or keep it in another file",
                );
            }
        }
    }

    /// Reads a constant at the top level or in a body.
    pub(super) fn constant(&mut self, item: &syn::ItemConst) -> Option<Constant> {
        let name = self.name(&item.ident);
        if let Some(open) = &item.generics.lt_token {
            let span = self.at(open.spans[0]);
            self.generic(span);
        }
        let outer = std::mem::take(&mut self.expressions);
        let ty = self.ty(&item.ty);
        let value = self.expr(&item.expr);
        let expressions = std::mem::replace(&mut self.expressions, outer);
        Some(Constant { name, ty, expressions, value })
    }

    pub(super) fn lifetime(&mut self, span: Span) {
        self.error_help(
            span,
            "lifetimes are not part of the force language",
            "values are copied, nothing is borrowed",
            "leave it out",
        );
    }

    fn generic(&mut self, span: Span) {
        self.error_help(
            span,
            "generics are not part of the force language",
            "every type has to be known",
            "write the types out, once for each use",
        );
    }

    fn function(&mut self, item: &syn::ItemFn) {
        self.expressions = Default::default();
        let stated = self.attributes(&item.attrs);
        let name = self.name(&item.sig.ident);
        self.modifiers(&item.sig, name.span);
        let arguments: Vec<Argument> =
            item.sig.inputs.iter().filter_map(|argument| self.argument(argument)).collect();
        let parentheses = self.between(item.sig.paren_token.span);
        let output = match &item.sig.output {
            syn::ReturnType::Type(_, ty) => self.ty(ty),
            syn::ReturnType::Default => Reader::no_type(parentheses),
        };
        let kind = stated.kind.map_or(FunctionKind::Helper, |(kind, _)| kind);
        if let (syn::ReturnType::Default, false) = (&item.sig.output, kind == FunctionKind::Helper) {
            let returns = match kind {
                FunctionKind::Constraint { .. } => "`-> Real` or `-> Vec3`, the rows of C",
                FunctionKind::Energy => "`-> Real`, the energy",
                _ => "`-> Vec3` for a particle, `-> Wrench` for a rigid body, or a tuple of these",
            };
            self.error_help(
                parentheses,
                format!("`{}` does not say what it returns", name.text),
                "no `->` after the arguments",
                format!("write {returns}"),
            );
        }
        if let (FunctionKind::Helper, Some(domain)) = (kind, stated.domain) {
            self.error_help(
                domain,
                "a domain belongs to a force function",
                format!("`{}` is a helper", name.text),
                "state the domain of the force function's own parameters",
            );
        }
        let body = self.body(&item.block);
        let Stated { docs, options, domains, allowed, .. } = stated;
        let span = name.span.to(body.span);
        let expressions = std::mem::take(&mut self.expressions);
        self.functions.push(Function {
            docs,
            kind,
            options: self.module_options.iter().cloned().chain(options).collect(),
            domains,
            name,
            arguments,
            output,
            expressions,
            body,
            span,
            allowed: self.allowed.iter().copied().chain(allowed).collect(),
        });
    }

    fn modifiers(&mut self, signature: &syn::Signature, name: Span) {
        let lifetimes = |p: &syn::GenericParam| matches!(p, syn::GenericParam::Lifetime(_));
        if let Some(open) = &signature.generics.lt_token {
            let span = self.at(open.spans[0]);
            let close = signature.generics.gt_token.as_ref().map(|close| self.at(close.spans[0]));
            let span = close.map_or(span, |close| span.to(close));
            if signature.generics.params.iter().all(lifetimes) {
                self.lifetime(span);
            } else {
                self.generic(span);
            }
        }
        if let Some(clause) = &signature.generics.where_clause {
            let span = self.at(clause.where_token.span);
            self.error_help(
                span,
                "`where` clauses are not part of the force language",
                "every type is known here",
                "leave it out",
            );
        }
        let mut words = Vec::new();
        if let Some(token) = &signature.asyncness {
            words.push(("async", token.span));
        }
        if let syn::Safety::Unsafe(token) = &signature.safety {
            words.push(("unsafe", token.span));
        }
        if let Some(abi) = &signature.abi {
            words.push(("extern", abi.extern_token.span));
        }
        for (word, span) in words {
            let span = self.at(span);
            self.error_help(
                span,
                format!("`{word}` functions are not part of the force language"),
                "a force function only computes a value",
                format!("leave `{word}` out"),
            );
        }
        if signature.variadic.is_some() {
            self.error(
                name,
                "variable numbers of arguments are not part of the force language",
                "takes `...`",
            );
        }
    }

    fn argument(&mut self, argument: &syn::FnArg) -> Option<Argument> {
        let typed = match argument {
            syn::FnArg::Typed(typed) => typed,
            syn::FnArg::Receiver(receiver) => {
                let span = self.at(receiver.self_token.span);
                self.error_help(
                    span,
                    "methods are not part of the force language",
                    "`self` has no meaning here",
                    "name the argument and write its type",
                );
                return None;
            }
        };
        self.attributes(&typed.attrs);
        let ty = self.ty(&typed.ty);
        match &*typed.pat {
            syn::Pat::Ident(pattern) if pattern.by_ref.is_none() && pattern.subpat.is_none() => {
                let name = self.name(&pattern.ident);
                Some(Argument { name, mutable: pattern.mutability.is_some(), ty })
            }
            pattern => {
                let span = self.pattern_span(pattern).unwrap_or(ty.span);
                self.error_help(
                    span,
                    "an argument is a plain name",
                    "a pattern stands here",
                    "give it a name, and take it apart with `let (p, q) = name;`",
                );
                None
            }
        }
    }
}
