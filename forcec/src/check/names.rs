//! Name resolution: reports unknown names, unused names and recursion.
//!
//! In: the functions of a file, including branches that constant conditions exclude. Out: errors, warnings,
//! and the call graph. Promise: all unknown names are reported, so the elaborator need not report them.

use crate::check::builtins;
use crate::check::program::{PI, Program};
use crate::check::scope::Scope;
use crate::check::types::Type;
use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::span::Span;
use crate::source::suggest;
use crate::syntax::ast::{
    Block, Constant, ExprId, ExprKind, Expressions, Function, FunctionKind, Name, Path, Pattern,
    StatedDomain, Statement, TypeKind,
};
use std::collections::{BTreeMap, BTreeSet};

/// The result of name resolution.
pub(crate) struct Names {
    /// Whether each function is recursive or calls one that is; neither can be inlined.
    pub(crate) recursive: Vec<bool>,
    /// The functions that each function calls directly.
    pub(crate) calls: Vec<Vec<usize>>,
    pub(crate) diagnostics: Vec<Diagnostic>,
}

/// Resolves every name of the program.
pub(crate) fn resolve(program: &Program<'_>) -> Names {
    let mut diagnostics = Vec::new();
    for constant in program.constants {
        constant_names(program, constant, &mut diagnostics);
    }
    let mut calls: Vec<BTreeMap<usize, Span>> = Vec::new();
    for function in program.functions {
        let mut walker = Walker::new(program, &function.expressions);
        walker.function(function);
        diagnostics.append(&mut walker.diagnostics);
        calls.push(walker.calls);
    }
    let recursive = recursion(program, &calls, &mut diagnostics);
    let calls = calls.into_iter().map(|calls| calls.into_keys().collect()).collect();
    Names { recursive, calls, diagnostics }
}

fn constant_names(program: &Program<'_>, constant: &Constant, diagnostics: &mut Vec<Diagnostic>) {
    let mut walker = Walker::new(program, &constant.expressions);
    walker.expr(constant.value);
    walker.ty(&constant.ty);
    diagnostics.append(&mut walker.diagnostics);
}

/// A variable in scope.
struct Variable<'a> {
    name: &'a Name,
    mutable: bool,
    used: bool,
    /// Its kind in the warning if it is unused; `None` without a warning.
    what: Option<&'static str>,
}

struct Walker<'a> {
    program: &'a Program<'a>,
    expressions: &'a Expressions,
    variables: Scope<'a, Variable<'a>>,
    /// The called functions with their first calls.
    calls: BTreeMap<usize, Span>,
    diagnostics: Vec<Diagnostic>,
}

impl<'a> Walker<'a> {
    fn new(program: &'a Program<'a>, expressions: &'a Expressions) -> Walker<'a> {
        Walker {
            program,
            expressions,
            variables: Scope::new(),
            calls: BTreeMap::new(),
            diagnostics: Vec::new(),
        }
    }

    fn function(&mut self, function: &'a Function) {
        let mut names = BTreeSet::new();
        for argument in &function.arguments {
            if !names.insert(argument.name.text.as_str()) {
                self.diagnostics.push(
                    Diagnostic::error(
                        argument.name.span,
                        format!("`{}` is an argument twice", argument.name.text),
                        "the second of this name",
                    )
                    .help("choose another name"),
                );
            }
            let body = matches!(&argument.ty.kind, TypeKind::Named(name) if matches!(Type::named(name), Some(Type::Body(_))));
            let what = match (function.kind, body) {
                (FunctionKind::Helper, _) => "argument",
                (_, true) => "body",
                (_, false) => "parameter",
            };
            self.ty(&argument.ty);
            self.bind(&argument.name, argument.mutable, Some(what));
        }
        self.ty(&function.output);
        self.block(&function.body);
        self.leave(0);
        for clause in &function.domains {
            match clause.stated {
                StatedDomain::Range(low, high) => {
                    self.expr(low);
                    self.expr(high);
                }
                StatedDomain::Scale(length) => self.expr(length),
                StatedDomain::Unit => {}
            }
        }
    }

    fn bind(&mut self, name: &'a Name, mutable: bool, what: Option<&'static str>) {
        if self.program.constant(&name.text).is_some() || name.text == PI {
            self.diagnostics.push(
                Diagnostic::error(
                    name.span,
                    format!("`{}` is a constant", name.text),
                    "Rust compares with the constant here and binds nothing",
                )
                .help("choose another name"),
            );
        }
        self.variables.bind(&name.text, Variable { name, mutable, used: false, what });
    }

    /// Ends the scope of the variables above a mark.
    fn leave(&mut self, mark: usize) {
        for variable in self.variables.leave(mark) {
            let Some(what) = variable.what.filter(|_| !variable.used && !variable.name.text.starts_with('_'))
            else {
                continue;
            };
            let text = &variable.name.text;
            self.diagnostics.push(
                Diagnostic::warning(
                    variable.name.span,
                    format!("unused {what} `{text}`"),
                    "nothing reads it",
                )
                .help(format!("leave it out, or call it `_{text}`"))
                .lint(Lint::Unused),
            );
        }
    }

    fn block(&mut self, block: &'a Block) {
        let mark = self.variables.mark();
        for statement in &block.statements {
            match statement {
                Statement::Let { pattern, ty, value } => {
                    if let Some(ty) = ty {
                        self.ty(ty);
                    }
                    self.expr(*value);
                    self.pattern(pattern);
                }
                Statement::Assign { target, value, .. } => {
                    self.expr(*value);
                    self.target(*target);
                }
                Statement::For(repeat) => {
                    self.expr(repeat.start);
                    self.expr(repeat.end);
                    let inner = self.variables.mark();
                    if let Some(name) = &repeat.variable {
                        self.bind(name, false, None);
                    }
                    self.block(&repeat.body);
                    self.leave(inner);
                }
                Statement::Expr(value) => {
                    self.expr(*value);
                    self.dropped(*value);
                }
            }
        }
        if let Some(value) = block.value {
            self.expr(value);
        }
        self.leave(mark);
    }

    /// Warns about a dropped value: the language has no side effects.
    fn dropped(&mut self, id: ExprId) {
        let expr = &self.expressions[id];
        if !matches!(expr.kind, ExprKind::If(..) | ExprKind::Block(_) | ExprKind::Error) {
            self.diagnostics.push(
                Diagnostic::warning(expr.span, "a value that nothing uses", "computed and dropped")
                    .help("leave it out, bind it by `let`, or assign it")
                    .lint(Lint::Unused),
            );
        }
    }

    fn pattern(&mut self, pattern: &'a Pattern) {
        match pattern {
            Pattern::Name { name, mutable } => self.bind(name, *mutable, Some("variable")),
            Pattern::Ignore => {}
            Pattern::Tuple(patterns, _) => patterns.iter().for_each(|pattern| self.pattern(pattern)),
        }
    }

    /// The target of an assignment: its variable must exist and be `mut`. An assignment is not a use.
    fn target(&mut self, id: ExprId) {
        let expr = &self.expressions[id];
        match &expr.kind {
            ExprKind::Field(base, _) => self.target(*base),
            ExprKind::Index(base, index) => {
                self.expr(*index);
                self.target(*base);
            }
            ExprKind::Path(path) => {
                let Some(name) = path.single() else { return self.not_a_place(expr.span) };
                match self.variables.find(name).map(|place| self.variables.at(place).mutable) {
                    Some(false) => {
                        self.diagnostics.push(
                            Diagnostic::error(
                                expr.span,
                                format!("`{name}` cannot be assigned"),
                                "not declared `mut`",
                            )
                            .help(format!("write `let mut {name} = …;`")),
                        );
                    }
                    Some(true) => {}
                    None => {
                        let before = self.diagnostics.len();
                        self.unknown(path);
                        for diagnostic in &mut self.diagnostics[before..] {
                            diagnostic
                                .help
                                .get_or_insert_with(|| format!("to bind it write `let {name} = …;`"));
                        }
                    }
                }
            }
            ExprKind::Error => {}
            _ => self.not_a_place(expr.span),
        }
    }

    fn not_a_place(&mut self, span: Span) {
        self.diagnostics.push(
            Diagnostic::error(span, "this cannot be assigned", "not a variable or a part of one")
                .help("assign to a `let mut` variable"),
        );
    }

    fn expr(&mut self, id: ExprId) {
        match &self.expressions[id].kind {
            ExprKind::Number(_) | ExprKind::Integer(_) | ExprKind::Truth(_) | ExprKind::Error => {}
            ExprKind::Path(path) => self.path(path),
            ExprKind::Unary(_, x) | ExprKind::Field(x, _) => self.expr(*x),
            ExprKind::Cast(x, ty) => {
                self.expr(*x);
                self.ty(ty);
            }
            ExprKind::Binary(_, x, y) | ExprKind::Index(x, y) | ExprKind::Repeat(x, y) => {
                self.expr(*x);
                self.expr(*y);
            }
            ExprKind::Call(path, arguments) => {
                self.call(path);
                arguments.iter().for_each(|argument| self.expr(*argument));
            }
            ExprKind::Method(receiver, _, arguments) => {
                self.expr(*receiver);
                arguments.iter().for_each(|argument| self.expr(*argument));
            }
            ExprKind::Tuple(elements) | ExprKind::Array(elements) => {
                elements.iter().for_each(|element| self.expr(*element));
            }
            ExprKind::Struct(_, fields) => fields.iter().for_each(|(_, value)| self.expr(*value)),
            ExprKind::Block(block) => self.block(block),
            ExprKind::If(condition, then, otherwise) => {
                self.expr(*condition);
                self.block(then);
                if let Some(otherwise) = otherwise {
                    self.expr(*otherwise);
                }
            }
        }
    }

    /// Resolves names in the lengths of arrays.
    fn ty(&mut self, ty: &'a crate::syntax::ast::Type) {
        match &ty.kind {
            TypeKind::Array(element, length) => {
                self.ty(element);
                self.expr(*length);
            }
            TypeKind::Tuple(types) => types.iter().for_each(|ty| self.ty(ty)),
            TypeKind::Named(_) | TypeKind::Error => {}
        }
    }

    fn path(&mut self, path: &Path) {
        if let Some(name) = path.single()
            && let Some(place) = self.variables.find(name)
        {
            self.variables.at(place).used = true;
            return;
        }
        let known = self.program.constant(path.last()).is_some() || path.last() == PI;
        if !self.elsewhere(path) && !known {
            self.unknown(path);
        }
    }

    /// Reports a path to an item outside the file if the file has an item of the same name. Paths through
    /// `crate` and `super` are accepted, because the module that contains the file is unknown.
    fn elsewhere(&mut self, path: &Path) -> bool {
        let [.., place, last] = path.segments.as_slice() else { return false };
        let first = &path.segments[0];
        let pi = last == PI && ["consts", "prelude"].contains(&place.as_str());
        let here =
            ["self", "super", "crate"].contains(&first.as_str()) || self.program.modules.contains(first);
        let known =
            last == PI || self.program.constant(last).is_some() || self.program.function(last).is_some();
        let out = known && !pi && !here;
        if out {
            let message = format!("`{last}` of `{place}` is not part of this file");
            let error = Diagnostic::error(path.span, message, "only items of this file are known");
            self.diagnostics.push(error.help(format!("for that of this file write `{last}`")));
        }
        out
    }

    fn unknown(&mut self, path: &Path) {
        let name = path.last();
        let known = self.variables.names().chain(self.program.constant_names());
        let standard = STANDARD_CONSTANTS.iter().find(|(constant, _)| *constant == name);
        let help = if let Some((_, ours)) = standard {
            Some(format!("write `{ours}`"))
        } else if self.program.function(name).is_some() {
            Some(format!("`{name}` is a function; call it, `{name}(…)`"))
        } else if ["EPSILON", "INFINITY", "NEG_INFINITY", "NAN", "MAX", "MIN", "MIN_POSITIVE"].contains(&name)
        {
            Some("write the number that is meant".to_owned())
        } else {
            suggest::did_you_mean(name, known)
        };
        let mut diagnostic = Diagnostic::error(
            path.span,
            format!("unknown name `{name}`"),
            "not bound here, and not a constant",
        );
        diagnostic.help = help;
        self.diagnostics.push(diagnostic);
    }

    fn call(&mut self, path: &Path) {
        let name = path.last();
        if let [.., ty, _] = path.segments.as_slice()
            && (Type::named(ty).is_some() || ty.starts_with(|c: char| c.is_ascii_uppercase()))
        {
            // A function of a type; the elaborator checks its name.
            return;
        }
        if self.elsewhere(path) {
            return;
        }
        if let Some(index) = self.program.function(name) {
            self.calls.entry(index).or_insert(path.span);
            return;
        }
        let mut diagnostic = Diagnostic::error(
            path.span,
            format!("unknown function `{name}`"),
            "no function of this file has this name",
        );
        diagnostic.help = if let Some(arguments) = builtins::method_arguments(name) {
            let arguments = if arguments == 0 { "" } else { "…" };
            Some(format!("`{name}` is a method; write `x.{name}({arguments})`"))
        } else if let Some(other) = builtins::instead(name, &Type::Real) {
            Some(other.to_owned())
        } else if let Some(ty) = Type::names().find(|ty| ty.eq_ignore_ascii_case(name)) {
            Some(format!("write `{ty}::new(…)`"))
        } else {
            suggest::did_you_mean(name, self.program.callable())
        };
        self.diagnostics.push(diagnostic);
    }
}

/// Constants of the standard library, and what to write instead.
const STANDARD_CONSTANTS: [(&str, &str); 8] = [
    ("TAU", "2.0 * PI"),
    ("FRAC_PI_2", "PI / 2.0"),
    ("FRAC_PI_3", "PI / 3.0"),
    ("FRAC_PI_4", "PI / 4.0"),
    ("FRAC_PI_6", "PI / 6.0"),
    ("FRAC_1_PI", "1.0 / PI"),
    ("SQRT_2", "(2.0).sqrt()"),
    ("E", "(1.0).exp()"),
];

/// Finds the recursive functions, and reports each cycle at the call that closes it.
fn recursion(
    program: &Program<'_>,
    calls: &[BTreeMap<usize, Span>],
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<bool> {
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        New,
        Open,
        Done,
    }
    let mut state = vec![State::New; calls.len()];
    let mut recursive = vec![false; calls.len()];
    for root in 0..calls.len() {
        // The path from the root; each function has its remaining calls.
        let mut path: Vec<(usize, Vec<(usize, Span)>)> = Vec::new();
        let mut next = (state[root] == State::New).then_some(root);
        loop {
            if let Some(function) = next.take() {
                state[function] = State::Open;
                let mut callees: Vec<(usize, Span)> = calls[function].iter().map(|(f, s)| (*f, *s)).collect();
                callees.reverse();
                path.push((function, callees));
            }
            let Some((function, callees)) = path.last_mut() else { break };
            let function = *function;
            let Some((callee, span)) = callees.pop() else {
                state[function] = State::Done;
                path.pop();
                continue;
            };
            match state[callee] {
                State::New => next = Some(callee),
                State::Done => recursive[function] |= recursive[callee],
                State::Open => {
                    let start = path.iter().position(|(f, _)| *f == callee).unwrap_or(0);
                    let cycle: Vec<usize> = path[start..].iter().map(|(f, _)| *f).collect();
                    cycle.iter().for_each(|f| recursive[*f] = true);
                    let name = |f: usize| format!("`{}`", program.functions[f].name.text);
                    let mut chain: Vec<String> = cycle.iter().map(|f| name(*f)).collect();
                    chain.push(name(callee));
                    diagnostics.push(
                        Diagnostic::error(
                            span,
                            format!("{} calls itself", name(callee)),
                            chain.join(" calls "),
                        )
                        .help("helpers are inlined; repeat with `for i in 0..n` over a constant range"),
                    );
                }
            }
        }
    }
    // A function that calls a recursive function cannot be inlined either.
    loop {
        let before = recursive.clone();
        for (function, callees) in calls.iter().enumerate() {
            recursive[function] |= callees.keys().any(|callee| recursive[*callee]);
        }
        if recursive == before {
            return recursive;
        }
    }
}
