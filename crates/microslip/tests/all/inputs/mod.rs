//! Files that commands read, made by the tests.
#![allow(clippy::unwrap_used)]
use serde_json::json;
use std::path::Path;

/// A ring-down of a mode at 180 Hz with 0.3 % of damping, and a neighbour, as text.
pub(crate) fn ring_down(scale: f64, neighbour: f64) -> String {
    let mut text = String::from("time [s],acc [g],still [g]\n");
    for i in 0..8192 {
        let t = f64::from(i) / 4096.0;
        let mode =
            |a: f64, f: f64| a * (-0.003 * std::f64::consts::TAU * f * t).exp() * (std::f64::consts::TAU * f * t).cos();
        let a = scale * (mode(5.0, 180.0) + mode(neighbour, 230.0));
        text += &format!("{t:.9},{a:.9},0\n");
    }
    text
}

/// Two synthetic faces on 18 mm x 12 mm as files that state nothing but their numbers, and the mesh of 6 x 4 elements on
/// them; steps of 60 and 100 um, heights in um.
pub(crate) fn faces(folder: &Path) {
    use surface_characterisation::SyntheticFace;
    for (name, seed) in [("top.csv", 1), ("bottom.csv", 2)] {
        let face = SyntheticFace {
            points: [301, 121],
            step: [60e-6, 100e-6],
            origin: [0.0, 0.0],
            rms: 2e-6,
            correlation_length: [200e-6, 300e-6],
            waviness: vec![],
            tilt: [1e-4, 0.0],
            height_step: Some(0.1e-6),
            seed,
        };
        let map = face.generate(|_| false).unwrap();
        let rows = (0..121).map(|j| {
            let row = (0..301).map(|i| format!("{:.1}", 1e6 * map.height(i, j).unwrap()));
            row.collect::<Vec<_>>().join(",")
        });
        std::fs::write(folder.join(name), rows.collect::<Vec<_>>().join("\n")).unwrap();
    }
    let nodes: Vec<[f64; 2]> = (0..35)
        .map(|k| [f64::from(k % 7) * 3.0, f64::from(k / 7) * 3.0])
        .collect();
    let element = |e: u32| {
        let a = e / 6 * 7 + e % 6 + 1;
        [a, a + 1, a + 8, a + 7]
    };
    let elements: Vec<[u32; 4]> = (0..24).map(element).collect();
    let mesh = json!({ "nodes": nodes, "elements": elements });
    std::fs::write(folder.join("mesh.json"), mesh.to_string()).unwrap();
}
