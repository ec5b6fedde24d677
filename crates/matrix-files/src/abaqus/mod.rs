//! Matrices that Abaqus writes as text (`.mtx`).
//!
//! Two kinds of files share the extension:
//!
//! - `*SUBSTRUCTURE MATRIX OUTPUT, OUTPUT FILE=USER DEFINED` writes the layout of a linear `*USER ELEMENT` (Abaqus
//!   Analysis User's Guide, "Defining substructures" and "User-defined elements"), with comments for what an input file
//!   has no place for. See [`parse_substructure`].
//! - `*MATRIX OUTPUT, FORMAT=MATRIX INPUT` writes assembled matrices as lines
//!   `node, component, node, component, value`. See [`parse_assembled`].
//!
//! CalculiX writes the first kind too (`*SUBSTRUCTURE GENERATE`).

mod assembled;
mod substructure;
mod writer;

pub use assembled::parse_assembled;
pub use substructure::{Recovery, Substructure, parse_substructure, read_substructure};
pub use writer::substructure_to_bytes;
