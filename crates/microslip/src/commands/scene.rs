//! Which scene a command works on.

use super::defaults::Defaults;
use anyhow::{Result, bail};
use finite_elements::formats::abaqus::Includes;
use finite_elements::formats::solid_mesh::Format;
use host::{BENCHMARKS, GivenScene};
use joint_model::Benchmark;
use scenes::StructureSource;
use serde_json::{Value, json};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The scene that a command works on.
#[derive(clap::Args)]
pub struct SceneArguments {
    /// Scene file; of `model` also a mesh or an input deck, of `export` also the folder of a run.
    scene: Option<PathBuf>,
    /// A scene that comes with the program: NAME of a benchmark for its first scene, or NAME/SCENE (`microslip benchmarks` lists them).
    #[arg(long, value_name = "NAME", conflicts_with = "scene")]
    benchmark: Option<String>,
    /// Input deck of the structure, in the place of the one that the scene names.
    #[arg(long, value_name = "FILE")]
    deck: Option<PathBuf>,
    /// Let the deck include files outside its folder.
    #[arg(long)]
    allow_includes_outside: bool,
}

impl SceneArguments {
    /// Whether it asks for anything of a deck.
    pub(super) fn asks_of_deck(&self) -> bool {
        self.deck.is_some() || self.allow_includes_outside
    }

    /// What stands in the place of the scene.
    pub fn path(&self) -> Option<&Path> {
        self.scene.as_deref()
    }

    /// What stands in the place of the scene, if it is none: a mesh or an input deck.
    pub fn mesh_file(&self) -> Option<&Path> {
        self.scene.as_deref().filter(|path| is_mesh(path))
    }

    /// The scene, in SI, and the file that it is from.
    ///
    /// # Errors
    /// No scene is named; it cannot be read or is not admissible; it has no deck to be replaced.
    pub fn read(&self, defaults: &Defaults) -> Result<GivenScene> {
        if let Some(path) = self.mesh_file() {
            bail!(
                "{} is no scene; if it is a mesh, make a scene of it: microslip new --from {} --length UNIT DIRECTORY",
                path.display(),
                path.display()
            );
        }
        let mut given = match (&self.scene, &self.benchmark) {
            (None, None) => default_scene(self.deck.is_some(), defaults)?,
            (path, name) => read(path.as_deref(), name.as_deref(), defaults)?,
        };
        if let Some(path) = &self.deck {
            let StructureSource::Deck(deck) = &mut given.scene.structure.source else {
                bail!(
                    "the scene {} has no structure.deck to say which surfaces and bolts of {} to take",
                    given.scene.name,
                    path.display()
                )
            };
            deck.path = path.clone();
        }
        if self.allow_includes_outside {
            let StructureSource::Deck(deck) = &mut given.scene.structure.source else {
                bail!(
                    "the scene {} has no structure.deck whose includes could be outside its folder; leave out --allow-includes-outside",
                    given.scene.name
                )
            };
            deck.includes = Includes::Anywhere;
        }
        Ok(given)
    }
}

/// Whether a file is a mesh or an input deck, and no scene. A scene may have any name, and begins with a brace or a comment. What is no file is refused
/// by who reads it.
pub(super) fn is_mesh(path: &Path) -> bool {
    if Format::of(path).is_ok() {
        return true;
    }
    if !path.is_file() {
        return false;
    }
    let mut first = [0; 256];
    let read = std::fs::File::open(path).and_then(|mut file| file.read(&mut first));
    let first = first[..read.unwrap_or(0)].trim_ascii_start();
    !(first.is_empty() || first.starts_with(b"{") || first.starts_with(b"/"))
}

/// The scene of a file, or one that comes with a benchmark, or else the first scene of the default benchmark.
pub(super) fn read(path: Option<&Path>, benchmark: Option<&str>, defaults: &Defaults) -> Result<GivenScene> {
    match (path, benchmark) {
        (Some(path), _) => read_file(path, defaults),
        (None, Some(name)) => Ok(GivenScene::of_benchmark(name)?),
        (None, None) => default_scene(false, defaults),
    }
}

/// The first scene of the benchmark that commands work on by default, or the first of its scenes that reads a deck.
fn default_scene(on_deck: bool, defaults: &Defaults) -> Result<GivenScene> {
    let Some(benchmark) = defaults.benchmark else {
        bail!("no scene is given: name a scene file, or a benchmark by --benchmark");
    };
    for (name, text) in benchmark.scenes() {
        let given = GivenScene::built_in(name, text)?;
        if given.scene.structure.deck().is_some() == on_deck {
            return Ok(given);
        }
    }
    bail!("{} has no scene that reads a deck; give a scene file", benchmark.name())
}

/// The scene of a file; one that names no structure is on the default benchmark, if there is one.
fn read_file(path: &Path, defaults: &Defaults) -> Result<GivenScene> {
    Ok(GivenScene::of_file(path, &|scene| fill(scene, defaults))?)
}

/// Puts a scene that names no structure on the default benchmark, if there is one.
pub(super) fn fill(scene: &mut Value, defaults: &Defaults) {
    let benchmark = defaults.benchmark.map(Benchmark::name);
    if let (Some(name), Some(scene)) = (benchmark, scene.as_object_mut()) {
        scene.entry("structure").or_insert_with(|| json!({ "benchmark": name }));
    }
}

/// What `microslip benchmarks` prints.
pub(super) fn list() -> String {
    let mut out = String::new();
    for benchmark in BENCHMARKS {
        out += &format!("{}  {}\n", benchmark.name(), benchmark.title());
        for (name, _) in benchmark.scenes() {
            out += &format!("  {}/{name}\n", benchmark.name());
        }
    }
    out
}
