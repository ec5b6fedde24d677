//! Interfaces with known answers: areas, patch tests, tangents, loops.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use contact_laws::{
    Asperity, AsperityBins, AsperityFriction, Components, ComponentsMut, Cone, ElasticCurves, ElasticPair,
    FrictionalLaw, HistoryRule, PointParameters, ResolvedLaw, StateView, StateViewMut, Sticking, TangentMut,
    TractionLaw, WayBack,
};
use proptest::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;
use zte_assembly::flux::LoopArea;
use zte_assembly::quadrature::Quadrature;
use zte_assembly::shape::{QUAD4, QUAD8, SHAPES, TRI3};
use zte_assembly::{Element, Error, Interface, InterfaceMesh, Operators, PointContact, State, Step};

const NORMAL: f64 = 3e13;
const TANGENTIAL: [f64; 2] = [2e13, 1e13];

/// A distorted patch of quadrilaterals and triangles over a 4 x 3 rectangle [cm].
fn patch() -> InterfaceMesh {
    let (nx, ny) = (4, 3);
    let mut nodes = Vec::new();
    for j in 0..=ny {
        for i in 0..=nx {
            let inner = i > 0 && i < nx && j > 0 && j < ny;
            let shift = if inner {
                0.2 * f64::from((i * 7 + j * 3) % 5 - 2) / 2.0
            } else {
                0.0
            };
            nodes.push([0.01 * (f64::from(i) + shift), 0.01 * (f64::from(j) - 0.7 * shift)]);
        }
    }
    let node = |i: i32, j: i32| (i + (nx + 1) * j) as u32;
    let mut elements = Vec::new();
    for j in 0..ny {
        for i in 0..nx {
            let corners = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            if (i + j) % 3 == 0 {
                elements.push(Element::tri3([corners[0], corners[1], corners[2]]));
                elements.push(Element::tri3([corners[0], corners[2], corners[3]]));
            } else {
                elements.push(Element::quad4(corners));
            }
        }
    }
    InterfaceMesh::flat(nodes, elements)
}

/// [`patch`] in quadratic elements, with or without a node in the centre of quadrilaterals. Middles of inner edges are moved by
/// up to `curved` edges.
fn quadratic_patch(centres: bool, curved: f64) -> InterfaceMesh {
    let InterfaceMesh {
        mut nodes, elements, ..
    } = patch();
    let mut middles = HashMap::new();
    let elements = elements
        .iter()
        .map(|element| {
            let corners = element.corners();
            let n = corners.len();
            let mut all = corners.to_vec();
            for i in 0..n {
                let ends = [
                    corners[i].min(corners[(i + 1) % n]),
                    corners[i].max(corners[(i + 1) % n]),
                ];
                all.push(*middles.entry(ends).or_insert_with(|| {
                    let [a, b] = ends.map(|node| nodes[node as usize]);
                    let mut at = [0, 1].map(|c| 0.5 * (a[c] + b[c]));
                    let inner = at[0] > 1e-9 && at[0] < 0.04 - 1e-9 && at[1] > 1e-9 && at[1] < 0.03 - 1e-9;
                    if inner {
                        let part = curved * (f64::from((ends[0] * 5 + ends[1] * 3) % 7) / 3.0 - 1.0);
                        at = [
                            at[0] + part * (b[1] - a[1]) + 0.3 * part * (b[0] - a[0]),
                            at[1] - part * (b[0] - a[0]),
                        ];
                    }
                    nodes.push(at);
                    nodes.len() as u32 - 1
                }));
            }
            if centres && n == 4 {
                let middle = |c: usize| 0.25 * all[4..].iter().map(|&m| nodes[m as usize][c]).sum::<f64>();
                nodes.push([middle(0), middle(1)]);
                all.push(nodes.len() as u32 - 1);
            }
            Element::from_nodes(&all).unwrap()
        })
        .collect();
    InterfaceMesh::flat(nodes, elements)
}

/// Linear, quadratic and curved meshes of the same rectangle.
fn patches() -> [InterfaceMesh; 5] {
    [
        patch(),
        quadratic_patch(false, 0.0),
        quadratic_patch(true, 0.0),
        quadratic_patch(false, 0.1),
        quadratic_patch(true, 0.1),
    ]
}

fn law(n: usize, mu: f64) -> Arc<dyn TractionLaw> {
    let curves = PointParameters::uniform(ElasticCurves::try_new(NORMAL, TANGENTIAL).unwrap(), n);
    Arc::new(FrictionalLaw::try_new(curves, PointParameters::uniform(mu, n), HistoryRule::Incremental).unwrap())
}

fn interface(points: usize, mu: f64) -> Interface {
    interface_on(&patch(), points, mu)
}

fn interface_on(mesh: &InterfaceMesh, points: usize, mu: f64) -> Interface {
    let operators = Arc::new(Operators::try_new(mesh, points).unwrap());
    let n = operators.n_points();
    // Two laws, so that blocks and ranges are exercised.
    let laws = vec![(0..n / 3, law(n / 3, mu)), (n / 3..n, law(n - n / 3, mu))];
    Interface::try_new(operators, laws, vec![0.0; n]).unwrap()
}

#[test]
fn quadrature_integrates_polynomials_up_to_its_degree() {
    for n in 1..=5 {
        let rule = Quadrature::try_new(n).unwrap();
        let square = &QUAD4;
        for a in 0..2 * n {
            for b in 0..2 * n {
                let sum: f64 = rule
                    .points(square)
                    .iter()
                    .map(|p| p.weight * p.xi[0].powi(a as i32) * p.xi[1].powi(b as i32))
                    .sum();
                let line = |k: usize| if k % 2 == 1 { 0.0 } else { 2.0 / (k as f64 + 1.0) };
                assert!((sum - line(a) * line(b)).abs() < 1e-14, "{n} {a} {b}");
            }
        }
        let triangle = &TRI3;
        let degree = [1, 2, 4, 6, 6][n - 1];
        for a in 0..=degree {
            for b in 0..=degree - a {
                let sum: f64 = rule
                    .points(triangle)
                    .iter()
                    .map(|p| p.weight * p.xi[0].powi(a as i32) * p.xi[1].powi(b as i32))
                    .sum();
                // a! b! / (a + b + 2)!
                let factorial = |k: usize| (1..=k).map(|v| v as f64).product::<f64>();
                let exact = factorial(a) * factorial(b) / factorial(a + b + 2);
                assert!((sum - exact).abs() < 1e-14, "triangle {n} {a} {b}: {sum} {exact}");
            }
        }
        assert_eq!(rule.points(square).len(), n * n);
    }
    assert!(matches!(
        Quadrature::try_new(6),
        Err(Error::Quadrature { per_direction: 6 })
    ));
    assert!(Quadrature::try_new(0).is_err());
}

#[test]
fn shape_functions_are_a_partition_of_unity_with_exact_derivatives() {
    for shape in SHAPES {
        let at = [0.3, 0.2];
        let (values, derivatives) = shape.functions(at);
        assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        for axis in 0..2 {
            let h = 1e-6;
            let moved = |sign: f64| {
                let mut x = at;
                x[axis] += sign * h;
                shape.functions(x).0
            };
            let (up, down) = (moved(1.0), moved(-1.0));
            for a in 0..shape.n_nodes {
                assert!(((up[a] - down[a]) / (2.0 * h) - derivatives[a][axis]).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn weights_and_integration_give_the_exact_area() {
    let meshes = patches();
    for (mesh, points) in meshes.iter().flat_map(|mesh| [1, 2, 3, 5].map(|points| (mesh, points))) {
        if points == 1 && mesh != &meshes[0] {
            continue;
        }
        let operators = Operators::try_new(mesh, points).unwrap();
        assert!((operators.area() / 12e-4 - 1.0).abs() < 1e-13);
        let nodal: f64 = operators.integration.data().iter().sum();
        assert!(
            (nodal / 12e-4 - 1.0).abs() < 1e-13,
            "T spreads the whole area over the nodes"
        );
        let areas = mesh.areas();
        for (element, range) in operators.first_point.windows(2).enumerate() {
            let sum: f64 = operators.weights[range[0]..range[1]].iter().sum();
            assert!((sum / areas[element] - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn patch_test_a_uniform_jump_gives_a_uniform_traction_and_the_exact_resultant() {
    let meshes = patches();
    for (mesh, points) in meshes.iter().flat_map(|mesh| [1, 2, 3, 5].map(|points| (mesh, points))) {
        if points == 1 && mesh != &meshes[0] {
            continue;
        }
        let interface = interface_on(mesh, points, 0.4);
        let jump = [3e-7, -1e-7, 2e-6];
        let u: Vec<f64> = (0..interface.n_dofs()).map(|i| jump[i % 3]).collect();
        let state = interface.initial_state();
        let (mut end, mut workspace) = (state.clone(), interface.workspace());
        let mut force = vec![0.0; interface.n_dofs()];
        let counts = interface.evaluate(
            &u,
            Sticking::Coulomb,
            &state,
            &mut end,
            &mut workspace,
            &mut force,
            None,
        );
        assert_eq!(counts.stick, interface.operators().n_points());
        let expected = [TANGENTIAL[0] * jump[0], TANGENTIAL[1] * jump[1], NORMAL * jump[2]];
        for c in 0..3 {
            for t in &workspace.traction[c] {
                assert!((t / expected[c] - 1.0).abs() < 1e-12);
            }
            let resultant: f64 = force.iter().skip(c).step_by(3).sum();
            assert!((resultant / (expected[c] * 12e-4) - 1.0).abs() < 1e-12);
        }
        // No moment about the centroid of the rectangle; one point does not see the first moment of a distorted quad, nor two
        // that of a curved one.
        if points == 1 || (points == 2 && mesh != &meshes[0]) {
            continue;
        }
        let nodes = &mesh.nodes;
        let moment: f64 = nodes
            .iter()
            .enumerate()
            .map(|(i, x)| (x[0] - 0.02) * force[3 * i + 2])
            .sum();
        assert!(moment.abs() < 1e-12 * expected[2] * 12e-4 * 0.04);
    }
}

#[test]
fn linear_jumps_are_interpolated_exactly_and_the_gap_is_subtracted() {
    let flat = interface(2, 0.3);
    assert!(flat.gap().is_none(), "nothing to subtract, nothing to carry");
    let field = |x: [f64; 2]| 1e-6 + 2e-5 * x[0] - 3e-5 * x[1];
    let nodes = patch().nodes;
    let u: Vec<f64> = (0..flat.n_dofs())
        .map(|i| if i % 3 == 2 { field(nodes[i / 3]) } else { 0.0 })
        .collect();
    let gap: Vec<f64> = flat.operators().positions.iter().map(|x| 1e-7 + 1e-6 * x[0]).collect();
    let gapped = flat.with_gap(gap.clone()).unwrap();
    let state = gapped.initial_state();
    let (mut end, mut workspace, mut force) = (state.clone(), gapped.workspace(), vec![0.0; gapped.n_dofs()]);
    gapped.evaluate(
        &u,
        Sticking::Coulomb,
        &state,
        &mut end,
        &mut workspace,
        &mut force,
        None,
    );
    for (p, x) in gapped.operators().positions.iter().enumerate() {
        assert!((workspace.jump[2][p] - (field(*x) - gap[p])).abs() < 1e-20);
    }
}

#[test]
fn patch_test_linear_tractions_have_their_resultant_and_moments_on_curved_quadratic_elements() {
    let field = |x: [f64; 2]| 1e-6 + 2e-5 * x[0] - 3e-5 * x[1];
    for mesh in &patches()[1..] {
        let interface = interface_on(mesh, 4, 0.3);
        let u: Vec<f64> = (0..interface.n_dofs())
            .map(|i| if i % 3 == 2 { field(mesh.nodes[i / 3]) } else { 0.0 })
            .collect();
        let state = interface.initial_state();
        let (mut end, mut workspace) = (state.clone(), interface.workspace());
        let mut force = vec![0.0; interface.n_dofs()];
        interface.evaluate(
            &u,
            Sticking::Coulomb,
            &state,
            &mut end,
            &mut workspace,
            &mut force,
            None,
        );
        for (traction, x) in workspace.traction[2].iter().zip(&interface.operators().positions) {
            assert!((traction / (NORMAL * field(*x)) - 1.0).abs() < 1e-12);
        }
        // Over the rectangle of 4 cm x 3 cm: mean of x, y, x^2, x y, y^2.
        let (area, [x, y], [xx, xy, yy]) = (12e-4, [0.02, 0.015], [16e-4 / 3.0, 3e-4, 3e-4]);
        let exact = [
            1e-6 + 2e-5 * x - 3e-5 * y,
            1e-6 * x + 2e-5 * xx - 3e-5 * xy,
            1e-6 * y + 2e-5 * xy - 3e-5 * yy,
        ]
        .map(|mean| NORMAL * area * mean);
        let mut found = [0.0; 3];
        for (node, [x, y]) in mesh.nodes.iter().enumerate() {
            for (sum, arm) in found.iter_mut().zip([1.0, *x, *y]) {
                *sum += arm * force[3 * node + 2];
            }
        }
        for (found, exact) in found.iter().zip(exact) {
            assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
        }
    }
}

#[test]
fn a_uniform_traction_pulls_at_the_corners_of_eight_nodes_and_opens_no_point() {
    // Square of 2 cm.
    let nodes: Vec<[f64; 2]> = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]]
        .map(|x| x.map(|v| 0.01 * f64::from(v)))
        .to_vec();
    let mesh = InterfaceMesh::flat(nodes, vec![Element::quad8([0, 1, 2, 3, 4, 5, 6, 7])]);
    let interface = interface_on(&mesh, 3, 0.3);
    let u: Vec<f64> = (0..24).map(|i| [0.0, 0.0, 1e-6][i % 3]).collect();
    let state = interface.initial_state();
    let (mut end, mut workspace, mut force) = (state.clone(), interface.workspace(), vec![0.0; 24]);
    let counts = interface.evaluate(
        &u,
        Sticking::Coulomb,
        &state,
        &mut end,
        &mut workspace,
        &mut force,
        None,
    );
    assert_eq!((counts.stick, counts.open), (9, 0));
    let resultant = NORMAL * 1e-6 * 4e-4;
    for node in 0..8 {
        let share = if node < 4 { -1.0 / 12.0 } else { 1.0 / 3.0 };
        assert!((force[3 * node + 2] / resultant - share).abs() < 1e-14);
    }
}

#[test]
fn quadratic_elements_follow_curved_edges() {
    // A quarter of a ring between 1 and 2 cm, in elements of a sixth of a right angle: parabolas enclose the ring to 1e-6.
    let n = 6;
    let mut nodes = Vec::new();
    for j in 0..=2 * n {
        for i in 0..3 {
            let (radius, angle) = (
                0.01 + 0.005 * f64::from(i),
                std::f64::consts::FRAC_PI_4 * f64::from(j) / f64::from(n),
            );
            nodes.push([radius * angle.cos(), radius * angle.sin()]);
        }
    }
    let node = |i: i32, j: i32| (i + 3 * j) as u32;
    let elements = (0..n).map(|k| {
        let j = 2 * k;
        Element::quad9([
            node(0, j),
            node(2, j),
            node(2, j + 2),
            node(0, j + 2),
            node(1, j),
            node(2, j + 1),
            node(1, j + 2),
            node(0, j + 1),
            node(1, j + 1),
        ])
    });
    let mesh = InterfaceMesh::flat(nodes, elements.collect());
    let exact = std::f64::consts::FRAC_PI_4 * 3e-4;
    let operators = Operators::try_new(&mesh, 3).unwrap();
    let relative = operators.area() / exact - 1.0;
    println!("{relative:.1e}");
    assert!(relative.abs() < 1e-5, "{relative}");
    assert!((mesh.areas().iter().sum::<f64>() / operators.area() - 1.0).abs() < 1e-13);
    // Two triangles to a quadrilateral, with the curved edges of both.
    let halves = mesh.elements.iter().flat_map(|element| {
        let [a, b, c, d, ab, bc, cd, da, centre] = element.nodes().try_into().unwrap();
        [
            Element::tri6([a, b, c, ab, bc, centre]),
            Element::tri6([a, c, d, centre, cd, da]),
        ]
    });
    let triangles = InterfaceMesh::flat(mesh.nodes.clone(), halves.collect());
    let area = Operators::try_new(&triangles, 3).unwrap().area();
    assert!((area / operators.area() - 1.0).abs() < 1e-13);
}

fn force_at(interface: &Interface, u: &[f64], begin: &State) -> Vec<f64> {
    force_into(interface, u, begin, &mut begin.clone())
}

fn force_into(interface: &Interface, u: &[f64], begin: &State, end: &mut State) -> Vec<f64> {
    let (mut workspace, mut force) = (interface.workspace(), vec![0.0; interface.n_dofs()]);
    interface.evaluate(u, Sticking::Coulomb, begin, end, &mut workspace, &mut force, None);
    force
}

/// What was no number stays none at its points, however the histories are passed on, and spoils no others.
#[test]
fn a_history_that_is_no_number_spoils_its_points_alone() {
    let operators = Arc::new(Operators::try_new(&patch(), 2).unwrap());
    let n = operators.n_points();
    let asperity = Asperity::try_new(ElasticPair::new(192e9, 0.3), 1.4e-3, None).unwrap();
    let bins = AsperityBins::try_new(asperity, vec![0.0, 4e-6], vec![1e6; 2]).unwrap();
    let friction = AsperityFriction::StickSlip(HistoryRule::Incremental);
    let mu = PointParameters::uniform(0.2, n);
    let law = ResolvedLaw::try_new(PointParameters::uniform(bins, n), mu, friction, Cone::Circle).unwrap();
    let interface = Interface::try_new(operators, vec![(0..n, Arc::new(law))], vec![0.0; n]).unwrap();
    let sound: Vec<f64> = (0..interface.n_dofs()).map(|i| [1e-7, 0.0, 1e-6][i % 3]).collect();
    let start = interface.initial_state();
    let expected = force_at(&interface, &sound, &start);
    let mut spoilt = sound.clone();
    spoilt[0] = f64::NAN;
    let mut end = start.clone();
    force_into(&interface, &spoilt, &start, &mut end);
    let found = force_at(&interface, &sound, &end);
    assert!(found[0].is_nan() && found[2].is_nan());
    let last = expected.len() - 3;
    assert!(
        found[last..].iter().all(|force| force.is_finite()),
        "{:?}",
        &found[last..]
    );
    // And back from a state that is sound, into the same room.
    assert_eq!(force_into(&interface, &sound, &start, &mut end), expected);
    assert!(force_at(&interface, &sound, &end).iter().all(|force| force.is_finite()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn tangent_is_the_derivative_of_the_force(seed in 0u64..1000, points in 1usize..=3, mesh in 0usize..5) {
        let points = if mesh == 0 { points } else { points + 1 };
        let interface = interface_on(&patches()[mesh], points, 0.3);
        let mut next = numbers(seed);
        // Mixed stick and slip, everything closed and away from kinks with probability one.
        let u: Vec<f64> =
            (0..interface.n_dofs()).map(|i| if i % 3 == 2 { 1e-6 * (1.0 + next()) } else { 2e-6 * (next() - 0.5) }).collect();
        let v: Vec<f64> = (0..interface.n_dofs()).map(|_| next() - 0.5).collect();
        let state = interface.initial_state();
        let (mut end, mut workspace, mut force) =
            (state.clone(), interface.workspace(), vec![0.0; interface.n_dofs()]);
        let mut values = vec![0.0; interface.pattern().indices.len()];
        interface.evaluate(&u, Sticking::Coulomb, &state, &mut end, &mut workspace, &mut force, Some(&mut values));
        let pattern = interface.pattern();
        let product: Vec<f64> = (0..interface.n_dofs())
            .map(|row| {
                let range = pattern.indptr[row]..pattern.indptr[row + 1];
                pattern.indices[range.clone()].iter().zip(&values[range]).map(|(&j, k)| k * v[j]).sum()
            })
            .collect();
        let h = 1e-11;
        let along = |sign: f64| {
            let moved: Vec<f64> = u.iter().zip(&v).map(|(u, v)| u + sign * h * v).collect();
            force_at(&interface, &moved, &state)
        };
        let (up, down) = (along(1.0), along(-1.0));
        let scale = product.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
        for i in 0..product.len() {
            let difference = (up[i] - down[i]) / (2.0 * h);
            prop_assert!((difference - product[i]).abs() <= 1e-6 * scale, "{} {} {}", i, difference, product[i]);
        }
    }
}

/// Numbers in [0, 1) that look random.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut s = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        (s >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Tractions and tangents of an interface's laws at given jumps, from the history of bodies at rest.
fn laws_alone(interface: &Interface, jump: &[Vec<f64>; 3]) -> ([Vec<f64>; 3], [Vec<f64>; 9]) {
    let n = interface.operators().n_points();
    let mut traction: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; n]);
    let mut tangent: [Vec<f64>; 9] = std::array::from_fn(|_| vec![0.0; n]);
    let apart = interface
        .gap()
        .map_or_else(|| vec![0.0; n], |gap| gap.iter().map(|g| -g).collect());
    let rest = [vec![0.0; n], vec![0.0; n], apart];
    let mut start = 0;
    while let Some((law, 0)) = interface.law(start) {
        let points = start..start + law.len();
        let mut history = vec![0.0; law.len() * law.info().n_state()];
        for jump in [&rest, jump] {
            let begin = history.clone();
            let [x, y, normal] = jump.each_ref().map(|v| &v[points.clone()]);
            let [tx, ty, tn] = traction.each_mut().map(|v| &mut v[points.clone()]);
            law.evaluate(
                0..law.len(),
                Sticking::Coulomb,
                Components::new(x, y, normal),
                StateView::new(&begin, law.len(), 0),
                StateViewMut::new(&mut history, law.len(), 0),
                ComponentsMut::new(tx, ty, tn),
                Some(TangentMut::from_entries(
                    tangent.each_mut().map(|v| &mut v[points.clone()]),
                )),
                None,
            );
        }
        start = points.end;
    }
    assert_eq!(start, n);
    (traction, tangent)
}

#[test]
fn jumps_forces_and_tangents_are_those_of_q_and_t() {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |m, v| m.max(v.abs()));
    let meshes = patches();
    for (mesh, points) in meshes.iter().flat_map(|mesh| [1, 2, 3, 5].map(|points| (mesh, points))) {
        if points == 1 && mesh != &meshes[0] {
            continue;
        }
        let flat = interface_on(mesh, points, 0.3);
        let mut next = numbers(points as u64);
        let gap = (0..flat.operators().n_points()).map(|_| 2e-7 * next()).collect();
        let interface = flat.with_gap(gap).unwrap();
        let (n_dofs, operators) = (interface.n_dofs(), interface.operators());
        let u: Vec<f64> = (0..n_dofs)
            .map(|i| {
                if i % 3 == 2 {
                    3e-6 * (next() - 0.4)
                } else {
                    4e-7 * (next() - 0.5)
                }
            })
            .collect();
        let begin = interface.initial_state();
        let (mut end, mut workspace) = (begin.clone(), interface.workspace());
        // What is left from an earlier evaluation must not matter.
        let mut force = vec![f64::NAN; n_dofs];
        let pattern = interface.pattern();
        let mut values = vec![f64::NAN; pattern.indices.len()];
        let coulomb = Sticking::Coulomb;
        let tangent = Some(&mut values[..]);
        let counts = interface.evaluate(&u, coulomb, &begin, &mut end, &mut workspace, &mut force, tangent);
        assert!(counts.stick > 0 && counts.slip > 0 && counts.open > 0, "{counts:?}");

        let jump_scale = largest(&mut u.iter().copied());
        for (p, row) in operators.interpolation.outer_iterator().enumerate() {
            for c in 0..3 {
                let gap = if c == 2 { interface.gap().unwrap()[p] } else { 0.0 };
                let jump = row.iter().map(|(node, q)| q * u[3 * node + c]).sum::<f64>() - gap;
                assert!((workspace.jump[c][p] - jump).abs() <= 1e-15 * jump_scale);
            }
        }

        let (traction, entries) = laws_alone(&interface, &workspace.jump);
        assert_eq!(traction, workspace.traction);
        let (mut plain_force, mut plain) = (vec![0.0; n_dofs], vec![vec![0.0; n_dofs]; n_dofs]);
        for (node, row) in operators.integration.outer_iterator().enumerate() {
            for (p, area) in row.iter() {
                for i in 0..3 {
                    plain_force[3 * node + i] += area * traction[i][p];
                    for (other, q) in operators.interpolation.outer_view(p).unwrap().iter() {
                        for j in 0..3 {
                            plain[3 * node + i][3 * other + j] += area * entries[3 * i + j][p] * q;
                        }
                    }
                }
            }
        }
        let force_scale = largest(&mut plain_force.iter().copied());
        for (found, expected) in force.iter().zip(&plain_force) {
            assert!((found - expected).abs() <= 1e-14 * force_scale, "{found} {expected}");
        }
        let scale = largest(&mut plain.iter().flatten().copied());
        for (i, row) in plain.iter_mut().enumerate() {
            let range = pattern.indptr[i]..pattern.indptr[i + 1];
            assert!(pattern.indices[range.clone()].is_sorted_by(|a, b| a < b));
            for (&j, found) in pattern.indices[range.clone()].iter().zip(&values[range]) {
                assert!((found - row[j]).abs() <= 1e-14 * scale, "{i} {j}: {found} {}", row[j]);
                row[j] = 0.0;
            }
            assert!(
                row.iter().all(|rest| *rest == 0.0),
                "row {i} has entries outside the pattern"
            );
        }
    }
}

#[test]
fn loop_area_is_the_dissipation_of_a_sliding_cycle() {
    // Every point slides along x under constant closure: area 4 mu t_n (X - mu t_n / k).
    let mu = 0.2;
    let interface = interface(2, mu);
    let n = interface.operators().n_points();
    let (closure, peak) = (1e-6, 2e-6);
    let mut state = interface.initial_state();
    let mut workspace = interface.workspace();
    let mut force = vec![0.0; interface.n_dofs()];
    let mut area = LoopArea::new(n);
    let turning = [peak, -peak, peak, -peak, peak];
    let mut at = 0.0;
    for (branch, target) in turning.into_iter().enumerate() {
        let mut end = state.clone();
        let steps = 400;
        for step in 1..=steps {
            let x = at + (target - at) * f64::from(step) / f64::from(steps);
            let u: Vec<f64> = (0..interface.n_dofs()).map(|i| [x, 0.0, closure][i % 3]).collect();
            interface.evaluate(
                &u,
                Sticking::Coulomb,
                &state,
                &mut end,
                &mut workspace,
                &mut force,
                None,
            );
            if branch > 2 || (branch == 2 && step == steps) {
                area.add(&workspace);
            }
        }
        at = target;
        state = end;
    }
    let limit = mu * NORMAL * closure;
    let exact = 4.0 * limit * (peak - limit / TANGENTIAL[0]);
    let flux = area.close();
    for p in 0..n {
        assert!((flux[0][p] / exact - 1.0).abs() < 1e-4, "{} {exact}", flux[0][p]);
        assert_eq!(flux[1][p], 0.0);
        assert_eq!(flux[2][p], 0.0);
    }
}

#[test]
fn defects_are_refused_by_name() {
    let mut mesh = patch();
    mesh.elements[0] = Element::tri3([0, 1, 99]);
    assert!(matches!(
        Operators::try_new(&mesh, 2),
        Err(Error::Dangling {
            element: 0,
            node: 99,
            ..
        })
    ));
    let mut mesh = patch();
    assert_eq!(mesh.elements[2].shape(), &QUAD4);
    mesh.elements[2].nodes_mut().swap(0, 1);
    assert!(matches!(
        Operators::try_new(&mesh, 2),
        Err(Error::Inverted { element: 2, .. })
    ));
    let mut mesh = patch();
    mesh.nodes.push([1.0, 1.0]);
    assert!(matches!(mesh.validate(), Err(Error::Unused { node: 20 })));
    let lists = |element: usize, list: &[u32]| {
        let mesh = patch();
        let mut lists: Vec<Vec<u32>> = mesh.elements.iter().map(|e| e.nodes().to_vec()).collect();
        lists[element] = list.to_vec();
        InterfaceMesh::try_from_lists(mesh.nodes, lists)
    };
    let same = patch().elements[5].nodes().to_vec();
    assert_eq!(lists(5, &same).unwrap(), patch());
    assert!(matches!(
        lists(1, &[0, 1]),
        Err(Error::NodeCount { element: 1, found: 2 })
    ));
    assert!(matches!(
        lists(1, &[0, 1, 99]),
        Err(Error::Dangling {
            element: 1,
            node: 99,
            ..
        })
    ));
    assert!(matches!(
        lists(1, &[0, 1, 0]),
        Err(Error::RepeatedNode { element: 1, node: 0 })
    ));
    let mut turned = same.clone();
    turned.rotate_left(1);
    assert!(matches!(
        lists(7, &turned),
        Err(Error::DuplicateElement { element: 7, first: 5 })
    ));
    // A triangle over two neighbours, with nodes of both.
    let mut covered = patch();
    covered.elements.push(Element::tri3([0, 2, 11]));
    let last = covered.elements.len() - 1;
    let error = Operators::try_new(&covered, 2).unwrap_err();
    assert!(
        matches!(error, Error::OverlappingElements { element, first: 0, shared, .. } if element == last && shared > 1e-6),
        "{error}"
    );
    // A middle node moved beyond its neighbours turns the element inside out there.
    let mut curved = quadratic_patch(false, 0.0);
    let element = curved.elements.iter().position(|e| e.shape() == &QUAD8).unwrap();
    let [first, middle] = [0, 4].map(|local| curved.elements[element].nodes()[local] as usize);
    curved.nodes[middle] = [curved.nodes[first][0] - 0.005, curved.nodes[first][1]];
    let error = Operators::try_new(&curved, 3).unwrap_err();
    assert!(
        matches!(error, Error::Inverted { element: found, determinant, .. } if found == element && determinant < 0.0),
        "{error}"
    );
    mesh.nodes[3][1] = f64::NAN;
    assert!(matches!(mesh.validate(), Err(Error::Value { index: 3, .. })));
    let operators = Arc::new(Operators::try_new(&patch(), 2).unwrap());
    let n = operators.n_points();
    let short = Interface::try_new(operators.clone(), vec![(0..n - 1, law(n - 1, 0.1))], vec![0.0; n]);
    assert!(matches!(short, Err(Error::Coverage { .. })));
    let negative = Interface::try_new(operators, vec![(0..n, law(n, 0.1))], vec![-1e-9; n]);
    assert!(matches!(
        negative,
        Err(Error::Value {
            quantity: "gap",
            index: 0,
            ..
        })
    ));
}

#[test]
fn nodal_least_squares_recovers_nodal_fields_and_keeps_integrals() {
    let meshes = patches();
    for (mesh, points) in meshes.iter().flat_map(|mesh| [2, 3, 5].map(|points| (mesh, points))) {
        if points == 2 && mesh != &meshes[0] {
            continue;
        }
        let operators = Operators::try_new(mesh, points).unwrap();
        let at_points = |nodal: &[f64]| -> Vec<f64> {
            let rows = operators.interpolation.outer_iterator();
            rows.map(|row| row.iter().map(|(j, n)| n * nodal[j]).sum()).collect()
        };
        let nodal: Vec<f64> = (0..mesh.nodes.len()).map(|i| 1e7 * (i as f64).sin()).collect();
        let found = operators.nodal_least_squares(&at_points(&nodal));
        for (found, given) in found.iter().zip(&nodal) {
            assert!((found - given).abs() < 1e-3, "{found} instead of {given}");
        }
        // A pressure that ends within an element is no interpolant: the residual is orthogonal to all interpolants.
        let pressure: Vec<f64> = operators
            .positions
            .iter()
            .map(|[x, _]| (x - 0.017).max(0.0) * 1e9)
            .collect();
        let found = operators.nodal_least_squares(&pressure);
        assert!(found.iter().any(|p| *p < 0.0), "it overshoots at the edge of contact");
        let rest: Vec<f64> = at_points(&found).iter().zip(&pressure).map(|(a, b)| a - b).collect();
        let scale: f64 = pressure.iter().zip(&operators.weights).map(|(p, w)| p * w).sum();
        for row in operators.integration.outer_iterator() {
            let moment: f64 = row.iter().map(|(p, t)| t * rest[p]).sum();
            assert!(moment.abs() < 1e-11 * scale, "{moment}");
        }
    }
}

#[test]
fn central_points_are_the_centres_where_the_rule_has_them() {
    let mesh = patch();
    let operators = Operators::try_new(&mesh, 3).unwrap();
    for (element, point) in mesh.elements.iter().zip(operators.central_points()) {
        if element.shape() == &QUAD4 {
            for axis in 0..2 {
                let centre = 0.25
                    * element
                        .nodes()
                        .iter()
                        .map(|&n| mesh.nodes[n as usize][axis])
                        .sum::<f64>();
                assert!((operators.positions[point][axis] - centre).abs() < 1e-12);
            }
        }
    }
}

/// `mesh` and its mirror image about the line y = 0, and for each node of the whole that of the half and its side.
fn with_image(mesh: &InterfaceMesh) -> (InterfaceMesh, Vec<(usize, f64)>) {
    let mut whole = mesh.clone();
    let mut origin: Vec<_> = (0..mesh.nodes.len()).map(|node| (node, 1.0)).collect();
    let image: Vec<u32> = mesh
        .nodes
        .iter()
        .zip(0..)
        .map(|(&[x, y], node)| {
            if y == 0.0 {
                return node;
            }
            whole.nodes.push([x, -y]);
            origin.push((node as usize, -1.0));
            whole.nodes.len() as u32 - 1
        })
        .collect();
    let images = mesh.elements.iter().map(|element| {
        let mut image = element.nodes().iter().map(|&n| image[n as usize]).collect::<Vec<_>>();
        let n = element.corners().len();
        image[1..n].reverse();
        // The edge before the first corner comes first now.
        if image.len() > n {
            image[n..2 * n].reverse();
        }
        Element::from_nodes(&image).unwrap()
    });
    whole.elements.extend(images);
    (whole, origin)
}

#[test]
fn the_half_of_a_symmetric_interface_stands_for_the_whole() {
    for mesh in patches() {
        half_stands_for_whole(mesh);
    }
}

fn half_stands_for_whole(half_mesh: InterfaceMesh) {
    let (whole_mesh, origin) = with_image(&half_mesh);
    let n_half = 3 * half_mesh.nodes.len();
    let of = |operators: Operators| {
        let n = operators.n_points();
        Interface::try_new(Arc::new(operators), vec![(0..n, law(n, 0.3))], vec![0.0; n]).unwrap()
    };
    let half = of(Operators::try_new_mirrored(&half_mesh, 2).unwrap());
    let whole = of(Operators::try_new(&whole_mesh, 2).unwrap());
    assert!((half.operators().area() / whole.operators().area() - 1.0).abs() < 1e-14);
    let on_line = half_mesh.nodes.iter().enumerate().filter(|(_, x)| x[1] == 0.0);
    let held: Vec<usize> = on_line.map(|(node, _)| 3 * node + 1).collect();
    assert!(held.starts_with(&[1, 4, 7, 10, 13]));
    assert_eq!(half.operators().held(), held);

    // Motions of the whole from those of the half; of held coordinates whatever is given is ignored.
    let spread = |u: &[f64]| -> Vec<f64> {
        let components = origin.iter().flat_map(|&(node, side)| {
            let y = if half_mesh.nodes[node][1] == 0.0 { 0.0 } else { side };
            [(3 * node, 1.0), (3 * node + 1, y), (3 * node + 2, 1.0)]
        });
        components.map(|(i, factor)| factor * u[i]).collect()
    };
    let gather = |f: &[f64]| -> Vec<f64> {
        let mut sums = vec![0.0; n_half];
        for (i, &(node, side)) in origin.iter().enumerate() {
            for (c, factor) in [1.0, side, 1.0].into_iter().enumerate() {
                sums[3 * node + c] += factor * f[3 * i + c];
            }
        }
        held.iter().for_each(|&i| sums[i] = 0.0);
        sums
    };
    let evaluate = |interface: &Interface, u: &[f64]| {
        let state = interface.initial_state();
        let (mut end, mut workspace) = (state.clone(), interface.workspace());
        let mut force = vec![0.0; interface.n_dofs()];
        let mut tangent = vec![0.0; interface.pattern().indices.len()];
        let counts = interface.evaluate(
            u,
            Sticking::Coulomb,
            &state,
            &mut end,
            &mut workspace,
            &mut force,
            Some(&mut tangent),
        );
        (counts, force, tangent)
    };
    let product = |interface: &Interface, values: &[f64], v: &[f64]| -> Vec<f64> {
        let pattern = interface.pattern();
        let rows = pattern.indptr.windows(2).map(|ends| ends[0]..ends[1]);
        rows.map(|row| row.map(|at| values[at] * v[pattern.indices[at]]).sum())
            .collect()
    };
    let agree = |a: &[f64], b: &[f64]| {
        let scale = a.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(scale > 0.0);
        for (i, (a, b)) in a.iter().zip(b).enumerate() {
            assert!((a - b).abs() <= 1e-13 * scale, "{i}: {a} {b}");
        }
        held.iter().for_each(|&i| assert_eq!(a[i], 0.0));
    };
    let wave = |scale: [f64; 3], phase: f64| -> Vec<f64> {
        (0..n_half)
            .map(|i| scale[i % 3] * (phase + 0.7 * i as f64).sin())
            .collect()
    };
    let u: Vec<f64> = wave([0.4e-6, 0.4e-6, 3e-6], 0.3)
        .iter()
        .zip(0..)
        .map(|(u, i)| u + if i % 3 == 2 { 0.8e-6 } else { 0.0 })
        .collect();
    let (of_half, of_whole) = (evaluate(&half, &u), evaluate(&whole, &spread(&u)));
    assert!(of_half.0.stick > 0 && of_half.0.slip > 0 && of_half.0.open > 0);
    assert_eq!(
        (2 * of_half.0.stick, 2 * of_half.0.slip),
        (of_whole.0.stick, of_whole.0.slip)
    );
    agree(&of_half.1, &gather(&of_whole.1));
    let v = wave([1.0; 3], 1.1);
    agree(
        &product(&half, &of_half.2, &v),
        &gather(&product(&whole, &of_whole.2, &spread(&v))),
    );
}

#[test]
fn halves_that_cross_or_miss_the_line_are_refused() {
    for shift in [-0.001, 0.001] {
        let mut mesh = patch();
        mesh.nodes.iter_mut().for_each(|x| x[1] += shift);
        let refused = Operators::try_new_mirrored(&mesh, 2);
        assert!(
            matches!(refused, Err(Error::Value { value, .. }) if value == shift),
            "{refused:?}"
        );
    }
}

/// Points of contact at nodes of their own, with areas and held components.
fn points(of: &[(f64, [bool; 3])]) -> InterfaceMesh {
    let element =
        |(node, &(area, held)): (usize, &(f64, [bool; 3]))| Element::point(node as u32, PointContact { area, held });
    InterfaceMesh::flat(vec![[0.0; 2]; of.len()], of.iter().enumerate().map(element).collect())
}

#[test]
fn points_of_contact_turn_tractions_into_forces_at_their_nodes_alone() {
    let areas = [1.0, 2.5e-4];
    let mesh = points(&areas.map(|area| (area, [false; 3])));
    assert!(mesh.is_of_points() && !patch().is_of_points());
    assert_eq!(mesh.areas(), areas);
    for per_direction in [1, 2, 5] {
        let operators = Operators::try_new(&mesh, per_direction).unwrap();
        assert_eq!(operators.weights, areas);
        assert_eq!(operators.first_point, [0, 1, 2]);
        let full = |matrix: &sprs::CsMat<f64>| matrix.to_dense().into_raw_vec_and_offset().0;
        assert_eq!(full(&operators.interpolation), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(full(&operators.integration), [areas[0], 0.0, 0.0, areas[1]]);
        assert_eq!(operators.element_means(&[3.0, 5.0]), [3.0, 5.0]);
        assert_eq!(operators.central_points(), [0, 1]);
        let nodal = operators.nodal_least_squares(&[3.0, 5.0]);
        assert!(
            nodal
                .iter()
                .zip([3.0, 5.0])
                .all(|(a, b)| (a / b - 1.0_f64).abs() < 1e-12)
        );
        assert!(operators.held().is_empty());
    }
    let interface = interface_on(&mesh, 2, 1e9);
    let (state, u) = (interface.initial_state(), [1e-7, -2e-7, 3e-6, 2e-7, 0.0, 1e-6]);
    let (mut end, mut workspace, mut force) = (state.clone(), interface.workspace(), vec![0.0; 6]);
    let mut tangent = vec![0.0; interface.pattern().indices.len()];
    let counts = interface.evaluate(
        &u,
        Sticking::Coulomb,
        &state,
        &mut end,
        &mut workspace,
        &mut force,
        Some(&mut tangent),
    );
    assert_eq!(counts.stick, 2);
    let stiffness = [TANGENTIAL[0], TANGENTIAL[1], NORMAL];
    for (i, (force, u)) in force.iter().zip(u).enumerate() {
        let expected = areas[i / 3] * stiffness[i % 3] * u;
        assert!(
            (force - expected).abs() <= 1e-12 * expected.abs(),
            "{i}: {force} {expected}"
        );
    }
    // Each node is coupled with itself alone.
    assert_eq!(
        interface.pattern().indices,
        [0, 1, 2, 0, 1, 2, 0, 1, 2, 3, 4, 5, 3, 4, 5, 3, 4, 5]
    );
    for row in 0..6 {
        let own = tangent[3 * row + row % 3];
        assert!((own / (areas[row / 3] * stiffness[row % 3]) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn components_that_a_point_lacks_do_not_move_and_take_no_force() {
    let held = [[false, true, false], [false, false, true]];
    let mesh = points(&held.map(|held| (1.0, held)));
    let interface = interface_on(&mesh, 2, 0.3).with_interference(vec![0.0, 2e-6]).unwrap();
    assert_eq!(interface.operators().held(), [1, 5]);
    let state = interface.initial_state();
    let (mut end, mut workspace, mut force) = (state.clone(), interface.workspace(), vec![0.0; 6]);
    let mut tangent = vec![0.0; interface.pattern().indices.len()];
    interface.evaluate(
        &[1e-7, 9.0, 1e-6, 1.0, 0.0, -9.0],
        Sticking::Coulomb,
        &state,
        &mut end,
        &mut workspace,
        &mut force,
        Some(&mut tangent),
    );
    // The second point slips under the pressure that its interference gives, whatever is said of its normal.
    let slip = 0.3 * NORMAL * 2e-6;
    for (i, expected) in [TANGENTIAL[0] * 1e-7, 0.0, NORMAL * 1e-6, slip, 0.0, 0.0]
        .into_iter()
        .enumerate()
    {
        assert!(
            (force[i] - expected).abs() <= 1e-12 * expected.abs(),
            "{i}: {}",
            force[i]
        );
    }
    assert!((workspace.traction[2][1] / (NORMAL * 2e-6) - 1.0).abs() < 1e-12);
    for at in (0..18).filter(|at| {
        let (row, column) = (at / 3, interface.pattern().indices[*at]);
        [1, 5].contains(&row) || [1, 5].contains(&column)
    }) {
        assert_eq!(tangent[at], 0.0);
    }
}

#[test]
fn interference_presses_the_faces_together_at_rest() {
    let flat = interface_on(&points(&[(1.0, [false; 3]); 2]), 1, 0.3);
    let pressed = flat.with_interference(vec![0.0, 4e-6]).unwrap();
    assert_eq!(pressed.gap(), Some(&[0.0, -4e-6][..]));
    let gapped = flat.with_gap(vec![1e-6, 0.0]).unwrap();
    let both = gapped.with_interference(vec![0.0, 4e-6]).unwrap();
    assert_eq!(both.gap(), Some(&[1e-6, -4e-6][..]));
    assert!(flat.with_interference(vec![0.0; 2]).unwrap().gap().is_none());
    let state = pressed.initial_state();
    let (mut end, mut workspace, mut force) = (state.clone(), pressed.workspace(), vec![0.0; 6]);
    let mut press = |closure: f64| {
        let u = [0.0, 0.0, closure, 0.0, 0.0, closure];
        pressed.evaluate(
            &u,
            Sticking::Coulomb,
            &state,
            &mut end,
            &mut workspace,
            &mut force,
            None,
        );
        [force[2], force[5]]
    };
    for closure in [0.0_f64, 1e-6, -1e-6, -5e-6] {
        let found = press(closure);
        for (found, interference) in found.into_iter().zip([0.0, 4e-6]) {
            let expected = NORMAL * (closure + interference).max(0.0);
            assert!(
                (found - expected).abs() <= 1e-12 * expected,
                "{closure}: {found} {expected}"
            );
        }
    }
    let refused = flat.with_interference(vec![0.0, -1e-9]);
    assert!(matches!(
        refused,
        Err(Error::Value {
            quantity: "interference",
            index: 1,
            ..
        })
    ));
    assert!(matches!(
        flat.with_interference(vec![0.0; 3]),
        Err(Error::Coverage { .. })
    ));
}

#[test]
fn points_of_contact_without_an_area_and_twice_at_a_node_are_refused() {
    for area in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mesh = points(&[(1.0, [false; 3]), (area, [false; 3])]);
        let error = Operators::try_new(&mesh, 1).unwrap_err();
        assert!(matches!(error, Error::PointArea { element: 1, .. }), "{error}");
    }
    let mut twice = points(&[(1.0, [false; 3])]);
    twice.elements.push(twice.elements[0]);
    assert!(matches!(
        twice.validate(),
        Err(Error::DuplicateElement { element: 1, first: 0 })
    ));
    // A list of nodes says nothing of the area.
    let error = InterfaceMesh::try_from_lists(vec![[0.0; 2]], [[0]]).unwrap_err();
    assert!(matches!(error, Error::NodeCount { element: 0, found: 1 }), "{error}");
}

/// Transposed derivatives against derivatives: the product of an adjoint with a change is the same on both sides.
#[test]
fn adjoints_are_the_transposes_of_derivatives() {
    let plain = interface(2, 0.2);
    let gap = (0..plain.operators().n_points()).map(|i| 1e-7 * (i % 5) as f64);
    let interface = plain.with_gap(gap.collect()).unwrap();
    let mut random = numbers(7);
    let nd = interface.n_dofs();
    let mut vector = |size: f64, normal: f64| -> Vec<f64> {
        (0..nd)
            .map(|i| size * random() + if i % 3 == 2 { normal } else { 0.0 })
            .collect()
    };
    let (first, second) = (vector(1e-7, 4e-7), vector(4e-7, 4e-7));
    let mut workspace = interface.workspace();
    let (mut begin, mut end) = (interface.initial_state(), interface.no_change());
    let mut force = vec![0.0; nd];
    // The history of a path that slips in part.
    for jump in [&first, &second] {
        interface.evaluate(
            jump,
            Sticking::Coulomb,
            &begin,
            &mut end,
            &mut workspace,
            &mut force,
            None,
        );
        std::mem::swap(&mut begin, &mut end);
    }
    let jump = vector(3e-7, 5e-7);
    let states = |interface: &Interface, jump: &[f64]| {
        // Histories as good as random ones: those of other motions, which have the right units.
        let (mut end, mut force) = (interface.no_change(), vec![0.0; nd]);
        let mut workspace = interface.workspace();
        let (none, rest) = (interface.no_change(), Sticking::Full);
        interface.evaluate(jump, rest, &none, &mut end, &mut workspace, &mut force, None);
        end
    };
    let (d_begin, adjoint) = (
        states(&interface, &vector(1e-7, 2e-7)),
        states(&interface, &vector(1e-7, 3e-7)),
    );
    let (d_jump, of_force) = (vector(1e-7, 0.0), vector(1e-3, 0.0));
    let (mut d_end, mut d_force) = (interface.no_change(), vec![0.0; nd]);
    interface.derivative(
        &jump,
        Sticking::Coulomb,
        &begin,
        &d_jump,
        &d_begin,
        None,
        &mut end,
        &mut d_end,
        &mut workspace,
        &mut force,
        &mut d_force,
    );
    let adjoints = [adjoint];
    let mut to_jump = vec![vec![0.0; nd]];
    let forces = [of_force.clone()];
    let mut to_begin = adjoints.clone();
    // And of another step that leads to this one.
    let (first, mut before) = (interface.initial_state(), interface.workspace());
    interface.evaluate(
        &vector(2e-7, 4e-7),
        Sticking::Coulomb,
        &first,
        &mut end,
        &mut before,
        &mut force,
        None,
    );
    let before = Step {
        begin: &first,
        workspace: &before,
    };
    let (mut to_jump_before, mut expected) = (to_jump.clone(), to_jump.clone());
    interface.transposed(
        Step {
            begin: &begin,
            workspace: &workspace,
        },
        WayBack::Committed,
        &mut to_begin,
        &forces,
        &mut to_jump,
        &mut [],
        Some((before, &mut to_jump_before)),
    );
    let mut kept = to_begin.clone();
    let jump_alone = WayBack::JumpAlone;
    interface.transposed(before, jump_alone, &mut kept, &[], &mut expected, &mut [], None);
    assert_eq!(to_jump_before, expected);
    assert!(kept == to_begin && expected[0].iter().any(|value| *value != 0.0));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let forwards = adjoints[0].product(&d_end) - dot(&of_force, &d_force);
    let backwards = dot(&to_jump[0], &d_jump) + to_begin[0].product(&d_begin);
    assert!(
        forwards != 0.0 && (backwards / forwards - 1.0).abs() < 1e-12,
        "{backwards} {forwards}"
    );
}

#[test]
fn forces_along_a_path_are_those_of_its_vertices_one_by_one() {
    // More points than stand together, of two laws; bins that close and open again, and points that slip.
    let operators = Arc::new(Operators::try_new(&patch(), 4).unwrap());
    let n = operators.n_points();
    let asperity = Asperity::try_new(ElasticPair::new(192e9, 0.3), 1.4e-3, None).unwrap();
    let law = |points: usize, friction: AsperityFriction| -> Arc<dyn TractionLaw> {
        let bins = AsperityBins::try_new(asperity, vec![0.0, 5e-7, 1e-6, 4e-6], vec![1e6; 4]).unwrap();
        let (bins, mu) = (
            PointParameters::uniform(bins, points),
            PointParameters::uniform(0.2, points),
        );
        Arc::new(ResolvedLaw::try_new(bins, mu, friction, Cone::Circle).unwrap())
    };
    let history = HistoryRule::Incremental;
    let laws = vec![
        (0..n / 3, law(n / 3, AsperityFriction::StickSlip(history))),
        (n / 3..n, law(n - n / 3, AsperityFriction::Annuli(history, 4))),
    ];
    let interface = Interface::try_new(operators, laws, vec![0.0; n]).unwrap();
    let mut random = numbers(3);
    let path: Vec<Vec<f64>> = [4e-7, 1.2e-6, 3e-7, 9e-7, -1e-7, 6e-7]
        .map(|normal| {
            (0..interface.n_dofs())
                .map(|i| 3e-7 * random() + if i % 3 == 2 { normal } else { 0.0 })
                .collect()
        })
        .into();
    let start = interface.initial_state();
    let found = interface.along_path(&path, Sticking::Coulomb, &start);
    let (mut begin, mut end) = (start.clone(), start);
    for (jump, found) in path.iter().zip(&found) {
        assert_eq!(*found, force_into(&interface, jump, &begin, &mut end));
        assert!(found.iter().any(|force| *force != 0.0));
        std::mem::swap(&mut begin, &mut end);
    }
}
