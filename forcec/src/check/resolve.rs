//! Resolves types of the source and evaluates the lengths of arrays.

use crate::check::elaborator::{Elaborator, LARGEST_VALUE};
use crate::check::types::Type;
use crate::check::values::Value;
use crate::source::suggest;
use crate::syntax::ast::{self, ExprId, TypeKind};

impl Elaborator<'_> {
    /// The type that a type expression names.
    pub(crate) fn resolve(&mut self, ty: &ast::Type) -> Type {
        match &ty.kind {
            TypeKind::Error => Type::Poison,
            TypeKind::Tuple(types) => Type::Tuple(types.iter().map(|ty| self.resolve(ty)).collect()),
            TypeKind::Array(element, length) => {
                let element = self.resolve(element);
                match self.array_length(*length) {
                    Some(length) => Type::Array(Box::new(element), length),
                    None => Type::Poison,
                }
            }
            TypeKind::Named(name) => {
                if let Some(known) = Type::named(name) {
                    return known;
                }
                let other = crate::syntax::OTHER_NAMES.iter().find(|(other, _)| other == name);
                let help = match other {
                    Some((_, ours)) => Some(format!("write `{ours}`")),
                    None => suggest::did_you_mean(name, Type::names()),
                };
                self.error_help(
                    ty.span,
                    format!("unknown type `{name}`"),
                    "no type of the force language",
                    help,
                );
                Type::Poison
            }
        }
    }

    /// Evaluates the length of an array, at least 1.
    pub(super) fn array_length(&mut self, id: ExprId) -> Option<u32> {
        let span = self.frame.expressions[id].span;
        let value = self.expr(id);
        match self.expect(value, &Type::Integer, span, "the length of an array is an integer constant") {
            Value::Integer(n) if n >= 1 && n as u64 <= LARGEST_VALUE => Some(n as u32),
            Value::Integer(n) => {
                self.error(span, "a length out of range", format!("{n} is not among 1 to {LARGEST_VALUE}"));
                None
            }
            _ => None,
        }
    }
}
