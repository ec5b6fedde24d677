//! Tables against the curves they are made from.

use super::{STEEL, asperities, elastic, fitted, measured_population, relative, table};
use crate::*;

fn sweep(range: [f64; 2], n: u32) -> impl Iterator<Item = f64> {
    (0..=n).map(move |i| range[0] * (range[1] / range[0]).powf(f64::from(i) / f64::from(n)))
}

#[test]
fn the_measured_error_holds_between_the_knots() {
    let (table, exact) = (table(), asperities(TangentialReading::Mindlin));
    let mut worst = [0.0_f64; 4];
    for u in sweep([1e-8, 3e-5], 100_003) {
        let (t, k) = (table.normal(u), table.tangential(u));
        let (t_exact, k_exact) = (exact.normal(u), exact.tangential(u));
        let errors = [
            relative(t.0, t_exact.0),
            relative(k[0].value, k_exact[0].value),
            relative(t.1, t_exact.1),
            relative(k[1].slope, k_exact[1].slope),
        ];
        worst = std::array::from_fn(|i| worst[i].max(errors[i]));
    }
    println!(
        "{} knots: measured {:.1e}, {:.1e}; sweep {:.1e}, {:.1e}; slopes {:.1e}, {:.1e}",
        table.n_knots(),
        table.max_relative_error_normal(),
        table.max_relative_error_tangential(),
        worst[0],
        worst[1],
        worst[2],
        worst[3],
    );
    // The stored error is relative to the upper knot of a cell, here within one part in four of the value.
    assert!(worst[0] <= 1.5 * table.max_relative_error_normal() && table.max_relative_error_normal() <= 1e-5);
    assert!(worst[1] <= 1.5 * table.max_relative_error_tangential() && table.max_relative_error_tangential() <= 1e-4);
    assert!(worst[2] < 1e-3 && worst[3] < 5e-2);
    let [lower, upper] = table.range();
    assert!(lower == 1e-8 && (3e-5..6e-5).contains(&upper));
}

/// For a smooth curve the error falls with the fourth power of the knot distance.
#[test]
fn smooth_curves_converge_with_fourth_order() {
    let single = AsperityPopulation::try_new(GapDistribution::try_from_samples(vec![0.0]).unwrap(), 1e6, [1e-3; 2]);
    let curves = AsperitySumCurves::try_new(single.unwrap(), STEEL, TangentialReading::Mindlin).unwrap();
    let error = |knots: u32| {
        let options = TableOptions {
            tolerance_normal: 1e-20,
            tolerance_tangential: 1.0,
            max_knots_per_octave: knots,
        };
        match Tabulated::try_new(curves.clone(), [1e-8, 1e-5], options) {
            Err(Error::Tolerance {
                error,
                knots_per_octave,
                ..
            }) if knots_per_octave == knots => error,
            other => panic!("{other:?}"),
        }
    };
    let ratio = error(8) / error(16);
    assert!((13.0..18.0).contains(&ratio), "{ratio}");
}

/// Steps of one part in 1e13 across knots, octaves and both ends.
#[test]
fn tables_are_smooth_and_rise_everywhere() {
    let table = table();
    let [lower, upper] = table.range();
    let mut before = (0.0, 0.0, 0.0);
    for u in sweep([1e-11, 1e-2], 200_001) {
        let ((t, slope), [x, _]) = (table.normal(u), table.tangential(u));
        assert!(
            t > before.0 && x.value >= before.1 && slope >= 0.0 && x.slope >= 0.0,
            "{u:e}"
        );
        before = (t, x.value, u);
    }
    for knot in [lower, 1.25 * lower, 2.0 * lower, 1024.0 * lower, 1536.0 * lower, upper] {
        let [a, b] = [knot * (1.0 - 1e-13), knot * (1.0 + 1e-13)].map(|u| (table.normal(u), table.tangential(u)[0]));
        assert!(
            relative(a.0.0, b.0.0) < 1e-11 && relative(a.0.1, b.0.1) < 1e-11,
            "{knot:e}"
        );
        assert!(
            relative(a.1.value, b.1.value) < 1e-11 && relative(a.1.slope, b.1.slope) < 1e-10,
            "{knot:e}"
        );
    }
}

/// Slopes and curvatures are those of the interpolant, not of the source.
#[test]
fn derivatives_are_those_of_the_interpolant() {
    let table = table();
    let (mut n, mut near_knots) = (0, 0);
    for u in sweep([1e-10, 1e-3], 10_007) {
        let h = 1e-5 * u;
        let (low, here, high) = (table.normal(u - h), table.normal(u), table.normal(u + h));
        let [x_low, x, x_high] = [u - h, u, u + h].map(|u| table.tangential(u)[0]);
        let errors = [
            ((high.0 - low.0) / (2.0 * h) - here.1) * u / here.0,
            ((x_high.value - x_low.value) / (2.0 * h) - x.slope) * u / x.value,
            ((x_high.slope - x_low.slope) / (2.0 * h) - x.curvature) * u * u / x.value,
        ];
        n += 1;
        if errors.iter().any(|e| e.abs() > 2e-8) {
            near_knots += 1;
        }
    }
    // Two steps of 1e-5 reach over a knot in about 64 cases of 1e5 where there are 64 knots per octave.
    assert!(near_knots * 100 < n, "{near_knots} of {n}");
}

/// Below the table the source's own power law goes on; above, the last slope.
#[test]
fn limits_outside_the_table() {
    let (table, exact) = (table(), asperities(TangentialReading::Mindlin));
    for u in [1e-12, 1e-10, 9e-9] {
        assert!(relative(table.normal(u).0, exact.normal(u).0) < 1e-2, "{u:e}");
        assert!(relative(table.tangential(u)[0].value, exact.tangential(u)[0].value) < 1e-2);
    }
    let log_slope = |u: f64| table.normal(u).1 * u / table.normal(u).0;
    assert!(relative(log_slope(1e-3), log_slope(1e-2)) < 1e-12);

    let single = AsperityPopulation::try_new(GapDistribution::try_from_samples(vec![0.0]).unwrap(), 1e6, [1e-3; 2]);
    let hertz = AsperitySumCurves::try_new(single.unwrap(), STEEL, TangentialReading::Mindlin).unwrap();
    let table = Tabulated::try_new(hertz.clone(), [1e-8, 1e-5], TableOptions::default()).unwrap();
    for u in [1e-14, 1e-9, 1e-4, 1e-2] {
        assert!(relative(table.normal(u).0, hertz.normal(u).0) < 1e-3, "{u:e}");
        assert!(
            relative(table.tangential(u)[0].value, hertz.tangential(u)[0].value) < 1e-2,
            "{u:e}"
        );
    }
}

/// Straight lines and constants are tabulated exactly, fits to the tolerance.
#[test]
fn tables_of_other_curves() {
    let line = Tabulated::try_new(elastic(), [1e-9, 1e-5], TableOptions::default()).unwrap();
    for u in sweep([1e-12, 1e-3], 1000) {
        assert!(relative(line.normal(u).0, elastic().normal(u).0) < 1e-13);
        assert!(relative(line.tangential(u)[1].value, elastic().tangential(u)[1].value) < 1e-13);
    }
    let smooth = Tabulated::try_new(fitted(), [2e-7, 9e-6], TableOptions::default()).unwrap();
    for u in sweep([2e-7, 9e-6], 1000) {
        assert!(relative(smooth.normal(u).0, fitted().normal(u).0) < 1.5e-5);
    }
}

/// Contact that begins above zero interference, from samples: zero below, nothing negative, and the published
/// stiffness, which jumps, is refused rather than smeared.
#[test]
fn curves_that_begin_at_zero() {
    let samples: Vec<f64> = (0..40).map(|i| 1e-6 * (1.0 + f64::from(i).sqrt())).collect();
    let gaps = GapDistribution::try_from_samples(samples).unwrap();
    let population = AsperityPopulation::try_new(gaps, 1e6, [1e-3; 2]).unwrap();
    let curves = |reading| AsperitySumCurves::try_new(population.clone(), STEEL, reading).unwrap();
    let options = TableOptions {
        tolerance_normal: 0.1,
        tolerance_tangential: 0.9,
        max_knots_per_octave: 4096,
    };
    let table = Tabulated::try_new(curves(TangentialReading::Mindlin), [1e-8, 1e-5], options).unwrap();
    assert_eq!(table.normal(5e-9), (0.0, 0.0));
    assert_eq!(table.tangential(5e-9)[0].value, 0.0);
    assert_eq!(table.normal(0.9e-6).0, 0.0);
    for u in sweep([1e-8, 1e-5], 20_000) {
        assert!(table.normal(u).0 >= 0.0 && table.tangential(u)[0].value >= 0.0);
    }
    let options = TableOptions {
        max_knots_per_octave: 64,
        ..TableOptions::default()
    };
    let text = Tabulated::try_new(curves(TangentialReading::Paper), [1e-8, 1e-5], options)
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("64 knots per octave") && text.contains("raise the tolerance"),
        "{text}"
    );
}

/// Just above a sample the stiffness rises almost vertically; a table with a knot there still rises everywhere.
#[test]
fn steep_knots_do_not_make_a_table_fall() {
    let below = |knot: f64| knot * (1.0 - 1e-9);
    let samples = vec![0.0, below(1.25e-6), below(1.5e-6), below(2.5e-6), below(4e-6)];
    let gaps = GapDistribution::try_from_samples(samples).unwrap();
    let population = AsperityPopulation::try_new(gaps, 1e6, [1e-3; 2]).unwrap();
    let curves = AsperitySumCurves::try_new(population, STEEL, TangentialReading::Mindlin).unwrap();
    let steepest = curves.tangential(2.5e-6)[0];
    assert!(steepest.slope * 2.5e-6 > 1e3 * steepest.value);
    let options = TableOptions {
        tolerance_normal: 0.5,
        tolerance_tangential: 0.5,
        max_knots_per_octave: 4,
    };
    let table = Tabulated::try_new(curves, [1e-6, 8e-6], options).unwrap();
    let mut before = 0.0;
    for u in sweep([1e-6, 8e-6], 20_000) {
        let k = table.tangential(u)[0];
        assert!(
            k.value >= before * (1.0 - 1e-14) && k.slope >= -1e-12 * k.value / u,
            "{u:e}"
        );
        before = k.value;
    }
}

/// The same table in millimetres, tonnes and seconds (Pa become MPa) gives the same numbers.
#[test]
fn tables_do_not_depend_on_the_unit() {
    let make = |length: f64, pressure: f64| {
        let n = 50;
        let probabilities: Vec<f64> = (0..=n).map(|i| f64::from(i) / f64::from(n)).collect();
        let values: Vec<f64> = probabilities.iter().map(|p| 2e-5 * length * p.sqrt()).collect();
        let gaps = GapDistribution::try_from_quantiles(&probabilities, &values).unwrap();
        let population = AsperityPopulation::try_new(gaps, 1e6 / (length * length), [1e-3 * length; 2]).unwrap();
        let material = ElasticPair {
            youngs_modulus: 192.85e9 * pressure,
            poisson_ratio: 0.29,
        };
        let curves = AsperitySumCurves::try_new(population, material, TangentialReading::Mindlin).unwrap();
        Tabulated::try_new(curves, [1e-8 * length, 3e-5 * length], TableOptions::default()).unwrap()
    };
    let (si, mm) = (make(1.0, 1.0), make(1e3, 1e-6));
    assert_eq!(si.n_knots(), mm.n_knots());
    for u in sweep([1e-9, 1e-3], 997) {
        assert!(relative(si.normal(u).0, mm.normal(1e3 * u).0 * 1e6) < 1e-11, "{u:e}");
        assert!(
            relative(si.tangential(u)[0].value, mm.tangential(1e3 * u)[0].value * 1e9) < 1e-11,
            "{u:e}"
        );
    }
}

/// The measured population of a real interface.
#[test]
fn the_measured_surface_meets_the_default_tolerances() {
    let Some(population) = measured_population() else {
        return;
    };
    let curves = AsperitySumCurves::try_new(population, STEEL, TangentialReading::Mindlin).unwrap();
    let table = Tabulated::try_new(curves.clone(), [1e-8, 1e-4], TableOptions::default()).unwrap();
    println!(
        "{} knots, errors {:.1e} and {:.1e}",
        table.n_knots(),
        table.max_relative_error_normal(),
        table.max_relative_error_tangential()
    );
    for u in [1e-6, 3e-6, 5e-6, 8e-6] {
        let (t, k) = (curves.normal(u), curves.tangential(u)[0].value);
        let area = curves.contact_area_ratio(u).unwrap();
        println!(
            "u_n = {u:.0e} m: t_n = {:.4e} Pa, k_n = {:.4e}, k_t = {k:.4e} Pa/m, area {area:.2e}",
            t.0, t.1
        );
    }
    let paper = curves.population().clone();
    let paper = AsperitySumCurves::try_new(paper, STEEL, TangentialReading::Paper).unwrap();
    let paper = Tabulated::try_new(paper, [1e-8, 1e-4], TableOptions::default()).unwrap();
    println!(
        "as published: {} knots, error {:.1e}",
        paper.n_knots(),
        paper.max_relative_error_tangential()
    );
    assert!(table.n_knots() < 20_000 && paper.n_knots() < 20_000);
}

/// Curves of a scaled population are those of the population with interferences and values scaled; so are its table and its fit.
#[test]
fn scaled_curves_are_those_of_scaled_populations() {
    let material = ElasticPair {
        youngs_modulus: 70e9,
        poisson_ratio: 0.33,
    };
    for reading in [TangentialReading::Mindlin, TangentialReading::Paper] {
        let source = asperities(reading);
        let population = source.population().scaled(1.7, 0.4, 2.5).unwrap();
        assert_eq!(population.density(), 0.4 * source.population().density());
        assert!(
            relative(
                population.effective_radius(),
                2.5 * source.population().effective_radius()
            ) < 1e-15
        );
        let scaled = AsperitySumCurves::try_new(population, material, reading).unwrap();
        let factors = source.factors_to(&scaled, 1.7);
        let tabulated = Tabulated::try_new(
            source.clone(),
            [1e-8, 3e-5],
            TableOptions {
                tolerance_tangential: 1e-1,
                ..TableOptions::default()
            },
        );
        let table = tabulated.unwrap().scaled(scaled.clone(), factors).unwrap();
        let (fit, wide) = (fitted(), fitted().scaled(factors).unwrap());
        for u in sweep([1e-9, 1e-4], 1000) {
            let from_source = factors.normal * source.normal(u / 1.7).0;
            assert!(relative(scaled.normal(u).0, from_source) < 1e-13, "{u}");
            let k = factors.tangential[1] * source.tangential(u / 1.7)[1].value;
            assert!(relative(scaled.tangential(u)[1].value, k) < 1e-13);
            assert!(relative(wide.normal(u).0, factors.normal * fit.normal(u / 1.7).0) < 1e-12);
            let k = factors.tangential[0] * fit.tangential(u / 1.7)[0].value;
            assert!(relative(wide.tangential(u)[0].value, k) < 1e-12);
            if (2e-8..4e-5).contains(&u) {
                assert!(relative(table.normal(u).0, scaled.normal(u).0) < 2e-5, "{u}");
                assert!(relative(table.normal(u).1, scaled.normal(u).1) < 1e-2, "{u}");
            }
        }
        let [lower, upper] = table.range();
        assert!(relative(lower, 1.7e-8) < 1e-15 && upper > 5e-5);
    }
    let source = asperities(TangentialReading::Mindlin);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(source.population().scaled(bad, 1.0, 1.0).is_err());
        assert!(source.population().scaled(1.0, bad, 1.0).is_err());
        assert!(source.population().scaled(1.0, 1.0, bad).is_err());
        assert!(
            fitted()
                .scaled(CurveFactors {
                    interference: bad,
                    normal: 1.0,
                    tangential: [1.0; 2]
                })
                .is_err()
        );
    }
}
