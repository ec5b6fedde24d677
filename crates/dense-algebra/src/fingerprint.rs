//! What distinguishes the arithmetic of one processor and build from that of another.

use crate::{Symmetric, product, scattered};
use std::sync::OnceLock;

/// Rows and columns of the products: more than the smallest kernels take.
const SIZE: usize = 48;

/// Terms of each sum: beyond the block that any cache size leads to, because sums are cut there.
const TERMS: usize = 4096;

/// Hash of what the kernels of this process make of fixed numbers: products of matrices, the symmetric product and
/// elementary functions.
///
/// The kernels choose instructions and block sizes by what they find out about the processor, and elementary functions
/// come from the system's library. All of that moves the last bits of results, and no list of processor features says it.
/// Where fingerprints are equal, results of the same program are expected to be equal bit by bit.
pub fn arithmetic_fingerprint() -> &'static str {
    static FINGERPRINT: OnceLock<String> = OnceLock::new();
    FINGERPRINT.get_or_init(|| format!("{:016x}", fold(&probe())))
}

fn probe() -> Vec<f64> {
    let (left, right) = (scattered(SIZE, TERMS), scattered(TERMS, SIZE));
    let square = product(left.as_ref(), right.as_ref());
    let mut found: Vec<f64> = square.col_iter().flat_map(|column| column.iter().copied()).collect();
    let arguments = found[..SIZE].to_vec();
    let mut moved = vec![0.0; SIZE];
    Symmetric::from_lower(square.as_ref()).product_into(&arguments, &mut moved);
    found.extend(moved);
    for x in arguments {
        found.extend([x.exp(), x.abs().ln(), x.abs().powf(1.7), x.sin(), x.tanh(), x.exp_m1()]);
    }
    found
}

/// FNV-1a over the bits.
fn fold(values: &[f64]) -> u64 {
    let bytes = values.iter().flat_map(|value| value.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fingerprint_is_the_same_each_time_and_feels_the_last_bit() {
        let found = probe();
        assert_eq!(found, probe());
        let mut changed = found.clone();
        let last = changed.last_mut().unwrap();
        *last = f64::from_bits(last.to_bits() ^ 1);
        assert_ne!(fold(&found), fold(&changed));
    }

    /// Summed in two parts, as another size of the cache would have it; at a place where no kernel cuts by itself.
    #[test]
    fn the_fingerprint_feels_where_sums_are_cut() {
        let (left, right) = (scattered(SIZE, TERMS), scattered(TERMS, SIZE));
        let whole = product(left.as_ref(), right.as_ref());
        let (first, rest) = (1001, TERMS - 1001);
        let mut sum = product(left.subcols(0, first), right.subrows(0, first));
        let remaining = [left.subcols(first, rest), right.subrows(first, rest)];
        crate::add_product(sum.as_mut(), remaining[0], remaining[1], 1.0);
        let numbers = |a: &faer::Mat<f64>| a.col_iter().flat_map(|c| c.iter().copied()).collect::<Vec<f64>>();
        assert_ne!(fold(&numbers(&whole)), fold(&numbers(&sum)));
    }
}
