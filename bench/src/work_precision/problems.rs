//! Scenes whose end is known.

use crate::scenes::{Scene, bar, c10, cloth, robots, t_handle};
use forcec_runtime::Integrator;
use forcec_runtime::prelude::Vec3;

/// A scene whose end is known.
#[derive(Debug)]
pub struct Problem {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Makes it.
    pub make: fn() -> Scene,
    /// How often it holds the same thing, side by side.
    pub copies: usize,
    /// The scene of the peers that is the same, if any.
    pub peers: Option<&'static str>,
    /// How many times as long a run of it may take as one of others.
    pub dear: f64,
    /// What is judged.
    pub judged: Judged,
}

/// What is judged.
#[derive(Debug)]
pub enum Judged {
    /// Where it ends.
    End(Reference),
    /// The largest change of energy on the way, for each copy.
    Energy,
}

/// What ends where it should.
#[derive(Debug)]
pub struct Reference {
    /// Makes it, coarser or finer: 0 and 1. Copies may be left out.
    pub make: fn(usize) -> Scene,
    /// Of order four.
    pub integrator: Integrator,
    /// The steps, s.
    pub steps: [f64; 2],
    /// What is compared.
    pub marks: fn(&Scene) -> Vec<Vec3>,
}

impl Problem {
    /// What its error is, with the unit.
    pub fn error(&self) -> &'static str {
        match self.judged {
            Judged::End(_) => "error, m",
            Judged::Energy => "largest change of a robot's energy, J",
        }
    }
}

const fn end(make: fn(usize) -> Scene, integrator: Integrator, steps: [f64; 2]) -> Judged {
    Judged::End(Reference { make, integrator, steps, marks: Scene::positions })
}

/// The ends of a body's axes, 1 m from its centre: its centre alone does not tell how it lies.
fn tips(scene: &Scene) -> Vec<Vec3> {
    let states = scene.bodies.iter().filter_map(|&body| scene.world.rigid(body).ok());
    states.flat_map(|state| [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| state.orientation * axis)).collect()
}

/// Half a second of the cloth, while it falls: later it depends on the smallest of errors.
fn falling() -> Scene {
    Scene { time: 0.5, ..cloth(40) }
}

/// The problems.
pub static PROBLEMS: [Problem; 8] = [
    Problem {
        name: "c10",
        about: "ten rods, joints of 1e6 N/m, after 0.5 s",
        make: || c10(1e6),
        copies: 1,
        peers: None,
        dear: 1.0,
        judged: end(|_| c10(1e6), Integrator::Rodas4, [1e-4, 5e-5]),
    },
    Problem {
        name: "c10-stiff",
        about: "ten rods, joints of 1e8 N/m, after 0.5 s",
        make: || c10(1e8),
        copies: 1,
        peers: None,
        dear: 1.0,
        judged: end(|_| c10(1e8), Integrator::Rodas4, [1e-4, 5e-5]),
    },
    Problem {
        name: "ben25-soft",
        about: "25 robots, driven, joints of 1e6 N/m, after 1 s",
        make: || robots(25, 1e6, true),
        copies: 25,
        peers: Some("ben25"),
        dear: 1.0,
        judged: end(rigid_robot, Integrator::Rodas4, [2e-4, 1e-4]),
    },
    Problem {
        name: "ben25",
        about: "25 robots, driven, joints of 1e7 N/m, after 1 s",
        make: || robots(25, 1e7, true),
        copies: 25,
        peers: Some("ben25"),
        dear: 1.0,
        judged: end(rigid_robot, Integrator::Rodas4, [2e-4, 1e-4]),
    },
    Problem {
        name: "ben25-free",
        about: "25 robots, turning freely, joints of 1e7 N/m, over 10 s",
        make: || robots(25, 1e7, false),
        copies: 25,
        peers: Some("ben25-free"),
        dear: 1.0,
        judged: Judged::Energy,
    },
    Problem {
        name: "t-handle",
        about: "a body that turns over, after 20 s",
        make: t_handle,
        copies: 1,
        peers: None,
        dear: 1.0,
        judged: Judged::End(Reference {
            make: |_| t_handle(),
            integrator: Integrator::RungeKutta4,
            steps: [1e-4, 5e-5],
            marks: tips,
        }),
    },
    Problem {
        name: "cloth",
        about: "a cloth of 40 × 40 particles, after 0.5 s",
        make: falling,
        copies: 1,
        peers: None,
        dear: 6.0,
        judged: end(|_| falling(), Integrator::RungeKutta4, [4e-4, 2e-4]),
    },
    Problem {
        name: "bar",
        about: "a bar of 20 × 4 × 4 cells of tetrahedra, after 1 s",
        make: || bar([20, 4, 4]),
        copies: 1,
        peers: None,
        dear: 1.0,
        judged: end(|_| bar([20, 4, 4]), Integrator::RungeKutta4, [4e-4, 2e-4]),
    },
];

/// One robot with joints so stiff that they hardly give way.
fn rigid_robot(fine: usize) -> Scene {
    robots(1, [1e9, 1e10][fine], true)
}
