struct Spring {
    k: Real,
}

enum Kind {
    Soft,
}

static K: Real = 1.0;

type Scalar = Real;

trait Law {}

macro_rules! spring {
    () => {};
}

extern crate nalgebra;
