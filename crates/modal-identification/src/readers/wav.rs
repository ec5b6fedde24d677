//! Sound files (`.wav`): PCM of 8, 16, 24 or 32 bits, or numbers in single precision. Integers become fractions of full
//! scale; the unit to state is then the size of full scale, as `98.1 m/s^2`. Channels are called `1`, `2` and so on.

use file_io::{Place, Source};
use hound::{SampleFormat, WavReader};

use super::recording::{Recording, malformed, recording};
use crate::Error;
use crate::signal::Timing;

/// Reads all channels.
///
/// # Errors
/// [`Error::File`].
pub fn parse(source: Source<'_>) -> Result<Recording, Error> {
    let broken = |place, e: hound::Error| match e {
        hound::Error::Unsupported => {
            let error = matrix_files::Error::Unsupported {
                file: source.name.into(),
                place,
                found: "its kind of samples".into(),
                remedy: "write PCM of 8, 16, 24 or 32 bits, or numbers of 32 bits",
            };
            error.into()
        }
        other => malformed(source, place, other, "a complete sound file"),
    };
    let reader = WavReader::new(source.bytes).map_err(|e| broken(Place::Byte(0), e))?;
    let spec = reader.spec();
    let stated = reader.len() as usize;
    let possible = source.bytes.len();
    if stated > possible {
        let error = matrix_files::Error::Oversized {
            file: source.name.into(),
            place: Place::Byte(0),
            what: "the number of samples",
            stated: stated as u128,
            possible,
        };
        return Err(error.into());
    }
    let count = usize::from(spec.channels);
    let mut channels: Vec<(String, Option<String>, Vec<f64>)> = (1..=count)
        .map(|number| (number.to_string(), None, Vec::new()))
        .collect();
    let full_scale = 2_f64.powi(i32::from(spec.bits_per_sample) - 1);
    let samples: Box<dyn Iterator<Item = hound::Result<f64>>> = match spec.sample_format {
        SampleFormat::Float => Box::new(reader.into_samples::<f32>().map(|s| s.map(f64::from))),
        SampleFormat::Int => {
            let fraction = move |s: i32| f64::from(s) / full_scale;
            Box::new(reader.into_samples::<i32>().map(move |s| s.map(fraction)))
        }
    };
    for (i, sample) in samples.enumerate() {
        let sample = sample.map_err(|e| {
            let part = "the samples".into();
            broken(
                Place::Inside {
                    part,
                    byte: i * usize::from(spec.bits_per_sample / 8),
                },
                e,
            )
        })?;
        channels[i % count].2.push(sample);
    }
    Ok(recording(source, &Timing::Rate(spec.sample_rate.into()), channels))
}
