//! Every element formulation: zero-energy modes, patch tests, rates of convergence.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use faer::Mat;
use finite_elements::Error;
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::elements::{
    CORNERS, ELEMENT_TYPES, ElementType, FACE_TYPES, FaceType, Formulation, HEX20, HEX27, TET4, TET10, WEDGE6, WEDGE15,
    matrices,
};
use finite_elements::factor::SparseCholesky;
use finite_elements::mesh::{Assembly, BeyondTolerance, Cell, Element, Material, Mesh, Tie};
use finite_elements::recovery::StrainErrors;
use finite_elements::sparse::multiply_vector;
use std::collections::{BTreeMap, BTreeSet};

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

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Hex(Formulation),
    Hex20(Formulation),
    Hex27,
    Wedge,
    Wedge15,
    Tet4,
    Tet10,
}

/// Hexahedra and wedges with quadratic functions.
const QUADRATIC: [Kind; 4] = [
    Kind::Hex20(Formulation::Reduced),
    Kind::Hex20(Formulation::Full),
    Kind::Hex27,
    Kind::Wedge15,
];

fn kinds() -> impl Iterator<Item = Kind> {
    HEXAHEDRA
        .map(Kind::Hex)
        .into_iter()
        .chain([Kind::Wedge, Kind::Tet4, Kind::Tet10])
        .chain(QUADRATIC)
}

/// The element on the given corners. Its other nodes, in the middle between corners, are found in `middles` or added to
/// `nodes`.
fn on_corners(kind: Kind, corners: &[u32], nodes: &mut Vec<Point>, middles: &mut BTreeMap<Vec<u32>, u32>) -> Cell {
    let (row, formulation) = match kind {
        Kind::Hex(formulation) => return Cell::hex8(corners.try_into().unwrap(), formulation),
        Kind::Hex20(formulation) => (&HEX20, formulation),
        Kind::Hex27 => (&HEX27, Formulation::Full),
        Kind::Wedge => (&WEDGE6, Formulation::Full),
        Kind::Wedge15 => (&WEDGE15, Formulation::Full),
        Kind::Tet4 => (&TET4, Formulation::Full),
        Kind::Tet10 => (&TET10, Formulation::Full),
    };
    let mut all = corners.to_vec();
    for between in row.middles {
        let mut between: Vec<u32> = between.iter().map(|&local| corners[local]).collect();
        between.sort_unstable();
        all.push(*middles.entry(between).or_insert_with_key(|between| {
            let mean = |c: usize| between.iter().map(|&n| nodes[n as usize][c]).sum::<f64>() / between.len() as f64;
            let middle = [0, 1, 2].map(mean);
            nodes.push(middle);
            nodes.len() as u32 - 1
        }));
    }
    Cell::try_new(row, formulation, &all).unwrap()
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
    let mut middles = BTreeMap::new();
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                let c = CORNERS.map(|x| {
                    let up = x.map(|s| usize::from(s > 0.0));
                    node(i + up[0], j + up[1], k + up[2])
                });
                // Around the diagonal from corner 0 to corner 6.
                let around = [1, 2, 3, 7, 4, 5, 1];
                let parts: Vec<Vec<u32>> = match kind {
                    Kind::Hex(_) | Kind::Hex20(_) | Kind::Hex27 => vec![c.to_vec()],
                    Kind::Wedge | Kind::Wedge15 => vec![
                        vec![c[0], c[1], c[2], c[4], c[5], c[6]],
                        vec![c[0], c[2], c[3], c[4], c[6], c[7]],
                    ],
                    Kind::Tet4 | Kind::Tet10 => {
                        let pairs = around.windows(2);
                        pairs.map(|pair| vec![c[0], c[pair[0]], c[pair[1]], c[6]]).collect()
                    }
                };
                for corners in parts {
                    let cell = on_corners(kind, &corners, &mut mesh.nodes, &mut middles);
                    mesh.elements.push(Element { cell, material: 0 });
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
    let halved = |row: &ElementType| jitter(row.nodes.iter().map(|c| c.map(|v| 0.5 * v)).collect());
    match kind {
        Kind::Hex(f) => (
            Cell::hex8([0; 8], f),
            jitter(CORNERS.map(|c| c.map(|v| 0.5 * v)).to_vec()),
        ),
        // All nodes are moved, so that edges and faces are curved.
        Kind::Hex20(f) => (Cell::try_new(&HEX20, f, &[0; 20]).unwrap(), halved(&HEX20)),
        Kind::Hex27 => (Cell::hex27([0; 27]), halved(&HEX27)),
        Kind::Wedge15 => (Cell::wedge15([0; 15]), jitter(WEDGE15.nodes.to_vec())),
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
        // Eight points have 48 strains, for 60 components of displacement.
        let expected = if matches!(kind, Kind::Hex20(Formulation::Reduced)) {
            12
        } else {
            6
        };
        assert_eq!(zero, expected, "{kind:?}: {values:?}");
        assert!(values[0] > -1e-12 * largest, "{kind:?}");
        assert!(values[expected] > 1e-5 * largest, "{kind:?}: {values:?}");
    }
}

/// Gauss points and weights on (-1, 1), exact for degree 7.
fn line() -> [(f64, f64); 4] {
    let root = (6.0_f64 / 5.0).sqrt();
    [-1.0, 1.0]
        .map(|sign| {
            let x = (3.0 / 7.0 + sign * 2.0 / 7.0 * root).sqrt();
            [
                (-x, (18.0 - sign * 30.0_f64.sqrt()) / 36.0),
                (x, (18.0 - sign * 30.0_f64.sqrt()) / 36.0),
            ]
        })
        .concat()
        .try_into()
        .unwrap()
}

/// Points and weights on the square from -1 to 1, or on the triangle that it is collapsed onto.
fn plane(triangle: bool) -> Vec<([f64; 2], f64)> {
    let of = |(a, wa): (f64, f64), (b, wb): (f64, f64)| {
        let (u, v) = (0.5 * (1.0 + a), 0.5 * (1.0 + b));
        if triangle {
            ([u, (1.0 - u) * v], 0.25 * wa * wb * (1.0 - u))
        } else {
            ([a, b], wa * wb)
        }
    };
    line().iter().flat_map(|&a| line().map(|b| of(a, b))).collect()
}

/// Volume by the divergence theorem over the faces, which may be curved (m^3).
fn enclosed_volume(row: &ElementType, x: &[Point]) -> f64 {
    let mut volume = 0.0;
    for (face_type, locals) in row.faces {
        let corners: Vec<Point> = locals[..face_type.n_corners].iter().map(|&a| row.nodes[a]).collect();
        let from_first = |k: usize| [0, 1, 2].map(|i| corners[k][i] - corners[0][i]);
        // Corners of reference faces lie in a parallelogram: a point is reached from the first one along two edges.
        let triangle = corners.len() == 3;
        let edges = if triangle {
            [from_first(1), from_first(2)]
        } else {
            [from_first(1), from_first(3)]
        };
        for ([p, q], weight) in plane(triangle) {
            let (p, q, half) = if triangle {
                (p, q, 1.0)
            } else {
                (0.5 * (1.0 + p), 0.5 * (1.0 + q), 0.5)
            };
            let at = [0, 1, 2].map(|i| corners[0][i] + p * edges[0][i] + q * edges[1][i]);
            let (values, derivatives) = row.shape_functions(at);
            let mut place = [0.0; 3];
            let mut tangents = [[0.0; 3]; 2];
            for ((value, d), x) in values.iter().zip(&derivatives).zip(x) {
                for i in 0..3 {
                    place[i] += value * x[i];
                    for (tangent, edge) in tangents.iter_mut().zip(&edges) {
                        tangent[i] += half * (0..3).map(|k| d[k] * edge[k]).sum::<f64>() * x[i];
                    }
                }
            }
            let [s, t] = tangents;
            let normal = [
                s[1] * t[2] - s[2] * t[1],
                s[2] * t[0] - s[0] * t[2],
                s[0] * t[1] - s[1] * t[0],
            ];
            volume += weight * (0..3).map(|i| place[i] * normal[i]).sum::<f64>() / 3.0;
        }
    }
    volume
}

#[test]
fn mass_is_that_of_the_volume_and_centroid() {
    for kind in kinds() {
        let (cell, x) = distorted(kind);
        let found = matrices(0, &cell, &x, &material(0.29)).unwrap();
        let n = found.n_nodes;
        let total: f64 = found.mass.iter().sum();
        let volume = enclosed_volume(cell.element_type(), &x);
        assert!(
            (total / (7857.8 * volume) - 1.0).abs() < 1e-12,
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
            Kind::Tet10 | Kind::Hex20(_) | Kind::Hex27 | Kind::Wedge15 => ([4, 8], 2.8),
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
fn of_the_quadratic_elements_reduced_integration_alone_does_not_lock() {
    let at = |kind, n, poisson_ratio| error(kind, n, poisson_ratio, true);
    let reduced = Kind::Hex20(Formulation::Reduced);
    let [coarse, fine] = [3, 6].map(|n| at(reduced, n, 0.4999));
    println!(
        "{reduced:?}: {coarse:.2e} {fine:.2e}, rate {:.2}",
        (coarse / fine).log2()
    );
    assert!((coarse / fine).log2() > 3.0 && fine < 3e-3, "{coarse:e} {fine:e}");
    for kind in [Kind::Hex20(Formulation::Full), Kind::Hex27, Kind::Wedge15, Kind::Tet10] {
        let ([coarse, fine], free) = ([3, 6].map(|n| at(kind, n, 0.4999)), at(kind, 6, 0.29));
        let rate = (coarse / fine).log2();
        println!("{kind:?}: {coarse:.2e} {fine:.2e}, rate {rate:.2}; {free:.2e} at 0.29");
        assert!(fine > 30.0 * free && fine < 0.05, "{kind:?}: {fine:e} {free:e}");
    }
}

/// Eigenvalues of the stiffness (N/m): the first that is not zero, the one in the middle, the two largest; the trace; least
/// and largest eigenvalue and sum of the mass matrix (kg). The elements are those of [`distorted`].
///
/// Found by a program of its own in numpy: shape functions from the inverse of the Vandermonde matrix of the monomials,
/// stiffness as `B^T D B` in Voigt's notation, Gauss points of `numpy.polynomial.legendre`.
const REFERENCE: [(Kind, [f64; 5], [f64; 3]); 4] = [
    (
        Kind::Hex20(Formulation::Reduced),
        [
            2.9820816326133e+06,
            8.3953909172396e+07,
            1.4971229007799e+09,
            2.9982521568329e+09,
            1.5699002794805e+10,
        ],
        [1.0373627608899e-07, 2.8708449209801e-05, 5.4852968497759e-05],
    ),
    (
        Kind::Hex20(Formulation::Full),
        [
            4.6986676607393e+06,
            9.9821601956823e+07,
            1.6775853287620e+09,
            2.9776878643376e+09,
            1.7109103997447e+10,
        ],
        [1.0373627608899e-07, 2.8708449209801e-05, 5.4852968497759e-05],
    ),
    (
        Kind::Hex27,
        [
            3.6796139085864e+06,
            9.2470643061634e+07,
            1.7287613663759e+09,
            3.9938821404852e+09,
            2.1525710942729e+10,
        ],
        [2.4635161271706e-08, 8.6922589765409e-06, 5.0867364164990e-05],
    ),
    (
        Kind::Wedge15,
        [
            1.4329203827756e+06,
            1.0250826036300e+08,
            2.9835990967389e+09,
            4.5106775007764e+09,
            1.9757251610629e+10,
        ],
        [1.6659244021959e-07, 2.6120664049016e-05, 5.9396255046030e-05],
    ),
];

#[test]
fn matrices_of_curved_elements_are_those_of_another_program() {
    for (kind, stiffness, mass) in REFERENCE {
        let (cell, x) = distorted(kind);
        let found = matrices(0, &cell, &x, &material(0.29)).unwrap();
        let eigenvalues = |n: usize, of: &[f64]| {
            dense_algebra::symmetric_eigenvalues(Mat::from_fn(n, n, |i, j| of[i * n + j]).as_ref()).unwrap()
        };
        let n = 3 * found.n_nodes;
        let values = eigenvalues(n, &found.stiffness);
        let first = values.iter().position(|v| *v > 1e-11 * values[n - 1]).unwrap();
        let chosen = [
            values[first],
            values[n / 2],
            values[n - 2],
            values[n - 1],
            values.iter().sum(),
        ];
        for (found, expected) in chosen.iter().zip(&stiffness) {
            let error = (found - expected).abs() / stiffness[3];
            assert!(error < 1e-12, "{kind:?}: {found:e} {expected:e}");
        }
        let values = eigenvalues(found.n_nodes, &found.mass);
        let chosen = [values[0], values[found.n_nodes - 1], found.mass.iter().sum()];
        for (found, expected) in chosen.iter().zip(&mass) {
            let error = (found - expected).abs() / mass[1];
            assert!(error < 1e-12, "{kind:?}: {found:e} {expected:e}");
        }
    }
}

/// The first elements of a mesh, with their nodes alone.
fn first_elements(mesh: &Mesh, count: usize) -> Mesh {
    let mut numbers = BTreeMap::new();
    let mut part = Mesh {
        materials: mesh.materials.clone(),
        ..Mesh::default()
    };
    for element in &mesh.elements[..count] {
        let cell = element.cell.map_nodes(|node| {
            *numbers.entry(node).or_insert_with(|| {
                part.nodes.push(mesh.nodes[node as usize]);
                part.nodes.len() as u32 - 1
            })
        });
        part.elements.push(Element { cell, material: 0 });
    }
    part
}

#[test]
fn meshes_of_reduced_integration_have_no_spurious_modes_but_a_row_of_boxes_does() {
    let boxes = cube(Kind::Hex20(Formulation::Reduced), 2, 0.02, 0.0, 0.29);
    let mut distorted = boxes.clone();
    for (node, x) in distorted.nodes.iter_mut().enumerate() {
        *x = [0, 1, 2].map(|i| x[i] + 5e-4 * noise((9 * node + i) as u64));
    }
    // One element, a row of two, two by two, and all eight; the counts of boxes are also those of another program.
    for (mesh, counts) in [(boxes, [12, 9, 6, 6]), (distorted, [12, 6, 6, 6])] {
        for (elements, expected) in [1, 2, 4, 8].into_iter().zip(counts) {
            let mesh = first_elements(&mesh, elements);
            let system = System::try_new(&Assembly {
                mesh,
                ..Assembly::default()
            })
            .unwrap();
            let n = system.n_dofs();
            let dense = Mat::from_fn(n, n, |i, j| system.stiffness.get(i, j).copied().unwrap_or(0.0));
            let values = dense_algebra::symmetric_eigenvalues(dense.as_ref()).unwrap();
            let zero = values.iter().filter(|v| v.abs() < 1e-11 * values[n - 1]).count();
            assert_eq!(zero, expected, "{elements} elements: {:?}", &values[..14]);
        }
    }
}

/// The cube with every node inside moved by a smooth field, so that edges are curved and the cells tend to parallelepipeds
/// when `n` grows.
fn curved_cube(kind: Kind, n: usize, poisson_ratio: f64) -> Mesh {
    use std::f64::consts::PI;
    let mut mesh = cube(kind, n, 1.0, 0.0, poisson_ratio);
    for x in &mut mesh.nodes {
        let bump: f64 = x.iter().map(|v| (PI * v).sin()).product();
        *x = [x[0] + 0.10 * bump, x[1] - 0.08 * bump, x[2] + 0.06 * bump * x[0]];
    }
    mesh
}

/// Error of the displacement in the mean square (m), and of the strain in energy (J), by quadrature.
fn true_errors(mesh: &Mesh, poisson_ratio: f64) -> [f64; 2] {
    use std::f64::consts::PI;
    let material = material(poisson_ratio);
    let (exact, force) = manufactured(&material, false);
    let (_, u) = solve(mesh, 1.0, &exact, force);
    let mu = 0.5 * material.youngs_modulus / (1.0 + poisson_ratio);
    let lambda = 2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio);
    let [mut square, mut energy] = [0.0; 2];
    for element in &mesh.elements {
        let row = element.cell.element_type();
        let wedge = row == &WEDGE15;
        for ([r, s], across) in plane(wedge) {
            for (t, along) in line() {
                let (values, derivatives) = row.shape_functions([r, s, t]);
                let mut place = nalgebra::Vector3::zeros();
                let mut shift = nalgebra::Vector3::zeros();
                let mut jacobian = nalgebra::Matrix3::<f64>::zeros();
                let mut slope = nalgebra::Matrix3::zeros();
                for ((&node, value), d) in element.cell.nodes().iter().zip(&values).zip(&derivatives) {
                    let x = nalgebra::Vector3::from(mesh.nodes[node as usize]);
                    let v = nalgebra::Vector3::from_column_slice(&u[3 * node as usize..][..3]);
                    let d = nalgebra::RowVector3::from(*d);
                    place += x * *value;
                    shift += v * *value;
                    jacobian += x * d;
                    slope += v * d;
                }
                let weight = across * along * jacobian.determinant();
                let gradient = slope * jacobian.try_inverse().unwrap();
                let at = <[f64; 3]>::from(place);
                let (s, c) = (at.map(|v| (PI * v).sin()), at.map(|v| (PI * v).cos()));
                let mut expected = nalgebra::Matrix3::zeros();
                for i in 0..3 {
                    expected[(0, i)] = PI * c[i] * s[(i + 1) % 3] * s[(i + 2) % 3];
                }
                let difference = gradient - expected;
                let strain = (difference + difference.transpose()) * 0.5;
                energy += weight * (0.5 * lambda * strain.trace().powi(2) + mu * strain.norm_squared());
                square += weight * (shift - nalgebra::Vector3::from(exact(at))).norm_squared();
            }
        }
    }
    [square.sqrt(), energy]
}

#[test]
fn displacement_converges_with_order_three_and_energy_with_order_four() {
    for kind in QUADRATIC {
        for (name, meshes) in [
            ("boxes", [4, 8].map(|n| cube(kind, n, 1.0, 0.0, 0.29))),
            ("curved", [4, 8].map(|n| curved_cube(kind, n, 0.29))),
            ("distorted", [4, 8].map(|n| cube(kind, n, 1.0, 0.1, 0.29))),
        ] {
            let [coarse, fine] = meshes.map(|mesh| true_errors(&mesh, 0.29));
            let [displacement, energy] = [0, 1].map(|i| (coarse[i] / fine[i]).log2());
            println!("{kind:?} {name}: {coarse:?} {fine:?}, orders {displacement:.2} {energy:.2}");
            assert!(
                displacement > 2.7 && energy > 3.6,
                "{kind:?} {name}: {displacement} {energy}"
            );
        }
    }
}

#[test]
fn quadratic_elements_hold_quadratic_fields() {
    let (mu, lambda) = {
        let mu = 0.5 * 192.85e9 / 1.29;
        (mu, 2.0 * mu * 0.29 / 0.42)
    };
    let field = |[x, y, z]: Point| [x * x - 2.0 * y * z, 0.5 * y * y + x * z, x * y - 1.5 * z * z];
    // -(lambda + mu) grad div u - mu laplace u, with div u = 2 x + y - 3 z and laplace u = (2, 1, -3).
    let force = [2.0, 1.0, -3.0].map(|v| -(lambda + 2.0 * mu) * v);
    for kind in QUADRATIC {
        // The serendipity elements hold them on parallelepipeds, the Lagrange element wherever edges are straight.
        let distortion = if matches!(kind, Kind::Hex27) { 0.1 } else { 0.0 };
        let mesh = cube(kind, 2, 1.0, distortion, 0.29);
        let (_, u) = solve(&mesh, 1.0, field, |_| force);
        for (node, &x) in mesh.nodes.iter().enumerate() {
            for (i, exact) in field(x).into_iter().enumerate() {
                assert!((u[3 * node + i] - exact).abs() < 1e-12, "{kind:?} {x:?}");
            }
        }
    }
}

#[test]
fn curved_patches_carry_constant_strain_where_the_points_suffice() {
    let h = [[1e-3, 2e-4, -3e-4], [5e-4, -7e-4, 1e-4], [2e-4, 6e-4, 4e-4]];
    let linear = |x: Point| h.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
    for kind in QUADRATIC {
        let mut mesh = cube(kind, 3, 0.02, 0.1, 0.29);
        for (node, x) in mesh.nodes.iter_mut().enumerate() {
            if x.iter().all(|v| *v > 1e-9 && *v < 0.02 - 1e-9) {
                *x = [0, 1, 2].map(|i| x[i] + 2e-4 * noise((5 * node + i) as u64));
            }
        }
        let (_, u) = solve(&mesh, 0.02, linear, |_| [0.0; 3]);
        let mut worst = 0.0_f64;
        for (node, &x) in mesh.nodes.iter().enumerate() {
            for (i, exact) in linear(x).into_iter().enumerate() {
                worst = worst.max((u[3 * node + i] - exact).abs());
            }
        }
        println!("{kind:?}: {worst:.1e} m of 3e-5 m");
        // Products of the cofactors of the Jacobian and a gradient are of degree 5: more than two points along a coordinate,
        // or three in a triangle, integrate exactly.
        let exact = matches!(kind, Kind::Hex20(Formulation::Full) | Kind::Hex27);
        assert!(worst < if exact { 1e-15 } else { 1e-8 }, "{kind:?}: {worst:e}");
    }
}

#[test]
fn a_midside_node_beyond_its_quarter_points_is_refused_by_element_and_point() {
    for kind in QUADRATIC {
        let (cell, _) = distorted(kind);
        let row = cell.element_type();
        let middle = row.n_nodes() - row.middles.len();
        // The middle of the edge from corner 0 to corner 1, moved towards the former.
        for (part, refused) in [(0.4, false), (0.0, true), (-0.5, true)] {
            let mut x = row.nodes.to_vec();
            x[middle] = [0, 1, 2].map(|i| x[0][i] + part * (x[1][i] - x[0][i]));
            let found = matrices(7, &cell, &x, &material(0.29));
            let is_refused = matches!(
                found,
                Err(Error::InvertedElement { element: 7, determinant, .. }) if determinant < 0.0
            );
            assert_eq!(is_refused, refused, "{kind:?} {part}: {:?}", found.err());
        }
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

/// A smaller body glued onto the upper face of a cube of 0.03 m. Every node in the plane between them is a slave, middles of edges
/// included.
fn glued(mut mesh: Mesh, top: &Mesh, position_tolerance: f64, adjust: bool) -> (Mesh, Tie) {
    let (count, below) = (mesh.nodes.len() as u32, mesh.elements.len());
    mesh.nodes
        .extend(top.nodes.iter().map(|x| [x[0] + 0.004, x[1] + 0.003, x[2] + 0.03]));
    mesh.elements.extend(top.elements.iter().map(|element| Element {
        cell: element.cell.map_nodes(|node| node + count),
        material: 0,
    }));
    let flat = |nodes: &[u32]| nodes.iter().all(|&n| (mesh.nodes[n as usize][2] - 0.03).abs() < 1e-12);
    let faces = mesh.elements[..below].iter().flat_map(|element| element.cell.faces());
    let tie = Tie {
        name: "glue".into(),
        slave_nodes: (count..mesh.nodes.len() as u32).filter(|&n| flat(&[n])).collect(),
        master_faces: faces.filter(|face| flat(face.nodes())).collect(),
        position_tolerance,
        beyond: BeyondTolerance::Refuse,
        adjust,
    };
    (mesh, tie)
}

#[test]
fn faces_of_every_kind_can_be_tied_to() {
    for kind in kinds() {
        let top = cube(Kind::Hex(Formulation::IncompatibleModes), 4, 0.02, 0.1, 0.29);
        let (mesh, tie) = glued(cube(kind, 3, 0.03, 0.1, 0.29), &top, 1e-6, true);
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
        if QUADRATIC.contains(&kind) {
            // So does a quadratic one.
            let field = |[x, y, z]: Point| [x * x - 2.0 * y * y, x * y + z, x * y - y * y];
            let u: Vec<f64> = dofs
                .independent
                .iter()
                .map(|d| field(dofs.coordinates[d / 3])[d % 3])
                .collect();
            let all = multiply_vector(&dofs.transform, &u);
            for (node, &x) in dofs.coordinates.iter().enumerate() {
                for (i, expected) in field(x).into_iter().enumerate() {
                    assert!((all[3 * node + i] - expected).abs() < 1e-16, "{kind:?} {x:?}");
                }
            }
        }
    }
}

#[test]
fn curved_quadratic_faces_hold_their_slaves() {
    // Both bodies are bent to the same parabola, which quadratic faces follow exactly.
    let bend = |x: &mut Point| x[2] += 8.0 * (x[0] - 0.015).powi(2) + 4.0 * x[0] * x[1];
    for kind in QUADRATIC.into_iter().chain([Kind::Tet10]) {
        for adjust in [true, false] {
            let top = cube(Kind::Hex20(Formulation::Full), 2, 0.02, 0.0, 0.29);
            let (mut mesh, tie) = glued(cube(kind, 3, 0.03, 0.0, 0.29), &top, 1e-12, adjust);
            assert_eq!(tie.slave_nodes.len(), 21);
            mesh.nodes.iter_mut().for_each(bend);
            let assembly = Assembly {
                mesh,
                ties: vec![tie],
                ..Assembly::default()
            };
            let system = System::try_new(&assembly).unwrap();
            let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 3, 1e-6).unwrap();
            assert_eq!(modes.n_zero, 6, "{kind:?}");
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
        for (&between, middle) in row.middles.iter().zip(&row.nodes[n_corners..]) {
            for axis in 0..3 {
                let sum: f64 = between.iter().map(|&a| row.nodes[a][axis]).sum();
                assert_eq!(sum / between.len() as f64, middle[axis], "{row:?}");
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

/// Of elements with curved edges and faces too: the mass of density one.
#[test]
fn volumes_are_masses_of_unit_density() {
    let unit = Material {
        density: 1.0,
        ..material(0.29)
    };
    for kind in kinds() {
        let (cell, nodes) = distorted(kind);
        let mut numbers = 0..;
        let cell = cell.map_nodes(|_| numbers.next().unwrap());
        let mass: f64 = matrices(0, &cell, &nodes, &unit).unwrap().mass.iter().sum();
        let volume = cell.volume(&nodes);
        assert!((volume / mass - 1.0).abs() < 1e-12, "{kind:?}: {volume} {mass}");
    }
}

/// Displacements of all nodes.
fn of_nodes(mesh: &Mesh, field: impl Fn(Point) -> Point) -> Vec<Point> {
    mesh.nodes.iter().map(|x| field(*x)).collect()
}

#[test]
fn strains_that_a_mesh_follows_have_no_error() {
    for kind in kinds() {
        let mesh = cube(kind, 3, 0.1, 0.1, 0.3);
        let linear = of_nodes(&mesh, |[x, y, z]| [x + 2.0 * y, z - x, 0.5 * y + z]);
        let size = StrainErrors::try_new(&mesh, std::slice::from_ref(&linear)).unwrap();
        let whole = 192.85e9 * 0.1_f64.powi(3);
        assert!(size.products[0].abs() < 1e-18 * whole, "{kind:?}: {}", size.products[0]);
        // A linear strain is beyond linear elements.
        let curved = of_nodes(&mesh, |[x, y, z]| [10.0 * x * y, 10.0 * z * z, 10.0 * (x - y) * z]);
        let both = StrainErrors::try_new(&mesh, &[linear, curved]).unwrap();
        let [own, mixed, _, error] = both.products[..] else {
            panic!()
        };
        assert!(own.abs() < 1e-18 * whole && mixed.abs() < 1e-9 * (whole * error.max(whole)).sqrt());
        assert!(
            (both.of_elements.iter().skip(1).step_by(2).sum::<f64>() / error - 1.0).abs() < 1e-9
                || error < 1e-12 * whole
        );
    }
}

/// Twice the energy of the difference between the strains of a field (its gradient) and those of displacements of the nodes.
fn energy_of_error(mesh: &Mesh, u: &[Point], gradient: impl Fn(Point) -> [Point; 3]) -> f64 {
    let far = (3.0 / 7.0 + 2.0 / 7.0 * 1.2_f64.sqrt()).sqrt();
    let near = (3.0 / 7.0 - 2.0 / 7.0 * 1.2_f64.sqrt()).sqrt();
    let [light, heavy] = [-1.0, 1.0].map(|sign| (18.0 + sign * 30.0_f64.sqrt()) / 36.0);
    let line = [(-far, light), (-near, heavy), (near, heavy), (far, light)];
    let (e, nu) = (mesh.materials[0].youngs_modulus, mesh.materials[0].poisson_ratio);
    let (lambda, mu) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 * e / (1.0 + nu));
    let mut sum = 0.0;
    for element in &mesh.elements {
        let row = element.cell.element_type();
        for (r, wr) in line {
            for (s, ws) in line {
                for (t, wt) in line {
                    // Tetrahedra are collapsed cubes.
                    let (at, weight) = if row.name.starts_with("Hex") {
                        ([r, s, t], wr * ws * wt)
                    } else {
                        let [a, b, c] = [r, s, t].map(|x| 0.5 * (1.0 + x));
                        let weight = wr * ws * wt / 8.0 * (1.0 - a).powi(2) * (1.0 - b);
                        ([a, (1.0 - a) * b, (1.0 - a) * (1.0 - b) * c], weight)
                    };
                    let (values, derivatives) = row.shape_functions(at);
                    let nodes: Vec<usize> = element.cell.nodes().iter().map(|n| *n as usize).collect();
                    let mut jacobian = nalgebra::Matrix3::<f64>::zeros();
                    let mut natural = nalgebra::Matrix3::<f64>::zeros();
                    let mut x = [0.0; 3];
                    for (local, &node) in nodes.iter().enumerate() {
                        for i in 0..3 {
                            x[i] += values[local] * mesh.nodes[node][i];
                            for j in 0..3 {
                                jacobian[(i, j)] += derivatives[local][i] * mesh.nodes[node][j];
                                natural[(i, j)] += derivatives[local][i] * u[node][j];
                            }
                        }
                    }
                    let found = jacobian.try_inverse().unwrap() * natural;
                    let exact = gradient(x);
                    let strain = |i: usize, j: usize| {
                        let difference = |i: usize, j: usize| exact[i][j] - found[(i, j)];
                        0.5 * (difference(i, j) + difference(j, i))
                    };
                    let trace = (0..3).map(|i| strain(i, i)).sum::<f64>();
                    let all = (0..9).map(|k| strain(k / 3, k % 3).powi(2)).sum::<f64>();
                    sum += weight * jacobian.determinant() * (lambda * trace * trace + 2.0 * mu * all);
                }
            }
        }
    }
    sum
}

/// Against a field whose strains are known, on two meshes; of reduced integration a half is taken.
#[test]
fn recovered_strains_estimate_the_error_of_a_mesh() {
    let k = 25.0_f64;
    let field = |[x, y, z]: Point| {
        let s = (k * x).sin() * (k * y + 0.3).cos() * (0.5 * k * z).exp();
        [s, 0.5 * s, -0.3 * s].map(|u| 1e-3 * u)
    };
    let gradient = |[x, y, z]: Point| {
        let [sx, cx] = [(k * x).sin(), (k * x).cos()];
        let [sy, cy] = [(k * y + 0.3).sin(), (k * y + 0.3).cos()];
        let e = (0.5 * k * z).exp();
        // By direction, then component.
        [cx * cy * e, -sx * sy * e, 0.5 * sx * cy * e].map(|d| [1.0, 0.5, -0.3].map(|f| 1e-3 * k * d * f))
    };
    // On coarse meshes of hexahedra the strains at the surface are extrapolated, and the error of smooth fields is overestimated.
    for (kind, share, largest) in [
        (Kind::Hex20(Formulation::Full), 1.0, [20.0, 4.0]),
        (Kind::Hex20(Formulation::Reduced), 0.5, [20.0, 4.0]),
        (Kind::Hex27, 1.0, [20.0, 4.0]),
        (Kind::Tet10, 1.0, [1.5, 1.5]),
        (Kind::Tet4, 1.0, [1.5, 1.5]),
        (Kind::Hex(Formulation::Full), 1.0, [3.0, 3.0]),
    ] {
        for (n, largest) in [4, 10].into_iter().zip(largest) {
            let mesh = cube(kind, n, 0.1, 0.1, 0.3);
            let u = of_nodes(&mesh, field);
            let error = energy_of_error(&mesh, &u, gradient);
            let estimate = StrainErrors::try_new(&mesh, &[u]).unwrap().products[0];
            let effectivity = estimate / (share * error);
            assert!((0.7..largest).contains(&effectivity), "{kind:?}, {n}: {effectivity}");
        }
    }
}
