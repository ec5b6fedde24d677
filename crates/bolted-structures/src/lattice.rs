//! Bodies of hexahedra on a lattice.

use finite_elements::elements::{Cell, Formulation, HEX8};
use finite_elements::mesh::{Element, Face, Group, Material, Mesh};
use std::collections::BTreeMap;

/// Cells of a lattice that a body consists of.
pub(crate) struct Lattice<'a> {
    /// Cells along the three directions.
    pub(crate) cells: [usize; 3],
    /// Whether the second direction is closed: its last nodes are its first.
    pub(crate) is_closed: bool,
    /// Which cells there are.
    pub(crate) has: &'a dyn Fn([usize; 3]) -> bool,
    /// Position of a node (m); the three directions are right-handed.
    pub(crate) position: &'a dyn Fn([usize; 3]) -> [f64; 3],
}

/// A body in a mesh.
pub(crate) struct Body {
    cells: Vec<([usize; 3], [u32; 8])>,
}

impl Lattice<'_> {
    /// Adds the body of this name.
    pub(crate) fn add(&self, mesh: &mut Mesh, name: String) -> Body {
        let material = mesh.materials.len() as u16;
        mesh.materials.push(Material {
            name,
            youngs_modulus: 1.0,
            poisson_ratio: 0.0,
            density: 1.0,
        });
        let [nx, ny, nz] = self.cells;
        let mut known: BTreeMap<[usize; 3], u32> = BTreeMap::new();
        let mut cells = Vec::new();
        for i in 0..nx {
            for j in 0..ny {
                for k in (0..nz).filter(|&k| (self.has)([i, j, k])) {
                    let mut node = |a: usize, b: usize, c: usize| {
                        let j = if self.is_closed { (j + b) % ny } else { j + b };
                        let at = [i + a, j, k + c];
                        *known.entry(at).or_insert_with(|| {
                            mesh.nodes.push((self.position)(at));
                            mesh.nodes.len() as u32 - 1
                        })
                    };
                    let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
                    let [lower, upper] = [0, 1].map(|c| corners.map(|(a, b)| node(a, b, c)));
                    let nodes = std::array::from_fn(|n| if n < 4 { lower[n] } else { upper[n - 4] });
                    // There is one of eight nodes.
                    let cell = Cell::try_new(&HEX8, Formulation::IncompatibleModes, &nodes);
                    mesh.elements.extend(cell.map(|cell| Element { cell, material }));
                    cells.push(([i, j, k], nodes));
                }
            }
        }
        Body { cells }
    }
}

impl Body {
    /// The faces below (`above` is false) or above these cells, outward.
    pub(crate) fn faces(&self, name: String, above: bool, of: impl Fn([usize; 3]) -> bool) -> Group<Face> {
        let chosen = self.cells.iter().filter(|(cell, _)| of(*cell));
        let face = |nodes: &[u32; 8]| match above {
            true => Face::quad4([nodes[4], nodes[5], nodes[6], nodes[7]]),
            false => Face::quad4([nodes[3], nodes[2], nodes[1], nodes[0]]),
        };
        Group {
            name,
            members: chosen.map(|(_, nodes)| face(nodes)).collect(),
        }
    }
}
