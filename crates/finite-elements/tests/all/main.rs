//! The tests of the public interface, in one program: one file for each subject.

mod blocks;

mod bolts_of_decks;
mod deck;
mod deck_reference;
mod elements;
mod elimination;
mod foreign_meshes;
mod mesh_files;
mod quadratic;
mod shanks;
mod solid_mesh;
mod structures;
mod superelements;
