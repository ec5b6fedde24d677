//! Cells that no structure can be made of.

use crate::Error;
use crate::elements::{ELEMENT_TYPES, ElementType, JacobianCheck, Orientation};
use crate::mesh::Cell;
use rayon::prelude::*;

/// How many cells a message names.
const NAMED: usize = 5;

/// Refuses cells that use a node twice, that are listed twice, or that are inverted.
pub(super) fn check(file: &str, nodes: &[[f64; 3]], cells: &[Cell], labels: &[u64]) -> Result<(), Error> {
    let refuse = |found: &[usize], problem: &'static str, remedy: &'static str| match found {
        [] => Ok(()),
        _ => Err(Error::MeshCells {
            file: file.to_owned(),
            cells: named(found, labels),
            problem,
            remedy,
        }),
    };
    let with = |is: &(dyn Fn(&Cell) -> bool + Sync)| -> Vec<usize> {
        let found = cells.par_iter().enumerate().filter(|(_, cell)| is(cell));
        found.map(|(number, _)| number).collect()
    };
    refuse(
        &with(&|cell| has_repeated_node(cell.nodes())),
        "use a node twice",
        "mesh collapsed hexahedra as wedges or tetrahedra",
    )?;
    refuse(
        &repeated(cells),
        "have the same corners as another solid",
        "the part is meshed or saved twice: delete one of the two",
    )?;
    let checks: Vec<(&ElementType, JacobianCheck)> = ELEMENT_TYPES
        .into_iter()
        .map(|row| (row, JacobianCheck::new(row)))
        .collect();
    let orientation = |cell: &Cell| {
        let mut x = [[0.0; 3]; 27];
        for (x, node) in x.iter_mut().zip(cell.nodes()) {
            *x = nodes[*node as usize];
        }
        let check = checks.iter().find(|(row, _)| *row == cell.element_type());
        check.map_or(Orientation::Right, |(_, check)| {
            check.orientation(&x[..cell.nodes().len()])
        })
    };
    let orientations: Vec<Orientation> = cells.par_iter().map(orientation).collect();
    let all = |wanted: Orientation| -> Vec<usize> {
        let found = orientations.iter().enumerate().filter(|(_, found)| **found == wanted);
        found.map(|(number, _)| number).collect()
    };
    refuse(
        &all(Orientation::Mirrored),
        "have a negative volume: their nodes are listed in mirrored order",
        "mirror the nodes of each cell, or save the mesh by the program that made it",
    )?;
    refuse(
        &all(Orientation::Inverted),
        "are inverted or flat: the Jacobian determinant is not positive at all integration points",
        "improve the mesh there (smaller elements, Mesh.HighOrderOptimize in Gmsh, or straight edges)",
    )
}

/// `1, 2, 3 and 7 more`.
fn named(found: &[usize], labels: &[u64]) -> String {
    let first: Vec<String> = found.iter().take(NAMED).map(|&cell| labels[cell].to_string()).collect();
    match found.len() {
        1..=NAMED => first.join(", "),
        count => format!("{} and {} more", first.join(", "), count - NAMED),
    }
}

fn has_repeated_node(nodes: &[u32]) -> bool {
    (1..nodes.len()).any(|i| nodes[..i].contains(&nodes[i]))
}

/// All but the first of the cells with the same corners.
fn repeated(cells: &[Cell]) -> Vec<usize> {
    let corners = |(number, cell): (usize, &Cell)| {
        let count = cell.nodes().len() - cell.element_type().middles.len();
        let mut corners = [u32::MAX; 8];
        corners[..count].copy_from_slice(&cell.nodes()[..count]);
        corners.sort_unstable();
        (corners, number as u32)
    };
    let mut all: Vec<([u32; 8], u32)> = cells.par_iter().enumerate().map(corners).collect();
    all.par_sort_unstable();
    let pairs = all.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    let mut repeated: Vec<usize> = pairs.map(|pair| pair[1].1 as usize).collect();
    repeated.sort_unstable();
    repeated
}
