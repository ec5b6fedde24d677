//! Which numbers of a scene a backbone depends on: a table, a picture, and the most influential ones in text.

use crate::analysis::{Analysis, Document, Section};
use crate::csv::{number, optional, table};
use crate::html::Picture;
use crate::plot::{self, Curve, Marks, Panel};
use crate::styles::{self, COLOURS};
use crate::{Error, Output};
use analyses::results::summary::Summary;
use analyses::{FoundBy, Per, Sensitivity};
use plotters::prelude::SeriesLabelPosition;
use std::fmt::Write as _;

/// Name of the table.
pub const TABLE: &str = "sensitivities.csv";

/// Name of the picture.
pub const PICTURE: &str = "sensitivities.svg";

/// Numbers named at each amplitude.
const NAMED: usize = 5;

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| [TABLE, PICTURE].contains(&name),
    document: |_, summary| {
        let all = &summary.sensitivities;
        if all.is_empty() {
            return Ok(None);
        }
        let mut outputs = vec![Output::new(TABLE, rows(all)?)];
        let picture = picture(all)?;
        outputs.extend(picture.iter().map(|svg| Output::new(PICTURE, svg.clone())));
        let section = picture.map(|svg| Section {
            heading: "What frequency and damping depend on",
            pictures: vec![Picture {
                svg: svg.into(),
                caption: caption(all),
            }],
            ..Section::default()
        });
        Ok(Some(Document { outputs, section }))
    },
    lines: most_influential,
    is_complete: |_| true,
};

/// One row per mode, method, parameter and amplitude; empty cells where there is no value.
///
/// # Errors
/// [`Error::Table`].
fn rows(all: &[Sensitivity]) -> Result<String, Error> {
    let headings = [
        "mode",
        "method",
        "parameter",
        "value [SI]",
        "unit",
        "per",
        "by",
        "number",
        "modal_amplitude [sqrt(kg) m]",
        "dln_frequency",
        "dln_damping",
        "dln_frequency_first_harmonic",
        "dln_damping_first_harmonic",
        "dln_dissipation",
        "dln_response",
    ];
    let rows = all.iter().flat_map(|one| {
        (0..one.modal_amplitude.len()).map(move |at| {
            let cell = |values: &[Option<f64>]| optional(values.get(at).copied().flatten());
            [
                one.mode.to_string(),
                one.method.clone(),
                one.parameter.path().to_owned(),
                number(one.value),
                one.unit.clone(),
                per(one).to_owned(),
                by(one).to_owned(),
                (at + 1).to_string(),
                cell(&one.modal_amplitude),
                cell(&one.dln_frequency),
                cell(&one.dln_damping),
                cell(&one.dln_frequency_first_harmonic),
                cell(&one.dln_damping_first_harmonic),
                cell(&one.dln_dissipation),
                cell(&one.dln_response),
            ]
        })
    });
    table(headings, rows)
}

fn per(of: &Sensitivity) -> &'static str {
    match of.per {
        Per::Logarithm => "logarithm",
        Per::Value => "value",
    }
}

fn by(of: &Sensitivity) -> &'static str {
    match of.by {
        FoundBy::ImplicitDifferentiation => "implicit-differentiation",
        FoundBy::CentralDifferences => "central-differences",
    }
}

/// Logarithmic derivatives of frequency and damping against the modal amplitude, for the parameters that are not zero; none without any.
///
/// # Errors
/// [`Error::Picture`].
pub fn picture(all: &[Sensitivity]) -> Result<Option<String>, Error> {
    let Some(first) = all.first() else { return Ok(None) };
    let drawn: Vec<&Sensitivity> = all
        .iter()
        .filter(|one| (one.mode, &one.method) == (first.mode, &first.method) && one.per == Per::Logarithm)
        .collect();
    if drawn.is_empty() {
        return Ok(None);
    }
    let curves = |of: &dyn Fn(&Sensitivity) -> Vec<Option<f64>>, named: bool| -> Vec<Curve> {
        let one = |(index, one): (usize, &&Sensitivity)| {
            let pairs = one.modal_amplitude.iter().zip(of(one)).enumerate();
            Curve {
                name: if named {
                    one.parameter.path().to_owned()
                } else {
                    String::new()
                },
                colour: COLOURS[index % COLOURS.len()],
                dashes: (index >= COLOURS.len()).then_some((9, 5)),
                marks: if index >= COLOURS.len() {
                    Marks::None
                } else {
                    Marks::Dots
                },
                points: pairs.filter_map(|(at, (q, value))| Some((at, (*q)?, value?))).collect(),
            }
        };
        drawn.iter().enumerate().map(one).collect()
    };
    let panels = vec![
        Panel {
            y_label: "d ln(frequency) / d ln(parameter)",
            log: false,
            legend: SeriesLabelPosition::UpperLeft,
            curves: curves(&|one| one.dln_frequency.clone(), true),
        },
        Panel {
            y_label: "d ln(damping) / d ln(parameter)",
            log: false,
            legend: SeriesLabelPosition::LowerRight,
            curves: curves(&|one| one.dln_damping.clone(), false),
        },
    ];
    plot::stack("modal amplitude [sqrt(kg) m]", true, panels).map(Some)
}

/// What the picture shows.
fn caption(all: &[Sensitivity]) -> String {
    let of = all.first().map_or_else(String::new, |first| {
        format!(" of mode {} by {}", first.mode, styles::title(&first.method))
    });
    format!("Change of frequency and damping{of} with each parameter, all logarithmic, at the same modal amplitude.")
}

/// The most influential parameters at every amplitude, for frequency and for damping, as a table in text.
fn most_influential(summary: &Summary) -> String {
    let mut out = String::new();
    let all = &summary.sensitivities;
    let mut done = Vec::new();
    for first in all {
        let group = (first.mode, &first.method);
        if done.contains(&group) {
            continue;
        }
        done.push(group);
        let members: Vec<&Sensitivity> = all
            .iter()
            .filter(|one| (one.mode, &one.method) == group && one.per == Per::Logarithm)
            .collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "\nmost influential on mode {} by {}: change in % for 1 % more of a parameter, at the same modal amplitude",
            first.mode,
            styles::title(&first.method)
        );
        for (what, of) in [
            (
                "frequency",
                &(|one: &Sensitivity| one.dln_frequency.clone()) as &dyn Fn(&Sensitivity) -> Vec<_>,
            ),
            ("damping", &|one| one.dln_damping.clone()),
        ] {
            let values: Vec<(&str, Vec<Option<f64>>)> =
                members.iter().map(|one| (one.parameter.path(), of(one))).collect();
            for (at, q) in first.modal_amplitude.iter().enumerate() {
                let mut here: Vec<(&str, f64)> = values
                    .iter()
                    .filter_map(|(path, values)| Some((*path, values.get(at).copied().flatten()?)))
                    .collect();
                here.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
                let named = here
                    .iter()
                    .take(NAMED)
                    .map(|(path, value)| format!("{path} {value:+.3}"));
                let named: Vec<String> = named.collect();
                let named = if named.is_empty() {
                    "-".to_owned()
                } else {
                    named.join(", ")
                };
                let q = q.map_or_else(|| "-".into(), |q| format!("{q:.3e}"));
                let _ = writeln!(out, "{what:>9} {q:>10}  {named}");
            }
        }
    }
    out
}
