//! Kernels with an early return: if a contact does not touch or a limit is not reached, these kernels return
//! zeros after a part of their operations, and in no other case; NaN inputs reach the output.

use forcec::internals::compile::Stages;
use forcec::internals::scalar::{Operations, eval};
use forcec::internals::schedule::Statement;
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{Family, Subject};
use forcec_tests::{Places, library, unseen};

/// Number of states per kernel.
const STATES: usize = 64;

/// The number of operations before the first early return, and of all operations.
fn before_leaving(function: &Stages) -> Option<(usize, usize)> {
    let schedule = &function.kernel.schedule;
    let leave = schedule.statements.iter().position(|s| matches!(s, Statement::Leave(_)))?;
    let mut before = Operations::default();
    let statements = schedule.statements[..=leave].iter().flat_map(Statement::expressions);
    statements.for_each(|value| before += value.operations());
    Some((before.total(), schedule.operations().total()))
}

/// The results of a schedule in doubles.
fn computed(function: &Stages, inputs: &[f64]) -> Vec<f64> {
    let places = Places::new(&function.program.signature);
    let outputs = function.kernel.schedule.evaluate::<f64>(&|slot| inputs[places.of(slot)]);
    outputs.expect("every output is written").iter().copied().collect()
}

#[test]
fn what_does_nothing_leaves_early() {
    let files = library();
    let functions = files.iter().flat_map(|file| &file.compiled.functions);
    for function in functions.filter(|f| f.definition.law.rows() > 0 && f.definition.name.contains("sphere"))
    {
        assert!(before_leaving(function).is_some(), "{} leaves", function.definition.name);
    }
    let files: Vec<_> = files.into_iter().chain(unseen()).collect();
    let (mut leaving, mut at_rest) = (0, 0);
    for function in files.iter().flat_map(|file| &file.compiled.functions) {
        let Some((before, all)) = before_leaving(function) else { continue };
        let name = &function.definition.name;
        leaving += 1;
        eprintln!("{name}: {before} of {all} operations, {} % skipped", 100 * (all - before) / all);
        let subject = Subject { source: &function.source, program: &function.program };
        let probe = Probe::new(&subject);
        let (mut idle, mut acting) = (0, 0);
        for index in 0..STATES {
            let inputs = probe.draw(Family::Random, 5, index);
            let exact = probe.program(&inputs);
            if exact.iter().any(|x| !x.is_finite()) {
                continue;
            }
            let computed = computed(function, &inputs);
            let nothing = exact.iter().all(|x| *x == 0.0);
            *(if nothing { &mut idle } else { &mut acting }) += 1;
            assert_eq!(computed.iter().all(|x| *x == 0.0), nothing, "{name} at {:?}", probe.inputs(&inputs));
        }
        assert!(acting > 0, "{name} acts");
        at_rest += usize::from(idle > 0);
        let nothing = vec![f64::NAN; probe.draw(Family::Random, 5, 0).len()];
        let whole = eval::evaluate(&function.program, &|_| f64::NAN);
        let handed_on = whole.iter().any(|x| x.is_nan());
        let computed = computed(function, &nothing);
        let both_zero = whole.iter().all(|x| *x == 0.0) <= computed.iter().all(|x| *x == 0.0);
        assert!(both_zero, "{name} is zero where its source chooses so");
        assert!(!handed_on || computed.iter().any(|x| x.is_nan()), "{name} hands on what is not a number");
    }
    assert!(at_rest >= 10, "{leaving} kernels leave, {at_rest} are seen to");
}

/// If the source returns zero when a comparison is false, the kernel also returns zero when a NaN makes the
/// comparison false.
#[test]
fn what_is_not_a_number_goes_the_way_of_the_source() {
    let text = "#[force]\npub fn floor(p: Particle, k: Real, d: Real) -> Vec3 {\n\
                let z = p.position.z;\n\
                if z < 0.0 { Vec3::new(0.0, k * z * z, -k * z + d * z * p.velocity.z * p.velocity.z) } else { Vec3::zeros() }\n}\n";
    let source = forcec::internals::source::span::Source::new("floor.rs", text);
    let compiled = forcec::internals::compile::compile(
        &source,
        &|_| true,
        forcec::internals::options::plan::Effort::Default,
    )
    .unwrap();
    let function = &compiled.functions[0];
    assert!(before_leaving(function).is_some(), "{}", function.kernel.schedule);
    for z in [-1.0, 0.0, 1.0, f64::NAN] {
        let mut inputs = vec![0.5; 16];
        inputs[2] = z;
        let acts = computed(function, &inputs).iter().any(|x| *x != 0.0);
        assert_eq!(acts, z < 0.0, "at {z}");
    }
}
