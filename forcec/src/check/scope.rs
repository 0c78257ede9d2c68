//! Variables in scope, found by name in logarithmic time however many there are.

use std::collections::BTreeMap;

/// A stack of named things; the last of a name is the one in sight.
pub(crate) struct Scope<'a, T> {
    entries: Vec<(&'a str, T)>,
    places: BTreeMap<&'a str, Vec<usize>>,
}

impl<'a, T> Scope<'a, T> {
    pub(crate) fn new() -> Scope<'a, T> {
        Scope { entries: Vec::new(), places: BTreeMap::new() }
    }

    /// How many there are: a mark to come back to.
    pub(crate) fn mark(&self) -> usize {
        self.entries.len()
    }

    pub(crate) fn bind(&mut self, name: &'a str, entry: T) {
        self.places.entry(name).or_default().push(self.entries.len());
        self.entries.push((name, entry));
    }

    /// Where the name in sight stands.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.places.get(name)?.last().copied()
    }

    pub(crate) fn at(&mut self, place: usize) -> &mut T {
        &mut self.entries[place].1
    }

    /// The names in sight, the last first.
    pub(crate) fn names(&self) -> impl Iterator<Item = &'a str> {
        self.entries.iter().rev().map(|(name, _)| *name)
    }

    /// Takes away what was bound after the mark, in the order it was bound.
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
