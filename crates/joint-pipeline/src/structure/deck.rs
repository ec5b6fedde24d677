//! Structures from input decks of Abaqus and CalculiX.

use super::facing::Facing;
use crate::Error;
use crate::joint::{Bodies, Joint, MeshedBodies};
use crate::scene::{Deck, Length, MaterialSource, Untied};
use substructure::elements::Formulation;
use substructure::formats::abaqus::{self, Choices};
use substructure::mesh::{BeyondTolerance, Dof, LoadPattern, Material};

/// A structure from an input deck, in SI.
///
/// # Errors
/// Of the deck; [`Error::Facing`].
pub(super) fn joint(
    source: &Deck,
    material: &Material,
    formulation: Option<Formulation>,
    notes: &mut dyn FnMut(&str),
) -> Result<Joint, Error> {
    let (length, mass) = (source.units.length_in_si(), source.units.mass_in_si());
    let choices = Choices {
        formulation,
        tie_tolerance: source.tie_tolerance.map(|tolerance| tolerance.si() / length),
        beyond: match source.untied {
            Untied::Refuse => BeyondTolerance::Refuse,
            Untied::Free => BeyondTolerance::LeaveFree,
        },
        ..Choices::default()
    };
    let deck = abaqus::read(&source.path, source.includes)?.assembly(&choices)?;
    deck.notes.iter().for_each(|note| notes(note));
    let mut assembly = deck.assembly.clone();
    assembly.convert_units(length, mass);
    if source.materials == MaterialSource::Scene {
        assembly.mesh.materials.fill(material.clone());
    }
    let facing = Facing::try_new(
        &assembly.mesh.nodes,
        deck.surface_faces(&source.top_surface)?,
        deck.surface_faces(&source.bottom_surface)?,
        source.along,
        &|node| deck.node_name(node),
    )?;
    let normal = facing.frame[2];
    assembly.loads = source
        .bolts
        .iter()
        .map(|bolt| {
            let ends = [(deck.reference(&bolt.top)?, 1.0), (deck.reference(&bolt.bottom)?, -1.0)];
            let components = |(reference, sign)| {
                (0..3_u8).map(move |c| (Dof::Reference(reference, c), sign * normal[usize::from(c)]))
            };
            Ok(LoadPattern {
                name: format!("{} against {}", bolt.top, bolt.bottom),
                terms: ends.into_iter().flat_map(components).collect(),
            })
        })
        .collect::<Result<_, Error>>()?;
    let response_node = match deck.node_set(&source.response.node) {
        Ok(&[node]) => node,
        Ok(nodes) => {
            return Err(Error::ResponseSet {
                set: source.response.node.clone(),
                count: nodes.len(),
            });
        }
        Err(_) => deck.node(&source.response.node)?,
    };
    Ok(Joint {
        bodies: Bodies::Meshed(MeshedBodies {
            assembly,
            top_nodes: facing.top_nodes,
            bottom_nodes: facing.bottom_nodes,
            response_node,
            response_direction: source.response.direction,
        }),
        interface: facing.interface,
        frame: facing.frame,
        clearance: source.bolt_hole_clearance.map(Length::si),
        response: format!(
            "node {} in direction {:?}",
            source.response.node, source.response.direction
        ),
    })
}
