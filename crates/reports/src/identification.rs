//! Table and picture of an identification: signal, spectrum, frequency and damping.

use crate::plot::{BLUE, Canvas, Curve, Marks, Points, RED, bounds, log, panel, picture, plain, power, ticks, widen};
use crate::{Drawing, Error, csv};
use modal_identification::average::MeanPoint;
use modal_identification::backbone::{Identification, Point};
use modal_identification::signal::{Quantity, Signal};
use plotters::prelude::*;
use std::ops::Range;

const SIZE: (u32, u32) = (900, 1200);
const GREY: RGBColor = RGBColor(150, 150, 150);
/// Columns of pixels that signals and spectra are thinned to.
const COLUMNS: usize = 700;

/// A ring-down and what was found in it.
#[derive(Clone, Copy)]
pub struct Hit<'a> {
    /// As measured.
    pub signal: &'a Signal,
    /// Its backbone, spectrum and trims.
    pub found: &'a Identification,
}

/// One row per amplitude, ascending; empty cells where there is no value.
///
/// # Errors
/// [`Error::Table`].
pub fn table(mean: &[MeanPoint], quantity: Quantity) -> Result<String, Error> {
    let amplitude = format!("amplitude [{}]", quantity.unit());
    let headings = [
        &amplitude,
        "frequency_hz",
        "damping_ratio",
        "frequency_spread_hz",
        "damping_ratio_spread",
        "hits",
    ];
    let rows = mean.iter().map(|p| {
        let [x, f, zeta] = [p.amplitude, p.frequency_hz, p.damping_ratio].map(csv::number);
        let [f_spread, zeta_spread] = p.spread.map_or_else(Default::default, |s| s.map(csv::number));
        [x, f, zeta, f_spread, zeta_spread, p.hits.to_string()]
    });
    csv::table(headings, rows)
}

/// Signal and spectrum of the first hit, frequency and damping ratio of all hits and their mean.
///
/// # Errors
/// [`Error::Picture`].
pub fn svg(hits: &[Hit<'_>], mean: &[MeanPoint], quantity: Quantity) -> Result<String, Error> {
    picture("the identification", SIZE, |root| panels(hits, mean, quantity, root))
}

fn panels(hits: &[Hit<'_>], mean: &[MeanPoint], quantity: Quantity, root: &Canvas<'_>) -> Result<(), Drawing> {
    let areas = root.split_evenly((4, 1));
    let Some(hit) = hits.first() else {
        return Ok(());
    };
    let (signal, found) = (hit.signal, hit.found);

    let rate = signal.sample_rate;
    let thinned = extremes(&signal.samples).map(|(i, v)| (i as f64 / rate, v));
    let y = margins(bounds(signal.samples.iter().copied()), 0.0);
    let used = uprights([found.trims.start, found.trims.end], &y);
    panel(
        &areas[0],
        0.0..signal.duration(),
        y,
        &format!("{} [{}]", signal.quantity, signal.quantity.unit()),
        "time [s]",
        [&plain, &|v| format!("{v:.1e}")],
        &[curve("signal", GREY, numbered(thinned)), dashed("used", RED, used)],
        &[],
        SeriesLabelPosition::UpperRight,
    )?;

    let spectrum = &found.spectrum;
    let last = ((3.0 * found.peak_hz / spectrum.step) as usize).min(spectrum.magnitudes.len() - 1);
    let lines = &spectrum.magnitudes[1..=last];
    let stride = lines.len().div_ceil(COLUMNS);
    let highest = |(i, chunk): (usize, &[f64])| {
        let middle = 1.0 + i as f64 * stride as f64 + 0.5 * (chunk.len() - 1) as f64;
        (middle * spectrum.step, chunk.iter().copied().fold(0.0, f64::max))
    };
    let thinned: Vec<(f64, f64)> = lines
        .chunks(stride)
        .enumerate()
        .map(highest)
        .filter(|l| l.1 > 0.0)
        .collect();
    let y = bounds(thinned.iter().map(|l| l.1)).map_or(0.1..1.0, |range| widen(&range, 2.0));
    let band = uprights(found.band_hz, &y);
    let y_ticks = ticks(&y);
    panel(
        &areas[1],
        0.0..last as f64 * spectrum.step,
        log(&y, &y_ticks),
        "spectrum after the hit",
        "frequency [Hz]",
        [&plain, &power],
        &[
            curve("spectrum", BLUE, numbered(thinned.into_iter())),
            dashed("band", RED, band),
        ],
        &[],
        SeriesLabelPosition::UpperRight,
    )?;

    let amplitudes = bounds(mean.iter().map(|p| p.amplitude)).unwrap_or(0.1..1.0);
    let x = widen(&amplitudes, 1.1);
    let x_ticks = ticks(&x);
    let label = format!("{quantity} amplitude at the sensor [{}]", quantity.unit());
    for (area, y_label, colour, least, of_point, of_mean) in [
        (
            &areas[2],
            "frequency [Hz]",
            BLUE,
            1e-3,
            (|p| p.frequency_hz) as fn(&Point) -> f64,
            (|p| [p.frequency_hz, p.spread.map_or(0.0, |s| s[0])]) as fn(&MeanPoint) -> [f64; 2],
        ),
        (
            &areas[3],
            "damping ratio [-]",
            RED,
            0.1,
            |p| p.damping_ratio,
            |p| [p.damping_ratio, p.spread.map_or(0.0, |s| s[1])],
        ),
    ] {
        let mut curves = Vec::new();
        if hits.len() > 1 {
            for (number, hit) in hits.iter().enumerate() {
                let points = hit.found.backbone.iter().map(|p| (p.amplitude, of_point(p)));
                curves.push(curve(&format!("hit {}", number + 1), GREY, numbered(points)));
            }
            for sign in [-1.0, 1.0] {
                let edge = mean.iter().enumerate().filter(|(_, p)| p.spread.is_some());
                let points = edge.map(|(i, p)| (i, p.amplitude, of_mean(p)[0] + sign * of_mean(p)[1]));
                let name = if sign > 0.0 { "mean + spread" } else { "mean - spread" };
                curves.push(dashed(name, colour, points.collect()));
            }
        }
        curves.push(curve(
            "mean",
            colour,
            numbered(mean.iter().map(|p| (p.amplitude, of_mean(p)[0]))),
        ));
        let y = margins(bounds(curves.iter().flat_map(|c| c.points.iter().map(|p| p.2))), least);
        let digits = move |v: &f64| {
            if colour == RED {
                format!("{v:.4}")
            } else {
                format!("{v:.2}")
            }
        };
        let position = if colour == RED {
            SeriesLabelPosition::UpperLeft
        } else {
            SeriesLabelPosition::LowerLeft
        };
        panel(
            area,
            log(&x, &x_ticks),
            y,
            y_label,
            &label,
            [&power, &digits],
            &curves,
            &[],
            position,
        )?;
    }
    Ok(())
}

fn curve(name: &str, colour: RGBColor, points: Points) -> Curve {
    Curve {
        name: name.into(),
        colour,
        dashes: None,
        marks: Marks::None,
        points,
    }
}

fn dashed(name: &str, colour: RGBColor, points: Points) -> Curve {
    Curve {
        dashes: Some((6, 4)),
        ..curve(name, colour, points)
    }
}

fn numbered(points: impl Iterator<Item = (f64, f64)>) -> Points {
    points.enumerate().map(|(i, (x, y))| (i, x, y)).collect()
}

/// Two upright lines over the whole height.
fn uprights([a, b]: [f64; 2], y: &Range<f64>) -> Points {
    vec![(0, a, y.start), (1, a, y.end), (3, b, y.start), (4, b, y.end)]
}

fn margins(range: Option<Range<f64>>, least: f64) -> Range<f64> {
    let Range { start, end } = range.unwrap_or(0.0..1.0);
    // Noise on a constant shall not fill the picture.
    let margin = (0.06 * (end - start)).max(least * end.abs());
    start - margin..end + margin
}

/// Smallest and largest sample of each column of pixels, with their places.
fn extremes(samples: &[f64]) -> impl Iterator<Item = (usize, f64)> {
    let stride = samples.len().div_ceil(COLUMNS).max(1);
    samples.chunks(stride).enumerate().flat_map(move |(column, chunk)| {
        let place = |smallest: bool| {
            let pick = |best: usize, i: usize| if (chunk[i] < chunk[best]) == smallest { i } else { best };
            (0..chunk.len()).fold(0, pick)
        };
        let (low, high) = (place(true), place(false));
        [low.min(high), low.max(high)].map(|i| (column * stride + i, chunk[i]))
    })
}
