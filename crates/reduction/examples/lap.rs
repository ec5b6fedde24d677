//! Two steel blocks, one on the other, reduced: `cargo run --release -p reduction --example lap`.
#![allow(clippy::print_stdout, reason = "example")]
use finite_elements::mesh::{Assembly, Cell, Element, Material};
use finite_elements::{assemble::System, elements::Formulation};
use reduction::{InterfacePairs, Limits, RelativeSystem, Settings, checks, reduce};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut blocks = Assembly::default();
    blocks.mesh.materials.push(Material {
        name: "steel".into(),
        youngs_modulus: 2e11,
        poisson_ratio: 0.3,
        density: 7800.0,
    });
    // Each block has 13 x 5 x 4 nodes; the second lies 9 mm higher and 20 mm farther along x, on the first.
    let node = |b: u32, i: u32, j: u32, k: u32| 260 * b + i + 13 * (j + 5 * k);
    for n in 0..520_u32 {
        let (b, i, j, k) = (n / 260, n % 13, n / 13 % 5, n / 65 % 4);
        let cells = [i + 4 * b, j, k + 3 * b].map(f64::from);
        let at = [5e-3 * cells[0], 5e-3 * cells[1], 3e-3 * cells[2]];
        blocks.mesh.nodes.push(at);
        if i < 12 && j < 4 && k < 3 {
            let corner = |a: u32| node(b, i + a.div_ceil(2) % 2, j + a / 2 % 2, k + a / 4);
            let nodes = [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
            let cell = Cell::hex8(nodes, Formulation::IncompatibleModes);
            blocks.mesh.elements.push(Element { cell, material: 0 });
        }
    }
    let bottom = &(0..45).map(|p| node(0, p % 9 + 4, p / 9, 3)).collect::<Vec<_>>();
    let top = &(0..45).map(|p| node(1, p % 9, p / 9, 0)).collect::<Vec<_>>();
    let frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]; // n points from top to bottom
    let system = System::try_new(&blocks)?;
    let relative = RelativeSystem::try_new(&system, InterfacePairs { top, bottom, frame })?;
    let reduced = reduce(&relative, &[], Settings::default(), Limits::default())?;
    let springs = sprs::CsMat::eye(relative.n_relative).map(|one: &f64| 1e7 * one);
    let full = checks::full_frequencies(&relative, Some(&springs), 4, 1e-7, Limits::default())?.1;
    let small = checks::reduced_spectrum(&reduced, &springs, 4)?.frequencies;
    println!("full [Hz] {full:.1?}, reduced to {} {small:.1?}", reduced.size());
    Ok(())
}
