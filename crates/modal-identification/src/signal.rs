//! One channel of a record as a signal in SI units, checked.

use std::fmt;
use std::str::FromStr;

use crate::median::upper_median;
use crate::{Error, Warning};

/// Acceleration of free fall (m/s^2), exact by definition.
const STANDARD_GRAVITY: f64 = 9.80665;

/// Weight of a pound (N), exact by definition.
const POUND_FORCE: f64 = 4.448_221_615_260_5;

/// Fewer samples are no signal.
const SHORTEST: usize = 16;

/// What a signal measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Displacement (m).
    Displacement,
    /// Velocity (m/s).
    Velocity,
    /// Acceleration (m/s^2).
    Acceleration,
}

impl Quantity {
    /// The SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Displacement => "m",
            Self::Velocity => "m/s",
            Self::Acceleration => "m/s^2",
        }
    }

    /// How often displacement is differentiated with respect to time.
    pub fn derivatives(self) -> i32 {
        match self {
            Self::Displacement => 0,
            Self::Velocity => 1,
            Self::Acceleration => 2,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
        })
    }
}

/// A unit of acceleration, velocity or displacement.
///
/// Written as a length (`m`, `cm`, `mm`, `um`, `nm`, `in`, `ft`, `mil`), that over `s` or `s^2` (also `s2`, `s²`, `s/s`), or
/// `g` for standard gravity; capitals mean the same. A number in front is a factor: with `0.5 m/s^2` a value of 2 is
/// 1 m/s^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// What it measures.
    pub quantity: Quantity,
    /// Its size in SI units.
    pub scale: f64,
}

impl FromStr for Unit {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let refused = || Self::unknown("unit", text);
        let (factor, symbol) = factored(text).ok_or_else(refused)?;
        let symbol = symbol.to_lowercase().replace(char::is_whitespace, "");
        let symbol = symbol.replace("**", "^").replace('²', "^2").replace(['µ', 'μ'], "u");
        let (length, rate) = symbol.split_once('/').unwrap_or((&symbol, ""));
        let length = match length {
            "m" => 1.0,
            "cm" => 1e-2,
            "mm" => 1e-3,
            "um" => 1e-6,
            "nm" => 1e-9,
            "in" => 0.0254,
            "ft" => 0.3048,
            "mil" => 2.54e-5,
            "g" if rate.is_empty() => STANDARD_GRAVITY,
            _ => return Err(refused()),
        };
        let quantity = match rate {
            "" if symbol == "g" => Quantity::Acceleration,
            "" if !symbol.contains('/') => Quantity::Displacement,
            "s" | "sec" => Quantity::Velocity,
            "s^2" | "s2" | "s/s" | "sec^2" | "sec2" | "sec/sec" => Quantity::Acceleration,
            _ => return Err(refused()),
        };
        let scale = factor * length;
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(refused());
        }
        Ok(Self { quantity, scale })
    }
}

/// A unit of force: `N`, `mN`, `kN` or `lbf`; a number in front is a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceUnit {
    /// Its size (N).
    pub scale: f64,
}

impl FromStr for ForceUnit {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let refused = || Self::unknown("unit", text);
        let (factor, symbol) = factored(text).ok_or_else(refused)?;
        let size = match symbol.trim() {
            "N" => 1.0,
            "mN" => 1e-3,
            "kN" => 1e3,
            "lbf" => POUND_FORCE,
            _ => return Err(refused()),
        };
        let scale = factor * size;
        match scale > 0.0 && scale.is_finite() {
            true => Ok(Self { scale }),
            false => Err(refused()),
        }
    }
}

/// The number in front of a unit, and the unit.
fn factored(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    match text.split_once(char::is_whitespace) {
        Some((factor, symbol)) => Some((factor.parse().ok()?, symbol)),
        None => Some((1.0, text)),
    }
}

/// What a channel may be in.
trait Physical: Copy + PartialEq + FromStr {
    /// Its size in SI units.
    fn scale(&self) -> f64;

    /// The SI unit.
    fn symbol(&self) -> &'static str;

    /// A text that is no such unit.
    fn unknown(at: &str, unit: &str) -> Error;
}

impl Physical for Unit {
    fn scale(&self) -> f64 {
        self.scale
    }

    fn symbol(&self) -> &'static str {
        self.quantity.unit()
    }

    fn unknown(at: &str, unit: &str) -> Error {
        Error::UnknownUnit {
            at: at.into(),
            unit: unit.into(),
        }
    }
}

impl Physical for ForceUnit {
    fn scale(&self) -> f64 {
        self.scale
    }

    fn symbol(&self) -> &'static str {
        "N"
    }

    fn unknown(at: &str, unit: &str) -> Error {
        Error::UnknownForceUnit {
            at: at.into(),
            unit: unit.into(),
        }
    }
}

/// When the samples of a channel were taken.
#[derive(Clone, Debug, PartialEq)]
pub enum Timing {
    /// The file does not say.
    Unstated,
    /// At a constant rate (Hz).
    Rate(f64),
    /// At these times (s), one per sample.
    Times(Vec<f64>),
}

/// A channel as it stands in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name.
    pub name: String,
    /// Unit as it is written, if any.
    pub unit: Option<String>,
    /// Times of the samples.
    pub timing: Timing,
    /// Samples in that unit; NaN where the file has none.
    pub samples: Vec<f64>,
}

impl Channel {
    /// Whether all samples are equal.
    pub fn is_constant(&self) -> bool {
        self.samples.windows(2).all(|w| w[0] == w[1])
    }
}

/// What the user states about a channel beyond its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stated {
    /// Unit, as [`Unit`] reads it.
    pub unit: Option<String>,
    /// Sample rate (Hz).
    pub sample_rate: Option<f64>,
}

/// A signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// File and channel, for messages.
    pub at: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Samples per second (Hz).
    pub sample_rate: f64,
    /// Samples (SI unit of the quantity).
    pub samples: Vec<f64>,
    /// The last sample that is clipped, counted from zero.
    pub last_clipped: Option<usize>,
}

impl Signal {
    /// Checks a channel of `file` and brings it to SI units.
    ///
    /// A unit that the file states and this crate knows need not be given, and one given must agree with it; a unit
    /// given replaces one that is none of length, velocity or acceleration (volts). A sample rate given must agree with
    /// that of the file within 1e-4, and then replaces it (formats round it).
    ///
    /// # Errors
    /// [`Error::TooShort`], [`Error::NotFinite`], [`Error::Constant`], [`Error::Gap`] where a step is longer than 1.5
    /// times the median, [`Error::TimeNotAscending`], [`Error::NonUniformTime`] beyond a quarter of a step,
    /// [`Error::NoUnit`], [`Error::UnknownUnit`], [`Error::ConflictingUnit`], [`Error::NoSampleRate`],
    /// [`Error::ConflictingSampleRate`], [`Error::BadSampleRate`].
    pub fn try_new(file: &str, channel: &Channel, stated: &Stated) -> Result<(Self, Vec<Warning>), Error> {
        let checked = Checked::<Unit>::try_new(file, channel, stated)?;
        let signal = Self {
            at: checked.at,
            quantity: checked.unit.quantity,
            sample_rate: checked.sample_rate,
            samples: checked.samples,
            last_clipped: checked.last_clipped,
        };
        Ok((signal, checked.warnings))
    }

    /// Length (s).
    pub fn duration(&self) -> f64 {
        self.samples.len() as f64 / self.sample_rate
    }
}

/// A force over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Force {
    /// File and channel, for messages.
    pub at: String,
    /// Samples per second (Hz).
    pub sample_rate: f64,
    /// Samples (N).
    pub samples: Vec<f64>,
}

impl Force {
    /// Checks a channel of `file` as [`Signal::try_new`] does, and brings it to N.
    ///
    /// # Errors
    /// Those of [`Signal::try_new`], with [`Error::UnknownForceUnit`] for units.
    pub fn try_new(file: &str, channel: &Channel, stated: &Stated) -> Result<(Self, Vec<Warning>), Error> {
        let checked = Checked::<ForceUnit>::try_new(file, channel, stated)?;
        let force = Self {
            at: checked.at,
            sample_rate: checked.sample_rate,
            samples: checked.samples,
        };
        Ok((force, checked.warnings))
    }
}

/// A channel that has passed the checks.
struct Checked<U> {
    at: String,
    unit: U,
    sample_rate: f64,
    /// In SI units.
    samples: Vec<f64>,
    last_clipped: Option<usize>,
    warnings: Vec<Warning>,
}

impl<U: Physical> Checked<U> {
    fn try_new(file: &str, channel: &Channel, stated: &Stated) -> Result<Self, Error> {
        let at = format!("{file}, channel `{}`", channel.name);
        let mut warnings = Vec::new();
        let samples = &channel.samples;
        if samples.len() < SHORTEST {
            return Err(Error::TooShort {
                at,
                samples: samples.len(),
                needed: SHORTEST,
            });
        }
        if let Some(i) = samples.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                at,
                sample: i + 1,
                value: samples[i],
            });
        }
        let unit: U = unit(&at, channel, stated)?;
        if channel.is_constant() {
            return Err(Error::Constant {
                at,
                samples: samples.len(),
                value: samples[0] * unit.scale(),
                unit: unit.symbol().into(),
            });
        }
        let sample_rate = sample_rate(&at, channel, stated, &mut warnings)?;
        let last_clipped = clipping(samples, sample_rate, &mut warnings);
        dropouts(samples, sample_rate, &mut warnings);
        Ok(Self {
            at,
            unit,
            sample_rate,
            samples: samples.iter().map(|v| v * unit.scale()).collect(),
            last_clipped,
            warnings,
        })
    }
}

fn unit<U: Physical>(at: &str, channel: &Channel, stated: &Stated) -> Result<U, Error> {
    let parse = |text: &str| text.parse().map_err(|_| U::unknown(at, text));
    match (&channel.unit, &stated.unit) {
        (None, None) => Err(Error::NoUnit { at: at.into() }),
        (Some(text), None) => parse(text),
        (None, Some(given)) => parse(given),
        (Some(text), Some(given)) => {
            let wanted = parse(given)?;
            match text.parse::<U>() {
                Ok(unit) if unit != wanted => Err(Error::ConflictingUnit {
                    at: at.into(),
                    stated: text.clone(),
                    given: given.clone(),
                }),
                _ => Ok(wanted),
            }
        }
    }
}

fn sample_rate(at: &str, channel: &Channel, stated: &Stated, warnings: &mut Vec<Warning>) -> Result<f64, Error> {
    let of_file = match &channel.timing {
        Timing::Unstated => None,
        Timing::Rate(rate) => Some(*rate),
        Timing::Times(times) => Some(uniform_rate(at, times, warnings)?),
    };
    let rate = match (of_file, stated.sample_rate) {
        (None, None) => return Err(Error::NoSampleRate { at: at.into() }),
        (Some(rate), None) | (None, Some(rate)) => rate,
        (Some(rate), Some(given)) if (rate - given).abs() <= 1e-4 * rate => given,
        (Some(stated), Some(given)) => {
            return Err(Error::ConflictingSampleRate {
                at: at.into(),
                stated,
                given,
            });
        }
    };
    if rate > 0.0 && rate.is_finite() {
        Ok(rate)
    } else {
        Err(Error::BadSampleRate { at: at.into(), rate })
    }
}

/// The rate of samples at these times.
fn uniform_rate(at: &str, times: &[f64], warnings: &mut Vec<Warning>) -> Result<f64, Error> {
    if let Some(i) = times.iter().position(|t| !t.is_finite()) {
        return Err(Error::NotFinite {
            at: format!("time of {at}"),
            sample: i + 1,
            value: times[i],
        });
    }
    let mut steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    if let Some(i) = steps.iter().position(|s| !(*s > 0.0)) {
        return Err(Error::TimeNotAscending {
            at: at.into(),
            sample: i + 2,
            before: times[i],
            time: times[i + 1],
        });
    }
    let median = upper_median(&mut steps);
    if let Some(i) = times.windows(2).position(|w| w[1] - w[0] > 1.5 * median) {
        return Err(Error::Gap {
            at: at.into(),
            sample: i + 1,
            time: times[i],
            missing: (times[i + 1] - times[i]) / median - 1.0,
        });
    }
    let (first, last) = (times[0], times[times.len() - 1]);
    let step = (last - first) / (times.len() - 1) as f64;
    let distance = |i: usize| ((times[i] - first) / step - i as f64).abs();
    let farthest = (0..times.len()).max_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    let worst = farthest.unwrap_or(0);
    if distance(worst) > 0.25 {
        return Err(Error::NonUniformTime {
            at: at.into(),
            sample: worst + 1,
            time: times[worst],
            steps: distance(worst),
        });
    }
    if distance(worst) > 1e-3 {
        warnings.push(Warning::Jitter { steps: distance(worst) });
    }
    Ok(1.0 / step)
}

/// Smallest step between neighbours that differ: that of the converter, if it shows.
fn smallest_step(samples: &[f64]) -> f64 {
    let steps = samples.windows(2).map(|w| (w[1] - w[0]).abs());
    steps.filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min)
}

/// Finds runs of three or more samples at the largest or smallest value that the signal enters or leaves by more than
/// four of its smallest steps, which a smooth extremum in whole steps does not. Returns the last such sample.
fn clipping(samples: &[f64], rate: f64, warnings: &mut Vec<Warning>) -> Option<usize> {
    let smallest = samples.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let step = smallest_step(samples);
    let (mut count, mut last, mut end) = (0, None, 0);
    for run in samples.chunk_by(|a, b| a == b) {
        let begin = end;
        end += run.len();
        if run.len() < 3 || run[0] != smallest && run[0] != largest {
            continue;
        }
        let before = begin.checked_sub(1).map(|i| samples[i]);
        let neighbours = [before, samples.get(end).copied()];
        let jump = neighbours
            .into_iter()
            .flatten()
            .map(|v| (v - run[0]).abs())
            .fold(0.0, f64::max);
        if jump > 4.0 * step {
            count += run.len();
            last = Some(end - 1);
        }
    }
    if let Some(last) = last {
        warnings.push(Warning::Clipped {
            samples: count,
            last: last as f64 / rate,
        });
    }
    last
}

/// Reports runs of 16 or more equal samples inside the record with motion of more than eight of the smallest steps within
/// as many samples on both sides.
fn dropouts(samples: &[f64], rate: f64, warnings: &mut Vec<Warning>) {
    let step = smallest_step(samples);
    let mut end = 0;
    for run in samples.chunk_by(|a, b| a == b) {
        let begin = end;
        end += run.len();
        if run.len() < 16 {
            continue;
        }
        let moves = |side: &[f64]| side.iter().any(|v| (v - run[0]).abs() > 8.0 * step);
        let before = &samples[begin.saturating_sub(run.len())..begin];
        let after = &samples[end..samples.len().min(end + run.len())];
        if moves(before) && moves(after) {
            warnings.push(Warning::Dropout {
                time: begin as f64 / rate,
                samples: run.len(),
            });
        }
    }
}
