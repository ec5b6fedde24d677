//! Bolts tightened one after the other: table and picture.

use crate::analysis::{Analysis, Document, Section};
use crate::csv::{number, table};
use crate::html::{Picture, Table};
use crate::motions::shade;
use crate::plot::{Curve, Marks, Panel, stack};
use crate::{Error, Output};
use analyses::TighteningResult;
use plotters::chart::SeriesLabelPosition;
use plotters::style::RGBColor;

/// Name of the table of a tightening sequence.
pub const TIGHTENING: &str = "tightening.csv";

/// Name of its picture.
pub const TIGHTENING_PICTURE: &str = "tightening.svg";

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| [TIGHTENING, TIGHTENING_PICTURE].contains(&name),
    document: |_, summary| {
        let Some(result) = &summary.tightening else {
            return Ok(None);
        };
        let picture = picture(result)?;
        Ok(Some(Document {
            outputs: vec![
                Output::new(TIGHTENING, csv(result)?),
                Output::new(TIGHTENING_PICTURE, picture.clone()),
            ],
            section: Some(section(result, picture)),
        }))
    },
    lines: |summary| summary.tightening.as_ref().map(line).unwrap_or_default(),
    is_complete: |_| true,
};

/// What the terminal says.
fn line(result: &TighteningResult) -> String {
    let residual: Vec<String> = result
        .residual_preloads
        .iter()
        .map(|load| format!("{:.3}", 1e-3 * load))
        .collect();
    let lowest = result.residual_ratios.iter().copied().fold(f64::INFINITY, f64::min);
    format!(
        "tightened in {} steps: {} kN are left, at least {:.2} % of the load; {:.2e} of the work on the bolts is dissipated; table in \
         {TIGHTENING}\n",
        result.steps.len(),
        residual.join(", "),
        100.0 * lowest,
        result.energy.dissipated / result.energy.external_work
    )
}

/// One row per step.
///
/// # Errors
/// [`Error::Table`].
fn csv(result: &TighteningResult) -> Result<String, Error> {
    let bolts = result.residual_preloads.len();
    let of_each =
        |what: &'static str, unit: &'static str| (1..=bolts).map(move |bolt| format!("{what}_{bolt} [{unit}]"));
    let first = ["step", "pass", "bolt", "target [N]"].map(str::to_owned).into_iter();
    let headings = first
        .chain(of_each("tension", "N"))
        .chain(of_each("interaction", "N"))
        .chain(of_each("advance", "m"))
        .chain(["external_work [J]", "iterations"].map(str::to_owned));
    let rows = (1..).zip(&result.steps).map(|(count, step): (usize, _)| {
        let first = [count, step.pass, step.bolt].map(|value| value.to_string()).into_iter();
        let values = std::iter::once(&step.target)
            .chain(&step.tensions)
            .chain(&step.interaction)
            .chain(&step.advances)
            .chain(std::iter::once(&step.external_work));
        first
            .chain(values.map(|value| number(*value)).collect::<Vec<_>>())
            .chain(std::iter::once(step.iterations.to_string()))
            .collect::<Vec<_>>()
    });
    table(headings, rows)
}

/// Tension of every bolt against the step.
///
/// # Errors
/// [`Error::Picture`].
fn picture(result: &TighteningResult) -> Result<String, Error> {
    let bolts = result.residual_preloads.len();
    let steps = || (1..).zip(&result.steps).map(|(count, step): (usize, _)| (count, step));
    let of_bolt = |bolt: usize| {
        let after = steps().map(|(count, step)| (count, count as f64, 1e-3 * step.tensions[bolt]));
        Curve {
            name: format!("bolt {}", bolt + 1),
            colour: shade(bolt, bolts),
            dashes: None,
            marks: Marks::Dots,
            points: std::iter::once((0, 0.0, 0.0)).chain(after).collect(),
        }
    };
    let targets = Curve {
        name: "target".into(),
        colour: RGBColor(90, 90, 90),
        dashes: None,
        marks: Marks::Crosses,
        points: steps()
            .map(|(count, step)| (count, count as f64, 1e-3 * step.target))
            .collect(),
    };
    let panel = Panel {
        y_label: "tension [kN]",
        log: None,
        legend: SeriesLabelPosition::LowerRight,
        curves: (0..bolts).map(of_bolt).chain([targets]).collect(),
    };
    stack("step of tightening", false, vec![panel])
}

/// What the page says of it.
fn section(result: &TighteningResult, picture: String) -> Section {
    let bolts = result.residual_preloads.len();
    let kilonewtons = |value: &f64| format!("{:.3}", 1e-3 * value);
    let headings = ["Step", "Pass", "Bolt", "Target [kN]"].map(str::to_owned).into_iter();
    let steps = (1..).zip(&result.steps).map(|(count, step): (usize, _)| {
        let first = [count, step.pass, step.bolt].map(|value| value.to_string()).into_iter();
        first
            .chain([kilonewtons(&step.target)])
            .chain(step.tensions.iter().map(kilonewtons))
            .collect()
    });
    let ratios: Vec<String> = result
        .residual_ratios
        .iter()
        .map(|ratio| format!("{:.2} %", 100.0 * ratio))
        .collect();
    let energy = &result.energy;
    Section {
        heading: "Tightening",
        pictures: vec![Picture {
            svg: picture.into(),
            caption: format!(
                "Tension of the bolts after each step; a bolt that is tightened changes those tightened before. Left in the end: {} of \
                 the load.",
                ratios.join(", ")
            ),
        }],
        tables: vec![(
            String::new(),
            Table {
                headings: headings
                    .chain((1..=bolts).map(|bolt| format!("Bolt {bolt} [kN]")))
                    .collect(),
                rows: steps.collect(),
            },
        )],
        remarks: vec![format!(
            "Work on the bolts {:.4e} J: stored in bolts and parts {:.4e} J, in the interface {:.4e} J, dissipated {:.4e} J; the balance \
             holds within {:.1e} (at most {:.0e}).",
            energy.external_work,
            energy.stored_in_structure,
            energy.stored_in_contact,
            energy.dissipated,
            energy.imbalance,
            energy.tolerance
        )],
        ..Section::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use analyses::{TighteningEnergy, TighteningStep};

    fn example() -> TighteningResult {
        let step = |bolt: usize, tensions: [f64; 2], interaction: [f64; 2]| TighteningStep {
            pass: 1,
            bolt,
            target: 1e4,
            tensions: tensions.to_vec(),
            interaction: interaction.to_vec(),
            advances: vec![1e-5, 2e-5],
            external_work: 0.05,
            iterations: 7,
        };
        TighteningResult {
            steps: vec![step(2, [0.0, 1e4], [0.0; 2]), step(1, [1e4, 9.25e3], [0.0, -750.0])],
            residual_preloads: vec![1e4, 9.25e3],
            residual_ratios: vec![1.0, 0.925],
            energy: TighteningEnergy::default(),
        }
    }

    #[test]
    fn the_table_has_a_row_per_step_and_a_column_per_bolt() {
        let table = csv(&example()).unwrap();
        let mut reader = ::csv::Reader::from_reader(table.as_bytes());
        let headings: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let at = |heading: &str| headings.iter().position(|own| own == heading).unwrap();
        let rows: Vec<::csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 2);
        let cell = |row: usize, heading: &str| rows[row][at(heading)].parse::<f64>().unwrap();
        assert_eq!((cell(0, "step"), cell(0, "bolt"), cell(1, "bolt")), (1.0, 2.0, 1.0));
        assert_eq!(
            (cell(1, "tension_2 [N]"), cell(1, "interaction_2 [N]")),
            (9.25e3, -750.0)
        );
        assert_eq!((cell(1, "advance_2 [m]"), cell(1, "iterations")), (2e-5, 7.0));
    }

    #[test]
    fn the_picture_and_the_section_name_bolts_and_what_is_left() {
        let picture = picture(&example()).unwrap();
        for text in ["bolt 1", "bolt 2", "target", "tension [kN]", "step of tightening"] {
            assert!(picture.contains(text), "{text}");
        }
        crate::markup::check(&picture).unwrap();
        let section = section(&example(), picture);
        assert!(section.pictures[0].caption.contains("100.00 %, 92.50 %"));
        assert_eq!(section.tables[0].1.headings.len(), 6);
        assert_eq!(section.tables[0].1.rows[1][3..], ["10.000", "10.000", "9.250"]);
    }
}
