//! What a mesh holds, in words.

use joints::structure::survey::{Survey, Touching};
use std::fmt::Write;
use std::path::Path;

/// How many lines of a kind are shown.
const SHOWN: usize = 40;

/// The bodies of a file, where they touch, and holes that bolts may pass; lengths are in the unit of the file.
pub(super) fn text(file: &Path, survey: &Survey) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}: {} nodes, {} bodies (lengths are in the unit of the file)",
        file.display(),
        survey.n_nodes,
        survey.bodies.len()
    );
    list(&mut text, "bodies", &survey.bodies, |body| {
        let elements: Vec<String> = body
            .elements
            .iter()
            .map(|(kind, count)| format!("{count} {kind}"))
            .collect();
        format!(
            "`{}`: {}, from {} to {}",
            body.name,
            elements.join(", "),
            point(&body.low),
            point(&body.high)
        )
    });
    list(&mut text, "bodies that touch", &survey.touching, |touching| {
        about(survey, touching)
    });
    list(
        &mut text,
        "holes in a row that a bolt may pass",
        &survey.bolts,
        |bolt| {
            let mut bodies: Vec<&str> = bolt
                .holes
                .iter()
                .map(|&hole| name(survey, survey.holes[hole].body))
                .collect();
            bodies.dedup();
            let filled = bolt
                .filled_by
                .map_or_else(String::new, |body| format!(", filled by `{}`", name(survey, body)));
            format!(
                "diameter {}, from {} to {}, through {}{filled}",
                number(bolt.diameter),
                point(&bolt.axis[0]),
                point(&bolt.axis[1]),
                bodies.join(", ")
            )
        },
    );
    let in_rows: Vec<usize> = survey.bolts.iter().flat_map(|bolt| bolt.holes.clone()).collect();
    let others: Vec<_> = survey
        .holes
        .iter()
        .enumerate()
        .filter(|(hole, _)| !in_rows.contains(hole))
        .collect();
    list(&mut text, "other round holes", &others, |(_, hole)| {
        format!(
            "diameter {}, from {} to {}, in {}",
            number(hole.diameter),
            point(&hole.ends[0]),
            point(&hole.ends[1]),
            name(survey, hole.body)
        )
    });
    for (what, groups) in ["groups of solids", "surfaces", "groups of nodes"]
        .iter()
        .zip(&survey.groups)
    {
        if !groups.is_empty() {
            let more = if groups.len() > SHOWN { ", ..." } else { "" };
            let shown: Vec<String> = groups
                .iter()
                .take(SHOWN)
                .map(|(name, size)| format!("`{name}` ({size})"))
                .collect();
            let _ = writeln!(text, "{what}: {}{more}", shown.join(", "));
        }
    }
    survey.notes.iter().for_each(|note| {
        let _ = writeln!(text, "note: {note}");
    });
    text.push_str("`microslip new --from FILE --length UNIT DIRECTORY` makes a scene of these\n");
    text
}

fn list<T>(text: &mut String, what: &str, all: &[T], line: impl Fn(&T) -> String) {
    if all.is_empty() {
        text.push_str(&format!("{what}: none\n"));
        return;
    }
    text.push_str(&format!("{what}:\n"));
    for one in all.iter().take(SHOWN) {
        text.push_str(&format!("  {}\n", line(one)));
    }
    if all.len() > SHOWN {
        text.push_str(&format!("  and {} more\n", all.len() - SHOWN));
    }
}

/// What two bodies that touch have in common.
pub(super) fn about(survey: &Survey, touching: &Touching) -> String {
    let [top, bottom] = touching.bodies.map(|body| name(survey, body));
    let patches = match touching.patches {
        1 => String::new(),
        count => format!(" in {count} patches"),
    };
    format!(
        "`{top}` on `{bottom}`: {} and {} faces{patches}, area {}, mean normal {}",
        touching.faces[0],
        touching.faces[1],
        number(touching.area),
        point(&touching.normal)
    )
}

/// What scenes call a body.
pub(super) fn name(survey: &Survey, body: usize) -> &str {
    &survey.bodies[body].name
}

fn point(x: &[f64; 3]) -> String {
    format!("({})", x.map(number).join(", "))
}

/// Six digits, without those that say nothing.
pub(super) fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    // A zero has no sign.
    format!("{}", rounded + 0.0)
}
