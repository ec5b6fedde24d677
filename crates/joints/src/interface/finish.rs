//! From roughness parameters of two faces to asperities, and what is reported about them.

use super::population::population;
use super::surface::{bounds, material, set_readings};
use crate::Error;
use contact_laws::{AsperityPopulation, ElasticPair};
use scenes::{Finish, Length, Lengths, Route, Scene, Surface};
use serde::{Deserialize, Serialize};
use surface_characterisation::finish::{
    FaceFinish, FinishError, FlatnessForm, LawInterval, PairFinish, SpectralMoments, Theory, patch_of_element,
};
use surface_characterisation::{ElementSurface, InterferenceRange, Options};
use zte_assembly::{Element, InterfaceMesh};

/// Interferences at which the interval is given, in rms heights of the pair, and their number.
const RANGE: [f64; 2] = [0.05, 8.0];
const SAMPLES: usize = 48;

/// A face as it was understood.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FinishedFace {
    /// Root mean square height (m).
    pub rms: f64,
    /// Moments of the power spectral density along x and y.
    pub moments: SpectralMoments,
    /// Total roughness that one half of the patches exceed, by the theory (m); of the fast route.
    pub total_roughness: Option<f64>,
}

/// The rough surface whose contact with a plane stands for that of the two faces in the theory of Greenwood and Williamson:
/// their moments add. For comparison: the law follows from the readings of the characterisation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GreenwoodWilliamsonParameters {
    /// Bandwidth `m0 m4/m2^2` (-).
    pub bandwidth: f64,
    /// Summits per area (1/m^2).
    pub summit_density: f64,
    /// Radius of the mean curvature of the summits (m).
    pub summit_radius: f64,
    /// Mean height of the summits above the mean plane (m).
    pub mean_summit_height: f64,
    /// Standard deviation of the heights of the summits (m).
    pub summit_deviation: f64,
}

/// What is reported about faces by their roughness parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FinishReport {
    /// Where the law comes from.
    pub route: Route,
    /// Realisations behind the interval.
    pub realisations: usize,
    /// Their seed.
    pub seed: u64,
    /// What the scene does not say and was assumed, one sentence each.
    pub assumptions: Vec<String>,
    /// Top and bottom face.
    pub faces: [FinishedFace; 2],
    /// Grid steps along x and y (m).
    pub step: [f64; 2],
    /// Sides of a patch along x and y (m).
    pub window: [f64; 2],
    /// Moments of the sum of both faces.
    pub sum: SpectralMoments,
    /// Greenwood and Williamson's parameters of that sum after Nayak and McCool.
    pub greenwood_williamson: GreenwoodWilliamsonParameters,
    /// Percentiles of the law of a patch.
    pub interval: LawInterval,
}

impl FinishReport {
    /// Interferences of the interval.
    pub(super) fn range(&self) -> InterferenceRange {
        range(&self.sum)
    }
}

fn range(sum: &SpectralMoments) -> InterferenceRange {
    let [from, to] = RANGE.map(|part| part * sum.m0.sqrt());
    InterferenceRange {
        from,
        to,
        points: SAMPLES,
    }
}

/// The asperities of two faces by their roughness parameters.
#[derive(Clone, Debug)]
pub struct FinishedSurface {
    /// The pair and its patches.
    pub pair: PairFinish,
    /// The patches of the ensemble; none of the fast route.
    pub patches: Vec<ElementSurface>,
    /// Populations of the law: of the patches, or the typical one.
    pub populations: Vec<AsperityPopulation>,
    /// Population of each element.
    pub of_element: Vec<u32>,
    /// Forms of top and bottom face within their flatness.
    pub forms: Option<[FlatnessForm; 2]>,
    /// What is reported.
    pub report: FinishReport,
}

impl FinishedSurface {
    /// Of a scene whose surface is given by roughness parameters, over the elements of `mesh`.
    ///
    /// # Errors
    /// [`scenes::Error::Finish`]; [`Error::NoSamples`] for other surfaces.
    pub fn try_new(scene: &Scene, mesh: &InterfaceMesh) -> Result<Self, Error> {
        let Surface::Finish(finish) = &scene.interfaces.surface else {
            return Err(Error::NoSamples);
        };
        let (faces, assumptions) = finish.faces(&scene.name)?;
        let material = material(scene)?;
        Self::of_faces(scene, finish, mesh, material, faces, assumptions).map_err(|source| {
            scenes::Error::Finish {
                place: scene.name.clone(),
                field: "interfaces.surface.finish".into(),
                source: Box::new(source),
            }
            .into()
        })
    }

    fn of_faces(
        scene: &Scene,
        finish: &Finish,
        mesh: &InterfaceMesh,
        material: ElasticPair,
        faces: [FaceFinish; 2],
        mut assumptions: Vec<String>,
    ) -> Result<Self, FinishError> {
        let outlines = surface_characterisation::ElementOutlines::try_new(
            mesh.nodes.clone(),
            mesh.elements.iter().map(Element::outline).collect(),
        )?;
        let area = (0..outlines.len()).map(|e| outlines.area(e)).sum::<f64>() / outlines.len() as f64;
        let lengths = |lengths: Option<Lengths>| lengths.map(Lengths::si);
        let (pair, assumed) = PairFinish::try_new(faces, lengths(finish.step), lengths(finish.window), area)?;
        assumptions.extend(assumed);

        let sum = pair.faces()[0].moments() + pair.faces()[1].moments();
        let mut options = Options::new(material);
        options.tangential = scene.interfaces.law.tangential;
        options.interference = range(&sum);
        set_readings(&mut options, &finish.readings);
        let (number, seed) = (finish.realisations, finish.seed);
        let elements = mesh.elements.len();
        let (patches, populations, of_element, drawn, total_roughness);
        match finish.route {
            Route::Ensemble => {
                patches = pair.characterised(number, seed, &options)?;
                let found = patches.iter().map(|patch| population(scene, &patch.population));
                populations = found
                    .collect::<Result<Vec<_>, _>>()
                    .map_err(|error| FinishError::Law(error.to_string()))?;
                drawn = None;
                let patch_of = |element| patch_of_element(seed, element, number) as u32;
                of_element = (0..elements).map(patch_of).collect();
                total_roughness = [None; 2];
                assumptions.push("each element takes one of the realisations by lot".into());
            }
            Route::Fast => {
                let theory = Theory::try_new(&pair, &options)?;
                patches = Vec::new();
                populations = vec![theory.population()?];
                drawn = Some(theory.realisations(number, seed)?);
                of_element = vec![0; elements];
                total_roughness = theory.total_roughness().map(Some);
                assumptions.push("all elements take the law of a typical patch".into());
            }
        }
        let interval = LawInterval::try_new(
            drawn.as_ref().unwrap_or(&populations),
            options.material,
            options.tangential,
            options.interference.samples()?,
        )?;
        let forms = finish.flatness.map(Length::si).map(|tolerance| {
            assumptions.push(format!(
                "each face fills its flatness tolerance of {tolerance:.3e} m with Legendre polynomials up to order 3 in x and y"
            ));
            let [x, y] = [0, 1].map(|axis| bounds(mesh, axis));
            [0, 1].map(|side| FlatnessForm::new([x.0, y.0], [x.1, y.1], tolerance, seed, side))
        });
        if forms.is_none() {
            assumptions.push("flat faces, as no flatness is given".into());
        }
        let isotropic = sum.isotropic();
        let faces = pair.faces().each_ref().map(|face| (face.rms(), face.moments()));
        let report = FinishReport {
            route: finish.route,
            realisations: number,
            seed,
            assumptions,
            faces: std::array::from_fn(|side| FinishedFace {
                rms: faces[side].0,
                moments: faces[side].1,
                total_roughness: total_roughness[side],
            }),
            step: pair.step(),
            window: pair.window(),
            sum,
            greenwood_williamson: GreenwoodWilliamsonParameters {
                bandwidth: isotropic.bandwidth(),
                summit_density: isotropic.summit_density(),
                summit_radius: isotropic.summit_radius(),
                mean_summit_height: isotropic.mean_summit_height(),
                summit_deviation: isotropic.summit_deviation(),
            },
            interval,
        };
        Ok(Self {
            pair,
            patches,
            populations,
            of_element,
            forms,
            report,
        })
    }
}
