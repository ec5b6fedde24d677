//! Presets against the settings of a scene: what they are known to cost and to miss, and the next finer ones.

use crate::accuracy::{PRESETS, Preset};
use crate::error::Error;
use crate::scene::Scene;
use joint_model::benchmark::{ElementOrder, RefinementLevel};

/// Time of `standard` on the flat Brake-Reuss beam, from nothing to the backbone of [`TIMED_AMPLITUDES`] amplitudes of one mode, on two
/// cores (s), with friction of annuli; with lumped friction it takes half of that.
const STANDARD_SECONDS: f64 = 19.0;

/// Amplitudes of the runs that were timed.
const TIMED_AMPLITUDES: usize = 20;

impl Preset {
    /// The preset whose settings a scene has, as far as its structure takes them.
    pub fn of(scene: &Scene) -> Option<&'static Self> {
        let loops = &scene.analyses.backbone;
        let is_own = |preset: &&Self| {
            let has_mesh = scene.structure.benchmark().is_none()
                || (scene.element_order(), scene.model.refinement) == (preset.element_order, preset.refinement);
            let has_modes = scene.structure.matrices().is_some() || scene.model.modes == Some(preset.modes);
            has_mesh
                && has_modes
                && scene.interfaces.points_per_direction == preset.points_per_direction
                && loops.vertices_per_quarter == preset.vertices_per_quarter
                && loops.tolerance == preset.tolerance
        };
        PRESETS.iter().find(is_own)
    }

    /// Whether its errors were measured on the structure of a scene.
    fn is_measured_on(scene: &Scene) -> bool {
        scene.structure.benchmark().is_some()
    }

    /// What a run with these settings is expected to take, and what that rests on, for the start of a run.
    pub fn expectation(&self, scene: &Scene) -> String {
        if !Self::is_measured_on(scene) {
            return "a time that depends on the mesh: settings are timed on the Brake-Reuss beam alone".into();
        }
        let seconds = self.cost * STANDARD_SECONDS;
        let time = match seconds {
            seconds if seconds < 100.0 => format!("{seconds:.0} s"),
            seconds => format!("{:.0} min", seconds / 60.0),
        };
        let model = &scene.model;
        let has_mesh = (scene.element_order(), model.refinement) == (self.element_order, self.refinement);
        let loops = scene.analyses.backbone.amplitudes * scene.analyses.modes.followed.len();
        let differs = match (has_mesh, loops == TIMED_AMPLITUDES) {
            (true, true) => String::new(),
            (true, false) => format!("; this scene has {loops} loops"),
            (false, _) => "; this scene has another mesh, on which times differ".into(),
        };
        format!(
            "about {time} where nothing is in the cache, as measured on the flat Brake-Reuss beam with \
             {TIMED_AMPLITUDES} loops on two cores{differs}"
        )
    }

    /// What is known of the errors of a scene with these settings, for the end of a run.
    pub fn promise(&self, scene: &Scene) -> String {
        match Self::is_measured_on(scene) {
            true => format!(
                "measured errors on the flat beam: {} in frequency, {} in the logarithm of damping",
                self.frequency_error, self.damping_error
            ),
            false => "measured on another structure; the errors below are estimated of this run".into(),
        }
    }

    /// Whether no setting is coarser than the scene's, and one is finer.
    fn refines(&self, scene: &Scene) -> bool {
        let meshed = scene.structure.benchmark().is_some();
        let reduced = scene.structure.matrices().is_none();
        // The coarsest quadratic mesh is nearer to the limit than the finest linear one.
        let mesh = |order: ElementOrder, refinement: RefinementLevel| 100 * order as usize + refinement as usize;
        let pairs = [
            (
                mesh(self.element_order, self.refinement),
                mesh(scene.element_order(), scene.model.refinement),
                meshed,
            ),
            (self.points_per_direction, scene.interfaces.points_per_direction, true),
            (self.modes, scene.model.n_modes(), reduced),
            (
                self.vertices_per_quarter,
                scene.analyses.backbone.vertices_per_quarter,
                true,
            ),
        ];
        let pairs = || pairs.iter().filter(|pair| pair.2);
        pairs().all(|(preset, own, _)| preset >= own) && pairs().any(|(preset, own, _)| preset > own)
    }

    /// The scene with the settings of the preset, none of them coarser than before.
    fn refine(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        if scene.structure.benchmark().is_some() {
            if scene.element_order() != self.element_order {
                // The other order need not have the scene's formulation.
                scene.model.formulation = None;
            }
            (scene.model.element_order, scene.model.refinement) = (Some(self.element_order), self.refinement);
        }
        if scene.structure.matrices().is_none() && scene.model.reduction_error.is_none() {
            scene.model.modes = Some(self.modes);
        }
        scene.interfaces.points_per_direction = self.points_per_direction;
        scene.analyses.backbone.vertices_per_quarter = self.vertices_per_quarter;
        scene.analyses.backbone.tolerance = scene.analyses.backbone.tolerance.min(self.tolerance);
        scene
    }
}

/// The scene with the settings of the cheapest preset that is finer than it in some and coarser in none of them.
///
/// # Errors
/// [`Error::NothingFiner`].
pub fn refined(scene: &Scene) -> Result<(&'static Preset, Scene), Error> {
    let finer = PRESETS
        .iter()
        .find(|preset| preset.refines(scene))
        .ok_or(Error::NothingFiner)?;
    let mut refined = finer.refine(scene);
    // A place beside the interface may be within the size of an element of the scene's mesh, and of none of the finer one.
    refined.analyses.backbone.loops_at.clear();
    Ok((finer, refined))
}
