//! Mode shapes of a straight bar of two layers that lie upon one another over its whole length.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::beam;
use finite_elements::elements::Formulation;
use finite_elements::mesh::{Assembly, Cell, Element, Material, Mesh};
use joint_model::fit::Fit;
use joint_model::{Bodies, Joint, MeshedBodies, Sides};
use joints::progress::Silent;
use joints::structure::{Contact, LinearInterface, ModalModel, ModesOfContact, Structure};
use std::f64::consts::PI;
use zte_assembly::InterfaceMesh;

/// Length, width and height of the bar (m).
const SIZE: [f64; 3] = [0.6, 0.03, 0.02];
/// Elements along them in each of the two layers.
const N: [u32; 3] = [40, 6, 3];
const YOUNGS_MODULUS: f64 = 200e9;
const DENSITY: f64 = 7800.0;
const POISSON: f64 = 0.3;

/// The bar, whose sections are turned about its long axis by an angle (rad), along an axis of the model.
fn bar(along: usize, angle: f64) -> Structure {
    let place = |[x, y, z]: [f64; 3]| {
        let local = [x, y * angle.cos() - z * angle.sin(), y * angle.sin() + z * angle.cos()];
        let mut at = [0.0; 3];
        for c in 0..3 {
            at[(along + c) % 3] = local[c];
        }
        at
    };
    let mut mesh = Mesh {
        materials: vec![Material {
            name: "steel".into(),
            youngs_modulus: YOUNGS_MODULUS,
            poisson_ratio: POISSON,
            density: DENSITY,
        }],
        ..Mesh::default()
    };
    let number = |layer: u32, i: u32, j: u32, k: u32| {
        layer * (N[0] + 1) * (N[1] + 1) * (N[2] + 1) + i + (N[0] + 1) * (j + (N[1] + 1) * k)
    };
    for layer in 0..2 {
        let bottom = if layer == 0 { -0.5 * SIZE[2] } else { 0.0 };
        for k in 0..=N[2] {
            for j in 0..=N[1] {
                for i in 0..=N[0] {
                    let part = |c: usize, index: u32| SIZE[c] * f64::from(index) / f64::from(N[c]);
                    mesh.nodes
                        .push(place([part(0, i), part(1, j), bottom + 0.5 * part(2, k)]));
                }
            }
        }
        for k in 0..N[2] {
            for j in 0..N[1] {
                for i in 0..N[0] {
                    let ring =
                        |k| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| number(layer, i, j, k));
                    let nodes: Vec<u32> = ring(k).into_iter().chain(ring(k + 1)).collect();
                    let cell = Cell::hex8(nodes.try_into().unwrap(), Formulation::IncompatibleModes);
                    mesh.elements.push(Element { cell, material: 0 });
                }
            }
        }
    }
    let side = |layer: u32, k: u32| -> Vec<u32> {
        (0..=N[1])
            .flat_map(|j| (0..=N[0]).map(move |i| (i, j)))
            .map(|(i, j)| number(layer, i, j, k))
            .collect()
    };
    let axis = |local: [f64; 3]| place(local);
    let frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]].map(axis);
    let plane = |i: u32, j: u32| {
        [
            SIZE[0] * f64::from(i) / f64::from(N[0]),
            SIZE[1] * f64::from(j) / f64::from(N[1]),
        ]
    };
    let nodes = (0..=N[1]).flat_map(|j| (0..=N[0]).map(move |i| plane(i, j))).collect();
    let elements = (0..N[1]).flat_map(|j| {
        (0..N[0]).map(move |i| {
            let at = |i: u32, j: u32| i + (N[0] + 1) * j;
            zte_assembly::Element::quad4([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
        })
    });
    let bodies = MeshedBodies {
        assembly: Assembly {
            mesh,
            ..Assembly::default()
        },
        sides: Sides::Pairs {
            top: side(1, 0),
            bottom: side(0, N[2]),
        },
        response_node: 0,
        response_direction: [1.0, 0.0, 0.0],
        excitations: Vec::new(),
        moved_pairs: None,
        raised: None,
        rigid_motions: 6,
    };
    let joint = Joint {
        positions: Some(bodies.interface_positions()),
        bodies: Bodies::Meshed(bodies),
        interface: InterfaceMesh::flat(nodes, elements.collect()),
        frame,
        node_frames: Vec::new(),
        parts: Vec::new(),
        clearance: None,
        response: "a corner".into(),
        fit: Fit::default(),
    };
    let scene = beam("bar");
    Structure::from_joint(&scene.model, scene.bolts.behaviour, joint)
}

fn modes(structure: &Structure) -> ModalModel {
    structure.modes(13, None, None, &Silent).unwrap()
}

fn of(model: &ModalModel, contact: Contact) -> &ModesOfContact {
    model.contacts.iter().find(|modes| modes.contact == contact).unwrap()
}

/// Frequencies of a free bar (Hz): bending of a thin one about the axis of radius of gyration `radius`, by number.
fn bending(radius: f64, number: usize) -> f64 {
    let roots = [4.730_041, 7.853_205, 10.995_608, 14.137_165];
    (roots[number] / SIZE[0]).powi(2) * (YOUNGS_MODULUS / DENSITY).sqrt() * radius / (2.0 * PI)
}

#[test]
fn modes_of_a_straight_bar_have_the_names_and_frequencies_of_beam_theory() {
    let model = modes(&bar(0, 0.0));
    let stuck = of(&model, Contact::Stuck);
    assert_eq!(stuck.zero_energy_modes, 6);
    let [_, width, height] = SIZE;
    let (about_y, about_z) = (height / 12_f64.sqrt(), width / 12_f64.sqrt());
    // Torsion constant of a rectangle of sides 3:2.
    let torsion = 0.1958 * width * height.powi(3);
    let polar = width * height * (width * width + height * height) / 12.0;
    let shear = YOUNGS_MODULUS / (2.0 * (1.0 + POISSON));
    let expected = [
        ("first bending about y", bending(about_y, 0), 0.01),
        ("first bending about z", bending(about_z, 0), 0.01),
        ("second bending about y", bending(about_y, 1), 0.02),
        // Shear and the inertia of rotation lower higher modes.
        ("second bending about z", bending(about_z, 1), 0.03),
        ("third bending about y", bending(about_y, 2), 0.03),
        (
            "first torsion about x",
            (shear / DENSITY * torsion / polar).sqrt() / (2.0 * SIZE[0]),
            0.02,
        ),
        (
            "first axial motion along x",
            (YOUNGS_MODULUS / DENSITY).sqrt() / (2.0 * SIZE[0]),
            0.01,
        ),
    ];
    for (name, frequency, tolerance) in expected {
        let found = stuck.modes.iter().find(|mode| mode.name.starts_with(name));
        let names: Vec<_> = stuck.modes.iter().map(|m| (m.frequency_hz, &m.name)).collect();
        let found = found.unwrap_or_else(|| panic!("no {name} in {names:?}"));
        let error = found.frequency_hz / frequency - 1.0;
        assert!(
            error.abs() < tolerance,
            "{name}: {} instead of {frequency}",
            found.frequency_hz
        );
        let share = found.name.split_once('(').unwrap().1.split_once(' ').unwrap().0;
        assert!(share.parse::<f64>().unwrap() >= 97.0, "{}", found.name);
    }
    let first = &stuck.modes[0];
    // A free body's elastic modes have neither momentum nor angular momentum.
    assert!(first.effective_mass.iter().all(|m| *m < 1e-6 * model.mass), "{first:?}");
    assert!((model.mass / (DENSITY * SIZE.iter().product::<f64>()) - 1.0).abs() < 1e-9);
}

#[test]
fn modes_are_orthonormal_and_alike_where_contacts_are() {
    let structure = bar(0, 0.0);
    let stiff = LinearInterface {
        normal_stiffness: 1e17,
        tangential_stiffness: 1e17,
        points_per_direction: 2,
    };
    let model = structure.modes(6, Some(stiff), None, &Silent).unwrap();
    for contact in &model.contacts {
        assert!(contact.orthonormality_error < 1e-8, "{contact:?}");
        assert!(contact.residual < 1e-6, "{contact:?}");
    }
    // A very stiff interface is a stuck one.
    let pair = model
        .assurance
        .iter()
        .find(|pair| (pair.rows, pair.columns) == (Contact::Stuck, Contact::Linear));
    for (i, row) in pair.unwrap().values.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let expected = f64::from(u8::from(i == j));
            assert!((value - expected).abs() < 1e-3, "{i} {j}: {value}");
        }
    }
    let (stuck, linear) = (of(&model, Contact::Stuck), of(&model, Contact::Linear));
    assert!(
        stuck
            .modes
            .iter()
            .all(|mode| mode.jump == 0.0 && mode.interface_energy.is_none())
    );
    assert!(linear.modes.iter().all(|mode| mode.interface_energy.unwrap() < 0.01));
    // Two layers that only touch are softer in bending about y, and slide against each other.
    let unstressed = of(&model, Contact::Unstressed);
    assert_eq!(unstressed.zero_energy_modes, 12);
    assert!(unstressed.modes[0].frequency_hz < 0.55 * stuck.modes[0].frequency_hz);
}

#[test]
fn energy_in_the_interface_is_what_the_frequency_owes_to_it() {
    let structure = bar(0, 0.0);
    let linear = |stiffness: f64| LinearInterface {
        normal_stiffness: stiffness,
        tangential_stiffness: stiffness,
        points_per_direction: 2,
    };
    let at = |stiffness: f64| structure.modes(3, Some(linear(stiffness)), None, &Silent).unwrap();
    let (base, step) = (2e11, 1e-3);
    let (low, middle, high) = (at(base * (1.0 - step)), at(base), at(base * (1.0 + step)));
    for mode in 0..3 {
        let w2 = |model: &ModalModel| of(model, Contact::Linear).modes[mode].frequency_hz.powi(2);
        // d ln(omega^2) / d ln(k), by the derivative of an eigenvalue.
        let slope = (w2(&high) / w2(&low)).ln() / ((1.0 + step) / (1.0 - step)).ln();
        let share = of(&middle, Contact::Linear).modes[mode].interface_energy.unwrap();
        assert!(
            (share - slope).abs() < 1e-4 * slope.max(1e-2),
            "{mode}: {share} {slope}"
        );
    }
    let energies: Vec<f64> = of(&middle, Contact::Linear)
        .modes
        .iter()
        .map(|mode| mode.interface_energy.unwrap())
        .collect();
    let order = &middle.joint_moved_most_by;
    assert!(
        order
            .windows(2)
            .all(|pair| energies[pair[0] - 1] >= energies[pair[1] - 1]),
        "{order:?}"
    );
}

#[test]
fn names_follow_a_bar_that_lies_otherwise() {
    let names = |structure: Structure| -> Vec<String> {
        let model = modes(&structure);
        of(&model, Contact::Stuck)
            .modes
            .iter()
            .map(|mode| mode.name.clone())
            .collect()
    };
    // The long axis is z; y and z of the bar are x and y of the model.
    let turned = names(bar(2, 0.0));
    assert!(turned[0].starts_with("first bending about x"), "{turned:?}");
    assert!(turned[1].starts_with("first bending about y"), "{turned:?}");
    let oblique = names(bar(0, 0.5));
    assert!(
        oblique[0].starts_with("first bending about (0.00, 0.88, 0.48)"),
        "{oblique:?}"
    );
}
