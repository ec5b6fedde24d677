//! Input decks of Abaqus and CalculiX (`.inp`).
//!
//! [`read`] turns a file into a [`Deck`], which holds what the file says with all names resolved; [`Deck::assembly`]
//! makes a [`crate::mesh::Assembly`] of it, and [`write()`] goes the other way. A deck has no units; read here, it must
//! be in SI (m, N, kg, Pa).
//!
//! | keyword | read as |
//! |---|---|
//! | `*NODE`, `*SYSTEM` | global coordinates; rectangular, cylindrical or spherical |
//! | `*ELEMENT` | `C3D8` (B-bar), `C3D8I`, `C3D8R`, `C3D20`, `C3D20R`, `C3D4`, `C3D10`, `C3D6`, `C3D15`; `B31`, `B32`; `MASS`, `ROTARYI`, `SPRING1`, `DCOUP3D` |
//! | `*PART`, `*INSTANCE`, `*ASSEMBLY` | copies, moved, then turned; names become `INSTANCE.NAME` and `INSTANCE.12` |
//! | `*NSET`, `*ELSET`, `*SURFACE` | sets (listed, generated, nested); element faces `S1`-`S6`, or nodes with weights |
//! | `*MATERIAL`, `*ELASTIC`, `*DENSITY`, `*SOLID SECTION` | isotropic, at one temperature |
//! | `*SPRING` | of `SPRING1`: to the ground |
//! | `*BEAM SECTION` | `CIRC` and `RECT` of `B31` and `B32`: shanks between nodes, which gain rotations |
//! | `*MASS`, `*ROTARY INERTIA` | of `MASS` and `ROTARYI`: at a node; inertia of rotation where the node has rotations |
//! | `*RIGID BODY` | of a node or element set: kinematic coupling of its reference node |
//! | `*PRE-TENSION SECTION` | of a beam or of a surface through solids: the overlap at a cut, loaded by `*CLOAD` on component 1 of its node |
//! | `*TIE` | slave nodes on master faces (node to surface, whatever `TYPE` says) |
//! | `*COUPLING` with `*DISTRIBUTING` or `*KINEMATIC`; `*DISTRIBUTING COUPLING`, `*KINEMATIC COUPLING` | couplings |
//! | `*EQUATION`, `*MPC` (`BEAM`, `LINK`, `PIN`, `TIE`) | equations, rigid links |
//! | `*BOUNDARY` | supports: of the model in the assembly; of a step kept with the step |
//! | `*STEP`, `*CLOAD`, `*SUBSTRUCTURE LOAD CASE`, `*LOAD CASE` | one load pattern per step or case, of its own loads |
//! | `*INCLUDE` | the file, relative to the one that includes it; see [`Includes`] |
//!
//! Shells, membranes, plane and rigid elements, trusses and beams that preprocessors write beside the solids have no stiffness
//! without a section: they are left out, with a note in [`Deck::notes`]. With a section they are an error.
//!
//! [`SolidMesh`] reads nodes, elements, sets and surfaces alone, and lists the other keywords.
//!
//! Keywords that only ask for output are listed in [`Deck::ignored`], those that choose an analysis in
//! [`Step::procedures`]. Any other keyword or parameter may change the mechanics, and is an error that names file, line
//! and remedy.
//!
//! Names are compared without regard to case. Sets grow when they are named again, are sorted by label unless
//! `UNSORTED`, and may only hold what exists.
//!
//! **Weights of distributing couplings.** On element surfaces a node's weight is its tributary area, as in both codes
//! (the integral of its shape function; on quadratic triangles the area is shared by the middles of the edges, which is
//! that integral on a flat face). On quadrilaterals of eight nodes the integrals are negative at the corners; half of each goes
//! to the two middles beside it. On node surfaces it is the second entry of the data line, or one. With
//! `COUPLING=STRUCTURAL` Abaqus also averages nodal rotations; solids have none, so that it makes no difference here.
//!
//! **Beams.** A beam is a [`Shank`](crate::mesh::Shank); `B32` is two of them, which is exact for loads at its nodes. Without a pretension
//! section its overlap is held. Both codes name circles `CIRC`, with one entry, the radius, in Abaqus, and two, the diameters, in
//! CalculiX; the number of entries decides. A beam that ends at a node of a solid is hinged there, as in Abaqus:
//! the node gains rotations that only the beam resists.
//!
//! **Pretension sections.** A load on the node is tension, and zero displacement of it holds the section together, as in both codes.
//! The overlap of a beam holds its own elongation, as in Abaqus; CalculiX takes the beam to be rigid along its axis.
//!
//! **Tolerance of ties.** Without `POSITION TOLERANCE`, slaves are tied within 5 % of the typical element size in the
//! master surface, as in Abaqus; the size is taken to be the mean length of the edges of its faces. Slaves beyond stay
//! free.
//!
//! Sources of the formats: the keyword guides of Abaqus (6.6 to 2024) and CalculiX.

mod assembly;
mod beams;
mod connections;
mod constraints;
mod deck;
mod expand;
mod facets;
mod geometry;
mod history;
mod keywords;
mod model;
mod phases;
mod properties;
mod reader;
mod solid;
mod text;
mod write;

pub use super::includes::Includes;
pub use assembly::Choices;
pub use deck::{
    AtComponents, Deck, DeckBeam, DeckBeamSection, DeckCoupling, DeckCouplingKind, DeckEquation, DeckInertia, DeckMass,
    DeckMaterial, DeckPretension, DeckSpring, DeckTie, Ignored, Label, Line, Link, LinkKind, LoadCase, Members, Node,
    PretensionOf, Solid, Step, Surface,
};
pub use model::DeckModel;
pub use write::write;

use super::solid_mesh::SolidMesh;
use crate::Error;
use keywords::Extent;
use std::path::{Path, PathBuf};

/// Reads a deck and the files that it includes: at most 1000, 10 deep, and all together no more than
/// [`file_io::input::Kind::Deck`] allows.
///
/// # Errors
/// [`Error::InputFile`] if the file cannot be read; [`Error::Deck`] naming file and line of the first defect.
pub fn read(path: impl AsRef<Path>, includes: Includes) -> Result<Deck, Error> {
    let limit = file_io::input::Kind::Deck.limit();
    phases::run(&text::Source::from_file(path.as_ref(), includes, limit)?)
}

/// The files of a deck: itself, and those that it includes, in the order of the lines that include them.
///
/// # Errors
/// As [`read`], of the files and the lines that include them alone.
pub fn files(path: impl AsRef<Path>, includes: Includes) -> Result<Vec<PathBuf>, Error> {
    let limit = file_io::input::Kind::Deck.limit();
    Ok(text::Source::from_file(path.as_ref(), includes, limit)?.paths)
}

/// Reads a deck from its text; `name` stands for the file in messages.
///
/// # Errors
/// As [`read`]; `*INCLUDE` is refused.
pub fn parse(text: &str, name: &str) -> Result<Deck, Error> {
    phases::run(&text::Source::from_text(name, text)?)
}

/// The solids, sets and surfaces of a deck and the files that it includes.
pub(super) fn solid_mesh_of_file(path: &Path) -> Result<SolidMesh, Error> {
    mesh_of(&text::Source::mesh_from_file(path)?)
}

/// The solids, sets and surfaces of a deck without includes.
pub(super) fn solid_mesh(name: &str, bytes: &[u8]) -> Result<SolidMesh, Error> {
    mesh_of(&text::Source::from_text(name, &String::from_utf8_lossy(bytes))?)
}

fn mesh_of(source: &text::Source) -> Result<SolidMesh, Error> {
    phases::read(source, Extent::Mesh)?
        .solid_mesh()?
        .finish(&source.files[0])
}
