//! Reads the text of a scene file into values with positions, or all errors.

use crate::layout::Layout;
use crate::model::outputs::Part;
use crate::options::{Choice, OPTIONS, OptionRow, Takes, one_of, suggestion};
use crate::source::diagnostic::{Diagnostic, Diagnostics};
use crate::source::span::{Source, Span};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// An integrator, and the kernels that it needs of a force.
pub(crate) struct Integrator {
    /// The name in scene files.
    pub(crate) name: &'static str,
    /// Outputs and layout of each kernel; empty if the scene specifies them.
    pub(crate) needs: &'static [(&'static [Part], Layout)],
}

/// Every integrator.
pub(crate) static INTEGRATORS: [Integrator; 7] = [
    Integrator { name: "explicit", needs: &[(&[Part::Force], Layout::Dense)] },
    Integrator { name: "implicit", needs: &[(&Part::DEFAULT, Layout::System)] },
    Integrator { name: "rosenbrock", needs: &[(&Part::DEFAULT, Layout::Dense)] },
    Integrator { name: "newton", needs: &[(&Part::DEFAULT, Layout::Dense)] },
    Integrator {
        name: "matrix-free",
        needs: &[(&[Part::Force], Layout::Dense), (&Part::DEFAULT, Layout::Product)],
    },
    Integrator { name: "xpbd", needs: &[(&[Part::Value, Part::Rate, Part::Jacobian], Layout::Dense)] },
    Integrator { name: "user", needs: &[] },
];

/// An option with its position.
#[derive(Clone, Debug)]
pub(crate) struct Stated {
    pub(crate) choice: Choice,
    pub(crate) span: Span,
    /// The position of each value of the option.
    pub(crate) places: Vec<Span>,
}

/// One kernel of a scene.
pub(crate) struct Entry {
    pub(crate) function: (String, Span),
    pub(crate) name: Option<(String, Span)>,
    pub(crate) integrator: &'static Integrator,
    /// The position of the kernel's or the scene's integrator.
    pub(crate) decided: Option<Span>,
    pub(crate) options: Vec<Stated>,
}

/// The contents of a scene file.
pub(crate) struct Scene {
    /// Force files and folders, relative to the scene's folder.
    pub(crate) forces: Vec<(String, Span)>,
    /// The output folder, relative to the scene's folder.
    pub(crate) out: String,
    /// Options for every kernel that they apply to.
    pub(crate) options: Vec<Stated>,
    pub(crate) entries: Vec<Entry>,
}

/// Reads a scene file.
pub(crate) fn read(source: &Source) -> Result<Scene, Diagnostics> {
    let (table, wrong) = DeTable::parse_recoverable(&source.text);
    let syntax = wrong.iter().map(|error| {
        let at = error.span().map(span).unwrap_or_default();
        Diagnostic::error(at, "a scene is a TOML file", error.message())
    });
    let mut reader = Reader { errors: syntax.collect() };
    // After a syntax error, further messages would not help.
    let scene = if reader.errors.is_empty() { reader.scene(table.get_ref()) } else { None };
    match scene {
        Some(scene) if reader.errors.is_empty() => Ok(scene),
        _ => Err(Diagnostics::new(source.clone(), reader.errors)),
    }
}

fn span(range: Range<usize>) -> Span {
    Span { start: range.start as u32, end: range.end as u32 }
}

struct Reader {
    errors: Vec<Diagnostic>,
}

type Value<'t> = Spanned<DeValue<'t>>;

impl Reader {
    fn wrong(
        &mut self,
        at: Span,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.errors.push(Diagnostic::error(at, message, label).help(help));
    }

    fn scene(&mut self, table: &DeTable<'_>) -> Option<Scene> {
        const OWN: [&str; 4] = ["forces", "kernel", "integrator", "out"];
        let options = self.options(table, &OWN, &[]);
        let forces = table.get("forces").map(|value| self.texts(value, "a path, or a list of them"));
        let out = table.get("out").and_then(|value| self.text(value, "a path"));
        let integrator = table.get("integrator").and_then(|value| self.integrator(value));
        let Some(forces) = forces.filter(|forces| !forces.is_empty()) else {
            let (at, label) = match table.get("forces") {
                None => (Span::default(), "no `forces` here"),
                Some(list) if matches!(list.get_ref(), DeValue::Array(list) if list.is_empty()) => {
                    (span(list.span()), "none is named here")
                }
                // The error about a wrong element has been reported.
                Some(_) => return None,
            };
            self.wrong(
                at,
                "a scene names its force files",
                label,
                "write `forces = [\"joints.rs\"]`; paths count from the folder of the scene",
            );
            return None;
        };
        let mut entries = Vec::new();
        match table.get("kernel").map(|value| (value, value.get_ref())) {
            Some((_, DeValue::Array(list))) => {
                for entry in list.iter() {
                    match entry.get_ref() {
                        DeValue::Table(table) => {
                            entries.extend(self.entry(table, span(entry.span()), integrator));
                        }
                        _ => self.no_kernel(span(entry.span())),
                    }
                }
            }
            Some((value, _)) => self.no_kernel(span(value.span())),
            None => self.no_kernel(Span::default()),
        }
        let out = out.map_or_else(|| "kernels".to_owned(), |(out, _)| out);
        Some(Scene { forces, out, options, entries })
    }

    fn no_kernel(&mut self, at: Span) {
        let help = "write `[[kernel]]`, and below it `function = \"point_to_point\"`";
        self.wrong(at, "a scene names its kernels", "no list of kernels", help);
    }

    fn entry(
        &mut self,
        table: &DeTable<'_>,
        at: Span,
        integrator: Option<(&'static Integrator, Span)>,
    ) -> Option<Entry> {
        const OWN: [&str; 3] = ["function", "name", "integrator"];
        const PRINTED: [&str; 2] = ["real", "target"];
        let options = self.options(table, &OWN, &PRINTED);
        let name = table.get("name").and_then(|value| self.name(value));
        let own = table.get("integrator").map(|value| self.integrator(value));
        let stated = match own {
            Some(own) => Some(own?),
            None => integrator,
        };
        let decided = stated.map(|(_, at)| at);
        let integrator = stated.map_or(&INTEGRATORS[INTEGRATORS.len() - 1], |(integrator, _)| integrator);
        if !integrator.needs.is_empty() {
            let decided = |choice: &Choice| matches!(choice, Choice::Outputs(_) | Choice::Layout(_));
            for stated in options.iter().filter(|stated| decided(&stated.choice)) {
                let message = format!("the integrator `{}` decides outputs and layout", integrator.name);
                self.wrong(
                    stated.span,
                    message,
                    "stated here",
                    "write `integrator = \"user\"`, or leave it out",
                );
            }
        }
        let Some(function) = table.get("function") else {
            self.wrong(
                at,
                "a kernel is that of a force function",
                "no `function` here",
                "write `function = \"hinge\"`",
            );
            return None;
        };
        Some(Entry {
            function: self.text(function, "the name of a force function")?,
            name,
            integrator,
            decided,
            options,
        })
    }

    fn integrator(&mut self, value: &Value<'_>) -> Option<(&'static Integrator, Span)> {
        let (name, at) = self.text(value, "the name of an integrator")?;
        let found = INTEGRATORS.iter().find(|row| row.name == name);
        if found.is_none() {
            let names = INTEGRATORS.each_ref().map(|row| row.name);
            let help = suggestion(&name, &names);
            self.wrong(at, format!("unknown integrator `{name}`"), "no such integrator", help);
        }
        found.map(|integrator| (integrator, at))
    }

    /// Reads the name of a kernel.
    fn name(&mut self, value: &Value<'_>) -> Option<(String, Span)> {
        let (name, at) = self.text(value, "a name")?;
        let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        let fits =
            letters && name.starts_with(|c: char| c.is_ascii_alphabetic()) && !name.starts_with("forcec_");
        if !fits {
            let help = "write ASCII letters, digits and `_`, a letter first; `forcec_` is ours";
            self.wrong(
                at,
                format!("`{name}` is not a valid kernel name"),
                "C and Rust cannot write it",
                help,
            );
        }
        fits.then_some((name, at))
    }

    /// Reads the options among a table's keys, except its `own` keys; other keys are errors.
    fn options(&mut self, table: &DeTable<'_>, own: &[&str], elsewhere: &[&str]) -> Vec<Stated> {
        let mut found = Vec::new();
        for (key, value) in table.iter().filter(|(key, _)| !own.contains(&key.get_ref().as_ref())) {
            let (name, at) = (key.get_ref().as_ref(), span(key.span()));
            match OptionRow::named(name) {
                Some(row) if elsewhere.contains(&name) => {
                    let help = "write it above all kernels";
                    self.wrong(
                        at,
                        format!("`{}` is stated of the scene", row.name),
                        "this is one kernel",
                        help,
                    );
                }
                Some(row) => found.extend(self.option(row, at, value)),
                None => {
                    let names = OPTIONS.iter().map(|row| row.name).filter(|name| !elsewhere.contains(name));
                    let known: Vec<&str> = own.iter().copied().chain(names).collect();
                    let help = suggestion(name, &known);
                    self.wrong(at, format!("unknown key `{name}`"), "nothing a scene says here", help);
                }
            }
        }
        found
    }

    fn option(&mut self, row: &'static OptionRow, key: Span, value: &Value<'_>) -> Option<Stated> {
        let at = span(value.span());
        let words: Vec<(String, Span)> = match (row.takes, value.get_ref()) {
            (Takes::Nothing, DeValue::Boolean(false)) => return None,
            (Takes::Nothing, DeValue::Boolean(true)) => Vec::new(),
            (Takes::Numbers, DeValue::Table(table)) => {
                let mut words = Vec::new();
                for (name, value) in table.iter() {
                    let mut list = Vec::new();
                    numbers(value.get_ref(), &mut list);
                    let place = span(name.span()).to(span(value.span()));
                    // The option's reader reports elements that are not numbers.
                    words.push((format!("{}=[{}]", name.get_ref(), list.join(",")), place));
                }
                words
            }
            (Takes::One, DeValue::Integer(number)) if row.is_number() => {
                vec![(number.as_str().to_owned(), at)]
            }
            (Takes::One, DeValue::String(text)) if !row.is_number() => vec![(text.to_string(), at)],
            (Takes::Some, DeValue::Array(list)) if list.is_empty() => {
                let help = format!("write `{} = [\"{}\"]`, or leave it out", row.name, (row.values)()[0]);
                self.wrong(at, format!("`{}` is empty", row.name), row.form(), help);
                return None;
            }
            (Takes::Some | Takes::Names, _) => self.texts(value, &row.form()),
            _ => {
                let help = match row.takes {
                    Takes::Nothing => format!("write `{} = true`", row.name),
                    Takes::One => {
                        let quote = if row.is_number() { "" } else { "\"" };
                        let value = |value: &&str| format!("{} = {quote}{value}{quote}", row.name);
                        let values: Vec<String> = (row.values)().iter().map(value).collect();
                        format!("write {}", one_of(&values.iter().map(String::as_str).collect::<Vec<_>>()))
                    }
                    _ => format!("write `{} = {{ damping = 0.0, arm_b = [0.0, 0.0, 0.5] }}`", row.name),
                };
                self.wrong(at, format!("`{}` is malformed", row.name), row.form(), help);
                return None;
            }
        };
        if words.is_empty() && row.takes != Takes::Nothing {
            return None;
        }
        let places: Vec<Span> = words.iter().map(|(_, place)| *place).collect();
        match row.read(&words.iter().map(|(word, _)| word.as_str()).collect::<Vec<_>>()) {
            Ok(choice) => Some(Stated { choice, span: key.to(at), places }),
            Err(wrong) if row.takes == Takes::Numbers => {
                let help = "write `damping = 0.0` or `arm_b = [0.0, 0.0, 0.5]`";
                self.wrong(
                    places[wrong.index],
                    "the value of a parameter is malformed",
                    "no finite numbers",
                    help,
                );
                None
            }
            Err(wrong) => {
                self.wrong(places[wrong.index], wrong.message, wrong.label, wrong.help);
                None
            }
        }
    }

    /// A string or a list of strings.
    fn texts(&mut self, value: &Value<'_>, what: &str) -> Vec<(String, Span)> {
        match value.get_ref() {
            DeValue::Array(list) => list.iter().filter_map(|element| self.text(element, what)).collect(),
            _ => self.text(value, what).into_iter().collect(),
        }
    }

    fn text(&mut self, value: &Value<'_>, what: &str) -> Option<(String, Span)> {
        let at = span(value.span());
        if let DeValue::String(text) = value.get_ref() {
            return Some((text.to_string(), at));
        }
        let kind = value.get_ref().type_str();
        let article = if kind.starts_with(['a', 'i']) { "an" } else { "a" };
        self.wrong(at, format!("expected a string, found {article} {kind}"), what, "put it in quotes");
        None
    }
}

/// The numbers of a number or of nested arrays; for other values the name of the type.
fn numbers(value: &DeValue<'_>, list: &mut Vec<String>) {
    match value {
        DeValue::Integer(number) if number.radix() == 10 => list.push(number.as_str().to_owned()),
        DeValue::Float(number) => list.push(number.as_str().to_owned()),
        DeValue::Array(elements) => elements.iter().for_each(|element| numbers(element.get_ref(), list)),
        other => list.push(other.type_str().to_owned()),
    }
}
