//! `cargo +nightly fuzz run x3p`, with the files of `tests/scans` as seeds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use surface_characterisation::readers::{Options, Source, x3p};

fuzz_target!(|bytes: &[u8]| {
    let options = Options {
        accept_implausible: true,
        ..Options::default()
    };
    let _ = x3p::parse(Source { name: "fuzzed", bytes }, &options);
});
