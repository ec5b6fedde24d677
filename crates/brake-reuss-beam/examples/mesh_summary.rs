//! Meshes the beam at every preset and prints what came out.
#![expect(clippy::print_stdout, reason = "an example prints")]
use brake_reuss_beam::{geometry::Geometry, mesh, published, quality};
use joint_model::benchmark::ElementOrder;

fn main() -> brake_reuss_beam::Result<()> {
    let (geometry, steel) = (Geometry::default(), published::steel());
    println!("preset    interface    nodes elements  mass [kg]  area [mm2]  least scaled Jacobian");
    for (name, refinement) in mesh::Refinement::presets(ElementOrder::Linear) {
        let beam = mesh::build(
            &geometry,
            &refinement,
            ElementOrder::Linear,
            &steel,
            published::BOLT_TENSION,
        )?;
        let solid = &beam.assembly.mesh;
        let jacobian = solid
            .elements
            .iter()
            .map(|e| quality::scaled_jacobian(solid, e))
            .fold(1.0, f64::min);
        println!(
            "{name:<8} {:>5} quads {:>8} {:>8} {:>10.5} {:>11.3} {:>10.3}",
            beam.interface.elements.len(),
            solid.nodes.len(),
            solid.elements.len(),
            quality::mass(solid),
            1e6 * beam.interface.areas().iter().sum::<f64>(),
            jacobian,
        );
    }
    Ok(())
}
