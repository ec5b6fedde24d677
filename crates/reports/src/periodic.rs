//! Periodic motions: files, section and lines of EPMC backbones and forced responses.

use crate::analysis::{Analysis, Document, Section};
use crate::html::{MISSING, Picture, Table};
use crate::motions::{PeriodicMotions, harmonics_picture, loops_picture};
use crate::names::{by_mode, of_mode};
use crate::sweep::{self, SWEEP};
use crate::{Error, Output, csv, fields, plot};
use analyses::Run;
use analyses::forced::{ForcedSummary, PointSummary};
use analyses::results::summary::Summary;
use std::fmt::Write;

/// Name of the table of free periodic motions by EPMC.
pub const EPMC: &str = "epmc.csv";

/// Name of the table of hysteresis loops of single points.
pub const LOOPS: &str = "loops.csv";

/// Name of the table of forced responses.
pub const FORCED: &str = "forced.csv";

/// Name of the picture of forced responses.
pub const FORCED_PICTURE: &str = "forced.svg";

/// Name of the arrays of periodic motions.
pub const PERIODIC: &str = "periodic.npz";

/// Name of the picture of the harmonics of a mode's EPMC backbone; `mode` is none for the first mode followed.
pub fn harmonics_file(mode: Option<usize>) -> String {
    of_mode(mode) + "harmonics.svg"
}

/// Name of the picture of the loops of single points in a mode; `mode` is none for the first mode followed.
pub fn loops_file(mode: Option<usize>) -> String {
    of_mode(mode) + "loops.svg"
}

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| {
        let of_mode = [harmonics_file, loops_file].map(|of| of(by_mode(name).0));
        [EPMC, LOOPS, FORCED, FORCED_PICTURE, PERIODIC, SWEEP].contains(&name) || of_mode.iter().any(|of| of == name)
    },
    document: |run, summary| {
        let Some(motions) = PeriodicMotions::of(run, summary) else {
            return Ok(None);
        };
        let (outputs, pictures) = files(run, &motions)?;
        Ok(Some(Document {
            outputs,
            section: Some(section(summary, pictures)),
        }))
    },
    lines: |summary| {
        let mut out: String = summary.forced.iter().map(|level| line(level) + "\n").collect();
        for swept in summary.forced.iter().filter_map(|level| level.sweep.as_ref()) {
            let _ = writeln!(out, "  {}", sweep::said(swept));
        }
        for stability in stabilities(summary) {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "stability: {stability}");
        }
        out
    },
    is_complete: |summary| {
        let mut levels = summary.forced.iter();
        levels.all(|level| {
            let swept = level.sweep.iter().filter_map(|swept| swept.in_time.as_ref());
            let found = level.resonances.iter().all(|r| r.failure.is_none());
            level.failure.is_none() && found && swept.into_iter().all(|swept| swept.failure.is_none())
        })
    },
};

/// What is said of the stability, each once.
fn stabilities(summary: &Summary) -> Vec<&str> {
    let mut all: Vec<&str> = summary.forced.iter().map(|level| level.stability.as_str()).collect();
    all.dedup();
    all
}

/// What the page says.
fn section(summary: &Summary, pictures: Vec<Picture<'static>>) -> Section {
    let mut warnings = Vec::new();
    for (mode, of_mode) in summary.by_mode() {
        let points = of_mode.methods.get(scenes::EPMC).map_or(&[][..], Vec::as_slice);
        let failed = points.iter().filter(|p| !p.converged).count();
        if failed > 0 {
            let of = mode.map_or_else(String::new, |mode| format!(" of mode {mode}"));
            warnings.push(format!(
                "{failed} of {} free motions{of} did not converge.",
                points.len()
            ));
        }
    }
    for level in &summary.forced {
        let failures = level.failure.iter().map(|reason| format!("ends early: {reason}"));
        let unfound = level.resonances.iter().filter_map(|r| r.failure.as_ref());
        let unfound = unfound.map(|reason| format!("has a resonance that was not found: {reason}"));
        let open = level.open_peaks.iter().map(|(harmonic, hz)| {
            format!("has a peak of harmonic {harmonic} at {hz:.4} Hz whose height is not known to a thousandth")
        });
        let said = failures.chain(unfound).chain(open);
        warnings.extend(said.map(|what| format!("The response to {} {} {what}.", level.level, level.level_unit)));
    }
    let remarks = stabilities(summary)
        .into_iter()
        .map(|said| format!("Stability: {said}."));
    let mut remarks: Vec<String> = remarks.collect();
    let sweeps = summary
        .forced
        .iter()
        .filter_map(|level| Some((level, level.sweep.as_ref()?)));
    remarks
        .extend(sweeps.map(|(level, swept)| format!("{} {}: {}.", level.level, level.level_unit, sweep::said(swept))));
    if !summary.forced.is_empty() {
        let said =
            "Differences of the nonlinear mode alone are those of its largest amplitude and of the frequency there.";
        remarks.insert(0, said.into());
    }
    Section {
        heading: "Periodic motions",
        warnings,
        // The first picture is that of the forced responses, if there are any.
        live: (!summary.forced.is_empty()).then_some("live-forced"),
        pictures,
        tables: match summary.forced.as_slice() {
            [] => Vec::new(),
            levels => vec![(String::new(), levels_table(levels))],
        },
        remarks,
    }
}

/// Resonance, peak and error of one mode alone, level by level.
fn levels_table(levels: &[ForcedSummary]) -> Table {
    let first = level_heading(levels);
    let held = levels.iter().any(ForcedSummary::holds_response);
    let headings = [
        first.as_str(),
        "resonance [Hz]",
        if held { "force there [N]" } else { "amplitude there [m]" },
        "largest amplitude [m]",
        "at [Hz]",
        "nonlinear mode alone: frequency [%]",
        "nonlinear mode alone: amplitude [%]",
        "points",
        "turning points",
    ];
    let row = |level: &ForcedSummary| {
        let found = |value: &dyn Fn(&PointSummary) -> Option<String>| {
            let texts: Vec<String> = level.resonances.iter().filter_map(value).collect();
            if texts.is_empty() {
                MISSING.into()
            } else {
                texts.join(", ")
            }
        };
        let cell = |value: Option<f64>, text: &dyn Fn(f64) -> String| value.map_or_else(|| MISSING.into(), text);
        let percent = |value: f64| format!("{:+.2}", 100.0 * value);
        vec![
            level.level.to_string(),
            found(&|r| r.frequency_hz.map(|f| format!("{f:.3}"))),
            found(&|r| if held { r.force } else { r.amplitude }.map(|a| format!("{a:.4e}"))),
            cell(level.peak.map(|p| p[1]), &|a| format!("{a:.4e}")),
            cell(level.peak.map(|p| p[0]), &|f| format!("{f:.3}")),
            cell(level.single_mode_error.map(|e| e[0]), &percent),
            cell(level.single_mode_error.map(|e| e[1]), &percent),
            level.frequency.len().to_string(),
            level.turning_points.len().to_string(),
        ]
    };
    Table {
        headings: headings.map(Into::into).into(),
        rows: levels.iter().map(row).collect(),
    }
}

/// Heading of the levels, with their unit.
fn level_heading(levels: &[ForcedSummary]) -> String {
    let base = levels.iter().find(|level| level.base.is_some());
    match (base, levels.iter().any(ForcedSummary::holds_response)) {
        (Some(level), _) => format!("supports [{}]", level.level_unit),
        (None, true) => "response [m]".into(),
        (None, false) => match levels.first() {
            Some(level) if level.is_unbalance() => format!("unbalance [{}]", level.level_unit),
            _ => "force [N]".into(),
        },
    }
}

/// A resonance as two cells: frequency and amplitude.
fn cells(resonance: Option<&PointSummary>) -> [String; 2] {
    let [f, a] = [
        resonance.and_then(|r| r.frequency_hz),
        resonance.and_then(|r| r.amplitude),
    ];
    [
        f.map_or_else(|| "-".into(), |f| format!("{f:.4}")),
        a.map_or_else(|| "-".into(), |a| format!("{a:.4e}")),
    ]
}

fn percent(value: f64) -> String {
    format!("{:+.2} %", 100.0 * value)
}

/// One line about a level, for the end of a run.
fn line(level: &ForcedSummary) -> String {
    let by = match level.base {
        Some(_) => "supports moving with",
        None if level.holds_response() => "response held at",
        None if level.is_unbalance() => "unbalance",
        None => "force",
    };
    let mut out = format!("{by} {} {}: ", level.level, level.level_unit);
    for resonance in &level.resonances {
        let [frequency, amplitude] = cells(Some(resonance));
        let force = resonance.force.filter(|_| level.holds_response());
        let force = force.map_or_else(String::new, |force| format!(", {force:.4e} N"));
        let _ = write!(out, "resonance {frequency} Hz, {amplitude} m{force}; ");
    }
    if let Some([frequency, amplitude]) = level.peak {
        let _ = write!(out, "peak {amplitude:.4e} m at {frequency:.4} Hz; ");
    }
    if let Some(error) = level.single_mode_error {
        let [frequency, amplitude] = error.map(percent);
        let _ = write!(
            out,
            "nonlinear mode alone {frequency} in frequency, {amplitude} in amplitude; "
        );
    }
    let _ = write!(out, "{}", points(level));
    out
}

/// Number of points, turning points, and why the curve ends early if it does.
fn points(level: &ForcedSummary) -> String {
    let turning = match level.turning_points.len() {
        0 => String::new(),
        n => format!(", {n} turning"),
    };
    let early = level.failure.iter().map(|reason| format!("  ENDS EARLY: {reason}"));
    let unfound = level.resonances.iter().filter_map(|r| r.failure.as_ref());
    let unfound = unfound.map(|reason| format!("  resonance not found: {reason}"));
    let failures: String = early.chain(unfound).collect();
    format!("{} points{turning}{failures}", level.frequency.len())
}

/// Tables, arrays and pictures, and the pictures for the page.
fn files(run: &Run, motions: &PeriodicMotions<'_>) -> Result<(Vec<Output>, Vec<Picture<'static>>), Error> {
    let mut outputs = vec![Output::new(PERIODIC, motions.archive()?)];
    let mut pictures = Vec::new();
    let mut add = |name: String, svg: String, caption: String, outputs: &mut Vec<Output>| {
        outputs.push(Output::new(name, svg.clone()));
        let svg = svg.into();
        pictures.push(Picture { svg, caption });
    };
    if !motions.forced.is_empty() {
        outputs.push(Output::new(FORCED, csv::forced(motions.forced)?));
        if let Some(swept) = sweep::in_time(motions.forced)? {
            outputs.push(Output::new(SWEEP, swept));
        }
        let title = format!("{}: forced responses", run.scene.name);
        if let Some(picture) = motions.response_picture(&title)? {
            let caption = format!(
                "Response to {}. Amplitude: {}.",
                match motions.forced.first() {
                    Some(level) if level.base.is_some() => "harmonic motion of the supports, against them",
                    Some(level) if level.holds_response() => "a harmonic force that holds it",
                    Some(level) if level.is_unbalance() => "a rotating unbalance",
                    _ => "a harmonic force",
                },
                plot::amplitude_label(motions.response)
            );
            add(FORCED_PICTURE.into(), picture, caption, &mut outputs);
        }
    }
    if !motions.epmc.is_empty() {
        outputs.push(Output::new(EPMC, csv::epmc(&motions.epmc)?));
    }
    for &(mode, points) in &motions.epmc {
        let further = (mode != run.first().mode).then_some(mode);
        let title = format!("{}: harmonics of mode {mode} by EPMC", run.scene.name);
        let picture = harmonics_picture(points, motions.response, &title)?;
        let caption =
            format!("Amplitudes of the harmonics of mode {mode} over that of the first, in the norm of the mass.");
        add(harmonics_file(further), picture, caption, &mut outputs);
    }
    let loops: Vec<_> = run
        .backbones
        .iter()
        .filter_map(|of| Some((of.mode, of.epmc.as_ref()?.loops.as_slice())))
        .filter(|(_, loops)| !loops.is_empty())
        .collect();
    if !loops.is_empty() {
        outputs.push(Output::new(
            LOOPS,
            csv::loops(&loops, fields::point_positions(run).as_deref())?,
        ));
    }
    for &(mode, of_mode) in &loops {
        let further = (mode != run.first().mode).then_some(mode);
        let title = format!("{}: loops of mode {mode} by EPMC", run.scene.name);
        let picture = loops_picture(of_mode, &title)?;
        let caption =
            "Tangential traction of single points against their jump, both from their means over a period; q is the \
                       modal amplitude in sqrt(kg) m."
                .to_owned();
        add(loops_file(further), picture, caption, &mut outputs);
    }
    Ok((outputs, pictures))
}
