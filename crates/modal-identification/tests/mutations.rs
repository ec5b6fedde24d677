//! Damaged files: whatever the bytes, every reader answers, memory stays within a multiple of the file's size, and what was
//! read is identified or refused.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use file_io::Source;
use modal_identification::backbone::{Settings, identify};
use modal_identification::readers::{self, Recording};
use modal_identification::signal::{Signal, Stated};
use test_support::memory::{self, Counting};
use test_support::{Damage, Sample, Tally};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn damaged_files_are_answered_within_bounds() {
    let rows = (0..40).map(|i| format!("{},{},{}\n", 0.001 * f64::from(i), i * i % 7, 3 - i));
    let csv: String = "# rig\ntime,a,b\ns,g,m/s^2\n"
        .chars()
        .chain(rows.collect::<String>().chars())
        .collect();
    // What a byte of the file may become (compressed files hold up to 1032 in one), and what may come on top: buffers for
    // text, unpacking and messages; matrices of MATLAB with starts for 2^20 rows.
    const PLAIN: usize = 64;
    const PACKED: usize = 64 * 1032;
    const LITTLE: usize = 1 << 15;
    const MATRICES: usize = 3 << 23;
    let files: Vec<(&str, Vec<u8>, usize, usize)> = [
        ("even_double.uff", PLAIN, LITTLE),
        ("uneven_double.uff", PLAIN, LITTLE),
        ("binary_double.uff", PLAIN, LITTLE),
        ("millimetres.uff", PLAIN, LITTLE),
        ("pcm8.wav", PLAIN, LITTLE),
        ("pcm16.wav", PLAIN, LITTLE),
        ("float.wav", PLAIN, LITTLE),
        ("named.mat", PACKED, MATRICES),
        ("named.npz", PACKED, MATRICES),
    ]
    .into_iter()
    .map(|(name, factor, base)| (name, fixture(name), factor, base))
    .chain([("csv", csv.into_bytes(), PLAIN, LITTLE)])
    .collect();
    let mut damage = Damage::new(7, &[b"    -1\n", b"    58b     1     2          11", b";"]);
    let settings = Settings {
        smoothing: 5,
        ..Settings::default()
    };
    for (name, sound, factor, base) in files {
        let sample = Sample {
            name,
            sound: &sound,
            memory: [factor, base],
            copies: 3000,
        };
        let read = |bytes: &[u8]| readers::parse(Source { name, bytes });
        let identified = |recording: Recording, _: &[u8]| {
            for channel in &recording.channels {
                if let Ok((signal, _)) = Signal::try_new(name, channel, &Stated::default()) {
                    let _ = identify(&signal, &settings);
                }
            }
        };
        let Tally { refused, accepted } = damage.trial(&sample, <[u8]>::to_vec, read, identified);
        // The damage is neither always fatal nor never.
        assert!(
            refused > 300 && accepted > 20,
            "{name}: {refused} refused, {accepted} read"
        );
    }
    // In the same test: the count is shared.
    rows_of_many_columns_take_memory_in_proportion();
}

fn rows_of_many_columns_take_memory_in_proportion() {
    for row in [
        ",".repeat(200_000),
        "a,".repeat(100_000),
        "1,".repeat(100_000) + "\n" + &"2,".repeat(100_000),
    ] {
        let source = Source {
            name: "wide.csv",
            bytes: row.as_bytes(),
        };
        let (read, used) = memory::peak(|| readers::parse(source));
        assert!(read.is_err());
        assert!(used <= 64 * row.len(), "{} bytes of memory per byte", used / row.len());
    }
}
