//! Blocks of hexahedra, and the closed form of a beam, for tests of whole structures.

use finite_elements::elements::Formulation;
use finite_elements::mesh::{Cell, Element, Material, Mesh};

pub(crate) fn steel() -> Material {
    Material {
        name: "steel".into(),
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
        density: 7857.8,
    }
}

/// Adds a block of `cells` from `corner` with edge lengths `size`; returns its nodes in x-fastest order.
pub(crate) fn add_block(mesh: &mut Mesh, corner: [f64; 3], size: [f64; 3], cells: [usize; 3]) -> Vec<u32> {
    let base = mesh.nodes.len() as u32;
    let [nx, ny, nz] = cells;
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let at = [i as f64 / nx as f64, j as f64 / ny as f64, k as f64 / nz as f64];
                mesh.nodes.push([0, 1, 2].map(|c| corner[c] + size[c] * at[c]));
            }
        }
    }
    let node = |i, j, k| base + (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let cell = Cell::hex8(
                    [
                        node(i, j, k),
                        node(i + 1, j, k),
                        node(i + 1, j + 1, k),
                        node(i, j + 1, k),
                        node(i, j, k + 1),
                        node(i + 1, j, k + 1),
                        node(i + 1, j + 1, k + 1),
                        node(i, j + 1, k + 1),
                    ],
                    Formulation::IncompatibleModes,
                );
                mesh.elements.push(Element { cell, material: 0 });
            }
        }
    }
    (base..mesh.nodes.len() as u32).collect()
}

pub(crate) fn plane(mesh: &Mesh, nodes: &[u32], axis: usize, at: f64) -> Vec<u32> {
    nodes
        .iter()
        .copied()
        .filter(|&n| (mesh.nodes[n as usize][axis] - at).abs() < 1e-12)
        .collect()
}

/// Free-free bending frequencies of a Timoshenko beam with square section (Hz).
///
/// Frequency equation of Huang (1961, DOI 10.1115/1.3641787), shear coefficient of Cowper (1966).
pub(crate) fn timoshenko(length: f64, side: f64, n: usize) -> Vec<f64> {
    let m = steel();
    let shear = m.youngs_modulus / (2.0 * (1.0 + m.poisson_ratio));
    let kappa = 10.0 * (1.0 + m.poisson_ratio) / (12.0 + 11.0 * m.poisson_ratio);
    let (area, inertia) = (side * side, side.powi(4) / 12.0);
    let bending = m.youngs_modulus * inertia;
    let r2 = inertia / (area * length * length);
    let s2 = bending / (kappa * area * shear * length * length);
    let equation = |omega: f64| {
        let b = omega * (m.density * area * length.powi(4) / bending).sqrt();
        let root = ((r2 - s2).powi(2) + 4.0 / (b * b)).sqrt();
        let alpha = ((root - (r2 + s2)) / 2.0).sqrt();
        let beta = ((root + (r2 + s2)) / 2.0).sqrt();
        let factor = b / (1.0 - b * b * r2 * s2).sqrt() * (b * b * r2 * (r2 - s2).powi(2) + (3.0 * r2 - s2));
        2.0 - 2.0 * (b * alpha).cosh() * (b * beta).cos() + factor * (b * alpha).sinh() * (b * beta).sin()
    };
    let mut found = Vec::new();
    let step = 1.0;
    let mut f = 20.0;
    while found.len() < n {
        let (mut lo, mut hi) = (f, f + step);
        let two_pi = 2.0 * std::f64::consts::PI;
        if equation(two_pi * lo) * equation(two_pi * hi) <= 0.0 {
            for _ in 0..60 {
                let mid = 0.5 * (lo + hi);
                if equation(two_pi * lo) * equation(two_pi * mid) <= 0.0 {
                    hi = mid
                } else {
                    lo = mid
                }
            }
            found.push(0.5 * (lo + hi));
        }
        f += step;
    }
    found
}
