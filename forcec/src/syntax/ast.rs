//! The syntax tree of a force file, with source positions, without Rust syntax outside the force language.
//!
//! The expressions of a function are in one arena, operands before users, and have `Copy` ids, so a tree of
//! any depth is stored flat. Names are not yet resolved, and types are not yet checked.

use crate::math::exact::Exact;
use crate::options::Choice;
use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::span::{Source, Span};

/// A parsed force file.
#[derive(Clone, Debug)]
pub struct File {
    /// The source text that the spans refer to.
    pub source: Source,
    /// Lines of its `//!` comment, without the leading space.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub docs: Vec<String>,
    /// The functions, helpers included, in source order.
    pub functions: Vec<Function>,
    /// The constants, in source order.
    pub constants: Vec<Constant>,
    /// Names of its `#[forces]` modules.
    pub modules: Vec<String>,
    /// Lints that an attribute allows without a reason, with positions.
    pub unexplained: Vec<(Lint, Span)>,
}

impl File {
    /// The force functions, in source order.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn forces(&self) -> impl Iterator<Item = &Function> {
        self.functions.iter().filter(|f| f.kind != FunctionKind::Helper)
    }

    /// The function with this name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|f| f.name.text == name)
    }

    /// A warning for each attribute that allows a lint without a reason.
    pub fn unexplained(&self) -> impl Iterator<Item = Diagnostic> {
        self.unexplained.iter().map(|(lint, span)| {
            let name = lint.name();
            let message = format!("`{name}` is allowed without a reason");
            let help = format!("write `#[allow({name}, reason = \"…\")]`");
            Diagnostic::warning(*span, message, "no `reason` here").help(help).lint(Lint::MissingReason)
        })
    }

    /// Lines of the doc comment at the head of the file.
    pub fn docs(&self) -> Vec<String> {
        let text = self.source.text.trim_start_matches('\u{feff}');
        // A licence or a note may precede the documentation.
        let before =
            |line: &&str| line.trim().is_empty() || line.starts_with("//") && !line.starts_with("//!");
        let lines = text.lines().skip_while(before).map_while(|line| line.strip_prefix("//!"));
        lines.map(|line| line.strip_prefix(' ').unwrap_or(line).trim_end().to_owned()).collect()
    }
}

/// An identifier with its position.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Name {
    /// The identifier.
    pub text: String,
    /// Its position.
    pub span: Span,
}

/// The kind of a function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FunctionKind {
    /// No attribute: inlined at each call.
    Helper,
    /// `#[constraint]`
    Constraint {
        /// Whether rows push only while they are negative.
        unilateral: bool,
        /// Whether `stiffness` and `damping` have one entry per row.
        per_row: bool,
    },
    /// `#[energy]`
    Energy,
    /// `#[force]`
    Force,
}

/// An option that an attribute states.
#[derive(Clone, Debug)]
pub struct Stated {
    /// The option with its value.
    pub choice: Choice,
    /// Its position.
    pub span: Span,
    /// Positions of its values.
    pub places: Vec<Span>,
    /// Whether a module states it, for those of its functions that it applies to.
    pub shared: bool,
}

/// A force function or a helper.
#[derive(Clone, Debug)]
pub struct Function {
    /// Lines of its doc comment, without the leading space.
    pub docs: Vec<String>,
    /// Helper, or kind of force function.
    pub kind: FunctionKind,
    /// Options of the module's attribute, then of its own.
    pub options: Vec<Stated>,
    /// The clauses of `#[domain(…)]`.
    pub domains: Vec<DomainClause>,
    /// Its name in the source.
    pub name: Name,
    /// Its arguments, in source order.
    pub arguments: Vec<Argument>,
    /// Its return type; the empty tuple if omitted.
    pub output: Type,
    /// The arena of its expressions.
    pub expressions: Expressions,
    /// Its body, a block.
    pub body: Block,
    /// From its name to the end of its body.
    pub span: Span,
    /// The lints that its attributes and those of its module and file allow.
    pub allowed: Vec<Lint>,
}

impl Function {
    /// The options that apply to it, in order.
    pub fn choices(&self) -> impl Iterator<Item = &Choice> {
        self.options.iter().map(|stated| &stated.choice)
    }

    /// Names that it binds: its arguments, and the variables in its body.
    pub fn bound(&self) -> Vec<&Name> {
        let mut names: Vec<&Name> = self.arguments.iter().map(|argument| &argument.name).collect();
        let mut blocks = vec![&self.body];
        for expr in self.expressions.iter() {
            match &expr.kind {
                ExprKind::Block(block) | ExprKind::If(_, block, _) => blocks.push(block),
                _ => {}
            }
        }
        let mut patterns = Vec::new();
        while let Some(block) = blocks.pop() {
            for statement in &block.statements {
                match statement {
                    Statement::Let { pattern, .. } => patterns.push(pattern),
                    Statement::For(repeat) => {
                        names.extend(&repeat.variable);
                        blocks.push(&repeat.body);
                    }
                    _ => {}
                }
            }
        }
        while let Some(pattern) = patterns.pop() {
            match pattern {
                Pattern::Name { name, .. } => names.push(name),
                Pattern::Tuple(inner, _) => patterns.extend(inner),
                Pattern::Ignore => {}
            }
        }
        names.sort_by_key(|name| name.span);
        names
    }

    /// Position where an option sets a parameter.
    pub fn sets(&self, parameter: &str) -> Option<Span> {
        let mut places = self.options.iter().rev().filter_map(|stated| {
            let Choice::Known(known) = &stated.choice else { return None };
            let at = known.set.iter().position(|(name, _)| name == parameter)?;
            stated.places.get(at).copied()
        });
        places.next()
    }
}

/// One argument of a function.
#[derive(Clone, Debug)]
pub struct Argument {
    /// Its name in the source.
    pub name: Name,
    /// Whether it is declared `mut`.
    pub mutable: bool,
    /// Its type as written.
    pub ty: Type,
}

/// One clause of `#[domain(…)]`.
#[derive(Clone, Debug)]
pub struct DomainClause {
    /// The parameter, the body, or `length`.
    pub name: Name,
    /// The field of the body, if any.
    pub field: Option<Name>,
    /// Stated domain.
    pub stated: StatedDomain,
    /// Position of the clause.
    pub span: Span,
}

/// The domain that a clause of `#[domain(…)]` states.
#[derive(Clone, Copy, Debug)]
pub enum StatedDomain {
    /// `lo..hi` or `lo..=hi`
    Range(ExprId, ExprId),
    /// `unit`
    Unit,
    /// One number: the length scale of all bodies.
    Scale(ExprId),
}

/// A constant of the file.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Its name in the source.
    pub name: Name,
    /// Its type as written.
    pub ty: Type,
    /// The arena of its expressions.
    pub expressions: Expressions,
    /// Its value, an expression.
    pub value: ExprId,
}

/// A type as written, without references.
#[derive(Clone, Debug)]
pub struct Type {
    /// Its form.
    pub kind: TypeKind,
    /// Its position.
    pub span: Span,
}

/// The form of a type.
#[derive(Clone, Debug)]
pub enum TypeKind {
    /// A name, the last segment of its path.
    Named(String),
    /// A tuple; empty if no type is written.
    Tuple(Vec<Type>),
    /// `[T; n]`
    Array(Box<Type>, ExprId),
    /// An invalid type, whose error was reported.
    Error,
}

/// An expression, by its index in the arena of its function.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct ExprId(u32);

/// The arena of a function's expressions.
#[derive(Clone, Default, Debug)]
pub struct Expressions(Vec<Expr>);

impl Expressions {
    /// Adds an expression and returns its id.
    pub fn push(&mut self, kind: ExprKind, span: Span) -> ExprId {
        self.0.push(Expr { kind, span });
        ExprId(self.0.len() as u32 - 1)
    }

    /// All expressions, operands before users.
    pub fn iter(&self) -> impl Iterator<Item = &Expr> {
        self.0.iter()
    }

    /// Number of expressions.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether the arena is empty.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl std::ops::IndexMut<ExprId> for Expressions {
    fn index_mut(&mut self, id: ExprId) -> &mut Expr {
        &mut self.0[id.0 as usize]
    }
}

impl std::ops::Index<ExprId> for Expressions {
    type Output = Expr;
    fn index(&self, id: ExprId) -> &Expr {
        &self.0[id.0 as usize]
    }
}

/// An expression with its position.
#[derive(Clone, Debug)]
pub struct Expr {
    /// Its form.
    pub kind: ExprKind,
    /// Its position.
    pub span: Span,
}

/// The form of an expression. `&x`, `(x)` and `*x` are `x`.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// A literal with a point or an exponent.
    Number(Exact),
    /// A literal without a point or an exponent.
    Integer(i64),
    /// `true` or `false`
    Truth(bool),
    /// A name, or a path of names.
    Path(Path),
    /// A prefix operator.
    Unary(UnaryOp, ExprId),
    /// An operator between two operands.
    Binary(BinaryOp, ExprId, ExprId),
    /// `f(x, y)`
    Call(Path, Vec<ExprId>),
    /// `x.f(y)`
    Method(ExprId, Name, Vec<ExprId>),
    /// `x.y` or `x.0`
    Field(ExprId, Name),
    /// `x[i]`
    Index(ExprId, ExprId),
    /// `(x, y)`
    Tuple(Vec<ExprId>),
    /// `[x, y]`
    Array(Vec<ExprId>),
    /// `[x; n]`
    Repeat(ExprId, ExprId),
    /// `Name { field: x }`
    Struct(Path, Vec<(Name, ExprId)>),
    /// `x as T`
    Cast(ExprId, Type),
    /// `{ … }`
    Block(Block),
    /// `if c { … } else …`
    If(ExprId, Block, Option<ExprId>),
    /// An invalid expression, whose error was reported.
    Error,
}

/// One or more names joined by `::`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Path {
    /// The segments; at least one.
    pub segments: Vec<String>,
    /// Its position.
    pub span: Span,
}

impl Path {
    /// The last segment.
    pub fn last(&self) -> &str {
        self.segments.last().map_or("", String::as_str)
    }

    /// The name, if the path has only one segment.
    pub fn single(&self) -> Option<&str> {
        if self.segments.len() == 1 { Some(&self.segments[0]) } else { None }
    }
}

/// A prefix operator.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum UnaryOp {
    /// `-`
    Negate,
    /// `!`
    Not,
}

/// An operator between two operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BinaryOp {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `%`
    Remainder,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
    /// `==`
    Equal,
    /// `!=`
    NotEqual,
    /// `&&`
    And,
    /// `||`
    Or,
}

impl BinaryOp {
    /// The operator in the source.
    pub fn symbol(self) -> &'static str {
        match self {
            BinaryOp::Add => "+",
            BinaryOp::Subtract => "-",
            BinaryOp::Multiply => "*",
            BinaryOp::Divide => "/",
            BinaryOp::Remainder => "%",
            BinaryOp::Less => "<",
            BinaryOp::LessEqual => "<=",
            BinaryOp::Greater => ">",
            BinaryOp::GreaterEqual => ">=",
            BinaryOp::Equal => "==",
            BinaryOp::NotEqual => "!=",
            BinaryOp::And => "&&",
            BinaryOp::Or => "||",
        }
    }
}

/// A block: statements, and possibly a value.
#[derive(Clone, Debug)]
pub struct Block {
    /// The statements, in order.
    pub statements: Vec<Statement>,
    /// The value of the block.
    pub value: Option<ExprId>,
    /// From brace to brace.
    pub span: Span,
}

/// One statement.
#[derive(Clone, Debug)]
pub enum Statement {
    /// `let p: T = x;`, and `const N: T = x;` within a body
    Let {
        /// The bound names.
        pattern: Pattern,
        /// The type, if one is written.
        ty: Option<Type>,
        /// The bound value.
        value: ExprId,
    },
    /// `x = y;`, `x += y;`
    Assign {
        /// The assigned variable, or a part of it.
        target: ExprId,
        /// The operator of a compound assignment.
        op: Option<BinaryOp>,
        /// The right-hand side.
        value: ExprId,
        /// The whole statement.
        span: Span,
    },
    /// `for i in a..b { … }`
    For(Loop),
    /// An expression whose value is dropped, or an `if` with assignments.
    Expr(ExprId),
}

/// A loop over a constant range.
#[derive(Clone, Debug)]
pub struct Loop {
    /// The variable; `None` for `_`.
    pub variable: Option<Name>,
    /// The first value.
    pub start: ExprId,
    /// The end of the range.
    pub end: ExprId,
    /// Whether the range is `..=`.
    pub inclusive: bool,
    /// The repeated block.
    pub body: Block,
    /// From `for` to the end of the range.
    pub span: Span,
}

/// The pattern of a `let`.
#[derive(Clone, Debug)]
pub enum Pattern {
    /// A variable.
    Name {
        /// Its name.
        name: Name,
        /// Whether it is declared `mut`.
        mutable: bool,
    },
    /// `_`
    Ignore,
    /// `(p, q)`, or `[p, q]`
    Tuple(Vec<Pattern>, Span),
}
