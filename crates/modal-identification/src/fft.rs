//! Discrete Fourier transforms of sizes that are powers of two.

use std::sync::Arc;

use rustfft::algorithm::Radix4;
use rustfft::algorithm::butterflies::Butterfly8;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftDirection};

/// Transforms as many values as a power of two says, in place and without a factor.
///
/// The algorithm is that of the library's planner for such sizes. The planner itself would bring the code for all other
/// sizes, which takes longer to compile than the rest of this crate.
pub(crate) fn transform(values: &mut [Complex64], direction: FftDirection) {
    let size = values.len();
    let exponent = size.trailing_zeros();
    let algorithm = if exponent > 5 && exponent % 2 == 1 {
        Radix4::new_with_base((exponent - 3) / 2, Arc::new(Butterfly8::new(direction)))
    } else {
        Radix4::new(size, direction)
    };
    algorithm.process(values);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bits_are_those_of_the_planner() {
        for exponent in 0..14 {
            let value = |i: u32| Complex64::new(f64::from(i * i % 31), f64::from(i % 7) - 3.5);
            let values: Vec<Complex64> = (0..1 << exponent).map(value).collect();
            for direction in [FftDirection::Forward, FftDirection::Inverse] {
                let (mut found, mut expected) = (values.clone(), values.clone());
                transform(&mut found, direction);
                rustfft::FftPlanner::new()
                    .plan_fft(values.len(), direction)
                    .process(&mut expected);
                assert_eq!(found, expected, "2^{exponent}");
            }
        }
    }
}
