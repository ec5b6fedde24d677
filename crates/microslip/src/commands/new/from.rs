//! A scene from a mesh or the mesh of an input deck: what can be seen in it is proposed, what cannot is asked for.

use super::super::destination::write_new;
use super::super::survey::{about, name, number};
use crate::text::print;
use anyhow::{Context, Result, bail};
use joints::structure::survey::{ProposedBolt, Survey, Touching};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

/// Units of length that a file may have.
pub(in crate::commands) const LENGTHS: [&str; 5] = ["m", "cm", "mm", "in", "ft"];

/// One of each in metres, and the other units of a consistent system.
const SYSTEMS: [(f64, [&str; 2]); 5] = [
    (1.0, ["mass", "kg"]),
    (0.01, ["force", "N"]),
    (1e-3, ["mass", "t"]),
    (0.0254, ["force", "lbf"]),
    (0.3048, ["force", "lbf"]),
];

/// Most notes about the file in a scene; `microslip model` shows all.
const NOTES: usize = 20;

/// Part of a normal along x from which on the first direction of an interface is y.
const FACING_X: f64 = 0.7;

/// Writes `scene.json` for the mesh in `file`.
pub(super) fn run(file: &Path, length: &str, directory: &Path) -> Result<()> {
    let Some(system) = LENGTHS.iter().position(|known| *known == length) else {
        bail!(
            "`{length}` is no unit of length here; give one of {}",
            LENGTHS.join(", ")
        );
    };
    let survey = Survey::of_file(file)?;
    std::fs::create_dir_all(directory).with_context(|| format!("making {}", directory.display()))?;
    let path = relative(file, directory)?;
    let scene = scene(&survey, &path, length, system)?;
    write_new(directory, &[("scene.json", scene.as_bytes())])?;
    print(&format!(
        "{} bodies, {} pairs of bodies that touch, {} bolts; the scene is {}\n\
         lines that begin with //? are what the file cannot tell: give your values there, and delete the mark\n",
        survey.bodies.len(),
        survey.touching.len(),
        survey.bolts.len(),
        directory.join("scene.json").display()
    ))
}

/// The way from a folder to a file.
fn relative(file: &Path, directory: &Path) -> Result<PathBuf> {
    let absolute = |path: &Path| {
        path.canonicalize()
            .with_context(|| format!("finding {}", path.display()))
    };
    let (file, directory) = (absolute(file)?, absolute(directory)?);
    let (to, from): (Vec<Component>, Vec<Component>) = (file.components().collect(), directory.components().collect());
    let common = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    // With nothing but the root in common an absolute path says more.
    if common <= 1 {
        return Ok(file);
    }
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - common);
    Ok(up.chain(to[common..].iter().copied()).collect())
}

fn scene(survey: &Survey, path: &Path, length: &str, system: usize) -> Result<String> {
    let (unit, [other, other_unit]) = SYSTEMS[system];
    let Some(path) = path.to_str() else {
        bail!("{} is not a name in UTF-8; rename it", path.display());
    };
    let units = format!(r#"{{ "length": "{length}", "{other}": "{other_unit}", "time": "s" }}"#);
    let mut text = format!(
        "// Made from a mesh. Lines that begin with // are comments.\n\
         // Those that begin with //? are what the mesh cannot tell: give your values there, and delete the mark.\n\
         {{\n  \"units\": {units},\n\n  \"structure\": {{ \"mesh\": {{\n    \"path\": {},\n\n",
        json!(path)
    );
    // Writing to a string cannot fail.
    for note in survey.notes.iter().take(NOTES) {
        let _ = writeln!(text, "    // {}", note.replace(['\n', '\r'], " "));
    }
    text.push_str("    // Where bodies touch: the upper one first.\n    \"interfaces\": [");
    let mut first = true;
    for touching in &survey.touching {
        if !touching.is_flat() {
            let _ = write!(
                text,
                "\n      // no interface, since its faces look in all directions: {}",
                about(survey, touching)
            );
            continue;
        }
        let comma = if first { "" } else { "," };
        first = false;
        let _ = write!(
            text,
            "{comma}\n      // {}\n      {}",
            about(survey, touching),
            interface(survey, touching)
        );
    }
    text.push_str(match survey.touching.is_empty() {
        true => "],\n    // No two bodies touch within a twentieth of an edge: name surfaces (`top`, `bottom`), or bodies `between` which a gap `within` is closed.\n\n",
        false => "\n    ],\n\n",
    });
    let has_bolts = (survey.bolts.iter()).any(|bolt| bolt.filled_by.is_none() && bolt.size(unit).is_some());
    text.push_str("    // Holes in a row that bolts may pass. `\"washers\": true` and `\"seat\": \"tied\"` are choices of yours.\n    ");
    text.push_str(match has_bolts {
        true => "\"bolts\": [",
        false => {
            "// No bolt was found; without one nothing presses the bodies together. A bolt has an axis and a size, or two surfaces.\n    \
             //? \"bolts\": [{ \"axis\": [[0, 0, 10], [0, 0, -10]], \"size\": \"M8\" }],\n    \
             // \"bolts\": [{ \"head\": \"NAME\", \"nut\": \"NAME\" }],"
        }
    });
    first = true;
    for bolt in &survey.bolts {
        match (bolt.filled_by, bolt.size(unit)) {
            (Some(body), _) => {
                let _ = write!(
                    text,
                    "\n      // `{}` is in the holes on {}: glue it to what it presses on by \"ties\", or leave it out of the mesh",
                    name(survey, body),
                    axis(bolt)
                );
            }
            (None, Some(size)) => {
                let comma = if first { "" } else { "," };
                first = false;
                let _ = write!(text, "{comma}\n      {}", json!({ "axis": axis(bolt), "size": size }));
            }
            (None, None) => {
                let _ = write!(
                    text,
                    "\n      // no size for a hole of {}, on {}",
                    number(bolt.diameter),
                    axis(bolt)
                );
            }
        }
    }
    text.push_str(if has_bolts { "\n    ],\n" } else { "\n" });
    text.push_str(
        "\n    // Nothing holds the structure unless you say so:\n    // \"supports\": [{ \"surface\": \"NAME\" }],\n\n    \
         // Amplitudes are measured where and along which the first mode moves most. A point of yours:\n    \
         // \"response\": { \"nearest\": [0, 0, 0], \"direction\": [0, 0, 1] }\n    \"response\": { \"mode\": 1 }\n  } },\n\n",
    );
    text.push_str(
        "  //? \"model\": { \"material\": { \"youngs_modulus\": \"200 GPa\", \"poisson_ratio\": 0.3, \"density\": \"7850 kg/m^3\" } },\n\n  \
         \"interfaces\": {\n    \
         // The surfaces: scans of both faces, a finish, parameters, or the measured surface of the Brake-Reuss beam in their place.\n    \
         // \"surface\": { \"scans\": [\"top.x3p\", \"bottom.x3p\"] },\n    \
         //? \"surface\": { \"benchmark\": \"brake-reuss-beam\" },\n    \
         // The friction coefficient.\n    //? \"mu\": 0.2,\n    \
         // The gap before the bolts are tightened: flat, or measured by the scans.\n    \"gap\": \"flat\"\n  },\n\n  \
         // The tension of each bolt.\n  //? \"bolts\": { \"load\": \"10 kN\" },\n\n  \
         \"analyses\": {\n    \"modes\": { \"followed\": [1] },\n    \
         \"backbone\": { \"amplitudes\": 8, \"amplitude_from\": \"0.1 um\", \"amplitude_to\": \"100 um\" }\n  }\n}\n",
    );
    Ok(text)
}

/// The interface of two bodies that touch.
pub(in crate::commands) fn interface(survey: &Survey, touching: &Touching) -> Value {
    let between = touching.bodies.map(|body| name(survey, body));
    match touching.normal[0].abs() < FACING_X {
        true => json!({ "name": between.join(" on "), "between": between }),
        // The first direction lies along x otherwise.
        false => json!({ "name": between.join(" on "), "between": between, "along": [0, 1, 0] }),
    }
}

/// Each unit of length that a file may have, with one of it in metres and the block `units` of a scene with it.
pub(in crate::commands) fn systems() -> impl Iterator<Item = (&'static str, f64, Value)> {
    let both = LENGTHS.iter().zip(SYSTEMS);
    both.map(|(length, (unit, [other, other_unit]))| {
        (
            *length,
            unit,
            json!({ "length": length, other: other_unit, "time": "s" }),
        )
    })
}

/// The axis of a bolt in the digits that are shown.
pub(in crate::commands) fn axis(bolt: &ProposedBolt) -> Value {
    json!(
        bolt.axis
            .map(|point| point.map(|x| number(x).parse::<f64>().unwrap_or(x)))
    )
}
