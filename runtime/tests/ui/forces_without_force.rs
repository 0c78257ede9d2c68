use forcec_runtime::prelude::*;

#[forces]
mod springs {
    use forcec_runtime::prelude::*;

    pub fn square(x: Real) -> Real {
        x * x
    }
}

fn main() {}
