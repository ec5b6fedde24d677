//! Coupled quasi-static modal analysis (eqs. 40-42): the hysteresis loops of one mode against its inertial load.

use crate::Error;
use crate::force::{HystereticForce, PointCounts, Sliding};
use crate::hysteresis::Loop;
use crate::linear::{dot, multiply};
use crate::modes::Linearisation;
use crate::newton::{Effort, Equilibrium, Failure, NewtonSettings, Strategy, Walk};
use rayon::prelude::*;

/// When the history reached becomes the one that later solves start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Commit {
    /// At load reversals, as published: the path of a point between two reversals counts as straight.
    #[default]
    AtReversals,
    /// At every converged vertex: curved paths and local reversals are followed, at the cost of walking every cycle in
    /// full.
    AtEveryVertex,
}

/// How the loops are walked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which mode, zero-based.
    pub mode: usize,
    /// Vertices per quarter of a loop; the measured loop has four times as many edges.
    pub vertices_per_quarter: usize,
    /// Cycles walked; the last one is measured. The first carries slip left over from the prestress.
    pub cycles: usize,
    /// When the history is committed.
    pub commit: Commit,
    /// Newton's method; the tolerance refers to the peak load of the loop.
    pub newton: NewtonSettings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: 0,
            vertices_per_quarter: 8,
            cycles: 2,
            commit: Commit::default(),
            newton: NewtonSettings::default(),
        }
    }
}

/// Sees every converged vertex of the measured loop.
pub trait LoopObserver<S>: Send {
    /// `modal_force` and the total displacement; `begin` is the history that the force at this vertex starts from.
    fn vertex(&mut self, modal_force: f64, displacement: &[f64], begin: &S);
}

/// An observer that looks away.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoObserver;

impl<S> LoopObserver<S> for NoObserver {
    fn vertex(&mut self, _: f64, _: &[f64], _: &S) {}
}

/// What a measured loop gives.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopResult {
    /// Half the range of the modal amplitude, `q` (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// Secant frequency `sqrt(2 alpha / range(q))` (rad/s).
    pub omega: f64,
    /// `loop_area / (2 pi (q omega)^2)` (eq. 42).
    pub zeta: f64,
    /// Dissipation per cycle: area of the polygon of modal force and amplitude (J).
    pub loop_area: f64,
    /// The same from every second vertex.
    pub coarse_loop_area: Option<f64>,
    /// Part of the motion at the peak that is mass-orthogonal to the mode, relative.
    pub shape_deviation: f64,
    /// Gap between the ends of the loop relative to its range.
    pub closure: f64,
    /// Largest residual at a vertex, relative to the peak load (energy norm).
    pub residual: f64,
    /// Regimes of the points at the positive peak.
    pub counts: PointCounts,
    /// The loop itself.
    pub hysteresis: Loop,
}

/// One amplitude of a backbone.
#[derive(Clone, Debug, PartialEq)]
pub struct BackbonePoint {
    /// Peak modal force `alpha` (sqrt(kg) m/s^2).
    pub modal_force: f64,
    /// The result, or why there is none.
    pub result: Result<LoopResult, Failure>,
    /// Work done.
    pub effort: Effort,
}

/// Runs one loop per modal force, in parallel; each depends on the prestressed state alone, so results do not depend
/// on the number of threads. `observer(i)` makes the observer of loop `i`; `done` hears when a loop ends.
///
/// # Errors
/// Settings outside their range. A loop that does not converge is a point with a [`Failure`].
pub fn run<F: HystereticForce, O: LoopObserver<F::State>>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    modal_forces: &[f64],
    settings: &Settings,
    observer: impl Fn(usize) -> O + Sync,
    done: impl Fn() + Sync,
) -> Result<Vec<(BackbonePoint, O)>, Error> {
    if settings.mode >= structure.shapes.ncols() {
        return Err(Error::Setting {
            field: "mode",
            value: settings.mode as f64,
            requirement: "less than the number of linearised modes (counted from 0)",
        });
    }
    let positive = |field, value: usize| {
        let requirement = "at least 1";
        if value == 0 {
            Err(Error::Setting {
                field,
                value: 0.0,
                requirement,
            })
        } else {
            Ok(())
        }
    };
    positive("vertices_per_quarter", settings.vertices_per_quarter)?;
    positive("cycles", settings.cycles)?;
    if let Some(&value) = modal_forces.iter().find(|a| !(a.is_finite() && **a > 0.0)) {
        return Err(Error::Setting {
            field: "modal_force",
            value,
            requirement: "positive and finite",
        });
    }
    let shape: Vec<f64> = structure.shapes.col(settings.mode).iter().copied().collect();
    let mut pattern = vec![0.0; shape.len()];
    multiply(structure.mass, &shape, &mut pattern);
    let scale = structure.factor.energy_norm(&pattern, &mut Vec::new());
    let mode = Mode {
        shape,
        pattern,
        scale,
        omega2: structure.eigenvalues[settings.mode],
    };
    Ok(modal_forces
        .par_iter()
        .enumerate()
        .map(|(index, &peak)| {
            let mut observer = observer(index);
            let point = run_loop(structure, force, &mode, peak, settings, &mut observer);
            done();
            (point, observer)
        })
        .collect())
}

struct Mode {
    shape: Vec<f64>,
    /// `M phi`: the load of unit modal force.
    pattern: Vec<f64>,
    /// Its energy norm.
    scale: f64,
    omega2: f64,
}

fn run_loop<F: HystereticForce, O: LoopObserver<F::State>>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    mode: &Mode,
    peak: f64,
    settings: &Settings,
    observer: &mut O,
) -> BackbonePoint {
    let nc = force.n_dofs();
    let equilibrium = Equilibrium {
        stiffness: structure.stiffness,
        force,
        factor: &structure.factor,
        reference: &structure.displacement[..nc],
        reference_force: &structure.contact_force,
    };
    let walk = Walk::new(force, vec![0.0; mode.shape.len()], structure.state.clone());
    let mut tour = Tour {
        equilibrium,
        mode,
        peak,
        settings,
        walk,
        at: 0.0,
        previous: None,
        residual: 0.0,
        load: mode.pattern.clone(),
    };
    let result = tour.measure(structure, observer);
    BackbonePoint {
        modal_force: peak,
        result,
        effort: tour.walk.effort,
    }
}

/// A walk along the modal force.
struct Tour<'a, F: HystereticForce> {
    equilibrium: Equilibrium<'a, F>,
    mode: &'a Mode,
    peak: f64,
    settings: &'a Settings,
    walk: Walk<F>,
    /// Modal force reached.
    at: f64,
    /// An earlier point of the same branch, for extrapolation.
    previous: Option<(f64, Vec<f64>)>,
    residual: f64,
    load: Vec<f64>,
}

impl<F: HystereticForce> Tour<'_, F> {
    fn measure<O: LoopObserver<F::State>>(
        &mut self,
        structure: &Linearisation<'_, F::State>,
        observer: &mut O,
    ) -> Result<LoopResult, Failure> {
        // With commits at reversals only, the vertices between them do not influence what follows: the cycles before
        // the measured one need no more than their reversals.
        let quarter = self.settings.vertices_per_quarter;
        let (loading, half) = match self.settings.commit {
            Commit::AtReversals => (1, 1),
            Commit::AtEveryVertex => (quarter, 2 * quarter),
        };
        self.branch(self.peak, loading, &mut |_| {})?;
        for _ in 1..self.settings.cycles {
            self.branch(-self.peak, half, &mut |_| {})?;
            self.branch(self.peak, half, &mut |_| {})?;
        }
        let mut hysteresis = Loop::default();
        let mut total = vec![0.0; self.mode.shape.len()];
        let mut deviation = 0.0_f64;
        self.residual = 0.0;
        let mut record = |tour: &Self| {
            let v = &tour.walk.v;
            let q = dot(&tour.mode.pattern, v);
            hysteresis.force.push(tour.at);
            hysteresis.amplitude.push(q);
            for ((t, u), v) in total.iter_mut().zip(&structure.displacement).zip(v) {
                *t = u + v;
            }
            observer.vertex(tour.at, &total, &tour.walk.begin);
            if tour.at.abs() >= tour.peak {
                let rest: Vec<f64> = v.iter().zip(&tour.mode.shape).map(|(v, phi)| v - q * phi).collect();
                let mut momentum = vec![0.0; v.len()];
                multiply(structure.mass, &rest, &mut momentum);
                let orthogonal = dot(&rest, &momentum).max(0.0);
                deviation = deviation.max((orthogonal / (q * q + orthogonal)).sqrt());
            }
        };
        record(self);
        self.branch(-self.peak, 2 * quarter, &mut record)?;
        let counts = self.branch(self.peak, 2 * quarter, &mut record)?;
        let (low, high) = hysteresis.extremes();
        let modal_amplitude = 0.5 * (high - low);
        let omega = (self.peak / modal_amplitude).sqrt();
        let loop_area = hysteresis.area();
        Ok(LoopResult {
            modal_amplitude,
            omega,
            zeta: loop_area / (2.0 * std::f64::consts::PI * (modal_amplitude * omega).powi(2)),
            loop_area,
            coarse_loop_area: hysteresis.coarse_area(),
            shape_deviation: deviation,
            closure: hysteresis.closure(),
            residual: self.residual,
            counts,
            hysteresis,
        })
    }

    /// Walks to `target` in `steps` equal steps, calls `record` at each, and commits the history at the end.
    fn branch(&mut self, target: f64, steps: usize, record: &mut dyn FnMut(&Self)) -> Result<PointCounts, Failure> {
        let start = self.at;
        let mut counts = PointCounts::default();
        self.previous = None;
        for step in 1..=steps {
            let goal = if step == steps {
                target
            } else {
                start + (target - start) * step as f64 / steps as f64
            };
            counts = self.advance(goal)?;
            if step < steps {
                record(self);
                if self.settings.commit == Commit::AtEveryVertex {
                    self.walk.commit();
                }
            }
        }
        // The end of the branch is recorded with the history that led to it.
        record(self);
        self.walk.commit();
        Ok(counts)
    }

    /// Solves at `goal`; a step that fails is halved.
    fn advance(&mut self, goal: f64) -> Result<PointCounts, Failure> {
        let mut targets = vec![goal];
        let smallest = 1e-3 * self.peak;
        let mut counts = PointCounts::default();
        while let Some(&next) = targets.last() {
            let origin = self.walk.v.clone();
            let step = next - self.at;
            match &self.previous {
                // Along the secant of the branch.
                Some((earlier, v)) if *earlier != self.at => {
                    let ratio = step / (self.at - earlier);
                    for i in 0..origin.len() {
                        self.walk.v[i] = origin[i] + ratio * (origin[i] - v[i]);
                    }
                }
                // After a reversal everything sticks: along the mode.
                _ => {
                    for i in 0..origin.len() {
                        self.walk.v[i] = origin[i] + step / self.mode.omega2 * self.mode.shape[i];
                    }
                }
            }
            for (load, pattern) in self.load.iter_mut().zip(&self.mode.pattern) {
                *load = next * pattern;
            }
            let outcome = self.equilibrium.solve(
                &mut self.walk,
                &self.load,
                self.peak * self.mode.scale,
                Sliding::Allowed,
                Strategy::Krylov,
                &self.settings.newton,
            );
            match outcome {
                Ok(converged) => {
                    self.previous = Some((self.at, origin));
                    self.at = next;
                    self.residual = self.residual.max(converged.residual);
                    counts = converged.counts;
                    targets.pop();
                }
                Err(failure) => {
                    self.walk.v.copy_from_slice(&origin);
                    if step.abs() < smallest {
                        return Err(failure);
                    }
                    targets.push(self.at + 0.5 * step);
                }
            }
        }
        Ok(counts)
    }
}
