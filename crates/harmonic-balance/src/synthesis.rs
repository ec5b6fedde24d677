//! The forced response of one nonlinear mode alone: what a backbone of free motions says about a forced one, without solving again.
//!
//! Near a resonance the motion is that of the nonlinear mode at some amplitude `q`, with its frequency `omega(q)`, damping ratio `zeta(q)`
//! and shape, and the balance with the force leaves one complex equation (Krack 2015, DOI 10.1016/j.compstruc.2015.03.008),
//!
//! `(omega^2 - Omega^2 + 2 i (zeta + beta) omega Omega) q = psi P exp(i theta)`,
//!
//! with the force's amplitude `P`, the displacement `psi` of its point per amplitude of the mode, and the background damping ratio `beta`.
//! For each amplitude it is a quadratic equation for `Omega^2`: two branches that meet where the force just sustains the amplitude.

use crate::backbone::Motion;
use crate::load::Load;

/// A point of the response of one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Point {
    /// Amplitude of the mode (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// Angular frequency of the force (rad/s).
    pub omega: f64,
    /// Amplitude of the first harmonic of the displacement observed (m).
    pub displacement: f64,
    /// How far the mode lags behind the force at its point (rad).
    pub phase: f64,
}

/// The displacement along `observed` under a load of amplitude `force` (N) that is no unbalance, from frequencies below the resonance to those above; amplitudes between
/// those of `motions`, which ascend, are interpolated, with `between` intervals for each of theirs.
pub fn response(
    motions: &[&Motion],
    load: &Load,
    observed: &[f64],
    force: f64,
    background: f64,
    between: usize,
) -> Vec<Point> {
    let of = |motion: &&Motion| Mode::of(motion, load, observed, background);
    let modes: Vec<Mode> = motions.iter().filter_map(of).collect();
    let mut amplitudes: Vec<Mode> = Vec::new();
    for pair in modes.windows(2) {
        let steps = between.max(1);
        amplitudes.extend((0..steps).map(|i| pair[0].towards(&pair[1], i as f64 / steps as f64)));
    }
    amplitudes.extend(modes.last());
    let sustained = |mode: &Mode| mode.frequencies(force)[1].is_some();
    let tips = amplitudes
        .windows(2)
        .filter(|pair| sustained(&pair[0]) != sustained(&pair[1]));
    let tips: Vec<Mode> = tips.map(|pair| pair[0].tip(&pair[1], &sustained)).collect();
    amplitudes.extend(tips);
    amplitudes.sort_by(|a, b| a.log_amplitude.total_cmp(&b.log_amplitude));
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for mode in amplitudes {
        let [low, high] = mode.frequencies(force);
        below.extend(low.map(|omega| mode.point(omega)));
        above.extend(high.map(|omega| mode.point(omega)));
    }
    above.reverse();
    below.extend(above);
    below
}

/// A nonlinear mode at an amplitude.
#[derive(Clone, Copy, Debug)]
struct Mode {
    log_amplitude: f64,
    square: f64,
    damping: f64,
    /// Displacement along the force per amplitude.
    psi: f64,
    /// Displacement observed per amplitude.
    observed: f64,
}

impl Mode {
    fn of(motion: &Motion, load: &Load, observed: &[f64], background: f64) -> Option<Self> {
        let [ahead, behind] = load.along(&motion.displacement);
        let seen = motion.displacement.along(observed);
        Some(Self {
            log_amplitude: motion.modal_amplitude.ln(),
            square: motion.omega * motion.omega,
            damping: motion.zeta? + background,
            psi: ahead.hypot(behind) / motion.modal_amplitude,
            observed: seen[1].hypot(seen[2]) / motion.modal_amplitude,
        })
    }

    fn towards(&self, other: &Self, weight: f64) -> Self {
        let between = |a: f64, b: f64| a + weight * (b - a);
        Self {
            log_amplitude: between(self.log_amplitude, other.log_amplitude),
            square: between(self.square, other.square),
            damping: between(self.damping, other.damping),
            psi: between(self.psi, other.psi),
            observed: between(self.observed, other.observed),
        }
    }

    /// The last mode towards `other` that is sustained where only one of the two is: the tip of the resonance.
    fn tip(&self, other: &Self, sustained: &dyn Fn(&Self) -> bool) -> Self {
        let (mut inside, mut outside) = if sustained(self) {
            (*self, *other)
        } else {
            (*other, *self)
        };
        for _ in 0..50 {
            let middle = inside.towards(&outside, 0.5);
            if sustained(&middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }

    /// Frequencies at which a force sustains the amplitude, below and above the resonance.
    fn frequencies(&self, force: f64) -> [Option<f64>; 2] {
        // With x = Omega^2: (square - x)^2 + 4 damping^2 square x = (psi force / q)^2.
        let load = self.psi * force / self.log_amplitude.exp();
        let half = self.square * (1.0 - 2.0 * self.damping * self.damping);
        let root = half * half - self.square * self.square + load * load;
        if root < 0.0 {
            return [None, None];
        }
        let of = |x: f64| (x > 0.0).then(|| x.sqrt());
        [of(half - root.sqrt()), of(half + root.sqrt())]
    }

    fn point(&self, omega: f64) -> Point {
        let amplitude = self.log_amplitude.exp();
        let lag = 2.0 * self.damping * self.square.sqrt() * omega;
        Point {
            modal_amplitude: amplitude,
            omega,
            displacement: self.observed * amplitude,
            phase: lag.atan2(self.square - omega * omega),
        }
    }
}
