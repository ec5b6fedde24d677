//! Moving supports and random loads: against closed forms, against forces, and against one another.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::BENCHMARKS;
use crate::common::points::{folder, scene, set, try_run, write};
use crate::meshes::{document, lap, named, scene as of_lap};
use analyses::results::summary::Summary;
use analyses::{Run, run};
use faer::Mat;
use joints::Options;
use joints::progress::{Progress, Silent, Stage};
use scenes::Scene;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Mutex;

pub(crate) fn summary(run: &Run) -> Summary {
    Summary::new(run, Default::default(), None)
}

/// Two masses on springs, the first of which rests on the ground with dry friction; `analyses` of the first mode.
pub(crate) fn oscillator(path: &Path, mu: f64, analyses: Value) -> Value {
    let (ground, spring, masses) = (4e4, 6e4, [1.0, 2.0]);
    let stiffness = Mat::from_fn(2, 2, |i, j| match (i, j) {
        (0, 0) => ground + spring,
        (1, 1) => spring,
        _ => -spring,
    });
    let mass = Mat::from_fn(2, 2, |i, j| if i == j { masses[i] } else { 0.0 });
    write(path, &stiffness, &mass, &[(7, 1), (-1, 1)]);
    let mut scene = scene(path, &[7], &[set([5e4, 5e4, 2e6], mu, 50.0)], &json!([[-1, 1, 1.0]]));
    scene["background_damping"] = json!(0.01);
    scene["analyses"] = analyses;
    scene["analyses"]["modes"]["number"] = json!(2);
    scene
}

#[test]
fn a_mass_on_one_contact_moves_on_its_base_as_the_closed_form_says() {
    let folder = folder("base");
    let path = folder.join("mass.npz");
    let (ground, contact, zeta, level) = (1e4, 5e4, 0.01, 0.3);
    let one = |value: f64| Mat::from_fn(1, 1, |_, _| value);
    write(&path, &one(ground), &one(2.0), &[(7, 1)]);
    let sticks = set([contact, contact, 2e6], 10.0, 50.0);
    let mut given = scene(&path, &[7], &[sticks], &json!([[7, 1, 1.0]]));
    given["background_damping"] = json!(zeta);
    let omega = ((ground + contact) / 2.0_f64).sqrt();
    let first = omega / TAU;
    let base = json!({ "motion": [[7, 1, 1.0]], "levels": [level] });
    given["analyses"] = json!({
        "modes": { "number": 1 },
        "forced": { "base": base, "from_hz": 0.5 * first, "to_hz": 1.5 * first, "tolerance": 1e-12, "stability": true },
    });
    let found = summary(&try_run(&given).unwrap()).forced.remove(0);
    // Multipliers of a linear oscillator: exp((-zeta w +- i w sqrt(1 - zeta^2)) T).
    let floquet = found.floquet.as_ref().unwrap();
    assert!(floquet.stable.iter().all(|stable| *stable == Some(true)) && floquet.bifurcations.is_empty());
    for (f, multipliers) in found.frequency.iter().zip(&floquet.multipliers) {
        let (growth, turn) = (zeta * omega / f, omega * (1.0 - zeta * zeta).sqrt() / f);
        let [[re, im]] = multipliers.as_slice() else {
            panic!("{multipliers:?}");
        };
        let error = (re - (-growth).exp() * turn.cos()).hypot(im.abs() - (-growth).exp() * turn.sin().abs());
        assert!(error < 1e-8, "{f} Hz: {error:e}");
    }
    assert_eq!((found.failure.as_deref(), found.level_unit.as_str()), (None, "m/s^2"));
    let outside = found.base.unwrap();
    assert!(found.frequency.len() > 20);
    let mut largest = [0.0_f64; 5];
    for (i, f) in found.frequency.iter().enumerate() {
        let w = TAU * f;
        // The coordinate per acceleration of the base, and the whole over the displacement of the base.
        let (x, y) = (omega * omega - w * w, 2.0 * zeta * omega * w);
        let square = x * x + y * y;
        let (real, imaginary) = (1.0 + w * w * x / square, -w * w * y / square);
        let lag = |re: f64, im: f64| (-im).atan2(re).to_degrees().rem_euclid(360.0);
        let apart = |a: f64, b: f64| ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs();
        let errors = [
            (found.amplitude[i] / (level / square.sqrt()) - 1.0).abs(),
            (outside.transmissibility[i] / real.hypot(imaginary) - 1.0).abs(),
            apart(outside.phase[i], lag(real, imaginary)),
            found.energy_error[i],
            // Against the supports: behind the force of inertia.
            apart(found.phase[i], lag(x, -y)),
        ];
        largest = [0, 1, 2, 3, 4].map(|k| largest[k].max(errors[k]));
    }
    println!("amplitude, transmissibility, phase, energy: {largest:?}");
    assert!(
        largest.iter().all(|error| *error < 1e-8) && largest[3] < 1e-9,
        "{largest:?}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_moving_base_is_an_inertial_force() {
    let folder = folder("inertial");
    let path = folder.join("oscillator.npz");
    let level = 6.0;
    let response = |excitation: Value| {
        let mut forced = json!({ "from_hz": 15.0, "to_hz": 30.0, "harmonics": 5, "samples": 256, "tolerance": 1e-11 });
        let fields = forced.as_object_mut().unwrap();
        fields.extend(excitation.as_object().unwrap().clone());
        let found = try_run(&oscillator(&path, 0.2, json!({ "forced": forced }))).unwrap();
        summary(&found).forced.remove(0)
    };
    let motion = json!([[7, 1, 1.0], [-1, 1, 1.0]]);
    let base = response(json!({ "base": { "motion": motion, "levels": [level] } }));
    let force = response(json!({ "terms": [[7, 1, -1.0], [-1, 1, -2.0]], "levels": [level] }));
    assert_eq!((base.failure.as_deref(), force.failure.as_deref()), (None, None));
    assert_eq!(base.frequency.len(), force.frequency.len());
    // It slips: the resonance is below that of the stuck structure, and there are further harmonics.
    assert!(base.harmonics.iter().any(|h| h[2] > 1e-3 * h[0]));
    let pairs = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    let errors = [
        pairs(&base.frequency, &force.frequency),
        pairs(&base.amplitude, &force.amplitude),
    ];
    assert!(errors.iter().all(|error| *error < 1e-9), "{errors:?}");
    assert!(base.energy_error.iter().all(|error| *error < 1e-9));
    assert!(force.base.is_none() && base.base.is_some());
    std::fs::remove_dir_all(folder).unwrap();
}

/// The clamped lap with these analyses beside the backbone.
fn clamped(path: &Path, analyses: &Value) -> Scene {
    lap([12, 4, 2], [12, 4, 2]).write(path);
    of_lap(path, named(), |scene| {
        scene["structure"]["mesh"]["supports"] = json!([{ "surface": "foot" }]);
        scene["background_damping"] = json!(0.002);
        let asked = scene["analyses"].as_object_mut().unwrap();
        asked["backbone"]["amplitudes"] = json!(9);
        asked.extend(analyses.as_object().unwrap().clone());
    })
}

/// Hears what is done of forced responses.
struct Parts(Mutex<Vec<f64>>);

impl Progress for Parts {
    fn fraction(&self, stage: Stage, done: f64) {
        if stage == Stage::Forced {
            self.0.lock().unwrap().push(done);
        }
    }
}

#[test]
fn a_clamped_structure_follows_its_base_at_low_frequencies_and_swings_as_a_random_load_says() {
    let folder = folder("clamped");
    let (level, scale) = (1e-3, 1e-12);
    let up = json!([0.0, 0.0, 1.0]);
    let scene = |[from, to]: [f64; 2]| {
        clamped(
            &folder.join("lap.msh"),
            &json!({
                "forced": { "base": { "direction": up, "levels": [level] }, "from_hz": from, "to_hz": to, "tolerance": 1e-10 },
                // Nothing; so little that nothing slips; as much as lets the joint slip; more than any backbone reaches.
                "random": { "base": { "direction": up }, "psd": [[from, scale], [to, scale]], "levels": [0.0, 1.0, 3e5, 1e9] },
            }),
        )
    };
    let options = Options::default();
    let found = run(&scene([20.0, 25.0]), &options, &Silent).unwrap();
    let first = found.frequencies[0];
    let low = summary(&found).forced.remove(0);
    let outside = low.base.unwrap();
    // The first point: one plus the square of the ratio of frequencies, nearly.
    let ratio = 20.0 / first;
    assert!(ratio < 0.2, "{first}");
    assert!(outside.transmissibility[0] > 1.0 && outside.transmissibility[0] < 1.0 + 2.0 * ratio * ratio);
    let mass = found.model.facts.mass.unwrap();
    let force = outside.support_force[0].unwrap() / (mass * level);
    assert!(force > 1.0 && force < 1.0 + 2.0 * ratio * ratio, "{force}");

    let band = [0.3 * first, 3.0 * first];
    let parts = Parts(Mutex::default());
    let found = run(&scene(band), &options, &parts).unwrap();
    // What is done is told nearly by points, although most of them lie about the resonance.
    let parts = parts.0.into_inner().unwrap();
    let number = (parts.len() - 1) as f64;
    let off = |(i, part): (usize, &f64)| (part - i as f64 / number).abs();
    let furthest = parts.iter().enumerate().map(off).fold(0.0, f64::max);
    println!("{} points are told to within {furthest:.2}", parts.len());
    assert!(parts.len() > 20 && furthest < 0.2, "{parts:?}");
    let document = summary(&found);
    let forced = &document.forced[0];
    assert!(
        forced.energy_error.iter().all(|error| *error < 1e-9),
        "{:?}",
        forced.energy_error
    );
    let [rest, small, large, beyond] = document.random.as_slice() else {
        panic!("four levels");
    };
    assert_eq!((rest.rms_load, rest.rms_response), (0.0, 0.0));
    assert!((small.rms_load / (scale * (band[1] - band[0])).sqrt() - 1.0).abs() < 1e-12);
    // At the ends of the band the response to a harmonic motion is what the density is made of: two ways to the same number, the one by harmonic
    // balance of the whole structure, the other by its modes and what they leave out.
    let last = forced.frequency.len() - 1;
    let ends = [(0, 0), (last, small.psd.frequency_hz.len() - 1)];
    for (of_forced, of_psd) in ends {
        assert!((forced.frequency[of_forced] / small.psd.frequency_hz[of_psd] - 1.0).abs() < 1e-12);
        let gain = (forced.amplitude[of_forced] / level).powi(2);
        let error = small.psd.displacement[of_psd] / scale / gain - 1.0;
        println!("{} Hz: {error:+.1e}", forced.frequency[of_forced]);
        assert!(error.abs() < 2e-3, "{error}");
    }
    let mode = |level: &analyses::random::RandomSummary| level.modes[0].clone();
    assert!((mode(small).frequency_hz / first - 1.0).abs() < 1e-3);
    assert!(
        mode(large).frequency_hz < mode(small).frequency_hz && mode(large).damping_ratio > mode(small).damping_ratio
    );
    assert!(large.rms_response > small.rms_response && large.rms_response < 3e5 * small.rms_response);
    assert!(large.validity.holds && !beyond.validity.holds, "{:?}", large.validity);
    assert!(
        beyond
            .validity
            .reasons
            .iter()
            .any(|reason| reason.contains("above the backbone"))
    );
    // What friction takes is what the mode takes beyond its background.
    let background = 0.002 * mode(large).power / mode(large).damping_ratio;
    let share = large.dissipated_power / (mode(large).power - background);
    println!("{share:.4} {:e} {:?}", large.rms_response, large.validity);
    assert!((share - 1.0).abs() < 0.05, "{share}");
    // All of it is in the connections, which move less than their farthest points.
    let [connection] = large.connections.as_slice() else {
        panic!("{:?}", large.connections)
    };
    assert!((connection.dissipated_power / large.dissipated_power - 1.0).abs() < 1e-9);
    assert!(connection.rms_displacement > 0.0 && connection.rms_displacement <= large.rms_sliding);
    // So is it in the elements, which move less than the farthest of their points.
    let Some(Ok(levels)) = &found.vibration.random else {
        panic!("{:?}", found.vibration.random)
    };
    let operators = found.interface.operators();
    let of_elements = &levels[2].elements;
    let of_element = |(element, power): (usize, &f64)| power * operators.element_area(element);
    let all: f64 = of_elements.power.iter().enumerate().map(of_element).sum();
    assert!(
        (all / large.dissipated_power - 1.0).abs() < 1e-9,
        "{all:e} {:e}",
        large.dissipated_power
    );
    let farthest = of_elements.sliding.iter().copied().fold(0.0, f64::max);
    assert!(farthest > 0.1 * large.rms_sliding && farthest <= large.rms_sliding);
    // What is open takes no power and has no traction.
    let mut both = of_elements.power.iter().zip(&of_elements.traction);
    assert!(both.all(|(power, traction)| *traction > 0.0 || *power == 0.0));
    assert!(of_elements.traction.iter().any(|rms| *rms > 0.0));
    assert!(
        levels[0]
            .elements
            .power
            .iter()
            .chain(&levels[0].elements.sliding)
            .all(|value| *value == 0.0)
    );
    // Where nothing slips, force and motion are those of a small loop.
    let small = &document.random[1].connections[0];
    let loops = &document.backbone[0].connections[0];
    let stiffness = (small.rms_force / small.rms_displacement) / (loops.force / loops.displacement);
    assert!((stiffness - 1.0).abs() < 1e-3, "{stiffness}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn bases_and_spectra_that_cannot_be_are_refused_with_their_field() {
    let folder = folder("refused");
    let path = folder.join("lap.msh");
    let base = json!({ "direction": [0.0, 0.0, 1.0] });
    let refusal = |analyses: Value| {
        lap([6, 2, 1], [6, 2, 1]).write(&path);
        let text = document(&path, named(), |scene| {
            scene["structure"]["mesh"]["supports"] = json!([{ "surface": "foot" }]);
            scene["analyses"]
                .as_object_mut()
                .unwrap()
                .extend(analyses.as_object().unwrap().clone());
        });
        Scene::from_json(&text.to_string(), "lap.json", "lap", &BENCHMARKS)
            .unwrap_err()
            .to_string()
    };
    let random = |psd: Value| json!({ "random": { "base": base, "psd": psd } });
    for (analyses, told) in [
        (random(json!([[20.0, 1.0]])), "at least two points"),
        (random(json!([[20.0, 1.0], [30.0, -1.0]])), "positive and finite"),
        (random(json!([[30.0, 1.0], [20.0, 1.0]])), "ascending"),
        (random(json!([[30.0, "1 N^2/Hz"], [40.0, 1.0]])), "g^2/Hz"),
        (
            json!({ "random": { "psd": [[1.0, 1.0], [2.0, 1.0]] } }),
            "exactly one of `base` and `force`",
        ),
        (
            json!({ "forced": { "base": { "direction": [0.0, 0.0, 2.0], "levels": ["1 g"] }, "from_hz": 1.0, "to_hz": 2.0 } }),
            "unit vector",
        ),
        (
            json!({ "forced": { "base": { "direction": [0.0, 0.0, 1.0], "levels": ["0 g"] }, "from_hz": 1.0, "to_hz": 2.0 } }),
            "positive",
        ),
        (
            json!({ "forced": { "base": { "direction": [0.0, 0.0, 1.0], "levels": [] }, "from_hz": 1.0, "to_hz": 2.0 } }),
            "at least one",
        ),
        (
            json!({ "forced": {
                "base": { "direction": [0.0, 0.0, 1.0], "motion": [[1, 1, 1.0]], "levels": [1.0] }, "from_hz": 1.0, "to_hz": 2.0,
            } }),
            "exactly one of direction and motion",
        ),
        (
            json!({ "forced": { "levels": [1.0], "frequencies_hz": [1.0, 3.0, 2.0] } }),
            "ascending or descending",
        ),
        (
            json!({ "forced": { "levels": [1.0], "from_hz": 1.0, "frequencies_hz": [1.0, 3.0] } }),
            "both left out",
        ),
        (
            json!({ "forced": { "levels": [1.0], "from_hz": 1.0 } }),
            "analyses.forced.from_hz",
        ),
        (
            json!({ "forced": {
                "forces": [{ "factor": 1.0 }], "base": { "direction": [0.0, 0.0, 1.0], "levels": [1.0] }, "from_hz": 1.0, "to_hz": 2.0,
            } }),
            "without another load",
        ),
        (
            json!({ "forced": { "forces": [{ "factor": 0.0 }], "levels": [1.0], "from_hz": 1.0, "to_hz": 2.0 } }),
            "analyses.forced.forces.factor",
        ),
        (
            json!({ "forced": {
                "unbalance": { "node": "1", "directions": [[1.0, 0.0, 0.0], [0.8, 0.6, 0.0]], "levels": ["1 g mm"] }, "from_hz": 1.0, "to_hz": 2.0,
            } }),
            "at right angles",
        ),
        (
            json!({ "forced": {
                "unbalance": { "node": "1", "directions": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "levels": ["1 g"] }, "from_hz": 1.0, "to_hz": 2.0,
            } }),
            "kg m",
        ),
    ] {
        let found = refusal(analyses);
        assert!(found.contains(told), "{found}");
    }
    // A free structure has no base.
    lap([6, 2, 1], [6, 2, 1]).write(&path);
    let free = of_lap(&path, named(), |scene| {
        scene["analyses"]["forced"] =
            json!({ "base": { "direction": [0.0, 0.0, 1.0], "levels": ["1 g"] }, "from_hz": 1.0, "to_hz": 2.0 });
    });
    let found = run(&free, &Options::default(), &Silent)
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(
        found.contains("analyses.forced.base") && found.contains("6 rigid motions"),
        "{found}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn forces_with_phases_and_an_unbalance_are_those_of_one_force_where_they_must() {
    let folder = folder("several");
    let path = folder.join("oscillator.npz");
    let found = |mu: f64, forced: Value| {
        let mut asked = json!({ "harmonics": 3, "tolerance": 1e-11, "from_hz": 15.0, "to_hz": 30.0, "levels": [6.0] });
        let fields = asked.as_object_mut().unwrap();
        for (name, value) in forced.as_object().unwrap() {
            match value {
                Value::Null => fields.remove(name),
                value => fields.insert(name.clone(), value.clone()),
            };
        }
        let run = try_run(&oscillator(&path, mu, json!({ "forced": asked }))).unwrap();
        let level = summary(&run).forced.remove(0);
        assert_eq!(level.failure, None);
        level
    };
    let at = json!([16.0, 19.0, 20.0, 21.0, 22.0, 24.0, 29.0]);
    let listed = |load: Value| {
        let mut asked = json!({ "from_hz": null, "to_hz": null, "frequencies_hz": at });
        asked.as_object_mut().unwrap().extend(load.as_object().unwrap().clone());
        found(0.2, asked)
    };
    let one = listed(json!({ "terms": [[7, 1, 1.0], [-1, 1, -2.0]] }));
    // The same force 45 degrees later, which are 16 samples, in two parts.
    let parts = json!([
        { "terms": [[7, 1, 1.0]], "factor": 1.0, "phase_deg": -45.0 },
        { "terms": [[-1, 1, 1.0]], "factor": 2.0, "phase_deg": 135.0 },
    ]);
    let two = listed(json!({ "forces": parts }));
    assert!(two.energy_error.iter().all(|error| *error < 1e-9));
    assert_eq!([one.at_frequencies.len(), two.at_frequencies.len()], [7; 2]);
    let lag = |a: f64, b: f64| (a - b + 180.0).rem_euclid(360.0) - 180.0;
    for (one, two) in one.at_frequencies.iter().zip(&two.at_frequencies) {
        assert_eq!(one.frequency_hz, two.frequency_hz);
        assert!((one.amplitude.unwrap() / two.amplitude.unwrap() - 1.0).abs() < 1e-8);
        assert!((lag(two.phase.unwrap(), one.phase.unwrap()) - 45.0).abs() < 1e-6);
    }
    let [a, b] = [&one, &two].map(|level| level.resonances[0].frequency_hz.unwrap());
    assert!((a / b - 1.0).abs() < 1e-8);

    // Without slip everything is linear: the unbalance a is a force a w^2.
    let at = [16.0, 18.5, 21.0, 29.0];
    let listed =
        json!({ "from_hz": null, "to_hz": null, "frequencies_hz": at, "terms": [[-1, 1, 1.0]], "levels": [1.0] });
    let by_force = found(10.0, listed);
    assert_eq!(by_force.at_frequencies.len(), 4);
    let turning = json!({
        "from_hz": null, "to_hz": null, "frequencies_hz": at, "levels": null,
        "unbalance": { "node": "-1", "directions": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "levels": ["20 g mm"] },
    });
    // Its second component needs a coordinate of the node: the mass moves across on a spring of its own.
    let with_across = |forced: Value| {
        let scene = oscillator(&path, 10.0, json!({ "forced": forced }));
        let (ground, spring, masses) = (4e4, 6e4, [1.0, 2.0, 2.0]);
        let stiffness = Mat::from_fn(3, 3, |i, j| match (i, j) {
            (0, 0) => ground + spring,
            (1, 1) => spring,
            (2, 2) => 3e7,
            (2, _) | (_, 2) => 0.0,
            _ => -spring,
        });
        let mass = Mat::from_fn(3, 3, |i, j| if i == j { masses[i] } else { 0.0 });
        write(&path, &stiffness, &mass, &[(7, 1), (-1, 1), (-1, 2)]);
        summary(&try_run(&scene).unwrap()).forced.remove(0)
    };
    let mut asked = turning;
    asked.as_object_mut().unwrap().retain(|_, value| !value.is_null());
    asked["tolerance"] = json!(1e-11);
    let by_mass = with_across(asked);
    assert_eq!(
        (by_mass.failure.as_deref(), by_mass.level_unit.as_str()),
        (None, "kg m")
    );
    for (force, mass) in by_force.at_frequencies.iter().zip(&by_mass.at_frequencies) {
        let w = TAU * force.frequency_hz.unwrap();
        assert_eq!(force.frequency_hz, mass.frequency_hz);
        let ratio = mass.amplitude.unwrap() / (2e-5 * w * w * force.amplitude.unwrap());
        assert!((ratio - 1.0).abs() < 1e-8, "{ratio}");
        assert!(lag(force.phase.unwrap(), mass.phase.unwrap()).abs() < 1e-5);
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn at_the_response_that_a_force_led_to_the_test_needs_that_force() {
    let folder = folder("held");
    let path = folder.join("oscillator.npz");
    let found = |levels: Value| {
        let mut forced = json!({ "from_hz": 15.0, "to_hz": 30.0, "harmonics": 3, "tolerance": 1e-11 });
        forced
            .as_object_mut()
            .unwrap()
            .extend(levels.as_object().unwrap().clone());
        let run = try_run(&oscillator(&path, 0.2, json!({ "forced": forced }))).unwrap();
        summary(&run).forced.remove(0)
    };
    let by_force = found(json!({ "levels": [12.0] }));
    let resonance = &by_force.resonances[0];
    let held = found(json!({ "response_levels": [resonance.amplitude.unwrap()] }));
    assert_eq!((held.failure.as_deref(), held.level_unit.as_str()), (None, "m"));
    assert!(held.amplitude.iter().all(|a| (a / held.level - 1.0).abs() < 1e-8));
    assert!(held.energy_error.iter().all(|error| *error < 1e-9));
    let again = &held.resonances[0];
    assert!((again.force.unwrap() / 12.0 - 1.0).abs() < 1e-8);
    assert!((again.frequency_hz.unwrap() / resonance.frequency_hz.unwrap() - 1.0).abs() < 1e-9);
    std::fs::remove_dir_all(folder).unwrap();
}

/// A shock of the oscillator's base.
fn shock(path: &Path, amplitude: f64, change: impl Fn(&mut Value)) -> Value {
    let motion = json!([[7, 1, 1.0], [-1, 1, 1.0]]);
    let mut asked = json!({
        "base": { "motion": motion },
        "pulse": { "shape": "half-sine", "amplitude": amplitude, "duration_s": 0.02 },
        "periods": 60, "steps_per_period": 200,
    });
    change(&mut asked);
    oscillator(path, 0.2, json!({ "shock": asked }))
}

#[test]
fn a_shock_that_moves_little_is_that_of_the_linear_joint_and_a_large_one_leaves_something_behind() {
    let folder = folder("shock");
    let path = folder.join("oscillator.npz");
    let found = |scene: &Value| summary(&try_run(scene).unwrap()).shock.unwrap();
    let small = found(&shock(&path, 0.1, |_| ()));
    assert_eq!((small.failure.as_deref(), small.load_unit.as_str()), (None, "m/s^2"));
    assert!((small.largest_load / 0.1 - 1.0).abs() < 1e-3);
    let same = |[a, b]: [f64; 2]| (a / b - 1.0).abs();
    assert!(same(small.largest_response) < 1e-6 && same(small.largest_acceleration) < 1e-6);
    assert!(small.energy_error < 0.02, "{}", small.energy_error);
    for (joint, linear) in small.spectrum.joint.iter().zip(&small.spectrum.linear) {
        assert!(same([*joint, *linear]) < 1e-6);
    }
    let large = found(&shock(&path, 100.0, |_| ()));
    assert!(large.largest_response[0] < 1e3 * small.largest_response[0] * 1.5);
    // What friction takes lowers the peak of the spectrum, and what is left is a thousandth or more of the motion, but no more than friction can hold.
    let peak = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    assert!(peak(&large.spectrum.joint) < 0.98 * peak(&large.spectrum.linear));
    let held = 0.2 * 50.0 / 4e4;
    let left = large.residual_sliding;
    println!("{left:e} of {held:e}, still {:e}", large.still_moving);
    assert!(left > 1e-3 * held && left < held, "{left} {held}");
    assert!(large.work_on_contact > 0.0);

    // The same pulse as a file.
    let file = folder.join("pulse.csv");
    let lines = (0..=400).map(|i| {
        let time = f64::from(i) * 1e-4;
        let value = if time <= 0.02 {
            100.0 * (std::f64::consts::PI * time / 0.02).sin()
        } else {
            0.0
        };
        format!("{time},{value}\n")
    });
    let text = "time [s],base [m/s^2]\n".to_owned() + &lines.collect::<String>();
    std::fs::write(&file, text).unwrap();
    let recorded = found(&shock(&path, 1.0, |asked| {
        let asked = asked.as_object_mut().unwrap();
        asked.remove("pulse");
        asked.insert("record".into(), json!({ "path": file }));
    }));
    assert_eq!(recorded.failure, None);
    assert!((recorded.largest_response[0] / large.largest_response[0] - 1.0).abs() < 2e-3);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn shocks_that_cannot_be_are_refused() {
    let folder = folder("shock-refused");
    let path = folder.join("oscillator.npz");
    let refused = |change: &dyn Fn(&mut Value)| match try_run(&shock(&path, 1.0, change)) {
        Err(error) => error.to_string(),
        Ok(run) => summary(&run).shock.unwrap().failure.unwrap(),
    };
    let short = refused(&|asked| asked["pulse"]["duration_s"] = json!(1e-4));
    assert!(short.contains("steps_per_period"), "{short}");
    let both = refused(&|asked| asked["record"] = json!({ "path": "pulse.csv" }));
    assert!(both.contains("exactly one of `pulse` and `record`"), "{both}");
    let gone = refused(&|asked| {
        let asked = asked.as_object_mut().unwrap();
        asked.remove("pulse");
        asked.insert("record".into(), json!({ "path": folder.join("none.csv") }));
    });
    assert!(gone.contains("none.csv"), "{gone}");
    let zero = refused(&|asked| asked["pulse"]["amplitude"] = json!(0.0));
    assert!(zero.contains("analyses.shock.pulse.amplitude"), "{zero}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn random_vibration_from_the_backbone_is_that_of_long_motions_in_time() {
    let folder = folder("random");
    let path = folder.join("oscillator.npz");
    let motion = json!([[7, 1, 1.0], [-1, 1, 1.0]]);
    let given = oscillator(
        &path,
        0.2,
        json!({
            "modes": { "followed": [1, 2] },
            "backbone": { "amplitudes": 40, "amplitude_from": 1e-6, "amplitude_to": 2e-2 },
            // Beyond the second mode, so that both move.
            "random": {
                "base": { "motion": motion }, "psd": [[2.0, 0.05], [80.0, 0.05]], "levels": [0.2, 0.5, 3.0, 12.0],
                "in_time": { "periods": 6000, "steps_per_period": 60 },
            },
        }),
    );
    let found = summary(&try_run(&given).unwrap());
    assert_eq!(found.random_failure, None);
    for level in &found.random {
        assert_eq!(level.in_time_failure, None);
        let in_time = level.in_time.as_ref().unwrap();
        let errors = [
            level.rms_response / in_time.rms_response - 1.0,
            level.rms_acceleration / in_time.rms_acceleration - 1.0,
        ];
        let [low, high] = in_time.rms_response_interval;
        println!(
            "level {}: damping {:.4}, rms {:+.3}, acceleration {:+.3}, interval {:.3}, energy {:.0e} {:?}",
            level.level,
            level.modes[0].damping_ratio,
            errors[0],
            errors[1],
            high / low - 1.0,
            in_time.energy_error,
            level.validity.reasons
        );
        // Of one mode of a joint that loses 40 % of its frequency and whose other mode moves the same joint: 10 % is what is left of the assumptions.
        assert!(
            errors.iter().all(|error| error.abs() < 0.13),
            "{}: {errors:?}",
            level.level
        );
        assert_eq!(in_time.share_of_load, 1.0);
    }
    std::fs::remove_dir_all(folder).unwrap();
}
