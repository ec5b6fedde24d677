//! What users see of a model: fields of the interface in its coordinates, mode shapes, what is computed with, and warnings.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use serde_json::{Value, json};
use std::path::Path;

/// Two bricks on one another; the interface is the plane z = 0 with x from 0 to 60 mm and y from 0 to 20 mm.
const DECK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../analyses/tests/fixtures/bricks.inp");

/// A rotation, rows being the images' components, and a shift (m).
#[derive(Clone, Copy)]
pub(crate) struct Place {
    rotation: [[f64; 3]; 3],
    shift: [f64; 3],
}

pub(crate) const AT_HOME: Place = Place {
    rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    shift: [0.0; 3],
};

/// Of a rotation matrix with rational entries.
pub(crate) const ELSEWHERE: Place = Place {
    rotation: [
        [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0],
        [2.0 / 3.0, 2.0 / 3.0, -1.0 / 3.0],
        [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0],
    ],
    shift: [0.013, -0.2, 0.4],
};

impl Place {
    pub(crate) fn turn(&self, x: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| row.iter().zip(x).map(|(r, x)| r * x).sum())
    }

    pub(crate) fn of(&self, x: [f64; 3]) -> [f64; 3] {
        let turned = self.turn(x);
        [0, 1, 2].map(|c| turned[c] + self.shift[c])
    }

    /// The deck with its nodes there.
    fn deck(&self) -> String {
        let lines = std::fs::read_to_string(DECK).unwrap();
        let lines = lines.lines().map(|line| {
            let numbers: Vec<f64> = line.split(',').map_while(|text| text.trim().parse().ok()).collect();
            match numbers[..] {
                [label, x, y, z] if line.matches(',').count() == 3 => {
                    let [x, y, z] = self.of([x, y, z]);
                    format!("{label}, {x:?}, {y:?}, {z:?}")
                }
                _ => line.to_owned(),
            }
        });
        lines.collect::<Vec<_>>().join("\n") + "\n"
    }
}

/// Runs the scene on the deck that is at a place.
fn results(folder: &Path, name: &str, place: Place) {
    results_of(folder, name, place, |_| {});
}

/// Runs the scene with a change on the deck that is at a place; returns what is said on standard error.
pub(crate) fn results_of(folder: &Path, name: &str, place: Place, change: impl Fn(&mut Value)) -> String {
    std::fs::write(folder.join(format!("{name}.inp")), place.deck()).unwrap();
    let elastic = json!({ "normal_stiffness": 1e12, "tangential_stiffness": [8e11, 8e11] });
    let mut scene = json!({
        "name": name,
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "deck": {
            "path": format!("{name}.inp"),
            "top_surface": "TOP",
            "bottom_surface": "BOTTOM",
            "along": place.turn([1.0, 0.0, 0.0]),
            "bolts": [{ "top": "HEAD", "bottom": "NUT" }],
            "response": { "node": "TIP", "direction": place.turn([0.0, 0.0, 1.0]) },
        } },
        "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3 } },
        "interfaces": {
            "surface": { "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": elastic }, "gap": 0.0 }] } },
            "mu": 0.2,
        },
        "bolts": { "load": "2 kN" },
        "analyses": {
            "backbone": { "amplitudes": 2, "amplitude_from": 1e-9, "amplitude_to": 1e-7, "vertices_per_quarter": 2 },
            "epmc": { "loops_at": [1, 5] },
        },
        "output": { "fields_at": [2] },
    });
    change(&mut scene);
    let file = format!("{name}.json");
    std::fs::write(folder.join(&file), scene.to_string()).unwrap();
    let output = run(folder, &["run", &file, "--out", name, "--no-cache"]);
    let said = messages(&output);
    assert_eq!(exit_code(&output), 0, "{said}");
    said
}

/// Leaves the periodic motions out of a scene.
pub(crate) fn without_epmc(scene: &mut Value) {
    scene["analyses"].as_object_mut().unwrap().remove("epmc");
}

/// Numbers of an array of a VTK file, by the components of each point or cell.
fn array(text: &str, name: &str, components: usize) -> Vec<Vec<f64>> {
    let of = text.split(&format!("Name=\"{name}\"")).nth(1);
    let body = of
        .unwrap_or_else(|| panic!("no array {name}"))
        .split_once('>')
        .unwrap()
        .1;
    let numbers = body.split_once('<').unwrap().0.split_whitespace();
    let numbers: Vec<f64> = numbers.map(|v| v.parse().unwrap()).collect();
    numbers.chunks(components).map(<[f64]>::to_vec).collect()
}

fn close(found: &[f64], expected: &[f64], scale: f64) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= 1e-9 * scale, "{found:?} instead of {expected:?}");
    }
}

#[test]
fn fields_of_a_rotated_and_shifted_deck_lie_on_its_mesh() {
    let folder = folder("fields-in-place");
    for (name, place) in [("home", AT_HOME), ("elsewhere", ELSEWHERE)] {
        results(&folder, name, place);
    }
    let read = |of: &str, name: &str| std::fs::read_to_string(folder.join(of).join(name)).unwrap();
    for name in ["interface-prestress.vtu", "interface-amplitude-02.vtu"] {
        let [home, elsewhere] = ["home", "elsewhere"].map(|of| read(of, name));
        // Nodes are those of the deck: labels 1 to 8.
        let nodes = (0..8).map(|i| [0.02 * f64::from(i % 4), 0.02 * f64::from(i / 4), 0.0]);
        for (x, found) in nodes.zip(array(&elsewhere, "Points", 3)) {
            close(&found, &ELSEWHERE.of(x), 1.0);
        }
        let pressures = array(&home, "pressure [Pa]", 1);
        let most = pressures.iter().map(|p| p[0]).fold(0.0, f64::max);
        close(
            &array(&elsewhere, "pressure [Pa]", 1).concat(),
            &pressures.concat(),
            most,
        );
        // The top body lies above: it pushes the bottom one down.
        let tractions = array(&home, "traction [Pa]", 3);
        for ((here, there), pressure) in tractions
            .iter()
            .zip(array(&elsewhere, "traction [Pa]", 3))
            .zip(&pressures)
        {
            close(&here[2..], &[-pressure[0]], most);
            close(&there, &ELSEWHERE.turn([here[0], here[1], here[2]]), most);
        }
        let jumps = array(&home, "tangential_jump [m]", 3);
        let largest = jumps.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (here, there) in jumps.iter().zip(array(&elsewhere, "tangential_jump [m]", 3)) {
            close(&here[2..], &[0.0], largest);
            close(&there, &ELSEWHERE.turn([here[0], here[1], here[2]]), largest);
        }
        // The second direction of the interface is the normal from top to bottom times the first: -y.
        let local = ["local_traction_x [Pa]", "local_traction_y [Pa]"].map(|name| array(&home, name, 1));
        for (cell, traction) in tractions.iter().enumerate() {
            close(&traction[..2], &[local[0][cell][0], -local[1][cell][0]], most);
        }
    }
}

#[test]
fn loops_of_points_say_where_the_points_are() {
    let folder = folder("loops-in-place");
    results(&folder, "elsewhere", ELSEWHERE);
    let table = std::fs::read_to_string(folder.join("elsewhere/loops.csv")).unwrap();
    let headings: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| headings.iter().position(|heading| *heading == name).unwrap();
    let mut rows = 0;
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let at = ["x [m]", "y [m]", "z [m]"].map(|name| cells[column(name)].parse::<f64>().unwrap());
        // Back to where the deck was.
        let shifted = [0, 1, 2].map(|c| at[c] - ELSEWHERE.shift[c]);
        let home = [0, 1, 2].map(|c| (0..3).map(|r| ELSEWHERE.rotation[r][c] * shifted[r]).sum::<f64>());
        let inside = |x: f64, end: f64| x > 1e-3 && x < end - 1e-3;
        assert!(
            inside(home[0], 0.06) && inside(home[1], 0.02) && home[2].abs() < 1e-12,
            "{home:?}"
        );
        rows += 1;
    }
    assert!(rows > 0);
}

/// Cells of a table of numbers by the name of the column; empty ones are not numbers.
fn columns(table: &str) -> std::collections::BTreeMap<String, Vec<f64>> {
    let mut lines = table.lines().map(|line| line.split(','));
    let headings = lines.next().unwrap().map(str::to_owned);
    let rows: Vec<Vec<f64>> = lines
        .map(|cells| cells.map(|cell| cell.parse().unwrap_or(f64::NAN)).collect())
        .collect();
    headings
        .enumerate()
        .map(|(i, name)| (name, rows.iter().map(|row| row[i]).collect()))
        .collect()
}

#[test]
fn loops_of_chosen_elements_are_a_table_and_enclose_their_dissipation() {
    let folder = folder("element-loops");
    let scene = json!({
        "units": { "length": "mm", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        // The mean over an element is then the value at its point.
        "interfaces": { "gap": "flat", "points_per_direction": 1, "law": { "friction": "lumped" } },
        "analyses": { "backbone": {
            "amplitudes": 2, "amplitude_from": 0.05, "amplitude_to": 0.1, "vertices_per_quarter": 4,
            "loops_at": [[57.5, 9, 0], ["-0.05 m", -9, 0]],
        } },
        "output": { "fields_at": [2] },
    });
    std::fs::write(folder.join("beam.json"), scene.to_string()).unwrap();
    succeeds(&folder, &["run", "beam.json", "--out", "beam", "--no-cache"]);
    let read = |name: &str| std::fs::read_to_string(folder.join("beam").join(name)).unwrap();
    let of = columns(&read("element-loops.csv"));
    let point = read_json(&folder.join("beam/summary.json"))["backbone"][1].clone();
    let flux = array(&read("interface-amplitude-02.vtu"), "flux_total [J/m^2]", 1).concat();
    let vertices = 4 * 4 + 1;
    assert_eq!(of["vertex"].len(), 2 * vertices);
    assert!(of["mode"].iter().all(|mode| *mode == 1.0) && of["number"].iter().all(|number| *number == 2.0));
    let amplitude = point["modal_amplitude"].as_f64().unwrap();
    assert!(of["modal_amplitude [sqrt(kg) m]"].iter().all(|q| *q == amplitude));
    for (first, place) in [(0, [0.0575, 0.009, 0.0]), (vertices, [-0.05, -0.009, 0.0])] {
        let rows = first..first + vertices;
        let at = ["x [m]", "y [m]", "z [m]"].map(|name| of[name][first]);
        // Elements are 6 mm long.
        assert!((0..3).all(|c| (at[c] - place[c]).abs() < 4e-3), "{at:?}");
        let numbers: Vec<f64> = (1..=vertices).map(|vertex| vertex as f64).collect();
        assert_eq!(of["vertex"][rows.clone()], numbers);
        let force = &of["modal_force [sqrt(kg) m/s^2]"][rows.clone()];
        let peak = point["modal_force"].as_f64().unwrap();
        close(&[force[0], force[vertices - 1], -force[vertices / 2]], &[peak; 3], peak);
        let mut area = 0.0;
        for (jump, traction) in [
            ("jump_x [m]", "traction_x [Pa]"),
            ("jump_y [m]", "traction_y [Pa]"),
            ("interference [m]", "pressure [Pa]"),
        ] {
            let [u, t] = [jump, traction].map(|name| &of[name][rows.clone()]);
            // Simpson's rule.
            for (every, share) in [(1, 4.0 / 3.0), (2, -1.0 / 3.0)] {
                for a in (0..vertices).step_by(every) {
                    let b = if a + every < vertices { a + every } else { 0 };
                    // The prestress would leave its round-off.
                    area += share * (0.5 * (t[a] + t[b]) - t[0]) * (u[b] - u[a]);
                }
            }
        }
        let expected = flux[of["element"][first] as usize - 1];
        println!("{at:?} m: {area:e} instead of {expected:e} J/m^2");
        assert!(expected > 1e-6 && (area - expected).abs() <= 1e-9 * expected);
    }
}

#[test]
fn loops_of_elements_are_where_the_model_is() {
    let folder = folder("element-loops-in-place");
    results_of(&folder, "elsewhere", ELSEWHERE, |scene| {
        without_epmc(scene);
        // In the last and in the first of three elements, and once more in the last.
        let places = [[0.055, 0.003, 0.0], [0.005, 0.01, 0.0], [0.05, 0.01, 0.0]];
        scene["analyses"]["backbone"]["loops_at"] = json!(places.map(|x| ELSEWHERE.of(x)));
    });
    let of = columns(&std::fs::read_to_string(folder.join("elsewhere/element-loops.csv")).unwrap());
    // Two vertices per quarter, which the scene asks for, do not resolve the damping.
    let vertices = 4 * 8 + 1;
    assert_eq!(of["vertex"].len(), 2 * vertices);
    for (first, centre) in [(0, [0.05, 0.01, 0.0]), (vertices, [0.01, 0.01, 0.0])] {
        let at = ["x [m]", "y [m]", "z [m]"].map(|name| of[name][first]);
        close(&at, &ELSEWHERE.of(centre), 1.0);
    }
    // Without places there is no table.
    results_of(&folder, "home", AT_HOME, without_epmc);
    assert!(!folder.join("home/element-loops.csv").exists());
}

#[test]
fn places_of_loops_beside_the_interface_are_refused() {
    let folder = folder("element-loops-beside");
    for (name, backbone, output, expected) in [
        (
            "far",
            json!({ "loops_at": [["50 mm", 0.01, 0.1]] }),
            json!({}),
            "analyses.backbone.loops_at, number 1: the element nearest to [0.05, 0.01, 0.1] m is number",
        ),
        (
            "flat",
            json!({ "loops_at": [[0.05, 0.01]] }),
            json!({}),
            "give [x, y, z]",
        ),
        (
            "four",
            json!({ "loops_at": [[0.05, 0.01, 0.0, 1.0]] }),
            json!({}),
            "analyses.backbone.loops_at",
        ),
        (
            "idle",
            json!({ "loops_at": [[0.05, 0.01, 0.0]] }),
            json!({ "fields_at": [] }),
            "analyses.backbone.loops_at belongs to amplitudes whose fields are stored",
        ),
    ] {
        std::fs::write(folder.join("bricks.inp"), AT_HOME.deck()).unwrap();
        let elastic = json!({ "normal_stiffness": 1e12, "tangential_stiffness": [8e11, 8e11] });
        let scene = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "deck": {
                "path": "bricks.inp", "top_surface": "TOP", "bottom_surface": "BOTTOM", "along": [1.0, 0.0, 0.0],
                "bolts": [{ "top": "HEAD", "bottom": "NUT" }],
                "response": { "node": "TIP", "direction": [0.0, 0.0, 1.0] },
            } },
            "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3 } },
            "interfaces": {
                "surface": { "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": elastic }, "gap": 0.0 }] } },
                "mu": 0.2,
            },
            "bolts": { "load": "2 kN" },
            "analyses": { "backbone": backbone },
            "output": output,
        });
        std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
        let output = run(&folder, &["run", "scene.json", "--out", name, "--no-cache"]);
        assert_eq!(exit_code(&output), 1, "{name}");
        assert!(messages(&output).contains(expected), "{name}: {}", messages(&output));
    }
}

#[test]
fn maps_have_axes_in_millimetres_and_say_from_where_they_are_seen() {
    let folder = folder("maps-in-place");
    results(&folder, "home", AT_HOME);
    let page = std::fs::read_to_string(folder.join("home/report.html")).unwrap();
    assert!(
        page.contains(
            "seen against the normal n = (0, 0, -1), from the bottom body; to the right is (1, 0, 0), upwards (0, -1, 0)"
        ),
        "no direction of view"
    );
    for text in [">x [mm]<", ">y [mm]<", ">60<", ">20<"] {
        assert!(page.contains(text), "{text}");
    }
}

#[test]
fn modes_about_the_prestress_are_those_of_the_run_and_all_files_are_listed() {
    let folder = folder("mode-shapes");
    results(&folder, "elsewhere", ELSEWHERE);
    let said = succeeds(
        &folder,
        &[
            "model",
            "elsewhere.json",
            "--modes",
            "3",
            "--prestressed",
            "--out",
            "modes",
            "--no-cache",
        ],
    );
    let summary = read_json(&folder.join("modes/summary.json"));
    let contacts = summary["modes"]["contacts"].as_array().unwrap();
    let kinds: Vec<&str> = contacts.iter().map(|of| of["contact"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["unstressed", "stuck", "linear", "prestressed"]);
    let run_summary = read_json(&folder.join("elsewhere/summary.json"));
    let [table, shapes] =
        ["modes.csv", "modes.vtu"].map(|name| std::fs::read_to_string(folder.join("modes").join(name)).unwrap());
    assert_eq!(table.lines().count(), 13);
    for (kind, of) in kinds.iter().zip(contacts) {
        for (i, mode) in of["modes"].as_array().unwrap().iter().enumerate() {
            let array = format!("Name=\"{kind} {:02} [1/sqrt(kg)]\"", i + 1);
            assert!(shapes.contains(&array), "{array}");
            assert!(said.contains(mode["name"].as_str().unwrap()), "{said}");
        }
    }
    // Those of the run are of the reduced model, which lacks the highest modes of this short structure.
    for i in 0..3 {
        let expected = run_summary["modes"][i]["frequency_hz"].as_f64().unwrap();
        let found = contacts[3]["modes"][i]["frequency_hz"].as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 5e-4, "{found} instead of {expected}");
    }
    let page = std::fs::read_to_string(folder.join("modes/report.html")).unwrap();
    // A picture per mode and per pair of kinds.
    assert_eq!(page.matches("<svg").count(), 12 + 6);
}

#[test]
fn halves_have_no_mode_shapes() {
    let folder = folder("half-shapes");
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick", "symmetry": "half" },
        "interfaces": { "gap": "flat" },
    });
    std::fs::write(folder.join("half.json"), scene.to_string()).unwrap();
    let refused = run(&folder, &["model", "half.json", "--modes", "2"]);
    assert_eq!(exit_code(&refused), 1);
    assert!(
        messages(&refused).contains("leave out model.symmetry"),
        "{}",
        messages(&refused)
    );
}

/// Kinds of the warnings of a run; each is on standard error and on the page too.
fn warned(folder: &Path, name: &str, said: &str) -> Vec<String> {
    let page = std::fs::read_to_string(folder.join(name).join("report.html")).unwrap();
    let summary = read_json(&folder.join(name).join("summary.json"));
    let warnings = summary["warnings"].as_array().unwrap();
    assert_eq!(said.matches("warning: ").count(), warnings.len(), "{said}");
    assert_eq!(page.matches("class=\"warning\"").count(), warnings.len());
    let kind = |warning: &Value| {
        let message = warning["message"].as_str().unwrap();
        assert!(said.contains(message), "{message} is not in {said}");
        assert!(warning["value"].is_f64() && warning["limit"].is_f64());
        warning["kind"].as_str().unwrap().to_owned()
    };
    warnings.iter().map(kind).collect()
}

#[test]
fn runs_begin_with_what_they_compute_with() {
    let folder = folder("overview");
    let said = results_of(&folder, "home", AT_HOME, |_| {});
    for line in [
        "structure: 60 x 20 x 20 mm, 0.1872 kg; 32 nodes, 6 elements; read in m, kg, s",
        "expected with a stuck interface: 6 motions without energy",
        "material STEEL: E 200 GPa, nu 0.3, 7800 kg/m^3 (of the deck)",
        "surface: parameters; gap: flat; mu 0.2",
        "bolts: 1 with 2 kN each, 2 kN together",
        "interface: 3 elements, 1200 mm^2, nominal pressure 1.6667 MPa",
    ] {
        assert!(said.contains(line), "{line} is not in {said}");
    }
    assert!(warned(&folder, "home", &said).is_empty());
    let overview = read_json(&folder.join("home/summary.json"))["overview"].clone();
    assert_eq!(overview["bolts"]["total_load"], 2000.0);
    assert_eq!(
        (&overview["rigid_motions"], &overview["n_elements"]),
        (&json!(6), &json!(6))
    );
    let mass = overview["mass"].as_f64().unwrap();
    assert!((mass - 0.1872).abs() < 1e-9, "{mass}");
    // Before the structure is reduced.
    assert!(said.find("structure: 60") < said.find("assemble"), "{said}");
    let modelled = run(&folder, &["model", "home.json", "--out", "model"]);
    assert!(
        messages(&modelled).contains("bolts: 1 with 2 kN each"),
        "{}",
        messages(&modelled)
    );
    assert_eq!(
        read_json(&folder.join("model/summary.json"))["overview"]["bolts"],
        overview["bolts"]
    );
}

#[test]
fn a_deck_in_millimetres_read_as_metres_is_warned_of() {
    let folder = folder("wrong-unit");
    let place = Place {
        rotation: AT_HOME.rotation.map(|row| row.map(|x| 1e3 * x)),
        ..AT_HOME
    };
    let said = results_of(&folder, "millimetres", place, |scene| {
        scene["structure"]["deck"]["along"] = json!([1.0, 0.0, 0.0]);
        scene["structure"]["deck"]["response"]["direction"] = json!([0.0, 0.0, 1.0]);
        // As stiff against the bodies as before.
        let elastic = json!({ "normal_stiffness": 1e9, "tangential_stiffness": [8e8, 8e8] });
        scene["interfaces"]["surface"]["parameters"]["sets"][0]["curves"]["elastic"] = elastic;
        scene["bolts"]["load"] = json!(2e9);
        let backbone = &mut scene["analyses"]["backbone"];
        (backbone["amplitude_from"], backbone["amplitude_to"]) = (json!(1e-6), json!(1e-4));
        without_epmc(scene);
    });
    assert!(
        warned(&folder, "millimetres", &said).contains(&"size".to_owned()),
        "{said}"
    );
    assert!(
        said.contains("60 m long") && said.contains("is the unit right?"),
        "{said}"
    );
}

#[test]
fn pressures_above_the_hardness_are_warned_of() {
    let folder = folder("wrong-load");
    let said = results_of(&folder, "heavy", AT_HOME, |scene| {
        scene["bolts"]["load"] = json!("2 MN");
        scene["model"]["material"]["hardness"] = json!("1.5 GPa");
        without_epmc(scene);
    });
    assert_eq!(warned(&folder, "heavy", &said), ["mean-pressure", "peak-pressure"]);
    assert!(said.contains("is the load right?"), "{said}");
}

#[test]
fn stored_fields_are_one_series_over_the_amplitude() {
    let folder = folder("series");
    results(&folder, "home", AT_HOME);
    let read = |name: &str| std::fs::read_to_string(folder.join("home").join(name)).unwrap();
    let amplitude = read_json(&folder.join("home/summary.json"))["backbone"][1]["response_displacement"].clone();
    let sets: Vec<String> = read("fields.pvd")
        .lines()
        .filter(|line| line.starts_with("<DataSet"))
        .map(str::to_owned)
        .collect();
    assert_eq!(sets.len(), 2);
    for (set, (time, file)) in sets.iter().zip([
        (json!(0.0), "interface-prestress.vtu"),
        (amplitude, "interface-amplitude-02.vtu"),
    ]) {
        assert!(set.contains(&format!("file=\"{file}\"")), "{set}");
        let found = set.split("timestep=\"").nth(1).unwrap().split_once('"').unwrap().0;
        assert_eq!(found.parse::<f64>().unwrap(), time.as_f64().unwrap());
        assert!(folder.join("home").join(file).exists());
    }
}
