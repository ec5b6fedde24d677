//! Springs of a foundation against the closed forms of Cattaneo and Mindlin, and their invariants.

use proptest::prelude::*;

use super::{STEEL, asperities, elastic, reference, relative};
use crate::testing::{
    PointResponse, closed_interference, displacement, evaluate_point, friction_coefficient, interference, jump,
    log_uniform,
};
use crate::*;

/// Up to where the springs of most tests are.
const REACH: f64 = 1e-5;

pub(super) fn law<C: ContactCurves>(curves: C, mu: PointParameters<f64>, n: usize) -> FoundationLaw<C> {
    FoundationLaw::of_curves(PointParameters::uniform(curves, 1), mu, STEEL.mindlin_ratio(), n, REACH).unwrap()
}

/// One sphere on an area.
fn sphere(area: f64, radius: f64) -> AsperitySumCurves {
    let gaps = GapDistribution::try_from_samples(vec![0.0]).unwrap();
    let population = AsperityPopulation::try_new(gaps, 1.0 / area, [radius; 2]).unwrap();
    AsperitySumCurves::try_new(population, STEEL, TangentialReading::Mindlin).unwrap()
}

/// A closed point that carries nothing.
fn rest(law: &dyn TractionLaw, u_n: f64) -> Vec<f64> {
    let mut state = vec![0.0; law.info().n_state()];
    state[2] = u_n;
    state
}

fn coulomb(law: &dyn TractionLaw, u: [f64; 3], begin: &[f64]) -> PointResponse {
    evaluate_point(law, 0, Sticking::Coulomb, u, begin)
}

/// Tractions along x from `from` to `to` in equal steps, from a state.
fn along(law: &dyn TractionLaw, u_n: f64, [from, to]: [f64; 2], steps: u32, state: &[f64]) -> Vec<f64> {
    let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(steps);
    (0..=steps)
        .map(|i| coulomb(law, [at(i), 0.0, u_n], state).traction[0])
        .collect()
}

/// Area of the cycle between `-amplitude` and `amplitude` along x, by Masing's rule.
fn loop_area(law: &dyn TractionLaw, u_n: f64, amplitude: f64) -> f64 {
    let steps = 400;
    let t = along(law, u_n, [0.0, amplitude], steps, &rest(law, u_n));
    let sum: f64 = t.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum();
    8.0 * sum * amplitude / f64::from(steps) - 4.0 * amplitude * t[t.len() - 1]
}

/// The table of the page on the law: springs; errors of the mean of 16 places, of pressure, of the loading curve relative to gross slip,
/// and of the loop area at 0.1 to 2 and at 0.01 to 0.1 of the displacement of gross slip.
const DOCUMENTED: [(usize, [f64; 4]); 4] = [
    (8, [1.6e-5, 4.6e-3, 4.6e-2, 1.0]),
    (16, [8.7e-7, 1.2e-3, 1.5e-2, 0.56]),
    (32, [2.5e-6, 1.2e-3, 7.3e-3, 6.4e-2]),
    (64, [2.4e-6, 1.2e-4, 2.0e-3, 2.5e-2]),
];

/// Errors of the mean of several sets of springs for a sphere at the interference `u_n`: of the pressure, of the loading curve relative to
/// gross slip, and of the areas of cycles between each pair of the motions over that of gross slip.
fn errors_of(curves: &AsperitySumCurves, sets: Vec<Foundation>, u_n: f64, cycles: &[[f64; 2]]) -> Vec<f64> {
    let mu = 0.2;
    let limit = mu * curves.normal(u_n).0;
    let k = curves.tangential(u_n)[0].value;
    let full = mindlin::full_slip_displacement(limit, k);
    let uniform = |springs| {
        let at = PointParameters::uniform(curves.clone(), 1);
        FoundationLaw::try_new(
            PointParameters::uniform(springs, 1),
            at,
            PointParameters::uniform(mu, 1),
        )
        .unwrap()
    };
    let laws: Vec<_> = sets.into_iter().map(uniform).collect();
    let mean = |of: &dyn Fn(&dyn TractionLaw) -> f64| laws.iter().map(|law| of(law)).sum::<f64>() / laws.len() as f64;
    let pressed = mean(&|law| coulomb(law, [0.0, 0.0, u_n], &rest(law, u_n)).traction[2]);
    let loading = |x: f64| {
        let found = mean(&|law| coulomb(law, [x * full, 0.0, u_n], &rest(law, u_n)).traction[0]);
        (found - mindlin::loading_force(limit, k, x * full)).abs() / limit
    };
    let area = |x: f64| {
        let found = mean(&|law| loop_area(law, u_n, x * full));
        (found / mindlin::loop_area(limit, k, x * full) - 1.0).abs()
    };
    let worst = |of: &dyn Fn(f64) -> f64, [from, to]: [f64; 2]| {
        let all = (0..=30).map(|i| of(from * f64::powf(to / from, f64::from(i) / 30.0)));
        all.fold(0.0, f64::max)
    };
    let mut found = vec![(mu * pressed / limit - 1.0).abs(), worst(&loading, [0.01, 1.5])];
    found.extend(cycles.iter().map(|range| worst(&area, *range)));
    found
}

fn places() -> Vec<f64> {
    (0..16).map(|i| (f64::from(i) + 0.5) / 16.0).collect()
}

#[test]
fn errors_against_the_closed_forms() {
    let (curves, ratio, u_n) = (sphere(1e-6, 1e-3), STEEL.mindlin_ratio(), 0.6 * REACH);
    let growth = Growth::of_curves(&curves, ratio, REACH, 2.0 * REACH).unwrap();
    for (n, documented) in DOCUMENTED {
        let found = errors_of(
            &curves,
            growth.springs(n, &places()).unwrap(),
            u_n,
            &[[0.1, 2.0], [0.01, 0.1]],
        );
        let shown: Vec<String> = found.iter().map(|v| format!("{v:.1e}")).collect();
        println!("{n} springs: {shown:?}");
        for (found, documented) in found.iter().zip(documented) {
            assert!((found / documented - 1.0).abs() < 0.05, "{n} {found:e} {documented:e}");
        }
    }
}

/// The second table of the page on the law, of springs about the interference at which the cycles are: as [`DOCUMENTED`], and of cycles at 0.001 to
/// 0.01 and at 1e-4 to 1e-3.
const DOCUMENTED_ABOUT: [(usize, [f64; 6]); 3] = [
    (16, [2.5e-6, 5.9e-3, 6.1e-2, 7.5e-2, 0.10, 0.13]),
    (32, [2.5e-6, 6.9e-4, 1.0e-2, 7.0e-3, 1.0e-2, 1.4e-2]),
    (48, [2.5e-6, 5.5e-4, 3.6e-3, 2.1e-3, 3.2e-3, 3.9e-3]),
];

#[test]
fn springs_about_an_interference_resolve_small_cycles() {
    let (curves, ratio, u_n) = (sphere(1e-6, 1e-3), STEEL.mindlin_ratio(), 0.6 * REACH);
    let growth = Growth::of_curves(&curves, ratio, REACH, 2.0 * REACH).unwrap();
    let cycles = [[0.1, 2.0], [0.01, 0.1], [1e-3, 0.01], [1e-4, 1e-3]];
    let about = |rest: f64, n: usize| {
        let sets = places()
            .into_iter()
            .map(|shift| growth.springs_about(rest, n, shift).unwrap());
        let sets: Vec<Foundation> = sets.collect();
        assert!(sets.iter().all(|set| set.gaps().len() <= n + 2), "{n}");
        sets
    };
    for (n, documented) in DOCUMENTED_ABOUT {
        let found = errors_of(&curves, about(u_n, n), u_n, &cycles);
        let shown: Vec<String> = found.iter().map(|v| format!("{v:.1e}")).collect();
        println!("{n} springs: {shown:?}");
        for (found, documented) in found.iter().zip(documented) {
            assert!((found / documented - 1.0).abs() < 0.06, "{n} {found:e} {documented:e}");
        }
    }
    // Beside that interference they are as good for large cycles, and without one they are those of the whole reach.
    assert!(
        errors_of(&curves, about(1.1 * u_n, 48), u_n, &cycles[..1])
            .iter()
            .all(|error| *error < 4e-3)
    );
    assert_eq!(
        growth.springs_about(0.0, 48, 0.25).unwrap(),
        growth.springs(48, &[0.25]).unwrap()[0]
    );
}

#[test]
fn mindlin_cycle_of_the_reference() {
    let Some(data) = reference("mindlin_hertz.json") else {
        return;
    };
    let cycle = &data["mindlin_cycle"];
    let numbers = |name: &str| -> Vec<f64> {
        let list = cycle["constant_normal"][name].as_array().unwrap();
        list.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let number = |name: &str| cycle[name].as_f64().unwrap();
    assert!(ElasticPair::new(number("E"), number("nu")) == STEEL);
    let (displacement, interference, force) = (numbers("x_disp"), numbers("normal_disp")[0], numbers("x_force"));
    // One contact in place of one unit of area.
    let curves = PointParameters::uniform(sphere(1.0, number("R")), 1);
    let mu = PointParameters::uniform(number("mu"), 1);
    let law = FoundationLaw::of_curves(curves, mu, STEEL.mindlin_ratio(), 256, 1.1 * interference).unwrap();
    let normal = hertz::force(&STEEL, number("R"), interference);
    let limit = number("mu") * normal;

    // Committed where the displacement turns: after first loading and after the way back.
    let mut begin = rest(&law, interference);
    let (mut worst, mut polygons, mut before) = (0.0_f64, [0.0; 2], [0.0; 3]);
    for (i, (&u, &f)) in displacement.iter().zip(&force).enumerate() {
        let found = coulomb(&law, [u, 0.0, interference], &begin);
        assert!(relative(found.traction[2], normal) < 1e-5);
        let t = found.traction[0];
        worst = worst.max((t - f).abs() / limit);
        if i >= 20 {
            polygons[0] += 0.5 * (t + before[1]) * (u - before[0]);
            polygons[1] += 0.5 * (f + before[2]) * (u - before[0]);
        }
        before = [u, t, f];
        if i == 19 || i == 39 {
            begin = found.end;
        }
    }
    println!(
        "60 points within {worst:.1e} of mu N, polygons {:.5e} and {:.5e} J",
        polygons[0], polygons[1]
    );
    // The source's model is within 0.2 % of mu N of the exact curve, which Masing's rule doubles.
    assert!(displacement.len() == 60 && worst < 4.5e-3);
    assert!(relative(polygons[0], polygons[1]) < 4e-3);
    // The area that it calls exact is that of the exact curve's polygon with these vertices.
    assert!(relative(polygons[0], 3.85909e-4) < 1e-3);
}

#[test]
fn small_displacements_and_gross_slip_are_exact() {
    let ratio = STEEL.mindlin_ratio();
    let law = law(
        asperities(TangentialReading::Mindlin),
        PointParameters::uniform(0.5, 1),
        32,
    );
    let u_n = 5e-6;
    let start = rest(&law, u_n);
    let small = coulomb(&law, [1e-15, 0.0, u_n], &start);
    assert_eq!(small.regime, Regime::Stick);
    assert!(relative(small.tangent[0][0], ratio * small.tangent[2][2]) < 1e-14);
    assert!(relative(small.traction[0], small.tangent[0][0] * 1e-15) < 1e-13);
    let gross = coulomb(&law, [3e-3, -4e-3, u_n], &start);
    assert_eq!(gross.regime, Regime::Slip);
    assert!(relative(gross.traction[0], 0.3 * gross.traction[2]) < 1e-14);
    assert!(relative(gross.traction[1], -0.4 * gross.traction[2]) < 1e-14);
    assert!(relative(gross.tangent[0][2], 0.3 * gross.tangent[2][2]) < 1e-14);
    // Partial slip counts as stick: the traction can still grow.
    let found = coulomb(&law, [1e-6, 0.0, u_n], &start);
    assert!(found.regime == Regime::Stick && found.traction[0] < gross.traction[2] * 0.5 && found.tangent[0][0] > 0.0);
}

/// Asperities that slip from their rims inwards are the same contact: in many bins with many annuli.
#[test]
fn a_foundation_is_what_annuli_become() {
    let (curves, mu) = (asperities(TangentialReading::Mindlin), PointParameters::uniform(0.3, 1));
    let population = curves.population();
    let asperity = Asperity::try_new(*curves.material(), population.effective_radius(), None).unwrap();
    let bins = AsperityBins::gauss(asperity, population, 200, REACH, &[0.5])
        .unwrap()
        .remove(0);
    let friction = AsperityFriction::Annuli(HistoryRule::Incremental, 64);
    let annuli = ResolvedLaw::try_new(PointParameters::uniform(bins, 1), mu.clone(), friction, Cone::Circle).unwrap();
    let springs = law(curves, mu, 400);
    let paths = [
        (
            "first loading and back",
            vec![[4e-7, 0.0, 5e-6], [-2e-7, 0.0, 5e-6], [3e-7, 0.0, 5e-6]],
            1e-3,
        ),
        ("around a corner", vec![[3e-7, 0.0, 5e-6], [3e-7, 4e-7, 5e-6]], 1e-3),
        // Annuli keep their places relative to the contact circle, and springs in the body: here the former are wrong.
        (
            "with more pressure",
            vec![[2e-7, 0.0, 4e-6], [3e-7, 0.0, 6e-6], [-1e-7, 0.0, 5e-6]],
            0.1,
        ),
    ];
    for (name, path, tolerance) in paths {
        let (mut at_springs, mut at_annuli) = (rest(&springs, path[0][2]), rest(&annuli, path[0][2]));
        for target in path {
            let [mut on_springs, mut on_annuli] = [[0.0; 3]; 2];
            let from = [at_springs[0], at_springs[1], at_springs[2]];
            for step in 1..=40 {
                let u = [0, 1, 2].map(|q| from[q] + (target[q] - from[q]) * f64::from(step) / 40.0);
                let (a, b) = (coulomb(&springs, u, &at_springs), coulomb(&annuli, u, &at_annuli));
                (at_springs, at_annuli) = (a.end, b.end);
                (on_springs, on_annuli) = (a.traction, b.traction);
            }
            let error = (0..3).map(|q| (on_springs[q] - on_annuli[q]).abs()).fold(0.0, f64::max) / (0.3 * on_annuli[2]);
            println!("{name}: {error:.1e} of gross slip");
            assert!(error < tolerance, "{name}: {on_springs:?} {on_annuli:?}");
        }
    }
}

/// Pressed and moved in proportion by less than friction holds, a contact does not slip and carries its shear over its pressure in that proportion
/// (R. D. Mindlin and H. Deresiewicz, J. Appl. Mech. 20 (1953) 327-344), however fine the steps.
#[test]
fn oblique_loading_does_not_slip() {
    let law = law(
        asperities(TangentialReading::Mindlin),
        PointParameters::uniform(0.3, 1),
        64,
    );
    let along = 0.25 / STEEL.mindlin_ratio();
    for steps in [1, 7, 300] {
        let mut state = rest(&law, 0.0);
        for step in 1..=steps {
            let u_n = 5e-6 * f64::from(step) / f64::from(steps);
            let found = coulomb(&law, [along * u_n, 0.0, u_n], &state);
            let full = evaluate_point(&law, 0, Sticking::Full, [along * u_n, 0.0, u_n], &state);
            assert!(relative(found.traction[0], 0.25 * found.traction[2]) < 1e-12 || found.regime == Regime::Open);
            assert_eq!(found.end, full.end);
            state = found.end;
        }
    }
}

#[test]
fn recontact_starts_where_the_path_closes() {
    // From u_n = -1 um to 3 um: closed over 3/4 of the path.
    let law = law(elastic(), PointParameters::uniform(10.0, 1), 4);
    let k = STEEL.mindlin_ratio() * 2e12;
    let mut begin = rest(&law, -1e-6);
    begin[0] = 1e-3;
    let found = coulomb(&law, [1e-3 + 4e-9, 0.0, 3e-6], &begin);
    // The difference of the displacements has lost three digits.
    assert!(relative(found.traction[0], 0.75 * k * 4e-9) < 1e-8);
    assert!(relative(found.end[3], 3e-9) < 1e-8 && found.end[4] == 0.0);
    // closed = u_n/(u_n - u_n0), so its derivative is -u_n0/(u_n - u_n0)^2.
    assert!(relative(found.tangent[0][2], 1e-6 / 16e-12 * k * 4e-9) < 1e-8);
    assert!(relative(found.tangent[0][0], 0.75 * k) < 1e-8);

    // Opening forgets the stretches.
    let open = coulomb(&law, [1e-3, 2e-3, -0.0], &found.end);
    assert_eq!(
        (open.regime, open.traction, open.tangent),
        (Regime::Open, [0.0; 3], [[0.0; 3]; 3])
    );
    assert!(open.end[3..].iter().all(|&e| e == 0.0));
}

#[test]
fn full_sticking_ignores_the_cone_and_without_friction_nothing_sticks() {
    let curves = || asperities(TangentialReading::Mindlin);
    let law = law(curves(), PointParameters::uniform(0.1, 1), 6);
    let start = rest(&law, 3e-6);
    let here = [2e-7, 1e-7, 3e-6];
    let state = coulomb(&law, here, &start);
    // About a committed state the stuck tangent is diagonal in the plane: the linearised modes depend on it.
    let stuck = evaluate_point(&law, 0, Sticking::Full, here, &state.end);
    assert_eq!(stuck.regime, Regime::Stick);
    for q in 0..2 {
        assert!(relative(stuck.traction[q], state.traction[q]) < 1e-14);
        assert!(relative(stuck.tangent[q][q], STEEL.mindlin_ratio() * stuck.tangent[2][2]) < 1e-14);
        assert_eq!(stuck.tangent[q][1 - q], 0.0);
    }
    let far = evaluate_point(&law, 0, Sticking::Full, [1e-3, 0.0, 3e-6], &start);
    assert!(far.regime == Regime::Stick && far.traction[0] > 100.0 * 0.1 * far.traction[2]);
    let open = evaluate_point(&law, 0, Sticking::Full, [1e-3, 0.0, 0.0], &start);
    assert_eq!((open.regime, open.traction), (Regime::Open, [0.0; 3]));

    let frictionless = super::foundation::law(curves(), PointParameters::uniform(0.0, 1), 6);
    assert!(!frictionless.dissipates());
    for x in [0.0, 1e-6] {
        let found = coulomb(&frictionless, [x, 0.0, 3e-6], &start);
        assert_eq!(
            (found.regime, found.traction[0], found.tangent[0]),
            (Regime::Slip, 0.0, [0.0; 3])
        );
        assert!(found.traction[2] > 0.0 && found.end[3..].iter().all(|&e| e == 0.0));
    }
}

#[test]
fn what_no_springs_are_is_refused_and_the_state_is_described() {
    let of = |ratio, n, reach| {
        let (curves, mu) = (PointParameters::uniform(elastic(), 3), PointParameters::uniform(0.1, 3));
        FoundationLaw::of_curves(curves, mu, ratio, n, reach).map_err(|error| error.to_string())
    };
    for (made, word) in [
        (of(0.0, 4, 1e-6), "tangential_ratio"),
        (of(0.8, 3, 1e-6), "bins"),
        (of(0.8, 4, -1.0), "reach"),
    ] {
        let text = made.unwrap_err();
        assert!(text.contains(word), "{text}");
    }
    let springs = PointParameters::uniform(Foundation::try_new(vec![0.0], vec![1e12], 0.8).unwrap(), 3);
    let law = |curves, mu| {
        let curves = PointParameters::uniform(elastic(), curves);
        FoundationLaw::try_new(springs.clone(), curves, PointParameters::uniform(0.1, mu))
    };
    assert!(law(3, 2).unwrap_err().to_string().contains("2 entries where 3"));
    assert!(law(2, 3).unwrap_err().to_string().contains("2 entries where 3"));
    assert!(Foundation::try_new(vec![], vec![], 0.8).is_err() && Foundation::try_new(vec![0.0], vec![], 0.8).is_err());
    assert!(Foundation::try_new(vec![-1.0], vec![1.0], 0.8).is_err());
    // A stiffness that falls.
    assert!(
        Growth::of_curves(&Softening, 0.8, 1e-6, 2e-6)
            .unwrap_err()
            .to_string()
            .contains("falling")
    );

    let law = of(0.8, 2, 1e-6).unwrap();
    let names: Vec<&str> = law.info().state.iter().map(|quantity| &*quantity.name).collect();
    assert_eq!(names[..5], ["u_x", "u_y", "u_n", "stretch_x_1", "stretch_y_1"]);
    assert!(law.info().state.iter().all(|quantity| quantity.unit == "m"));
    let rough = super::foundation::law(
        asperities(TangentialReading::Mindlin),
        PointParameters::uniform(0.1, 1),
        4,
    );
    let curves = asperities(TangentialReading::Mindlin);
    assert_eq!(rough.contact_area_ratio(0, 5e-6), curves.contact_area_ratio(5e-6));
    assert_eq!(
        rough.yielded_fraction(0, 5e-6, 1e-7),
        curves.yielded_fraction(5e-6, 1e-7)
    );
}

struct Softening;

impl ContactCurves for Softening {
    fn info(&self) -> &'static CurvesInfo {
        CURVES[0]
    }
    fn normal(&self, u_n: f64) -> (f64, f64) {
        (1e9 * u_n.sqrt(), 0.5e9 / u_n.sqrt())
    }
    fn tangential(&self, _: f64) -> [Jet; 2] {
        [Jet::default(); 2]
    }
    fn exponents(&self) -> Exponents {
        Exponents {
            normal: 0.5,
            tangential: [0.0; 2],
        }
    }
}

/// Springs of laws that the properties are tried on.
const SPRINGS: usize = 6;

/// The law on several kinds of curves.
fn laws(mu: f64) -> Vec<Box<dyn TractionLaw>> {
    let mu = || PointParameters::uniform(mu, 1);
    vec![
        Box::new(law(elastic(), mu(), SPRINGS)),
        Box::new(law(sphere(1e-6, 1e-3), mu(), SPRINGS)),
        Box::new(law(asperities(TangentialReading::Mindlin), mu(), SPRINGS)),
    ]
}

/// A state that a jump and any stretches would leave.
fn begin_state(law: &dyn TractionLaw, u: [f64; 3], stretches: &[f64]) -> Vec<f64> {
    let mut before = vec![0.0; law.info().n_state()];
    let n = before.len();
    before[2] = 1.0;
    before[3..].copy_from_slice(&stretches[..n - 3]);
    coulomb(law, u, &before).end
}

fn stretches() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(displacement(), 2 * (SPRINGS + 4))
}

/// Any finite number.
fn finite() -> impl Strategy<Value = f64> {
    use prop::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_answer_is_admissible(
        mu in friction_coefficient(), u in jump(), before in jump(), stretches in stretches(),
    ) {
        for law in laws(mu) {
            let begin = begin_state(&*law, before, &stretches);
            let found = coulomb(&*law, u, &begin);
            let [x, y, n] = found.traction;
            prop_assert!(found.numbers().all(f64::is_finite));
            prop_assert!(n >= 0.0 && found.tangent[2][2] >= 0.0);
            // The last term: squares of the smallest numbers are zero.
            prop_assert!(x.hypot(y) <= mu * n * (1.0 + 1e-13) + 1e-140, "{found:?}");
            if found.regime == Regime::Open {
                prop_assert_eq!((found.traction, found.tangent), ([0.0; 3], [[0.0; 3]; 3]));
                prop_assert!(found.end[3..].iter().all(|&e| e == 0.0));
            } else {
                prop_assert!(n > 0.0 && u[2] > 0.0);
            }
            prop_assert_eq!(&found.end[..3], &u[..]);
            // Pure: the same call gives the same bits.
            prop_assert_eq!(&found, &coulomb(&*law, u, &begin));
        }
    }

    /// Finite input anywhere in the number range gives finite output.
    #[test]
    fn finite_input_gives_finite_output(
        mu in prop_oneof![friction_coefficient(), Just(f64::MAX)], u in prop::array::uniform3(finite()),
        begin in prop::collection::vec(finite(), 3 + 2 * (SPRINGS + 4)),
    ) {
        for law in laws(mu) {
            for sticking in [Sticking::Coulomb, Sticking::Full] {
                let found = evaluate_point(&*law, 0, sticking, u, &begin[..law.info().n_state()]);
                prop_assert!(found.numbers().all(f64::is_finite), "{found:?}");
            }
        }
    }

    #[test]
    fn a_number_that_is_none_is_invalid(
        u in jump(), before in jump(), stretches in stretches(), which in any::<prop::sample::Index>(),
        value in prop::sample::select(vec![f64::NAN, f64::INFINITY]),
    ) {
        for law in laws(0.3) {
            let (mut u, mut begin) = (u, begin_state(&*law, before, &stretches));
            let which = which.index(3 + begin.len());
            if which < 3 { u[which] = value } else { begin[which - 3] = value }
            let found = coulomb(&*law, u, &begin);
            prop_assert_eq!(found.regime, Regime::Invalid);
            let mut numbers = found.traction.iter().chain(found.tangent.iter().flatten()).chain(&found.end);
            prop_assert!(numbers.all(|v| v.is_nan()));
        }
    }

    #[test]
    fn tractions_turn_with_the_axes(
        mu in friction_coefficient(), u in jump(), before in jump(), stretches in stretches(), angle in 0.0..6.3_f64,
    ) {
        for law in laws(mu) {
            let begin = begin_state(&*law, before, &stretches);
            let (s, c) = angle.sin_cos();
            let turn = |v: &[f64]| [c * v[0] - s * v[1], s * v[0] + c * v[1]];
            let mut turned_begin = begin.clone();
            for at in std::iter::once(0).chain((3..begin.len()).step_by(2)) {
                turned_begin[at..at + 2].copy_from_slice(&turn(&begin[at..]));
            }
            let [x, y] = turn(&u);
            let (found, turned) = (coulomb(&*law, u, &begin), coulomb(&*law, [x, y, u[2]], &turned_begin));
            let expected = turn(&found.traction);
            let scale = mu * found.traction[2] + found.tangent[2][2] * 1e-4 * (u[0].hypot(u[1]) + before[0].hypot(before[1]));
            for q in 0..2 {
                prop_assert!((turned.traction[q] - expected[q]).abs() <= 1e-9 * scale);
            }
            prop_assert_eq!(turned.traction[2], found.traction[2]);
        }
    }

    /// Closed collinear cycles at constant interference, committed at the reversals only.
    #[test]
    fn cycles_dissipate_and_obey_masings_rule(
        mu in friction_coefficient(), n in log_uniform(1e-8, 1e-4), reach in 0.01..3.0_f64, angle in 0.0..6.3_f64,
    ) {
        for law in laws(mu) {
            let (s, c) = angle.sin_cos();
            let start = rest(&*law, n);
            let first = evaluate_point(&*law, 0, Sticking::Full, [0.0, 0.0, n], &start);
            let limit = mu * first.traction[2];
            let amplitude = if limit > 0.0 { reach * limit / first.tangent[0][0] } else { 1e-6 };
            let at = |v: f64, begin: &[f64]| coulomb(&*law, [v * amplitude * c, v * amplitude * s, n], begin);
            let along = |v: f64, begin: &[f64]| {
                let t = at(v, begin).traction;
                t[0] * c + t[1] * s
            };
            let up = at(1.0, &start).end;
            for i in 0..=8 {
                let v = f64::from(i) / 8.0;
                let expected = along(1.0, &start) - 2.0 * along(v, &start);
                prop_assert!((along(1.0 - 2.0 * v, &up) - expected).abs() <= 1e-12 * limit);
            }
        }
    }

    /// Along any path, committed at every step, the tangential work done on a point that was at rest is never negative, also where it is pressed
    /// together, lifted and opened on the way.
    #[test]
    fn work_is_never_given_back(
        mu in friction_coefficient(), n in log_uniform(1e-8, 1e-4),
        path in prop::collection::vec([-3.0..3.0_f64, -3.0..3.0, -0.5..2.0], 2..30),
    ) {
        for law in laws(mu) {
            let mut state = rest(&*law, n);
            let first = evaluate_point(&*law, 0, Sticking::Full, [0.0, 0.0, n], &state);
            let limit = mu * first.traction[2];
            let scale = if limit > 0.0 { limit / first.tangent[0][0] } else { 1e-6 };
            let mut work = 0.0;
            for vertex in &path {
                let u = [vertex[0] * scale, vertex[1] * scale, vertex[2] * n];
                let found = coulomb(&*law, u, &state);
                work += found.traction[0] * (u[0] - state[0]) + found.traction[1] * (u[1] - state[1]);
                state = found.end;
                prop_assert!(work >= -1e-12 * limit * scale, "{work:e}");
            }
        }
    }

    /// A point that opens and closes again forgets what it carried.
    #[test]
    fn reopening_forgets(
        mu in friction_coefficient(), u in jump(), before in jump(), stretches in stretches(), gap in interference(),
    ) {
        let gap = -gap.abs();
        for law in laws(mu) {
            let begin = begin_state(&*law, before, &stretches);
            let opened = coulomb(&*law, [1e-6, 0.0, gap], &begin).end;
            let mut fresh = rest(&*law, gap);
            fresh[0] = 1e-6;
            prop_assert_eq!(coulomb(&*law, u, &opened), coulomb(&*law, u, &fresh));
        }
    }

    /// The tangent about a state, where no spring begins or ceases to slip within the steps.
    #[test]
    fn the_tangent_is_the_derivative(
        mu in log_uniform(0.01, 3.0), n in closed_interference(), at in [-2.0..2.0_f64, -2.0..2.0], before in [-1.0..1.0_f64, -1.0..1.0],
        opens in any::<bool>(),
    ) {
        for law in laws(mu) {
            let mut begin = rest(&*law, if opens { -0.5 * n } else { n });
            let first = evaluate_point(&*law, 0, Sticking::Full, [0.0, 0.0, n], &rest(&*law, n));
            if first.regime == Regime::Open {
                continue;
            }
            let scale = mu * first.traction[2] / first.tangent[0][0];
            if !opens {
                begin = coulomb(&*law, [before[0] * scale, before[1] * scale, n], &begin).end;
            }
            let u = [at[0] * scale, at[1] * scale, n];
            let here = coulomb(&*law, u, &begin);
            let stuck = |u: [f64; 3]| {
                let (full, found) = (evaluate_point(&*law, 0, Sticking::Full, u, &begin).end, coulomb(&*law, u, &begin).end);
                (3..full.len()).map(|c| full[c] == found[c]).collect::<Vec<bool>>()
            };
            for k in 0..3 {
                let step = 1e-5 * if k < 2 { scale } else { n };
                let moved = [-2.0, -1.0, 1.0, 2.0].map(|steps| {
                    let mut moved = u;
                    moved[k] += steps * step;
                    moved
                });
                let closed = |u: [f64; 3]| coulomb(&*law, u, &begin).tangent[2][2];
                if moved.iter().any(|&u| stuck(u) != stuck(moved[0]) || closed(u) != here.tangent[2][2]) {
                    continue;
                }
                let t = moved.map(|u| coulomb(&*law, u, &begin).traction);
                for i in 0..3 {
                    let width = [moved[2][k] - moved[1][k], moved[3][k] - moved[0][k]];
                    let (near, far) = ((t[2][i] - t[1][i]) / width[0], (t[3][i] - t[0][i]) / width[1]);
                    let difference = (4.0 * near - far) / 3.0;
                    let size = here.tangent[i][k].abs().max(first.tangent[2][2] * if k == 2 && i < 2 { mu } else { 1.0 });
                    prop_assert!((difference - here.tangent[i][k]).abs() <= 1e-6 * size, "{i} {k} {difference:e} {here:?}");
                }
            }
        }
    }
}

#[test]
fn a_path_followed_at_once_is_that_of_its_steps() {
    use crate::law::step_by_step;
    // Eleven points: eight together and three alone.
    const N: usize = 11;
    const STEPS: usize = 100;
    let curves = PointParameters::uniform(sphere(1e-8, 1e-4), N);
    // One of them without friction.
    let mu = PointParameters::per_point((0..N).map(|i| if i == 3 { 0.0 } else { 0.3 }).collect());
    let law = FoundationLaw::of_curves(curves, mu, STEEL.mindlin_ratio(), 24, REACH).unwrap();
    let n_state = law.info().n_state();
    // From motions that let nothing slip to some that open and reclose every point, and one whose squares overflow.
    for (size, swing) in [
        (1e-12, 0.0),
        (1e-9, 1e-10),
        (1e-8, 2e-7),
        (1e-6, 2e-6),
        (1e-6, 5e-5),
        (1e160, 0.0),
    ] {
        let path: Vec<f64> = (0..STEPS)
            .flat_map(|step| {
                let phase = 0.21 * step as f64;
                let of = move |q: usize, i: usize| match q {
                    0 => size * (phase + i as f64).sin(),
                    1 => 0.3 * size * (2.0 * phase + 0.1 * i as f64).cos(),
                    _ => 1e-6 + 1e-7 * i as f64 + swing * (1.3 * phase).sin(),
                };
                (0..3).flat_map(move |q| (0..N).map(move |i| of(q, i)))
            })
            .collect();
        let mut states = [0, 1].map(|_| {
            let mut state = vec![0.0; n_state * N];
            state[2 * N..3 * N].fill(1e-6);
            state
        });
        let mut tractions = [0, 1].map(|_| vec![0.0; path.len()]);
        let mut room = vec![0.0; n_state * N];
        step_by_step(
            &law,
            0..N,
            Sticking::Coulomb,
            &path,
            &mut states[0],
            &mut room,
            &mut tractions[0],
        );
        law.follow(
            0..N,
            Sticking::Coulomb,
            &path,
            &mut states[1],
            &mut room,
            &mut tractions[1],
        );
        let largest = |values: &[f64]| values.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let apart = |of: &[Vec<f64>; 2]| {
            let differences: Vec<f64> = of[0].iter().zip(&of[1]).map(|(a, b)| a - b).collect();
            largest(&differences) / largest(&of[0])
        };
        let found = [apart(&tractions), apart(&states)];
        assert!(
            found.iter().all(|error| *error < 1e-13),
            "{size:e} {swing:e}: {found:?}"
        );
    }
}
