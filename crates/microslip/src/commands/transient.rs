//! `transient`: a ring-down of a scene in time, identified and laid over the quasi-static backbones.

use super::identify::{table, trims};
use super::{Cache, Defaults, SceneArguments, default_directory, scene};
use crate::files::{self, Overwrite};
use crate::progress::Monitor;
use analyses::Run;
use analyses::comparison::{Backbone, Misfit, Point};
use analyses::transient::{Excitation, RingDown, Settings, backbones, ring_down, scene_for};
use anyhow::{Context, Result};
use host::results_of;
use joints::progress::Progress;
use joints::store::checkpoint::Checkpoints;
use modal_identification::average::average;
use modal_identification::backbone::Identification;
use modal_identification::signal::Quantity;
use reports::Output;
use reports::{csv, ring_down as ring_down_picture};
use scenes::Scene;
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

/// Name of the machine-readable account.
const REPORT: &str = "transient.json";

/// Options of `transient`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The scene [default of the tasks of the workspace: the coarse one of the benchmark]. Its amplitudes are replaced by
    /// those of the ring-down.
    #[command(flatten)]
    scene: SceneArguments,
    /// Displacement of the response point that the mode is released from, by linear estimate (m); the quasi-static
    /// backbones begin there.
    #[arg(long, value_name = "M", default_value_t = 2e-3)]
    amplitude: f64,
    /// Strike the response point instead: impulse of a half-sine of force (N s).
    #[arg(long, value_name = "NS", requires = "contact_time")]
    impulse: Option<f64>,
    /// Duration of that half-sine (s).
    #[arg(long, value_name = "S", requires = "impulse")]
    contact_time: Option<f64>,
    /// Periods of the linearised mode to follow.
    #[arg(long, value_name = "N", default_value_t = Settings::default().periods)]
    periods: usize,
    /// Steps per period.
    #[arg(long, value_name = "N", default_value_t = Settings::default().steps_per_period)]
    steps: usize,
    /// Spectral radius of the integration at infinite frequency, from 0 to 1.
    #[arg(long, value_name = "RHO", default_value_t = Settings::default().spectral_radius)]
    spectral_radius: f64,
    /// Viscous damping ratio of the other linearised modes (cqsma.modes of them), to quieten what the release excites.
    #[arg(long, value_name = "ZETA", default_value_t = Settings::default().other_damping)]
    other_damping: f64,
    /// Folder for signal.csv, backbone.csv, theory.csv, transient.svg and transient.json [default: a folder in results,
    /// named like the scene with `-transient`].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    cache: Cache,
}

/// What came of it.
struct Found {
    scene: Scene,
    ring: RingDown,
    identification: Identification,
    measured: Backbone,
    theories: Vec<(String, Backbone)>,
    /// Theory minus ring-down.
    misfits: Vec<(String, Misfit)>,
    /// Identification of a ring-down that has the first theory's backbone, minus that backbone.
    own_error: Option<Misfit>,
    seconds: f64,
    checkpoints: Checkpoints,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<()> {
    let given = match defaults.benchmark {
        Some(benchmark) if !arguments.scene.is_given() => scene::coarse(benchmark)?,
        _ => arguments.scene.read(defaults)?,
    };
    let scene = given.scene;
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}-transient", scene.name))?,
    };
    let folder = arguments
        .overwrite
        .open(&directory, &results_of("transient", &scene), &[REPORT])?;
    let settings = Settings {
        excitation: match (arguments.impulse, arguments.contact_time) {
            (Some(impulse), Some(duration)) => Excitation::Impact { impulse, duration },
            _ => Excitation::Release(arguments.amplitude),
        },
        periods: arguments.periods,
        steps_per_period: arguments.steps,
        spectral_radius: arguments.spectral_radius,
        other_damping: arguments.other_damping,
    };
    settings.validate()?;
    let options = arguments.cache.options(defaults);
    let monitor = Monitor::new()?;
    let scene = scene_for(scene, arguments.amplitude);
    let name = scene.name.clone();
    let found = analyses::run(&scene, &options, &monitor)
        .and_then(|run| follow(run, &settings, &monitor))
        .with_context(|| format!("following the scene {name}"));
    monitor.finish();
    let found = found?;
    let outputs = [
        Output::new("signal.csv", signal(&found)?),
        Output::new("backbone.csv", identified(&found)?),
        Output::new("theory.csv", theory(&found)?),
        Output::new("transient.svg", draw(&found)?),
        Output::new(REPORT, format!("{:#}\n", report(&found, &settings))),
    ];
    files::publish(folder, &outputs)?;
    found.checkpoints.remove();
    let names = outputs.each_ref().map(|o| o.name.as_str()).join(", ");
    let text = printed(&found);
    super::print(&format!("{text}written to {}: {names}\n", directory.display()))
}

fn follow(run: Run, settings: &Settings, progress: &dyn Progress) -> Result<Found, analyses::Error> {
    let began = Instant::now();
    let ring = ring_down(&run, settings, progress)?;
    let seconds = began.elapsed().as_secs_f64();
    let how = ring.identification();
    let (identification, measured) = ring.identify(&how)?;
    let theories = backbones(&run)?;
    let misfits = theories.iter();
    let misfits = misfits.filter_map(|(name, theory)| Some((name.clone(), theory.misfit(&measured)?)));
    let known = &theories[0].1;
    let own_error = ring.identified_again(known, &how)?.misfit(known);
    Ok(Found {
        scene: run.scene,
        checkpoints: run.checkpoints,
        misfits: misfits.collect(),
        own_error,
        ring,
        identification,
        measured,
        theories,
        seconds,
    })
}

/// The motion of the response point and the energies.
fn signal(found: &Found) -> Result<String> {
    let headings = [
        "time [s]",
        "acceleration [m/s^2]",
        "velocity [m/s]",
        "displacement [m]",
        "kinetic [J]",
        "kinetic_elsewhere [J]",
        "elastic [J]",
        "contact_work [J]",
        "viscous_work [J]",
        "external_work [J]",
    ];
    let rows = found.ring.transient.samples.iter().map(|s| {
        let e = s.energy;
        [
            s.time,
            s.acceleration,
            s.velocity,
            s.displacement,
            e.kinetic,
            e.kinetic_elsewhere,
            e.elastic,
            e.contact,
            e.viscous,
            e.external,
        ]
        .map(csv::number)
    });
    Ok(csv::table(headings, rows)?)
}

/// The backbone identified, as `identify` writes it.
fn identified(found: &Found) -> Result<String> {
    let mean = average(&[&found.identification.backbone], 2)?;
    table(&mean, Quantity::Acceleration)
}

fn theory(found: &Found) -> Result<String> {
    let headings = ["method", "amplitude [m/s^2]", "frequency_hz", "damping_ratio"];
    let rows = found.theories.iter().flat_map(|(name, backbone)| {
        let row = move |p: &Point| {
            let [x, f] = [p.amplitude, p.frequency_hz].map(csv::number);
            [name.clone(), x, f, csv::optional(p.damping_ratio)]
        };
        backbone.points().iter().map(row)
    });
    Ok(csv::table(headings, rows)?)
}

fn report(found: &Found, settings: &Settings) -> Value {
    let transient = &found.ring.transient;
    let identification = &found.identification;
    let first = transient.samples.first().map(|s| s.energy).unwrap_or_default();
    let last = transient.samples.last().map(|s| s.energy).unwrap_or_default();
    let start = match settings.excitation {
        Excitation::Release(amplitude) => json!({ "release_m": amplitude }),
        Excitation::Impact { impulse, duration } => json!({ "impulse_ns": impulse, "contact_time_s": duration }),
    };
    let misfits: Map<String, Value> = found.misfits.iter().map(|(n, m)| (n.clone(), json!(m))).collect();
    json!({
        "schema_version": 1,
        "scene": found.scene.name,
        "amplitude": { "quantity": "acceleration", "unit": "m/s^2", "place": "response point" },
        "start": start,
        "linearised_frequency_hz": found.ring.frequency_hz,
        "periods": settings.periods,
        "steps_per_period": settings.steps_per_period,
        "step_s": transient.step,
        "spectral_radius": settings.spectral_radius,
        "other_damping": settings.other_damping,
        "algorithmic_error": transient.algorithmic,
        "energy": {
            "first": first,
            "last": last,
            "error": transient.energy_error(),
            "kinetic_elsewhere": transient.share_elsewhere(),
        },
        "residual": transient.residual,
        "halved_steps": transient.halved_steps,
        "effort": transient.effort,
        "seconds": found.seconds,
        "identification": {
            "band_hz": identification.band_hz,
            "trims": trims(&identification.trims),
            "points": identification.backbone.len(),
            "frequency_divided_by": transient.algorithmic.frequency_ratio,
            "warnings": identification.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        },
        "theory_minus_ring_down": misfits,
        "identification_of_cqsma_minus_cqsma": found.own_error,
    })
}

fn draw(found: &Found) -> Result<String> {
    let samples = &found.ring.transient.samples;
    let signal: Vec<(f64, f64)> = samples.iter().map(|s| (s.time, s.acceleration)).collect();
    Ok(ring_down_picture::svg(&signal, &found.measured, &found.theories)?)
}

fn printed(found: &Found) -> String {
    let transient = &found.ring.transient;
    let [low, high] = found.measured.range();
    let mut out = String::new();
    // Writing into text does not fail.
    let _ = writeln!(
        out,
        "\n{} steps in {:.1} s ({:.2} ms each), energy kept within {:.1e}, {:.1e} of the kinetic energy outside the mode",
        transient.samples.len() - 1,
        found.seconds,
        1e3 * found.seconds / (transient.samples.len() - 1) as f64,
        transient.energy_error(),
        transient.share_elsewhere(),
    );
    let _ = writeln!(
        out,
        "damping ratio of the integration {:.1e}; its frequency error, {:.1e}, is taken out",
        transient.algorithmic.damping_ratio,
        transient.algorithmic.frequency_ratio - 1.0,
    );
    for warning in &found.identification.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    let _ = writeln!(
        out,
        "identified from {high:.3e} down to {low:.3e} m/s^2; difference from it:"
    );
    let _ = writeln!(
        out,
        "{:>24}  {:>19}  {:>21}  {:>17}",
        "", "amplitudes [m/s^2]", "frequency rms [Hz, %]", "damping rms [ln]"
    );
    let own = found.own_error.iter().map(|m| ("identification of cqsma", m));
    for (name, m) in found.misfits.iter().map(|(name, m)| (name.as_str(), m)).chain(own) {
        let _ = writeln!(out, "{}", line(name, m));
    }
    out
}

/// A misfit as a row.
pub(super) fn line(name: &str, m: &Misfit) -> String {
    let damping = m.damping_ln.map_or_else(|| "-".into(), |d| format!("{:.4}", d.rms));
    let [low, high] = m.amplitudes;
    let frequency = format!("{:.4}, {:.4}", m.frequency_hz.rms, m.frequency_percent.rms);
    format!(
        "{name:>24}  {:>19}  {frequency:>21}  {damping:>17}",
        format!("{low:.2e} to {high:.2e}")
    )
}
