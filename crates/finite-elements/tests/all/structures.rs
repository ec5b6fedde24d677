//! Whole structures against closed forms: bars, ties, couplings and the modes of free bodies.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use crate::blocks::{add_block, plane, steel, timoshenko};
use faer::Mat;
use finite_elements::Error;
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::elements::Formulation;
use finite_elements::factor::SparseCholesky;
use finite_elements::mesh::{
    Assembly, BeyondTolerance, Coupling, CouplingKind, Dof, Equation, Face, GroundSpring, LoadPattern, Mesh, PointMass,
    Tie,
};
use finite_elements::sparse::multiply_vector;

fn bar(cells: [usize; 3], size: [f64; 3]) -> Assembly {
    let mut mesh = Mesh {
        materials: vec![steel()],
        ..Mesh::default()
    };
    add_block(&mut mesh, [0.0; 3], size, cells);
    Assembly {
        mesh,
        ..Assembly::default()
    }
}

#[test]
fn free_bar_bends_like_a_timoshenko_beam() {
    let (length, side) = (0.72, 0.0254);
    let system = System::try_new(&bar([96, 6, 6], [length, side, side])).unwrap();
    assert!((system.total_mass / (7857.8 * length * side * side) - 1.0).abs() < 1e-11);
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 8, 1e-6).unwrap();
    assert_eq!(modes.n_zero, 6);
    let f = modes.frequencies();
    let theory = timoshenko(length, side, 3);
    // Bending comes in pairs; torsion and extension lie above the third pair. Beam theory itself is good to 0.3 %
    // at the third pair, where the wavelength is ten times the depth.
    for (pair, expected) in theory.iter().enumerate() {
        for f in &f[2 * pair..2 * pair + 2] {
            assert!((f / expected - 1.0).abs() < 3e-3, "pair {pair}: {f} against {expected}");
        }
    }
}

#[test]
fn a_translation_moves_the_whole_mass_held_or_not() {
    let mut free = bar([6, 2, 2], [0.3, 0.02, 0.03]);
    free.masses = vec![PointMass { node: 40, mass: 0.25 }];
    let whole = System::try_new(&free).unwrap();
    for momentum in &whole.momenta {
        assert!((momentum.iter().sum::<f64>() / whole.total_mass - 1.0).abs() < 1e-12);
    }
    // With an end held, what is left has the momentum that it has in the whole, that of held neighbours included.
    let held: Vec<u32> = plane(
        &free.mesh,
        &(0..free.mesh.nodes.len() as u32).collect::<Vec<_>>(),
        0,
        0.0,
    );
    let mut clamped = free.clone();
    clamped.supports = held
        .iter()
        .flat_map(|&node| (0..3).map(move |component| Dof::Node(node, component)))
        .collect();
    let part = System::try_new(&clamped).unwrap();
    assert_eq!(part.total_mass, whole.total_mass);
    for (momentum, all) in part.momenta.iter().zip(&whole.momenta) {
        for (value, full) in momentum.iter().zip(&part.dofs.independent) {
            let place = whole.dofs.independent.binary_search(full).unwrap();
            assert!((value - all[place]).abs() < 1e-15 * whole.total_mass);
        }
    }
}

#[test]
fn incompatible_modes_do_not_lock_and_full_integration_does() {
    let first = |formulation| {
        let mut bar = bar([36, 1, 1], [0.72, 0.0254, 0.0254]);
        bar.mesh.set_formulation(formulation);
        let system = System::try_new(&bar).unwrap();
        lowest_modes(&system.stiffness, &system.mass, &system.positions, 2, 1e-6)
            .unwrap()
            .frequencies()[0]
    };
    let expected = timoshenko(0.72, 0.0254, 1)[0];
    assert!((first(Formulation::IncompatibleModes) / expected - 1.0).abs() < 0.01);
    assert!(first(Formulation::Full) / expected > 1.05);
}

#[test]
fn modes_of_a_nearly_incompressible_bar_are_found() {
    // The bulk modulus is up to 5e4 times the shear modulus, which the stiffest components feel most.
    let first = |poisson_ratio: f64| {
        let mut assembly = bar([24, 3, 3], [0.4, 0.02, 0.02]);
        assembly.mesh.materials[0].poisson_ratio = poisson_ratio;
        assembly.mesh.set_formulation(Formulation::BBar);
        let system = System::try_new(&assembly).unwrap();
        let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 8, 1e-6).unwrap();
        assert_eq!(modes.n_zero, 6);
        assert!(modes.residual < 1e-7, "{poisson_ratio}: {:e}", modes.residual);
        modes.frequencies()[0]
    };
    let usual = first(0.49);
    for poisson_ratio in [0.4999, 0.499_99] {
        let found = first(poisson_ratio);
        assert!((found / usual - 1.0).abs() < 0.01, "{poisson_ratio}: {found} {usual}");
    }
}

#[test]
fn bar_frequencies_converge_with_second_order() {
    let f = |n: usize| {
        let system = System::try_new(&bar([12 * n, n, n], [0.3, 0.025, 0.025])).unwrap();
        lowest_modes(&system.stiffness, &system.mass, &system.positions, 2, 1e-7)
            .unwrap()
            .frequencies()[0]
    };
    let (a, b, c) = (f(2), f(4), f(8));
    let order = ((a - b) / (b - c)).abs().log2();
    assert!((1.7..2.6).contains(&order), "order {order}: {a} {b} {c}");
}

/// Two stacked blocks with different meshes, the upper tied to the lower.
fn tied_blocks(offset: f64) -> Assembly {
    let mut mesh = Mesh {
        materials: vec![steel()],
        ..Mesh::default()
    };
    let lower = add_block(&mut mesh, [0.0; 3], [0.03, 0.02, 0.01], [3, 2, 1]);
    let upper = add_block(
        &mut mesh,
        [0.002, 0.003, 0.01 + offset],
        [0.025, 0.015, 0.01],
        [4, 5, 2],
    );
    let slave_nodes = plane(&mesh, &upper, 2, 0.01 + offset);
    let at = |i: u32, j: u32| lower[(i + 4 * (j + 3)) as usize];
    let master_faces = (0..2).flat_map(|j| (0..3).map(move |i| (i, j)));
    let master_faces = master_faces
        .map(|(i, j)| Face::quad4([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]))
        .collect();
    let tie = Tie {
        name: "glue".into(),
        slave_nodes,
        master_faces,
        position_tolerance: 1e-4,
        beyond: BeyondTolerance::Refuse,
        adjust: true,
    };
    Assembly {
        mesh,
        ties: vec![tie],
        ..Assembly::default()
    }
}

#[test]
fn a_tie_passes_constant_stress_and_rigid_motion() {
    let system = System::try_new(&tied_blocks(0.0)).unwrap();
    // A linear displacement field in equilibrium leaves no force on any independent inner component.
    let h = [[1e-3, 2e-4, 0.0], [2e-4, -7e-4, 0.0], [0.0, 0.0, 4e-4]];
    let field = |x: [f64; 3]| [0, 1, 2].map(|i| (0..3).map(|j| h[i][j] * x[j]).sum::<f64>());
    let u: Vec<f64> = system
        .dofs
        .independent
        .iter()
        .map(|dof| field(system.dofs.coordinates[dof / 3])[dof % 3])
        .collect();
    // The dependent nodes follow the same field.
    let all = multiply_vector(&system.dofs.transform, &u);
    for (node, x) in system.dofs.coordinates.iter().enumerate() {
        for (i, expected) in field(*x).into_iter().enumerate() {
            assert!((all[3 * node + i] - expected).abs() < 1e-16);
        }
    }
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 3, 1e-6).unwrap();
    assert_eq!(modes.n_zero, 6);
}

#[test]
fn a_slave_out_of_tolerance_is_refused_and_one_inside_is_moved() {
    let system = System::try_new(&tied_blocks(5e-5)).unwrap();
    assert!((system.dofs.largest_adjustment - 5e-5).abs() < 1e-12);
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 3, 1e-6).unwrap();
    assert_eq!(modes.n_zero, 6, "an adjusted tie lets the pair rotate freely");
    let error = System::try_new(&tied_blocks(5e-4)).unwrap_err();
    assert!(
        matches!(&error, Error::TieTooFar { tie, .. } if tie == "glue"),
        "{error}"
    );
}

/// Two separate bars whose facing end nodes are coupled at one point in all motions but the one along x.
fn sliding_bars() -> Assembly {
    let mut mesh = Mesh {
        materials: vec![steel()],
        ..Mesh::default()
    };
    let a = add_block(&mut mesh, [0.0; 3], [0.05, 0.01, 0.02], [5, 2, 2]);
    let b = add_block(&mut mesh, [0.06, 0.0, 0.0], [0.05, 0.01, 0.02], [5, 3, 2]);
    let coupling = |name: &str, nodes: Vec<u32>| Coupling {
        name: name.into(),
        reference: [0.055, 0.005, 0.01],
        kind: CouplingKind::Distributing(vec![1.0; nodes.len()]),
        nodes,
    };
    let couplings = vec![
        coupling("a", plane(&mesh, &a, 0, 0.05)),
        coupling("b", plane(&mesh, &b, 0, 0.06)),
    ];
    let equations = (1..6)
        .map(|c| Equation {
            name: format!("component {c}"),
            terms: vec![(Dof::Reference(0, c), 1.0), (Dof::Reference(1, c), -1.0)],
        })
        .collect();
    let pull = LoadPattern {
        name: "pull".into(),
        terms: vec![(Dof::Reference(0, 0), -7.0), (Dof::Reference(1, 0), 7.0)],
    };
    Assembly {
        mesh,
        couplings,
        equations,
        loads: vec![pull],
        ..Assembly::default()
    }
}

#[test]
fn couplings_and_equations_leave_exactly_the_free_motions() {
    let assembly = sliding_bars();
    let system = System::try_new(&assembly).unwrap();
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 3, 1e-6).unwrap();
    assert_eq!(modes.n_zero, 7, "six rigid motions and the sliding one");
    // The load is in equilibrium: no work on any common translation or rotation.
    let resultant = |motion: &dyn Fn([f64; 3]) -> [f64; 3]| -> f64 {
        let u = system
            .dofs
            .independent
            .iter()
            .map(|d| motion(system.dofs.coordinates[d / 3])[d % 3]);
        u.zip(&system.loads[0]).map(|(u, f)| u * f).sum()
    };
    assert!(resultant(&|_| [1.0, 0.0, 0.0]).abs() < 1e-12);
    assert!(resultant(&|x| [0.0, -x[2], x[1]]).abs() < 1e-12);
    assert!(resultant(&|x| [-x[1], x[0], 0.0]).abs() < 1e-12);
    // Opening by one metre does the work of the force.
    assert!((resultant(&|x| if x[0] > 0.055 { [1.0, 0.0, 0.0] } else { [0.0; 3] }) - 7.0).abs() < 1e-12);
}

#[test]
fn a_node_that_nothing_holds_is_refused_by_name() {
    let mut assembly = bar([2, 1, 1], [2.0, 1.0, 1.0]);
    let loose = assembly.mesh.nodes.len();
    assembly.mesh.nodes.push([0.5, 0.5, 1.0]);
    let error = System::try_new(&assembly).unwrap_err();
    assert!(
        matches!(error, Error::LooseNode { node, component: 0 } if node == loose),
        "{error}"
    );
    // An equation that ties it to the bar holds it.
    assembly.equations = (0..3_u8)
        .map(|c| Equation {
            name: format!("hold {c}"),
            terms: vec![(Dof::Node(loose as u32, c), 1.0), (Dof::Node(0, c), -1.0)],
        })
        .collect();
    assert!(System::try_new(&assembly).is_ok());
}

#[test]
fn redundant_circular_and_dangling_constraints_are_refused() {
    let mut assembly = sliding_bars();
    assembly.equations.push(assembly.equations[0].clone());
    let error = System::try_new(&assembly).unwrap_err();
    assert!(matches!(error, Error::RedundantEquation { .. }), "{error}");
    let mut assembly = sliding_bars();
    assembly.equations[0].terms[0].0 = Dof::Reference(9, 1);
    assert!(matches!(
        System::try_new(&assembly),
        Err(Error::Dangling { index: 9, .. })
    ));
    let mut assembly = sliding_bars();
    assembly.couplings[0].nodes.truncate(1);
    assembly.couplings[0].kind = CouplingKind::Distributing(vec![1.0]);
    assert!(matches!(System::try_new(&assembly), Err(Error::Coupling { .. })));
    let mut assembly = tied_blocks(0.0);
    assembly.ties.push(assembly.ties[0].clone());
    assert!(matches!(System::try_new(&assembly), Err(Error::DependentTwice { .. })));
    let mut assembly = bar([1, 1, 1], [1.0; 3]);
    assembly.mesh.materials[0].poisson_ratio = 0.5;
    let error = System::try_new(&assembly).unwrap_err();
    assert!(error.to_string().contains("poisson_ratio"), "{error}");
}

#[test]
fn sparse_solve_is_accurate_and_a_free_body_is_refused() {
    let system = System::try_new(&bar([20, 4, 4], [0.2, 0.02, 0.02])).unwrap();
    let n = system.n_dofs();
    let grounded = &system.stiffness + &system.mass.map(|m| 1e9 * m);
    let factor = SparseCholesky::try_new(&grounded, &system.positions, "test matrix").unwrap();
    let mut x = Mat::from_fn(n, 130, |i, j| ((i * 31 + j * 17) % 101) as f64 - 50.0);
    let b = x.clone();
    factor.solve_in_place(x.as_mut());
    for j in [0, 63, 64, 129] {
        let column: Vec<f64> = x.col(j).iter().copied().collect();
        let product = multiply_vector(&grounded, &column);
        let error = (0..n).map(|i| (product[i] - b[(i, j)]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-7, "{error}");
    }
    // Free bodies have round-off pivots of either sign; a negative shift makes the defect certain.
    let indefinite = &system.stiffness + &system.mass.map(|m| -1e6 * m);
    assert!(matches!(
        SparseCholesky::try_new(&indefinite, &system.positions, "free bar"),
        Err(Error::NotPositiveDefinite { .. })
    ));
}

#[test]
fn frequencies_do_not_depend_on_the_unit_system() {
    let frequencies = |length: f64, mass: f64| {
        // Lengths in `length` metres, masses in `mass` kilograms, seconds.
        let mut assembly = bar([12, 2, 2], [0.3 / length, 0.02 / length, 0.03 / length]);
        let material = &mut assembly.mesh.materials[0];
        material.youngs_modulus *= length / mass;
        material.density *= length.powi(3) / mass;
        let system = System::try_new(&assembly).unwrap();
        lowest_modes(&system.stiffness, &system.mass, &system.positions, 4, 1e-6)
            .unwrap()
            .frequencies()
    };
    for (si, mm) in frequencies(1.0, 1.0).iter().zip(frequencies(1e-3, 1e3)) {
        assert!((si / mm - 1.0).abs() < 1e-9, "{si} {mm}");
    }
}

#[test]
fn a_tie_that_is_not_adjusted_keeps_its_distance_and_costs_no_energy() {
    let mut assembly = tied_blocks(5e-5);
    assembly.ties[0].adjust = false;
    let system = System::try_new(&assembly).unwrap();
    assert_eq!(system.dofs.largest_adjustment, 0.0);
    assert_eq!(system.dofs.coordinates, assembly.mesh.nodes);
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 3, 1e-6).unwrap();
    assert_eq!(modes.n_zero, 6);
    // Rigid rotation of what is independent is rigid rotation of everything.
    let turn = |x: [f64; 3]| [3.0 * x[2] - x[1], x[0] + 2.0 * x[2], -2.0 * x[1] - 3.0 * x[0]];
    let dofs = &system.dofs;
    let u: Vec<f64> = dofs
        .independent
        .iter()
        .map(|d| turn(dofs.coordinates[d / 3])[d % 3])
        .collect();
    let all = multiply_vector(&dofs.transform, &u);
    for (node, &x) in dofs.coordinates.iter().enumerate() {
        for (i, expected) in turn(x).into_iter().enumerate() {
            assert!((all[3 * node + i] - expected).abs() < 1e-15, "{x:?}");
        }
    }
}

#[test]
fn slaves_beyond_the_tolerance_are_left_free_on_request_and_listed() {
    let mut assembly = tied_blocks(0.0);
    let strays: Vec<u32> = assembly.ties[0].slave_nodes[..3].to_vec();
    for &node in &strays {
        assembly.mesh.nodes[node as usize][2] += 3e-4;
    }
    assert!(matches!(System::try_new(&assembly), Err(Error::TieTooFar { .. })));
    assembly.ties[0].beyond = BeyondTolerance::LeaveFree;
    let system = System::try_new(&assembly).unwrap();
    let untied = &system.dofs.untied;
    assert_eq!(untied.iter().map(|u| u.1).collect::<Vec<_>>(), strays);
    assert!(
        untied
            .iter()
            .all(|&(tie, _, distance)| tie == 0 && (distance - 3e-4).abs() < 1e-12)
    );
    assert!(
        strays
            .iter()
            .all(|&node| system.dofs.independent_index(node, 0).is_some())
    );
}

/// Where two bars face one another both ends follow one point, the first of all couplings of `kind`.
fn joined_bars(kind: impl Fn(usize) -> CouplingKind) -> System {
    let mut assembly = sliding_bars();
    for coupling in &mut assembly.couplings {
        coupling.kind = kind(coupling.nodes.len());
    }
    assembly.equations.push(Equation {
        name: "component 0".into(),
        terms: vec![(Dof::Reference(0, 0), 1.0), (Dof::Reference(1, 0), -1.0)],
    });
    assembly.loads.clear();
    System::try_new(&assembly).unwrap()
}

#[test]
fn kinematic_couplings_are_rigid_and_distributing_ones_are_not() {
    let first = |system: &System| {
        let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 4, 1e-6).unwrap();
        assert_eq!(modes.n_zero, 6);
        modes.frequencies()[0]
    };
    let rigid = joined_bars(|_| CouplingKind::Kinematic([true; 3]));
    let soft = joined_bars(|n| CouplingKind::Distributing(vec![1.0; n]));
    assert!(
        first(&rigid) > 1.001 * first(&soft),
        "{} {}",
        first(&rigid),
        first(&soft)
    );
    // Six unknowns for both clouds together, at the reference point.
    let beyond = rigid
        .dofs
        .independent
        .iter()
        .filter(|&&d| d >= 3 * rigid.dofs.coordinates.len());
    assert_eq!(beyond.count(), 6);
    assert_eq!(rigid.positions[rigid.n_dofs() - 1], [0.055, 0.005, 0.01]);

    let mut assembly = sliding_bars();
    assembly.couplings[0].kind = CouplingKind::Kinematic([true, false, false]);
    // Equations tie the motions that move no node to those of the other cloud; two rotations alone tie the bars.
    System::try_new(&assembly).unwrap();
    assert_eq!(assembly.rigid_motions().unwrap(), 10);
    assembly.equations.clear();
    let error = System::try_new(&assembly).unwrap_err();
    assert!(
        matches!(&error, Error::Coupling { coupling, .. } if coupling == "a"),
        "{error}"
    );
}

#[test]
fn loads_on_reference_points_of_kinematic_couplings_are_those_of_the_rigid_clouds() {
    let mut assembly = sliding_bars();
    for coupling in &mut assembly.couplings {
        coupling.kind = CouplingKind::Kinematic([true; 3]);
    }
    // The first rotation of one point is held, so that the equation holds that of the other as well.
    assembly.supports = vec![Dof::Reference(0, 3)];
    for (name, term) in [
        ("held", (Dof::Reference(1, 3), 5.0)),
        ("moment", (Dof::Reference(1, 5), 3.0)),
    ] {
        assembly.loads.push(LoadPattern {
            name: name.into(),
            terms: vec![term],
        });
    }
    let system = System::try_new(&assembly).unwrap();
    let dofs = &system.dofs;
    // The generalised forces of the independent components do the work of the loads on any motion of them.
    let motion: Vec<f64> = (0..system.n_dofs()).map(|i| 1.0 + (i % 7) as f64).collect();
    let nodal = multiply_vector(&dofs.transform, &motion);
    let first = 3 * dofs.coordinates.len();
    let moved = |full: usize| dofs.row(full).map(|(column, c)| c * motion[column]).sum::<f64>();
    for (load, pattern) in system.loads.iter().zip(&assembly.loads) {
        let work: f64 = load.iter().zip(&motion).map(|(f, u)| f * u).sum();
        let terms = pattern.terms.iter().map(|(dof, value)| match dof {
            Dof::Reference(index, component) => value * moved(first + 6 * *index as usize + usize::from(*component)),
            Dof::Node(..) | Dof::Pretension(_) => unreachable!(),
        });
        assert!((work - terms.sum::<f64>()).abs() < 1e-12, "{}", pattern.name);
    }
    assert!(system.loads[1].iter().all(|f| *f == 0.0), "what is held does no work");
    assert_eq!(dofs.row(first + 9).next(), None);
    assert_eq!(moved(first + 5), moved(first + 11), "one rotation by an equation");
    // Each node of a cloud moves as the rigid body does that its reference point drives.
    for (index, coupling) in assembly.couplings.iter().enumerate() {
        let of: [f64; 6] = std::array::from_fn(|c| moved(first + 6 * index + c));
        for &node in &coupling.nodes {
            let x = dofs.coordinates[node as usize];
            let r = [0, 1, 2].map(|c| x[c] - coupling.reference[c]);
            let turned = [
                of[4] * r[2] - of[5] * r[1],
                of[5] * r[0] - of[3] * r[2],
                of[3] * r[1] - of[4] * r[0],
            ];
            for c in 0..3 {
                let found = nodal[3 * node as usize + c];
                assert!((found - of[c] - turned[c]).abs() < 1e-12, "node {node}, {c}");
            }
        }
    }
}

#[test]
fn a_clamped_bar_is_a_cantilever() {
    let mut assembly = bar([60, 2, 2], [0.72, 0.012, 0.012]);
    let nodes: Vec<u32> = (0..assembly.mesh.nodes.len() as u32).collect();
    let end = plane(&assembly.mesh, &nodes, 0, 0.0);
    assembly.supports = end.iter().flat_map(|&n| (0..3).map(move |c| Dof::Node(n, c))).collect();
    // Twice is not too often.
    assembly.supports.push(assembly.supports[0]);
    let system = System::try_new(&assembly).unwrap();
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 2, 1e-6).unwrap();
    assert_eq!(modes.n_zero, 0);
    let m = steel();
    let euler = 1.875_104_1_f64.powi(2) / (2.0 * std::f64::consts::PI * 0.72 * 0.72)
        * (m.youngs_modulus * 0.012_f64.powi(2) / (12.0 * m.density)).sqrt();
    for f in &modes.frequencies()[..2] {
        assert!((f / euler - 1.0).abs() < 5e-3, "{f} {euler}");
    }
}

#[test]
fn masses_at_the_ends_lower_the_first_frequency_as_perturbation_theory_says() {
    let mut assembly = bar([12, 2, 2], [0.12, 0.02, 0.01]);
    let modes = |assembly: &Assembly| {
        let system = System::try_new(assembly).unwrap();
        let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 1, 1e-7).unwrap();
        (system, modes)
    };
    let (system, bare) = modes(&assembly);
    let ends = [0_u32, 12];
    let mass = 1e-4 * system.total_mass;
    assembly.masses = ends.map(|node| PointMass { node, mass }).to_vec();
    let (heavy, found) = modes(&assembly);
    assert!((heavy.total_mass - system.total_mass - 2.0 * mass).abs() < 1e-12);
    // df / f = -1/2 sum m |phi|^2 with mass-normalised shapes.
    let squares = ends
        .iter()
        .flat_map(|&node| (0..3).map(move |c| (node, c)))
        .map(|(node, c)| {
            let row = system.dofs.independent_index(node, c).unwrap();
            bare.elastic()[(row, 0)].powi(2)
        });
    let expected = -0.5 * mass * squares.sum::<f64>();
    let shift = found.frequencies()[0] / bare.frequencies()[0] - 1.0;
    assert!((shift / expected - 1.0).abs() < 1e-2, "{shift} {expected}");

    for (node, mass) in [(u32::MAX, 1.0), (0, 0.0), (0, -1.0), (0, f64::NAN)] {
        assembly.masses = vec![PointMass { node, mass }];
        assert!(matches!(
            System::try_new(&assembly),
            Err(Error::PointMass { mass: 0, .. })
        ));
    }
}

#[test]
fn a_bar_on_springs_bounces_on_them() {
    let mut assembly = bar([12, 2, 2], [0.12, 0.02, 0.02]);
    let corners = [0, 12, 12 + 13 * 2, 13 * 2];
    assembly.springs = corners
        .into_iter()
        .flat_map(|node| {
            (0..3).map(move |component| GroundSpring {
                node,
                component,
                stiffness: 30.0,
            })
        })
        .collect();
    let system = System::try_new(&assembly).unwrap();
    let load = {
        let u: Vec<f64> = system
            .dofs
            .independent
            .iter()
            .map(|d| f64::from(u8::from(d % 3 == 2)))
            .collect();
        multiply_vector(&system.stiffness, &u)
    };
    // Lifting it by one metre stretches four springs.
    assert!((load.iter().sum::<f64>() / 120.0 - 1.0).abs() < 1e-6);
    assembly.springs[0].component = 3;
    assert!(matches!(
        System::try_new(&assembly),
        Err(Error::Spring { spring: 0, .. })
    ));
    assembly.springs[0].component = 0;
    assembly.springs[0].stiffness = -1.0;
    assert!(matches!(
        System::try_new(&assembly),
        Err(Error::Spring { spring: 0, .. })
    ));
}
