//! The asperity population of a pair of faces.

use crate::Error;
use contact_laws::AsperityPopulation;
use scenes::{LawKind, Scene};
use surface_characterisation::PairAsperities;

/// The population of a pair of faces as the scene's law takes it. A sum over single samples has a kink of square-root type
/// at every one of them, which no table follows: tables take the heights interpolated.
pub(super) fn population(scene: &Scene, pair: &PairAsperities) -> Result<AsperityPopulation, Error> {
    Ok(match scene.interfaces.law.kind {
        LawKind::Tabulated => pair.interpolated_population()?,
        LawKind::Fitted | LawKind::AsperitySum | LawKind::BoundaryElements => pair.law_population()?,
    })
}
