//! What a run says about its own validity: where the assumptions of the model end.

use super::amplitude::{AmplitudeResult, Fields};
use contact_laws::adhesion::critical_interference;
use contact_laws::{Asperity, AsperityPopulation, Yield};
use joints::interface::Asperities;
use scenes::{Material, Stress, SurfaceEnergy};
use serde::{Deserialize, Serialize};
use zte_assembly::Interface;

/// Shape deviation beyond which the secant and loop formulas, which assume a fixed mode shape, are doubtful.
const LARGEST_SHAPE_DEVIATION: f64 = 0.1;

/// Contact radius over the radius of an asperity up to which formulas of contacts hold: the largest of the computations that those of
/// plastic contact describe (R. L. Jackson and I. Green, J. Tribol. 127 (2005) 343-354).
pub(super) const LARGEST_CONTACT: f64 = 0.41;

/// Validity of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Validity {
    /// Real contact area over nominal area under prestress.
    pub real_contact_area_fraction: Option<f64>,
    /// Area of all quadrature points in contact under prestress over nominal area.
    pub contact_area_fraction_by_points: f64,
    /// The same counted by whole elements with any point in contact.
    pub contact_area_fraction_by_elements: f64,
    /// Interference of one asperity at the onset of yield (m) (mean over the populations): of asperities that yield their own,
    /// else `omega_c` from the material's hardness, if it is given.
    pub yield_onset_interference: Option<f64>,
    /// Fraction of the loaded asperities beyond it under prestress (mean over the points in contact).
    pub yielded_asperity_fraction: Option<f64>,
    /// Largest contact radius of an asperity over its effective radius under prestress.
    #[serde(default)]
    pub contact_over_asperity_radius: Option<f64>,
    /// Share of the elastic pressure on the asperities of that contact circle at which the formulas of contact hold; 1 where they do.
    #[serde(default)]
    pub pressure_share_within_formulas: Option<f64>,
    /// Adhesive over elastic normal traction under prestress: pull-off `2 pi R w` of every loaded asperity, an upper
    /// bound (mean over the points in contact); needs the material's work of adhesion.
    pub adhesive_to_elastic_traction: Option<f64>,
    /// Sliding distance at which a shank would touch its hole (m); pinning is not modelled.
    pub bolt_hole_clearance: Option<f64>,
    /// First amplitude number whose tangential motion exceeds that.
    pub first_beyond_clearance: Option<usize>,
    /// Limit on the shape deviation.
    pub shape_deviation_limit: f64,
    /// First amplitude number beyond it.
    pub first_beyond_shape_deviation: Option<usize>,
    /// First amplitude number that did not converge.
    pub first_not_converged: Option<usize>,
    /// Modal force beyond which bolts of constant tension cannot hold the halves against the mode's inertia, so that there is no
    /// equilibrium (sqrt(kg) m/s^2): bolt loads over the mode's inertia, both along a uniform separation. Where other rigid motions
    /// are free, equilibrium may end earlier. None where something else resists a separation, beyond the round-off of the
    /// stiffness, or the mode has no inertia along it.
    pub separation_modal_force: Option<f64>,
}

impl Validity {
    /// The largest contact radius over the radius of an asperity, if the formulas of contacts do not reach so far.
    pub fn beyond_contact_formulas(&self) -> Option<f64> {
        self.contact_over_asperity_radius
            .filter(|ratio| *ratio > LARGEST_CONTACT)
    }
}

/// Judges a run from its prestressed interface and its amplitudes; `own_onset` is the onset of yield of asperities that yield (m), and
/// `yielding` how they do.
pub(crate) fn assess(
    interface: &Interface,
    asperities: Option<&Asperities>,
    material: Option<&Material>,
    own_onset: Option<f64>,
    yielding: Option<Yield>,
    prestressed: &Fields,
    clearance: Option<f64>,
    separation_modal_force: Option<f64>,
    amplitudes: &[AmplitudeResult],
) -> Validity {
    let operators = interface.operators();
    let area = operators.area();
    let u_n = &prestressed.jump[2];
    let touching: Vec<usize> = (0..u_n.len()).filter(|&p| u_n[p] > 0.0).collect();
    let weight = |p: usize| operators.weights[p];
    let closed: f64 = touching.iter().map(|&p| weight(p)).sum();
    let by_elements: f64 = operators
        .first_point
        .windows(2)
        .filter(|range| (range[0]..range[1]).any(|p| u_n[p] > 0.0))
        .map(|range| operators.weights[range[0]..range[1]].iter().sum::<f64>())
        .sum();
    let element_of = |p: usize| operators.first_point.partition_point(|&first| first <= p) - 1;
    let population = |p: usize| asperities.map(|a| (a, &a.populations[a.of_element[element_of(p)] as usize]));
    // Interference of the asperity that touches first, where it is largest, of each population.
    let mut deepest = vec![0.0_f64; asperities.map_or(0, |a| a.populations.len())];
    for &p in &touching {
        if let Some(asperities) = asperities {
            let of = asperities.of_element[element_of(p)] as usize;
            deepest[of] = deepest[of].max(u_n[p] - asperities.populations[of].gaps().smallest());
        }
    }
    let onset_of = |asperities: &Asperities, population: &AsperityPopulation| {
        if own_onset.is_some() {
            return own_onset;
        }
        let hardness = material?.hardness.map(Stress::si)?;
        Some(critical_interference(
            &asperities.material,
            hardness,
            population.effective_radius(),
        ))
    };
    let law_mean = |of: &dyn Fn(usize) -> Option<f64>, total: f64| {
        touching
            .iter()
            .map(|&p| of(p).map(|v| weight(p) * v))
            .sum::<Option<f64>>()
            .map(|sum| sum / total)
    };
    let first = |beyond: &dyn Fn(&AmplitudeResult) -> bool| amplitudes.iter().position(beyond).map(|i| i + 1);
    let circles = asperities.and_then(|a| contact_over_radius(a, yielding, &deepest));
    Validity {
        real_contact_area_fraction: law_mean(
            &|p| {
                interface
                    .law(p)
                    .and_then(|(law, local)| law.contact_area_ratio(local, u_n[p]))
            },
            area,
        ),
        contact_area_fraction_by_points: (closed / area).min(1.0),
        contact_area_fraction_by_elements: (by_elements / area).min(1.0),
        yield_onset_interference: asperities.and_then(|a| {
            let onsets = a.populations.iter().map(|p| onset_of(a, p));
            Some(onsets.sum::<Option<f64>>()? / a.populations.len() as f64)
        }),
        yielded_asperity_fraction: law_mean(
            &|p| {
                let (asperities, population) = population(p)?;
                let (law, local) = interface.law(p)?;
                law.yielded_fraction(local, u_n[p], onset_of(asperities, population)?)
            },
            closed,
        ),
        contact_over_asperity_radius: circles.map(|(ratio, _)| ratio),
        pressure_share_within_formulas: circles.map(|(_, share)| share),
        adhesive_to_elastic_traction: law_mean(
            &|p| {
                let (_, pair) = population(p)?;
                let work = material?.work_of_adhesion.map(SurfaceEnergy::si)?;
                let pull_off = 2.0 * std::f64::consts::PI * pair.effective_radius() * work;
                let adhesive = pair.density() * pair.gaps().loaded_fraction(u_n[p]) * pull_off;
                Some(adhesive / prestressed.traction[2][p])
            },
            closed,
        ),
        bolt_hole_clearance: clearance,
        first_beyond_clearance: clearance
            .and_then(|clearance| first(&|a| a.fields.as_ref().is_some_and(|f| f.largest_sliding > clearance))),
        shape_deviation_limit: LARGEST_SHAPE_DEVIATION,
        first_beyond_shape_deviation: first(&|a| {
            a.point
                .result
                .as_ref()
                .is_ok_and(|r| r.shape_deviation > LARGEST_SHAPE_DEVIATION)
        }),
        first_not_converged: first(&|a| a.point.result.is_err()),
        separation_modal_force,
    }
}

/// Largest contact radius over the effective radius, from the deepest interference of each population (m), and the share of the elastic
/// pressure there at which it would not be beyond the formulas of contact.
fn contact_over_radius(asperities: &Asperities, yielding: Option<Yield>, deepest: &[f64]) -> Option<(f64, f64)> {
    let ratios = asperities
        .populations
        .iter()
        .zip(deepest)
        .map(|(population, &interference)| {
            let radius = population.effective_radius();
            let asperity = Asperity::try_new(asperities.material, radius, yielding).ok()?;
            let ratio = asperity.published_contact_radius(interference) / radius;
            let gaps = population.gaps();
            // By Hertz, a contact radius grows with the root of the interference.
            let part = (LARGEST_CONTACT / ratio).powi(2).min(1.0);
            let [within, now] =
                [part, 1.0].map(|part| gaps.three_halves_moment(gaps.smallest() + part * interference).0);
            Some((ratio, if part < 1.0 { within / now } else { 1.0 }))
        });
    ratios.into_iter().try_fold((0.0_f64, 1.0), |largest, found| {
        let found = found?;
        Some(if found.0 > largest.0 { found } else { largest })
    })
}
