//! Coupled quasi-static modal analysis (eqs. 40-42): the hysteresis loops of one mode against its inertial load.

use crate::Error;
use crate::force::HystereticForce;
use crate::hysteresis::Loop;
use crate::linear::{Motion, Stuck};
use crate::modes::{Linearisation, Mode};
use crate::newton::{Effort, Failure, LinearSolver, NewtonSettings, Sequence};
use crate::path::Path;
use crate::sensitivity::{Derivatives, DifferentiableForce, Follower, LoopRate};
use contact_laws::{RegimeCounts, Sticking};
use dense_algebra::{Inner, SystemMatrixRef, Vector, dot};
use faer::Mat;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// When the history reached becomes the one that later solves start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Commit {
    /// At load reversals, as published: the path of a point between two reversals counts as straight. Of laws whose stuck
    /// traction depends on the path this leaves a damping without slip, which [`LoopResult::zeta_floor`] contains.
    AtReversals,
    /// At every converged vertex: curved paths and local reversals are followed.
    #[default]
    AtEveryVertex,
}

/// How many cycles are computed, all with the same vertices. The first carries slip left over from the prestress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cycles {
    /// So many, of which the last is measured.
    Fixed(usize),
    /// Until a cycle closes, which is the measured one.
    ///
    /// Closed is a loop of modal force and amplitude, not the motion of every point: points under low pressure may creep on
    /// from cycle to cycle for ever, without a change of frequency or damping.
    UntilClosed {
        /// Part of the damping ratio that the gap between the ends of the loop may make up.
        tolerance: f64,
        /// Most cycles, the measured one included.
        most: usize,
    },
}

impl Default for Cycles {
    fn default() -> Self {
        Self::UntilClosed {
            tolerance: 2e-3,
            most: 20,
        }
    }
}

/// How the loops are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which mode, zero-based.
    pub mode: usize,
    /// Vertices per quarter of a loop; the measured loop has four times as many edges. Until loops close, as [`Cycles::UntilClosed`] has it, it is
    /// the least number: where half as many give another damping ratio, by 5 % and more than 1e-5, the loop is computed anew with twice as many,
    /// up to four times.
    pub vertices_per_quarter: usize,
    /// How many cycles are computed; the last one is measured.
    pub cycles: Cycles,
    /// When the history is committed.
    pub commit: Commit,
    /// Newton's method; the tolerance refers to the peak load of the loop.
    pub newton: NewtonSettings,
    /// How its linear systems are solved.
    pub solver: LinearSolver,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: 0,
            vertices_per_quarter: 4,
            cycles: Cycles::default(),
            commit: Commit::default(),
            newton: NewtonSettings::default(),
            solver: LinearSolver::default(),
        }
    }
}

/// Sees every converged vertex of the cycles.
pub trait LoopObserver<W>: Send {
    /// A cycle begins. It replaces the one seen before, which was not the last.
    fn begin(&mut self) {}

    /// `modal_force` and the total displacement; `workspace` is what the evaluation of the force there left.
    fn vertex(&mut self, modal_force: f64, displacement: &[f64], workspace: &W);

    /// The amplitude is done, with or without success. `Break` stops the run: loops under way are finished and
    /// reported, others not begun.
    fn done(&mut self, _point: &BackbonePoint) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// An observer that looks away.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoObserver;

impl<W> LoopObserver<W> for NoObserver {
    fn vertex(&mut self, _: f64, _: &[f64], _: &W) {}
}

/// What a measured loop gives.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopResult {
    /// Half the range of the modal amplitude, `q` (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// Secant frequency `sqrt(2 alpha / range(q))` (rad/s); it does not depend on the sign of the mode shape.
    pub omega: f64,
    /// Frequency from the first harmonic of the modal force in a sinusoidal motion ([`Loop::harmonic_omega`], rad/s): that of a
    /// free oscillation, and of harmonic balance, more closely than the secant.
    pub harmonic_omega: f64,
    /// Frequencies of the halves where the modal force is positive and where it is negative, `sqrt(alpha / |q|)` at the
    /// reversals, with `q` from the static state (rad/s).
    pub half_omegas: [f64; 2],
    /// `loop_area / (2 pi (q omega)^2)` (eq. 42).
    pub zeta: f64,
    /// What residuals, an open loop and, with commits at reversals, the history of points that do not slip may make of
    /// `zeta`: a smaller one is not resolved.
    pub zeta_floor: f64,
    /// Dissipation per cycle: area of the loop of modal force and amplitude, [`Loop::area`] (J).
    pub loop_area: f64,
    /// The same from every second vertex.
    pub coarse_loop_area: Option<f64>,
    /// Part of the motion at the peak that is mass-orthogonal to the mode, relative.
    pub shape_deviation: f64,
    /// Cycles computed, the measured one included.
    pub cycles: usize,
    /// Whether the loop closed within the tolerance asked for; always false for a fixed number of cycles.
    pub closed: bool,
    /// Whether the measured loop was computed one way only, because the cycle before it dissipated nothing and nothing slips
    /// or opens on the way.
    pub one_way: bool,
    /// Distance between the ends of the measured loop relative to the motion there (energy norm); zero where nothing dissipates.
    pub closure: f64,
    /// Largest residual at a vertex of this cycle and those before, relative to the peak load (energy norm).
    pub residual: f64,
    /// Regimes of the points at the positive peak.
    pub counts: RegimeCounts,
    /// The loop itself.
    pub hysteresis: Loop,
    /// Derivatives, parameter by parameter; none if they were not asked for, or a linear system for them could not be solved.
    #[cfg_attr(feature = "serde", serde(default))]
    pub rates: Option<Vec<LoopRate>>,
}

/// What a loop's polygon does not tell.
struct Circumstances {
    cycles: usize,
    closed: bool,
    one_way: bool,
    closure: f64,
    residual: f64,
    shape_deviation: f64,
    counts: RegimeCounts,
}

impl LoopResult {
    fn new(peak: f64, hysteresis: Loop, found: Circumstances) -> Self {
        let (low, high) = hysteresis.extremes();
        let modal_amplitude = 0.5 * (high - low);
        let middle = hysteresis.amplitude.len() / 2;
        let half = |at: Option<&f64>| at.map_or(f64::NAN, |q| (peak / q.abs()).sqrt());
        Self {
            modal_amplitude,
            omega: (peak / modal_amplitude).sqrt(),
            harmonic_omega: hysteresis.harmonic_omega(),
            half_omegas: [
                half(hysteresis.amplitude.last()),
                half(hysteresis.amplitude.get(middle)),
            ],
            zeta: hysteresis.zeta(peak),
            // A residual moves q by its own size, relative, and the sides of the loop add up to four times the peak force.
            zeta_floor: 2.0 * found.residual / PI + open_ends(&hysteresis),
            loop_area: hysteresis.area(),
            coarse_loop_area: hysteresis.coarse_area(),
            shape_deviation: found.shape_deviation,
            cycles: found.cycles,
            closed: found.closed,
            one_way: found.one_way,
            closure: found.closure,
            residual: found.residual,
            counts: found.counts,
            rates: None,
            hysteresis,
        }
    }

    /// Whether the damping is larger than what may be noise.
    pub fn is_resolved(&self) -> bool {
        self.zeta.abs() > self.zeta_floor
    }

    /// Vertices per quarter of the measured loop.
    pub fn vertices_per_quarter(&self) -> usize {
        self.hysteresis.force.len() / 4
    }

    /// Whether the vertices resolve the damping.
    fn has_enough_vertices(&self) -> bool {
        let energy = 2.0 * PI * (self.modal_amplitude * self.omega).powi(2);
        let change = self
            .coarse_loop_area
            .map_or(f64::INFINITY, |coarse| (self.loop_area - coarse).abs() / energy);
        change <= (RESOLVED * self.zeta.abs()).max(NEGLIGIBLE).max(self.zeta_floor)
    }

    /// Damping ratio with the frequency of the first harmonic in the place of the secant one in eq. 42.
    pub fn harmonic_zeta(&self) -> f64 {
        self.zeta * (self.omega / self.harmonic_omega).powi(2)
    }
}

/// Largest change of a damping ratio, relative, from half of the vertices to all of them: the error is smaller by an order.
const RESOLVED: f64 = 0.05;

/// Change of a damping ratio that the damping of any material hides.
const NEGLIGIBLE: f64 = 1e-5;

/// How many times vertices are doubled.
const MOST_DOUBLINGS: usize = 2;

/// Remainders where some points slip, over those with everything stuck; measured are up to 1.01.
const PARTIAL_SLIP: f64 = 1.1;

/// Damping ratio that the gap between the ends of a loop may make: they may be joined at any force between the peaks.
fn open_ends(hysteresis: &Loop) -> f64 {
    2.0 * hysteresis.closure() / PI
}

/// One amplitude of a backbone.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BackbonePoint {
    /// Peak modal force `alpha` (sqrt(kg) m/s^2).
    pub modal_force: f64,
    /// The result, or why there is none.
    pub result: Result<LoopResult, Failure>,
    /// Work done.
    pub effort: Effort,
}

/// Runs one loop per modal force, in parallel; each depends on the prestressed state alone, so results do not depend
/// on the number of threads. `observer(i)` makes the observer of loop `i`.
///
/// # Errors
/// Settings outside their range; [`Error::Interrupted`] if an observer or [`Linearisation::limits`] ended the run. A loop that does not converge is a point with a [`Failure`].
pub fn run<F: HystereticForce, O: LoopObserver<F::Workspace>>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    modal_forces: &[f64],
    settings: &Settings,
    observer: impl Fn(usize) -> O + Sync,
) -> Result<Vec<(BackbonePoint, O)>, Error> {
    run_followed(structure, force, modal_forces, settings, &observer, &|| None)
}

/// The same with the derivatives of every loop with respect to parameters ([`LoopResult::rates`]).
///
/// # Errors
/// As [`run`], and derivatives that belong to another mode.
pub fn run_differentiated<F: DifferentiableForce, O: LoopObserver<F::Workspace>>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    modal_forces: &[f64],
    settings: &Settings,
    derivatives: &Derivatives<'_, F>,
    observer: impl Fn(usize) -> O + Sync,
) -> Result<Vec<(BackbonePoint, O)>, Error> {
    if derivatives.mode() != settings.mode {
        return Err(Error::Setting {
            field: "mode",
            value: settings.mode as f64,
            requirement: "that of the derivatives",
        });
    }
    run_followed(structure, force, modal_forces, settings, &observer, &|| {
        Some(Box::new(derivatives.companion()))
    })
}

/// What goes along with a loop, made anew for each.
type Followers<'a, F> = dyn Fn() -> Option<Box<dyn Follower<F> + 'a>> + Sync + 'a;

fn run_followed<F: HystereticForce, O: LoopObserver<F::Workspace>>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    modal_forces: &[f64],
    settings: &Settings,
    observer: &(impl Fn(usize) -> O + Sync),
    followers: &Followers<'_, F>,
) -> Result<Vec<(BackbonePoint, O)>, Error> {
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
    match settings.cycles {
        Cycles::Fixed(n) => positive("cycles", n)?,
        Cycles::UntilClosed { tolerance, most } => {
            positive("cycles", most)?;
            if !(tolerance.is_finite() && tolerance > 0.0) {
                return Err(Error::Setting {
                    field: "cycles.tolerance",
                    value: tolerance,
                    requirement: "positive and finite",
                });
            }
        }
    }
    if let Some(&value) = modal_forces.iter().find(|a| !(a.is_finite() && **a > 0.0)) {
        return Err(Error::Setting {
            field: "modal_force",
            value,
            requirement: "positive and finite",
        });
    }
    let mode = Mode::try_new(structure, force.pattern(), settings.mode)?;
    let interrupted = AtomicBool::new(false);
    let points: Vec<Option<(BackbonePoint, O)>> = modal_forces
        .par_iter()
        .enumerate()
        // One by one from the end: the loops that take longest must not be the last to begin.
        .rev()
        .with_max_len(1)
        .map(|(index, &peak)| {
            if interrupted.load(Ordering::Relaxed) {
                return None;
            }
            let mut observer = observer(index);
            let point = run_loop(structure, force, &mode, peak, settings, &mut observer, followers);
            if point.result.is_err() && structure.limits.stops() {
                interrupted.store(true, Ordering::Relaxed);
                return None;
            }
            if observer.done(&point).is_break() {
                interrupted.store(true, Ordering::Relaxed);
            }
            Some((point, observer))
        })
        .collect();
    let points: Option<Vec<_>> = points.into_iter().rev().collect();
    points.filter(|_| !interrupted.into_inner()).ok_or(Error::Interrupted)
}

fn run_loop<F: HystereticForce, O: LoopObserver<F::Workspace>>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    mode: &Mode,
    peak: f64,
    settings: &Settings,
    observer: &mut O,
    followers: &Followers<'_, F>,
) -> BackbonePoint {
    let mut effort = Effort::default();
    let mut slipping = None;
    let mut settings = *settings;
    let mut doublings = match settings.cycles {
        Cycles::Fixed(_) => 0,
        Cycles::UntilClosed { .. } => MOST_DOUBLINGS,
    };
    let mut result = loop {
        let mut tracer = LoopTracer::new(structure, force, mode, peak, &settings);
        tracer.follower = followers();
        tracer.path.sequence.slipping = slipping;
        let found = tracer.measure(structure, observer);
        effort += tracer.path.sequence.effort;
        match found {
            Ok((found, _)) if doublings > 0 && !found.has_enough_vertices() => {}
            found => break found.map(|(found, numbers)| tracer.with_rates(found, &numbers)),
        }
        slipping = tracer.path.sequence.slipping.take();
        drop(tracer);
        doublings -= 1;
        settings.vertices_per_quarter *= 2;
    };
    let settings = &settings;
    if let Ok(found) = &mut result
        && settings.commit == Commit::AtReversals
        && force.dissipates()
    {
        let mut stuck = LoopTracer::new(structure, force, mode, peak, settings);
        stuck.path.sticking = Sticking::Full;
        // Without a stuck loop to compare with, all of the damping may be such a remainder.
        match stuck.remainder() {
            Ok(zeta) => found.zeta_floor += PARTIAL_SLIP * zeta,
            Err(failure) if failure.reason == crate::Reason::Interrupted => result = Err(failure),
            Err(_) => found.zeta_floor += found.zeta.abs(),
        }
        effort += stuck.path.sequence.effort;
    }
    BackbonePoint {
        modal_force: peak,
        result,
        effort,
    }
}

/// The loops of one amplitude.
struct LoopTracer<'a, F: HystereticForce> {
    mode: &'a Mode,
    peak: f64,
    settings: &'a Settings,
    path: Path<'a, F>,
    /// Most points that slipped at a vertex since it was last set to zero.
    most_slipping: usize,
    /// Fewest and most points that were open at a vertex.
    open: Option<[usize; 2]>,
    /// Goes along.
    follower: Option<Box<dyn Follower<F> + 'a>>,
    /// Factors and motions of the last branches down and up.
    walked: [Vec<(f64, Motion)>; 2],
}

/// The largest share of these motions that is not the mode, in the norm of the mass: of each the modal amplitude and what it has beside the mode.
fn shape_deviation(mass: SystemMatrixRef<'_>, motions: &[(f64, Vec<f64>)]) -> f64 {
    let beside = Mat::from_fn(mass.size(), motions.len(), |i, j| motions[j].1[i]);
    // Of all at once: reading the mass takes longest.
    let momenta = mass.product(beside.as_ref());
    let of_motion = motions.iter().enumerate().map(|(j, (q, beside))| {
        let square = beside
            .iter()
            .zip(momenta.col(j).iter())
            .map(|(v, m)| v * m)
            .sum::<f64>();
        let square = square.max(0.0);
        (square / (q * q + square)).sqrt()
    });
    of_motion.fold(0.0, f64::max)
}

impl<'a, F: HystereticForce> LoopTracer<'a, F> {
    fn new(
        structure: &'a Linearisation<'_, F::State>,
        force: &'a F,
        mode: &'a Mode,
        peak: f64,
        settings: &'a Settings,
    ) -> Self {
        let sequence = Sequence::new(force, Motion::zero(mode.shape.len()), structure.state.clone());
        let solution = (settings.solver, settings.newton);
        Self {
            mode,
            peak,
            settings,
            path: Path::new(structure.equilibrium(force), &mode.unit, peak, solution, sequence),
            most_slipping: 0,
            open: None,
            follower: None,
            walked: Default::default(),
        }
    }

    /// Follows the first loading and cycle after cycle, all with the same vertices: friction keeps what it is left with, and after coarser steps points
    /// near the onset of slip would shake down to another state, in which loops close as well. Gives the numbers of the vertices beside the loop, too.
    fn measure<O: LoopObserver<F::Workspace>>(
        &mut self,
        structure: &Linearisation<'_, F::State>,
        observer: &mut O,
    ) -> Result<(LoopResult, Vec<usize>), Failure> {
        let mut counts = self.branch(self.peak, self.settings.vertices_per_quarter, &mut |_| {})?;
        self.precondition();
        // Whether nothing that can be told from the residuals is dissipated.
        let mut quiet = !self.path.equilibrium.force.dissipates();
        let most = match self.settings.cycles {
            Cycles::Fixed(most) | Cycles::UntilClosed { most, .. } => most,
        };
        let mut cycles = 0;
        loop {
            cycles += 1;
            observer.begin();
            let (found, numbers) = self.loop_from_peak(structure, cycles, quiet, counts, observer)?;
            let is_quiet = found.closed && self.is_quiet(&found.hysteresis);
            if quiet || cycles >= most || (found.closed && !is_quiet) {
                return Ok((found, numbers));
            }
            quiet = is_quiet;
            counts = found.counts;
        }
    }

    /// A measured loop with its derivatives, if something goes along that knows its vertices by these numbers.
    fn with_rates(&self, mut found: LoopResult, numbers: &[usize]) -> LoopResult {
        let follower = self.follower.as_ref();
        found.rates = follower.and_then(|follower| follower.rates(&found.hysteresis, numbers, &self.path));
        found
    }

    /// Makes a preconditioner of the tangent at the peak where the steps that it is likely to spare take longer. Its inverse takes as long as an eighth as
    /// many products as there are coordinates; of the steps of the cycles, which take four times those of the first loading or more, it spares up to a
    /// half.
    fn precondition(&mut self) {
        let Path {
            equilibrium, sequence, ..
        } = &mut self.path;
        if sequence.slipping.is_some() || 16 * sequence.effort.krylov_steps < self.mode.shape.len() {
            return;
        }
        let force = equilibrium.force;
        let (pattern, tangent) = (force.pattern(), &sequence.tangent);
        sequence.slipping = Stuck::slipping(equilibrium.stiffness, pattern, tangent, force.reflections());
    }

    /// The loop from where the path is, at its positive peak, with the number of the cycle, whether those before dissipate nothing, and the regimes at the
    /// peak; and the numbers of its vertices by which a follower knows them.
    fn loop_from_peak<O: LoopObserver<F::Workspace>>(
        &mut self,
        structure: &Linearisation<'_, F::State>,
        cycles: usize,
        quiet: bool,
        counts_before: RegimeCounts,
        observer: &mut O,
    ) -> Result<(LoopResult, Vec<usize>), Failure> {
        let mut hysteresis = Loop::default();
        let mut numbers = Vec::new();
        // Modal amplitude at each reversal, and what the motion there has beside the mode.
        let mut reversals: Vec<(f64, Vec<f64>)> = Vec::new();
        // Without dissipation the way back passes the same vertices, which are kept for it.
        let mut passed: Vec<(Vec<f64>, F::Workspace)> = Vec::new();
        let mut total = vec![0.0; self.mode.shape.len()];
        let mut record = |tracer: &Self| {
            let v = &tracer.path.sequence.motion.v;
            tracer.record(&mut hysteresis);
            numbers.extend(tracer.follower.as_ref().map(|follower| follower.last()));
            for ((t, u), v) in total.iter_mut().zip(&structure.displacement).zip(v) {
                *t = u + v;
            }
            observer.vertex(tracer.path.at, &total, &tracer.path.sequence.workspace);
            if quiet {
                passed.push((total.clone(), tracer.path.sequence.workspace.clone()));
            }
            if tracer.path.at.abs() >= tracer.peak {
                let q = tracer.modal_amplitude();
                let beside = v.iter().zip(&tracer.mode.shape).map(|(v, phi)| v - q * phi);
                reversals.push((q, beside.collect()));
            }
        };
        record(self);
        let edges = 2 * self.settings.vertices_per_quarter;
        let start = self.path.sequence.motion.clone();
        self.most_slipping = 0;
        self.branch(-self.peak, edges, &mut record)?;
        // What slips or opens may dissipate less than the residuals of the cycle before it.
        let sticks = self.most_slipping == 0
            && !self.path.equilibrium.force.slips_in_parts()
            && self.open.is_some_and(|[fewest, most]| fewest == most);
        let one_way = quiet && (sticks || !self.path.equilibrium.force.dissipates());
        let (counts, closure) = if one_way {
            for (vertex, (total, workspace)) in passed.iter().enumerate().rev().skip(1) {
                let (force, amplitude) = (hysteresis.force[vertex], hysteresis.amplitude[vertex]);
                hysteresis.force.push(force);
                hysteresis.amplitude.push(amplitude);
                numbers.extend(numbers.get(vertex).copied());
                observer.vertex(force, total, workspace);
            }
            (counts_before, 0.0)
        } else {
            (self.branch(self.peak, edges, &mut record)?, self.distance(&start))
        };
        let closed = self.is_closed(&hysteresis);
        let found = LoopResult::new(
            self.peak,
            hysteresis,
            Circumstances {
                cycles,
                closed,
                one_way,
                closure,
                residual: self.path.residual,
                shape_deviation: shape_deviation(structure.mass, &reversals),
                counts,
            },
        );
        Ok((found, numbers))
    }

    /// Damping ratio that a loop with everything stuck has under this rule of history.
    fn remainder(&mut self) -> Result<f64, Failure> {
        let mut hysteresis = Loop::default();
        let mut record = |tracer: &Self| tracer.record(&mut hysteresis);
        for peak in [self.peak, -self.peak, self.peak] {
            self.branch(peak, 1, &mut |_| {})?;
        }
        record(self);
        let edges = 2 * self.settings.vertices_per_quarter;
        self.branch(-self.peak, edges, &mut record)?;
        self.branch(self.peak, edges, &mut record)?;
        Ok(hysteresis.zeta(self.peak).abs() + open_ends(&hysteresis))
    }

    /// Adds the vertex at hand to a loop.
    fn record(&self, hysteresis: &mut Loop) {
        hysteresis.force.push(self.path.at);
        hysteresis.amplitude.push(self.modal_amplitude());
    }

    fn modal_amplitude(&self) -> f64 {
        dot(&self.mode.unit.force, &self.path.sequence.motion.v)
    }

    /// Distance from `start` relative to the motion at hand (energy norm).
    fn distance(&self, start: &Motion) -> f64 {
        let mut difference = self.path.sequence.motion.clone();
        difference.add(-1.0, start);
        difference.norm() / self.path.sequence.motion.norm()
    }

    /// Damping ratio that the residuals may make.
    fn noise(&self) -> f64 {
        2.0 * self.path.residual / PI
    }

    /// Whether the ends of a loop are close enough together.
    fn is_closed(&self, hysteresis: &Loop) -> bool {
        let open = open_ends(hysteresis);
        match self.settings.cycles {
            Cycles::Fixed(_) => false,
            Cycles::UntilClosed { tolerance, .. } => {
                open <= self.noise() || open <= tolerance * hysteresis.zeta(self.peak).abs()
            }
        }
    }

    /// Whether a loop tells of no dissipation, and lies so well closed that this means something.
    fn is_quiet(&self, hysteresis: &Loop) -> bool {
        open_ends(hysteresis) <= self.noise() && hysteresis.zeta(self.peak).abs() <= self.noise()
    }

    /// Goes to `target` in `steps` equal steps, calls `record` at each, and commits the history at the end.
    fn branch(&mut self, target: f64, steps: usize, record: &mut dyn FnMut(&Self)) -> Result<RegimeCounts, Failure> {
        let start = self.path.at;
        let way = usize::from(target > start);
        self.path.guide = std::mem::take(&mut self.walked[way]);
        let mut walked = vec![(start, self.path.sequence.motion.clone())];
        let mut counts = RegimeCounts::default();
        for step in 1..=steps {
            let goal = if step == steps {
                target
            } else {
                start + (target - start) * step as f64 / steps as f64
            };
            counts = self.path.advance(goal)?;
            walked.push((goal, self.path.sequence.motion.clone()));
            if let Some(follower) = &mut self.follower {
                follower.vertex(&self.path);
            }
            self.most_slipping = self.most_slipping.max(counts.slip);
            let [fewest, most] = self.open.unwrap_or([counts.open; 2]);
            self.open = Some([fewest.min(counts.open), most.max(counts.open)]);
            if step < steps {
                record(self);
                if self.settings.commit == Commit::AtEveryVertex {
                    if let Some(follower) = &mut self.follower {
                        follower.commit();
                    }
                    self.path.sequence.commit();
                }
            }
        }
        // The end of the branch is recorded with the history that led to it.
        record(self);
        if let Some(follower) = &mut self.follower {
            follower.commit();
        }
        self.path.turn();
        // The first loading is like no branch after it.
        if start != 0.0 {
            self.walked[way] = walked;
        }
        Ok(counts)
    }
}
