//! The published figures carried in code against the reference files, where those are at hand.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]
use brake_reuss_beam::published::*;
use serde_json::Value;

/// Content of a reference file, where there is one.
fn reference(file: &str) -> Option<Value> {
    let text = std::fs::read_to_string(test_support::reference_file(file)?).unwrap();
    Some(serde_json::from_str(&text).unwrap())
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        Value::Number(number) => vec![number.as_f64().unwrap()],
        other => panic!("{other} is not numeric"),
    }
}

fn same(ours: &[f64], theirs: &Value) {
    let theirs = numbers(theirs);
    assert_eq!(ours.len(), theirs.len());
    for (a, b) in ours.iter().zip(&theirs) {
        assert!((a - b).abs() <= 1e-14 * b.abs(), "{a} instead of {b}");
    }
}

#[test]
fn tables_agree_with_the_reference() {
    let Some(data) = reference("published.json") else {
        return;
    };
    let paper = &data["paper_2020"];
    let table = &paper["table1_frequency_hz"];
    same(
        &[FIRST_FREQUENCY.topography_per_element],
        &table["topography_per_element"],
    );
    same(&[FIRST_FREQUENCY.flat_per_element], &table["flat_per_element"]);
    same(&[FIRST_FREQUENCY.flat_uniform], &table["flat_uniform"]);
    same(&[FIRST_FREQUENCY.measured], &table["measured"]);
    same(&LINEARISED_FREQUENCIES, &paper["table3_hz"]["free"]);
    let column = |pick: fn(&BoltStrainRow) -> f64| BOLT_STRAIN_TABLE.iter().map(pick).collect::<Vec<_>>();
    let table = &paper["table4"];
    same(&column(|r| r.bolt_strain * 1e6), &table["bolt_strain_microstrain"]);
    same(&column(|r| r.topography_frequency), &table["topography_hz"]);
    same(
        &column(|r| r.topography_contact * 100.0),
        &table["topography_contact_pct"],
    );
    same(&column(|r| r.flat_frequency), &table["flat_hz"]);
    same(&column(|r| r.flat_contact * 100.0), &table["flat_contact_pct"]);
    same(&[BOLT_TENSION_PER_STRAIN], &paper["bolt_force_per_strain_n"]);
    same(&[BOLT_TENSION], &paper["bolt_load_n"]);
    same(&[PAPER_MASS], &paper["mass_kg"]);
    same(&[LOW_AMPLITUDE_DAMPING], &paper["low_amplitude_damping_about"]);
    same(&EVOLUTION_RHO.concat(), &paper["table2"]["rho"]);
    same(&EVOLUTION_P.concat(), &paper["table2"]["p"]);
    same(&[INTERFACE_ELEMENTS as f64], &paper["table2"]["n_inferred"]);
    same(&[ADHESION.hardness_coefficient], &paper["K_eq45"]);
    same(&[ADHESION.composite_modulus], &paper["E_star"]);
    same(&[ADHESION.hardness], &paper["hardness"]);
    same(&[ADHESION.intermolecular_distance], &paper["intermolecular_m"]);
    same(&[ADHESION.work_of_adhesion], &paper["work_of_adhesion"]);
    same(&[PENDULUM_STIFFNESS], &paper["pendulum_stiffness_n_per_m"]);
    let steel = steel();
    same(&[steel.youngs_modulus], &paper["E"]);
    same(&[steel.poisson_ratio], &paper["nu"]);
    same(&[steel.density], &paper["rho"]);

    let tutorial = &data["abaqus_tutorial"];
    same(&TUTORIAL_FREQUENCIES.unstressed, &tutorial["unstressed_hz"]);
    same(
        &TUTORIAL_FREQUENCIES.frictionless_contact,
        &tutorial["hard_frictionless_contact_hz"],
    );
    same(
        &TUTORIAL_FREQUENCIES.bonded,
        &tutorial["bonded_penalty_5e6_per_element_hz"],
    );

    let elements = &data["independent_fe"];
    same(&HALF_BEAM_FREQUENCIES, &elements["half_beam_free_c3d8i_hz"]);
    same(&STUCK_FREQUENCIES, &elements["stuck_c3d8i_all_tied_hz"]);
    same(
        &STUCK_FREQUENCIES_REDUCED_INTEGRATION,
        &elements["stuck_c3d8r_all_tied_hz"],
    );
    same(&HARD_CONTACT_FREQUENCIES, &elements["hard_contact_emulation_hz"]);
    same(&[HARD_CONTACT_AREA * 100.0], &elements["hard_contact_area_pct"]);
    same(&[MODEL_MASS], &elements["mass_kg"]);
    same(&[HALF_BEAM_MASS], &elements["half_beam_mass_kg"]);

    for (ours, theirs) in [
        (&BACKBONE_FLAT[..], &data["epmc_rough_contact_flat"]),
        (&BACKBONE_TOPOGRAPHY[..], &data["epmc_rough_contact_topography"]),
    ] {
        let column = |pick: fn(&BackbonePoint) -> f64| ours.iter().map(pick).collect::<Vec<_>>();
        same(&column(|p| p.modal_amplitude), &theirs["modal_amplitude"]);
        same(&column(|p| p.frequency), &theirs["frequency_hz"]);
        same(&column(|p| p.damping_ratio), &theirs["damping_ratio"]);
        same(&column(|p| p.displacement_amplitude), &theirs["displacement_amplitude"]);
    }
}

#[test]
fn surface_agrees_with_the_reference() {
    let Some(data) = reference("brb_surface.json") else {
        return;
    };
    same(&[EFFECTIVE_RADIUS], &data["effective_radius"]);
    same(&[ASPERITIES_PER_AREA], &data["asperities_per_area"]);
    same(&[ASPERITY_GAP_MAX], &data["gap_max"]);
    same(&ASPERITY_GAP_QUANTILES, &data["asperity_gap_quantiles"]["values"]);
    let gap = &data["mesoscale_gap"];
    same(MESOSCALE_GAP_COEFFICIENTS.as_flattened(), &gap["coefficients"]);
    same(&[MESOSCALE_GAP_RMS_RESIDUAL], &gap["rms_residual"]);
    same(&[MESOSCALE_GAP_MAX_RESIDUAL], &gap["max_residual"]);
    let law = &data["law_in_source"];
    same(&[SURFACE_SOURCE_MODEL.youngs_modulus], &law["E"]);
    same(&[SURFACE_SOURCE_MODEL.poisson_ratio], &law["nu"]);
    same(&[SURFACE_SOURCE_MODEL.friction_coefficient], &law["mu"]);
    let note = law["note"].as_str().unwrap();
    assert!(note.contains("331.7 MPa") && note.contains("12249 N"));
}

#[test]
fn quantiles_increase_from_first_touch_to_the_greatest_gap() {
    assert_eq!(ASPERITY_GAP_QUANTILES[0], 0.0);
    assert!(ASPERITY_GAP_QUANTILES.windows(2).all(|w| w[0] < w[1]));
    assert!((ASPERITY_GAP_QUANTILES[200] / ASPERITY_GAP_MAX - 1.0).abs() < 1e-6);
}

/// Legendre polynomials from the explicit sum, an independent form of the recurrence.
fn legendre(n: u32, x: f64) -> f64 {
    let binomial = |n: u32, k: u32| (0..k).map(|i| f64::from(n - i) / f64::from(i + 1)).product::<f64>();
    let term = |k: u32| {
        let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * binomial(n, k) * binomial(2 * n - 2 * k, n) * x.powi((n - 2 * k) as i32)
    };
    (0..=n / 2).map(term).sum::<f64>() / 2.0_f64.powi(n as i32)
}

#[test]
fn mesoscale_gap_is_the_clipped_legendre_sum() {
    let mut positive = 0;
    for i in 0..=40 {
        for j in 0..=10 {
            let (x, y) = (0.003 * f64::from(i - 20), 0.00254 * f64::from(j - 5));
            let mut expected = 0.0;
            for (a, row) in (0..).zip(&MESOSCALE_GAP_COEFFICIENTS) {
                for (b, c) in (0..).zip(row) {
                    expected += c * legendre(a, x / 0.0625) * legendre(b, y / 0.0127);
                }
            }
            let gap = mesoscale_gap(x, y);
            assert!(
                (gap - f64::max(expected, 0.0)).abs() < 1e-16,
                "{x} {y}: {gap} {expected}"
            );
            positive += usize::from(gap > 0.0);
        }
    }
    assert!(positive > 400, "{positive}");
    // At (1, 1) all polynomials are 1: the sum of the coefficients.
    let sum: f64 = MESOSCALE_GAP_COEFFICIENTS.as_flattened().iter().sum();
    assert!((mesoscale_gap(0.0625, 0.0127) - sum.max(0.0)).abs() < 1e-18);
    // Constant beyond the edges, whatever the distance; NaN stays visible.
    assert_eq!(mesoscale_gap(1.0, 0.0), mesoscale_gap(0.0625, 0.0));
    assert!(mesoscale_gap(f64::NAN, 0.0).is_nan());
}

#[test]
fn the_paper_relates_bolt_load_and_strain() {
    // 2050 microstrain give 12.850 kN by eq. 46; the paper's text uses 12.845 kN.
    assert!((BOLT_TENSION_PER_STRAIN * 2050e-6 / BOLT_TENSION - 1.0).abs() < 5e-4);
}

#[test]
fn bolt_loads_and_cords_of_the_paper() {
    assert!((bolt_tension(BOLT_STRAIN) - 12_850.0).abs() < 0.1);
    assert!((bolt_tension(BOLT_STRAIN) / BOLT_TENSION - 1.0).abs() < 5e-4);
    let (load, strain) = TORQUE_BOLT_TENSION;
    assert!((bolt_tension(strain) / load - 1.0).abs() < 5e-4);
    let cord = pendulum_stiffness(PAPER_MASS, CORD_LENGTH, 9.80665);
    assert!((cord - 29.6).abs() < 0.01, "{cord}");
    assert_eq!((cord / 10.0).round() * 10.0, PENDULUM_STIFFNESS);
}
