//! Stationary random vibration: tables, densities and lines.

use crate::analysis::{Analysis, Document, Section};
use crate::csv::{number, table};
use crate::fields::{CellField, Placed, vtu};
use crate::html::{MISSING, Picture, Table};
use crate::motions::{shade, short};
use crate::plot::{Curve, Marks, Panel, amplitude_label, power, stack};
use crate::{Error, Output, map};
use analyses::Run;
use analyses::random::{RandomModeSummary, RandomSummary, RandomVibration};
use analyses::results::summary::Summary;
use plotters::chart::SeriesLabelPosition;
use std::fmt::Write;

/// Name of the table of levels and modes.
pub const RANDOM: &str = "random.csv";

/// Name of the table of densities.
pub const DENSITIES: &str = "random-psd.csv";

/// Name of the picture of the densities.
pub const RANDOM_PICTURE: &str = "random.svg";

/// Name of the interface file of a level, counted from 1.
fn level_file(number: usize) -> String {
    format!("interface-random-{number:02}.vtu")
}

/// Densities below this share of the largest are not drawn.
const LEAST: f64 = 1e-8;

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| {
        let is_level = name.starts_with("interface-random-") && name.ends_with(".vtu");
        is_level || [RANDOM, DENSITIES, RANDOM_PICTURE].contains(&name)
    },
    document: |run, summary| {
        if summary.random.is_empty() && summary.random_failure.is_none() {
            return Ok(None);
        }
        let levels = summary.random.as_slice();
        let mut outputs = Vec::new();
        let mut drawn = None;
        if !levels.is_empty() {
            outputs.extend([
                Output::new(RANDOM, csv(levels)?),
                Output::new(DENSITIES, densities(levels)?),
            ]);
        }
        if levels.iter().any(|level| level.rms_response > 0.0) {
            let svg = picture(levels)?;
            outputs.push(Output::new(RANDOM_PICTURE, svg.clone()));
            drawn = Some(svg);
        }
        for (number, level) in found(run).iter().enumerate() {
            let elements = &level.elements;
            let cells = vec![
                CellField::scalar("friction_power [W/m^2]", elements.power.clone()),
                CellField::scalar("rms_tangential_motion [m]", elements.sliding.clone()),
                CellField::scalar("rms_tangential_traction_change [Pa]", elements.traction.clone()),
            ];
            outputs.push(Output::new(level_file(number + 1), vtu(run.into(), cells)?));
        }
        let section = Some(section(run, summary, drawn));
        Ok(Some(Document { outputs, section }))
    },
    lines: |summary| {
        let failure = summary.random_failure.iter();
        let failure = failure.map(|reason| format!("\nNO RANDOM VIBRATION: {reason}\n"));
        failure.chain(summary.random.iter().map(line)).collect()
    },
    is_complete: |summary| {
        summary.random_failure.is_none() && summary.random.iter().all(|level| level.in_time_failure.is_none())
    },
};

/// The levels of a run.
fn found(run: &Run) -> &[RandomVibration] {
    match &run.vibration.random {
        Some(Ok(levels)) => levels,
        _ => &[],
    }
}

/// A row per level and mode.
fn csv(levels: &[RandomSummary]) -> Result<String, Error> {
    let unit = levels.first().map_or("N", |level| level.load_unit.as_str());
    let rms_load = format!("rms_load [{unit}]");
    let headings = [
        "level [-]",
        &rms_load,
        "rms_response [m]",
        "rms_velocity [m/s]",
        "rms_acceleration [m/s^2]",
        "dissipated_power [W]",
        "rms_sliding [m]",
        "assumptions_hold",
        "mode",
        "follows_backbone",
        "frequency [Hz]",
        "damping_ratio [-]",
        "rms_of_mode [m]",
        "modal_rms [sqrt(kg) m]",
        "power_of_mode [W]",
    ];
    let rows = levels.iter().flat_map(|level| {
        let row = move |mode: &RandomModeSummary| {
            let of_level = [
                level.level,
                level.rms_load,
                level.rms_response,
                level.rms_velocity,
                level.rms_acceleration,
                level.dissipated_power,
                level.rms_sliding,
            ];
            let of_mode = [
                mode.frequency_hz,
                mode.damping_ratio,
                mode.rms,
                mode.modal_rms,
                mode.power,
            ];
            let words = [
                level.validity.holds.to_string(),
                mode.mode.to_string(),
                mode.follows_backbone.to_string(),
            ];
            let numbers = |values: &[f64]| values.iter().map(|value| number(*value)).collect::<Vec<_>>();
            [numbers(&of_level), words.to_vec(), numbers(&of_mode)].concat()
        };
        level.modes.iter().map(row)
    });
    table(headings, rows)
}

/// A row per level and frequency.
fn densities(levels: &[RandomSummary]) -> Result<String, Error> {
    let headings = [
        "level [-]",
        "frequency [Hz]",
        "displacement [m^2/Hz]",
        "acceleration [(m/s^2)^2/Hz]",
    ];
    let rows = levels.iter().flat_map(|level| {
        let psd = &level.psd;
        let values = psd.frequency_hz.iter().zip(&psd.displacement).zip(&psd.acceleration);
        values.map(|((f, x), a)| [level.level, *f, *x, *a].map(number))
    });
    table(headings, rows)
}

/// Densities of displacement and acceleration, a curve for each level.
fn picture(levels: &[RandomSummary]) -> Result<String, Error> {
    let panel = |y_label, values: fn(&RandomSummary) -> &[f64]| {
        let all = levels.iter().flat_map(|level| values(level).iter().copied());
        let least = LEAST * all.fold(0.0, f64::max);
        let curve = |(index, level): (usize, &RandomSummary)| {
            let points = level.psd.frequency_hz.iter().zip(values(level)).enumerate();
            Curve {
                name: format!("level {}", short(level.level)),
                colour: shade(index, levels.len()),
                dashes: None,
                marks: Marks::None,
                points: points
                    .filter(|(_, (_, y))| **y > least)
                    .map(|(i, (f, y))| (i, *f, *y))
                    .collect(),
            }
        };
        let drawn = levels.iter().enumerate().filter(|(_, level)| level.rms_response > 0.0);
        Panel {
            y_label,
            log: Some(power),
            legend: SeriesLabelPosition::UpperRight,
            curves: drawn.map(curve).collect(),
        }
    };
    let panels = vec![
        panel("displacement [m^2/Hz]", |level| &level.psd.displacement),
        panel("acceleration [(m/s^2)^2/Hz]", |level| &level.psd.acceleration),
    ];
    stack("frequency [Hz]", true, panels)
}

/// Where friction takes power at the highest level; nothing to draw of points of contact.
fn power_map(run: &Run) -> Option<Picture<'static>> {
    let highest = found(run).iter().max_by(|a, b| a.level.total_cmp(&b.level));
    let highest = highest.filter(|level| level.level > 0.0 && !run.joint.mesh.is_of_points())?;
    Some(Picture {
        svg: map::svg(
            run.into(),
            &highest.elements.power,
            "mean power of friction per area",
            "W/m²",
        )
        .into(),
        caption: format!(
            "Mean power that friction takes at level {}, means over the elements; {}.",
            short(highest.level),
            Placed::from(run).view()
        ),
    })
}

/// What the page says.
fn section(run: &Run, summary: &Summary, picture: Option<String>) -> Section {
    let levels = summary.random.as_slice();
    let failure = summary.random_failure.iter();
    let failure = failure.map(|reason| format!("There is no stationary random vibration: {reason}."));
    let doubts = levels.iter().flat_map(|level| {
        let reasons = level.validity.reasons.iter().chain(&level.in_time_failure);
        reasons.map(|reason| format!("Random vibration at level {}: {reason}.", short(level.level)))
    });
    let headings = [
        "level",
        "load, rms",
        "response, rms [m]",
        "acceleration, rms [m/s²]",
        "frequency [Hz]",
        "damping ratio",
        "power by friction [W]",
        "response in time, rms [m]",
        "assumptions",
    ];
    let row = |level: &RandomSummary| {
        let first = level.modes.first();
        let cell = |value: Option<String>| value.unwrap_or_else(|| MISSING.into());
        vec![
            short(level.level),
            format!("{} {}", short(level.rms_load), level.load_unit),
            format!("{:.4e}", level.rms_response),
            format!("{:.4e}", level.rms_acceleration),
            cell(first.map(|mode| format!("{:.3}", mode.frequency_hz))),
            cell(first.map(|mode| format!("{:.3e}", mode.damping_ratio))),
            format!("{:.3e}", level.dissipated_power),
            cell(level.in_time.as_ref().map(|found| {
                let [low, high] = found.rms_response_interval;
                format!("{:.3e} ({low:.3e} to {high:.3e})", found.rms_response)
            })),
            if level.validity.holds { "hold" } else { "do not hold" }.into(),
        ]
    };
    Section {
        heading: "Stationary random vibration",
        warnings: failure.chain(doubts).collect(),
        pictures: picture
            .into_iter()
            .map(|svg| Picture {
                svg: svg.into(),
                caption: format!(
                    "One-sided power spectral densities of the response: {}.",
                    amplitude_label(&summary.response)
                ),
            })
            .chain(power_map(run))
            .collect(),
        tables: match levels {
            [] => Vec::new(),
            _ => {
                let all = Table {
                    headings: headings.map(Into::into).into(),
                    rows: levels.iter().map(row).collect(),
                };
                let connections = connections(levels);
                let has_connections = !connections.rows.is_empty();
                let named = has_connections.then(|| ("Connections, root mean squares".into(), connections));
                std::iter::once((String::new(), all)).chain(named).collect()
            }
        },
        remarks: vec!["Frequency and damping ratio are those of the linear mode that stands for the first mode followed at this level.".into()],
        ..Section::default()
    }
}

/// What the connections do at the highest level.
fn connections(levels: &[RandomSummary]) -> Table {
    let highest = levels.iter().max_by(|a, b| a.level.total_cmp(&b.level));
    let rows = highest.into_iter().flat_map(|level| {
        level.connections.iter().map(|of| {
            vec![
                of.name.clone(),
                format!("{:.3e}", of.rms_displacement),
                format!("{:.3e}", of.rms_force),
                format!("{:.3e}", of.rms_traction),
                format!("{:.3e}", of.dissipated_power),
            ]
        })
    });
    let headings = [
        "connection, at the highest level",
        "motion [m]",
        "force [N]",
        "traction [Pa]",
        "dissipated power [W]",
    ];
    Table {
        headings: headings.map(Into::into).into(),
        rows: rows.collect(),
    }
}

/// One level, for the end of a run.
fn line(level: &RandomSummary) -> String {
    let mut out = format!(
        "random, {} {} rms: response {:.4e} m, {:.4e} m/s^2 rms",
        short(level.rms_load),
        level.load_unit,
        level.rms_response,
        level.rms_acceleration
    );
    // Writing to a string cannot fail.
    for mode in level.modes.iter().filter(|mode| mode.follows_backbone) {
        let _ = write!(
            out,
            "; mode {} at {:.4} Hz, damping ratio {:.3e}",
            mode.mode, mode.frequency_hz, mode.damping_ratio
        );
    }
    out.push('\n');
    if let Some(found) = &level.in_time {
        let [low, high] = found.rms_response_interval;
        let _ = writeln!(
            out,
            "  in time, {:.3} s: response {:.4e} m rms (90 %: {low:.3e} to {high:.3e}), {:.4e} m/s^2 rms",
            found.averaged_s, found.rms_response, found.rms_acceleration
        );
    }
    for reason in level.validity.reasons.iter().chain(&level.in_time_failure) {
        let _ = writeln!(out, "warning: {reason}");
    }
    out
}
