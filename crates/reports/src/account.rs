//! What is printed at the end of a run.

use crate::answer::{self, length};
use crate::errors::{adaptation, errors};
use crate::names::SUMMARY;
use crate::phrases::damping;
use crate::plot;
use crate::registry::ANALYSES;
use analyses::mesh_error::{FrequencyEstimate, MeshEstimate};
use analyses::results::summary::Summary;
use scenes::Scene;
use std::fmt::Write;
use std::path::Path;

/// Most lines of an analysis beside the backbones that are printed where not all is.
const FEW: usize = 5;

/// The backbone of one mode.
fn table(out: &mut String, summary: &Summary) {
    let cell = |value: Option<f64>, format: &dyn Fn(f64) -> String| value.map_or_else(|| "-".into(), format);
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "{:>4} {:>14} {:>15} {:>12} {:>14} {:>11}",
        "no.", "amplitude [m]", "frequency [Hz]", "damping [-]", "slipping area", "iterations"
    );
    for (index, b) in summary.backbone.iter().enumerate() {
        let _ = writeln!(
            out,
            "{:>4} {:>14} {:>15} {:>12} {:>14} {:>11}{}",
            index + 1,
            cell(b.response_displacement, &|v| format!("{v:.4e}")),
            cell(b.frequency_hz, &|v| format!("{v:.4}")),
            damping(b),
            cell(b.slip_fraction, &|v| format!("{:.2} %", 100.0 * v)),
            b.iterations,
            b.failure
                .as_ref()
                .map_or_else(String::new, |reason| format!("  not converged: {reason}")),
        );
    }
}

/// What is missing of a backbone.
fn shortcomings(out: &mut String, summary: &Summary) {
    let failed = summary.backbone.iter().filter(|b| !b.converged).count();
    if failed > 0 {
        let all = summary.backbone.len();
        let _ = writeln!(
            out,
            "{failed} of {all} amplitudes DID NOT CONVERGE; their results are missing"
        );
    }
    let open = summary.backbone.iter().filter(|b| b.closed == Some(false));
    let at: Vec<String> = open.filter_map(|b| b.response_displacement).map(length).collect();
    if !at.is_empty() {
        let loops = if at.len() == 1 { "loop" } else { "loops" };
        let _ = writeln!(
            out,
            "{} {loops} did not close within the cycles allowed, at {}: their damping still changes from cycle to cycle; see cycles and \
             damping_floor in {SUMMARY}",
            at.len(),
            at.join(", ")
        );
    }
}

/// The two formulations beside each other.
fn mesh_estimate(estimate: &MeshEstimate) -> String {
    let mut out = String::new();
    let [own, other] = estimate.formulations();
    let limit = |frequency: &FrequencyEstimate| match (frequency.limit_hz, frequency.uncertainty_hz) {
        (Some(limit), Some(uncertainty)) => format!("{limit:.3} +- {uncertainty:.3}"),
        _ => "-".into(),
    };
    for mode in &estimate.modes {
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "\nmode {} with two formulations, {own} and {other}\n{:>14} {:>15} {:>15} {:>12} {:>20} {:>14}",
            mode.mode, "amplitude [m]", "frequency [Hz]", "other [Hz]", "difference", "limit [Hz]", "ln(damping)"
        );
        let first = (None, &mode.linear_frequency, None);
        let amplitudes = mode.amplitudes.iter();
        let rows = amplitudes.map(|a| (Some(a.response_displacement), &a.frequency, a.damping_ln_difference));
        for (amplitude, frequency, damping) in std::iter::once(first).chain(rows) {
            let _ = writeln!(
                out,
                "{:>14} {:>15.4} {:>15.4} {:>+11.3}% {:>20} {:>14}",
                amplitude.map_or_else(|| "linearised".into(), |a| format!("{a:.4e}")),
                frequency.own_hz,
                frequency.other_hz,
                100.0 * frequency.relative_difference,
                limit(frequency),
                damping.map_or_else(|| "-".into(), |d: f64| format!("{d:+.3}"))
            );
        }
    }
    let _ = writeln!(out, "limit: {}", estimate.rule());
    if estimate.share_of_elements < 1.0 {
        let share = 100.0 * estimate.share_of_elements;
        let _ = writeln!(
            out,
            "only {share:.1} % of the elements have both formulations; the error of the others is not in it"
        );
    }
    out
}

/// What the settings promise, and how far finer ones lead.
fn of_settings(summary: &Summary, scene: &Scene) -> String {
    let mut out = String::new();
    let cell = |value: Option<f64>| value.map_or_else(|| "-".into(), |v| format!("{v:.1e}"));
    if let Some(preset) = summary.accuracy {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "settings `{}`: {}", preset.name, preset.promise(scene));
    }
    if let Some(estimate) = &summary.error_estimate {
        let _ = writeln!(
            out,
            "against the settings `{}`: first frequency {:+.2e}, frequencies within {}, logarithm of damping within {}",
            estimate.finer,
            estimate.linear_frequency,
            cell(estimate.frequency),
            cell(estimate.damping)
        );
    }
    out
}

/// What is known of the error of the mesh.
fn of_mesh(summary: &Summary) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "error of the mesh: {}", summary.model.error_bar.sentence());
    if let Some(places) = summary.model.error_bar.places() {
        let _ = writeln!(out, "the mesh errs most at {places} of the error");
    }
    if let Some(estimate) = &summary.mesh_estimate {
        out.push_str(&mesh_estimate(estimate));
    }
    out
}

/// All that was found, apart from the answer.
fn details(summary: &Summary, scene: &Scene) -> String {
    let mut out = String::new();
    for (mode, of_mode) in summary.by_mode() {
        // Writing to a string cannot fail.
        let _ = match mode {
            Some(mode) => writeln!(out, "\nmode {mode}"),
            None => writeln!(out),
        };
        if !of_mode.backbone.is_empty() {
            table(&mut out, &of_mode);
        }
    }
    for analysis in ANALYSES {
        out.push_str(&(analysis.lines)(summary));
    }
    let _ = writeln!(out, "\namplitude: {}", plot::amplitude_label(&summary.response));
    if let (Some(first), Some(stuck)) = (summary.modes.first(), summary.model.stuck_frequencies_hz.first()) {
        let first = first.frequency_hz;
        let _ = writeln!(
            out,
            "first frequency about the prestress: {first:.3} Hz (interface stuck: {stuck:.3} Hz)"
        );
    }
    if let Some(torque) = &summary.torque {
        let _ = writeln!(out, "{}", torque.line());
    }
    out.push_str(&of_settings(summary, scene));
    if let Some(found) = &summary.adaptation {
        let _ = writeln!(out, "accuracy: {}", adaptation(found));
    }
    if let Some(errors) = errors(summary) {
        let _ = writeln!(out, "errors of the settings: {errors}");
    }
    out.push_str(&of_mesh(summary));
    out
}

/// What is printed at the end: the answer, what is missing of it, and where the rest is; all that was found before it if it shall be `verbose`.
pub fn account(summary: &Summary, scene: &Scene, directory: &Path, verbose: bool) -> String {
    let (mut out, name) = (String::new(), &scene.name);
    if verbose {
        out.push_str(&details(summary, scene));
    } else {
        let lines = ANALYSES.iter().map(|analysis| (analysis.lines)(summary));
        out.extend(lines.filter(|lines| lines.trim().lines().count() <= FEW));
        // What a command was asked for by an option of its own.
        if summary.error_estimate.is_some() {
            out.push_str(&of_settings(summary, scene));
        }
        if summary.mesh_estimate.is_some() {
            out.push_str(&of_mesh(summary));
        }
    }
    for (_, of_mode) in summary.by_mode() {
        shortcomings(&mut out, &of_mode);
    }
    out.push_str(&answer::lines(summary));
    let total = summary.timings.get("total").copied().unwrap_or_default();
    let _ = writeln!(
        out,
        "{name}: {total:.1} s; results, with report.html to begin with, in {}",
        directory.display()
    );
    out
}
