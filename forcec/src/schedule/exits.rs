//! Early return from kernels whose outputs are all zero: contacts that do not touch, limits that are not
//! reached.
//!
//! In: items. Out: guards, which are comparisons evaluated before everything else, in order; and items
//! simplified under the assumption that the kernel did not return. A comparison with NaN is false. If the
//! source selects zero outputs in that case, the kernel returns, as the source says; if a zero multiplies a
//! value that may be NaN, the kernel continues and its outputs become NaN.

use crate::math::functions::Function;
use crate::math::number::Comparison;
use crate::schedule::items::{Edge, Item, ItemId, Items};
use crate::schedule::sections;

/// The largest number of comparisons that are considered.
const MOST: usize = 32;

/// Kernels with more items are not considered: they are split into functions that cannot return from each
/// other.
const LONGEST: usize = 4 * sections::LONGEST;

/// An early return must skip at least this many items.
const WORTH: usize = 12;

/// A comparison: the first edge is less than the second, or less than or equal to the second.
#[derive(Clone, Copy)]
pub(super) struct Test {
    pub(super) comparison: Comparison,
    pub(super) pair: [Edge; 2],
}

/// A condition under which every output is zero.
pub(super) struct Guard {
    pub(super) tests: Vec<Test>,
    /// If true, the outputs are zero where no test is true; if false, where all tests are true.
    pub(super) unless: bool,
}

/// A known property of an item: its boolean value, or that a number is zero.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fact {
    Nothing,
    Zero,
    Truth(bool),
}

/// Finds the guards of a kernel and removes from the items the choices that the guards decide.
pub(super) fn guards(items: &mut Items) -> Vec<Guard> {
    let mut found: Vec<Guard> = Vec::new();
    if items.items.len() > LONGEST {
        return found;
    }
    let mut known: Vec<(ItemId, bool)> = Vec::new();
    while let Some(skipping) = skipping(items, &known) {
        let needed = reach(items, known.iter().chain(&skipping).map(|(item, _)| *item));
        let all = reach(items, items.outputs.iter().map(|(_, edge)| edge.item));
        if all.iter().zip(needed).filter(|(all, needed)| **all && !needed).count() < WORTH {
            break;
        }
        let chosen = facts(items, &[known.as_slice(), &skipping].concat(), true);
        let chosen = items.outputs.iter().all(|(_, edge)| chosen[edge.item as usize] == Fact::Zero);
        let unless = chosen && skipping.iter().all(|(_, holds)| !holds);
        let tests =
            skipping.iter().filter_map(|(item, holds)| test(&items.items[*item as usize], *holds || unless));
        let tests = tests.collect();
        found.push(Guard { tests, unless });
        match skipping.as_slice() {
            [(item, holds)] => known.push((*item, !holds)),
            _ => break,
        }
    }
    if !found.is_empty() {
        resolve(items, &known);
        count(items, &found);
    }
    found
}

/// A minimal set of comparisons, each with its assumed value, that makes every output zero.
fn skipping(items: &Items, known: &[(ItemId, bool)]) -> Option<Vec<(ItemId, bool)>> {
    let free = |item: &ItemId| known.iter().all(|(other, _)| other != item);
    let comparisons = (0..items.items.len() as ItemId).filter(|item| {
        items.uses[*item as usize] > 0 && test(&items.items[*item as usize], true).is_some() && free(item)
    });
    let comparisons: Vec<ItemId> = comparisons.take(MOST).collect();
    if comparisons.is_empty() || items.outputs.iter().all(|(_, edge)| items.is_zero(edge.item)) {
        return None;
    }
    let vanishes = |assumed: &[(ItemId, bool)]| {
        let facts = facts(items, &[known, assumed].concat(), false);
        items.outputs.iter().all(|(_, edge)| facts[edge.item as usize] == Fact::Zero)
    };
    let mut chosen: Vec<(ItemId, bool)> = comparisons.iter().map(|item| (*item, false)).collect();
    if vanishes(&chosen) {
        // Later comparisons need the most items: drop them first where possible.
        for index in (0..chosen.len()).rev() {
            let rest: Vec<(ItemId, bool)> = [&chosen[..index], &chosen[index + 1..]].concat();
            if vanishes(&rest) {
                chosen = rest;
            }
        }
        return Some(chosen).filter(|chosen| !chosen.is_empty());
    }
    comparisons.into_iter().map(|item| vec![(item, true)]).find(|assumed| vanishes(assumed))
}

/// The test that is true where the comparison has the value `holds`.
fn test(item: &Item, holds: bool) -> Option<Test> {
    let Item::Compare(comparison, x, y) = *item else { return None };
    let opposite = match comparison {
        Comparison::Less => Comparison::LessEqual,
        Comparison::LessEqual => Comparison::Less,
        Comparison::Equal => return None,
    };
    Some(if holds { Test { comparison, pair: [x, y] } } else { Test { comparison: opposite, pair: [y, x] } })
}

/// The facts that follow from assumed comparisons; with `of_all`, only the facts that are true for NaN
/// operands too.
fn facts(items: &Items, assumed: &[(ItemId, bool)], of_all: bool) -> Vec<Fact> {
    let mut facts = vec![Fact::Nothing; items.items.len()];
    for (index, item) in items.items.iter().enumerate() {
        let fact = |item: &ItemId| facts[*item as usize];
        let zero = |item: &ItemId| fact(item) == Fact::Zero;
        let when = |zero: bool| if zero { Fact::Zero } else { Fact::Nothing };
        // 0 · NaN is NaN.
        let harmless = |other: &ItemId| {
            !of_all || zero(other) || matches!(items.items[*other as usize], Item::Number(_))
        };
        let assumption = assumed.iter().find(|(item, _)| *item as usize == index);
        facts[index] = match item {
            _ if assumption.is_some() => assumption.map_or(Fact::Nothing, |(_, holds)| Fact::Truth(*holds)),
            Item::Number(value) => when(value.is_zero()),
            Item::Known(value) => Fact::Truth(*value),
            Item::Sum(edges) => when(edges.iter().all(|edge| zero(&edge.item))),
            Item::Quotient(over, under) => {
                when(over.iter().any(zero) && over.iter().chain(under).all(harmless))
            }
            Item::Fused(x, y, z) => {
                let both = harmless(&x.item) && harmless(y);
                when((zero(&x.item) || zero(y)) && both && zero(&z.item))
            }
            Item::Call(function, arguments) => {
                let vanishes =
                    matches!(function, Function::Min | Function::Max | Function::Abs | Function::Sqrt);
                let clipped = positive(items, item)
                    .is_some_and(|(comparison, _)| assumed.contains(&(comparison, false)));
                when(clipped && !of_all || vanishes && arguments.iter().all(|edge| zero(&edge.item)))
            }
            Item::Select(c, x, y) => match fact(c) {
                Fact::Truth(true) => fact(&x.item),
                Fact::Truth(false) => fact(&y.item),
                _ => when(zero(&x.item) && zero(&y.item)),
            },
            Item::And(a, b) => match (fact(a), fact(b)) {
                (Fact::Truth(false), _) | (_, Fact::Truth(false)) => Fact::Truth(false),
                (Fact::Truth(true), Fact::Truth(true)) => Fact::Truth(true),
                _ => Fact::Nothing,
            },
            Item::Or(a, b) => match (fact(a), fact(b)) {
                (Fact::Truth(true), _) | (_, Fact::Truth(true)) => Fact::Truth(true),
                (Fact::Truth(false), Fact::Truth(false)) => Fact::Truth(false),
                _ => Fact::Nothing,
            },
            Item::Not(a) => match fact(a) {
                Fact::Truth(value) => Fact::Truth(!value),
                _ => Fact::Nothing,
            },
            Item::Input(_) | Item::Difference(..) | Item::Compare(..) => Fact::Nothing,
        };
    }
    facts
}

/// The comparison that is true where max(x, 0) or min(x, 0) equals x, and the edge of x.
fn positive(items: &Items, item: &Item) -> Option<(ItemId, Edge)> {
    let Item::Call(function, arguments) = item else { return None };
    let [x, y] = arguments.as_slice() else { return None };
    let (value, zero) = if items.is_zero(y.item) { (*x, *y) } else { (*y, *x) };
    if !items.is_zero(zero.item) {
        return None;
    }
    let same = |x: &Edge, y: &Edge| x.item == y.item && (x.negative == y.negative || items.is_zero(x.item));
    let opposite = Edge { negative: !value.negative, ..value };
    let sides = |x: &Edge, y: &Edge| match function {
        // 0 < x, or −x < 0
        Function::Max => same(x, &zero) && same(y, &value) || same(x, &opposite) && same(y, &zero),
        Function::Min => same(x, &value) && same(y, &zero) || same(x, &zero) && same(y, &opposite),
        _ => false,
    };
    let found = items.items.iter().position(
        |item| matches!(item, Item::Compare(Comparison::Less | Comparison::LessEqual, x, y) if sides(x, y)),
    );
    found.map(|comparison| (comparison as ItemId, value))
}

/// Replaces each choice that is decided by the value it selects.
fn resolve(items: &mut Items, known: &[(ItemId, bool)]) {
    let facts = facts(items, known, false);
    // Only booleans are replaced: the guard handles numbers that are zero.
    let truth = |item: ItemId| match facts[item as usize] {
        Fact::Truth(value) => Some(value),
        _ => None,
    };
    let mut replaced_by: Vec<ItemId> = Vec::with_capacity(items.items.len());
    for index in 0..items.items.len() {
        let own = index as ItemId;
        let chosen = match &items.items[index] {
            Item::Select(c, x, y) => truth(*c).map(|holds| if holds { *x } else { *y }),
            Item::And(a, b) | Item::Or(a, b) => match (truth(*a), truth(*b)) {
                (None, Some(_)) => Some(Edge { item: *a, negative: false }),
                (Some(_), None) => Some(Edge { item: *b, negative: false }),
                _ => None,
            },
            item @ Item::Call(..) => {
                positive(items, item).filter(|(test, _)| truth(*test) == Some(true)).map(|(_, value)| value)
            }
            _ => None,
        };
        let chosen = chosen.map(|edge| Edge { item: replaced_by[edge.item as usize], ..edge });
        match chosen {
            Some(Edge { item, negative: false }) if truth(own).is_none() => {
                replaced_by.push(item);
                let source = items.sources[index].take();
                let named = &mut items.sources[item as usize];
                *named = named.take().or(source);
            }
            Some(edge) if truth(own).is_none() => {
                items.items[index] = Item::Sum(vec![edge]);
                replaced_by.push(own);
            }
            _ => {
                if let Some(value) = truth(own)
                    && !known.iter().any(|(item, _)| *item == own)
                {
                    items.items[index] = Item::Known(value);
                }
                items.items[index].operands_mut().into_iter().for_each(|x| *x = replaced_by[*x as usize]);
                replaced_by.push(own);
            }
        }
    }
    for (_, edge) in &mut items.outputs {
        edge.item = replaced_by[edge.item as usize];
    }
}

/// Recounts the reads of each item.
fn count(items: &mut Items, guards: &[Guard]) {
    let tests = guards.iter().flat_map(|guard| &guard.tests).flat_map(|test| test.pair).map(|edge| edge.item);
    let read: Vec<ItemId> = items.outputs.iter().map(|(_, edge)| edge.item).chain(tests).collect();
    let all = reach(items, read.iter().copied());
    items.uses.fill(0);
    let live = items.items.iter().zip(all).filter(|(_, live)| *live);
    let operands: Vec<ItemId> = live.flat_map(|(item, _)| item.operands()).collect();
    for item in operands.into_iter().chain(read) {
        items.uses[item as usize] += 1;
    }
}

/// Marks the given items and all items they depend on.
fn reach(items: &Items, from: impl Iterator<Item = ItemId>) -> Vec<bool> {
    let mut seen = vec![false; items.items.len()];
    let mut pending: Vec<ItemId> = from.collect();
    while let Some(item) = pending.pop() {
        if !std::mem::replace(&mut seen[item as usize], true) {
            pending.extend(items.items[item as usize].operands());
        }
    }
    seen
}

impl Item {
    /// Mutable references to the operands of the item.
    fn operands_mut(&mut self) -> Vec<&mut ItemId> {
        match self {
            Item::Number(_) | Item::Input(_) | Item::Known(_) => vec![],
            Item::Difference(x, y) | Item::And(x, y) | Item::Or(x, y) => vec![x, y],
            Item::Sum(edges) | Item::Call(_, edges) => edges.iter_mut().map(|e| &mut e.item).collect(),
            Item::Quotient(over, under) => over.iter_mut().chain(under).collect(),
            Item::Fused(x, y, z) => vec![&mut x.item, y, &mut z.item],
            Item::Select(c, x, y) => vec![c, &mut x.item, &mut y.item],
            Item::Compare(_, x, y) => vec![&mut x.item, &mut y.item],
            Item::Not(x) => vec![x],
        }
    }
}
