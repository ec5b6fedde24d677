//! How exact a scene asks to be: settings chosen by their measured errors.
//!
//! [`PRESETS`] are whole sets of numerical settings, each with the sum of the errors that were measured for its mesh, points and
//! vertices on the Brake-Reuss beam (`docs/validation.md`). A scene that asks for an accuracy gets the settings of
//! a preset wherever it does not give its own.

use super::{ElementOrder, RefinementLevel, Scene};
use crate::Error;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// A set of numerical settings and what it was measured to cost and to miss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Preset {
    /// Name.
    pub name: &'static str,
    /// Order of the elements and refinement of a benchmark's mesh; without effect where a deck or matrices replace it, and on scenes
    /// that give a mesh of their own: an order, a refinement or a formulation. Of a mesh file the order alone, as far as its elements fit.
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

/// Time of `standard` on the flat Brake-Reuss beam, from nothing to the backbone of [`TIMED_AMPLITUDES`] amplitudes of one mode, on two
/// cores (s): `docs/validation.md`, what accuracy costs.
const STANDARD_SECONDS: f64 = 12.4;

/// Amplitudes of the runs that were timed.
const TIMED_AMPLITUDES: usize = 20;

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
        vertices_per_quarter: 8,
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
        vertices_per_quarter: 8,
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
        vertices_per_quarter: 32,
        tolerance: 1e-9,
        frequency_error: 1.5e-3,
        damping_error: 0.022,
        cost: 3.4,
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
    /// The cheapest preset whose measured errors are not larger.
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
}

impl Accuracy {
    /// The preset that is asked for.
    ///
    /// # Errors
    /// What no preset reaches, or what is no error to ask for, in words.
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
        if *target == Target::default() {
            return Err("accuracy is empty; name accuracy.frequency, accuracy.damping or both".into());
        }
        let meets = |preset: &&Preset| {
            target.frequency.is_none_or(|wanted| preset.frequency_error <= wanted)
                && target.damping.is_none_or(|wanted| preset.damping_error <= wanted)
        };
        PRESETS.iter().find(meets).ok_or_else(|| {
            let finest = &PRESETS[PRESETS.len() - 1];
            format!(
                "no measured set of settings is within the accuracy asked for; the finest has the errors {} in frequency \
                 and {} in the logarithm of damping",
                finest.frequency_error, finest.damping_error
            )
        })
    }
}

impl Preset {
    /// Whether its errors were measured on the structure of a scene.
    fn is_measured_on(scene: &Scene) -> bool {
        scene.structure.benchmark().is_some()
    }

    /// What a run with these settings is expected to take, and what that rests on, for the start of a run.
    pub fn expectation(&self, scene: &Scene) -> String {
        if !Self::is_measured_on(scene) {
            return "a time that depends on the mesh: settings are timed on the Brake-Reuss beam alone".into();
        }
        let seconds = self.cost * STANDARD_SECONDS;
        let time = match seconds {
            seconds if seconds < 100.0 => format!("{seconds:.0} s"),
            seconds => format!("{:.0} min", seconds / 60.0),
        };
        let model = &scene.model;
        let has_mesh = (model.element_order, model.refinement) == (self.element_order, self.refinement);
        let loops = scene.cqsma.amplitudes * scene.cqsma.followed().len();
        let differs = match (has_mesh, loops == TIMED_AMPLITUDES) {
            (true, true) => String::new(),
            (true, false) => format!("; this scene has {loops} loops"),
            (false, _) => "; this scene has another mesh, on which times differ".into(),
        };
        format!(
            "about {time} where nothing is in the cache, as measured on the flat Brake-Reuss beam with \
             {TIMED_AMPLITUDES} loops on two cores{differs}"
        )
    }

    /// What is known of the errors of a scene with these settings, for the end of a run.
    pub fn promise(&self, scene: &Scene) -> String {
        match Self::is_measured_on(scene) {
            true => format!(
                "measured errors on the flat beam: {} in frequency, {} in the logarithm of damping",
                self.frequency_error, self.damping_error
            ),
            false => "their errors are not known of this structure; --estimate-error settings measures them".into(),
        }
    }

    /// Where a scene file has the settings, and their values.
    fn settings(&self) -> [([&'static str; 2], Value); 6] {
        [
            (["model", "element_order"], json!(self.element_order)),
            (["model", "refinement"], json!(self.refinement)),
            (["", "points_per_direction"], json!(self.points_per_direction)),
            (["model", "modes"], json!(self.modes)),
            (["cqsma", "vertices_per_quarter"], json!(self.vertices_per_quarter)),
            (["cqsma", "tolerance"], json!(self.tolerance)),
        ]
    }

    /// Writes the settings into a scene file where it has none of its own.
    pub fn fill(&self, scene: &mut Value) {
        let given = |path: &str| scene.pointer(path).is_some_and(|value| !value.is_null());
        // Order, refinement and formulation make a mesh together.
        let own_mesh = [
            "structure/deck",
            "structure/matrices",
            "model/element_order",
            "model/refinement",
            "model/formulation",
        ]
        .iter()
        .any(|path| given(&format!("/{path}")));
        // A reduction to an error finds its number of modes, and matrices over the jump have theirs.
        let own_modes = given("/structure/matrices") || given("/model/reduction_error");
        for ([group, name], value) in self.settings() {
            let of_mesh = ["element_order", "refinement"].contains(&name);
            if (of_mesh && own_mesh) || (name == "modes" && own_modes) {
                continue;
            }
            let Some(mut object) = scene.as_object_mut() else {
                return;
            };
            if !group.is_empty() {
                let inner = object.entry(group).or_insert_with(|| json!({}));
                match inner.as_object_mut() {
                    Some(inner) => object = inner,
                    None => return,
                }
            }
            let own = object.entry(name).or_insert(Value::Null);
            if own.is_null() {
                *own = value;
            }
        }
    }

    /// Whether no setting is coarser than the scene's, and one is finer.
    fn refines(&self, scene: &Scene) -> bool {
        let meshed = scene.structure.benchmark().is_some();
        let reduced = scene.structure.matrices().is_none();
        // The coarsest quadratic mesh is nearer to the limit than the finest linear one.
        let mesh = |order: ElementOrder, refinement: RefinementLevel| 100 * order as usize + refinement as usize;
        let pairs = [
            (
                mesh(self.element_order, self.refinement),
                mesh(scene.model.element_order, scene.model.refinement),
                meshed,
            ),
            (self.points_per_direction, scene.points_per_direction, true),
            (self.modes, scene.model.n_modes(), reduced),
            (self.vertices_per_quarter, scene.cqsma.vertices_per_quarter, true),
        ];
        let pairs = || pairs.iter().filter(|pair| pair.2);
        pairs().all(|(preset, own, _)| preset >= own) && pairs().any(|(preset, own, _)| preset > own)
    }

    /// The scene with the settings of the preset, none of them coarser than before.
    fn refine(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        if scene.structure.benchmark().is_some() {
            if scene.model.element_order != self.element_order {
                // The other order need not have the scene's formulation.
                scene.model.formulation = None;
            }
            (scene.model.element_order, scene.model.refinement) = (self.element_order, self.refinement);
        }
        if scene.structure.matrices().is_none() && scene.model.reduction_error.is_none() {
            scene.model.modes = Some(self.modes);
        }
        scene.points_per_direction = self.points_per_direction;
        scene.cqsma.vertices_per_quarter = self.vertices_per_quarter;
        scene.cqsma.tolerance = scene.cqsma.tolerance.min(self.tolerance);
        scene
    }
}

/// The scene with the settings of the cheapest preset that is finer than it in some and coarser in none of them.
///
/// # Errors
/// [`Error::NothingFiner`].
pub fn refined(scene: &Scene) -> Result<(&'static Preset, Scene), Error> {
    let finer = PRESETS
        .iter()
        .find(|preset| preset.refines(scene))
        .ok_or(Error::NothingFiner)?;
    let mut refined = finer.refine(scene);
    // A place beside the interface may be within the size of an element of the scene's mesh, and of none of the finer one.
    refined.cqsma.loops_at.clear();
    Ok((finer, refined))
}
