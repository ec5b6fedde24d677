//! Joints of linear elements turned into joints of quadratic ones.

use finite_elements::mesh::{Assembly, Face};
use finite_elements::{Error, Quadratic};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use zte_assembly::{Element, InterfaceMesh};

/// Linear elements that were made quadratic after a mesh was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RaisedElements {
    /// Solid elements.
    pub elements: usize,
    /// Nodes added in the middles of their edges.
    pub added_nodes: usize,
}

/// Gives all solids of two bodies, and the elements of the interface between them, a node in the middle of each edge, as
/// [`Quadratic`] does.
///
/// `sides` are the nodes of the top and the bottom body at each node of the interface. Middles of its edges follow after its
/// corners, in the order of their ends. Rows 0 and 1 of `frame` are the axes of the plane. `position` says where the middle of an edge of a solid lies (m);
/// `None` stands for the mean of its ends. All solids get the default formulation of their new type.
///
/// # Errors
/// Those of [`Quadratic::try_new`]; [`Error::NotRaisable`] for an edge of the interface that is not an edge of both bodies. Nothing is changed
/// then.
pub fn raise(
    assembly: &mut Assembly,
    interface: &mut InterfaceMesh,
    sides: [&mut Vec<u32>; 2],
    frame: [[f64; 3]; 3],
    position: impl FnMut([u32; 2]) -> Option<[f64; 3]>,
) -> Result<RaisedElements, Error> {
    let raised = Quadratic::try_new(assembly, position)?;
    let [top_nodes, bottom_nodes] = sides;
    let mut number: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let (mut top, mut bottom, mut nodes) = (top_nodes.clone(), bottom_nodes.clone(), interface.nodes.clone());
    let all: BTreeSet<[u32; 2]> = interface.elements.iter().flat_map(edges).collect();
    for edge in all {
        let on = |side: &[u32]| raised.middle(edge.map(|node| side[node as usize]));
        let (Some(above), Some(below)) = (on(top_nodes), on(bottom_nodes)) else {
            let [a, b] = edge.map(|node| interface.nodes[node as usize]);
            return Err(Error::NotRaisable {
                place: format!("the edge of the interface from {a:?} m to {b:?} m"),
                reason: "it is no edge of both bodies; give both the same mesh there",
            });
        };
        let at = raised.assembly.mesh.nodes[above as usize];
        let along = |axis: [f64; 3]| axis.iter().zip(at).map(|(a, x)| a * x).sum::<f64>();
        number.insert(edge, nodes.len() as u32);
        nodes.push([along(frame[0]), along(frame[1])]);
        top.push(above);
        bottom.push(below);
    }
    let elements = interface.elements.iter().filter_map(|element| {
        let middles = edges(element).map(|edge| number[&edge]);
        let nodes: Vec<u32> = element.corners().iter().copied().chain(middles).collect();
        // Triangles and quadrilaterals both have a shape with these nodes.
        Element::from_nodes(&nodes)
    });
    *interface = InterfaceMesh::flat(nodes, elements.collect());
    (*top_nodes, *bottom_nodes) = (top, bottom);
    let found = RaisedElements {
        elements: assembly.mesh.elements.len(),
        added_nodes: raised.assembly.mesh.nodes.len() - assembly.mesh.nodes.len(),
    };
    *assembly = raised.assembly;
    Ok(found)
}

/// Gives all solids a node in the middle of each edge, as [`Quadratic`] does, and the faces of some surfaces with them.
///
/// # Errors
/// Those of [`Quadratic::try_new`]; [`Error::NotRaisable`] for a face with an edge that no solid has. Nothing is changed then.
pub fn raise_surfaces(assembly: &mut Assembly, surfaces: Vec<&mut Vec<Face>>) -> Result<RaisedElements, Error> {
    let raised = Quadratic::try_new(assembly, |_| None)?;
    let face = |face: &Face| {
        let corners = face.corners();
        let ends = (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]);
        let middles = ends.map(|ends| {
            raised.middle(ends).ok_or_else(|| Error::NotRaisable {
                place: format!(
                    "the edge of the interface between nodes {} and {} of the mesh",
                    ends[0], ends[1]
                ),
                reason: "it is no edge of a solid",
            })
        });
        let middles = middles.collect::<Result<Vec<u32>, Error>>()?;
        let nodes: Vec<u32> = corners.iter().copied().chain(middles).collect();
        // Triangles and quadrilaterals both have a face type with these nodes.
        Ok(Face::from_nodes(&nodes).unwrap_or(*face))
    };
    let faces = surfaces.iter().map(|faces| faces.iter().map(face).collect());
    let faces = faces.collect::<Result<Vec<Vec<Face>>, Error>>()?;
    for (surface, faces) in surfaces.into_iter().zip(faces) {
        *surface = faces;
    }
    let found = RaisedElements {
        elements: assembly.mesh.elements.len(),
        added_nodes: raised.assembly.mesh.nodes.len() - assembly.mesh.nodes.len(),
    };
    *assembly = raised.assembly;
    Ok(found)
}

/// The edges from each corner to the next, by their ends in increasing order.
fn edges(element: &Element) -> impl Iterator<Item = [u32; 2]> {
    let corners = element.corners();
    (0..corners.len()).map(|i| {
        let [a, b] = [corners[i], corners[(i + 1) % corners.len()]];
        [a.min(b), a.max(b)]
    })
}
