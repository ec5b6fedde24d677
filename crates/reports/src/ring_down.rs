//! The picture of a computed ring-down: the signal, and its identified backbone beside the quasi-static ones.

use crate::overlay::{self, Series};
use crate::plot::{BLUE, Canvas, Curve, Marks, bounds, panel, picture, plain};
use crate::{Drawing, Error};
use analyses::comparison::Backbone;
use plotters::prelude::*;

const SIZE: (u32, u32) = (900, 1080);

/// Acceleration over time (s, m/s^2) above, the identified backbone and those of the methods, by name, below.
///
/// # Errors
/// [`Error::Picture`].
pub fn svg(signal: &[(f64, f64)], identified: &Backbone, methods: &[(String, Backbone)]) -> Result<String, Error> {
    picture("the ring-down", SIZE, |root| panels(signal, identified, methods, root))
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
    let label = "acceleration amplitude at the response point [m/s^2]";
    overlay::draw([&areas[1], &areas[2]], &series, label)
}
