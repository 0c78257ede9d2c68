//! Names reserved in the languages, in headers or in the kernels themselves, in every position: printed code
//! compiles without a warning in every supported dialect.

use forcec::internals::compile;
use forcec::internals::compile::Request;
use forcec::internals::emit;
use forcec::internals::kernel::{File, Precision, Target};
use forcec::internals::layout::{LAYOUTS, Layout};
use forcec::internals::source::span::Source;
use forcec_tests::{ForceFile, compiled, folder, lint, run};
use std::fmt::Write;
use std::path::Path;

/// Words, each of which becomes a kernel, a body, a parameter and a `let`.
const WORDS: &str = "double int_ float char auto register restrict signed typedef volatile inline goto asm \
    constexpr nullptr alignas thread_local static_assert typeof_unqual bool_ _Bool _Complex \
    and or not xor bitand new this template class concept co_await char8_t operator delete namespace private try_ \
    linux unix i386 errno I M_PI M_PIf INFINITY NAN HUGE_VAL FP_NAN RAND_MAX MATH_ERRNO NULL EOF stdin complex \
    FORCEC_H FORCEC_NAMES_H FORCEC_PI \
    sin sqrt fabs fmax hypot exp pow cosf sqrtl y0 gamma abs index signgam min max near isnan assert \
    gen union raw Match Type Self_ super_ crate_ r_type std core alloc f64 f32 evaluate main \
    foo baz row j s m out params position force dfdx dfdv x y fill from_bits cos_sqrt_1 angle_ratio_0 \
    lane step direction prepared shared RigidF32 ParticleF32 Output PartialEq __x _Y _x2 a__b _1 X1Y restLength Kn E Jac Greek_phi \
    x_f64 yy_f32 z_params_f64 w_out_f32 a_name_that_is_really_rather_long_as_names_in_kernels_go";

/// Names that are close to each other, together in one kernel.
const GROUPS: [&str; 8] = [
    "double double_ double_2",
    "K k _K k_ _k k_2 __k",
    "I I_ i i_ _I __ ___ _X FORCEC_PI_F32 usize J j",
    "params params_ out out_ Params",
    "int int_ INT Int",
    "f f_64 f_f64 f_params_f64 f_out_f64 F",
    "restLength rest_length RestLength rest_length_",
    "stiffness_ Stiffness Damping damping_",
];

/// A force that reads its arguments in every possible way, and leaves one body unread.
fn kernel(text: &mut String, [name, a, b, unread, p, q, held]: [&str; 7]) {
    let _ = writeln!(
        text,
        "#[force]
pub fn {name}({a}: Particle, {b}: Particle, {unread}: Particle, {p}: Real, {q}: Quat) -> (Vec3, Vec3, Vec3) {{
    let {held} = ({p} * {a}.position.x).sin().abs().sqrt() + {b}.position.y.exp().max({p});
    let v = {q}.scaled_axis() * {held} + Quat::from_scaled_axis({p} * Vec3::x()).imag();
    (v, {b}.position - {a}.position, {a}.velocity)
}}
"
    );
}

/// A kernel whose arguments are all of a group.
fn group(text: &mut String, index: usize, names: &[&str]) {
    // Clippy wants at most seven arguments.
    let some = &names[..names.len().min(6)];
    let bodies: Vec<String> = some.iter().map(|name| format!("{name}: Particle")).collect();
    let read: Vec<String> = some.iter().skip(1).map(|name| format!("{name}.position.x")).collect();
    let fields: Vec<String> = names.iter().map(|name| format!("{name}: Real")).collect();
    let sum = names.join(" + ");
    let _ = writeln!(
        text,
        "#[energy]\npub fn bodies_{index}({}) -> Real {{\n    ({}).sin()\n}}\n\n\
         #[constraint]\npub fn fields_{index}(p: Particle, {}) -> Real {{\n    let p_x = {sum};\n    p.position.x * p_x\n}}\n",
        bodies.join(", "),
        read.join(" * "),
        fields.join(", "),
    );
}

fn file() -> File {
    let words: Vec<&str> = WORDS.split_ascii_whitespace().collect();
    let mut text = String::new();
    for index in 0..words.len() {
        kernel(&mut text, std::array::from_fn(|place| words[(index + place) % words.len()]));
    }
    let groups = GROUPS.map(|names| names.split_ascii_whitespace().collect::<Vec<_>>());
    for (index, names) in groups.iter().enumerate() {
        group(&mut text, index, names);
    }
    let stem = "names".to_owned();
    ForceFile { compiled: compiled(&stem, &text), stem }.printable(&[Precision::F64, Precision::F32])
}

fn emit(folder: &Path, target: Target) {
    for generated in emit::emit(&file(), target) {
        std::fs::write(folder.join(generated.name), generated.text).unwrap();
    }
}

#[test]
fn c_and_cpp_take_every_name() {
    let folder = folder(env!("CARGO_TARGET_TMPDIR"), "names_c");
    emit(&folder, Target::C);
    // Headers that a program may have included before.
    let headers = ["complex.h", "errno.h", "stdio.h", "stdlib.h"].map(|header| ["-include", header]).concat();
    let strict = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"];
    for (compiler, standard, headers) in [
        ("gcc", ["-std=c99", "-xc"], &[][..]),
        ("gcc", ["-std=gnu11", "-xc"], &headers),
        ("g++", ["-std=c++17", "-xc++"], &[]),
        ("g++", ["-std=gnu++20", "-xc++"], &headers[2..]),
    ] {
        run(&folder, compiler, &[&standard[..], &strict, headers, &["names.c"]].concat());
    }
}

/// Bodies whose combined names equal those of other bodies, and bodies with the names of layout arguments.
#[test]
fn layouts_take_every_name() {
    let folder = folder(env!("CARGO_TARGET_TMPDIR"), "names_layouts");
    let text = "#[energy]\npub fn pairs(a: Particle, a_a: Particle, k: Real) -> Real {\n    \
        k.sin() * (a.position.norm_squared() * a.position.x + a.position.dot(&a_a.position))\n}\n\n\
        #[force]\npub fn named(step: Particle, direction: Particle, lane: Particle, prepared: Particle, k: Real) \
        -> (Vec3, Vec3, Vec3, Vec3) {\n    let l = k.sin() * (step.position - direction.velocity);\n    \
        (l, l.cross(&lane.position), direction.position, prepared.velocity * prepared.position.x)\n}\n";
    let source = Source::new("pairs.rs", text);
    let wanted = LAYOUTS.iter().flat_map(|row| [(row.layout, 1, false), (row.layout, 4, true)]);
    for (layout, lanes, prepare) in wanted.filter(|way| *way != (Layout::Accumulate, 4, true)) {
        let request = Request { layout, lanes, prepare, ..Request::default() };
        let compiled = compile::compile(&source, &|_| true, request).expect("it compiles");
        let stem = format!("pairs_{layout:?}_{lanes}").to_lowercase();
        let file = ForceFile { compiled, stem }.printable(&[Precision::F64]);
        for generated in Target::ALL.into_iter().flat_map(|target| emit::emit(&file, target)) {
            std::fs::write(folder.join(generated.name), generated.text).unwrap();
        }
        let name = file.name();
        let strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"];
        run(&folder, "cc", &[&strict[..], &[&format!("{name}.c")]].concat());
        lint(&folder, &name);
    }
}

#[test]
fn rust_takes_every_name() {
    let folder = folder(env!("CARGO_TARGET_TMPDIR"), "names_rust");
    emit(&folder, Target::Rust);
    lint(&folder, "names");
}
