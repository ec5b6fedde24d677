//! Frequencies of two masses on springs: `cargo run --release -p dense-algebra --example pair`.
#![allow(clippy::print_stdout, reason = "example")]

use dense_algebra::{product, symmetric_pair};
use faer::mat;

fn main() -> Result<(), dense_algebra::Error> {
    // Wall, 3 kN/m, 2 kg, 1 kN/m, 1 kg.
    let stiffness = mat![[4000.0, -1000.0], [-1000.0, 1000.0]];
    let mass = mat![[2.0, 0.0], [0.0, 1.0]];
    let (eigenvalues, shapes) = symmetric_pair(stiffness.as_ref(), mass.as_ref())?;
    for (mode, w2) in eigenvalues.iter().enumerate() {
        let shape = shapes.col(mode);
        println!("{:.4} rad/s, shape [{:.4}, {:.4}]", w2.sqrt(), shape[0], shape[1]);
    }
    let modal_mass = product(shapes.transpose(), product(mass.as_ref(), shapes.as_ref()).as_ref());
    println!("modal mass {modal_mass:.3?}");
    Ok(())
}
