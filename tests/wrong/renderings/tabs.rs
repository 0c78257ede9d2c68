#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
	let d = b.position	- a.positon;
	k	* d.norm_squared()
}
