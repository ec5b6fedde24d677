//! The backbone as comma-separated values.

use joint_pipeline::analysis::ensemble::Ensemble;
use joint_pipeline::analysis::registration::Moved;
use joint_pipeline::results::summary::{BackboneSummary, Summary};

/// Name with unit, and value, of every column.
fn columns(number: usize, b: &BackboneSummary) -> Vec<(&'static str, String)> {
    // `{:?}` is the shortest text that reads back as the same number.
    let optional = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:?}"));
    vec![
        ("number", number.to_string()),
        ("converged", b.converged.to_string()),
        ("response_displacement [m]", optional(b.response_displacement)),
        ("response_acceleration [m/s^2]", optional(b.response_acceleration)),
        ("frequency [Hz]", optional(b.frequency_hz)),
        (
            "frequency_positive_half [Hz]",
            optional(b.half_frequencies_hz.map(|f| f[0])),
        ),
        (
            "frequency_negative_half [Hz]",
            optional(b.half_frequencies_hz.map(|f| f[1])),
        ),
        ("damping_ratio [-]", optional(b.damping_ratio)),
        ("friction_damping_ratio [-]", optional(b.friction_damping_ratio)),
        ("damping_floor [-]", optional(b.damping_floor)),
        ("modal_force [sqrt(kg) m/s^2]", format!("{:?}", b.modal_force)),
        ("modal_amplitude [sqrt(kg) m]", optional(b.modal_amplitude)),
        ("dissipation [J]", optional(b.dissipation)),
        ("loop_area [J]", optional(b.loop_area)),
        ("coarse_loop_area [J]", optional(b.coarse_loop_area)),
        ("slip_fraction [-]", optional(b.slip_fraction)),
        ("open_fraction [-]", optional(b.open_fraction)),
        ("shape_deviation [-]", optional(b.shape_deviation)),
        ("cycles", b.cycles.map_or_else(String::new, |n| n.to_string())),
        ("loop_closure [-]", optional(b.loop_closure)),
        ("residual [-]", optional(b.residual)),
        ("iterations", b.iterations.to_string()),
        (
            "failure",
            b.failure
                .as_deref()
                .map_or_else(String::new, |text| format!("\"{}\"", text.replace('"', "\"\""))),
        ),
    ]
}

/// Backbones with the bottom face moved, one row per amplitude; empty cells where damping is below its floor.
pub fn registration(study: &[Moved]) -> String {
    let mut out = String::from(
        "shift_x [m],shift_y [m],tilt_x [-],tilt_y [-],response_displacement [m],frequency [Hz],damping_ratio [-]\n",
    );
    for moved in study {
        let ([x, y], [tx, ty]) = (moved.registration.shift, moved.registration.tilt);
        for point in &moved.points {
            let (amplitude, frequency) = (point.response_displacement, point.frequency_hz);
            let damping = point.damping_ratio.map_or_else(String::new, |z| format!("{z:?}"));
            out += &format!("{x:?},{y:?},{tx:?},{ty:?},{amplitude:?},{frequency:?},{damping}\n");
        }
    }
    out
}

/// Percentiles over the realisations, one row per amplitude; empty cells where there is no value.
pub fn ensemble(ensemble: &Ensemble) -> String {
    let mut out = String::from(
        "response_displacement [m],realisations,frequency_5 [Hz],frequency_50 [Hz],frequency_95 [Hz],damping_ratio_5 [-],\
         damping_ratio_50 [-],damping_ratio_95 [-]\n",
    );
    for band in &ensemble.bands {
        let frequencies = band.frequency_hz.iter().map(|f| format!("{f:?}"));
        let dampings = band
            .damping_ratio
            .iter()
            .map(|z| z.map_or_else(String::new, |z| format!("{z:?}")));
        let cells = [
            format!("{:?}", band.response_displacement),
            band.realisations.to_string(),
        ];
        out += &(cells
            .into_iter()
            .chain(frequencies)
            .chain(dampings)
            .collect::<Vec<_>>()
            .join(",")
            + "\n");
    }
    out
}

/// One row per amplitude; empty cells where there is no value.
pub fn document(summary: &Summary) -> String {
    let mut out = String::new();
    for (index, point) in summary.backbone.iter().enumerate() {
        let (names, cells): (Vec<_>, Vec<_>) = columns(index + 1, point).into_iter().unzip();
        if index == 0 {
            out += &(names.join(",") + "\n");
        }
        out += &(cells.join(",") + "\n");
    }
    out
}
