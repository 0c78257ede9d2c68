//! From items to statements: which values get a line of their own, in which order, and where long lines are
//! split.
//!
//! In: items, operands before users. Out: a schedule. The items are visited depth first from the outputs in
//! order, so that a value is computed right before its first use and stored at once in every output equal to
//! it. Loops write the rows that follow from other rows. The rows that these loops read are stored together
//! once all their entries are computed, so that compilers use wide stores for the rows and wide loads in the
//! loops. The zeros among these entries are stored right before them.

use crate::math::functions::Function;
use crate::model::bodies::{ParameterType, Signature};
use crate::names::values::ValueName;
use crate::scalar::eval::Value;
use crate::scalar::valuation::Valuation;
use crate::schedule::eval;
use crate::schedule::exits::{Guard, Test};
use crate::schedule::expressions::{negate, quotient, sum, turned};
use crate::schedule::items::{Edge, Item, ItemId, Items};
use crate::schedule::meanings::{Inputs, Meanings, STATES};
use crate::schedule::names::{self, Taken};
use crate::schedule::rows::{self, Negated, Rows, Scaled};
use crate::schedule::turns;
use crate::schedule::wrap as cut;
use crate::schedule::wrap::Room;
use crate::schedule::{Expression, Name, Output, Part, Schedule, Statement, Style, Variable};
use rustc_hash::{FxHashMap, FxHashSet};
use std::ops::Range;

/// Builds the statements that compute the outputs of the items.
pub(super) fn build(
    signature: &Signature,
    mut items: Items,
    guards: &[Guard],
    style: Style,
    meanings: &Meanings,
) -> Schedule {
    let mut distinct: Vec<ItemId> =
        items.outputs.iter().map(|(_, edge)| edge.item).filter(|item| !items.is_zero(*item)).collect();
    let nonzero = distinct.len();
    distinct.sort_unstable();
    distinct.dedup();
    let single = style.single;
    let rows =
        if single || style.adds { Rows::default() } else { rows::find(&mut items, signature, !style.strict) };
    let own_line = own_line(signature, &items, &rows, single);
    let flipped = flipped(&items, &own_line, &rows);
    let mut taken = Taken::by(signature);
    let assigned = names::assign(signature, &items, &own_line, &flipped, &mut taken);
    let mut stores: FxHashMap<ItemId, Vec<(Output, Edge)>> = FxHashMap::default();
    for &(output, edge) in items.outputs.iter().filter(|(output, _)| !rows.side_by_side(output.part)) {
        if own_line[edge.item as usize] {
            stores.entry(edge.item).or_default().push((output, edge));
        }
    }
    let count = items.items.len();
    let mut builder = Builder {
        signature,
        items: &items,
        rows: &rows,
        single,
        adds: style.adds,
        own_line,
        flipped,
        assigned,
        meanings,
        inputs: if meanings.is_empty() { Inputs::default() } else { meanings.inputs(signature) },
        stores,
        values: vec![None; count],
        variables: Vec::new(),
        value_names: Vec::new(),
        values_at: Default::default(),
        valuations: Vec::new(),
        statements: Vec::new(),
        taken,
        stored: FxHashSet::default(),
        part: Part::Force,
        family: Family::Output(Output::new(Part::Force, 0, 0)),
    };
    guards.iter().for_each(|guard| builder.leave_where(guard));
    builder.outputs();
    let Builder { variables, statements, .. } = builder;
    let statements = without_short_sections(statements);
    Schedule {
        signature: signature.clone(),
        parts: items.parts,
        variables,
        statements,
        nonzero,
        distinct: distinct.len(),
        adds: style.adds,
        doubled: false,
    }
}

/// The statements without the headings of bodies in a part that is short enough to be read as a whole.
fn without_short_sections(statements: Vec<Statement>) -> Vec<Statement> {
    const LONG: usize = 60;
    let starts = |_: &Statement, next: &Statement| !matches!(next, Statement::Heading(_, None));
    let parts: Vec<usize> = statements.chunk_by(starts).map(<[Statement]>::len).collect();
    let mut statements = statements.into_iter();
    let mut kept = Vec::new();
    for length in parts {
        let whole = statements.by_ref().take(length);
        kept.extend(whole.filter(|s| length >= LONG || !matches!(s, Statement::Heading(_, Some(_)))));
    }
    kept
}

/// Which items get a line of their own: items that are used twice or named, and items that do not fit into a
/// line.
fn own_line(signature: &Signature, items: &Items, rows: &Rows, single: bool) -> Vec<bool> {
    let mut own: Vec<bool> = items.items.iter().zip(&items.uses).map(|(_, uses)| *uses > 1).collect();
    for (own, source) in own.iter_mut().zip(&items.sources) {
        *own |= source.is_some();
    }
    for (index, item) in items.items.iter().enumerate() {
        match item {
            Item::Select(..) | Item::Difference(..) => own[index] = true,
            Item::Input(slot) => {
                let long = cut::input_width(signature, *slot) > cut::LONG_INPUT;
                own[index] |= long || single || signature.known(*slot).is_some();
                // An argument that is a single number has a name already.
                let lone = signature.parameter(*slot).is_some_and(|p| p.ty == ParameterType::Real);
                own[index] &= !(lone && signature.extra(*slot).is_some() && signature.known(*slot).is_none());
            }
            // No nesting of logical operators: the lines then read the same in every language and pass every
            // linter.
            Item::And(a, b) | Item::Or(a, b) => [*a, *b].into_iter().for_each(|x| own[x as usize] = true),
            Item::Not(a) => own[*a as usize] = true,
            _ => {}
        }
    }
    // A selection whose only use is a store is a statement already.
    for (_, edge) in &items.outputs {
        let item = edge.item as usize;
        if matches!(items.items[item], Item::Select(..)) && !edge.negative {
            own[item] = items.uses[item] > 1 || items.sources[item].is_some();
        }
    }
    // A loop reads only names.
    for scaled in &rows.scaled {
        let edges = scaled.rows.iter().map(|(_, factor)| factor).chain(&scaled.columns);
        edges.for_each(|edge| own[edge.item as usize] = true);
    }
    for (own, item) in own.iter_mut().zip(&items.items) {
        *own &= !item.is_literal();
    }
    own
}

/// Which named items are defined as their negatives: items that are stored or read negated more often than
/// not, if the change of sign costs no operation.
fn flipped(items: &Items, own_line: &[bool], rows: &Rows) -> Vec<bool> {
    let mut free = vec![false; items.items.len()];
    let mut votes = vec![0i32; items.items.len()];
    let mut vote = |edge: &Edge| votes[edge.item as usize] += if edge.negative { -1 } else { 1 };
    items.outputs.iter().for_each(|(_, edge)| vote(edge));
    for scaled in &rows.scaled {
        scaled.rows.iter().map(|(_, factor)| factor).chain(&scaled.columns).for_each(&mut vote);
    }
    for (index, item) in items.items.iter().enumerate().filter(|(index, _)| items.uses[*index] > 0) {
        match item {
            Item::Call(_, edges) => edges.iter().for_each(&mut vote),
            Item::Select(_, x, y) | Item::Compare(_, x, y) => [x, y].into_iter().for_each(&mut vote),
            Item::Fused(x, y, z) => {
                [x, &Edge { item: *y, negative: false }, z].into_iter().for_each(&mut vote)
            }
            Item::Quotient(over, under) => {
                let factors = over.iter().chain(under);
                factors.for_each(|&item| vote(&Edge { item, negative: false }));
                free[index] = over.iter().any(|&x| !own_line[x as usize] && free[x as usize]);
            }
            Item::Sum(edges) => {
                free[index] = edges.iter().any(|e| e.negative) && edges.iter().any(|e| !e.negative)
            }
            Item::Difference(..) => free[index] = true,
            _ => {}
        }
    }
    let named = items.sources.iter().map(Option::is_some);
    let turns = own_line.iter().zip(named).zip(free.iter().zip(&votes));
    let flip =
        |((own, named), (free, votes)): ((&bool, bool), (&bool, &i32))| *own && !named && *free && *votes < 0;
    turns.map(flip).collect()
}

/// The item or output whose name is the stem of the numbered names in a subtree.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Family {
    Item(ItemId),
    Output(Output),
}

pub(super) struct Builder<'a> {
    pub(super) signature: &'a Signature,
    items: &'a Items,
    rows: &'a Rows,
    /// Whether the statements are inside a loop over instances.
    pub(super) single: bool,
    adds: bool,
    own_line: Vec<bool>,
    /// Whether the name of an item denotes its negative.
    flipped: Vec<bool>,
    /// The names of items that are known before their statements.
    assigned: Vec<Option<String>>,
    meanings: &'a Meanings,
    /// The entries of arguments at each state of the meanings.
    inputs: Inputs,
    /// The outputs equal to an item or its negative; they are stored when the item is computed.
    stores: FxHashMap<ItemId, Vec<(Output, Edge)>>,
    /// The outputs already stored.
    stored: FxHashSet<Output>,
    /// The current part.
    part: Part,
    /// The expression for an item at its uses: a name, or the tree itself before its only use.
    values: Vec<Option<Expression>>,
    pub(super) variables: Vec<Variable>,
    /// The descriptive name of every variable, if it has one.
    value_names: Vec<Option<ValueName>>,
    /// The value of every variable at each state of the meanings.
    values_at: [Vec<Option<Value<f64>>>; STATES],
    /// The valuation of every variable: how the variable vanishes or grows as positions coincide.
    valuations: Vec<Valuation>,
    statements: Vec<Statement>,
    taken: Taken,
    family: Family,
}

struct Frame {
    item: ItemId,
    operands: std::vec::IntoIter<ItemId>,
    family: Family,
}

impl Builder<'_> {
    /// Emits the early return of a guard, after the values that the guard reads.
    fn leave_where(&mut self, guard: &Guard) {
        let mut holds: Option<Expression> = None;
        let join = |pair| if guard.unless { Expression::Or(pair) } else { Expression::And(pair) };
        for Test { comparison, pair } in &guard.tests {
            pair.iter().for_each(|edge| self.visit(edge.item, self.family));
            let [x, y] = pair.map(|edge| self.signed(edge));
            let test = Expression::Compare(*comparison, Box::new(turned(x, y)));
            holds = Some(match holds {
                // No nesting of logical operators.
                Some(others @ (Expression::And(_) | Expression::Or(_))) => {
                    join(Box::new([self.part(others), test]))
                }
                Some(other) => join(Box::new([other, test])),
                None => test,
            });
        }
        if let Some(acts) = holds.take_if(|_| guard.unless) {
            // Negate a named value: inverting the comparison gives a different result for NaN.
            let acts = self.fit_statement(acts, Room::DEFINITION);
            let name = self.taken.claim("acts");
            let name = Expression::Name(self.define(Some(name), acts));
            self.statements.push(Statement::Leave(Expression::Not(Box::new(name))));
        }
        if let Some(holds) = holds {
            let holds = self.fit_statement(holds, Room::STORE);
            self.statements.push(Statement::Leave(holds));
        }
    }

    fn outputs(&mut self) {
        let rows = self.rows;
        // Lists and loop-written parts come first: loops need few values, and the processor computes the next
        // part meanwhile.
        let looped = |part: &Part| rows.scaled.iter().any(|scaled| scaled.part == *part);
        let mut parts = self.items.parts.clone();
        parts.sort_by_key(|part| !part.is_list() && !looped(part));
        for part in parts {
            self.part = part;
            self.statements.push(Statement::Heading(part, None));
            let mut rows_of = part.body_of_row(self.signature, 0);
            let outputs: Vec<(Output, Edge)> =
                self.items.outputs.iter().filter(|(output, _)| output.part == part).copied().collect();
            let together =
                |x: &(Output, Edge), y: &(Output, Edge)| rows.side_by_side(part) && x.0.row == y.0.row;
            // The zeros among entries that are stored together come right before them.
            let empty = |row: &&[(Output, Edge)]| row.iter().all(|(_, edge)| self.items.is_zero(edge.item));
            let empty: Vec<(Output, Edge)> =
                outputs.chunk_by(together).filter(empty).flatten().copied().collect();
            self.zeros(part, &empty);
            rows.scaled.iter().filter(|scaled| scaled.part == part).for_each(|scaled| self.scaled(scaled));
            let at_once = |negated: &&Negated| negated.part == part && rows.looped(negated);
            rows.negated.iter().filter(at_once).for_each(|negated| self.negated(negated));
            for row in outputs.chunk_by(together) {
                let filled = row.iter().filter(|(_, edge)| !self.items.is_zero(edge.item));
                let filled: Vec<(Output, Edge)> = filled.copied().collect();
                let body = row.first().and_then(|(output, _)| part.body_of_row(self.signature, output.row));
                if !filled.is_empty() && body != rows_of {
                    rows_of = body;
                    self.statements.push(Statement::Heading(part, body));
                }
                for (output, edge) in &filled {
                    self.visit(edge.item, Family::Output(*output));
                    self.store_all(edge.item);
                }
                if rows.side_by_side(part) && !filled.is_empty() {
                    self.zeros(part, row);
                }
                filled.into_iter().for_each(|(output, edge)| self.store(output, edge));
            }
        }
        rows.negated.iter().filter(|negated| !rows.looped(negated)).for_each(|negated| self.negated(negated));
    }

    /// Emits the loop for rows that are the negatives of other rows.
    fn negated(&mut self, negated: &Negated) {
        let Negated { part, ref rows, of, from } = *negated;
        self.statements.push(Statement::Negated { part, rows: rows.clone(), of, from });
    }

    /// Emits the loops for rows that are multiples of one row.
    fn scaled(&mut self, scaled: &Scaled) {
        let part = scaled.part;
        let place = |row: usize, column: usize| Family::Output(Output::new(part, row, column));
        let first = scaled.rows[0].0;
        for (column, edge) in scaled.columns.iter().enumerate() {
            self.visit(edge.item, place(first, column));
        }
        for (row, factor) in &scaled.rows {
            self.visit(factor.item, place(*row, 0));
        }
        let columns = scaled.columns.iter().map(|edge| self.signed(*edge)).collect();
        let name = Name(self.variables.len() as u32);
        let text = self.taken.claim(&format!("{}_columns", part.stem(self.signature)));
        self.variables.push(Variable { name: text, truth: false });
        self.value_names.push(None);
        self.values_at.iter_mut().for_each(|values| values.push(None));
        self.valuations.push(Valuation::ZERO);
        self.statements.push(Statement::Columns(name, columns));
        for (row, factor) in &scaled.rows {
            let factor = self.signed(*factor);
            self.statements.push(Statement::Scaled { part, row: *row, factor, columns: name });
        }
    }

    /// Emits the zeros among some outputs of a part.
    fn zeros(&mut self, part: Part, outputs: &[(Output, Edge)]) {
        let mut rows: Vec<(usize, Vec<Range<usize>>)> = Vec::new();
        for (Output { row, column, .. }, _) in
            outputs.iter().filter(|(_, edge)| self.items.is_zero(edge.item))
        {
            match rows.last_mut() {
                Some((last, runs)) if last == row => match runs.last_mut() {
                    Some(run) if run.end == *column => run.end += 1,
                    _ => runs.push(*column..column + 1),
                },
                _ => rows.push((*row, std::iter::once(*column..column + 1).collect())),
            }
        }
        if !rows.is_empty() && !self.adds {
            let first = self.rows.side_by_side(part);
            self.statements.push(Statement::Zero { part, rows, first });
        }
    }

    /// Stores a value in all equal outputs of the current part, except for parts that are stored row by row.
    fn store_all(&mut self, item: ItemId) {
        let Some(outputs) = self.stores.get_mut(&item) else { return };
        let now: Vec<(Output, Edge)> =
            outputs.extract_if(.., |(output, _)| output.part == self.part).collect();
        now.into_iter().for_each(|(output, edge)| self.store(output, edge));
    }

    fn store(&mut self, output: Output, edge: Edge) {
        if !self.stored.insert(output) {
            return;
        }
        let value = self.signed(edge);
        self.family = Family::Output(output);
        let (negative, value) = match value {
            Expression::Negative(value) if self.adds => (true, *value),
            value => (false, value),
        };
        let value = self.fit_statement(value, Room::STORE);
        self.statements.push(if self.adds {
            Statement::Add(output, negative, value)
        } else {
            Statement::Store(output, value)
        });
    }

    /// Visits the operands of an item, then the item.
    fn visit(&mut self, item: ItemId, family: Family) {
        let mut stack = Vec::new();
        self.enter(&mut stack, item, family);
        while let Some(frame) = stack.last_mut() {
            let (item, family) = (frame.item, frame.family);
            match frame.operands.next() {
                Some(operand) => self.enter(&mut stack, operand, family),
                None => {
                    stack.pop();
                    self.leave(item, family);
                }
            }
        }
    }

    fn enter(&mut self, stack: &mut Vec<Frame>, item: ItemId, family: Family) {
        if self.values[item as usize].is_none() {
            let family = if self.assigned[item as usize].is_some() { Family::Item(item) } else { family };
            stack.push(Frame {
                item,
                operands: self.items.items[item as usize].operands().into_iter(),
                family,
            });
        }
    }

    fn leave(&mut self, item: ItemId, family: Family) {
        if self.values[item as usize].is_some() {
            return;
        }
        self.family = family;
        let value = match &self.items.items[item as usize] {
            Item::Quotient(over, under) if self.items.written.contains(&item) => self.as_written(over, under),
            item => self.expression(item),
        };
        if !self.own_line[item as usize] {
            let value = self.fit_statement(value, Room::INLINE);
            self.values[item as usize] = Some(value);
            return;
        }
        let value = if self.flipped[item as usize] { negate(value) } else { value };
        let value = self.fit_statement(value, Room::DEFINITION);
        let name = self.define(self.assigned[item as usize].clone(), value);
        self.values[item as usize] = Some(Expression::Name(name));
        self.store_all(item);
    }

    /// Defines a variable. Without a name, it gets one by its meaning or its operands, or else a number.
    fn define(&mut self, name: Option<String>, value: Expression) -> Name {
        let truth = value.is_truth();
        let id = Name(self.variables.len() as u32);
        let meaning = self.meaning(&value);
        let derived =
            || names::derived_name(self.signature, &|name| self.value_names[name.index()].as_ref(), &value);
        let described = match &name {
            Some(name) => Some(ValueName::source(name)),
            None => meaning.or_else(derived),
        };
        let name = name.unwrap_or_else(|| match &described {
            Some(described) => self.taken.claim(&described.text),
            None => self.numbered(),
        });
        self.valuations.push(self.valuation(&value));
        self.variables.push(Variable { name, truth });
        self.value_names.push(described);
        self.statements.push(Statement::Let(id, value));
        id
    }

    /// The name of an expression's value, if the source speaks of it; records the value for later expressions.
    fn meaning(&mut self, value: &Expression) -> Option<ValueName> {
        if self.meanings.is_empty() {
            return None;
        }
        let values: [Option<Value<f64>>; STATES] = std::array::from_fn(|state| {
            let input = |slot| self.inputs[&slot][state];
            eval::evaluate(value, &self.values_at[state], &input)
        });
        for (all, value) in self.values_at.iter_mut().zip(&values) {
            all.push(value.clone());
        }
        let values: Vec<Value<f64>> = values.into_iter().collect::<Option<_>>()?;
        self.meanings.find(&values.try_into().ok()?)
    }

    /// The valuation of a tree: how the tree vanishes or grows as positions coincide.
    fn valuation(&self, value: &Expression) -> Valuation {
        value.valuation(&|atom| match atom {
            Expression::Name(name) => self.valuations[name.index()],
            Expression::Input(slot) => Valuation::of_slot(self.signature, *slot),
            _ => Valuation::ZERO,
        })
    }

    /// Reorders the factors of a product so that partial products stay in the range of floats.
    fn in_turns(&self, value: Expression) -> Expression {
        match value {
            Expression::Quotient(over, under) => turns::in_turns(over, under, &|x| self.valuation(x)),
            Expression::Negative(x) => Expression::Negative(Box::new(self.in_turns(*x))),
            value => value,
        }
    }

    /// Reorders the factors of a fused multiply-add in the same way.
    fn fused_in_turns(&self, x: Expression, y: Expression) -> [Expression; 2] {
        match x {
            Expression::Negative(x) => {
                let [x, y] = self.fused_in_turns(*x, y);
                [Expression::Negative(Box::new(x)), y]
            }
            Expression::Quotient(mut factors, under) if under.is_empty() => {
                factors.push(y);
                let ordered = self.in_turns(Expression::Quotient(factors, under));
                let Expression::Quotient(mut factors, under) = ordered else {
                    unreachable!("it has factors")
                };
                let y = factors.pop().expect("it has factors");
                [Expression::Quotient(factors, under), y]
            }
            x => [x, y],
        }
    }

    /// The next numbered name of the current family.
    fn numbered(&mut self) -> String {
        let stem = self.stem();
        self.taken.part(&stem)
    }

    /// The approximate length of the numbered names of the current family.
    pub(super) fn part_width(&self) -> usize {
        names::part_width(&self.stem())
    }

    fn stem(&self) -> String {
        match self.family {
            Family::Item(item) => self.assigned[item as usize].clone().expect("a family has a name"),
            Family::Output(output) => names::output_name(self.signature, output),
        }
    }

    /// The expression for an item; a tree is moved out to its only user.
    fn value(&mut self, item: ItemId) -> Expression {
        match &mut self.values[item as usize] {
            Some(value) if value.is_atom() => value.clone(),
            value => value.take().expect("operands come before users"),
        }
    }

    fn signed(&mut self, edge: Edge) -> Expression {
        let value = self.value(edge.item);
        if edge.negative ^ self.flipped[edge.item as usize] { negate(value) } else { value }
    }

    fn plain(&mut self, item: ItemId) -> Expression {
        self.signed(Edge { item, negative: false })
    }

    fn pair(&mut self, x: ItemId, y: ItemId) -> Box<[Expression; 2]> {
        Box::new([self.value(x), self.value(y)])
    }

    fn expression(&mut self, item: &Item) -> Expression {
        match item {
            Item::Number(value) => Expression::Literal(value.clone()),
            Item::Input(slot) => Expression::Input(*slot),
            Item::Known(value) => Expression::Known(*value),
            Item::Difference(first, second) => Expression::Difference(self.pair(*first, *second)),
            Item::Sum(edges) => {
                let term = |edge: &Edge| (edge.negative, self.plain(edge.item));
                sum(edges.iter().map(term).collect())
            }
            Item::Quotient(over, under) => {
                let over = over.iter().map(|item| self.plain(*item)).collect();
                let under = under.iter().map(|item| self.plain(*item)).collect();
                self.in_turns(quotient(over, under))
            }
            Item::Call(function, arguments) => {
                let arguments = arguments.iter().map(|edge| self.signed(*edge)).collect();
                let arguments = self.plain_arguments(*function, arguments);
                Expression::Call(*function, arguments)
            }
            Item::Fused(x, y, z) => {
                let (x, y, z) = (self.signed(*x), self.plain(*y), self.signed(*z));
                let [x, y] = self.fused_in_turns(x, y);
                Expression::Fused(Box::new([x, y, z]))
            }
            Item::Select(condition, x, y) => {
                Expression::Select(Box::new([self.value(*condition), self.signed(*x), self.signed(*y)]))
            }
            Item::Compare(comparison, x, y) => {
                let (x, y) = (self.signed(*x), self.signed(*y));
                Expression::Compare(*comparison, Box::new(turned(x, y)))
            }
            Item::And(a, b) => Expression::And(self.pair(*a, *b)),
            Item::Or(a, b) => Expression::Or(self.pair(*a, *b)),
            Item::Not(a) => Expression::Not(Box::new(self.value(*a))),
        }
    }

    /// A product or quotient into which no operand is merged. Only signs move outward, which causes no
    /// rounding.
    fn as_written(&mut self, over: &[ItemId], under: &[ItemId]) -> Expression {
        let mut negative = false;
        let mut unsigned = |value: Expression| match value {
            Expression::Negative(x) => {
                negative = !negative;
                *x
            }
            value => value,
        };
        let over = over.iter().map(|item| unsigned(self.plain(*item))).collect();
        let under = under.iter().map(|item| unsigned(self.plain(*item))).collect();
        let value = Expression::Quotient(over, under);
        if negative { negate(value) } else { value }
    }

    /// Splits a nested min or max into two statements: linters report nested ones as a clamp.
    fn plain_arguments(&mut self, function: Function, arguments: Vec<Expression>) -> Vec<Expression> {
        let chooses = |function: Function| matches!(function, Function::Min | Function::Max);
        let mut plain = Vec::new();
        for argument in arguments {
            plain.push(match &argument {
                Expression::Call(inner, _) if chooses(function) && chooses(*inner) => self.part(argument),
                _ => argument,
            });
        }
        plain
    }

    /// Moves a tree to a line of its own and returns its name.
    pub(super) fn part(&mut self, value: Expression) -> Expression {
        Expression::Name(self.define(None, value))
    }
}

impl Items {
    /// Whether an item is the number 0.
    pub(super) fn is_zero(&self, item: ItemId) -> bool {
        matches!(&self.items[item as usize], Item::Number(number) if number.is_zero())
    }
}
