//! Which numbers of a scene a backbone depends on: a table, a picture, and the most influential ones in text.

use crate::analysis::{Analysis, Document, Section};
use crate::csv::{number, optional, table};
use crate::html::Picture;
use crate::plot;
use crate::styles::{self, COLOURS};
use crate::{Error, Output};
use analyses::results::summary::Summary;
use analyses::{FoundBy, Per, Sensitivity};
use plotters::prelude::*;
use std::fmt::Write as _;

/// Name of the table.
pub const TABLE: &str = "sensitivities.csv";

/// Name of the picture.
pub const PICTURE: &str = "sensitivities.svg";

/// Most amplitudes that have bars.
const AMPLITUDES: usize = 5;

/// Height of a line of the legend (pixels).
const LINE: u32 = 22;

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

/// Logarithmic derivatives of frequency and damping as bars, at a few amplitudes, for the parameters that are not zero; none without any.
///
/// # Errors
/// [`Error::Picture`].
pub fn picture(all: &[Sensitivity]) -> Result<Option<String>, Error> {
    let Some(first) = all.first() else { return Ok(None) };
    let drawn: Vec<&Sensitivity> = all
        .iter()
        .filter(|one| (one.mode, &one.method) == (first.mode, &first.method) && one.per == Per::Logarithm)
        .collect();
    let known: Vec<usize> = (0..first.modal_amplitude.len())
        .filter(|at| first.modal_amplitude[*at].is_some())
        .collect();
    if drawn.is_empty() || known.is_empty() {
        return Ok(None);
    }
    // Equally spaced, the first and the last among them.
    let count = known.len().min(AMPLITUDES);
    let chosen: Vec<usize> = (0..count)
        .map(|k| known[k * (known.len() - 1) / (count - 1).max(1)])
        .collect();
    let height = 300 + 300 + LINE * drawn.len() as u32 + 20;
    let svg = plot::picture("sensitivities", (800, height), |root| {
        let (legend, charts) = root.split_vertically(LINE * drawn.len() as u32 + 12);
        for (place, one) in drawn.iter().enumerate() {
            let top = (LINE as usize * place) as i32 + 8;
            let colour = COLOURS[place % COLOURS.len()];
            legend.draw(&Rectangle::new([(70, top), (98, top + 12)], colour.filled()))?;
            let style = ("sans-serif", 15).into_text_style(&legend);
            legend.draw(&Text::new(one.parameter.path().to_owned(), (106, top - 2), style))?;
        }
        let (upper, lower) = charts.split_vertically(300);
        let modal = |at: f64| {
            let place = chosen.get(at as usize).filter(|_| at.fract() == 0.0 && at >= 0.0)?;
            first.modal_amplitude[*place]
        };
        type Values = fn(&Sensitivity) -> &Vec<Option<f64>>;
        let quantities: [(_, &str, Values); 2] = [
            (&upper, "change of frequency [%]", |one| &one.dln_frequency),
            (&lower, "change of damping [%]", |one| &one.dln_damping),
        ];
        for (area, label, of) in quantities {
            let values: Vec<&Vec<Option<f64>>> = drawn.iter().map(|one| of(one)).collect();
            let shown = || {
                values
                    .iter()
                    .flat_map(|all| chosen.iter().filter_map(|at| all.get(*at).copied().flatten()))
            };
            let range = plot::bounds(shown().chain([0.0])).unwrap_or(-1.0..1.0);
            let text = plot::decimals(&plot::margin(&range));
            let amplitude = |at: &f64| modal(*at).map_or_else(String::new, |q| format!("{q:.1e}"));
            let mut chart = ChartBuilder::on(area)
                .margin(10)
                .set_label_area_size(LabelAreaPosition::Left, 78)
                .set_label_area_size(LabelAreaPosition::Bottom, 44)
                .build_cartesian_2d(-0.5..count as f64 - 0.5, plot::margin(&range))?;
            chart
                .configure_mesh()
                .disable_x_mesh()
                .light_line_style(TRANSPARENT)
                .label_style(("sans-serif", 14))
                .axis_desc_style(("sans-serif", 15))
                .x_labels(2 * count + 1)
                .x_label_formatter(&amplitude)
                .y_label_formatter(&text)
                .x_desc("modal amplitude [sqrt(kg) m]")
                .y_desc(label)
                .draw()?;
            let width = 0.8 / drawn.len() as f64;
            for (place, values) in values.iter().enumerate() {
                for (group, at) in chosen.iter().enumerate() {
                    let Some(value) = values.get(*at).copied().flatten() else {
                        continue;
                    };
                    let left = group as f64 - 0.4 + width * place as f64;
                    let corners = [(left, 0.0), (left + 0.9 * width, value)];
                    chart.draw_series([Rectangle::new(corners, COLOURS[place % COLOURS.len()].filled())])?;
                }
            }
        }
        Ok(())
    })?;
    Ok(Some(svg))
}

/// What the picture shows.
fn caption(all: &[Sensitivity]) -> String {
    let of = all.first().map_or_else(String::new, |first| {
        format!(" of mode {} by {}", first.mode, styles::title(&first.method))
    });
    format!("Change of frequency and damping{of} (%) for 1 % more of each parameter, at the same modal amplitude.")
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
