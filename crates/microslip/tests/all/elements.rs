//! The joints of a finished run as elements for other programs.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use crate::fields::{AT_HOME, ELSEWHERE, results_of, without_epmc};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use std::path::Path;

fn number(of: &Value, pointer: &str) -> f64 {
    of.pointer(pointer)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("{pointer} in {of}"))
}

fn scene(amplitudes: usize) -> Value {
    json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": "quick" },
        "interfaces": { "gap": "flat" },
        "analyses": { "backbone": {
            "amplitudes": amplitudes, "amplitude_from": "1 um", "amplitude_to": "0.3 mm", "vertices_per_quarter": 8
        } }
    })
}

fn export(folder: &Path, format: &str) -> String {
    succeeds(
        folder,
        &["export", "run", "--format", format, "--out", format, "--overwrite"],
    )
}

/// Large fields of the cards of a name, cards one after another; blank fields are kept within a card.
fn cards(text: &str, name: &str) -> Vec<Vec<String>> {
    let mut all: Vec<Vec<String>> = Vec::new();
    let mut is_of = false;
    for line in text.lines().filter(|line| !line.starts_with('$')) {
        if !line.starts_with('*') {
            is_of = line.starts_with(&format!("{name}*"));
            all.extend(is_of.then(Vec::new));
        }
        if is_of {
            let line = format!("{line:<72}");
            let fields = (0..4).map(|k| line[8 + 16 * k..24 + 16 * k].trim().to_owned());
            all.last_mut().unwrap().extend(fields);
        }
    }
    all
}

/// Force of Jenkins sliders in parallel that stand for an Iwan element over a motion, by their own rule.
struct Sliders {
    all: Vec<(f64, f64)>,
    places: Vec<f64>,
}

impl Sliders {
    fn of(element: &Value) -> Self {
        let [force, stiffness, chi, beta, spring] = ["slip_force", "stiffness", "chi", "beta", "spring"]
            .map(|name| number(element, &format!("/element/{name}")));
        let p = chi + 1.0;
        let most = force * (1.0 + beta) / (stiffness * (beta + p / (p + 1.0)));
        let density = stiffness / (1.0 + beta) * p / most.powf(p);
        // Cells in geometric steps: the motions are far below the largest displacement.
        let edges: Vec<f64> = (0..=6000)
            .map(|k| {
                if k == 0 {
                    0.0
                } else {
                    most * 1e-9_f64.powf(1.0 - f64::from(k) / 6000.0)
                }
            })
            .collect();
        let cell = |edge: &[f64]| {
            let moment = |power: f64| (edge[1].powf(power) - edge[0].powf(power)) / power;
            (moment(p + 1.0) / moment(p), density * moment(p))
        };
        let all: Vec<(f64, f64)> = edges
            .windows(2)
            .map(cell)
            .chain([(most, stiffness * beta / (1.0 + beta)), (f64::INFINITY, spring)])
            .collect();
        let places = vec![0.0; all.len()];
        Self { all, places }
    }

    fn force(&mut self, u: f64) -> f64 {
        let each = self.all.iter().zip(&mut self.places).map(|((most, stiffness), place)| {
            let stretch = (u - *place).clamp(-most, *most);
            *place = u - stretch;
            stiffness * stretch
        });
        each.sum()
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_the_joints_of_a_run_stand_in_other_models() {
    let folder = folder("elements");
    std::fs::write(folder.join("beam.json"), scene(7).to_string()).unwrap();
    succeeds(&folder, &["run", "beam.json", "--out", "run"]);
    let summary = read_json(&folder.join("run/summary.json"));
    let backbone = summary["backbone"].as_array().unwrap();

    // Three bolts along x; the connections make up the interface and its dissipation.
    let connections = summary["connections"].as_array().unwrap();
    let names: Vec<&str> = connections.iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["bolt 1", "bolt 2", "bolt 3"]);
    let area: f64 = connections.iter().map(|one| number(one, "/area")).sum();
    assert!((area / number(&summary, "/model/interface_area") - 1.0).abs() < 1e-12);
    for point in backbone {
        let around: Vec<&Value> = point["connections"].as_array().unwrap().iter().collect();
        let dissipated: f64 = around.iter().map(|one| number(one, "/dissipation")).sum();
        assert!((dissipated / number(point, "/dissipation") - 1.0).abs() < 1e-9);
        // The first bending mode is symmetric about the middle: the outer bolts slide alike and along the beam, the middle one does not.
        let [first, middle, last] = around[..] else {
            panic!("{point}")
        };
        let [a, b, c] = [first, middle, last].map(|one| number(one, "/displacement"));
        assert!((a / c - 1.0).abs() < 0.05 && b < 0.05 * a, "{a} {b} {c}");
        assert!(number(first, "/direction/0") > 0.99 && number(first, "/coherence") > 0.5);
        // A loop of common motion is a part of what is dissipated, and no more than all.
        let [area, all] = ["/loop_area", "/dissipation"].map(|name| number(first, name));
        assert!(area > 0.0 && area < 1.02 * all, "{area} of {all}");
    }

    let text = export(&folder, "cbush");
    assert!(text.contains("bolt 2: only "), "{text}");
    let bdf = std::fs::read_to_string(folder.join("cbush/cbush.bdf")).unwrap();
    assert!(bdf.contains("Units: m, N, kg, s"));
    let bushes = cards(&bdf, "PBUSH");
    // Of each bolt a level per amplitude, and one with a table.
    assert_eq!(
        (bushes.len(), cards(&bdf, "PBUSHT").len(), cards(&bdf, "CORD2R").len()),
        (3 * 8, 3, 3)
    );
    let real = |text: &str| text.parse::<f64>().unwrap();
    for (card, point) in bushes.iter().zip(backbone) {
        let of = &point["connections"][0];
        let [force, motion, joules] = ["/force", "/displacement", "/dissipation"].map(|name| number(of, name));
        assert!((real(&card[2]) / (force / motion) - 1.0).abs() < 1e-7 && card[1] == "K" && card[9] == "GE");
        assert!((real(&card[10]) / (joules / (PI * force * motion)) - 1.0).abs() < 1e-7);
    }
    let table = &cards(&bdf, "TABLED1")[0];
    let values: Vec<f64> = table[8..]
        .iter()
        .take_while(|cell| *cell != "ENDT")
        .map(|cell| real(cell))
        .collect();
    assert_eq!(values.len(), 2 * 15);
    assert!(
        values
            .chunks(2)
            .zip(values.chunks(2).rev())
            .all(|(a, b)| a[0] == -b[0] && a[1] == -b[1])
    );
    assert!(
        values
            .chunks(2)
            .zip(values.chunks(2).skip(1))
            .all(|(a, b)| a[0] < b[0] && a[1] < b[1])
    );

    export(&folder, "connector");
    let inp = std::fs::read_to_string(folder.join("connector/connectors.inp")).unwrap();
    assert_eq!(
        inp.matches("*CONNECTOR DAMPING, COMPONENT=1, TYPE=STRUCTURAL\n")
            .count(),
        3 * 7
    );

    // The fitted element of the modal coordinate, moved through a cycle, has frequency and damping of the run within the error that it states.
    for format in ["iwan", "bouc-wen"] {
        let text = export(&folder, format);
        assert!(
            text.contains("mode 1, bolt 1: ") && text.contains("largest error of stiffness"),
            "{text}"
        );
    }
    let found = read_json(&folder.join("iwan/iwan.json"));
    let elements = found["elements"].as_array().unwrap();
    assert_eq!(elements.len(), 4);
    let modal = &elements[0];
    assert_eq!(
        (modal["coordinate"].as_str(), modal["quality"].as_str()),
        (Some("modal coordinate"), Some("good"))
    );
    let [of_stiffness, of_dissipation] =
        ["stiffness", "dissipation"].map(|what| number(modal, &format!("/{what}/largest")));
    assert!(of_stiffness < 0.01 && of_dissipation < 0.1);
    for point in backbone {
        let q = number(point, "/modal_amplitude");
        let mut sliders = Sliders::of(modal);
        sliders.force(q);
        let (mut area, mut peak, mut before) = (0.0, 0.0_f64, None);
        for k in (0..=2000).map(|k| 0.5 * TAU + TAU * f64::from(k) / 2000.0) {
            let u = -q * (k - 0.5 * TAU).cos();
            let force = sliders.force(u);
            peak = peak.max(force);
            if let Some((u0, f0)) = before {
                area += 0.5 * (force + f0) * (u - u0);
            }
            before = Some((u, force));
        }
        let hertz = (peak / q).sqrt() / TAU;
        assert!((hertz / number(point, "/frequency_hz") - 1.0).abs() < 0.5 * of_stiffness + 1e-5);
        let zeta = area / (TAU * q * peak);
        let friction = number(point, "/friction_damping_ratio");
        assert!(
            (zeta / friction - 1.0).abs() < of_dissipation + of_stiffness + 1e-3,
            "{zeta} {friction}"
        );
    }
}

#[test]
fn a_connection_without_slip_has_the_stiffness_of_the_law_times_its_area() {
    let folder = folder("elements-stuck");
    for (name, place) in [("home", AT_HOME), ("elsewhere", ELSEWHERE)] {
        results_of(&folder, name, place, without_epmc);
        let summary = read_json(&folder.join(name).join("summary.json"));
        let connection = &summary["connections"][0];
        let stuck = &summary["backbone"][0]["connections"][0];
        let vector = |of: &Value, name: &str| [0, 1, 2].map(|c| number(of, &format!("/{name}/{c}")));
        let close = |a: [f64; 3], b: [f64; 3], within: f64| a.iter().zip(b).all(|(a, b)| (a - b).abs() < within);
        // 60 x 20 mm with 8e11 Pa/m, about the middle; the first mode bends along x.
        assert!((number(connection, "/area") - 1.2e-3).abs() < 1e-12);
        assert!(close(
            vector(connection, "position"),
            place.of([0.03, 0.01, 0.0]),
            1e-12
        ));
        assert!(close(
            vector(connection, "frame/2"),
            place.turn([0.0, 0.0, -1.0]),
            1e-12
        ));
        let along = place.turn([1.0, 0.0, 0.0]);
        let sign = vector(stuck, "direction")
            .iter()
            .zip(along)
            .map(|(a, b)| a * b)
            .sum::<f64>();
        assert!(close(
            vector(stuck, "direction").map(|x| sign.signum() * x),
            along,
            1e-6
        ));
        let stiffness = number(stuck, "/force") / number(stuck, "/displacement");
        assert!((stiffness / (8e11 * 1.2e-3) - 1.0).abs() < 1e-6, "{stiffness:e}");
    }
}

#[test]
fn what_cannot_be_exported_is_said() {
    let folder = folder("elements-refused");
    let refused = |arguments: &[&str], expected: &[&str]| {
        let output = run(&folder, &[&["export"], arguments, &["--out", "out"]].concat());
        let text = messages(&output);
        assert_eq!(exit_code(&output), 1, "{text}");
        assert!(expected.iter().all(|part| text.contains(part)), "{text}");
        assert!(!folder.join("out").exists());
    };
    refused(
        &["--format", "iwan"],
        &["--format iwan takes the folder of a finished run", "microslip run"],
    );
    std::fs::write(folder.join("beam.json"), scene(2).to_string()).unwrap();
    refused(&["beam.json", "--format", "cbush"], &["is no folder"]);
    succeeds(&folder, &["run", "beam.json", "--out", "run"]);
    // Two amplitudes make no element, which the file says; the tables are as good as any.
    let text = succeeds(&folder, &["export", "run", "--format", "iwan", "--out", "iwan"]);
    assert!(text.contains("no element: ") && text.contains("needs three"), "{text}");
    assert!(read_json(&folder.join("iwan/iwan.json"))["elements"][0]["failure"].is_string());
    let path = folder.join("run/summary.json");
    let mut summary = read_json(&path);
    summary.as_object_mut().unwrap().remove("connections");
    std::fs::write(&path, summary.to_string()).unwrap();
    refused(
        &["run", "--format", "cbush"],
        &["no connections", "run the scene again"],
    );
    summary["scene"]["model"]["symmetry"] = json!("half");
    std::fs::write(&path, summary.to_string()).unwrap();
    refused(&["run", "--format", "cbush"], &["the half", "model.symmetry"]);
}
