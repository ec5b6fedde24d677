//! Bars in a row.

use crate::lattice::Lattice;
use finite_elements::Error;
use finite_elements::formats::gmsh;
use finite_elements::mesh::Mesh;
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
    /// The text of its mesh, a Gmsh file with lengths in m, the volumes `bar 1`, `bar 2` and so on, along x, and the surface `first end`, by which it can
    /// be held: the lower side of the first third of the first bar.
    ///
    /// # Errors
    /// None for at least one element in each direction; otherwise those of the file.
    pub fn mesh(&self) -> Result<String, Error> {
        let mut mesh = Mesh::default();
        // As fine as laps: what joints do to one another must die away between them on the mesh too.
        let free = self.along;
        let graded = |from: f64, cells: usize| (1..=cells).map(move |i| from + LAP * i as f64 / cells as f64);
        let along: Vec<f64> = std::iter::once(0.0)
            .chain(graded(0.0, self.along))
            .chain(graded(LAP, free))
            .chain(graded(2.0 * LAP, self.along))
            .collect();
        let mut ends = Vec::new();
        for bar in 0..=self.joints {
            let [x, z] = [2.0 * LAP * bar as f64, if bar % 2 == 0 { 0.0 } else { -THICKNESS }];
            let lattice = Lattice {
                cells: [along.len() - 1, self.across, LAYERS],
                is_closed: false,
                has: &|_| true,
                position: &|[i, j, k]| {
                    let y = WIDTH * (j as f64 / self.across as f64 - 0.5);
                    [x + along[i], y, z + THICKNESS * k as f64 / LAYERS as f64]
                },
            };
            let body = lattice.add(&mut mesh, format!("bar {}", bar + 1));
            if bar == 0 {
                ends.push(body.faces("first end".to_owned(), false, |[i, _, k]| i < self.along && k == 0));
            }
        }
        gmsh::write(&mesh, &ends, &[])
    }

    /// Its scene; `path` is that of the mesh.
    pub fn scene(&self, path: &str) -> Value {
        let bar = |number: usize| format!("bar {number}");
        let interfaces: Vec<Value> = (1..=self.joints)
            .map(|lap| {
                // The first bar lies above the second, the second below the third.
                let sides = if lap % 2 == 1 { [lap, lap + 1] } else { [lap + 1, lap] };
                json!({ "name": format!("lap {lap}"), "between": sides.map(bar) })
            })
            .collect();
        let at = |z: f64| [2.5 * LAP - BOLT, 0.0, z];
        let bolts = json!([{
            "axis": [at(THICKNESS), at(-THICKNESS)], "size": "M8", "washers": true,
            "repeat": [{ "times": 2, "step": [2.0 * BOLT, 0, 0] }, { "times": self.joints, "step": [2.0 * LAP, 0, 0] }],
        }]);
        let length = 2.0 * LAP * self.joints as f64 + 3.0 * LAP;
        let mesh = json!({
            "path": path,
            "interfaces": interfaces,
            "bolts": bolts,
            "response": { "nearest": [length, 0.0, 0.0], "direction": [0.0, 0.0, 1.0] },
        });
        crate::scene(mesh, "1 mm")
    }
}
