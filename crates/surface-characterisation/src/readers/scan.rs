//! From the grid that stands in a file to a height map: axes turned, resolution measured, plausibility checked.

use super::format::Format;
use super::options::{FirstRow, Options};
use super::units::Declaration;
use crate::error::FileError;
use crate::topography::HeightMap;

/// A height map and what its file says about it. Numbers of points, missing points and lateral steps are those of the
/// map.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Heights (m).
    pub map: HeightMap,
    /// Format of the file.
    pub format: Format,
    /// Unit of positions in the file.
    pub lateral_unit: Declaration,
    /// Unit of heights in the file.
    pub height_unit: Declaration,
    /// Difference of heights (m) that the file's numbers resolve, as stated: the step of heights stored as integers, or
    /// SDF's `Zresolution` if it is coarser.
    pub stated_step: Option<f64>,
    /// Smallest difference (m) between two heights that differ by more than rounding. With few different heights this is the height
    /// step of the instrument, which [`HeightMap::with_height_step`] asks for.
    pub smallest_step: Option<f64>,
    /// Number of different heights.
    pub distinct_heights: usize,
    /// What was ignored or settled by convention, one sentence each.
    pub notes: Vec<String>,
}

/// A grid as it stands in a file, in metres.
pub(super) struct RawGrid {
    pub(super) format: Format,
    pub(super) size: [usize; 2],
    /// Negative where the axis runs backwards.
    pub(super) step: [f64; 2],
    pub(super) origin: [f64; 2],
    /// x running fastest, NaN where missing.
    pub(super) heights: Vec<f64>,
    pub(super) lateral_unit: Declaration,
    pub(super) height_unit: Declaration,
    pub(super) stated_step: Option<f64>,
    /// Whether the format leaves open where its first line lies.
    pub(super) rows_open: bool,
    pub(super) notes: Vec<String>,
}

impl RawGrid {
    /// Turns the axes, makes the map, checks it.
    pub(super) fn finish(mut self, file: &str, options: &Options) -> Result<Scan, FileError> {
        let text = matches!(self.format, Format::Xyz | Format::Grid);
        let stepless = matches!(self.format, Format::Grid | Format::Npy | Format::Npz);
        let unused = [
            ("lateral_step", options.lateral_step.is_some() && !stepless),
            ("first_row", options.first_row.is_some() && !self.rows_open),
            ("layer", options.layer.is_some() && self.format != Format::X3p),
            ("array", options.array.is_some() && self.format != Format::Npz),
            ("header_lines", options.header_lines.is_some() && !text),
        ];
        if let Some((option, _)) = unused.into_iter().find(|(_, unused)| *unused) {
            return Err(FileError::UnusedOption {
                file: file.into(),
                option,
                format: self.format,
            });
        }
        let [nx, ny] = self.size;
        if self.step[0] < 0.0 {
            self.heights.chunks_mut(nx.max(1)).for_each(<[f64]>::reverse);
        }
        let turned = options.first_row == Some(FirstRow::HighestY);
        if (self.step[1] < 0.0) != turned {
            for j in 0..ny / 2 {
                let (low, high) = self.heights.split_at_mut((ny - 1 - j) * nx);
                low[j * nx..(j + 1) * nx].swap_with_slice(&mut high[..nx]);
            }
        }
        for q in 0..2 {
            if self.step[q] < 0.0 {
                self.origin[q] += self.size[q].saturating_sub(1) as f64 * self.step[q];
                self.step[q] = -self.step[q];
                self.notes.push(format!(
                    "{} runs backwards in the file and was turned over",
                    ["x", "y"][q]
                ));
            }
        }
        if self.rows_open && options.first_row.is_none() {
            self.notes
                .push("the format does not say where its first line lies: taken as the lowest y".into());
        }
        let (smallest_step, distinct_heights) = resolution(&self.heights);
        let map =
            HeightMap::try_new(nx, ny, self.step, self.origin, self.heights).map_err(|source| FileError::Map {
                file: file.into(),
                source,
            })?;
        let scan = Scan {
            map,
            format: self.format,
            lateral_unit: self.lateral_unit,
            height_unit: self.height_unit,
            stated_step: self.stated_step,
            smallest_step,
            distinct_heights,
            notes: self.notes,
        };
        if !options.accept_implausible {
            scan.check_plausibility(file)?;
        }
        Ok(scan)
    }
}

/// Smallest difference between heights that differ by more than rounding, and number of such heights.
fn resolution(heights: &[f64]) -> (Option<f64>, usize) {
    let mut sorted: Vec<f64> = heights.iter().copied().filter(|z| z.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(low), Some(high)) = (sorted.first(), sorted.last()) else {
        return (None, 0);
    };
    let rounding = 8.0 * f64::EPSILON * low.abs().max(high.abs());
    let steps = sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|step| *step > rounding);
    let (count, smallest) = steps.fold((0, f64::INFINITY), |(n, smallest), step| (n + 1, smallest.min(step)));
    ((count > 0).then_some(smallest), count + 1)
}

impl Scan {
    fn check_plausibility(&self, file: &str) -> Result<(), FileError> {
        let map = &self.map;
        let (nx, ny, step) = (map.nx(), map.ny(), map.step());
        let extent = ((nx - 1) as f64 * step[0]).max((ny - 1) as f64 * step[1]);
        let (mut low, mut high, mut slopes, mut pairs) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0usize);
        for j in 0..ny {
            for i in 0..nx {
                let z = map.value(j * nx + i);
                if z.is_nan() {
                    continue;
                }
                (low, high) = (low.min(z), high.max(z));
                let before = [(i > 0).then(|| j * nx + i - 1), (j > 0).then(|| (j - 1) * nx + i)];
                for (q, index) in before.into_iter().enumerate() {
                    let slope = index.map(|index| (z - map.value(index)).abs() / step[q]);
                    if let Some(slope) = slope.filter(|slope| !slope.is_nan()) {
                        slopes += slope;
                        pairs += 1;
                    }
                }
            }
        }
        let range = (high - low).max(0.0);
        let checks = [
            (
                "lateral extent",
                extent,
                " m",
                1e-6,
                1.0,
                "microscopes see no less and profilometers travel no farther",
            ),
            (
                "range of heights over lateral extent",
                range / extent,
                "",
                if range == 0.0 { 0.0 } else { 1e-9 },
                1.0,
                "a scan from above follows no more and no instrument resolves less",
            ),
            (
                "mean slope between neighbours",
                slopes / pairs.max(1) as f64,
                "",
                0.0,
                10.0,
                "no probe or lens follows steeper flanks all over",
            ),
        ];
        for (quantity, value, unit, low, high, reason) in checks {
            if !(value >= low && value <= high) {
                return Err(FileError::Implausible {
                    file: file.into(),
                    quantity,
                    value,
                    unit,
                    low,
                    high,
                    reason,
                    lateral: self.lateral_unit,
                    height: self.height_unit,
                });
            }
        }
        Ok(())
    }
}
