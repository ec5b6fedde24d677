//! What the readers of mesh files share.

use crate::Error;
use crate::error::Position;
use crate::mesh::Mesh;

/// The nodes that solids use, numbered anew in their old order.
pub(crate) struct Kept {
    /// Old numbers.
    pub(crate) old: Vec<u32>,
    new: Vec<Option<u32>>,
}

impl Kept {
    /// Of `count` nodes those in `used`, all of them below `count`.
    pub(crate) fn new(count: usize, used: impl Iterator<Item = u32>) -> Self {
        let mut new = vec![None; count];
        for node in used {
            new[node as usize] = Some(0);
        }
        let mut old = Vec::new();
        for (node, number) in (0_u32..).zip(&mut new) {
            if number.is_some() {
                *number = Some(old.len() as u32);
                old.push(node);
            }
        }
        Self { old, new }
    }

    /// New number of a node, if it is kept.
    pub(crate) fn number(&self, node: u32) -> Option<u32> {
        self.new.get(node as usize).copied().flatten()
    }
}

/// The line that byte `at` stands in.
pub(crate) fn line(bytes: &[u8], at: usize) -> Position {
    let before = &bytes[..at.min(bytes.len())];
    Position::Line(1 + before.iter().filter(|byte| **byte == b'\n').count())
}

/// Where `needle` begins in `bytes`, at or after `from`.
pub(crate) fn find(bytes: &[u8], from: usize, needle: &[u8]) -> Option<usize> {
    let tail = bytes.get(from..)?;
    tail.windows(needle.len())
        .position(|window| window == needle)
        .map(|i| from + i)
}

/// Text for a message: quoted, and not too long.
pub(crate) fn quoted(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    if text.is_empty() {
        return "nothing".into();
    }
    let more = if text.len() > LONGEST { "..." } else { "" };
    let shown = String::from_utf8_lossy(&text[..text.len().min(LONGEST)]);
    format!("`{}{more}`", visible(shown.chars()))
}

/// Text in which control characters are escaped, so that a terminal shows them and does not obey.
pub(crate) fn visible(text: impl Iterator<Item = char>) -> String {
    let mut shown = String::new();
    for c in text {
        match c.is_control() {
            true => shown.extend(c.escape_debug()),
            false => shown.push(c),
        }
    }
    shown
}

/// Checks what a mesh refers to, and that its coordinates are numbers, before it is written.
pub(crate) fn check(mesh: &Mesh) -> Result<(), Error> {
    check_positions(&mesh.nodes)?;
    for (number, element) in mesh.elements.iter().enumerate() {
        let place = format!("element {number}");
        check_nodes(&place, element.cell.nodes(), mesh.nodes.len())?;
        if usize::from(element.material) >= mesh.materials.len() {
            return Err(Error::Dangling {
                place,
                what: "material",
                index: element.material.into(),
                count: mesh.materials.len(),
            });
        }
    }
    Ok(())
}

/// Checks that all nodes are below `count`.
pub(crate) fn check_nodes(place: &str, nodes: &[u32], count: usize) -> Result<(), Error> {
    match nodes.iter().find(|node| **node as usize >= count) {
        Some(&node) => Err(Error::Dangling {
            place: place.into(),
            what: "node",
            index: node as usize,
            count,
        }),
        None => Ok(()),
    }
}

/// Checks that coordinates are numbers.
pub(crate) fn check_positions(nodes: &[[f64; 3]]) -> Result<(), Error> {
    for (number, node) in nodes.iter().enumerate() {
        if let Some(&value) = node.iter().find(|x| !x.is_finite()) {
            let place = format!("coordinates of node {number}");
            return Err(Error::NotFinite { place, value });
        }
    }
    Ok(())
}
