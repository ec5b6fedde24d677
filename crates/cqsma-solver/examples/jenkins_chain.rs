//! Backbone of a chain with sliders: `cargo run --release -p cqsma-solver --example jenkins_chain`.
#![allow(clippy::print_stdout, reason = "example")]

use cqsma_solver::test_problems::JenkinsChain;
use cqsma_solver::{NewtonSettings, NoObserver, cqsma, modes, prestress};
use std::f64::consts::TAU;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Ten masses of 1 kg, springs of 2 kN/m, and from each mass to the ground 400 N/m that slides at 1 N.
    let chain = JenkinsChain::new(10, 2000.0, (400.0, 1.0));
    let (stiffness, mass) = (chain.stiffness.as_ref(), chain.mass.as_ref());
    let mut load = [0.0; 10];
    load[9] = 0.5;
    let newton = NewtonSettings::default();
    let rest =
        prestress::solve(stiffness, &chain.force, &load, &[0.0; 10], &newton)?.map_err(|failure| failure.reason)?;
    let mut structure = modes::linearise(stiffness, mass, &chain.force, rest.displacement, rest.state, 2)?;
    structure.orient(&[1.0; 10])?;
    println!("linearised modes [Hz]: {:.4?}", structure.frequencies());

    let forces: Vec<f64> = (0..8).map(|i| 0.5 * 2.0_f64.powi(i)).collect();
    let settings = cqsma::Settings {
        vertices_per_quarter: 32,
        ..Default::default()
    };
    for (point, _) in cqsma::run(&structure, &chain.force, &forces, &settings, |_| NoObserver)? {
        let r = point.result.map_err(|failure| failure.reason)?;
        let (alpha, q, f) = (point.modal_force, r.modal_amplitude, r.omega / TAU);
        println!("alpha {alpha:5.1}   q {q:.4e}   f {f:.4} Hz   zeta {:9.2e}", r.zeta);
    }
    Ok(())
}
