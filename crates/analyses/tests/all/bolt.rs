//! Bolts of described size: tables, torque and compliance against printed values, seats in meshes, and a modelled solid bolt.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use faer::Mat;
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::elements::Formulation;
use finite_elements::factor::SparseCholesky;
use finite_elements::mesh::{Assembly, Cell, Coupling, CouplingKind, Dof, Element, LoadPattern, Material, Mesh};
use joints::structure::bolt::{Bolt, BoltGeometry, Compliance, Engagement, HeadContact};
use nalgebra::{Rotation3, Vector3};
use scenes::metric::{Friction, Metric};
use std::collections::HashMap;
use std::f64::consts::PI;

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs(),
        "found {found}, expected {expected}: off by {:.2e}",
        (found / expected - 1.0).abs()
    );
}

fn steel() -> Material {
    Material {
        name: "steel".into(),
        youngs_modulus: 205e9,
        poisson_ratio: 0.3,
        density: 7850.0,
    }
}

#[test]
fn sizes_are_found_by_name() {
    // Stress areas of ISO 898-1 (mm^2).
    for (name, area) in [
        ("M3", 5.03),
        ("M8", 36.6),
        ("M10", 58.0),
        ("M16", 157.0),
        ("M39", 976.0),
        ("M8x1", 39.2),
        ("M10x1.25", 61.2),
    ] {
        let size = Metric::from_name(name).unwrap();
        close(1e6 * size.thread.stress_area(), area, 3e-3);
        assert!(
            size.hole > size.thread.diameter && size.washer.outer > size.face && size.face < size.head.across_flats
        );
    }
    assert_eq!(Metric::from_name("m10 X 1.25").unwrap().thread.pitch, 1.25e-3);
    for (name, said) in [
        ("M11", "M10, M12"),
        ("10", "M3"),
        ("M10x2", "coarse"),
        ("M10x1x1", "nothing"),
        ("M10xx", "0.2"),
        ("Mnan", "M3"),
    ] {
        let message = Metric::from_name(name).unwrap_err().to_string();
        assert!(message.contains(said), "{message}");
    }
}

/// Preload (kN) and torque (N m) of property class 8.8 with both coefficients of friction 0.12 at 90 % of the yield strength, as printed by
/// manufacturers from VDI 2230 in its editions since 2001.
#[test]
fn preload_and_torque_are_those_of_vdi_2230() {
    let friction = Friction {
        thread: 0.12,
        head: 0.12,
    };
    for (name, yield_strength, preload, torque) in [
        ("M10", 640e6, 29.6, 48.0),
        ("M8x1", 640e6, 20.2, 26.1),
        ("M10x1.25", 640e6, 31.6, 51.0),
        ("M12x1.25", 640e6, 48.0, 90.0),
        ("M16x1.5", 640e6, 87.6, 218.0),
        ("M20x1.5", 660e6, 148.0, 454.0),
        ("M24x2", 660e6, 209.0, 769.0),
    ] {
        let size = Metric::from_name(name).unwrap();
        let found = size.thread.assembly_preload(yield_strength, 0.9, friction.thread);
        let bearing = [size.hole, size.face];
        let moment = size.thread.torque(found, friction, bearing);
        println!("{name}: {:.2} kN ({preload}), {moment:.1} N m ({torque})", 1e-3 * found);
        close(found, 1e3 * preload, 5e-3);
        close(moment, torque, 1.5e-2);
        close(size.thread.preload(moment, friction, bearing), found, 1e-14);
    }
}

#[test]
fn compliance_is_the_sum_of_its_parts() {
    let thread = Metric::from_name("M10").unwrap().thread;
    let e = 205e9;
    let found = Compliance::new(&thread, 0.03, 0.012, e, Engagement::Nut(e));
    let area = |d: f64| PI / 4.0 * d * d;
    let core = 8.159_695e-3;
    let expected = (0.005 + 0.012 + 0.004) / (e * area(0.01)) + (0.018 + 0.005) / (e * area(core));
    close(found.axial(), expected, 1e-12);
    let second = |d: f64| PI / 64.0 * d.powi(4);
    let expected = (0.005 + 0.012 + 0.004) / (e * second(0.01)) + (0.018 + 0.005) / (e * second(core));
    close(found.bending(), expected, 1e-12);
    assert_eq!(found.terms.len(), 5);
    let tapped = Compliance::new(&thread, 0.03, 0.0, e, Engagement::TappedHole(70e9));
    assert_eq!(tapped.terms.len(), 4);
    close(tapped.terms[3].axial(), 0.0033 / (70e9 * area(0.01)), 1e-12);
}

/// Rings of hexahedra around the z axis, with wedges where they reach it.
struct Rings {
    mesh: Mesh,
    known: HashMap<(u32, [i64; 3]), u32>,
}

const SECTORS: usize = 24;

impl Rings {
    fn new() -> Self {
        Self {
            mesh: Mesh {
                materials: vec![steel()],
                ..Mesh::default()
            },
            known: HashMap::new(),
        }
    }

    /// The node at a place; nodes of different bodies are different. `body` is asked for the radius and height.
    fn node(&mut self, body: &dyn Fn(f64, f64) -> u32, r: f64, sector: usize, z: f64) -> u32 {
        let (sin, cos) = (2.0 * PI * sector as f64 / SECTORS as f64).sin_cos();
        let at = [r * cos, r * sin, z];
        let key = (body(r, z), at.map(|x| (1e9 * x).round() as i64));
        *self.known.entry(key).or_insert_with(|| {
            self.mesh.nodes.push(at);
            self.mesh.nodes.len() as u32 - 1
        })
    }

    fn add(&mut self, body: &dyn Fn(f64, f64) -> u32, radii: &[f64], heights: &[f64]) {
        for r in radii.windows(2) {
            for z in heights.windows(2) {
                for sector in 0..SECTORS {
                    let mut layer = |z: f64| {
                        let mut at = |r: f64, s: usize| self.node(body, r, s, z);
                        match r[0] {
                            0.0 => vec![at(0.0, 0), at(r[1], sector), at(r[1], sector + 1)],
                            _ => vec![
                                at(r[0], sector),
                                at(r[1], sector),
                                at(r[1], sector + 1),
                                at(r[0], sector + 1),
                            ],
                        }
                    };
                    let nodes = [layer(z[0]), layer(z[1])].concat();
                    let cell = match nodes[..] {
                        [a, b, c, d, e, f] => Cell::wedge6([a, b, c, d, e, f]),
                        [a, b, c, d, e, f, g, h] => {
                            Cell::hex8([a, b, c, d, e, f, g, h], Formulation::IncompatibleModes)
                        }
                        _ => unreachable!(),
                    };
                    self.mesh.elements.push(Element { cell, material: 0 });
                }
            }
        }
    }
}

fn steps(from: f64, to: f64, n: usize) -> Vec<f64> {
    (0..=n).map(|i| from + (to - from) * i as f64 / n as f64).collect()
}

const HOLE: f64 = 5.5e-3;
const FACE: f64 = 7.315e-3;
const THICKNESS: f64 = 10e-3;

/// Two discs with a hole for M10, one above the other, that share their nodes up to the radius `joined` and touch nowhere else. The
/// head is to be below.
fn discs(joined: f64) -> Rings {
    let mut rings = Rings::new();
    let radii = [HOLE, 6.4e-3, FACE, 8.5e-3, 10e-3, 14e-3, 19e-3, 25e-3];
    let body = |upper: u32| move |r: f64, z: f64| if z.abs() < 1e-9 && r < joined { 0 } else { upper };
    rings.add(&body(0), &radii, &steps(-THICKNESS, 0.0, 5));
    rings.add(&body(1), &radii, &steps(0.0, THICKNESS, 5));
    rings
}

fn described() -> BoltGeometry {
    let size = Metric::from_name("M10").unwrap();
    let axis = [[0.0, 0.0, -0.1], [0.0, 0.0, 0.3]];
    BoltGeometry {
        unthreaded: Some(2.0 * THICKNESS),
        ..BoltGeometry::metric("M10", &size, axis, false, steel())
    }
}

#[test]
fn seats_are_found_wherever_the_model_stands() {
    let mut mesh = discs(0.0).mesh;
    let mut geometry = described();
    let boundary = mesh.boundary();
    let bolt = Bolt::try_new(&mesh.nodes, &boundary, &geometry).unwrap();
    let facts = &bolt.facts;
    close(facts.clamped, 2.0 * THICKNESS, 1e-12);
    assert_eq!(facts.clamped, facts.grip);
    for (seat, coupling) in facts.seats.iter().zip(&bolt.couplings) {
        // Three rings of nodes.
        assert_eq!((seat.nodes, coupling.nodes.len()), (3 * SECTORS, 3 * SECTORS));
        // A polygon covers sin(a) / a of its circle.
        close(seat.covered, 0.99, 0.02);
        assert!(seat.tilt < 1e-6);
    }
    assert!((bolt.couplings[0].reference[2] + THICKNESS).abs() < 1e-15);
    assert!((bolt.couplings[1].reference[2] - THICKNESS).abs() < 1e-15);
    // Head and nut as prisms, the shank without thread.
    let hexagon = 0.75_f64.sqrt() * 0.016 * 0.016;
    close(
        facts.mass,
        7850.0 * (hexagon * (6.4e-3 + 8.4e-3) + PI / 4.0 * 1e-4 * 0.02),
        1e-12,
    );

    // The same points of the axis in the other order: head above.
    geometry.axis.reverse();
    let reversed = Bolt::try_new(&mesh.nodes, &boundary, &geometry).unwrap();
    assert_eq!(reversed.couplings[0].nodes, bolt.couplings[1].nodes);
    geometry.axis.reverse();

    let rotation = Rotation3::from_euler_angles(0.4, 1.3, -0.7);
    let moved = |x: [f64; 3]| -> [f64; 3] { (rotation * Vector3::from(x) + Vector3::new(0.3, -2.0, 0.1)).into() };
    mesh.nodes.iter_mut().for_each(|x| *x = moved(*x));
    geometry.axis = geometry.axis.map(moved);
    geometry.contact = HeadContact::Distributing;
    let turned = Bolt::try_new(&mesh.nodes, &boundary, &geometry).unwrap();
    assert_eq!(turned.couplings[0].nodes, bolt.couplings[0].nodes);
    close(turned.facts.grip, facts.grip, 1e-12);
    close(turned.shank.axial, bolt.shank.axial, 1e-12);
    let CouplingKind::Distributing(weights) = &turned.couplings[0].kind else {
        panic!("a seat that does not distribute");
    };
    close(weights.iter().sum(), PI * (FACE * FACE - HOLE * HOLE), 0.02);

    // Washers move the points at which head and nut bear, and add their mass.
    let size = Metric::from_name("M10").unwrap();
    let washers = BoltGeometry::metric("M10", &size, geometry.axis, true, steel());
    let with = Bolt::try_new(&mesh.nodes, &boundary, &washers).unwrap();
    close(with.facts.grip, 2.0 * THICKNESS + 4e-3, 1e-12);
    assert!(with.facts.mass > bolt.facts.mass && with.couplings[0].nodes.len() > 3 * SECTORS);
}

#[test]
fn what_is_no_seat_is_refused_with_its_measure() {
    let mesh = discs(0.0).mesh;
    let boundary = mesh.boundary();
    let refused = |change: &dyn Fn(&mut BoltGeometry)| {
        let mut geometry = described();
        change(&mut geometry);
        Bolt::try_new(&mesh.nodes, &boundary, &geometry)
            .unwrap_err()
            .to_string()
    };
    let far = refused(&|g| g.axis = [[0.3, 0.0, 0.0], [0.3, 0.0, 1.0]]);
    assert!(
        far.contains("under the head") && far.contains("nearest") && far.contains("2.7203e-1"),
        "{far}"
    );
    let tilted = refused(&|g| g.axis = [[0.0, 0.0, 0.0], [0.0, 0.3, 1.0]]);
    assert!(tilted.contains("16.7 degrees"), "{tilted}");
    let coarse = refused(&|g| {
        for seat in &mut g.seats {
            (seat.inner, seat.outer) = (2.0 * 11e-3, 2.0 * 13e-3);
        }
    });
    assert!(
        coarse.contains("0 nodes") && coarse.contains("1.0e-3 m or less"),
        "{coarse}"
    );
    assert!(refused(&|g| g.axis[1] = g.axis[0]).contains("no axis"));
    assert!(refused(&|g| g.axis[1][2] = f64::NAN).contains("no axis"));
    assert!(refused(&|g| g.seats[1].outer = 0.001).contains("under the nut"));
    assert!(refused(&|g| g.unthreaded = Some(0.05)).contains("5.0000e-2 m long"));
    assert!(refused(&|g| g.thread.pitch = 0.02).contains("no thread"));
    assert!(refused(&|g| g.material.density = f64::NAN).contains("density"));
}

/// A bolt of nominal diameter in elements, head and nut as cylinders of the face's diameter, glued to the discs if they have nodes there.
fn add_solid_bolt(rings: &mut Rings) {
    let z = THICKNESS;
    let own = |r: f64, z: f64| match r > 0.99 * HOLE {
        true if (z + THICKNESS).abs() < 1e-9 => 0,
        true if (z - THICKNESS).abs() < 1e-9 => 1,
        _ => 9,
    };
    let shank = [0.0, 2.5e-3, 5e-3];
    let head = [0.0, 2.5e-3, 5e-3, HOLE, 6.4e-3, FACE];
    rings.add(&own, &head, &steps(-z - 6.4e-3, -z, 4));
    rings.add(&own, &shank, &steps(-z, z, 10));
    rings.add(&own, &head, &steps(z, z + 8.4e-3, 5));
}

fn frequencies(assembly: &Assembly, n: usize) -> Vec<f64> {
    let system = System::try_new(assembly).unwrap();
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, n, 1e-8).unwrap();
    assert_eq!(modes.n_zero, 6);
    modes.frequencies()
}

/// Elongation between the faces under head and nut of a solid bolt alone, for uniform pressure there (m/N).
fn solid_compliance() -> f64 {
    let mut rings = Rings::new();
    add_solid_bolt(&mut rings);
    let mesh = rings.mesh;
    let boundary = mesh.boundary();
    let coupling = |height: f64| {
        let mut weights: HashMap<u32, f64> = HashMap::new();
        for face in &boundary {
            let on_seat = |&n: &u32| {
                let [x, y, z] = mesh.nodes[n as usize];
                (z - height).abs() < 1e-9 && x.hypot(y) > 0.99 * HOLE
            };
            if face.nodes().iter().all(on_seat) {
                for (node, area) in face.areas(&mesh.nodes) {
                    *weights.entry(node).or_default() += area;
                }
            }
        }
        let (nodes, weights) = weights.into_iter().unzip();
        Coupling {
            name: "face".into(),
            reference: [0.0, 0.0, height],
            nodes,
            kind: CouplingKind::Distributing(weights),
        }
    };
    let assembly = Assembly {
        couplings: vec![coupling(-THICKNESS), coupling(THICKNESS)],
        supports: (0..6).map(|c| Dof::Reference(0, c)).collect(),
        loads: vec![LoadPattern {
            name: "pull".into(),
            terms: vec![(Dof::Reference(1, 2), 1.0)],
        }],
        mesh,
        ..Assembly::default()
    };
    let system = System::try_new(&assembly).unwrap();
    let factor = SparseCholesky::try_new(&system.stiffness, &system.positions, "stiffness").unwrap();
    let load = &system.loads[0];
    let mut u = Mat::from_fn(load.len(), 1, |i, _| load[i]);
    factor.solve_in_place(u.as_mut());
    load.iter().enumerate().map(|(i, f)| f * u[(i, 0)]).sum()
}

/// A description without what a cylinder lacks: the compliance of the engaged thread.
fn without_thread(mut bolt: Bolt) -> Bolt {
    let compliance = &mut bolt.facts.compliance;
    compliance.terms.retain(|term| term.part != "engaged thread");
    bolt.shank.axial = 1.0 / compliance.axial();
    bolt.shank.bending = [bolt.facts.grip / compliance.bending(); 2];
    bolt.shank.torsion = bolt.shank.bending[0] / (1.0 + steel().poisson_ratio);
    bolt
}

#[test]
fn a_described_bolt_is_close_to_a_solid_one() {
    let solid = solid_compliance();
    let mesh = discs(0.0).mesh;
    let described_bolt = Bolt::try_new(&mesh.nodes, &mesh.boundary(), &described()).unwrap();
    let whole = described_bolt.facts.compliance.axial();
    let cylinder = without_thread(described_bolt).facts.compliance.axial();
    println!("compliance (m/N): solid {solid:.4e}, VDI 2230 {whole:.4e}, without the thread's {cylinder:.4e}");
    close(cylinder, solid, 0.03);
    for joined in [0.0, 12e-3] {
        let mut rings = discs(joined);
        add_solid_bolt(&mut rings);
        let modelled = Assembly {
            mesh: rings.mesh,
            ..Assembly::default()
        };
        let expected = frequencies(&modelled, 8);
        println!("joined up to {joined} m: solid {expected:.1?} Hz");
        let mut off = Vec::new();
        for (contact, thread) in [
            (HeadContact::Tied, true),
            (HeadContact::Tied, false),
            (HeadContact::Distributing, false),
        ] {
            let mut assembly = Assembly {
                mesh: discs(joined).mesh,
                ..Assembly::default()
            };
            let geometry = BoltGeometry { contact, ..described() };
            let bolt = Bolt::try_new(&assembly.mesh.nodes, &assembly.mesh.boundary(), &geometry).unwrap();
            let bolt = if thread { bolt } else { without_thread(bolt) };
            bolt.join(&mut assembly);
            // What the structure weighs before it is assembled is what its matrix holds.
            let solids = assembly.mesh.elements.iter().map(|element| {
                let material = &assembly.mesh.materials[usize::from(element.material)];
                material.density * element.cell.volume(&assembly.mesh.nodes)
            });
            let weighed = solids.sum::<f64>() + assembly.mass_at_references().unwrap();
            close(weighed, System::try_new(&assembly).unwrap().total_mass, 1e-12);
            assert_eq!(assembly.rigid_motions().unwrap(), 6);
            assembly.supports = vec![Dof::Pretension(0)];
            let found = frequencies(&assembly, 8);
            let of_all = found.iter().zip(&expected).map(|(f, e)| 100.0 * (f / e - 1.0));
            off.push(of_all.collect::<Vec<f64>>());
            println!(
                "{contact:?}, thread {thread}: {found:.1?} Hz, off by {:.2?} %",
                off[off.len() - 1]
            );
        }
        // Where contact holds the discs together the bolt matters less, and the solid one lies between rigid seats and soft ones.
        let bound = if joined > 0.0 { 8.5 } else { 12.0 };
        assert!(off[1..].iter().flatten().all(|off| off.abs() < bound), "{off:?}");
        assert!(joined == 0.0 || (off[1][0] > 0.0 && off[2][0] < 0.0), "{off:?}");
    }
}
