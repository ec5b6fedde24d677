//! The entries as a page in HTML, and as a few lines of text.

use super::entry::{self, Computed, Figure};
use reports::Error;
use reports::findings::{Findings, FindingsPage, Section};
use reports::html::{Picture, Table};
use std::fmt::Write;
use std::path::Path;

const TITLE: &str = "The paper, recomputed";

const INTRODUCTION: &str = "Every result of Balaji, Chen and Brake (2020), DOI 10.1016/j.ymssp.2020.106615, that can be computed without \
    its private scans, beside the published figure. The scans of the authors are not public: in their place stand the measured \
    asperity statistics and gap of another interface of the same beam (Porter and Brake 2023, DOI 10.1016/j.ymssp.2023.110210), or \
    two synthetic scans on the paper's grid; where that is so, the last column of a table says it at the number. Figures of entries \
    that are not comparable can agree no better than the surfaces do.";

const QUICK: &str =
    "This is a quick look: the mesh is coarser than the paper's and the figures are not those of its mesh.";

/// A number with five significant digits, as an exponential outside of the range of easy reading.
fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let exponent = value.abs().log10().floor();
    if (-3.0..6.0).contains(&exponent) {
        let places = (4.0 - exponent).clamp(0.0, 6.0) as usize;
        format!("{value:.places$}")
    } else {
        format!("{value:.4e}")
    }
}

fn difference(figure: &Figure) -> String {
    match (figure.published, figure.difference()) {
        (Some(0.0), Some(difference)) => number(difference),
        (_, Some(difference)) => format!("{:+.2} %", 100.0 * difference),
        _ => String::new(),
    }
}

fn cells(figure: &Figure) -> [String; 5] {
    [
        figure.name.clone(),
        figure.published.map_or_else(|| "–".into(), number),
        number(figure.computed),
        difference(figure),
        figure.note.into(),
    ]
}

const HEADINGS: [&str; 5] = ["figure", "published", "here", "difference", "remark"];

fn comparable(comparable: bool) -> &'static str {
    if comparable {
        "inputs as published, as far as they are printed"
    } else {
        "the inputs differ from the published ones"
    }
}

/// The page as HTML, pictures included.
pub(super) fn html(computed: &[Computed], quick: bool) -> Result<String, Error> {
    let page = FindingsPage {
        title: TITLE,
        introduction: INTRODUCTION,
        warning: quick.then_some(QUICK),
        sections: computed.iter().map(section).collect(),
        cases: None,
    };
    page.html()
}

fn section(computed: &Computed) -> Section<'_> {
    Section {
        id: computed.entry.id,
        title: computed.entry.title,
        inputs: computed.entry.inputs,
        findings: match &computed.findings {
            Ok(found) => Ok(findings(found, computed.seconds)),
            Err(reason) => Err(reason),
        },
    }
}

fn findings(found: &entry::Findings, seconds: f64) -> Findings<'_> {
    let pictures = found.pictures.iter().map(|picture| Picture {
        svg: picture.svg.as_str().into(),
        caption: picture.caption.clone(),
    });
    Findings {
        judgement: &found.judgement,
        pictures: pictures.collect(),
        tables: vec![(
            String::new(),
            Table {
                headings: HEADINGS.map(Into::into).into(),
                rows: found.figures.iter().map(|figure| cells(figure).into()).collect(),
            },
        )],
        remark: format!("{seconds:.0} s of computation; {}.", comparable(found.comparable)),
    }
}

/// What is printed at the end.
pub(super) fn account(computed: &[Computed], folder: &Path, seconds: f64) -> String {
    let mut out = String::from("\n");
    for Computed { entry, findings, .. } in computed {
        let text = match findings {
            Ok(found) => found.judgement.clone(),
            Err(reason) => format!("FAILED: {reason}"),
        };
        let _ = writeln!(out, "{:>10}  {text}", entry.id);
    }
    let _ = writeln!(
        out,
        "\n{} entries in {seconds:.0} s; results, with report.html to begin with, in {}",
        computed.len(),
        folder.display()
    );
    out
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_have_five_digits() {
        let texts = [0.0, 168.267912, -0.0123456, 12850.015, 1.0528e11, 4.2e-9].map(number);
        assert_eq!(texts, ["0", "168.27", "-0.012346", "12850", "1.0528e11", "4.2000e-9"]);
    }
}
