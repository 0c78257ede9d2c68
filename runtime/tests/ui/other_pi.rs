use forcec_runtime::prelude::{Particle, Real, energy, forces};

mod other {
    pub const PI: f64 = 3.0;
}

mod alone {
    use super::other::PI;
    use super::*;

    #[energy]
    pub fn weight(p: Particle) -> Real {
        p.position.x * PI
    }
}

#[forces]
mod imported {
    use super::other::PI;

    #[energy]
    pub fn weight(p: Particle) -> Real {
        p.position.x * PI
    }
}

#[forces]
mod by_path {
    fn twice(x: Real) -> Real {
        2.0 * x
    }

    #[energy]
    pub fn weight(p: Particle) -> Real {
        other::twice(p.position.x) * other::PI + twice(1.0)
    }
}

fn main() {}
