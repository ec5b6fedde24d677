//! Work without end, runs that do not fit into the memory, and Ctrl-C.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use serde_json::json;
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const SIGINT: i32 = 2;

fn scene(folder: &Path, refinement: &str) {
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": refinement },
        "interfaces": { "gap": "flat", "mu": 0.2 },
        "analyses": { "backbone": { "amplitudes": 2, "vertices_per_quarter": 2 } },
    });
    fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
}

#[test]
fn work_without_end_is_refused_at_once() {
    let folder = folder("limits-work");
    scene(&folder, "quick");
    succeeds(&folder, &["samples", "samples"]);
    let hits = ["identify", "samples/hit1.csv", "samples/hit2.csv"];
    let identify = [&hits[..], &["--points", "1000000000", "--out", "identified"]].concat();
    let memory = ["run", "scene.json", "--no-cache", "--memory", "10MB"];
    let mut endless = read_json(&folder.join("scene.json"));
    endless["analyses"]["ring_down"] = json!({ "release": 1e-3, "periods": 1_000_000_000_000_u64 });
    std::fs::write(folder.join("endless.json"), endless.to_string()).unwrap();
    for (arguments, words) in [
        (&["run", "endless.json"][..], ["periods", "1e7 steps"]),
        (&identify, ["1000000000 points", "1000000"]),
        (&memory, ["--memory", "MB"]),
    ] {
        let began = Instant::now();
        let done = run(&folder, arguments);
        let text = messages(&done);
        assert_eq!(exit_code(&done), 1, "{text}");
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
        assert!(began.elapsed() < Duration::from_secs(20), "{text}");
    }
}

/// Ends a run by Ctrl-C once a line with `word` has been shown; how long it then took.
fn interrupt_after(folder: &Path, word: &str) -> Duration {
    // Children of a process in the background ignore the signal otherwise.
    let mut child = Command::new("env")
        .args([
            "--default-signal=INT",
            crate::PROGRAM,
            "run",
            "scene.json",
            "--no-cache",
            "--out",
            "results",
        ])
        .current_dir(folder)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().contains(word)), "{word}");
    std::thread::sleep(Duration::from_millis(100));
    let began = Instant::now();
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success(), "the run was still going on");
    let ended = child.wait().unwrap();
    assert_eq!(ended.signal(), Some(SIGINT), "{word}: {ended}");
    began.elapsed()
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_ctrl_c_ends_a_run_at_once_whatever_it_is_at_and_leaves_no_half_of_results() {
    let folder = folder("limits-interrupted");
    scene(&folder, "default");
    // While the stage after it goes on.
    for word in ["mesh ...", "assemble ...", "factor ...", "reduce ..."] {
        let took = interrupt_after(&folder, word);
        assert!(took < Duration::from_secs(2), "{word}: {took:?}");
        // But for the mark of who holds the folder.
        let names = fs::read_dir(folder.join("results")).into_iter().flatten();
        let names = names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
        let left: Vec<String> = names.filter(|name| !name.starts_with('.')).collect();
        assert!(left.is_empty(), "{word}: {left:?}");
    }
}
