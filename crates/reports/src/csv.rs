//! Tables as comma-separated values.

use crate::Error;
use analyses::ensemble::{Ensemble, MemberPoint};
use analyses::epmc::PointLoop;
use analyses::forced::ForcedSummary;
use analyses::registration::Moved;
use analyses::results::summary::{BackboneSummary, MethodSummary, Summary};
use analyses::{Run, element_centres};

/// A number as the shortest text that reads back as the same.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

/// The same, or an empty cell.
pub fn optional(value: Option<f64>) -> String {
    value.map(number).unwrap_or_default()
}

/// A table with a line of headings; cells are quoted where they must be.
///
/// # Errors
/// [`Error::Table`] if a row has another number of cells than there are headings.
pub fn table<H, R, C>(headings: H, rows: R) -> Result<String, Error>
where
    H: IntoIterator<Item: AsRef<[u8]>>,
    R: IntoIterator<Item = C>,
    C: IntoIterator<Item: AsRef<[u8]>>,
{
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(headings).map_err(Error::Table)?;
    for row in rows {
        writer.write_record(row).map_err(Error::Table)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| Error::Table(error.into_error().into()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Heading with unit, and cell, of a column.
type Column<T> = (&'static str, fn(&T) -> String);

/// Every column of a backbone beside the number.
const COLUMNS: [Column<BackboneSummary>; 28] = [
    ("converged", |b| b.converged.to_string()),
    ("response_displacement [m]", |b| optional(b.response_displacement)),
    ("response_acceleration [m/s^2]", |b| optional(b.response_acceleration)),
    ("response_motion [m]", |b| optional(b.response_motion)),
    ("frequency [Hz]", |b| optional(b.frequency_hz)),
    ("frequency_first_harmonic [Hz]", |b| {
        optional(b.frequency_first_harmonic_hz)
    }),
    ("frequency_positive_half [Hz]", |b| {
        optional(b.half_frequencies_hz.map(|f| f[0]))
    }),
    ("frequency_negative_half [Hz]", |b| {
        optional(b.half_frequencies_hz.map(|f| f[1]))
    }),
    ("damping_ratio [-]", |b| optional(b.damping_ratio)),
    ("friction_damping_ratio [-]", |b| optional(b.friction_damping_ratio)),
    ("damping_ratio_first_harmonic [-]", |b| {
        optional(b.damping_ratio_first_harmonic)
    }),
    ("damping_floor [-]", |b| optional(b.damping_floor)),
    ("modal_force [sqrt(kg) m/s^2]", |b| number(b.modal_force)),
    ("modal_amplitude [sqrt(kg) m]", |b| optional(b.modal_amplitude)),
    ("dissipation [J]", |b| optional(b.dissipation)),
    ("loop_area [J]", |b| optional(b.loop_area)),
    ("coarse_loop_area [J]", |b| optional(b.coarse_loop_area)),
    ("slip_fraction [-]", |b| optional(b.slip_fraction)),
    ("open_fraction [-]", |b| optional(b.open_fraction)),
    ("shape_deviation [-]", |b| optional(b.shape_deviation)),
    ("cycles", |b| b.cycles.map_or_else(String::new, |n| n.to_string())),
    ("vertices_per_quarter", |b| {
        b.vertices_per_quarter.map_or_else(String::new, |n| n.to_string())
    }),
    ("loop_closure [-]", |b| optional(b.loop_closure)),
    ("residual [-]", |b| optional(b.residual)),
    ("error_frequency [-]", |b| {
        optional(b.error.as_ref().and_then(|error| error.frequency_relative))
    }),
    ("error_ln_damping [-]", |b| {
        optional(b.error.as_ref().and_then(|error| error.damping_ln))
    }),
    ("iterations", |b| b.iterations.to_string()),
    ("failure", |b| b.failure.clone().unwrap_or_default()),
];

/// Backbones with the bottom face moved, one row per amplitude; empty cells where damping is below its floor.
///
/// # Errors
/// [`Error::Table`].
pub fn registration(study: &[Moved]) -> Result<String, Error> {
    let headings = [
        "shift_x [m]",
        "shift_y [m]",
        "tilt_x [-]",
        "tilt_y [-]",
        "response_displacement [m]",
        "frequency [Hz]",
        "damping_ratio [-]",
    ];
    let rows = study.iter().flat_map(|moved| {
        let ([x, y], [tx, ty]) = (moved.registration.shift, moved.registration.tilt);
        let row = move |point: &MemberPoint| {
            let [a, f] = [point.response_displacement, point.frequency_hz].map(number);
            let [x, y, tx, ty] = [x.si(), y.si(), tx, ty].map(number);
            [x, y, tx, ty, a, f, optional(point.damping_ratio)]
        };
        moved.points.iter().map(row)
    });
    table(headings, rows)
}

/// Percentiles over the realisations, one row per amplitude; empty cells where there is no value.
///
/// # Errors
/// [`Error::Table`].
pub fn ensemble(ensemble: &Ensemble) -> Result<String, Error> {
    let headings = [
        "response_displacement [m]",
        "realisations",
        "frequency_5 [Hz]",
        "frequency_50 [Hz]",
        "frequency_95 [Hz]",
        "damping_ratio_5 [-]",
        "damping_ratio_50 [-]",
        "damping_ratio_95 [-]",
    ];
    let rows = ensemble.bands.iter().map(|band| {
        let cells = [number(band.response_displacement), band.realisations.to_string()];
        let (frequencies, dampings) = (band.frequency_hz.map(number), band.damping_ratio.map(optional));
        cells.into_iter().chain(frequencies).chain(dampings)
    });
    table(headings, rows)
}

/// One row per amplitude; empty cells where there is no value.
///
/// # Errors
/// [`Error::Table`].
pub fn backbone(summary: &Summary) -> Result<String, Error> {
    let headings = ["number"].into_iter().chain(COLUMNS.map(|(heading, _)| heading));
    let rows = summary.backbone.iter().enumerate().map(|(index, point)| {
        let cells = COLUMNS.map(|(_, cell)| cell(point));
        [(index + 1).to_string()].into_iter().chain(cells)
    });
    table(headings, rows)
}

/// Every column of EPMC beside mode, number and harmonics.
const EPMC_COLUMNS: [Column<MethodSummary>; 21] = [
    ("converged", |p| p.converged.to_string()),
    ("modal_amplitude [sqrt(kg) m]", |p| optional(p.modal_amplitude)),
    ("response_displacement [m]", |p| optional(p.response_displacement)),
    ("frequency_first_harmonic [Hz]", |p| {
        optional(p.frequency_first_harmonic_hz)
    }),
    ("damping_ratio [-]", |p| optional(p.damping_ratio)),
    ("damping_floor [-]", |p| optional(p.damping_floor)),
    ("modal_force [sqrt(kg) m/s^2]", |p| optional(p.modal_force)),
    ("dissipation [J]", |p| optional(p.dissipation)),
    ("energy_error [-]", |p| optional(p.energy_error)),
    ("residual [-]", |p| optional(p.residual)),
    ("drift [-]", |p| optional(p.drift)),
    ("harmonics", |p| count(p.harmonics)),
    ("samples", |p| count(p.samples)),
    ("periods", |p| count(p.periods)),
    ("frequency_error_harmonics [-]", |p| {
        optional(p.frequency_errors.map(|e| e[0]))
    }),
    ("frequency_error_samples [-]", |p| {
        optional(p.frequency_errors.map(|e| e[1]))
    }),
    ("damping_error_harmonics [-]", |p| {
        optional(p.damping_errors.map(|e| e[0]))
    }),
    ("damping_error_samples [-]", |p| {
        optional(p.damping_errors.map(|e| e[1]))
    }),
    ("iterations", |p| count(p.iterations)),
    ("evaluations", |p| count(p.evaluations)),
    ("krylov_steps", |p| count(p.krylov_steps)),
];

fn count(value: Option<usize>) -> String {
    value.map_or_else(String::new, |n| n.to_string())
}

/// Cells of the harmonics above the first, empty beyond the last of `values`.
fn above_the_first(values: &[f64], highest: usize) -> impl Iterator<Item = String> + '_ {
    (2..=highest).map(|h| optional(values.get(h - 1).copied()))
}

/// Free periodic motions by EPMC, one row per mode and amplitude; empty cells where there is no value.
///
/// # Errors
/// [`Error::Table`].
pub fn epmc(modes: &[(usize, &[MethodSummary])]) -> Result<String, Error> {
    let shares = |p: &MethodSummary| p.share_of_harmonics.as_ref().map_or(0, Vec::len);
    let highest = modes.iter().flat_map(|(_, points)| points.iter().map(shares)).max();
    let highest = highest.unwrap_or(0);
    let headings = ["mode", "number"]
        .into_iter()
        .chain(EPMC_COLUMNS.map(|(heading, _)| heading));
    let headings = headings.map(str::to_owned);
    let headings = headings.chain((2..=highest).map(|h| format!("share_of_harmonic_{h} [-]")));
    let rows = modes.iter().flat_map(|&(mode, points)| {
        points.iter().enumerate().map(move |(index, point)| {
            let cells = EPMC_COLUMNS.map(|(_, cell)| cell(point));
            let shares = point.share_of_harmonics.as_deref().unwrap_or_default();
            let before = [mode.to_string(), (index + 1).to_string()];
            let row = before.into_iter().chain(cells).chain(above_the_first(shares, highest));
            row.chain([point.failure.clone().unwrap_or_default()])
                .collect::<Vec<_>>()
        })
    });
    table(headings.chain(["failure".to_owned()]), rows)
}

/// Hysteresis loops of single points along periodic motions, one row per sample; each loop is closed by its first sample.
/// `positions` are those of all points (m), where they are known.
///
/// # Errors
/// [`Error::Table`].
pub fn loops(modes: &[(usize, &[PointLoop])], positions: Option<&[[f64; 3]]>) -> Result<String, Error> {
    let headings = [
        "mode",
        "modal_amplitude [sqrt(kg) m]",
        "point",
        "sample",
        "jump_x [m]",
        "jump_y [m]",
        "interference [m]",
        "traction_x [Pa]",
        "traction_y [Pa]",
        "pressure [Pa]",
        "x [m]",
        "y [m]",
        "z [m]",
    ];
    let rows = modes.iter().flat_map(|&(mode, loops)| {
        loops.iter().flat_map(move |found| {
            let history = &found.history;
            let at = positions.and_then(|of| of.get(history.point));
            let at = (0..3).map(|c| optional(at.map(|x| x[c]))).collect::<Vec<_>>();
            (0..history.jump[0].len()).map(move |sample| {
                let place = [
                    mode.to_string(),
                    number(found.modal_amplitude),
                    (history.point + 1).to_string(),
                    (sample + 1).to_string(),
                ];
                let values = history
                    .jump
                    .iter()
                    .chain(&history.traction)
                    .map(|values| number(values[sample]));
                place.into_iter().chain(values).chain(at.clone()).collect::<Vec<_>>()
            })
        })
    });
    table(headings, rows)
}

/// Hysteresis loops of the interface elements at the places of `analyses.backbone.loops_at`, one row per vertex, for the amplitudes whose fields are
/// stored. Values are means over the element; the first and the last vertex of a loop are at the positive peak. Positions are those of
/// the centres of the elements; where their place in the model is not known, they lie in the plane of the interface and `z` is empty.
///
/// # Errors
/// [`Error::Table`].
pub fn element_loops(run: &Run) -> Result<String, Error> {
    let headings = [
        "mode",
        "number",
        "modal_amplitude [sqrt(kg) m]",
        "element",
        "x [m]",
        "y [m]",
        "z [m]",
        "vertex",
        "modal_force [sqrt(kg) m/s^2]",
        "jump_x [m]",
        "jump_y [m]",
        "interference [m]",
        "traction_x [Pa]",
        "traction_y [Pa]",
        "pressure [Pa]",
    ];
    let centres = element_centres(&run.joint.mesh, run.joint.positions.as_deref());
    let centres = &centres;
    let rows = run.backbones.iter().flat_map(|backbone| {
        let numbered = (1_usize..).zip(&backbone.amplitudes);
        let stored = numbered.filter_map(|(index, amplitude)| {
            let loops = amplitude.fields.as_ref()?.loops.as_ref()?;
            let result = amplitude.point.result.as_ref().ok()?;
            Some((index, result.modal_amplitude, loops))
        });
        stored.flat_map(move |(index, modal_amplitude, loops)| {
            run.loop_elements.iter().flat_map(move |&element| {
                let [x, y, z] = centres[element];
                let z = run.joint.positions.is_some().then_some(z);
                let vertices = loops.of_element(element).into_iter().flatten();
                let vertices = (1_usize..).zip(&loops.modal_force).zip(vertices);
                vertices.map(move |((vertex, force), (jump, traction))| {
                    let amplitude = [backbone.mode.to_string(), index.to_string(), number(modal_amplitude)];
                    let place = [(element + 1).to_string(), number(x), number(y), optional(z)];
                    let of_vertex = [vertex.to_string(), number(*force)];
                    let row = amplitude.into_iter().chain(place).chain(of_vertex);
                    row.chain(jump.map(number))
                        .chain(traction.map(number))
                        .collect::<Vec<_>>()
                })
            })
        })
    });
    table(headings, rows)
}

/// Forced responses, one row per point along the curve of each level. The amplitude is that of the first harmonic.
///
/// # Errors
/// [`Error::Table`].
pub fn forced(levels: &[ForcedSummary]) -> Result<String, Error> {
    let highest = levels
        .iter()
        .flat_map(|level| level.harmonics.iter().map(Vec::len))
        .max();
    let highest = highest.unwrap_or(0);
    let level = format!(
        "level [{}]",
        levels.first().map_or("N", |level| level.level_unit.as_str())
    );
    let held = levels.iter().any(ForcedSummary::holds_response);
    let moves = levels.iter().any(|level| level.base.is_some());
    let is_judged = levels.iter().any(|level| level.floquet.is_some());
    let first = [
        level.as_str(),
        "number",
        "frequency [Hz]",
        "amplitude [m]",
        "phase_lag [deg]",
    ];
    let headings = first.map(str::to_owned).into_iter();
    let headings = headings.chain((2..=highest).map(|h| format!("amplitude_of_harmonic_{h} [m]")));
    let rows = levels.iter().flat_map(|level| {
        level.harmonics.iter().enumerate().map(move |(i, harmonics)| {
            let of = |values: &[f64]| optional(values.get(i).copied());
            let [frequency, amplitude, phase, residual] =
                [&level.frequency, &level.amplitude, &level.phase, &level.residual].map(|values| of(values));
            let before = [number(level.level), (i + 1).to_string(), frequency, amplitude, phase];
            let turns = level.turning_points.contains(&i).to_string();
            let row = before.into_iter().chain(above_the_first(harmonics, highest));
            let row = row.chain([residual, turns]);
            let base = level.base.as_ref().map(|base| {
                let [amplitude, transmissibility, phase] =
                    [&base.amplitude, &base.transmissibility, &base.phase].map(|values| of(values));
                let force = optional(base.support_force.get(i).copied().flatten());
                [amplitude, transmissibility, phase, force]
            });
            let empty = (moves && base.is_none()).then(Default::default);
            let force = held.then(|| of(&level.force));
            let floquet = level.floquet.as_ref();
            let stability = is_judged.then(|| {
                let stable = floquet.and_then(|found| *found.stable.get(i)?);
                let multipliers = floquet.and_then(|found| found.multipliers.get(i));
                let sizes = multipliers.into_iter().flatten().map(|[re, im]| re.hypot(*im));
                let stable = stable.map_or_else(String::new, |stable| stable.to_string());
                [optional(sizes.max_by(f64::total_cmp)), stable]
            });
            row.chain(base.or(empty).into_iter().flatten())
                .chain(force)
                .chain(stability.into_iter().flatten())
                .collect::<Vec<_>>()
        })
    });
    let last = ["residual [-]", "turns"].into_iter();
    let of_base = [
        "amplitude_from_outside [m]",
        "transmissibility [-]",
        "phase_lag_from_outside [deg]",
        "support_force [N]",
    ];
    let last = last
        .chain(of_base.into_iter().filter(|_| moves))
        .chain(held.then_some("force [N]"))
        .chain(["largest_multiplier [-]", "stable"].into_iter().filter(|_| is_judged));
    table(headings.chain(last.map(str::to_owned)), rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_and_texts_are_quoted_where_they_must() {
        let found = table(
            ["a", "b [1, 2]"],
            [[number(0.1 + 0.2), "x".into()], ["1e-7".into(), "say \"x\"".into()]],
        );
        assert_eq!(
            found.expect("two columns"),
            "a,\"b [1, 2]\"\n0.30000000000000004,x\n1e-7,\"say \"\"x\"\"\"\n"
        );
        assert!(table(["a", "b"], [["alone"]]).is_err());
        assert_eq!(optional(None), "");
    }
}
