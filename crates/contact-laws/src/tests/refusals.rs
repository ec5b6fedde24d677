//! Every field of every constructor, out of its bounds: the error names parameter, value, unit and place.

use super::{
    STEEL, elastic, fitted, greenwood_williamson, histories, normal_fit, population, relative, tangential_fit,
};
use crate::testing::evaluate_point;
use crate::*;

const NAN: f64 = f64::NAN;
const INF: f64 = f64::INFINITY;

/// A constructor with one value of its input replaced.
struct Field {
    /// Name, as the error has it.
    name: &'static str,
    unit: &'static str,
    place: Place,
    /// What is refused.
    bad: &'static [f64],
    make: fn(f64) -> Result<(), Error>,
}

const NOT_POSITIVE: &[f64] = &[NAN, INF, -INF, 0.0, -0.0, -1.0, -f64::MIN_POSITIVE];
const NEGATIVE: &[f64] = &[NAN, INF, -INF, -1.0, -f64::MIN_POSITIVE];
/// Beyond the bounds of parameters without unit, by one unit in the last place too.
const OUTSIZE: &[f64] = &[
    NAN,
    INF,
    -INF,
    1e6 * (1.0 + f64::EPSILON),
    -1e6 * (1.0 + f64::EPSILON),
    1e7,
    f64::MAX,
];
const OUTSIZE_OR_NEGATIVE: &[f64] = &[
    NAN,
    INF,
    -INF,
    -1.0,
    -f64::MIN_POSITIVE,
    1e6 * (1.0 + f64::EPSILON),
    f64::MAX,
];
/// Beyond the bounds of reference lengths.
const NO_REFERENCE: &[f64] = &[
    NAN,
    INF,
    -INF,
    0.0,
    -0.0,
    -1.0,
    0.9e-150,
    1.1e150,
    f64::MIN_POSITIVE,
    f64::MAX,
];

fn normal(change: impl Fn(&mut NormalFit)) -> Result<(), Error> {
    let mut fit = normal_fit();
    change(&mut fit);
    FittedCurves::try_new(fit, *fitted().tangential_fits()).map(drop)
}

fn tangential(q: usize, change: impl Fn(&mut TangentialFit)) -> Result<(), Error> {
    let mut fits = [tangential_fit(TangentialEnds::Mindlin); 2];
    change(&mut fits[q]);
    FittedCurves::try_new(normal_fit(), fits).map(drop)
}

fn quantiles(probabilities: [f64; 3], values: [f64; 3]) -> Result<(), Error> {
    GapDistribution::try_from_quantiles(&probabilities, &values).map(drop)
}

fn asperities(density: f64, radii: [f64; 2]) -> Result<(), Error> {
    AsperityPopulation::try_new(population().gaps().clone(), density, radii).map(drop)
}

fn material(modulus: f64, nu: f64) -> Result<(), Error> {
    AsperitySumCurves::try_new(population(), ElasticPair::new(modulus, nu), TangentialReading::Mindlin).map(drop)
}

fn tabulated(range: [f64; 2]) -> Result<(), Error> {
    Tabulated::try_new(elastic(), range, TableOptions::default()).map(drop)
}

fn tabulated_with(change: impl Fn(&mut TableOptions)) -> Result<(), Error> {
    let mut options = TableOptions::default();
    change(&mut options);
    Tabulated::try_new(elastic(), [1e-8, 1e-5], options).map(drop)
}

fn friction(mu: PointParameters<f64>) -> Result<(), Error> {
    let curves = PointParameters::uniform(elastic(), mu.len());
    FrictionalLaw::try_new(curves, mu, HistoryRule::Incremental).map(drop)
}

/// The same law in blocks.
fn rough_friction(mu: Vec<f64>) -> Result<(), Error> {
    let curves = FittedPoints::new(&PointParameters::uniform(fitted(), mu.len()));
    RoughLaw::try_new(curves, PointParameters::per_point(mu), HistoryRule::Potential).map(drop)
}

fn springs(mu: PointParameters<f64>, n: usize) -> Result<(), Error> {
    FoundationLaw::of_curves(PointParameters::uniform(elastic(), mu.len()), mu, 0.8, n, 1e-5).map(drop)
}

fn greenwood(change: impl Fn(&mut GreenwoodWilliamsonSurface)) -> Result<(), Error> {
    let mut surface = *greenwood_williamson().surface();
    change(&mut surface);
    GreenwoodWilliamsonCurves::try_new(surface, STEEL, TangentialReading::Mindlin).map(drop)
}

fn on_greenwood(modulus: f64, nu: f64) -> Result<(), Error> {
    let surface = *greenwood_williamson().surface();
    GreenwoodWilliamsonCurves::try_new(surface, ElasticPair::new(modulus, nu), TangentialReading::Mindlin).map(drop)
}

fn fields() -> Vec<Field> {
    let placed = |name, unit, place, bad, make| Field {
        name,
        unit,
        place,
        bad,
        make,
    };
    let field = |name, unit, bad, make| placed(name, unit, Place::Whole, bad, make);
    vec![
        field("normal a", "(no unit)", OUTSIZE, |v| normal(|fit| fit.a = v)),
        field("normal b", "(no unit)", OUTSIZE, |v| normal(|fit| fit.b = v)),
        field(
            "normal c",
            "(no unit)",
            &[NAN, INF, -INF, 1.1e100, -1.1e100, f64::MAX],
            |v| normal(|fit| fit.c = v),
        ),
        field("normal d", "(no unit)", OUTSIZE, |v| normal(|fit| fit.d = v)),
        field(
            "normal e",
            "(no unit)",
            &[NAN, INF, -INF, 0.0, -0.0, -1.0, 0.9e-6, 1.1e6, f64::MAX],
            |v| normal(|fit| fit.e = v),
        ),
        field("normal t_ref", "Pa", NOT_POSITIVE, |v| normal(|fit| fit.t_ref = v)),
        field("normal u_ref", " m", NO_REFERENCE, |v| normal(|fit| fit.u_ref = v)),
        field("normal range", " m", NOT_POSITIVE, |v| {
            normal(|fit| fit.range = Some([v, 1e-5]))
        }),
        field("normal range", " m", &[NAN, INF, -INF, 0.0, -1.0, 1e-7, 0.9e-7], |v| {
            normal(|fit| fit.range = Some([1e-7, v]))
        }),
        field("tangential a", "(no unit)", OUTSIZE, |v| tangential(0, |fit| fit.a = v)),
        field("tangential b", "(no unit)", OUTSIZE_OR_NEGATIVE, |v| {
            tangential(1, |fit| fit.b = v)
        }),
        field("tangential c", "(no unit)", OUTSIZE, |v| tangential(0, |fit| fit.c = v)),
        field("tangential d", "(no unit)", OUTSIZE_OR_NEGATIVE, |v| {
            tangential(1, |fit| fit.d = v)
        }),
        field("tangential k_ref", "Pa/m", NOT_POSITIVE, |v| {
            tangential(0, |fit| fit.k_ref = v)
        }),
        field("tangential u_ref", " m", NO_REFERENCE, |v| {
            tangential(1, |fit| fit.u_ref = v)
        }),
        field("tangential range", " m", NOT_POSITIVE, |v| {
            tangential(0, |fit| fit.range = Some([v, 1e-5]))
        }),
        field("tangential range", " m", &[NAN, INF, -INF, 0.0, -1.0, 1e-7], |v| {
            tangential(1, |fit| fit.range = Some([1e-7, v]))
        }),
        field("k_n", "Pa/m", NOT_POSITIVE, |v| {
            ElasticCurves::try_new(v, [1.0; 2]).map(drop)
        }),
        field("k_x", "Pa/m", NEGATIVE, |v| {
            ElasticCurves::try_new(1.0, [v, 1.0]).map(drop)
        }),
        field("k_y", "Pa/m", NEGATIVE, |v| {
            ElasticCurves::try_new(1.0, [1.0, v]).map(drop)
        }),
        placed("asperity gap", " m", Place::Entry(2), NEGATIVE, |v| {
            GapDistribution::try_from_samples(vec![0.0, 1e-6, v]).map(drop)
        }),
        placed("asperity gap", " m", Place::Entry(0), NEGATIVE, |v| {
            quantiles([0.0, 0.5, 1.0], [v, 1e-6, 2e-6])
        }),
        placed(
            "asperity gap",
            " m",
            Place::Entry(1),
            &[NAN, INF, -INF, -1.0, 0.9e-6],
            |v| quantiles([0.0, 0.5, 1.0], [1e-6, v, 2e-6]),
        ),
        placed(
            "asperity gap",
            " m",
            Place::Entry(2),
            &[NAN, INF, -INF, -1.0, 0.9e-6],
            |v| quantiles([0.0, 0.5, 1.0], [0.0, 1e-6, v]),
        ),
        placed(
            "probability",
            "(no unit)",
            Place::Entry(0),
            &[NAN, INF, -INF, -0.1, 0.1],
            |v| quantiles([v, 0.5, 1.0], [0.0, 1e-6, 2e-6]),
        ),
        placed("probability", "(no unit)", Place::Entry(1), &[NAN, -INF, -0.1], |v| {
            quantiles([0.0, v, 1.0], [0.0, 1e-6, 2e-6])
        }),
        placed(
            "probability",
            "(no unit)",
            Place::Entry(2),
            &[NAN, INF, -INF, 0.9, 1.1],
            |v| quantiles([0.0, 0.5, v], [0.0, 1e-6, 2e-6]),
        ),
        field("asperity_density", "1/m^2", NOT_POSITIVE, |v| asperities(v, [1e-3; 2])),
        field("beta_x", " m", NOT_POSITIVE, |v| asperities(1e6, [v, 1e-3])),
        field("beta_y", " m", NOT_POSITIVE, |v| asperities(1e6, [1e-3, v])),
        field("youngs_modulus", "Pa", NOT_POSITIVE, |v| material(v, 0.3)),
        field("poisson_ratio", "(no unit)", &[NAN, INF, -INF, -1.0, 0.51], |v| {
            material(STEEL.youngs_modulus, v)
        }),
        field("table range, lower end", " m", NOT_POSITIVE, |v| tabulated([v, 1e-5])),
        field(
            "table range, upper end",
            " m",
            &[NAN, INF, -INF, 0.0, -1.0, 1e-8, 0.9e-8],
            |v| tabulated([1e-8, v]),
        ),
        field("tolerance_normal", "(no unit)", NOT_POSITIVE, |v| {
            tabulated_with(|options| options.tolerance_normal = v)
        }),
        field("tolerance_tangential", "(no unit)", NOT_POSITIVE, |v| {
            tabulated_with(|options| options.tolerance_tangential = v)
        }),
        field(
            "max_knots_per_octave",
            "(no unit)",
            &[0.0, 1.0, 2.0, 24.0, 131_072.0],
            |v| tabulated_with(|options| options.max_knots_per_octave = v as u32),
        ),
        field("scale of the heights", " m", NOT_POSITIVE, |v| {
            greenwood(|surface| surface.heights = HeightDistribution::Exponential { scale: v })
        }),
        field("standard_deviation of the heights", " m", NOT_POSITIVE, |v| {
            greenwood(|surface| surface.heights = HeightDistribution::Gaussian { standard_deviation: v })
        }),
        field("reference_height", " m", NOT_POSITIVE, |v| {
            greenwood(|surface| surface.reference_height = v)
        }),
        field("asperity_density", "1/m^2", NOT_POSITIVE, |v| {
            greenwood(|surface| surface.asperity_density = v)
        }),
        field("beta_x", " m", NOT_POSITIVE, |v| {
            greenwood(|surface| surface.radii[0] = v)
        }),
        field("beta_y", " m", NOT_POSITIVE, |v| {
            greenwood(|surface| surface.radii[1] = v)
        }),
        field("youngs_modulus", "Pa", NOT_POSITIVE, |v| on_greenwood(v, 0.3)),
        field("poisson_ratio", "(no unit)", &[NAN, INF, -INF, -1.0, 0.51], |v| {
            on_greenwood(STEEL.youngs_modulus, v)
        }),
        field("work_of_adhesion", "J/m^2", NOT_POSITIVE, |v| {
            Adhesion::try_new(v, 4e-10).map(drop)
        }),
        field("intermolecular_distance", " m", NOT_POSITIVE, |v| {
            Adhesion::try_new(2.5, v).map(drop)
        }),
        field("bins", "(no unit)", &[0.0, 7.0, 1e9], |v| {
            springs(PointParameters::uniform(0.1, 3), v as usize)
        }),
        placed("mu", "(no unit)", Place::Point(0), NEGATIVE, |v| {
            springs(PointParameters::uniform(v, 3), 4)
        }),
        placed("mu", "(no unit)", Place::Point(2), NEGATIVE, |v| {
            springs(PointParameters::per_point(vec![0.1, 0.2, v]), 4)
        }),
        placed("mu", "(no unit)", Place::Point(0), NEGATIVE, |v| {
            friction(PointParameters::uniform(v, 3))
        }),
        placed("mu", "(no unit)", Place::Point(1), NEGATIVE, |v| {
            rough_friction(vec![0.1, v])
        }),
        placed("mu", "(no unit)", Place::Point(2), NEGATIVE, |v| {
            friction(PointParameters::per_point(vec![0.1, 0.2, v]))
        }),
        placed("mu", "(no unit)", Place::Point(1), NEGATIVE, |v| {
            friction(PointParameters::try_indexed(vec![0.1, v], vec![0, 1, 0]).unwrap())
        }),
    ]
}

#[test]
fn every_field_is_checked() {
    for field in fields() {
        for &bad in field.bad {
            let case = format!("{} = {bad:e}", field.name);
            let error = match (field.make)(bad) {
                Err(error) => error,
                Ok(()) => panic!("{case} was accepted"),
            };
            let text = error.to_string();
            let Error::Parameter {
                parameter,
                value,
                unit,
                place,
                requirement,
            } = error
            else {
                panic!("{case}: {text}")
            };
            assert!(parameter.contains(field.name), "{case}: {text}");
            assert!(value == bad || (value.is_nan() && bad.is_nan()), "{case}: {text}");
            assert_eq!(place, field.place, "{case}: {text}");
            assert!(format!(" {unit}").contains(field.unit), "{case}: {text}");
            assert!(!requirement.is_empty());
            // The message carries all of it.
            let place = match place {
                Place::Whole => String::new(),
                Place::Point(i) => format!("at point {i}"),
                Place::Entry(i) => format!("at entry {i}"),
            };
            for part in [field.name, field.unit, &place, requirement, &format!("{bad:e}")] {
                assert!(text.contains(part), "{case}: {part:?} is not in {text:?}");
            }
        }
    }
}

/// What lies on the bounds is accepted, and gives numbers.
#[test]
fn bounds_belong_to_the_domain() {
    let bare = NormalFit {
        range: None,
        ..normal_fit()
    };
    let normals = [
        NormalFit { u_ref: 1e-150, ..bare },
        NormalFit { u_ref: 1e150, ..bare },
        NormalFit {
            c: 500.0,
            e: 1e6,
            ..bare
        },
        NormalFit {
            c: 0.0,
            e: 1e-6,
            ..bare
        },
        // The tail of a bell far beyond the range.
        NormalFit {
            c: 1e100,
            d: -100.0,
            e: 4.6,
            ..normal_fit()
        },
        NormalFit { d: 1e6, ..bare },
        NormalFit { d: -1e6, ..bare },
        NormalFit { b: 1e6, ..bare },
        NormalFit {
            a: 700.0,
            t_ref: 1e-300,
            ..bare
        },
        NormalFit {
            a: -700.0,
            t_ref: 1e300,
            ..bare
        },
    ];
    let step = TangentialFit {
        range: None,
        ..tangential_fit(TangentialEnds::Mindlin)
    };
    let tangentials = [
        TangentialFit { u_ref: 1e-150, ..step },
        TangentialFit { u_ref: 1e150, ..step },
        TangentialFit { c: 1e6, d: 1e6, ..step },
        TangentialFit {
            c: -1e6,
            d: 1e6,
            ..step
        },
        TangentialFit { b: 0.0, d: 0.0, ..step },
        TangentialFit {
            a: 700.0,
            k_ref: 1e-300,
            ..step
        },
    ];
    let fits = (normals.iter().map(|&n| (n, step))).chain(tangentials.iter().map(|&t| (bare, t)));
    for (normal, tangential) in fits {
        let curves = FittedCurves::try_new(normal, [tangential; 2]).unwrap_or_else(|e| panic!("{normal:?}: {e}"));
        let curves = PointParameters::uniform(curves, 1);
        for history in histories() {
            let mu = || PointParameters::uniform(0.3, 1);
            let laws: [Box<dyn TractionLaw>; 3] = [
                Box::new(FrictionalLaw::try_new(curves.clone(), mu(), history).unwrap()),
                Box::new(RoughLaw::try_new(FittedPoints::new(&curves), mu(), history).unwrap()),
                Box::new(FrictionalLaw::try_new(FittedPoints::<f32>::new(&curves), mu(), history).unwrap()),
            ];
            for law in laws {
                for n in [f64::from_bits(1), 1e-150, 1e-9, 1e-6, 1.0, 1e150, f64::MAX] {
                    let begin = [0.0, 0.0, 0.5 * n, 0.0, 0.0];
                    let found = evaluate_point(&*law, 0, Sticking::Coulomb, [1e-7, -1e-7, n], &begin);
                    assert!(
                        found.numbers().all(f64::is_finite),
                        "{normal:?} {tangential:?} {n:e} {found:?}"
                    );
                }
            }
        }
    }
}

/// Lists that do not fit together, and curves that fall: errors of their own kind.
#[test]
fn lists_and_curves_that_do_not_fit() {
    let curves = || PointParameters::uniform(elastic(), 3);
    let law = |mu| FrictionalLaw::try_new(curves(), mu, HistoryRule::Incremental).map(drop);
    let expected = Error::Length {
        list: "mu",
        expected: 3,
        found: 2,
    };
    assert_eq!(law(PointParameters::per_point(vec![0.1; 2])).unwrap_err(), expected);
    assert_eq!(law(PointParameters::uniform(0.1, 2)).unwrap_err(), expected);
    assert_eq!(
        PointParameters::try_indexed(vec![0.1; 2], vec![0, 1, 2]).unwrap_err(),
        Error::Index {
            point: 2,
            index: 2,
            n_sets: 2
        }
    );
    let text = |result: Result<GapDistribution, Error>| result.unwrap_err().to_string();
    assert!(text(GapDistribution::try_from_samples(vec![])).contains("samples"));
    assert!(text(GapDistribution::try_from_quantiles(&[0.0, 1.0], &[0.0])).contains("1 entries where 2"));
    // Fits that fall somewhere in the range: in the middle, at its end, and far away where there is no range.
    let falling = [
        NormalFit {
            b: 0.6,
            c: 1.0,
            e: 0.6,
            ..normal_fit()
        },
        NormalFit {
            b: 0.0,
            c: 0.0,
            ..normal_fit()
        },
        NormalFit {
            b: -1.0,
            c: 0.0,
            range: None,
            ..normal_fit()
        },
        NormalFit {
            b: 0.3,
            c: 4.0,
            d: -6.0,
            e: 1.0,
            range: None,
            ..normal_fit()
        },
    ];
    for fit in falling {
        match FittedCurves::try_new(fit, *fitted().tangential_fits()) {
            Err(error @ Error::NotMonotone { log_slope, .. }) => {
                let text = error.to_string();
                assert!(
                    log_slope <= 0.0 && text.contains("eq. (28)") && text.contains(" m"),
                    "{text}"
                );
            }
            other => panic!("{fit:?}: {other:?}"),
        }
    }
    // The first of them stops rising where u = exp(e - d) um; on a range without this point it is accepted.
    let found = FittedCurves::try_new(falling[0], *fitted().tangential_fits());
    let least = 1e-6 * 0.3_f64.exp();
    assert!(matches!(found, Err(Error::NotMonotone { interference, .. }) if relative(interference, least) < 1e-12));
    let beyond = NormalFit {
        range: Some([4e-6, 1e-5]),
        ..falling[0]
    };
    assert!(FittedCurves::try_new(beyond, *fitted().tangential_fits()).is_ok());
    // A log-slope that is no number does not rise.
    let narrow = NormalFit {
        b: 0.0,
        c: 0.0,
        d: -10.0,
        e: f64::from_bits(1),
        ..normal_fit()
    };
    assert!(FittedCurves::try_new(narrow, *fitted().tangential_fits()).is_err());
    // Stiffness or traction beyond the number range.
    for a in [800.0, -800.0] {
        let text = normal(|fit| fit.a = a).unwrap_err().to_string();
        assert!(text.contains("eq. (28)") && text.contains("Pa"), "{text}");
        let text = tangential(1, |fit| fit.a = a).unwrap_err().to_string();
        assert!(text.contains("eq. (29)") && text.contains("Pa/m"), "{text}");
    }
}

/// Surfaces whose tractions leave the number range, or that have no asperity within reach: 40 standard deviations up there
/// is none in any number that a computer knows.
#[test]
fn surfaces_beyond_the_number_range() {
    let gaussian = HeightDistribution::Gaussian {
        standard_deviation: 2e-6,
    };
    let refused = |change: fn(&mut GreenwoodWilliamsonSurface)| {
        greenwood(|surface| {
            surface.heights = gaussian;
            change(surface);
        })
        .unwrap_err()
        .to_string()
    };
    assert!(refused(|surface| surface.asperity_density = 1e300).contains("neither overflow"));
    assert!(refused(|surface| surface.radii = [1e-320; 2]).contains("asperity_density"));
    assert!(refused(|surface| surface.reference_height = 8e-5).contains("within reach of the heights"));
}

/// Parameters that are positive each but whose product leaves the number range: the law would be NaN where it is not
/// zero.
#[test]
fn stiffnesses_beyond_the_number_range() {
    for (modulus, density) in [(1e-320, 1e-10), (1e300, 1e300)] {
        let gaps = population().gaps().clone();
        let curves = AsperityPopulation::try_new(gaps, density, [1e-3; 2])
            .and_then(|p| AsperitySumCurves::try_new(p, ElasticPair::new(modulus, 0.3), TangentialReading::Mindlin));
        let Ok(curves) = curves else { continue };
        for u in [1e-300, 1e-6, 1e300] {
            assert!(!curves.normal(u).0.is_nan(), "{modulus:e} {density:e} {u:e}");
        }
    }
}
