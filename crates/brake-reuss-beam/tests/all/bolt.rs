//! Stiffness of the bolt model.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]
use brake_reuss_beam::geometry::Geometry;
use brake_reuss_beam::mesh::{Refinement, build};
use brake_reuss_beam::published;
use finite_elements::assemble::System;
use finite_elements::factor::SparseCholesky;
use finite_elements::mesh::Dof;
use joint_model::benchmark::ElementOrder;

/// Force per axial strain in the middle of a shank (N).
fn force_per_strain(geometry: &Geometry) -> f64 {
    let steel = published::steel();
    let mut beam = build(geometry, &Refinement::quick(), ElementOrder::Linear, &steel, 1.0).unwrap();
    // The interface is held, so that the bolt's load runs through washers and half-beams alone.
    let held = beam.top_nodes.iter().chain(&beam.bottom_nodes);
    beam.assembly.supports = held.flat_map(|&node| (0..3).map(move |c| Dof::Node(node, c))).collect();
    let system = System::try_new(&beam.assembly).unwrap();
    let factor = SparseCholesky::try_new(&system.stiffness, &system.positions, "held beam").unwrap();
    let mut u = faer::Mat::from_fn(system.n_dofs(), 1, |i, _| system.loads[1][i]);
    factor.solve_in_place(u.as_mut());
    let mesh = &beam.assembly.mesh;
    let part = beam.parts.iter().find(|part| part.name == "shank_2").unwrap();
    let mut nodes: Vec<u32> = mesh.elements[part.elements.clone()]
        .iter()
        .flat_map(|element| element.cell.nodes().to_vec())
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    let z = |node: u32| mesh.nodes[node as usize][2];
    let levels = |wanted: f64| {
        let nearest = nodes
            .iter()
            .map(|&n| z(n))
            .min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs()));
        let level = nearest.unwrap();
        let there: Vec<u32> = nodes.iter().copied().filter(|&n| (z(n) - level).abs() < 1e-9).collect();
        let displacement = |node: u32| -> f64 {
            let terms = system.dofs.row(3 * node as usize + 2);
            terms.map(|(i, factor)| factor * u[(i, 0)]).sum()
        };
        let mean = there.iter().map(|&n| displacement(n)).sum::<f64>() / there.len() as f64;
        (level, mean)
    };
    let reach = 0.25 * geometry.height;
    let ((low, u_low), (high, u_high)) = (levels(-reach), levels(reach));
    let strain = (u_high - u_low) / (high - low);
    strain.abs().recip()
}

#[test]
fn tension_stretches_the_shank_as_a_rod() {
    let steel = published::steel();
    let geometry = Geometry::default();
    let slope = force_per_strain(&geometry);
    let rod = steel.youngs_modulus * 0.25 * std::f64::consts::PI * geometry.shank_diameter.powi(2);
    println!(
        "{slope:.4e} N per strain, as a rod {rod:.4e} N, published {:.4e} N",
        published::BOLT_TENSION_PER_STRAIN
    );
    // A polygon in the circle has less area.
    assert!((0.96..1.0).contains(&(slope / rod)), "{slope} {rod}");
    // The bolts of the experiment were modified to take strain gauges: two thirds of the shank's section are left.
    let left = published::BOLT_TENSION_PER_STRAIN / rod;
    assert!((0.6..0.7).contains(&left), "{left}");
}
