//! Runs whose settings are adapted to the errors that the scene bears.
//!
//! Errors are estimated from the run ([`super::walks`]), first at a few amplitudes. The run itself has the last word: where it misses the target,
//! it is repeated with more.

use super::adaptation::{Adaptation, AdaptationStep};
use super::ensemble::loops_alone;
use super::error_bar::ErrorBar;
use super::prepared::{Prepared, check_inputs, mesh, prepare};
use super::run::Run;
use super::walks;
use crate::Error;
use joints::progress::{Progress, Quiet, Stage, Within};
use joints::store::Options;
use joints::store::checkpoint::Checkpoints;
use joints::structure::{StructuralModel, Structure};
use scenes::{Accuracy, Scene, Target};

/// Amplitudes of a pilot.
const PILOT: usize = 5;

/// Most pilots, and most runs.
const MOST: [usize; 2] = [4, 3];

/// A structure with its reduced model, as long as the mesh stays the same, and the error of that mesh.
struct Known {
    structure: Structure,
    model: StructuralModel,
    bar: Option<ErrorBar>,
}

/// Runs a scene, with settings that are adapted to the errors it bears if it names any.
///
/// # Errors
/// Whatever makes the scene impossible to run. Amplitudes that do not converge are results, not errors.
pub fn run(scene: &Scene, options: &Options, progress: &dyn Progress) -> Result<Run, Error> {
    match &scene.accuracy {
        Some(Accuracy::Target(target)) => adapted(scene, target, options, progress),
        _ => prepare(scene, options, progress)?.solve(progress),
    }
}

/// Runs a scene with settings that are adapted to a target.
fn adapted(scene: &Scene, target: &Target, options: &Options, progress: &dyn Progress) -> Result<Run, Error> {
    check_inputs(scene)?;
    let mut scene = scene.clone();
    // The scene of the results has the settings that were chosen.
    scene.accuracy = None;
    let mut steps = Vec::new();
    let mut known = None;
    if scene.analyses.backbone.amplitudes > 2 * PILOT {
        while steps.len() < MOST[0] {
            let (step, after) = pilot(&scene, known, options, progress)?;
            known = Some(after);
            progress.note(&step.sentence(target));
            let next = step.refined(&scene, target, steps.is_empty());
            steps.push(step);
            let Some(next) = next else { break };
            if next.model != scene.model {
                known = None;
            }
            scene = next;
        }
    }
    let most = steps.len() + MOST[1];
    let mut checkpoints = Checkpoints::default();
    loop {
        let prepared = match known.take() {
            Some(Known { structure, model, .. }) => Prepared::with_model(&scene, &structure, model, options, progress)?,
            None => prepare(&scene, options, progress)?,
        };
        let mut run = prepared.solve(progress)?;
        let backbones = run.backbones.iter().flat_map(|mode| &mode.amplitudes);
        let step = AdaptationStep::of(&scene, walks::bins(&run.parts), backbones);
        let next = step.refined(&scene, target, false);
        let (met, limited_by) = (step.meets(target), step.limits(target));
        steps.push(step);
        if let (Some(next), true) = (next, steps.len() < most) {
            progress.note("again, with more of what misses the accuracy asked for");
            checkpoints.extend(run.checkpoints);
            scene = next;
            continue;
        }
        // Those of runs that were not enough go with those of the last.
        run.checkpoints.extend(checkpoints);
        run.adaptation = Some(Adaptation {
            frequency: target.frequency,
            damping: target.damping,
            met,
            limited_by,
            steps,
        });
        return Ok(run);
    }
}

/// Errors at a few amplitudes, with what the next pilot or the run may know.
fn pilot(
    scene: &Scene,
    known: Option<Known>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(AdaptationStep, Known), Error> {
    let mut pilot = loops_alone(scene, true);
    pilot.analyses.backbone.amplitudes = PILOT;
    // Its loops are its own.
    let uncached = Options {
        cache: None,
        ..options.clone()
    };
    let Known { structure, model, bar } = match known {
        Some(known) => known,
        None => {
            // With the nodes of all that the scene asks for.
            let structure = mesh(scene, progress)?;
            let model = structure.reduce(options, progress)?;
            let bar = None;
            Known { structure, model, bar }
        }
    };
    let quiet = Quiet(progress);
    let prepared = Prepared::with_model(&pilot, &structure, model, &uncached, &quiet)?;
    let mut analysis = prepared.analyse_in_full(&quiet)?;
    let bar = match bar {
        Some(bar) => Some(bar),
        None => prepared.estimated_error(&analysis, &Within::new(&quiet, Stage::Bodies, [0.0, 1.0]))?,
    };
    prepared.estimate_errors(&mut analysis.modes, bar.as_ref());
    let amplitudes = analysis.modes.iter().flat_map(|mode| &mode.amplitudes);
    let step = AdaptationStep::of(&pilot, walks::bins(&prepared.reports), amplitudes);
    let model = prepared.model;
    Ok((step, Known { structure, model, bar }))
}
