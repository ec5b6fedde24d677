//! What a closed hysteresis loop says: frequency, damping, dissipation.

use std::f64::consts::PI;

/// Vertices of one closed loop of modal force against modal amplitude.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Loop {
    /// Modal force at each vertex, `alpha` (sqrt(kg) m/s^2).
    pub force: Vec<f64>,
    /// Modal amplitude at each vertex, `q` (sqrt(kg) m).
    pub amplitude: Vec<f64>,
}

/// Simpson's rule from the trapezoidal rule with all vertices and with every second one: the part of either.
pub(crate) const SIMPSON: [f64; 2] = [4.0 / 3.0, -1.0 / 3.0];

impl Loop {
    /// Area of the closed loop, positive for dissipation (J); the sum is signed.
    ///
    /// By Simpson's rule along the branches, which is of fourth order in the vertices. The branches are of the same even number of edges, in pairs of
    /// equal steps of force; with another number of edges the loop is the polygon of its vertices.
    pub fn area(&self) -> f64 {
        self.combined(Self::polygon)
    }

    /// The same from every second vertex: with [`Loop::area`] it tells how well the loop is resolved.
    ///
    /// `None` unless the number of edges is even.
    pub fn coarse_area(&self) -> Option<f64> {
        (self.force.len() % 2 == 1).then(|| self.every(2).combined(Self::polygon))
    }

    /// The loop from every so many vertices.
    fn every(&self, stride: usize) -> Self {
        let of = |all: &[f64]| all.iter().step_by(stride).copied().collect();
        Self {
            force: of(&self.force),
            amplitude: of(&self.amplitude),
        }
    }

    /// Whether both branches are pairs of edges.
    fn has_pairs(&self) -> bool {
        self.force.len() % 4 == 1 && self.force.len() > 1
    }

    /// A linear rule that is of second order in the vertices, made one of fourth order.
    fn combined(&self, rule: impl Fn(&Self) -> f64) -> f64 {
        if self.has_pairs() {
            SIMPSON[0] * rule(self) + SIMPSON[1] * rule(&self.every(2))
        } else {
            rule(self)
        }
    }

    /// `closed integral of force d amplitude` of the polygon.
    fn polygon(&self) -> f64 {
        let (Some(force), Some(amplitude)) = (self.force.first(), self.amplitude.first()) else {
            return 0.0;
        };
        // Relative to the first vertex, so that the offset of a loop cannot enter through round-off.
        let at = |(f, q): (&f64, &f64)| (f - force, q - amplitude);
        let vertices = || self.force.iter().zip(&self.amplitude).map(at);
        let next = vertices().skip(1).chain(std::iter::once((0.0, 0.0)));
        vertices().zip(next).map(|(a, b)| 0.5 * (a.0 + b.0) * (b.1 - a.1)).sum()
    }

    /// Damping ratio of a loop with the peak force `peak`: its area over `2 pi q alpha`, as `(q omega)^2 = q alpha` (eq. 42).
    pub(crate) fn zeta(&self, peak: f64) -> f64 {
        let (low, high) = self.extremes();
        self.area() / (PI * (high - low) * peak)
    }

    /// Smallest and largest modal amplitude.
    pub fn extremes(&self) -> (f64, f64) {
        self.amplitude
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), q| {
                (lo.min(*q), hi.max(*q))
            })
    }

    /// Angular frequency of the sinusoidal motion of the loop's range that the force balances in its first harmonic (rad/s):
    /// with `q = middle + Q cos(theta)`, `omega^2 = 1/(pi Q) closed integral of force cos(theta) d theta`, exact on the edges of the polygon and of the
    /// order of [`Loop::area`].
    ///
    /// The secant takes the force at the reversals for the whole of the motion; a free oscillation feels all of it, and
    /// where the loop bends has a period closer to this one.
    pub fn harmonic_omega(&self) -> f64 {
        self.combined(Self::harmonic_square).sqrt()
    }

    /// The square of it for the polygon.
    fn harmonic_square(&self) -> f64 {
        let (low, high) = self.extremes();
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        // Loops begin at the positive reversal: down in the first half of the vertices, up in the second.
        let last = self.amplitude.len().saturating_sub(1);
        let angle = |i: usize| {
            let angle = ((self.amplitude[i] - middle) / half).clamp(-1.0, 1.0).acos();
            if 2 * i <= last { angle } else { 2.0 * PI - angle }
        };
        // By parts: minus the integral of sin(theta) over the force, which grows by its slope times -Q sin(theta) d theta.
        let edge = |i: usize| {
            let (a, b) = (angle(i), angle(i + 1));
            let force = self.force[i + 1] - self.force[i];
            let way = half * (b.cos() - a.cos());
            let squares = 0.5 * (b - a) - 0.25 * ((2.0 * b).sin() - (2.0 * a).sin());
            if way == 0.0 {
                -force / half * a.sin()
            } else {
                force / way * squares
            }
        };
        (0..last).map(edge).sum::<f64>() / PI
    }

    /// Derivatives of [`Loop::area`] with respect to the amplitudes of the vertices, at the same forces.
    pub(crate) fn area_weights(&self) -> Vec<f64> {
        self.combined_weights(|polygon| {
            let force = &polygon.force;
            let n = force.len();
            (0..n)
                .map(|i| 0.5 * (force[(i + n - 1) % n] - force[(i + 1) % n]))
                .collect()
        })
    }

    /// Derivatives of the square of [`Loop::harmonic_omega`] with respect to the amplitudes of the vertices, at the same forces.
    pub(crate) fn harmonic_weights(&self) -> Vec<f64> {
        self.combined_weights(Self::harmonic_square_weights)
    }

    /// [`Loop::combined`] of the derivatives that belong to the vertices.
    fn combined_weights(&self, rule: impl Fn(&Self) -> Vec<f64>) -> Vec<f64> {
        let mut weights = rule(self);
        if self.has_pairs() {
            weights.iter_mut().for_each(|weight| *weight *= SIMPSON[0]);
            let coarse = rule(&self.every(2));
            for (weight, coarse) in weights.iter_mut().step_by(2).zip(coarse) {
                *weight += SIMPSON[1] * coarse;
            }
        }
        weights
    }

    /// Those of the polygon: with `x = cos(theta)` an edge gives its force times `(g(b) - g(a)) / (x(b) - x(a))`, where `dg/dx = -sin(theta)`: it has a slope where
    /// `theta` itself has none, at the reversals.
    fn harmonic_square_weights(&self) -> Vec<f64> {
        let (low, high) = self.extremes();
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let last = self.amplitude.len().saturating_sub(1);
        let place = |i: usize| ((self.amplitude[i] - middle) / half).clamp(-1.0, 1.0);
        let angle = |i: usize| {
            if 2 * i <= last {
                place(i).acos()
            } else {
                2.0 * PI - place(i).acos()
            }
        };
        let mut weights = vec![0.0; self.amplitude.len()];
        for i in 0..last {
            let (a, b) = (angle(i), angle(i + 1));
            let (force, way) = (self.force[i + 1] - self.force[i], b.cos() - a.cos());
            if way == 0.0 {
                // Half of what the slope of g changes by, on either end.
                let bend = 0.5 * force * a.cos() / a.sin();
                weights[i] += bend;
                weights[i + 1] += bend;
                continue;
            }
            let slope = (0.5 * (b - a) - 0.25 * ((2.0 * b).sin() - (2.0 * a).sin())) / way;
            weights[i] += force * (slope + a.sin()) / way;
            weights[i + 1] -= force * (slope + b.sin()) / way;
        }
        let omega2 = self.harmonic_square();
        let factor = 1.0 / (PI * half * half);
        let all: f64 = weights.iter().sum();
        let stretched: f64 = weights.iter().enumerate().map(|(i, weight)| weight * place(i)).sum();
        weights.iter_mut().for_each(|weight| *weight *= factor);
        // The extremes move the middle and the range.
        let (by_middle, by_half) = (-factor * all, -factor * stretched - omega2 / half);
        let at = |wanted: f64| self.amplitude.iter().position(|q| *q == wanted);
        for (extreme, sign) in [(high, 1.0), (low, -1.0)] {
            if let Some(weight) = at(extreme).and_then(|i| weights.get_mut(i)) {
                *weight += 0.5 * (by_middle + sign * by_half);
            }
        }
        weights
    }

    /// Distance between the last and the first vertex relative to the loop's range.
    pub fn closure(&self) -> f64 {
        let (low, high) = self.extremes();
        match (self.amplitude.first(), self.amplitude.last()) {
            (Some(first), Some(last)) => (last - first).abs() / (high - low),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop of Mindlin's kind of so many vertices per quarter: the branches are `q = 1 - 2 b(x)` with `b(x) = 1 - (1 - x)^(2/3)` smooth up to their
    /// ends, and equal steps of force.
    fn branches(vertices_per_quarter: usize) -> Loop {
        let edges = 2 * vertices_per_quarter;
        let along = |i: usize| i as f64 / edges as f64;
        let slipped = |x: f64| (1.0 - (1.0 - 0.8 * x).powf(2.0 / 3.0)) / (1.0 - 0.2_f64.powf(2.0 / 3.0));
        let down = (0..=edges).map(|i| (1.0 - 2.0 * along(i), 1.0 - 2.0 * slipped(along(i))));
        let up = (1..=edges).map(|i| (2.0 * along(i) - 1.0, 2.0 * slipped(along(i)) - 1.0));
        let (force, amplitude) = down.chain(up).unzip();
        Loop { force, amplitude }
    }

    #[test]
    fn areas_are_of_fourth_order_and_first_harmonics_converge_faster_than_polygons() {
        // The integral of b over x from 0 to 1.
        let mean = (1.0 - 0.6 * (1.0 - 0.2_f64.powf(5.0 / 3.0)) / 0.8) / (1.0 - 0.2_f64.powf(2.0 / 3.0));
        let area = 4.0 * (1.0 - 2.0 * mean);
        let fine = branches(4096).harmonic_square();
        let errors = |n: usize| {
            let found = branches(n);
            let coarse = found.coarse_area().unwrap();
            [
                found.area() / area - 1.0,
                coarse / area - 1.0,
                found.polygon() / area - 1.0,
                found.harmonic_omega().powi(2) / fine - 1.0,
                found.harmonic_square() / fine - 1.0,
            ]
            .map(f64::abs)
        };
        for n in [4, 8, 16] {
            let ([of_area, coarse, polygon, harmonic, of_polygon], next) = (errors(n), errors(2 * n));
            assert!(next[0] < of_area / 10.0, "{n}: {of_area} {next:?}");
            assert!((next[1] / of_area - 1.0).abs() < 1e-6, "{n}: {of_area} {next:?}");
            assert!(
                of_area < 0.1 * polygon && of_area < coarse,
                "{n}: {of_area} {coarse} {polygon}"
            );
            assert!(harmonic < 0.3 * of_polygon, "{n}: {harmonic} {of_polygon}");
        }
        // Without pairs on both branches it is the polygon.
        let mut odd = branches(3);
        odd.force.truncate(11);
        odd.amplitude.truncate(11);
        assert_eq!(odd.area(), odd.polygon());
    }

    #[test]
    fn weights_are_slopes() {
        let n = 32;
        let of = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        let known = Loop {
            force: (0..=n).map(|i| 3.0 * of(i).cos()).collect(),
            amplitude: (0..=n)
                .map(|i| 0.2 + 1.5 * of(i).cos() + 0.1 * of(i).cos().powi(3) + 0.2 * of(i).sin() * of(i).sin().abs())
                .collect(),
        };
        for (i, weight) in known.area_weights().iter().enumerate() {
            let mut moved = known.clone();
            moved.amplitude[i] += 0.5;
            let slope = (moved.area() - known.area()) / 0.5;
            assert!((weight - slope).abs() < 1e-12, "{i}: {weight} {slope}");
        }
        let weights = known.harmonic_weights();
        // The first and the last vertex are both the largest: which of them is has a kink there.
        for (i, weight) in weights.iter().enumerate().take(n).skip(1) {
            let moved = |by: f64| {
                let mut moved = known.clone();
                moved.amplitude[i] += by;
                moved.harmonic_omega().powi(2)
            };
            let step = 1e-6;
            let difference = (moved(step) - moved(-step)) / (2.0 * step);
            assert!((weight - difference).abs() < 1e-7, "{i}: {weight} {difference}");
        }
    }

    #[test]
    fn the_first_harmonic_is_that_of_closed_forms() {
        let steps = 4000;
        let along = |i: usize| (2.0 * PI * i as f64 / steps as f64).cos();
        let loop_of = |force: &dyn Fn(usize, f64) -> f64| Loop {
            force: (0..=steps).map(|i| force(i, along(i))).collect(),
            amplitude: (0..=steps).map(|i| 0.3 + 2.0 * along(i)).collect(),
        };
        let linear = loop_of(&|_, c| 5.0 * 2.0 * c);
        assert!((linear.harmonic_omega() - 5.0_f64.sqrt()).abs() < 1e-12);
        // Duffing: k (1 + 3/4 e Q^2), where the secant has k (1 + e Q^2).
        let duffing = loop_of(&|_, c| 5.0 * (2.0 * c + 0.1 * (2.0 * c).powi(3)));
        let exact = 5.0 * (1.0 + 0.75 * 0.1 * 4.0);
        assert!((duffing.harmonic_omega().powi(2) / exact - 1.0).abs() < 1e-5);
        // Dry friction beside a spring has no part in phase with the motion but for the edges that it jumps on.
        let friction = loop_of(&|i, c| {
            10.0 * c
                - if i == 0 || i == steps {
                    -1.0
                } else {
                    (steps as f64 / 2.0 - i as f64).signum()
                }
        });
        assert!(
            (friction.harmonic_omega().powi(2) / 5.0 - 1.0).abs() < 1e-3,
            "{}",
            friction.harmonic_omega().powi(2)
        );
    }
}
