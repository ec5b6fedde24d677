//! The tasks of the program `validation`, with their arguments.

use clap::ValueEnum;
use microslip::commands::SceneArguments;
use microslip::files::Overwrite;
use std::path::PathBuf;

/// Tasks of the program `validation`.
#[derive(clap::Subcommand)]
pub enum Validation {
    /// Measure what every numerical setting costs and misses: errors, time and memory, setting by setting.
    Trade(Trade),
    /// Recompute the results of the method paper that need no private scan, each beside the published figure.
    Paper(Paper),
    /// Time interface, solver and reduction in one run: ratios between them, not times, are what to compare.
    Bench(Bench),
    /// Run scenes in hostile but finite situations, and check that each does what it must.
    Extremes(Extremes),
    /// Compute what the documents quote, and record it with date and commit: an hour and more.
    Validate(Validate),
    /// Make what people without Rust need: program, Python package, documents and checksums.
    Dist(Dist),
}

/// Arguments of `validate`.
#[derive(clap::Args)]
pub struct Validate {
    /// Reports to compute [default: all].
    #[arg(long, value_name = "REPORT", num_args = 1..)]
    only: Vec<Report>,
    /// Folder for the results of the tasks, with a folder for each commit.
    #[arg(long, value_name = "DIR", default_value = "results/validation")]
    pub out: PathBuf,
    /// Folder of the records, a file for each report. Tests compare the documents with those of the checkout.
    #[arg(long, value_name = "DIR", default_value = "fixtures/validation")]
    pub record: PathBuf,
}

impl Validate {
    /// What is asked for.
    pub fn reports(&self) -> Vec<Report> {
        match self.only.as_slice() {
            [] => Report::value_variants().to_vec(),
            only => only.to_vec(),
        }
    }
}

/// A report that the documents quote.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Report {
    /// Masses and frequencies of the built-in scenes.
    Scenes,
    /// `cargo xtask extremes`.
    Extremes,
    /// `cargo xtask paper`.
    Paper,
    /// `cargo xtask trade`.
    Trade,
    /// What tests can be compared with: bands from uncertain inputs.
    Tests,
}

impl Report {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scenes => "scenes",
            Self::Extremes => "extremes",
            Self::Paper => "paper",
            Self::Trade => "trade",
            Self::Tests => "tests",
        }
    }
}

/// Arguments of `trade`.
#[derive(clap::Args)]
pub struct Trade {
    /// The scene whose settings are varied; without it the built-in scene brb-flat.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Settings to measure, such as mesh [default: all].
    #[arg(long, value_name = "NAME", num_args = 1..)]
    pub only: Vec<String>,
    /// Files of the scene's mesh, from coarse to fine, where it comes as a file.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub meshes: Vec<PathBuf>,
    /// A coarse mesh and only what takes seconds on it, for a look.
    #[arg(long)]
    pub quick: bool,
    /// Folder for the results and the runs, made if missing; finished runs of the same settings found there are kept.
    #[arg(long, value_name = "DIR", default_value = "results/trade")]
    pub out: PathBuf,
    /// Whether results of something else are replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
}

/// Arguments of `paper`.
#[derive(clap::Args)]
pub struct Paper {
    /// Entries to compute [default: all].
    #[arg(long, value_name = "ID", num_args = 1..)]
    pub only: Vec<String>,
    /// Folder for the results, made if missing; other files in it are left alone.
    #[arg(long, value_name = "DIR", default_value = "results/paper")]
    pub out: PathBuf,
    /// Whether results of something else are replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
    /// Neither read nor store reduced models and finished scenes in results/.cache.
    #[arg(long)]
    pub no_cache: bool,
    /// A coarse mesh and few amplitudes, for a look: the figures are not those of the paper's mesh.
    #[arg(long)]
    pub quick: bool,
}

/// Arguments of `bench`.
#[derive(clap::Args)]
pub struct Bench {
    /// Write the figures to this file as well.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Instead, how the cost grows with the number of interface elements and of points per element: some ten minutes.
    #[arg(long)]
    pub scaling: bool,
    /// Instead, free periodic motions by harmonic balance: a minute.
    #[arg(long, conflicts_with = "scaling")]
    pub periodic: bool,
    /// Draw what `--scaling` measured (SVG).
    #[arg(long, value_name = "FILE", requires = "scaling")]
    pub plot: Option<PathBuf>,
}

/// Arguments of `extremes`.
#[derive(clap::Args)]
pub struct Extremes {
    /// On the mesh of the default scene instead of the coarse one.
    #[arg(long)]
    pub full: bool,
    /// Only these cases.
    #[arg(long, value_name = "NAME", num_args = 1..)]
    pub only: Vec<String>,
    /// Folder for extremes.json, made if missing.
    #[arg(long, value_name = "DIR", default_value = "results/extremes")]
    pub out: PathBuf,
    /// Whether results of something else are replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
}

/// Arguments of `dist`.
#[derive(clap::Args)]
pub struct Dist {
    /// Only what needs no compilation: manual pages, completions, licences, list of components and text of the release.
    #[arg(long)]
    pub only_text: bool,
    /// First check that every crate can be published, as far as that can be known without doing so: minutes.
    #[arg(long, conflicts_with = "only_text")]
    pub packages: bool,
    /// Folder for the files, made if missing.
    #[arg(long, value_name = "DIR", default_value = "results/dist")]
    pub out: PathBuf,
    /// Whether results of something else are replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
}
