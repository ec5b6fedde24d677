//! Studies: the same tables whatever runs them and however often it is killed, every case once, and plans that are refused before anything runs.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "tests say what they skip")]

use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const TABLES: [&str; 2] = ["results.csv", "results.parquet"];
const FIXTURES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures");

/// The coarse beam with two amplitudes.
fn scene() -> Value {
    json!({
        "name": "coarse",
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": { "gap": "flat", "law": { "friction": "lumped" }, "points_per_direction": 2 },
        "analyses": {
            "backbone": { "amplitudes": 2, "amplitude_from": 1e-4, "amplitude_to": 4e-4, "vertices_per_quarter": 3 },
        },
    })
}

/// Writes a plan of 3 x 2 x 2 cases, two of each three equal.
fn plan(folder: &Path) {
    // `json!` would sort the parameters.
    let parameters = r#"{
        "/interfaces/mu": { "values": [0.1, 0.3, 0.30000000000000000] },
        "/bolts/load": { "from": "8 kN", "to": "12 kN", "number": 2 },
        "/interfaces/gap": { "values": ["flat", "measured"] }
    }"#;
    let text = format!(r#"{{ "scene": {}, "parameters": {parameters} }}"#, scene());
    fs::write(folder.join("plan.json"), text).unwrap();
}

fn tables(folder: &Path, out: &str) -> Vec<Vec<u8>> {
    let read = |name: &&str| fs::read(folder.join(out).join(name)).unwrap();
    TABLES.iter().map(read).collect()
}

/// The lines of all segments below a folder.
fn lines(cases: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for bucket in fs::read_dir(cases).unwrap() {
        for segment in fs::read_dir(bucket.unwrap().path()).unwrap() {
            let text = fs::read_to_string(segment.unwrap().path()).unwrap();
            found.extend(text.lines().map(str::to_owned));
        }
    }
    found
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_tables_are_the_same_by_one_thread_by_two_and_in_parts_and_no_case_is_run_twice() {
    let folder = folder("study-same");
    plan(&folder);
    succeeds(
        &folder,
        &["study", "plan.json", "--out", "two", "--cache", "a", "--threads", "2"],
    );
    succeeds(
        &folder,
        &["study", "plan.json", "--out", "one", "--no-cache", "--threads", "1"],
    );
    let expected = tables(&folder, "two");
    assert_eq!(expected, tables(&folder, "one"));
    // Eight of the twelve differ.
    assert_eq!(lines(&folder.join("a/cases")).len(), 8);
    assert_eq!(lines(&folder.join("one/cases")).len(), 8);
    for part in ["2/3", "1/3"] {
        let told = succeeds(
            &folder,
            &["study", "plan.json", "--out", "parts", "--cache", "b", "--part", part],
        );
        assert!(told.contains("pending 0"), "{told}");
    }
    assert!(!folder.join("parts").exists());
    let told = succeeds(
        &folder,
        &["study", "plan.json", "--out", "parts", "--cache", "b", "--status"],
    );
    assert!(
        told.contains("12 cases, 8 distinct, structures: 1") && told.contains("done 5") && told.contains("pending 3"),
        "{told}"
    );
    succeeds(&folder, &["study", "plan.json", "--out", "parts", "--cache", "b"]);
    assert_eq!(expected, tables(&folder, "parts"));
    assert_eq!(lines(&folder.join("b/cases")).len(), 8);
    // In full, each in a folder of its own, of which the one that is there is left.
    let one = json!({
        "scene": scene(),
        "cases": [{ "/interfaces/mu": 0.3, "/bolts/load": "12 kN" }, { "/interfaces/mu": 0.5 }],
    });
    fs::write(folder.join("full.json"), one.to_string()).unwrap();
    let command = [
        "study",
        "full.json",
        "--out",
        "full",
        "--cache",
        "b",
        "--workers",
        "2",
        "--folders",
    ];
    succeeds(&folder, &command);
    let text = fs::read_to_string(folder.join("full/results.csv")).unwrap();
    let last: Vec<&str> = text.lines().last().unwrap().split(',').collect();
    let runs = folder.join("full/runs");
    assert_eq!(fs::read_dir(&runs).unwrap().count(), 2);
    let own = runs.join(&last[0][..16]);
    let summary = read_json(&own.join("summary.json"));
    let backbone = summary["backbone"].as_array().unwrap();
    assert_eq!(backbone[1]["frequency_hz"].to_string(), last[6]);
    succeeds(&folder, &["verify", own.to_str().unwrap()]);
    let before = fs::metadata(own.join("manifest.json")).unwrap().modified().unwrap();
    succeeds(&folder, &command);
    assert_eq!(
        fs::metadata(own.join("manifest.json")).unwrap().modified().unwrap(),
        before
    );
    // Another study takes what it shares with this one from the store.
    let other = json!({
        "scene": scene(),
        "cases": [{ "/interfaces/mu": 0.3, "/bolts/load": "12 kN" }, { "/interfaces/mu": 0.5 }],
    });
    fs::write(folder.join("other.json"), other.to_string()).unwrap();
    succeeds(&folder, &["study", "other.json", "--out", "other", "--cache", "a"]);
    assert_eq!(lines(&folder.join("a/cases")).len(), 9);
    let account = read_json(&folder.join("other/study.json"));
    assert_eq!(account["counts"]["converged"], 2);
    assert_eq!(account["times"]["run_now"]["cases"], 1);

    let text = String::from_utf8(expected[0].clone()).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let headings = "case,/interfaces/mu,/bolts/load [kN],/interfaces/gap,mode,modal_amplitude,response_displacement,frequency_hz,\
                    damping_ratio,response_motion,frequency_first_harmonic_hz,damping_ratio_first_harmonic,status,reason";
    assert_eq!(rows[0].join(","), headings);
    assert_eq!(rows.len(), 1 + 12 * 2);
    // In the order of the plan, the last parameter fastest.
    assert_eq!(rows[1][1..5], ["0.1", "8.0", "flat", "1"]);
    assert_eq!(rows[3][1..5], ["0.1", "8.0", "measured", "1"]);
    assert_eq!(rows[23][1..5], ["0.3", "12.0", "measured", "1"]);
    assert_eq!(rows[9][0], rows[17][0]);
    assert!(rows[1..].iter().all(|row| row[0].len() == 64 && row[12] == "converged"));
    for name in [
        "report.html",
        "backbones.svg",
        "effects.svg",
        "parallel.svg",
        "frequency.svg",
        "damping.svg",
        "manifest.json",
    ] {
        assert!(folder.join("two").join(name).is_file(), "{name}");
    }
    // The resolved plan is a plan of the same cases, in its own order.
    succeeds(&folder, &["study", "two/plan.json", "--out", "again", "--cache", "a"]);
    assert_eq!(expected, tables(&folder, "again"));
    same_in_parquet(&folder.join("two"), &rows);
}

/// Nine cases of the coarse beam, of which five teach the others; `hyper_reduction` of the plan is empty for none.
fn learning(folder: &Path, name: &str, hyper_reduction: &str) {
    let parameters =
        r#"{ "/interfaces/mu": { "values": [0.15, 0.2, 0.25] }, "/bolts/load": { "values": [10e3, 12e3, 14e3] } }"#;
    let text = format!(
        r#"{{ "scene": {}, "parameters": {parameters} {hyper_reduction} }}"#,
        scene()
    );
    fs::write(folder.join(name), text).unwrap();
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_cases_that_learn_have_estimated_errors_and_the_same_tables_whoever_runs_them() {
    let folder = folder("study-learning");
    learning(&folder, "whole.json", "");
    learning(
        &folder,
        "few.json",
        r#", "hyper_reduction": { "training": 5, "damping": 0.05 }"#,
    );
    let study = |plan: &str, out: &str, cache: &str, more: &[&str]| {
        let command = ["study", plan, "--out", out, "--cache", cache];
        run(&folder, &[&command, more].concat())
    };
    assert_eq!(exit_code(&study("whole.json", "whole", "a", &[])), 0);
    let told = messages(&study("few.json", "few", "a", &["--threads", "2"]));
    assert!(
        told.contains("mode 1, learned from 5 cases: ") && told.contains(" of 592 points of contact"),
        "{told}"
    );
    // Those that teach were finished by the study before.
    assert_eq!(lines(&folder.join("a/cases")).len(), 9 + 4);
    for part in ["3/3", "1/3", "2/3"] {
        assert_eq!(exit_code(&study("few.json", "parts", "b", &["--part", part])), 0);
    }
    assert_eq!(exit_code(&study("few.json", "parts", "b", &[])), 0);
    assert_eq!(tables(&folder, "few"), tables(&folder, "parts"));
    assert_eq!(lines(&folder.join("b/cases")).len(), 9);

    let table = |out: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(folder.join(out).join("results.csv")).unwrap();
        text.lines()
            .map(|line| line.split(',').map(str::to_owned).collect())
            .collect()
    };
    let (whole, few) = (table("whole"), table("few"));
    let column = |name: &str| few[0].iter().position(|own| own == name).unwrap();
    assert_eq!(few[0][whole[0].len()..], ["frequency_error", "damping_ratio_error"]);
    let (frequency, damping) = (column("frequency_hz"), column("damping_ratio"));
    let mut learned = 0;
    for (few, whole) in few[1..].iter().zip(&whole[1..]) {
        let number = |row: &[String], at: usize| row[at].parse::<f64>().ok();
        let Some(error) = number(few, column("frequency_error")) else {
            // The address of a case that learns is another one, its results may be those of the whole joint.
            assert_eq!(few[1..whole.len()], whole[1..]);
            continue;
        };
        learned += 1;
        assert_ne!(few[0], whole[0]);
        let off = |at: usize| {
            number(few, at)
                .zip(number(whole, at))
                .map(|(few, whole)| (few / whole - 1.0).abs())
        };
        assert!(error <= 5e-4 && off(frequency).unwrap() <= error, "{few:?} {whole:?}");
        if let Some(off) = off(damping) {
            let error = number(few, column("damping_ratio_error")).unwrap();
            assert!(error <= 0.05 && off <= error, "{few:?} {whole:?}");
        }
    }
    assert!((4..=8).contains(&learned), "{learned}");
    let account = read_json(&folder.join("few/study.json"));
    assert_eq!(
        account["hyper_reduction"],
        json!({ "amplitudes": 18, "with_few_coordinates_and_points": learned })
    );

    for (settings, words) in [
        (
            r#"{ "training": 1 }"#,
            &["hyper_reduction.training", "1 cases", "2 or more"][..],
        ),
        (
            r#"{ "training": 5, "damping": 0.001 }"#,
            &["hyper_reduction.damping", "0.001", "0.002"][..],
        ),
        (
            r#"{ "training": 65 }"#,
            &["hyper_reduction.training", "65 cases", "64 or less"],
        ),
        (
            r#"{ "damping": 0 }"#,
            &["hyper_reduction.damping", "0 is no relative error"],
        ),
        (r#"{ "traning": 5 }"#, &["unknown field `traning`", "`training`"]),
    ] {
        learning(&folder, "refused.json", &format!(r#", "hyper_reduction": {settings}"#));
        let message = messages(&study("refused.json", "refused", "c", &[]));
        assert!(
            message.contains("refused.json") && words.iter().all(|word| message.contains(word)),
            "{message}"
        );
    }
    let parameters =
        r#"{ "/interfaces/points_per_direction": { "values": [2, 3] }, "/interfaces/mu": { "values": [0.1, 0.2] } }"#;
    let text = format!(
        r#"{{ "scene": {}, "parameters": {parameters}, "hyper_reduction": {{ "training": 2 }} }}"#,
        scene()
    );
    fs::write(folder.join("refused.json"), text).unwrap();
    let message = messages(&study("refused.json", "refused", "c", &[]));
    assert!(
        message.contains("cases 1 and 3") && message.contains("points per direction"),
        "{message}"
    );
}

#[test]
fn what_cases_learn_does_not_depend_on_the_order_of_a_plan() {
    let folder = folder("study-order");
    let (gap, mu) = (
        r#""/interfaces/gap": { "values": ["flat", "measured"] }"#,
        r#""/interfaces/mu": { "values": [0.15, 0.2, 0.25, 0.3] }"#,
    );
    let rows = |name: &str, parameters: String| -> BTreeMap<String, Vec<String>> {
        let text = format!(
            r#"{{ "scene": {}, "parameters": {{ {parameters} }}, "hyper_reduction": {{ "training": 5, "damping": 0.2 }} }}"#,
            scene()
        );
        fs::write(folder.join(format!("{name}.json")), text).unwrap();
        let plan = format!("{name}.json");
        succeeds(
            &folder,
            &["study", &plan, "--out", name, "--no-cache", "--threads", "1"],
        );
        let text = fs::read_to_string(folder.join(name).join("results.csv")).unwrap();
        let rows = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        // Address and amplitude, and what follows the mode.
        rows.map(|row| (format!("{} {}", row[0], row[4]), row[3..].to_vec()))
            .collect()
    };
    let (one, other) = (
        rows("one", format!("{gap}, {mu}")),
        rows("other", format!("{mu}, {gap}")),
    );
    assert_eq!(one.len(), 16);
    assert!(
        one.values()
            .any(|row| row.iter().rev().take(2).all(|cell| !cell.is_empty())),
        "{one:?}"
    );
    assert_eq!(one, other);
}

/// Asserts that the Parquet file holds the rows of the CSV file.
fn same_in_parquet(results: &Path, rows: &[Vec<&str>]) {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    let file = fs::File::open(results.join("results.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let mut read = 0;
    for (row, expected) in reader.get_row_iter(None).unwrap().zip(&rows[1..]) {
        for ((name, field), (heading, cell)) in row.unwrap().get_column_iter().zip(rows[0].iter().zip(expected)) {
            assert_eq!(name, heading);
            match field {
                Field::Null => assert_eq!(*cell, ""),
                Field::Str(text) => assert_eq!(text, cell),
                Field::Double(number) => assert_eq!(*number, cell.parse::<f64>().unwrap()),
                Field::Int(number) => assert_eq!(*number, cell.parse::<i32>().unwrap()),
                other => panic!("{other:?}"),
            }
        }
        read += 1;
    }
    assert_eq!(read, rows.len() - 1);
    // A reader that is no relative of the writer.
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let is_there = Command::new(&python)
        .args(["-c", "import pyarrow.parquet"])
        .output()
        .is_ok_and(|done| done.status.success());
    if !is_there {
        println!("skipped: {python} has no pyarrow, which reads results.parquet a second time");
        return;
    }
    let compare = r#"
import csv, sys, pyarrow.parquet as pq
table = pq.read_table(sys.argv[1] + "/results.parquet")
with open(sys.argv[1] + "/results.csv", newline="") as file:
    rows = list(csv.reader(file))
assert table.column_names == rows[0], table.column_names
columns = [table.column(k).to_pylist() for k in range(table.num_columns)]
assert all(len(column) == len(rows) - 1 for column in columns)
types = [str(field.type) for field in table.schema]
assert types == ["string", "double", "double", "string", "int32"] + 4 * ["double"] + 2 * ["string"], types
for number, row in enumerate(rows[1:]):
    for column, cell in zip(columns, row):
        value = column[number]
        assert (cell == "") == (value is None), (cell, value)
        if value is not None:
            assert type(value)(cell) == value, (cell, value)
"#;
    let done = Command::new(&python)
        .args(["-c", compare])
        .arg(results)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// A study under way, in a group of its own so that nothing else is killed.
fn start(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(crate::PROGRAM)
        .args(arguments)
        .current_dir(folder)
        .process_group(0)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Numbers that follow from a seed.
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }
}

/// Runs a study that is killed at random moments, each within the time that what is left takes, and then to its end. Gives how often it
/// was killed while it had cases to run.
fn killed_at_random(folder: &Path, plan: &str, kills: usize, whole: Duration) -> usize {
    let arguments = [
        "study",
        plan,
        "--out",
        "killed",
        "--cache",
        "killed-cache",
        "--threads",
        "2",
    ];
    let mut random = Random(7);
    let mut killed = 0;
    for kill in 0..kills {
        // Twice as long as equal shares, so that some come late.
        let wait =
            whole.mul_f64(2.0 * random.next() / (kills as f64 + 1.0)) + Duration::from_millis(100 + 10 * kill as u64);
        let mut child = start(folder, &arguments);
        std::thread::sleep(wait);
        if child.try_wait().unwrap().is_none() {
            killed += 1;
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }
    succeeds(folder, &arguments);
    killed
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_a_study_that_is_killed_goes_on_and_loses_the_cases_under_way_alone() {
    let folder = folder("study-killed");
    plan(&folder);
    let began = Instant::now();
    succeeds(
        &folder,
        &[
            "study",
            "plan.json",
            "--out",
            "whole",
            "--cache",
            "whole-cache",
            "--threads",
            "2",
        ],
    );
    let killed = killed_at_random(&folder, "plan.json", 6, began.elapsed());
    assert!(killed >= 3, "{killed}");
    assert_eq!(tables(&folder, "whole"), tables(&folder, "killed"));
    assert_eq!(lines(&folder.join("killed-cache/cases")).len(), 8);
    // Lines that were torn or damaged count as not done.
    let bucket = fs::read_dir(folder.join("killed-cache/cases"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let segment = fs::read_dir(bucket).unwrap().next().unwrap().unwrap().path();
    let bytes = fs::read(&segment).unwrap();
    fs::write(&segment, &bytes[..bytes.len() - 5]).unwrap();
    let status = [
        "study",
        "plan.json",
        "--out",
        "killed",
        "--cache",
        "killed-cache",
        "--status",
    ];
    assert!(succeeds(&folder, &status).contains("pending 1"));
    succeeds(
        &folder,
        &["study", "plan.json", "--out", "killed", "--cache", "killed-cache"],
    );
    assert_eq!(tables(&folder, "whole"), tables(&folder, "killed"));
}

/// The measurement of docs/guide/studies.md: a thousand cases, killed twenty times.
///
/// `cargo test --release -p microslip --test all study::a_thousand -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes; a measurement"]
fn a_thousand_cases_use_all_processors_and_survive_twenty_kills() {
    let folder = folder("study-thousand");
    let fixture = Path::new(FIXTURES).join("studies/thousand.json");
    let plan = fixture.to_str().unwrap();
    let timed = |threads: &str, out: &str| {
        let began = Instant::now();
        succeeds(
            &folder,
            &["study", plan, "--out", out, "--cache", out, "--threads", threads],
        );
        began.elapsed()
    };
    let two = timed("2", "two");
    let account = read_json(&folder.join("two/study.json"));
    let one = timed("1", "one");
    let expected = tables(&folder, "two");
    assert_eq!(expected, tables(&folder, "one"));
    println!(
        "one thread {:.1} s, two threads {:.1} s: efficiency {:.1} %; cases {:.1} s on one thread each",
        one.as_secs_f64(),
        two.as_secs_f64(),
        50.0 * one.as_secs_f64() / two.as_secs_f64(),
        account["times"]["case_seconds"].as_f64().unwrap()
    );
    let killed = killed_at_random(&folder, plan, 20, two);
    println!("killed {killed} times of 20 while cases were left");
    assert!(killed >= 15, "{killed}");
    assert_eq!(expected, tables(&folder, "killed"));
    for cache in ["two", "one", "killed-cache"] {
        assert_eq!(lines(&folder.join(cache).join("cases")).len(), 1000, "{cache}");
    }
}

#[test]
fn cases_that_fail_are_rows_and_are_run_again_on_request_alone() {
    let folder = folder("study-failed");
    // Two loads for three bolts; a gap that the bolts cannot close.
    let text = json!({ "scene": scene(), "cases": [
        { "/interfaces/mu": 0.2 },
        { "/bolts/loads": ["8 kN", "9 kN"] },
        { "/interfaces/gap": "measured", "/interfaces/scale/gap": 1e7 },
    ] });
    fs::write(folder.join("plan.json"), text.to_string()).unwrap();
    let arguments = ["study", "plan.json", "--out", "out", "--cache", "cache"];
    let done = run(&folder, &arguments);
    assert_eq!(exit_code(&done), 3, "{}", messages(&done));
    let table = String::from_utf8_lossy(&tables(&folder, "out")[0]).into_owned();
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 1 + 2 + 1 + 1, "{table}");
    assert!(rows[3].contains(",failed,") && rows[3].contains("3"), "{}", rows[3]);
    assert!(rows[3].contains("\"[\"\"8 kN\"\",\"\"9 kN\"\"]\""), "{}", rows[3]);
    assert!(
        rows[4].contains(",failed,") && rows[4].contains(",measured,10000000.0,"),
        "{}",
        rows[4]
    );
    assert_eq!(lines(&folder.join("cache/cases")).len(), 3);
    assert_eq!(exit_code(&run(&folder, &arguments)), 3);
    assert_eq!(lines(&folder.join("cache/cases")).len(), 3);
    let again = run(&folder, &[&arguments[..], &["--retry-failed"]].concat());
    assert_eq!(exit_code(&again), 3);
    assert_eq!(lines(&folder.join("cache/cases")).len(), 5);
    assert_eq!(table, fs::read_to_string(folder.join("out/results.csv")).unwrap());
    let told = succeeds(&folder, &[&arguments[..], &["--status"]].concat());
    assert!(
        told.contains("done 3 (converged 1, converged in part 0, failed 2), pending 0"),
        "{told}"
    );
}

#[test]
fn plans_are_refused_before_anything_runs_with_place_value_and_remedy() {
    let folder = folder("study-refused");
    let of = |parameters: Value| json!({ "scene": scene(), "parameters": parameters });
    let values = |pointer: &str, value: Value| of(json!({ pointer: { "values": [value] } }));
    for (plan, words) in [
        (
            values("/mu2", json!(0.1)),
            &["case 1 (/mu2 = 0.1)", "unknown field `mu2`", "expected"][..],
        ),
        (
            values("/bolts/laod", json!("9 kN")),
            &["/bolts/laod = \"9 kN\"", "unknown field `laod`", "`load`"],
        ),
        (
            values("/interfaces/gap/size", json!(1)),
            &[
                "/interfaces/gap/size = 1",
                "/interfaces/gap is \"flat\"",
                "correct the pointer",
            ],
        ),
        (
            values("/interfaces/mu", json!(-0.1)),
            &["/interfaces/mu = -0.1", "not admissible", "must be"],
        ),
        (
            values("/model/material/hardness", json!("2 GPa")),
            &["model.material.hardness", "no result depends on it"],
        ),
        (values("/bolts/load", json!("9 mm")), &["/bolts/load = \"9 mm\"", "mm"]),
        (
            of(json!({ "/interfaces/mu": { "values": [0.1, 0.2, "x"] } })),
            &["case 3 (/interfaces/mu = \"x\")"],
        ),
        (
            of(json!({ "/interfaces/mu": { "values": [0.1], "valeus": [] } })),
            &["valeus", "unknown field"],
        ),
        (
            json!({ "scene": "nowhere.json", "parameters": { "/interfaces/mu": { "values": [1] } } }),
            &["nowhere.json", "no file beside the plan"],
        ),
        (json!({ "scene": 3, "parameters": {} }), &["scene", "in quotes"]),
    ] {
        fs::write(folder.join("plan.json"), plan.to_string()).unwrap();
        let done = run(&folder, &["study", "plan.json", "--out", "out"]);
        let message = messages(&done);
        assert_eq!(exit_code(&done), 1, "{message}");
        assert!(message.contains("plan.json"), "{message}");
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
        assert!(!folder.join("out").exists(), "{plan}");
    }
    fs::write(
        folder.join("plan.json"),
        r#"{ "scene": "brake-reuss-beam/brb-quick", "parameters": { "/interfaces/mu": { "values": [0.1] }, "/interfaces/mu": {} } }"#,
    )
    .unwrap();
    let message = messages(&run(&folder, &["study", "plan.json", "--out", "out"]));
    assert!(message.contains("duplicate field `/interfaces/mu`"), "{message}");
    plan(&folder);
    for (arguments, words) in [
        (&["--part", "4/3"][..], "4/3"),
        (&["--engine", "slurm"], "--workers"),
        (&["--workers", "2", "--threads", "2"], "--threads"),
        (&["--engine", "slurm", "--workers", "2", "--folders"], "--folders"),
        (&["--memory=-1"], "positive"),
    ] {
        let done = run(&folder, &[&["study", "plan.json", "--out", "out"], arguments].concat());
        assert!(
            !done.status.success() && messages(&done).contains(words),
            "{arguments:?}: {}",
            messages(&done)
        );
    }
}

#[test]
fn the_schema_of_plans_accepts_the_plans_that_come_with_the_program() {
    let folder = folder("study-schema");
    let schema: Value = serde_json::from_str(&succeeds(&folder, &["schema", "plan"])).unwrap();
    let (mut schemas, mut compiler) = (boon::Schemas::new(), boon::Compiler::new());
    compiler.add_resource("plan.json", schema).unwrap();
    let index = compiler.compile("plan.json", &mut schemas).unwrap();
    for name in ["quick", "thousand"] {
        let text = fs::read_to_string(Path::new(FIXTURES).join(format!("studies/{name}.json"))).unwrap();
        let plan = scenes::parse_json(&text).unwrap();
        schemas
            .validate(&plan, index)
            .unwrap_or_else(|error| panic!("{name}: {error:#}"));
    }
    assert!(
        schemas
            .validate(&json!({ "scene": "s", "parametres": {} }), index)
            .is_err()
    );
}

/// A Slurm of one node, ended when it is dropped.
struct Slurm(PathBuf);

impl Slurm {
    /// None, and a line that says so, where it cannot be started.
    fn start(folder: &Path) -> Option<Self> {
        let is_there = |program: &str| {
            let found = Command::new("sh")
                .args(["-c", &format!("command -v {program}")])
                .output();
            found.is_ok_and(|found| found.status.success())
        };
        let missing = ["munged", "slurmctld", "slurmd", "sbatch"]
            .into_iter()
            .find(|program| !is_there(program));
        let is_root = Command::new("id")
            .arg("-u")
            .output()
            .is_ok_and(|id| id.stdout == b"0\n");
        if let Some(program) = missing {
            println!("skipped: there is no Slurm here ({program} is missing)");
            return None;
        }
        if !is_root {
            println!("skipped: starting a Slurm for tests needs root");
            return None;
        }
        let slurm = Self(folder.join("slurm-node"));
        let started = Command::new("sh")
            .arg(Path::new(FIXTURES).join("slurm/start.sh"))
            .arg(&slurm.0)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
            .wait()
            .unwrap();
        assert!(started.success(), "see {}", slurm.0.display());
        Some(slurm)
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.0.join("slurm.conf"));
        command
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        let _ = Command::new("sh")
            .arg(Path::new(FIXTURES).join("slurm/stop.sh"))
            .arg(&self.0)
            .status();
    }
}

/// Runs a study by Slurm whose tasks are killed at random moments, `kills` times; gives how often one was running then.
fn killed_by_slurm(slurm: &Slurm, folder: &Path, plan: &str, kills: usize, pause: f64) -> (usize, String) {
    let log = fs::File::create(folder.join("driver.log")).unwrap();
    let mut driver = slurm
        .command(crate::PROGRAM)
        .args([
            "study",
            plan,
            "--out",
            "slurm",
            "--cache",
            "slurm-cache",
            "--engine",
            "slurm",
            "--workers",
            "2",
            "--poll",
            "1",
            "--tries",
            "30",
        ])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(log)
        .spawn()
        .unwrap();
    let (mut random, mut killed) = (Random(3), 0);
    while killed < kills && driver.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_secs_f64(pause * (0.5 + random.next())));
        let listed = slurm
            .command("squeue")
            .args(["--noheader", "--states=RUNNING", "--format=%i"])
            .output()
            .unwrap();
        let tasks: Vec<String> = String::from_utf8_lossy(&listed.stdout)
            .lines()
            .map(str::to_owned)
            .collect();
        if tasks.is_empty() {
            continue;
        }
        let victim = &tasks[(random.next() * tasks.len() as f64) as usize];
        let done = slurm
            .command("scancel")
            .args(["--full", "--signal=KILL", victim])
            .status()
            .unwrap();
        killed += usize::from(done.success());
    }
    let status = driver.wait().unwrap();
    let log = fs::read_to_string(folder.join("driver.log")).unwrap();
    assert!(status.success(), "{log}");
    (killed, log)
}

#[test]
fn slurm_gives_the_same_tables_with_workers_that_are_killed() {
    let folder = folder("study-slurm");
    let Some(slurm) = Slurm::start(&folder) else { return };
    plan(&folder);
    succeeds(
        &folder,
        &["study", "plan.json", "--out", "local", "--cache", "local-cache"],
    );
    let (killed, log) = killed_by_slurm(&slurm, &folder, "plan.json", 3, 0.7);
    assert!(
        killed > 0 && log.contains("again, as they ended before they were done"),
        "{killed}: {log}"
    );
    assert_eq!(tables(&folder, "local"), tables(&folder, "slurm"));
    assert_eq!(lines(&folder.join("slurm-cache/cases")).len(), 8);
}

/// `cargo test --release -p microslip --test all study::a_thousand -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes; a measurement"]
fn a_thousand_cases_by_slurm_with_a_worker_that_dies() {
    let folder = folder("study-thousand-slurm");
    let Some(slurm) = Slurm::start(&folder) else { return };
    let fixture = Path::new(FIXTURES).join("studies/thousand.json");
    let plan = fixture.to_str().unwrap();
    succeeds(&folder, &["study", plan, "--out", "local", "--cache", "local-cache"]);
    let began = Instant::now();
    let (killed, log) = killed_by_slurm(&slurm, &folder, plan, 1, 30.0);
    println!("{killed} worker killed, {:.1} s; {log}", began.elapsed().as_secs_f64());
    assert_eq!(killed, 1);
    assert_eq!(tables(&folder, "local"), tables(&folder, "slurm"));
    assert_eq!(lines(&folder.join("slurm-cache/cases")).len(), 1000);
}

/// A Python that has Dask, if there is one: that of `MICROSLIP_PYTHON`, or `python3`.
fn python_with_dask() -> Option<String> {
    let python = std::env::var("MICROSLIP_PYTHON").unwrap_or_else(|_| "python3".into());
    let asked = Command::new(&python)
        .args(["-c", "import distributed"])
        .stderr(Stdio::null())
        .status();
    asked.is_ok_and(|status| status.success()).then_some(python)
}

/// Numbers of the processes whose command line has all of these words.
fn processes_with(words: &[&str]) -> Vec<u32> {
    let numbers = fs::read_dir("/proc")
        .unwrap()
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    let has = |number: &u32| {
        let line = fs::read(format!("/proc/{number}/cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).replace('\0', " ");
        words.iter().all(|word| line.contains(word))
    };
    numbers.filter(has).collect()
}

#[test]
fn dask_gives_the_same_tables_with_a_part_that_is_killed() {
    let Some(python) = python_with_dask() else {
        println!("skipped: no Dask (python -m pip install dask distributed; MICROSLIP_PYTHON names the Python)");
        return;
    };
    let folder = folder("study-dask");
    plan(&folder);
    succeeds(&folder, &["study", "plan.json", "--out", "local", "--cache", "a"]);
    let out = folder.join("dask");
    let script = Path::new(FIXTURES).join("dask/study.py");
    let mut driver = Command::new(python)
        .arg(script)
        .args(["plan.json", "--cache", "b", "--parts", "3", "--program", crate::PROGRAM])
        .arg("--out")
        .arg(&out)
        .current_dir(&folder)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    // A part that is at work.
    let began = Instant::now();
    let words = [out.to_str().unwrap(), "--threads 1 --part"];
    let killed = loop {
        if let Some(part) = processes_with(&[crate::PROGRAM, words[0], words[1]]).first() {
            break Command::new("kill")
                .args(["-9", &part.to_string()])
                .status()
                .unwrap()
                .success();
        }
        assert!(
            began.elapsed() < Duration::from_secs(120) && driver.try_wait().unwrap().is_none(),
            "no part was run"
        );
        std::thread::sleep(Duration::from_millis(20));
    };
    assert!(driver.wait().unwrap().success());
    println!("a part was killed: {killed}");
    assert_eq!(tables(&folder, "local"), tables(&folder, "dask"));
}
