//! `compare`: a run over measured backbones, or over other runs.

use super::identify;
use crate::files::{self, Overwrite};
use crate::text::print;
use analyses::comparison::{Backbone, Experiment, Misfit, POINTS, Point, title};
use anyhow::{Context, Result, bail, ensure};
use file_io::durable::{Identity, Manifest};
use modal_identification::signal::Quantity;
use reports::Output;
use reports::csv::{number, table as csv_table};
use reports::names::SUMMARY;
use reports::overlay::{self, Series};
use reports::ring_down::RING_DOWN;
use reports::ring_down::misfit_line;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// What is said of every misfit.
const NORM: &str = "theory minus experiment; root mean square over amplitudes equally spaced in their logarithm over the common \
     range, each backbone linear over ln(amplitude) in frequency and in ln(damping ratio)";
const CONVERSION: &str = "amplitudes of theory are those of displacement times the power of its secant circular frequency; those \
     of an experiment are converted with its own frequency";

/// Options of `compare`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Results of a run: the folder, its summary.json or its backbone.csv.
    run: PathBuf,
    /// Backbones of `identify`: the folder, or its backbone.csv; the ring-down.csv of a run; or results of other runs, read like the first.
    #[arg(required = true, value_name = "EXPERIMENT")]
    experiments: Vec<PathBuf>,
    /// What amplitudes are [default: the quantity of the first experiment].
    #[arg(long, value_enum)]
    amplitude: Option<identify::Amplitude>,
    /// Folder for compare.csv, compare.svg and compare.json.
    #[arg(long, value_name = "DIR", default_value = "results/compare")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// The backbone of a run, over displacement, with its band of 5 to 95 % where there is one.
struct Theory {
    name: String,
    backbone: Backbone,
    band: Option<[Backbone; 2]>,
}

/// An experiment beside the theory.
struct Compared {
    experiment: Experiment,
    misfit: Misfit,
    /// Shares of the common amplitudes at which frequency and damping lie within the band.
    within: Option<[f64; 2]>,
}

/// A backbone of a run or of an experiment, with the edges of its band where there is one.
pub(super) struct Overlaid(Theory);

impl Overlaid {
    pub(super) fn series(&self) -> Series<'_> {
        Series {
            name: self.0.name.clone(),
            backbone: &self.0.backbone,
            dashes: None,
            band: self.0.band.as_ref().map(|[low, high]| [low, high]),
        }
    }
}

/// The backbones of runs and experiments over one quantity, that of the first experiment.
pub(super) fn overlaid(paths: &[PathBuf]) -> Result<(Quantity, Vec<Overlaid>)> {
    let results: Vec<Results> = paths.iter().map(|path| Results::read(path)).collect::<Result<_>>()?;
    let harmonic = results.iter().all(Results::may_be_harmonic);
    let measured = results.iter().find_map(|of| match of {
        Results::Measured(experiment) => Some(experiment.quantity),
        Results::Run(_) => None,
    });
    let quantity = measured.unwrap_or(Quantity::Displacement);
    let all = results.into_iter().map(|of| {
        Ok(Overlaid(match of {
            Results::Run(run) => run.theory(harmonic)?.over(quantity)?,
            Results::Measured(experiment) => {
                let Experiment { name, backbone, .. } = experiment.over(quantity)?;
                Theory {
                    name,
                    backbone,
                    band: None,
                }
            }
        }))
    });
    Ok((quantity, all.collect::<Result<_>>()?))
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let ran = match Results::read(&arguments.run)? {
        Results::Run(run) => run,
        Results::Measured(experiment) => bail!(
            "{}: `{}` is a measured backbone; give first a run (its folder, or its {SUMMARY}), then what it is compared with",
            arguments.run.display(),
            experiment.name
        ),
    };
    let references: Vec<Results> = (arguments.experiments.iter())
        .map(|path| Results::read(path))
        .collect::<Result<_>>()?;
    // Like with like: where one of the runs has no first harmonics, all are read by their secants.
    let harmonic = ran.is_harmonic() && references.iter().all(Results::may_be_harmonic);
    let theory = ran.theory(harmonic)?;
    let experiments: Vec<Experiment> = (references.into_iter())
        .map(|results| results.experiment(harmonic))
        .collect::<Result<_>>()?;
    let quantity = match (arguments.amplitude, experiments.first()) {
        (Some(amplitude), _) => amplitude.quantity(),
        (None, Some(first)) => first.quantity,
        (None, None) => bail!("there is no experiment"),
    };
    let theory = theory.over(quantity)?;
    let mut results = Vec::new();
    for experiment in experiments {
        let experiment = experiment.over(quantity)?;
        let Some(misfit) = theory.backbone.misfit(&experiment.backbone) else {
            let ([a, b], [c, d]) = (theory.backbone.range(), experiment.backbone.range());
            bail!(
                "{} and {} share no amplitude: {a:.3e} to {b:.3e} against {c:.3e} to {d:.3e} {}; run the scene with other \
                 analyses.backbone.amplitude_from and analyses.backbone.amplitude_to, or check the unit and the place of the sensor",
                theory.name,
                experiment.name,
                quantity.unit()
            )
        };
        let within = theory
            .band
            .as_ref()
            .and_then(|[low, high]| experiment.backbone.within(low, high));
        results.push(Compared {
            experiment,
            misfit,
            within,
        });
    }
    let outputs = [
        Output::new("compare.csv", table(&results)?),
        Output::new("compare.svg", draw(&theory, &results, quantity)?),
        Output::new("compare.json", format!("{:#}\n", report(&theory, &results, quantity))),
    ];
    let directory = &arguments.out;
    let names: Vec<&str> = results.iter().map(|r| r.experiment.name.as_str()).collect();
    let identity = Identity::new("compare", format!("{} with {}", theory.name, names.join(", ")));
    files::publish(arguments.overwrite.open(directory, &identity, &[])?, &outputs)?;
    let names = outputs.each_ref().map(|o| o.name.as_str()).join(", ");
    let text = printed(&theory, &results, quantity);
    print(&format!("{text}written to {}: {names}\n", directory.display()))
}

fn read(path: &Path) -> Result<String> {
    Ok(file_io::input::read_text(path, file_io::input::Kind::Table)?)
}

/// The table of a backbone, of a run or of what was identified.
const TABLE: &str = "backbone.csv";

/// Whether a command writes a backbone: that of a model, or of what was identified.
fn writes_backbone(command: &str) -> bool {
    let only = command.strip_prefix("run --only ").unwrap_or_default();
    ["run", "identify"].contains(&command) || only.split(',').any(|name| name == "backbone")
}

/// The file with the backbone: the path itself, or in a folder what its command has written there.
///
/// # Errors
/// The results are those of a command that writes no backbone.
fn file(path: &Path) -> Result<PathBuf> {
    let is_folder = path.is_dir();
    let folder = if is_folder { Some(path) } else { path.parent() };
    let is_listed = |manifest: &Manifest| {
        let name = path.file_name();
        is_folder || name.is_some_and(|name| manifest.files.keys().any(|listed| name == listed.as_str()))
    };
    let identity = match folder.map(Manifest::read) {
        Some(Ok(manifest)) => is_listed(&manifest).then_some(manifest.identity),
        Some(Err(error)) if is_folder && !matches!(error, file_io::durable::Error::NoManifest { .. }) => {
            return Err(error.into());
        }
        // A file may stand beside anything.
        _ => None,
    };
    if let Some(identity) = &identity
        && !writes_backbone(&identity.command)
        && !path.ends_with(RING_DOWN)
    {
        bail!(
            "{}: the results are those of {identity}, which have no backbone of frequency and damping over amplitude; give the folder of a \
             `run`, or as an experiment also one of `identify` or the {RING_DOWN} of a run",
            path.display(),
        );
    }
    if !is_folder {
        return Ok(path.to_owned());
    }
    let is_run = match &identity {
        Some(identity) => identity.command.starts_with("run"),
        None => path.join(SUMMARY).exists() || !path.join(TABLE).exists(),
    };
    Ok(path.join(if is_run { SUMMARY } else { TABLE }))
}

/// What is read of the summary of a run, whatever else it holds.
#[derive(Deserialize)]
struct Summary {
    backbone: Vec<Amplitude>,
    ensemble: Option<Ensemble>,
}

/// An amplitude, by its names in the summary and in the table; its values are missing where it did not converge, those of the first
/// harmonic also where another program wrote the summary.
#[derive(Deserialize)]
struct Amplitude {
    #[serde(alias = "response_displacement [m]")]
    response_displacement: Option<f64>,
    #[serde(alias = "frequency [Hz]")]
    frequency_hz: Option<f64>,
    #[serde(alias = "damping_ratio [-]")]
    damping_ratio: Option<f64>,
    #[serde(alias = "response_motion [m]")]
    response_motion: Option<f64>,
    #[serde(alias = "frequency_first_harmonic [Hz]")]
    frequency_first_harmonic_hz: Option<f64>,
    #[serde(alias = "damping_ratio_first_harmonic [-]")]
    damping_ratio_first_harmonic: Option<f64>,
}

impl Amplitude {
    fn point(&self, harmonic: bool) -> Option<Point> {
        Some(if harmonic {
            Point {
                amplitude: self.response_motion?,
                frequency_hz: self.frequency_first_harmonic_hz?,
                damping_ratio: self.damping_ratio_first_harmonic,
            }
        } else {
            Point {
                amplitude: self.response_displacement?,
                frequency_hz: self.frequency_hz?,
                damping_ratio: self.damping_ratio,
            }
        })
    }
}

#[derive(Deserialize)]
struct Ensemble {
    bands: Vec<Band>,
}

/// 5, 50 and 95 % at an amplitude.
#[derive(Deserialize)]
struct Band {
    response_displacement: f64,
    frequency_hz: [f64; 3],
    frequency_first_harmonic_hz: Option<[f64; 3]>,
    damping_ratio: [Option<f64>; 3],
}

impl Ensemble {
    /// The backbones of 5 and 95 %.
    fn edges(&self) -> Result<[Backbone; 2]> {
        let edge = |index: usize| {
            let points = self.bands.iter().map(|band| Point {
                amplitude: band.response_displacement,
                frequency_hz: band.frequency_first_harmonic_hz.unwrap_or(band.frequency_hz)[index],
                damping_ratio: band.damping_ratio[index],
            });
            Backbone::try_new("the edge of the band", points.collect())
        };
        Ok([edge(0)?, edge(2)?])
    }
}

/// A run as read.
struct Ran {
    path: PathBuf,
    summary: Summary,
}

impl Ran {
    fn is_harmonic(&self) -> bool {
        let mut amplitudes = self.summary.backbone.iter();
        amplitudes.any(|a| a.frequency_first_harmonic_hz.is_some())
    }

    /// Its backbone, of first harmonics or of secants.
    fn theory(&self, harmonic: bool) -> Result<Theory> {
        let (at, summary) = (self.path.display(), &self.summary);
        let points: Vec<Point> = summary.backbone.iter().filter_map(|a| a.point(harmonic)).collect();
        ensure!(
            !points.is_empty(),
            "none of the {} amplitudes of {at} converged: there is nothing to compare",
            summary.backbone.len()
        );
        let band = match &summary.ensemble {
            None => None,
            Some(ensemble) => Some(ensemble.edges().with_context(|| format!("{at}: `ensemble`"))?),
        };
        Ok(Theory {
            name: title(&self.path) + if harmonic { "" } else { " (secant)" },
            backbone: Backbone::try_new(&at.to_string(), points)?,
            band,
        })
    }
}

/// What a path leads to.
enum Results {
    Run(Ran),
    Measured(Experiment),
}

impl Results {
    fn read(path: &Path) -> Result<Self> {
        let path = file(path)?;
        let text = read(&path)?;
        if path.extension().is_none_or(|extension| extension != "csv") {
            let summary = files::parse(&path, &text, files::A_SUMMARY)?;
            return Ok(Self::Run(Ran { path, summary }));
        }
        let at = path.display().to_string();
        let mut table = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let header = table
            .headers()
            .with_context(|| format!("{at}: the first line"))?
            .clone();
        if header.iter().any(|name| name == "response_displacement [m]") {
            let summary = Summary {
                backbone: rows(table).with_context(|| format!("reading {at}"))?,
                ensemble: None,
            };
            return Ok(Self::Run(Ran { path, summary }));
        }
        Ok(Self::Measured(Experiment::of_table(&path, &text)?))
    }

    /// Whether it stands beside backbones of first harmonics: all but runs without them.
    fn may_be_harmonic(&self) -> bool {
        !matches!(self, Self::Run(run) if !run.is_harmonic())
    }

    fn experiment(self, harmonic: bool) -> Result<Experiment> {
        match self {
            Self::Measured(experiment) => Ok(experiment),
            Self::Run(run) => {
                let Theory { name, backbone, .. } = run.theory(harmonic)?;
                Ok(Experiment {
                    name,
                    backbone,
                    quantity: Quantity::Displacement,
                })
            }
        }
    }
}

fn rows<T: DeserializeOwned>(mut table: csv::Reader<&[u8]>) -> csv::Result<Vec<T>> {
    table.deserialize().collect()
}

impl Theory {
    fn over(self, quantity: Quantity) -> Result<Self> {
        let over = |backbone: &Backbone| backbone.differentiated(&self.name, quantity.derivatives());
        let band = match &self.band {
            None => None,
            Some([low, high]) => Some([over(low)?, over(high)?]),
        };
        Ok(Self {
            backbone: over(&self.backbone)?,
            band,
            name: self.name,
        })
    }
}

/// A backbone of `identify` or of a ring-down, or that of a run.
pub(super) fn experiment(path: &Path) -> Result<Experiment> {
    let results = Results::read(path)?;
    let harmonic = matches!(&results, Results::Run(run) if run.is_harmonic());
    results.experiment(harmonic)
}

/// One row per experiment; empty cells where there is no value.
fn table(results: &[Compared]) -> Result<String> {
    let mut headings: Vec<String> = ["experiment", "amplitude_from", "amplitude_to"].map(Into::into).into();
    for (name, unit) in [("frequency", "hz"), ("frequency", "percent"), ("damping", "ln")] {
        headings.extend(["mean", "rms", "largest"].map(|what| format!("{name}_{what}_{unit}")));
    }
    headings.extend(["damping_points", "frequency_within_band", "damping_within_band"].map(Into::into));
    let rows = results.iter().map(|r| {
        let m = &r.misfit;
        let mut row = vec![r.experiment.name.clone()];
        row.extend(m.amplitudes.map(number));
        for difference in [Some(m.frequency_hz), Some(m.frequency_percent), m.damping_ln] {
            row.extend(difference.map_or_else(Default::default, |d| [d.mean, d.rms, d.largest].map(number)));
        }
        row.push(m.damping_points.to_string());
        row.extend(r.within.map_or_else(Default::default, |within| within.map(number)));
        row
    });
    Ok(csv_table(headings, rows)?)
}

fn report(theory: &Theory, results: &[Compared], quantity: Quantity) -> Value {
    let points = |backbone: &Backbone| json!(backbone.points());
    let experiments: Vec<Value> = results
        .iter()
        .map(|r| {
            json!({
                "name": r.experiment.name,
                "measured": r.experiment.quantity.to_string(),
                "misfit": r.misfit,
                "within_band": r.within.map(|[f, zeta]| json!({ "frequency": f, "damping": zeta })),
                "backbone": points(&r.experiment.backbone),
            })
        })
        .collect();
    json!({
        "schema_version": 1,
        "amplitude": { "quantity": quantity.to_string(), "unit": quantity.unit(), "place": "response point" },
        "norm": NORM,
        "norm_amplitudes": POINTS,
        "conversion": CONVERSION,
        "theory": {
            "name": theory.name,
            "backbone": points(&theory.backbone),
            "band": theory.band.as_ref().map(|[low, high]| json!({ "5 %": points(low), "95 %": points(high) })),
        },
        "experiments": experiments,
    })
}

fn draw(theory: &Theory, results: &[Compared], quantity: Quantity) -> Result<String> {
    let mut series = vec![Series {
        name: format!("theory: {}", theory.name),
        backbone: &theory.backbone,
        dashes: None,
        band: theory.band.as_ref().map(|[low, high]| [low, high]),
    }];
    series.extend(results.iter().map(|r| Series {
        name: r.experiment.name.clone(),
        backbone: &r.experiment.backbone,
        dashes: Some((9, 4)),
        band: None,
    }));
    Ok(overlay::svg(&series, quantity)?)
}

fn printed(theory: &Theory, results: &[Compared], quantity: Quantity) -> String {
    let mut out = format!(
        "theory `{}` minus experiment, root mean square over the common range\n{:>24}  {:>19}  {:>21}  {:>17}\n",
        theory.name,
        "",
        format!("amplitudes [{}]", quantity.unit()),
        "frequency [Hz, %]",
        "damping [ln]"
    );
    for r in results {
        out += &(misfit_line(&r.experiment.name, &r.misfit) + "\n");
        if let Some([f, zeta]) = r.within {
            let _ = writeln!(
                out,
                "{:>24}  within the band: frequency at {:.0} %, damping at {:.0} % of the amplitudes",
                "",
                100.0 * f,
                100.0 * zeta
            );
        }
    }
    out
}
