//! Frequencies of the mesh against an independent code on another mesh of the same beam.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]
use brake_reuss_beam::geometry::Geometry;
use brake_reuss_beam::identification::material_of_half_beam;
use brake_reuss_beam::mesh::{Refinement, build, half_beam, uniform_bar};
use brake_reuss_beam::published;
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::mesh::{Assembly, Dof, Equation};
use joint_model::benchmark::ElementOrder;

fn modes(assembly: &Assembly, n_elastic: usize) -> (usize, Vec<f64>) {
    let system = System::try_new(assembly).unwrap();
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
fn material_is_identified_from_mass_and_frequency_of_an_independent_half_beam() {
    let steel = published::steel();
    let identify = |mass, frequency| {
        material_of_half_beam(
            &Geometry::default(),
            &Refinement::default(),
            steel.poisson_ratio,
            mass,
            frequency,
        )
    };
    let found = identify(published::HALF_BEAM_MASS, published::HALF_BEAM_FREQUENCIES[0]).unwrap();
    // The other code's half-beam has holes of 32-gons and other tolerances; its modulus is the paper's.
    assert!((found.density / steel.density - 1.0).abs() < 2e-3, "{}", found.density);
    assert!(
        (found.youngs_modulus / steel.youngs_modulus - 1.0).abs() < 5e-3,
        "{}",
        found.youngs_modulus
    );
    assert!(identify(-1.0, 600.0).unwrap_err().to_string().contains("mass = -1 kg"));
}

#[test]
fn stuck_beam_has_the_independent_frequencies() {
    let mut beam = build(
        &Geometry::default(),
        &Refinement::default(),
        ElementOrder::Linear,
        &published::steel(),
        published::BOLT_TENSION,
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
            ElementOrder::Linear,
            &published::steel(),
            published::BOLT_TENSION,
        )
        .unwrap();
        assert_eq!(modes(&beam.assembly, 3).0, 7);
    }
}

#[test]
fn uniform_bar_bends_like_a_timoshenko_beam() {
    // First free-free bending frequencies (Hz) of a 720 x 25.4 x 25.4 mm steel bar: roots of Huang's frequency equation
    // (1961, DOI 10.1115/1.3641787) with Cowper's shear coefficient 10 (1 + nu) / (12 + 11 nu).
    const TIMOSHENKO: [f64; 3] = [248.395_729, 679.116_161, 1_315.779_694];
    let mesh = uniform_bar(0.72, 0.0254, 0.0254, 120, 8, 8, &published::steel()).unwrap();
    let assembly = Assembly {
        mesh,
        ..Assembly::default()
    };
    let (n_zero, frequencies) = modes(&assembly, 6);
    assert_eq!(n_zero, 6);
    // A square section bends alike in both directions.
    let pairs: Vec<f64> = TIMOSHENKO.iter().flat_map(|&f| [f, f]).collect();
    compare(&frequencies, &pairs, 3e-3);
}
