//! The files of a run.

use crate::html::Picture;
use crate::periodic::{self, PeriodicMotions};
use crate::{Error, Output, bodies, csv, fields, page, plot, sensitivity, tightening, uncertainty};
use analyses::results::summary::{BackboneSummary, Status, Summary};
use analyses::{Deformed, Fields, Run};
use finite_elements::mesh::Face;

/// Name of the machine-readable account of a run.
pub const SUMMARY: &str = "summary.json";

/// Name of the table of an ensemble.
pub const ENSEMBLE: &str = "ensemble.csv";

/// Name of the table of free periodic motions by EPMC.
pub const EPMC: &str = "epmc.csv";

/// Name of the table of hysteresis loops of single points.
pub const LOOPS: &str = "loops.csv";

/// Name of the table of hysteresis loops of interface elements along quasi-static loops.
pub const ELEMENT_LOOPS: &str = "element-loops.csv";

/// Name of the table of forced responses.
pub const FORCED: &str = "forced.csv";

/// Name of the picture of forced responses.
pub const FORCED_PICTURE: &str = "forced.svg";

/// Name of the arrays of periodic motions.
pub const PERIODIC: &str = "periodic.npz";

/// Name of the interface file of an amplitude, counted from 1; `mode` is none for the first mode followed.
pub fn amplitude_file(mode: Option<usize>, number: usize) -> String {
    format!("interface-{}amplitude-{number:02}.vtu", of_mode(mode))
}

/// Name of the file of the deformed bodies at an amplitude, counted from 1; `mode` is none for the first mode followed.
pub fn bodies_file(mode: Option<usize>, number: usize) -> String {
    format!("bodies-{}amplitude-{number:02}.vtu", of_mode(mode))
}

/// Name of the file of the deformed bodies in the static state.
pub const BODIES_PRESTRESS: &str = "bodies-prestress.vtu";

/// Name of the interface file of the static state.
const PRESTRESS: &str = "interface-prestress.vtu";

/// Name of the list of the interface files of a mode over the amplitude, the static state being at zero; `mode` is none for the first mode
/// followed.
pub fn series_file(mode: Option<usize>) -> String {
    of_mode(mode) + "fields.pvd"
}

/// Name of the table of a backbone; `mode` is none for the first mode followed.
pub fn table_file(mode: Option<usize>) -> String {
    of_mode(mode) + "backbone.csv"
}

/// Name of the picture of a backbone; `mode` is none for the first mode followed.
pub fn picture_file(mode: Option<usize>) -> String {
    of_mode(mode) + "backbone.svg"
}

/// Name of the picture of the harmonics of a mode's EPMC backbone; `mode` is none for the first mode followed.
pub fn harmonics_file(mode: Option<usize>) -> String {
    of_mode(mode) + "harmonics.svg"
}

/// Name of the picture of the loops of single points in a mode; `mode` is none for the first mode followed.
pub fn loops_file(mode: Option<usize>) -> String {
    of_mode(mode) + "loops.svg"
}

/// What distinguishes the files of a mode from those of the first mode followed.
fn of_mode(mode: Option<usize>) -> String {
    mode.map_or_else(String::new, |mode| format!("mode-{mode}-"))
}

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
        outputs.push(bodies.file(BODIES_PRESTRESS.into(), &bodies.of.prestress)?);
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
                    outputs.push(bodies.file(name, peak)?);
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
    if let Some(result) = &summary.tightening {
        outputs.extend(tightening::outputs(result)?);
    }
    if let Some(ensemble) = &summary.ensemble {
        outputs.push(Output::new(ENSEMBLE, csv::ensemble(ensemble)?));
    }
    let sensitivities = &summary.sensitivities;
    if !sensitivities.is_empty() {
        outputs.push(Output::new(sensitivity::TABLE, sensitivity::rows(sensitivities)?));
        if let Some(picture) = sensitivity::picture(sensitivities)? {
            outputs.push(Output::new(sensitivity::PICTURE, picture));
        }
    }
    let mut of_samples = Vec::new();
    if let Some(uncertainty) = &summary.uncertainty {
        let (files, drawn) = uncertainty::outputs(uncertainty, &run.scene.name, &summary.response)?;
        outputs.extend(files);
        of_samples = drawn;
    }
    let motions = PeriodicMotions::of(run, summary);
    let periodic = motions
        .as_ref()
        .map(|motions| periodic_files(run, motions))
        .transpose()?;
    let (files, drawn) = periodic.unwrap_or_default();
    outputs.extend(files);
    outputs.push(Output::new(
        "report.html",
        page::document(run, summary, &pictures, drawn, of_samples)?,
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

    fn file(&self, name: String, displacement: &[[f64; 3]]) -> Result<Output, Error> {
        let document = bodies::vtu(&self.of.mesh, &self.surface, "displacement [m]", displacement);
        document
            .map(|document| Output::new(name, document))
            .map_err(Error::Shapes)
    }
}

/// Tables, arrays and pictures of periodic motions, and the pictures for the page.
fn periodic_files(run: &Run, motions: &PeriodicMotions<'_>) -> Result<(Vec<Output>, Vec<Picture<'static>>), Error> {
    let mut outputs = vec![Output::new(PERIODIC, motions.archive()?)];
    let mut pictures = Vec::new();
    let mut add = |name: String, svg: String, caption: String, outputs: &mut Vec<Output>| {
        outputs.push(Output::new(name, svg.clone()));
        let svg = svg.into();
        pictures.push(Picture { svg, caption });
    };
    if !motions.forced.is_empty() {
        outputs.push(Output::new(FORCED, csv::forced(motions.forced)?));
        let title = format!("{}: forced responses", run.scene.name);
        if let Some(picture) = motions.response_picture(&title)? {
            let caption = format!(
                "Response to a harmonic force. Amplitude: {}.",
                plot::amplitude_label(motions.response)
            );
            add(FORCED_PICTURE.into(), picture, caption, &mut outputs);
        }
    }
    if !motions.epmc.is_empty() {
        outputs.push(Output::new(EPMC, csv::epmc(&motions.epmc)?));
    }
    for &(mode, points) in &motions.epmc {
        let further = (mode != run.first().mode).then_some(mode);
        let title = format!("{}: harmonics of mode {mode} by EPMC", run.scene.name);
        let picture = periodic::harmonics_picture(points, motions.response, &title)?;
        let caption =
            format!("Amplitudes of the harmonics of mode {mode} over that of the first, in the norm of the mass.");
        add(harmonics_file(further), picture, caption, &mut outputs);
    }
    let loops: Vec<_> = run
        .backbones
        .iter()
        .filter_map(|of| Some((of.mode, of.epmc.as_ref()?.loops.as_slice())))
        .filter(|(_, loops)| !loops.is_empty())
        .collect();
    if !loops.is_empty() {
        outputs.push(Output::new(
            LOOPS,
            csv::loops(&loops, fields::point_positions(run).as_deref())?,
        ));
    }
    for &(mode, of_mode) in &loops {
        let further = (mode != run.first().mode).then_some(mode);
        let title = format!("{}: loops of mode {mode} by EPMC", run.scene.name);
        let picture = periodic::loops_picture(of_mode, &title)?;
        let caption =
            "Tangential traction of single points against their jump, both from their means over a period; q is the \
                       modal amplitude in sqrt(kg) m."
                .to_owned();
        add(loops_file(further), picture, caption, &mut outputs);
    }
    Ok((outputs, pictures))
}

fn title(run: &Run, mode: usize) -> String {
    let scene = &run.scene;
    let bolts = match run.model.reduced.loads.len() {
        0 => "no bolts".to_owned(),
        _ => format!("bolts {}", tensions(run)),
    };
    format!("{}: mode {mode}, mu = {}, {bolts}", scene.name, scene.mu)
}

/// Tension of the bolts as text.
pub(crate) fn tensions(run: &Run) -> String {
    let all = run.prestress.tensions.iter().map(|tension| tension / 1e3);
    let (low, high) = all.fold((f64::INFINITY, 0.0_f64), |(l, h), load| (l.min(load), h.max(load)));
    match low < high {
        true => format!("{low:.3} to {high:.3} kN"),
        false => format!("{low:.3} kN each"),
    }
}

/// Total damping ratio as text, or the floor that it lies below.
pub fn damping(b: &BackboneSummary) -> String {
    match (b.status, b.damping_ratio, b.damping_floor) {
        (Status::BelowFloor, _, Some(floor)) => format!("< {floor:.1e}"),
        (_, Some(zeta), _) => format!("{zeta:.4e}"),
        _ => "-".into(),
    }
}
