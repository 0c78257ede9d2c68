//! The network that factoring rewrites: every value is a sum of signed products of other values.
//!
//! In: a [`Program`]. Out: a program that computes the same values with fewer operations. Sums and products
//! with one use are part of their user; a node with several uses, a name from the source, or an output is an
//! atom. Numbers other than ±1 are atoms, so that 2x is shared like any product. Pinned differences are
//! leaves.

use crate::math::exact::Exact;
use crate::optimize::polynomial::{Atom, Monomial, Monomials, Polynomial};
use crate::scalar::valuation::Valuation;
use crate::scalar::{Graph, Id, Node, Operations, Program};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// The definition of an atom.
#[derive(Clone, Debug)]
pub enum Value {
    /// An input, a pinned difference, or a known truth.
    Leaf(Id),
    /// A number other than ±1.
    Number(Exact),
    /// Σ coefficient · product
    Sum(Polynomial),
    /// Any other node, with atoms as operands.
    Operation(Id, Box<[Atom]>),
    /// Removed.
    Dead,
}

/// An output: a number or a multiple of an atom.
#[derive(Clone, Debug)]
enum Output {
    Number(Exact),
    Multiple(Exact, Atom),
}

/// Sums of signed products, with the program that they were read from.
#[derive(Clone)]
pub struct Network {
    /// The program that was read; leaves and operations refer to its graph.
    source: Rc<Program>,
    /// The definition of each atom.
    pub values: Vec<Value>,
    /// The interned products.
    pub monomials: Monomials,
    names: BTreeMap<Atom, String>,
    numbers: FxHashMap<Exact, Atom>,
    outputs: FxHashMap<Id, Output>,
}

type Terms = Vec<(Exact, Vec<Atom>)>;

/// Longer products, and higher powers, become atoms.
const LONGEST_POWER: usize = 12;

/// Longer sums are split.
const LONGEST_SUM: usize = 12;

struct Reader<'p> {
    graph: &'p Graph,
    uses: Vec<u32>,
    /// Multiples that are not expanded: a power of the number would leave the range of floats.
    whole: BTreeSet<Id>,
    terms: Vec<Terms>,
    atoms: FxHashMap<Id, Atom>,
    network: Network,
}

impl Network {
    /// Reads a program; every live node becomes an atom or part of one.
    pub fn new(program: &Rc<Program>) -> Network {
        let live = program.live();
        let graph = &program.graph;
        let mut uses = vec![0_u32; graph.len()];
        for (id, node) in graph.iter().filter(|(id, _)| live[id.index()]) {
            for operand in node.operands() {
                // A multiple is not an atom: its users read the multiplied node.
                let weight = if graph.split(id).1 != id { 0 } else { 1 };
                let target = graph.split(operand).1;
                uses[target.index()] += weight;
            }
        }
        let mut seen = vec![false; graph.len()];
        for output in program.roots() {
            let target = graph.split(output).1;
            if !std::mem::replace(&mut seen[target.index()], true) {
                uses[target.index()] += 1;
            }
        }
        let network = Network {
            source: Rc::clone(program),
            values: Vec::new(),
            monomials: Monomials::default(),
            names: BTreeMap::new(),
            numbers: FxHashMap::default(),
            outputs: FxHashMap::default(),
        };
        let mut whole = BTreeSet::new();
        for (_, node) in graph.iter() {
            let Node::Product(factors) = node else { continue };
            whole.extend(factors.iter().filter_map(|(x, exponent)| match graph.node(*x) {
                Node::Multiple(c, _) if !c.power_stays(*exponent) => Some(*x),
                _ => None,
            }));
        }
        let terms = vec![Vec::new(); graph.len()];
        let mut reader = Reader { graph, uses, whole, terms, atoms: FxHashMap::default(), network };
        // A multiple has no terms: its users read the multiplied node.
        for (id, node) in graph.iter().filter(|(id, _)| live[id.index()] && graph.split(*id).1 == *id) {
            reader.terms[id.index()] = reader.read(id, node);
            if graph.name(id).is_some() {
                reader.atom(id);
            }
        }
        for output in program.roots() {
            if reader.network.outputs.contains_key(&output) {
                continue;
            }
            let (coefficient, rest) = graph.split(output);
            let value = match graph.value(rest) {
                Some(number) => Output::Number(&coefficient * number),
                None => Output::Multiple(coefficient, reader.atom(rest)),
            };
            reader.network.outputs.insert(output, value);
        }
        reader.network
    }

    /// Adds an atom.
    pub fn define(&mut self, value: Value) -> Atom {
        self.values.push(value);
        (self.values.len() - 1) as Atom
    }

    /// Terms as a polynomial, with numbers other than ±1 as atoms. A long sum becomes a sum of shorter sums,
    /// so that changing a term does not affect all others.
    fn lift(&mut self, mut terms: Terms) -> Polynomial {
        while terms.len() > LONGEST_SUM {
            let mut shorter = Vec::with_capacity(terms.len() / LONGEST_SUM + 1);
            for chunk in terms.chunks(LONGEST_SUM) {
                let polynomial = self.lift(chunk.to_vec());
                shorter.push((Exact::ONE, vec![self.define(Value::Sum(polynomial))]));
            }
            terms = shorter;
        }
        let mut polynomial = Polynomial::new();
        for (coefficient, mut atoms) in terms {
            let (sign, size) = (coefficient.is_negative(), coefficient.abs());
            if !size.is_one() {
                atoms.push(self.number(size));
            }
            let monomial = self.monomials.intern(&mut atoms);
            polynomial.add(monomial, &if sign { -Exact::ONE } else { Exact::ONE });
        }
        polynomial
    }

    /// A power of an atom, by squaring.
    fn power(&mut self, base: Atom, exponent: u32) -> Atom {
        let product = |network: &mut Network, x: Atom, y: Atom| {
            let monomial = network.monomials.intern(&mut [x, y]);
            network.define(Value::Sum(Polynomial::from([(monomial, Exact::ONE)])))
        };
        let mut power = base;
        for bit in (0..exponent.ilog2()).rev() {
            power = product(self, power, power);
            if exponent >> bit & 1 == 1 {
                power = product(self, power, base);
            }
        }
        power
    }

    fn number(&mut self, value: Exact) -> Atom {
        if let Some(&atom) = self.numbers.get(&value) {
            return atom;
        }
        let atom = self.define(Value::Number(value.clone()));
        self.numbers.insert(value, atom);
        atom
    }

    /// Visits the operands of an atom, in order, with repetition.
    pub fn each_operand(&self, atom: Atom, mut visit: impl FnMut(Atom)) {
        match &self.values[atom as usize] {
            Value::Sum(polynomial) => {
                for monomial in polynomial.monomials() {
                    self.monomials.atoms(monomial).iter().copied().for_each(&mut visit);
                }
            }
            Value::Operation(_, atoms) => atoms.iter().copied().for_each(visit),
            Value::Leaf(_) | Value::Number(_) | Value::Dead => {}
        }
    }

    /// The atoms that outputs and residuals are multiples of.
    pub fn roots(&self) -> impl Iterator<Item = Atom> {
        self.source.roots().filter_map(|id| match self.outputs[&id] {
            Output::Multiple(_, atom) => Some(atom),
            Output::Number(_) => None,
        })
    }

    /// The number of nonzero outputs, distinct up to sign.
    pub fn distinct(&self) -> usize {
        let outputs = self.source.outputs().filter_map(|id| match &self.outputs[&id] {
            Output::Multiple(c, atom) => Some((Some(*atom), c.abs())),
            Output::Number(value) => (!value.is_zero()).then(|| (None, value.abs())),
        });
        outputs.collect::<BTreeSet<_>>().len()
    }

    /// Whether an atom is a sum of several terms, which can cancel.
    pub fn is_mixed(&self, atom: Atom) -> bool {
        matches!(&self.values[atom as usize], Value::Sum(polynomial) if polynomial.len() > 1)
    }

    /// Whether an atom carries a name from the source.
    pub fn is_named(&self, atom: Atom) -> bool {
        self.names.contains_key(&atom)
    }

    /// Live atoms, operands first.
    pub fn order(&self) -> Vec<Atom> {
        let mut order = Vec::new();
        let mut state = vec![0_u8; self.values.len()];
        let mut roots: Vec<Atom> = self.roots().collect();
        roots.reverse();
        while let Some(&atom) = roots.last() {
            match state[atom as usize] {
                0 => {
                    state[atom as usize] = 1;
                    let first = roots.len();
                    self.each_operand(atom, |x| {
                        if state[x as usize] == 0 {
                            roots.push(x);
                        }
                    });
                    roots[first..].reverse();
                }
                1 => {
                    state[atom as usize] = 2;
                    order.push(atom);
                    roots.pop();
                }
                _ => {
                    roots.pop();
                }
            }
        }
        order
    }

    /// The sums that read each atom.
    pub fn users(&self) -> Vec<Vec<Atom>> {
        let mut users = vec![Vec::new(); self.values.len()];
        for user in self.order() {
            self.each_operand(user, |x| users[x as usize].push(user));
        }
        users
    }

    /// Removes copies and dead atoms, and merges atoms that are equal up to sign.
    pub fn sweep(&mut self) {
        // The sign and the atom that replace an atom.
        let mut became: FxHashMap<Atom, (bool, Atom)> = FxHashMap::default();
        let mut sums: FxHashMap<Polynomial, (bool, Atom)> = FxHashMap::default();
        let mut operations: FxHashMap<(Node, Box<[Atom]>), Atom> = FxHashMap::default();
        let order = self.order();
        for &atom in &order {
            let value = std::mem::replace(&mut self.values[atom as usize], Value::Dead);
            self.values[atom as usize] = match value {
                Value::Sum(polynomial) => {
                    let polynomial = self.replace(polynomial, &became);
                    if let Some(copy) = self.copy_of(&polynomial) {
                        became.insert(atom, copy);
                    } else {
                        let negative = polynomial.terms().first().is_some_and(|(_, c)| c.is_negative());
                        let key = if negative { polynomial.negated() } else { polynomial.clone() };
                        match sums.get(&key) {
                            Some(&(sign, same)) => {
                                became.insert(atom, (sign != negative, same));
                            }
                            None => {
                                sums.insert(key, (negative, atom));
                            }
                        }
                    }
                    Value::Sum(polynomial)
                }
                Value::Operation(id, atoms) => {
                    let atoms: Box<[Atom]> = atoms
                        .iter()
                        .map(|&a| match became.get(&a) {
                            Some(&(false, other)) => other,
                            _ => a,
                        })
                        .collect();
                    let key = (shape(self.source.graph.node(id)), atoms.clone());
                    match operations.get(&key) {
                        Some(&same) => {
                            became.insert(atom, (false, same));
                        }
                        None => {
                            operations.insert(key, atom);
                        }
                    }
                    Value::Operation(id, atoms)
                }
                other => other,
            };
        }
        for (old, (_, new)) in became_sorted(&became) {
            if let Some(name) = self.names.get(&old).cloned()
                && !became[&old].0
            {
                self.names.entry(new).or_insert(name);
            }
        }
        let ids: Vec<Id> = self.source.roots().collect();
        for id in ids {
            let output = self.outputs.get_mut(&id).expect("every output was read");
            if let Output::Multiple(c, atom) = output
                && let Some(&(negative, other)) = became.get(atom)
            {
                *output = Output::Multiple(if negative { -&*c } else { c.clone() }, other);
            }
            if let Output::Multiple(c, atom) = output
                && let Value::Sum(polynomial) = &self.values[*atom as usize]
            {
                if polynomial.is_empty() {
                    *output = Output::Number(Exact::ZERO);
                } else if let [(m, d)] = polynomial.terms()
                    && self.monomials.degree(*m) == 0
                {
                    *output = Output::Number(&*c * d);
                }
            }
        }
        let mut still = vec![false; self.values.len()];
        for root in self.roots() {
            still[root as usize] = true;
        }
        for &atom in order.iter().rev() {
            if still[atom as usize] {
                self.each_operand(atom, |operand| still[operand as usize] = true);
            }
        }
        for (value, still) in self.values.iter_mut().zip(still) {
            if !still && !matches!(value, Value::Number(_)) {
                *value = Value::Dead;
            }
        }
    }

    fn replace(&mut self, polynomial: Polynomial, became: &FxHashMap<Atom, (bool, Atom)>) -> Polynomial {
        let touched = |m: Monomial| self.monomials.atoms(m).iter().any(|a| became.contains_key(a));
        if became.is_empty() || !polynomial.monomials().any(touched) {
            return polynomial;
        }
        let mut replaced = Polynomial::new();
        let mut atoms = Vec::new();
        for (monomial, coefficient) in polynomial.terms() {
            let mut negative = false;
            atoms.clear();
            for &atom in self.monomials.atoms(*monomial) {
                let (sign, atom) = became.get(&atom).copied().unwrap_or((false, atom));
                negative ^= sign;
                atoms.push(atom);
            }
            let monomial = self.monomials.intern(&mut atoms);
            if negative {
                replaced.add(monomial, &-coefficient);
            } else {
                replaced.add(monomial, coefficient);
            }
        }
        replaced
    }

    /// The sign and the atom if the polynomial is ± one atom.
    fn copy_of(&self, polynomial: &Polynomial) -> Option<(bool, Atom)> {
        let [(monomial, coefficient)] = polynomial.terms() else { return None };
        match self.monomials.atoms(*monomial) {
            &[atom] if coefficient.is_unit() => match self.values[atom as usize] {
                Value::Number(_) => None,
                _ => Some((coefficient.is_negative(), atom)),
            },
            _ => None,
        }
    }

    /// Whether a sum is a single product with a number and another factor, which stays a value.
    fn is_multiple(&self, polynomial: &Polynomial) -> bool {
        let number = |atom: &Atom| matches!(self.values[*atom as usize], Value::Number(_));
        polynomial.len() == 1
            && polynomial.monomials().all(|monomial| {
                let atoms = self.monomials.atoms(monomial);
                atoms.iter().any(number) && !atoms.iter().all(number)
            })
    }

    /// The valuation of each atom; 0 for dead atoms.
    pub fn valuations(&self) -> Vec<Valuation> {
        let mut valuations = vec![Valuation::ZERO; self.values.len()];
        let signature = &self.source.signature;
        for atom in self.order() {
            valuations[atom as usize] = match &self.values[atom as usize] {
                Value::Sum(polynomial) => self.valuation_of_sum(polynomial, &valuations),
                Value::Leaf(id) | Value::Operation(id, _) => {
                    let mut operands = SmallVec::<[Valuation; 4]>::new();
                    self.each_operand(atom, |x| operands.push(valuations[x as usize]));
                    Valuation::of_node(signature, self.source.graph.node(*id), &operands)
                }
                Value::Number(_) | Value::Dead => Valuation::ZERO,
            };
        }
        valuations
    }

    /// The valuation of a sum of products.
    pub fn valuation_of_sum(&self, sum: &Polynomial, valuations: &[Valuation]) -> Valuation {
        let of_atom = |atom: &Atom| valuations[*atom as usize];
        Valuation::least(sum.monomials().map(|m| self.monomials.atoms(m).iter().map(of_atom).sum()))
    }

    /// The operations of every live atom.
    pub fn operations(&self) -> Operations {
        let mut total = Operations::default();
        for atom in self.order() {
            match &self.values[atom as usize] {
                Value::Sum(polynomial) => {
                    total.add += polynomial.len().saturating_sub(1);
                    let degrees = polynomial.monomials().map(|m| self.monomials.degree(m).saturating_sub(1));
                    total.mul += degrees.sum::<usize>();
                    total.neg += usize::from(polynomial.terms().iter().all(|(_, c)| c.is_negative()));
                }
                Value::Leaf(id) | Value::Operation(id, _) => total += self.source.graph.cost(*id),
                Value::Number(_) | Value::Dead => {}
            }
        }
        total
    }

    /// Converts the network back to a program.
    pub fn program(&self) -> Program {
        let mut graph = Graph::default();
        let mut ids: Vec<Option<Id>> = vec![None; self.values.len()];
        for atom in self.order() {
            let id = match &self.values[atom as usize] {
                Value::Leaf(id) => match self.source.graph.node(*id) {
                    Node::Input(slot) => graph.input(*slot),
                    Node::Difference(first, second) => graph.difference(*first, *second),
                    Node::Offset(slot, number) => {
                        let entry = graph.input(*slot);
                        graph.offset(entry, number.clone())
                    }
                    Node::Known(value) => graph.known(*value),
                    node => unreachable!("{node:?} is not a leaf"),
                },
                Value::Number(value) => graph.constant(value.clone()),
                Value::Sum(polynomial) if self.is_multiple(polynomial) => {
                    let (monomial, sign) = &polynomial.terms()[0];
                    let mut size = sign.clone();
                    let mut factors = Vec::new();
                    for &factor in self.monomials.atoms(*monomial) {
                        match &self.values[factor as usize] {
                            Value::Number(number) => size = &size * number,
                            _ => factors.push((ids[factor as usize].expect("operands come first"), 1)),
                        }
                    }
                    let product = graph.product(&factors);
                    graph.held_multiple(&size, product)
                }
                Value::Sum(polynomial) => {
                    let mut terms = Vec::with_capacity(polynomial.len());
                    for (monomial, coefficient) in polynomial.terms() {
                        let factors: Vec<(Id, u32)> = self
                            .monomials
                            .atoms(*monomial)
                            .iter()
                            .map(|a| (ids[*a as usize].expect("operands come first"), 1))
                            .collect();
                        terms.push((coefficient.clone(), graph.product(&factors)));
                    }
                    graph.sum(Exact::ZERO, terms)
                }
                Value::Operation(id, atoms) => {
                    let operands: Vec<Id> =
                        atoms.iter().map(|a| ids[*a as usize].expect("operands come first")).collect();
                    rebuild(&mut graph, self.source.graph.node(*id), &operands)
                }
                Value::Dead => unreachable!("a dead atom is not live"),
            };
            if let Some(name) = self.names.get(&atom) {
                graph.set_name(id, name);
            }
            ids[atom as usize] = Some(id);
        }
        let mut program = self.source.outline();
        program.map_outputs(|id| match &self.outputs[&id] {
            Output::Number(value) => graph.constant(value.clone()),
            Output::Multiple(c, atom) => {
                graph.scaled(c.clone(), ids[*atom as usize].expect("outputs are live"))
            }
        });
        for id in self.source.graph.residual() {
            if let Output::Multiple(_, atom) = self.outputs[&id] {
                graph.set_residual(ids[atom as usize].expect("the residual is live"));
            }
        }
        program.graph = graph;
        program
    }
}

fn became_sorted(became: &FxHashMap<Atom, (bool, Atom)>) -> BTreeMap<Atom, (bool, Atom)> {
    became.iter().map(|(k, v)| (*k, *v)).collect()
}

/// A node without its operands; operations merge only if their shapes are equal.
fn shape(node: &Node) -> Node {
    let none = Id(0);
    match node {
        Node::Recip(_) => Node::Recip(none),
        Node::Held(_) => Node::Held(none),
        Node::Written(operator, ..) => Node::Written(*operator, none, none),
        Node::Multiple(c, _) => Node::Multiple(c.clone(), none),
        Node::Call(function, _) => Node::Call(*function, [].into()),
        Node::Select(..) => Node::Select(none, none, none),
        Node::Compare(comparison, ..) => Node::Compare(*comparison, none, none),
        Node::And(..) => Node::And(none, none),
        Node::Or(..) => Node::Or(none, none),
        Node::Not(_) => Node::Not(none),
        other => other.clone(),
    }
}

/// The same operation with other operands.
fn rebuild(graph: &mut Graph, node: &Node, operands: &[Id]) -> Id {
    match (node, operands) {
        (Node::Recip(_), &[x]) => graph.recip(x),
        (Node::Held(_), &[x]) => graph.held(x),
        (Node::Written(operator, ..), &[x, y]) => graph.written(*operator, x, y),
        (Node::Multiple(c, _), &[x]) => graph.held_multiple(c, x),
        (Node::Call(function, _), arguments) => graph.call(*function, arguments),
        (Node::Select(..), &[c, x, y]) => graph.select(c, x, y),
        (Node::Compare(comparison, ..), &[x, y]) => graph.compare(*comparison, x, y),
        (Node::And(..), &[a, b]) => graph.and(a, b),
        (Node::Or(..), &[a, b]) => graph.or(a, b),
        (Node::Not(_), &[a]) => graph.not(a),
        _ => unreachable!("{node:?} is not an operation"),
    }
}

impl Reader<'_> {
    /// The terms of a node, for its only user or for [`Reader::atom`].
    fn read(&mut self, id: Id, node: &Node) -> Terms {
        match node {
            Node::Constant(value) if value.is_zero() => vec![],
            Node::Constant(value) => vec![(value.clone(), vec![])],
            Node::Sum(constant, terms) => {
                let mut flat = Vec::new();
                if !constant.is_zero() {
                    flat.push((constant.clone(), vec![]));
                }
                for (coefficient, term) in terms {
                    // Other numbers than powers of two would round every term of a sum, and the terms may
                    // cancel.
                    let parts = self.inline(*term, coefficient.is_power_of_two());
                    if coefficient.is_one() && flat.is_empty() {
                        flat = parts;
                    } else {
                        flat.extend(parts.into_iter().map(|(c, atoms)| (coefficient * &c, atoms)));
                    }
                }
                flat
            }
            Node::Product(factors) => {
                let mut coefficient = Exact::ONE;
                let mut product = Vec::new();
                for &(factor, exponent) in factors {
                    if exponent as usize > LONGEST_POWER {
                        let base = self.atom(factor);
                        product.push(self.network.power(base, exponent));
                        continue;
                    }
                    let mut parts = self.inline(factor, false);
                    let (c, mut atoms) = parts.pop().expect("a factor is not zero");
                    coefficient = &coefficient * &c.powi(exponent as i32);
                    if atoms.len() > LONGEST_POWER {
                        let held = self.network.lift(vec![(Exact::ONE, atoms)]);
                        atoms = vec![self.network.define(Value::Sum(held))];
                    }
                    for _ in 0..exponent {
                        product.extend_from_slice(&atoms);
                    }
                }
                vec![(coefficient, product)]
            }
            Node::Multiple(coefficient, x) if !self.whole.contains(&id) => {
                let parts = self.inline(*x, false);
                parts.into_iter().map(|(c, atoms)| (coefficient * &c, atoms)).collect()
            }
            Node::Input(_) | Node::Difference(..) | Node::Offset(..) | Node::Known(_) => {
                let atom = self.network.define(Value::Leaf(id));
                if let Some(name) = self.graph.name(id) {
                    self.network.names.insert(atom, name.to_owned());
                }
                self.atoms.insert(id, atom);
                vec![(Exact::ONE, vec![atom])]
            }
            operation => {
                let operands = operation.operands().into_iter().map(|x| self.atom(x)).collect();
                let atom = self.network.define(Value::Operation(id, operands));
                if let Some(name) = self.graph.name(id) {
                    self.network.names.insert(atom, name.to_owned());
                }
                self.atoms.insert(id, atom);
                vec![(Exact::ONE, vec![atom])]
            }
        }
    }

    /// A node's terms for a user: the terms themselves if this is the only use, else the node's atom.
    fn inline(&mut self, id: Id, sum: bool) -> Terms {
        if let Some(&atom) = self.atoms.get(&id) {
            return vec![(Exact::ONE, vec![atom])];
        }
        let (coefficient, rest) = self.graph.split(id);
        if rest != id {
            let parts = self.inline(rest, sum);
            return parts.into_iter().map(|(c, atoms)| (&coefficient * &c, atoms)).collect();
        }
        let terms = &self.terms[id.index()];
        let trivial = terms.len() == 1 && terms[0].1.len() <= 1;
        let single = self.uses[id.index()] <= 1 && self.graph.name(id).is_none();
        if trivial {
            return terms.clone();
        }
        if single && (sum || terms.len() == 1) {
            return std::mem::take(&mut self.terms[id.index()]);
        }
        vec![(Exact::ONE, vec![self.atom(id)])]
    }

    /// The atom of a node, defined on the first call.
    fn atom(&mut self, id: Id) -> Atom {
        if let Some(&atom) = self.atoms.get(&id) {
            return atom;
        }
        let multiple = self.graph.split(id).1 != id;
        let terms =
            if multiple { self.inline(id, true) } else { std::mem::take(&mut self.terms[id.index()]) };
        if let [(c, atoms)] = terms.as_slice()
            && c.is_one()
            && atoms.len() == 1
        {
            self.atoms.insert(id, atoms[0]);
            return atoms[0];
        }
        let polynomial = self.network.lift(terms);
        let atom = self.network.define(Value::Sum(polynomial));
        if let Some(name) = self.graph.name(id) {
            self.network.names.insert(atom, name.to_owned());
        }
        self.atoms.insert(id, atom);
        atom
    }
}
