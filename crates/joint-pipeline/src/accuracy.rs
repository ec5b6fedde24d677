//! How exact a scene asks to be: settings chosen by their measured errors.
//!
//! [`RUNGS`] are whole sets of numerical settings, each with the sum of the errors that `cargo xtask trade` measured for its
//! mesh, points and vertices on the flat beam against finer computations of the same model. A scene that asks for an accuracy gets the settings of
//! a rung wherever it does not give its own.

use crate::comparison::Backbone;
use crate::scene::{RefinementName, Scene};
use crate::{Error, Run, transient};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// A set of numerical settings and what it was measured to cost and to miss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rung {
    /// Name.
    pub name: &'static str,
    /// Block mesh; without effect where a deck or matrices replace it.
    pub refinement: RefinementName,
    /// Quadrature points per direction of an interface element.
    pub points_per_direction: usize,
    /// Stuck-interface modes retained by the reduction.
    pub modes: usize,
    /// Vertices per quarter loop.
    pub vertices_per_quarter: usize,
    /// Residual relative to the load.
    pub tolerance: f64,
    /// Largest relative error of the frequency, of the linearised mode and at amplitudes of 5e-5, 2e-4 and 6e-4 m.
    pub frequency_error: f64,
    /// Largest error of the logarithm of the damping ratio at these amplitudes.
    pub damping_error: f64,
    /// Time relative to that of `standard`.
    pub cost: f64,
}

/// From the cheapest to the finest. Errors are against the finest mesh (2352 interface elements), which is not the limit of
/// the mesh either, and rounded up.
pub static RUNGS: [Rung; 4] = [
    Rung {
        name: "draft",
        refinement: RefinementName::Quick,
        points_per_direction: 2,
        modes: 10,
        vertices_per_quarter: 4,
        tolerance: 1e-5,
        frequency_error: 1.8e-2,
        damping_error: 0.065,
        cost: 0.1,
    },
    Rung {
        name: "coarse",
        refinement: RefinementName::Coarse,
        points_per_direction: 2,
        modes: 10,
        vertices_per_quarter: 8,
        tolerance: 1e-7,
        frequency_error: 1.2e-2,
        damping_error: 0.05,
        cost: 0.3,
    },
    Rung {
        name: "standard",
        refinement: RefinementName::Default,
        points_per_direction: 2,
        modes: 20,
        vertices_per_quarter: 8,
        tolerance: 1e-9,
        frequency_error: 8e-3,
        damping_error: 0.025,
        cost: 1.0,
    },
    Rung {
        name: "reference",
        refinement: RefinementName::Fine,
        points_per_direction: 3,
        modes: 20,
        vertices_per_quarter: 32,
        tolerance: 1e-9,
        frequency_error: 3.5e-3,
        damping_error: 0.01,
        cost: 5.0,
    },
];

/// What a scene may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "`accuracy` is \"draft\", \"standard\", \"reference\", or the errors that are borne, such as {\"damping\": 0.02}"
)]
pub enum Accuracy {
    /// A rung by its name.
    Level(Level),
    /// The cheapest rung whose measured errors are not larger.
    Target(Target),
}

/// Rungs that have a name in scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// The cheapest.
    Draft,
    /// What scenes get that ask for nothing.
    Standard,
    /// The finest.
    Reference,
}

/// Errors that are borne.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Target {
    /// Relative error of frequencies.
    pub frequency: Option<f64>,
    /// Error of the logarithm of damping ratios.
    pub damping: Option<f64>,
}

impl Accuracy {
    /// The rung that is asked for.
    ///
    /// # Errors
    /// What no rung reaches, or what is no error to ask for, in words.
    pub fn rung(&self) -> Result<&'static Rung, String> {
        let target = match self {
            Self::Level(level) => {
                let name = match level {
                    Level::Draft => "draft",
                    Level::Standard => "standard",
                    Level::Reference => "reference",
                };
                return RUNGS
                    .iter()
                    .find(|rung| rung.name == name)
                    .ok_or_else(|| format!("there is no rung {name}"));
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
        let meets = |rung: &&Rung| {
            target.frequency.is_none_or(|wanted| rung.frequency_error <= wanted)
                && target.damping.is_none_or(|wanted| rung.damping_error <= wanted)
        };
        RUNGS.iter().find(meets).ok_or_else(|| {
            let finest = &RUNGS[RUNGS.len() - 1];
            format!(
                "no measured set of settings is within the accuracy asked for; the finest has the errors {} in frequency \
                 and {} in the logarithm of damping",
                finest.frequency_error, finest.damping_error
            )
        })
    }
}

impl Rung {
    /// Where a scene file has the settings, and their values.
    fn settings(&self) -> [([&'static str; 2], Value); 5] {
        [
            (["model", "refinement"], json!(self.refinement)),
            (["", "points_per_direction"], json!(self.points_per_direction)),
            (["model", "modes"], json!(self.modes)),
            (["cqsma", "vertices_per_quarter"], json!(self.vertices_per_quarter)),
            (["cqsma", "tolerance"], json!(self.tolerance)),
        ]
    }

    /// Writes the settings into a scene file where it has none of its own.
    pub(crate) fn fill(&self, scene: &mut Value) {
        let given = |path: &str| scene.pointer(path).is_some_and(|value| !value.is_null());
        let imported = given("/model/deck") || given("/model/matrices");
        // A reduction to an error finds its number of modes, and matrices over the jump have theirs.
        let own_modes = given("/model/matrices") || given("/model/reduction_error");
        for ([group, name], value) in self.settings() {
            if (name == "refinement" && imported) || (name == "modes" && own_modes) {
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
        let meshed = scene.model.deck.is_none() && scene.model.matrices.is_none();
        let pairs = [
            (self.refinement as usize, scene.model.refinement as usize, meshed),
            (self.points_per_direction, scene.points_per_direction, true),
            (self.modes, scene.model.n_modes(), scene.model.matrices.is_none()),
            (self.vertices_per_quarter, scene.cqsma.vertices_per_quarter, true),
        ];
        let pairs = || pairs.iter().filter(|pair| pair.2);
        pairs().all(|(rung, own, _)| rung >= own) && pairs().any(|(rung, own, _)| rung > own)
    }

    /// The scene with the settings of the rung, none of them coarser than before.
    fn refine(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        if scene.model.deck.is_none() && scene.model.matrices.is_none() {
            scene.model.refinement = self.refinement;
        }
        if scene.model.matrices.is_none() && scene.model.reduction_error.is_none() {
            scene.model.modes = Some(self.modes);
        }
        scene.points_per_direction = self.points_per_direction;
        scene.cqsma.vertices_per_quarter = self.vertices_per_quarter;
        scene.cqsma.tolerance = scene.cqsma.tolerance.min(self.tolerance);
        scene
    }
}

/// The scene with the settings of the cheapest rung that is finer than it in some and coarser in none of them.
///
/// # Errors
/// [`Error::NothingFiner`].
pub fn refined(scene: &Scene) -> Result<(&'static Rung, Scene), Error> {
    let finer = RUNGS
        .iter()
        .find(|rung| rung.refines(scene))
        .ok_or(Error::NothingFiner)?;
    Ok((finer, finer.refine(scene)))
}

/// Differences between a run and one with finer settings: an estimate of the errors of the first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorEstimate {
    /// The settings of the finer run.
    pub finer: &'static str,
    /// Relative difference of the linearised frequency of the mode followed.
    pub linear_frequency: f64,
    /// Largest relative difference of the frequency at amplitudes common to both.
    pub frequency: Option<f64>,
    /// Largest difference of the logarithm of the damping ratio there.
    pub damping: Option<f64>,
}

impl ErrorEstimate {
    /// Compares a run with one of the scene that [`refined`] gave.
    pub fn new(run: &Run, finer: &'static Rung, fine: &Run) -> Self {
        let mode = run.scene.cqsma.mode - 1;
        let cqsma = |run| -> Option<Backbone> { Some(transient::backbones(run).ok()?.swap_remove(0).1) };
        let misfit = cqsma(run).zip(cqsma(fine)).and_then(|(own, fine)| own.misfit(&fine));
        Self {
            finer: finer.name,
            linear_frequency: run.frequencies[mode] / fine.frequencies[mode] - 1.0,
            frequency: misfit.map(|misfit| misfit.frequency_percent.largest / 100.0),
            damping: misfit.and_then(|misfit| Some(misfit.damping_ln?.largest)),
        }
    }
}

/// What a refinement converges to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extrapolation {
    /// Power of the step that the error goes with.
    pub order: f64,
    /// Value at step zero.
    pub limit: f64,
}

/// Richardson's extrapolation from three descending step sizes that need not have a constant ratio: `value = limit +
/// constant * size^order`. None where the values do not approach a limit monotonically with an order between 0.1 and 12.
pub fn extrapolate(sizes: [f64; 3], values: [f64; 3]) -> Option<Extrapolation> {
    let [a, b, c] = sizes;
    if !(a > b && b > c && c > 0.0) {
        return None;
    }
    let wanted = (values[0] - values[1]) / (values[1] - values[2]);
    // Grows with the order, from ln(a/b) / ln(b/c) without bounds.
    let ratio = |p: f64| ((a / b).powf(p) - 1.0) / (1.0 - (c / b).powf(p));
    let (mut low, mut high) = (0.1, 12.0);
    if !(ratio(low) <= wanted && wanted <= ratio(high)) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    let order = 0.5 * (low + high);
    let constant = (values[1] - values[2]) / (b.powf(order) - c.powf(order));
    Some(Extrapolation {
        order,
        limit: values[2] - constant * c.powf(order),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_refinements_are_found() {
        let sizes = [1.0 / 12.0, 1.0 / 24.0, 1.0 / 34.0];
        for order in [0.5, 1.0, 2.0, 3.7] {
            let found = extrapolate(sizes, sizes.map(|h| 168.0 + 3.0 * h.powf(order))).unwrap();
            assert!(
                (found.order - order).abs() < 1e-6 && (found.limit - 168.0).abs() < 1e-8,
                "{found:?}"
            );
        }
        assert!(extrapolate(sizes, [1.0, 2.0, 1.5]).is_none(), "not monotone");
        assert!(extrapolate(sizes, [1.0, 2.0, 4.0]).is_none(), "not converging");
        assert!(extrapolate(sizes, [1.0; 3]).is_none());
        assert!(extrapolate([1.0, 2.0, 3.0], [1.0, 2.0, 2.5]).is_none());
    }

    #[test]
    fn the_cheapest_rung_within_a_target_is_chosen() {
        for pair in RUNGS.windows(2) {
            assert!(pair[0].cost < pair[1].cost && pair[0].damping_error >= pair[1].damping_error);
            assert!(pair[0].frequency_error >= pair[1].frequency_error);
        }
        let of = |frequency, damping| Accuracy::Target(Target { frequency, damping }).rung();
        for (index, rung) in RUNGS.iter().enumerate() {
            assert_eq!(of(None, Some(rung.damping_error)).unwrap().name, rung.name);
            if index > 0 {
                let slightly_more = RUNGS[index - 1].damping_error * 0.999;
                assert_eq!(of(None, Some(slightly_more)).unwrap().name, rung.name);
            }
        }
        assert!(of(None, Some(1e-9)).unwrap_err().contains("finest"));
        assert!(of(Some(-1.0), None).unwrap_err().contains("accuracy.frequency"));
        assert!(of(None, None).unwrap_err().contains("empty"));
    }

    #[test]
    fn scenes_get_the_settings_that_they_do_not_give() {
        let read = |rest: &str| {
            let text = format!(r#"{{"units": {{"length": "mm", "mass": "t", "time": "s"}}, {rest}}}"#);
            Scene::from_json(&text, "test", "test")
        };
        let draft = &RUNGS[0];
        let scene = read(r#""accuracy": "draft""#).unwrap();
        assert_eq!(
            (scene.model.refinement, scene.points_per_direction),
            (draft.refinement, draft.points_per_direction)
        );
        assert_eq!(
            scene.model.material,
            crate::scene::Material::default(),
            "nothing else changes"
        );
        let own = read(r#""accuracy": "draft", "points_per_direction": 3, "cqsma": {"amplitude_to": 1.0}"#).unwrap();
        assert_eq!(own.points_per_direction, 3);
        assert_eq!(own.cqsma.vertices_per_quarter, draft.vertices_per_quarter);
        assert!((own.cqsma.amplitude_to - 1e-3).abs() < 1e-15);
        // The standard is what scenes get that ask for nothing.
        let standard = read(r#""accuracy": "standard""#).unwrap();
        let mut nothing = read(r#""mu": 0.2"#).unwrap();
        nothing.accuracy = standard.accuracy;
        nothing.model.modes = standard.model.modes;
        assert_eq!((nothing.model.n_modes(), &nothing), (20, &standard));
        let again = Scene::from_json(&serde_json::to_string(&own).unwrap(), "test", "test").unwrap();
        assert_eq!(again, own, "a scene with its settings filled in stays as it is");
        for wrong in [
            r#""accuracy": "best""#,
            r#""accuracy": {"speed": 1}"#,
            r#""accuracy": {"damping": 1e-9}"#,
        ] {
            assert!(read(wrong).unwrap_err().to_string().contains("ccuracy"), "{wrong}");
        }
    }

    #[test]
    fn finer_settings_are_finer_in_something_and_coarser_in_nothing() {
        let standard = Scene::new("standard");
        let (rung, fine) = refined(&standard).unwrap();
        assert_eq!(rung.name, "reference");
        assert!(fine.model.refinement as usize > standard.model.refinement as usize);
        let mut vertices = standard.clone();
        vertices.model.refinement = RefinementName::Quick;
        vertices.model.modes = Some(10);
        assert_eq!(refined(&vertices).unwrap().0.name, "coarse");
        vertices.cqsma.vertices_per_quarter = 4096;
        assert!(matches!(refined(&vertices), Err(Error::NothingFiner)));
    }
}
