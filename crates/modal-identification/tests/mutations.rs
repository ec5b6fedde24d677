//! Damaged files: whatever the bytes, every reader answers, memory stays within a multiple of the file's size, and what was
//! read is identified or refused.
#![allow(unsafe_code, clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use matrix_files::Source;
use modal_identification::backbone::{Settings, identify};
use modal_identification::readers;
use modal_identification::signal::{Signal, Stated};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The system's allocator with a count of the bytes in use.
struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: the system's allocator does the work.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let in_use = IN_USE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(in_use, Ordering::Relaxed);
        // SAFETY: passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: passed on.
        unsafe { System.dealloc(block, layout) }
    }
}

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
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for (name, sound, factor, base) in files {
        assert!(readers::parse(Source { name, bytes: &sound }).is_ok(), "{name}");
        let (mut refused, mut accepted) = (0, 0);
        for _ in 0..3000 {
            let mut bytes = sound.clone();
            for _ in 0..random.random_range(1..4) {
                damage(&mut bytes, &mut random);
            }
            let before = IN_USE.load(Ordering::Relaxed);
            PEAK.store(before, Ordering::Relaxed);
            let read = readers::parse(Source { name, bytes: &bytes });
            let used = PEAK.load(Ordering::Relaxed) - before;
            assert!(
                used <= factor * bytes.len() + base,
                "{name}: {used} bytes for a file of {}",
                bytes.len()
            );
            match read {
                Err(_) => refused += 1,
                Ok(recording) => {
                    accepted += 1;
                    for channel in &recording.channels {
                        if let Ok((signal, _)) = Signal::try_new(name, channel, &Stated::default()) {
                            let settings = Settings {
                                smoothing: 5,
                                ..Settings::default()
                            };
                            let _ = identify(&signal, &settings);
                        }
                    }
                }
            }
        }
        // The damage is neither always fatal nor never.
        assert!(
            refused > 300 && accepted > 20,
            "{name}: {refused} refused, {accepted} read"
        );
    }
    // In the same test: the count is shared.
    rows_of_many_columns_take_memory_in_proportion();
}

/// Changes, removes or adds a few bytes.
fn damage(bytes: &mut Vec<u8>, random: &mut impl Rng) {
    const FRAGMENTS: [&[u8]; 8] = [
        b"    -1\n",
        b"    58b     1     2          11",
        b";",
        b"nan",
        b"1e999",
        b"\xff\xff\xff\x7f",
        &[0; 8],
        b"\n",
    ];
    let at = random.random_range(0..=bytes.len());
    match random.random_range(0..7) {
        0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
        1 if at < bytes.len() => bytes[at] = random.random(),
        2 => bytes.truncate(at),
        3 => {
            let end = (at + random.random_range(1..20)).min(bytes.len());
            bytes.drain(at..end);
        }
        4 => {
            let fragment = FRAGMENTS[random.random_range(0..FRAGMENTS.len())];
            let end = (at + random.random_range(0..=fragment.len())).min(bytes.len());
            bytes.splice(at..end, fragment.iter().copied());
        }
        // Another number, in digits or in four bytes.
        5 => {
            let digit = |i: &usize| bytes[*i].is_ascii_digit();
            let from = (at..bytes.len()).find(digit).unwrap_or(bytes.len());
            let end = (from..bytes.len()).find(|i| !digit(i)).unwrap_or(bytes.len());
            let number = [0, 2, 7, 400, 70_000, 1_000_000_000_u64][random.random_range(0..6)];
            bytes.splice(from..end, number.to_string().into_bytes());
        }
        _ => {
            let from = at / 4 * 4;
            let end = (from + 4).min(bytes.len());
            let number = [0, 2, 7, 400, 70_000, 1_000_000_000, -1_i32][random.random_range(0..7)];
            bytes.splice(from..end, number.to_le_bytes());
        }
    }
}

fn rows_of_many_columns_take_memory_in_proportion() {
    for row in [
        ",".repeat(200_000),
        "a,".repeat(100_000),
        "1,".repeat(100_000) + "\n" + &"2,".repeat(100_000),
    ] {
        let before = IN_USE.load(Ordering::Relaxed);
        PEAK.store(before, Ordering::Relaxed);
        let read = readers::parse(Source {
            name: "wide.csv",
            bytes: row.as_bytes(),
        });
        let used = PEAK.load(Ordering::Relaxed) - before;
        assert!(read.is_err());
        assert!(used <= 64 * row.len(), "{} bytes of memory per byte", used / row.len());
    }
}
