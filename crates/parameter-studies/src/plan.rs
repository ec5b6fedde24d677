//! Plans: which numbers of a scene vary, and how.

use crate::Error;
use file_io::input::Kind;
use scenes::{Length, parse_json, read_json, without_comments};
use schemars::JsonSchema;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

/// A plan: a scene, and the values that parts of it take. JSON with comments.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// The scene: the path of a file, relative to the plan; the name of a scene that comes with the program, such as
    /// `"brake-reuss-beam/brb-quick"`; or the scene itself.
    pub scene: Base,
    /// What varies: values by JSON pointers (RFC 6901) into the scene, such as `/interfaces/mu` or `/bolts/load`.
    #[serde(default, skip_serializing_if = "Listed::is_empty")]
    pub parameters: Listed<Parameter>,
    /// Which combinations of values are run; by default all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub design: Option<Design>,
    /// In the place of `parameters` and `design`, the cases themselves: values by JSON pointers. What a case does not name is as in the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cases: Option<Vec<Listed<Value>>>,
    /// Loops over few coordinates and from few points of contact, learned from some of the cases.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hyper_reduction: Option<HyperReduction>,
    /// Displacement amplitude at the response point (m, or a text with a unit) that pictures compare cases at; by default the largest that all
    /// cases reach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<Length>,
}

/// What cases on one structure learn from each other. Results with larger estimated errors than are borne are computed with the whole joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HyperReduction {
    /// Cases of each structure that are run with the whole joint and learned from; by default 9 with one or two parameters, 27 with more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training: Option<usize>,
    /// Largest estimated error of the frequency, relative; by default a quarter of what the `accuracy` of the scene bears, or 0.0005.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency: Option<f64>,
    /// Largest estimated error of the damping ratio, relative; by default a quarter of what the `accuracy` of the scene bears, or 0.01.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
}

/// Where the scene of a plan is from.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Base {
    /// Its file, or the name of one that comes with the program.
    Named(String),
    /// The scene itself.
    Inline(Value),
}

impl<'de> Deserialize<'de> for Base {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::String(name) => Ok(Self::Named(name)),
            scene @ Value::Object(_) => Ok(Self::Inline(scene)),
            _ => Err(D::Error::custom(
                "the path or the name of a scene in quotes is expected, or a scene { ... }",
            )),
        }
    }
}

/// Values of a parameter: `values`, or a range `from`, `to`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Values as the scene takes them there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<Value>>,
    /// First value of a range: a number, or a text with a unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Value>,
    /// Last value of a range, in the same unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<Value>,
    /// Number of values of a range, for grids.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<usize>,
    /// How they lie between `from` and `to`; by default equally spaced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<Spacing>,
}

/// How values lie in a range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spacing {
    /// Equal differences.
    #[default]
    Linear,
    /// Equal ratios.
    Logarithmic,
}

/// Which combinations of values are run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Design {
    /// All; the last parameter varies fastest.
    #[default]
    Grid,
    /// A Latin hypercube over the ranges.
    LatinHypercube(Sample),
    /// Sobol's sequence over the ranges, scrambled by the seed.
    Sobol(Sample),
}

/// Samples of a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// How many.
    pub samples: usize,
    /// Equal seeds give equal samples.
    pub seed: u64,
}

/// Values by name, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Listed<T>(pub Vec<(String, T)>);

impl<T> Default for Listed<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Listed<T> {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T: JsonSchema> JsonSchema for Listed<T> {
    fn schema_name() -> Cow<'static, str> {
        BTreeMap::<String, T>::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        BTreeMap::<String, T>::json_schema(generator)
    }
}

impl<T: Serialize> Serialize for Listed<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Listed<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
            type Value = Listed<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object { \"/POINTER\": ... }")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Listed(entries))
            }
        }

        deserializer.deserialize_map(Entries(PhantomData))
    }
}

impl Plan {
    /// Reads a plan.
    ///
    /// # Errors
    /// [`Error::InputFile`], [`Error::Syntax`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = file_io::input::read_text(path, Kind::Scene)?;
        let syntax = |message| Error::Syntax {
            path: path.to_owned(),
            message,
        };
        // Finds names that occur twice, of which a value keeps the last.
        parse_json(&text).map_err(syntax)?;
        let plain = without_comments(&text).map_err(syntax)?;
        read_json(&plain).map_err(syntax)
    }
}

/// JSON Schema of plans.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(Plan)
}
