//! The commands of the program, for its binary and for others that offer them too.

mod calibrate;
mod characterise;
mod compare;
mod defaults;
mod destination;
mod elements;
mod export;
mod identify;
mod model;
mod new;
mod outcome;
mod plot;
mod resources;
pub mod run;
mod samples;
mod scene;
mod schema;
mod setup;
mod study;
mod survey;
mod upgrade;
mod verify;
mod view;
mod web;

use crate::progress::Display;
pub use crate::text::print;
use anyhow::Result;
pub use defaults::Defaults;
pub use destination::RESULTS;
pub use host::GivenScene;
pub use outcome::{EXIT_CODES, Outcome, execute};
pub use resources::{Cache, Threads};
pub use scene::SceneArguments;

/// Commands beside `run`.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Describe the structure of a scene: size, mass and, with `--spectrum`, frequencies with linear interfaces.
    Model(model::Arguments),
    /// Write the reduced model of a scene for other programs: NumPy, MATLAB and Octave, Matrix Market; or the joints of a run as elements.
    Export(export::Arguments),
    /// Frequency and damping against amplitude from measured ring-downs; several files are hits to be averaged.
    Identify(identify::Arguments),
    /// Characterise two scans over an interface: gaps, roughness, asperities and traction laws with bands per element.
    Characterise(characterise::Arguments),
    /// Bring scenes and plans of former versions into the present layout.
    Upgrade(upgrade::Arguments),
    /// Lay a run over measured backbones at the same response point: misfit in frequency and damping.
    Compare(compare::Arguments),
    /// Find numbers of a scene by least squares on measured backbones, with priors, standard errors and what cannot be identified.
    #[command(after_help = EXIT_CODES)]
    Calibrate(calibrate::Arguments),
    /// Run hundreds to thousands of variants of a scene by a plan, here or by a batch system, and tabulate them; what is finished is kept.
    #[command(after_help = EXIT_CODES)]
    Study(study::Arguments),
    /// Set up a joint from a mesh in a browser on this computer, and run it, until Ctrl-C ends it.
    Setup(setup::Arguments),
    /// Show runs beside each other in a browser on this computer, until Ctrl-C ends it.
    View(view::Arguments),
    /// Draw results for papers, as SVG or PDF: backbones, maps of dissipation, mode shapes, bands, errors against time.
    Plot(plot::Arguments),
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
    /// How the command shows what it does.
    pub fn display(&self) -> Display {
        match self {
            Self::Calibrate(arguments) => arguments.display,
            Self::Study(arguments) => arguments.display,
            _ => Display::default(),
        }
    }

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
            Self::Upgrade(arguments) => upgrade::run(arguments),
            Self::Compare(arguments) => compare::run(arguments),
            Self::Calibrate(arguments) => return calibrate::run(arguments, defaults),
            Self::Study(arguments) => return study::run(arguments, defaults),
            Self::Setup(arguments) => setup::run(arguments),
            Self::View(arguments) => view::run(arguments),
            Self::Plot(arguments) => plot::run(arguments),
            Self::Verify(arguments) => verify::run(arguments),
            Self::New(arguments) => new::run(arguments),
            Self::Samples(arguments) => samples::run(arguments),
            Self::Benchmarks => print(&scene::list()),
            Self::Schema(arguments) => schema::run(arguments),
        };
        done.map(|()| Outcome::Success)
    }
}
