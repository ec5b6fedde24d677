//! Faces as drawings and roughness reports describe them.

use super::scans::Readings;
#[cfg(feature = "schema")]
use super::scans::or;
use super::units::Length;
use crate::Error;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{IntoDeserializer, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use surface_characterisation::finish::{FaceFinish, FaceReport, LEAST_REALISATIONS, Process, Spectrum};

/// Two faces by their roughness parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Finish {
    /// The top face.
    pub top: FinishFace,
    /// The bottom face.
    pub bottom: FinishFace,
    /// Flatness tolerance of each face (length): each fills it with a random smooth form. Flat faces without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flatness: Option<Length>,
    /// Where the law comes from.
    #[serde(default)]
    pub route: Route,
    /// Realisations of a patch, between which the interval of the law lies: 19 to 1000.
    #[serde(default = "realisations")]
    pub realisations: usize,
    /// Seed of the realisations and of the forms.
    #[serde(default = "one")]
    pub seed: u64,
    /// Sides of a patch along x and y (length), at least 4 correlation lengths: by default a square as large as the
    /// mean element, or 8 correlation lengths where that is longer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<Lengths>,
    /// Grid steps along x and y (length): by default 8 in a correlation length, 4 in a cut-off wavelength.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<Lengths>,
    /// Readings of the method, as for scans.
    #[serde(default)]
    pub readings: Readings,
}

fn realisations() -> usize {
    32
}

fn one() -> u64 {
    1
}

/// Where the law of a finish comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Route {
    /// Pairs of synthesised patches, characterised like scans; each element takes one of them.
    #[default]
    Ensemble,
    /// What the characterisation would find of a typical patch, by the theory of random surfaces; all elements take it.
    Fast,
}

/// What is said of a face.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct FinishFace {
    /// Arithmetic mean height Ra (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ra: Option<Length>,
    /// Root mean square height Rq (length); by default from `ra`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rq: Option<Length>,
    /// Root mean square height Sq of the area (length).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sq: Option<Length>,
    /// Maximum height Rz (length), for a check alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rz: Option<Length>,
    /// Mean width of profile elements Rsm (length); two along and across the lay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rsm: Option<Lengths>,
    /// Length in which the autocorrelation falls to 1/e, by default `rsm`/4.443; two along and across the lay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub correlation_length: Option<Lengths>,
    /// Direction of the lay from x towards y (degrees); needed beside two lengths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lay_degrees: Option<f64>,
    /// Skewness Rsk or Ssk (-); 0 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skewness: Option<f64>,
    /// Kurtosis Rku or Sku (-), which is 3 for Gaussian heights and by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kurtosis: Option<f64>,
    /// Power-law spectrum in the place of a Gaussian autocorrelation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psd: Option<PowerLaw>,
    /// Machining process, which stands for the Ra that it commonly leaves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process: Option<Process>,
}

/// Isotropic power spectral density: constant up to the roll-off, `q^(-2 - 2 H)` from there to the cut-off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PowerLaw {
    /// Hurst exponent H (-).
    pub hurst: f64,
    /// Roll-off wavelength (length).
    pub rolloff: Length,
    /// Cut-off wavelength, the shortest one (length).
    pub cutoff: Length,
}

/// Lengths in two directions; one stands for both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = or_one))]
pub struct Lengths(pub [Length; 2]);

impl Lengths {
    /// In SI.
    pub fn si(self) -> [f64; 2] {
        self.0.map(Length::si)
    }
}

/// Adds the short form of two equal lengths to their schema.
#[cfg(feature = "schema")]
fn or_one(schema: &mut schemars::Schema) {
    let one = schema.as_value().pointer("/items").cloned();
    or(
        schema,
        one.unwrap_or_else(|| serde_json::json!({ "type": ["number", "string"] })),
    );
}

impl<'de> Deserialize<'de> for Lengths {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrTwo;
        impl<'de> Visitor<'de> for OneOrTwo {
            type Value = Lengths;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a length, or a list of two")
            }

            fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<Lengths, E> {
                let length = Length::deserialize(number.into_deserializer())?;
                Ok(Lengths([length; 2]))
            }

            fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Lengths, E> {
                self.visit_f64(number as f64)
            }

            fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<Lengths, E> {
                self.visit_f64(number as f64)
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Lengths, E> {
                let length = Length::deserialize(text.into_deserializer())?;
                Ok(Lengths([length; 2]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Lengths, A::Error> {
                <[Length; 2]>::deserialize(SeqAccessDeserializer::new(list)).map(Lengths)
            }
        }
        deserializer.deserialize_any(OneOrTwo)
    }
}

impl FinishFace {
    fn report(&self) -> FaceReport {
        let si = |length: Option<Length>| length.map(Length::si);
        FaceReport {
            ra: si(self.ra),
            rq: si(self.rq),
            sq: si(self.sq),
            rz: si(self.rz),
            rsm: self.rsm.map(Lengths::si),
            correlation_length: self.correlation_length.map(Lengths::si),
            lay: self.lay_degrees.map(f64::to_radians),
            skewness: self.skewness,
            kurtosis: self.kurtosis,
            psd: self.psd.map(|psd| Spectrum::PowerLaw {
                hurst: psd.hurst,
                rolloff: psd.rolloff.si(),
                cutoff: psd.cutoff.si(),
            }),
            process: self.process,
        }
    }
}

impl Finish {
    /// Top and bottom face, and what was assumed of each; `place` is named in errors.
    ///
    /// # Errors
    /// [`Error::Finish`].
    pub fn faces(&self, place: &str) -> Result<([FaceFinish; 2], Vec<String>), Error> {
        let mut assumed = Vec::new();
        let mut face = |name: &str, given: &FinishFace| {
            let (face, lines) = given.report().face().map_err(|source| Error::Finish {
                place: place.into(),
                field: format!("interfaces.surface.finish.{name}"),
                source: Box::new(source),
            })?;
            assumed.extend(lines.into_iter().map(|line| format!("{name} face: {line}")));
            Ok::<_, Error>(face)
        };
        let faces = [face("top", &self.top)?, face("bottom", &self.bottom)?];
        Ok((faces, assumed))
    }

    /// Whether half of an interface need not be like the other.
    pub fn is_random(&self) -> bool {
        self.route == Route::Ensemble || self.flatness.is_some()
    }

    /// What must hold: field, value, its unit, the requirement, and whether it is met.
    pub fn requirements(&self) -> Vec<(&'static str, f64, &'static str, &'static str, bool)> {
        let number = self.realisations;
        let mut all = vec![(
            "interfaces.surface.finish.realisations",
            number as f64,
            "",
            "from 19 (fewer do not hold 90 % between them) to 1000",
            (LEAST_REALISATIONS..=1000).contains(&number),
        )];
        let mut positive = |field, value: f64| {
            all.push((
                field,
                value,
                "m",
                "positive and finite",
                value.is_finite() && value > 0.0,
            ));
        };
        if let Some(tolerance) = self.flatness {
            positive("interfaces.surface.finish.flatness", tolerance.si());
        }
        for (field, lengths) in [
            ("interfaces.surface.finish.window", self.window),
            ("interfaces.surface.finish.step", self.step),
        ] {
            for length in lengths.into_iter().flat_map(Lengths::si) {
                positive(field, length);
            }
        }
        all
    }
}
