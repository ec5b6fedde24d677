//! What was measured as a table and a picture.

use super::front::{Front, Placed};
use super::ladder::{Errors, Ladder, Measured, Part, total};
use super::parameters::{AMPLITUDES, Source};
use plotters::prelude::*;
use reports::csv::table;
use reports::plot::{Band, Canvas, Curve, Marks, bounds, log, panel, picture, power, ticks, widen};
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

fn seconds(measured: &Measured) -> f64 {
    measured.structure_seconds + measured.interface_seconds
}

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
                of(seconds),
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
                seconds(measured),
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
    let root = root.titled(
        "What errors cost: each parameter against its finest setting, all others as in the scene",
        ("sans-serif", 18),
    )?;
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
        let curves: Vec<Curve> = DRAWN
            .iter()
            .filter_map(|&(name, colour)| {
                let ladder = ladders.iter().find(|ladder| ladder.parameter.name == name)?;
                let points = ladder.outcomes.iter().enumerate().filter_map(|(index, outcome)| {
                    let errors = outcome.errors?;
                    let error = if is_damping {
                        errors.damping()?
                    } else {
                        errors.frequency()
                    };
                    let measured = outcome.measured.as_ref().ok()?;
                    // The reference itself has no error to draw.
                    (error > 0.0).then(|| (index, seconds(measured), error))
                });
                Some(Curve {
                    name: name.into(),
                    colour,
                    dashes: None,
                    marks: Marks::Dots,
                    points: points.collect(),
                })
            })
            .collect();
        let all = || curves.iter().flat_map(|curve| &curve.points);
        let x = widen(&bounds(all().map(|p| p.1)).unwrap_or(1.0..10.0), 1.5);
        let y = widen(&bounds(all().map(|p| p.2)).unwrap_or(1e-6..1.0), 2.0);
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
            &[],
            SeriesLabelPosition::LowerLeft,
        )?;
    }
    Ok(())
}

/// All settings of the scene `name` on one plane, with those on the Pareto front named.
pub(crate) fn front(front: &Front, name: &str) -> Result<String, Error> {
    picture("all settings on one plane", SIZE, |root| draw_front(front, name, root))
}

/// What settings that nothing beats are drawn in.
const BEST: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

fn draw_front(front: &Front, name: &str, root: &Canvas<'_>) -> Result<(), Drawing> {
    let title = match front.physics {
        Some(_) => format!("{name}: settings against all fine; band: physics against the measured beam"),
        None => format!("{name}: settings against all fine"),
    };
    let root = root.titled(&title, ("sans-serif", 18))?;
    let (upper, lower) = root.split_vertically(SIZE.1 / 2 - 30);
    let frequency: fn(&Errors) -> Option<f64> = |errors| Some(errors.frequency()).filter(|error| *error > 0.0);
    let damping: fn(&Errors) -> Option<f64> = |errors| errors.damping().filter(|error| *error > 0.0);
    for (area, y_label, x_label, error, physics) in [
        (
            &upper,
            "largest relative error of frequency",
            "",
            frequency,
            front.physics,
        ),
        (
            &lower,
            "largest error of ln(damping ratio)",
            "seconds from nothing",
            damping,
            None,
        ),
    ] {
        let place = |placed: &Placed| Some((placed.seconds, error(&placed.errors)?));
        let all: Vec<(f64, f64)> = front.settings.iter().filter_map(place).collect();
        let best = front.best(error);
        let curve = |name: String, colour, dashes, marks, points: Vec<(f64, f64)>| Curve {
            name,
            colour,
            dashes,
            marks,
            points: points.into_iter().enumerate().map(|(i, (x, y))| (i, x, y)).collect(),
        };
        let grey = RGBColor(150, 150, 150);
        let line = best.iter().filter_map(|placed| place(placed)).collect();
        let mut curves = vec![
            curve(String::new(), grey, None, Marks::Bounds, all.clone()),
            curve("Pareto front".into(), grey, Some((4, 4)), Marks::None, line),
        ];
        curves.extend(best.iter().enumerate().map(|(i, placed)| {
            let name = format!("{:.1} s, {}", placed.seconds, placed.name);
            let point = place(placed).into_iter().collect();
            curve(name, BEST[i % BEST.len()], None, Marks::Triangles, point)
        }));
        let ends = physics.into_iter().flatten().filter(|end| *end > 0.0);
        let x = widen(&bounds(all.iter().map(|p| p.0)).unwrap_or(1.0..10.0), 1.5);
        let y = widen(&bounds(all.iter().map(|p| p.1).chain(ends)).unwrap_or(1e-6..1.0), 2.0);
        let band = physics.map(|[low, high]| Band {
            colour: grey,
            points: vec![(x.start, low.max(y.start), high), (x.end, low.max(y.start), high)],
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
            band.as_slice(),
            SeriesLabelPosition::LowerLeft,
        )?;
    }
    Ok(())
}
