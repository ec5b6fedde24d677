//! Limits of tangential forces that follow from the yield strength.

use std::f64::consts::PI;

use super::elastic_plastic::published;
use crate::physics::sliding_yield::ceb_factor;
use crate::*;

/// `D` and `T` at the depth `zeta` by integration of point forces over the contact circle: Boussinesq's along the normal,
/// Cerruti's along the surface, with Hertz's distribution of largest value 1 on a circle of radius 1.
fn on_axis(zeta: f64, nu: f64) -> [f64; 2] {
    let n = 4000;
    let (mut vertical, mut radial, mut shear) = (0.0, 0.0, 0.0);
    for i in 0..n {
        // r = sin(theta) takes the root out of the distribution.
        let width = 0.5 * PI / f64::from(n);
        let (r, q) = ((f64::from(i) + 0.5) * width).sin_cos();
        let force = q * r * q * width;
        let distance = r.hypot(zeta);
        let (three, five) = (distance.powi(3), distance.powi(5));
        vertical -= force * 3.0 * zeta.powi(3) / five;
        radial += force * 0.5 * ((1.0 - 2.0 * nu) * zeta / three - 3.0 * zeta * r * r / five);
        shear += force * 1.5 * r * r * zeta / five;
    }
    [radial - vertical, shear]
}

/// First yield by the stresses of point forces, over all depths.
#[test]
fn ceb_is_first_yield_under_both_forces() {
    for nu in [0.0, 0.1, 0.3, 0.45, 0.5] {
        let depths = (1..=800).map(|i| on_axis(f64::from(i) * 1e-3, nu));
        let [normal, shear] = depths.max_by(|a, b| a[0].total_cmp(&b[0])).unwrap();
        let expected = normal / (3.0_f64.sqrt() * shear);
        let error = ceb_factor(nu) / expected - 1.0;
        println!("nu = {nu}: {:.4}, {error:.1e}", ceb_factor(nu));
        // The depth is found to 1e-3 of the radius.
        assert!(error.abs() < 2e-3);
    }
    assert!((ceb_factor(0.3) - 1.260).abs() < 1e-3);
}

/// The figures of the description, and what must hold whatever the past.
#[test]
fn limits_over_the_normal_force() {
    for formulas in published() {
        for curves in [YieldCurves::Published, YieldCurves::Continuous] {
            let asperity = formulas.with_curves(curves).asperity();
            let ratio = |limit, w: f64, dent| {
                let force = asperity.contact(w, dent).0.force.value;
                asperity.slip_limit(limit, w, dent).unwrap().value / force
            };
            let loaded = 20.0 * asperity.onset_of_yield();
            let (_, dent) = asperity.contact(loaded, Dent::default());
            let depth = asperity.unloading(dent).unwrap().residual_depth;
            for (share, expected) in [(0.01, 0.127), (0.1, 0.420)] {
                let found = ratio(AsperityLimit::Ceb, depth + (1.0 - share) * (loaded - depth), dent);
                assert!((found - expected).abs() < 1e-3, "{found}");
            }
            // Nothing is left at a load that is larger than all before, and all at the first touch.
            assert_eq!(ratio(AsperityLimit::Ceb, loaded, dent), 0.0);
            assert_eq!(ratio(AsperityLimit::Ceb, loaded, Dent::default()), 0.0);
            for limit in [AsperityLimit::Ceb, AsperityLimit::ShearStrength] {
                let ratios: Vec<f64> = (1..100)
                    .map(|i| ratio(limit, depth + 0.01 * f64::from(i) * (loaded - depth), dent))
                    .collect();
                let falls = |pair: &[f64]| pair[1] < pair[0] || pair == [0.0; 2];
                assert!(ratios.windows(2).all(falls), "{limit:?} {ratios:?}");
                assert!(asperity.slip_limit(limit, depth, dent).unwrap().value == 0.0);
            }
            for w in [1.0, 30.0] {
                let left = ratio(
                    AsperityLimit::ShearStrength,
                    w * asperity.onset_of_yield(),
                    Dent::default(),
                );
                assert!((0.0..1.0).contains(&left), "{left}");
            }
            assert_eq!(asperity.slip_limit(AsperityLimit::Coulomb, loaded, dent), None);
        }
    }
    // The published material of single asperities, over `delta_y`.
    let asperity = published()[1].asperity();
    for (times, expected) in [(2.0, 0.917), (3.0, 0.779), (10.0, 0.446), (30.0, 0.184), (100.0, 0.0)] {
        let w = times / 1.9 * asperity.onset_of_yield();
        let limit = asperity.slip_limit(AsperityLimit::ShearStrength, w, Dent::default());
        let left = limit.unwrap().value / asperity.loading(w).force.value;
        assert!((left - expected).abs() < 6e-4, "{left}");
    }
    // `tau/p` with `p = 0.9 P`.
    let left = (1.0 / 0.81_f64 - 1.0).sqrt() / 3.0_f64.sqrt();
    assert!((left - 0.28).abs() < 5e-3);
}

#[test]
fn elastic_asperities_have_no_strength() {
    let elastic = Asperity::try_new(ElasticPair::new(192e9, 0.3), 1e-3, None).unwrap();
    assert_eq!(elastic.slip_limit(AsperityLimit::Ceb, 1e-6, Dent::default()), None);
    let bins = AsperityBins::try_new(elastic, vec![0.0], vec![1e6]).unwrap();
    let law = |limit| {
        let (bins, mu) = (
            PointParameters::uniform(bins.clone(), 1),
            PointParameters::uniform(0.1, 1),
        );
        let friction = AsperityFriction::StickSlip(HistoryRule::Incremental);
        ResolvedLaw::try_new(bins, mu, friction, Cone::Circle)
            .unwrap()
            .with_limit(limit)
    };
    for limit in [AsperityLimit::Ceb, AsperityLimit::ShearStrength] {
        let refused = law(limit).unwrap_err().to_string();
        assert!(
            refused.contains("elastic asperities") && refused.contains("yield strength"),
            "{refused}"
        );
    }
    let coulomb = law(AsperityLimit::Coulomb).unwrap();
    assert_eq!(coulomb.info().parameters.iter().filter(|of| of.name == "mu").count(), 1);
}
