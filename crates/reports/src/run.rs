//! The files of a run.

use crate::names::{
    BODIES_PRESTRESS, ELEMENT_LOOPS, PRESTRESS, SUMMARY, amplitude_file, bodies_file, picture_file, series_file,
    table_file,
};
use crate::phrases::tensions;
use crate::registry::ANALYSES;
use crate::{Error, Output, bodies, csv, fields, page, plot};
use analyses::results::summary::Summary;
use analyses::{Deformed, Fields, Run};
use finite_elements::mesh::Face;

/// All files of a run; the summary comes last, so that a new one never stands beside old files.
///
/// # Errors
/// [`Error::Picture`], [`Error::Summary`].
pub fn outputs(run: &Run, summary: &Summary) -> Result<Vec<Output>, Error> {
    let field_file = |name: String, of: &Fields| {
        let document = fields::vtu(run.into(), fields::cell_fields(run, of))?;
        Ok::<_, Error>(Output::new(name, document))
    };
    let mut outputs = vec![field_file(PRESTRESS.into(), &run.prestress.fields)?];
    let bodies = Bodies::of(run);
    if let Some(bodies) = &bodies {
        let shares = run.estimated_error.as_ref().map_or(&[][..], |bar| &bar.shares);
        outputs.push(bodies.file(BODIES_PRESTRESS.into(), &bodies.of.prestress, shares)?);
    }
    let mut pictures = Vec::with_capacity(run.backbones.len());
    for (place, (backbone, (mode, of_mode))) in run.backbones.iter().zip(summary.by_mode()).enumerate() {
        let mut series = vec![(0.0, PRESTRESS.to_owned())];
        series.extend(bodies.as_ref().map(|_| (0.0, BODIES_PRESTRESS.to_owned())));
        for (index, amplitude) in backbone.amplitudes.iter().enumerate() {
            if let Some(fields) = amplitude.fields.as_ref().and_then(|f| f.fields.as_ref()) {
                let name = amplitude_file(mode, index + 1);
                series.extend(amplitude.response_displacement.map(|x| (x, name.clone())));
                outputs.push(field_file(name, fields)?);
                if let Some((bodies, peak)) = bodies.as_ref().and_then(|b| Some((b, b.peak(place, index)?))) {
                    let name = bodies_file(mode, index + 1);
                    series.extend(amplitude.response_displacement.map(|x| (x, name.clone())));
                    outputs.push(bodies.file(name, peak, &[])?);
                }
            }
        }
        outputs.push(Output::new(series_file(mode), fields::collection(&series)));
        outputs.push(Output::new(table_file(mode), csv::backbone(&of_mode)?));
        let picture = plot::backbone(&of_mode, &title(run, backbone.mode))?;
        outputs.push(Output::new(picture_file(mode), picture.clone()));
        pictures.push(picture);
    }
    let is_followed = run.backbones.iter().any(|backbone| !backbone.amplitudes.is_empty());
    if !run.loop_elements.is_empty() && is_followed {
        outputs.push(Output::new(ELEMENT_LOOPS, csv::element_loops(run)?));
    }
    let mut sections = Vec::new();
    for analysis in ANALYSES {
        if let Some(document) = (analysis.document)(run, summary)? {
            outputs.extend(document.outputs);
            sections.extend(document.section);
        }
    }
    outputs.push(Output::new(
        "report.html",
        page::document(run, summary, &pictures, sections)?,
    ));
    let json = serde_json::to_string_pretty(summary).map_err(Error::Summary)?;
    outputs.push(Output::new(SUMMARY, json + "\n"));
    Ok(outputs)
}

/// The bodies of a run that are shown deformed.
struct Bodies<'a> {
    of: &'a Deformed,
    surface: Vec<Face>,
}

impl<'a> Bodies<'a> {
    fn of(run: &'a Run) -> Option<Self> {
        let of = run.deformed.as_ref()?;
        let surface = of.mesh.boundary();
        Some(Self { of, surface })
    }

    /// Displacements at the positive peak of an amplitude, by places of the mode and of the amplitude.
    fn peak(&self, mode: usize, amplitude: usize) -> Option<&'a [[f64; 3]]> {
        self.of.peaks.get(mode)?.get(amplitude)?.as_deref()
    }

    /// Displacements, and shares of the elements in the error of the mesh, if there are any.
    fn file(&self, name: String, displacement: &[[f64; 3]], shares: &[f64]) -> Result<Output, Error> {
        let mesh = &self.of.mesh;
        let mut fields = vec![bodies::displacement("displacement [m]".into(), displacement)];
        if !shares.is_empty() {
            fields.push(bodies::mean_at_nodes(mesh, "share of mesh error [-]", shares));
        }
        bodies::vtu(mesh, &self.surface, fields)
            .map(|document| Output::new(name, document))
            .map_err(Error::Shapes)
    }
}

fn title(run: &Run, mode: usize) -> String {
    let scene = &run.scene;
    let bolts = match run.model.reduced.loads.len() {
        0 => "no bolts".to_owned(),
        _ => format!("bolts {}", tensions(run)),
    };
    format!("{}: mode {mode}, mu = {}, {bolts}", scene.name, scene.interfaces.mu)
}
