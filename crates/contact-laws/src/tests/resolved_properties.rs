//! What must hold for friction resolved over asperities, whatever the bins and their past.

use std::cell::Cell;
use std::iter::once;

use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::batches::{chunks, stored};
use super::elastic_plastic::{Formulas, published};
use super::kinks::extreme;
use super::oracle::closed_path;
use super::relative;
use super::resolved::{Case, cases, coulomb_cases, paths};
use super::{config, hold};
use crate::testing::{PointResponse, evaluate_batch, evaluate_point, log_uniform};
use crate::*;

fn at(law: &dyn TractionLaw, u: [f64; 3], begin: &[f64]) -> PointResponse {
    evaluate_point(law, 0, Sticking::Coulomb, u, begin)
}

fn rule(case: &Case) -> Option<HistoryRule> {
    match case.friction {
        AsperityFriction::StickSlip(rule) | AsperityFriction::Annuli(rule, _) => Some(rule),
        AsperityFriction::MindlinIwan(_) => None,
    }
}

/// What tangential tractions are compared with, over the normal traction.
fn share(case: &Case) -> f64 {
    match case.limit() {
        AsperityLimit::Coulomb => case.mu,
        AsperityLimit::Ceb | AsperityLimit::ShearStrength => 1.0,
    }
}

/// Largest tangential traction at a point.
fn slip_limit(case: &Case, u_n: f64, begin: &[f64], t_n: f64) -> f64 {
    let limit = case.limit();
    if limit == AsperityLimit::Coulomb {
        return case.mu * t_n;
    }
    let (asperity, n_memory) = (case.formulas.asperity(), case.n_memory());
    let bins = case
        .gaps
        .iter()
        .zip(&case.densities)
        .zip(begin[3..].chunks_exact(n_memory));
    bins.map(|((gap, density), memory)| {
        let dent = Dent {
            interference: memory[n_memory - 2],
            force: memory[n_memory - 1],
        };
        density * asperity.slip_limit(limit, u_n - gap, dent).unwrap().value
    })
    .sum()
}

fn with_path() -> impl Strategy<Value = (Case, Vec<[f64; 3]>)> {
    cases().prop_flat_map(|case| {
        let mu = case.mu;
        (Just(case), paths(mu))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn every_answer_is_admissible((case, path) in with_path()) {
        let law = case.law();
        let zero = vec![0.0; law.info().n_state()];
        let mut state = zero.clone();
        // Nothing touches at zero, and pressing alone gives no tangential traction.
        let nothing = at(&law, [0.0; 3], &zero);
        prop_assert_eq!((nothing.regime, nothing.traction, nothing.tangent), (Regime::Open, [0.0; 3], [[0.0; 3]; 3]));
        prop_assert_eq!(&nothing.end, &zero);
        let pressed = at(&law, [0.0, 0.0, 3e-6], &zero);
        let loading: f64 = case.gaps.iter().zip(&case.densities).map(|(gap, density)| {
            density * case.formulas.asperity().loading(3e-6 - gap).force.value
        }).sum();
        prop_assert_eq!(&pressed.traction[..2], &[0.0; 2]);
        prop_assert!(relative(pressed.traction[2], loading) < 1e-13);
        for u in path {
            let found = at(&law, u, &state);
            // Pure: the same call gives the same bits.
            prop_assert!(found.is_identical(&at(&law, u, &state)));
            prop_assert!(found.numbers().all(f64::is_finite), "{found:?}");
            prop_assert_eq!(&found.end[..3], &u);
            let [x, y, n] = found.traction;
            prop_assert!(n >= 0.0);
            let limit = slip_limit(&case, u[2], &state, n) * (1.0 + 1e-13);
            match case.cone {
                Cone::Circle => prop_assert!(x.hypot(y) <= limit, "{found:?}"),
                Cone::Box => prop_assert!(x.abs() <= limit && y.abs() <= limit, "{found:?}"),
            }
            if rule(&case) != Some(HistoryRule::Potential) {
                prop_assert!(found.tangent[2][2] >= 0.0 && found.tangent[2][..2] == [0.0; 2]);
            }
            let touches = case.gaps.iter().zip(&case.densities).any(|(gap, density)| u[2] > *gap && *density > 0.0);
            if !touches {
                prop_assert_eq!((found.regime, found.traction), (Regime::Open, [0.0; 3]));
                prop_assert_eq!(found.tangent, [[0.0; 3]; 3]);
            } else if !case.yields() {
                prop_assert!(found.regime != Regime::Open && n > 0.0);
            }
            prop_assert_eq!(found.regime == Regime::Open, n == 0.0);
            // Committed, the end state carries the same tractions; a yielded contact circle unloads with another radius.
            let committed = at(&law, u, &found.end);
            let known = if case.yields() && rule(&case).is_none() { 2..3 } else { 0..3 };
            for q in known {
                // A yielded contact begins at a depth that has lost the digits of the interference.
                let error = (committed.traction[q] - found.traction[q]).abs();
                prop_assert!(error <= 1e-11 * found.traction[2], "{found:?} {committed:?}");
            }
            state = found.end;
        }
    }

    /// Under the circle directions do not matter.
    #[test]
    fn tractions_turn_with_the_axes((case, path) in with_path(), angle in 0.0..6.3_f64) {
        let case = Case { cone: Cone::Circle, ..case };
        let law = case.law();
        let (s, c) = angle.sin_cos();
        let turn = |v: &mut [f64]| (v[0], v[1]) = (c * v[0] - s * v[1], s * v[0] + c * v[1]);
        let n_memory = case.n_memory();
        let mut state = vec![0.0; law.info().n_state()];
        for u in path {
            let found = at(&law, u, &state);
            let (mut u_turned, mut turned) = (u, state.clone());
            turn(&mut u_turned);
            turn(&mut turned);
            for bin in turned[3..].chunks_exact_mut(n_memory) {
                match &case.friction {
                    AsperityFriction::StickSlip(_) => turn(bin),
                    AsperityFriction::Annuli(_, n) => {
                        bin[..2 * n].chunks_exact_mut(2).for_each(turn);
                    }
                    AsperityFriction::MindlinIwan(radii) => {
                        bin[1..=2 * radii.len()].chunks_exact_mut(2).for_each(turn);
                    }
                }
            }
            let other = at(&law, u_turned, &turned);
            let mut expected = found.traction;
            turn(&mut expected);
            for q in 0..3 {
                let error = (other.traction[q] - expected[q]).abs();
                prop_assert!(error <= 1e-10 * (1.0 + case.mu) * found.traction[2], "{found:?} {other:?}");
            }
            state = found.end;
        }
    }

    /// Finite input anywhere in the number range gives finite output.
    #[test]
    fn finite_input_gives_finite_output(
        case in cases(), numbers_in in prop::collection::vec(extreme(), 60), (gap, density) in (extreme(), extreme()),
        mu in extreme(), change: bool,
    ) {
        let mut case = case;
        if change {
            case.mu = mu.abs();
            case.gaps[0] = gap.abs().min(1e100);
            case.densities[0] = density.abs().min(1e100);
        }
        let law = case.law();
        let u = [numbers_in[0], numbers_in[1], numbers_in[2]];
        let begin: Vec<f64> = (0..law.info().n_state()).map(|i| numbers_in[3 + i % 57]).collect();
        for sticking in [Sticking::Coulomb, Sticking::Full] {
            let found = evaluate_point(&law, 0, sticking, u, &begin);
            prop_assert!(found.numbers().all(f64::is_finite), "{sticking:?} {found:?}");
            prop_assert!(found.regime != Regime::Invalid && found.traction[2] >= 0.0, "{found:?}");
        }
    }

    /// One number that is none makes all of the point's numbers none.
    #[test]
    fn input_that_is_no_number_is_invalid(
        (case, path) in with_path(), which: prop::sample::Index,
        value in prop::sample::select(vec![f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ) {
        let law = case.law();
        let n_state = law.info().n_state();
        let mut state = vec![0.0; n_state];
        for u in path {
            let (mut u_spoilt, mut spoilt) = (u, state.clone());
            match which.index(3 + n_state) {
                i if i < 3 => u_spoilt[i] = value,
                i => spoilt[i - 3] = value,
            }
            for sticking in [Sticking::Coulomb, Sticking::Full] {
                let found = evaluate_point(&law, 0, sticking, u_spoilt, &spoilt);
                prop_assert_eq!(found.regime, Regime::Invalid);
                prop_assert!(found.numbers().all(f64::is_nan), "{found:?}");
            }
            state = at(&law, u, &state).end;
        }
    }
}

/// Points with a past of their own and sets of bins of different lengths.
#[derive(Debug, Clone)]
struct Points {
    sets: Vec<Case>,
    set: Vec<u32>,
    mu: Vec<u32>,
    paths: Vec<Vec<[f64; 3]>>,
    spoilt: Vec<usize>,
}

fn points() -> impl Strategy<Value = Points> {
    let point = (0..3_u32, 0..3_u32, paths(0.3), 0..60_usize);
    let points = prop::collection::vec(point, 3..150);
    (prop::collection::vec(cases(), 3), points).prop_map(|(sets, points)| {
        let (mut set, mut mu, mut paths, mut spoilt) = (vec![], vec![], vec![], vec![]);
        for (of, friction, path, spoil) in points {
            set.push(of);
            mu.push(friction);
            paths.push(path);
            spoilt.push(spoil);
        }
        // One friction for all sets; they may yield or not.
        // However the sets are stored, all of them are there.
        set[..3].copy_from_slice(&[0, 1, 2]);
        let first = sets.iter().find(|case| case.yields()).unwrap_or(&sets[0]).clone();
        let like_first = |case| Case {
            friction: first.friction.clone(),
            cone: first.cone,
            ..case
        };
        let mut sets: Vec<Case> = sets.into_iter().map(like_first).collect();
        let limit = if sets.iter().all(Case::yields) {
            sets[0].limit
        } else {
            AsperityLimit::Coulomb
        };
        sets.iter_mut().for_each(|case| case.limit = limit);
        Points {
            sets,
            set,
            mu,
            paths,
            spoilt,
        }
    })
}

/// Chunks, order and storage change no bit, and no bit depends on bins of other points.
#[test]
fn batches_do_not_change_a_bit() {
    let config = config(150, file!(), Some("resolved_batches"));
    let strategy = points().prop_flat_map(|points| {
        let n = points.set.len();
        let order = Just((0..n).collect::<Vec<usize>>()).prop_shuffle();
        (Just(points), order, prop::collection::vec(0..=n, 0..8))
    });
    let alone = Cell::new(0);
    hold(config, &strategy, |(points, order, cuts)| {
        let n = points.set.len();
        let mu = [0.1, 0.7, 3.0];
        let bins: Vec<AsperityBins> = points.sets.iter().map(Case::bins).collect();
        let (friction, cone) = (points.sets[0].friction.clone(), points.sets[0].cone);
        let law_of = |order: &[usize], indexed: bool| {
            let pick = |of: &[u32]| order.iter().map(|&i| of[i]).collect::<Vec<u32>>();
            let bins = stored(&bins, &pick(&points.set), indexed);
            let mu = stored(&mu, &pick(&points.mu), !indexed);
            let law = ResolvedLaw::try_new(bins, mu, friction.clone(), cone).unwrap();
            law.with_limit(points.sets[0].limit()).unwrap()
        };
        let straight: Vec<usize> = (0..n).collect();
        let law = law_of(&straight, false);
        let n_state = law.info().n_state();
        let (mut jump, mut begin) = (vec![], vec![]);
        for (i, path) in points.paths.iter().enumerate() {
            let (last, before) = path.split_last().unwrap();
            let mut state = vec![0.0; n_state];
            for u in before {
                state = evaluate_point(&law, i, Sticking::Coulomb, *u, &state).end;
            }
            jump.push(*last);
            match points.spoilt[i] {
                0 => jump[i][i % 3] = f64::NAN,
                1 => state[i % n_state] = f64::INFINITY,
                _ => {}
            }
            begin.push(state);
        }
        for sticking in [Sticking::Coulomb, Sticking::Full] {
            let one_by_one: Vec<PointResponse> = (0..n)
                .map(|i| evaluate_point(&law, i, sticking, jump[i], &begin[i]))
                .collect();
            for indexed in [false, true] {
                let law = law_of(&straight, indexed);
                let found = evaluate_batch(&law, sticking, once(0..n), &jump, &begin);
                prop_assert!(found.iter().zip(&one_by_one).all(|(a, b)| a.is_identical(b)));
                let law = law_of(&order, indexed);
                let jump: Vec<[f64; 3]> = order.iter().map(|&i| jump[i]).collect();
                let begin: Vec<Vec<f64>> = order.iter().map(|&i| begin[i].clone()).collect();
                let found = evaluate_batch(&law, sticking, chunks(n, &cuts), &jump, &begin);
                prop_assert!(found.iter().zip(&order).all(|(a, &i)| a.is_identical(&one_by_one[i])));
            }
            for i in 0..n {
                // The point's bins alone, where their state has the same form.
                let case = Case {
                    mu: mu[points.mu[i] as usize],
                    ..points.sets[points.set[i] as usize].clone()
                };
                let yields = points.sets.iter().any(Case::yields);
                if points.spoilt[i] < 2 || case.yields() != yields {
                    continue;
                }
                let law = case.law();
                let n_state = law.info().n_state();
                let found = evaluate_point(&law, 0, sticking, jump[i], &begin[i][..n_state]);
                prop_assert_eq!(&found.traction, &one_by_one[i].traction);
                prop_assert_eq!(&found.tangent, &one_by_one[i].tangent);
                prop_assert_eq!(found.regime, one_by_one[i].regime);
                prop_assert_eq!(&found.end[..], &one_by_one[i].end[..n_state]);
                alone.set(alone.get() + 1);
            }
        }
        // Without tangents the same tractions and the same end.
        let columns: [Vec<f64>; 3] = std::array::from_fn(|q| jump.iter().map(|u| u[q]).collect());
        let state: Vec<f64> = (0..n_state)
            .flat_map(|c| begin.iter().map(move |state| state[c]))
            .collect();
        let (mut end, mut t) = (vec![0.0; n_state * n], [vec![0.0; n], vec![0.0; n], vec![0.0; n]]);
        let [x, y, normal] = &mut t;
        law.evaluate(
            0..n,
            Sticking::Coulomb,
            Components::new(&columns[0], &columns[1], &columns[2]),
            StateView::new(&state, n, 0),
            StateViewMut::new(&mut end, n, 0),
            ComponentsMut::new(x, y, normal),
            None,
            None,
        );
        let whole = evaluate_batch(&law, Sticking::Coulomb, once(0..n), &jump, &begin);
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
        for (i, point) in whole.iter().enumerate() {
            prop_assert!((0..3).all(|q| same(t[q][i], point.traction[q])));
            prop_assert!((0..n_state).all(|c| same(end[c * n + i], point.end[c])));
        }
        Ok(())
    });
    println!("{} points evaluated alone", alone.get());
    assert!(alone.get() > 1000);
}

/// Tangential work of a closed path from no stretch, with a commit at every step, and the sum of `mu t_n |du_t|`. With a
/// potential the work includes what the stretch adds to the normal traction.
fn work(case: &Case, path: &[[f64; 3]]) -> [f64; 2] {
    let law = case.law();
    let mut state = vec![0.0; law.info().n_state()];
    state[..3].copy_from_slice(&path[0]);
    let unstretched = |state: &[f64], u: [f64; 3]| {
        let mut zero = vec![0.0; state.len()];
        zero[..3].copy_from_slice(&u);
        at(&law, u, &zero).traction[2]
    };
    let potential = rule(case) == Some(HistoryRule::Potential);
    let traction = |found: &PointResponse, u: [f64; 3], state: &[f64]| {
        let [x, y, n] = found.traction;
        [x, y, if potential { n - unstretched(state, u) } else { 0.0 }]
    };
    let (mut work, mut size) = (0.0, 0.0);
    let first = at(&law, path[0], &state);
    let mut before = traction(&first, path[0], &state);
    state = first.end;
    for step in path.windows(2) {
        let du: [f64; 3] = std::array::from_fn(|q| step[1][q] - step[0][q]);
        let found = at(&law, step[1], &state);
        let after = traction(&found, step[1], &state);
        work += (0..3).map(|q| 0.5 * (before[q] + after[q]) * du[q]).sum::<f64>();
        size += share(case) * found.traction[2] * du[0].hypot(du[1]);
        before = after;
        state = found.end;
    }
    [work, size]
}

/// Shapes of closed paths: size, depth, shares of the amplitudes, phases.
type Shape = (f64, f64, [f64; 2], [f64; 3]);

fn shapes() -> impl Strategy<Value = Shape> {
    (
        log_uniform(2e-7, 5e-6),
        0.1..1.5_f64,
        prop::array::uniform2(log_uniform(1e-3, 3.0)),
        prop::array::uniform3(0.0..6.3_f64),
    )
}

fn path(case: &Case, (size, depth, shares, phases): Shape, n: u32) -> Vec<[f64; 3]> {
    let along = size * case.mu.clamp(0.01, 1.0);
    closed_path([shares[0] * along, shares[1] * along, size], phases, depth, n)
}

/// With a potential no closed path gives energy, also through opening.
#[test]
fn potential_cycles_dissipate() {
    let config = config(300, file!(), Some("resolved_potential"));
    let dissipating = Cell::new(0);
    hold(config, &(cases(), shapes()), |(case, shape)| {
        let formulas = Formulas {
            yielding: None,
            ..case.formulas
        };
        let case = Case {
            friction: AsperityFriction::StickSlip(HistoryRule::Potential),
            formulas,
            ..case
        };
        let [[coarse, _], [middle, _], [fine, size]] = [250, 500, 1000].map(|n| work(&case, &path(&case, shape, n)));
        let rounding = 1e-11 * size;
        prop_assert!(
            fine >= -(fine - middle).abs() - (middle - coarse).abs() - rounding,
            "{coarse:e} {middle:e} {fine:e} {size:e}"
        );
        dissipating.set(dissipating.get() + u32::from(fine > 1e-6 * size));
        Ok(())
    });
    println!("{} of 300 cycles dissipate", dissipating.get());
    // About 170 do; the bound is eight standard deviations of that number below it.
    assert!(dissipating.get() > 100);
}

/// At constant `u_n` no rule gives energy.
#[test]
fn cycles_at_constant_interference_dissipate() {
    let config = config(1000, file!(), Some("resolved_constant"));
    hold(config, &(cases(), shapes()), |(case, shape)| {
        let path: Vec<[f64; 3]> = path(&case, shape, 100)
            .into_iter()
            .map(|[x, y, _]| [x, y, shape.0])
            .collect();
        let law = case.law();
        let zero = vec![0.0; law.info().n_state()];
        let mut state = at(&law, [path[0][0], path[0][1], shape.0], &zero).end;
        // Loaded without tangential traction.
        let n_memory = case.n_memory();
        let n_dent = if case.yields() { 2 } else { 0 };
        let first = usize::from(rule(&case).is_none());
        for bin in state[3..].chunks_exact_mut(n_memory) {
            bin[first..n_memory - n_dent].fill(0.0);
        }
        let (mut work, mut size) = (0.0, 0.0);
        let mut before = at(&law, path[0], &state).traction;
        for step in path.windows(2) {
            let found = at(&law, step[1], &state);
            let [x, y] = [0, 1].map(|q| step[1][q] - step[0][q]);
            work += 0.5 * ((before[0] + found.traction[0]) * x + (before[1] + found.traction[1]) * y);
            size += share(&case) * found.traction[2] * x.hypot(y);
            before = found.traction;
            state = found.end;
        }
        prop_assert!(work >= -1e-11 * size, "{work:e} {size:e} {case:?}");
        Ok(())
    });
}

/// Largest gain over `mu t_n` times the length of the path, for what has no potential, at changing `u_n`: the numbers of the
/// documentation.
#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_gains_without_a_potential() {
    let (elastic, jumps, smooth) = (None, Some(YieldCurves::Published), Some(YieldCurves::Continuous));
    let whole = AsperityFriction::StickSlip;
    let annuli = |rule| AsperityFriction::Annuli(rule, 4);
    let interpolated = || AsperityFriction::MindlinIwan(Radii::equally_spaced(7).unwrap());
    use HistoryRule::{EndPoint, Incremental, Paper};
    let coulomb = AsperityLimit::Coulomb;
    for (name, yielding, friction, limit, stated) in [
        ("incremental", elastic, whole(Incremental), coulomb, 4.4),
        (
            "incremental, continuous yield",
            smooth,
            whole(Incremental),
            coulomb,
            3.6,
        ),
        ("incremental, published yield", jumps, whole(Incremental), coulomb, 13.5),
        ("paper", elastic, whole(Paper), coulomb, 72.0),
        ("paper, continuous yield", smooth, whole(Paper), coulomb, 69.0),
        ("paper, published yield", jumps, whole(Paper), coulomb, 69.0),
        ("end-point", elastic, whole(EndPoint), coulomb, 4.4),
        ("end-point, continuous yield", smooth, whole(EndPoint), coulomb, 3.6),
        ("end-point, published yield", jumps, whole(EndPoint), coulomb, 13.5),
        ("annuli, incremental", elastic, annuli(Incremental), coulomb, 1.7),
        (
            "annuli, incremental, continuous yield",
            smooth,
            annuli(Incremental),
            coulomb,
            1.4,
        ),
        ("mindlin-iwan", elastic, interpolated(), coulomb, 2.8),
        ("mindlin-iwan, published yield", jumps, interpolated(), coulomb, 3.2),
        ("ceb", smooth, whole(Incremental), AsperityLimit::Ceb, 5.1),
        (
            "shear strength",
            smooth,
            whole(Incremental),
            AsperityLimit::ShearStrength,
            2.7,
        ),
    ] {
        let config = ProptestConfig {
            // The numbers of the documentation are those of 3000.
            cases: 600,
            failure_persistence: None,
            rng_seed: prop::test_runner::RngSeed::Fixed(7),
            ..ProptestConfig::default()
        };
        let gains = Cell::new([0.0_f64; 2]);
        let outcome = TestRunner::new(config).run(&(coulomb_cases(), shapes()), |(case, shape)| {
            let [_, usual] = published();
            let formulas = match yielding {
                Some(curves) => Formulas {
                    yielding: case.formulas.yielding.or(usual.yielding),
                    ..case.formulas
                }
                .with_curves(curves),
                None => Formulas {
                    yielding: None,
                    ..case.formulas
                },
            };
            let case = Case {
                friction: friction.clone(),
                limit,
                formulas,
                mu: case.mu.max(0.01),
                ..case
            };
            let mut largest = gains.get();
            for (n, largest) in [100, 400].into_iter().zip(&mut largest) {
                let [work, size] = work(&case, &path(&case, shape, n));
                if size > 0.0 {
                    *largest = largest.max(-work / size);
                }
            }
            gains.set(largest);
            Ok(())
        });
        assert!(outcome.is_ok());
        let [coarse, fine] = gains.get();
        println!(
            "{name}: gains up to {:.2} % with 100 steps, {:.2} % with 400",
            100.0 * coarse,
            100.0 * fine
        );
        assert!(100.0 * coarse.max(fine) <= stated, "{name}: {coarse} {fine}");
    }
}

/// Loaded, unloaded to nothing and loaded again, a hundred times: the same forces each time.
#[test]
fn unloading_and_reloading_a_hundred_times() {
    for formulas in published() {
        for friction in [
            AsperityFriction::StickSlip(HistoryRule::EndPoint),
            AsperityFriction::StickSlip(HistoryRule::Incremental),
            AsperityFriction::MindlinIwan(Radii::equally_spaced(7).unwrap()),
        ] {
            let case = Case {
                formulas,
                gaps: vec![0.0, 5e-7, 1.5e-6],
                densities: vec![1e5, 2e5, 3e5],
                mu: 0.3,
                friction,
                cone: Cone::Circle,
                limit: AsperityLimit::Coulomb,
            };
            let law = case.law();
            let mut state = vec![0.0; law.info().n_state()];
            let cycle = |state: &mut Vec<f64>| -> Vec<[f64; 3]> {
                [2e-6, 1.2e-6, 0.0, 1.2e-6, 2e-6]
                    .into_iter()
                    .map(|n| {
                        let found = at(&law, [2e-8, 0.0, n], state);
                        *state = found.end;
                        found.traction
                    })
                    .collect()
            };
            cycle(&mut state);
            let first = cycle(&mut state);
            assert_eq!(first[2], [0.0; 3]);
            for _ in 0..100 {
                for (found, expected) in cycle(&mut state).into_iter().zip(&first) {
                    assert!((0..3).all(|q| (found[q] - expected[q]).abs() <= 1e-12 * expected[2]));
                }
            }
        }
    }
}

/// Only one of many bins touches, in a block of points with others; a bin exactly at the onset; bins without asperities.
#[test]
fn single_bins_and_empty_bins() {
    let [_, formulas] = published();
    let onset = formulas.asperity().onset_of_yield();
    let friction = AsperityFriction::StickSlip(HistoryRule::EndPoint);
    let case = Case {
        formulas,
        gaps: (0..12).map(|i| 1e-6 * f64::from(i)).collect(),
        densities: vec![1e5; 12],
        mu: 0.3,
        friction,
        cone: Cone::Circle,
        limit: AsperityLimit::Coulomb,
    };
    let elastic = Formulas {
        yielding: None,
        ..formulas
    };
    let law = case.law();
    let zero = vec![0.0; law.info().n_state()];
    // The first bin alone, at the onset and beyond it.
    for (w, asperity) in [
        (onset, elastic.asperity()),
        (onset.next_up(), formulas.asperity()),
        (9e-7, formulas.asperity()),
    ] {
        let found = at(&law, [0.0, 0.0, w], &zero);
        let contact = asperity.loading(w);
        assert!(relative(found.traction[2], 1e5 * contact.force.value) < 1e-15, "{w:e}");
        assert!(relative(found.tangent[2][2], 1e5 * contact.force.slope) < 1e-15);
        let k = 1e5 * asperity.tangential_modulus() * contact.radius.value;
        assert!(relative(found.tangent[0][0], k) < 1e-15);
        assert_eq!(found.end[5..7], [w, contact.force.value]);
        assert_eq!(found.regime, Regime::Stick);
    }
    // The onset leaves no dent: unloading is elastic.
    let end = at(&law, [0.0, 0.0, onset], &zero).end;
    let found = at(&law, [0.0, 0.0, 0.5 * onset], &end);
    assert!(
        relative(
            found.traction[2],
            1e5 * elastic.asperity().loading(0.5 * onset).force.value
        ) < 1e-15
    );
    // Bins without asperities change nothing and keep the regime.
    let mut sparse = case.clone();
    sparse.densities = (0..12).map(|i| if i % 2 == 0 { 1e5 } else { 0.0 }).collect();
    let mut dense = case.clone();
    (dense.gaps, dense.densities) = ((0..6).map(|i| 2e-6 * f64::from(i)).collect(), vec![1e5; 6]);
    let (sparse, dense) = (sparse.law(), dense.law());
    let mut states = [vec![0.0; 3 + 48], vec![0.0; 3 + 24]];
    for u in [
        [0.0, 0.0, 7e-6],
        [1e-6, 0.0, 5.5e-6],
        [-1e-6, 1e-7, 8e-6],
        [0.0, 0.0, -1e-6],
        [1e-6, 1e-6, 3e-7],
    ] {
        let [a, b] = [at(&sparse, u, &states[0]), at(&dense, u, &states[1])];
        assert_eq!((a.traction, a.tangent, a.regime), (b.traction, b.tangent, b.regime));
        states = [a.end, b.end];
    }
    let empty = Case {
        densities: vec![0.0; 12],
        ..case.clone()
    };
    let found = at(&empty.law(), [1e-6, 0.0, 5e-6], &zero);
    assert_eq!(
        (found.regime, found.traction, found.tangent),
        (Regime::Open, [0.0; 3], [[0.0; 3]; 3])
    );
    // Many points of which one touches, with its first bin.
    let n = 200;
    let bins = PointParameters::uniform(case.bins(), n);
    let law = ResolvedLaw::try_new(bins, PointParameters::uniform(0.3, n), case.friction.clone(), case.cone).unwrap();
    let jump: Vec<[f64; 3]> = (0..n)
        .map(|i| [1e-7, 0.0, if i == 77 { 5e-7 } else { -1e-6 }])
        .collect();
    let found = evaluate_batch(&law, Sticking::Coulomb, once(0..n), &jump, &vec![zero.clone(); n]);
    for (i, point) in found.iter().enumerate() {
        assert_eq!(point.regime == Regime::Open, i != 77);
        let alone = at(&case.law(), jump[i], &zero);
        assert!(point.is_identical(&alone));
    }
}

/// What a constructor refuses, and how bins of a population are stored.
#[test]
fn refused_laws_and_bins() {
    let [formulas, _] = published();
    let bins = |n| AsperityBins::try_new(formulas.asperity(), vec![0.0; n], vec![1.0; n]);
    let law = |mu: f64, n, friction| {
        let bins = PointParameters::uniform(bins(2).unwrap(), 3);
        ResolvedLaw::try_new(bins, PointParameters::uniform(mu, n), friction, Cone::Box)
    };
    let end_point = || AsperityFriction::StickSlip(HistoryRule::EndPoint);
    assert!(law(0.0, 3, end_point()).is_ok() && law(10.0, 3, end_point()).is_ok());
    assert!(matches!(law(0.1, 2, end_point()), Err(Error::Length { .. })));
    assert!(matches!(law(-0.1, 3, end_point()), Err(Error::Parameter { .. })));
    let error = law(0.1, 3, AsperityFriction::StickSlip(HistoryRule::Potential)).unwrap_err();
    assert!(error.to_string().contains("asperities that yield"), "{error}");
    assert!(bins(0).is_err() && bins(MAX_BINS).is_ok() && bins(MAX_BINS + 1).is_err());
    for (gap, density) in [
        (-1e-9, 1.0),
        (f64::NAN, 1.0),
        (f64::INFINITY, 1.0),
        (0.0, -1.0),
        (0.0, f64::NAN),
    ] {
        let error = AsperityBins::try_new(formulas.asperity(), vec![0.0, gap], vec![1.0, density]).unwrap_err();
        assert!(
            matches!(
                error,
                Error::Parameter {
                    place: Place::Entry(1),
                    ..
                }
            ),
            "{error}"
        );
    }
    let unequal = AsperityBins::try_new(formulas.asperity(), vec![0.0], vec![1.0, 1.0]);
    assert!(matches!(unequal, Err(Error::Length { .. })));
    // The state is described: components and units of every bin.
    let law = law(0.1, 3, end_point()).unwrap();
    let state: Vec<String> = law
        .info()
        .state
        .iter()
        .map(|q| format!("{} {}", q.name, q.unit))
        .collect();
    let expected = [
        "u_x m",
        "u_y m",
        "u_n m",
        "f_x_1 N",
        "f_y_1 N",
        "w_max_1 m",
        "f_max_1 N",
        "f_x_2 N",
        "f_y_2 N",
        "w_max_2 m",
        "f_max_2 N",
    ];
    assert_eq!(state, expected);
}

/// Bins keep the number of asperities; equally spaced ones cover all gaps, Gauss rules keep the mean gap.
#[test]
fn bins_of_a_population() {
    let population = super::population();
    let asperity = published()[0].asperity();
    for n in [1, 2, 7, 101] {
        let bins = AsperityBins::equally_spaced(asperity, &population, n).unwrap();
        let sum: f64 = bins.densities().iter().sum();
        assert!(bins.len() == n && relative(sum, population.density()) < 1e-12);
        let largest = if n == 1 { 0.0 } else { population.gaps().largest() };
        assert!((bins.gaps()[n - 1] - largest).abs() <= 1e-12 * population.gaps().largest());
    }
    let mean = |bins: &AsperityBins| {
        let moments = bins.gaps().iter().zip(bins.densities());
        moments.map(|(gap, density)| gap * density).sum::<f64>() / population.density()
    };
    let fine = AsperityBins::equally_spaced(asperity, &population, 1024).unwrap();
    for (n, shift) in [(2, 0.0), (4, 0.0), (8, 0.5), (12, 0.9)] {
        let [bins] = AsperityBins::gauss(asperity, &population, n, 5e-6, &[shift])
            .unwrap()
            .try_into()
            .unwrap();
        let sum: f64 = bins.densities().iter().sum();
        assert!(relative(sum, population.density()) < 1e-12);
        assert!(
            relative(mean(&bins), mean(&fine)) < 1e-4,
            "{} {}",
            mean(&bins),
            mean(&fine)
        );
        assert!(bins.gaps().is_sorted(), "{bins:?}");
    }
    for n in [0, MAX_BINS + 1] {
        assert!(AsperityBins::equally_spaced(asperity, &population, n).is_err());
    }
    for (reach, shift) in [(0.0, 0.0), (f64::NAN, 0.0), (5e-6, 1.0), (5e-6, -0.1)] {
        assert!(AsperityBins::gauss(asperity, &population, 4, reach, &[shift]).is_err());
    }
    for n in [0, 3, MAX_BINS] {
        assert!(AsperityBins::gauss(asperity, &population, n, 5e-6, &[0.5]).is_err());
    }
}
