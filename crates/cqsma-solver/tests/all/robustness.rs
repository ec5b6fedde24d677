//! Units, noise floors, and what happens to loops that cannot be computed.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use cqsma_solver::cqsma::{Commit, Cycles, Settings, run};
use cqsma_solver::test_problems::{Jenkins, JenkinsChain};
use cqsma_solver::{
    BackbonePoint, Error, HystereticForce, LinearSolver, LoopObserver, LoopResult, NoObserver, PatternView, Reason,
    RegimeCounts, Sticking, modes, prestress,
};
use faer::Mat;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

fn loops<F: HystereticForce>(
    (stiffness, mass): (&Mat<f64>, &Mat<f64>),
    force: &F,
    load: &[f64],
    modal_forces: &[f64],
    settings: &Settings,
) -> Vec<BackbonePoint> {
    let (stiffness, mass) = (stiffness.as_ref(), mass.as_ref());
    let start = vec![0.0; load.len()];
    let rest = prestress::solve(stiffness, force, load, &start, &settings.newton)
        .unwrap()
        .unwrap();
    let mut line = modes::linearise(stiffness, mass, force, rest.displacement, rest.state, 1).unwrap();
    line.orient(&vec![1.0; load.len()]).unwrap();
    let points = run(&line, force, modal_forces, settings, |_| NoObserver).unwrap();
    points.into_iter().map(|(point, _)| point).collect()
}

fn scaled(matrix: &Mat<f64>, factor: f64) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| factor * matrix[(i, j)])
}

#[test]
fn units_change_neither_results_nor_effort() {
    // Lengths in units of `l` metres, masses of `m` kilograms, times of `t` seconds.
    let chain = JenkinsChain::new(12, 2000.0, (400.0, 1.0));
    let load: Vec<f64> = (0..12).map(|i| 0.2 * f64::from(i)).collect();
    let modal: Vec<f64> = (0..6).map(|i| 3.0_f64.powi(i)).collect();
    let settings = Settings::default();
    let si = loops((&chain.stiffness, &chain.mass), &chain.force, &load, &modal, &settings);
    for (l, m, t) in [(1e-3, 1e3, 1.0), (1e-6, 1e-9, 1e-3), (0.3048, 0.4536, 1.0)] {
        let (newton, per_length) = (t * t / (m * l), t * t / m);
        let force = Jenkins::new(vec![(400.0 * per_length, 1.0 * newton); 12]);
        let stiffness = scaled(&chain.stiffness, per_length);
        let mass = scaled(&chain.mass, 1.0 / m);
        let load: Vec<f64> = load.iter().map(|f| f * newton).collect();
        let modal: Vec<f64> = modal.iter().map(|a| a * t * t / (m.sqrt() * l)).collect();
        let other = loops((&stiffness, &mass), &force, &load, &modal, &settings);
        for (a, b) in si.iter().zip(&other) {
            let (effort, other_effort) = (a.effort, b.effort);
            let (a, b) = (a.result.as_ref().unwrap(), b.result.as_ref().unwrap());
            assert!(
                (b.omega / t / a.omega - 1.0).abs() < 1e-9,
                "{} {}",
                a.omega,
                b.omega / t
            );
            let noise = 1e-9 * a.zeta + a.zeta_floor + b.zeta_floor;
            assert!((a.zeta - b.zeta).abs() < noise, "{} {}", a.zeta, b.zeta);
            assert!(
                effort.iterations.abs_diff(other_effort.iterations) <= 1,
                "{effort:?} {other_effort:?}"
            );
            assert!(effort.krylov_steps.abs_diff(other_effort.krylov_steps) <= 2);
        }
    }
}

#[test]
fn loops_get_the_vertices_that_their_damping_needs() {
    // One slider, whose corner two vertices per quarter miss, and many, which slip one after the other.
    let one = JenkinsChain::new(1, 1000.0, (500.0, 2.0));
    let many = JenkinsChain::new(12, 2000.0, (400.0, 1.0));
    let with = |chain: &JenkinsChain, peak: f64, vertices_per_quarter: usize, cycles: Cycles| {
        let settings = Settings {
            vertices_per_quarter,
            cycles,
            ..Settings::default()
        };
        let load = vec![0.0; chain.mass.nrows()];
        let points = loops((&chain.stiffness, &chain.mass), &chain.force, &load, &[peak], &settings);
        points[0].result.clone().unwrap()
    };
    let corner = with(&one, 8.0, 2, Cycles::default());
    assert_eq!(corner.vertices_per_quarter(), 8);
    // The same as if they had been asked for.
    assert_eq!(corner, with(&one, 8.0, 8, Cycles::default()));
    let coarse = with(&one, 8.0, 2, Cycles::Fixed(2));
    let exact = 4.0 * 2.0 * (6.0 / 1000.0 - 2.0 / 500.0);
    assert_eq!(coarse.vertices_per_quarter(), 2);
    let of = |found: &LoopResult| (found.loop_area / exact - 1.0).abs();
    assert!(of(&corner) < 0.3 * of(&coarse), "{} {}", of(&corner), of(&coarse));
    let gradual = with(&many, 8.0, 4, Cycles::default());
    assert_eq!(gradual.vertices_per_quarter(), 4);
    // What dissipates nothing needs no more.
    assert_eq!(with(&one, 0.1, 2, Cycles::default()).vertices_per_quarter(), 2);
}

#[test]
fn the_floor_bounds_what_the_tolerance_does_to_damping() {
    let chain = JenkinsChain::new(12, 2000.0, (400.0, 1.0));
    let load: Vec<f64> = (0..12).map(|i| 0.2 * f64::from(i)).collect();
    // From far below the first slip to all elements slipping, eight decades.
    let modal: Vec<f64> = (0..9).map(|i| 1e-5 * 10.0_f64.powi(i)).collect();
    let with = |tolerance: f64| {
        let mut settings = Settings {
            // A loop that counts as closed too soon would be a difference of another kind.
            cycles: Cycles::Fixed(4),
            ..Settings::default()
        };
        settings.newton.tolerance = tolerance;
        loops((&chain.stiffness, &chain.mass), &chain.force, &load, &modal, &settings)
    };
    let exact = with(1e-13);
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10] {
        for (a, b) in with(tolerance).iter().zip(&exact) {
            let (a, b) = (a.result.as_ref().unwrap(), b.result.as_ref().unwrap());
            // The stuck structure, which the floor is derived for, is at most twice as stiff as the slipping one here.
            assert!(
                (a.zeta - b.zeta).abs() <= 2.0 * (a.zeta_floor + b.zeta_floor),
                "{tolerance:e}: {:e} {:e}, floor {:e}",
                a.zeta,
                b.zeta,
                a.zeta_floor
            );
            assert!(a.zeta_floor < 4.0 * tolerance, "{tolerance:e}: {:e}", a.zeta_floor);
        }
    }
    // Nothing slips at the smallest amplitudes: whatever is found there is noise, and said to be.
    assert!(exact[..4].iter().all(|p| !p.result.as_ref().unwrap().is_resolved()));
    assert!(exact[6..].iter().all(|p| p.result.as_ref().unwrap().is_resolved()));
}

#[test]
fn factorisations_and_krylov_steps_find_the_same_loops() {
    let chain = JenkinsChain::new(12, 2000.0, (400.0, 1.0));
    let load: Vec<f64> = (0..12).map(|i| 0.2 * f64::from(i)).collect();
    let with = |solver, commit| {
        let mut settings = Settings {
            solver,
            commit,
            ..Settings::default()
        };
        settings.newton.tolerance = 1e-12;
        loops(
            (&chain.stiffness, &chain.mass),
            &chain.force,
            &load,
            &[2.0, 20.0],
            &settings,
        )
    };
    for commit in [Commit::AtReversals, Commit::AtEveryVertex] {
        for (a, b) in with(LinearSolver::Krylov, commit)
            .iter()
            .zip(with(LinearSolver::Direct, commit))
        {
            assert_eq!(a.effort.factorisations, 0);
            assert!(b.effort.factorisations >= b.effort.iterations);
            let (a, b) = (a.result.as_ref().unwrap(), b.result.unwrap());
            assert!((a.omega / b.omega - 1.0).abs() < 1e-11, "{} {}", a.omega, b.omega);
            assert!(
                (a.zeta - b.zeta).abs() < a.zeta_floor + b.zeta_floor,
                "{} {}",
                a.zeta,
                b.zeta
            );
        }
    }
}

/// A hardening spring `k u (1 + (u / scale)^(2 power))` per coordinate that breaks beyond `limit`.
struct Hardening {
    stiffness: f64,
    scale: f64,
    power: i32,
    limit: f64,
    evaluations: AtomicUsize,
}

impl Hardening {
    fn new(power: i32, limit: f64) -> Self {
        Self {
            stiffness: 100.0,
            scale: 0.01,
            power,
            limit,
            evaluations: AtomicUsize::new(0),
        }
    }
}

impl HystereticForce for Hardening {
    type State = ();
    type Workspace = ();

    fn n_dofs(&self) -> usize {
        1
    }

    fn pattern(&self) -> PatternView<'_> {
        PatternView {
            indptr: &[0, 1],
            indices: &[0],
        }
    }

    fn initial_state(&self) {}

    fn workspace(&self) {}

    fn evaluate(
        &self,
        u: &[f64],
        _: Sticking,
        (): &(),
        (): &mut (),
        (): &mut (),
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> RegimeCounts {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let growth = (u[0] / self.scale).powi(2 * self.power);
        force[0] = if u[0].abs() > self.limit {
            f64::NAN
        } else {
            self.stiffness * u[0] * (1.0 + growth)
        };
        if let Some(tangent) = tangent {
            tangent[0] = self.stiffness * (1.0 + f64::from(2 * self.power + 1) * growth);
        }
        RegimeCounts::default()
    }
}

#[test]
fn steep_forces_are_solved_and_broken_ones_reported_while_others_go_on() {
    let (stiffness, mass) = (scaled(&Mat::identity(1, 1), 10.0), Mat::identity(1, 1));
    // A force of the seventh power: the linear prediction misses by many orders of magnitude.
    let steep = Hardening::new(3, f64::INFINITY);
    let modal = [0.1, 1.0, 10.0, 1e3, 1e5];
    for (point, alpha) in loops((&stiffness, &mass), &steep, &[0.0], &modal, &Settings::default())
        .iter()
        .zip(modal)
    {
        let r = point.result.as_ref().unwrap();
        // Displacement by bisection of the scalar equation.
        let balance = |u: f64| 10.0 * u + 100.0 * u * (1.0 + (u / 0.01).powi(6)) - alpha;
        let (mut low, mut high) = (0.0, 10.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if balance(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        assert!(
            (r.modal_amplitude / low - 1.0).abs() < 1e-8,
            "{alpha}: {} {low}",
            r.modal_amplitude
        );
        assert!(
            !r.is_resolved(),
            "an elastic force dissipates nothing: {} {}",
            r.zeta,
            r.zeta_floor
        );
    }

    // Beyond the limit there is no equilibrium: the smaller loops are found, the larger ones reported with their history.
    let broken = Hardening::new(3, 0.012);
    let points = loops(
        (&stiffness, &mass),
        &broken,
        &[0.0],
        &[0.1, 1e3, 1.0],
        &Settings::default(),
    );
    assert!(points[0].result.is_ok() && points[2].result.is_ok());
    let failure = points[1].result.as_ref().unwrap_err();
    assert!(
        matches!(failure.reason, Reason::NotFinite | Reason::Stalled),
        "{failure:?}"
    );
    assert!(!failure.history.is_empty());
    assert!(
        broken.evaluations.load(Ordering::Relaxed) < 10_000,
        "gives up in good time"
    );
}

#[test]
fn the_halves_have_their_own_frequencies_and_the_whole_does_not_know_the_sign() {
    // A static load close to the slip limit of one side makes the halves differ.
    let chain = JenkinsChain::new(6, 2000.0, (400.0, 1.0));
    let mut load = vec![0.0; 6];
    load[5] = 10.0;
    let newton = Settings::default().newton;
    let with = |sign: f64| {
        let (stiffness, mass) = (chain.stiffness.as_ref(), chain.mass.as_ref());
        let rest = prestress::solve(stiffness, &chain.force, &load, &[0.0; 6], &newton)
            .unwrap()
            .unwrap();
        let mut line = modes::linearise(stiffness, mass, &chain.force, rest.displacement, rest.state, 1).unwrap();
        line.orient(&[sign; 6]).unwrap();
        let settings = Settings {
            cycles: Cycles::Fixed(3),
            ..Settings::default()
        };
        let mut points = run(&line, &chain.force, &[8.0], &settings, |_| NoObserver).unwrap();
        points.remove(0).0.result.unwrap()
    };
    let (a, b) = (with(1.0), with(-1.0));
    let [up, down] = a.half_omegas;
    assert!((up / down - 1.0).abs() > 1e-3, "{up} {down}");
    assert!(a.omega > up.min(down) && a.omega < up.max(down));
    assert!((b.half_omegas[0] / down - 1.0).abs() < 1e-6 && (b.half_omegas[1] / up - 1.0).abs() < 1e-6);
    assert!((a.omega / b.omega - 1.0).abs() < 1e-8);
}

#[test]
fn a_loop_is_followed_until_it_closes() {
    let chain = JenkinsChain::new(6, 2000.0, (400.0, 1.0));
    let mut load = vec![0.0; 6];
    // Pulled backwards, so that the first cycle slips on its way back only.
    load[5] = -10.0;
    let with = |cycles| {
        let settings = Settings {
            cycles,
            ..Settings::default()
        };
        let mut points = loops((&chain.stiffness, &chain.mass), &chain.force, &load, &[8.0], &settings);
        points.remove(0).result.unwrap()
    };
    let until = |tolerance, most| with(Cycles::UntilClosed { tolerance, most });
    let closed = until(1e-6, 20);
    assert!(closed.closed && closed.closure < 1e-6 && closed.cycles > 1 && closed.cycles < 20);
    let first = with(Cycles::Fixed(1));
    assert!(
        first.closure > 1e-3,
        "the first cycle carries slip of the prestress: {}",
        first.closure
    );
    assert!((first.zeta / closed.zeta - 1.0).abs() > 1e-3);
    // The most cycles are kept, and what is open is called open.
    let open = until(1e-6, 1);
    assert!(!open.closed && open.cycles == 1);
    assert!((open.closure / first.closure - 1.0).abs() < 1e-6);
    for (tolerance, most) in [(0.0, 3), (f64::NAN, 3), (1e-6, 0)] {
        let cycles = Cycles::UntilClosed { tolerance, most };
        let settings = Settings {
            cycles,
            ..Settings::default()
        };
        let state = chain.force.initial_state();
        let (stiffness, mass) = (chain.stiffness.as_ref(), chain.mass.as_ref());
        let line = modes::linearise(stiffness, mass, &chain.force, vec![0.0; 6], state, 1).unwrap();
        let refused = run(&line, &chain.force, &[1.0], &settings, |_| NoObserver);
        assert!(matches!(refused, Err(Error::Setting { .. })), "{cycles:?}");
    }
}

struct StopsAt<'a>(&'a AtomicUsize);

impl<W> LoopObserver<W> for StopsAt<'_> {
    fn vertex(&mut self, _: f64, _: &[f64], _: &W) {}

    fn done(&mut self, _: &BackbonePoint) -> ControlFlow<()> {
        self.0.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Break(())
    }
}

#[test]
fn a_stopped_run_begins_no_more_loops() {
    let chain = JenkinsChain::new(6, 2000.0, (400.0, 1.0));
    let state = chain.force.initial_state();
    let (stiffness, mass) = (chain.stiffness.as_ref(), chain.mass.as_ref());
    let line = modes::linearise(stiffness, mass, &chain.force, vec![0.0; 6], state, 1).unwrap();
    let forces: Vec<f64> = (1..=500).map(f64::from).collect();
    let reported = AtomicUsize::new(0);
    let result = run(&line, &chain.force, &forces, &Settings::default(), |_| {
        StopsAt(&reported)
    });
    assert!(matches!(result, Err(Error::Interrupted)));
    let reported = reported.into_inner();
    assert!((1..100).contains(&reported), "{reported}");
}

#[test]
fn loops_and_motions_end_where_their_line_is_told_to() {
    let chain = JenkinsChain::new(6, 2000.0, (400.0, 1.0));
    let state = chain.force.initial_state();
    let (stiffness, mass) = (chain.stiffness.as_ref(), chain.mass.as_ref());
    let mut line = modes::linearise(stiffness, mass, &chain.force, vec![0.0; 6], state, 1).unwrap();
    let asked = AtomicUsize::new(0);
    let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 5;
    line.limits = line.limits.until(&stop);
    let reported = AtomicUsize::new(0);
    let loops = run(&line, &chain.force, &[1000.0], &Settings::default(), |_| {
        StopsAt(&reported)
    });
    assert!(matches!(loops, Err(Error::Interrupted)));
    assert_eq!(reported.into_inner(), 0, "within the first loop");
    let loading = cqsma_solver::loading::Settings::default();
    asked.store(0, Ordering::Relaxed);
    let points = cqsma_solver::masing::run(&line, &chain.force, &[1000.0], &loading);
    assert!(matches!(points, Err(Error::Interrupted)));
    asked.store(0, Ordering::Relaxed);
    let start = cqsma_solver::transient::Start::Release { modal_force: 1000.0 };
    let settings = cqsma_solver::transient::Settings::default();
    let motion = cqsma_solver::transient::run(&line, &chain.force, &[1.0; 6], &start, &settings, &mut |_| {
        ControlFlow::Continue(())
    });
    assert!(matches!(motion, Err(Error::Interrupted)));
}

#[test]
fn loads_within_the_round_off_of_the_static_forces_are_called_so() {
    let chain = JenkinsChain::new(6, 2000.0, (400.0, 1.0));
    let load = vec![0.1; 6];
    let (stiffness, mass) = (chain.stiffness.as_ref(), chain.mass.as_ref());
    let newton = Settings::default().newton;
    let rest = prestress::solve(stiffness, &chain.force, &load, &[0.0; 6], &newton)
        .unwrap()
        .unwrap();
    let mut line = modes::linearise(stiffness, mass, &chain.force, rest.displacement, rest.state, 1).unwrap();
    line.orient(&[1.0; 6]).unwrap();
    let linear = line.eigenvalues[0].sqrt();
    // Decades from far below the round-off of forces of 0.1 N to where friction is told.
    let modal: Vec<f64> = (-24..1).map(|i| 10.0_f64.powi(i)).collect();
    let points: Vec<BackbonePoint> = run(&line, &chain.force, &modal, &Settings::default(), |_| NoObserver)
        .unwrap()
        .into_iter()
        .map(|(point, _)| point)
        .collect();
    let mut found = 0;
    for point in &points {
        match &point.result {
            Ok(result) => {
                found += 1;
                // Whatever is given out as a frequency is one: its error is half of that of the motion.
                assert!(
                    (result.omega / linear - 1.0).abs() <= result.residual,
                    "{:e}: {} {linear}, {:e}",
                    point.modal_force,
                    result.omega,
                    result.residual
                );
                assert!(result.residual <= 1e-2);
            }
            Err(failure) => {
                assert_eq!(failure.reason, Reason::BelowRoundOff);
                assert!(failure.history[0] > 1e-2 && point.modal_force < 1e-13, "{failure:?}");
                assert_eq!(
                    (found, point.effort.iterations),
                    (0, 0),
                    "resolved above, refused below"
                );
            }
        }
    }
    assert!((12..22).contains(&found), "{found}");
    // The sweeps refuse the same amplitudes and go on with the larger ones.
    let settings = cqsma_solver::loading::Settings::default();
    let swept = cqsma_solver::masing::run(&line, &chain.force, &modal, &settings).unwrap();
    assert!(
        swept[0]
            .result
            .as_ref()
            .is_err_and(|f| f.reason == Reason::BelowRoundOff)
    );
    assert!(swept.last().unwrap().result.is_ok());
}

#[test]
fn a_static_load_within_round_off_is_no_equilibrium() {
    // Ends as far apart as 1e16 times what the load moves them by.
    let chain = JenkinsChain::new(2, 2000.0, (400.0, f64::INFINITY));
    let newton = Settings::default().newton;
    let far = prestress::solve(chain.stiffness.as_ref(), &chain.force, &[1e-16; 2], &[1e3; 2], &newton);
    let failure = far.unwrap().unwrap_err();
    assert_eq!(failure.reason, Reason::BelowRoundOff);
}
