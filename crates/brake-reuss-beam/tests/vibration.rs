//! Frequencies of the mesh against an independent code on another mesh of the same beam.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]
use brake_reuss_beam::geometry::Geometry;
use brake_reuss_beam::mesh::{Refinement, build, half_beam};
use brake_reuss_beam::published;
use substructure::assemble::System;
use substructure::eigen::lowest_modes;
use substructure::hex8::Formulation;
use substructure::mesh::{Assembly, Dof, Equation};

fn modes(assembly: &Assembly, n_elastic: usize) -> (usize, Vec<f64>) {
    let system = System::try_new(assembly, Formulation::IncompatibleModes).unwrap();
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, n_elastic, 1e-7).unwrap();
    (modes.n_zero, modes.frequencies())
}

fn compare(ours: &[f64], theirs: &[f64], tolerance: f64) {
    assert!(ours.len() >= theirs.len());
    let mut worst = 0.0_f64;
    for (ours, theirs) in ours.iter().zip(theirs) {
        let difference = ours / theirs - 1.0;
        println!("{ours:10.3} Hz against {theirs:10.3} Hz: {:+.3} %", 100.0 * difference);
        worst = worst.max(difference.abs());
    }
    assert!(worst < tolerance, "{worst}");
}

#[test]
fn free_half_beam_has_the_independent_frequencies() {
    let mesh = half_beam(&Geometry::default(), &Refinement::default(), &published::steel()).unwrap();
    let assembly = Assembly {
        mesh,
        ..Assembly::default()
    };
    let (n_zero, frequencies) = modes(&assembly, 7);
    assert_eq!(n_zero, 6);
    compare(&frequencies, &published::HALF_BEAM_FREQUENCIES, 3e-3);
}

#[test]
fn stuck_beam_has_the_independent_frequencies() {
    let mut beam = build(
        &Geometry::default(),
        &Refinement::default(),
        &published::steel(),
        published::BOLT_LOAD,
    )
    .unwrap();
    for (&top, &bottom) in beam.top_nodes.iter().zip(&beam.bottom_nodes) {
        for component in 0..3 {
            beam.assembly.equations.push(Equation {
                name: "stuck".to_owned(),
                terms: vec![(Dof::Node(top, component), 1.0), (Dof::Node(bottom, component), -1.0)],
            });
        }
    }
    let (n_zero, frequencies) = modes(&beam.assembly, 10);
    assert_eq!(n_zero, 6);
    compare(&frequencies, &published::STUCK_FREQUENCIES, 3e-3);
}

#[test]
fn unstressed_assembly_has_seven_zero_energy_modes() {
    // Six rigid motions, and the half-beams moving apart along the bolts.
    for refinement in [Refinement::quick(), Refinement::coarse()] {
        let beam = build(
            &Geometry::default(),
            &refinement,
            &published::steel(),
            published::BOLT_LOAD,
        )
        .unwrap();
        assert_eq!(modes(&beam.assembly, 3).0, 7);
    }
}
