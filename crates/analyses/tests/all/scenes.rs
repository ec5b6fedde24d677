//! What scene files may say, and what they must.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{BENCHMARKS, beam};
use analyses::Error;
use analyses::error_bar::ErrorBar;
use analyses::mesh_error::Partner;
use finite_elements::elements::Formulation;
use joint_model::benchmark::{ElementOrder, RefinementLevel};
use scenes::{
    Accuracy, Friction, GivenSettings, Influence, Length, PRESETS, Parameter, Preset, Scene, Surface, Target, refined,
};
use serde_json::{Value, json};
use std::path::Path;

fn read(scene: &Value) -> Result<Scene, scenes::Error> {
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
        "interfaces": { "surface": { "benchmark": "brake-reuss-beam" }, "mu": 0.3 },
        "bolts": { "load": "10 kN" },
    })
}

#[test]
fn errors_give_field_value_and_remedy_beside_their_message() {
    let on_beam = |rest: Value| {
        let mut scene = json!({ "units": units(), "structure": { "benchmark": "brake-reuss-beam" } });
        scene.as_object_mut().unwrap().extend(rest.as_object().unwrap().clone());
        read(&scene).unwrap_err()
    };
    let value = on_beam(json!({ "analyses": { "backbone": { "amplitude_from": -1.0 } } }));
    assert_eq!(value.field(), Some("analyses.backbone.amplitude_from"));
    assert_eq!(value.value(), Some((-1.0, "m")));
    assert_eq!(value.remedy().unwrap(), "it must be positive and finite");
    for (wrong, field) in [
        (
            // A block of its own kind: its message says which of its units is wrong.
            json!({ "units": { "length": "ell", "mass": "kg", "time": "s" } }),
            "units",
        ),
        (json!({ "bolts": { "load": "12 parsec" } }), "bolts.load"),
        (json!({ "bolts": [12e3] }), "bolts"),
        (json!({ "structure": { "benchmark": "none" } }), "structure.benchmark"),
        (json!({ "accuracy": { "damping": -1.0 } }), "accuracy"),
    ] {
        let error = on_beam(wrong);
        assert_eq!((error.field(), error.value()), (Some(field), None), "{error}");
    }
    let idle = on_beam(json!({ "interfaces": { "law": { "friction": "lumped", "bins": { "gauss": 8 } } } }));
    assert_eq!(idle.field(), Some("interfaces.law.bins"));
    assert_eq!(idle.remedy().unwrap(), "leave one of them out");
    let mut scene = on_deck();
    scene["interfaces"].as_object_mut().unwrap().remove("mu");
    assert_eq!(read(&scene).unwrap_err().field(), Some("interfaces.mu"));
    assert_eq!(read(&json!([])).unwrap_err().field(), Some("units"));
    assert_eq!(
        Scene::from_json("{", "scene.json", "scene", &BENCHMARKS)
            .unwrap_err()
            .field(),
        None
    );
}

#[test]
fn what_a_deck_does_not_say_is_asked_for_with_a_line_to_add() {
    read(&on_deck()).unwrap();
    for (path, name) in [
        ("/interfaces/mu", "interfaces.mu"),
        ("/bolts/load", "bolts.load"),
        ("/model/material/youngs_modulus", "model.material.youngs_modulus"),
        ("/model/material/poisson_ratio", "model.material.poisson_ratio"),
        ("/interfaces/surface", "interfaces.surface"),
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
    scene["interfaces"]["surface"] = json!("measured");
    assert!(
        refused(&scene).contains("the structure has none"),
        "{}",
        refused(&scene)
    );
    let mut scene = on_deck();
    scene["interfaces"]["gap"] = json!("measured");
    assert!(
        refused(&scene).contains("interfaces.gap asks for a measured surface"),
        "{}",
        refused(&scene)
    );
    scene["interfaces"]["gap"] = json!({ "benchmark": "brake-reuss-beam" });
    read(&scene).unwrap();
    scene["interfaces"]["gap"] = json!({ "benchmark": "s4" });
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
    let message = refused(&json!({ "units": units(), "interfaces": { "mu": 0.2 } }));
    assert!(
        message.contains("`structure` is missing") && message.contains("benchmark"),
        "{message}"
    );
    let message = refused(&json!({ "units": units(), "model": { "deck": {} } }));
    assert!(message.contains("model.deck is now structure.deck"), "{message}");
    let both = json!({ "benchmark": "brake-reuss-beam", "deck": on_deck()["structure"]["deck"] });
    let mut scene = on_deck();
    scene["structure"] = both;
    assert!(refused(&scene).contains("exactly one of `benchmark`, `deck`, `mesh` and `matrices`"));
    scene["structure"] = json!({});
    assert!(refused(&scene).contains("exactly one of `benchmark`, `deck`, `mesh` and `matrices`"));
    scene["structure"] = json!({ "meshes": "a.msh" });
    assert!(
        refused(&scene).contains("structure")
            && refused(&scene).contains("`meshes`, expected one of `benchmark`, `deck`")
    );
    let mut scene = on_deck();
    scene["model"]["refinement"] = json!("quick");
    assert!(refused(&scene).contains("model.refinement belongs to meshes of a benchmark"));
}

#[test]
fn masses_name_their_nodes_as_the_structure_has_them() {
    let benchmark = |masses: Value| {
        json!({ "units": { "length": "mm", "mass": "g", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam", "point_masses": masses } })
    };
    let scene = read(&benchmark(
        json!([{ "at": [360.0, 0.0, "1 cm"], "within": 3.0, "mass": 0.8 }]),
    ))
    .unwrap();
    let [mass] = &scene.structure.point_masses[..] else {
        panic!("one mass was given")
    };
    assert_eq!(mass.at.unwrap().map(Length::si), [0.36, 0.0, 0.01]);
    assert!((mass.mass.si() / 8e-4 - 1.0).abs() < 1e-15);
    let written = serde_json::to_value(&scene).unwrap();
    assert_eq!(written["structure"]["benchmark"], "brake-reuss-beam");
    assert_eq!(
        written["structure"]["point_masses"][0]["mass"].as_f64(),
        Some(mass.mass.si())
    );
    assert_eq!(read(&written).unwrap(), scene);

    let mut deck = on_deck();
    let masses = |deck: &mut Value, masses: Value| deck["structure"]["point_masses"] = masses;
    masses(
        &mut deck,
        json!([{ "node": "TIP", "mass": "0.8 g" }, { "node": "4", "mass": 1e-3 }]),
    );
    assert_eq!(read(&deck).unwrap().structure.point_masses.len(), 2);
    for (mass, reason) in [
        (json!({ "at": [0.0, 0.0, 0.0], "mass": 1.0 }), "name the `node`"),
        (json!({ "node": "TIP", "within": 1.0, "mass": 1.0 }), "name the `node`"),
        (json!({ "node": "TIP" }), "missing field `mass`"),
        (json!({ "node": "TIP", "mass": -1.0 }), "must be positive"),
        (json!({ "node": "TIP", "mass": "1 mm" }), "not a mass"),
        (
            json!({ "node": "TIP", "mass": 1.0, "inertia": 1.0 }),
            "unknown field `inertia`",
        ),
    ] {
        masses(&mut deck, json!([mass]));
        let message = refused(&deck);
        assert!(message.contains(reason), "{message}");
    }
    let message = refused(&benchmark(json!([{ "node": "TIP", "mass": 1.0 }])));
    assert!(message.contains("number 1") && message.contains("`at`"), "{message}");
    let mut half = benchmark(json!([{ "at": [0.0, 0.0, 0.0], "mass": 1.0 }]));
    half["model"] = json!({ "symmetry": "half" });
    assert!(refused(&half).contains("structure.point_masses need not be symmetric"));
    let mut matrices = on_deck();
    matrices["structure"] = json!({
        "matrices": { "path": "m.npz", "coordinates": "jump" },
        "point_masses": [{ "node": "1", "mass": 1.0 }],
    });
    let message = refused(&matrices);
    assert!(message.contains("matrices show no nodes"), "{message}");
}

#[test]
fn wrong_types_name_the_field() {
    let mut scene = on_deck();
    scene["analyses"] = json!({ "backbone": { "amplitudes": "many" } });
    assert!(
        refused(&scene).contains("analyses.backbone.amplitudes"),
        "{}",
        refused(&scene)
    );
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
fn materials_and_bolts_written_as_lists_are_refused() {
    let units = json!({ "length": "mm", "mass": "kg", "time": "s" });
    let material = json!([192_850_000.0, 0.29, 7.8578e-6, 9_470_000.0]);
    let bolts = json!([12_845e3, "dead-load"]);
    let benchmark = json!({ "structure": { "benchmark": "brake-reuss-beam" } });
    for mut scene in [on_deck(), benchmark] {
        scene["units"] = units.clone();
        if scene["structure"].get("deck").is_some() {
            scene["structure"]["deck"]["materials"] = json!("scene");
            scene["model"]["material"]["density"] = json!(7.8578e-6);
        }
        read(&scene).unwrap();
        let mut listed = scene.clone();
        listed["model"] = json!({ "material": material });
        let message = refused(&listed);
        assert!(message.contains("model.material is a list"), "{message}");
        let mut listed = scene.clone();
        listed["bolts"] = bolts.clone();
        let message = refused(&listed);
        assert!(message.contains("bolts is a list"), "{message}");
    }
}

/// JSON whose objects keep the order of their fields, which is that of their declaration.
#[derive(Clone)]
enum Ordered {
    Leaf(Value),
    List(Vec<Ordered>),
    Block(Vec<(String, Ordered)>),
}

impl<'de> serde::Deserialize<'de> for Ordered {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> serde::de::Visitor<'de> for Any {
            type Value = Ordered;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("JSON")
            }

            fn visit_unit<E>(self) -> Result<Ordered, E> {
                Ok(Ordered::Leaf(Value::Null))
            }

            fn visit_bool<E>(self, value: bool) -> Result<Ordered, E> {
                Ok(Ordered::Leaf(value.into()))
            }

            fn visit_u64<E>(self, value: u64) -> Result<Ordered, E> {
                Ok(Ordered::Leaf(value.into()))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Ordered, E> {
                Ok(Ordered::Leaf(value.into()))
            }

            fn visit_f64<E>(self, value: f64) -> Result<Ordered, E> {
                Ok(Ordered::Leaf(value.into()))
            }

            fn visit_str<E>(self, value: &str) -> Result<Ordered, E> {
                Ok(Ordered::Leaf(value.into()))
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut list: A) -> Result<Ordered, A::Error> {
                let mut all = Vec::new();
                while let Some(value) = list.next_element()? {
                    all.push(value);
                }
                Ok(Ordered::List(all))
            }

            fn visit_map<A: serde::de::MapAccess<'de>>(self, mut block: A) -> Result<Ordered, A::Error> {
                let mut all = Vec::new();
                while let Some(entry) = block.next_entry()? {
                    all.push(entry);
                }
                Ok(Ordered::Block(all))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

impl Ordered {
    /// As plain JSON, with the block that `n` counts down to as a list; its path is given back.
    fn with_list(&self, n: &mut usize, path: &str, found: &mut Option<String>) -> Value {
        match self {
            Self::Leaf(value) => value.clone(),
            Self::List(list) => {
                let items = list.iter().enumerate();
                items
                    .map(|(i, item)| item.with_list(n, &format!("{path}/{i}"), found))
                    .collect()
            }
            Self::Block(fields) => {
                let this = *n == 0;
                *n = n.wrapping_sub(1);
                let of = |(name, value): &(String, Self), n: &mut usize, found: &mut Option<String>| {
                    (name.clone(), value.with_list(n, &format!("{path}/{name}"), found))
                };
                let mut all = Vec::new();
                for field in fields {
                    all.push(of(field, n, found));
                }
                if this {
                    *found = Some(path.to_owned());
                    return all.into_iter().map(|(_, value)| value).collect();
                }
                Value::Object(all.into_iter().collect())
            }
        }
    }
}

/// Every block of scenes that have all blocks there are, one by one, as the list of its values.
#[test]
fn no_block_of_a_scene_may_be_a_list() {
    let elastic = json!({ "elastic": { "normal_stiffness": 1e13, "tangential_stiffness": [7e12, 7e12] } });
    let fitted = json!({ "fitted": {
        "normal": [13.0, 2.2, 0.4, 0.5, 1.2], "tangential": [[28.0, 1.5, 0.3, 0.6], [28.0, 1.5, 0.3, 0.6]],
        "u_ref": 1e-6, "range": [1e-7, 1e-5],
    } });
    let benchmark = |surface: Value| {
        json!({
            "units": units(),
            "structure": { "benchmark": "brake-reuss-beam" },
            "interfaces": { "surface": surface },
        })
    };
    let mut deck = on_deck();
    deck["structure"]["deck"]["materials"] = json!("scene");
    deck["model"]["material"] = json!({
        "youngs_modulus": 192.85e9, "poisson_ratio": 0.29, "density": 7857.8, "hardness": 3e9, "work_of_adhesion": 0.1,
    });
    deck["structure"]["deck"]["tie_tolerance"] = json!(1e-3);
    deck["structure"]["deck"]["pair_tolerance"] = json!(1e-4);
    deck["structure"]["point_masses"] = json!([{ "node": "TIP", "mass": 1e-3 }]);
    deck["output"] = json!({ "fields_at": [1] });
    deck["accuracy"] = json!({ "damping": 0.5 });
    deck["analyses"] = json!({ "backbone": { "methods": ["qsma"] } });
    let mut matrices = on_deck();
    matrices["structure"] = json!({ "matrices": {
        "path": "joint.npz",
        "coordinates": { "both-sides": { "top": [1, 2, 3], "bottom": [4, 5, 6], "frame": [[1, 0, 0], [0, 1, 0], [0, 0, 1]] } },
        "interface": { "nodes": [[0, 0], [1, 0], [0, 1]], "elements": [[1, 2, 3]] },
        "bolts": [{ "number": 1 }, { "terms": [[1, 3, 1.0]] }],
        "response": { "number": 1 },
        "bolt_hole_clearance": 1e-4,
    } });
    let mut paths = std::collections::BTreeSet::new();
    for scene in [
        deck,
        matrices,
        benchmark(json!({ "parameters": { "per": "interface", "sets": [{ "curves": elastic, "gap": 1e-6 }] } })),
        benchmark(json!({ "parameters": { "per": "interface", "sets": [{ "curves": fitted }] } })),
        benchmark(json!({ "synthetic-scan": {} })),
        benchmark(
            json!({ "scans": { "top": { "path": "a.x3p", "place": { "origin": [0.0, 0.0] }, "height_step": 1e-9 },
            "bottom": "b.x3p", "align": 1e-3, "noise": { "s_filter": 1e-5 } } }),
        ),
    ] {
        let full = read(&scene).unwrap_or_else(|error| panic!("{scene}: {error}"));
        let ordered: Ordered = serde_json::from_str(&serde_json::to_string(&full).unwrap()).unwrap();
        let mut millimetres = serde_json::to_value(&full).unwrap();
        millimetres["units"] = json!({ "length": "mm", "mass": "kg", "time": "s" });
        read(&millimetres).unwrap_or_else(|error| panic!("{millimetres}: {error}"));
        for block in 0.. {
            let (mut n, mut path) = (block, None);
            let mut listed = ordered.with_list(&mut n, "", &mut path);
            let Some(path) = path else { break };
            if !path.is_empty() && path != "/units" {
                listed["units"] = json!({ "length": "mm", "mass": "kg", "time": "s" });
            }
            assert!(read(&listed).is_err(), "{path} as a list: {listed}");
            paths.insert(path);
        }
    }
    for path in [
        "",
        "/units",
        "/bolts",
        "/model",
        "/model/material",
        "/interfaces",
        "/interfaces/law",
        "/analyses",
        "/analyses/modes",
        "/analyses/backbone",
        "/output",
        "/accuracy",
        "/structure",
        "/structure/deck",
        "/structure/point_masses/0",
        "/structure/deck/units",
        "/structure/deck/bolts/0",
        "/structure/deck/response",
        "/structure/matrices",
        "/structure/matrices/interface",
        "/structure/matrices/coordinates/both-sides",
        "/interfaces/surface/parameters",
        "/interfaces/surface/parameters/sets/0",
        "/interfaces/surface/parameters/sets/0/curves/elastic",
        "/interfaces/surface/parameters/sets/0/curves/fitted",
        "/interfaces/surface/synthetic-scan",
        "/interfaces/surface/synthetic-scan/registration",
        "/interfaces/surface/scans",
        "/interfaces/surface/scans/top",
        "/interfaces/surface/scans/registration",
        "/interfaces/surface/scans/noise",
        "/interfaces/surface/scans/readings",
    ] {
        assert!(paths.contains(path), "{path} is in no scene of this test: {paths:?}");
    }
}

#[test]
fn a_scene_in_inches_is_the_same_scene() {
    let mut metric = on_deck();
    metric["structure"]["deck"]["tie_tolerance"] = json!(2.54e-3);
    metric["analyses"] = json!({ "backbone": { "amplitude_to": 2.54e-4 } });
    let mut inches = on_deck();
    inches["units"] = json!({ "length": "in", "force": "lbf", "time": "s" });
    inches["structure"]["deck"]["tie_tolerance"] = json!(0.1);
    inches["analyses"] = json!({ "backbone": { "amplitude_to": "10 mil" } });
    let (metric, inches) = (read(&metric).unwrap(), read(&inches).unwrap());
    let [a, b] = [&metric, &inches].map(|s| s.structure.deck().unwrap().tie_tolerance.unwrap().si());
    assert!((a / b - 1.0).abs() < 1e-15, "{a} {b}");
    let [a, b] = [&metric, &inches].map(|s| s.analyses.backbone.amplitude_to.si());
    assert!((a / b - 1.0).abs() < 1e-15, "{a} {b}");
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
        "analyses": { "modes": { "followed": [3, 1] }, "backbone": {} } }),
    ] {
        let scene = read(&scene).unwrap();
        let again = read(&serde_json::to_value(&scene).unwrap()).unwrap();
        assert_eq!(scene, again);
    }
}

#[test]
fn several_modes_are_named_once_and_in_range() {
    let scene = |followed: Value| {
        json!({
            "units": units(),
            "structure": { "benchmark": "brake-reuss-beam" },
            "analyses": { "modes": { "followed": followed }, "backbone": {} },
        })
    };
    let followed = |modes: Value| read(&scene(modes)).unwrap().analyses.modes.followed;
    assert_eq!(followed(json!([1, 3])), [1, 3]);
    assert_eq!(followed(json!([3])), [3]);
    for (modes, said) in [
        (json!([1, 1]), "different from the modes before it"),
        (json!([0]), "between 1 and analyses.modes.number"),
        (json!([1, 11]), "between 1 and analyses.modes.number"),
        (json!([]), "at least one"),
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
    let of = |frequency, damping| {
        let given = GivenSettings::default();
        let target = Target {
            frequency,
            damping,
            given,
        };
        Accuracy::Target(target).preset()
    };
    for (index, preset) in PRESETS.iter().enumerate() {
        assert_eq!(of(None, Some(preset.damping_error)).unwrap().name, preset.name);
        if index > 0 {
            let slightly_more = PRESETS[index - 1].damping_error * 0.999;
            assert_eq!(of(None, Some(slightly_more)).unwrap().name, preset.name);
        }
    }
    // A run refines further from there.
    assert_eq!(of(None, Some(1e-9)).unwrap().name, PRESETS[PRESETS.len() - 1].name);
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
        (scene.model.refinement, scene.interfaces.points_per_direction),
        (draft.refinement, draft.points_per_direction)
    );
    assert_eq!(scene.model.material, beam("").model.material, "nothing else changes");
    assert_eq!(scene.interfaces.surface, Surface::Measured);
    let own = read(json!({
        "accuracy": "draft",
        "interfaces": { "points_per_direction": 3 },
        "analyses": { "backbone": { "amplitude_to": 1.0 } },
    }))
    .unwrap();
    assert_eq!(own.interfaces.points_per_direction, 3);
    assert_eq!(own.analyses.backbone.vertices_per_quarter, draft.vertices_per_quarter);
    assert_eq!(own.analyses.backbone.amplitude_to, Length::from_si(1e-3));
    // The mesh of `standard` is that of scenes that ask for nothing. A scene that gives the order keeps it, on the mesh of the method
    // paper, as no refinement of the set was measured with it; one that gives the refinement has the order of the set.
    let mesh = |scene: &Scene| (scene.element_order(), scene.model.refinement);
    let standard = read(json!({ "accuracy": "standard" })).unwrap();
    let nothing = read(json!({})).unwrap();
    for scene in [&standard, &nothing] {
        assert_eq!(mesh(scene), (ElementOrder::Quadratic, RefinementLevel::Coarse));
        assert_eq!(scene.interfaces.law.friction(), Friction::Foundation);
        assert_eq!(Preset::of(scene).unwrap().name, "standard");
    }
    for (own, expected) in [
        (
            json!({ "refinement": "fine" }),
            (ElementOrder::Quadratic, RefinementLevel::Fine),
        ),
        (
            json!({ "element_order": "linear" }),
            (ElementOrder::Linear, RefinementLevel::Default),
        ),
        (
            json!({ "formulation": "full" }),
            (ElementOrder::Quadratic, RefinementLevel::Coarse),
        ),
    ] {
        let kept = read(json!({ "accuracy": "standard", "model": own })).unwrap();
        assert_eq!(mesh(&kept), expected, "{own}");
        let [own_points, points] = [&kept, &standard].map(|scene| scene.interfaces.points_per_direction);
        assert_eq!(own_points, points, "{own}");
    }
    let text = serde_json::to_string(&own).unwrap();
    let again = Scene::from_json(&text, "test", "test", &BENCHMARKS).unwrap();
    assert_eq!(again, own, "a scene with its settings filled in stays as it is");
    for wrong in [
        json!({ "accuracy": "best" }),
        json!({ "accuracy": { "speed": 1 } }),
        json!({ "accuracy": { "damping": -1.0 } }),
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
    let mut linear = beam("linear");
    linear.model.formulation = Some(Formulation::IncompatibleModes);
    let (preset, fine) = refined(&linear).unwrap();
    assert_eq!(preset.name, "standard");
    // A coarse quadratic mesh is finer than any linear one, and incompatible modes are none of its formulations.
    assert_eq!(fine.element_order(), ElementOrder::Quadratic);
    assert_eq!((fine.model.formulation, fine.hexahedra()), (None, Formulation::Reduced));
    let (preset, finer) = refined(&fine).unwrap();
    assert_eq!(preset.name, "reference");
    assert!(finer.model.refinement as usize > fine.model.refinement as usize);
    let mut vertices = beam("vertices");
    vertices.model.refinement = RefinementLevel::Quick;
    vertices.model.modes = Some(10);
    assert_eq!(refined(&vertices).unwrap().0.name, "coarse");
    vertices.analyses.backbone.vertices_per_quarter = 4096;
    assert!(matches!(refined(&vertices), Err(scenes::Error::NothingFiner)));
}

#[test]
fn elements_of_benchmarks_and_decks_may_be_quadratic() {
    let on_beam = |model: Value| {
        let text = json!({ "units": units(), "structure": { "benchmark": "brake-reuss-beam" }, "model": model });
        Scene::from_json(&text.to_string(), "a test", "a test", &BENCHMARKS).map_err(|error| error.to_string())
    };
    assert_eq!(
        on_beam(json!({ "element_order": "linear" })).unwrap().hexahedra(),
        Formulation::IncompatibleModes
    );
    let scene = on_beam(json!({ "element_order": "quadratic" })).unwrap();
    assert_eq!(scene.hexahedra(), Formulation::Reduced);
    let full = on_beam(json!({ "element_order": "quadratic", "formulation": "full" })).unwrap();
    assert_eq!(full.hexahedra(), Formulation::Full);
    for formulation in ["incompatible-modes", "b-bar"] {
        let message = on_beam(json!({ "element_order": "quadratic", "formulation": formulation })).unwrap_err();
        assert!(
            message.contains(formulation) && message.contains("choose one of reduced, full"),
            "{message}"
        );
    }

    // Those of a deck too; its linear ones have any formulation, and keep theirs where they do not.
    let mut deck = on_deck();
    deck["model"]["formulation"] = json!("b-bar");
    assert_eq!(read(&deck).unwrap().element_order(), ElementOrder::Linear);
    deck["model"]["element_order"] = json!("quadratic");
    assert!(
        refused(&deck).contains("choose one of reduced, full"),
        "{}",
        refused(&deck)
    );
    deck["model"]["formulation"] = Value::Null;
    assert_eq!(read(&deck).unwrap().hexahedra(), Formulation::Reduced);
    let matrices = json!({
        "units": units(),
        "structure": { "matrices": { "path": "joint.npz", "coordinates": "jump" } },
        "model": { "material": deck["model"]["material"], "element_order": "quadratic" },
        "interfaces": { "surface": { "benchmark": "brake-reuss-beam" }, "mu": 0.2 },
        "bolts": { "load": 1.2e4 },
    });
    assert!(
        refused(&matrices).contains("model.element_order belongs to"),
        "{}",
        refused(&matrices)
    );

    // The partner of reduced integration is full integration, and the other way round.
    for (own, other) in [
        (None, Formulation::Full),
        (Some(Formulation::Full), Formulation::Reduced),
    ] {
        let mut quick = scene.clone();
        (quick.model.refinement, quick.model.formulation) = (RefinementLevel::Quick, own);
        let partner = Partner::try_new(&quick).unwrap();
        assert_eq!(partner.scene.hexahedra(), other);
    }
}

#[test]
fn the_error_of_a_mesh_is_known_where_it_was_measured() {
    let known = |scene: &Scene| {
        let bar = ErrorBar::of(scene);
        assert!(!bar.source.is_empty());
        assert_eq!(bar.frequency_relative.is_some(), bar.damping_ln.is_some());
        bar.frequency_relative
    };
    let levels = [
        RefinementLevel::Quick,
        RefinementLevel::Coarse,
        RefinementLevel::Default,
        RefinementLevel::Fine,
        RefinementLevel::Finest,
    ];
    for (element_order, hexahedra, measured) in [
        (ElementOrder::Linear, None, 5),
        (ElementOrder::Linear, Some(Formulation::Reduced), 5),
        (ElementOrder::Quadratic, None, 4),
        (ElementOrder::Quadratic, Some(Formulation::Full), 3),
    ] {
        let mut last = f64::INFINITY;
        for refinement in levels.into_iter().take(measured) {
            let mut scene = beam("family");
            scene.model.element_order = Some(element_order);
            (scene.model.refinement, scene.model.formulation) = (refinement, hexahedra);
            let error = known(&scene).unwrap();
            assert!(error > 0.0 && error < last, "{refinement:?}: {error} after {last}");
            last = error;
        }
    }
    // What was not measured has no figure, but a reason.
    let changed = |change: fn(&mut Scene)| {
        let mut scene = beam("changed");
        change(&mut scene);
        assert_eq!(known(&scene), None);
        ErrorBar::of(&scene).source
    };
    assert!(changed(|scene| scene.model.arm_layers = Some(10)).contains("arm_layers"));
    assert!(changed(|scene| scene.model.formulation = Some(Formulation::Full)).contains("formulation"));
    let finest = |scene: &mut Scene| {
        (scene.model.element_order, scene.model.refinement) = (Some(ElementOrder::Quadratic), RefinementLevel::Finest);
    };
    assert!(changed(finest).contains("refinement"));
    assert!(changed(|scene| scene.analyses.modes.followed[0] = 3).contains("first mode"));
    assert!(changed(|scene| scene.analyses.modes.followed = vec![1, 3]).contains("first mode"));
    let deck = read(&on_deck()).unwrap();
    assert!(known(&deck).is_none() && ErrorBar::of(&deck).source.contains("deck"));
    let matrices = read(&json!({
        "units": units(),
        "structure": { "matrices": {
            "path": "joint.npz",
            "coordinates": "jump",
            "interface": { "nodes": [[0, 0], [1, 0], [0, 1]], "elements": [[1, 2, 3]] },
            "bolts": [{ "number": 1 }],
            "response": { "number": 1 },
        } },
        "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3 } },
        "interfaces": { "surface": { "benchmark": "brake-reuss-beam" }, "mu": 0.3 },
        "bolts": { "load": "10 kN" },
    }))
    .unwrap();
    assert!(known(&matrices).is_none() && ErrorBar::of(&matrices).source.contains("matrices"));
    let error = Partner::try_new(&matrices).unwrap_err();
    assert!(
        matches!(error, Error::OneFormulation { .. }) && error.to_string().contains("matrices"),
        "{error}"
    );
}

#[test]
fn numbers_of_a_scene_are_named_by_their_paths() {
    let scene = beam("paths");
    let value = |path: &str| Parameter::new(path).value(&scene);
    assert_eq!(value("interfaces.mu").unwrap(), scene.interfaces.mu);
    assert_eq!(value("bolts.load").unwrap(), scene.bolts.load.si());
    assert_eq!(value("interfaces.scale.gap_tilt.1").unwrap_or(0.0), 0.0);
    for (path, unit, influence) in [
        ("interfaces.mu", "", Influence::Interface),
        ("bolts.load", "N", Influence::Loads),
        ("model.material.youngs_modulus", "Pa", Influence::Structure),
        ("model.material.density", "kg/m^3", Influence::Structure),
        ("model.material.poisson_ratio", "", Influence::Structure),
        ("interfaces.scale.asperity_radius", "", Influence::Interface),
        ("interfaces.scale.gap_tilt.0", "", Influence::Interface),
    ] {
        let parameter = Parameter::new(path);
        assert_eq!(parameter.unit(&scene).unwrap(), unit, "{path}");
        assert_eq!(parameter.influence(), influence);
        let before = parameter.value(&scene).unwrap();
        let varied = parameter.with(&scene, before * 1.01 + 1e-3).unwrap();
        assert_eq!(parameter.value(&varied).unwrap(), before * 1.01 + 1e-3, "{path}");
        assert_eq!(parameter.with(&varied, before).unwrap(), scene, "nothing else changes");
    }
    // Of bolts with loads of their own the common load is a factor on all.
    let mut own = scene.clone();
    own.bolts.loads = [10e3, 12e3, 14e3].map(scenes::Force::from_si).to_vec();
    own.bolts.load = own.bolts.loads[0];
    let doubled = Parameter::new("bolts.load").with(&own, 20e3).unwrap();
    assert_eq!(doubled.bolts.loads[2].si(), 28e3);
    let one = Parameter::new("bolts.loads.0").with(&own, 11e3).unwrap();
    assert_eq!(
        (one.tension(0), one.tension(1), one.bolts.load.si()),
        (11e3, 12e3, 11e3)
    );
    for (path, why) in [
        (
            "analyses.backbone.tolerance",
            "it is no number that the physics depends on",
        ),
        ("mus", "it is no number that the physics depends on"),
        ("bolts.loads.1", "bolts has assembly, behaviour, load"),
        ("model.material.density.x", "the scene has no number there"),
        (
            "interfaces.scale.gap_tilt.2",
            "interfaces.scale.gap_tilt has 2 elements, counted from 0",
        ),
        (
            "interfaces.law.yield.strength",
            "the scene has no such number; interfaces.law has bins",
        ),
    ] {
        let message = value(path).unwrap_err().to_string();
        assert!(message.contains(why), "{path}: {message}");
    }
    assert!(Parameter::new("interfaces.mu").with(&scene, -0.1).is_err());
    let asking = |parameters: Value| {
        let mut scene = json!({ "units": units(), "structure": { "benchmark": "brake-reuss-beam" } });
        scene["analyses"] = json!({ "backbone": {}, "sensitivities": parameters });
        read(&scene)
    };
    let two = asking(json!(["interfaces.mu", "bolts.load"])).unwrap();
    assert_eq!(two.analyses.sensitivities.len(), 2);
    let twice = asking(json!(["interfaces.mu", "interfaces.mu"])).unwrap_err();
    assert!(twice.to_string().contains("names it twice") && twice.field() == Some("interfaces.mu"));
    assert!(asking(json!(["friction"])).is_err());
}

/// Keys of stored results and summaries are texts: paths that are none would all be the same in them.
#[cfg(unix)]
#[test]
fn paths_that_are_no_text_are_refused_before_anything_is_computed() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let given = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": "quick" },
        "interfaces": { "surface": { "scans": ["top.csv", "bottom.csv"] }, "gap": "scan" },
    });
    let mut scene = Scene::from_json(&given.to_string(), "x", "x", &BENCHMARKS).unwrap();
    scene.validate("x").unwrap();
    scene.resolve(Path::new(OsStr::from_bytes(b"/tmp/caf\xe9")));
    let options = joints::Options::cached(std::env::temp_dir());
    let messages = [
        scene.validate("x").unwrap_err().to_string(),
        analyses::run(&scene, &options, &joints::progress::Silent)
            .unwrap_err()
            .to_string(),
        analyses::cases::CaseHasher::new(None)
            .keys(&scene)
            .unwrap_err()
            .to_string(),
    ];
    for message in messages {
        assert!(
            message.contains("top.csv") && message.contains("no Unicode text"),
            "{message}"
        );
    }
}

/// Matrices with a law of given numbers have no material; what is made of one asks for it.
#[test]
fn a_material_is_asked_for_where_something_is_made_of_it() {
    let set = |curves: Value| json!({ "parameters": { "per": "interface", "sets": [{ "curves": curves }] } });
    let elastic = set(json!({ "elastic": { "normal_stiffness": 1e13, "tangential_stiffness": [7e12, 7e12] } }));
    let rough = set(json!({ "greenwood-williamson": {
        "heights": { "gaussian": 1e-6 }, "reference_height": 3e-6, "asperity_density": 1e9, "radii": [1e-4, 1e-4],
    } }));
    let structure = json!({ "matrices": {
        "path": "x.npz", "coordinates": "jump", "interface": { "nodes": [[0, 0], [1, 0], [1, 1], [0, 1]], "elements": [[1, 2, 3, 4]] },
        "response": { "terms": [[1, 1, 1.0]] },
    } });
    let beam = json!({ "mesh": {
        "path": "x.msh", "interfaces": [{}], "bolts": [{ "head": "a", "nut": "b" }],
        "response": { "nearest": [0, 0, 0], "direction": [0, 0, 1] },
    } });
    let read = |structure: &Value, surface: &Value| {
        let given = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": structure, "interfaces": { "surface": surface, "mu": 0.2 }, "bolts": { "load": 1e3 },
        });
        Scene::from_json(&given.to_string(), "x", "x", &BENCHMARKS)
    };
    let free = read(&structure, &elastic).unwrap();
    assert!(free.model.material.is_none() && !free.needs_material());
    let written = serde_json::to_value(&free).unwrap();
    assert_eq!(Scene::from_summary(&written, &BENCHMARKS).unwrap(), free);
    for (structure, surface) in [
        (&structure, &rough),
        (&structure, &json!({ "benchmark": "brake-reuss-beam" })),
        (&beam, &elastic),
    ] {
        let error = read(structure, surface).unwrap_err();
        assert_eq!(error.field(), Some("model.material.youngs_modulus"), "{error}");
    }
}
