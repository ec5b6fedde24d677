//! The order in which a deck is read.

use super::deck::Deck;
use super::expand::{Scoped, expand};
use super::keywords::{Extent, Phase};
use super::reader::Reader;
use super::text::Source;
use crate::Error;
use nalgebra::Isometry3;

/// Reads all blocks of a deck.
pub(super) fn run(source: &Source) -> Result<Deck, Error> {
    let mut reader = read(source, Extent::Structure)?;
    reader
        .deck
        .notes
        .extend(reader.facets.note("have no section and are left out"));
    Ok(reader.deck)
}

/// Reads the blocks of a deck, as far as they are wanted, phase by phase.
pub(super) fn read(source: &Source, extent: Extent) -> Result<Reader<'_>, Error> {
    let blocks = source.blocks()?;
    if extent == Extent::Mesh {
        source.check_end(&blocks)?;
    }
    let mut reader = Reader::new(source, extent);
    let mut scoped = expand(&mut reader, &blocks)?;
    // Stable: within a phase the order of the deck is kept.
    scoped.sort_by_key(|scoped| scoped.phase);
    let mut system = (0, Isometry3::identity());
    for Scoped { instance, phase, block } in scoped {
        match phase {
            Phase::Geometry => {
                if system.0 != instance {
                    system = (instance, Isometry3::identity());
                }
                reader.geometry(instance, &mut system.1, block)?;
            }
            Phase::Sets => reader.set(instance, block)?,
            Phase::Surfaces => reader.surface(instance, block)?,
            Phase::Materials => reader.material(block)?,
            Phase::Properties => reader.property(instance, block)?,
            Phase::Constraints => reader.constraint(instance, block)?,
            Phase::History => reader.history(block)?,
        }
    }
    reader.close_coupling()?;
    let idle = reader
        .points
        .iter()
        .filter(|(label, _)| !reader.used_points.contains(*label));
    if let Some((label, (.., line))) = idle.min_by_key(|(label, _)| **label) {
        let name = reader.deck.name(*label);
        let what = "*MASS, *ROTARY INERTIA, *SPRING, *BEAM SECTION or *DISTRIBUTING COUPLING of element";
        return Err(reader.undefined(*line, what, &name));
    }
    Ok(reader)
}
