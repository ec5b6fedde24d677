//! The fitted curves in blocks, with elementary functions of their own, against the same curves point by point with
//! those of the standard library.

use std::cell::Cell;
use std::iter::once;

use proptest::prelude::*;

use super::oracle::{Expected, SMALLEST, expected};
use super::{config, histories, hold, normal_fit, remembered, tangential_fit};
use crate::curves::{CurveBlock, PointCurves};
use crate::simd::BLOCK;
use crate::simd::elementary::Real;
use crate::testing::{PointResponse, evaluate_batch, fitted_curves, friction_coefficient, log_uniform, step};
use crate::*;

/// Fits of the points of a batch. Whether any has a range and whether all are equal along x and y changes the code that
/// evaluates them.
fn batch_of_fits(n: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<FittedCurves>> {
    (prop::collection::vec(fitted_curves(), n), any::<bool>(), any::<bool>()).prop_map(|(list, ranged, isotropic)| {
        let change = |curves: FittedCurves| {
            let (mut normal, [mut x, mut y]) = (*curves.normal_fit(), *curves.tangential_fits());
            if !ranged {
                (normal.range, x.range, y.range) = (None, None, None);
            }
            FittedCurves::try_new(normal, [x, if isotropic { x } else { y }]).unwrap()
        };
        list.into_iter().map(change).collect()
    })
}

/// `t_n, t_n', k_x, k_x', k_x'', k_y, k_y', k_y''` of points at one interference each.
fn in_blocks<R: Real>(curves: &FittedPoints<R>, u_n: &[f64]) -> Vec<[f64; 8]> {
    let (mut workspace, mut block) = (Default::default(), CurveBlock::<BLOCK>::new());
    let mut all = Vec::new();
    for (first, u_n) in (0..).step_by(BLOCK).zip(u_n.chunks(BLOCK)) {
        curves.evaluate(first, u_n, u_n, true, &mut workspace, &mut block);
        all.extend((0..u_n.len()).map(|i| {
            let [x, y] = [0, 1].map(|q| {
                let (k, slope) = (&block.tangential[q], &block.tangential_slope[q]);
                [k.0[i], slope.0[i], block.tangential_curvature[q].0[i]]
            });
            let (t, slope) = (block.normal.0[i], block.normal_slope.0[i]);
            [t, slope, x[0], x[1], x[2], y[0], y[1], y[2]]
        }));
    }
    all
}

/// The same by the curves of one point.
fn by_point(curves: &FittedCurves, u_n: f64) -> [f64; 8] {
    let ((t, slope), [x, y]) = (curves.normal(u_n), curves.tangential(u_n));
    [t, slope, x.value, x.slope, x.curvature, y.value, y.slope, y.curvature]
}

/// Errors of values relative to themselves, of derivatives relative to the larger of themselves and of the value over
/// the interference: largest of the values, of the first and of the second derivatives.
fn errors(found: [f64; 8], expected: [f64; 8], u_n: f64) -> [f64; 3] {
    const ORDER: [usize; 8] = [0, 1, 0, 1, 2, 0, 1, 2];
    const VALUE: [usize; 8] = [0, 0, 2, 2, 2, 5, 5, 5];
    let mut worst = [0.0_f64; 3];
    for i in 0..8 {
        let scale = (0..ORDER[i]).fold(expected[VALUE[i]], |value, _| value / u_n);
        let error = (found[i] - expected[i]).abs() / scale.max(expected[i].abs());
        // No number is as bad as any error.
        let error = if error.is_nan() { f64::INFINITY } else { error };
        worst[ORDER[i]] = worst[ORDER[i]].max(error);
    }
    worst
}

/// Largest errors of curves in precision `R` over random fits and interferences between two bounds.
fn largest_errors<R: Real>(bounds: [f64; 2]) -> [f64; 3] {
    let config = config(400, file!(), None);
    let worst = Cell::new([0.0_f64; 3]);
    let points = batch_of_fits(1..150).prop_flat_map(move |curves| {
        let n = curves.len();
        (
            Just(curves),
            prop::collection::vec(log_uniform(bounds[0], bounds[1]), n),
            any::<bool>(),
        )
    });
    hold(config, &points, |(curves, u_n, uniform)| {
        let curves = match uniform {
            true => PointParameters::uniform(curves[0], curves.len()),
            false => PointParameters::per_point(curves),
        };
        let found = in_blocks(&FittedPoints::<R>::new(&curves), &u_n);
        for (i, (found, &u)) in found.into_iter().zip(&u_n).enumerate() {
            let expected = by_point(curves.at(i), u);
            let (normal, [x, y]) = (curves.at(i).normal_fit(), curves.at(i).tangential_fits());
            // Beyond, exponentials are held.
            let held = |value: f64, scale: f64, a: f64| ((value / scale).ln() - a).abs() > R::LARGEST_EXPONENT - 1.0;
            let [t, _, k_x, _, _, k_y, _, _] = expected;
            if held(t, normal.t_ref, normal.a) || held(k_x, x.k_ref, x.a) || held(k_y, y.k_ref, y.a) {
                continue;
            }
            let here = errors(found, expected, u);
            prop_assert!(here.iter().all(|e| e.is_finite()), "{found:?} {:?}", curves.at(i));
            worst.set(std::array::from_fn(|k| worst.get()[k].max(here[k])));
        }
        Ok(())
    });
    worst.get()
}

/// Largest errors of a usual fit over the interferences that a joint works at.
fn one_fit<R: Real>() -> [f64; 3] {
    let (normal, x) = (normal_fit(), tangential_fit(TangentialEnds::Mindlin));
    let curves = FittedCurves::try_new(normal, [x; 2]).unwrap();
    let u_n: Vec<f64> = (0..=20_000).map(|i| 1e-8 * 1e4_f64.powf(f64::from(i) / 2e4)).collect();
    let points = FittedPoints::<R>::new(&PointParameters::uniform(curves, u_n.len()));
    let found = in_blocks(&points, &u_n);
    found.into_iter().zip(&u_n).fold([0.0_f64; 3], |worst, (found, &u)| {
        let here = errors(found, by_point(&curves, u), u);
        std::array::from_fn(|k| worst[k].max(here[k]))
    })
}

fn short(errors: [f64; 3]) -> String {
    errors.map(|e| format!("{e:.1e}")).join(", ")
}

#[test]
fn double_precision_agrees_with_the_standard_functions() {
    let worst = largest_errors::<f64>([1e-12, 1e-2]);
    println!(
        "f64, 1e-12 m to 1e-2 m: values, first and second derivatives within {}",
        short(worst)
    );
    let [values, slopes, curvatures] = worst;
    // Exponents of these fits reach 200, whose rounding alone is 1e-13 of the value, in either calculation.
    assert!(values <= 3e-13 && slopes <= 3e-13 && curvatures <= 1e-12);
}

#[test]
fn single_precision_has_seven_digits_less() {
    let everywhere = largest_errors::<f32>([1e-12, 1e-2]);
    println!(
        "f32, 1e-12 m to 1e-2 m: values, first and second derivatives within {}",
        short(everywhere)
    );
    let usual = one_fit::<f32>();
    println!("f32, one fit, 1e-8 m to 1e-4 m: within {}", short(usual));
    assert!(usual.iter().all(|&e| e < 2e-6) && everywhere.iter().all(|&e| e < 2e-4));
}

/// Beyond 1e-150 and 1e150 references nothing changes, and up to there, as long as the values are numbers, they agree.
#[test]
fn extremes_are_held() {
    let bare = |fit: NormalFit| NormalFit { range: None, ..fit };
    let (x, y) = (
        tangential_fit(TangentialEnds::Mindlin),
        tangential_fit(TangentialEnds::Constant),
    );
    let unranged = |fit: TangentialFit| TangentialFit { range: None, ..fit };
    let fits = [
        FittedCurves::try_new(normal_fit(), [x, y]).unwrap(),
        FittedCurves::try_new(bare(normal_fit()), [unranged(x), unranged(y)]).unwrap(),
    ];
    let mut worst = 0.0_f64;
    for curves in fits {
        let exponents = (-323..=308).chain([-324]);
        let u_n: Vec<f64> = exponents
            .map(|p| 10.0_f64.powi(p).clamp(f64::from_bits(1), f64::MAX))
            .chain([f64::from_bits(1), f64::MIN_POSITIVE, f64::MAX])
            .collect();
        let points = FittedPoints::<f64>::new(&PointParameters::uniform(curves, u_n.len()));
        let [lowest, highest] = [1e-156, 1e144].map(|u| in_blocks(&points, &[u])[0]);
        for (found, &u) in in_blocks(&points, &u_n).into_iter().zip(&u_n) {
            assert!(found.iter().all(|v| v.is_finite()), "{u:e} {found:?}");
            let values = [found[0], found[2], found[5]];
            if !(0.5e-156..=2e144).contains(&u) {
                let end = if u < 1.0 { lowest } else { highest };
                for (value, end) in values.into_iter().zip([end[0], end[2], end[5]]) {
                    // The product with the reference is rounded once more.
                    assert!((value - end).abs() <= 1e-12 * end, "{u:e} {value:e} {end:e}");
                }
                continue;
            }
            let expected = by_point(&curves, u);
            for (value, expected) in values.into_iter().zip([expected[0], expected[2], expected[5]]) {
                // Cut off at 1e150, and where the exponential would leave the number range.
                if (1e-290..1e149).contains(&expected) {
                    let error = (value - expected).abs() / expected;
                    assert!(error < 2e-12, "{u:e} {value:e} {expected:e}");
                    worst = worst.max(error);
                }
            }
        }
    }
    println!("values from 1e-156 m to 1e144 m within {worst:.1e}");
}

/// Largest errors of tractions and end states relative to themselves, and of the tangent's entries relative to the
/// largest of their row; both beside the rounding of what cancels.
fn law_errors(found: &PointResponse, by_point: &PointResponse, expected: &Expected) -> (f64, f64) {
    let error = |found: f64, by_point: f64, scale: f64, rounding: f64| {
        let scale = scale + 0.01 * rounding + SMALLEST;
        if found == by_point {
            0.0
        } else {
            (found - by_point).abs() / scale
        }
    };
    let (mut tractions, mut tangents) = (0.0_f64, 0.0_f64);
    let values = found.traction.iter().zip(&by_point.traction).zip(&expected.traction);
    let memory = found.end[3..].iter().zip(&by_point.end[3..]).zip(&expected.memory);
    for ((&found, &by_point), expected) in values.chain(memory) {
        tractions = tractions.max(error(found, by_point, by_point.abs(), expected.value.rounding));
    }
    for i in 0..3 {
        let row = by_point.tangent[i].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        for k in 0..3 {
            let derivative = expected.traction[i].derivatives[k].rounding;
            let closing = if k == 2 {
                expected.traction[i].value.rounding / found.end[2]
            } else {
                0.0
            };
            let (found, by_point) = (found.tangent[i][k], by_point.tangent[i][k]);
            tangents = tangents.max(error(found, by_point, row, derivative + closing));
        }
    }
    (tractions, tangents)
}

#[test]
fn laws_agree_on_both_paths() {
    let config = config(150, file!(), None);
    let (worst, counts) = (Cell::new([0.0_f64; 2]), Cell::new(RegimeCounts::default()));
    let points = batch_of_fits(1..100).prop_flat_map(|curves| {
        let n = curves.len();
        let steps = prop::collection::vec(step(), n);
        (Just(curves), prop::collection::vec(friction_coefficient(), n), steps)
    });
    hold(config, &points, |(curves, mu, steps)| {
        let n = curves.len();
        let each = PointParameters::per_point(curves);
        let mu = PointParameters::per_point(mu);
        let jump: Vec<[f64; 3]> = steps.iter().map(|step| step.0).collect();
        for history in histories() {
            let begin: Vec<Vec<f64>> = steps.iter().map(|step| remembered(history, step.1).to_vec()).collect();
            let vector = RoughLaw::try_new(FittedPoints::new(&each), mu.clone(), history).unwrap();
            let scalar = FrictionalLaw::try_new(each.clone(), mu.clone(), history).unwrap();
            for sticking in [Sticking::Coulomb, Sticking::Full] {
                let found = evaluate_batch(&vector, sticking, once(0..n), &jump, &begin);
                let by_point = evaluate_batch(&scalar, sticking, once(0..n), &jump, &begin);
                for i in 0..n {
                    let (found, by_point) = (&found[i], &by_point[i]);
                    if jump[i][2] <= 0.0 {
                        prop_assert!(found.is_identical(by_point), "{found:?} {by_point:?}");
                    } else if jump[i][2] >= 1e-12 {
                        let (curves, mu) = (each.at(i), *mu.at(i));
                        let expected = expected(curves, mu, history, sticking, jump[i], &begin[i]);
                        if expected.cone_distance < 1e-11 {
                            continue;
                        }
                        prop_assert_eq!(found.regime, by_point.regime);
                        let (tractions, tangents) = law_errors(found, by_point, &expected);
                        prop_assert!(
                            tractions <= 1e-13 && tangents <= 1e-12,
                            "{:e} {:e} {:?} {:?} {:?}",
                            tractions,
                            tangents,
                            history,
                            found,
                            by_point
                        );
                        let [t, j] = worst.get();
                        worst.set([t.max(tractions), j.max(tangents)]);
                    } else {
                        // Denormal interferences: nothing but numbers.
                        let mut numbers = found
                            .traction
                            .iter()
                            .chain(found.tangent.as_flattened())
                            .chain(&found.end);
                        prop_assert!(numbers.all(|v| v.is_finite()), "{found:?}");
                    }
                    let mut sum = counts.get();
                    sum.count(found.regime);
                    counts.set(sum);
                }
            }
        }
        Ok(())
    });
    let ([tractions, tangents], counts) = (worst.get(), counts.get());
    println!("{counts:?}: tractions within {tractions:.1e}, tangents within {tangents:.1e} of their row");
    let least = counts.total() / 20;
    assert!(counts.stick > least && counts.slip > least && counts.open > least);
}
