//! The benchmarks that the program embeds.

use brake_reuss_beam::BrakeReussBenchmark;
use joint_pipeline::{Benchmark, Error, Scene};

/// All of them; a new one is a row here.
pub static BENCHMARKS: [&dyn Benchmark; 1] = [&BrakeReussBenchmark];

/// A scene that comes with a benchmark: the first one, or that of a name.
///
/// # Errors
/// A name that the benchmark has no scene of, in words.
pub fn scene_text(
    benchmark: &'static dyn Benchmark,
    scene: Option<&str>,
) -> Result<(&'static str, &'static str), String> {
    let scenes = benchmark.scenes();
    let found = match scene {
        None => scenes.first(),
        Some(wanted) => scenes.iter().find(|(name, _)| *name == wanted),
    };
    found.copied().ok_or_else(|| {
        let names: Vec<&str> = scenes.iter().map(|(name, _)| *name).collect();
        format!(
            "{} has no scene `{}`; it has {}",
            benchmark.name(),
            scene.unwrap_or_default(),
            names.join(", ")
        )
    })
}

/// The scene of a name that comes with a benchmark.
///
/// # Errors
/// Those of [`Scene::from_json`].
pub fn read(name: &str, text: &str) -> Result<Scene, Error> {
    Scene::from_json(text, &format!("the built-in scene {name}"), name, &BENCHMARKS)
}
