//! Kernels where their formulas are singular, and one that is wrong.

use super::{Verdict, watch};
use crate::scenes::Scene;
use forcec_constraints::joints::{point_to_point_norm, torsion_spring};
use forcec_runtime::prelude::{Particle, Quat, Rigid, Vec3, constraint};

/// Two particles at one place.
#[constraint(real = f64)]
fn tie(a: Particle, b: Particle) -> Vec3 {
    b.position - a.position
}

pub(super) fn tie_at_zero(_: bool) -> Verdict {
    let (a, b) = (Particle::default(), Particle::default());
    let mut out = tie::Output::default();
    tie::evaluate(&a, &b, &tie::Params { stiffness: 1e6, damping: 1e3 }, &mut out);
    let numbers = out.force.iter().chain(out.dfdx.as_flattened()).chain(out.dfdv.as_flattened());
    let finite = numbers.into_iter().all(|x| x.is_finite());
    Verdict {
        passes: finite && out.dfdx[0][0] == -1e6,
        text: format!("finite {finite}, ∂F/∂x = {:e}", out.dfdx[0][0]),
    }
}

pub(super) fn short(_: bool) -> Verdict {
    let (mut stood, mut stable, mut bad) = (Vec::new(), 0, Vec::new());
    for power in [-300, -200, -160, -150, -100, -50, -16, -12, -8] {
        let make = || {
            let mut scene = Scene::new(0.5, 1.0 / 120.0);
            let pin = scene.pin(Vec3::zeros());
            let position = Vec3::new(10.0_f64.powi(power), 0.0, 0.0);
            let body = scene.rigid(Rigid { position, ..Rigid::default() }, 1.0, Vec3::repeat(0.1), [0.1; 3]);
            let params = point_to_point_norm::Params {
                arm_a: [0.0; 3],
                arm_b: [0.0; 3],
                stiffness: 1e6,
                damping: 100.0,
            };
            scene.world.add(params, [pin, body]).expect("a joint");
            scene
        };
        let seen = watch(&mut make(), 0.5, |_| 1.0 / 120.0);
        match (seen.quarantined, seen.is_stable()) {
            (1.., _) => stood.push(format!("1e{power}")),
            (0, true) => stable += 1,
            (0, false) => bad.push(format!("1e{power}: {seen}")),
        }
    }
    Verdict {
        passes: bad.is_empty(),
        text: format!("{stable} **U**; quarantined: {}; neither: {}", list(&stood), list(&bad)),
    }
}

fn list(items: &[String]) -> String {
    if items.is_empty() { "none".to_owned() } else { items.join(", ") }
}

pub(super) fn angles(_: bool) -> Verdict {
    let (stiffness, pi) = (10.0, std::f64::consts::PI);
    let params = torsion_spring::Params {
        axis_a: [0.0, 0.0, 1.0],
        normal_a: [1.0, 0.0, 0.0],
        normal_b: [1.0, 0.0, 0.0],
        stiffness,
        damping: 0.0,
    };
    let mut worst = 0.0_f64;
    for angle in [0.0, 1e-12, pi - 1e-12, pi] {
        let b = Rigid { orientation: Quat::from_axis_angle(&Vec3::z_axis(), angle), ..Rigid::default() };
        let mut out = torsion_spring::Output::default();
        torsion_spring::evaluate(&Rigid::default(), &b, &params, &mut out);
        // Torque on b is −k θ, its derivative along θ is −k.
        worst = worst
            .max((out.dfdx[11][11] / -stiffness - 1.0).abs())
            .max((out.force[11].abs() - stiffness * angle).abs());
    }
    Verdict { passes: worst <= 1e-6, text: format!("error at most {worst:.1e}") }
}

pub(super) fn flipped(_: bool) -> Verdict {
    let library = crate::library();
    let source =
        library.iter().find(|source| source.name.ends_with("joints.rs")).expect("the file of joints");
    let compiled = crate::compile_all(source);
    let function = compiled
        .functions
        .iter()
        .find(|stages| stages.kernel.name == "point_to_point")
        .expect("the ball joint");
    let (mut caught, mut tried, mut name) = (0, 0, String::new());
    for mutation in forcec::internals::verify::mutations(&function.program) {
        if !matches!(mutation, forcec::internals::verify::Mutation::Output(_)) {
            continue;
        }
        let mutant = forcec::internals::verify::apply(&function.program, mutation);
        let subject = forcec::internals::verify::Subject { source: &function.source, program: &mutant };
        let report = forcec::internals::verify::check(
            &subject,
            &forcec::internals::verify::CheckOptions { seed: 1, states: 1 },
        );
        tried += 1;
        if let (false, Some(entry)) = (report.passed, report.worst_failure()) {
            caught += 1;
            name.clone_from(&entry.name);
        }
    }
    Verdict {
        passes: tried > 0 && caught == tried,
        text: format!("{caught} of {tried} caught, the last as `{name}`"),
    }
}
