//! Long kernels: they are printed as functions of at most about a thousand statements, compile without a warning in both
//! languages, and results equal the source in 320 bits.

use forcec::internals::emit;
use forcec::internals::kernel::{Precision, Target};
use forcec::internals::schedule::Statement;
use forcec::internals::schedule::sections::LONGEST;
use forcec_tests::cases::{Miss, Reference, STATES, compare, judge};
use forcec_tests::{ForceFile, compiled, driver, folder, lint, run};

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

/// Fibres between two bodies, and values handed on from step to step with a choice in each.
fn long() -> ForceFile {
    let text = r"
        /// Many fibres between two bodies.
        #[energy]
        #[domain(rest = 0.1..2.0)]
        pub fn fibres(
            a: Rigid, b: Rigid, origin: [Vec3; 16], insertion: [Vec3; 16], rest: [Real; 16], k: Real,
        ) -> Real {
            let mut energy = 0.0;
            for i in 0..16 {
                let pa = a.position + a.orientation * origin[i];
                let pb = b.position + b.orientation * insertion[i];
                let strain = ((pb - pa).norm_squared() + 0.01).sqrt() - rest[i];
                energy += 0.5 * k * strain * strain + (0.1 * strain).exp();
            }
            energy
        }

        fn step(x: Real, y: Real, z: Real, c: Real) -> (Real, Real, Real) {
            let s = c * x + y;
            let t = (0.1 * (s * z)).sin();
            let turned = if t < 0.3 { t } else { 0.3 + 0.1 * s };
            (y - 0.02 * s, turned, x + 0.01 * t)
        }

        /// One step after another.
        #[energy]
        pub fn chain(a: Particle, b: Particle, c: [Real; 12]) -> Real {
            let d = b.position - a.position;
            let (mut x, mut y, mut z) = (d.x, d.y, d.z);
            for i in 0..12 {
                let (p, q, r) = step(x, y, z, c[i]);
                x = p;
                y = q;
                z = r;
            }
            x + y * z
        }
    ";
    ForceFile { stem: "long".to_owned(), compiled: compiled("long", text) }
}

#[test]
fn sections_are_short_and_hand_on_what_is_read() {
    for function in &long().compiled.functions {
        let schedule = &function.kernel.schedule;
        let sections = schedule.sections();
        let name = &function.definition.name;
        let (count, taken) = (schedule.statements.len(), sections.iter().map(|section| section.takes.len()));
        eprintln!(
            "{name}: {count} statements in {} sections, {} values taken",
            sections.len(),
            taken.sum::<usize>()
        );
        assert!(count > 2 * LONGEST, "{name}: {count} statements are not many");
        assert!(sections.len() <= 1 + count / (LONGEST / 2), "{name}: {} sections", sections.len());
        assert_eq!(
            sections.iter().flat_map(|section| section.statements.clone()).collect::<Vec<_>>(),
            (0..count).collect::<Vec<_>>()
        );
        let mut there = Vec::new();
        for section in &sections {
            assert!(section.statements.len() <= LONGEST, "{name}: {} statements", section.statements.len());
            assert!(
                section.takes.iter().all(|name| there.contains(name)),
                "{name}: what is taken was handed on"
            );
            let mut own: Vec<_> = section.takes.clone();
            for statement in section.written(schedule) {
                assert!(
                    statement.reads().iter().all(|name| own.contains(name)),
                    "{name}: what is read is there"
                );
                own.extend(statement.defines());
            }
            let read: Vec<_> = section.written(schedule).flat_map(Statement::reads).collect();
            let unread = own.iter().find(|name| !read.contains(name) && !section.hands_on.contains(name));
            assert!(
                unread.is_none(),
                "{name}: what a section takes or defines is read, there or in a later one"
            );
            there.extend(&section.hands_on);
        }
    }
}

#[test]
fn long_kernels_equal_their_mathematics() {
    let file = long();
    let printable = file.printable(&PRECISIONS);
    let folder = folder(env!("CARGO_TARGET_TMPDIR"), "long");
    for generated in [Target::C, Target::Rust].into_iter().flat_map(|target| emit::emit(&printable, target)) {
        std::fs::write(folder.join(generated.name), generated.text).unwrap();
    }
    lint(&folder, "long");
    std::fs::write(folder.join("driver.rs"), driver::rust(&printable, STATES)).unwrap();
    run(&folder, "rustc", &["--edition", "2024", "-C", "opt-level=1", "-A", "warnings", "driver.rs"]);
    let mut found: Vec<(Precision, Miss)> =
        compare(&file, &folder.join("driver"), &PRECISIONS, Reference::Source);
    std::fs::write(folder.join("driver.c"), driver::c(&printable, STATES)).unwrap();
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2"];
    run(&folder, "cc", &[&strict[..], &["-c", "long.c"]].concat());
    run(&folder, "cc", &["-std=c99", "-O1", "driver.c", "long.o", "-lm", "-o", "driver"]);
    found.extend(compare(&file, &folder.join("driver"), &PRECISIONS, Reference::Program));
    judge(&found);
}
