//! What is known before a kernel is compiled: bodies that never move, parameters that never change.
//!
//! In: names, and values for some. Out: signatures that know them; everything after the front end follows from these. A
//! force function takes of it what it has; what none of them has is an error.

use crate::bodies::{Body, Parameter, ParameterType, Signature};
use crate::exact::Exact;

/// Bodies and parameters that are known while compiling.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Specialization {
    /// The bodies that never move: their velocity is zero, they have no degrees of freedom and feel no force.
    pub fixed: Vec<String>,
    /// Parameters by name with their values, entry by entry in memory order.
    pub set: Vec<(String, Vec<Exact>)>,
}

impl Specialization {
    /// Reads `damping=0` or `arm_b=[0, 0, 0.5]`; brackets may be nested as the type is, and are not told apart.
    pub fn parse_value(text: &str) -> Result<(String, Vec<Exact>), String> {
        let wrong = || format!("`{text}` is not NAME=NUMBER or NAME=[NUMBER, …]");
        let (name, value) = text.split_once('=').ok_or_else(wrong)?;
        let numbers = value.split(['[', ']', ',', ' ']).filter(|number| !number.is_empty());
        let number = |number: &str| number.parse().ok().and_then(Exact::from_f64).ok_or_else(wrong);
        let numbers: Vec<Exact> = numbers.map(number).collect::<Result<_, _>>()?;
        if name.trim().is_empty() || numbers.is_empty() {
            return Err(wrong());
        }
        Ok((name.trim().to_owned(), numbers))
    }

    /// Adds what else is known; of two values of a parameter the new one holds.
    pub(crate) fn add(&mut self, more: &Specialization) {
        let new = more.fixed.iter().filter(|body| !self.fixed.contains(body)).cloned().collect::<Vec<_>>();
        self.fixed.extend(new);
        self.set.retain(|(name, _)| more.set.iter().all(|(other, _)| other != name));
        self.set.extend(more.set.iter().cloned());
    }

    /// Notes the fixed bodies in a signature.
    pub(crate) fn fix(&self, bodies: &mut [Body]) {
        bodies.iter_mut().for_each(|body| body.fixed = self.fixed.contains(&body.name));
    }

    /// Notes the value of a parameter, if it is set; one number stands for every entry.
    pub(crate) fn give(&self, parameter: &mut Parameter) -> Result<(), String> {
        let Some((name, value)) = self.set.iter().find(|(name, _)| *name == parameter.name) else {
            return Ok(());
        };
        let (wanted, given) = (parameter.ty.length(), value.len() as u64);
        parameter.value = match value.as_slice() {
            [one] if parameter.ty != ParameterType::Quaternion => Some(vec![one.clone(); wanted as usize]),
            _ if wanted == given => Some(value.clone()),
            _ => return Err(format!("`{name}` has {wanted} entries, and {given} are set")),
        };
        Ok(())
    }

    /// What stands behind the name of a kernel: `_fixed_b`, `_set_damping`.
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

/// What is known, as a kernel's comment says it: `b is fixed`, `damping = 0`.
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
    use crate::exact::Exact;

    #[test]
    fn values_are_read() {
        let read = |text| Specialization::parse_value(text);
        assert_eq!(read("damping=0"), Ok(("damping".to_owned(), vec![Exact::ZERO])));
        let numbers = [1, 2, 3, 4].map(Exact::from).to_vec();
        assert_eq!(read("m = [[1, 2], [3, 4.0]]"), Ok(("m".to_owned(), numbers)));
        for wrong in ["damping", "=1", "k=", "k=[]", "k=one", "k=inf", "k=nan"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
