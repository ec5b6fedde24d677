//! The mesh against counts, closed forms and topology.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]
use brake_reuss_beam::geometry::{Geometry, equal_area_radius};
use brake_reuss_beam::mesh::{BrakeReussBeam, Refinement, build, half_beam, uniform_bar};
use brake_reuss_beam::{Error, published, quality};
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::mesh::{CouplingKind, Dof, Mesh};
use joint_model::benchmark::ElementOrder;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::f64::consts::{PI, SQRT_2};

const LOAD: f64 = published::BOLT_TENSION;

fn beam(refinement: &Refinement) -> BrakeReussBeam {
    build(
        &Geometry::default(),
        refinement,
        ElementOrder::Linear,
        &published::steel(),
        LOAD,
    )
    .unwrap()
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value} instead of {expected}"
    );
}

/// Least sine over the corners of the interface's quadrilaterals.
fn least_corner_sine(beam: &BrakeReussBeam) -> f64 {
    let mut least = 1.0_f64;
    for element in &beam.interface.elements {
        let points: Vec<_> = element
            .nodes()
            .iter()
            .map(|&n| beam.interface.nodes[n as usize])
            .collect();
        for k in 0..4 {
            let (o, a, b) = (points[k], points[(k + 1) % 4], points[(k + 3) % 4]);
            let (u, v) = ([a[0] - o[0], a[1] - o[1]], [b[0] - o[0], b[1] - o[1]]);
            least = least.min((u[0] * v[1] - u[1] * v[0]) / (u[0].hypot(u[1]) * v[0].hypot(v[1])));
        }
    }
    least
}

fn element_edges(mesh: &Mesh) -> impl Iterator<Item = f64> + '_ {
    const EDGES: [(usize, usize); 12] = [
        (0, 1),
        (1, 2),
        (2, 3),
        (3, 0),
        (4, 5),
        (5, 6),
        (6, 7),
        (7, 4),
        (0, 4),
        (1, 5),
        (2, 6),
        (3, 7),
    ];
    mesh.elements.iter().flat_map(move |element| {
        EDGES.iter().map(move |&(a, b)| {
            let [p, q] = [a, b].map(|local| mesh.nodes[element.cell.nodes()[local] as usize]);
            (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
        })
    })
}

#[test]
fn default_interface_has_588_quadrilaterals_and_692_nodes() {
    let refinement = Refinement::default();
    let beam = beam(&refinement);
    assert_eq!(beam.interface.elements.len(), 588);
    assert_eq!(beam.interface.nodes.len(), 692);
    assert_eq!(refinement.hole_ring(), 32);
    assert_eq!(refinement.interface_elements(), 588);
    beam.interface.validate().unwrap();
    close(least_corner_sine(&beam), 0.489, 2e-3);
    close(equal_area_radius(4.25e-3, 32, ElementOrder::Linear), 4.2637e-3, 1e-5);
}

#[test]
fn every_preset_has_the_expected_interface_and_no_inverted_element() {
    let expected = [148, 300, 588, 1196, 2352];
    for ((name, refinement), elements) in Refinement::presets(ElementOrder::Linear).into_iter().zip(expected) {
        let beam = beam(&refinement);
        let mesh = &beam.assembly.mesh;
        assert_eq!(beam.interface.elements.len(), elements, "{name}");
        assert_eq!(refinement.interface_elements(), elements, "{name}");
        assert!(least_corner_sine(&beam) > 0.45, "{name}");
        for element in &mesh.elements {
            assert!(quality::least_jacobian_determinant(mesh, element) > 0.0, "{name}");
            assert!(quality::scaled_jacobian(mesh, element) > 0.45, "{name}");
        }
        // Holes and circles keep their areas, so neither mass nor area depends on the refinement.
        close(quality::mass(mesh), 3.702, 1e-4);
        close(
            beam.interface.areas().iter().sum(),
            Geometry::default().interface_area(),
            1e-12,
        );
    }
    let quick = beam(&Refinement::quick());
    assert!((3000..6000).contains(&quick.assembly.mesh.nodes.len()));
    assert_eq!(Refinement::default().scaled(2.0).unwrap(), Refinement::finest());
}

#[test]
fn levels_of_quadratic_elements_have_the_washers_rings_and_grow_away_from_the_edges() {
    let geometry = Geometry::default();
    for ((name, refinement), elements) in Refinement::presets(ElementOrder::Quadratic)
        .into_iter()
        .zip([132, 184, 272, 828])
    {
        assert_eq!(refinement.interface_elements(), elements, "{name}");
        let beam = quadratic(&refinement);
        let mesh = &beam.assembly.mesh;
        assert_eq!(beam.interface.elements.len(), elements, "{name}");
        close(quality::volume(mesh, &mesh.elements), geometry.volume(), 1e-12);
        for element in &mesh.elements {
            assert!(quality::scaled_jacobian(mesh, element) > 0.43, "{name}");
        }

        // Washers are tied to nodes of the lap, but for those on the bore, which is wider than the hole, and the middles of edges
        // that begin there.
        let bore = 0.5 * geometry.washer_inner_diameter;
        let first_ring = bore + 0.51 / refinement.seat_rings as f64 * (geometry.across_flats / 3.0_f64.sqrt() - bore);
        for tie in &beam.assembly.ties {
            let place = |&node: &u32| mesh.nodes[node as usize];
            let masters: Vec<_> = tie
                .master_faces
                .iter()
                .flat_map(|face| face.nodes())
                .map(place)
                .collect();
            let (mut coincident, mut in_first_ring) = (0, 0);
            for at in tie.slave_nodes.iter().map(place) {
                let distance = |of: &[f64; 3]| (0..3).map(|c| (of[c] - at[c]).powi(2)).sum::<f64>().sqrt();
                let nearest = masters.iter().map(distance).fold(f64::INFINITY, f64::min);
                let from_hole = geometry.hole_positions().map(|hole| (at[0] - hole).hypot(at[1]));
                if from_hole.iter().any(|radius| *radius < first_ring) {
                    in_first_ring += 1;
                } else {
                    assert!(nearest < 1e-14, "{name}: {nearest}");
                    coincident += 1;
                }
            }
            assert_eq!(in_first_ring, 3 * refinement.sectors, "{name}");
            let rings = refinement.seat_rings + refinement.rim_rings;
            assert_eq!(coincident, (3 * rings - 1) * refinement.sectors, "{name}");
        }

        // Corners of elements on the line through the arm, the lap's end and its first column, at the edge of the interface.
        let corners = element_edges_at(mesh, |[_, y, z]| z == 0.0 && (y - 0.5 * geometry.width).abs() < 1e-12);
        let columns: Vec<f64> = (corners.iter().copied())
            .filter(|x| (-0.5 * geometry.lap_length..=-1.5 * geometry.hole_pitch + 1e-12).contains(x))
            .collect();
        assert_eq!(columns.len(), refinement.end + 1, "{name}");
        for three in columns.windows(3) {
            close(
                (three[2] - three[1]) / (three[1] - three[0]),
                refinement.end_growth,
                1e-9,
            );
        }
        let edge = corners.iter().position(|x| *x == columns[0]).unwrap();
        close(corners[edge] - corners[edge - 1], columns[1] - columns[0], 1e-9);
        let mut heights: Vec<f64> = (mesh.elements.iter())
            .flat_map(|element| &element.cell.nodes()[..8])
            .map(|&node| mesh.nodes[node as usize])
            .filter(|[x, _, z]| *x == -0.5 * geometry.length && *z >= 0.0)
            .map(|[.., z]| z)
            .collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        assert_eq!(heights.len(), refinement.layers + 1, "{name}");
        for three in heights.windows(3) {
            close(
                (three[2] - three[1]) / (three[1] - three[0]),
                refinement.layer_growth,
                1e-9,
            );
        }
    }
}

/// Positions along `x` of the elements' corners of which `wanted` is true, in order.
fn element_edges_at(mesh: &Mesh, wanted: impl Fn([f64; 3]) -> bool) -> Vec<f64> {
    let corners = mesh.elements.iter().flat_map(|element| &element.cell.nodes()[..8]);
    let places = corners.map(|&node| mesh.nodes[node as usize]).filter(|at| wanted(*at));
    let mut along: Vec<f64> = places.map(|[x, ..]| x).collect();
    along.sort_by(f64::total_cmp);
    along.dedup();
    along
}

#[test]
fn multiples_of_a_graded_mesh_divide_its_elements() {
    let unit = Refinement::graded_unit();
    let edges = |refinement: &Refinement| {
        let beam = quadratic(refinement);
        let mesh = &beam.assembly.mesh;
        let half_width = 0.5 * Geometry::default().width;
        element_edges_at(mesh, |[x, y, z]| {
            z == 0.0 && (y - half_width).abs() < 1e-12 && x.abs() < 0.06 + 1e-12
        })
    };
    let coarse = edges(&unit);
    for multiple in [2, 3] {
        let fine = edges(&unit.scaled(multiple as f64).unwrap());

        assert_eq!(fine.len() - 1, multiple * (coarse.len() - 1));
        for (k, x) in coarse.iter().enumerate() {
            assert!((fine[multiple * k] - x).abs() < 1e-15, "{x}");
        }
    }
}

#[test]
fn refinements_are_a_family() {
    // From `default` to `fine` and from there to `finest` all counts grow by the root of two as nearly as whole numbers can; a count
    // of one can only stay or double.
    let default = Refinement::default();
    for (refinement, factor) in [(Refinement::fine(), SQRT_2), (Refinement::finest(), 2.0)] {
        for ((name, count), (_, of_default)) in refinement.counts().into_iter().zip(default.counts()) {
            let wanted = factor * of_default as f64;
            let found = (count as f64 / wanted).ln().abs();
            let allowed = if of_default == 1 {
                0.5 * 2.0_f64.ln()
            } else {
                1.1_f64.ln()
            };
            assert!(found <= allowed + 1e-12, "{name}: {count} for {wanted:.2}");
            assert!(count > of_default, "{name} does not grow");
        }
    }
    // Multiples of one mesh need no rounding.
    let unit = Refinement::unit();
    for multiple in [2, 3, 4] {
        let scaled = unit.scaled(multiple as f64).unwrap();
        for ((name, count), (_, of_unit)) in scaled.counts().into_iter().zip(unit.counts()) {
            assert_eq!(count, multiple * of_unit, "{name}");
        }
        beam(&scaled).interface.validate().unwrap();
    }
}

#[test]
fn default_mesh_has_the_intended_size_and_mass() {
    let beam = beam(&Refinement::default());
    let mesh = &beam.assembly.mesh;
    assert_eq!((mesh.nodes.len(), mesh.elements.len()), (26_973, 20_488));
    let used: BTreeSet<u32> = mesh.elements.iter().flat_map(|e| e.cell.nodes()).copied().collect();
    assert_eq!(used.len(), mesh.nodes.len());
    let mass = quality::mass(mesh);
    close(mass, 3.70, 5e-3);
    close(mass, published::MODEL_MASS, 5e-4);
    let half = half_beam(&Geometry::default(), &Refinement::default(), &published::steel()).unwrap();
    // The independent model's holes are inscribed polygons, a little too small.
    close(quality::mass(&half), published::HALF_BEAM_MASS, 2e-4);
    let area = 0.120 * 0.0254 - 3.0 * std::f64::consts::PI * 0.0085_f64.powi(2) / 4.0;
    close(beam.interface.areas().iter().sum(), area, 1e-12);
}

#[test]
fn volumes_of_the_parts_equal_closed_forms() {
    let geometry = Geometry::default();
    for (name, refinement) in [("quick", Refinement::quick()), ("default", Refinement::default())] {
        let beam = beam(&refinement);
        let mesh = &beam.assembly.mesh;
        let mut covered = 0;
        for part in &beam.parts {
            assert_eq!(part.elements.start, covered, "{name}: {}", part.name);
            covered = part.elements.end;
            let expected = match part.name.trim_end_matches(|c: char| c == '_' || c.is_ascii_digit()) {
                "top_half_beam" | "bottom_half_beam" => geometry.half_beam_volume(),
                "shank" => geometry.shank_volume(),
                "head" => geometry.head_volume(),
                "nut" => geometry.nut_volume(),
                "head_washer" | "nut_washer" => geometry.washer_volume(),
                other => panic!("unknown part {other}"),
            };
            close(
                quality::volume(mesh, &mesh.elements[part.elements.clone()]),
                expected,
                1e-12,
            );
        }
        assert_eq!(covered, mesh.elements.len());
        assert_eq!(beam.parts.len(), 2 + 3 * 5);
        assert_eq!(beam.part("nut_2").unwrap().name, "nut_2");
        close(quality::volume(mesh, &mesh.elements), geometry.volume(), 1e-12);
    }
    // Hexagon of 12.7 mm across flats, by hand: 2 sqrt(3) 6.35^2 mm^2.
    close(geometry.head_volume(), 139.681_23e-6 * 5.159_375e-3, 1e-6);
}

/// Faces that belong to one element only, grouped by connected component.
fn boundary_faces(mesh: &Mesh) -> Vec<Vec<[u32; 4]>> {
    const FACES: [[usize; 4]; 6] = [
        [0, 3, 2, 1],
        [4, 5, 6, 7],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ];
    let mut seen: HashMap<[u32; 4], (usize, [u32; 4])> = HashMap::new();
    for element in &mesh.elements {
        for face in FACES {
            let face = face.map(|local| element.cell.nodes()[local]);
            let mut key = face;
            key.sort_unstable();
            seen.entry(key).or_insert((0, face)).0 += 1;
        }
    }
    let (component, count) = quality::connected_components(mesh);
    let mut faces = vec![Vec::new(); count];
    for (times, face) in seen.into_values() {
        match times {
            1 => faces[component[face[0] as usize]].push(face),
            2 => {}
            _ => panic!("face {face:?} belongs to {times} elements"),
        }
    }
    faces
}

#[test]
fn eight_bodies_have_closed_surfaces_of_the_right_genus() {
    for refinement in [Refinement::quick(), Refinement::default()] {
        let beam = beam(&refinement);
        let mut characteristics = Vec::new();
        for faces in boundary_faces(&beam.assembly.mesh) {
            let mut directed: BTreeSet<(u32, u32)> = BTreeSet::new();
            let mut nodes = BTreeSet::new();
            for face in &faces {
                for k in 0..4 {
                    nodes.insert(face[k]);
                    assert!(
                        directed.insert((face[k], face[(k + 1) % 4])),
                        "an edge is used twice in one direction"
                    );
                }
            }
            // Closed and consistently oriented: each edge is run along once in each direction.
            assert!(directed.iter().all(|&(a, b)| directed.contains(&(b, a))));
            characteristics.push(nodes.len() as i64 - directed.len() as i64 / 2 + faces.len() as i64);
        }
        characteristics.sort_unstable();
        // Half-beams with three holes; nuts with their washers are rings; bolts with their washers are plain bodies.
        assert_eq!(characteristics, [-4, -4, 0, 0, 0, 2, 2, 2]);
    }
}

/// Points in cells, to find the ones near a place.
struct Cells<'a> {
    points: &'a [[f64; 3]],
    size: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> Cells<'a> {
    fn new(points: &'a [[f64; 3]], size: f64) -> Self {
        let mut cells: HashMap<_, Vec<_>> = HashMap::new();
        for (index, point) in points.iter().enumerate() {
            cells
                .entry(point.map(|c| (c / size).round() as i64))
                .or_default()
                .push(index);
        }
        Self { points, size, cells }
    }

    fn within(&self, place: [f64; 3], distance: f64) -> Vec<usize> {
        assert!(distance < self.size);
        let home = place.map(|c| (c / self.size).round() as i64);
        let mut found = Vec::new();
        for shift in 0..27 {
            let cell = [
                home[0] + shift % 3 - 1,
                home[1] + shift / 3 % 3 - 1,
                home[2] + shift / 9 - 1,
            ];
            found.extend(
                self.cells
                    .get(&cell)
                    .into_iter()
                    .flatten()
                    .copied()
                    .filter(|&index| (0..3).all(|c| (self.points[index][c] - place[c]).abs() <= distance)),
            );
        }
        found
    }
}

#[test]
fn nodes_of_one_body_never_coincide() {
    let beam = beam(&Refinement::default());
    let mesh = &beam.assembly.mesh;
    let smallest_edge = element_edges(mesh).fold(f64::INFINITY, f64::min);
    let (component, _) = quality::connected_components(mesh);
    let cells = Cells::new(&mesh.nodes, smallest_edge);
    for (node, &place) in mesh.nodes.iter().enumerate() {
        for other in cells.within(place, 0.5 * smallest_edge) {
            assert!(
                other == node || component[other] != component[node],
                "nodes {node} and {other}"
            );
        }
    }
}

#[test]
fn mesh_is_symmetric_about_the_plane_y_0() {
    for refinement in [Refinement::quick(), Refinement::coarse(), Refinement::default()] {
        let beam = beam(&refinement);
        let nodes = &beam.assembly.mesh.nodes;
        let cells = Cells::new(nodes, 1e-5);
        for &[x, y, z] in nodes {
            let here = cells.within([x, y, z], 1e-12).len();
            assert_eq!(cells.within([x, -y, z], 1e-12).len(), here, "({x}, {y}, {z})");
        }
        let plane: Vec<_> = beam.interface.nodes.iter().map(|p| [p[0], p[1], 0.0]).collect();
        let cells = Cells::new(&plane, 1e-5);
        for &[x, y, _] in &plane {
            assert_eq!(cells.within([x, -y, 0.0], 1e-12).len(), 1);
            assert_eq!(cells.within([-x, y, 0.0], 1e-12).len(), 1);
        }
    }
}

#[test]
fn interface_nodes_pair_the_half_beams() {
    let beam = beam(&Refinement::default());
    let nodes = &beam.assembly.mesh.nodes;
    let (component, _) = quality::connected_components(&beam.assembly.mesh);
    assert_eq!(beam.top_nodes.len(), beam.interface.nodes.len());
    assert_eq!(beam.bottom_nodes.len(), beam.interface.nodes.len());
    let [top, bottom] = [beam.top_nodes[0], beam.bottom_nodes[0]].map(|n| component[n as usize]);
    assert_ne!(top, bottom);
    for (i, &[x, y]) in beam.interface.nodes.iter().enumerate() {
        let (t, b) = (beam.top_nodes[i] as usize, beam.bottom_nodes[i] as usize);
        assert_eq!((nodes[t], nodes[b]), ([x, y, 0.0], [x, y, 0.0]));
        assert_eq!((component[t], component[b]), (top, bottom));
    }
    // The normal leads from the top body's material into the bottom body's.
    let centre = |name: &str| {
        let elements = &beam.assembly.mesh.elements[beam.part(name).unwrap().elements.clone()];
        let lap: Vec<f64> = elements
            .iter()
            .flat_map(|e| e.cell.nodes().iter().map(|&n| nodes[n as usize]))
            .filter(|p| p[0].abs() < 0.05)
            .map(|p| p[2])
            .collect();
        lap.iter().sum::<f64>() / lap.len() as f64
    };
    let [along, across, normal] = beam.frame;
    assert_eq!((along, across), ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]));
    assert!(normal[2] * (centre("bottom_half_beam") - centre("top_half_beam")) > 0.0);
    // The response point: beam's end, middle of the upper edge, on the top half-beam.
    assert_eq!(nodes[beam.response_node as usize], [-0.36, 0.0, 0.0127]);
    assert_eq!(component[beam.response_node as usize], top);
    assert_eq!(beam.response_direction, [0.0, 0.0, 1.0]);
}

#[test]
fn half_beams_touch_at_the_interface_only() {
    // Coinciding nodes of the two half-beams outside of the interface would be a connection across the end gaps.
    let beam = beam(&Refinement::default());
    let mesh = &beam.assembly.mesh;
    let nodes_of = |name: &str| -> BTreeSet<u32> {
        mesh.elements[beam.part(name).unwrap().elements.clone()]
            .iter()
            .flat_map(|e| e.cell.nodes().to_vec())
            .collect()
    };
    let (top, bottom) = (nodes_of("top_half_beam"), nodes_of("bottom_half_beam"));
    assert!(top.is_disjoint(&bottom));
    let extent = |nodes: &BTreeSet<u32>, axis: usize| {
        let values = nodes.iter().map(|&n| mesh.nodes[n as usize][axis]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
    };
    assert_eq!(extent(&top, 0), (-0.36, 0.06));
    assert_eq!(extent(&bottom, 0), (-0.06, 0.36));
    assert_eq!(extent(&top, 2), (-0.0127, 0.0127));
}

#[test]
fn six_washers_are_tied_to_the_faces_they_lie_on() {
    for (name, refinement) in Refinement::presets(ElementOrder::Linear).into_iter().take(4) {
        let beam = beam(&refinement);
        let nodes = &beam.assembly.mesh.nodes;
        assert_eq!(beam.assembly.ties.len(), 6, "{name}");
        for tie in &beam.assembly.ties {
            let height = if tie.name.starts_with("head") { 0.0127 } else { -0.0127 };
            assert_eq!(tie.slave_nodes.len() % refinement.sectors, 0);
            let faces: Vec<_> = tie
                .master_faces
                .iter()
                .map(|face| {
                    let corners: [u32; 4] = face.nodes().try_into().unwrap();
                    corners.map(|n| nodes[n as usize])
                })
                .collect();
            for &slave in &tie.slave_nodes {
                let p = nodes[slave as usize];
                assert_eq!(p[2], height);
                // Inside of a master face, up to rounding of the cross products.
                let inside = faces.iter().any(|face| {
                    (0..4).all(|k| {
                        let (a, b) = (face[k], face[(k + 1) % 4]);
                        let cross = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                        cross * height.signum() >= -1e-16
                    })
                });
                assert!(inside, "{name}: {} slave {slave} at {p:?}", tie.name);
            }
            assert!(faces.iter().flatten().all(|p| p[2] == height));
            assert!(tie.position_tolerance < 1e-3 * element_edges(&beam.assembly.mesh).fold(1.0, f64::min));
        }
        let slaves: Vec<u32> = beam.assembly.ties.iter().flat_map(|t| t.slave_nodes.clone()).collect();
        let distinct: BTreeSet<_> = slaves.iter().collect();
        assert_eq!(distinct.len(), slaves.len());
    }
}

#[test]
fn couplings_hold_the_bore_and_the_shank_facing_it() {
    let geometry = Geometry::default();
    let beam = beam(&Refinement::default());
    let nodes = &beam.assembly.mesh.nodes;
    assert_eq!(beam.assembly.couplings.len(), 6);
    let radius = equal_area_radius(0.5 * geometry.shank_diameter, 24, ElementOrder::Linear);
    let (low, high) = (-19.446_875e-3, -14.2875e-3);
    for (index, coupling) in beam.assembly.couplings.iter().enumerate() {
        let x = geometry.hole_positions()[index / 2];
        assert_eq!(coupling.reference[..2], [x, 0.0]);
        close(coupling.reference[2], 0.5 * (low + high), 1e-14);
        assert_eq!(coupling.nodes.len(), 24 * 4);
        let CouplingKind::Distributing(weights) = &coupling.kind else {
            panic!("{coupling:?}")
        };
        assert_eq!(weights.len(), coupling.nodes.len());
        let total: f64 = weights.iter().sum();
        let mut centre = [0.0; 3];
        for (&node, &weight) in coupling.nodes.iter().zip(weights) {
            let p = nodes[node as usize];
            assert!(((p[0] - x).hypot(p[1]) - radius).abs() < 1e-12 * 1.0_f64.max(radius));
            assert!(p[2] > low - 1e-15 && p[2] < high + 1e-15);
            for c in 0..3 {
                centre[c] += weight * p[c] / total;
            }
        }
        for c in 0..3 {
            assert!(
                (centre[c] - coupling.reference[c]).abs() < 1e-15,
                "{} {centre:?}",
                coupling.name
            );
        }
    }
    // Shank and nut surfaces coincide but belong to different bodies.
    let (component, _) = quality::connected_components(&beam.assembly.mesh);
    for pair in beam.assembly.couplings.chunks(2) {
        assert_ne!(
            component[pair[0].nodes[0] as usize],
            component[pair[1].nodes[0] as usize]
        );
        assert!(pair[0].name.starts_with("shank") && pair[1].name.starts_with("nut"));
    }
}

#[test]
fn bolts_are_free_along_their_axis_only_and_pull_head_and_nut_together() {
    let beam = beam(&Refinement::quick());
    assert_eq!(beam.assembly.equations.len(), 15);
    let mut tied: BTreeMap<(u32, u32), Vec<u8>> = BTreeMap::new();
    for equation in &beam.assembly.equations {
        match equation.terms[..] {
            [(Dof::Reference(a, i), 1.0), (Dof::Reference(b, j), -1.0)] if i == j => {
                tied.entry((a, b)).or_default().push(i);
            }
            _ => panic!("{equation:?}"),
        }
    }
    let pairs: Vec<_> = tied.into_iter().collect();
    assert_eq!(
        pairs,
        [
            ((0, 1), vec![0, 1, 3, 4, 5]),
            ((2, 3), vec![0, 1, 3, 4, 5]),
            ((4, 5), vec![0, 1, 3, 4, 5])
        ]
    );
    let names: Vec<_> = beam.assembly.loads.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["bolt_load_1", "bolt_load_2", "bolt_load_3"]);
    for (bolt, load) in beam.assembly.loads.iter().enumerate() {
        let shank = 2 * bolt as u32;
        // The nut is below the beam: its force points up, the shank's down.
        assert_eq!(
            load.terms,
            [(Dof::Reference(shank, 2), -LOAD), (Dof::Reference(shank + 1, 2), LOAD)]
        );
    }
    let sum = beam.bolt_load_pattern();
    assert_eq!((sum.name.as_str(), sum.terms.len()), ("bolt_load", 6));
}

#[test]
fn arm_layers_grow_by_one_ratio_and_start_like_the_lap() {
    let mesh = half_beam(&Geometry::default(), &Refinement::default(), &published::steel()).unwrap();
    let mut stations: Vec<f64> = mesh
        .nodes
        .iter()
        .filter(|p| p[2] == -0.0127 && p[1] == 0.0)
        .map(|p| p[0])
        .collect();
    stations.sort_by(f64::total_cmp);
    assert_eq!(stations.len(), 51);
    assert_eq!((stations[0], stations[50]), (-0.36, -0.06));
    let steps: Vec<f64> = stations.windows(2).map(|w| w[1] - w[0]).rev().collect();
    close(steps[0], 2.5e-3, 1e-12);
    let ratio = steps[1] / steps[0];
    assert!((1.03..1.04).contains(&ratio), "{ratio}");
    for pair in steps.windows(2) {
        close(pair[1] / pair[0], ratio, 1e-9);
    }
}

#[test]
fn uniform_bar_is_a_brick() {
    let bar = uniform_bar(0.3, 0.02, 0.01, 30, 4, 2, &published::steel()).unwrap();
    assert_eq!((bar.nodes.len(), bar.elements.len()), (31 * 5 * 3, 240));
    close(quality::volume(&bar, &bar.elements), 0.3 * 0.02 * 0.01, 1e-13);
    assert_eq!(bar.nodes[0], [0.0, -0.01, -0.005]);
    assert_eq!(bar.nodes[(30 * 5 + 4) * 3 + 2], [0.3, 0.01, 0.005]);
    assert!(
        bar.elements
            .iter()
            .all(|e| quality::scaled_jacobian(&bar, e) > 1.0 - 1e-12)
    );
}

#[test]
fn results_scale_with_the_unit_of_length() {
    let metres = Geometry::default();
    let millimetres = scaled_geometry(1000.0);
    let in_metres = half_beam(&metres, &Refinement::quick(), &published::steel()).unwrap();
    let in_millimetres = half_beam(&millimetres, &Refinement::quick(), &published::steel()).unwrap();
    assert_eq!(in_metres.elements, in_millimetres.elements);
    for (a, b) in in_metres.nodes.iter().zip(&in_millimetres.nodes) {
        for c in 0..3 {
            assert!((1000.0 * a[c] - b[c]).abs() < 1e-12 * 720.0);
        }
    }
}

fn scaled_geometry(factor: f64) -> Geometry {
    let g = Geometry::default();
    Geometry {
        length: factor * g.length,
        width: factor * g.width,
        height: factor * g.height,
        lap_length: factor * g.lap_length,
        hole_diameter: factor * g.hole_diameter,
        hole_pitch: factor * g.hole_pitch,
        washer_inner_diameter: factor * g.washer_inner_diameter,
        washer_outer_diameter: factor * g.washer_outer_diameter,
        washer_thickness: factor * g.washer_thickness,
        shank_diameter: factor * g.shank_diameter,
        bolt_length: factor * g.bolt_length,
        across_flats: factor * g.across_flats,
        head_height: factor * g.head_height,
        nut_height: factor * g.nut_height,
        nut_bore_diameter: factor * g.nut_bore_diameter,
    }
}

#[test]
fn smaller_holes_of_the_paper_are_a_parameter() {
    let geometry = Geometry {
        hole_diameter: 21.0 / 64.0 * 0.0254,
        ..Geometry::default()
    };
    let beam = build(
        &geometry,
        &Refinement::default(),
        ElementOrder::Linear,
        &published::steel(),
        LOAD,
    )
    .unwrap();
    close(beam.interface.areas().iter().sum(), geometry.interface_area(), 1e-12);
    assert!(geometry.interface_area() > Geometry::default().interface_area());
}

#[test]
fn inadmissible_input_is_refused_by_name() {
    let steel = published::steel();
    let with =
        |geometry: &Geometry, refinement: &Refinement| build(geometry, refinement, ElementOrder::Linear, &steel, LOAD);
    let good = Geometry::default();
    let message = |geometry: Geometry| with(&geometry, &Refinement::quick()).unwrap_err().to_string();

    let text = message(Geometry {
        width: f64::NAN,
        ..good.clone()
    });
    assert!(text.contains("width") && text.contains("NaN"), "{text}");
    let text = message(Geometry {
        washer_thickness: 0.0,
        ..good.clone()
    });
    assert!(text.contains("washer_thickness"), "{text}");
    let text = message(Geometry {
        hole_diameter: 0.009,
        ..good.clone()
    });
    assert!(
        text.contains("hole_diameter") && text.contains("washer_inner_diameter"),
        "{text}"
    );
    let text = message(Geometry {
        bolt_length: 0.038,
        ..good.clone()
    });
    assert!(text.contains("bolt_length") && text.contains("0.0388"), "{text}");
    let text = message(Geometry {
        nut_bore_diameter: 0.007,
        ..good.clone()
    });
    assert!(text.contains("nut_bore_diameter"), "{text}");
    // Fits as drawn, but not as polygons of this refinement.
    let refinement = Refinement {
        sectors: 48,
        ..Refinement::quick()
    };
    let text = with(
        &Geometry {
            hole_diameter: 0.0087,
            ..good.clone()
        },
        &refinement,
    )
    .err()
    .unwrap()
    .to_string();
    assert!(text.contains("hole polygon radius"), "{text}");

    for refinement in [
        Refinement {
            across: 0,
            ..Refinement::default()
        },
        Refinement {
            across: 7,
            ..Refinement::default()
        },
        Refinement {
            sectors: 16,
            ..Refinement::default()
        },
        Refinement {
            layers: 1000,
            ..Refinement::default()
        },
        // A hole has 12 elements round it.
        Refinement {
            sectors: 24,
            ..Refinement::graded_unit()
        },
    ] {
        assert!(
            matches!(with(&good, &refinement), Err(Error::Count { .. })),
            "{refinement:?}"
        );
    }
    for growth in [0.5, 4.1, f64::NAN] {
        let refinement = Refinement {
            end_growth: growth,
            ..Refinement::graded_unit()
        };
        assert!(matches!(
            with(&good, &refinement),
            Err(Error::Value {
                field: "end_growth",
                ..
            })
        ));
    }
    // Washers that fit on the beam, but whose polygons are as wide as it is.
    let wide = Geometry {
        washer_outer_diameter: 0.02535,
        ..good.clone()
    };
    let text = with(&wide, &Refinement::graded_unit()).unwrap_err().to_string();
    assert!(
        text.contains("washer rim polygon radius") && text.contains("half width"),
        "{text}"
    );
    let refinement = Refinement {
        arm_layers: 5,
        ..Refinement::default()
    };
    assert!(matches!(
        with(&good, &refinement),
        Err(Error::Grading { layers: 5, .. })
    ));
    for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            Refinement::default().scaled(factor),
            Err(Error::Value { field: "factor", .. })
        ));
    }
    assert!(matches!(Refinement::default().scaled(1e300), Err(Error::Count { .. })));

    let quick = Refinement::quick();
    for load in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(matches!(
            build(&good, &quick, ElementOrder::Linear, &steel, load),
            Err(Error::Value {
                field: "bolt_tension",
                ..
            })
        ));
    }
    let mut liquid = steel.clone();
    liquid.poisson_ratio = 0.5;
    assert!(matches!(
        build(&good, &quick, ElementOrder::Linear, &liquid, LOAD),
        Err(Error::Material(_))
    ));
    assert!(matches!(
        uniform_bar(0.1, 0.0, 0.1, 1, 1, 1, &steel),
        Err(Error::Value { field: "width", .. })
    ));
    assert!(matches!(
        uniform_bar(0.1, 0.1, 0.1, 1, 0, 1, &steel),
        Err(Error::Count { field: "ny", .. })
    ));
}

#[test]
fn scaling_keeps_refinements_meshable() {
    for factor in [0.4, 0.5, 0.75, 1.0, 1.3, 1.5] {
        let refinement = Refinement::default().scaled(factor).unwrap();
        let beam = beam(&refinement);
        assert_eq!(beam.interface.elements.len(), refinement.interface_elements());
        close(quality::mass(&beam.assembly.mesh), 3.702, 1e-4);
    }
}

#[test]
fn the_half_has_the_mass_and_the_loads_of_the_whole() {
    for (name, refinement) in Refinement::presets(ElementOrder::Linear).into_iter().take(3) {
        let whole = beam(&refinement);
        let half = whole.half().unwrap();
        let [of_whole, of_half] = [&whole, &half].map(|beam| System::try_new(&beam.assembly).unwrap());
        close(of_half.total_mass, of_whole.total_mass, 1e-12);
        assert_eq!(2 * half.interface.elements.len(), whole.interface.elements.len());
        let area = |beam: &BrakeReussBeam| beam.interface.areas().iter().sum::<f64>();
        close(2.0 * area(&half), area(&whole), 1e-12);
        assert_eq!(
            half.parts.last().unwrap().elements.end,
            half.assembly.mesh.elements.len()
        );
        // Nodes of the interface are those of the mesh, and do not leave the plane where they are on it.
        for (i, &[x, y]) in half.interface.nodes.iter().enumerate() {
            for node in [half.top_nodes[i], half.bottom_nodes[i]] {
                let at = half.assembly.mesh.nodes[node as usize];
                assert_eq!((at[0], at[1] == 0.0), (x, y == 0.0));
                let across = of_half.dofs.row(3 * node as usize + 1).count();
                assert_eq!(across, usize::from(y > 0.0), "{name}");
            }
        }
    }
}

fn quadratic(refinement: &Refinement) -> BrakeReussBeam {
    let order = ElementOrder::Quadratic;
    build(&Geometry::default(), refinement, order, &published::steel(), LOAD).unwrap()
}

#[test]
fn parabolas_on_the_equal_area_radius_enclose_the_circle() {
    for edges in [12, 24, 32] {
        let h = PI / edges as f64;
        let radius = equal_area_radius(1.0, edges, ElementOrder::Quadratic);
        let area = |radius: f64| {
            // Triangle below the chord, and two thirds of chord times height between chord and parabola.
            let (sin, cos) = h.sin_cos();
            edges as f64 * radius * radius * (sin * cos + 4.0 / 3.0 * sin * (1.0 - cos))
        };
        close(area(radius), PI, 1e-14);
        // On the circle itself the area would be h^4/30 too small: 1.6e-4 at 12 edges, 9.8e-6 at 24.
        close(1.0 - area(1.0) / PI, h.powi(4) / 30.0, 2e-2);
        close(radius - 1.0, h.powi(4) / 60.0, 2e-2);
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_quadratic_meshes_have_round_holes_and_exact_volumes() {
    let geometry = Geometry::default();
    let on_linear_meshes = [("quick", Refinement::quick()), ("coarse", Refinement::coarse())];
    let levels = Refinement::presets(ElementOrder::Quadratic).into_iter().take(3);
    for (name, refinement) in levels.chain(on_linear_meshes) {
        let (linear, beam) = (beam(&refinement), quadratic(&refinement));
        let mesh = &beam.assembly.mesh;
        assert_eq!(mesh.elements.len(), linear.assembly.mesh.elements.len());
        assert!(mesh.elements.iter().all(|element| element.cell.nodes().len() == 20));
        let used: BTreeSet<u32> = mesh.elements.iter().flat_map(|e| e.cell.nodes()).copied().collect();
        assert_eq!(used.len(), mesh.nodes.len());
        for (element, of_linear) in mesh.elements.iter().zip(&linear.assembly.mesh.elements) {
            assert!(quality::least_jacobian_determinant(mesh, element) > 0.0, "{name}");
            assert_eq!(element.cell.nodes()[..8], *of_linear.cell.nodes());
        }
        close(quality::volume(mesh, &mesh.elements), geometry.volume(), 1e-12);
        close(beam.interface.areas().iter().sum(), geometry.interface_area(), 1e-12);
        beam.interface.validate().unwrap();

        // All nodes on the edges of holes, middles too, lie on one radius.
        let radius = equal_area_radius(
            0.5 * geometry.hole_diameter,
            refinement.hole_ring(),
            ElementOrder::Quadratic,
        );
        for hole in geometry.hole_positions() {
            let from_hole = |p: &&[f64; 2]| (p[0] - hole).hypot(p[1]) < radius * (1.0 + 1e-3);
            let on_edge: Vec<_> = beam.interface.nodes.iter().filter(from_hole).collect();
            assert_eq!(on_edge.len(), 2 * refinement.hole_ring());
            on_edge
                .iter()
                .for_each(|p| close((p[0] - hole).hypot(p[1]), radius, 1e-12));
        }

        // Pairs face one another, elements of the interface are faces of both half-beams.
        assert_eq!(beam.interface.elements.len(), refinement.interface_elements());
        let place = |node: u32| mesh.nodes[node as usize];
        for (pair, &[x, y]) in beam.interface.nodes.iter().enumerate() {
            assert_eq!(
                (place(beam.top_nodes[pair]), place(beam.bottom_nodes[pair])),
                ([x, y, 0.0], [x, y, 0.0])
            );
        }
        let faces: HashSet<Vec<u32>> = (mesh.elements.iter().flat_map(|element| element.cell.faces()))
            .map(|face| {
                let mut nodes = face.nodes().to_vec();
                nodes.sort_unstable();
                nodes
            })
            .collect();
        for element in &beam.interface.elements {
            for side in [&beam.top_nodes, &beam.bottom_nodes] {
                let mut nodes: Vec<u32> = element.nodes().iter().map(|&node| side[node as usize]).collect();
                nodes.sort_unstable();
                assert!(nodes.len() == 8 && faces.contains(&nodes), "{name}");
            }
        }

        // Couplings hold on to the middles of the cylinders they face; the reference point is the centroid.
        for coupling in &beam.assembly.couplings {
            let CouplingKind::Distributing(weights) = &coupling.kind else {
                panic!("distributing");
            };
            let total: f64 = weights.iter().sum();
            close(total, (refinement.sectors * refinement.head_layers) as f64, 1e-9);
            for c in 0..3 {
                let mean = coupling
                    .nodes
                    .iter()
                    .zip(weights)
                    .map(|(&n, w)| place(n)[c] * w)
                    .sum::<f64>()
                    / total;
                assert!(
                    (mean - coupling.reference[c]).abs() < 1e-12,
                    "{}: {mean}",
                    coupling.name
                );
            }
        }
        let system = System::try_new(&beam.assembly).unwrap();
        close(system.total_mass, quality::mass(mesh), 1e-9);
        assert!(system.dofs.largest_adjustment < 1e-12);
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_half_of_a_quadratic_beam_has_the_loads_and_mass_of_the_whole() {
    let whole = quadratic(&Refinement::quick());
    let half = whole.half().unwrap();
    half.interface.validate().unwrap();
    assert!(half.interface.elements.iter().all(|element| element.nodes().len() == 8));
    close(
        2.0 * half.interface.areas().iter().sum::<f64>(),
        whole.interface.areas().iter().sum(),
        1e-12,
    );
    let [of_half, of_whole] = [&half, &whole].map(|beam| System::try_new(&beam.assembly).unwrap());
    close(of_half.total_mass, of_whole.total_mass, 1e-12);
    assert!(of_half.n_dofs() < of_whole.n_dofs() * 55 / 100);
    let modes = |system: &System, n| {
        let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, n, 1e-8).unwrap();
        (modes.n_zero, modes.frequencies())
    };
    let ((zero_half, half), (zero_whole, whole)) = (modes(&of_half, 2), modes(&of_whole, 10));
    assert!(zero_half < zero_whole);
    for frequency in half {
        let nearest = whole
            .iter()
            .map(|f| (f / frequency - 1.0).abs())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-7, "{frequency} {whole:?}");
    }
}
