//! Arrays and archives: `cargo +nightly fuzz run numpy`, with the files of `tests/scans` as seeds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use surface_characterisation::readers::{LengthUnit, Options, Source, numpy};

fuzz_target!(|bytes: &[u8]| {
    let options = Options {
        lateral_unit: Some(LengthUnit::Micrometre),
        height_unit: Some(LengthUnit::Nanometre),
        lateral_step: Some([1.0, 2.0]),
        accept_implausible: true,
        ..Options::default()
    };
    let _ = numpy::parse(Source { name: "fuzzed", bytes }, &options);
});
