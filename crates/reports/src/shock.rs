//! A shock: the motion, its spectra, lines.

use crate::analysis::{Analysis, Document, Section};
use crate::csv::{number, table};
use crate::html::{Picture, Table};
use crate::plot::{BLUE, Curve, Marks, Panel, RED, power, stack};
use crate::{Error, Output};
use analyses::shock::{ShockResponse, ShockSummary};
use plotters::chart::SeriesLabelPosition;
use plotters::style::RGBColor;

/// Name of the table of the motion.
pub const SHOCK: &str = "shock.csv";

/// Name of the table of the spectra.
pub const SPECTRUM: &str = "shock-spectrum.csv";

/// Name of the picture of the motion.
pub const SHOCK_PICTURE: &str = "shock.svg";

/// Name of the picture of the spectra.
pub const SPECTRUM_PICTURE: &str = "shock-spectrum.svg";

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| [SHOCK, SPECTRUM, SHOCK_PICTURE, SPECTRUM_PICTURE].contains(&name),
    document: |run, summary| {
        let Some(told) = &summary.shock else {
            return Ok(None);
        };
        let (mut outputs, mut pictures) = (Vec::new(), Vec::new());
        if let Some(Ok(found)) = &run.vibration.shock {
            outputs.push(Output::new(SHOCK, motion(found, told)?));
            outputs.push(Output::new(SPECTRUM, spectrum(told)?));
            let drawn = [
                (
                    SHOCK_PICTURE,
                    picture(found)?,
                    "Displacement and acceleration of the response point.",
                ),
                (
                    SPECTRUM_PICTURE,
                    spectra(told)?,
                    "Shock response spectrum of the acceleration of the response point (maximax).",
                ),
            ];
            for (name, svg, caption) in drawn {
                outputs.push(Output::new(name, svg.clone()));
                let caption = format!("{caption} A joint that answers linearly beside it.");
                pictures.push(Picture {
                    svg: svg.into(),
                    caption,
                });
            }
        }
        let section = Some(section(told, pictures));
        Ok(Some(Document { outputs, section }))
    },
    lines: |summary| summary.shock.as_ref().map(line).unwrap_or_default(),
    is_complete: |summary| summary.shock.iter().all(|found| found.failure.is_none()),
};

/// A row per sample.
fn motion(found: &ShockResponse, told: &ShockSummary) -> Result<String, Error> {
    let load = format!("load [{}]", told.load_unit);
    let headings = [
        "time [s]",
        &load,
        "displacement [m]",
        "displacement_linear [m]",
        "acceleration [m/s^2]",
        "acceleration_linear [m/s^2]",
        "work_on_contact [J]",
    ];
    let [joint, linear] = &found.accelerations;
    let rows = (0..found.motion.samples.len()).map(|i| {
        let sample = &found.motion.samples[i];
        [
            sample.time,
            found.load[i],
            sample.displacement,
            found.linear.samples[i].displacement,
            joint[i],
            linear[i],
            sample.energy.contact,
        ]
        .map(number)
    });
    table(headings, rows)
}

/// A row per frequency.
fn spectrum(told: &ShockSummary) -> Result<String, Error> {
    let of = &told.spectrum;
    let rows = of.frequency_hz.iter().zip(&of.joint).zip(&of.linear);
    let rows = rows.map(|((f, joint), linear)| [*f, *joint, *linear].map(number));
    table(["frequency [Hz]", "joint [m/s^2]", "linear [m/s^2]"], rows)
}

fn curve(name: &str, colour: RGBColor, points: impl Iterator<Item = (f64, f64)>) -> Curve {
    Curve {
        name: name.into(),
        colour,
        dashes: None,
        marks: Marks::None,
        points: points.enumerate().map(|(i, (x, y))| (i, x, y)).collect(),
    }
}

fn picture(found: &ShockResponse) -> Result<String, Error> {
    let [joint, linear] = &found.accelerations;
    let times = || found.motion.samples.iter().map(|s| s.time);
    let panel = |y_label, values: [Vec<f64>; 2]| {
        let [joint, linear] = values;
        Panel {
            y_label,
            log: None,
            legend: SeriesLabelPosition::UpperRight,
            curves: vec![
                curve("linear joint", RED, times().zip(linear)),
                curve("joint", BLUE, times().zip(joint)),
            ],
        }
    };
    let displacement = [&found.motion, &found.linear].map(|of| of.samples.iter().map(|s| s.displacement).collect());
    let panels = vec![
        panel("displacement [m]", displacement),
        panel("acceleration [m/s^2]", [joint.clone(), linear.clone()]),
    ];
    stack("time [s]", false, panels)
}

fn spectra(told: &ShockSummary) -> Result<String, Error> {
    let of = &told.spectrum;
    let values = |values: &[f64]| of.frequency_hz.iter().copied().zip(values.to_vec()).collect::<Vec<_>>();
    let panel = Panel {
        y_label: "largest acceleration [m/s^2]",
        log: Some(power),
        legend: SeriesLabelPosition::LowerRight,
        curves: vec![
            curve("linear joint", RED, values(&of.linear).into_iter()),
            curve("joint", BLUE, values(&of.joint).into_iter()),
        ],
    };
    stack("natural frequency [Hz]", true, vec![panel])
}

/// What the page says.
fn section(told: &ShockSummary, pictures: Vec<Picture<'static>>) -> Section {
    let failure = told.failure.iter();
    let row = |name: &str, values: [f64; 2], unit: &str| {
        let cell = |value: f64| format!("{value:.4e}");
        vec![format!("{name} [{unit}]"), cell(values[0]), cell(values[1])]
    };
    let table = || Table {
        headings: ["", "joint", "linear joint"].map(Into::into).into(),
        rows: vec![
            row("largest displacement", told.largest_response, "m"),
            row("largest acceleration", told.largest_acceleration, "m/s²"),
            row("displacement that is left", [told.residual_response, 0.0], "m"),
            row("sliding that is left", [told.residual_sliding, 0.0], "m"),
        ],
    };
    Section {
        heading: "Shock",
        warnings: failure
            .map(|reason| format!("There is no response to the shock: {reason}."))
            .collect(),
        tables: match told.failure {
            None => vec![(String::new(), table())],
            Some(_) => Vec::new(),
        },
        remarks: match told.failure {
            None => vec![format!(
                "{} steps; energy kept within {:.1e}; in the last period {:.1e} of the largest displacement is left, about which the mean of the last two \
                 periods is what stays. Quality factor of the spectrum: {}.",
                told.steps, told.energy_error, told.still_moving, told.quality
            )],
            Some(_) => Vec::new(),
        },
        pictures,
        ..Section::default()
    }
}

/// What the terminal says.
fn line(told: &ShockSummary) -> String {
    match &told.failure {
        Some(reason) => format!("\nNO RESPONSE TO THE SHOCK: {reason}\n"),
        None => format!(
            "shock of {:.4e} {}: displacement {:.4e} m ({:.4e} with a linear joint), acceleration {:.4e} m/s^2 ({:.4e}); {:.2e} m of displacement and \
             {:.2e} m of sliding are left; energy kept within {:.1e}\n",
            told.largest_load,
            told.load_unit,
            told.largest_response[0],
            told.largest_response[1],
            told.largest_acceleration[0],
            told.largest_acceleration[1],
            told.residual_response,
            told.residual_sliding,
            told.energy_error
        ),
    }
}
