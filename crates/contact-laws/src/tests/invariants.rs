//! What must hold for every law at every point, whatever its parameters.

use std::cell::Cell;

use proptest::prelude::*;

use super::{
    any_history, asperities, config, elastic, fitted, greenwood_williamson, hold, law, memory, remembered, rough, table,
};
use crate::friction::rule::Memory;
use crate::law::{Along, evaluates_by};
use crate::testing::{
    begin_state, closed_interference, evaluate_point, fitted_curves, friction_coefficient, jump, log_uniform, step,
    tangent_error, work_along,
};
use crate::*;

/// One law of each kind.
pub(super) fn laws(mu: f64, history: HistoryRule) -> Vec<Box<dyn TractionLaw>> {
    vec![
        Box::new(law(fitted(), mu, history)),
        Box::new(rough(fitted(), mu, history)),
        Box::new(law(greenwood_williamson(), mu, history)),
        Box::new(law(elastic(), mu, history)),
        Box::new(law(asperities(TangentialReading::Mindlin), mu, history)),
        Box::new(law(asperities(TangentialReading::Paper), mu, history)),
        Box::new(law(TABLE.with(|table| table.clone()), mu, history)),
    ]
}

thread_local! {
    pub(super) static TABLE: Tabulated<AsperitySumCurves> = table();
}

/// Elastic energy per area of the stretch in a state, at the stiffness `k` of both directions.
fn stored(history: HistoryRule, state: &[f64], k: f64) -> f64 {
    let square = state[3] * state[3] + state[4] * state[4];
    match memory(history) {
        Memory::Traction => 0.5 * square / k,
        Memory::Stretch => 0.5 * k * square,
    }
}

/// Admissibility of one answer.
fn check(
    law: &dyn TractionLaw,
    mu: f64,
    history: HistoryRule,
    u: [f64; 3],
    begin: [f64; 5],
) -> Result<(), TestCaseError> {
    let begin = remembered(history, begin);
    let found = evaluate_point(law, 0, Sticking::Coulomb, u, &begin);
    let [x, y, n] = found.traction;
    prop_assert!(n >= 0.0);
    prop_assert!(found.numbers().all(f64::is_finite), "{found:?}");
    // The last term: denormal numbers have no relative accuracy.
    prop_assert!(x.hypot(y) <= mu * n * (1.0 + 1e-14) + 1e-320, "{found:?}");
    prop_assert_eq!(found.regime == Regime::Open, u[2] <= 0.0);
    if u[2] <= 0.0 {
        prop_assert_eq!(found.traction, [0.0; 3]);
        prop_assert_eq!(found.tangent, [[0.0; 3]; 3]);
    } else if u[2] >= 1e-12 {
        prop_assert!(n > 0.0);
    }
    prop_assert_eq!(&found.end[..3], &u[..]);
    if history == HistoryRule::Potential {
        // The cone is that of the normal traction without stretch, and stretch only adds to it.
        let elastic = evaluate_point(law, 0, Sticking::Coulomb, u, &[u[0], u[1], u[2], 0.0, 0.0]).traction[2];
        prop_assert!(x.hypot(y) <= mu * elastic * (1.0 + 1e-14) + 1e-320, "{found:?}");
        prop_assert!(n >= elastic);
    } else {
        prop_assert!(found.tangent[2][2] >= 0.0);
        prop_assert_eq!(&found.end[3..], &[x, y]);
    }
    // Committed, the end state carries the same tractions, unless its stretch has lost digits to underflow. In blocks the
    // logarithms of the end of the path and of its middle share a division, so that another begin state may round `t_n`
    // in another way.
    if u[2] >= 1e-12 {
        let committed = evaluate_point(law, 0, Sticking::Coulomb, u, &found.end);
        for q in 0..3 {
            let size = if q < 2 { x.hypot(y) } else { n };
            let error = (committed.traction[q] - found.traction[q]).abs();
            prop_assert!(error <= 2e-13 * size + 1e-310, "{found:?} {committed:?}");
        }
    }
    // Pure: the same call gives the same bits.
    prop_assert_eq!(&found, &evaluate_point(law, 0, Sticking::Coulomb, u, &begin));
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn every_answer_is_admissible(
        mu in friction_coefficient(), history in any_history(), (u, begin) in step(),
    ) {
        for law in laws(mu, history) {
            check(&*law, mu, history, u, begin)?;
        }
    }

    #[test]
    fn every_fit_is_admissible(
        curves in fitted_curves(), mu in friction_coefficient(), history in any_history(), (u, begin) in step(),
    ) {
        check(&law(curves, mu, history), mu, history, u, begin)?;
        check(&rough(curves, mu, history), mu, history, u, begin)?;
    }

    #[test]
    fn equal_stiffnesses_turn_with_the_axes(
        mu in friction_coefficient(), history in any_history(), u in jump(), begin in begin_state(), angle in 0.0..6.3_f64,
    ) {
        let law = law(asperities(TangentialReading::Mindlin), mu, history);
        let (s, c) = angle.sin_cos();
        let turn = |v: &[f64]| [c * v[0] - s * v[1], s * v[0] + c * v[1]];
        let begin = remembered(history, begin);
        let found = evaluate_point(&law, 0, Sticking::Coulomb, u, &begin);
        let [ux, uy] = turn(&u);
        let ([bx, by], [tx, ty]) = (turn(&begin), turn(&begin[3..]));
        let turned = evaluate_point(&law, 0, Sticking::Coulomb, [ux, uy, u[2]], &[bx, by, begin[2], tx, ty]);
        prop_assume!(found.regime == turned.regime);
        let expected = turn(&found.traction);
        // The trial cancels, so rounding is relative to its parts; a slip direction inherits that error.
        let stuck = evaluate_point(&law, 0, Sticking::Full, u, &begin);
        let displacements = u.iter().chain(&begin[..3]).fold(0.0_f64, |m, v| m.max(v.abs()));
        let k = law.curves().at(0).tangential(u[2].max(begin[2]).max(f64::MIN_POSITIVE))[0];
        let k_end = law.curves().at(0).tangential(u[2].max(f64::MIN_POSITIVE))[0];
        let parts = if history == HistoryRule::Potential {
            k_end.value * (begin[3].hypot(begin[4]) + displacements * 4.0)
        } else {
            let stretch = k.value + k_end.slope * (u[2] - begin[2]).abs();
            begin[3].hypot(begin[4]) + stretch * displacements * 4.0
        };
        let length = stuck.traction[0].hypot(stuck.traction[1]);
        let slip_scale = mu * found.traction[2] * (parts / length).min(1e300);
        let scale = if found.regime == Regime::Slip { slip_scale } else { parts };
        for q in 0..2 {
            prop_assert!((turned.traction[q] - expected[q]).abs() <= 1e-13 * scale + 1e-310, "{found:?} {turned:?}");
        }
        if history == HistoryRule::Potential && u[2] >= 1e-12 {
            // k' e^2/2 adds to the normal traction; its stretch is rounded like the traction.
            let stretch = found.end[3].hypot(found.end[4]);
            let allowed = 1e-13 * (found.traction[2] + k_end.slope * stretch * scale / k_end.value);
            prop_assert!((turned.traction[2] - found.traction[2]).abs() <= allowed + 1e-310, "{found:?} {turned:?}");
        } else if history != HistoryRule::Potential {
            prop_assert_eq!(turned.traction[2], found.traction[2]);
        }
    }

    /// A cycle between reversals at constant interference dissipates, with commits at the reversals only, and the
    /// branch after a reversal is the first loading scaled by two (Masing).
    #[test]
    fn cycles_at_constant_interference(
        curves in fitted_curves(), mu in friction_coefficient(), history in any_history(), n in closed_interference(),
        reach in log_uniform(1e-3, 1e3), [c, s] in direction(),
    ) {
        let fits: [Box<dyn TractionLaw>; 2] = [
            Box::new(law(curves, mu, history)),
            Box::new(rough(curves, mu, history)),
        ];
        for law in laws(mu, history).into_iter().chain(fits) {
            let first = evaluate_point(&*law, 0, Sticking::Full, [0.0, 0.0, n], &[0.0, 0.0, n, 0.0, 0.0]);
            let k = first.tangent[0][0].max(first.tangent[1][1]);
            let limit = mu * first.traction[2];
            let amplitude = if limit > 0.0 { reach * limit / k } else { 1e-6 };
            let at = |v: f64, begin: &[f64]| {
                evaluate_point(&*law, 0, Sticking::Coulomb, [v * amplitude * c, v * amplitude * s, n], begin)
            };
            let along = |v: f64, begin: &[f64]| {
                let t = at(v, begin).traction;
                t[0] * c + t[1] * s
            };

            let zero = [0.0, 0.0, n, 0.0, 0.0];
            let up = at(1.0, &zero).end;
            let down = at(-1.0, &up).end;
            let mut area = 0.0;
            let steps = 40;
            for (begin, from, to) in [(&up, 1.0, -1.0), (&down, -1.0, 1.0)] {
                let mut before = along(from, begin);
                for i in 1..=steps {
                    let v = from + (to - from) * f64::from(i) / f64::from(steps);
                    let now = along(v, begin);
                    area += 0.5 * (before + now) * (to - from) / f64::from(steps) * amplitude;
                    before = now;
                }
            }
            prop_assert!(area >= -1e-12 * limit * amplitude, "{} {area:e}", law.info().name);

            // Elsewhere the direction of slip turns.
            if c == 0.0 || s == 0.0 || first.tangent[0][0] == first.tangent[1][1] {
                for i in 0..=8 {
                    let v = f64::from(i) / 8.0;
                    let loading = along(v, &zero);
                    let unloading = along(1.0 - 2.0 * v, &up);
                    let expected = along(1.0, &zero) - 2.0 * loading;
                    prop_assert!((unloading - expected).abs() <= 1e-13 * limit * reach.max(1.0));
                }
            }
        }
    }

    /// Any path back and forth along one line at constant interference, with commits at the reversals only, takes up at
    /// least the energy that is stored at its end.
    #[test]
    fn collinear_paths_dissipate(
        mu in friction_coefficient(), history in any_history(), n in closed_interference(),
        turns in prop::collection::vec(-3.0..3.0_f64, 1..8), [c, s] in direction(),
    ) {
        for law in laws(mu, history) {
            let [k_x, k_y, t_n] = stuck(&*law, n);
            if k_x != k_y && c != 0.0 && s != 0.0 { continue }
            let k = if c == 0.0 { k_y } else { k_x };
            let scale = mu * t_n / k + 1e-30;
            let mut state = vec![0.0, 0.0, n, 0.0, 0.0];
            let (mut work, mut length, mut from) = (0.0, 0.0, 0.0);
            for &to in turns.iter().chain([&0.0]) {
                let at = |i: u32| from + (to - from) * f64::from(i) / 16.0;
                let respond = |i: u32| {
                    let v = scale * at(i);
                    evaluate_point(&*law, 0, Sticking::Coulomb, [v * c, v * s, n], &state)
                };
                let along = |i: u32| respond(i).traction[0] * c + respond(i).traction[1] * s;
                for i in 0..16 {
                    work += 0.5 * (along(i) + along(i + 1)) * scale * (at(i + 1) - at(i));
                    length += scale * (at(i + 1) - at(i)).abs();
                }
                state = respond(16).end;
                from = to;
            }
            let stored = stored(history, &state, k);
            prop_assert!(work - stored >= -1e-13 * mu * t_n * length, "{} {work:e} {stored:e}", law.info().name);
        }
    }

    /// Any planar path at constant interference with a commit at every step and equal stiffnesses takes up at least the
    /// energy that is stored at its end; a closed one from rest dissipates.
    #[test]
    fn planar_paths_dissipate(
        mu in friction_coefficient(), history in any_history(), n in closed_interference(),
        corners in prop::collection::vec(prop::array::uniform2(-3.0..3.0_f64), 1..12),
    ) {
        let [x, _] = *fitted().tangential_fits();
        let isotropic = FittedCurves::try_new(*fitted().normal_fit(), [x; 2]).unwrap();
        let laws: [Box<dyn TractionLaw>; 5] = [
            Box::new(rough(isotropic, mu, history)),
            Box::new(law(greenwood_williamson(), mu, history)),
            Box::new(law(asperities(TangentialReading::Mindlin), mu, history)),
            Box::new(law(TABLE.with(|table| table.clone()), mu, history)),
            Box::new(law(ElasticCurves::try_new(2e12, [1e12; 2]).unwrap(), mu, history)),
        ];
        for law in laws {
            let [k, _, t_n] = stuck(&*law, n);
            let scale = mu * t_n / k;
            let mut path = vec![[0.0, 0.0, n]];
            for corner in corners.iter().chain([&[0.0; 2]]) {
                let &[x, y, _] = path.last().unwrap();
                let part = |i: u32, from: f64, to: f64| from + (to * scale - from) * f64::from(i) / 4.0;
                path.extend((1..=4).map(|i| [part(i, x, corner[0]), part(i, y, corner[1]), n]));
            }
            let respond = |u: [f64; 3], begin: &[f64]| evaluate_point(&*law, 0, Sticking::Coulomb, u, begin);
            let (work, end) = work_along(&path, &[0.0, 0.0, n, 0.0, 0.0], respond);
            let stored = stored(history, &end, k);
            let length: f64 = path.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum();
            prop_assert!(work - stored >= -1e-13 * mu * t_n * length, "{} {work:e} {stored:e}", law.info().name);
        }
    }
}

/// Directions in the plane: the axes and any other.
fn direction() -> impl Strategy<Value = [f64; 2]> {
    let any = (0.0..6.3_f64).prop_map(|angle| [angle.cos(), angle.sin()]);
    prop_oneof![1 => Just([1.0, 0.0]), 1 => Just([0.0, 1.0]), 2 => any]
}

/// `k_x`, `k_y` and `t_n` at the interference `n`.
fn stuck(law: &dyn TractionLaw, n: f64) -> [f64; 3] {
    let found = evaluate_point(law, 0, Sticking::Full, [0.0, 0.0, n], &[0.0, 0.0, n, 0.0, 0.0]);
    [found.tangent[0][0], found.tangent[1][1], found.traction[2]]
}

/// The checker that other laws' tests use: it finds these tangents right wherever it can judge, and it mostly can.
#[test]
fn tangents_are_the_differences_of_tractions() {
    let judged = [const { Cell::new(0) }; 4];
    let worst = [const { Cell::new(0.0_f64) }; 4];
    let config = config(3000, file!(), None);
    let strategy = (
        fitted_curves(),
        friction_coefficient(),
        any_history(),
        step(),
        closed_interference(),
    );
    hold(config, &strategy, |(curves, mu, history, (mut u, begin), n)| {
        if u[2] < 1e-12 {
            u[2] = n;
        }
        // Where a fitted range ends the second derivatives jump: within the steps that misleads the differences.
        let fits = curves.tangential_fits().map(|fit| fit.range);
        let mut ends = fits.into_iter().chain([curves.normal_fit().range]).flatten().flatten();
        let middle = 0.5 * (u[2] + begin[2].max(0.0));
        prop_assume!(ends.all(|end| [u[2], middle].iter().all(|n| (n / end - 1.0).abs() > 0.06)));
        let fitted = law(curves, mu, history);
        let vector = rough(curves, mu, history);
        let begin = remembered(history, begin);
        let elastic = law(elastic(), mu, history);
        // The second derivatives of a table jump at its knots, some of which lie between the steps.
        let table = law(TABLE.with(|table| table.clone()), mu, HistoryRule::Incremental);
        let laws: [(&dyn TractionLaw, f64); 4] = [(&fitted, 1e-6), (&vector, 1e-6), (&elastic, 1e-6), (&table, 1e-3)];
        for (i, (law, tolerance)) in laws.into_iter().enumerate() {
            for sticking in [Sticking::Coulomb, Sticking::Full] {
                if let Some(error) = tangent_error(law, 0, sticking, u, &begin) {
                    judged[i].set(judged[i].get() + 1);
                    worst[i].set(error.max(worst[i].get()));
                    prop_assert!(error <= tolerance, "{} {error:e}", law.info().name);
                }
            }
        }
        Ok(())
    });
    println!("fitted, in blocks, elastic, table: judged {judged:?} of 6000, errors up to {worst:?}");
    assert!(judged.iter().all(|n| n.get() > 4000));
}

/// The checker sees a wrong tangent: by a thousandth, by a missing coupling, by a wrong sign.
#[test]
fn wrong_tangents_are_found() {
    /// A law with one entry of its tangent changed.
    struct Wrong(FrictionalLaw<PointParameters<FittedCurves>>, fn(&mut TangentMut<'_>));
    impl Wrong {
        fn answer(
            &self,
            points: std::ops::Range<usize>,
            sticking: Sticking,
            jump: Components<'_>,
            begin: StateView<'_>,
            end: StateViewMut<'_>,
            traction: ComponentsMut<'_>,
            tangent: Option<TangentMut<'_>>,
            regimes: Option<&mut [Regime]>,
            _along: Option<Along<'_>>,
        ) -> RegimeCounts {
            let mut entries = tangent.expect("asked for by the checker").into_entries();
            let inner = TangentMut::from_entries(entries.each_mut().map(|entry| &mut **entry));
            let counts = self
                .0
                .evaluate(points, sticking, jump, begin, end, traction, Some(inner), regimes);
            self.1(&mut TangentMut::from_entries(entries));
            counts
        }
    }
    impl TractionLaw for Wrong {
        fn info(&self) -> &LawInfo {
            self.0.info()
        }
        fn len(&self) -> usize {
            self.0.len()
        }
        evaluates_by!(answer);
    }
    let begin = [1e-7, 0.0, 8e-7, 1e4, -2e4];
    // Stuck and slipping.
    for jump in [[1.2e-7, 1e-8, 1e-6], [4e-6, 3e-6, 1e-6]] {
        let law = || law(fitted(), 0.3, HistoryRule::Incremental);
        assert!(tangent_error(&law(), 0, Sticking::Coulomb, jump, &begin).unwrap() < 1e-8);
        let changes: [fn(&mut TangentMut<'_>); 4] = [
            |tangent| tangent.xx[0] *= 1.001,
            |tangent| tangent.yn[0] = 0.0,
            |tangent| tangent.nn[0] *= -1.0,
            |tangent| tangent.nx[0] = 0.1 * tangent.xx[0],
        ];
        for change in changes {
            let error = tangent_error(&Wrong(law(), change), 0, Sticking::Coulomb, jump, &begin);
            assert!(error.unwrap() > 1e-4, "{error:?}");
        }
    }
}
