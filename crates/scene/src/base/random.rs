//! Random numbers that depend on where they are used alone, so that the order of threads does not matter.

use rand_core::RngCore;

/// Numbers in [0, 1) by (seed, cell, count): SplitMix64 (Steele, Lea & Flood 2014).
pub struct Counter(u64);

/// Increment of the state: 2⁶⁴ by the golden ratio.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

impl Counter {
    /// The sequence of a cell.
    pub fn new(seed: u64, cell: u64) -> Self {
        Self(seed.wrapping_mul(STEP) ^ cell.wrapping_mul(0xd134_2543_de82_ef95))
    }

    /// The sequence of a part of a cell, far from those of all others.
    pub fn nested(seed: u64, cell: u64, part: u64) -> Self {
        let bits = Self::new(seed, cell).bits();
        Self(Self::new(bits, part).bits())
    }

    /// The next number, evenly spread over [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Skips a number of values.
    pub fn skip(&mut self, count: u64) {
        self.0 = self.0.wrapping_add(STEP.wrapping_mul(count));
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

/// For distributions of other crates.
impl RngCore for Counter {
    fn next_u32(&mut self) -> u32 {
        (self.bits() >> 32) as u32
    }

    fn next_u64(&mut self) -> u64 {
        self.bits()
    }

    fn fill_bytes(&mut self, bytes: &mut [u8]) {
        rand_core::impls::fill_bytes_via_next(self, bytes);
    }
}
