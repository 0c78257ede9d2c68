//! Rows of the results that follow from others: the negatives of other rows, and multiples of one row.
//!
//! In: items. Out: these rows, and the items without their outputs. A loop writes such a row, and compilers make wide
//! instructions of loops. What acts on two bodies acts on both with the same force, so half of their rows are often
//! the negatives of the others; what acts along one direction has a ∂F/∂V of rank one.

use crate::bodies::Signature;
use crate::schedule::lower::{Edge, Item, ItemId, Items};
use crate::schedule::{Output, Part};
use std::ops::Range;

/// Rows that are the negatives of others.
pub(super) struct Negated {
    pub(super) part: Part,
    pub(super) rows: Range<usize>,
    /// The first of the others.
    pub(super) from: usize,
}

/// Rows that are multiples of the same row.
pub(super) struct Scaled {
    pub(super) part: Part,
    /// The row.
    pub(super) columns: Vec<Edge>,
    /// By what each row multiplies it.
    pub(super) rows: Vec<(usize, Edge)>,
}

/// The rows that follow from others.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) negated: Vec<Negated>,
    pub(super) scaled: Vec<Scaled>,
}

impl Rows {
    /// Whether rows of a part are read again, by the loops.
    pub(super) fn side_by_side(&self, part: Part) -> bool {
        self.negated.iter().any(|negated| negated.part == part)
    }

    /// Whether a row needs no stores of its own.
    pub(super) fn cover(&self, output: Output) -> bool {
        let negated = |n: &Negated| n.part == output.part && n.rows.contains(&output.row);
        let scaled = |s: &Scaled| s.part == output.part && s.rows.iter().any(|(row, _)| *row == output.row);
        self.negated.iter().any(negated) || self.scaled.iter().any(scaled)
    }
}

/// Finds the rows that follow from others and takes their outputs away from the items.
pub(super) fn find(items: &mut Items, signature: &Signature) -> Rows {
    let mut rows = Rows::default();
    for part in items.parts.clone().into_iter().filter(|part| !part.is_list()) {
        let (rows_of_part, count) = part.shape(signature);
        let entries = items.outputs.iter().filter(|(output, _)| output.part == part).map(|(_, edge)| *edge);
        let entries: Vec<Edge> = entries.collect();
        let matrix: Vec<&[Edge]> = entries.chunks(count.max(1)).collect();
        rows.negated.extend(negated(items, part, &matrix));
        let free: Vec<usize> =
            (0..rows_of_part).filter(|&row| !rows.cover(Output::new(part, row, 0))).collect();
        rows.scaled.extend(scaled(items, part, &matrix, &free));
    }
    let outputs = std::mem::take(&mut items.outputs);
    let (covered, kept): (Vec<_>, Vec<_>) = outputs.into_iter().partition(|(output, _)| rows.cover(*output));
    items.outputs = kept;
    for scaled in &rows.scaled {
        for edge in scaled.rows.iter().map(|(_, factor)| factor).chain(&scaled.columns) {
            items.uses[edge.item as usize] += 1;
        }
    }
    for (_, edge) in covered {
        release(items, edge.item);
    }
    rows
}

/// One reader less; what nothing reads reads nothing itself.
fn release(items: &mut Items, item: ItemId) {
    let mut pending = vec![item];
    while let Some(item) = pending.pop() {
        items.uses[item as usize] -= 1;
        if items.uses[item as usize] == 0 {
            pending.extend(items.items[item as usize].operands());
        }
    }
}

/// Rows that are the negatives of earlier ones, in runs.
fn negated(items: &Items, part: Part, matrix: &[&[Edge]]) -> Vec<Negated> {
    let mut found: Vec<Negated> = Vec::new();
    let mut known = vec![false; matrix.len()];
    for (row, entries) in matrix.iter().enumerate() {
        let nonzero = entries.iter().filter(|edge| !items.is_zero(edge.item)).count();
        if 2 * nonzero < entries.len() || nonzero < LEAST {
            continue;
        }
        let opposite = |&other: &usize| {
            let mut pairs = entries.iter().zip(matrix[other]);
            !known[other]
                && pairs.all(|(x, y)| x.item == y.item && (x.negative != y.negative || items.is_zero(x.item)))
        };
        let Some(from) = (0..row).find(opposite) else { continue };
        known[row] = true;
        match found.last_mut() {
            Some(run) if run.rows.end == row && run.from + run.rows.len() == from => run.rows.end += 1,
            _ => found.push(Negated { part, rows: row..row + 1, from }),
        }
    }
    found
}

/// Fewer entries or rows are not worth a loop.
const LEAST: usize = 3;

/// An entry that is a product, or the negative of one.
struct Product {
    factors: [ItemId; 2],
    negative: bool,
}

impl Product {
    /// The other factor.
    fn other(&self, factor: ItemId) -> Option<ItemId> {
        match self.factors {
            [x, y] if x == factor => Some(y),
            [x, y] if y == factor => Some(x),
            _ => None,
        }
    }
}

/// Rows whose entries are all products of a factor of the row and a factor of the column.
fn scaled(items: &Items, part: Part, matrix: &[&[Edge]], free: &[usize]) -> Option<Scaled> {
    let mut reads = rustc_hash::FxHashMap::default();
    for edge in matrix.iter().copied().flatten() {
        *reads.entry(edge.item).or_insert(0u32) += 1;
    }
    // The factors of an entry that nothing else reads.
    let factors = |edge: &Edge| match &items.items[edge.item as usize] {
        Item::Quotient(over, under) if under.is_empty() && over.len() == 2 => {
            let plain = over.iter().all(|x| !items.items[*x as usize].is_literal());
            let alone = items.sources[edge.item as usize].is_none()
                && items.uses[edge.item as usize] == reads[&edge.item];
            (plain && alone).then(|| [over[0], over[1]])
        }
        _ => None,
    };
    let product = |edge: &Edge| Some(Product { factors: factors(edge)?, negative: edge.negative });
    let products = |row: usize| matrix[row].iter().map(product).collect::<Option<Vec<Product>>>();
    let rows: Vec<(usize, Vec<Product>)> =
        free.iter().filter_map(|&row| Some((row, products(row)?))).collect();
    let (_, first) = rows.first().filter(|(_, entries)| rows.len() >= LEAST && entries.len() >= LEAST)?;
    let multiples = |factor: ItemId| -> Option<Scaled> {
        let column = |entry: &Product| Some(Edge { item: entry.other(factor)?, negative: entry.negative });
        let columns: Vec<Edge> = first.iter().map(column).collect::<Option<_>>()?;
        let multiple = |entries: &[Product]| -> Option<Edge> {
            let item = entries[0].other(columns[0].item)?;
            let negative = entries[0].negative != columns[0].negative;
            let same = |(entry, column): (&Product, &Edge)| {
                entry.other(item) == Some(column.item) && entry.negative == (column.negative != negative)
            };
            entries.iter().zip(&columns).all(same).then_some(Edge { item, negative })
        };
        let found: Vec<(usize, Edge)> =
            rows.iter().filter_map(|(row, entries)| Some((*row, multiple(entries)?))).collect();
        (found.len() >= LEAST).then_some(Scaled { part, columns, rows: found })
    };
    first[0].factors.into_iter().find_map(multiples)
}
