//! File formats: each a module that reads bytes or text into the types of [`crate::mesh`], and writes them.
//!
//! | module | files | holds |
//! |---|---|---|
//! | [`abaqus`] | input decks of Abaqus and CalculiX (`.inp`) | whole assemblies |
//! | [`gmsh`] | MSH 4.1 | meshes, materials, lists of faces and nodes |
//! | [`vtu`] | VTK unstructured grids | meshes and surfaces with fields |
//!
//! What elements are called in a format, and in which order it lists their nodes, stands in the table of
//! [`crate::elements`].

pub mod abaqus;
mod common;
pub mod gmsh;
pub mod vtu;
