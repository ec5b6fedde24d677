//! `view`: runs beside each other in a browser.

use super::web::{self, Answer, METHOD_NOT_ALLOWED, Method, NOT_FOUND, Request, Site};
use crate::files;
use crate::text::print;
use analyses::results::summary::Summary;
use anyhow::{Result, ensure};
use reports::several::{self, Entry};
use std::path::PathBuf;

/// Options of `view`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folders of results of `run`, or of `forced`.
    #[arg(required = true, value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// Print the address and leave it to the reader to open it.
    #[arg(long)]
    no_open: bool,
}

/// Runs the command, which ends with the process.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let mut runs = Vec::with_capacity(arguments.results.len());
    for folder in &arguments.results {
        ensure!(
            folder.is_dir(),
            "{} is no folder; give the folders of results, which `microslip run` writes",
            folder.display()
        );
        runs.push(files::summary(folder)?);
    }
    let name = |summary: &Summary| summary.scene["name"].as_str().unwrap_or_default().to_owned();
    let names: Vec<String> = runs
        .iter()
        .zip(&arguments.results)
        .map(
            |(run, folder)| match runs.iter().filter(|other| name(other) == name(run)).count() {
                1 => name(run),
                _ => format!("{} ({})", name(run), folder.display()),
            },
        )
        .collect();
    let pages: Vec<String> = (1..=runs.len()).map(|number| format!("{number}/report.html")).collect();
    let entries: Vec<Entry<'_>> = (names.iter().zip(&pages).zip(&runs))
        .map(|((name, page), summary)| Entry { name, page, summary })
        .collect();
    let site = Runs {
        index: several::document(&entries)?,
        folders: arguments.results.clone(),
    };
    let (listener, address) = web::listen(0)?;
    print(&format!("{} runs at {address}; Ctrl-C ends it\n", runs.len()))?;
    if !arguments.no_open {
        web::open(&address);
    }
    web::serve(&listener, site)
}

/// What is served.
struct Runs {
    /// The page at the root.
    index: String,
    /// Folders whose files are at `NUMBER/NAME`, from 1 on.
    folders: Vec<PathBuf>,
}

impl Site for Runs {
    fn refuses(&self, request: &Request) -> Option<&'static str> {
        (request.method == Method::Post).then_some(METHOD_NOT_ALLOWED)
    }

    fn answer(&self, request: &Request) -> Answer {
        if request.path == "/" {
            return Answer::found("index.html", self.index.clone());
        }
        let place = request.path[1..].split_once('/').and_then(|(number, name)| {
            let index = number.parse::<usize>().ok()?.checked_sub(1)?;
            Some((self.folders.get(index)?, name))
        });
        match place {
            Some((folder, name)) => web::file(folder, name),
            None => Answer::refusal(NOT_FOUND),
        }
    }
}
