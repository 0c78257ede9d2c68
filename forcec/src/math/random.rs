//! Random numbers from a seed, the same on every machine: the splitmix64 generator of Steele, Lea and Flood, "Fast
//! splittable pseudorandom number generators", 2014.
//!
//! One file for the compiler, its tests and a build script of the tests, which names the file by its path.

/// The state of the generator.
pub struct Random(u64);

impl Random {
    /// A generator from a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `limit`, 0 if `limit` is 0.
    pub fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }

    /// A uniform number between `low` and `high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.next() >> 11) as f64 / (1u64 << 53) as f64;
        (low + (high - low) * unit).clamp(low, high)
    }

    /// A random decade of 10^low to 10^high, then uniform in it; without library calls, the same everywhere.
    pub(crate) fn decades(&mut self, low: i32, high: i32) -> f64 {
        let decade = low + (self.next() % (high - low).max(1) as u64) as i32;
        let power = (0..decade.unsigned_abs()).fold(1.0, |power, _| power * 10.0);
        let power = if decade < 0 { 1.0 / power } else { power };
        power * self.uniform(1.0, 10.0)
    }

    pub(crate) fn chance(&mut self, one_in: u64) -> bool {
        self.next().is_multiple_of(one_in)
    }

    /// A random vector of length one.
    pub(crate) fn unit(&mut self, length: usize) -> Vec<f64> {
        loop {
            let v: Vec<f64> = (0..length).map(|_| self.uniform(-1.0, 1.0)).collect();
            let square: f64 = v.iter().map(|x| x * x).sum();
            if square > 0.01 && square <= 1.0 {
                return v.iter().map(|x| x / square.sqrt()).collect();
            }
        }
    }
}
