//! Scenes on the benchmark that the tests use.
#![allow(dead_code, clippy::unwrap_used, reason = "each test uses some of it")]

use brake_reuss_beam::BrakeReussBenchmark;
use joint_pipeline::{Benchmark, Scene};

/// Benchmarks that scenes of the tests may name.
pub(crate) static BENCHMARKS: [&dyn Benchmark; 1] = [&BrakeReussBenchmark];

/// The default scene on the Brake-Reuss beam.
pub(crate) fn beam(name: &str) -> Scene {
    Scene::of(&BrakeReussBenchmark, name).unwrap()
}
