//! Areal parameters of ISO 25178-2 on masked patches of any outline.

use std::collections::BinaryHeap;

use crate::error::{SurfaceError, not_negative, positive};

/// Height, hybrid and feature parameters of a patch, under their names in ISO 25178-2.
///
/// Heights are measured from their mean. The standard's scale-limited surface is what the caller hands over: over an
/// interface element the heights above its bilinear form, over a whole face those above its plane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ArealParameters {
    /// Points with data that were evaluated.
    pub points: usize,
    /// Arithmetic mean of the absolute heights (m).
    pub sa: f64,
    /// Root mean square height (m).
    pub sq: f64,
    /// Maximum height, highest minus lowest point (m): the total roughness R_t of the patch.
    pub sz: f64,
    /// Skewness (1); `None` on a level patch.
    pub ssk: Option<f64>,
    /// Kurtosis (1), 3 for Gaussian heights; `None` on a level patch.
    pub sku: Option<f64>,
    /// Root mean square gradient (1): `sqrt(mean (dz/dx)^2 + mean (dz/dy)^2)`, each mean over the differences of
    /// neighbouring points that both have data. Such a difference passes `sin(pi d/l) / (pi d/l)` of the slope of a
    /// wave of length `l` at step `d`. `None` where no two neighbours have data.
    pub sdq: Option<f64>,
    /// Peaks of significant hills.
    pub peaks: usize,
    /// Density of those peaks (1/m^2), over the area that the evaluated points stand for.
    pub spd: f64,
    /// Arithmetic mean curvature of those peaks (1/m): the mean of `-(z_xx + z_yy)/2` by second differences of
    /// neighbouring points. `None` without peaks.
    pub spc: Option<f64>,
}

/// Heights on a regular grid, of which a part is evaluated and the rest shows what its border leans on.
#[derive(Debug, Clone, Copy)]
pub struct ArealPatch<'a> {
    /// Heights (m), x running fastest, NaN where there is no data.
    pub heights: &'a [f64],
    /// Points along x.
    pub nx: usize,
    /// Lateral steps along x and y (m).
    pub step: [f64; 2],
    /// Height resolution (m), 0 where heights are exact.
    pub height_step: f64,
}

impl ArealPatch<'_> {
    /// Parameters of the points for which `evaluated` holds; `None` if none of them has data.
    ///
    /// Hills are pruned by Wolf's rule: while a peak rises less than `pruning * Sz` (0.05 in ISO 25178-3), or less
    /// than half a height step, above the highest saddle that leads to a higher peak, its hill joins that one. What
    /// remains is found without a segmentation: a peak stays exactly if no higher point can be reached from it along
    /// 8-neighbours without descending by that much. Points that are not evaluated carry hills on beyond the border,
    /// so that an element's peaks do not depend on its outline; peaks are counted where they are evaluated and all
    /// 8 neighbours have data.
    ///
    /// # Errors
    /// A number of heights that is no multiple of `nx`, steps that are not positive, or a negative pruning.
    pub fn parameters(
        &self,
        pruning: f64,
        evaluated: impl Fn(usize) -> bool,
    ) -> Result<Option<ArealParameters>, SurfaceError> {
        let ny = self.heights.len().checked_div(self.nx).unwrap_or(0);
        if self.nx == 0 || self.nx * ny != self.heights.len() {
            return Err(SurfaceError::LengthMismatch {
                field: "heights",
                found: self.heights.len(),
                expected: self.nx * ny,
                remedy: "give a whole number of rows of nx heights",
            });
        }
        positive("dx", self.step[0], "m")?;
        positive("dy", self.step[1], "m")?;
        not_negative("height_step", self.height_step, "m")?;
        not_negative("pruning", pruning, "1")?;
        let z = self.heights;
        let taken = |k: usize| evaluated(k) && !z[k].is_nan();

        let (mut points, mut sum, mut low, mut high) = (0usize, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        for k in (0..z.len()).filter(|&k| taken(k)) {
            points += 1;
            sum += z[k];
            low = low.min(z[k]);
            high = high.max(z[k]);
        }
        if points == 0 {
            return Ok(None);
        }
        let n = points as f64;
        let (mean, sz) = (sum / n, high - low);

        let mut moments = [0.0; 4];
        let (mut squares, mut pairs) = ([0.0; 2], [0usize; 2]);
        for k in (0..z.len()).filter(|&k| taken(k)) {
            let h = z[k] - mean;
            let square = h * h;
            moments[0] += h.abs();
            moments[1] += square;
            moments[2] += square * h;
            moments[3] += square * square;
            let next = [
                ((k + 1) % self.nx != 0).then_some(k + 1),
                (k + self.nx < z.len()).then_some(k + self.nx),
            ];
            for axis in 0..2 {
                if let Some(neighbour) = next[axis].filter(|&m| taken(m)) {
                    squares[axis] += (z[neighbour] - z[k]).powi(2);
                    pairs[axis] += 1;
                }
            }
        }
        let [absolute, square, cube, fourth] = moments.map(|m| m / n);
        let sq = square.sqrt();
        let slope =
            |axis: usize| (pairs[axis] > 0).then(|| squares[axis] / pairs[axis] as f64 / self.step[axis].powi(2));
        let sdq = match [slope(0), slope(1)] {
            [None, None] => None,
            slopes => Some(slopes.iter().flatten().sum::<f64>().sqrt()),
        };

        let descent = (pruning * sz).max(0.5 * self.height_step);
        let peaks = self.significant_peaks(descent, evaluated);
        let curvature: f64 = peaks.iter().map(|&k| self.curvature(k)).sum();
        Ok(Some(ArealParameters {
            points,
            sa: absolute,
            sq,
            sz,
            ssk: (sq > 0.0).then(|| cube / (square * sq)),
            sku: (sq > 0.0).then(|| fourth / (square * square)),
            sdq,
            peaks: peaks.len(),
            spd: peaks.len() as f64 / (n * self.step[0] * self.step[1]),
            spc: (!peaks.is_empty()).then(|| curvature / peaks.len() as f64),
        }))
    }

    /// Peaks from which no higher point is reached without descending by `descent` or more.
    fn significant_peaks(&self, descent: f64, evaluated: impl Fn(usize) -> bool) -> Vec<usize> {
        let (z, nx) = (self.heights, self.nx);
        let ny = z.len() / nx;
        // Of equal heights the later one counts as higher, so that a plateau has one peak.
        let higher = |a: usize, b: usize| z[a] > z[b] || (z[a] == z[b] && a > b);
        let mut peaks = Vec::new();
        let (mut reached_from, mut front) = (vec![usize::MAX; z.len()], BinaryHeap::new());
        for j in 1..ny.saturating_sub(1) {
            for i in 1..nx.saturating_sub(1) {
                let peak = j * nx + i;
                let around = [
                    peak - nx - 1,
                    peak - nx,
                    peak - nx + 1,
                    peak - 1,
                    peak + 1,
                    peak + nx - 1,
                    peak + nx,
                    peak + nx + 1,
                ];
                // Comparisons with NaN are false: points beside missing data are no peaks.
                if !around.iter().all(|&k| higher(peak, k)) || !evaluated(peak) {
                    continue;
                }
                let floor = z[peak] - descent;
                front.clear();
                front.push((ascending(z[peak]), peak));
                reached_from[peak] = peak;
                let mut significant = true;
                // Downhill from the peak, highest points first: no more of the hill is seen than lies above its saddle.
                'flood: while let Some((_, k)) = front.pop() {
                    let (i, j) = (k % nx, k / nx);
                    for nj in j.saturating_sub(1)..=(j + 1).min(ny - 1) {
                        for ni in i.saturating_sub(1)..=(i + 1).min(nx - 1) {
                            let m = nj * nx + ni;
                            if higher(m, peak) {
                                significant = false;
                                break 'flood;
                            }
                            if z[m] > floor && reached_from[m] != peak {
                                reached_from[m] = peak;
                                front.push((ascending(z[m]), m));
                            }
                        }
                    }
                }
                if significant {
                    peaks.push(peak);
                }
            }
        }
        peaks
    }

    /// Mean curvature (1/m) of a point with 8 neighbours, positive on hilltops.
    fn curvature(&self, k: usize) -> f64 {
        let bend = |stride: usize, step: f64| {
            (2.0 * self.heights[k] - self.heights[k - stride] - self.heights[k + stride]) / (step * step)
        };
        0.5 * (bend(1, self.step[0]) + bend(self.nx, self.step[1]))
    }
}

/// An integer that orders like the number (no NaN).
fn ascending(z: f64) -> u64 {
    let bits = z.to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    fn patch(heights: &[f64], nx: usize, step: [f64; 2]) -> ArealPatch<'_> {
        ArealPatch {
            heights,
            nx,
            step,
            height_step: 0.0,
        }
    }

    fn sampled(n: [usize; 2], step: [f64; 2], z: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        (0..n[0] * n[1])
            .map(|k| z((k % n[0]) as f64 * step[0], (k / n[0]) as f64 * step[1]))
            .collect()
    }

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found} against {expected}");
    }

    #[test]
    fn closed_forms_of_an_egg_box() {
        // z = A cos(kx) cos(ly) over whole periods: Sa = (2/pi)^2 A, Sq = A/2, Ssk = 0, Sku = (3/2)^2, one hill in half
        // a cell (two per period and period), mean curvature A (k^2 + l^2)/2 on top.
        let (amplitude, n, step) = (2e-6, [400usize, 300usize], [3e-6, 5e-6]);
        let wave = [100.0 * step[0], 60.0 * step[1]];
        let z = sampled(n, step, |x, y| {
            amplitude * (TAU * x / wave[0]).cos() * (TAU * y / wave[1]).cos()
        });
        let a = patch(&z, n[0], step).parameters(0.05, |_| true).unwrap().unwrap();
        assert_eq!(a.points, n[0] * n[1]);
        near(a.sa, (2.0 / PI).powi(2) * amplitude, 2e-3);
        near(a.sq, 0.5 * amplitude, 1e-12);
        near(a.sz, 2.0 * amplitude, 1e-12);
        assert!(a.ssk.unwrap().abs() < 1e-12);
        near(a.sku.unwrap(), 2.25, 1e-12);
        // Differences pass sin(pi/100)/(pi/100) and sin(pi/60)/(pi/60) of the slopes, second differences its square.
        let passed = [100.0, 60.0].map(|points: f64| (PI / points).sin() / (PI / points));
        let wavenumber = wave.map(|w| TAU / w);
        let gradient = [0, 1].map(|q| 0.5 * amplitude * wavenumber[q] * passed[q]);
        near(a.sdq.unwrap(), gradient[0].hypot(gradient[1]), 3e-3);
        let curvature: f64 = (0..2)
            .map(|q| 0.5 * amplitude * (wavenumber[q] * passed[q]).powi(2))
            .sum();
        near(a.spc.unwrap(), curvature, 1e-10);
        // Tops at whole (odd, odd) and (even, even) half periods; those on the border of the grid are not resolved.
        let inside = |n: usize, period: usize, odd: usize| {
            (0..)
                .map(|k| (2 * k + odd) * period / 2)
                .take_while(|&i| i + 1 < n)
                .filter(|&i| i > 0)
                .count()
        };
        let tops: usize = (0..2).map(|odd| inside(n[0], 100, odd) * inside(n[1], 60, odd)).sum();
        assert_eq!(a.peaks, tops);
        near(
            a.spd,
            tops as f64 / (n[0] as f64 * n[1] as f64 * step[0] * step[1]),
            1e-12,
        );
    }

    #[test]
    fn an_independent_program_gives_the_same_figures() {
        // Five waves and a square, sampled at 3 um by 5 um. Reference: surfalize 0.19.2 (MIT licence), which segments
        // by watershed and merges hills one by one; its peaks on the border left out, as here.
        let (n, step) = ([120, 90], [3e-6, 5e-6]);
        let waves = [
            (1.00, 61.0, 173.0, 0.3),
            (0.80, 37.0, -83.0, 1.1),
            (0.55, 23.0, 47.0, 2.0),
            (0.35, -131.0, 29.0, 4.0),
            (0.20, 17.0, 211.0, 5.0),
        ];
        let z = sampled(n, step, |x, y| {
            let (x, y) = (x * 1e6, y * 1e6);
            let sum: f64 = waves
                .iter()
                .map(|(a, p, q, phase)| a * (TAU * (x / p + y / q) + phase).sin())
                .sum();
            (sum + 0.15 * sum * sum) * 1e-6
        });
        let found = |pruning: f64| patch(&z, n[0], step).parameters(pruning, |_| true).unwrap().unwrap();
        let a = found(0.05);
        near(a.sa, 0.8415482201141926e-6, 1e-11);
        near(a.sq, 1.0397745952368578e-6, 1e-11);
        near(a.sz, 5.543602051971775e-6, 1e-11);
        near(a.ssk.unwrap(), 0.6640128194443413, 1e-10);
        near(a.sku.unwrap(), 3.0067834876229615, 1e-10);
        near(a.sdq.unwrap(), 0.19473436428433008, 1e-11);
        for (pruning, peaks, spc) in [
            (0.0, 170, 0.05750575140771084e6),
            (0.01, 160, 0.059114764831342835e6),
            (0.05, 136, 0.06289166863163873e6),
            (0.2, 68, 0.07733096356308597e6),
        ] {
            let a = found(pruning);
            assert_eq!(a.peaks, peaks, "pruning {pruning}");
            near(a.spc.unwrap(), spc, 1e-9);
        }
    }

    #[test]
    fn hills_of_a_profile_are_pruned_by_their_rise_above_the_saddle() {
        // Ridge with tops 10, 9 and 6 and saddles 7 and 5: rises 10, 2 and 1.
        let ridge = [0.0, 10.0, 7.0, 9.0, 5.0, 6.0, 0.0];
        let z: Vec<f64> = [vec![0.0; 7], ridge.to_vec(), vec![0.0; 7]].concat();
        let peaks = |descent: f64| {
            patch(&z, 7, [1.0; 2])
                .parameters(descent / 10.0, |_| true)
                .unwrap()
                .unwrap()
                .peaks
        };
        assert_eq!(
            (peaks(0.9), peaks(1.0), peaks(1.1), peaks(2.0), peaks(2.1)),
            (3, 3, 2, 2, 1)
        );
        // A stated height step of 2.2 does what a pruning of 1.1 does.
        let stepped = ArealPatch {
            height_step: 2.2,
            ..patch(&z, 7, [1.0; 2])
        };
        assert_eq!(stepped.parameters(0.0, |_| true).unwrap().unwrap().peaks, 2);
        // Evaluated in part: the border leans on the rest.
        let right = patch(&z, 7, [1.0; 2]).parameters(0.0, |k| k % 7 > 2).unwrap().unwrap();
        assert_eq!((right.points, right.peaks, right.sz), (12, 2, 9.0));
    }

    #[test]
    fn missing_points_plateaus_and_level_patches() {
        let mut z = sampled([40, 30], [1.0, 1.0], |x, y| (0.7 * x).sin() + (0.9 * y).cos());
        let whole = patch(&z, 40, [1.0; 2]).parameters(0.0, |_| true).unwrap().unwrap();
        let summit = (1..29)
            .flat_map(|j| (1..39).map(move |i| j * 40 + i))
            .find(|&k| [k - 1, k + 1, k - 40, k + 40].iter().all(|&m| z[m] < z[k]))
            .unwrap();
        z[summit + 1] = f64::NAN;
        let masked = patch(&z, 40, [1.0; 2]).parameters(0.0, |_| true).unwrap().unwrap();
        assert_eq!((masked.points, masked.peaks), (whole.points - 1, whole.peaks - 1));
        assert!(masked.sdq.unwrap().is_finite());

        let plateau = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(
            patch(&plateau, 4, [1.0; 2])
                .parameters(0.05, |_| true)
                .unwrap()
                .unwrap()
                .peaks,
            1
        );
        let level = patch(&[3.0; 12], 4, [1.0; 2])
            .parameters(0.05, |_| true)
            .unwrap()
            .unwrap();
        assert_eq!((level.sq, level.ssk, level.sku, level.spc), (0.0, None, None, None));
        assert_eq!(level.sdq, Some(0.0));
        assert_eq!(patch(&[f64::NAN; 12], 4, [1.0; 2]).parameters(0.05, |_| true), Ok(None));
        assert!(patch(&[0.0; 11], 4, [1.0; 2]).parameters(0.05, |_| true).is_err());
        assert!(patch(&[0.0; 12], 4, [1.0; 2]).parameters(-0.1, |_| true).is_err());
        assert!(patch(&[0.0; 12], 4, [1.0, 0.0]).parameters(0.1, |_| true).is_err());
    }

    #[test]
    fn integers_order_like_their_numbers() {
        let sorted = [f64::NEG_INFINITY, -1e9, -1.0, -1e-300, 0.0, 1e-300, 2.0, f64::INFINITY];
        assert!(sorted.windows(2).all(|w| ascending(w[0]) < ascending(w[1])));
    }
}
