//! Elements of a scanned interface that stand for all.

use anyhow::{Context, Result};
use contact_laws::{ContactCurves, FittedCurves};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use scenes::{Curves, Length, ParameterSet, Parameters, Per, Stress, Surface};
use surface_characterisation::ElementSurface;

/// Seed of the element that is drawn.
const SEED: u64 = 2020;

/// Interference at which elements are ranked (m): about what the bolts close.
const WORKING_INTERFERENCE: f64 = 5e-6;

/// Elements that may stand for all.
pub(crate) struct Representatives<'a> {
    /// Drawn by [`SEED`].
    pub(crate) drawn: &'a ElementSurface,
    /// At the tenth percentile of the fitted traction at the working interference.
    pub(crate) soft: &'a ElementSurface,
    /// At the fiftieth.
    pub(crate) median: &'a ElementSurface,
    /// At the ninetieth.
    pub(crate) stiff: &'a ElementSurface,
}

impl<'a> Representatives<'a> {
    /// Ranks the elements.
    ///
    /// # Errors
    /// No elements, or a fit that is refused.
    pub(crate) fn try_new(elements: &'a [ElementSurface]) -> Result<Self> {
        let mut rng = Pcg64::seed_from_u64(SEED);
        let drawn = ((u128::from(rng.next_u64()) * elements.len() as u128) >> 64) as usize;
        let mut ranked = elements
            .iter()
            .map(|element| {
                let tangential = element.tangential.each_ref().map(|fit| fit.parameters);
                let curves = FittedCurves::try_new(element.normal.parameters, tangential)?;
                Ok((curves.normal(WORKING_INTERFERENCE).0, element))
            })
            .collect::<Result<Vec<_>>>()?;
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = |tenths: usize| {
            let found = ranked
                .get(ranked.len() * tenths / 10)
                .context("the scan has no elements")?;
            anyhow::Ok(found.1)
        };
        Ok(Self {
            drawn: elements.get(drawn).context("the scan has no elements")?,
            soft: at(1)?,
            median: at(5)?,
            stiff: at(9)?,
        })
    }
}

/// A surface of these curves: one for the interface, or one for each element.
pub(crate) fn given(curves: Vec<Curves>) -> Surface {
    let per = if curves.len() == 1 {
        Per::Interface
    } else {
        Per::Element
    };
    let set = |curves| ParameterSet {
        curves,
        mu: None,
        gap: Length::default(),
        preload: Stress::default(),
    };
    Surface::Parameters(Parameters {
        per,
        sets: curves.into_iter().map(set).collect(),
    })
}
