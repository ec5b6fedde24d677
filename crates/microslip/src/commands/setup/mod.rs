//! `setup`: a joint is set up from its mesh in a browser, and run.

mod check;
mod job;
mod site;

use super::destination::RESULTS;
use super::new::from::{self, LENGTHS};
use super::scene::is_mesh;
use super::survey::{about, name};
use super::web;
use crate::text::print;
use anyhow::{Context, Result, anyhow, bail};
use check::Checker;
use file_io::input::{Kind, read_text};
use host::BENCHMARKS;
use joints::structure::Shape;
use joints::structure::survey::Survey;
use serde_json::{Map, Value, json};
use site::Place;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Options of `setup`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Mesh, or input deck of which the mesh is taken; the scene is written beside it as scene.json. Or a scene on a mesh, to go on with.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Unit of length of the mesh: m, cm, mm, in or ft; it can be chosen on the page too.
    #[arg(long, value_name = "UNIT", value_parser = LENGTHS)]
    length: Option<String>,
    /// Folder for the results of runs [default: results/NAME beside the scene].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the address and leave it to the reader to open it.
    #[arg(long)]
    no_open: bool,
    /// Port on the loopback interface [default: one that is free].
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
}

/// Most names of files that are proposed for scans.
const MOST_FILES: usize = 500;

/// Runs the command, which ends with the process.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let file = &arguments.file;
    let whole = |path: &Path| {
        let found = path.canonicalize();
        found.with_context(|| format!("{}: finding {}", file.display(), path.display()))
    };
    let own = file.file_name().unwrap_or_default();
    let (mesh, scene_name, given) = match is_mesh(file) {
        true => (own.into(), "scene.json".to_owned(), None),
        false => {
            let (scene, mesh) = scene_of(file, arguments.length.as_deref())?;
            (mesh, utf8(own.as_ref())?, Some(scene))
        }
    };
    // Where a link to a file is, and not where the file is.
    let folder = whole(&file.with_file_name("."))?;
    let (path, mesh) = (utf8(&mesh)?, whole(&folder.join(mesh))?);
    let (survey, shape) = Shape::of_file(&mesh)?;
    let stem = scene_name.trim_end_matches(".json").to_owned();
    let out = match &arguments.out {
        Some(out) => std::path::absolute(out).with_context(|| format!("finding {}", out.display()))?,
        None => folder.join(RESULTS).join(&stem),
    };
    let mut facts = facts(&survey);
    let length = arguments.length.as_deref();
    facts["mesh"] = json!(path);
    facts["length"] = json!(length);
    facts["scene_file"] = json!(scene_name);
    facts["results"] = json!(out.display().to_string());
    facts["files"] = json!(files_in(&folder));
    facts["scene"] = json!(given);
    let page = reports::setup::document(&format!("Set-up of {path}"), &shape, &facts)?;
    let token = host::token().context("asking the system for random numbers")?;
    let place = Place {
        checker: Checker {
            folder: folder.clone(),
            mesh,
            place: scene_name.clone(),
            name: stem,
            body_of_cell: shape.body_of_cell,
            turn: Mutex::default(),
        },
        scene: folder.join(scene_name),
        out,
    };
    let (listener, address) = web::listen(arguments.port)?;
    let address = format!("{address}{token}/");
    print(&format!("{address}\n"))?;
    if !arguments.no_open {
        web::open(&address);
    }
    web::serve(&listener, site::Setup::new(token, page, place))
}

/// The scene of a file, which need not say all that a run needs, and its mesh as it names it.
fn scene_of(file: &Path, length: Option<&str>) -> Result<(Value, PathBuf)> {
    let text = read_text(file, Kind::Scene)?;
    let scene = scenes::parse_json(&text).map_err(|message| anyhow!("{}: {message}", file.display()))?;
    let Some(mesh) = scene.pointer("/structure/mesh/path").and_then(Value::as_str) else {
        bail!(
            "{}: structure.mesh.path is missing, and only what a mesh shows can be set up on a page; give a mesh, or a scene on one",
            file.display()
        );
    };
    if length.is_some() {
        bail!(
            "{}: the scene states its units in `units`; leave --length out",
            file.display()
        );
    }
    let own = scene.pointer("/structure/mesh/units/length");
    if own.is_some_and(|own| Some(own) != scene.pointer("/units/length")) {
        bail!(
            "{}: structure.mesh.units has another length than `units`, and the page knows one unit; give the scene that of the mesh",
            file.display()
        );
    }
    let mesh = PathBuf::from(mesh);
    Ok((scene, mesh))
}

fn utf8(path: &Path) -> Result<String> {
    let text = path.to_str();
    let text = text.with_context(|| format!("{} is not a name in UTF-8; rename it", path.display()))?;
    Ok(text.to_owned())
}

/// What the page shows of a mesh, and what it proposes.
fn facts(survey: &Survey) -> Value {
    let bodies = survey.bodies.iter().map(|body| {
        let elements = body.elements.iter().map(|(kind, count)| format!("{count} {kind}"));
        json!({ "name": body.name, "elements": elements.collect::<Vec<_>>().join(", ") })
    });
    let touching = survey.touching.iter().map(|touching| {
        json!({
            "bodies": touching.bodies,
            "about": about(survey, touching),
            "flat": touching.is_flat(),
            "normal": touching.normal,
            "entry": from::interface(survey, touching),
        })
    });
    let bolts = survey.bolts.iter().map(|bolt| {
        let sizes: Map<String, Value> = from::systems()
            .map(|(length, unit, _)| (length.to_owned(), json!(bolt.size(unit))))
            .collect();
        json!({
            "axis": from::axis(bolt),
            "diameter": bolt.diameter,
            "sizes": sizes,
            "filled_by": bolt.filled_by.map(|body| name(survey, body)),
        })
    });
    let systems: Map<String, Value> = from::systems()
        .map(|(length, _, units)| (length.to_owned(), units))
        .collect();
    let measured = BENCHMARKS.iter().filter(|benchmark| benchmark.surface().is_some());
    json!({
        "systems": systems,
        "lengths": LENGTHS,
        "bodies": bodies.collect::<Vec<_>>(),
        "touching": touching.collect::<Vec<_>>(),
        "bolts": bolts.collect::<Vec<_>>(),
        "groups": survey.groups,
        "notes": survey.notes,
        "benchmarks": measured.map(|benchmark| benchmark.name()).collect::<Vec<_>>(),
        "schema": scenes::file_schema(),
    })
}

/// Names of the files in a folder that are not hidden, in order.
fn files_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let files = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    let names = files.filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| !name.starts_with('.')).collect();
    names.sort_unstable();
    names.truncate(MOST_FILES);
    names
}
