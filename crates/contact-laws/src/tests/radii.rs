//! Sliders at radii of a contact circle against Mindlin's closed forms at constant normal force.

use super::elastic_plastic::Formulas;
use super::relative;
use super::resolved::Case;
use crate::testing::evaluate_point;
use crate::*;

/// Ranges of the amplitude over the displacement of full slip.
const RANGES: [[f64; 2]; 3] = [[0.1, 0.3], [0.3, 1.0], [1.0, 2.0]];

/// Largest errors: of first loading over `mu N`, and of the loop's area over the closed form in every range.
fn errors(friction: AsperityFriction) -> [f64; 4] {
    let (w, mu) = (3e-6, 0.3);
    let formulas = Formulas::new(192e9, 0.29, 1.4e-3, None);
    let case = Case {
        formulas,
        gaps: vec![0.0],
        densities: vec![1.0],
        mu,
        friction,
        cone: Cone::Circle,
        limit: AsperityLimit::Coulomb,
    };
    let law = case.law();
    let begin = {
        let zero = vec![0.0; law.info().n_state()];
        evaluate_point(&law, 0, Sticking::Coulomb, [0.0, 0.0, w], &zero).end
    };
    let limit = mu * hertz::force(&formulas.material, formulas.radius, w);
    let k = mindlin::stiffness(&formulas.material, formulas.radius, w);
    let d = mindlin::full_slip_displacement(limit, k);
    let at = |u: f64, begin: &[f64]| evaluate_point(&law, 0, Sticking::Coulomb, [0.6 * u, 0.8 * u, w], begin);
    let force = |u: f64, begin: &[f64]| {
        let t = at(u, begin).traction;
        0.6 * t[0] + 0.8 * t[1]
    };
    let loading = (0..=400).fold(0.0_f64, |worst, i| {
        let u = 1.5 * d * f64::from(i) / 400.0;
        worst.max((force(u, &begin) - mindlin::loading_force(limit, k, u)).abs() / limit)
    });
    let area = |share: f64| {
        let amplitude = share * d;
        let up = at(amplitude, &begin).end;
        let down = at(-amplitude, &up).end;
        let n = 1000;
        let step = 2.0 * amplitude / f64::from(n);
        let mut area = 0.0;
        for (state, from, sign) in [(&up, amplitude, -1.0), (&down, -amplitude, 1.0)] {
            let along = |i: i32| force(from + sign * step * f64::from(i), state);
            area += (1..=n)
                .map(|i| 0.5 * sign * step * (along(i - 1) + along(i)))
                .sum::<f64>();
        }
        area / mindlin::loop_area(limit, k, amplitude) - 1.0
    };
    let areas = RANGES.map(|[from, to]| {
        let shares = (0..=30).map(|i| from * (to / from).powf(f64::from(i) / 30.0));
        shares.fold(0.0_f64, |worst, share| worst.max(area(share).abs()))
    });
    [loading, areas[0], areas[1], areas[2]]
}

/// The table of the documentation.
#[test]
fn errors_against_mindlins_sphere() {
    let annuli = |n| AsperityFriction::Annuli(HistoryRule::Incremental, n);
    let radii = Radii::equally_spaced(100).unwrap();
    for (friction, stated) in [
        (AsperityFriction::MindlinIwan(radii), [0.2, 54.0, 9.6, 0.7]),
        // As stated for the law of a whole point.
        (annuli(8), [2.9, 28.0, 28.0, 28.0]),
        (annuli(16), [0.73, 7.8, 7.8, 7.8]),
        (annuli(32), [0.19, 2.1, 2.1, 2.1]),
    ] {
        let percent = errors(friction).map(|error| 100.0 * error);
        println!("loading and loops within {percent:.2?} %");
        for (found, stated) in percent.into_iter().zip(stated) {
            assert!(found <= stated, "{found} {stated}");
        }
    }
}

/// Forces at full slip and stiffness without slip are exact by the shares of the annuli.
#[test]
fn ends_of_the_loading_curve() {
    let formulas = Formulas::new(192e9, 0.29, 1.4e-3, None);
    let (w, mu) = (3e-6, 0.3);
    for n in [1, 3, 8, 40, 256] {
        let case = Case {
            formulas,
            gaps: vec![0.0],
            densities: vec![1.0],
            mu,
            friction: AsperityFriction::Annuli(HistoryRule::EndPoint, n),
            cone: Cone::Circle,
            limit: AsperityLimit::Coulomb,
        };
        let law = case.law();
        let begin = vec![0.0; law.info().n_state()];
        let at = |u| evaluate_point(&law, 0, Sticking::Coulomb, [u, 0.0, w], &begin);
        let k = mindlin::stiffness(&formulas.material, formulas.radius, w);
        let stuck = evaluate_point(&law, 0, Sticking::Full, [1e-9, 0.0, w], &begin);
        assert!(relative(stuck.tangent[0][0], k) < 1e-12);
        let limit = mu * hertz::force(&formulas.material, formulas.radius, w);
        let slipping = at(1e-3);
        assert_eq!(slipping.regime, Regime::Slip);
        assert!(relative(slipping.traction[0], limit) < 1e-12, "{n}");
    }
    for n in [0, 2, 257] {
        assert!(Radii::equally_spaced(n).unwrap_err().to_string().contains("radii"));
    }
}
