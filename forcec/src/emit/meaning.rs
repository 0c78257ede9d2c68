//! The comment for a parameter of a kernel.
//!
//! In: a kernel and one of its parameters. Out: the description of the parameter from the author's doc
//! comment, its storage order where several orders are possible, and its domain. A doc comment describes
//! parameters in phrases such as `` `arm_a`, `arm_b`: anchors in body space, m. `` at the start of a
//! paragraph or of a sentence.

use crate::kernel::Kernel;
use crate::model::bodies::{Domain, Parameter, ParameterType, Signature};

/// The comment for a parameter. `None` if its name and type suffice.
pub(super) fn parameter_comment(kernel: &Kernel, signature: &Signature, index: usize) -> Option<String> {
    if let Some(summary) = kernel.summary_of(signature, index) {
        return Some(summary);
    }
    let parameter = &signature.parameters[index];
    let own = meaning(&kernel.docs, &parameter.name).or_else(|| added(kernel, parameter));
    let parts: Vec<String> = [own, order(&parameter.ty), domain(parameter)].into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// The description of a parameter that the compiler adds to a constraint.
fn added(kernel: &Kernel, parameter: &Parameter) -> Option<String> {
    match parameter.name.as_str() {
        "stiffness" if kernel.schedule.signature.rows > 0 => Some("k of the constraint".to_owned()),
        "damping" if kernel.schedule.signature.rows > 0 => Some("d of the constraint".to_owned()),
        _ => None,
    }
}

/// The storage order of the numbers of a parameter, where a reader could expect another order.
fn order(ty: &ParameterType) -> Option<String> {
    match ty {
        ParameterType::Real | ParameterType::Vector(_) => None,
        ParameterType::Matrix(_) => Some("row by row".to_owned()),
        ParameterType::Quaternion => Some("quaternion x, y, z, w".to_owned()),
        ParameterType::Array(_, element) => order(element),
    }
}

fn domain(parameter: &Parameter) -> Option<String> {
    match parameter.domain {
        Domain::Any => None,
        Domain::Range(low, high) => Some(format!("{low} to {high}")),
        Domain::Unit => Some("of length one".to_owned()),
    }
}

/// The description of a name in a doc comment, without the full stop.
fn meaning(docs: &[String], name: &str) -> Option<String> {
    let lines: Vec<&str> = docs.iter().map(|line| line.trim()).collect();
    let paragraphs = lines.split(|line| line.is_empty()).map(|lines| lines.join(" "));
    paragraphs.into_iter().find_map(|paragraph| {
        let starts = paragraph.match_indices('`').map(|(at, _)| at);
        let is_start = |at: &usize| *at == 0 || paragraph[..*at].ends_with(". ");
        starts.filter(is_start).find_map(|at| {
            let (names, text) = described(&paragraph[at..])?;
            names.contains(&name).then(|| text.trim_end_matches('.').to_owned())
        })
    })
}

/// The names that a phrase describes, and its text up to the next phrase.
fn described(phrase: &str) -> Option<(Vec<&str>, &str)> {
    let mut names = Vec::new();
    let mut rest = phrase;
    loop {
        let (name, after) = rest.strip_prefix('`')?.split_once('`')?;
        names.push(name);
        if let Some(text) = after.strip_prefix(": ") {
            let next = text.match_indices(". `").map(|(at, _)| at);
            let end = next.into_iter().find(|at| described(&text[at + 2..]).is_some());
            return Some((names, &text[..end.unwrap_or(text.len())]));
        }
        rest = after.strip_prefix(", ").or_else(|| after.strip_prefix(" and "))?;
    }
}

#[cfg(test)]
mod tests {
    use super::meaning;

    #[test]
    fn phrases_of_doc_comments() {
        let docs = [
            "Spring: `rest` apart.",
            "",
            "`arm_a`, `arm_b`: anchors in body",
            "space, m. `k` and `d`: N/m, see `rest`. More",
            "words. `rest`: L, m.",
        ];
        let docs = docs.map(str::to_owned);
        let of = |name| meaning(&docs, name);
        assert_eq!(of("arm_b").as_deref(), Some("anchors in body space, m"));
        assert_eq!(of("d").as_deref(), Some("N/m, see `rest`. More words"));
        assert_eq!(of("rest").as_deref(), Some("L, m"));
        assert_eq!(of("other"), None);
    }
}
