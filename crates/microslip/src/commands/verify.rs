//! `verify`: whether results are as they were written, sound, and what the program computes again.

use super::run::{ErrorOf, Request};
use crate::check::{self, Demand};
use crate::progress::Display;
use crate::text::print;
use analyses::results::provenance::{Provenance, arithmetic_fingerprint};
use analyses::results::summary::Summary;
use anyhow::{Context, Result, bail, ensure};
use file_io::durable::Manifest;
use host::provenance;
use joints::Options;
use reports::registry::is_of_some_run;
use reports::run::outputs;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Relative difference that is allowed of numbers where arithmetic or program differ.
const TOLERANCE: f64 = 1e-6;

/// Fields of the summary that are not results: inputs, where they and the settings come from, and what the computer spent.
const NOT_RESULTS: [&str; 6] = ["scene", "adaptation", "provenance", "timings", "work", "peak_memory"];

/// Fields that round-off decides: how much work was done, what was left of residuals, and what follows from that; the common motion around bolts that
/// hardly have one.
const OF_ROUND_OFF: [&str; 17] = [
    "coarse_loop_area",
    "connections",
    "damping_floor",
    "equilibrium_error",
    "error",
    "evaluations",
    "factorisations",
    "iterations",
    "krylov_steps",
    "load_points",
    "loop_closure",
    "penalty_spectrum_error",
    "reduction_asymmetry",
    "residual",
    "residual_ratio",
    "shape_deviation",
    "skipped",
];

/// Fields that are differences of large numbers; what `damping_floor` says of the same amplitude is allowed of them too.
const DAMPINGS: [&str; 3] = [
    "damping_ratio",
    "damping_ratio_first_harmonic",
    "friction_damping_ratio",
];

/// Energies, of which the same holds through the damping ratio.
const ENERGIES: [&str; 2] = ["dissipation", "loop_area"];

/// Options of `verify`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of the results of any command.
    results: PathBuf,
    /// Also repeat a run from the scene in its summary and the inputs that it names, and compare all numbers: bit by bit with
    /// the same program and arithmetic, else within 1e-6 and the floor of each damping.
    #[arg(long)]
    rerun: bool,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let directory = &arguments.results;
    let manifest = Manifest::read(directory)?;
    let mut defects: Vec<String> = manifest.defects(directory)?.iter().map(ToString::to_string).collect();
    let is_run = {
        let command = manifest.identity.command.as_str();
        command == "run" || command.starts_with("run --only")
    };
    if is_run {
        let extra = names(directory)?.into_iter().filter(|name| is_of_some_run(name));
        let extra = extra.filter(|name| !manifest.files.contains_key(name));
        defects.extend(extra.map(|name| format!("{name}: is not of these results; move it away")));
    }
    if !defects.is_empty() {
        bail!(
            "{}: not as {} wrote it:\n  {}",
            directory.display(),
            manifest.identity,
            defects.join("\n  ")
        );
    }
    print(&format!(
        "{}: results of {}, {} files as they were written\n",
        directory.display(),
        manifest.identity,
        manifest.files.len()
    ))?;
    if is_run {
        let count = check::results(directory, Demand::Sound)?;
        print(&format!("{count} checks of the results passed\n"))?;
    }
    if arguments.rerun {
        ensure!(
            is_run,
            "only runs can be repeated, and {} holds the results of {}",
            directory.display(),
            manifest.identity
        );
        rerun(directory)?;
    }
    Ok(())
}

/// Names of the files in a folder.
fn names(directory: &Path) -> Result<Vec<String>> {
    let listing = || format!("listing {}", directory.display());
    let entries = std::fs::read_dir(directory).with_context(listing)?;
    entries
        .map(|entry| Ok(entry.with_context(listing)?.file_name().to_string_lossy().into_owned()))
        .collect()
}

/// Computes a run again, and compares.
fn rerun(directory: &Path) -> Result<()> {
    let (before, mut scene) = check::read(directory)?;
    let provenance = before.provenance.as_ref();
    let provenance = provenance.context("summary.json: provenance is missing, so that the inputs are not known")?;
    let folder = Path::new(&provenance.working_directory);
    provenance.inputs.iter().try_for_each(|input| input.check(folder))?;
    if std::env::current_dir().is_ok_and(|here| here != folder) {
        scene.resolve(folder);
    }
    let request = Request {
        ensemble: before.ensemble.as_ref().map(|ensemble| ensemble.realisations),
        samples: before
            .uncertainty
            .as_ref()
            .map(|found| (found.samples, Some(found.seed))),
        estimate_error: match (&before.error_estimate, &before.mesh_estimate) {
            (Some(_), _) => Some(ErrorOf::Settings),
            (None, Some(_)) => Some(ErrorOf::Mesh),
            (None, None) => None,
        },
    };
    // Nothing is read that an earlier run has stored.
    let (run, after) = request.compute(&scene, &Options::default(), Display::default())?;
    let exact = is_same_arithmetic(provenance);
    let mut compared = Comparison {
        exact,
        count: 0,
        differences: Vec::new(),
    };
    compared.values("", &results(&before)?, &results(&after)?, 0.0);
    if exact {
        // Pictures and pages say nothing that tables and fields do not, but for times and paths.
        for output in outputs(&run, &after)? {
            let path = directory.join(&output.name);
            let is_data = path.extension().is_some_and(|e| e == "csv" || e == "vtu" || e == "npz");
            if is_data
                && std::fs::read(&path).with_context(|| format!("reading {}", path.display()))? != output.contents
            {
                compared
                    .differences
                    .push(format!("{}: computed again, it is another file", output.name));
            }
        }
    }
    let how = match exact {
        true => "the same program and arithmetic, bit by bit".to_owned(),
        false => format!("another program or arithmetic, within {TOLERANCE:e} and the floor of each damping"),
    };
    if !compared.differences.is_empty() {
        let shown = compared.differences.len().min(20);
        bail!(
            "{}: {} of {} numbers differ when they are computed again ({how}):\n  {}",
            directory.display(),
            compared.differences.len(),
            compared.count,
            compared.differences[..shown].join("\n  ")
        );
    }
    print(&format!(
        "{} numbers are the same when they are computed again ({how})\n",
        compared.count
    ))
}

/// Whether results are expected to be the same to the last bit.
fn is_same_arithmetic(then: &Provenance) -> bool {
    then.arithmetic == arithmetic_fingerprint() && then.program == provenance::program()
}

/// The results in a summary.
fn results(summary: &Summary) -> Result<Value> {
    let mut value = serde_json::to_value(summary).context("encoding the summary")?;
    if let Some(fields) = value.as_object_mut() {
        fields.retain(|name, _| !NOT_RESULTS.contains(&name.as_str()));
    }
    // What is known of the mesh was not computed by the run.
    if let Some(model) = value.pointer_mut("/model").and_then(Value::as_object_mut) {
        model.remove("error_bar");
    }
    Ok(value)
}

/// Numbers, truth values and states of two summaries, side by side.
struct Comparison {
    exact: bool,
    count: usize,
    differences: Vec<String>,
}

impl Comparison {
    /// `floor` is what may be missing of damping ratios here.
    fn values(&mut self, place: &str, before: &Value, after: &Value, floor: f64) {
        match (before, after) {
            (Value::Object(a), Value::Object(b)) => {
                let floor = a.get("damping_floor").and_then(Value::as_f64).unwrap_or(floor);
                // Energy over damping: that of the cycle.
                let cycle = match (a.get("dissipation"), a.get("friction_damping_ratio")) {
                    (Some(energy), Some(zeta)) => energy.as_f64().zip(zeta.as_f64()).map_or(0.0, |(e, zeta)| e / zeta),
                    _ => 0.0,
                };
                for name in a.keys().chain(b.keys().filter(|name| !a.contains_key(*name))) {
                    if !self.exact && OF_ROUND_OFF.contains(&name.as_str()) {
                        continue;
                    }
                    let allowed = match name.as_str() {
                        damping if DAMPINGS.contains(&damping) => floor,
                        energy if ENERGIES.contains(&energy) => floor * cycle,
                        _ => 0.0,
                    };
                    let [x, y] = [a, b].map(|of| of.get(name).unwrap_or(&Value::Null));
                    self.values(&format!("{place}/{name}"), x, y, allowed);
                }
            }
            (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
                for (index, (x, y)) in a.iter().zip(b).enumerate() {
                    self.values(&format!("{place}/{index}"), x, y, floor);
                }
            }
            // Texts name files and say in words what numbers say; only states are results.
            (Value::String(_), Value::String(_)) if !place.ends_with("/status") => {}
            _ => {
                self.count += 1;
                if !self.agree(before, after, floor) {
                    self.differences.push(format!("{place}: {before} then, {after} now"));
                }
            }
        }
    }

    fn agree(&self, before: &Value, after: &Value, floor: f64) -> bool {
        match (before.as_f64(), after.as_f64()) {
            (Some(a), Some(b)) if self.exact => a.to_bits() == b.to_bits(),
            (Some(a), Some(b)) => (a - b).abs() <= TOLERANCE * a.abs().max(b.abs()) + floor,
            _ => before == after,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn differences(exact: bool, before: &Value, after: &Value) -> Vec<String> {
        let mut compared = Comparison {
            exact,
            count: 0,
            differences: Vec::new(),
        };
        compared.values("", before, after, 0.0);
        compared.differences
    }

    #[test]
    fn one_bit_is_a_difference_and_round_off_is_one_with_the_same_arithmetic_alone() {
        let point = |frequency: f64, zeta: f64, iterations: usize| {
            json!({ "backbone": [{
                "status": "resolved", "frequency_hz": frequency, "damping_ratio": zeta, "friction_damping_ratio": zeta,
                "damping_floor": 1e-8, "dissipation": 1e-3 * zeta, "iterations": iterations, "failure": null,
            }] })
        };
        let base = point(170.0, 1e-4, 30);
        let near = point(170.0 * (1.0 + f64::EPSILON), 1e-4 + 0.9e-8, 31);
        assert_eq!(differences(true, &base, &base), Vec::<String>::new());
        assert_eq!(differences(true, &base, &near).len(), 5);
        assert_eq!(differences(false, &base, &near), Vec::<String>::new());
        for far in [point(170.001, 1e-4, 30), point(170.0, 1e-4 + 2e-8, 30)] {
            assert!(!differences(false, &base, &far).is_empty());
        }
        let mut other = base.clone();
        other["backbone"][0]["status"] = json!("below-floor");
        assert_eq!(differences(false, &base, &other).len(), 1);
        other["backbone"] = json!([]);
        assert_eq!(differences(false, &base, &other).len(), 1);
        assert_eq!(differences(false, &base, &json!({})).len(), 1);
    }
}
