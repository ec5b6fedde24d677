//! A ring-down: the signal, and its identified backbone beside those of the run.

use crate::analysis::{Analysis, Document, Section};
use crate::html::{Picture, Table};
use crate::overlay::{self, Series};
use crate::plot::{BLUE, Canvas, Curve, Marks, bounds, panel, picture, plain};
use crate::{Drawing, Error, Output, csv, identification};
use analyses::comparison::{Backbone, Misfit, Point};
use analyses::ring_down::{Identified, Motion, RingDownSummary};
use modal_identification::signal::Quantity;
use plotters::prelude::*;
use std::fmt::Write;

/// Name of the table of the identified backbone.
pub const RING_DOWN: &str = "ring-down.csv";

/// Name of the table of the motion.
pub const SIGNAL: &str = "ring-down-signal.csv";

/// Name of the table of the backbones of the run over acceleration.
pub const THEORY: &str = "ring-down-theory.csv";

/// Name of the picture.
pub const RING_DOWN_PICTURE: &str = "ring-down.svg";

const SIZE: (u32, u32) = (900, 1080);

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| [RING_DOWN, RING_DOWN_PICTURE, SIGNAL, THEORY].contains(&name),
    document: |run, summary| {
        let Some(told) = &summary.ring_down else {
            return Ok(None);
        };
        let mut outputs = Vec::new();
        let mut picture = None;
        if let Some(Ok(found)) = &run.vibration.ring_down {
            outputs.push(Output::new(SIGNAL, signal(&found.motion)?));
            if let Ok(identified) = &found.identified {
                let svg = svg(&found.motion, identified)?;
                outputs.push(Output::new(
                    RING_DOWN,
                    identification::table(&identified.mean, Quantity::Acceleration)?,
                ));
                outputs.push(Output::new(THEORY, theory(identified)?));
                outputs.push(Output::new(RING_DOWN_PICTURE, svg.clone()));
                picture = Some(svg);
            }
        }
        Ok(Some(Document {
            outputs,
            section: Some(section(told, picture)),
        }))
    },
    lines: |summary| summary.ring_down.as_ref().map(lines).unwrap_or_default(),
    is_complete: |summary| summary.ring_down.iter().all(|found| found.failure.is_none()),
};

/// The motion of the response point and the energies.
fn signal(motion: &Motion) -> Result<String, Error> {
    let headings = [
        "time [s]",
        "acceleration [m/s^2]",
        "velocity [m/s]",
        "displacement [m]",
        "kinetic [J]",
        "kinetic_elsewhere [J]",
        "elastic [J]",
        "contact_work [J]",
        "viscous_work [J]",
        "external_work [J]",
    ];
    let rows = motion.transient.samples.iter().map(|s| {
        let e = s.energy;
        [
            s.time,
            s.acceleration,
            s.velocity,
            s.displacement,
            e.kinetic,
            e.kinetic_elsewhere,
            e.elastic,
            e.contact,
            e.viscous,
            e.external,
        ]
        .map(csv::number)
    });
    csv::table(headings, rows)
}

/// The backbones of the run over acceleration.
fn theory(found: &Identified) -> Result<String, Error> {
    let headings = ["method", "amplitude [m/s^2]", "frequency_hz", "damping_ratio"];
    let rows = found.theories.iter().flat_map(|(name, backbone)| {
        let row = move |p: &Point| {
            let [x, f] = [p.amplitude, p.frequency_hz].map(csv::number);
            [name.clone(), x, f, csv::optional(p.damping_ratio)]
        };
        backbone.points().iter().map(row)
    });
    csv::table(headings, rows)
}

/// What the page says of it.
fn section(found: &RingDownSummary, picture: Option<String>) -> Section {
    let [low, high] = found.amplitudes;
    let picture = picture.map(|svg| Picture {
        svg: svg.into(),
        caption: format!(
            "Free decay of the response point, and the backbone identified from it between {low:.3e} and {high:.3e} m/s²."
        ),
    });
    let mut remarks = found.warnings.clone();
    if found.steps > 0 {
        remarks.insert(
            0,
            format!(
                "{} steps; energy kept within {:.1e}; {:.1e} of the kinetic energy outside the mode; damping ratio of the integration {:.1e}; \
                 its frequency error, {:.1e}, is taken out.",
                found.steps,
                found.energy_error,
                found.kinetic_elsewhere,
                found.integration_damping_ratio,
                found.integration_frequency_ratio - 1.0,
            ),
        );
    }
    let warnings = found
        .failure
        .iter()
        .map(|reason| format!("Nothing is identified: {reason}."));
    let misfits = (!found.theory_minus_ring_down.is_empty()).then(|| (String::new(), misfits(found)));
    Section {
        heading: "Free decay in time",
        warnings: warnings.collect(),
        pictures: picture.into_iter().collect(),
        tables: misfits.into_iter().collect(),
        remarks,
        ..Section::default()
    }
}

/// What a ring-down shows.
fn lines(found: &RingDownSummary) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    if let Some(reason) = &found.failure {
        let _ = writeln!(out, "\nNO RING-DOWN IDENTIFIED: {reason}");
        return out;
    }
    let [low, high] = found.amplitudes;
    let _ = writeln!(
        out,
        "\nring-down: {} steps, energy kept within {:.1e}, {:.1e} of the kinetic energy outside the mode; identified from {high:.3e} down to \
         {low:.3e} m/s^2 in {RING_DOWN}",
        found.steps, found.energy_error, found.kinetic_elsewhere
    );
    for warning in &found.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    let misfits = found
        .theory_minus_ring_down
        .iter()
        .map(|(name, misfit)| (name.as_str(), misfit));
    let own = found.identification_of_cqsma_minus_cqsma.iter();
    for (name, misfit) in misfits.chain(own.map(|misfit| ("identification of cqsma", misfit))) {
        let _ = writeln!(out, "{}", misfit_line(name, misfit));
    }
    out
}

/// A misfit as a row on the terminal.
pub fn misfit_line(name: &str, m: &Misfit) -> String {
    let damping = m.damping_ln.map_or_else(|| "-".into(), |d| format!("{:.4}", d.rms));
    let [low, high] = m.amplitudes;
    let frequency = format!("{:.4}, {:.4}", m.frequency_hz.rms, m.frequency_percent.rms);
    format!(
        "{name:>24}  {:>19}  {frequency:>21}  {damping:>17}",
        format!("{low:.2e} to {high:.2e}")
    )
}

/// Differences from the ring-down.
fn misfits(summary: &RingDownSummary) -> Table {
    let headings = [
        "backbone",
        "amplitudes [m/s²]",
        "frequency, rms [Hz]",
        "frequency, rms [%]",
        "ln(damping ratio), rms",
    ];
    let row = |name: &str, misfit: &Misfit| {
        let [low, high] = misfit.amplitudes;
        let damping = misfit.damping_ln;
        vec![
            name.to_owned(),
            format!("{low:.2e} to {high:.2e}"),
            format!("{:.4}", misfit.frequency_hz.rms),
            format!("{:.4}", misfit.frequency_percent.rms),
            damping.map_or_else(|| "-".into(), |damping| format!("{:.4}", damping.rms)),
        ]
    };
    let theories = summary
        .theory_minus_ring_down
        .iter()
        .map(|(name, misfit)| row(name, misfit));
    let own = summary.identification_of_cqsma_minus_cqsma.iter();
    let own = own.map(|misfit| row("identification of a ring-down by cqsma, from cqsma", misfit));
    Table {
        headings: headings.map(Into::into).into(),
        rows: theories.chain(own).collect(),
    }
}

/// Acceleration over time (s, m/s^2) above, the identified backbone and those of the run, by name, below.
fn svg(motion: &Motion, found: &Identified) -> Result<String, Error> {
    let samples = &motion.transient.samples;
    let signal: Vec<(f64, f64)> = samples.iter().map(|s| (s.time, s.acceleration)).collect();
    picture("the ring-down", SIZE, |root| {
        panels(&signal, &found.backbone, &found.theories, root)
    })
}

fn panels(
    signal: &[(f64, f64)],
    identified: &Backbone,
    methods: &[(String, Backbone)],
    root: &Canvas<'_>,
) -> Result<(), Drawing> {
    let areas = root.split_evenly((3, 1));
    let points: Vec<_> = signal.iter().enumerate().map(|(i, &(t, a))| (i, t, a)).collect();
    let y = bounds(points.iter().map(|p| p.2)).unwrap_or(-1.0..1.0);
    let end = signal.last().map_or(1.0, |sample| sample.0);
    panel(
        &areas[0],
        0.0..end,
        1.05 * y.start..1.05 * y.end,
        "acceleration [m/s^2]",
        "time [s]",
        [&plain, &plain],
        &[Curve {
            name: String::new(),
            colour: BLUE,
            dashes: None,
            marks: Marks::None,
            points,
        }],
        &[],
        SeriesLabelPosition::UpperRight,
    )?;
    let mut series = vec![Series {
        name: "ring-down, identified".into(),
        backbone: identified,
        dashes: None,
        band: None,
    }];
    let dashes = [(9, 5), (2, 4), (14, 4), (5, 3), (3, 6)];
    series.extend(methods.iter().zip(dashes).map(|((name, backbone), dashes)| Series {
        name: name.clone(),
        backbone,
        dashes: Some(dashes),
        band: None,
    }));
    overlay::draw([&areas[1], &areas[2]], &series, Quantity::Acceleration)
}
