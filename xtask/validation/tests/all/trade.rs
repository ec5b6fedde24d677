//! `cargo xtask trade` as scripts meet it.
#![allow(clippy::unwrap_used)]

use crate::common::{folder, read_json, run, succeeds};
use serde_json::Value;

#[test]
#[ignore = "half a minute; `.ci/run slow` runs it"]
fn slow_errors_fall_from_rung_to_rung_and_finished_runs_are_kept() {
    let folder = folder("trade");
    let go = || {
        succeeds(
            &folder,
            &["trade", "--quick", "--only", "vertices", "tolerance", "--out", "t"],
        )
    };
    go();
    let trade = read_json(&folder.join("t/trade.json"));
    let rungs: Vec<&Value> = trade["rungs"].as_array().unwrap().iter().collect();
    assert_eq!(rungs.len(), 6 + 5);
    for rung in &rungs {
        assert_eq!(rung["status"], "measured");
        assert_eq!(rung["not_converged"], 0);
        assert!(rung["seconds"].as_f64().unwrap() > 0.0);
    }
    // The largest error of damping falls from rung to rung until the reference, whose own is zero.
    let errors = |dial: &str| -> Vec<f64> {
        let own = rungs.iter().filter(|rung| rung["dial"] == dial);
        own.map(|rung| {
            let at = rung["errors"]["damping_ln"].as_array().unwrap();
            at.iter().map(|e| e.as_f64().unwrap().abs()).fold(0.0, f64::max)
        })
        .collect()
    };
    let vertices = errors("vertices");
    assert!(vertices.windows(2).all(|pair| pair[1] < pair[0]), "{vertices:?}");
    assert_eq!(vertices.last(), Some(&0.0));
    assert!(vertices[0] < 1e-3, "{vertices:?}");
    let tolerance = errors("tolerance");
    assert!(tolerance[0] < 0.1 && tolerance[3] < 1e-6, "{tolerance:?}");
    let parts = &trade["budget"]["parts"];
    assert!(parts["vertices"]["damping_ln"].as_f64().unwrap() < 0.01);
    for file in ["trade.csv", "trade.md", "trade.svg"] {
        assert!(folder.join("t").join(file).exists(), "{file}");
    }
    // Nothing is run again: a run would leave another time.
    go();
    assert_eq!(read_json(&folder.join("t/trade.json")), trade);

    let unknown = run(&folder, &["trade", "--only", "speed"]);
    assert_eq!(unknown.status.code(), Some(1));
    let message = String::from_utf8(unknown.stderr).unwrap();
    assert!(message.contains("`speed`") && message.contains("vertices"), "{message}");
}
