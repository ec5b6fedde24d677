//! Scenes.

use crate::error::Exception;
use host::{BENCHMARKS, GivenScene};
use pyo3::prelude::*;
use scenes::Scene as LibraryScene;
use std::path::PathBuf;

/// A scene that was checked, in SI.
#[pyclass(frozen, module = "microslip._native")]
pub(crate) struct Scene(pub(crate) GivenScene);

#[pymethods]
impl Scene {
    /// The scene in a file.
    #[staticmethod]
    #[pyo3(signature = (path: "str") -> "Scene")]
    fn from_file(py: Python<'_>, path: PathBuf) -> Result<Self, Exception> {
        Ok(Self(py.detach(|| GivenScene::of_file(&path, &|_| {}))?))
    }

    /// The scene in a text, of which relative paths start from a folder; errors name `place`.
    #[staticmethod]
    #[pyo3(signature = (text: "str", place: "str", name: "str", directory: "str | None") -> "Scene")]
    fn from_json(text: &str, place: &str, name: &str, directory: Option<PathBuf>) -> Result<Self, Exception> {
        let mut scene = LibraryScene::from_json(text, place, name, &BENCHMARKS)?;
        if let Some(directory) = directory {
            scene.resolve(&directory);
        }
        Ok(Self(GivenScene { scene, source: None }))
    }

    /// A scene that comes with a benchmark.
    #[staticmethod]
    fn benchmark(name: &str) -> Result<Self, Exception> {
        Ok(Self(GivenScene::of_benchmark(name)?))
    }

    /// What `state` gave.
    #[staticmethod]
    fn from_state(scene: &str, source: &str) -> Result<Self, Exception> {
        let value = serde_json::from_str(scene)?;
        let scene = LibraryScene::from_summary(&value, &BENCHMARKS)?;
        scene.validate(&scene.name)?;
        Ok(Self(GivenScene {
            scene,
            source: serde_json::from_str(source)?,
        }))
    }

    /// The scene with all defaults, and the file that it is from, as JSON.
    fn state(&self) -> Result<(String, String), Exception> {
        let scene = serde_json::to_string(&self.0.scene)?;
        Ok((scene, serde_json::to_string(&self.0.source)?))
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.scene.name
    }
}

/// Names of the scenes that come with the package, as `BENCHMARK/SCENE`.
#[pyfunction]
pub(crate) fn benchmarks() -> Vec<String> {
    let of = |known: &&dyn joint_model::Benchmark| {
        let benchmark = known.name();
        let scenes = known.scenes().iter();
        scenes
            .map(|(scene, _)| format!("{benchmark}/{scene}"))
            .collect::<Vec<_>>()
    };
    BENCHMARKS.iter().flat_map(of).collect()
}
