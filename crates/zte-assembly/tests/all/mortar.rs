//! Projection between faces whose meshes do not match.

use sprs::CsMat;
use zte_assembly::{Element, Error, InterfaceMesh, Mortar, Operators};

const SHAPES: [&str; 5] = ["tri3", "quad4", "tri6", "quad8", "quad9"];

/// `nx x ny` elements over a rectangle [m] from `origin`; inner corners are moved by up to `distortion` of an edge.
fn grid(shape: &str, [nx, ny]: [usize; 2], origin: [f64; 2], size: [f64; 2], distortion: f64) -> InterfaceMesh {
    let fine = [2 * nx + 1, 2 * ny + 1];
    let corner = |i: usize, j: usize| {
        let inner = i > 0 && i < nx && j > 0 && j < ny;
        let wave = |k: usize| {
            if inner {
                distortion * (1.7 * (i * 3 + j * 5 + k) as f64).sin()
            } else {
                0.0
            }
        };
        [
            origin[0] + size[0] * (i as f64 + wave(0)) / nx as f64,
            origin[1] + size[1] * (j as f64 + wave(1)) / ny as f64,
        ]
    };
    let mean = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    // Nodes of a grid twice as fine; the diagonals of triangles pass through its odd points.
    let place = |i: usize, j: usize| match (i % 2, j % 2) {
        (0, 0) => corner(i / 2, j / 2),
        (1, 0) => mean(corner(i / 2, j / 2), corner(i / 2 + 1, j / 2)),
        (0, _) => mean(corner(i / 2, j / 2), corner(i / 2, j / 2 + 1)),
        _ if shape.starts_with("tri") => mean(corner(i / 2, j / 2), corner(i / 2 + 1, j / 2 + 1)),
        _ => mean(
            mean(corner(i / 2, j / 2), corner(i / 2 + 1, j / 2 + 1)),
            mean(corner(i / 2 + 1, j / 2), corner(i / 2, j / 2 + 1)),
        ),
    };
    let lists: &[&[[usize; 2]]] = match shape {
        "tri3" => &[&[[0, 0], [2, 0], [2, 2]], &[[0, 0], [2, 2], [0, 2]]],
        "quad4" => &[&[[0, 0], [2, 0], [2, 2], [0, 2]]],
        "tri6" => &[
            &[[0, 0], [2, 0], [2, 2], [1, 0], [2, 1], [1, 1]],
            &[[0, 0], [2, 2], [0, 2], [1, 1], [1, 2], [0, 1]],
        ],
        "quad8" => &[&[[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]]],
        _ => &[&[[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]]],
    };
    let mut number = vec![None; fine[0] * fine[1]];
    let (mut nodes, mut elements) = (Vec::new(), Vec::new());
    for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
        for list in lists {
            let of_element: Vec<u32> = list
                .iter()
                .map(|&[a, b]| {
                    let (i, j) = (2 * i + a, 2 * j + b);
                    *number[j * fine[0] + i].get_or_insert_with(|| {
                        nodes.push(place(i, j));
                        nodes.len() as u32 - 1
                    })
                })
                .collect();
            elements.push(Element::from_nodes(&of_element).expect("a shape"));
        }
    }
    InterfaceMesh::flat(nodes, elements)
}

fn product(matrix: &CsMat<f64>, vector: &[f64]) -> Vec<f64> {
    let row = |row: sprs::CsVecView<'_, f64>| row.iter().map(|(j, a)| a * vector[j]).sum();
    matrix.outer_iterator().map(row).collect()
}

fn transposed_product(matrix: &CsMat<f64>, vector: &[f64]) -> Vec<f64> {
    product(&matrix.transpose_view().to_csr(), vector)
}

/// Consistent nodal forces of the traction `1 + a x + b y`.
fn forces(mesh: &InterfaceMesh, [a, b]: [f64; 2]) -> Vec<f64> {
    let operators = Operators::try_new(mesh, 4).expect("a mesh");
    let traction: Vec<f64> = operators.positions.iter().map(|x| 1.0 + a * x[0] + b * x[1]).collect();
    product(&operators.integration, &traction)
}

/// Largest difference.
fn deviation(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn coordinate(mesh: &InterfaceMesh, axis: usize) -> Vec<f64> {
    mesh.nodes.iter().map(|x| x[axis]).collect()
}

/// Resultant and the two moments of nodal forces.
fn resultants(mesh: &InterfaceMesh, forces: &[f64]) -> Vec<f64> {
    let moment = |axis: usize| forces.iter().zip(&mesh.nodes).map(|(f, x)| f * x[axis]).sum();
    vec![forces.iter().sum(), moment(0), moment(1)]
}

#[test]
fn translations_rotations_and_uniform_traction_pass_between_all_shapes() {
    for own_shape in SHAPES {
        for other_shape in SHAPES {
            // Parallelograms and triangles: all integrals are of polynomials of degree 6 at most, but for the products of two
            // shapes with nine nodes, which no condition below needs.
            let own = grid(own_shape, [7, 5], [0.2, -0.1], [0.12, 0.03], 0.0);
            let other = grid(other_shape, [5, 3], [0.2, -0.1], [0.12, 0.03], 0.0);
            let mortar = Mortar::try_new(&own, &other, 1e-6).expect("faces");
            let about = format!("{own_shape} on {other_shape}");
            assert!(mortar.covered.is_empty() && mortar.dropped.is_empty(), "{about}");
            assert_eq!(mortar.elements.len(), own.elements.len());
            let ones = vec![1.0; other.nodes.len()];
            assert!(
                deviation(&product(&mortar.projection, &ones), &vec![1.0; own.nodes.len()]) < 1e-12,
                "{about}"
            );
            for axis in 0..2 {
                let found = product(&mortar.projection, &coordinate(&other, axis));
                assert!(deviation(&found, &coordinate(&own, axis)) < 1e-13, "{about}");
            }
            let mean = 0.12 * 0.03 / own.nodes.len() as f64;
            let passed = transposed_product(&mortar.projection, &forces(&own, [0.0; 2]));
            let found = deviation(&passed, &forces(&other, [0.0; 2]));
            assert!(found < 1e-10 * mean, "{about}: {:e}", found / mean);
            // Other tractions arrive with their resultant and moments.
            let of_own = forces(&own, [3.0, -40.0]);
            let passed = transposed_product(&mortar.projection, &of_own);
            let found = deviation(&resultants(&other, &passed), &resultants(&own, &of_own));
            assert!(found < 1e-12 * 0.12 * 0.03, "{about}: {found:e}");
        }
    }
}

#[test]
fn distorted_meshes_pass_the_patch_test_too() {
    let mut largest = 0.0_f64;
    for own_shape in SHAPES {
        for other_shape in SHAPES {
            let own = grid(own_shape, [6, 5], [0.0; 2], [1.0, 0.7], 0.15);
            let other = grid(other_shape, [4, 7], [0.0; 2], [1.0, 0.7], 0.12);
            let mortar = Mortar::try_new(&own, &other, 1.0).expect("faces");
            let passed = transposed_product(&mortar.projection, &forces(&own, [0.0; 2]));
            let mean = 0.7 / own.nodes.len() as f64;
            let found = deviation(&passed, &forces(&other, [0.0; 2])) / mean;
            largest = largest.max(found);
            for axis in 0..2 {
                let places = product(&mortar.projection, &coordinate(&other, axis));
                assert!(deviation(&places, &coordinate(&own, axis)) < 1e-12);
            }
        }
    }
    // 1.6e-10: shape functions of distorted quadrilaterals are no polynomials of the place.
    assert!(largest < 3e-10, "{largest:e}");
}

#[test]
fn matching_meshes_are_paired_node_by_node() {
    for shape in SHAPES {
        let mesh = grid(shape, [4, 3], [0.0; 2], [1.0, 1.0], 0.1);
        let mortar = Mortar::try_new(&mesh, &mesh, 1e-9).expect("faces");
        let identity: CsMat<f64> = CsMat::eye(mesh.nodes.len());
        let difference = &mortar.projection - &identity;
        let largest = difference.data().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(largest < 1e-9, "{shape}: {largest:e}");
    }
}

#[test]
fn partial_contact_keeps_area_and_centre() {
    for shape in SHAPES {
        let own = grid(shape, [9, 4], [0.0; 2], [0.9, 0.4], 0.0);
        // Covers columns 2 to 6 whole, and six tenths of columns 1 and 7.
        let other = grid("quad4", [5, 5], [0.14, -0.05], [0.62, 0.5], 0.0);
        let mortar = Mortar::try_new(&own, &other, 1e-6).expect("faces");
        let mut contact = InterfaceMesh {
            covered: mortar.covered.clone(),
            ..own.clone()
        };
        let open: Vec<usize> = (0..own.elements.len())
            .filter(|e| !mortar.elements.contains(e))
            .collect();
        assert!(!open.is_empty());
        let areas = contact.areas();
        let dropped: f64 = mortar
            .dropped
            .iter()
            .map(|&(element, share)| share * own.areas()[element])
            .sum();
        let found: f64 = mortar.elements.iter().map(|&e| areas[e]).sum();
        assert!(
            (found + dropped - 0.62 * 0.4).abs() < 1e-12,
            "{shape}: {found} {dropped}"
        );
        if mortar.dropped.is_empty() {
            contact.elements = mortar.elements.iter().map(|&e| own.elements[e]).collect();
            let number = |e: usize| mortar.elements.iter().position(|&kept| kept == e).expect("kept");
            contact
                .covered
                .iter_mut()
                .for_each(|part| part.element = number(part.element));
            // Nodes without elements are no matter here.
            let used: std::collections::BTreeSet<u32> =
                contact.elements.iter().flat_map(|e| e.nodes().to_vec()).collect();
            let of: Vec<u32> = used.into_iter().collect();
            let map = |node: u32| Ok::<u32, ()>(of.binary_search(&node).expect("used") as u32);
            contact.elements = contact
                .elements
                .iter()
                .map(|e| e.try_map_nodes(map).expect("mapped"))
                .collect();
            contact.nodes = of.iter().map(|&node| own.nodes[node as usize]).collect();
            let operators = Operators::try_new(&contact, 3).expect("operators");
            assert!((operators.area() - 0.62 * 0.4).abs() < 1e-12);
            let x: f64 = operators
                .weights
                .iter()
                .zip(&operators.positions)
                .map(|(w, x)| w * x[0])
                .sum();
            assert!((x / operators.area() - 0.45).abs() < 1e-12);
            let points = operators.weights.iter().zip(&operators.positions);
            let moment: f64 = points.map(|(w, x)| w * (x[0] - 0.45) * (x[0] - 0.45)).sum();
            assert!(
                (moment / (0.4 * 0.62_f64.powi(3) / 12.0) - 1.0).abs() < 1e-10,
                "{shape}"
            );
        }
        let ones = product(&mortar.projection, &vec![1.0; other.nodes.len()]);
        let places = product(&mortar.projection, &coordinate(&other, 0));
        for &element in &mortar.elements {
            for &node in own.elements[element].nodes() {
                assert!((ones[node as usize] - 1.0).abs() < 1e-11);
                assert!((places[node as usize] - own.nodes[node as usize][0]).abs() < 1e-11);
            }
        }
    }
}

#[test]
fn curved_faces_have_the_area_of_the_curved_elements() {
    // A part of a cylinder of radius 1 m, up to 0.3 rad to either side.
    let mut areas = Vec::new();
    for n in [4, 8, 16] {
        let mut mesh = grid("quad9", [n, 3], [-0.3, 0.0], [0.6, 0.5], 0.0);
        for x in &mut mesh.nodes {
            x[0] = x[0].sin();
        }
        mesh.heights = mesh.nodes.iter().map(|x| (1.0 - x[0] * x[0]).sqrt()).collect();
        let area = Operators::try_new(&mesh, 3).expect("operators").area();
        assert!((area - mesh.areas().iter().sum::<f64>()).abs() < 1e-7);
        areas.push((area - 0.3).abs());
    }
    assert!(areas[2] < 1e-8 && areas[1] < areas[0] / 10.0, "{areas:?}");
    let cylinder = |shape: &str, n: [usize; 2]| {
        let mut mesh = grid(shape, n, [-0.3, 0.0], [0.6, 0.5], 0.0);
        mesh.heights = mesh.nodes.iter().map(|x| (1.0 - x[0] * x[0]).sqrt()).collect();
        mesh
    };
    let (own, other) = (cylinder("quad4", [12, 4]), cylinder("tri3", [7, 3]));
    let mortar = Mortar::try_new(&own, &other, 0.01).expect("faces");
    // The sagitta of the coarser chords.
    assert!(
        mortar.largest_distance > 1e-4 && mortar.largest_distance < 2e-3,
        "{}",
        mortar.largest_distance
    );
    let passed = transposed_product(&mortar.projection, &forces(&own, [0.0; 2]));
    let total = passed.iter().sum::<f64>();
    assert!((total - own.areas().iter().sum::<f64>()).abs() < 1e-12);
    assert!(matches!(
        Mortar::try_new(&own, &other, 1e-6),
        Ok(_) | Err(Error::NotFacing { .. })
    ));
}

#[test]
fn meshes_that_do_not_face_one_another_are_refused() {
    let own = grid("quad4", [3, 3], [0.0; 2], [1.0; 2], 0.0);
    let aside = grid("quad4", [3, 3], [2.0, 0.0], [1.0; 2], 0.0);
    assert!(matches!(
        Mortar::try_new(&own, &aside, 1e-3),
        Err(Error::NotFacing { .. })
    ));
    let mut above = own.clone();
    above.heights = vec![0.1; above.nodes.len()];
    assert!(matches!(
        Mortar::try_new(&own, &above, 1e-3),
        Err(Error::NotFacing { .. })
    ));
    assert!(Mortar::try_new(&own, &above, 0.2).is_ok());
}
