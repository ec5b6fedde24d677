//! Every number of a scene, varied by every route, changes results or is refused: none is taken and then ignored.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]

use crate::common::BENCHMARKS;
use crate::common::points::{folder, scene as of_points, set, write};
use analyses::calibration::{Measured, Noise, calibrate};
use analyses::cases::{CaseMode, CaseStructure, as_case, idle};
use analyses::comparison::{Backbone, Point};
use analyses::uncertainty::run_samples;
use analyses::{Error, Sensitivity, prepare, run};
use faer::Mat;
use joints::Options;
use joints::progress::Silent;
use scenes::{Parameter, Scene, parse_json};
use serde_json::{Value, json};

/// Change of a number by which results must differ.
const STEP: f64 = 0.02;

/// What became of a number on a route.
#[derive(Clone, Debug, PartialEq)]
enum Outcome {
    Acts,
    Refused(String),
    /// It was taken, and changed nothing.
    Silent,
}

impl Outcome {
    fn of(found: Result<bool, Error>) -> Self {
        match found {
            Ok(true) => Self::Acts,
            Ok(false) => Self::Silent,
            Err(error) => Self::Refused(error.to_string()),
        }
    }
}

const ROUTES: [&str; 4] = ["sensitivities", "samples", "calibration", "study"];

fn read(given: &Value) -> Result<Scene, scenes::Error> {
    Scene::from_value(given.clone(), "the test's scene", "effects", &BENCHMARKS)
}

/// Paths of all numbers that the physics may depend on.
fn numbers(scene: &Scene) -> Vec<Parameter> {
    fn walk(value: &Value, path: &str, all: &mut Vec<String>) {
        let within = |name: &str| match path {
            "" => name.to_owned(),
            _ => format!("{path}.{name}"),
        };
        match value {
            Value::Object(fields) => fields.iter().for_each(|(name, value)| walk(value, &within(name), all)),
            Value::Array(list) => (0..)
                .zip(list)
                .for_each(|(k, value): (usize, _)| walk(value, &within(&k.to_string()), all)),
            Value::Number(_) => all.push(path.to_owned()),
            _ => {}
        }
    }
    let mut all = Vec::new();
    walk(&serde_json::to_value(scene).unwrap(), "", &mut all);
    let parameters = all.into_iter().map(Parameter::new);
    parameters.filter(|parameter| parameter.value(scene).is_ok()).collect()
}

/// The value beside that of the scene, admissible if one of them is.
fn beside(scene: &Scene, parameter: &Parameter) -> Option<f64> {
    let value = parameter.value(scene).unwrap();
    let tried = match value == 0.0 {
        true => vec![1e-5, 1e-3],
        false => vec![value * (1.0 + STEP), value * (1.0 - STEP)],
    };
    tried.into_iter().find(|value| parameter.with(scene, *value).is_ok())
}

fn of_sensitivities(given: &Value, parameter: &Parameter) -> Result<bool, Error> {
    let mut asking = given.clone();
    asking["analyses"]["sensitivities"] = json!([parameter]);
    let scene = read(&asking)?;
    let found = prepare(&scene, &Options::default(), &Silent)?.solve(&Silent)?;
    let acts = |one: &Sensitivity| {
        let along = one.dln_frequency.iter().chain(&one.dln_damping).flatten();
        one.dln_linear_frequency != 0.0 || one.dln_mode_shape != 0.0 || along.into_iter().any(|rate| *rate != 0.0)
    };
    Ok(found.first().sensitivities.iter().any(acts))
}

fn of_samples(given: &Value, parameter: &Parameter, other: f64) -> Result<bool, Error> {
    let value = parameter.value(&read(given)?)?;
    let mut asking = given.clone();
    let unit = parameter.unit(&read(given)?)?;
    let quantity = |value: f64| match unit {
        "" => json!(value),
        unit => json!(format!("{value} {unit}")),
    };
    let ends = [value.min(other), value.max(other)].map(quantity);
    asking["uncertain"] = json!({ "parameters": { parameter.path(): { "uniform": ends } }, "law_error": 1 });
    let (_, found) = run_samples(&read(&asking)?, 2, None, &Options::default(), &Silent)?;
    let [a, b] = found.variants.as_slice() else {
        panic!("two samples")
    };
    Ok(a.failure.is_some() || b.failure.is_some() || a.curves != b.curves)
}

fn of_calibration(given: &Value, parameter: &Parameter) -> Result<bool, Error> {
    let scene = read(given)?;
    let found = run(&scene, &Options::default(), &Silent)?;
    // The scene as it is, a little softer and with more damping.
    let points = found.amplitudes().iter().map(|amplitude| {
        let (result, fields) = (
            amplitude.point.result.as_ref().unwrap(),
            amplitude.fields.as_ref().unwrap(),
        );
        Point {
            amplitude: fields.response_motion,
            frequency_hz: 0.999 * result.harmonic_omega / std::f64::consts::TAU,
            damping_ratio: result.is_resolved().then_some(1.05 * result.harmonic_zeta()),
        }
    });
    let measured = Measured {
        name: "softer".into(),
        mode: 1,
        backbone: Backbone::try_new("softer", points.collect())?,
    };
    let noise = Noise {
        frequency_ln: 1e-3,
        damping_ln: 0.05,
    };
    let free = [(parameter.clone(), None)];
    let found = calibrate(&scene, &free, &[measured], noise, &Options::default(), &Silent)?;
    // Without any information nothing but the weak prior holds it.
    Ok(found
        .unidentifiable
        .iter()
        .all(|direction| direction.singular_value > 0.0))
}

fn backbones(case: &Scene) -> Result<Vec<CaseMode>, Error> {
    let structure = CaseStructure::try_new(case, &Options::default(), &Silent)?;
    let interface = structure.interface(case, None)?;
    structure.backbones(case, &interface, &Silent)
}

fn of_study(given: &Value, parameter: &Parameter, other: f64) -> Result<bool, Error> {
    let mut varied = given.clone();
    let unit = parameter.unit(&read(given)?)?;
    let (mut place, mut before) = (&mut varied, String::new());
    for field in parameter.path().split('.') {
        if field.parse::<usize>().is_ok() && !place.is_array() {
            // A list that the file leaves out: as it is understood.
            *place = serde_json::to_value(read(given)?)
                .unwrap()
                .pointer(&before)
                .cloned()
                .unwrap();
        }
        before += &format!("/{field}");
        place = match field.parse::<usize>() {
            Ok(index) => &mut place[index],
            _ => &mut place[field],
        };
    }
    *place = match unit {
        "" => json!(other),
        unit => json!(format!("{other} {unit}")),
    };
    let [own, varied] = [given, &varied].map(read);
    let (own, varied) = (as_case(&own?), as_case(&varied?));
    if let Some((_, error)) = idle(&own, [parameter.clone()]).pop() {
        return Err(error);
    }
    Ok(backbones(&own)? != backbones(&varied)?)
}

/// Varies all numbers of a scene by all routes, prints a row of the table for each, and gives those that were taken and ignored.
fn vary(name: &str, given: &Value, which: &dyn Fn(&str) -> bool) -> (usize, Vec<String>) {
    let scene = read(given).unwrap();
    let (mut rows, mut silent) = (0, Vec::new());
    for parameter in numbers(&scene).iter().filter(|parameter| which(parameter.path())) {
        let Some(other) = beside(&scene, parameter) else {
            println!("{name:24} {:44} has no other admissible value", parameter.path());
            continue;
        };
        let outcomes = [
            Outcome::of(of_sensitivities(given, parameter)),
            Outcome::of(of_samples(given, parameter, other)),
            Outcome::of(of_calibration(given, parameter)),
            Outcome::of(of_study(given, parameter, other)),
        ];
        let words = outcomes.each_ref().map(|outcome| match outcome {
            Outcome::Acts => "acts",
            Outcome::Refused(_) => "refused",
            Outcome::Silent => "SILENT",
        });
        println!(
            "{name:24} {:44} {:8} {:8} {:8} {:8}",
            parameter.path(),
            words[0],
            words[1],
            words[2],
            words[3]
        );
        if let Some(Outcome::Refused(reason)) = outcomes.iter().find(|outcome| matches!(outcome, Outcome::Refused(_))) {
            println!("{:24}   {reason}", "");
        }
        rows += 1;
        let ignored = ROUTES
            .iter()
            .zip(&outcomes)
            .filter(|(_, outcome)| **outcome == Outcome::Silent);
        silent.extend(ignored.map(|(route, _)| format!("{name}: {} by {route}", parameter.path())));
    }
    (rows, silent)
}

/// The coarse beam whose bolts are tightened by torque.
fn by_torque(bolts: &Value) -> Value {
    let mut given = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": { "gap": "flat", "mu": 0.2, "law": { "friction": "lumped" } },
        "bolts": {
            "thread": { "diameter": 7.9375e-3, "pitch": 1.4111e-3 },
            "thread_friction": 0.15, "head_friction": 0.12, "bearing_diameters": [8.7e-3, 12.7e-3],
        },
        "analyses": { "backbone": {
            "amplitudes": 2, "amplitude_from": 1e-4, "amplitude_to": 4e-4, "vertices_per_quarter": 2,
        } },
    });
    given["bolts"]
        .as_object_mut()
        .unwrap()
        .extend(bolts.as_object().unwrap().clone());
    given
}

#[test]
#[ignore = "half a minute; `.ci/run slow` runs it"]
fn slow_what_a_bolt_load_follows_from_acts_by_every_route() {
    let given = by_torque(&json!({ "torque": 20.0 }));
    let tried = ["bolts.torque", "bolts.thread.pitch", "bolts.load"];
    let (rows, silent) = vary("torque", &given, &|path| tried.contains(&path));
    assert!(silent.is_empty() && rows == tried.len(), "{rows}: {silent:?}");
    // What a thread says of a load that is given is a remark, and no result depends on it.
    let by_load = by_torque(&json!({ "load": 12e3 }));
    let scene = read(&by_load).unwrap();
    let pitch = Parameter::new("bolts.thread.pitch");
    let (_, error) = idle(&scene, [pitch]).pop().unwrap();
    assert!(error.to_string().contains("no result depends on it"), "{error}");
    // A load and what it follows from cannot vary at the same time.
    let mut both = given;
    both["uncertain"] = json!({ "parameters": {
        "bolts.torque": { "uniform": ["18 N m", "22 N m"] }, "bolts.load": { "tightening": "torque-wrench" },
    } });
    let error = read(&both).unwrap_err().to_string();
    assert!(error.contains("bolts.load follows from bolts.torque"), "{error}");
}

/// The logarithm of a load is that of the torque and a constant, and thus their derivatives are the same; those by friction and sizes are
/// products with the derivative of the lever.
#[test]
fn derivatives_go_through_what_follows_from_a_number() {
    let paths = [
        "bolts.torque",
        "bolts.head_friction",
        "bolts.thread_friction",
        "bolts.thread.pitch",
        "bolts.thread.diameter",
        "bolts.bearing_diameters.0",
        "bolts.bearing_diameters.1",
        "bolts.load",
    ];
    let mut given = by_torque(&json!({ "torque": 20.0 }));
    given["analyses"]["sensitivities"] = json!(paths);
    let scene = read(&given).unwrap();
    let mut bare = scene.clone();
    bare.analyses.sensitivities.clear();
    let found = run(&scene, &Options::default(), &Silent).unwrap();
    let sensitivities = &found.first().sensitivities;
    let of_load = sensitivities.last().unwrap();
    for one in sensitivities {
        let parameter = &one.parameter;
        let ln_load = |step: f64| parameter.with(&bare, one.value * step.exp()).unwrap().tension(0).ln();
        let step = 1e-4;
        let chain = (ln_load(step) - ln_load(-step)) / (2.0 * step);
        assert!(chain.abs() > 0.01, "{parameter}: {chain}");
        let pairs = [
            (&one.dln_frequency, &of_load.dln_frequency),
            (&one.dln_damping, &of_load.dln_damping),
            (&one.dln_response, &of_load.dln_response),
        ];
        for (own, of_load) in pairs {
            for (own, of_load) in own.iter().zip(of_load) {
                let (own, expected) = (own.unwrap(), chain * of_load.unwrap());
                let error = (own - expected).abs() / expected.abs();
                println!("{parameter} {own:+.9e} {expected:+.9e} {error:.1e}");
                assert!(error < 1e-5, "{parameter}: {own} {expected}");
            }
        }
    }
}

/// Masses and points of contact whose sets have friction of their own, and bodies from matrices.
#[test]
fn numbers_of_given_laws_act_or_are_refused() {
    let path = folder("effects").join("slider.npz");
    let of = |value: f64| Mat::from_fn(1, 1, |_, _| value);
    write(&path, &of(4e4), &of(2.0), &[(7, 1)]);
    let mut slider = of_points(&path, &[7], &[set([5e4, 5e4, 2e6], 0.2, 50.0)], &json!([[7, 1, 1.0]]));
    slider["interfaces"]["mu"] = json!(0.3);
    slider["model"]["material"]["hardness"] = json!(2e9);
    slider["model"]["material"]["work_of_adhesion"] = json!(0.1);
    slider["analyses"] = json!({
        "modes": { "number": 1 },
        "backbone": { "amplitudes": 3, "vertices_per_quarter": 8, "amplitude_from": 1e-4, "amplitude_to": 2e-3 },
    });
    let (rows, silent) = vary("slider", &slider, &|_| true);
    assert!(silent.is_empty() && rows >= 6, "{rows}: {silent:?}");
    for path in [
        "interfaces.mu",
        "model.material.hardness",
        "model.material.work_of_adhesion",
    ] {
        let error = of_samples(&slider, &Parameter::new(path), 0.31)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(path) && error.contains("no result depends on it"),
            "{error}"
        );
    }
    std::fs::remove_file(&path).unwrap();
}

/// Every number of every scene that comes with the beam, on its coarsest mesh.
#[test]
#[ignore = "takes minutes"]
fn every_number_of_every_scene_acts_or_is_refused() {
    let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/../brake-reuss-beam/scenes");
    let (mut total, mut all) = vary("torque", &by_torque(&json!({ "torque": 20.0 })), &|_| true);
    let each = by_torque(&json!({ "torques": [20.0, 22.0, 18.0] }));
    let (rows, silent) = vary("torques", &each, &|path| path.starts_with("bolts."));
    total += rows;
    all.extend(silent);
    for entry in std::fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let mut given = parse_json(&std::fs::read_to_string(&path).unwrap()).unwrap();
        if given["structure"].get("deck").is_some() {
            continue;
        }
        given["model"]["refinement"] = json!("quick");
        given["uncertain"] = Value::Null;
        given["analyses"]["backbone"] = json!({
            "amplitudes": 2, "amplitude_from": "30 um", "amplitude_to": "0.3 mm", "vertices_per_quarter": 3,
        });
        let (rows, silent) = vary(&name, &given, &|_| true);
        total += rows;
        all.extend(silent);
    }
    println!("{total} numbers");
    assert!(all.is_empty() && total > 50, "{total}: {all:#?}");
}
