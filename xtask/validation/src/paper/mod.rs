//! The results of the method paper that need no private scan, recomputed and set beside the published figures.
//!
//! # Fields of `paper.json`
//!
//! `cargo xtask paper` writes an array with one object per entry, in the paper's order:
//!
//! | field | meaning |
//! |---|---|
//! | `id`, `title` | name for `--only`, and heading |
//! | `inputs` | what was computed, on what |
//! | `published`, `computed`, `difference` | figures by name and unit; `published` is `null` where the paper prints none. `difference` is `computed / published - 1`, `computed` where 0 is published, else `null` |
//! | `comparable` | whether inputs and method are the paper's as far as printed, so that figures should agree |
//! | `judgement` | what the figures say; empty if the entry failed |
//! | `seconds` | wall-clock time of its scenes, possibly beside others or in an earlier run, and of what is made of them |
//! | `status` | `computed`, or `failed: ` and why |
//!
//! Numbers that are not finite are `null`.

mod backbones;
mod claims;
mod entry;
mod inputs;
mod linear;
mod maps;
mod page;
mod runs;
mod surface;

use crate::Display;
use anyhow::{Context, Result, bail};
use entry::{Computed, Plan, Results};
use inputs::Inputs;
use reports::Output;
use scenes::Scene;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub use entry::Entry;

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
    use super::entry::{Figure, Findings};
    use super::*;
    use anyhow::anyhow;

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
                scene.interfaces.mu = -1.0;
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
}
