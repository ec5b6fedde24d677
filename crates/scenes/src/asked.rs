//! Which of the analyses that a scene asks for are wanted.

use super::parameter_values::understood;
use super::scene::Scene;
use crate::Error;
use serde_json::{Value, json};

/// What all results depend on.
const ALWAYS: [&str; 2] = ["modes", "tightening"];

impl Scene {
    /// The scene with some of the analyses that it asks for, by the names of their blocks. Bolts are tightened as it says all the same; with
    /// `sensitivities` and `random` goes the backbone that they belong to.
    ///
    /// # Errors
    /// [`Error::NotAsked`] for the name of none that it asks for.
    pub fn only(&self, names: &[String]) -> Result<Self, Error> {
        let mut scene = self.encoded()?;
        let Some(analyses) = scene.get_mut("analyses").and_then(Value::as_object_mut) else {
            return Ok(self.clone());
        };
        let has_loops = self.analyses.backbone.amplitudes > 0;
        let asked: Vec<&String> = analyses
            .keys()
            .filter(|name| has_loops || *name != "backbone")
            .collect();
        if let Some(unknown) = names.iter().find(|name| !asked.contains(name)) {
            return Err(Error::NotAsked {
                name: unknown.clone(),
                asked: asked.into_iter().map(String::as_str).collect::<Vec<_>>().join(", "),
            });
        }
        let is_named = |name: &str| names.iter().any(|named| named == name);
        let keeps_loops = is_named("backbone") || is_named("sensitivities") || is_named("random");
        // Of the backbone, settings that the static state has too are kept.
        analyses.retain(|name, _| ALWAYS.contains(&name.as_str()) || name == "backbone" || is_named(name));
        if !keeps_loops {
            let backbone = &mut analyses["backbone"];
            (backbone["amplitudes"], backbone["methods"], backbone["loops_at"]) = (json!(0), json!([]), json!([]));
            scene["output"]["fields_at"] = Value::Null;
        }
        understood(self, scene)
    }
}
