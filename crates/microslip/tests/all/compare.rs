//! Ring-downs and `compare` as a user meets them.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;

/// Fails with one line that names all of these.
fn fails(folder: &Path, arguments: &[&str], expected: &[&str]) {
    let output = run(folder, arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {text}");
    for part in expected {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
}

fn amplitudes() -> Vec<f64> {
    (0..=20).map(|k| 1e-7 * 10_f64.powf(f64::from(k) / 5.0)).collect()
}

fn frequency(x: f64) -> f64 {
    170.0 - 2.0 * (x / 1e-7).ln()
}

fn damping(x: f64) -> f64 {
    20.0 * x
}

/// A run whose frequency is linear in ln x and whose damping is a power of x, with a band about it if asked for.
fn write_run(folder: &Path, name: &str, with_band: bool) {
    let backbone: Vec<Value> = amplitudes()
        .iter()
        .map(|&x| {
            json!({ "response_displacement": x, "frequency_hz": frequency(x), "damping_ratio": damping(x), "converged": true })
        })
        .chain([json!({ "response_displacement": null, "frequency_hz": null, "damping_ratio": null, "converged": false })])
        .collect();
    let mut summary = json!({ "backbone": backbone });
    if with_band {
        let bands: Vec<Value> = amplitudes()
            .iter()
            .map(|&x| {
                let frequencies = [-1.0, 0.0, 1.0].map(|shift| frequency(x) + shift);
                let dampings = [0.5, 1.0, 1.1].map(|factor| damping(x) * factor);
                json!({
                    "response_displacement": x,
                    "realisations": 20,
                    "frequency_hz": frequencies,
                    "damping_ratio": dampings,
                })
            })
            .collect();
        summary["ensemble"] = json!({ "realisations": 20, "failed": 0, "bands": bands, "members": [] });
    }
    std::fs::create_dir_all(folder.join(name)).unwrap();
    std::fs::write(folder.join(name).join("summary.json"), summary.to_string()).unwrap();
}

/// Measured: 0.5 Hz below the theory, 1.25 times its damping, over a decade and a half, amplitudes in `unit`.
fn write_experiment(folder: &Path, name: &str, unit: &str, amplitude: impl Fn(f64) -> f64) {
    let mut text =
        format!("amplitude [{unit}],frequency_hz,damping_ratio,frequency_spread_hz,damping_ratio_spread,hits\n");
    for k in 0..=15 {
        let x = 1e-6 * 10_f64.powf(f64::from(k) / 10.0);
        text += &format!(
            "{:?},{:?},{:?},,,1\n",
            amplitude(x),
            frequency(x) - 0.5,
            1.25 * damping(x)
        );
    }
    std::fs::create_dir_all(folder.join(name)).unwrap();
    std::fs::write(folder.join(name).join("backbone.csv"), text).unwrap();
}

#[test]
fn known_differences_are_found_in_any_quantity_and_unit() {
    let folder = folder("compare-known");
    write_run(&folder, "run", true);
    let omega = |x: f64| TAU * (frequency(x) - 0.5);
    write_experiment(&folder, "displacement", "um", |x| 1e6 * x);
    write_experiment(&folder, "velocity", "mm/s", |x| 1e3 * x * omega(x));
    write_experiment(&folder, "acceleration", "g", |x| x * omega(x).powi(2) / 9.80665);
    let text = succeeds(
        &folder,
        &[
            "compare",
            "run",
            "displacement",
            "velocity/backbone.csv",
            "acceleration",
            "--out",
            "out",
        ],
    );
    assert!(text.contains("within the band"), "{text}");
    let report = read_json(&folder.join("out/compare.json"));
    assert_eq!(report["amplitude"]["quantity"], "displacement");
    assert!(report["norm"].as_str().unwrap().contains("root mean square"));
    for (index, name) in ["displacement", "velocity", "acceleration"].iter().enumerate() {
        let found = &report["experiments"][index];
        assert_eq!(found["name"], *name);
        let value = |pointer: &str| found.pointer(pointer).and_then(Value::as_f64).unwrap();
        // Straight lines in the coordinates of the interpolation: whatever the grids, exact.
        for what in ["mean", "rms", "largest"] {
            assert!(
                (value(&format!("/misfit/frequency_hz/{what}")) - 0.5).abs() < 1e-9,
                "{name}"
            );
        }
        assert!((value("/misfit/damping_ln/mean") + 1.25_f64.ln()).abs() < 1e-9);
        assert!((value("/misfit/amplitudes/0") / 1e-6 - 1.0).abs() < 1e-9);
        assert!((value("/misfit/amplitudes/1") / 10_f64.powf(-4.5) - 1.0).abs() < 1e-9);
        // Half a hertz is within one, a quarter more damping is not within a tenth.
        assert_eq!(
            (value("/within_band/frequency"), value("/within_band/damping")),
            (1.0, 0.0)
        );
    }
    let table = std::fs::read_to_string(folder.join("out/compare.csv")).unwrap();
    let columns: Vec<usize> = table.lines().map(|l| l.split(',').count()).collect();
    assert_eq!(columns, [15; 4]);
    let picture = std::fs::read_to_string(folder.join("out/compare.svg")).unwrap();
    for part in [
        "theory: run",
        "95 %",
        "velocity",
        "displacement amplitude at the response point",
        " um",
        " %",
    ] {
        assert!(picture.contains(part), "{part}");
    }

    // Over acceleration the theory is converted by its own frequency: the same shapes, no longer exactly straight.
    succeeds(
        &folder,
        &[
            "compare",
            "run",
            "velocity",
            "--amplitude",
            "acceleration",
            "--out",
            "other",
        ],
    );
    let other = read_json(&folder.join("other/compare.json"));
    let first = &other["theory"]["backbone"][0];
    let expected = 1e-7 * (TAU * frequency(1e-7)).powi(2);
    assert!((first["amplitude"].as_f64().unwrap() / expected - 1.0).abs() < 1e-12);
    let rms = other["experiments"][0]["misfit"]["frequency_hz"]["rms"]
        .as_f64()
        .unwrap();
    assert!((rms - 0.5).abs() < 0.03, "{rms}");
}

#[test]
fn what_cannot_be_compared_is_refused_by_name() {
    let folder = folder("compare-refused");
    write_run(&folder, "run", false);
    write_experiment(&folder, "good", "m", |x| x);
    write_experiment(&folder, "far", "m", |x| 1e6 * x);
    write_experiment(&folder, "volts", "V", |x| x);
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("plain.csv", "a,b\n1,2\n");
    write(
        "words.csv",
        "amplitude [m],frequency_hz,damping_ratio\n1e-6,170,0.01\n1e-5,many,0.01\n",
    );
    write("one.csv", "amplitude [m],frequency_hz,damping_ratio\n1e-6,170,0.01\n");
    write("empty.csv", "");
    write(
        "failed.json",
        r#"{"backbone": [{"response_displacement": null, "frequency_hz": null}]}"#,
    );
    write("other.json", r#"{"hits": []}"#);
    write(
        "band.json",
        r#"{"backbone": [{"response_displacement": 1e-6, "frequency_hz": 170}], "ensemble": {"bands": [{}]}}"#,
    );
    for (run, experiment, expected) in [
        ("run", "far", &["far", "share no amplitude", "1.000e-7"] as &[&str]),
        ("run", "volts", &["volts", "`V`"]),
        ("run", "plain.csv", &["plain.csv", "amplitude [unit]"]),
        ("run", "words.csv", &["words.csv, line 3", "frequency_hz", "`many`"]),
        ("run", "one.csv", &["one.csv", "two different amplitudes"]),
        ("run", "empty.csv", &["empty.csv", "first line"]),
        ("run", "missing", &["missing"]),
        (
            "failed.json",
            "good",
            &["failed.json", "none of the 1 amplitudes", "converged"],
        ),
        ("other.json", "good", &["other.json", "`backbone`"]),
        ("band.json", "good", &["ensemble", "response_displacement"]),
        ("good", "good", &["good: `good` is a measured backbone", "summary.json"]),
    ] {
        fails(&folder, &["compare", run, experiment, "--out", "out"], expected);
        assert!(!folder.join("out").exists());
    }
}

/// Columns of the table of a run at its amplitudes, by the names of their headings.
fn columns<const N: usize>(results: &Path, names: [&str; N]) -> Vec<[f64; N]> {
    let text = std::fs::read_to_string(results.join("backbone.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let headings = lines.next().unwrap();
    let places = names.map(|name| headings.iter().position(|heading| *heading == name).unwrap());
    lines
        .map(|cells| places.map(|place| cells[place].parse().unwrap_or(f64::NAN)))
        .collect()
}

/// Linear over the logarithm of the first of two numbers.
fn at(points: &[[f64; 2]], amplitude: f64) -> f64 {
    let end = points
        .iter()
        .position(|[a, _]| *a >= amplitude)
        .unwrap_or(points.len() - 1)
        .max(1);
    let [[a, f], [b, g]] = [points[end - 1], points[end]];
    f + (g - f) * (amplitude / a).ln() / (b / a).ln()
}

#[test]
fn runs_are_compared_with_runs() {
    let folder = folder("compare-runs");
    succeeds(&folder, &["samples", "samples"]);
    let scene = std::fs::read_to_string(folder.join("samples/joint-mesh.json")).unwrap();
    assert!(scene.contains("\"mu\": 0.2"));
    let other = scene.replace("\"mu\": 0.2", "\"mu\": 0.1");
    std::fs::write(folder.join("samples/smoother.json"), other).unwrap();
    succeeds(&folder, &["run", "samples/joint-mesh.json", "--out", "run"]);
    succeeds(&folder, &["run", "samples/smoother.json", "--out", "smoother"]);

    // Against itself, by folder, summary and table, on either side.
    for first in ["run", "run/summary.json", "run/backbone.csv"] {
        let arguments = [
            "compare",
            first,
            "run",
            "run/summary.json",
            "run/backbone.csv",
            "--out",
            "itself",
        ];
        succeeds(&folder, &arguments);
        let report = read_json(&folder.join("itself/compare.json"));
        assert_eq!(report["theory"]["name"], "run");
        for experiment in report["experiments"].as_array().unwrap() {
            assert_eq!(
                (&experiment["name"], &experiment["measured"]),
                (&json!("run"), &json!("displacement"))
            );
            let misfit = &experiment["misfit"];
            for pointer in ["/frequency_hz/rms", "/frequency_hz/largest", "/damping_ln/largest"] {
                assert_eq!(misfit.pointer(pointer), Some(&json!(0.0)), "{misfit}");
            }
            assert!(misfit["damping_points"].as_f64().unwrap() > 0.0);
        }
    }

    // Against another one: the misfit from both tables, by the rule of the guide. Mu makes a difference where faces slip.
    succeeds(&folder, &["compare", "run", "smoother/backbone.csv", "--out", "other"]);
    let misfit = &read_json(&folder.join("other/compare.json"))["experiments"][0]["misfit"];
    let names = ["response_motion [m]", "frequency_first_harmonic [Hz]"];
    let [ours, theirs] = ["run", "smoother"].map(|results| columns(&folder.join(results), names));
    let low = ours[0][0].max(theirs[0][0]);
    let high = ours[ours.len() - 1][0].min(theirs[theirs.len() - 1][0]);
    let n = 200;
    let grid = (0..n).map(|k| low * (high / low).powf(f64::from(k) / f64::from(n - 1)));
    let squares = grid.map(|amplitude| (at(&ours, amplitude) - at(&theirs, amplitude)).powi(2));
    let rms = (squares.sum::<f64>() / f64::from(n)).sqrt();
    let found = misfit["frequency_hz"]["rms"].as_f64().unwrap();
    assert!(rms > 1.0 && (found / rms - 1.0).abs() < 1e-9, "{found} {rms}");
    // Damping, where both have some, at the largest common amplitude.
    let names = ["response_motion [m]", "damping_ratio_first_harmonic [-]"];
    let [ours, theirs] = ["run", "smoother"].map(|results| {
        let all = columns(&folder.join(results), names);
        let damped = all.into_iter().filter(|[_, zeta]| zeta.is_finite());
        damped.map(|[a, zeta]| [a, zeta.ln()]).collect::<Vec<_>>()
    });
    let largest = at(&ours, high) - at(&theirs, high);
    let found = misfit["damping_ln"]["largest"].as_f64().unwrap().abs();
    assert!(
        largest.abs() > 0.1 && found > largest.abs() * (1.0 - 1e-9),
        "{found} {largest}"
    );

    // Where one has no first harmonics, both are read by their secants.
    let mut summary = read_json(&folder.join("smoother/summary.json"));
    for amplitude in summary["backbone"].as_array_mut().unwrap() {
        amplitude.as_object_mut().unwrap().remove("frequency_first_harmonic_hz");
    }
    std::fs::write(folder.join("secant.json"), summary.to_string()).unwrap();
    succeeds(&folder, &["compare", "smoother", "secant.json", "--out", "secants"]);
    let report = read_json(&folder.join("secants/compare.json"));
    assert_eq!(report["theory"]["name"], "smoother (secant)");
    assert_eq!(report["experiments"][0]["misfit"]["frequency_hz"]["largest"], 0.0);

    // What has no backbone says what it is.
    succeeds(
        &folder,
        &[
            "run",
            "samples/joint-motions.json",
            "--only",
            "forced",
            "--out",
            "forced",
        ],
    );
    succeeds(&folder, &["model", "samples/joint-mesh.json", "--out", "model"]);
    for (results, command) in [
        ("forced", "`run --only forced` of joint-motions"),
        ("forced/summary.json", "`run --only forced` of joint-motions"),
        ("forced/backbone.csv", "`run --only forced` of joint-motions"),
        ("model", "`model` of joint-mesh"),
        ("itself", "`compare` of run with run"),
    ] {
        let expected = [results, command, "no backbone", "give the folder of a `run`"];
        fails(&folder, &["compare", "run", results, "--out", "refused"], &expected);
        fails(&folder, &["compare", results, "run", "--out", "refused"], &expected);
    }
}

#[test]
fn a_ring_down_is_computed_identified_and_compared() {
    let folder = folder("ring-down");
    let quick = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");
    let mut scene = read_json(Path::new(quick));
    scene["analyses"]["ring_down"] =
        json!({ "release": 2e-3, "periods": 80, "steps_per_period": 50, "other_damping": 0.05 });
    for (field, value) in [
        ("amplitudes", json!(24)),
        ("amplitude_from", json!(2.5e-5)),
        ("amplitude_to", json!(2e-3)),
    ] {
        scene["analyses"]["backbone"][field] = value;
    }
    std::fs::write(folder.join("ring.json"), scene.to_string()).unwrap();
    let text = succeeds(&folder, &["run", "ring.json", "--out", "ring"]);
    assert!(text.contains("4000 steps"), "{text}");
    let summary = read_json(&folder.join("ring/summary.json"));
    let number = |pointer: &str| summary["ring_down"].pointer(pointer).and_then(Value::as_f64).unwrap();
    assert!(number("/energy_error") < 1e-4, "{summary:#}");
    assert!(number("/integration_damping_ratio").abs() < 1e-6);
    assert!(number("/theory_minus_ring_down/cqsma/frequency_hz/rms") < 0.5);
    let points = summary["ring_down"]["backbone"].as_array().unwrap();
    assert_eq!(points.len() as f64, number("/points"));
    let largest = points.last().unwrap()["response_displacement"].as_f64().unwrap();
    assert!((5e-4..2e-3).contains(&largest), "{largest}");
    let signal = std::fs::read_to_string(folder.join("ring/ring-down-signal.csv")).unwrap();
    assert_eq!(signal.lines().count(), 4002);
    let read = |name: &str| std::fs::read_to_string(folder.join("ring").join(name)).unwrap();
    assert!(read("ring-down.svg").contains("ring-down, identified"));
    assert!(read("report.html").contains("<h2>Free decay in time</h2>"));
    assert!(read("ring-down-theory.csv").lines().count() > 8);

    // The signal can be identified from its file as well, and both compared with a run of the scene.
    let identify = [
        "identify",
        "ring/ring-down-signal.csv",
        "--channel",
        "acceleration",
        "--bandwidth",
        "80",
        "--smoothing",
        "9",
    ];
    succeeds(&folder, &[&identify[..], &["--out", "again"]].concat());
    succeeds(
        &folder,
        &["compare", "ring", "ring/ring-down.csv", "again", "--out", "compare"],
    );
    let compared = read_json(&folder.join("compare/compare.json"));
    assert_eq!(compared["amplitude"]["unit"], "m/s^2");
    for (index, name) in ["ring/ring-down.csv", "again"].iter().enumerate() {
        let experiment = &compared["experiments"][index];
        assert_eq!(experiment["name"], *name);
        let value = |pointer: &str| experiment.pointer(pointer).and_then(Value::as_f64).unwrap();
        // Eight amplitudes with lines between them are a coarse theory.
        assert!(
            value("/misfit/frequency_hz/rms") < 1.0 && value("/misfit/damping_ln/rms") < 0.3,
            "{experiment:#}"
        );
    }

    // A motion that cannot be followed leaves the backbone, and says why there is no ring-down.
    scene["analyses"]["ring_down"]["steps_per_period"] = json!(2);
    scene["analyses"]["backbone"]["amplitudes"] = json!(2);
    std::fs::write(folder.join("coarse.json"), scene.to_string()).unwrap();
    let output = run(&folder, &["run", "coarse.json", "--out", "coarse"]);
    assert_eq!(exit_code(&output), 3, "{}", messages(&output));
    let summary = read_json(&folder.join("coarse/summary.json"));
    let reason = summary["ring_down"]["failure"].as_str().unwrap();
    assert!(reason.contains("steps_per_period = 2"), "{reason}");
    assert!(!summary["backbone"].as_array().unwrap().is_empty());
}
