#![allow(outside_domain, reason = "for the whole file")]

fn length(v: Vec3) -> Real {
    v.norm()
}

#[allow(singular, reason = "a helper answers for all who call it")]
fn known(v: Vec3) -> Real {
    v.norm()
}

/// Warned of: `length` and `unread`.
#[energy]
#[allow(clippy::too_many_arguments, unused_variables, dead_code)]
pub fn plain(p: Particle, unread: Real) -> Real {
    length(p.position) + known(p.position)
}

/// Nothing of this is warned of, but `length` because of `plain`.
#[energy]
#[allow(singular, unused, reason = "the spring is never short")]
pub fn answered(p: Particle, unread: Real) -> Real {
    p.position.y;
    length(p.position) + p.position.norm()
}

#[forces]
#[allow(unused, reason = "for the module")]
mod inner {
    /// Warned of because there is no reason.
    #[energy]
    #[allow(singular)]
    pub fn bare(p: Particle, unread: Real) -> Real {
        p.position.norm()
    }

    #[energy]
    pub fn after(p: Particle, unread: Real) -> Real {
        p.position.norm()
    }
}
