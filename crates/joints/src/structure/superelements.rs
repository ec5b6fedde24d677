//! Bodies of a mesh that come as matrices of another program.

use super::matrix_contents::File;
use crate::Error;
use finite_elements::mesh::Superelement;
use matrix_files::value::Dof;
use scenes::MeshSuperelement;
use std::collections::HashMap;

/// Reads one; `nodes` are those of the mesh by their labels, in which it must have some.
///
/// # Errors
/// Of the file; [`Error::Matrices`] for what is missing in it, and for labels that the mesh does not have.
pub(super) fn read(
    source: &MeshSuperelement,
    nodes: &HashMap<u64, u32>,
    notes: &mut dyn FnMut(&str),
) -> Result<Superelement, Error> {
    let file = File { path: &source.path };
    let mut contents = file.contents(notes)?;
    if contents.lift.is_some() {
        return Err(file.fail("L is read of whole structures only; give K, M and dofs over the same coordinates"));
    }
    if contents.damping.is_some() {
        return Err(file.fail(
            "its damping C is not taken of a body of a mesh; leave it out, and give damping of the whole as background_damping",
        ));
    }
    let missing = |what: &str| file.fail(&format!("it has no {what}"));
    let stiffness = contents.stiffness.take().ok_or_else(|| missing("stiffness K"))?;
    let mass = contents.mass.take().ok_or_else(|| missing("mass M"))?;
    let (stiffness, mass) = (
        file.symmetric(stiffness, "stiffness K")?,
        file.symmetric(mass, "mass M")?,
    );
    file.check_sizes(&contents, stiffness.rows(), mass.rows(), None)?;
    // Over displacements, and other coordinates of the dimension of length, matrices carry the unit of mass alone.
    let unit = source.units.mass_in_si();
    let coordinates = contents.dofs.iter().map(|dof| {
        let Dof::Nodal {
            node,
            component: component @ 1..=3,
        } = *dof
        else {
            return None;
        };
        let label = node.checked_add_signed(source.label_offset)?;
        Some((*nodes.get(&label)?, component as u8 - 1))
    });
    let found = Superelement {
        name: source.path.display().to_string(),
        coordinates: coordinates.collect(),
        stiffness: stiffness.map(|value| value * unit),
        mass: mass.map(|value| value * unit),
        is_held: source.held,
    };
    let of_nodes = |dof: &&Dof| matches!(dof, Dof::Nodal { component: 1..=3, .. });
    let (named, inner) = (contents.dofs.iter().filter(of_nodes).count(), found.n_inner());
    let joined = found.coordinates.len() - inner;
    if joined == 0 {
        return Err(file.fail(&format!(
            "none of the {named} displacements in its map of degrees of freedom belongs to a node of the mesh: give the nodes that it is joined by the \
             labels that they have in the mesh, or say by `label_offset` how these differ"
        )));
    }
    notes(&format!(
        "{}: joined by {joined} displacements of {} nodes of the mesh; {} of its displacements are no nodes of the mesh and move inside of it, with {} other \
         coordinates",
        found.name,
        found.nodes().len(),
        named - joined,
        found.coordinates.len() - named
    ));
    Ok(found)
}
