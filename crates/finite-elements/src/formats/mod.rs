//! File formats: each a module that reads bytes or text into the types of [`crate::mesh`], and writes them.
//!
//! | module | files | holds |
//! |---|---|---|
//! | [`abaqus`] | input decks of Abaqus and CalculiX (`.inp`) | whole assemblies |
//! | [`gmsh`] | MSH 4.1 and 2.2 (text, binary) | meshes, materials, lists of faces and nodes |
//! | [`nastran`] | bulk data of Nastran and Optistruct (`.bdf`, `.nas`, `.fem`) | meshes and groups |
//! | [`ansys`] | archives of Ansys (`.cdb`) | meshes and components |
//! | [`exodus`] | Exodus II (`.exo`, `.e`, `.g`) | meshes, blocks and sets |
//! | [`med`] | MED files of Salome and code_aster (`.med`) | meshes and groups |
//! | [`universal`] | universal files of I-DEAS (`.unv`) | meshes and groups |
//! | [`vtu`] | VTK unstructured grids (text, base64, appended; zlib) | meshes and surfaces with fields |
//! | [`solid_mesh`] | any of these | solids and named groups, without materials and units |
//!
//! What elements are called in a format, and in which order it lists their nodes, stands in the table of
//! [`crate::elements`].

pub mod abaqus;
pub mod ansys;
mod common;
pub mod exodus;
pub mod gmsh;
mod includes;
mod labelled;
mod lines;
pub mod med;
pub mod nastran;
pub mod solid_mesh;
pub mod universal;
pub mod vtu;
