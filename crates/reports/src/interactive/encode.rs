//! Arrays of numbers as text.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::io::Write;

/// Steps between the smallest and the largest value of a quantised sequence.
const STEPS: f64 = 4095.0;

/// Bytes as base64.
pub(super) fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Numbers in single precision, little-endian, as base64.
pub(super) fn singles(values: impl IntoIterator<Item = f64>) -> String {
    let bytes: Vec<u8> = values.into_iter().flat_map(|v| (v as f32).to_le_bytes()).collect();
    base64(&bytes)
}

/// Whole numbers of four bytes, little-endian, as base64.
pub(super) fn integers(values: impl IntoIterator<Item = u32>) -> String {
    let bytes: Vec<u8> = values.into_iter().flat_map(u32::to_le_bytes).collect();
    base64(&bytes)
}

/// Whole numbers of two bytes, little-endian, as base64.
pub(super) fn shorts(values: impl IntoIterator<Item = i16>) -> String {
    let bytes: Vec<u8> = values.into_iter().flat_map(i16::to_le_bytes).collect();
    base64(&bytes)
}

/// Sequences of one length, each in 4096 steps between its own smallest and largest value.
///
/// The bytes are, compressed (raw deflate) and as base64: the low bytes, then the high bytes, of the differences between neighbours in a
/// sequence, the sign in the lowest bit. Smooth sequences have high bytes of zero, which take no room.
#[derive(Debug, Default)]
pub(super) struct Sequences {
    /// Smallest and largest value of each sequence.
    pub(super) ranges: Vec<f64>,
    differences: Vec<u16>,
}

impl Sequences {
    /// Adds a sequence of finite numbers; others count as zero.
    pub(super) fn add(&mut self, values: impl Iterator<Item = f64> + Clone) {
        let finite = values.map(|v| if v.is_finite() { v } else { 0.0 });
        let low = finite.clone().fold(f64::INFINITY, f64::min);
        let high = finite.clone().fold(f64::NEG_INFINITY, f64::max);
        self.ranges.extend([low, high]);
        let scale = if high > low { STEPS / (high - low) } else { 0.0 };
        let mut before = 0_i32;
        for value in finite {
            let step = ((value - low) * scale).round() as i32;
            let difference = step - before;
            before = step;
            self.differences.push(((difference << 1) ^ (difference >> 31)) as u16);
        }
    }

    /// The compressed text.
    pub(super) fn text(&self) -> String {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        let bytes = self.differences.iter().map(|d| d.to_le_bytes());
        let (low, high): (Vec<u8>, Vec<u8>) = bytes.map(|[low, high]| (low, high)).unzip();
        // Writing to memory cannot fail.
        let written = encoder.write_all(&low).and_then(|()| encoder.write_all(&high));
        base64(&written.and_then(|()| encoder.finish()).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn arrays_are_little_endian() {
        assert_eq!(singles([1.0]), "AACAPw==");
        assert_eq!(integers([1, 256]), "AQAAAAABAAA=");
        assert_eq!(shorts([-2]), "/v8=");
    }

    #[test]
    fn sequences_come_back_within_half_a_step() {
        let wave: Vec<f64> = (0..65).map(|i| 3.0 + (0.1 * f64::from(i)).sin()).collect();
        let constant = vec![-2.0; 65];
        let mut sequences = Sequences::default();
        sequences.add(wave.iter().copied());
        sequences.add(constant.iter().copied());
        let compressed = STANDARD.decode(sequences.text()).unwrap();
        let mut bytes = Vec::new();
        flate2::read::DeflateDecoder::new(&compressed[..])
            .read_to_end(&mut bytes)
            .unwrap();
        assert_eq!(bytes.len(), 2 * 130);
        for (number, expected) in [wave, constant].iter().enumerate() {
            let [low, high] = [sequences.ranges[2 * number], sequences.ranges[2 * number + 1]];
            let mut step = 0_i32;
            for (i, value) in expected.iter().enumerate() {
                let at = 65 * number + i;
                let coded = u16::from_le_bytes([bytes[at], bytes[130 + at]]);
                step += i32::from(coded >> 1) ^ -i32::from(coded & 1);
                let found = low + f64::from(step) * (high - low) / STEPS;
                assert!(
                    (found - value).abs() <= 0.5001 * (high - low) / STEPS,
                    "{found} instead of {value}"
                );
            }
        }
    }
}
