//! What the server of a set-up answers.

use super::check::{Checker, Depth};
use super::job::Job;
use crate::commands::web::{Answer, BAD_REQUEST, METHOD_NOT_ALLOWED, Method, NOT_FOUND, Request, Site, file};
use file_io::durable;
use reports::setup::Page;
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Where things are.
pub(super) struct Place {
    pub(super) checker: Checker,
    /// The file that the scene is saved to.
    pub(super) scene: PathBuf,
    /// The folder of results.
    pub(super) out: PathBuf,
}

/// The page of a set-up and what its scripts ask for, below a word that only its reader knows.
pub(super) struct Setup {
    token: String,
    page: Page,
    place: Place,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// The text that was saved last.
    saved: Option<String>,
    job: Option<Arc<Job>>,
}

/// What a page sends.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sent {
    /// Text of the scene.
    #[serde(default)]
    scene: String,
    /// Whether a file, or results, that this program has not written since it was started may be replaced.
    #[serde(default)]
    replace: bool,
    #[serde(default)]
    overwrite: bool,
    /// Whether a check is of the fields alone, without the mesh.
    #[serde(default)]
    fields: bool,
}

/// What is done with what a page sends.
const ACTIONS: [&str; 4] = ["check", "save", "run", "stop"];

impl Setup {
    pub(super) fn new(token: String, page: Page, place: Place) -> Self {
        Self {
            token,
            page,
            place,
            state: Mutex::default(),
        }
    }

    /// What is asked for below the word, if the word is there.
    fn below<'a>(&self, path: &'a str) -> Option<&'a str> {
        let (word, name) = path.strip_prefix('/')?.split_once('/')?;
        let differ = |(a, b): (u8, u8)| a ^ b;
        let difference = word
            .bytes()
            .zip(self.token.bytes())
            .map(differ)
            .fold(0, |all, one| all | one);
        (word.len() == self.token.len() && difference == 0).then_some(name)
    }

    fn act(&self, action: &str, sent: &Sent) -> Answer {
        if action == "check" {
            let depth = if sent.fields { Depth::Fields } else { Depth::Structure };
            return Answer::json(&self.place.checker.verdict(&sent.scene, depth).json());
        }
        // One at a time: two pages may be open.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match action {
            "save" => self
                .save(&mut state, sent)
                .map_or_else(|refused| refused, |()| saved(&self.place)),
            "run" => self
                .run(&mut state, sent)
                .map_or_else(|refused| refused, |()| saved(&self.place)),
            _ => {
                state.job.iter().for_each(|job| job.stop());
                Answer::json(&json!({}))
            }
        }
    }

    /// Writes the scene, unless its file has something else in it than what was written before.
    fn save(&self, state: &mut State, sent: &Sent) -> Result<(), Answer> {
        let refused = |document: Value| Err(Answer::json(&document));
        let path = &self.place.scene;
        let wanted = match scenes::parse_json(&sent.scene) {
            Ok(wanted) => wanted,
            Err(message) => return refused(json!({ "error": message })),
        };
        let former = std::fs::read_to_string(path).ok();
        let is_own = match std::fs::symlink_metadata(path) {
            Err(_) => true,
            Ok(_) => state.saved.is_some() && former == state.saved,
        };
        if !is_own && !sent.replace {
            return refused(json!({ "exists": self.place.scene_name() }));
        }
        // With the comments of what was there, where it was a scene.
        let kept = former.and_then(|former| scenes::rewritten(&former, &wanted).ok());
        let text = kept.unwrap_or_else(|| sent.scene.clone());
        match durable::write(path, text.as_bytes()) {
            Ok(()) => {
                state.saved = Some(text);
                Ok(())
            }
            Err(error) => refused(json!({ "error": host::with_causes(&error) })),
        }
    }

    /// Saves the scene and runs it, if it is complete and nothing runs.
    fn run(&self, state: &mut State, sent: &Sent) -> Result<(), Answer> {
        let refused = |error: String| Answer::json(&json!({ "error": error }));
        if state.job.as_ref().is_some_and(|job| job.is_running()) {
            return Err(refused("a run is under way; stop it, or wait for its end".into()));
        }
        let verdict = self.place.checker.verdict(&sent.scene, Depth::Structure);
        if !verdict.is_complete() {
            return Err(Answer::json(&verdict.json()));
        }
        self.save(state, sent)?;
        let overwrite = sent.overwrite || state.job.is_some();
        let job = Job::start(&self.place.scene, &self.place.out, overwrite);
        state.job = Some(job.map_err(|error| refused(format!("{error:#}")))?);
        Ok(())
    }

    /// What a run has told from the number on that the query has.
    fn told(&self, query: &str) -> Answer {
        let Ok(from) = query.strip_prefix("from=").unwrap_or("0").parse() else {
            return Answer::refusal(BAD_REQUEST);
        };
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let told = state.job.as_ref().map_or(Value::Null, |job| job.told(from));
        Answer::json(&told)
    }
}

impl Place {
    fn scene_name(&self) -> String {
        let name = self.scene.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }
}

fn saved(place: &Place) -> Answer {
    Answer::json(&json!({ "saved": place.scene_name() }))
}

impl Site for Setup {
    fn refuses(&self, request: &Request) -> Option<&'static str> {
        let Some(name) = self.below(&request.path) else {
            return Some(NOT_FOUND);
        };
        let posts = request.method == Method::Post;
        (ACTIONS.contains(&name) != posts).then_some(METHOD_NOT_ALLOWED)
    }

    fn answer(&self, request: &Request) -> Answer {
        let name = self.below(&request.path).unwrap_or_default();
        match (request.method, name) {
            (Method::Post, action) => match serde_json::from_slice(&request.body) {
                Ok(sent) => self.act(action, &sent),
                Err(_) => Answer::refusal(BAD_REQUEST),
            },
            (_, "") => Answer {
                policy: Some(self.page.policy.clone()),
                ..Answer::found("index.html", self.page.html.clone())
            },
            (_, "progress") => self.told(&request.query),
            (_, path) => match path.strip_prefix("results/") {
                Some(name) => file(&self.place.out, name),
                None => Answer::refusal(NOT_FOUND),
            },
        }
    }
}
