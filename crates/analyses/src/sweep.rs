//! Sweeps: a harmonic load whose frequency changes at a given rate.
//!
//! A sweep that is slow finds the steady motions, and where the curve of these turns back it jumps to the branch that goes on. It is slow where the
//! frequency changes by less than the width of the resonance while a free motion dies away: `d omega/dt < zeta^2 omega^2 / pi`. A faster one
//! is followed in time, and its amplitude is that of the first harmonic over each period of the load.

use super::linearised::{Linearised, whole};
use crate::Error;
use cqsma_solver::transient::{self, MOST_STEPS, Transient};
use harmonic_balance::Failure;
use harmonic_balance::forced::{Curve, Point};
use harmonic_balance::points::Between;
use scenes::{Sweep, SweepRate};
use serde::{Deserialize, Serialize};
use std::f64::consts::{LN_2, TAU};
use std::ops::ControlFlow;

/// Steps per period of the load, and of the first mode followed, where it is followed in time.
const STEPS: f64 = 100.0;

/// Values per period of the load that its first harmonic is taken from.
const VALUES: usize = 64;

/// What a sweep finds.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Swept {
    /// Where it passes a resonance.
    pub resonances: Vec<SweptResonance>,
    /// Whether it is slow at each of them; not where the curve of steady motions ends early.
    pub is_slow: bool,
    /// Where a slow sweep jumps from one branch to another.
    pub jumps: Vec<Jump>,
    /// The sweep in time, where it is not slow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_time: Option<SweptInTime>,
}

/// A resonance that is passed.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SweptResonance {
    /// Its frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio of the motion there, by the energy that is put in (-).
    pub damping_ratio: f64,
    /// Rate of the sweep there (Hz/s).
    pub rate_hz_per_s: f64,
    /// Rate below which it is slow, `2 zeta^2 f^2` (Hz/s).
    pub limit_hz_per_s: f64,
}

/// A jump of a slow sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Jump {
    /// Its frequency (Hz).
    pub frequency_hz: f64,
    /// Amplitudes of the first harmonic of the displacement before and after it (m).
    pub amplitude: [f64; 2],
}

/// A sweep in time; lists run along its periods.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SweptInTime {
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Frequencies of the load in the middle of each period (Hz).
    pub frequency_hz: Vec<f64>,
    /// Amplitudes of the first harmonic of the displacement at the response point (m).
    pub amplitude: Vec<f64>,
    /// The largest: frequency (Hz) and amplitude (m).
    pub peak: Option<[f64; 2]>,
    /// Largest change of the balance of energies, relative to the largest energy in the motion (-).
    pub energy_error: f64,
    /// Steps of time.
    pub steps: usize,
    /// Steps that had to be halved.
    pub halved_steps: usize,
}

/// Frequency and phase of a load in time.
#[derive(Clone, Copy)]
struct Chirp {
    rate: SweepRate,
    /// First and last frequency (Hz).
    ends: [f64; 2],
}

impl Chirp {
    fn sign(&self) -> f64 {
        (self.ends[1] - self.ends[0]).signum()
    }

    /// How long it takes (s).
    fn duration(&self) -> f64 {
        let [from, to] = self.ends;
        match self.rate {
            SweepRate::Linear(rate) => (to - from).abs() / rate,
            SweepRate::Logarithmic(rate) => (to / from).log2().abs() / rate,
        }
    }

    /// Frequency at a time (Hz).
    fn frequency(&self, time: f64) -> f64 {
        match self.rate {
            SweepRate::Linear(rate) => self.ends[0] + self.sign() * rate * time,
            SweepRate::Logarithmic(rate) => self.ends[0] * (self.sign() * rate * time).exp2(),
        }
    }

    /// Periods that have passed at a time.
    fn periods(&self, time: f64) -> f64 {
        match self.rate {
            SweepRate::Linear(rate) => (self.ends[0] + 0.5 * self.sign() * rate * time) * time,
            SweepRate::Logarithmic(rate) => {
                let growth = self.sign() * rate * LN_2;
                self.ends[0] * (growth * time).exp_m1() / growth
            }
        }
    }

    /// Change of the frequency per second where it is `hz` (Hz/s).
    fn speed(&self, hz: f64) -> f64 {
        match self.rate {
            SweepRate::Linear(rate) => rate,
            SweepRate::Logarithmic(rate) => rate * LN_2 * hz,
        }
    }
}

/// Where a slow sweep jumps on a curve of frequencies (Hz) and amplitudes (m), and whether it passes each point.
fn slow(curve: &[[f64; 2]], sign: f64) -> (Vec<Jump>, Vec<bool>) {
    let mut jumps = Vec::new();
    let mut passed = vec![false; curve.len()];
    let mut last: Option<usize> = None;
    for (index, [f, _]) in curve.iter().enumerate() {
        if last.is_some_and(|last: usize| sign * (f - curve[last][0]) < 0.0) {
            continue;
        }
        if let Some(before) = last.filter(|before| before + 1 < index) {
            let at = curve[before][0];
            let [below, above] = [curve[index - 1], curve[index]];
            let part = (at - below[0]) / (above[0] - below[0]);
            jumps.push(Jump {
                frequency_hz: at,
                amplitude: [curve[before][1], below[1] + part * (above[1] - below[1])],
            });
        }
        passed[index] = true;
        last = Some(index);
    }
    (jumps, passed)
}

impl Linearised<'_> {
    /// What a sweep of a load finds, of which the curve of steady motions and its resonances are known; `load` is a row and its factor, `range` the angular
    /// frequencies of the ends (rad/s), and `observe` hears of the part that is done and may stop it.
    ///
    /// # Errors
    /// An interruption. A motion that cannot be followed in time is a result.
    pub(super) fn sweep(
        &self,
        sweep: &Sweep,
        (row, level): (&[f64], f64),
        range: [f64; 2],
        (curve, resonances): (&Curve, &[Result<Between, Failure>]),
        observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Swept, Error> {
        let chirp = Chirp {
            rate: sweep.rate(),
            ends: range.map(|omega| omega / TAU),
        };
        let of_point = |point: &Point| {
            let along = point.displacement.along(self.response);
            [point.omega / TAU, along[1].hypot(along[2])]
        };
        let points: Vec<[f64; 2]> = curve.points.iter().map(of_point).collect();
        let (jumps, passed) = slow(&points, chirp.sign());
        // Resonances are points of the curve.
        let is_passed =
            |omega: f64| (curve.points.iter().zip(&passed)).any(|(point, passed)| *passed && point.omega == omega);
        let found = resonances.iter().filter_map(|found| found.as_ref().ok());
        let found: Vec<SweptResonance> = found
            .filter(|found| is_passed(found.point.omega))
            .map(|found| {
                let (f, zeta) = (found.point.omega / TAU, found.point.damping_ratio);
                SweptResonance {
                    frequency_hz: f,
                    damping_ratio: zeta,
                    rate_hz_per_s: chirp.speed(f),
                    limit_hz_per_s: 2.0 * (zeta * f).powi(2),
                }
            })
            .collect();
        let is_slow = curve.failure.is_none()
            && resonances.iter().all(Result::is_ok)
            && found.iter().all(|at| at.rate_hz_per_s < at.limit_hz_per_s);
        let in_time = match is_slow {
            true => None,
            false => Some(match self.sweep_in_time(chirp, row, level, observe) {
                Ok(found) => found,
                Err(Error::Solver(cqsma_solver::Error::Interrupted)) => {
                    return Err(cqsma_solver::Error::Interrupted.into());
                }
                Err(error) => SweptInTime {
                    failure: Some(error.to_string()),
                    ..SweptInTime::default()
                },
            }),
        };
        Ok(Swept {
            resonances: found,
            is_slow,
            jumps,
            in_time,
        })
    }

    fn sweep_in_time(
        &self,
        chirp: Chirp,
        row: &[f64],
        level: f64,
        observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<SweptInTime, Error> {
        let mode = self.scene.analyses.modes.followed[0] - 1;
        let own = self.line.frequencies()[mode];
        let highest = chirp.ends[0].max(chirp.ends[1]).max(own);
        let steps_per_period = (STEPS * highest / own).ceil();
        let step = 1.0 / (own * steps_per_period);
        let wanted = chirp.duration();
        let steps = (wanted / step).ceil();
        // Also catches what is not finite.
        if !(steps <= MOST_STEPS as f64) {
            return Err(Error::Sweep { steps });
        }
        let periods = (steps / steps_per_period).ceil() as usize;
        let start = transient::Start::Record {
            step,
            values: (1..=steps as usize)
                .map(|k| level * (TAU * chirp.periods(k as f64 * step)).sin())
                .collect(),
            point: row.to_vec(),
        };
        let solver = transient::Settings {
            mode,
            steps_per_period: steps_per_period as usize,
            periods,
            background_damping: self.scene.background_damping,
            ..transient::Settings::default()
        };
        let found = transient::run(self.line, self.force, self.response, &start, &solver, &mut |sample| {
            observe((sample.time / wanted).min(1.0))
        })?;
        let found = whole(found, wanted)?;
        let (frequency_hz, amplitude) = first_harmonics(&found, chirp);
        let peak = amplitude.iter().zip(&frequency_hz).max_by(|a, b| a.0.total_cmp(b.0));
        Ok(SweptInTime {
            failure: None,
            peak: peak.map(|(a, f)| [*f, *a]),
            frequency_hz,
            amplitude,
            energy_error: found.energy_error(),
            steps: found.samples.len().saturating_sub(1),
            halved_steps: found.halved_steps,
        })
    }
}

/// Frequency in the middle (Hz) and amplitude of the first harmonic (m) of each whole period of the load.
fn first_harmonics(motion: &Transient, chirp: Chirp) -> (Vec<f64>, Vec<f64>) {
    let (samples, duration) = (&motion.samples, chirp.duration());
    let phases: Vec<f64> = samples.iter().map(|sample| chirp.periods(sample.time)).collect();
    let count = chirp.periods(duration).floor() as usize;
    let mut after = 0;
    let (mut frequencies, mut amplitudes) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for period in 0..count {
        let (mut cosine, mut sine, mut middle) = (0.0, 0.0, 0.0);
        for value in 0..VALUES {
            let phase = period as f64 + value as f64 / VALUES as f64;
            while after < phases.len() && phases[after] <= phase {
                after += 1;
            }
            let (Some(before), true) = (after.checked_sub(1), after < phases.len()) else {
                return (frequencies, amplitudes);
            };
            let part = (phase - phases[before]) / (phases[after] - phases[before]);
            let between = |of: &dyn Fn(usize) -> f64| of(before) + part * (of(after) - of(before));
            let displacement = between(&|at| samples[at].displacement);
            if value == VALUES / 2 {
                middle = between(&|at| samples[at].time);
            }
            let (s, c) = (TAU * phase).sin_cos();
            cosine += c * displacement;
            sine += s * displacement;
        }
        frequencies.push(chirp.frequency(middle));
        amplitudes.push(2.0 / VALUES as f64 * f64::hypot(cosine, sine));
    }
    (frequencies, amplitudes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_sweep_leaves_a_branch_where_it_turns_back_and_goes_on_above_or_below() {
        let curve = [
            [1.0, 1.0],
            [2.0, 2.0],
            [3.0, 5.0],
            [2.6, 4.0],
            [2.4, 2.5],
            [2.8, 1.5],
            [3.2, 1.0],
            [4.0, 0.5],
        ];
        let (jumps, passed) = slow(&curve, 1.0);
        assert_eq!(passed, [true, true, true, false, false, false, true, true]);
        assert_eq!(jumps.len(), 1);
        assert_eq!((jumps[0].frequency_hz, jumps[0].amplitude[0]), (3.0, 5.0));
        assert!((jumps[0].amplitude[1] - 1.25).abs() < 1e-12);
        // The same from above jumps up.
        let back: Vec<[f64; 2]> = curve.into_iter().rev().collect();
        let (jumps, _) = slow(&back, -1.0);
        assert_eq!(jumps.len(), 1);
        assert_eq!((jumps[0].frequency_hz, jumps[0].amplitude[0]), (2.4, 2.5));
        assert!((jumps[0].amplitude[1] - (2.0 + 0.4 * 3.0)).abs() < 1e-12);
        assert!(slow(&[[1.0, 1.0], [2.0, 2.0]], 1.0).0.is_empty());
    }

    #[test]
    fn phases_are_integrals_of_frequencies() {
        for (rate, ends) in [
            (SweepRate::Linear(3.0), [20.0, 50.0]),
            (SweepRate::Linear(3.0), [50.0, 20.0]),
            (SweepRate::Logarithmic(0.2), [20.0, 50.0]),
            (SweepRate::Logarithmic(0.2), [50.0, 20.0]),
        ] {
            let chirp = Chirp { rate, ends };
            let duration = chirp.duration();
            assert!((chirp.frequency(duration) / ends[1] - 1.0).abs() < 1e-12);
            let n = 20_000;
            let step = duration / f64::from(n);
            let sum: f64 = (0..n).map(|k| chirp.frequency((f64::from(k) + 0.5) * step)).sum();
            assert!((chirp.periods(duration) / (sum * step) - 1.0).abs() < 1e-8);
            let [a, b] = [0.3, 0.3001].map(|part| chirp.frequency(part * duration));
            assert!(((b - a).abs() / (1e-4 * duration) / chirp.speed(a) - 1.0).abs() < 1e-4);
        }
    }
}
