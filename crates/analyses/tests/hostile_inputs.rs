//! From damaged files to prepared models: each scene, deck, matrix or scan is refused with a reason or prepared, within bounds
//! of memory and time.
//!
//! The cases run in processes of their own, so that an abort or an endless loop is a finding too. `HOSTILE_CASES` (a number of
//! cases, or a range such as `17..18`) and `HOSTILE_SEED` choose others than the ordinary ones:
//! `HOSTILE_CASES=1000000 HOSTILE_SEED=2 cargo test --release -p analyses --test hostile_inputs -- --ignored --nocapture many`.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

mod common;

use analyses::prepare;
use common::{BENCHMARKS, fixture, lap, material};
use joints::Options;
use joints::progress::Silent;
use scenes::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use surface_characterisation::SyntheticFace;
use test_support::memory::{self, Counting};
use test_support::{Changes, Damage, TemporaryFolder};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Cases that run by default, and their seed.
const ORDINARY: (usize, u64) = (2000, 1);

/// Bytes that preparing a damaged case may take; sound, none takes a hundredth of it.
const MEMORY: usize = 1 << 30;

/// Kilobytes of address space of a process of cases.
const ADDRESSES: usize = 6 << 20;

/// Seconds that a case may take.
const TIME: u64 = 60;

/// Fragments of decks and matrices.
const FRAGMENTS: [&[u8]; 12] = [
    b"*",
    b"**\n",
    b", ",
    b"1, ",
    b"TOP",
    b"S1",
    b"GENERATE",
    b"0.",
    b"1e300",
    b"*EQUATION\n2\n1, 1, 1., 2, 1, -1.\n",
    b"*BOUNDARY\n1, 1, 6\n",
    b"*TIE, NAME=T\nTOP, BOTTOM\n",
];

/// Files of a scene; `scene.json` is among them.
type Files = BTreeMap<&'static str, Vec<u8>>;

/// A small scene with all that it reads.
struct Subject {
    name: &'static str,
    files: Files,
    /// Whether the model is prepared; meshes of a benchmark may be as large as one asks.
    prepared: bool,
}

fn bytes(value: &Value) -> Vec<u8> {
    value.to_string().into_bytes()
}

fn on_deck() -> Value {
    json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "deck": {
            "path": "bricks.inp",
            "top_surface": "TOP",
            "bottom_surface": "BOTTOM",
            "bolts": [{ "top": "HEAD", "bottom": "NUT" }],
            "response": { "node": "TIP", "direction": [0.0, 0.0, 1.0] },
        } },
        "model": { "material": material() },
        "interfaces": {
            "mu": 0.2,
            "surface": { "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": {
                "normal_stiffness": 1e13, "tangential_stiffness": [7e12, 7e12],
            } } }] } },
        },
        "bolts": { "load": "2 kN" },
        "analyses": { "backbone": { "amplitudes": 2 } },
    })
}

/// Heights over the interface of the bricks, as text in um.
fn scan(seed: u64) -> Vec<u8> {
    let face = SyntheticFace {
        points: [151, 51],
        step: [4e-4, 4e-4],
        origin: [0.0, 0.0],
        rms: 2e-6,
        correlation_length: [8e-4, 8e-4],
        waviness: vec![],
        tilt: [0.0, 0.0],
        height_step: Some(0.1e-6),
        seed,
    };
    let map = face.generate(|_| false).unwrap();
    let row = |j| (0..151).map(move |i| (i, j));
    let text = |(i, j)| map.height(i, j).map_or_else(String::new, |z| format!("{:.1}", 1e6 * z));
    let rows = (0..51).map(|j| row(j).map(text).collect::<Vec<_>>().join(","));
    rows.collect::<Vec<_>>().join("\n").into_bytes()
}

fn subjects() -> Vec<Subject> {
    let read = |name: &str| std::fs::read(fixture(name)).unwrap();
    let matrices = lap(Path::new("lap.sti"), 1.0, &json!({}));
    let mut scanned = on_deck();
    let file = |name: &str| json!({ "path": name, "place": "centred", "lateral_step": [400.0, 400.0], "lateral_unit": "um", "height_unit": "um", "first_row": "lowest-y", "height_step": "0.1 um" });
    scanned["interfaces"]["surface"] =
        json!({ "scans": { "top": file("top.csv"), "bottom": file("bottom.csv"), "bootstrap": 0 } });
    scanned["interfaces"]["gap"] = json!("scan");
    let mut subjects = vec![
        Subject {
            name: "deck",
            files: [("scene.json", bytes(&on_deck())), ("bricks.inp", read("bricks.inp"))].into(),
            prepared: true,
        },
        Subject {
            name: "matrices",
            files: [
                ("scene.json", bytes(&matrices)),
                ("lap.sti", read("lap.sti")),
                ("lap.mas", read("lap.mas")),
                ("lap.dof", read("lap.dof")),
            ]
            .into(),
            prepared: true,
        },
        Subject {
            name: "scans",
            files: [
                ("scene.json", bytes(&scanned)),
                ("bricks.inp", read("bricks.inp")),
                ("top.csv", scan(1)),
                ("bottom.csv", scan(2)),
            ]
            .into(),
            prepared: true,
        },
    ];
    for (name, text) in BENCHMARKS.iter().flat_map(|benchmark| benchmark.scenes()) {
        subjects.push(Subject {
            name,
            files: [("scene.json", text.as_bytes().to_vec())].into(),
            prepared: false,
        });
    }
    subjects
}

/// Reads a scene and prepares its model.
fn answer(subject: &Subject, folder: &Path) -> Result<(), String> {
    let scene = Scene::read(&folder.join("scene.json"), &BENCHMARKS).map_err(|error| error.to_string())?;
    if subject.prepared {
        prepare(&scene, &Options::default(), &Silent).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// A case: a subject with one of its files damaged.
fn damaged(subjects: &[Subject], seed: u64, case: usize) -> (&Subject, &'static str, Files) {
    let subject = &subjects[case % subjects.len()];
    let rest = case / subjects.len();
    let names: Vec<&'static str> = subject.files.keys().copied().collect();
    // Scenes, by value and by byte, as often as the other files together.
    let name = if rest.is_multiple_of(2) {
        "scene.json"
    } else {
        names[rest / 2 % names.len()]
    };
    let seed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(case as u64);
    let mut files = subject.files.clone();
    let sound = &files[name];
    let changed = match serde_json::from_slice(sound) {
        Ok(document) if rest.is_multiple_of(4) => bytes(&Changes::new(seed).of(&document)),
        _ => Damage::new(seed, &FRAGMENTS).of(sound),
    };
    files.insert(name, changed);
    (subject, name, files)
}

fn write(files: &Files, folder: &Path) {
    for (name, bytes) in files {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

/// Cases and seed that the environment asks for.
fn asked((cases, seed): (usize, u64)) -> (Range<usize>, u64) {
    let seed = std::env::var("HOSTILE_SEED").map_or(seed, |text| text.parse().unwrap());
    let range = std::env::var("HOSTILE_CASES").map_or(0..cases, |text| match text.split_once("..") {
        Some((from, to)) => from.parse().unwrap()..to.parse().unwrap(),
        None => 0..text.parse().unwrap(),
    });
    (range, seed)
}

/// The process of cases: writes the number of each before it begins, and ends at the first finding.
#[test]
#[ignore = "one of the processes of the tests below"]
fn a_range_of_damaged_inputs_is_refused_or_admissible() {
    static CASE: AtomicUsize = AtomicUsize::new(usize::MAX);
    let Some(progress) = std::env::var_os("HOSTILE_PROGRESS") else {
        return;
    };
    let (range, seed) = asked(ORDINARY);
    std::thread::spawn(|| {
        loop {
            let case = CASE.load(Ordering::Relaxed);
            std::thread::sleep(Duration::from_secs(TIME));
            if case != usize::MAX && case == CASE.load(Ordering::Relaxed) {
                println!("more than {TIME} s");
                std::process::exit(3);
            }
        }
    });
    let folder = TemporaryFolder::new("hostile-cases");
    let subjects = subjects();
    for subject in &subjects {
        write(&subject.files, &folder);
        answer(subject, &folder).unwrap_or_else(|error| panic!("{}: {error}", subject.name));
    }
    let mut accepted = 0;
    for case in range {
        CASE.store(case, Ordering::Relaxed);
        std::fs::write(&progress, format!("{case} {accepted}")).unwrap();
        let (subject, _, files) = damaged(&subjects, seed, case);
        write(&files, &folder);
        let (answered, used) = memory::peak(|| catch_unwind(AssertUnwindSafe(|| answer(subject, &folder))));
        match answered {
            Err(_) => std::process::exit(4),
            Ok(Ok(())) => accepted += 1,
            Ok(Err(message)) => assert!(!message.is_empty()),
        }
        if used > MEMORY {
            println!("{used} bytes in use");
            std::process::exit(5);
        }
    }
    std::fs::write(&progress, format!("done {accepted}")).unwrap();
}

/// Runs cases in processes, each up to the next finding; the findings, and how many cases were accepted.
fn trial(range: Range<usize>, seed: u64, name: &str) -> (Vec<String>, usize) {
    let progress = std::env::temp_dir().join(format!("hostile-progress-{name}-{}", std::process::id()));
    let program: PathBuf = std::env::current_exe().unwrap();
    let (mut findings, mut accepted, mut from) = (Vec::new(), 0, range.start);
    while from < range.end {
        let mut command = Command::new("sh");
        command
            .args(["-c", &format!("ulimit -v {ADDRESSES}; exec \"$0\" \"$@\"")])
            .arg(&program);
        command
            .args([
                "a_range_of_damaged_inputs_is_refused_or_admissible",
                "--exact",
                "--ignored",
                "--nocapture",
            ])
            .env("HOSTILE_PROGRESS", &progress)
            .env("HOSTILE_CASES", format!("{from}..{}", range.end))
            .env("HOSTILE_SEED", seed.to_string())
            .env("RAYON_NUM_THREADS", "1");
        let output = command.output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        let reached = std::fs::read_to_string(&progress).unwrap_or_else(|_| panic!("no case began: {said}"));
        let (case, count) = reached.split_once(' ').unwrap();
        accepted += count.parse::<usize>().unwrap();
        if case == "done" && output.status.success() {
            break;
        }
        let case: usize = case.parse().unwrap_or_else(|_| panic!("{said}"));
        let subjects = subjects();
        let (subject, file, _) = damaged(&subjects, seed, case);
        let finding = format!(
            "HOSTILE_SEED={seed} HOSTILE_CASES={case}..{}: {} of the scene on {}: {}\n{said}",
            case + 1,
            file,
            subject.name,
            output.status
        );
        println!("{finding}");
        findings.push(finding);
        from = case + 1;
    }
    let _ = std::fs::remove_file(progress);
    (findings, accepted)
}

#[test]
fn damaged_inputs_are_refused_or_prepared_within_bounds() {
    let (cases, seed) = ORDINARY;
    let (findings, accepted) = trial(0..cases, seed, "ordinary");
    assert!(
        findings.is_empty(),
        "{} findings, the first: {}",
        findings.len(),
        findings[0]
    );
    // Some damage is none, and some cannot be seen.
    assert!(
        accepted > cases / 50 && accepted < cases / 2,
        "{accepted} of {cases} were accepted"
    );
}

#[test]
#[ignore = "as long as HOSTILE_CASES asks for"]
fn many_damaged_inputs_are_refused_or_prepared_within_bounds() {
    let (range, seed) = asked((50_000, 2));
    let cases = range.len();
    let (findings, accepted) = trial(range, seed, "long");
    println!("{cases} cases, {accepted} accepted, {} findings", findings.len());
    assert!(findings.is_empty(), "{} findings", findings.len());
}
