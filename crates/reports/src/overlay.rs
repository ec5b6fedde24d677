//! Backbones on shared axes: frequency above, damping ratio below.

use crate::answer::{length, percent};
use crate::plot::{Canvas, Curve, Marks, Numbers, bounds, log, panel, picture, power, ticks, widen};
use crate::styles::COLOURS;
use crate::{Drawing, Error};
use analyses::comparison::{Backbone, Point};
use modal_identification::signal::Quantity;
use plotters::prelude::*;
use std::ops::Range;

const SIZE: (u32, u32) = (900, 800);

/// A backbone to be drawn.
pub struct Series<'a> {
    /// Name in the legend.
    pub name: String,
    /// Its points.
    pub backbone: &'a Backbone,
    /// Length and spacing of dashes (pixels); none: a solid line.
    pub dashes: Option<(u32, u32)>,
    /// Edges of the band of uncertainty, thinly dashed in the same colour.
    pub band: Option<[&'a Backbone; 2]>,
}

/// Name of amplitudes at the response point beside their axis, and how its numbers are written: lengths with the unit that suits each.
pub(crate) fn abscissa(quantity: Quantity) -> (String, Numbers) {
    let name = format!("{quantity} amplitude at the response point");
    match quantity {
        Quantity::Displacement => (name, |x| length(*x)),
        Quantity::Velocity | Quantity::Acceleration => (format!("{name} [{}]", quantity.unit()), power),
    }
}

/// The series over amplitudes of this quantity, on a picture of their own.
///
/// # Errors
/// [`Error::Picture`].
pub fn svg(series: &[Series<'_>], quantity: Quantity) -> Result<String, Error> {
    picture("the comparison", SIZE, |root| {
        let (upper, lower) = root.split_vertically(SIZE.1 / 2 - 15);
        draw([&upper, &lower], series, quantity)
    })
}

/// Draws the series into two areas of equal width.
pub(crate) fn draw([upper, lower]: [&Canvas<'_>; 2], series: &[Series<'_>], quantity: Quantity) -> Result<(), Drawing> {
    let (label, amplitude) = abscissa(quantity);
    let amplitudes = series.iter().flat_map(|s| s.backbone.range());
    let x = widen(&bounds(amplitudes).unwrap_or(0.1..1.0), 1.1);
    let x_ticks = ticks(&x);

    let frequency = curves(series, |p| Some(p.frequency_hz));
    let Range { start, end } = bounds(values(&frequency)).unwrap_or(0.0..1.0);
    let margin = (0.08 * (end - start)).max(1e-3 * end);
    panel(
        upper,
        log(&x, &x_ticks),
        start - margin..end + margin,
        "frequency [Hz]",
        "",
        [&amplitude, &|f| format!("{f:.2}")],
        &frequency,
        &[],
        SeriesLabelPosition::LowerLeft,
    )?;

    let damping = curves(series, |p| p.damping_ratio);
    let y = bounds(values(&damping)).map_or(1e-6..1.0, |range| widen(&range, 1.5));
    let y_ticks = ticks(&y);
    panel(
        lower,
        log(&x, &x_ticks),
        log(&y, &y_ticks),
        "damping ratio",
        &label,
        [&amplitude, &|zeta| percent(*zeta)],
        &damping,
        &[],
        SeriesLabelPosition::LowerRight,
    )
}

fn curves(series: &[Series<'_>], value: fn(&Point) -> Option<f64>) -> Vec<Curve> {
    let points = |backbone: &Backbone| {
        let points = backbone.points().iter().enumerate();
        points.filter_map(|(i, p)| Some((i, p.amplitude, value(p)?))).collect()
    };
    let mut out = Vec::new();
    for (series, colour) in series.iter().zip(COLOURS.into_iter().cycle()) {
        out.push(Curve {
            name: series.name.clone(),
            colour,
            dashes: series.dashes,
            marks: Marks::None,
            points: points(series.backbone),
        });
        let edges = series.band.iter().flatten().zip(["5 %", "95 %"]);
        out.extend(edges.map(|(edge, share)| Curve {
            name: format!("{}, {share}", series.name),
            colour,
            dashes: Some((2, 3)),
            marks: Marks::None,
            points: points(edge),
        }));
    }
    out
}

fn values(curves: &[Curve]) -> impl Iterator<Item = f64> {
    curves.iter().flat_map(|c| c.points.iter().map(|p| p.2))
}
