//! The files of a run.

use crate::{Error, Output, csv, fields, page, plot, vtu};
use joint_pipeline::Run;
use joint_pipeline::summary::{BackboneSummary, Status, Summary};

/// Name of the machine-readable account of a run.
pub const SUMMARY: &str = "summary.json";

/// Name of the table of an ensemble.
pub const ENSEMBLE: &str = "ensemble.csv";

/// Name of the interface file of an amplitude, counted from 1.
pub fn amplitude_file(number: usize) -> String {
    format!("interface-amplitude-{number:02}.vtu")
}

/// All files of a run; the summary comes last, so that a new one never stands beside old files.
///
/// # Errors
/// [`Error::Picture`], [`Error::Summary`].
pub fn outputs(run: &Run, summary: &Summary) -> Result<Vec<Output>, Error> {
    let field_file =
        |name: String, fields| Output::new(name, vtu::document(&run.mesh, &fields::cell_fields(run, fields)));
    let picture = plot::backbone(summary, &title(run))?;
    let mut outputs = vec![field_file("interface-prestress.vtu".into(), &run.prestress.fields)];
    for (index, amplitude) in run.amplitudes.iter().enumerate() {
        if let Some(fields) = amplitude.fields.as_ref().and_then(|f| f.fields.as_ref()) {
            outputs.push(field_file(amplitude_file(index + 1), fields));
        }
    }
    outputs.push(Output::new("backbone.csv", csv::document(summary)));
    if let Some(ensemble) = &summary.ensemble {
        outputs.push(Output::new(ENSEMBLE, csv::ensemble(ensemble)));
    }
    outputs.push(Output::new("report.html", page::document(run, summary, &picture)?));
    outputs.push(Output::new("backbone.svg", picture));
    let json = serde_json::to_string_pretty(summary).map_err(Error::Summary)?;
    outputs.push(Output::new(SUMMARY, json + "\n"));
    Ok(outputs)
}

fn title(run: &Run) -> String {
    let scene = &run.scene;
    format!(
        "{}: mode {}, mu = {}, bolts {:.3} kN each",
        scene.name,
        scene.cqsma.mode,
        scene.mu,
        scene.bolts.load / 1e3
    )
}

/// Total damping ratio as text, or the floor that it lies below.
pub fn damping(b: &BackboneSummary) -> String {
    match (b.status, b.damping_ratio, b.damping_floor) {
        (Status::BelowFloor, _, Some(floor)) => format!("< {floor:.1e}"),
        (_, Some(zeta), _) => format!("{zeta:.4e}"),
        _ => "-".into(),
    }
}
