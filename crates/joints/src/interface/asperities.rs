//! Asperities of an interface: populations, which one each element has, and the gap of the surface they belong to.

use super::finish::{FinishReport, FinishedSurface};
use super::population::population;
use super::pressed::Pressed;
use super::surface::{FileReport, ScannedSurface, material};
use super::work::Work;
use crate::Error;
use contact_laws::{
    AsperityPopulation, AsperitySumCurves, CurveFactors, ElasticPair, GapDistribution, SampledCurves, TangentialReading,
};
use joint_model::benchmark::MeasuredSurface;
use scenes::{Gap, LawKind, Scale, Scene};
use std::sync::Arc;
use surface_characterisation::Characterisation;
use surface_characterisation::finish::FlatnessForm;
use zte_assembly::{InterfaceMesh, Operators};

/// Asperities of the interface: populations, and which one each element has.
pub struct Asperities {
    /// As the scene scales them.
    pub populations: Vec<AsperityPopulation>,
    /// As they are known, where the scene scales them.
    known: Option<Vec<AsperityPopulation>>,
    /// Factor of the scene on differences in height.
    height: f64,
    /// Number of the asperities of each interface element.
    pub of_element: Vec<u32>,
    /// Of both faces.
    pub material: ElasticPair,
    pub(super) scan: Option<Arc<(Characterisation, Vec<FileReport>)>>,
    /// Contact of the scans by boundary elements, where the law asks for it.
    pub(super) pressed: Option<Arc<Pressed>>,
    /// Of faces by their roughness parameters: what is reported, and the forms within their flatness.
    pub(super) finish: Option<Arc<(FinishReport, Option<[FlatnessForm; 2]>)>>,
}

/// The asperities of a measured surface.
///
/// # Errors
/// Of statistics that are none.
pub fn measured_population(surface: &MeasuredSurface) -> Result<AsperityPopulation, Error> {
    let values = surface.gap_quantiles;
    let last = (values.len() - 1) as f64;
    let probabilities: Vec<f64> = (0..values.len()).map(|i| i as f64 / last).collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, values)?;
    let radii = [surface.effective_radius; 2];
    Ok(AsperityPopulation::try_new(gaps, surface.asperities_per_area, radii)?)
}

impl Asperities {
    /// Measured statistics, the same everywhere.
    pub(super) fn measured(surface: &MeasuredSurface, scene: &Scene, mesh: &InterfaceMesh) -> Result<Self, Error> {
        Self {
            populations: vec![measured_population(surface)?],
            known: None,
            height: 1.0,
            of_element: vec![0; mesh.elements.len()],
            material: material(scene)?,
            scan: None,
            pressed: None,
            finish: None,
        }
        .scaled(&scene.interfaces.scale)
    }

    /// Those of two faces by their roughness parameters.
    pub(super) fn finished(scene: &Scene, mesh: &InterfaceMesh) -> Result<Self, Error> {
        let FinishedSurface {
            populations,
            of_element,
            forms,
            report,
            ..
        } = FinishedSurface::try_new(scene, mesh)?;
        Self {
            populations,
            known: None,
            height: 1.0,
            of_element,
            material: material(scene)?,
            scan: None,
            pressed: None,
            finish: Some(Arc::new((report, forms))),
        }
        .scaled(&scene.interfaces.scale)
    }

    /// Those of two scans, element by element.
    pub(super) fn scanned(scene: &Scene, mesh: &InterfaceMesh, work: Work<'_>) -> Result<Self, Error> {
        let scanned = ScannedSurface::within(work.limits, scene, mesh)?;
        let pressed = Pressed::of(work, scene, &scanned)?;
        let ScannedSurface { found, files, .. } = scanned;
        let populations = found.elements.iter().map(|e| population(scene, &e.population));
        Self {
            populations: populations.collect::<Result<_, Error>>()?,
            known: None,
            height: 1.0,
            of_element: (0..mesh.elements.len() as u32).collect(),
            material: material(scene)?,
            scan: Some(Arc::new((found, files))),
            pressed,
            finish: None,
        }
        .scaled(&scene.interfaces.scale)
    }

    /// Other populations on the same elements.
    pub(super) fn with_populations(&self, populations: Vec<AsperityPopulation>, scale: &Scale) -> Result<Self, Error> {
        Self {
            populations,
            known: None,
            height: 1.0,
            of_element: self.of_element.clone(),
            material: self.material,
            scan: None,
            pressed: None,
            finish: self.finish.clone(),
        }
        .scaled(scale)
    }

    /// The same asperities in a scene with another scale and material.
    pub(super) fn varied(&self, scene: &Scene) -> Result<Self, Error> {
        Self {
            populations: self.known().to_vec(),
            known: None,
            height: 1.0,
            of_element: self.of_element.clone(),
            material: material(scene)?,
            scan: self.scan.clone(),
            pressed: self.pressed.clone(),
            finish: self.finish.clone(),
        }
        .scaled(&scene.interfaces.scale)
    }

    /// The populations before the scene scales them.
    fn known(&self) -> &[AsperityPopulation] {
        self.known.as_deref().unwrap_or(&self.populations)
    }

    fn scaled(mut self, scale: &Scale) -> Result<Self, Error> {
        if scale.keeps_asperities() {
            return Ok(self);
        }
        let scaled = self
            .populations
            .iter()
            .map(|known| known.scaled(scale.asperity_height, scale.asperity_density, scale.asperity_radius));
        let scaled = scaled.collect::<Result<_, _>>()?;
        self.known = Some(std::mem::replace(&mut self.populations, scaled));
        self.height = scale.asperity_height;
        Ok(self)
    }

    /// The sums of the populations as they are known, each with the factors from its curves to those of the scaled one; none where the
    /// scene does not scale them. Tables and fits are made of these, so that they change smoothly with the scale.
    pub(super) fn known_sums(
        &self,
        reading: TangentialReading,
        scaled: &[AsperitySumCurves],
    ) -> Result<Option<Vec<(AsperitySumCurves, CurveFactors)>>, Error> {
        let Some(known) = &self.known else { return Ok(None) };
        let sums = known.iter().zip(scaled).map(|(known, scaled)| {
            let known = AsperitySumCurves::try_new(known.clone(), self.material, reading)?;
            let factors = known.factors_to(scaled, self.height);
            Ok((known, factors))
        });
        sums.collect::<Result<_, Error>>().map(Some)
    }

    /// Those of parts that lie side by side, in their order. None of no parts.
    pub(super) fn joined(parts: Vec<&Self>) -> Option<Self> {
        let mut joined = Self {
            populations: Vec::new(),
            known: None,
            height: 1.0,
            of_element: Vec::new(),
            material: parts.first()?.material,
            scan: None,
            pressed: None,
            finish: None,
        };
        for part in parts {
            let first = joined.populations.len() as u32;
            joined
                .of_element
                .extend(part.of_element.iter().map(|population| first + population));
            joined.populations.extend(part.populations.iter().cloned());
        }
        Some(joined)
    }

    /// The curves of every population by boundary elements, if the law asks for them.
    pub(super) fn pressed_curves(&self, scene: &Scene) -> Result<Option<Vec<SampledCurves>>, Error> {
        match (scene.interfaces.law.kind, self.pressed.as_deref()) {
            (LawKind::BoundaryElements, Some(pressed)) => Ok(Some(pressed.curves(scene, self.material)?)),
            (LawKind::BoundaryElements, None) => Err(Error::BoundaryElements {
                reason: "needs the scans themselves; give interfaces.surface.scans, and no realisations of asperities, or take another law",
            }),
            _ => Ok(None),
        }
    }

    pub(super) fn sums(&self, reading: TangentialReading) -> Result<Vec<AsperitySumCurves>, Error> {
        let curves = self
            .populations
            .iter()
            .map(|p| AsperitySumCurves::try_new(p.clone(), self.material, reading));
        Ok(curves.collect::<Result<_, _>>()?)
    }

    /// Gap per point as it is known (m).
    pub(super) fn gap(&self, scene: &Scene, operators: &Operators, element_of: &[u32]) -> Vec<f64> {
        let measured = scene.measured_gap();
        let gap = |(&[x, y], &element): (&[f64; 2], &u32)| match (&measured, scene.interfaces.gap, self.scan.as_deref())
        {
            (Some(measured), ..) => (measured.gap)([x, y]),
            (None, Gap::Scan, Some((scan, _))) => scan.elements[element as usize].gap.at([x, y]),
            _ => 0.0,
        };
        if let Some((_, Some(forms))) = self.finish.as_deref() {
            let approach = |&x: &[f64; 2]| forms[0].height(x) + forms[1].height(x);
            let heights: Vec<f64> = operators.positions.iter().map(approach).collect();
            let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            return heights.into_iter().map(|z| highest - z).collect();
        }
        operators.positions.iter().zip(element_of).map(gap).collect()
    }
}
