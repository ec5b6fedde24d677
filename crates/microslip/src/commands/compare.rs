//! `compare`: a run over measured backbones.

use super::identify::Amplitude;
use super::transient::line;
use crate::files;
use anyhow::{Context, Result, bail, ensure};
use joint_pipeline::analysis::comparison::{Backbone, Misfit, POINTS, Point};
use modal_identification::signal::{Quantity, Unit};
use reports::Output;
use reports::overlay::{self, Series};
use reports::run::SUMMARY;
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
    /// Results of a run: the folder, or its summary.json.
    run: PathBuf,
    /// Backbones of `identify` or `transient`: the folder, or its backbone.csv.
    #[arg(required = true, value_name = "EXPERIMENT")]
    experiments: Vec<PathBuf>,
    /// What amplitudes are [default: the quantity of the first experiment].
    #[arg(long, value_enum)]
    amplitude: Option<Amplitude>,
    /// Folder for compare.csv, compare.svg and compare.json.
    #[arg(long, value_name = "DIR", default_value = "results/compare")]
    out: PathBuf,
}

/// The backbone of a run, over displacement, with its band of 5 to 95 % where there is one.
struct Theory {
    name: String,
    backbone: Backbone,
    band: Option<[Backbone; 2]>,
}

struct Experiment {
    name: String,
    backbone: Backbone,
    quantity: Quantity,
}

/// An experiment beside the theory.
struct Compared {
    experiment: Experiment,
    misfit: Misfit,
    /// Shares of the common amplitudes at which frequency and damping lie within the band.
    within: Option<[f64; 2]>,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let theory = Theory::read(&arguments.run)?;
    let experiments: Vec<Experiment> = (arguments.experiments.iter())
        .map(|path| Experiment::read(path))
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
                 cqsma.amplitude_from and cqsma.amplitude_to, or check the unit and the place of the sensor",
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
        Output::new("compare.csv", table(&results)),
        Output::new("compare.svg", draw(&theory, &results, quantity)?),
        Output::new("compare.json", format!("{:#}\n", report(&theory, &results, quantity))),
    ];
    let directory = &arguments.out;
    std::fs::create_dir_all(directory).with_context(|| format!("making the folder {}", directory.display()))?;
    files::write_all(directory, &outputs)?;
    let names = outputs.each_ref().map(|o| o.name.as_str()).join(", ");
    let text = printed(&theory, &results, quantity);
    super::print(&format!("{text}written to {}: {names}\n", directory.display()))
}

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))
}

/// The file itself, or the one of this name in a folder.
fn file(path: &Path, name: &str) -> PathBuf {
    if path.is_dir() {
        path.join(name)
    } else {
        path.to_owned()
    }
}

/// Name for tables: that of the folder, for a file with a name of its own also that.
fn title(path: &Path, usual: &str) -> String {
    let name = |path: Option<&Path>| path.and_then(Path::file_name).map(|n| n.to_string_lossy().into_owned());
    match (name(path.parent()), name(Some(path))) {
        (Some(folder), Some(file)) if file == usual => folder,
        (Some(folder), Some(file)) => format!("{folder}/{file}"),
        (None, Some(file)) => file,
        _ => path.display().to_string(),
    }
}

impl Theory {
    fn read(path: &Path) -> Result<Self> {
        let path = file(path, SUMMARY);
        let at = path.display();
        let summary: Value = serde_json::from_str(&read(&path)?).with_context(|| format!("{at} is not JSON"))?;
        let Some(all) = summary.get("backbone").and_then(Value::as_array) else {
            bail!("{at} has no list `backbone`; it must be the summary of a run")
        };
        let number = |b: &Value, name: &str| b.get(name).and_then(Value::as_f64);
        let points: Vec<Point> = all
            .iter()
            .filter_map(|b| {
                Some(Point {
                    amplitude: number(b, "response_displacement")?,
                    frequency_hz: number(b, "frequency_hz")?,
                    damping_ratio: number(b, "damping_ratio"),
                })
            })
            .collect();
        ensure!(
            !points.is_empty(),
            "none of the {} amplitudes of {at} converged: there is nothing to compare",
            all.len()
        );
        let band = match summary.get("ensemble") {
            None | Some(Value::Null) => None,
            Some(ensemble) => Some(band(ensemble).with_context(|| format!("{at}: `ensemble`"))?),
        };
        Ok(Self {
            name: title(&path, SUMMARY),
            backbone: Backbone::try_new(&at.to_string(), points)?,
            band,
        })
    }

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

/// The 5 and 95 % edges of `{"response_displacement": [..], "quantiles": [0.05, 0.5, 0.95], "frequency_hz": [[..], ..],
/// "damping_ratio": [[..], ..]}`: one list per quantile over the displacements (m).
fn band(ensemble: &Value) -> Result<[Backbone; 2]> {
    let list = |value: &Value, name: &str| -> Result<Vec<Option<f64>>> {
        let list = value.as_array().with_context(|| format!("`{name}` is not a list"))?;
        Ok(list.iter().map(Value::as_f64).collect())
    };
    let field = |name: &str| ensemble.get(name).with_context(|| format!("`{name}` is missing"));
    let amplitudes = list(field("response_displacement")?, "response_displacement")?;
    let quantiles = list(field("quantiles")?, "quantiles")?;
    let edge = |quantile: f64| -> Result<Backbone> {
        let same = |q: &Option<f64>| q.is_some_and(|q| (q - quantile).abs() < 1e-9);
        let at = quantiles.iter().position(same);
        let at = at.with_context(|| format!("`quantiles` has no {quantile}"))?;
        let of = |name: &str| -> Result<Vec<Option<f64>>> {
            let values = field(name)?
                .get(at)
                .with_context(|| format!("`{name}` has no list {}", at + 1))?;
            let values = list(values, name)?;
            ensure!(
                values.len() == amplitudes.len(),
                "`{name}` has {} values for {} amplitudes",
                values.len(),
                amplitudes.len()
            );
            Ok(values)
        };
        let (frequencies, dampings) = (of("frequency_hz")?, of("damping_ratio")?);
        let points = amplitudes.iter().zip(frequencies).zip(dampings);
        let points = points.filter_map(|((x, f), damping_ratio)| {
            Some(Point {
                amplitude: (*x)?,
                frequency_hz: f?,
                damping_ratio,
            })
        });
        Ok(Backbone::try_new("the edge of the band", points.collect())?)
    };
    Ok([edge(0.05)?, edge(0.95)?])
}

impl Experiment {
    fn read(path: &Path) -> Result<Self> {
        let path = file(path, "backbone.csv");
        let text = read(&path)?;
        let at = path.display();
        let mut lines = text.lines().enumerate();
        let header: Vec<&str> = lines.next().map(|(_, l)| l.split(',').collect()).unwrap_or_default();
        let column = |wanted: &str| header.iter().position(|name| name.trim() == wanted);
        let (Some(first), Some(frequency), Some(damping)) =
            (header.first(), column("frequency_hz"), column("damping_ratio"))
        else {
            bail!(
                "{at}: the first line must name the columns `amplitude [unit]`, `frequency_hz` and `damping_ratio`, as \
                 `identify` writes them"
            )
        };
        let unit = first
            .trim()
            .strip_prefix("amplitude [")
            .and_then(|rest| rest.strip_suffix(']'));
        let unit = unit.with_context(|| format!("{at}: the first column is `{first}`, not `amplitude [unit]`"))?;
        let unit: Unit = unit.parse().with_context(|| format!("{at}: the first line"))?;
        let mut points = Vec::new();
        for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            let number = |column: usize| -> Result<f64> {
                let cell = cells.get(column).copied().unwrap_or_default();
                let name = header[column];
                cell.parse()
                    .with_context(|| format!("{at}, line {}, column `{name}`: `{cell}` is no number", index + 1))
            };
            points.push(Point {
                amplitude: unit.scale * number(0)?,
                frequency_hz: number(frequency)?,
                damping_ratio: Some(number(damping)?),
            });
        }
        Ok(Self {
            name: title(&path, "backbone.csv"),
            backbone: Backbone::try_new(&at.to_string(), points)?,
            quantity: unit.quantity,
        })
    }

    fn over(self, quantity: Quantity) -> Result<Self> {
        let more = quantity.derivatives() - self.quantity.derivatives();
        Ok(Self {
            backbone: self.backbone.differentiated(&self.name, more)?,
            ..self
        })
    }
}

/// One row per experiment; empty cells where there is no value.
fn table(results: &[Compared]) -> String {
    let mut out = String::from("experiment,amplitude_from,amplitude_to");
    for (name, unit) in [("frequency", "hz"), ("frequency", "percent"), ("damping", "ln")] {
        for what in ["mean", "rms", "largest"] {
            let _ = write!(out, ",{name}_{what}_{unit}");
        }
    }
    out += ",damping_points,frequency_within_band,damping_within_band\n";
    for r in results {
        let m = &r.misfit;
        let [low, high] = m.amplitudes;
        let _ = write!(out, "\"{}\",{low:?},{high:?}", r.experiment.name.replace('"', "\"\""));
        for d in [Some(m.frequency_hz), Some(m.frequency_percent), m.damping_ln] {
            let cells = d.map_or_else(Default::default, |d| {
                [d.mean, d.rms, d.largest].map(|v| format!("{v:?}"))
            });
            let _ = write!(out, ",{}", cells.join(","));
        }
        let [f, zeta] = r.within.map_or_else(Default::default, |w| w.map(|v| format!("{v:?}")));
        let _ = writeln!(out, ",{},{f},{zeta}", m.damping_points);
    }
    out
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
    let label = format!("{quantity} amplitude at the response point [{}]", quantity.unit());
    Ok(overlay::svg(&series, &label)?)
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
        out += &(line(&r.experiment.name, &r.misfit) + "\n");
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
