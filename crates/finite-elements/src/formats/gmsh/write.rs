//! Gmsh files as text.

use crate::Error;
use crate::formats::common::{check, check_nodes};
use crate::mesh::{Face, Group, Mesh};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Writes a mesh as text: one volume per material, one surface per list of faces, one point per list of nodes, all with
/// a physical group of the same name. Nodes and solids have the tags `number + 1`. What [`super::read`] makes of the result,
/// given the same materials, is the same mesh to the last bit, except for nodes without solids and for the
/// formulation of hexahedra, which the format cannot carry.
///
/// # Errors
/// [`Error::Dangling`] and [`Error::NotFinite`] for broken meshes and lists; [`Error::MeshUnwritable`] for names that
/// appear twice or that quotes cannot hold.
pub fn write(mesh: &Mesh, faces: &[Group<Face>], nodes: &[Group<u32>]) -> Result<String, Error> {
    check(mesh)?;
    for group in faces {
        let place = format!("list of faces `{}`", group.name);
        for face in &group.members {
            check_nodes(&place, face.nodes(), mesh.nodes.len())?;
        }
    }
    for group in nodes {
        check_nodes(
            &format!("list of nodes `{}`", group.name),
            &group.members,
            mesh.nodes.len(),
        )?;
    }
    // Writing to a string cannot fail.
    let mut out = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
    physical_names(&mut out, mesh, faces, nodes)?;
    entities(&mut out, mesh, faces, nodes);
    node_section(&mut out, mesh);
    element_section(&mut out, mesh, faces, nodes);
    Ok(out)
}

/// Element type of a point.
const POINT: u8 = 15;

fn physical_names(out: &mut String, mesh: &Mesh, faces: &[Group<Face>], nodes: &[Group<u32>]) -> Result<(), Error> {
    let names: [Vec<&str>; 4] = [
        nodes.iter().map(|group| group.name.as_str()).collect(),
        Vec::new(),
        faces.iter().map(|group| group.name.as_str()).collect(),
        mesh.materials.iter().map(|material| material.name.as_str()).collect(),
    ];
    let _ = writeln!(out, "$PhysicalNames\n{}", names.iter().map(Vec::len).sum::<usize>());
    for (dimension, names) in names.iter().enumerate() {
        let mut before = BTreeSet::new();
        for (number, name) in names.iter().enumerate() {
            let reason = if !before.insert(name) {
                "another has the same name; names must differ"
            } else if name.contains(|c: char| c == '"' || c.is_control()) || name.trim() != *name {
                "names must be free of double quotes, control characters and outer blanks"
            } else {
                let _ = writeln!(out, "{dimension} {} \"{name}\"", number + 1);
                continue;
            };
            return Err(Error::MeshUnwritable {
                what: format!("physical group {name:?} of dimension {dimension}"),
                reason: reason.into(),
            });
        }
    }
    *out += "$EndPhysicalNames\n";
    Ok(())
}

fn entities(out: &mut String, mesh: &Mesh, faces: &[Group<Face>], nodes: &[Group<u32>]) {
    let counts = [nodes.len(), 0, faces.len(), mesh.materials.len()].map(|n| n.to_string());
    let _ = writeln!(out, "$Entities\n{}", counts.join(" "));
    for (number, group) in (1..).zip(nodes) {
        let [x, y, z] = group
            .members
            .first()
            .map_or([0.0; 3], |node| mesh.nodes[*node as usize]);
        let _ = writeln!(out, "{number} {x:e} {y:e} {z:e} 1 {number}");
    }
    for (number, group) in (1..).zip(faces) {
        let nodes = group.members.iter().flat_map(|face| face.nodes());
        bounded_entity(out, number, nodes.map(|node| &mesh.nodes[*node as usize]));
    }
    for number in 0..mesh.materials.len() {
        let elements = mesh.elements.iter().filter(|e| usize::from(e.material) == number);
        let nodes = elements.flat_map(|e| e.cell.nodes());
        bounded_entity(out, number + 1, nodes.map(|node| &mesh.nodes[*node as usize]));
    }
    *out += "$EndEntities\n";
}

fn node_section(out: &mut String, mesh: &Mesh) {
    *out += "$Nodes\n";
    let n = mesh.nodes.len();
    if n == 0 {
        *out += "0 0 0 0\n";
    } else {
        let _ = writeln!(out, "1 {n} 1 {n}\n3 1 0 {n}");
    }
    for tag in 1..=n {
        let _ = writeln!(out, "{tag}");
    }
    for [x, y, z] in &mesh.nodes {
        let _ = writeln!(out, "{x:e} {y:e} {z:e}");
    }
    *out += "$EndNodes\n";
}

/// An element as it is written.
struct Written {
    dimension: i32,
    entity: usize,
    gmsh: u8,
    nodes: Vec<u32>,
}

impl Written {
    /// Elements of one kind share a block.
    fn block(&self) -> (i32, usize, u8) {
        (self.dimension, self.entity, self.gmsh)
    }
}

fn element_section(out: &mut String, mesh: &Mesh, faces: &[Group<Face>], nodes: &[Group<u32>]) {
    let solids = mesh.elements.iter().map(|element| {
        let row = &element.cell.element_type().gmsh;
        Written {
            dimension: 3,
            entity: usize::from(element.material) + 1,
            gmsh: row.number,
            nodes: row.to_file(element.cell.nodes()),
        }
    });
    let faces = (1..).zip(faces).flat_map(|(entity, group)| {
        group.members.iter().map(move |face| Written {
            dimension: 2,
            entity,
            gmsh: face.face_type().gmsh,
            nodes: face.nodes().to_vec(),
        })
    });
    let points = (1..).zip(nodes).flat_map(|(entity, group)| {
        group.members.iter().map(move |node| Written {
            dimension: 0,
            entity,
            gmsh: POINT,
            nodes: vec![*node],
        })
    });
    let elements: Vec<Written> = solids.chain(faces).chain(points).collect();
    // Runs of elements of one kind: the order of the elements is kept.
    let blocks: Vec<&[Written]> = elements.chunk_by(|a, b| a.block() == b.block()).collect();
    let n = elements.len();
    let _ = writeln!(out, "$Elements\n{} {n} {} {n}", blocks.len(), n.min(1));
    let mut tag = 0;
    for block in blocks {
        let (dimension, entity, gmsh) = block[0].block();
        let _ = writeln!(out, "{dimension} {entity} {gmsh} {}", block.len());
        for element in block {
            tag += 1;
            let _ = write!(out, "{tag}");
            for node in &element.nodes {
                let _ = write!(out, " {}", u64::from(*node) + 1);
            }
            out.push('\n');
        }
    }
    *out += "$EndElements\n";
}

/// An entity with a box round its nodes, one physical tag and no boundary.
fn bounded_entity<'a>(out: &mut String, number: usize, nodes: impl Iterator<Item = &'a [f64; 3]>) {
    let empty = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (low, high) = nodes.fold(empty, |(low, high), x| {
        let corner = |f: fn(f64, f64) -> f64, a: [f64; 3]| std::array::from_fn(|i| f(a[i], x[i]));
        (corner(f64::min, low), corner(f64::max, high))
    });
    let _ = write!(out, "{number}");
    for x in low.into_iter().chain(high) {
        let _ = write!(out, " {:e}", if x.is_finite() { x } else { 0.0 });
    }
    let _ = writeln!(out, " 1 {number} 0");
}
