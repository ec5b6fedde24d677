//! Two rings on pads.

use crate::lattice::Lattice;
use finite_elements::Error;
use finite_elements::formats::gmsh;
use finite_elements::mesh::Mesh;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Arc of the circle of bolts that belongs to a bolt, and of its pad (m).
const PITCH: f64 = 0.08;
const PAD: f64 = 0.03;

/// Radial width of the rings (m).
const WIDTH: f64 = 0.03;

/// Thickness of the rings and height of the pads (m).
const THICKNESS: f64 = 0.016;
const HEIGHT: f64 = 0.002;

/// Layers of elements through a ring.
const LAYERS: usize = 2;

/// Height of a block on the upper ring between the first bolt and the second (m), which tells modes apart that a ring of equal sectors has in pairs.
const BLOCK: f64 = 0.03;

/// Two steel rings that touch on raised pads alone, one around each bolt M8: 80 mm of circumference for each bolt. Every pad is a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flange {
    /// Bolts.
    pub bolts: usize,
    /// Elements of a pad along the circumference and along the radius.
    pub pad: usize,
}

impl Default for Flange {
    fn default() -> Self {
        Self { bolts: 8, pad: 6 }
    }
}

impl Flange {
    /// Radius of the circle of bolts (m).
    fn radius(&self) -> f64 {
        PITCH * self.bolts as f64 / TAU
    }

    /// The text of its mesh, a Gmsh file with lengths in m, the volumes `upper` and `lower`, and the surfaces `upper pad 1`, `lower pad 1` and so on.
    ///
    /// # Errors
    /// None for at least three bolts and one element; otherwise those of the file.
    pub fn mesh(&self) -> Result<String, Error> {
        let mut mesh = Mesh::default();
        // As fine as the pads: what joints do to one another must die away between them on the mesh too.
        let between = (self.pad as f64 * (PITCH - PAD) / PAD).ceil() as usize;
        let sector = self.pad + between;
        // Angle of a line of nodes; pads are about the first bolt, the second and so on.
        let angle = |j: usize| {
            let (bolt, own) = (j / sector, j % sector);
            let arc = match own.checked_sub(self.pad) {
                None => PAD * (own as f64 / self.pad as f64 - 0.5),
                Some(rest) => 0.5 * PAD + (PITCH - PAD) * rest as f64 / between as f64,
            };
            arc / self.radius() + TAU * bolt as f64 / self.bolts as f64
        };
        let is_pad = |j: usize| j % sector < self.pad;
        let place = |[i, j, _]: [usize; 3], z: f64| {
            let r = self.radius() + WIDTH * (i as f64 / self.pad as f64 - 0.5);
            [r * angle(j).cos(), r * angle(j).sin(), z]
        };
        let layer = |k: usize| THICKNESS * k as f64 / LAYERS as f64;
        let upper = Lattice {
            cells: [self.pad, sector * self.bolts, LAYERS + 1],
            is_closed: true,
            has: &|[_, j, k]| k < LAYERS || (self.pad..sector).contains(&j),
            position: &|at| match at[2] {
                k if k > LAYERS => place(at, HEIGHT + THICKNESS + BLOCK),
                k => place(at, HEIGHT + layer(k)),
            },
        };
        let upper = upper.add(&mut mesh, "upper".into());
        let lower = Lattice {
            cells: [self.pad, sector * self.bolts, LAYERS + 1],
            is_closed: true,
            has: &|[_, j, k]| k < LAYERS || is_pad(j),
            position: &|at| match at[2] {
                k if k > LAYERS => place(at, HEIGHT),
                k => place(at, layer(k) - THICKNESS),
            },
        };
        let lower = lower.add(&mut mesh, "lower".into());
        let mut faces = Vec::with_capacity(2 * self.bolts);
        for bolt in 0..self.bolts {
            let is_own = |j: usize| is_pad(j) && j / sector == bolt;
            let number = bolt + 1;
            faces.push(upper.faces(format!("upper pad {number}"), false, |[_, j, k]| k == 0 && is_own(j)));
            faces.push(lower.faces(format!("lower pad {number}"), true, |[_, j, k]| {
                k == LAYERS && is_own(j)
            }));
        }
        gmsh::write(&mesh, &faces, &[])
    }

    /// Its scene; `path` is that of the mesh.
    pub fn scene(&self, path: &str) -> Value {
        let interfaces: Vec<Value> = (1..=self.bolts)
            .map(|pad| {
                json!({ "name": format!("pad {pad}"), "top": format!("upper pad {pad}"), "bottom": format!("lower pad {pad}") })
            })
            .collect();
        let at = |z: f64| [self.radius(), 0.0, z];
        let bolts = json!([{
            "axis": [at(HEIGHT + THICKNESS), at(-THICKNESS)], "size": "M8", "washers": true,
            "repeat": [{ "times": self.bolts, "about": [[0, 0, 0], [0, 0, 1]] }],
        }]);
        let outer = self.radius() + 0.5 * WIDTH;
        let mesh = json!({
            "path": path,
            "interfaces": interfaces,
            "bolts": bolts,
            "response": { "nearest": [outer, 0.0, HEIGHT + THICKNESS], "direction": [0.0, 0.0, 1.0] },
        });
        crate::scene(mesh, "100 um")
    }
}
