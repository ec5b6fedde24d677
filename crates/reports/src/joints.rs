//! Several interfaces: what each of them does along the backbone.

use crate::analysis::{Analysis, Document, Section};
use crate::csv::{number, optional, table};
use crate::html::Picture;
use crate::plot::{BLUE, Canvas, picture};
use crate::{Drawing, Error, Output};
use analyses::results::summary::{BackboneSummary, JointSummary, Summary};
use plotters::prelude::*;

/// Name of the table of interfaces.
pub const JOINTS: &str = "joints.csv";

/// Name of the picture of their dissipation.
pub const JOINTS_PICTURE: &str = "joints.svg";

/// Most interfaces that are drawn: those that dissipate most.
const MOST: usize = 30;

/// Pixels: height of a bar with its gap, where bars begin and end, height of the title.
const ROW: i32 = 22;
const BARS: [i32; 2] = [240, 740];
const TITLE: i32 = 40;

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| [JOINTS, JOINTS_PICTURE].contains(&name),
    document: |_, summary| {
        let Some(last) = last(summary) else {
            return Ok(None);
        };
        let mut outputs = vec![Output::new(JOINTS, csv(&summary.backbone)?)];
        let mut section = None;
        if last.joints.iter().any(|joint| joint.dissipation > 0.0) {
            let svg = bars(last)?;
            outputs.push(Output::new(JOINTS_PICTURE, svg.clone()));
            section = Some(Section {
                heading: "Interfaces",
                pictures: vec![Picture {
                    svg: svg.into(),
                    caption: caption(last),
                }],
                remarks: stiffest(summary)
                    .into_iter()
                    .chain([format!(
                        "Slip, contact and dissipation of each interface at all amplitudes: {JOINTS}."
                    )])
                    .collect(),
                ..Section::default()
            });
        }
        Ok(Some(Document { outputs, section }))
    },
    lines: |summary| last(summary).map(line).unwrap_or_default(),
    is_complete: |_| true,
};

/// The largest amplitude of the first mode followed that has several interfaces.
fn last(summary: &Summary) -> Option<&BackboneSummary> {
    summary
        .backbone
        .iter()
        .rev()
        .find(|amplitude| !amplitude.joints.is_empty())
}

/// Interfaces from that which dissipates most on.
fn by_dissipation(joints: &[JointSummary]) -> Vec<&JointSummary> {
    let mut joints: Vec<&JointSummary> = joints.iter().collect();
    // The first of equal ones first.
    joints.sort_by(|a, b| b.dissipation.total_cmp(&a.dissipation));
    joints
}

/// A row per amplitude and interface.
fn csv(backbone: &[BackboneSummary]) -> Result<String, Error> {
    let headings = [
        "number",
        "response_displacement [m]",
        "joint",
        "slip_fraction [-]",
        "contact_area_fraction [-]",
        "dissipation [J]",
        "dissipation_share [-]",
    ];
    let rows = (1..).zip(backbone).flat_map(|(count, amplitude): (usize, _)| {
        let row = move |joint: &JointSummary| {
            [
                count.to_string(),
                optional(amplitude.response_displacement),
                joint.name.clone(),
                number(joint.slip_fraction),
                number(joint.contact_area_fraction),
                number(joint.dissipation),
                optional(joint.dissipation_share),
            ]
        };
        amplitude.joints.iter().map(row)
    });
    table(headings, rows)
}

fn caption(of: &BackboneSummary) -> String {
    let shown = of.joints.len().min(MOST);
    let all = match shown < of.joints.len() {
        true => format!(" of the {shown} interfaces that dissipate most"),
        false => " of each interface".to_owned(),
    };
    format!(
        "Share{all} in the dissipation of a cycle at the largest amplitude that converged, and the share of its area that slips."
    )
}

fn bars(of: &BackboneSummary) -> Result<String, Error> {
    let joints = by_dissipation(&of.joints);
    let shown = &joints[..joints.len().min(MOST)];
    let size = (900, (TITLE + ROW * shown.len() as i32 + 20) as u32);
    picture("the dissipation of the interfaces", size, |root| draw(root, shown))
}

fn draw(root: &Canvas<'_>, shown: &[&JointSummary]) -> Result<(), Drawing> {
    let style = ("sans-serif", 14).into_font().color(&BLACK);
    let share = |joint: &JointSummary| joint.dissipation_share.unwrap_or(0.0);
    let largest = shown.iter().map(|joint| share(joint)).fold(0.0, f64::max);
    let [from, to] = BARS;
    root.draw(&Text::new(
        "share of the dissipation (slipping area)",
        (from, 12),
        style.clone(),
    ))?;
    for (place, joint) in (0..).zip(shown) {
        let top = TITLE + ROW * place;
        let length = if largest > 0.0 { share(joint) / largest } else { 0.0 };
        let end = from + (f64::from(to - from) * length).round() as i32;
        root.draw(&Text::new(joint.name.clone(), (10, top + 2), style.clone()))?;
        root.draw(&Rectangle::new([(from, top), (end, top + ROW - 6)], BLUE.filled()))?;
        let told = format!("{:.1} % ({:.1} %)", 100.0 * share(joint), 100.0 * joint.slip_fraction);
        root.draw(&Text::new(told, (end + 8, top + 2), style.clone()))?;
    }
    Ok(())
}

/// The interface whose stiffness the first mode followed depends on most.
fn stiffest(summary: &Summary) -> Option<String> {
    let mode = summary.answer.first()?.mode;
    let found = summary
        .modes
        .get(mode.checked_sub(1)?)?
        .dln_frequency_by_interface
        .iter();
    let (part, change) = summary
        .interfaces
        .iter()
        .zip(found)
        .max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    Some(format!(
        "The frequency of mode {mode} follows the stiffness of `{}` most: {:.2} % where that changes by 1 %.",
        part.name, change
    ))
}

/// What the terminal says.
fn line(of: &BackboneSummary) -> String {
    let Some(first) = by_dissipation(&of.joints)
        .first()
        .copied()
        .filter(|joint| joint.dissipation > 0.0)
    else {
        return String::new();
    };
    format!(
        "of {} interfaces, `{}` dissipates most at the largest amplitude: {:.1} % of all; table in {JOINTS}\n",
        of.joints.len(),
        first.name,
        100.0 * first.dissipation_share.unwrap_or(0.0)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn interfaces_are_drawn_from_the_one_that_dissipates_most_on() {
        let joint = |name: &str, dissipation: f64| {
            json!({
                "name": name, "slip_fraction": 0.25, "contact_area_fraction": 1.0, "dissipation": dissipation,
                "dissipation_share": dissipation / 4.0,
            })
        };
        let joints: Vec<JointSummary> =
            serde_json::from_value(json!([joint("a & b", 1.0), joint("lap 2", 3.0), joint("lap 3", 0.0)]))
                .expect("joints");
        let order = by_dissipation(&joints);
        let svg = picture("joints", (900, 200), |root| draw(root, &order)).expect("a picture");
        assert_eq!(crate::markup::check(&svg), Ok(()));
        let at = |text: &str| svg.find(text).expect(text);
        assert!(at("lap 2") < at("a &amp; b") && at("a &amp; b") < at("lap 3"));
        assert!(svg.contains("75.0 % (25.0 %)"));
    }
}
