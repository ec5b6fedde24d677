//! Displacements and other fields of bodies as VTK files.

use finite_elements::formats::vtu::{self, Encoding, Field};
use finite_elements::mesh::{Face, Mesh};
use std::collections::BTreeMap;

/// Elements of a mesh beyond which VTK files hold its surface only.
pub const LARGEST_VOLUME: usize = 20_000;

/// Displacements of each node (m) as a field. ParaView shows it by the filter *Warp By Vector*.
pub fn displacement(name: String, of_nodes: &[[f64; 3]]) -> Field {
    Field {
        name,
        components: 3,
        values: of_nodes.concat(),
    }
}

/// The mean at each node of what its elements have.
pub fn mean_at_nodes(mesh: &Mesh, name: &str, of_elements: &[f64]) -> Field {
    let mut sums = vec![(0.0, 0.0); mesh.nodes.len()];
    for (element, value) in mesh.elements.iter().zip(of_elements) {
        for node in element.cell.nodes() {
            let (sum, count) = &mut sums[*node as usize];
            (*sum, *count) = (*sum + value, *count + 1.0);
        }
    }
    Field {
        name: name.into(),
        components: 1,
        values: sums.iter().map(|(sum, count)| sum / f64::max(*count, 1.0)).collect(),
    }
}

/// Fields of the nodes on the mesh, or on its `surface` if the mesh is large.
///
/// # Errors
/// A number that is not finite, or sizes that do not fit.
pub fn vtu(mesh: &Mesh, surface: &[Face], mut fields: Vec<Field>) -> Result<String, finite_elements::Error> {
    if mesh.elements.len() <= LARGEST_VOLUME {
        return vtu::write(mesh, &fields, &[], Encoding::Base64);
    }
    let mut place: BTreeMap<u32, u32> = surface
        .iter()
        .flat_map(|face| face.nodes())
        .map(|node| (*node, 0))
        .collect();
    place.values_mut().zip(0..).for_each(|(place, number)| *place = number);
    let nodes: Vec<[f64; 3]> = place.keys().map(|node| mesh.nodes[*node as usize]).collect();
    for field in &mut fields {
        let rows: Vec<&[f64]> = field.values.chunks(field.components).collect();
        field.values = place.keys().flat_map(|node| rows[*node as usize]).copied().collect();
    }
    let faces: Vec<Face> = surface
        .iter()
        .filter_map(|face| Face::from_nodes(&face.nodes().iter().map(|node| place[node]).collect::<Vec<_>>()))
        .collect();
    vtu::write_surface(&nodes, &faces, &fields, &[], Encoding::Base64)
}
