//! What the stages of a run are expected to take, from sizes alone.
//!
//! Constants are seconds on two cores of a usual computer, measured on the Brake-Reuss beam, flanges and chains of laps from 30 000 to 130 000 unknowns.
//! A run scales them by its own pace, so that their ratios are what counts.

use super::error_bar::ErrorBar;
use super::forced::OF_RESONANCE;
use joint_model::Bodies;
use joints::progress::{Expected, Progress, Stage};
use joints::structure::Structure;
use scenes::{Scene, Surface};

/// Per unknown of the structure.
const ASSEMBLING: f64 = 1.4e-5;

/// Of a structure of 100 000 unknowns, and the power of their number that it goes with.
const FACTORING: (f64, f64) = (7.6, 1.2);

/// Per number of the reduced matrices to the power.
const REDUCING: (f64, f64) = (1.7e-9, 1.25);

/// Per interface.
const CHARACTERISING: f64 = 0.3;

/// Per element of an interface whose faces were scanned.
const MEASURING: f64 = 8e-3;

/// Of a comparison, relative to the law.
const COMPARING: f64 = 2.2;

/// Per number of the reduced matrix: of the static state, of the modes, and of a vertex of a quarter of a loop.
const SOLVING: [f64; 3] = [1.6e-8, 3e-8, 9e-9];

/// Of finding displacements, relative to the factorisation; and of recovering strains, per element.
const RECOVERING: (f64, f64) = (0.3, 1.2e-3);

/// Loops of each mode that the error of a mesh follows from.
const LOOPS_OF_MESH: f64 = 2.0;

/// Per number of the reduced matrix: of a periodic motion on one thread, and of a step in time.
const MOVING: [f64; 2] = [7.5e-7, 2e-9];

/// A method beside the backbone, relative to it.
const METHOD: f64 = 0.15;

/// A sample beside the backbone of the scene, whose errors are estimated too.
const SAMPLE: f64 = 1.1;

/// Tells what the stages of a scene are expected to take.
pub(super) fn expect(scene: &Scene, structure: &Structure, progress: &dyn Progress) {
    let (unknowns, elements) = match &structure.joint.bodies {
        Bodies::Meshed(bodies) => {
            let mesh = &bodies.assembly.mesh;
            (3 * mesh.nodes.len(), mesh.elements.len())
        }
        Bodies::Imported(bodies) => (bodies.relative.stiffness.rows(), 0),
    };
    let threads = rayon::current_num_threads() as f64;
    // Fronts near the end of a factorisation are work for one thread.
    let in_part = |seconds: f64| seconds / threads.sqrt();
    let entries = structure.reduced_entries() as f64;
    let factor = FACTORING.0 * (1e-5 * unknowns as f64).powf(FACTORING.1);
    let [rest, modes, vertex] = SOLVING.map(|each| each * entries);
    let [periodic, step] = MOVING.map(|each| each * entries);
    let analyses = &scene.analyses;
    let loops = (analyses.backbone.amplitudes * analyses.modes.followed.len()) as f64;
    let of_loop = vertex * analyses.backbone.vertices_per_quarter as f64 / threads;
    let is_scanned = scene.interfaces.surfaces().any(Surface::is_scanned);
    let expect = |stage, seconds| progress.expect(stage, Expected::Seconds(seconds));
    expect(Stage::Assemble, ASSEMBLING * unknowns as f64);
    expect(Stage::Factor, in_part(factor));
    expect(Stage::Reduce, in_part(REDUCING.0 * entries.powf(REDUCING.1)));
    let laws = CHARACTERISING * structure.joint.parts.len().max(1) as f64;
    let scans = MEASURING * structure.interface().elements.len() as f64;
    expect(Stage::Characterise, laws + if is_scanned { scans } else { 0.0 });
    expect(Stage::Prestress, rest);
    expect(Stage::Modes, modes);
    if loops > 0.0 {
        match is_scanned {
            // Surfaces are not measured again.
            true => expect(Stage::Comparisons, COMPARING * laws),
            false => progress.expect(Stage::Comparisons, Expected::Times(COMPARING, Stage::Characterise)),
        }
        expect(Stage::Backbone, loops * of_loop);
    }
    let methods = METHOD * analyses.backbone.methods.len() as f64;
    if methods > 0.0 {
        progress.expect(Stage::Methods, Expected::Times(methods, Stage::Backbone));
    }
    if let Some(epmc) = &analyses.epmc {
        let amplitudes = epmc.modal_amplitudes.as_ref().map(|given| given.values().len());
        let amplitudes = amplitudes.unwrap_or(analyses.backbone.amplitudes) * analyses.modes.followed.len();
        expect(Stage::Epmc, in_part(periodic) * amplitudes as f64);
    }
    if let Some(forced) = &analyses.forced {
        let [from, to] = forced.range_hz();
        let of_level = (to / from).ln().abs() / forced.frequency_step + OF_RESONANCE;
        expect(
            Stage::Forced,
            in_part(periodic) * of_level * forced.levels().len() as f64,
        );
    }
    if let Some(random) = &analyses.random {
        // Without motions in time it takes milliseconds.
        let steps = random.in_time.map_or(0, |asked| asked.periods * asked.steps_per_period);
        expect(Stage::Random, step * (steps * random.levels.len()) as f64);
    }
    if let Some(shock) = &analyses.shock {
        // And as many of a joint that answers linearly.
        expect(Stage::Shock, step * (2 * shock.periods * shock.steps_per_period) as f64);
    }
    if let Some(ring_down) = &analyses.ring_down {
        expect(
            Stage::Transient,
            step * (ring_down.periods * ring_down.steps_per_period) as f64,
        );
    }
    let displacements = in_part(RECOVERING.0 * factor);
    let of_bodies = if scene.output.deformed { displacements } else { 0.0 };
    let of_mesh = match ErrorBar::is_estimated(scene) {
        true => {
            let again = rest + modes + LOOPS_OF_MESH * of_loop * analyses.modes.followed.len() as f64;
            displacements + RECOVERING.1 * elements as f64 + again
        }
        false => 0.0,
    };
    if of_bodies + of_mesh > 0.0 {
        expect(Stage::Bodies, of_bodies + of_mesh);
    }
}

/// Tells of so many samples or realisations beside a scene.
pub(super) fn expect_samples(number: usize, progress: &dyn Progress) {
    let times = Expected::Times(SAMPLE * number as f64, Stage::Backbone);
    progress.expect(Stage::Ensemble, times);
}
