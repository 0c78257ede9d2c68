//! Expressions: the part of Rust that computes values; for others, the error says what to write instead.

use crate::math::exact::Exact;
use crate::source::span::Span;
use crate::syntax::ast::{BinaryOp, Block, ExprId, ExprKind, Name, Path, UnaryOp};
use crate::syntax::reader::Reader;
use syn::{BinOp, Expr, Lit, UnOp};

/// The suffixes that an integer literal may have.
const INTEGER_SUFFIXES: [&str; 12] =
    ["i8", "i16", "i32", "i64", "i128", "isize", "u8", "u16", "u32", "u64", "u128", "usize"];

impl Reader<'_> {
    fn push(&mut self, kind: ExprKind, span: Span) -> ExprId {
        self.expressions.push(kind, span)
    }

    fn span_of(&self, id: ExprId) -> Span {
        self.expressions[id].span
    }

    pub(super) fn expr(&mut self, expr: &Expr) -> ExprId {
        match expr {
            Expr::Lit(literal) => self.literal(&literal.lit),
            Expr::Path(path) => {
                if let Some(qualified) = &path.qself {
                    let span = self.at(qualified.lt_token.spans[0]);
                    return self.unsupported(
                        span,
                        "qualified paths",
                        "a type in angle brackets",
                        "write the plain name",
                    );
                }
                let path = self.path(&path.path);
                let span = path.span;
                self.push(ExprKind::Path(path), span)
            }
            Expr::Paren(paren) => {
                // The span includes the brackets, so that a label covers them.
                let span = self.between(paren.paren_token.span);
                let inner = self.expr(&paren.expr);
                self.expressions[inner].span = span;
                inner
            }
            Expr::Group(group) => self.expr(&group.expr),
            Expr::Reference(reference) => {
                if let Some(mutability) = &reference.mutability {
                    let span = self.at(reference.and_token.spans[0]).to(self.at(mutability.span));
                    return self.unsupported(
                        span,
                        "mutable references",
                        "nothing is changed through a reference",
                        "pass the value, and assign what the helper returns",
                    );
                }
                self.expr(&reference.expr)
            }
            Expr::Unary(unary) => self.unary(unary),
            Expr::Binary(binary) => self.binary(binary),
            Expr::Call(call) => self.call(call),
            Expr::MethodCall(call) => self.method(call),
            Expr::Field(field) => {
                let base = self.expr(&field.base);
                let name = match &field.member {
                    syn::Member::Named(ident) => self.name(ident),
                    syn::Member::Unnamed(index) => {
                        Name { text: index.index.to_string(), span: self.at(index.span) }
                    }
                };
                let span = self.span_of(base).to(name.span);
                self.push(ExprKind::Field(base, name), span)
            }
            Expr::Index(index) => {
                let base = self.expr(&index.expr);
                let at = self.expr(&index.index);
                let span = self.span_of(base).to(self.between(index.bracket_token.span));
                self.push(ExprKind::Index(base, at), span)
            }
            Expr::Tuple(tuple) => {
                let span = self.between(tuple.paren_token.span);
                let elements = tuple.elems.iter().map(|element| self.expr(element)).collect();
                self.push(ExprKind::Tuple(elements), span)
            }
            Expr::Array(array) => {
                let span = self.between(array.bracket_token.span);
                let elements = array.elems.iter().map(|element| self.expr(element)).collect();
                self.push(ExprKind::Array(elements), span)
            }
            Expr::Repeat(repeat) => {
                let span = self.between(repeat.bracket_token.span);
                let element = self.expr(&repeat.expr);
                let length = self.expr(&repeat.len);
                self.push(ExprKind::Repeat(element, length), span)
            }
            Expr::Struct(literal) => self.struct_literal(literal),
            Expr::Cast(cast) => {
                let value = self.expr(&cast.expr);
                let ty = self.ty(&cast.ty);
                let span = self.span_of(value).to(ty.span);
                self.push(ExprKind::Cast(value, ty), span)
            }
            Expr::Block(block) => {
                self.label(block.label.as_ref());
                let block = self.block(&block.block);
                let span = block.span;
                self.push(ExprKind::Block(block), span)
            }
            Expr::If(_) => self.conditional(expr),
            other => self.foreign(other),
        }
    }

    fn literal(&mut self, literal: &Lit) -> ExprId {
        let span = self.at(literal.span());
        let (digits, suffix, whole) = match literal {
            Lit::Bool(value) => return self.push(ExprKind::Truth(value.value), span),
            Lit::Int(value) => (value.base10_digits().to_owned(), value.suffix().to_owned(), true),
            Lit::Float(value) => (value.base10_digits().to_owned(), value.suffix().to_owned(), false),
            Lit::Str(_) | Lit::ByteStr(_) | Lit::CStr(_) | Lit::Char(_) | Lit::Byte(_) => {
                self.error(
                    span,
                    "text is not a value in the force language",
                    "a string or character literal",
                );
                return self.poison(span);
            }
            _ => {
                self.error(span, "such literals are not part of the force language", "no number");
                return self.poison(span);
            }
        };
        let float = matches!(suffix.as_str(), "f32" | "f64");
        if !(suffix.is_empty() || float || whole && INTEGER_SUFFIXES.contains(&suffix.as_str())) {
            self.error_help(
                span,
                format!("`{suffix}` is not a type of numbers"),
                "an unknown suffix",
                format!("write `{digits}` without it"),
            );
            return self.poison(span);
        }
        if whole && !float {
            return match digits.parse() {
                Ok(value) => self.push(ExprKind::Integer(value), span),
                Err(_) => {
                    self.error_help(
                        span,
                        "an integer that is too large",
                        "beyond the range of `i64`",
                        format!("for a real write `{digits}.0`"),
                    );
                    self.poison(span)
                }
            };
        }
        match Exact::parse(&digits) {
            Some(value) if value.is_zero() || value.to_f64() != 0.0 => {
                self.push(ExprKind::Number(value), span)
            }
            Some(_) => {
                self.error_help(
                    span,
                    "a number that is too small",
                    "below the least `f64`, about 5e-324",
                    "write `0.0`, or choose other units",
                );
                self.poison(span)
            }
            None => {
                self.error_help(
                    span,
                    "a number that is too large or too long",
                    "beyond the largest `f64`, about 1.8e308, or more than a thousand digits",
                    "choose other units",
                );
                self.poison(span)
            }
        }
    }

    fn unary(&mut self, unary: &syn::ExprUnary) -> ExprId {
        let (op, token) = match &unary.op {
            UnOp::Neg(token) => (UnaryOp::Negate, token.spans[0]),
            UnOp::Not(token) => (UnaryOp::Not, token.spans[0]),
            // `*x` is `x`, as `&x` is.
            _ => return self.expr(&unary.expr),
        };
        let start = self.at(token);
        let value = self.expr(&unary.expr);
        let span = start.to(self.span_of(value));
        self.push(ExprKind::Unary(op, value), span)
    }

    fn binary(&mut self, binary: &syn::ExprBinary) -> ExprId {
        let op = match &binary.op {
            BinOp::Add(_) => BinaryOp::Add,
            BinOp::Sub(_) => BinaryOp::Subtract,
            BinOp::Mul(_) => BinaryOp::Multiply,
            BinOp::Div(_) => BinaryOp::Divide,
            BinOp::Rem(_) => BinaryOp::Remainder,
            BinOp::And(_) => BinaryOp::And,
            BinOp::Or(_) => BinaryOp::Or,
            BinOp::Eq(_) => BinaryOp::Equal,
            BinOp::Ne(_) => BinaryOp::NotEqual,
            BinOp::Lt(_) => BinaryOp::Less,
            BinOp::Le(_) => BinaryOp::LessEqual,
            BinOp::Gt(_) => BinaryOp::Greater,
            BinOp::Ge(_) => BinaryOp::GreaterEqual,
            other => {
                let (span, what, help) = match other {
                    BinOp::BitXor(token) => {
                        (token.spans[0], "`^`", "for a power write `x.powi(2)` or `x.powf(y)`")
                    }
                    BinOp::BitAnd(token) => (token.spans[0], "`&`", "for both write `&&`"),
                    BinOp::BitOr(token) => (token.spans[0], "`|`", "for either write `||`"),
                    BinOp::Shl(token) => (token.spans[0], "`<<`", "multiply by a power of two"),
                    BinOp::Shr(token) => (token.spans[0], "`>>`", "divide by a power of two"),
                    BinOp::AddAssign(token) => (token.spans[0], "`+=` within an expression", ASSIGN),
                    BinOp::SubAssign(token) => (token.spans[0], "`-=` within an expression", ASSIGN),
                    BinOp::MulAssign(token) => (token.spans[0], "`*=` within an expression", ASSIGN),
                    BinOp::DivAssign(token) => (token.spans[0], "`/=` within an expression", ASSIGN),
                    BinOp::RemAssign(token) => (token.spans[0], "`%=` within an expression", ASSIGN),
                    BinOp::BitXorAssign(token) => {
                        (token.spans[0], "`^=`", "for a power write `x = x.powi(2)`")
                    }
                    BinOp::BitAndAssign(token) => (token.spans[0], "`&=`", "write `x = x && y`"),
                    BinOp::BitOrAssign(token) => (token.spans[0], "`|=`", "write `x = x || y`"),
                    BinOp::ShlAssign(token) => (token.spans[0], "`<<=`", "multiply by a power of two"),
                    BinOp::ShrAssign(token) => (token.spans[0], "`>>=`", "divide by a power of two"),
                    _ => return self.poison(Span::default()),
                };
                let span = self.at(span);
                return self.error_at(
                    span,
                    &format!("{what} is not part of the force language"),
                    "no operator on reals",
                    help,
                );
            }
        };
        if let (BinOp::Mul(times), Expr::Unary(right)) = (&binary.op, &*binary.right)
            && let UnOp::Deref(star) = right.op
        {
            // Rust reads `x ** y` as `x * (*y)`; the author means a power.
            let (first, second) = (self.at(times.spans[0]), self.at(star.spans[0]));
            if first.end == second.start {
                return self.error_at(
                    first.to(second),
                    "`**` is not part of the force language",
                    "no operator on reals",
                    "for a power write `x.powi(2)` or `x.powf(y)`",
                );
            }
        }
        let left = self.expr(&binary.left);
        let right = self.expr(&binary.right);
        let span = self.span_of(left).to(self.span_of(right));
        self.push(ExprKind::Binary(op, left, right), span)
    }

    fn call(&mut self, call: &syn::ExprCall) -> ExprId {
        let Expr::Path(syn::ExprPath { qself: None, path, .. }) = &*call.func else {
            let span = self.between(call.paren_token.span);
            return self.error_at(
                span,
                "only functions with a name can be called",
                "the called expression is not a name",
                "write a helper `fn` and call it by its name",
            );
        };
        let path = self.path(path);
        let arguments = call.args.iter().map(|argument| self.expr(argument)).collect();
        let span = path.span.to(self.between(call.paren_token.span));
        self.push(ExprKind::Call(path, arguments), span)
    }

    fn method(&mut self, call: &syn::ExprMethodCall) -> ExprId {
        let receiver = self.expr(&call.receiver);
        let name = self.name(&call.method);
        if let Some(turbofish) = &call.turbofish {
            let span = self.at(turbofish.lt_token.spans[0]).to(self.at(turbofish.gt_token.spans[0]));
            self.error_help(
                span,
                "generic arguments are not part of the force language",
                "every type is known here",
                "leave out `::<…>`",
            );
        }
        let arguments = call.args.iter().map(|argument| self.expr(argument)).collect();
        let span = self.span_of(receiver).to(self.between(call.paren_token.span));
        self.push(ExprKind::Method(receiver, name, arguments), span)
    }

    fn struct_literal(&mut self, literal: &syn::ExprStruct) -> ExprId {
        let path: Path = self.path(&literal.path);
        let mut fields = Vec::new();
        for field in &literal.fields {
            match &field.member {
                syn::Member::Named(ident) => {
                    let name = self.name(ident);
                    let value = self.expr(&field.expr);
                    fields.push((name, value));
                }
                syn::Member::Unnamed(index) => {
                    let span = self.at(index.span);
                    self.error(span, "a field has a name", "this is a number");
                }
            }
        }
        if let Some(dots) = &literal.dot2_token {
            let span = self.at(dots.spans[0]).to(self.at(dots.spans[1]));
            self.error_help(
                span,
                "`..` within a struct literal is not part of the force language",
                "the remaining fields",
                "write every field",
            );
        }
        let span = path.span.to(self.between(literal.brace_token.span));
        self.push(ExprKind::Struct(path, fields), span)
    }

    /// `if … else if … else …`; a chain is read in a loop.
    fn conditional(&mut self, expr: &Expr) -> ExprId {
        let mut chain: Vec<(Span, ExprId, Block)> = Vec::new();
        let mut next = Some(expr);
        let mut otherwise = None;
        while let Some(expr) = next.take() {
            let Expr::If(item) = expr else {
                otherwise = Some(self.expr(expr));
                break;
            };
            let start = self.at(item.if_token.span);
            let condition = self.expr(&item.cond);
            let then = self.block(&item.then_branch);
            chain.push((start, condition, then));
            next = item.else_branch.as_ref().map(|(_, branch)| &**branch);
        }
        for (start, condition, then) in chain.into_iter().rev() {
            let end = otherwise.map_or(then.span, |otherwise| self.span_of(otherwise));
            otherwise = Some(self.push(ExprKind::If(condition, then, otherwise), start.to(end)));
        }
        otherwise.unwrap_or_else(|| self.poison(Span::default()))
    }

    fn error_at(&mut self, span: Span, message: &str, label: &str, help: &str) -> ExprId {
        self.error_help(span, message, label, help);
        self.poison(span)
    }

    fn unsupported(&mut self, span: Span, what: &str, label: &str, help: &str) -> ExprId {
        self.error_at(span, &format!("{what} are not part of the force language"), label, help)
    }

    /// Reports an expression outside the force language.
    fn foreign(&mut self, expr: &Expr) -> ExprId {
        let (token, what, label, help) = match expr {
            Expr::Closure(e) => (
                e.inputs_begin.spans[0],
                "closures",
                "a function without a name",
                "write a helper `fn` beside the function and call it",
            ),
            Expr::While(e) => (
                e.while_token.span,
                "`while` loops",
                "how often it runs is not known",
                "write `for i in 0..n` over a constant range",
            ),
            Expr::Loop(e) => (
                e.loop_token.span,
                "`loop`s",
                "how often it runs is not known",
                "write `for i in 0..n` over a constant range",
            ),
            Expr::Match(e) => (
                e.match_token.span,
                "`match` expressions",
                "there are no cases to match",
                "write `if … { … } else if … { … } else { … }`",
            ),
            Expr::Return(e) => (
                e.return_token.span,
                "early returns",
                "every branch runs to its end",
                "write `if … { … } else { … }`, whose value is its last expression",
            ),
            Expr::Break(e) => (
                e.break_token.span,
                "`break`s",
                "every iteration runs",
                "put the rest of the iteration into an `if`",
            ),
            Expr::Continue(e) => (
                e.continue_token.span,
                "`continue`s",
                "every iteration runs to its end",
                "put the rest of the iteration into an `if`",
            ),
            Expr::Try(e) => {
                (e.question_token.spans[0], "`?` operators", "no value here is an error", "leave it out")
            }
            Expr::Unsafe(e) => {
                (e.unsafe_token.span, "`unsafe` blocks", "nothing here is unsafe", "write a plain block")
            }
            Expr::Async(e) => {
                (e.async_token.span, "`async` blocks", "nothing is waited for", "write a plain block")
            }
            Expr::Await(e) => (e.await_token.span, "`await`s", "nothing is waited for", "leave it out"),
            Expr::Const(e) => {
                (e.const_token.span, "`const` blocks", "not needed", "write a plain block, or a `const` item")
            }
            Expr::TryBlock(e) => {
                (e.try_token.span, "`try` blocks", "no value here is an error", "write a plain block")
            }
            Expr::Yield(e) => (e.yield_token.span, "`yield`s", "a function has one value", "leave it out"),
            Expr::RawAddr(e) => (e.and_token.spans[0], "pointers", "not a value", "take the value itself"),
            Expr::Let(e) => (
                e.let_token.span,
                "`let` conditions",
                "patterns always match here",
                "compare with `<`, `<=` or `==`",
            ),
            Expr::Assign(e) => {
                (e.eq_token.spans[0], "assignments within an expression", "has no value", ASSIGN)
            }
            Expr::ForLoop(e) => (
                e.for_token.span,
                "loops within an expression",
                "a loop has no value",
                "accumulate in a `let mut` variable before the expression",
            ),
            Expr::Infer(e) => (e.underscore_token.spans[0], "`_` values", "no value", "write the value"),
            Expr::Macro(e) => {
                let span = self.path(&e.mac.path).span;
                self.macro_call(span);
                return self.poison(span);
            }
            Expr::Range(e) => {
                let span = self.limits_span(&e.limits);
                return self.unsupported(
                    span,
                    "ranges as values",
                    "a range may only follow `for i in`",
                    "write the loop, `for i in 0..n`",
                );
            }
            _ => {
                return self.unsupported(
                    Span::default(),
                    "such expressions",
                    "not a value",
                    "see the language reference for what is",
                );
            }
        };
        let span = self.at(token);
        self.unsupported(span, what, label, help)
    }
}

const ASSIGN: &str = "write the assignment as a statement of its own";
