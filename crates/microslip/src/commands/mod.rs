//! The commands of the program, for its binary and for others that offer them too.

mod calibrate;
mod characterise;
mod compare;
mod export;
mod forced;
mod identify;
mod model;
mod new;
pub mod run;
mod samples;
mod scene;
mod schema;
mod study;
mod transient;
mod verify;
mod view;

use crate::text;
use anyhow::{Context, Result, bail};
pub use host::GivenScene;
use host::{free_memory, provenance};
use joint_model::Benchmark;
use joints::Options;
pub use scene::SceneArguments;
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::process::ExitCode;

/// Folder of all results, under the current one.
pub const RESULTS: &str = "results";

/// What the exit codes mean, for the help texts.
pub const EXIT_CODES: &str = "Exit codes:
  0  success
  1  error: bad scene, failed check, unreadable or unwritable file
  2  wrong arguments
  3  the run finished and its outputs were written, but some amplitudes did not converge or a forced response ended early";

/// Commands beside `run`.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Describe the structure of a scene: size, mass and, with `--spectrum`, frequencies with linear interfaces.
    Model(model::Arguments),
    /// Write the reduced model of a scene for other programs: NumPy, MATLAB and Octave, Matrix Market.
    Export(export::Arguments),
    /// Frequency and damping against amplitude from measured ring-downs; several files are hits to be averaged.
    Identify(identify::Arguments),
    /// Characterise two scans over an interface: gaps, roughness, asperities and traction laws with bands per element.
    Characterise(characterise::Arguments),
    /// Follow the ring-down of a scene in time, identify it, and lay it over the quasi-static backbones.
    Transient(transient::Arguments),
    /// Compute the response of a scene to harmonic forces against frequency, level by level.
    #[command(after_help = EXIT_CODES)]
    Forced(forced::Arguments),
    /// Lay a run over measured backbones at the same response point: misfit in frequency and damping.
    Compare(compare::Arguments),
    /// Find numbers of a scene by least squares on measured backbones, with priors, standard errors and what cannot be identified.
    #[command(after_help = EXIT_CODES)]
    Calibrate(calibrate::Arguments),
    /// Run hundreds to thousands of variants of a scene by a plan, here or by a batch system, and tabulate them; what is finished is kept.
    #[command(after_help = EXIT_CODES)]
    Study(study::Arguments),
    /// Show runs beside each other in a browser on this computer, until Ctrl-C ends it.
    View(view::Arguments),
    /// Check that results are as they were written, and within the bounds of sound results; with `--rerun` compute them again.
    Verify(verify::Arguments),
    /// Write a commented scene to start from, or with `--benchmark` a bolted structure with the script that makes its mesh.
    New(new::Arguments),
    /// Write small files to try the commands with: scans, ring-downs, a deck and a mesh with scenes.
    Samples(samples::Arguments),
    /// List the benchmarks that scenes may name, with the scenes that come with them.
    Benchmarks,
    /// Print the JSON Schema of scenes, of summaries or of plans.
    Schema(schema::Arguments),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Whatever stops it: a bad scene, a file that cannot be read or written, a solver that gives up.
    pub fn run(&self, defaults: &Defaults) -> Result<Outcome> {
        let done = match self {
            Self::Model(arguments) => model::run(arguments, defaults),
            Self::Export(arguments) => export::run(arguments, defaults),
            Self::Identify(arguments) => identify::run(arguments),
            Self::Characterise(arguments) => characterise::run(arguments, defaults),
            Self::Transient(arguments) => transient::run(arguments, defaults),
            Self::Forced(arguments) => return forced::run(arguments, defaults),
            Self::Compare(arguments) => compare::run(arguments),
            Self::Calibrate(arguments) => return calibrate::run(arguments, defaults),
            Self::Study(arguments) => return study::run(arguments, defaults),
            Self::View(arguments) => view::run(arguments),
            Self::Verify(arguments) => verify::run(arguments),
            Self::New(arguments) => new::run(arguments),
            Self::Samples(arguments) => samples::run(arguments),
            Self::Benchmarks => print(&scene::list()),
            Self::Schema(arguments) => schema::run(arguments),
        };
        done.map(|()| Outcome::Success)
    }
}

/// What the program decides where the arguments leave it open.
#[derive(Clone, Default)]
pub struct Defaults {
    /// Folder of the cache; none: nothing is cached.
    pub cache: Option<PathBuf>,
    /// The benchmark that scenes without a structure are on, and whose first scene commands take that are given none.
    pub benchmark: Option<&'static dyn Benchmark>,
}

/// Where reduced models and finished amplitudes are kept, and how much memory there is for what is computed.
#[derive(clap::Args)]
pub struct Cache {
    /// Folder for reduced models and finished amplitudes, made if missing [default: the one that the help of the program names].
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    cache: Option<PathBuf>,
    /// Neither read nor store reduced models and finished amplitudes.
    #[arg(long)]
    no_cache: bool,
    /// Memory that may be taken, such as 8 or 8GB, or 500MB; what needs more is refused before it is computed [default: what is free, where
    /// the system tells].
    #[arg(long, value_name = "GB", value_parser = bytes)]
    memory: Option<u64>,
}

/// A size with its unit as a number of bytes; GB where there is none.
fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let (number, unit) = match (text.strip_suffix("GB"), text.strip_suffix("MB")) {
        (Some(number), _) => (number, 1e9),
        (_, Some(number)) => (number, 1e6),
        _ => (text, 1e9),
    };
    match number.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok((unit * number) as u64),
        _ => Err("give a positive number of GB, such as 8 or 8GB, or of MB, such as 500MB".into()),
    }
}

impl Cache {
    fn options(&self, defaults: &Defaults) -> Options {
        let cache = match (self.no_cache, &self.cache) {
            (true, _) => None,
            (false, Some(folder)) => Some(folder.clone()),
            (false, None) => defaults.cache.clone(),
        };
        Options {
            cache,
            build: provenance::commit(),
            memory: self.memory.or_else(free_memory),
        }
    }
}

/// How many threads a command uses.
#[derive(clap::Args)]
pub struct Threads {
    /// Number of threads [default: one per processor].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Threads {
    /// These, or another number where none is given.
    fn or(&self, other: Option<u16>) -> Self {
        Self {
            threads: self.threads.or(other),
        }
    }

    /// Starts them.
    fn start(&self) -> Result<()> {
        let Some(threads) = self.threads else {
            return Ok(());
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global()
            .with_context(|| format!("starting {threads} threads"))
    }
}

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All is well.
    Success,
    /// Some amplitudes did not converge.
    Incomplete,
}

/// Runs a command and turns its outcome into an exit code; an error is written to standard error in one line.
pub fn execute(command: impl FnOnce() -> Result<Outcome>) -> ExitCode {
    // Amplitudes and elements already run in parallel; threads within matrix kernels would only compete with them.
    faer::set_global_parallelism(faer::Par::Seq);
    match command() {
        Ok(Outcome::Success) => ExitCode::SUCCESS,
        Ok(Outcome::Incomplete) => ExitCode::from(3),
        Err(error) => {
            // A closed standard error leaves nobody to tell.
            let _ = writeln!(std::io::stderr(), "error: {}", text::of_error(&error));
            ExitCode::FAILURE
        }
    }
}

/// Prints a finished text; a reader that has gone away (as `head` does) is no error.
///
/// # Errors
/// Standard output cannot be written.
pub fn print(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text::visible(text).as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Writes files into a folder that has none of them.
///
/// # Errors
/// One of them is there already, of which none is written then; or a file cannot be written.
fn write_new(directory: &Path, files: &[(&str, &[u8])]) -> Result<()> {
    for (name, _) in files {
        let path = directory.join(name);
        if path.exists() {
            bail!("{} is there already; choose another folder", path.display());
        }
    }
    for (name, contents) in files {
        file_io::durable::write(&directory.join(name), contents)?;
    }
    Ok(())
}

/// The folder of this name among the results.
fn default_directory(name: &str) -> Result<PathBuf> {
    let mut components = Path::new(name).components();
    match (components.next(), components.next()) {
        (Some(Component::Normal(_)), None) if !name.starts_with('.') => Ok(Path::new(RESULTS).join(name)),
        _ => bail!("the scene's name `{name}` cannot name a folder; choose one with --out"),
    }
}
