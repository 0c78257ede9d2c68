//! Rods end to end, and a body on its own.

use super::{Scene, box_inertia, critical_damping};
use forcec_runtime::prelude::{Rigid, Vec3};

/// The rods of [`Chain`]: 0.5 × 0.1 × 0.06 m and 1 kg.
pub const ROD: [f64; 3] = [0.25, 0.05, 0.03];

/// A chain of rods, to be varied.
#[derive(Clone, Copy, Debug)]
pub struct Chain {
    /// How many rods.
    pub rods: usize,
    /// Of every joint, N/m.
    pub stiffness: f64,
    /// In units of critical damping.
    pub damping: f64,
    /// The mass of rod k out of n, kg; the inertia is proportional to it.
    pub mass: fn(usize, usize) -> f64,
    /// Moments of a rod of 1 kg, kg·m².
    pub inertia: [f64; 3],
    /// The pin, m.
    pub origin: [f64; 3],
    /// The initial opening of each joint, m.
    pub stretch: f64,
    /// Whether the first rod is pinned to the world.
    pub pinned: bool,
}

impl Default for Chain {
    fn default() -> Chain {
        Chain {
            rods: 10,
            stiffness: 1e6,
            damping: 1.0,
            mass: |_, _| 1.0,
            inertia: box_inertia(1.0, ROD).into(),
            origin: [0.0; 3],
            stretch: 0.0,
            pinned: true,
        }
    }
}

impl Chain {
    /// The rods end to end along x, turning at (3, 0, 0.5) about the pin as one rigid piece.
    pub fn scene(self) -> Scene {
        let mut scene = Scene::new(0.5, 1.0 / 120.0);
        let spin = Vec3::new(3.0, 0.0, 0.5);
        let origin = Vec3::from(self.origin);
        let end = Vec3::x() * ROD[0];
        let mut before = (scene.pin(origin), Vec3::zeros(), [0.0; 2]);
        for k in 0..self.rods {
            let arm = Vec3::new((0.5 + self.stretch) * k as f64 + 0.25 + self.stretch, 0.0, 0.0);
            let mass = (self.mass)(k, self.rods);
            let inertia = self.inertia.map(|moment| moment * mass);
            let state = Rigid {
                position: origin + arm,
                velocity: spin.cross(&arm),
                angular_velocity: spin,
                ..Rigid::default()
            };
            let body = scene.rigid(state, mass, inertia.into(), ROD);
            // How either end gives way, by moving and by turning.
            let own = [1.0 / mass, end.norm_squared() / inertia[2]];
            let (other, arm_a, others) = before;
            if k > 0 || self.pinned {
                let mobility = own.into_iter().chain(others).sum();
                let damping = self.damping * critical_damping(self.stiffness, mobility);
                scene.joint([other, body], [arm_a, -end], self.stiffness, damping);
            }
            before = (body, end, own);
        }
        scene
    }
}

/// The chain of the catalogue.
pub fn c10(stiffness: f64) -> Scene {
    Chain { stiffness, ..Chain::default() }.scene()
}

/// A free body with moments 1, 2, 3 that spins about its middle axis, which is unstable.
pub fn t_handle() -> Scene {
    let mut scene = Scene::new(20.0, 1.0 / 60.0);
    scene.world.gravity = Vec3::zeros();
    scene.world.settings.integrator = forcec_runtime::Integrator::Rodas4;
    // When it turns over hangs on the smallest of errors.
    scene.world.settings.tolerance = 1e-9;
    let state = Rigid { angular_velocity: Vec3::new(0.01, 10.0, 0.0), ..Rigid::default() };
    scene.rigid(state, 1.0, Vec3::new(1.0, 2.0, 3.0), [0.7, 0.5, 0.3]);
    scene
}
