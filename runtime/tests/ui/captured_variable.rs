use forcec_runtime::prelude::*;

macro_rules! scaled {
    ($name:ident, $x:ident, $e:expr) => {
        #[energy]
        pub fn $name(p: Particle, $x: Real) -> Real {
            let x = 2.0;
            p.position.x * x * $e
        }
    };
}

scaled!(captured, x, x * x);

fn main() {}
