//! The limit of the mesh: the first frequency of the beam (half of it where it is flat), by levels and orders of the elements.
//!
//! `mesh_limit family [GREATEST]` prints multiples of one mesh, all counts multiplied by the same number, with two formulations of linear
//! elements, to the third multiple (in minutes) or another one; `mesh_limit graded [GREATEST]` those of the graded mesh in quadratic
//! elements, to the second multiple. `mesh_limit LEVEL FORMULATION [GAP]` prints one row: level `quick`, `coarse`, `default`, `fine` or
//! `finest`, formulation `C3D8I`, `C3D8R`, `C3D20` or `C3D20R`, gap `flat` or `measured`. Interface elements have two points per
//! direction, quadratic ones three.
#![expect(clippy::print_stdout, reason = "an example prints")]
use analyses::Prepared;
use brake_reuss_beam::mesh::Refinement;
use brake_reuss_beam::{BrakeReussBenchmark, benchmark, published};
use finite_elements::elements::Formulation;
use joint_model::benchmark::{ElementOrder, MeshSettings, Symmetry};
use joints::Options;
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::{Gap, Scene};
use std::error::Error;
use std::time::Instant;

type Elements = (&'static str, ElementOrder, Formulation);

const ELEMENTS: [Elements; 4] = [
    ("C3D8I", ElementOrder::Linear, Formulation::IncompatibleModes),
    ("C3D8R", ElementOrder::Linear, Formulation::Reduced),
    ("C3D20", ElementOrder::Quadratic, Formulation::Full),
    ("C3D20R", ElementOrder::Quadratic, Formulation::Reduced),
];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        [] | ["family"] => family(&Refinement::unit(), [0, 1], 3),
        ["family", greatest] => family(&Refinement::unit(), [0, 1], greatest.parse()?),
        ["graded"] => family(&Refinement::graded_unit(), [2, 3], 2),
        ["graded", greatest] => family(&Refinement::graded_unit(), [2, 3], greatest.parse()?),
        [level, elements] => row(level, elements, "flat"),
        [level, elements, gap] => row(level, elements, gap),
        _ => Err("give `family [GREATEST]`, `graded [GREATEST]`, or a level, a formulation and a gap".into()),
    }
}

fn family(unit: &Refinement, elements: [usize; 2], greatest: u8) -> Result<(), Box<dyn Error>> {
    let elements = elements.map(|row| ELEMENTS[row]);
    println!(
        "multiple  interface elements  {:>6} [Hz] {:>6} [Hz]",
        elements[0].0, elements[1].0
    );
    for multiple in 1..=greatest {
        let refinement = unit.scaled(f64::from(multiple))?;
        let [stiff, soft] = elements.map(|elements| first(&refinement, elements, Gap::Flat));
        println!(
            "{multiple:>8} {:>19} {:>11.4} {:>11.4}",
            refinement.interface_elements(),
            stiff?.frequency,
            soft?.frequency
        );
    }
    Ok(())
}

fn row(level: &str, elements: &str, gap: &str) -> Result<(), Box<dyn Error>> {
    let elements = ELEMENTS.into_iter().find(|(name, ..)| *name == elements);
    let elements = elements.ok_or("no such formulation")?;
    let presets = Refinement::presets(elements.1);
    let preset = presets.iter().find(|(name, _)| *name == level);
    let (_, refinement) = preset.ok_or("no such level")?;
    let gap = match gap {
        "flat" => Gap::Flat,
        "measured" => Gap::Measured,
        _ => return Err("the gap is flat or measured".into()),
    };
    let began = Instant::now();
    let found = first(refinement, elements, gap)?;
    println!(
        "{} unknowns, {} pairs of nodes, f1 {:.4} Hz, {:.1} s",
        found.unknowns,
        found.pairs,
        found.frequency,
        began.elapsed().as_secs_f64()
    );
    Ok(())
}

struct First {
    /// Of the structure before its reduction.
    unknowns: usize,
    /// Nodes of the interface.
    pairs: usize,
    /// Linearised (Hz).
    frequency: f64,
}

fn first(refinement: &Refinement, (_, element_order, hexahedra): Elements, gap: Gap) -> Result<First, Box<dyn Error>> {
    let mut scene = Scene::of(&BrakeReussBenchmark, "mesh limit")?;
    // The measured gap is not symmetric.
    scene.model.symmetry = match gap {
        Gap::Flat => Symmetry::Half,
        _ => Symmetry::None,
    };
    scene.model.element_order = Some(element_order);
    if element_order == ElementOrder::Quadratic {
        scene.interfaces.points_per_direction = 3;
    }
    scene.model.formulation = Some(hexahedra);
    scene.analyses.backbone.amplitudes = 0;
    scene.interfaces.gap = gap;
    let settings = MeshSettings {
        refinement: scene.model.refinement,
        arm_layers: None,
        symmetry: scene.model.symmetry,
        element_order,
        hexahedra,
        material: published::steel(),
    };
    let joint = benchmark::joint(refinement, &settings)?;
    let structure = Structure::from_joint(&scene.model, scene.bolts.behaviour, joint);
    let prepared = Prepared::try_new(&scene, &structure, &Options::default(), &Silent)?;
    let run = prepared.solve(&Silent)?;
    Ok(First {
        unknowns: run.model.facts.n_dofs,
        pairs: run.joint.mesh.nodes.len(),
        frequency: run.frequencies[0],
    })
}
