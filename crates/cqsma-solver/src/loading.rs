//! Frequency and damping from an initial loading curve, by Masing's rule.
//!
//! Of elements that obey Masing's rule the branches of a closed loop are the initial loading curve, scaled by two and
//! turned around. The area of the loop between `-q` and `q` then follows from the curve alone:
//!
//! - `D = 8 (integral of alpha dq from 0 to q) - 4 alpha q`,
//! - `omega^2 = lambda = alpha / q`,
//! - `zeta = D / (2 pi q^2 omega^2)`.
//!
//! `D` is eight times the area between the curve and its chord, and of a polygon with vertices `i` exactly
//! `D = 4 sum_i q_i q_(i+1) (lambda_i - lambda_(i+1))`, a sum in which nothing large cancels: where the curve is
//! straight, `lambda` does not change.
//!
//! Masing's rule fails where pressure changes along the loop, where points open, and where slip is left from the static
//! load; curves start from the static state, in one direction.
//!
//! Source: G. Masing, *Eigenspannungen und Verfestigung beim Messing*, Proc. 2nd Int. Congress of Applied Mechanics,
//! Zurich 1926.

use crate::Error;
use crate::force::HystereticForce;
use crate::hysteresis::{Loop, SIMPSON};
use crate::modes::Linearisation;
use crate::newton::{Effort, Failure, LinearSolver, NewtonSettings, Reason};
use crate::path::Path;
use std::f64::consts::PI;

/// How a loading curve is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which mode, zero-based.
    pub mode: usize,
    /// Edges of the curve up to the first amplitude, and from each amplitude to the next.
    pub edges: usize,
    /// Newton's method; the tolerance refers to the load at hand.
    pub newton: NewtonSettings,
    /// How its linear systems are solved.
    pub solver: LinearSolver,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: 0,
            edges: 8,
            newton: NewtonSettings::default(),
            solver: LinearSolver::default(),
        }
    }
}

/// What a loading curve gives at one amplitude.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoadingResult {
    /// Modal force `alpha = lambda q` (sqrt(kg) m/s^2).
    pub modal_force: f64,
    /// Modal amplitude `q` (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// Frequency `sqrt(alpha / q)` (rad/s).
    pub omega: f64,
    /// Frequency from the first harmonic of the loop that Masing's rule makes of the curve
    /// ([`Loop::harmonic_omega`](crate::hysteresis::Loop::harmonic_omega), rad/s).
    pub harmonic_omega: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// What residuals may make of `zeta`: a smaller one is not resolved.
    pub zeta_floor: f64,
    /// Dissipation per cycle by Masing's rule (J).
    pub dissipation: f64,
    /// Residual relative to the load (energy norm).
    pub residual: f64,
    /// Displacement from the static state (m).
    pub displacement: Vec<f64>,
}

impl LoadingResult {
    /// Whether the damping is larger than what may be noise.
    pub fn is_resolved(&self) -> bool {
        self.zeta.abs() > self.zeta_floor
    }
}

/// One amplitude of a backbone from a loading curve.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoadingPoint {
    /// The result, or why there is none; beyond a failure all amplitudes have it.
    pub result: Result<LoadingResult, Failure>,
    /// Work done since the amplitude before.
    pub effort: Effort,
}

/// Refuses settings and targets (named `field`) outside their range.
pub(crate) fn check(settings: &Settings, field: &'static str, targets: &[f64]) -> Result<(), Error> {
    if settings.edges == 0 {
        return Err(Error::Setting {
            field: "edges",
            value: 0.0,
            requirement: "at least 1",
        });
    }
    let mut last = 0.0;
    for &value in targets {
        if !(value.is_finite() && value > last) {
            return Err(Error::Setting {
                field,
                value,
                requirement: "positive, finite and larger than the one before",
            });
        }
        last = value;
    }
    Ok(())
}

/// A curve, unless it ends because the run does.
pub(crate) fn finished<S>(
    structure: &Linearisation<'_, S>,
    curve: Vec<LoadingPoint>,
) -> Result<Vec<LoadingPoint>, Error> {
    let is_cut = curve.last().is_some_and(|point| point.result.is_err()) && structure.limits.stops();
    if is_cut { Err(Error::Interrupted) } else { Ok(curve) }
}

/// Goes from the static state through ascending targets; `state` reads modal amplitude `q` and `lambda = alpha / q`.
pub(crate) fn follow<F: HystereticForce>(
    mut path: Path<'_, F>,
    targets: &[f64],
    edges: usize,
    state: impl Fn(&Path<'_, F>) -> (f64, f64),
) -> Vec<LoadingPoint> {
    let mut curve = Curve::default();
    let mut failed: Option<Failure> = None;
    let mut from = 0.0;
    targets
        .iter()
        .map(|&target| {
            path.sequence.effort = Effort::default();
            let mut follow = || {
                for edge in 1..=edges {
                    let goal = if edge == edges {
                        target
                    } else {
                        from + (target - from) * edge as f64 / edges as f64
                    };
                    // The smallest amplitude is as well converged as the largest.
                    path.range = goal;
                    path.residual = 0.0;
                    path.advance(goal)?;
                    let (q, lambda) = state(&path);
                    curve.add(q, lambda, path.residual);
                }
                from = target;
                Ok(curve.result(&path))
            };
            let result = match &failed {
                Some(failure) => Err(failure.clone()),
                None => follow(),
            };
            // Larger amplitudes may be told from round-off where this one is not.
            if let Some(failure) = result.as_ref().err().filter(|f| f.reason != Reason::BelowRoundOff) {
                failed = Some(failure.clone());
            }
            LoadingPoint {
                result,
                effort: path.sequence.effort,
            }
        })
        .collect()
}

/// The polygon so far.
#[derive(Default)]
struct Curve {
    /// Last vertex and the one before it.
    last: Vertex,
    before: Vertex,
    /// All vertices, in the order of their amplitude.
    vertices: Vec<Vertex>,
    /// Of the polygon of all vertices, and of every second one.
    dissipation: [f64; 2],
    /// What the residuals of the vertices before the last may make of the dissipation.
    noise: f64,
}

#[derive(Clone, Copy, Default)]
struct Vertex {
    q: f64,
    lambda: f64,
    residual: f64,
}

impl Vertex {
    /// Change of the dissipation with an error of `lambda` of the size of the residual, if the neighbours of this
    /// vertex are `distance` apart.
    fn noise(&self, distance: f64) -> f64 {
        4.0 * self.residual.max(f64::EPSILON) * self.lambda * self.q * distance.abs()
    }
}

impl Curve {
    fn add(&mut self, q: f64, lambda: f64, residual: f64) {
        // Nothing lies between the origin, where q vanishes, and the first vertex but a straight edge.
        let edge = |from: Vertex| 4.0 * from.q * q * (from.lambda - lambda);
        self.dissipation[0] += edge(self.last);
        if self.vertices.len() % 2 == 1 {
            self.dissipation[1] += edge(self.before);
        }
        self.noise += self.last.noise(q - self.before.q);
        self.before = self.last;
        self.last = Vertex { q, lambda, residual };
        self.vertices.push(self.last);
    }

    /// By the rule of [`Loop::area`] (J).
    fn dissipation(&self) -> f64 {
        let [fine, coarse] = self.dissipation;
        if self.vertices.len().is_multiple_of(2) {
            SIMPSON[0] * fine + SIMPSON[1] * coarse
        } else {
            fine
        }
    }

    /// The closed loop whose branches are the curve, scaled by two and turned around.
    fn masing_loop(&self) -> Loop {
        let origin = (0.0, 0.0);
        let curve: Vec<(f64, f64)> = std::iter::once(origin)
            .chain(self.vertices.iter().map(|v| (v.lambda * v.q, v.q)))
            .collect();
        let (alpha, q) = (self.last.lambda * self.last.q, self.last.q);
        let down = curve.iter().map(|(a, x)| (alpha - 2.0 * a, q - 2.0 * x));
        let up = curve.iter().skip(1).map(|(a, x)| (2.0 * a - alpha, 2.0 * x - q));
        let (force, amplitude) = down.chain(up).unzip();
        Loop { force, amplitude }
    }

    fn result<F: HystereticForce>(&self, path: &Path<'_, F>) -> LoadingResult {
        let Vertex { q, lambda, residual } = self.last;
        let energy = 2.0 * PI * lambda * q * q;
        let dissipation = self.dissipation();
        LoadingResult {
            modal_force: lambda * q,
            modal_amplitude: q,
            omega: lambda.sqrt(),
            harmonic_omega: self.masing_loop().harmonic_omega(),
            zeta: dissipation / energy,
            zeta_floor: (self.noise + self.last.noise(self.before.q)) / energy,
            dissipation,
            residual,
            displacement: path.sequence.motion.v.clone(),
        }
    }
}
