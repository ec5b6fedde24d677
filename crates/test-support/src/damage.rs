//! Damaged files.

use std::fmt::Display;

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::memory;

/// Pieces that trouble readers of any format.
const FRAGMENTS: [&[u8]; 6] = [b"-1", b"nan", b"1e999", b"\xff\xff\xff\x7f", &[0; 8], b"\n"];

/// Bytes that numbers and tables in text consist of.
const CHARACTERS: &[u8] = b"0123456789.,;*+-\n eED";

/// Numbers that counts and indices may become.
const NUMBERS: [i64; 7] = [0, 2, 7, 400, 70_000, 1_000_000_000, -1];

/// Damages files at random, the same way for the same seed.
pub struct Damage {
    random: Pcg64Mcg,
    fragments: Vec<&'static [u8]>,
}

/// A sound file, what reading it may cost, and how often it is damaged.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Name, for messages.
    pub name: &'a str,
    /// The bytes to be damaged.
    pub sound: &'a [u8],
    /// Bytes of memory that reading may take per byte of the file, and on top.
    pub memory: [usize; 2],
    /// Number of damaged copies, unless the environment variable `DAMAGED_COPIES` has another.
    pub copies: usize,
}

/// How many damaged copies were refused and read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Refused.
    pub refused: usize,
    /// Read all the same.
    pub accepted: usize,
}

impl Damage {
    /// `fragments` are pieces of the format, which the damage throws in beside those that trouble every reader.
    pub fn new(seed: u64, fragments: &[&'static [u8]]) -> Self {
        Self {
            random: Pcg64Mcg::seed_from_u64(seed),
            fragments: FRAGMENTS.iter().chain(fragments).copied().collect(),
        }
    }

    /// A copy with one to three changes.
    pub fn of(&mut self, sound: &[u8]) -> Vec<u8> {
        let mut bytes = sound.to_vec();
        for _ in 0..self.random.random_range(1..4) {
            change(&mut bytes, &self.fragments, &mut self.random);
        }
        bytes
    }

    /// Reads damaged copies of a sample, whole files made of them by `packed`, and hands what was read to `accept`.
    ///
    /// # Panics
    /// If `DAMAGED_COPIES` is no number, the sound file is refused, a refusal has no message, or reading takes more memory than the sample allows. The test
    /// must have installed [`memory::Counting`].
    pub fn trial<T, E: Display>(
        &mut self,
        sample: &Sample<'_>,
        packed: impl Fn(&[u8]) -> Vec<u8>,
        read: impl Fn(&[u8]) -> Result<T, E>,
        mut accept: impl FnMut(T, &[u8]),
    ) -> Tally {
        let name = sample.name;
        if let Err(error) = read(&packed(sample.sound)) {
            panic!("{name}: the sound file is refused: {error}");
        }
        let asked = std::env::var("DAMAGED_COPIES");
        let number = |count: String| count.parse().unwrap_or_else(|_| panic!("DAMAGED_COPIES={count}"));
        let mut tally = Tally::default();
        for _ in 0..asked.map_or(sample.copies, number) {
            let bytes = packed(&self.of(sample.sound));
            let (answer, used) = memory::peak(|| read(&bytes));
            let [per_byte, base] = sample.memory;
            assert!(
                used <= per_byte * bytes.len() + base,
                "{name}: {used} bytes for a file of {}",
                bytes.len()
            );
            match answer {
                Ok(contents) => {
                    tally.accepted += 1;
                    accept(contents, &bytes);
                }
                Err(error) => {
                    tally.refused += 1;
                    assert!(!error.to_string().is_empty(), "{name}");
                }
            }
        }
        tally
    }
}

/// Changes, removes or adds a few bytes.
fn change(bytes: &mut Vec<u8>, fragments: &[&[u8]], random: &mut impl Rng) {
    let at = random.random_range(0..=bytes.len());
    let length = bytes.len();
    let up_to = |count: usize| (at + count).min(length);
    match random.random_range(0..10) {
        0 if at < length => bytes[at] ^= 1 << random.random_range(0..8),
        1 if at < length => bytes[at] = random.random(),
        2 if at < length => bytes[at] = CHARACTERS[random.random_range(0..CHARACTERS.len())],
        3 => bytes.truncate(at),
        4 => drop(bytes.drain(at..up_to(random.random_range(1..20)))),
        5 => {
            let fragment = fragments[random.random_range(0..fragments.len())];
            let end = up_to(random.random_range(0..=fragment.len()));
            bytes.splice(at..end, fragment.iter().copied());
        }
        // Another number, in digits or in four bytes.
        6 => {
            let digit = |i: &usize| bytes[*i].is_ascii_digit();
            let from = (at..length).find(digit).unwrap_or(length);
            let end = (from..length).find(|i| !digit(i)).unwrap_or(length);
            let number = NUMBERS[random.random_range(0..NUMBERS.len())];
            bytes.splice(from..end, number.to_string().into_bytes());
        }
        7 => {
            let from = at / 2 * 2;
            let number = NUMBERS[random.random_range(0..NUMBERS.len())] as i32;
            bytes.splice(from..(from + 4).min(length), number.to_le_bytes());
        }
        // A line at the beginning of another.
        8 => {
            let start = |at: usize| bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |p| p + 1);
            let from = start(random.random_range(0..=length));
            let line = bytes[from..].split_inclusive(|b| *b == b'\n').next();
            let line = line.unwrap_or_default().to_vec();
            bytes.splice(start(at)..start(at), line);
        }
        _ => {
            let copied = bytes[at..up_to(random.random_range(1..40))].to_vec();
            let to = random.random_range(0..=length);
            bytes.splice(to..to, copied);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damage_belongs_to_its_seed() {
        let sound = b"1 2 3\n4 5 6\n";
        let copies = |seed| {
            let mut damage = Damage::new(seed, &[b"*"]);
            (0..500).map(|_| damage.of(sound)).collect::<Vec<_>>()
        };
        assert_eq!(copies(1), copies(1));
        assert_ne!(copies(1), copies(2));
        let changed = copies(1).iter().filter(|bytes| *bytes != sound).count();
        assert!(changed > 450, "{changed}");
        assert!(Damage::new(3, &[]).of(b"").len() < 1000);
    }
}
