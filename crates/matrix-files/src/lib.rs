//! Readers and writers of the matrix files that structural-dynamics programs exchange.
//!
//! | module | files |
//! |---|---|
//! | [`matrix_market`] | `.mtx`, `.mm`: one matrix as text |
//! | [`mat`] | `.mat`, level 5 (`-v6`, `-v7`) and HDF5 (`-v7.3`) |
//! | [`npz`] | `.npz`, with sparse matrices as `scipy.sparse.save_npz` lays them out; `.npy` |
//! | [`abaqus`] | `.mtx` of `*SUBSTRUCTURE MATRIX OUTPUT` and `*MATRIX OUTPUT` |
//! | [`ansys`] | `.full` of Ansys |
//! | [`archive`] | members of any ZIP archive |
//! | [`calculix`] | `.sti`, `.mas`, `.dof` of `*FREQUENCY, SOLVER=MATRIXSTORAGE` |
//! | [`dmig`] | entries `DMIG` of Nastran's punch and bulk data files |
//! | [`op2`] | `.op2` of Nastran's `OUTPUT2`, matrices and tables `DMIG` |
//! | [`op4`] | `.op4` of Nastran's `OUTPUT4`, text and binary |
//!
//! Numbers are passed on as they stand, in the units of the file. Readers refuse what is not finite (but for
//! measurements), out of range, given twice or asymmetric where symmetry is stated; memory stays within a fixed
//! multiple of the file's size (of its unpacked size for compressed parts, which is at most 1032 times as large).
//! Writers return whole files as bytes.

pub mod abaqus;
pub mod ansys;
pub mod archive;
pub mod calculix;
mod columns;
pub mod dmig;
mod error;
mod fortran;
pub mod mat;
pub mod matrix_market;
pub mod npz;
pub mod op2;
pub mod op4;
mod text;
mod triplets;
pub mod value;
mod writing;

pub use error::Error;
