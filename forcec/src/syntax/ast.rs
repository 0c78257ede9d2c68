//! The syntax tree: what a force file says, with places, free of everything the language leaves out.
//!
//! Expressions lie in one arena per function, operands before users, and are named by `Copy` ids: a tree of any depth
//! is flat memory. Names are not resolved and types are not checked yet.

use crate::math::exact::Exact;
use crate::options::Choice;
use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::span::{Source, Span};

/// A parsed force file.
#[derive(Clone, Debug)]
pub struct File {
    /// The text the spans point into.
    pub source: Source,
    /// Its `//!` comment, a line each, without the leading space.
    #[cfg_attr(not(feature = "internals"), expect(dead_code, reason = "tests use it"))]
    pub docs: Vec<String>,
    /// The functions, helpers included, in source order.
    pub functions: Vec<Function>,
    /// The constants, in source order.
    pub constants: Vec<Constant>,
    /// The names of the modules of forces among its items.
    pub modules: Vec<String>,
    /// What attributes allow without a reason, and where.
    pub unexplained: Vec<(Lint, Span)>,
}

impl File {
    /// The force functions, in source order.
    #[cfg_attr(not(feature = "internals"), expect(dead_code, reason = "tests use it"))]
    pub fn forces(&self) -> impl Iterator<Item = &Function> {
        self.functions.iter().filter(|f| f.kind != FunctionKind::Helper)
    }

    /// The function of that name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|f| f.name.text == name)
    }

    /// A warning for each attribute that answers warnings and does not say why.
    pub fn unexplained(&self) -> impl Iterator<Item = Diagnostic> {
        self.unexplained.iter().map(|(lint, span)| {
            let name = lint.name();
            let message = format!("`{name}` is allowed without a reason");
            let help = format!("write `#[allow({name}, reason = \"…\")]`");
            Diagnostic::warning(*span, message, "no `reason` here").help(help).lint(Lint::MissingReason)
        })
    }

    /// The doc comment at the head of the file, a line each.
    pub fn docs(&self) -> Vec<String> {
        let text = self.source.text.trim_start_matches('\u{feff}');
        // A licence or a note to editors may stand before the documentation.
        let before =
            |line: &&str| line.trim().is_empty() || line.starts_with("//") && !line.starts_with("//!");
        let lines = text.lines().skip_while(before).map_while(|line| line.strip_prefix("//!"));
        lines.map(|line| line.strip_prefix(' ').unwrap_or(line).trim_end().to_owned()).collect()
    }
}

/// An identifier and where it stands.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Name {
    /// The identifier.
    pub text: String,
    /// Where it stands.
    pub span: Span,
}

/// What a function is to the compiler.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FunctionKind {
    /// No attribute: inlined where it is called.
    Helper,
    /// `#[constraint]`
    Constraint {
        /// Rows push only while they are negative.
        unilateral: bool,
        /// `stiffness` and `damping` have an entry a row.
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
    /// What is stated.
    pub choice: Choice,
    /// Where.
    pub span: Span,
    /// Where each of its values stands.
    pub places: Vec<Span>,
    /// Whether it is stated of a module, and holds for those of its functions that it fits.
    pub shared: bool,
}

/// A function.
#[derive(Clone, Debug)]
pub struct Function {
    /// Doc comment, a line each, without the leading space.
    pub docs: Vec<String>,
    /// What it is.
    pub kind: FunctionKind,
    /// The options of its module's attribute, then those of its own.
    pub options: Vec<Stated>,
    /// The clauses of `#[domain(…)]`.
    pub domains: Vec<DomainClause>,
    /// Its name.
    pub name: Name,
    /// Its arguments.
    pub arguments: Vec<Argument>,
    /// What it returns.
    pub output: Type,
    /// Its expressions.
    pub expressions: Expressions,
    /// Its body.
    pub body: Block,
    /// From its name to the end of its body.
    pub span: Span,
    /// The warnings that its attributes answer, and those of its module and file.
    pub allowed: Vec<Lint>,
}

impl Function {
    /// What it states of itself, in order.
    pub fn choices(&self) -> impl Iterator<Item = &Choice> {
        self.options.iter().map(|stated| &stated.choice)
    }

    /// The names that it binds: its arguments, and the variables in its body.
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

    /// Where it states the value of a parameter.
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
    /// Its name.
    pub name: Name,
    /// Whether it is declared `mut`.
    pub mutable: bool,
    /// Its type.
    pub ty: Type,
}

/// One clause of `#[domain(…)]`.
#[derive(Clone, Debug)]
pub struct DomainClause {
    /// The parameter, the body, or `length`.
    pub name: Name,
    /// The field of the body.
    pub field: Option<Name>,
    /// What is stated.
    pub stated: StatedDomain,
    /// Where the statement stands.
    pub span: Span,
}

/// What a clause of `#[domain(…)]` states.
#[derive(Clone, Copy, Debug)]
pub enum StatedDomain {
    /// `lo..hi` or `lo..=hi`
    Range(ExprId, ExprId),
    /// `unit`
    Unit,
    /// One number: the scale of all bodies.
    Scale(ExprId),
}

/// A constant.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Its name.
    pub name: Name,
    /// Its type.
    pub ty: Type,
    /// Its expressions.
    pub expressions: Expressions,
    /// Its value.
    pub value: ExprId,
}

/// A type as it is written, references stripped.
#[derive(Clone, Debug)]
pub struct Type {
    /// What it says.
    pub kind: TypeKind,
    /// Where it stands.
    pub span: Span,
}

/// The form of a type.
#[derive(Clone, Debug)]
pub enum TypeKind {
    /// A name, the last segment of its path.
    Named(String),
    /// A tuple; empty where nothing is returned.
    Tuple(Vec<Type>),
    /// `[T; n]`
    Array(Box<Type>, ExprId),
    /// Something a message was given for.
    Error,
}

/// An expression, by its place in the arena of its function.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct ExprId(u32);

/// The arena of a function's expressions.
#[derive(Clone, Default, Debug)]
pub struct Expressions(Vec<Expr>);

impl Expressions {
    /// Adds an expression.
    pub fn push(&mut self, kind: ExprKind, span: Span) -> ExprId {
        self.0.push(Expr { kind, span });
        ExprId(self.0.len() as u32 - 1)
    }

    /// All of them, operands before users.
    pub fn iter(&self) -> impl Iterator<Item = &Expr> {
        self.0.iter()
    }

    /// How many there are.
    #[cfg_attr(not(feature = "internals"), expect(dead_code, reason = "tests use it"))]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    #[cfg_attr(not(feature = "internals"), expect(dead_code, reason = "tests use it"))]
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

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// What it says.
    pub kind: ExprKind,
    /// Where it stands.
    pub span: Span,
}

/// The form of an expression. `&x`, `(x)` and `*x` are `x`.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// A literal with a point or an exponent.
    Number(Exact),
    /// A literal without.
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
    /// Something a message was given for.
    Error,
}

/// One or more names joined by `::`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Path {
    /// The segments; at least one.
    pub segments: Vec<String>,
    /// Where it stands.
    pub span: Span,
}

impl Path {
    /// The last segment.
    pub fn last(&self) -> &str {
        self.segments.last().map_or("", String::as_str)
    }

    /// The name, where there is but one segment.
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
    /// How it is written.
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

/// Statements and the value after them.
#[derive(Clone, Debug)]
pub struct Block {
    /// The statements, in order.
    pub statements: Vec<Statement>,
    /// The expression at the end.
    pub value: Option<ExprId>,
    /// From brace to brace.
    pub span: Span,
}

/// One statement.
#[derive(Clone, Debug)]
pub enum Statement {
    /// `let p: T = x;`, and `const N: T = x;` within a body
    Let {
        /// What is bound.
        pattern: Pattern,
        /// The type, if stated.
        ty: Option<Type>,
        /// The value.
        value: ExprId,
    },
    /// `x = y;`, `x += y;`
    Assign {
        /// The place.
        target: ExprId,
        /// The operator of a compound assignment.
        op: Option<BinaryOp>,
        /// The operand.
        value: ExprId,
        /// The whole statement.
        span: Span,
    },
    /// `for i in a..b { … }`
    For(Loop),
    /// An expression whose value is dropped, or an `if` for its assignments.
    Expr(ExprId),
}

/// A loop over a constant range.
#[derive(Clone, Debug)]
pub struct Loop {
    /// The variable; `None` for `_`.
    pub variable: Option<Name>,
    /// First value.
    pub start: ExprId,
    /// Last value, or one past it.
    pub end: ExprId,
    /// Whether the range is `..=`.
    pub inclusive: bool,
    /// What is repeated.
    pub body: Block,
    /// From `for` to the end of the range.
    pub span: Span,
}

/// What a `let` binds.
#[derive(Clone, Debug)]
pub enum Pattern {
    /// A name.
    Name {
        /// The name.
        name: Name,
        /// Whether it is declared `mut`.
        mutable: bool,
    },
    /// `_`
    Ignore,
    /// `(p, q)`, or `[p, q]`
    Tuple(Vec<Pattern>, Span),
}
