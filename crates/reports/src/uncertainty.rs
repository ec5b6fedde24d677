//! Bands from uncertain inputs: tables, pictures and what pages say of them.

use crate::analysis::{Analysis, Document, Section};
use crate::answer::{length, percent};
use crate::csv::{number, optional, table};
use crate::html::{Picture, Table};
use crate::names::by_mode;
use crate::plot::{self, BLUE, Band as Shade, Curve, Marks, RED};
use crate::{Drawing, Error, Output};
use analyses::uncertainty::{Band, ModeBands, Spread, Uncertainty};
use analyses::variants::Reading;
use plotters::prelude::*;
use std::fmt::Write;

/// Name of the table of bands.
pub const BANDS: &str = "bands.csv";

/// Name of the table of samples.
pub const SAMPLES: &str = "samples.csv";

/// Name of the table of shares of the variance.
pub const INFLUENCES: &str = "influences.csv";

/// Inputs that are named per amplitude.
const MOST: usize = 5;

/// Name of the picture of the bands of a mode; `mode` is none for the first mode followed.
pub fn bands_picture(mode: Option<usize>) -> String {
    mode.map_or_else(|| "bands.svg".into(), |mode| format!("mode-{mode}-bands.svg"))
}

/// A quantity with its unit, and how it is found in a band.
type Quantity = (&'static str, &'static str, fn(&Band) -> &Spread);

const QUANTITIES: [Quantity; 2] = [
    ("frequency", "Hz", |band| &band.frequency_hz),
    ("damping_ratio", "-", |band| &band.damping_ratio),
];

/// Percentages of lower edge, median and upper edge.
fn percentages(uncertainty: &Uncertainty) -> [String; 3] {
    let tail = 50.0 * (1.0 - uncertainty.confidence);
    // Without the digits that a difference of binary numbers leaves.
    [tail, 50.0, 100.0 - tail].map(|p| format!("{}", (1e9 * p).round() / 1e9))
}

/// All bands with their modes.
fn rows(uncertainty: &Uncertainty) -> impl Iterator<Item = (usize, &Band)> {
    uncertainty
        .modes
        .iter()
        .flat_map(|of| of.bands.iter().map(move |band| (of.mode, band)))
}

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| [BANDS, SAMPLES, INFLUENCES].contains(&name) || bands_picture(by_mode(name).0) == name,
    document: |run, summary| {
        let found = summary.uncertainty.as_ref();
        found
            .map(|found| document(found, &run.scene.name, &summary.response))
            .transpose()
    },
    lines: |summary| summary.uncertainty.as_ref().map(lines).unwrap_or_default(),
    is_complete: |summary| summary.uncertainty.iter().all(|found| found.failed == 0),
};

fn document(uncertainty: &Uncertainty, name: &str, response: &str) -> Result<Document, Error> {
    let mut outputs = vec![
        Output::new(BANDS, bands(uncertainty)?),
        Output::new(SAMPLES, samples(uncertainty)?),
        Output::new(INFLUENCES, influences(uncertainty)?),
    ];
    let mut pictures = Vec::new();
    for (place, mode) in uncertainty.modes.iter().enumerate() {
        let Some(svg) = picture(uncertainty, mode, name, response)? else {
            continue;
        };
        outputs.push(Output::new(
            bands_picture((place > 0).then_some(mode.mode)),
            svg.clone(),
        ));
        let [low, _, high] = percentages(uncertainty);
        let caption = format!(
            "Mode {}: shaded from {low} to {high} % of {} samples; dots: the scene itself; dashed: the edges by linear propagation.",
            mode.mode,
            uncertainty.samples - uncertainty.failed
        );
        pictures.push(Picture {
            svg: svg.into(),
            caption,
        });
    }
    let influences = uncertainty.modes.iter().map(|mode| {
        let heading = format!(
            "Mode {}: bands and the inputs with the largest shares of the variance",
            mode.mode
        );
        (heading, influence_table(uncertainty, mode))
    });
    let section = Section {
        heading: "Uncertain inputs",
        pictures,
        tables: std::iter::once((String::new(), inputs_table(uncertainty)))
            .chain(influences)
            .collect(),
        remarks: remarks(uncertainty),
        ..Section::default()
    };
    Ok(Document {
        outputs,
        section: Some(section),
    })
}

/// One row per mode and amplitude; empty cells where there is no value.
fn bands(uncertainty: &Uncertainty) -> Result<String, Error> {
    let names = percentages(uncertainty);
    let mut headings: Vec<String> = ["mode", "modal_amplitude [sqrt(kg) m]", "response_displacement [m]"]
        .map(str::to_owned)
        .into();
    for (name, unit, _) in QUANTITIES {
        headings.push(format!("{name}_samples"));
        let mut add = |what: &str| headings.push(format!("{name}_{what} [{unit}]"));
        let edges = [&names[0], &names[2]];
        ["nominal", "mean", "sd"].iter().for_each(|what| add(what));
        names.iter().for_each(|p| add(p));
        edges.iter().for_each(|p| add(&format!("{p}_half_width")));
        names.iter().for_each(|p| add(&format!("{p}_of_first_half")));
        ["linear_mean", "linear_sd"].iter().for_each(|what| add(what));
        edges.iter().for_each(|p| add(&format!("linear_{p}")));
        edges.iter().for_each(|p| add(&format!("linear_less_sampled_{p}")));
    }
    let row = |(mode, band): (usize, &Band)| {
        let mut cells = vec![
            mode.to_string(),
            number(band.modal_amplitude),
            number(band.response_displacement),
        ];
        for (_, _, of) in QUANTITIES {
            let spread = of(band);
            cells.push(spread.samples.to_string());
            let linear = spread.linear;
            let edges = [0, 2].map(|edge| linear.map(|linear| linear.quantiles[edge]));
            let differences = [0, 2].map(|edge| Some(linear?.quantiles[edge] - spread.quantiles[edge]?));
            let values = [spread.nominal, spread.mean, spread.sd]
                .into_iter()
                .chain(spread.quantiles)
                .chain(spread.half_widths)
                .chain(spread.of_first_half)
                .chain([linear.map(|linear| linear.mean), linear.map(|linear| linear.sd)])
                .chain(edges)
                .chain(differences);
            cells.extend(values.map(optional));
        }
        cells
    };
    table(headings, rows(uncertainty).map(row))
}

/// One row per sample, mode and amplitude of the scene's own backbone, with the inputs; a sample without a backbone is one row with its reason.
fn samples(uncertainty: &Uncertainty) -> Result<String, Error> {
    let inputs = uncertainty.inputs.iter().map(|input| match input.unit.as_str() {
        "" => format!("{} [-]", input.parameter),
        unit => format!("{} [{unit}]", input.parameter),
    });
    let before = ["sample"].map(str::to_owned).into_iter().chain(inputs);
    let after = [
        "mode",
        "modal_amplitude [sqrt(kg) m]",
        "frequency [Hz]",
        "damping_ratio [-]",
        "failure",
    ];
    let mut all = Vec::new();
    for (index, variant) in uncertainty.variants.iter().enumerate() {
        let mut given = vec![(index + 1).to_string()];
        given.extend(variant.inputs.iter().map(|value| number(*value)));
        if let Some(reason) = &variant.failure {
            let rest = [
                String::new(),
                String::new(),
                String::new(),
                String::new(),
                reason.clone(),
            ];
            all.push([given.clone(), rest.to_vec()].concat());
        }
        for (of_mode, curve) in uncertainty.modes.iter().zip(&variant.curves) {
            for band in &of_mode.bands {
                let amplitude = band.modal_amplitude;
                let found = match amplitude == 0.0 {
                    true => [Some(curve.linear_frequency_hz), None],
                    false => match curve.at(Reading::Modal, amplitude) {
                        Some([frequency, damping]) => [Some(frequency), Some(damping).filter(|zeta| zeta.is_finite())],
                        None => [None; 2],
                    },
                };
                let [frequency, damping] = found.map(optional);
                let rest = [
                    of_mode.mode.to_string(),
                    number(amplitude),
                    frequency,
                    damping,
                    String::new(),
                ];
                all.push([given.clone(), rest.to_vec()].concat());
            }
        }
    }
    table(before.chain(after.map(str::to_owned)), all)
}

/// One row per mode, amplitude, quantity and input.
fn influences(uncertainty: &Uncertainty) -> Result<String, Error> {
    let headings = [
        "mode",
        "modal_amplitude [sqrt(kg) m]",
        "response_displacement [m]",
        "quantity",
        "parameter",
        "linear_share [-]",
        "sobol_first [-]",
        "sobol_first_low [-]",
        "sobol_first_high [-]",
        "sobol_total [-]",
        "sobol_total_low [-]",
        "sobol_total_high [-]",
    ];
    let mut all = Vec::new();
    for (mode, band) in rows(uncertainty) {
        for (name, _, of) in QUANTITIES {
            let spread = of(band);
            for input in &uncertainty.inputs {
                let share = spread.shares.iter().find(|share| share.parameter == input.parameter);
                let index = spread.indices.iter().find(|index| index.parameter == input.parameter);
                if share.is_none() && index.is_none() {
                    continue;
                }
                let mut row = vec![
                    mode.to_string(),
                    number(band.modal_amplitude),
                    number(band.response_displacement),
                    name.to_owned(),
                    input.parameter.to_string(),
                    optional(share.map(|share| share.share)),
                ];
                let values = index.map(|index| {
                    let ([a, b], [c, d]) = (index.first_interval, index.total_interval);
                    [index.first, a, b, index.total, c, d]
                });
                row.extend((0..6).map(|place| optional(values.map(|values| values[place]))));
                all.push(row);
            }
        }
    }
    table(headings, all)
}

/// Frequency above, damping below; none where there are fewer than two amplitudes.
fn picture(uncertainty: &Uncertainty, mode: &ModeBands, name: &str, response: &str) -> Result<Option<String>, Error> {
    let bands: Vec<&Band> = mode.bands.iter().filter(|band| band.modal_amplitude > 0.0).collect();
    let Some(x) = plot::bounds(bands.iter().map(|band| band.response_displacement)).filter(|_| bands.len() > 1) else {
        return Ok(None);
    };
    let title = format!("{name}: mode {}, {} samples", mode.mode, uncertainty.samples);
    let draw = |root: &plot::Canvas<'_>| -> Result<(), Drawing> {
        let root = root.titled(&title, ("sans-serif", 20))?;
        let x = plot::widen(&x, 1.3);
        let x_ticks = plot::ticks(&x);
        let label = format!("{}, by the linearised mode", plot::amplitude_label(response));
        let amplitude = |x: &f64| length(*x);
        let (upper, lower) = root.split_vertically(330);
        for (area, which, colour) in [(upper, 0, BLUE), (lower, 1, RED)] {
            let (_, _, of) = QUANTITIES[which];
            let positive = |value: &f64| which == 0 || *value > 0.0;
            let shade = bands.iter().filter_map(|band| {
                let [low, _, high] = of(band).quantiles;
                Some((
                    band.response_displacement,
                    low.filter(positive)?,
                    high.filter(positive)?,
                ))
            });
            let shade = Shade {
                colour,
                points: shade.collect(),
            };
            let curve = |value: &dyn Fn(&Spread) -> Option<f64>, dashes, marks, name: &str| {
                let points = bands.iter().enumerate();
                let points = points
                    .filter_map(|(i, band)| Some((i, band.response_displacement, value(of(band)).filter(positive)?)));
                Curve {
                    name: name.into(),
                    colour,
                    dashes,
                    marks,
                    points: points.collect(),
                }
            };
            let edge = |edge: usize| move |spread: &Spread| spread.linear.map(|linear| linear.quantiles[edge]);
            let curves = [
                curve(&|spread| spread.nominal, None, Marks::Dots, "scene"),
                curve(&edge(0), Some((7, 4)), Marks::None, "linear propagation"),
                curve(&edge(2), Some((7, 4)), Marks::None, ""),
            ];
            let heights = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.2));
            let heights = heights.chain(shade.points.iter().flat_map(|point| [point.1, point.2]));
            let range = plot::bounds(heights.collect::<Vec<_>>().into_iter());
            // One point has no area.
            let shades = if shade.points.len() > 1 {
                vec![shade]
            } else {
                Vec::new()
            };
            let log_x = plot::log(&x, &x_ticks);
            match (which, range) {
                (_, None) => {
                    let (x, y) = (280, 150);
                    area.draw(&Text::new("no damping above its floor", (x, y), ("sans-serif", 18)))?;
                }
                (0, Some(range)) => {
                    let y = plot::margin(&range);
                    let text = plot::decimals(&y);
                    let texts: [&dyn Fn(&f64) -> String; 2] = [&amplitude, &text];
                    let legend = SeriesLabelPosition::LowerLeft;
                    plot::panel(
                        &area,
                        log_x,
                        y,
                        "frequency, secant [Hz]",
                        "",
                        texts,
                        &curves,
                        &shades,
                        legend,
                    )?;
                }
                (_, Some(range)) => {
                    let y = plot::widen(&range, 1.5);
                    let y_ticks = plot::ticks(&y);
                    let texts: [&dyn Fn(&f64) -> String; 2] = [&amplitude, &|zeta| percent(*zeta)];
                    let legend = SeriesLabelPosition::LowerRight;
                    let log_y = plot::log(&y, &y_ticks);
                    plot::panel(
                        &area,
                        log_x,
                        log_y,
                        "damping ratio",
                        &label,
                        texts,
                        &curves,
                        &shades,
                        legend,
                    )?;
                }
            }
        }
        Ok(())
    };
    plot::picture("the bands", (800, 720), draw).map(Some)
}

/// What is known of the inputs.
fn inputs_table(uncertainty: &Uncertainty) -> Table {
    let [low, middle, high] = percentages(uncertainty);
    let headings = [
        "input".to_owned(),
        "unit".into(),
        "scene".into(),
        "mean".into(),
        "standard deviation".into(),
    ];
    let row = |input: &analyses::uncertainty::Input| {
        let mut row = vec![input.parameter.to_string(), input.unit.clone()];
        row.extend([input.nominal, input.mean, input.sd].map(short));
        row.extend(input.quantiles.map(short));
        row
    };
    Table {
        headings: headings
            .into_iter()
            .chain([low, middle, high].map(|p| format!("{p} %")))
            .collect(),
        rows: uncertainty.inputs.iter().map(row).collect(),
    }
}

/// Bands, and the inputs with the largest shares of their variance, per amplitude of a mode.
fn influence_table(uncertainty: &Uncertainty, mode: &ModeBands) -> Table {
    let [low, middle, high] = percentages(uncertainty);
    let of_variance = match mode.bands.iter().any(|band| !band.frequency_hz.indices.is_empty()) {
        true => "share of variance (Sobol, first order)",
        false => "share of variance (linear)",
    };
    let headings = [
        "amplitude [m]".to_owned(),
        "quantity".into(),
        format!("{low} %"),
        format!("{middle} %"),
        format!("{high} %"),
        "samples".into(),
        of_variance.into(),
    ];
    let mut rows = Vec::new();
    for band in &mode.bands {
        for (name, unit, of) in QUANTITIES {
            let spread = of(band);
            if band.modal_amplitude == 0.0 && name == "damping_ratio" {
                continue;
            }
            let amplitude = if band.modal_amplitude == 0.0 {
                "linearised".into()
            } else {
                format!("{:.3e}", band.response_displacement)
            };
            let unit = if unit == "-" {
                String::new()
            } else {
                format!(" [{unit}]")
            };
            let mut row = vec![amplitude, format!("{}{unit}", name.replace('_', " "))];
            row.extend(spread.quantiles.map(|value| value.map_or_else(|| "-".into(), short)));
            row.extend([spread.samples.to_string(), most_influential(spread)]);
            rows.push(row);
        }
    }
    Table {
        headings: headings.into(),
        rows,
    }
}

/// Bands from uncertain inputs, and which of them matter most.
fn lines(found: &Uncertainty) -> String {
    let mut out = String::new();
    for mode in &found.modes {
        let table = influence_table(found, mode);
        let columns = 0..table.headings.len();
        let cells = |column: usize| table.rows.iter().map(move |row| row[column].chars().count());
        let widths: Vec<usize> = columns
            .map(|column| {
                cells(column)
                    .chain([table.headings[column].chars().count()])
                    .max()
                    .unwrap_or(0)
            })
            .collect();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "\nmode {}: bands from uncertain inputs", mode.mode);
        for row in std::iter::once(&table.headings).chain(&table.rows) {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                // Texts from the left, numbers from the right.
                let is_text = column == 1 || column + 1 == row.len();
                let _ = match is_text {
                    true => write!(line, "{cell:<width$}  "),
                    false => write!(line, "{cell:>width$}  "),
                };
            }
            let _ = writeln!(out, "{}", line.trim_end());
        }
    }
    for remark in remarks(found) {
        let _ = writeln!(out, "{remark}");
    }
    let _ = writeln!(
        out,
        "bands in {BANDS}, samples in {SAMPLES}, shares of the variance in {INFLUENCES}"
    );
    out
}

/// The inputs with the largest shares, by Sobol's first-order indices where they are known.
fn most_influential(spread: &Spread) -> String {
    let mut shares: Vec<(&str, f64)> = match spread.indices.is_empty() {
        true => spread
            .shares
            .iter()
            .map(|share| (share.parameter.path(), share.share))
            .collect(),
        false => spread
            .indices
            .iter()
            .map(|index| (index.parameter.path(), index.first))
            .collect(),
    };
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let texts = shares
        .iter()
        .take(MOST)
        .map(|(name, share)| format!("{name} {:.0} %", 100.0 * share + 0.0));
    let all: Vec<String> = texts.collect();
    if all.is_empty() { "-".into() } else { all.join(", ") }
}

/// A number in a few digits.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if (1e-2..1e5).contains(&size) => {
            let places = (4 - size.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{value:.places$}")
        }
        _ => format!("{value:.3e}"),
    }
}

/// What is to be said beside the tables.
fn remarks(uncertainty: &Uncertainty) -> Vec<String> {
    let mut all = vec![format!(
        "{} samples ({}, seed {}), {} of them without a backbone; {} runs in all",
        uncertainty.samples, uncertainty.method, uncertainty.seed, uncertainty.failed, uncertainty.runs
    )];
    let assumed = uncertainty
        .inputs
        .iter()
        .filter_map(|input| Some((input, input.assumption.as_ref()?)));
    all.extend(assumed.map(|(input, assumption)| format!("{}: {assumption}", input.parameter)));
    all.extend(uncertainty.left_out.clone());
    for (place, (name, unit, of)) in QUANTITIES.into_iter().enumerate() {
        // The edge that the number of samples leaves the least certain.
        let worst = rows(uncertainty).filter_map(|(_, band)| {
            let spread = of(band);
            let ([low, _, high], [a, b]) = (spread.quantiles, spread.half_widths);
            let error = a?.max(b?);
            Some((error / (high? - low?), error)).filter(|(share, _)| share.is_finite())
        });
        if let Some((share, error)) = worst.max_by(|a, b| a.0.total_cmp(&b.0)) {
            let unit = if place == 0 { format!(" {unit}") } else { String::new() };
            all.push(format!(
                "edges of the bands of {} are known within {}{unit} or better, {:.0} % of the width of the band (95 % confidence)",
                name.replace('_', " "),
                short(error),
                100.0 * share
            ));
        }
    }
    let shortest = rows(uncertainty)
        .filter(|(_, band)| band.modal_amplitude > 0.0)
        .map(|(_, band)| band.frequency_hz.samples)
        .min();
    if let Some(least) = shortest.filter(|least| *least + uncertainty.failed < uncertainty.samples) {
        all.push(format!(
            "not all samples reach all amplitudes: bands are from {least} samples at least"
        ));
    }
    all
}
