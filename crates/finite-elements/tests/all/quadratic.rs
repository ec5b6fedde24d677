//! Assemblies whose order is raised: patch test, rigid motions, volumes of curved walls, and what is carried over.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use finite_elements::assemble::System;
use finite_elements::constraints::DofMap;
use finite_elements::eigen::lowest_modes;
use finite_elements::elements::{
    CORNERS, Cell, Face, Formulation, HEX8, HEX20, HEX27, TET4, TET10, WEDGE6, WEDGE15, matrices,
};
use finite_elements::mesh::{
    Assembly, BeyondTolerance, Coupling, CouplingKind, Dof, Element, Equation, Material, Mesh, Tie,
};
use finite_elements::sparse::multiply_vector;
use finite_elements::{Error, Quadratic};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};

fn steel() -> Material {
    Material {
        name: "steel".into(),
        youngs_modulus: 2e11,
        poisson_ratio: 0.3,
        density: 7800.0,
    }
}

/// What a box is cut into.
#[derive(Clone, Copy)]
enum Cut {
    Hexahedron,
    Wedges,
    Tetrahedra,
}

/// Linear elements that fill the unit cube in `n` boxes per edge, cut in turn along x. Inner nodes are displaced.
fn cube(n: usize, cuts: &[Cut]) -> Mesh {
    let mut mesh = Mesh {
        materials: vec![steel()],
        ..Mesh::default()
    };
    let node = |i: usize, j: usize, k: usize| ((i * (n + 1) + j) * (n + 1) + k) as u32;
    for (i, j, k) in (0..=n).flat_map(|i| (0..=n).flat_map(move |j| (0..=n).map(move |k| (i, j, k)))) {
        let at = [i, j, k];
        let inside = at.iter().all(|&c| 0 < c && c < n);
        let shift = if inside { 0.08 / n as f64 } else { 0.0 };
        let seed = f64::from(node(i, j, k));
        mesh.nodes
            .push([0, 1, 2].map(|c| at[c] as f64 / n as f64 + shift * (seed * (c + 1) as f64).sin()));
    }
    for (i, j, k) in (0..n).flat_map(|i| (0..n).flat_map(move |j| (0..n).map(move |k| (i, j, k)))) {
        let c = CORNERS.map(|x| {
            let up = x.map(|s| usize::from(s > 0.0));
            node(i + up[0], j + up[1], k + up[2])
        });
        let around = [1, 2, 3, 7, 4, 5, 1];
        let cells: Vec<Cell> = match cuts[i % cuts.len()] {
            Cut::Wedges => {
                let parts = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]];
                parts.map(|part| Cell::wedge6(part.map(|local| c[local]))).into()
            }
            Cut::Tetrahedra => {
                let pairs = around.windows(2);
                pairs
                    .map(|pair| Cell::tet4([c[0], c[pair[0]], c[pair[1]], c[6]]))
                    .collect()
            }
            Cut::Hexahedron => vec![Cell::hex8(c, Formulation::IncompatibleModes)],
        };
        mesh.elements
            .extend(cells.into_iter().map(|cell| Element { cell, material: 0 }));
    }
    mesh
}

fn assembly(mesh: Mesh) -> Assembly {
    Assembly {
        mesh,
        ..Assembly::default()
    }
}

fn raised(assembly: &Assembly) -> Quadratic {
    Quadratic::try_new(assembly, |_| None).unwrap()
}

#[test]
fn each_type_has_the_quadratic_one_on_its_corners() {
    for (linear, quadratic) in [(&HEX8, &HEX20), (&WEDGE6, &WEDGE15), (&TET4, &TET10)] {
        assert_eq!(linear.quadratic(), Some(quadratic));
        assert_eq!(quadratic.quadratic(), None);
    }
    assert_eq!(HEX27.quadratic(), None);
}

#[test]
fn neighbours_share_one_node_per_edge() {
    let n = 3;
    let linear = cube(n, &[Cut::Hexahedron]);
    let quadratic = raised(&assembly(linear.clone()));
    let mesh = &quadratic.assembly.mesh;
    let (corners, edges) = ((n + 1).pow(3), 3 * n * (n + 1) * (n + 1));
    assert_eq!((linear.nodes.len(), mesh.nodes.len()), (corners, corners + edges));
    assert_eq!(mesh.nodes[..corners], linear.nodes[..]);
    let places: BTreeSet<[u64; 3]> = mesh.nodes.iter().map(|x| x.map(f64::to_bits)).collect();
    assert_eq!(places.len(), mesh.nodes.len());
    for (linear, quadratic) in linear.elements.iter().zip(&mesh.elements) {
        assert_eq!(quadratic.cell.element_type(), &HEX20);
        assert_eq!(quadratic.cell.formulation(), Formulation::Reduced);
        assert_eq!(quadratic.cell.nodes()[..8], *linear.cell.nodes());
    }
    let [a, b] = [0, 1].map(|local| linear.elements[0].cell.nodes()[local]);
    let middle = quadratic.middle([b, a]).unwrap();
    assert_eq!(quadratic.middle([a, b]), Some(middle));
    let mean = [0, 1, 2].map(|c| 0.5 * (mesh.nodes[a as usize][c] + mesh.nodes[b as usize][c]));
    assert_eq!(mesh.nodes[middle as usize], mean);
    assert_eq!(quadratic.middle([linear.elements[0].cell.nodes()[6], a]), None);
}

#[test]
fn raised_meshes_pass_the_patch_test() {
    for cuts in [
        &[Cut::Hexahedron][..],
        &[Cut::Hexahedron, Cut::Wedges],
        &[Cut::Tetrahedra],
    ] {
        let quadratic = raised(&assembly(cube(3, cuts))).assembly;
        let system = System::try_new(&quadratic).unwrap();
        let strain = [[1e-3, 4e-4, -2e-4], [3e-4, -5e-4, 7e-4], [2e-4, 6e-4, 9e-4]];
        let field: Vec<f64> = (quadratic.mesh.nodes.iter())
            .flat_map(|x| strain.map(|row| (0..3).map(|c| row[c] * x[c]).sum::<f64>()))
            .collect();
        let force = multiply_vector(&system.stiffness, &field);
        let largest = force.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
        let mut inner = 0;
        for (x, force) in quadratic.mesh.nodes.iter().zip(force.chunks(3)) {
            if x.iter().all(|&c| 1e-6 < c && c < 1.0 - 1e-6) {
                inner += 1;
                assert!(
                    force.iter().all(|f| f.abs() < 1e-12 * largest),
                    "{force:?} of {largest}"
                );
            }
        }
        assert!(inner > 20);
    }
}

/// Two cubes one upon the other, tied, with a distributing coupling on top, kinematic one below.
fn stack() -> Assembly {
    let (mut mesh, upper) = (cube(2, &[Cut::Hexahedron]), cube(3, &[Cut::Hexahedron]));
    let first = mesh.nodes.len() as u32;
    mesh.nodes.extend(upper.nodes.iter().map(|x| [x[0], x[1], x[2] + 1.0]));
    mesh.elements.extend(upper.elements.iter().map(|element| Element {
        cell: element.cell.map_nodes(|node| node + first),
        material: 0,
    }));
    let at = |from: u32, z: f64| -> Vec<u32> {
        let nodes = (from..).zip(&mesh.nodes[from as usize..]);
        nodes.filter(|(_, x)| x[2] == z).map(|(node, _)| node).collect()
    };
    let faces = mesh.elements[..8].iter().flat_map(|element| element.cell.faces());
    let on_top = |face: &Face| face.nodes().iter().all(|&node| mesh.nodes[node as usize][2] == 1.0);
    let tie = Tie {
        name: "tie".into(),
        slave_nodes: at(first, 1.0),
        master_faces: faces.filter(on_top).collect(),
        position_tolerance: 1e-9,
        beyond: BeyondTolerance::Refuse,
        adjust: true,
    };
    assert_eq!((tie.slave_nodes.len(), tie.master_faces.len()), (16, 4));
    let top = at(first, 2.0);
    // Tributary areas.
    let share = |x: f64| if x == 0.0 || x == 1.0 { 0.5 } else { 1.0 };
    let weights = top.iter().map(|&node| {
        let x = mesh.nodes[node as usize];
        share(x[0]) * share(x[1]) / 9.0
    });
    let coupling = |name: &str, z, nodes, kind| Coupling {
        name: name.into(),
        reference: [0.5, 0.5, z],
        nodes,
        kind,
    };
    let kinds = [
        CouplingKind::Distributing(weights.collect()),
        CouplingKind::Kinematic([true; 3]),
    ];
    let [distributing, kinematic] = kinds;
    let couplings = vec![
        coupling("top", 2.0, top, distributing),
        coupling("bottom", -0.2, at(0, 0.0), kinematic),
    ];
    Assembly {
        ties: vec![tie],
        couplings,
        ..assembly(mesh)
    }
}

#[test]
fn rigid_motions_of_connected_bodies_cost_no_energy() {
    let quadratic = raised(&stack()).assembly;
    let system = System::try_new(&quadratic).unwrap();
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 4, 1e-8).unwrap();
    assert_eq!(modes.n_zero, 6);
    let linear = System::try_new(&stack()).unwrap();
    let of_linear = lowest_modes(&linear.stiffness, &linear.mass, &linear.positions, 4, 1e-8).unwrap();
    for (a, b) in modes.frequencies().iter().zip(of_linear.frequencies()) {
        println!("{a:.1} {b:.1}");
        assert!(*a < b && *a > 0.8 * b, "{a} {b}");
    }
    assert!((system.total_mass / 15_600.0 - 1.0).abs() < 1e-12);
}

#[test]
fn connections_are_those_of_the_quadratic_faces() {
    let linear = stack();
    let quadratic = raised(&linear);
    let nodes = &quadratic.assembly.mesh.nodes;
    let tie = &quadratic.assembly.ties[0];
    // 16 corners and 24 edges.
    assert_eq!(tie.slave_nodes.len(), 40);
    assert!(tie.slave_nodes.iter().all(|&node| nodes[node as usize][2] == 1.0));
    assert!(tie.master_faces.iter().all(|face| face.nodes().len() == 8));
    let [top, bottom] = [0, 1].map(|index| &quadratic.assembly.couplings[index]);
    assert_eq!(bottom.nodes.len(), 9 + 12);
    assert!(bottom.nodes.iter().all(|&node| nodes[node as usize][2] == 0.0));
    // Consistent forces of a uniform traction with the corners' parts moved to the middles: a quarter of each face's area.
    let CouplingKind::Distributing(weights) = &top.kind else {
        panic!("distributing");
    };
    assert_eq!((top.nodes.len(), weights.len()), (24, 24));
    for (&node, weight) in top.nodes.iter().zip(weights) {
        let x = nodes[node as usize];
        let on_edge = x[..2].iter().any(|&c| c == 0.0 || c == 1.0);
        let expected = if on_edge { 0.25 } else { 0.5 } / 9.0;
        assert!(x[2] == 2.0 && (weight / expected - 1.0).abs() < 1e-12, "{x:?} {weight}");
    }

    // A node by itself keeps its weight.
    let mut sparse = linear.clone();
    let alone = vec![sparse.couplings[0].nodes[0], sparse.couplings[0].nodes[3], 0];
    sparse.couplings[0].nodes = alone.clone();
    sparse.couplings[0].kind = CouplingKind::Distributing(vec![1.0, 2.0, 3.0]);
    let found = &raised(&sparse).assembly.couplings[0];
    let CouplingKind::Distributing(weights) = &found.kind else {
        panic!("distributing");
    };
    let found: BTreeMap<u32, f64> = found.nodes.iter().copied().zip(weights.iter().copied()).collect();
    assert_eq!(found, alone.into_iter().zip([1.0, 2.0, 3.0]).collect());
}

#[test]
fn edges_stay_straight_where_slaves_are_moved() {
    // The upper cube begins a third of its elements above the lower one.
    let mut apart = stack();
    let tie = &mut apart.ties[0];
    tie.position_tolerance = 0.2;
    for &slave in &tie.slave_nodes {
        apart.mesh.nodes[slave as usize][2] += 0.11;
    }
    for adjust in [true, false] {
        apart.ties[0].adjust = adjust;
        let quadratic = raised(&apart);
        let dofs = DofMap::try_new(&quadratic.assembly).unwrap();
        assert!((dofs.largest_adjustment - if adjust { 0.11 } else { 0.0 }).abs() < 1e-12);
        let at = |node: u32| dofs.coordinates[node as usize];
        let mut edges = 0;
        for [a, b] in all_pairs(&apart.mesh) {
            if let Some(middle) = quadratic.middle([a, b]) {
                edges += 1;
                let distance = (0..3).map(|c| (at(middle)[c] - 0.5 * (at(a)[c] + at(b)[c])).abs());
                let largest = distance.fold(0.0, f64::max);
                assert!(largest < 1e-12, "{:?} to {:?}: {largest}", at(a), at(b));
            }
        }
        // 54 edges of the lower cube, 144 of the upper one.
        assert_eq!(edges, 54 + 144);
    }
}

/// Pairs of nodes of one element, each once.
fn all_pairs(mesh: &Mesh) -> BTreeSet<[u32; 2]> {
    let of_element = |element: &Element| {
        let nodes = element.cell.nodes().to_vec();
        let pairs = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| [a, b]));
        pairs.filter(|[a, b]| a < b).collect::<Vec<_>>()
    };
    mesh.elements.iter().flat_map(of_element).collect()
}

#[test]
fn supports_hold_the_middles_between_them() {
    let mut linear = assembly(cube(2, &[Cut::Wedges, Cut::Hexahedron]));
    let held = (0_u32..).zip(&linear.mesh.nodes).filter(|(_, x)| x[0] == 0.0);
    linear.supports = held.map(|(node, _)| Dof::Node(node, 1)).collect();
    let quadratic = raised(&linear).assembly;
    assert_eq!((linear.supports.len(), quadratic.supports.len()), (9, 21));
    for support in &quadratic.supports {
        let Dof::Node(node, 1) = support else {
            panic!("{support:?}");
        };
        assert_eq!(quadratic.mesh.nodes[*node as usize][0], 0.0);
    }
}

#[test]
fn what_cannot_be_raised_is_refused() {
    let refused = |assembly: &Assembly| Quadratic::try_new(assembly, |_| None).unwrap_err();
    let good = assembly(cube(1, &[Cut::Hexahedron]));
    let twice = refused(&raised(&good).assembly);
    assert!(
        matches!(
            twice,
            Error::NotLinear {
                element: 0,
                element_type: "Hex20"
            }
        ),
        "{twice}"
    );
    let mut linked = good.clone();
    linked.equations.push(Equation {
        name: "mirror".into(),
        terms: vec![(Dof::Node(0, 0), 1.0), (Dof::Node(1, 0), 1.0)],
    });
    let message = refused(&linked).to_string();
    assert!(message.contains("equation `mirror`"), "{message}");
    let mut diagonal = stack();
    diagonal.ties[0].master_faces.push(Face::quad4([0, 1, 5, 26]));
    let message = refused(&diagonal).to_string();
    assert!(message.contains("tie `tie`"), "{message}");
    let mut short = stack();
    short.couplings[0].nodes.pop();
    assert!(matches!(refused(&short), Error::Coupling { .. }));
    let mut nowhere = Quadratic::try_new(&good, |_| Some([f64::NAN; 3]));
    assert!(matches!(nowhere, Err(Error::NotFinite { .. })));
    nowhere = Quadratic::try_new(
        &assembly(Mesh {
            nodes: vec![[0.0; 3]; 2],
            ..good.mesh.clone()
        }),
        |_| None,
    );
    assert!(matches!(nowhere, Err(Error::Dangling { .. })));
}

/// A wall between two radii in `n` sectors, one element thick; its volume relative to the exact one, less one.
fn wall(n: usize, curved: bool) -> f64 {
    let (radii, height) = ([0.5, 1.0], 0.3);
    let at = |r: f64, k: f64, z: f64| {
        let (sin, cos) = (TAU * k / n as f64).sin_cos();
        [r * cos, r * sin, z]
    };
    let mut mesh = Mesh {
        materials: vec![steel()],
        ..Mesh::default()
    };
    for k in 0..n {
        for z in [0.0, height] {
            mesh.nodes.extend(radii.map(|r| at(r, k as f64, z)));
        }
    }
    for k in 0..n {
        let [a, b] = [k, (k + 1) % n].map(|k| 4 * k as u32);
        let nodes = [a, a + 1, b + 1, b, a + 2, a + 3, b + 3, b + 2];
        mesh.elements.push(Element {
            cell: Cell::hex8(nodes, Formulation::IncompatibleModes),
            material: 0,
        });
    }
    let on_circle = |[a, b]: [u32; 2]| {
        let same_place = a % 4 == b % 4;
        let sectors = [a, b].map(|node| f64::from(node / 4));
        // The last sector ends where the first begins.
        let half = if (sectors[1] - sectors[0]).abs() > 1.5 {
            -0.5
        } else {
            0.5
        };
        (curved && same_place).then(|| {
            at(
                radii[a as usize % 2],
                sectors[0] + half,
                [0.0, height][a as usize % 4 / 2],
            )
        })
    };
    let mesh = Quadratic::try_new(&assembly(mesh), on_circle).unwrap().assembly.mesh;
    let mass: f64 = (mesh.elements.iter().enumerate())
        .map(|(index, element)| {
            let x: Vec<_> = element
                .cell
                .nodes()
                .iter()
                .map(|&node| mesh.nodes[node as usize])
                .collect();
            matrices(index, &element.cell, &x, &steel())
                .unwrap()
                .mass
                .iter()
                .sum::<f64>()
        })
        .sum();
    mass / (7800.0 * PI * (1.0 - 0.25) * height) - 1.0
}

#[test]
fn volumes_of_walls_converge_with_curved_edges() {
    for (curved, order) in [(false, 2.0), (true, 4.0)] {
        let errors = [8, 16, 32].map(|n| wall(n, curved));
        println!("curved {curved}: {errors:?}");
        for pair in errors.windows(2) {
            let observed = (pair[0] / pair[1]).log2();
            assert!((observed - order).abs() < 0.1, "{observed}");
        }
    }
    // A parabola through three points of a circle encloses h^4/30 too little.
    assert!((wall(16, true) / -((PI / 16.0).powi(4) / 30.0) - 1.0).abs() < 0.05);
}
