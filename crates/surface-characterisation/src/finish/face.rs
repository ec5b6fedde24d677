//! One face: what a drawing or a roughness report says of it, and the random surface that this stands for.

use std::fmt;

use super::error::{FinishError, positive};
use super::spectrum::{RSM_PER_LENGTH, SpectralMoments, Spectrum};
use super::translation::Translation;

/// A random face: standard deviation, distribution and correlation of its heights.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceFinish {
    rms: f64,
    translation: Translation,
    spectrum: Spectrum,
}

impl FaceFinish {
    /// A face of root mean square height `rms` (m), whose heights have this skewness and kurtosis (3 if Gaussian).
    ///
    /// # Errors
    /// A roughness that is not positive; those of [`Translation::try_new`] and [`Spectrum::validated`].
    pub fn try_new(rms: f64, skewness: f64, kurtosis: f64, spectrum: Spectrum) -> Result<Self, FinishError> {
        Ok(Self {
            rms: positive("rq", rms, "m")?,
            translation: Translation::try_new(skewness, kurtosis)?,
            spectrum: spectrum.validated()?,
        })
    }

    /// Root mean square height (m).
    pub fn rms(&self) -> f64 {
        self.rms
    }

    /// From Gaussian heights of unit variance to heights of unit variance.
    pub fn translation(&self) -> &Translation {
        &self.translation
    }

    /// Correlation of the heights.
    pub fn spectrum(&self) -> &Spectrum {
        &self.spectrum
    }

    /// Spectral moments of the heights.
    pub fn moments(&self) -> SpectralMoments {
        self.spectrum.moments(self.rms)
    }

    /// Height (m) of a standard normal value.
    pub(super) fn height(&self, y: f64) -> f64 {
        self.rms * self.translation.height(y)
    }

    /// Standard normal value of a height (m).
    pub(super) fn normal(&self, z: f64) -> f64 {
        self.translation.normal(z / self.rms)
    }

    /// Correlation of the standard normal values at a lag (m).
    pub(super) fn normal_correlation(&self, lag: [f64; 2]) -> f64 {
        self.translation.normal_correlation(self.spectrum.correlation(lag))
    }
}

/// A machining process, which stands for the Ra that it commonly leaves.
///
/// The ranges are those of average application in the table of roughness by common production methods of ASME B46.1
/// (appendix B; also in Machinery's Handbook). They say nothing of spacing, skewness or lay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Process {
    /// Sawn: Ra 1.6 to 25 um.
    Sawn,
    /// Planed or shaped: Ra 1.6 to 12.5 um.
    Planed,
    /// Drilled: Ra 1.6 to 6.3 um.
    Drilled,
    /// Eroded by electric discharge: Ra 1.6 to 4.75 um.
    Eroded,
    /// Milled: Ra 0.8 to 6.3 um.
    Milled,
    /// Broached: Ra 0.8 to 3.2 um.
    Broached,
    /// Reamed: Ra 0.8 to 3.2 um.
    Reamed,
    /// Turned or bored: Ra 0.4 to 6.3 um.
    Turned,
    /// Ground: Ra 0.1 to 1.6 um.
    Ground,
    /// Honed: Ra 0.1 to 0.8 um.
    Honed,
    /// Polished: Ra 0.1 to 0.4 um.
    Polished,
    /// Lapped: Ra 0.05 to 0.4 um.
    Lapped,
    /// Superfinished: Ra 0.05 to 0.2 um.
    Superfinished,
}

impl Process {
    /// Least and greatest Ra of average application (m).
    pub fn ra(self) -> [f64; 2] {
        match self {
            Self::Sawn => [1.6e-6, 25e-6],
            Self::Planed => [1.6e-6, 12.5e-6],
            Self::Drilled => [1.6e-6, 6.3e-6],
            Self::Eroded => [1.6e-6, 4.75e-6],
            Self::Milled => [0.8e-6, 6.3e-6],
            Self::Broached | Self::Reamed => [0.8e-6, 3.2e-6],
            Self::Turned => [0.4e-6, 6.3e-6],
            Self::Ground => [0.1e-6, 1.6e-6],
            Self::Honed => [0.1e-6, 0.8e-6],
            Self::Polished => [0.1e-6, 0.4e-6],
            Self::Lapped => [0.05e-6, 0.4e-6],
            Self::Superfinished => [0.05e-6, 0.2e-6],
        }
    }
}

impl fmt::Display for Process {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", format!("{self:?}").to_lowercase())
    }
}

/// What a drawing or a roughness report says of a face (ISO 21920-2, ISO 25178-2), in SI.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FaceReport {
    /// Arithmetic mean height Ra (m).
    pub ra: Option<f64>,
    /// Root mean square height Rq of profiles (m).
    pub rq: Option<f64>,
    /// Root mean square height Sq of the area (m).
    pub sq: Option<f64>,
    /// Maximum height Rz (m), for a check alone.
    pub rz: Option<f64>,
    /// Mean width of profile elements Rsm along and across the lay (m).
    pub rsm: Option<[f64; 2]>,
    /// Correlation lengths along and across the lay (m), to 1/e.
    pub correlation_length: Option<[f64; 2]>,
    /// Direction of the lay from x towards y (rad).
    pub lay: Option<f64>,
    /// Skewness Rsk or Ssk.
    pub skewness: Option<f64>,
    /// Kurtosis Rku or Sku (3 if Gaussian).
    pub kurtosis: Option<f64>,
    /// Power-law spectrum in the place of a Gaussian correlation.
    pub psd: Option<Spectrum>,
    /// Machining process.
    pub process: Option<Process>,
}

/// Largest factor between Rsm and what belongs to the correlation length.
const SPACING_FACTOR: f64 = 1.5;

impl FaceReport {
    /// The random face, and in words what was assumed of it.
    ///
    /// # Errors
    /// What is missing, given twice, impossible, or inconsistent.
    pub fn face(&self) -> Result<(FaceFinish, Vec<String>), FinishError> {
        let mut assumed = Vec::new();
        let lengths = [("ra", self.ra), ("rq", self.rq), ("sq", self.sq), ("rz", self.rz)];
        for (field, value) in lengths {
            if let Some(value) = value {
                positive(field, value, "m")?;
            }
        }
        let spectrum = self.spectrum(&mut assumed)?;
        if self.skewness.is_none() {
            assumed.push("skewness 0, as none is given".into());
        }
        if self.kurtosis.is_none() {
            assumed.push("kurtosis 3, as none is given".into());
        }
        let (skewness, kurtosis) = (self.skewness.unwrap_or(0.0), self.kurtosis.unwrap_or(3.0));
        let translation = Translation::try_new(skewness, kurtosis)?;
        let rms = self.rms(&translation, &mut assumed)?;
        if let Some((rz, reason)) = self.rz.map(|rz| (rz, "no profile is lower than its rms height")) {
            if rms > rz {
                return Err(FinishError::Order {
                    smaller: "rq",
                    first: rms,
                    larger: "rz",
                    second: rz,
                    reason,
                });
            }
            assumed.push("rz is compared with rq and otherwise without effect".into());
        }
        let face = FaceFinish {
            rms,
            translation,
            spectrum,
        };
        Ok((face, assumed))
    }

    fn rms(&self, translation: &Translation, assumed: &mut Vec<String>) -> Result<f64, FinishError> {
        let (rms, name) = match (self.rq, self.sq) {
            (Some(_), Some(_)) => {
                return Err(FinishError::Conflict {
                    field: "rq",
                    other: "sq",
                    remedy: "both are the root mean square height; leave one of them out",
                });
            }
            (Some(rq), None) => (Some(rq), "rq"),
            (None, sq) => (sq, "sq"),
        };
        if let (Some(process), true) = (self.process, rms.is_some() || self.ra.is_some()) {
            assumed.push(format!("the roughness is given, so that `{process}` is without effect"));
        }
        let ratio = translation.mean_absolute();
        match (rms, self.ra, self.process) {
            (Some(rms), Some(ra), _) if ra > rms => Err(FinishError::Order {
                smaller: "ra",
                first: ra,
                larger: name,
                second: rms,
                reason: "a mean absolute height never exceeds the root mean square; check units and order",
            }),
            (Some(rms), Some(ra), _) => {
                assumed.push(format!(
                    "{name} is used; ra is {:.3} of it, the assumed distribution has {ratio:.3}",
                    ra / rms
                ));
                Ok(rms)
            }
            (Some(rms), None, _) => Ok(rms),
            (None, Some(ra), _) => {
                assumed.push(format!(
                    "rq = ra/{ratio:.4}, as the assumed distribution of heights has it"
                ));
                Ok(ra / ratio)
            }
            (None, None, Some(process)) => {
                let [least, greatest] = process.ra();
                let ra = (least * greatest).sqrt();
                assumed.push(format!(
                    "ra = {ra:.3e} m, geometric mean of {least:.2e} to {greatest:.2e} m that ASME B46.1 gives for `{process}` \
                     faces; rq = ra/{ratio:.4}"
                ));
                Ok(ra / ratio)
            }
            (None, None, None) => Err(FinishError::Missing {
                what: "a roughness",
                remedy: "add \"ra\", \"rq\" or \"sq\", such as \"ra\": \"0.8 um\", or a \"process\"",
            }),
        }
    }

    fn spectrum(&self, assumed: &mut Vec<String>) -> Result<Spectrum, FinishError> {
        let given = [
            ("rsm", self.rsm.is_some()),
            ("correlation_length", self.correlation_length.is_some()),
            ("lay_degrees", self.lay.is_some()),
        ];
        if let (Some(psd), Some((other, _))) = (self.psd, given.iter().find(|(_, given)| *given)) {
            let _ = psd;
            return Err(FinishError::Conflict {
                field: "psd",
                other,
                remedy: "a power law says itself how heights are correlated; leave one of them out",
            });
        }
        if let Some(psd) = self.psd {
            assumed.push("isotropic power-law spectrum, without structure beyond its cut-off wavelength".into());
            return psd.validated();
        }
        for (field, pair) in [("rsm", self.rsm), ("correlation_length", self.correlation_length)] {
            for value in pair.into_iter().flatten() {
                positive(field, value, "m")?;
            }
        }
        assumed.push(
            "Gaussian autocorrelation exp(-(s/l)^2), which has no structure finer than l: the curvature of asperities follows \
             from it"
                .into(),
        );
        let lengths = match (self.correlation_length, self.rsm) {
            (None, None) => {
                return Err(FinishError::Missing {
                    what: "the spacing of the roughness",
                    remedy: "add \"rsm\" or \"correlation_length\", such as \"rsm\": \"150 um\", or a \"psd\"; no process \
                             stands for one",
                });
            }
            (Some(lengths), None) => lengths,
            (None, Some(rsm)) => {
                assumed.push(format!(
                    "correlation length l = rsm/{RSM_PER_LENGTH:.3}: zero crossings of a Gaussian profile, without the \
                     discrimination of small elements of ISO 21920"
                ));
                rsm.map(|rsm| rsm / RSM_PER_LENGTH)
            }
            (Some(lengths), Some(rsm)) => {
                for (length, rsm) in lengths.into_iter().zip(rsm) {
                    let expected = RSM_PER_LENGTH * length;
                    if (rsm / expected).max(expected / rsm) > SPACING_FACTOR {
                        return Err(FinishError::Spacing { rsm, length, expected });
                    }
                }
                assumed.push("correlation_length is used; rsm agrees with it and is otherwise without effect".into());
                lengths
            }
        };
        // The same length in two units may differ in its last bits.
        let isotropic = (lengths[0] / lengths[1] - 1.0).abs() < 1e-9;
        let lay = match self.lay {
            Some(_) if isotropic => {
                return Err(FinishError::Conflict {
                    field: "lay_degrees",
                    other: "one length for all directions",
                    remedy: "give two lengths, along and across the lay, or leave the lay out",
                });
            }
            None if !isotropic => {
                return Err(FinishError::Missing {
                    what: "the direction of the lay, along which the first of two lengths is,",
                    remedy: "add \"lay_degrees\", from x towards y, such as \"lay_degrees\": 90",
                });
            }
            lay => lay.unwrap_or(0.0),
        };
        Spectrum::Gaussian { lengths, lay }.validated()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> FaceReport {
        FaceReport {
            ra: Some(0.8e-6),
            correlation_length: Some([1e-4; 2]),
            ..FaceReport::default()
        }
    }

    #[test]
    fn reports_become_faces_and_say_what_they_assume() {
        let (face, assumed) = report().face().unwrap();
        assert!((face.rms() / (0.8e-6 * (std::f64::consts::FRAC_PI_2).sqrt()) - 1.0).abs() < 1e-3);
        for what in ["skewness 0", "kurtosis 3", "Gaussian autocorrelation", "rq = ra/"] {
            assert!(assumed.iter().any(|line| line.contains(what)), "{what}: {assumed:?}");
        }
        let class = FaceReport {
            ra: None,
            process: Some(Process::Ground),
            ..report()
        };
        let (face, assumed) = class.face().unwrap();
        assert!((face.rms() / (0.4e-6 * (std::f64::consts::FRAC_PI_2).sqrt()) - 1.0).abs() < 1e-3);
        assert!(
            assumed
                .iter()
                .any(|line| line.contains("ASME B46.1") && line.contains("ground"))
        );
        let width = FaceReport {
            correlation_length: None,
            rsm: Some([4.44e-4, 2.22e-4]),
            lay: Some(0.5),
            ..report()
        };
        let (face, _) = width.face().unwrap();
        let [along, across] = face.moments().principal();
        assert!((across[0] / along[0] - 4.0).abs() < 1e-9);
        let full = FaceReport {
            ra: Some(0.8e-6),
            rq: Some(1e-6),
            rz: Some(6e-6),
            rsm: Some([4e-4; 2]),
            skewness: Some(-0.5),
            kurtosis: Some(3.6),
            ..report()
        };
        let (face, assumed) = full.face().unwrap();
        assert_eq!(face.rms(), 1e-6);
        assert!(!assumed.iter().any(|line| line.contains("skewness 0")));
    }

    #[test]
    fn every_contradiction_is_refused_by_its_name() {
        let error = |report: FaceReport| report.face().unwrap_err().to_string();
        let cases = [
            (
                FaceReport { ra: None, ..report() },
                "a roughness is not given; add \"ra\"",
            ),
            (
                FaceReport {
                    ra: Some(-1e-6),
                    ..report()
                },
                "ra = -0.000001 m; it must be positive and finite",
            ),
            (
                FaceReport {
                    ra: None,
                    rq: Some(0.0),
                    ..report()
                },
                "rq = 0 m",
            ),
            (
                FaceReport {
                    rq: Some(0.7e-6),
                    ..report()
                },
                "ra = 8.0000e-7 m is above rq = 7.0000e-7 m",
            ),
            (
                FaceReport {
                    ra: None,
                    sq: Some(2e-6),
                    rz: Some(1e-6),
                    ..report()
                },
                "rq = 2.0000e-6 m is above rz",
            ),
            (
                FaceReport {
                    rz: Some(f64::NAN),
                    ..report()
                },
                "rz = NaN m",
            ),
            (
                FaceReport {
                    rq: Some(1e-6),
                    sq: Some(1e-6),
                    ..report()
                },
                "`rq` is given together with `sq`",
            ),
            (
                FaceReport {
                    correlation_length: None,
                    ..report()
                },
                "the spacing of the roughness is not given; add \"rsm\"",
            ),
            (
                FaceReport {
                    correlation_length: Some([0.0; 2]),
                    ..report()
                },
                "correlation_length = 0 m",
            ),
            (
                FaceReport {
                    correlation_length: None,
                    rsm: Some([-1e-4; 2]),
                    ..report()
                },
                "rsm = -0.0001 m",
            ),
            (
                FaceReport {
                    rsm: Some([1e-4; 2]),
                    ..report()
                },
                "rsm = 1.0000e-4 m with correlation_length = 1.0000e-4 m",
            ),
            (
                FaceReport {
                    lay: Some(0.1),
                    ..report()
                },
                "`lay_degrees` is given together with `one length for all directions`",
            ),
            (
                FaceReport {
                    correlation_length: Some([1e-3, 1e-4]),
                    ..report()
                },
                "the direction of the lay",
            ),
            (
                FaceReport {
                    skewness: Some(1.0),
                    kurtosis: Some(1.9),
                    ..report()
                },
                "kurtosis = 1.9 with skewness = 1",
            ),
            (
                FaceReport {
                    kurtosis: Some(-1.0),
                    ..report()
                },
                "kurtosis = -1",
            ),
            (
                FaceReport {
                    kurtosis: Some(1.01),
                    ..report()
                },
                "beyond what the sinh-arcsinh distribution reaches",
            ),
            (
                FaceReport {
                    psd: Some(Spectrum::PowerLaw {
                        hurst: 0.8,
                        rolloff: 1e-3,
                        cutoff: 1e-5,
                    }),
                    ..report()
                },
                "`psd` is given together with `correlation_length`",
            ),
        ];
        for (report, expected) in cases {
            let found = error(report);
            assert!(found.contains(expected), "{found}");
        }
    }
}
