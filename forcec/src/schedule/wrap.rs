//! Line lengths: how long a line may be, and where a longer line is split.
//!
//! In: an expression tree and its room. Out: a tree that fits, after the subtrees that did not fit were moved
//! to lines of their own. A width is the maximum over all targets, so that all targets have the same lines;
//! rustfmt leaves these lines alone. Splits are decided with one nominal length for all names of temporaries:
//! a longer name may move the right side of its line to the next line, but it causes no split. A line is
//! split for the length of its names only if the right side does not fit on a line of its own either.

use crate::math::functions::Function;
use crate::model::bodies::{Signature, Slot};
use crate::names::{Target, spelled};
use crate::schedule::build::Builder;
use crate::schedule::expressions::{quotient, sum};
use crate::schedule::{Expression, Variable};

/// Inputs that are longer than this get a short name.
pub(super) const LONG_INPUT: usize = 27;

/// The nominal length of the name of a temporary.
const NAME: usize = 9;

/// The right side of a statement on a line of its own: 100 columns minus rustfmt's indentation, the
/// semicolon, and the sign and parentheses that a store may add.
const LINE: usize = 84;

/// The arguments of a call, in nominal and in actual width: narrower than rustfmt's `fn_call_width`.
const ARGUMENTS: [usize; 2] = [72, 50];

/// The width of a fused multiply-add without its arguments: that of `f64::mul_add(, , )`.
const FUSED: usize = 18;

/// The space available to a tree.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Room {
    /// The width with names of nominal length.
    width: usize,
    /// The width with the actual names.
    written: usize,
    operations: usize,
}

impl Room {
    /// The room of a tree within another tree.
    pub(super) const INLINE: Room = Room { width: 58, written: LINE, operations: 7 };

    /// The right side of a store: 100 columns minus `    out->dfdx[00][00] = ;`.
    pub(super) const STORE: Room = Room { width: 75, written: LINE, operations: 9 };

    /// The right side of a definition: enough for three products of two names, and their square root.
    pub(super) const DEFINITION: Room = Room { width: 75, written: LINE, operations: 9 };

    /// The same room for statements in a loop.
    fn in_loop(self) -> Room {
        /// The indentation, and the space that further parentheses may need.
        const INDENT: usize = 6;
        Room { width: self.width - INDENT, written: self.written - INDENT, ..self }
    }

    fn holds(self, size: Size) -> bool {
        size.width <= self.width && size.written <= self.written && size.operations <= self.operations
    }

    fn less(self, size: Size) -> Room {
        Room {
            width: self.width.saturating_sub(size.width).max(20),
            written: self.written.saturating_sub(size.written).max(20),
            operations: self.operations.saturating_sub(size.operations).max(1),
        }
    }
}

/// The space that a tree takes.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
struct Size {
    /// The width with names of nominal length.
    width: usize,
    /// The width with the actual names.
    written: usize,
    operations: usize,
}

impl Size {
    /// The size of text that contains no name of a temporary.
    fn new(width: usize, operations: usize) -> Size {
        Size { width, written: width, operations }
    }

    fn name(length: usize) -> Size {
        Size { width: NAME, written: length, operations: 0 }
    }
}

impl std::ops::Add for Size {
    type Output = Size;
    fn add(self, other: Size) -> Size {
        Size {
            width: self.width + other.width,
            written: self.written + other.written,
            operations: self.operations + other.operations,
        }
    }
}

/// The width of an argument entry.
pub(super) fn input_width(signature: &Signature, slot: Slot) -> usize {
    let width = |name: &str| spelled(name, Target::Rust).len();
    match signature.bodies.get(slot.argument as usize) {
        Some(body) => width(&body.name) + body.kind.row().fields[slot.field as usize].name.len() + 6,
        None => {
            let parameter = signature.parameter(slot).expect("a slot names an argument");
            let indices = parameter.ty.extents().len() * if slot.offset < 10 { 3 } else { 4 };
            let given = if signature.prepared { "prepared->" } else { "params->" };
            given.len() + width(&parameter.name) + indices
        }
    }
}

fn measure(signature: &Signature, variables: &[Variable], expression: &Expression) -> Size {
    let inner = expression.children();
    let inside =
        inner.iter().fold(Size::default(), |size, child| size + measure(signature, variables, child));
    let parentheses = |child: &&&Expression| !child.is_atom() && !matches!(child, Expression::Call(..));
    let own = match expression {
        Expression::Literal(value) => Size::new(format!("{:?}", value.to_f64()).len() + 1, 0),
        Expression::Known(_) => Size::new(5, 0),
        Expression::Input(slot) => Size::new(input_width(signature, *slot), 0),
        Expression::Name(name) => Size::name(variables[name.index()].name.len()),
        Expression::Negative(_) | Expression::Not(_) => Size::new(3, 0),
        Expression::Difference(_) => Size::new(5, 1),
        Expression::Sum(terms) => {
            let sums = inner.iter().filter(|child| matches!(child, Expression::Sum(_))).count();
            Size::new(3 * (terms.len() - 1) + usize::from(terms[0].0) + 2 * sums, terms.len() - 1)
        }
        Expression::Quotient(over, under) => {
            let operators = over.len().max(1) + under.len() - 1;
            let one = if over.is_empty() { 3 } else { 0 };
            let around = if under.len() > 1 { 2 } else { 0 };
            let wrapped = inner.iter().filter(parentheses).count();
            Size::new(3 * operators + one + around + 2 * wrapped, operators)
        }
        Expression::Call(function, _) => Size::new(spelling_width(*function), 1),
        Expression::Fused(_) => Size::new(FUSED, 2),
        Expression::Select(_) => Size::new(6, 1),
        Expression::Compare(..) | Expression::And(_) | Expression::Or(_) => Size::new(4, 1),
    };
    inside + own
}

/// The width of a call without its arguments.
fn spelling_width(function: Function) -> usize {
    let row = function.row();
    row.c.len().max(row.rust.len())
}

/// The room of the arguments of a call.
fn call_room(room: Room, call: Size) -> Room {
    let room = room.less(call);
    Room { width: room.width.min(ARGUMENTS[0]), written: room.written.min(ARGUMENTS[1]), ..room }
}

impl Builder<'_> {
    fn size(&self, expression: &Expression) -> Size {
        measure(self.signature, &self.variables, expression)
    }

    /// The tree of a statement; subtrees that do not fit are moved to lines of their own.
    pub(super) fn fit_statement(&mut self, value: Expression, room: Room) -> Expression {
        self.fit(value, if self.single { room.in_loop() } else { room })
    }

    /// Moves a fused multiply-add that rustfmt would break, because its names are long, to a line of its own.
    fn apart(&mut self, value: Expression) -> Expression {
        /// rustfmt's `fn_call_width`, which counts the commas.
        const CALL: usize = 60 - 4;
        let call = match &value {
            Expression::Negative(x) => x,
            value => value,
        };
        let wide = matches!(call, Expression::Fused(_)) && self.size(call).written > FUSED + CALL;
        match value {
            Expression::Negative(x) if wide => Expression::Negative(Box::new(self.part(*x))),
            value if wide => self.part(value),
            value => value,
        }
    }

    /// Applies [`Self::apart`] to every operand.
    fn operands_apart(&mut self, value: Expression) -> Expression {
        let mut all = |list: Vec<Expression>| list.into_iter().map(|x| self.apart(x)).collect::<Vec<_>>();
        match value {
            Expression::Sum(terms) => {
                let (signs, terms): (Vec<bool>, Vec<Expression>) = terms.into_iter().unzip();
                Expression::Sum(signs.into_iter().zip(all(terms)).collect())
            }
            Expression::Quotient(over, under) => Expression::Quotient(all(over), all(under)),
            Expression::Call(function, arguments) => Expression::Call(function, all(arguments)),
            Expression::Select(parts) => Expression::Select(Box::new(parts.map(|x| self.apart(x)))),
            Expression::Compare(comparison, pair) => {
                Expression::Compare(comparison, Box::new(pair.map(|x| self.apart(x))))
            }
            value => value,
        }
    }

    /// Fits a tree into the room; subtrees that do not fit are moved to lines of their own.
    fn fit(&mut self, value: Expression, room: Room) -> Expression {
        match self.operands_apart(value) {
            Expression::Call(function, arguments) => self.fit_call(function, arguments, room),
            // A fused multiply-add is a call as well, and no wider than a call.
            Expression::Fused(parts) => {
                let parts = self.cut_greatest((*parts).into(), call_room(room, Size::new(FUSED, 2)), 1);
                Expression::Fused(Box::new(parts.try_into().expect("as many as there were")))
            }
            value if room.holds(self.size(&value)) => value,
            Expression::Sum(terms) => {
                let join = |terms: Vec<(bool, Expression)>| {
                    let negative = terms.iter().all(|(negative, _)| *negative);
                    let terms = terms.into_iter().map(|(sign, x)| (sign && !negative, x)).collect();
                    (negative, sum(terms))
                };
                sum(self.condense(terms, room, &join))
            }
            Expression::Quotient(over, under) => {
                let join = |factors: Vec<(bool, Expression)>| {
                    (false, quotient(factors.into_iter().map(|(_, x)| x).collect(), vec![]))
                };
                let unsigned =
                    |factors: Vec<Expression>| factors.into_iter().map(|x| (false, x)).collect::<Vec<_>>();
                let rest = Expression::Quotient(vec![], under);
                let over_room = room.less(self.size(&rest));
                let over = self.condense(unsigned(over), over_room, &join);
                let Expression::Quotient(_, under) = rest else { unreachable!("just made") };
                let rest = Expression::Quotient(over.into_iter().map(|(_, x)| x).collect(), vec![]);
                let under_room = room.less(self.size(&rest));
                let under = self.condense(unsigned(under), under_room, &join);
                let Expression::Quotient(over, _) = rest else { unreachable!("just made") };
                let value = Expression::Quotient(over, under.into_iter().map(|(_, x)| x).collect());
                let wide = self.size(&value).written > room.written;
                match value {
                    // Only the names are too long: the numerator moves to a line of its own.
                    Expression::Quotient(over, under) if wide && over.len() > 1 && !under.is_empty() => {
                        let over = self.part(Expression::Quotient(over, vec![]));
                        Expression::Quotient(vec![over], under)
                    }
                    value => value,
                }
            }
            Expression::Negative(x) => Expression::Negative(Box::new(self.fit(*x, room))),
            Expression::Not(x) => Expression::Not(Box::new(self.fit(*x, room))),
            Expression::Difference(pair) => Expression::Difference(self.fit_all(*pair, room)),
            Expression::Compare(comparison, pair) => {
                Expression::Compare(comparison, self.fit_all(*pair, room))
            }
            Expression::And(pair) => Expression::And(self.fit_all(*pair, room)),
            Expression::Or(pair) => Expression::Or(self.fit_all(*pair, room)),
            Expression::Select(parts) => Expression::Select(self.fit_all(*parts, room)),
            atom => atom,
        }
    }

    /// Moves the largest trees to lines of their own until the rest fits.
    fn fit_all<const COUNT: usize>(
        &mut self,
        parts: [Expression; COUNT],
        room: Room,
    ) -> Box<[Expression; COUNT]> {
        let list = self.cut_greatest(parts.into_iter().collect(), room, 1);
        Box::new(list.try_into().expect("as many as there were"))
    }

    fn fit_call(&mut self, function: Function, arguments: Vec<Expression>, room: Room) -> Expression {
        let room = call_room(room, Size::new(spelling_width(function), 1));
        Expression::Call(function, self.cut_greatest(arguments, room, 1))
    }

    /// Moves trees of at least `least` operations to lines of their own, the largest first, until the rest
    /// fits.
    fn cut_greatest(&mut self, mut list: Vec<Expression>, room: Room, least: usize) -> Vec<Expression> {
        let sizes: Vec<Size> = list.iter().map(|x| self.size(x)).collect();
        let mut total = sizes.iter().fold(Size::default(), |sum, size| sum + *size);
        total = total + Size::new(3 * list.len(), 0);
        let mut order: Vec<usize> = (0..list.len()).filter(|&i| sizes[i].operations >= least).collect();
        order.sort_by_key(|&i| std::cmp::Reverse((sizes[i].operations, sizes[i].width)));
        let mut cut = vec![false; list.len()];
        for index in order {
            if room.holds(total) {
                break;
            }
            cut[index] = true;
            total = total + Size::name(self.part_width());
            total.width -= sizes[index].width;
            total.written -= sizes[index].written;
            total.operations -= sizes[index].operations;
        }
        for (slot, cut) in list.iter_mut().zip(cut) {
            if cut {
                let tree = std::mem::replace(slot, Expression::Known(false));
                *slot = self.part(tree);
            }
        }
        list
    }

    /// Shortens a sum with the same total: large terms, then groups of neighbours move to lines of their own.
    fn condense(
        &mut self,
        terms: Vec<(bool, Expression)>,
        room: Room,
        join: &dyn Fn(Vec<(bool, Expression)>) -> (bool, Expression),
    ) -> Vec<(bool, Expression)> {
        const GREAT: usize = 3;
        let joints = Size::new(0, terms.len().saturating_sub(1));
        let (signs, trees): (Vec<bool>, Vec<Expression>) = terms.into_iter().unzip();
        let trees = self.cut_greatest(trees, room.less(joints), GREAT);
        let mut terms: Vec<(bool, Expression)> = signs.into_iter().zip(trees).collect();
        loop {
            let sizes: Vec<Size> = terms.iter().map(|(_, x)| self.size(x)).collect();
            let total = |range: &[Size]| {
                let joints = range.len().saturating_sub(1);
                let sum = range.iter().fold(Size::default(), |sum, size| sum + *size);
                sum + Size::new(3 * joints, joints)
            };
            if room.holds(total(&sizes)) {
                return terms;
            }
            if terms.len() < 3 {
                let (signs, trees): (Vec<bool>, Vec<Expression>) = terms.into_iter().unzip();
                return signs.into_iter().zip(self.cut_greatest(trees, room, 1)).collect();
            }
            // Two neighbours must fit on one line.
            let line = if self.single { Room::DEFINITION.in_loop() } else { Room::DEFINITION };
            let wide = |size: &Size| {
                size.operations > 0
                    && (2 * size.width + 3 > line.width || 2 * size.written + 3 > line.written)
            };
            if sizes.iter().any(wide) {
                for ((_, tree), size) in terms.iter_mut().zip(&sizes) {
                    if wide(size) {
                        let cut = std::mem::replace(tree, Expression::Known(false));
                        *tree = self.part(cut);
                    }
                }
                continue;
            }
            let mut groups: Vec<usize> = vec![0];
            for end in 1..terms.len() {
                let start = groups[groups.len() - 1];
                if end - start > 1 && !line.holds(total(&sizes[start..=end])) {
                    groups.push(end);
                }
            }
            // The remaining terms stay in place.
            let last = if groups.len() > 1 { groups[groups.len() - 1] } else { terms.len() - 1 };
            let mut rest = terms.into_iter();
            let mut joined = Vec::new();
            for (index, start) in groups.iter().enumerate() {
                let end = groups.get(index + 1).copied().unwrap_or(last).min(last);
                let group: Vec<_> = rest.by_ref().take(end.saturating_sub(*start)).collect();
                match group.len() {
                    0 => {}
                    1 => joined.extend(group),
                    _ => {
                        let (negative, tree) = join(group);
                        joined.push((negative, self.part(tree)));
                    }
                }
            }
            joined.extend(rest);
            terms = joined;
        }
    }
}
