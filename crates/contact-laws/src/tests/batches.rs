//! What must not matter: the unit system, the order of the points, how a batch is cut, how parameters are stored.

use std::iter::once;

use proptest::prelude::*;

use super::oracle::{AsGiven, Rule, expected};
use super::{STEEL, law};
use crate::testing::{
    PointResponse, elastic_curves, evaluate_batch, evaluate_point, fitted_curves, friction_coefficient, step,
};
use crate::*;

/// A system of units by its factors: the number of a length or traction in it over the number in SI.
#[derive(Debug, Clone, Copy)]
struct Units {
    length: f64,
    traction: f64,
}

impl Units {
    const SI: Self = Self {
        length: 1.0,
        traction: 1.0,
    };
    /// Millimetres, tonnes, seconds: tractions in MPa.
    const MM_T_S: Self = Self {
        length: 1e3,
        traction: 1e-6,
    };

    fn jump(self, u: [f64; 3]) -> [f64; 3] {
        u.map(|v| v * self.length)
    }

    fn begin(self, state: [f64; 5]) -> [f64; 5] {
        let [x, y, n, tx, ty] = state;
        let [x, y, n] = self.jump([x, y, n]);
        [x, y, n, tx * self.traction, ty * self.traction]
    }

    fn response(self, found: &PointResponse) -> PointResponse {
        let [x, y, n, tx, ty] = found.end[..] else {
            panic!("five components of state")
        };
        PointResponse {
            traction: found.traction.map(|t| t * self.traction),
            tangent: found.tangent.map(|row| row.map(|d| d * (self.traction / self.length))),
            end: self.begin([x, y, n, tx, ty]).to_vec(),
            regime: found.regime,
        }
    }
}

/// A number that all the systems here represent exactly: 24 significant bits, no denormals.
fn exact(value: f64) -> f64 {
    let short = value as f32;
    if short.is_normal() {
        short.into()
    } else {
        0.0_f64.copysign(value)
    }
}

/// Curves of one kind in any system.
fn elastic_in(units: Units) -> ElasticCurves {
    let k = units.traction / units.length;
    ElasticCurves::try_new(2e12 * k, [1.5e12 * k, 1e12 * k]).unwrap()
}

fn asperities_in(units: Units, reading: TangentialReading) -> AsperitySumCurves {
    let n = 60;
    let probabilities: Vec<f64> = (0..=n).map(|i| f64::from(i) / f64::from(n)).collect();
    let gaps: Vec<f64> = probabilities
        .iter()
        .map(|p| exact(2e-5 * (p.powf(0.4) + p.powi(6))) * units.length)
        .collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, &gaps).unwrap();
    let radii = [1.2e-3, 1.5e-3].map(|r| r * units.length);
    let population = AsperityPopulation::try_new(gaps, 1.4e6 / units.length / units.length, radii).unwrap();
    let material = ElasticPair::new(STEEL.youngs_modulus * units.traction, STEEL.poisson_ratio);
    AsperitySumCurves::try_new(population, material, reading).unwrap()
}

fn table_in<C: ContactCurves>(units: Units, source: C) -> Tabulated<C> {
    let range = [1e-8, 3e-5].map(|u| exact(u) * units.length);
    let options = TableOptions {
        tolerance_normal: 1e-3,
        tolerance_tangential: 1e-2,
        ..TableOptions::default()
    };
    Tabulated::try_new(source, range, options).unwrap()
}

/// Points as [`step`] makes them, in numbers that the systems represent exactly.
fn steps() -> impl Strategy<Value = Vec<([f64; 3], [f64; 5])>> {
    let exact_step = |(u, [x, y, n, tx, ty]): ([f64; 3], [f64; 5])| {
        let [tx, ty] = [tx, ty].map(|t| exact(t * 1e-6) * 1e6);
        (u.map(exact), [exact(x), exact(y), exact(n), tx, ty])
    };
    prop::collection::vec(step().prop_map(exact_step), 20)
}

fn histories() -> impl Strategy<Value = HistoryRule> {
    prop::sample::select(vec![HistoryRule::Incremental, HistoryRule::Paper])
}

/// Bitwise the same in a system whose factors are powers of two.
fn same_bits<C: ContactCurves>(
    curves_in: impl Fn(Units) -> C,
    units: Units,
    (mu, history): (f64, HistoryRule),
    steps: &[([f64; 3], [f64; 5])],
) -> Result<(), TestCaseError> {
    let [si, other] = [Units::SI, units].map(|units| law(curves_in(units), mu, history));
    for &(u, begin) in steps {
        for sticking in [Sticking::Coulomb, Sticking::Full] {
            let here = units.response(&evaluate_point(&si, 0, sticking, u, &begin));
            let there = evaluate_point(&other, 0, sticking, units.jump(u), &units.begin(begin));
            prop_assert!(here.is_identical(&there), "{} {here:?} {there:?}", si.info().name);
        }
    }
    Ok(())
}

/// The same to 1e-12 in mm-t-s, with the same regimes.
fn same_in_millimetres<C: ContactCurves>(
    curves_in: impl Fn(Units) -> C,
    (mu, history): (f64, HistoryRule),
    steps: &[([f64; 3], [f64; 5])],
) -> Result<(), TestCaseError> {
    let units = Units::MM_T_S;
    let back = Units {
        length: 1.0 / units.length,
        traction: 1.0 / units.traction,
    };
    let [si, other] = [Units::SI, units].map(|units| law(curves_in(units), mu, history));
    let rule = match history {
        HistoryRule::Paper => Rule::Paper,
        _ => Rule::Incremental,
    };
    for &(u, begin) in steps {
        let here = evaluate_point(&si, 0, Sticking::Coulomb, u, &begin);
        let there = evaluate_point(&other, 0, Sticking::Coulomb, units.jump(u), &units.begin(begin));
        let there = back.response(&there);
        // How far cancellation makes these numbers uncertain at all.
        let oracle = expected(&AsGiven(si.curves().at(0)), mu, rule, Sticking::Coulomb, u, &begin);
        if oracle.cone_distance < 1e-11 {
            continue;
        }
        prop_assert_eq!(here.regime, there.regime);
        for i in 0..3 {
            let value = oracle.traction[i].value;
            let allowed = 1e-12 * value.value.abs() + 1e-14 * value.rounding;
            prop_assert!(
                (here.traction[i] - there.traction[i]).abs() <= allowed,
                "{here:?} {there:?}"
            );
            for k in 0..3 {
                let entry = oracle.traction[i].derivatives[k];
                let over_closing = if k == 2 && u[2] > 0.0 {
                    value.rounding / u[2]
                } else {
                    0.0
                };
                let allowed = 1e-12 * entry.value.abs() + 1e-13 * (entry.rounding + over_closing);
                prop_assert!(
                    (here.tangent[i][k] - there.tangent[i][k]).abs() <= allowed,
                    "{here:?} {there:?}"
                );
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn powers_of_two_do_not_change_a_bit(
        length in -20..20, traction in -20..20, mu in friction_coefficient(), history in histories(), steps in steps(),
    ) {
        let units = Units { length: 2.0_f64.powi(length), traction: 2.0_f64.powi(traction) };
        let case = (mu, history);
        same_bits(elastic_in, units, case, &steps)?;
        same_bits(|units| table_in(units, elastic_in(units)), units, case, &steps)?;
        // Asperities take roots of lengths, so there the factor is a power of four.
        let units = Units { length: 4.0_f64.powi(length), ..units };
        for reading in [TangentialReading::Mindlin, TangentialReading::Paper] {
            same_bits(|units| asperities_in(units, reading), units, case, &steps)?;
        }
        same_bits(|units| table_in(units, asperities_in(units, TangentialReading::Mindlin)), units, case, &steps)?;
    }

    #[test]
    fn millimetres_and_tonnes_change_nothing(
        fitted in fitted_curves(), mu in friction_coefficient(), history in histories(), steps in steps(),
    ) {
        let case = (mu, history);
        same_in_millimetres(elastic_in, case, &steps)?;
        same_in_millimetres(|units| asperities_in(units, TangentialReading::Mindlin), case, &steps)?;
        same_in_millimetres(|units| asperities_in(units, TangentialReading::Paper), case, &steps)?;
        same_in_millimetres(
            |units| table_in(units, asperities_in(units, TangentialReading::Mindlin)), case, &steps,
        )?;
        let fitted_in = |units: Units| {
            let range = |range: Option<[f64; 2]>| range.map(|range| range.map(|u| u * units.length));
            let normal = fitted.normal_fit();
            let normal = NormalFit {
                a: normal.a + units.traction.ln(),
                u_ref: normal.u_ref * units.length,
                range: range(normal.range),
                ..*normal
            };
            let tangential = fitted.tangential_fits().map(|fit| TangentialFit {
                a: fit.a + (units.traction / units.length).ln(),
                u_ref: fit.u_ref * units.length,
                range: range(fit.range),
                ..fit
            });
            FittedCurves::try_new(normal, tangential).unwrap()
        };
        same_in_millimetres(fitted_in, case, &steps)?;
    }
}

#[derive(Debug, Clone)]
struct Points {
    jump: Vec<[f64; 3]>,
    begin: Vec<Vec<f64>>,
    curves: Vec<u32>,
    mu: Vec<u32>,
}

impl Points {
    fn len(&self) -> usize {
        self.jump.len()
    }

    fn permuted(&self, order: &[usize]) -> Self {
        Self {
            jump: order.iter().map(|&i| self.jump[i]).collect(),
            begin: order.iter().map(|&i| self.begin[i].clone()).collect(),
            curves: order.iter().map(|&i| self.curves[i]).collect(),
            mu: order.iter().map(|&i| self.mu[i]).collect(),
        }
    }
}

const N_SETS: u32 = 3;

/// Points in all regimes, a few of them with input that is no number, with an order and cuts.
fn points() -> impl Strategy<Value = (Points, Vec<usize>, Vec<usize>)> {
    let point = (step(), 0..N_SETS, 0..N_SETS, 0..60_usize);
    prop::collection::vec(point, 1..200).prop_flat_map(|list| {
        let n = list.len();
        let mut points = Points {
            jump: list.iter().map(|point| point.0.0).collect(),
            begin: list.iter().map(|point| point.0.1.to_vec()).collect(),
            curves: list.iter().map(|point| point.1).collect(),
            mu: list.iter().map(|point| point.2).collect(),
        };
        for (i, point) in list.iter().enumerate() {
            match point.3 {
                0 => points.jump[i][i % 3] = f64::NAN,
                1 => points.begin[i][i % 5] = f64::INFINITY,
                _ => {}
            }
        }
        let order = Just((0..n).collect::<Vec<usize>>()).prop_shuffle();
        (Just(points), order, prop::collection::vec(0..=n, 0..8))
    })
}

fn chunks(n: usize, cuts: &[usize]) -> Vec<std::ops::Range<usize>> {
    let mut cuts: Vec<usize> = cuts.iter().copied().chain([0, n]).collect();
    cuts.sort_unstable();
    // Evaluated from the last chunk to the first.
    cuts.windows(2).rev().map(|pair| pair[0]..pair[1]).collect()
}

/// The parameters of points, stored with an index or apart.
fn stored<T: Clone>(sets: &[T], index: &[u32], indexed: bool) -> PointParameters<T> {
    if indexed {
        PointParameters::try_indexed(sets.to_vec(), index.to_vec()).unwrap()
    } else {
        PointParameters::per_point(index.iter().map(|&i| sets[i as usize].clone()).collect())
    }
}

/// Every storage, order and cut gives the bits of point after point.
fn neutral<C: ContactCurves + Clone>(
    curves: &[C],
    mu: &[f64],
    history: HistoryRule,
    points: &Points,
    order: &[usize],
    cuts: &[usize],
) -> Result<(), TestCaseError> {
    let n = points.len();
    let permuted = points.permuted(order);
    for sticking in [Sticking::Coulomb, Sticking::Full] {
        let single = |i: usize| {
            let curves = curves[points.curves[i] as usize].clone();
            let law = law(curves, mu[points.mu[i] as usize], history);
            evaluate_point(&law, 0, sticking, points.jump[i], &points.begin[i])
        };
        let expected: Vec<PointResponse> = (0..n).map(single).collect();
        for (curves_indexed, mu_indexed) in [(false, false), (false, true), (true, false), (true, true)] {
            let law_of = |points: &Points| {
                let curves = stored(curves, &points.curves, curves_indexed);
                FrictionalLaw::try_new(curves, stored(mu, &points.mu, mu_indexed), history).unwrap()
            };
            let found = evaluate_batch(&law_of(points), sticking, once(0..n), &points.jump, &points.begin);
            prop_assert!(found.iter().zip(&expected).all(|(a, b)| a.is_identical(b)));
            let law = law_of(&permuted);
            let found = evaluate_batch(&law, sticking, chunks(n, cuts), &permuted.jump, &permuted.begin);
            prop_assert!(found.iter().zip(order).all(|(a, &i)| a.is_identical(&expected[i])));
        }
        let law = FrictionalLaw::try_new(
            PointParameters::uniform(curves[0].clone(), n),
            PointParameters::uniform(mu[0], n),
            history,
        )
        .unwrap();
        let found = evaluate_batch(&law, sticking, once(0..n), &points.jump, &points.begin);
        let turned = evaluate_batch(&law, sticking, chunks(n, cuts), &permuted.jump, &permuted.begin);
        prop_assert!(turned.iter().zip(order).all(|(a, &i)| a.is_identical(&found[i])));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn order_cuts_and_storage_do_not_change_a_bit(
        fitted in prop::collection::vec(fitted_curves(), N_SETS as usize),
        elastic in prop::collection::vec(elastic_curves(), N_SETS as usize),
        mu in prop::collection::vec(friction_coefficient(), N_SETS as usize),
        history in histories(),
        (points, order, cuts) in points(),
    ) {
        neutral(&fitted, &mu, history, &points, &order, &cuts)?;
        neutral(&elastic, &mu, history, &points, &order, &cuts)?;
    }
}

/// A batch large enough for every path of a kernel, with all regimes in it; and without tangents the same tractions.
#[test]
fn a_large_batch_in_odd_chunks() {
    let n = 1000;
    let wave = |i: usize, f: f64| (i as f64 * f).sin();
    let jump: Vec<[f64; 3]> = (0..n)
        .map(|i| [3e-6 * wave(i, 0.7), 2e-6 * wave(i, 1.3), 4e-6 * (0.4 + wave(i, 0.37))])
        .collect();
    let begin: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            vec![
                2e-6 * wave(i, 0.71),
                2e-6 * wave(i, 1.1),
                4e-6 * (0.4 + wave(i, 0.36)),
                0.0,
                0.0,
            ]
        })
        .collect();
    let other = NormalFit {
        a: 16.0,
        ..super::normal_fit()
    };
    let other = FittedCurves::try_new(other, *super::fitted().tangential_fits()).unwrap();
    let index = (0..n).map(|i| u32::from(i % 3 == 0)).collect();
    let curves = PointParameters::try_indexed(vec![super::fitted(), other], index).unwrap();
    let mu = PointParameters::per_point((0..n).map(|i| 0.1 + 1e-3 * i as f64).collect());
    let law = FrictionalLaw::try_new(curves, mu, HistoryRule::Incremental).unwrap();

    let whole = evaluate_batch(&law, Sticking::Coulomb, once(0..n), &jump, &begin);
    let mut counts = RegimeCounts::default();
    whole.iter().for_each(|point| counts.count(point.regime));
    assert!(counts.stick > 50 && counts.slip > 50 && counts.open > 50, "{counts:?}");
    let cuts = [600..n, 0..1, 1..64, 64..64, 64..131, 131..600];
    let parts = evaluate_batch(&law, Sticking::Coulomb, cuts, &jump, &begin);
    assert!(whole.iter().zip(&parts).all(|(a, b)| a.is_identical(b)));

    let columns: [Vec<f64>; 3] = std::array::from_fn(|q| jump.iter().map(|u| u[q]).collect());
    let state: Vec<f64> = (0..5).flat_map(|c| begin.iter().map(move |state| state[c])).collect();
    let (mut end, mut t) = (vec![0.0; 5 * n], [vec![0.0; n], vec![0.0; n], vec![0.0; n]]);
    let [x, y, normal] = &mut t;
    let found = law.evaluate(
        0..n,
        Sticking::Coulomb,
        Components::new(&columns[0], &columns[1], &columns[2]),
        StateView::new(&state, n, 0),
        StateViewMut {
            data: &mut end,
            stride: n,
            offset: 0,
        },
        ComponentsMut::new(x, y, normal),
        None,
        None,
    );
    assert_eq!(found, counts);
    for (i, point) in whole.iter().enumerate() {
        assert!((0..3).all(|q| t[q][i].to_bits() == point.traction[q].to_bits()));
        assert!((0..5).all(|c| end[c * n + i].to_bits() == point.end[c].to_bits()));
    }
}
