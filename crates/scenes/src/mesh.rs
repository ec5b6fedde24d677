//! A structure from a mesh file: which of its parts are bodies, interfaces, bolts and supports.

use super::material::Material;
use super::units::{ContactStiffness, Length, Units};
use nalgebra::{Rotation3, Unit, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::PathBuf;

/// A structure from a mesh of Gmsh (`.msh`), Abaqus, CalculiX or PrePoMax (`.inp`), Nastran or Optistruct (`.bdf`, `.nas`, `.fem`), Ansys (`.cdb`), I-DEAS (`.unv`), Exodus II (`.exo`), Salome (`.med`) or VTK (`.vtu`).
///
/// Groups are physical groups of Gmsh, sets and surfaces of decks, properties and sets of Nastran, components of Ansys, blocks and sets of Exodus, and values of cell arrays of VTK.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// The file; in a scene file relative to its folder.
    pub path: PathBuf,
    /// Its units, of which that of length matters; by default those of the scene.
    #[serde(default = "Units::in_use")]
    pub units: Units,
    /// Materials of the volumes with these names; all others have the scene's `model.material`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, Material>,
    /// Where bodies touch.
    pub interfaces: Vec<MeshInterface>,
    /// Bolts that are not in the mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bolts: Vec<MeshBolt>,
    /// Surfaces that are glued together; their meshes need not match.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ties: Vec<MeshTie>,
    /// Bodies, or parts of bodies, that come as matrices of another program and are joined to nodes of the mesh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub superelements: Vec<MeshSuperelement>,
    /// What holds the structure; none if it is free.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub supports: Vec<MeshSupport>,
    /// Where amplitudes are measured.
    pub response: MeshResponse,
    /// By how much the bodies can slide before a shank touches its hole (length), if it is known.
    #[serde(default)]
    pub bolt_hole_clearance: Option<Length>,
}

/// Where two bodies touch: two named surfaces, or the faces of two bodies that lie upon one another.
///
/// With neither, the file must hold two bodies, of which the first is the top one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshInterface {
    /// Name in results; by default a number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Surface of the top body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub top: Option<String>,
    /// Surface of the bottom body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom: Option<String>,
    /// In their place the volumes of the top and of the bottom body, whose faces that touch are the interface. In names, `*` stands for any text: then there is an
    /// interface for each pair of volumes that touch, and that no entry before it is between.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[String; 2]>,
    /// How far apart along the normal faces may be that touch (length); by default a twentieth of the longest edge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Length>,
    /// First direction in the interface.
    #[serde(default = "along_x")]
    pub along: [f64; 3],
}

/// A bolt that is not in the mesh: a shank on an axis through the clamped bodies, or forces on two surfaces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshBolt {
    /// Two points on the axis of the shank, that of the head first. The bolt clamps what the axis meets between them, and beyond them what lies on that without a gap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[[Length; 3]; 2]>,
    /// Its thread with an axis, such as `"M10"` or `"M10x1.25"`: sizes of head, nut and washers are those of ISO 4014, 4032 and 7089.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<String>,
    /// Whether there are washers under head and nut.
    #[serde(default)]
    pub washers: bool,
    /// How head and nut hold the bodies.
    #[serde(default)]
    pub seat: BoltSeat,
    /// Material of the bolt; by default the scene's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
    /// Without an axis, the surface that the head presses on; nothing is between it and that of the nut but forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub head: Option<String>,
    /// Without an axis, the surface that the nut presses on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nut: Option<String>,
    /// Bolts like it in a pattern. Each entry repeats what those before it made, so that two of them make rows and columns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repeat: Vec<Repeat>,
}

/// How often a bolt stands beside itself: along a line, or on a circle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Repeat {
    /// How many there are, with the first.
    pub times: usize,
    /// From one to the next (length).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<[Length; 3]>,
    /// In its place two points on the axis that they are turned about, by the right hand from the first point to the second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<[[Length; 3]; 2]>,
    /// Angle from one to the next (degrees); by default they share a full circle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
}

impl Repeat {
    /// Where the one of this number, counted from zero, has a position of the first.
    fn place(&self, number: usize, at: [Length; 3]) -> [Length; 3] {
        let vector = |at: &[Length; 3]| Vector3::from(at.map(Length::si));
        let along = self.step.as_ref().map_or(Vector3::zeros(), vector);
        let moved = vector(&at) + number as f64 * along;
        let placed = match &self.about {
            None => moved,
            Some([from, to]) => {
                let angle = self.angle_deg.map_or(TAU / self.times as f64, f64::to_radians);
                let from = vector(from);
                let axis = Unit::new_normalize(vector(to) - from);
                from + Rotation3::from_axis_angle(&axis, number as f64 * angle) * (moved - from)
            }
        };
        placed.map(Length::from_si).into()
    }
}

impl MeshFile {
    /// Whether there may be more than one interface: one between patterns of names has as many as pairs touch.
    pub(super) fn may_have_several_interfaces(&self) -> bool {
        let is_pattern = |interface: &MeshInterface| interface.between.iter().flatten().any(|name| name.contains('*'));
        self.interfaces.len() > 1 || self.interfaces.iter().any(is_pattern)
    }

    /// The bolts with those of their patterns, in turn.
    pub fn all_bolts(&self) -> Vec<MeshBolt> {
        let pattern = |bolt: &MeshBolt| {
            let mut made = vec![MeshBolt {
                repeat: Vec::new(),
                ..bolt.clone()
            }];
            for repeat in &bolt.repeat {
                let again = |number: usize| {
                    let moved = move |bolt: &MeshBolt| MeshBolt {
                        axis: bolt.axis.map(|axis| axis.map(|at| repeat.place(number, at))),
                        ..bolt.clone()
                    };
                    made.iter().map(moved).collect::<Vec<_>>()
                };
                made = (0..repeat.times).flat_map(again).collect();
            }
            made
        };
        self.bolts.iter().flat_map(pattern).collect()
    }
}

/// How head and nut of a bolt hold the bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum BoltSeat {
    /// The seat moves with the mean motion of the face below it, and does not stiffen it.
    #[default]
    Distributing,
    /// The face below it follows the seat rigidly.
    Tied,
}

/// Two surfaces that are glued together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshTie {
    /// The one whose nodes follow: the finer one, or the one on the softer body.
    pub slave: String,
    /// The one whose faces they follow.
    pub master: String,
    /// How far they may be apart (length); by default a twentieth of the longest edge of the master.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Length>,
}

/// A body, or a part of one, by its stiffness and mass. It is joined to the nodes of the mesh that have the labels in its map of degrees of freedom; retained
/// modes, rotations and other nodes move inside of it. The mesh keeps the elements that it comes with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshSuperelement {
    /// A file or folder as of `structure.matrices`; in a scene file relative to its folder.
    pub path: PathBuf,
    /// Its units, of which that of mass matters; by default those of the scene.
    #[serde(default = "Units::in_use")]
    pub units: Units,
    /// What is added to the labels of its nodes, so that one file serves several equal bodies.
    #[serde(default)]
    pub label_offset: i64,
    /// Whether supports of its own are in its stiffness. Otherwise it must let its nodes move rigidly, which is checked.
    #[serde(default)]
    pub held: bool,
}

/// A part of the structure that is held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshSupport {
    /// A surface of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<String>,
    /// In its place a position: the smooth part of the bodies' outer surface with the face whose middle is nearest to it. It ends at edges where
    /// neighbouring faces meet at more than 46 degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<[Length; 3]>,
    /// In its place, a group of nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<String>,
    /// Which displacement components x, y, z of the model are held.
    #[serde(default = "all")]
    pub components: [bool; 3],
    /// Stiffness per area of a surface that rests on an elastic ground; without it the components do not move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<ContactStiffness>,
}

/// Where and in which direction amplitudes are measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshResponse {
    /// A position, for the node of the bodies' surface that is nearest to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<[Length; 3]>,
    /// In its place a group of one node, or the number of a node in the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// In its place a mode of the structure with a stuck interface, counted from 1: where and along which this mode moves most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<usize>,
    /// Unit vector; none with a mode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
}

pub(super) fn along_x() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}

fn all() -> [bool; 3] {
    [true; 3]
}
