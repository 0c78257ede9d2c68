//! Statements: `let`, assignments, loops, and the value at the end of a block.

use crate::source::span::Span;
use crate::syntax::ast::{BinaryOp, Block, ExprId, Loop, Pattern, Statement, Type};
use crate::syntax::reader::Reader;
use syn::{BinOp, Expr, Pat, Stmt};

impl Reader<'_> {
    /// The body of a function; a redundant `return` at its end is an error.
    pub(super) fn body(&mut self, block: &syn::Block) -> Block {
        let Some((Stmt::Expr(Expr::Return(last), _), before)) = block.stmts.split_last() else {
            return self.block(block);
        };
        let span = self.at(last.return_token.span);
        self.error_help(
            span,
            "`return` is not part of the force language",
            "the last expression is the value anyway",
            "write the expression without `return` and without `;`",
        );
        let rest = syn::Block { brace_token: block.brace_token, stmts: before.to_vec() };
        let mut body = self.block(&rest);
        body.value = Some(self.poison(span));
        body
    }

    pub(super) fn block(&mut self, block: &syn::Block) -> Block {
        let span = self.between(block.brace_token.span);
        let mut statements = Vec::new();
        let mut value = None;
        for (index, statement) in block.stmts.iter().enumerate() {
            let last = index + 1 == block.stmts.len();
            match statement {
                Stmt::Local(local) => statements.extend(self.local(local)),
                Stmt::Item(item) => statements.extend(self.inner_item(item)),
                Stmt::Macro(item) => {
                    let span = self.path(&item.mac.path).span;
                    self.macro_call(span);
                }
                Stmt::Expr(expr, semicolon) => match self.statement(expr) {
                    Some(statement) => statements.push(statement),
                    None if last && semicolon.is_none() => value = Some(self.expr(expr)),
                    None => {
                        let expr = self.expr(expr);
                        statements.push(Statement::Expr(expr));
                    }
                },
            }
        }
        Block { statements, value, span }
    }

    /// Reads a constant within a body as a `let`.
    fn inner_item(&mut self, item: &syn::Item) -> Option<Statement> {
        match item {
            syn::Item::Use(_) => None,
            syn::Item::Const(item) => {
                let name = self.name(&item.ident);
                let ty = Some(self.ty(&item.ty));
                let value = self.expr(&item.expr);
                Some(Statement::Let { pattern: Pattern::Name { name, mutable: false }, ty, value })
            }
            syn::Item::Fn(item) => {
                let name = self.name(&item.sig.ident);
                self.error_help(
                    name.span,
                    "a function within a function",
                    "not part of the force language",
                    "write the helper beside the function",
                );
                None
            }
            syn::Item::Macro(item) => {
                let span = self.path(&item.mac.path).span;
                self.macro_call(span);
                None
            }
            _ => {
                let value = self.poison(Span::default());
                self.error_help(
                    Span::default(),
                    "a body holds statements only",
                    "an item within a function",
                    "write it at the top of the file",
                );
                Some(Statement::Expr(value))
            }
        }
    }

    fn local(&mut self, local: &syn::Local) -> Option<Statement> {
        let (pattern, ty): (&Pat, Option<Type>) = match &local.pat {
            Pat::Type(typed) => (&typed.pat, Some(self.ty(&typed.ty))),
            pattern => (pattern, None),
        };
        let pattern = self.pattern(pattern);
        let Some(init) = &local.init else {
            let span = self.at(local.let_token.span);
            self.error_help(
                span,
                "a `let` without a value",
                "nothing is bound",
                "write the value: `let x = if … { … } else { … };`",
            );
            let value = self.poison(span);
            return Some(Statement::Let { pattern, ty, value });
        };
        let value = self.expr(&init.expr);
        if let Some((token, _)) = &init.diverge {
            let span = self.at(token.span);
            self.error_help(
                span,
                "`let … else` is not part of the force language",
                "patterns always match here",
                "write `if … { … } else { … }` as the value",
            );
        }
        Some(Statement::Let { pattern, ty, value })
    }

    pub(super) fn pattern_span(&mut self, pattern: &Pat) -> Option<Span> {
        Some(match pattern {
            Pat::Ident(pattern) => match &pattern.by_ref {
                Some(token) => self.at(token.span).to(self.at(pattern.ident.span())),
                None => self.at(pattern.ident.span()),
            },
            Pat::Wild(pattern) => self.at(pattern.underscore_token.spans[0]),
            Pat::Tuple(pattern) => self.between(pattern.paren_token.span),
            Pat::Paren(pattern) => self.between(pattern.paren_token.span),
            Pat::Slice(pattern) => self.between(pattern.bracket_token.span),
            Pat::Struct(pattern) => self.path(&pattern.path).span.to(self.between(pattern.brace_token.span)),
            Pat::TupleStruct(pattern) => {
                self.path(&pattern.path).span.to(self.between(pattern.paren_token.span))
            }
            Pat::Path(pattern) => self.path(&pattern.path).span,
            Pat::Rest(pattern) => {
                self.at(pattern.dot2_token.spans[0]).to(self.at(pattern.dot2_token.spans[1]))
            }
            Pat::Lit(pattern) => self.at(pattern.lit.span()),
            _ => return None,
        })
    }

    fn pattern(&mut self, pattern: &Pat) -> Pattern {
        match pattern {
            Pat::Ident(item) if item.by_ref.is_none() && item.subpat.is_none() => {
                Pattern::Name { name: self.name(&item.ident), mutable: item.mutability.is_some() }
            }
            Pat::Wild(_) => Pattern::Ignore,
            Pat::Paren(paren) => self.pattern(&paren.pat),
            Pat::Tuple(tuple) => {
                let span = self.between(tuple.paren_token.span);
                Pattern::Tuple(tuple.elems.iter().map(|pattern| self.pattern(pattern)).collect(), span)
            }
            Pat::Slice(slice) => {
                let span = self.between(slice.bracket_token.span);
                Pattern::Tuple(slice.elems.iter().map(|pattern| self.pattern(pattern)).collect(), span)
            }
            other => {
                let span = self.pattern_span(other).unwrap_or_default();
                self.error_help(
                    span,
                    "such patterns are not part of the force language",
                    "neither a name nor a tuple of names",
                    "bind a name and take its fields, or write `let (p, q) = …;`",
                );
                Pattern::Ignore
            }
        }
    }

    /// Reads an expression without a value: an assignment or a loop.
    fn statement(&mut self, expr: &Expr) -> Option<Statement> {
        match expr {
            Expr::Assign(assign) => {
                let target = self.expr(&assign.left);
                let value = self.expr(&assign.right);
                Some(self.assignment(target, None, value))
            }
            Expr::Binary(binary) => {
                let op = match binary.op {
                    BinOp::AddAssign(_) => BinaryOp::Add,
                    BinOp::SubAssign(_) => BinaryOp::Subtract,
                    BinOp::MulAssign(_) => BinaryOp::Multiply,
                    BinOp::DivAssign(_) => BinaryOp::Divide,
                    BinOp::RemAssign(_) => BinaryOp::Remainder,
                    _ => return None,
                };
                let target = self.expr(&binary.left);
                let value = self.expr(&binary.right);
                Some(self.assignment(target, Some(op), value))
            }
            Expr::ForLoop(item) => Some(self.repeat(item)),
            _ => None,
        }
    }

    fn assignment(&mut self, target: ExprId, op: Option<BinaryOp>, value: ExprId) -> Statement {
        let span = self.expressions[target].span.to(self.expressions[value].span);
        Statement::Assign { target, op, value, span }
    }

    fn repeat(&mut self, item: &syn::ExprForLoop) -> Statement {
        let token = self.at(item.for_token.span);
        self.label(item.label.as_ref());
        let variable = match &*item.pat {
            Pat::Ident(pattern) if pattern.by_ref.is_none() && pattern.subpat.is_none() => {
                Some(self.name(&pattern.ident))
            }
            Pat::Wild(_) => None,
            pattern => {
                let span = self.pattern_span(pattern).unwrap_or(token);
                self.error_help(
                    span,
                    "a loop counts with a plain name",
                    "a pattern stands here",
                    "write `for i in 0..n`, and index with `i`",
                );
                None
            }
        };
        let mut range = &*item.expr;
        while let Expr::Paren(paren) = range {
            range = &paren.expr;
        }
        let (start, end, inclusive) = match range {
            Expr::Range(syn::ExprRange { start: Some(start), end: Some(end), limits, .. }) => {
                (self.expr(start), self.expr(end), matches!(limits, syn::RangeLimits::Closed(_)))
            }
            other => {
                let reversed = matches!(other, Expr::MethodCall(call) if call.method == "rev");
                let span = match other {
                    Expr::MethodCall(call) => self.at(call.method.span()),
                    Expr::Range(range) => self.limits_span(&range.limits),
                    other => {
                        let value = self.expr(other);
                        self.expressions[value].span
                    }
                };
                let help = if reversed {
                    "count up with `for i in 0..n` and use `n - 1 - i`"
                } else {
                    "write `for i in 0..n`, and index with `i`"
                };
                self.error_help(span, "a loop runs over a constant range", "not a range with two ends", help);
                let poison = self.poison(span);
                (poison, poison, false)
            }
        };
        let body = self.block(&item.body);
        let span = token.to(self.expressions[end].span);
        Statement::For(Loop { variable, start, end, inclusive, body, span })
    }

    pub(super) fn limits_span(&mut self, limits: &syn::RangeLimits) -> Span {
        match limits {
            syn::RangeLimits::HalfOpen(dots) => self.at(dots.spans[0]).to(self.at(dots.spans[1])),
            syn::RangeLimits::Closed(dots) => self.at(dots.spans[0]).to(self.at(dots.spans[2])),
        }
    }

    pub(super) fn label(&mut self, label: Option<&syn::Label>) {
        if let Some(label) = label {
            let span = self.at(label.name.apostrophe).to(self.at(label.name.ident.span()));
            self.error_help(
                span,
                "labels are not part of the force language",
                "no `break` can use it",
                "leave it out",
            );
        }
    }

    pub(super) fn macro_call(&mut self, span: Span) {
        self.error_help(
            span,
            "macros are not part of the force language",
            "the compiler does not expand it",
            "write out what it stands for; nothing can be printed or asserted in a kernel",
        );
    }
}
