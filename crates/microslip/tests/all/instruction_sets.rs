//! The same scene with each instruction set that the laws are compiled for.
//!
//! The dense algebra asks the processor by itself and has no switch: it is the same in all of these runs.
#![cfg(target_arch = "x86_64")]
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{exit_code, folder, messages, read_json};
use serde_json::json;
use std::path::Path;
use std::process::Command;

const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");

/// Relative differences that are allowed of frequency and of damping; with and without fused operations they were 3.3e-14 and
/// 3.6e-13.
const TOLERANCE: [f64; 2] = [2e-13, 2e-12];

/// A backbone by frequency, and damping where it is resolved.
type Backbone = Vec<(f64, Option<f64>)>;

/// The backbone with no more than an instruction set, and what it was computed with.
fn backbone(folder: &Path, asked: &str) -> (String, Backbone) {
    let out = format!("out-{asked}");
    let output = Command::new(crate::PROGRAM)
        .args(["run", "scene.json", "--no-cache", "--out", &out])
        .current_dir(folder)
        .env("CONTACT_LAWS_INSTRUCTION_SET", asked)
        .output()
        .unwrap();
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let summary = read_json(&folder.join(out).join("summary.json"));
    let points = summary["backbone"].as_array().unwrap().iter();
    let numbers = points.map(|point| (point["frequency_hz"].as_f64().unwrap(), point["damping_ratio"].as_f64()));
    let set = summary["provenance"]["instruction_set"].as_str().unwrap().to_owned();
    (set, numbers.collect())
}

#[test]
fn backbones_agree_whatever_instruction_set_evaluates_the_laws() {
    for kind in ["tabulated", "fitted"] {
        let folder = folder(&format!("instructions-{kind}"));
        let mut scene = read_json(Path::new(QUICK));
        scene["interfaces"]["law"] = json!({ "friction": "lumped", "kind": kind });
        scene["analyses"]["backbone"] = json!({
            "amplitudes": 4, "vertices_per_quarter": 4,
            // Where the search ends would make a difference of 1e-11 by default.
            "tolerance": 1e-12,
        });
        std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
        let (widest, all) = backbone(&folder, "");
        assert_eq!(all.len(), 4);
        for asked in ["avx2", "baseline"] {
            let (set, other) = backbone(&folder, asked);
            match asked {
                "avx2" => assert!(set != "AVX-512"),
                _ => assert_eq!(set, "baseline"),
            }
            // Only fitted curves differ, and only without fused operations.
            if kind == "tabulated" || (set == "AVX2 and FMA") || set == widest {
                assert_eq!(all, other, "{kind}: {widest}, {set}");
            }
            for ((f, zeta), (f_other, zeta_other)) in all.iter().zip(&other) {
                assert!(
                    (f_other / f - 1.0).abs() <= TOLERANCE[0],
                    "{kind}, {set}: {f} Hz, {f_other} Hz"
                );
                let differ = match (zeta, zeta_other) {
                    (Some(a), Some(b)) => (b / a - 1.0).abs() > TOLERANCE[1],
                    (a, b) => a != b,
                };
                assert!(!differ, "{kind}, {set}: {zeta:?}, {zeta_other:?}");
            }
            let resolved = all.iter().filter(|(_, zeta)| zeta.is_some()).count();
            assert!(resolved >= 2, "{kind}");
        }
    }
}
