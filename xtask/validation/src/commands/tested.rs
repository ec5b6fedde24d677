//! What is predicted of structures and contacts that somebody has tested: bands from the inputs that are not known.

use analyses::run_samples;
use anyhow::{Context, Result, bail};
use brake_reuss_beam::BrakeReussBenchmark;
use brake_reuss_beam::published::steel;
use contact_laws::{AsperitySumCurves, ContactCurves, ElasticPair, TangentialReading};
use host::{BENCHMARKS, provenance};
use joint_model::Benchmark;
use joints::Options;
use joints::interface::{interference_at, measured_population};
use microslip::Defaults;
use microslip::progress::{Display, Monitor};
use scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Samples behind a band.
const SAMPLES: usize = 200;

/// Pressures between which the exponent of a stiffness is taken (Pa).
const PRESSURES: [f64; 2] = [10e6, 70e6];

/// The comparisons of a file, each with its `name` and what is `predicted`.
pub(crate) fn predictions(file: &Path, defaults: &Defaults) -> Result<Value> {
    let text = std::fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))?;
    let given: Value = serde_json::from_str(&text).with_context(|| format!("reading {}", file.display()))?;
    // Every scene runs once, whatever is compared of it.
    let mut scenes: BTreeMap<&str, [Value; 2]> = BTreeMap::new();
    let mut rows = Vec::new();
    for one in given["comparisons"].as_array().into_iter().flatten() {
        let asked = &one["predicted"];
        let found = match asked["scene"].as_str() {
            None => exponents()?,
            Some(scene) => {
                if !scenes.contains_key(scene) {
                    scenes.insert(scene, bands(scene, &given["uncertain"][scene], defaults)?);
                }
                match asked["of"].as_str() {
                    Some("frequency") => scenes[scene][0].clone(),
                    Some("damping") => scenes[scene][1].clone(),
                    other => bail!(
                        "{}: predicted.of = {other:?} is neither frequency nor damping",
                        file.display()
                    ),
                }
            }
        };
        rows.push(json!({ "name": one["name"], "predicted": found }));
    }
    Ok(rows.into())
}

/// Bands of the linearised frequency, and of the damping ratio at 1 um, of a built-in scene; `uncertain` are the distributions of its inputs,
/// or null where the scene has its own.
fn bands(name: &str, uncertain: &Value, defaults: &Defaults) -> Result<[Value; 2]> {
    let text = BrakeReussBenchmark
        .scene(name)
        .with_context(|| format!("there is no scene {name}"))?;
    let mut given = scenes::parse_json(text).map_err(anyhow::Error::msg)?;
    if !uncertain.is_null() {
        given["uncertain"] = json!({ "parameters": uncertain });
    }
    // The second amplitude is one that a backbone has to have.
    given["analyses"] = json!({ "backbone": { "amplitudes": 2, "amplitude_from": "1 um", "amplitude_to": "10 um" } });
    let scene = Scene::from_value(given, name, name, &BENCHMARKS)?;
    let options = Options {
        cache: defaults.cache.clone(),
        build: provenance::commit(),
        ..Options::default()
    };
    let monitor = Monitor::new(Display::default())?;
    let found = run_samples(&scene, SAMPLES, None, &options, &monitor);
    monitor.finish();
    let (_, found) = found.with_context(|| format!("samples of the scene {name}"))?;
    if found.failed > 0 {
        bail!("{name}: {} of {SAMPLES} samples failed", found.failed);
    }
    let bands = &found.modes[0].bands;
    let band = |spread: &analyses::uncertainty::Spread| {
        let [low, _, high] = spread.quantiles;
        json!({ "nominal": spread.nominal, "low": low, "high": high })
    };
    Ok([band(&bands[0].frequency_hz), band(&bands[1].damping_ratio)])
}

/// Exponent of the tangential stiffness in the pressure, of the asperity sum on the measured faces: over the whole range, and at its ends.
fn exponents() -> Result<Value> {
    let surface = BrakeReussBenchmark
        .surface()
        .context("the beam has a measured surface")?;
    let steel = steel();
    let steel = ElasticPair::new(steel.youngs_modulus, steel.poisson_ratio);
    let curves = AsperitySumCurves::try_new(measured_population(&surface)?, steel, TangentialReading::Mindlin)?;
    let stiffness = |pressure: f64| curves.tangential(interference_at(&curves, pressure))[0].value;
    let between = |from: f64, to: f64| (stiffness(to) / stiffness(from)).ln() / (to / from).ln();
    let ends = PRESSURES.map(|pressure| between(pressure, 1.01 * pressure));
    Ok(json!({
        "nominal": between(PRESSURES[0], PRESSURES[1]),
        "low": ends[0].min(ends[1]),
        "high": ends[0].max(ends[1]),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponents_are_those_recorded() {
        let record = include_str!("../../../../fixtures/validation/tests.json");
        let record: Value = serde_json::from_str(record).unwrap_or_default();
        let rows = record["found"].as_array().map_or(&[][..], Vec::as_slice);
        let recorded = rows
            .iter()
            .find(|row| row["name"] == "exponent")
            .map(|row| &row["predicted"]);
        let found = exponents().unwrap_or_default();
        for figure in ["nominal", "low", "high"] {
            let (a, b) = (recorded.and_then(|of| of[figure].as_f64()), found[figure].as_f64());
            assert!(
                a.zip(b).is_some_and(|(a, b)| (a - b).abs() < 1e-6),
                "{figure}: {a:?} {b:?}"
            );
        }
    }
}
