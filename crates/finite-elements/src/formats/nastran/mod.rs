//! Bulk data of Nastran and Optistruct (`.bdf`, `.nas`, `.fem`): the mesh and what names its parts.
//!
//! | card | read |
//! |---|---|
//! | `GRID`, `GRDSET` | nodes, in any coordinate system |
//! | `CORD1R`, `CORD1C`, `CORD1S`, `CORD2R`, `CORD2C`, `CORD2S` | coordinate systems |
//! | `CTETRA`, `CPENTA`, `CHEXA` | solids; those of each property `N` are the group `PSOLID=N` |
//! | `CTRIA3`, `CTRIA6`, `CTRIAR`, `CQUAD4`, `CQUAD8`, `CQUADR` | facets; those of each property are the group `PSHELL=N` |
//! | `PLOAD4`, `BSURFS` | faces of solids: the groups `PLOAD4=N` and `BSURFS=N` |
//! | `SPC`, `SPC1`, `SET1` | groups of nodes: `SPC=N`, `SET=N` |
//! | `CBAR`, `CBEAM`, `CROD`, `CBUSH`, `RBE2` | the nodes of each property, of each rigid element: groups of nodes `CBAR=N`, ... |
//! | `MAT1`, `PSOLID` | a note says what the file gives for each material |
//! | `INCLUDE` | the file, relative to the one that includes it |
//!
//! Fields may be free, small or large. Names that HyperMesh and Femap give to properties in comments are names of the groups.
//! Case control and all other cards are named in a note.
//!
//! Format: MSC Nastran Quick Reference Guide.

mod cards;
mod solid;
mod systems;

use super::solid_mesh::SolidMesh;
use crate::Error;
use cards::Source;
use std::path::{Path, PathBuf};

/// The mesh of a file and all that it includes from its folder and below.
pub(super) fn solid_mesh_of_file(path: &Path) -> Result<SolidMesh, Error> {
    solid::read(&Source::from_file(path)?)
}

/// The mesh of a file without includes.
pub(super) fn solid_mesh(file: &str, bytes: &[u8]) -> Result<SolidMesh, Error> {
    solid::read(&Source::from_bytes(file, bytes)?)
}

/// The file and those that it includes.
pub(super) fn files(path: &Path) -> Result<Vec<PathBuf>, Error> {
    Ok(Source::from_file(path)?.paths)
}
