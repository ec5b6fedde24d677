//! What entries make their scenes from: structure, surfaces and the settings of the paper.

use super::runs;
use crate::elements::given;
use analyses::error_bar::ErrorBar;
use anyhow::{Result, anyhow};
use brake_reuss_beam::BrakeReussBenchmark;
use joint_model::benchmark::Benchmark as _;
use joint_model::benchmark::RefinementLevel;
use joints::interface::ScannedSurface;
use joints::progress::Silent;
use joints::structure::Structure;
use reports::plot::amplitude_label;
use scenes::{Gap, LawKind, Length, Scene, Surface, SyntheticScan};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::PathBuf;
use std::sync::OnceLock;
use surface_characterisation::ElementSurface;
use zte_assembly::InterfaceMesh;

/// What entries make their scenes from.
pub(crate) struct Inputs {
    quick: bool,
    pub(super) cache: Option<PathBuf>,
    /// The scene that all others are made from.
    scene: Scene,
    pub(crate) structure: Structure,
    pub(crate) mesh: InterfaceMesh,
    scan: OnceLock<Result<ScannedSurface, String>>,
}

/// The synthetic pair in the place of the paper's scans.
pub(crate) fn synthetic() -> SyntheticScan {
    SyntheticScan::default()
}

impl Inputs {
    pub(super) fn try_new(quick: bool, cache: Option<PathBuf>) -> Result<Self> {
        let mut scene = crate::paper_scene("paper")?;
        if quick {
            scene.model.refinement = RefinementLevel::Quick;
        }
        let structure = Structure::try_new(&scene, &Silent)?;
        Ok(Self {
            quick,
            cache,
            mesh: structure.interface().clone(),
            scene,
            structure,
            scan: OnceLock::new(),
        })
    }

    /// A scene of prestress and linearised modes alone, with measured statistics and no gap.
    pub(crate) fn scene(&self, name: &str) -> Scene {
        let mut scene = self.scene.clone();
        scene.name = name.into();
        scene.analyses.backbone.amplitudes = 0;
        scene
    }

    /// The same with a backbone.
    pub(crate) fn backbone(&self, name: &str, amplitudes: usize, from: f64, to: f64) -> Scene {
        let mut scene = self.scene(name);
        scene.analyses.backbone.amplitudes = if self.quick { amplitudes.min(6) } else { amplitudes };
        scene.analyses.backbone.vertices_per_quarter = if self.quick { 4 } else { 8 };
        scene.analyses.backbone.amplitude_from = Length::from_si(from);
        scene.analyses.backbone.amplitude_to = Length::from_si(to);
        scene.output.fields_at = Some(Vec::new());
        scene
    }

    /// A scene of the benchmark's own, on the mesh of the command.
    ///
    /// # Errors
    /// Of a scene that is not there.
    pub(crate) fn benchmark(&self, name: &str) -> Result<Scene> {
        let text = BrakeReussBenchmark.scene(name);
        let text = text.ok_or_else(|| anyhow!("the benchmark has no scene {name}"))?;
        let mut scene = Scene::from_json(text, name, name, &[&BrakeReussBenchmark])?;
        if self.quick {
            scene.model.refinement = self.scene(name).model.refinement;
            scene.analyses.backbone.amplitudes = scene.analyses.backbone.amplitudes.min(6);
            scene.analyses.backbone.vertices_per_quarter = 4;
        }
        scene.output.fields_at = Some(Vec::new());
        Ok(scene)
    }

    /// The same as a static scene of the paper: mu = 0.6 and 25 points per element.
    pub(crate) fn prestress(&self, name: &str, gap: Gap) -> Scene {
        let mut scene = self.scene(name);
        scene.interfaces.gap = gap;
        scene.interfaces.mu = 0.6;
        scene.interfaces.points_per_direction = 5;
        scene
    }

    /// Title of an axis of amplitudes.
    pub(crate) fn amplitude_axis(&self) -> String {
        format!("{} [m]", amplitude_label(&self.structure.joint.response))
    }

    /// What an entry made of its own inputs and the structure in an earlier run, or makes now.
    ///
    /// # Errors
    /// Of `make`, and of the folder it is stored in.
    pub(crate) fn kept<T: Serialize + DeserializeOwned>(
        &self,
        inputs: &impl Serialize,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        runs::kept(self.cache.as_deref(), &(self.quick, inputs), make)
    }

    /// The synthetic pair, characterised once.
    ///
    /// # Errors
    /// Of the characterisation.
    pub(crate) fn scan(&self) -> Result<&ScannedSurface> {
        let found = self
            .scan
            .get_or_init(|| self.scanned(synthetic()).map_err(|error| format!("{error:#}")));
        found.as_ref().map_err(|reason| anyhow!("{reason}"))
    }

    /// A synthetic pair, characterised.
    ///
    /// # Errors
    /// Of the generator and the characterisation.
    pub(crate) fn scanned(&self, scan: SyntheticScan) -> Result<ScannedSurface> {
        let mut scene = self.scene("");
        scene.interfaces.surface = Surface::SyntheticScan(scan);
        Ok(ScannedSurface::try_new(&scene, &self.mesh)?)
    }
}

/// Gives a scene the roughness of the synthetic pair, element by element, in the paper's fitted form.
pub(crate) fn per_element(mut scene: Scene) -> Scene {
    scene.interfaces.surface = Surface::SyntheticScan(synthetic());
    scene.interfaces.law.kind = LawKind::Fitted;
    scene
}

/// A static scene on flat faces with the fit of one element everywhere.
pub(super) fn uniform(inputs: &Inputs, name: &str, element: &ElementSurface) -> Scene {
    let mut scene = inputs.prestress(name, Gap::Flat);
    scene.interfaces.surface = given(vec![joints::interface::curves_of_element(element)]);
    scene
}

/// How far frequencies of a scene may be from the limit of its mesh, in words.
pub(crate) fn mesh_error(scene: &Scene) -> String {
    match ErrorBar::of(scene).frequency_relative {
        Some(error) => format!("up to {:.1} %", 100.0 * error),
        None => "not known".into(),
    }
}
