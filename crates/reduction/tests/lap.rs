//! Reduction of a small lap of two blocks against the full model.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use dense_algebra::product;
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::elements::Formulation;
use finite_elements::mesh::{
    Assembly, Cell, Coupling, CouplingKind, Dof, Element, Equation, LoadPattern, Material, Mesh, Section, Shank,
};
use finite_elements::sparse::{multiply_vector, numbering, submatrix};
use reduction::{
    Error, Hold, InterfacePairs, Limits, LinearCheck, ReducedModel, RelativeSystem, Settings, SystemMatrices, checks,
    reduce,
};
use std::borrow::Cow;

struct Lap {
    assembly: Assembly,
    top: Vec<u32>,
    bottom: Vec<u32>,
}

/// Two 60 x 20 x 10 mm blocks, one on the other over 40 mm; the top one is shifted along x.
fn lap() -> Lap {
    let mut mesh = Mesh {
        materials: vec![Material {
            name: "steel".into(),
            youngs_modulus: 2e11,
            poisson_ratio: 0.3,
            density: 7800.0,
        }],
        ..Mesh::default()
    };
    let mut block = |corner: [f64; 3]| {
        let base = mesh.nodes.len() as u32;
        let (nx, ny, nz) = (12, 4, 3);
        for k in 0..=nz {
            for j in 0..=ny {
                for i in 0..=nx {
                    let at = [
                        0.005 * f64::from(i),
                        0.005 * f64::from(j),
                        0.01 * f64::from(k) / f64::from(nz),
                    ];
                    mesh.nodes.push([0, 1, 2].map(|c| corner[c] + at[c]));
                }
            }
        }
        let node = |i: i32, j: i32, k: i32| base + (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let ring = |k| {
                        [
                            node(i, j, k),
                            node(i + 1, j, k),
                            node(i + 1, j + 1, k),
                            node(i, j + 1, k),
                        ]
                    };
                    let (low, high) = (ring(k), ring(k + 1));
                    let nodes = [low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]];
                    let cell = Cell::hex8(nodes, Formulation::IncompatibleModes);
                    mesh.elements.push(Element { cell, material: 0 });
                }
            }
        }
        base
    };
    let lower = block([0.0; 3]);
    let upper = block([0.02, 0.0, 0.01]);
    let pairs = |first: u32, offset: u32, layer: u32| -> Vec<u32> {
        (0..5)
            .flat_map(|j| (0..9).map(move |i| first + offset + i + 13 * (j + 5 * layer)))
            .collect()
    };
    let (bottom, top) = (pairs(lower, 4, 3), pairs(upper, 0, 0));
    // A clamp: the two blocks pressed together at one point.
    let (t, b) = (top[20], bottom[20]);
    let clamp = LoadPattern {
        name: "clamp".into(),
        terms: vec![(Dof::Node(t, 2), -100.0), (Dof::Node(b, 2), 100.0)],
    };
    Lap {
        assembly: Assembly {
            mesh,
            loads: vec![clamp],
            ..Assembly::default()
        },
        top,
        bottom,
    }
}

const FRAME: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];

fn relative(lap: &Lap) -> (System, RelativeSystem) {
    let system = System::try_new(&lap.assembly).unwrap();
    let pairs = InterfacePairs {
        top: &lap.top,
        bottom: &lap.bottom,
        frame: FRAME,
    };
    let relative = RelativeSystem::try_new(&system, pairs).unwrap();
    (system, relative)
}

fn diagonal(values: &[f64]) -> sprs::CsMat<f64> {
    let n = values.len();
    sprs::CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), values.to_vec())
}

/// All entries of a reduced matrix.
fn entries(matrix: &dense_algebra::SystemMatrix) -> faer::Mat<f64> {
    matrix.as_ref().to_dense()
}

#[test]
fn relative_coordinates_change_nothing_but_the_names() {
    let (system, relative) = relative(&lap());
    let modes = |k, m, p: &[[f64; 3]]| lowest_modes(k, m, p, 6, 1e-7).unwrap();
    let before = modes(&system.stiffness, &system.mass, &system.positions);
    let after = modes(&relative.stiffness, &relative.mass, &relative.positions);
    assert_eq!((before.n_zero, after.n_zero), (12, 12), "two free blocks");
    for (a, b) in before.frequencies().iter().zip(after.frequencies()) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
    // The clamp closes the interface: it does positive work on the normal jump alone.
    let load = &relative.loads[0];
    assert_eq!(relative.n_relative, 3 * 45);
    assert!((load[3 * 20 + 2] - 100.0).abs() < 1e-12, "{}", load[3 * 20 + 2]);
    assert!(load.iter().map(|f| f.abs()).sum::<f64>() < 100.0 + 1e-9);
}

#[test]
fn reduced_spectra_converge_to_the_full_ones_with_the_modes_retained() {
    let (_, relative) = relative(&lap());
    let full: Vec<Vec<f64>> = [1e6, 1e8]
        .iter()
        .map(|&stiffness| {
            let penalty = vec![stiffness; relative.n_relative];
            let (zero, frequencies) =
                checks::full_frequencies(&relative, Some(&diagonal(&penalty)), 10, 1e-7, Limits::default()).unwrap();
            assert_eq!(zero, 6);
            frequencies
        })
        .collect();
    let (_, free) = checks::full_frequencies(&relative, None, 10, 1e-7, Limits::default()).unwrap();
    let errors: Vec<f64> = [5, 20, 80]
        .iter()
        .map(|&n_modes| {
            let settings = Settings {
                n_modes,
                n_reported: 10,
                ..Settings::default()
            };
            let reduced = reduce(&relative, &[], settings, Limits::default()).unwrap();
            assert_eq!(reduced.zem_stuck, 6);
            assert!(reduced.asymmetry < 1e-8, "{}", reduced.asymmetry);
            let mut worst = 0.0_f64;
            for (stiffness, full) in [1e6, 1e8].iter().zip(&full) {
                let penalty = vec![*stiffness; relative.n_relative];
                let small = checks::reduced_spectrum(&reduced, &diagonal(&penalty), 10)
                    .unwrap()
                    .frequencies;
                for (a, b) in full.iter().zip(&small) {
                    assert!(
                        b / a > 1.0 - 1e-8,
                        "Rayleigh-Ritz frequencies lie above the exact ones: {a} {b}"
                    );
                    worst = worst.max(b / a - 1.0);
                }
            }
            let (zero, unstressed) = checks::unstressed_spectrum(&reduced, 10).unwrap();
            assert_eq!(zero, 12, "two free blocks");
            for (a, b) in free.iter().zip(&unstressed) {
                assert!(b / a > 1.0 - 1e-8, "without contact: {a} {b}");
                if n_modes == 80 {
                    assert!(b / a < 1.0 + 3e-3, "without contact: {a} {b}");
                }
            }
            if n_modes >= 10 {
                let stuck = checks::reduced_spectrum(&reduced, &diagonal(&vec![1e14; relative.n_relative]), 10)
                    .unwrap()
                    .frequencies;
                for (a, b) in reduced.stuck_frequencies.iter().zip(&stuck) {
                    assert!((b / a - 1.0).abs() < 1e-5, "stuck: {a} {b}");
                }
            }
            worst
        })
        .collect();
    assert!(errors[1] < 0.5 * errors[0] && errors[2] < 0.5 * errors[1], "{errors:?}");
    assert!(errors[2] < 3e-3, "{errors:?}");
}

#[test]
fn matrices_over_the_jump_are_those_of_the_static_responses() {
    use dense_algebra::{cholesky, product, solve_lower, solve_lower_transposed};
    let (_, relative) = relative(&lap());
    let reduced = reduce(&relative, &[], Settings::default(), Limits::default()).unwrap();
    let (n, nd) = (relative.stiffness.rows(), relative.n_relative);
    let dense = |a: &sprs::CsMat<f64>| faer::Mat::from_fn(n, n, |i, j| a.get(i, j).copied().unwrap_or(0.0));
    let (k, m) = (dense(&relative.stiffness), dense(&relative.mass));
    // Responses of the rest held at a node and along two more lines, so by other supports than the library's.
    let rest: Vec<usize> = (nd..n).collect();
    let at = |x: [f64; 3]| {
        let close = |p: &[f64; 3]| p.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-9);
        (nd..n).filter(|&i| close(&relative.positions[i])).collect::<Vec<_>>()
    };
    let (a, b, c) = (at([0.0; 3]), at([0.0, 0.02, 0.0]), at([0.0, 0.0, 0.01]));
    let held = [a[0], a[1], a[2], b[0], b[2], c[0]];
    let free: Vec<usize> = rest.iter().copied().filter(|i| !held.contains(i)).collect();
    let lower = cholesky(faer::Mat::from_fn(free.len(), free.len(), |i, j| k[(free[i], free[j])]).as_ref()).unwrap();
    let mut x = faer::Mat::from_fn(free.len(), nd, |i, j| -k[(free[i], j)]);
    solve_lower(lower.as_ref(), x.as_mut());
    solve_lower_transposed(lower.as_ref(), x.as_mut());
    let mut basis = faer::Mat::from_fn(n, nd, |i, j| f64::from(u8::from(i == j)));
    for (i, &row) in free.iter().enumerate() {
        basis.row_mut(row).copy_from(x.row(i));
    }
    // Rigid motions of the stuck structure move the rest only; mass-orthonormal by the factor of their Gram matrix.
    let rigid = faer::Mat::from_fn(n, 6, |i, mode| {
        if i < nd {
            return 0.0;
        }
        let (component, p) = ((i - nd) % 3, relative.positions[i]);
        let (u, v) = ((mode + 1) % 3, (mode + 2) % 3);
        match mode < 3 {
            true => f64::from(u8::from(component == mode)),
            false if component == u => -p[v],
            false if component == v => p[u],
            false => 0.0,
        }
    });
    let gram = product(rigid.transpose(), product(m.as_ref(), rigid.as_ref()).as_ref());
    let mut momentum = product(rigid.transpose(), product(m.as_ref(), basis.as_ref()).as_ref());
    solve_lower(cholesky(gram.as_ref()).unwrap().as_ref(), momentum.as_mut());
    let seen = |a: &faer::Mat<f64>| product(basis.transpose(), product(a.as_ref(), basis.as_ref()).as_ref());
    let mass = seen(&m) - product(momentum.transpose(), momentum.as_ref());
    for (name, expected, matrix) in [
        ("stiffness", seen(&k), entries(&reduced.stiffness)),
        ("mass", mass, entries(&reduced.mass)),
    ] {
        let error = difference(expected.as_ref(), matrix.submatrix(0, 0, nd, nd));
        println!("{name} {error:.1e}");
        assert!(error < 1e-9, "{name} {error:.1e}");
    }
}

#[test]
fn static_response_of_the_jump_is_exact() {
    // A static load on the jump with springs across the interface: reduced and full solutions must agree to round-off.
    let (_, relative) = relative(&lap());
    let n = relative.stiffness.rows();
    let mut row = vec![0.0; n];
    row[n - 7] = 1.0;
    let reduced = reduce(&relative, &[row.clone()], Settings::default(), Limits::default()).unwrap();
    let nd = relative.n_relative;
    let springs = 1e7;
    let mut small = entries(&reduced.stiffness);
    (0..nd).for_each(|i| small[(i, i)] += springs);
    let llt = small.llt(faer::Side::Lower).unwrap();
    let mut x = faer::Mat::from_fn(small.nrows(), 1, |i, _| reduced.loads[0][i]);
    faer::linalg::solvers::Solve::solve_in_place(&llt, x.as_mut());
    // The full solution through an extremely soft grounding instead of supports.
    // Far above the round-off of the stiffness, far below the first elastic mode.
    let sigma = 1e3;
    let mut triplets = sprs::TriMat::new((n, n));
    (0..nd).for_each(|i| triplets.add_triplet(i, i, springs));
    let spring: sprs::CsMat<f64> = triplets.to_csr();
    let grounded = &(&relative.stiffness + &spring) + &relative.mass.map(|m| sigma * m);
    let factor = finite_elements::factor::SparseCholesky::try_new(&grounded, &relative.positions, "grounded").unwrap();
    let mut full = faer::Mat::from_fn(n, 1, |i, _| relative.loads[0][i]);
    factor.solve_in_place(full.as_mut());
    let scale = (0..nd).map(|i| full[(i, 0)].abs()).fold(0.0, f64::max);
    for i in 0..nd {
        assert!(
            (full[(i, 0)] - x[(i, 0)]).abs() < 1e-6 * scale,
            "{i}: {} {}",
            full[(i, 0)],
            x[(i, 0)]
        );
    }
    let recovered: f64 = (0..x.nrows()).map(|j| reduced.recovery[(0, j)] * x[(j, 0)]).sum();
    let expected: f64 = full[(n - 7, 0)];
    assert!((recovered - expected).abs() < 1e-5 * scale, "{recovered} {expected}");
}

#[test]
fn mismatched_interfaces_are_refused_by_name() {
    let good = lap();
    let system = System::try_new(&good.assembly).unwrap();
    let attempt = |top: &[u32], bottom: &[u32], frame| {
        RelativeSystem::try_new(&system, InterfacePairs { top, bottom, frame }).unwrap_err()
    };
    assert!(matches!(
        attempt(&good.top[1..], &good.bottom, FRAME),
        Error::PairCount { top: 44, bottom: 45 }
    ));
    let mut crossed = good.bottom.clone();
    crossed.swap(3, 4);
    assert!(matches!(
        attempt(&good.top, &crossed, FRAME),
        Error::PairApart { pair: 3, .. }
    ));
    let [mut tops, mut bottoms] = [good.top.clone(), good.bottom.clone()];
    tops.push(good.top[3]);
    bottoms.push(good.bottom[3]);
    let twice = attempt(&tops, &bottoms, FRAME);
    assert!(
        matches!(twice, Error::PairTwice { pair: 45, node } if node == good.top[3]),
        "{twice}"
    );
    let mut skew = FRAME;
    skew[0][1] = 0.1;
    assert!(matches!(attempt(&good.top, &good.bottom, skew), Error::Frame { .. }));
    let mut missing = good.top.clone();
    missing[0] = 1_000_000;
    assert!(matches!(
        attempt(&missing, &good.bottom, FRAME),
        Error::DependentInterface { node: 1_000_000, .. }
    ));
}

#[test]
fn wrong_number_of_zero_energy_modes_and_unbalanced_loads_are_refused() {
    let good = lap();
    let (_, relative_system) = relative(&good);
    let settings = Settings {
        expected_zem: 5,
        ..Settings::default()
    };
    let error = reduce(&relative_system, &[], settings, Limits::default()).unwrap_err();
    assert!(
        matches!(error, Error::ZeroEnergyModes { found: 6, expected: 5 }),
        "{error}"
    );
    let mut pushed = lap();
    pushed.assembly.loads[0].terms.truncate(1);
    let (_, relative_system) = relative(&pushed);
    let error = reduce(&relative_system, &[], Settings::default(), Limits::default()).unwrap_err();
    assert!(matches!(error, Error::UnbalancedLoad { .. }), "{error}");
}

#[test]
fn a_jump_that_is_fixed_stays_as_a_coordinate_that_nothing_moves() {
    // Half of a lap that is symmetric about y = 0.
    let mut half = lap();
    let on_plane = (0..).zip(&half.assembly.mesh.nodes).filter(|(_, at)| at[1] == 0.0);
    half.assembly.supports = on_plane.map(|(node, _)| Dof::Node(node, 1)).collect();
    let (system, relative_system) = relative(&half);
    let held: Vec<usize> = (0..9).map(|pair| 3 * pair + 1).collect();
    assert_eq!(relative_system.stiffness.rows(), system.n_dofs() + held.len());
    for &i in &held {
        for matrix in [&relative_system.stiffness, &relative_system.mass] {
            let row = matrix.outer_view(i).unwrap();
            let coupled: Vec<usize> = row.iter().filter(|(_, v)| **v != 0.0).map(|(j, _)| j).collect();
            assert_eq!(coupled, [i]);
            assert!(matrix.get(i, i).is_some_and(|v| *v > 0.0));
        }
        assert_eq!(relative_system.positions[i], relative_system.positions[i - 1]);
    }
    // No mode has it.
    let own = lowest_modes(&system.stiffness, &system.mass, &system.positions, 12, 1e-7).unwrap();
    let (zero, frequencies) = checks::full_frequencies(&relative_system, None, 12, 1e-7, Limits::default()).unwrap();
    assert_eq!((own.n_zero, zero), (6, 6));
    for (a, b) in own.frequencies().iter().zip(&frequencies) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
    let settings = Settings {
        expected_zem: 3,
        n_modes: 80,
        ..Settings::default()
    };
    let reduced = reduce(&relative_system, &[], settings, Limits::default()).unwrap();
    let springs = |i: usize| if held.contains(&i) { 0.0 } else { 1e8 };
    let springs = diagonal(&(0..relative_system.n_relative).map(springs).collect::<Vec<_>>());
    let small = checks::reduced_spectrum(&reduced, &springs, 12).unwrap().frequencies;
    let (_, full) = checks::full_frequencies(&relative_system, Some(&springs), 12, 1e-7, Limits::default()).unwrap();
    for (a, b) in full.iter().zip(&small) {
        assert!(b / a > 1.0 - 1e-8 && b / a < 1.0 + 3e-3, "{a} {b}");
    }
    for &i in &held {
        let others = (0..reduced.size()).filter(|&j| j != i);
        assert!(
            others
                .into_iter()
                .all(|j| entries(&reduced.stiffness)[(i, j)] == 0.0 && entries(&reduced.mass)[(i, j)].abs() < 1e-14)
        );
        let own = (entries(&reduced.stiffness)[(i, i)] / entries(&reduced.mass)[(i, i)]).sqrt() / std::f64::consts::TAU;
        assert!(own > 5.0 * small[11], "{own} {}", small[11]);
    }

    let attempt = |half: &Lap, frame| {
        let system = System::try_new(&half.assembly).unwrap();
        let (top, bottom) = (&half.top, &half.bottom);
        RelativeSystem::try_new(&system, InterfacePairs { top, bottom, frame }).unwrap_err()
    };
    let turned = [[0.6, 0.8, 0.0], [0.8, -0.6, 0.0], [0.0, 0.0, -1.0]];
    let error = attempt(&half, turned);
    assert!(
        matches!(error, Error::FixedInterface { pair: 0, component: 1 }),
        "{error}"
    );
    half.assembly
        .supports
        .retain(|dof| matches!(dof, Dof::Node(node, _) if *node != half.top[4]));
    let error = attempt(&half, FRAME);
    let expected = half.bottom[4];
    assert!(
        matches!(error, Error::DependentInterface { node, component: 1 } if node == expected),
        "{error}"
    );
}

/// Node of the lower block; those of the upper one follow.
fn node(i: u32, j: u32, k: u32) -> u32 {
    i + 13 * (j + 5 * k)
}

/// The lap with two bolts: unit forces that press the outer faces together at two places.
fn bolted() -> Lap {
    let mut lap = lap();
    lap.assembly.loads = [3, 7]
        .map(|i| LoadPattern {
            name: format!("bolt {i}"),
            terms: vec![
                (Dof::Node(260 + node(i, 2, 3), 2), -1.0),
                (Dof::Node(node(i + 4, 2, 0), 2), 1.0),
            ],
        })
        .into();
    lap
}

fn attached(n_modes: usize) -> Settings {
    Settings {
        n_modes,
        n_reported: 10,
        attachment_modes: true,
        ..Settings::default()
    }
}

/// Largest difference of two blocks relative to the largest entry.
fn difference(a: faer::MatRef<'_, f64>, b: faer::MatRef<'_, f64>) -> f64 {
    (a - b).norm_max() / a.norm_max()
}

#[test]
fn holding_the_displacement_of_loads_is_the_limit_of_stiff_springs() {
    let (_, relative) = relative(&bolted());
    let n = relative.stiffness.rows();
    let penalty = vec![1e6; relative.n_relative];
    let held = relative.locked().unwrap();
    assert_eq!(held.stiffness.rows(), n - 2);
    let (zero, held) = checks::full_frequencies(&held, Some(&diagonal(&penalty)), 10, 1e-7, Limits::default()).unwrap();
    let (_, free) =
        checks::full_frequencies(&relative, Some(&diagonal(&penalty)), 10, 1e-7, Limits::default()).unwrap();
    assert_eq!(zero, 6);
    // The compliance at a load is of the order of 1e-9 m/N: a spring k leaves 1e9 / k of the motion.
    let errors: Vec<f64> = [1e13, 1e14]
        .iter()
        .map(|spring| {
            let mut triplets = sprs::TriMat::new((n, n));
            for load in &relative.loads {
                let entries: Vec<usize> = (0..n).filter(|&i| load[i] != 0.0).collect();
                for &i in &entries {
                    entries
                        .iter()
                        .for_each(|&j| triplets.add_triplet(i, j, spring * load[i] * load[j]));
                }
            }
            let springs: sprs::CsMat<f64> = triplets.to_csr();
            let mut sprung = relative.clone();
            sprung.stiffness = &relative.stiffness + &springs;
            let (_, sprung) =
                checks::full_frequencies(&sprung, Some(&diagonal(&penalty)), 10, 1e-7, Limits::default()).unwrap();
            held.iter()
                .zip(&sprung)
                .map(|(a, b)| (b / a - 1.0).abs())
                .fold(0.0, f64::max)
        })
        .collect();
    println!("{errors:?} free {free:.1?} held {held:.1?}");
    assert!(errors[0] < 1e-4 && errors[1] < 0.2 * errors[0], "{errors:?}");
    assert!(held.iter().zip(&free).any(|(a, b)| a / b > 1.01), "{held:?} {free:?}");
}

#[test]
fn locked_reduced_spectra_converge_to_the_full_locked_ones() {
    let (_, relative) = relative(&bolted());
    let held = relative.locked().unwrap();
    let stiffnesses = [1e6, 1e8];
    let full = stiffnesses.map(|stiffness| {
        let penalty = vec![stiffness; relative.n_relative];
        checks::full_frequencies(&held, Some(&diagonal(&penalty)), 10, 1e-7, Limits::default())
            .unwrap()
            .1
    });
    let worst = |model: &ReducedModel| {
        let mut worst = [0.0_f64; 2];
        for (stiffness, full) in stiffnesses.iter().zip(&full) {
            let penalty = vec![*stiffness; relative.n_relative];
            let small = checks::reduced_spectrum(model, &diagonal(&penalty), 10)
                .unwrap()
                .frequencies;
            for (mode, (a, b)) in full.iter().zip(&small).enumerate() {
                assert!(b / a > 1.0 - 1e-8, "mode {mode} lies above the exact one: {a} {b}");
                // The first three apart, as a reduction is made for them.
                let group = usize::from(mode >= 3);
                worst[group] = worst[group].max(b / a - 1.0);
            }
        }
        worst
    };
    let errors = [5, 20, 80].map(|n_modes| {
        let reduced = reduce(&relative, &[], attached(n_modes), Limits::default()).unwrap();
        assert_eq!(reduced.size(), relative.n_relative + n_modes + 2);
        let locked = reduced.locked().unwrap();
        assert_eq!(locked.size(), relative.n_relative + n_modes);
        // What the system with the bolts eliminated from the start is reduced to with as many modes.
        let direct = Settings {
            attachment_modes: false,
            ..attached(n_modes)
        };
        let direct = reduce(&held, &[], direct, Limits::default()).unwrap();
        (worst(&locked), worst(&direct))
    });
    // The last of 22 modes taken for attachment modes: the flexibility at the loads is missing.
    let mut without = reduce(
        &relative,
        &[],
        Settings {
            attachment_modes: false,
            ..attached(22)
        },
        Limits::default(),
    )
    .unwrap();
    without.n_attachment = 2;
    let without = worst(&without.locked().unwrap());
    println!("{errors:?} without attachment modes {without:?}");
    assert!(without[0] > 5.0 * errors[1].0[0], "{without:?}");
    for (locked, direct) in &errors {
        for (locked, direct) in locked.iter().zip(direct) {
            assert!(*locked < 2.0 * direct, "{errors:?}");
        }
    }
    let locked = errors.map(|(locked, _)| locked);
    assert!(locked[1][1] < 0.5 * locked[0][1] && locked[2][1] < 0.5 * locked[1][1]);
    assert!(locked[1][0] < 1e-3 && locked[2][0] < 2e-5, "{locked:?}");
}

#[test]
fn one_load_held_and_one_given_is_the_system_with_the_first_eliminated() {
    let (_, relative) = relative(&bolted());
    let nd = relative.n_relative;
    let reduced = reduce(&relative, &[], attached(8), Limits::default()).unwrap();
    let compliance = reduced.load_compliance().unwrap();
    let (held, tension) = (3e-6, 2e3);
    let system = compliance
        .held(&[Hold::Displacement(held), Hold::Tension(tension)])
        .unwrap();
    // Stiffness over the jump, from the full system.
    let mut first = relative.clone();
    first.loads.truncate(1);
    let eliminated = first.locked().unwrap();
    let direct = reduce(&eliminated, &[], Settings::default(), Limits::default()).unwrap();
    let (of_direct, of_system) = (entries(&direct.stiffness), entries(&system.stiffness));
    let size = (0..nd).map(|i| of_direct[(i, i)]).fold(0.0, f64::max);
    for j in 0..nd {
        for i in 0..nd {
            let difference = (of_direct[(i, j)] - of_system[(i, j)]).abs();
            assert!(difference < 1e-9 * size, "{i} {j}: {difference:e} of {size:e}");
        }
    }
    // At any jump the first load has moved as it is held, and forces balance beside the jump.
    let jump: Vec<f64> = (0..nd).map(|i| 1e-6 * (i as f64).sin()).collect();
    let tensions = system.tensions(&jump);
    assert_eq!(tensions[1], tension);
    let all = compliance.displacement(&jump, &tensions);
    let work = |load: &[f64]| load.iter().zip(&all).map(|(l, u)| l * u).sum::<f64>();
    assert!((work(&reduced.loads[0]) / held - 1.0).abs() < 1e-9);
    let moved = compliance.displacements_of_loads(&jump, &tensions);
    for (load, moved) in reduced.loads.iter().zip(moved) {
        assert!((work(load) - moved).abs() < 1e-12 * held);
    }
    let force = |i: usize| -> (f64, f64) {
        let elastic = (0..all.len())
            .map(|j| entries(&reduced.stiffness)[(i, j)] * all[j])
            .sum::<f64>();
        (
            elastic,
            tensions.iter().zip(&reduced.loads).map(|(t, load)| t * load[i]).sum(),
        )
    };
    for i in nd..all.len() {
        let (elastic, load) = force(i);
        assert!(
            (elastic - load).abs() < 1e-9 * load.abs().max(1e-3),
            "{i}: {elastic} {load}"
        );
    }
    // Over the jump what is left is what the held system leaves.
    for i in 0..nd {
        let (elastic, load) = force(i);
        let own = (0..nd).map(|j| of_system[(i, j)] * jump[j]).sum::<f64>() - system.load[i];
        assert!((elastic - load - own).abs() < 1e-9 * size * 1e-6, "{i}");
    }
    let without = reduce(&relative, &[], Settings::default(), Limits::default()).unwrap();
    assert!(matches!(
        without.load_compliance(),
        Err(Error::NoAttachmentModes { .. })
    ));
}

#[test]
fn statics_of_the_locked_model_are_those_of_the_locked_system() {
    // The response of the rest to the jump is exact with any number of modes, so the whole jump block is.
    let (system, relative) = relative(&bolted());
    let held = relative.locked().unwrap();
    let mut over_independent = vec![0.0; system.n_dofs()];
    over_independent[7] = 1.0;
    let rows = |of: &RelativeSystem| [of.row(&over_independent)];
    let locked = reduce(&relative, &rows(&relative), attached(8), Limits::default())
        .unwrap()
        .locked()
        .unwrap();
    let direct = reduce(&held, &rows(&held), Settings::default(), Limits::default()).unwrap();
    let nd = relative.n_relative;
    let jump = |m: &faer::Mat<f64>| m.submatrix(0, 0, nd, nd).to_owned();
    for (name, a, b) in [
        (
            "stiffness",
            jump(&entries(&direct.stiffness)),
            jump(&entries(&locked.stiffness)),
        ),
        ("mass", jump(&entries(&direct.mass)), jump(&entries(&locked.mass))),
        (
            "recovery",
            direct.recovery.subcols(0, nd).to_owned(),
            locked.recovery.subcols(0, nd).to_owned(),
        ),
    ] {
        let error = difference(a.as_ref(), b.as_ref());
        println!("{name} {error:.1e}");
        assert!(error < 1e-8, "{name}: {error}");
    }
    let rest = entries(&locked.stiffness).nrows() - nd;
    assert_eq!(entries(&locked.stiffness).submatrix(0, nd, nd, rest).norm_max(), 0.0);
    // Stuck modes, also of the locked structure: the first follow from 8 modes and two attachment modes.
    for (a, b) in direct.stuck_frequencies.iter().zip(&locked.stuck_frequencies).take(4) {
        assert!(b / a > 1.0 - 1e-8 && b / a < 1.001, "{a} {b}");
    }
}

/// The lap with two bolts of 6 mm between rigid patches of 10 x 10 mm on the outer faces.
fn with_shanks() -> Lap {
    let mut lap = lap();
    let assembly = &mut lap.assembly;
    assembly.loads.clear();
    for (bolt, i) in (0..).zip([3, 7]) {
        let patch = |first: u32, i: u32, k: u32| Coupling {
            name: format!("bolt {bolt}"),
            reference: assembly.mesh.nodes[(first + node(i, 2, k)) as usize],
            nodes: (1..4)
                .flat_map(|j| (i - 1..=i + 1).map(move |i| first + node(i, j, k)))
                .collect(),
            kind: CouplingKind::Kinematic([true; 3]),
        };
        let ends = [patch(260, i, 3), patch(0, i + 4, 0)];
        let at = [ends[0].reference, ends[1].reference];
        assembly.couplings.extend(ends);
        let material = &assembly.mesh.materials[0];
        let section = Section::Circle(0.006);
        let shank = Shank::uniform(
            format!("bolt {bolt}"),
            [2 * bolt, 2 * bolt + 1],
            at,
            section,
            material,
            [1.0, 0.0, 0.0],
        );
        assembly.shanks.push(shank);
        assembly.loads.push(LoadPattern {
            name: format!("bolt {bolt}"),
            terms: vec![(Dof::Pretension(bolt), 1.0)],
        });
    }
    lap
}

#[test]
fn a_locked_shank_is_one_whose_overlap_is_held() {
    let lap_of_shanks = with_shanks();
    let (_, loaded) = relative(&lap_of_shanks);
    let mut held = with_shanks();
    held.assembly.loads.clear();
    held.assembly.supports = vec![Dof::Pretension(0), Dof::Pretension(1)];
    assert_eq!(held.assembly.rigid_motions().unwrap(), 6);
    let (_, held) = relative(&held);
    let penalty = diagonal(&vec![1e6; loaded.n_relative]);
    let frequencies =
        |of: &RelativeSystem| checks::full_frequencies(of, Some(&penalty), 10, 1e-8, Limits::default()).unwrap();
    let (zero, expected) = frequencies(&held);
    assert_eq!(zero, 6);
    let locked = loaded.locked().unwrap();
    assert_eq!(locked.stiffness.rows(), held.stiffness.rows());
    for (a, b) in expected.iter().zip(frequencies(&locked).1) {
        assert!((b / a - 1.0).abs() < 1e-8, "{a} {b}");
    }
    // At constant tension the axial stiffness does not act.
    let free = frequencies(&loaded).1;
    assert!(
        expected.iter().zip(&free).any(|(a, b)| a / b > 1.001),
        "{expected:?} {free:?}"
    );
    for (is_locked, expected) in [(false, &free), (true, &expected)] {
        let found = checked_frequencies(&loaded, attached(60), &penalty, is_locked);
        for (a, b) in expected.iter().zip(found) {
            assert!((b / a - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }
    let reduced = reduce(&loaded, &[], attached(60), Limits::default()).unwrap();
    let of = |model: &ReducedModel| checks::reduced_spectrum(model, &penalty, 4).unwrap().frequencies;
    for (found, full) in [(of(&reduced), &free), (of(&reduced.locked().unwrap()), &expected)] {
        for (a, b) in full.iter().zip(found) {
            println!("{a:.2} {b:.2}");
            assert!(b / a > 1.0 - 1e-8 && b / a < 1.0 + 5e-3, "{a} {b}");
        }
    }
}

/// The ten lowest frequencies of the full system that the factors of its reduction find.
fn checked_frequencies(
    relative: &RelativeSystem,
    settings: Settings,
    springs: &sprs::CsMat<f64>,
    is_locked: bool,
) -> Vec<f64> {
    let check = LinearCheck {
        springs,
        count: 10,
        tolerance: 1e-6,
        is_locked,
    };
    let found =
        reduction::reduce_with_modes(Cow::Borrowed(relative), &[], settings, Some(check), Limits::default()).unwrap();
    assert_eq!(found.frequencies.len(), 10);
    found.frequencies
}

#[test]
fn attachment_modes_complete_the_compliance_at_the_loads() {
    let (_, relative) = relative(&bolted());
    let n = relative.stiffness.rows();
    let nd = relative.n_relative;
    // Statically determinate supports at three corners, without reactions because the loads are balanced.
    let at = |x: [f64; 3]| {
        let close = |p: &[f64; 3]| p.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-9);
        (0..n).filter(|&i| close(&relative.positions[i])).collect::<Vec<_>>()
    };
    let (a, b, c) = (at([0.0; 3]), at([0.0, 0.02, 0.0]), at([0.0, 0.0, 0.01]));
    let held = [a[0], a[1], a[2], b[0], b[2], c[0]];
    let kept: Vec<usize> = (0..n).filter(|i| !held.contains(i)).collect();
    let positions: Vec<[f64; 3]> = kept.iter().map(|&i| relative.positions[i]).collect();
    let with = reduce(&relative, &[], attached(20), Limits::default()).unwrap();
    let without = reduce(&relative, &[], Settings::default(), Limits::default()).unwrap();
    for springs in [1e6, 1e8] {
        let mut triplets = sprs::TriMat::new((n, n));
        (0..nd).for_each(|i| triplets.add_triplet(i, i, springs));
        let supported = &relative.stiffness + &triplets.to_csr();
        let supported = submatrix(&supported, &kept, &numbering(&kept, n), kept.len());
        let factor = finite_elements::factor::SparseCholesky::try_new(&supported, &positions, "supported").unwrap();
        let loads = faer::Mat::from_fn(kept.len(), 2, |i, j| relative.loads[j][kept[i]]);
        let mut x = loads.clone();
        factor.solve_in_place(x.as_mut());
        let full = dense_algebra::product(loads.transpose(), x.as_ref());
        let compliance = |model: &ReducedModel| {
            let mut stiffness = entries(&model.stiffness);
            (0..nd).for_each(|i| stiffness[(i, i)] += springs);
            let lower = dense_algebra::cholesky(stiffness.as_ref()).unwrap();
            let mut half = faer::Mat::from_fn(stiffness.nrows(), 2, |i, j| model.loads[j][i]);
            dense_algebra::solve_lower(lower.as_ref(), half.as_mut());
            dense_algebra::product(half.transpose(), half.as_ref())
        };
        let error = |model| difference(full.as_ref(), compliance(model).as_ref());
        println!("compliance {:.1e} {:.1e}", error(&with), error(&without));
        assert!(error(&with) < 1e-9, "{}", error(&with));
        assert!(error(&without) > 0.01, "{}", error(&without));
    }
}

#[test]
fn locking_is_refused_without_attachment_modes_and_for_dependent_loads() {
    let (_, bolts) = relative(&bolted());
    let plain = reduce(&bolts, &[], Settings::default(), Limits::default()).unwrap();
    assert!(matches!(
        plain.locked(),
        Err(Error::NoAttachmentModes {
            loads: 2,
            attachment: 0
        })
    ));
    let mut repeated = bolted();
    repeated.assembly.loads[1] = repeated.assembly.loads[0].clone();
    let (_, repeated) = relative(&repeated);
    // A clamp between interface nodes deforms nothing while the interface is stuck.
    let (_, clamp) = relative(&lap());
    for (system, load) in [(&repeated, 1), (&clamp, 0)] {
        let error = system.locked().unwrap_err();
        assert!(
            matches!(error, Error::DependentLoad { load: l } if l == load),
            "{error}"
        );
        let error = reduce(system, &[], attached(20), Limits::default()).unwrap_err();
        assert!(
            matches!(error, Error::DependentLoad { load: l } if l == load),
            "{error}"
        );
    }
}

#[test]
fn displacements_have_the_energies_of_the_reduced_motions() {
    let (_, relative) = relative(&bolted());
    let (n, nd) = (relative.stiffness.rows(), relative.n_relative);
    let row: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == n - 1))).collect();
    let rows = [row];
    let times = |a: &sprs::CsMat<f64>, x: &faer::Mat<f64>| {
        let mut y = faer::Mat::zeros(n, x.ncols());
        finite_elements::sparse::multiply_into(a, x.as_ref(), y.as_mut());
        y
    };
    for (settings, kept) in [(Settings::default(), 20), (attached(12), 12), (attached(12), 7)] {
        let found =
            reduction::reduce_with_modes(Cow::Borrowed(&relative), &rows, settings, None, Limits::default()).unwrap();
        let (mut model, modes) = (found.model, found.modes);
        let again = reduction::modes_of_basis(&relative, settings, None, Limits::default()).unwrap();
        assert_eq!(again, modes);
        model.truncate(kept);
        // No entry is like another.
        let coordinates =
            |model: &ReducedModel| faer::Mat::from_fn(model.size(), 3, |i, j| 1e-6 * ((1 + i * (7 + j)) as f64).sin());
        let motions = coordinates(&model);
        let displacements = |motions: &faer::Mat<f64>| {
            let (motions, limits) = (motions.as_ref(), Limits::default());
            reduction::displacements(&relative, &rows, (settings, None), &model, &modes, motions, limits).unwrap()
        };
        let found = displacements(&motions);
        assert_eq!(found.subrows(0, nd), motions.subrows(0, nd));
        for (name, full, reduced) in [
            ("stiffness", &relative.stiffness, entries(&model.stiffness)),
            ("mass", &relative.mass, entries(&model.mass)),
        ] {
            let of_full = product(found.transpose(), times(full, &found).as_ref());
            let of_reduced = product(
                motions.transpose(),
                product(reduced.as_ref(), motions.as_ref()).as_ref(),
            );
            let error = difference(of_reduced.as_ref(), of_full.as_ref());
            println!("{kept} {name} {error:.1e}");
            assert!(error < 1e-9, "{kept} {name} {error:.1e}");
        }
        if model.n_attachment > 0 {
            // Motions of the locked model do no work at the loads, and have its energies.
            let (locked, basis) = model.locked_with_motions().unwrap();
            let motions = coordinates(&locked);
            let mut of_model = faer::Mat::zeros(model.size(), motions.ncols());
            let nd = model.n_relative;
            of_model.subrows_mut(0, nd).copy_from(motions.subrows(0, nd));
            of_model
                .subrows_mut(nd, basis.nrows())
                .copy_from(product(basis.as_ref(), motions.as_ref()));
            let found = displacements(&of_model);
            for load in &relative.loads {
                for motion in found.col_iter() {
                    let [work, size] = motion.iter().zip(load).fold([0.0_f64; 2], |[work, size], (u, f)| {
                        [work + u * f, size + (u * f).abs()]
                    });
                    assert!(work.abs() < 1e-9 * size, "{work:e} of {size:e}");
                }
            }
            let of_full = product(found.transpose(), times(&relative.mass, &found).as_ref());
            let of_locked = product(
                motions.transpose(),
                product(entries(&locked.mass).as_ref(), motions.as_ref()).as_ref(),
            );
            let error = difference(of_locked.as_ref(), of_full.as_ref());
            assert!(error < 1e-9, "{error:.1e}");
        }
        // Another system, and another number of modes.
        let other = reduce(&relative, &rows, attached(9), Limits::default()).unwrap();
        let motions = coordinates(&other);
        let of = |modes: &[_]| {
            let (settings, limits) = ((Settings::default(), None), Limits::default());
            reduction::displacements(&relative, &rows, settings, &other, modes, motions.as_ref(), limits)
        };
        for modes in [modes.as_slice(), &[]] {
            let refused = of(modes);
            assert!(matches!(refused, Err(Error::OtherModel { .. })), "{refused:?}");
        }
    }
}

#[test]
fn mode_shapes_satisfy_the_equations_of_motion() {
    let lap = lap();
    let system = System::try_new(&lap.assembly).unwrap();
    let pairs = InterfacePairs {
        top: &lap.top,
        bottom: &lap.bottom,
        frame: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
    };
    let relative = RelativeSystem::try_new(&system, pairs).unwrap();
    let mut springs = sprs::TriMat::new((relative.n_relative, relative.n_relative));
    (0..relative.n_relative).for_each(|i| springs.add_triplet(i, i, 1e7));
    let springs: sprs::CsMat<f64> = springs.to_csr();
    let (n, nd) = (relative.stiffness.rows(), relative.n_relative);
    let free = checks::full_modes(&relative, None, 6, 1e-8, Limits::default()).unwrap();
    let linear = checks::full_modes(&relative, Some(&springs), 6, 1e-8, Limits::default()).unwrap();
    let stuck = checks::stuck_modes(&relative, 6, 1e-8, Limits::default()).unwrap();
    assert_eq!(
        (stuck.n_zero, stuck.frequencies()),
        checks::stuck_frequencies(&relative, 6, 1e-8, Limits::default()).unwrap()
    );
    assert_eq!(
        (linear.n_zero, linear.frequencies()),
        checks::full_frequencies(&relative, Some(&springs), 6, 1e-8, Limits::default()).unwrap()
    );
    for (modes, spring, first) in [(&free, 0.0, 0), (&linear, 1e7, 0), (&stuck, 0.0, nd)] {
        let shapes = modes.elastic();
        for mode in 0..6 {
            let shape: Vec<f64> = shapes.col(mode).iter().copied().collect();
            let w2 = modes.eigenvalues[modes.n_zero + mode];
            let mut elastic = multiply_vector(&relative.stiffness, &shape);
            elastic[..nd].iter_mut().zip(&shape).for_each(|(f, u)| *f += spring * u);
            let inertia = multiply_vector(&relative.mass, &shape);
            // On a stuck interface the forces on the jump are those that hold it.
            let norm = |v: &dyn Fn(usize) -> f64| (first..n).map(|i| v(i).powi(2)).sum::<f64>().sqrt();
            let error = norm(&|i| elastic[i] - w2 * inertia[i]) / norm(&|i| w2 * inertia[i]);
            assert!(error < 1e-6, "mode {mode}: {error:.1e}");
            for other in 0..6 {
                let product: f64 = shapes.col(other).iter().zip(&inertia).map(|(a, b)| a * b).sum();
                assert!(
                    (product - f64::from(u8::from(mode == other))).abs() < 1e-10,
                    "{mode} {other}"
                );
            }
        }
    }
    // Before the change of coordinates, both sides of a stuck interface move together.
    let before = relative.displacements(stuck.elastic());
    for (top, bottom) in lap.top.iter().zip(&lap.bottom) {
        for component in 0..3 {
            let rows = [top, bottom].map(|node| system.dofs.independent_index(*node, component).unwrap());
            assert_eq!(before[(rows[0], 0)], before[(rows[1], 0)]);
        }
    }
}

/// Motions without energy of [`symmetric`], whose equations hold its turns about y and z.
const LEFT_FREE: usize = 4;

/// The lap, whose jump, rest and constraints are their own image about the plane y = 10 mm. Constraints choose which components they
/// eliminate without regard to that. `aside` is how far one node is off its place (m).
fn symmetric(aside: f64) -> (Lap, System, RelativeSystem) {
    let mut lap = bolted();
    // Not on the plane: acts on both parts.
    lap.assembly.loads.push(LoadPattern {
        name: "aside".into(),
        terms: vec![
            (Dof::Node(260 + node(5, 1, 3), 2), -1.0),
            (Dof::Node(node(9, 1, 0), 2), 1.0),
        ],
    });
    let ends = |weight: fn(u32) -> f64, c: u8| -> Vec<(Dof, f64)> {
        (0..5)
            .filter(|&j| weight(j) != 0.0)
            .flat_map(|j| {
                [
                    (Dof::Node(node(0, j, 3), c), weight(j)),
                    (Dof::Node(260 + node(12, j, 0), c), -weight(j)),
                ]
            })
            .collect()
    };
    lap.assembly.equations = [
        ("mean of z", ends(|j| f64::from(j % 2), 2)),
        ("turn about x", ends(|j| f64::from(j) - 2.0, 2)),
        ("along y", ends(|j| f64::from(u8::from(j != 2)), 1)),
    ]
    .map(|(name, terms)| Equation {
        name: name.into(),
        terms,
    })
    .into();
    lap.assembly.mesh.nodes[node(6, 1, 1) as usize][0] += aside;
    let (system, relative) = relative(&lap);
    (lap, system, relative)
}

/// The same system without knowledge of its symmetry.
fn without_symmetry(lap: &Lap, system: &System) -> RelativeSystem {
    let rows = |nodes: &[u32]| -> Vec<usize> {
        let of = |&node: &u32| (0..3).map(move |c| system.dofs.independent_index(node, c).unwrap());
        nodes.iter().flat_map(of).collect()
    };
    let matrices = SystemMatrices {
        stiffness: &system.stiffness,
        mass: &system.mass,
        loads: &system.loads,
        positions: &system.positions,
    };
    RelativeSystem::from_both_sides(matrices, &rows(&lap.top), &rows(&lap.bottom), FRAME).unwrap()
}

/// The reduced model, and in how many parts it was found.
fn reduced_in_parts(relative: &RelativeSystem, rows: &[Vec<f64>], settings: Settings) -> (ReducedModel, usize) {
    let found = reduction::reduce_with_modes(Cow::Borrowed(relative), rows, settings, None, Limits::default()).unwrap();
    (found.model, found.modes.len())
}

#[test]
fn symmetric_and_antisymmetric_parts_make_the_whole() {
    let (lap, system, relative) = symmetric(0.0);
    let whole = without_symmetry(&lap, &system);
    assert_eq!(whole.stiffness, relative.stiffness);
    let n = relative.stiffness.rows();
    let rows = [(0..n).map(|i| (i as f64).sin()).collect::<Vec<f64>>()];
    let settings = Settings {
        mode_tolerance: 1e-10,
        expected_zem: LEFT_FREE,
        ..Settings::default()
    };
    let (found, parts) = reduced_in_parts(&relative, &rows, settings);
    let (mut expected, one) = reduced_in_parts(&whole, &rows, settings);
    assert_eq!((parts, one), (2, 1));
    assert_eq!((found.zem_stuck, found.n_modes()), (LEFT_FREE, 20));
    // Springs that are their own image, and such as are not.
    let nd = relative.n_relative;
    let even = vec![1e7; nd];
    let uneven: Vec<f64> = (0..nd).map(|i| 1e7 * (1.0 + (i as f64).sin().powi(2))).collect();
    for springs in [even, uneven].map(|values| diagonal(&values)) {
        let (zero, full) = checks::full_frequencies(&whole, Some(&springs), 10, 1e-8, Limits::default()).unwrap();
        assert_eq!(zero, LEFT_FREE);
        for (a, b) in full
            .iter()
            .zip(checked_frequencies(&relative, settings, &springs, false))
        {
            assert!((b / a - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }
    // With less memory they follow one another.
    let short = Limits::default().within(Some(1 << 30));
    for given in [Cow::Borrowed(&relative), Cow::Owned(relative.clone())] {
        let again = reduction::reduce_with_modes(given, &rows, settings, None, short).unwrap();
        let again = again.model;
        assert_eq!(
            (again.stiffness, again.mass),
            (found.stiffness.clone(), found.mass.clone())
        );
    }
    expected.align_with(&found).unwrap();
    let row = |load: &Vec<f64>| faer::Mat::from_fn(1, load.len(), |_, j| load[j]);
    let mut compared = vec![
        (
            "stiffness",
            entries(&found.stiffness),
            entries(&expected.stiffness),
            1e-12,
        ),
        ("mass", entries(&found.mass), entries(&expected.mass), 1e-9),
        ("recovery", found.recovery.clone(), expected.recovery.clone(), 1e-9),
    ];
    for (a, b) in found.loads.iter().zip(&expected.loads) {
        compared.push(("load", row(a), row(b), 1e-9));
    }
    for (name, a, b, bound) in compared {
        let error = difference(b.as_ref(), a.as_ref());
        println!("{name} {error:.1e}");
        assert!(error < bound, "{name} {error:.1e}");
    }
    for (a, b) in found.stuck_frequencies.iter().zip(&expected.stuck_frequencies) {
        assert!((a / b - 1.0).abs() < 1e-11, "{a} {b}");
    }
    // Motions of both parts together.
    let modes = reduction::modes_of_basis(&relative, settings, None, Limits::default()).unwrap();
    let motions = faer::Mat::from_fn(found.size(), 2, |i, j| 1e-6 * ((1 + i * (3 + j)) as f64).sin());
    let moved = reduction::displacements(
        &relative,
        &rows,
        (settings, None),
        &found,
        &modes,
        motions.as_ref(),
        Limits::default(),
    )
    .unwrap();
    for (name, full, reduced) in [
        ("stiffness", &relative.stiffness, entries(&found.stiffness)),
        ("mass", &relative.mass, entries(&found.mass)),
    ] {
        let error = difference(
            energies(reduced.as_ref(), &motions).as_ref(),
            energies_of_full(full, &moved).as_ref(),
        );
        println!("energies by {name} {error:.1e}");
        assert!(error < 1e-9, "{name} {error:.1e}");
    }
}

/// Products of all motions with one another.
fn energies(matrix: faer::MatRef<'_, f64>, motions: &faer::Mat<f64>) -> faer::Mat<f64> {
    product(motions.transpose(), product(matrix, motions.as_ref()).as_ref())
}

fn energies_of_full(matrix: &sprs::CsMat<f64>, motions: &faer::Mat<f64>) -> faer::Mat<f64> {
    let mut momentum = faer::Mat::zeros(matrix.rows(), motions.ncols());
    finite_elements::sparse::multiply_into(matrix, motions.as_ref(), momentum.as_mut());
    product(motions.transpose(), momentum.as_ref())
}

#[test]
fn loads_with_attachment_modes_act_on_one_part_or_the_whole_is_taken() {
    let (lap, system, mut relative) = symmetric(0.0);
    let mut whole = without_symmetry(&lap, &system);
    let settings = Settings {
        expected_zem: LEFT_FREE,
        ..attached(12)
    };
    let aside = reduced_in_parts(&relative, &[], settings).1;
    assert_eq!(aside, 1, "one load is not symmetric");
    // The two bolts lie on the plane.
    for system in [&mut relative, &mut whole] {
        system.loads.truncate(2);
    }
    let (found, parts) = reduced_in_parts(&relative, &[], settings);
    let (expected, one) = reduced_in_parts(&whole, &[], settings);
    assert_eq!((parts, one), (2, 1));
    assert_eq!((found.n_attachment, found.n_modes()), (2, 12));
    // The coordinates beside the jump differ: the static response of one part has no share in the modes of the other. What is held does not.
    let [found, expected] = [found, expected].map(|model| model.locked().unwrap());
    let nd = found.n_relative;
    let jump = |a: &faer::Mat<f64>| a.submatrix(0, 0, nd, nd).to_owned();
    let stiffness = difference(
        jump(&entries(&expected.stiffness)).as_ref(),
        jump(&entries(&found.stiffness)).as_ref(),
    );
    assert!(stiffness < 1e-9, "{stiffness:.1e}");
    for (a, b) in found.stuck_frequencies.iter().zip(&expected.stuck_frequencies).take(6) {
        assert!((a / b - 1.0).abs() < 1e-7, "{a} {b}");
    }
}

#[test]
fn modes_of_parts_are_those_of_the_whole() {
    let (lap, system, relative) = symmetric(0.0);
    let whole = without_symmetry(&lap, &system);
    let uniform = vec![1e6; relative.n_relative];
    // More at one end across the plane: not symmetric.
    let mut uneven = uniform.clone();
    uneven[..9].fill(3e6);
    for (name, springs, parts_agree) in [("uniform", uniform, 1e-10), ("uneven", uneven, 1e-10)] {
        let springs = diagonal(&springs);
        let of =
            |system: &RelativeSystem| checks::full_modes(system, Some(&springs), 12, 1e-9, Limits::default()).unwrap();
        let (found, expected) = (of(&relative), of(&whole));
        assert_eq!(found.n_zero, expected.n_zero, "{name}");
        for (a, b) in found.frequencies().iter().zip(&expected.frequencies()) {
            assert!((a / b - 1.0).abs() < parts_agree, "{name} {a} {b}");
        }
        // Mass-normalised, and modes of the whole.
        let shapes = found.shapes.to_owned();
        let masses = energies_of_full(&relative.mass, &shapes);
        let unit = faer::Mat::<f64>::identity(masses.nrows(), masses.nrows());
        assert!((masses - unit).norm_max() < 1e-9, "{name}");
    }
    let stuck = |system: &RelativeSystem| checks::stuck_frequencies(system, 12, 1e-9, Limits::default()).unwrap();
    let (a, b) = (stuck(&relative), stuck(&whole));
    assert_eq!((a.0, a.1.len()), (b.0, b.1.len()));
    for (a, b) in a.1.iter().zip(&b.1) {
        assert!((a / b - 1.0).abs() < 1e-10, "{a} {b}");
    }
}

#[test]
fn a_node_off_its_place_leaves_one_part() {
    // 1e-8 is the distance of nodes that are images, relative to the 80 mm of the lap; at 1e-10 m stiffness tells.
    for (aside, expected) in [(0.0, 2), (1e-10, 1), (1e-6, 1)] {
        let (_, _, relative) = symmetric(aside);
        let settings = Settings {
            expected_zem: LEFT_FREE,
            ..Settings::default()
        };
        let (_, parts) = reduced_in_parts(&relative, &[], settings);
        assert_eq!(parts, expected, "{aside:e} m");
    }
}
