//! Checks a finished run against bounds that hold for every sound run.

use crate::files;
use analyses::results::summary::Summary;
use anyhow::{Context, Result, bail};
use host::BENCHMARKS;
use joint_model::benchmark::{Bounds, Symmetry};
use reports::markup;
use reports::names::{SUMMARY, amplitude_file};
use reports::periodic::{FORCED, FORCED_PICTURE};
use reports::tightening::{TIGHTENING, TIGHTENING_PICTURE};
use scenes::Scene;
use std::path::Path;

/// Share of the area that slips beyond which the damping need not rise any more.
const GROSS_SLIP: f64 = 0.8;

/// Relative rise of the frequency that counts as noise: kinks of single asperities at the onset of slip.
const NOISE: f64 = 1e-6;

/// Relative difference of numbers that are the same but for round-off.
const ROUND_OFF: f64 = 1e-12;

/// What is demanded of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// What any run must satisfy: the static balance, the energy balance of each loop that converged, and whole files; on a
    /// benchmark also its mass, area and zero-energy modes.
    Sound,
    /// Also what holds for a benchmark with usual settings whose amplitudes all converged: an accurate reduction, and a
    /// frequency that falls and a damping that rises up to gross slip.
    Complete,
}

/// The summary of a run and the scene in it.
///
/// # Errors
/// A file that cannot be read, or is no summary of a run.
pub fn read(directory: &Path) -> Result<(Summary, Scene)> {
    let summary = files::summary(directory)?;
    let scene = Scene::from_summary(&summary.scene, &BENCHMARKS)
        .with_context(|| format!("reading {}", directory.join(SUMMARY).display()))?;
    Ok((summary, scene))
}

/// Checks the run in a folder, and gives the number of checks.
///
/// # Errors
/// All that is wrong, in one message; a file that cannot be read.
pub fn results(directory: &Path, demand: Demand) -> Result<usize> {
    let (summary, scene) = read(directory)?;
    let mut checks = Checks::new(demand);
    checks.summary(&scene, &summary)?;
    checks.files(directory, &scene, &summary);
    if !checks.defects.is_empty() {
        let (failed, all) = (checks.defects.len(), checks.count);
        bail!(
            "{}: {failed} of {all} checks failed:\n  {}",
            directory.display(),
            checks.defects.join("\n  ")
        );
    }
    Ok(checks.count)
}

/// What is wrong with the numbers of a run that is not written yet, among what any run must satisfy.
pub fn defects(scene: &Scene, summary: &Summary) -> Vec<String> {
    let mut checks = Checks::new(Demand::Sound);
    let found = checks.summary(scene, summary);
    checks.defects.extend(found.err().map(|error| format!("{error:#}")));
    checks.defects
}

struct Checks {
    count: usize,
    defects: Vec<String>,
    demand: Demand,
}

impl Checks {
    fn new(demand: Demand) -> Self {
        Self {
            count: 0,
            defects: Vec::new(),
            demand,
        }
    }

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

    fn summary(&mut self, scene: &Scene, summary: &Summary) -> Result<()> {
        match scene.structure.benchmark() {
            Some(benchmark) => self.benchmark(&benchmark.bounds(), scene, summary)?,
            None if self.is_complete() => bail!("the run is of no benchmark, of which nothing is known"),
            None => {}
        }
        if self.is_complete() {
            self.usual(summary)?;
        }
        let prestress = &summary.prestress;
        self.that(prestress.converged, || "prestress.converged is not true".into());
        let (residual, equilibrium) = (prestress.residual_ratio, prestress.equilibrium_error);
        // A residual of forces follows the tolerance in the energy norm; the run itself refuses one above the upper end.
        let bound = (1e3 * scene.analyses.backbone.tolerance).clamp(1e-6, 1e-3);
        self.between("prestress.residual_ratio", residual, 0.0, bound);
        // What is left out of the coupling of joints takes a little of the load.
        let left_out = summary.model.flexibility.as_ref().map_or(0.0, |form| form.tolerance);
        let bound = 10.0 * residual + left_out + 1e-12;
        self.between("prestress.equilibrium_error", equilibrium, 0.0, bound);
        if let Some(result) = &summary.tightening {
            let energy = &result.energy;
            self.between("tightening.energy.imbalance", energy.imbalance, 0.0, energy.tolerance);
        }
        for (_, of_mode) in summary.by_mode() {
            self.backbone(scene, &of_mode)?;
        }
        Ok(())
    }

    fn is_complete(&self) -> bool {
        self.demand == Demand::Complete
    }

    /// What is known of the structure of a benchmark.
    fn benchmark(&mut self, bounds: &Bounds, scene: &Scene, summary: &Summary) -> Result<()> {
        let model = &summary.model;
        let density = scene.model.material.and_then(|material| material.density);
        let density = density
            .context("summary.json: scene.model.material.density is missing")?
            .si();
        let added: f64 = scene.structure.point_masses.iter().map(|point| point.mass.si()).sum();
        let mass = model.mass.context("summary.json: model.mass is missing")? - added;
        let nominal = bounds.mass * density / bounds.density;
        self.between("model.mass", mass, 0.995 * nominal, 1.005 * nominal);
        self.between(
            "model.interface_area over its nominal value",
            model.interface_area / bounds.interface_area,
            0.999,
            1.001,
        );
        // Those of a half are others.
        let is_whole = self.is_complete() || scene.model.symmetry == Symmetry::None;
        for (name, found, expected) in [
            ("zem_stuck", model.zem_stuck, bounds.zero_energy_modes[0]),
            ("zem_unstressed", model.zem_unstressed, bounds.zero_energy_modes[1]),
        ] {
            self.that(found == expected || !is_whole, || {
                format!("model.{name} = {found} is not {expected}")
            });
        }
        Ok(())
    }

    /// What holds with usual settings and bolt loads.
    fn usual(&mut self, summary: &Summary) -> Result<()> {
        let model = &summary.model;
        self.between("model.penalty_spectrum_error", model.penalty_spectrum_error, 0.0, 1e-4);
        self.between(
            "prestress.contact_area_fraction",
            summary.prestress.contact_area_fraction,
            0.05,
            1.0,
        );

        let stuck = model.stuck_frequencies_hz.first();
        let stuck = stuck.context("summary.json: model.stuck_frequencies_hz is empty")?;
        let first = summary.modes.first().context("summary.json: modes is empty")?;
        self.between(
            "modes[0] over model.stuck_frequencies_hz[0]",
            first.frequency_hz / stuck,
            0.5,
            1.0,
        );
        Ok(())
    }

    fn backbone(&mut self, scene: &Scene, summary: &Summary) -> Result<()> {
        let (found, expected) = (summary.backbone.len(), scene.analyses.backbone.amplitudes);
        self.that(found == expected, || {
            format!("backbone has {found} amplitudes instead of {expected}")
        });
        // (number, frequency, friction damping, slip fraction) once slip begins.
        let mut before: Option<(usize, f64, f64, f64)> = None;
        for (index, point) in summary.backbone.iter().enumerate() {
            let n = index + 1;
            let complete = self.is_complete();
            self.that(point.converged || !complete, || {
                let reason = point.failure.as_deref().unwrap_or("no reason is given");
                format!("amplitude {n} did not converge: {reason}")
            });
            if !point.converged {
                continue;
            }
            let value = |field: &str, value: Option<f64>| {
                value.with_context(|| format!("amplitude {n}: summary.json: {field} is missing"))
            };
            let dissipation = value("dissipation", point.dissipation)?;
            let area = value("loop_area", point.loop_area)?;
            let load = point.modal_force * value("modal_amplitude", point.modal_amplitude)?;
            let bound = 1e-6 * dissipation.abs() + 10.0 * scene.analyses.backbone.tolerance * load;
            self.that((dissipation - area).abs() <= bound, || {
                format!(
                    "amplitude {n}: dissipation {dissipation} J by points and {area} J by the loop differ by more than \
                     {bound:.3e} J"
                )
            });
            let frequency = value("frequency_hz", point.frequency_hz)?;
            let halves = point.half_frequencies_hz;
            let halves = halves.with_context(|| format!("amplitude {n}: half_frequencies_hz is missing"))?;
            // The range of a loop counts both of its ends at the first reversal, and the halves the last one alone.
            let apart = value("loop_closure", point.loop_closure)? + value("residual", point.residual)? + ROUND_OFF;
            let [low, high] = [
                halves[0].min(halves[1]) * (1.0 - apart),
                halves[0].max(halves[1]) * (1.0 + apart),
            ];
            self.that((low..=high).contains(&frequency), || {
                format!(
                    "amplitude {n}: the frequency {frequency} Hz is not between those of the halves {halves:?} within {apart:.1e}, the \
                     distance between the ends of the loop"
                )
            });
            let slip = value("slip_fraction", point.slip_fraction)?;
            // Below the floor there is no damping to compare.
            if complete
                && slip > 0.0
                && let Some(damping) = point.friction_damping_ratio
            {
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

    fn files(&mut self, directory: &Path, scene: &Scene, summary: &Summary) {
        let mut documents = vec![
            "backbone.svg".to_owned(),
            "report.html".into(),
            "interface-prestress.vtu".into(),
        ];
        if summary.forced.iter().any(|level| !level.frequency.is_empty()) {
            documents.push(FORCED_PICTURE.into());
        }
        documents.extend(summary.tightening.as_ref().map(|_| TIGHTENING_PICTURE.to_owned()));
        documents.extend(stored(scene, summary).map(|number| amplitude_file(None, number)));
        for name in documents {
            let text = std::fs::read_to_string(directory.join(&name));
            let result = text.map_err(|e| e.to_string()).and_then(|text| markup::check(&text));
            self.that(result.is_ok(), || {
                format!("{name}: {}", result.err().unwrap_or_default())
            });
        }
        let mut tables = vec![("backbone.csv", summary.backbone.len(), "amplitudes")];
        if !summary.forced.is_empty() {
            let points = summary.forced.iter().map(|level| level.frequency.len());
            tables.push((FORCED, points.sum(), "points"));
        }
        if let Some(result) = &summary.tightening {
            tables.push((TIGHTENING, result.steps.len(), "steps of tightening"));
        }
        for (name, expected, what) in tables {
            let table = std::fs::read_to_string(directory.join(name)).unwrap_or_default();
            let rows = table.lines().count();
            self.that(rows == expected + 1, || {
                format!("{name} has {rows} lines for {expected} {what}")
            });
        }
    }
}

/// Numbers of the amplitudes whose fields must be there: those asked for that converged.
fn stored(scene: &Scene, summary: &Summary) -> impl Iterator<Item = usize> {
    // By default at least the first and the last.
    let asked = scene.output.fields_at.clone();
    let asked = asked.unwrap_or_else(|| vec![1, scene.analyses.backbone.amplitudes]);
    let converged = |n: &usize| {
        summary
            .backbone
            .get(n.wrapping_sub(1))
            .is_some_and(|point| point.converged)
    };
    asked.into_iter().filter(converged)
}
