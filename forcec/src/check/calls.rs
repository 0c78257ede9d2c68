//! Calls of helpers and of built-ins.

use crate::check::builtins::{self, Builtin, Place, Shape};
use crate::check::elaborator::Elaborator;
use crate::check::types::Type;
use crate::check::values::Value;
use crate::source::span::Span;
use crate::source::suggest;
use crate::syntax::ast::{ExprId, Name, Path};

impl<'a> Elaborator<'a> {
    pub(super) fn call(&mut self, path: &'a Path, arguments: &[ExprId], span: Span) -> Value {
        let expressions = self.frame.expressions;
        let values: Vec<Value> = arguments.iter().map(|argument| self.expr(*argument)).collect();
        let spans: Vec<Span> = arguments.iter().map(|argument| expressions[*argument].span).collect();
        if let [.., ty, name] = path.segments.as_slice()
            && (ty.starts_with(|c: char| c.is_ascii_uppercase()) || Type::named(ty).is_some())
        {
            return self.associated(ty, name, path.span, values, &spans, span);
        }
        let Some(index) = self.program.function(path.last()) else { return Value::Poison };
        let function = &self.program.functions[index];
        // Signatures contain array lengths made of constants, so constants are evaluated first.
        let Some(types) = self.program.signatures.get(index).map(|own| own.arguments.clone()) else {
            return self.error_help(
                span,
                format!("`{}` is called in a constant", function.name.text),
                "constants are evaluated before functions",
                Some("make constants of literals, `PI` and other constants".to_owned()),
            );
        };
        if types.len() != values.len() {
            let names: Vec<&str> = function.arguments.iter().map(|a| a.name.text.as_str()).collect();
            let form = format!("{}({})", function.name.text, names.join(", "));
            return self.wrong_count(&function.name.text, types.len(), values.len(), &form, span);
        }
        let mut checked = Vec::new();
        for (k, value) in values.into_iter().enumerate() {
            let argument = &function.arguments[k].name.text;
            let why = format!("`{argument}` of `{}` is {}", function.name.text, types[k].said());
            checked.push(self.expect(value, &types[k], spans[k], &why));
        }
        self.inline(index, checked, span)
    }

    fn wrong_count(&mut self, name: &str, wanted: usize, found: usize, form: &str, span: Span) -> Value {
        let plural = if wanted == 1 { "" } else { "s" };
        self.error_help(
            span,
            format!("`{name}` takes {wanted} argument{plural}, not {found}"),
            format!("{found} given"),
            Some(format!("write `{form}`")),
        )
    }

    /// `Type::name(…)`
    fn associated(
        &mut self,
        ty: &str,
        name: &str,
        path: Span,
        mut values: Vec<Value>,
        spans: &[Span],
        span: Span,
    ) -> Value {
        let Some(on) = Type::named(ty) else {
            let other = crate::syntax::OTHER_NAMES.iter().find(|(other, _)| *other == ty);
            let help = match other {
                Some((_, ours)) => Some(format!("write `{ours}::{name}(…)`")),
                None => suggest::did_you_mean(ty, Type::names()),
            };
            return self.error_help(
                path,
                format!("unknown type `{ty}`"),
                "no type of the force language",
                help,
            );
        };
        let row = builtins::find(Place::Type, name, &on);
        if let Some(row) = row {
            return self.apply(row, &on, values, spans, span);
        }
        // `Vec3::dot(&u, &v)` is `u.dot(&v)`.
        if let (Some(row), Some(first)) = (builtins::find(Place::Value, name, &on), values.first()) {
            let why = format!("`{name}` of `{ty}` is called on {}", on.said());
            let first = self.expect(first.clone(), &on, spans[0], &why);
            values[0] = first;
            return self.apply(row, &on, values, spans, span);
        }
        let known: Vec<&str> = builtins::names(Place::Type, &on).collect();
        let help = match (on.clone(), name) {
            (Type::Vector(_), "x_axis" | "y_axis" | "z_axis") => {
                Some(format!("write `{ty}::{}()`", &name[..1]))
            }
            (Type::Vector(_), "zero") => Some(format!("write `{ty}::zeros()`")),
            (Type::Quat, "from_axis_angle" | "new") => {
                Some("write `Quat::from_scaled_axis(axis * angle)`".to_owned())
            }
            _ => suggest::did_you_mean(name, known.iter().copied())
                .or_else(|| (!known.is_empty()).then(|| format!("`{ty}` has `{}`", known.join("`, `")))),
        };
        self.error_help(
            path,
            format!("unknown function `{ty}::{name}`"),
            format!("no such function of `{ty}`"),
            help,
        )
    }

    /// `receiver.name(…)`
    pub(super) fn method(
        &mut self,
        receiver: ExprId,
        name: &Name,
        arguments: &[ExprId],
        span: Span,
    ) -> Value {
        let expressions = self.frame.expressions;
        let mut values = vec![self.expr(receiver)];
        let mut spans = vec![expressions[receiver].span];
        for argument in arguments {
            values.push(self.expr(*argument));
            spans.push(expressions[*argument].span);
        }
        let on = values[0].ty();
        if on == Type::Poison {
            return Value::Poison;
        }
        if let Some(row) = builtins::find(Place::Value, &name.text, &on) {
            return self.apply(row, &on, values, &spans, span);
        }
        let text = name.text.as_str();
        let known: Vec<&str> = builtins::names(Place::Value, &on).collect();
        let help = builtins::instead(text, &on).map(str::to_owned).or_else(|| match &on {
            Type::Integer if builtins::find(Place::Value, text, &Type::Real).is_some() => {
                Some(self.real_help(spans[0]))
            }
            Type::Body(kind) => {
                let fields: Vec<&str> = kind.row().fields.iter().map(|field| field.name).collect();
                Some(match fields.iter().find(|field| **field == text) {
                    Some(field) => format!("`{field}` is a field; write it without `()`"),
                    None => format!("a body has fields: `{}`", fields.join("`, `")),
                })
            }
            _ if ["x", "y", "z", "w", "i", "j", "k", "force", "torque"].contains(&text) => {
                Some(format!("`{text}` is a field; write it without `()`"))
            }
            _ => suggest::did_you_mean(text, known.iter().copied()),
        });
        self.error_help(
            name.span,
            format!("unknown method `{text}`"),
            format!("no such method on {}", on.said()),
            help,
        )
    }

    /// Checks the arguments of a built-in, then applies it.
    fn apply(
        &mut self,
        row: &'static Builtin,
        on: &Type,
        values: Vec<Value>,
        spans: &[Span],
        span: Span,
    ) -> Value {
        let receiver = usize::from(row.place == Place::Value);
        if values.len() - receiver.min(values.len()) != row.arguments.len() {
            let found = values.len() - receiver.min(values.len());
            let arguments: Vec<String> = row.arguments.iter().map(|shape| shape.written(on)).collect();
            let of = if row.place == Place::Value { String::new() } else { format!("{on}:") };
            let dot = if row.place == Place::Value { "." } else { ":" };
            let form = format!("{of}{dot}{}({})", row.name, arguments.join(", "));
            return self.wrong_count(row.name, row.arguments.len(), found, &form, span);
        }
        let mut checked = Vec::new();
        for (k, value) in values.into_iter().enumerate() {
            if k < receiver {
                checked.push(value);
                continue;
            }
            let shape = row.arguments[k - receiver];
            let found = value.ty();
            if shape.accepts(&found, on) {
                checked.push(value);
                continue;
            }
            let wanted = shape.of(on);
            let why = format!("`{}` takes {} here", row.name, shape.said(on));
            checked.push(match shape {
                Shape::Small => {
                    let help = (found == Type::Real).then(|| {
                        "write the number without a point, or use `powf` for a real power".to_owned()
                    });
                    self.error_help(
                        spans[k],
                        format!("expected an integer, found {}", found.said()),
                        why,
                        help,
                    )
                }
                _ => self.expect(value, &wanted, spans[k], &why),
            });
        }
        if checked.iter().any(Value::is_poison) {
            return Value::Poison;
        }
        (row.apply)(self, &checked, span)
    }
}
