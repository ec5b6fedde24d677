//! Stationary random vibration of modes whose frequency and damping depend on their amplitude, by equivalent linearisation from backbones.
//!
//! A mode under a Gaussian load answers in a narrow band, with an amplitude `a` that changes slowly. Under white noise of one-sided density `G` (per Hz)
//! averaging over a period (Stratonovich; Roberts and Spanos, Random Vibration and Statistical Linearization, 2003, sections 4.5 and 8) gives its density
//!
//! `p(a) = c a exp(-(8 / G) int_0^a zeta(s) omega(s)^3 s ds)`,
//!
//! which is that of Rayleigh where the damping is constant. The linear oscillator that stands for the mode has as much elastic and dissipated energy in
//! the mean, with `sigma^2 = E[a^2] / 2`,
//!
//! `omega_eq^2 = E[omega(a)^2 a^2] / E[a^2]`, `zeta_eq omega_eq^3 = E[zeta(a) omega(a)^3 a^2] / E[a^2]`,
//!
//! and its mean square under the load itself, `(phi^T e)^2` times the integral of `S(f) / |omega_eq^2 - w^2 + 2 i zeta_eq omega_eq w|^2`, is `sigma^2`: this sets
//! `G`, which under white noise is its density. Integrals over frequency hold for spectra of any shape; what is assumed of a mode that is not linear is that
//! its amplitude is distributed as under white noise.

use crate::Error;
use std::f64::consts::TAU;

/// Gauss-Legendre rule of eight points on -1 to 1: abscissae and weights of one half.
const RULE: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_3),
];

/// Points of the rule between two limits, with weights.
fn points(from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let both = RULE.into_iter().flat_map(|(x, w)| [(-x, w), (x, w)]);
    both.map(move |(x, w)| (middle + half * x, half * w))
}

/// A one-sided power spectral density: straight lines in log-log between points, nothing beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Frequency (Hz), and density (unit of the load squared per Hz).
    points: Vec<[f64; 2]>,
}

impl Spectrum {
    /// From frequencies (Hz) and densities.
    ///
    /// # Errors
    /// [`Error::Setting`] for fewer than two points, frequencies that do not ascend, and numbers that are not positive.
    pub fn try_new(points: Vec<[f64; 2]>) -> Result<Self, Error> {
        let refuse = |value: f64, requirement| {
            Err(Error::Setting {
                field: "psd",
                value,
                requirement,
            })
        };
        if points.len() < 2 {
            return refuse(points.len() as f64, "two points at least");
        }
        if let Some(wrong) = points.iter().flatten().find(|v| !(**v > 0.0 && v.is_finite())) {
            return refuse(*wrong, "positive and finite");
        }
        if let Some(pair) = points.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
            return refuse(pair[1][0], "in ascending order of the frequencies");
        }
        Ok(Self { points })
    }

    /// The same, all densities times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let points = self.points.iter().map(|[f, s]| [*f, factor * s]);
        Self {
            points: points.collect(),
        }
    }

    /// First and last frequency (Hz).
    pub fn band(&self) -> [f64; 2] {
        [self.points[0][0], self.points[self.points.len() - 1][0]]
    }

    /// Density at a frequency (Hz).
    pub fn density(&self, frequency: f64) -> f64 {
        let [first, last] = self.band();
        if !(first..=last).contains(&frequency) {
            return 0.0;
        }
        let after = self
            .points
            .partition_point(|p| p[0] < frequency)
            .clamp(1, self.points.len() - 1);
        let ([f0, s0], [f1, s1]) = (self.points[after - 1], self.points[after]);
        s0 * ((s1 / s0).ln() * (frequency / f0).ln() / (f1 / f0).ln()).exp()
    }

    /// Integral of the density over all frequencies.
    pub fn mean_square(&self) -> f64 {
        self.mean_square_below(f64::INFINITY)
    }

    /// Integral of the density up to a frequency (Hz).
    pub fn mean_square_below(&self, frequency: f64) -> f64 {
        let of = |pair: &[[f64; 2]]| {
            let ([f0, s0], mut last) = (pair[0], pair[1]);
            if frequency <= f0 {
                return 0.0;
            }
            if frequency < last[0] {
                last = [frequency, self.density(frequency)];
            }
            let [f1, s1] = last;
            let ratio = (f1 / f0).ln();
            // Of f^m, with x = (m + 1) ln(f1 / f0): s0 f0 ratio (e^x - 1) / x.
            let x = (s1 / s0).ln() + ratio;
            s0 * f0 * ratio * if x == 0.0 { 1.0 } else { x.exp_m1() / x }
        };
        self.points.windows(2).map(of).sum()
    }

    /// Limits of intervals on which the density and responses with these resonances (frequency, half the width of the peak; Hz) are smooth.
    fn limits(&self, resonances: impl Iterator<Item = [f64; 2]>) -> Vec<f64> {
        let [first, last] = self.band();
        let mut limits: Vec<f64> = self.points.iter().map(|p| p[0]).collect();
        let mut octave = first;
        while octave < last {
            limits.push(octave);
            octave *= 2.0;
        }
        for [centre, width] in resonances {
            limits.push(centre);
            let mut distance = 0.5 * width.max(1e-12 * centre);
            while distance < last + centre {
                limits.extend([centre - distance, centre + distance]);
                distance *= 2.0;
            }
        }
        limits.retain(|f| (first..=last).contains(f));
        limits.sort_by(f64::total_cmp);
        limits.dedup();
        limits
    }
}

/// A linear oscillator of unit mass, and how load and response go with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator {
    /// Natural angular frequency (rad/s).
    pub omega: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Modal force per unit of the load.
    pub load: f64,
    /// Displacement at the response point per unit of the coordinate.
    pub response: f64,
}

impl Oscillator {
    /// Real and imaginary part of its coordinate under a unit modal force.
    fn receptance(&self, omega: f64) -> [f64; 2] {
        let (x, y) = (
            self.omega * self.omega - omega * omega,
            2.0 * self.zeta * self.omega * omega,
        );
        let square = x * x + y * y;
        [x / square, -y / square]
    }

    fn peak(&self) -> [f64; 2] {
        [self.omega / TAU, self.zeta * self.omega / TAU]
    }

    /// Mean square of its coordinate under a load of this density.
    pub fn mean_square(&self, spectrum: &Spectrum) -> f64 {
        let value = |f: f64| {
            let [x, y] = self.receptance(TAU * f);
            (x * x + y * y) * spectrum.density(f)
        };
        let limits = spectrum.limits(std::iter::once(self.peak()));
        let intervals = limits.windows(2).flat_map(|pair| points(pair[0], pair[1]));
        self.load * self.load * intervals.map(|(f, weight)| weight * value(f)).sum::<f64>()
    }
}

/// Densities that are given for each interval of the integrals.
const BETWEEN: u32 = 4;

/// From the load to the response point.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// The modes.
    pub oscillators: Vec<Oscillator>,
    /// Displacement per unit of a slow load beyond that of the oscillators.
    pub remainder: f64,
    /// Acceleration of the response point that goes with a unit of the load itself: of supports that move with it.
    pub carried: f64,
}

/// Mean squares, or densities, of the motion of the response point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Squares {
    /// Of the displacement (m^2), against the supports where they move.
    pub displacement: f64,
    /// Of its rate (m^2/s^2).
    pub velocity: f64,
    /// Of the acceleration (m^2/s^4), that of the supports included.
    pub acceleration: f64,
}

impl Transfer {
    /// Squares of the response to a unit load at a frequency (Hz).
    fn squares(&self, frequency: f64) -> Squares {
        let omega = TAU * frequency;
        let mut sum = [self.remainder, 0.0];
        for oscillator in &self.oscillators {
            let [x, y] = oscillator.receptance(omega);
            let factor = oscillator.load * oscillator.response;
            sum = [sum[0] + factor * x, sum[1] + factor * y];
        }
        let [x, y] = sum;
        let square = omega * omega;
        Squares {
            displacement: x * x + y * y,
            velocity: square * (x * x + y * y),
            acceleration: (self.carried - square * x).powi(2) + (square * y).powi(2),
        }
    }

    fn limits(&self, spectrum: &Spectrum) -> Vec<f64> {
        spectrum.limits(self.oscillators.iter().map(Oscillator::peak))
    }

    /// Mean squares under a load of this density.
    pub fn mean_squares(&self, spectrum: &Spectrum) -> Squares {
        let mut sum = Squares::default();
        for pair in self.limits(spectrum).windows(2) {
            for (f, weight) in points(pair[0], pair[1]) {
                let (factor, of) = (weight * spectrum.density(f), self.squares(f));
                sum.displacement += factor * of.displacement;
                sum.velocity += factor * of.velocity;
                sum.acceleration += factor * of.acceleration;
            }
        }
        sum
    }

    /// Frequencies (Hz), closer near resonances, and densities of the response there.
    pub fn densities(&self, spectrum: &Spectrum) -> Vec<(f64, Squares)> {
        let of = |f: f64| {
            let (of, density) = (self.squares(f), spectrum.density(f));
            let scaled = Squares {
                displacement: density * of.displacement,
                velocity: density * of.velocity,
                acceleration: density * of.acceleration,
            };
            (f, scaled)
        };
        let limits = self.limits(spectrum);
        let between = limits.windows(2).flat_map(|pair| {
            let step = (pair[1] - pair[0]) / f64::from(BETWEEN);
            (0..BETWEEN).map(move |k| pair[0] + f64::from(k) * step)
        });
        between.chain(limits.last().copied()).map(of).collect()
    }
}

/// Frequency and damping of a mode against its amplitude.
#[derive(Clone, Debug, PartialEq)]
pub struct AmplitudeCurve {
    /// Logarithms of the amplitudes.
    logs: Vec<f64>,
    omega: Vec<f64>,
    zeta: Vec<f64>,
    /// Intervals between amplitudes, short enough for the damping to be constant in them.
    parts: Vec<Part>,
}

/// An interval of amplitudes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    /// Squares of its ends.
    ends: [f64; 2],
    /// `zeta omega^3` in it.
    loss: f64,
    /// The amplitude before it, and how far its middle is from that to the next one (by logarithms).
    segment: usize,
    share: f64,
}

/// Longest interval of the logarithm of amplitudes in which the damping counts as constant.
const LONGEST: f64 = 1.0 / 32.0;

/// The linear oscillator that stands for a mode at a mean square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equivalent {
    /// Root of the mean square of the modal coordinate (sqrt(kg) m).
    pub sigma: f64,
    /// Angular frequency (rad/s).
    pub omega: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// One-sided density of the white modal force that leads to this mean square (1/Hz times the square of its unit).
    pub white: f64,
    /// Share of `E[a^2]` by amplitudes below the first, and above the last one of the backbone, where its end values are taken.
    pub beyond: [f64; 2],
    /// Root of the mean square of the natural frequency's deviation, weighted with `a^2`, over `omega`.
    pub spread: f64,
    /// Whether the mean square has other solutions, all of them larger.
    pub others: bool,
}

/// Levels that are tried, for each decade.
const TRIED: f64 = 16.0;

/// How far they go beyond the amplitudes of the backbone.
const BEYOND: f64 = 10.0;

/// Halvings of the interval between two of them.
const HALVINGS: usize = 60;

/// Between two values by logarithms where they are positive.
fn between(values: [f64; 2], share: f64) -> f64 {
    let [a, b] = values;
    match a > 0.0 && b > 0.0 {
        true => a * (b / a).powf(share),
        false => a + share * (b - a),
    }
}

/// Integrals of `a` and `a^3` times `exp(-k (a^2 - first))` over amplitudes between roots of `first` and `last`, which may be infinite.
fn moments(k: f64, [first, last]: [f64; 2]) -> [f64; 2] {
    let y = k * (last - first);
    let decay = (-y).exp();
    let one = -(-y).exp_m1() / (2.0 * k);
    // 1 - (1 + y) exp(-y), without cancellation.
    let rest = match y < 1e-2 {
        true => y * y * (0.5 - y * (1.0 / 3.0 - y * (0.125 - y / 30.0))),
        false if y.is_finite() => 1.0 - (1.0 + y) * decay,
        false => 1.0,
    };
    [one, first * one + rest / (2.0 * k * k)]
}

impl AmplitudeCurve {
    /// From amplitudes (sqrt(kg) m), angular frequencies (rad/s) and damping ratios.
    ///
    /// # Errors
    /// [`Error::Setting`] for none, amplitudes that do not ascend, and numbers that are not positive.
    pub fn try_new(points: &[[f64; 3]]) -> Result<Self, Error> {
        let refuse = |field, value: f64, requirement| {
            Err(Error::Setting {
                field,
                value,
                requirement,
            })
        };
        if points.is_empty() {
            return refuse("amplitudes", 0.0, "one at least");
        }
        for point in points {
            for (field, value) in ["amplitude", "omega", "zeta"].into_iter().zip(point) {
                if !(*value > 0.0 && value.is_finite()) {
                    return refuse(field, *value, "positive and finite");
                }
            }
        }
        if let Some(pair) = points.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
            return refuse("amplitude", pair[1][0], "larger than the one before");
        }
        let [logs, omega, zeta] = [0, 1, 2].map(|i| points.iter().map(|p| p[i]).collect::<Vec<f64>>());
        let logs: Vec<f64> = logs.into_iter().map(f64::ln).collect();
        let mut parts = Vec::new();
        for (segment, ends) in logs.windows(2).enumerate() {
            let number = ((ends[1] - ends[0]) / LONGEST).ceil().max(1.0);
            for part in 0..number as usize {
                let [from, middle, to] = [0.0, 0.5, 1.0].map(|x| (part as f64 + x) / number);
                let square = |share: f64| (2.0 * (ends[0] + share * (ends[1] - ends[0]))).exp();
                let at = |values: &[f64]| between([values[segment], values[segment + 1]], middle);
                parts.push(Part {
                    ends: [from, to].map(square),
                    loss: at(&zeta) * at(&omega).powi(3),
                    segment,
                    share: middle,
                });
            }
        }
        Ok(Self {
            logs,
            omega,
            zeta,
            parts,
        })
    }

    /// `E[a^2]` under white noise of this density, with its shares: below the first amplitude, part by part, above the last one.
    fn shares(&self, white: f64) -> (f64, Vec<f64>) {
        let last = self.logs.len() - 1;
        let end = |at: usize| (2.0 * self.logs[at]).exp();
        let loss = |at: usize| self.zeta[at] * self.omega[at].powi(3);
        let outer = [(0.0, end(0), loss(0)), (end(last), f64::INFINITY, loss(last))];
        let [below, above] = outer.map(|(from, to, loss)| ([from, to], loss));
        let parts = self.parts.iter().map(|part| (part.ends, part.loss));
        let all = std::iter::once(below).chain(parts).chain([above]);
        let mut weights = Vec::with_capacity(self.parts.len() + 2);
        let (mut sum, mut exponent) = ([0.0; 2], 0.0);
        for (ends, loss) in all {
            let k = 4.0 * loss / white;
            let [one, square] = moments(k, ends).map(|moment| f64::exp(-exponent) * moment);
            sum = [sum[0] + one, sum[1] + square];
            weights.push(square);
            exponent += k * (ends[1] - ends[0]);
        }
        weights.iter_mut().for_each(|weight| *weight /= sum[1]);
        (sum[1] / sum[0], weights)
    }

    /// What gives `E[v(a) a^2] / E[a^2]` of values at the amplitudes, under white noise of this density (which may be zero) as [`Equivalent::white`] says:
    /// interpolated along the logarithm of the amplitude, in their own logarithms where they are positive, and constant beyond the ends. It panics on
    /// another number of values than of amplitudes.
    pub fn means(&self, white: f64) -> impl Fn(&[f64]) -> f64 {
        let weights = (white > 0.0).then(|| self.shares(white).1);
        move |values| {
            assert_eq!(values.len(), self.logs.len(), "one value for each amplitude");
            weights
                .as_ref()
                .map_or(values[0], |weights| self.weighted(values, weights))
        }
    }

    fn weighted(&self, values: &[f64], weights: &[f64]) -> f64 {
        let parts = self.parts.iter().zip(&weights[1..]);
        let inner =
            parts.map(|(part, weight)| weight * between([values[part.segment], values[part.segment + 1]], part.share));
        weights[0] * values[0] + inner.sum::<f64>() + weights[weights.len() - 1] * values[values.len() - 1]
    }

    fn equivalent(&self, white: f64) -> Equivalent {
        let (square, weights) = match white > 0.0 {
            true => self.shares(white),
            false => {
                let mut weights = vec![0.0; self.parts.len() + 2];
                weights[0] = 1.0;
                (0.0, weights)
            }
        };
        let mean = |value: &dyn Fn(f64, f64) -> f64| {
            let values: Vec<f64> = self
                .omega
                .iter()
                .zip(&self.zeta)
                .map(|(omega, zeta)| value(*omega, *zeta))
                .collect();
            self.weighted(&values, &weights)
        };
        let omega = mean(&|omega, _| omega * omega).sqrt();
        let spread = mean(&|own, _| (own - omega).powi(2)).max(0.0).sqrt() / omega;
        Equivalent {
            sigma: (0.5 * square).sqrt(),
            omega,
            zeta: mean(&|omega, zeta| zeta * omega.powi(3)) / omega.powi(3),
            white,
            beyond: [weights[0], weights[weights.len() - 1]],
            spread,
            others: false,
        }
    }

    /// The stationary state under a load of this density, of which `load` is the modal force per unit. Where there are several, it is the smallest.
    pub fn stationary(&self, load: f64, spectrum: &Spectrum) -> Equivalent {
        let answer = |equivalent: &Equivalent| {
            let oscillator = Oscillator {
                omega: equivalent.omega,
                zeta: equivalent.zeta,
                load,
                response: 0.0,
            };
            oscillator.mean_square(spectrum).sqrt()
        };
        // The density that leads to a mean square at one end of the backbone.
        let white = |at: usize, sigma: f64| 8.0 * self.zeta[at] * self.omega[at].powi(3) * sigma * sigma;
        let last = self.logs.len() - 1;
        let [small, large] = [self.logs[0].exp() / BEYOND, self.logs[last].exp() * BEYOND];
        let least = answer(&self.equivalent(white(0, small)));
        if least == 0.0 {
            return self.equivalent(0.0);
        }
        let most = answer(&self.equivalent(white(last, large)));
        // Beyond the backbone the oscillator stays as it is, and its answer is the solution if it lies there.
        let from = white(0, small.min(0.5 * least)).ln();
        let to = white(last, large.max(2.0 * most)).ln();
        let steps = ((to - from) / std::f64::consts::LN_10 * TRIED).ceil().max(1.0) as usize;
        let excess = |log: f64| {
            let equivalent = self.equivalent(log.exp());
            answer(&equivalent).ln() - equivalent.sigma.ln()
        };
        let at = |step: usize| from + (to - from) * step as f64 / steps as f64;
        let mut roots = Vec::new();
        let mut before = excess(from);
        for step in 1..=steps {
            let after = excess(at(step));
            if before > 0.0 && after <= 0.0 {
                roots.push([at(step - 1), at(step)]);
            }
            before = after;
        }
        // The excess falls from above zero to below it, so that there is one.
        let [mut low, mut high] = roots.first().copied().unwrap_or([from, to]);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match excess(middle) > 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        Equivalent {
            others: roots.len() > 1,
            ..self.equivalent((0.5 * (low + high)).exp())
        }
    }
}

/// Power that an oscillator of unit mass dissipates in the mean (W), by `2 zeta omega q' q'`, where its mean square is that of a narrow band.
pub fn dissipated_power(equivalent: &Equivalent) -> f64 {
    2.0 * equivalent.zeta * equivalent.omega.powi(3) * equivalent.sigma * equivalent.sigma
}
