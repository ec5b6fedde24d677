//! The limit of the mesh: the first frequency of the flat beam on multiples of one mesh, all counts multiplied by the same number,
//! with two formulations of the elements. `mesh_limit 4` goes to the fourth multiple (default: the third, in minutes).
#![expect(clippy::print_stdout, reason = "an example prints")]
use brake_reuss_beam::mesh::Refinement;
use brake_reuss_beam::{BrakeReussBenchmark, benchmark, published};
use joint_pipeline::analysis::Prepared;
use joint_pipeline::joint::benchmark::{MeshSettings, Symmetry};
use joint_pipeline::progress::Silent;
use joint_pipeline::structure::Structure;
use joint_pipeline::{Options, Scene};
use std::error::Error;
use substructure::elements::Formulation;

fn main() -> Result<(), Box<dyn Error>> {
    let multiples = std::env::args().nth(1).map_or(Ok(3_u8), |text| text.parse())?;
    let mut scene = Scene::of(&BrakeReussBenchmark, "mesh limit")?;
    scene.model.symmetry = Symmetry::Half;
    scene.cqsma.amplitudes = 0;
    println!("multiple  interface elements  C3D8I [Hz]  C3D8R [Hz]");
    for multiple in 1..=multiples {
        let refinement = Refinement::unit().scaled(f64::from(multiple))?;
        let mut frequencies = [0.0; 2];
        for (frequency, hexahedra) in frequencies
            .iter_mut()
            .zip([Formulation::IncompatibleModes, Formulation::Reduced])
        {
            let settings = MeshSettings {
                refinement: scene.model.refinement,
                arm_layers: None,
                symmetry: Symmetry::Half,
                hexahedra,
                material: published::steel(),
            };
            let joint = benchmark::joint(&refinement, &settings)?;
            let structure = Structure::from_joint(&scene.model, scene.bolts.behaviour, joint);
            let run = Prepared::try_new(&scene, &structure, &Options::default(), &Silent)?.solve(&Silent)?;
            *frequency = run.frequencies[0];
        }
        let [stiff, soft] = frequencies;
        println!(
            "{multiple:>8} {:>19} {stiff:>11.4} {soft:>11.4}",
            refinement.interface_elements()
        );
    }
    Ok(())
}
