//! The fitted curves inside and outside their range.

use super::{fitted, normal_fit, relative, tangential_fit};
use crate::*;

#[test]
fn formulas_hold_inside_the_range() {
    let curves = fitted();
    let (fit, k) = (normal_fit(), tangential_fit(TangentialEnds::Mindlin));
    let u: f64 = 2.3e-6;
    let x = 2.3_f64.ln();
    let t = (fit.a + fit.b * x + fit.c * (-0.5 * ((x + fit.d) / fit.e).powi(2)).exp()).exp();
    assert!(relative(curves.normal(u).0, t) < 1e-14);
    assert!(
        relative(
            curves.tangential(u)[0].value,
            (k.a + k.b * (k.d * (x - k.c)).tanh()).exp()
        ) < 1e-14
    );
}

/// Value and slope are continuous where the ranges end, and beyond them the limits are those promised.
#[test]
fn curves_go_on_smoothly_outside_the_range() {
    let curves = fitted();
    let around = |u: f64| [u * (1.0 - 1e-9), u * (1.0 + 1e-9)];
    for end in [1e-7, 1e-5] {
        let [a, b] = around(end).map(|u| curves.normal(u));
        assert!(relative(a.0, b.0) < 1e-7 && relative(a.1, b.1) < 1e-7);
        for q in 0..2 {
            let [a, b] = around(end).map(|u| curves.tangential(u)[q]);
            assert!(relative(a.value, b.value) < 1e-7 && relative(a.slope, b.slope) < 1e-7);
        }
    }
    let log_slope = |f: &dyn Fn(f64) -> f64, u: f64| (f(u * 1.001) / f(u)).ln() / 1.001_f64.ln();
    let normal = |u| curves.normal(u).0;
    let [x, y] = [0, 1].map(|q| move |u| fitted().tangential(u)[q].value);
    assert!((log_slope(&normal, 1e-12) - 1.5).abs() < 1e-4);
    assert!((log_slope(&x, 1e-12) - 0.5).abs() < 1e-4);
    assert!(log_slope(&y, 1e-12).abs() < 1e-4 && log_slope(&y, 1.0).abs() < 1e-4);
    let at_end = curves.normal(1e-5).1 * 1e-5 / curves.normal(1e-5).0;
    assert!((log_slope(&normal, 1e-3) - at_end).abs() < 1e-9);

    // Derivatives returned are those of the values, and the curves never fall.
    let mut before = 0.0;
    for i in 0..600 {
        // No step meets an end of the range, where second derivatives jump.
        let u = 1e-12 * 1e10_f64.powf(f64::from(i) / 599.0);
        let h = 1e-6 * u;
        assert!(relative((normal(u + h) - normal(u - h)) / (2.0 * h), curves.normal(u).1) < 1e-6);
        for q in 0..2 {
            let (low, here, high) = (
                curves.tangential(u - h)[q],
                curves.tangential(u)[q],
                curves.tangential(u + h)[q],
            );
            let scale = here.value / u;
            assert!(((high.value - low.value) / (2.0 * h) - here.slope).abs() < 1e-7 * scale);
            assert!(((high.slope - low.slope) / (2.0 * h) - here.curvature).abs() < 1e-6 * scale / u);
        }
        assert!(normal(u) > before);
        before = normal(u);
    }
}

/// Fits in another unit of length are the same curves.
#[test]
fn the_reference_length_is_a_matter_of_taste() {
    let (n, x) = (normal_fit(), tangential_fit(TangentialEnds::Mindlin));
    let shift = 1e6_f64.ln();
    let metres = NormalFit {
        a: n.a + n.b * shift,
        d: n.d + shift,
        u_ref: 1.0,
        ..n
    };
    let x_metres = TangentialFit {
        c: x.c - shift,
        u_ref: 1.0,
        ..x
    };
    let a = FittedCurves::try_new(n, [x; 2]).unwrap();
    let b = FittedCurves::try_new(metres, [x_metres; 2]).unwrap();
    for u in [1e-9, 3e-7, 2e-6, 1e-4] {
        assert!(relative(a.normal(u).0, b.normal(u).0) < 1e-12);
        assert!(relative(a.tangential(u)[0].value, b.tangential(u)[0].value) < 1e-12);
    }
}

#[cfg(feature = "serde")]
#[test]
fn parameters_survive_a_file() {
    let text = serde_json::to_string(&(normal_fit(), tangential_fit(TangentialEnds::Mindlin))).unwrap();
    let back: (NormalFit, TangentialFit) = serde_json::from_str(&text).unwrap();
    assert_eq!(back, (normal_fit(), tangential_fit(TangentialEnds::Mindlin)));
    assert!(serde_json::from_str::<TableOptions>("{\"tolerence_normal\": 1e-3}").is_err());
}
