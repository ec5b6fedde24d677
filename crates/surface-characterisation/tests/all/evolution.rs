//! Rank correlations against published and independent figures, and what the spatial test is worth.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use contact_laws::ElasticPair;
use surface_characterisation::{
    CorrelationOptions, ElementField, ElementOutlines, Options, SurfaceError, SyntheticFace, benjamini_hochberg,
    changes, characterise, correlate, p_as89, p_student, spearman,
};

#[test]
fn figures_of_an_independent_program() {
    // SciPy 1.x: spearmanr with ties, false_discovery_control, Student tails.
    let x = [2.1, 3.3, 3.3, 0.5, 9.0, 7.7, 5.5, 3.3, 8.1, 1.2, 6.6, 6.6];
    let y = [1.0, 4.0, 2.0, 2.0, 8.0, 9.0, 3.0, 5.0, 7.0, 2.0, 6.0, 0.0];
    let (n, rho) = spearman(&x, &y).unwrap();
    assert_eq!(n, 12);
    assert!((rho - 0.6749566597320119).abs() < 1e-14);
    assert!((p_student(rho, n).unwrap() - 0.01603282705936336).abs() < 1e-12);
    for (rho, n, p) in [
        (0.6, 10, 0.06668799999999998),
        (0.99, 40, 6.187916776321287e-34),
        (0.05, 1000, 0.11407259555107296),
    ] {
        assert!((p_student(rho, n).unwrap() / p - 1.0).abs() < 1e-9, "{rho} {n}");
    }
    assert!((p_student(-0.6, 10).unwrap() - p_student(0.6, 10).unwrap()).abs() < 1e-15);
    assert_eq!((p_student(1.0, 10), p_student(0.0, 10)), (Ok(0.0), Ok(1.0)));
    for (found, expected) in benjamini_hochberg(&[0.01, 0.04, 0.03, 0.005, 0.5, 0.2])
        .iter()
        .zip([0.03, 0.06, 0.06, 0.03, 0.5, 0.24])
    {
        assert!((found - expected).abs() < 1e-15);
    }
    // Pairs with a gap are left out.
    let (mut x_gap, mut y_gap) = (x.to_vec(), y.to_vec());
    x_gap.insert(3, f64::NAN);
    y_gap.insert(3, 99.0);
    assert_eq!(spearman(&x_gap, &y_gap), Some((12, rho)));
    assert_eq!(spearman(&x, &[1.0; 12]), None);
    assert_eq!(spearman(&x[..2], &y[..2]), None);
}

#[test]
fn exact_tails_of_few_pairs() {
    // 2/5! for perfect order; 10 of 120 orders have |rho| >= 0.9; tables of critical values: 0.648 at 5 % for 10.
    assert!((p_as89(1.0, 5).unwrap() - 2.0 / 120.0).abs() < 1e-15);
    assert!((p_as89(-0.9, 5).unwrap() - 10.0 / 120.0).abs() < 1e-15);
    assert!(p_as89(0.648, 10).unwrap() <= 0.05 && p_as89(0.636, 10).unwrap() > 0.05);
    assert_eq!(p_as89(0.0, 7), Ok(1.0));
    assert!(matches!(
        p_as89(1.1, 5),
        Err(SurfaceError::InvalidValue { field: "rho", .. })
    ));
    assert!(p_as89(0.5, 2).is_err() && p_student(f64::NAN, 9).is_err());
}

#[test]
fn the_published_table_at_588_elements() {
    let Some(published) = test_support::reference_file("published.json") else {
        return;
    };
    let text = std::fs::read_to_string(published).unwrap();
    let published: serde_json::Value = serde_json::from_str(&text).unwrap();
    let table = &published["paper_2020"]["table2"];
    let n = table["n_inferred"].as_u64().unwrap() as usize;
    let entries = |name: &str| -> Vec<f64> {
        let rows = table[name].as_array().unwrap();
        rows.iter()
            .flat_map(|r| r.as_array().unwrap())
            .map(|v| v.as_f64().unwrap())
            .collect()
    };
    let (rho, p) = (entries("rho"), entries("p"));
    assert_eq!((n, rho.len(), p.len()), (588, 24, 24));
    let mut largest: [f64; 2] = [0.0; 2];
    for (rho, p) in rho.iter().zip(&p) {
        // rho and p are printed with four digits: p must lie between those of the bounds of rho.
        let [most, least] = [-5e-5, 5e-5].map(|d| p_as89(rho.abs() + d, n).unwrap());
        assert!(
            (least - 5e-5..=most + 5e-5).contains(p),
            "rho {rho}: {p} not in {least} to {most}"
        );
        largest[0] = largest[0].max((p_as89(*rho, n).unwrap() - p).abs());
        largest[1] = largest[1].max((p_student(*rho, n).unwrap() - p).abs());
    }
    println!(
        "largest difference from the printed p: AS 89 {:.1e}, t {:.1e}",
        largest[0], largest[1]
    );
    // Of all of them two survive the adjustment for 24 pairs.
    let computed: Vec<f64> = rho.iter().map(|r| p_as89(*r, n).unwrap()).collect();
    let survivors: Vec<f64> = benjamini_hochberg(&computed)
        .into_iter()
        .zip(&p)
        .filter(|(q, _)| *q <= 0.05)
        .map(|(_, p)| *p)
        .collect();
    assert_eq!(survivors, [0.0002, 0.0002]);
}

/// 21 x 9 elements on 105 mm x 27 mm.
fn elements() -> ElementOutlines {
    let nodes = (0..220)
        .map(|k| [f64::from(k % 22) * 5e-3, f64::from(k / 22) * 3e-3])
        .collect();
    let quads = (0..189u32)
        .map(|e| {
            let a = e / 21 * 22 + e % 21;
            vec![a, a + 1, a + 23, a + 22]
        })
        .collect();
    ElementOutlines::try_new(nodes, quads).unwrap()
}

/// A Gaussian field with a correlation length of `length` (m), at the middles of the elements.
fn field(name: &str, seed: u64, length: f64) -> ElementField {
    let outlines = elements();
    let map = SyntheticFace {
        points: [211, 55],
        step: [0.5e-3; 2],
        origin: [0.0; 2],
        rms: 1.0,
        correlation_length: [length; 2],
        waviness: vec![],
        tilt: [0.0; 2],
        height_step: None,
        seed,
    }
    .generate(|_| false)
    .unwrap();
    let at = |e: usize| {
        let [x, y] = outlines.middle(e);
        map.height((x / 0.5e-3).round() as usize, (y / 0.5e-3).round() as usize)
            .unwrap()
    };
    ElementField {
        name: name.to_owned(),
        unit: "1".to_owned(),
        values: (0..outlines.len()).map(at).collect(),
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_shifts_keep_their_level_where_independence_does_not() {
    let options = CorrelationOptions {
        shifts: 199,
        ..CorrelationOptions::default()
    };
    let outlines = elements();
    let rejected = |length: f64| {
        let pairs = 200;
        let (mut independent, mut spatial) = (0, 0);
        for k in 0..pairs {
            let (x, y) = (field("x", 2 * k, length), field("y", 2 * k + 1, length));
            let found = correlate(&[x], &[y], &outlines, options).unwrap();
            independent += usize::from(found.correlations[0].p_as89 <= 0.05);
            spatial += usize::from(found.correlations[0].p_spatial.unwrap() <= 0.05);
        }
        [independent, spatial].map(|n| n as f64 / pairs as f64)
    };
    // Fields that know nothing of each other; 200 pairs put 5 % at 2 to 8 %.
    let [independent, spatial] = rejected(1e-3);
    println!("1 mm: {independent} by AS 89, {spatial} by shifts");
    assert!((0.01..0.1).contains(&independent) && (0.01..0.1).contains(&spatial));
    let [independent, spatial] = rejected(10e-3);
    println!("10 mm: {independent} by AS 89, {spatial} by shifts");
    assert!(independent > 0.25, "{independent}");
    assert!(spatial < 0.12, "{spatial}");
}

#[test]
fn what_is_there_is_found_and_what_is_not_is_said() {
    let outlines = elements();
    let (pressure, noise) = (field("pressure", 1, 6e-3), field("noise", 2, 6e-3));
    let mut worn = field("change of R_t", 3, 6e-3);
    for (w, p) in worn.values.iter_mut().zip(&pressure.values) {
        *w -= 2.0 * p;
    }
    worn.values[7] = f64::NAN;
    let options = CorrelationOptions::default();
    let found = correlate(std::slice::from_ref(&worn), &[pressure, noise], &outlines, options).unwrap();
    println!("{found}");
    assert_eq!(found.correlations[0].n, 188);
    assert!(found.correlations[0].rho < -0.8);
    assert_eq!(found.correlations[0].significant(0.05), (true, Some(true)));
    assert_eq!(found.correlations[1].significant(0.05).1, Some(false));
    assert!(
        found
            .to_string()
            .contains("Significant at 0.05 after adjustment for 2 pairs: change of R_t against pressure.")
    );

    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (x, y) = (field("x", 12, 1e-3), field("y", 13, 1e-3));
        pool.install(|| correlate(&[x], &[y], &outlines, options).unwrap())
    };
    let nothing = run(1);
    assert_eq!(nothing, run(2));
    assert!(
        nothing
            .to_string()
            .contains("Nothing is significant at 0.05 after adjustment for 1 pairs."),
        "{nothing}"
    );

    let flat = ElementField {
        name: "flux".to_owned(),
        unit: "J/m^2".to_owned(),
        values: vec![0.0; 189],
    };
    let error = correlate(std::slice::from_ref(&worn), &[flat], &outlines, options).unwrap_err();
    assert!(error.to_string().contains("change of R_t against flux"), "{error}");
    let short = ElementField {
        values: vec![0.0; 3],
        ..worn.clone()
    };
    assert!(matches!(
        correlate(&[worn], &[short], &outlines, options),
        Err(SurfaceError::LengthMismatch { .. })
    ));
}

#[test]
fn changes_are_after_minus_before() {
    let nodes = (0..12)
        .map(|k| [f64::from(k % 4) * 1.5e-3, f64::from(k / 4) * 3e-3])
        .collect();
    let quads = [0u32, 1, 2, 4, 5, 6]
        .into_iter()
        .map(|a| vec![a, a + 1, a + 5, a + 4])
        .collect();
    let elements = ElementOutlines::try_new(nodes, quads).unwrap();
    let face = |seed, rms| {
        SyntheticFace {
            points: [150, 120],
            step: [30e-6, 50e-6],
            origin: [15e-6, 25e-6],
            rms,
            correlation_length: [120e-6, 150e-6],
            waviness: vec![],
            tilt: [0.0; 2],
            height_step: None,
            seed,
        }
        .generate(|_| false)
        .unwrap()
    };
    let options = Options::new(ElasticPair {
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
    });
    let state = |rms| characterise(&face(1, rms), &face(2, rms), &elements, &options).unwrap();
    let (before, after) = (state(1e-6), state(0.5e-6));
    let [roughness, radius_x, radius_y, count] = changes(&before, &after).unwrap();
    // Half as high everywhere: half the roughness and twice the radii, so as many asperities in the packing.
    for e in 0..6 {
        let was = &before.elements[e];
        assert!((roughness.values[e] / (-0.5 * was.total_roughness()) - 1.0).abs() < 1e-9);
        assert!((radius_x.values[e] / was.population.radius()[0] - 1.0).abs() < 1e-9);
        assert!((radius_y.values[e] / was.population.radius()[1] - 1.0).abs() < 1e-9);
        assert!(count.values[e].abs() < 1e-2 * was.population.count());
    }
    let mut fewer = after;
    fewer.elements.pop();
    assert!(matches!(
        changes(&before, &fewer),
        Err(SurfaceError::LengthMismatch {
            expected: 6,
            found: 5,
            ..
        })
    ));
}
