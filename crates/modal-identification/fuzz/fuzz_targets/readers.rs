//! All readers on the same bytes, and identification of what they find: `cargo +nightly fuzz run readers`, with the files of
//! `tests/fixtures` as seeds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use file_io::Source;
use modal_identification::backbone::{Settings, identify};
use modal_identification::readers::{self, csv, named, uff, wav};
use modal_identification::signal::{Signal, Stated};

fuzz_target!(|bytes: &[u8]| {
    let source = Source { name: "fuzzed", bytes };
    let readers = [readers::parse, csv::parse, named::parse_matlab, named::parse_numpy, uff::parse, wav::parse];
    for read in readers {
        let Ok(recording) = read(source) else {
            continue;
        };
        for channel in &recording.channels {
            if let Ok((signal, _)) = Signal::try_new("fuzzed", channel, &Stated::default()) {
                let _ = identify(&signal, &Settings::default());
            }
        }
    }
});
