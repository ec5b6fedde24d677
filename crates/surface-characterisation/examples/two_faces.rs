//! Two synthetic faces, characterised over four elements.
#![allow(clippy::print_stdout)]

use contact_laws::ElasticPair;
use surface_characterisation::{ElementOutlines, Options, SyntheticFace, characterise};

fn main() -> Result<(), surface_characterisation::SurfaceError> {
    let face = |seed| SyntheticFace {
        points: [330, 100],
        step: [30e-6, 50e-6],
        origin: [0.0, 0.0],
        rms: 1.5e-6,
        correlation_length: [120e-6, 150e-6],
        waviness: vec![],
        tilt: [1e-4, -2e-4],
        height_step: Some(0.5e-6),
        seed,
    };
    let (top, bottom) = (face(1).generate(|_| false)?, face(2).generate(|_| false)?);

    // Four elements of 2.4 mm x 4.8 mm in a row.
    let nodes = (0..10)
        .map(|k| [f64::from(k % 5) * 2.4e-3, f64::from(k / 5) * 4.8e-3])
        .collect();
    let quads = (0..4).map(|e| vec![e, e + 1, e + 6, e + 5]).collect();
    let elements = ElementOutlines::try_new(nodes, quads)?;

    let steel = ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    };
    let surface = characterise(&top, &bottom, &elements, &Options::new(steel))?;
    for e in &surface.elements {
        let (radius, density) = (e.population.effective_radius(), e.population.asperity_density());
        println!("{radius:.3e} m, {density:.3e} asperities/m^2, {:?}", e.normal);
    }
    println!("{:?}", surface.summary());
    Ok(())
}
