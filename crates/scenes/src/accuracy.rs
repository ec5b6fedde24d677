//! How exact a scene asks to be: settings chosen by their measured errors.
//!
//! [`PRESETS`] are whole sets of numerical settings, each with the sum of the errors that were measured for its mesh, points and
//! vertices on the Brake-Reuss beam (`docs/validation.md`). A scene that asks for an accuracy gets the settings of
//! a preset wherever it does not give its own.

use joint_model::benchmark::{ElementOrder, RefinementLevel};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// A set of numerical settings and what it was measured to cost and to miss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Preset {
    /// Name.
    pub name: &'static str,
    /// Order of the elements and refinement of a benchmark's mesh; without effect on decks and matrices. Of a mesh file the order alone:
    /// linear elements stay as they are.
    pub element_order: ElementOrder,
    /// See there.
    pub refinement: RefinementLevel,
    /// Quadrature points per direction of an interface element.
    pub points_per_direction: usize,
    /// Stuck-interface modes retained by the reduction.
    pub modes: usize,
    /// Vertices per quarter loop.
    pub vertices_per_quarter: usize,
    /// Residual relative to the load.
    pub tolerance: f64,
    /// Largest relative error of the frequency, of the linearised mode and at amplitudes up to 6e-4 m.
    pub frequency_error: f64,
    /// Largest error of the logarithm of the damping ratio, where it is above 0.5 %: at the onset of slip errors are larger.
    pub damping_error: f64,
    /// Time relative to that of `standard`.
    pub cost: f64,
}

/// From the cheapest to the finest. Errors are against the limit of the mesh and rounded up: those of
/// `ErrorBar` of `analyses` with those of the vertices.
pub static PRESETS: [Preset; 4] = [
    Preset {
        name: "draft",
        element_order: ElementOrder::Linear,
        refinement: RefinementLevel::Quick,
        points_per_direction: 2,
        modes: 10,
        vertices_per_quarter: 4,
        tolerance: 1e-5,
        frequency_error: 2.6e-2,
        damping_error: 0.12,
        cost: 0.1,
    },
    Preset {
        name: "coarse",
        element_order: ElementOrder::Quadratic,
        refinement: RefinementLevel::Quick,
        points_per_direction: 3,
        modes: 10,
        vertices_per_quarter: 4,
        tolerance: 1e-7,
        frequency_error: 5e-3,
        damping_error: 0.036,
        cost: 0.5,
    },
    Preset {
        name: "standard",
        element_order: ElementOrder::Quadratic,
        refinement: RefinementLevel::Coarse,
        points_per_direction: 3,
        modes: 20,
        vertices_per_quarter: 4,
        tolerance: 1e-9,
        frequency_error: 3e-3,
        damping_error: 0.025,
        cost: 1.0,
    },
    Preset {
        name: "reference",
        element_order: ElementOrder::Quadratic,
        refinement: RefinementLevel::Default,
        points_per_direction: 3,
        modes: 20,
        vertices_per_quarter: 16,
        tolerance: 1e-9,
        frequency_error: 1.5e-3,
        damping_error: 0.022,
        cost: 2.3,
    },
];

/// What a scene may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "`accuracy` is \"draft\", \"standard\", \"reference\", or the errors that are borne, such as {\"damping\": 0.02}"
)]
pub enum Accuracy {
    /// A preset by its name.
    Level(Level),
    /// Settings that a run adapts to errors estimated for the scene itself, from the cheapest preset on whose measured errors are not larger,
    /// or the finest.
    Target(Target),
}

/// Presets that have a name in scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// The cheapest.
    Draft,
    /// What is advised.
    Standard,
    /// The finest.
    Reference,
}

/// Errors that are borne.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Target {
    /// Relative error of frequencies.
    pub frequency: Option<f64>,
    /// Error of the logarithm of damping ratios.
    pub damping: Option<f64>,
    /// Which settings the scene gives itself; they are kept as they are.
    #[serde(skip)]
    pub given: GivenSettings,
}

/// Settings that a scene file gives and that no accuracy changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GivenSettings {
    /// Refinement of a benchmark's mesh.
    pub mesh: bool,
    /// Quadrature points.
    pub points: bool,
    /// Bins of asperities.
    pub bins: bool,
    /// Radii of an asperity.
    pub radii: bool,
    /// Vertices of a loop.
    pub vertices: bool,
    /// Residual relative to the load.
    pub tolerance: bool,
}

impl GivenSettings {
    /// Those of a scene file.
    pub(crate) fn of(given: &Value) -> Self {
        let is_given = |path: &str| given.pointer(path).is_some_and(|value| !value.is_null());
        let own = given.pointer("/interfaces/each").and_then(Value::as_array);
        let of_law = |name: &str| {
            let own = own.into_iter().flatten();
            let path = format!("/law/{name}");
            let mut own = own.filter_map(|own| own.pointer(&path));
            is_given(&format!("/interfaces/law/{name}")) || own.any(|value| !value.is_null())
        };
        Self {
            mesh: ["refinement", "element_order", "arm_layers", "formulation"]
                .iter()
                .any(|name| is_given(&format!("/model/{name}"))),
            points: is_given("/interfaces/points_per_direction"),
            bins: of_law("bins"),
            radii: of_law("radii"),
            vertices: is_given("/analyses/backbone/vertices_per_quarter"),
            tolerance: is_given("/analyses/backbone/tolerance"),
        }
    }
}

impl Default for Accuracy {
    fn default() -> Self {
        Self::Level(Level::Standard)
    }
}

impl Accuracy {
    /// The preset that is asked for, or that a run begins to adapt: the cheapest whose measured errors are not larger, or the finest.
    ///
    /// # Errors
    /// What is no error to ask for, in words.
    pub fn preset(&self) -> Result<&'static Preset, String> {
        let target = match self {
            Self::Level(level) => {
                let name = match level {
                    Level::Draft => "draft",
                    Level::Standard => "standard",
                    Level::Reference => "reference",
                };
                return PRESETS
                    .iter()
                    .find(|preset| preset.name == name)
                    .ok_or_else(|| format!("there is no preset {name}"));
            }
            Self::Target(target) => target,
        };
        for (name, wanted) in [("frequency", target.frequency), ("damping", target.damping)] {
            if let Some(wanted) = wanted.filter(|wanted| !(*wanted > 0.0 && wanted.is_finite())) {
                return Err(format!("accuracy.{name} = {wanted} must be positive and finite"));
            }
        }
        if (target.frequency, target.damping) == (None, None) {
            return Err("accuracy is empty; name accuracy.frequency, accuracy.damping or both".into());
        }
        let meets = |preset: &&Preset| {
            target.frequency.is_none_or(|wanted| preset.frequency_error <= wanted)
                && target.damping.is_none_or(|wanted| preset.damping_error <= wanted)
        };
        let finest = &PRESETS[PRESETS.len() - 1];
        Ok(PRESETS.iter().find(meets).unwrap_or(finest))
    }
}

impl Preset {
    /// Where a scene file has the settings, and their values.
    fn settings(&self) -> [(&'static str, Value); 6] {
        [
            ("/model/element_order", json!(self.element_order)),
            ("/model/refinement", json!(self.refinement)),
            ("/interfaces/points_per_direction", json!(self.points_per_direction)),
            ("/model/modes", json!(self.modes)),
            (
                "/analyses/backbone/vertices_per_quarter",
                json!(self.vertices_per_quarter),
            ),
            ("/analyses/backbone/tolerance", json!(self.tolerance)),
        ]
    }

    /// Writes the settings into a scene file where it has none of its own.
    pub fn fill(&self, scene: &mut Value) {
        let given = |path: &str| scene.pointer(path).is_some_and(|value| !value.is_null());
        let is_benchmark = given("/structure/benchmark");
        let is_kept_linear = given("/structure/mesh") && self.element_order == ElementOrder::Linear;
        // The refinement is a measured one for elements of the preset's order alone.
        let order = scene.pointer("/model/element_order");
        let has_other_order = order.is_some_and(|order| !order.is_null() && *order != json!(self.element_order));
        // A reduction to an error finds its number of modes, and matrices over the jump have theirs.
        let own_modes = given("/structure/matrices") || given("/model/reduction_error");
        let has_points = given("/structure/matrices/points");
        if let Some(Value::Object(analyses)) = scene.get_mut("analyses") {
            // Settings alone ask for no loops.
            analyses.entry("backbone").or_insert(json!({ "amplitudes": 0 }));
        }
        for (path, mut value) in self.settings() {
            let applies = match path {
                "/model/element_order" => is_benchmark || is_kept_linear,
                "/model/refinement" => is_benchmark,
                "/model/modes" => !own_modes,
                "/interfaces/points_per_direction" => !has_points,
                _ => true,
            };
            if !applies {
                continue;
            }
            if path == "/model/refinement" && has_other_order {
                value = json!(RefinementLevel::Default);
            }
            let mut place = &mut *scene;
            for name in path.split('/').skip(1) {
                let Some(object) = as_object(place) else { return };
                place = object.entry(name).or_insert(Value::Null);
            }
            if place.is_null() {
                *place = value;
            }
        }
    }
}

/// The fields of a block, which is made if there is none.
fn as_object(value: &mut Value) -> Option<&mut serde_json::Map<String, Value>> {
    if value.is_null() {
        *value = json!({});
    }
    value.as_object_mut()
}
