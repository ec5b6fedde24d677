//! Measured ring-downs, their backbones, and backbones beside one another.

use crate::error::{Exception, input};
use analyses::comparison::{Backbone, Difference, Point};
use modal_identification::average::average;
use modal_identification::backbone::{self, Identification, Settings};
use modal_identification::signal::{Channel, Quantity, Signal, Stated, Timing};
use modal_identification::synthetic::{RingDown, add_noise};
use modal_identification::{Warning, readers};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Name, unit, sample rate (Hz) or times (s), samples.
type PyChannel<'py> = (
    String,
    Option<String>,
    Option<f64>,
    Option<Bound<'py, PyArray1<f64>>>,
    Bound<'py, PyArray1<f64>>,
);

/// The record that a channel is of, and the channel.
type GivenChannel<'py> = (
    String,
    String,
    Option<String>,
    Option<f64>,
    Option<PyReadonlyArray1<'py, f64>>,
    PyReadonlyArray1<'py, f64>,
);

/// All channels in a file, or those of one name: the file, the channels, and what is worth knowing.
#[pyfunction]
#[pyo3(signature = (path: "str", channel: "str | None") -> "tuple[str, list[tuple[str, str | None, float | None, numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.float64]]], list[str]]")]
pub(crate) fn read_record<'py>(
    py: Python<'py>,
    path: PathBuf,
    channel: Option<&str>,
) -> Result<(String, Vec<PyChannel<'py>>, Vec<String>), Exception> {
    let recording = py.detach(|| readers::read(&path))?;
    let (channels, warnings) = match channel {
        Some(name) => recording.select(Some(name))?,
        None => {
            let skipped = recording.skipped.iter().map(|s| Warning::Skipped {
                name: s.name.clone(),
                reason: s.reason.clone(),
            });
            (recording.channels.iter().collect(), skipped.collect())
        }
    };
    let channels = channels.into_iter().map(|channel| {
        let (rate, times) = match &channel.timing {
            Timing::Unstated => (None, None),
            Timing::Rate(rate) => (Some(*rate), None),
            Timing::Times(times) => (None, Some(PyArray1::from_slice(py, times))),
        };
        let samples = PyArray1::from_slice(py, &channel.samples);
        (channel.name.clone(), channel.unit.clone(), rate, times, samples)
    });
    let channels = channels.collect();
    Ok((
        recording.file,
        channels,
        warnings.iter().map(ToString::to_string).collect(),
    ))
}

/// A quantity by its name.
fn quantity(argument: &str, name: &str) -> Result<Quantity, Exception> {
    const NAMES: &str = "it must be one of acceleration, velocity, displacement";
    let all = [Quantity::Acceleration, Quantity::Velocity, Quantity::Displacement];
    all.into_iter()
        .find(|quantity| quantity.to_string() == name)
        .ok_or_else(|| input(format!("there is no quantity {name:?}; {NAMES}")).of(argument, NAMES))
}

/// The backbone of one mode in several hits: what amplitudes are; amplitudes, frequencies, damping ratios, their spreads and numbers of
/// hits; and for each hit its backbone with times, its spectrum with the distance of its lines, and more as JSON.
#[pyfunction]
#[pyo3(signature = (
    channels: "collections.abc.Sequence[tuple[str, str, str | None, float | None, numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.float64]]]",
    unit: "str | None",
    sample_rate: "float | None",
    frequency: "float | None",
    bandwidth: "float | None",
    start: "float | None",
    smoothing: "int",
    noise_margin: "float",
    amplitude: "str | None",
    points: "int"
) -> "tuple[str, numpy.typing.NDArray[numpy.float64], list[tuple[numpy.typing.NDArray[numpy.float64], float, numpy.typing.NDArray[numpy.float64], str]]]")]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    channels: Vec<GivenChannel<'py>>,
    unit: Option<String>,
    sample_rate: Option<f64>,
    frequency: Option<f64>,
    bandwidth: Option<f64>,
    start: Option<f64>,
    smoothing: i64,
    noise_margin: f64,
    amplitude: Option<&str>,
    points: i64,
) -> PyResult<Identified<'py>> {
    let mut settings = Settings {
        frequency,
        bandwidth,
        start,
        // What is refused for being negative is refused for being zero.
        smoothing: usize::try_from(smoothing).unwrap_or(0),
        noise_margin,
        quantity: amplitude.map(|name| quantity("amplitude", name)).transpose()?,
    };
    const POINTS: &str = "it must be from 2 to 100000";
    let points = usize::try_from(points).ok().filter(|n| (2..=100_000).contains(n));
    let points = points.ok_or_else(|| input(format!("points is not admissible; {POINTS}")).of("points", POINTS))?;
    let stated = Stated { unit, sample_rate };
    let channels: Vec<(String, Channel)> = channels.into_iter().map(given).collect::<Result<_, _>>()?;
    let (mean, hits) = py.detach(|| {
        let mut hits: Vec<Hit> = Vec::new();
        for (file, channel) in &channels {
            let (signal, mut warnings) = Signal::try_new(file, channel, &stated)?;
            // Hits of another kind of sensor are converted to that of the first.
            settings.quantity.get_or_insert(signal.quantity);
            let found = backbone::identify(&signal, &settings)?;
            warnings.extend(found.warnings.iter().cloned());
            hits.push(Hit {
                file: file.clone(),
                signal,
                found,
                warnings,
            });
        }
        let backbones: Vec<&[backbone::Point]> = hits.iter().map(|hit| &hit.found.backbone[..]).collect();
        Ok::<_, Exception>((average(&backbones, points)?, hits))
    })?;
    // Every hit has been given this quantity.
    let quantity = settings.quantity.unwrap_or(Quantity::Acceleration);
    let rows: Vec<f64> = mean
        .iter()
        .flat_map(|p| {
            let [f, zeta] = p.spread.unwrap_or([f64::NAN; 2]);
            [p.amplitude, p.frequency_hz, p.damping_ratio, f, zeta, p.hits as f64]
        })
        .collect();
    let table = PyArray1::from_vec(py, rows).reshape([mean.len(), 6])?;
    let hits = hits.iter().map(|hit| {
        let backbone = &hit.found.backbone;
        let rows = backbone
            .iter()
            .flat_map(|p| [p.time, p.amplitude, p.frequency_hz, p.damping_ratio]);
        let rows = PyArray1::from_vec(py, rows.collect()).reshape([backbone.len(), 4])?;
        let spectrum = &hit.found.spectrum;
        let magnitudes = PyArray1::from_slice(py, &spectrum.magnitudes);
        Ok((rows, spectrum.step, magnitudes, hit.about().to_string()))
    });
    Ok((quantity.to_string(), table, hits.collect::<PyResult<_>>()?))
}

/// Time, amplitude, frequency and damping; distance of the lines of the spectrum, and their magnitudes; the rest.
type PyHit<'py> = (Bound<'py, PyArray2<f64>>, f64, Bound<'py, PyArray1<f64>>, String);

/// See [`identify`].
type Identified<'py> = (String, Bound<'py, PyArray2<f64>>, Vec<PyHit<'py>>);

fn given((file, name, unit, rate, times, samples): GivenChannel<'_>) -> Result<(String, Channel), Exception> {
    let timing = match (rate, times) {
        (_, Some(times)) => Timing::Times(times.as_array().to_vec()),
        (Some(rate), None) => Timing::Rate(rate),
        (None, None) => Timing::Unstated,
    };
    let samples = samples.as_array().to_vec();
    if let Timing::Times(times) = &timing
        && times.len() != samples.len()
    {
        let remedy = "give a time for each sample";
        let found = format!(
            "{file}: there are {} times for {} samples; {remedy}",
            times.len(),
            samples.len()
        );
        return Err(input(found).of("record", remedy));
    }
    let channel = Channel {
        name,
        unit,
        timing,
        samples,
    };
    Ok((file, channel))
}

struct Hit {
    file: String,
    signal: Signal,
    found: Identification,
    warnings: Vec<Warning>,
}

impl Hit {
    fn about(&self) -> Value {
        let (signal, found) = (&self.signal, &self.found);
        json!({
            "record": self.file,
            "quantity": signal.quantity.to_string(),
            "sample_rate_hz": signal.sample_rate,
            "samples": signal.samples.len(),
            "peak_hz": found.peak_hz,
            "band_hz": found.band_hz,
            "start_s": found.trims.start,
            "end_s": found.trims.end,
            "end_reason": format!("{:?}", found.trims.reason),
            "noise_amplitude": found.noise_amplitude,
            "cross_check": found.cross_check.map(|c| json!({
                "points": c.points,
                "frequency_median_hz": c.frequency_median,
                "frequency_largest_hz": c.frequency_largest,
                "damping_median": c.damping_median,
                "damping_largest": c.damping_largest,
                "amplitude_median": c.amplitude_median,
            })),
            "warnings": self.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        })
    }
}

/// Name, amplitudes, frequencies and damping ratios, and what amplitudes are.
type NamedBackbone<'py> = (
    String,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    String,
);

/// A backbone over `wanted`.
fn over(
    (name, amplitude, frequency, damping, measured): &NamedBackbone<'_>,
    wanted: Quantity,
) -> Result<Backbone, Exception> {
    let (amplitude, frequency, damping) = (amplitude.as_array(), frequency.as_array(), damping.as_array());
    if amplitude.len() != frequency.len() || amplitude.len() != damping.len() {
        let remedy = "give as many frequencies and damping ratios as amplitudes";
        let found = format!(
            "{name}: there are {} amplitudes, {} frequencies and {} damping ratios; {remedy}",
            amplitude.len(),
            frequency.len(),
            damping.len()
        );
        return Err(input(found).of("damping_ratio", remedy));
    }
    let points = amplitude.iter().zip(frequency).zip(damping);
    let points = points.map(|((amplitude, frequency_hz), damping)| Point {
        amplitude: *amplitude,
        frequency_hz: *frequency_hz,
        damping_ratio: Some(*damping).filter(|zeta| !zeta.is_nan()),
    });
    let more = wanted.derivatives() - quantity("quantity", measured)?.derivatives();
    let made = Backbone::try_new(name, points.collect()).and_then(|backbone| backbone.differentiated(name, more));
    made.map_err(|error| input(error.to_string()))
}

/// How far a backbone lies from a reference, over amplitudes of a quantity: by name mean, root mean square and largest, and the arrays
/// that they are of; the shares of the reference that lie within a band; and both backbones.
#[pyfunction]
#[pyo3(signature = (
    theory: "tuple[str, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], str]",
    reference: "tuple[str, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], str]",
    band: "collections.abc.Sequence[tuple[str, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], str]] | None",
    amplitude: "str"
) -> "tuple[dict[str, tuple[float, float, float] | None], tuple[float, float] | None, dict[str, numpy.typing.NDArray[numpy.float64]], tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]]")]
pub(crate) fn misfit<'py>(
    py: Python<'py>,
    theory: NamedBackbone<'py>,
    reference: NamedBackbone<'py>,
    band: Option<[NamedBackbone<'py>; 2]>,
    amplitude: &str,
) -> PyResult<Compared<'py>> {
    let wanted = quantity("amplitude", amplitude)?;
    let (over_theory, over_reference) = (over(&theory, wanted)?, over(&reference, wanted)?);
    let (Some(misfit), Some(points)) = (
        over_theory.misfit(&over_reference),
        over_theory.differences(&over_reference),
    ) else {
        let ([a, b], [c, d]) = (over_theory.range(), over_reference.range());
        let remedy = "run the scene with other analyses.backbone.amplitude_from and analyses.backbone.amplitude_to, or check the \
                      unit and the place of the sensor";
        let found = format!(
            "{} and {} share no amplitude: {a:.3e} to {b:.3e} against {c:.3e} to {d:.3e} {}; {remedy}",
            theory.0,
            reference.0,
            wanted.unit()
        );
        return Err(input(found).of("experiments", remedy).into());
    };
    let within = match &band {
        Some([low, high]) => over_reference.within(&over(low, wanted)?, &over(high, wanted)?),
        None => None,
    };
    let numbers = PyDict::new(py);
    let triple = |d: Difference| (d.mean, d.rms, d.largest);
    numbers.set_item("frequency_hz", triple(misfit.frequency_hz))?;
    numbers.set_item("frequency_percent", triple(misfit.frequency_percent))?;
    numbers.set_item("damping_ln", misfit.damping_ln.map(triple))?;
    let arrays = PyDict::new(py);
    let column = |name: &str, values: Vec<f64>| arrays.set_item(name, PyArray1::from_vec(py, values));
    column("amplitude", points.iter().map(|p| p.amplitude).collect())?;
    column("frequency_hz", points.iter().map(|p| p.frequency_hz).collect())?;
    column(
        "frequency_percent",
        points.iter().map(|p| p.frequency_percent).collect(),
    )?;
    let logarithms = points.iter().map(|p| p.damping_ln.unwrap_or(f64::NAN));
    column("damping_ln", logarithms.collect())?;
    let table = |backbone: &Backbone| {
        let points = backbone.points();
        let rows = points
            .iter()
            .flat_map(|p| [p.amplitude, p.frequency_hz, p.damping_ratio.unwrap_or(f64::NAN)]);
        PyArray1::from_vec(py, rows.collect()).reshape([points.len(), 3])
    };
    let tables = (table(&over_theory)?, table(&over_reference)?);
    Ok((numbers, within.map(|[f, zeta]| (f, zeta)), arrays, tables))
}

/// See [`misfit`].
type Compared<'py> = (
    Bound<'py, PyDict>,
    Option<(f64, f64)>,
    Bound<'py, PyDict>,
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>),
);

/// A ring-down whose frequency (Hz) and damping ratio are linear in the logarithm of the amplitude between the given ones, and constant
/// beyond; with Gaussian noise.
#[pyfunction]
#[pyo3(signature = (
    amplitude: "float",
    over: "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]",
    sample_rate: "float",
    samples: "int",
    phase: "float",
    noise: "float",
    seed: "int"
) -> "numpy.typing.NDArray[numpy.float64]")]
pub(crate) fn synthetic_ring_down<'py>(
    py: Python<'py>,
    amplitude: f64,
    over: (
        PyReadonlyArray1<'py, f64>,
        PyReadonlyArray1<'py, f64>,
        PyReadonlyArray1<'py, f64>,
    ),
    sample_rate: f64,
    samples: i64,
    phase: f64,
    noise: f64,
    seed: u64,
) -> Result<Bound<'py, PyArray1<f64>>, Exception> {
    let [amplitudes, frequencies, dampings] = [&over.0, &over.1, &over.2].map(|array| array.as_array().to_vec());
    for (name, value) in [("amplitude", amplitude), ("sample_rate", sample_rate)] {
        const RANGE: &str = "it must be positive and finite";
        if !(value > 0.0 && value.is_finite()) {
            return Err(input(format!("{name} = {value} is not admissible; {RANGE}")).of(name, RANGE));
        }
    }
    const COUNT: &str = "it must be from 1 to 100 million";
    let count = usize::try_from(samples).ok().filter(|n| (1..=100_000_000).contains(n));
    let count =
        count.ok_or_else(|| input(format!("samples = {samples} is not admissible; {COUNT}")).of("samples", COUNT))?;
    const CURVES: &str = "it must have as many positive frequencies, up to the sample rate, and \
         damping ratios from 0 to below 1 as ascending positive amplitudes";
    let fits = amplitudes.len() == frequencies.len()
        && amplitudes.len() == dampings.len()
        && amplitudes.first().is_some_and(|first| *first > 0.0)
        && amplitudes.windows(2).all(|pair| pair[0] < pair[1])
        && amplitudes.iter().all(|a| a.is_finite())
        && frequencies.iter().all(|f| *f > 0.0 && *f <= sample_rate)
        && dampings.iter().all(|zeta| (0.0..1.0).contains(zeta));
    if !fits {
        return Err(input(format!("the backbone cannot be followed; {CURVES}")).of("backbone", CURVES));
    }
    if !(noise >= 0.0 && noise.is_finite() && phase.is_finite()) {
        const RANGE: &str = "they must be finite, and the noise not negative";
        return Err(input(format!(
            "noise = {noise} and phase = {phase} are not admissible; {RANGE}"
        ))
        .of("noise", RANGE));
    }
    let between = |values: &[f64], a: f64| {
        let above = amplitudes
            .partition_point(|x| *x < a)
            .clamp(1, amplitudes.len().max(2) - 1);
        let Some([x, y]) = amplitudes
            .get(above - 1..=above)
            .and_then(|w| <[f64; 2]>::try_from(w).ok())
        else {
            return values[0];
        };
        let part = ((a / x).ln() / (y / x).ln()).clamp(0.0, 1.0);
        values[above - 1] + part * (values[above] - values[above - 1])
    };
    let signal = py.detach(|| {
        let mode = RingDown {
            amplitude,
            phase,
            frequency: |a: f64| between(&frequencies, a),
            damping_ratio: |a: f64| between(&dampings, a),
        };
        let mut signal = mode.samples(sample_rate, count);
        if noise > 0.0 {
            add_noise(&mut signal, noise, seed);
        }
        signal
    });
    Ok(PyArray1::from_vec(py, signal))
}
