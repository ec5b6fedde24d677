//! How the geometry of a mesh fits what a scene says of it: faces that touch, and seats of bolts.

use crate::significant_digits::significant;
use serde::{Deserialize, Serialize};

/// Interfaces of which the geometry is told.
const MOST: usize = 3;

/// What geometry alone says of faces and seats; empty where no mesh was read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Fit {
    /// Faces that touch, interface by interface.
    pub faces: Vec<FacesFit>,
    /// Seats of bolts that are described by an axis and a size.
    pub seats: Vec<SeatFit>,
}

/// Two faces that touch, as they were before nodes were moved.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FacesFit {
    /// Name of the interface.
    pub interface: String,
    /// Whether the scene names the faces; otherwise all elements were taken that touch another, be it in part.
    pub named: bool,
    /// Whether the faces are curved, so that meshes of them are apart by the height of arcs.
    pub curved: bool,
    /// Shares of top and bottom face that face nothing (-).
    pub without_partner: [f64; 2],
    /// Mean distance along the normal (m); negative where the bodies penetrate one another.
    pub distance: f64,
    /// Mean size of the distance (m).
    pub distance_size: f64,
    /// Least and largest distance (m).
    pub distance_range: [f64; 2],
}

impl FacesFit {
    /// The distance that stands for the faces (m): meshes of curved ones are apart by the height of arcs, on both sides.
    pub fn representative(&self) -> f64 {
        match self.curved {
            true => self.distance,
            false => self.distance_size.copysign(self.distance),
        }
    }

    fn line(&self) -> String {
        let shares = self
            .without_partner
            .map(|share| significant((1e4 * share).round() / 100.0));
        let [mean, least, largest] = [self.distance, self.distance_range[0], self.distance_range[1]].map(millimetres);
        format!(
            "faces: {} % of the top and {} % of the bottom one without a partner; {mean} mm apart in the mean ({least} to {largest} mm)",
            shares[0], shares[1]
        )
    }
}

/// The seat of a bolt on the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SeatFit {
    /// Number of the bolt, from 1.
    pub bolt: usize,
    /// Head or nut.
    pub side: String,
    /// Outer diameter of head, nut or washer (m).
    pub outer: f64,
    /// Nominal diameter of the shank (m).
    pub shank: f64,
    /// Share of the ring under head, nut or washer that lies on faces of the mesh (-); above one for polygons around round holes.
    pub covered: f64,
    /// The round hole in its plane whose centre is below it, if there is one.
    pub hole: Option<Hole>,
    /// The seat of another bolt in its plane that is nearest, if there is one.
    pub neighbour: Option<Neighbour>,
}

/// A round hole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Hole {
    /// Twice the mean distance of the nodes of its rim from its centre (m).
    pub diameter: f64,
    /// Distance of its centre from the axis (m).
    pub offset: f64,
}

/// Another seat in the plane of a seat.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Neighbour {
    /// Number of its bolt, from 1.
    pub bolt: usize,
    /// Distance of the centres (m).
    pub distance: f64,
    /// Distance from which on the two have room beside one another (m).
    pub least: f64,
}

impl Neighbour {
    /// Room between the rims (m); negative where they overlap.
    pub fn room(&self) -> f64 {
        self.distance - self.least
    }
}

impl Fit {
    /// In a few plain lines.
    pub fn lines(&self) -> Vec<String> {
        let name = |faces: &FacesFit| match self.faces.len() {
            1 => String::new(),
            _ => format!("interface {}: ", faces.interface),
        };
        let mut lines: Vec<String> = (self.faces.iter().take(MOST))
            .map(|faces| format!("{}{}", name(faces), faces.line()))
            .collect();
        if self.faces.len() > MOST {
            lines.push(format!("and {} more interfaces", self.faces.len() - MOST));
        }
        if !self.seats.is_empty() {
            let covered = self.seats.iter().map(|seat| seat.covered).fold(f64::INFINITY, f64::min);
            let holes: Vec<Hole> = self.seats.iter().filter_map(|seat| seat.hole).collect();
            let offset = holes.iter().map(|hole| hole.offset).fold(0.0, f64::max);
            lines.push(format!(
                "seats of bolts: at least {} % of a ring is on the mesh; {} of {} have a round hole, at most {} mm off the axis",
                significant((100.0 * covered).round()),
                holes.len(),
                self.seats.len(),
                millimetres(offset)
            ));
        }
        lines
    }
}

/// To a tenth of a micrometre, below which coordinates of files are round-off.
fn millimetres(metres: f64) -> String {
    // Without the sign of a negative zero.
    significant((1e7 * metres).round() / 1e4 + 0.0)
}
