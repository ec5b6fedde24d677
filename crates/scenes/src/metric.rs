//! Sizes of metric hexagon bolts, and preload against torque.

use crate::Error;
use std::f64::consts::PI;

/// One row of the table of sizes, all in mm.
struct Row {
    /// Nominal diameter and coarse pitch (ISO 261).
    thread: [f64; 2],
    /// Width across flats and height of a bolt's head (ISO 4014).
    head: [f64; 2],
    /// Least diameter of the face under the head (ISO 4014; product grade A up to 24 mm, B beyond).
    face: f64,
    /// Height of a nut (ISO 4032).
    nut: f64,
    /// Clearance hole, medium series (ISO 273).
    hole: f64,
    /// Inner and outer diameter and thickness of a washer (ISO 7089).
    washer: [f64; 3],
}

const fn row(thread: [f64; 2], head: [f64; 2], face: f64, nut: f64, hole: f64, washer: [f64; 3]) -> Row {
    Row {
        thread,
        head,
        face,
        nut,
        hole,
        washer,
    }
}

#[rustfmt::skip]
const ROWS: [Row; 25] = [
    row([ 3.0, 0.5],  [ 5.5,  2.0],  4.57,  2.4,  3.4, [ 3.2,   7.0,  0.5]),
    row([ 4.0, 0.7],  [ 7.0,  2.8],  5.88,  3.2,  4.5, [ 4.3,   9.0,  0.8]),
    row([ 5.0, 0.8],  [ 8.0,  3.5],  6.88,  4.7,  5.5, [ 5.3,  10.0,  1.0]),
    row([ 6.0, 1.0],  [10.0,  4.0],  8.88,  5.2,  6.6, [ 6.4,  12.0,  1.6]),
    row([ 8.0, 1.25], [13.0,  5.3], 11.63,  6.8,  9.0, [ 8.4,  16.0,  1.6]),
    row([10.0, 1.5],  [16.0,  6.4], 14.63,  8.4, 11.0, [10.5,  20.0,  2.0]),
    row([12.0, 1.75], [18.0,  7.5], 16.63, 10.8, 13.5, [13.0,  24.0,  2.5]),
    row([14.0, 2.0],  [21.0,  8.8], 19.64, 12.8, 15.5, [15.0,  28.0,  2.5]),
    row([16.0, 2.0],  [24.0, 10.0], 22.49, 14.8, 17.5, [17.0,  30.0,  3.0]),
    row([18.0, 2.5],  [27.0, 11.5], 25.34, 15.8, 20.0, [19.0,  34.0,  3.0]),
    row([20.0, 2.5],  [30.0, 12.5], 28.19, 18.0, 22.0, [21.0,  37.0,  3.0]),
    row([22.0, 2.5],  [34.0, 14.0], 31.71, 19.4, 24.0, [23.0,  39.0,  3.0]),
    row([24.0, 3.0],  [36.0, 15.0], 33.61, 21.5, 26.0, [25.0,  44.0,  4.0]),
    row([27.0, 3.0],  [41.0, 17.0], 38.0,  23.8, 30.0, [28.0,  50.0,  4.0]),
    row([30.0, 3.5],  [46.0, 18.7], 42.75, 25.6, 33.0, [31.0,  56.0,  4.0]),
    row([33.0, 3.5],  [50.0, 21.0], 46.55, 28.7, 36.0, [34.0,  60.0,  5.0]),
    row([36.0, 4.0],  [55.0, 22.5], 51.11, 31.0, 39.0, [37.0,  66.0,  5.0]),
    row([39.0, 4.0],  [60.0, 25.0], 55.86, 33.4, 42.0, [42.0,  72.0,  6.0]),
    row([42.0, 4.5],  [65.0, 26.0], 59.95, 34.0, 45.0, [45.0,  78.0,  8.0]),
    row([45.0, 4.5],  [70.0, 28.0], 64.7,  36.0, 48.0, [48.0,  85.0,  8.0]),
    row([48.0, 5.0],  [75.0, 30.0], 69.45, 38.0, 52.0, [52.0,  92.0,  8.0]),
    row([52.0, 5.0],  [80.0, 33.0], 74.2,  42.0, 56.0, [56.0,  98.0,  8.0]),
    row([56.0, 5.5],  [85.0, 35.0], 78.66, 45.0, 62.0, [62.0, 105.0, 10.0]),
    row([60.0, 5.5],  [90.0, 38.0], 83.41, 48.0, 66.0, [66.0, 110.0, 10.0]),
    row([64.0, 6.0],  [95.0, 40.0], 88.16, 51.0, 70.0, [70.0, 115.0, 10.0]),
];

/// A metric thread with the basic profile of ISO 68-1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thread {
    /// Nominal diameter `d` (m).
    pub diameter: f64,
    /// Pitch `P` (m).
    pub pitch: f64,
}

impl Thread {
    /// Pitch diameter `d2 = d - 0.64952 P` (m; ISO 724).
    pub fn pitch_diameter(&self) -> f64 {
        self.diameter - 0.649_52 * self.pitch
    }

    /// Core diameter of the bolt `d3 = d - 1.22687 P` (m; ISO 965-1, VDI 2230-1).
    pub fn core_diameter(&self) -> f64 {
        self.diameter - 1.226_87 * self.pitch
    }

    /// Diameter of the tensile stress area, `(d2 + d3) / 2 = d - 0.9382 P` (m).
    pub fn stress_diameter(&self) -> f64 {
        self.diameter - 0.9382 * self.pitch
    }

    /// Tensile stress area (m^2; ISO 898-1).
    pub fn stress_area(&self) -> f64 {
        PI / 4.0 * self.stress_diameter().powi(2)
    }

    /// The ratio of torque to preload (m; Kellermann and Klein, VDI 2230-1:2015 section 5.4.3):
    /// `M_A / F = 0.16 P + 0.58 d2 mu_thread + D_Km / 2 mu_head`, with `D_Km` the mean of `bearing`, the inner and the outer
    /// diameter of the face that turns (m).
    pub fn lever(&self, friction: Friction, bearing: [f64; 2]) -> f64 {
        self.lever_parts(friction, bearing).iter().sum()
    }

    /// The terms of [`Thread::lever`] (m): what strains the bolt along the pitch, what friction takes in the thread, and below the head.
    pub fn lever_parts(&self, friction: Friction, bearing: [f64; 2]) -> [f64; 3] {
        let mean_diameter = 0.5 * (bearing[0] + bearing[1]);
        [
            0.16 * self.pitch,
            0.58 * self.pitch_diameter() * friction.thread,
            0.5 * mean_diameter * friction.head,
        ]
    }

    /// Torque that tightens to a preload (N): N m.
    pub fn torque(&self, preload: f64, friction: Friction, bearing: [f64; 2]) -> f64 {
        preload * self.lever(friction, bearing)
    }

    /// Preload that a torque (N m) gives: N.
    pub fn preload(&self, torque: f64, friction: Friction, bearing: [f64; 2]) -> f64 {
        torque / self.lever(friction, bearing)
    }

    /// Preload at which tension and torsion of tightening together reach the share `utilisation` of the yield strength (Pa): N
    /// (VDI 2230-1:2015 section 5.5.1, with the torsion of a fully plastic section).
    pub fn assembly_preload(&self, yield_strength: f64, utilisation: f64, thread_friction: f64) -> f64 {
        let (d0, d2) = (self.stress_diameter(), self.pitch_diameter());
        let shear = 1.5 * d2 / d0 * (self.pitch / (PI * d2) + 1.155 * thread_friction);
        self.stress_area() * utilisation * yield_strength / (1.0 + 3.0 * shear * shear).sqrt()
    }
}

/// Coefficients of friction while a bolt is tightened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// In the thread.
    pub thread: f64,
    /// Under the head or nut that turns.
    pub head: f64,
}

/// A washer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Washer {
    /// Inner diameter (m).
    pub inner: f64,
    /// Outer diameter (m).
    pub outer: f64,
    /// Thickness (m).
    pub thickness: f64,
}

/// A hexagonal prism: a bolt's head, or a nut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hexagon {
    /// Width across flats (m).
    pub across_flats: f64,
    /// Height (m).
    pub height: f64,
}

/// A size of metric hexagon bolts with what goes with it.
///
/// | what | standard |
/// |---|---|
/// | threads, coarse pitch | ISO 261 |
/// | head: width across flats, height, face under it | ISO 4014, product grade A up to 24 mm, B beyond |
/// | nut | ISO 4032 |
/// | clearance hole, medium | ISO 273 |
/// | washer | ISO 7089, nominal sizes |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// The thread.
    pub thread: Thread,
    /// The head.
    pub head: Hexagon,
    /// Outer diameter of the face under head and nut (m).
    pub face: f64,
    /// The nut.
    pub nut: Hexagon,
    /// Clearance hole (m).
    pub hole: f64,
    /// The washer.
    pub washer: Washer,
}

impl Metric {
    /// Name of the largest size that passes a hole of this diameter (m); none if the hole is a quarter wider than that.
    pub fn for_hole(diameter: f64) -> Option<String> {
        // Holes of meshes have corners, and positions have digits.
        let passes = |row: &&Row| 1e-3 * row.thread[0] <= diameter * (1.0 + 1e-3);
        let row = ROWS.iter().rev().find(passes)?;
        (diameter <= 1.25e-3 * row.thread[0]).then(|| format!("M{}", row.thread[0]))
    }

    /// The size called `M10`, or with a fine pitch `M10x1.25`.
    ///
    /// # Errors
    /// [`Error::BoltSize`] for sizes that are not in the table, M3 to M64, and pitches above the coarse one.
    pub fn from_name(name: &str) -> Result<Self, Error> {
        let fail = |reason: String| Error::BoltSize {
            name: name.to_owned(),
            reason,
        };
        let digits = name.trim().strip_prefix(['M', 'm']);
        let mut parts = digits.unwrap_or_default().split(['x', 'X', '×']);
        let number = |text: Option<&str>| text.and_then(|text| text.trim().parse::<f64>().ok());
        let diameter = number(parts.next());
        let found = ROWS.iter().find(|row| Some(row.thread[0]) == diameter);
        let Some(row) = found else {
            let known: Vec<String> = ROWS.iter().map(|row| format!("M{}", row.thread[0])).collect();
            return Err(fail(format!(
                "it must be one of {}, with a fine pitch as M10x1.25",
                known.join(", ")
            )));
        };
        let [diameter, coarse] = row.thread;
        let pitch = match parts.next() {
            None => coarse,
            text => number(text)
                .filter(|pitch| *pitch >= 0.2 && *pitch <= coarse)
                .ok_or_else(|| fail(format!("the pitch must be 0.2 to {coarse} mm, the coarse one")))?,
        };
        if parts.next().is_some() {
            return Err(fail("nothing may follow the pitch".into()));
        }
        let mm = |value: f64| 1e-3 * value;
        let hexagon = |[across_flats, height]: [f64; 2]| Hexagon {
            across_flats: mm(across_flats),
            height: mm(height),
        };
        Ok(Self {
            thread: Thread {
                diameter: mm(diameter),
                pitch: mm(pitch),
            },
            head: hexagon(row.head),
            face: mm(row.face),
            nut: hexagon([row.head[0], row.nut]),
            hole: mm(row.hole),
            washer: Washer {
                inner: mm(row.washer[0]),
                outer: mm(row.washer[1]),
                thickness: mm(row.washer[2]),
            },
        })
    }
}
