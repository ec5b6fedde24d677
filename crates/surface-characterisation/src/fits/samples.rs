//! The samples of a curve, and what linear least squares make of them.

use crate::error::{SurfaceError, positive};

/// The logarithms of a curve: `x = ln(u/u_ref)`, `y = ln t - offset`.
pub(super) struct Samples {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    /// Mean of ln t, taken off so that the unit of t does not touch any tolerance.
    pub(super) offset: f64,
    pub(super) mean_x: f64,
    pub(super) range: [f64; 2],
    pub(super) zero_samples: usize,
}

impl Samples {
    const NEEDED: usize = 8;

    pub(super) fn try_new(
        curve: &'static str,
        unit: &'static str,
        interference: &[f64],
        values: &[f64],
        u_ref: f64,
    ) -> Result<Self, SurfaceError> {
        positive("u_ref", u_ref, "m")?;
        if interference.len() != values.len() {
            return Err(SurfaceError::LengthMismatch {
                field: curve,
                found: values.len(),
                expected: interference.len(),
                remedy: "give one value per interference",
            });
        }
        let mut samples = Self {
            x: vec![],
            y: vec![],
            offset: 0.0,
            mean_x: 0.0,
            range: [f64::INFINITY, 0.0],
            zero_samples: 0,
        };
        for (index, (&u, &t)) in interference.iter().zip(values).enumerate() {
            let invalid = |field, value, unit, requirement| {
                Err(SurfaceError::InvalidSample {
                    field,
                    index,
                    value,
                    unit,
                    requirement,
                })
            };
            if !(u.is_finite() && u > 0.0) {
                return invalid("interference", u, "m", "finite and greater than zero");
            }
            if !(t.is_finite() && t >= 0.0) {
                return invalid(curve, t, unit, "finite and not negative");
            }
            if t == 0.0 {
                samples.zero_samples += 1;
                continue;
            }
            samples.x.push((u / u_ref).ln());
            samples.y.push(t.ln());
            samples.range = [samples.range[0].min(u), samples.range[1].max(u)];
        }
        let mut distinct = samples.x.clone();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        if distinct.len() < Self::NEEDED {
            return Err(SurfaceError::TooFewSamples {
                curve,
                found: distinct.len(),
                needed: Self::NEEDED,
            });
        }
        let n = samples.x.len() as f64;
        samples.mean_x = samples.x.iter().sum::<f64>() / n;
        samples.offset = samples.y.iter().sum::<f64>() / n;
        for y in &mut samples.y {
            *y -= samples.offset;
        }
        Ok(samples)
    }

    pub(super) fn bounds(&self) -> [f64; 2] {
        self.x
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], &x| [l.min(x), h.max(x)])
    }

    pub(super) fn rss(&self, value: impl Fn(f64) -> f64) -> f64 {
        self.x.iter().zip(&self.y).map(|(&x, y)| (value(x) - y).powi(2)).sum()
    }

    /// Best `[a, b, c]` and residual of `a + b x + c g(x)` with b within bounds; `None` if the columns are dependent.
    pub(super) fn project(&self, g: impl Fn(f64) -> f64, [b_low, b_high]: [f64; 2]) -> Option<([f64; 3], f64)> {
        let column: Vec<f64> = self.x.iter().map(|&x| g(x)).collect();
        let mean_g = column.iter().sum::<f64>() / column.len() as f64;
        // y has zero mean: centred columns leave a 2 x 2 system.
        let (mut xx, mut xg, mut gg, mut xy, mut gy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for ((&x, &g), &y) in self.x.iter().zip(&column).zip(&self.y) {
            let (x, g) = (x - self.mean_x, g - mean_g);
            xx += x * x;
            xg += x * g;
            gg += g * g;
            xy += x * y;
            gy += g * y;
        }
        let determinant = xx * gg - xg * xg;
        if determinant.is_nan() || gg <= 1e-12 * column.len() as f64 || determinant <= 1e-8 * xx * gg {
            return None;
        }
        // Strictly inside, so that the polish can move away from the bound.
        let margin = 1e-3 * (b_high - b_low);
        let b = ((gg * xy - xg * gy) / determinant).clamp(b_low + margin, b_high - margin);
        let c = (gy - b * xg) / gg;
        let a = -b * self.mean_x - c * mean_g;
        let rss = self
            .x
            .iter()
            .zip(&column)
            .zip(&self.y)
            .map(|((x, g), y)| (a + b * x + c * g - y).powi(2))
            .sum();
        Some(([a, b, c], rss))
    }

    /// Best `[a, b]` and residual of `a + b h(x)` with b at least twice `least`; `None` if h is constant over the samples.
    pub(super) fn project_step(&self, h: impl Fn(f64) -> f64, least: f64) -> Option<([f64; 2], f64)> {
        let column: Vec<f64> = self.x.iter().map(|&x| h(x)).collect();
        let mean = column.iter().sum::<f64>() / column.len() as f64;
        let (mut hh, mut hy) = (0.0, 0.0);
        for (&h, &y) in column.iter().zip(&self.y) {
            hh += (h - mean) * (h - mean);
            hy += (h - mean) * y;
        }
        if hh.is_nan() || hh <= 1e-12 * column.len() as f64 {
            return None;
        }
        let b = (hy / hh).max(2.0 * least);
        let a = -b * mean;
        let rss = column.iter().zip(&self.y).map(|(h, y)| (a + b * h - y).powi(2)).sum();
        Some(([a, b], rss))
    }

    /// Least-squares `[a, b]` of a power law with b within bounds.
    pub(super) fn power_law(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let (mut xx, mut xy) = (0.0, 0.0);
        for (&x, &y) in self.x.iter().zip(&self.y) {
            xx += (x - self.mean_x) * (x - self.mean_x);
            xy += (x - self.mean_x) * y;
        }
        let b = (xy / xx).clamp(low, high);
        [-b * self.mean_x, b]
    }
}
