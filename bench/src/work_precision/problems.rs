//! Scenes with a known final state.

use crate::scenes::{Scene, bar, c10, cloth, robots, t_handle};
use forcec_runtime::Integrator;
use forcec_runtime::prelude::Vec3;

/// A scene with a known final state.
#[derive(Debug)]
pub struct Problem {
    /// Name of the problem.
    pub name: &'static str,
    /// Description of the scene.
    pub about: &'static str,
    /// Creates the scene.
    pub make: fn() -> Scene,
    /// Number of copies of the same system in the scene, side by side.
    pub copies: usize,
    /// Name of the equivalent scene of the peers, if any.
    pub peers: Option<&'static str>,
    /// Factor on the allowed run time compared with other problems.
    pub cost_factor: f64,
    /// The measured error.
    pub judged: Judged,
}

/// The measured error.
#[derive(Debug)]
pub enum Judged {
    /// The error of the final state.
    End(Reference),
    /// The largest change of energy during the run, for each copy.
    Energy,
}

/// A reference solution.
#[derive(Debug)]
pub struct Reference {
    /// Creates the scene at two refinements, 0 (coarse) and 1 (fine). Copies may be omitted.
    pub make: fn(usize) -> Scene,
    /// An integrator of order four.
    pub integrator: Integrator,
    /// The step sizes, s.
    pub steps: [f64; 2],
    /// The compared points.
    pub marks: fn(&Scene) -> Vec<Vec3>,
}

impl Problem {
    /// Description of the error, with the unit.
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

/// The end points of a body's axes, 1 m from its centre, because the centre alone does not determine the
/// orientation.
fn tips(scene: &Scene) -> Vec<Vec3> {
    let states = scene.bodies.iter().filter_map(|&body| scene.world.rigid(body).ok());
    states.flat_map(|state| [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| state.orientation * axis)).collect()
}

/// The first half second of the falling cloth; later states are sensitive to the smallest errors.
fn falling() -> Scene {
    Scene { time: 0.5, ..cloth(40) }
}

/// The problems.
pub static PROBLEMS: [Problem; 10] = [
    Problem {
        name: "c10",
        about: "ten rods, joints of 1e6 N/m, after 0.5 s",
        make: || c10(1e6),
        copies: 1,
        peers: None,
        cost_factor: 1.0,
        judged: end(|_| c10(1e6), Integrator::Rodas4, [1e-4, 5e-5]),
    },
    Problem {
        name: "c10-stiff",
        about: "ten rods, joints of 1e8 N/m, after 0.5 s",
        make: || c10(1e8),
        copies: 1,
        peers: None,
        cost_factor: 1.0,
        judged: end(|_| c10(1e8), Integrator::Rodas4, [1e-4, 5e-5]),
    },
    Problem {
        name: "ben25-soft",
        about: "25 robots, driven, joints of 1e6 N/m, after 1 s",
        make: || robots(25, 1e6, true),
        copies: 25,
        peers: Some("ben25"),
        cost_factor: 1.0,
        judged: end(rigid_robot, Integrator::Rodas4, [2e-4, 1e-4]),
    },
    Problem {
        name: "ben25",
        about: "25 robots, driven, joints of 1e7 N/m, after 1 s",
        make: || robots(25, 1e7, true),
        copies: 25,
        peers: Some("ben25"),
        cost_factor: 1.0,
        judged: end(rigid_robot, Integrator::Rodas4, [2e-4, 1e-4]),
    },
    Problem {
        name: "ben25-free",
        about: "25 robots, turning freely, joints of 1e7 N/m, over 10 s",
        make: || robots(25, 1e7, false),
        copies: 25,
        peers: Some("ben25-free"),
        cost_factor: 1.0,
        judged: Judged::Energy,
    },
    Problem {
        name: "ben25-rigid",
        about: "25 robots, driven, rigid joints, after 1 s",
        make: || rigid(25, true),
        copies: 25,
        peers: Some("ben25"),
        cost_factor: 1.0,
        judged: end(|_| rigid(1, true), Integrator::RungeKutta4, [2e-4, 1e-4]),
    },
    Problem {
        name: "ben25-rigid-free",
        about: "25 robots, turning freely, rigid joints, over 10 s",
        make: || rigid(25, false),
        copies: 25,
        peers: Some("ben25-free"),
        cost_factor: 1.0,
        judged: Judged::Energy,
    },
    Problem {
        name: "t-handle",
        about: "a body that turns over, after 20 s",
        make: t_handle,
        copies: 1,
        peers: None,
        cost_factor: 1.0,
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
        cost_factor: 6.0,
        judged: end(|_| falling(), Integrator::RungeKutta4, [4e-4, 2e-4]),
    },
    Problem {
        name: "bar",
        about: "a bar of 20 × 4 × 4 cells of tetrahedra, after 1 s",
        make: || bar([20, 4, 4]),
        copies: 1,
        peers: None,
        cost_factor: 1.0,
        judged: end(|_| bar([20, 4, 4]), Integrator::RungeKutta4, [4e-4, 2e-4]),
    },
];

/// Robots with rigid joints, and steps that are not shortened, because the error is measured.
fn rigid(count: usize, driven: bool) -> Scene {
    let mut scene = robots(count, f64::INFINITY, driven);
    (scene.world.settings.tolerance, scene.world.settings.energy_growth) = (f64::INFINITY, f64::INFINITY);
    scene
}

/// One robot with joints so stiff that they hardly give way.
fn rigid_robot(fine: usize) -> Scene {
    robots(1, [1e9, 1e10][fine], true)
}
