//! One point of a rough joint: pressed together, then sheared through a cycle with a commit at each reversal.
#![allow(clippy::print_stdout)]

use contact_laws::*;

fn main() -> Result<(), Error> {
    // Quantiles of the asperity gaps at first touch; 1.4 asperities per mm^2, radius 1.4 mm, steel, mu = 0.2.
    let gaps = GapDistribution::try_from_quantiles(&[0.0, 0.1, 0.5, 1.0], &[0.0, 8e-6, 14e-6, 28e-6])?;
    let population = AsperityPopulation::try_new(gaps, 1.4e6, [1.4e-3; 2])?;
    let curves = AsperitySumCurves::try_new(population, ElasticPair::new(192.85e9, 0.29), TangentialReading::Mindlin)?;
    let table = Tabulated::try_new(curves, [1e-8, 1e-4], TableOptions::default())?;
    let (curves, mu) = (PointParameters::uniform(table, 1), PointParameters::uniform(0.2, 1));
    let law = TableLaw::try_new(curves, mu, HistoryRule::Incremental)?;

    // u_x, u_y, u_n, t_x, t_y of the point committed last.
    let (mut begin, mut end) = ([0.0, 0.0, 5e-6, 0.0, 0.0], [0.0; 5]);
    for (from, to) in [(0.0, 8e-7), (8e-7, -8e-7), (-8e-7, 8e-7)] {
        for step in 1..=8 {
            let (u_x, [mut t_x, mut t_y, mut t_n]) = (from + (to - from) * f64::from(step) / 8.0, [[0.0]; 3]);
            let counts = law.evaluate(
                0..1,
                Sticking::Coulomb,
                Components::new(&[u_x], &[0.0], &[5e-6]),
                StateView::new(&begin, 1, 0),
                StateViewMut::new(&mut end, 1, 0),
                ComponentsMut::new(&mut t_x, &mut t_y, &mut t_n),
                None,
                None,
            );
            println!(
                "u_x {u_x:9.1e} m   t_x {:10.3e} Pa   {}",
                t_x[0],
                if counts.slip == 1 { "slip" } else { "stick" }
            );
        }
        begin = end;
    }
    Ok(())
}
