//! The benchmarks that programs embed.

use crate::Error;
use brake_reuss_beam::BrakeReussBenchmark;
use joint_model::Benchmark;
use scenes::Scene;

/// All of them; a new one is a row here.
pub static BENCHMARKS: [&dyn Benchmark; 1] = [&BrakeReussBenchmark];

/// The benchmark of a name or a short name.
pub fn find(name: &str) -> Option<&'static dyn Benchmark> {
    let mut known = BENCHMARKS.iter().copied();
    known.find(|known| known.name() == name || known.short_name() == name)
}

/// Name and text of a scene that comes with a benchmark: `NAME` for its first one, or `NAME/SCENE`.
///
/// # Errors
/// [`Error::NoBenchmark`], [`Error::NoScene`].
pub fn scene_text(name: &str) -> Result<(&'static str, &'static str), Error> {
    let list = |names: Vec<&str>| names.join(", ");
    let (benchmark, scene) = match name.split_once('/') {
        Some((benchmark, scene)) => (benchmark, Some(scene)),
        None => (name, None),
    };
    let benchmark = find(benchmark).ok_or_else(|| Error::NoBenchmark {
        name: benchmark.into(),
        known: list(BENCHMARKS.iter().map(|known| known.name()).collect()),
    })?;
    let scenes = benchmark.scenes();
    let found = match scene {
        None => scenes.first(),
        Some(wanted) => scenes.iter().find(|(name, _)| *name == wanted),
    };
    found.copied().ok_or_else(|| Error::NoScene {
        benchmark: benchmark.name(),
        name: scene.unwrap_or_default().into(),
        known: list(scenes.iter().map(|(name, _)| *name).collect()),
    })
}

/// The scene of a name that comes with a benchmark.
///
/// # Errors
/// Those of [`Scene::from_json`].
pub fn read(name: &str, text: &str) -> Result<Scene, scenes::Error> {
    Scene::from_json(text, &format!("the built-in scene {name}"), name, &BENCHMARKS)
}
