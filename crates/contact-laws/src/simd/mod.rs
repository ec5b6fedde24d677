//! Passes over blocks of points, compiled for the vector registers that the processor has.
//!
//! A pass is written as plain loops over arrays of [`BLOCK`] numbers, without branches on the values, so that the
//! compiler can turn several points into one instruction. [`run`] executes it with AVX-512 or AVX2 where the processor
//! has them and otherwise with what every processor of the target has. A point's result has the same bits in every
//! block and at any place in it, because additions, multiplications, divisions and square roots are rounded alike in
//! every register width. Only [`elementary`] fuses operations where the processor can, and so differs in the last bits
//! from processors that cannot.
//!
//! Two things keep the compiler from using the registers: arrays that it cannot tell apart (give each an argument of its
//! own), and functions that take what a loop loads by reference (pass values; references to [`Lanes`] made short batches
//! slower by a quarter).

pub(crate) mod bounds;
pub(crate) mod elementary;

use core::ops::Range;

/// Points per block: the dozen arrays of a pass stay in the first-level cache.
pub(crate) const BLOCK: usize = 64;
/// Points per block of a short batch: what is set up for a block is then much less.
pub(crate) const SHORT_BLOCK: usize = 8;

/// Points that are looked at together where some need more than others: as many as the widest register has numbers.
pub(crate) const WIDTH: usize = 8;

/// The numbers of `W` points.
#[inline(always)]
pub(crate) fn lanes<const W: usize>(values: &[f64]) -> [f64; W] {
    let mut lanes = [0.0; W];
    lanes.copy_from_slice(&values[..W]);
    lanes
}

/// Numbers of the `B` points of a block, at the alignment of a vector register.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Lanes<T, const B: usize>(pub(crate) [T; B]);

/// A loop over the points of a block.
pub(crate) trait Pass {
    /// `FMA`: the processor fuses a multiplication with an addition in one instruction; without it, fusing would be
    /// slow.
    ///
    /// Must be `#[inline(always)]`: what is inlined takes on the instruction set of [`run`]'s callee, what is called
    /// does not. A closure counts as called.
    fn run<const FMA: bool>(self);
}

/// Runs a pass with the widest instruction set there is.
#[inline]
pub(crate) fn run(pass: impl Pass) {
    #[cfg(all(target_arch = "x86_64", feature = "std"))]
    match x86::widest() {
        // SAFETY: `widest` gives this only where the processor has what the callee is compiled for.
        #[expect(unsafe_code, reason = "the call from code for any processor into code for AVX-512")]
        x86::Widest::Avx512 => return unsafe { x86::avx512(pass) },
        // SAFETY: as above.
        #[expect(unsafe_code, reason = "the call from code for any processor into code for AVX2")]
        x86::Widest::Avx2 => return unsafe { x86::avx2(pass) },
        x86::Widest::Baseline => {}
    }
    pass.run::<false>();
}

/// Environment variable that is read at the first evaluation: `avx2` and `baseline` ask for no more than AVX2 with FMA, or than
/// what every processor of the target has. Other values ask for nothing.
#[cfg(all(target_arch = "x86_64", feature = "std"))]
const INSTRUCTION_SET: &str = "CONTACT_LAWS_INSTRUCTION_SET";

/// Name of the instruction set that laws are evaluated with: the widest that the processor has, or less where the environment
/// variable `CONTACT_LAWS_INSTRUCTION_SET` is `avx2` or `baseline` at the first evaluation.
pub fn instruction_set() -> &'static str {
    #[cfg(all(target_arch = "x86_64", feature = "std"))]
    match x86::widest() {
        x86::Widest::Avx512 => return "AVX-512",
        x86::Widest::Avx2 => return "AVX2 and FMA",
        x86::Widest::Baseline => {}
    }
    "baseline"
}

/// The numbers of a block in each slice.
#[inline]
pub(crate) fn part<'a, const N: usize>(slices: &[&'a [f64]; N], block: &Range<usize>) -> [&'a [f64]; N] {
    let mut parts: [&[f64]; N] = [&[]; N];
    for (part, slice) in parts.iter_mut().zip(slices) {
        *part = &slice[block.clone()];
    }
    parts
}

/// Like [`part`], to be written.
#[inline]
pub(crate) fn part_mut<'a, const N: usize>(
    slices: &'a mut [&mut [f64]; N],
    block: &Range<usize>,
) -> [&'a mut [f64]; N] {
    let mut parts: [&mut [f64]; N] = core::array::from_fn(|_| -> &mut [f64] { &mut [] });
    for (part, slice) in parts.iter_mut().zip(slices) {
        *part = &mut slice[block.clone()];
    }
    parts
}

#[cfg(all(target_arch = "x86_64", feature = "std"))]
mod x86 {
    use super::{INSTRUCTION_SET, Pass};
    use core::sync::atomic::{AtomicU8, Ordering};

    #[derive(Clone, Copy)]
    pub(super) enum Widest {
        Avx512 = 1,
        Avx2 = 2,
        Baseline = 3,
    }

    /// The choice as a number, 0 before the first call.
    static CHOSEN: AtomicU8 = AtomicU8::new(0);

    #[inline]
    pub(super) fn widest() -> Widest {
        match CHOSEN.load(Ordering::Relaxed) {
            1 => Widest::Avx512,
            2 => Widest::Avx2,
            3 => Widest::Baseline,
            _ => choose(),
        }
    }

    /// What the processor has, or less where the environment asks for less. All threads choose alike.
    #[cold]
    fn choose() -> Widest {
        use std::arch::is_x86_feature_detected as has;
        let asked = std::env::var(INSTRUCTION_SET).unwrap_or_default();
        let avx2 = has!("avx2") && has!("fma") && asked != "baseline";
        let avx512 = has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl");
        let chosen = match (avx2, avx512 && asked != "avx2") {
            (true, true) => Widest::Avx512,
            (true, false) => Widest::Avx2,
            (false, _) => Widest::Baseline,
        };
        CHOSEN.store(chosen as u8, Ordering::Relaxed);
        chosen
    }

    #[target_feature(enable = "avx2,fma,avx512f,avx512bw,avx512dq,avx512vl")]
    pub(super) fn avx512(pass: impl Pass) {
        pass.run::<true>();
    }

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn avx2(pass: impl Pass) {
        pass.run::<true>();
    }
}
