//! Descriptive names of temporaries: unique, plain identifiers of C, C++ and Rust.
//!
//! In: items and expressions. Out: a name for every value on a line of its own, if the source suggests one: the
//! author's name, the output it is stored to, a value that the source speaks of, the argument entry it loads,
//! or a name built from its operands (`inv_length`, `sin_angle`, `k_x`). The scheduler numbers the other temporaries within the statement they serve, so that
//! an edit elsewhere in the source does not rename them.

use crate::math::exact::Exact;
use crate::math::number::Comparison;
use crate::model::bodies::Signature;
use crate::model::outputs::Output;
use crate::names::values::{ValueName, difference_name, entry_name, flat};
use crate::names::{Arguments, Target, is_no_local, spelled};
use crate::schedule::items::{Item, ItemId, Items};
use crate::schedule::{Expression, Name};
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
    let name = flat(&output.named(signature));
    let Output { part, row, column } = output;
    match name.len() {
        ..=LONGEST_STEM => name,
        _ => {
            let stem = part.stem(signature);
            if part.is_list() { format!("{stem}_{row}") } else { format!("{stem}_{row}_{column}") }
        }
    }
}

/// The names of items that are known before their statements: the author's names, names of outputs, and names
/// of values that the source speaks of. The scheduler derives the other names.
pub(super) fn assign(
    signature: &Signature,
    items: &Items,
    own_line: &[bool],
    flipped: &[bool],
    taken: &mut Taken,
) -> Vec<Option<String>> {
    let mut names: Vec<Option<String>> = vec![None; items.items.len()];
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
    for (item, name) in names.iter_mut().enumerate().filter(|(item, _)| own_line[*item]) {
        if let Some(meaning) = items.meanings.get(&(item as ItemId)).filter(|_| name.is_none()) {
            let meaning = if flipped[item] { meaning.opposite() } else { meaning.clone() };
            *name = Some(taken.claim(&meaning.text));
        }
    }
    names
}

/// A name built from the operands of an expression, if the name is short; `variable` gives the name of a
/// temporary.
pub(super) fn derived_name<'n>(
    signature: &Signature,
    variable: &dyn Fn(Name) -> Option<&'n ValueName>,
    value: &Expression,
) -> Option<ValueName> {
    let of = |value: &Expression| derived_name(signature, variable, value);
    let name = match value {
        Expression::Input(slot) => return Some(ValueName::plain(tidy(&entry_name(signature, *slot)))),
        Expression::Name(name) => variable(*name)?.clone(),
        Expression::Negative(x) => of(x)?.opposite(),
        Expression::Difference(pair) => {
            let [Expression::Input(to), Expression::Input(from)] = &**pair else { return None };
            let name = entry_name(signature, *to);
            let axis = name.rsplit('_').next()?;
            let name = format!("{}_{axis}", difference_name(signature, *to, *from)?);
            return Some(ValueName::plain(tidy(&name)));
        }
        Expression::Quotient(over, under) => match (over.as_slice(), under.as_slice()) {
            ([], [x]) => of(x)?.power(-1),
            ([x], [y]) => of(x)?.join("_per_", &of(y)?),
            ([Expression::Literal(number), y], []) if *number == Exact::from(2) => of(y)?.after("two_"),
            ([Expression::Literal(number), y], []) if *number == Exact::ratio(1, 2) => of(y)?.after("half_"),
            ([x, y], []) => {
                if let Some(name) = quaternion_product(signature, variable, [x, y]) {
                    return Some(ValueName::plain(tidy(&name)));
                }
                of(x)?.times(&of(y)?)
            }
            _ => return None,
        },
        Expression::Call(function, arguments) => match arguments.as_slice() {
            [x] => of(x)?.call(*function)?,
            _ => return None,
        },
        Expression::Sum(terms) => match terms.as_slice() {
            [(false, x), (negative, y)] => of(x)?.join(if *negative { "_minus_" } else { "_plus_" }, &of(y)?),
            _ => return None,
        },
        Expression::Compare(Comparison::Less, pair) => {
            let zero = |side: &Expression| matches!(side, Expression::Literal(n) if n.is_zero());
            let [x, y] = &**pair;
            match (zero(x), zero(y)) {
                (_, true) => of(x)?.and("_negative"),
                (true, _) => of(y)?.and("_positive"),
                _ => of(x)?.join("_below_", &of(y)?),
            }
        }
        _ => return None,
    };
    name.short()
}

/// The name of a product of two entries of one quaternion, `a_q_xy`.
fn quaternion_product<'n>(
    signature: &Signature,
    variable: &dyn Fn(Name) -> Option<&'n ValueName>,
    factors: [&Expression; 2],
) -> Option<String> {
    let entry = |factor: &Expression| derived_name(signature, variable, factor).map(|name| name.text);
    let [x, y] = [entry(factors[0])?, entry(factors[1])?];
    let ((of, first), (other, second)) = (x.rsplit_once('_')?, y.rsplit_once('_')?);
    let is_quaternion = signature.bodies.iter().any(|body| of.strip_prefix(&body.name) == Some("_q"));
    let (first, second) = if first < second || second == "w" { (first, second) } else { (second, first) };
    let single = first.len() == 1 && second.len() == 1 && first != second;
    (is_quaternion && of == other && single).then(|| format!("{of}_{first}{second}"))
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
