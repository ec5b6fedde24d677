//! The library's own exponential and logarithm against those of the standard library, which are right to the last bit
//! or the one before.

use crate::simd::elementary::{Real, ln_pair};

/// Largest error of `e^x` over arguments between two bounds: relative, and after the share that rounding of the
/// argument explains, `|x|` units.
fn exponential_errors<R: Real, const FMA: bool>(from: f64, to: f64, unit: f64) -> [f64; 2] {
    const N: u32 = 400_000;
    let mut worst = [0.0_f64; 2];
    for i in 0..=N {
        let x = R::of(from + (to - from) * f64::from(i) / f64::from(N));
        let error = (x.natural_exp::<FMA>().double() / x.double().exp() - 1.0).abs();
        let explained = unit * x.double().abs();
        worst = [worst[0].max(error), worst[1].max(error - explained)];
    }
    worst
}

/// Largest error of `ln x` over arguments spread evenly over the octaves: relative to the larger of the logarithm and 1,
/// and relative to the logarithm within a factor of `sqrt(2)` of 1, where nothing is added to it.
fn logarithm_errors<R: Real, const FMA: bool>(from: f64, to: f64) -> [f64; 2] {
    const N: u32 = 400_000;
    let mut worst = [0.0_f64; 2];
    for i in 0..=N {
        let share = f64::from(i) / f64::from(N);
        let far = R::of((from.ln() + (to / from).ln() * share).exp());
        let near = R::of((0.69 * (share - 0.5)).exp());
        let (found, found_near) = ln_pair::<R, FMA>(far, near);
        let (of_near, of_far) = ln_pair::<R, FMA>(near, far);
        // Neither place nor partner matters much: the division that they share rounds.
        let exact = far.double().ln();
        for found in [found, of_far] {
            worst[0] = worst[0].max((found.double() - exact).abs() / exact.abs().max(1.0));
        }
        let exact = near.double().ln();
        for found in [found_near, of_near] {
            let error = (found.double() - exact).abs();
            worst[1] = worst[1].max(if error == 0.0 { 0.0 } else { error / exact.abs() });
        }
    }
    worst
}

fn check<R: Real, const FMA: bool>(name: &str, unit: f64) {
    let [smallest, largest] = R::RANGE;
    let bound = R::LARGEST_EXPONENT;
    let near = exponential_errors::<R, FMA>(-0.35, 0.35, 0.0)[0] / unit;
    let [everywhere, unexplained] = exponential_errors::<R, FMA>(-bound, bound, unit).map(|e| e / unit);
    let [far, next_to_one] = logarithm_errors::<R, FMA>(smallest, largest).map(|e| e / unit);
    println!(
        "{name}, FMA {FMA}, in units of {unit:.1e}: exp {near:.1} about 0, {everywhere:.1} everywhere, {unexplained:.1} \
         beyond |x|; ln {far:.1} everywhere, {next_to_one:.1} about 1"
    );
    // Values outside are those of the ends: below, of the smallest argument.
    let [least, below] = [-bound, -2.0 * bound].map(|x| R::of(x).natural_exp::<FMA>().double());
    assert!(least == below && least > 0.0);
    assert_eq!(R::of(0.0).natural_exp::<FMA>().double(), 1.0);
    let (of_one, of_two) = ln_pair::<R, FMA>(R::of(1.0), R::of(2.0));
    assert!(of_one.double() == 0.0 && (of_two.double() / 2.0_f64.ln() - 1.0).abs() <= unit);
    assert!(unexplained <= LIMITS[0] && near <= LIMITS[0] && far <= LIMITS[1] && next_to_one <= LIMITS[2]);
}

/// Units of the last place that `exp` beyond the argument's own, `ln` and `ln` about 1 may be wrong by.
const LIMITS: [f64; 3] = [8.0, 3.0, 8.0];

#[test]
fn functions_agree_with_the_standard_library() {
    let (double, single) = (f64::EPSILON, f64::from(f32::EPSILON));
    check::<f64, false>("f64", double);
    check::<f64, true>("f64", double);
    check::<f32, false>("f32", single);
    check::<f32, true>("f32", single);
}
