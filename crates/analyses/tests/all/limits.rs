//! Runs end where they are told to, whatever they are at, and are refused where there is no memory for them.

use crate::common::beam;
use analyses::run;
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::progress::{Progress, Silent, Stage};
use joints::structure::Structure;
use scenes::{Epmc, Scene};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

fn scene() -> Scene {
    let mut scene = beam("limits");
    scene.model.refinement = RefinementLevel::Quick;
    scene.analyses.backbone.amplitudes = 3;
    scene.analyses.backbone.vertices_per_quarter = 2;
    scene.analyses.epmc = Some(Epmc::default());
    scene
}

/// Ends a run when a stage begins.
struct StopAt {
    stage: Stage,
    stop: AtomicBool,
    begun: Mutex<Vec<Stage>>,
    finished: Mutex<Vec<Stage>>,
}

impl Progress for StopAt {
    fn begin(&self, stage: Stage) {
        self.begun.lock().unwrap_or_else(PoisonError::into_inner).push(stage);
        self.stop.fetch_or(stage == self.stage, Ordering::Relaxed);
    }

    fn end(&self, stage: Stage) {
        self.finished.lock().unwrap_or_else(PoisonError::into_inner).push(stage);
    }

    fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_a_run_ends_in_the_stage_in_which_it_is_told_to() {
    for stage in [
        Stage::Mesh,
        Stage::Assemble,
        Stage::Factor,
        Stage::Reduce,
        Stage::Characterise,
        Stage::Prestress,
        Stage::Modes,
        Stage::Backbone,
        Stage::Epmc,
    ] {
        let watch = StopAt {
            stage,
            stop: AtomicBool::new(false),
            begun: Mutex::default(),
            finished: Mutex::default(),
        };
        let error = run(&scene(), &Options::default(), &watch).unwrap_err();
        assert!(error.is_interruption(), "{stage:?}: {error}");
        let (begun, finished) = (watch.begun.into_inner().unwrap(), watch.finished.into_inner().unwrap());
        assert_eq!(begun.last(), Some(&stage));
        // These are asked within, not between them alone.
        if matches!(stage, Stage::Factor | Stage::Reduce | Stage::Backbone | Stage::Epmc) {
            assert!(!finished.contains(&stage), "{stage:?}");
        }
    }
}

#[test]
fn models_that_do_not_fit_into_the_memory_are_refused_with_an_estimate() {
    let structure = Structure::try_new(&scene(), &Silent).unwrap();
    let within = |memory: u64| {
        let options = Options {
            memory: Some(memory),
            ..Options::default()
        };
        structure.reduce(&options, &Silent)
    };
    // The matrices of the reduced model are known before anything is assembled.
    let error = within(20_000_000).unwrap_err();
    let joints::Error::Memory {
        coordinates: 608,
        needed,
        limit: 20_000_000,
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!(needed, 10 * 8 * 608 * 608);
    assert!(
        error.to_string().contains("30 MB") && error.remedy().unwrap().contains("--memory"),
        "{error}"
    );
    // Fronts and factor are known before they are factored.
    let error = within(31_000_000).unwrap_err();
    let factorisation = matches!(
        &error,
        joints::Error::FactorMemory(finite_elements::Error::Memory { .. })
    );
    assert!(factorisation, "{error}");
    assert!(error.to_string().contains("--memory"), "{error}");
    // 92 MB were measured.
    assert!(within(120_000_000).is_ok());
}
