//! The options of kernels: a [`Request`], and the table of the options that change it.
//!
//! A row describes an option: its name, its form, its values and how it reads them. The command line,
//! attributes, scene files and build scripts have their own notations; the names and meanings of options and
//! the errors about wrong values are defined here.

pub mod plan;
pub mod specialize;

use crate::layout::{LANES, Layout};
use crate::math::number::Precision;
use crate::model::outputs::Part;
use crate::names::Target;
use crate::options::plan::{Effort, Mode, Plan};
use crate::options::specialize::Specialization;
use crate::source::suggest;

/// A request for kernels.
#[derive(Clone, PartialEq, Debug)]
pub struct Request {
    /// Effort and mode of the optimiser.
    pub plan: Plan,
    /// Fixed bodies and known parameters.
    pub known: Specialization,
    /// The outputs of kernels, in the order of the table, unless the layout determines them.
    pub outputs: Vec<Part>,
    /// The output layout.
    pub layout: Layout,
    /// Number of instances that a kernel computes at once.
    pub lanes: usize,
    /// Whether values that depend on parameters alone are computed once, by a separate function.
    pub prepare: bool,
    /// Precisions to print; if empty, the caller decides.
    pub precisions: Vec<Precision>,
    /// Languages to print; if empty, the caller decides.
    pub targets: Vec<Target>,
    /// Whether the request overrides the attributes of functions.
    pub settled: bool,
}

impl Default for Request {
    fn default() -> Request {
        Request {
            plan: Plan::default(),
            known: Specialization::default(),
            outputs: Part::DEFAULT.to_vec(),
            layout: Layout::Dense,
            lanes: 1,
            prepare: false,
            precisions: Vec::new(),
            targets: Vec::new(),
            settled: false,
        }
    }
}

impl Request {
    /// The outputs that kernels compute, in the order of the table.
    pub fn parts(&self) -> &[Part] {
        self.layout.row().computes.unwrap_or(&self.outputs)
    }

    /// Applies choices; later ones replace earlier ones, but fixed bodies and values accumulate.
    pub fn with<'c>(mut self, choices: impl IntoIterator<Item = &'c Choice>) -> Request {
        for choice in choices {
            match choice {
                Choice::Effort(effort) => self.plan.effort = *effort,
                Choice::Mode(mode) => self.plan.mode = *mode,
                Choice::Fma => self.plan.fma = true,
                Choice::Outputs(parts) => self.outputs = parts.clone(),
                Choice::Layout(layout) => self.layout = *layout,
                Choice::Lanes(lanes) => self.lanes = *lanes,
                Choice::Prepare => self.prepare = true,
                Choice::Known(known) => self.known.add(known),
                Choice::Real(precisions) => self.precisions = precisions.clone(),
                Choice::Target(targets) => self.targets = targets.clone(),
            }
        }
        self
    }

    /// The request with a function's own choices, unless the request overrides them.
    pub fn of<'c>(&self, own: impl IntoIterator<Item = &'c Choice>) -> Request {
        if self.settled { self.clone() } else { self.clone().with(own) }
    }

    /// Languages to print, by default `default`.
    pub fn targets_or(&self, default: Target) -> Vec<Target> {
        if self.targets.is_empty() { vec![default] } else { self.targets.clone() }
    }

    /// Precisions to print, by default double.
    pub fn precisions_or_double(&self) -> Vec<Precision> {
        if self.precisions.is_empty() { vec![Precision::F64] } else { self.precisions.clone() }
    }

    /// Why the request is contradictory, and what to write.
    pub fn conflict(&self) -> Option<(String, &'static str)> {
        let set = &self.known.set;
        let twice =
            |(index, (name, _)): &(usize, &(String, _))| set[..*index].iter().any(|(own, _)| own == name);
        if let Some((_, (name, _))) = set.iter().enumerate().find(twice) {
            return Some((format!("`{name}` is set twice"), "leave one of the values out"));
        }
        let row = self.layout.row();
        if row.computes.is_some() && self.outputs != Part::DEFAULT {
            let message = format!("the layout `{}` says itself what is computed", row.name);
            return Some((message, "leave `outputs` out"));
        }
        (row.adds && self.lanes > 1).then(|| {
            let message = format!(
                "the layout `{}` adds to what one instance is given, and {} lanes may share a body",
                row.name, self.lanes
            );
            (message, "leave `lanes` out, or add what the layout `blocks` computes")
        })
    }
}

impl From<Plan> for Request {
    fn from(plan: Plan) -> Request {
        Request { plan, ..Request::default() }
    }
}

impl From<Effort> for Request {
    fn from(effort: Effort) -> Request {
        Plan::from(effort).into()
    }
}

/// An option with its value.
#[derive(Clone, PartialEq, Debug)]
pub enum Choice {
    /// Optimization effort.
    Effort(Effort),
    /// Floating-point mode.
    Mode(Mode),
    /// Fused multiply-add.
    Fma,
    /// The outputs that kernels compute.
    Outputs(Vec<Part>),
    /// Output layout.
    Layout(Layout),
    /// Number of instances at once.
    Lanes(usize),
    /// Values that depend on parameters alone are computed once.
    Prepare,
    /// Fixed bodies, or parameters with known values.
    Known(Specialization),
    /// The precisions of kernels.
    Real(Vec<Precision>),
    /// The languages of kernels.
    Target(Vec<Target>),
}

/// The form of an option's value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Takes {
    /// No value.
    Nothing,
    /// One of the option's values.
    One,
    /// One or more of the option's values.
    Some,
    /// Names that the function defines.
    Names,
    /// Names that the function defines, with numbers, `NAME=NUMBER` or `NAME=[NUMBER, …]`.
    Numbers,
}

/// A row of the table of options.
pub struct OptionRow {
    /// The name of the option.
    pub name: &'static str,
    /// The form of its value.
    pub takes: Takes,
    /// The noun for a value in messages.
    pub noun: &'static str,
    /// All allowed values; empty if they are names that the function defines.
    pub values: fn() -> Vec<&'static str>,
    /// Reads values; `None` if one of them is invalid.
    read: fn(&[&str]) -> Option<Choice>,
    /// An example in the notation of attributes.
    pub example: &'static str,
    /// A description in one line.
    pub summary: &'static str,
}

/// All options, in the order of listings.
pub static OPTIONS: [OptionRow; 11] = [
    OptionRow {
        name: "effort",
        takes: Takes::One,
        noun: "effort",
        values: || Effort::ALL.iter().map(|(name, _)| *name).collect(),
        read: |words| {
            let found = Effort::ALL.iter().find(|(name, _)| *name == words[0]);
            found.map(|(_, effort)| Choice::Effort(*effort))
        },
        example: "effort = max",
        summary: "Optimization effort",
    },
    OptionRow {
        name: "mode",
        takes: Takes::One,
        noun: "mode",
        values: || Mode::ALL.iter().map(|(name, ..)| *name).collect(),
        read: |words| Mode::named(words[0]).map(Choice::Mode),
        example: "mode = fast",
        summary: "Floating-point mode",
    },
    OptionRow {
        name: "fma",
        takes: Takes::Nothing,
        noun: "",
        values: Vec::new,
        read: |_| Some(Choice::Fma),
        example: "fma",
        summary: "Write products that are added as fused multiplications and additions",
    },
    OptionRow {
        name: "outputs",
        takes: Takes::Some,
        noun: "output",
        values: || Part::choices().map(|row| row.name).collect(),
        read: |words| Part::chosen(words.iter().copied()).ok().map(Choice::Outputs),
        example: "outputs(value, jacobian)",
        summary: "What kernels compute; `value` is C or E, `rate` is dC/dt or dE/dt",
    },
    OptionRow {
        name: "layout",
        takes: Takes::One,
        noun: "layout",
        values: || crate::layout::LAYOUTS.iter().map(|row| row.name).collect(),
        read: |words| Layout::named(words[0]).map(Choice::Layout),
        example: "layout = packed",
        summary: "Output layout",
    },
    OptionRow {
        name: "lanes",
        takes: Takes::One,
        noun: "number of lanes",
        values: || vec!["1", "4", "8"],
        read: |words| {
            let found = LANES.iter().find(|lanes| lanes.to_string() == words[0]);
            found.map(|lanes| Choice::Lanes(*lanes))
        },
        example: "lanes = 4",
        summary: "How many instances a kernel computes at once, from structures of arrays",
    },
    OptionRow {
        name: "prepare",
        takes: Takes::Nothing,
        noun: "",
        values: Vec::new,
        read: |_| Some(Choice::Prepare),
        example: "prepare",
        summary: "Compute what depends on parameters alone once, in a function of its own",
    },
    OptionRow {
        name: "fixed",
        takes: Takes::Names,
        noun: "body",
        values: Vec::new,
        read: |words| {
            let fixed = words.iter().map(|&word| word.to_owned()).collect();
            Some(Choice::Known(Specialization { fixed, set: Vec::new() }))
        },
        example: "fixed(b)",
        summary: "A body that never moves: it has no velocity, no degrees of freedom, and feels no force",
    },
    OptionRow {
        name: "set",
        takes: Takes::Numbers,
        noun: "value of a parameter",
        values: Vec::new,
        read: |words| Specialization::parse_values(words).ok().map(Choice::Known),
        example: "set(damping = 0.0, arm_b = [0.0, 0.0, 0.5])",
        summary: "A parameter whose value is known, as in `damping=0` or `arm_b=[0,0,0.5]`",
    },
    OptionRow {
        name: "real",
        takes: Takes::Some,
        noun: "precision",
        values: || Precision::ALL.iter().map(|precision| precision.name()).collect(),
        read: |words| all_named(words, &Precision::ALL, |precision| precision.name()).map(Choice::Real),
        example: "real = f32",
        summary: "The precision of the kernels",
    },
    OptionRow {
        name: "target",
        takes: Takes::Some,
        noun: "target",
        values: || Target::ALL.iter().map(|target| target.name()).collect(),
        read: |words| all_named(words, &Target::ALL, |target| target.name()).map(Choice::Target),
        example: "target = rust",
        summary: "What to write: C99, as NAME.h, NAME.c and forcec.h, or Rust, as NAME.rs",
    },
];

/// The items that `words` name, in the order of `all`; `None` if a word does not name an item.
fn all_named<T: Copy>(words: &[&str], all: &[T], name: fn(T) -> &'static str) -> Option<Vec<T>> {
    let known = words.iter().all(|word| all.iter().any(|&one| name(one) == *word));
    known.then(|| all.iter().copied().filter(|&one| words.contains(&name(one))).collect())
}

/// Why an option or its value is invalid.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Wrong {
    /// Index of the invalid value.
    pub index: usize,
    /// The message of the error.
    pub message: String,
    /// The label of the error.
    pub label: String,
    /// The help of the error.
    pub help: String,
}

impl OptionRow {
    /// The option with this name.
    pub fn named(name: &str) -> Option<&'static OptionRow> {
        OPTIONS.iter().find(|row| row.name == name)
    }

    /// Whether the option accepts several values.
    pub fn is_list(&self) -> bool {
        matches!(self.takes, Takes::Some | Takes::Names | Takes::Numbers)
    }

    /// Whether the values of the option are numbers.
    pub fn is_number(&self) -> bool {
        let values = (self.values)();
        !values.is_empty() && values.iter().all(|value| value.parse::<u32>().is_ok())
    }

    /// The form of the value, for messages.
    pub fn form(&self) -> String {
        match self.takes {
            Takes::Nothing => "it stands by itself".to_owned(),
            Takes::One => format!("it takes one {}", self.noun),
            Takes::Some | Takes::Names => {
                let article = if self.noun.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" };
                format!("it takes the name of {article} {}, or a list of them", self.noun)
            }
            Takes::Numbers => "it takes names with numbers".to_owned(),
        }
    }

    /// Reads these values, or returns the first invalid one.
    pub fn read(&self, words: &[&str]) -> Result<Choice, Wrong> {
        if let Some(choice) = (self.read)(words) {
            return Ok(choice);
        }
        // Values may be valid only one by one.
        let index = (0..words.len()).find(|last| (self.read)(&words[..=*last]).is_none()).unwrap_or(0);
        let (word, noun) = (words[index], self.noun);
        if let Some(message) =
            Specialization::parse_values(words).err().filter(|_| self.takes == Takes::Numbers)
        {
            let help = format!("write `{}`", self.example);
            return Err(Wrong { index, message, label: "no value of a parameter".to_owned(), help });
        }
        let values = (self.values)();
        let help = suggestion(word, &values);
        let message = format!("unknown {noun} `{word}`");
        Err(Wrong { index, message, label: format!("no such {noun}"), help })
    }
}

/// What to write instead of an unknown name: the nearest known name, or else any known name.
pub(crate) fn suggestion(name: &str, known: &[&str]) -> String {
    suggest::did_you_mean(name, known.iter().copied()).unwrap_or_else(|| match known {
        [] => "leave it out".to_owned(),
        known => format!("write {}", one_of(known)),
    })
}

/// `a`, `b` or `c`
pub fn one_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        all => all.join(""),
    }
}

#[cfg(test)]
mod tests {
    use super::{LANES, OPTIONS, OptionRow, Request, Takes};

    #[test]
    fn every_value_is_read() {
        for row in &OPTIONS {
            let values = (row.values)();
            assert_eq!(values.is_empty(), !matches!(row.takes, Takes::One | Takes::Some), "{}", row.name);
            for value in &values {
                assert!(row.read(&[value]).is_ok(), "{} {value}", row.name);
            }
            let wrong =
                row.read(&["value", "no such value"]).map_or(0, |_| 1) + usize::from(values.is_empty());
            assert_eq!(wrong > 0, values.is_empty(), "{}", row.name);
        }
        assert_eq!(
            LANES.map(|lanes| lanes.to_string()).to_vec(),
            (OptionRow::named("lanes").unwrap().values)()
        );
    }

    #[test]
    fn a_wrong_value_is_named() {
        let wrong = OptionRow::named("outputs").unwrap().read(&["value", "forc"]).unwrap_err();
        assert_eq!((wrong.index, wrong.message.as_str()), (1, "unknown output `forc`"));
        assert_eq!(wrong.help, "did you mean `force`?");
        let wrong = OptionRow::named("lanes").unwrap().read(&["5000"]).unwrap_err();
        assert_eq!(wrong.help, "write `1`, `4` or `8`");
    }

    #[test]
    fn a_parameter_is_set_once() {
        let wrong = OptionRow::named("set").unwrap().read(&["k=1", "d=2", "k=3"]).unwrap_err();
        assert_eq!((wrong.index, wrong.message.as_str()), (2, "`k` is set twice"));
        let mut request = Request::default();
        request.known.set = vec![("k".to_owned(), vec![]), ("k".to_owned(), vec![])];
        assert_eq!(request.conflict().unwrap().0, "`k` is set twice");
    }

    #[test]
    fn what_is_known_comes_together() {
        let read = |name: &str, words: &[&str]| OptionRow::named(name).unwrap().read(words).unwrap();
        let request = Request::default().with(&[read("set", &["k=1", "d=2"]), read("fixed", &["a"])]);
        let request = request.of(&[read("set", &["k=3"]), read("fixed", &["a", "b"])]);
        assert_eq!(request.known.fixed, ["a", "b"]);
        let set: Vec<(&str, f64)> =
            request.known.set.iter().map(|(name, value)| (name.as_str(), value[0].to_f64())).collect();
        assert_eq!(set, [("d", 2.0), ("k", 3.0)]);
    }
}
