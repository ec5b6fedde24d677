//! Motion in time.

use super::backbones::{Modes, check_mode, check_most, check_tolerance, flow, to_python};
use super::structure::{Begin, Structure, of_solver};
use crate::arrays::list;
use crate::error::{Exception, input};
use crate::work::{pool, supervise};
use cqsma_solver::NewtonSettings;
use cqsma_solver::transient::{self, MOST_STEPS, Sample, Start, Transient};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The motion after a release (a modal amplitude) or a pulse (impulse and duration), along the first row that is recovered; a
/// pulse acts along the last one.
#[pyfunction]
pub(crate) fn run_transient<'py>(
    py: Python<'py>,
    structure: &Structure,
    release: Option<f64>,
    pulse: Option<(f64, f64)>,
    mode: usize,
    n_linear_modes: usize,
    closure: Option<f64>,
    steps_per_period: usize,
    periods: usize,
    spectral_radius: f64,
    background_damping: f64,
    other_damping: f64,
    tolerance: f64,
    max_iterations: usize,
    static_tolerance: f64,
    threads: Option<i64>,
) -> PyResult<Bound<'py, PyDict>> {
    let rows = structure.reduced.recovery.nrows();
    let (Some(row), Some(point)) = (structure.row(0), structure.row(rows.saturating_sub(1))) else {
        return Err(input("response is not given; it says which displacement is recorded").into());
    };
    check_tolerance("tolerance", tolerance)?;
    check_tolerance("static_tolerance", static_tolerance)?;
    check_most("steps_per_period", steps_per_period, MOST_STEPS)?;
    check_most("periods", periods, MOST_STEPS / steps_per_period.max(1))?;
    let default = transient::Settings::default();
    let settings = transient::Settings {
        mode,
        steps_per_period,
        periods,
        spectral_radius,
        background_damping,
        other_damping,
        newton: NewtonSettings {
            tolerance,
            max_iterations,
            ..default.newton
        },
        ..default
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
        let start = match (release, pulse) {
            (Some(amplitude), None) => Start::Release {
                modal_force: line.eigenvalues[mode] * amplitude,
            },
            (None, Some((impulse, duration))) => Start::Pulse {
                impulse,
                duration,
                point: point.clone(),
            },
            _ => return Err(input("release and pulse: give one of them")),
        };
        let motion = transient::run(&line, &structure.force(), &row, &start, &settings, &mut |_| {
            flow(monitor)
        })
        .map_err(of_solver)?;
        let modes = Modes {
            frequencies: line.frequencies(),
            shapes: line.shapes.clone(),
        };
        drop(line);
        Ok::<_, Exception>(Ok((rest, modes, motion)))
    })??;
    to_python(py, structure, found, motion)
}

/// A motion as arrays.
fn motion(all: &Bound<'_, PyDict>, motion: Transient) -> PyResult<()> {
    let py = all.py();
    let set =
        |name: &str, of: fn(&Sample) -> f64| all.set_item(name, list(py, motion.samples.iter().map(of).collect()));
    set("time", |s| s.time)?;
    set("displacement", |s| s.displacement)?;
    set("velocity", |s| s.velocity)?;
    set("acceleration", |s| s.acceleration)?;
    set("kinetic_energy", |s| s.energy.kinetic)?;
    set("elastic_energy", |s| s.energy.elastic)?;
    set("contact_work", |s| s.energy.contact)?;
    set("viscous_work", |s| s.energy.viscous)?;
    set("external_work", |s| s.energy.external)?;
    all.set_item("step", motion.step)?;
    all.set_item(
        "reason",
        motion.failure.as_ref().map(|failure| failure.reason.to_string()),
    )?;
    all.set_item("residual", motion.residual)?;
    all.set_item("energy_error", motion.energy_error())?;
    all.set_item("share_elsewhere", motion.share_elsewhere())?;
    all.set_item("algorithmic_frequency_ratio", motion.algorithmic.frequency_ratio)?;
    all.set_item("algorithmic_damping_ratio", motion.algorithmic.damping_ratio)
}
