//! From the scalar graph to items: the operations that the text of a kernel consists of.
//!
//! In: a program. Out: its live nodes as sums, quotients and calls with signed operands, operands before
//! users, shared wherever the text can share them. Signs are attached to the edges, so that a value and its
//! negative are one item. A number times an item is an item of its own. Powers become multiplications by the
//! shortest addition chain. A reciprocal with a single reader that is a product becomes a division in that
//! product.

use crate::math::exact::Exact;
use crate::math::functions::{Cost, Function, Operator};
use crate::math::number::Comparison;
use crate::model::bodies::{Signature, Slot};
use crate::model::outputs::{Array, Output, Part};
use crate::names::values::ValueName;
use crate::scalar::valuation::Valuation;
use crate::scalar::{Id, Node, Program};
use crate::schedule::Style;
use crate::schedule::doubled::Pair;
use crate::schedule::meanings::Meanings;
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::SmallVec;

/// Index of an item.
pub(super) type ItemId = u32;

/// A use of an item, with or without a minus sign.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Edge {
    pub(super) item: ItemId,
    pub(super) negative: bool,
}

/// One operation of the text.
#[derive(Debug)]
pub(super) enum Item {
    /// A number ≥ 0.
    Number(Exact),
    Input(Slot),
    /// Pinned.
    Difference(ItemId, ItemId),
    Sum(Vec<Edge>),
    /// Π over / Π under
    Quotient(Vec<ItemId>, Vec<ItemId>),
    /// x y + z with one rounding.
    Fused(Edge, ItemId, Edge),
    Call(Function, Vec<Edge>),
    Select(ItemId, Edge, Edge),
    Known(bool),
    Compare(Comparison, Edge, Edge),
    And(ItemId, ItemId),
    Or(ItemId, ItemId),
    Not(ItemId),
}

impl Item {
    /// The operands of the item, in the order of the text.
    pub(super) fn operands(&self) -> Vec<ItemId> {
        match self {
            Item::Number(_) | Item::Input(_) | Item::Known(_) => vec![],
            Item::Difference(x, y) | Item::And(x, y) | Item::Or(x, y) => vec![*x, *y],
            Item::Sum(edges) | Item::Call(_, edges) => edges.iter().map(|e| e.item).collect(),
            Item::Quotient(over, under) => over.iter().chain(under).copied().collect(),
            Item::Fused(x, y, z) => vec![x.item, *y, z.item],
            Item::Select(c, x, y) => vec![*c, x.item, y.item],
            Item::Compare(_, x, y) => vec![x.item, y.item],
            Item::Not(x) => vec![*x],
        }
    }

    /// The valuation of the item, from the valuations of its operands: how it vanishes or grows as positions
    /// coincide.
    fn valuation(&self, signature: &Signature, of: &[Valuation]) -> Valuation {
        let of = |item: &ItemId| of[*item as usize];
        match self {
            Item::Input(slot) => Valuation::of_slot(signature, *slot),
            Item::Difference(x, y) => of(x).max(of(y)),
            Item::Sum(edges) => Valuation::least(edges.iter().map(|edge| of(&edge.item))),
            Item::Quotient(over, under) => over.iter().map(of).chain(under.iter().map(|x| -of(x))).sum(),
            Item::Fused(x, y, z) => (of(&x.item) + of(y)).min(of(&z.item)),
            Item::Call(function, edges) => {
                let arguments: SmallVec<[Valuation; 2]> = edges.iter().map(|edge| of(&edge.item)).collect();
                Valuation::of_call(*function, &arguments)
            }
            Item::Select(_, x, y) => of(&x.item).min(of(&y.item)),
            _ => Valuation::ZERO,
        }
    }

    /// Whether the item is written in place at every use.
    pub(super) fn is_literal(&self) -> bool {
        match self {
            Item::Number(_) | Item::Known(_) => true,
            Item::Call(function, _) => function.row().cost == Cost::Free,
            _ => false,
        }
    }
}

/// A program as items.
pub(super) struct Items {
    pub(super) items: Vec<Item>,
    /// The name in the source, if any.
    pub(super) sources: Vec<Option<String>>,
    /// The names of items whose values the source speaks of.
    pub(super) meanings: FxHashMap<ItemId, ValueName>,
    /// The number of reads of an item, by items and by outputs.
    pub(super) uses: Vec<u32>,
    /// The quotients that stay as written in the source.
    pub(super) written: FxHashSet<ItemId>,
    /// The computed results, in order.
    pub(super) parts: Vec<Part>,
    /// Every output, in the order of the parts and rows.
    pub(super) outputs: Vec<(Output, Edge)>,
}

/// Higher powers always use the shortest addition chain, whether or not floats can represent the power.
const LONGEST_APART: u32 = 4;

/// The live nodes of a program as items.
pub(super) fn lower(program: &Program, style: Style, meanings: &Meanings) -> Items {
    let live = program.live();
    let found = meanings.of_nodes(&program.signature, &program.graph);
    let mut lowering = Lowering {
        program,
        style,
        reads: reads(program, &live),
        items: Vec::new(),
        valuations: Vec::new(),
        sources: Vec::new(),
        found,
        meanings: FxHashMap::default(),
        of: vec![None; live.len()],
        inputs: FxHashMap::default(),
        numbers: FxHashMap::default(),
        scaled: FxHashMap::default(),
        power: FxHashMap::default(),
        powers: FxHashMap::default(),
        written: FxHashSet::default(),
        chains: Chains::new(),
        pairs: FxHashMap::default(),
    };
    for (id, node) in program.graph.iter() {
        if live[id.index()] {
            lowering.node(id, node);
        }
    }
    let mut outputs = Vec::new();
    for (output, id) in program.arrays.iter().flat_map(Array::outputs) {
        outputs.push((output, lowering.edge(*id)));
    }
    let Lowering { items, sources, meanings, written, .. } = lowering;
    let mut uses = vec![0u32; items.len()];
    let reads = items.iter().flat_map(Item::operands);
    for item in reads.chain(outputs.iter().map(|(_, edge)| edge.item)) {
        uses[item as usize] += 1;
    }
    let parts = program.arrays.iter().map(|array| array.part).collect();
    Items { items, sources, meanings, uses, written, parts, outputs }
}

/// The number of reads of each node by live nodes and outputs; a read of a multiple counts as a read of the
/// node itself.
fn reads(program: &Program, live: &[bool]) -> Vec<u32> {
    let mut reads = vec![0u32; live.len()];
    for (id, node) in program.graph.iter() {
        if live[id.index()] {
            for operand in node.operands() {
                reads[program.graph.split(operand).1.index()] += 1;
            }
        }
    }
    for output in program.outputs() {
        reads[program.graph.split(output).1.index()] += 1;
    }
    reads
}

pub(super) struct Lowering<'a> {
    pub(super) program: &'a Program,
    style: Style,
    reads: Vec<u32>,
    items: Vec<Item>,
    /// The valuations of the items: how they vanish or grow as positions coincide.
    valuations: Vec<Valuation>,
    sources: Vec<Option<String>>,
    /// The name of each node's value, if the source speaks of it.
    found: Vec<Option<ValueName>>,
    meanings: FxHashMap<ItemId, ValueName>,
    of: Vec<Option<ItemId>>,
    inputs: FxHashMap<Slot, ItemId>,
    numbers: FxHashMap<Exact, ItemId>,
    scaled: FxHashMap<(ItemId, ItemId), ItemId>,
    power: FxHashMap<(ItemId, u32), ItemId>,
    powers: FxHashMap<ItemId, (ItemId, u32)>,
    written: FxHashSet<ItemId>,
    chains: Chains,
    /// The values computed in doubled precision.
    pub(super) pairs: FxHashMap<Id, Pair>,
}

impl Lowering<'_> {
    pub(super) fn push(&mut self, item: Item) -> ItemId {
        let id = self.items.len() as ItemId;
        self.valuations.push(item.valuation(&self.program.signature, &self.valuations));
        self.items.push(item);
        self.sources.push(None);
        id
    }

    pub(super) fn number(&mut self, value: &Exact) -> Edge {
        let (size, negative) = (value.abs(), value.is_negative());
        let item = match self.numbers.get(&size) {
            Some(item) => *item,
            None => {
                let item = self.push(Item::Number(size.clone()));
                self.numbers.insert(size, item);
                item
            }
        };
        Edge { item, negative }
    }

    pub(super) fn edge(&mut self, id: Id) -> Edge {
        let (coefficient, rest) = self.program.graph.split(id);
        match self.program.graph.value(rest) {
            Some(value) => self.number(&(&coefficient * value)),
            None => self.multiple(&coefficient, rest),
        }
    }

    /// coefficient · id, for an id that is neither a number nor a multiple.
    fn multiple(&mut self, coefficient: &Exact, id: Id) -> Edge {
        let item = self.item(id);
        if coefficient.is_unit() {
            return Edge { item, negative: coefficient.is_negative() };
        }
        let Edge { item: number, negative } = self.number(coefficient);
        let item = match self.scaled.get(&(number, item)) {
            Some(scaled) => *scaled,
            None => {
                let scaled = self.push(Item::Quotient(vec![number, item], vec![]));
                self.scaled.insert((number, item), scaled);
                scaled
            }
        };
        Edge { item, negative }
    }

    pub(super) fn item(&mut self, id: Id) -> ItemId {
        if self.of[id.index()].is_none() {
            // Only reciprocals are deferred until an operation other than a product reads them.
            match self.program.graph.node(id) {
                Node::Recip(x) => self.recip(id, *x),
                Node::Constant(value) => return self.number(value).item,
                _ => unreachable!("operands come before users"),
            }
        }
        self.of[id.index()].expect("just made")
    }

    fn recip(&mut self, id: Id, x: Id) {
        let under = self.item(x);
        let item = self.push(Item::Quotient(vec![], vec![under]));
        self.place(id, item);
    }

    fn place(&mut self, id: Id, item: ItemId) {
        self.of[id.index()] = Some(item);
        if let Some(name) = self.program.graph.name(id) {
            self.sources[item as usize].get_or_insert_with(|| name.to_owned());
        }
        if let Some(name) = &self.found[id.index()] {
            self.meanings.entry(item).or_insert_with(|| name.clone());
        }
    }

    fn node(&mut self, id: Id, node: &Node) {
        if self.program.graph.is_doubled(id) {
            let item = self.doubled(id, node);
            return self.place(id, item);
        }
        let item = match node {
            Node::Constant(_) => return,
            Node::Sum(constant, terms) if terms.len() == 1 && constant.is_zero() => return,
            Node::Multiple(c, x) => {
                let multiple = self.multiple(c, *x).item;
                return self.place(id, multiple);
            }
            Node::Recip(_)
                if (self.reads[id.index()] == 1 || self.style.strict)
                    && self.program.graph.name(id).is_none() =>
            {
                return;
            }
            Node::Written(operator, x, y) => {
                let (x, y) = (self.edge(*x), self.edge(*y));
                let item = match operator {
                    Operator::Add => Item::Sum(vec![x, y]),
                    Operator::Subtract => Item::Sum(vec![x, -y]),
                    Operator::Multiply => Item::Quotient(vec![x.item, y.item], vec![]),
                    Operator::Divide => Item::Quotient(vec![x.item], vec![y.item]),
                };
                let item = self.push(item);
                self.written.insert(item);
                return self.place(id, item);
            }
            Node::Held(x) => {
                let item = self.edge(*x).item;
                return self.place(id, item);
            }
            Node::Recip(x) => return self.recip(id, *x),
            Node::Input(slot) => {
                let input = self.input(*slot);
                return self.place(id, input);
            }
            Node::Difference(first, second) => Item::Difference(self.input(*first), self.input(*second)),
            Node::Offset(slot, number) => {
                let (entry, number) = (Edge::of(self.input(*slot)), self.number(number));
                match number.negative {
                    true => Item::Difference(entry.item, number.item),
                    false => Item::Sum(vec![entry, number]),
                }
            }
            Node::Sum(constant, terms) => {
                let mut edges: Vec<Edge> = terms.iter().map(|(c, id)| self.multiple(c, *id)).collect();
                if !constant.is_zero() {
                    edges.push(self.number(constant));
                }
                if self.style.fma {
                    let factors = terms.iter().map(|(c, id)| self.factors(c, *id)).collect();
                    let sum = self.fused_sum(edges, factors);
                    return self.place(id, sum);
                }
                Item::Sum(edges)
            }
            Node::Product(factors) => {
                let product = self.product(factors);
                return self.place(id, product);
            }
            Node::Call(function, arguments) => {
                Item::Call(*function, arguments.iter().map(|x| self.edge(*x)).collect())
            }
            Node::Select(c, x, y) => Item::Select(self.item(*c), self.edge(*x), self.edge(*y)),
            Node::Known(value) => Item::Known(*value),
            Node::Compare(comparison, x, y) if x == y => Item::Known(*comparison != Comparison::Less),
            Node::Compare(comparison, x, y) => Item::Compare(*comparison, self.edge(*x), self.edge(*y)),
            Node::And(a, b) | Node::Or(a, b) => {
                let (a, b) = (self.item(*a), self.item(*b));
                let neutral = matches!(node, Node::And(..));
                match (&self.items[a as usize], &self.items[b as usize]) {
                    (Item::Known(known), _) => return self.place(id, if *known == neutral { b } else { a }),
                    (_, Item::Known(known)) => return self.place(id, if *known == neutral { a } else { b }),
                    _ if a == b => return self.place(id, a),
                    _ if neutral => Item::And(a, b),
                    _ => Item::Or(a, b),
                }
            }
            Node::Not(a) => Item::Not(self.item(*a)),
        };
        let item = self.push(item);
        self.place(id, item);
    }

    pub(super) fn input(&mut self, slot: Slot) -> ItemId {
        if let Some(input) = self.inputs.get(&slot) {
            return *input;
        }
        let input = self.push(Item::Input(slot));
        self.inputs.insert(slot, input);
        input
    }

    fn product(&mut self, factors: &[(Id, u32)]) -> ItemId {
        let (mut over, mut under) = (Vec::new(), Vec::new());
        for &(id, exponent) in factors {
            match *self.program.graph.node(id) {
                Node::Recip(x) if self.of[id.index()].is_none() || self.style.strict => {
                    let x = self.item(x);
                    self.powers_of(x, exponent, &mut under);
                }
                _ => {
                    let x = self.item(id);
                    self.powers_of(x, exponent, &mut over);
                }
            }
        }
        match (over.as_slice(), under.as_slice()) {
            ([power], []) => *power,
            _ => self.push(Item::Quotient(over, under)),
        }
    }

    /// Whether a term is a product without other readers.
    fn factors(&self, coefficient: &Exact, id: Id) -> bool {
        coefficient.is_unit()
            && self.reads[id.index()] == 1
            && self.program.graph.name(id).is_none()
            && matches!(self.program.graph.node(id), Node::Product(_))
            && !self.program.graph.is_doubled(id)
    }

    /// A sum to which products without other readers are added one by one, by fused multiply-adds.
    fn fused_sum(&mut self, edges: Vec<Edge>, single: Vec<bool>) -> ItemId {
        let fusible = |lowering: &Self, edge: &Edge| {
            matches!(&lowering.items[edge.item as usize], Item::Quotient(over, under) if over.len() > 1 && under.is_empty())
                && !lowering.powers.contains_key(&edge.item)
        };
        let single = single.into_iter().chain([false]);
        let (mut products, mut rest) = (Vec::new(), Vec::new());
        for (edge, single) in edges.into_iter().zip(single) {
            if single && fusible(self, &edge) { products.push(edge) } else { rest.push(edge) }
        }
        if rest.is_empty() {
            rest.push(products.remove(0));
        }
        let mut sum = match rest.as_slice() {
            [edge] => *edge,
            _ => Edge { item: self.push(Item::Sum(rest)), negative: false },
        };
        for product in products {
            // The product has no readers left.
            let taken = std::mem::replace(&mut self.items[product.item as usize], Item::Known(false));
            let Item::Quotient(mut factors, _) = taken else { unreachable!("just looked at") };
            let last = factors.pop().expect("a product has factors");
            let first = match factors.as_slice() {
                [factor] => *factor,
                _ => self.push(Item::Quotient(factors, vec![])),
            };
            let first = Edge { item: first, negative: product.negative };
            sum = Edge { item: self.push(Item::Fused(first, last, sum)), negative: false };
        }
        if sum.negative { self.push(Item::Sum(vec![sum])) } else { sum.item }
    }

    /// The power of a factor, or the repeated factor if the factor is in the range of floats and its power is
    /// not.
    fn powers_of(&mut self, base: ItemId, exponent: u32, factors: &mut Vec<ItemId>) {
        let valuation = self.valuations[base as usize];
        let power: Valuation = (0..exponent.min(LONGEST_APART + 1)).map(|_| valuation).sum();
        if exponent > LONGEST_APART || power.is_held() || !valuation.is_held() {
            factors.push(self.power(base, exponent));
        } else {
            factors.extend(std::iter::repeat_n(base, exponent as usize));
        }
    }

    fn power(&mut self, base: ItemId, exponent: u32) -> ItemId {
        if exponent == 1 {
            return base;
        }
        if let Some(power) = self.power.get(&(base, exponent)) {
            return *power;
        }
        // Collect the missing smaller powers, then compute them upwards: no recursion.
        let mut needed = vec![exponent];
        while let Some(&n) = needed.last() {
            let (long, short) = self.chains.split(n);
            match [long, short].into_iter().find(|&m| m > 1 && !self.power.contains_key(&(base, m))) {
                Some(missing) => needed.push(missing),
                None => {
                    let factor = |m: u32| if m == 1 { base } else { self.power[&(base, m)] };
                    let factors = vec![factor(long), factor(short)];
                    let power = self.push(Item::Quotient(factors, vec![]));
                    self.power.insert((base, n), power);
                    self.powers.insert(power, (base, n));
                    needed.pop();
                }
            }
        }
        self.power[&(base, exponent)]
    }
}

/// Shortest chains of multiplications, by Knuth's power tree (The Art of Computer Programming, 4.6.3): xⁿ is
/// x^long · x^short, and both factors lie on the path from x to xⁿ.
struct Chains {
    parent: Vec<u32>,
}

impl Chains {
    /// The tree is optimal for every exponent below 77; larger exponents are halved.
    const REACH: u32 = 77;

    fn new() -> Chains {
        let mut parent = vec![0; Chains::REACH as usize];
        parent[1] = 1;
        let mut level = vec![1u32];
        while !level.is_empty() {
            let mut next = Vec::new();
            for &n in &level {
                let mut path = vec![n];
                while path[path.len() - 1] != 1 {
                    path.push(parent[path[path.len() - 1] as usize]);
                }
                for &step in path.iter().rev() {
                    let sum = n + step;
                    if sum < Chains::REACH && parent[sum as usize] == 0 {
                        parent[sum as usize] = n;
                        next.push(sum);
                    }
                }
            }
            level = next;
        }
        Chains { parent }
    }

    fn split(&self, n: u32) -> (u32, u32) {
        let long = if n < Chains::REACH { self.parent[n as usize] } else { n - n / 2 };
        (long, n - long)
    }
}

#[cfg(test)]
mod tests {
    use super::Chains;

    #[test]
    fn chains_are_shortest() {
        // Lengths of shortest addition chains, OEIS A003313.
        let shortest =
            [0, 1, 2, 2, 3, 3, 4, 3, 4, 4, 5, 4, 5, 5, 5, 4, 5, 5, 6, 5, 6, 6, 6, 5, 6, 6, 6, 6, 7, 6];
        let chains = Chains::new();
        for (n, length) in (1u32..).zip(shortest) {
            let mut needed = std::collections::BTreeSet::from([n]);
            let mut steps = 0;
            while let Some(m) = needed.pop_last().filter(|&m| m > 1) {
                let (long, short) = chains.split(m);
                needed.extend([long, short]);
                steps += 1;
            }
            assert_eq!(steps, length, "x^{n}");
        }
    }
}
