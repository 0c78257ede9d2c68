//! Scene files: the kernels that a program needs.
//!
//! In: a TOML file that lists force functions, their fixed bodies and constants, and the integrator that uses
//! the kernels. Out: these kernels, each compiled once; or messages with positions in the scene or a force
//! file.

mod read;

use crate::check::check_knowing;
use crate::compile::{self, Compiled, Stages};
use crate::driver::files::{self, BuildError, Unit};
use crate::layout::{Lanes, Layout};
use crate::model::bodies::Parameter;
use crate::model::outputs::Part;
use crate::names::{Target, defined_for};
use crate::options::plan::Plan;
use crate::options::specialize::Specialization;
use crate::options::{Choice, Request, suggestion};
use crate::source::diagnostic::{Diagnostic, Diagnostics};
use crate::source::span::{Source, Span, shown};
use crate::source::suggest;
use crate::syntax::{self, ast};
use crate::vector::definition::Definition;
use read::{Entry, Stated};
use std::path::{Path, PathBuf};

/// A compiled scene.
#[cfg_attr(
    not(feature = "cli"),
    expect(dead_code, reason = "the command line alone tells what was left out")
)]
pub(crate) struct Scene {
    /// The force files and folders of the scene.
    pub(crate) sources: Vec<PathBuf>,
    /// The output folder.
    pub(crate) out: PathBuf,
    /// The request that determines the printed files.
    pub(crate) request: Request,
    /// The kernels, by force file.
    pub(crate) units: Vec<Unit>,
    /// The plan of each kernel's full kernel, for comparison; `None` for repeated full kernels.
    pub(crate) full: Vec<Option<Plan>>,
    /// Functions in the force files without a kernel in the scene.
    pub(crate) left_out: Vec<String>,
    /// The number of duplicate kernels in the scene.
    pub(crate) again: usize,
}

/// A force file, read and checked.
struct Force {
    path: PathBuf,
    file: ast::File,
    definitions: Vec<Definition>,
    kernels: Vec<Stages>,
    full: Vec<Option<Plan>>,
}

/// Callbacks for progress and warnings.
pub(crate) struct Listener<'a> {
    /// Called before each kernel with its function and the number of kernels.
    pub(crate) step: &'a mut dyn FnMut(&str, usize),
    /// Called with the warnings of a force file.
    pub(crate) warn: &'a mut dyn FnMut(Diagnostics),
}

/// Reads a scene and compiles its kernels.
pub(crate) fn compile(path: &Path, listener: &mut Listener<'_>) -> Result<Scene, BuildError> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| BuildError::from(vec![format!("error: cannot read `{}`: {error}", shown(path))]))?;
    let source = Source::new(shown(Path::new(&path.to_string_lossy().replace('\\', "/"))), text);
    let scene = read::read(&source)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let wanted = |name: &str| scene.entries.iter().any(|entry| entry.function.0 == name);
    let mut forces = forces(&scene.forces, folder, &source, &wanted, listener.warn)?;
    let mut errors = Vec::new();
    let mut asked: Vec<(usize, String, Request)> = Vec::new();
    let mut made: Vec<(usize, &str, Option<&str>, Request)> = Vec::new();
    let mut again = 0;
    let mut failures: Vec<Diagnostics> = Vec::new();
    for entry in &scene.entries {
        let (name, at) = &entry.function;
        (listener.step)(name, scene.entries.len());
        let Some((index, at_definition)) = find(&forces, name, *at, &mut errors) else { continue };
        let force = &mut forces[index];
        let definition = &force.definitions[at_definition];
        let before = errors.len();
        errors.extend(entry.options.iter().flat_map(|stated| misfits(definition, stated, entry)));
        let fitting = scene.options.iter().map(|stated| fitting(&stated.choice, definition));
        let fitting: Vec<Choice> = fitting.flatten().collect();
        let own: Vec<&Choice> =
            force.file.function(name).map_or_else(Vec::new, |own| own.choices().collect());
        let stated = Request::default().with(own).with(&fitting);
        let stated = stated.with(entry.options.iter().map(|stated| &stated.choice));
        let needs: Vec<(&[Part], Layout)> = match entry.integrator.needs {
            [] => vec![(&stated.outputs, stated.layout)],
            needs => needs.to_vec(),
        };
        if errors.len() > before {
            continue;
        }
        for (number, (outputs, layout)) in needs.into_iter().enumerate() {
            let request = Request { outputs: outputs.to_vec(), layout, settled: true, ..stated.clone() };
            let all = || scene.options.iter().chain(&entry.options).rev();
            if let Some((message, help)) = request.conflict() {
                let place = conflicting(&request, all()).or(entry.decided).unwrap_or(*at);
                errors.push(Diagnostic::error(place, message, "stated here").help(help));
                continue;
            }
            let wanted = all().find(|stated| matches!(stated.choice, Choice::Outputs(_)));
            let wanted = wanted.map(|stated| stated.span).filter(|_| entry.integrator.needs.is_empty());
            if let Some(place) = wanted.or(entry.decided)
                && let Some(error) = compile::valueless(definition, request.parts())
            {
                let help = if entry.integrator.needs.is_empty() {
                    "ask for `force`, `dfdx` and `dfdv`"
                } else {
                    "take another integrator for this kernel"
                };
                errors.push(Diagnostic::error(place, error.message, "this asks for them").help(help));
                continue;
            }
            // Skips duplicates.
            let own_name = entry.name.as_ref().map(|(own, _)| own.as_str());
            let is_same = |(other, called, own, earlier): &(usize, &str, Option<&str>, Request)| {
                (*other, *called, *own) == (index, name.as_str(), own_name) && *earlier == request
            };
            if made.iter().any(is_same) {
                again += 1;
                continue;
            }
            let mut kernel = match compile::compile_file(&force.file, &|own| own == name, request.clone()) {
                Ok(compiled) => compiled.functions,
                Err(wrong) => {
                    failures.push(wrong);
                    continue;
                }
            };
            let Some(mut kernel) = kernel.pop() else { continue };
            if let Some(own) = &entry.name {
                kernel.kernel.name = format!("{}{}", own.0, layout.suffix(Lanes::of(request.lanes)));
            }
            let title = kernel.kernel.name.clone();
            let place = entry.name.as_ref().map_or(*at, |(_, place)| *place);
            match asked.iter().find(|(_, other, own)| meet((other, own.layout), (&title, layout))) {
                Some((other, earlier_title, earlier))
                    if *other == index && *earlier_title == title && *earlier == request =>
                {
                    again += 1;
                }
                Some((_, other, _)) => {
                    let message = match *other == title {
                        true => format!("two kernels are named `{title}`"),
                        false => format!("kernels of `{other}` and `{title}` would have the same name"),
                    };
                    let help = match entry.name {
                        Some(_) => "give one of them another name",
                        None => "give one of them a name, `name = \"…\"`",
                    };
                    errors.push(Diagnostic::error(place, message, "the second of them").help(help));
                }
                None => {
                    force.full.push((number == 0).then_some(request.plan));
                    force.kernels.push(kernel);
                    made.push((index, name.as_str(), own_name, request.clone()));
                    asked.push((index, title, request));
                }
            }
        }
    }
    let definitions = || forces.iter().flat_map(|force| &force.definitions);
    errors.extend(scene.options.iter().flat_map(|stated| nowhere(stated, definitions())));
    if !errors.is_empty() {
        failures.insert(0, Diagnostics::new(source, errors));
    }
    if !failures.is_empty() {
        return Err(BuildError { diagnostics: failures, others: Vec::new() });
    }
    let wanted: Vec<&str> = scene.entries.iter().map(|entry| entry.function.0.as_str()).collect();
    let left_out = definitions().map(|definition| definition.name.clone());
    let left_out = left_out.filter(|name| !wanted.contains(&name.as_str())).collect();
    let request = Request::default().with(scene.options.iter().map(|stated| &stated.choice));
    let mut full = Vec::new();
    let mut units = Vec::new();
    for force in forces {
        full.extend(force.full);
        let names = force.definitions.into_iter().map(|definition| definition.name).collect();
        let (source, docs) = (force.file.source.clone(), force.file.docs());
        let compiled = Compiled { source, docs, names, functions: force.kernels, warnings: Vec::new() };
        units.push(Unit { path: force.path, compiled });
    }
    let sources = scene.forces.iter().map(|(path, _)| folder.join(path)).collect();
    Ok(Scene { sources, out: folder.join(&scene.out), request, units, full, left_out, again })
}

/// Whether kernels with these names and layouts define a common C name.
fn meet(one: (&str, Layout), other: (&str, Layout)) -> bool {
    let defined = |(name, layout): (&str, Layout)| {
        defined_for(name, &layout.tables()).into_iter().filter(|(target, _)| *target == Target::C)
    };
    one.0 == other.0 || defined(one).any(|item| defined(other).any(|own| own == item))
}

/// The position of the option that conflicts with a layout: the first match of `stated`.
fn conflicting<'s>(request: &Request, mut stated: impl Iterator<Item = &'s Stated>) -> Option<Span> {
    let decides = request.layout.row().computes.is_some() && request.outputs != Part::DEFAULT;
    let found = stated.find(|stated| match stated.choice {
        Choice::Outputs(_) => decides,
        Choice::Lanes(_) => !decides,
        _ => false,
    });
    found.map(|stated| stated.span)
}

/// Reads and checks the force files.
fn forces(
    named: &[(String, Span)],
    folder: &Path,
    source: &Source,
    wanted: &dyn Fn(&str) -> bool,
    warn: &mut dyn FnMut(Diagnostics),
) -> Result<Vec<Force>, BuildError> {
    let mut missing = Vec::new();
    for (path, at) in named.iter().filter(|(path, _)| !folder.join(path).exists()) {
        let there = folder.join(path);
        let error = Diagnostic::error(
            *at,
            format!("no force file `{path}`"),
            format!("`{}` is not there", shown(&there)),
        );
        missing.push(error.help("paths count from the folder of the scene"));
    }
    if !missing.is_empty() {
        return Err(Diagnostics::new(source.clone(), missing).into());
    }
    let paths: Vec<PathBuf> = named.iter().map(|(path, _)| folder.join(path)).collect();
    let found = files::read_all(&paths);
    let mut wrong = BuildError::from(found.errors);
    let mut forces = Vec::new();
    for (path, source) in found.sources {
        let checked = syntax::parse(&source).and_then(|file| {
            let known = |_: &ast::Function| Specialization::default();
            Ok((check_knowing(&file, &known, wanted, false)?, file))
        });
        match checked {
            Ok((checked, file)) => {
                if !checked.warnings.is_empty() {
                    warn(Diagnostics::new(source, checked.warnings));
                }
                let definitions = checked.definitions;
                forces.push(Force { path, file, definitions, kernels: Vec::new(), full: Vec::new() });
            }
            Err(errors) => wrong.diagnostics.push(errors),
        }
    }
    if wrong.is_empty() { Ok(forces) } else { Err(wrong) }
}

/// The force function with this name: the indices of its file and of its definition.
fn find(forces: &[Force], name: &str, at: Span, errors: &mut Vec<Diagnostic>) -> Option<(usize, usize)> {
    let all = forces.iter().enumerate().flat_map(|(index, force)| {
        force
            .definitions
            .iter()
            .enumerate()
            .map(move |(at, definition)| (index, at, definition.name.as_str()))
    });
    let found: Vec<(usize, usize)> =
        all.clone().filter(|(.., own)| *own == name).map(|(index, at, _)| (index, at)).collect();
    match found.as_slice() {
        [one] => return Some(*one),
        [] => {
            let names: Vec<&str> = all.map(|(.., own)| own).collect();
            let message = format!("no force function `{name}`");
            let error = Diagnostic::error(at, message, "none of the force files has it");
            errors.push(error.help(suggestion(name, &names)));
        }
        several => {
            let files: Vec<String> = several.iter().map(|(index, _)| shown(&forces[*index].path)).collect();
            let label = format!("it is in {}", files.join(" and in "));
            let error =
                Diagnostic::error(at, format!("`{name}` is the name of several force functions"), label);
            errors.push(error.help("rename one of them"));
        }
    }
    None
}

/// Errors for specialised names that a function does not have, and for values that do not fit.
fn misfits(definition: &Definition, stated: &Stated, entry: &Entry) -> Vec<Diagnostic> {
    let Choice::Known(known) = &stated.choice else { return Vec::new() };
    let mut errors = Vec::new();
    let own = |what: &str| -> Vec<String> { names(definition, what, entry) };
    for ((what, name), place) in known.names().zip(&stated.places) {
        let own = own(what);
        let own: Vec<&str> = own.iter().map(String::as_str).collect();
        if !own.contains(&name.as_str()) {
            let label = format!("`{}` has no such {what}", definition.name);
            let error = Diagnostic::error(*place, format!("no {what} `{name}`"), label);
            errors.push(error.help(suggestion(name, &own)));
        }
        let parameter = definition.graph.signature.parameters.iter().find(|own| own.name == *name);
        let fits = parameter.map(|parameter: &Parameter| known.give(&mut parameter.clone()));
        if let Some(Err((message, help))) = fits {
            let label = format!("set here for `{}`", definition.name);
            errors.push(Diagnostic::error(*place, message, label).help(help));
        }
    }
    let moves = |name: &String| !known.fixed.contains(name);
    let bodies = &definition.graph.signature.bodies;
    if errors.is_empty() && !bodies.iter().any(|body| moves(&body.name)) {
        let message = format!("no body of `{}` moves", definition.name);
        errors.push(Diagnostic::error(stated.span, message, "all of them are fixed").help("leave one free"));
    }
    errors
}

/// The names of a function's bodies, or of its parameters and its kernels' extra arguments.
fn names(definition: &Definition, what: &str, entry: &Entry) -> Vec<String> {
    let signature = &definition.graph.signature;
    if what == "body" {
        return signature.bodies.iter().map(|body| body.name.clone()).collect();
    }
    let layout = entry.options.iter().find_map(|stated| match &stated.choice {
        Choice::Layout(layout) => Some(*layout),
        _ => None,
    });
    let layouts = entry.integrator.needs.iter().map(|(_, layout)| *layout).chain(layout);
    let parts = layouts.filter_map(|layout| layout.row().computes).flatten().copied().collect::<Vec<Part>>();
    let extras = Part::extras(&parts).into_iter().map(|extra| extra.parameter(signature).name);
    signature.parameters.iter().map(|parameter| parameter.name.clone()).chain(extras).collect()
}

/// The part of a scene-wide option that applies to a function.
fn fitting(choice: &Choice, definition: &Definition) -> Option<Choice> {
    let Choice::Known(known) = choice else { return Some(choice.clone()) };
    let signature = &definition.graph.signature;
    let mut known = known.clone();
    known.fixed.retain(|name| signature.bodies.iter().any(|body| body.name == *name));
    Some(Choice::Known(known))
}

/// An error for each name in a scene-wide option that no function has.
fn nowhere<'d>(
    stated: &Stated,
    definitions: impl Iterator<Item = &'d Definition> + Clone,
) -> Vec<Diagnostic> {
    let Choice::Known(known) = &stated.choice else { return Vec::new() };
    let signatures = definitions.map(|definition| &definition.graph.signature);
    let bodies: Vec<&str> =
        signatures.clone().flat_map(|signature| &signature.bodies).map(|body| body.name.as_str()).collect();
    let parameters = signatures.flat_map(|signature| &signature.parameters).map(|p| p.name.as_str());
    let parameters: Vec<&str> = parameters.chain(["step"]).collect();
    let known = known.names();
    let wanted = known.map(|(what, name)| (what, name, if what == "body" { &bodies } else { &parameters }));
    let unknown = wanted.zip(&stated.places).filter(|((_, name, names), _)| !names.contains(&name.as_str()));
    let error = |((what, name, names), place): ((&str, &String, &Vec<&str>), &Span)| {
        let label = "none of the force functions has it";
        let error = Diagnostic::error(*place, format!("no {what} `{name}`"), label);
        Diagnostic { help: suggest::did_you_mean(name, names.iter().copied()), ..error }
    };
    unknown.map(error).collect()
}
