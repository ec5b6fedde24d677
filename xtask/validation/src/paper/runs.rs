//! The scenes behind the entries: each run once, what is needed of it kept on disk.

use crate::progress::{Batch, Display, Task};
use analyses::results::summary::Summary;
use analyses::{Fields, Prepared, Run};
use anyhow::{Context, Result};
use contact_laws::Regime;
use host::provenance;
use joints::Options;
use joints::progress::Progress;
use joints::store::checkpoint::Checkpoints;
use joints::store::key::KeyBuilder;
use joints::structure::Structure;
use scenes::Scene;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Scenes that run at the same time; their loops share all threads, and each holds a reduced model of its own.
const WORKERS: usize = 2;

/// What is kept of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Wall-clock time, without that of the reduction.
    pub(crate) seconds: f64,
    /// Linearised frequencies (Hz).
    pub(crate) frequencies: Vec<f64>,
    /// Part of the area in contact: by points, by elements with any point in contact, by elements with their centre in
    /// contact.
    pub(crate) contact: [f64; 3],
    /// Part of the area that slips under prestress, by points.
    pub(crate) slipping: f64,
    /// Traction x, y, n at the centre of each element under prestress (Pa).
    pub(crate) central: [Vec<f64>; 3],
    /// The same at the nodes, by least squares (Pa).
    pub(crate) nodal: [Vec<f64>; 3],
    /// Amplitudes in ascending order.
    pub(crate) backbone: Vec<Point>,
    /// Displacement (m), frequency (Hz) and damping ratio of other methods, by the names that scenes use.
    pub(crate) methods: BTreeMap<String, Vec<(f64, f64, Option<f64>)>>,
}

/// One amplitude that converged.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Point {
    /// Place in the backbone, from 0.
    pub(crate) index: usize,
    /// Modal amplitude (sqrt(kg) m).
    pub(crate) modal_amplitude: f64,
    /// Displacement amplitude at the response point (m).
    pub(crate) displacement: f64,
    /// Frequency (Hz).
    pub(crate) frequency: f64,
    /// Total damping ratio, if it is resolved.
    pub(crate) damping: Option<f64>,
    /// Energy per cycle (J).
    pub(crate) dissipation: f64,
    /// Part of the area that slips at the peak.
    pub(crate) slip: f64,
    /// Part of the motion outside the mode.
    pub(crate) shape_deviation: f64,
    /// Where they were asked for.
    pub(crate) fields: Option<PointFields>,
}

/// Element means at an amplitude.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct PointFields {
    /// Dissipated energy per area and cycle x, y, n (J/m^2).
    pub(crate) flux: [Vec<f64>; 3],
    /// Motion along the beam from the prestress to the positive peak (m).
    pub(crate) sliding: Vec<f64>,
}

impl Record {
    fn new(run: &Run, seconds: f64) -> Self {
        let operators = run.interface.operators();
        let prestress = &run.prestress.fields;
        let centres = operators.central_points();
        let central = prestress
            .traction
            .each_ref()
            .map(|t| centres.iter().map(|&p| t[p]).collect::<Vec<f64>>());
        let areas = run.joint.mesh.areas();
        let closed = areas.iter().zip(&central[2]).filter(|(_, pressure)| **pressure > 0.0);
        let by_centres = closed.map(|(area, _)| area).sum::<f64>() / areas.iter().sum::<f64>();
        let slips = prestress.regime.iter().zip(&operators.weights);
        let slips = slips
            .filter(|(regime, _)| **regime == Regime::Slip)
            .map(|(_, weight)| weight);
        let summary = Summary::new(run, BTreeMap::new(), None);
        let backbone = summary.backbone.iter().zip(run.amplitudes()).enumerate();
        let backbone = backbone.filter_map(|(index, (point, amplitude))| {
            let fields = amplitude.fields.as_ref().and_then(|f| f.fields.as_ref());
            Some(Point {
                index,
                modal_amplitude: point.modal_amplitude?,
                displacement: point.response_displacement?,
                frequency: point.frequency_hz?,
                damping: point.damping_ratio,
                dissipation: point.dissipation?,
                slip: point.slip_fraction?,
                shape_deviation: point.shape_deviation?,
                fields: fields.map(|fields| point_fields(run, fields)),
            })
        });
        let methods = summary.methods.iter().map(|(name, points)| {
            let converged = points
                .iter()
                .filter_map(|p| Some((p.response_displacement?, p.frequency_hz?, p.damping_ratio)));
            ((*name).to_owned(), converged.collect())
        });
        let validity = run.validity();
        Self {
            seconds,
            frequencies: run.frequencies.clone(),
            contact: [
                validity.contact_area_fraction_by_points,
                validity.contact_area_fraction_by_elements,
                by_centres,
            ],
            slipping: slips.sum::<f64>() / operators.area(),
            nodal: prestress.traction.each_ref().map(|t| operators.nodal_least_squares(t)),
            central,
            backbone: backbone.collect(),
            methods: methods.collect(),
        }
    }

    /// Displacement against a quantity of each amplitude that has it.
    pub(crate) fn curve(&self, of: impl Fn(&Point) -> Option<f64>) -> Vec<(f64, f64)> {
        let points = self.backbone.iter();
        points.filter_map(|p| Some((p.displacement, of(p)?))).collect()
    }

    /// First linearised frequency (Hz).
    pub(crate) fn first(&self) -> f64 {
        self.frequencies.first().copied().unwrap_or(f64::NAN)
    }
}

fn point_fields(run: &Run, fields: &Fields) -> PointFields {
    let means = |values: &[f64]| run.interface.operators().element_means(values);
    let before = &run.prestress.fields.jump[0];
    let sliding: Vec<f64> = fields.jump[0].iter().zip(before).map(|(a, b)| a - b).collect();
    PointFields {
        flux: fields.flux.each_ref().map(|flux| means(flux)),
        sliding: means(&sliding),
    }
}

/// What came of a scene: its record, or why there is none.
pub(crate) type RunResult = Result<Arc<Record>, String>;

/// The different scenes among those given, in the order of their first appearance, and for each given one its number
/// among them. Names do not make scenes different.
pub(crate) fn unique(scenes: &[Scene]) -> Result<(Vec<Scene>, Vec<usize>)> {
    let mut numbers = BTreeMap::new();
    let mut different = Vec::new();
    let mut of = Vec::with_capacity(scenes.len());
    for scene in scenes {
        let number = *numbers.entry(key(scene)?).or_insert_with(|| {
            different.push(scene.clone());
            different.len() - 1
        });
        of.push(number);
    }
    Ok((different, of))
}

/// Hash of all that the record of a scene depends on.
fn key(scene: &Scene) -> Result<String> {
    hash(&Scene {
        name: String::new(),
        ..scene.clone()
    })
}

/// Hash of inputs, and of the build that turns them into results.
fn hash(inputs: &impl Serialize) -> Result<String> {
    let mut key = KeyBuilder::new(provenance::commit().as_deref());
    key.text(&serde_json::to_string(inputs).context("encoding inputs")?);
    Ok(key.finish().0)
}

fn path_of(folder: &Path, key: &str) -> PathBuf {
    folder.join(format!("paper-{key}.json"))
}

/// An intact result of an earlier run; anything else counts as absent.
fn stored<T: DeserializeOwned>(folder: &Path, key: &str) -> Option<T> {
    serde_json::from_slice(&file_io::durable::read_sealed(&path_of(folder, key))?).ok()
}

fn store(folder: &Path, key: &str, result: &impl Serialize) -> Result<()> {
    Ok(file_io::durable::write_sealed(
        &path_of(folder, key),
        &serde_json::to_vec(result)?,
    )?)
}

/// What was made of these inputs in an earlier run, or is made now and stored.
pub(crate) fn kept<T: Serialize + DeserializeOwned>(
    cache: Option<&Path>,
    inputs: &impl Serialize,
    make: impl FnOnce() -> Result<T>,
) -> Result<T> {
    let Some(folder) = cache else {
        return make();
    };
    let key = hash(inputs)?;
    if let Some(found) = stored(folder, &key) {
        return Ok(found);
    }
    let made = make()?;
    store(folder, &key, &made)?;
    Ok(made)
}

/// Load points of a scene, roughly: the unit of progress.
fn work(scene: &Scene) -> f64 {
    let c = &scene.analyses.backbone;
    let methods = 1.0 + 0.7 * scene.analyses.backbone.methods.len() as f64;
    30.0 + methods * (c.amplitudes * (4 * c.vertices_per_quarter + 20)) as f64
}

/// Runs scenes that are all different, those of one structure together on one reduction. A scene that fails leaves the
/// others alone.
pub(crate) fn run_all(scenes: &[Scene], cache: Option<&Path>, display: &dyn Display) -> Result<Vec<RunResult>> {
    let mut results: Vec<Option<RunResult>> = scenes
        .iter()
        .map(|scene| Some(Ok(Arc::new(stored(cache?, &key(scene).ok()?)?))))
        .collect();
    // Structures in the order in which scenes ask for them.
    let mut structures: Vec<(String, Vec<usize>)> = Vec::new();
    let pending: Vec<usize> = (0..scenes.len()).filter(|&i| results[i].is_none()).collect();
    for &index in &pending {
        let scene = &scenes[index];
        let structure = serde_json::to_string(&(&scene.structure, &scene.model, scene.bolts.behaviour))?;
        match structures.iter_mut().find(|(known, _)| *known == structure) {
            Some((_, members)) => members.push(index),
            None => structures.push((structure, vec![index])),
        }
    }
    let batch = Batch::new(display, pending.len(), pending.iter().map(|&i| work(&scenes[i])).sum());
    if pending.len() < scenes.len() {
        batch.note(&format!(
            "{} of {} scenes were taken from an earlier run",
            scenes.len() - pending.len(),
            scenes.len()
        ));
    }
    for (_, members) in &structures {
        for (index, result) in run_group(scenes, members, cache, &batch) {
            results[index] = Some(result);
        }
    }
    let missing = || Err("it was not run".to_owned());
    Ok(results
        .into_iter()
        .map(|result| result.unwrap_or_else(missing))
        .collect())
}

/// Runs scenes of one structure.
fn run_group(scenes: &[Scene], members: &[usize], cache: Option<&Path>, batch: &Batch<'_>) -> Vec<(usize, RunResult)> {
    let Some(&first) = members.first() else {
        return Vec::new();
    };
    let silent = batch.task(0.0);
    let options = Options {
        cache: cache.map(Path::to_owned),
        build: provenance::commit(),
        ..Options::default()
    };
    let began = Instant::now();
    let reduced = Structure::try_new(&scenes[first], &silent)
        .and_then(|structure| structure.reduce(&options, &silent).map(|model| (structure, model)));
    let (structure, model) = match reduced {
        Ok(found) => found,
        Err(error) => {
            let reason = format!("{:#}", anyhow::Error::from(error));
            return members.iter().map(|&index| (index, Err(reason.clone()))).collect();
        }
    };
    batch.note(&format!(
        "          structure reduced ... {:.1} s",
        began.elapsed().as_secs_f64()
    ));
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::with_capacity(members.len()));
    std::thread::scope(|threads| {
        for _ in 0..WORKERS.min(members.len()) {
            threads.spawn(|| {
                while let Some(&index) = members.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let scene = &scenes[index];
                    let task = batch.task(work(scene));
                    let began = Instant::now();
                    let run = |task: &Task<'_>| -> Result<(Record, Checkpoints)> {
                        let prepared = Prepared::with_model(scene, &structure, model.clone(), &options, task)?;
                        let run = prepared.solve(task)?;
                        let record = Record::new(&run, began.elapsed().as_secs_f64());
                        Ok((record, run.checkpoints))
                    };
                    let result = run(&task);
                    let seconds = began.elapsed().as_secs_f64();
                    let end = match &result {
                        Ok(_) => format!("{} ... {seconds:.1} s", scene.name),
                        Err(error) => format!("{}: FAILED, {error:#}", scene.name),
                    };
                    batch.end(&task, &end);
                    if let (Some(folder), Ok((record, checkpoints))) = (cache, &result) {
                        match key(scene).and_then(|key| store(folder, &key, record)) {
                            Ok(()) => checkpoints.remove(),
                            Err(error) => task.note(&format!("the result was not stored: {error:#}")),
                        }
                    }
                    let result = result
                        .map(|(record, _)| Arc::new(record))
                        .map_err(|error| format!("{error:#}"));
                    let mut results = results.lock().unwrap_or_else(PoisonError::into_inner);
                    results.push((index, result));
                }
            });
        }
    });
    results.into_inner().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use brake_reuss_beam::BrakeReussBenchmark;

    #[test]
    fn equal_scenes_run_once_whatever_their_names() {
        let scene = |name: &str, mu: f64| {
            let mut scene = Scene::of(&BrakeReussBenchmark, name).expect("the benchmark has all defaults");
            scene.interfaces.mu = mu;
            scene
        };
        let given = [scene("a", 0.2), scene("b", 0.3), scene("c", 0.2), scene("b", 0.4)];
        let (different, of) = unique(&given).expect("scenes are encodable");
        assert_eq!(of, [0, 1, 0, 2]);
        let names: Vec<&str> = different.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "b"]);
        let mus: Vec<f64> = of.iter().map(|&i| different[i].interfaces.mu).collect();
        assert_eq!(mus, given.each_ref().map(|s| s.interfaces.mu));
    }
}
