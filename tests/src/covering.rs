//! Covering arrays: a few of many possible rows, such that any two values of any two factors occur together
//! in some row.
//!
//! Input: the number of values of each factor, and the valid rows. Output: rows, the same in every run. Each
//! row begins with the first uncovered pair, and takes for every other factor the value that covers most new
//! pairs.

use std::collections::BTreeSet;

/// Two values of two factors.
type Pair = ((usize, usize), (usize, usize));

/// The rows. `valid` judges a row in which some values are still open; the first value of a factor goes with all others
/// that go together.
pub fn covering(sizes: &[usize], valid: &dyn Fn(&[Option<usize>]) -> bool) -> Vec<Vec<usize>> {
    let values = |factor: usize| (0..sizes[factor]).map(move |value| (factor, value));
    let mut open: BTreeSet<Pair> = BTreeSet::new();
    for (first, second) in (0..sizes.len()).flat_map(|x| (0..x).map(move |y| (y, x))) {
        open.extend(values(first).flat_map(|x| values(second).map(move |y| (x, y))));
    }
    let mut rows: Vec<Vec<usize>> = Vec::new();
    while let Some(pair @ (x, y)) = open.pop_first() {
        let mut row = vec![None; sizes.len()];
        (row[x.0], row[y.0]) = (Some(x.1), Some(y.1));
        if !valid(&row) {
            continue;
        }
        for factor in 0..sizes.len() {
            if row[factor].is_some() {
                continue;
            }
            let others: Vec<(usize, usize)> =
                row.iter().enumerate().filter_map(|(at, value)| value.map(|value| (at, value))).collect();
            let gain = |own: (usize, usize)| {
                let pairs = others.iter().map(|other| (own.min(*other), own.max(*other)));
                pairs.filter(|pair| open.contains(pair)).count()
            };
            let candidates = values(factor).filter(|(_, value)| {
                let mut tried = row.clone();
                tried[factor] = Some(*value);
                valid(&tried)
            });
            let best = candidates
                .map(|own| (gain(own), own.1))
                .max_by_key(|(gain, value)| (*gain, std::cmp::Reverse(*value)));
            let Some((_, value)) = best else { break };
            row[factor] = Some(value);
        }
        let row: Option<Vec<usize>> = row.into_iter().collect();
        let row = row.unwrap_or_else(|| panic!("no complete row contains {pair:?}"));
        for (x, y) in (0..row.len()).flat_map(|x| (0..x).map(move |y| (y, x))) {
            open.remove(&((x, row[x]), (y, row[y])));
        }
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::covering;

    #[test]
    fn every_valid_pair_is_in_a_row() {
        let sizes = [5, 3, 2, 4];
        let valid = |row: &[Option<usize>]| !(row[0] == Some(4) && row[3].is_some_and(|value| value > 1));
        let rows = covering(&sizes, &valid);
        assert!(rows.len() < 5 * 4 + 5, "{} rows", rows.len());
        for (x, y) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            for (v, w) in (0..sizes[x]).flat_map(|v| (0..sizes[y]).map(move |w| (v, w))) {
                let there = rows.iter().any(|row| row[x] == v && row[y] == w);
                assert_eq!(there, !((x, v) == (0, 4) && y == 3 && w > 1), "{x}: {v}, {y}: {w}");
            }
        }
        assert_eq!(rows, covering(&sizes, &valid));
    }
}
