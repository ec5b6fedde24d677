//! `cargo xtask export`: the reduced model of a scene for other programs.

use crate::brb::{RESULTS, default_directory, read_scene};
use crate::files::{self, Output};
use crate::progress::Monitor;
use anyhow::{Context, Result};
use joint_pipeline::export::{ABOUT, arrays};
use joint_pipeline::model::MeshedStructure;
use matrix_files::value::Array;
use matrix_files::{mat, matrix_market, npz};
use std::path::{Path, PathBuf};

/// Options of `export`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Scene file [default: as for brb].
    scene: Option<PathBuf>,
    /// Input deck of the structure, in the place of the one that the scene names.
    #[arg(long, value_name = "FILE")]
    deck: Option<PathBuf>,
    /// Format: one file of all arrays, or one Matrix Market file each.
    #[arg(long, value_enum)]
    format: Format,
    /// Folder for the files [default: results/NAME-export].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Neither read nor store reduced models in results/.cache.
    #[arg(long)]
    no_cache: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// NumPy.
    Npz,
    /// MATLAB and Octave (level 5).
    Mat,
    /// Matrix Market.
    Mtx,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let scene = read_scene(arguments.scene.as_deref(), arguments.deck.as_deref())?;
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}-export", scene.name))?,
    };
    std::fs::create_dir_all(&directory).with_context(|| format!("making the folder {}", directory.display()))?;
    let monitor = Monitor::new()?;
    let structure = MeshedStructure::try_new(&scene.model, scene.bolts.behaviour, &monitor)?;
    let cache = (!arguments.no_cache).then(|| Path::new(RESULTS).join(".cache"));
    let model = structure.reduce(cache.as_deref(), &monitor)?;
    monitor.finish();
    let arrays = arrays(&model, &structure.joint)?;
    let outputs = match arguments.format {
        Format::Npz => vec![Output::new("reduced.npz", npz::to_bytes(&arrays)?)],
        Format::Mat => vec![Output::new("reduced.mat", mat::to_bytes(&arrays)?)],
        Format::Mtx => arrays
            .iter()
            .map(|(name, array)| match array {
                Array::Text(text) => Ok(Output::new(format!("{name}.txt"), text.clone())),
                numbers => Ok(Output::new(format!("{name}.mtx"), matrix_market::to_bytes(numbers)?)),
            })
            .collect::<Result<Vec<_>>>()?,
    };
    files::write_all(&directory, &outputs)?;
    let names: Vec<&str> = outputs.iter().map(|o| o.name.as_str()).collect();
    crate::print(&format!(
        "{ABOUT}\nwritten to {}: {}\n",
        directory.display(),
        names.join(", ")
    ))
}
