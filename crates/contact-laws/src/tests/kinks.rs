//! Exact kinks, the ends of the number range, and input that is no number.

use proptest::prelude::*;

use super::invariants::{TABLE, laws};
use super::{any_history, fitted, histories, law, memory, normal_fit, relative, rough};
use crate::friction::rule::Memory;
use crate::testing::{PointResponse, evaluate_point, log_uniform};
use crate::*;

fn at(law: &dyn TractionLaw, jump: [f64; 3], begin: &[f64; 5]) -> PointResponse {
    evaluate_point(law, 0, Sticking::Coulomb, jump, begin)
}

/// Elastic normal traction and tangential stiffnesses at `u`.
fn curves_at(law: &dyn TractionLaw, u: [f64; 3]) -> (f64, [f64; 2]) {
    let found = evaluate_point(law, 0, Sticking::Full, u, &[u[0], u[1], u[2], 0.0, 0.0]);
    (found.traction[2], [found.tangent[0][0], found.tangent[1][1]])
}

/// Derivative of all tractions along direction `k` from one side, of second order, with the step.
fn one_sided(law: &dyn TractionLaw, jump: [f64; 3], begin: &[f64; 5], k: usize, step: f64) -> ([f64; 3], f64) {
    let moved = |steps: f64| {
        let mut moved = jump;
        moved[k] += steps * step;
        // Relative to the step as it was rounded.
        (moved[k] - jump[k], at(law, moved, begin).traction)
    };
    let here = at(law, jump, begin).traction;
    let [(h, near), (double, far)] = [moved(1.0), moved(2.0)];
    let derivatives = std::array::from_fn(|i| {
        let (near, far) = ((near[i] - here[i]) / h, (far[i] - here[i]) / double);
        near + (near - far) * h / (double - h)
    });
    (derivatives, step)
}

/// Column `k` of the tangent against differences over a `step` by which rounded tractions were divided.
fn assert_column(found: &PointResponse, k: usize, (expected, step): ([f64; 3], f64), tolerance: f64, what: &str) {
    let scale = found.tangent[0][0]
        .abs()
        .max(found.tangent[1][1].abs())
        .max(found.tangent[2][k].abs());
    for i in 0..3 {
        let entry = found.tangent[i][k];
        let rounding = 8.0 * f64::EPSILON * found.traction[i].abs() / step.abs();
        assert!(
            (entry - expected[i]).abs() <= tolerance * scale.max(entry.abs()) + rounding,
            "{what}: entry {i}{k} is {entry:e}, difference {:e}",
            expected[i]
        );
    }
}

/// Trial exactly on the cone: it sticks, and the tangent is the derivative towards the inside. One unit in the last
/// place beyond it slips, and the tangent is the derivative towards the outside.
#[test]
fn trial_on_the_cone() {
    let u = [2e-6, -1e-6, 3e-6];
    for history in histories() {
        for mu in [1e-3, 0.3, 10.0] {
            for law in laws(mu, history) {
                let name = law.info().name;
                let (t_n, [k, _]) = curves_at(&*law, u);
                let (limit, reach) = (mu * t_n, mu * t_n / k);
                // The coincident begin state makes its own memory the trial: the last one that sticks and the next.
                let with = |memory: f64| [u[0], u[1], u[2], memory, 0.0];
                let mut last = if history == HistoryRule::Potential {
                    reach
                } else {
                    limit
                };
                while at(&*law, u, &with(last)).regime == Regime::Slip {
                    last = last.next_down();
                }
                while at(&*law, u, &with(last.next_up())).regime == Regime::Stick {
                    last = last.next_up();
                }
                let (on, beyond) = (with(last), with(last * (1.0 + 2.0 * f64::EPSILON)));
                let found = at(&*law, u, &on);
                if history == HistoryRule::Potential {
                    assert!(relative(found.traction[0], limit) < 4e-16, "{name}");
                } else {
                    assert_eq!(found.traction[0], limit, "{name}");
                }
                assert_column(&found, 0, one_sided(&*law, u, &on, 0, -1e-4 * reach), 1e-9, name);

                let found = at(&*law, u, &beyond);
                assert_eq!(found.regime, Regime::Slip, "{name}");
                assert!(relative(found.traction[0], limit) < 1e-15);
                assert_column(&found, 0, one_sided(&*law, u, &beyond, 0, 1e-4 * reach), 1e-9, name);
                // Across the direction of slip the cone turns, to second order in the step.
                assert_column(&found, 1, one_sided(&*law, u, &beyond, 1, 1e-4 * reach), 1e-6, name);
            }
        }
    }
    // From a trial at a place where the cone meets it by geometry: 3-4-5 on k = 2^40, t_n = 5 * 2^20, mu = 1.
    let k = 2.0_f64.powi(40);
    let law = law(
        ElasticCurves::try_new(k, [k; 2]).unwrap(),
        1.0,
        HistoryRule::Incremental,
    );
    let [three, four, five] = [3.0, 4.0, 5.0].map(|v| v * 2.0_f64.powi(-20));
    let found = at(&law, [three, four, five], &[0.0, 0.0, five, 0.0, 0.0]);
    assert_eq!(
        (found.regime, found.traction),
        (Regime::Stick, [three * k, four * k, five * k])
    );
    assert_eq!(found.tangent, [[k, 0.0, 0.0], [0.0, k, 0.0], [0.0, 0.0, k]]);
    // Opening by the smallest number leaves the cone behind.
    let found = at(&law, [three, four, five.next_down()], &[0.0, 0.0, five, 0.0, 0.0]);
    assert_eq!(found.regime, Regime::Slip);
}

/// At `u_n = 0`, of either sign, the point is open with the derivative from the open side; the smallest number above is
/// closed.
#[test]
fn zero_interference() {
    let tiny = f64::from_bits(1);
    for history in histories() {
        for mu in [0.0, 0.3, 10.0] {
            for law in laws(mu, history) {
                for begin_n in [-1e-6, -0.0, 0.0, tiny, 1e-6] {
                    let begin = [1e-7, 0.0, begin_n, 0.0, 0.0];
                    for n in [0.0, -0.0, -tiny] {
                        let found = at(&*law, [1e-6, -1e-6, n], &begin);
                        assert_eq!(found.regime, Regime::Open);
                        assert_eq!((found.traction, found.tangent), ([0.0; 3], [[0.0; 3]; 3]));
                        assert_eq!(found.end[3..], [0.0; 2]);
                    }
                    let found = at(&*law, [1e-6, -1e-6, tiny], &begin);
                    assert_ne!(found.regime, Regime::Open, "{}", law.info().name);
                    let numbers = found.traction.iter().chain(found.tangent.as_flattened());
                    assert!(numbers.copied().all(f64::is_finite), "{} {found:?}", law.info().name);
                }
            }
        }
    }
}

/// Where the fitted range or a table ends the value is that of the formula, and the tangent is one of the two one-sided
/// derivatives. They differ only for the rule that differentiates `k'`: there it is the side of the branch taken.
#[test]
fn ends_of_the_range() {
    let fit = normal_fit();
    let range = fit.range.unwrap();
    for n in range {
        let x = (n / fit.u_ref).ln();
        let formula = (fit.a + fit.b * x + fit.c * (-0.5 * ((x + fit.d) / fit.e).powi(2)).exp()).exp();
        assert!(relative(fitted().normal(n).0, formula) < 1e-14);
    }
    let fitted_inward = [1e-4, -1e-4];
    // A cell begins at its lower knot, and the continuation at the last one.
    let table_upward = [1e-4, 1e-4];
    for history in histories() {
        let vector = rough(fitted(), 0.5, history);
        let fitted = law(fitted(), 0.5, history);
        let table = law(TABLE.with(|table| table.clone()), 0.5, history);
        let table_range = table.curves().at(0).range();
        let cases: [(&dyn TractionLaw, [f64; 2], [f64; 2]); 3] = [
            (&fitted, range, fitted_inward),
            (&vector, range, fitted_inward),
            (&table, table_range, table_upward),
        ];
        for (i, (law, range, sides)) in cases.into_iter().enumerate() {
            // In blocks the end is met to rounding of its logarithm only: from either side.
            let either = i == 1;
            for (n, side) in range.into_iter().zip(sides) {
                let open = at(law, [0.0, 0.0, n], &[0.0; 5]);
                let k = open.tangent[0][0];
                let reach = 0.5 * open.traction[2] / k;
                // Stuck and slipping; for the incremental rule the middle of the path lies on the end.
                for share in [0.1, 3.0] {
                    let jump = [share * reach, 0.2 * share * reach, n];
                    let begin = [0.0, 0.0, 0.9 * n, 0.0, 0.0];
                    let middle = [jump[0], jump[1], 1.25 * n];
                    let before = [0.0, 0.0, 0.75 * n, 0.0, 0.0];
                    assert_eq!(0.5 * middle[2] + 0.5 * before[2], n);
                    for (jump, begin) in [(jump, begin), (middle, before)] {
                        let found = at(law, jump, &begin);
                        // Scaled by the size of dt/du_n.
                        let scale = found.traction[2] / n;
                        let errors = [side, -side].map(|side| {
                            let (expected, _) = one_sided(law, jump, &begin, 2, side * n);
                            (0..3).fold(0.0_f64, |worst, i| worst.max((found.tangent[i][2] - expected[i]).abs()))
                        });
                        let error = if either { errors[0].min(errors[1]) } else { errors[0] };
                        assert!(
                            error <= 1e-6 * scale,
                            "{} {history:?} {n:e}: {error:e} {scale:e}",
                            law.info().name
                        );
                    }
                }
            }
        }
    }
}

/// Begin and end coincide, as at a reversal: the traction stays, and the tangent is that of sticking.
#[test]
fn coincident_states() {
    for history in histories() {
        for law in laws(0.5, history) {
            for n in [1e-12, 1e-9, 1e-6, 1e-2] {
                let u = [3e-6, -2e-6, n];
                let (t_n, [k_x, k_y]) = curves_at(&*law, u);
                let held = [0.15 * t_n, -0.2 * t_n];
                let memory = match memory(history) {
                    Memory::Traction => held,
                    Memory::Stretch => [held[0] / k_x, held[1] / k_y],
                };
                let begin = [u[0], u[1], n, memory[0], memory[1]];
                let found = at(&*law, u, &begin);
                assert_eq!(found.regime, Regime::Stick);
                if history == HistoryRule::Potential {
                    assert!((0..2).all(|q| relative(found.traction[q], held[q]) < 4e-16));
                    assert!(found.traction[2] >= t_n);
                } else {
                    assert_eq!(found.traction, [held[0], held[1], t_n]);
                }
                assert_eq!(found.end, begin);
                assert!(found.tangent[0][0] > 0.0 && found.tangent[0][1] == 0.0 && found.tangent[1][0] == 0.0);
                // Zeros of either sign are no difference.
                let signed = at(&*law, [0.0, -0.0, n], &[-0.0, 0.0, n, 0.0, -0.0]);
                assert_eq!(
                    (signed.regime, signed.traction[..2].to_vec()),
                    (Regime::Stick, vec![0.0; 2])
                );
            }
        }
    }
}

/// A trial of zero length: without friction it slips with no tangential tangent, with friction it sticks.
#[test]
fn trials_of_zero_length() {
    for history in histories() {
        for n in [1e-12, 1e-6, 1e-2] {
            let (u, begin) = ([1e-6, 0.0, n], [1e-6, 0.0, n, 0.0, 0.0]);
            for law in laws(0.0, history) {
                let found = at(&*law, u, &begin);
                assert_eq!(
                    (found.regime, found.traction[..2].to_vec()),
                    (Regime::Slip, vec![0.0; 2])
                );
                assert_eq!(found.tangent[..2], [[0.0; 3]; 2]);
                assert!(relative(found.tangent[2][2], one_branch_slope(&*law, n)) < 1e-13);
            }
            for law in laws(1e-300, history).into_iter().chain(laws(10.0, history)) {
                let found = at(&*law, u, &begin);
                assert_eq!(
                    (found.regime, found.traction[..2].to_vec()),
                    (Regime::Stick, vec![0.0; 2])
                );
                assert!(found.tangent[0][0] > 0.0 && found.tangent[1][1] > 0.0);
            }
        }
    }
}

/// `d t_n / d u_n`, which no history changes.
fn one_branch_slope(law: &dyn TractionLaw, n: f64) -> f64 {
    evaluate_point(law, 0, Sticking::Full, [0.0, 0.0, n], &[0.0; 5]).tangent[2][2]
}

/// From zero over the denormal numbers to the largest ones, of either sign.
pub(super) fn extreme() -> impl Strategy<Value = f64> {
    let sizes = [
        0.0,
        f64::from_bits(1),
        1e-310,
        f64::MIN_POSITIVE,
        1e-200,
        1e-100,
        1e-12,
        1e-6,
        1.0,
        1e100,
        1e154,
        1e200,
        1e300,
        1e308,
        f64::MAX,
    ];
    let anything = prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO;
    prop_oneof![
        3 => (prop::sample::select(sizes.to_vec()), any::<bool>()).prop_map(|(v, minus)| if minus { -v } else { v }),
        1 => anything,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Finite input anywhere in the number range gives finite output, on the cone or inside it.
    #[test]
    fn finite_input_gives_finite_output(
        mu in prop_oneof![3 => 0.0..10.0, 1 => extreme().prop_map(f64::abs)],
        history in any_history(),
        u in prop::array::uniform3(extreme()), begin in prop::array::uniform5(extreme()),
    ) {
        for law in laws(mu, history) {
            for sticking in [Sticking::Coulomb, Sticking::Full] {
                let found = evaluate_point(&*law, 0, sticking, u, &begin);
                prop_assert!(found.numbers().all(f64::is_finite), "{} {sticking:?} {found:?}", law.info().name);
                prop_assert_eq!(found.regime == Regime::Open, u[2] <= 0.0);
                prop_assert!(found.regime != Regime::Invalid && found.traction[2] >= 0.0);
            }
        }
    }

    /// Input that is no finite number is counted, and nothing that comes out can be taken for a number.
    #[test]
    fn input_that_is_no_number_is_invalid(
        mu in 0.0..10.0, history in any_history(),
        u in prop::array::uniform3(extreme()), begin in prop::array::uniform5(extreme()), which in 0..8_usize,
        value in prop::sample::select(vec![f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ) {
        let (mut u, mut begin) = (u, begin);
        if which < 3 { u[which] = value } else { begin[which - 3] = value }
        for law in laws(mu, history) {
            for sticking in [Sticking::Coulomb, Sticking::Full] {
                let found = evaluate_point(&*law, 0, sticking, u, &begin);
                prop_assert_eq!(found.regime, Regime::Invalid);
                prop_assert!(found.numbers().all(f64::is_nan), "{found:?}");
            }
        }
    }
}

/// Positive numbers, most of them ordinary.
fn positive() -> impl Strategy<Value = f64> {
    prop_oneof![3 => log_uniform(1e-9, 1e9), 1 => log_uniform(1e-50, 1e50)]
}

/// Numbers of either sign, most of them ordinary.
fn signed() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -10.0..10.0, 1 => -1e3..1e3]
}

fn range() -> impl Strategy<Value = Option<[f64; 2]>> {
    prop::option::of((positive(), positive()).prop_map(|(a, b)| [a.min(b), a.max(b)]))
}

/// Whatever a constructor accepts gives no NaN.
fn check_accepted<C: ContactCurves + Clone>(
    curves: Result<C, Error>,
    mu: f64,
    u: [f64; 3],
    begin: [f64; 5],
) -> Result<(), TestCaseError> {
    let Ok(curves) = curves else { return Ok(()) };
    for history in histories() {
        check_finite(&law(curves.clone(), mu, history), u, begin)?;
    }
    Ok(())
}

fn check_finite(law: &dyn TractionLaw, u: [f64; 3], begin: [f64; 5]) -> Result<(), TestCaseError> {
    for sticking in [Sticking::Coulomb, Sticking::Full] {
        let found = evaluate_point(law, 0, sticking, u, &begin);
        prop_assert!(found.numbers().all(f64::is_finite), "{sticking:?} {found:?}");
        prop_assert!(found.traction[2] >= 0.0);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    #[test]
    fn accepted_fits_give_finite_output(
        (a, b, c, d) in (-50.0..50.0_f64, signed(), signed(), signed()), (e, u_ref, normal_range) in (positive(), positive(), range()),
        (ka, kb, kc, kd) in (-50.0..50.0_f64, signed(), signed(), signed()), (k_u_ref, k_range) in (positive(), range()),
        ends in prop::sample::select(vec![TangentialEnds::Mindlin, TangentialEnds::Constant]), isotropic: bool,
        mu in positive(), u in prop::array::uniform3(extreme()), begin in prop::array::uniform5(extreme()),
    ) {
        let normal = NormalFit { a, b, c, d, e, u_ref, t_ref: 1.0, range: normal_range };
        let fit = TangentialFit { a: ka, b: kb.abs(), c: kc, d: kd.abs(), u_ref: k_u_ref, k_ref: 1.0, range: k_range, ends };
        let curves = {
            let other = if isotropic { fit } else { TangentialFit { range: None, ..fit } };
            FittedCurves::try_new(normal, [fit, other])
        };
        check_accepted(curves.clone(), mu, u, begin)?;
        let Ok(curves) = curves else { return Ok(()) };
        let curves = PointParameters::uniform(curves, 1);
        for history in histories() {
            let mu = PointParameters::uniform(mu, 1);
            check_finite(&RoughLaw::try_new(FittedPoints::new(&curves), mu.clone(), history).unwrap(), u, begin)?;
            let single = FittedPoints::<f32>::new(&curves);
            check_finite(&FrictionalLaw::try_new(single, mu, history).unwrap(), u, begin)?;
        }
    }

    #[test]
    fn accepted_stiffnesses_and_asperities_give_finite_output(
        k in prop::array::uniform3(positive()), mut gaps in prop::collection::vec(positive(), 1..4),
        density in positive(), radii in prop::array::uniform2(positive()), modulus in positive(), nu in -1.0..=0.5_f64,
        reading in prop::sample::select(vec![TangentialReading::Mindlin, TangentialReading::Paper]),
        mu in positive(), u in prop::array::uniform3(extreme()), begin in prop::array::uniform5(extreme()),
    ) {
        check_accepted(ElasticCurves::try_new(k[0], [k[1], k[2]]), mu, u, begin)?;
        gaps.sort_by(f64::total_cmp);
        let n = gaps.len();
        let probabilities: Vec<f64> = (0..n).map(|i| i as f64 / (n - 1).max(1) as f64).collect();
        let material = ElasticPair::new(modulus, nu);
        for gaps in [
            GapDistribution::try_from_quantiles(&probabilities, &gaps),
            GapDistribution::try_from_samples(gaps),
        ] {
            let curves = gaps
                .and_then(|gaps| AsperityPopulation::try_new(gaps, density, radii))
                .and_then(|population| AsperitySumCurves::try_new(population, material, reading));
            check_accepted(curves, mu, u, begin)?;
        }
    }
}
