#![doc = include_str!("../README.md")]

mod chain;
mod flange;
mod frame;
mod lattice;

pub use chain::Chain;
pub use flange::Flange;
pub use frame::Frame;

use serde_json::{Value, json};

/// Steel bodies with the measured asperities of the Brake-Reuss beam and flat faces, and loops of the first mode up to an amplitude.
fn scene(mesh: Value, amplitude_to: &str) -> Value {
    json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "mesh": mesh },
        "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.29, "density": 7800.0 } },
        "interfaces": { "surface": { "benchmark": "brake-reuss-beam" }, "gap": "flat", "mu": 0.2 },
        "bolts": { "load": "12 kN" },
        "analyses": {
            "modes": { "followed": [1] },
            "backbone": { "amplitudes": 10, "amplitude_from": "1 um", "amplitude_to": amplitude_to, "vertices_per_quarter": 4 },
        },
    })
}
