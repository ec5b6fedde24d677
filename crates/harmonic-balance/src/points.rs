//! Points of a curve of forced responses that are found apart: resonances, peaks, given frequencies, and the stability of all of them.

use crate::Error;
use crate::force::PointwiseForce;
use crate::forced::{Curve, Held, Point, Settings, Tracer, amplitude};
use crate::harmonics::Harmonics;
use crate::load::Load;
use crate::solve::{BUDGET, Closure, Condition, Failure, solve};
use crate::stability::{self, Exponent};
use crate::system::{Parameter, Unknown};
use cqsma_solver::Linearisation;
use std::ops::ControlFlow;

/// Drop from a peak to the farther of its neighbours, relative to it, at which its height is known.
const PEAK: f64 = 4e-3;

/// Most points that are found for one peak.
const MOST_FOR_A_PEAK: usize = 12;

/// Shares of a harmonic above the first that are too small for their peaks to be looked for.
pub const LEAST_SHARE: f64 = 1e-3;

/// A point between two of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Between {
    /// Index of the last point of the curve before it.
    pub after: usize,
    /// The point.
    pub point: Point,
}

/// A peak whose height is not known to a thousandth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OpenPeak {
    /// The harmonic; above the first, of its share in the first.
    pub harmonic: usize,
    /// Angular frequency of the highest point (rad/s).
    pub omega: f64,
}

/// What curves are followed with, for points beside those followed.
pub struct Finder<'a, 's, F: PointwiseForce> {
    tracer: Tracer<'a, 's, F>,
}

impl<'a, 's, F: PointwiseForce> Finder<'a, 's, F> {
    /// For curves that [`follow`](crate::forced::follow) found with the same.
    ///
    /// # Errors
    /// Settings or sizes that do not fit.
    pub fn try_new(
        line: &'a Linearisation<'a, F::State>,
        law: &'a F,
        load: &Load,
        held: Held<'s>,
        settings: &'s Settings,
    ) -> Result<Self, Error> {
        Ok(Self {
            tracer: Tracer::new(line, law, load, held, settings)?,
        })
    }

    /// The resonances: one for each place where the part of the motion in phase with the load becomes negative towards higher frequencies, so that the point of a
    /// single force moves a quarter period behind it.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn resonances(&mut self, curve: &Curve) -> Result<Vec<Result<Between, Failure>>, Error> {
        let load = self.tracer.system.load.clone();
        let [from, to] = self.tracer.settings.range;
        let upwards = (to - from).signum();
        let in_phase = |point: &Point| upwards * load.along(&point.displacement)[0];
        let held = self.tracer.held;
        let free = match held {
            Held::Force(_) => &[Parameter::Square][..],
            Held::Response { .. } => &[Parameter::Square, Parameter::Force],
        };
        let conditions = |unknown: &Unknown, _: &Harmonics| {
            let [ahead, behind] = load.along(&unknown.v);
            let reference = ahead.hypot(behind);
            let mut gradient = Harmonics::zeros(unknown.v.size(), unknown.v.count());
            for (column, row) in [(1, &load.cosine), (2, &load.sine)] {
                let to = gradient.column_mut(column).iter_mut();
                to.zip(row).for_each(|(to, r)| *to = r / reference);
            }
            let phase = Condition {
                value: ahead / reference,
                gradient,
                along: vec![0.0; free.len()],
            };
            std::iter::once(phase)
                .chain(amplitude(unknown, held, 1.0, free.len()))
                .collect()
        };
        let closure = Closure {
            free,
            conditions: &conditions,
        };
        let mut found = Vec::new();
        for (after, pair) in curve.points.windows(2).enumerate() {
            let [before, behind] = [in_phase(&pair[0]), in_phase(&pair[1])];
            if !(before > 0.0 && behind <= 0.0) {
                continue;
            }
            let mut unknown = self.between(pair, before / (before - behind));
            let solved = solve(
                &self.tracer.system,
                &mut unknown,
                &closure,
                &self.tracer.settings.newton,
                &mut self.tracer.effort,
                BUDGET[0],
            );
            self.unless_interrupted()?;
            self.tracer.settle(&unknown.v);
            found.push(solved.map(|converged| {
                let mut point = self.tracer.point(&unknown, &converged);
                // Anew from the stiffness.
                point.residual = point.residual.max(self.tracer.system.imbalance(&unknown));
                Between { after, point }
            }));
        }
        Ok(found)
    }

    /// The points at an angular frequency (rad/s) that the curve passes.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn at(&mut self, curve: &Curve, omega: f64) -> Result<Vec<Result<Between, Failure>>, Error> {
        let mut found = Vec::new();
        for (after, pair) in curve.points.windows(2).enumerate() {
            let [before, behind] = [&pair[0], &pair[1]].map(|point| point.omega - omega);
            // A point of the curve itself counts for the pair that it ends, and the first one for that which it begins.
            if before * behind > 0.0 || before == behind || (before == 0.0 && after > 0) {
                continue;
            }
            let mut unknown = self.between(pair, before / (before - behind));
            *unknown.at_mut(Parameter::Square) = omega * omega;
            let solved = self.tracer.correct(&mut unknown, None);
            self.unless_interrupted()?;
            self.tracer.settle(&unknown.v);
            found.push(solved.map(|converged| Between {
                after,
                point: self.tracer.point(&unknown, &converged),
            }));
        }
        Ok(found)
    }

    /// Adds points to the curve about the peaks of the first harmonic of a displacement, and of the shares of the others in it, until each peak is known to a
    /// thousandth. Gives those for which that did not succeed.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn resolve_peaks(&mut self, curve: &mut Curve, row: &[f64]) -> Result<Vec<OpenPeak>, Error> {
        let mut open = Vec::new();
        let count = curve.points.first().map_or(0, |point| point.displacement.count());
        for h in 1..=count {
            let height = |point: &Point| {
                let along = point.displacement.along(row);
                let of = |h: usize| along[2 * h - 1].hypot(along[2 * h]);
                if h == 1 { of(1) } else { of(h) / of(1) }
            };
            let mut at = 1;
            while at + 1 < curve.points.len() {
                let here = height(&curve.points[at]);
                let is_peak = here > height(&curve.points[at - 1]) && here >= height(&curve.points[at + 1]);
                if is_peak && (h == 1 || here > LEAST_SHARE) {
                    let is_known;
                    (at, is_known) = self.resolve(curve, at, &height)?;
                    let omega = curve.points[at].omega;
                    open.extend((!is_known).then_some(OpenPeak { harmonic: h, omega }));
                }
                at += 1;
            }
        }
        Ok(open)
    }

    /// Adds points about a peak; the index of the highest, and whether its height is known.
    fn resolve(
        &mut self,
        curve: &mut Curve,
        mut at: usize,
        height: &dyn Fn(&Point) -> f64,
    ) -> Result<(usize, bool), Error> {
        for _ in 0..MOST_FOR_A_PEAK {
            let [low, top, high] = [at - 1, at, at + 1].map(|index| height(&curve.points[index]));
            if top - low.min(high) <= PEAK * top {
                return Ok((at, true));
            }
            let [before, here, behind] = [at - 1, at, at + 1].map(|index| self.unknown(&curve.points[index]));
            let [left, right] = [self.tracer.length(&before, &here), self.tracer.length(&here, &behind)];
            // The top of the parabola through the three, not too near to one of them.
            let (slope, other) = ((top - low) / left, (high - top) / right);
            let bend = (other - slope) / (left + right);
            let way = -0.5 * (slope + bend * left) / bend;
            let way = if way.abs() < 0.1 * left.max(right) {
                // The longer side is the one that is not known.
                if left > right { -0.3 * left } else { 0.3 * right }
            } else {
                way.clamp(-0.7 * left, 0.7 * right)
            };
            let (from, to, after, share, length) = match way < 0.0 {
                true => (&before, &here, at - 1, 1.0 + way / left, left),
                false => (&here, &behind, at, way / right, right),
            };
            if !(length > 0.0 && share > 0.0 && share < 1.0) {
                break;
            }
            let tangent = self.tracer.secant(from, to, length);
            let mut unknown = self.between(&curve.points[after..after + 2], share);
            let predicted = unknown.clone();
            let solved = self.tracer.correct(&mut unknown, Some((&predicted, &tangent)));
            self.unless_interrupted()?;
            let Ok(converged) = solved else { break };
            self.tracer.settle(&unknown.v);
            curve.insert(after, self.tracer.point(&unknown, &converged));
            let candidates = [at - 1, at, at + 1, at + 2];
            let highest = candidates
                .into_iter()
                .max_by(|a, b| height(&curve.points[*a]).total_cmp(&height(&curve.points[*b])));
            at = highest
                .filter(|at| *at > 0 && at + 1 < curve.points.len())
                .unwrap_or(at);
        }
        Ok((at, false))
    }

    /// Floquet exponents of all points, each under its load; `observe` hears how many are judged and may stop the run.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn exponents(
        &self,
        curve: &Curve,
        observe: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<Result<Vec<Exponent>, Failure>>, Error> {
        let mut found = Vec::with_capacity(curve.points.len());
        for point in &curve.points {
            let exponents = stability::exponents(&self.tracer.system, point);
            self.unless_interrupted()?;
            found.push(exponents);
            if observe(found.len()).is_break() {
                return Err(Error::Interrupted);
            }
        }
        Ok(found)
    }

    fn unless_interrupted(&self) -> Result<(), Error> {
        match self.tracer.system.line().limits.stops() {
            true => Err(Error::Interrupted),
            false => Ok(()),
        }
    }

    fn unknown(&self, point: &Point) -> Unknown {
        let mut unknown = Unknown {
            p: point.displacement.clone(),
            v: point.displacement.clone(),
            parameters: [point.omega * point.omega, 0.0, point.force],
        };
        self.tracer.system.restore(&mut unknown);
        unknown
    }

    /// A guess between two points.
    fn between(&self, pair: &[Point], weight: f64) -> Unknown {
        let mut point = pair[0].clone();
        point.displacement.scale(1.0 - weight);
        point.displacement.add(weight, &pair[1].displacement);
        let between = |of: fn(&Point) -> f64| (1.0 - weight) * of(&pair[0]) + weight * of(&pair[1]);
        (point.omega, point.force) = (between(|p| p.omega), between(|p| p.force));
        self.unknown(&point)
    }
}
