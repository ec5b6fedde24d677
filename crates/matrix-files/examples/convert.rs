//! From Matrix Market to MATLAB and NumPy: `cargo run --release -p matrix-files --example convert`.
#![allow(clippy::print_stdout, reason = "example")]

use std::collections::BTreeMap;

use file_io::Source;
use matrix_files::value::{Array, Dof};
use matrix_files::{mat, matrix_market, npz};

fn main() -> Result<(), matrix_files::Error> {
    let text = "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 4000\n2 1 -1000\n2 2 1000\n";
    let stiffness = matrix_market::parse(Source {
        name: "stiffness.mtx",
        bytes: text.as_bytes(),
    })?;
    let dofs = [Dof::new(11, 3), Dof::new(12, 3)];
    let arrays = BTreeMap::from([("K".to_owned(), stiffness), ("dofs".to_owned(), Dof::table(&dofs))]);
    let (matlab, numpy) = (mat::to_bytes(&arrays)?, npz::to_bytes(&arrays)?);
    println!("{} bytes for MATLAB, {} for NumPy", matlab.len(), numpy.len());

    let back = mat::parse(Source {
        name: "model.mat",
        bytes: &matlab,
    })?;
    if let Some(Array::Sparse(k)) = back.arrays.get("K") {
        println!("K: {} x {}, {} entries", k.rows(), k.cols(), k.nnz());
    }
    Ok(())
}
