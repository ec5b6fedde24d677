#![doc = include_str!("../README.md")]

use finite_elements::Error;
use finite_elements::elements::{Cell, Formulation, HEX8};
use finite_elements::formats::gmsh;
use finite_elements::mesh::{Element, Material, Mesh};
use serde_json::{Value, json};

/// Size of a lap and of the free length between two laps (m), along the chain.
const LAP: f64 = 0.06;

/// Width and thickness of a bar (m).
const WIDTH: f64 = 0.025;
const THICKNESS: f64 = 0.008;

/// Distance of a bolt from the middle of its lap (m).
const BOLT: f64 = 0.015;

/// Layers of elements through a bar.
const LAYERS: usize = 2;

/// Flat bars of 180 x 25 x 8 mm, one end of each on top of an end of the next: 60 mm of lap with two bolts M8, 60 mm free. All joints are alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain {
    /// Laps, one less than bars.
    pub joints: usize,
    /// Elements along a lap.
    pub along: usize,
    /// Elements across a bar.
    pub across: usize,
}

impl Default for Chain {
    fn default() -> Self {
        Self {
            joints: 4,
            along: 12,
            across: 6,
        }
    }
}

impl Chain {
    /// The text of its mesh, a Gmsh file with lengths in m and the volumes `bar 1`, `bar 2` and so on, along x.
    ///
    /// # Errors
    /// None for at least one element in each direction; otherwise those of the file.
    pub fn mesh(&self) -> Result<String, Error> {
        let mut mesh = Mesh::default();
        let free = self.along.div_ceil(3).max(1);
        let graded = |from: f64, cells: usize| (1..=cells).map(move |i| from + LAP * i as f64 / cells as f64);
        let along: Vec<f64> = std::iter::once(0.0)
            .chain(graded(0.0, self.along))
            .chain(graded(LAP, free))
            .chain(graded(2.0 * LAP, self.along))
            .collect();
        for bar in 0..=self.joints {
            mesh.materials.push(Material {
                name: format!("bar {}", bar + 1),
                youngs_modulus: 1.0,
                poisson_ratio: 0.0,
                density: 1.0,
            });
            let [x, z] = [2.0 * LAP * bar as f64, if bar % 2 == 0 { 0.0 } else { -THICKNESS }];
            let first = mesh.nodes.len();
            for at in &along {
                for j in 0..=self.across {
                    for k in 0..=LAYERS {
                        let y = WIDTH * (j as f64 / self.across as f64 - 0.5);
                        mesh.nodes.push([x + at, y, z + THICKNESS * k as f64 / LAYERS as f64]);
                    }
                }
            }
            let node = |i: usize, j: usize, k: usize| (first + (i * (self.across + 1) + j) * (LAYERS + 1) + k) as u32;
            for i in 0..along.len() - 1 {
                for j in 0..self.across {
                    for k in 0..LAYERS {
                        let layer = |k| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| node(i + a, j + b, k));
                        let nodes = [layer(k), layer(k + 1)].concat();
                        // There is one of eight nodes.
                        let cell = Cell::try_new(&HEX8, Formulation::IncompatibleModes, &nodes);
                        mesh.elements.extend(cell.map(|cell| Element {
                            cell,
                            material: bar as u16,
                        }));
                    }
                }
            }
        }
        gmsh::write(&mesh, &[], &[])
    }

    /// Its scene, of steel, with the measured asperities of the Brake-Reuss beam and flat faces; `path` is that of the mesh.
    pub fn scene(&self, path: &str) -> Value {
        let bar = |number: usize| format!("bar {number}");
        let interfaces: Vec<Value> = (1..=self.joints)
            .map(|lap| {
                // The first bar lies above the second, the second below the third.
                let sides = if lap % 2 == 1 { [lap, lap + 1] } else { [lap + 1, lap] };
                json!({ "name": format!("lap {lap}"), "between": sides.map(bar) })
            })
            .collect();
        let bolts: Vec<Value> = (1..=self.joints)
            .flat_map(|lap| {
                let middle = 2.0 * LAP * lap as f64 + 0.5 * LAP;
                [-BOLT, BOLT].map(|offset| {
                    let at = |z: f64| json!([middle + offset, 0.0, z]);
                    json!({ "axis": [at(THICKNESS), at(-THICKNESS)], "size": "M8", "washers": true })
                })
            })
            .collect();
        let length = 2.0 * LAP * self.joints as f64 + 3.0 * LAP;
        json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "mesh": {
                "path": path,
                "interfaces": interfaces,
                "bolts": bolts,
                "response": { "nearest": [length, 0.0, 0.0], "direction": [0.0, 0.0, 1.0] },
            } },
            "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.29, "density": 7800.0 } },
            "interfaces": { "surface": { "benchmark": "brake-reuss-beam" }, "gap": "flat", "mu": 0.2 },
            "bolts": { "load": "12 kN" },
            "analyses": {
                "modes": { "followed": [1] },
                "backbone": { "amplitudes": 10, "amplitude_from": "1 um", "amplitude_to": "1 mm", "vertices_per_quarter": 4 },
            },
        })
    }
}
