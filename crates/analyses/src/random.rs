//! Stationary random vibration of a scene's structure about its static state, from the backbones of the modes followed.

use super::connections::Connection;
use super::linearised::{Base, Drive, Linearised, flow, whole};
use super::mode_backbone::ModeAnalysis;
use super::vibration::{Start, VibrationAnalysis};
use crate::Error;
use cqsma_solver::HystereticForce;
use cqsma_solver::random::{AmplitudeCurve, Equivalent, Oscillator, Spectrum, Squares, Transfer, dissipated_power};
use cqsma_solver::transient::{self, Sample};
use joints::progress::{Stage, go_on};
use joints::store::checkpoint::Checkpoints;
use modal_identification::synthetic;
use scenes::{Random, RandomInTime};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Largest share of `E[a^2]` that amplitudes beyond the backbone may have.
const MOST_BEYOND: f64 = 0.05;

/// Largest sum of the half-power widths of two modes over the distance of their frequencies.
const MOST_OVERLAP: f64 = 0.3;

/// Largest damping ratio of a narrow band.
const MOST_DAMPING: f64 = 0.1;

/// Largest ratio of the load's densities where the natural frequency wanders.
const MOST_SLOPE: f64 = 1.5;

/// How closely the flexibility under a slow load is found (energy norm).
const STATIC: f64 = 1e-9;

impl VibrationAnalysis for Random {
    type Found = Result<Vec<RandomVibration>, RandomFailure>;

    /// The stationary states at all levels.
    fn run(&self, start: Start<'_>) -> Result<(Self::Found, Checkpoints), Error> {
        let Start {
            about, modes, progress, ..
        } = start;
        progress.begin(Stage::Random);
        let drive = about.drive(&self.excitation());
        let spectrum = Spectrum::try_new(self.psd.iter().map(|(f, s)| [*f, *s]).collect())?;
        let found = match Followed::all(&about, &drive, modes) {
            Err(failure) => Err(failure),
            Ok(followed) => {
                let vibrating = Vibrating::new(&about, &drive, followed)?;
                let levels = self.levels.iter().enumerate().map(|(number, &level)| {
                    go_on(progress)?;
                    let mut found = vibrating.at(level, &spectrum);
                    let share =
                        |done: f64| progress.fraction(Stage::Random, (number as f64 + done) / self.levels.len() as f64);
                    if let Some(asked) = self.in_time.filter(|_| level > 0.0) {
                        let noise = Noise {
                            level,
                            spectrum: &spectrum,
                            drive: &drive,
                            damping: found.modes[0].equivalent.zeta,
                        };
                        let followed = about.in_time(&asked, &noise, &|done| {
                            share(done);
                            flow(progress)
                        });
                        go_on(progress)?;
                        found.in_time = Some(followed.map_err(|error| error.to_string()));
                    }
                    share(1.0);
                    Ok(found)
                });
                Ok(levels.collect::<Result<_, Error>>()?)
            }
        };
        progress.end(Stage::Random);
        Ok((found, Checkpoints::default()))
    }
}

/// Why there is no stationary state: a mode without a backbone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RandomFailure {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Its amplitudes with a damping ratio.
    pub amplitudes: usize,
}

impl std::fmt::Display for RandomFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "mode {} has {} amplitudes with a resolved damping ratio, and random vibration needs two; follow it over larger amplitudes, or give \
             background_damping",
            self.mode, self.amplitudes
        )
    }
}

/// Stationary random vibration at a level.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomVibration {
    /// Factor of the load's amplitude.
    pub level: f64,
    /// Root of the load's mean square.
    pub rms_load: f64,
    /// The modes: those followed first.
    pub modes: Vec<RandomMode>,
    /// Mean squares of the motion of the response point.
    pub squares: Squares,
    /// Frequencies (Hz) and densities of that motion.
    pub densities: Vec<(f64, Squares)>,
    /// Mean power that friction takes at each interface (W).
    pub power: Vec<f64>,
    /// Root of the mean square of the largest sliding anywhere (m).
    pub rms_sliding: f64,
    /// What each connection does, in the order of the run's.
    pub connections: Vec<RandomConnection>,
    /// What each interface element does.
    pub elements: RandomElements,
    /// Whether what is assumed holds.
    pub validity: RandomValidity,
    /// A motion in time under such a load, where it is asked for, or why there is none.
    pub in_time: Option<Result<InTime, String>>,
}

/// Interface elements in stationary random vibration, by the modes followed. The root mean squares are those of vibrations that reach, at each amplitude,
/// the largest value that the loop of that amplitude has.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomElements {
    /// Mean power per area that friction takes (W/m^2). Between the amplitudes of the backbone each element is interpolated on its own: their sum, which would
    /// differ by that, is brought to the power of the interfaces.
    pub power: Vec<f64>,
    /// Root of the mean square of the tangential motion (m).
    pub sliding: Vec<f64>,
    /// Root of the mean square of the change of the tangential traction (Pa).
    pub traction: Vec<f64>,
}

/// A connection in stationary random vibration: motion and force are those along the direction of its loops.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RandomConnection {
    /// Root of the mean square of its motion (m).
    pub displacement: f64,
    /// Root of the mean square of its tangential force (N).
    pub force: f64,
    /// Mean power that friction takes in it (W).
    pub power: f64,
}

/// A mode in stationary random vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomMode {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Whether frequency and damping are those of its backbone; otherwise those of the linear mode with the background damping alone.
    pub follows_backbone: bool,
    /// The oscillator that stands for it.
    pub equivalent: Equivalent,
    /// Root of the mean square of the displacement at the response point by this mode alone (m).
    pub rms: f64,
}

/// Whether the assumptions of equivalent linearisation hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RandomValidity {
    /// Whether all of them do.
    pub holds: bool,
    /// Largest share of a mode's mean square by amplitudes below and above its backbone, where the values at its ends are taken (-).
    pub share_beyond_backbone: [f64; 2],
    /// Root of the mean square of a natural frequency's deviation over its mean, the largest of all modes (-).
    pub frequency_spread: f64,
    /// Largest ratio of the load's densities within twice that about a mode (-).
    pub load_slope: f64,
    /// Largest sum of the half-power widths of two modes over the distance of their frequencies (-).
    pub overlap: f64,
    /// Share of the response point's flexibility under a slow load that the modes do not have; it answers statically (-); `null` where it was not found.
    pub static_share: Option<f64>,
    /// What does not hold, and what can be done.
    pub reasons: Vec<String>,
}

/// Periods of decay that a motion from rest is given to become stationary: amplitudes within a thousandth.
const SETTLING: f64 = 7.0;

/// Blocks that a motion is divided into for the spread of its mean squares, and the quantile of Student's distribution that holds 90 % for so many.
const BLOCKS: usize = 20;
const STUDENT: f64 = 1.729;

/// What a motion in time under stationary noise shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InTime {
    /// Root mean square of the displacement of the response point (m).
    pub rms_response: f64,
    /// Interval that holds it with a probability of 90 %, from the spread of 20 blocks (m).
    pub rms_response_interval: [f64; 2],
    /// Root mean square of its acceleration (m/s^2), that of the supports included.
    pub rms_acceleration: f64,
    /// As that of the displacement (m/s^2).
    pub rms_acceleration_interval: [f64; 2],
    /// Share of the load's mean square below half the rate of steps, which is all that acts (-).
    pub share_of_load: f64,
    /// Time that was averaged over (s), after the motion had become stationary.
    pub averaged_s: f64,
    /// Largest change of the balance of energies, relative to the largest energy in the motion (-).
    pub energy_error: f64,
}

/// A stationary load in time.
struct Noise<'a> {
    level: f64,
    spectrum: &'a Spectrum,
    drive: &'a Drive,
    /// Damping ratio of the first mode followed.
    damping: f64,
}

impl Linearised<'_> {
    /// Follows the motion under noise; `observe` hears of the share that is done.
    fn in_time(
        &self,
        asked: &RandomInTime,
        noise: &Noise<'_>,
        observe: &dyn Fn(f64) -> ControlFlow<()>,
    ) -> Result<InTime, Error> {
        let mode = self.scene.analyses.modes.followed[0] - 1;
        let frequency = self.line.frequencies()[mode];
        let settling = (SETTLING / (TAU * noise.damping)).ceil() as usize;
        if asked.periods < 2 * settling {
            return Err(Error::Random {
                reason: format!(
                    "at a damping ratio of {:.1e} a motion becomes stationary after {settling} periods; follow at least twice as many \
                     (analyses.random.in_time.periods)",
                    noise.damping
                ),
            });
        }
        let step = 1.0 / (frequency * asked.steps_per_period as f64);
        let count = asked.periods * asked.steps_per_period;
        let scale = noise.level * noise.level;
        let start = transient::Start::Record {
            step,
            values: synthetic::stationary(|f| scale * noise.spectrum.density(f), step, count, asked.seed),
            point: noise.drive.row.clone(),
        };
        let solver = transient::Settings {
            mode,
            steps_per_period: asked.steps_per_period,
            periods: asked.periods,
            background_damping: self.scene.background_damping,
            ..transient::Settings::default()
        };
        let wanted = asked.periods as f64 / frequency;
        let found = transient::run(self.line, self.force, self.response, &start, &solver, &mut |sample| {
            observe(sample.time / wanted)
        })?;
        let energy_error = found.energy_error();
        let found = whole(found, wanted)?;
        let carried = noise.drive.base.map_or(0.0, |base| base.carried);
        let stationary = &found.samples[settling * asked.steps_per_period..];
        let squares = |value: &dyn Fn(&Sample) -> f64| {
            let length = stationary.len() / BLOCKS;
            let of_block = |block: &[Sample]| block.iter().map(|s| value(s).powi(2)).sum::<f64>() / block.len() as f64;
            let means: Vec<f64> = stationary.chunks_exact(length).take(BLOCKS).map(of_block).collect();
            let mean = means.iter().sum::<f64>() / BLOCKS as f64;
            let spread = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (BLOCKS - 1) as f64;
            let reach = STUDENT * (spread / BLOCKS as f64).sqrt();
            (mean.sqrt(), [(mean - reach).max(0.0).sqrt(), (mean + reach).sqrt()])
        };
        let (rms_response, rms_response_interval) = squares(&|s| s.displacement);
        let (rms_acceleration, rms_acceleration_interval) =
            squares(&|s| s.acceleration + carried * start.force_at(s.time));
        Ok(InTime {
            rms_response,
            rms_response_interval,
            rms_acceleration,
            rms_acceleration_interval,
            share_of_load: noise.spectrum.mean_square_below(0.5 / step) / noise.spectrum.mean_square(),
            averaged_s: stationary.len() as f64 * step,
            energy_error,
        })
    }
}

/// A mode followed, as random vibration needs it.
struct Followed {
    /// From zero.
    mode: usize,
    curve: AmplitudeCurve,
    /// Power that friction takes at each interface over the square of the amplitude, at the amplitudes of the curve (W/(kg m^2)).
    power: Vec<Vec<f64>>,
    /// Square of the motion of the response point over that of the amplitude (1/kg): it is not that of the linear mode, whose shape slip changes.
    motion: Vec<f64>,
    /// Square of the largest sliding over that of the amplitude (1/kg).
    sliding: Vec<f64>,
    /// Of each connection, over the square of the amplitude: squares of motion (1/kg) and force (N^2/(kg m^2)), and power (W/(kg m^2)).
    connections: Vec<[Vec<f64>; 3]>,
    /// The same of each interface element and area: squares of motion (1/kg) and traction (Pa^2/(kg m^2)), and power (W/(kg m^4)).
    elements: Vec<[Vec<f64>; 3]>,
    load: f64,
    response: f64,
}

impl Followed {
    fn all(about: &Linearised<'_>, drive: &Drive, modes: &[ModeAnalysis]) -> Result<Vec<Self>, RandomFailure> {
        modes.iter().map(|mode| Self::of(about, drive, mode)).collect()
    }

    fn of(about: &Linearised<'_>, drive: &Drive, of: &ModeAnalysis) -> Result<Self, RandomFailure> {
        let mode = of.mode - 1;
        let background = of.background;
        let mut points: Vec<[f64; 3]> = Vec::new();
        let (mut power, mut sliding, mut motion) = (Vec::<Vec<f64>>::new(), Vec::new(), Vec::new());
        let (mut connections, mut elements) = (Vec::<[Vec<f64>; 3]>::new(), Vec::<[Vec<f64>; 3]>::new());
        for amplitude in &of.amplitudes {
            let (Ok(result), Some(fields)) = (&amplitude.point.result, &amplitude.fields) else {
                continue;
            };
            // Stored with every amplitude of a scene that asks for random vibration.
            let Some(motions) = &fields.elements else {
                continue;
            };
            let (a, omega) = (result.modal_amplitude, result.harmonic_omega);
            let friction = if result.is_resolved() {
                result.harmonic_zeta()
            } else {
                0.0
            };
            let ascends = points.last().is_none_or(|before| a > before[0]);
            if !(ascends && friction + background > 0.0) {
                continue;
            }
            points.push([a, omega, friction + background]);
            // Energy of a period over its duration.
            let rate = omega / TAU / (a * a);
            power.push(match fields.joints.as_slice() {
                [] => vec![rate * fields.dissipation],
                joints => joints.iter().map(|joint| rate * joint.dissipation).collect(),
            });
            let over = |[motion, force, dissipation]: [f64; 3]| {
                [(motion / a).powi(2), (force / a).powi(2), rate * dissipation]
            };
            let of_connections = fields.connections.iter();
            let of_connections = of_connections.map(|c| over([c.displacement, c.force, c.dissipation]));
            keep(&mut connections, of_connections);
            let of_elements = motions.sliding.iter().zip(&motions.traction).zip(&motions.dissipation);
            keep(&mut elements, of_elements.map(|((m, t), d)| over([*m, *t, *d])));
            sliding.push((fields.largest_sliding / a).powi(2));
            motion.push((fields.response_motion / a).powi(2));
        }
        let amplitudes = points.len();
        let failure = RandomFailure {
            mode: of.mode,
            amplitudes,
        };
        let curve = AmplitudeCurve::try_new(&points).map_err(|_| failure)?;
        if amplitudes < 2 {
            return Err(failure);
        }
        let shape = about.line.shapes.col_as_slice(mode);
        let along = |row: &[f64]| row.iter().zip(shape).map(|(a, b)| a * b).sum();
        Ok(Self {
            mode,
            curve,
            power: (0..power[0].len())
                .map(|joint| power.iter().map(|of| of[joint]).collect())
                .collect(),
            sliding,
            connections,
            elements,
            motion,
            load: along(&drive.row),
            response: along(about.response),
        })
    }
}

/// Appends what was found at an amplitude to the lists of each place.
fn keep(lists: &mut Vec<[Vec<f64>; 3]>, found: impl ExactSizeIterator<Item = [f64; 3]>) {
    lists.resize(found.len(), Default::default());
    for (lists, values) in lists.iter_mut().zip(found) {
        lists.iter_mut().zip(values).for_each(|(list, value)| list.push(value));
    }
}

/// A structure that vibrates under a random load.
struct Vibrating {
    followed: Vec<Followed>,
    /// Linear modes that are damped, with their numbers from zero.
    linear: Vec<(usize, Oscillator)>,
    /// Flexibility of the response point under a slow load, and what of it the modes do not have; none where it was not found.
    slow: Option<[f64; 2]>,
    base: Option<Base>,
    /// Areas of the interface elements (m^2).
    areas: Vec<f64>,
    /// Rigid motions that the modes do not have.
    rigid_motions: usize,
    /// Whether modes that are not followed have no damping, and answer statically.
    undamped: bool,
}

impl Vibrating {
    fn new(about: &Linearised<'_>, drive: &Drive, followed: Vec<Followed>) -> Result<Self, Error> {
        let line = about.line;
        let along = |row: &[f64], shape: &[f64]| row.iter().zip(shape).map(|(a, b)| a * b).sum::<f64>();
        let others = (0..line.eigenvalues.len()).filter(|mode| followed.iter().all(|of| of.mode != *mode));
        let linear: Vec<(usize, Oscillator)> = others
            .map(|mode| {
                let shape = line.shapes.col_as_slice(mode);
                let oscillator = Oscillator {
                    omega: line.eigenvalues[mode].max(0.0).sqrt(),
                    zeta: about.background(mode),
                    load: along(&drive.row, shape),
                    response: along(about.response, shape),
                };
                (mode, oscillator)
            })
            .filter(|(_, oscillator)| oscillator.zeta > 0.0)
            .collect();
        let slow = line.tangent_response(about.force.pattern(), line.stuck_tangent(), &drive.row, STATIC)?;
        let of_modes = followed
            .iter()
            .map(|of| of.load * of.response / line.eigenvalues[of.mode]);
        let of_linear = linear
            .iter()
            .map(|(_, own)| own.load * own.response / (own.omega * own.omega));
        let of_modes: f64 = of_modes.chain(of_linear).sum();
        Ok(Self {
            slow: slow.map(|(displacement, _)| {
                let flexibility = along(about.response, &displacement);
                [flexibility, flexibility - of_modes]
            }),
            undamped: followed.len() + linear.len() < line.eigenvalues.len(),
            followed,
            linear,
            base: drive.base,
            areas: {
                let operators = about.force.interface().operators();
                (0..operators.n_elements())
                    .map(|element| operators.element_area(element))
                    .collect()
            },
            rigid_motions: about.vibrating.zem_stuck,
        })
    }

    fn at(&self, level: f64, unit: &Spectrum) -> RandomVibration {
        // A level of zero is rest, of which the spectrum is none.
        let scale = level * level;
        let spectrum = unit.scaled(if scale > 0.0 { scale } else { 1.0 });
        let load = |load: f64| if scale > 0.0 { load } else { 0.0 };
        let mut modes = Vec::new();
        let mut oscillators = Vec::new();
        let mut power = vec![0.0; self.followed.first().map_or(0, |of| of.power.len())];
        let mut sliding = 0.0;
        // Mean squares of motion and force, and power.
        let zeros =
            |of: fn(&Followed) -> &Vec<[Vec<f64>; 3]>| vec![[0.0; 3]; self.followed.first().map_or(0, |f| of(f).len())];
        let (mut connections, mut elements) = (zeros(|of| &of.connections), zeros(|of| &of.elements));
        for of in &self.followed {
            let equivalent = of.curve.stationary(load(of.load), &spectrum);
            let square = equivalent.sigma * equivalent.sigma;
            let mean = of.curve.means(equivalent.white);
            for (sum, values) in power.iter_mut().zip(&of.power) {
                *sum += 2.0 * square * mean(values);
            }
            sliding += square * mean(&of.sliding);
            let of_connections = connections.iter_mut().zip(&of.connections);
            for (sums, values) in of_connections.chain(elements.iter_mut().zip(&of.elements)) {
                for ((sum, values), times) in sums.iter_mut().zip(values).zip([1.0, 1.0, 2.0]) {
                    *sum += times * square * mean(values);
                }
            }
            let response = mean(&of.motion).sqrt().copysign(of.response);
            modes.push(RandomMode {
                mode: of.mode + 1,
                follows_backbone: true,
                rms: equivalent.sigma * response.abs(),
                equivalent,
            });
            oscillators.push(Oscillator {
                omega: equivalent.omega,
                zeta: equivalent.zeta,
                load: load(of.load),
                response,
            });
        }
        let of_elements: f64 = elements
            .iter()
            .zip(&self.areas)
            .map(|([.., power], area)| power * area)
            .sum();
        if of_elements > 0.0 {
            let factor = power.iter().sum::<f64>() / of_elements;
            elements.iter_mut().for_each(|[.., power]| *power *= factor);
        }
        for (mode, oscillator) in &self.linear {
            let oscillator = Oscillator {
                load: load(oscillator.load),
                ..*oscillator
            };
            let sigma = oscillator.mean_square(&spectrum).sqrt();
            modes.push(RandomMode {
                mode: mode + 1,
                follows_backbone: false,
                rms: sigma * oscillator.response.abs(),
                equivalent: Equivalent {
                    sigma,
                    omega: oscillator.omega,
                    zeta: oscillator.zeta,
                    white: 0.0,
                    beyond: [0.0; 2],
                    spread: 0.0,
                    others: false,
                },
            });
            oscillators.push(oscillator);
        }
        let transfer = Transfer {
            oscillators,
            remainder: load(self.slow.map_or(0.0, |[_, remainder]| remainder)),
            carried: load(self.base.map_or(0.0, |base| base.carried)),
        };
        RandomVibration {
            level,
            rms_load: level * unit.mean_square().sqrt(),
            squares: transfer.mean_squares(&spectrum),
            densities: transfer.densities(&spectrum),
            power,
            rms_sliding: sliding.sqrt(),
            connections: connections
                .into_iter()
                .map(|[displacement, force, power]| RandomConnection {
                    displacement: displacement.sqrt(),
                    force: force.sqrt(),
                    power,
                })
                .collect(),
            elements: RandomElements {
                sliding: elements.iter().map(|[motion, ..]| motion.sqrt()).collect(),
                traction: elements.iter().map(|[_, traction, _]| traction.sqrt()).collect(),
                power: elements.iter().map(|[.., power]| *power).collect(),
            },
            validity: self.validity(&modes, &spectrum),
            in_time: None,
            modes,
        }
    }

    fn validity(&self, modes: &[RandomMode], spectrum: &Spectrum) -> RandomValidity {
        let own = || {
            modes
                .iter()
                .filter(|mode| mode.follows_backbone)
                .map(|mode| mode.equivalent)
        };
        let largest = |value: &dyn Fn(Equivalent) -> f64| own().map(value).fold(0.0, f64::max);
        let slope = |of: Equivalent| {
            let [from, to] = [-2.0, 2.0].map(|times| of.omega / TAU * (1.0 + times * of.spread));
            let [first, last] = spectrum.band();
            if to < first || from > last {
                return 1.0;
            }
            let ends = [from, 0.5 * (from + to), to].map(|f| spectrum.density(f));
            let [low, high] = [
                ends.iter().copied().fold(f64::INFINITY, f64::min),
                ends.iter().copied().fold(0.0, f64::max),
            ];
            high / low
        };
        let overlap = |(i, a): (usize, &RandomMode)| {
            let others = modes.iter().enumerate().filter(move |(j, _)| i != *j);
            others
                .map(|(_, b)| {
                    let (a, b) = (a.equivalent, b.equivalent);
                    2.0 * (a.zeta * a.omega + b.zeta * b.omega) / (a.omega - b.omega).abs()
                })
                .fold(0.0, f64::max)
        };
        let followed = modes.iter().enumerate().filter(|(_, mode)| mode.follows_backbone);
        let found = RandomValidity {
            share_beyond_backbone: [0, 1].map(|end| largest(&|of| of.beyond[end])),
            frequency_spread: largest(&|of| of.spread),
            load_slope: largest(&slope),
            overlap: followed.map(overlap).fold(0.0, f64::max),
            static_share: self
                .slow
                .map(|[all, remainder]| if all == 0.0 { 0.0 } else { (remainder / all).abs() }),
            ..RandomValidity::default()
        };
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let [below, above] = found.share_beyond_backbone;
        let damping = largest(&|of| of.zeta);
        let is_at_rest = own().all(|of| of.sigma == 0.0);
        let mut reasons = Vec::new();
        let mut unless = |holds: bool, reason: String| {
            if !holds {
                reasons.push(reason);
            }
        };
        unless(
            below <= MOST_BEYOND || is_at_rest,
            format!(
                "{} of the mean square belong to amplitudes below the backbone, where its first damping ratio is taken; begin it lower \
                 (analyses.backbone.amplitude_from)",
                percent(below)
            ),
        );
        unless(
            above <= MOST_BEYOND,
            format!(
                "{} of the mean square belong to amplitudes above the backbone, where its last values are taken; end it higher \
                 (analyses.backbone.amplitude_to)",
                percent(above)
            ),
        );
        unless(
            damping <= MOST_DAMPING,
            format!("a damping ratio of {damping:.2} makes no narrow band; follow the motion in time"),
        );
        unless(
            found.load_slope <= MOST_SLOPE,
            format!(
                "the density of the load changes by a factor of {:.1} where a natural frequency wanders by {:.1e} of itself; follow the motion in time",
                found.load_slope, found.frequency_spread
            ),
        );
        unless(
            found.overlap <= MOST_OVERLAP,
            format!(
                "modes overlap by {:.2} of the distance between them; their amplitudes are not independent",
                found.overlap
            ),
        );
        unless(
            own().all(|of| !of.others),
            "there are several stationary states, of which the smallest is given".to_owned(),
        );
        unless(
            self.rigid_motions == 0 || self.base.is_some(),
            format!(
                "{} rigid motions of the structure are not counted; only its deformation is",
                self.rigid_motions
            ),
        );
        unless(
            self.slow.is_some(),
            "the flexibility under a slow load was not found; what the modes do not have is left out".to_owned(),
        );
        unless(
            !self.undamped,
            "modes that are not followed have no damping and answer statically; give background_damping, or follow them (analyses.modes.followed)"
                .to_owned(),
        );
        RandomValidity {
            holds: reasons.is_empty(),
            reasons,
            ..found
        }
    }
}

/// Stationary random vibration at a level.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RandomSummary {
    /// Factor of the load's amplitude.
    pub level: f64,
    /// Root mean square of the load (N), or of the acceleration of the supports (m/s^2).
    pub rms_load: f64,
    /// Its unit: `N` or `m/s^2`.
    pub load_unit: String,
    /// The modes: those followed first, then the linear ones that are damped.
    pub modes: Vec<RandomModeSummary>,
    /// Root mean square of the displacement of the response point from its static position (m), against the supports where they move.
    pub rms_response: f64,
    /// Of its velocity (m/s).
    pub rms_velocity: f64,
    /// Of its acceleration (m/s^2), that of the supports included.
    pub rms_acceleration: f64,
    /// Upward crossings of the static position per second (Hz).
    pub crossings_hz: Option<f64>,
    /// Mean power that friction takes (W).
    pub dissipated_power: f64,
    /// The same over the area of the interfaces (W/m^2).
    pub dissipated_power_per_area: f64,
    /// The same of each interface, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<RandomJointSummary>,
    /// Root mean square of the largest tangential motion anywhere on the interfaces (m).
    pub rms_sliding: f64,
    /// Connections, by the names of the run's `connections`; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub connections: Vec<RandomConnectionSummary>,
    /// One-sided densities of the response.
    pub psd: DensitySummary,
    /// Whether what is assumed holds.
    pub validity: RandomValidity,
    /// What a motion in time under such a load shows; left out unless asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_time: Option<InTime>,
    /// Why there is none although it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_time_failure: Option<String>,
}

/// A mode in stationary random vibration.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RandomModeSummary {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Whether frequency and damping are means over its backbone; otherwise they are those of the linear mode with the background damping alone.
    pub follows_backbone: bool,
    /// Natural frequency of the equivalent linear mode (Hz).
    pub frequency_hz: f64,
    /// Its damping ratio (-), background included.
    pub damping_ratio: f64,
    /// Root mean square of the displacement at the response point by this mode alone (m).
    pub rms: f64,
    /// Root mean square of the modal amplitude (sqrt(kg) m).
    pub modal_rms: f64,
    /// Mean power that it takes, background included (W).
    pub power: f64,
}

/// Power that friction takes at an interface.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RandomJointSummary {
    /// Name of the interface.
    pub name: String,
    /// Mean power (W).
    pub dissipated_power: f64,
}

/// A connection in stationary random vibration; other modes than those followed are not in it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RandomConnectionSummary {
    /// Its name.
    pub name: String,
    /// Root mean square of its mean tangential motion, along the direction of its loops (m).
    pub rms_displacement: f64,
    /// Root mean square of its tangential force (N).
    pub rms_force: f64,
    /// The same over its area (Pa).
    pub rms_traction: f64,
    /// Mean power that friction takes in it (W).
    pub dissipated_power: f64,
}

/// One-sided power spectral densities of the motion of the response point, at frequencies that are closer near resonances.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DensitySummary {
    /// Frequencies (Hz).
    pub frequency_hz: Vec<f64>,
    /// Of the displacement (m^2/Hz).
    pub displacement: Vec<f64>,
    /// Of the acceleration ((m/s^2)^2/Hz).
    pub acceleration: Vec<f64>,
}

impl RandomSummary {
    /// `names` are those of the interfaces, `area` is that of all (m^2).
    pub(crate) fn of(
        of: &RandomVibration,
        load_unit: &str,
        names: &[String],
        area: f64,
        connections: &[Connection],
    ) -> Self {
        let mode = |mode: &RandomMode| RandomModeSummary {
            mode: mode.mode,
            follows_backbone: mode.follows_backbone,
            frequency_hz: mode.equivalent.omega / TAU,
            damping_ratio: mode.equivalent.zeta,
            rms: mode.rms,
            modal_rms: mode.equivalent.sigma,
            power: dissipated_power(&mode.equivalent),
        };
        let Squares {
            displacement,
            velocity,
            acceleration,
        } = of.squares;
        let power: f64 = of.power.iter().sum();
        let joints = names
            .iter()
            .zip(&of.power)
            .map(|(name, &dissipated_power)| RandomJointSummary {
                name: name.clone(),
                dissipated_power,
            });
        let density = |value: fn(&Squares) -> f64| of.densities.iter().map(|(_, squares)| value(squares)).collect();
        Self {
            level: of.level,
            rms_load: of.rms_load,
            load_unit: load_unit.to_owned(),
            modes: of.modes.iter().map(mode).collect(),
            rms_response: displacement.sqrt(),
            rms_velocity: velocity.sqrt(),
            rms_acceleration: acceleration.sqrt(),
            crossings_hz: (displacement > 0.0).then(|| (velocity / displacement).sqrt() / TAU),
            dissipated_power: power,
            dissipated_power_per_area: power / area,
            joints: if of.power.len() > 1 {
                joints.collect()
            } else {
                Vec::new()
            },
            rms_sliding: of.rms_sliding,
            connections: connections
                .iter()
                .zip(&of.connections)
                .map(|(connection, found)| RandomConnectionSummary {
                    name: connection.name.clone(),
                    rms_displacement: found.displacement,
                    rms_force: found.force,
                    rms_traction: found.force / connection.area,
                    dissipated_power: found.power,
                })
                .collect(),
            psd: DensitySummary {
                frequency_hz: of.densities.iter().map(|(f, _)| *f).collect(),
                displacement: density(|squares| squares.displacement),
                acceleration: density(|squares| squares.acceleration),
            },
            validity: of.validity.clone(),
            in_time: of.in_time.as_ref().and_then(|found| found.as_ref().ok().cloned()),
            in_time_failure: of.in_time.as_ref().and_then(|found| found.as_ref().err().cloned()),
        }
    }
}
