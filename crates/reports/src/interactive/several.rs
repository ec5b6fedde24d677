//! What the scripts of a page about several runs read.

use super::data::Backbone;
use crate::Error;
use analyses::results::summary::Summary;
use serde::Serialize;

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
                Backbone::of(further.unwrap_or_else(|| summary.first_mode()), further, &of_mode)
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
