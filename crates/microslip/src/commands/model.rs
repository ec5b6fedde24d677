//! `model`: what a scene's structure is, before anything nonlinear.

use super::{Defaults, SceneArguments, default_directory};
use crate::files::{self, Overwrite};
use crate::progress::Monitor;
use crate::provenance;
use anyhow::{Context, Result};
use joint_pipeline::structure::{Frequencies, LinearInterface, Structure};
use reports::Output;
use reports::run::SUMMARY;
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
    /// Folder for summary.json [default: results/NAME-model].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<()> {
    let given = arguments.scene.read(defaults)?;
    let provenance = provenance::of(given.inputs()?)?;
    let scene = given.scene;
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}-model", scene.name))?,
    };
    let interface = arguments.normal_stiffness.zip(arguments.tangential_stiffness);
    let linear = interface.map(|(normal_stiffness, tangential_stiffness)| LinearInterface {
        normal_stiffness,
        tangential_stiffness,
        points_per_direction: scene.points_per_direction,
    });
    let folder = arguments
        .overwrite
        .open(&directory, &files::of_scene("model", &scene), &[SUMMARY])?;
    let monitor = Monitor::new()?;
    let structure = Structure::try_new(&scene, &monitor)?;
    let found = structure.describe(arguments.spectrum.then_some((arguments.count.into(), linear)), &monitor)?;
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
        row("unstressed", &spectrum.unstressed)?;
        row("stuck", &spectrum.stuck)?;
        let linear = &spectrum.linear;
        let name = format!(
            "linear interface ({:.3e} Pa/m normal, {:.3e} tangential)",
            linear.normal_stiffness, linear.tangential_stiffness
        );
        row(&name, &spectrum.with_linear)?;
    }
    let summary = json!({ "scene": scene, "model": found, "provenance": provenance, "seconds": timings });
    let json = serde_json::to_string_pretty(&summary).context("encoding the summary")?;
    files::publish(folder, &[Output::new(SUMMARY, json + "\n")])?;
    super::print(&text)
}
