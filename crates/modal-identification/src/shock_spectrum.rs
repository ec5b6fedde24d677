//! Shock response spectra.

use std::f64::consts::TAU;

/// Largest absolute acceleration of an oscillator of natural frequency `frequency` (Hz) and quality factor `quality`, at rest before, whose base moves with
/// these accelerations, `step` (s) apart: the maximax spectrum of ISO 18431-4 at this frequency. Between samples the acceleration is a straight line, and
/// the motion under it exact (Nigam and Jennings 1969); the largest value is that at the samples and in the two periods after them.
pub fn maximax(accelerations: &[f64], step: f64, frequency: f64, quality: f64) -> f64 {
    let (omega, zeta) = (TAU * frequency, 0.5 / quality);
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let (decay, (sine, cosine)) = ((-zeta * omega * step).exp(), (damped * step).sin_cos());
    // Relative displacement z'' + 2 zeta omega z' + omega^2 z = -a, a = a0 + slope t: a particular solution, and free motion of the rest.
    let advance = |[z, v]: [f64; 2], [from, to]: [f64; 2]| {
        let slope = (to - from) / step;
        let square = omega * omega;
        let at = |time: f64| -(from + slope * time) / square + 2.0 * zeta * slope / (square * omega);
        let rate = -slope / square;
        let (z, v) = (z - at(0.0), v - rate);
        let next = decay * (z * cosine + (v + zeta * omega * z) / damped * sine);
        let speed = decay * (v * cosine - (omega * omega * z + zeta * omega * v) / damped * sine);
        [next + at(step), speed + rate]
    };
    // Absolute acceleration: what the spring and the damper exert.
    let felt = |[z, v]: [f64; 2]| (omega * omega * z + 2.0 * zeta * omega * v).abs();
    let after = (2.0 / (frequency * step)).ceil() as usize;
    let all = accelerations.iter().copied().chain(std::iter::repeat_n(0.0, after));
    let (mut state, mut before, mut most) = ([0.0; 2], 0.0, 0.0_f64);
    for acceleration in all {
        state = advance(state, [before, acceleration]);
        before = acceleration;
        most = most.max(felt(state));
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_half_sine_has_its_known_spectrum() {
        // Without damping: of a pulse of duration d the largest response is where the frequency is near 0.8/d, 1.77 times its height; far above it follows
        // the pulse, far below the oscillator sees an impulse of 2 d / pi.
        let (duration, step) = (0.01, 1e-5);
        let samples: Vec<f64> = (0..=1000)
            .map(|i| (PI * f64::from(i) * step / duration).sin())
            .collect();
        let at = |frequency: f64| maximax(&samples, step, frequency, 1e6);
        let largest = (40..140).map(|f| at(f64::from(f))).fold(0.0, f64::max);
        assert!((largest - 1.768).abs() < 2e-3, "{largest}");
        assert!((at(4000.0) - 1.0).abs() < 0.02);
        let slow = at(0.5);
        assert!((slow / (TAU * 0.5 * 2.0 * duration / PI) - 1.0).abs() < 1e-3, "{slow}");
        // A damped oscillator in the resonance of a long sine swings up to its quality.
        let samples: Vec<f64> = (0..200_000).map(|i| (TAU * 50.0 * f64::from(i) * step).sin()).collect();
        let resonant = maximax(&samples, step, 50.0, 10.0);
        assert!((resonant / 10.05 - 1.0).abs() < 5e-3, "{resonant}");
    }
}
