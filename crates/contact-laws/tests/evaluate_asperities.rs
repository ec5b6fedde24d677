//! The example `evaluate_asperities`, from file to file.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]

#[path = "../examples/evaluate_asperities.rs"]
#[allow(dead_code)]
mod example;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

const PARTS: [&str; 3] = ["normal_asperity", "element_cycles", "mindlin_iwan_asperity"];

/// Fields that are computed, as paths below a part.
const COMPUTED: [(&str, &[&str]); 3] = [
    (
        "normal_asperity",
        &["/normal_force", "/contact_radius", "/x_force", "/y_force"],
    ),
    ("element_cycles", &["/txyn"]),
    (
        "mindlin_iwan_asperity",
        &[
            "/constant_normal/x_force",
            "/constant_normal/normal_force",
            "/decreasing_normal/x_force",
            "/decreasing_normal/normal_force",
        ],
    ),
];

/// A file with inputs only.
fn inputs() -> Value {
    json!({
        "normal_asperity": {
            "E": [192e9, 192e9], "nu": [0.3, 0.3], "R": [1.4e-3, 1.4e-3], "Et": [0.62e9, 0.62e9], "Sys": [330e6, null],
            "normal_disp": [[-1e-6, 1e-6, 3e-6, 2e-6], [1e-6, 2e-6]],
            "x_disp": [[0.0, 1e-7, 1e-7, 1e-7], [1e-7, 0.0]],
            "y_disp": [[0.0, 0.0, 2e-7, 2e-7], [0.0, 1e-7]],
        },
        "element_cycles": {
            "E": 192.85e9, "nu": 0.3, "R": 7e-4, "Et": 2.9e9, "Sys": 200e6, "mu": 0.6,
            "gap_values": [0.0, 1e-6], "gap_weights": [1e6, 2e6],
            "uxyn": [[[0.0, 1e-7, 2e-6], [0.0, 0.0, 1e-7], [1e-6, 2e-6, 2e-6]]],
        },
        "mindlin_iwan_asperity": {
            "E": 192.85e9, "nu": 0.29, "R": 4.2e-3, "mu": 0.2, "asp_num_quad_points": 100,
            "constant_normal": { "x_disp": [0.0, 1e-7, 0.0], "normal_disp": [1e-5, 1e-5, 1e-5] },
            "decreasing_normal": { "x_disp": [0.0, 1e-7], "normal_disp": [1e-5, 9e-6] },
        },
    })
}

/// A folder of its own for a test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("asperities_{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// What the example writes for a file.
fn evaluated(folder: &Path, file: &Value) -> Value {
    let (input, output) = (folder.join("in.json"), folder.join("out.json"));
    fs::write(&input, file.to_string()).unwrap();
    example::run(&input, &output).unwrap();
    serde_json::from_str(&fs::read_to_string(&output).unwrap()).unwrap()
}

/// The numbers of a list of any depth.
fn flat(value: &Value, into: &mut Vec<f64>) {
    match value {
        Value::Array(list) => list.iter().for_each(|entry| flat(entry, into)),
        value => into.push(value.as_f64().unwrap()),
    }
}

/// Largest difference of two fields relative to the largest number in the field.
fn difference(found: &Value, expected: &Value) -> f64 {
    let [mut a, mut b] = [const { Vec::new() }; 2];
    flat(found, &mut a);
    flat(expected, &mut b);
    assert_eq!(a.len(), b.len());
    let largest = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let worst = a.iter().zip(&b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(largest > 0.0 && worst.is_finite());
    worst / largest
}

/// The reference file, if it is there.
fn reference() -> Option<Value> {
    let Some(folder) = std::env::var_os("BRB_REFERENCE") else {
        println!("skipped the asperities of the authors' code: BRB_REFERENCE is not set");
        return None;
    };
    // The variable may be relative to the workspace, while tests run in the crate's folder.
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = workspace.join(folder).join("elastic_plastic_asperity.json");
    Some(serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap())
}

/// The file without the computed fields.
fn stripped(file: &Value) -> Value {
    let mut inputs = file.clone();
    for (part, fields) in COMPUTED {
        for field in fields {
            let path = format!("/{part}{field}");
            let (parent, name) = path.rsplit_once('/').unwrap();
            let parent = inputs.pointer_mut(parent).unwrap().as_object_mut().unwrap();
            assert!(parent.remove(name).is_some(), "{path}");
        }
    }
    inputs
}

#[test]
fn asperities_of_the_authors_code() {
    let Some(expected) = reference() else { return };
    let found = evaluated(&folder("reference"), &stripped(&expected));
    for (part, fields) in COMPUTED {
        for field in fields {
            let path = format!("/{part}{field}");
            let error = difference(found.pointer(&path).unwrap(), expected.pointer(&path).unwrap());
            println!("{path}: within {error:.1e} of the largest value");
            assert!(error <= 1e-6, "{path}: {error:e}");
        }
    }
    // Every force of a single asperity by itself.
    for field in ["normal_force", "contact_radius", "x_force", "y_force"] {
        let [mut a, mut b] = [const { Vec::new() }; 2];
        flat(&found["normal_asperity"][field], &mut a);
        flat(&expected["normal_asperity"][field], &mut b);
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() <= 1e-6 * b.abs(), "{field}: {a:e} {b:e}");
        }
    }
}

/// The computed fields are put in, whatever stood there; all else is kept.
#[test]
fn inputs_suffice() {
    let folder = folder("inputs");
    let mut file = inputs();
    file["note"] = json!("kept");
    let found = evaluated(&folder, &file);
    assert_eq!(stripped(&found), file);
    let mut wrong = found.clone();
    for (part, fields) in COMPUTED {
        for field in fields {
            *wrong.pointer_mut(&format!("/{part}{field}")).unwrap() = json!("wrong");
        }
    }
    assert_eq!(evaluated(&folder, &wrong), found);
    assert_eq!(files(&folder), ["in.json", "out.json"]);
    // A constant normal displacement has one normal force, like the displacement's field.
    let iwan = &found["mindlin_iwan_asperity"];
    assert_eq!(iwan["constant_normal"]["normal_force"].as_array().unwrap().len(), 1);
    assert_eq!(iwan["decreasing_normal"]["normal_force"].as_array().unwrap().len(), 2);
    // Nothing before the first touch, and a force that only the yielded asperity lowers.
    let normal = &found["normal_asperity"]["normal_force"];
    assert_eq!(normal[0][0], json!(0.0));
    assert!(normal[0][1].as_f64().unwrap() < normal[1][0].as_f64().unwrap());
}

/// Any parts alone give what they give together.
#[test]
fn any_subset_of_the_parts() {
    let folder = folder("subsets");
    let all = evaluated(&folder, &inputs());
    for chosen in 1..8 {
        let mut file = inputs();
        let parts: Vec<&str> = (0..3).filter(|i| chosen >> i & 1 == 1).map(|i| PARTS[i]).collect();
        file.as_object_mut()
            .unwrap()
            .retain(|name, _| parts.contains(&name.as_str()));
        let found = evaluated(&folder, &file);
        assert_eq!(found.as_object().unwrap().len(), parts.len());
        for part in parts {
            assert_eq!(found[part], all[part]);
        }
    }
    // Either history of the microslip asperity.
    for dropped in ["constant_normal", "decreasing_normal"] {
        let mut file = inputs();
        file["mindlin_iwan_asperity"].as_object_mut().unwrap().remove(dropped);
        let found = evaluated(&folder, &file);
        assert!(found["mindlin_iwan_asperity"].get(dropped).is_none());
    }
}

/// Every refusal names file and place, and leaves what was there before.
#[test]
fn refused_files() {
    let folder = folder("refused");
    let (input, output) = (folder.join("in.json"), folder.join("out.json"));
    fs::write(&output, "before").unwrap();
    let refused = |change: &dyn Fn(&mut Value), expected: &str| {
        let mut value = inputs();
        change(&mut value);
        fs::write(&input, value.to_string()).unwrap();
        let text = example::run(&input, &output).unwrap_err();
        assert!(
            text.contains("in.json: ") && text.contains(expected),
            "{text}\nlacks {expected}"
        );
    };
    let without = |part: &'static str, field: &'static str| {
        move |v: &mut Value| drop(v[part].as_object_mut().unwrap().remove(field).unwrap())
    };
    let lists = "must be a list of numbers";
    for (part, field, expected) in [
        ("normal_asperity", "E", lists),
        ("normal_asperity", "nu", "[0] must be there"),
        ("normal_asperity", "R", "[0] must be there"),
        ("normal_asperity", "Et", "[0] must be there"),
        ("normal_asperity", "normal_disp", lists),
        ("normal_asperity", "x_disp", lists),
        ("normal_asperity", "y_disp", lists),
        ("element_cycles", "E", "must be there"),
        ("element_cycles", "Et", "must be there"),
        ("element_cycles", "mu", "must be a number"),
        ("element_cycles", "gap_values", lists),
        ("element_cycles", "gap_weights", lists),
        ("element_cycles", "uxyn", "must be a list of cases"),
        ("mindlin_iwan_asperity", "R", "must be there"),
        ("mindlin_iwan_asperity", "mu", "must be a number"),
        ("mindlin_iwan_asperity", "asp_num_quad_points", "must be a whole number"),
    ] {
        refused(&without(part, field), &format!("{part}.{field}"));
        refused(&without(part, field), expected);
    }
    for (field, history) in [("x_disp", "constant_normal"), ("normal_disp", "decreasing_normal")] {
        refused(
            &|v| {
                drop(
                    v["mindlin_iwan_asperity"][history]
                        .as_object_mut()
                        .unwrap()
                        .remove(field),
                )
            },
            &format!("mindlin_iwan_asperity.{history}.{field} {lists}"),
        );
    }
    let shorter =
        |path: &'static str| move |v: &mut Value| drop(v.pointer_mut(path).unwrap().as_array_mut().unwrap().pop());
    let unequal = "must be lists of one length, not empty";
    refused(&shorter("/normal_asperity/y_disp/1"), "normal_asperity.normal_disp[1]");
    refused(&shorter("/normal_asperity/x_disp/0"), unequal);
    refused(
        &shorter("/element_cycles/uxyn/0/1"),
        "element_cycles.uxyn[0] must be lists",
    );
    refused(
        &shorter("/element_cycles/uxyn/0"),
        "element_cycles.uxyn[0][2] must be a list",
    );
    refused(&shorter("/element_cycles/gap_weights"), "element_cycles: ");
    refused(
        &shorter("/mindlin_iwan_asperity/constant_normal/x_disp"),
        "mindlin_iwan_asperity.constant_normal",
    );
    refused(
        &|v| v["normal_asperity"]["nu"][1] = json!("steel"),
        "normal_asperity.nu[1] must be a number",
    );
    refused(
        &|v| v["element_cycles"]["E"] = json!([1.0]),
        "element_cycles.E must be a number",
    );
    refused(
        &|v| v["element_cycles"]["uxyn"][0][2][1] = json!("deep"),
        "element_cycles.uxyn[0]",
    );
    refused(
        &|v| v["element_cycles"]["Et"] = json!(1e12),
        "element_cycles: tangent_modulus = 1e12",
    );
    refused(&|v| v["element_cycles"]["mu"] = json!(-0.5), "mu = -5e-1");
    refused(
        &|v| v["normal_asperity"]["Sys"][0] = json!(0.0),
        "normal_asperity: yield_strength = 0e0",
    );
    refused(
        &|v| v["mindlin_iwan_asperity"]["asp_num_quad_points"] = json!(1),
        "mindlin_iwan_asperity: radii = 1e0",
    );
    refused(
        &|v| *v = json!({ "other": 1 }),
        "none of normal_asperity, element_cycles, mindlin_iwan_asperity is there",
    );
    refused(&|v| *v = json!([1, 2]), "none of normal_asperity");
    refused(&|v| v["element_cycles"] = json!(3), "element_cycles.E must be there");

    fs::write(&input, "{\"element_cycles\": [1,").unwrap();
    let text = example::run(&input, &output).unwrap_err();
    assert!(text.contains("in.json: ") && text.contains("line 1"), "{text}");
    let text = example::run(&folder.join("none.json"), &output).unwrap_err();
    assert!(text.contains("none.json: "), "{text}");
    assert_eq!(fs::read_to_string(&output).unwrap(), "before");

    // A file that cannot be written: a folder stands in its place.
    fs::write(&input, inputs().to_string()).unwrap();
    fs::create_dir(folder.join("taken")).unwrap();
    fs::write(folder.join("taken/file"), "").unwrap();
    let text = example::run(&input, &folder.join("taken")).unwrap_err();
    assert!(text.contains("taken: "), "{text}");
    assert_eq!(files(&folder), ["in.json", "out.json", "taken"]);
}
