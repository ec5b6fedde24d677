//! File formats: each a module that reads bytes or text into the types of [`crate::mesh`], and writes them.
//!
//! | module | files | holds |
//! |---|---|---|
//! | [`abaqus`] | input decks of Abaqus and CalculiX (`.inp`) | whole assemblies |
//! | [`gmsh`] | MSH 4.1 and 2.2 (text, binary) | meshes, materials, lists of faces and nodes |
//! | [`vtu`] | VTK unstructured grids (text, base64, appended; zlib) | meshes and surfaces with fields |
//! | [`solid_mesh`] | any of these (`.msh`, `.inp`, `.vtu`) | solids and named groups, without materials and units |
//!
//! What elements are called in a format, and in which order it lists their nodes, stands in the table of
//! [`crate::elements`].

pub mod abaqus;
mod common;
pub mod gmsh;
pub mod solid_mesh;
pub mod vtu;
