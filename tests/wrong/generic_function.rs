#[energy]
pub fn well<T: Scalar>(a: Particle, k: T) -> Real
where
    T: Copy,
{
    k * a.position.x
}
