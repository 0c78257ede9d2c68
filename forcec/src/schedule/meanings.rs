//! Names by value: which values of a kernel are values that the source speaks of.
//!
//! In: the vocabulary of a function. Out: for the values that an expression has at a few random states, the
//! name of the scalar that has the same values up to sign. Formulas are not compared, so that it does not
//! matter how the optimiser rewrote them. A coincidence would give a misleading name, never a wrong result.

use crate::lower::vocabulary::Vocabulary;
use crate::math::random::Random;
use crate::model::bodies::{Signature, Slot};
use crate::names::values::ValueName;
use crate::sample::inputs::Places;
use crate::sample::states::{Family, draw, seed};
use crate::scalar::eval::{self, Value};
use crate::scalar::{Graph, Node};
use rustc_hash::FxHashMap;

/// The number of states.
pub(super) const STATES: usize = 16;

/// The value of an expression at each state.
pub(super) type Values = [Value<f64>; STATES];

/// The values of the entries of arguments at each state.
pub(super) type Inputs = FxHashMap<Slot, [f64; STATES]>;

/// The names of values.
#[derive(Default)]
pub struct Meanings {
    /// The entries of arguments at each state, by their names in messages.
    inputs: FxHashMap<String, [f64; STATES]>,
    /// Sorted by key.
    words: Vec<Word>,
}

struct Word {
    key: f64,
    /// The first value that is not zero is positive.
    values: [f64; STATES],
    /// Position in the vocabulary.
    rank: usize,
    name: ValueName,
}

impl Meanings {
    /// Evaluates a vocabulary; `gains` says that the last two parameters are the stiffness and damping of a
    /// constraint.
    pub fn new(vocabulary: &Vocabulary, gains: bool) -> Meanings {
        let places = Places::new(&vocabulary.signature);
        let states: [Vec<f64>; STATES] = std::array::from_fn(|number| {
            let mut random = Random::new(seed(2, Family::Random, number as u64));
            draw(&places, gains, Family::Random, number, &mut random).values
        });
        let inputs = (places.slots())
            .map(|slot| {
                let place = places.place(slot);
                (vocabulary.signature.slot_name(slot), states.each_ref().map(|state| state[place]))
            })
            .collect();
        let mut meanings = Meanings { inputs, words: Vec::new() };
        let values = meanings.values(&vocabulary.signature, &vocabulary.graph);
        let mut words: Vec<Word> = Vec::new();
        for (rank, (name, id)) in vocabulary.words.iter().enumerate() {
            // An argument and its multiples have names already.
            let (_, core) = vocabulary.graph.split(*id);
            let computed = !matches!(vocabulary.graph.node(core), Node::Constant(_) | Node::Input(_));
            if let Some((values, negative)) = canonical(&values[id.index()]).filter(|_| computed) {
                let name = if negative { name.opposite() } else { name.clone() };
                words.push(Word { key: key(&values), values, rank, name });
            }
        }
        words.sort_by(|x, y| x.key.total_cmp(&y.key));
        meanings.words = words;
        meanings
    }

    /// The values of every entry of a signature's arguments; NaN for those that the vocabulary does not have.
    pub(super) fn inputs(&self, signature: &Signature) -> Inputs {
        let values = |slot: Slot| match signature.known(slot) {
            Some(value) => [value.to_f64(); STATES],
            None => self.inputs.get(&signature.slot_name(slot)).copied().unwrap_or([f64::NAN; STATES]),
        };
        Places::new(signature).slots().map(|slot| (slot, values(slot))).collect()
    }

    /// The values of every node of a graph.
    fn values(&self, signature: &Signature, graph: &Graph) -> Vec<Values> {
        let inputs = self.inputs(signature);
        let states: [Vec<Value<f64>>; STATES] =
            std::array::from_fn(|state| eval::values(graph, &|slot| inputs[&slot][state]));
        (0..graph.len()).map(|index| states.each_ref().map(|values| values[index].clone())).collect()
    }

    /// The name of each node of a graph, if it has one.
    pub(super) fn of_nodes(&self, signature: &Signature, graph: &Graph) -> Vec<Option<ValueName>> {
        if self.words.is_empty() {
            return vec![None; graph.len()];
        }
        self.values(signature, graph).iter().map(|values| self.find(values)).collect()
    }

    /// Whether it has no names.
    pub(super) fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// The name of a value, if it has one.
    pub(super) fn find(&self, values: &Values) -> Option<ValueName> {
        let (values, negative) = canonical(values)?;
        let key = key(&values);
        let near = |x: f64, y: f64| (x - y).abs() <= 1e-10 * (x.abs() + y.abs());
        let size = values.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let first = self.words.partition_point(|word| word.key < key - 1e-9 * size);
        let candidates = self.words[first..].iter().take_while(|word| word.key <= key + 1e-9 * size);
        let same = |word: &&Word| word.values.iter().zip(&values).all(|(x, y)| near(*x, *y));
        let word = candidates.filter(same).min_by_key(|word| word.rank)?;
        Some(if negative { word.name.opposite() } else { word.name.clone() })
    }
}

/// Values with a positive first one, and whether their sign was changed; `None` if fewer than two are not
/// zero, or all are equal, as those of a number, or one is not finite.
fn canonical(values: &Values) -> Option<([f64; STATES], bool)> {
    let mut numbers = [0.0; STATES];
    for (number, value) in numbers.iter_mut().zip(values) {
        match value {
            Value::Real(x) if x.is_finite() => *number = *x,
            _ => return None,
        }
    }
    let telling = numbers.iter().filter(|x| **x != 0.0).count();
    if telling < 2 || numbers.iter().all(|x| *x == numbers[0]) {
        return None;
    }
    let negative = numbers.iter().find(|x| **x != 0.0).is_some_and(|x| *x < 0.0);
    Some((numbers.map(|x| if negative { -x } else { x }), negative))
}

/// A number by which equal values are found.
fn key(values: &[f64; STATES]) -> f64 {
    values.iter().fold(0.0, |sum, x| 0.8125 * sum + x)
}
