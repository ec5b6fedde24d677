//! `samples`: small files to try the commands with.

mod joint;

use super::destination::write_new;
use crate::text::print;
use anyhow::Result;
use modal_identification::synthetic::{RingDown, add_noise};
use std::fmt::Write;
use std::path::PathBuf;
use surface_characterisation::{HeightMap, SyntheticFace, writers};

/// Options of `samples`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for the files, made if missing.
    directory: PathBuf,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let directory = &arguments.directory;
    let text = |text: &str| text.as_bytes().to_vec();
    let mut files = vec![
        ("README.md", text(include_str!("README.md"))),
        ("joint-mesh.json", text(include_str!("joint-mesh.json"))),
        ("joint-motions.json", text(include_str!("joint-motions.json"))),
        ("joint-scans.json", text(include_str!("joint-scans.json"))),
        ("joint.msh", joint::gmsh()?.into_bytes()),
        ("joint.inp", joint::deck()?.into_bytes()),
        ("joint-deck.json", joint::deck_scene().into_bytes()),
        ("patch.json", joint::patch().to_string().into_bytes()),
    ];
    for (names, seed) in [(["top.x3p", "top.csv"], 1), (["bottom.x3p", "bottom.csv"], 2)] {
        let map = face(seed)?;
        files.push((names[0], writers::x3p(&map)?));
        files.push((names[1], grid(&map).into_bytes()));
    }
    for (name, amplitude, seed) in [("hit1.csv", 5000.0, 1), ("hit2.csv", 4000.0, 2)] {
        files.push((name, ring_down(amplitude, seed).into_bytes()));
    }
    let borrowed: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
    write_new(directory, &borrowed)?;
    let total: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    print(&format!(
        "{} files of {:.1} MB in {}; README.md there has commands that use them\n",
        files.len(),
        1e-6 * total as f64,
        directory.display()
    ))
}

/// A face of the patch on which the sample joint touches, as a profilometer with steps of 60 and 100 um sees it.
fn face(seed: u64) -> Result<HeightMap> {
    let [length, width] = joint::OVERLAP;
    let face = SyntheticFace {
        points: [301, 121],
        step: [length / 300.0, width / 120.0],
        origin: [-0.5 * length, -0.5 * width],
        rms: 2e-6,
        correlation_length: [200e-6, 300e-6],
        waviness: Vec::new(),
        tilt: [1e-4, 0.0],
        height_step: Some(0.1e-6),
        seed,
    };
    Ok(face.generate(|_| false)?)
}

/// Lines of heights in um, the lowest y first.
fn grid(map: &HeightMap) -> String {
    let mut text = String::new();
    for j in 0..map.ny() {
        for i in 0..map.nx() {
            let end = if i + 1 == map.nx() { '\n' } else { ',' };
            let height = 1e6 * map.height(i, j).unwrap_or(f64::NAN);
            // Writing to a string cannot fail.
            let _ = write!(text, "{height:.1}{end}");
        }
    }
    text
}

/// The acceleration after a hammer hit (m/s^2): a mode near that of the sample joint, and noise.
fn ring_down(amplitude: f64, seed: u64) -> String {
    let rate = 20480.0;
    let mode = RingDown {
        amplitude,
        phase: 0.5,
        frequency: |a: f64| 2810.0 - 2e-3 * a,
        damping_ratio: |a: f64| 5e-4 + 3e-7 * a,
    };
    let mut samples = mode.samples(rate, 9000);
    add_noise(&mut samples, 0.05, seed);
    let mut text = String::from("time [s],tip:+Z [m/s^2]\n");
    for (i, sample) in samples.iter().enumerate() {
        let _ = writeln!(text, "{:.9},{sample:.3}", i as f64 / rate);
    }
    text
}
