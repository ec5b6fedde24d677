//! `export`: the reduced model of a scene, its mesh, or the joints of a finished run, for other programs.

use super::defaults::Defaults;
use super::destination::default_directory;
use super::elements::{self, Elements};
use super::resources::Cache;
use super::scene::SceneArguments;
use crate::files::{self, Overwrite};
use crate::progress::{Display, Monitor};
use crate::text::print;
use anyhow::{Context, Result, bail};
use finite_elements::formats::vtu::{self, Encoding};
use finite_elements::formats::{abaqus, gmsh};
use host::results_of;
use joint_model::Bodies;
use joint_model::benchmark::{RefinementLevel, Symmetry};
use joints::structure::Structure;
use joints::structure::export::{ABOUT, ABOUT_POINTS, arrays, deck, groups, point_matrices, with_short_names};
use matrix_files::value::Array;
use matrix_files::{dmig, mat, matrix_market, npz, op4};
use reports::Output;
use reports::elements::Family;
use scenes::{Gap, MaterialSource, Scene, StructureSource, Surface};
use std::path::{Path, PathBuf};

/// Options of `export`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Format: of the reduced model one file of all arrays, or one Matrix Market file each; of the mesh; or of the joints of a finished run, whose
    /// folder then takes the place of the scene.
    #[arg(long, value_enum)]
    format: Format,
    /// Folder for the files [default: results/NAME-export-FORMAT].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    cache: Cache,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// NumPy.
    Npz,
    /// MATLAB and Octave (level 5).
    Mat,
    /// Matrix Market.
    Mtx,
    /// Nastran's OUTPUT4 (binary), names in capitals.
    Op4,
    /// Entries DMIG of Nastran: mass, stiffness, loads and responses between grid points and scalar points.
    Dmig,
    /// The mesh with its connections as an input deck for Abaqus and CalculiX, and a scene that runs on it.
    Inp,
    /// The mesh and the sides of its interface for Gmsh (4.1).
    Msh,
    /// The mesh for ParaView.
    Vtu,
    /// Of a run: stiffness and loss factor of each connection at each amplitude, as PBUSH and PBUSHT of Nastran.
    Cbush,
    /// The same as behaviours of connectors of Abaqus.
    Connector,
    /// Of a run: four-parameter Iwan elements fitted to modal coordinates and connections.
    Iwan,
    /// The same by Bouc-Wen elements.
    BoucWen,
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Self::Npz => "npz",
            Self::Mat => "mat",
            Self::Mtx => "mtx",
            Self::Op4 => "op4",
            Self::Dmig => "dmig",
            Self::Inp => "inp",
            Self::Msh => "msh",
            Self::Vtu => "vtu",
            Self::Cbush => "cbush",
            Self::Connector => "connector",
            Self::Iwan => "iwan",
            Self::BoucWen => "bouc-wen",
        }
    }

    /// What is written of a finished run; none of a scene.
    fn of_runs(self) -> Option<Elements> {
        match self {
            Self::Cbush => Some(Elements::Nastran),
            Self::Connector => Some(Elements::Abaqus),
            Self::Iwan => Some(Elements::Fitted(Family::Iwan)),
            Self::BoucWen => Some(Elements::Fitted(Family::BoucWen)),
            _ => None,
        }
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<()> {
    let format = arguments.format.name();
    if let Some(of) = arguments.format.of_runs() {
        let folder = arguments.scene.path().with_context(|| {
            format!("--format {format} takes the folder of a finished run, which `microslip run` writes")
        })?;
        return elements::export(folder, of, format, arguments.out.as_deref(), &arguments.overwrite);
    }
    let scene = arguments.scene.read(defaults)?.scene;
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}-export-{format}", scene.name))?,
    };
    if scene.model.symmetry == Symmetry::Half {
        bail!(
            "the half of the scene {} stands for the whole only here; leave out model.symmetry to export it",
            scene.name
        );
    }
    let identity = results_of(&format!("export --format {format}"), &scene);
    let folder = arguments.overwrite.open(&directory, &identity, &[])?;
    let monitor = Monitor::new(Display::default())?;
    let structure = Structure::try_new(&scene, &monitor).with_context(|| format!("the scene {}", scene.name))?;
    let reduced = || {
        let joint = &structure.joint;
        if !joint.node_frames.is_empty() || !joint.interface.covered.is_empty() {
            bail!(
                "the interface of the scene {} is curved, faced in part or in several planes, which the matrices of one plane cannot tell; export the \
                 mesh by --format inp",
                scene.name
            );
        }
        let model = structure.reduce(&arguments.cache.options(defaults), &monitor)?;
        Ok::<_, anyhow::Error>(arrays(&model, &structure.joint)?)
    };
    let outputs = match arguments.format {
        Format::Npz => vec![Output::new("reduced.npz", npz::to_bytes(&reduced()?)?)],
        Format::Mat => vec![Output::new("reduced.mat", mat::to_bytes(&reduced()?)?)],
        Format::Mtx => reduced()?
            .iter()
            .map(|(name, array)| match array {
                Array::Text(text) => Ok(Output::new(format!("{name}.txt"), text.clone())),
                numbers => Ok(Output::new(format!("{name}.mtx"), matrix_market::to_bytes(numbers)?)),
            })
            .collect::<Result<Vec<_>>>()?,
        Format::Op4 => vec![Output::new(
            "reduced.op4",
            op4::to_bytes(&with_short_names(reduced()?))?,
        )],
        Format::Dmig => vec![Output::new(
            "reduced.pch",
            dmig::to_bytes(&point_matrices(&reduced()?), ABOUT_POINTS)?,
        )],
        _ => mesh(&scene, &structure, arguments.format)?,
    };
    monitor.finish();
    files::publish(folder, &outputs)?;
    let names: Vec<&str> = outputs.iter().map(|o| o.name.as_str()).collect();
    let about = match arguments.format {
        Format::Npz | Format::Mat | Format::Mtx | Format::Op4 => ABOUT,
        Format::Dmig => ABOUT_POINTS,
        _ => "",
    };
    print(&format!(
        "{about}\nwritten to {}: {}\n",
        directory.display(),
        names.join(", ")
    ))
}

fn mesh(scene: &Scene, structure: &Structure, format: Format) -> Result<Vec<Output>> {
    let joint = &structure.joint;
    let Bodies::Meshed(bodies) = &joint.bodies else {
        bail!("the scene {} is on matrices, which have no mesh", scene.name);
    };
    let (faces, nodes) = groups(joint, bodies);
    let solids = &bodies.assembly.mesh;
    Ok(match format {
        Format::Msh => vec![Output::new("structure.msh", gmsh::write(solids, &faces, &nodes)?)],
        Format::Vtu => vec![Output::new(
            "structure.vtu",
            vtu::write(solids, &[], &[], Encoding::Base64)?,
        )],
        _ => {
            let mut on_deck = scene.clone();
            // The scene knows no density of bodies whose materials are a deck's.
            let materials = match scene.structure.deck() {
                Some(deck) => deck.materials,
                None => MaterialSource::Scene,
            };
            let deck = deck(joint, bodies, Path::new("structure.inp"), materials);
            on_deck.structure = StructureSource::Deck(Box::new(deck)).into();
            // Formulation and order are those of the deck's element types.
            (on_deck.model.formulation, on_deck.model.element_order) = (None, None);
            (on_deck.model.refinement, on_deck.model.arm_layers) = (RefinementLevel::default(), None);
            // What the structure's own measured faces were is not known of a deck.
            if let Some(benchmark) = scene.structure.benchmark() {
                if on_deck.interfaces.surface == Surface::Measured {
                    on_deck.interfaces.surface = Surface::Benchmark(benchmark);
                }
                if on_deck.interfaces.gap == Gap::Measured {
                    on_deck.interfaces.gap = Gap::Benchmark(benchmark);
                }
            }
            let json = serde_json::to_string_pretty(&on_deck).context("encoding the scene")?;
            vec![
                Output::new("structure.inp", abaqus::write(&bodies.assembly, &faces, &nodes)?),
                Output::new("structure.json", json + "\n"),
            ]
        }
    })
}
