//! Pictures of many cases over their parameters: parallel coordinates, and a quantity against two parameters.

use crate::map::rgb;
use crate::plot::{Canvas, bounds, margin, picture};
use crate::{Drawing, Error};
use plotters::prelude::*;
use std::ops::Range;

const SIZE: (u32, u32) = (800, 460);
/// Most lines of a picture: more of them cover one another, and make files that browsers are slow with.
const MOST_LINES: usize = 2000;
/// Room beside and above the axes, and for the colour bar (pixels).
const SIDE: i32 = 70;
const ABOVE: i32 = 48;
const BELOW: i32 = 34;
const BAR: u32 = 110;
/// Steps of colour of the bar.
const STEPS: i32 = 64;
const FONT: (&str, i32) = ("sans-serif", 14);

/// A parameter or a quantity of all cases, in one order.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Its name, with its unit.
    pub name: String,
    /// Its value for each case, where it has one.
    pub values: Vec<Option<f64>>,
}

impl Axis {
    /// Smallest and largest value; something about it where all are equal.
    fn range(&self) -> Range<f64> {
        match bounds(self.values.iter().flatten().copied().filter(|value| value.is_finite())) {
            Some(range) if range.start < range.end => range,
            Some(range) => margin(&range),
            None => 0.0..1.0,
        }
    }

    fn value(&self, case: usize) -> Option<f64> {
        self.values
            .get(case)
            .copied()
            .flatten()
            .filter(|value| value.is_finite())
    }
}

/// Place of a value in a range, from 0 to 1.
fn place(value: f64, range: &Range<f64>) -> f64 {
    (value - range.start) / (range.end - range.start)
}

fn colour(place: f64) -> RGBColor {
    let [r, g, b] = rgb(place);
    RGBColor(r, g, b)
}

/// A number in at most four digits.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if (1e-3..1e5).contains(&size) => {
            let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
            let text = format!("{value:.decimals$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').into(),
                false => text,
            }
        }
        _ => format!("{value:.2e}"),
    }
}

/// Parallel coordinates: an upright line per axis, and a line per case through its values, coloured by the last axis. Also gives how many
/// cases are drawn, which are equally spaced among those that have a value on every axis.
///
/// # Errors
/// [`Error::Picture`].
pub fn parallel(axes: &[Axis]) -> Result<(String, usize), Error> {
    let cases = axes.first().map_or(0, |axis| axis.values.len());
    let whole: Vec<usize> = (0..cases)
        .filter(|case| axes.iter().all(|axis| axis.value(*case).is_some()))
        .collect();
    let stride = whole.len().div_ceil(MOST_LINES).max(1);
    let mut drawn: Vec<usize> = whole.into_iter().step_by(stride).collect();
    let ranges: Vec<Range<f64>> = axes.iter().map(Axis::range).collect();
    let at = |case: usize, axis: usize| {
        let value = axes.get(axis).and_then(|axis| axis.value(case));
        value
            .zip(ranges.get(axis))
            .map_or(0.0, |(value, range)| place(value, range))
    };
    let last = axes.len().saturating_sub(1);
    // The highest values lie on top.
    drawn.sort_by(|a, b| at(*a, last).total_cmp(&at(*b, last)));
    let svg = picture("parallel coordinates", SIZE, |root| {
        let (width, height) = (SIZE.0 as i32, SIZE.1 as i32);
        let x = |axis: usize| SIDE + (width - 2 * SIDE) * axis as i32 / last.max(1) as i32;
        let y = |place: f64| height - BELOW - (f64::from(height - ABOVE - BELOW) * place) as i32;
        for &case in &drawn {
            let points: Vec<(i32, i32)> = (0..axes.len()).map(|axis| (x(axis), y(at(case, axis)))).collect();
            root.draw(&PathElement::new(
                points,
                colour(at(case, last)).mix(0.6).stroke_width(1),
            ))?;
        }
        let centred = FONT.into_text_style(root).pos(text_anchor());
        for (index, (axis, range)) in axes.iter().zip(&ranges).enumerate() {
            root.draw(&PathElement::new(
                vec![(x(index), y(0.0)), (x(index), y(1.0))],
                BLACK.stroke_width(1),
            ))?;
            // Names in two rows, so that long ones do not meet.
            let row = if index % 2 == 0 { 8 } else { 24 };
            root.draw(&Text::new(axis.name.clone(), (x(index), row), centred.clone()))?;
            root.draw(&Text::new(
                short(range.end),
                (x(index) + 22, y(1.0) - 14),
                centred.clone(),
            ))?;
            root.draw(&Text::new(short(range.start), (x(index), y(0.0) + 6), centred.clone()))?;
        }
        Ok(())
    })?;
    Ok((svg, drawn.len()))
}

fn text_anchor() -> plotters::style::text_anchor::Pos {
    use plotters::style::text_anchor::{HPos, Pos, VPos};
    Pos::new(HPos::Center, VPos::Top)
}

/// A quantity against two parameters: fields where the cases are a grid, else dots; with a colour bar.
///
/// # Errors
/// [`Error::Picture`].
pub fn response_surface(x: &Axis, y: &Axis, quantity: &Axis) -> Result<String, Error> {
    let points: Vec<[f64; 3]> = (0..quantity.values.len())
        .filter_map(|case| Some([x.value(case)?, y.value(case)?, quantity.value(case)?]))
        .collect();
    let columns = cells(points.iter().map(|point| point[0]));
    let rows = cells(points.iter().map(|point| point[1]));
    let is_grid = columns.len() * rows.len() == points.len() && columns.len() > 1 && rows.len() > 1;
    let range = quantity.range();
    picture("a response surface", SIZE, |root| {
        let (left, right) = root.split_horizontally(SIZE.0 - BAR);
        let span = |cells: &[(f64, Range<f64>)], axis: &Axis| match (is_grid, cells) {
            (true, [first, .., last]) => first.1.start..last.1.end,
            _ => margin(&axis.range()),
        };
        let mut chart = ChartBuilder::on(&left)
            .margin(10)
            .set_label_area_size(LabelAreaPosition::Left, 78)
            .set_label_area_size(LabelAreaPosition::Bottom, 52)
            .build_cartesian_2d(span(&columns, x), span(&rows, y))?;
        let number = |value: &f64| short(*value);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .label_style(FONT)
            .axis_desc_style(("sans-serif", 16))
            .x_label_formatter(&number)
            .y_label_formatter(&number)
            .x_desc(&x.name)
            .y_desc(&y.name)
            .draw()?;
        for [px, py, value] in points {
            let fill = colour(place(value, &range)).filled();
            let cell = |cells: &[(f64, Range<f64>)], at: f64| {
                let index = cells.partition_point(|(own, _)| *own < at);
                cells.get(index).map(|(_, cell)| cell.clone())
            };
            match cell(&columns, px).zip(cell(&rows, py)).filter(|_| is_grid) {
                Some((across, up)) => {
                    let corners = [(across.start, up.start), (across.end, up.end)];
                    chart.draw_series([Rectangle::new(corners, fill)])?;
                }
                None => {
                    chart.draw_series([Circle::new((px, py), 5, fill)])?;
                }
            }
        }
        bar(&right, &quantity.name, &range)
    })
}

/// The values that occur, ascending, each with the cell about it up to the middles between neighbours.
fn cells(values: impl Iterator<Item = f64>) -> Vec<(f64, Range<f64>)> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let cell = |k: usize| {
        let own = values.get(k).copied().unwrap_or_default();
        let before = k
            .checked_sub(1)
            .and_then(|k| values.get(k))
            .map(|other| 0.5 * (own - other));
        let after = values.get(k + 1).map(|other| 0.5 * (other - own));
        let (below, above) = (before.or(after).unwrap_or(0.5), after.or(before).unwrap_or(0.5));
        (own, own - below..own + above)
    };
    (0..values.len()).map(cell).collect()
}

/// The bar of colours.
fn bar(area: &Canvas<'_>, name: &str, range: &Range<f64>) -> Result<(), Drawing> {
    let (top, bottom, left, right) = (ABOVE, SIZE.1 as i32 - 62, 8, 28);
    let height = |place: f64| bottom - (f64::from(bottom - top) * place) as i32;
    for step in 0..STEPS {
        let of = |step: i32| f64::from(step) / f64::from(STEPS);
        let corners = [(left, height(of(step))), (right, height(of(step + 1)))];
        area.draw(&Rectangle::new(corners, colour(of(step)).filled()))?;
    }
    let style = FONT.into_text_style(area);
    for k in 0..=4 {
        let place = f64::from(k) / 4.0;
        let value = range.start + place * (range.end - range.start);
        area.draw(&Text::new(short(value), (right + 6, height(place) - 7), style.clone()))?;
    }
    area.draw(&Text::new(name.to_owned(), (0, top - 30), style))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::markup;

    fn axis(name: &str, values: &[f64]) -> Axis {
        Axis {
            name: name.into(),
            values: values.iter().map(|value| Some(*value)).collect(),
        }
    }

    #[test]
    fn cells_of_a_grid_meet_in_the_middle() {
        let found = cells([1.0, 2.0, 4.0, 2.0].into_iter());
        assert_eq!(found, [(1.0, 0.5..1.5), (2.0, 1.5..3.0), (4.0, 3.0..5.0)]);
        assert_eq!(cells([3.0].into_iter()), [(3.0, 2.5..3.5)]);
    }

    #[test]
    fn numbers_on_axes_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (0.25, "0.25"),
            (169.8756, "169.9"),
            (12845.0, "12845"),
            (100.0, "100"),
            (2.97e-5, "2.97e-5"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn pictures_hold_every_case_once() {
        let (mu, load) = (
            axis("/interfaces/mu", &[0.1, 0.1, 0.2, 0.2]),
            axis("/bolts/load [kN]", &[8.0, 9.0, 8.0, 9.0]),
        );
        let frequency = axis("frequency [Hz]", &[150.0, 151.0, 152.0, 153.0]);
        let svg = response_surface(&mu, &load, &frequency).expect("a picture");
        assert_eq!(markup::check(&svg), Ok(()));
        let fields = svg.matches("<rect").count();
        let dots = response_surface(&mu, &axis("y", &[1.0, 2.0, 3.0, 4.0]), &frequency).expect("a picture");
        // The ground and the bar are rectangles of both.
        assert_eq!(fields, dots.matches("<rect").count() + 4);
        assert_eq!(dots.matches("<circle").count(), 4);
        let (svg, lines) = parallel(&[mu, load, frequency]).expect("a picture");
        assert_eq!((markup::check(&svg), lines), (Ok(()), 4));
        assert_eq!(svg.matches("<polyline").count(), 4 + 3);
        // A case without a value is left out, and equal values are drawn.
        let missing = Axis {
            name: "z".into(),
            values: vec![None, Some(1.0)],
        };
        let (_, lines) = parallel(&[axis("a", &[1.0, 1.0]), missing]).expect("a picture");
        assert_eq!(lines, 1);
        let many: Vec<f64> = (0..5000).map(f64::from).collect();
        assert_eq!(
            parallel(&[axis("a", &many), axis("b", &many)]).expect("a picture").1,
            1667
        );
    }
}
