//! Displacements of bodies as VTK files.

use finite_elements::formats::vtu::{self, Encoding, Field};
use finite_elements::mesh::{Face, Mesh};
use std::collections::BTreeMap;

/// Elements of a mesh beyond which VTK files hold its surface only.
pub const LARGEST_VOLUME: usize = 20_000;

/// The displacement of each node on the mesh, or on its `surface` if the mesh is large. ParaView shows it by the filter *Warp By Vector*.
///
/// # Errors
/// A number that is not finite, or sizes that do not fit.
pub fn vtu(
    mesh: &Mesh,
    surface: &[Face],
    name: &str,
    displacement: &[[f64; 3]],
) -> Result<String, finite_elements::Error> {
    let field = |values| Field {
        name: name.into(),
        components: 3,
        values,
    };
    if mesh.elements.len() <= LARGEST_VOLUME {
        return vtu::write(mesh, &[field(displacement.concat())], &[], Encoding::Base64);
    }
    let mut place: BTreeMap<u32, u32> = surface
        .iter()
        .flat_map(|face| face.nodes())
        .map(|node| (*node, 0))
        .collect();
    place.values_mut().zip(0..).for_each(|(place, number)| *place = number);
    let nodes: Vec<[f64; 3]> = place.keys().map(|node| mesh.nodes[*node as usize]).collect();
    let values = place.keys().flat_map(|node| displacement[*node as usize]).collect();
    let faces: Vec<Face> = surface
        .iter()
        .filter_map(|face| Face::from_nodes(&face.nodes().iter().map(|node| place[node]).collect::<Vec<_>>()))
        .collect();
    vtu::write_surface(&nodes, &faces, &[field(values)], &[], Encoding::Base64)
}
