//! What a run found, in as few numbers as a reader needs: frequency and damping of each mode with their intervals, where slip begins, what
//! limits the result and whether it can be relied on.

use super::amplitudes::{BackboneSummary, Status};
use crate::dials::{Dial, DialError};
use crate::error_bar::ErrorBar;
use crate::uncertainty::{Band, Spread};
use crate::validity::Validity;
use crate::warnings::Warning;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Amplitudes that are answered where they are within the backbone (m).
const AMPLITUDES: [f64; 3] = [1e-6, 1e-5, 1e-4];

/// A backbone of at most so many amplitudes is answered at all of them.
const FEW: usize = 5;

/// Factor within which an amplitude is another one.
const BESIDE: f64 = 1.01;

/// Share of the area that slips as a whole from which slip has begun.
const ONSET: f64 = 0.01;

/// Numerical errors of the frequency (relative) and of the logarithm of damping up to which nothing is said, and beyond which a result is not
/// to be relied on.
const FREQUENCY: [f64; 2] = [0.01, 0.05];
const DAMPING: [f64; 2] = [0.2, 0.7];

/// What was found of a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Answer {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Frequency at small amplitude (Hz).
    pub frequency_hz: f64,
    /// Within which it is by the estimated numerical error (Hz); `null` where that is not known.
    pub frequency_interval_hz: Option<[f64; 2]>,
    /// Band of it by uncertain inputs (Hz), where samples of them were run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_band_hz: Option<[f64; 2]>,
    /// Amplitude of the response from which at least 1 % of the area of contact slips as a whole (m), interpolated; the smallest amplitude where
    /// it does so from the beginning, `null` where it does so nowhere.
    pub onset_amplitude_m: Option<f64>,
    /// Computed amplitudes between which it lies (m); `null` where it is the smallest of them, or there is none.
    pub onset_interval_m: Option<[f64; 2]>,
    /// Frequency and damping at the amplitudes of a backbone of five or fewer, else at 1, 10 and 100 um, as far as the backbone has them; at the nearer
    /// computed amplitude where the damping of one neighbour alone is above its floor.
    pub damping: Vec<AtAmplitude>,
    /// Whether it can be relied on.
    pub verdict: Verdict,
    /// Why not; or what limits it most.
    pub reason: String,
}

/// Frequency and damping at an amplitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AtAmplitude {
    /// Amplitude of the response (m).
    pub amplitude_m: f64,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Within which it is by the estimated numerical error, and between computed amplitudes by what else they allow (Hz).
    pub frequency_interval_hz: Option<[f64; 2]>,
    /// Band of it by uncertain inputs (Hz).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_band_hz: Option<[f64; 2]>,
    /// Total damping ratio (-); `null` below its floor.
    pub ratio: Option<f64>,
    /// Within which it is by the estimated numerical error, and between computed amplitudes by what else they allow.
    pub interval: Option<[f64; 2]>,
    /// Band of it by uncertain inputs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub band: Option<[f64; 2]>,
}

/// Whether a result can be relied on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing that is checked speaks against it.
    Sound,
    /// Something limits it, or its numerical error is not known.
    WithCare,
    /// A part did not converge, or its numerical error is large.
    NotReliable,
}

impl Verdict {
    /// For readers.
    pub fn words(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::WithCare => "with care",
            Self::NotReliable => "not reliable",
        }
    }
}

/// What an answer is made of.
pub(super) struct Found<'a> {
    /// The mode, counted from 1.
    pub(super) mode: usize,
    /// Its linearised frequency (Hz).
    pub(super) frequency_hz: f64,
    pub(super) backbone: &'a [BackboneSummary],
    pub(super) error_bar: &'a ErrorBar,
    /// By uncertain inputs: the linearised mode, and then amplitudes; empty without samples.
    pub(super) bands: &'a [Band],
    pub(super) warnings: &'a [Warning],
    pub(super) validity: &'a Validity,
}

/// The answer of a mode.
pub(super) fn answer(found: &Found<'_>) -> Answer {
    let of_mesh = DialError {
        frequency_relative: found.error_bar.frequency_relative,
        damping_ln: found.error_bar.damping_ln,
    };
    let error = |point: &BackboneSummary| match &point.error {
        // Without the part of the mesh it is none of the whole.
        Some(error) if of_mesh.frequency_relative.is_some() => DialError {
            frequency_relative: error.frequency_relative,
            damping_ln: error.damping_ln,
        },
        _ => of_mesh,
    };
    let linear_error = found
        .backbone
        .iter()
        .find(|point| point.converged)
        .map_or(of_mesh, error);
    let mut answered: Vec<Answered> = amplitudes(found.backbone)
        .into_iter()
        .filter_map(|amplitude| at(amplitude, found.backbone, found.bands, &error))
        .collect();
    answered.dedup_by(|a, b| a.at.amplitude_m == b.at.amplitude_m);
    let (verdict, reason) = judge(found, linear_error, &answered);
    let onset = onset(found.backbone);
    Answer {
        mode: found.mode,
        frequency_hz: found.frequency_hz,
        frequency_interval_hz: around(found.frequency_hz, linear_error.frequency_relative),
        frequency_band_hz: found.bands.first().and_then(|band| edges(&band.frequency_hz)),
        onset_amplitude_m: onset.map(|(amplitude, _)| amplitude),
        onset_interval_m: onset.and_then(|(_, between)| between),
        damping: answered.into_iter().map(|answered| answered.at).collect(),
        verdict,
        reason,
    }
}

/// A frequency less and more an error.
fn around(frequency: f64, relative: Option<f64>) -> Option<[f64; 2]> {
    relative.map(|error| [frequency * (1.0 - error), frequency * (1.0 + error)])
}

fn edges(spread: &Spread) -> Option<[f64; 2]> {
    let [low, _, high] = spread.quantiles;
    Some([low?, high?])
}

/// The amplitudes that are answered.
fn amplitudes(backbone: &[BackboneSummary]) -> Vec<f64> {
    let computed = backbone.iter().filter(|point| point.converged);
    let computed: Vec<f64> = computed.filter_map(|point| point.response_displacement).collect();
    match computed.as_slice() {
        all if all.len() <= FEW => computed,
        [first, .., last] => {
            // Amplitudes land beside those that a scene asks for.
            let near = AMPLITUDES
                .into_iter()
                .filter(|a| (first / BESIDE..=last * BESIDE).contains(a));
            let within: Vec<f64> = near.map(|a| a.clamp(*first, *last)).collect();
            match within.is_empty() {
                true => vec![*first, *last],
                false => within,
            }
        }
        _ => computed,
    }
}

/// The power through two positive numbers, `values`, at two amplitudes.
fn power(at: f64, [from, to]: [f64; 2], values: [f64; 2]) -> f64 {
    match values[0] == values[1] || from == to {
        true => values[0],
        false => values[0] * (at / from).powf((values[1] / values[0]).ln() / (to / from).ln()),
    }
}

/// An answer, and where its intervals come from.
struct Answered {
    at: AtAmplitude,
    /// Numerical errors of frequency (relative) and of the logarithm of damping.
    numerical: DialError,
    /// How much damping may differ from what is interpolated (logarithm).
    interpolated: f64,
}

/// The number at an amplitude between two computed ones, `below` and `above`, by the power through both, after the least and before the largest that the
/// ones beside them allow: a curve that bends one way lies between this power and the nearer of those through either and the next one beyond, one that
/// bends both ways between these two. `known` gives amplitude and number of a place.
fn interpolated(at: f64, [below, above]: [usize; 2], known: &dyn Fn(usize) -> Option<(f64, f64)>) -> Option<[f64; 3]> {
    let through = |from: usize, to: usize| {
        let ((from, low), (to, high)) = (known(from)?, known(to)?);
        Some(power(at, [from, to], [low, high]))
    };
    let own = through(below, above)?;
    if below == above {
        return Some([own; 3]);
    }
    let beside = [
        below.checked_sub(1).and_then(|before| through(before, below)),
        through(above, above + 1),
    ];
    let beside = beside.into_iter().flatten().filter(|number| number.is_finite());
    let least = beside.clone().filter(|number| *number < own).reduce(f64::max);
    let most = beside.filter(|number| *number > own).reduce(f64::min);
    Some([least.unwrap_or(own), own, most.unwrap_or(own)])
}

/// The answer at an amplitude within the backbone.
fn at(
    amplitude: f64,
    backbone: &[BackboneSummary],
    bands: &[Band],
    error: &dyn Fn(&BackboneSummary) -> DialError,
) -> Option<Answered> {
    let known: Vec<(f64, &BackboneSummary)> = backbone
        .iter()
        .filter(|point| point.converged)
        .filter_map(|point| Some((point.response_displacement?, point)))
        .collect();
    let above = known.iter().position(|(at, _)| *at >= amplitude)?;
    let mut places = [above.saturating_sub(usize::from(known[above].0 > amplitude)), above];
    let mut amplitude = amplitude;
    // Nothing is known of the damping between one that is known and one that is not.
    let has_damping = places.map(|place| known[place].1.damping_ratio.is_some());
    if has_damping[0] != has_damping[1] {
        let [below, above] = places.map(|place| known[place].0);
        let nearer = usize::from(above / amplitude < amplitude / below);
        places = [places[nearer]; 2];
        amplitude = known[places[nearer]].0;
    }
    let of = |value: &dyn Fn(&BackboneSummary) -> Option<f64>| {
        interpolated(amplitude, places, &|place| {
            let (at, point) = known.get(place)?;
            Some((*at, value(point)?))
        })
    };
    // The larger error of the two, as neither may stand for the other.
    let larger = |which: &dyn Fn(DialError) -> Option<f64>| {
        let [low, high] = places.map(|place| which(error(known[place].1)));
        Some(low?.max(high?))
    };
    let numerical = DialError {
        frequency_relative: larger(&|error| error.frequency_relative),
        damping_ln: larger(&|error| error.damping_ln),
    };
    let [least_hz, frequency_hz, most_hz] = of(&|point| point.frequency_hz)?;
    let ratio = of(&|point| point.damping_ratio).map(|[_, ratio, _]| ratio);
    let friction = of(&|point| point.friction_damping_ratio);
    let interval = || {
        let (ratio, [least, friction, most], error) = (ratio?, friction?, numerical.damping_ln?);
        let others = ratio - friction;
        Some([least * (-error).exp() + others, most * error.exp() + others])
    };
    Some(Answered {
        at: AtAmplitude {
            amplitude_m: amplitude,
            frequency_hz,
            frequency_interval_hz: (numerical.frequency_relative)
                .map(|error| [least_hz * (1.0 - error), most_hz * (1.0 + error)]),
            frequency_band_hz: band(amplitude, bands, &|band| edges(&band.frequency_hz)),
            ratio,
            interval: interval(),
            band: band(amplitude, bands, &|band| edges(&band.damping_ratio)),
        },
        numerical,
        interpolated: friction.map_or(0.0, |[least, own, most]| (own / least).max(most / own).ln()),
    })
}

/// A band at an amplitude.
fn band(amplitude: f64, bands: &[Band], of: &dyn Fn(&Band) -> Option<[f64; 2]>) -> Option<[f64; 2]> {
    // The first is that of the linearised mode.
    let known: Vec<&Band> = bands.iter().skip(1).collect();
    let above = known.iter().position(|band| band.response_displacement >= amplitude)?;
    let below = above.saturating_sub(usize::from(known[above].response_displacement > amplitude));
    let ends = [below, above].map(|place| known[place].response_displacement);
    let (low, high) = (of(known[below])?, of(known[above])?);
    let edge =
        |edge: usize| (low[edge] > 0.0 && high[edge] > 0.0).then(|| power(amplitude, ends, [low[edge], high[edge]]));
    Some([edge(0)?, edge(1)?])
}

/// The amplitude from which contact slips, and the computed amplitudes between which it is interpolated.
fn onset(backbone: &[BackboneSummary]) -> Option<(f64, Option<[f64; 2]>)> {
    let known = backbone
        .iter()
        .filter_map(|point| Some((point.response_displacement?, point.slip_fraction?)));
    let mut before: Option<(f64, f64)> = None;
    for (amplitude, share) in known {
        if share >= ONSET {
            let Some((from, less)) = before else {
                return Some((amplitude, None));
            };
            let part = (ONSET - less) / (share - less);
            return Some((from * (amplitude / from).powf(part), Some([from, amplitude])));
        }
        before = Some((amplitude, share));
    }
    None
}

/// What speaks against a result, the worst first; or what limits it.
fn judge(of: &Found<'_>, linear: DialError, answered: &[Answered]) -> (Verdict, String) {
    let mut found: Vec<(Verdict, String)> = Vec::new();
    let failed = of
        .backbone
        .iter()
        .filter(|point| !point.converged && point.status != Status::BelowRoundOff);
    let failed = failed.count();
    if failed > 0 {
        let all = of.backbone.len();
        found.push((
            Verdict::NotReliable,
            format!("{failed} of {all} amplitudes did not converge"),
        ));
    }
    let parts = parts(of.backbone);
    let by = |which: &dyn Fn(&DialError) -> Option<f64>| {
        let known = parts.iter().filter_map(|(dial, error)| Some((*dial, which(error)?)));
        let largest = known.max_by(|a, b| a.1.total_cmp(&b.1));
        largest.map_or("the mesh", |(dial, _)| cause(dial))
    };
    let frequency = answered.iter().filter_map(|one| one.numerical.frequency_relative);
    let frequency = frequency.chain(linear.frequency_relative).fold(0.0, f64::max);
    let with_damping = answered.iter().filter(|one| one.at.ratio.is_some());
    let damping = with_damping
        .filter_map(|one| one.numerical.damping_ln)
        .fold(0.0, f64::max);
    let of_frequency = format!(
        "the numerical error of the frequency is up to {:.1} %, most of it by {}",
        100.0 * frequency,
        by(&|error| error.frequency_relative)
    );
    let of_damping = format!(
        "the numerical error of the damping is up to {:.0} %, most of it by {}",
        100.0 * damping.exp_m1(),
        by(&|error| error.damping_ln)
    );
    for (error, limits, text) in [(frequency, FREQUENCY, &of_frequency), (damping, DAMPING, &of_damping)] {
        if error > limits[1] {
            found.push((Verdict::NotReliable, text.clone()));
        } else if error > limits[0] {
            found.push((Verdict::WithCare, text.clone()));
        }
    }
    let interpolated = answered.iter().map(|one| one.interpolated).fold(0.0, f64::max);
    if interpolated > DAMPING[0] {
        let text = format!(
            "between computed amplitudes the damping is known within a factor of {:.2}; more of them make it known better",
            interpolated.exp()
        );
        found.push((Verdict::WithCare, text));
    }
    let open = of.backbone.iter().filter(|point| point.closed == Some(false)).count();
    if open > 0 {
        let (all, cycles) = (
            of.backbone.len(),
            of.backbone.iter().filter_map(|point| point.cycles).max(),
        );
        let text = format!(
            "{open} of {all} loops did not close within {} cycles, so that their damping still changes from cycle to cycle",
            cycles.unwrap_or_default()
        );
        found.push((Verdict::WithCare, text));
    }
    found.extend(
        of.warnings
            .iter()
            .map(|warning| (Verdict::WithCare, warning.message.clone())),
    );
    let beyond = |number: Option<usize>, what: &str| {
        let at = of.backbone.get(number?.checked_sub(1)?)?.response_displacement?;
        Some((Verdict::WithCare, format!("from {:.3} um on {what}", 1e6 * at)))
    };
    let validity = of.validity;
    found.extend(beyond(validity.first_beyond_clearance, "bolts may touch their holes"));
    found.extend(beyond(
        validity.first_beyond_shape_deviation,
        "the shape of the mode changes with the amplitude",
    ));
    if [of.error_bar.frequency_relative, linear.frequency_relative].contains(&None) {
        found.push((
            Verdict::WithCare,
            format!("the numerical error is not known: {}", of.error_bar.source),
        ));
    } else if answered
        .iter()
        .any(|one| one.at.ratio.is_some() && one.at.interval.is_none())
    {
        found.push((
            Verdict::WithCare,
            "the numerical error of the damping is not known".into(),
        ));
    }
    let worst = found.iter().map(|(verdict, _)| *verdict).max();
    let first = worst.and_then(|worst| found.into_iter().find(|(verdict, _)| *verdict == worst));
    first.unwrap_or_else(|| {
        let limits = if damping > 20.0 * frequency {
            of_damping
        } else {
            of_frequency
        };
        (Verdict::Sound, limits)
    })
}

/// The largest error of every setting over the amplitudes.
fn parts(backbone: &[BackboneSummary]) -> BTreeMap<Dial, DialError> {
    let mut parts = BTreeMap::<Dial, DialError>::new();
    for (dial, error) in backbone
        .iter()
        .filter_map(|point| point.error.as_ref())
        .flat_map(|error| &error.of)
    {
        parts.entry(*dial).or_default().raise(error);
    }
    parts
}

/// What a setting is, to somebody who has not chosen it.
fn cause(dial: Dial) -> &'static str {
    match dial {
        Dial::Mesh => "the mesh",
        Dial::Modes => "the number of modes kept",
        Dial::Points => "the number of points of contact",
        Dial::Bins => "the number of groups of asperities",
        Dial::Radii => "the number of rings of an asperity",
        Dial::Vertices => "the number of points of a cycle",
        Dial::Equilibrium => "the tolerance of the equilibria",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_between_amplitudes_are_powers_of_them() {
        let at = |x: f64| 3.0 * x.powf(0.7);
        let found = power(2e-6, [1e-6, 1e-5], [at(1e-6), at(1e-5)]);
        assert!((found / at(2e-6) - 1.0).abs() < 1e-12);
        assert_eq!(power(1e-6, [1e-6, 1e-6], [3.0, 3.0]), 3.0);
    }

    #[test]
    fn a_bend_between_two_amplitudes_is_allowed_for() {
        // Flat up to 3e-6, and the third power from there on.
        let bent = |x: f64| 2e-6 * (x / 3e-6).max(1.0).powi(3);
        let known = [1e-6, 2e-6, 8e-6, 2e-5].map(|x| (x, bent(x)));
        for at in [2.5e-6, 3e-6, 4e-6, 6e-6] {
            let [least, _, most] = interpolated(at, [1, 2], &|place| known.get(place).copied()).unwrap();
            assert!(
                least * (1.0 - 1e-12) <= bent(at) && bent(at) <= most * (1.0 + 1e-12),
                "{at}: {least} {most}"
            );
        }
        let straight = known.map(|(x, _)| (x, 3.0 * x.powf(0.7)));
        let [least, _, most] = interpolated(4e-6, [1, 2], &|place| straight.get(place).copied()).unwrap();
        assert!(most / least - 1.0 < 1e-12);
        assert_eq!(
            interpolated(2e-6, [1, 1], &|place| known.get(place).copied()),
            Some([bent(2e-6); 3])
        );
    }
}
