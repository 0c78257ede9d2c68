//! Kernels, run time against error: every kernel of the library in every mode, in one process, by turns.
//!
//! Input: the number of rounds. Output: a [`Point`] for each kernel and mode: nanoseconds per instance at
//! 1024 varying states, and the largest error at states of four families, against the program in 320 bits on
//! the same input bits. A mode has its own folder: the files that forcec prints, and a unit that reads states
//! and calls each kernel.

mod plot;

pub use plot::plot;

use crate::kernels::{CLOCK, STATES, Spread, arguments, bytes, interleaved, reported, run};
use crate::library;
use forcec::internals::compile::{Request, Stages, compile};
use forcec::internals::kernel::{File, Precision};
use forcec::internals::names::{Target, kernel_name};
use forcec::internals::sample::states::Family;
use forcec::internals::verify::Subject;
use forcec::internals::verify::probe::Probe;
use forcec::{Mode, Plan};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// A way to compute: options of the compiler.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Name in tables.
    pub name: &'static str,
    precision: Precision,
    mode: Mode,
    fma: bool,
    lanes: usize,
}

const fn way(name: &'static str, precision: Precision, mode: Mode, fma: bool, lanes: usize) -> Way {
    Way { name, precision, mode, fma, lanes }
}

/// All measured ways; times are relative to the first way.
pub static WAYS: [Way; 13] = [
    way("f64 balanced", Precision::F64, Mode::Balanced, false, 1),
    way("f64 balanced, fma", Precision::F64, Mode::Balanced, true, 1),
    way("f64 balanced, 4 lanes", Precision::F64, Mode::Balanced, false, 4),
    way("f64 strict", Precision::F64, Mode::Strict, false, 1),
    way("f64 strict, fma", Precision::F64, Mode::Strict, true, 1),
    way("f64 fast", Precision::F64, Mode::Fast, false, 1),
    way("f64 fast, fma", Precision::F64, Mode::Fast, true, 1),
    way("f64 accurate", Precision::F64, Mode::Accurate, false, 1),
    way("f32 balanced", Precision::F32, Mode::Balanced, false, 1),
    way("f32 balanced, 8 lanes", Precision::F32, Mode::Balanced, false, 8),
    way("f32 strict", Precision::F32, Mode::Strict, false, 1),
    way("f32 fast, fma", Precision::F32, Mode::Fast, true, 1),
    way("f32 accurate", Precision::F32, Mode::Accurate, false, 1),
];

/// The families at which errors are taken.
pub const FAMILIES: [Family; 4] = [Family::Random, Family::NearSingular, Family::Far, Family::Stiff];

/// States of each family.
const DRAWN: usize = 48;

/// The largest errors at the states of a family.
#[derive(Clone, Copy, Debug, Default)]
pub struct Error {
    /// Of an entry, relative to the largest of its array.
    pub normwise: f64,
    /// Of an entry that is not zero, relative to itself.
    pub componentwise: f64,
}

/// One kernel in one way.
#[derive(Clone, Debug)]
pub struct Point {
    /// The kernel's name.
    pub kernel: String,
    /// The way to compute.
    pub way: &'static Way,
    /// Nanoseconds an instance.
    pub time: Spread,
    /// Round by round, the time divided by that of the first way.
    pub ratio: Spread,
    /// For each family; those of a kernel of several lanes are those of one, which are the same by test.
    pub errors: [Error; FAMILIES.len()],
}

/// The kernels of a force file, compiled in the first way.
struct Subjects {
    stem: String,
    all: Vec<Stages>,
}

/// Measures kernels of these names; if empty, all kernels. The build products stay in `folder`.
pub fn measure(only: &[&str], rounds: usize, folder: &Path) -> Vec<Point> {
    let wanted = |name: &str| only.is_empty() || only.contains(&name);
    let compiled = |way: &Way| -> Vec<Subjects> {
        let plan = Plan { mode: way.mode, fma: way.fma, ..Plan::default() };
        let request = Request { lanes: way.lanes, ..plan.into() };
        let files = library().into_iter().map(|source| {
            let compiled = compile(&source, &wanted, request.clone());
            let all = compiled.unwrap_or_else(|diagnostics| panic!("{diagnostics}")).functions;
            Subjects { stem: source.name.trim_end_matches(".rs").to_owned(), all }
        });
        files.filter(|file| !file.all.is_empty()).collect()
    };
    let first = compiled(&WAYS[0]);
    let drawn: Vec<[Drawn; 2]> = first
        .iter()
        .flat_map(|file| &file.all)
        .map(|stages| Precision::ALL.map(|precision| draw(stages, precision)))
        .collect();

    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let (compiled, drawn) = (&compiled, &drawn);
            scope.spawn(move || {
                for (number, way) in WAYS.iter().enumerate().skip(thread).step_by(threads) {
                    build(way, number, &compiled(way), drawn, &folder.join(format!("w{number}")));
                }
            });
        }
    });
    let count = drawn.len();
    let mut names = String::new();
    for number in 0..WAYS.len() {
        let _ = writeln!(names, "extern const struct kernel w{number}_all[];\nint w{number}_take(FILE *);");
    }
    let list = |what: &str| (0..WAYS.len()).map(|n| format!("w{n}_{what}, ")).collect::<String>();
    let text = format!(
        "{HEAD}{CLOCK}\n{KERNEL}{names}\nenum {{ KERNELS = {count}, WAYS = {} }};\n\
         static const struct kernel *const all[] = {{ {}}};\nstatic int (*const take[])(FILE *) = {{ {}}};\n{MAIN}",
        WAYS.len(),
        list("all"),
        list("take")
    );
    std::fs::write(folder.join("driver.c"), text).expect("a file to build");
    let objects: Vec<String> = (0..WAYS.len()).map(|number| format!("w{number}/way.o")).collect();
    let mut gcc = Command::new("gcc");
    run(gcc.args(["-O2", "driver.c"]).args(&objects).args(["-lm", "-o", "driver"]), folder);
    let answer = run(Command::new("./driver").arg(rounds.to_string()), folder);
    let times = |number: usize, kernel: usize| -> Vec<f64> {
        let all = reported(&answer, &format!("{number} {kernel} "));
        all.into_iter().map(|time| time / STATES as f64).collect()
    };

    let mut points = Vec::new();
    let kernels: Vec<&Stages> = first.iter().flat_map(|file| &file.all).collect();
    for (kernel, stages) in kernels.iter().enumerate() {
        let base = times(0, kernel);
        for (number, way) in WAYS.iter().enumerate() {
            let own = times(number, kernel);
            let ratio = own.iter().zip(&base).map(|(x, y)| x / y).collect();
            // Of several lanes the errors are those of one.
            let same = |other: &Way| {
                (other.precision, other.mode, other.fma, other.lanes) == (way.precision, way.mode, way.fma, 1)
            };
            let alone = WAYS.iter().position(same).expect("each way of lanes has one of one lane");
            let path = folder.join(format!("w{alone}/out{kernel}"));
            let computed = reals(&std::fs::read(path).expect("what the driver wrote"), way.precision);
            points.push(Point {
                kernel: stages.kernel.name.clone(),
                way,
                time: Spread::of(own),
                ratio: Spread::of(ratio),
                errors: errors(stages, &drawn[kernel][way.precision as usize], &computed),
            });
        }
    }
    points
}

/// States of a kernel, entry by entry, and what it computes in 320 bits at those of the families.
struct Drawn {
    timed: Vec<Vec<f64>>,
    judged: Vec<Vec<f64>>,
    exact: Vec<f64>,
}

fn draw(stages: &Stages, precision: Precision) -> Drawn {
    let subject = Subject { source: &stages.source, program: &stages.program };
    let probe = Probe::new(&subject);
    let largest = if precision == Precision::F32 { f64::from(f32::MAX) } else { f64::MAX };
    // Some kernels have few regular states in a family: the same ones serve again then.
    let regular = |family: Family, count: usize| -> Vec<(Vec<f64>, Vec<f64>)> {
        let drawn = (0..20 * count).map(|index| {
            let mut inputs = probe.draw(family, 2, index);
            if precision == Precision::F32 {
                inputs.iter_mut().for_each(|x| *x = f64::from(*x as f32));
            }
            let outputs = probe.program(&inputs);
            (inputs, outputs)
        });
        let found: Vec<_> =
            drawn.filter(|(_, outputs)| outputs.iter().all(|x| x.abs() <= largest)).take(count).collect();
        assert!(!found.is_empty(), "{} has no regular state", stages.kernel.name);
        (0..count).map(|index| found[index % found.len()].clone()).collect()
    };
    let (judged, exact) =
        FAMILIES.iter().flat_map(|&family| regular(family, DRAWN)).unzip::<_, _, _, Vec<_>>();
    let timed = regular(Family::Random, STATES / 8).into_iter().map(|(inputs, _)| inputs).collect();
    Drawn { timed, judged, exact: exact.concat() }
}

/// Writes, compiles and links to one object what a way computes with.
fn build(way: &Way, number: usize, files: &[Subjects], drawn: &[[Drawn; 2]], folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder to build in");
    let write = |name: &str, text: &[u8]| std::fs::write(folder.join(name), text).expect("a file to build");
    let (mut renamed, mut unit, mut table) = (String::new(), HEAD.to_owned() + KERNEL, String::new());
    let (mut sources, mut states, mut kernel) = (vec!["unit.c".to_owned()], Vec::new(), 0);
    let mut taken = String::new();
    for Subjects { stem, all } in files {
        let kernels = all.iter().map(|stages| stages.kernel.clone()).collect();
        let file = File { stem: stem.clone(), docs: Vec::new(), kernels, precisions: vec![way.precision] };
        for generated in forcec::internals::emit::emit(&file, Target::C) {
            write(&generated.name, generated.text.as_bytes());
        }
        sources.push(format!("{}.c", file.name()));
        let _ = writeln!(unit, "#include \"{}.h\"", file.name());
        for stages in all {
            let called = |part: &str| {
                kernel_name(&stages.kernel.name, Target::C, &format!("{part}_{}", way.precision))
            };
            let symbol = called("");
            let _ = writeln!(renamed, "#define {symbol} w{number}_{symbol}");
            let types =
                arguments(&stages.kernel.name, &stages.kernel.schedule.signature, way.precision, way.lanes);
            let members: String = types.iter().enumerate().map(|(i, ty)| format!("{ty} m{i}; ")).collect();
            let passed =
                |of: &str| (0..types.len()).map(|i| format!("&{of}{kernel}[i].m{i}, ")).collect::<String>();
            let judged = if way.lanes == 1 { DRAWN * FAMILIES.len() } else { 1 };
            let _ = write!(
                unit,
                "static struct s{kernel} {{ {members}}} timed{kernel}[{}], judged{kernel}[{judged}];\n\
                 static _Alignas(64) {} out{kernel};\n\
                 static void run{kernel}(void)\n{{\n    for (int i = 0; i < {}; i++) {symbol}({}&out{kernel});\n}}\n\
                 static void write{kernel}(FILE *file)\n{{\n    for (int i = 0; i < {judged}; i++) {{\n        \
                 {symbol}({}&out{kernel});\n        fwrite(&out{kernel}, sizeof out{kernel}, 1, file);\n    }}\n}}\n",
                STATES / way.lanes,
                called("_out"),
                STATES / way.lanes,
                passed("timed"),
                passed("judged"),
            );
            let _ = writeln!(
                table,
                "    {{ run{kernel}, {} }},",
                if way.lanes == 1 { format!("write{kernel}") } else { "0".to_owned() }
            );
            let _ =
                writeln!(taken, "    if (!fread(timed{kernel}, sizeof timed{kernel}, 1, file)) return 0;");
            let own = &drawn[kernel][way.precision as usize];
            let all: Vec<&Vec<f64>> = (0..STATES).map(|index| &own.timed[index % own.timed.len()]).collect();
            states.extend(interleaved(&all, way.lanes));
            if way.lanes == 1 {
                let _ = writeln!(
                    taken,
                    "    if (!fread(judged{kernel}, sizeof judged{kernel}, 1, file)) return 0;"
                );
                states.extend(own.judged.iter().flatten());
            }
            kernel += 1;
        }
    }
    let _ = write!(
        unit,
        "const struct kernel w{number}_all[] = {{\n{table}}};\nint w{number}_take(FILE *file);\n\
         int w{number}_take(FILE *file)\n{{\n{taken}    return 1;\n}}\n"
    );
    write("renamed.h", renamed.as_bytes());
    write("unit.c", unit.as_bytes());
    write("states", &bytes(states.into_iter(), way.precision));
    let contracted = if way.mode == Mode::Fast { "fast" } else { "off" };
    for source in &sources {
        let mut gcc = Command::new("gcc");
        gcc.args(["-O3", "-march=native", "-fno-math-errno", &format!("-ffp-contract={contracted}")]);
        run(gcc.args(["-include", "renamed.h", "-c", source, "-o", &format!("{source}.o")]), folder);
    }
    let objects: Vec<String> = sources.iter().map(|source| format!("{source}.o")).collect();
    run(Command::new("ld").arg("-r").args(&objects).args(["-o", "way.o"]), folder);
}

fn reals(bytes: &[u8], precision: Precision) -> Vec<f64> {
    match precision {
        Precision::F64 => bytes.as_chunks().0.iter().map(|x| f64::from_ne_bytes(*x)).collect(),
        Precision::F32 => bytes.as_chunks().0.iter().map(|x| f64::from(f32::from_ne_bytes(*x))).collect(),
    }
}

/// The errors of a kernel at the states of each family.
fn errors(stages: &Stages, drawn: &Drawn, computed: &[f64]) -> [Error; FAMILIES.len()] {
    let n = stages.kernel.schedule.signature.dofs();
    let whole = n + 2 * n * n;
    assert_eq!(computed.len(), drawn.exact.len(), "{}", stages.kernel.name);
    let mut found = [Error::default(); FAMILIES.len()];
    for (state, (exact, computed)) in drawn.exact.chunks(whole).zip(computed.chunks(whole)).enumerate() {
        let error = &mut found[state / DRAWN];
        for range in [0..n, n..n + n * n, n + n * n..whole] {
            let (exact, computed) = (&exact[range.clone()], &computed[range]);
            let largest = exact.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for (x, y) in exact.iter().zip(computed) {
                let off = if y.is_finite() { (x - y).abs() } else { f64::INFINITY };
                if off > 0.0 {
                    error.normwise = error.normwise.max(off / largest);
                    error.componentwise =
                        error.componentwise.max(if *x == 0.0 { 0.0 } else { off / x.abs() });
                }
            }
        }
    }
    found
}

/// For each way the times and errors of all kernels: geometric means, medians and the worst.
pub fn table(points: &[Point]) -> String {
    let mut text = String::from("| mode | time | quartiles |");
    for family in FAMILIES {
        let _ = write!(text, " {} | worst |", family.name());
    }
    text += " entry by entry |\n|---|--:|--:|";
    text += &"--:|--:|".repeat(FAMILIES.len());
    text += "--:|\n";
    for way in &WAYS {
        let own: Vec<&Point> = points.iter().filter(|point| std::ptr::eq(point.way, way)).collect();
        let logs: Vec<f64> = own.iter().map(|point| point.ratio.median.ln()).collect();
        let mean = (logs.iter().sum::<f64>() / logs.len() as f64).exp();
        let ratios = Spread::of(own.iter().map(|point| point.ratio.median).collect());
        let _ = write!(text, "| {} | {mean:.2} | {:.2} … {:.2} |", way.name, ratios.low, ratios.high);
        for family in 0..FAMILIES.len() {
            let all: Vec<f64> = own.iter().map(|point| point.errors[family].normwise).collect();
            let worst = all.iter().fold(0.0_f64, |most, x| most.max(*x));
            let _ = write!(text, " {:.0e} | {worst:.0e} |", Spread::of(all).median);
        }
        let all = own.iter().map(|point| point.errors[0].componentwise).collect();
        let _ = writeln!(text, " {:.0e} |", Spread::of(all).median);
    }
    text
}

/// Every point, a row each.
pub fn csv(points: &[Point]) -> String {
    let mut text = String::from("kernel,mode,ns,ns_low,ns_high,ratio");
    for family in FAMILIES {
        let name = family.name().replace(' ', "_");
        let _ = write!(text, ",{name}_normwise,{name}_componentwise");
    }
    text.push('\n');
    for point in points {
        let time = point.time;
        let name = point.way.name.replace(',', "");
        let _ = write!(
            text,
            "{},{name},{:.2},{:.2},{:.2},{:.3}",
            point.kernel, time.median, time.low, time.high, point.ratio.median
        );
        for error in point.errors {
            let _ = write!(text, ",{:.2e},{:.2e}", error.normwise, error.componentwise);
        }
        text.push('\n');
    }
    text
}

const HEAD: &str = "\
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
";

const KERNEL: &str = "
struct kernel {
    void (*run)(void);
    void (*write)(FILE *);
};
";

const MAIN: &str = "
int main(int count, char **arguments)
{
    const int rounds = count == 2 ? atoi(arguments[1]) : 0;
    char name[64];
    for (int w = 0; w < WAYS; w++) {
        snprintf(name, sizeof name, \"w%d/states\", w);
        FILE *file = fopen(name, \"rb\");
        if (!file || !take[w](file)) return 1;
        fclose(file);
        for (int k = 0; k < KERNELS; k++) {
            if (!all[w][k].write) continue;
            snprintf(name, sizeof name, \"w%d/out%d\", w, k);
            FILE *out = fopen(name, \"wb\");
            if (!out) return 1;
            all[w][k].write(out);
            fclose(out);
        }
    }
    for (int round = 0; round < rounds; round++)
        for (int k = 0; k < KERNELS; k++)
            for (int w = 0; w < WAYS; w++) {
                const int turn = (round + w) % WAYS;
                all[turn][k].run(); /* brings the states into the cache */
                const double start = now();
                all[turn][k].run();
                printf(\"%d %d %.3f\\n\", turn, k, now() - start);
            }
    return 0;
}
";
