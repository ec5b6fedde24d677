//! The half of a symmetric scene against the whole.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "tests, which print what they measure"
)]

use crate::common::{BENCHMARKS, beam};
use analyses::results::summary::{BackboneSummary, Status, Summary};
use analyses::{Run, run};
use brake_reuss_beam::BrakeReussBenchmark;
use joint_model::benchmark::{RefinementLevel, Symmetry};
use joints::Options;
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::{BenchmarkRef, BoltBehaviour, Deck, Gap, Length, Method, Scene, StructureSource, Surface, SyntheticScan};
use std::collections::BTreeMap;

fn scene(symmetry: Symmetry) -> Scene {
    let mut scene = beam("quick");
    scene.model.refinement = RefinementLevel::Quick;
    scene.model.symmetry = symmetry;
    scene.analyses.backbone.amplitudes = 4;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-5);
    scene.analyses.backbone.vertices_per_quarter = 4;
    // Far below what is compared, so that the ends of Newton's iterations do not matter.
    scene.analyses.backbone.tolerance = 1e-12;
    scene.analyses.backbone.methods = vec![Method::Qsma, Method::Masing, Method::Rqnma];
    scene
}

/// A run of the whole, and one of the half that retains those modes of the whole that are symmetric.
fn both(change: impl Fn(&mut Scene)) -> [Run; 2] {
    let go = |mut scene: Scene| {
        change(&mut scene);
        run(&scene, &Options::default(), &Silent).unwrap()
    };
    let whole = go(scene(Symmetry::None));
    let highest = whole.model.reduced.stuck_frequencies.last().unwrap() * (1.0 + 1e-6);
    let mut half = scene(Symmetry::Half);
    half.analyses.backbone.amplitudes = 0;
    half.analyses.backbone.methods.clear();
    let found = run(&half, &Options::default(), &Silent).unwrap();
    let mut half = scene(Symmetry::Half);
    let stuck = &found.model.reduced.stuck_frequencies;
    half.model.modes = Some(stuck.iter().filter(|f| **f <= highest).count());
    [whole, go(half)]
}

/// Compares, prints how well things agree, and holds them to `bound`.
fn compare(name: &str, pairs: impl IntoIterator<Item = (f64, f64)>, bound: f64) {
    let pairs: Vec<_> = pairs.into_iter().collect();
    let worst = pairs.iter().map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    println!("{name}: {worst:.1e} of {} values", pairs.len());
    assert!(!pairs.is_empty() && worst <= bound, "{name}: {worst:e}\n{pairs:?}");
}

/// Frequencies of the half with the nearest of the whole; those beyond the last of the whole are left out.
fn nearest(half: &[f64], whole: &[f64]) -> Vec<(f64, f64)> {
    let last = whole.iter().copied().fold(0.0, f64::max) * (1.0 + 1e-6);
    let nearest = |f: f64| {
        whole
            .iter()
            .copied()
            .min_by(|a, b| (a - f).abs().total_cmp(&(b - f).abs()))
            .unwrap()
    };
    half.iter().filter(|f| **f <= last).map(|&f| (f, nearest(f))).collect()
}

#[test]
fn the_half_is_the_whole() {
    let [whole, half] = both(|_| {});
    let (model, of_whole) = (&half.model, &whole.model);
    assert_eq!((model.reduced.zem_stuck, model.facts.zem_unstressed), (3, 4));
    compare(
        "mass",
        [(model.facts.mass.unwrap(), of_whole.facts.mass.unwrap())],
        1e-12,
    );
    compare(
        "area",
        [(half.interface.operators().area(), whole.interface.operators().area())],
        1e-12,
    );
    // The modes of the full model have residuals of 1e-6 and 1e-4, their frequencies errors of the square.
    let (a, b) = (&model.reduced.stuck_frequencies, &of_whole.reduced.stuck_frequencies);
    compare("stuck frequencies", nearest(a, b), 1e-9);
    let (a, b) = (
        &model.facts.penalty_frequencies_hz,
        &of_whole.facts.penalty_frequencies_hz,
    );
    compare("penalty frequencies", nearest(a, b), 1e-8);
    let (a, b) = (
        &model.facts.unstressed_frequencies_hz,
        &of_whole.facts.unstressed_frequencies_hz,
    );
    compare("unstressed frequencies", nearest(a, b), 1e-9);
    compare(
        "linearised frequencies",
        nearest(&half.frequencies, &whole.frequencies),
        1e-9,
    );
    assert!(nearest(&half.frequencies, &whole.frequencies).len() >= 5);

    let [half, whole] = [half, whole].map(|run| Summary::new(&run, BTreeMap::new(), None));
    let skips_half = |summary: &Summary| summary.skipped.contains_key("half_of_the_structure");
    assert!(skips_half(&half) && !skips_half(&whole));
    let of = |of: &dyn Fn(&Summary) -> f64| [(of(&half), of(&whole))];
    compare(
        "force that separates",
        of(&|s| s.validity.separation_modal_force.unwrap()),
        1e-8,
    );
    compare("closure", of(&|s| s.law.mean_closure), 1e-9);
    compare("contact area", of(&|s| s.prestress.contact_area_fraction), 1e-9);
    compare("largest pressure", of(&|s| s.prestress.max_pressure), 1e-9);
    compare("mean pressure", of(&|s| s.prestress.mean_pressure), 1e-12);
    compare(
        "real contact area",
        of(&|s| s.validity.real_contact_area_fraction.unwrap()),
        1e-9,
    );
    let points = |of: &dyn Fn(&BackboneSummary) -> f64| -> Vec<_> {
        let pairs = half.backbone.iter().zip(&whole.backbone);
        pairs.map(|(a, b)| (of(a), of(b))).collect()
    };
    compare("modal force", points(&|p| p.modal_force), 1e-9);
    compare("modal amplitude", points(&|p| p.modal_amplitude.unwrap()), 1e-9);
    compare("response", points(&|p| p.response_displacement.unwrap()), 1e-9);
    compare("frequency", points(&|p| p.frequency_hz.unwrap()), 1e-9);
    compare("slip fraction", points(&|p| 1.0 + p.slip_fraction.unwrap()), 1e-9);
    compare("open fraction", points(&|p| 1.0 + p.open_fraction.unwrap()), 1e-9);
    // A small difference of large energies: of the first, 1e-4 of the potential energy.
    // Below slip there is none to compare.
    let resolved = |of: &dyn Fn(&BackboneSummary) -> Option<f64>| -> Vec<_> {
        let pairs = half.backbone.iter().zip(&whole.backbone);
        assert!(pairs.clone().all(|(a, b)| a.status == b.status));
        let pairs = pairs.filter(|(a, _)| a.status == Status::Resolved);
        pairs.map(|(a, b)| (of(a).unwrap(), of(b).unwrap())).collect()
    };
    compare("damping", resolved(&|p| p.friction_damping_ratio), 1e-8);
    compare("dissipation of the points", resolved(&|p| p.dissipation), 1e-8);
    compare("dissipation of the mode", resolved(&|p| p.loop_area), 1e-8);
    for (name, of_half) in &half.methods {
        let pairs = || of_half.iter().zip(&whole.methods[name]);
        let frequencies = pairs().map(|(a, b)| (a.frequency_hz.unwrap(), b.frequency_hz.unwrap()));
        compare(&format!("frequency of {name}"), frequencies, 1e-9);
        let damping = pairs().filter_map(|(a, b)| a.damping_ratio.zip(b.damping_ratio));
        compare(&format!("damping of {name}"), damping, 1e-8);
    }
}

#[test]
fn locked_bolts_lock_in_the_half_too() {
    let [whole, half] = both(|scene| {
        scene.bolts.behaviour = BoltBehaviour::Locked;
        scene.analyses.backbone.amplitudes = 0;
        scene.analyses.backbone.methods.clear();
    });
    compare(
        "linearised frequencies",
        nearest(&half.frequencies, &whole.frequencies),
        1e-9,
    );
}

#[test]
fn scenes_that_need_not_be_symmetric_are_refused() {
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene(Symmetry::Half);
        change(&mut scene);
        match scene.validate("a scene") {
            Err(scenes::Error::Symmetry { what, .. }) => what,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(refused(&|s| s.interfaces.gap = Gap::Measured), "the gap");
    let scanned = |s: &mut Scene| s.interfaces.surface = Surface::SyntheticScan(SyntheticScan::default());
    assert_eq!(refused(&scanned), "the surface");
    let deck: Deck = serde_json::from_value(serde_json::json!({
        "path": "a.inp", "top_surface": "T", "bottom_surface": "B", "bolts": [{ "top": "1", "bottom": "2" }],
        "response": { "node": "3", "direction": [0.0, 0.0, 1.0] }
    }))
    .unwrap();
    let on_deck = |s: &mut Scene| {
        s.structure = StructureSource::Deck(Box::new(deck.clone())).into();
        s.interfaces.surface = Surface::Benchmark(BenchmarkRef(&BrakeReussBenchmark));
    };
    assert_eq!(refused(&on_deck), "a deck");
    let mut half_deck = scene(Symmetry::Half);
    on_deck(&mut half_deck);
    let structure = Structure::try_new(&half_deck, &Silent);
    assert!(matches!(
        structure,
        Err(joints::Error::Scene(scenes::Error::Symmetry { .. }))
    ));

    let per = |per: &str| {
        format!(
            r#"{{ "units": {{ "length": "m", "mass": "kg", "time": "s" }}, "structure": {{ "benchmark": "brake-reuss-beam" }},
            "model": {{ "symmetry": "half" }},
            "interfaces": {{ "surface": {{ "parameters": {{ "per": "{per}", "sets": [ {{ "curves": {{ "elastic":
            {{ "normal_stiffness": 1e13, "tangential_stiffness": [7e12, 7e12] }} }} }} ] }} }} }} }}"#
        )
    };
    Scene::from_json(&per("interface"), "a scene", "a", &BENCHMARKS).unwrap();
    let error = Scene::from_json(&per("element"), "a scene", "a", &BENCHMARKS).unwrap_err();
    assert!(matches!(error, scenes::Error::Symmetry { .. }), "{error}");
}
