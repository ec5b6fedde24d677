//! Linear finite elements: hexahedra, ties, couplings, equations, sparse mass and stiffness, and eigenpairs.
pub mod mesh;
