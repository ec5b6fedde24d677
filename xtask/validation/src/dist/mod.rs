//! What is published: the program for people without Rust, with all that must come with it.

pub mod archive;
pub mod build;
pub mod elf;
pub mod licences;
pub mod process;
pub mod sbom;
pub mod sources;
pub mod text;
pub mod trial;
