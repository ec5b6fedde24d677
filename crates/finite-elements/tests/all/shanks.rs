//! Shanks of bolts, and rigid motions, against closed forms.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use crate::blocks::{add_block, plane, steel, timoshenko};
use faer::Mat;
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::factor::SparseCholesky;
use finite_elements::mesh::{
    Assembly, Coupling, CouplingKind, Dof, Equation, GroundSpring, LoadPattern, Material, Mesh, RigidMass, Section,
    Shank,
};
use finite_elements::sparse::multiply_vector;
use finite_elements::{Error, Quadratic};
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::PI;

const DIAMETER: f64 = 0.01;
const BLOCK: [f64; 3] = [0.03, 0.02, 0.025];
const LENGTH: f64 = 0.04;

/// Two blocks one above the other, a shank along z between their reference points in the middle of the faces that face one
/// another. With `all` each block follows its reference point as a whole, otherwise with that face alone.
fn two_blocks(kind: fn(usize) -> CouplingKind, all: bool) -> Assembly {
    let mut mesh = Mesh {
        materials: vec![steel()],
        ..Mesh::default()
    };
    let lower = add_block(&mut mesh, [0.0; 3], BLOCK, [2, 2, 2]);
    let upper = add_block(&mut mesh, [0.0, 0.0, BLOCK[2] + LENGTH], BLOCK, [2, 2, 2]);
    let coupling = |name: &str, block: &[u32], z: f64| {
        let nodes = if all { block.to_vec() } else { plane(&mesh, block, 2, z) };
        Coupling {
            name: name.into(),
            reference: [0.5 * BLOCK[0], 0.5 * BLOCK[1], z],
            kind: kind(nodes.len()),
            nodes,
        }
    };
    let couplings = vec![
        coupling("lower", &lower, BLOCK[2]),
        coupling("upper", &upper, BLOCK[2] + LENGTH),
    ];
    let at = [couplings[0].reference, couplings[1].reference];
    Assembly {
        mesh,
        shanks: vec![Shank::uniform(
            "bolt".into(),
            [0, 1],
            at,
            Section::Circle(DIAMETER),
            &steel(),
            [1.0, 0.0, 0.0],
        )],
        couplings,
        ..Assembly::default()
    }
}

fn kinematic(_: usize) -> CouplingKind {
    CouplingKind::Kinematic([true; 3])
}

fn distributing(n: usize) -> CouplingKind {
    CouplingKind::Distributing((0..n).map(|i| 1.0 + (i % 3) as f64).collect())
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs(),
        "found {found}, expected {expected}: off by {:.2e}",
        (found / expected - 1.0).abs()
    );
}

fn frequencies(assembly: &Assembly, n: usize) -> (usize, Vec<f64>) {
    let system = System::try_new(assembly).unwrap();
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, n, 1e-9).unwrap();
    (modes.n_zero, modes.frequencies())
}

/// Displacement of each load's own component under it.
fn compliances(assembly: &Assembly) -> Vec<f64> {
    let system = System::try_new(assembly).unwrap();
    let factor = SparseCholesky::try_new(&system.stiffness, &system.positions, "stiffness").unwrap();
    let answer = |load: &Vec<f64>| {
        let mut u = Mat::from_fn(load.len(), 1, |i, _| load[i]);
        factor.solve_in_place(u.as_mut());
        load.iter().enumerate().map(|(i, f)| f * u[(i, 0)]).sum()
    };
    system.loads.iter().map(answer).collect()
}

fn load(dof: Dof) -> LoadPattern {
    LoadPattern {
        name: format!("{dof:?}"),
        terms: vec![(dof, 1.0)],
    }
}

fn mass_of_block() -> f64 {
    steel().density * BLOCK.iter().product::<f64>()
}

#[test]
fn two_masses_on_a_shank_bounce_as_on_a_spring() {
    let mut assembly = two_blocks(kinematic, true);
    // Only along the axis.
    for coupling in 0..2 {
        assembly
            .supports
            .extend([0, 1, 3, 4, 5].map(|c| Dof::Reference(coupling, c)));
    }
    let area = PI * DIAMETER * DIAMETER / 4.0;
    let stiffness = steel().youngs_modulus * area / LENGTH;
    let shank = steel().density * area * LENGTH;
    // Free overlap: the tension is held, and nothing resists.
    assert_eq!(frequencies(&assembly, 1).0, 2);
    assembly.supports.push(Dof::Pretension(0));
    let (n_zero, found) = frequencies(&assembly, 1);
    assert_eq!(n_zero, 1);
    // Out of phase, with a linear field of velocity: m / 2 + shank / 12.
    let mass = 0.5 * mass_of_block() + shank / 12.0;
    close(found[0], (stiffness / mass).sqrt() / (2.0 * PI), 1e-9);
    let system = System::try_new(&assembly).unwrap();
    close(system.total_mass, 2.0 * mass_of_block() + shank, 1e-12);
}

#[test]
fn a_cantilevered_shank_bends_shears_twists_and_stretches() {
    let mut assembly = two_blocks(kinematic, true);
    assembly.shanks[0] = Shank::uniform(
        "plank".into(),
        [0, 1],
        [assembly.couplings[0].reference, assembly.couplings[1].reference],
        Section::Rectangle([0.012, 0.005]),
        &steel(),
        // Its part along the axis does not count.
        [1.0, 0.0, 3.0],
    );
    assembly.supports = (0..6).map(|c| Dof::Reference(0, c)).collect();
    assembly.supports.push(Dof::Pretension(0));
    assembly.loads = (0..6).map(|c| load(Dof::Reference(1, c))).collect();
    let found = compliances(&assembly);
    let (e, nu) = (steel().youngs_modulus, steel().poisson_ratio);
    let shear = 0.5 * e / (1.0 + nu) * 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu) * 0.012 * 0.005;
    let along_x = e * 0.005 * 0.012_f64.powi(3) / 12.0;
    let along_y = e * 0.012 * 0.005_f64.powi(3) / 12.0;
    let l = LENGTH;
    close(found[0], l.powi(3) / (3.0 * along_x) + l / shear, 1e-9);
    close(found[1], l.powi(3) / (3.0 * along_y) + l / shear, 1e-9);
    close(found[2], l / (e * 0.012 * 0.005), 1e-9);
    close(found[3], l / along_y, 1e-9);
    close(found[4], l / along_x, 1e-9);
    // Torsion constant of a rectangle 12 to 5 from its series: 0.2462 a b^3 (interpolated between 2.0: 0.229 and 2.5: 0.249).
    close(
        found[5],
        l / (0.5 * e / (1.0 + nu) * 0.2462 * 0.012 * 0.005_f64.powi(3)),
        3e-3,
    );
}

/// First modes of a free beam of `n` shanks.
fn chain(n: u32, length: f64, side: f64) -> Vec<f64> {
    let at = |i: u32| [0.0, length * f64::from(i) / f64::from(n), 0.0];
    let mut assembly = Assembly::default();
    for i in 0..=n {
        assembly.couplings.push(Coupling {
            name: format!("point {i}"),
            reference: at(i),
            nodes: Vec::new(),
            kind: kinematic(0),
        });
    }
    for i in 0..n {
        let (ends, section) = ([i, i + 1], Section::Rectangle([side; 2]));
        let shank = Shank::uniform(format!("{i}"), ends, ends.map(at), section, &steel(), [1.0, 0.0, 1.0]);
        assembly.shanks.push(shank);
        assembly.supports.push(Dof::Pretension(i));
    }
    let (n_zero, found) = frequencies(&assembly, 4);
    assert_eq!((n_zero, assembly.rigid_motions().unwrap()), (6, 6));
    found
}

#[test]
fn a_chain_of_shanks_is_a_timoshenko_beam() {
    let (length, side) = (0.72, 0.04);
    let expected = timoshenko(length, side, 2);
    let error = |n: u32| -> Vec<f64> {
        let found = chain(n, length, side);
        // Both planes.
        close(found[0], found[1], 1e-8);
        let pairs = found.iter().step_by(2).zip(&expected);
        pairs.map(|(found, expected)| found / expected - 1.0).collect()
    };
    for (coarse, fine) in error(20).into_iter().zip(error(40)) {
        println!("errors {coarse:.2e} {fine:.2e}");
        // Second order, from above.
        assert!(fine > 0.0 && fine < 1e-4 && fine < 0.27 * coarse, "{coarse:e} {fine:e}");
    }
}

/// A sleeve of stiffness `k` without Poisson effect, with a shank through it.
fn sleeve(kind: fn(usize) -> CouplingKind) -> (Assembly, f64) {
    let material = Material {
        poisson_ratio: 0.0,
        ..steel()
    };
    let mut mesh = Mesh {
        materials: vec![material],
        ..Mesh::default()
    };
    let nodes = add_block(&mut mesh, [0.0; 3], [0.02, 0.02, LENGTH], [2, 2, 3]);
    // Weights of uniform traction on each end.
    let end = |z: f64| {
        let cloud = plane(&mesh, &nodes, 2, z);
        let at_rim = |n: &u32| {
            [0, 1]
                .iter()
                .filter(|&&c| (mesh.nodes[*n as usize][c] - 0.01).abs() > 0.005)
                .count()
        };
        let weights = cloud.iter().map(|n| [4.0, 2.0, 1.0][at_rim(n)]).collect();
        let kind = match kind(cloud.len()) {
            CouplingKind::Distributing(_) => CouplingKind::Distributing(weights),
            kinematic => kinematic,
        };
        Coupling {
            name: format!("{z}"),
            reference: [0.01, 0.01, z],
            nodes: cloud,
            kind,
        }
    };
    let couplings = vec![end(0.0), end(LENGTH)];
    let at = [couplings[0].reference, couplings[1].reference];
    let shank = Shank::uniform(
        "bolt".into(),
        [0, 1],
        at,
        Section::Circle(DIAMETER),
        &steel(),
        [0.3, 0.4, 0.0],
    );
    let stiffness = steel().youngs_modulus * 0.02 * 0.02 / LENGTH;
    let assembly = Assembly {
        mesh,
        couplings,
        shanks: vec![shank],
        ..Assembly::default()
    };
    (assembly, stiffness)
}

#[test]
fn pretension_sees_bolt_and_clamped_part_in_series_and_a_locked_bolt_both_in_parallel() {
    for kind in [kinematic, distributing] {
        let (mut assembly, sleeve) = sleeve(kind);
        let bolt = assembly.shanks[0].axial;
        assembly.supports = (0..6).map(|c| Dof::Reference(0, c)).collect();
        assembly.loads = vec![load(Dof::Pretension(0)), load(Dof::Reference(1, 2))];
        let found = compliances(&assembly);
        close(found[0], 1.0 / bolt + 1.0 / sleeve, 1e-9);
        // At constant tension the shank has no axial stiffness.
        close(found[1], 1.0 / sleeve, 1e-9);
        assembly.loads.remove(0);
        assembly.supports.push(Dof::Pretension(0));
        close(compliances(&assembly)[0], 1.0 / (bolt + sleeve), 1e-9);
    }
}

#[test]
fn unit_pretension_compresses_what_it_clamps() {
    let (mut assembly, sleeve) = sleeve(kinematic);
    assembly.supports = (0..6).map(|c| Dof::Reference(0, c)).collect();
    assembly.loads = vec![load(Dof::Pretension(0))];
    let system = System::try_new(&assembly).unwrap();
    let factor = SparseCholesky::try_new(&system.stiffness, &system.positions, "stiffness").unwrap();
    let mut u = Mat::from_fn(system.n_dofs(), 1, |i, _| system.loads[0][i]);
    factor.solve_in_place(u.as_mut());
    let top = 3 * assembly.mesh.nodes.len() + 6 + 2;
    let moved: f64 = system.dofs.row(top).map(|(column, c)| c * u[(column, 0)]).sum();
    close(moved, -1.0 / sleeve, 1e-9);
}

#[test]
fn rigid_motions_cost_no_energy_and_have_the_mass_and_inertia_of_all() {
    for kind in [kinematic, distributing] {
        let mut assembly = two_blocks(kind, false);
        turn(&mut assembly, &Rotation3::from_euler_angles(0.3, -1.1, 2.0));
        assembly.rigid_masses.push(RigidMass {
            coupling: 1,
            mass: 0.02,
            inertia: [[2e-6, 1e-7, 0.0], [1e-7, 3e-6, 0.0], [0.0, 0.0, 4e-6]],
        });
        let system = System::try_new(&assembly).unwrap();
        let largest = system.stiffness.data().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let n_nodal = 3 * assembly.mesh.nodes.len();
        for axis in 0..6 {
            let motion = |x: [f64; 3], component: usize| match axis {
                0..3 => f64::from(u8::from(component == axis)),
                _ => {
                    let theta = Vector3::ith(axis - 3, 1.0);
                    theta.cross(&Vector3::from(x))[component]
                }
            };
            let rigid: Vec<f64> = system
                .dofs
                .independent
                .iter()
                .map(|&full| match full.checked_sub(n_nodal) {
                    None => motion(assembly.mesh.nodes[full / 3], full % 3),
                    Some(12..) => 0.0,
                    Some(beyond) if beyond % 6 < 3 => motion(assembly.couplings[beyond / 6].reference, beyond % 6),
                    Some(beyond) => f64::from(u8::from(axis == beyond % 6)),
                })
                .collect();
            let force = multiply_vector(&system.stiffness, &rigid);
            let size = rigid.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let worst = force.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            assert!(
                worst < 1e-12 * largest * size,
                "motion {axis}: {:e}",
                worst / largest / size
            );
            let momentum = multiply_vector(&system.mass, &rigid);
            let twice_energy: f64 = momentum.iter().zip(&rigid).map(|(p, v)| p * v).sum();
            let expected = if axis < 3 {
                system.total_mass
            } else {
                inertia_about_origin(&assembly, axis - 3)
            };
            close(twice_energy, expected, 1e-9);
        }
    }
}

/// Moment of inertia of all elements, the shank and the rigid mass about a global axis.
fn inertia_about_origin(assembly: &Assembly, axis: usize) -> f64 {
    let mut solids = assembly.clone();
    (solids.couplings, solids.shanks, solids.rigid_masses) = (Vec::new(), Vec::new(), Vec::new());
    let system = System::try_new(&solids).unwrap();
    let theta = Vector3::ith(axis, 1.0);
    let rigid: Vec<f64> = (assembly.mesh.nodes.iter())
        .flat_map(|x| <[f64; 3]>::from(theta.cross(&Vector3::from(*x))))
        .collect();
    let momentum = multiply_vector(&system.mass, &rigid);
    let of_solids: f64 = momentum.iter().zip(&rigid).map(|(p, v)| p * v).sum();
    let body = &assembly.rigid_masses[0];
    let at = |coupling: u32| Vector3::from(assembly.couplings[coupling as usize].reference);
    let of_body = body.inertia[axis][axis] + body.mass * theta.cross(&at(body.coupling)).norm_squared();
    let shank = &assembly.shanks[0];
    let [a, b] = shank.ends.map(at);
    let (length, along) = ((b - a).norm(), (b - a).normalize());
    let cos2 = along[axis] * along[axis];
    let line = |x: Vector3<f64>| theta.cross(&x).norm_squared();
    // Simpson's rule is exact for squares.
    let of_line = shank.mass * length / 6.0 * (line(a) + 4.0 * line(0.5 * (a + b)) + line(b));
    let of_section = length * (shank.inertia[0] * cos2 + shank.inertia[1] * (1.0 - cos2));
    of_solids + of_body + of_line + of_section
}

fn turn(assembly: &mut Assembly, rotation: &Rotation3<f64>) {
    let turned = |x: &mut [f64; 3]| *x = (rotation * Vector3::from(*x)).into();
    assembly.mesh.nodes.iter_mut().for_each(turned);
    for coupling in &mut assembly.couplings {
        turned(&mut coupling.reference);
    }
    for shank in &mut assembly.shanks {
        turned(&mut shank.transverse);
    }
}

#[test]
fn a_turned_structure_has_the_same_frequencies() {
    for (kind, all) in [
        (kinematic as fn(usize) -> _, false),
        (distributing, false),
        (kinematic, true),
    ] {
        let mut assembly = two_blocks(kind, all);
        assembly.shanks[0] = Shank::uniform(
            "bolt".into(),
            [0, 1],
            [assembly.couplings[0].reference, assembly.couplings[1].reference],
            Section::Rectangle([0.01, 0.004]),
            &steel(),
            [1.0, 1.0, 0.0],
        );
        assembly.supports = vec![Dof::Pretension(0)];
        let (n_zero, before) = frequencies(&assembly, 6);
        turn(&mut assembly, &Rotation3::from_euler_angles(1.0, 0.5, -2.2));
        let (turned_zero, after) = frequencies(&assembly, 6);
        assert_eq!((n_zero, turned_zero), (6, 6));
        for (before, after) in before.iter().zip(&after) {
            // Of eigenvalues, the squares, twice as much.
            close(*after, *before, 0.5e-10);
        }
    }
}

#[test]
fn kinematic_ends_are_stiffer_than_distributing_ones() {
    let first = |kind| {
        let mut assembly = two_blocks(kind, false);
        assembly.supports = vec![Dof::Pretension(0)];
        frequencies(&assembly, 1).1[0]
    };
    let (rigid, soft) = (first(kinematic), first(|n| CouplingKind::Distributing(vec![1.0; n])));
    assert!(rigid > soft && rigid < 1.2 * soft, "{rigid} {soft}");
}

#[test]
fn frequencies_with_shanks_do_not_depend_on_the_unit_system() {
    let mut assembly = two_blocks(distributing, false);
    assembly.rigid_masses.push(RigidMass {
        coupling: 0,
        mass: 0.05,
        inertia: [[2e-6, 0.0, 0.0], [0.0, 3e-6, 0.0], [0.0, 0.0, 4e-6]],
    });
    assembly.supports.push(Dof::Pretension(0));
    assembly.loads = vec![load(Dof::Pretension(0))];
    let (_, before) = frequencies(&assembly, 6);
    // As if the numbers were in inches and pounds.
    assembly.convert_units(0.0254, 0.453_592_37);
    let (_, after) = frequencies(&assembly, 6);
    for (before, after) in before.iter().zip(&after) {
        close(*after, *before, 1e-9);
    }
    // A force of lb in/s^2.
    close(assembly.loads[0].terms[0].1, 0.0254 * 0.453_592_37, 1e-15);
}

#[test]
fn shanks_stay_on_quadratic_elements() {
    let assembly = two_blocks(kinematic, false);
    let raised = Quadratic::try_new(&assembly, |_| None).unwrap().assembly;
    assert_eq!(raised.shanks, assembly.shanks);
    assert!(raised.couplings[0].nodes.len() > assembly.couplings[0].nodes.len());
    assert_eq!(raised.rigid_motions().unwrap(), 6);
    assert_eq!(frequencies(&raised, 1).0, 7);
}

#[test]
fn what_is_no_shank_is_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Assembly)| {
        let mut assembly = two_blocks(kinematic, false);
        change(&mut assembly);
        System::try_new(&assembly).unwrap_err().to_string()
    };
    let coincide = refused(&|a| a.couplings[1].reference = a.couplings[0].reference);
    assert!(
        coincide.contains("`bolt`") && coincide.contains("coincide"),
        "{coincide}"
    );
    assert!(refused(&|a| a.shanks[0].ends[1] = 7).contains("coupling 7"));
    assert!(refused(&|a| a.shanks[0].axial = 0.0).contains("positive"));
    assert!(refused(&|a| a.shanks[0].shear[1] = f64::NAN).contains("positive"));
    assert!(refused(&|a| a.shanks[0].mass = -1.0).contains("not negative"));
    assert!(refused(&|a| a.shanks[0].transverse = [0.0, 0.0, 2.0]).contains("deflection"));
    assert!(refused(&|a| a.shanks[0].transverse = [f64::NAN; 3]).contains("deflection"));
    assert!(refused(&|a| a.supports.push(Dof::Pretension(3))).contains("pretension 3"));
    assert!(refused(&|a| a.loads.push(load(Dof::Pretension(1)))).contains("pretension 1"));
    let body = RigidMass {
        coupling: 1,
        mass: 1.0,
        inertia: [[0.0; 3]; 3],
    };
    assert!(refused(&|a| a.rigid_masses.push(RigidMass { coupling: 2, ..body })).contains("coupling 2"));
    assert!(refused(&|a| a.rigid_masses.push(RigidMass { mass: -1.0, ..body })).contains("rigid mass 0"));
    let lopsided = [[0.0, 1.0, 0.0], [0.0; 3], [0.0; 3]];
    let lopsided = refused(&|a| {
        a.rigid_masses.push(RigidMass {
            inertia: lopsided,
            ..body
        });
    });
    assert!(lopsided.contains("symmetric"), "{lopsided}");
    // A point that nothing holds.
    let loose = refused(&|a| {
        a.couplings.push(Coupling {
            name: "loose".into(),
            reference: [0.1; 3],
            nodes: Vec::new(),
            kind: kinematic(0),
        });
    });
    assert!(loose.contains("`loose`") && loose.contains("undetermined"), "{loose}");
    assert!(matches!(
        System::try_new(&Assembly {
            shanks: two_blocks(kinematic, false).shanks,
            ..Assembly::default()
        }),
        Err(Error::Dangling { .. })
    ));
}

#[test]
fn rigid_motions_are_counted() {
    let mut mesh = Mesh {
        materials: vec![steel()],
        ..Mesh::default()
    };
    let nodes = add_block(&mut mesh, [0.01, -0.02, 0.03], BLOCK, [2, 2, 2]);
    let free = Assembly {
        mesh,
        ..Assembly::default()
    };
    let count = |supports: &[Dof]| {
        let mut assembly = free.clone();
        assembly.supports = supports.to_vec();
        assembly.rigid_motions().unwrap()
    };
    let all = |nodes: &[u32], components: &[u8]| -> Vec<Dof> {
        let each = nodes
            .iter()
            .flat_map(|&n| components.iter().map(move |&c| Dof::Node(n, c)));
        each.collect()
    };
    let bottom = plane(&free.mesh, &nodes, 2, 0.03);
    let edge = plane(&free.mesh, &bottom, 0, 0.01);
    assert_eq!(count(&[]), 6);
    assert_eq!(count(&all(&bottom, &[0, 1, 2])), 0);
    assert_eq!(count(&all(&bottom[4..5], &[0, 1, 2])), 3, "pinned at a point");
    assert_eq!(count(&all(&edge, &[0, 1, 2])), 1, "hinge");
    assert_eq!(count(&all(&bottom, &[2])), 3, "plane of symmetry");
    // Elastic ground under the bottom.
    let mut sprung = free.clone();
    sprung.springs = bottom
        .iter()
        .map(|&node| GroundSpring {
            node,
            component: 2,
            stiffness: 1e6,
        })
        .collect();
    assert_eq!(sprung.rigid_motions().unwrap(), 3);
    // An equation that holds one motion.
    let mut held = free.clone();
    held.equations.push(Equation {
        name: "mean".into(),
        terms: all(&bottom, &[0]).into_iter().map(|dof| (dof, 0.25)).collect(),
    });
    assert_eq!(held.rigid_motions().unwrap(), 5);

    for kind in [kinematic, distributing] {
        let mut joined = two_blocks(kind, false);
        assert_eq!(joined.rigid_motions().unwrap(), 6);
        let shanks = std::mem::take(&mut joined.shanks);
        assert_eq!(joined.rigid_motions().unwrap(), 12);
        // A joint that leaves all rotations.
        joined.equations = (0..3)
            .map(|c| Equation {
                name: format!("ball {c}"),
                terms: vec![(Dof::Reference(0, c), 1.0), (Dof::Reference(1, c), -1.0)],
            })
            .collect();
        assert_eq!(joined.rigid_motions().unwrap(), 9);
        joined.equations.clear();
        joined.shanks = shanks;
        joined.supports = (0..6).map(|c| Dof::Reference(1, c)).collect();
        assert_eq!(joined.rigid_motions().unwrap(), 0);
    }
}

#[test]
fn assemblies_whose_matrices_are_multiples_are_told_by_their_inputs() {
    let of = |material: Material| {
        let mut assembly = two_blocks(distributing, false);
        let at = [assembly.couplings[0].reference, assembly.couplings[1].reference];
        let section = Section::Circle(DIAMETER);
        assembly.shanks = vec![Shank::uniform(
            "bolt".into(),
            [0, 1],
            at,
            section,
            &material,
            [1.0, 0.0, 0.0],
        )];
        assembly.mesh.materials = vec![material];
        assembly
    };
    let other = |youngs_modulus: f64, density: f64| Material {
        youngs_modulus: youngs_modulus * steel().youngs_modulus,
        density: density * steel().density,
        ..steel()
    };
    let known = of(steel());
    let found = of(other(1.3, 0.7)).multiple_of(&known).unwrap();
    close(found[0], 1.3, 1e-12);
    close(found[1], 0.7, 1e-12);
    let [own, theirs] = [&of(other(1.3, 0.7)), &known].map(|assembly| System::try_new(assembly).unwrap());
    for (own, known, factor) in [
        (own.stiffness.data(), theirs.stiffness.data(), found[0]),
        (own.mass.data(), theirs.mass.data(), found[1]),
    ] {
        let largest = known.iter().fold(0.0_f64, |m, value| m.max(value.abs()));
        assert_eq!(own.len(), known.len());
        for (own, known) in own.iter().zip(known) {
            assert!((own - factor * known).abs() <= 1e-12 * factor * largest);
        }
    }
    assert_eq!(known.multiple_of(&known), Some([1.0, 1.0]));

    let poisson = Material {
        poisson_ratio: 0.31,
        ..steel()
    };
    assert_eq!(of(poisson).multiple_of(&known), None);
    // The bolt alone is stiffer, or the blocks are.
    let mut stiffer = known.clone();
    stiffer.mesh.materials = vec![other(1.3, 1.0)];
    assert_eq!(stiffer.multiple_of(&known), None);
    // A spring to the ground, and a mass, keep what they are.
    let spring = GroundSpring {
        node: 0,
        component: 2,
        stiffness: 1e6,
    };
    let held = |mut assembly: Assembly| {
        assembly.springs = vec![spring];
        assembly
    };
    assert_eq!(held(of(other(1.3, 1.0))).multiple_of(&held(known.clone())), None);
    let lighter = held(of(other(1.0, 0.7))).multiple_of(&held(known.clone())).unwrap();
    assert_eq!(lighter[0], 1.0);
    close(lighter[1], 0.7, 1e-12);
    assert_eq!(held(known.clone()).multiple_of(&known), None);
    let mut moved = known.clone();
    moved.mesh.nodes[0][0] += 1e-6;
    assert_eq!(moved.multiple_of(&known), None);
}
