//! Frequency and damping against amplitude: hysteresis loops and free periodic motions.

use super::structure::{Begin, StaticState, Structure, linear_modes, of_solver};
use crate::arrays::list;
use crate::error::{Exception, input};
use crate::laws::choice;
use crate::work::{Monitor, pool, supervise};
use cqsma_solver::cqsma::{self, Commit, Cycles, LoopObserver};
use cqsma_solver::{BackbonePoint, Failure, NewtonSettings};
use faer::Mat;
use harmonic_balance::backbone::{self, Accuracy, Kind, Point};
use harmonic_balance::{Harmonics, Sampling};
use joints::progress::Progress;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Of a static state, its linear modes, and an analysis about it.
pub(super) type AboutStaticState<T> = (StaticState, Modes, T);

/// Linear modes.
pub(super) struct Modes {
    pub(super) frequencies: Vec<f64>,
    pub(super) shapes: Mat<f64>,
}

/// Where a run is stopped.
struct Watch<'a, 'b> {
    monitor: &'a Monitor<'b>,
}

impl<W> LoopObserver<W> for Watch<'_, '_> {
    fn vertex(&mut self, _: f64, _: &[f64], _: &W) {}

    fn done(&mut self, _: &BackbonePoint) -> ControlFlow<()> {
        flow(self.monitor)
    }
}

pub(super) fn flow(monitor: &Monitor<'_>) -> ControlFlow<()> {
    match monitor.interrupted() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

/// A result with its static state and modes as a dictionary; of a static state that was not found, the reason.
pub(super) fn to_python<'py, T>(
    py: Python<'py>,
    structure: &Structure,
    found: Result<AboutStaticState<T>, Failure>,
    result: impl FnOnce(&Bound<'py, PyDict>, T) -> PyResult<()>,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    match found {
        Err(failure) => {
            all.set_item("failure", failure.reason.to_string())?;
            all.set_item("history", list(py, failure.history))?;
        }
        Ok((rest, modes, analysis)) => {
            let recovery = structure.reduced.recovery.as_ref();
            all.set_item("static", rest.to_python(py)?)?;
            all.set_item(
                "modes",
                linear_modes(py, recovery, modes.frequencies, modes.shapes.as_ref())?,
            )?;
            result(&all, analysis)?;
        }
    }
    Ok(all)
}

/// Most vertices per quarter of a loop.
const MOST_VERTICES: usize = 100_000;

/// Most harmonics and samples of a period.
const MOST_SAMPLING: [usize; 2] = [200, 1 << 16];

/// Refuses what would take no end of time and memory.
pub(super) fn check_most(name: &str, value: usize, most: usize) -> Result<(), Exception> {
    match value <= most {
        true => Ok(()),
        false => Err(input(format!("{name} is {value}; it must be at most {most}"))),
    }
}

/// Refuses tolerances that nothing can reach, or anything.
pub(super) fn check_tolerance(name: &str, value: f64) -> Result<(), Exception> {
    match value > 0.0 && value < 1.0 {
        true => Ok(()),
        false => Err(input(format!("{name} is {value}; it must be above 0 and below 1"))),
    }
}

/// Refuses amplitudes that no analysis takes.
fn check_amplitudes(amplitudes: &[f64]) -> Result<(), Exception> {
    match amplitudes.iter().find(|q| !(q.is_finite() && **q > 0.0)) {
        Some(q) => Err(input(format!(
            "modal_amplitudes holds {q}; all must be positive and finite"
        ))),
        None => Ok(()),
    }
}

/// Hysteresis loops of a mode, at amplitudes that hold by linear estimate.
#[pyfunction]
pub(crate) fn run_cqsma<'py>(
    py: Python<'py>,
    structure: &Structure,
    modal_amplitudes: Vec<f64>,
    mode: usize,
    n_linear_modes: usize,
    closure: Option<f64>,
    vertices_per_quarter: usize,
    cycles: Option<usize>,
    until_closed: f64,
    max_cycles: usize,
    commit: &str,
    tolerance: f64,
    max_iterations: usize,
    threads: Option<i64>,
) -> PyResult<Bound<'py, PyDict>> {
    check_amplitudes(&modal_amplitudes)?;
    check_tolerance("tolerance", tolerance)?;
    check_most("vertices_per_quarter", vertices_per_quarter, MOST_VERTICES)?;
    let newton = NewtonSettings {
        tolerance,
        max_iterations,
        ..NewtonSettings::default()
    };
    let commits = [
        ("every-vertex", Commit::AtEveryVertex),
        ("reversals", Commit::AtReversals),
    ];
    let settings = cqsma::Settings {
        mode,
        vertices_per_quarter,
        cycles: cycles.map_or(
            Cycles::UntilClosed {
                tolerance: until_closed,
                most: max_cycles,
            },
            Cycles::Fixed,
        ),
        commit: choice("commit", commit, &commits)?,
        newton,
        ..cqsma::Settings::default()
    };
    let begin = Begin {
        closure,
        newton,
        n_modes: n_linear_modes.max(mode.saturating_add(1)),
    };
    let pool = pool(threads)?;
    let found = supervise(py, &pool, None, |monitor| {
        let rest = match structure.rest(&begin)? {
            Ok(rest) => rest,
            Err(failure) => return Ok(Err(failure)),
        };
        let line = structure.linearise(&begin, &rest)?;
        check_mode(mode, line.eigenvalues.len())?;
        let forces: Vec<f64> = modal_amplitudes.iter().map(|q| line.eigenvalues[mode] * q).collect();
        let points =
            cqsma::run(&line, &structure.force(), &forces, &settings, |_| Watch { monitor }).map_err(of_solver)?;
        let points: Vec<BackbonePoint> = points.into_iter().map(|(point, _)| point).collect();
        let modes = Modes {
            frequencies: line.frequencies(),
            shapes: line.shapes.clone(),
        };
        drop(line);
        Ok::<_, Exception>(Ok((rest, modes, points)))
    })??;
    to_python(py, structure, found, |all, points| loops(all, &points))
}

/// Free periodic motions at modal amplitudes.
#[pyfunction]
pub(crate) fn run_epmc<'py>(
    py: Python<'py>,
    structure: &Structure,
    modal_amplitudes: Vec<f64>,
    mode: usize,
    n_linear_modes: usize,
    closure: Option<f64>,
    sampling: [usize; 3],
    accuracy: Option<[f64; 3]>,
    max_sampling: [usize; 2],
    tolerance: f64,
    max_iterations: usize,
    static_tolerance: f64,
    threads: Option<i64>,
) -> PyResult<Bound<'py, PyDict>> {
    check_amplitudes(&modal_amplitudes)?;
    let [harmonics, samples, periods] = sampling;
    check_tolerance("tolerance", tolerance)?;
    check_tolerance("static_tolerance", static_tolerance)?;
    for target in accuracy.iter().flatten() {
        check_tolerance("accuracy", *target)?;
    }
    check_most("max_harmonics", max_sampling[0], MOST_SAMPLING[0])?;
    check_most("max_samples", max_sampling[1], MOST_SAMPLING[1])?;
    let settings = backbone::Settings {
        mode,
        sampling: Sampling {
            harmonics,
            samples,
            periods,
        },
        accuracy: accuracy.map(|[frequency, damping, damping_floor]| Accuracy {
            frequency,
            damping,
            damping_floor,
            max_harmonics: max_sampling[0],
            max_samples: max_sampling[1],
        }),
        newton: harmonic_balance::NewtonSettings {
            tolerance,
            max_iterations,
            ..harmonic_balance::NewtonSettings::default()
        },
    };
    let begin = Begin {
        closure,
        newton: NewtonSettings {
            tolerance: static_tolerance,
            ..NewtonSettings::default()
        },
        n_modes: n_linear_modes.max(mode.saturating_add(1)),
    };
    let pool = pool(threads)?;
    let found = supervise(py, &pool, None, |monitor| {
        let rest = match structure.rest(&begin)? {
            Ok(rest) => rest,
            Err(failure) => return Ok(Err(failure)),
        };
        let line = structure.linearise(&begin, &rest)?;
        check_mode(mode, line.eigenvalues.len())?;
        let points = backbone::follow(
            &line,
            &structure.force(),
            Kind::Free,
            &modal_amplitudes,
            &settings,
            Vec::new(),
            &mut |_| flow(monitor),
        )
        .map_err(|error| input(error.to_string()))?;
        let modes = Modes {
            frequencies: line.frequencies(),
            shapes: line.shapes.clone(),
        };
        drop(line);
        Ok::<_, Exception>(Ok((rest, modes, points)))
    })??;
    to_python(py, structure, found, |all, points| structure.motions(all, &points))
}

/// Refuses a mode that the structure does not have.
pub(super) fn check_mode(mode: usize, found: usize) -> Result<(), Exception> {
    if mode < found {
        return Ok(());
    }
    Err(input(format!(
        "mode is {mode}, counted from 0, but the structure has {found} modes: as many as coordinates with a mass"
    )))
}

/// One number for each point, NaN where there is no result.
fn column<'py, P>(py: Python<'py>, points: &[P], of: impl Fn(&P) -> Option<f64>) -> Bound<'py, PyArray1<f64>> {
    list(py, points.iter().map(|point| of(point).unwrap_or(f64::NAN)).collect())
}

/// Loops as arrays.
fn loops(all: &Bound<'_, PyDict>, points: &[BackbonePoint]) -> PyResult<()> {
    let py = all.py();
    let set = |name: &str, of: &dyn Fn(&cqsma::LoopResult) -> f64| {
        all.set_item(name, column(py, points, |point| point.result.as_ref().ok().map(of)))
    };
    all.set_item("modal_force", column(py, points, |point| Some(point.modal_force)))?;
    set("modal_amplitude", &|r| r.modal_amplitude)?;
    set("frequency_hz", &|r| r.omega / TAU)?;
    set("harmonic_frequency_hz", &|r| r.harmonic_omega / TAU)?;
    set("damping_ratio", &|r| r.zeta)?;
    set("damping_floor", &|r| r.zeta_floor)?;
    set("dissipation", &|r| r.loop_area)?;
    set("shape_deviation", &|r| r.shape_deviation)?;
    set("residual", &|r| r.residual)?;
    let status = |of: &dyn Fn(&cqsma::LoopResult) -> bool| -> Vec<bool> {
        points.iter().map(|point| point.result.as_ref().is_ok_and(of)).collect()
    };
    all.set_item("closed", PyArray1::from_vec(py, status(&|r| r.closed)))?;
    all.set_item(
        "resolved",
        PyArray1::from_vec(py, status(&cqsma::LoopResult::is_resolved)),
    )?;
    let count = |of: &dyn Fn(&cqsma::LoopResult) -> usize| -> Vec<i64> {
        points
            .iter()
            .map(|point| point.result.as_ref().map_or(0, |r| of(r) as i64))
            .collect()
    };
    all.set_item("cycles", PyArray1::from_vec(py, count(&|r| r.cycles)))?;
    all.set_item("n_slip", PyArray1::from_vec(py, count(&|r| r.counts.slip)))?;
    all.set_item("n_open", PyArray1::from_vec(py, count(&|r| r.counts.open)))?;
    let reason = |point: &BackbonePoint| point.result.as_ref().err().map(|failure| failure.reason.to_string());
    all.set_item("reason", points.iter().map(reason).collect::<Vec<_>>())?;
    let curves = points.iter().map(|point| {
        point.result.as_ref().map_or_else(
            |_| (list(py, Vec::new()), list(py, Vec::new())),
            |r| {
                (
                    list(py, r.hysteresis.amplitude.clone()),
                    list(py, r.hysteresis.force.clone()),
                )
            },
        )
    });
    all.set_item("loops", curves.collect::<Vec<_>>())
}

impl Structure {
    /// Periodic motions as arrays.
    fn motions(&self, all: &Bound<'_, PyDict>, points: &[Point]) -> PyResult<()> {
        let py = all.py();
        let set = |name: &str, of: &dyn Fn(&backbone::Motion) -> f64| {
            all.set_item(name, column(py, points, |point| point.result.as_ref().ok().map(of)))
        };
        all.set_item(
            "modal_amplitude",
            column(py, points, |point| Some(point.modal_amplitude)),
        )?;
        set("frequency_hz", &|m| m.omega / TAU)?;
        set("damping_ratio", &|m| m.zeta.unwrap_or(f64::NAN))?;
        set("dissipation", &|m| m.dissipation)?;
        set("energy_error", &|m| m.energy_error)?;
        set("residual", &|m| m.residual)?;
        set("drift", &|m| m.drift)?;
        let size = |of: &dyn Fn(&backbone::Motion) -> usize| -> Vec<i64> {
            points
                .iter()
                .map(|point| point.result.as_ref().map_or(0, |m| of(m) as i64))
                .collect()
        };
        all.set_item("harmonics", PyArray1::from_vec(py, size(&|m| m.sampling.harmonics)))?;
        all.set_item("samples", PyArray1::from_vec(py, size(&|m| m.sampling.samples)))?;
        let reason = |point: &Point| point.result.as_ref().err().map(|failure| failure.reason.to_string());
        all.set_item("reason", points.iter().map(reason).collect::<Vec<_>>())?;
        // Amplitudes have harmonics of their own where an accuracy was asked for.
        let most = points.iter().filter_map(|point| point.result.as_ref().ok());
        let most = most.map(|motion| motion.displacement.count()).max().unwrap_or(0);
        let columns = 2 * most + 1;
        let coefficients = |rows: usize, of: &dyn Fn(&Harmonics, usize) -> Vec<f64>| {
            let mut values = Vec::with_capacity(points.len() * rows * columns);
            for point in points {
                let motion = point
                    .result
                    .as_ref()
                    .ok()
                    .map(|motion| motion.displacement.with_count(most));
                for row in 0..rows {
                    match &motion {
                        None => values.resize(values.len() + columns, f64::NAN),
                        Some(motion) => values.extend(of(motion, row)),
                    }
                }
            }
            PyArray1::from_vec(py, values).reshape([points.len(), rows, columns])
        };
        let response: Vec<Vec<f64>> = (0..self.reduced.recovery.nrows())
            .filter_map(|row| self.row(row))
            .collect();
        all.set_item(
            "response",
            coefficients(response.len(), &|motion, row| motion.along(&response[row]))?,
        )?;
        let jump = coefficients(self.reduced.n_relative, &|motion, row| {
            (0..columns).map(|column| motion.column(column)[row]).collect()
        })?;
        all.set_item("jump", jump)
    }
}
