//! Joints as elements of one degree of freedom in other programs: tables of stiffness and loss factor against amplitude for Nastran and Abaqus, and
//! fitted Iwan and Bouc-Wen elements.

use crate::Error;
use analyses::equivalent::{BoucWen, Fit, Iwan, Level, Quality, bouc_wen, iwan};
use analyses::results::summary::{BackboneSummary, Status, Summary};
use analyses::{Connection, ConnectionLoop};
use serde::Serialize;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Coherence below which a connection moves so little in common that an element of one degree of freedom misses most of it.
const INCOHERENT: f64 = 0.5;

/// Levels of a coordinate of a mode that was followed.
pub struct Coordinate {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Its linearised frequency (Hz).
    pub frequency_hz: f64,
    /// The connection; none of the modal coordinate.
    pub connection: Option<Connection>,
    /// Levels, ascending.
    pub levels: Vec<Level>,
    /// What the connection did at these, in the same order; empty of the modal coordinate.
    loops: Vec<ConnectionLoop>,
    /// Amplitude at the response point at these (m); empty of the modal coordinate.
    response: Vec<f64>,
}

impl Coordinate {
    /// Its name.
    pub fn name(&self) -> &str {
        self.connection
            .as_ref()
            .map_or("modal coordinate", |connection| &connection.name)
    }

    /// What the connection did at the largest amplitude.
    fn last(&self) -> Option<&ConnectionLoop> {
        self.loops.last()
    }

    /// What is to be known before it is used; nothing of most.
    pub fn remark(&self) -> Option<String> {
        let coherence = self.last()?.coherence;
        (coherence < INCOHERENT).then(|| {
            format!(
                "mode {}, {}: only {:.0} % of the motion is common to the connection, which turns or stretches: an element along one direction misses the rest",
                self.mode,
                self.name(),
                100.0 * coherence
            )
        })
    }
}

/// The modal coordinate of each mode that was followed, and its connections that move.
pub fn coordinates(summary: &Summary) -> Vec<Coordinate> {
    let first = summary.first_mode();
    let mut all = Vec::new();
    for (further, of) in summary.by_mode() {
        let mode = further.unwrap_or(first);
        let Some(frequency_hz) = summary.modes.get(mode - 1).map(|mode| mode.frequency_hz) else {
            continue;
        };
        let told: Vec<(&BackboneSummary, f64)> = of
            .backbone
            .iter()
            .filter(|point| [Status::Resolved, Status::BelowFloor].contains(&point.status))
            .filter_map(|point| Some((point, point.response_displacement?)))
            .collect();
        let dissipation = |point: &BackboneSummary, found: Option<f64>| {
            found.filter(|joules| point.status == Status::Resolved && *joules > 0.0)
        };
        let level = |(point, _): &(&BackboneSummary, f64)| {
            Some(Level {
                amplitude: point.modal_amplitude?,
                stiffness: (TAU * point.frequency_hz?).powi(2),
                dissipation: dissipation(point, point.loop_area),
            })
        };
        all.push(Coordinate {
            mode,
            frequency_hz,
            connection: None,
            levels: told.iter().filter_map(level).collect(),
            loops: Vec::new(),
            response: Vec::new(),
        });
        for (place, connection) in summary.connections.iter().enumerate() {
            let mut found = Coordinate {
                mode,
                frequency_hz,
                connection: Some(connection.clone()),
                levels: Vec::new(),
                loops: Vec::new(),
                response: Vec::new(),
            };
            for (point, response) in &told {
                let Some(moved) = point
                    .connections
                    .get(place)
                    .filter(|of| of.displacement > 0.0 && of.force > 0.0)
                else {
                    continue;
                };
                found.levels.push(Level {
                    amplitude: moved.displacement,
                    stiffness: moved.force / moved.displacement,
                    dissipation: dissipation(point, Some(moved.dissipation)),
                });
                found.loops.push(*moved);
                found.response.push(*response);
            }
            if !found.levels.is_empty() {
                all.push(found);
            }
        }
    }
    all
}

/// An element with what it stands for.
#[derive(Serialize)]
struct Fitted<'a, E> {
    mode: usize,
    coordinate: &'a str,
    units: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coherence: Option<f64>,
    #[serde(flatten)]
    fit: Option<Fit<E>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<String>,
}

/// A family of elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// The four-parameter element of Segalman.
    Iwan,
    /// That of Bouc and Wen.
    BoucWen,
}

/// A fitted file, and a line about each element.
pub struct Fits {
    /// JSON.
    pub json: String,
    /// Lines for the terminal.
    pub lines: Vec<String>,
}

/// The elements of a family nearest to the coordinates of a run.
///
/// # Errors
/// [`Error::Summary`].
pub fn fitted(run: &str, coordinates: &[Coordinate], family: Family) -> Result<Fits, Error> {
    match family {
        Family::Iwan => {
            let about = "Segalman (2005), DOI 10.1115/1.1989354: slip_force F_S, stiffness K_T, chi, beta; spring: stiffness of a linear spring in parallel, which is not part of K_T";
            of_family(run, coordinates, "iwan", about, iwan, |element: &Iwan| {
                format!(
                    "F_S {:.4e}, K_T {:.6e}, chi {:.3}, beta {:.3}, spring {:.6e}",
                    element.slip_force, element.stiffness, element.chi, element.beta, element.spring
                )
            })
        }
        Family::BoucWen => {
            let about = "F = alpha k u + (1 - alpha) k z; dz/du = 1 - |z/z_y|^n where z du > 0, else 1: stiffness k, alpha, yield_displacement z_y, n";
            of_family(run, coordinates, "bouc-wen", about, bouc_wen, |element: &BoucWen| {
                format!(
                    "k {:.6e}, alpha {:.3}, z_y {:.4e}, n {:.3}",
                    element.stiffness, element.alpha, element.yield_displacement, element.n
                )
            })
        }
    }
}

fn of_family<E: Serialize>(
    run: &str,
    coordinates: &[Coordinate],
    name: &str,
    about: &str,
    fit: impl Fn(&[Level]) -> Result<Fit<E>, analyses::Error>,
    words: impl Fn(&E) -> String,
) -> Result<Fits, Error> {
    let mut lines = Vec::new();
    let mut elements = Vec::new();
    for of in coordinates {
        let (fit, failure) = match fit(&of.levels) {
            Ok(fit) => (Some(fit), None),
            Err(error) => (None, Some(error.to_string())),
        };
        let what = format!("mode {}, {}", of.mode, of.name());
        lines.push(match (&fit, &failure) {
            (Some(fit), _) => format!(
                "{what}: {}; largest error of stiffness {:.2} %, of dissipation {:.1} %: {}{}",
                words(&fit.element),
                100.0 * fit.stiffness.largest,
                100.0 * fit.dissipation.largest,
                match fit.quality {
                    Quality::Good => "good",
                    Quality::Poor => "poor, do not use it",
                },
                if fit.slips_wholly {
                    ""
                } else {
                    "; the amplitudes do not reach whole slip, whose force is no prediction"
                }
            ),
            (None, reason) => format!("{what}: no element: {}", reason.as_deref().unwrap_or_default()),
        });
        lines.extend(of.remark());
        let units = match of.connection {
            None => {
                json!({ "displacement": "sqrt(kg) m", "stiffness": "rad^2/s^2", "force": "sqrt(kg) m/s^2", "dissipation": "J" })
            }
            Some(_) => json!({ "displacement": "m", "stiffness": "N/m", "force": "N", "dissipation": "J" }),
        };
        let element = Fitted {
            mode: of.mode,
            coordinate: of.name(),
            units,
            position: of.connection.as_ref().map(|connection| connection.position),
            direction: of.last().map(|last| last.direction),
            coherence: of.last().map(|last| last.coherence),
            fit,
            failure,
        };
        elements.push(serde_json::to_value(element).map_err(Error::Summary)?);
    }
    let document = json!({ "schema_version": 1, "run": run, "family": name, "about": about, "elements": elements });
    let json = serde_json::to_string_pretty(&document).map_err(Error::Summary)? + "\n";
    Ok(Fits { json, lines })
}

/// What tables of connections say of themselves, after the sign of a comment.
fn about(run: &str, comment: &str) -> String {
    format!(
        "{comment} Connections of the run {run}, by microslip. Units: m, N, kg, s.\n\
         {comment} A connection is the interface nearest to a bolt. Its stiffness is half the range of the tangential force over that of the mean\n\
         {comment} tangential motion of the top body against the bottom one along the first axis; its loss factor D/(pi K u^2) dissipates per\n\
         {comment} cycle what the interface there does. Take the level of the amplitude that is expected; other directions are not known here.\n"
    )
}

/// First number of the properties of a connection, by its place among the coordinates.
fn first_number(place: usize) -> usize {
    1000 * (place + 1)
}

/// The connections among the coordinates with their places.
fn connections(coordinates: &[Coordinate]) -> impl Iterator<Item = (usize, &Coordinate, &Connection, &ConnectionLoop)> {
    let found = coordinates
        .iter()
        .filter_map(|of| Some((of, of.connection.as_ref()?, of.last()?)));
    found
        .enumerate()
        .map(|(place, (of, connection, last))| (place, of, connection, last))
}

/// A level in words.
fn words(of: &Coordinate, level: usize) -> String {
    let at = &of.levels[level];
    let joules = at
        .dissipation
        .map_or_else(|| "below its floor".into(), |joules| format!("{joules:.4e} J"));
    format!(
        "motion {:.4e} m, force {:.4e} N, dissipation {joules}; response point {:.4e} m",
        at.amplitude,
        at.amplitude * at.stiffness,
        of.response[level]
    )
}

/// A card of Nastran in large fields.
fn card(out: &mut String, name: &str, fields: &[String]) {
    for (line, of) in fields.chunks(4).enumerate() {
        let name = if line == 0 { format!("{name}*") } else { "*".into() };
        let cells: String = of.iter().map(|field| format!("{field:>16}")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}", format!("{name:<8}{cells}").trim_end());
    }
}

fn real(value: f64) -> String {
    format!("{value:.8E}")
}

/// Properties of bushes for Nastran: for each connection a coordinate system, a PBUSH per level with stiffness and structural damping, and one PBUSH
/// with a PBUSHT of the force against the motion.
pub fn nastran(run: &str, coordinates: &[Coordinate]) -> String {
    let mut out = about(run, "$");
    for (place, of, connection, last) in connections(coordinates) {
        let (first, origin, normal) = (first_number(place), connection.position, connection.frame[2]);
        let toward = |direction: [f64; 3]| [0, 1, 2].map(|c| real(origin[c] + direction[c]));
        let _ = writeln!(
            out,
            "$\n$ Mode {} ({:.3} Hz), {}: coordinate system {first}, x along the motion, z along the normal.\n\
             $ CBUSH,EID,{},GA,GB,,,,{first}",
            of.mode,
            of.frequency_hz,
            connection.name,
            first + 1
        );
        out.extend(of.remark().map(|remark| format!("$ {remark}.\n")));
        let mut system = vec![first.to_string(), "0".into()];
        system.extend(
            origin
                .map(real)
                .into_iter()
                .chain(toward(normal))
                .chain(toward(last.direction)),
        );
        card(&mut out, "CORD2R", &system);
        let property = |number: usize, level: &Level| {
            let mut fields = vec![String::new(); 16];
            fields[0] = number.to_string();
            (fields[1], fields[2]) = ("K".into(), real(level.stiffness));
            (fields[9], fields[10]) = ("GE".into(), real(level.loss_factor().unwrap_or(0.0)));
            fields.truncate(11);
            fields
        };
        for (number, level) in of.levels.iter().enumerate() {
            let _ = writeln!(out, "$ {}", words(of, number));
            card(&mut out, "PBUSH", &property(first + 1 + number, level));
        }
        let nonlinear = first + 999;
        let _ = writeln!(out, "$ The force against the motion, for nonlinear solutions.");
        card(&mut out, "PBUSH", &property(nonlinear, &of.levels[0]));
        card(
            &mut out,
            "PBUSHT",
            &[nonlinear.to_string(), "KN".into(), nonlinear.to_string()],
        );
        let mut table = vec![nonlinear.to_string()];
        table.resize(8, String::new());
        let points = of
            .levels
            .iter()
            .map(|level| [level.amplitude, level.amplitude * level.stiffness]);
        let points: Vec<[f64; 2]> = points.collect();
        let negative = points.iter().rev().map(|point| point.map(|value| -value));
        let all = negative.chain([[0.0; 2]]).chain(points.iter().copied());
        table.extend(all.flatten().map(real));
        table.push("ENDT".into());
        card(&mut out, "TABLED1", &table);
    }
    out
}

/// Behaviours of connectors for Abaqus, one per connection and level: elasticity and structural damping along the first local axis.
pub fn abaqus(run: &str, coordinates: &[Coordinate]) -> String {
    let mut out = about(run, "**");
    for (place, of, connection, last) in connections(coordinates) {
        let vector = |v: [f64; 3]| v.map(real).join(", ");
        let [x, normal] = [last.direction, connection.frame[2]];
        // The second direction of an orientation only spans the plane of the first two axes.
        let across = [0, 1, 2].map(|c| {
            let (next, after) = ((c + 1) % 3, (c + 2) % 3);
            normal[next] * x[after] - normal[after] * x[next]
        });
        let _ = writeln!(
            out,
            "**\n** Mode {} ({:.3} Hz), {}, at {}\n*ORIENTATION, NAME=MICROSLIP-{}\n{}, {}",
            of.mode,
            of.frequency_hz,
            connection.name,
            vector(connection.position),
            place + 1,
            vector(x),
            vector(across)
        );
        out.extend(of.remark().map(|remark| format!("** {remark}.\n")));
        for (number, level) in of.levels.iter().enumerate() {
            let _ = writeln!(
                out,
                "** {}\n*CONNECTOR BEHAVIOR, NAME=MICROSLIP-{}-LEVEL-{}\n*CONNECTOR ELASTICITY, COMPONENT=1\n{}\n\
                 *CONNECTOR DAMPING, COMPONENT=1, TYPE=STRUCTURAL\n{}",
                words(of, number),
                place + 1,
                number + 1,
                real(level.stiffness),
                real(level.loss_factor().unwrap_or(0.0))
            );
        }
    }
    out
}
