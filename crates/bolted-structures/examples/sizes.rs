//! Writes the structures by which the size of runs is measured, with linear elements: 20 laps of 588 elements, and a flange with 100 bolts and 100
//! elements at each.
//!
//! `cargo run --release -p bolted-structures --example sizes -- FOLDER`, then `microslip run FOLDER/laps/scene.json`.

use bolted_structures::{Chain, Flange};
use serde_json::{Value, json};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("give a folder")?);
    let laps = Chain {
        joints: 20,
        along: 42,
        across: 14,
    };
    let flange = Flange { bolts: 100, pad: 10 };
    let write = |name: &str, mesh: String, mut scene: Value| -> Result<(), Box<dyn Error>> {
        let own = folder.join(name);
        std::fs::create_dir_all(&own)?;
        scene["model"]["element_order"] = json!("linear");
        std::fs::write(own.join("mesh.msh"), mesh)?;
        Ok(std::fs::write(own.join("scene.json"), scene.to_string())?)
    };
    write("laps", laps.mesh()?, laps.scene("mesh.msh"))?;
    write("flange", flange.mesh()?, flange.scene("mesh.msh"))
}
