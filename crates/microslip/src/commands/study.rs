//! `study`: many variants of a scene by a plan.

use super::defaults::Defaults;
use super::outcome::Outcome;
use super::resources::{Cache, Threads};
use super::run::Request;
use super::scene;
use crate::files::{Overwrite, publish};
use crate::progress::{Bar, Display};
use analyses::results::provenance::{Input, InputRole, Provenance};
use anyhow::{Context, Result, anyhow, bail};
use file_io::durable::{Identity, MANIFEST};
use host::{BENCHMARKS, benchmarks, forget_peak_memory, free_memory, peak_memory, provenance, results_of};
use joints::Options;
use parameter_studies::slurm::Job;
use parameter_studies::{
    Base, BaseScene, CSV, Counts, Machine, Memory, PARQUET, Part, Plan, Store, Study, Tally, outputs,
};
use rayon::ThreadPoolBuilder;
use reports::Output;
use reports::names::SUMMARY;
use reports::registry::is_complete;
use scenes::parse_json;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Folder of finished cases, in the cache or in that of the results.
const CASES: &str = "cases";

/// Folder of the cases that are run in full, in that of the results.
const RUNS: &str = "runs";

/// Digits of an address that name such a folder.
const SHORT: usize = 16;

/// What was run, beside the tables.
const ACCOUNT: &str = "study.json";

/// Measured sizes (bytes): of a line of the store apart from its amplitudes, of an amplitude in it, and of a row of both tables.
const SIZES: [f64; 3] = [190.0, 131.0, 291.0];

/// Options of `study`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The plan: a scene and what varies.
    plan: PathBuf,
    /// Folder for the results, made if missing; those of the same plan in it are replaced, other files are left alone.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What runs the cases.
    #[arg(long, value_name = "ENGINE", default_value = "local")]
    engine: Engine,
    /// Number of parts that the cases are divided into, each a task of the batch system; of the engine `local`, another word for --threads.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), conflicts_with = "threads")]
    workers: Option<u16>,
    /// Afterwards also run every distinct case in full, one after the other, as `run` does, each into a folder of its own in DIR/runs.
    #[arg(long, conflicts_with_all = ["part", "status"])]
    folders: bool,
    /// Option of `sbatch`, such as --slurm-option=--partition=long; may be given several times.
    #[arg(long, value_name = "OPT", allow_hyphen_values = true)]
    slurm_option: Vec<String>,
    /// Times that a part is submitted at most, if it ends before its cases are done.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    tries: u16,
    /// Seconds between two looks at the queue.
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=3600))]
    poll: u16,
    /// Run the K-th of N parts of the cases alone, and write no tables: what any batch system calls. Which cases a part has depends on the
    /// plan alone.
    #[arg(long, value_name = "K/N", conflicts_with_all = ["engine", "workers", "slurm_option", "tries", "poll"])]
    part: Option<Part>,
    /// Tell how many cases are done, have failed and are pending, without running any.
    #[arg(long)]
    status: bool,
    /// Run cases again that have failed or did not converge.
    #[arg(long)]
    retry_failed: bool,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    cache: Cache,
    #[command(flatten)]
    pub(super) display: Display,
}

/// What runs the cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Engine {
    /// This process.
    Local,
    /// Tasks of a job array of Slurm.
    Slurm,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
    let engine = arguments.engine;
    match (engine, arguments.workers) {
        (Engine::Slurm, None) => bail!("--engine slurm needs --workers N: the number of tasks that share the cases"),
        (Engine::Slurm, _) if arguments.folders => {
            bail!(
                "--folders runs cases in this process; give it to the same command without --engine slurm, which finds the cases done"
            )
        }
        _ => {}
    }
    if engine == Engine::Local && !arguments.slurm_option.is_empty() {
        bail!("--slurm-option belongs to --engine slurm");
    }
    let workers = arguments.workers.filter(|_| engine == Engine::Local);
    arguments.threads.or(workers).start()?;
    let machine = Here::new(rayon::current_num_threads(), arguments.display)?;
    let done = work(arguments, defaults, &machine);
    machine.bar.finish();
    done
}

fn work(arguments: &Arguments, defaults: &Defaults, machine: &Here) -> Result<Outcome> {
    let options = arguments.cache.options(defaults);
    let plan = Plan::read(&arguments.plan)?;
    let (base, mut inputs) = base_scene(&arguments.plan, &plan, defaults)?;
    inputs.insert(0, Input::of_file(InputRole::Plan, &arguments.plan)?);
    let study = Study::new(&arguments.plan, plan, base, &BENCHMARKS, options.build.clone())?;
    inputs.extend(study.inputs().iter().cloned());
    let provenance = provenance::of(inputs)?;
    let root = match &options.cache {
        Some(cache) => cache.join(CASES),
        None => arguments.out.join(CASES),
    };
    let range = study.part(arguments.part);
    let tell = |counts: &Counts, text: &str| arguments.display.conclude(&arguments.out, counts, text);
    let mut store = study.store(&root, range.clone())?;
    let name = file_name(&arguments.plan);
    if arguments.status {
        tell(
            &study.counts(range.clone(), &store),
            &status(&name, &study, &store, range),
        )?;
        return Ok(Outcome::Success);
    }
    let todo = study.pending(range.clone(), &store, arguments.retry_failed);
    if !todo.is_empty() {
        study.refuse_idle()?;
    }
    // Before the computation: it would be a pity to find out only afterwards.
    let folder = match arguments.part {
        Some(_) => None,
        None => {
            let identity = Identity::new("study", format!("{name} of {}", study.scene_name()));
            let names = [CSV, PARQUET, ACCOUNT, "report.html"];
            Some(
                arguments
                    .overwrite
                    .open_for(arguments.display, &arguments.out, &identity, &names)?,
            )
        }
    };
    announce(&name, &study, &store, range.clone(), todo.len(), machine)?;
    let (segments, tally) = match arguments.engine {
        Engine::Slurm if arguments.part.is_none() => {
            let job = job(arguments, &options)?;
            job.run(&study, &mut store, machine)?;
            (store.size(), Tally::default())
        }
        _ => {
            let tally = parameter_studies::run(&study, &store, &todo, &options, arguments.cache.memory, machine)?;
            store.refresh()?;
            (store.size(), tally)
        }
    };
    let counts = study.counts(range.clone(), &store);
    let Some(folder) = folder else {
        tell(&counts, &status(&name, &study, &store, range))?;
        return Ok(Outcome::Success);
    };
    let few = study.found_with_few(range.clone(), &store);
    let case_seconds: f64 = store.records().map(|record| record.seconds).sum();
    let account = json!({
        "plan": name,
        "scene": study.scene_name(),
        "parameters": study.columns().iter().map(|column| column.heading()).collect::<Vec<_>>(),
        "counts": counts,
        "hyper_reduction": few.map(|[amplitudes, few]| json!({ "amplitudes": amplitudes, "with_few_coordinates_and_points": few })),
        "engine": format!("{:?}", arguments.engine).to_lowercase(),
        "times": {
            "case_seconds": case_seconds,
            "run_now": { "cases": tally.cases, "case_seconds": tally.case_seconds, "structure_seconds": tally.structure_seconds,
                "teaching_seconds": tally.teaching_seconds,
                "seconds": tally.seconds },
            "total": machine.seconds(),
        },
        "store": { "folder": root.display().to_string(), "segments": segments.1, "bytes": segments.0, "lines": store.lines() },
        "peak_memory": peak_memory(),
        "provenance": &provenance,
    });
    let mut facts = vec![
        ("plan".to_owned(), name.clone()),
        ("cases".to_owned(), counts.cases.to_string()),
        ("distinct cases".to_owned(), counts.distinct.to_string()),
        ("distinct structures".to_owned(), counts.structures.to_string()),
        ("converged".to_owned(), counts.converged.to_string()),
        ("converged in part".to_owned(), counts.partly_converged.to_string()),
        ("failed".to_owned(), counts.failed.to_string()),
    ];
    if let Some([amplitudes, few]) = few {
        let figure = format!("{few} of {amplitudes} that converged");
        facts.push(("amplitudes with few coordinates and points".to_owned(), figure));
    }
    facts.extend(
        study
            .columns()
            .iter()
            .map(|column| ("parameter".to_owned(), column.heading())),
    );
    let mut files = outputs(&study, &store, &facts)?;
    let mut account = serde_json::to_vec_pretty(&account).context("encoding the account of the study")?;
    account.push(b'\n');
    files.push(Output::new(ACCOUNT, account));
    publish(folder, &files)?;
    let incomplete = match arguments.folders {
        true => in_full(arguments, &study, &options, &provenance, machine)?,
        false => 0,
    };
    machine.bar.finish();
    let text = format!(
        "{}{:.1} s of cases on one thread each; results, with report.html to begin with, in {}\n",
        status(&name, &study, &store, range),
        case_seconds,
        arguments.out.display()
    );
    tell(&counts, &text)?;
    Ok(match counts.failed + counts.partly_converged + incomplete {
        0 => Outcome::Success,
        _ => Outcome::Incomplete,
    })
}

/// Runs all distinct cases in full that have no folder yet, and gives the number of those that failed or did not converge.
fn in_full(
    arguments: &Arguments,
    study: &Study<'_>,
    options: &Options,
    provenance: &Provenance,
    machine: &Here,
) -> Result<usize> {
    let request = Request {
        ensemble: None,
        samples: None,
        estimate_error: None,
    };
    let mut incomplete = 0;
    for case in study.cases_in_full() {
        let (address, mut scene) = case?;
        let short = address.get(..SHORT).unwrap_or(address);
        let directory = arguments.out.join(RUNS).join(short);
        if directory.join(MANIFEST).exists() {
            continue;
        }
        scene.name = format!("{}-{short}", scene.name);
        let names = [SUMMARY, "report.html", "backbone.csv"];
        let folder =
            (arguments.overwrite).open_for(arguments.display, &directory, &results_of("run", &scene), &names)?;
        match request.compute(&scene, options, arguments.display) {
            Ok((run, mut summary)) => {
                summary.provenance = Some(provenance.clone());
                publish(folder, &reports::run::outputs(&run, &summary)?)?;
                run.checkpoints.remove();
                incomplete += usize::from(!is_complete(&summary));
            }
            Err(error) => {
                machine.line(&format!("case {short}: {error:#}"));
                incomplete += 1;
            }
        }
    }
    Ok(incomplete)
}

/// The scene of a plan, and the file that it is from.
fn base_scene(path: &Path, plan: &Plan, defaults: &Defaults) -> Result<(BaseScene, Vec<Input>)> {
    let parent = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let stem = |path: &Path| {
        path.file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
    };
    // Addresses of cases shall not depend on the folder that the command is called in.
    let absolute = |folder: &Path| {
        std::fs::canonicalize(folder).with_context(|| format!("finding the folder {}", folder.display()))
    };
    let (mut base, inputs) = match &plan.scene {
        Base::Inline(value) => {
            let base = BaseScene {
                value: value.clone(),
                name: stem(path),
                folder: Some(absolute(parent)?),
            };
            (base, Vec::new())
        }
        Base::Named(name) => {
            let file = parent.join(name);
            if file.exists() {
                let text = file_io::input::read_text(&file, file_io::input::Kind::Scene)?;
                let value = parse_json(&text).map_err(|message| anyhow!("{}: {message}", file.display()))?;
                let base = BaseScene {
                    value,
                    name: stem(&file),
                    folder: Some(absolute(file.parent().unwrap_or(parent))?),
                };
                (base, vec![Input::of_file(InputRole::Scene, &file)?])
            } else {
                let (own, text) = benchmarks::scene_text(name).map_err(|error| {
                    anyhow!(
                        "{}: scene = `{name}` is no file beside the plan, and no scene that comes with the program: {error}",
                        path.display()
                    )
                })?;
                let value = parse_json(text).map_err(|message| anyhow!("the built-in scene {own}: {message}"))?;
                let base = BaseScene {
                    value,
                    name: own.to_owned(),
                    folder: None,
                };
                (base, vec![Input::of_built_in_scene(own, text)])
            }
        }
    };
    scene::fill(&mut base.value, defaults);
    Ok((base, inputs))
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// How far a study is, in lines.
fn status(name: &str, study: &Study<'_>, store: &Store, range: std::ops::Range<usize>) -> String {
    let counts = study.counts(range, store);
    let done = counts.distinct - counts.pending;
    format!(
        "{name}: {} cases, {} distinct, structures: {}\ndone {done} (converged {}, converged in part {}, failed {}), pending {}\n",
        counts.cases,
        counts.distinct,
        counts.structures,
        counts.converged,
        counts.partly_converged,
        counts.failed,
        counts.pending
    )
}

/// Tells what will be run before it is.
fn announce(
    name: &str,
    study: &Study<'_>,
    store: &Store,
    range: std::ops::Range<usize>,
    todo: usize,
    machine: &Here,
) -> Result<()> {
    for name in study.left_out() {
        machine.line(&format!(
            "the scene asks for `{name}`, which studies leave out: they follow hysteresis loops alone"
        ));
    }
    let counts = study.counts(range, store);
    machine.line(&format!(
        "{name}: {} cases, {} distinct, structures to reduce: {}; {} done, {todo} to run",
        counts.cases,
        counts.distinct,
        counts.structures,
        counts.distinct - counts.pending
    ));
    let [line, amplitude, row] = SIZES;
    let rows = study.rows_per_case()? as f64;
    machine.line(&format!(
        "expected on disk: {:.1} MB of finished cases in {}, {:.1} MB of tables",
        1e-6 * counts.distinct as f64 * (line + amplitude * rows),
        store.root().display(),
        1e-6 * counts.cases as f64 * row * rows
    ));
    let known: Vec<f64> = store.records().map(|record| record.seconds).collect();
    if !known.is_empty() && todo > 0 {
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        machine.line(&format!(
            "expected time: {:.0} s of cases, by {} that are done",
            mean * todo as f64,
            known.len()
        ));
    }
    Ok(())
}

/// The job array that runs all parts.
fn job(arguments: &Arguments, options: &Options) -> Result<Job> {
    let absolute = |path: &Path| {
        let path = std::path::absolute(path).with_context(|| format!("finding {}", path.display()))?;
        Ok::<_, anyhow::Error>(path.display().to_string())
    };
    let program = std::env::current_exe().context("finding the program")?;
    let mut command = vec![
        program.display().to_string(),
        "study".into(),
        absolute(&arguments.plan)?,
    ];
    command.extend(["--out".into(), absolute(&arguments.out)?]);
    match &options.cache {
        Some(cache) => command.extend(["--cache".into(), absolute(cache)?]),
        None => command.push("--no-cache".into()),
    }
    if arguments.retry_failed {
        command.push("--retry-failed".into());
    }
    if let Some(memory) = arguments.cache.memory {
        command.extend(["--memory".into(), format!("{}MB", memory as f64 / 1e6)]);
    }
    Ok(Job {
        command,
        parts: arguments.workers.map_or(1, usize::from),
        options: arguments.slurm_option.clone(),
        tries: arguments.tries.into(),
        poll: arguments.poll.into(),
        folder: std::path::absolute(&arguments.out).context("finding the folder of the results")?,
        retry: arguments.retry_failed,
    })
}

/// This process: clock, threads, memory and display.
struct Here {
    bar: Bar,
    told: AtomicUsize,
    began: Instant,
    threads: usize,
}

impl Here {
    fn new(threads: usize, display: Display) -> Result<Self> {
        Ok(Self {
            bar: Bar::new("study", display)?,
            told: AtomicUsize::new(0),
            began: Instant::now(),
            threads,
        })
    }
}

impl Machine for Here {
    fn seconds(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    fn threads(&self) -> usize {
        self.threads
    }

    fn on_threads(&self, number: usize, work: &(dyn Fn() + Sync)) {
        std::thread::scope(|scope| {
            for _ in 0..number {
                scope.spawn(|| {
                    // A pool of this thread alone, so that parallel loops within a case stay on it.
                    let pool = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
                    work();
                    drop(pool);
                });
            }
        });
    }

    fn memory(&self) -> Option<Memory> {
        Some(Memory {
            peak: peak_memory()?,
            free: free_memory()?,
        })
    }

    fn forget_peak_memory(&self) {
        forget_peak_memory();
    }

    fn fraction(&self, done: f64) {
        self.bar.fraction(done);
        let tenths = (10.0 * done) as usize;
        if self.bar.is_plain() && self.told.fetch_max(tenths, Ordering::Relaxed) < tenths {
            let seconds = self.seconds();
            let left = self.bar.left(done).unwrap_or_default();
            self.line(&format!(
                "{:>3} % after {seconds:.0} s, about {left:.0} s left",
                10 * tenths
            ));
        }
    }

    fn line(&self, text: &str) {
        self.bar.line(text);
    }

    fn wait(&self, seconds: f64) {
        std::thread::sleep(Duration::from_secs_f64(seconds));
    }
}
