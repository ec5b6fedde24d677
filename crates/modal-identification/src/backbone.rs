//! From a signal to natural frequency and damping ratio against amplitude.
//!
//! # What is done
//!
//! 1. The mean is taken off. The *hit* is the sample of largest magnitude, or the last clipped one if that comes later.
//! 2. The mode is the highest peak of the spectrum after the hit, near the frequency asked for if there is one.
//! 3. The band-pass filter of [`crate::filter`], centred on the mode, runs over the reversed signal.
//! 4. Fewer than 40 samples per cycle are interpolated; extrema are vertices of parabolas ([`crate::peaks`]). At both
//!    ends part of the record is not used, see [`Trims`].
//! 5. About each point the filter is a factor, a delay and some dispersion, known from its poles; they are undone, so that
//!    amplitude, frequency and damping belong to the same moment of the unfiltered mode.
//! 6. Decay rate `sigma` and damped angular frequency `omega_d` are differences over two periods (logarithmic decrement, phase);
//!    `omega = sqrt(omega_d^2 + sigma^2)`, `zeta = sigma/omega`. Amplitude (its logarithm), frequency and damping ratio are
//!    smoothed ([`crate::smoothing`]).
//!
//! The amplitude of another quantity than the one measured is that divided by `omega` once or twice, as for free decay.
//!
//! Pairs of modes closer than their half-power widths, or than the resolution of the record, look like one mode whose
//! frequency and damping change; no test of one channel tells them apart.

use std::f64::consts::{SQRT_2, TAU};

use rustfft::num_complex::Complex64;

use crate::error::Setting;
use crate::filter::{BandPass, HIGHEST_EDGE, NOISE_BANDWIDTH};
use crate::hilbert::{self, CrossCheck};
use crate::peaks::{REACH, SAMPLES_PER_CYCLE, peaks, upsample};
use crate::point::moments;
use crate::signal::{Quantity, Signal};
use crate::smoothing::SavitzkyGolay;
use crate::spectrum::{Line, Spectrum, largest, noise_density};
use crate::track::Track;
use crate::{Error, Warning};

pub use crate::point::Point;

/// What is left of the filter's start at the end of the record when the backbone ends.
const TRANSIENT: f64 = 1e-4;

/// Samples per cycle that interpolation aims for.
const INTERPOLATED: f64 = 2.0 * SAMPLES_PER_CYCLE;

/// How to identify.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Frequency near which the mode is (Hz): the highest peak within half a bandwidth of it is taken. Without it, the
    /// highest peak of all.
    pub frequency: Option<f64>,
    /// Width of the band between half-power points (Hz); a ninth of the frequency if not given (20 Hz at 180 Hz).
    pub bandwidth: Option<f64>,
    /// Start of the backbone after the first sample (s); one cycle after the hit if not given.
    pub start: Option<f64>,
    /// Points per window of the smoothing, odd. A cycle has two points: 41 of them span as much as 21 maxima.
    pub smoothing: usize,
    /// The backbone ends where the amplitude falls below this many times that of the noise in the band.
    pub noise_margin: f64,
    /// What amplitudes are; the quantity measured if not given.
    pub quantity: Option<Quantity>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            frequency: None,
            bandwidth: None,
            start: None,
            smoothing: 41,
            noise_margin: 50.0,
            quantity: None,
        }
    }
}

/// Which rule ends the backbone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// From there to the end of the record the filter has not settled: its slowest oscillation takes this time to decay by
    /// the factor 1e-4.
    Filter,
    /// The amplitude falls below the noise margin.
    Noise,
    /// The oscillation grows again by a factor of two.
    LaterExcitation,
    /// Maxima and minima do not follow one another in turn.
    IrregularPeaks,
}

/// What of the record is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trims {
    /// The hit (s).
    pub hit: f64,
    /// Start of what is used (s). The first point comes later by the delay of the filter and the two periods of rates.
    pub start: f64,
    /// End of what is used (s).
    pub end: f64,
    /// Why it ends there.
    pub reason: End,
    /// Length of the record (s).
    pub duration: f64,
}

/// A backbone and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// What amplitudes are.
    pub quantity: Quantity,
    /// Points in the order of time, two per cycle.
    pub backbone: Vec<Point>,
    /// Peak of the spectrum, centre of the band (Hz).
    pub peak_hz: f64,
    /// Half-power points of the filter (Hz).
    pub band_hz: [f64; 2],
    /// Factor by which the signal was interpolated.
    pub upsampling: usize,
    /// What of the record is used.
    pub trims: Trims,
    /// Smallest and largest factor `|F|` by which the filter scaled the mode at one moment.
    pub filter_gain: [f64; 2],
    /// Smallest and largest delay of the filter (s).
    pub filter_delay: [f64; 2],
    /// Amplitude of the noise in the band (SI unit of the signal).
    pub noise_amplitude: f64,
    /// The second method beside the first.
    pub cross_check: Option<CrossCheck>,
    /// Spectrum after the hit, unfiltered.
    pub spectrum: Spectrum,
    /// What was noticed.
    pub warnings: Vec<Warning>,
}

/// Identifies the backbone of one mode.
///
/// # Errors
/// [`Error::Setting`], [`Error::NoPeak`], [`Error::TwoModes`] where the band holds another mode whose peak in the spectrum
/// is at least a tenth as high, stands twice above the valley between, and which modulates amplitude and phase at the
/// difference of the frequencies by 5 % or more, or upsets the order of the extrema; [`Error::TooFewCycles`].
pub fn identify(signal: &Signal, settings: &Settings) -> Result<Identification, Error> {
    let rate = signal.sample_rate;
    check(signal, settings)?;
    let smoother = SavitzkyGolay::try_new(settings.smoothing)?;
    let mean = signal.samples.iter().sum::<f64>() / signal.samples.len() as f64;
    let samples: Vec<f64> = signal.samples.iter().map(|v| v - mean).collect();
    let hit = loudest(&samples).unwrap_or(0).max(signal.last_clipped.unwrap_or(0));

    let spectrum = Spectrum::of_ring_down(&samples[hit..], rate);
    let peak = mode_peak(signal, settings, &spectrum)?;
    let bandwidth = settings.bandwidth.unwrap_or(peak / 9.0);
    let band = [peak - 0.5 * bandwidth, peak + 0.5 * bandwidth];
    let filter = BandPass::try_new(band[0], band[1], rate)?;

    // The filter rings on before the first sample; the interpolation there needs it.
    let mut filtered = vec![0.0; REACH];
    filtered.extend(&samples);
    filter.run_backward(&mut filtered);

    let oscillation = Oscillation {
        rate,
        samples: &samples,
        filtered: &filtered,
        hit,
        peak,
        bandwidth,
    };
    let duration = signal.duration();
    let mut trims = Trims {
        hit: hit as f64 / rate,
        start: settings.start.unwrap_or(hit as f64 / rate + 1.0 / peak),
        end: duration - filter.settling_time(TRANSIENT),
        reason: End::Filter,
        duration,
    };
    let mut warnings = Vec::new();
    let upsampling = match rate / peak {
        few if few < SAMPLES_PER_CYCLE => (INTERPOLATED / few).ceil() as usize,
        _ => 1,
    };
    let noise_amplitude = oscillation.noise_amplitude();
    let mut extrema = oscillation.extrema(upsampling, settings.noise_margin * noise_amplitude, &mut trims);
    let track = Track::from_extrema(&extrema, &smoother);
    let growth = growth(&extrema);
    let beats = |distance: f64| trims.reason == End::IrregularPeaks || modulation(&track, distance) >= 0.05;
    other_modes(signal, &spectrum, &filter, peak, beats, growth.is_some(), &mut warnings)?;
    if let Some(k) = growth {
        let end = extrema[k].0 - filter.settling_time(1e-3);
        extrema.retain(|e| e.0 < end);
        (trims.end, trims.reason) = (end, End::LaterExcitation);
        warnings.push(Warning::LaterExcitation { time: end });
    }
    if trims.reason == End::IrregularPeaks {
        warnings.push(Warning::IrregularPeaks { time: trims.end });
    }
    warnings.extend(oscillation.earlier_excitation(&filter, extrema.first()));

    check_length(signal, &trims, extrema.len(), &smoother)?;
    let track = Track::from_extrema(&extrema, &smoother);
    let (track, transfers) = track.before_filter(|lambda| filter.transfer(lambda), &smoother);
    let moments = moments(&track, &smoother);
    let cross_check = hilbert::cross_check(
        &samples,
        rate,
        [trims.start, trims.end],
        [peak, bandwidth],
        &moments,
        &smoother,
    );
    let quantity = settings.quantity.unwrap_or(signal.quantity);
    let divisions = signal.quantity.derivatives() - quantity.derivatives();
    let backbone: Vec<Point> = moments
        .into_iter()
        .map(|point| Point {
            amplitude: point.amplitude / (TAU * point.frequency_hz).powi(divisions),
            ..point
        })
        .collect();
    let span = |value: fn(&crate::filter::Transfer) -> f64| {
        let values = transfers.iter().map(value);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)])
    };
    observe(&backbone, peak, bandwidth, cross_check.as_ref(), &mut warnings);
    Ok(Identification {
        quantity,
        peak_hz: peak,
        band_hz: band,
        upsampling,
        trims,
        filter_gain: span(|t| t.logarithm.re).map(f64::exp),
        filter_delay: span(|t| t.delay.re),
        noise_amplitude,
        cross_check,
        spectrum,
        warnings,
        backbone,
    })
}

/// Refuses a record with too few extrema within the trims.
fn check_length(signal: &Signal, trims: &Trims, extrema: usize, smoother: &SavitzkyGolay) -> Result<(), Error> {
    // Rates, their smoothing and the undoing of the filter take two points at either end each.
    let needed = smoother.window() + 12;
    if extrema >= needed {
        return Ok(());
    }
    Err(Error::TooFewCycles {
        at: signal.at.clone(),
        from: trims.start,
        to: trims.end.max(trims.start),
        cycles: 0.5 * extrema as f64,
        needed: 0.5 * needed as f64,
    })
}

/// Index of the sample of largest magnitude.
fn loudest(samples: &[f64]) -> Option<usize> {
    (0..samples.len()).max_by(|a, b| samples[*a].abs().total_cmp(&samples[*b].abs()))
}

/// The mode in a record, before and after the filter.
struct Oscillation<'a> {
    rate: f64,
    /// Without their mean.
    samples: &'a [f64],
    /// With [`REACH`] values in front.
    filtered: &'a [f64],
    /// Index of the hit.
    hit: usize,
    /// Frequency (Hz).
    peak: f64,
    /// Width of the band (Hz).
    bandwidth: f64,
}

impl Oscillation<'_> {
    /// Amplitude of the noise in the band, from the second half of the record after the hit.
    fn noise_amplitude(&self) -> f64 {
        let tail = &self.samples[self.hit + (self.samples.len() - self.hit) / 2..];
        let density = noise_density(tail, self.rate, self.peak, self.bandwidth);
        SQRT_2 * (density * NOISE_BANDWIDTH * self.bandwidth).sqrt()
    }

    /// Extrema within the trims, which end earlier where extrema lose their order or fall below `least`.
    fn extrema(&self, upsampling: usize, least: f64, trims: &mut Trims) -> Vec<(f64, f64)> {
        let mut extrema = extrema(self.filtered, self.rate, upsampling, [trims.start, trims.end]);
        if let Some(k) = extrema.windows(2).position(|w| w[0].1 * w[1].1 > 0.0) {
            extrema.truncate(k + 1);
            (trims.end, trims.reason) = (extrema[k].0, End::IrregularPeaks);
        }
        if let Some(k) = extrema.iter().position(|(_, v)| v.abs() < least) {
            extrema.truncate(k);
            (trims.end, trims.reason) = (extrema.last().map_or(trims.start, |e| e.0), End::Noise);
        }
        extrema
    }

    /// Motion before the hit that is more than a tenth of the first extremum after it.
    fn earlier_excitation(&self, filter: &BandPass, first: Option<&(f64, f64)>) -> Option<Warning> {
        let hit = self.hit as f64 / self.rate;
        let before = ((hit - filter.settling_time(1e-2)) * self.rate).max(0.0) as usize;
        let k = loudest(&self.filtered[..before])?;
        (self.filtered[k].abs() > 0.1 * first?.1.abs()).then(|| Warning::EarlierExcitation {
            time: k.saturating_sub(REACH) as f64 / self.rate,
        })
    }
}

fn check(signal: &Signal, settings: &Settings) -> Result<(), Error> {
    let refuse = |name, value, unit, allowed: String| {
        Err(Error::Setting(Setting {
            name,
            value,
            unit,
            allowed,
        }))
    };
    let highest = HIGHEST_EDGE * signal.sample_rate;
    for (name, value) in [("frequency", settings.frequency), ("bandwidth", settings.bandwidth)] {
        if let Some(value) = value
            && !(value > 0.0 && value < highest)
        {
            let allowed = format!("above 0 and below {highest}, 0.4 of the sample rate");
            return refuse(name, value, "Hz", allowed);
        }
    }
    if let Some(start) = settings.start
        && !(start >= 0.0 && start < signal.duration())
    {
        let allowed = format!("from 0 to the length of the record, {}", signal.duration());
        return refuse("start", start, "s", allowed);
    }
    // Memory is taken for the whole window.
    if settings.smoothing > signal.samples.len() {
        let allowed = format!("odd and at most the number of samples, {}", signal.samples.len());
        return refuse("smoothing window", settings.smoothing as f64, "points", allowed);
    }
    if !(settings.noise_margin >= 1.0 && settings.noise_margin.is_finite()) {
        return refuse("noise margin", settings.noise_margin, "(1)", "at least 1".into());
    }
    Ok(())
}

/// The peak to identify (Hz).
fn mode_peak(signal: &Signal, settings: &Settings, spectrum: &Spectrum) -> Result<f64, Error> {
    let highest = HIGHEST_EDGE * signal.sample_rate;
    let [low, high] = match settings.frequency {
        Some(f) => {
            let half = 0.5 * settings.bandwidth.unwrap_or(f / 9.0);
            [f - half, f + half]
        }
        None => [4.0 / signal.duration(), highest],
    };
    let maxima = spectrum.maxima(low, high.min(highest), |_| 1.0);
    largest(&maxima)
        .map(|line| line.frequency)
        .ok_or_else(|| Error::NoPeak {
            at: signal.at.clone(),
            low,
            high,
        })
}

/// Times (s) and values of the extrema within a span of time, of filtered samples with [`REACH`] ones in front.
fn extrema(filtered: &[f64], rate: f64, factor: usize, [from, to]: [f64; 2]) -> Vec<(f64, f64)> {
    let index = |time: f64| (time * rate).max(0.0) as usize + REACH;
    let first = index(from) - REACH;
    let last = (index(to) + REACH).min(filtered.len());
    if to <= from || first >= last {
        return Vec::new();
    }
    let interpolated;
    let samples = if factor > 1 {
        interpolated = upsample(&filtered[first..last], factor);
        &interpolated
    } else {
        &filtered[first..last]
    };
    let time = |position: f64| (position / factor as f64 + first as f64 - REACH as f64) / rate;
    let found = peaks(samples).into_iter().map(|p| (time(p.position), p.value));
    found.filter(|(t, _)| (from..to).contains(t)).collect()
}

/// The extremum after which the amplitude grows to twice its size.
fn growth(extrema: &[(f64, f64)]) -> Option<usize> {
    let mut lowest = 0;
    for (k, (_, value)) in extrema.iter().enumerate() {
        if value.abs() < extrema[lowest].1.abs() {
            lowest = k;
        } else if value.abs() > 2.0 * extrema[lowest].1.abs() {
            return Some(lowest);
        }
    }
    None
}

/// Refuses a second mode in the band, reports one beside it. That the signal `beats` at the distance of two peaks confirms
/// them. After a further hit (`again`) the spectrum is that of a mode
/// times a comb: then more than two peaks stand out, and those beside the band say nothing.
fn other_modes(
    signal: &Signal,
    spectrum: &Spectrum,
    filter: &BandPass,
    peak: f64,
    beats: impl Fn(f64) -> bool,
    again: bool,
    warnings: &mut Vec<Warning>,
) -> Result<(), Error> {
    let [low, high] = filter.edges();
    let bandwidth = high - low;
    let weight = |f: f64| filter.response(f).norm();
    let lines = spectrum.maxima(low - bandwidth, high + bandwidth, weight);
    let Some(main) = lines
        .iter()
        .min_by(|a, b| (a.frequency - peak).abs().total_cmp(&(b.frequency - peak).abs()))
    else {
        return Ok(());
    };
    let stands_out = |line: &Line| spectrum.valley(main.frequency, line.frequency, weight) <= 0.5 * line.magnitude;
    let others: Vec<Line> = lines
        .iter()
        .filter(|line| *line != main && stands_out(line))
        .copied()
        .collect();
    let (inside, outside): (Vec<Line>, Vec<Line>) =
        (others.into_iter()).partition(|line| (low..=high).contains(&line.frequency));
    if let Some(line) = largest(&inside)
        && inside.len() <= 2
        && line.magnitude >= 0.1 * main.magnitude
        && beats(line.frequency - main.frequency)
    {
        return Err(Error::TwoModes {
            at: signal.at.clone(),
            first: main.frequency,
            second: line.frequency,
            ratio: line.magnitude / main.magnitude,
            low,
            high,
        });
    }
    if let Some(line) = largest(&outside)
        && !again
        && line.magnitude >= 0.01 * main.magnitude
    {
        warnings.push(Warning::OtherMode {
            frequency: line.frequency,
            ratio: line.magnitude / main.magnitude,
        });
    }
    Ok(())
}

/// Depth to which amplitude and phase are modulated at `frequency` (Hz; its sign counts): the amplitude of a second mode at
/// that distance over that of the first, averaged over the track under a Hann window. Taken from the rates, where slow
/// changes weigh less.
fn modulation(track: &Track, frequency: f64) -> f64 {
    let rates = track.rates();
    let points = track.inner();
    let (Some(first), Some(last)) = (points.times.first(), points.times.last()) else {
        return 0.0;
    };
    let mean = rates.iter().sum::<Complex64>() / rates.len() as f64;
    let (mut sum, mut weights) = (Complex64::default(), 0.0);
    for (time, rate) in points.times.iter().zip(&rates) {
        let weight = 0.5 - 0.5 * (TAU * (time - first) / (last - first)).cos();
        sum += weight * (rate - mean) * Complex64::cis(-TAU * frequency * time);
        weights += weight;
    }
    let omega = TAU * frequency;
    // Rates are differences over two periods.
    let span = 0.5 * omega * TAU * 2.0 / mean.im;
    (sum / weights).norm() / (omega * span.sin() / span).abs()
}

/// Warnings about a finished backbone.
fn observe(
    backbone: &[Point],
    peak: f64,
    bandwidth: f64,
    cross_check: Option<&CrossCheck>,
    warnings: &mut Vec<Warning>,
) {
    let distance = |p: &&Point| (p.frequency_hz - peak).abs();
    if let Some(point) = backbone.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)))
        && distance(&point) > 0.4 * bandwidth
    {
        let frequency = point.frequency_hz;
        warnings.push(Warning::NearBandEdge { frequency });
    }
    let points = backbone.iter().filter(|p| !(p.damping_ratio > 0.0)).count();
    if points > 0 {
        warnings.push(Warning::NegativeDamping { points });
    }
    match cross_check {
        None => warnings.push(Warning::NoCrossCheck),
        Some(check) if check.frequency_median > 1e-3 * peak || check.damping_median > 0.05 => {
            warnings.push(Warning::CrossCheckDiffers {
                frequency: check.frequency_median,
                damping: check.damping_median,
            });
        }
        Some(_) => {}
    }
}
