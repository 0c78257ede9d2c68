//! Values in doubled precision: the marked nodes of a program as pairs of items, high + low.
//!
//! In: a marked node. Out: its pair, and the item that is the rounded sum of the pair; unmarked nodes read
//! this item. The rounding error of a sum is computed by Knuth's exact sum of two numbers, that of a product
//! by a fused multiply-add (Ogita, Rump and Oishi, Accurate sum and dot product, 2005). Low parts are added
//! with ordinary rounding, and pairs are not renormalised (Lange and Rump, Faithfully rounded floating-point
//! computations, 2020). The result is correct whichever operations a compiler contracts: every product whose
//! rounding error matters is an operand of a fused multiply-add and is therefore computed, and no exact sum
//! reads a product that is not.

use crate::math::exact::Exact;
use crate::math::functions::{Function, Operator};
use crate::scalar::{Id, Node};
use crate::schedule::items::{Edge, Item, ItemId, Lowering};

/// high + low; without a low part the value is the high part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    high: Edge,
    low: Option<Edge>,
}

impl Pair {
    fn negative(self) -> Pair {
        Pair { high: -self.high, low: self.low.map(|low| -low) }
    }
}

impl std::ops::Neg for Edge {
    type Output = Edge;
    fn neg(self) -> Edge {
        Edge { negative: !self.negative, ..self }
    }
}

impl Edge {
    pub(super) fn of(item: ItemId) -> Edge {
        Edge { item, negative: false }
    }

    fn signed(self, negative: bool) -> Edge {
        Edge { negative: self.negative ^ negative, ..self }
    }
}

impl Lowering<'_> {
    /// Lowers a marked node to a pair, and to the item that unmarked nodes read.
    pub(super) fn doubled(&mut self, id: Id, node: &Node) -> ItemId {
        let pair = match node {
            Node::Difference(first, second) => {
                let [first, second] = [*first, *second].map(|slot| Edge::of(self.input(slot)));
                let high = self.push(Item::Difference(first.item, second.item));
                let low = self.lost(first, -second, high);
                Pair { high: Edge::of(high), low: Some(low) }
            }
            Node::Offset(slot, number) => {
                let pairs = [Edge::of(self.input(*slot)), self.number(number)];
                self.sum_of(&pairs.map(|high| Pair { high, low: None }))
            }
            Node::Sum(constant, terms) => {
                let mut pairs: Vec<Pair> = terms.iter().map(|(c, x)| self.scaled_pair(c, *x)).collect();
                if !constant.is_zero() {
                    pairs.push(Pair { high: self.number(constant), low: None });
                }
                self.sum_of(&pairs)
            }
            Node::Product(factors) => {
                let factors = factors.iter().flat_map(|(x, n)| std::iter::repeat_n(*x, *n as usize));
                let pairs: Vec<Pair> = factors.map(|x| self.pair(x)).collect();
                let (first, rest) = pairs.split_first().expect("a product has factors");
                rest.iter().fold(*first, |product, x| self.product_of(product, *x))
            }
            Node::Multiple(c, x) => self.scaled_pair(c, *x),
            Node::Held(x) => self.pair(*x),
            Node::Written(operator, x, y) => {
                let (x, y) = (self.pair(*x), self.pair(*y));
                match operator {
                    Operator::Add => self.sum_of(&[x, y]),
                    Operator::Subtract => self.sum_of(&[x, y.negative()]),
                    Operator::Multiply => self.product_of(x, y),
                    Operator::Divide => self.quotient_of(x, y),
                }
            }
            Node::Recip(x) => {
                let one = Pair { high: self.number(&Exact::ONE), low: None };
                let x = self.pair(*x);
                self.quotient_of(one, x)
            }
            Node::Call(Function::Sqrt, x) => {
                let x = self.pair(x[0]);
                self.root_of(x)
            }
            Node::Select(c, x, y) => {
                let condition = self.item(*c);
                let (x, y) = (self.pair(*x), self.pair(*y));
                let high = self.push(Item::Select(condition, x.high, y.high));
                let low = (x.low.is_some() || y.low.is_some()).then(|| {
                    let zero = self.number(&Exact::ZERO);
                    let (x, y) = (x.low.unwrap_or(zero), y.low.unwrap_or(zero));
                    Edge::of(self.push(Item::Select(condition, x, y)))
                });
                Pair { high: Edge::of(high), low }
            }
            _ => unreachable!("{node:?} is never marked"),
        };
        self.pairs.insert(id, pair);
        match pair.low {
            None if !pair.high.negative => pair.high.item,
            low => self.push(Item::Sum([pair.high].into_iter().chain(low).collect())),
        }
    }

    /// A node as a pair.
    fn pair(&mut self, id: Id) -> Pair {
        let (coefficient, rest) = self.program.graph.split(id);
        if self.program.graph.value(rest).is_some() {
            return Pair { high: self.edge(id), low: None };
        }
        self.scaled_pair(&coefficient, rest)
    }

    /// coefficient · node
    fn scaled_pair(&mut self, coefficient: &Exact, id: Id) -> Pair {
        let pair = match self.pairs.get(&id) {
            Some(pair) => *pair,
            None => Pair { high: Edge::of(self.item(id)), low: None },
        };
        let scaled = match (coefficient.is_unit(), coefficient.whole()) {
            (true, _) => pair,
            // Scaling by a power of two is exact.
            (_, Some((over, under))) if [&over, &under].iter().all(|n| is_power_of_two(n)) => {
                let number = self.number(&coefficient.abs()).item;
                let mut times = |edge: Edge| {
                    let item = self.push(Item::Quotient(vec![number, edge.item], vec![]));
                    Edge { item, ..edge }
                };
                Pair { high: times(pair.high), low: pair.low.map(times) }
            }
            (_, Some((over, under))) => {
                let over = Pair { high: self.number(&over), low: None };
                let product =
                    if over.high == self.number(&Exact::ONE) { pair } else { self.product_of(over, pair) };
                let under = Pair { high: self.number(&under), low: None };
                if under.high == self.number(&Exact::ONE) {
                    product
                } else {
                    self.quotient_of(product, under)
                }
            }
            _ => {
                let number = Pair { high: self.number(&coefficient.abs()), low: None };
                self.product_of(number, pair)
            }
        };
        if coefficient.is_negative() { scaled.negative() } else { scaled }
    }

    fn sum_of(&mut self, pairs: &[Pair]) -> Pair {
        let mut lows: Vec<Edge> = pairs.iter().filter_map(|pair| pair.low).collect();
        let mut high = pairs[0].high;
        for pair in &pairs[1..] {
            let (sum, low) = self.exact_sum(high, pair.high);
            lows.push(low);
            high = sum;
        }
        let low = match lows.as_slice() {
            [] => None,
            [low] => Some(*low),
            _ => Some(Edge::of(self.push(Item::Sum(lows)))),
        };
        Pair { high, low }
    }

    /// The rounded sum x + y and its rounding error.
    fn exact_sum(&mut self, x: Edge, y: Edge) -> (Edge, Edge) {
        // The rounding error of −x − y is the negative of the rounding error of x + y.
        let turn = x.negative;
        let (x, y) = (x.signed(turn), y.signed(turn));
        let sum = self.push(Item::Sum(vec![x, y]));
        let low = self.lost(x, y, sum);
        (Edge::of(sum).signed(turn), low.signed(turn))
    }

    /// The rounding error of a sum of two: (x − (sum − (sum − x))) + (y − (sum − x)).
    fn lost(&mut self, x: Edge, y: Edge, sum: ItemId) -> Edge {
        let sum = Edge::of(sum);
        let second = Edge::of(self.push(Item::Sum(vec![sum, -x])));
        let first = Edge::of(self.push(Item::Sum(vec![sum, -second])));
        let of_first = Edge::of(self.push(Item::Sum(vec![x, -first])));
        // −y − second is the negative of a sum.
        let (turn, y) = (y.negative, Edge::of(y.item));
        let of_second = Edge::of(self.push(Item::Sum(vec![y, second.signed(!turn)]))).signed(turn);
        Edge::of(self.push(Item::Sum(vec![of_first, of_second])))
    }

    /// x y + z with one rounding.
    fn fused(&mut self, x: Edge, y: Edge, z: Edge) -> Edge {
        let negative = x.negative ^ y.negative;
        Edge::of(self.push(Item::Fused(Edge { negative, ..x }, y.item, z)))
    }

    fn product_of(&mut self, x: Pair, y: Pair) -> Pair {
        let high = self.push(Item::Quotient(vec![x.high.item, y.high.item], vec![]));
        let high = Edge { item: high, negative: x.high.negative ^ y.high.negative };
        let mut low = self.fused(x.high, y.high, -high);
        for (low_factor, other) in [(x.low, y.high), (y.low, x.high)] {
            if let Some(factor) = low_factor {
                low = self.fused(factor, other, low);
            }
        }
        Pair { high, low: Some(low) }
    }

    /// Renormalises a pair: the low part becomes smaller than the rounding of the high part.
    fn normal(&mut self, pair: Pair) -> Pair {
        match pair.low {
            Some(low) => {
                let (high, low) = self.exact_sum(pair.high, low);
                Pair { high, low: Some(low) }
            }
            None => pair,
        }
    }

    fn quotient_of(&mut self, x: Pair, y: Pair) -> Pair {
        let (x, y) = (self.normal(x), self.normal(y));
        let high = self.push(Item::Quotient(vec![x.high.item], vec![y.high.item]));
        let high = Edge { item: high, negative: x.high.negative ^ y.high.negative };
        let mut rest = self.fused(-high, y.high, x.high);
        if let Some(low) = y.low {
            rest = self.fused(-high, low, rest);
        }
        if let Some(low) = x.low {
            rest = Edge::of(self.push(Item::Sum(vec![rest, low])));
        }
        let low = self.push(Item::Quotient(vec![rest.item], vec![y.high.item]));
        Pair { high, low: Some(Edge { item: low, negative: rest.negative ^ y.high.negative }) }
    }

    fn root_of(&mut self, x: Pair) -> Pair {
        let x = self.normal(x);
        let root = Edge::of(self.push(Item::Call(Function::Sqrt, vec![x.high])));
        let mut rest = self.fused(-root, root, x.high);
        if let Some(low) = x.low {
            rest = Edge::of(self.push(Item::Sum(vec![rest, low])));
        }
        let two = self.number(&Exact::from(2));
        let low = self.push(Item::Quotient(vec![rest.item], vec![two.item, root.item]));
        Pair { high: root, low: Some(Edge::of(low)) }
    }
}

fn is_power_of_two(number: &Exact) -> bool {
    number.to_i64().is_some_and(|n| n > 0 && n & (n - 1) == 0)
}
