//! How a constraint holds.

use crate::error::Error;
use crate::kernel::Kernel;
use nalgebra::RealField;

/// How a constraint holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Law<R> {
    /// By the stiffness and damping among its parameters.
    #[default]
    Penalty,
    /// By a compliance per row, m/N or rad/(N m), which replaces both: a stiffness of its inverse, no damping.
    /// Zero is `Rigid`.
    Compliance(R),
    /// By multipliers, which are unknowns of each step: C = 0 and Ċ = 0 at its end, whatever the stiffness and
    /// damping among the parameters. Not for one-sided constraints.
    Rigid,
}

impl<R: RealField + Copy> Law<R> {
    /// The parameters by this law, and whether the rows are rigid.
    pub(super) fn apply<K: Kernel<Real = R>>(self, params: K::Params) -> Result<(K::Params, bool), Error> {
        if self == Law::Penalty {
            return Ok((params, false));
        }
        if K::ROWS == 0 {
            return Err(Error::NotAConstraint(K::NAME));
        }
        match self {
            Law::Compliance(c) if !c.is_finite() || c < R::zero() => Err(Error::NotPositive),
            Law::Compliance(c) if c > R::zero() => {
                let mut params = params;
                let set = K::set_penalty(&mut params, R::one() / c, R::zero());
                if set { Ok((params, false)) } else { Err(Error::NotAConstraint(K::NAME)) }
            }
            _ if K::ONE_SIDED => Err(Error::OneSided(K::NAME)),
            _ => Ok((params, true)),
        }
    }
}
