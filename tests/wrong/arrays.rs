//! Arrays, and indices of arrays, vectors and matrices.

// case: empty_array
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let v = [];
//~         ^^ its type is not known
//~ ERROR an empty array
    k * a.position.dot(&b.position)
}

// case: array_out_of_bounds
#[energy]
pub fn f(p: Particle, w: [Real; 3]) -> Real {
    w[3] + w[-1] + p.position[3]
//~   ^ 3 is not among 0 to 2
//~ ERROR an index out of range
//~          ^^ -1 is not among 0 to 2
//~ ERROR an index out of range
//~                           ^ 3 is not among 0 to 2
//~ ERROR an index out of range
}

// case: index_out_of_range
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    k * d[3]
//~       ^ 3 is not among 0 to 2
//~ ERROR an index out of range
}

// case: index_of_loop_out_of_range
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for i in 0..=3 {
        sum += (b.position - a.position)[i].powi(2);
//~                                      ^ 3 is not among 0 to 2
//~ ERROR an index out of range
    }
    k * sum
}

// case: index_by_real
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    k * d[1.0]
//~       ^^^ this is `Real`
//~ ERROR an index is an integer, not `Real`
//~ HELP write an integer, `0`, or the variable of a loop
}

// case: index_of_tuple
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let pair = (k, a.position.dot(&b.position));
    pair[0]
//~ ^^^^^^^ this is `(Real, Real)`
//~ ERROR `(Real, Real)` cannot be indexed
//~ HELP write `.0`, `.1` for the elements of a tuple
}

// case: matrix_indexed_by_one
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real, m: Mat3) -> Real {
    m[0] * k * a.position.dot(&b.position)
//~   ^ this is an integer
//~ ERROR a matrix is indexed by row and column
//~ HELP write `m[(row, column)]`
}
