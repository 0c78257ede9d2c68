//! The arguments of the functions that a long kernel is split into, for all targets.
//!
//! In: a kernel's schedule and one of its sections. Out: the arguments in order; targets declare and pass
//! them.

use crate::emit::reads;
use crate::model::bodies::{Body, Parameter};
use crate::names::Arguments;
use crate::schedule::Schedule;
use crate::schedule::sections::Section;

/// An argument that a part needs.
pub(crate) enum Needed<'a> {
    /// A body, with its name.
    Body(&'a Body, &'a str),
    /// The parameters, with the name of the argument.
    Parameters(&'a str),
    /// An extra argument, with its name.
    Extra(&'a Parameter, &'a str),
    /// The struct through which parts share values, and whether this part writes values to it.
    Shared(bool),
    /// The destination of the results.
    Results,
}

impl Needed<'_> {
    /// The name of the argument in the part; the kernel uses the same name, except for the shared struct.
    pub(crate) fn name(&self) -> &str {
        match self {
            Needed::Body(_, name) | Needed::Extra(_, name) | Needed::Parameters(name) => name,
            Needed::Shared(_) => "shared",
            Needed::Results => "out",
        }
    }
}

/// The arguments that a part needs.
pub(crate) fn needed<'a>(schedule: &'a Schedule, section: &Section, names: &'a Arguments) -> Vec<Needed<'a>> {
    let signature = &schedule.signature;
    let reads = reads(schedule, section.written(schedule));
    let bodies = signature.bodies.iter().zip(&names.bodies).zip(reads.bodies).filter(|(_, read)| *read);
    let mut all: Vec<Needed<'a>> = bodies.map(|((body, name), _)| Needed::Body(body, name)).collect();
    all.extend(reads.parameters.then_some(Needed::Parameters(names.given)));
    let extras = signature.given_extras().filter(|(index, _)| reads.extras[*index]);
    all.extend(extras.map(|(index, extra)| Needed::Extra(extra, &names.extras[index])));
    all.extend(section.shares().then_some(Needed::Shared(!section.hands_on.is_empty())));
    all.extend(section.stores.then_some(Needed::Results));
    all
}
