//! Every element formulation: zero-energy modes, patch tests, rates of convergence.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use faer::Mat;
use std::collections::BTreeSet;
use substructure::Error;
use substructure::assemble::System;
use substructure::eigen::lowest_modes;
use substructure::elements::{CORNERS, ELEMENT_TYPES, ElementType, FACE_TYPES, FaceType, Formulation, matrices};
use substructure::factor::SparseCholesky;
use substructure::mesh::{Assembly, BeyondTolerance, Cell, Element, Material, Mesh, Tie};
use substructure::sparse::multiply_vector;

type Point = [f64; 3];

const HEXAHEDRA: [Formulation; 4] = [
    Formulation::IncompatibleModes,
    Formulation::BBar,
    Formulation::Full,
    Formulation::Reduced,
];

fn material(poisson_ratio: f64) -> Material {
    Material {
        name: "test".into(),
        youngs_modulus: 192.85e9,
        poisson_ratio,
        density: 7857.8,
    }
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Hex(Formulation),
    Wedge,
    Tet4,
    Tet10,
}

fn kinds() -> impl Iterator<Item = Kind> {
    HEXAHEDRA
        .map(Kind::Hex)
        .into_iter()
        .chain([Kind::Wedge, Kind::Tet4, Kind::Tet10])
}

/// A number between -1 and 1 that belongs to `seed`.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03;
    x ^= x >> 31;
    x = x.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x ^= x >> 29;
    (x % 20_001) as f64 / 10_000.0 - 1.0
}

/// The cube from 0 to `size` in `n` cells per edge, inner nodes moved by up to `distortion` cells, cut into `kind`.
fn cube(kind: Kind, n: usize, size: f64, distortion: f64, poisson_ratio: f64) -> Mesh {
    let mut mesh = Mesh {
        materials: vec![material(poisson_ratio)],
        ..Mesh::default()
    };
    let h = size / n as f64;
    for k in 0..=n {
        for j in 0..=n {
            for i in 0..=n {
                let seed = 3 * mesh.nodes.len() as u64;
                let at = [i, j, k];
                let inside = at.iter().all(|&c| c > 0 && c < n);
                mesh.nodes.push([0, 1, 2].map(|c| {
                    let moved = if inside {
                        distortion * noise(seed + c as u64)
                    } else {
                        0.0
                    };
                    h * (at[c] as f64 + moved)
                }));
            }
        }
    }
    let node = |i: usize, j: usize, k: usize| (i + (n + 1) * (j + (n + 1) * k)) as u32;
    let mut middles = std::collections::BTreeMap::new();
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                let c = CORNERS.map(|x| {
                    let up = x.map(|s| usize::from(s > 0.0));
                    node(i + up[0], j + up[1], k + up[2])
                });
                let mut add = |cell| mesh.elements.push(Element { cell, material: 0 });
                // Around the diagonal from corner 0 to corner 6.
                let around = [1, 2, 3, 7, 4, 5, 1];
                match kind {
                    Kind::Hex(formulation) => add(Cell::hex8(c, formulation)),
                    Kind::Wedge => {
                        add(Cell::wedge6([c[0], c[1], c[2], c[4], c[5], c[6]]));
                        add(Cell::wedge6([c[0], c[2], c[3], c[4], c[6], c[7]]));
                    }
                    Kind::Tet4 => {
                        for pair in around.windows(2) {
                            add(Cell::tet4([c[0], c[pair[0]], c[pair[1]], c[6]]));
                        }
                    }
                    Kind::Tet10 => {
                        for pair in around.windows(2) {
                            let corners = [c[0], c[pair[0]], c[pair[1]], c[6]];
                            let mut nodes = [0; 10];
                            nodes[..4].copy_from_slice(&corners);
                            for (e, [a, b]) in [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]].into_iter().enumerate()
                            {
                                let ends = [corners[a].min(corners[b]), corners[a].max(corners[b])];
                                nodes[4 + e] = *middles.entry(ends).or_insert_with(|| {
                                    let [p, q] = ends.map(|n| mesh.nodes[n as usize]);
                                    mesh.nodes.push([0, 1, 2].map(|c| 0.5 * (p[c] + q[c])));
                                    mesh.nodes.len() as u32 - 1
                                });
                            }
                            mesh.elements.push(Element {
                                cell: Cell::tet10(nodes),
                                material: 0,
                            });
                        }
                    }
                }
            }
        }
    }
    mesh
}

/// Displacement of all nodes under body forces `force` (per volume) if the surface moves as `exact`.
fn solve(mesh: &Mesh, size: f64, exact: impl Fn(Point) -> Point, force: impl Fn(Point) -> Point) -> (System, Vec<f64>) {
    let system = System::try_new(&Assembly {
        mesh: mesh.clone(),
        ..Assembly::default()
    })
    .unwrap();
    let on_surface = |x: &Point| x.iter().any(|&v| v < 1e-9 * size || v > (1.0 - 1e-9) * size);
    let at_nodes = |f: &dyn Fn(Point) -> Point| mesh.nodes.iter().flat_map(|&x| f(x)).collect::<Vec<f64>>();
    let mut u = at_nodes(&exact);
    let density = mesh.materials[0].density;
    let inner: Vec<usize> = (0..u.len()).filter(|&d| !on_surface(&mesh.nodes[d / 3])).collect();
    for &d in &inner {
        u[d] = 0.0;
    }
    let known = multiply_vector(&system.stiffness, &u);
    let loads = multiply_vector(&system.mass, &at_nodes(&force));
    let mut place = vec![usize::MAX; u.len()];
    for (i, &d) in inner.iter().enumerate() {
        place[d] = i;
    }
    let mut block = sprs::TriMat::new((inner.len(), inner.len()));
    for (row, line) in system.stiffness.outer_iterator().enumerate() {
        for (column, &value) in line.iter() {
            if place[row] != usize::MAX && place[column] != usize::MAX {
                block.add_triplet(place[row], place[column], value);
            }
        }
    }
    let positions: Vec<Point> = inner.iter().map(|&d| mesh.nodes[d / 3]).collect();
    let factor = SparseCholesky::try_new(&block.to_csr(), &positions, "stiffness of the inner nodes").unwrap();
    let mut x = Mat::from_fn(inner.len(), 1, |i, _| loads[inner[i]] / density - known[inner[i]]);
    factor.solve_in_place(x.as_mut());
    for (i, &d) in inner.iter().enumerate() {
        u[d] = x[(i, 0)];
    }
    (system, u)
}

/// The nodes of one distorted element of each kind (m).
fn distorted(kind: Kind) -> (Cell, Vec<Point>) {
    let jitter = |x: Vec<Point>| -> Vec<Point> {
        x.iter()
            .enumerate()
            .map(|(a, x)| [0, 1, 2].map(|i| 1e-3 * (x[i] * (i + 1) as f64 + 0.1 * noise((7 * a + i) as u64))))
            .collect()
    };
    let tet = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    match kind {
        Kind::Hex(f) => (
            Cell::hex8([0; 8], f),
            jitter(CORNERS.map(|c| c.map(|v| 0.5 * v)).to_vec()),
        ),
        Kind::Wedge => {
            let level = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
            (Cell::wedge6([0; 6]), jitter([level(0.0), level(1.0)].concat()))
        }
        Kind::Tet4 => (Cell::tet4([0; 4]), jitter(tet)),
        Kind::Tet10 => {
            let corners = jitter(tet);
            let middles = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]
                .map(|[a, b]| [0, 1, 2].map(|i| 0.5 * (corners[a][i] + corners[b][i])));
            (Cell::tet10([0; 10]), [corners, middles.to_vec()].concat())
        }
    }
}

#[test]
fn rigid_motion_costs_no_energy_and_nothing_else_is_free() {
    for kind in kinds() {
        let (cell, x) = distorted(kind);
        let found = matrices(0, &cell, &x, &material(0.29)).unwrap();
        let n = 3 * found.n_nodes;
        let k = Mat::from_fn(n, n, |i, j| found.stiffness[i * n + j]);
        let values = dense_algebra::symmetric_eigenvalues(k.as_ref()).unwrap();
        let largest = values[n - 1];
        let zero = values.iter().filter(|v| v.abs() < 1e-11 * largest).count();
        assert_eq!(zero, 6, "{kind:?}: {values:?}");
        assert!(values[0] > -1e-12 * largest, "{kind:?}");
        assert!(values[6] > 1e-5 * largest, "{kind:?}: {values:?}");
    }
}

#[test]
fn mass_is_that_of_the_volume_and_centroid() {
    for kind in kinds() {
        let (cell, x) = distorted(kind);
        let found = matrices(0, &cell, &x, &material(0.29)).unwrap();
        let n = found.n_nodes;
        let total: f64 = found.mass.iter().sum();
        // The volume by the divergence theorem over the faces, each cut into triangles about its middle.
        let mut number = 0..;
        let local = cell.map_nodes(|_| number.next().unwrap());
        let mut volume = 0.0;
        for face in local.faces() {
            let corners: Vec<Point> = match face.nodes() {
                six if six.len() == 6 => six[..3].iter().map(|&a| x[a as usize]).collect(),
                all => all.iter().map(|&a| x[a as usize]).collect(),
            };
            let count = corners.len();
            let middle = [0, 1, 2].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / count as f64);
            for a in 0..count {
                let (p, q) = (corners[a], corners[(a + 1) % count]);
                let cross = [
                    p[1] * q[2] - p[2] * q[1],
                    p[2] * q[0] - p[0] * q[2],
                    p[0] * q[1] - p[1] * q[0],
                ];
                volume += (0..3).map(|i| middle[i] * cross[i]).sum::<f64>() / 6.0;
            }
        }
        // A bilinear face differs from its triangles about the middle by a higher order of its warp.
        let tolerance = if matches!(kind, Kind::Tet4 | Kind::Tet10) {
            1e-12
        } else {
            1e-2
        };
        assert!(
            (total / (7857.8 * volume) - 1.0).abs() < tolerance,
            "{kind:?}: {total} {volume}"
        );
        for a in 0..n {
            for b in 0..n {
                assert!((found.mass[a * n + b] - found.mass[b * n + a]).abs() < 1e-15 * total);
            }
        }
    }
}

#[test]
fn patches_of_distorted_elements_carry_constant_strain_exactly() {
    let h = [[1e-3, 2e-4, -3e-4], [5e-4, -7e-4, 1e-4], [2e-4, 6e-4, 4e-4]];
    let linear = |x: Point| h.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
    for kind in kinds() {
        // Beyond 0.1 cells some tetrahedra turn inside out.
        let mesh = cube(kind, 3, 0.02, 0.1, 0.29);
        let (_, u) = solve(&mesh, 0.02, linear, |_| [0.0; 3]);
        for (node, &x) in mesh.nodes.iter().enumerate() {
            for (i, exact) in linear(x).into_iter().enumerate() {
                assert!((u[3 * node + i] - exact).abs() < 1e-15, "{kind:?} {x:?}");
            }
        }
    }
}

/// A smooth displacement (m) of the unit cube, its nodes' force per volume for `material`.
fn manufactured(material: &Material, curl: bool) -> (impl Fn(Point) -> Point + use<>, impl Fn(Point) -> Point + use<>) {
    use std::f64::consts::PI;
    let (e, nu) = (material.youngs_modulus, material.poisson_ratio);
    let mu = 0.5 * e / (1.0 + nu);
    let lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    // Either (s s s, 0, 0) with s = sin(pi x), or the divergence-free (sx cy, -cx sy, 0).
    let displacement = move |x: Point| {
        let (s, c) = (x.map(|v| (PI * v).sin()), x.map(|v| (PI * v).cos()));
        if curl {
            [s[0] * c[1], -c[0] * s[1], 0.0]
        } else {
            [s[0] * s[1] * s[2], 0.0, 0.0]
        }
    };
    // -(lambda + mu) grad div u - mu laplace u
    let force = move |x: Point| {
        let (s, c) = (x.map(|v| (PI * v).sin()), x.map(|v| (PI * v).cos()));
        if curl {
            displacement(x).map(|u| 2.0 * PI * PI * mu * u)
        } else {
            let p = PI * PI;
            [
                (lambda + 4.0 * mu) * p * s[0] * s[1] * s[2],
                -(lambda + mu) * p * c[0] * c[1] * s[2],
                -(lambda + mu) * p * c[0] * s[1] * c[2],
            ]
        }
    };
    (displacement, force)
}

/// Error in the mean square over the volume.
fn error(kind: Kind, n: usize, poisson_ratio: f64, curl: bool) -> f64 {
    let (exact, force) = manufactured(&material(poisson_ratio), curl);
    let mesh = cube(kind, n, 1.0, 0.1, poisson_ratio);
    let (system, mut u) = solve(&mesh, 1.0, &exact, force);
    for (node, &x) in mesh.nodes.iter().enumerate() {
        for (i, value) in exact(x).into_iter().enumerate() {
            u[3 * node + i] -= value;
        }
    }
    let product = multiply_vector(&system.mass, &u);
    let square: f64 = product.iter().zip(&u).map(|(a, b)| a * b).sum();
    (square / 7857.8).sqrt()
}

#[test]
fn errors_fall_with_the_order_of_the_element() {
    for kind in kinds() {
        let (meshes, rate) = match kind {
            Kind::Tet10 => ([4, 8], 2.8),
            Kind::Hex(_) | Kind::Wedge | Kind::Tet4 => ([8, 16], 1.8),
        };
        let [coarse, fine] = meshes.map(|n| error(kind, n, 0.29, false));
        let found = (coarse / fine).log2();
        println!("{kind:?}: {coarse:.3e} {fine:.3e}, rate {found:.2}");
        assert!(
            found > rate && fine < 2e-2,
            "{kind:?}: {coarse:e} {fine:e}, rate {found}"
        );
    }
}

#[test]
fn only_full_integration_locks_at_nearly_constant_volume() {
    let at = |formulation| error(Kind::Hex(formulation), 6, 0.4999, true);
    let locked = at(Formulation::Full);
    for formulation in [Formulation::BBar, Formulation::IncompatibleModes, Formulation::Reduced] {
        let free = at(formulation);
        println!("{formulation:?} {free:.2e}, full {locked:.2e}");
        assert!(free < 0.2 * locked, "{formulation:?}: {free:e}, full {locked:e}");
    }
}

#[test]
fn inverted_elements_are_refused() {
    for kind in kinds() {
        let (cell, mut x) = distorted(kind);
        x.swap(0, 1);
        let found = matrices(7, &cell, &x, &material(0.29));
        assert!(
            matches!(found, Err(Error::InvertedElement { element: 7, .. })),
            "{kind:?}"
        );
    }
}

#[test]
fn faces_of_every_kind_can_be_tied_to() {
    for kind in kinds() {
        let mut mesh = cube(kind, 3, 0.03, 0.1, 0.29);
        let count = mesh.nodes.len() as u32;
        let below = mesh.elements.len();
        let top = cube(Kind::Hex(Formulation::IncompatibleModes), 4, 0.02, 0.1, 0.29);
        mesh.nodes
            .extend(top.nodes.iter().map(|x| [x[0] + 0.004, x[1] + 0.003, x[2] + 0.03]));
        mesh.elements.extend(top.elements.iter().map(|element| {
            let nodes: Vec<u32> = element.cell.nodes().iter().map(|n| n + count).collect();
            Element {
                cell: Cell::hex8(nodes.try_into().unwrap(), Formulation::IncompatibleModes),
                material: 0,
            }
        }));
        let flat = |nodes: &[u32]| nodes.iter().all(|&n| (mesh.nodes[n as usize][2] - 0.03).abs() < 1e-12);
        let faces = mesh.elements[..below].iter().flat_map(|element| element.cell.faces());
        let tie = Tie {
            name: "glue".into(),
            slave_nodes: (count..mesh.nodes.len() as u32).filter(|&n| flat(&[n])).collect(),
            master_faces: faces.filter(|face| flat(face.nodes())).collect(),
            position_tolerance: 1e-6,
            beyond: BeyondTolerance::Refuse,
            adjust: true,
        };
        assert_eq!(tie.slave_nodes.len(), 25);
        let assembly = Assembly {
            mesh,
            ties: vec![tie],
            ..Assembly::default()
        };
        let system = System::try_new(&assembly).unwrap();
        let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 3, 1e-6).unwrap();
        assert_eq!(modes.n_zero, 6, "{kind:?}");
        // A linear field stays linear across the tie.
        let h = [[1e-3, 2e-4, -3e-4], [5e-4, -7e-4, 1e-4], [2e-4, 6e-4, 4e-4]];
        let linear = |x: Point| h.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
        let dofs = &system.dofs;
        let u: Vec<f64> = dofs
            .independent
            .iter()
            .map(|d| linear(dofs.coordinates[d / 3])[d % 3])
            .collect();
        let all = multiply_vector(&dofs.transform, &u);
        for (node, &x) in dofs.coordinates.iter().enumerate() {
            for (i, expected) in linear(x).into_iter().enumerate() {
                assert!((all[3 * node + i] - expected).abs() < 1e-16, "{kind:?} {x:?}");
            }
        }
    }
}

#[test]
fn rows_of_the_table_agree_with_themselves() {
    for row in ELEMENT_TYPES {
        let n = row.n_nodes();
        for (a, &at) in row.nodes.iter().enumerate() {
            let (values, derivatives) = row.shape_functions(at);
            for (b, value) in values.iter().enumerate() {
                let expected = if a == b { 1.0 } else { 0.0 };
                assert!((value - expected).abs() < 1e-14, "{row:?}: function {b} at node {a}");
            }
            for axis in 0..3 {
                let sum: f64 = derivatives.iter().map(|d| d[axis]).sum();
                assert!(sum.abs() < 1e-14, "{row:?}: derivatives at node {a}");
            }
        }
        let n_corners = n - row.middles.len();
        for (&[a, b], middle) in row.middles.iter().zip(&row.nodes[n_corners..]) {
            for axis in 0..3 {
                assert_eq!(0.5 * (row.nodes[a][axis] + row.nodes[b][axis]), middle[axis], "{row:?}");
            }
        }
        for (face_type, locals) in row.faces {
            assert_eq!(face_type.n_nodes, locals.len(), "{row:?}");
        }
        let alternative = row.vtk.alternative.as_ref().map_or(&[][..], |other| other.order);
        for order in [row.gmsh.order, row.vtk.order, alternative] {
            let mut sorted = order.to_vec();
            sorted.sort_unstable();
            assert!(
                order.is_empty() || sorted == (0..n).collect::<Vec<_>>(),
                "{row:?}: {order:?}"
            );
        }
    }
    let distinct = |numbers: Vec<u8>| numbers.iter().collect::<BTreeSet<_>>().len() == numbers.len();
    let all = |of: fn(&ElementType) -> u8, of_face: fn(&FaceType) -> u8| {
        let faces = FACE_TYPES.into_iter().map(of_face);
        distinct(ELEMENT_TYPES.into_iter().map(of).chain(faces).collect())
    };
    assert!(all(|row| row.gmsh.number, |face| face.gmsh));
    assert!(all(|row| row.vtk.number, |face| face.vtk));
}
