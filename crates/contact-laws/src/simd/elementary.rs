//! Exponential and logarithm from additions, multiplications and one division, for loops that fill vector registers.
//!
//! `exp`: `x = n ln 2 + r`, `|r| <= ln(2)/2`, `e^r = 1 + r + r^2 q(r)`. `ln`: `x = 2^n m`, `m` between `sqrt(1/2)` and
//! `sqrt(2)`, `ln m = 2 artanh s = s (2 + s^2 p(s^2))`, `s = (m - 1)/(m + 1)`. The coefficients of `q` and `p` are
//! Chebyshev fits of their functions, made with 60 digits. Truncation, relative: `exp` 1.2e-15 and 1e-8, `ln m` 7e-16
//! and 3e-9, for `f64` and `f32`. `n ln 2` is rounded like the argument itself, so `exp(x)` has a relative error of
//! about `|x|` units of the last place beside: no more than the rounding of `x` means.

/// A precision in which [`FittedPoints`](crate::FittedPoints) evaluates its formulas: `f64` or `f32`.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + core::ops::Add<Output = Self>
    + core::ops::Sub<Output = Self>
    + core::ops::Mul<Output = Self>
    + core::ops::Div<Output = Self>
    + core::ops::Neg<Output = Self>
    + Send
    + Sync
    + core::fmt::Debug
    + 'static
{
    /// Interferences over their reference whose logarithm and reciprocal exist.
    const RANGE: [f64; 2];
    /// Largest argument of the exponential.
    const LARGEST_EXPONENT: f64;

    /// Nearest value.
    fn of(value: f64) -> Self;
    /// As double.
    fn double(self) -> f64;
    /// `self * factor + addend`, rounded once if `FMA`.
    fn times_plus<const FMA: bool>(self, factor: Self, addend: Self) -> Self;
    /// Magnitude.
    fn magnitude(self) -> Self;
    /// The magnitude of `self` with the sign of `sign`.
    fn with_sign(self, sign: Self) -> Self;
    /// `e^x`, of arguments so small that the result would be no normal number that of the smallest allowed one. The
    /// argument must not exceed [`Self::LARGEST_EXPONENT`].
    fn natural_exp<const FMA: bool>(self) -> Self;
    /// `x = 2^n m` with `m` between `sqrt(1/2)` and `sqrt(2)`: `(m, n)`, for positive normal `x`.
    fn split(self) -> (Self, Self);
    /// `ln(2^n m)` from `s = (m - 1)/(m + 1)`.
    fn ln_of<const FMA: bool>(s: Self, n: Self) -> Self;
}

#[inline(always)]
pub(crate) fn min<R: Real>(a: R, b: R) -> R {
    if a < b { a } else { b }
}

#[inline(always)]
pub(crate) fn max<R: Real>(a: R, b: R) -> R {
    if a > b { a } else { b }
}

/// `ln` of two positive normal numbers with one division.
#[inline(always)]
pub(crate) fn ln_pair<R: Real, const FMA: bool>(x: R, y: R) -> (R, R) {
    let one = R::of(1.0);
    let ((x, n_x), (y, n_y)) = (x.split(), y.split());
    let (above_x, above_y) = (x + one, y + one);
    let per_both = one / (above_x * above_y);
    (
        R::ln_of::<FMA>((x - one) * (above_y * per_both), n_x),
        R::ln_of::<FMA>((y - one) * (above_x * per_both), n_y),
    )
}

/// What both kinds of numbers do with the same words.
macro_rules! alike {
    () => {
        #[inline(always)]
        fn times_plus<const FMA: bool>(self, factor: Self, addend: Self) -> Self {
            #[cfg(feature = "std")]
            if FMA {
                return self.mul_add(factor, addend);
            }
            self * factor + addend
        }

        #[inline(always)]
        fn magnitude(self) -> Self {
            self.abs()
        }

        #[inline(always)]
        fn with_sign(self, sign: Self) -> Self {
            self.copysign(sign)
        }
    };
}

impl Real for f64 {
    const RANGE: [f64; 2] = [1e-150, 1e150];
    const LARGEST_EXPONENT: f64 = 700.0;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn double(self) -> f64 {
        self
    }

    alike!();

    #[inline(always)]
    fn natural_exp<const FMA: bool>(self) -> Self {
        // Adding 3/2 2^52 rounds to an integer and leaves it in the lowest bits.
        const SHIFT: f64 = 6_755_399_441_055_744.0;
        let x = max(self, -Self::LARGEST_EXPONENT as Self);
        let shifted = x.times_plus::<FMA>(core::f64::consts::LOG2_E, SHIFT);
        let r = (shifted - SHIFT).times_plus::<FMA>(-core::f64::consts::LN_2, x);
        // Neighbouring powers first, then pairs, then fours: a short chain of dependent operations.
        let r2 = r * r;
        let r4 = r2 * r2;
        let q_01 = r.times_plus::<FMA>(0.166_666_666_666_481_55, 0.5);
        let q_23 = r.times_plus::<FMA>(8.333_333_353_839_835e-3, 4.166_666_666_665_124e-2);
        let q_45 = r.times_plus::<FMA>(1.984_120_851_210_209_2e-4, 1.388_888_890_597_354_4e-3);
        let q_67 = r.times_plus::<FMA>(2.762_523_779_574_073_3e-6, 2.480_153_620_505_534e-5);
        let low = r2.times_plus::<FMA>(q_23, q_01);
        let high = r4.times_plus::<FMA>(2.761_390_867_578_485_6e-7, r2.times_plus::<FMA>(q_67, q_45));
        let above_one = r2.times_plus::<FMA>(r4.times_plus::<FMA>(high, low), r);
        let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
        above_one.times_plus::<FMA>(power, power)
    }

    #[inline(always)]
    fn split(self) -> (Self, Self) {
        const ROOT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
        const MANTISSA: u64 = (1 << 52) - 1;
        // 2^52 with the exponent of 1 in its lowest bits: an integer placed there is a float without a conversion.
        const SHIFT: u64 = 0x4330_0000_0000_0000;
        let bits = self.to_bits() + (1.0_f64.to_bits() - ROOT_HALF);
        let n = f64::from_bits((bits >> 52) | SHIFT) - (f64::from_bits(SHIFT) + 1023.0);
        (f64::from_bits((bits & MANTISSA) + ROOT_HALF), n)
    }

    #[inline(always)]
    fn ln_of<const FMA: bool>(s: Self, n: Self) -> Self {
        let z = s * s;
        let z2 = z * z;
        let p_01 = z.times_plus::<FMA>(0.400_000_000_113_208_7, 0.666_666_666_666_620_3);
        let p_23 = z.times_plus::<FMA>(0.222_228_662_247_483_64, 0.285_714_241_020_432_2);
        let p_45 = z.times_plus::<FMA>(0.166_244_174_447_655_2, 0.181_400_215_296_480_9);
        let p = z2.times_plus::<FMA>(z2.times_plus::<FMA>(p_45, p_23), p_01);
        n.times_plus::<FMA>(core::f64::consts::LN_2, s * z.times_plus::<FMA>(p, 2.0))
    }
}

impl Real for f32 {
    const RANGE: [f64; 2] = [1e-37, 1e37];
    const LARGEST_EXPONENT: f64 = 87.0;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value as Self
    }

    #[inline(always)]
    fn double(self) -> f64 {
        self.into()
    }

    alike!();

    #[inline(always)]
    fn natural_exp<const FMA: bool>(self) -> Self {
        const SHIFT: f32 = 12_582_912.0;
        let x = max(self, -Self::LARGEST_EXPONENT as Self);
        let shifted = x.times_plus::<FMA>(core::f32::consts::LOG2_E, SHIFT);
        let r = (shifted - SHIFT).times_plus::<FMA>(-core::f32::consts::LN_2, x);
        let r2 = r * r;
        let q_01 = r.times_plus::<FMA>(0.166_665_77, 0.5);
        let q_23 = r.times_plus::<FMA>(8.363_233e-3, 0.041_666_556);
        let q = (r2 * r2).times_plus::<FMA>(1.392_625_1e-3, r2.times_plus::<FMA>(q_23, q_01));
        let above_one = r2.times_plus::<FMA>(q, r);
        let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
        above_one.times_plus::<FMA>(power, power)
    }

    #[inline(always)]
    fn split(self) -> (Self, Self) {
        const ROOT_HALF: u32 = 0x3f35_04f3;
        const MANTISSA: u32 = (1 << 23) - 1;
        const SHIFT: u32 = 0x4b00_0000;
        let bits = self.to_bits() + (1.0_f32.to_bits() - ROOT_HALF);
        let n = f32::from_bits((bits >> 23) | SHIFT) - (f32::from_bits(SHIFT) + 127.0);
        (f32::from_bits((bits & MANTISSA) + ROOT_HALF), n)
    }

    #[inline(always)]
    fn ln_of<const FMA: bool>(s: Self, n: Self) -> Self {
        let z = s * s;
        let p = (z * z).times_plus::<FMA>(0.295_820_24, z.times_plus::<FMA>(0.399_887_35, 0.666_666_85));
        n.times_plus::<FMA>(core::f32::consts::LN_2, s * z.times_plus::<FMA>(p, 2.0))
    }
}
