//! The text form of the syntax tree: one line per expression, indented below the expression that uses it.

use crate::syntax::ast::{
    Block, ExprId, ExprKind, Expressions, File, Function, FunctionKind, Pattern, StatedDomain, Statement,
    Type, TypeKind, UnaryOp,
};
use std::fmt;

impl fmt::Display for File {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for constant in &self.constants {
            let printer = Printer { expressions: &constant.expressions };
            writeln!(f, "const {}: {}", constant.name.text, printer.ty(&constant.ty))?;
            printer.tree(f, "", constant.value)?;
        }
        for function in &self.functions {
            write!(f, "{function}")?;
        }
        Ok(())
    }
}

impl fmt::Display for FunctionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FunctionKind::Helper => f.write_str("helper"),
            FunctionKind::Energy => f.write_str("energy"),
            FunctionKind::Force => f.write_str("force"),
            FunctionKind::Constraint { unilateral, per_row } => {
                f.write_str("constraint")?;
                let options = [("unilateral", *unilateral), ("per_row", *per_row)];
                let set: Vec<&str> = options.iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect();
                if set.is_empty() { Ok(()) } else { write!(f, "({})", set.join(", ")) }
            }
        }
    }
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let printer = Printer { expressions: &self.expressions };
        writeln!(f, "{} {}", self.kind, self.name.text)?;
        for argument in &self.arguments {
            let mutable = if argument.mutable { "mut " } else { "" };
            writeln!(f, "  argument {mutable}{}: {}", argument.name.text, printer.ty(&argument.ty))?;
        }
        writeln!(f, "  returns {}", printer.ty(&self.output))?;
        for clause in &self.domains {
            let field = clause.field.as_ref().map_or_else(String::new, |field| format!(".{}", field.text));
            writeln!(f, "  domain {}{field}", clause.name.text)?;
            match clause.stated {
                StatedDomain::Unit => writeln!(f, "    unit")?,
                StatedDomain::Scale(length) => printer.tree(f, "  ", length)?,
                StatedDomain::Range(low, high) => {
                    printer.tree(f, "  ", low)?;
                    printer.tree(f, "  ", high)?;
                }
            }
        }
        printer.block(f, "", &self.body)
    }
}

struct Printer<'a> {
    expressions: &'a Expressions,
}

impl Printer<'_> {
    fn ty(&self, ty: &Type) -> String {
        match &ty.kind {
            TypeKind::Named(name) => name.clone(),
            TypeKind::Tuple(types) => {
                let types: Vec<String> = types.iter().map(|t| self.ty(t)).collect();
                format!("({})", types.join(", "))
            }
            TypeKind::Array(element, length) => {
                format!("[{}; {}]", self.ty(element), self.line(*length))
            }
            TypeKind::Error => "?".to_owned(),
        }
    }

    /// The text of an expression without its operands.
    fn line(&self, id: ExprId) -> String {
        match &self.expressions[id].kind {
            ExprKind::Number(value) => format!("number {value}"),
            ExprKind::Integer(value) => value.to_string(),
            ExprKind::Truth(value) => value.to_string(),
            ExprKind::Path(path) => path.segments.join("::"),
            ExprKind::Unary(UnaryOp::Negate, _) => "negate".to_owned(),
            ExprKind::Unary(UnaryOp::Not, _) => "not".to_owned(),
            ExprKind::Binary(op, ..) => op.symbol().to_owned(),
            ExprKind::Call(path, _) => format!("call {}", path.segments.join("::")),
            ExprKind::Method(_, name, _) => format!("method {}", name.text),
            ExprKind::Field(_, name) => format!("field {}", name.text),
            ExprKind::Index(..) => "index".to_owned(),
            ExprKind::Tuple(_) => "tuple".to_owned(),
            ExprKind::Array(_) => "array".to_owned(),
            ExprKind::Repeat(..) => "repeat".to_owned(),
            ExprKind::Struct(path, _) => format!("struct {}", path.segments.join("::")),
            ExprKind::Cast(_, ty) => format!("as {}", self.ty(ty)),
            ExprKind::Block(_) => "block".to_owned(),
            ExprKind::If(..) => "if".to_owned(),
            ExprKind::Error => "error".to_owned(),
        }
    }

    /// Prints an expression and, below it, its operands.
    fn tree(&self, f: &mut fmt::Formatter<'_>, indent: &str, id: ExprId) -> fmt::Result {
        // Indentation is limited, so that a chain of thousands of operators prints in linear space.
        let deeper = if indent.len() < 120 { format!("{indent}  ") } else { indent.to_owned() };
        writeln!(f, "{deeper}{}", self.line(id))?;
        let all = |f: &mut fmt::Formatter<'_>, ids: &[ExprId]| {
            ids.iter().try_for_each(|id| self.tree(f, &deeper, *id))
        };
        match &self.expressions[id].kind {
            ExprKind::Unary(_, x) | ExprKind::Field(x, _) | ExprKind::Cast(x, _) => all(f, &[*x]),
            ExprKind::Binary(_, x, y) | ExprKind::Index(x, y) | ExprKind::Repeat(x, y) => all(f, &[*x, *y]),
            ExprKind::Call(_, arguments) => all(f, arguments),
            ExprKind::Method(receiver, _, arguments) => {
                all(f, &[*receiver])?;
                all(f, arguments)
            }
            ExprKind::Tuple(elements) | ExprKind::Array(elements) => all(f, elements),
            ExprKind::Struct(_, fields) => fields.iter().try_for_each(|(name, value)| {
                writeln!(f, "{deeper}  {}:", name.text)?;
                self.tree(f, &deeper, *value)
            }),
            ExprKind::Block(block) => self.block(f, &deeper, block),
            ExprKind::If(condition, then, otherwise) => {
                all(f, &[*condition])?;
                self.block(f, &deeper, then)?;
                match otherwise {
                    Some(otherwise) => all(f, &[*otherwise]),
                    None => Ok(()),
                }
            }
            ExprKind::Number(_)
            | ExprKind::Integer(_)
            | ExprKind::Truth(_)
            | ExprKind::Path(_)
            | ExprKind::Error => Ok(()),
        }
    }

    fn block(&self, f: &mut fmt::Formatter<'_>, indent: &str, block: &Block) -> fmt::Result {
        for statement in &block.statements {
            match statement {
                Statement::Let { pattern, ty, value } => {
                    let ty = ty.as_ref().map_or(String::new(), |ty| format!(": {}", self.ty(ty)));
                    writeln!(f, "{indent}  let {}{ty}", pattern_text(pattern))?;
                    self.tree(f, &format!("{indent}  "), *value)?;
                }
                Statement::Assign { target, op, value, .. } => {
                    writeln!(f, "{indent}  assign {}=", op.map_or("", |op| op.symbol()))?;
                    self.tree(f, &format!("{indent}  "), *target)?;
                    self.tree(f, &format!("{indent}  "), *value)?;
                }
                Statement::For(repeat) => {
                    let name = repeat.variable.as_ref().map_or("_", |name| &name.text);
                    let dots = if repeat.inclusive { "..=" } else { ".." };
                    let (start, end) = (self.line(repeat.start), self.line(repeat.end));
                    writeln!(f, "{indent}  for {name} in {start}{dots}{end}")?;
                    self.block(f, &format!("{indent}  "), &repeat.body)?;
                }
                Statement::Expr(value) => {
                    writeln!(f, "{indent}  statement")?;
                    self.tree(f, &format!("{indent}  "), *value)?;
                }
            }
        }
        match block.value {
            Some(value) => {
                writeln!(f, "{indent}  value")?;
                self.tree(f, &format!("{indent}  "), value)
            }
            None => Ok(()),
        }
    }
}

fn pattern_text(pattern: &Pattern) -> String {
    match pattern {
        Pattern::Name { name, mutable } => format!("{}{}", if *mutable { "mut " } else { "" }, name.text),
        Pattern::Ignore => "_".to_owned(),
        Pattern::Tuple(patterns, _) => {
            let patterns: Vec<String> = patterns.iter().map(pattern_text).collect();
            format!("({})", patterns.join(", "))
        }
    }
}
