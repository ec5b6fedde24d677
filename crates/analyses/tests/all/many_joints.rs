//! Structures of several joints: reduced matrices in blocks against dense ones, and what each joint does.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::BENCHMARKS;
use analyses::results::summary::Summary;
use analyses::{Run, run};
use bolted_structures::{Chain, Flange, Frame};
use dense_algebra::SystemMatrix;
use joints::Options;
use joints::progress::{Progress, Silent};
use joints::structure::Structure;
use scenes::{OwnInterface, Scene};
use serde_json::{Value, json};
use std::sync::Mutex;
use test_support::TemporaryFolder;

/// A short chain with few linear elements, and a change of its scene.
fn chain(folder: &TemporaryFolder, joints: usize, change: impl Fn(&mut Value)) -> Scene {
    let value = chain_value(folder, joints, change);
    Scene::from_json(&value.to_string(), "the test's scene", "chain", &BENCHMARKS).unwrap()
}

/// [`chain`] as it is written.
fn chain_value(folder: &TemporaryFolder, joints: usize, change: impl Fn(&mut Value)) -> Value {
    let chain = Chain {
        joints,
        along: 8,
        across: 4,
    };
    let path = folder.join("chain.msh");
    std::fs::write(&path, chain.mesh().unwrap()).unwrap();
    let mut value = chain.scene("chain.msh");
    value["model"]["element_order"] = json!("linear");
    value["model"]["coupling_tolerance"] = json!(0.0);
    value["interfaces"]["points_per_direction"] = json!(2);
    value["analyses"]["backbone"]["amplitudes"] = json!(3);
    // Wide rings, as elements are larger than washers.
    for bolt in value["structure"]["mesh"]["bolts"].as_array_mut().unwrap() {
        bolt["size"] = json!("M12");
    }
    change(&mut value);
    value["structure"]["mesh"]["path"] = json!(path);
    value
}

fn found(scene: &Scene) -> Run {
    run(scene, &Options::default(), &Silent).unwrap()
}

/// Numbers of a document whose names end like this, in order.
fn numbers(value: &Value, ending: &str) -> Vec<f64> {
    let below = |name: &str, value: &Value| -> Vec<f64> {
        match value {
            Value::Number(number) if name.ends_with(ending) => number.as_f64().into_iter().collect(),
            Value::Array(list) if name.ends_with(ending) => list.iter().filter_map(Value::as_f64).collect(),
            other => numbers(other, ending),
        }
    };
    match value {
        Value::Object(fields) => fields.iter().flat_map(|(name, value)| below(name, value)).collect(),
        Value::Array(list) => list.iter().flat_map(|value| numbers(value, ending)).collect(),
        _ => Vec::new(),
    }
}

/// Compares what a scene gives with dense matrices and with blocks of this tolerance: largest relative differences of frequencies, damping ratios and
/// dissipations, of which there are at least as many.
fn differences(dense: &Value, blocks: &Value, place: &str, endings: [&str; 2]) -> [f64; 2] {
    endings.map(|ending| {
        let (a, b) = (numbers(&dense[place], ending), numbers(&blocks[place], ending));
        assert!(
            !a.is_empty() && a.len() == b.len(),
            "{place}: {} and {}",
            a.len(),
            b.len()
        );
        let pairs = a.iter().zip(&b).filter(|(a, _)| **a != 0.0);
        pairs.map(|(a, b)| (b / a - 1.0).abs()).fold(0.0, f64::max)
    })
}

fn summary(run: &Run) -> Value {
    let mut summary = Summary::new(run, Default::default(), None);
    // What is dissipated around a bolt is a part of what its interface does, which is compared.
    summary.backbone.iter_mut().for_each(|point| point.connections.clear());
    serde_json::to_value(summary).unwrap()
}

#[test]
#[ignore = "twenty seconds; `.ci/run slow` runs it"]
fn slow_blocks_give_what_dense_matrices_give_the_nearer_the_smaller_their_tolerance() {
    let folder = TemporaryFolder::new("many-joints");
    for (joints, behaviour) in [(2, "dead-load"), (4, "locked")] {
        let with = |tolerance: f64| {
            let scene = chain(&folder, joints, |value| {
                value["model"]["coupling_tolerance"] = json!(tolerance);
                value["bolts"]["behaviour"] = json!(behaviour);
            });
            found(&scene)
        };
        let dense = with(0.0);
        assert!(matches!(dense.model.reduced.stiffness, SystemMatrix::Dense(_)));
        let dense = summary(&dense);
        assert_eq!(dense["model"]["flexibility"]["form"], "dense");
        let (mut last_rank, mut last_error) = (0, f64::INFINITY);
        // Bounds of frequencies and of damping.
        for (tolerance, bounds) in [(1e-6, [1e-6, 3e-5]), (1e-8, [1e-8, 1e-6]), (1e-10, [1e-10, 1e-7])] {
            let blocks = with(tolerance);
            let SystemMatrix::Blocks(stiffness) = &blocks.model.reduced.stiffness else {
                panic!("several interfaces are blocks");
            };
            assert_eq!(stiffness.tree().n_groups(), joints);
            let blocks = summary(&blocks);
            let flexibility = &blocks["model"]["flexibility"];
            let rank = flexibility["rank"].as_u64().unwrap();
            assert_eq!(
                (&flexibility["form"], &flexibility["tolerance"]),
                (&json!("blocks"), &json!(tolerance))
            );
            let measured = flexibility["measured_error"].as_f64().unwrap();
            assert!(
                rank > last_rank && measured < last_error.max(1e-13),
                "{rank} {measured:e}"
            );
            (last_rank, last_error) = (rank, measured);
            for place in ["modes", "backbone"] {
                let found = differences(&dense, &blocks, place, ["frequency_hz", "frequency_hz"])[0];
                println!("{joints} {behaviour} {tolerance:e} {place}: {found:.1e}, rank {rank}");
                assert!(found < bounds[0], "{place}: {found:e}");
            }
            let [damping, dissipation] = differences(&dense, &blocks, "backbone", ["damping_ratio", "dissipation"]);
            println!("{joints} {behaviour} {tolerance:e}: damping {damping:.1e}, dissipation {dissipation:.1e}");
            assert!(
                damping < bounds[1] && dissipation < bounds[1],
                "{damping:e} {dissipation:e}"
            );
        }
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_other_analyses_run_on_blocks_too() {
    let folder = TemporaryFolder::new("many-joints-analyses");
    let flange = Flange { bolts: 4, pad: 6 };
    let mesh = flange.mesh().unwrap();
    let with = |tolerance: f64| {
        let mut scene = flange.scene("mesh.msh");
        let analyses = &mut scene["analyses"];
        analyses["epmc"] = json!({ "harmonics": 3, "modal_amplitudes": { "number": 2, "from": 1e-7, "to": 1e-6 } });
        analyses["ring_down"] = json!({ "release": "2 um", "periods": 6, "steps_per_period": 40 });
        analyses["tightening"] = json!({ "order": [1, 3, 2, 4], "passes": [0.5, 1.0] });
        summary(&modes_of(&folder, &mesh, scene, tolerance).0)
    };
    let (dense, blocks) = (with(0.0), with(1e-7));
    for (place, endings, bound) in [
        // Periodic motions are converged to an accuracy of their own.
        ("methods", ["frequency_hz", "dissipation"], 1e-4),
        ("tightening", ["tensions", "external_work"], 1e-5),
        ("ring_down", ["frequency_hz", "damping_ratio"], 1e-4),
    ] {
        let found = differences(&dense, &blocks, place, endings);
        println!("{place}: {found:.1?}");
        assert!(found.iter().all(|error| *error < bound), "{place}: {found:?}");
    }
}

#[test]
fn each_joint_tells_what_it_does_and_the_loose_one_dissipates() {
    let folder = TemporaryFolder::new("many-joints-apart");
    let scene = chain(&folder, 4, |value| {
        value["model"]["coupling_tolerance"] = json!(1e-7);
        // The second lap is held by a hundredth of the force.
        value["bolts"] = json!({ "loads": ["12 kN", "12 kN", "120 N", "120 N", "12 kN", "12 kN", "12 kN", "12 kN"] });
        value["analyses"]["backbone"]["amplitude_to"] = json!("200 um");
    });
    let run = found(&scene);
    let summary = summary(&run);
    let amplitude = summary["backbone"].as_array().unwrap().last().unwrap();
    let joints = amplitude["joints"].as_array().unwrap();
    let names: Vec<_> = joints.iter().map(|joint| joint["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["lap 1", "lap 2", "lap 3", "lap 4"]);
    let of = |field: &str| -> Vec<f64> { joints.iter().map(|joint| joint[field].as_f64().unwrap()).collect() };
    let (shares, slip, contact) = (
        of("dissipation_share"),
        of("slip_fraction"),
        of("contact_area_fraction"),
    );
    println!("{shares:?} {slip:?} {contact:?}");
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(shares[1] > 0.5 && slip[1] > slip[0].max(slip[2]).max(slip[3]));
    assert!(contact.iter().all(|share| (0.0..=1.0).contains(share)));
    let all = of("dissipation").iter().sum::<f64>();
    assert!((all / amplitude["dissipation"].as_f64().unwrap() - 1.0).abs() < 1e-12);
    // Open areas of the joints are that of the whole.
    let open: f64 = contact.iter().map(|share| 0.25 * (1.0 - share)).sum();
    assert!((open - amplitude["open_fraction"].as_f64().unwrap()).abs() < 1e-12);
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_threads_and_a_stored_model_change_no_bit() {
    let folder = TemporaryFolder::new("many-joints-bits");
    let scene = chain(&folder, 3, |value| value["model"]["coupling_tolerance"] = json!(1e-6));
    let options = Options {
        cache: Some(folder.join("cache")),
        ..Options::default()
    };
    let with = |threads: usize, options: &Options| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| run(&scene, options, &Silent)).unwrap();
        let points = found.amplitudes().iter().map(|amplitude| {
            let result = amplitude.point.result.as_ref().unwrap();
            [result.omega.to_bits(), result.zeta.to_bits()]
        });
        (
            points.collect::<Vec<_>>(),
            found.model.reduced.stiffness,
            found.model.reduced.mass,
        )
    };
    let one = with(1, &options);
    assert!(one == with(2, &options), "from the cache");
    assert!(one == with(3, &Options::default()));
}

#[test]
fn patterns_of_names_and_bolts_are_the_joints_written_one_by_one() {
    let folder = TemporaryFolder::new("many-joints-patterns");
    let with = |change: &dyn Fn(&mut Value)| {
        let change = |value: &mut Value| {
            value["model"]["coupling_tolerance"] = json!(1e-7);
            value["analyses"]["backbone"]["amplitudes"] = json!(1);
            change(&mut value["structure"]["mesh"]);
        };
        Scene::from_json(
            &chain_value(&folder, 2, change).to_string(),
            "the test's scene",
            "chain",
            &BENCHMARKS,
        )
    };
    let written = with(&|mesh| {
        // The pattern of the benchmark, bolt by bolt.
        let bolt = mesh["bolts"][0].clone();
        let [inner, outer] = [0, 1].map(|at| bolt["repeat"][at]["step"][0].as_f64().unwrap());
        let at = |lap: usize, side: usize| {
            let mut bolt = bolt.clone();
            bolt.as_object_mut().unwrap().remove("repeat");
            for end in bolt["axis"].as_array_mut().unwrap() {
                end[0] = json!(end[0].as_f64().unwrap() + lap as f64 * outer + side as f64 * inner);
            }
            bolt
        };
        mesh["bolts"] = (0..2).flat_map(|lap| [at(lap, 0), at(lap, 1)]).collect();
    });
    let by_patterns = with(&|mesh| mesh["interfaces"] = json!([{ "between": ["bar *", "b*r*"] }]));
    let [written, by_patterns] = [written, by_patterns].map(|scene| summary(&found(&scene.unwrap())));
    let names = |summary: &Value| -> Vec<String> {
        let joints = summary["backbone"][0]["joints"].as_array().unwrap().iter();
        joints.map(|joint| joint["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&written), ["lap 1", "lap 2"]);
    assert_eq!(names(&by_patterns), ["bar 1 on bar 2", "bar 2 on bar 3"]);
    // One pair has an interface ahead of the pattern, the other one is left for it.
    let one_ahead = |mesh: &mut Value| {
        mesh["interfaces"] =
            json!([{ "name": "own", "between": ["bar 3", "bar 2"] }, { "between": ["bar *", "b*r*"] }]);
    };
    let one_by_name = summary(&found(&with(&one_ahead).unwrap()));
    assert_eq!(names(&one_by_name), ["own", "bar 1 on bar 2"]);
    let frequencies = |summary: &Value| numbers(&summary["backbone"], "frequency_hz");
    let expected = frequencies(&written);
    for summary in [&by_patterns, &one_by_name] {
        let found = frequencies(summary);
        assert!(!found.is_empty() && found.len() == expected.len());
        for (a, b) in found.iter().zip(&expected) {
            assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
        }
    }
    let mut of_its_own = with(&one_ahead).unwrap();
    of_its_own.interfaces.each = vec![
        OwnInterface {
            mu: Some(0.7),
            ..Default::default()
        },
        Default::default(),
    ];
    let mu: Vec<f64> = numbers(&summary(&found(&of_its_own))["interfaces"], "mu");
    assert_eq!(mu, [0.7, of_its_own.interfaces.mu]);

    for (change, told) in [
        (json!({ "interfaces": [{ "between": ["beam *", "bar *"] }] }), "bar 1"),
        (
            json!({ "interfaces": [{ "between": ["bar 1", "bar 3*"] }] }),
            "none touch",
        ),
        (
            json!({ "bolts": [{ "head": "a", "nut": "b", "repeat": [{ "times": 2, "step": [1, 0, 0] }] }] }),
            "no place",
        ),
        (
            json!({ "bolts": [{ "axis": [[0, 0, 0], [0, 0, 1]], "size": "M8", "repeat": [{ "times": 2 }] }] }),
            "either `step`",
        ),
        (
            json!({ "bolts": [{ "axis": [[0, 0, 0], [0, 0, 1]], "size": "M8", "repeat": [{ "times": 0, "step": [1, 0, 0] }] }] }),
            "from 1 to 10 000",
        ),
        (
            json!({ "bolts": [{ "axis": [[0, 0, 0], [0, 0, 1]], "size": "M8", "repeat": [{ "times": 3, "about": [[1, 0, 0], [1, 0, 0]] }] }] }),
            "same point twice",
        ),
    ] {
        let scene = with(&|mesh| {
            for (field, value) in change.as_object().unwrap() {
                mesh[field] = value.clone();
            }
        });
        let error = match scene {
            Err(error) => error.to_string(),
            Ok(scene) => Structure::try_new(&scene, &Silent).map(|_| ()).unwrap_err().to_string(),
        };
        assert!(error.contains(told), "{error}");
    }
}

#[test]
fn a_joint_without_preload_is_named_where_it_does_not_converge() {
    let folder = TemporaryFolder::new("many-joints-loose");
    let scene = chain(&folder, 4, |value| {
        value["model"]["coupling_tolerance"] = json!(1e-7);
        value["bolts"] = json!({ "loads": ["12 kN", "12 kN", "1 N", "1 N", "12 kN", "12 kN", "12 kN", "12 kN"] });
        value["analyses"]["backbone"]["amplitude_to"] = json!("1 mm");
    });
    let summary = summary(&found(&scene));
    let amplitudes = summary["backbone"].as_array().unwrap();
    let failures: Vec<&str> = amplitudes.iter().filter_map(|a| a["failure"].as_str()).collect();
    assert!(!failures.is_empty() && failures.len() < amplitudes.len());
    assert!(
        failures.iter().all(|failure| failure.contains("`lap 2`")),
        "{failures:?}"
    );
}

#[test]
fn a_bolt_of_another_material_is_another_structure_to_the_cache() {
    let folder = TemporaryFolder::new("many-joints-bolts");
    let with = |modulus: f64| {
        let scene = chain(&folder, 2, |value| {
            for bolt in value["structure"]["mesh"]["bolts"].as_array_mut().unwrap() {
                bolt["material"] = json!({ "youngs_modulus": modulus, "poisson_ratio": 0.3, "density": 7800 });
            }
        });
        Structure::try_new(&scene, &Silent).unwrap().hash(None).finish()
    };
    assert_eq!(with(2e11), with(2e11));
    assert_ne!(with(2e11), with(1e11));
}

#[test]
fn the_stiffness_of_each_joint_changes_frequencies_as_its_energy_says() {
    let folder = TemporaryFolder::new("many-joints-stiffness");
    let with = |factor: f64| {
        let elastic = |normal: f64| {
            json!({ "surface": { "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": {
                "normal_stiffness": normal, "tangential_stiffness": [0.7 * normal, 0.5 * normal] } } }] } } })
        };
        found(&chain(&folder, 2, |value| {
            value["model"]["coupling_tolerance"] = json!(1e-7);
            value["interfaces"]["each"] = json!([elastic(3e11), elastic(1e12 * factor)]);
            value["analyses"]["backbone"]["amplitudes"] = json!(0);
        }))
    };
    let step: f64 = 1e-3;
    let [below, own, above] = [-step, 0.0, step].map(|change| with(change.exp()));
    let sides = above.frequencies.iter().zip(&below.frequencies);
    for ((above, below), told) in sides.zip(&own.by_interface) {
        let change = (above / below).ln() / (2.0 * step);
        assert!(told.len() == 2 && told.iter().all(|part| *part > 0.0) && told.iter().sum::<f64>() < 0.5);
        assert!((told[1] / change - 1.0).abs() < 1e-5, "{} for {change}", told[1]);
    }
}

#[test]
fn derivatives_by_blocks_are_those_by_dense_matrices() {
    let folder = TemporaryFolder::new("many-joints-derivatives");
    let with = |tolerance: f64| {
        let scene = chain(&folder, 2, |value| {
            value["model"]["coupling_tolerance"] = json!(tolerance);
            value["bolts"]["behaviour"] = json!("dead-load");
            let material = "model.material";
            value["analyses"]["sensitivities"] = json!([
                "interfaces.mu",
                "bolts.load",
                format!("{material}.youngs_modulus"),
                format!("{material}.poisson_ratio")
            ]);
            value["analyses"]["epmc"] =
                json!({ "harmonics": 3, "modal_amplitudes": { "number": 2, "from": 1e-6, "to": 1e-5 } });
        });
        summary(&found(&scene))
    };
    let (dense, blocks) = (with(0.0), with(1e-7));
    let all = |summary: &Value| summary["sensitivities"].as_array().unwrap().clone();
    assert_eq!(all(&dense).len(), 8);
    let mut compared = 0;
    for (own, other) in all(&dense).iter().zip(all(&blocks)) {
        assert_eq!(own["by"], "implicit-differentiation");
        for field in ["dln_linear_frequency", "dln_mode_shape", "dln_frequency", "dln_damping"] {
            let (a, b) = (numbers(own, field), numbers(&other, field));
            assert_eq!(a.len(), b.len());
            compared += a.len();
            for (a, b) in a.iter().zip(&b) {
                let (method, parameter) = (&own["method"], &own["parameter"]);
                assert!(
                    (a - b).abs() < 1e-6 * a.abs() + 1e-8,
                    "{method} {parameter} {field}: {a} and {b}"
                );
            }
        }
    }
    // One each of the mode, and three and two amplitudes with frequency and damping.
    assert_eq!(compared, 4 * (2 + 2 * 3) + 4 * (2 + 2 * 2));
}

#[test]
fn what_does_not_fit_blocks_is_refused_by_name() {
    let folder = TemporaryFolder::new("many-joints-refused");
    // A structure of one interface has nothing to couple.
    let value = json!({
        "units": { "length": "mm", "mass": "t", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "coupling_tolerance": 1e-7 },
    });
    let error = Scene::from_json(&value.to_string(), "the test's scene", "beam", &BENCHMARKS).unwrap_err();
    assert!(error.to_string().contains("coupling_tolerance"), "{error}");
    let value = chain_with(&folder, 0.1);
    let error = Scene::from_json(&value.to_string(), "the test's scene", "chain", &BENCHMARKS).unwrap_err();
    assert!(error.to_string().contains("between 0"), "{error}");
}

fn chain_with(folder: &TemporaryFolder, tolerance: f64) -> Value {
    let mut value = Chain::default().scene("chain.msh");
    value["structure"]["mesh"]["path"] = json!(folder.join("chain.msh"));
    value["model"]["coupling_tolerance"] = json!(tolerance);
    value
}

/// What a structure to start from gives with linear elements, without loops.
fn modes_of(folder: &TemporaryFolder, mesh: &str, mut scene: Value, tolerance: f64) -> (Run, Vec<String>) {
    let path = folder.join("mesh.msh");
    std::fs::write(&path, mesh).unwrap();
    scene["structure"]["mesh"]["path"] = json!(path);
    scene["model"]["element_order"] = json!("linear");
    scene["model"]["coupling_tolerance"] = json!(tolerance);
    scene["interfaces"]["points_per_direction"] = json!(2);
    scene["analyses"]["backbone"]["amplitudes"] = json!(0);
    let scene = Scene::from_json(&scene.to_string(), "the test's scene", "joints", &BENCHMARKS).unwrap();
    let notes = Notes::default();
    let found = run(&scene, &Options::default(), &notes).unwrap();
    (found, notes.0.into_inner().unwrap())
}

/// Keeps what is noted.
#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Progress for Notes {
    fn note(&self, text: &str) {
        self.0.lock().unwrap().push(text.to_owned());
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_rings_on_pads_have_the_same_modes_by_blocks() {
    let folder = TemporaryFolder::new("many-joints-flange");
    let flange = Flange { bolts: 6, pad: 6 };
    let mesh = flange.mesh().unwrap();
    let [dense, blocks] = [0.0, 1e-7].map(|tolerance| modes_of(&folder, &mesh, flange.scene("mesh.msh"), tolerance).0);
    assert!(matches!(blocks.model.reduced.stiffness, SystemMatrix::Blocks(_)));
    assert_eq!(blocks.parts.len(), 6);
    for (a, b) in blocks.frequencies.iter().zip(&dense.frequencies) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
    // Each bolt presses its own pad.
    let (area, load) = (blocks.parts[0].area, 12e3);
    let weights = &blocks.interface.operators().weights;
    for points in blocks.interface.points_of_laws() {
        let force: f64 = points
            .map(|p| weights[p] * blocks.prestress.fields.traction[2][p])
            .sum();
        assert!((force / load - 1.0).abs() < 0.05, "{force} of {load}, {area}");
    }
}

#[test]
#[ignore = "twenty seconds; `.ci/run slow` runs it"]
fn slow_bolts_of_a_frame_clamp_what_lies_between_their_ends_and_not_the_level_above() {
    let folder = TemporaryFolder::new("many-joints-frame");
    let frame = Frame::default();
    let (found, notes) = modes_of(&folder, &frame.mesh().unwrap(), frame.scene("mesh.msh"), 1e-6);
    assert_eq!(found.parts.len(), 20);
    let grips: Vec<&String> = notes.iter().filter(|note| note.contains("clamps")).collect();
    assert_eq!(grips.len(), 20);
    // A cross bar on a bar, or a post on a bar.
    for (number, note) in grips.iter().enumerate() {
        let expected = if number % 5 < 3 {
            "clamps 30.000 mm"
        } else {
            "clamps 48.000 mm"
        };
        assert!(note.contains(expected), "{note}");
    }
}
