//! What an entry is: its scenes, and what it makes of their results.

use super::inputs::Inputs;
use super::runs::{Record, RunResult};
use anyhow::{Result, bail};
use scenes::Scene;
use serde_json::{Map, Value, json};

/// A result of the paper.
pub struct Entry {
    pub(crate) id: &'static str,
    pub(crate) title: &'static str,
    /// What was computed, on what inputs.
    pub(crate) inputs: &'static str,
    pub(super) plan: fn(&Inputs) -> Result<Plan<'_>>,
}

/// What an entry needs, and what it makes of it.
pub(crate) struct Plan<'a> {
    pub(crate) scenes: Vec<Scene>,
    pub(crate) evaluate: Box<Evaluate<'a>>,
}

/// What an entry makes of the results of its scenes.
type Evaluate<'a> = dyn FnOnce(&Results<'_>) -> Result<Findings> + 'a;

/// What came of the scenes of a plan, in their order.
pub(crate) struct Results<'a> {
    pub(super) scenes: &'a [Scene],
    pub(super) runs: Vec<&'a RunResult>,
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

    pub(super) fn seconds(&self) -> f64 {
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
    pub(super) fn json(&self) -> Value {
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

/// A published claim, and whether it is seen here.
pub(crate) fn claim(holds: bool, text: &str) -> String {
    format!("{text} - {}", if holds { "seen here too" } else { "NOT seen here" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use brake_reuss_beam::BrakeReussBenchmark;
    use std::sync::Arc;

    #[test]
    fn differences_are_relative_where_there_is_something_to_relate_to() {
        let figure = |published: Option<f64>, computed| Figure::new("f", published, computed, "").difference();
        assert_eq!(figure(Some(200.0), 201.0), Some(201.0 / 200.0 - 1.0));
        assert_eq!(figure(Some(0.0), 3.0), Some(3.0));
        assert_eq!(figure(None, 3.0), None);
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
