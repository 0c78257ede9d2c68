//! Run times per instance of the layouts of a kernel and of the dense hand-written kernel, in one process, in
//! turn.
//!
//! Input: a kernel that also exists hand-written. Output: a [`Row`] for each layout and each target. Every
//! variant has its own folder: the files that forcec prints, and a unit that reads states in the variant's
//! memory order and calls the kernel at each state.

use crate::kernels::{
    CLOCK, FLAGS, RUST_FLAGS, STATES, Spread, arguments, bytes, interleaved, printable, reported, run,
};
use crate::{compile_all, library};
use forcec::internals::compile::{Request, Stages, compile};
use forcec::internals::kernel::{File, Precision};
use forcec::internals::model::bodies::Signature;
use forcec::internals::names::{Target, kernel_name};
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{Family, Subject};
use forcec::{Layout, Part};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// A layout of a kernel.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Name in tables.
    pub name: &'static str,
    layout: Layout,
    lanes: usize,
    precision: Precision,
    outputs: &'static [Part],
}

/// A layout with F and both derivatives.
const fn way(name: &'static str, layout: Layout, lanes: usize, precision: Precision) -> Variant {
    Variant { name, layout, lanes, precision, outputs: &Part::DEFAULT }
}

/// All measured layouts.
pub static VARIANTS: [Variant; 12] = [
    way("dense", Layout::Dense, 1, Precision::F64),
    Variant { outputs: &[Part::Force], ..way("force only", Layout::Dense, 1, Precision::F64) },
    way("packed", Layout::Packed, 1, Precision::F64),
    way("system", Layout::System, 1, Precision::F64),
    way("product", Layout::Product, 1, Precision::F64),
    way("dense, 4 lanes", Layout::Dense, 4, Precision::F64),
    way("packed, 4 lanes", Layout::Packed, 4, Precision::F64),
    way("packed, 8 lanes", Layout::Packed, 8, Precision::F64),
    way("packed, 8 lanes, f32", Layout::Packed, 8, Precision::F32),
    way("system, 4 lanes", Layout::System, 4, Precision::F64),
    way("system, 8 lanes, f32", Layout::System, 8, Precision::F32),
    Variant { outputs: &[Part::Force], ..way("force only, 4 lanes", Layout::Dense, 4, Precision::F64) },
];

/// The time of one variant.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the variant.
    pub variant: &'static str,
    /// The implementation.
    pub maker: &'static str,
    /// Nanoseconds per instance.
    pub time: Spread,
    /// Time divided by the time of the dense hand-written kernel in the same round.
    pub ratio: Spread,
}

/// Times as a table.
pub fn table(rows: &[Row]) -> String {
    let mut text = String::from("| variant | code | ns | by hand = 1 | quartiles |\n|---|---|--:|--:|--:|\n");
    for row in rows {
        let (time, ratio) = (row.time.median, row.ratio);
        let _ = writeln!(
            text,
            "| {} | {} | {time:.1} | {:.3} | {:.3} … {:.3} |",
            row.variant, row.maker, ratio.median, ratio.low, ratio.high
        );
    }
    text
}

/// Measures a hand-written kernel and every variant of the kernel. The build products stay in `folder`.
pub fn measure(kernel: &str, rounds: usize, folder: &Path) -> Vec<Row> {
    std::fs::create_dir_all(folder).expect("a folder to build in");
    let root = &std::path::absolute(folder).expect("a folder to build in");
    let mut objects = Vec::new();
    let (mut declared, mut table, mut wrappers) = (String::new(), String::new(), String::new());
    let mut rows = Vec::new();
    for (index, variant) in VARIANTS.iter().enumerate() {
        let place = format!("v{index}");
        let own = folder.join(&place);
        std::fs::create_dir_all(&own).expect("a folder to build in");
        let (file, stages) = compiled(kernel, variant);
        for generated in
            [Target::C, Target::Rust].into_iter().flat_map(|t| forcec::internals::emit::emit(&file, t))
        {
            std::fs::write(own.join(generated.name), generated.text).expect("a file to build");
        }
        std::fs::write(own.join("states"), states(&stages, variant)).expect("a file of states");
        let symbol = kernel_name(&stages.kernel.name, Target::C, &format!("_{}", variant.precision));
        let mut makers = vec![("C", format!("v{index}_c")), ("Rust", format!("v{index}_rust"))];
        if index == 0 {
            makers.insert(0, ("hand", format!("hand_{kernel}")));
        }
        let mut gcc = |folder: &str, source: &str, object: &str, defines: &[String]| {
            let mut gcc = Command::new("gcc");
            gcc.args(FLAGS.split(' ')).arg("-I.").args(defines).args(["-c", source, "-o", object]);
            run(&mut gcc, &root.join(folder));
            objects.push(format!("{folder}/{object}"));
        };
        gcc(&place, &format!("{}.c", file.name()), "kernel.o", &[format!("-D{symbol}=v{index}_c")]);
        if index == 0 {
            let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("hand").join(format!("{kernel}.c"));
            headers(&root.join("hand"));
            gcc("hand", &own.to_string_lossy(), "hand.o", &[]);
        }
        for (place_of_maker, (maker, function)) in makers.iter().enumerate() {
            let id = format!("{index}_{place_of_maker}");
            let text = unit(&file, &stages, variant, function, &id);
            let name = format!("unit_{place_of_maker}");
            std::fs::write(own.join(format!("{name}.c")), text).expect("a file to build");
            gcc(&place, &format!("{name}.c"), &format!("{name}.o"), &[]);
            let _ = writeln!(declared, "int take_{id}(FILE *);\nvoid run_{id}(void);");
            let _ = writeln!(table, "    {{ \"{place}/states\", take_{id}, run_{id} }},");
            rows.push((variant.name, *maker));
        }
        wrappers.push_str(&wrapper(&file, &stages, variant, index));
    }
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("a file to build");
    write("driver.c", &format!("{HEAD}{CLOCK}\n{declared}{TABLE}{table}{TAIL}"));
    write("kernels.rs", &wrappers);
    let mut rustc = Command::new("rustc");
    rustc.args(["--edition", "2024", "--crate-type", "staticlib"]).args(RUST_FLAGS.split(' '));
    run(rustc.args(["kernels.rs", "-o", "libkernels.a"]), folder);
    let mut gcc = Command::new("gcc");
    let libraries = ["libkernels.a", "-lm", "-lpthread", "-ldl", "-o", "driver"];
    run(gcc.arg("-O2").arg("driver.c").args(&objects).args(libraries), folder);
    let answer = run(Command::new("./driver").arg(rounds.to_string()), folder);
    let times = |place: usize| -> Vec<f64> {
        reported(&answer, &format!("{place} ")).into_iter().map(|time| time / STATES as f64).collect()
    };
    let hand = times(0);
    let row = |(place, (variant, maker)): (usize, (&'static str, &'static str))| {
        let own = times(place);
        let quotients = own.iter().zip(&hand).map(|(x, y)| x / y).collect();
        Row { variant, maker, time: Spread::of(own), ratio: Spread::of(quotients) }
    };
    rows.into_iter().enumerate().map(row).collect()
}

/// The headers of the library, which hand-written code includes.
fn headers(folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder to build in");
    for source in library() {
        let file = printable(compile_all(&source)).0;
        for generated in
            forcec::internals::emit::emit(&file, Target::C).into_iter().filter(|g| g.name.ends_with(".h"))
        {
            std::fs::write(folder.join(generated.name), generated.text).expect("a file to build");
        }
    }
}

/// The kernel of this name in the form of a variant.
fn compiled(kernel: &str, variant: &Variant) -> (File, Stages) {
    let request = Request {
        layout: variant.layout,
        lanes: variant.lanes,
        outputs: variant.outputs.to_vec(),
        ..Request::default()
    };
    for source in library() {
        let mut compiled = match compile(&source, &|name| name == kernel, request.clone()) {
            Ok(compiled) => compiled,
            Err(diagnostics) => panic!("{diagnostics}"),
        };
        if let Some(stages) = compiled.functions.pop() {
            let stem = source.name.trim_end_matches(".rs").to_owned();
            let (kernels, precisions) = (vec![stages.kernel.clone()], vec![variant.precision]);
            return (File { stem, docs: Vec::new(), kernels, precisions }, stages);
        }
    }
    panic!("no kernel `{kernel}` in the library")
}

/// Number of reals in the arguments before the extra arguments.
fn inputs(signature: &Signature) -> usize {
    let stored = signature.bodies.iter().flat_map(|body| body.kind.row().fields);
    let given = signature.parameters.iter().map(|parameter| parameter.ty.length() as usize);
    stored.map(|field| field.length as usize).sum::<usize>() + given.sum::<usize>()
}

/// The states for a variant: one group per lane count, entry by entry within each group.
fn states(stages: &Stages, variant: &Variant) -> Vec<u8> {
    let subject = Subject { source: &stages.source, program: &stages.program };
    let probe = Probe::new(&subject);
    let length = inputs(&stages.kernel.schedule.signature);
    let drawn = (0..STATES).map(|state| probe.draw(Family::Random, 1, state)[..length].to_vec());
    let all: Vec<Vec<f64>> = drawn.collect();
    bytes(interleaved(&all.iter().collect::<Vec<_>>(), variant.lanes), variant.precision)
}

/// The C unit that calls a function at all states.
fn unit(file: &File, stages: &Stages, variant: &Variant, function: &str, id: &str) -> String {
    let (signature, precision) = (&stages.kernel.schedule.signature, variant.precision);
    let named = |part: &str| kernel_name(&stages.kernel.name, Target::C, &format!("{part}_{precision}"));
    let types = arguments(&stages.kernel.name, signature, precision, variant.lanes);
    let members: String = types.iter().enumerate().map(|(i, ty)| format!("{ty} m{i}; ")).collect();
    let declared: String = types.iter().map(|ty| format!("const {ty} *, ")).collect();
    let passed: String = (0..types.len()).map(|i| format!("&states[i].m{i}, ")).collect();
    let real = if precision == Precision::F64 { "double" } else { "float" };
    let (extra, value) = match variant.layout {
        Layout::System => (format!("{real}, "), "0.01, "),
        Layout::Product => (format!("const {real} *, "), "direction, "),
        _ => (String::new(), ""),
    };
    let (out, count) = (named("_out"), STATES / variant.lanes);
    format!(
        "#include <stdio.h>\n#include \"{}.h\"\n\nstatic struct {{ {members}}} states[{count}];\n\
         static _Alignas(64) {out} out;\nconst {real} direction_{id}[24] = {{ 1, 2, 3, 4 }};\n\
         void {function}({declared}{extra}{out} *);\nint take_{id}(FILE *file)\n{{\n    \
         return fread(states, sizeof *states, {count}, file) == {count};\n}}\nvoid run_{id}(void)\n{{\n    \
         for (int i = 0; i < {count}; i++) {function}({passed}{}&out);\n}}\n",
        file.name(),
        value.replace("direction", &format!("direction_{id}"))
    )
}

/// The module of a variant's Rust, and a function that C can call.
fn wrapper(file: &File, stages: &Stages, variant: &Variant, index: usize) -> String {
    let (signature, name) = (&stages.kernel.schedule.signature, file.name());
    let (precise, suffix) = match variant.precision {
        Precision::F64 => ("", ""),
        Precision::F32 => ("F32", "_f32"),
    };
    let several = if variant.lanes > 1 { format!("X{}", variant.lanes) } else { String::new() };
    let module = kernel_name(&stages.kernel.name, Target::Rust, suffix);
    let body = |body: &forcec::internals::model::bodies::Body| {
        format!("v{index}::{}{precise}{several}", body.kind.row().name)
    };
    let bodies = signature.bodies.iter().map(body);
    let types: Vec<String> = bodies.chain([format!("v{index}::{module}::Params")]).collect();
    let mut declared: String = types.iter().enumerate().map(|(i, ty)| format!("m{i}: &{ty}, ")).collect();
    let mut passed: String = (0..types.len()).map(|i| format!("m{i}, ")).collect();
    for (_, extra) in signature.given_extras() {
        let length = extra.ty.length();
        let real = variant.precision;
        declared += &if variant.layout == Layout::System {
            format!("extra: {real}, ")
        } else {
            format!("extra: &[{real}; {length}], ")
        };
        passed.push_str("extra, ");
    }
    format!(
        "#[path = \"v{index}/{name}.rs\"]\nmod v{index};\n#[unsafe(no_mangle)]\n\
         pub extern \"C\" fn v{index}_rust({declared}out: &mut v{index}::{module}::Output) {{\n    \
         v{index}::{module}::evaluate({passed}out)\n}}\n\n"
    )
}

const HEAD: &str = "\
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
";

const TABLE: &str = "
static const struct {
    const char *states;
    int (*take)(FILE *);
    void (*run)(void);
} all[] = {
";

const TAIL: &str = "};

int main(int count, char **arguments)
{
    const int makers = (int)(sizeof all / sizeof *all), rounds = count == 2 ? atoi(arguments[1]) : 0;
    for (int k = 0; k < makers; k++) {
        FILE *file = fopen(all[k].states, \"rb\");
        if (!file || !all[k].take(file)) return 1;
        fclose(file);
    }
    for (int round = 0; round < rounds; round++)
        for (int k = 0; k < makers; k++) {
            const int turn = (round + k) % makers;
            all[turn].run(); /* brings the states into the cache */
            const double start = now();
            all[turn].run();
            printf(\"%d %.3f\\n\", turn, now() - start);
        }
    return 0;
}
";
