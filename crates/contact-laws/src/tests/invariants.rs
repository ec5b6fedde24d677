//! What must hold for every law at every point, whatever its parameters.

use proptest::prelude::*;

use super::{asperities, elastic, fitted, law, normal_fit, table, tangential_fit};
use crate::testing::{
    begin_state, closed_interference, displacement, evaluate_point, friction_coefficient, jump, log_uniform,
    tangent_error,
};
use crate::*;

/// One law of each kind.
fn laws(mu: f64, history: HistoryRule) -> Vec<Box<dyn TractionLaw>> {
    vec![
        Box::new(law(fitted(), mu, history)),
        Box::new(law(elastic(), mu, history)),
        Box::new(law(asperities(TangentialReading::Mindlin), mu, history)),
        Box::new(law(asperities(TangentialReading::Paper), mu, history)),
        Box::new(law(TABLE.with(|table| table.clone()), mu, history)),
    ]
}

thread_local! {
    static TABLE: Tabulated<AsperitySumCurves> = table();
}

fn history() -> impl Strategy<Value = HistoryRule> {
    prop::sample::select(vec![HistoryRule::Incremental, HistoryRule::Paper])
}

/// Fits over the domain of their bounds.
fn curves() -> impl Strategy<Value = FittedCurves> {
    let normal = (10.0..25.0, 0.5..8.0, -0.99..0.99_f64, -2.0..2.0, 0.15..5.0).prop_map(|(a, b, share, d, e)| {
        // c at most where the curve stops rising: b = exp(-1/2) |c|/e.
        NormalFit {
            a,
            b,
            c: share * b * e * 0.5_f64.exp(),
            d,
            e,
            ..normal_fit()
        }
    });
    let ends = prop::sample::select(vec![TangentialEnds::Mindlin, TangentialEnds::Constant]);
    let tangential = (20.0..35.0, 0.0..4.0, -2.0..2.0, 0.0..3.0, ends).prop_map(|(a, b, c, d, ends)| TangentialFit {
        a,
        b,
        c,
        d,
        ..tangential_fit(ends)
    });
    (normal, tangential.clone(), tangential).prop_map(|(n, x, y)| FittedCurves::try_new(n, [x, y]).unwrap())
}

/// Admissibility of one answer.
fn check(law: &dyn TractionLaw, mu: f64, u: [f64; 3], begin: [f64; 5]) -> Result<(), TestCaseError> {
    let found = evaluate_point(law, 0, Sticking::Coulomb, u, &begin);
    let [x, y, n] = found.traction;
    prop_assert!(n >= 0.0);
    prop_assert!(
        found
            .traction
            .iter()
            .chain(found.tangent.iter().flatten())
            .all(|v| v.is_finite()),
        "{found:?}"
    );
    // The last term: denormal numbers have no relative accuracy.
    prop_assert!(x.hypot(y) <= mu * n * (1.0 + 1e-14) + 1e-320, "{found:?}");
    prop_assert_eq!(found.regime == Regime::Open, u[2] <= 0.0);
    if u[2] <= 0.0 {
        prop_assert_eq!(found.traction, [0.0; 3]);
        prop_assert_eq!(found.tangent, [[0.0; 3]; 3]);
    } else if u[2] >= 1e-12 {
        prop_assert!(n > 0.0);
    }
    prop_assert!(found.tangent[2][2] >= 0.0);
    prop_assert_eq!(&found.end, &[u[0], u[1], u[2], x, y]);
    // Pure: the same call gives the same bits.
    prop_assert_eq!(&found, &evaluate_point(law, 0, Sticking::Coulomb, u, &begin));
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_answer_is_admissible(
        mu in friction_coefficient(), history in history(), u in jump(), begin in begin_state(),
    ) {
        for law in laws(mu, history) {
            check(&*law, mu, u, begin)?;
        }
    }

    #[test]
    fn every_fit_is_admissible(
        curves in curves(), mu in friction_coefficient(), history in history(), u in jump(), begin in begin_state(),
    ) {
        check(&law(curves, mu, history), mu, u, begin)?;
    }

    /// Finite input anywhere in the number range gives finite output.
    #[test]
    fn finite_input_gives_finite_output(
        mu in friction_coefficient(), history in history(),
        u in prop::array::uniform3(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO),
        begin in prop::array::uniform5(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO),
    ) {
        for law in laws(mu, history) {
            let found = evaluate_point(&*law, 0, Sticking::Coulomb, u, &begin);
            let all_finite = found.traction.iter().chain(found.tangent.iter().flatten()).all(|v| v.is_finite());
            prop_assert!(all_finite, "{} {found:?}", law.info().name);
        }
    }

    #[test]
    fn a_jump_that_is_no_number_is_invalid(u in jump(), begin in begin_state(), which in 0..8_usize,
                                           value in prop::sample::select(vec![f64::NAN, f64::INFINITY])) {
        let (mut u, mut begin) = (u, begin);
        if which < 3 { u[which] = value } else { begin[which - 3] = value }
        for law in laws(0.3, HistoryRule::Incremental) {
            let found = evaluate_point(&*law, 0, Sticking::Coulomb, u, &begin);
            prop_assert_eq!(found.regime, Regime::Invalid);
            prop_assert!(found.traction.iter().chain(found.tangent.iter().flatten()).all(|v| v.is_nan()));
        }
    }

    #[test]
    fn equal_stiffnesses_turn_with_the_axes(
        mu in friction_coefficient(), history in history(), u in jump(), begin in begin_state(), angle in 0.0..6.3_f64,
    ) {
        let law = law(asperities(TangentialReading::Mindlin), mu, history);
        let (s, c) = angle.sin_cos();
        let turn = |v: &[f64]| [c * v[0] - s * v[1], s * v[0] + c * v[1]];
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
        let stretch = k.value + k_end.slope * (u[2] - begin[2]).abs();
        let parts = begin[3].hypot(begin[4]) + stretch * displacements * 4.0;
        let length = stuck.traction[0].hypot(stuck.traction[1]);
        let scale = if found.regime == Regime::Slip { mu * found.traction[2] * (parts / length).min(1e300) } else { parts };
        for q in 0..2 {
            prop_assert!((turned.traction[q] - expected[q]).abs() <= 1e-13 * scale + 1e-310, "{found:?} {turned:?}");
        }
        prop_assert_eq!(turned.traction[2], found.traction[2]);
    }

    #[test]
    fn the_tangent_is_the_derivative(
        curves in curves(), mu in friction_coefficient(), history in history(),
        x in displacement(), y in displacement(), n in closed_interference(), begin in begin_state(),
    ) {
        let mut begin = begin;
        if history == HistoryRule::Paper {
            // Its trial is a small difference of large terms when u_n has changed by orders of magnitude.
            begin[2] = n * (begin[2] / n).clamp(-10.0, 10.0);
        }
        let law = law(curves, mu, history);
        for sticking in [Sticking::Coulomb, Sticking::Full] {
            // Fits have a kink of second order where their range ends.
            let range = 1e-7..1e-5;
            let ends = [n, 0.5 * (n + begin[2].max(0.0))];
            let near_end = ends.iter().any(|u| [range.start, range.end].iter().any(|e| (u / e - 1.0).abs() < 1e-3));
            if near_end { continue }
            if let Some(error) = tangent_error(&law, 0, sticking, [x, y, n], &begin) {
                prop_assert!(error <= 1e-6, "{error:e}");
            }
        }
    }

    #[test]
    fn tangents_of_table_and_friction_law(
        mu in friction_coefficient(), x in displacement(), y in displacement(), n in closed_interference(),
        begin in begin_state(),
    ) {
        let table = law(TABLE.with(|table| table.clone()), mu, HistoryRule::Incremental);
        let elastic = law(elastic(), mu, HistoryRule::Incremental);
        // The second derivative of a table jumps at its knots, some of which lie between the steps.
        let laws: [(&dyn TractionLaw, f64); 2] = [(&table, 1e-4), (&elastic, 1e-6)];
        for (law, tolerance) in laws {
            if let Some(error) = tangent_error(law, 0, Sticking::Coulomb, [x, y, n], &begin) {
                prop_assert!(error <= tolerance, "{} {error:e}", law.info().name);
            }
        }
    }

    /// Closed collinear cycles at constant interference dissipate, with commits at the reversals only, and the branch
    /// after a reversal is the first loading scaled by two (Masing).
    #[test]
    fn cycles_at_constant_interference(
        mu in friction_coefficient(), n in log_uniform(1e-8, 1e-4), reach in 0.01..5.0_f64, angle in 0.0..6.3_f64,
    ) {
        for law in laws(mu, HistoryRule::Incremental) {
            let (s, c) = angle.sin_cos();
            let first = evaluate_point(&*law, 0, Sticking::Full, [0.0, 0.0, n], &[0.0, 0.0, n, 0.0, 0.0]);
            let k = first.tangent[0][0];
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

            // Masing for stiffness along a principal axis or equal stiffnesses: elsewhere the direction of slip turns.
            if law.info().name.contains("asperity") && first.tangent[0][0] == first.tangent[1][1] {
                for i in 0..=8 {
                    let v = f64::from(i) / 8.0;
                    let loading = along(v, &zero);
                    let unloading = along(1.0 - 2.0 * v, &up);
                    let expected = along(1.0, &zero) - 2.0 * loading;
                    prop_assert!((unloading - expected).abs() <= 1e-12 * limit);
                }
            }
        }
    }
}

/// A batch of many points in the three regimes.
struct Batch {
    jump: [Vec<f64>; 3],
    begin: Vec<f64>,
}

impl Batch {
    fn new(n: usize) -> Self {
        let wave = |i: usize, f: f64| (i as f64 * f).sin();
        let jump = [
            (0..n).map(|i| 3e-6 * wave(i, 0.7)).collect(),
            (0..n).map(|i| 2e-6 * wave(i, 1.3)).collect(),
            (0..n).map(|i| 4e-6 * (0.4 + wave(i, 0.37))).collect(),
        ];
        let mut begin = vec![0.0; 5 * n];
        for i in 0..n {
            begin[i] = 2e-6 * wave(i, 0.71);
            begin[n + i] = 2e-6 * wave(i, 1.1);
            begin[2 * n + i] = 4e-6 * (0.4 + wave(i, 0.36));
        }
        Self { jump, begin }
    }

    /// Evaluated in the given chunks: tractions, tangent entries and end state, one vector.
    fn evaluate(&self, law: &dyn TractionLaw, chunks: &[std::ops::Range<usize>]) -> (Vec<f64>, RegimeCounts) {
        let n = self.jump[0].len();
        let (mut end, mut outputs) = (vec![f64::NAN; 5 * n], vec![vec![f64::NAN; n]; 12]);
        let mut regimes = vec![Regime::Open; n];
        let mut counts = RegimeCounts::default();
        for chunk in chunks {
            let [x, y, n_, xx, xy, xn, yx, yy, yn, nx, ny, nn] =
                outputs.get_disjoint_mut(std::array::from_fn(|i| i)).unwrap();
            let c = chunk.clone();
            let found = law.evaluate(
                c.clone(),
                Sticking::Coulomb,
                Components {
                    x: &self.jump[0][c.clone()],
                    y: &self.jump[1][c.clone()],
                    n: &self.jump[2][c.clone()],
                },
                StateView {
                    data: &self.begin,
                    stride: n,
                    offset: c.start,
                },
                StateViewMut {
                    data: &mut end,
                    stride: n,
                    offset: c.start,
                },
                ComponentsMut {
                    x: &mut x[c.clone()],
                    y: &mut y[c.clone()],
                    n: &mut n_[c.clone()],
                },
                Some(TangentMut {
                    xx: &mut xx[c.clone()],
                    xy: &mut xy[c.clone()],
                    xn: &mut xn[c.clone()],
                    yx: &mut yx[c.clone()],
                    yy: &mut yy[c.clone()],
                    yn: &mut yn[c.clone()],
                    nx: &mut nx[c.clone()],
                    ny: &mut ny[c.clone()],
                    nn: &mut nn[c.clone()],
                }),
                Some(&mut regimes[c.clone()]),
            );
            counts += found;
        }
        let mut recounted = RegimeCounts::default();
        regimes.iter().for_each(|&regime| recounted.count(regime));
        assert_eq!(recounted, counts);
        (outputs.concat().into_iter().chain(end).collect(), counts)
    }
}

#[test]
fn chunks_do_not_change_a_bit() {
    let n = 1000;
    let batch = Batch::new(n);
    let population = |curves: FittedCurves| {
        let index: Vec<u32> = (0..n).map(|i| u32::from(i % 3 == 0)).collect();
        let other = FittedCurves::try_new(
            NormalFit {
                a: 16.0,
                ..normal_fit()
            },
            *curves.tangential_fits(),
        )
        .unwrap();
        PointParameters::try_indexed(vec![curves, other], index).unwrap()
    };
    let mu = PointParameters::per_point((0..n).map(|i| 0.1 + 1e-3 * i as f64).collect());
    let law = FrictionalLaw::try_new(population(fitted()), mu, HistoryRule::Incremental).unwrap();
    let (whole, counts) = batch.evaluate(&law, std::slice::from_ref(&(0..n)));
    assert!(
        counts.stick > 50 && counts.slip > 50 && counts.open > 50 && counts.total() == n,
        "{counts:?}"
    );
    assert!(whole.iter().all(|v| v.is_finite()));
    let (parts, counted) = batch.evaluate(&law, &[600..n, 0..1, 1..64, 64..64, 64..600]);
    assert_eq!(counted, counts);
    assert!(whole.iter().zip(&parts).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn tractions_do_not_depend_on_the_tangent_being_asked_for() {
    let batch = Batch::new(300);
    let points = PointParameters::uniform(table(), 300);
    let law = FrictionalLaw::try_new(points, PointParameters::uniform(0.3, 300), HistoryRule::Incremental).unwrap();
    let (with, counts) = batch.evaluate(&law, std::slice::from_ref(&(0..300)));
    let (mut end, mut t) = (vec![0.0; 1500], [vec![0.0; 300], vec![0.0; 300], vec![0.0; 300]]);
    let [x, y, n] = &mut t;
    let found = law.evaluate(
        0..300,
        Sticking::Coulomb,
        Components {
            x: &batch.jump[0],
            y: &batch.jump[1],
            n: &batch.jump[2],
        },
        StateView {
            data: &batch.begin,
            stride: 300,
            offset: 0,
        },
        StateViewMut {
            data: &mut end,
            stride: 300,
            offset: 0,
        },
        ComponentsMut { x, y, n },
        None,
        None,
    );
    assert_eq!(found, counts);
    assert_eq!(t.concat(), with[..900]);
    assert_eq!(end, with[12 * 300..]);
}
