//! The example `evaluate_points`, from file to file.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]

#[path = "../examples/evaluate_points.rs"]
#[allow(dead_code)]
mod example;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

/// A slipping, a sticking and an open point with `t` and `J`.
///
/// Source: evaluations of the contact law of Balaji, Chen and Brake (2020), DOI 10.1016/j.ymssp.2020.106615, by its
/// authors' public code.
fn points() -> Value {
    json!({
        "u": [
            [7.209400411292881e-07, 5.071790018227237e-07, 9.183903405080794e-07],
            [-4.090089014146151e-07, -2.3529973716255013e-06, 1.988763648942867e-06],
            [-1.0688479839287101e-06, -8.249288248994165e-08, -2.5157155143214873e-07],
        ],
        "prev": [
            [-1.8853900590958057e-07, 1.1647201741763737e-07, 2.2780521596224685e-06,
             -91765.82703122035, -196239.3439868191, 764787.957296445],
            [-5.0258151166183183e-08, -3.245426468559766e-08, 2.429880496409366e-06,
             -19865.442179895457, 57361.03394370908, 384180.26159060746],
            [2.5939081639851594e-08, -5.38687433942181e-08, 2.6545767730555568e-06,
             -21377.463323553882, -39493.3763953299, 115844.09408182184],
        ],
        "mu": [0.35906621186652987, 0.5287056034453513, 0.27859117168561165],
        "Zn": [2.5936479527021017e-07, 3.537840239532589e-07, 1.8310788727219874e-07],
        "N": {
            "a": [43.3185989786087, 42.14889999994835, 43.2339480315565],
            "b": [2.199176551653819, 1.9277694449884983, 1.9975456559241571],
            "c": [-0.9178019332310183, 0.6764085192114531, -0.12329481275731458],
            "d": [14.371613167724533, 13.167954586824708, 13.307490154666372],
            "e": [0.8284932734322841, 1.3287262059984257, 1.3517685776352852],
        },
        "Tx": {
            "a": [29.623504830756968, 29.702365082461533, 28.468064446888423],
            "b": [0.591812006662134, 1.2699711027626899, 0.6447070866038465],
            "c": [-13.15823338596239, -13.167784624122332, -13.009376760967243],
            "d": [0.9621918548654054, 1.1755314813903568, 0.9362675099538449],
        },
        "Ty": {
            "a": [28.386295954792615, 28.227152344453003, 29.076867282349887],
            "b": [1.114891084734581, 0.8361241746400292, 1.3542848988342602],
            "c": [-13.365942421046814, -13.148030013110562, -13.763094777592109],
            "d": [0.4247360373974014, 1.1124039359137545, 0.4329780829840886],
        },
        "t": [
            [23969.301365859807, -2421.7539299825207, 67094.40117568761],
            [-1276730.576061706, -2648567.0135510825, 27654470.4686542],
            [0.0, 0.0, 0.0],
        ],
        "J": [
            [233246594.78019083, 194299468.55213776, 87755753054.94922, 2308557386.293713, 1923078335.620252,
             2125702139.5104427, 242566837293.62955],
            [3847348000684.698, 0.0, -3738073252329.2227, 0.0, 1171293258023.7595, -3778254428944.833,
             33610295624169.35],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ],
    })
}

/// A folder of its own for a test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
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

/// Largest errors of `t` (relative to `mu t_n` and `t_n`) and of `J` (relative to its largest entry).
fn errors(expected: &Value, found: &Value) -> [f64; 2] {
    let rows = |value: &Value| -> Vec<Vec<f64>> {
        let row = |row: &Value| row.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        value.as_array().unwrap().iter().map(row).collect()
    };
    let mut worst = [0.0_f64; 2];
    for (i, (t, j)) in rows(&found["t"]).iter().zip(rows(&found["J"])).enumerate() {
        let (known_t, known_j) = (&rows(&expected["t"])[i], &rows(&expected["J"])[i]);
        let mu = expected["mu"][i].as_f64().unwrap();
        assert_eq!((t.len(), j.len()), (3, 7));
        let largest = known_j.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (q, scale) in [(0, mu * known_t[2]), (1, mu * known_t[2]), (2, known_t[2])] {
            if t[q] != known_t[q] {
                worst[0] = worst[0].max((t[q] - known_t[q]).abs() / scale);
            }
        }
        for (found, known) in j.iter().zip(known_j) {
            if found != known {
                worst[1] = worst[1].max((found - known).abs() / largest);
            }
        }
    }
    worst
}

fn check(input: &Path, n: usize) {
    let output = input.with_file_name("out.json");
    example::run(input, &output).unwrap();
    let read = |path: &Path| -> Value { serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap() };
    let (expected, found) = (read(input), read(&output));
    assert_eq!(found.as_object().unwrap().len(), 2);
    for field in ["t", "J"] {
        assert_eq!(found[field].as_array().unwrap().len(), n);
    }
    let [traction, tangent] = errors(&expected, &found);
    println!("{n} points: t within {traction:.1e}, J within {tangent:.1e}");
    assert!(traction <= 1e-12 && tangent <= 1e-12);
}

#[test]
fn known_points() {
    let folder = folder("known_points");
    fs::write(folder.join("in.json"), points().to_string()).unwrap();
    check(&folder.join("in.json"), 3);
    assert_eq!(files(&folder), ["in.json", "out.json"]);
}

#[test]
fn all_points_of_the_authors_code() {
    let Some(reference) = std::env::var_os("BRB_REFERENCE") else {
        println!("skipped the points of the authors' code: BRB_REFERENCE is not set");
        return;
    };
    // The variable may be relative to the workspace, while tests run in the crate's folder.
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let points = workspace.join(reference).join("authors_law_160_points.json");
    let folder = folder("all_points");
    fs::copy(points, folder.join("in.json")).unwrap();
    check(&folder.join("in.json"), 160);
}

/// Every refusal names file, field and point, and leaves what was there before.
#[test]
fn refused_files() {
    let folder = folder("refused_files");
    let (input, output) = (folder.join("in.json"), folder.join("out.json"));
    fs::write(&output, "before").unwrap();
    let refused = |change: &dyn Fn(&mut Value), expected: &str| {
        let mut value = points();
        change(&mut value);
        fs::write(&input, value.to_string()).unwrap();
        let text = example::run(&input, &output).unwrap_err().to_string();
        assert!(
            text.contains("in.json: ") && text.contains(expected),
            "{text}\nlacks {expected}"
        );
    };
    let without = |field: &'static str| move |v: &mut Value| drop(v.as_object_mut().unwrap().remove(field));
    for field in ["u", "prev", "mu", "Zn", "N", "Tx", "Ty"] {
        refused(&without(field), &format!("the field {field} is missing"));
    }
    refused(
        &|v| drop(v["Tx"].as_object_mut().unwrap().remove("d")),
        "the field Tx.d is missing",
    );
    refused(&|v| v["Ty"] = json!(3), "the field Ty.a is missing");
    refused(&|v| *v = json!([1, 2]), "the field u is missing");
    refused(&|v| v["u"] = json!("three"), "u is not a list");
    refused(&|v| v["N"]["e"] = json!(1.0), "N.e is not a list");
    refused(
        &|v| drop(v["mu"].as_array_mut().unwrap().pop()),
        "mu has 2 entries where 3 are needed",
    );
    refused(
        &|v| drop(v["prev"].as_array_mut().unwrap().pop()),
        "prev has 2 entries where 3 are needed",
    );
    refused(
        &|v| v["u"][1] = json!([0.0, 1e-6]),
        "u of point 1 has 2 entries where 3 are needed",
    );
    refused(
        &|v| v["prev"][2] = json!(vec![0.0; 5]),
        "prev of point 2 has 5 entries where 6 are needed",
    );
    refused(&|v| v["u"][1] = json!(1.0), "u of point 1 is not a list");
    refused(
        &|v| v["u"][2][0] = json!("1e-6"),
        "u of point 2, entry 0, is not a number",
    );
    refused(&|v| v["Zn"][1] = Value::Null, "Zn of point 1 is not a number");
    refused(&|v| v["N"]["c"][0] = json!([1.0]), "N.c of point 0 is not a number");
    refused(&|v| v["mu"][2] = json!(-0.1), "mu = -1e-1 (no unit) at point 2");
    refused(&|v| v["N"]["e"][1] = json!(0.0), "N, Tx, Ty of point 1: normal e = 0e0");
    refused(
        &|v| v["N"]["b"][2] = json!(0.01),
        "N, Tx, Ty of point 2: normal traction, eq. (28)",
    );
    let apart = |v: &mut Value| (v["u"][0][2], v["Zn"][0]) = (json!(1e308), json!(-1e308));
    refused(&apart, "minus Zn of point 0 is not finite");

    fs::write(&input, "{\"u\": [1,").unwrap();
    let text = example::run(&input, &output).unwrap_err().to_string();
    assert!(text.contains("in.json: ") && text.contains("line 1"), "{text}");
    let text = example::run(&folder.join("none.json"), &output)
        .unwrap_err()
        .to_string();
    assert!(text.contains("none.json: "), "{text}");
    assert_eq!(fs::read_to_string(&output).unwrap(), "before");

    // A file that cannot be written: a folder stands in its place.
    fs::write(&input, points().to_string()).unwrap();
    fs::create_dir(folder.join("taken")).unwrap();
    fs::write(folder.join("taken/file"), "").unwrap();
    let text = example::run(&input, &folder.join("taken")).unwrap_err().to_string();
    assert!(text.contains("taken: "), "{text}");
    assert_eq!(files(&folder), ["in.json", "out.json", "taken"]);
}

#[test]
fn no_points() {
    let folder = folder("no_points");
    let mut none = json!({ "u": [], "prev": [], "mu": [], "Zn": [] });
    for (field, names) in [("N", "abcde"), ("Tx", "abcd"), ("Ty", "abcd")] {
        none[field] = names.chars().map(|name| (name.to_string(), json!([]))).collect();
    }
    fs::write(folder.join("in.json"), none.to_string()).unwrap();
    check(&folder.join("in.json"), 0);
}
