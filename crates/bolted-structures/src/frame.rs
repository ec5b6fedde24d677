//! A frame of bars in three directions.

use crate::lattice::Lattice;
use finite_elements::Error;
use finite_elements::formats::gmsh;
use finite_elements::mesh::Mesh;
use serde_json::{Value, json};

/// Where bars meet along x: cross bars lie over the first, the third and the fifth length, posts stand at the second and the fourth (m).
const MEETINGS: [[f64; 2]; 5] = [[0.08, 0.12], [0.185, 0.215], [0.28, 0.32], [0.385, 0.415], [0.48, 0.52]];

/// Length and section of the bars along x (m).
const LONG: f64 = 0.6;
const WIDTH: f64 = 0.04;
const DEPTH: f64 = 0.02;

/// Distance over the outer sides of the two bars along x of a level, which is the length of cross bars, and their thickness (m).
const ACROSS: f64 = 0.4;
const CROSS: f64 = 0.01;

/// Height of the second level over the first, and thickness of the posts (m).
const STOREY: f64 = 0.3;
const POST: f64 = 0.008;

/// Free lengths have elements so many times as long as laps.
const COARSER: f64 = 3.0;

/// Two levels, each of two bars along x with three bars across on top of them, and four posts outside: 20 laps with a bolt M8 each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Elements along the width of a lap of 40 mm.
    pub lap: usize,
}

impl Default for Frame {
    fn default() -> Self {
        Self { lap: 8 }
    }
}

/// A bar: its name, and lines of nodes along x, y and z.
struct Bar {
    name: String,
    lines: [Vec<f64>; 3],
}

impl Frame {
    /// Lines of nodes between these ends, with these lengths as fine as laps.
    fn lines(&self, ends: [f64; 2], fine: &[[f64; 2]]) -> Vec<f64> {
        let size = WIDTH / self.lap as f64;
        let mut lines = vec![ends[0]];
        let mut go = |to: f64, size: f64| {
            let from = lines[lines.len() - 1];
            let cells = ((to - from) / size - 1e-9).ceil().max(0.0) as usize;
            lines.extend((1..=cells).map(|i| from + (to - from) * i as f64 / cells as f64));
        };
        for &[from, to] in fine {
            go(from, COARSER * size);
            go(to, size);
        }
        go(ends[1], COARSER * size);
        lines
    }

    fn bars(&self) -> Vec<Bar> {
        let mut bars = Vec::new();
        let sides = [[0.0, WIDTH], [ACROSS - WIDTH, ACROSS]];
        let levels = [0.0, STOREY];
        for (level, z) in (1..).zip(levels) {
            for (side, y) in (1..).zip(sides) {
                bars.push(Bar {
                    name: format!("bar {level}.{side}"),
                    lines: [
                        self.lines([0.0, LONG], &MEETINGS),
                        self.lines(y, &[y]),
                        self.lines([z, z + DEPTH], &[[z, z + DEPTH]]),
                    ],
                });
            }
            for (number, x) in (1..).zip(MEETINGS.into_iter().step_by(2)) {
                let z = z + DEPTH;
                bars.push(Bar {
                    name: format!("cross {level}.{number}"),
                    lines: [
                        self.lines(x, &[x]),
                        self.lines([0.0, ACROSS], &sides),
                        self.lines([z, z + CROSS], &[[z, z + CROSS]]),
                    ],
                });
            }
        }
        for (side, y) in (1..).zip([[-POST, 0.0], [ACROSS, ACROSS + POST]]) {
            for (number, x) in (1..).zip([MEETINGS[1], MEETINGS[3]]) {
                bars.push(Bar {
                    name: format!("post {side}.{number}"),
                    lines: [
                        self.lines(x, &[x]),
                        self.lines(y, &[y]),
                        self.lines([0.0, STOREY + DEPTH], &levels.map(|z| [z, z + DEPTH])),
                    ],
                });
            }
        }
        bars
    }

    /// The text of its mesh, a Gmsh file with lengths in m and a volume for each bar.
    ///
    /// # Errors
    /// None for at least one element; otherwise those of the file.
    pub fn mesh(&self) -> Result<String, Error> {
        let mut mesh = Mesh::default();
        for Bar { name, lines } in self.bars() {
            let [x, y, z] = &lines;
            let lattice = Lattice {
                cells: [x.len() - 1, y.len() - 1, z.len() - 1],
                is_closed: false,
                has: &|_| true,
                position: &|[i, j, k]| [x[i], y[j], z[k]],
            };
            lattice.add(&mut mesh, name);
        }
        gmsh::write(&mesh, &[], &[])
    }

    /// Its scene; `path` is that of the mesh.
    pub fn scene(&self, path: &str) -> Value {
        let (mut interfaces, mut bolts) = (Vec::new(), Vec::new());
        let mut join = |upper: String, lower: String, axis: [[f64; 3]; 2]| {
            interfaces.push(json!({ "name": format!("{upper} on {lower}"), "between": [upper, lower] }));
            bolts.push(json!({ "axis": axis, "size": "M8", "washers": true }));
        };
        let middle = |x: [f64; 2]| 0.5 * (x[0] + x[1]);
        for (level, z) in [(1, 0.0), (2, STOREY)] {
            for (side, y) in [(1, 0.5 * WIDTH), (2, ACROSS - 0.5 * WIDTH)] {
                for (number, x) in (1..).zip(MEETINGS.into_iter().step_by(2)) {
                    let at = |z: f64| [middle(x), y, z];
                    let axis = [at(z + DEPTH + CROSS), at(z)];
                    join(format!("cross {level}.{number}"), format!("bar {level}.{side}"), axis);
                }
                let z = z + 0.5 * DEPTH;
                for (number, x) in (1..).zip([MEETINGS[1], MEETINGS[3]]) {
                    let at = |y: f64| [middle(x), y, z];
                    let axis = match side {
                        1 => [at(-POST), at(WIDTH)],
                        _ => [at(ACROSS + POST), at(ACROSS - WIDTH)],
                    };
                    join(format!("post {side}.{number}"), format!("bar {level}.{side}"), axis);
                }
            }
        }
        let mesh = json!({
            "path": path,
            "interfaces": interfaces,
            "bolts": bolts,
            "response": { "nearest": [LONG, 0.0, STOREY], "direction": [0.0, 1.0, 0.0] },
        });
        crate::scene(mesh, "1 mm")
    }
}
