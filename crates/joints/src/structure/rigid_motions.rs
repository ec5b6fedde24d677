//! Rigid motions that are left to bodies whose interface sticks.

use crate::Error;
use finite_elements::mesh::{Assembly, Dof, Equation};
use joint_model::Sides;

/// Rigid motions of bodies whose interface sticks.
///
/// # Errors
/// [`Error::Disconnected`] for more than six; those of the constraints.
pub(super) fn rigid_motions(assembly: &Assembly, sides: &Sides) -> Result<usize, Error> {
    let mut stuck = assembly.clone();
    let mut stick = |node: u32, other: &mut dyn Iterator<Item = (u32, f64)>| {
        let other: Vec<(u32, f64)> = other.collect();
        stuck.equations.extend((0..3_u8).map(|c| {
            Equation {
                name: "the interface that sticks".into(),
                terms: std::iter::once((Dof::Node(node, c), 1.0))
                    .chain(other.iter().map(|&(node, weight)| (Dof::Node(node, c), -weight)))
                    .collect(),
            }
        }));
    };
    match sides {
        Sides::Pairs { top, bottom } => {
            for (&top, &bottom) in top.iter().zip(bottom) {
                stick(top, &mut std::iter::once((bottom, 1.0)));
            }
        }
        Sides::Projected(parts) => {
            for part in parts {
                for (&own, row) in part.own.iter().zip(part.projection.outer_iterator()) {
                    stick(
                        own,
                        &mut row.iter().map(|(column, &weight)| (part.other[column], weight)),
                    );
                }
            }
        }
    }
    let found = stuck.rigid_motions()?;
    match found {
        0..=6 => Ok(found),
        _ => Err(Error::Disconnected { found }),
    }
}
