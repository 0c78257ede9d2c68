//! Descriptive names of temporaries: unique, plain identifiers of C, C++ and Rust.
//!
//! In: items. Out: a name for every item on a line of its own, if the source suggests one: the author's name,
//! the output it is stored to, the argument entry it loads, or a name built from its operands (`inv_length`,
//! `sin_angle`, `k_x`). The scheduler numbers the other temporaries within the statement they serve, so that
//! an edit elsewhere in the source does not rename them.

use crate::math::exact::Exact;
use crate::math::number::Comparison;
use crate::model::bodies::{Role, Signature, Slot};
use crate::model::outputs::Output;
use crate::names::{Arguments, Target, is_no_local, spelled};
use crate::schedule::items::{Edge, Item, ItemId, Items};
use rustc_hash::{FxHashMap, FxHashSet};

/// The longest name of a temporary; the middle of a longer name is cut out.
const LONGEST: usize = 27;

/// The longest stem of a numbered name.
const LONGEST_STEM: usize = 18;

/// The name of a temporary: shortened, without outer underscores. All targets spell temporaries alike.
fn tidy(name: &str) -> String {
    let text = spelled(name, Target::Rust);
    let text = text.trim_matches('_');
    let digit = text.starts_with(|c: char| c.is_ascii_digit());
    shorten(&if digit { format!("x{text}") } else { text.to_owned() }, LONGEST)
}

/// A name of at most the given length: the middle of a longer name is cut out.
fn shorten(name: &str, longest: usize) -> String {
    if name.len() <= longest {
        return name.to_owned();
    }
    let half = longest / 2;
    let (head, tail) =
        (name[..half].trim_end_matches('_'), name[name.len() - half..].trim_start_matches('_'));
    format!("{head}_{tail}")
}

/// The approximate length of the numbered names of a part.
pub(super) fn part_width(of: &str) -> usize {
    of.len().min(LONGEST_STEM) + "_p100".len()
}

/// The names already in use.
pub(super) struct Taken {
    names: FxHashSet<String>,
    /// The number to try next after a name in use.
    next: FxHashMap<String, u32>,
}

impl Taken {
    /// The names of bodies, extra arguments and loop variables.
    pub(super) fn by(signature: &Signature) -> Taken {
        let arguments = Target::ALL.into_iter().map(|target| Arguments::new(signature, target));
        let arguments = arguments.flat_map(|arguments| arguments.bodies.into_iter().chain(arguments.extras));
        let names = arguments.chain(["i", "j", "column", "lane"].map(str::to_owned)).collect();
        Taken { names, next: FxHashMap::default() }
    }

    /// The name itself if it is free, else the name with the first number that makes it unique.
    pub(super) fn claim(&mut self, name: &str) -> String {
        let name = tidy(name);
        if self.is_free(&name) {
            return name;
        }
        self.numbered(&format!("{name}_"), 2)
    }

    /// A name for a part of a named value: the name, `_p` and the first number that makes the result unique.
    pub(super) fn part(&mut self, of: &str) -> String {
        self.numbered(&format!("{}_p", shorten(&tidy(of), LONGEST_STEM)), 1)
    }

    /// The stem with the first number that makes the name unique.
    fn numbered(&mut self, stem: &str, first: u32) -> String {
        let mut number = self.next.get(stem).copied().unwrap_or(first);
        loop {
            let name = format!("{stem}{number}");
            number += 1;
            if self.is_free(&name) {
                self.next.insert(stem.to_owned(), number);
                return name;
            }
        }
    }

    fn is_free(&mut self, name: &str) -> bool {
        !is_no_local(name) && self.names.insert(name.to_owned())
    }
}

/// The name of an output: `force_a_x`, `dfdx_a_ry_b_x`; with numeric indices where the names of the bodies
/// are long.
pub(super) fn output_name(signature: &Signature, output: Output) -> String {
    let name = output.named(signature).replace(['.', '['], "_").replace(']', "");
    let Output { part, row, column } = output;
    match name.len() {
        ..=LONGEST_STEM => name,
        _ => {
            let stem = part.stem(signature);
            if part.is_list() { format!("{stem}_{row}") } else { format!("{stem}_{row}_{column}") }
        }
    }
}

/// Names derived from the source, for the items on lines of their own.
pub(super) fn assign(
    signature: &Signature,
    items: &Items,
    own_line: &[bool],
    flipped: &[bool],
    taken: &mut Taken,
) -> Vec<Option<String>> {
    let count = items.items.len();
    let mut names: Vec<Option<String>> = vec![None; count];
    for (name, source) in names.iter_mut().zip(&items.sources) {
        *name = source.as_ref().map(|source| taken.claim(source));
    }
    for (output, edge) in &items.outputs {
        let item = edge.item as usize;
        let positive = edge.negative == flipped[item];
        let computed = !matches!(items.items[item], Item::Input(_) | Item::Difference(..));
        if own_line[item] && positive && computed && names[item].is_none() {
            names[item] = Some(taken.claim(&output_name(signature, *output)));
        }
    }
    let mut bases: Vec<Option<DerivedName>> = vec![None; count];
    for item in 0..count {
        let derived = match &names[item] {
            Some(name) if items.sources[item].is_some() => Some(DerivedName::source(name.clone())),
            Some(_) => None,
            None if flipped[item] && !matches!(items.items[item], Item::Sum(_) | Item::Difference(..)) => {
                None
            }
            None => derived_name(signature, items, &bases, flipped, item as ItemId),
        };
        if own_line[item] && names[item].is_none() {
            names[item] = derived.as_ref().map(|derived| taken.claim(&derived.name));
        }
        bases[item] = derived;
    }
    names
}

/// The name of a loaded entry: `a_q_x`, `arm_a_x`, `m_0_1`.
fn slot_name(signature: &Signature, slot: Slot) -> String {
    let name = signature.slot_name(slot);
    let name = match (signature.role(slot), name.split_once('.')) {
        (Some(role), Some((body, entry))) => {
            let letter = match role {
                Role::Position => "p",
                Role::Orientation => "q",
                Role::Velocity => "v",
                Role::AngularVelocity => "w",
            };
            format!("{body}_{letter}_{}", entry.rsplit('.').next().unwrap_or_default())
        }
        _ => name,
    };
    name.replace(['.', '['], "_").replace(']', "")
}

/// A name built from the operands of an item, and the length that is assumed for the name.
#[derive(Clone)]
struct DerivedName {
    name: String,
    /// The assumed length of an author's name is constant, so that renaming a value does not change other
    /// names.
    length: usize,
}

impl DerivedName {
    /// A longer derived name is rejected.
    const SHORT: usize = 20;

    /// A name chosen by the author.
    fn source(name: String) -> DerivedName {
        const LENGTH: usize = 7;
        DerivedName { name, length: LENGTH }
    }

    fn plain(name: impl Into<String>) -> DerivedName {
        let name = name.into();
        DerivedName { length: name.len(), name }
    }

    fn and(&self, text: &str) -> DerivedName {
        DerivedName { name: format!("{}{text}", self.name), length: self.length + text.len() }
    }

    fn then(self, other: &DerivedName) -> DerivedName {
        DerivedName { name: self.name + &other.name, length: self.length + other.length }
    }
}

/// The name of a product of two entries of one quaternion, `a_q_xy`.
fn quaternion_product(signature: &Signature, items: &Items, x: ItemId, y: ItemId) -> Option<String> {
    let [&Item::Input(first), &Item::Input(second)] = [x, y].map(|id| &items.items[id as usize]) else {
        return None;
    };
    let is_quaternion = signature.role(first) == Some(Role::Orientation);
    let (first, second) = if first.offset <= second.offset { (first, second) } else { (second, first) };
    if !is_quaternion || (first.argument, first.field) != (second.argument, second.field) {
        return None;
    }
    let second = slot_name(signature, second);
    Some(slot_name(signature, first) + second.rsplit('_').next().unwrap_or_default())
}

/// A name built from the operands of an item, if the name is short.
fn derived_name(
    signature: &Signature,
    items: &Items,
    bases: &[Option<DerivedName>],
    flipped: &[bool],
    item: ItemId,
) -> Option<DerivedName> {
    let base = |id: ItemId| if flipped[id as usize] { None } else { bases[id as usize].as_ref() };
    let flipped = flipped[item as usize];
    let derived = match &items.items[item as usize] {
        Item::Input(slot) => {
            return Some(DerivedName::plain(tidy(&slot_name(signature, *slot))));
        }
        Item::Difference(first, second) => {
            let (first, second) = if flipped { (second, first) } else { (first, second) };
            let [&Item::Input(to), Item::Input(from)] = [first, second].map(|id| &items.items[*id as usize])
            else {
                return None;
            };
            let body = &signature.bodies.get(from.argument as usize)?.name;
            let name = slot_name(signature, to).replacen('_', &format!("_minus_{body}_"), 1);
            return Some(DerivedName::plain(tidy(&name.replace("_p_", "_"))));
        }
        Item::Quotient(..) if items.powers.contains_key(&item) => {
            let (of, exponent) = items.powers[&item];
            match exponent {
                2 => base(of)?.and("_sq"),
                _ => base(of)?.and(&format!("_pow{exponent}")),
            }
        }
        Item::Quotient(over, under) => match (over.as_slice(), under.as_slice()) {
            ([], [x]) => DerivedName::plain("inv_").then(base(*x)?),
            ([x], [y]) => base(*x)?.and("_per_").then(base(*y)?),
            ([x, y], []) => match &items.items[*x as usize] {
                Item::Number(number) if *number == Exact::from(2) => {
                    DerivedName::plain("two_").then(base(*y)?)
                }
                Item::Number(number) if *number == Exact::ratio(1, 2) => {
                    DerivedName::plain("half_").then(base(*y)?)
                }
                _ => match quaternion_product(signature, items, *x, *y) {
                    Some(name) => return Some(DerivedName::plain(tidy(&name))),
                    None => base(*x)?.and("_").then(base(*y)?),
                },
            },
            _ => return None,
        },
        Item::Call(function, arguments) if function.order().is_none() => match arguments.as_slice() {
            [x] if !x.negative => DerivedName::plain(format!("{}_", function.row().name)).then(base(x.item)?),
            _ => return None,
        },
        Item::Sum(edges) => match edges.as_slice() {
            [x, y] => {
                let (x, y) = if x.negative != flipped { (y, x) } else { (x, y) };
                if x.negative != flipped {
                    return None;
                }
                let sign = if y.negative != flipped { "_minus_" } else { "_plus_" };
                base(x.item)?.and(sign).then(base(y.item)?)
            }
            _ => return None,
        },
        Item::Compare(Comparison::Less, x, y) => {
            let zero =
                |edge: &Edge| matches!(&items.items[edge.item as usize], Item::Number(n) if n.is_zero());
            match (x.negative, y.negative) {
                (false, false) if zero(y) => base(x.item)?.and("_negative"),
                (true, false) if zero(y) => base(x.item)?.and("_positive"),
                (false, false) => base(x.item)?.and("_below_").then(base(y.item)?),
                _ => return None,
            }
        }
        _ => return None,
    };
    (derived.length <= DerivedName::SHORT).then_some(derived)
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, Taken};
    use crate::model::bodies::Signature;

    #[test]
    fn names_are_plain_unique_and_free() {
        let mut taken = Taken::by(&Signature::default());
        for (name, expected) in [
            ("pa_x", "pa_x"),
            ("pa_x", "pa_x_2"),
            ("pa_x_2", "pa_x_2_2"),
            ("y0", "y0_2"),
            ("int", "int_2"),
            ("match", "match_2"),
            ("sinf", "sinf_2"),
            ("cos_sqrt_1", "cos_sqrt_1_2"),
            ("x_f64", "x_f64_2"),
            ("restLength", "rest_length"),
            ("__K__t", "k_t"),
            ("3d", "x3d"),
        ] {
            assert_eq!(taken.claim(name), expected, "{name}");
        }
        assert!(taken.claim("a_name_of_more_than_twenty_seven_letters").len() <= LONGEST);
        assert_eq!(taken.part("pa_x"), "pa_x_p1");
        assert_eq!(taken.part("pa_x"), "pa_x_p2");
    }
}
