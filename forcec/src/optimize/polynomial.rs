//! Sums of signed products of atoms: the values that factoring rewrites.
//!
//! A product is interned and identified by its number. A sum is a short sorted list; equal sums compare
//! equal.

use crate::math::exact::Exact;
use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;
use smallvec::SmallVec;

/// A value of the network.
pub type Atom = u32;

/// An interned product of atoms.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Monomial(u32);

/// Interned products. Atoms are sorted, powers repeat their atom, the empty product is 1.
#[derive(Clone, Default)]
pub struct Monomials(IndexSet<Product, FxBuildHasher>);

/// Nearly all products have few factors.
type Product = SmallVec<[Atom; 4]>;

impl Monomials {
    /// The id of a product; the atoms need not be sorted.
    pub fn intern(&mut self, atoms: &mut [Atom]) -> Monomial {
        atoms.sort_unstable();
        let (place, _) = self.0.insert_full(Product::from_slice(atoms));
        Monomial(place as u32)
    }

    /// The atoms of a product.
    pub fn atoms(&self, monomial: Monomial) -> &[Atom] {
        &self.0[monomial.0 as usize]
    }

    /// The number of atoms, with multiplicity.
    pub fn degree(&self, monomial: Monomial) -> usize {
        self.atoms(monomial).len()
    }

    /// a / b, or `None` if b does not divide a.
    pub fn quotient(&self, a: &[Atom], b: &[Atom]) -> Option<Vec<Atom>> {
        let mut rest = Vec::with_capacity(a.len() + 1);
        let mut j = 0;
        for &atom in a {
            if j < b.len() && b[j] == atom {
                j += 1;
            } else {
                rest.push(atom);
            }
        }
        (j == b.len()).then_some(rest)
    }
}

/// (product, coefficient) pairs, sorted by product; no coefficient is zero.
#[derive(Clone, Default, PartialEq, Eq, Hash, Debug)]
pub struct Polynomial(Vec<(Monomial, Exact)>);

impl Polynomial {
    /// The empty sum, 0.
    pub fn new() -> Polynomial {
        Polynomial::default()
    }

    /// The terms, sorted by product.
    pub fn terms(&self) -> &[(Monomial, Exact)] {
        &self.0
    }

    /// Number of terms.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether the sum is 0.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The products of the terms, in order.
    pub fn monomials(&self) -> impl Iterator<Item = Monomial> + Clone {
        self.0.iter().map(|(monomial, _)| *monomial)
    }

    /// The coefficient of a product that occurs.
    pub fn get(&self, monomial: Monomial) -> Option<&Exact> {
        self.place(monomial).ok().map(|i| &self.0[i].1)
    }

    /// Removes the term with this product.
    pub fn remove(&mut self, monomial: Monomial) -> Option<Exact> {
        self.place(monomial).ok().map(|i| self.0.remove(i).1)
    }

    /// Removes and returns the first term whose product is wanted.
    pub fn take_first(&mut self, wanted: impl Fn(Monomial) -> bool) -> Option<(Monomial, Exact)> {
        let place = self.0.iter().position(|(monomial, _)| wanted(*monomial))?;
        Some(self.0.remove(place))
    }

    /// Adds a term.
    pub fn add(&mut self, monomial: Monomial, coefficient: &Exact) {
        match self.place(monomial) {
            Ok(i) => {
                let sum = &self.0[i].1 + coefficient;
                if sum.is_zero() {
                    self.0.remove(i);
                } else {
                    self.0[i].1 = sum;
                }
            }
            Err(i) => self.0.insert(i, (monomial, coefficient.clone())),
        }
    }

    /// The sum with opposite signs.
    pub fn negated(&self) -> Polynomial {
        Polynomial(self.0.iter().map(|(monomial, c)| (*monomial, -c)).collect())
    }

    fn place(&self, monomial: Monomial) -> Result<usize, usize> {
        self.0.binary_search_by_key(&monomial, |(m, _)| *m)
    }
}

impl<const N: usize> From<[(Monomial, Exact); N]> for Polynomial {
    fn from(terms: [(Monomial, Exact); N]) -> Polynomial {
        let mut polynomial = Polynomial(Vec::with_capacity(N));
        for (monomial, coefficient) in &terms {
            polynomial.add(*monomial, coefficient);
        }
        polynomial
    }
}
