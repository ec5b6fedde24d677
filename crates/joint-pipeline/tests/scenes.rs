//! What scene files may say, and what they must.
#![expect(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{BENCHMARKS, beam};
use joint_pipeline::scene::{Accuracy, Length, PRESETS, RefinementLevel, Surface, Target, refined};
use joint_pipeline::{Error, Scene};
use serde_json::{Value, json};

fn read(scene: &Value) -> Result<Scene, Error> {
    Scene::from_json(&scene.to_string(), "scene.json", "scene", &BENCHMARKS)
}

fn refused(scene: &Value) -> String {
    read(scene).unwrap_err().to_string()
}

fn units() -> Value {
    json!({ "length": "m", "mass": "kg", "time": "s" })
}

/// A deck with everything that a deck does not say itself.
fn on_deck() -> Value {
    json!({
        "units": units(),
        "structure": { "deck": {
            "path": "joint.inp",
            "top_surface": "TOP",
            "bottom_surface": "BOTTOM",
            "bolts": [{ "top": "HEAD", "bottom": "NUT" }],
            "response": { "node": "TIP", "direction": [0.0, 0.0, 1.0] },
        } },
        "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3 } },
        "surface": { "benchmark": "brake-reuss-beam" },
        "bolts": { "load": "10 kN" },
        "mu": 0.3,
    })
}

#[test]
fn what_a_deck_does_not_say_is_asked_for_with_a_line_to_add() {
    read(&on_deck()).unwrap();
    for (path, name) in [
        ("/mu", "mu"),
        ("/bolts/load", "bolts.load"),
        ("/model/material/youngs_modulus", "model.material.youngs_modulus"),
        ("/model/material/poisson_ratio", "model.material.poisson_ratio"),
        ("/surface", "surface"),
    ] {
        let mut scene = on_deck();
        let (parent, field) = path.rsplit_once('/').unwrap();
        scene
            .pointer_mut(parent)
            .unwrap()
            .as_object_mut()
            .unwrap()
            .remove(field);
        let message = refused(&scene);
        assert!(message.contains(&format!("{name} is missing")), "{message}");
        assert!(message.contains("add for example \""), "{message}");
    }
    // The bodies have the deck's materials, unless the scene's are asked for; then a density is needed.
    let mut own = on_deck();
    own["model"]["material"]["density"] = json!(7850.0);
    assert!(
        refused(&own).contains("model.material.density belongs to"),
        "{}",
        refused(&own)
    );
    own["structure"]["deck"]["materials"] = json!("scene");
    read(&own).unwrap();
    own["model"]["material"].as_object_mut().unwrap().remove("density");
    assert!(refused(&own).contains("model.material.density"), "{}", refused(&own));
}

#[test]
fn measured_faces_are_those_of_a_benchmark_that_is_named() {
    let mut scene = on_deck();
    scene["surface"] = json!("measured");
    assert!(
        refused(&scene).contains("the structure has none"),
        "{}",
        refused(&scene)
    );
    let mut scene = on_deck();
    scene["gap"] = json!("measured");
    assert!(
        refused(&scene).contains("gap asks for a measured surface"),
        "{}",
        refused(&scene)
    );
    scene["gap"] = json!({ "benchmark": "brake-reuss-beam" });
    read(&scene).unwrap();
    scene["gap"] = json!({ "benchmark": "s4" });
    let message = refused(&scene);
    assert!(
        message.contains("no benchmark `s4`; there are brake-reuss-beam"),
        "{message}"
    );
    let mut scene = on_deck();
    scene["structure"] = json!({ "benchmark": "ring" });
    assert!(refused(&scene).contains("no benchmark `ring`"));
}

#[test]
fn a_structure_is_named_once_and_where_it_belongs() {
    let message = refused(&json!({ "units": units(), "mu": 0.2 }));
    assert!(
        message.contains("`structure` is missing") && message.contains("benchmark"),
        "{message}"
    );
    let message = refused(&json!({ "units": units(), "model": { "deck": {} } }));
    assert!(
        message.contains("model.deck is not a field") && message.contains("\"structure\""),
        "{message}"
    );
    let both = json!({ "benchmark": "brake-reuss-beam", "deck": on_deck()["structure"]["deck"] });
    let mut scene = on_deck();
    scene["structure"] = both;
    assert!(read(&scene).is_err());
    let mut scene = on_deck();
    scene["model"]["refinement"] = json!("quick");
    assert!(refused(&scene).contains("model.refinement belongs to meshes of a benchmark"));
}

#[test]
fn wrong_types_name_the_field() {
    let mut scene = on_deck();
    scene["cqsma"] = json!({ "amplitudes": "many" });
    assert!(refused(&scene).contains("cqsma.amplitudes"), "{}", refused(&scene));
    let mut scene = on_deck();
    scene["model"]["material"]["youngs_modulus"] = json!("200 kN");
    let message = refused(&scene);
    assert!(
        message.contains("model.material.youngs_modulus") && message.contains("GPa"),
        "{message}"
    );
    let twice = on_deck().to_string().replace("\"mu\":0.3", "\"mu\":0.3,\"mu\":0.4");
    let error = Scene::from_json(&twice, "scene.json", "scene", &BENCHMARKS).unwrap_err();
    assert!(error.to_string().contains("duplicate field `mu`"), "{error}");
}

#[test]
fn structures_written_as_lists_are_converted_as_well() {
    let scene = |material: Value, bolts: Value| {
        let mut scene = on_deck();
        scene["units"] = json!({ "length": "mm", "mass": "t", "time": "s" });
        scene["structure"]["deck"]["materials"] = json!("scene");
        scene["model"]["material"] = material;
        scene["bolts"] = bolts;
        read(&scene)
    };
    let block = scene(
        json!({ "youngs_modulus": 192_850.0, "poisson_ratio": 0.29, "density": 7.8578e-9 }),
        json!({ "load": 12_845.0, "behaviour": "dead-load" }),
    )
    .unwrap();
    assert!((block.model.material.youngs_modulus.si() / 192.85e9 - 1.0).abs() < 1e-15);
    // Such lists are refused, as the fields of a list have no names; if they were read, every quantity would be SI.
    match scene(
        json!([192_850.0, 0.29, 7.8578e-9, 9470.0]),
        json!([12_845.0, "dead-load"]),
    ) {
        Ok(list) => assert_eq!((list.model.material, list.bolts), (block.model.material, block.bolts)),
        Err(error) => assert!(error.to_string().contains("is missing"), "{error}"),
    }
}

#[test]
fn a_scene_in_inches_is_the_same_scene() {
    let mut metric = on_deck();
    metric["structure"]["deck"]["tie_tolerance"] = json!(2.54e-3);
    metric["cqsma"] = json!({ "amplitude_to": 2.54e-4 });
    let mut inches = on_deck();
    inches["units"] = json!({ "length": "in", "force": "lbf", "time": "s" });
    inches["structure"]["deck"]["tie_tolerance"] = json!(0.1);
    inches["cqsma"] = json!({ "amplitude_to": "10 mil" });
    let (metric, inches) = (read(&metric).unwrap(), read(&inches).unwrap());
    let [a, b] = [&metric, &inches].map(|s| s.structure.deck().unwrap().tie_tolerance.unwrap().si());
    assert!((a / b - 1.0).abs() < 1e-15, "{a} {b}");
    assert!((metric.cqsma.amplitude_to.si() / inches.cqsma.amplitude_to.si() - 1.0).abs() < 1e-15);
    assert_eq!(metric.bolts, inches.bolts);
    // The deck is in the units of the scene.
    let length = inches.structure.deck().unwrap().units.length_in_si();
    assert_eq!(length, 0.0254);
}

#[test]
fn a_scene_is_written_in_si_and_reads_back() {
    for scene in [
        on_deck(),
        json!({ "units": units(), "structure": { "benchmark": "brake-reuss-beam" },
        "cqsma": { "modes_of_interest": [3, 1] } }),
    ] {
        let scene = read(&scene).unwrap();
        let again = read(&serde_json::to_value(&scene).unwrap()).unwrap();
        assert_eq!(scene, again);
    }
}

#[test]
fn several_modes_are_named_once_and_in_range() {
    let scene =
        |modes: Value| json!({ "units": units(), "structure": { "benchmark": "brake-reuss-beam" }, "cqsma": modes });
    assert_eq!(
        read(&scene(json!({ "modes_of_interest": [1, 3] })))
            .unwrap()
            .cqsma
            .followed(),
        [1, 3]
    );
    assert_eq!(read(&scene(json!({ "mode": 3 }))).unwrap().cqsma.followed(), [3]);
    for (modes, said) in [
        (
            json!({ "modes_of_interest": [1, 1] }),
            "different from the modes before it",
        ),
        (json!({ "modes_of_interest": [0] }), "between 1 and cqsma.modes"),
        (json!({ "modes_of_interest": [1, 11] }), "between 1 and cqsma.modes"),
        (
            json!({ "mode": 2, "modes_of_interest": [1] }),
            "cqsma.mode belongs to scenes that follow one mode",
        ),
    ] {
        let message = refused(&scene(modes));
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn the_cheapest_preset_within_a_target_is_chosen() {
    for pair in PRESETS.windows(2) {
        assert!(pair[0].cost < pair[1].cost && pair[0].damping_error >= pair[1].damping_error);
        assert!(pair[0].frequency_error >= pair[1].frequency_error);
    }
    let of = |frequency, damping| Accuracy::Target(Target { frequency, damping }).preset();
    for (index, preset) in PRESETS.iter().enumerate() {
        assert_eq!(of(None, Some(preset.damping_error)).unwrap().name, preset.name);
        if index > 0 {
            let slightly_more = PRESETS[index - 1].damping_error * 0.999;
            assert_eq!(of(None, Some(slightly_more)).unwrap().name, preset.name);
        }
    }
    assert!(of(None, Some(1e-9)).unwrap_err().contains("finest"));
    assert!(of(Some(-1.0), None).unwrap_err().contains("accuracy.frequency"));
    assert!(of(None, None).unwrap_err().contains("empty"));
}

#[test]
fn scenes_get_the_settings_that_they_do_not_give() {
    let read = |more: Value| {
        let mut scene = json!({
            "units": { "length": "mm", "mass": "t", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
        });
        scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        read(&scene)
    };
    let draft = &PRESETS[0];
    let scene = read(json!({ "accuracy": "draft" })).unwrap();
    assert_eq!(
        (scene.model.refinement, scene.points_per_direction),
        (draft.refinement, draft.points_per_direction)
    );
    assert_eq!(scene.model.material, beam("").model.material, "nothing else changes");
    assert_eq!(scene.surface, Surface::Measured);
    let own =
        read(json!({ "accuracy": "draft", "points_per_direction": 3, "cqsma": { "amplitude_to": 1.0 } })).unwrap();
    assert_eq!(own.points_per_direction, 3);
    assert_eq!(own.cqsma.vertices_per_quarter, draft.vertices_per_quarter);
    assert_eq!(own.cqsma.amplitude_to, Length::from_si(1e-3));
    // The standard is what scenes get that ask for nothing.
    let standard = read(json!({ "accuracy": "standard" })).unwrap();
    let mut nothing = read(json!({ "mu": 0.2 })).unwrap();
    nothing.accuracy = standard.accuracy;
    nothing.model.modes = standard.model.modes;
    assert_eq!((nothing.model.n_modes(), &nothing), (20, &standard));
    let text = serde_json::to_string(&own).unwrap();
    let again = Scene::from_json(&text, "test", "test", &BENCHMARKS).unwrap();
    assert_eq!(again, own, "a scene with its settings filled in stays as it is");
    for wrong in [
        json!({ "accuracy": "best" }),
        json!({ "accuracy": { "speed": 1 } }),
        json!({ "accuracy": { "damping": 1e-9 } }),
    ] {
        assert!(
            read(wrong.clone()).unwrap_err().to_string().contains("ccuracy"),
            "{wrong}"
        );
    }
}

#[test]
fn finer_settings_are_finer_in_something_and_coarser_in_nothing() {
    let standard = beam("standard");
    let (preset, fine) = refined(&standard).unwrap();
    assert_eq!(preset.name, "reference");
    assert!(fine.model.refinement as usize > standard.model.refinement as usize);
    let mut vertices = standard.clone();
    vertices.model.refinement = RefinementLevel::Quick;
    vertices.model.modes = Some(10);
    assert_eq!(refined(&vertices).unwrap().0.name, "coarse");
    vertices.cqsma.vertices_per_quarter = 4096;
    assert!(matches!(refined(&vertices), Err(Error::NothingFiner)));
}
