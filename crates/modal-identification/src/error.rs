//! Errors and warnings of this crate. `at` names the file and the channel.

use std::fmt;

/// A setting outside what is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Name.
    pub name: &'static str,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
    /// What is allowed.
    pub allowed: String,
}

/// Why a ring-down cannot be read or identified. Samples are counted from one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file cannot be read, or breaks the rules of its format.
    #[error(transparent)]
    File(#[from] matrix_files::Error),
    /// No channel in the file.
    #[error(
        "{file}: no channel was found in it; a channel is a column or vector of at least two numbers beside the time"
    )]
    NoChannels {
        /// File.
        file: String,
    },
    /// The channel asked for is not there.
    #[error("{file}: there is no channel `{wanted}`; there are {available}")]
    UnknownChannel {
        /// File.
        file: String,
        /// Name asked for.
        wanted: String,
        /// Names of those that are there.
        available: String,
    },
    /// Several channels and no name.
    #[error("{file}: which channel to identify is not stated; name one of {available}")]
    SeveralChannels {
        /// File.
        file: String,
        /// Names of those that are there.
        available: String,
    },
    /// A unit that is not known, or none of acceleration, velocity or displacement.
    #[error(
        "{at}: the unit `{unit}` is none of acceleration, velocity or displacement; state it as for example `m/s^2`, `g`, \
         `mm/s`, `um`, or with a factor, `0.5 m/s^2`, which is then the size of one unit of the file"
    )]
    UnknownUnit {
        /// File and channel, or where the unit was given.
        at: String,
        /// The unit.
        unit: String,
    },
    /// A unit that is not one of force.
    #[error("{at}: the unit `{unit}` is none of force; state it as `N`, `mN`, `kN`, `lbf`, or with a factor, `2.5 N`")]
    UnknownForceUnit {
        /// File and channel, or where the unit was given.
        at: String,
        /// The unit.
        unit: String,
    },
    /// The file states no unit, and none was given.
    #[error("{at}: the file states no unit; give it, for example `m/s^2` or `g`, or `N` for a force")]
    NoUnit {
        /// File and channel.
        at: String,
    },
    /// The unit given is not that of the file.
    #[error("{at}: the file states the unit `{stated}`, but `{given}` was given; leave one out")]
    ConflictingUnit {
        /// File and channel.
        at: String,
        /// Unit of the file.
        stated: String,
        /// Unit given.
        given: String,
    },
    /// The file states no sample rate, and none was given.
    #[error("{at}: the file states neither sample rate nor times; give the sample rate (Hz)")]
    NoSampleRate {
        /// File and channel.
        at: String,
    },
    /// The sample rate given is not that of the file.
    #[error(
        "{at}: the file states a sample rate of {stated} Hz, but {given} Hz was given; leave it out, or correct the file"
    )]
    ConflictingSampleRate {
        /// File and channel.
        at: String,
        /// Rate of the file.
        stated: f64,
        /// Rate given.
        given: f64,
    },
    /// A sample rate that is not positive.
    #[error("{at}: the sample rate is {rate} Hz; it must be positive and finite")]
    BadSampleRate {
        /// File and channel.
        at: String,
        /// The rate.
        rate: f64,
    },
    /// Too few samples to be a signal.
    #[error("{at}: there are {samples} samples, at least {needed} are needed; check that the record is complete")]
    TooShort {
        /// File and channel.
        at: String,
        /// Number of samples.
        samples: usize,
        /// Number needed.
        needed: usize,
    },
    /// A sample is NaN or infinite.
    #[error("{at}: sample {sample} is {value}, not a finite number; cut the record there, or correct it")]
    NotFinite {
        /// File and channel.
        at: String,
        /// Number of the sample.
        sample: usize,
        /// Its value.
        value: f64,
    },
    /// All samples are equal.
    #[error("{at}: all {samples} samples are {value} {unit}; check the sensor and the choice of the channel")]
    Constant {
        /// File and channel.
        at: String,
        /// Number of samples.
        samples: usize,
        /// Their value.
        value: f64,
        /// Its unit.
        unit: String,
    },
    /// Samples are missing.
    #[error(
        "{at}: about {missing:.0} samples are missing after sample {sample} at {time} s; cut the record so that it begins or \
         ends there"
    )]
    Gap {
        /// File and channel.
        at: String,
        /// Number of the sample before the gap.
        sample: usize,
        /// Its time (s).
        time: f64,
        /// Length of the gap in samples.
        missing: f64,
    },
    /// Times do not ascend.
    #[error(
        "{at}: the time {time} s of sample {sample} does not come after {before} s; sort the samples, or correct the times"
    )]
    TimeNotAscending {
        /// File and channel.
        at: String,
        /// Number of the sample.
        sample: usize,
        /// Time before it (s).
        before: f64,
        /// Its time (s).
        time: f64,
    },
    /// Samples are not equally spaced.
    #[error(
        "{at}: sample {sample} at {time} s is {steps:.2} steps away from equal spacing; resample the signal at a constant rate"
    )]
    NonUniformTime {
        /// File and channel.
        at: String,
        /// Number of the sample farthest away.
        sample: usize,
        /// Its time (s).
        time: f64,
        /// Distance in steps.
        steps: f64,
    },
    /// A setting outside what is allowed.
    #[error("the {} is {} {}; it must be {}", .0.name, .0.value, .0.unit, .0.allowed)]
    Setting(Setting),
    /// No peak of the spectrum in the range searched.
    #[error(
        "{at}: the spectrum has no peak between {low} and {high} Hz; state the frequency of the mode, or a larger bandwidth"
    )]
    NoPeak {
        /// File and channel.
        at: String,
        /// Lower end of the search (Hz).
        low: f64,
        /// Upper end (Hz).
        high: f64,
    },
    /// Two modes in one band.
    #[error(
        "{at}: the band from {low:.2} to {high:.2} Hz holds two modes, at {first:.2} Hz and at {second:.2} Hz with {ratio:.2} \
         times the height; choose a bandwidth well below their distance of {distance:.2} Hz, or measure where only one of \
         them moves", distance = (second - first).abs()
    )]
    TwoModes {
        /// File and channel.
        at: String,
        /// The one to be identified (Hz).
        first: f64,
        /// The other (Hz).
        second: f64,
        /// Its peak in the spectrum over that of the first, after the filter.
        ratio: f64,
        /// Lower edge of the band (Hz).
        low: f64,
        /// Upper edge (Hz).
        high: f64,
    },
    /// Too little of the record is left.
    #[error(
        "{at}: between {from:.4} s and {to:.4} s, after the hit and above the noise, there are {cycles:.1} cycles; at least \
         {needed:.1} are needed. Record longer, choose a larger bandwidth, a shorter smoothing window or a smaller noise margin"
    )]
    TooFewCycles {
        /// File and channel.
        at: String,
        /// Start of what is usable (s).
        from: f64,
        /// Its end (s).
        to: f64,
        /// Cycles in it.
        cycles: f64,
        /// Cycles needed.
        needed: f64,
    },
    /// A record that is no sweep in one direction.
    #[error(
        "{at}: {what}. A swept-sine record has a force and a response that were taken together, whose frequency rises or falls \
         throughout; cut the record to one sweep, or choose other channels"
    )]
    NoSweep {
        /// File and channel.
        at: String,
        /// What is wrong.
        what: String,
    },
    /// Backbones of different quantities, or none.
    #[error("{what}; average backbones of one quantity, at least one, with at least two points each")]
    Average {
        /// What is wrong.
        what: String,
    },
}

/// Something that was noticed and did not stop the identification.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Part of a file was not read.
    Skipped {
        /// What.
        name: String,
        /// Why.
        reason: String,
    },
    /// Another channel of the file has one value throughout.
    ConstantChannel {
        /// Its name.
        name: String,
    },
    /// The signal stays at its largest or smallest value for several samples.
    Clipped {
        /// Samples at the limits.
        samples: usize,
        /// Time of the last (s).
        last: f64,
    },
    /// The signal stands still for many samples amid motion.
    Dropout {
        /// Time of the first such sample (s).
        time: f64,
        /// Number of samples.
        samples: usize,
    },
    /// Samples lie off the equally spaced times that are assumed.
    Jitter {
        /// Largest distance in steps.
        steps: f64,
    },
    /// The signal was loud before the hit that is identified.
    EarlierExcitation {
        /// Time of the loudest moment before (s).
        time: f64,
    },
    /// The oscillation grows again; the backbone ends before.
    LaterExcitation {
        /// Time at which the backbone ends (s).
        time: f64,
    },
    /// Extrema follow one another irregularly; the backbone ends before.
    IrregularPeaks {
        /// Time at which the backbone ends (s).
        time: f64,
    },
    /// Frequencies in the outer part of the band.
    NearBandEdge {
        /// The frequency farthest from the centre (Hz).
        frequency: f64,
    },
    /// A negative damping ratio.
    NegativeDamping {
        /// Number of points.
        points: usize,
    },
    /// Another mode shows in the band, weakly.
    OtherMode {
        /// Its frequency (Hz).
        frequency: f64,
        /// Its peak in the spectrum over that of the mode, after the filter.
        ratio: f64,
    },
    /// The response of a sweep was not held.
    NotHeld {
        /// Largest difference of an amplitude from the mean, relative.
        apart: f64,
    },
    /// The second method could not be applied.
    NoCrossCheck,
    /// The second method disagrees.
    CrossCheckDiffers {
        /// Median difference of frequency (Hz).
        frequency: f64,
        /// Median difference of the damping ratio over the ratio.
        damping: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Skipped { name, reason } => write!(f, "{name} was not read: {reason}"),
            Self::ConstantChannel { name } => write!(f, "channel `{name}` has one value throughout"),
            Self::Clipped { samples, last } => write!(
                f,
                "{samples} samples are clipped, the last at {last:.6} s; the backbone begins after it"
            ),
            Self::Dropout { time, samples } => {
                write!(f, "the signal stands still for {samples} samples from {time:.6} s on")
            }
            Self::Jitter { steps } => write!(
                f,
                "times deviate from equal spacing by up to {steps:.2e} steps; equal spacing is assumed"
            ),
            Self::EarlierExcitation { time } => {
                write!(f, "the signal before the hit, loudest at {time:.4} s, is left out")
            }
            Self::LaterExcitation { time } => {
                write!(f, "the oscillation grows again; the backbone ends at {time:.4} s")
            }
            Self::IrregularPeaks { time } => write!(
                f,
                "extrema follow one another irregularly; the backbone ends at {time:.4} s"
            ),
            Self::NearBandEdge { frequency } => write!(
                f,
                "the frequency reaches {frequency:.3} Hz, in the outer fifth of the band; choose a larger bandwidth or \
                 another centre"
            ),
            Self::NegativeDamping { points } => write!(f, "the damping ratio is not positive at {points} points"),
            Self::OtherMode { frequency, ratio } => write!(
                f,
                "another mode at about {frequency:.2} Hz shows in the band with {ratio:.4} times the height"
            ),
            Self::NotHeld { apart } => write!(
                f,
                "the response differs by up to {:.1} % from its mean; a mode whose frequency or damping depends on amplitude needs a response that is held",
                100.0 * apart
            ),
            Self::NoCrossCheck => write!(f, "too short for the second method; nothing confirms the result"),
            Self::CrossCheckDiffers { frequency, damping } => write!(
                f,
                "the second method differs by {frequency:.2e} Hz and by {:.2} % of the damping ratio in the median",
                100.0 * damping
            ),
        }
    }
}
