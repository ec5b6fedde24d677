//! The page of a run: its data are those of the other files, and nothing in it breaks out.
#![allow(clippy::unwrap_used)]
use crate::common;

use crate::common::page::{DATA, SCRIPT, data_of, scripts_of};
use crate::common::{folder, read_json, succeeds};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");

/// Markup that a name must not become.
const HOSTILE: &str = "</script><script>alert(1)</script><!-- <img src=x onerror=alert(1)> & \"quoted\"";

/// The quick scene under a hostile name; the folder of its results.
fn results() -> &'static Path {
    static RUN: OnceLock<PathBuf> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = folder("report");
        let mut scene = read_json(Path::new(QUICK));
        scene["name"] = json!(HOSTILE);
        std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
        succeeds(&folder, &["run", "scene.json", "--out", "results", "--no-cache"]);
        folder.join("results")
    })
}

fn page() -> String {
    std::fs::read_to_string(results().join("report.html")).unwrap()
}

fn data() -> Value {
    serde_json::from_str(data_of(&page())).unwrap()
}

fn bytes(value: &Value) -> Vec<u8> {
    STANDARD.decode(value.as_str().unwrap()).unwrap()
}

fn singles(value: &Value) -> Vec<f32> {
    let bytes = bytes(value);
    bytes
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
        .collect()
}

fn integers(value: &Value) -> Vec<u32> {
    let bytes = bytes(value);
    bytes
        .chunks_exact(4)
        .map(|b| u32::from_le_bytes(b.try_into().unwrap()))
        .collect()
}

/// A field of a file for ParaView.
fn field(file: &str, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(results().join(file)).unwrap();
    let (_, array) = text.split_once(&format!("Name=\"{name}\"")).unwrap();
    let numbers = array.split_once('>').unwrap().1.split_once('<').unwrap().0;
    numbers.split_whitespace().map(|v| v.parse().unwrap()).collect()
}

#[test]
fn a_name_stays_text() {
    let page = page();
    let (markup, scripts) = scripts_of(&page);
    assert!(!markup.contains("<img") && !markup.contains("<!-- "));
    assert_eq!(markup.matches("<script").count(), scripts.len());
    let tags: Vec<&str> = scripts.iter().map(|(tag, _)| *tag).collect();
    assert_eq!(tags, [DATA, SCRIPT, SCRIPT, SCRIPT]);
    assert_eq!(data()["name"], HOSTILE);
    let text = data_of(&page).to_owned();
    assert!(!text.contains(['<', '>', '&']), "markup in the data");
}

#[test]
fn the_policy_admits_the_scripts_of_the_page_and_no_others() {
    let page = page();
    let (markup, scripts) = scripts_of(&page);
    let (_, policy) = markup.split_once("Content-Security-Policy\" content=\"").unwrap();
    let policy = policy.split_once('"').unwrap().0;
    let admitted = policy.split_once("script-src").unwrap().1;
    let hashes: Vec<&str> = admitted.split_whitespace().collect();
    let expected: Vec<String> = scripts
        .iter()
        .filter(|(tag, _)| *tag == SCRIPT)
        .map(|(_, script)| format!("'sha256-{}'", STANDARD.encode(Sha256::digest(script))))
        .collect();
    assert_eq!(hashes, expected);
    assert!(
        policy.starts_with("default-src 'none'; ") && !policy.contains("//"),
        "{policy}"
    );
}

#[test]
fn fields_are_those_of_the_files() {
    let data = data();
    let elements = read_json(&results().join("summary.json"))["model"]["n_interface_elements"]
        .as_u64()
        .unwrap() as usize;
    let interface = &data["interface"];
    let corners = integers(&interface["corners"]);
    let nodes = integers(&interface["nodes"]);
    let known = singles(&interface["plane"]).len() / 2;
    assert_eq!(corners.len(), elements);
    assert_eq!(nodes.len(), corners.iter().sum::<u32>() as usize);
    assert!(nodes.iter().all(|&node| (node as usize) < known));
    assert_eq!(singles(&interface["positions"]).len(), 3 * known);
    assert_eq!(singles(&interface["frames"]).len(), 9);
    let stops = data["modes"][0]["stops"].as_array().unwrap();
    let numbers: Vec<&Value> = stops.iter().map(|stop| &stop["number"]).collect();
    assert_eq!(numbers, [1, 4, 6, 8]);
    let files = [
        ("interface-prestress.vtu", &interface["prestress"]),
        ("interface-amplitude-08.vtu", &stops[3]["fields"]),
    ];
    for (file, fields) in files {
        for (key, name) in [
            ("pressure", "pressure [Pa]"),
            ("traction_x", "local_traction_x [Pa]"),
            ("traction_y", "local_traction_y [Pa]"),
            ("interference", "interference [m]"),
            ("flux", "flux_total [J/m^2]"),
            ("slip", "slip_area_fraction [-]"),
            ("open", "open_area_fraction [-]"),
        ] {
            let expected: Vec<f32> = field(file, name).into_iter().map(|v| v as f32).collect();
            assert_eq!(expected.len(), elements);
            assert_eq!(singles(&fields[key]), expected, "{file}: {key}");
        }
    }
    assert!(singles(&interface["prestress"]["motion_x"]).iter().all(|v| *v == 0.0));
    let moved = singles(&stops[3]["fields"]["motion_x"]);
    let [after, before] =
        ["interface-amplitude-08.vtu", "interface-prestress.vtu"].map(|file| field(file, "local_jump_x [m]"));
    for ((moved, after), before) in moved.iter().zip(after).zip(before) {
        let expected = after - before;
        assert!(
            (f64::from(*moved) - expected).abs() <= 1e-6 * expected.abs() + 1e-17,
            "{moved} instead of {expected}"
        );
    }
}

#[test]
fn loops_hold_what_the_elements_dissipate() {
    let data = data();
    let stop = &data["modes"][0]["stops"][3];
    let (loops, flux) = (&stop["loops"], singles(&stop["fields"]["flux"]));
    let vertices = loops["vertices"].as_u64().unwrap() as usize;
    assert_eq!(vertices, 4 * 4 + 1);
    assert!(loops["elements"].is_null(), "all elements");
    let ranges = singles(&loops["ranges"]);
    assert_eq!(ranges.len(), 2 * 6 * flux.len());
    let compressed = bytes(&loops["sequences"]);
    let mut plain = Vec::new();
    flate2::read::DeflateDecoder::new(&compressed[..])
        .read_to_end(&mut plain)
        .unwrap();
    let all = 6 * vertices * flux.len();
    assert_eq!(plain.len(), 2 * all);
    let sequence = |number: usize| -> Vec<f64> {
        let [low, high] = [ranges[2 * number], ranges[2 * number + 1]].map(f64::from);
        let mut step = 0_i32;
        let value = |k: usize| {
            let at = number * vertices + k;
            let coded = u16::from_le_bytes([plain[at], plain[all + at]]);
            step += i32::from(coded >> 1) ^ -i32::from(coded & 1);
            low + f64::from(step) * (high - low) / 4095.0
        };
        (0..vertices).map(value).collect()
    };
    // Work of the mean traction on the mean motion of an element; its points may move against each other.
    let work = |element: usize| -> f64 {
        let [motion, traction] = [0, 3].map(|first| [0, 1, 2].map(|c| sequence(6 * element + first + c)));
        let parts = motion.iter().zip(&traction).map(|(u, t)| {
            let steps = u.windows(2).zip(t.windows(2));
            steps.map(|(u, t)| 0.5 * (t[0] + t[1]) * (u[1] - u[0])).sum::<f64>()
        });
        parts.sum()
    };
    let (total, expected): (f64, f64) = (
        (0..flux.len()).map(work).sum(),
        flux.iter().map(|v| f64::from(*v)).sum(),
    );
    assert!((total / expected - 1.0).abs() < 0.1, "{total} instead of {expected}");
}

#[test]
fn the_table_is_the_file_and_the_page_is_small() {
    let table = std::fs::read_to_string(results().join("backbone.csv")).unwrap();
    let data = data();
    assert_eq!(data["modes"][0]["table"], table);
    assert_eq!(data["modes"][0]["file"], "backbone.csv");
    let bodies = &data["bodies"];
    assert!(
        bodies["step"].as_f64().unwrap() * 32767.0 > 0.71,
        "the beam is 0.72 m long"
    );
    let nodes = bytes(&bodies["positions"]).len() / 6;
    assert!(
        integers(&bodies["triangles"])
            .iter()
            .all(|&node| (node as usize) < nodes)
    );
    assert!(page().len() < 1_500_000, "{}", page().len());
}

#[test]
fn the_scene_is_there_with_every_default() {
    let page = page();
    let text = page.split_once("<pre>").unwrap().1.split_once("</pre>").unwrap().0;
    let text = text
        .replace("&#34;", "\"")
        .replace("&#39;", "'")
        .replace("&#60;", "<")
        .replace("&#62;", ">")
        .replace("&#38;", "&");
    let summary = read_json(&results().join("summary.json"));
    assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), summary["scene"]);
}

/// The answer to a request for a target.
fn get(address: &str, target: &str) -> String {
    use std::io::Write;
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    write!(stream, "GET {target} HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn runs_are_shown_beside_each_other() {
    use std::io::{BufRead, BufReader};
    let folder = folder("view");
    std::fs::write(folder.join("secret"), "hidden").unwrap();
    common::copy(results(), &folder.join("a"));
    common::copy(results(), &folder.join("b"));
    let mut program = std::process::Command::new(crate::PROGRAM)
        .args(["view", "a", "b", "--no-open"])
        .current_dir(&folder)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(program.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    let address = line.split_once("http://").unwrap().1.split('/').next().unwrap();
    let index = get(address, "/");
    let page = get(address, "/2/report.html");
    let outside = ["/1/../secret", "/1/%2e%2e/secret", "/secret"].map(|target| get(address, target));
    program.kill().unwrap();
    program.wait().unwrap();
    assert!(address.starts_with("127.0.0.1:"), "{line}");
    assert!(index.starts_with("HTTP/1.1 200 OK\r\n"), "{index:.300}");
    let data: Value = serde_json::from_str(data_of(&index)).unwrap();
    let table = std::fs::read_to_string(results().join("backbone.csv")).unwrap();
    for (number, folder) in ["a", "b"].into_iter().enumerate() {
        let run = &data["runs"][number];
        assert_eq!(run["name"], format!("{HOSTILE} ({folder})"));
        assert_eq!(run["modes"][0]["table"], table);
        assert_eq!(run["page"], format!("{}/report.html", number + 1));
    }
    assert!(!scripts_of(&index).0.contains("<img"));
    assert!(page.ends_with(&self::page()));
    for answer in outside {
        assert!(answer.starts_with("HTTP/1.1 404 "), "{answer:.300}");
    }
}
