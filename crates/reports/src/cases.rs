//! Cases of a study: their backbones by parameter, what parameters do alone and in pairs, and what a page's scripts read.

use crate::answer::unit_of_length;
use crate::html::{MISSING, Table};
use crate::map::rgb;
use crate::plot::{Canvas, Curve, Marks, bounds, decimals, log, margin, panel, picture, plain, power, ticks, widen};
use crate::{Drawing, Error};
use plotters::prelude::*;
use serde::Serialize;
use std::ops::Range;

/// Size of a diagram (pixels), and how many stand side by side at most.
const DIAGRAM: (u32, u32) = (300, 230);
const MOST_COLUMNS: usize = 3;

/// Most backbones of a diagram, and of a page's scripts: more of them cover one another.
const MOST_CURVES: usize = 200;

/// Most levels of a parameter; more values are brought together in as many intervals.
const MOST_LEVELS: usize = 8;

/// A parameter of all cases.
#[derive(Clone, Debug, Serialize)]
pub struct Factor {
    /// Its name, with its unit.
    pub name: String,
    /// Its value for each case, where it has one; places among the labels, where there are labels.
    pub values: Vec<Option<f64>>,
    /// Texts that it takes; empty for numbers.
    pub labels: Vec<String>,
}

impl Factor {
    fn range(&self) -> Range<f64> {
        bounds(self.values.iter().flatten().copied()).unwrap_or(0.0..1.0)
    }

    /// Place of the value of a case in the range, from 0 to 1.
    fn place(&self, case: usize) -> Option<f64> {
        let (value, range) = ((*self.values.get(case)?)?, self.range());
        let width = range.end - range.start;
        Some(if width > 0.0 {
            (value - range.start) / width
        } else {
            0.5
        })
    }

    /// A value in words.
    fn text(&self, value: f64) -> String {
        let label = self.labels.get(value as usize).filter(|_| value >= 0.0);
        label.cloned().unwrap_or_else(|| plain(&value))
    }
}

/// A finished amplitude of a case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Amplitude {
    /// Displacement amplitude at the response point (m).
    pub amplitude_m: f64,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Total damping ratio; none below its floor.
    pub damping_ratio: Option<f64>,
}

/// The cases of a study, in one order.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Cases {
    /// What varies.
    pub parameters: Vec<Factor>,
    /// The backbone of each case; empty where it has none.
    pub backbones: Vec<Vec<Amplitude>>,
    /// Number of each case in its plan, from 1 on.
    pub numbers: Vec<usize>,
}

/// Two quantities of a backbone: name, and value in the unit of the name.
type Quantity = (&'static str, fn(&Amplitude) -> Option<f64>);

const QUANTITIES: [Quantity; 2] = [
    ("frequency [Hz]", |at| Some(at.frequency_hz)),
    ("damping [%]", |at| at.damping_ratio.map(|ratio| 100.0 * ratio)),
];

impl Cases {
    /// Of how many cases a page shows one: of all, where they are not too many.
    pub fn stride(&self) -> usize {
        self.backbones.len().div_ceil(MOST_CURVES).max(1)
    }

    /// As many cases as a page can show, equally spaced.
    #[must_use]
    pub fn thinned(&self) -> Self {
        let stride = self.stride();
        let kept = |case: &usize| case.is_multiple_of(stride);
        let places: Vec<usize> = (0..self.backbones.len()).filter(kept).collect();
        let parameters = self.parameters.iter().map(|factor| Factor {
            values: places.iter().map(|case| factor.values[*case]).collect(),
            ..factor.clone()
        });
        Self {
            parameters: parameters.collect(),
            backbones: places.iter().map(|case| self.backbones[*case].clone()).collect(),
            numbers: places.iter().map(|case| self.numbers[*case]).collect(),
        }
    }

    /// Small multiples: for each parameter frequency and damping against amplitude, coloured by the parameter.
    ///
    /// # Errors
    /// [`Error::Picture`].
    pub fn backbones(&self) -> Result<String, Error> {
        let cases = self.thinned();
        let all = || cases.backbones.iter().flatten();
        let amplitudes = bounds(all().map(|at| at.amplitude_m).filter(|x| *x > 0.0)).unwrap_or(1e-6..1e-6);
        // The unit that suits the middle of a logarithmic axis.
        let (unit, scale) = unit_of_length((amplitudes.start * amplitudes.end).sqrt());
        let x_label = format!("amplitude [{unit}]");
        let x = widen(&(scale * amplitudes.start..scale * amplitudes.end), 1.2);
        diagrams(
            "backbones of cases",
            &cases.parameters,
            true,
            |factor, quantity, area| {
                let (name, value) = QUANTITIES[quantity];
                let is_log = quantity == 1;
                let mut order: Vec<usize> = (0..cases.backbones.len()).collect();
                // The highest values lie on top.
                order.sort_by(|a, b| {
                    factor
                        .place(*a)
                        .partial_cmp(&factor.place(*b))
                        .unwrap_or(std::cmp::Ordering::Equal)
                });
                let curve = |case: usize| {
                    let [r, g, b] = rgb(factor.place(case).unwrap_or(0.0));
                    let points = cases.backbones[case].iter().enumerate();
                    let points = points.filter_map(|(i, at)| Some((i, scale * at.amplitude_m, value(at)?)));
                    Curve {
                        name: String::new(),
                        colour: RGBColor(r, g, b),
                        dashes: None,
                        marks: Marks::None,
                        points: points.filter(|(_, x, y)| *x > 0.0 && (!is_log || *y > 0.0)).collect(),
                    }
                };
                let curves: Vec<Curve> = order.into_iter().map(curve).collect();
                let range = bounds(curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.2)));
                let range = range.unwrap_or(0.1..1.0);
                let x_ticks = ticks(&x);
                let legend = SeriesLabelPosition::LowerLeft;
                match is_log {
                    true => {
                        let y = widen(&range, 1.5);
                        let y_ticks = ticks(&y);
                        let axes: [&dyn Fn(&f64) -> String; 2] = [&short, &short];
                        let y_axis = log(&y, &y_ticks);
                        panel(
                            area,
                            log(&x, &x_ticks),
                            y_axis,
                            name,
                            &x_label,
                            axes,
                            &curves,
                            &[],
                            legend,
                        )
                    }
                    false => {
                        let y = margin(&range);
                        let text = decimals(&y);
                        let axes: [&dyn Fn(&f64) -> String; 2] = [&short, &text];
                        panel(area, log(&x, &x_ticks), y, name, &x_label, axes, &curves, &[], legend)
                    }
                }
            },
        )
    }
}

/// A number of a logarithmic axis.
fn short(value: &f64) -> String {
    match value.abs() {
        size if (1e-3..1e4).contains(&size) => plain(value),
        _ => power(value),
    }
}

/// Two rows of diagrams for every few parameters, under their names and, where they are coloured, the colours of their ends; `draw` is told the
/// parameter and the row.
fn diagrams(
    name: &'static str,
    factors: &[Factor],
    is_coloured: bool,
    draw: impl Fn(&Factor, usize, &Canvas<'_>) -> Result<(), Drawing>,
) -> Result<String, Error> {
    const HEAD: u32 = 44;
    let columns = factors.len().clamp(1, MOST_COLUMNS);
    let bands = factors.len().div_ceil(columns);
    let height = HEAD + 2 * DIAGRAM.1;
    let size = (DIAGRAM.0 * columns as u32, height * bands as u32);
    picture(name, size, |root| {
        for (place, factor) in factors.iter().enumerate() {
            let (left, top) = (DIAGRAM.0 * (place % columns) as u32, height * (place / columns) as u32);
            let area = root.clone().shrink((left, top), (DIAGRAM.0, height));
            let (head, rows) = area.split_vertically(HEAD);
            let bold = ("sans-serif", 15).into_text_style(&head);
            head.draw(&Text::new(factor.name.clone(), (12, 4), bold))?;
            let range = factor.range();
            let ends = [(range.start, 0.0), (range.end, 1.0)].into_iter().enumerate();
            for (place, (value, at)) in ends.filter(|_| is_coloured) {
                let [r, g, b] = rgb(at);
                let left = 12 + 140 * place as i32;
                head.draw(&Rectangle::new(
                    [(left, 28), (left + 22, 34)],
                    RGBColor(r, g, b).filled(),
                ))?;
                let style = ("sans-serif", 13).into_text_style(&head);
                head.draw(&Text::new(factor.text(value), (left + 28, 23), style))?;
            }
            for (quantity, area) in rows.split_evenly((2, 1)).iter().enumerate() {
                draw(factor, quantity, area)?;
            }
        }
        Ok(())
    })
}

/// Levels of a parameter, ascending: a value, and the cases there.
fn levels(factor: &Factor) -> Vec<(f64, Vec<usize>)> {
    let mut known: Vec<(f64, usize)> = factor
        .values
        .iter()
        .enumerate()
        .filter_map(|(case, v)| Some(((*v)?, case)))
        .collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let groups: Vec<Vec<(f64, usize)>> = known.chunk_by(|a, b| a.0 == b.0).map(<[_]>::to_vec).collect();
    let groups = match groups.len() {
        0..=MOST_LEVELS => groups,
        _ => known
            .chunks(known.len().div_ceil(MOST_LEVELS))
            .map(<[_]>::to_vec)
            .collect(),
    };
    let level = |group: Vec<(f64, usize)>| {
        let value = group.iter().map(|(value, _)| value).sum::<f64>() / group.len() as f64;
        (value, group.into_iter().map(|(_, case)| case).collect())
    };
    groups.into_iter().map(level).collect()
}

/// Mean over those cases that have a value.
fn mean(values: &[Option<f64>], cases: impl Iterator<Item = usize>) -> Option<f64> {
    let (sum, count) = cases
        .filter_map(|case| values[case])
        .fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// Main effects: for each parameter the mean of the frequency (Hz) and of the damping ratio over the cases at each of its values.
///
/// # Errors
/// [`Error::Picture`].
pub fn main_effects(factors: &[Factor], quantities: &[Vec<Option<f64>>; 2]) -> Result<String, Error> {
    let means = |levels: &[(f64, Vec<usize>)], quantity: usize| -> Vec<(usize, f64, f64)> {
        let scale = if quantity == 1 { 100.0 } else { 1.0 };
        let at = |(place, (_, cases)): (usize, &(f64, Vec<usize>))| {
            let mean = mean(&quantities[quantity], cases.iter().copied())?;
            Some((place, place as f64, scale * mean))
        };
        levels.iter().enumerate().filter_map(at).collect()
    };
    // One range for all, so that effects compare.
    let range = |quantity: usize| {
        let all = factors.iter().flat_map(|factor| means(&levels(factor), quantity));
        bounds(all.map(|point| point.2)).map_or(0.0..1.0, |range| margin(&range))
    };
    let ranges = [range(0), range(1)];
    diagrams("main effects", factors, false, |factor, quantity, area| {
        let levels = levels(factor);
        let curve = Curve {
            name: String::new(),
            colour: [crate::plot::BLUE, crate::plot::RED][quantity],
            dashes: None,
            marks: Marks::Dots,
            points: means(&levels, quantity),
        };
        let (x, y) = (-0.5..levels.len() as f64 - 0.5, ranges[quantity].clone());
        let text = decimals(&y);
        // Ticks between levels have no text.
        let level = |at: &f64| {
            let known = levels
                .get(at.round() as usize)
                .filter(|_| (at - at.round()).abs() < 1e-6 && *at > -0.5);
            known.map_or_else(String::new, |(value, _)| factor.text(*value))
        };
        let name = ["mean frequency [Hz]", "mean damping [%]"][quantity];
        let axes: [&dyn Fn(&f64) -> String; 2] = [&level, &text];
        panel(
            area,
            x,
            y,
            name,
            "",
            axes,
            &[curve],
            &[],
            SeriesLabelPosition::LowerLeft,
        )
    })
}

/// Effects of pairs of parameters on a quantity, relative to its mean (%). On the diagonal: by how much the mean of the cases in the upper half of a
/// parameter's range is above that of those in the lower half. Beside it: by how much half of this effect grows from the lower to the
/// upper half of the other parameter (two-factor interaction). A dash where a half has no cases.
pub fn interactions(factors: &[Factor], values: &[Option<f64>]) -> Table {
    let half = |factor: &Factor, upper: bool| -> Vec<usize> {
        let range = factor.range();
        let middle = 0.5 * (range.start + range.end);
        let is_in = |case: &usize| {
            factor.values[*case].is_some_and(|value| if upper { value > middle } else { value < middle })
        };
        (0..values.len()).filter(is_in).collect()
    };
    let both = |a: &[usize], b: &[usize]| mean(values, a.iter().filter(|case| b.contains(case)).copied());
    let all = mean(values, 0..values.len());
    let effect = |a: &Factor, b: &Factor| -> Option<f64> {
        let [low, high] = [false, true].map(|upper| half(a, upper));
        if std::ptr::eq(a, b) {
            return Some(mean(values, high.into_iter())? - mean(values, low.into_iter())?);
        }
        let [other_low, other_high] = [false, true].map(|upper| half(b, upper));
        let at = |other: &[usize]| Some(both(&high, other)? - both(&low, other)?);
        Some(0.5 * (at(&other_high)? - at(&other_low)?))
    };
    let row = |a: &Factor| {
        let cells = factors.iter().map(|b| match effect(a, b).zip(all) {
            Some((effect, all)) => format!("{:+.2} %", 100.0 * effect / all),
            None => MISSING.into(),
        });
        std::iter::once(a.name.clone()).chain(cells).collect()
    };
    Table {
        headings: std::iter::once(String::new())
            .chain(factors.iter().map(|factor| factor.name.clone()))
            .collect(),
        rows: factors.iter().map(row).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::markup;

    /// A full plan of two numbers at two levels and a text, and a quantity of them.
    fn plan(of: impl Fn(f64, f64) -> f64) -> (Vec<Factor>, Vec<Option<f64>>) {
        let rows: Vec<(f64, f64)> = vec![(1.0, 0.0), (1.0, 1.0), (2.0, 0.0), (2.0, 1.0)];
        let factor = |name: &str, labels: &[&str], value: fn(&(f64, f64)) -> f64| Factor {
            name: name.into(),
            values: rows.iter().map(|row| Some(value(row))).collect(),
            labels: labels.iter().map(|label| (*label).to_owned()).collect(),
        };
        let factors = vec![
            factor("/interfaces/mu", &[], |row| row.0),
            factor("/interfaces/gap", &["flat", "measured"], |row| row.1),
        ];
        (factors, rows.iter().map(|row| Some(of(row.0, row.1))).collect())
    }

    #[test]
    fn effects_are_those_of_a_factorial_plan() {
        let (factors, values) = plan(|a, b| 100.0 + 10.0 * (a - 1.5) + 4.0 * (b - 0.5) + 8.0 * (a - 1.5) * (b - 0.5));
        let table = interactions(&factors, &values);
        assert_eq!(table.headings, ["", "/interfaces/mu", "/interfaces/gap"]);
        assert_eq!(table.rows[0], ["/interfaces/mu", "+10.00 %", "+4.00 %"]);
        assert_eq!(table.rows[1], ["/interfaces/gap", "+4.00 %", "+4.00 %"]);
        // Without one of the cases nothing is made up.
        let mut lacking = values.clone();
        lacking[3] = None;
        assert_eq!(interactions(&factors, &lacking).rows[0][2], MISSING);
    }

    #[test]
    fn pictures_have_a_diagram_for_each_parameter_and_quantity() {
        let (parameters, values) = plan(|a, b| 150.0 + a + b);
        let backbone = |frequency: &Option<f64>| {
            let at = |amplitude_m: f64| Amplitude {
                amplitude_m,
                frequency_hz: frequency.unwrap_or(1.0) - 1e4 * amplitude_m,
                damping_ratio: (amplitude_m > 2e-6).then_some(100.0 * amplitude_m),
            };
            [1e-6, 1e-5, 1e-4].map(at).to_vec()
        };
        let cases = Cases {
            backbones: values.iter().map(backbone).collect(),
            numbers: (1..=4).collect(),
            parameters: parameters.clone(),
        };
        let svg = cases.backbones().expect("a picture");
        assert_eq!(markup::check(&svg), Ok(()));
        assert!(svg.contains("amplitude [um]") && svg.contains("damping [%]") && svg.contains("measured"));
        let [r, g, b] = rgb(1.0);
        assert!(svg.contains(&format!("#{r:02X}{g:02X}{b:02X}")), "{svg}");
        let svg = main_effects(&parameters, &[values.clone(), values]).expect("a picture");
        assert_eq!(markup::check(&svg), Ok(()));
        assert!(svg.matches("<circle").count() >= 8);
    }

    #[test]
    fn many_values_are_brought_together() {
        let factor = Factor {
            name: String::new(),
            values: (0..100).map(|value| Some(f64::from(value))).collect(),
            labels: Vec::new(),
        };
        let found = levels(&factor);
        assert_eq!(found.len(), MOST_LEVELS);
        assert_eq!(found.iter().map(|(_, cases)| cases.len()).sum::<usize>(), 100);
    }
}
