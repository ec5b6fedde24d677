//! Files that other programs wrote (`fixtures/make_fixtures.py`), and what SciPy says of filter and smoothing.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use modal_identification::filter::BandPass;
use modal_identification::readers::{self, Recording};
use modal_identification::signal::{Quantity, Signal, Stated, Timing};
use modal_identification::smoothing::SavitzkyGolay;

fn fixture(name: &str) -> Recording {
    let path = format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
    readers::read(path.as_ref()).unwrap()
}

/// What all fixtures hold, in eighths.
fn counts() -> Vec<f64> {
    (0..40).map(|k| f64::from((7 * k * k + 3 * k) % 41 - 20)).collect()
}

fn scaled(factor: f64) -> Vec<f64> {
    counts().iter().map(|c| c * factor).collect()
}

#[test]
fn universal_files() {
    for name in [
        "even_double.uff",
        "even_single.uff",
        "uneven_single.uff",
        "uneven_double.uff",
        "binary_double.uff",
        "millimetres.uff",
    ] {
        let recording = fixture(name);
        let [channel] = &recording.channels[..] else {
            panic!("{name}: {:?}", recording.channels)
        };
        assert_eq!(channel.name, "hammer side 12:-Z", "{name}");
        assert_eq!(channel.samples, scaled(0.125), "{name}");
        assert!(recording.skipped.is_empty());
        match &channel.timing {
            Timing::Rate(rate) => assert!((rate / 2048.0 - 1.0).abs() < 1e-5, "{name}: {rate}"),
            Timing::Times(times) => {
                assert!(name.starts_with("uneven") && times.len() == 40);
                assert!((times[39] - 39.0 / 2048.0).abs() < 1e-7, "{name}");
            }
            Timing::Unstated => panic!("{name}"),
        }
        let (signal, _) = Signal::try_new(name, channel, &Stated::default()).unwrap();
        let size = if name == "millimetres.uff" { 1e-3 } else { 1.0 };
        assert_eq!(
            (signal.quantity, signal.samples),
            (Quantity::Acceleration, scaled(0.125 * size))
        );
    }
    let two = fixture("two_hits.uff");
    let (hits, warnings) = two.select(None).unwrap();
    assert_eq!((hits.len(), warnings.len()), (2, 0));
    assert_eq!(hits[0], hits[1]);
}

#[test]
fn sound_files() {
    for name in ["pcm8.wav", "pcm16.wav", "pcm32.wav", "float.wav"] {
        let recording = fixture(name);
        assert_eq!(recording.channels.len(), 2);
        assert_eq!(recording.channels[0].samples, scaled(1.0 / 128.0), "{name}");
        assert_eq!(recording.channels[1].samples, scaled(-1.0 / 128.0), "{name}");
        assert_eq!(recording.channels[1].timing, Timing::Rate(2048.0));
        assert_eq!(recording.channels[1].unit, None);
    }
}

#[test]
fn arrays_by_name() {
    let matlab = fixture("named.mat");
    let channel = |name: &str| matlab.channels.iter().find(|c| c.name == name).unwrap();
    let acc = channel("run.acc");
    assert_eq!((acc.samples.clone(), acc.unit.as_deref()), (scaled(0.125), Some("g")));
    assert!(matches!(&acc.timing, Timing::Times(times) if times[39] == 39.0 / 2048.0));
    let second = channel("pair:2");
    assert_eq!(
        (second.samples.clone(), second.unit.as_deref()),
        (scaled(-0.125), Some("mm/s"))
    );
    assert_eq!(second.timing, Timing::Rate(2048.0));
    assert_eq!(matlab.channels.len(), 3);
    assert_eq!(matlab.skipped.len(), 1, "gain: {:?}", matlab.skipped);

    let numpy = fixture("named.npz");
    assert_eq!(numpy.channels.len(), 2);
    assert_eq!(numpy.channels[1].samples, scaled(0.25));
    assert_eq!(numpy.channels[1].unit.as_deref(), Some("um"));
    assert_eq!(numpy.channels[1].timing, Timing::Rate(2048.0));
}

#[test]
fn poles_and_smoothing_are_those_of_scipy() {
    let filter = BandPass::try_new(170.0, 190.0, 7200.0).unwrap();
    for [re, im] in [
        [0.9791313263168567, 0.1580203211477649],
        [0.9804992254686985, 0.1515282276240556],
        [0.9829508391409931, 0.16374746615838046],
        [0.9857986181507795, 0.14792711101516684],
    ] {
        let near = |p: f64, q: f64| (p - q).abs() < 1e-12;
        let found = filter.poles().iter().any(|p| near(p.re, re) && near(p.im.abs(), im));
        assert!(found, "{re} + {im}i is not among {:?}", filter.poles());
    }
    let values: Vec<f64> = (0..25).map(|i| f64::from(i * i % 17)).collect();
    let smoothed = SavitzkyGolay::try_new(21).unwrap().smooth(&values);
    for (i, expected) in [(0, -1.8158291), (5, 11.1927381), (12, 8.16672115), (24, 12.72181442)] {
        assert!((smoothed[i] - expected).abs() < 1e-7, "{i}: {} {expected}", smoothed[i]);
    }
}
