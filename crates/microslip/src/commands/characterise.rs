//! `characterise`: two scans over an interface, element by element.

use super::defaults::Defaults;
use super::scene;
use crate::files::{self, Overwrite};
use crate::text::print;
use anyhow::{Context, Result, bail};
use contact_laws::FittedCurves;
use file_io::durable::Identity;
use host::{benchmarks, results_of};
use joints::interface::{FinishReport, FinishedSurface, SURFACE_SCHEMA_VERSION, ScannedSurface};
use joints::progress::Silent;
use joints::structure::Structure;
use reports::Output;
use reports::fields::{CellField, Placed};
use reports::{csv, fields, map, plot};
use scenes::{BenchmarkRef, Length, Place, PlaneMesh, ScanFile, Scans, Scene, StructureSource, Surface};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use surface_characterisation::finish::PERCENTILES;
use surface_characterisation::readers::{FirstRow, LengthUnit};
use surface_characterisation::{ElementSurface, GapChange};
use zte_assembly::InterfaceMesh;

/// Name of the machine-readable account.
const REPORT: &str = "surface.json";

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Scan of the top face: X3P, SDF, SUR, text or NumPy [default: that of the scene].
    #[arg(requires = "bottom", required_unless_present_any = ["scene", "benchmark"])]
    top: Option<PathBuf>,
    /// Scan of the bottom face.
    bottom: Option<PathBuf>,
    /// Scene whose interface, material and `surface` are taken: scans with all their settings and readings.
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// The same of a scene that comes with the program, see `benchmarks`.
    #[arg(long, value_name = "NAME", conflicts_with = "scene")]
    benchmark: Option<String>,
    /// Interface mesh: a benchmark by its name, or JSON with `nodes` and `elements` (node numbers from 1)
    /// [default: that of the scene].
    #[arg(long, value_name = "NAME|FILE")]
    mesh: Option<PathBuf>,
    /// Unit of the nodes in the file of the mesh.
    #[arg(long, value_name = "UNIT", default_value = "m")]
    mesh_units: LengthUnit,
    /// Unit of positions, steps and heights that the scans do not state.
    #[arg(long, value_name = "UNIT")]
    units: Option<LengthUnit>,
    /// Unit of heights, where it is another one.
    #[arg(long, value_name = "UNIT")]
    height_units: Option<LengthUnit>,
    /// Distances of neighbouring points along x and y, in units of the positions, that the scans do not state.
    #[arg(long, value_name = "DX,DY", value_parser = pair)]
    step: Option<[f64; 2]>,
    /// Where the first line of the scans lies, in formats that leave it open.
    #[arg(long, value_enum)]
    first_row: Option<FirstLine>,
    /// Height step of the instrument (m) [default: what the scans state].
    #[arg(long, value_name = "METRES")]
    height_step: Option<f64>,
    /// Put the middle of each scan on the middle of the interface [default: positions are what the scans state].
    #[arg(long)]
    centred: bool,
    /// The bottom face was scanned from its own side: turn its x over.
    #[arg(long)]
    mirror_bottom: bool,
    /// Move each face onto the interface by the edges and holes of its mask, by at most this (m).
    #[arg(long, value_name = "METRES")]
    align: Option<f64>,
    /// Bootstrap draws for the bands.
    #[arg(long, value_name = "N")]
    bootstrap: Option<usize>,
    /// Seed of these draws.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Element, from 0, whose profiles and response are drawn [default: the one with the median total roughness].
    #[arg(long, value_name = "N")]
    element: Option<usize>,
    /// Also tell how the gap depends on shifts and tilts of the bottom face.
    #[arg(long)]
    registration_study: bool,
    /// Folder for the results, made if missing.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum FirstLine {
    LowestY,
    HighestY,
}

/// Two numbers with a comma between them.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match (numbers[..].try_into(), text.matches(',').count()) {
        (Ok(pair), 1) => Ok(pair),
        _ => Err("give two numbers with a comma between them".into()),
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<()> {
    let mut scene = scene::read(arguments.scene.as_deref(), arguments.benchmark.as_deref(), defaults)?.scene;
    if let (Some(top), Some(bottom)) = (&arguments.top, &arguments.bottom) {
        let mut scans = match scene.interfaces.surface {
            Surface::Scans(scans) => *scans,
            _ => Scans::new(ScanFile::default(), ScanFile::default()),
        };
        (scans.top.path, scans.bottom.path) = (top.clone(), bottom.clone());
        scene.interfaces.surface = Surface::Scans(Box::new(scans));
    }
    apply(arguments, &mut scene)?;
    scene.validate("the arguments")?;
    let mesh = mesh(arguments, &scene)?;
    // Before the computation: it would be a pity to find out only afterwards.
    let directory = &arguments.out;
    let folder = arguments.overwrite.open(directory, &identity(&scene), &[REPORT])?;
    if let Surface::Finish(_) = scene.interfaces.surface {
        if arguments.registration_study || arguments.element.is_some() {
            bail!(
                "--registration-study and --element belong to scans; the surface of the scene {} is given by roughness parameters",
                scene.name
            );
        }
        let surface = FinishedSurface::try_new(&scene, &mesh.plane)?;
        let outputs = finished_outputs(&surface)?;
        files::publish(folder, &outputs)?;
        return print(&finished_account(&surface, &outputs, directory));
    }
    let surface = ScannedSurface::try_new(&scene, &mesh.plane)?;
    let study = match arguments.registration_study {
        true => Some(surface.registration_study().context("moving the bottom face")?),
        false => None,
    };
    let shown = shown(arguments, &surface.found.elements)?;
    let outputs = outputs(&surface, mesh.place(), shown, study.as_deref())?;
    files::publish(folder, &outputs)?;
    print(&account(&surface, study.as_deref(), &outputs, directory))
}

/// The scans that are characterised, or the scene that describes the surface otherwise.
fn identity(scene: &Scene) -> Identity {
    match &scene.interfaces.surface {
        Surface::Scans(scans) => {
            let files = [&scans.top.path, &scans.bottom.path];
            let names = files.map(|path| path.file_name().unwrap_or_default().to_string_lossy());
            Identity::new("characterise", names.join(" and "))
        }
        _ => results_of("characterise", scene),
    }
}

/// Lays what the arguments say of the scans over what the scene says.
fn apply(arguments: &Arguments, scene: &mut Scene) -> Result<()> {
    let given = arguments.units.is_some()
        || arguments.height_units.is_some()
        || arguments.step.is_some()
        || arguments.first_row.is_some()
        || arguments.height_step.is_some()
        || arguments.centred
        || arguments.mirror_bottom
        || arguments.align.is_some()
        || arguments.bootstrap.is_some()
        || arguments.seed.is_some();
    let scans = match &mut scene.interfaces.surface {
        Surface::Scans(scans) => scans,
        _ if given => bail!(
            "options of scans are given, but the surface of the scene {} is not read from files",
            scene.name
        ),
        _ => return Ok(()),
    };
    for file in [&mut scans.top, &mut scans.bottom] {
        file.lateral_unit = arguments.units.or(file.lateral_unit);
        file.height_unit = arguments.height_units.or(arguments.units).or(file.height_unit);
        file.lateral_step = arguments.step.or(file.lateral_step);
        if let Some(line) = arguments.first_row {
            file.first_row = Some(match line {
                FirstLine::LowestY => FirstRow::LowestY,
                FirstLine::HighestY => FirstRow::HighestY,
            });
        }
        file.height_step = arguments.height_step.map(Length::from_si).or(file.height_step);
        if arguments.centred {
            file.place = Place::Centred;
        }
    }
    scans.bottom.mirrored |= arguments.mirror_bottom;
    scans.align = arguments.align.map(Length::from_si).or(scans.align);
    scans.bootstrap = arguments.bootstrap.unwrap_or(scans.bootstrap);
    scans.seed = arguments.seed.unwrap_or(scans.seed);
    Ok(())
}

/// An interface mesh of a file, which lies nowhere, or of a structure.
struct Mesh {
    plane: InterfaceMesh,
    frame: [[f64; 3]; 3],
    node_frames: Vec<[[f64; 3]; 3]>,
    positions: Option<Vec<[f64; 3]>>,
}

impl Mesh {
    fn place(&self) -> Placed<'_> {
        Placed {
            mesh: &self.plane,
            frame: self.frame,
            node_frames: &self.node_frames,
            positions: self.positions.as_deref(),
        }
    }
}

fn mesh(arguments: &Arguments, scene: &Scene) -> Result<Mesh> {
    let named = arguments
        .mesh
        .as_ref()
        .and_then(|name| benchmarks::find(name.to_str()?));
    match (&arguments.mesh, named) {
        (Some(path), None) => {
            let text = file_io::input::read_text(path, file_io::input::Kind::Table)?;
            let plane: PlaneMesh = files::parse(path, &text, "the mesh of an interface, with `nodes` and `elements`")?;
            let plane = plane
                .interface(arguments.mesh_units.metres(1.0))
                .with_context(|| format!("reading {}", path.display()))?;
            Ok(Mesh {
                plane,
                frame: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                node_frames: Vec::new(),
                positions: None,
            })
        }
        (_, named) => {
            let mut scene = scene.clone();
            if let Some(benchmark) = named {
                scene.structure = StructureSource::Benchmark(BenchmarkRef(benchmark)).into();
            }
            let joint = Structure::try_new(&scene, &Silent)?.joint;
            if joint.parts.len() > 1 {
                bail!(
                    "the scene {} has {} interfaces; characterise them one by one, each in a scene that names it alone",
                    scene.name,
                    joint.parts.len()
                );
            }
            Ok(Mesh {
                plane: joint.interface,
                frame: joint.frame,
                node_frames: joint.node_frames,
                positions: joint.positions,
            })
        }
    }
}

/// The element that is drawn.
fn shown(arguments: &Arguments, elements: &[ElementSurface]) -> Result<usize> {
    match arguments.element {
        Some(element) if element >= elements.len() => {
            bail!(
                "there is no element {element}; the interface has elements 0 to {}",
                elements.len() - 1
            )
        }
        Some(element) => Ok(element),
        None => {
            let mut order: Vec<usize> = (0..elements.len()).collect();
            order.sort_by(|&a, &b| elements[a].total_roughness().total_cmp(&elements[b].total_roughness()));
            Ok(order[order.len() / 2])
        }
    }
}

/// What is mapped over the interface: name of the file, quantity, unit and values.
fn quantities(elements: &[ElementSurface]) -> [(&'static str, &'static str, &'static str, Vec<f64>); 5] {
    let all = |of: &dyn Fn(&ElementSurface) -> f64| elements.iter().map(of).collect();
    [
        ("gap", "gap at the middle", "m", all(&|e| e.gap.at(e.gap.centre))),
        (
            "roughness",
            "total roughness R_t",
            "m",
            all(&ElementSurface::total_roughness),
        ),
        ("count", "asperities N", "-", all(&|e| e.population.count())),
        ("radius-x", "radius R_x", "m", all(&|e| e.population.radius()[0])),
        ("radius-y", "radius R_y", "m", all(&|e| e.population.radius()[1])),
    ]
}

fn outputs(
    surface: &ScannedSurface,
    place: Placed<'_>,
    shown: usize,
    study: Option<&[GapChange]>,
) -> Result<Vec<Output>> {
    let elements = &surface.found.elements;
    let mut outputs = Vec::new();
    for (name, quantity, unit, values) in quantities(elements) {
        outputs.push(Output::new(
            format!("map-{name}.svg"),
            map::svg(place, &values, quantity, unit),
        ));
    }
    let element = &elements[shown];
    for (side, name) in ["top", "bottom"].into_iter().enumerate() {
        let profile = surface.profile(shown, side)?;
        let title = format!("element {shown}, {name} face, y = {:.2} mm", 1e3 * profile.y);
        let picture = plot::profile(&profile, &title).context("drawing a profile")?;
        outputs.push(Output::new(format!("profile-{name}.svg"), picture));
    }
    let fits = FittedCurves::try_new(element.normal.parameters, element.tangential.map(|t| t.parameters))?;
    let draws = element.bands.as_ref().map_or(0, |bands| bands.realisations);
    let title = format!("element {shown}, 95 % bands of {draws} bootstrap draws");
    let picture = plot::response(element, &fits, &title).context("drawing the response")?;
    outputs.push(Output::new("response.svg", picture));
    outputs.push(Output::new("surface.vtu", fields::vtu(place, cells(elements))?));
    if let Some(study) = study {
        outputs.push(Output::new("registration.csv", registration(study)?));
    }
    let json = serde_json::to_string(&surface.report(study)).context("encoding the surface")?;
    outputs.push(Output::new(REPORT, json + "\n"));
    Ok(outputs)
}

fn cells(elements: &[ElementSurface]) -> Vec<CellField> {
    let field = |name, of: &dyn Fn(&ElementSurface) -> f64| CellField::scalar(name, elements.iter().map(of).collect());
    let mean = |of: fn(&surface_characterisation::FaceAsperities) -> f64| {
        move |e: &ElementSurface| 0.5 * (of(&e.faces[0]) + of(&e.faces[1]))
    };
    vec![
        field("gap [m]", &|e| e.gap.at(e.gap.centre)),
        field("total_roughness [m]", &ElementSurface::total_roughness),
        field("asperities [-]", &|e| e.population.count()),
        field("asperity_density [1/m^2]", &|e| e.population.asperity_density()),
        field("radius_x [m]", &|e| e.population.radius()[0]),
        field("radius_y [m]", &|e| e.population.radius()[1]),
        field("effective_radius [m]", &|e| e.population.effective_radius()),
        field("heights [-]", &|e| e.population.heights().len() as f64),
        field("Sa [m]", &mean(|f| f.areal.sa)),
        field("Sq [m]", &mean(|f| f.areal.sq)),
        field("points_top [-]", &|e| e.faces[0].points as f64),
        field("points_bottom [-]", &|e| e.faces[1].points as f64),
        field("fit_rms_normal [-]", &|e| e.normal.rms),
        field("fit_rms_tangential [-]", &|e| {
            e.tangential[0].rms.max(e.tangential[1].rms)
        }),
        field("fallback [-]", &|e| f64::from(u8::from(fell_back(e)))),
    ]
}

fn fell_back(element: &ElementSurface) -> bool {
    element.normal.fallback.is_some() || element.tangential.iter().any(|t| t.fallback.is_some())
}

fn registration(study: &[GapChange]) -> Result<String> {
    let headings = [
        "shift_x [m]",
        "shift_y [m]",
        "tilt_x [-]",
        "tilt_y [-]",
        "gap_mean_change [m]",
        "gap_rms_change [m]",
        "gap_largest_change [m]",
    ];
    let rows = study.iter().map(|change| {
        let ([x, y], [tx, ty]) = (change.registration.shift, change.registration.tilt);
        [x, y, tx, ty, change.mean, change.rms, change.largest].map(csv::number)
    });
    Ok(csv::table(headings, rows)?)
}

/// The machine-readable account of faces by their roughness parameters.
#[derive(serde::Serialize)]
struct FinishAccount<'a> {
    schema_version: u32,
    finish: &'a FinishReport,
    /// The patches of the ensemble.
    elements: &'a [ElementSurface],
}

fn finished_outputs(surface: &FinishedSurface) -> Result<Vec<Output>> {
    let account = FinishAccount {
        schema_version: SURFACE_SCHEMA_VERSION,
        finish: &surface.report,
        elements: &surface.patches,
    };
    let json = serde_json::to_string(&account).context("encoding the surface")?;
    Ok(vec![
        Output::new("law.csv", interval(&surface.report)?),
        Output::new(REPORT, json + "\n"),
    ])
}

/// The interval of the law as a table.
fn interval(report: &FinishReport) -> Result<String> {
    let law = &report.interval;
    let quantities = [
        ("normal [Pa]", &law.normal),
        ("normal_stiffness [Pa/m]", &law.normal_stiffness),
        ("tangential_x [Pa/m]", &law.tangential[0]),
        ("tangential_y [Pa/m]", &law.tangential[1]),
    ];
    let mut headings = vec!["interference [m]".to_owned()];
    for (name, _) in &quantities {
        headings.extend(PERCENTILES.map(|p| format!("{name} {p} %")));
    }
    let rows = law.interference.iter().enumerate().map(|(k, u)| {
        let values = quantities
            .iter()
            .flat_map(|(_, bounds)| bounds.iter().map(move |bound| bound[k]));
        std::iter::once(*u).chain(values).map(csv::number).collect::<Vec<_>>()
    });
    Ok(csv::table(headings, rows)?)
}

fn finished_account(surface: &FinishedSurface, outputs: &[Output], directory: &Path) -> String {
    let (report, mut out) = (&surface.report, String::new());
    // Writing to a string cannot fail.
    for line in &report.assumptions {
        let _ = writeln!(out, "assumed: {line}");
    }
    let law = &report.interval;
    let rms = report.sum.m0.sqrt();
    for part in [0.5, 1.0, 2.0, 4.0] {
        let k = law
            .interference
            .partition_point(|u| *u < part * rms)
            .min(law.interference.len() - 1);
        let [low, median, high] = law.normal.each_ref().map(|bound| bound[k]);
        let _ = writeln!(
            out,
            "at {:.2e} m: normal traction {median:.3e} Pa, from {low:.2e} to {high:.2e} Pa in nine of ten patches",
            law.interference[k]
        );
    }
    let names: Vec<&str> = outputs.iter().map(|o| o.name.as_str()).collect();
    let _ = writeln!(out, "written to {}: {}", directory.display(), names.join(", "));
    out
}

/// What is printed at the end.
fn account(surface: &ScannedSurface, study: Option<&[GapChange]>, outputs: &[Output], directory: &Path) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    for file in &surface.files {
        let [nx, ny] = file.points;
        let _ = writeln!(
            out,
            "{}: {}, {nx} x {ny} points, {} missing, positions in {}, heights in {}",
            file.path.display(),
            file.format,
            file.missing,
            file.lateral_unit,
            file.height_unit
        );
        if let Some(found) = &file.alignment {
            let [x, y] = found.shift;
            let _ = writeln!(out, "  moved onto the interface by {x:.3e} m, {y:.3e} m");
        }
        for note in &file.notes {
            let _ = writeln!(out, "  {note}");
        }
    }
    let found = surface.found.summary();
    let elements = &surface.found.elements;
    let _ = writeln!(
        out,
        "{} elements; {} with a fallback: {} of one asperity, {} power laws, {} constants",
        found.elements,
        elements.iter().filter(|e| fell_back(e)).count(),
        found.single_asperity,
        found.power_law,
        found.constant
    );
    for (_, quantity, unit, mut values) in quantities(elements) {
        values.sort_by(f64::total_cmp);
        let n = values.len();
        let _ = writeln!(
            out,
            "{quantity:>20} [{unit}]: median {:.3e}, from {:.3e} to {:.3e}",
            0.5 * (values[(n - 1) / 2] + values[n / 2]),
            values[0],
            values[n - 1]
        );
    }
    let [x, y] = found.median_rms_tangential;
    let _ = writeln!(
        out,
        "median rms residuals in ln: {:.3} of (28), {x:.3} and {y:.3} of (29)",
        found.median_rms_normal
    );
    for change in study.unwrap_or_default() {
        let (shift, tilt) = (change.registration.shift, change.registration.tilt);
        let _ = writeln!(
            out,
            "bottom face at ({:+.3e}, {:+.3e}) m, tilted by ({:+.0e}, {:+.0e}): gap {:+.2e} m, its shape by {:.2e} m rms",
            shift[0], shift[1], tilt[0], tilt[1], change.mean, change.rms
        );
    }
    let names: Vec<&str> = outputs.iter().map(|o| o.name.as_str()).collect();
    let _ = writeln!(out, "written to {}: {}", directory.display(), names.join(", "));
    out
}
