//! What the scripts of a page about several runs read.

use super::data::Backbone;
use crate::Error;
use analyses::results::summary::Summary;
use serde::Serialize;
use serde_json::Value;

/// Runs beside each other.
#[derive(Debug, Serialize)]
pub(crate) struct Runs {
    runs: Vec<Entry>,
}

#[derive(Debug, Serialize)]
struct Entry {
    name: String,
    /// The response point in words.
    response: String,
    /// Where its own page is.
    page: String,
    modes: Vec<Backbone>,
}

impl Runs {
    /// Runs with their names and the addresses of their own pages.
    ///
    /// # Errors
    /// [`Error::Table`].
    pub(crate) fn of<'a>(runs: impl IntoIterator<Item = (&'a str, &'a str, &'a Summary)>) -> Result<Self, Error> {
        let entry = |(name, page, summary): (&str, &str, &Summary)| {
            let modes = summary.by_mode().map(|(further, of_mode)| {
                Backbone::of(further.unwrap_or_else(|| first_mode(summary)), further, &of_mode)
            });
            Ok::<_, Error>(Entry {
                name: name.into(),
                response: summary.response.clone(),
                page: page.into(),
                modes: modes.collect::<Result<_, _>>()?,
            })
        };
        Ok(Self {
            runs: runs.into_iter().map(entry).collect::<Result<_, _>>()?,
        })
    }
}

/// The first mode that a run followed, counted from 1.
fn first_mode(summary: &Summary) -> usize {
    let cqsma = &summary.scene["cqsma"];
    let asked = [&cqsma["modes_of_interest"][0], &cqsma["mode"]]
        .into_iter()
        .find_map(Value::as_u64);
    match (summary.backbones.first(), asked) {
        (Some(first), _) => first.mode,
        (None, asked) => asked.map_or(1, |mode| mode as usize),
    }
}
