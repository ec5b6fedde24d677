//! What makes a page answer: data in the page, and scripts that draw them.
//!
//! A page stays one file that asks nobody for anything. Its scripts are the files of this folder, in strict mode and without a framework,
//! and the libraries in `vendor`. Without scripts the page shows its static pictures.

pub(crate) mod bodies;
mod data;
mod encode;
mod setup;
mod several;
mod shapes;

pub(crate) use data::Document;
pub(crate) use setup::Setup;
pub(crate) use several::Runs;
pub(crate) use shapes::Shapes;

use crate::cases::Cases;
use crate::{Error, styles};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// The plotting library with its style.
const UPLOT: [&str; 2] = [
    include_str!("../../vendor/uplot.min.js"),
    include_str!("../../vendor/uplot.min.css"),
];

/// The parts of the library for pictures in space that are used.
const THREE: &str = include_str!("../../vendor/three.min.js");

/// The style of what scripts make.
const STYLE: &str = include_str!("live.css");

/// What all scripts use.
const COMMON: &str = include_str!("common.js");

/// What scripts of a page about a run consist of, in this order.
const RUN: [&str; 8] = [
    include_str!("table.js"),
    include_str!("chart.js"),
    include_str!("curves.js"),
    include_str!("maps.js"),
    include_str!("loops.js"),
    include_str!("scene3d.js"),
    include_str!("body3d.js"),
    include_str!("main.js"),
];

/// What scripts of a page about several runs consist of, in this order.
const RUNS: [&str; 4] = [
    include_str!("table.js"),
    include_str!("chart.js"),
    include_str!("curves.js"),
    include_str!("several.js"),
];

/// What scripts of a page about a study consist of, in this order.
const CASES: [&str; 2] = [include_str!("chart.js"), include_str!("cases.js")];

/// What scripts of a page about mode shapes consist of, in this order.
const SHAPES: [&str; 2] = [include_str!("scene3d.js"), include_str!("shapes.js")];

/// What scripts of the page of a set-up consist of, in this order.
const SETUP: [&str; 6] = [
    include_str!("chart.js"),
    include_str!("scene3d.js"),
    include_str!("setup-form.js"),
    include_str!("setup-view.js"),
    include_str!("setup-run.js"),
    include_str!("setup.js"),
];

/// The style of that page.
const SETUP_STYLE: &str = include_str!("setup.css");

/// What a template puts into a page.
#[derive(Debug)]
pub(crate) struct Live {
    /// Directives of the content security policy: the scripts of the page, and nothing from elsewhere.
    pub(crate) policy: String,
    /// Style sheets.
    pub(crate) style: String,
    /// The data as JSON.
    pub(crate) data: String,
    /// Scripts, to be run in this order.
    pub(crate) scripts: Vec<String>,
}

impl Live {
    /// What a page about a run needs.
    ///
    /// # Errors
    /// [`Error::Summary`] if the data have no JSON.
    pub(crate) fn run(document: &Document) -> Result<Self, Error> {
        let mut scripts = vec![UPLOT[0].to_owned()];
        if document.is_in_space() {
            scripts.push(THREE.to_owned());
        }
        scripts.push(own(&RUN));
        Self::new(document, scripts, &[UPLOT[1], STYLE])
    }

    /// What a page about mode shapes needs.
    ///
    /// # Errors
    /// [`Error::Summary`] if the data have no JSON.
    pub(crate) fn shapes(shapes: &Shapes) -> Result<Self, Error> {
        Self::new(shapes, vec![THREE.to_owned(), own(&SHAPES)], &[STYLE])
    }

    /// What a page about several runs needs.
    ///
    /// # Errors
    /// [`Error::Summary`] if the data have no JSON.
    pub(crate) fn runs(runs: &Runs) -> Result<Self, Error> {
        Self::new(runs, vec![UPLOT[0].to_owned(), own(&RUNS)], &[UPLOT[1], STYLE])
    }

    /// What the page of a set-up needs.
    ///
    /// # Errors
    /// [`Error::Summary`] if the data have no JSON.
    pub(crate) fn setup(setup: &Setup<'_>) -> Result<Self, Error> {
        let scripts = vec![UPLOT[0].to_owned(), THREE.to_owned(), own(&SETUP)];
        Self::new(setup, scripts, &[UPLOT[1], STYLE, SETUP_STYLE])
    }

    /// What a page about the cases of a study needs.
    ///
    /// # Errors
    /// [`Error::Summary`] if the data have no JSON.
    pub(crate) fn cases(cases: &Cases) -> Result<Self, Error> {
        Self::new(cases, vec![UPLOT[0].to_owned(), own(&CASES)], &[UPLOT[1], STYLE])
    }

    fn new(data: &impl Serialize, scripts: Vec<String>, styles: &[&str]) -> Result<Self, Error> {
        let scripts: Vec<String> = scripts.iter().map(|script| format!("\n{}\n", script.trim())).collect();
        let mut policy = String::from(
            "default-src 'none'; base-uri 'none'; form-action 'none'; style-src 'unsafe-inline'; script-src",
        );
        for script in &scripts {
            let hash = encode::base64(&Sha256::digest(script.as_bytes()));
            // Writing to a string cannot fail.
            let _ = write!(policy, " 'sha256-{hash}'");
        }
        Ok(Self {
            policy,
            style: styles.join("\n"),
            data: json(data)?,
            scripts,
        })
    }
}

/// Files of this folder as one script.
fn own(files: &[&str]) -> String {
    let mut script = String::from("\"use strict\";\n");
    script += COMMON;
    script += &styles::script();
    files.iter().for_each(|file| script += file);
    script
}

/// JSON that no reader of HTML takes for markup.
fn json(data: &impl Serialize) -> Result<String, Error> {
    let text = serde_json::to_string(data).map_err(Error::Summary)?;
    Ok(text
        .replace('<', "\\u003c")
        .replace('>', "\\u003e")
        .replace('&', "\\u0026"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_has_no_markup() {
        let text = json(&"</script> & <!--").unwrap();
        assert_eq!(text, "\"\\u003c/script\\u003e \\u0026 \\u003c!--\"");
        assert_eq!(serde_json::from_str::<String>(&text).unwrap(), "</script> & <!--");
    }

    #[test]
    fn libraries_are_those_whose_sums_are_written_down() {
        let account = include_str!("../../vendor/README.md");
        for file in [UPLOT[0], UPLOT[1], THREE] {
            let sum: String = Sha256::digest(file).iter().map(|byte| format!("{byte:02x}")).collect();
            assert!(account.contains(&sum), "{sum}");
        }
    }

    #[test]
    fn scripts_hold_nothing_that_a_page_changes_or_ends() {
        for script in RUN
            .iter()
            .chain(&SHAPES)
            .chain(&RUNS)
            .chain(&SETUP)
            .chain(&CASES)
            .chain(&UPLOT[..1])
            .chain(&[THREE, COMMON])
        {
            assert!(!script.contains("</script") && !script.contains("<!--"));
            assert!(!script.contains(|c: char| c.is_control() && !c.is_whitespace()));
        }
    }
}
