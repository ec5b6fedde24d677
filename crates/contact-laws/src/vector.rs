//! Passes over blocks of points, compiled for the vector registers that the processor has.
//!
//! A pass is written as plain loops over arrays of [`BLOCK`] numbers, without branches on the values, so that the
//! compiler can turn several points into one instruction. [`run`] executes it with AVX2 where the processor has it and
//! otherwise with what every processor of the target has. A point's result has the same bits in every block and at any
//! place in it, because additions, multiplications, divisions and square roots are rounded alike in every register
//! width. Only [`crate::elementary`] fuses operations where the processor can, and so differs in the last bits from
//! processors that cannot.

/// Points per block: the dozen arrays of a pass stay in the first-level cache.
pub(crate) const BLOCK: usize = 64;
/// Points per block of a short batch: what is set up for a block is then much less.
pub(crate) const SHORT_BLOCK: usize = 8;

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
    if has_avx2() {
        // SAFETY: the processor has AVX2 and FMA, asked in the line above.
        #[expect(unsafe_code, reason = "the one call from code for any processor into code for AVX2")]
        unsafe {
            avx2(pass);
        }
        return;
    }
    pass.run::<false>();
}

#[cfg(all(target_arch = "x86_64", feature = "std"))]
#[inline]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

#[cfg(all(target_arch = "x86_64", feature = "std"))]
#[target_feature(enable = "avx2,fma")]
fn avx2(pass: impl Pass) {
    pass.run::<true>();
}

/// Name of the instruction set that laws are evaluated with.
pub fn instruction_set() -> &'static str {
    #[cfg(all(target_arch = "x86_64", feature = "std"))]
    if has_avx2() {
        return "AVX2 and FMA";
    }
    "baseline"
}
