//! Checks a finished run against bounds that hold for every sound scene of the beam.

use anyhow::{Context, Result, bail};
use reports::markup;
use reports::run::{SUMMARY, amplitude_file};
use serde_json::Value;
use std::path::Path;

/// Share of the area that slips beyond which the damping need not rise any more.
const GROSS_SLIP: f64 = 0.8;

/// Relative rise of the frequency that counts as noise: kinks of single asperities at the onset of slip.
const NOISE: f64 = 1e-6;

/// Runs the command.
pub(crate) fn run(directory: &Path) -> Result<()> {
    let path = directory.join(SUMMARY);
    let text = std::fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))?;
    let summary: Value = serde_json::from_str(&text).with_context(|| format!("parsing {}", path.display()))?;
    let mut checks = Checks::default();
    checks.summary(&summary)?;
    checks.files(directory, &summary)?;
    if !checks.defects.is_empty() {
        let (failed, all) = (checks.defects.len(), checks.count);
        bail!(
            "{}: {failed} of {all} checks failed:\n  {}",
            directory.display(),
            checks.defects.join("\n  ")
        );
    }
    microslip::commands::print(&format!("{}: {} checks passed\n", directory.display(), checks.count))
}

#[derive(Default)]
struct Checks {
    count: usize,
    defects: Vec<String>,
}

impl Checks {
    fn that(&mut self, holds: bool, otherwise: impl FnOnce() -> String) {
        self.count += 1;
        if !holds {
            self.defects.push(otherwise());
        }
    }

    fn between(&mut self, name: &str, value: f64, low: f64, high: f64) {
        self.that((low..=high).contains(&value), || {
            format!("{name} = {value} is not between {low} and {high}")
        });
    }

    fn summary(&mut self, summary: &Value) -> Result<()> {
        let at = |pointer: &str| number(summary, pointer);
        // 3.70 kg within 0.5 %, for the default material's density.
        let density = at("/scene/model/material/density")? / 7857.8;
        self.between("model.mass", at("/model/mass")? / density, 3.70 * 0.995, 3.70 * 1.005);
        let bore = 0.0085_f64;
        let area = 0.120 * 0.0254 - 3.0 * std::f64::consts::PI * bore * bore / 4.0;
        self.between(
            "model.interface_area over its nominal value",
            at("/model/interface_area")? / area,
            0.999,
            1.001,
        );
        let (stuck, unstressed) = (at("/model/zem_stuck")?, at("/model/zem_unstressed")?);
        self.that(stuck == 6.0, || format!("model.zem_stuck = {stuck} is not 6"));
        self.that(unstressed == 7.0, || {
            format!("model.zem_unstressed = {unstressed} is not 7")
        });
        self.between(
            "model.penalty_spectrum_error",
            at("/model/penalty_spectrum_error")?,
            0.0,
            1e-4,
        );

        let converged = summary.pointer("/prestress/converged") == Some(&Value::Bool(true));
        self.that(converged, || "prestress.converged is not true".into());
        let (residual, equilibrium) = (at("/prestress/residual_ratio")?, at("/prestress/equilibrium_error")?);
        self.between("prestress.residual_ratio", residual, 0.0, 1e-6);
        self.between("prestress.equilibrium_error", equilibrium, 0.0, 10.0 * residual + 1e-12);
        self.between(
            "prestress.contact_area_fraction",
            at("/prestress/contact_area_fraction")?,
            0.05,
            1.0,
        );

        let (stuck, first) = (at("/model/stuck_frequencies_hz/0")?, at("/modes/0/frequency_hz")?);
        self.between("modes[0] over model.stuck_frequencies_hz[0]", first / stuck, 0.5, 1.0);
        self.backbone(summary)
    }

    fn backbone(&mut self, summary: &Value) -> Result<()> {
        let points = summary
            .pointer("/backbone")
            .and_then(Value::as_array)
            .context("summary.json: no backbone")?;
        let expected = number(summary, "/scene/cqsma/amplitudes")?;
        self.that(points.len() as f64 == expected, || {
            format!("backbone has {} amplitudes instead of {expected}", points.len())
        });
        let tolerance = number(summary, "/scene/cqsma/tolerance")?;
        // (number, frequency, friction damping, slip fraction) once slip begins.
        let mut before: Option<(usize, f64, f64, f64)> = None;
        for (index, point) in points.iter().enumerate() {
            let n = index + 1;
            let converged = point["converged"] == Value::Bool(true);
            self.that(converged, || {
                format!("amplitude {n} did not converge: {}", point["failure"])
            });
            if !converged {
                continue;
            }
            let at = |field: &str| number(point, &format!("/{field}")).with_context(|| format!("amplitude {n}"));
            let (dissipation, area) = (at("dissipation")?, at("loop_area")?);
            let bound = 1e-6 * dissipation.abs() + 10.0 * tolerance * at("modal_force")? * at("modal_amplitude")?;
            self.that((dissipation - area).abs() <= bound, || {
                format!(
                    "amplitude {n}: dissipation {dissipation} J by points and {area} J by the loop differ by more than \
                     {bound:.3e} J"
                )
            });
            let frequency = at("frequency_hz")?;
            let halves = (at("half_frequencies_hz/0")?, at("half_frequencies_hz/1")?);
            self.that(
                halves.0.min(halves.1) <= frequency && frequency <= halves.0.max(halves.1),
                || format!("amplitude {n}: the frequency {frequency} Hz is not between those of the halves {halves:?}"),
            );
            let slip = at("slip_fraction")?;
            // Below the floor there is no damping to compare.
            if slip > 0.0 && !point["friction_damping_ratio"].is_null() {
                let damping = at("friction_damping_ratio")?;
                if let Some((last, f, zeta, slipped)) = before {
                    self.that(frequency < f * (1.0 + NOISE), || {
                        format!("frequency does not fall from amplitude {last} ({f} Hz) to {n} ({frequency} Hz)")
                    });
                    // Beyond gross slip friction can do no more and the damping falls again.
                    self.that(damping > zeta || slipped > GROSS_SLIP, || {
                        format!("damping does not rise from amplitude {last} ({zeta}) to {n} ({damping})")
                    });
                }
                before = Some((n, frequency, damping, slip));
            }
        }
        Ok(())
    }

    fn files(&mut self, directory: &Path, summary: &Value) -> Result<()> {
        let mut documents = vec![
            "backbone.svg".to_owned(),
            "report.html".into(),
            "interface-prestress.vtu".into(),
        ];
        documents.extend(stored(summary)?.into_iter().map(|number| amplitude_file(None, number)));
        for name in documents {
            let text = std::fs::read_to_string(directory.join(&name));
            let result = text.map_err(|e| e.to_string()).and_then(|text| markup::check(&text));
            self.that(result.is_ok(), || {
                format!("{name}: {}", result.err().unwrap_or_default())
            });
        }
        let amplitudes = summary
            .pointer("/backbone")
            .and_then(Value::as_array)
            .map_or(0, Vec::len);
        let table = std::fs::read_to_string(directory.join("backbone.csv")).unwrap_or_default();
        let rows = table.lines().count();
        self.that(rows == amplitudes + 1, || {
            format!("backbone.csv has {rows} lines for {amplitudes} amplitudes")
        });
        Ok(())
    }
}

/// Numbers of the amplitudes whose fields must be there: those asked for that converged.
fn stored(summary: &Value) -> Result<Vec<usize>> {
    let converged = |n: usize| summary["backbone"][n - 1]["converged"] == Value::Bool(true);
    let asked = match summary.pointer("/scene/output/fields_at").and_then(Value::as_array) {
        Some(numbers) => numbers.iter().filter_map(Value::as_u64).map(|n| n as usize).collect(),
        // By default at least the first and the last.
        None => vec![1, number(summary, "/scene/cqsma/amplitudes")? as usize],
    };
    Ok(asked.into_iter().filter(|&n| n > 0 && converged(n)).collect())
}

fn number(value: &Value, pointer: &str) -> Result<f64> {
    let found = value.pointer(pointer).and_then(Value::as_f64);
    found.with_context(|| {
        format!(
            "summary.json: {} is missing or not a number",
            pointer[1..].replace('/', ".")
        )
    })
}
