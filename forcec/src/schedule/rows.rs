//! Rows of the results that follow from other rows: negatives of other rows, and multiples of one row.
//!
//! In: items. Out: these rows, and the items without the outputs of these rows. A loop writes each such row,
//! and compilers vectorise loops. A force between two bodies acts on both with opposite signs, so half of the
//! rows are often the negatives of the other half; the ∂F/∂V of a force along one direction has rank one.

use crate::model::bodies::Signature;
use crate::schedule::items::{Edge, Item, ItemId, Items};
use crate::schedule::{Output, Part};
use std::ops::Range;

/// Rows that are the negatives of other rows.
pub(super) struct Negated {
    pub(super) part: Part,
    pub(super) rows: Range<usize>,
    /// The result whose rows are negated.
    pub(super) of: Part,
    /// The first of the rows that are negated.
    pub(super) from: usize,
}

/// Rows that are multiples of the same row.
pub(super) struct Scaled {
    pub(super) part: Part,
    /// The entries of the common row.
    pub(super) columns: Vec<Edge>,
    /// The rows, each with its factor.
    pub(super) rows: Vec<(usize, Edge)>,
}

/// The rows that follow from other rows.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) negated: Vec<Negated>,
    pub(super) scaled: Vec<Scaled>,
}

impl Rows {
    /// Whether the loops read rows of a part.
    pub(super) fn side_by_side(&self, part: Part) -> bool {
        self.negated.iter().any(|negated| negated.of == part)
    }

    /// Whether loops write all rows that `negated` reads, so that these rows can be negated at once.
    pub(super) fn looped(&self, negated: &Negated) -> bool {
        let written = |row: usize| {
            let scaled = |s: &Scaled| s.part == negated.of && s.rows.iter().any(|(own, _)| *own == row);
            self.scaled.iter().any(scaled)
        };
        (negated.from..negated.from + negated.rows.len()).all(written)
    }

    /// Whether a loop writes the row of an output.
    pub(super) fn cover(&self, output: Output) -> bool {
        let negated = |n: &Negated| n.part == output.part && n.rows.contains(&output.row);
        let scaled = |s: &Scaled| s.part == output.part && s.rows.iter().any(|(row, _)| *row == output.row);
        self.negated.iter().any(negated) || self.scaled.iter().any(scaled)
    }
}

/// Finds the rows that follow from other rows and removes their outputs from the items.
///
/// With `regroup`, products may be regrouped to find such rows; strict mode forbids it.
pub(super) fn find(items: &mut Items, signature: &Signature, regroup: bool) -> Rows {
    let mut rows = Rows::default();
    // Blocks of earlier bodies: rows of later bodies may be the negatives of their rows.
    let mut blocks: Vec<(Part, Vec<Vec<Edge>>)> = Vec::new();
    for part in items.parts.clone().into_iter().filter(|part| !part.is_list()) {
        let (rows_of_part, count) = part.shape(signature);
        let entries = items.outputs.iter().filter(|(output, _)| output.part == part).map(|(_, edge)| *edge);
        let entries: Vec<Edge> = entries.collect();
        let matrix: Vec<&[Edge]> = entries.chunks(count.max(1)).collect();
        let found = negated(items, part, &matrix, &blocks, &rows);
        rows.negated.extend(found);
        if matches!(part, Part::Block(_)) {
            blocks.push((part, matrix.iter().map(|row| row.to_vec()).collect()));
        }
        let free: Vec<usize> =
            (0..rows_of_part).filter(|&row| !rows.cover(Output::new(part, row, 0))).collect();
        rows.scaled.extend(scaled(items, part, &matrix, &free, regroup));
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

/// Removes one reader of an item; an item without readers releases its operands.
fn release(items: &mut Items, item: ItemId) {
    let mut pending = vec![item];
    while let Some(item) = pending.pop() {
        items.uses[item as usize] -= 1;
        if items.uses[item as usize] == 0 {
            pending.extend(items.items[item as usize].operands());
        }
    }
}

/// A row with at least this many entries is long.
const LONG: usize = 8;

/// Rows that are the negatives of earlier rows, of the same result or of other blocks, in runs; long rows
/// with few zeros are listed one by one.
fn negated(
    items: &Items,
    part: Part,
    matrix: &[&[Edge]],
    blocks: &[(Part, Vec<Vec<Edge>>)],
    earlier: &Rows,
) -> Vec<Negated> {
    let mut found: Vec<Negated> = Vec::new();
    let mut known = vec![false; matrix.len()];
    for (row, entries) in matrix.iter().enumerate() {
        let nonzero = entries.iter().filter(|edge| !items.is_zero(edge.item)).count();
        if 2 * nonzero < entries.len() || nonzero < LEAST {
            continue;
        }
        let opposite = |other: &[Edge]| {
            let mut pairs = entries.iter().zip(other);
            let turned = |(x, y): (&Edge, &Edge)| {
                x.item == y.item && (x.negative != y.negative || items.is_zero(x.item))
            };
            entries.len() == other.len() && pairs.all(turned)
        };
        let own = (0..row).find(|&other| !known[other] && opposite(matrix[other])).map(|from| (part, from));
        let of_block = |(block, rows): &(Part, Vec<Vec<Edge>>)| {
            let free = |row: usize| {
                !earlier.negated.iter().any(|negated| negated.part == *block && negated.rows.contains(&row))
            };
            let from = (0..rows.len()).find(|&row| free(row) && opposite(&rows[row]))?;
            Some((*block, from))
        };
        let Some((of, from)) = own.or_else(|| blocks.iter().find_map(of_block)) else { continue };
        known[row] = true;
        // gcc unrolls a loop over one row and then sees the negated values; this pays off for long rows with
        // few zeros.
        let one_by_one = entries.len() >= LONG && 2 * nonzero > entries.len();
        match found.last_mut() {
            Some(run)
                if !one_by_one
                    && run.of == of
                    && run.rows.end == row
                    && run.from + run.rows.len() == from =>
            {
                run.rows.end += 1
            }
            _ => found.push(Negated { part, rows: row..row + 1, of, from }),
        }
    }
    found
}

/// A loop needs at least this many entries and rows.
const LEAST: usize = 3;

/// Products with more factors are not split.
const MOST: usize = 12;

/// The sorted factors of a product; nested products are expanded if regrouping is allowed.
fn factors(items: &Items, item: ItemId, regroup: bool) -> Vec<ItemId> {
    let mut found = Vec::new();
    let mut pending = vec![item];
    while let Some(next) = pending.pop() {
        match &items.items[next as usize] {
            Item::Quotient(over, under)
                if under.is_empty()
                    && items.sources[next as usize].is_none()
                    && (regroup || next == item) =>
            {
                pending.extend(over)
            }
            _ => found.push(next),
        }
        if found.len() + pending.len() > MOST {
            return vec![item];
        }
    }
    found.sort_unstable();
    found
}

/// The factors that remain after `others` are removed; `None` if `factors` does not contain `others`.
fn without(factors: &[ItemId], others: &[ItemId]) -> Option<Vec<ItemId>> {
    let mut rest = factors.to_vec();
    for other in others {
        rest.remove(rest.iter().position(|factor| factor == other)?);
    }
    Some(rest)
}

/// The factors common to both lists.
fn common(factors: &[ItemId], others: &[ItemId]) -> Vec<ItemId> {
    let mut others = others.to_vec();
    let shared = |factor: &&ItemId| {
        let place = others.iter().position(|other| other == *factor);
        place.map(|place| others.remove(place)).is_some()
    };
    factors.iter().filter(shared).copied().collect()
}

/// Rows whose entries are all products of a row factor and a column factor.
fn scaled(
    items: &mut Items,
    part: Part,
    matrix: &[&[Edge]],
    free: &[usize],
    regroup: bool,
) -> Option<Scaled> {
    let mut reads = rustc_hash::FxHashMap::default();
    for edge in matrix.iter().copied().flatten() {
        *reads.entry(edge.item).or_insert(0u32) += 1;
    }
    // The factors of an entry without other readers.
    let product = |edge: &Edge| {
        let alone = items.sources[edge.item as usize].is_none()
            && items.uses[edge.item as usize] == reads[&edge.item];
        let factors = factors(items, edge.item, regroup);
        (alone && factors.len() > 1).then_some((factors, edge.negative))
    };
    let products = |row: usize| matrix[row].iter().map(product).collect::<Option<Vec<_>>>();
    let rows: Vec<_> = free.iter().filter_map(|&row| Some((row, products(row)?))).collect();
    let (_, first) = rows.first().filter(|(_, entries)| rows.len() >= LEAST && entries.len() >= LEAST)?;
    // The common factors of the first row form the row factor; the remaining factors form the column factors.
    let shared = first.iter().fold(first[0].0.clone(), |shared, (factors, _)| common(&shared, factors));
    let column = |(factors, negative): &(Vec<ItemId>, bool)| Some((without(factors, &shared)?, *negative));
    let columns: Vec<(Vec<ItemId>, bool)> = first.iter().map(column).collect::<Option<_>>()?;
    let multiple = |entries: &[(Vec<ItemId>, bool)]| {
        let factor = without(&entries[0].0, &columns[0].0)?;
        let negative = entries[0].1 != columns[0].1;
        let mut pairs = entries.iter().zip(&columns);
        let same = pairs.all(|(entry, column)| {
            without(&entry.0, &column.0).as_ref() == Some(&factor) && entry.1 == (column.1 != negative)
        });
        same.then_some((factor, negative))
    };
    let found: Vec<_> = rows.iter().filter_map(|(row, entries)| Some((*row, multiple(entries)?))).collect();
    let mut replaced: Vec<ItemId> = found.iter().flat_map(|(row, _)| matrix[*row]).map(|x| x.item).collect();
    let written = replaced.len();
    replaced.sort_unstable();
    replaced.dedup();
    let empty = columns.iter().chain(found.iter().map(|(_, row)| row)).any(|(factors, _)| factors.is_empty());
    // A loop repeats the multiplications of equal entries, but computes several entries at a time.
    if found.len() < LEAST || empty || written > 2 * replaced.len() {
        return None;
    }
    let known = known_products(items, regroup);
    let mut edge = |(factors, negative): (Vec<ItemId>, bool)| Edge {
        item: product_of(items, &known, &factors),
        negative,
    };
    let columns = columns.into_iter().map(&mut edge).collect();
    let rows = found.into_iter().map(|(row, factor)| (row, edge(factor))).collect();
    Some(Scaled { part, columns, rows })
}

/// The first item with each product of factors.
type Products = rustc_hash::FxHashMap<Vec<ItemId>, ItemId>;

/// The existing products, by their factors.
fn known_products(items: &Items, regroup: bool) -> Products {
    let mut known = Products::default();
    for (item, _) in items.uses.iter().enumerate().filter(|(_, uses)| **uses > 0) {
        known.entry(factors(items, item as ItemId, regroup)).or_insert(item as ItemId);
    }
    known
}

/// A product of factors: an existing item, one factor times an existing item, or a new item.
fn product_of(items: &mut Items, known: &Products, factors: &[ItemId]) -> ItemId {
    match (factors, known.get(factors)) {
        ([single], _) => return *single,
        (_, Some(item)) => return *item,
        _ => {}
    }
    let with_rest = |factor: &ItemId| Some(vec![*factor, *known.get(&without(factors, &[*factor])?)?]);
    let over = factors.iter().find_map(with_rest).unwrap_or_else(|| factors.to_vec());
    over.iter().for_each(|item| items.uses[*item as usize] += 1);
    items.items.push(Item::Quotient(over, vec![]));
    items.sources.push(None);
    items.uses.push(0);
    items.items.len() as ItemId - 1
}
