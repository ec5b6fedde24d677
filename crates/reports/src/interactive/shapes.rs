//! What the scripts of a page about mode shapes read.

use super::bodies::Bodies;
use super::encode;
use finite_elements::mesh::{Face, Mesh};
use joints::structure::{ModalModel, OuterSurface};
use serde::Serialize;

/// Most components of displacements in a page; a component takes less than three bytes.
const MOST_COMPONENTS: usize = 1_200_000;

/// Steps that displacements are rounded to, from zero to the largest component.
const STEPS: f64 = 32_767.0;

/// Mode shapes on the surface of a structure.
#[derive(Debug, Serialize)]
pub(crate) struct Shapes {
    bodies: Option<Bodies>,
    modes: Vec<Shape>,
    /// Modes that a page has no room for.
    left_out: usize,
}

/// A mode.
#[derive(Debug, Serialize)]
struct Shape {
    /// Contact, number, frequency and name.
    name: String,
    /// Displacements of the nodes, three numbers of two bytes each; the largest component is 32767.
    displacement: String,
}

impl Shapes {
    /// The modes of a model on the `surface` of its mesh.
    pub(crate) fn of(model: &ModalModel, mesh: &Mesh, surface: &[Face]) -> Self {
        let surface = OuterSurface::from_faces(&mesh.nodes, surface);
        let room = MOST_COMPONENTS / (3 * surface.numbers.len()).max(1);
        let all = || {
            let modes = model.contacts.iter().rev();
            modes.flat_map(|of| of.modes.iter().map(move |mode| (of.contact, mode)))
        };
        let shapes = all().take(room).map(|(contact, mode)| {
            let own = || surface.numbers.iter().map(|&node| mode.displacement[node as usize]);
            let largest = own().flatten().fold(0.0_f64, |largest, u| largest.max(u.abs()));
            let scale = if largest > 0.0 { STEPS / largest } else { 0.0 };
            Shape {
                name: format!(
                    "{}: {}. {:.2} Hz, {}",
                    contact.name(),
                    mode.number,
                    mode.frequency_hz,
                    mode.name
                ),
                displacement: encode::shorts(own().flatten().map(|u| (u * scale).round() as i16)),
            }
        });
        Self {
            modes: shapes.collect(),
            left_out: all().count().saturating_sub(room),
            bodies: Bodies::of(&surface),
        }
    }
}
