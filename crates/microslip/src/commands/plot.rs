//! `plot`: pictures for papers, from results that stand in folders.

use super::compare::{self, Overlaid};
use crate::files;
use crate::text::print;
use analyses::results::summary::Summary;
use anyhow::{Context, Result, bail, ensure};
use file_io::durable;
use file_io::input::{self, Kind as File};
use finite_elements::formats::vtu::{self, Surface};
use reports::modes::SHAPES;
use reports::names::{SUMMARY, amplitude_file};
use reports::overlay::Series;
use reports::paper::{self, Cost, Flux, Shape};
use reports::pdf;
use serde::Deserialize;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Options of `plot`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folders of results: of `run`; for backbones all that `compare` reads, for mode shapes of `model --modes`, for errors of
    /// `cargo xtask trade`.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// What is drawn.
    #[arg(long, value_enum)]
    kind: Kind,
    /// Mode of which maps and bands are drawn, if several were followed [default: the first].
    #[arg(long, value_name = "NUMBER")]
    mode: Option<usize>,
    /// Number of the amplitude, from 1, of which maps are drawn [default: the largest whose fields are stored].
    #[arg(long, value_name = "NUMBER")]
    amplitude: Option<usize>,
    /// File, as SVG or PDF by its extension [default: results/plot-KIND.svg].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum, PartialEq, Eq)]
enum Kind {
    /// Frequency and damping against amplitude, runs and measured backbones on shared axes.
    Backbone,
    /// Dissipation over the interfaces in their place, with the outlines of their holes.
    Flux,
    /// Mode shapes of the linearised structure.
    Modes,
    /// Bands from uncertain inputs, or of realisations of the faces.
    Bands,
    /// Errors of settings against their time.
    Trade,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Backbone => "backbone",
            Self::Flux => "flux",
            Self::Modes => "modes",
            Self::Bands => "bands",
            Self::Trade => "trade",
        }
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let kind = arguments.kind;
    let out = match &arguments.out {
        Some(path) => path.clone(),
        None => super::destination::default_directory(&format!("plot-{}.svg", kind.name()))?,
    };
    let extension = out.extension().and_then(|extension| extension.to_str());
    let Some(extension @ ("svg" | "pdf")) = extension else {
        bail!("--out {}: the name must end in .svg or .pdf", out.display());
    };
    for (given, option, kinds) in [
        (arguments.mode.is_some(), "--mode", &[Kind::Flux, Kind::Bands][..]),
        (arguments.amplitude.is_some(), "--amplitude", &[Kind::Flux]),
    ] {
        let names: Vec<&str> = kinds.iter().map(|kind| kind.name()).collect();
        ensure!(
            !given || kinds.contains(&kind),
            "{option} goes with --kind {} alone; for the backbone of another mode give its table, as mode-3-backbone.csv",
            names.join(" or ")
        );
    }
    let svg = match kind {
        Kind::Backbone => backbones(&arguments.runs)?,
        Kind::Flux => flux(&arguments.runs, arguments.mode, arguments.amplitude)?,
        Kind::Modes => modes(only(&arguments.runs, kind)?)?,
        Kind::Bands => bands(&arguments.runs, arguments.mode)?,
        Kind::Trade => trade(only(&arguments.runs, kind)?)?,
    };
    let contents = match extension {
        "pdf" => pdf::from_svg(&svg)?,
        _ => svg.into_bytes(),
    };
    if let Some(folder) = out.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))?;
    }
    durable::write(&out, &contents)?;
    print(&format!("written to {}\n", out.display()))
}

/// The folder of a picture that shows one.
fn only(folders: &[PathBuf], kind: Kind) -> Result<&Path> {
    match folders {
        [one] => Ok(one),
        _ => bail!(
            "--kind {} shows one folder, and {} are given",
            kind.name(),
            folders.len()
        ),
    }
}

fn backbones(paths: &[PathBuf]) -> Result<String> {
    let (quantity, found) = compare::overlaid(paths)?;
    let series: Vec<Series<'_>> = found.iter().map(Overlaid::series).collect();
    Ok(paper::backbones(&series, quantity)?)
}

fn name(folder: &Path) -> String {
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    name.unwrap_or_else(|| folder.display().to_string())
}

/// What stands in a file of a folder of results.
fn read(folder: &Path, file: &str) -> Result<Vec<u8>> {
    Ok(input::read(&folder.join(file), File::Table)?)
}

/// The summary as that of one mode, and the mode's number where it is not the first followed.
fn of_mode(folder: &Path, summary: &Summary, mode: Option<usize>) -> Result<(Option<usize>, Summary)> {
    let first = summary.first_mode();
    let wanted = mode.unwrap_or(first);
    let mut followed = Vec::new();
    for (further, of) in summary.by_mode() {
        let number = further.unwrap_or(first);
        if number == wanted {
            return Ok((further, of.into_owned()));
        }
        followed.push(number.to_string());
    }
    bail!(
        "{}: mode {wanted} was not followed, but {}; analyses.modes.followed of the scene says which are",
        folder.display(),
        followed.join(", ")
    )
}

/// Name of the field of dissipation.
const FLUX: &str = "flux_total [J/m^2]";

fn flux(folders: &[PathBuf], mode: Option<usize>, amplitude: Option<usize>) -> Result<String> {
    let mut all: Vec<(String, Surface, Vec<f64>)> = Vec::new();
    for folder in folders {
        let (further, summary) = of_mode(folder, &files::summary(folder)?, mode)?;
        let of = |number: usize| amplitude_file(further, number);
        let stored: Vec<usize> = (1..=summary.backbone.len())
            .filter(|&n| folder.join(of(n)).exists())
            .collect();
        let number = match amplitude {
            None => stored.last().copied(),
            Some(number) => Some(number).filter(|number| stored.contains(number)),
        };
        let number = number.with_context(|| {
            let known: Vec<String> = stored.iter().map(usize::to_string).collect();
            let known = if known.is_empty() { "none".into() } else { known.join(", ") };
            format!(
                "{}: the fields of {} are not stored, but those of {known}; name the amplitude in output.fields_at of the scene and run it again",
                folder.display(),
                amplitude.map_or_else(|| "any amplitude".into(), |number| format!("amplitude {number}")),
            )
        })?;
        let file = of(number);
        let path = folder.join(&file);
        let mut surface = vtu::read_surface(&path.display().to_string(), &read(folder, &file)?)?;
        let field = surface
            .face_fields
            .iter()
            .position(|field| field.name == FLUX && field.components == 1);
        let field = field.with_context(|| match surface.faces.is_empty() {
            true => format!(
                "{}: the interface is of points of contact, which have no area to map",
                path.display()
            ),
            false => format!(
                "{}: there is no field `{FLUX}`, which `microslip run` writes",
                path.display()
            ),
        })?;
        let values = surface.face_fields.swap_remove(field).values;
        let at = summary.backbone.get(number - 1).and_then(|b| b.response_displacement);
        let at = at.map_or_else(String::new, |x| format!(", {x:.3e} m"));
        all.push((format!("{}: amplitude {number}{at}", name(folder)), surface, values));
    }
    let fields: Vec<Flux<'_>> = (all.iter())
        .map(|(name, surface, values)| Flux {
            name: name.clone(),
            surface,
            values,
        })
        .collect();
    Ok(paper::flux(&fields)?)
}

/// What is read of the modes in the summary of `model`.
#[derive(Deserialize)]
struct Modal {
    axes: [[f64; 3]; 3],
    contacts: Vec<Contact>,
}

#[derive(Deserialize)]
struct Contact {
    contact: joints::structure::Contact,
    modes: Vec<Mode>,
}

#[derive(Deserialize)]
struct Mode {
    number: usize,
    frequency_hz: f64,
}

fn modes(folder: &Path) -> Result<String> {
    let path = folder.join(SUMMARY);
    let remedy = "`microslip model SCENE --modes 6 --out DIR` writes mode shapes";
    let summary: Value = files::parse(&path, &input::read_text(&path, File::Table)?, "a summary")?;
    // Of a run they are frequencies alone.
    let model = summary.get("modes").filter(|modes| modes.is_object());
    let model = model.with_context(|| format!("{}: there are no mode shapes; {remedy}", folder.display()))?;
    let model = Modal::deserialize(model).with_context(|| format!("{}: `modes`", path.display()))?;
    let file = folder.join(SHAPES);
    let surface = vtu::read_surface(&file.display().to_string(), &input::read(&file, File::Mesh)?)?;
    ensure!(
        !surface.faces.is_empty(),
        "{}: the file has no faces; {remedy}",
        file.display()
    );
    // The last is the nearest to what a run linearises.
    let of = model
        .contacts
        .last()
        .with_context(|| format!("{}: there are no modes; {remedy}", path.display()))?;
    let shape = |mode: &Mode| {
        let name = reports::modes::shape(of.contact, mode.number);
        let field = surface
            .point_fields
            .iter()
            .find(|field| field.name == name && field.components == 3);
        let field = field.with_context(|| format!("{}: there is no field `{name}`; {remedy}", file.display()))?;
        Ok(Shape {
            caption: format!("{}. {:.1} Hz", mode.number, mode.frequency_hz),
            displacement: field.values.as_chunks().0.to_vec(),
        })
    };
    let shapes = of.modes.iter().map(shape).collect::<Result<Vec<Shape>>>()?;
    Ok(paper::modes(&surface, model.axes, &shapes))
}

fn bands(folders: &[PathBuf], mode: Option<usize>) -> Result<String> {
    let mut all = Vec::new();
    for folder in folders {
        let summary = files::summary(folder)?;
        let (further, of) = of_mode(folder, &summary, mode)?;
        let number = further.unwrap_or(summary.first_mode());
        let found = paper::Spread::of(&name(folder), &of, number);
        all.push(found.with_context(|| {
            format!(
                "{}: the run has no bands of mode {number}; `microslip run SCENE --samples 100` makes them from `uncertain` of the scene, \
                 `--ensemble 20` from other realisations of the faces",
                folder.display()
            )
        })?);
    }
    Ok(paper::bands(&all)?)
}

/// What is read of `trade.json`.
#[derive(Deserialize)]
struct Trade {
    rungs: Vec<Rung>,
}

/// A setting; without time and errors where its run failed.
#[derive(Deserialize)]
struct Rung {
    dial: String,
    errors: Option<Errors>,
    seconds: Option<f64>,
}

#[derive(Deserialize)]
struct Errors {
    linear_frequency: f64,
    frequency_shift: Vec<Option<f64>>,
    damping_ln: Vec<Option<f64>>,
}

fn trade(folder: &Path) -> Result<String> {
    let path = if folder.is_dir() {
        folder.join("trade.json")
    } else {
        folder.to_owned()
    };
    let text = input::read_text(&path, File::Table)?;
    let trade: Trade = files::parse(&path, &text, "what `cargo xtask trade SCENE` writes")?;
    let mut dials: Vec<(String, Vec<Cost>)> = Vec::new();
    for rung in trade.rungs {
        let (Some(errors), Some(seconds)) = (rung.errors, rung.seconds) else {
            continue;
        };
        let linear = errors.linear_frequency;
        let shifts = errors
            .frequency_shift
            .iter()
            .flatten()
            .map(|shift| (linear + shift).abs());
        let cost = Cost {
            seconds,
            frequency: shifts.fold(linear.abs(), f64::max),
            damping_ln: errors.damping_ln.iter().flatten().map(|e| e.abs()).reduce(f64::max),
        };
        match dials.iter_mut().find(|(name, _)| *name == rung.dial) {
            Some((_, settings)) => settings.push(cost),
            None => dials.push((rung.dial, vec![cost])),
        }
    }
    ensure!(!dials.is_empty(), "{}: no setting was measured", path.display());
    Ok(paper::trade(&dials)?)
}
