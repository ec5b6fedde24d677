//! Pressures that laws are made for, and what is found for them once.

use crate::Error;
use contact_laws::{Asperity, AsperityPopulation, TangentialReading};
use scenes::Bins;
use std::sync::{Mutex, PoisonError};

/// Pressures that a law is made for.
#[derive(Clone, Copy)]
pub(super) struct Pressures<'a> {
    /// Of the bolts over the whole interface (Pa).
    pub(super) mean: f64,
    /// At the points under the bolt loads (Pa); none before they are known.
    pub(super) at_rest: Option<&'a [f64]>,
    /// What is found for these once for all parts.
    pub(super) counted: &'a Counted,
}

/// A number of bins or springs, and its relative errors: normal traction, tangential stiffness, dissipated energy.
pub(super) type Count = (usize, [f64; 3]);

/// Numbers of bins or springs that were found for populations, with their errors: parts of an interface with the same surface find them once.
#[derive(Default)]
pub(super) struct Counted(Mutex<Vec<(Counting, Count)>>);

/// What a number of parts is found for.
#[derive(PartialEq)]
pub(super) struct Counting {
    /// Asperities, populations and the interferences up to which they are expected (m).
    pub(super) of: Vec<(Asperity, AsperityPopulation, f64)>,
    pub(super) reading: TangentialReading,
    pub(super) bins: Bins,
    /// Springs, about interferences at rest unless `bins` are equally spaced; otherwise bins.
    pub(super) are_springs: bool,
}

impl Counted {
    /// What is known of these, or is `found` now.
    pub(super) fn or(&self, of: Counting, found: impl FnOnce() -> Result<Count, Error>) -> Result<Count, Error> {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = all().iter().find(|(known, _)| *known == of).map(|(_, found)| *found);
        if let Some(known) = known {
            return Ok(known);
        }
        // Two threads may find the same: one that waits could hold up what the other one waits for.
        let found = found()?;
        all().push((of, found));
        Ok(found)
    }
}
