//! Decks: every keyword, every kind of defect, and the way back.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use finite_elements::assemble::System;
use finite_elements::elements::{Formulation, HEX8, HEX20, HEX27, TET10, WEDGE15};
use finite_elements::formats::abaqus::{self, Choices, Deck, DeckModel, Includes, Members};
use finite_elements::mesh::{
    Assembly, BeyondTolerance, Cell, Coupling, CouplingKind, Dof, Element, Equation, Face, GroundSpring, Group,
    LoadPattern, Material, Mesh, PointMass, Tie,
};
use finite_elements::{DeckProblem, Error};

/// Two stacked unit cubes (0-1 and 1-2 along z) with separate nodes 1-8 and 11-18, without steps.
const CUBES: &str = "\
*HEADING
Anything, even * stars, may stand here
** a comment
*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
11, 0., 0., 1.
12, 1., 0., 1.
13, 1., 1., 1.
14, 0., 1., 1.
15, 0., 0., 2.
16, 1., 0., 2.
17, 1., 1., 2.
18, 0., 1., 2.
100, 0.5, 0.5, 2.5
101, 9., 9., 9.
*ELEMENT, TYPE=C3D8, ELSET=LOWER
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8I, ELSET=UPPER
2, 11, 12, 13, 14,
   15, 16, 17, 18
*ELSET, ELSET=BODY
LOWER, UPPER
*SURFACE, NAME=BOTTOM
LOWER, S2
*SURFACE, NAME=TOP
2, S1
*SURFACE, NAME=HEAD
2, S2
*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL
,
*MATERIAL, NAME=Steel
*ELASTIC
2.D11, 0.3
*DENSITY
7800.,
*TIE, NAME=GLUE
TOP, BOTTOM
*COUPLING, CONSTRAINT NAME=HOOK, REF NODE=100, SURFACE=HEAD
*DISTRIBUTING
";

fn parse(text: &str) -> Result<Deck, Error> {
    abaqus::parse(text, "cubes.inp")
}

fn model(text: &str) -> Result<DeckModel, Error> {
    parse(text)?.assembly(&Choices::default())
}

/// Number of the first line of `text` that holds `part`.
fn line_of(text: &str, part: &str) -> u32 {
    text.lines().position(|line| line.contains(part)).unwrap() as u32 + 1
}

/// `CUBES` with one passage exchanged, or a passage added behind it.
fn with(old: &str, new: &str) -> String {
    assert!(CUBES.contains(old), "{old}");
    CUBES.replacen(old, new, 1)
}

/// Asserts that the error stands at the line that holds `part`, and that its message names `said`.
fn assert_defect(text: &str, part: &str, said: &[&str]) {
    let error = model(text).expect_err(part);
    let Error::Deck { file, line, .. } = &error else {
        panic!("{part}: {error}")
    };
    assert_eq!((file.as_str(), *line), ("cubes.inp", line_of(text, part)), "{error}");
    for said in said {
        assert!(error.to_string().contains(said), "`{said}` is not in `{error}`");
    }
}

#[test]
fn a_flat_deck_becomes_an_assembly() {
    let deck = parse(CUBES).unwrap();
    assert_eq!(deck.node_sets["ALL"].len(), 18);
    assert_eq!(deck.element_sets["BODY"], [0, 1]);
    assert_eq!(deck.ignored.len(), 1);
    assert_eq!(
        (deck.ignored[0].keyword.as_str(), deck.ignored[0].first_line.number),
        ("HEADING", 1)
    );
    let model = deck.assembly(&Choices::default()).unwrap();
    let assembly = &model.assembly;
    assert_eq!(assembly.mesh.nodes.len(), 16);
    assert!(
        model.notes.iter().any(|note| note.starts_with("1 nodes belong")),
        "{:?}",
        model.notes
    );
    let formulations: Vec<Formulation> = assembly
        .mesh
        .elements
        .iter()
        .map(|element| {
            assert_eq!(element.cell.element_type(), &HEX8);
            element.cell.formulation()
        })
        .collect();
    assert_eq!(formulations, [Formulation::BBar, Formulation::IncompatibleModes]);
    assert_eq!(assembly.mesh.materials[0].youngs_modulus, 2e11);
    // 5 % of the unit edge.
    assert_eq!(assembly.ties[0].position_tolerance, 0.05);
    assert!(assembly.ties[0].adjust);
    assert_eq!(assembly.ties[0].beyond, BeyondTolerance::LeaveFree);
    assert_eq!(model.surface_faces("bottom").unwrap(), [Face::quad4([4, 5, 6, 7])]);
    assert_eq!(model.node("18").unwrap(), 15);
    assert_eq!(model.node_name(15), "18");
    assert_eq!(model.element_name(1), "2");
    assert_eq!(model.reference("100").unwrap(), 0);
    assert!(matches!(&assembly.couplings[0].kind, CouplingKind::Distributing(w)
        if w.iter().all(|w| (w - 0.25).abs() < 1e-15)));
    let error = model.surface_faces("SIDE").unwrap_err().to_string();
    assert!(error.contains("SIDE") && error.contains("BOTTOM"), "{error}");
    assert!(model.node("101").is_err() && model.node("x.1").is_err());
    let system = System::try_new(assembly).unwrap();
    assert!((system.total_mass - 15_600.0).abs() < 1e-8);
    let dense = system.stiffness.to_dense();
    let n = system.n_dofs();
    let values = dense_algebra::symmetric_eigenvalues(faer::Mat::from_fn(n, n, |i, j| dense[[i, j]]).as_ref()).unwrap();
    let zero = values.iter().filter(|v| v.abs() < 1e-10 * values[n - 1]).count();
    assert_eq!((n, zero), (36, 6));
}

#[test]
fn choices_prevail_over_the_deck() {
    let text = with("NAME=GLUE", "NAME=GLUE, POSITION TOLERANCE=0.3, ADJUST=NO");
    let deck = parse(&text).unwrap();
    let plain = deck.assembly(&Choices::default()).unwrap().assembly;
    assert_eq!((plain.ties[0].position_tolerance, plain.ties[0].adjust), (0.3, false));
    let material = Material {
        name: "brass".into(),
        youngs_modulus: 1e11,
        poisson_ratio: 0.35,
        density: 8500.0,
    };
    let chosen = deck
        .assembly(&Choices {
            formulation: Some(Formulation::Full),
            material: Some(material.clone()),
            tie_tolerance: Some(0.7),
            beyond: BeyondTolerance::Refuse,
        })
        .unwrap()
        .assembly;
    assert_eq!(chosen.mesh.materials, [material]);
    assert!(
        chosen
            .mesh
            .elements
            .iter()
            .all(|e| e.cell.element_type() == &HEX8 && e.cell.formulation() == Formulation::Full)
    );
    assert_eq!(chosen.ties[0].position_tolerance, 0.7);
    assert_eq!(chosen.ties[0].beyond, BeyondTolerance::Refuse);
}

#[test]
fn spelling_does_not_matter() {
    let plain = model(CUBES).unwrap().assembly;
    let odd = CUBES
        .to_lowercase()
        .replace("*solid section", "* Solid  SECTION")
        .replace("ref node=100", "\n ref node = 100")
        .replace("name=glue", "name=\"glue\"")
        .replace("\n1, 0., 0., 0.", "\n  1 ,0,,-0.e0 ,\n\n** in between")
        .replace('\n', "\r\n");
    let found = model(&odd).unwrap().assembly;
    assert_eq!(found.mesh.nodes, plain.mesh.nodes);
    assert_eq!(found.mesh.elements, plain.mesh.elements);
    assert_eq!(found.couplings[0].nodes, plain.couplings[0].nodes);
    assert_eq!(found.ties[0].master_faces, plain.ties[0].master_faces);
}

#[test]
fn local_systems_and_curvilinear_coordinates_become_global() {
    let text = "\
*SYSTEM
1., 2., 3., 1., 3., 3.
1., 2., 4.
*NODE
1, 1., 0., 0.
2, 0., 1., 0.
3, 0., 0., 1.
*SYSTEM
1., 2., 3., 1., 7., 9.
*NODE
4, 1., 0., 0.
5, 0., 0., 1.
*SYSTEM
10., 0., 0.
*NODE
6, 1., 1., 1.
*SYSTEM
*NODE, SYSTEM=C
7, 2., 90., 5.
*NODE, SYSTEM=S
8, 2., 90., 30.
";
    let deck = parse(text).unwrap();
    let root = 3.0_f64.sqrt();
    let expected = [
        [1.0, 3.0, 3.0],
        [1.0, 2.0, 4.0],
        [2.0, 2.0, 3.0],
        [1.0, 3.0, 3.0],
        [1.0, 2.0, 4.0],
        [11.0, 1.0, 1.0],
        [0.0, 2.0, 5.0],
        [0.0, root, 1.0],
    ];
    for (node, expected) in deck.nodes.iter().zip(expected) {
        for i in 0..3 {
            assert!((node.at[i] - expected[i]).abs() < 1e-14, "{node:?} {expected:?}");
        }
    }
    for bad in [
        "*SYSTEM\n0.,0.,0.,0.,0.,1.\n",
        "*SYSTEM\n0,0,0,1,0,0\n2,0,0\n",
        "*SYSTEM\n0,0,0,1,0,0\n0,0,0\n",
    ] {
        let error = parse(bad).unwrap_err();
        assert!(error.to_string().contains("span a plane"), "{bad}: {error}");
    }
}

const PARTS: &str = "\
*PART, NAME=CUBE
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*ELEMENT, TYPE=C3D8R, ELSET=E
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=LOW, GENERATE
1, 4
*SURFACE, NAME=UP
E, S2
*SOLID SECTION, ELSET=E, MATERIAL=M
*END PART
*PART, NAME=IDLE
*NODE
1, 0., 0., 0.
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=First, PART=CUBE
*END INSTANCE
*INSTANCE, NAME=Second, PART=CUBE
3., 0., 0.
3., 0., 0., 3., 0., 1., 90.
*END INSTANCE
*NODE
1, 0.5, 0.5, 3.
*NSET, NSET=REF
1
*NSET, NSET=ENDS, INSTANCE=Second
LOW, 8
*NSET, NSET=MIXED
First.LOW, Second.8
*COUPLING, CONSTRAINT NAME=C, REF NODE=REF, SURFACE=First.UP
*KINEMATIC
1, 2
*END ASSEMBLY
*MATERIAL, NAME=M
*ELASTIC
1., 0.
*DENSITY
1.
*BOUNDARY
A.Second.LOW, PINNED
ENDS, 3, 6
*STEP, NAME=Pull
*STATIC
*CLOAD
First.7, 3, 2.5
MIXED, 1, 1.
REF, 6, 4.
*END STEP
";

#[test]
fn instances_are_moved_then_turned_and_their_names_qualified() {
    let deck = parse(PARTS).unwrap();
    assert_eq!(deck.instances, ["", "FIRST", "SECOND"]);
    let model = deck.assembly(&Choices::default()).unwrap();
    let at = |name: &str| model.assembly.mesh.nodes[model.node(name).unwrap() as usize];
    assert_eq!(at("First.7"), [1.0, 1.0, 1.0]);
    let turned = at("second.2");
    for (found, expected) in turned.iter().zip([3.0, 1.0, 0.0]) {
        assert!((found - expected).abs() < 1e-15, "{turned:?}");
    }
    assert_eq!(model.node_set("ENDS").unwrap(), [8, 9, 10, 11, 15]);
    assert_eq!(model.node_set("mixed").unwrap(), [0, 1, 2, 3, 15]);
    assert_eq!(model.node_set("First.low").unwrap(), [0, 1, 2, 3]);
    assert_eq!(model.reference("ref").unwrap(), 0);
    assert_eq!(
        model.assembly.couplings[0].kind,
        CouplingKind::Kinematic([true, true, false])
    );
    // PINNED on four, component 3 on node 8; rotations are noted.
    assert_eq!(model.assembly.supports.len(), 13);
    assert!(
        model
            .notes
            .iter()
            .any(|note| note.starts_with("15 supports of rotations")),
        "{:?}",
        model.notes
    );
    assert!(
        model.notes.iter().any(|note| note.contains("part `IDLE`")),
        "{:?}",
        model.notes
    );
    let pull = &model.assembly.loads[model.load("pull").unwrap()];
    assert!(pull.terms.contains(&(Dof::Node(6, 2), 2.5)));
    assert!(pull.terms.contains(&(Dof::Reference(0, 5), 4.0)));
    assert_eq!(pull.terms.len(), 7);
    assert_eq!(deck.steps[0].procedures[0].keyword, "STATIC");
}

#[test]
fn sets_grow_nest_and_keep_their_order_only_if_told() {
    let text = format!(
        "{CUBES}*NSET, NSET=A\n4, 2\n*NSET, NSET=A\n1, 2\n*NSET, NSET=B, UNSORTED\n7, 3, A, 7\n\
         *NSET, NSET=C, GENERATE\n11, 17, 3\n*NSET, NSET=D, ELSET=UPPER\n*ELSET, ELSET=L, GENERATE\n1, 2, 1\n"
    );
    let deck = parse(&text).unwrap();
    let labels = |name: &str| -> Vec<u32> {
        let set = deck.node_sets[name].iter();
        set.map(|&node| deck.nodes[node as usize].label.number).collect()
    };
    assert_eq!(labels("A"), [1, 2, 4]);
    assert_eq!(labels("B"), [7, 3, 1, 2, 4]);
    assert_eq!(labels("C"), [11, 14, 17]);
    assert_eq!(labels("D"), [11, 12, 13, 14, 15, 16, 17, 18]);
    assert_eq!(deck.element_sets["L"], [0, 1]);
}

#[test]
fn equations_and_links_become_constraints() {
    let text = format!(
        "{CUBES}*NODE\n200, 0.5, 0.5, -1.\n201, 0.5, 0.5, -2.\n*NSET, NSET=P\n1, 2\n*NSET, NSET=Q\n3, 4\n\
         *EQUATION\n2\nP, 1, 1.\nQ, 1, -1.\n3\n1, 2, 1., 2, 2, 1., 100, 3, -2.\n\
         *MPC\nBEAM, 3, 200\nBEAM, 4, 200\nBEAM, 201, 200\n"
    );
    // 201 belongs to nothing.
    let error = model(&text).unwrap_err().to_string();
    assert!(error.contains("node 201 has no component 1"), "{error}");
    let text = text.replace("BEAM, 201, 200\n", "PIN, 100, 200\nLINK, 1, 16\nTIE, 2, 17\n");
    let model = model(&text).unwrap();
    let equations = &model.assembly.equations;
    assert_eq!(equations.len(), 3 + 3 + 1 + 3);
    assert_eq!(
        equations[0].terms,
        [(Dof::Reference(0, 0), 1.0), (Dof::Reference(1, 0), -1.0)]
    );
    assert_eq!(equations[6].terms, [(Dof::Node(1, 2), 1.0), (Dof::Node(14, 2), -1.0)]);
    assert_eq!(equations[8].terms, [(Dof::Node(1, 0), 1.0), (Dof::Node(3, 0), -1.0)]);
    let mean = [
        (Dof::Node(0, 1), 1.0),
        (Dof::Node(1, 1), 1.0),
        (Dof::Reference(0, 2), -2.0),
    ];
    assert_eq!(equations[9].terms, mean);
    // From (0, 0, 0) to (1, 0, 2).
    let along = [-1.0, 0.0, -2.0].map(|v| v / 5.0_f64.sqrt());
    let expected = [
        (Dof::Node(0, 0), along[0]),
        (Dof::Node(13, 0), -along[0]),
        (Dof::Node(0, 2), along[2]),
        (Dof::Node(13, 2), -along[2]),
    ];
    for (found, expected) in equations[3].terms.iter().zip(expected) {
        assert_eq!(found.0, expected.0);
        assert!((found.1 - expected.1).abs() < 1e-15);
    }
    assert_eq!(model.assembly.couplings[1].kind, CouplingKind::Kinematic([true; 3]));
    assert_eq!(model.assembly.couplings[1].nodes, [2, 3]);
    assert_eq!(
        equations[9].name,
        format!("equation at cubes.inp:{}", line_of(&text, "Q, 1, -1.") + 1)
    );
}

#[test]
fn a_beam_to_a_couplings_reference_turns_with_it() {
    // Rigid rotation must satisfy every equation.
    let text = format!("{CUBES}*MPC\nBEAM, 1, 100\n");
    let assembly = model(&text).unwrap().assembly;
    let theta = [0.3, -0.7, 0.2];
    let cross = |x: [f64; 3]| {
        [
            theta[1] * x[2] - theta[2] * x[1],
            theta[2] * x[0] - theta[0] * x[2],
            theta[0] * x[1] - theta[1] * x[0],
        ]
    };
    assert_eq!(assembly.equations.len(), 3);
    for equation in &assembly.equations {
        let sum: f64 = equation
            .terms
            .iter()
            .map(|&(dof, coefficient)| {
                coefficient
                    * match dof {
                        Dof::Node(node, c) => cross(assembly.mesh.nodes[node as usize])[c as usize],
                        Dof::Reference(i, c) if c < 3 => cross(assembly.couplings[i as usize].reference)[c as usize],
                        Dof::Reference(_, c) => theta[c as usize - 3],
                        Dof::Pretension(_) => unreachable!(),
                    }
            })
            .sum();
        assert!(sum.abs() < 1e-14, "{equation:?}");
    }
}

#[test]
fn older_couplings_and_springs_are_read() {
    let text = format!(
        "{CUBES}*NODE\n200, 0.5, 0.5, -1.\n201, 0.5, 0.5, -2.\n*ELEMENT, TYPE=DCOUP3D, ELSET=D\n900, 200\n\
         *NSET, NSET=BASE, GENERATE\n1, 4\n*DISTRIBUTING COUPLING, ELSET=D\nBASE, 2.\n\
         *KINEMATIC COUPLING, REF NODE=201\nBASE, 1, 2\n\
         *ELEMENT, TYPE=SPRING1, ELSET=S\n901, 5\n902, 6\n*SPRING, ELSET=S\n3\n1.5D3\n"
    );
    let assembly = model(&text).unwrap().assembly;
    assert_eq!(assembly.couplings[1].kind, CouplingKind::Distributing(vec![2.0; 4]));
    assert_eq!(assembly.couplings[2].kind, CouplingKind::Kinematic([true, true, false]));
    let springs: Vec<_> = assembly
        .springs
        .iter()
        .map(|s| (s.node, s.component, s.stiffness))
        .collect();
    assert_eq!(springs, [(4, 2, 1500.0), (5, 2, 1500.0)]);
    assert_defect(
        &text.replace("*SPRING, ELSET=S\n3\n1.5D3\n", ""),
        "901, 5",
        &["901", "*SPRING"],
    );
}

#[test]
fn masses_at_nodes_are_read() {
    let text = format!(
        "{CUBES}*ELEMENT, TYPE=MASS, ELSET=M\n901, 5\n902, 6\n*MASS, ELSET=M\n8.D-4\n\
         *ELEMENT, TYPE=MASS\n903, 7\n*ELSET, ELSET=ONE\n903\n*MASS, ELSET=ONE\n0.625\n"
    );
    let mut assembly = model(&text).unwrap().assembly;
    let masses: Vec<_> = assembly.masses.iter().map(|m| (m.node, m.mass)).collect();
    assert_eq!(masses, [(4, 8e-4), (5, 8e-4), (6, 0.625)]);
    // Grams and millimetres.
    assembly.convert_units(1e-3, 1e-3);
    assert_eq!(assembly.masses[2].mass, 6.25e-4);
    let bare = model(CUBES).unwrap().assembly;
    let mass = |assembly: &Assembly| System::try_new(assembly).unwrap().total_mass;
    assembly = model(&text).unwrap().assembly;
    assert!((mass(&assembly) - mass(&bare) - 0.6266).abs() < 1e-12 * mass(&bare));
    assert_defect(
        &text.replace("*MASS, ELSET=ONE\n0.625\n", ""),
        "903, 7",
        &["903", "*MASS"],
    );
    assert_defect(&text.replace("0.625", "-0.625"), "-0.625", &["mass", "positive"]);
    assert_defect(
        &text.replace("*MASS, ELSET=ONE", "*MASS, ELSET=m"),
        "*MASS, ELSET=m",
        &["property of element", "901"],
    );
    assert_defect(
        &text.replace("903, 7", "903, 101"),
        "*MASS, ELSET=ONE",
        &["101", "no element"],
    );
    // At the reference node of a coupling it moves with the mean of the cloud.
    assembly = model(&text.replace("903, 7", "903, 100")).unwrap().assembly;
    assert_eq!((assembly.masses.len(), assembly.rigid_masses.len()), (2, 1));
    assert_eq!(
        (assembly.rigid_masses[0].coupling, assembly.rigid_masses[0].mass),
        (0, 0.625)
    );
    assert!((mass(&assembly) - mass(&bare) - 0.6266).abs() < 1e-12 * mass(&bare));
}

#[test]
fn steps_keep_their_supports_and_give_load_patterns() {
    let text = format!(
        "{CUBES}*STEP\n*FREQUENCY\n10\n*BOUNDARY\n1, ENCASTRE\n*NODE PRINT, NSET=ALL\nU\n*END STEP\n\
         *STEP, NAME=S\n*SUBSTRUCTURE GENERATE, TYPE=Z1\n*SUBSTRUCTURE LOAD CASE, NAME=L1\n*CLOAD\n100, 3, 1.\n\
         *SUBSTRUCTURE LOAD CASE, NAME=L2\n*CLOAD\n100, 4, 2.\n*END STEP\n"
    );
    let model = model(&text).unwrap();
    assert!(model.assembly.supports.is_empty());
    let names: Vec<&str> = model.assembly.loads.iter().map(|load| load.name.as_str()).collect();
    assert_eq!(names, ["S/L1", "S/L2"]);
    assert_eq!(model.assembly.loads[1].terms, [(Dof::Reference(0, 3), 2.0)]);
    assert_eq!(model.load("s/l2").unwrap(), 1);
    assert_eq!(model.step_supports[0].0, "Step-1");
    assert_eq!(
        model.step_supports[0].1,
        [Dof::Node(0, 0), Dof::Node(0, 1), Dof::Node(0, 2)]
    );
    assert!(model.ignored.iter().any(|i| i.keyword == "NODE PRINT"));
}

#[test]
fn contact_and_loads_that_the_scene_replaces_are_listed() {
    let contact = "*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n*FRICTION\n0.2\n\
                   *CONTACT PAIR, INTERACTION=I\nTOP, BOTTOM\n*CONTACT PAIR, INTERACTION=I\nA, B\n\
                   *AMPLITUDE, NAME=RAMP\n0,0,1,1\n*TIE";
    let text = with("*TIE", contact) + "*STEP\n*STATIC\n*DLOAD\nALL, P1, 2.\n*END STEP\n";
    let (with_contact, without) = (parse(&text).unwrap(), parse(CUBES).unwrap());
    assert_eq!(with_contact.elements, without.elements);
    for said in [
        "*CONTACT PAIR does not act: faces touch where the scene says so, by its law, and nowhere else",
        "*DLOAD does not act: steps are not run",
        "*AMPLITUDE does not act",
    ] {
        let count = with_contact.notes.iter().filter(|note| note.starts_with(said)).count();
        assert_eq!(count, 1, "{said}: {:?}", with_contact.notes);
    }
    let pairs = with_contact
        .ignored
        .iter()
        .find(|ignored| ignored.keyword == "CONTACT PAIR");
    assert_eq!(pairs.unwrap().count, 2);
}

#[test]
fn couplings_that_share_a_reference_node_move_it_together() {
    let text = format!("{CUBES}*COUPLING, CONSTRAINT NAME=TWO, REF NODE=100, SURFACE=BOTTOM\n*DISTRIBUTING\n");
    let assembly = model(&text).unwrap().assembly;
    assert_eq!((assembly.couplings.len(), assembly.equations.len()), (2, 6));
    assert_eq!(
        assembly.equations[5].terms,
        [(Dof::Reference(1, 5), 1.0), (Dof::Reference(0, 5), -1.0)]
    );
}

#[test]
fn loads_and_supports_of_kinematic_reference_nodes_are_assembled() {
    let nodes = "*NODE\n200, 0.5, 0.5, -1.\n*NSET, NSET=BASE, GENERATE\n1, 4\n";
    let step = "*STEP, NAME=S\n*STATIC\n*CLOAD\n200, 3, 2.\n*END STEP\n";
    for coupling in [
        "*SURFACE, NAME=BASE, TYPE=NODE\nBASE\n*COUPLING, CONSTRAINT NAME=K, REF NODE=200, SURFACE=BASE\n*KINEMATIC\n",
        "*KINEMATIC COUPLING, REF NODE=200\nBASE, 1, 3\n",
        "*MPC\nBEAM, 1, 200\nBEAM, 2, 200\nBEAM, 3, 200\nBEAM, 4, 200\n",
    ] {
        for support in [
            "",
            "*BOUNDARY\n200, 1, 2\n",
            "*BOUNDARY\n200, 3\n",
            "*BOUNDARY\n200, 1, 6\n",
        ] {
            let text = format!("{CUBES}{nodes}{coupling}{support}{step}");
            let assembly = model(&text).unwrap().assembly;
            let system = System::try_new(&assembly).unwrap();
            let load = system.loads[0].iter().map(|f| f.abs()).sum::<f64>();
            let held = ["\n200, 3\n", "1, 6"].iter().any(|part| support.contains(part));
            assert_eq!(load, if held { 0.0 } else { 2.0 }, "{coupling}{support}");
        }
    }
}

#[test]
fn weights_are_tributary_areas() {
    // A wedge with one triangular face of area 1/2 and a face of area 1.
    let text = "\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
5, 1., 0., 1.
6, 0., 1., 1.
9, 5., 5., 5.
*ELEMENT, TYPE=C3D6, ELSET=E
1, 1, 2, 3, 4, 5, 6
*SURFACE, NAME=S
E, S1
E, S3
*COUPLING, CONSTRAINT NAME=C, REF NODE=9, SURFACE=S
*DISTRIBUTING
1, 3
";
    let deck = parse(text).unwrap();
    let mut weights: Vec<(u32, f64)> = deck.couplings[0].nodes.clone();
    weights.sort_by_key(|(node, _)| *node);
    let (sixth, quarter) = (1.0 / 6.0, 0.25);
    let expected = [
        (0, sixth + quarter),
        (1, sixth + quarter),
        (2, sixth),
        (3, quarter),
        (4, quarter),
    ];
    for (found, expected) in weights.iter().zip(expected) {
        assert_eq!(found.0, expected.0);
        assert!((found.1 - expected.1).abs() < 1e-15, "{found:?} {expected:?}");
    }
    // Rotations were left free: nothing may use them.
    let text = format!("{text}*SOLID SECTION, ELSET=E, MATERIAL=M\n*MATERIAL, NAME=M\n*ELASTIC\n1,0\n*DENSITY\n1\n");
    assert!(model(&text).is_ok());
    assert_defect(
        &format!("{text}*STEP\n*CLOAD\n9, 5, 1.\n*END STEP\n"),
        "9, 5, 1.",
        &["node 9 has no component 5", "*CLOAD", "free"],
    );
    assert!(matches!(&deck.surfaces["S"].members, Members::Faces(faces) if faces[..] == [(0, 0), (0, 2)]));
}

#[test]
fn every_defect_names_its_line() {
    let cases: &[(&str, &str, &str, &[&str])] = &[
        // Exchanged passage, its replacement, part of the line at fault, what the message says.
        (
            "*HEADING",
            "77, 88\n*HEADING",
            "77, 88",
            &["`77, 88`", "before the first keyword"],
        ),
        (
            "8, 0., 1., 1.\n",
            "8, 0., 1., 1.\n8, 0., 0., 0.\n",
            "8, 0., 0., 0.",
            &["node `8`", "cubes.inp:12"],
        ),
        (
            "3, 1., 1., 0.",
            "3, 1., 1., nan",
            "nan",
            &["coordinate = `nan`", "finite"],
        ),
        ("3, 1., 1., 0.", "3, 1., 1., 1e999", "1e999", &["1e999"]),
        ("3, 1., 1., 0.", "x, 1., 1., 0.", "x, 1.", &["node = `x`"]),
        ("3, 1., 1., 0.", "4294967296, 1., 1., 0.", "4294967296", &["4294967295"]),
        (
            "1, 1, 2, 3, 4, 5, 6, 7, 8",
            "1, 1, 2, 3, 4, 5, 6, 7, 99",
            "1, 1, 2, 3",
            &["node `99` is not defined"],
        ),
        (
            "1, 1, 2, 3, 4, 5, 6, 7, 8",
            "1, 1, 2, 3, 4, 5, 6, 7",
            "1, 1, 2, 3",
            &["element 1", "7 given, 8 needed"],
        ),
        (
            "1, 1, 2, 3, 4, 5, 6, 7, 8",
            "1, 1, 2, 3, 4, 5, 6, 7, 7",
            "1, 1, 2, 3",
            &["`7`", "C3D6"],
        ),
        (
            "2, 11, 12, 13, 14,",
            "1, 11, 12, 13, 14,",
            "1, 11, 12",
            &["element `1`", "cubes.inp:24"],
        ),
        ("TYPE=C3D8I", "TYPE=C3D27", "C3D27", &["C3D27", "C3D20R"]),
        ("TYPE=C3D8I, ", "", "*ELEMENT, ELSET=UPPER", &["TYPE"]),
        ("LOWER, UPPER", "LOWER, OTHER", "LOWER, OTHER", &["element set `OTHER`"]),
        (
            "*ELSET, ELSET=BODY\nLOWER, UPPER\n",
            "*ELSET, ELSET=BODY\n",
            "*ELSET, ELSET=BODY",
            &["`BODY` is empty"],
        ),
        (
            "*SURFACE, NAME=TOP\n2, S1",
            "*SURFACE, NAME=TOP",
            "*SURFACE, NAME=TOP",
            &["surface `TOP` is empty"],
        ),
        ("2, S1", "2, SPOS", "SPOS", &["face = `SPOS`"]),
        ("2, S1", "2, S7", "S7", &["face = `S7`"]),
        ("2, S1", "3, S1", "3, S1", &["element `3`"]),
        (
            "NAME=HEAD",
            "NAME= TOP",
            "NAME= TOP",
            &["surface `TOP`", "cubes.inp:32"],
        ),
        (
            "ELSET=BODY, MATERIAL",
            "ELSET=UPPER, MATERIAL",
            "1, 1, 2, 3",
            &["element 1 has no *SOLID SECTION"],
        ),
        ("MATERIAL=STEEL", "MATERIAL=WOOD", "WOOD", &["material `WOOD`"]),
        (
            "ELSET=BODY, MATERIAL=STEEL",
            "ELSET=BODY, MATERIAL=STEEL, ORIENTATION=O",
            "ORIENTATION",
            &["ORIENTATION=O"],
        ),
        ("*DENSITY\n7800.,\n", "", "*MATERIAL", &["*DENSITY of material Steel"]),
        (
            "2.D11, 0.3",
            "2.D11, 0.3, 20.\n1.D11, 0.3, 90.",
            "*ELASTIC",
            &["2 given, 1 needed"],
        ),
        (
            "*ELASTIC",
            "*ELASTIC, TYPE=ORTHOTROPIC",
            "ORTHOTROPIC",
            &["TYPE=ORTHOTROPIC"],
        ),
        (
            "*DENSITY",
            "*PLASTIC\n1., 0.\n*DENSITY",
            "*PLASTIC",
            &["PLASTIC", "linear elastic"],
        ),
        ("TOP, BOTTOM", "TOP, NOWHERE", "TOP, NOWHERE", &["surface `NOWHERE`"]),
        ("NAME=GLUE", "NAME=GLUE, CYCLIC SYMMETRY", "CYCLIC", &["CYCLICSYMMETRY"]),
        (
            "TOP, BOTTOM\n",
            "TOP, BOTTOM\n*TIE, NAME=AGAIN\nTOP , BOTTOM\n",
            "TOP , BOTTOM",
            &["node 11", "tie `GLUE` at cubes.inp:44", "tie `AGAIN`"],
        ),
        (
            "*DISTRIBUTING",
            "*KINEMATIC\n*TIE, NAME=T\nHEAD, BOTTOM",
            "HEAD, BOTTOM",
            &["node 15", "coupling `HOOK`", "tie `T`"],
        ),
        (
            "*DISTRIBUTING\n",
            "",
            "*COUPLING",
            &["neither *DISTRIBUTING nor *KINEMATIC"],
        ),
        (
            "*DISTRIBUTING",
            "*DISTRIBUTING, WEIGHTING METHOD=CUBIC",
            "CUBIC",
            &["WEIGHTINGMETHOD=CUBIC"],
        ),
        ("REF NODE=100", "REF NODE=7", "*COUPLING", &["reference node = `7`"]),
        ("REF NODE=100", "REF NODE=ALL", "*COUPLING", &["18 given, 1 needed"]),
        ("*TIE", "*GAP\n*TIE", "*GAP", &["joint analysis"]),
        ("*TIE", "*WHATEVER\n*TIE", "*WHATEVER", &["*WHATEVER is not supported"]),
        ("*TIE", "*,x\n*TIE", "*,x", &["no keyword"]),
        ("*TIE", "*NGEN\n1,8,1\n*TIE", "*NGEN", &["write all nodes"]),
        ("*TIE", "*CLOAD\n1, 1, 1.\n*TIE", "*CLOAD", &["*STEP"]),
        (
            "*TIE",
            "*BOUNDARY\n1, 1, 1, 0.1\n*TIE",
            "1, 1, 1, 0.1",
            &["prescribed motion = `0.1`"],
        ),
        ("*TIE", "*BOUNDARY\n1, 11\n*TIE", "1, 11", &["component = `11`"]),
        ("*TIE", "*BOUNDARY\n1, GLUED\n*TIE", "GLUED", &["GLUED", "ENCASTRE"]),
        ("*TIE", "*BOUNDARY\n101, 1\n*TIE", "101, 1", &["node 101"]),
        (
            "*TIE",
            "*NSET, NSET=G, GENERATE\n1, 4000000000\n*TIE",
            "1, 4000000000",
            &["node `9`"],
        ),
        (
            "*TIE",
            "*NSET, NSET=G, GENERATE\n1, 4, 2\n*TIE",
            "1, 4, 2",
            &["generated range"],
        ),
        ("*TIE", "*NSET, NSET=G\n1, H\n*TIE", "1, H", &["node set `H`"]),
        ("*TIE", "*NSET\n1\n*TIE", "*NSET", &["NSET"]),
        (
            "*TIE",
            "*EQUATION\n3 ,\n1, 1, 1., 2, 1, 1.\n*TIE",
            "3 ,",
            &["2 given, 3 needed"],
        ),
        (
            "*TIE",
            "*EQUATION\n2 ,\n1, 4, 1., 2, 1, 1.\n*TIE",
            "2 ,",
            &["node 1 has no component 4"],
        ),
        ("*TIE", "*MPC\nSLIDER, 1, 2\n*TIE", "SLIDER", &["*MPC type `SLIDER`"]),
        (
            "*TIE",
            "*INCLUDE, INPUT=more.inp\n*TIE",
            "*INCLUDE",
            &["INCLUDE", "read it from its file"],
        ),
        ("*TIE", "*PART, NAME=P\n*TIE", "*PART", &["*END"]),
        ("*TIE", "*END PART\n*TIE", "*END PART", &["END PART"]),
        (
            "*TIE",
            "*STEP\n*NODE  , NSET=X\n1,0,0,0\n*END STEP\n*TIE",
            "*NODE  ,",
            &["before the first *STEP"],
        ),
        (
            "*TIE",
            "*STEP\n*CLOAD\n1, 1, 1.\n1, 1, 2.\n*END STEP\n*TIE",
            "1, 1, 2.",
            &["component 1 of node 1"],
        ),
        (
            "*TIE",
            "*STEP, NAME=X\n*END STEP\n*STEP, NAME=x\n*END STEP\n*TIE",
            "NAME=x",
            &["step `x`"],
        ),
        ("*TIE", "*FREQUENCY\n*TIE", "*FREQUENCY", &["into a *STEP"]),
        (
            "*TIE",
            "*MATERIAL, NAME=STEEL\n*TIE",
            "NAME=STEEL",
            &["material `STEEL`"],
        ),
        ("*TIE", "*NODE, INPUT=x\n*TIE", "*NODE, INPUT=x", &["INPUT"]),
    ];
    for (old, new, part, said) in cases {
        let text = with(old, new);
        assert_eq!(text.lines().filter(|line| line.contains(part)).count(), 1, "{part}");
        assert_defect(&text, part, said);
    }
    let parts: &[(&str, &str, &str, &[&str])] = &[
        (
            "PART=CUBE\n*END INSTANCE\n*INSTANCE",
            "PART=CONE\n*END INSTANCE\n*INSTANCE",
            "CONE",
            &["part `CONE`"],
        ),
        (
            "NAME=Second",
            "NAME=FIRST",
            "NAME=FIRST",
            &["instance `FIRST`", "cubes.inp:24"],
        ),
        (
            "3., 0., 0., 3., 0., 1., 90.",
            "3., 0., 1., 3., 0., 1., 90.",
            "3., 0., 1., 3.",
            &["axis of rotation"],
        ),
        ("INSTANCE=Second", "INSTANCE=Third", "Third", &["instance `Third`"]),
        ("Second.8", "Second.9", "Second.9", &["node `SECOND.9`"]),
        (
            "*MATERIAL",
            "*END  ASSEMBLY\n*MATERIAL",
            "*END  ASSEMBLY",
            &["END ASSEMBLY", "move it"],
        ),
        (
            "*END INSTANCE\n*NODE",
            "*END INSTANCE\n*SURFACE, NAME=FIRST.X\nFirst.E, S1\n*NODE",
            "FIRST.X",
            &["new name"],
        ),
    ];
    for (old, new, part, said) in parts {
        assert!(PARTS.contains(old));
        let text = PARTS.replacen(old, new, 1);
        assert_defect(&text, part, said);
    }
    let missing = abaqus::read("/no such folder/x.inp", Includes::BelowTheDeck).unwrap_err();
    assert!(
        matches!(&missing, Error::InputFile(file_io::input::Error::Unreadable { path, .. }) if path.ends_with("x.inp")),
        "{missing}"
    );
}

#[test]
fn short_texts_cannot_fill_the_memory() {
    // Each set holds the one before and all nodes: their sizes stay, but a load case repeats them.
    let mut text = String::from("*NODE, NSET=S\n");
    for i in 1..=2000 {
        text.push_str(&format!("{i},0,0,0\n"));
    }
    for i in 0..2000 {
        text.push_str(&format!("*NSET, NSET=S{i}\nS\n"));
    }
    let error = parse(&text).unwrap_err();
    assert!(
        matches!(
            &error,
            Error::Deck {
                problem: DeckProblem::TooLarge { .. },
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn included_files_are_found_and_circles_are_not_followed() {
    let folder = test_support::TemporaryFolder::new("finite-elements-deck");
    std::fs::create_dir_all(folder.join("sub")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let (nodes, rest) = CUBES.split_at(CUBES.find("*ELEMENT").unwrap());
    let (header, coordinates) = nodes.split_at(nodes.find("1, 0.").unwrap());
    write("main.inp", &format!("{header}*INCLUDE, INPUT=sub/nodes.inp\n{rest}"));
    write("sub/nodes.inp", "*INCLUDE, INPUT=more.inp\n");
    write("sub/more.inp", coordinates);
    let found = abaqus::read(folder.join("main.inp"), Includes::BelowTheDeck).unwrap();
    assert_eq!(found.files, ["main.inp", "sub/nodes.inp", "more.inp"]);
    let plain = model(CUBES).unwrap();
    assert_eq!(found.assembly(&Choices::default()).unwrap().assembly, plain.assembly);
    assert_eq!(found.place(found.nodes[2].line), "more.inp:3");
    write("sub/more.inp", "1, 0., 0., 0.\n*INCLUDE, INPUT=../main.inp\n");
    let circle = abaqus::read(folder.join("main.inp"), Includes::BelowTheDeck).unwrap_err();
    assert!(
        matches!(&circle, Error::Deck { file, line: 2, problem: DeckProblem::Include { .. } } if file == "more.inp"),
        "{circle}"
    );
    write("sub/more.inp", "*INCLUDE, INPUT=none.inp\n");
    let absent = abaqus::read(folder.join("main.inp"), Includes::BelowTheDeck)
        .unwrap_err()
        .to_string();
    assert!(absent.starts_with("more.inp:1: *INCLUDE of `none.inp`"), "{absent}");
}

#[test]
fn files_outside_the_folder_of_the_deck_are_taken_on_request_and_never_quoted() {
    let folder = test_support::TemporaryFolder::new("finite-elements-outside");
    std::fs::create_dir_all(folder.join("deck/sub")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("secret.inp", "root:$6$hash:19000\n*SECRET, KEY=hash\n1, hash\n");
    write("deck/sub/link.txt", "");
    let main = folder.join("deck/main.inp");
    let include = |path: &str| {
        std::fs::write(&main, format!("*INCLUDE, INPUT={path}\n{CUBES}")).unwrap();
    };
    let absolute = folder.join("secret.inp").display().to_string();
    let mut outside = vec![
        "../secret.inp",
        "sub/../../secret.inp",
        &absolute,
        "../absent.inp",
        "/absent.inp",
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&absolute, folder.join("deck/sub/link.inp")).unwrap();
        outside.push("sub/link.inp");
    }
    for path in outside {
        include(path);
        let error = abaqus::read(&main, Includes::BelowTheDeck).unwrap_err().to_string();
        assert!(error.starts_with("main.inp:1: *INCLUDE of"), "{error}");
        assert!(
            error.contains("--allow-includes-outside") && !error.contains("hash"),
            "{error}"
        );
    }
    // What is wrong with each of the lines would quote it.
    for text in [
        "root:hash",
        "*HASH",
        "*NODE, HASH=1",
        "*NODE\nhash, 1., 1., 1.",
        "*INCLUDE, INPUT=hash",
        "*ELEMENT, TYPE=HASH",
    ] {
        write("secret.inp", text);
        include("../secret.inp");
        let error = abaqus::read(&main, Includes::Anywhere).unwrap_err().to_string();
        assert!(error.starts_with("../secret.inp:"), "{error}");
        assert!(!error.to_lowercase().contains("hash"), "{error}");
    }
    write("secret.inp", "*NODE\n99, 1., 2., 3.\n");
    include("../secret.inp");
    assert_eq!(
        abaqus::read(&main, Includes::Anywhere).unwrap().nodes[0].at,
        [1.0, 2.0, 3.0]
    );
    // A folder that is named in another way is the same folder.
    write("deck/nodes.inp", "*NODE\n99, 1., 2., 3.\n");
    include("../deck/nodes.inp");
    assert_eq!(
        abaqus::read(&main, Includes::BelowTheDeck).unwrap().nodes[0].at,
        [1.0, 2.0, 3.0]
    );
}

#[cfg(target_os = "linux")]
#[test]
fn endless_files_are_not_included() {
    let folder = test_support::TemporaryFolder::new("finite-elements-endless");
    let main = folder.join("main.inp");
    let pipe = folder.join("pipe.inp");
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    for (path, includes, said) in [
        ("pipe.inp", Includes::BelowTheDeck, "it is a pipe"),
        ("/dev/zero", Includes::Anywhere, "it is a device"),
        (".", Includes::BelowTheDeck, "it is a folder"),
    ] {
        std::fs::write(&main, format!("*INCLUDE, INPUT={path}\n")).unwrap();
        let error = abaqus::read(&main, includes).unwrap_err().to_string();
        assert!(error.contains(said) && error.starts_with("main.inp:1"), "{error}");
    }
    for (path, said) in [
        (pipe.as_path(), "it is a pipe"),
        ("/dev/zero".as_ref(), "it is a device"),
    ] {
        let error = abaqus::read(path, Includes::BelowTheDeck).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

/// Time that this thread has spent on a processor (ns), whatever else the machine does.
#[cfg(target_os = "linux")]
fn on_processor() -> u64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split_whitespace().next().unwrap().parse().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn instances_cost_in_proportion_to_their_number() {
    let (part, rest) = PARTS.split_at(PARTS.find("*ASSEMBLY").unwrap());
    let material = &rest[rest.find("*MATERIAL").unwrap()..rest.find("*BOUNDARY").unwrap()];
    let cost = |count: usize| {
        let mut text = format!("{part}*ASSEMBLY, NAME=A\n");
        for i in 0..count {
            text += &format!("*INSTANCE, NAME=I{i}, PART=CUBE\n{}., 0., 0.\n*END INSTANCE\n", 2 * i);
        }
        for i in 0..count {
            text += &format!(
                "*NSET, NSET=S{i}, INSTANCE=I{i}\nLOW\n*NSET, NSET=ENDS\nI{i}.1\n*TIE, NAME=T{i}\nA.I{i}.UP, I{i}.UP\n"
            );
        }
        text += &format!("*END ASSEMBLY\n{material}");
        let times = (0..3).map(|_| {
            let begin = on_processor();
            let deck = parse(&text).unwrap();
            assert_eq!((deck.instances.len(), deck.node_sets["ENDS"].len()), (count + 1, count));
            on_processor() - begin
        });
        times.min().unwrap() as f64
    };
    // Squares would be 64; what falls out of the processor's caches costs a factor of two.
    let ratio = cost(16_000) / cost(2000);
    assert!(ratio < 28.0, "eight times the instances cost {ratio:.1} times as much");
}

/// Three blocks of different cells with everything that an assembly may hold.
fn everything() -> Assembly {
    let mut mesh = Mesh::default();
    for (name, density) in [("steel", 7857.8), ("odd, \"name\"", 1000.0 / 3.0)] {
        mesh.materials.push(Material {
            name: name.into(),
            youngs_modulus: 1e11 / 7.0,
            poisson_ratio: 0.29,
            density,
        });
    }
    let cube = |mesh: &mut Mesh, z: f64| {
        let first = mesh.nodes.len() as u32;
        for k in 0..2 {
            for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                mesh.nodes
                    .push([x / 3.0 + 0.01 * z, y / 7.0 - 0.0, z + f64::from(k) * 0.1]);
            }
        }
        [0, 1, 2, 3, 4, 5, 6, 7].map(|a| first + a)
    };
    let formulations = [Formulation::BBar, Formulation::IncompatibleModes, Formulation::Reduced];
    let mut ties = Vec::new();
    let mut below: Option<Face> = None;
    for (i, z) in [0.0, 0.1, 0.2, 0.3, 0.4].into_iter().enumerate() {
        let n = cube(&mut mesh, z);
        let material = (i % 2) as u16;
        let cells = match i {
            0..=2 => vec![Cell::hex8(n, formulations[i])],
            3 => vec![
                Cell::wedge6([n[0], n[1], n[2], n[4], n[5], n[6]]),
                Cell::wedge6([n[0], n[2], n[3], n[4], n[6], n[7]]),
            ],
            _ => [[1, 2], [2, 3], [3, 7], [7, 4], [4, 5], [5, 1]]
                .map(|[a, b]| Cell::tet4([n[0], n[a], n[b], n[6]]))
                .to_vec(),
        };
        let first = cells[0];
        mesh.elements
            .extend(cells.into_iter().map(|cell| Element { cell, material }));
        if let Some(face) = below {
            ties.push(Tie {
                name: "glue".into(),
                slave_nodes: n[..4].to_vec(),
                master_faces: vec![face],
                position_tolerance: 0.02,
                beyond: BeyondTolerance::LeaveFree,
                adjust: i % 2 == 0,
            });
        }
        below = Some(first.face(1));
    }
    // A quadratic tetrahedron of its own.
    let corners = [[2.0, 0.0, 0.0], [2.1, 0.0, 0.0], [2.0, 0.1, 0.0], [2.0, 0.0, 0.1]];
    let first = mesh.nodes.len() as u32;
    mesh.nodes.extend(corners);
    for [a, b] in [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]] {
        mesh.nodes
            .push([0, 1, 2].map(|c: usize| 0.5 * (corners[a][c] + corners[b][c])));
    }
    let cell = Cell::tet10([0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|a| first + a));
    mesh.elements.push(Element { cell, material: 1 });
    let couplings = vec![
        Coupling {
            name: "cloud".into(),
            reference: [0.1, 0.2, 0.3],
            nodes: vec![0, 1, 2, 3],
            kind: CouplingKind::Distributing(vec![1.0 / 3.0, 0.2, 1.0, 4.0]),
        },
        Coupling {
            name: "cloud".into(),
            reference: [2.0, 0.1, -0.3],
            nodes: vec![first, first + 1, first + 2],
            kind: CouplingKind::Kinematic([true, true, true]),
        },
        Coupling {
            name: "part".into(),
            reference: [0.3, -0.1, 0.05],
            nodes: vec![4, 5, 6, 7],
            kind: CouplingKind::Distributing(vec![1.0; 4]),
        },
    ];
    Assembly {
        mesh,
        ties,
        couplings,
        equations: vec![Equation {
            name: "bolt".into(),
            terms: vec![
                (Dof::Reference(0, 4), 1.0),
                (Dof::Reference(1, 4), -2.0 / 3.0),
                (Dof::Node(16, 1), 0.1),
            ],
        }],
        supports: vec![Dof::Node(0, 2), Dof::Reference(1, 0), Dof::Reference(1, 5)],
        springs: vec![GroundSpring {
            node: 5,
            component: 1,
            stiffness: 30.0,
        }],
        masses: vec![PointMass { node: 6, mass: 8e-4 }],
        loads: vec![
            LoadPattern {
                name: "pull".into(),
                terms: vec![(Dof::Node(2, 0), 1.5), (Dof::Reference(0, 2), -7.0 / 3.0)],
            },
            LoadPattern {
                name: "step/case".into(),
                terms: vec![(Dof::Reference(2, 3), 1e-3)],
            },
        ],
        ..Assembly::default()
    }
}

#[test]
fn what_is_written_is_read_back() {
    let assembly = everything();
    let text = abaqus::write(&assembly, &[], &[]).unwrap();
    let back = model(&text).unwrap().assembly;
    let bits = |mesh: &Mesh| mesh.nodes.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&back.mesh), bits(&assembly.mesh));
    assert_eq!(back.mesh.elements, assembly.mesh.elements);
    for (found, expected) in back.mesh.materials.iter().zip(&assembly.mesh.materials) {
        assert_eq!(found.youngs_modulus, expected.youngs_modulus);
        assert_eq!(found.density, expected.density);
    }
    assert_eq!(back.springs, assembly.springs);
    assert_eq!(back.masses, assembly.masses);
    assert_eq!(back.supports.len(), assembly.supports.len());
    assert_eq!(back.equations[0].terms, assembly.equations[0].terms);
    assert_eq!(back.loads, assembly.loads);
    for (found, expected) in back.ties.iter().zip(&assembly.ties) {
        assert_eq!(found.slave_nodes, expected.slave_nodes);
        assert_eq!(found.master_faces, expected.master_faces);
        assert_eq!(
            (found.position_tolerance, found.adjust),
            (expected.position_tolerance, expected.adjust)
        );
    }
    for (found, expected) in back.couplings.iter().zip(&assembly.couplings) {
        assert_eq!(
            (found.reference, &found.nodes, &found.kind),
            (expected.reference, &expected.nodes, &expected.kind)
        );
    }
    let [a, b] = [&assembly, &back].map(|assembly| System::try_new(assembly).unwrap());
    assert_eq!(a.stiffness, b.stiffness);
    assert_eq!(a.mass, b.mass);
    assert_eq!(a.loads, b.loads);
    // Once more: writing is settled.
    assert_eq!(
        abaqus::write(
            &model(&abaqus::write(&back, &[], &[]).unwrap()).unwrap().assembly,
            &[],
            &[]
        )
        .unwrap(),
        abaqus::write(&back, &[], &[]).unwrap()
    );
}

/// One element of each quadratic type, beside one another, with curved edges.
fn quadratic() -> Mesh {
    let mut mesh = Mesh {
        materials: vec![Material {
            name: "steel".into(),
            youngs_modulus: 2e11,
            poisson_ratio: 0.3,
            density: 7800.0,
        }],
        ..Mesh::default()
    };
    let elements = [
        (&HEX20, Formulation::Full),
        (&HEX20, Formulation::Reduced),
        (&WEDGE15, Formulation::Full),
        (&TET10, Formulation::Full),
    ];
    for ((row, formulation), shift) in elements.into_iter().zip([0.0, 3.0, 6.0, 9.0]) {
        let first = mesh.nodes.len() as u32;
        let bent = |x: &[f64; 3]| [x[0] + shift, x[1], x[2] + 0.1 * x[0] * x[0]];
        mesh.nodes.extend(row.nodes.iter().map(bent));
        let nodes: Vec<u32> = (first..).take(row.n_nodes()).collect();
        let cell = Cell::try_new(row, formulation, &nodes).unwrap();
        mesh.elements.push(Element { cell, material: 0 });
    }
    mesh
}

#[test]
fn quadratic_elements_are_written_and_read_back() {
    let assembly = Assembly {
        mesh: quadratic(),
        ..Assembly::default()
    };
    let faces: Vec<Face> = assembly.mesh.elements.iter().flat_map(|e| e.cell.faces()).collect();
    let group = Group {
        name: "SKIN".into(),
        members: faces.clone(),
    };
    let text = abaqus::write(&assembly, &[group], &[]).unwrap();
    for name in ["C3D20\n", "C3D20R\n", "C3D15\n", "C3D10\n"] {
        assert!(text.contains(&format!("TYPE={name}")), "{text}");
    }
    // No line has more entries than Abaqus reads.
    assert!(
        text.lines()
            .all(|line| line.trim_end_matches(',').split(',').count() <= 16),
        "{text}"
    );
    let back = model(&text).unwrap();
    assert_eq!(back.assembly.mesh.elements, assembly.mesh.elements);
    assert_eq!(back.surface_faces("SKIN").unwrap(), faces);
    // Choices of formulation apply to the hexahedra that have them.
    let deck = abaqus::parse(&text, "quadratic.inp").unwrap();
    let of = |formulation| {
        let choices = Choices {
            formulation,
            ..Choices::default()
        };
        let elements = deck.assembly(&choices).unwrap().assembly.mesh.elements;
        [0, 1].map(|e| elements[e].cell.formulation())
    };
    assert_eq!(of(Some(Formulation::Reduced)), [Formulation::Reduced; 2]);
    assert_eq!(of(Some(Formulation::BBar)), [Formulation::Full, Formulation::Reduced]);

    let mut lagrange = Assembly::default();
    lagrange.mesh.materials = assembly.mesh.materials;
    lagrange.mesh.nodes = HEX27.nodes.to_vec();
    let cell = Cell::try_new(&HEX27, Formulation::Full, &(0..27).collect::<Vec<u32>>()).unwrap();
    lagrange.mesh.elements.push(Element { cell, material: 0 });
    let error = abaqus::write(&lagrange, &[], &[]).unwrap_err().to_string();
    assert!(error.contains("element 0") && error.contains("20 nodes"), "{error}");
}

#[test]
fn couplings_share_the_area_of_quadratic_quadrilaterals_among_the_middles_of_their_edges() {
    let mesh = quadratic();
    let assembly = Assembly {
        mesh,
        ..Assembly::default()
    };
    let face = assembly.mesh.elements[0].cell.face(0);
    let group = Group {
        name: "FACE".into(),
        members: vec![face],
    };
    let mut text = abaqus::write(&assembly, &[group], &[]).unwrap();
    text.push_str("*NODE, NSET=REF\n9001, 0., 0., -1.\n*COUPLING, CONSTRAINT NAME=C, REF NODE=9001, SURFACE=FACE\n*DISTRIBUTING\n");
    let back = model(&text).unwrap();
    let coupling = &back.assembly.couplings[0];
    let CouplingKind::Distributing(weights) = &coupling.kind else {
        panic!("{coupling:?}");
    };
    let mut nodes = coupling.nodes.clone();
    nodes.sort_unstable();
    assert_eq!(nodes, [8, 9, 10, 11]);
    assert!(weights.iter().all(|w| *w > 0.0));
    // The face is a strip of the parabola z = 0.1 x^2, two wide: 3 x 3 points come within 1e-5 of its area.
    let total: f64 = weights.iter().sum();
    let expected = 2.0 * (1.04_f64.sqrt() + 0.2_f64.asinh() / 0.2);
    assert!((total / expected - 1.0).abs() < 1e-5, "{total} {expected}");
}

#[test]
fn what_no_deck_can_say_is_not_written() {
    let mut full = everything();
    full.mesh.set_formulation(Formulation::Full);
    let error = abaqus::write(&full, &[], &[]).unwrap_err().to_string();
    assert!(error.contains("element 0"), "{error}");
    let mut inner = everything();
    inner.ties[0].master_faces[0] = Face::tri3([0, 1, 9]);
    let error = abaqus::write(&inner, &[], &[]).unwrap_err().to_string();
    assert!(error.contains("tie `glue`"), "{error}");
    let mut dangling = everything();
    dangling.loads[0].terms[0].0 = Dof::Reference(7, 0);
    assert!(matches!(
        abaqus::write(&dangling, &[], &[]),
        Err(Error::NotWritable { .. })
    ));
}

#[test]
fn damaged_decks_give_errors_and_no_panic() {
    let fragments: [&[u8]; 10] = [
        b"*",
        b"**",
        b",",
        b"=",
        b"\"",
        b"4294967295",
        b"GENERATE",
        b"S1",
        b"*END PART\n",
        "\u{e9}".as_bytes(),
    ];
    let written = abaqus::write(&everything(), &[], &[]).unwrap();
    let mut damage = test_support::Damage::new(7, &fragments);
    let (mut read, mut refused) = (0, 0);
    for original in [CUBES, PARTS, &written] {
        for _ in 0..3000 {
            let bytes = damage.of(original.as_bytes());
            let text = String::from_utf8_lossy(&bytes);
            match model(&text) {
                Ok(model) => {
                    read += 1;
                    assert!(model.assembly.mesh.nodes.iter().flatten().all(|x| x.is_finite()));
                }
                Err(error) => {
                    refused += 1;
                    assert!(matches!(error, Error::Deck { line: 1.., .. }), "{error}");
                }
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 500 && refused > 2000, "{read} {refused}");
}
