//! Bolts as decks model them: beams, rigid bodies, inertia, pretension sections; against closed forms and CalculiX.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use faer::Mat;
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::elements::Formulation;
use finite_elements::factor::SparseCholesky;
use finite_elements::formats::abaqus::{self, Choices, DeckModel};
use finite_elements::mesh::{Assembly, CouplingKind, Dof, LoadPattern};
use finite_elements::{Error, Quadratic};
use std::f64::consts::PI;

fn model(text: &str) -> Result<DeckModel, Error> {
    abaqus::parse(text, "bolt.inp")?.assembly(&Choices::default())
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs(),
        "found {found}, expected {expected}: off by {:.2e}",
        (found / expected - 1.0).abs()
    );
}

/// The motion of a component under the first load.
struct Static {
    system: System,
    model: DeckModel,
    motion: Vec<f64>,
}

impl Static {
    fn new(model: DeckModel) -> Self {
        let system = System::try_new(&model.assembly).unwrap();
        let factor = SparseCholesky::try_new(&system.stiffness, &system.positions, "stiffness").unwrap();
        let load = &system.loads[0];
        let mut u = Mat::from_fn(load.len(), 1, |i, _| load[i]);
        factor.solve_in_place(u.as_mut());
        let motion = (0..load.len()).map(|i| u[(i, 0)]).collect();
        Self { system, model, motion }
    }

    fn of(&self, dof: Dof) -> f64 {
        let action = self
            .system
            .dofs
            .force(&self.model.assembly, "test", &[(dof, 1.0)])
            .unwrap();
        action.iter().zip(&self.motion).map(|(a, u)| a * u).sum()
    }

    fn of_node(&self, node: &str) -> [f64; 3] {
        let node = self.model.node(node).unwrap();
        [0, 1, 2].map(|c| self.of(Dof::Node(node, c)))
    }
}

/// Two plates 50 x 10 x 10 mm joined by three columns 10 x 10 x 40 mm, the middle one with a pretension section in its half height; 1 kN
/// on its node. In mm, N and t.
const YOKE: &str = include_str!("../meshes/yoke.inp");

/// Displacements that CalculiX 2.20 gives (mm, printed with seven digits): the node's first component, then nodes above and below the
/// section and at corners.
const YOKE_OVERLAP: f64 = 1.018346e-2;
const YOKE_NODES: [(&str, [f64; 3]); 4] = [
    ("9", [-8.479598e-4, -1.479884e-4, 4.805809e-3]),
    ("35", [-8.479598e-4, -1.479884e-4, -3.140272e-3]),
    ("49", [-4.399382e-3, 3.412773e-5, 4.622634e-4]),
    ("77", [2.114096e-3, -1.380136e-4, 8.327686e-4]),
];

#[test]
fn a_pretension_section_through_solids_is_that_of_calculix() {
    let found = Static::new(model(YOKE).unwrap());
    assert_eq!(found.model.assembly.cuts[0].pairs.len(), 4);
    assert_eq!(found.model.assembly.rigid_motions().unwrap(), 0);
    let dof = found.model.pretension("85").unwrap();
    assert_eq!(found.model.pretension("pt").unwrap(), dof);
    let overlap = found.of(dof);
    println!("overlap {overlap:.6e} mm, CalculiX {YOKE_OVERLAP:.6e}");
    let mut worst = (overlap / YOKE_OVERLAP - 1.0).abs();
    for (node, expected) in YOKE_NODES {
        let of_node = found.of_node(node);
        println!("node {node}: {of_node:?} mm, CalculiX {expected:?}");
        for (found, expected) in of_node.iter().zip(expected) {
            worst = worst.max((found - expected).abs() / YOKE_OVERLAP);
        }
    }
    println!("worst {worst:.1e} of the overlap");
    assert!(worst < 1e-6, "{worst:e}");

    // Both halves overlap by the load of 1 kN per stiffness, and carry it: the sleeves are pressed by as much.
    let cut = &found.model.assembly.cuts[0];
    for pair in &cut.pairs {
        let [first, second] = pair.map(|node| found.of(Dof::Node(node, 2)));
        close(first - second, overlap, 1e-9);
    }
}

#[test]
fn a_cut_bolt_held_together_is_the_uncut_one() {
    let held = YOKE.replace("*BOUNDARY\n", "*BOUNDARY\n85, 1, 1\n");
    let cut = model(&held).unwrap().assembly;
    let from = YOKE.find("*SURFACE").unwrap();
    let to = YOKE.find("*BOUNDARY").unwrap();
    let load = YOKE.find("*STEP").unwrap();
    let uncut = model(&[&YOKE[..from], &YOKE[to..load]].concat()).unwrap().assembly;
    let frequencies = |assembly: &Assembly| {
        let system = System::try_new(assembly).unwrap();
        let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 5, 1e-9).unwrap();
        (modes.n_zero, modes.frequencies())
    };
    let raised = |assembly: &Assembly| {
        let mut raised = Quadratic::try_new(assembly, |_| None).unwrap().assembly;
        // Columns one element thick have motions that reduced integration does not see.
        raised.mesh.set_formulation(Formulation::Full);
        raised
    };
    for (cut, uncut) in [(cut.clone(), uncut.clone()), (raised(&cut), raised(&uncut))] {
        let ((zero, found), (same, expected)) = (frequencies(&cut), frequencies(&uncut));
        assert_eq!((zero, same), (0, 0));
        for (found, expected) in found.iter().zip(expected) {
            close(*found, expected, 1e-9);
        }
    }
}

/// A column 10 x 10 x 40 mm between two rigid faces with a beam through it, of which CalculiX takes the diameter twice; 1 kN of
/// pretension. In mm, N and t.
const COLUMN: &str = "\
*NODE, NSET=ALL
1, 0., 0., 0.
2, 10., 0., 0.
3, 10., 10., 0.
4, 0., 10., 0.
5, 0., 0., 40.
6, 10., 0., 40.
7, 10., 10., 40.
8, 0., 10., 40.
21, 5., 5., 0.
22, 5., 5., 40.
30, 5., 5., 20.
*ELEMENT, TYPE=C3D8I, ELSET=BODY
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=B31, ELSET=BOLT
2, 21, 22
*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.0
*DENSITY
7.85E-9
*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL
*BEAM SECTION, ELSET=BOLT, MATERIAL=STEEL, SECTION=CIRC
6., 6.
1., 0., 0.
*NSET, NSET=LOW
1, 2, 3, 4
*NSET, NSET=UP
5, 6, 7, 8
*RIGID BODY, NSET=LOW, REF NODE=21
*RIGID BODY, NSET=UP, REF NODE=22
*PRE-TENSION SECTION, ELEMENT=2, NODE=30
0., 0., 1.
*BOUNDARY
21, 1, 6
*STEP
*STATIC
*CLOAD
30, 1, 1000.
*END STEP
";

#[test]
fn a_pretensioned_beam_presses_what_it_clamps() {
    let found = Static::new(model(COLUMN).unwrap());
    let assembly = &found.model.assembly;
    assert_eq!((assembly.couplings.len(), assembly.shanks.len()), (2, 1));
    assert!(matches!(
        &assembly.couplings[0].kind,
        CouplingKind::Kinematic([true, true, true])
    ));
    // CalculiX 2.20: -1.904762e-3 mm at nodes 5 to 8 and 22.
    for node in ["5", "6", "7", "8"] {
        close(found.of_node(node)[2], -1.904762e-3, 2e-7);
    }
    // Without the elongation of the beam, which CalculiX leaves out, its 1.904762e-3 mm.
    let elongation = 1000.0 * 40.0 / (210_000.0 * PI * 9.0);
    close(
        found.of(found.model.pretension("30").unwrap()) - elongation,
        1.904762e-3,
        2e-7,
    );
    close(found.of(Dof::Reference(1, 2)), -1.904762e-3, 2e-7);
}

#[test]
fn beams_bend_and_quadratic_ones_are_two() {
    let deck = |elements: &str, nodes: &str, section: &str| {
        format!(
            "*NODE\n1, 0., 0., 0.\n2, 0., 0.3, 0.\n3, 0., 0.6, 0.\n{nodes}*ELEMENT, ELSET=PIN, TYPE={elements}\n*MATERIAL, NAME=S\n\
             *ELASTIC\n2.1E11, 0.3\n*DENSITY\n7850.\n*BEAM SECTION, ELSET=PIN, SECTION={section}\n\
             *BOUNDARY\n1, ENCASTRE\n*STEP\n*STATIC\n*CLOAD\n3, 1, 1.\n3, 3, 1.\n*END STEP\n"
        )
    };
    let rectangle = "RECT, MATERIAL=S\n0.03, 0.02\n1., 0., 0.";
    let pair = Static::new(model(&deck("B31\n1, 1, 2\n2, 2, 3", "", rectangle)).unwrap());
    let curved = Static::new(model(&deck("B32\n1, 1, 2, 3", "", rectangle)).unwrap());
    let shear = 2.1e11 / 2.6 * 0.03 * 0.02 * 10.0 * 1.3 / (12.0 + 11.0 * 0.3);
    for found in [&pair, &curved] {
        let end = found.model.reference("3").unwrap();
        let bent = |second_moment: f64| 0.6_f64.powi(3) / (3.0 * 2.1e11 * second_moment) + 0.6 / shear;
        close(
            found.of(Dof::Reference(end, 0)),
            bent(0.02 * 0.03_f64.powi(3) / 12.0),
            1e-9,
        );
        close(
            found.of(Dof::Reference(end, 2)),
            bent(0.03 * 0.02_f64.powi(3) / 12.0),
            1e-9,
        );
        close(found.system.total_mass, 7850.0 * 0.03 * 0.02 * 0.6, 1e-12);
    }
    // One entry is a radius, two are diameters.
    let one = model(&deck("B31\n1, 1, 2\n2, 2, 3", "", "CIRC, MATERIAL=S\n0.01")).unwrap();
    let two = model(&deck("B31\n1, 1, 2\n2, 2, 3", "", "CIRC, MATERIAL=S\n0.02, 0.02")).unwrap();
    assert_eq!(one.assembly.shanks, two.assembly.shanks);
    close(one.assembly.shanks[0].axial, 2.1e11 * PI * 1e-4 / 0.3, 1e-12);
    // Without pretension sections overlaps are held.
    assert_eq!(one.assembly.supports[..2], [Dof::Pretension(0), Dof::Pretension(1)]);
    assert_eq!(one.assembly.rigid_motions().unwrap(), 0);
}

#[test]
fn masses_and_inertia_stand_at_reference_nodes() {
    let text = COLUMN.replace(
        "*MATERIAL",
        "*ELEMENT, TYPE=MASS, ELSET=HEAD\n3, 22\n*ELEMENT, TYPE=ROTARYI, ELSET=TURN\n4, 22\n*MASS, ELSET=HEAD\n1e-5\n\
         *ROTARY INERTIA, ELSET=TURN\n1e-4, 2e-4, 3e-4, 1e-5\n*MATERIAL",
    );
    let assembly = model(&text).unwrap().assembly;
    let [head, turn] = &assembly.rigid_masses[..] else {
        panic!("{:?}", assembly.rigid_masses)
    };
    assert_eq!((head.coupling, head.mass, turn.coupling, turn.mass), (1, 1e-5, 1, 0.0));
    assert_eq!(turn.inertia, [[1e-4, 1e-5, 0.0], [1e-5, 2e-4, 0.0], [0.0, 0.0, 3e-4]]);
    let system = System::try_new(&assembly).unwrap();
    close(system.total_mass, 7.85e-9 * (4000.0 + PI * 9.0 * 40.0) + 1e-5, 1e-12);
}

/// The error of `text` with one passage exchanged stands at the line that holds `part` and says `said`.
fn assert_defect(text: &str, [old, new]: [&str; 2], part: &str, said: &str) {
    assert!(text.contains(old), "{old}");
    let text = text.replacen(old, new, 1);
    let error = model(&text).expect_err(new);
    let Error::Deck { line, .. } = &error else {
        panic!("{new}: {error}")
    };
    let expected = text.lines().position(|line| line.contains(part)).unwrap() as u32 + 1;
    assert_eq!(*line, expected, "{error}");
    assert!(error.to_string().contains(said), "`{said}` is not in `{error}`");
}

#[test]
fn defects_of_bolts_name_their_lines() {
    let of_column: &[([&str; 2], &str, &str)] = &[
        (["ELEMENT=2, NODE=30", "ELEMENT=1, NODE=30"], "*PRE-TENSION", "B31"),
        (
            ["ELEMENT=2, NODE=30", "ELEMENT=2, NODE=31"],
            "*PRE-TENSION",
            "node `31`",
        ),
        (
            ["ELEMENT=2, NODE=30", "ELEMENT=2, NODE=8"],
            "*PRE-TENSION",
            "nothing else",
        ),
        (
            ["ELEMENT=2, NODE=30", "ELEMENT=2, NODE=22"],
            "*PRE-TENSION",
            "nothing else",
        ),
        (["ELEMENT=2, NODE=30", "NODE=30"], "*PRE-TENSION", "SURFACE or ELEMENT"),
        (
            ["ELEMENT=2, NODE=30", "SURFACE=A, NODE=30"],
            "*PRE-TENSION",
            "surface of element faces",
        ),
        (
            ["0., 0., 1.\n*BOUNDARY", "0., 0., -1.\n*BOUNDARY"],
            "*PRE-TENSION",
            "first to the second",
        ),
        (
            ["0., 0., 1.\n*BOUNDARY", "0., 0., 0.0\n*BOUNDARY"],
            "0., 0., 0.0",
            "zero",
        ),
        (
            [
                "*BOUNDARY",
                "*NODE\n31, 1., 1., 1.\n*PRE-TENSION SECTION, NODE=31, ELEMENT=2\n*BOUNDARY",
            ],
            "NODE=31",
            "pretension section of beam",
        ),
        (["30, 1, 1000.", "30, 2, 1000."], "30, 2", "component 1 alone"),
        (["6., 6.", "6., 5."], "6., 5.", "equal"),
        (["6., 6.", "-6."], "-6.", "positive"),
        (
            ["SECTION=CIRC\n6., 6.", "SECTION=PIPE\n6., 6."],
            "SECTION=PIPE",
            "not supported",
        ),
        (
            ["SECTION=CIRC\n6., 6.\n1., 0., 0.", "SECTION=CIRC"],
            "SECTION=CIRC",
            "empty",
        ),
        (
            ["*BEAM SECTION, ELSET=BOLT", "*BEAM SECTION, ELSET=BODY"],
            "*BEAM",
            "set of B31",
        ),
        (["2, 21, 22", "2, 21, 21"], "2, 21, 21", "different positions"),
        (
            ["NSET=UP, REF NODE=22", "NSET=UP, REF NODE=8"],
            "NSET=UP, REF",
            "no element uses",
        ),
        (["NSET=UP, REF NODE=22", "REF NODE=22"], "BODY, REF NODE=22", "empty"),
        (
            ["NSET=UP, REF NODE=22", "NSET=UP, REF NODE=22, ROT NODE=3"],
            "ROT",
            "ROTNODE",
        ),
        (
            [
                "*MATERIAL",
                "*ELEMENT, TYPE=ROTARYI, ELSET=T\n4, 8\n*ROTARY INERTIA, ELSET=T\n1., 1., 1.\n*MATERIAL",
            ],
            "*ROTARY",
            "no rotations",
        ),
        (
            [
                "*MATERIAL",
                "*ELEMENT, TYPE=ROTARYI, ELSET=T\n4, 22\n*ROTARY INERTIA, ELSET=T\n1., -1., 1.\n*MATERIAL",
            ],
            "1., -1.",
            "positive",
        ),
        (
            ["*MATERIAL", "*ELEMENT, TYPE=B31, ELSET=T\n4, 21, 8\n*MATERIAL"],
            "4, 21, 8",
            "*BEAM SECTION",
        ),
    ];
    for (change, part, said) in of_column {
        assert_defect(COLUMN, *change, part.trim_end(), said);
    }
    let of_yoke: &[([&str; 2], &str, &str)] = &[
        (
            ["0., 0., 1.\n*NSET", "0., 0., -1.\n*NSET"],
            "*PRE-TENSION",
            "reverse it",
        ),
        (
            [
                "16, S2\n*PRE-TENSION SECTION, SURFACE=CUT, NODE=85\n0., 0., 1.\n",
                "1, S3\n*PRE-TENSION SECTION, SURFACE=CUT, NODE=85\n",
            ],
            "*PRE-TENSION",
            "both sides",
        ),
        (
            ["SURFACE=CUT, NODE=85", "SURFACE=CUT, ELEMENT=3, NODE=85"],
            "*PRE-TENSION",
            "not both",
        ),
        (
            [
                "*BOUNDARY",
                "*NODE\n99, 0., 0., 9.\n*NSET, NSET=N\n65, 66\n*RIGID BODY, NSET=N, REF NODE=99\n*BOUNDARY",
            ],
            "*PRE-TENSION",
            "no tie",
        ),
    ];
    for (change, part, said) in of_yoke {
        assert_defect(YOKE, *change, part, said);
    }
}

#[test]
fn loads_may_be_named_by_pretension_nodes() {
    let mut found = model(COLUMN).unwrap();
    assert_eq!(found.assembly.loads[0].terms, [(Dof::Pretension(0), 1000.0)]);
    found.assembly.loads = vec![LoadPattern {
        name: "unit".into(),
        terms: vec![(found.pretension("30").unwrap(), 1.0)],
    }];
    assert_eq!(System::try_new(&found.assembly).unwrap().loads.len(), 1);
    let error = found.pretension("21").unwrap_err().to_string();
    assert!(error.contains("pretension section") && error.contains("30"), "{error}");
}

#[test]
fn a_shank_beside_a_cut_leaves_the_tension_of_the_cut_where_it_was() {
    let mut found = model(YOKE).unwrap();
    let shank = model(COLUMN).unwrap().assembly.shanks.remove(0);
    found.assembly.supports.push(Dof::Pretension(0));
    assert_eq!(found.assembly.add_shank(shank), Dof::Pretension(0));
    assert_eq!(found.assembly.loads[0].terms, [(Dof::Pretension(1), 1000.0)]);
    assert_eq!(found.assembly.supports.last(), Some(&Dof::Pretension(1)));
}

#[test]
fn damaged_bolts_give_errors_and_no_panic() {
    let fragments: [&[u8]; 7] = [b"*", b",", b"-", b"0.", b"1e300", b"RECT", b"22"];
    let mut damage = test_support::Damage::new(11, &fragments);
    let (mut read, mut refused) = (0, 0);
    for original in [COLUMN, YOKE] {
        for _ in 0..2000 {
            let text = damage.of(original.as_bytes());
            let built = model(&String::from_utf8_lossy(&text))
                .and_then(|model| Ok((System::try_new(&model.assembly)?, model.assembly.rigid_motions()?)));
            match built {
                Ok((system, _)) => {
                    read += 1;
                    assert!(system.stiffness.data().iter().all(|entry| !entry.is_nan()));
                }
                Err(_) => refused += 1,
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 100 && refused > 1000, "{read} {refused}");
}
