//! Displacements of bodies as VTK files.

use finite_elements::formats::vtu::{self, Encoding, Field};
use finite_elements::mesh::{Face, Mesh};
use std::collections::BTreeMap;

/// Elements of a mesh beyond which VTK files hold its surface only.
pub const LARGEST_VOLUME: usize = 20_000;

/// Displacements of each node, by name, on the mesh, or on its `surface` if the mesh is large. ParaView shows one by the filter *Warp By Vector*.
///
/// # Errors
/// A number that is not finite, or sizes that do not fit.
pub fn vtu(
    mesh: &Mesh,
    surface: &[Face],
    displacements: &[(String, &[[f64; 3]])],
) -> Result<String, finite_elements::Error> {
    let fields = |of_nodes: &dyn Fn(&[[f64; 3]]) -> Vec<f64>| -> Vec<Field> {
        let field = |(name, displacement): &(String, &[[f64; 3]])| Field {
            name: name.clone(),
            components: 3,
            values: of_nodes(displacement),
        };
        displacements.iter().map(field).collect()
    };
    if mesh.elements.len() <= LARGEST_VOLUME {
        let all = fields(&|displacement| displacement.concat());
        return vtu::write(mesh, &all, &[], Encoding::Base64);
    }
    let mut place: BTreeMap<u32, u32> = surface
        .iter()
        .flat_map(|face| face.nodes())
        .map(|node| (*node, 0))
        .collect();
    place.values_mut().zip(0..).for_each(|(place, number)| *place = number);
    let nodes: Vec<[f64; 3]> = place.keys().map(|node| mesh.nodes[*node as usize]).collect();
    let shown = fields(&|displacement| place.keys().flat_map(|node| displacement[*node as usize]).collect());
    let faces: Vec<Face> = surface
        .iter()
        .filter_map(|face| Face::from_nodes(&face.nodes().iter().map(|node| place[node]).collect::<Vec<_>>()))
        .collect();
    vtu::write_surface(&nodes, &faces, &shown, &[], Encoding::Base64)
}
