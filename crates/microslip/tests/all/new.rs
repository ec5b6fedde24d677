//! Structures to start from, and small files to try the commands with: what is written is read, and runs.
#![allow(clippy::unwrap_used)]

use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use microslip::{BENCHMARKS, Scene};
use std::path::Path;
use std::process::Command;

/// The structures, with their masses (kg) and areas in contact (mm^2).
const STRUCTURES: [(&str, f64, f64); 4] = [
    ("half-brake-reuss-beam", 1.8854, 2881.8),
    ("lap-joint", 1.0360, 3072.8),
    ("ring", 5.1048, 8227.8),
    ("s4", 2.7598, 3098.6),
];

/// The commands of a README, without the program's own name.
fn commands(readme: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(readme).unwrap();
    let lines = text.lines().filter_map(|line| line.strip_prefix("$ microslip "));
    lines
        .map(|line| line.split_whitespace().map(|word| word.replace('"', "")).collect())
        .collect()
}

#[test]
fn structures_to_start_from_have_valid_scenes_and_are_not_overwritten() {
    let folder = folder("new-structures");
    for (name, ..) in STRUCTURES {
        let said = succeeds(&folder, &["new", "--benchmark", name, name]);
        for file in ["README.md", "scene.json", "mesh.py", "blocks.py"] {
            assert!(said.contains(file) && folder.join(name).join(file).exists(), "{said}");
        }
        let text = std::fs::read_to_string(folder.join(name).join("scene.json")).unwrap();
        Scene::from_json(&text, "scene.json", name, &BENCHMARKS).unwrap();
        assert!(!commands(&folder.join(name).join("README.md")).is_empty());
        // Without its mesh, the scene names the file that is missing.
        let scene = format!("{name}/scene.json");
        let output = run(&folder, &["model", &scene, "--out", "model"]);
        assert_eq!(exit_code(&output), 1);
        assert!(messages(&output).contains(".msh"), "{}", messages(&output));
    }
    // One file is enough to refuse all.
    std::fs::remove_file(folder.join("ring/scene.json")).unwrap();
    let again = run(&folder, &["new", "--benchmark", "ring", "ring"]);
    assert_eq!(exit_code(&again), 1);
    assert!(messages(&again).contains("is there already"), "{}", messages(&again));
    assert!(!folder.join("ring/scene.json").exists());
    let unknown = run(&folder, &["new", "--benchmark", "lap", "lap"]);
    assert_eq!(exit_code(&unknown), 1);
    let text = messages(&unknown);
    assert!(STRUCTURES.iter().all(|(name, ..)| text.contains(name)), "{text}");
    assert!(!folder.join("lap").exists());
}

/// Meshes by Gmsh, where Python (`PYTHON`, else `python3`) has it.
#[test]
fn mesh_scripts_make_what_their_scenes_describe() {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let has_gmsh = Command::new(&python).args(["-c", "import gmsh"]).output();
    if !has_gmsh.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: {python} has no module gmsh");
        return;
    }
    let folder = folder("new-meshes");
    for (name, mass, area) in STRUCTURES {
        succeeds(&folder, &["new", "--benchmark", name, name]);
        let inside = folder.join(name);
        for (mesh, order) in [("hex", "2"), ("hex-nonmatching", "1"), ("tet", "1")] {
            let made = Command::new(&python)
                .args(["mesh.py", "--mesh", mesh, "--order", order, "--size", "12"])
                .current_dir(&inside)
                .output()
                .unwrap();
            assert!(made.status.success(), "{}", messages(&made));
            succeeds(&inside, &["model", "scene.json", "--out", "model", "--overwrite"]);
            let model = &read_json(&inside.join("model/summary.json"))["model"];
            let near = |field: &str, expected: f64| {
                let found = model[field].as_f64().unwrap();
                // Circles are polygons of coarse elements.
                assert!((found / expected - 1.0).abs() < 2e-2, "{name} {mesh} {field}: {found}");
            };
            near("mass", mass);
            near("interface_area", 1e-6 * area);
        }
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_samples_are_the_same_everywhere_and_their_commands_run() {
    let folder = folder("samples");
    succeeds(&folder, &["samples", "one"]);
    succeeds(&folder, &["samples", "two"]);
    let mut total = 0;
    for entry in std::fs::read_dir(folder.join("one")).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        total += bytes.len();
        let other = folder.join("two").join(path.file_name().unwrap());
        assert!(bytes == std::fs::read(other).unwrap(), "{}", path.display());
    }
    assert!(total < 2_000_000, "{total}");
    let again = run(&folder, &["samples", "one"]);
    assert_eq!(exit_code(&again), 1);
    assert!(messages(&again).contains("is there already"), "{}", messages(&again));
    let samples = folder.join("one");
    let commands = commands(&samples.join("README.md"));
    assert_eq!(commands.len(), 13);
    for command in commands {
        let arguments: Vec<&str> = command.iter().map(String::as_str).collect();
        succeeds(&samples, &arguments);
    }
    // The deck is the mesh.
    let frequencies = |run: &str| {
        let summary = read_json(&samples.join("results").join(run).join("summary.json"));
        let points = summary["backbone"].as_array().unwrap().clone();
        points
            .iter()
            .map(|point| point["frequency_hz"].as_f64().unwrap())
            .collect::<Vec<_>>()
    };
    let (mesh, deck) = (frequencies("mesh"), frequencies("deck"));
    assert_eq!(mesh.len(), 8);
    for (a, b) in mesh.iter().zip(&deck) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
}

/// A shank has an overlap among its unknowns, which rigid motions leave alone.
#[test]
fn structures_with_bolts_on_an_axis_have_mode_shapes() {
    let folder = folder("samples-bolt");
    succeeds(&folder, &["samples", "."]);
    let scene = std::fs::read_to_string(folder.join("joint-mesh.json")).unwrap();
    let forces = r#"{ "head": "HEAD", "nut": "NUT" }"#;
    let shank = r#"{ "axis": [[0, 0, 0.006], [0, 0, -0.006]], "size": "M8", "washers": true }"#;
    assert!(scene.contains(forces));
    std::fs::write(folder.join("bolt.json"), scene.replace(forces, shank)).unwrap();
    succeeds(&folder, &["model", "bolt.json", "--modes", "3", "--out", "model"]);
    assert!(folder.join("model/report.html").exists());
}

/// Bulk data of Nastran of two plates of 40 x 40 x 8 mm with a hole of 9 mm, one upon the other, with 16 solids around it.
fn plates_with_a_hole() -> String {
    use std::fmt::Write;
    const AROUND: usize = 16;
    const OUTWARDS: usize = 3;
    let mut text = String::from("BEGIN BULK\nMAT1,1,210000.,,.3,7.85-9\nPSOLID,1,1\nPSOLID,2,1\n");
    let label = |plate: usize, level: usize, out: usize, turn: usize| {
        1 + ((plate * 2 + level) * (OUTWARDS + 1) + out) * AROUND + turn % AROUND
    };
    let mut element = 0;
    for plate in 0..2 {
        for level in 0..2 {
            for out in 0..=OUTWARDS {
                for turn in 0..AROUND {
                    let angle = 2.0 * std::f64::consts::PI * turn as f64 / AROUND as f64;
                    let (sine, cosine) = angle.sin_cos();
                    let edge = 20.0 / f64::max(sine.abs(), cosine.abs());
                    let radius = 4.5 + (edge - 4.5) * out as f64 / OUTWARDS as f64;
                    let (x, y, z) = (radius * cosine, radius * sine, 8.0 * (plate + level) as f64);
                    writeln!(text, "GRID,{},,{x:.8},{y:.8},{z:.1}", label(plate, level, out, turn)).unwrap();
                }
            }
        }
        for out in 0..OUTWARDS {
            for turn in 0..AROUND {
                let corners = [
                    (0, out, turn),
                    (0, out + 1, turn),
                    (0, out + 1, turn + 1),
                    (0, out, turn + 1),
                ];
                let nodes = corners.iter().map(|&(_, out, turn)| label(plate, 0, out, turn));
                let above = corners.iter().map(|&(_, out, turn)| label(plate, 1, out, turn));
                let nodes: Vec<String> = nodes.chain(above).map(|node| node.to_string()).collect();
                element += 1;
                writeln!(
                    text,
                    "CHEXA,{element},{},{}\n,{}",
                    plate + 1,
                    nodes[..6].join(","),
                    nodes[6..].join(",")
                )
                .unwrap();
            }
        }
    }
    text + "ENDDATA\n"
}

#[test]
fn a_mesh_becomes_a_scene_that_runs_once_what_it_cannot_tell_is_given() {
    let folder = folder("new-from");
    std::fs::write(folder.join("plates.bdf"), plates_with_a_hole()).unwrap();
    let said = succeeds(&folder, &["model", "plates.bdf"]);
    for part in [
        "`PSOLID=1`: 48 Hex8, from (-20, -20, 0) to (20, 20, 8)",
        "`PSOLID=2` on `PSOLID=1`: 48 and 48 faces, area 1538.0",
        "diameter 9, from (0, 0, 16) to (0, 0, 0), through PSOLID=1, PSOLID=2",
        "E 210000., G -, NU .3, RHO 7.85-9",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    succeeds(&folder, &["new", "--from", "plates.bdf", "--length", "mm", "joint"]);
    let scene = folder.join("joint/scene.json");
    let text = std::fs::read_to_string(&scene).unwrap();
    assert!(
        text.contains(r#"{"axis":[[0.0,0.0,16.0],[0.0,0.0,0.0]],"size":"M8"}"#),
        "{text}"
    );
    let asked = run(&folder, &["run", "joint/scene.json", "--out", "out"]);
    assert_eq!(exit_code(&asked), 1);
    assert!(
        messages(&asked).contains("interfaces.mu is missing"),
        "{}",
        messages(&asked)
    );
    std::fs::write(&scene, text.replace("//? ", "")).unwrap();
    succeeds(&folder, &["run", "joint/scene.json", "--out", "out", "--no-cache"]);
    let summary = read_json(&folder.join("out/summary.json"));
    let points = summary["backbone"].as_array().unwrap();
    assert_eq!(points.len(), 8);
    assert!(
        points
            .iter()
            .all(|point| point["frequency_hz"].as_f64().unwrap() > 1000.0)
    );
    let modes = run(&folder, &["model", "plates.bdf", "--modes", "6"]);
    assert!(messages(&modes).contains("--modes, --out"), "{}", messages(&modes));
    let no_scene = run(&folder, &["run", "plates.bdf"]);
    assert!(
        messages(&no_scene).contains("microslip new --from plates.bdf"),
        "{}",
        messages(&no_scene)
    );
    std::fs::rename(folder.join("plates.bdf"), folder.join("plates.dat")).unwrap();
    let unknown = run(&folder, &["model", "plates.dat"]);
    assert!(
        messages(&unknown).contains("call it .bdf if it is bulk data"),
        "{}",
        messages(&unknown)
    );
    std::fs::rename(folder.join("plates.dat"), folder.join("plates.bdf")).unwrap();
    // A second time nothing is overwritten; a unit is asked for, never guessed.
    let again = run(&folder, &["new", "--from", "plates.bdf", "--length", "mm", "joint"]);
    assert!(messages(&again).contains("is there already"), "{}", messages(&again));
    assert_eq!(exit_code(&run(&folder, &["new", "--from", "plates.bdf", "other"])), 2);
}
