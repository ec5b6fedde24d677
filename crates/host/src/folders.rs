//! Folders of the user, and of results.

use etcetera::base_strategy::BaseStrategy;
use file_io::durable::Identity;
use scenes::{Scene, StructureSource};
use std::path::{Path, PathBuf};

/// The folder `microslip` among the user's caches; none for a user without a home.
pub fn user_cache() -> Option<PathBuf> {
    let folders = etcetera::base_strategy::choose_native_strategy().ok()?;
    Some(folders.cache_dir().join("microslip"))
}

/// What a command computes for a scene: results of scenes of the same name on the same structure replace one another.
pub fn results_of(command: &str, scene: &Scene) -> Identity {
    let file = |path: &Path| {
        path.file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    };
    let structure = match &scene.structure.source {
        StructureSource::Benchmark(benchmark) => benchmark.name().to_owned(),
        StructureSource::Deck(deck) => file(&deck.path),
        StructureSource::Mesh(mesh) => file(&mesh.path),
        StructureSource::Matrices(matrices) => file(&matrices.path),
    };
    Identity::new(command, format!("{} on {structure}", scene.name))
}
