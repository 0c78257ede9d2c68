//! Run times of kernels: emitted C and Rust, C written by hand and C from peers, timed in turn in one
//! process.
//!
//! Input: a [`Plan`]. Output: a [`Row`] for each kernel and maker. The library is compiled, printed, and
//! built by gcc and rustc into one program together with the driver that this module writes. The driver first
//! compares the results of every maker with the program evaluated in 320 bits, then times the correct kernels
//! in rounds. All statistics are computed from the lists of times.

use crate::peers::Peer;
use crate::{compile_all, library};
use forcec::internals::compile::{Compiled, Stages};
use forcec::internals::kernel::{File, Precision};
use forcec::internals::model::bodies::{Body, Signature};
use forcec::internals::names::{Target, kernel_name};
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{Family, Subject};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Kernels that also exist hand-written in `bench/hand`.
pub const BY_HAND: [&str; 3] = ["point_to_point", "distance", "spring"];

/// Number of states at which a kernel is called in each round, in a fixed order.
pub const STATES: usize = 1024;

/// Default flags for gcc; the command line can replace these flags. In GNU C, its default dialect, gcc fuses
/// products and sums.
pub const FLAGS: &str = "-O3 -march=native -fno-math-errno";

/// Flags for rustc.
pub const RUST_FLAGS: &str = "-C opt-level=3 -C target-cpu=native -C panic=abort";

/// Largest relative error that can be rounding. A kernel with a larger error is wrong and is not timed.
pub const WRONG: f64 = 1e-9;

/// An implementation of a kernel.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Maker {
    /// Name in tables: `hand`, `C` and `Rust` (emitted by forcec), or a peer.
    pub name: String,
    /// How the problem was formulated for a peer.
    pub formulation: String,
    /// The function that the driver calls; its interface is that of the emitted C.
    pub symbol: String,
    /// Source file to compile for this maker, in addition to the files that forcec emits.
    pub source: Option<PathBuf>,
}

impl Maker {
    /// All makers of a kernel, hand-written code first.
    fn all(plan: &Plan, kernel: &str) -> Vec<Maker> {
        let maker = |name: &str, symbol: String, source: Option<PathBuf>| Maker {
            name: name.to_owned(),
            formulation: String::new(),
            symbol,
            source,
        };
        let hand = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("hand/{kernel}.c"));
        let by_hand = BY_HAND.contains(&kernel).then(|| maker("hand", format!("hand_{kernel}"), Some(hand)));
        let ours = [
            maker("C", kernel_name(kernel, Target::C, "_f64"), None),
            maker("Rust", format!("rust_{kernel}"), None),
        ];
        let peers = plan.peers.iter().filter(|peer| peer.kernel == kernel).map(|peer| Maker {
            formulation: peer.formulation.clone(),
            ..maker(&peer.name, peer.symbol.clone(), Some(peer.source.clone()))
        });
        by_hand.into_iter().chain(ours).chain(peers).collect()
    }
}

/// Selection and settings of a measurement.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Names of the kernels to measure; if empty, all kernels.
    pub only: Vec<String>,
    /// Number of timing rounds for each kernel.
    pub rounds: usize,
    /// Flags for gcc, used for all C code.
    pub flags: Vec<String>,
    /// Kernels from other tools.
    pub peers: Vec<Peer>,
}

/// Distribution of times, or of ratios of times, of one kernel over all rounds.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// The minimum.
    pub least: f64,
    /// The lower quartile.
    pub low: f64,
    /// The median.
    pub median: f64,
    /// The upper quartile.
    pub high: f64,
}

impl Spread {
    pub(crate) fn of(mut values: Vec<f64>) -> Spread {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        Spread { least: at(0.0), low: at(0.25), median: at(0.5), high: at(0.75) }
    }
}

/// The results for the kernel of one maker.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the kernel.
    pub kernel: String,
    /// The implementation.
    pub maker: Maker,
    /// Nanoseconds per call; `None` for a wrong kernel.
    pub time: Option<Spread>,
    /// Time divided by the time of the hand-written kernel in the same round.
    pub ratio: Option<Spread>,
    /// Time divided by the time of the emitted C in the same round.
    pub to_ours: Option<Spread>,
    /// The largest error over all states against the program in 320 bits, relative to the largest entry of
    /// the same part of the output.
    pub error: f64,
    /// Compile time in seconds; `None` for code that is compiled together with other kernels.
    pub compilation: Option<f64>,
}

/// Times and errors as a table.
pub fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| kernel | code | median | quartiles | least | by hand = 1 | quartiles | error |\n\
         |---|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for row in rows {
        let ratio = row.ratio.map_or("| | ".to_owned(), |ratio| {
            format!("| {:.2} | {:.2} … {:.2} ", ratio.median, ratio.low, ratio.high)
        });
        let time = row.time.map_or("wrong | | ".to_owned(), |time| {
            format!("{:.1} | {:.1} … {:.1} | {:.1} ", time.median, time.low, time.high, time.least)
        });
        text += &format!("| `{}` | {} | {time}{ratio}| {:.0e} |\n", row.kernel, row.maker.name, row.error);
    }
    text
}

/// Runs the measurement and leaves the build products in `folder`. Panics when a compiler or the driver
/// fails.
pub fn measure(plan: &Plan, folder: &Path) -> Vec<Row> {
    std::fs::create_dir_all(folder).expect("a folder to build in");
    let wanted = |name: &str| plan.only.is_empty() || plan.only.iter().any(|only| only == name);
    let files: Vec<(File, Compiled)> =
        library().iter().map(|source| printable(compile_all(source))).collect();
    let mut kernels: Vec<(&str, &Stages)> = Vec::new();
    for (file, compiled) in &files {
        let stages = compiled.functions.iter().filter(|stages| wanted(&stages.kernel.name));
        kernels.extend(stages.map(|stages| (file.stem.as_str(), stages)));
    }
    let kernels: Vec<(&str, &Stages, Vec<Maker>)> = kernels
        .into_iter()
        .map(|(stem, stages)| (stem, stages, Maker::all(plan, &stages.kernel.name)))
        .collect();
    let seconds = build(plan, folder, &files, &kernels);
    let answer = run(Command::new(folder.join("driver")).arg("states").arg(plan.rounds.to_string()), folder);
    let mut rows = Vec::new();
    for (index, (_, stages, makers)) in kernels.iter().enumerate() {
        let values = |what: &str, place: usize| reported(&answer, &format!("{what} {index} {place} "));
        let times: Vec<Vec<f64>> = (0..makers.len()).map(|place| values("time", place)).collect();
        for (place, maker) in makers.iter().enumerate() {
            let right = !times[place].is_empty();
            let against = |name: &str| {
                let other = makers.iter().position(|maker| maker.name == name).filter(|_| right)?;
                let quotients: Vec<f64> =
                    times[place].iter().zip(&times[other]).map(|(x, y)| x / y).collect();
                (!quotients.is_empty()).then(|| Spread::of(quotients))
            };
            rows.push(Row {
                kernel: stages.kernel.name.clone(),
                maker: maker.clone(),
                time: right.then(|| Spread::of(times[place].clone())),
                ratio: against("hand"),
                to_ours: against("C"),
                error: values("error", place)[0],
                compilation: seconds.get(&maker.symbol).copied(),
            });
        }
    }
    rows
}

/// A compiled file in the form that the targets print, and the compiled file itself.
pub(crate) fn printable(compiled: Compiled) -> (File, Compiled) {
    let file = File {
        stem: compiled.source.name.trim_end_matches(".rs").to_owned(),
        docs: compiled.docs.clone(),
        kernels: compiled.functions.iter().map(|stages| stages.kernel.clone()).collect(),
        precisions: vec![Precision::F64],
    };
    (file, compiled)
}

/// Writes `driver` and `states` into the folder. Returns the compile time of each C object in seconds.
fn build(
    plan: &Plan,
    folder: &Path,
    files: &[(File, Compiled)],
    kernels: &[(&str, &Stages, Vec<Maker>)],
) -> BTreeMap<String, f64> {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("a file to build");
    let used: Vec<&File> = files
        .iter()
        .map(|(file, _)| file)
        .filter(|file| kernels.iter().any(|(stem, ..)| *stem == file.stem))
        .collect();
    for (file, _) in files {
        for target in [Target::C, Target::Rust] {
            for generated in forcec::internals::emit::emit(file, target) {
                write(&generated.name, &generated.text);
            }
        }
    }
    let mut objects = Vec::new();
    let mut seconds = BTreeMap::new();
    let mut compile = |source: &Path, name: &str| {
        seconds.insert(name.to_owned(), compile(plan, folder, source, name));
        objects.push(format!("{name}.o"));
    };
    for file in &used {
        compile(Path::new(&format!("{}.c", file.stem)), &file.stem);
    }
    for maker in kernels.iter().flat_map(|(_, _, makers)| makers) {
        if let Some(source) = &maker.source {
            compile(source, &maker.symbol);
        }
    }
    write("driver.c", &driver(kernels));
    compile(Path::new("driver.c"), "driver");
    write("kernels.rs", &wrappers(&used, kernels));
    let mut rustc = Command::new("rustc");
    rustc.args(["--edition", "2024", "--crate-type", "staticlib"]).args(RUST_FLAGS.split(' '));
    run(rustc.args(["kernels.rs", "-o", "libkernels.a"]), folder);
    let mut gcc = Command::new("gcc");
    // A library linked by its full path is found again when the program runs.
    gcc.args(&objects).args(crate::peers::libraries(&plan.peers));
    run(gcc.args(["libkernels.a", "-lm", "-lpthread", "-ldl", "-o", "driver"]), folder);
    let states: Vec<u8> = kernels.iter().flat_map(|(_, stages, _)| states(stages)).collect();
    std::fs::write(folder.join("states"), states).expect("a file of states");
    seconds
}

/// Compiles a C or C++ file to `NAME.o` and returns the compile time in seconds.
pub fn compile(plan: &Plan, folder: &Path, source: &Path, name: &str) -> f64 {
    let start = Instant::now();
    let cpp = source.extension().is_some_and(|ending| ending == "cc");
    let mut compiler = Command::new(if cpp { "g++" } else { "gcc" });
    compiler.args(&plan.flags).arg("-I.");
    if let Some(folder) = source.parent() {
        compiler.arg("-isystem").arg(folder.join("include"));
    }
    run(compiler.arg("-c").arg(source).args(["-o", &format!("{name}.o")]), folder);
    start.elapsed().as_secs_f64()
}

/// The regular states of a kernel in memory order, followed by the kernel's results in 320 bits at all
/// states.
fn states(stages: &Stages) -> Vec<u8> {
    let subject = Subject { source: &stages.source, program: &stages.program };
    let probe = Probe::new(&subject);
    let drawn = (0..).map(|state| {
        let inputs = probe.draw(Family::Random, 1, state);
        let outputs = probe.program(&inputs);
        (inputs, outputs)
    });
    let regular = drawn.filter(|(_, outputs)| outputs.iter().all(|x| x.is_finite())).take(STATES);
    let (inputs, outputs): (Vec<_>, Vec<_>) = regular.unzip();
    bytes(inputs.into_iter().chain(outputs).flatten(), Precision::F64)
}

/// Runs a command in the folder and returns its standard output.
pub(crate) fn run(command: &mut Command, folder: &Path) -> String {
    let output = match command.current_dir(folder).output() {
        Ok(output) => output,
        Err(error) => panic!("{command:?}: {error}"),
    };
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The numbers that a driver prints after the prefix `head`, one number per line.
pub(crate) fn reported(answer: &str, head: &str) -> Vec<f64> {
    let values = answer.lines().filter_map(|line| line.strip_prefix(head));
    values.map(|value| value.parse().expect("a number of the driver")).collect()
}

/// The C types of a kernel's arguments before the output, for a kernel that computes `lanes` instances per
/// call.
pub(crate) fn arguments(
    name: &str,
    signature: &Signature,
    precision: Precision,
    lanes: usize,
) -> Vec<String> {
    let several = if lanes > 1 { format!("x{lanes}") } else { String::new() };
    let body = |body: &Body| format!("{}_{precision}{several}", body.kind.row().c_name);
    let params = (!signature.parameters.is_empty())
        .then(|| kernel_name(name, Target::C, &format!("_params_{precision}")));
    signature.bodies.iter().map(body).chain(params).collect()
}

/// States in the memory order of a kernel that computes `lanes` instances per call: entry by entry within
/// each group.
pub(crate) fn interleaved<'s>(states: &'s [&Vec<f64>], lanes: usize) -> impl Iterator<Item = f64> + 's {
    let groups = states.chunks(lanes);
    groups.flat_map(|group| (0..group[0].len()).flat_map(move |k| group.iter().map(move |x| x[k])))
}

/// The bytes of numbers in memory.
pub(crate) fn bytes(reals: impl Iterator<Item = f64>, precision: Precision) -> Vec<u8> {
    match precision {
        Precision::F64 => reals.flat_map(f64::to_ne_bytes).collect(),
        Precision::F32 => reals.flat_map(|x| (x as f32).to_ne_bytes()).collect(),
    }
}

const HEAD: &str = "\
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* How far y is from x in a part of the outputs, relative to its largest entry. */
static double apart(const double *x, const double *y, int count)
{
    double most = 0.0, largest = 0.0;
    for (int i = 0; i < count; i++) {
        if (!isfinite(y[i])) return HUGE_VAL;
        most = fmax(most, fabs(x[i] - y[i]));
        largest = fmax(largest, fabs(x[i]));
    }
    return most > 0.0 ? most / largest : 0.0;
}
";

/// C code of a clock: the processor time of the thread in nanoseconds.
pub(crate) const CLOCK: &str = "
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}
";

const TAIL: &str = "
int main(int count, char **arguments)
{
    FILE *states = count == 3 ? fopen(arguments[1], \"rb\") : NULL;
    if (!states) return 1;
    static char right[sizeof all / sizeof *all][MAKERS];
    const int kernels = (int)(sizeof all / sizeof *all), rounds = atoi(arguments[2]);
    for (int k = 0; k < kernels; k++)
        if (!all[k].take(states)) return 1;
    for (int k = 0; k < kernels; k++)
        for (int m = 0; m < all[k].makers; m++) {
            const double error = all[k].compare(m);
            right[k][m] = error <= WRONG;
            printf(\"error %d %d %g\\n\", k, m, error);
        }
    for (int round = 0; round < rounds; round++)
        for (int k = 0; k < kernels; k++) {
            int cold = 1;
            for (int m = 0; m < all[k].makers; m++) {
                const int turn = (round + m) % all[k].makers;
                if (!right[k][turn]) continue;
                if (cold) all[k].run[turn](); /* brings the states into the cache */
                cold = 0;
                const double start = now();
                all[k].run[turn]();
                printf(\"time %d %d %.3f\\n\", k, turn, (now() - start) / STATES);
            }
        }
    return 0;
}
";

/// The C driver program: for each kernel the states, one function per maker that calls the kernel at every
/// state, and a comparison of the results.
fn driver(kernels: &[(&str, &Stages, Vec<Maker>)]) -> String {
    let most = kernels.iter().map(|(_, _, makers)| makers.len()).max().unwrap_or(0);
    let mut text =
        format!("{HEAD}{CLOCK}\n#define STATES {STATES}\n#define MAKERS {most}\n#define WRONG {WRONG:e}\n");
    let mut stems: Vec<&str> = kernels.iter().map(|(stem, ..)| *stem).collect();
    stems.dedup();
    for stem in stems {
        let _ = writeln!(text, "#include \"{stem}.h\"");
    }
    let mut table = String::new();
    for (_, stages, makers) in kernels {
        let (name, signature) = (&stages.kernel.name, &stages.kernel.schedule.signature);
        let types = arguments(name, signature, Precision::F64, 1);
        let out = kernel_name(name, Target::C, "_out_f64");
        let members: String = types.iter().enumerate().map(|(i, ty)| format!("{ty} m{i}; ")).collect();
        let declared: String = types.iter().map(|ty| format!("const {ty} *, ")).collect();
        let passed: String = (0..types.len()).map(|i| format!("&of_{name}[i].m{i}, ")).collect();
        let _ = write!(
            text,
            "\nstatic struct {{ {members}}} of_{name}[STATES];\nstatic _Alignas(64) {out} out_{name};\n\
             static {out} exact_{name}[STATES];\nstatic int take_{name}(FILE *file)\n{{\n    \
             return fread(of_{name}, sizeof *of_{name}, STATES, file) == STATES\n        \
             && fread(exact_{name}, sizeof *exact_{name}, STATES, file) == STATES;\n}}\n"
        );
        let (mut runs, mut calls) = (String::new(), String::new());
        for (place, Maker { symbol, .. }) in makers.iter().enumerate() {
            let _ = write!(
                text,
                "void {symbol}({declared}{out} *);\nstatic void run_{name}_{place}(void)\n{{\n    \
                 for (int i = 0; i < STATES; i++) {symbol}({passed}&out_{name});\n}}\n"
            );
            let _ = write!(runs, "run_{name}_{place}, ");
            let _ = writeln!(calls, "        if (maker == {place}) {symbol}({passed}&out_{name});");
        }
        let n = signature.dofs();
        let _ = write!(
            text,
            "static double compare_{name}(int maker)\n{{\n    double most = 0.0;\n    \
             for (int i = 0; i < STATES; i++) {{\n        memset(&out_{name}, 0xff, sizeof out_{name});\n{calls}        \
             const double *x = (const double *)&exact_{name}[i], *y = (const double *)&out_{name};\n        \
             most = fmax(most, apart(x, y, {n}));\n        \
             most = fmax(most, apart(x + {n}, y + {n}, {n} * {n}));\n        \
             most = fmax(most, apart(x + {n} + {n} * {n}, y + {n} + {n} * {n}, {n} * {n}));\n    }}\n    \
             return most;\n}}\n"
        );
        let count = makers.len();
        let _ = writeln!(table, "    {{ {count}, take_{name}, compare_{name}, {{ {runs}}} }},");
    }
    let _ = write!(
        text,
        "\nstatic const struct {{\n    int makers;\n    int (*take)(FILE *);\n    double (*compare)(int);\n    \
         void (*run[MAKERS])(void);\n}} all[] = {{\n{table}}};\n{TAIL}"
    );
    text
}

/// The crate that exports the emitted Rust as functions callable from C.
fn wrappers(files: &[&File], kernels: &[(&str, &Stages, Vec<Maker>)]) -> String {
    let mut text = String::new();
    for file in files {
        let _ = writeln!(text, "mod {};", file.stem);
    }
    for (stem, stages, _) in kernels {
        let (name, signature) = (&stages.kernel.name, &stages.kernel.schedule.signature);
        let module = kernel_name(name, Target::Rust, "");
        let mut types: Vec<String> =
            signature.bodies.iter().map(|body| format!("{stem}::{}", body.kind.row().name)).collect();
        if !signature.parameters.is_empty() {
            types.push(format!("{stem}::{module}::Params"));
        }
        let declared: String = types.iter().enumerate().map(|(i, ty)| format!("m{i}: &{ty}, ")).collect();
        let passed: String = (0..types.len()).map(|i| format!("m{i}, ")).collect();
        let _ = write!(
            text,
            "\n#[unsafe(no_mangle)]\npub extern \"C\" fn rust_{name}({declared}out: &mut {stem}::{module}::Output) {{\n    \
             {stem}::{module}::evaluate({passed}out)\n}}\n"
        );
    }
    text
}
