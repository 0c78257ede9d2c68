//! Shared code of the external tests: force files, work folders, programs to run, and the cases of the
//! oracle.
//!
//! These tests use forcec as a user does, through the library, the command line or the emitted text, and
//! compare results with references that share no code with forcec: 320-bit arithmetic, a C compiler, rustc,
//! clippy.

mod any_options;
pub mod cases;
pub mod covering;
pub mod driver;
pub mod sweep;
pub mod wrong;

pub use forcec::internals::math::random::Random;

use forcec::internals::compile::{Compiled, Request, compile};
use forcec::internals::kernel::{File, Precision};
use forcec::internals::layout::{LANES, LAYOUTS, Layout};
use forcec::internals::model::bodies::{Role, Signature, Slot};
use forcec::internals::model::outputs::Part;
use forcec::internals::source::span::Source;
use forcec::internals::{check, syntax};
use forcec::{Plan, Specialization};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

/// A compiled force file of this repository.
pub struct ForceFile {
    /// File name without folder and extension.
    pub stem: String,
    /// All kernels of the file.
    pub compiled: Compiled,
}

impl ForceFile {
    /// The file in the form that a target prints.
    pub fn printable(&self, precisions: &[Precision]) -> File {
        File {
            stem: self.stem.clone(),
            docs: self.compiled.docs.clone(),
            kernels: self.compiled.functions.iter().map(|function| function.kernel.clone()).collect(),
            precisions: precisions.to_vec(),
        }
    }
}

/// The library: `constraints/*.rs`.
pub fn library() -> Vec<ForceFile> {
    files("../constraints")
}

/// One file of the library, compiled with a plan.
pub fn library_with(plan: Plan, stem: &str) -> ForceFile {
    let text = library_text(stem);
    ForceFile { compiled: compiled_with(stem, &text, plan), stem: stem.to_owned() }
}

/// Force files on which nothing was tuned: `tests/unseen/*.rs`.
pub fn unseen() -> Vec<ForceFile> {
    files("unseen")
}

fn files(folder: &str) -> Vec<ForceFile> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a folder can be read").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "rs"));
    paths.sort();
    assert!(!paths.is_empty(), "{} has force files", folder.display());
    let mut files = parallel(paths, |path| {
        let text = std::fs::read_to_string(&path).expect("a force file can be read");
        let stem = path.file_stem().expect("a file has a name").to_string_lossy().into_owned();
        ForceFile { compiled: compiled(&stem, &text), stem }
    });
    // The longest files first, so that parallel work does not end with one thread working on a long file.
    files.sort_by_key(|file| std::cmp::Reverse(file.compiled.functions.len()));
    files
}

/// Unusual kernels, one force file each: with a fixed body and parameters set to constants, and with selected
/// results.
pub fn special() -> Vec<ForceFile> {
    let set = ["arm_b=[0, -0.3, 0.5]", "damping=0.7", "stiffness=20"];
    let set = set.map(|text| Specialization::parse_value(text).expect("a value")).to_vec();
    let known = Specialization { fixed: vec!["b".to_owned()], set };
    let values = Part::chosen(["value", "rate", "jacobian", "dfdv"]).expect("names of results");
    let requests = [
        ("joints", Request { known, ..Request::default() }),
        ("springs", Request { outputs: values.clone(), ..Request::default() }),
        ("solids", Request { outputs: values, ..Request::default() }),
        ("contacts", Request { outputs: vec![Part::Force], ..Request::default() }),
        ("cloth", Request { outputs: held(), ..Request::default() }),
    ];
    requests.map(|(stem, request)| requested(stem, request)).into()
}

/// Some kernels of each kind: springs have square roots, contacts have branches, joints have all other
/// operations.
const KINDS: [(&str, &[&str]); 3] = [
    ("springs", &["spring", "polynomial_spring", "rope", "rod_bend"]),
    ("contacts", &["hertz_contact", "sphere_plane_friction", "sphere_sphere"]),
    ("joints", &["point_to_point", "distance", "pin", "attachment", "torsion_spring", "hinge_motor"]),
];

/// A kernel that is split into several functions unless the kernel computes several instances.
const LONG: &str = "bushing";

/// Kernels of the library in every layout, for one instance and for several, some with prepared values; one
/// file each with the tested precisions: both for one instance, one for several instances.
pub fn laid_out() -> Vec<(ForceFile, &'static [Precision])> {
    let mut text = String::new();
    for (stem, _) in KINDS {
        let file = library_text(stem);
        file.lines().filter(|line| !line.starts_with("//!")).for_each(|line| text.extend([line, "\n"]));
    }
    let source = Source::new("kinds.rs", text);
    let all = LAYOUTS.iter().flat_map(|row| LANES.map(|lanes| (row.layout, lanes)));
    let ways = all.filter(|way| *way != (Layout::Dense, 1)).map(|way| (way, false));
    let prepared = [(Layout::Dense, 1), (Layout::Packed, 4), (Layout::Accumulate, 1), (Layout::System, 8)];
    let ways = ways.chain(prepared.map(|way| (way, true)));
    let requests =
        ways.map(|((layout, lanes), prepare)| Request { layout, lanes, prepare, ..Request::default() });
    let of_constraints = [(Layout::Accumulate, 1), (Layout::Packed, 4), (Layout::Dense, 8)]
        .map(|(layout, lanes)| Request { layout, lanes, outputs: held(), ..Request::default() });
    let requests = requests.filter(|request| request.conflict().is_none()).chain(of_constraints);
    let constraints = constraints(&source);
    parallel(requests.collect(), |request: Request| {
        let chosen = |name: &str| KINDS.iter().any(|(_, names)| names.contains(&name));
        let held = request.outputs == held();
        let wanted = |name: &str| match held {
            true => chosen(name) && constraints.iter().any(|own| own == name),
            false => chosen(name) || name == LONG && request.lanes == 1,
        };
        let compiled = compile(&source, &wanted, request.clone());
        let compiled = compiled.unwrap_or_else(|errors| panic!("{errors}"));
        let precisions: &[Precision] = match request.lanes {
            1 => &[Precision::F64, Precision::F32],
            4 => &[Precision::F64],
            _ => &[Precision::F32],
        };
        let stem = match (held, request.prepare) {
            (true, _) => "held_kinds",
            (_, true) => "prepared_kinds",
            _ => "kinds",
        };
        (ForceFile { stem: stem.to_owned(), compiled }, precisions)
    })
}

/// The results that only constraints have, and F.
fn held() -> Vec<Part> {
    let own = Part::choices().filter(|row| row.of_constraints || row.part == Part::Force);
    own.map(|row| row.part).collect()
}

/// The constraints of a text, by name.
fn constraints(source: &Source) -> Vec<String> {
    let checked = syntax::parse(source).and_then(|file| check::check(&file));
    let definitions = checked.unwrap_or_else(|errors| panic!("{errors}")).definitions;
    let own = definitions.into_iter().filter(|own| own.law.has_multipliers());
    own.map(|own| own.name).collect()
}

/// The text of a file of the library.
pub fn library_text(stem: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../constraints").join(format!("{stem}.rs"));
    std::fs::read_to_string(&path).expect("the library can be read")
}

/// A file of the library compiled with a request; only the constraints of the file if the request applies
/// only to constraints.
pub fn requested(stem: &str, request: Request) -> ForceFile {
    let source = Source::new(format!("{stem}.rs"), library_text(stem));
    let of_constraints = request.outputs.iter().any(|part| part.row().of_constraints);
    let constraints = if of_constraints { constraints(&source) } else { Vec::new() };
    let wanted = |name: &str| !of_constraints || constraints.iter().any(|own| own == name);
    let compiled = compile(&source, &wanted, request);
    let compiled = compiled.unwrap_or_else(|errors| panic!("{errors}"));
    ForceFile { stem: stem.to_owned(), compiled }
}

/// Compiles a valid text.
pub fn compiled(name: &str, text: &str) -> Compiled {
    compiled_with(name, text, Plan::default())
}

/// Compiles a valid text with a plan.
pub fn compiled_with(name: &str, text: &str, plan: Plan) -> Compiled {
    match compile(&Source::new(format!("{name}.rs"), text), &|_| true, plan) {
        Ok(compiled) => compiled,
        Err(errors) => panic!("{name} does not compile:\n{errors}\n{text}"),
    }
}

/// Random options from a seed, for a text whose bodies and parameters the options may name.
pub fn options_for(text: &str, seed: u64) -> forcec::Options {
    let mut random = Random::new(seed);
    any_options::any_options(text, &mut |n| random.below(n))
}

/// An empty folder of this name. `base` is `env!("CARGO_TARGET_TMPDIR")`, which cargo defines only for the
/// tests themselves.
pub fn folder(base: &str, name: &str) -> PathBuf {
    let path = Path::new(base).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("the build folder can be written");
    path
}

/// Runs a program that must succeed.
pub fn run(folder: &Path, program: &str, arguments: &[&str]) {
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    let output = output.unwrap_or_else(|e| panic!("{program}: {e}"));
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {arguments:?} in {}\n{text}{errors}", folder.display());
}

/// Compiles `STEM.rs` and runs clippy and rustfmt on the file; any message is a failure.
pub fn lint(folder: &Path, stem: &str) {
    let file = format!("{stem}.rs");
    let library = format!("#![deny(missing_docs)]\n//! A crate.\n\npub mod {stem};\n");
    // The configuration of a parent folder must not affect rustfmt or clippy.
    for (name, text) in [("lib.rs", library.as_str()), ("rustfmt.toml", ""), ("clippy.toml", "")] {
        std::fs::write(folder.join(name), text).expect("the build folder can be written");
    }
    run(folder, "rustfmt", &["--edition", "2024", "--check", &file]);
    let strict = ["--edition", "2024", "-D", "warnings", "--crate-type", "lib", "--emit", "metadata"];
    run(folder, "rustc", &[&strict[..], &[&file]].concat());
    run(folder, "clippy-driver", &[&strict[..], &["-D", "clippy::all", "lib.rs"]].concat());
}

/// Runs a program that maps doubles to doubles, both as raw memory in files.
pub fn pipe(program: &Path, input: &[f64]) -> Vec<f64> {
    let input_path = program.with_extension("in");
    let bytes: Vec<u8> = input.iter().flat_map(|x| x.to_ne_bytes()).collect();
    std::fs::write(&input_path, bytes).expect("the build folder can be written");
    let input = std::fs::File::open(&input_path).expect("the input was just written");
    let output = Command::new(program).stdin(Stdio::from(input)).output();
    let output = output.unwrap_or_else(|e| panic!("{}: {e}", program.display()));
    assert!(output.status.success(), "{} fails", program.display());
    let words = output.stdout.chunks_exact(8);
    assert!(words.remainder().is_empty(), "{} writes doubles", program.display());
    words.map(|word| f64::from_ne_bytes(word.try_into().expect("eight bytes"))).collect()
}

/// Parallel map over all processors; results are in the order of the items.
pub fn parallel<T: Send, R: Send>(items: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let count = items.len();
    let queue = Mutex::new(items.into_iter().enumerate());
    let results: Mutex<Vec<(usize, R)>> = Mutex::new(Vec::with_capacity(count));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.min(count))
            .map(|_| {
                scope.spawn(|| {
                    loop {
                        let next = queue.lock().expect("no worker panics with the queue").next();
                        let Some((index, item)) = next else { break };
                        let result = work(item);
                        results.lock().expect("no worker panics with the results").push((index, result));
                    }
                })
            })
            .collect();
        for worker in workers {
            if let Err(panic) = worker.join() {
                std::panic::resume_unwind(panic);
            }
        }
    });
    let mut results = results.into_inner().expect("every worker is done");
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Offsets of inputs, and in particular of positions, in the flat inputs of a kernel.
pub struct Places {
    /// Offsets by argument and field.
    pub starts: Vec<Vec<usize>>,
    /// Offsets of the positions of bodies.
    pub positions: Vec<usize>,
}

impl Places {
    /// Computes the offsets for a signature.
    pub fn new(signature: &Signature) -> Places {
        let mut length = 0;
        let mut place = |count: usize| {
            length += count;
            length - count
        };
        let (mut starts, mut positions) = (Vec::new(), Vec::new());
        for body in &signature.bodies {
            let fields = body.kind.row().fields;
            let places: Vec<usize> = fields.iter().map(|field| place(field.length as usize)).collect();
            let own = fields.iter().zip(&places).filter(|(field, _)| field.role == Role::Position);
            positions.extend(own.map(|(_, place)| *place));
            starts.push(places);
        }
        starts
            .extend(signature.parameters.iter().map(|parameter| vec![place(parameter.ty.length() as usize)]));
        Places { starts, positions }
    }

    /// Offset of a slot.
    pub fn of(&self, slot: Slot) -> usize {
        self.starts[slot.argument as usize][slot.field as usize] + slot.offset as usize
    }
}
