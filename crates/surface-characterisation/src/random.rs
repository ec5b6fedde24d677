//! Seeds, indices and normal deviates of the random draws.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// A uniform index below `n`.
pub(crate) fn draw(rng: &mut Pcg64, n: usize) -> usize {
    ((u128::from(rng.next_u64()) * n as u128) >> 64) as usize
}

/// A uniform deviate in (0, 1): never zero, so that its logarithm exists.
pub(crate) fn uniform(rng: &mut Pcg64) -> f64 {
    ((rng.next_u64() >> 11) as f64 + 0.5) * 2f64.powi(-53)
}

/// One seed from a seed and two indices (SplitMix64 steps), so that neighbours of all three give unrelated streams.
pub(crate) fn mix(seed: u64, a: u64, b: u64) -> u64 {
    // The seed is scattered before the first index meets it: else seed 1 with index 2 would be seed 2 with index 1.
    [seed, a, b].iter().fold(0, |state, &part| {
        let mut z = (state ^ part).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}

/// Standard normal deviates in pairs (Box and Muller).
pub(crate) struct NormalDeviates {
    rng: Pcg64,
    spare: Option<f64>,
}

impl NormalDeviates {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            rng: Pcg64::seed_from_u64(seed),
            spare: None,
        }
    }

    pub(crate) fn next(&mut self) -> f64 {
        if let Some(z) = self.spare.take() {
            return z;
        }
        let radius = (-2.0 * uniform(&mut self.rng).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * uniform(&mut self.rng)).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }
}
