//! The branches of the friction law, one by one, against figures worked out by hand.

use super::{asperities, elastic, fitted, law, relative, table};
use crate::testing::evaluate_point;
use crate::*;

const OPEN: [f64; 5] = [0.0; 5];

#[test]
fn stick_slip_and_open() {
    // k_n = 2e12, k_x = 1.5e12, k_y = 1e12 Pa/m, u_n = 1 um: t_n = 2 MPa, limit 1 MPa.
    let law = law(elastic(), 0.5, HistoryRule::Incremental);
    let begin = [1e-7, 0.0, 1e-6, 1e5, 0.0];
    let stick = evaluate_point(&law, 0, Sticking::Coulomb, [3e-7, -2e-7, 1e-6], &begin);
    assert_eq!(stick.regime, Regime::Stick);
    assert!(relative(stick.traction[0], 4e5) < 1e-14 && relative(stick.traction[1], -2e5) < 1e-14);
    assert_eq!(stick.tangent, [[1.5e12, 0.0, 0.0], [0.0, 1e12, 0.0], [0.0, 0.0, 2e12]]);

    // Trial (3.1, 4) MPa - a length of 5.0606 MPa - back to 1 MPa.
    let slip = evaluate_point(&law, 0, Sticking::Coulomb, [2.1e-6, 4e-6, 1e-6], &begin);
    let length = 3.1_f64.hypot(4.0);
    assert_eq!(slip.regime, Regime::Slip);
    assert!(relative(slip.traction[0], 1e6 * 3.1 / length) < 1e-14);
    assert!(relative(slip.traction[1], 1e6 * 4.0 / length) < 1e-14);
    // The direction is taken from the cone mu t_n: d t_x / d u_n = mu k_n n_x.
    assert!(relative(slip.tangent[0][2], 0.5 * 2e12 * 3.1 / length) < 1e-14);
    assert!(
        relative(
            slip.tangent[0][1],
            -1e6 / (length * 1e6) * 3.1 * 4.0 / length.powi(2) * 1e12
        ) < 1e-13
    );

    let open = evaluate_point(&law, 0, Sticking::Coulomb, [3e-7, -2e-7, -0.0], &begin);
    assert_eq!(
        (open.regime, open.traction, open.tangent),
        (Regime::Open, [0.0; 3], [[0.0; 3]; 3])
    );
}

#[test]
fn recontact_sticks_from_where_the_path_closes() {
    // From u_n = -1 um to 3 um: closed over 3/4 of the path.
    let law = law(elastic(), 10.0, HistoryRule::Incremental);
    let found = evaluate_point(
        &law,
        0,
        Sticking::Coulomb,
        [4e-7, 0.0, 3e-6],
        &[0.0, 0.0, -1e-6, 0.0, 0.0],
    );
    assert_eq!(found.regime, Regime::Stick);
    assert!(relative(found.traction[0], 0.75 * 1.5e12 * 4e-7) < 1e-14);
    // share = u_n/(u_n - u_n0), so its derivative is -u_n0/(u_n - u_n0)^2.
    assert!(relative(found.tangent[0][2], 1e-6 / 16e-12 * 1.5e12 * 4e-7) < 1e-13);
}

/// Between two closed states the error of the midpoint rule falls with the square of the step.
#[test]
fn the_incremental_rule_is_of_second_order_and_has_no_origin() {
    let law = law(fitted(), 10.0, HistoryRule::Incremental);
    let path = |steps: u32, origin: f64| {
        let at = |s: f64| [origin + 1e-7 * s, origin - 2e-8 * s, 1e-6 * (1.0 + s)];
        let [x, y, n] = at(0.0);
        let mut state = vec![x, y, n, 0.0, 0.0];
        for i in 1..=steps {
            state = evaluate_point(&law, 0, Sticking::Full, at(f64::from(i) / f64::from(steps)), &state).end;
        }
        state[3]
    };
    let exact = path(4096, 0.0);
    let errors: Vec<f64> = [4, 8, 16, 32].map(|n| (path(n, 0.0) - exact).abs()).to_vec();
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((3.8..4.3).contains(&ratio), "{ratio}");
    }
    assert!(relative(path(8, 0.0), path(8, 1e-6)) < 1e-13);
}

#[test]
fn without_friction_nothing_sticks_and_no_direction_is_needed() {
    let law = law(elastic(), 0.0, HistoryRule::Incremental);
    for x in [0.0, 1e-6] {
        let found = evaluate_point(&law, 0, Sticking::Coulomb, [x, 0.0, 1e-6], &OPEN);
        assert_eq!((found.regime, found.traction), (Regime::Slip, [0.0, 0.0, 2e12 * 1e-6]));
        assert_eq!(found.tangent, [[0.0; 3], [0.0; 3], [0.0, 0.0, 2e12]]);
    }
    // A trial of zero length below a limit above zero sticks.
    let law = super::law(elastic(), 0.3, HistoryRule::Incremental);
    let found = evaluate_point(
        &law,
        0,
        Sticking::Coulomb,
        [0.0, 0.0, 1e-6],
        &[0.0, 0.0, 1e-6, 0.0, 0.0],
    );
    assert_eq!((found.regime, found.tangent[0][0]), (Regime::Stick, 1.5e12));
}

/// The stuck tangent about a committed state is symmetric: the linearised modes depend on it.
#[test]
fn full_sticking_ignores_the_cone_but_not_the_opening() {
    let law = law(table(), 0.1, HistoryRule::Incremental);
    let state = evaluate_point(
        &law,
        0,
        Sticking::Coulomb,
        [4e-6, 1e-6, 3e-6],
        &[0.0, 0.0, 3e-6, 0.0, 0.0],
    )
    .end;
    let stuck = evaluate_point(&law, 0, Sticking::Full, [state[0], state[1], state[2]], &state);
    let [k_x, k_y] = law.curves().at(0).tangential(3e-6);
    assert_eq!(stuck.regime, Regime::Stick);
    assert_eq!(stuck.traction[..2], state[3..]);
    let slope = law.curves().at(0).normal(3e-6).1;
    assert_eq!(
        stuck.tangent,
        [[k_x.value, 0.0, 0.0], [0.0, k_y.value, 0.0], [0.0, 0.0, slope]]
    );

    let beyond = evaluate_point(&law, 0, Sticking::Full, [1e-3, 0.0, 3e-6], &state);
    assert!(beyond.regime == Regime::Stick && beyond.traction[0] > 100.0 * 0.1 * beyond.traction[2]);
    let open = evaluate_point(&law, 0, Sticking::Full, [1e-3, 0.0, 0.0], &state);
    assert_eq!((open.regime, open.traction), (Regime::Open, [0.0; 3]));
}

/// A law over points that have nothing in common but their kind.
#[test]
fn points_use_their_own_parameters() {
    let curves = PointParameters::per_point(vec![
        ElasticCurves::try_new(1e12, [1e12; 2]).unwrap(),
        ElasticCurves::try_new(3e12, [1e12; 2]).unwrap(),
    ]);
    let law = FrictionalLaw::try_new(
        curves,
        PointParameters::per_point(vec![0.1, 0.2]),
        HistoryRule::Incremental,
    )
    .unwrap();
    let begin = [0.0; 5];
    let t = [0, 1].map(|point| evaluate_point(&law, point, Sticking::Coulomb, [1e-3, 0.0, 1e-6], &begin).traction);
    assert_eq!(t, [[1e5, 0.0, 1e6], [6e5, 0.0, 3e6]].map(|t: [f64; 3]| t));
}

#[test]
fn companion_outputs_reach_through_the_law() {
    let law: Box<dyn TractionLaw> = Box::new(law(table(), 0.1, HistoryRule::Incremental));
    let curves = asperities(TangentialReading::Mindlin);
    assert_eq!(law.contact_area_ratio(0, 5e-6), curves.contact_area_ratio(5e-6));
    assert_eq!(law.contact_area_ratio(0, -1e-6), Some(0.0));
    assert_eq!(law.yielded_fraction(0, 5e-6, 1e-7), curves.yielded_fraction(5e-6, 1e-7));
    let elastic = super::law(elastic(), 0.1, HistoryRule::Incremental);
    assert_eq!(elastic.contact_area_ratio(0, 5e-6), None);
    assert_eq!(law.info().n_state(), 5);
}
