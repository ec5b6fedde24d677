//! One quadrilateral under a uniform jump: `cargo run --release -p zte-assembly --example one_quad`.
#![allow(clippy::print_stdout, reason = "example")]

use contact_laws::Sticking::Coulomb;
use contact_laws::{ElasticCurves, ElasticDryFriction, HistoryRule, PointParameters};
use std::sync::Arc;
use zte_assembly::{Element, Interface, InterfaceMesh, Operators};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 4 mm x 2 mm with 2 x 2 Gauss points.
    let nodes = vec![[0.0, 0.0], [4e-3, 0.0], [4e-3, 2e-3], [0.0, 2e-3]];
    let elements = vec![Element::quad4([0, 1, 2, 3])];
    let operators = Operators::try_new(&InterfaceMesh::flat(nodes, elements), 2)?;
    let n = operators.n_points();
    println!("area {:.1e} m^2, {n} points", operators.area());

    // k_n = 3e13 Pa/m, k_x = k_y = 2e13 Pa/m, mu = 0.3, no gap.
    let curves = PointParameters::uniform(ElasticCurves::try_new(3e13, [2e13; 2])?, n);
    let law = ElasticDryFriction::try_new(curves, PointParameters::uniform(0.3, n), HistoryRule::Incremental)?;
    let interface = Interface::try_new(Arc::new(operators), vec![(0..n, Arc::new(law))], vec![0.0; n])?;

    let (begin, mut points) = (interface.initial_state(), interface.workspace());
    let mut end = begin.clone();
    let mut force = vec![0.0; interface.n_dofs()];
    for u_x in [2e-7, 2e-6] {
        let jump = [u_x, 0.0, 1e-6].repeat(4);
        let counts = interface.evaluate(&jump, Coulomb, &begin, &mut end, &mut points, &mut force, None);
        let resultant = [0, 1, 2].map(|c| force.iter().skip(c).step_by(3).sum::<f64>());
        println!(
            "u_x {u_x:.0e} m: resultant {resultant:.1?} N, {} points slip",
            counts.slip
        );
    }
    Ok(())
}
