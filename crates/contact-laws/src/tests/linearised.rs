//! Contact linearised about a static state, against the laws that it is made from and against closed forms.

use proptest::prelude::*;

use super::{elastic, table};
use crate::testing::{PointResponse, displacement, evaluate_point, interference, log_uniform, tangent_error};
use crate::*;

fn coulomb(law: &dyn TractionLaw, u: [f64; 3], begin: &[f64]) -> PointResponse {
    evaluate_point(law, 0, Sticking::Coulomb, u, begin)
}

fn about(law: &dyn TractionLaw, u: [f64; 3], state: &[f64]) -> LinearisedContact {
    let [x, y, n] = u.each_ref().map(core::slice::from_ref);
    LinearisedContact::about(law, Components::new(x, y, n), StateView::new(state, 1, 0)).unwrap()
}

fn linear_elastic(mu: f64) -> ElasticDryFriction {
    let curves = PointParameters::uniform(ElasticCurves::try_new(2e12, [1.5e12, 1e12]).unwrap(), 1);
    FrictionalLaw::try_new(curves, PointParameters::uniform(mu, 1), HistoryRule::Incremental).unwrap()
}

fn point() -> StaticPoint {
    StaticPoint {
        jump: [1e-6, -2e-6, 3e-6],
        traction: [2e5, -1e5, 5e6],
        stiffness: [1.5e12, 1e12, 3e12],
        slip_limit: 1e6,
    }
}

/// Steps from the static state of a law that was loaded by `moves` (m), each committed.
fn loaded(law: &dyn TractionLaw, moves: &[[f64; 3]]) -> ([f64; 3], Vec<f64>) {
    let mut state = vec![0.0; law.info().n_state()];
    for &u in moves {
        state = coulomb(law, u, &state).end;
    }
    (*moves.last().unwrap(), state)
}

#[test]
fn the_static_state_and_its_stuck_stiffness_are_those_of_the_law() {
    let mu = 0.2;
    let curves = |n| PointParameters::uniform(table(), n);
    let per = |history| TableLaw::try_new(curves(1), PointParameters::uniform(mu, 1), history).unwrap();
    let springs = FoundationLaw::of_curves(curves(1), PointParameters::uniform(mu, 1), 0.8, 8, 2e-5).unwrap();
    let laws: [&dyn TractionLaw; 5] = [
        &per(HistoryRule::Incremental),
        &per(HistoryRule::Paper),
        &per(HistoryRule::EndPoint),
        &per(HistoryRule::Potential),
        &springs,
    ];
    for law in laws {
        for far in [1e-8, 1e-4] {
            let (u, state) = loaded(law, &[[0.0, 0.0, 4e-6], [far, -0.5 * far, 5e-6]]);
            let linear = about(law, u, &state);
            let (expected, found) = (coulomb(law, u, &state), coulomb(&linear, u, &[0.0; 4]));
            assert_eq!(found.traction, expected.traction, "{}", law.info().name);
            assert_eq!(found.end, [0.0; 4]);
            assert_eq!(found.regime, Regime::Stick);
            let stuck = evaluate_point(law, 0, Sticking::Full, u, &state).tangent;
            for q in 0..3 {
                assert_eq!(found.tangent[q][q], stuck[q][q]);
            }
            // Slip continues from the static state: a point that slips goes on slipping.
            let on = coulomb(&linear, [u[0] + 0.01 * far, u[1] - 0.005 * far, u[2]], &[0.0; 4]);
            assert_eq!(on.regime == Regime::Slip, far == 1e-4, "{}", law.info().name);
        }
    }
}

#[test]
fn at_constant_interference_constant_stiffnesses_are_left_unchanged() {
    let (law, u) = (linear_elastic(0.3), [2e-7, 0.0, 1e-6]);
    let (_, mut own) = loaded(&law, &[[0.0, 0.0, 1e-6], u]);
    let linear = about(&law, u, &own);
    let mut state = vec![0.0; 4];
    for (i, (x, y)) in [
        (5e-7, 1e-7),
        (-4e-7, 6e-7),
        (3e-7, 3e-7),
        (9e-7, -2e-7),
        (8.9e-7, -2e-7),
    ]
    .into_iter()
    .enumerate()
    {
        let (a, b) = (
            coulomb(&law, [x, y, 1e-6], &own),
            coulomb(&linear, [x, y, 1e-6], &state),
        );
        assert_eq!(a.regime, b.regime);
        for q in 0..3 {
            assert!((a.traction[q] - b.traction[q]).abs() < 1e-9 * 2e6, "{i}: {a:?} {b:?}");
        }
        (own, state) = (a.end, b.end);
    }
}

#[test]
fn the_contact_is_bilateral_and_open_points_stay_open() {
    let law = LinearisedContact::try_new(vec![Some(point())]).unwrap();
    for d in [-1e-4, -1e-6, 1e-9, 1e-3] {
        let t = coulomb(&law, [1e-6, -2e-6, 3e-6 + d], &[0.0; 4]).traction[2];
        assert!((t - (5e6 + 3e12 * d)).abs() < 1e-9 * 3e9, "{d} {t}");
    }
    let elastic = elastic();
    let law = FrictionalLaw::try_new(
        PointParameters::uniform(elastic, 1),
        PointParameters::uniform(0.3, 1),
        HistoryRule::Incremental,
    )
    .unwrap();
    let open = about(&law, [0.0, 0.0, -1e-6], &[0.0; 5]);
    let pressed = coulomb(&open, [1e-6, 0.0, 1e-3], &[0.0; 4]);
    assert_eq!((pressed.traction, pressed.regime), ([0.0; 3], Regime::Open));
    assert_eq!(pressed.tangent, [[0.0; 3]; 3]);
}

#[test]
fn cycles_dissipate_their_closed_form_at_any_interference() {
    let law = LinearisedContact::try_new(vec![Some(StaticPoint {
        jump: [0.0; 3],
        traction: [0.0, 0.0, 1e6],
        stiffness: [1.5e12, 1.5e12, 2e12],
        slip_limit: 3e5,
    })])
    .unwrap();
    let (u, d) = (1e-6, 3e5 / 1.5e12);
    // Lifted off and pressed on along the way, which changes nothing.
    let path = |i: i32| [0.01 * f64::from(i) * u, 0.0, 1e-6 * f64::from(i % 7 - 3)];
    let (mut state, mut area, mut before) = (vec![0.0; 4], 0.0, 0.0);
    let cycle = (0..=100).chain((-100..100).rev()).chain(-99..=100);
    for (step, i) in cycle.enumerate() {
        let found = coulomb(&law, path(i), &state);
        if step > 100 {
            let moved = (path(i)[0] - state[0]) * 0.5 * (before + found.traction[0]);
            area += moved;
        }
        before = found.traction[0];
        state = found.end;
    }
    assert!((area / (4.0 * 3e5 * (u - d)) - 1.0).abs() < 1e-12, "{area}");
}

#[test]
fn defects_are_refused_by_name_and_place() {
    let refusal = |change: fn(&mut StaticPoint)| {
        let mut bad = point();
        change(&mut bad);
        LinearisedContact::try_new(vec![None, Some(point()), Some(bad)]).unwrap_err()
    };
    for (change, name) in [
        ((|p| p.jump[0] = f64::NAN) as fn(&mut StaticPoint), "jump"),
        (|p| p.traction[2] = f64::INFINITY, "traction"),
        (|p| p.stiffness[1] = -1.0, "k_y"),
        (|p| p.stiffness[2] = f64::NAN, "k_n"),
        (|p| p.slip_limit = 2.2e5, "slip_limit"),
        (|p| p.slip_limit = f64::INFINITY, "slip_limit"),
    ] {
        let error = refusal(change);
        assert!(
            matches!(error, Error::Parameter { parameter, place: Place::Point(2), .. } if parameter == name),
            "{error}"
        );
    }
    let (law, state) = (linear_elastic(0.3), [0.0; 5]);
    let try_about = |jump: &[f64], state: &[f64]| {
        let jump = Components::new(jump, jump, jump);
        LinearisedContact::about(&law, jump, StateView::new(state, 1, 0)).unwrap_err()
    };
    for (error, list) in [
        (try_about(&[], &state), "jump.x"),
        (try_about(&[1e-6], &state[..3]), "state"),
    ] {
        assert!(
            matches!(error, Error::Length { list: found, .. } if found == list),
            "{error}"
        );
    }
    let error = try_about(&[f64::NAN], &state);
    assert!(matches!(error, Error::Parameter { parameter: "jump", .. }), "{error}");
}

#[test]
fn what_is_not_finite_is_invalid() {
    let law = LinearisedContact::try_new(vec![Some(point())]).unwrap();
    for (u, begin) in [
        ([f64::NAN, 0.0, 0.0], [0.0; 4]),
        ([0.0; 3], [0.0, 0.0, f64::INFINITY, 0.0]),
    ] {
        let found = coulomb(&law, u, &begin);
        assert_eq!(found.regime, Regime::Invalid);
        assert!(found.numbers().all(f64::is_nan));
    }
}

proptest! {
    #[test]
    fn the_tangent_is_the_derivative_and_the_limit_holds(
        (x, y, n) in (displacement(), displacement(), interference()),
        begin in (displacement(), displacement(), log_uniform(1.0, 1e6), -1e6..1e6),
        stiffness in [log_uniform(1e10, 1e14), log_uniform(1e10, 1e14), log_uniform(1e10, 1e14)],
        limit in prop_oneof![Just(2.3e5), log_uniform(2.3e5, 1e9)],
        full in any::<bool>(),
    ) {
        let p = StaticPoint { stiffness, slip_limit: limit, ..point() };
        let law = LinearisedContact::try_new(vec![Some(p)]).unwrap();
        let sticking = if full { Sticking::Full } else { Sticking::Coulomb };
        let begin = [begin.0, begin.1, begin.2, begin.3];
        let found = evaluate_point(&law, 0, sticking, [x, y, n], &begin);
        prop_assert!(found.numbers().all(f64::is_finite));
        let length = found.traction[0].hypot(found.traction[1]);
        prop_assert!(full || length <= limit * (1.0 + 1e-15));
        // Going on from the state reached changes nothing.
        let again = evaluate_point(&law, 0, sticking, [x, y, n], &found.end);
        for q in 0..2 {
            prop_assert!((again.traction[q] - found.traction[q]).abs() <= 1e-14 * (length + 1e6));
        }
        if let Some(error) = tangent_error(&law, 0, sticking, [x, y, n], &begin) {
            prop_assert!(error < 1e-6, "{error:e}");
        }
    }
}
