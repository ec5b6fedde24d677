//! The commands as a user meets them: the built program, its exit codes, its messages and its files.
#![allow(clippy::unwrap_used)]

use crate::common::page::{DATA, SCRIPT, data_of, scripts_of};
use crate::common::{assert_same_numbers, exit_code, folder, messages, read_json, run};
use crate::inputs::{faces, ring_down};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");

/// The quick scene, run once with two threads and an empty cache; the folder that it ran in.
fn quick() -> &'static Path {
    static RUN: OnceLock<PathBuf> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = folder("quick");
        let output = run(&folder, &["run", QUICK, "--threads", "2", "--verbose"]);
        assert_eq!(exit_code(&output), 0, "{}", messages(&output));
        std::fs::write(folder.join("stdout"), &output.stdout).unwrap();
        std::fs::write(folder.join("stderr"), &output.stderr).unwrap();
        folder
    })
}

fn quick_results() -> PathBuf {
    quick().join("results/brb-quick")
}

fn quick_summary() -> Value {
    read_json(&quick_results().join("summary.json"))
}

/// A scene on the benchmark, with `fields` for all else, is refused.
fn rejected(name: &str, fields: &str, expected: &[&str]) {
    let folder = folder(name);
    let scene = fields.replacen('{', "{ \"structure\": { \"benchmark\": \"brake-reuss-beam\" }, ", 1);
    std::fs::write(folder.join("scene.json"), scene).unwrap();
    let output = run(&folder, &["run", "scene.json"]);
    assert_eq!(exit_code(&output), 1);
    let text = messages(&output);
    assert!(text.starts_with("error: "), "{text}");
    for part in expected {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    assert!(!folder.join("results").exists(), "a rejected scene leaves no folder");
}

#[test]
fn the_summary_keeps_its_contract() {
    let summary = quick_summary();
    for (pointer, fields) in [
        (
            "",
            "schema_version scene model law gap prestress modes backbone validity skipped provenance timings peak_memory",
        ),
        (
            "/model",
            "n_nodes n_elements n_dofs mass interface_area n_interface_elements n_interface_points n_relative_dofs n_modes \
             zem_unstressed zem_stuck stuck_frequencies_hz unstressed_frequencies_hz penalty_frequencies_hz \
             penalty_spectrum_error reduction_asymmetry error_bar",
        ),
        ("/model/error_bar", "frequency_relative damping_ln source"),
        (
            "/law",
            "kind tangential history fit_rms_normal fit_rms_tangential table_error_normal table_error_tangential \
             fitted_to_summed paper_to_mindlin",
        ),
        (
            "/prestress",
            "bolt_load iterations residual_ratio equilibrium_error contact_area_fraction max_pressure mean_pressure \
             converged",
        ),
        ("/modes/0", "frequency_hz"),
        (
            "/backbone/0",
            "status modal_force modal_amplitude frequency_hz frequency_first_harmonic_hz damping_ratio \
             damping_ratio_first_harmonic damping_floor friction_damping_ratio dissipation loop_area response_motion \
             response_acceleration response_displacement slip_fraction open_fraction iterations shape_deviation \
             converged failure",
        ),
        (
            "/timings",
            "mesh assemble reduce characterise prestress modes backbone total",
        ),
    ] {
        let object = summary.pointer(pointer).and_then(Value::as_object).unwrap();
        for field in fields.split_whitespace() {
            assert!(object.contains_key(field), "{pointer}/{field} is missing");
        }
    }
    assert_eq!(summary["scene"]["name"], "brb-quick");
    assert_eq!(
        summary["scene"]["units"],
        json!({ "length": "m", "mass": "kg", "time": "s" })
    );
    assert_eq!(summary["backbone"].as_array().unwrap().len(), 8);
    assert_eq!(summary["model"]["stuck_frequencies_hz"].as_array().unwrap().len(), 10);
    // Eight amplitudes, of which the defaults store four; dead loads; flat faces; small amplitudes without slip; the whole structure.
    let skipped = summary["skipped"].as_object().unwrap();
    let names: Vec<&str> = skipped.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "attachment_modes",
            "factorisations",
            "fields",
            "gap",
            "way_back_of_loops"
        ]
    );
    assert!(skipped["fields"].as_str().unwrap().contains("4 of 8 amplitudes"));
    let seconds = |stage: &str| summary["timings"][stage].as_f64().unwrap();
    let sum: f64 = summary["timings"]
        .as_object()
        .unwrap()
        .keys()
        .filter(|k| *k != "total")
        .map(|k| seconds(k))
        .sum();
    assert!(seconds("reduce") > 0.0 && sum <= seconds("total"));
    if cfg!(target_os = "linux") {
        assert!(summary["peak_memory"].as_u64().unwrap() > 1_000_000);
    }
}

#[test]
fn the_table_agrees_with_the_summary_and_the_terminal() {
    let summary = quick_summary();
    let table = std::fs::read_to_string(quick_results().join("backbone.csv")).unwrap();
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let printed = std::fs::read_to_string(quick().join("stdout")).unwrap();
    for (line, point) in lines.zip(summary["backbone"].as_array().unwrap()) {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| cells[names.iter().position(|n| n.starts_with(name)).unwrap()];
        for (column, field) in [
            ("response_displacement", "response_displacement"),
            ("response_motion", "response_motion"),
            ("frequency [", "frequency_hz"),
            ("frequency_first_harmonic", "frequency_first_harmonic_hz"),
            ("damping_ratio [", "damping_ratio"),
            ("damping_ratio_first_harmonic", "damping_ratio_first_harmonic"),
            ("dissipation", "dissipation"),
        ] {
            // Empty where it is null: damping below its floor.
            assert_eq!(cell(column).parse::<f64>().ok(), point[field].as_f64(), "{column}");
        }
        assert!(point["frequency_hz"].is_f64());
        assert_eq!(cell("converged"), "true");
        let frequency = format!("{:.4}", point["frequency_hz"].as_f64().unwrap());
        assert!(printed.contains(&frequency), "{frequency} is not printed");
    }
    assert_eq!(table.lines().count(), 9);
    assert!(printed.contains("first frequency about the prestress") && printed.contains("report.html"));
    // Standard error is no terminal here: plain lines, one per stage.
    let progress = std::fs::read_to_string(quick().join("stderr")).unwrap();
    for stage in [
        "mesh",
        "assemble",
        "reduce",
        "characterise",
        "prestress",
        "modes",
        "backbone",
    ] {
        assert!(progress.contains(&format!("{stage} ... ")), "{progress}");
    }
}

#[test]
fn the_interface_files_conserve_force_and_energy() {
    let summary = quick_summary();
    let last = &summary["backbone"][7];
    for (name, field, expected) in [
        (
            "interface-prestress.vtu",
            "pressure [Pa]",
            3.0 * summary["prestress"]["bolt_load"].as_f64().unwrap(),
        ),
        (
            "interface-amplitude-08.vtu",
            "flux_total [J/m^2]",
            last["dissipation"].as_f64().unwrap(),
        ),
        (
            "interface-amplitude-08.vtu",
            "slip_area_fraction [-]",
            last["slip_fraction"].as_f64().unwrap() * summary["model"]["interface_area"].as_f64().unwrap(),
        ),
    ] {
        let text = std::fs::read_to_string(quick_results().join(name)).unwrap();
        let values = |name: &str| -> Vec<f64> {
            let from = text.split(&format!("Name=\"{name}\"")).nth(1).unwrap();
            let body = from.split_once('>').unwrap().1.split_once('<').unwrap().0;
            body.split_whitespace().map(|v| v.parse().unwrap()).collect()
        };
        let (points, connectivity, offsets) = (values("Points"), values("connectivity"), values("offsets"));
        assert_eq!(values("types").len(), 148);
        let mut begin = 0;
        let mut integral = 0.0;
        for (end, value) in offsets.iter().map(|o| *o as usize).zip(values(field)) {
            let corner = |i: usize| {
                let node = connectivity[begin + i % (end - begin)] as usize;
                (points[3 * node], points[3 * node + 1])
            };
            let shoelace = (0..end - begin).map(|i| corner(i).0 * corner(i + 1).1 - corner(i + 1).0 * corner(i).1);
            integral += 0.5 * shoelace.sum::<f64>() * value;
            begin = end;
        }
        assert!(
            (integral / expected - 1.0).abs() < 1e-9,
            "{field}: {integral} instead of {expected}"
        );
    }
}

#[test]
fn the_report_is_one_page_without_outside_help() {
    let report = std::fs::read_to_string(quick_results().join("report.html")).unwrap();
    assert_eq!(
        report.matches("<svg").count(),
        6,
        "backbone, pressure and four amplitudes"
    );
    let (markup, scripts) = scripts_of(&report);
    for outside in ["<link", "src=", "href=", "@import", "url("] {
        assert!(!markup.contains(outside), "{outside}");
    }
    for (tag, _) in &scripts {
        assert!([SCRIPT, DATA].contains(tag), "{tag}");
    }
    let policy = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; ";
    let name_of_svg = "http://www.w3.org/2000/svg";
    assert!(markup.contains(policy) && !markup.replace(name_of_svg, "").contains("://"));
    let frequency = format!(
        "{:.4}",
        quick_summary()["backbone"][7]["frequency_hz"].as_f64().unwrap()
    );
    assert!(report.contains(&frequency) && report.contains("All amplitudes converged."));
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let folder = folder("one-thread");
    let output = run(&folder, &["run", QUICK, "--threads", "1", "--no-cache"]);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    assert!(!folder.join("results/.cache").exists() && !folder.join("caches").exists());
    assert_same_numbers(&folder.join("results/brb-quick"), &quick_results());
    let data = |results: &Path| data_of(&std::fs::read_to_string(results.join("report.html")).unwrap()).to_owned();
    assert_eq!(data(&folder.join("results/brb-quick")), data(&quick_results()));
}

#[test]
fn units_do_not_change_the_results() {
    let folder = folder("units");
    let mut scene = read_json(Path::new(QUICK));
    scene["units"] = json!({ "length": "mm", "mass": "t", "time": "s" });
    let si = &quick_summary()["scene"];
    let at = |pointer: &str| si.pointer(pointer).unwrap().as_f64().unwrap();
    scene["model"]["material"] = json!({
        "youngs_modulus": at("/model/material/youngs_modulus") * 1e-6,
        "poisson_ratio": at("/model/material/poisson_ratio"),
        "density": at("/model/material/density") * 1e-12,
        "hardness": at("/model/material/hardness") * 1e-6,
    });
    scene["bolts"] = json!({ "load": at("/bolts/load") });
    scene["analyses"]["backbone"]["amplitude_from"] = json!(at("/analyses/backbone/amplitude_from") * 1e3);
    scene["analyses"]["backbone"]["amplitude_to"] = json!(at("/analyses/backbone/amplitude_to") * 1e3);
    std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
    let output = run(&folder, &["run", "scene.json", "--out", "out", "--no-cache"]);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));

    let (a, b) = (quick_summary(), read_json(&folder.join("out/summary.json")));
    let near = |a: &Value, b: &Value, tolerance: f64| {
        let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
        (a - b).abs() <= tolerance * a.abs().max(b.abs())
    };
    for pointer in ["/model/mass", "/modes/0/frequency_hz", "/prestress/max_pressure"] {
        assert!(
            near(a.pointer(pointer).unwrap(), b.pointer(pointer).unwrap(), 1e-9),
            "{pointer}"
        );
    }
    let tolerance = at("/analyses/backbone/tolerance");
    for (a, b) in a["backbone"]
        .as_array()
        .unwrap()
        .iter()
        .zip(b["backbone"].as_array().unwrap())
    {
        for field in ["frequency_hz", "response_displacement", "modal_force"] {
            assert!(near(&a[field], &b[field], 1e-9), "{field}: {} {}", a[field], b[field]);
        }
        // Dissipation is a difference of large numbers: what the tolerance of the solver leaves of it.
        let number = |v: &Value, field: &str| v[field].as_f64().unwrap();
        let floor = 10.0 * tolerance * number(a, "modal_force") * number(a, "modal_amplitude");
        let (da, db) = (number(a, "dissipation"), number(b, "dissipation"));
        assert!((da - db).abs() <= 1e-9 * da.abs() + floor, "dissipation: {da} {db}");
        let count = |v: &Value| v["iterations"].as_i64().unwrap();
        assert!(
            (count(a) - count(b)).abs() <= 1,
            "iterations: {} {}",
            count(a),
            count(b)
        );
    }
}

#[test]
fn amplitudes_that_do_not_converge_are_results() {
    let folder = folder("too-far");
    let mut scene = read_json(Path::new(QUICK));
    scene["analyses"]["backbone"] = json!({ "amplitudes": 2, "vertices_per_quarter": 1, "amplitude_to": 1e6 });
    std::fs::write(folder.join("too-far.json"), scene.to_string()).unwrap();
    let output = run(&folder, &["run", "too-far.json"]);
    assert_eq!(exit_code(&output), 3, "{}", messages(&output));
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.contains("1 of 2 amplitudes DID NOT CONVERGE"), "{printed}");
    let results = folder.join("results/too-far");
    let summary = read_json(&results.join("summary.json"));
    let point = &summary["backbone"][1];
    assert_eq!(
        (&point["converged"], &point["frequency_hz"]),
        (&json!(false), &Value::Null)
    );
    // Far more than the bolts hold together; the first amplitude is far less.
    assert_eq!(point["status"], "no-equilibrium");
    let force = |index: usize| summary["backbone"][index]["modal_force"].as_f64().unwrap();
    let holds = summary["validity"]["separation_modal_force"].as_f64().unwrap();
    assert!(force(0) < holds && holds < force(1), "{holds}");
    let table = std::fs::read_to_string(results.join("backbone.csv")).unwrap();
    assert!(table.lines().nth(2).unwrap().starts_with("2,false,,,,"), "{table}");
}

#[test]
fn bad_scenes_are_refused_with_the_field_named() {
    let units = r#""units": { "length": "m", "mass": "kg", "time": "s" }"#;
    rejected(
        "unknown-field",
        &format!("{{ {units}, \"frction\": 0.2 }}"),
        &["scene.json", "frction"],
    );
    let nested = format!("{{ {units}, \"analyses\": {{ \"backbone\": {{ \"amplitude\": 3 }} }} }}");
    rejected("unknown-nested-field", &nested, &["scene.json", "amplitude"]);
    rejected(
        "no-units",
        "{ \"interfaces\": { \"mu\": 0.2 } }",
        &["scene.json", "units"],
    );
    rejected(
        "bad-value",
        &format!("{{ {units}, \"interfaces\": {{ \"mu\": -0.2 }} }}"),
        &["scene.json", "interfaces.mu = -0.2"],
    );
    rejected(
        "no-folder-name",
        &format!("{{ {units}, \"name\": \"../up\" }}"),
        &["../up", "--out"],
    );
}

#[test]
fn missing_files_and_bad_arguments_are_errors() {
    let folder = folder("arguments");
    let output = run(&folder, &["run", "nowhere.json"]);
    assert_eq!(exit_code(&output), 1);
    assert!(
        messages(&output).starts_with("error: nowhere.json: No such file"),
        "{}",
        messages(&output)
    );
    for threads in ["0", "1000000", "-1", "many"] {
        let output = run(&folder, &["run", QUICK, &format!("--threads={threads}")]);
        assert_eq!(exit_code(&output), 2);
        assert!(messages(&output).contains("--threads"), "{}", messages(&output));
    }
    std::fs::write(folder.join("occupied"), "a file").unwrap();
    let output = run(&folder, &["run", QUICK, "--out", "occupied"]);
    assert_eq!(exit_code(&output), 1);
    assert!(messages(&output).contains("occupied"), "{}", messages(&output));
}

#[test]
fn ring_downs_are_identified_averaged_and_drawn() {
    let folder = folder("identify");
    for (name, scale) in [("a.csv", 1.0), ("b.csv", 0.4)] {
        std::fs::write(folder.join(name), ring_down(scale, 0.2)).unwrap();
    }
    let base = [
        "identify",
        "a.csv",
        "b.csv",
        "--channel",
        "acc",
        "--frequency",
        "181",
        "--bandwidth",
        "20",
    ];
    let output = run(
        &folder,
        &[&base[..], &["--out", "out", "--amplitude", "displacement"]].concat(),
    );
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(
        printed.contains("channel `still` has one value throughout"),
        "{printed}"
    );

    let table = std::fs::read_to_string(folder.join("out/backbone.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(
        lines.next().unwrap(),
        "amplitude [m],frequency_hz,damping_ratio,frequency_spread_hz,damping_ratio_spread,hits"
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 200);
    let number = |cell: &str| cell.parse::<f64>().unwrap();
    assert!(rows.is_sorted_by(|a, b| number(a[0]) < number(b[0])));
    assert!(rows.iter().any(|r| r[5] == "2" && number(r[3]) < 0.01) && rows[199][5] == "1" && rows[199][3].is_empty());
    for row in &rows {
        assert!((number(row[1]) - 180.0).abs() < 0.01, "{row:?}");
        assert!((number(row[2]) / 0.003 - 1.0).abs() < 0.03, "{row:?}");
    }
    // 5 g at the start is more than any amplitude after it.
    let first = 5.0 * 9.80665 / (std::f64::consts::TAU * 180.0_f64).powi(2);
    assert!((0.7..1.0).contains(&(number(rows[199][0]) / first)));

    let report = read_json(&folder.join("out/identification.json"));
    assert_eq!(report["amplitude"], json!({ "quantity": "displacement", "unit": "m" }));
    assert_eq!(report["settings"]["bandwidth_hz"], 20.0);
    let hit = &report["hits"][1];
    assert_eq!((&hit["file"], &hit["channel"]), (&json!("b.csv"), &json!("acc")));
    assert!((hit["sample_rate_hz"].as_f64().unwrap() - 4096.0).abs() < 0.01);
    assert!(hit["trims"]["end_s"].as_f64().unwrap() < 2.0 && hit["trims"]["end_reason"].is_string());
    assert!(
        hit["cross_check"]["frequency_difference_hz"]["median"]
            .as_f64()
            .unwrap()
            < 0.01
    );
    let picture = std::fs::read_to_string(folder.join("out/backbone.svg")).unwrap();
    for text in [
        "time [s]",
        "frequency [Hz]",
        "damping ratio [-]",
        "mean + spread",
        "band",
    ] {
        assert!(picture.contains(text), "{text}");
    }
    let mut left: Vec<_> = std::fs::read_dir(folder.join("out"))
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    left.sort();
    assert_eq!(
        left,
        ["backbone.csv", "backbone.svg", "identification.json", "manifest.json"]
    );
}

#[test]
fn sweeps_that_hold_their_response_are_identified_level_by_level() {
    let folder = folder("identify-sweeps");
    // 0.5 kg at 100 Hz with 1 %, moved by 10 and 20 um while the frequency rises by 2 Hz/s.
    let (mass, natural, zeta, rate) = (0.5, std::f64::consts::TAU * 100.0, 0.01, 4096.0);
    for (name, amplitude, end) in [
        ("a.csv", 1e-5, 105.0),
        ("b.csv", 2e-5, 105.0),
        ("short.csv", 1e-5, 97.0),
    ] {
        let mut text = String::from("time [s],shaker [N],tip [um],room [m/s^2]\n");
        for sample in 0..((end - 95.0) / 2.0 * rate) as usize {
            let time = f64::from(sample as u32) / rate;
            let (phase, omega) = (
                std::f64::consts::TAU * (95.0 + time) * time,
                std::f64::consts::TAU * (95.0 + 2.0 * time),
            );
            let (sine, cosine) = phase.sin_cos();
            let in_phase = natural * natural - omega * omega;
            let lagging = -2.0 * zeta * natural * omega - std::f64::consts::TAU * 2.0;
            let force = mass * amplitude * (in_phase * cosine + lagging * sine);
            text += &format!("{time:.9},{force:.9e},{:.9e},0.1\n", 1e6 * amplitude * cosine);
        }
        std::fs::write(folder.join(name), text).unwrap();
    }
    let base = [
        "identify",
        "a.csv",
        "b.csv",
        "--swept-sine",
        "shaker",
        "--channel",
        "tip",
    ];
    let output = run(&folder, &[&base[..], &["--out", "out"]].concat());
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let report = read_json(&folder.join("out/identification.json"));
    for (level, amplitude) in report["levels"].as_array().unwrap().iter().zip([1e-5, 2e-5]) {
        let number = |value: &Value| value.as_f64().unwrap();
        for (name, expected, error) in [
            ("amplitude", amplitude, 1e-4),
            ("frequency_hz", 100.0, 1e-6),
            ("damping_ratio", zeta, 1e-4),
            ("modal_mass_kg", mass, 1e-3),
        ] {
            let found = number(&level[name]);
            assert!((found / expected - 1.0).abs() < error, "{name}: {found}");
        }
        assert!((number(&level["sweep"]["rate_hz_per_s"]) - 2.0).abs() < 1e-3);
        assert!((number(&level["sweep"]["slow_below_hz_per_s"]) - 2.0).abs() < 1e-3);
        assert_eq!(level["warnings"], json!(["channel `room` has one value throughout"]));
    }
    let table = std::fs::read_to_string(folder.join("out/backbone.csv")).unwrap();
    assert_eq!(table.lines().count(), 3);

    for (arguments, told) in [
        (&["a.csv", "--swept-sine", "hammer"][..], "no channel `hammer`"),
        (&["a.csv", "--swept-sine", "shaker"], "`tip`, `room`"),
        (
            &["a.csv", "--swept-sine", "tip", "--channel", "shaker"],
            "none of force",
        ),
        (
            &["short.csv", "--swept-sine", "shaker", "--channel", "tip"],
            "no level was identified",
        ),
    ] {
        let output = run(&folder, &[&["identify"], arguments, &["--out", "other"]].concat());
        assert_eq!(exit_code(&output), 1, "{arguments:?}");
        assert!(messages(&output).contains(told), "{}", messages(&output));
        assert!(!folder.join("other").exists());
    }
}

#[test]
fn ring_downs_that_cannot_be_identified_leave_no_folder() {
    let folder = folder("identify-refused");
    std::fs::write(folder.join("run.csv"), ring_down(1.0, 0.0)).unwrap();
    std::fs::write(folder.join("both.csv"), ring_down(1.0, 4.0)).unwrap();
    std::fs::write(folder.join("empty.csv"), "").unwrap();
    for (arguments, parts) in [
        (&["run.csv"][..], &["run.csv", "`acc`, `still`"][..]),
        (&["run.csv", "--channel", "b"], &["`b`"]),
        (
            &["run.csv", "--channel", "still"],
            &["channel `still`", "8192 samples are 0 m/s^2"],
        ),
        (&["run.csv", "--channel", "acc", "--unit", "m/s^2"], &["`g`", "`m/s^2`"]),
        (
            &["run.csv", "--channel", "acc", "--sample-rate", "1000"],
            &["4096", "1000 Hz"],
        ),
        (
            &["run.csv", "--channel", "acc", "--smoothing", "4"],
            &["smoothing window is 4 points", "odd"],
        ),
        (&["empty.csv"], &["empty.csv", "no channel"]),
        (&["nowhere.csv"], &["nowhere.csv"]),
        (
            &[
                "both.csv",
                "--channel",
                "acc",
                "--frequency",
                "180",
                "--bandwidth",
                "140",
            ],
            &["both.csv, channel `acc`", "two modes", "179.99 Hz", "230.01 Hz"],
        ),
    ] {
        let output = run(&folder, &[&["identify"], arguments, &["--out", "out"]].concat());
        assert_eq!(exit_code(&output), 1, "{arguments:?}");
        let text = messages(&output);
        assert!(text.starts_with("error: "), "{text}");
        for part in parts {
            assert!(text.contains(part), "`{part}` is not in: {text}");
        }
        assert!(!folder.join("out").exists(), "{arguments:?}");
    }
    let output = run(&folder, &["identify", "run.csv"]);
    assert_eq!(exit_code(&output), 2);
}

const CHARACTERISE: [&str; 12] = [
    "characterise",
    "top.csv",
    "bottom.csv",
    "--benchmark",
    "brake-reuss-beam",
    "--mesh",
    "mesh.json",
    "--mesh-units",
    "mm",
    "--out",
    "out",
    "--height-step=1e-7",
];

#[test]
fn two_scans_are_characterised() {
    let folder = folder("characterise");
    faces(&folder);
    let files = [
        "--units=um",
        "--step=60,100",
        "--first-row=lowest-y",
        "--registration-study",
    ];
    let output = run(&folder, &[&CHARACTERISE[..], &files].concat());
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let out = folder.join("out");
    let report = read_json(&out.join("surface.json"));
    assert_eq!(report["files"][0]["points"], json!([301, 121]));
    assert_eq!(report["files"][1]["height_unit"], json!({ "caller": "um" }));
    assert_eq!(report["options"]["radius"], "inverse-mean-curvature");
    let elements = report["elements"].as_array().unwrap();
    assert_eq!((elements.len(), &report["summary"]["elements"]), (24, &json!(24)));
    let number = |v: &Value, pointer: &str| v.pointer(pointer).unwrap().as_f64().unwrap();
    let mut counted = 0.0;
    for (index, e) in elements.iter().enumerate() {
        assert_eq!(e["element"], index);
        assert!((number(e, "/population/area") / 9e-6 - 1.0).abs() < 1e-9);
        counted += number(e, "/faces/0/points");
        // Sq of the faces as they were made, of a patch of 15 by 10 correlation lengths.
        assert!(
            (number(e, "/faces/0/areal/sq") / 2e-6 - 1.0).abs() < 0.4,
            "{}",
            e["faces"][0]["areal"]
        );
        for field in [
            "/normal/parameters/a",
            "/tangential/1/rms",
            "/faces/1/resolution/height_step",
        ] {
            assert!(number(e, field).is_finite(), "{field}");
        }
        assert_eq!(e["bands"]["realisations"], 30);
        assert_eq!(e["bands"]["normal"][0].as_array().unwrap().len(), 64);
        assert!(e["faces"][0]["peaks"][0].as_u64().unwrap() > 100);
    }
    // All points of the map belong to elements.
    assert_eq!(counted, 301.0 * 121.0);

    // The fields of the VTU are the numbers of the account; pictures are well formed, one polygon per element.
    let vtu = std::fs::read_to_string(out.join("surface.vtu")).unwrap();
    let body = vtu
        .split("Name=\"radius_x [m]\"")
        .nth(1)
        .unwrap()
        .split_once('>')
        .unwrap()
        .1;
    let radii: Vec<f64> = body
        .split('<')
        .next()
        .unwrap()
        .split_whitespace()
        .map(|v| v.parse().unwrap())
        .collect();
    for (e, radius) in elements.iter().zip(&radii) {
        assert_eq!(number(e, "/population/radius/0"), *radius);
    }
    for name in ["gap", "roughness", "count", "radius-x", "radius-y"] {
        let map = std::fs::read_to_string(out.join(format!("map-{name}.svg"))).unwrap();
        assert_eq!(map.matches("<polygon").count(), 24, "{name}");
    }
    for name in ["profile-top.svg", "profile-bottom.svg", "response.svg"] {
        let picture = std::fs::read_to_string(out.join(name)).unwrap();
        assert!(
            picture.trim_end().ends_with("</svg>") && picture.contains("<polyline"),
            "{name}"
        );
    }
    let table = std::fs::read_to_string(out.join("registration.csv")).unwrap();
    assert_eq!(table.lines().count(), 17);
    let study = report["registration_study"].as_array().unwrap();
    assert_eq!(study.len(), 16);
    // A tilt about the middle of the interface changes the gap's shape by its slope times the rms distance of the elements'
    // middles, and what the highest points of the face make of it is a mean.
    let tilted = |tilt: f64| {
        study
            .iter()
            .find(|c| c["registration"]["tilt"][0] == json!(tilt))
            .unwrap()
    };
    let middles: f64 = (0..6).map(|k| (f64::from(k) * 3e-3 - 7.5e-3).powi(2)).sum::<f64>() / 6.0;
    let rms = number(tilted(1e-4), "/rms");
    assert!((rms / (1e-4 * middles.sqrt()) - 1.0).abs() < 0.05, "{rms}");

    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(
        printed.contains("24 elements") && printed.contains("heights in um (as passed)"),
        "{printed}"
    );
}

#[test]
fn scans_that_cannot_be_characterised_leave_nothing_behind() {
    let folder = folder("characterise-refused");
    faces(&folder);
    for (more, expected) in [
        (&[][..], "does not state the unit of its positions"),
        (&["--units=um"], "pass `lateral_step`"),
        (&["--units=m", "--step=60,100"], "lateral extent"),
        (&["--units=um", "--step=30,100"], "element "),
        (&["--units=um", "--step=60,100", "--element=24"], "elements 0 to 23"),
        (&["--units=parsec"], "`parsec` is no unit of length"),
        (&["--units=um", "--step=60,100", "--align=1"], "alignment reach = 1 m"),
        (
            &["--units=um", "--step=60,100", "--align=-1"],
            "interfaces.surface.scans.align = -1 m",
        ),
    ] {
        let output = run(&folder, &[&CHARACTERISE[..], more].concat());
        assert!([1, 2].contains(&exit_code(&output)), "{more:?}");
        let text = messages(&output);
        assert!(text.contains(expected), "`{expected}` is not in: {text}");
        let left = std::fs::read_dir(folder.join("out")).map_or(0, Iterator::count);
        assert_eq!(left, 0, "{more:?}");
    }
    assert_eq!(exit_code(&run(&folder, &["characterise", "--out", "out"])), 2);
    let output = run(&folder, &["characterise", "--scene", QUICK, "--out", "out"]);
    assert!(
        messages(&output).contains("no samples of heights"),
        "{}",
        messages(&output)
    );
}

#[test]
#[ignore = "half a minute; `.ci/run slow` runs it"]
fn slow_an_ensemble_puts_bands_about_the_backbone() {
    let folder = folder("ensemble");
    let mut scene = read_json(Path::new(QUICK));
    scene["name"] = json!("scanned");
    scene["interfaces"]["surface"] = json!({ "synthetic-scan": { "step": [120e-6, 200e-6] } });
    scene["interfaces"]["gap"] = json!("scan");
    scene["analyses"]["backbone"] = json!({ "amplitudes": 3, "amplitude_from": 1e-6, "vertices_per_quarter": 4 });
    std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
    let go = |arguments: &[&str]| {
        let output = run(&folder, &[&["run", "scene.json"], arguments].concat());
        assert_eq!(exit_code(&output), 0, "{}", messages(&output));
        (
            messages(&output),
            read_json(&folder.join("results/scanned/summary.json")),
        )
    };
    let (progress, summary) = go(&["--ensemble", "3"]);
    assert!(progress.contains("ensemble ... "), "{progress}");
    let results = folder.join("results/scanned");
    let ensemble = &summary["ensemble"];
    assert_eq!((&ensemble["realisations"], &ensemble["failed"]), (&json!(3), &json!(0)));
    let bands = ensemble["bands"].as_array().unwrap();
    let table = std::fs::read_to_string(results.join("ensemble.csv")).unwrap();
    assert_eq!((bands.len(), table.lines().count()), (3, 4));
    for (band, line) in bands.iter().zip(table.lines().skip(1)) {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap_or(f64::NAN)).collect();
        assert_eq!(cells[0], band["response_displacement"].as_f64().unwrap());
        for k in 0..3 {
            assert_eq!(cells[2 + k], band["frequency_hz"][k].as_f64().unwrap());
        }
        assert!(cells[2] <= cells[3] && cells[3] <= cells[4]);
    }
    let picture = |name: &str| std::fs::read_to_string(results.join(name)).unwrap();
    assert!(picture("backbone.svg").contains("<polygon") && picture("report.html").contains("<polygon"));
    // Without an ensemble its table would be that of an earlier run.
    let (_, summary) = go(&[]);
    assert!(summary.get("ensemble").is_none() && !results.join("ensemble.csv").exists());
    assert!(!picture("backbone.svg").contains("<polygon"));

    let output = run(
        &folder,
        &["run", "scene.json", "--registration-study=2e-4,1e-5", "--out", "moved"],
    );
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let table = std::fs::read_to_string(folder.join("moved/registration.csv")).unwrap();
    // The scene as it is and eight motions of its bottom face, three amplitudes each.
    assert_eq!(table.lines().count(), 1 + 9 * 3);
    let frequencies: Vec<&str> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(5).unwrap())
        .collect();
    assert!(frequencies.chunks(3).skip(1).all(|moved| moved[0] != frequencies[0]));

    let output = run(&folder, &["run", QUICK, "--ensemble", "3"]);
    assert_eq!(exit_code(&output), 1);
    assert!(
        messages(&output).contains("no samples of heights"),
        "{}",
        messages(&output)
    );
    assert!(!folder.join("results/brb-quick").exists());
}

#[test]
fn the_cache_is_where_it_is_asked_for() {
    if cfg!(target_os = "linux") {
        let kept = std::fs::read_dir(quick().join("caches/microslip")).unwrap().count();
        assert!(kept > 0 && !quick().join("results/.cache").exists());
    }
    let folder = folder("cache");
    let run_with = |more: &[&str]| {
        let output = run(&folder, &[&["run", QUICK, "--out", "here"], more].concat());
        assert_eq!(exit_code(&output), 0, "{}", messages(&output));
        read_json(&folder.join("here/summary.json"))["timings"]["reduce"]
            .as_f64()
            .unwrap()
    };
    assert!(run_with(&["--cache", "mine"]) > 0.0);
    assert!(std::fs::read_dir(folder.join("mine")).unwrap().count() > 0);
    assert_eq!(run_with(&["--cache", "mine"]), 0.0);
    assert_same_numbers(&folder.join("here"), &quick_results());
    assert!(!folder.join("caches").exists());
    let output = run(&folder, &["run", QUICK, "--cache", "mine", "--no-cache"]);
    assert_eq!(exit_code(&output), 2);
}

#[test]
fn shells_are_given_completions() {
    let folder = folder("completions");
    for shell in ["bash", "fish", "zsh", "powershell", "elvish"] {
        let output = run(&folder, &["completions", shell]);
        assert_eq!(exit_code(&output), 0, "{}", messages(&output));
        let script = String::from_utf8(output.stdout).unwrap();
        for word in ["microslip", "characterise", "estimate-error"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    assert_eq!(exit_code(&run(&folder, &["completions", "tcsh"])), 2);
}

#[test]
fn structures_of_many_joints_are_written_with_their_meshes() {
    let folder = folder("joints");
    for (name, option, count, joints) in [
        ("chain-of-laps", "--joints", "2", 2),
        ("flange", "--bolts", "5", 5),
        ("bolted-frame", "", "", 20),
    ] {
        let options = ["new", "--benchmark", name, name, option, count];
        let given = if option.is_empty() { &options[..4] } else { &options };
        let output = run(&folder, given);
        assert_eq!(exit_code(&output), 0, "{}", messages(&output));
        let own = folder.join(name);
        let scene = read_json(&own.join("scene.json"));
        let interfaces = scene["structure"]["mesh"]["interfaces"].as_array().unwrap();
        assert_eq!(interfaces.len(), joints, "{name}");
        assert!(own.join("mesh.msh").is_file() && own.join("README.md").is_file());
    }
    let output = run(
        &folder,
        &["model", "chain-of-laps/scene.json", "--modes", "2", "--out", "model"],
    );
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    // What a structure does not have is refused by name.
    let output = run(&folder, &["new", "--benchmark", "flange", "--joints", "4", "other"]);
    assert_eq!(exit_code(&output), 1);
    assert!(
        messages(&output).contains("--joints is for chain-of-laps"),
        "{}",
        messages(&output)
    );
    assert!(!folder.join("other").exists());
}
