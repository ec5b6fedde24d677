//! The half of a symmetric scene against the whole.
#![expect(clippy::unwrap_used, reason = "tests")]

use joint_pipeline::progress::Silent;
use joint_pipeline::scene::{Method, RefinementName, Symmetry};
use joint_pipeline::summary::Summary;
use joint_pipeline::{Options, Scene, run};
use std::collections::BTreeMap;

fn quick() -> Scene {
    let mut scene = Scene::new("quick");
    scene.model.refinement = RefinementName::Quick;
    scene.cqsma.amplitudes = 4;
    scene.cqsma.amplitude_from = 1e-5;
    scene.cqsma.vertices_per_quarter = 4;
    scene.cqsma.tolerance = 1e-12;
    scene
}

fn summary(scene: &Scene) -> Summary {
    Summary::new(&run(scene, &Options::default(), &Silent).unwrap(), BTreeMap::new(), None)
}

#[test]
fn the_half_is_the_whole() {
    let whole = summary(&quick());
    let mut scene = quick();
    scene.model.symmetry = Symmetry::Half;
    let half = summary(&scene);
    let nearest = |f: f64, of: &[f64]| of.iter().map(|g| (f / g - 1.0).abs()).fold(f64::INFINITY, f64::min);
    for (name, a, b) in [
        ("stuck", &half.model.stuck_frequencies_hz, &whole.model.stuck_frequencies_hz),
        ("penalty", &half.model.penalty_frequencies_hz, &whole.model.penalty_frequencies_hz),
        ("unstressed", &half.model.unstressed_frequencies_hz, &whole.model.unstressed_frequencies_hz),
    ] {
        println!("{name} {a:?} {b:?}");
        for f in a { println!("  {f} {:.1e}", nearest(*f, b)); }
    }
    println!("{:?}\n{:?}", half.model, whole.model);
    println!("{:?}\n{:?}", half.modes, whole.modes);
    println!("{:?}\n{:?}", half.prestress, whole.prestress);
    for (a, b) in half.backbone.iter().zip(&whole.backbone) {
        println!("{a:?}\n{b:?}");
    }
}
