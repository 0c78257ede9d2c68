//! Constants and helpers: a constant is evaluated once, a helper is inlined once per distinct argument list.

use crate::check::elaborator::{Elaborator, Frame, Variable};
use crate::check::values::Value;
use crate::source::span::Span;

impl<'a> Elaborator<'a> {
    /// Runs `work` with `frame` as the current frame.
    pub(super) fn within<T>(&mut self, frame: Frame<'a>, work: impl FnOnce(&mut Self) -> T) -> T {
        let outer = std::mem::replace(&mut self.frame, frame);
        let result = work(self);
        self.frame = outer;
        result
    }

    /// The value of a constant.
    pub(crate) fn constant(&mut self, index: usize) -> Value {
        let constant = &self.program.constants[index];
        match self.constants.get(&index) {
            Some(Some(value)) => return value.clone(),
            Some(None) => {
                return self.error_help(
                    constant.name.span,
                    format!("`{}` is made of itself", constant.name.text),
                    "its value leads back to it",
                    Some("give one of the constants a value of its own".to_owned()),
                );
            }
            None => {}
        }
        self.constants.insert(index, None);
        let frame = Frame::new(&constant.expressions, self.guards.len());
        let value = self.within(frame, |e| {
            let wanted = e.resolve(&constant.ty);
            let value = e.expr(constant.value);
            let span = constant.expressions[constant.value].span;
            e.expect(value, &wanted, span, &format!("the constant is declared as {}", wanted.said()))
        });
        self.constants.insert(index, Some(value.clone()));
        value
    }

    /// The value of a helper for these arguments, whose types were checked.
    pub(crate) fn inline(&mut self, index: usize, arguments: Vec<Value>, span: Span) -> Value {
        if self.recursive[index] || arguments.contains(&Value::Poison) {
            return Value::Poison;
        }
        let size = arguments.iter().map(Value::size).fold(0, u64::saturating_add);
        if !self.spend(size, span) {
            return Value::Poison;
        }
        let key = (index, arguments);
        if let Some(value) = self.memo.get(&key) {
            return value.clone();
        }
        let function = &self.program.functions[index];
        self.open.push((span, format!("the call of `{}`", function.name.text)));
        let iterations = std::mem::replace(&mut self.iterations, 1);
        let value = self.body(index, key.1.clone());
        self.iterations = iterations;
        self.open.pop();
        match value {
            Value::Real(x) => self.graph.returned_by(x.index(), &function.name.text),
            Value::Vector(v) => self.graph.returned_by(v.index(), &function.name.text),
            _ => {}
        }
        self.memo.insert(key, value.clone());
        value
    }

    /// Evaluates the body of a function for these arguments.
    pub(crate) fn body(&mut self, index: usize, arguments: Vec<Value>) -> Value {
        let function = &self.program.functions[index];
        let mut frame = Frame::new(&function.expressions, self.guards.len());
        for (argument, value) in function.arguments.iter().zip(arguments) {
            frame.variables.bind(&argument.name.text, Variable { value });
        }
        let output = self.program.signatures[index].output.clone();
        let value = self.within(frame, |e| e.block(&function.body));
        let (span, why) = match function.body.value {
            Some(id) => {
                (function.expressions[id].span, format!("`{}` returns {}", function.name.text, output.said()))
            }
            None => (
                function.output.span,
                format!("`{}` returns {}, but its body has no value", function.name.text, output.said()),
            ),
        };
        self.expect(value, &output, span, &why)
    }
}
