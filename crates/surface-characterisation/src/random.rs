//! Seeds and indices of the random draws.

use rand::Rng;
use rand_pcg::Pcg64;

/// A uniform index below `n`.
pub(crate) fn draw(rng: &mut Pcg64, n: usize) -> usize {
    ((u128::from(rng.next_u64()) * n as u128) >> 64) as usize
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
