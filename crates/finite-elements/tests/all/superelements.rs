//! Bodies that come as matrices.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use crate::blocks::{add_block, plane, steel};
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::mesh::{Assembly, Dof, Mesh, Superelement};

const CELLS: [usize; 3] = [5, 2, 2];
const SIZE: [f64; 3] = [0.1, 0.02, 0.03];

/// A bar along x from `at`, of this many lengths of [`SIZE`].
fn bar(at: f64, lengths: usize) -> Assembly {
    let mut mesh = Mesh {
        materials: vec![steel()],
        ..Mesh::default()
    };
    let [x, y, z] = SIZE;
    let [nx, ny, nz] = CELLS;
    add_block(
        &mut mesh,
        [at, 0.0, 0.0],
        [lengths as f64 * x, y, z],
        [lengths * nx, ny, nz],
    );
    Assembly {
        mesh,
        ..Assembly::default()
    }
}

fn at(assembly: &Assembly, x: f64) -> Vec<u32> {
    let all: Vec<u32> = (0..assembly.mesh.nodes.len() as u32).collect();
    plane(&assembly.mesh, &all, 0, x)
}

/// The second half of the bar by its matrices, joined to the end of the first.
fn by_matrices(half: &Assembly, first: &Assembly) -> Superelement {
    let system = System::try_new(half).unwrap();
    let (own, other) = (at(half, SIZE[0]), at(first, SIZE[0]));
    let coordinates = system.dofs.independent.iter().map(|full| {
        let node = (full / 3) as u32;
        let place = own.iter().position(|one| *one == node)?;
        Some((other[place], (full % 3) as u8))
    });
    Superelement {
        name: "half".into(),
        coordinates: coordinates.collect(),
        stiffness: system.stiffness.clone(),
        mass: system.mass.clone(),
        is_held: !half.supports.is_empty(),
    }
}

fn frequencies(assembly: &Assembly) -> (usize, Vec<f64>) {
    let system = System::try_new(assembly).unwrap();
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 8, 1e-9).unwrap();
    (modes.n_zero, modes.frequencies())
}

#[test]
fn a_bar_whose_half_comes_as_matrices_is_the_whole_bar() {
    let (whole, mut first) = (bar(0.0, 2), bar(0.0, 1));
    first.superelements = vec![by_matrices(&bar(SIZE[0], 1), &first)];
    assert_eq!(first.rigid_motions().unwrap(), 6);
    let ((n, expected), (found_n, found)) = (frequencies(&whole), frequencies(&first));
    assert_eq!((n, found_n), (6, 6));
    for (a, b) in found.iter().zip(&expected) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} Hz against {b}");
    }
    let [own, other] = [&first, &whole].map(|assembly| System::try_new(assembly).unwrap());
    assert!((own.total_mass / other.total_mass - 1.0).abs() < 1e-12);
    for (a, b) in own.momenta.iter().zip(&other.momenta) {
        assert!((a.iter().sum::<f64>() / b.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn supports_of_a_superelement_hold_the_structure() {
    let hold = |mut assembly: Assembly| {
        let nodes = at(&assembly, 2.0 * SIZE[0]);
        assembly.supports = nodes
            .iter()
            .flat_map(|&node| (0..3).map(move |c| Dof::Node(node, c)))
            .collect();
        assembly
    };
    let (whole, mut first) = (hold(bar(0.0, 2)), bar(0.0, 1));
    let half = by_matrices(&hold(bar(SIZE[0], 1)), &first);
    first.superelements = vec![half.clone()];
    assert_eq!(first.rigid_motions().unwrap(), 0);
    for (a, b) in frequencies(&first).1.iter().zip(frequencies(&whole).1) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} Hz against {b}");
    }
    // One that is held unsaid may as well be joined by the wrong nodes.
    first.superelements[0].is_held = false;
    let error = System::try_new(&first).unwrap_err().to_string();
    assert!(error.contains("resists 6 of six") && error.contains("held"), "{error}");
}

#[test]
fn superelements_that_do_not_fit_the_mesh_are_refused() {
    let first = bar(0.0, 1);
    let half = by_matrices(&bar(SIZE[0], 1), &first);
    let refusal = |change: &dyn Fn(&mut Superelement)| {
        let mut assembly = first.clone();
        let mut own = half.clone();
        change(&mut own);
        assembly.superelements = vec![own];
        assert!(assembly.rigid_motions().is_err());
        System::try_new(&assembly).unwrap_err().to_string()
    };
    let joined: Vec<usize> = (0..half.coordinates.len())
        .filter(|&row| half.coordinates[row].is_some())
        .collect();
    // Nodes in another order.
    let turned = refusal(&|own| {
        for (row, from) in joined.iter().zip(joined.iter().cycle().skip(3)) {
            let component = half.coordinates[*row].unwrap().1;
            own.coordinates[*row] = Some((half.coordinates[*from].unwrap().0, component));
        }
    });
    assert!(turned.contains("other labels"), "{turned}");
    let line = refusal(&|own| {
        let first = half.coordinates[joined[0]].unwrap().0;
        own.coordinates
            .iter_mut()
            .for_each(|at| *at = at.filter(|(node, _)| *node == first));
    });
    assert!(line.contains("too few"), "{line}");
    let twice = refusal(&|own| own.coordinates[joined[0]] = half.coordinates[joined[1]]);
    assert!(twice.contains("two of its coordinates"), "{twice}");
    let nowhere = refusal(&|own| own.coordinates[joined[0]] = Some((1_000_000, 0)));
    assert!(nowhere.contains("not in the mesh"), "{nowhere}");
    let short = refusal(&|own| {
        own.coordinates.pop();
    });
    assert!(short.contains("instead of"), "{short}");
}
