//! Correlation of a rough face, its spectral moments, and what Nayak's theory makes of them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::error::{FinishError, positive};

/// How the heights of a face are correlated.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Spectrum {
    /// Autocorrelation `exp(-(s/l_1)^2 - (t/l_2)^2)` at lags `s` along the lay and `t` across it.
    Gaussian {
        /// Correlation lengths along and across the lay (m): where the autocorrelation is 1/e.
        lengths: [f64; 2],
        /// Direction of the lay from x towards y (rad).
        lay: f64,
    },
    /// Isotropic power spectral density: constant up to the roll-off, `q^(-2 - 2 H)` from there to the cut-off, nothing beyond
    /// (Persson et al., J. Phys.: Condens. Matter 17 R1, 2005, doi 10.1088/0953-8984/17/1/R01).
    PowerLaw {
        /// Hurst exponent H.
        hurst: f64,
        /// Roll-off wavelength (m).
        rolloff: f64,
        /// Cut-off wavelength (m).
        cutoff: f64,
    },
}

/// Profile elements of a Gaussian correlation are this many correlation lengths wide: mean distance of zero crossings of
/// one sense, `2 pi sqrt(m0/m2)` (Rice 1945), with `m2 = 2 m0/l^2`.
pub const RSM_PER_LENGTH: f64 = 4.442_882_938_158_366;

/// Nodes of the integrals over a power law: along its plateau, along its flank, and around a quarter of the circle.
const PLATEAU: usize = 48;
const FLANK: usize = 192;
const QUARTER: usize = 16;

impl Spectrum {
    /// The same, if it is one.
    ///
    /// # Errors
    /// Lengths that are not positive, a Hurst exponent outside (0, 1), a cut-off that is not below the roll-off.
    pub fn validated(self) -> Result<Self, FinishError> {
        match self {
            Self::Gaussian { lengths, lay } => {
                for length in lengths {
                    positive("correlation_length", length, "m")?;
                }
                if !lay.is_finite() {
                    return Err(FinishError::Value {
                        field: "lay",
                        value: lay.to_degrees(),
                        unit: "degrees",
                        requirement: "finite",
                    });
                }
            }
            Self::PowerLaw { hurst, rolloff, cutoff } => {
                if !(hurst > 0.0 && hurst < 1.0) {
                    return Err(FinishError::Value {
                        field: "psd.hurst",
                        value: hurst,
                        unit: "",
                        requirement: "above 0 and below 1",
                    });
                }
                positive("psd.rolloff", rolloff, "m")?;
                positive("psd.cutoff", cutoff, "m")?;
                if cutoff >= rolloff {
                    return Err(FinishError::Order {
                        smaller: "psd.cutoff",
                        first: cutoff,
                        larger: "psd.rolloff",
                        second: rolloff,
                        reason: "both are wavelengths, and the cut-off is the shortest one",
                    });
                }
            }
        }
        Ok(self)
    }

    /// Correlation at a lag along x and y (m).
    pub fn correlation(&self, lag: [f64; 2]) -> f64 {
        match *self {
            Self::Gaussian { lengths, lay } => {
                let [xx, xy, yy] = quadratic(lengths, lay);
                (-(xx * lag[0] * lag[0] + 2.0 * xy * lag[0] * lag[1] + yy * lag[1] * lag[1])).exp()
            }
            Self::PowerLaw { .. } => {
                let distance = lag[0].hypot(lag[1]);
                let (mut sum, mut all) = (0.0, 0.0);
                for (q, weight) in self.shells() {
                    let around = (0..QUARTER).map(|k| {
                        let angle = (k as f64 + 0.5) * FRAC_PI_2 / QUARTER as f64;
                        (q * distance * angle.cos()).cos()
                    });
                    sum += weight * around.sum::<f64>() / QUARTER as f64;
                    all += weight;
                }
                sum / all
            }
        }
    }

    /// Wave numbers (1/m) and variances of the shells of a power law; none of a Gaussian correlation.
    fn shells(&self) -> impl Iterator<Item = (f64, f64)> {
        let (hurst, rolloff, cutoff) = match *self {
            Self::PowerLaw { hurst, rolloff, cutoff } => (hurst, TAU / rolloff, TAU / cutoff),
            Self::Gaussian { .. } => (0.5, 0.0, 0.0),
        };
        let plateau = (0..PLATEAU).map(move |k| {
            let part = (k as f64 + 0.5) / PLATEAU as f64;
            (rolloff * part, rolloff * rolloff * part / PLATEAU as f64)
        });
        let width = (cutoff / rolloff).ln() / FLANK as f64;
        let flank = (0..FLANK).map(move |k| {
            let q = rolloff * ((k as f64 + 0.5) * width).exp();
            (q, q * q * (q / rolloff).powf(-2.0 - 2.0 * hurst) * width)
        });
        plateau.chain(flank)
    }

    /// Density of a power law at a wave number (1/m), with the plateau as unit; zero for a Gaussian correlation.
    pub(super) fn density(&self, q: f64) -> f64 {
        match *self {
            Self::PowerLaw { hurst, rolloff, cutoff } => {
                let (first, last) = (TAU / rolloff, TAU / cutoff);
                match q {
                    q if q <= first => 1.0,
                    q if q <= last => (q / first).powf(-2.0 - 2.0 * hurst),
                    _ => 0.0,
                }
            }
            Self::Gaussian { .. } => 0.0,
        }
    }

    /// Correlation lengths of profiles along x and y (m); of a power law its cut-off wavelength, the finest detail.
    pub fn profile_lengths(&self) -> [f64; 2] {
        match *self {
            Self::Gaussian { lengths, lay } => {
                let [xx, _, yy] = quadratic(lengths, lay);
                [xx, yy].map(|b| 1.0 / b.sqrt())
            }
            Self::PowerLaw { cutoff, .. } => [cutoff; 2],
        }
    }

    /// Half the extent along x and y (m) of the ellipse on which the correlation is 1/e; a power law has lost most of its
    /// correlation at a fifth of its roll-off wavelength.
    pub(super) fn extent(&self) -> [f64; 2] {
        match *self {
            Self::Gaussian { lengths, lay } => {
                let (sin, cos) = lay.sin_cos();
                [
                    (lengths[0] * cos).hypot(lengths[1] * sin),
                    (lengths[0] * sin).hypot(lengths[1] * cos),
                ]
            }
            Self::PowerLaw { rolloff, .. } => [rolloff / 5.0; 2],
        }
    }

    /// Spectral moments of heights of standard deviation `rms` (m).
    pub fn moments(&self, rms: f64) -> SpectralMoments {
        let m0 = rms * rms;
        match *self {
            Self::Gaussian { lengths, lay } => {
                let [xx, xy, yy] = quadratic(lengths, lay);
                SpectralMoments {
                    m0,
                    m2: [xx, xy, yy].map(|b| 2.0 * m0 * b),
                    m4: [
                        12.0 * xx * xx,
                        12.0 * xx * xy,
                        4.0 * (xx * yy + 2.0 * xy * xy),
                        12.0 * xy * yy,
                        12.0 * yy * yy,
                    ]
                    .map(|b| m0 * b),
                }
            }
            Self::PowerLaw { .. } => {
                let [all, second, fourth] = self
                    .shells()
                    .fold([0.0; 3], |[a, b, c], (q, w)| [a + w, b + w * q * q, c + w * q.powi(4)]);
                let (second, fourth) = (m0 * second / all, m0 * fourth / all);
                SpectralMoments {
                    m0,
                    m2: [0.5 * second, 0.0, 0.5 * second],
                    m4: [3.0, 0.0, 1.0, 0.0, 3.0].map(|part| part * fourth / 8.0),
                }
            }
        }
    }
}

/// `exp(-(xx s^2 + 2 xy s t + yy t^2))` of lengths along and across a lay.
fn quadratic(lengths: [f64; 2], lay: f64) -> [f64; 3] {
    let (sin, cos) = lay.sin_cos();
    let [along, across] = lengths.map(|l| 1.0 / (l * l));
    [
        along * cos * cos + across * sin * sin,
        (along - across) * sin * cos,
        along * sin * sin + across * cos * cos,
    ]
}

/// Moments of the power spectral density: variances and covariances of height, slope and curvature. Those of the sum of two
/// independent faces are the sums.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SpectralMoments {
    /// Variance of the heights (m^2).
    pub m0: f64,
    /// Variances of the slopes: xx, xy, yy (-).
    pub m2: [f64; 3],
    /// Variances of the curvatures: xxxx, xxxy, xxyy, xyyy, yyyy (1/m^2).
    pub m4: [f64; 5],
}

impl std::ops::Add for SpectralMoments {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            m0: self.m0 + other.m0,
            m2: std::array::from_fn(|k| self.m2[k] + other.m2[k]),
            m4: std::array::from_fn(|k| self.m4[k] + other.m4[k]),
        }
    }
}

impl SpectralMoments {
    /// `m2` and `m4` of the profile in a direction from x towards y (rad).
    pub fn profile(&self, angle: f64) -> [f64; 2] {
        let (s, c) = angle.sin_cos();
        let [a, b, d] = self.m2;
        let [p, q, r, t, u] = self.m4;
        [
            a * c * c + 2.0 * b * s * c + d * s * s,
            p * c.powi(4) + 4.0 * q * c.powi(3) * s + 6.0 * r * c * c * s * s + 4.0 * t * c * s.powi(3) + u * s.powi(4),
        ]
    }

    /// `m2` and `m4` of the profiles along the two principal directions of the slopes, the smaller `m2` first.
    pub fn principal(&self) -> [[f64; 2]; 2] {
        let [xx, xy, yy] = self.m2;
        let steepest = 0.5 * (2.0 * xy).atan2(xx - yy);
        [steepest + FRAC_PI_2, steepest].map(|angle| self.profile(angle))
    }

    /// The isotropic surface that stands for an anisotropic one: geometric means of the principal moments (McCool, Wear 107,
    /// 1986, doi 10.1016/0043-1648(86)90045-1).
    pub fn isotropic(&self) -> IsotropicMoments {
        let [a, b] = self.principal();
        IsotropicMoments {
            m0: self.m0,
            m2: (a[0] * b[0]).sqrt(),
            m4: (a[1] * b[1]).sqrt(),
        }
    }
}

/// Profile moments of an isotropic Gaussian surface, and its summits after Nayak (J. Lubr. Technol. 93, 1971,
/// doi 10.1115/1.3451608), for a surface known at all its points.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct IsotropicMoments {
    /// Variance of the heights (m^2).
    pub m0: f64,
    /// Variance of the slopes (-).
    pub m2: f64,
    /// Variance of the curvatures (1/m^2).
    pub m4: f64,
}

impl IsotropicMoments {
    /// Bandwidth `m0 m4/m2^2`, at least 1.5.
    pub fn bandwidth(&self) -> f64 {
        self.m0 * self.m4 / (self.m2 * self.m2)
    }

    /// Summits per area (1/m^2): `m4/(6 pi sqrt(3) m2)`.
    pub fn summit_density(&self) -> f64 {
        self.m4 / (6.0 * PI * 3f64.sqrt() * self.m2)
    }

    /// Mean height of the summits above the mean plane (m): `4 sqrt(m0/(pi alpha))`.
    pub fn mean_summit_height(&self) -> f64 {
        4.0 * (self.m0 / (PI * self.bandwidth())).sqrt()
    }

    /// Standard deviation of the heights of the summits (m): `sqrt((1 - 0.8968/alpha) m0)`.
    pub fn summit_deviation(&self) -> f64 {
        ((1.0 - 0.8968 / self.bandwidth()) * self.m0).sqrt()
    }

    /// Radius of the mean curvature of the summits (m): `(3/8) sqrt(pi/m4)`.
    pub fn summit_radius(&self) -> f64 {
        0.375 * (PI / self.m4).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central differences of the correlation stand for the derivatives that the moments are.
    fn from_correlation(spectrum: &Spectrum, h: f64) -> [f64; 5] {
        let r = |i: f64, j: f64| spectrum.correlation([i * h, j * h]);
        [
            -(2.0 * r(1.0, 0.0) - 2.0) / (h * h),
            -(2.0 * r(0.0, 1.0) - 2.0) / (h * h),
            -(r(1.0, 1.0) - r(1.0, -1.0)) / (2.0 * h * h),
            (2.0 * r(2.0, 0.0) - 8.0 * r(1.0, 0.0) + 6.0) / h.powi(4),
            (2.0 * r(0.0, 2.0) - 8.0 * r(0.0, 1.0) + 6.0) / h.powi(4),
        ]
    }

    #[test]
    fn moments_are_the_derivatives_of_the_correlation() {
        for (spectrum, h) in [
            (
                Spectrum::Gaussian {
                    lengths: [3e-4, 1e-4],
                    lay: 0.4,
                },
                2e-6,
            ),
            (
                Spectrum::PowerLaw {
                    hurst: 0.8,
                    rolloff: 4e-4,
                    cutoff: 4e-5,
                },
                1e-6,
            ),
        ] {
            let moments = spectrum.moments(1.0);
            let expected = [
                moments.m2[0],
                moments.m2[2],
                moments.m2[1],
                moments.m4[0],
                moments.m4[4],
            ];
            for (found, expected) in from_correlation(&spectrum, h).into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= 5e-3 * expected.abs() + 1e-3,
                    "{spectrum:?}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn principal_moments_do_not_turn_with_the_lay_and_sums_add() {
        let moments = |lay| {
            Spectrum::Gaussian {
                lengths: [3e-4, 1e-4],
                lay,
            }
            .moments(2e-6)
        };
        let [along, across] = moments(0.0).principal();
        assert!((along[0] / (2.0 * 4e-12 / 9e-8) - 1.0).abs() < 1e-12);
        assert!((across[1] / (12.0 * 4e-12 / 1e-16) - 1.0).abs() < 1e-12);
        for lay in [0.3, 1.2, -0.7] {
            let turned = moments(lay).principal();
            for (a, b) in turned.iter().flatten().zip([along, across].iter().flatten()) {
                assert!((a / b - 1.0).abs() < 1e-9);
            }
        }
        // Two crossed lays of equal finish are isotropic in their slopes.
        let crossed = moments(0.2) + moments(0.2 + FRAC_PI_2);
        let [a, b] = crossed.principal();
        assert!((a[0] / b[0] - 1.0).abs() < 1e-9);
        assert!((crossed.m0 / 8e-12 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn impossible_spectra_are_refused() {
        let law = |hurst, rolloff, cutoff| Spectrum::PowerLaw { hurst, rolloff, cutoff }.validated();
        assert!(law(0.8, 1e-4, 1e-5).is_ok());
        assert!(matches!(
            law(1.2, 1e-4, 1e-5),
            Err(FinishError::Value { field: "psd.hurst", .. })
        ));
        assert!(matches!(law(0.8, 1e-4, 1e-4), Err(FinishError::Order { .. })));
        assert!(matches!(
            law(0.8, 1e-4, 0.0),
            Err(FinishError::Value {
                field: "psd.cutoff",
                ..
            })
        ));
        let gaussian = |l| {
            Spectrum::Gaussian {
                lengths: [l, 1e-4],
                lay: 0.0,
            }
            .validated()
        };
        assert!(gaussian(-1e-4).is_err() && gaussian(f64::NAN).is_err() && gaussian(1e-4).is_ok());
    }
}
