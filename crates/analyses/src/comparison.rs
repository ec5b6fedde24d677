//! Two backbones at the same amplitudes: how far apart they are.
//!
//! Between its points a backbone is linear over the logarithm of the amplitude, in frequency and in the logarithm of the
//! damping ratio. The norm of a misfit is the root mean square over amplitudes equally spaced in their logarithm over the
//! range that both backbones cover.

use crate::Error;
use file_io::input;
use modal_identification::signal::{Quantity, Unit};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::path::Path;

/// Amplitudes at which backbones are compared.
pub const POINTS: usize = 200;

/// One point of a backbone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Point {
    /// Amplitude at the response point (SI unit of its quantity).
    pub amplitude: f64,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio, if it is positive and more than noise.
    pub damping_ratio: Option<f64>,
}

/// A backbone in ascending order of amplitude.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Backbone {
    points: Vec<Point>,
}

/// How far a backbone lies from another, the reference, at one amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointDifference {
    /// Amplitude (SI unit of its quantity).
    pub amplitude: f64,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Frequency relative to the reference (%).
    pub frequency_percent: f64,
    /// Natural logarithm of the ratio of the damping ratios, where both have one.
    pub damping_ln: Option<f64>,
}

/// How far a backbone lies from another, the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Difference {
    /// Mean, with its sign.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
    /// Largest magnitude.
    pub largest: f64,
}

impl Difference {
    fn of(values: &[f64]) -> Option<Self> {
        let count = values.len() as f64;
        (!values.is_empty()).then(|| Self {
            mean: values.iter().sum::<f64>() / count,
            rms: (values.iter().map(|v| v * v).sum::<f64>() / count).sqrt(),
            largest: values.iter().fold(0.0, |m, v| m.max(v.abs())),
        })
    }
}

/// Theory minus reference over the amplitudes that both cover.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Misfit {
    /// Smallest and largest amplitude compared.
    pub amplitudes: [f64; 2],
    /// Frequency (Hz).
    pub frequency_hz: Difference,
    /// Frequency relative to the reference (%).
    pub frequency_percent: Difference,
    /// Natural logarithm of the ratio of the damping ratios; none where they share no amplitude.
    pub damping_ln: Option<Difference>,
    /// Amplitudes, of [`POINTS`], at which both have a damping ratio.
    pub damping_points: usize,
}

/// A measured backbone.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Name, by its folder and file.
    pub name: String,
    /// Its points, with amplitudes of `quantity`.
    pub backbone: Backbone,
    /// What was measured.
    pub quantity: Quantity,
}

impl Experiment {
    /// From a table as `identify` writes it: columns `amplitude [unit]`, `frequency_hz` and `damping_ratio`, and any others.
    ///
    /// # Errors
    /// [`Error::Comparison`] with file, line and column; of a file that cannot be read.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::of_table(path, &input::read_text(path, input::Kind::Table)?)
    }

    /// The same, from the text of the file.
    ///
    /// # Errors
    /// [`Error::Comparison`] with file, line and column.
    pub fn of_table(path: &Path, text: &str) -> Result<Self, Error> {
        let at = path.display();
        let refuse = |reason: String| Error::Comparison {
            what: format!("{at}{reason}"),
        };
        let mut table = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let header = table
            .headers()
            .map_err(|error| refuse(format!(", the first line: {error}")))?;
        let header = header.clone();
        let column = |wanted: &str| header.iter().position(|name| name == wanted);
        let (Some(first), Some(frequency), Some(damping)) =
            (header.get(0), column("frequency_hz"), column("damping_ratio"))
        else {
            return Err(refuse(
                ": the first line must name the columns `amplitude [unit]`, `frequency_hz` and `damping_ratio`, as `identify` writes them".into(),
            ));
        };
        let unit = first
            .strip_prefix("amplitude [")
            .and_then(|rest| rest.strip_suffix(']'));
        let unit = unit.ok_or_else(|| refuse(format!(": the first column is `{first}`, not `amplitude [unit]`")))?;
        let unit: Unit = unit
            .parse()
            .map_err(|error| refuse(format!(", the first line: {error}")))?;
        let mut points = Vec::new();
        for row in table.records() {
            let row = row.map_err(|error| refuse(format!(": {error}")))?;
            if row.iter().all(str::is_empty) {
                continue;
            }
            let number = |column: usize| -> Result<f64, Error> {
                let (cell, name) = (row.get(column).unwrap_or_default(), &header[column]);
                let line = row.position().map_or(0, csv::Position::line);
                let number = cell.parse();
                number.map_err(|_| refuse(format!(", line {line}, column `{name}`: `{cell}` is no number")))
            };
            points.push(Point {
                amplitude: unit.scale * number(0)?,
                frequency_hz: number(frequency)?,
                damping_ratio: Some(number(damping)?),
            });
        }
        Ok(Self {
            name: title(path),
            backbone: Backbone::try_new(&at.to_string(), points)?,
            quantity: unit.quantity,
        })
    }

    /// The same over another quantity, converted with its own frequency.
    ///
    /// # Errors
    /// [`Error::Comparison`].
    pub fn over(self, quantity: Quantity) -> Result<Self, Error> {
        let more = quantity.derivatives() - self.quantity.derivatives();
        Ok(Self {
            backbone: self.backbone.differentiated(&self.name, more)?,
            quantity,
            ..self
        })
    }
}

/// Name of a file with a backbone: that of its folder, and that of the file where it is its own.
pub fn title(path: &Path) -> String {
    let name = |path: Option<&Path>| path.and_then(Path::file_name).map(|n| n.to_string_lossy().into_owned());
    match (name(path.parent()), name(Some(path))) {
        (Some(folder), Some(file)) if ["summary.json", "backbone.csv"].contains(&file.as_str()) => folder,
        (Some(folder), Some(file)) => format!("{folder}/{file}"),
        (None, Some(file)) => file,
        _ => path.display().to_string(),
    }
}

impl Backbone {
    /// Sorts the points by amplitude; `what` names the backbone in messages.
    ///
    /// # Errors
    /// [`Error::Comparison`] for fewer than two different amplitudes, and for amplitudes and frequencies that are not
    /// positive and finite.
    pub fn try_new(what: &str, mut points: Vec<Point>) -> Result<Self, Error> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let refuse = |reason: String| {
            Err(Error::Comparison {
                what: format!("{what}: {reason}"),
            })
        };
        if let Some(k) = points
            .iter()
            .position(|p| !(positive(p.amplitude) && positive(p.frequency_hz)))
        {
            let Point {
                amplitude,
                frequency_hz,
                ..
            } = points[k];
            return refuse(format!(
                "point {} has the amplitude {amplitude} and the frequency {frequency_hz} Hz; both must be positive and finite",
                k + 1
            ));
        }
        for point in &mut points {
            point.damping_ratio = point.damping_ratio.filter(|zeta| positive(*zeta));
        }
        points.sort_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
        points.dedup_by_key(|p| p.amplitude);
        if points.len() < 2 {
            return refuse(format!(
                "a backbone to compare needs two different amplitudes, and there are {}",
                points.len()
            ));
        }
        Ok(Self { points })
    }

    /// The points.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Smallest and largest amplitude.
    pub fn range(&self) -> [f64; 2] {
        [self.points[0].amplitude, self.points[self.points.len() - 1].amplitude]
    }

    /// The same for a quantity that is differentiated `derivatives` times more with respect to time (fewer: negative):
    /// amplitudes times the power of the circular frequency at the same point.
    ///
    /// # Errors
    /// [`Error::Comparison`].
    pub fn differentiated(&self, what: &str, derivatives: i32) -> Result<Self, Error> {
        let point = |p: &Point| Point {
            amplitude: p.amplitude * (TAU * p.frequency_hz).powi(derivatives),
            ..*p
        };
        Self::try_new(what, self.points.iter().map(point).collect())
    }

    /// Frequency (Hz) and damping ratio at an amplitude within the range.
    pub fn at(&self, amplitude: f64) -> Option<(f64, Option<f64>)> {
        self.at_or_beyond(amplitude, 1.0)
    }

    /// The same, and by the line through the outermost two points also beyond the range, by this factor at most.
    pub(crate) fn at_or_beyond(&self, amplitude: f64, factor: f64) -> Option<(f64, Option<f64>)> {
        let [first, last] = self.range();
        if !(first / factor..=last * factor).contains(&amplitude) {
            return None;
        }
        let above = self.points.partition_point(|p| p.amplitude < amplitude);
        let above = above.clamp(1, self.points.len() - 1);
        let (a, b) = (self.points[above - 1], self.points[above]);
        let part = (amplitude / a.amplitude).ln() / (b.amplitude / a.amplitude).ln();
        let between = |x: f64, y: f64| x + part * (y - x);
        let damping = match (a.damping_ratio, b.damping_ratio) {
            (Some(x), Some(y)) => Some(between(x.ln(), y.ln()).exp()),
            _ => None,
        };
        Some((between(a.frequency_hz, b.frequency_hz), damping))
    }

    /// Shares of the amplitudes common to all three (equally spaced in their logarithm) at which frequency and damping ratio
    /// lie between those of `a` and `b`; none if they share no range. A missing damping ratio lies nowhere.
    pub fn within(&self, a: &Self, b: &Self) -> Option<[f64; 2]> {
        let ranges = [self, a, b].map(Self::range);
        let low = ranges.iter().fold(0.0, |low: f64, r| low.max(r[0]));
        let high = ranges.iter().fold(f64::INFINITY, |high, r| high.min(r[1]));
        if !(low < high) {
            return None;
        }
        let mut inside = [0, 0];
        for amplitude in spaced(low, high) {
            let (Some(x), Some(a), Some(b)) = (self.at(amplitude), a.at(amplitude), b.at(amplitude)) else {
                continue;
            };
            let between = |x: f64, a: f64, b: f64| usize::from(a.min(b) <= x && x <= a.max(b));
            inside[0] += between(x.0, a.0, b.0);
            if let (Some(x), Some(a), Some(b)) = (x.1, a.1, b.1) {
                inside[1] += between(x, a, b);
            }
        }
        Some(inside.map(|count| count as f64 / POINTS as f64))
    }

    /// Smallest and largest amplitude that both backbones cover.
    fn shared_range(&self, other: &Self) -> Option<[f64; 2]> {
        let ([a, b], [c, d]) = (self.range(), other.range());
        let (low, high) = (a.max(c), b.min(d));
        (low < high).then_some([low, high])
    }

    /// This backbone minus `reference` at [`POINTS`] amplitudes; none if they share no range.
    pub fn differences(&self, reference: &Self) -> Option<Vec<PointDifference>> {
        let [low, high] = self.shared_range(reference)?;
        let difference = |amplitude| {
            let ((f, zeta), (f0, zeta0)) = (self.at(amplitude)?, reference.at(amplitude)?);
            Some(PointDifference {
                amplitude,
                frequency_hz: f - f0,
                frequency_percent: 100.0 * (f / f0 - 1.0),
                damping_ln: zeta.zip(zeta0).map(|(zeta, zeta0)| (zeta / zeta0).ln()),
            })
        };
        Some(spaced(low, high).filter_map(difference).collect())
    }

    /// The misfit of this backbone to `reference`; none if they share no range.
    pub fn misfit(&self, reference: &Self) -> Option<Misfit> {
        let all = self.differences(reference)?;
        let of = |value: fn(&PointDifference) -> f64| Difference::of(&all.iter().map(value).collect::<Vec<_>>());
        let logarithms: Vec<f64> = all.iter().filter_map(|d| d.damping_ln).collect();
        Some(Misfit {
            amplitudes: self.shared_range(reference)?,
            frequency_hz: of(|d| d.frequency_hz)?,
            frequency_percent: of(|d| d.frequency_percent)?,
            damping_ln: Difference::of(&logarithms),
            damping_points: logarithms.len(),
        })
    }
}

/// Amplitudes equally spaced in their logarithm, both ends included.
fn spaced(low: f64, high: f64) -> impl Iterator<Item = f64> {
    // Powers may miss the ends by a rounding.
    (0..POINTS).map(move |k| (low * (high / low).powf(k as f64 / (POINTS - 1) as f64)).clamp(low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn backbone(amplitudes: impl Iterator<Item = f64>, f: impl Fn(f64) -> f64, zeta: impl Fn(f64) -> f64) -> Backbone {
        let point = |amplitude| Point {
            amplitude,
            frequency_hz: f(amplitude),
            damping_ratio: Some(zeta(amplitude)),
        };
        Backbone::try_new("test", amplitudes.map(point).collect()).unwrap()
    }

    fn decades(from: i32, to: i32) -> impl Iterator<Item = f64> {
        (4 * from..=4 * to).map(|k| 10_f64.powf(f64::from(k) / 4.0))
    }

    #[test]
    fn constant_differences_are_found_over_the_common_range() {
        // Linear in ln A and in ln zeta: interpolation is exact, whatever the points.
        let theory = backbone(decades(-6, -3), |a| 170.0 - a.ln(), |a| 3.0 * a);
        let measured = backbone(decades(-5, -2).map(|a| 1.1 * a), |a| 169.5 - a.ln(), |a| 2.0 * a);
        let found = theory.misfit(&measured).unwrap();
        assert!((found.amplitudes[0] / 1.1e-5 - 1.0).abs() < 1e-12 && found.amplitudes[1] == 1e-3);
        let Difference { mean, rms, largest } = found.frequency_hz;
        for value in [mean, rms, largest] {
            assert!((value - 0.5).abs() < 1e-10);
        }
        let damping = found.damping_ln.unwrap();
        assert!((damping.mean - 1.5_f64.ln()).abs() < 1e-10 && (damping.rms - damping.largest).abs() < 1e-10);
        assert_eq!(found.damping_points, POINTS);
        let reversed = measured.misfit(&theory).unwrap();
        assert!((reversed.frequency_hz.mean + 0.5).abs() < 1e-10);
    }

    #[test]
    fn what_has_no_damping_or_no_overlap_is_not_invented() {
        let theory = backbone(decades(-6, -3), |_| 170.0, |a| if a < 1e-5 { -1e-9 } else { 1e-3 });
        let measured = backbone(decades(-6, -3), |_| 170.0, |_| 1e-3);
        let found = theory.misfit(&measured).unwrap();
        assert!(found.damping_points > POINTS / 2 && found.damping_points < 2 * POINTS / 3 + 2);
        assert!(found.damping_ln.unwrap().rms < 1e-12);
        let elsewhere = backbone(decades(-2, -1), |_| 170.0, |_| 1e-3);
        assert!(theory.misfit(&elsewhere).is_none());
        let point = theory.points()[0];
        assert!(Backbone::try_new("one", vec![point]).is_err());
        let wrong = Point {
            frequency_hz: f64::NAN,
            ..point
        };
        assert!(
            Backbone::try_new("bad", vec![point, wrong])
                .unwrap_err()
                .to_string()
                .contains("point 2")
        );
    }

    #[test]
    fn differentiating_twice_and_back_is_the_same() {
        let theory = backbone(decades(-6, -3), |a| 170.0 - a.ln(), |_| 1e-3);
        let back = theory.differentiated("a", 2).unwrap().differentiated("b", -2).unwrap();
        for (a, b) in theory.points().iter().zip(back.points()) {
            assert!((a.amplitude / b.amplitude - 1.0).abs() < 1e-12);
        }
        let first = theory.differentiated("a", 1).unwrap().points()[0];
        assert!((first.amplitude / (TAU * first.frequency_hz * 1e-6) - 1.0).abs() < 1e-12);
    }
}
