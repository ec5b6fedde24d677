//! Contact of scanned faces by boundary elements.

use super::stiffness::{as_dyn, interference_at};
use super::surface::ScannedSurface;
use super::work::Work;
use crate::Error;
use crate::progress::Stage;
use crate::store::cache;
use crate::store::key::{Key, KeyBuilder};
use contact_laws::{AsperitySumCurves, ContactCurves, ElasticPair, SampledCurves, TangentialReading};
use scenes::{Gap, LawKind, Scene};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use surface_characterisation::PressedElement;

/// Most elements whose contact is computed; others have that of the nearest of them.
const MOST_ELEMENTS: usize = 32;

/// Curves by boundary elements.
pub(super) struct Pressed {
    elements: Vec<PressedElement>,
    /// Which of them each population has.
    of_population: Vec<u32>,
}

/// What the contact of elements depends on.
fn key(work: Work<'_>, scanned: &ScannedSurface, chosen: &[usize]) -> Key {
    let mut key = KeyBuilder::new(work.options.build.as_deref());
    key.text("boundary elements");
    key.text(&format!("{:?}", scanned.found.options));
    for face in &scanned.faces {
        key.integers([face.nx(), face.ny()].map(|n| n as u64));
        key.numbers(face.step().into_iter().chain(face.origin()));
        let points = (0..face.ny()).flat_map(|j| (0..face.nx()).map(move |i| (i, j)));
        key.numbers(points.map(|(i, j)| face.height(i, j).unwrap_or(f64::NAN)));
    }
    for &element in chosen {
        let (low, high) = scanned.outlines.element_bounds(element);
        key.numbers(low.into_iter().chain(high));
    }
    key.finish()
}

/// What is reported about boundary elements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BoundaryElementsReport {
    /// Interface elements whose contact was computed; others have that of the nearest of them.
    pub elements: usize,
    /// Fewest points of the grid along x and y.
    pub points: [usize; 2],
    /// Most points of the top face from one of them to the next along x and y.
    pub stride: [usize; 2],
    /// Largest part of points without data, which cannot touch.
    pub missing: f64,
    /// Smallest mean pressure that is resolved everywhere (Pa).
    pub resolved_from: f64,
    /// Normal stiffness of the asperity sums over that of boundary elements at the mean pressure.
    pub sums_to_boundary_elements: f64,
}

impl Pressed {
    /// Those of a scene's scans, if its law asks for them.
    pub(super) fn of(work: Work<'_>, scene: &Scene, scanned: &ScannedSurface) -> Result<Option<Arc<Self>>, Error> {
        if scene.interfaces.law.kind != LawKind::BoundaryElements {
            return Ok(None);
        }
        let ScannedSurface {
            faces, outlines, found, ..
        } = scanned;
        let n = outlines.len();
        let count = n.min(MOST_ELEMENTS);
        let chosen: Vec<usize> = (0..count).map(|i| (2 * i + 1) * n / (2 * count)).collect();
        let stored = (work.options.cache.as_deref()).map(|directory| (directory, key(work, scanned, &chosen)));
        let stored = stored.as_ref();
        let elements = match stored.and_then(|(directory, key)| cache::load_elements(directory, key)) {
            Some(elements) => {
                work.progress
                    .note("the contact by boundary elements was read from the cache");
                elements
            }
            None => {
                let begun = AtomicUsize::new(0);
                let next = || {
                    let done = begun.fetch_add(1, Ordering::Relaxed) as f64 / count as f64;
                    work.progress.fraction(Stage::Characterise, done);
                    work.limits.stops()
                };
                let elements = found.pressed(&next, [&faces[0], &faces[1]], outlines, &chosen)?;
                let error = stored.and_then(|(directory, key)| cache::store_elements(directory, key, &elements).err());
                if let Some(error) = error {
                    work.progress
                        .note(&format!("the contact by boundary elements was not cached: {error}"));
                }
                elements
            }
        };
        let nearest = |element: usize| {
            let middle = outlines.middle(element);
            let apart = |other: usize| {
                let at = outlines.middle(chosen[other]);
                (at[0] - middle[0]).hypot(at[1] - middle[1])
            };
            (0..count).min_by(|a, b| apart(*a).total_cmp(&apart(*b))).unwrap_or(0) as u32
        };
        Ok(Some(Arc::new(Self {
            of_population: (0..n).map(nearest).collect(),
            elements,
        })))
    }

    /// The curves of every population.
    ///
    /// # Errors
    /// Of scenes that scale asperities, or read their tangential stiffness in another way.
    pub(super) fn curves(&self, scene: &Scene, material: ElasticPair) -> Result<Vec<SampledCurves>, Error> {
        let refused = |reason| Err(Error::BoundaryElements { reason });
        if !scene.interfaces.scale.keeps_asperities() {
            return refused(
                "knows no asperities; leave interfaces.scale.asperity_radius, asperity_density and asperity_height out",
            );
        }
        if scene.interfaces.law.tangential != TangentialReading::Mindlin {
            return refused("has the tangential stiffness of elastic contact; leave interfaces.law.tangential out");
        }
        let modulus = material.composite_modulus();
        let curve = |&number: &u32| {
            let PressedElement {
                interferences,
                pressures,
                areas,
                ..
            } = &self.elements[number as usize];
            // Flat faces touch first everywhere; the gap of scans counts from where the tallest peaks would meet.
            let first = if scene.interfaces.gap == Gap::Scan {
                0.0
            } else {
                interferences[0]
            };
            let interferences = interferences.iter().map(|u| u - first).collect();
            let tractions = pressures.iter().map(|p| p * modulus).collect();
            SampledCurves::try_new(interferences, tractions, areas.clone(), material.mindlin_ratio())
        };
        let curves = self.of_population.iter().map(curve);
        Ok(curves.collect::<Result<_, _>>()?)
    }

    /// What is reported; curves of the sums and by boundary elements, compared at a mean pressure (Pa).
    pub(super) fn report(
        &self,
        material: ElasticPair,
        sums: &[AsperitySumCurves],
        curves: &[SampledCurves],
        pressure: f64,
    ) -> BoundaryElementsReport {
        let elements = &self.elements;
        let modulus = material.composite_modulus();
        let at_pressure = |curves: &[&dyn ContactCurves]| -> f64 {
            curves
                .iter()
                .map(|curves| curves.normal(interference_at(*curves, pressure)).1)
                .sum()
        };
        let largest = |value: &dyn Fn(&PressedElement) -> f64| elements.iter().map(value).fold(0.0, f64::max);
        BoundaryElementsReport {
            elements: elements.len(),
            points: [0, 1].map(|axis| elements.iter().map(|of| of.points[axis]).min().unwrap_or(0)),
            stride: [0, 1].map(|axis| elements.iter().map(|of| of.stride[axis]).max().unwrap_or(1)),
            missing: largest(&|of| of.missing),
            resolved_from: modulus * largest(&|of| of.resolved_from),
            sums_to_boundary_elements: at_pressure(&as_dyn(sums)) / at_pressure(&as_dyn(curves)),
        }
    }
}
