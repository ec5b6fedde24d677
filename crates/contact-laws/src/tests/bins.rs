//! The errors of bins on a measured surface: the table of the documentation.

use super::reference;
use crate::*;

/// Errors in the order of the table: normal traction, tangential stiffness, energy from 0.1 and from 0.01 of gross slip.
fn errors(bins: &[AsperityBins], finest: &AsperityBins, reach: f64) -> [f64; 4] {
    let [normal, tangential, energy] = AsperityBins::errors(bins, finest, reach, 0.1);
    let [_, _, small] = AsperityBins::errors(bins, finest, reach, 0.01);
    [normal, tangential, energy, small]
}

#[test]
fn few_gauss_bins_do_what_many_equally_spaced_ones_do() {
    let Some(data) = reference("brb_surface.json") else {
        return;
    };
    let number = |name: &str| data[name].as_f64().unwrap();
    let values = data["asperity_gap_quantiles"]["values"].as_array().unwrap();
    let values: Vec<f64> = values.iter().map(|value| value.as_f64().unwrap()).collect();
    let probabilities: Vec<f64> = (0..values.len())
        .map(|i| i as f64 / (values.len() - 1) as f64)
        .collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, &values).unwrap();
    let radius = number("effective_radius");
    let population = AsperityPopulation::try_new(gaps, number("asperities_per_area"), [radius; 2]).unwrap();
    let asperity = Asperity::try_new(ElasticPair::new(192.31e9, 0.3), radius, None).unwrap();

    let reach = 18e-6;
    let gauss_up_to = |reach, n, shifts: &[f64]| AsperityBins::gauss(asperity, &population, n, reach, shifts).unwrap();
    let gauss = |n, shifts: &[f64]| gauss_up_to(reach, n, shifts);
    let finest = &gauss(1000, &[0.0])[0];
    let shifts: Vec<f64> = (0..16).map(|i| f64::from(i) / 16.0).collect();
    let spaced = AsperityBins::equally_spaced(asperity, &population, 101).unwrap();
    for (name, bins, stated) in [
        ("8", gauss(8, &shifts), [6.0e-5, 8.7e-5, 3.0e-3, 8.2e-3]),
        ("12", gauss(12, &shifts), [1.4e-5, 2.4e-5, 7.0e-4, 4.8e-3]),
        ("16", gauss(16, &shifts), [4.6e-6, 1.5e-5, 1.5e-4, 3.4e-3]),
        ("101 equally spaced", vec![spaced], [3.2e-4, 1.3e-4, 2.2e-4, 3.6e-3]),
    ] {
        let found = errors(&bins, finest, reach);
        println!("{name}: {}", found.map(|e| format!("{e:.1e}")).join(" "));
        for (found, stated) in found.into_iter().zip(stated) {
            assert!(found <= stated && found > 0.5 * stated, "{name}: {found:e} {stated:e}");
        }
    }

    // The reach is found by a solver: what it rounds to must not choose a number of bins.
    let expected = errors(&gauss(12, &shifts), finest, reach);
    for ulps in 1..=20 {
        let reach = f64::from_bits(reach.to_bits() + ulps);
        let finest = &gauss_up_to(reach, 1000, &[0.0])[0];
        let found = errors(&gauss_up_to(reach, 12, &shifts), finest, reach);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-9, "{ulps}: {found:e} {expected:e}");
        }
    }
}
