//! Cells that no structure can be made of.

use crate::Error;
use crate::elements::{ELEMENT_TYPES, ElementType, JacobianCheck, Orientation};
use crate::mesh::Cell;
use rayon::prelude::*;

/// How many cells a message names.
const NAMED: usize = 5;

/// Refuses cells that use a node twice, that are listed twice, or that are inverted; returns those that are listed in mirrored
/// order.
pub(super) fn check(file: &str, nodes: &[[f64; 3]], cells: &[Cell], labels: &[u64]) -> Result<Vec<usize>, Error> {
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
    let orientations = orientations(nodes, cells);
    let all = |wanted: Orientation| -> Vec<usize> {
        let found = orientations.iter().enumerate().filter(|(_, found)| **found == wanted);
        found.map(|(number, _)| number).collect()
    };
    refuse(
        &all(Orientation::Inverted),
        "are inverted or flat: the Jacobian determinant is not positive at all integration points",
        "improve the mesh there (smaller elements, Mesh.HighOrderOptimize in Gmsh, or straight edges)",
    )?;
    Ok(all(Orientation::Mirrored))
}

/// Which way the nodes of each cell are listed.
fn orientations(nodes: &[[f64; 3]], cells: &[Cell]) -> Vec<Orientation> {
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
    cells.par_iter().map(orientation).collect()
}

/// The same cell with its nodes in the order of its mirror image.
pub(super) fn mirrored(cell: &Cell) -> Cell {
    let row = cell.element_type();
    let nodes = cell.nodes();
    // Every reference shape is its own image with the first two natural coordinates exchanged.
    let image = row.nodes.iter().enumerate().map(|(local, x)| {
        let is_image = |y: &[f64; 3]| *y == [x[1], x[0], x[2]];
        nodes[row.nodes.iter().position(is_image).unwrap_or(local)]
    });
    let mut mirrored = Cell::of_type(row, &image.collect::<Vec<u32>>());
    mirrored.set_formulation(cell.formulation());
    mirrored
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
