//! Frequencies of a free steel bar: `cargo run --release -p finite-elements --example free_bar`.
#![allow(clippy::print_stdout, reason = "example")]

use finite_elements::mesh::{Assembly, Cell, Element, Material};
use finite_elements::{assemble::System, eigen::lowest_modes, elements::Formulation};

fn main() -> Result<(), finite_elements::Error> {
    let mut bar = Assembly::default();
    bar.mesh.materials.push(Material {
        name: "steel".into(),
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
        density: 7857.8,
    });
    // 0.72 m x 25.4 mm x 25.4 mm in 36 x 2 x 2 hexahedra.
    let node = |i: u32, j: u32, k: u32| i + 37 * (j + 3 * k);
    for n in 0..37 * 3 * 3 {
        let (i, j, k) = (n % 37, n / 37 % 3, n / 111);
        bar.mesh
            .nodes
            .push([0.02 * f64::from(i), 0.0127 * f64::from(j), 0.0127 * f64::from(k)]);
        if i < 36 && j < 2 && k < 2 {
            // Corners counter-clockwise round the lower face, then round the upper one.
            let corner = |a: u32| node(i + a.div_ceil(2) % 2, j + a / 2 % 2, k + a / 4);
            let nodes = [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
            let cell = Cell::hex8(nodes, Formulation::IncompatibleModes);
            bar.mesh.elements.push(Element { cell, material: 0 });
        }
    }
    let system = System::try_new(&bar)?;
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 6, 1e-6)?;
    println!("mass {:.4} kg, {} components", system.total_mass, system.n_dofs());
    println!("{} rigid-body modes, then {:.2?} Hz", modes.n_zero, modes.frequencies());
    Ok(())
}
