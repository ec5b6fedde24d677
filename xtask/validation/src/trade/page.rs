//! What was measured as a table and a picture.

use super::front::{Front, Placed};
use super::ladder::{Errors, Ladder, Measured, Part, total};
use super::parameters::{AMPLITUDES, Source};
use plotters::prelude::*;
use reports::csv::table;
use reports::plot::{Band, Canvas, Curve, Marks, bounds, log, panel, picture, power, ticks, widen};
use reports::styles::COLOURS;
use reports::{Drawing, Error};
use std::fmt::Write;

const SIZE: (u32, u32) = (900, 900);

/// Parameters that are drawn, with the colours of Okabe and Ito, which the colour-blind can tell apart.
const DRAWN: [(&str, RGBColor); 8] = [
    ("mesh", RGBColor(0, 0, 0)),
    ("points", RGBColor(230, 159, 0)),
    ("modes", RGBColor(86, 180, 233)),
    ("vertices", RGBColor(0, 158, 115)),
    ("tolerance", RGBColor(240, 228, 66)),
    ("law", RGBColor(0, 114, 178)),
    ("arms", RGBColor(213, 94, 0)),
    ("accuracy", RGBColor(204, 121, 167)),
];

/// All settings as rows.
pub(crate) fn csv(ladders: &[Ladder]) -> Result<String, Error> {
    let mut headings: Vec<String> = [
        "dial",
        "setting",
        "seconds",
        "interface_seconds",
        "peak_memory_bytes",
        "linear_frequency_error",
    ]
    .map(Into::into)
    .into();
    for what in ["frequency_shift_error", "damping_ln_error"] {
        headings.extend(AMPLITUDES.map(|amplitude| format!("{what}_at_{amplitude:e}_m")));
    }
    headings.extend(["not_converged", "pareto", "failure"].map(Into::into));
    let cell = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.6e}"));
    let rows = ladders.iter().flat_map(|ladder| {
        let settings = ladder.parameter.settings.iter().zip(&ladder.outcomes);
        settings.map(move |(setting, outcome)| {
            let measured = outcome.measured.as_ref();
            let of = |value: fn(&Measured) -> f64| cell(measured.ok().map(value));
            let memory = measured.ok().and_then(|m| m.peak_memory);
            let mut row = vec![
                ladder.parameter.name.to_owned(),
                setting.name.clone(),
                of(Measured::seconds),
                of(|m| m.interface_seconds),
                memory.map_or_else(String::new, |bytes| bytes.to_string()),
                cell(outcome.errors.map(|e| e.linear)),
            ];
            let errors = outcome.errors;
            row.extend((0..AMPLITUDES.len()).map(|index| cell(errors.and_then(|e| e.shift[index]))));
            row.extend((0..AMPLITUDES.len()).map(|index| cell(errors.and_then(|e| e.damping[index]))));
            row.push(measured.map_or_else(|_| String::new(), |m| m.not_converged.to_string()));
            row.push(outcome.pareto.to_string());
            row.push(measured.err().cloned().unwrap_or_default());
            row
        })
    });
    table(headings, rows)
}

/// The same for readers, times and errors to two digits.
pub(crate) fn markdown(ladders: &[Ladder], budget: &[Part]) -> String {
    let [low, middle, high] = AMPLITUDES.map(|a| format!("{:.0}", 1e6 * a));
    let mut out = format!(
        "| dial | setting | time [s] | of it the interface [s] | memory [GB] | f1 | shift at {low}, {middle}, {high} um | \
         ln(damping) at {low}, {middle}, {high} um |\n|---|---|---|---|---|---|---|---|\n"
    );
    let number = |value: f64| match value {
        0.0 => "0".to_owned(),
        value => format!("{value:+.1e}"),
    };
    let three = |values: [Option<f64>; 3]| values.map(|v| v.map_or_else(|| "-".into(), number)).join(", ");
    for ladder in ladders {
        let last = ladder.parameter.settings.len().saturating_sub(1);
        for (index, (setting, outcome)) in ladder.parameter.settings.iter().zip(&ladder.outcomes).enumerate() {
            let measured = match &outcome.measured {
                Ok(measured) => measured,
                Err(reason) => {
                    let _ = writeln!(
                        out,
                        "| {} | {} | failed: {reason} | | | | | |",
                        ladder.parameter.name, setting.name
                    );
                    continue;
                }
            };
            let memory = measured
                .peak_memory
                .map_or_else(|| "-".into(), |bytes| format!("{:.2}", bytes as f64 / 1e9));
            let _ = write!(
                out,
                "| {} | {}{} | {:.1} | {:.1} | {memory} ",
                ladder.parameter.name,
                setting.name,
                match measured.not_converged {
                    0 => String::new(),
                    count => format!(" ({count} not converged)"),
                },
                measured.seconds(),
                measured.interface_seconds
            );
            let _ = match outcome.errors {
                _ if index == last && setting.source == Source::Loops => writeln!(out, "| reference | | |"),
                Some(e) => writeln!(
                    out,
                    "| {} | {} | {} |",
                    number(e.linear),
                    three(e.shift),
                    three(e.damping)
                ),
                None => writeln!(out, "| - | - | - |"),
            };
        }
    }
    out.push_str("\nDials: ");
    let parameters = ladders
        .iter()
        .map(|l| format!("`{}`, {}", l.parameter.name, l.parameter.what));
    out.push_str(&parameters.collect::<Vec<_>>().join("; "));
    out.push_str(".\n");
    for ladder in ladders {
        for limit in &ladder.limits {
            let _ = match (&limit.extrapolation, limit.uncertainty) {
                (Some(e), Some(uncertainty)) => writeln!(
                    out,
                    "\n{}: {} converges with order {:.1} to {:.5}; the finest is {uncertainty:.1e} from it.",
                    ladder.parameter.name, limit.quantity, e.order, e.limit
                ),
                (None, Some(_)) => writeln!(
                    out,
                    "\n{}: {} does not depend on it.",
                    ladder.parameter.name, limit.quantity
                ),
                _ => writeln!(
                    out,
                    "\n{}: {} does not approach a limit monotonically.",
                    ladder.parameter.name, limit.quantity
                ),
            };
        }
    }
    out.push_str("\n| part of the budget | kind | frequency | ln(damping) |\n|---|---|---|---|\n");
    for part in budget {
        let (frequency, damping) = (part.frequency, part.damping_ln);
        let _ = writeln!(
            out,
            "| {} | {} | {frequency:.1e} | {damping:.1e} |",
            part.parameter,
            part.kind.name()
        );
    }
    let [frequency, damping] = total(budget);
    let _ = writeln!(
        out,
        "| errors together (root of the sum of squares) | | {frequency:.1e} | {damping:.1e} |"
    );
    out
}

/// Error against time, both logarithmic: of frequencies above, of damping below.
pub(crate) fn pareto(ladders: &[Ladder]) -> Result<String, Error> {
    picture("errors against times", SIZE, |root| draw(ladders, root))
}

fn draw(ladders: &[Ladder], root: &Canvas<'_>) -> Result<(), Drawing> {
    let curves = |is_damping: bool| -> Vec<Curve> {
        let curve = |&(name, colour): &(&str, RGBColor)| {
            let ladder = ladders.iter().find(|ladder| ladder.parameter.name == name)?;
            let points = ladder.outcomes.iter().enumerate().filter_map(|(index, outcome)| {
                let error = drawn(&outcome.errors?, is_damping)?;
                Some((index, outcome.measured.as_ref().ok()?.seconds(), error))
            });
            Some(Curve {
                name: name.into(),
                colour,
                dashes: None,
                marks: Marks::Dots,
                points: points.collect(),
            })
        };
        DRAWN.iter().filter_map(curve).collect()
    };
    let title = "What errors cost: each parameter against its finest setting, all others as in the scene";
    planes(root, title, curves, None)
}

/// The error that is drawn; a run that is the reference itself has none.
fn drawn(errors: &Errors, is_damping: bool) -> Option<f64> {
    let error = match is_damping {
        true => errors.damping(),
        false => Some(errors.frequency()),
    };
    error.filter(|error| *error > 0.0)
}

/// Errors of frequency above and of damping below, against seconds. `curves` is told whether they are of damping; `band` is a range of errors of frequency.
fn planes(
    root: &Canvas<'_>,
    title: &str,
    curves: impl Fn(bool) -> Vec<Curve>,
    band: Option<[f64; 2]>,
) -> Result<(), Drawing> {
    let root = root.titled(title, ("sans-serif", 18))?;
    let (upper, lower) = root.split_vertically(SIZE.1 / 2 - 30);
    for (area, y_label, x_label, is_damping) in [
        (&upper, "largest relative error of frequency", "", false),
        (
            &lower,
            "largest error of ln(damping ratio)",
            "seconds from nothing",
            true,
        ),
    ] {
        let curves = curves(is_damping);
        let band = band.filter(|_| !is_damping);
        let all = || curves.iter().flat_map(|curve| &curve.points);
        let ends = band.into_iter().flatten();
        let x = widen(&bounds(all().map(|p| p.1)).unwrap_or(1.0..10.0), 1.5);
        let y = widen(&bounds(all().map(|p| p.2).chain(ends)).unwrap_or(1e-6..1.0), 2.0);
        let bands = band.map(|[low, high]| Band {
            colour: OTHERS,
            points: [x.start, x.end].map(|x| (x, low, high)).into(),
        });
        let (x_ticks, y_ticks) = (ticks(&x), ticks(&y));
        let plain = |value: &f64| format!("{value}");
        panel(
            area,
            log(&x, &x_ticks),
            log(&y, &y_ticks),
            y_label,
            x_label,
            [&plain, &power],
            &curves,
            bands.as_slice(),
            SeriesLabelPosition::UpperRight,
        )?;
    }
    Ok(())
}

/// What settings that others beat are drawn in.
const OTHERS: RGBColor = RGBColor(150, 150, 150);

/// All settings of the scene `name` on one plane, with those on the Pareto front named.
pub(crate) fn front(front: &Front, name: &str) -> Result<String, Error> {
    let mut title = format!("{name}: settings against all fine");
    if front.physics.is_some() {
        title += "; band: physics against the measured beam";
    }
    let curves = |is_damping| on_front(front, is_damping);
    picture("all settings on one plane", SIZE, |root| {
        planes(root, &title, curves, front.physics)
    })
}

/// All settings, the line of the front, and each setting on it with its name.
fn on_front(front: &Front, is_damping: bool) -> Vec<Curve> {
    let place = |placed: &Placed| Some((placed.seconds, drawn(&placed.errors, is_damping)?));
    let curve = |name: String, colour, dashes, marks, points: &mut dyn Iterator<Item = &Placed>| Curve {
        name,
        colour,
        dashes,
        marks,
        points: (0..)
            .zip(points.filter_map(place))
            .map(|(i, (x, y))| (i, x, y))
            .collect(),
    };
    let best = front.best(|errors| drawn(errors, is_damping));
    let mut curves = vec![
        curve(String::new(), OTHERS, None, Marks::Bounds, &mut front.settings.iter()),
        curve(
            "Pareto front".into(),
            OTHERS,
            Some((4, 4)),
            Marks::None,
            &mut best.iter().copied(),
        ),
    ];
    curves.extend(best.iter().zip(COLOURS.iter().cycle()).map(|(placed, colour)| {
        let name = format!("{:.1} s, {}", placed.seconds, placed.name);
        curve(name, *colour, None, Marks::Triangles, &mut std::iter::once(*placed))
    }));
    curves
}
