//! The derivative of the update along a direction of jump and begin state, for every law.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::iter::once;

use proptest::prelude::*;

use super::batches::chunks;
use super::invariants::{TABLE, laws};
use super::kinks::extreme;
use super::resolved::{cases, paths};
use super::{any_history, elastic, fitted, hold};
use crate::testing::{
    PointDerivative, derivative_at_point, derivative_batch, derivative_error, evaluate_point, log_uniform,
};
use crate::*;

/// Numbers from -1 to 1, read round and round.
type Weights = Vec<f64>;

fn weights() -> impl Strategy<Value = Weights> {
    (0..10_000).prop_map(|seed| {
        (0..97)
            .map(|k| (0.37 * f64::from(seed) + 2.1 * f64::from(k)).sin())
            .collect()
    })
}

fn stickings() -> impl Strategy<Value = Sticking> {
    prop_oneof![6 => Just(Sticking::Coulomb), 1 => Just(Sticking::Full), 1 => Just(Sticking::Frictionless)]
}

type Input = ([f64; 3], Vec<f64>);

/// A direction whose unit changes jump and begin state by about their size.
fn direction(law: &dyn TractionLaw, (u, begin): (&[f64; 3], &[f64]), end: &[f64], weights: &[f64]) -> Input {
    let mut weights = weights.iter().copied().cycle();
    let mut next = || weights.next().unwrap();
    let moved = |q: usize| (u[q] - begin[q]).abs().min(u[2].abs()) + 0.02 * u[2].abs();
    let jump = [next() * moved(0), next() * moved(1), 0.5 * next() * u[2]];
    let state = law.info().state.iter().enumerate().map(|(c, quantity)| {
        let size = match c {
            0 | 1 => moved(c),
            // Where a path begins at the first touch there is a kink.
            2 if begin[2] == 0.0 => 0.0,
            // And where a contact circle that remembers nothing begins.
            _ if begin[c] == 0.0 && quantity.name.starts_with("a_") => 0.0,
            _ => 0.5 * begin[c].abs() + 0.3 * end[c].abs(),
        };
        next() * size
    });
    (jump, state.collect())
}

fn combined((d, d_state): &Input, factor: f64, (e, e_state): &Input) -> Input {
    let jump = std::array::from_fn(|q| d[q] + factor * e[q]);
    let state = d_state.iter().zip(e_state).map(|(d, e)| d + factor * e);
    (jump, state.collect())
}

/// Numbers of the derivative.
fn changes(found: &PointDerivative) -> Vec<f64> {
    found.d_traction.iter().chain(&found.d_end).copied().collect()
}

/// What has been seen: steps compared with differences of all steps, and the largest error.
type Tally = BTreeMap<&'static str, (u32, u32, f64)>;

/// The product of adjoints with the change along a direction of jump and begin state is the same on both sides.
fn transposed(
    law: &dyn TractionLaw,
    (u, state): (&[f64; 3], &[f64]),
    (d_jump, d_begin): &Input,
    (m, l): &Input,
) -> Result<(), TestCaseError> {
    let forwards = derivative_at_point(law, 0, Sticking::Coulomb, (*u, state), (*d_jump, d_begin));
    let at = [(*u, state.to_vec())];
    let back = |way: WayBack, after: &[f64]| {
        let mut found = transposed_batch(law, way, 0..1, &at, &[(*m, after.to_vec())]);
        let mut to_jump = found.swap_remove(0);
        let history = to_jump.split_off(3);
        (to_jump, history)
    };
    let (to_jump, begin) = back(WayBack::Committed, l);
    prop_assert_eq!(back(WayBack::JumpAlone, l), (to_jump.clone(), l.clone()));
    let (to_jump_alone, alone) = back(WayBack::Committed, &vec![0.0; l.len()]);
    let kept: Vec<f64> = l.iter().zip(&alone).map(|(l, alone)| l + alone).collect();
    prop_assert_eq!(back(WayBack::Passed, l), (to_jump_alone, kept));
    let changes = forwards.d_traction.iter().chain(&forwards.d_end);
    let values = forwards.traction.iter().chain(&forwards.end);
    let (mut sum, mut size, mut values_size) = (0.0, 0.0, 0.0);
    for ((adjoint, change), value) in m.iter().chain(l).zip(changes).zip(values) {
        sum += adjoint * change;
        size += (adjoint * change).abs();
        values_size += (adjoint * value).abs();
    }
    let inputs = || d_jump.iter().chain(d_begin);
    let terms = || to_jump.iter().chain(&begin).zip(inputs()).map(|(a, b)| a * b);
    let (back, parts) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
    // What does not depend on the history changes by rounding of what it is.
    prop_assert!(
        (back - sum).abs() <= 1e-9 * (size + parts) + 1e-12 * values_size,
        "{}: {back:e} backwards, {sum:e} forwards of {size:e} and {parts:e}",
        law.info().name
    );
    Ok(())
}

/// Adjoints of jump and history of some points before a step, at once.
fn transposed_batch(
    law: &dyn TractionLaw,
    way: WayBack,
    points: core::ops::Range<usize>,
    at: &[([f64; 3], Vec<f64>)],
    adjoints: &[Input],
) -> Vec<Vec<f64>> {
    let n = points.len();
    let jump =
        |of: &[([f64; 3], Vec<f64>)]| [0, 1, 2].map(|c| points.clone().map(|i| of[i].0[c]).collect::<Vec<f64>>());
    let state = |of: &[([f64; 3], Vec<f64>)]| -> Vec<f64> {
        let components = 0..law.info().n_state();
        components
            .flat_map(|c| points.clone().map(move |i| of[i].1[c]))
            .collect()
    };
    let (u, begin, traction, mut history) = (jump(at), state(at), jump(adjoints), state(adjoints));
    let mut to_jump = [0, 1, 2].map(|_| vec![0.0; n]);
    let [x, y, z] = to_jump.each_mut();
    let mut one = [Adjoint {
        history: StateViewMut::new(&mut history, n, 0),
        traction: Components::new(&traction[0], &traction[1], &traction[2]),
        jump: ComponentsMut::new(x, y, z),
    }];
    let jump = Components::new(&u[0], &u[1], &u[2]);
    law.transposed(points.clone(), jump, StateView::new(&begin, n, 0), way, &mut one);
    let of_point = |i: usize| {
        let numbers = to_jump.iter().map(|values| values[i]);
        numbers.chain(history.chunks_exact(n).map(|values| values[i])).collect()
    };
    (0..n).map(of_point).collect()
}

/// Steps with commits: the bits of the evaluation, its tangent, differences, linearity.
fn follow(
    law: &dyn TractionLaw,
    steps: &[([f64; 3], Sticking)],
    weights: &[f64],
    tally: &RefCell<Tally>,
) -> Result<(), TestCaseError> {
    let mut state = vec![0.0; law.info().n_state()];
    for (k, &(u, sticking)) in steps.iter().enumerate() {
        let here = evaluate_point(law, 0, sticking, u, &state);
        let along = direction(law, (&u, &state), &here.end, &weights[k % 41..]);
        let other = direction(law, (&u, &state), &here.end, &weights[41 + k % 41..]);
        let derive = |(d, d_begin): &Input| derivative_at_point(law, 0, sticking, (u, &state), (*d, d_begin));
        let found = derive(&along);
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<u64>>();
        prop_assert_eq!(bits(&found.traction), bits(&here.traction));
        prop_assert_eq!(bits(&found.end), bits(&here.end));
        prop_assert!(changes(&found).iter().all(|v| v.is_finite()), "{:?}", found);

        let still = vec![0.0; state.len()];
        let by_tangent = derive(&(along.0, still));
        let sizes = |i: usize| (0..3).map(|k| (here.tangent[i][k] * along.0[k]).abs()).sum::<f64>();
        for i in 0..3 {
            let product: f64 = (0..3).map(|k| here.tangent[i][k] * along.0[k]).sum();
            let size = if i < 2 { sizes(0).max(sizes(1)) } else { sizes(2) };
            let error = (by_tangent.d_traction[i] - product).abs();
            prop_assert!(
                error <= 1e-12 * size,
                "{} row {i}: {error:e} of {size:e}",
                law.info().name
            );
        }

        // Homogeneous to the last bit, additive to rounding, which large terms of opposite sign magnify.
        let doubled = combined(&along, 1.0, &along);
        let twice: Vec<f64> = changes(&found).iter().map(|v| 2.0 * v).collect();
        prop_assert_eq!(bits(&changes(&derive(&doubled))), bits(&twice));
        let sum = changes(&derive(&combined(&along, -0.75, &other)));
        let parts = changes(&found).into_iter().zip(changes(&derive(&other)));
        let scales = found.traction.iter().chain(&found.end);
        for ((sum, (a, b)), scale) in sum.into_iter().zip(parts).zip(scales) {
            let size = a.abs().max(b.abs()).max(scale.abs());
            prop_assert!(
                (sum - (a - 0.75 * b)).abs() <= 1e-8 * size,
                "{sum:e} {a:e} {b:e} {scale:e}"
            );
        }

        if sticking == Sticking::Coulomb {
            transposed(law, (&u, &state), &along, &other)?;
        }

        let kind = match (here.regime, sticking) {
            (Regime::Open, _) => "open",
            (Regime::Stick, Sticking::Full) => "full",
            (Regime::Slip, Sticking::Frictionless) => "frictionless",
            (Regime::Stick, _) if state[2] < 0.0 => "stick, closed again",
            (Regime::Slip, _) if state[2] < 0.0 => "slip, closed again",
            (Regime::Stick, _) => "stick",
            _ => "slip",
        };
        let error = derivative_error(law, 0, sticking, (u, &state), (along.0, &along.1));
        let mut tally = tally.borrow_mut();
        let (compared, all, worst) = tally.entry(kind).or_default();
        *all += 1;
        if let Some(error) = error {
            *compared += 1;
            *worst = worst.max(error);
            prop_assert!(
                error <= 1e-6,
                "{} {kind} {sticking:?}: {error:e}\nat {u:?} {state:?}\nalong {along:?}\n{found:?}",
                law.info().name
            );
        }
        state = here.end;
    }
    Ok(())
}

/// Runs a property and returns what it has seen.
fn seen<S: Strategy>(
    name: &'static str,
    cases: u32,
    strategy: &S,
    check: impl Fn(S::Value, &RefCell<Tally>) -> Result<(), TestCaseError>,
) -> Tally {
    let config = ProptestConfig {
        cases,
        source_file: Some(file!()),
        test_name: Some(name),
        max_shrink_iters: 200,
        ..ProptestConfig::default()
    };
    let tally = RefCell::new(Tally::new());
    hold(config, strategy, |value| check(value, &tally));
    println!("{name}: compared, of, largest error: {:?}", tally.borrow());
    tally.into_inner()
}

/// Most steps are compared with differences: a share of those of a kind.
fn assert_compared(tally: &Tally, kinds: &[&str], least: u32, share: f64) {
    for kind in kinds {
        let (compared, all, _) = tally.get(kind).copied().unwrap_or_default();
        assert!(
            compared >= least && f64::from(compared) >= share * f64::from(all),
            "{kind}: {compared} of {all}"
        );
    }
}

const KINDS: [&str; 7] = [
    "open",
    "full",
    "frictionless",
    "stick, closed again",
    "slip, closed again",
    "stick",
    "slip",
];

fn friction() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 8 => log_uniform(1e-2, 10.0)]
}

/// A friction coefficient and steps that stick and slip with it.
fn with_steps() -> impl Strategy<Value = (f64, Vec<([f64; 3], Sticking)>)> {
    friction().prop_flat_map(|mu| {
        let steps = paths(mu).prop_flat_map(|path| {
            let n = path.len();
            (Just(path), prop::collection::vec(stickings(), n))
        });
        (Just(mu), steps).prop_map(|(mu, (path, stickings))| (mu, path.into_iter().zip(stickings).collect()))
    })
}

#[test]
fn friction_on_curves() {
    let cones = prop::sample::select(vec![Cone::Circle, Cone::Box]);
    let strategy = (with_steps(), cones, any_history(), weights());
    let tally = seen(
        "friction_on_curves",
        400,
        &strategy,
        |((mu, steps), cone, history, weights), tally| {
            for law in laws(mu, history) {
                follow(&*law, &steps, &weights, tally)?;
            }
            let curves = FittedPoints::<f64>::new(&PointParameters::uniform(fitted(), 1));
            let law = RoughLaw::try_new(curves, PointParameters::uniform(mu, 1), history).unwrap();
            follow(&law.with_cone(cone), &steps, &weights, tally)
        },
    );
    assert_compared(&tally, &KINDS, 200, 0.8);
}

#[test]
fn springs_of_a_foundation() {
    let strategy = (with_steps(), 1..6_usize, weights());
    let tally = seen(
        "springs_of_a_foundation",
        1000,
        &strategy,
        |((mu, steps), n, weights), tally| {
            let mu = PointParameters::uniform(mu, 1);
            follow(
                &super::foundation::law(elastic(), mu.clone(), 2 * n),
                &steps,
                &weights,
                tally,
            )?;
            let curves = super::asperities(TangentialReading::Mindlin);
            follow(&super::foundation::law(curves, mu, 2 * n), &steps, &weights, tally)
        },
    );
    assert_compared(&tally, &KINDS, 100, 0.7);
}

#[test]
fn linearised_contact() {
    let strategy = (with_steps(), any::<prop::sample::Index>(), weights());
    let tally = seen(
        "linearised_contact",
        1000,
        &strategy,
        |((mu, steps), first, weights), tally| {
            let law = super::law(elastic(), mu, HistoryRule::Incremental);
            let (u, _) = steps[first.index(steps.len())];
            let state = [0.0, 0.0, u[2], 0.0, 0.0];
            let [x, y, n] = u.each_ref().map(core::slice::from_ref);
            let about = LinearisedContact::about(&law, Components::new(x, y, n), StateView::new(&state, 1, 0)).unwrap();
            follow(&about, &steps, &weights, tally)
        },
    );
    assert_compared(&tally, &["open", "full", "frictionless", "stick", "slip"], 50, 0.7);
}

#[test]
fn asperities_with_friction() {
    let strategy = cases().prop_flat_map(|case| {
        let path = paths(case.mu).prop_flat_map(|path| {
            let n = path.len();
            (Just(path), prop::collection::vec(stickings(), n))
        });
        (Just(case), path, weights())
    });
    let tally = seen(
        "asperities_with_friction",
        3000,
        &strategy,
        |(case, (path, stickings), weights), tally| {
            let steps: Vec<_> = path.into_iter().zip(stickings).collect();
            follow(&case.law(), &steps, &weights, tally)
        },
    );
    assert_compared(&tally, &KINDS, 100, 0.6);
}

/// Laws of several points of each kind.
fn many(n: usize, mu: f64, cone: Cone, history: HistoryRule) -> Vec<Box<dyn TractionLaw>> {
    let mu = || PointParameters::uniform(mu, n);
    let curves = FittedPoints::<f64>::new(&PointParameters::uniform(fitted(), n));
    let asperities = |yielding: Option<Yield>, friction| {
        let asperity = Asperity::try_new(ElasticPair::new(192e9, 0.3), 1e-3, yielding).unwrap();
        let bins = AsperityBins::try_new(asperity, vec![0.0, 1e-7, 3e-6], vec![1e5, 3e6, 1e6]).unwrap();
        Box::new(ResolvedLaw::try_new(PointParameters::uniform(bins, n), mu(), friction, cone).unwrap())
    };
    let steel = Some(Yield {
        strength: 330e6,
        tangent_modulus: 620e6,
        curves: YieldCurves::Continuous,
    });
    let yielding_rule = match history {
        HistoryRule::Potential => HistoryRule::EndPoint,
        history => history,
    };
    vec![
        Box::new(RoughLaw::try_new(curves, mu(), history).unwrap().with_cone(cone)),
        Box::new(
            TableLaw::try_new(
                PointParameters::uniform(TABLE.with(|table| table.clone()), n),
                mu(),
                history,
            )
            .unwrap()
            .with_cone(cone),
        ),
        Box::new(FoundationLaw::of_curves(PointParameters::uniform(elastic(), n), mu(), 0.8, 6, 1e-5).unwrap()),
        asperities(None, AsperityFriction::StickSlip(history)),
        asperities(None, AsperityFriction::Annuli(history, 3)),
        asperities(steel, AsperityFriction::StickSlip(yielding_rule)),
        asperities(steel, AsperityFriction::MindlinIwan(Radii::equally_spaced(5).unwrap())),
        Box::new(
            asperities(steel, AsperityFriction::StickSlip(yielding_rule))
                .with_limit(AsperityLimit::ShearStrength)
                .unwrap(),
        ),
    ]
}

/// A path, and which kind of number of the point is spoilt, if any.
type Spoilt = (Vec<[f64; 3]>, usize);

/// Points in all regimes with a direction each, some of them spoilt: a number of the input or of the direction.
fn points() -> impl Strategy<Value = (Vec<Spoilt>, Weights, Vec<usize>)> {
    prop::collection::vec((paths(0.3), 0..40_usize), 1..150).prop_flat_map(|points| {
        let n = points.len();
        (Just(points), weights(), prop::collection::vec(0..=n, 0..6))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(25))]

    /// Chunks change no bit. What is not finite makes derivatives NaN, of a direction the derivatives alone.
    #[test]
    fn batches_do_not_change_a_bit(
        (points, weights, cuts) in points(), box_cone: bool, history in any_history(),
    ) {
        let n = points.len();
        let cone = if box_cone { Cone::Box } else { Cone::Circle };
        for law in many(n, 0.3, cone, history) {
            let n_state = law.info().n_state();
            let (mut at, mut along) = (vec![], vec![]);
            for (i, (path, spoilt)) in points.iter().enumerate() {
                let (u, before) = path.split_last().unwrap();
                let mut state = vec![0.0; n_state];
                for u in before {
                    state = evaluate_point(&*law, i, Sticking::Coulomb, *u, &state).end;
                }
                let end = evaluate_point(&*law, i, Sticking::Coulomb, *u, &state).end;
                let (mut u, mut d) = (*u, direction(&*law, (u, &state), &end, &weights[i % 80..]));
                match spoilt {
                    0 => u[i % 3] = f64::NAN,
                    1 => state[i % n_state] = f64::INFINITY,
                    2 => d.0[i % 3] = f64::NEG_INFINITY,
                    3 => d.1[i % n_state] = f64::NAN,
                    _ => {}
                }
                at.push((u, state));
                along.push(d);
            }
            // On the way back the adjoints are as large as the directions. Spoilt points are beside others here, and zeros of open parts have either sign.
            for way in [WayBack::Committed, WayBack::Passed, WayBack::JumpAlone] {
                let whole = transposed_batch(&*law, way, 0..n, &at, &along);
                for (i, whole) in whole.iter().enumerate().filter(|(i, _)| points[*i].1 > 3) {
                    let alone = transposed_batch(&*law, way, i..i + 1, &at, &along);
                    prop_assert!(whole.iter().all(|v| v.is_finite()), "{} {whole:?}", law.info().name);
                    prop_assert_eq!(&alone[0], whole, "{}", law.info().name);
                }
            }
            for sticking in [Sticking::Coulomb, Sticking::Full, Sticking::Frictionless] {
                let whole = derivative_batch(&*law, sticking, once(0..n), &at, &along);
                let cut = derivative_batch(&*law, sticking, chunks(n, &cuts), &at, &along);
                prop_assert!(whole.iter().zip(&cut).all(|(a, b)| a.is_identical(b)));
                for i in 0..n {
                    let ((u, state), (d, d_state)) = (&at[i], &along[i]);
                    let alone = derivative_at_point(&*law, i, sticking, (*u, state), (*d, d_state));
                    prop_assert!(alone.is_identical(&whole[i]), "{}: {alone:?} {:?}", law.info().name, whole[i]);
                    let here = evaluate_point(&*law, i, sticking, *u, state);
                    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<u64>>();
                    if points[i].1 < 4 {
                        prop_assert!(changes(&alone).iter().all(|v| v.is_nan()), "{} {alone:?}", law.info().name);
                    } else {
                        prop_assert!(changes(&alone).iter().all(|v| v.is_finite()), "{} {alone:?}", law.info().name);
                    }
                    if points[i].1 < 2 {
                        prop_assert!(alone.traction.iter().chain(&alone.end).all(|v| v.is_nan()));
                    } else {
                        prop_assert_eq!(bits(&alone.traction), bits(&here.traction));
                        prop_assert_eq!(bits(&alone.end), bits(&here.end));
                    }
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// Finite input and direction anywhere in the number range give finite derivatives.
    #[test]
    fn finite_input_gives_finite_derivatives(
        numbers in prop::collection::vec(extreme(), 120), box_cone: bool,
        history in any_history(), mu in extreme(),
    ) {
        let cone = if box_cone { Cone::Box } else { Cone::Circle };
        for law in many(1, mu.abs(), cone, history) {
            let n_state = law.info().n_state();
            let mut numbers = numbers.iter().copied().cycle();
            let mut next = || numbers.next().unwrap();
            let mut input = || ([next(), next(), next()], (0..n_state).map(|_| next()).collect::<Vec<f64>>());
            let ((u, begin), (d, d_begin)) = (input(), input());
            for sticking in [Sticking::Coulomb, Sticking::Full, Sticking::Frictionless] {
                let found = derivative_at_point(&*law, 0, sticking, (u, &begin), (d, &d_begin));
                prop_assert!(changes(&found).iter().all(|v| v.is_finite()), "{} {found:?}", law.info().name);
                let here = evaluate_point(&*law, 0, sticking, u, &begin);
                prop_assert_eq!((found.traction, found.end), (here.traction, here.end));
            }
        }
    }
}

/// A law with scaled curves and friction is its neighbour on a path that sticks, slips, opens and closes again; the derivative by the parameter is the
/// difference of the two.
#[test]
fn scaled_laws_change_as_their_neighbours_do() {
    let n = 3;
    let build = |p: f64, history: HistoryRule| {
        let factors = CurveFactors {
            interference: (0.7 * p).exp(),
            normal: (1.3 * p).exp(),
            tangential: [(-0.4 * p).exp(), (0.9 * p).exp()],
        };
        let curves = PointParameters::uniform(fitted().scaled(factors).unwrap(), n);
        let mu = PointParameters::uniform(0.3 * (0.6 * p).exp(), n);
        FrictionalLaw::try_new(curves, mu, history).unwrap()
    };
    let similarity = Similarity {
        interference: 0.7,
        normal: 1.3,
        tangential: [-0.4, 0.9],
        friction: 0.6,
        density: 0.0,
    };
    // Jumps of the three points along the path, in um.
    let path = [
        [[0.0, 0.0, 2.0], [0.0, 0.1, 1.0], [0.0, 0.0, 0.5]],
        [[0.3, 0.1, 2.1], [3.0, 0.5, 1.1], [0.1, 0.0, -0.2]],
        [[-0.2, 0.0, 1.9], [-2.0, 0.4, 1.2], [0.2, 0.1, 0.6]],
        [[0.4, 0.2, 2.2], [1.0, -1.5, 0.9], [0.4, -0.3, 0.7]],
    ];
    for history in [HistoryRule::Incremental, HistoryRule::EndPoint, HistoryRule::Paper] {
        let tractions = |p: f64| -> Vec<[f64; 3]> {
            let law = build(p, history);
            let (mut begin, mut end) = (vec![0.0; 5 * n], vec![0.0; 5 * n]);
            let mut all = Vec::new();
            for step in path {
                let jump: [Vec<f64>; 3] = core::array::from_fn(|c| step.iter().map(|u| 1e-6 * u[c]).collect());
                let mut t: [Vec<f64>; 3] = core::array::from_fn(|_| vec![0.0; n]);
                let [x, y, z] = t.each_mut();
                law.evaluate(
                    0..n,
                    Sticking::Coulomb,
                    Components::new(&jump[0], &jump[1], &jump[2]),
                    StateView::new(&begin, n, 0),
                    StateViewMut::new(&mut end, n, 0),
                    ComponentsMut::new(x, y, z),
                    None,
                    None,
                );
                std::mem::swap(&mut begin, &mut end);
                all.extend((0..n).map(|i| [t[0][i], t[1][i], t[2][i]]));
            }
            all
        };
        let law = build(0.0, history);
        let scaling = Scaling::try_new(&law, vec![similarity; n]).unwrap();
        let (mut begin, mut end) = (vec![0.0; 5 * n], vec![0.0; 5 * n]);
        let (mut d_begin, mut d_end) = (vec![0.0; 5 * n], vec![0.0; 5 * n]);
        let mut found = Vec::new();
        let mut steps = Vec::new();
        for step in path {
            let jump: [Vec<f64>; 3] = core::array::from_fn(|c| step.iter().map(|u| 1e-6 * u[c]).collect());
            let fields = || -> [Vec<f64>; 3] { core::array::from_fn(|_| vec![0.0; n]) };
            let (mut d_jump, mut t, mut d_t) = (fields(), fields(), fields());
            let mut changes = d_begin.clone();
            let [dx, dy, dz] = d_jump.each_mut();
            let [tx, ty, tz] = t.each_mut();
            let [rx, ry, rz] = d_t.each_mut();
            scaling.derivative(
                &law,
                0..n,
                Sticking::Coulomb,
                Components::new(&jump[0], &jump[1], &jump[2]),
                StateView::new(&begin, n, 0),
                ComponentsMut::new(dx, dy, dz),
                &mut changes,
                StateViewMut::new(&mut end, n, 0),
                StateViewMut::new(&mut d_end, n, 0),
                ComponentsMut::new(tx, ty, tz),
                ComponentsMut::new(rx, ry, rz),
            );
            steps.push((jump, t, begin.clone(), d_begin.clone()));
            std::mem::swap(&mut begin, &mut end);
            std::mem::swap(&mut d_begin, &mut d_end);
            found.extend((0..n).map(|i| [d_t[0][i], d_t[1][i], d_t[2][i]]));
        }
        // The change of a weighted sum of the tractions after the first step, on the way back to its end.
        let weight = |at: usize, c: usize| (1.0 + at as f64 + 0.7 * c as f64).sin();
        let later = found.iter().enumerate().skip(n);
        let terms = later.flat_map(|(at, found)| (0..3).map(move |c| weight(at, c) * found[c]));
        let (forwards, size) = terms.fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()));
        let (mut sums, mut history_back) = (PointSums::new(n), vec![0.0; 5 * n]);
        let mut of_begin = 0.0;
        for (k, (jump, t, begin, d_begin)) in steps.iter().enumerate().skip(1).rev() {
            let weights: [Vec<f64>; 3] = core::array::from_fn(|c| (0..n).map(|i| weight(k * n + i, c)).collect());
            let mut to_jump: [Vec<f64>; 3] = core::array::from_fn(|_| vec![0.0; n]);
            let [x, y, z] = to_jump.each_mut();
            let mut adjoints = [Adjoint {
                history: StateViewMut::new(&mut history_back, n, 0),
                traction: Components::new(&weights[0], &weights[1], &weights[2]),
                jump: ComponentsMut::new(x, y, z),
            }];
            let jump = Components::new(&jump[0], &jump[1], &jump[2]);
            law.transposed(
                0..n,
                jump,
                StateView::new(begin, n, 0),
                WayBack::Committed,
                &mut adjoints,
            );
            sums.add_step(0..n, jump, Components::new(&t[0], &t[1], &t[2]), &adjoints[0]);
            if k == 1 {
                sums.add_begin(0..n, &law.info().state, begin, &history_back);
                of_begin = history_back.iter().zip(d_begin).map(|(a, b)| a * b).sum();
            }
        }
        let backwards = scaling.of_path(&sums, 0) + of_begin;
        assert!(
            (backwards - forwards).abs() < 1e-12 * size,
            "{history:?}: {backwards} {forwards}"
        );
        let h = 1e-6;
        let (above, below) = (tractions(h), tractions(-h));
        for (at, ((found, above), below)) in found.iter().zip(&above).zip(&below).enumerate() {
            for c in 0..3 {
                let central = (above[c] - below[c]) / (2.0 * h);
                let size = above.iter().fold(1.0_f64, |m, t| m.max(t.abs()));
                assert!(
                    (found[c] - central).abs() < 1e-7 * size,
                    "{history:?} {at} {c}: {} {central}",
                    found[c]
                );
            }
        }
    }
    // What has a length of its own, and a potential, are not scaled.
    let with_potential = build(0.0, HistoryRule::Potential);
    assert!(Scaling::try_new(&with_potential, vec![similarity; n]).is_none());
    let alone = Similarity {
        normal: 1.0,
        tangential: [1.0; 2],
        density: 1.0,
        ..Similarity::default()
    };
    assert!(Scaling::try_new(&with_potential, vec![alone; n]).is_some());
    assert!(Scaling::try_new(&with_potential, vec![alone; n - 1]).is_none());
}
