//! `model`: what a scene's structure is, before anything nonlinear; or what a mesh holds, without a scene.

use super::defaults::Defaults;
use super::destination::default_directory;
use super::resources::Cache;
use super::scene::SceneArguments;
use super::survey;
use crate::files::{self, Overwrite};
use crate::progress::{Display, Monitor};
use crate::text::print;
use analyses::{Prepared, warnings};
use anyhow::{Context, Result, bail};
use host::{provenance, results_of};
use joint_model::Bodies;
use joint_model::benchmark::Symmetry;
use joints::progress::Progress;
use joints::structure::survey::Survey;
use joints::structure::{Contact, Frequencies, LinearInterface, ModalModel, Structure};
use reports::Output;
use reports::bodies::LARGEST_VOLUME;
use reports::modes;
use reports::names::SUMMARY;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

/// Options of `model`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Also the frequencies of the unstressed assembly, with a stuck and with a linear interface.
    #[arg(long)]
    spectrum: bool,
    /// Frequencies of each kind.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=200))]
    count: u16,
    /// Normal stiffness of the linear interface (Pa/m in SI) [default: 50 Young's moduli per metre].
    #[arg(long, value_name = "STIFFNESS", requires = "tangential_stiffness")]
    normal_stiffness: Option<f64>,
    /// Its tangential stiffness (Pa/m in SI).
    #[arg(long, value_name = "STIFFNESS", requires = "normal_stiffness")]
    tangential_stiffness: Option<f64>,
    /// Also the N lowest mode shapes of the unstressed assembly, with a stuck and with the linear interface: names, shares of energy,
    /// effective masses, a file for ParaView and a page with pictures.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=200))]
    modes: Option<u16>,
    /// Also those about the prestress of the scene, with everything in contact stuck.
    #[arg(long, requires = "modes")]
    prestressed: bool,
    /// Folder for the results [default: results/NAME-model].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    cache: Cache,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<()> {
    if let Some(file) = arguments.scene.mesh_file() {
        if arguments.spectrum
            || arguments.modes.is_some()
            || arguments.out.is_some()
            || arguments.normal_stiffness.is_some()
            || arguments.scene.asks_of_deck()
            || arguments.cache.is_given()
        {
            bail!(
                "{} is no scene: --spectrum, --modes, --out, stiffnesses, options of the cache and those of decks need one; if it is a mesh, make a scene of it by `microslip new --from`",
                file.display()
            );
        }
        return print(&survey::text(file, &Survey::of_file(file)?));
    }
    let given = arguments.scene.read(defaults)?;
    let provenance = provenance::of(given.inputs()?)?;
    let scene = given.scene;
    if arguments.modes.is_some() && scene.model.symmetry == Symmetry::Half {
        bail!(
            "the half of the scene {} has only the symmetric modes, with half their masses; leave out model.symmetry for mode shapes",
            scene.name
        );
    }
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}-model", scene.name))?,
    };
    let interface = arguments.normal_stiffness.zip(arguments.tangential_stiffness);
    let linear = interface.map(|(normal_stiffness, tangential_stiffness)| LinearInterface {
        normal_stiffness,
        tangential_stiffness,
        points_per_direction: scene.interfaces.points_per_direction,
    });
    let folder = arguments
        .overwrite
        .open(&directory, &results_of("model", &scene), &[SUMMARY])?;
    let monitor = Monitor::new(Display::default())?;
    let of_scene = || format!("the scene {}", scene.name);
    let structure = Structure::try_new(&scene, &monitor).with_context(of_scene)?;
    let overview = structure.overview(&scene)?;
    overview.lines().iter().for_each(|line| monitor.echo(line));
    let warnings = warnings::of_input(&overview);
    warnings.iter().for_each(|warning| monitor.warn(&warning.message));
    let found = structure
        .describe(arguments.spectrum.then_some((arguments.count.into(), linear)), &monitor)
        .with_context(of_scene)?;
    let modal = match arguments.modes {
        None => None,
        Some(count) => {
            let tangent = match arguments.prestressed {
                false => None,
                true => {
                    let options = arguments.cache.options(defaults);
                    let prepared = Prepared::try_new(&scene, &structure, &options, &monitor)?;
                    Some(prepared.stuck_tangent(&monitor)?)
                }
            };
            Some(structure.modes(count.into(), linear, tangent.as_ref(), &monitor)?)
        }
    };
    let timings = monitor.finish();

    let mesh = match (found.n_nodes, found.n_elements) {
        (Some(nodes), Some(elements)) => format!("{nodes} nodes, {elements} elements, "),
        _ => String::new(),
    };
    let mass = found
        .mass
        .map_or_else(|| "mass not known".into(), |mass| format!("{mass:.4} kg"));
    let mut text = format!(
        "{}: {mesh}{} independent components, {mass}\n\
         interface: {} elements, {:.2} mm^2; {} slaves left free, others moved by {:.2e} m at most\n",
        scene.name,
        found.n_dofs,
        found.n_interface_elements,
        1e6 * found.interface_area,
        found.n_untied_slaves,
        found.largest_adjustment,
    );
    if let Some(raised) = found.raised {
        writeln!(
            text,
            "{} linear elements of the deck were made quadratic, which added {} nodes",
            raised.elements, raised.added_nodes
        )?;
    }
    if let Some(spectrum) = &found.spectrum {
        let mut row = |name: &str, f: &Frequencies| {
            let list: Vec<String> = f.frequencies_hz.iter().map(|f| format!("{f:.2}")).collect();
            writeln!(
                text,
                "{name}, {} zero-energy modes, then [Hz]: {}",
                f.zero_energy_modes,
                list.join(" ")
            )
        };
        row(Contact::Unstressed.words(), &spectrum.unstressed)?;
        row(Contact::Stuck.words(), &spectrum.stuck)?;
        let linear = &spectrum.linear;
        let name = format!(
            "{} ({:.3e} Pa/m normal, {:.3e} tangential)",
            Contact::Linear.words(),
            linear.normal_stiffness,
            linear.tangential_stiffness
        );
        row(&name, &spectrum.with_linear)?;
    }
    let mut outputs = Vec::new();
    if let (Some(modal), Bodies::Meshed(bodies)) = (&modal, &structure.joint.bodies) {
        let mesh = &bodies.assembly.mesh;
        let is_large = mesh.elements.len() > LARGEST_VOLUME;
        text.push_str(&listed(modal));
        if is_large {
            writeln!(
                text,
                "the mesh has more than {LARGEST_VOLUME} elements: modes.vtu holds its surface only"
            )?;
        }
        outputs = modes::outputs(modal, mesh, &format!("{}: modes", scene.name), &about(modal, is_large))?;
        writeln!(
            text,
            "written to {}, with report.html to begin with",
            directory.display()
        )?;
    }
    let mut summary = json!({
        "scene": scene,
        "overview": overview,
        "warnings": warnings,
        "model": found,
        "provenance": provenance,
        "seconds": timings,
    });
    if let Some(modal) = &modal {
        summary["modes"] = json!(modal);
    }
    let json = serde_json::to_string_pretty(&summary).context("encoding the summary")?;
    outputs.push(Output::new(SUMMARY, json + "\n"));
    files::publish(folder, &outputs)?;
    print(&text)
}

/// The modes with each contact, line by line, and which of them move the joint most.
fn listed(modal: &ModalModel) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for of in &modal.contacts {
        let _ = writeln!(
            text,
            "\n{}, {} zero-energy modes",
            of.contact.words(),
            of.zero_energy_modes
        );
        for mode in &of.modes {
            let energy = mode.interface_energy.map_or_else(String::new, |share| {
                format!(", {:.2} % of its energy in the interface", 100.0 * share)
            });
            let _ = writeln!(
                text,
                "{:>4} {:>12.3} Hz  {}{energy}",
                mode.number, mode.frequency_hz, mode.name
            );
        }
    }
    let most: Vec<String> = modal.joint_moved_most_by.iter().take(3).map(usize::to_string).collect();
    let last = modal.contacts.last().map_or("", |of| of.contact.name());
    let _ = writeln!(
        text,
        "\n{last}: the joint is moved most by the modes {}",
        most.join(", ")
    );
    text
}

/// What the page of the modes says first.
fn about(modal: &ModalModel, is_large: bool) -> String {
    let [x, y, z] = modal.centre;
    let files = match is_large {
        true => "modes.vtu holds the surface of the mesh",
        false => "modes.vtu holds the whole mesh",
    };
    format!(
        "{:.4} kg, centre of mass at ({x:.4}, {y:.4}, {z:.4}) m. Names say which share of the mass-weighted square of the motion \
         the cross-sections along the longest axis have as rigid bodies. Effective masses are those of the three translations and, about \
         the centre of mass, rotations. In the pictures the largest displacement is 8 % of the length, colours are magnitudes, and \
         grey lines are the structure at rest. {files} for ParaView, with an array of displacements per mode.",
        modal.mass
    )
}
