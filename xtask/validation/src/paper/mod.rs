//! The results of the method paper that need no private scan, recomputed and set beside the published figures.

mod backbones;
mod claims;
mod linear;
mod maps;
mod page;
mod runs;
mod surface;

use crate::Display;
use analyses::mesh_error::ErrorBar;
use anyhow::{Context, Result, anyhow, bail};
use brake_reuss_beam::BrakeReussBenchmark;
use joint_model::benchmark::Benchmark as _;
use joint_model::benchmark::RefinementLevel;
use joints::interface::ScannedSurface;
use joints::progress::Silent;
use joints::structure::Structure;
use reports::Output;
use reports::plot::amplitude_label;
use runs::{Record, RunResult};
use scenes::{Gap, LawKind, Length, Scene, Surface, SyntheticScan};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;
use zte_assembly::InterfaceMesh;

/// A result of the paper.
pub struct Entry {
    pub(crate) id: &'static str,
    pub(crate) title: &'static str,
    /// What was computed, on what inputs.
    pub(crate) inputs: &'static str,
    plan: fn(&Inputs) -> Result<Plan<'_>>,
}

/// All entries, in the paper's order.
static ENTRIES: [Entry; 13] = [
    linear::TABLE_1,
    maps::FIG_17,
    backbones::FIG_19,
    maps::FIG_21,
    surface::TABLE_2,
    claims::CLAIMS,
    linear::TABLE_3,
    linear::TABLE_4,
    surface::FIG_12,
    linear::NUMBERS,
    backbones::METHODS,
    backbones::READINGS,
    backbones::EXPERIMENT,
];

/// What an entry needs, and what it makes of it.
pub(crate) struct Plan<'a> {
    pub(crate) scenes: Vec<Scene>,
    pub(crate) evaluate: Box<Evaluate<'a>>,
}

/// What an entry makes of the results of its scenes.
type Evaluate<'a> = dyn FnOnce(&Results<'_>) -> Result<Findings> + 'a;

/// What came of the scenes of a plan, in their order.
pub(crate) struct Results<'a> {
    scenes: &'a [Scene],
    runs: Vec<&'a RunResult>,
}

impl Results<'_> {
    /// The record of a scene.
    ///
    /// # Errors
    /// If it failed: which, and why.
    pub(crate) fn of(&self, index: usize) -> Result<&Record> {
        match self.runs.get(index) {
            Some(Ok(record)) => Ok(record),
            Some(Err(reason)) => bail!("the scene {} failed: {reason}", self.scenes[index].name),
            None => bail!("the entry asks for scene {} of {}", index + 1, self.runs.len()),
        }
    }

    /// All records.
    ///
    /// # Errors
    /// If one failed.
    pub(crate) fn all(&self) -> Result<Vec<&Record>> {
        (0..self.runs.len()).map(|index| self.of(index)).collect()
    }

    fn seconds(&self) -> f64 {
        let records = self.runs.iter().filter_map(|run| run.as_ref().ok());
        records.map(|record| record.seconds).sum()
    }
}

/// A number beside the published one.
pub(crate) struct Figure {
    pub(crate) name: String,
    pub(crate) published: Option<f64>,
    pub(crate) computed: f64,
    /// In what the inputs differ from the paper's, or what else is to be known; may be empty.
    pub(crate) note: &'static str,
}

impl Figure {
    pub(crate) fn new(
        name: impl Into<String>,
        published: impl Into<Option<f64>>,
        computed: f64,
        note: &'static str,
    ) -> Self {
        Self {
            name: name.into(),
            published: published.into(),
            computed,
            note,
        }
    }

    /// Relative difference; absolute where the published figure is zero.
    pub(crate) fn difference(&self) -> Option<f64> {
        let published = self.published?;
        Some(if published == 0.0 {
            self.computed
        } else {
            self.computed / published - 1.0
        })
    }
}

/// A picture of an entry.
pub(crate) struct Picture {
    /// Name of its file, without extension.
    pub(crate) name: &'static str,
    pub(crate) svg: String,
    pub(crate) caption: String,
}

/// What an entry found.
pub(crate) struct Findings {
    pub(crate) figures: Vec<Figure>,
    /// Whether inputs and method are the paper's, so that the figures should agree.
    pub(crate) comparable: bool,
    /// One sentence, or a few where several claims are judged.
    pub(crate) judgement: String,
    pub(crate) pictures: Vec<Picture>,
}

/// An entry with what came of it.
pub(crate) struct Computed {
    pub(crate) entry: &'static Entry,
    pub(crate) findings: Result<Findings, String>,
    pub(crate) seconds: f64,
}

impl Computed {
    /// The row of `paper.json`.
    fn json(&self) -> Value {
        let mut columns = [Map::new(), Map::new(), Map::new()];
        let (comparable, judgement, status) = match &self.findings {
            Ok(found) => {
                for figure in &found.figures {
                    let values = [figure.published, Some(figure.computed), figure.difference()];
                    for (column, value) in columns.iter_mut().zip(values) {
                        column.insert(figure.name.clone(), json!(value));
                    }
                }
                (found.comparable, found.judgement.clone(), "computed".to_owned())
            }
            Err(reason) => (false, String::new(), format!("failed: {reason}")),
        };
        let [published, computed, difference] = columns;
        json!({
            "id": self.entry.id,
            "title": self.entry.title,
            "inputs": self.entry.inputs,
            "published": published,
            "computed": computed,
            "difference": difference,
            "comparable": comparable,
            "judgement": judgement,
            "seconds": self.seconds,
            "status": status,
        })
    }
}

/// What entries make their scenes from.
pub(crate) struct Inputs {
    quick: bool,
    cache: Option<PathBuf>,
    /// The scene that all others are made from.
    scene: Scene,
    pub(crate) structure: Structure,
    pub(crate) mesh: InterfaceMesh,
    scan: OnceLock<Result<ScannedSurface, String>>,
}

/// The synthetic pair in the place of the paper's scans.
pub(crate) fn synthetic() -> SyntheticScan {
    SyntheticScan::default()
}

impl Inputs {
    fn try_new(quick: bool, cache: Option<PathBuf>) -> Result<Self> {
        let mut scene = Scene::of(&BrakeReussBenchmark, "paper")?;
        if quick {
            scene.model.refinement = RefinementLevel::Quick;
        }
        let structure = Structure::try_new(&scene, &Silent)?;
        Ok(Self {
            quick,
            cache,
            mesh: structure.interface().clone(),
            scene,
            structure,
            scan: OnceLock::new(),
        })
    }

    /// A scene of prestress and linearised modes alone, with measured statistics and no gap.
    pub(crate) fn scene(&self, name: &str) -> Scene {
        let mut scene = self.scene.clone();
        scene.name = name.into();
        scene.cqsma.amplitudes = 0;
        scene
    }

    /// The same with a backbone.
    pub(crate) fn backbone(&self, name: &str, amplitudes: usize, from: f64, to: f64) -> Scene {
        let mut scene = self.scene(name);
        scene.cqsma.amplitudes = if self.quick { amplitudes.min(6) } else { amplitudes };
        scene.cqsma.vertices_per_quarter = if self.quick { 4 } else { 8 };
        scene.cqsma.amplitude_from = Length::from_si(from);
        scene.cqsma.amplitude_to = Length::from_si(to);
        scene.output.fields_at = Some(Vec::new());
        scene
    }

    /// A scene of the benchmark's own, on the mesh of the command.
    ///
    /// # Errors
    /// Of a scene that is not there.
    pub(crate) fn benchmark(&self, name: &str) -> Result<Scene> {
        let text = BrakeReussBenchmark.scene(name);
        let text = text.ok_or_else(|| anyhow!("the benchmark has no scene {name}"))?;
        let mut scene = Scene::from_json(text, name, name, &[&BrakeReussBenchmark])?;
        if self.quick {
            scene.model.refinement = self.scene(name).model.refinement;
            scene.cqsma.amplitudes = scene.cqsma.amplitudes.min(6);
            scene.cqsma.vertices_per_quarter = 4;
        }
        scene.output.fields_at = Some(Vec::new());
        Ok(scene)
    }

    /// The same as a static scene of the paper: mu = 0.6 and 25 points per element.
    pub(crate) fn prestress(&self, name: &str, gap: Gap) -> Scene {
        let mut scene = self.scene(name);
        scene.gap = gap;
        scene.mu = 0.6;
        scene.points_per_direction = 5;
        scene
    }

    /// Title of an axis of amplitudes.
    pub(crate) fn amplitude_axis(&self) -> String {
        format!("{} [m]", amplitude_label(&self.structure.joint.response))
    }

    /// What an entry made of its own inputs and the structure in an earlier run, or makes now.
    ///
    /// # Errors
    /// Of `make`, and of the folder it is stored in.
    pub(crate) fn kept<T: Serialize + DeserializeOwned>(
        &self,
        inputs: &impl Serialize,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        runs::kept(self.cache.as_deref(), &(self.quick, inputs), make)
    }

    /// The synthetic pair, characterised once.
    ///
    /// # Errors
    /// Of the characterisation.
    pub(crate) fn scan(&self) -> Result<&ScannedSurface> {
        let found = self
            .scan
            .get_or_init(|| self.scanned(synthetic()).map_err(|error| format!("{error:#}")));
        found.as_ref().map_err(|reason| anyhow!("{reason}"))
    }

    /// A synthetic pair, characterised.
    ///
    /// # Errors
    /// Of the generator and the characterisation.
    pub(crate) fn scanned(&self, scan: SyntheticScan) -> Result<ScannedSurface> {
        let mut scene = self.scene("");
        scene.surface = Surface::SyntheticScan(scan);
        Ok(ScannedSurface::try_new(&scene, &self.mesh)?)
    }
}

/// Gives a scene the roughness of the synthetic pair, element by element, in the paper's fitted form.
pub(crate) fn per_element(mut scene: Scene) -> Scene {
    scene.surface = Surface::SyntheticScan(synthetic());
    scene.law.kind = LawKind::Fitted;
    scene
}

/// How far frequencies of a scene may be from the limit of its mesh, in words.
pub(crate) fn mesh_error(scene: &Scene) -> String {
    match ErrorBar::of(scene).frequency_relative {
        Some(error) => format!("up to {:.1} %", 100.0 * error),
        None => "not known".into(),
    }
}

/// A published claim, and whether it is seen here.
pub(crate) fn claim(holds: bool, text: &str) -> String {
    format!("{text} - {}", if holds { "seen here too" } else { "NOT seen here" })
}

/// Entries with these ids, all without any.
///
/// # Errors
/// An unknown id, listing those that exist.
pub fn select(only: &[String]) -> Result<Vec<&'static Entry>> {
    if let Some(unknown) = only.iter().find(|id| ENTRIES.iter().all(|e| e.id != id.as_str())) {
        let known: Vec<&str> = ENTRIES.iter().map(|e| e.id).collect();
        bail!("there is no entry `{unknown}`; the entries are {}", known.join(", "));
    }
    let chosen = |entry: &&Entry| only.is_empty() || only.iter().any(|id| id == entry.id);
    Ok(ENTRIES.iter().filter(chosen).collect())
}

/// Entries with what came of them.
pub struct Paper {
    computed: Vec<Computed>,
    quick: bool,
}

impl Paper {
    /// Runs the scenes of these entries and evaluates them; `quick` on a coarse mesh with few amplitudes. Reduced models and
    /// finished scenes are kept in the folder `cache`. An entry that fails leaves the others alone.
    ///
    /// # Errors
    /// The structure that all entries share cannot be made.
    pub fn compute(
        entries: &[&'static Entry],
        quick: bool,
        cache: Option<PathBuf>,
        display: &dyn Display,
    ) -> Result<Self> {
        let inputs = Inputs::try_new(quick, cache)?;
        let computed = compute(&inputs, entries, display)?;
        Ok(Self { computed, quick })
    }

    /// Pictures, page and `paper.json`.
    ///
    /// # Errors
    /// The entries cannot be encoded.
    pub fn outputs(&self) -> Result<Vec<Output>> {
        let rows: Vec<Value> = self.computed.iter().map(Computed::json).collect();
        let json = serde_json::to_string_pretty(&rows).context("encoding the entries")?;
        let mut outputs = self.pictures();
        outputs.push(Output::new("report.html", page::html(&self.computed, self.quick)?));
        outputs.push(Output::new("paper.json", json + "\n"));
        Ok(outputs)
    }

    fn pictures(&self) -> Vec<Output> {
        let found = self.computed.iter().filter_map(|c| c.findings.as_ref().ok());
        let pictures = found.flat_map(|found| &found.pictures);
        pictures
            .map(|picture| Output::new(format!("{}.svg", picture.name), picture.svg.clone()))
            .collect()
    }

    /// A few lines of text: the judgements, the folder of the results and the time taken.
    pub fn account(&self, folder: &Path, seconds: f64) -> String {
        page::account(&self.computed, folder, seconds)
    }

    /// Whether no entry failed.
    pub fn is_complete(&self) -> bool {
        self.computed.iter().all(|entry| entry.findings.is_ok())
    }
}

/// Runs the scenes of all entries, each once, and lets the entries make of them what they do. What fails in one entry
/// leaves the others alone.
fn compute(inputs: &Inputs, entries: &[&'static Entry], display: &dyn Display) -> Result<Vec<Computed>> {
    let plan = |entry: &&'static Entry| {
        let began = Instant::now();
        let plan = (entry.plan)(inputs);
        display.line(&format!(
            "{:>10} planned ... {:.1} s",
            entry.id,
            began.elapsed().as_secs_f64()
        ));
        plan
    };
    let plans: Vec<Result<Plan<'_>>> = entries.iter().map(plan).collect();
    let scenes_of = |plan: &Result<Plan<'_>>| plan.as_ref().map_or_else(|_| Vec::new(), |plan| plan.scenes.clone());
    let scenes: Vec<Scene> = plans.iter().flat_map(scenes_of).collect();
    let (different, of) = runs::unique(&scenes)?;
    let results = runs::run_all(&different, inputs.cache.as_deref(), display)?;
    let mut numbers = of.into_iter();
    let mut computed = Vec::with_capacity(entries.len());
    for (&entry, plan) in entries.iter().zip(plans) {
        let began = Instant::now();
        let mut seconds = 0.0;
        let findings = plan.and_then(|plan| {
            let runs = plan.scenes.iter().zip(&mut numbers).map(|(_, number)| &results[number]);
            let results = Results {
                runs: runs.collect(),
                scenes: &plan.scenes,
            };
            seconds = results.seconds();
            (plan.evaluate)(&results)
        });
        seconds += began.elapsed().as_secs_f64();
        computed.push(Computed {
            entry,
            findings: findings.map_err(|error| format!("{error:#}")),
            seconds,
        });
    }
    Ok(computed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn an_unknown_entry_is_refused_with_those_that_exist() {
        let ids = |only: &[&str]| {
            let only: Vec<String> = only.iter().map(|id| (*id).to_owned()).collect();
            select(&only).map(|entries| entries.iter().map(|e| e.id).collect::<Vec<_>>())
        };
        assert_eq!(ids(&["table4", "table1"]).expect("known"), ["table1", "table4"]);
        let all = ids(&[]).expect("all");
        let mut different = all.clone();
        different.sort_unstable();
        different.dedup();
        assert_eq!(different.len(), all.len(), "ids are unique");
        let message = ids(&["table1", "fig99"]).expect_err("unknown").to_string();
        assert!(message.contains("`fig99`"), "{message}");
        assert!(all.iter().all(|id| message.contains(id)), "{message}");
    }

    #[test]
    fn differences_are_relative_where_there_is_something_to_relate_to() {
        let figure = |published: Option<f64>, computed| Figure::new("f", published, computed, "").difference();
        assert_eq!(figure(Some(200.0), 201.0), Some(201.0 / 200.0 - 1.0));
        assert_eq!(figure(Some(0.0), 3.0), Some(3.0));
        assert_eq!(figure(None, 3.0), None);
    }

    #[test]
    fn rows_have_the_agreed_fields_also_when_an_entry_failed() {
        let fields = [
            "comparable",
            "computed",
            "difference",
            "id",
            "inputs",
            "judgement",
            "published",
            "seconds",
            "status",
            "title",
        ];
        let found = Findings {
            figures: vec![
                Figure::new("f1 (Hz)", 168.91, 168.27, "another surface"),
                Figure::new("f2 (Hz)", None, 230.0, ""),
            ],
            comparable: true,
            judgement: "near".into(),
            pictures: Vec::new(),
        };
        for (findings, status) in [
            (Ok(found), "computed"),
            (Err("no loop closed".to_owned()), "failed: no loop closed"),
        ] {
            let row = Computed {
                entry: &ENTRIES[0],
                findings,
                seconds: 1.5,
            }
            .json();
            let object = row.as_object().expect("an object");
            let mut names: Vec<&str> = object.keys().map(String::as_str).collect();
            names.sort_unstable();
            assert_eq!(names, fields);
            assert_eq!(row["status"], status);
            if status == "computed" {
                assert_eq!(row["published"]["f1 (Hz)"], 168.91);
                assert!(row["published"]["f2 (Hz)"].is_null() && row["difference"]["f2 (Hz)"].is_null());
                assert_eq!(row["computed"]["f2 (Hz)"], 230.0);
            }
        }
    }

    struct Unseen;

    impl Display for Unseen {
        fn fraction(&self, _: f64) {}
        fn line(&self, _: &str) {}
    }

    #[test]
    fn what_fails_in_one_entry_leaves_the_others_alone() {
        static UNPLANNED: Entry = Entry {
            id: "unplanned",
            title: "",
            inputs: "",
            plan: |_| bail!("there is no scan"),
        };
        static REFUSED: Entry = Entry {
            id: "refused",
            title: "",
            inputs: "",
            plan: |inputs| {
                let mut scene = inputs.scene("sticky");
                scene.mu = -1.0;
                Ok(Plan {
                    scenes: vec![scene],
                    evaluate: Box::new(|results| Err(results.of(0).err().unwrap_or_else(|| anyhow!("it ran")))),
                })
            },
        };
        static FINE: Entry = Entry {
            id: "fine",
            title: "",
            inputs: "",
            plan: |inputs| {
                Ok(Plan {
                    scenes: vec![inputs.scene("as by default")],
                    evaluate: Box::new(|results| {
                        Ok(Findings {
                            figures: vec![Figure::new("f1 (Hz)", None, results.of(0)?.first(), "")],
                            comparable: false,
                            judgement: String::new(),
                            pictures: Vec::new(),
                        })
                    }),
                })
            },
        };
        let paper = Paper::compute(&[&UNPLANNED, &REFUSED, &FINE], true, None, &Unseen).expect("entries fail alone");
        let computed = &paper.computed;
        let rows: Vec<Value> = computed.iter().map(Computed::json).collect();
        assert_eq!(rows[0]["status"], "failed: there is no scan");
        let refused = rows[1]["status"].as_str().expect("a text");
        assert!(refused.starts_with("failed: the scene sticky failed"), "{refused}");
        assert!(refused.contains("mu"), "{refused}");
        assert_eq!(rows[2]["status"], "computed");
        assert!(rows[2]["computed"]["f1 (Hz)"].as_f64().expect("a number") > 100.0);
        assert!(!paper.is_complete());
        let page = page::html(computed, true).expect("a page");
        assert!(page.contains("Failed: there is no scan"));
        let fine = Paper {
            computed: paper.computed.into_iter().skip(2).collect(),
            quick: true,
        };
        assert!(fine.is_complete());
    }

    /// A scene that cannot run fails its own entry and no other.
    #[test]
    fn results_name_the_scene_that_failed() {
        let scenes =
            ["good", "bad"].map(|name| Scene::of(&BrakeReussBenchmark, name).expect("the benchmark has all defaults"));
        let record: RunResult = Ok(Arc::new(Record {
            seconds: 2.0,
            frequencies: vec![168.0],
            contact: [1.0; 3],
            slipping: 0.0,
            central: Default::default(),
            nodal: Default::default(),
            backbone: Vec::new(),
            methods: Default::default(),
        }));
        let failed: RunResult = Err("no contact".into());
        let results = Results {
            scenes: &scenes,
            runs: vec![&record, &failed],
        };
        assert_eq!(results.of(0).expect("it ran").first(), 168.0);
        let message = results.of(1).expect_err("it failed").to_string();
        assert!(message.contains("bad") && message.contains("no contact"), "{message}");
        assert!(results.all().is_err());
        assert_eq!(results.seconds(), 2.0);
    }
}
