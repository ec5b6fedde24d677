//! Grids and points: `cargo +nightly fuzz run text`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use surface_characterisation::readers::{Format, LengthUnit, Options, Source, text};

fuzz_target!(|bytes: &[u8]| {
    let source = Source { name: "fuzzed", bytes };
    let stated = Options {
        accept_implausible: true,
        ..Options::default()
    };
    let points = Options {
        lateral_unit: Some(LengthUnit::Micrometre),
        height_unit: Some(LengthUnit::Nanometre),
        ..stated.clone()
    };
    let grid = Options {
        format: Some(Format::Grid),
        lateral_step: Some([1.0, 2.0]),
        ..points.clone()
    };
    for options in [&stated, &points, &grid] {
        let _ = text::parse(source, options);
    }
});
