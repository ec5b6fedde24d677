//! A page about several runs.

use crate::Error;
use crate::html::render;
use crate::interactive::{Live, Runs};
use crate::page::frequencies;
use analyses::results::summary::Summary;
use askama::Template;

/// A run of several.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Address of its own page, relative to that of the comparison.
    pub page: &'a str,
    /// Its numbers.
    pub summary: &'a Summary,
}

#[derive(Template)]
#[template(path = "runs.html")]
struct Page<'a> {
    title: String,
    rows: Vec<Row<'a>>,
    live: Live,
}

struct Row<'a> {
    name: &'a str,
    page: &'a str,
    structure: &'a str,
    frequencies: String,
    warnings: usize,
}

/// The backbones of the runs on shared axes, and a table of the runs.
///
/// # Errors
/// [`Error::Table`], [`Error::Summary`], [`Error::Page`].
pub fn document(runs: &[Entry<'_>]) -> Result<String, Error> {
    let rows = runs.iter().map(|run| Row {
        name: run.name,
        page: run.page,
        structure: &run.summary.title,
        frequencies: frequencies(run.summary.modes.iter().map(|mode| &mode.frequency_hz)),
        warnings: run.summary.warnings.len(),
    });
    render(&Page {
        title: format!("{} runs", runs.len()),
        rows: rows.collect(),
        live: Live::runs(&Runs::of(runs.iter().map(|run| (run.name, run.page, run.summary)))?)?,
    })
}
