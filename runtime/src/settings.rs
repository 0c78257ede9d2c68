//! How a world is stepped.

use crate::iterative::Solver;
use crate::methods::Integrator;
use nalgebra::{RealField, convert};

/// How a world is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<R> {
    /// The method of integration.
    pub integrator: Integrator,
    /// The method for linear systems. `Rodas4`, which solves with one matrix six times, always eliminates.
    pub solver: Solver,
    /// What `Rodas4` may err in a step, m and rad.
    pub tolerance: R,
    /// By how much the energy of an island may grow in a call of `step`, as a share of the most kinetic and elastic
    /// energy it has had of late. Work that is done on it from outside is allowed beside that.
    pub energy_growth: R,
    /// The same for energy that is lost; none if losing is fine, as it must be where something damps.
    pub energy_loss: Option<R>,
    /// When islands fall asleep; none if they never do.
    pub sleep: Option<Sleep<R>>,
    /// Islands above a size are solved in parts; none if they never are.
    pub decoupling: Option<Decoupling>,
}

/// When an island falls asleep.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sleep<R> {
    /// Its bodies are slower than this, m/s and rad/s,
    pub speed: R,
    /// for this long, s.
    pub time: R,
}

/// How islands are solved in parts: forces across a cut act, but their derivatives from part to part are left out. Where
/// the cuts lie changes from step to step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Decoupling {
    /// The most bodies of a part.
    pub limit: usize,
    /// Decides where the cuts lie.
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
        }
    }
}
