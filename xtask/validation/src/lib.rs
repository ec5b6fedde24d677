#![doc = include_str!("../README.md")]

pub mod bench;
pub mod dist;
mod elements;
pub mod extremes;
pub mod paper;
mod progress;
pub mod trade;

pub use progress::Display;

/// The flat beam as the method paper models it: linear elements, one friction limit per point.
fn paper_scene(name: &str) -> anyhow::Result<scenes::Scene> {
    let (_, text) = host::benchmarks::scene_text("brake-reuss-beam/brb-paper-flat")?;
    Ok(host::benchmarks::read(name, text)?)
}
