//! The settings of steps.

use crate::step::Integrator;
use crate::system::iterative::Solver;
use nalgebra::{RealField, convert};

/// The methods and tolerances of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<R> {
    /// The method of integration.
    pub integrator: Integrator,
    /// The method for linear systems. `Rodas4` always uses elimination, because its matrix serves six times.
    pub solver: Solver,
    /// The tolerated error per step, m and rad: the estimate of `Rodas4`; with `RungeKutta4` the gap that rigid
    /// constraints have before they are projected. Infinity leaves steps as they are.
    pub tolerance: R,
    /// The tolerated growth of an island's energy per call of `step`, relative to its largest recent kinetic
    /// and elastic energy. Work done from outside is allowed in addition.
    pub energy_growth: R,
    /// The same for a loss of energy; `None` allows any loss, as damping requires.
    pub energy_loss: Option<R>,
    /// The condition for falling asleep; `None` disables sleep.
    pub sleep: Option<Sleep<R>>,
    /// The solution of large islands in parts; `None` disables it.
    pub decoupling: Option<Decoupling>,
    /// The largest number of equal islands that explicit methods step at once, with the same bits as one by
    /// one: 1, 2, 4 or 8; `None` chooses by the processor.
    pub lanes: Option<usize>,
}

/// The condition for falling asleep.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sleep<R> {
    /// The speed below which a body counts as slow, m/s and rad/s.
    pub speed: R,
    /// The time for which all bodies must be slow, s.
    pub time: R,
}

/// Solves large islands in parts: forces act across cuts, derivatives between parts are neglected. Cuts vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Decoupling {
    /// The largest number of bodies in a part.
    pub limit: usize,
    /// The seed of the cuts.
    pub seed: u64,
}

impl<R: RealField + Copy> Default for Settings<R> {
    fn default() -> Settings<R> {
        Settings {
            integrator: Integrator::default(),
            solver: Solver::default(),
            tolerance: convert(1e-5),
            energy_growth: convert(1e-3),
            energy_loss: None,
            sleep: None,
            decoupling: None,
            lanes: None,
        }
    }
}
