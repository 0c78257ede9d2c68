//! Variables in scope, found by name in logarithmic time.

use std::collections::BTreeMap;

/// A stack of named entries; a later entry shadows earlier ones of the same name.
pub(crate) struct Scope<'a, T> {
    entries: Vec<(&'a str, T)>,
    places: BTreeMap<&'a str, Vec<usize>>,
}

impl<'a, T> Scope<'a, T> {
    pub(crate) fn new() -> Scope<'a, T> {
        Scope { entries: Vec::new(), places: BTreeMap::new() }
    }

    /// Number of entries, as a mark for `leave`.
    pub(crate) fn mark(&self) -> usize {
        self.entries.len()
    }

    pub(crate) fn bind(&mut self, name: &'a str, entry: T) {
        self.places.entry(name).or_default().push(self.entries.len());
        self.entries.push((name, entry));
    }

    /// Index of the entry that a name refers to.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.places.get(name)?.last().copied()
    }

    pub(crate) fn at(&mut self, place: usize) -> &mut T {
        &mut self.entries[place].1
    }

    /// Names in scope, the latest first.
    pub(crate) fn names(&self) -> impl Iterator<Item = &'a str> {
        self.entries.iter().rev().map(|(name, _)| *name)
    }

    /// Removes and returns the entries bound after the mark, in order.
    pub(crate) fn leave(&mut self, mark: usize) -> Vec<T> {
        let mut left = Vec::new();
        for (name, entry) in self.entries.drain(mark..) {
            if let Some(places) = self.places.get_mut(name) {
                places.pop();
            }
            left.push(entry);
        }
        left
    }
}
