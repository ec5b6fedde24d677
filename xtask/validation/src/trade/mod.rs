//! What accuracy costs, measured setting by setting.
//!
//! Every setting of every parameter is a run in a process of its own, one after another, so that time and memory are
//! its own. A setting is judged against the last one of its parameter.
//!
//! # Fields of `trade.json`
//!
//! `cargo xtask trade [SCENE]` writes `trade.json`, `trade.csv`, `trade.md`, `trade.svg` and `front.svg` into `results/trade`, and each run into `runs`.
//!
//! | field | meaning |
//! |---|---|
//! | `scene` | the scene about which one setting at a time is varied (SI) |
//! | `amplitudes[3]` | response amplitudes of the comparison (m); between points backbones are linear in ln(amplitude), frequency and ln(damping) |
//! | `rungs[].{name, dial, setting, status}` | one row per value: name, setting, value; `measured`, or `failed:` and why |
//! | `rungs[].errors.{linear_frequency, frequency_shift[3], damping_ln[3]}` | against the setting's reference: relative of the linearised frequency; of the frequency less the linearised one, relative to that; of the logarithm of the damping ratio |
//! | `rungs[].{seconds, structure_seconds, interface_seconds}` | time from nothing, and its parts: up to the reduced model, and after it (s) |
//! | `rungs[].{peak_memory, not_converged}` | of the run, or of the one that reduced its structure (bytes); amplitudes without a result |
//! | `pareto.{dial}`, `reference.{dial}` | values than which no other is both faster and nearer to the reference; the reference |
//! | `limits.{dial}[].{quantity, order, limit, uncertainty}` | Richardson's extrapolation of refined discretisations; `null` where the three finest do not approach a limit |
//! | `front.settings[].{name, seconds, frequency, damping_ln}` | all settings that model the same, against one run whose settings are all fine; `front` is `null` with `--only` |
//! | `front.best`, `front.physics` | names of the settings than which none is both faster and nearer; least and largest distance of f1 from the measured beam, over kinds of friction |
//! | `budget.parts.{dial}.{kind, frequency, damping_ln}` | `error`: of the scene's own setting, with the distance of the reference from its limit (of the mesh: `model.error_bar`); `choice`: largest difference between the models to choose from; `sampling`: 95 % end of the bootstrap of scans |
//! | `budget.root_sum_of_squares_of_errors` | of the parts of kind `error` |

mod front;
mod ladder;
mod page;
mod parameters;

use analyses::comparison::{Backbone, Point};
use analyses::results::summary::Summary;
use anyhow::{Context, Result, anyhow, bail};
use front::Front;
use ladder::{Ladder, Measured, Part, budget, exceeded, ladder, total};
use parameters::{AMPLITUDES, Parameter, Setting, Source};
use reports::Output;
use reports::names::SUMMARY;
use scenes::{EPMC, Scene};
use serde_json::{Map, Value, json};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The command that runs a scene: followed by the scene's file, `--out DIR` and perhaps `--ensemble K`, it writes `summary.json`
/// into that folder. Its working directory is the folder of the runs, and is where it should keep its cache.
pub struct Launcher {
    /// Program.
    pub program: PathBuf,
    /// Arguments before those.
    pub arguments: Vec<OsString>,
}

/// What is to be measured.
pub struct Plan {
    base: Scene,
    parameters: Vec<Parameter>,
    /// What all settings are compared with on one plane, if all are measured.
    truth: Option<Setting>,
}

impl Plan {
    /// The settings of `scene` that are named, all without any; `quick` on a coarse mesh and only what takes seconds on it. `meshes` are files of
    /// the scene's mesh from coarse to fine.
    ///
    /// # Errors
    /// An unknown name, listing those that exist; a scene that cannot be varied.
    pub fn try_new(mut scene: Scene, only: &[String], quick: bool, meshes: &[PathBuf]) -> Result<Self> {
        if !meshes.is_empty() && scene.structure.mesh().is_none() {
            bail!("--meshes: the structure of the scene {} is not a mesh file", scene.name);
        }
        // Runs have a working directory of their own.
        scene.resolve(&std::env::current_dir().context("finding the working directory")?);
        let meshes = meshes.iter().map(|path| {
            let found = path.canonicalize();
            found.with_context(|| format!("--meshes: finding the mesh file {}", path.display()))
        });
        let meshes = meshes.collect::<Result<Vec<_>>>()?;
        let base = parameters::base(scene, quick);
        let wanted = |name: &str| only.is_empty() || only.iter().any(|only| only == name);
        let mut parameters = parameters::all(&base, quick, &meshes, wanted)?;
        for name in only {
            if parameters.iter().all(|parameter| parameter.name != name) {
                let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
                bail!("there is no parameter `{name}`; there are {}", names.join(", "));
            }
        }
        parameters.retain(|parameter| wanted(parameter.name));
        let truth = only
            .is_empty()
            .then(|| parameters::truth(&base, quick, meshes.last().map(PathBuf::as_path)));
        Ok(Self {
            base,
            parameters,
            truth,
        })
    }

    /// Runs everything, or takes what an equal scene left in the folder `runs`. `show` is given a line after each run.
    ///
    /// # Errors
    /// The folder cannot be found, the scene itself fails, or a picture cannot be drawn.
    pub fn measure(self, runs: &Path, launcher: &Launcher, show: impl Fn(&str)) -> Result<Trade> {
        let runs = runs
            .canonicalize()
            .with_context(|| format!("finding the folder {}", runs.display()))?;
        let all = 1
            + usize::from(self.truth.is_some())
            + self
                .parameters
                .iter()
                .map(|parameter| parameter.settings.len())
                .sum::<usize>();
        let mut bench = Bench::new(runs, launcher, &show, all);
        let ladders: Vec<Ladder> = self
            .parameters
            .into_iter()
            .map(|parameter| {
                let measured = parameter
                    .settings
                    .iter()
                    .map(|setting| bench.run(parameter.name, setting))
                    .collect();
                ladder(parameter, measured)
            })
            .collect();
        // After the parameters, among whose settings it usually is.
        let own = bench.run("scene", &Setting::new("as it is", self.base.clone()));
        let own = own.map_err(|reason| anyhow!("the scene itself failed: {reason}"))?;
        let budget = budget(&ladders, &own);
        let mut report = report(&ladders, &self.base, &budget, &own);
        let front = match &self.truth {
            None => None,
            Some(truth) => {
                let measured = bench.run("truth", truth);
                let measured = measured.map_err(|reason| anyhow!("the run with all settings fine failed: {reason}"))?;
                Some(Front::new(&ladders, &own, &truth.scene, &measured))
            }
        };
        report["front"] = json!(front.as_ref().map(Front::json));
        let table = page::markdown(&ladders, &budget);
        let mut outputs = vec![
            Output::new("trade.csv", page::csv(&ladders)?),
            Output::new("trade.md", table.clone()),
            Output::new("trade.svg", page::pareto(&ladders)?),
        ];
        if let Some(front) = &front {
            outputs.push(Output::new("front.svg", page::front(front, &self.base.name)?));
        }
        outputs.push(Output::new("trade.json", format!("{report:#}\n")));
        let outcomes = || ladders.iter().flat_map(|ladder| &ladder.outcomes);
        Ok(Trade {
            outputs,
            table,
            failed: outcomes().filter(|outcome| outcome.measured.is_err()).count(),
            exceeded: exceeded(&ladders),
        })
    }
}

/// What was measured.
pub struct Trade {
    /// Its files.
    pub outputs: Vec<Output>,
    /// Markdown.
    pub table: String,
    /// Number of runs that failed.
    pub failed: usize,
    /// Settings that scenes can ask for whose errors are larger than promised, each with a sentence.
    pub exceeded: Vec<(&'static str, String)>,
}

/// What tells reduced structures apart in summaries: equal only where one was taken from the cache.
fn structure(summary: &Summary) -> impl PartialEq {
    let model = &summary.model;
    (
        [model.n_dofs, model.n_relative_dofs, model.n_modes],
        model.mass,
        model.stuck_frequencies_hz.clone(),
    )
}

/// Runs scenes one after another, each in its own process.
struct Bench<'a> {
    folder: PathBuf,
    launcher: &'a Launcher,
    show: &'a dyn Fn(&str),
    done: usize,
    all: usize,
    /// Scenes without their names, the reduced structures among them, and what was measured.
    known: Vec<(Value, Summary)>,
}

impl<'a> Bench<'a> {
    fn new(folder: PathBuf, launcher: &'a Launcher, show: &'a dyn Fn(&str), all: usize) -> Self {
        Self {
            folder,
            launcher,
            show,
            done: 0,
            all,
            known: Vec::new(),
        }
    }

    /// Runs a setting, or takes what an equal scene gave.
    fn run(&mut self, parameter: &str, setting: &Setting) -> Result<Measured, String> {
        self.done += 1;
        let slug: String = format!("{parameter}-{}", setting.name)
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
            .collect();
        let measured = self
            .summary(&slug, setting)
            .and_then(|summary| self.measured(setting, &summary))
            .map_err(|error| format!("{error:#}"));
        let account = match &measured {
            Ok(m) => format!("{:.1} s", m.seconds()),
            Err(reason) => format!("failed: {reason}"),
        };
        (self.show)(&format!(
            "{:>3} of {} {parameter}, {}: {account}",
            self.done, self.all, setting.name
        ));
        measured
    }

    fn summary(&mut self, slug: &str, setting: &Setting) -> Result<Summary> {
        let scene = comparable(&setting.scene, setting.source);
        if let Some((_, summary)) = self.known.iter().find(|(known, _)| *known == scene) {
            return Ok(summary.clone());
        }
        let folder = self.folder.join(slug);
        let path = folder.join(SUMMARY);
        let earlier = std::fs::read_to_string(&path).ok();
        let earlier = earlier.and_then(|text| serde_json::from_str::<Summary>(&text).ok());
        // A run that is there was measured as this one would be, if its scene is the same.
        let kept = earlier.filter(|summary| of_summary(summary, setting.source) == scene);
        let summary = match kept {
            Some(summary) => summary,
            None => self.measure(slug, setting, &folder)?,
        };
        self.known.push((scene, summary.clone()));
        Ok(summary)
    }

    fn measure(&self, slug: &str, setting: &Setting, folder: &Path) -> Result<Summary> {
        std::fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))?;
        let path = folder.join("scene.json");
        let mut scene = setting.scene.clone();
        scene.name = slug.into();
        let text = serde_json::to_string_pretty(&scene).context("encoding the scene")?;
        std::fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
        let mut command = Command::new(&self.launcher.program);
        command
            .args(&self.launcher.arguments)
            .arg(&path)
            .arg("--out")
            .arg(folder);
        if let Source::Ensemble(count) = setting.source {
            command.args(["--ensemble", &count.to_string()]);
        }
        // The cache of reduced structures is relative to the working directory.
        command.current_dir(&self.folder).stdin(Stdio::null());
        let output = command.output().with_context(|| format!("starting the run {slug}"))?;
        // Exit code 3: some amplitudes did not converge, which the summary counts.
        if !matches!(output.status.code(), Some(0 | 3)) {
            let messages = String::from_utf8_lossy(&output.stderr);
            return Err(anyhow!(
                "{}",
                messages.lines().last().unwrap_or("the run ended without a message")
            ));
        }
        let path = folder.join(SUMMARY);
        let text = std::fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))?;
        serde_json::from_str(&text).with_context(|| format!("{} is not the summary of a run", path.display()))
    }

    /// Seconds and memory of reducing the structure of a run, from the run that did it: others took it from the cache, also where their
    /// scenes spell out what is the default.
    fn structure_of(&self, summary: &Summary) -> (f64, Option<u64>) {
        let known = self.known.iter().map(|(_, known)| known);
        let same = known.filter(|known| structure(known) == structure(summary));
        let longest = same.max_by(|a, b| structure_seconds(a).total_cmp(&structure_seconds(b)));
        longest.map_or((0.0, None), |run| (structure_seconds(run), run.peak_memory))
    }

    fn measured(&self, setting: &Setting, summary: &Summary) -> Result<Measured> {
        let mode = setting.scene.analyses.modes.followed[0] - 1;
        let linear = summary
            .modes
            .get(mode)
            .context("the summary has no linearised frequency")?;
        let points: Vec<Point> = match setting.source {
            Source::Loops => {
                let points = summary.backbone.iter();
                points
                    .filter_map(|b| point(b.response_displacement, b.frequency_hz, b.damping_ratio))
                    .collect()
            }
            Source::Method(method) => {
                let points = summary.methods.get(method);
                points
                    .context("the summary has no backbone of the method")?
                    .iter()
                    .filter_map(|m| point(m.response_displacement, m.frequency_hz, m.damping_ratio))
                    .collect()
            }
            Source::RingDown => {
                let found = summary.ring_down.as_ref().context("the summary has no ring-down")?;
                if let Some(failure) = &found.failure {
                    bail!("{failure}");
                }
                let points = found.backbone.iter();
                points
                    .filter_map(|b| {
                        point(
                            Some(b.response_displacement),
                            Some(b.frequency_hz),
                            Some(b.damping_ratio),
                        )
                    })
                    .collect()
            }
            Source::Ensemble(_) => {
                let ensemble = summary.ensemble.as_ref().context("the summary has no ensemble")?;
                let upper = ensemble.bands.iter();
                upper
                    .filter_map(|b| {
                        point(
                            Some(b.response_displacement),
                            Some(b.frequency_hz[2]),
                            b.damping_ratio[2],
                        )
                    })
                    .collect()
            }
        };
        let not_converged = setting.scene.analyses.backbone.amplitudes.saturating_sub(points.len());
        let own = match setting.source {
            Source::Loops => "backbone",
            Source::Method(EPMC) => EPMC,
            Source::Method(_) => "methods",
            Source::RingDown => "transient",
            Source::Ensemble(_) => "ensemble",
        };
        let (structure, memory) = self.structure_of(summary);
        Ok(Measured {
            linear: linear.frequency_hz,
            backbone: Backbone::try_new(&setting.name, points)?,
            structure_seconds: structure,
            interface_seconds: seconds(summary, &["characterise", "prestress", "modes", own]),
            peak_memory: summary.peak_memory.max(memory),
            error_bar: summary.model.error_bar.clone(),
            not_converged,
        })
    }
}

/// A point of a backbone, where the amplitude converged.
fn point(amplitude: Option<f64>, frequency_hz: Option<f64>, damping_ratio: Option<f64>) -> Option<Point> {
    Some(Point {
        amplitude: amplitude?,
        frequency_hz: frequency_hz?,
        damping_ratio,
    })
}

/// Seconds of these stages together.
fn seconds(summary: &Summary, stages: &[&str]) -> f64 {
    let of = |stage: &&str| summary.timings.get(*stage).copied().unwrap_or(0.0);
    stages.iter().map(of).sum()
}

fn structure_seconds(summary: &Summary) -> f64 {
    seconds(summary, &["mesh", "assemble", "factor", "reduce"])
}

/// A scene as its summary has it, without its name, and what else is computed.
fn comparable(scene: &Scene, source: Source) -> Value {
    without_name(json!(scene), source)
}

fn of_summary(summary: &Summary, source: Source) -> Value {
    let members = summary.ensemble.as_ref().map_or(0, |ensemble| ensemble.realisations);
    let asked = match source {
        Source::Ensemble(count) => usize::from(count),
        _ => 0,
    };
    if members == asked {
        without_name(summary.scene.clone(), source)
    } else {
        Value::Null
    }
}

fn without_name(mut scene: Value, source: Source) -> Value {
    if let Some(object) = scene.as_object_mut() {
        object.remove("name");
    }
    let ensemble = match source {
        Source::Ensemble(count) => count,
        _ => 0,
    };
    json!([scene, ensemble])
}

/// What `trade.json` holds.
fn report(ladders: &[Ladder], base: &Scene, budget: &[Part], own: &Measured) -> Value {
    let [frequency, damping_ln] = total(budget);
    let mut settings = Vec::new();
    let (mut pareto, mut reference, mut orders) = (Map::new(), Map::new(), Map::new());
    for ladder in ladders {
        let parameter = &ladder.parameter;
        let name = |setting: &Setting| format!("{}: {}", parameter.name, setting.name);
        for (setting, outcome) in parameter.settings.iter().zip(&ladder.outcomes) {
            let mut row = json!({
                "name": name(setting),
                "dial": parameter.name,
                "setting": setting.name,
                "errors": outcome.errors.map(|errors| json!({
                    "linear_frequency": errors.linear,
                    "frequency_shift": errors.shift,
                    "damping_ln": errors.damping,
                })),
                "status": match &outcome.measured {
                    Ok(_) => "measured".to_owned(),
                    Err(reason) => format!("failed: {reason}"),
                },
            });
            if let Ok(measured) = &outcome.measured {
                let backbone = AMPLITUDES.map(|a| measured.backbone.at(a));
                row["seconds"] = json!(measured.structure_seconds + measured.interface_seconds);
                row["structure_seconds"] = json!(measured.structure_seconds);
                row["interface_seconds"] = json!(measured.interface_seconds);
                row["peak_memory"] = json!(measured.peak_memory);
                row["not_converged"] = json!(measured.not_converged);
                row["linear_frequency_hz"] = json!(measured.linear);
                row["frequency_hz"] = json!(backbone.map(|at| at.map(|(f, _)| f)));
                row["damping_ratio"] = json!(backbone.map(|at| at.and_then(|(_, zeta)| zeta)));
            }
            settings.push(row);
        }
        let best = parameter
            .settings
            .iter()
            .zip(&ladder.outcomes)
            .filter(|(_, o)| o.pareto);
        pareto.insert(
            parameter.name.into(),
            best.map(|(setting, _)| json!(setting.name)).collect(),
        );
        reference.insert(
            parameter.name.into(),
            json!(parameter.settings.last().map(|setting| &setting.name)),
        );
        let limits = ladder.limits.iter().map(|limit| {
            json!({
                "quantity": limit.quantity,
                "order": limit.extrapolation.map(|e| e.order),
                "limit": limit.extrapolation.map(|e| e.limit),
                "uncertainty": limit.uncertainty,
            })
        });
        orders.insert(parameter.name.into(), limits.collect());
    }
    json!({
        "scene": base,
        "amplitudes": AMPLITUDES,
        "rungs": settings,
        "pareto": pareto,
        "reference": reference,
        "limits": orders,
        "budget": {
            "parts": budget.iter().map(|part| {
                let row = json!({"kind": part.kind.name(), "frequency": part.frequency, "damping_ln": part.damping_ln});
                (part.parameter.to_owned(), row)
            }).collect::<Map<_, _>>(),
            "root_sum_of_squares_of_errors": {"frequency": frequency, "damping_ln": damping_ln},
        },
        "structure": {"seconds": own.structure_seconds, "peak_memory": own.peak_memory},
    })
}
