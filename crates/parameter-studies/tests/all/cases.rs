//! Cases of studies: what they share changes no bit, and what they are addressed by is all that they depend on.
#![expect(clippy::unwrap_used, reason = "tests")]

use analyses::cases::{CaseHasher, CaseKeys, CaseMode, CaseStructure, as_case};
use analyses::run;
use brake_reuss_beam::BrakeReussBenchmark;
use joint_model::Benchmark;
use joints::Options;
use joints::progress::Silent;
use scenes::Scene;
use serde_json::{Value, json};
use std::f64::consts::TAU;

static BENCHMARKS: [&dyn Benchmark; 1] = [&BrakeReussBenchmark];

/// The coarse beam with few amplitudes, with changes at these pointers (without the first `/`).
fn scene(change: &[(&str, Value)]) -> Scene {
    let mut scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": { "mu": 0.2, "gap": "flat", "law": { "friction": "lumped" }, "points_per_direction": 2 },
        "analyses": {
            "backbone": { "amplitudes": 2, "amplitude_from": 1e-4, "amplitude_to": 4e-4, "vertices_per_quarter": 2 },
        },
    });
    for (pointer, value) in change {
        *pointer.split('/').fold(&mut scene, |place, name| &mut place[name]) = value.clone();
    }
    Scene::from_value(scene, "test", "test", &BENCHMARKS).unwrap()
}

fn case(change: &[(&str, Value)]) -> Scene {
    as_case(&scene(change))
}

fn keys(case: &Scene) -> CaseKeys {
    CaseHasher::new(None).keys(case).unwrap()
}

fn backbones(structure: &CaseStructure, case: &Scene, known: Option<&Scene>) -> Vec<CaseMode> {
    let known = known.map(|known| structure.interface(known, None).unwrap());
    let interface = structure.interface(case, known.as_ref()).unwrap();
    structure.backbones(case, &interface, &Silent).unwrap()
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_shared_surfaces_and_structures_change_no_bit() {
    let structure = CaseStructure::try_new(&case(&[]), &Options::default(), &Silent).unwrap();
    let face = json!({ "ra": "0.8 um", "rsm": "400 um" });
    let finish = json!({ "finish": { "top": face, "bottom": face, "route": "fast" } });
    let scan = json!({ "synthetic-scan": { "step": [1e-4, 1e-4], "bootstrap": 2 } });
    for (surface, gap) in [(json!("measured"), "measured"), (finish, "flat"), (scan, "scan")] {
        let own = [("interfaces/surface", surface.clone()), ("interfaces/gap", json!(gap))];
        let with = |scale: Value, mu: f64| {
            let other = [("interfaces/scale", scale), ("interfaces/mu", json!(mu))];
            case(&[&own[..], &other].concat())
        };
        let other = with(
            json!({ "asperity_radius": 1.3, "asperity_height": 0.9, "gap": 0.5 }),
            0.4,
        );
        let varied = with(json!({ "gap": 0.7, "asperity_density": 1.1 }), 0.3);
        assert_eq!(keys(&other).surface, keys(&varied).surface);
        assert_eq!(keys(&other).structure, keys(&varied).structure);
        let fresh = backbones(&structure, &varied, None);
        assert_eq!(fresh, backbones(&structure, &varied, Some(&other)), "{surface}");
        assert!(fresh[0].amplitudes.iter().all(Result::is_ok), "{surface}: {fresh:?}");
    }
    // It is what a run of the scene gives.
    let change = [("interfaces/gap", json!("measured")), ("interfaces/mu", json!(0.3))];
    let found = backbones(&structure, &case(&change), None);
    let run = run(&scene(&change), &Options::default(), &Silent).unwrap();
    for (point, amplitude) in found[0].amplitudes.iter().zip(run.amplitudes()) {
        let (point, result) = (point.as_ref().unwrap().point, amplitude.point.result.as_ref().unwrap());
        assert_eq!(point.frequency_hz, result.omega / TAU);
        assert_eq!(point.damping_ratio, result.is_resolved().then_some(result.zeta));
        assert_eq!(Some(point.response_displacement), amplitude.response_displacement);
    }
}

#[test]
fn addresses_follow_what_a_case_depends_on_and_nothing_else() {
    let plain = keys(&case(&[]));
    assert_eq!(plain.case.len(), 64);
    let same = [
        ("name", json!("another")),
        ("output", json!({ "fields_at": [1] })),
        ("analyses/backbone/methods", json!(["masing"])),
        ("analyses/epmc", json!({})),
        ("analyses/sensitivities", json!(["interfaces.mu"])),
        // What is so by default.
        ("interfaces/scale", json!({ "gap": 1.0 })),
        ("bolts", json!({ "load": "12.845 kN" })),
    ];
    for change in same {
        assert_eq!(keys(&case(std::slice::from_ref(&change))), plain, "{change:?}");
    }
    let of_case = [
        ("interfaces/mu", json!(0.21)),
        ("bolts", json!({ "load": "9 kN" })),
        ("interfaces/points_per_direction", json!(3)),
        ("background_damping", json!(1e-3)),
    ];
    for change in of_case {
        let other = keys(&case(std::slice::from_ref(&change)));
        assert_ne!(other.case, plain.case, "{change:?}");
        assert_eq!(
            (other.structure, other.surface),
            (plain.structure.clone(), plain.surface.clone()),
            "{change:?}"
        );
    }
    let material = |material: Value| {
        (
            "model",
            json!({ "element_order": "linear", "refinement": "quick", "material": material }),
        )
    };
    let stiffer = keys(&case(&[material(json!({ "youngs_modulus": "200 GPa" }))]));
    assert!(stiffer.case != plain.case && stiffer.structure != plain.structure);
    let hard = keys(&case(&[material(json!({ "hardness": "2 GPa" }))]));
    assert_eq!(hard.structure, plain.structure);
    let locked = keys(&case(&[("bolts", json!({ "behaviour": "locked" }))]));
    assert_ne!(locked.structure, plain.structure);
    // What another build has stored is not taken.
    let build = CaseHasher::new(Some("other".into())).keys(&case(&[])).unwrap();
    assert!(build.case != plain.case && build.structure != plain.structure);
}
