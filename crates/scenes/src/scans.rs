//! Scanned faces as scenes name them: where the files are, and what is done with them.

use super::units::Length;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::path::PathBuf;
use surface_characterisation::readers::{FirstRow, Format, LengthUnit};
use surface_characterisation::{
    AsperityCount, Detrend, HeightCombination, NoiseHandling, OutlierRule, PackingHeight, PairRadius, RadiusStatistic,
    TallestPeak,
};

/// Two scans from files, characterised element by element. `[TOP, BOTTOM]` stands for both files and all defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = or_both_files))]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct Scans {
    /// The top face.
    pub top: ScanFile,
    /// The bottom face.
    pub bottom: ScanFile,
    /// If given, each face is moved onto the interface by the edges and holes of its mask, by at most this along x and y
    /// (length).
    #[serde(default)]
    pub align: Option<Length>,
    /// Motion of the bottom face against the top one, after that (length, and slopes without unit).
    #[serde(default)]
    pub registration: Registration,
    /// Treatment of noise before anything else: outliers, and the cut-off of an S-filter (length). None by default.
    #[serde(default)]
    pub noise: Noise,
    /// Plane that is taken off each face.
    #[serde(default)]
    pub detrend: Detrend,
    /// Readings of the method.
    #[serde(default)]
    pub readings: Readings,
    /// Bootstrap draws for the bands of the curves.
    #[serde(default = "bootstrap")]
    pub bootstrap: usize,
    /// Seed of these draws, and of the realisations of ensembles.
    #[serde(default)]
    pub seed: u64,
    /// What the draws do with the tallest peak.
    #[serde(default)]
    pub tallest: TallestPeak,
}

fn bootstrap() -> usize {
    30
}

/// Motion of the bottom face against the top one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Registration {
    /// Shift along x and y (length).
    pub shift: [Length; 2],
    /// Slopes along x and y added to the heights of the bottom face (-).
    pub tilt: [f64; 2],
}

impl From<Registration> for surface_characterisation::Registration {
    fn from(Registration { shift, tilt }: Registration) -> Self {
        Self {
            shift: shift.map(Length::si),
            tilt,
        }
    }
}

/// Treatment of noise before anything else.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Noise {
    /// Rule by which points are taken for outliers and their data dropped.
    pub outliers: Option<OutlierRule>,
    /// Cut-off wavelength of a Gaussian S-filter (length), applied after the outliers are gone.
    pub s_filter: Option<Length>,
}

impl From<Noise> for NoiseHandling {
    fn from(Noise { outliers, s_filter }: Noise) -> Self {
        Self {
            outliers,
            s_filter: s_filter.map(Length::si),
        }
    }
}

/// How the published method is read where it leaves a choice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Readings {
    /// How the radii of an element's peaks become one.
    pub radius: RadiusStatistic,
    /// How the radii of two faces combine.
    pub pair_radius: PairRadius,
    /// Peak height in the packing estimate.
    pub packing_height: PackingHeight,
    /// Where the number of asperities comes from.
    pub count: AsperityCount,
    /// How the heights of two faces combine.
    pub heights: HeightCombination,
}

/// One face: a file, and what it does not say itself. A path alone stands for all defaults.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = or_path))]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct ScanFile {
    /// X3P, SDF, SUR, text or NumPy; in a scene file relative to its folder.
    pub path: PathBuf,
    /// The format, where the contents are not to decide.
    #[serde(default)]
    pub format: Option<Format>,
    /// Unit of positions and steps, if the file does not state it.
    #[serde(default)]
    pub lateral_unit: Option<LengthUnit>,
    /// Unit of heights, if the file does not state it.
    #[serde(default)]
    pub height_unit: Option<LengthUnit>,
    /// Distances of neighbours along x and y in `lateral_unit`, if the file does not state them.
    #[serde(default)]
    pub lateral_step: Option<[f64; 2]>,
    /// Where the first line lies, in formats that leave it open.
    #[serde(default)]
    pub first_row: Option<FirstRow>,
    /// Which layer of several, from 0.
    #[serde(default)]
    pub layer: Option<usize>,
    /// Which array of several.
    #[serde(default)]
    pub array: Option<String>,
    /// Lines of a text before its numbers.
    #[serde(default)]
    pub header_lines: Option<usize>,
    /// Do without the check of plausibility.
    #[serde(default)]
    pub accept_implausible: bool,
    /// Height step of the instrument (length); by default what the file states.
    #[serde(default)]
    pub height_step: Option<Length>,
    /// The face was scanned from its own side: x is turned over, about the middle of the interface.
    #[serde(default)]
    pub mirrored: bool,
    /// Where the grid lies, once it is turned over.
    #[serde(default)]
    pub place: Place,
}

/// Where the grid of a scan lies in the plane of the interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// Where its file says.
    #[default]
    AsStated,
    /// Its middle on the middle of the interface.
    Centred,
    /// Its point of lowest x and y at this position (length).
    Origin([Length; 2]),
}

impl Scans {
    /// Two files with all defaults.
    pub fn new(top: ScanFile, bottom: ScanFile) -> Self {
        Self {
            top,
            bottom,
            align: None,
            registration: Registration::default(),
            noise: Noise::default(),
            detrend: Detrend::default(),
            readings: Readings::default(),
            bootstrap: bootstrap(),
            seed: 0,
            tallest: TallestPeak::default(),
        }
    }

    /// What must hold: field, value, its unit, the requirement, and whether it is met.
    pub fn requirements(&self) -> Vec<(&'static str, f64, &'static str, &'static str, bool)> {
        let mut all = Vec::new();
        let mut positive = |field, value: Option<f64>, unit| {
            if let Some(v) = value {
                all.push((field, v, unit, "positive and finite", v.is_finite() && v > 0.0));
            }
        };
        let width = match self.detrend {
            Detrend::FreeEdges { width } => Some(width),
            Detrend::WholeFace | Detrend::Registered => None,
        };
        positive("interfaces.surface.scans.align", self.align.map(Length::si), "m");
        positive(
            "interfaces.surface.scans.noise.s_filter",
            self.noise.s_filter.map(Length::si),
            "m",
        );
        let threshold = self.noise.outliers.map(|rule| rule.threshold);
        positive("interfaces.surface.scans.noise.outliers.threshold", threshold, "");
        positive("interfaces.surface.scans.detrend.free-edges.width", width, "");
        for file in [&self.top, &self.bottom] {
            positive(
                "interfaces.surface.scans, height_step of a file",
                file.height_step.map(Length::si),
                "m",
            );
            for step in file.lateral_step.into_iter().flatten() {
                positive(
                    "interfaces.surface.scans, lateral_step of a file",
                    Some(step),
                    "lateral_unit",
                );
            }
        }
        let mut finite = |field, value: f64, unit| all.push((field, value, unit, "finite", value.is_finite()));
        for k in 0..2 {
            finite(
                "interfaces.surface.scans.registration.shift",
                self.registration.shift[k].si(),
                "m",
            );
            finite(
                "interfaces.surface.scans.registration.tilt",
                self.registration.tilt[k],
                "",
            );
        }
        for place in [self.top.place, self.bottom.place] {
            if let Place::Origin(origin) = place {
                origin
                    .into_iter()
                    .for_each(|x| finite("interfaces.surface.scans, origin of a file", x.si(), "m"));
            }
        }
        if let TallestPeak::MOutOfN { exponent } = self.tallest {
            let field = "interfaces.surface.scans.tallest.m-out-of-n.exponent";
            let ok = exponent > 0.0 && exponent < 1.0;
            all.push((field, exponent, "", "above 0 and below 1", ok));
        }
        let draws = self.bootstrap as f64;
        all.push((
            "interfaces.surface.scans.bootstrap",
            draws,
            "",
            "at most 100000",
            self.bootstrap <= 100_000,
        ));
        all
    }
}

impl Serialize for Scans {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

/// Adds the short form of two scans to their schema.
#[cfg(feature = "schema")]
fn or_both_files(schema: &mut schemars::Schema) {
    let file = serde_json::json!({ "$ref": "#/$defs/ScanFile" });
    or(
        schema,
        serde_json::json!({ "type": "array", "items": file, "minItems": 2, "maxItems": 2 }),
    );
}

/// Adds the short form of a scan to its schema.
#[cfg(feature = "schema")]
fn or_path(schema: &mut schemars::Schema) {
    or(schema, serde_json::json!({ "type": "string" }));
}

#[cfg(feature = "schema")]
pub(super) fn or(schema: &mut schemars::Schema, short: serde_json::Value) {
    let full = std::mem::take(schema);
    let both = [short, full.into()];
    schema.insert("anyOf".into(), both.to_vec().into());
}

impl<'de> Deserialize<'de> for Scans {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListOrBlock;
        impl<'de> Visitor<'de> for ListOrBlock {
            type Value = Scans;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of two files, or a block with `top` and `bottom`")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Scans, A::Error> {
                let [top, bottom] = <[ScanFile; 2]>::deserialize(SeqAccessDeserializer::new(list))?;
                Ok(Scans::new(top, bottom))
            }

            fn visit_map<A: MapAccess<'de>>(self, block: A) -> Result<Scans, A::Error> {
                Scans::deserialize(MapAccessDeserializer::new(block))
            }
        }
        deserializer.deserialize_any(ListOrBlock)
    }
}

impl Serialize for ScanFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for ScanFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PathOrBlock;
        impl<'de> Visitor<'de> for PathOrBlock {
            type Value = ScanFile;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the path of a scan, or a block with `path`")
            }

            fn visit_str<E: serde::de::Error>(self, path: &str) -> Result<ScanFile, E> {
                Ok(ScanFile {
                    path: path.into(),
                    ..ScanFile::default()
                })
            }

            fn visit_map<A: MapAccess<'de>>(self, block: A) -> Result<ScanFile, A::Error> {
                ScanFile::deserialize(MapAccessDeserializer::new(block))
            }
        }
        deserializer.deserialize_any(PathOrBlock)
    }
}
