//! Structures from mesh files.

use super::bolt::{Bolt, BoltGeometry, HeadContact, Placed, SIDES, SeatFacts};
use super::excited::{excited, require_held};
use super::facing::{Facing, Surfaces};
use super::material::material;
use super::rigid_motions::rigid_motions;

use super::superelements;
use super::survey::{body_name, smooth};
use super::touching;
use crate::Error;
use finite_elements::formats::solid_mesh::SolidMesh;
use finite_elements::mesh::{
    Assembly, BeyondTolerance, Coupling, CouplingKind, Dof, Element, Face, GroundSpring, LoadPattern, Material, Mesh,
    Tie,
};
use joint_model::benchmark::ElementOrder;
use joint_model::fit::{FacesFit, Fit, Neighbour, SeatFit};
use joint_model::{Bodies, InterfacePart, Joint, MeshedBodies, ProjectedSide, Sides, quadratic, significant};
use nalgebra::Vector3;
use scenes::metric::Metric;
use scenes::{
    BoltSeat, ContactStiffness, Length, MeshBolt, MeshFile, MeshInterface, MeshResponse, MeshSupport, Model, Scene,
};
use sprs::CsMat;
use std::borrow::Cow;
use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use zte_assembly::InterfaceMesh;

/// How far apart faces that are tied or touch may be by default, relative to the longest edge (of the master).
const TIE_REACH: f64 = 0.05;

/// Room between the parts of an interface in their common plane, relative to the extent of the widest one.
const MARGIN: f64 = 0.05;

/// The structure of a scene from a mesh file, in SI, in elements of the order that the scene asks for.
///
/// # Errors
/// Of the file and its groups; [`Error::Facing`], [`Error::MeshScene`], [`Error::NotRaisable`], [`Error::Disconnected`].
pub(super) fn joint(source: &MeshFile, scene: &Scene, notes: &mut dyn FnMut(&str)) -> Result<Joint, Error> {
    let (model, masses) = (&scene.model, &scene.structure.point_masses);
    let mut file = SolidMesh::read(&source.path)?;
    file.notes.iter().for_each(|note| notes(note));
    let length = source.units.length_in_si();
    file.nodes.iter_mut().flatten().for_each(|x| *x *= length);
    let file = File {
        source,
        mesh: file,
        boundary: OnceCell::new(),
        bodies: OnceCell::new(),
    };
    let mut assembly = Assembly {
        mesh: file.solids(model, notes)?,
        ..Assembly::default()
    };
    for tie in &source.ties {
        assembly.ties.push(file.tie(tie)?);
    }
    if !source.superelements.is_empty() {
        let labels = file.mesh.labels.iter().copied();
        let nodes: HashMap<u64, u32> = labels.zip(0..).collect();
        if nodes.len() < file.mesh.labels.len() {
            return file.fail(
                "structure.mesh.superelements".into(),
                "several nodes of the mesh have the same label, as in decks with instances; write the mesh without instances",
            );
        }
        for body in &source.superelements {
            assembly.superelements.push(superelements::read(body, &nodes, notes)?);
        }
    }
    for (number, support) in (1..).zip(&source.supports) {
        file.support(number, support, &mut assembly)?;
    }
    let (mut placed, mut seats) = (Vec::new(), Vec::new());
    for (number, bolt) in (1..).zip(&source.all_bolts()) {
        let (place, own) = file.bolt(number, bolt, model, &mut assembly, notes)?;
        file.require_room(&placed, &place)?;
        placed.push(place);
        seats.extend(own);
    }
    find_neighbours(&mut seats, &placed);
    assembly.masses = super::masses::at_positions(&assembly.mesh.nodes, masses)?;
    let (response_node, direction) = file.response(&source.response)?;
    let excitations = excited(scene, |field, node| file.named_node(field, node))?;
    let (mut surfaces, mut paired) = (Vec::new(), BTreeSet::new());
    for (number, interface) in (1..).zip(&source.interfaces) {
        surfaces.extend(file.surfaces(number, interface, &mut paired)?);
    }
    let elements = &assembly.mesh.elements;
    let is_linear = |element: &&Element| element.cell.element_type().quadratic().is_some();
    let (linear, all) = (elements.iter().filter(is_linear).count(), elements.len());
    let raised = match scene.element_order() {
        ElementOrder::Linear => None,
        ElementOrder::Quadratic if linear == 0 => {
            if model.element_order.is_some() {
                notes("the elements of the mesh are quadratic already");
            }
            None
        }
        ElementOrder::Quadratic if linear < all && model.element_order.is_none() => {
            notes(&format!(
                "{linear} of {all} elements are linear; they stay as they are, since only a mesh that is linear as a whole can be made quadratic"
            ));
            None
        }
        ElementOrder::Quadratic if !source.superelements.is_empty() => {
            return file.fail(
                "structure.mesh.superelements".into(),
                "linear elements that become quadratic have nodes in the middles of edges, which the superelements do not know; give \
                 model.element_order = \"linear\", or a mesh of quadratic elements",
            );
        }
        ElementOrder::Quadratic => {
            let sides = surfaces
                .iter_mut()
                .flat_map(|named| [&mut named.top, &mut named.bottom]);
            let raised = quadratic::raise_surfaces(&mut assembly, sides.collect());
            let raised = raised.map_err(|error| Error::NotRaisable {
                deck: source.path.clone(),
                source: Box::new(error),
            })?;
            assembly.mesh.set_formulation(scene.hexahedra());
            notes(&format!(
                "the {} elements of the mesh were made quadratic, with {} nodes in the middles of their straight edges",
                raised.elements, raised.added_nodes
            ));
            Some(raised)
        }
    };
    let label = |node: u32| file.label(node);
    let (mut joined, mut faces) = (Joined::default(), Vec::new());
    for named in &surfaces {
        let facing = Facing::try_new(
            &mut assembly.mesh.nodes,
            &Surfaces {
                top: &named.top,
                bottom: &named.bottom,
                along: named.interface.along,
                pair_tolerance: None,
                within: named.interface.within.map(Length::si).or(raised.map(|_| named.reach)),
                // Faces of a mesh that stays as it is have their own.
                order: raised.map_or(ElementOrder::Linear, |_| ElementOrder::Quadratic),
                label: &label,
            },
        )
        .map_err(|error| named.unfit(&error))?;
        let about = match surfaces.len() {
            1 => String::new(),
            _ => format!("interface {}: ", named.name),
        };
        facing.notes().iter().for_each(|note| notes(&format!("{about}{note}")));
        faces.push(FacesFit {
            interface: named.name.clone(),
            named: named.interface.top.is_some(),
            ..facing.fit.clone()
        });
        joined.parts.push((named, facing));
    }
    let moved_pairs = joined.parts.first().and_then(|(_, facing)| facing.moved);
    let joined = joined.joint();
    let position = assembly.mesh.nodes[response_node as usize];
    let rigid_motions = rigid_motions(&assembly, &joined.sides)?;
    require_held(scene, rigid_motions)?;
    let bodies = MeshedBodies {
        assembly,
        sides: joined.sides,
        response_node,
        response_direction: direction,
        excitations,
        moved_pairs,
        raised,
        rigid_motions,
    };
    Ok(Joint {
        positions: Some(bodies.interface_positions()),
        bodies: Bodies::Meshed(bodies),
        interface: joined.interface,
        frame: joined.frame,
        node_frames: joined.node_frames,
        parts: joined.parts,
        clearance: source.bolt_hole_clearance.map(Length::si),
        response: format!(
            "node {} at {position:?} m in direction {direction:?}",
            file.label(response_node),
        ),
        fit: Fit { faces, seats },
    })
}

/// Two surfaces of an interface of the scene.
struct Named<'a> {
    name: String,
    interface: &'a MeshInterface,
    /// Its number in the scene, from zero.
    index: usize,
    top: Vec<Face>,
    bottom: Vec<Face>,
    /// How far they may be apart by default (m): elements that are made quadratic have shorter edges.
    reach: f64,
}

impl Named<'_> {
    /// Why the surfaces are no interface, with their place in the scene.
    fn unfit(&self, error: &Error) -> Error {
        let reason = match error {
            Error::Facing { reason } => reason.clone(),
            other => other.to_string(),
        };
        Error::Facing {
            reason: format!("structure.mesh.interfaces, number {}: {reason}", self.index + 1),
        }
    }
}

/// A mesh in SI, and what the scene says of it.
struct File<'a> {
    source: &'a MeshFile,
    mesh: SolidMesh,
    /// Faces of one cell only, outward, with their cells, once something asks for them.
    boundary: OnceCell<Vec<(Face, u32)>>,
    /// For each solid the number of its body, once something asks for them.
    bodies: OnceCell<Vec<u32>>,
}

impl File<'_> {
    fn fail<T>(&self, field: String, reason: impl Into<String>) -> Result<T, Error> {
        Err(Error::MeshScene {
            path: self.source.path.clone(),
            field,
            reason: reason.into(),
        })
    }

    fn boundary(&self) -> &[(Face, u32)] {
        self.boundary.get_or_init(|| self.mesh.boundary())
    }

    /// The solids of a group, or of a body by its number.
    fn volume(&self, name: &str) -> Result<Cow<'_, [u32]>, Error> {
        let unknown = match self.mesh.volume(name) {
            Ok(cells) => return Ok(cells.into()),
            Err(unknown) => unknown,
        };
        let bodies = self.bodies.get_or_init(|| self.mesh.bodies());
        let of_body = (0_u32..)
            .zip(bodies)
            .filter(|(_, body)| body_name(**body as usize) == name);
        let cells: Vec<u32> = of_body.map(|(cell, _)| cell).collect();
        match cells.is_empty() {
            true => Err(unknown.into()),
            false => Ok(cells.into()),
        }
    }

    fn label(&self, node: u32) -> String {
        match self.mesh.labels.get(node as usize) {
            Some(label) => label.to_string(),
            None => "in the middle of an edge".into(),
        }
    }

    fn at(&self, node: u32) -> Vector3<f64> {
        self.mesh.nodes[node as usize].into()
    }

    /// Solids with the materials of their volumes.
    fn solids(&self, model: &Model, notes: &mut dyn FnMut(&str)) -> Result<Mesh, Error> {
        let mut materials = vec![material(model)?];
        let mut of_cell = vec![None; self.mesh.cells.len()];
        for (name, material) in &self.source.materials {
            let number = u16::try_from(materials.len()).unwrap_or(u16::MAX);
            for &cell in &*self.volume(name)? {
                if of_cell[cell as usize]
                    .replace((number, name))
                    .is_some_and(|(first, _)| first != number)
                {
                    return self.fail(
                        format!("structure.mesh.materials.{name}"),
                        "a solid of this volume belongs to another volume with a material too; name one of them",
                    );
                }
            }
            materials.push(elastic(name, material));
        }
        let elements = self.mesh.cells.iter().zip(of_cell).map(|(&cell, material)| Element {
            cell,
            material: material.map_or(0, |(number, _)| number),
        });
        let mut mesh = Mesh {
            nodes: self.mesh.nodes.clone(),
            elements: elements.collect(),
            materials,
        };
        if let Some(formulation) = model.formulation {
            mesh.set_formulation(formulation);
        }
        let stiff = mesh
            .elements
            .iter()
            .filter(|element| matches!(element.cell.nodes().len(), 4 | 6))
            .count();
        // A mesh that is linear as a whole becomes quadratic.
        let is_mixed = mesh.elements.iter().any(|element| element.cell.nodes().len() > 8);
        if stiff > 0 && (is_mixed || model.element_order == Some(ElementOrder::Linear)) {
            let remedy = match is_mixed {
                true => "make the mesh quadratic as a whole",
                false => "give model.element_order = \"quadratic\"",
            };
            notes(&format!(
                "{stiff} elements are linear tetrahedra or wedges, which are far too stiff in bending: with two of them over the thickness of a \
                 plate its frequencies in bending and torsion are 22 to 33 % too high; {remedy}"
            ));
        }
        Ok(mesh)
    }

    fn tie(&self, tie: &scenes::MeshTie) -> Result<Tie, Error> {
        let (slave, master) = (self.mesh.surface(&tie.slave)?, self.mesh.surface(&tie.master)?);
        Ok(Tie {
            name: format!("{} on {}", tie.slave, tie.master),
            slave_nodes: touching::nodes(slave),
            master_faces: master.to_vec(),
            position_tolerance: tie.within.map_or(TIE_REACH * self.longest_edge(master), Length::si),
            beyond: BeyondTolerance::Refuse,
            adjust: true,
        })
    }

    fn longest_edge(&self, faces: &[Face]) -> f64 {
        let edges = faces.iter().flat_map(|face| {
            let corners = face.corners();
            (0..corners.len()).map(move |i| [corners[i], corners[(i + 1) % corners.len()]])
        });
        edges.map(|[a, b]| (self.at(a) - self.at(b)).norm()).fold(0.0, f64::max)
    }

    /// Area of each node's share of faces (m^2).
    fn areas(&self, faces: &[Face]) -> BTreeMap<u32, f64> {
        let mut areas = BTreeMap::new();
        for face in faces {
            for (node, area) in face.node_areas(&self.mesh.nodes) {
                *areas.entry(node).or_insert(0.0) += area;
            }
        }
        areas
    }

    fn support(&self, number: usize, support: &MeshSupport, assembly: &mut Assembly) -> Result<(), Error> {
        let field = || format!("structure.mesh.supports, number {number}");
        let held = (0..3_u8).filter(|&c| support.components[usize::from(c)]);
        let faces = match (&support.surface, support.face, &support.points) {
            (Some(surface), None, None) => Some(self.mesh.surface(surface)?.into()),
            (None, Some(position), None) => Some(self.smooth_surface(&format!("{}: face", field()), position)?.into()),
            (None, None, Some(_)) => None,
            _ => return self.fail(field(), "give one of `surface`, `face` and `points`"),
        };
        let faces: Option<Cow<'_, [Face]>> = faces;
        match (&faces, &support.points, support.stiffness.map(ContactStiffness::si)) {
            (Some(faces), _, Some(stiffness)) => {
                for (node, area) in self.areas(faces) {
                    assembly.springs.extend(held.clone().map(|component| GroundSpring {
                        node,
                        component,
                        stiffness: stiffness * area,
                    }));
                }
            }
            (None, _, Some(_)) => {
                return self.fail(
                    field(),
                    "a stiffness per area needs a surface, and this is a group of nodes",
                );
            }
            (Some(faces), _, None) => {
                let nodes = touching::nodes(faces);
                let all = nodes
                    .into_iter()
                    .flat_map(|node| held.clone().map(move |c| Dof::Node(node, c)));
                assembly.supports.extend(all);
            }
            (None, Some(points), None) => {
                let nodes = self.mesh.points(points)?.iter();
                let all = nodes.flat_map(|&node| held.clone().map(move |c| Dof::Node(node, c)));
                assembly.supports.extend(all);
            }
            (None, None, None) => {}
        }
        Ok(())
    }

    /// The smooth part of the outer surface with the face whose middle is nearest to a position.
    fn smooth_surface(&self, field: &str, position: [Length; 3]) -> Result<Vec<Face>, Error> {
        let position = Vector3::from(position.map(Length::si));
        let faces: Vec<Face> = self.boundary().iter().map(|(face, _)| *face).collect();
        let away = |face: &Face| {
            let corners = face.corners();
            let sum: Vector3<f64> = corners.iter().map(|&node| self.at(node)).sum();
            (sum / corners.len() as f64 - position).norm()
        };
        let distances: Vec<f64> = faces.iter().map(away).collect();
        let nearest = (0..faces.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        let Some(nearest) = nearest else {
            return self.fail(field.into(), "the mesh has no surface");
        };
        self.require_on_mesh(field, position, distances[nearest])?;
        let parts = smooth(&self.mesh.nodes, &faces);
        let mut with_nearest = parts.into_iter().filter(|part| part.contains(&nearest));
        let part = with_nearest.next().unwrap_or_default();
        Ok(part.into_iter().map(|face| faces[face]).collect())
    }

    /// Refuses a position that is farther `away` from the mesh than its size.
    fn require_on_mesh(&self, field: &str, position: Vector3<f64>, away: f64) -> Result<(), Error> {
        let size = self.size();
        if away > size {
            return self.fail(
                field.into(),
                format!(
                    "what is nearest to {:?} m is {away:.3e} m away, more than the size of the mesh, {size:.3e} m; give a position on \
                     the mesh, and check its unit",
                    position.as_slice()
                ),
            );
        }
        Ok(())
    }

    /// Refuses a bolt in the place of one before it.
    fn require_room(&self, placed: &[Placed], bolt: &Placed) -> Result<(), Error> {
        let number = placed.len() + 1;
        let found = (1..).zip(placed);
        let mut collisions = found.filter_map(|(other, before)| Some((other, before.shank, before.collision(bolt)?)));
        match collisions.next() {
            None => Ok(()),
            Some((other, shank, distance)) => {
                let [own, shank] = [bolt.shank, shank].map(|shank| match shank > 0.0 {
                    true => format!("a shank of {} mm", significant(1e3 * shank)),
                    false => "forces alone".to_owned(),
                });
                self.fail(
                    format!("structure.mesh.bolts, number {number}"),
                    format!(
                        "its axis ({own}) is {} mm from that of bolt {other} ({shank}), which clamps the same place; leave one of the two out, \
                         or correct where it is",
                        significant((1e7 * distance).round() / 1e4),
                    ),
                )
            }
        }
    }

    /// Adds a bolt with its load of unit tension, and says where it is and how its seats fit, if they are found in the mesh.
    fn bolt(
        &self,
        number: usize,
        bolt: &MeshBolt,
        model: &Model,
        assembly: &mut Assembly,
        notes: &mut dyn FnMut(&str),
    ) -> Result<(Placed, Vec<SeatFit>), Error> {
        let field = || format!("structure.mesh.bolts, number {number}");
        match (&bolt.axis, &bolt.size, &bolt.head, &bolt.nut) {
            (None, None, Some(head), Some(nut)) => {
                let [head, nut] = [head, nut].map(|name| -> Result<Coupling, Error> {
                    let areas = self.areas(self.mesh.surface(name)?);
                    let total: f64 = areas.values().sum();
                    let mean = areas
                        .iter()
                        .fold(Vector3::zeros(), |sum, (&node, area)| sum + self.at(node) * *area);
                    Ok(Coupling {
                        name: name.clone(),
                        reference: (mean / total).into(),
                        nodes: areas.keys().copied().collect(),
                        kind: CouplingKind::Distributing(areas.into_values().collect()),
                    })
                });
                let (head, nut) = (head?, nut?);
                let way = Vector3::from(nut.reference) - Vector3::from(head.reference);
                let Some(way) = way.try_normalize(0.0) else {
                    return self.fail(field(), "the surfaces of head and nut have the same centre");
                };
                let first = assembly.couplings.len() as u32;
                let pull = |reference, sign: f64| {
                    (0..3_u8).map(move |c| (Dof::Reference(reference, c), sign * way[usize::from(c)]))
                };
                assembly.loads.push(LoadPattern {
                    name: format!("{} against {}", head.name, nut.name),
                    terms: pull(first, 1.0).chain(pull(first + 1, -1.0)).collect(),
                });
                let placed = Placed {
                    ends: [head.reference, nut.reference].map(Vector3::from),
                    shank: 0.0,
                };
                assembly.couplings.extend([head, nut]);
                Ok((placed, Vec::new()))
            }
            (Some(axis), Some(size), None, None) => {
                let size = Metric::from_name(size)?;
                let material = match &bolt.material {
                    Some(own) => elastic(&format!("bolt {number}"), own),
                    None => material(model)?,
                };
                let axis = axis.map(|point| point.map(Length::si));
                let mut geometry = BoltGeometry::metric(&format!("bolt {number}"), &size, axis, bolt.washers, material);
                geometry.contact = match bolt.seat {
                    BoltSeat::Distributing => HeadContact::Distributing,
                    BoltSeat::Tied => HeadContact::Tied,
                };
                let boundary: Vec<Face> = self.boundary().iter().map(|(face, _)| *face).collect();
                let facts = Bolt::try_new(&self.mesh.nodes, &boundary, &geometry)?.join(assembly);
                notes(&format!(
                    "bolt {number}: clamps {:.3} mm, {:.4} kg, {:.4e} N/m axially (VDI 2230); its seats hold {} and {} nodes and cover {:.0} and \
                     {:.0} % of their rings",
                    1e3 * facts.clamped,
                    facts.mass,
                    1.0 / facts.compliance.axial(),
                    facts.seats[0].nodes,
                    facts.seats[1].nodes,
                    100.0 * facts.seats[0].covered,
                    100.0 * facts.seats[1].covered,
                ));
                let shank = geometry.thread.diameter;
                let seats = facts
                    .seats
                    .iter()
                    .zip(&geometry.seats)
                    .zip(SIDES)
                    .map(|((found, seat), side)| SeatFit {
                        bolt: number,
                        side: side.to_owned(),
                        outer: seat.outer,
                        shank,
                        covered: found.covered,
                        hole: found.hole,
                        neighbour: None,
                    });
                let ends = facts.seats.map(|seat| Vector3::from(seat.centre));
                Ok((Placed { ends, shank }, seats.collect()))
            }
            _ => self.fail(
                field(),
                "give either `axis` and `size` for a shank, or the surfaces `head` and `nut` for forces alone",
            ),
        }
    }

    /// Node and direction of the response; any for a mode, which is not known yet.
    fn response(&self, response: &MeshResponse) -> Result<(u32, [f64; 3]), Error> {
        let field = "structure.mesh.response";
        let node = match (&response.nearest, &response.node, response.mode, response.direction) {
            (Some(position), None, None, Some(_)) => {
                let position = Vector3::from(position.map(Length::si));
                let nodes = self.boundary().iter().flat_map(|(face, _)| face.corners());
                let distance = |node: &&u32| (self.at(**node) - position).norm();
                let nearest = nodes.min_by(|a, b| distance(a).total_cmp(&distance(b)));
                // A mesh without solids was refused.
                let Some(&nearest) = nearest else {
                    return self.fail(field.into(), "the mesh has no surface");
                };
                self.require_on_mesh(&format!("{field}.nearest"), position, distance(&&nearest))?;
                nearest
            }
            (None, Some(node), None, Some(_)) => self.named_node("structure.mesh.response.node", node)?,
            (None, None, Some(_), None) => 0,
            _ => {
                return self.fail(
                    field.into(),
                    "give either `nearest` or `node` with a `direction`, or a `mode` without one",
                );
            }
        };
        Ok((node, response.direction.unwrap_or([0.0, 0.0, 1.0])))
    }

    /// Diagonal of the box about all nodes (m).
    fn size(&self) -> f64 {
        let extent = |axis: usize| {
            let along = self.mesh.nodes.iter().map(|x| x[axis]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        Vector3::from([0, 1, 2].map(extent)).norm()
    }

    /// The node of a group of one, or with a number.
    fn named_node(&self, field: &'static str, name: &str) -> Result<u32, Error> {
        match self.mesh.points(name) {
            Ok(&[node]) => Ok(node),
            Ok(nodes) => Err(Error::NodeSet {
                field,
                set: name.to_owned(),
                count: nodes.len(),
            }),
            Err(error) => {
                let number: Option<u64> = name.parse().ok();
                let found = number.and_then(|number| self.mesh.labels.iter().position(|&label| label == number));
                Ok(found.ok_or(error)? as u32)
            }
        }
    }

    /// The pairs of surfaces of an interface: one that is named, or all patches where two bodies touch. Pairs of volumes go to `paired`; those of
    /// a pattern are only those that are not there.
    fn surfaces<'a>(
        &self,
        number: usize,
        interface: &'a MeshInterface,
        paired: &mut BTreeSet<[String; 2]>,
    ) -> Result<Vec<Named<'a>>, Error> {
        let name = interface.name.clone().unwrap_or_else(|| number.to_string());
        let field = || format!("structure.mesh.interfaces, number {number}");
        let cells = match (&interface.top, &interface.bottom, &interface.between) {
            (Some(top), Some(bottom), None) => {
                let sides = [self.mesh.surface(top)?.to_vec(), self.mesh.surface(bottom)?.to_vec()];
                return Ok(vec![self.named(number, interface, name, sides)]);
            }
            (None, None, Some(volumes)) if volumes.iter().any(|name| self.is_pattern(name)) => {
                return self.of_pairs(number, interface, volumes, paired);
            }
            (None, None, Some(volumes)) => {
                paired.insert(in_order(volumes.each_ref()));
                let mut of_cell = vec![None; self.mesh.cells.len()];
                for (side, volume) in volumes.iter().enumerate() {
                    for &cell in &*self.volume(volume)? {
                        of_cell[cell as usize] = Some(side);
                    }
                }
                of_cell
            }
            (None, None, None) => {
                let bodies = self.mesh.bodies();
                let count = bodies.iter().max().map_or(0, |last| last + 1);
                if count != 2 {
                    return self.fail(
                        field(),
                        match count {
                            0 | 1 => "all solids of the mesh share nodes, so that nothing can slide: mesh the bodies apart, each with nodes of \
                                      its own where they touch (in Gmsh without BooleanFragments and Coherence between them)"
                                .to_owned(),
                            _ => format!(
                                "the mesh has {count} bodies that share no nodes, so that the faces in contact must be named: give `top` and \
                                 `bottom`, or the volumes they are `between`"
                            ),
                        },
                    );
                }
                bodies.into_iter().map(|body| Some(body as usize)).collect()
            }
            _ => {
                return self.fail(
                    field(),
                    "give both `top` and `bottom`, or the two volumes it is `between`, or none of them where there are two bodies",
                );
            }
        };
        let mut sides: [Vec<Face>; 2] = Default::default();
        for (face, cell) in self.boundary() {
            if let Some(side) = cells[*cell as usize] {
                sides[side].push(*face);
            }
        }
        let patches = self.patches(number, interface, &name, &sides);
        match patches.is_empty() {
            true => self.fail(
                field(),
                "no faces of the two bodies touch; give a larger distance `within`, or check the geometry",
            ),
            false => Ok(patches),
        }
    }

    /// The patches on which two sets of faces touch.
    fn patches<'a>(
        &self,
        number: usize,
        interface: &'a MeshInterface,
        name: &str,
        sides: &[Vec<Face>; 2],
    ) -> Vec<Named<'a>> {
        let patches = touching::patches(&self.mesh.nodes, sides, interface.within.map(Length::si));
        let is_one = patches.len() == 1;
        let numbered = (1_usize..).zip(patches).map(|(patch, sides)| {
            let name = match is_one {
                true => name.to_owned(),
                false => format!("{name}.{patch}"),
            };
            self.named(number, interface, name, sides)
        });
        numbered.collect()
    }

    fn named<'a>(
        &self,
        number: usize,
        interface: &'a MeshInterface,
        name: String,
        [top, bottom]: [Vec<Face>; 2],
    ) -> Named<'a> {
        Named {
            name,
            interface,
            index: number - 1,
            reach: TIE_REACH * self.longest_edge(&top).max(self.longest_edge(&bottom)),
            top,
            bottom,
        }
    }

    /// Whether a name stands for several volumes.
    fn is_pattern(&self, name: &str) -> bool {
        name.contains('*') && self.mesh.volume(name).is_err()
    }

    /// The volumes that a name or pattern stands for: groups, or where no group has such a name the bodies by their numbers.
    fn volumes(&self, pattern: &str) -> Result<Vec<String>, Error> {
        if !self.is_pattern(pattern) {
            return Ok(vec![pattern.to_owned()]);
        }
        let groups = self.mesh.volumes.iter().map(|group| group.name.clone());
        let found: Vec<String> = groups.filter(|name| matches(pattern, name)).collect();
        if !found.is_empty() {
            return Ok(found);
        }
        let last = self.bodies.get_or_init(|| self.mesh.bodies()).iter().max();
        let bodies = 0..last.map_or(0, |last| *last as usize + 1);
        let found: Vec<String> = bodies.map(body_name).filter(|name| matches(pattern, name)).collect();
        match found.is_empty() {
            // Says which volumes there are.
            true => self.mesh.volume(pattern).map(|_| Vec::new()).map_err(Error::from),
            false => Ok(found),
        }
    }

    /// An interface for each pair of volumes of two patterns that touch.
    fn of_pairs<'a>(
        &self,
        number: usize,
        interface: &'a MeshInterface,
        patterns: &[String; 2],
        paired: &mut BTreeSet<[String; 2]>,
    ) -> Result<Vec<Named<'a>>, Error> {
        let field = || format!("structure.mesh.interfaces, number {number}");
        let [tops, bottoms] = [self.volumes(&patterns[0])?, self.volumes(&patterns[1])?];
        let mut of_cell: Vec<Option<&String>> = vec![None; self.mesh.cells.len()];
        let mut names: Vec<&String> = tops.iter().chain(&bottoms).collect();
        names.sort();
        names.dedup();
        for name in names {
            for &cell in &*self.volume(name)? {
                if let Some(other) = of_cell[cell as usize].replace(name) {
                    return self.fail(
                        field(),
                        format!("the volumes `{other}` and `{name}` share solids; give patterns of which only one has each body"),
                    );
                }
            }
        }
        let mut faces: BTreeMap<&String, Vec<Face>> = BTreeMap::new();
        for (face, cell) in self.boundary() {
            if let Some(name) = of_cell[*cell as usize] {
                faces.entry(name).or_default().push(*face);
            }
        }
        let reach = interface.within.map_or_else(
            || {
                faces
                    .values()
                    .map(|faces| TIE_REACH * self.longest_edge(faces))
                    .fold(0.0, f64::max)
            },
            Length::si,
        );
        let boxes: BTreeMap<&String, [Vector3<f64>; 2]> = (faces.iter())
            .map(|(name, faces)| (*name, self.bounding_box(faces)))
            .collect();
        let mut found = Vec::new();
        for (top, bottom) in tops
            .iter()
            .flat_map(|top| bottoms.iter().map(move |bottom| (top, bottom)))
        {
            let (Some(own), Some(other)) = (boxes.get(top), boxes.get(bottom)) else {
                continue;
            };
            let apart = (0..3).any(|q| own[0][q] > other[1][q] + reach || other[0][q] > own[1][q] + reach);
            if top == bottom || apart || !paired.insert(in_order([top, bottom])) {
                continue;
            }
            let name = match &interface.name {
                None => format!("{top} on {bottom}"),
                Some(name) => format!("{name}: {top} on {bottom}"),
            };
            let sides = [faces[top].clone(), faces[bottom].clone()];
            found.extend(self.patches(number, interface, &name, &sides));
        }
        match found.is_empty() {
            true => self.fail(
                field(),
                format!(
                    "of {} and {} volumes none touch that no entry before has; give a larger distance `within`, or check the geometry",
                    tops.len(),
                    bottoms.len()
                ),
            ),
            false => Ok(found),
        }
    }

    /// Smallest and largest coordinates of faces.
    fn bounding_box(&self, faces: &[Face]) -> [Vector3<f64>; 2] {
        let nodes = faces.iter().flat_map(|face| face.nodes());
        nodes.fold(
            [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)],
            |[low, high], &node| [low.inf(&self.at(node)), high.sup(&self.at(node))],
        )
    }
}

/// A pair whichever is named first.
fn in_order([a, b]: [&String; 2]) -> [String; 2] {
    [a.min(b).clone(), a.max(b).clone()]
}

/// Whether a name fits a pattern, in which `*` stands for any text.
fn matches(pattern: &str, name: &str) -> bool {
    let parts: Vec<&str> = pattern.split('*').collect();
    let [first, middle @ .., last] = &parts[..] else {
        return pattern == name;
    };
    let begun = name.strip_prefix(first);
    let found = begun.and_then(|left| {
        let mut middle = middle.iter();
        middle.try_fold(left, |left, part| left.split_once(part).map(|(_, rest)| rest))
    });
    found.is_some_and(|left| left.ends_with(last))
}

/// Finds for each seat the nearest one of another bolt in its plane; `placed` are all bolts in turn.
fn find_neighbours(seats: &mut [SeatFit], placed: &[Placed]) {
    let known: Vec<(usize, f64, Vector3<f64>)> = (seats.iter())
        .map(|seat| (seat.bolt, seat.outer, placed[seat.bolt - 1].ends[end_of(seat)]))
        .collect();
    for seat in seats {
        let own = placed[seat.bolt - 1];
        let others = known.iter().filter(|(bolt, ..)| *bolt != seat.bolt);
        let beside = others.filter_map(|&(bolt, outer, centre)| {
            Some(Neighbour {
                bolt,
                distance: own.beside(end_of(seat), centre, SeatFacts::depth(seat.outer))?,
                least: 0.5 * (seat.outer + outer),
            })
        });
        seat.neighbour = beside.min_by(|a, b| a.room().total_cmp(&b.room()));
    }
}

/// Zero for the seat under the head, one for that under the nut.
fn end_of(seat: &SeatFit) -> usize {
    usize::from(seat.side != SIDES[0])
}

fn elastic(name: &str, material: &scenes::Material) -> Material {
    Material {
        name: name.to_owned(),
        youngs_modulus: material.youngs_modulus.si(),
        poisson_ratio: material.poisson_ratio,
        density: material.density.map_or(f64::NAN, scenes::Density::si),
    }
}

/// Parts of an interface, to be joined.
#[derive(Default)]
struct Joined<'a> {
    parts: Vec<(&'a Named<'a>, Facing)>,
}

/// All parts together.
struct Whole {
    interface: InterfaceMesh,
    sides: Sides,
    frame: [[f64; 3]; 3],
    node_frames: Vec<[[f64; 3]; 3]>,
    parts: Vec<InterfacePart>,
}

impl Joined<'_> {
    /// One interface as it is; several side by side in one plane.
    fn joint(mut self) -> Whole {
        if self.parts.len() == 1
            && let Some((named, facing)) = self.parts.pop()
        {
            let part = InterfacePart {
                name: named.name.clone(),
                source: named.index,
                nodes: 0..facing.interface.nodes.len(),
                elements: 0..facing.interface.elements.len(),
                offset: [0.0; 2],
                normal: facing.frame[2],
            };
            return Whole {
                interface: facing.interface,
                sides: facing.sides,
                frame: facing.frame,
                node_frames: facing.node_frames,
                parts: vec![part],
            };
        }
        let mut whole = Whole {
            interface: InterfaceMesh::flat(Vec::new(), Vec::new()),
            sides: Sides::Projected(Vec::new()),
            frame: self.parts.first().map_or([[0.0; 3]; 3], |(_, facing)| facing.frame),
            node_frames: Vec::new(),
            parts: Vec::new(),
        };
        let range = |mesh: &InterfaceMesh, axis: usize| {
            let along = mesh.nodes.iter().map(|x| x[axis]);
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
        };
        let extents = self.parts.iter().map(|(_, facing)| {
            let (low, high) = range(&facing.interface, 0);
            high - low
        });
        let margin = MARGIN * extents.fold(0.0, f64::max);
        let is_curved = self
            .parts
            .iter()
            .any(|(_, facing)| !facing.interface.heights.is_empty());
        let mut sides = Vec::new();
        let mut end = 0.0;
        for (number, (named, facing)) in self.parts.into_iter().enumerate() {
            let mesh = facing.interface;
            let (low, high) = range(&mesh, 0);
            let bottom = range(&mesh, 1).0;
            // The first part stays where it is.
            let offset = match number {
                0 => [0.0; 2],
                _ => [
                    end + margin - low,
                    whole.interface.nodes.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min) - bottom,
                ],
            };
            end = high + offset[0];
            let (first_node, first_element) = (whole.interface.nodes.len(), whole.interface.elements.len());
            let nodes = first_node..first_node + mesh.nodes.len();
            let elements = first_element..first_element + mesh.elements.len();
            let renumbered = mesh.elements.iter().map(|element| {
                let mut element = *element;
                element
                    .nodes_mut()
                    .iter_mut()
                    .for_each(|node| *node += first_node as u32);
                element
            });
            whole.interface.elements.extend(renumbered);
            let shifted = mesh.nodes.iter().map(|x| [x[0] + offset[0], x[1] + offset[1]]);
            whole.interface.nodes.extend(shifted);
            if is_curved {
                let flat = vec![0.0; mesh.nodes.len()];
                let heights = if mesh.heights.is_empty() { flat } else { mesh.heights };
                whole.interface.heights.extend(heights);
            }
            whole
                .interface
                .covered
                .extend(mesh.covered.iter().map(|part| zte_assembly::Covered {
                    element: part.element + first_element,
                    centroid: [part.centroid[0] + offset[0], part.centroid[1] + offset[1]],
                    ..*part
                }));
            whole.node_frames.extend(match facing.node_frames.is_empty() {
                true => vec![facing.frame; nodes.len()],
                false => facing.node_frames,
            });
            match facing.sides {
                Sides::Projected(projected) => sides.extend(projected),
                Sides::Pairs { top, bottom } => sides.push(ProjectedSide {
                    projection: CsMat::eye(top.len()),
                    own: top,
                    own_is_top: true,
                    own_faces: named.top.clone(),
                    other: bottom,
                    other_faces: named.bottom.clone(),
                }),
            }
            whole.parts.push(InterfacePart {
                name: named.name.clone(),
                source: named.index,
                nodes,
                elements,
                offset,
                normal: facing.frame[2],
            });
        }
        whole.sides = Sides::Projected(sides);
        whole
    }
}
