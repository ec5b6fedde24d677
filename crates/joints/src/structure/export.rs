//! Models for other programs: reduced ones as named arrays, meshes as input decks and mesh files.

use super::StructuralModel;
use super::matrix_contents::{from_dense, short_name};
use dense_algebra::product;
use faer::{Mat, MatRef};
use finite_elements::formats::abaqus::Includes;
use finite_elements::mesh::{Dof as Component, Face, Group};
use joint_model::{Joint, MeshedBodies, Sides};
use matrix_files::Error;
use matrix_files::dmig::PointMatrices;
use matrix_files::value::{Array, Dense, Dof};
use scenes::{Length, Units};
use std::collections::BTreeMap;
use std::path::Path;
use zte_assembly::shape::QUAD4;

/// What the arrays are; goes with them where the format has room for text.
pub const ABOUT: &str = "\
Reduced model of two bodies joined by an interface; SI units.
M, K: mass and stiffness without contact; C, where there is one: viscous damping. Fv: a column per bolt, the generalised force of unit tension.
R: response = R x, a row per response.
dofs: a row per coordinate. Label k > 0, component 1, 2, 3: displacement of the top body less that of the bottom one at
interface node k along the rows of `frame`, the third being the normal from the top body into the bottom one, so that
a positive value closes the interface. Label -m: coordinate m of the modes with the interface stuck.
interface_nodes: coordinates in the plane. interface_elements: node numbers from 1, the corners counter-clockwise, then the
middles of the edges from each corner to the next, then the centre; 0 in places that an element does not have. Points of
contact have neither.
";

/// The arrays `M`, `K`, `C` where there are dampers, `Fv` where there are bolts, `R`, `dofs`, `frame`, `interface_nodes`, `interface_elements` and `about`. Points of
/// contact have no mesh: point `k` of a scene becomes node `k`, and coordinates that it lacks are left out again.
///
/// # Errors
/// None for models made by this crate.
pub fn arrays(model: &StructuralModel, joint: &Joint) -> Result<BTreeMap<String, Array>, Error> {
    let reduced = &model.reduced;
    let held = joint.interface.held();
    let kept: Vec<usize> = (0..reduced.size()).filter(|i| held.binary_search(i).is_err()).collect();
    let n = kept.len();
    let dofs: Vec<Dof> = kept
        .iter()
        .map(|&i| match i.checked_sub(reduced.n_relative) {
            None => Dof::new(i as i64 / 3 + 1, i as u32 % 3 + 1),
            Some(mode) => Dof::new(-(mode as i64 + 1), 1),
        })
        .collect();
    let loads = reduced
        .loads
        .iter()
        .flat_map(|load| kept.iter().map(|&i| load[i]))
        .collect();
    let square = |matrix: Mat<f64>| dense(Mat::from_fn(n, n, |i, j| matrix[(kept[i], kept[j])]).as_ref());
    let rows = |from: usize, to: usize| Mat::from_fn(to - from, n, |i, j| reduced.recovery[(from + i, kept[j])]);
    let first_damper = model.first_damper();
    let (recovery, dampers) = (rows(0, first_damper), rows(first_damper, reduced.recovery.nrows()));
    let plane = &joint.interface;
    let places = plane.elements.iter().map(|element| element.nodes().len());
    let places = places.max().unwrap_or(0).max(QUAD4.n_nodes);
    let nodes: Vec<i64> = plane
        .elements
        .iter()
        .flat_map(|element| (0..places).map(|i| element.nodes().get(i).map_or(0, |n| i64::from(*n) + 1)))
        .collect();
    let mut arrays: BTreeMap<String, Array> = [
        ("M", square(reduced.mass.as_ref().to_dense())?),
        ("K", square(reduced.stiffness.as_ref().to_dense())?),
        ("Fv", Array::Dense(Dense::try_new(n, reduced.loads.len(), loads)?)),
        ("R", dense(recovery.as_ref())?),
        ("dofs", Dof::table(&dofs)),
        ("frame", Array::Dense(Dense::try_from_rows(3, 3, joint.frame.concat())?)),
        (
            "interface_nodes",
            Array::Dense(Dense::try_from_rows(plane.nodes.len(), 2, plane.nodes.concat())?),
        ),
        (
            "interface_elements",
            Array::Integers(Dense::try_from_rows(plane.elements.len(), places, nodes)?),
        ),
        ("about", Array::Text(ABOUT.into())),
    ]
    .map(|(name, array)| (name.to_owned(), array))
    .into();
    if plane.is_of_points() {
        arrays.retain(|name, _| !name.starts_with("interface_"));
    }
    if reduced.loads.is_empty() {
        arrays.remove("Fv");
    }
    if dampers.nrows() > 0 {
        let damping = product(dampers.transpose(), dampers.as_ref());
        arrays.insert("C".to_owned(), dense(damping.as_ref())?);
    }
    Ok(arrays)
}

/// What the matrices of [`point_matrices`] are.
pub const ABOUT_POINTS: &str = "\
Reduced model of two bodies joined by an interface; SI units.
K, M: stiffness and mass without contact; B: viscous damping. FV: a column per bolt, the
generalised force of unit tension. R: a column per response, which is
the product of it with the coordinates.
Grid point k, component 1, 2, 3: displacement of the top body less that
of the bottom one at interface node k, the third being the normal from
the top body into the bottom one, so that a positive value closes the
interface. Scalar points, which follow the grid points: modes with the
interface stuck.
The points must be defined by the model that includes this file.
";

/// Arrays as files of Nastran's `OUTPUT4` hold them: without text, with names in capitals, `INTNODES` and `INTELEMS`.
pub fn with_short_names(arrays: BTreeMap<String, Array>) -> BTreeMap<String, Array> {
    let numbers = arrays.into_iter().filter(|(_, array)| !matches!(array, Array::Text(_)));
    numbers.map(|(name, array)| (short_name(&name), array)).collect()
}

/// What entries `DMIG` can hold of the [`arrays`]: `K`, `M`, `B` for `C`, `FV` and the transpose of `R`. Mode `m` becomes the scalar
/// point `m` after the last node.
pub fn point_matrices(arrays: &BTreeMap<String, Array>) -> PointMatrices {
    let matrix = |name: &str| match arrays.get(name) {
        Some(Array::Dense(matrix)) => Some(from_dense(matrix)),
        _ => None,
    };
    let dofs = match arrays.get("dofs") {
        Some(Array::Integers(table)) => Dof::from_table(table).unwrap_or_default(),
        _ => Vec::new(),
    };
    let last = dofs.iter().map(Dof::label).max().unwrap_or(0).max(0);
    let point = |dof: &Dof| match *dof {
        Dof::Generalised { label, .. } => Dof::new(last - label, 0),
        nodal @ Dof::Nodal { .. } => nodal,
    };
    let named = |name: &str, matrix: Option<_>| matrix.map(|matrix| (name.to_owned(), matrix));
    let recovery = matrix("R").map(|rows| rows.transpose_view().to_csr());
    PointMatrices {
        dofs: dofs.iter().map(point).collect(),
        matrices: [("K", "K"), ("M", "M"), ("B", "C")]
            .iter()
            .filter_map(|(short, name)| named(short, matrix(name)))
            .collect(),
        numbered: [named("FV", matrix("Fv")), named("R", recovery)]
            .into_iter()
            .flatten()
            .collect(),
        skipped: Vec::new(),
    }
}

/// Name of the top side of the interface in mesh files, and of the bottom side.
const SIDES: [&str; 2] = ["INTERFACE TOP", "INTERFACE BOTTOM"];

/// Name of the set of the response node.
const RESPONSE: &str = "RESPONSE";

/// The two sides of the interface as faces of the mesh, and the response node.
pub fn groups(joint: &Joint, bodies: &MeshedBodies) -> ([Group<Face>; 2], [Group<u32>; 1]) {
    let side = |name: &str, nodes: &[u32]| Group {
        name: name.to_owned(),
        members: joint
            .interface
            .elements
            .iter()
            .filter_map(|element| {
                let of_face: Vec<u32> = element.nodes().iter().map(|&n| nodes[n as usize]).collect();
                Face::from_nodes(&of_face)
            })
            .collect(),
    };
    let response = Group {
        name: RESPONSE.to_owned(),
        members: vec![bodies.response_node],
    };
    let sides = match &bodies.sides {
        Sides::Pairs { top, bottom } => [side(SIDES[0], top), side(SIDES[1], bottom)],
        Sides::Projected(parts) => [true, false].map(|top| Group {
            name: SIDES[usize::from(!top)].to_owned(),
            members: parts
                .iter()
                .flat_map(|part| {
                    if part.own_is_top == top {
                        &part.own_faces
                    } else {
                        &part.other_faces
                    }
                })
                .copied()
                .collect(),
        }),
    };
    (sides, [response])
}

/// What a scene says of the input deck at `path` that [`finite_elements::formats::abaqus::write`] makes of the bodies and their
/// [`groups`]: the structure is the same. Its `materials` are those that the bodies have, which the deck holds, or the scene's.
pub fn deck(joint: &Joint, bodies: &MeshedBodies, path: &Path, materials: scenes::MaterialSource) -> scenes::Deck {
    let normal = joint.frame[2];
    let n_nodes = bodies.assembly.mesh.nodes.len() as u64;
    // References are numbered after the nodes. The end that tension pulls along the normal is that of the top body.
    let end = |terms: &[(Component, f64)], sign: f64| {
        let pulled = |term: &&(Component, f64)| match term {
            (Component::Reference(_, c), value) if *c < 3 => sign * value * normal[usize::from(*c)] > 0.0,
            _ => false,
        };
        match terms.iter().find(pulled) {
            Some((Component::Reference(reference, _), _)) => (n_nodes + u64::from(*reference) + 1).to_string(),
            _ => String::new(),
        }
    };
    scenes::Deck {
        path: path.to_owned(),
        includes: Includes::BelowTheDeck,
        units: Units::SI,
        top_surface: SIDES[0].to_owned(),
        bottom_surface: SIDES[1].to_owned(),
        pair_tolerance: None,
        along: joint.frame[0],
        bolts: bodies
            .assembly
            .loads
            .iter()
            .map(|load| scenes::DeckBolt::References {
                top: end(&load.terms, 1.0),
                bottom: end(&load.terms, -1.0),
            })
            .collect(),
        response: scenes::DeckResponse {
            node: RESPONSE.to_owned(),
            direction: bodies.response_direction,
        },
        tie_tolerance: None,
        untied: scenes::Untied::Refuse,
        materials,
        bolt_hole_clearance: joint.clearance.map(Length::from_si),
    }
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
