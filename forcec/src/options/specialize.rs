//! Specialization: fixed bodies, and parameters with known values, stated before a kernel is compiled.
//!
//! In: names, and values for some of them. Out: signatures with these facts, which all later stages follow. A
//! force function uses the names that it has; a name that no force function has is an error.

use crate::math::exact::Exact;
use crate::model::bodies::{Body, Parameter, ParameterType, Signature};

/// Fixed bodies, and parameters with known values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Specialization {
    /// Fixed bodies: their velocity is zero, they have no degrees of freedom, and no force acts on them.
    pub fixed: Vec<String>,
    /// Parameters by name with their values, entry by entry in memory order.
    pub set: Vec<(String, Vec<Exact>)>,
}

impl Specialization {
    /// Parses `damping=0` or `arm_b=[0, 0, 0.5]`; brackets may be nested according to the type.
    pub fn parse_value(text: &str) -> Result<(String, Vec<Exact>), String> {
        let wrong = || format!("`{text}` is not NAME=NUMBER or NAME=[NUMBER, …]");
        let (name, value) = text.split_once('=').ok_or_else(wrong)?;
        let entries = entries(value).filter(|_| !name.trim().is_empty()).ok_or_else(wrong)?;
        let number = |entry: &str| {
            let value: f64 = entry.parse().map_err(|_| wrong())?;
            let exact = Exact::from_f64(value).ok_or_else(|| format!("`{entry}` is not finite"))?;
            let mantissa = entry.split(['e', 'E']).next().unwrap_or(entry);
            if exact.is_zero() && mantissa.contains(|c: char| ('1'..='9').contains(&c)) {
                return Err(format!("`{entry}` is below the least `f64`, about 5e-324"));
            }
            Ok(exact)
        };
        let numbers = entries.into_iter().map(number).collect::<Result<_, _>>()?;
        Ok((name.trim().to_owned(), numbers))
    }

    /// Parses several values; a parameter must not be set twice.
    pub fn parse_values(texts: &[&str]) -> Result<Specialization, String> {
        let mut known = Specialization::default();
        for text in texts {
            let (name, value) = Specialization::parse_value(text)?;
            if known.set.iter().any(|(other, _)| *other == name) {
                return Err(format!("`{name}` is set twice"));
            }
            known.set.push((name, value));
        }
        Ok(known)
    }

    /// All names, each with its kind, body or parameter.
    pub(crate) fn names(&self) -> impl Iterator<Item = (&'static str, &String)> {
        let fixed = self.fixed.iter().map(|name| ("body", name));
        fixed.chain(self.set.iter().map(|(name, _)| ("parameter", name)))
    }

    /// Adds another specialization; its values override existing ones.
    pub(crate) fn add(&mut self, more: &Specialization) {
        let new = more.fixed.iter().filter(|body| !self.fixed.contains(body)).cloned().collect::<Vec<_>>();
        self.fixed.extend(new);
        self.set.retain(|(name, _)| more.set.iter().all(|(other, _)| other != name));
        self.set.extend(more.set.iter().cloned());
    }

    /// Marks the fixed bodies in a signature.
    pub(crate) fn fix(&self, bodies: &mut [Body]) {
        bodies.iter_mut().for_each(|body| body.fixed = self.fixed.contains(&body.name));
    }

    /// Stores the value of a parameter if it is set; a single number applies to every entry. The error
    /// consists of a message and a help text.
    pub(crate) fn give(&self, parameter: &mut Parameter) -> Result<(), (String, String)> {
        let Some((name, value)) = self.set.iter().find(|(name, _)| *name == parameter.name) else {
            return Ok(());
        };
        let (wanted, given) = (parameter.ty.length(), value.len() as u64);
        let turns = *parameter.ty.innermost() == ParameterType::Quaternion;
        let value = match value.as_slice() {
            [one] if !turns => vec![one.clone(); wanted as usize],
            _ if wanted == given => value.clone(),
            _ => {
                let (entries, are) =
                    (if wanted == 1 { "entry" } else { "entries" }, if given == 1 { "is" } else { "are" });
                let message = format!("`{name}` has {wanted} {entries}, and {given} {are} set");
                return Err((message, format!("write {}", form(&parameter.ty))));
            }
        };
        let norm = |entries: &[Exact]| entries.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt();
        let off = |norm: &f64| (norm - 1.0).abs() > UNIT;
        if let Some(norm) = value.chunks(4).filter(|_| turns).map(norm).find(off) {
            let help = "divide its entries by the norm; `[0, 0, 0, 1]` turns nothing";
            return Err((format!("`{name}` is not a unit quaternion: its norm is {norm}"), help.to_owned()));
        }
        parameter.value = Some(value);
        Ok(())
    }

    /// The suffix of a kernel's name: `_fixed_b`, `_set_damping`.
    pub fn suffix(&self, signature: &Signature) -> String {
        let fixed = signature.bodies.iter().filter(|body| body.fixed).map(|body| &body.name);
        let set = signature.parameters.iter().chain(&signature.extras);
        let set = set.filter(|p| p.value.is_some()).map(|p| &p.name);
        let mut suffix = String::new();
        for (label, names) in [("_fixed", fixed.collect::<Vec<_>>()), ("_set", set.collect())] {
            if !names.is_empty() {
                suffix.push_str(label);
            }
            names.into_iter().for_each(|name| suffix.push_str(&format!("_{name}")));
        }
        suffix
    }
}

/// The largest deviation of the norm of a unit quaternion.
const UNIT: f64 = 1e-6;

/// The form of a value of this type, for messages.
fn form(ty: &ParameterType) -> String {
    let rows = |n: u32, row: &str| match n {
        0..=4 => format!("[{}]", vec![row; n as usize].join(", ")),
        _ => format!("[{row}, …], {n} of them"),
    };
    match ty {
        ParameterType::Real => "one number".to_owned(),
        ParameterType::Quaternion => "`[x, y, z, w]`".to_owned(),
        ParameterType::Vector(n) => {
            format!("`[{}]`", ["x", "y", "z", "w"][..(*n as usize).min(4)].join(", "))
        }
        ParameterType::Matrix(n) => {
            let row = format!("[{}]", vec!["_"; *n as usize].join(", "));
            format!("`{}`, row by row", rows(*n, &row))
        }
        ParameterType::Array(n, element) => match **element {
            ParameterType::Real => format!("{n} numbers, as in `[1, 2]`"),
            _ => format!("an array of {n}, each {}", form(element)),
        },
    }
}

/// Entries of `1` or `[[1, 2], [3, 4]]`; `None` for unbalanced brackets or elements of different shapes.
fn entries(text: &str) -> Option<Vec<&str>> {
    let mut found = Vec::new();
    // The number of complete elements in each open bracket, and the number of elements at each depth.
    let (mut open, mut lengths): (Vec<usize>, Vec<Option<usize>>) = (Vec::new(), Vec::new());
    let (mut depth, mut complete) = (None, false);
    let mut rest = text.trim();
    while let Some(first) = rest.chars().next() {
        let end = if "[],".contains(first) { 1 } else { rest.find(['[', ']', ',']).unwrap_or(rest.len()) };
        let (word, behind) = rest.split_at(end);
        rest = behind.trim_start();
        match word {
            "[" if !complete => open.push(0),
            "," if complete => {
                *open.last_mut()? += 1;
                complete = false;
            }
            "]" => {
                let length = open.pop()? + usize::from(complete);
                let level = open.len();
                if lengths.len() <= level {
                    lengths.resize(level + 1, None);
                }
                if length == 0 || *lengths[level].get_or_insert(length) != length {
                    return None;
                }
                complete = true;
            }
            "[" | "," => return None,
            number if !complete && *depth.get_or_insert(open.len()) == open.len() => {
                found.push(number.trim_end());
                complete = true;
            }
            _ => return None,
        }
    }
    (complete && open.is_empty()).then_some(found)
}

/// The specialization in the comment of a kernel: `b is fixed`, `damping = 0`.
pub fn remarks(signature: &Signature) -> Vec<String> {
    let fixed = signature.bodies.iter().filter(|body| body.fixed);
    let mut lines: Vec<String> = fixed.map(|body| format!("{} is fixed", body.name)).collect();
    for parameter in signature.parameters.iter().chain(&signature.extras) {
        let Some(value) = &parameter.value else { continue };
        let numbers: Vec<String> = value.iter().map(|number| number.to_f64().to_string()).collect();
        lines.push(match numbers.as_slice() {
            [number] => format!("{} = {number}", parameter.name),
            numbers => format!("{} = [{}]", parameter.name, numbers.join(", ")),
        });
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::Specialization;
    use crate::math::exact::Exact;
    use crate::model::bodies::{Domain, Parameter, ParameterType};

    #[test]
    fn values_are_read() {
        let read = |text| Specialization::parse_value(text);
        assert_eq!(read("damping=0"), Ok(("damping".to_owned(), vec![Exact::ZERO])));
        let numbers = [1, 2, 3, 4].map(Exact::from).to_vec();
        assert_eq!(read("m = [[1, 2], [3, 4.0]]"), Ok(("m".to_owned(), numbers)));
        assert_eq!(read("k=[[1, 2, 3], [4, 5, 6]]").unwrap().1.len(), 6);
        assert_eq!(read("z=[[[0e5]], [[-0.0]]]").unwrap().1, [Exact::ZERO, Exact::ZERO]);
        let shapes = [
            "k=[1,2",
            "k=1]]],2",
            "k=1]",
            "k=[[1],[2,3]]",
            "k=[1,[2]]",
            "k=[1 2]",
            "k=1,2",
            "k=[,1]",
            "k=[[1],[]]",
        ];
        for wrong in ["damping", "=1", "k=", "k=[]", "k=one"].into_iter().chain(shapes) {
            assert!(read(wrong).unwrap_err().contains("is not NAME=NUMBER"), "{wrong}");
        }
        for (wrong, message) in [
            ("k=inf", "`inf` is not finite"),
            ("k=nan", "`nan` is not finite"),
            ("k=[1, 1e999]", "`1e999` is not finite"),
            ("k=1e-400", "`1e-400` is below the least `f64`, about 5e-324"),
        ] {
            assert_eq!(read(wrong).unwrap_err(), message);
        }
        assert_eq!(Specialization::parse_values(&["k=1", "d=2", "k=1"]).unwrap_err(), "`k` is set twice");
    }

    #[test]
    fn values_fit_or_say_why_not() {
        let give = |value: &str, ty: ParameterType| {
            let known = Specialization::parse_values(&[value]).unwrap();
            known.give(&mut Parameter { name: "k".to_owned(), ty, domain: Domain::Any, value: None })
        };
        let turn = ParameterType::Quaternion;
        assert_eq!(give("k=[0, 0.6, 0, 0.8000001]", turn.clone()), Ok(()));
        let (message, _) = give("k=[0, 0, 0, 2]", turn.clone()).unwrap_err();
        assert_eq!(message, "`k` is not a unit quaternion: its norm is 2");
        let (message, help) = give("k=1", turn.clone()).unwrap_err();
        assert_eq!(
            (message.as_str(), help.as_str()),
            ("`k` has 4 entries, and 1 is set", "write `[x, y, z, w]`")
        );
        assert!(give("k=1", ParameterType::Array(2, Box::new(turn))).is_err());
        let (message, help) = give("k=[1, 2]", ParameterType::Real).unwrap_err();
        assert_eq!((message.as_str(), help.as_str()), ("`k` has 1 entry, and 2 are set", "write one number"));
    }
}
