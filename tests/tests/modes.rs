//! Kernels of every mode: they compile without a warning under every kind of contraction, and results equal
//! the program in 320 bits; the text of a small kernel in each mode.

use forcec::internals::emit;
use forcec::internals::kernel::{Precision, Target};
use forcec::{Mode, Plan};
use forcec_tests::cases::{Reference, STATES, compare, judge};
use forcec_tests::{ForceFile, compiled_with, driver, folder, library_with, parallel, run};

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

/// Every mode with its name, without and with fused multiplications.
fn plans() -> Vec<(String, Plan)> {
    let modes = Mode::ALL.iter().flat_map(|(name, mode, _)| [(name, *mode, false), (name, *mode, true)]);
    let named = modes.map(|(name, mode, fma)| {
        let fused = if fma { "_fma" } else { "" };
        (format!("{name}{fused}"), Plan { mode, fma, ..Plan::default() })
    });
    named.collect()
}

/// The kernels of a file of the library that are compiled in every mode.
fn some(plan: Plan, stem: &str, names: &[&str]) -> ForceFile {
    let mut file = library_with(plan, stem);
    file.compiled.functions.retain(|function| names.contains(&function.definition.name.as_str()));
    assert_eq!(file.compiled.functions.len(), names.len(), "{stem} has what is asked for");
    file
}

#[test]
fn kernels_of_every_mode_equal_their_mathematics() {
    const FILES: [(&str, &[&str]); 4] = [
        ("joints", &["point_to_point", "distance", "hinge"]),
        ("springs", &["spring", "rope"]),
        ("solids", &["neo_hookean"]),
        ("contacts", &["sphere_sphere"]),
    ];
    const STRICT: [&str; 5] = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
    // gcc contracts in its own dialect.
    const FLAGS: [(&str, &[&str]); 2] = [
        ("c99", &["-std=c99", "-ffp-contract=off", "-O2"]),
        ("gnu", &["-std=gnu11", "-ffp-contract=fast", "-O3", "-march=native"]),
    ];
    let jobs: Vec<_> = plans().into_iter().flat_map(|plan| FILES.map(|file| (plan.clone(), file))).collect();
    let found = parallel(jobs, |((mode, plan), (stem, names))| {
        let file = some(plan, stem, names);
        let folder = folder(env!("CARGO_TARGET_TMPDIR"), &format!("modes_{mode}_{stem}"));
        let printable = file.printable(&PRECISIONS);
        for generated in emit::emit(&printable, Target::C) {
            std::fs::write(folder.join(generated.name), generated.text).unwrap();
        }
        std::fs::write(folder.join("driver.c"), driver::c(&printable, STATES)).unwrap();
        let source = format!("{stem}.c");
        run(&folder, "cc", &[&STRICT[..], &["-O2", "-c", &source, "-o", "strict.o"]].concat());
        let mut found = Vec::new();
        for (dialect, flags) in FLAGS {
            let program = format!("driver_{dialect}");
            run(&folder, "cc", &[flags, &["driver.c", &source, "-lm", "-o", &program]].concat());
            let misses = compare(&file, &folder.join(program), &PRECISIONS, Reference::Program);
            found.extend(misses.into_iter().map(|(precision, mut miss)| {
                miss.kernel = format!("{} {mode} {dialect}", miss.kernel);
                (precision, miss)
            }));
        }
        found
    });
    judge(&found.into_iter().flatten().collect::<Vec<_>>());
}

/// The same in Rust, one program for each mode.
#[test]
fn rust_kernels_of_every_mode_equal_their_mathematics() {
    let found = parallel(plans(), |(mode, plan)| {
        let file = some(plan, "joints", &["point_to_point", "distance"]);
        let folder = folder(env!("CARGO_TARGET_TMPDIR"), &format!("modes_rust_{mode}"));
        let printable = file.printable(&PRECISIONS);
        for generated in emit::emit(&printable, Target::Rust) {
            std::fs::write(folder.join(generated.name), generated.text).unwrap();
        }
        forcec_tests::lint(&folder, "joints");
        std::fs::write(folder.join("driver.rs"), driver::rust(&printable, STATES)).unwrap();
        let flags = ["--edition", "2024", "-O", "-C", "target-cpu=native"];
        run(&folder, "rustc", &[&flags[..], &["driver.rs", "-o", "driver"]].concat());
        compare(&file, &folder.join("driver"), &PRECISIONS, Reference::Program)
    });
    judge(&found.into_iter().flatten().collect::<Vec<_>>());
}

/// A small force in every mode; the default is `balanced`.
#[test]
fn a_small_force_in_every_mode() {
    const TEXT: &str = "\
#[constraint]
fn stay(a: Particle, b: Particle, length: Real) -> Real {
    let gap = b.position - a.position;
    (gap.dot(&gap) - length * length) / (length + gap.norm())
}
";
    let text =
        |text: &str, plan: Plan| compiled_with("stay", text, plan).functions[0].kernel.schedule.to_string();
    for (name, plan) in plans() {
        insta::with_settings!({ snapshot_path => "../golden/modes", prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!(name.as_str(), text(TEXT, plan));
        });
        let stated =
            format!("mode = {}{}", name.trim_end_matches("_fma"), if plan.fma { ", fma" } else { "" });
        let stated = TEXT.replace("#[constraint]", &format!("#[constraint({stated})]"));
        assert_eq!(text(&stated, Plan::default()), text(TEXT, plan), "an attribute says what a flag says");
    }
    assert_eq!(Plan::default().mode, Mode::Balanced);
}
