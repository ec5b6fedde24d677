//! How much work loops and periodic motions take.

use crate::common::BENCHMARKS;
use analyses::results::summary::Summary;
use analyses::results::work::Work;
use analyses::run;
use joints::Options;
use joints::progress::Silent;
use scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Counts of the solvers, so that a change of theirs is seen. A twentieth is left to the rounding of other processors.
#[test]
fn loops_and_periodic_motions_take_as_much_work_as_they_did() {
    let found = |law: Value, epmc: bool| {
        let mut scene = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
            "model": { "element_order": "linear", "refinement": "quick" },
            "interfaces": { "gap": "flat", "mu": 0.2, "law": law },
            "analyses": { "backbone": { "amplitudes": 6 } },
        });
        if epmc {
            scene["analyses"]["epmc"] = json!({});
        }
        let scene = Scene::from_value(scene, "here", "work", &BENCHMARKS).unwrap();
        Summary::new(
            &run(&scene, &Options::default(), &Silent).unwrap(),
            BTreeMap::new(),
            None,
        )
        .work
    };
    let check = |name: &str, work: &Work, expected: [usize; 3]| {
        let counts = [work.residuals, work.krylov_steps, work.products];
        println!("{name}: {work:?}");
        for (found, expected) in counts.into_iter().zip(expected) {
            assert!(
                20 * found.abs_diff(expected) <= expected,
                "{name}: {counts:?}, expected {expected:?}"
            );
        }
        assert_eq!(work.factorisations, 0);
    };
    let lumped = found(json!({ "friction": "lumped" }), false);
    check("lumped", &lumped["backbone"], [393, 1003, 1396]);
    assert_eq!(lumped.keys().collect::<Vec<_>>(), ["backbone"]);
    let annuli = found(json!({ "friction": "mindlin-iwan" }), false);
    check("annuli", &annuli["backbone"], [544, 1382, 1926]);
    let springs = found(json!({}), true);
    check("springs", &springs["backbone"], [535, 1322, 1857]);
    check("springs, periodic", &springs["epmc"], [32, 175, 1449]);
    // Two periods of 128 samples, and three harmonics.
    let Work {
        residuals,
        krylov_steps,
        law_evaluations,
        products,
        bytes_read,
        ..
    } = springs["epmc"];
    assert_eq!(
        (law_evaluations, products),
        (256 * residuals, 7 * (residuals + krylov_steps))
    );
    assert_eq!(bytes_read % products as u64, 0);
}

/// Finer samples are tried until the error is small enough: each motion counts with its own.
#[test]
fn every_sampling_that_is_tried_counts_with_its_own_numbers() {
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": { "gap": "flat", "mu": 0.2, "law": { "friction": "lumped" } },
        "analyses": {
            "backbone": { "amplitudes": 0 },
            "epmc": {
                "modal_amplitudes": [3e-4], "harmonics": 1, "samples": 16,
                "accuracy": { "frequency": 1e-5, "damping": 1e-2 },
            },
        },
    });
    let scene = Scene::from_value(scene, "here", "work", &BENCHMARKS).unwrap();
    let found = run(&scene, &Options::default(), &Silent).unwrap();
    let epmc = found.first().epmc.as_ref().unwrap();
    let finest = epmc.points[0].result.as_ref().unwrap().sampling;
    let work = Summary::new(&found, BTreeMap::new(), None).work["epmc"];
    println!("{finest:?} {work:?}");
    assert!(finest.samples > 16 && finest.harmonics > 1);
    let each = [finest.samples * finest.periods, 2 * finest.harmonics + 1];
    assert!(each[0] < work.law_evaluations && work.law_evaluations < each[0] * work.residuals);
    assert!(work.products < each[1] * (work.residuals + work.krylov_steps));
    assert!(work.products > 3 * (work.residuals + work.krylov_steps));
}
