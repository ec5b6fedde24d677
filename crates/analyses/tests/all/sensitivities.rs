//! Derivatives of backbones of scenes against central differences of whole runs.
#![allow(clippy::unwrap_used, reason = "a test that fails may panic")]
#![allow(clippy::print_stdout, reason = "what was measured, for those who look")]

use crate::common::{BENCHMARKS, plain};
use analyses::{FoundBy, Per, Prepared, Sensitivity};
use joints::Options;
use joints::progress::Silent;
use joints::structure::{StructuralModel, Structure};
use scenes::{Influence, Length, Parameter, Scene};
use serde_json::{Value, json};

const AMPLITUDES: usize = 10;
/// Difference from a central difference that is enough.
const ENOUGH: f64 = 1e-5;
/// What is differentiated: frequency and damping, of the secant and of the first harmonic.
const NUMBERS: usize = 4;
/// Relative distance of the loops that are interpolated.
const NEAR: f64 = 3e-4;

/// A small beam with the measured gap, whose runs are exact to round-off; `more` is added to the fields of its blocks.
fn scene(more: &Value) -> Scene {
    let mut scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": "quick" },
        "interfaces": { "gap": "measured", "mu": 0.2, "points_per_direction": 1 },
        "analyses": { "backbone": {
            "amplitudes": AMPLITUDES, "vertices_per_quarter": 3, "tolerance": 1e-12, "cycles": 3,
            "amplitude_from": "3 um", "amplitude_to": "0.6 mm",
        } },
        "output": { "fields_at": [] },
    });
    for (block, fields) in more.as_object().unwrap() {
        let block = scene[block].as_object_mut().unwrap();
        block.extend(fields.as_object().unwrap().clone());
    }
    Scene::from_json(&plain(scene).to_string(), "scene", "scene", &BENCHMARKS).unwrap()
}

/// `ln omega` and `ln zeta`, and the same of the first harmonic, at the modal amplitude `ln_q`, from three loops about a displacement.
fn beside(scene: &Scene, model: Option<&StructuralModel>, displacement: f64, ln_q: f64) -> [f64; NUMBERS] {
    let mut near = scene.clone();
    near.analyses.backbone.amplitudes = 3;
    near.analyses.backbone.amplitude_from = Length::from_si(displacement * (1.0 - NEAR));
    near.analyses.backbone.amplitude_to = Length::from_si(displacement * (1.0 + NEAR));
    let structure = Structure::try_new(&near, &Silent).unwrap();
    let prepared = match model {
        Some(model) => Prepared::with_model(&near, &structure, model.clone(), &Options::default(), &Silent),
        None => Prepared::try_new(&near, &structure, &Options::default(), &Silent),
    };
    let found = prepared.unwrap().solve(&Silent).unwrap();
    let points: Vec<[f64; 1 + NUMBERS]> = found
        .amplitudes()
        .iter()
        .map(|one| {
            let found = one.point.result.as_ref().unwrap();
            let (omega, zeta) = (found.harmonic_omega, found.harmonic_zeta());
            [found.modal_amplitude, found.omega, found.zeta, omega, zeta].map(f64::ln)
        })
        .collect();
    // Lagrange's polynomial.
    let weight = |i: usize| {
        let others = (0..3).filter(|j| *j != i);
        others
            .map(|j| (ln_q - points[j][0]) / (points[i][0] - points[j][0]))
            .product::<f64>()
    };
    [1, 2, 3, 4].map(|which| (0..3).map(|i| weight(i) * points[i][which]).sum())
}

/// Largest differences of the derivatives of frequencies and damping ratios to central differences, over amplitudes whose numbers are given, each relative
/// to the largest derivative of the parameter over all amplitudes.
fn compare(scene: &Scene, amplitudes: &[usize]) -> Vec<(Parameter, [f64; NUMBERS])> {
    let structure = Structure::try_new(scene, &Silent).unwrap();
    let model = structure.reduce(&Options::default(), &Silent).unwrap();
    let prepared = Prepared::with_model(scene, &structure, model.clone(), &Options::default(), &Silent);
    let found = prepared.unwrap().solve(&Silent).unwrap();
    let sensitivities = &found.first().sensitivities;
    assert_eq!(sensitivities.len(), scene.analyses.sensitivities.len());
    let mut bare = scene.clone();
    bare.analyses.sensitivities.clear();
    let of_one = |one: &Sensitivity| {
        let is_structural = one.parameter.influence() == Influence::Structure;
        // A point that begins to slip between the two values makes a difference wrong by a kink, and round-off one of close values: the best
        // of these steps is taken.
        let steps = match one.per {
            Per::Logarithm if is_structural => [1e-3, 3e-4, 1e-4],
            Per::Logarithm => [6e-5, 2e-5, 6e-6],
            Per::Value => [3e-7, 1e-7, 3e-8],
        };
        let varied = |step: f64, side: f64| {
            let value = match one.per {
                Per::Logarithm => one.value * (side * step).exp(),
                Per::Value => side * step,
            };
            one.parameter.with(&bare, value).unwrap()
        };
        let known = (!is_structural).then_some(&model);
        let largest = |of: &[Option<f64>]| of.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
        let all = [
            &one.dln_frequency,
            &one.dln_damping,
            &one.dln_frequency_first_harmonic,
            &one.dln_damping_first_harmonic,
        ];
        let scale = all.map(|values| largest(values));
        let mut worst = [0.0_f64; NUMBERS];
        for &number in amplitudes {
            let result = found.amplitudes()[number].point.result.as_ref().unwrap();
            let ln_q = result.modal_amplitude.ln();
            let displacement = displacements(scene)[number];
            let own = all.map(|values| values[number]);
            let mut best = [f64::INFINITY; NUMBERS];
            for step in steps {
                let sides = [1.0, -1.0].map(|side| varied(step, side));
                let [above, below] = sides.each_ref().map(|scene| beside(scene, known, displacement, ln_q));
                for which in 0..NUMBERS {
                    let central = (above[which] - below[which]) / (2.0 * step);
                    let Some(own) = own[which] else {
                        best[which] = 0.0;
                        continue;
                    };
                    let error = (own - central).abs() / scale[which];
                    println!(
                        "{:32} {number:2} {which} {step:.0e} {own:+.9e} {central:+.9e} {error:.1e}",
                        one.parameter.path()
                    );
                    best[which] = best[which].min(error);
                }
                if best.iter().all(|error| *error < ENOUGH) {
                    break;
                }
            }
            for (worst, best) in worst.iter_mut().zip(best) {
                *worst = worst.max(best);
            }
        }
        (one.parameter.clone(), worst)
    };
    sensitivities.iter().map(of_one).collect()
}

/// Displacements that the amplitudes of a scene are chosen for (m).
fn displacements(scene: &Scene) -> Vec<f64> {
    let backbone = &scene.analyses.backbone;
    let [from, to] = [backbone.amplitude_from, backbone.amplitude_to].map(Length::si);
    let last = (backbone.amplitudes - 1) as f64;
    (0..backbone.amplitudes)
        .map(|i| from * (to / from).powf(i as f64 / last))
        .collect()
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_derivatives_of_the_beam_are_those_of_whole_runs() {
    let parameters = [
        "interfaces.mu",
        "bolts.load",
        "interfaces.scale.asperity_radius",
        "interfaces.scale.asperity_height",
        "interfaces.scale.gap",
        "interfaces.scale.gap_tilt.0",
        "interfaces.scale.gap_crown.0",
    ];
    let scene = scene(&json!({ "analyses": { "sensitivities": parameters } }));
    for (parameter, errors) in compare(&scene, &[0, 5, 9]) {
        assert!(errors.iter().all(|error| *error < ENOUGH), "{parameter}: {errors:?}");
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_derivatives_by_the_material_are_those_of_whole_runs() {
    let parameters = [
        "model.material.youngs_modulus",
        "model.material.poisson_ratio",
        "model.material.density",
    ];
    let scene = scene(&json!({ "analyses": { "sensitivities": parameters } }));
    for (parameter, errors) in compare(&scene, &[6]) {
        assert!(errors.iter().all(|error| *error < ENOUGH), "{parameter}: {errors:?}");
    }
}

/// What the law is not differentiated with respect to is left to differences, beside what it is.
#[test]
fn what_loops_do_not_carry_is_differences_of_runs() {
    let yielding = |sensitivities: &[&str]| {
        scene(&json!({
            "interfaces": {
                "gap": "flat",
                "law": { "friction": "resolved", "yield": { "strength": "331.7 MPa", "tangent_modulus": "620 MPa" } },
            },
            "analyses": {
                "backbone": {
                    "amplitudes": 3, "vertices_per_quarter": 3, "amplitude_from": "50 um", "amplitude_to": "0.4 mm",
                },
                "sensitivities": sensitivities,
            },
        }))
    };
    let path = "interfaces.law.yield.strength";
    let asked = yielding(&["interfaces.mu", path]);
    let prepared = |scene: &Scene| {
        let structure = Structure::try_new(scene, &Silent).unwrap();
        let prepared = Prepared::try_new(scene, &structure, &Options::default(), &Silent).unwrap();
        prepared.solve(&Silent).unwrap()
    };
    let found = prepared(&asked);
    let [mu, strength] = found.first().sensitivities.as_slice() else {
        panic!("{:?}", found.first().sensitivities)
    };
    assert_eq!(
        (mu.by, strength.by),
        (FoundBy::ImplicitDifferentiation, FoundBy::CentralDifferences)
    );
    assert_eq!(strength.parameter.path(), path);
    // By hand, over another step.
    let step = 5e-3;
    let (bare, last) = (yielding(&[]), 2);
    let ln_q = strength.modal_amplitude[last].unwrap().ln();
    let [above, below] = [1.0, -1.0].map(|side: f64| {
        let varied = strength
            .parameter
            .with(&bare, strength.value * (side * step).exp())
            .unwrap();
        beside(&varied, Some(&found.model), displacements(&bare)[last], ln_q)
    });
    for (which, own) in [strength.dln_frequency[last], strength.dln_damping[last]]
        .into_iter()
        .enumerate()
    {
        let by_hand = (above[which] - below[which]) / (2.0 * step);
        let own = own.unwrap();
        assert!((own - by_hand).abs() < 0.02 * own.abs(), "{which}: {own} {by_hand}");
    }
}

/// Frequency and damping of free periodic motions at given amplitudes.
fn free_motions(scene: &Scene, model: Option<&StructuralModel>) -> (Vec<Sensitivity>, Vec<[f64; 2]>) {
    let structure = Structure::try_new(scene, &Silent).unwrap();
    let prepared = match model {
        Some(model) => Prepared::with_model(scene, &structure, model.clone(), &Options::default(), &Silent),
        None => Prepared::try_new(scene, &structure, &Options::default(), &Silent),
    };
    let found = prepared.unwrap().solve(&Silent).unwrap();
    let epmc = found.first().epmc.as_ref().unwrap();
    let points = epmc.points.iter().map(|point| {
        let motion = point.result.as_ref().unwrap();
        [motion.omega.ln(), motion.zeta.unwrap().ln()]
    });
    (epmc.sensitivities.clone(), points.collect())
}

fn compare_free_motions(parameters: &[&str], number: usize) {
    let scene = scene(&json!({ "analyses": {
        "backbone": { "amplitudes": 0 },
        "epmc": {
            "harmonics": 3, "samples": 64, "tolerance": 1e-12,
            "modal_amplitudes": { "from": 3e-5, "to": 1e-3, "number": number },
        },
        "sensitivities": parameters,
    } }));
    let structure = Structure::try_new(&scene, &Silent).unwrap();
    let model = structure.reduce(&Options::default(), &Silent).unwrap();
    let (sensitivities, _) = free_motions(&scene, Some(&model));
    assert_eq!(sensitivities.len(), parameters.len());
    let mut bare = scene.clone();
    bare.analyses.sensitivities.clear();
    for one in &sensitivities {
        let is_structural = one.parameter.influence() == Influence::Structure;
        // A point that begins to slip between two samples on the way from one value to the other makes a difference wrong by a kink. That
        // happens by chance, and not with all steps.
        let steps: &[f64] = match is_structural {
            true => &[1e-3, 1e-4, 2e-5, 6e-6, 3e-6],
            false => &[1e-4, 2e-5, 4e-6],
        };
        let differences: Vec<Vec<[f64; 2]>> = steps
            .iter()
            .map(|step| {
                let [above, below] = [*step, -*step].map(|step: f64| {
                    let varied = one.parameter.with(&bare, one.value * step.exp()).unwrap();
                    free_motions(&varied, (!is_structural).then_some(&model)).1
                });
                let pairs = above.iter().zip(&below);
                pairs
                    .map(|(a, b)| [0, 1].map(|which| (a[which] - b[which]) / (2.0 * step)))
                    .collect()
            })
            .collect();
        for (which, own) in [&one.dln_frequency, &one.dln_damping].into_iter().enumerate() {
            let scale = own.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
            assert!(
                own.iter().flatten().count() > number / 2,
                "most amplitudes have a value"
            );
            for (at, own) in own.iter().enumerate() {
                let Some(own) = own else { continue };
                let errors = differences.iter().map(|found| (own - found[at][which]).abs() / scale);
                let errors: Vec<f64> = errors.collect();
                println!("{:32} {at:2} {which} {own:+.9e} {errors:?}", one.parameter.path());
                let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
                assert!(least < 1e-5, "{} {at} {which}: {own:e} {errors:?}", one.parameter);
            }
        }
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_derivatives_of_free_motions_are_those_of_whole_backbones() {
    compare_free_motions(&["interfaces.mu", "bolts.load"], 3);
}

/// Ten amplitudes for every parameter, both methods.
#[test]
#[ignore = "takes minutes"]
fn derivatives_by_all_parameters_are_those_of_whole_runs() {
    let parameters = [
        "interfaces.mu",
        "bolts.load",
        "interfaces.scale.asperity_radius",
        "interfaces.scale.asperity_density",
        "interfaces.scale.asperity_height",
        "interfaces.scale.gap",
        "interfaces.scale.gap_tilt.0",
        "model.material.youngs_modulus",
        "model.material.poisson_ratio",
        "model.material.density",
    ];
    let all: Vec<usize> = (0..AMPLITUDES).collect();
    let scene = scene(&json!({ "analyses": { "sensitivities": parameters } }));
    let found = compare(&scene, &all);
    found
        .iter()
        .for_each(|(parameter, errors)| println!("{parameter}: {errors:?}"));
    assert!(
        found
            .iter()
            .all(|(_, errors)| errors.iter().all(|error| *error < ENOUGH))
    );
    let without_tilt: Vec<&str> = parameters.into_iter().filter(|path| !path.contains("tilt")).collect();
    compare_free_motions(&without_tilt, AMPLITUDES);
}
