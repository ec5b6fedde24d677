//! `cargo +nightly fuzz run sdf`, with the files of `tests/scans` as seeds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use surface_characterisation::readers::{Options, Source, sdf};

fuzz_target!(|bytes: &[u8]| {
    let options = Options {
        accept_implausible: true,
        ..Options::default()
    };
    let _ = sdf::parse(Source { name: "fuzzed", bytes }, &options);
});
