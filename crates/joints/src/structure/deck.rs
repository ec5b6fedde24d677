//! Structures from input decks of Abaqus and CalculiX.

use super::excited::{excited, require_held};
use super::facing::{Facing, Surfaces};
use super::material::material;
use super::rigid_motions::rigid_motions;
use crate::Error;
use finite_elements::formats::abaqus::{self, Choices, DeckModel};
use finite_elements::mesh::{BeyondTolerance, Dof, LoadPattern};
use joint_model::benchmark::ElementOrder;
use joint_model::fit::{FacesFit, Fit};
use joint_model::{Bodies, Joint, MeshedBodies, Sides, quadratic};
use scenes::{Deck, DeckBolt, Length, MaterialSource, Scene, Untied};

/// A structure from an input deck, in SI, with point masses at nodes that it names.
///
/// # Errors
/// Of the deck; [`Error::Facing`], [`Error::NotRaisable`].
pub(super) fn joint(source: &Deck, scene: &Scene, notes: &mut dyn FnMut(&str)) -> Result<Joint, Error> {
    let (model, masses) = (&scene.model, &scene.structure.point_masses);
    let order = scene.element_order();
    let (length, mass) = (source.units.length_in_si(), source.units.mass_in_si());
    let choices = Choices {
        formulation: model.formulation,
        tie_tolerance: source.tie_tolerance.map(|tolerance| tolerance.si() / length),
        beyond: match source.untied {
            Untied::Refuse => BeyondTolerance::Refuse,
            Untied::Free => BeyondTolerance::LeaveFree,
        },
        ..Choices::default()
    };
    let not_raisable = |error| Error::NotRaisable {
        deck: source.path.clone(),
        source: Box::new(error),
    };
    let read = abaqus::read(&source.path, source.includes)?;
    if order == ElementOrder::Quadratic {
        read.require_linear().map_err(not_raisable)?;
    }
    let deck = read.assembly(&choices)?;
    deck.notes.iter().for_each(|note| notes(note));
    let mut assembly = deck.assembly.clone();
    assembly.convert_units(length, mass);
    if source.materials == MaterialSource::Scene {
        assembly.mesh.materials.fill(material(model)?);
    }
    let [top, bottom] = [
        deck.surface_faces(&source.top_surface)?,
        deck.surface_faces(&source.bottom_surface)?,
    ];
    let n_nodes = assembly.mesh.nodes.len();
    let label = |node: u32| match (node as usize) < n_nodes {
        true => deck.node_name(node),
        false => "in the middle of an edge".into(),
    };
    let surfaces = Surfaces {
        top,
        bottom,
        along: source.along,
        pair_tolerance: source.pair_tolerance.map(Length::si),
        within: None,
        order,
        label: &label,
    };
    let mut facing = Facing::try_new(&mut assembly.mesh.nodes, &surfaces)?;
    facing.notes().iter().for_each(|note| notes(note));
    let normal = facing.frame[2];
    // Before nodes are moved, and elements are raised.
    let faces = FacesFit {
        named: true,
        ..facing.fit.clone()
    };
    assembly.loads = source
        .bolts
        .iter()
        .map(|bolt| {
            let (top, bottom) = match bolt {
                DeckBolt::References { top, bottom } => (top, bottom),
                DeckBolt::Pretension { pretension } => {
                    return Ok(LoadPattern {
                        name: format!("pretension of {pretension}"),
                        terms: vec![(deck.pretension(pretension)?, 1.0)],
                    });
                }
            };
            let ends = [(deck.reference(top)?, 1.0), (deck.reference(bottom)?, -1.0)];
            let components = |(reference, sign)| {
                (0..3_u8).map(move |c| (Dof::Reference(reference, c), sign * normal[usize::from(c)]))
            };
            Ok(LoadPattern {
                name: format!("{top} against {bottom}"),
                terms: ends.into_iter().flat_map(components).collect(),
            })
        })
        .collect::<Result<_, Error>>()?;
    let response_node = named_node(&deck, "structure.deck.response.node", &source.response.node)?;
    let excitations = excited(scene, |field, node| named_node(&deck, field, node))?;
    for point in masses {
        // Decks name the nodes of all masses.
        let name = point.node.as_deref().unwrap_or_default();
        assembly.masses.push(finite_elements::mesh::PointMass {
            node: named_node(&deck, "structure.point_masses[].node", name)?,
            mass: point.mass.si(),
        });
    }
    // Last, so that edges stay straight where nodes of the interface were moved.
    let raised = match order {
        ElementOrder::Linear => None,
        ElementOrder::Quadratic => {
            let raised = match &mut facing.sides {
                Sides::Pairs { top, bottom } => {
                    let sides = [top, bottom];
                    quadratic::raise(&mut assembly, &mut facing.interface, sides, facing.frame, |_| None)
                        .map_err(not_raisable)?
                }
                Sides::Projected(_) => {
                    let [mut top, mut bottom] = [top.to_vec(), bottom.to_vec()];
                    let raised =
                        quadratic::raise_surfaces(&mut assembly, vec![&mut top, &mut bottom]).map_err(not_raisable)?;
                    let surfaces = Surfaces {
                        top: &top,
                        bottom: &bottom,
                        ..surfaces
                    };
                    facing = Facing::try_new(&mut assembly.mesh.nodes, &surfaces)?;
                    raised
                }
            };
            assembly.mesh.set_formulation(scene.hexahedra());
            notes(&format!(
                "the {} elements of the deck were made quadratic, with {} nodes in the middles of their straight edges",
                raised.elements, raised.added_nodes
            ));
            Some(raised)
        }
    };
    let rigid_motions = rigid_motions(&assembly, &facing.sides)?;
    require_held(scene, rigid_motions)?;
    let bodies = MeshedBodies {
        assembly,
        sides: facing.sides,
        response_node,
        response_direction: source.response.direction,
        excitations,
        moved_pairs: facing.moved,
        raised,
        rigid_motions,
    };
    Ok(Joint {
        positions: Some(bodies.interface_positions()),
        bodies: Bodies::Meshed(bodies),
        interface: facing.interface,
        frame: facing.frame,
        node_frames: facing.node_frames,
        parts: Vec::new(),
        clearance: source.bolt_hole_clearance.map(Length::si),
        response: format!(
            "node {} in direction {:?}",
            source.response.node, source.response.direction
        ),
        fit: Fit {
            faces: vec![faces],
            ..Fit::default()
        },
    })
}

/// The node of a label or of a set of one node; `field` of the scene names it.
fn named_node(deck: &DeckModel, field: &'static str, name: &str) -> Result<u32, Error> {
    match deck.node_set(name) {
        Ok(&[node]) => Ok(node),
        Ok(nodes) => Err(Error::NodeSet {
            field,
            set: name.to_owned(),
            count: nodes.len(),
        }),
        Err(_) => Ok(deck.node(name)?),
    }
}
