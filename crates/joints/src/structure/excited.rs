//! What drives a structure in the analyses of a scene.

use crate::Error;
use joint_model::Excited;
use scenes::{Driver, Excitation, Scene};

/// The excitations of a scene's analyses on a mesh, of which `node` finds a node by the field that names it and its name.
pub(super) fn excited(
    scene: &Scene,
    node: impl Fn(&'static str, &str) -> Result<u32, Error>,
) -> Result<Vec<Excited>, Error> {
    let of = |driver: Driver| {
        Ok(match driver.excitation {
            Excitation::Node { node: name, direction } => Some(Excited::Force {
                node: node(driver.field, &name)?,
                direction,
            }),
            Excitation::Base(base) => base.direction.map(Excited::Base),
            // Of matrices alone.
            Excitation::Response | Excitation::Terms(_) => None,
        })
    };
    scene
        .analyses
        .drivers()
        .into_iter()
        .filter_map(|driver| of(driver).transpose())
        .collect()
}

/// Refuses a moving base of a structure that moves freely.
pub(super) fn require_held(scene: &Scene, rigid_motions: usize) -> Result<(), Error> {
    let drivers = scene.analyses.drivers();
    let moving = drivers
        .iter()
        .find(|driver| matches!(driver.excitation, Excitation::Base(_)));
    match moving {
        Some(driver) if rigid_motions > 0 => Err(Error::FreeBase {
            field: driver.field,
            rigid_motions,
        }),
        _ => Ok(()),
    }
}
