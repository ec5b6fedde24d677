//! Pictures for papers as a user makes them.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{exit_code, folder, messages, run, succeeds};
use flate2::read::ZlibDecoder;
use serde_json::{Value, json};
use std::io::Read;
use std::path::Path;

/// The picture that the command writes, which must be the same again, 85 mm wide, well formed, and valid as PDF.
fn picture(folder: &Path, arguments: &[&str]) -> String {
    let mut both = Vec::new();
    for extension in ["svg", "pdf"] {
        let [first, second] = ["first", "second"].map(|name| {
            let out = format!("pictures/{name}.{extension}");
            succeeds(folder, &[&["plot"], arguments, &["--out", &out]].concat());
            std::fs::read(folder.join(out)).unwrap()
        });
        assert!(first == second, "{arguments:?}: two pictures differ");
        both.push(first);
    }
    let pdf = both.pop().unwrap();
    let svg = String::from_utf8(both.pop().unwrap()).unwrap();
    reports::markup::check(&svg).unwrap();
    assert!(svg.starts_with("<svg width=\"85mm\" height=\""), "{}", &svg[..200]);
    let content = check_pdf(&pdf);
    // Each text, but for an empty one, has one or more runs of characters, each element its own state.
    let written = svg.matches("<text").count() - svg.matches(">\n\n</text>").count();
    assert!(content.matches(" Tj\n").count() >= written);
    assert_eq!(content.matches("BT\n").count(), svg.matches("<text").count());
    svg
}

/// Checks the table of objects, and that states are balanced; what is drawn.
fn check_pdf(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    assert!(text.starts_with("%PDF-1.4\n") && text.ends_with("%%EOF\n"));
    let find =
        |needle: &[u8], from: usize| from + bytes[from..].windows(needle.len()).position(|w| w == needle).unwrap();
    let start = text.rsplit("startxref\n").next().unwrap().lines().next().unwrap();
    let table = String::from_utf8(bytes[start.parse().unwrap()..].to_vec()).unwrap();
    let rows: Vec<usize> = (table.lines().filter_map(|line| line.strip_suffix(" 00000 n ")))
        .map(|at| at.parse().unwrap())
        .collect();
    assert_eq!(rows.len(), 5);
    for (index, at) in rows.iter().enumerate() {
        assert!(bytes[*at..].starts_with(format!("{} 0 obj\n", index + 1).as_bytes()));
    }
    let stream = find(b"stream\n", 0) + 7;
    let mut content = String::new();
    ZlibDecoder::new(&bytes[stream..]).read_to_string(&mut content).unwrap();
    let lines = |wanted: &str| content.lines().filter(|line| *line == wanted).count();
    assert_eq!(lines("q"), lines("Q"));
    content
}

/// Fails with one line that has all of these, and leaves no picture behind.
fn refuses(folder: &Path, arguments: &[&str], expected: &[&str]) {
    let output = run(folder, &[&["plot"], arguments, &["--out", "refused.pdf"]].concat());
    let text = messages(&output);
    assert_eq!(exit_code(&output), 1, "{arguments:?}: {text}");
    for part in expected {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    assert!(!folder.join("refused.pdf").exists());
}

/// Values of an attribute of all elements of a kind, in their order.
fn attributes(svg: &str, element: &str, name: &str) -> Vec<f64> {
    let (element, name) = (format!("<{element} "), format!(" {name}=\""));
    let value = |tag: &str| format!(" {tag}").split(&name).nth(1)?.split('"').next()?.parse().ok();
    svg.split(&element).skip(1).filter_map(value).collect()
}

/// A summary of which `compare` reads the backbone: a damping that is a power of the amplitude.
fn write_power_law(folder: &Path, name: &str) {
    let backbone: Vec<Value> = (0..=20)
        .map(|k| 1e-7 * 10_f64.powf(f64::from(k) / 5.0))
        .map(|x| json!({ "response_displacement": x, "frequency_hz": 170.0 - 1e3 * x, "damping_ratio": 20.0 * x.powf(0.7) }))
        .collect();
    std::fs::create_dir_all(folder.join(name)).unwrap();
    std::fs::write(
        folder.join(name).join("summary.json"),
        json!({ "backbone": backbone }).to_string(),
    )
    .unwrap();
}

#[test]
fn a_power_law_of_damping_is_a_straight_line_and_runs_have_a_legend() {
    let folder = folder("plot-backbone");
    write_power_law(&folder, "steel & \"oil\"");
    let one = picture(&folder, &["steel & \"oil\"", "--kind", "backbone"]);
    let [x, y] = ["cx", "cy"].map(|name| attributes(&one, "circle", name));
    assert_eq!(x.len(), 2 * 21);
    // The points of damping follow those of frequency.
    let [x, y] = [&x[21..], &y[21..]];
    for k in 0..=20 {
        let share = f64::from(k) / 20.0;
        let on_line = |of: &[f64]| of[0] + share * (of[20] - of[0]);
        let place = k as usize;
        assert!(
            (x[place] - on_line(x)).abs() <= 1.0 && (y[place] - on_line(y)).abs() <= 1.0,
            "point {k}"
        );
    }
    assert!(!one.contains("steel"), "one run needs no legend");
    write_power_law(&folder, "dry");
    let two = picture(&folder, &["steel & \"oil\"", "dry", "--kind", "backbone"]);
    assert!(two.contains("steel &amp; &quot;oil&quot;") && two.contains(">\ndry (secant)\n<"));
    // Of text that Helvetica does not have there is no PDF, but an SVG.
    write_power_law(&folder, "μ");
    refuses(
        &folder,
        &["μ", "dry", "--kind", "backbone"],
        &["`μ`", "Helvetica", ".svg"],
    );
    succeeds(&folder, &["plot", "μ", "dry", "--kind", "backbone"]);
    assert!(folder.join("results/plot-backbone.svg").exists());
}

#[test]
#[ignore = "twenty seconds; `.ci/run slow` runs it"]
fn slow_runs_have_maps_and_bands() {
    let folder = folder("plot-run");
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": "quick" },
        "interfaces": { "gap": "flat" },
        "uncertain": { "parameters": { "interfaces.mu": { "normal": { "sd": 0.02 }, "between": [0.1, 0.4] } } },
        "output": { "fields_at": [2] },
        "analyses": { "backbone": {
            "amplitudes": 3, "amplitude_from": "0.05 mm", "amplitude_to": "0.5 mm", "vertices_per_quarter": 4
        } }
    });
    std::fs::write(folder.join("beam.json"), scene.to_string()).unwrap();
    succeeds(&folder, &["run", "beam.json", "--samples", "5", "--out", "run"]);

    let map = picture(&folder, &["run", "--kind", "flux"]);
    let elements = std::fs::read_to_string(folder.join("run/interface-amplitude-02.vtu")).unwrap();
    let elements = elements
        .split("NumberOfCells=\"")
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap();
    assert_eq!(map.matches("<polygon").count(), elements.parse::<usize>().unwrap());
    assert!(map.contains("run: amplitude 2, ") && map.contains("[J/m²]"));
    assert!(map.contains(">x [mm]<"));
    picture(&folder, &["run", "--kind", "bands"]);
    picture(&folder, &["run", "run", "--kind", "backbone"]);

    refuses(
        &folder,
        &["run", "--kind", "flux", "--amplitude", "3"],
        &["amplitude 3", "2", "output.fields_at"],
    );
    refuses(
        &folder,
        &["run", "--kind", "flux", "--mode", "2"],
        &["mode 2 was not followed, but 1", "analyses.modes.followed"],
    );
    refuses(
        &folder,
        &["run", "--kind", "backbone", "--mode", "3"],
        &["--mode", "flux or bands"],
    );
    refuses(&folder, &["run", "--kind", "modes"], &["microslip model SCENE --modes"]);
    refuses(
        &folder,
        &["run", "run", "--kind", "trade"],
        &["one folder", "2 are given"],
    );
    refuses(&folder, &["run", "--kind", "trade"], &["trade.json"]);
    let output = run(&folder, &["plot", "run", "--kind", "flux", "--out", "map.png"]);
    assert!(exit_code(&output) == 1 && messages(&output).contains(".svg or .pdf"));

    succeeds(&folder, &["run", "beam.json", "--out", "bare"]);
    refuses(
        &folder,
        &["bare", "--kind", "bands"],
        &["no bands of mode 1", "--samples", "--ensemble"],
    );

    succeeds(&folder, &["model", "beam.json", "--modes", "2", "--out", "model"]);
    let modes = picture(&folder, &["model", "--kind", "modes"]);
    assert!(modes.contains(">1. ") && modes.contains(">2. ") && modes.contains(" Hz<"));
}

#[test]
fn errors_stand_against_time() {
    let folder = folder("plot-trade");
    let rung = |dial: &str, seconds: f64, error: f64| {
        json!({ "dial": dial, "seconds": seconds, "errors": {
            "linear_frequency": 0.5 * error, "frequency_shift": [0.5 * error, null, -error], "damping_ln": [-2.0 * error, null, error]
        } })
    };
    let rungs = [
        rung("mesh", 1.0, 1e-2),
        rung("mesh", 10.0, 1e-3),
        rung("vertices", 2.0, 1e-2),
        json!({ "dial": "mesh", "errors": null, "status": "failed: no" }),
    ];
    std::fs::create_dir_all(folder.join("trade")).unwrap();
    std::fs::write(folder.join("trade/trade.json"), json!({ "rungs": rungs }).to_string()).unwrap();
    let svg = picture(&folder, &["trade", "--kind", "trade"]);
    let [x, y] = ["cx", "cy"].map(|name| attributes(&svg, "circle", name));
    // Two settings of the mesh and one of the vertices; times ten, errors by ten, in both diagrams.
    assert_eq!(x.len(), 6);
    assert!(x[0] == x[3] && x[1] == x[4] && y[0] == y[2], "{x:?} {y:?}");
    let decade = x[1] - x[0];
    assert!(((x[2] - x[0]) / decade - 2_f64.log10()).abs() < 2e-3);
    std::fs::write(folder.join("trade/trade.json"), "{\"rungs\": []}").unwrap();
    refuses(&folder, &["trade", "--kind", "trade"], &["no setting was measured"]);
}
