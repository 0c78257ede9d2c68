//! Types as written: `&T` is `T`; every other type is a name, a tuple or an array.

use crate::source::span::Span;
use crate::syntax::ast::{ExprKind, Type, TypeKind};
use crate::syntax::reader::Reader;

/// Types of nalgebra and Rust, and our names for them.
pub(crate) const OTHER_NAMES: [(&str, &str); 17] = [
    ("f64", "Real"),
    ("f32", "Real"),
    ("Vector2", "Vec2"),
    ("Vector3", "Vec3"),
    ("Vector4", "Vec4"),
    ("SVector", "Vec3"),
    ("DVec3", "Vec3"),
    ("Point3", "Vec3"),
    ("Matrix2", "Mat2"),
    ("Matrix3", "Mat3"),
    ("SMatrix", "Mat3"),
    ("Rotation3", "Quat"),
    ("Quaternion", "Quat"),
    ("UnitQuaternion", "Quat"),
    ("Isometry3", "Rigid"),
    ("Body", "Rigid"),
    ("RigidBody", "Rigid"),
];

impl Reader<'_> {
    pub(super) fn ty(&mut self, ty: &syn::Type) -> Type {
        let mut ty = ty;
        loop {
            ty = match ty {
                syn::Type::Group(group) => &group.elem,
                syn::Type::Paren(paren) => &paren.elem,
                syn::Type::Reference(reference) => {
                    let and = self.at(reference.and_token.spans[0]);
                    if let Some(mutability) = &reference.mutability {
                        let span = and.to(self.at(mutability.span));
                        self.error_help(
                            span,
                            "mutable references are not part of the force language",
                            "nothing is changed through a reference",
                            "take the value and return the new one",
                        );
                    }
                    if let Some(lifetime) = &reference.lifetime {
                        let span = self.at(lifetime.apostrophe).to(self.at(lifetime.ident.span()));
                        self.lifetime(span);
                    }
                    &reference.elem
                }
                _ => break,
            };
        }
        match ty {
            syn::Type::Path(path) if path.qself.is_none() => self.named(&path.path),
            syn::Type::Tuple(tuple) => {
                let span = self.between(tuple.paren_token.span);
                let types = tuple.elems.iter().map(|ty| self.ty(ty)).collect();
                Type { kind: TypeKind::Tuple(types), span }
            }
            syn::Type::Array(array) => {
                let span = self.between(array.bracket_token.span);
                let element = self.ty(&array.elem);
                let length = self.expr(&array.len);
                Type { kind: TypeKind::Array(Box::new(element), length), span }
            }
            syn::Type::Slice(slice) => {
                let span = self.between(slice.bracket_token.span);
                self.other(span, "slices", "the length has to be known", "write an array, `[T; n]`")
            }
            syn::Type::ImplTrait(ty) => {
                let span = self.at(ty.impl_token.span);
                self.other(span, "`impl` types", "not a type of values", "write the type out")
            }
            syn::Type::FnPtr(ty) => {
                let span = self.at(ty.fn_token.span);
                self.other(span, "function pointers", "not a type of values", "call the helper by its name")
            }
            syn::Type::Ptr(ty) => {
                let span = self.at(ty.star_token.spans[0]);
                self.other(span, "pointers", "not a type of values", "take the value itself")
            }
            syn::Type::Infer(ty) => {
                let span = self.at(ty.underscore_token.spans[0]);
                self.other(span, "inferred types", "the type is not known here", "write the type out")
            }
            syn::Type::Never(ty) => {
                let span = self.at(ty.bang_token.spans[0]);
                self.other(span, "`!` types", "a force function always returns", "write the type it returns")
            }
            syn::Type::Macro(ty) => {
                let span = self.path(&ty.mac.path).span;
                self.other(span, "macros", "not a type", "write the type out")
            }
            syn::Type::TraitObject(ty) => {
                let span = ty.dyn_token.as_ref().map(|token| self.at(token.span)).unwrap_or_default();
                self.other(span, "trait objects", "not a type of values", "write the type out")
            }
            _ => self.other(
                Span::default(),
                "such types",
                "not a type of values",
                "write one of the types of the force language",
            ),
        }
    }

    fn other(&mut self, span: Span, what: &str, label: &str, help: &str) -> Type {
        self.error_help(span, format!("{what} are not part of the force language"), label, help);
        Type { kind: TypeKind::Error, span }
    }

    fn named(&mut self, path: &syn::Path) -> Type {
        let generic = path.segments.iter().any(|segment| !segment.arguments.is_none());
        let last = path.segments.last().map(|segment| segment.ident.to_string()).unwrap_or_default();
        let ours = OTHER_NAMES.iter().find(|(other, _)| *other == last);
        if let (true, Some((_, ours))) = (generic, ours) {
            let first = self.at(path.segments[0].ident.span());
            let end = match &path.segments[path.segments.len() - 1].arguments {
                syn::PathArguments::AngleBracketed(arguments) => self.at(arguments.gt_token.spans[0]),
                _ => first,
            };
            let span = first.to(end);
            self.error_help(
                span,
                format!("`{last}` goes by another name here"),
                "a generic type",
                format!("write `{ours}`"),
            );
            return Type { kind: TypeKind::Error, span };
        }
        let path = self.path(path);
        let kind = if generic { TypeKind::Error } else { TypeKind::Named(path.last().to_owned()) };
        Type { kind, span: path.span }
    }

    /// The empty tuple, the type of a function without a return type.
    pub(super) fn no_type(span: Span) -> Type {
        Type { kind: TypeKind::Tuple(Vec::new()), span }
    }

    /// An invalid expression, whose error was reported.
    pub(super) fn poison(&mut self, span: Span) -> crate::syntax::ast::ExprId {
        self.expressions.push(ExprKind::Error, span)
    }
}
