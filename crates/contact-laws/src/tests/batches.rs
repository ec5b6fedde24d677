//! What must not matter: the unit system, the order of the points, how a batch is cut, how parameters are stored.

use std::iter::once;

use proptest::prelude::*;

use super::oracle::{AsGiven, expected};
use super::{STEEL, any_history, histories, law, memory, remembered, rough};
use crate::friction::rule::Memory;
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

    fn state(self, history: HistoryRule, state: &[f64]) -> [f64; 5] {
        let &[x, y, n, memory_x, memory_y] = state else {
            panic!("five components of state")
        };
        let [x, y, n] = self.jump([x, y, n]);
        let memory = match memory(history) {
            Memory::Traction => self.traction,
            Memory::Stretch => self.length,
        };
        [x, y, n, memory_x * memory, memory_y * memory]
    }

    fn response(self, history: HistoryRule, found: &PointResponse) -> PointResponse {
        PointResponse {
            traction: found.traction.map(|t| t * self.traction),
            tangent: found.tangent.map(|row| row.map(|d| d * (self.traction / self.length))),
            end: self.state(history, &found.end).to_vec(),
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

fn fitted_in(si: &FittedCurves, units: Units) -> FittedCurves {
    let range = |range: Option<[f64; 2]>| range.map(|range| range.map(|u| u * units.length));
    let normal = si.normal_fit();
    let normal = NormalFit {
        t_ref: normal.t_ref * units.traction,
        u_ref: normal.u_ref * units.length,
        range: range(normal.range),
        ..*normal
    };
    let tangential = si.tangential_fits().map(|fit| TangentialFit {
        k_ref: fit.k_ref * (units.traction / units.length),
        u_ref: fit.u_ref * units.length,
        range: range(fit.range),
        ..fit
    });
    FittedCurves::try_new(normal, tangential).unwrap()
}

/// The fitted curves evaluated in single precision.
fn rough_in_single(curves: FittedCurves, mu: f64, history: HistoryRule) -> FrictionalLaw<FittedPoints<f32>> {
    let points = FittedPoints::new(&PointParameters::uniform(curves, 1));
    FrictionalLaw::try_new(points, PointParameters::uniform(mu, 1), history).unwrap()
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

/// A begin state for the rule, in numbers that the systems represent exactly.
fn remembered_exactly(history: HistoryRule, begin: [f64; 5]) -> [f64; 5] {
    let [x, y, n, memory_x, memory_y] = remembered(history, begin);
    match memory(history) {
        Memory::Traction => begin,
        Memory::Stretch => [x, y, n, exact(memory_x), exact(memory_y)],
    }
}

/// Bitwise the same in a system whose factors are powers of two.
fn same_bits<L: TractionLaw>(
    law_in: impl Fn(Units) -> L,
    units: Units,
    history: HistoryRule,
    steps: &[([f64; 3], [f64; 5])],
) -> Result<(), TestCaseError> {
    let [si, other] = [Units::SI, units].map(law_in);
    for &(u, begin) in steps {
        let begin = remembered_exactly(history, begin);
        for sticking in [Sticking::Coulomb, Sticking::Full] {
            let here = units.response(history, &evaluate_point(&si, 0, sticking, u, &begin));
            let there = evaluate_point(&other, 0, sticking, units.jump(u), &units.state(history, &begin));
            prop_assert!(here.is_identical(&there), "{} {here:?} {there:?}", si.info().name);
        }
    }
    Ok(())
}

/// The same to 1e-12 in mm-t-s, with the same regimes.
fn same_in_millimetres<C: ContactCurves, L: TractionLaw>(
    curves_in: impl Fn(Units) -> C,
    law_of: impl Fn(C, f64, HistoryRule) -> L,
    (mu, history): (f64, HistoryRule),
    steps: &[([f64; 3], [f64; 5])],
) -> Result<(), TestCaseError> {
    let units = Units::MM_T_S;
    let back = Units {
        length: 1.0 / units.length,
        traction: 1.0 / units.traction,
    };
    let [si, other] = [Units::SI, units].map(|units| law_of(curves_in(units), mu, history));
    let curves = curves_in(Units::SI);
    for &(u, begin) in steps {
        let begin = remembered_exactly(history, begin);
        let here = evaluate_point(&si, 0, Sticking::Coulomb, u, &begin);
        let there = evaluate_point(
            &other,
            0,
            Sticking::Coulomb,
            units.jump(u),
            &units.state(history, &begin),
        );
        let there = back.response(history, &there);
        // How far cancellation makes these numbers uncertain at all.
        let oracle = expected(&AsGiven(&curves), mu, history, Sticking::Coulomb, u, &begin);
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
        fitted in fitted_curves(), length in -20..20, traction in -20..20, mu in friction_coefficient(),
        history in any_history(), steps in steps(),
    ) {
        let units = Units { length: 2.0_f64.powi(length), traction: 2.0_f64.powi(traction) };
        same_bits(|units| law(fitted_in(&fitted, units), mu, history), units, history, &steps)?;
        same_bits(|units| rough(fitted_in(&fitted, units), mu, history), units, history, &steps)?;
        same_bits(|units| rough_in_single(fitted_in(&fitted, units), mu, history), units, history, &steps)?;
        same_bits(|units| law(elastic_in(units), mu, history), units, history, &steps)?;
        same_bits(|units| law(table_in(units, elastic_in(units)), mu, history), units, history, &steps)?;
        // Asperities take roots of lengths, so there the factor is a power of four.
        let units = Units { length: 4.0_f64.powi(length), ..units };
        for reading in [TangentialReading::Mindlin, TangentialReading::Paper] {
            same_bits(|units| law(asperities_in(units, reading), mu, history), units, history, &steps)?;
        }
        let table = |units| table_in(units, asperities_in(units, TangentialReading::Mindlin));
        same_bits(|units| law(table(units), mu, history), units, history, &steps)?;
    }

    #[test]
    fn millimetres_and_tonnes_change_nothing(
        fitted in fitted_curves(), mu in friction_coefficient(), history in any_history(), steps in steps(),
    ) {
        let case = (mu, history);
        same_in_millimetres(elastic_in, law, case, &steps)?;
        same_in_millimetres(|units| asperities_in(units, TangentialReading::Mindlin), law, case, &steps)?;
        same_in_millimetres(|units| asperities_in(units, TangentialReading::Paper), law, case, &steps)?;
        same_in_millimetres(
            |units| table_in(units, asperities_in(units, TangentialReading::Mindlin)), law, case, &steps,
        )?;
        // By reference values, and in the logarithms as a file without them has it.
        same_in_millimetres(|units| fitted_in(&fitted, units), law, case, &steps)?;
        same_in_millimetres(|units| fitted_in(&fitted, units), rough, case, &steps)?;
        let in_logarithms = |units: Units| {
            let other = fitted_in(&fitted, units);
            let (normal, tangential) = (other.normal_fit(), other.tangential_fits());
            let normal = NormalFit { a: normal.a + normal.t_ref.ln(), t_ref: 1.0, ..*normal };
            let tangential = tangential.map(|fit| TangentialFit { a: fit.a + fit.k_ref.ln(), k_ref: 1.0, ..fit });
            FittedCurves::try_new(normal, tangential).unwrap()
        };
        same_in_millimetres(in_logarithms, law, case, &steps)?;
        same_in_millimetres(in_logarithms, rough, case, &steps)?;
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

pub(super) fn chunks(n: usize, cuts: &[usize]) -> Vec<std::ops::Range<usize>> {
    let mut cuts: Vec<usize> = cuts.iter().copied().chain([0, n]).collect();
    cuts.sort_unstable();
    // Evaluated from the last chunk to the first.
    cuts.windows(2).rev().map(|pair| pair[0]..pair[1]).collect()
}

/// The parameters of points, stored with an index or apart.
pub(super) fn stored<T: Clone>(sets: &[T], index: &[u32], indexed: bool) -> PointParameters<T> {
    if indexed {
        PointParameters::try_indexed(sets.to_vec(), index.to_vec()).unwrap()
    } else {
        PointParameters::per_point(index.iter().map(|&i| sets[i as usize].clone()).collect())
    }
}

/// Every storage, order and cut gives the bits of point after point. `law_of` makes the law from curves and friction
/// coefficients.
fn neutral<C: Clone, L: TractionLaw>(
    law_of: impl Fn(PointParameters<C>, PointParameters<f64>) -> L,
    curves: &[C],
    mu: &[f64],
    points: &Points,
    order: &[usize],
    cuts: &[usize],
) -> Result<(), TestCaseError> {
    let n = points.len();
    let permuted = points.permuted(order);
    for sticking in [Sticking::Coulomb, Sticking::Full] {
        let single = |i: usize| {
            let curves = PointParameters::uniform(curves[points.curves[i] as usize].clone(), 1);
            let law = law_of(curves, PointParameters::uniform(mu[points.mu[i] as usize], 1));
            evaluate_point(&law, 0, sticking, points.jump[i], &points.begin[i])
        };
        let expected: Vec<PointResponse> = (0..n).map(single).collect();
        for (curves_indexed, mu_indexed) in [(false, false), (false, true), (true, false), (true, true)] {
            let law_of = |points: &Points| {
                law_of(
                    stored(curves, &points.curves, curves_indexed),
                    stored(mu, &points.mu, mu_indexed),
                )
            };
            let found = evaluate_batch(&law_of(points), sticking, once(0..n), &points.jump, &points.begin);
            prop_assert!(found.iter().zip(&expected).all(|(a, b)| a.is_identical(b)));
            let law = law_of(&permuted);
            let found = evaluate_batch(&law, sticking, chunks(n, cuts), &permuted.jump, &permuted.begin);
            prop_assert!(found.iter().zip(order).all(|(a, &i)| a.is_identical(&expected[i])));
        }
        let law = law_of(
            PointParameters::uniform(curves[0].clone(), n),
            PointParameters::uniform(mu[0], n),
        );
        let found = evaluate_batch(&law, sticking, once(0..n), &points.jump, &points.begin);
        let turned = evaluate_batch(&law, sticking, chunks(n, cuts), &permuted.jump, &permuted.begin);
        prop_assert!(turned.iter().zip(order).all(|(a, &i)| a.is_identical(&found[i])));
    }
    Ok(())
}

/// Fits with and without range and with equal stiffnesses: whether there is any with or without in a law changes the
/// code that evaluates all of them.
fn sets_of_fits() -> impl Strategy<Value = Vec<FittedCurves>> {
    let set = (fitted_curves(), any::<bool>(), any::<bool>()).prop_map(|(curves, bare, isotropic)| {
        let (mut normal, [mut x, mut y]) = (*curves.normal_fit(), *curves.tangential_fits());
        if bare {
            (normal.range, x.range, y.range) = (None, None, None);
        }
        FittedCurves::try_new(normal, [x, if isotropic { x } else { y }]).unwrap()
    });
    prop::collection::vec(set, N_SETS as usize)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn order_cuts_and_storage_do_not_change_a_bit(
        fitted in sets_of_fits(),
        elastic in prop::collection::vec(elastic_curves(), N_SETS as usize),
        mu in prop::collection::vec(friction_coefficient(), N_SETS as usize),
        history in any_history(),
        (points, order, cuts) in points(),
    ) {
        let by_point = |curves, mu| FrictionalLaw::try_new(curves, mu, history).unwrap();
        neutral(by_point, &fitted, &mu, &points, &order, &cuts)?;
        let by_point = |curves, mu| FrictionalLaw::try_new(curves, mu, history).unwrap();
        neutral(by_point, &elastic, &mu, &points, &order, &cuts)?;
        let in_blocks = |curves, mu| RoughLaw::try_new(FittedPoints::new(&curves), mu, history).unwrap();
        neutral(in_blocks, &fitted, &mu, &points, &order, &cuts)?;
        let in_single = |curves, mu| FrictionalLaw::try_new(FittedPoints::<f32>::new(&curves), mu, history).unwrap();
        neutral(in_single, &fitted, &mu, &points, &order, &cuts)?;
        let springs: Vec<_> = elastic
            .iter()
            .map(|curves| Foundation::try_new(vec![1e-8], vec![curves.normal(1e-6).1], 0.8).unwrap())
            .collect();
        let on_springs = |springs: PointParameters<Foundation>, mu| {
            let curves = PointParameters::uniform(super::elastic(), springs.len());
            FoundationLaw::try_new(springs, curves, mu).unwrap()
        };
        neutral(on_springs, &springs, &mu, &points, &order, &cuts)?;
    }
}

/// Points of which many in a row stick, slip, reopen or leave the fitted range, so that some blocks of them know nothing
/// of the rest.
fn uneven(n: usize, history: HistoryRule) -> Points {
    let wave = |i: usize, f: f64| (i as f64 * f).sin();
    let jump = |i: usize| {
        let along = if (i / 70).is_multiple_of(2) { 1e-9 } else { 4e-6 };
        let n = match i / 90 % 3 {
            0 => 1e-6 * (2.0 + wave(i, 0.3)),
            1 => 1e-5 * (1.0 + 0.5 * wave(i, 0.3)),
            _ => 1e-7 * (1.0 + 1.5 * wave(i, 0.3)),
        };
        [along * wave(i, 0.7), along * wave(i, 1.3), n]
    };
    let begin = |i: usize| {
        let [x, y, n] = jump(i);
        let n = if i % 200 < 120 { n.abs() } else { -n };
        let memory = if n > 0.0 { 2e3 } else { 0.0 };
        let [tx, ty] = [memory * wave(i, 0.9), memory * wave(i, 1.9)];
        remembered(history, [0.9 * x, 1.1 * y, n, tx, ty]).to_vec()
    };
    Points {
        jump: (0..n).map(jump).collect(),
        begin: (0..n).map(begin).collect(),
        curves: (0..n).map(|i| (i / 40) as u32 % N_SETS).collect(),
        mu: (0..n).map(|i| (i / 11) as u32 % N_SETS).collect(),
    }
}

/// Chunks of every length from 1 to 70 points, from every storage.
#[test]
fn every_length_of_chunk_gives_the_same_bits() {
    let n = 450;
    let [x, y] = *super::fitted().tangential_fits();
    let isotropic = FittedCurves::try_new(super::normal_fit(), [x; 2]).unwrap();
    let bare = NormalFit {
        range: None,
        ..super::normal_fit()
    };
    let bare = FittedCurves::try_new(bare, [x, y].map(|fit| TangentialFit { range: None, ..fit })).unwrap();
    let (sets, mu) = ([super::fitted(), isotropic, bare], [0.3, 0.6, 0.05]);
    for history in histories() {
        let points = uneven(n, history);
        let chunked = |law: &dyn TractionLaw, length: usize, offset: usize| {
            let starts = (offset..n).step_by(length);
            let chunks = starts.map(|start| start..n.min(start + length)).chain(once(0..offset));
            evaluate_batch(law, Sticking::Coulomb, chunks, &points.jump, &points.begin)
        };
        let curves = [
            stored(&sets, &points.curves, false),
            stored(&sets, &points.curves, true),
            PointParameters::uniform(sets[1], n),
        ];
        for (storage, curves) in curves.into_iter().enumerate() {
            let mu = match storage {
                2 => PointParameters::uniform(mu[0], n),
                _ => stored(&mu, &points.mu, storage == 1),
            };
            let laws: [Box<dyn TractionLaw>; 3] = [
                Box::new(FrictionalLaw::try_new(curves.clone(), mu.clone(), history).unwrap()),
                Box::new(RoughLaw::try_new(FittedPoints::new(&curves), mu.clone(), history).unwrap()),
                Box::new(FrictionalLaw::try_new(FittedPoints::<f32>::new(&curves), mu, history).unwrap()),
            ];
            for law in laws {
                let one_by_one = chunked(&*law, 1, 0);
                let mut counts = RegimeCounts::default();
                one_by_one.iter().for_each(|point| counts.count(point.regime));
                let least = n / 20;
                assert!(
                    counts.stick > least && counts.slip > least && counts.open > least,
                    "{counts:?}"
                );
                for length in 2..=70 {
                    let found = chunked(&*law, length, length * 7 % 64);
                    for (i, (a, b)) in found.iter().zip(&one_by_one).enumerate() {
                        assert!(a.is_identical(b), "{history:?} {storage} {length} {i}: {a:?} {b:?}");
                    }
                }
            }
        }
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
    in_odd_chunks(
        &FrictionalLaw::try_new(curves.clone(), mu.clone(), HistoryRule::Incremental).unwrap(),
        &jump,
        &begin,
    );
    in_odd_chunks(
        &RoughLaw::try_new(FittedPoints::new(&curves), mu, HistoryRule::Incremental).unwrap(),
        &jump,
        &begin,
    );
}

fn in_odd_chunks(law: &dyn TractionLaw, jump: &[[f64; 3]], begin: &[Vec<f64>]) {
    let n = jump.len();
    let whole = evaluate_batch(law, Sticking::Coulomb, once(0..n), jump, begin);
    let mut counts = RegimeCounts::default();
    whole.iter().for_each(|point| counts.count(point.regime));
    assert!(counts.stick > 50 && counts.slip > 50 && counts.open > 50, "{counts:?}");
    let cuts = [600..n, 0..1, 1..64, 64..64, 64..131, 131..600];
    let parts = evaluate_batch(law, Sticking::Coulomb, cuts, jump, begin);
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
        StateViewMut::new(&mut end, n, 0),
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
