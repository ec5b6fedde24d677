//! A reduced model as named arrays, for other programs.

use crate::joint::Joint;
use crate::model::StructuralModel;
use faer::MatRef;
use matrix_files::Error;
use matrix_files::value::{Array, Dense, Dof};
use std::collections::BTreeMap;
use zte_assembly::Element;

/// What the arrays are; goes with them where the format has room for text.
pub const ABOUT: &str = "\
Reduced model of two bodies joined by an interface; SI units.
M, K: mass and stiffness without contact. Fv: a column per bolt, the generalised force of unit tension.
R: response = R x, a row per response.
dofs: a row per coordinate. Label k > 0, component 1, 2, 3: displacement of the top body less that of the bottom one at
interface node k along the rows of `frame`, the third being the normal from the top body into the bottom one, so that
a positive value closes the interface. Label -m: coordinate m of the modes with the interface stuck.
interface_nodes: coordinates in the plane. interface_elements: node numbers from 1, counter-clockwise; 0 in the fourth place of
a triangle.
";

/// The arrays `M`, `K`, `Fv`, `R`, `dofs`, `frame`, `interface_nodes`, `interface_elements` and `about`.
///
/// # Errors
/// None for models made by this crate.
pub fn arrays(model: &StructuralModel, joint: &Joint) -> Result<BTreeMap<String, Array>, Error> {
    let reduced = &model.reduced;
    let n = reduced.mass.nrows();
    let dofs: Vec<Dof> = (0..n)
        .map(|i| match i.checked_sub(reduced.n_relative) {
            None => Dof::new(i as i64 / 3 + 1, i as u32 % 3 + 1),
            Some(mode) => Dof::new(-(mode as i64 + 1), 1),
        })
        .collect();
    let loads = reduced.loads.concat();
    let plane = &joint.interface;
    let corners: Vec<i64> = plane
        .elements
        .iter()
        .flat_map(|element| match element {
            Element::Quad4(nodes) => nodes.map(|n| i64::from(n) + 1),
            Element::Tri3([a, b, c]) => [i64::from(*a) + 1, i64::from(*b) + 1, i64::from(*c) + 1, 0],
        })
        .collect();
    Ok([
        ("M", dense(reduced.mass.as_ref())?),
        ("K", dense(reduced.stiffness.as_ref())?),
        ("Fv", Array::Dense(Dense::try_new(n, reduced.loads.len(), loads)?)),
        ("R", dense(reduced.recovery.as_ref())?),
        ("dofs", Dof::table(&dofs)),
        ("frame", Array::Dense(Dense::try_from_rows(3, 3, joint.frame.concat())?)),
        (
            "interface_nodes",
            Array::Dense(Dense::try_from_rows(plane.nodes.len(), 2, plane.nodes.concat())?),
        ),
        (
            "interface_elements",
            Array::Integers(Dense::try_from_rows(plane.elements.len(), 4, corners)?),
        ),
        ("about", Array::Text(ABOUT.into())),
    ]
    .map(|(name, array)| (name.to_owned(), array))
    .into())
}

fn dense(matrix: MatRef<'_, f64>) -> Result<Array, Error> {
    let columns = matrix
        .col_iter()
        .flat_map(|column| column.iter().copied().collect::<Vec<f64>>());
    Ok(Array::Dense(Dense::try_new(
        matrix.nrows(),
        matrix.ncols(),
        columns.collect(),
    )?))
}
