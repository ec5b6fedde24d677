//! How a surface changed, and whether the changes go with a field of a run.

use std::fmt;

use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use statrs::function::beta::beta_reg;
use statrs::function::erf::erfc;

use crate::characterise::{Characterisation, ElementSurface};
use crate::error::{SurfaceError, positive};
use crate::partition::ElementOutlines;
use crate::random::{draw, mix};

/// One number per element: a change of the surface, or a field of a run such as pressure or dissipated flux.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementField {
    /// Name, for the report.
    pub name: String,
    /// Unit of the values.
    pub unit: String,
    /// Values, one per element; NaN where there is none.
    pub values: Vec<f64>,
}

/// Changes per element between two characterisations over the same elements: total roughness R_t of the pair, its
/// radii along x and y, and the number of asperities N, each after minus before.
///
/// # Errors
/// Different numbers of elements.
pub fn changes(before: &Characterisation, after: &Characterisation) -> Result<[ElementField; 4], SurfaceError> {
    if before.elements.len() != after.elements.len() {
        return Err(SurfaceError::LengthMismatch {
            field: "elements of the characterisation after",
            found: after.elements.len(),
            expected: before.elements.len(),
            remedy: "characterise both states over the same interface mesh",
        });
    }
    let change = |name: &str, unit: &str, of: &dyn Fn(&ElementSurface) -> f64| ElementField {
        name: name.to_owned(),
        unit: unit.to_owned(),
        values: before
            .elements
            .iter()
            .zip(&after.elements)
            .map(|(b, a)| of(a) - of(b))
            .collect(),
    };
    Ok([
        change("change of R_t", "m", &ElementSurface::total_roughness),
        change("change of radius x", "m", &|e| e.population.radius()[0]),
        change("change of radius y", "m", &|e| e.population.radius()[1]),
        change("change of N", "1", &|e| e.population.count()),
    ])
}

/// Spearman's rank correlation of the pairs in which both values are numbers: their number and rho, with average ranks
/// for ties. `None` with fewer than 3 pairs or where one side has only one value.
pub fn spearman(x: &[f64], y: &[f64]) -> Option<(usize, f64)> {
    let (x, y): (Vec<f64>, Vec<f64>) = x.iter().zip(y).filter(|(x, y)| !(x.is_nan() || y.is_nan())).unzip();
    let n = x.len();
    if n < 3 {
        return None;
    }
    rank_correlation(&average_ranks(&x), &average_ranks(&y)).map(|rho| (n, rho))
}

/// Correlation of ranks that have no mean; `None` where those of one side are all equal.
fn rank_correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scale = product(x, x).sqrt() * product(y, y).sqrt();
    (scale > 0.0).then(|| (product(x, y) / scale).clamp(-1.0, 1.0))
}

/// Ranks less their mean; equal values share the average of theirs.
fn average_ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut below = 0;
    for tied in order.chunk_by(|&a, &b| values[a] == values[b]) {
        for &k in tied {
            ranks[k] = below as f64 + 0.5 * (tied.len() as f64 - values.len() as f64);
        }
        below += tied.len();
    }
    ranks
}

/// Two-sided p of Spearman's `rho` of `n` pairs by `t = rho sqrt((n - 2)/(1 - rho^2))` with n - 2 degrees of freedom.
///
/// # Errors
/// Fewer than 3 pairs, or a rho outside [-1, 1].
pub fn p_student(rho: f64, n: usize) -> Result<f64, SurfaceError> {
    check(rho, n)?;
    let rest = (1.0 - rho) * (1.0 + rho);
    // The tails of Student's t as an incomplete beta function of 1 - rho^2: no difference of large numbers.
    Ok(if rest > 0.0 {
        beta_reg(0.5 * (n - 2) as f64, 0.5, rest)
    } else {
        0.0
    })
}

/// Two-sided p of Spearman's `rho` of `n` pairs without ties by algorithm AS 89 (Best and Roberts, Applied Statistics
/// 24, 1975): all permutations up to n = 9, an Edgeworth series of the sum of squared rank differences beyond.
///
/// With ties it is as good an approximation as they are few.
///
/// # Errors
/// As [`p_student`].
pub fn p_as89(rho: f64, n: usize) -> Result<f64, SurfaceError> {
    check(rho, n)?;
    // The distribution is symmetric: twice the tail of large sums of squared differences.
    let most = (n as f64).powi(3) / 3.0 - n as f64 / 3.0;
    let sum = 0.5 * (1.0 + rho.abs()) * most;
    let tail = if n <= LARGEST_EXACT {
        exact_tail(sum, n)
    } else {
        edgeworth_tail(sum, n)
    };
    Ok((2.0 * tail).clamp(0.0, 1.0))
}

const LARGEST_EXACT: usize = 9;

/// Probability that the sum of squared rank differences of n pairs is at least `sum`.
fn exact_tail(sum: f64, n: usize) -> f64 {
    let mut ranks: Vec<usize> = (0..n).collect();
    // Sums are even numbers; a rho that was rounded on the way here still means the same one.
    let least = 2 * (0.5 * sum).round() as usize;
    let reaches = |ranks: &[usize]| {
        ranks
            .iter()
            .enumerate()
            .map(|(k, r)| k.abs_diff(*r).pow(2))
            .sum::<usize>()
            >= least
    };
    // Heap's enumeration.
    let (mut reached, mut all) = (usize::from(reaches(&ranks)), 1usize);
    let (mut counters, mut k) = (vec![0; n], 1);
    while k < n {
        if counters[k] < k {
            ranks.swap(if k % 2 == 0 { 0 } else { counters[k] }, k);
            reached += usize::from(reaches(&ranks));
            all += 1;
            counters[k] += 1;
            k = 1;
        } else {
            counters[k] = 0;
            k += 1;
        }
    }
    reached as f64 / all as f64
}

/// The same by the Edgeworth series of AS 89.
fn edgeworth_tail(sum: f64, n: usize) -> f64 {
    let b = 1.0 / n as f64;
    let x = (6.0 * (sum - 1.0) * b / (1.0 / (b * b) - 1.0) - 1.0) * (1.0 / b - 1.0).sqrt();
    let y = x * x;
    let high = y * (0.0072 - 0.0831 * b + y * b * (0.0131 - 4.6e-4 * y));
    let low = -0.0758 + b * (0.1033 + 0.3932 * b) - y * b * (0.0879 + 0.0151 * b - high);
    let series = x * b * (0.2274 + b * (0.2531 + 0.1745 * b) + y * low);
    (series * (-0.5 * y).exp() + 0.5 * erfc(x / std::f64::consts::SQRT_2)).clamp(0.0, 1.0)
}

fn check(rho: f64, n: usize) -> Result<(), SurfaceError> {
    let invalid = |field, value, requirement| {
        Err(SurfaceError::InvalidValue {
            field,
            value,
            unit: "1",
            requirement,
        })
    };
    if n < 3 {
        return invalid("number of pairs", n as f64, "at least 3");
    }
    if !(-1.0..=1.0).contains(&rho) {
        return invalid("rho", rho, "in [-1, 1]");
    }
    Ok(())
}

/// Benjamini and Hochberg's adjusted p: those at most `q` are discoveries of which a share `q` is expected to be false.
pub fn benjamini_hochberg(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[b].total_cmp(&p[a]));
    let mut adjusted = vec![0.0; p.len()];
    let mut least: f64 = 1.0;
    for (k, &index) in order.iter().enumerate() {
        least = least.min(p[index] * p.len() as f64 / (p.len() - k) as f64);
        adjusted[index] = least;
    }
    adjusted
}

/// How [`correlate`] judges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrelationOptions {
    /// Level at which adjusted p are called significant.
    pub level: f64,
    /// Random shifts of the spatial test; its p is at least `1/(shifts + 1)`. 0 for no such test.
    pub shifts: usize,
    /// Seed of the shifts.
    pub seed: u64,
}

impl Default for CorrelationOptions {
    /// Level 0.05, 1999 shifts, seed 0.
    fn default() -> Self {
        Self {
            level: 0.05,
            shifts: 1999,
            seed: 0,
        }
    }
}

/// One change against one field.
#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    /// Name of the change.
    pub change: String,
    /// Name of the field.
    pub field: String,
    /// Elements in which both are known.
    pub n: usize,
    /// Spearman's rho.
    pub rho: f64,
    /// p by Student's t, as if elements were independent.
    pub p_student: f64,
    /// p by AS 89, as if elements were independent.
    pub p_as89: f64,
    /// p of AS 89 adjusted for the number of pairs correlated.
    pub p_adjusted: f64,
    /// p of the spatial test.
    pub p_spatial: Option<f64>,
    /// That, adjusted likewise.
    pub p_spatial_adjusted: Option<f64>,
}

impl Correlation {
    /// Whether it is significant at `level` after adjustment: as if elements were independent, and by the spatial test.
    pub fn significant(&self, level: f64) -> (bool, Option<bool>) {
        (self.p_adjusted <= level, self.p_spatial_adjusted.map(|p| p <= level))
    }
}

/// All changes against all fields. Displays as a table and a plain statement of what is significant.
#[derive(Debug, Clone, PartialEq)]
pub struct Evolution {
    /// Every pair, changes running fastest.
    pub correlations: Vec<Correlation>,
    /// What judged them.
    pub options: CorrelationOptions,
}

/// Correlates every change with every field over the elements.
///
/// Neighbouring elements are alike, so that n of them say less than n independent ones, and p that take them for
/// independent are too small. The spatial test keeps the likeness: its null hypothesis is that the field has the
/// same statistics everywhere in the rectangle around the interface and nothing to do with the change. The field is
/// moved by random shifts, wrapped around that rectangle, each element takes the value of the element nearest to
/// where it came from, and p is the share of shifts (the given position among them) with a rho at least as large in
/// size. Wrapping breaks the likeness along one seam each way, so that fields which vary over the whole interface
/// still get too small a p.
///
/// # Errors
/// Values that are not one per element, a change or field with fewer than 3 elements or one value in common with its
/// partner, or a level that is not positive.
pub fn correlate(
    changes: &[ElementField],
    fields: &[ElementField],
    elements: &ElementOutlines,
    options: CorrelationOptions,
) -> Result<Evolution, SurfaceError> {
    positive("level", options.level, "1")?;
    for field in changes.iter().chain(fields) {
        if field.values.len() != elements.len() {
            return Err(SurfaceError::LengthMismatch {
                field: "values of an element field",
                found: field.values.len(),
                expected: elements.len(),
                remedy: "give one value per interface element, NaN where there is none",
            });
        }
    }
    let mut correlations = Vec::with_capacity(changes.len() * fields.len());
    for field in fields {
        for change in changes {
            let (n, rho) =
                spearman(&change.values, &field.values).ok_or_else(|| SurfaceError::UndefinedCorrelation {
                    change: change.name.clone(),
                    field: field.name.clone(),
                })?;
            correlations.push(Correlation {
                change: change.name.clone(),
                field: field.name.clone(),
                n,
                rho,
                p_student: p_student(rho, n)?,
                p_as89: p_as89(rho, n)?,
                p_adjusted: 1.0,
                p_spatial: None,
                p_spatial_adjusted: None,
            });
        }
    }
    let adjusted = benjamini_hochberg(&correlations.iter().map(|c| c.p_as89).collect::<Vec<_>>());
    for (c, p) in correlations.iter_mut().zip(adjusted) {
        c.p_adjusted = p;
    }
    if options.shifts > 0 {
        let rho: Vec<f64> = correlations.iter().map(|c| c.rho).collect();
        let spatial = spatial_test(changes, fields, elements, options, &rho);
        let adjusted = benjamini_hochberg(&spatial);
        for ((c, p), q) in correlations.iter_mut().zip(spatial).zip(adjusted) {
            c.p_spatial = Some(p);
            c.p_spatial_adjusted = Some(q);
        }
    }
    Ok(Evolution { correlations, options })
}

/// p of every pair (changes running fastest) by random shifts of the fields.
fn spatial_test(
    changes: &[ElementField],
    fields: &[ElementField],
    elements: &ElementOutlines,
    options: CorrelationOptions,
    rho: &[f64],
) -> Vec<f64> {
    let (low, high) = elements.bounds();
    let middles: Vec<[f64; 2]> = (0..elements.len()).map(|e| elements.middle(e)).collect();
    // Ranks do not depend on the shift where no value is missing.
    let ranked = |values: &[f64]| (!values.iter().any(|v| v.is_nan())).then(|| average_ranks(values));
    let change_ranks: Vec<_> = changes.iter().map(|c| ranked(&c.values)).collect();
    let reached = (0..options.shifts)
        .into_par_iter()
        .map(|k| {
            let mut rng = Pcg64::seed_from_u64(mix(options.seed, k as u64, 0));
            // In parts of the rectangle: fine enough that no two elements are confused.
            let mut part = || draw(&mut rng, 1 << 32) as f64 / (1u64 << 32) as f64;
            let shift = [part(), part()];
            let source: Vec<usize> = middles
                .iter()
                .map(|p| {
                    let from = [0, 1].map(|q| {
                        let width = high[q] - low[q];
                        low[q] + ((p[q] - low[q]) / width + shift[q]).fract() * width
                    });
                    nearest(&middles, from)
                })
                .collect();
            let mut reached = Vec::with_capacity(rho.len());
            for field in fields {
                let moved: Vec<f64> = source.iter().map(|&e| field.values[e]).collect();
                let moved_ranks = ranked(&moved);
                for (change, ranks) in changes.iter().zip(&change_ranks) {
                    let size = rho[reached.len()].abs();
                    let found = match (ranks, &moved_ranks) {
                        (Some(x), Some(y)) => rank_correlation(x, y),
                        _ => spearman(&change.values, &moved).map(|(_, rho)| rho),
                    };
                    // A shift under which nothing can be said counts against the correlation. A rho that differs by
                    // rounding alone is the same.
                    reached.push(usize::from(found.is_none_or(|r| r.abs() >= size - 1e-12)));
                }
            }
            reached
        })
        .reduce(
            || vec![0; rho.len()],
            |a, b| a.iter().zip(&b).map(|(a, b)| a + b).collect(),
        );
    reached
        .into_iter()
        .map(|n| (n + 1) as f64 / (options.shifts + 1) as f64)
        .collect()
}

/// The first of the points nearest to `from`.
fn nearest(points: &[[f64; 2]], from: [f64; 2]) -> usize {
    let mut best = (f64::INFINITY, 0);
    for (k, p) in points.iter().enumerate() {
        let distance = (p[0] - from[0]).powi(2) + (p[1] - from[1]).powi(2);
        if distance < best.0 {
            best = (distance, k);
        }
    }
    best.1
}

impl fmt::Display for Evolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level = self.options.level;
        writeln!(f, "rho, p (t, AS 89, adjusted; by shifts, adjusted)")?;
        for c in &self.correlations {
            write!(f, "{} against {}: {:+.4} (n = {}), p ", c.change, c.field, c.rho, c.n)?;
            write!(f, "{:.4} {:.4} {:.4}", c.p_student, c.p_as89, c.p_adjusted)?;
            if let (Some(p), Some(q)) = (c.p_spatial, c.p_spatial_adjusted) {
                write!(f, "; {p:.4} {q:.4}")?;
            }
            writeln!(f)?;
        }
        let judged: Vec<_> = self.correlations.iter().map(|c| (c, c.significant(level))).collect();
        let names = |of: &dyn Fn((bool, Option<bool>)) -> bool| {
            let found: Vec<String> = judged
                .iter()
                .filter(|(_, s)| of(*s))
                .map(|(c, _)| format!("{} against {}", c.change, c.field))
                .collect();
            found.join(", ")
        };
        let significant = names(&|(p, spatial)| p && spatial.unwrap_or(true));
        if significant.is_empty() {
            writeln!(
                f,
                "Nothing is significant at {level} after adjustment for {} pairs.",
                judged.len()
            )?;
        } else {
            writeln!(
                f,
                "Significant at {level} after adjustment for {} pairs: {significant}.",
                judged.len()
            )?;
        }
        for (disagreement, says) in [
            (
                names(&|s| s == (true, Some(false))),
                "Significant only if neighbouring elements were independent, which the shifts deny",
            ),
            (names(&|s| s == (false, Some(true))), "Significant by the shifts only"),
        ] {
            if !disagreement.is_empty() {
                writeln!(f, "{says}: {disagreement}.")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_joins_the_permutations() {
        // The documented example of R's pspearman: S = 36 of 10 pairs, whose mirror image is 330 - 36.
        assert!((exact_tail(294.0, 10) - 0.005265377).abs() < 5e-10);
        assert!((edgeworth_tail(294.0, 10) - 0.005825634).abs() < 5e-10);
        for sum in [200.0, 220.0, 240.0, 260.0, 280.0, 300.0] {
            let (exact, series) = (exact_tail(sum, 10), edgeworth_tail(sum, 10));
            assert!((exact - series).abs() < 6e-4, "{sum}: {exact} {series}");
        }
        // All orders of three: sums of squares 0, 2, 2, 6, 6, 8.
        assert_eq!(
            [8.0, 6.0, 2.0, 0.0].map(|sum| (exact_tail(sum, 3) * 6.0).round()),
            [1.0, 3.0, 5.0, 6.0]
        );
    }

    #[test]
    fn ranks_of_ties_are_averages() {
        assert_eq!(average_ranks(&[3.0, 1.0, 3.0, 3.0, 7.0]), [0.0, -2.0, 0.0, 0.0, 2.0]);
        assert_eq!(average_ranks(&[0.0, -0.0]), [0.0, 0.0]);
    }
}
