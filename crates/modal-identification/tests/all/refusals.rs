//! Signals and files that are not sound.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use file_io::Source;
use modal_identification::readers::{self, Recording};
use modal_identification::signal::{Channel, Quantity, Signal, Stated, Timing, Unit};
use modal_identification::{Error, Warning};

fn wave() -> Vec<f64> {
    (0..200).map(|i| (0.3 * f64::from(i)).sin()).collect()
}

fn channel(samples: Vec<f64>, timing: Timing) -> Channel {
    Channel {
        name: "acc".into(),
        unit: Some("m/s^2".into()),
        timing,
        samples,
    }
}

fn refused(channel: &Channel) -> Error {
    let error = Signal::try_new("run.csv", channel, &Stated::default()).unwrap_err();
    assert!(error.to_string().contains("run.csv, channel `acc`"), "{error}");
    error
}

#[test]
fn samples_that_are_no_signal() {
    let rate = Timing::Rate(1000.0);
    for short in [vec![], vec![1.0]] {
        assert!(matches!(refused(&channel(short, rate.clone())), Error::TooShort { .. }));
    }
    for value in [0.0, 3.5] {
        assert!(matches!(
            refused(&channel(vec![value; 50], rate.clone())),
            Error::Constant { .. }
        ));
    }
    for value in [f64::NAN, f64::INFINITY] {
        let mut samples = wave();
        samples[20] = value;
        assert!(matches!(
            refused(&channel(samples, rate.clone())),
            Error::NotFinite { sample: 21, .. }
        ));
    }
    for rate in [0.0, -5.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            refused(&channel(wave(), Timing::Rate(rate))),
            Error::BadSampleRate { .. }
        ));
    }
    assert!(matches!(
        refused(&channel(wave(), Timing::Unstated)),
        Error::NoSampleRate { .. }
    ));
}

#[test]
fn times_that_are_not_uniform() {
    let times =
        |change: &dyn Fn(usize) -> f64| Timing::Times((0..200).map(|i| 1e-3 * (i as f64 + change(i))).collect());
    let gap = channel(wave(), times(&|i| if i > 80 { 3.0 } else { 0.0 }));
    assert!(matches!(refused(&gap), Error::Gap { sample: 81, missing, .. } if (missing - 3.0).abs() < 1e-9));
    let back = channel(wave(), times(&|i| if i == 50 { -2.0 } else { 0.0 }));
    assert!(matches!(refused(&back), Error::TimeNotAscending { sample: 51, .. }));
    let drift = channel(wave(), times(&|i| 1e-4 * (i * i) as f64));
    assert!(matches!(refused(&drift), Error::NonUniformTime { .. }));
    let missing = channel(wave(), times(&|i| if i == 7 { f64::NAN } else { 0.0 }));
    assert!(matches!(refused(&missing), Error::NotFinite { sample: 8, .. }));
    let rounded = channel(wave(), times(&|i| 0.02 * (i % 2) as f64));
    let (signal, warnings) = Signal::try_new("", &rounded, &Stated::default()).unwrap();
    assert!(matches!(warnings[..], [Warning::Jitter { .. }]), "{warnings:?}");
    assert!((signal.sample_rate - 1000.0).abs() < 0.2);
}

#[test]
fn flaws_that_are_reported() {
    let rate = Timing::Rate(1000.0);
    let clipped = wave().iter().map(|v| v.clamp(-2.0, 0.9)).collect();
    let (signal, warnings) = Signal::try_new("", &channel(clipped, rate.clone()), &Stated::default()).unwrap();
    assert!(
        matches!(warnings[..], [Warning::Clipped { .. }]) && signal.last_clipped.is_some(),
        "{warnings:?}"
    );
    // A converter with few steps is not clipped by being flat at the top.
    let coarse = (0..4000)
        .map(|i| (100.0 * (0.02 * f64::from(i)).sin()).round())
        .collect();
    let (_, warnings) = Signal::try_new("", &channel(coarse, rate.clone()), &Stated::default()).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let mut still = wave();
    still[60..90].fill(0.25);
    let (_, warnings) = Signal::try_new("", &channel(still, rate), &Stated::default()).unwrap();
    assert!(
        matches!(warnings[..], [Warning::Dropout { samples: 30, .. }]),
        "{warnings:?}"
    );
}

#[test]
fn units() {
    for (text, quantity, scale) in [
        ("m/s^2", Quantity::Acceleration, 1.0),
        ("M/S2", Quantity::Acceleration, 1.0),
        ("mm/s²", Quantity::Acceleration, 1e-3),
        ("in/s/s", Quantity::Acceleration, 0.0254),
        ("g", Quantity::Acceleration, 9.80665),
        ("0.5 g", Quantity::Acceleration, 0.5 * 9.80665),
        ("mm / s", Quantity::Velocity, 1e-3),
        ("µm", Quantity::Displacement, 1e-6),
        ("mil", Quantity::Displacement, 2.54e-5),
    ] {
        // A factor is parted from its unit by a blank, so `mm / s` is none.
        match text.parse::<Unit>() {
            Ok(unit) => {
                assert_eq!(unit.quantity, quantity, "{text}");
                assert!((unit.scale / scale - 1.0).abs() < 1e-15, "{text}");
            }
            Err(error) => assert_eq!(text, "mm / s", "{error}"),
        }
    }
    for text in [
        "", "V", "m/", "m/s^3", "/s", "g/s", "-1 m", "0 m", "nan m", "1e999 m", "1", "m s",
    ] {
        assert!(matches!(text.parse::<Unit>(), Err(Error::UnknownUnit { .. })), "{text}");
    }
}

#[test]
fn what_is_stated_must_agree_with_the_file() {
    let stated = |unit: Option<&str>, sample_rate| Stated {
        unit: unit.map(Into::into),
        sample_rate,
    };
    let known = channel(wave(), Timing::Rate(1000.0));
    let volts = Channel {
        unit: Some("V".into()),
        ..known.clone()
    };
    let none = Channel {
        unit: None,
        timing: Timing::Unstated,
        ..known.clone()
    };
    let refuse = |channel, stated| Signal::try_new("run.mat", channel, &stated).unwrap_err();
    assert!(matches!(
        refuse(&known, stated(Some("g"), None)),
        Error::ConflictingUnit { .. }
    ));
    assert!(matches!(
        refuse(&known, stated(Some("furlong"), None)),
        Error::UnknownUnit { .. }
    ));
    assert!(matches!(
        refuse(&known, stated(None, Some(1001.0))),
        Error::ConflictingSampleRate { .. }
    ));
    assert!(matches!(refuse(&volts, stated(None, None)), Error::UnknownUnit { .. }));
    assert!(matches!(
        refuse(&none, stated(None, Some(1000.0))),
        Error::NoUnit { .. }
    ));
    assert!(matches!(
        refuse(&none, stated(Some("m"), None)),
        Error::NoSampleRate { .. }
    ));
    let (signal, _) = Signal::try_new("", &volts, &stated(Some("100 m/s^2"), Some(1000.01))).unwrap();
    assert_eq!((signal.sample_rate, signal.samples[1]), (1000.01, 100.0 * wave()[1]));
}

fn parse(text: &str) -> Result<Recording, Error> {
    readers::parse(Source {
        name: "run.csv",
        bytes: text.as_bytes(),
    })
}

#[test]
fn columns_of_text() {
    let plain = parse("1,2\n3,4\n").unwrap();
    assert_eq!(plain.channels[1].name, "2");
    assert_eq!(plain.channels[1].samples, [2.0, 4.0]);
    let full = parse("# rig 3\ntime [ms],a [g],\"b, side\"\n0,1,2\n0.5,3,\n").unwrap();
    assert_eq!(full.channels[0].timing, Timing::Times(vec![0.0, 0.0005]));
    assert_eq!(
        (full.channels[0].unit.as_deref(), full.channels[1].name.as_str()),
        (Some("g"), "b, side")
    );
    assert!(full.channels[1].samples[1].is_nan());
    let german = parse("\u{feff}t;a;\ns;m/s^2;\n0,0;-1,5;\n0,1;2e-3;\n").unwrap();
    assert_eq!(german.channels.len(), 1);
    assert_eq!(
        (german.channels[0].samples.clone(), german.channels[0].unit.as_deref()),
        (vec![-1.5, 0.002], Some("m/s^2"))
    );
    for (text, line) in [
        ("a,b\n1,2\n3\n", 3),
        ("a\n1\nx\n", 3),
        ("a,b\n1,2,3\n", 2),
        ("1,2\n3,x\n", 2),
    ] {
        let message = parse(text).unwrap_err().to_string();
        assert!(
            message.contains(&format!("line {line}:")) && message.contains("run.csv"),
            "{text:?}: {message}"
        );
    }
    assert!(parse("time [h],a\n0,1\n1,2\n").is_err());
}

#[test]
fn channels_are_chosen_by_name() {
    let recording = parse("time,a,b,c\n0,1,2,0\n1,2,3,0\n").unwrap();
    let message = recording.select(None).unwrap_err().to_string();
    assert!(message.contains("`a`, `b`, `c`"), "{message}");
    assert!(matches!(recording.select(Some("d")), Err(Error::UnknownChannel { .. })));
    let (chosen, warnings) = recording.select(Some("b")).unwrap();
    assert_eq!((chosen.len(), chosen[0].name.as_str()), (1, "b"));
    assert_eq!(warnings, [Warning::ConstantChannel { name: "c".into() }]);
    for empty in ["", "\n\n", "time\n0\n1\n"] {
        assert!(
            matches!(parse(empty).unwrap().select(None), Err(Error::NoChannels { .. })),
            "{empty:?}"
        );
    }
}

/// A sound file of one channel at 1000 Hz.
fn sound(format: u16, bits: u16, data: &[u8]) -> Vec<u8> {
    let block = bits / 8;
    let mut bytes = b"RIFF".to_vec();
    bytes.extend((36 + data.len() as u32).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16_u32.to_le_bytes());
    bytes.extend([format, 1].map(u16::to_le_bytes).concat());
    bytes.extend([1000, 1000 * u32::from(block)].map(u32::to_le_bytes).concat());
    bytes.extend([block, bits].map(u16::to_le_bytes).concat());
    bytes.extend(b"data");
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn sound_files_of_other_kinds() {
    let read = |bytes: &[u8]| readers::parse(Source { name: "hit.wav", bytes });
    let three = sound(1, 24, &[0, 0, 0x40, 0, 0, 0x80, 1, 0, 0]);
    assert_eq!(read(&three).unwrap().channels[0].samples, [0.5, -1.0, 2_f64.powi(-23)]);
    for bad in [
        &three[..three.len() - 2],
        &sound(3, 64, &[0; 16]),
        &sound(7, 8, &[0; 16]),
        b"RIFF",
    ] {
        let message = read(bad).unwrap_err().to_string();
        assert!(message.contains("hit.wav"), "{message}");
    }
}

#[test]
fn universal_files_that_break_their_rules() {
    let path = format!("{}/tests/fixtures/even_double.uff", env!("CARGO_MANIFEST_DIR"));
    let sound = std::fs::read_to_string(path).unwrap();
    let change = |from: &str, to: &str| {
        assert!(sound.contains(from), "{from}");
        let text = sound.replacen(from, to, 1);
        readers::parse(Source {
            name: "run.uff",
            bytes: text.as_bytes(),
        })
    };
    for (from, to, place, found) in [
        ("        40         1", "        41         1", "line ", "40 values"),
        ("4.88281e-04", "0.00000e+00", "line ", "a step of 0"),
        (" s  ", " h  ", "line 10", "unit `h` of time"),
        ("-2.50000000000e+00", "-2.5x000000000e+00", "line 14", "-2.5x"),
        (
            "    58 ",
            "    58b    1     1          11         320",
            "line 2",
            "format 1",
        ),
        ("    58 ", "    58b    1     2          11        9999", "byte", "9999"),
    ] {
        let message = change(from, to).unwrap_err().to_string();
        assert!(
            message.contains(place) && message.contains(found) && message.contains("run.uff"),
            "{message}"
        );
    }
    // A frequency response, and values without a blank between them.
    let other = change("\n    1         0", "\n    4         0").unwrap();
    assert!(other.channels.is_empty() && other.skipped[0].reason.contains("type 4"));
    let joined = change(
        "  -2.50000000000e+00  -1.25000000000e+00",
        " -2.50000000000e+000-1.25000000000e+000",
    )
    .unwrap();
    assert_eq!(joined.channels[0].samples[..2], [-2.5, -1.25]);
}
