//! How the gap depends on where the faces lie against each other.

use crate::error::SurfaceError;
use crate::gap::Bilinear;
use crate::options::Options;
use crate::partition::ElementOutlines;
use crate::registration::Registration;
use crate::scan::{gaps, scan_face};
use crate::topography::HeightMap;

/// What another registration does to the gap, over the middles of all elements, weighted by their areas.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct GapChange {
    /// The registration.
    pub registration: Registration,
    /// Mean change of the gap (m): a rigid approach would undo it.
    pub mean: f64,
    /// Root mean square change about that mean (m): the change of the gap's shape.
    pub rms: f64,
    /// Largest change about the mean (m).
    pub largest: f64,
}

/// How the gap depends on the registration: the change against `options.registration` for each of `registrations`.
///
/// The bottom face is characterised anew for each one, without responses and fits. What a change does to a
/// backbone is asked by characterising under [`Options::registration`].
///
/// # Errors
/// As [`crate::characterise`]; a shift that leaves an element without data names it.
pub fn registration_study(
    top: &HeightMap,
    bottom: &HeightMap,
    elements: &ElementOutlines,
    options: &Options,
    registrations: &[Registration],
) -> Result<Vec<GapChange>, SurfaceError> {
    let top = scan_face("top", top, elements, Registration::default(), options)?;
    let under = |registration| -> Result<Vec<Bilinear>, SurfaceError> {
        let bottom = scan_face("bottom", bottom, elements, registration, options)?;
        Ok(gaps(&top, &bottom))
    };
    let base = under(options.registration)?;
    let area: f64 = (0..elements.len()).map(|e| elements.area(e)).sum();
    registrations
        .iter()
        .map(|&registration| {
            let found = under(registration)?;
            let change: Vec<f64> = (0..elements.len())
                .map(|e| found[e].at(elements.middle(e)) - base[e].at(elements.middle(e)))
                .collect();
            let weighted = |of: &dyn Fn(f64) -> f64| -> f64 {
                change
                    .iter()
                    .enumerate()
                    .map(|(e, d)| elements.area(e) / area * of(*d))
                    .sum()
            };
            let mean = weighted(&|d| d);
            Ok(GapChange {
                registration,
                mean,
                rms: weighted(&|d| (d - mean).powi(2)).sqrt(),
                largest: change.iter().fold(0.0, |m: f64, d| m.max((d - mean).abs())),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registration::tests::{face, outlines};
    use contact_laws::ElasticPair;

    #[test]
    fn a_tilt_tilts_the_gap_and_a_shift_moves_waviness() {
        let steel = ElasticPair {
            youngs_modulus: 192.85e9,
            poisson_ratio: 0.29,
        };
        let (top, bottom) = (face(1, |_| false), face(2, |_| false));
        let study = |registrations: &[Registration]| {
            registration_study(&top, &bottom, &outlines(), &Options::new(steel), registrations).unwrap()
        };
        let still = Registration::default();
        let tilted = Registration {
            tilt: [1e-3, 0.0],
            ..still
        };
        let shifted = Registration {
            shift: [200e-6, 0.0],
            ..still
        };
        let [none, tilt, shift] = study(&[still, tilted, shifted]).try_into().unwrap();
        assert_eq!((none.mean, none.rms, none.largest), (0.0, 0.0, 0.0));
        // Element middles at +-1.5, 4.5, 7.5 mm with a hole at -1.5 mm in one row of four.
        let x: Vec<f64> = (0..24)
            .filter(|e| *e != 8)
            .map(|e| f64::from(e % 6) * 3e-3 - 7.5e-3)
            .collect();
        let mean = x.iter().sum::<f64>() / 23.0;
        let rms = (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 23.0).sqrt();
        assert!((tilt.rms / (1e-3 * rms) - 1.0).abs() < 1e-3, "{tilt:?}");
        assert!(
            (tilt.largest / (1e-3 * (7.5e-3 + mean.abs())) - 1.0).abs() < 1e-2,
            "{tilt:?}"
        );
        // The reference is the face's tallest point, which rises with the tilt: the mean gap opens by at most 9 um.
        assert!(tilt.mean.abs() < 9e-6);
        // 200 um against correlation lengths of 300 um in elements of 3 mm: some other tallest peaks, no other form.
        assert!(shift.rms > 0.0 && shift.rms < 2e-6, "{shift:?}");
        assert!(matches!(
            registration_study(
                &top,
                &bottom,
                &outlines(),
                &Options::new(steel),
                &[Registration {
                    shift: [15e-3, 0.0],
                    ..still
                }]
            ),
            Err(SurfaceError::TooFewPoints { face: "bottom", .. })
        ));
    }
}
