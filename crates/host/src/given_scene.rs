//! A scene and where it is from.

use crate::{BENCHMARKS, Error, benchmarks};
use analyses::results::provenance::{Input, InputRole, inputs_of};
use scenes::Scene;
use serde_json::Value;
use std::path::Path;

/// A scene and where it is from.
#[derive(Clone, Debug)]
pub struct GivenScene {
    /// The scene, in SI.
    pub scene: Scene,
    /// Its file, as it was read; none for a scene that was made by a program.
    pub source: Option<Input>,
}

impl GivenScene {
    /// The scene of a file; `fill` sees it before it is understood, see [`Scene::read_filled`].
    ///
    /// # Errors
    /// [`Error::Scene`].
    pub fn of_file(path: &Path, fill: &dyn Fn(&mut Value)) -> Result<Self, Error> {
        Ok(Self {
            // The error of a scene that cannot be read comes first.
            scene: Scene::read_filled(path, &BENCHMARKS, fill)?,
            source: Some(Input::of_file(InputRole::Scene, path)?),
        })
    }

    /// A scene that comes with a benchmark: `NAME` for its first one, or `NAME/SCENE`.
    ///
    /// # Errors
    /// [`Error::NoBenchmark`], [`Error::NoScene`].
    pub fn of_benchmark(name: &str) -> Result<Self, Error> {
        let (name, text) = benchmarks::scene_text(name)?;
        Self::built_in(name, text)
    }

    /// A scene that comes with a program, by its name and its text.
    ///
    /// # Errors
    /// [`Error::Scene`].
    pub fn built_in(name: &str, text: &str) -> Result<Self, Error> {
        Ok(Self {
            scene: benchmarks::read(name, text)?,
            source: Some(Input::of_built_in_scene(name, text)),
        })
    }

    /// All files that a run of the scene reads, as they stand.
    ///
    /// # Errors
    /// [`Error::Scene`] for a file that cannot be read.
    pub fn inputs(&self) -> Result<Vec<Input>, Error> {
        let mut inputs: Vec<Input> = self.source.iter().cloned().collect();
        inputs.extend(inputs_of(&self.scene)?);
        Ok(inputs)
    }
}
