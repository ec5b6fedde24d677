//! Commands whose files cannot be written, or that are killed while they write them.
//!
//! `fixtures/fault-injection/faults.c` makes the n-th call that changes files fail. Whatever n, the folder of results holds the
//! old set or the new one, whole, and running the command again completes it.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{copy, folder, read_json, reproducible};
use crate::inputs::{faces, ring_down};
use file_io::durable::{Error, Folder, Identity, MANIFEST, Manifest};
use serde_json::json;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");
/// Two bars of three bricks each.
const DECK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../analyses/tests/fixtures/bricks.inp");
const SHIM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/fault-injection/faults.c");

/// How calls fail, see the shim.
const KINDS: [&str; 4] = ["KILL", "FULL", "EIO", "EACCES"];

/// The compiled shim; none, and a line that says so, without a C compiler.
#[expect(clippy::print_stdout, reason = "tests say what they skip")]
fn shim() -> Option<&'static Path> {
    static SHIM_LIBRARY: OnceLock<Option<PathBuf>> = OnceLock::new();
    let shim = SHIM_LIBRARY.get_or_init(|| {
        let library = folder("faults-shim").join("faults.so");
        let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
        let mut command = Command::new(compiler);
        command.args(["-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-o"]);
        let compiled = command.arg(&library).arg(SHIM).arg("-ldl").output().ok()?;
        assert!(
            compiled.status.success(),
            "{}",
            String::from_utf8_lossy(&compiled.stderr)
        );
        Some(library)
    });
    if shim.is_none() {
        println!("skipped: there is no C compiler for {SHIM}");
    }
    shim.as_deref()
}

/// A command that writes `out`, and keeps what it keeps in `kept`.
struct Subject {
    name: &'static str,
    arguments: &'static [&'static str],
    /// What is added for the results that are there before.
    earlier: &'static [&'static str],
    /// Writes the input files, also those of the results that are there before.
    inputs: fn(&Path, bool),
}

/// Two amplitudes on the coarse mesh of the benchmark, one in the results before.
fn few(folder: &Path, earlier: bool) {
    let mut scene = read_json(Path::new(QUICK));
    scene["name"] = json!("few");
    let amplitudes = if earlier { 1 } else { 2 };
    scene["analyses"]["backbone"] =
        json!({ "amplitudes": amplitudes, "amplitude_from": 1e-6, "vertices_per_quarter": 2 });
    fs::write(folder.join("few.json"), scene.to_string()).unwrap();
}

const RUN: Subject = Subject {
    name: "run",
    arguments: &["run", "few.json", "--out", "out", "--cache", "kept", "--threads", "1"],
    earlier: &[],
    inputs: few,
};

const ENSEMBLE: Subject = Subject {
    name: "ensemble",
    arguments: &[
        "run",
        "scanned.json",
        "--out",
        "out",
        "--cache",
        "kept",
        "--threads",
        "1",
        "--ensemble",
        "2",
    ],
    earlier: &[],
    inputs: |folder, earlier| {
        fs::copy(DECK, folder.join("bricks.inp")).unwrap();
        let scene = json!({
            "name": "scanned",
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "deck": {
                "path": "bricks.inp",
                "top_surface": "TOP",
                "bottom_surface": "BOTTOM",
                "bolts": [{ "top": "HEAD", "bottom": "NUT" }],
                "response": { "node": "TIP", "direction": [0.0, 0.0, 1.0] },
            } },
            "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3 } },
            "interfaces": {
                "mu": 0.2,
                "surface": { "synthetic-scan": { "step": [400e-6, 400e-6], "bootstrap": 4 } },
                "gap": "scan",
            },
            "bolts": { "load": "2 kN" },
            "analyses": { "backbone": {
                "amplitudes": if earlier { 1 } else { 2 },
                "amplitude_from": 1e-9, "amplitude_to": 1e-8, "vertices_per_quarter": 2,
            } },
        });
        fs::write(folder.join("scanned.json"), scene.to_string()).unwrap();
    },
};

const CHARACTERISE: Subject = Subject {
    name: "characterise",
    arguments: &[
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
        "--units=um",
        "--step=60,100",
        "--first-row=lowest-y",
        "--height-step=1e-7",
        "--bootstrap=2",
    ],
    // A file more.
    earlier: &["--registration-study"],
    inputs: |folder, _| faces(folder),
};

const IDENTIFY: Subject = Subject {
    name: "identify",
    arguments: &[
        "identify",
        "a.csv",
        "--channel",
        "acc",
        "--frequency",
        "181",
        "--out",
        "out",
    ],
    earlier: &["--bandwidth", "30"],
    inputs: |folder, _| fs::write(folder.join("a.csv"), ring_down(1.0, 0.2)).unwrap(),
};

/// What is in the way of a command.
struct Fault<'a> {
    shim: &'a Path,
    /// Number of the call, from 1; 0 for none.
    at: usize,
    kind: &'static str,
}

/// Runs the command, with a fault in a call about a file below `folder`; and which call it was, or all calls.
fn execute(folder: &Path, arguments: &[&str], fault: Option<&Fault<'_>>) -> (Output, String) {
    let report = folder.with_extension("calls");
    let mut command = Command::new(crate::PROGRAM);
    command.args(arguments).current_dir(folder);
    command.env("XDG_CACHE_HOME", folder.join("caches"));
    if let Some(fault) = fault {
        let _ = fs::remove_file(&report);
        command
            .env("LD_PRELOAD", fault.shim)
            .env("FAULT_BELOW", format!("{}/", folder.display()))
            .env("FAULT_AT", fault.at.to_string())
            .env("FAULT_KIND", fault.kind)
            .env("FAULT_REPORT", &report);
    }
    let output = command.output().unwrap();
    (output, fs::read_to_string(&report).unwrap_or_default())
}

/// Files below a folder by their names, with what is the same each time they are computed.
type Contents = BTreeMap<String, Vec<u8>>;

fn contents(folder: &Path) -> Contents {
    let mut contents = Contents::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        let bytes = match name.as_str() {
            "summary.json" => reproducible(folder).to_string().into_bytes(),
            // They repeat times, and hashes of what repeats times.
            "report.html" | MANIFEST => Vec::new(),
            _ if entry.file_type().unwrap().is_dir() => Vec::new(),
            _ => fs::read(entry.path()).unwrap(),
        };
        contents.insert(name, bytes);
    }
    contents
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Empty,
    Old,
    New,
    /// Neither, and the folder says so; what opens it next makes it new.
    Interrupted,
}

/// A subject with its results, computed without faults.
struct Trial {
    subject: &'static Subject,
    folder: PathBuf,
    old: Contents,
    new: Contents,
    kept: Vec<String>,
    identity: Identity,
}

impl Trial {
    /// Computes the results into `folder/old` and `folder/new`.
    fn new(subject: &'static Subject, test: &str) -> Self {
        let folder = fs::canonicalize(folder(&format!("faults-{test}-{}", subject.name))).unwrap();
        let compute = |earlier: bool| {
            let at = folder.join(if earlier { "old" } else { "new" });
            fs::create_dir(&at).unwrap();
            (subject.inputs)(&at, earlier);
            let more = if earlier { subject.earlier } else { &[] };
            let (output, _) = execute(&at, &[subject.arguments, more].concat(), None);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            at
        };
        let (old, new) = (compute(true), compute(false));
        let trial = Self {
            subject,
            old: contents(&old.join("out")),
            new: contents(&new.join("out")),
            kept: contents(&new.join("kept")).into_keys().collect(),
            identity: Manifest::read(&new.join("out")).unwrap().identity,
            folder,
        };
        assert!(trial.old != trial.new, "{}", subject.name);
        trial
    }

    /// The folder of a case with its inputs: nothing was computed yet, or the old results and what was kept are there.
    fn case(&self, over_old: bool) -> PathBuf {
        let case = self.folder.join("case");
        let _ = fs::remove_dir_all(&case);
        fs::create_dir(&case).unwrap();
        (self.subject.inputs)(&case, false);
        if over_old {
            copy(&self.folder.join("old/out"), &case.join("out"));
            if !self.kept.is_empty() {
                copy(&self.folder.join("new/kept"), &case.join("kept"));
            }
        }
        case
    }

    fn state(&self, out: &Path) -> State {
        let manifest = match Manifest::read(out) {
            Ok(manifest) => manifest,
            Err(Error::Interrupted { .. }) => {
                let copied = self.folder.join("opened");
                let _ = fs::remove_dir_all(&copied);
                copy(out, &copied);
                drop(Folder::open(&copied, &self.identity, false).unwrap());
                assert_eq!(self.state(&copied), State::New);
                return State::Interrupted;
            }
            Err(Error::NoManifest { .. }) => {
                let left = contents(out).into_keys();
                let visible: Vec<String> = left.filter(|name| !name.starts_with(".microslip-")).collect();
                assert_eq!(visible, Vec::<String>::new());
                return State::Empty;
            }
            Err(error) => panic!("{error}"),
        };
        assert_eq!(manifest.defects(out).unwrap(), []);
        let mut found = contents(out);
        found.retain(|name, _| !name.starts_with(".microslip-"));
        match () {
            () if found == self.new => State::New,
            () if found == self.old => State::Old,
            () => panic!("neither set: {:?}", found.keys()),
        }
    }

    /// Lets one call fail, checks what is there, and runs the command again. Returns which call it was; none, if the command
    /// made fewer.
    fn fail(&self, over_old: bool, fault: &Fault<'_>) -> Option<String> {
        let case = self.case(over_old);
        let (out, kept) = (case.join("out"), case.join("kept"));
        let (output, call) = execute(&case, self.subject.arguments, Some(fault));
        let said = String::from_utf8_lossy(&output.stderr);
        let call = call.trim_end().replace(&format!("{}/", case.display()), "");
        let place = format!(
            "{} over {over_old}, {} in call {}: {call}: {said}",
            self.subject.name, fault.kind, fault.at
        );
        let state = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| self.state(&out)));
        let state = state.unwrap_or_else(|_| panic!("{place}"));
        match output.status.code() {
            // The results are in place, whatever else could not be done.
            Some(0) => assert_eq!(state, State::New, "{place}"),
            Some(1) => {
                assert!(state != State::New && said.contains("rror"), "{state:?} {place}");
                assert!((state != State::Empty) || !over_old, "{place}");
            }
            None if fault.kind == "KILL" => assert_eq!(output.status.signal(), Some(9), "{place}"),
            other => panic!("exit code {other:?} {place}"),
        }
        if call.is_empty() {
            assert!(output.status.success(), "{place}");
            return None;
        }
        // Who lives cleans up, unless that is what failed.
        if fault.kind != "KILL" && !call.starts_with("unlink") && !call.starts_with("rmdir") {
            let names = contents(&out).into_keys().chain(contents(&kept).into_keys());
            let parts: Vec<String> = names.filter(|name| name.ends_with(".part")).collect();
            assert_eq!(parts, Vec::<String>::new(), "{place}");
        }
        let (again, _) = execute(&case, self.subject.arguments, None);
        assert!(
            again.status.success(),
            "{place}, again: {}",
            String::from_utf8_lossy(&again.stderr)
        );
        assert!(contents(&out) == self.new, "{place}");
        assert_eq!(self.state(&out), State::New, "{place}");
        assert_eq!(contents(&kept).into_keys().collect::<Vec<_>>(), self.kept, "{place}");
        Some(call)
    }

    /// Every call in every way.
    #[expect(clippy::print_stdout, reason = "the account of a long run")]
    fn fail_everywhere(&self, shim: &Path) {
        for over_old in [false, true] {
            for kind in KINDS {
                let calls = (1..).map_while(|at| self.fail(over_old, &Fault { shim, at, kind }));
                let count = calls.count();
                println!(
                    "{}, over old results: {over_old}, {kind}: {count} calls",
                    self.subject.name
                );
                assert!(count > 10);
            }
        }
    }

    /// `count` calls, spread over all, each in one way; the first and the last ones are among them. And the first removal of
    /// what was kept for resuming.
    fn fail_at(&self, shim: &Path, over_old: bool, count: usize) {
        let (_, calls) = execute(
            &self.case(over_old),
            self.subject.arguments,
            Some(&Fault {
                shim,
                at: 0,
                kind: "KILL",
            }),
        );
        let removal = calls
            .lines()
            .position(|call| call.starts_with("unlink") && call.contains("/kept/"));
        if let Some(at) = removal.map(|index| index + 1) {
            self.fail(over_old, &Fault { shim, at, kind: "KILL" });
        }
        let calls = calls.lines().count();
        assert!(calls > count, "{calls}");
        for case in 0..count {
            let at = 1 + case * (calls - 1) / (count - 1);
            let kind = KINDS[case % KINDS.len()];
            // What is measured of a run has other digits each time, and may take a call less to write.
            let failed = self.fail(over_old, &Fault { shim, at, kind }).is_some();
            assert!(failed || at == calls, "{at} of {calls}");
        }
    }
}

fn sample(subject: &'static Subject, counts: [usize; 2]) {
    let Some(shim) = shim() else { return };
    let trial = Trial::new(subject, "sample");
    for (over_old, count) in [false, true].into_iter().zip(counts) {
        trial.fail_at(shim, over_old, count);
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_a_run_with_a_failed_call_leaves_old_or_new_results_and_completes_again() {
    sample(&RUN, [5, 10]);
}

#[test]
#[ignore = "half a minute; `.ci/run slow` runs it"]
fn slow_an_ensemble_with_a_failed_call_leaves_old_or_new_results_and_completes_again() {
    sample(&ENSEMBLE, [2, 5]);
}

#[test]
fn a_characterisation_with_a_failed_call_leaves_old_or_new_results_and_completes_again() {
    sample(&CHARACTERISE, [5, 10]);
}

#[test]
fn an_identification_with_a_failed_call_leaves_old_or_new_results_and_completes_again() {
    sample(&IDENTIFY, [10, 20]);
}

#[test]
#[ignore = "an hour: cargo test --release -p microslip --test all faults:: -- --ignored --nocapture"]
fn every_failed_call_leaves_old_or_new_results_and_every_command_completes_again() {
    let Some(shim) = shim() else { return };
    for subject in [&IDENTIFY, &CHARACTERISE, &RUN, &ENSEMBLE] {
        Trial::new(subject, "all").fail_everywhere(shim);
    }
}
