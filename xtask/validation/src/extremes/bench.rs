//! The scene that the cases start from, and ways to run it.

use analyses::{Error, Prepared, Run, run};
use anyhow::{Context, Result, bail};
use joint_model::benchmark::RefinementLevel;
use joint_model::{Bodies, MeshedBodies};
use joints::Options;
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::{ContactStiffness, Curves, Elastic, Length, ParameterSet, Parameters, Per, Scene, Stress, Surface};
use std::path::PathBuf;

/// The scene of all cases as it is before anything is done to it, and what came of that.
pub(super) struct Bench {
    pub(super) scene: Scene,
    pub(super) base: Run,
    pub(super) full: bool,
    /// A folder that goes with the bench.
    pub(super) folder: PathBuf,
}

impl Drop for Bench {
    fn drop(&mut self) {
        // What cannot be removed is left to the system's own cleaning.
        drop(std::fs::remove_dir_all(&self.folder));
    }
}

impl Bench {
    /// On the mesh of the default scene if it is `full`, else on the coarse one.
    pub(super) fn try_new(full: bool) -> Result<Self> {
        let mut scene = crate::paper_scene(if full { "brb-paper-flat" } else { "brb-quick" })?;
        if !full {
            scene.model.refinement = RefinementLevel::Quick;
        }
        // Stuck, at the onset of slip, in partial slip.
        scene.analyses.backbone.amplitude_from = Length::from_si(1e-6);
        scene.analyses.backbone.amplitude_to = Length::from_si(1e-4);
        scene.analyses.backbone.amplitudes = 3;
        scene.analyses.backbone.vertices_per_quarter = 4;
        let folder = std::env::temp_dir().join(format!("joint-extremes-{}", std::process::id()));
        std::fs::create_dir_all(&folder).with_context(|| format!("making the folder {}", folder.display()))?;
        let base =
            run(&scene, &Options::cached(&folder), &Silent).context("running the scene that all cases start from")?;
        base.checkpoints.remove();
        Ok(Self {
            scene,
            base,
            full,
            folder,
        })
    }

    /// Reduced models are taken from the folder of the bench.
    pub(super) fn options(&self) -> Options {
        Options::cached(&self.folder)
    }

    /// Runs a scene.
    pub(super) fn run_scene(&self, scene: &Scene) -> Result<Run, Error> {
        let run = run(scene, &self.options(), &Silent)?;
        run.checkpoints.remove();
        Ok(run)
    }

    /// The scene after a change.
    pub(super) fn changed(&self, change: impl FnOnce(&mut Scene)) -> Scene {
        let mut scene = self.scene.clone();
        change(&mut scene);
        scene
    }

    /// Runs the scene after a change.
    pub(super) fn run(&self, change: impl FnOnce(&mut Scene)) -> Result<Run, Error> {
        self.run_scene(&self.changed(change))
    }

    /// Runs the scene on its structure after a change of the mesh.
    pub(super) fn run_on_changed(
        &self,
        change: impl FnOnce(&mut Structure, &mut Scene) -> Result<()>,
    ) -> Result<Result<Run, Error>> {
        let mut scene = self.scene.clone();
        let mut structure = self.structure()?;
        change(&mut structure, &mut scene)?;
        // These structures occur once.
        let prepared = Prepared::try_new(&scene, &structure, &Options::default(), &Silent);
        Ok(prepared.and_then(|prepared| prepared.solve(&Silent)))
    }

    /// The structure of the scene.
    pub(super) fn structure(&self) -> Result<Structure, Error> {
        Ok(Structure::try_new(&self.scene, &Silent)?)
    }

    /// First frequency of the scene without contact and with a stuck interface (Hz), beyond which none can be.
    pub(super) fn bounds(&self) -> [f64; 2] {
        let (facts, reduced) = (&self.base.model.facts, &self.base.model.reduced);
        [facts.unstressed_frequencies_hz[0], reduced.stuck_frequencies[0]]
    }

    /// Constant stiffnesses of the size that the law of the scene has at the mean pressure, with a gap for each element.
    pub(super) fn elastic(&self, tangential: f64, gaps: &dyn Fn(usize) -> f64) -> Surface {
        let normal = ContactStiffness::from_si(self.base.law().normal_stiffness);
        let n = self.base.joint.mesh.elements.len();
        let set = |e: usize| ParameterSet {
            curves: Curves::Elastic(Elastic {
                normal_stiffness: normal,
                tangential_stiffness: [normal * tangential; 2],
            }),
            mu: None,
            gap: Length::from_si(gaps(e)),
            preload: Stress::default(),
        };
        Surface::Parameters(Parameters {
            per: Per::Element,
            sets: (0..n).map(set).collect(),
        })
    }
}

/// The finite elements of a structure.
pub(super) fn meshed(structure: &mut Structure) -> Result<&mut MeshedBodies> {
    match &mut structure.joint.bodies {
        Bodies::Meshed(bodies) => Ok(bodies),
        Bodies::Imported(_) => bail!("the scene is on matrices, which have no mesh"),
    }
}
