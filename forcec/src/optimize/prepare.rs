//! Splits a program so that values of the parameters alone are computed once, not at every call.
//!
//! In: a program. Out: two programs; the first computes values from the parameters, the second reads these
//! values. Each value saves an operation, or turns a division into a multiplication. The split does not
//! change rounding: sums are not regrouped, and in the author's order neither are products and quotients.

use crate::math::exact::Exact;
use crate::model::bodies::{Domain, Parameter, ParameterType, Signature, Slot};
use crate::model::outputs::{Array, Part, Piece};
use crate::names::values::{ValueName, entry_name};
use crate::scalar::{Graph, Id, Node, Program};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// A program split in two.
pub struct Split {
    /// Computes the values, from all arguments of the original program.
    pub once: Program,
    /// Computes the outputs. The parameters are those that are still read, then the values.
    pub rest: Program,
    /// The positions of the parameters that `rest` still reads.
    pub kept: Vec<usize>,
}

/// How often a node has to be computed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rate {
    /// Depends on nothing but numbers known at compile time.
    Known,
    /// Depends on parameters.
    Once,
    /// Depends on bodies, or on an extra argument.
    Call,
}

/// Splits a program; `None` if no value can be computed once. `strict` keeps the order of operations.
pub fn split(program: &Program, strict: bool) -> Option<Split> {
    let mut whole = program.clone();
    if !strict {
        part_products(&mut whole);
    }
    let mut splitter = Splitter {
        rates: rates(&whole),
        given: whole.graph.clone(),
        whole: &whole,
        strict,
        values: BTreeSet::new(),
    };
    let needed = splitter.needed();
    if splitter.values.is_empty() {
        return None;
    }
    Some(splitter.split(&needed))
}

fn rate(signature: &Signature, slot: Slot) -> Rate {
    match (signature.bodies.get(slot.argument as usize), signature.extra(slot)) {
        _ if signature.known(slot).is_some() => Rate::Known,
        (None, None) => Rate::Once,
        _ => Rate::Call,
    }
}

fn rates(program: &Program) -> Vec<Rate> {
    let mut rates: Vec<Rate> = Vec::with_capacity(program.graph.len());
    for (_, node) in program.graph.iter() {
        let slots = node.slots().into_iter().map(|slot| rate(&program.signature, slot));
        let operands = node.operands().into_iter().map(|operand| rates[operand.index()]);
        let own = slots.chain(operands).max().unwrap_or(Rate::Known);
        rates.push(own);
    }
    rates
}

/// Collects those factors of each product that depend on parameters alone into a product.
fn part_products(program: &mut Program) {
    let rates = rates(program);
    let mut parted = program.outline();
    let mut at: Vec<Id> = Vec::with_capacity(program.graph.len());
    for (id, node) in program.graph.iter() {
        let new = match node {
            Node::Product(factors) if !program.graph.is_doubled(id) => {
                let moved = |(x, n): &(Id, u32)| (at[x.index()], *n);
                let (slow, fast): (Vec<_>, Vec<_>) =
                    factors.iter().partition(|(x, _)| rates[x.index()] < Rate::Call);
                let slow = parted.graph.product(&slow.into_iter().map(moved).collect::<Vec<_>>());
                let mut all: Vec<(Id, u32)> = fast.into_iter().map(moved).collect();
                all.push((slow, 1));
                parted.graph.product(&all)
            }
            node => parted.graph.copy(node, |x| at[x.index()]),
        };
        carry(&program.graph, id, &mut parted.graph, new);
        at.push(new);
    }
    parted.map_outputs(|id| at[id.index()]);
    *program = parted;
}

/// Copies the name and the doubled mark of a node to its copy.
fn carry(from: &Graph, id: Id, to: &mut Graph, new: Id) {
    if let Some(name) = from.name(id) {
        to.set_name(new, name);
    }
    if from.is_doubled(id) {
        to.set_doubled(new);
    }
}

struct Splitter<'a> {
    whole: &'a Program,
    rates: Vec<Rate>,
    strict: bool,
    /// The graph of the whole program, plus the multiples that become values.
    given: Graph,
    /// The values computed once, as nodes of `given`, in the order of that graph.
    values: BTreeSet<Id>,
}

impl Splitter<'_> {
    /// The value of |coefficient| · node, if worth computing once, and whether the sign is negative.
    fn value(&mut self, coefficient: &Exact, id: Id) -> Option<(Id, bool)> {
        let graph = &self.whole.graph;
        let (inner, rest) = graph.split(id);
        let coefficient = coefficient * &inner;
        let truth = matches!(
            graph.node(rest),
            Node::Known(_) | Node::Compare(..) | Node::And(..) | Node::Or(..) | Node::Not(_)
        );
        // A division on its own stays in place, because a multiplication by its reciprocal would round twice.
        let division = self.strict && matches!(graph.node(rest), Node::Recip(_));
        let costs = !coefficient.is_unit() || graph.cost(rest).total() > 0 && !division;
        let doubled = graph.is_doubled(rest) || graph.is_doubled(id);
        if self.rates[rest.index()] != Rate::Once || truth || doubled || !costs {
            return None;
        }
        Some((self.given.scaled(coefficient.abs(), rest), coefficient.is_negative()))
    }

    /// Whether a multiple of a node is computed once; if so, adds it to `values`.
    fn is_value(&mut self, coefficient: &Exact, id: Id) -> bool {
        let Some((value, _)) = self.value(coefficient, id) else { return false };
        self.values.insert(value);
        true
    }

    /// The nodes that the rest computes; collects values.
    fn needed(&mut self) -> Vec<bool> {
        let whole = self.whole;
        let mut needed = vec![false; whole.graph.len()];
        for output in whole.outputs() {
            needed[output.index()] = true;
        }
        for index in (0..needed.len()).rev() {
            let id = Id(index as u32);
            if !needed[index] || self.is_value(&Exact::ONE, id) {
                needed[index] = false;
                continue;
            }
            match whole.graph.node(id) {
                Node::Sum(_, terms) => {
                    for (coefficient, term) in terms {
                        needed[term.index()] |= !self.is_value(coefficient, *term);
                    }
                }
                node => node.operands().into_iter().for_each(|operand| needed[operand.index()] = true),
            }
        }
        needed
    }

    fn split(mut self, needed: &[bool]) -> Split {
        let whole = self.whole;
        let signature = &whole.signature;
        let order: Vec<Id> = self.values.iter().copied().collect();
        let slots =
            whole.graph.iter().filter(|(id, _)| needed[id.index()]).flat_map(|(_, node)| node.slots());
        let mut kept: Vec<usize> = slots
            .filter(|slot| signature.parameter(*slot).is_some() && signature.extra(*slot).is_none())
            .map(|slot| slot.argument as usize - signature.bodies.len())
            .collect();
        kept.sort_unstable();
        kept.dedup();
        let names = self.names(&order, &kept);
        let mut rest = whole.outline();
        let real = |name: &String| Parameter {
            name: name.clone(),
            ty: ParameterType::Real,
            domain: Domain::Any,
            value: None,
        };
        let parameters = kept.iter().map(|k| signature.parameters[*k].clone());
        rest.signature.parameters = parameters.chain(names.iter().map(real)).collect();
        rest.signature.prepared = true;
        let place = |(place, id): (usize, &Id)| (*id, rest.signature.parameter_slot(kept.len() + place, 0));
        let places: FxHashMap<Id, Slot> = order.iter().enumerate().map(place).collect();
        let shift = rest.signature.parameters.len() as i64 - signature.parameters.len() as i64;
        let moved = |slot: Slot| {
            let argument = slot.argument as usize;
            let argument = match (argument.checked_sub(signature.bodies.len()), signature.extra(slot)) {
                (None, _) => argument,
                (_, Some(_)) => (argument as i64 + shift) as usize,
                (Some(parameter), None) => {
                    let place = kept.binary_search(&parameter).expect("what is read is kept");
                    signature.bodies.len() + place
                }
            };
            Slot { argument: argument as u16, ..slot }
        };
        let mut at: Vec<Option<Id>> = vec![None; whole.graph.len()];
        for (id, node) in whole.graph.iter() {
            let held = |splitter: &mut Self, coefficient: &Exact, id: Id, graph: &mut Graph| {
                let (value, negative) = splitter.value(coefficient, id)?;
                let input = graph.input(*places.get(&value)?);
                Some(if negative { graph.neg(input) } else { input })
            };
            let new = match held(&mut self, &Exact::ONE, id, &mut rest.graph) {
                Some(input) => input,
                None if !needed[id.index()] => continue,
                None => match node {
                    Node::Input(slot) => rest.graph.input(moved(*slot)),
                    Node::Difference(first, second) => rest.graph.difference(moved(*first), moved(*second)),
                    Node::Offset(slot, number) => {
                        let entry = rest.graph.input(moved(*slot));
                        rest.graph.offset(entry, number.clone())
                    }
                    Node::Sum(constant, terms) => {
                        let mut term = |(coefficient, x): &(Exact, Id)| match held(
                            &mut self,
                            coefficient,
                            *x,
                            &mut rest.graph,
                        ) {
                            Some(input) => (Exact::ONE, input),
                            None => (coefficient.clone(), at[x.index()].expect("operands come first")),
                        };
                        let terms = terms.iter().map(&mut term).collect();
                        rest.graph.sum(constant.clone(), terms)
                    }
                    node => rest.graph.copy(node, |x| at[x.index()].expect("operands come first")),
                },
            };
            if needed[id.index()] {
                carry(&whole.graph, id, &mut rest.graph, new);
            }
            at[id.index()] = Some(new);
        }
        rest.map_outputs(|id| at[id.index()].expect("outputs are computed"));
        let mut once = Program { signature: signature.clone(), graph: self.given, arrays: Vec::new() };
        once.signature.pieces = vec![Piece::Values(names)];
        once.arrays = vec![Array { part: Part::List(0), columns: 1, entries: order }];
        Split { once, rest, kept }
    }

    /// A name made of the parameters that a value depends on.
    fn sources(&self, id: Id) -> String {
        let (mut seen, mut pending) = (BTreeSet::new(), vec![id]);
        let mut sources = BTreeSet::new();
        while let Some(id) = pending.pop() {
            if seen.insert(id) {
                let node = self.given.node(id);
                sources.extend(node.slots().into_iter().map(|slot| Slot { field: 0, offset: 0, ..slot }));
                pending.extend(node.operands());
            }
        }
        let parameters = sources.into_iter().filter_map(|slot| self.whole.signature.parameter(slot));
        let names = parameters.map(|parameter| &*parameter.name);
        let name = ["of"].into_iter().chain(names).collect::<Vec<&str>>().join("_");
        if name.len() <= LONGEST { name } else { "value".to_owned() }
    }

    /// Unique names for values, from the source's names or the expressions, other than kept parameters'
    /// names.
    fn names(&self, values: &[Id], kept: &[usize]) -> Vec<String> {
        let mut taken: Vec<String> =
            kept.iter().map(|k| self.whole.signature.parameters[*k].name.clone()).collect();
        let mut names = Vec::new();
        for id in values {
            let stem = derived_name(&self.given, &self.whole.signature, *id, 0).map(|name| name.text);
            let stem = stem.filter(|name| name.len() <= LONGEST);
            let stem = stem.unwrap_or_else(|| self.sources(*id));
            let numbers = (2..).map(|number| format!("{stem}_{number}"));
            let mut free = std::iter::once(stem.clone()).chain(numbers).filter(|name| !taken.contains(name));
            let name = free.next().expect("numbers do not end");
            taken.push(name.clone());
            names.push(name);
        }
        names
    }
}

/// The longest name that is used.
const LONGEST: usize = 27;

/// The depth of an expression from which a name is derived.
const DEEPEST: usize = 4;

/// A name derived from the expression of a value.
fn derived_name(graph: &Graph, signature: &Signature, id: Id, depth: usize) -> Option<ValueName> {
    let below = |x: &Id| derived_name(graph, signature, *x, depth + 1);
    if let Some(name) = graph.name(id) {
        return Some(ValueName::source(name));
    }
    if depth == DEEPEST {
        return None;
    }
    Some(match graph.node(id) {
        Node::Input(slot) => ValueName::plain(entry_name(signature, *slot)),
        Node::Difference(first, second) => {
            let [first, second] = [first, second].map(|slot| ValueName::plain(entry_name(signature, *slot)));
            first.join("_minus_", &second)
        }
        Node::Recip(x) => below(x)?.power(-1),
        Node::Product(factors) => {
            let powers: Option<Vec<ValueName>> =
                factors.iter().map(|(x, n)| Some(below(x)?.power(i64::from(*n)))).collect();
            powers?.into_iter().reduce(|product, power| product.join("_", &power))?
        }
        Node::Sum(constant, terms) => match &**terms {
            [(two, x)] if constant.is_zero() && *two == Exact::from(2) => below(x)?.after("two_"),
            [(half, x)] if constant.is_zero() && *half == Exact::ratio(1, 2) => below(x)?.after("half_"),
            [(c, x), (d, y)] if constant.is_zero() && c.is_one() && d.is_unit() => {
                let sign = if d.is_negative() { "_minus_" } else { "_plus_" };
                below(x)?.join(sign, &below(y)?)
            }
            _ => return None,
        },
        Node::Call(function, arguments) => match &**arguments {
            [x] => below(x)?.call(*function)?,
            _ => return None,
        },
        _ => return None,
    })
}
