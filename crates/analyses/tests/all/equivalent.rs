//! Elements of one degree of freedom: closed forms against simulations of a cycle, and fits of what is known.

use analyses::equivalent::{BoucWen, Fit, Hysteretic, Iwan, Level, Quality, bouc_wen, iwan};
use proptest::prelude::*;

/// Relative difference.
fn apart(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs().max(f64::MIN_POSITIVE)
}

/// Stiffness and dissipation of the steady cycle between `-u` and `u` of many sliders (displacement and stiffness of each).
fn cycle(sliders: &[(f64, f64)], u: f64) -> [f64; 2] {
    const STEPS: usize = 4000;
    let mut places = vec![0.0; sliders.len()];
    let mut force = |at: f64| -> f64 {
        let each = sliders.iter().zip(&mut places).map(|((most, stiffness), place)| {
            let stretch = (at - *place).clamp(-most, *most);
            *place = at - stretch;
            stiffness * stretch
        });
        each.sum()
    };
    force(u);
    let way = |k: usize| u * (1.0 - 2.0 * k as f64 / STEPS as f64);
    let (mut peak, mut area) = (0.0_f64, 0.0);
    let (mut before, mut at) = (force(u), u);
    for k in (0..=STEPS).chain((0..STEPS).rev()) {
        let (next, now) = (way(k), force(way(k)));
        area += 0.5 * (before + now) * (next - at);
        peak = peak.max(now);
        (before, at) = (now, next);
    }
    [peak / u, area]
}

/// The sliders of an Iwan element: cells of the density with their stiffness at their centre, of which `u` is an edge.
fn sliders(element: &Iwan, u: f64) -> Vec<(f64, f64)> {
    const CELLS: usize = 1500;
    let most = element.largest_displacement();
    let p = element.chi + 1.0;
    let density = element.stiffness / (1.0 + element.beta) * p / most.powf(p);
    let mut edges = vec![0.0];
    for (from, to) in [(0.0, u.min(most)), (u.min(most), most)] {
        let cells = (1..=CELLS).map(|k| (k as f64 / CELLS as f64, from, to));
        // Finer at zero, where the density may have a pole.
        edges.extend(cells.map(|(share, from, to)| {
            from + (to - from)
                * if from == 0.0 {
                    share.powf(1.0 / p.min(1.0))
                } else {
                    share
                }
        }));
        if to == most {
            break;
        }
    }
    let cells = edges.windows(2).filter(|edge| edge[1] > edge[0]).map(|edge| {
        let moment = |power: f64| (edge[1].powf(power) - edge[0].powf(power)) / power;
        (moment(p + 1.0) / moment(p), density * moment(p))
    });
    let lump = element.stiffness * element.beta / (1.0 + element.beta);
    cells.chain([(most, lump), (f64::INFINITY, element.spring)]).collect()
}

/// Stiffness and dissipation of the steady cycle of a Bouc-Wen element, by Runge-Kutta steps from reversal to reversal; the state at the reversals is
/// found by halving.
fn bouc_wen_cycle(element: &BoucWen, u: f64) -> [f64; 2] {
    const STEPS: usize = 2000;
    let limit = element.yield_displacement;
    let slope = |z: f64| 1.0 - (z.max(0.0) / limit).powf(element.n);
    // From no force on: displacement, state and work, in steps that grow, since the slope may have a pole at zero.
    let loading = |way: f64| {
        let (mut z, mut work) = (0.0_f64, 0.0);
        for k in 0..STEPS {
            let [from, to] = [k, k + 1].map(|k| way * (k as f64 / STEPS as f64).powi(3));
            let h = to - from;
            let k1 = slope(z);
            let k2 = slope(z + 0.5 * h * k1);
            let k3 = slope(z + 0.5 * h * k2);
            let k4 = slope(z + h * k3);
            let next = z + h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
            let middle = z + 0.5 * h * k2;
            work += h * (z + 4.0 * middle + next) / 6.0;
            z = next;
        }
        (z, work)
    };
    // The way without force to the reversal is what is left of the whole after the state has fallen to zero.
    let (mut low, mut high) = (0.0, u.min(limit));
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if loading(2.0 * u - middle).0 > middle {
            low = middle
        } else {
            high = middle
        }
    }
    let z = 0.5 * (low + high);
    let (_, work) = loading(2.0 * u - z);
    let hysteretic = (1.0 - element.alpha) * element.stiffness;
    [
        element.alpha * element.stiffness + hysteretic * z / u,
        2.0 * hysteretic * (work - 0.5 * z * z),
    ]
}

/// Levels of an element from one amplitude to another, evenly in the logarithm.
fn levels(element: &impl Hysteretic, [from, to]: [f64; 2]) -> Vec<Level> {
    let amplitudes = (0..20).map(|k| from * (to / from).powf(f64::from(k) / 19.0));
    let level = |amplitude| Level {
        amplitude,
        stiffness: element.stiffness(amplitude),
        dissipation: Some(element.dissipation(amplitude)),
    };
    amplitudes.map(level).collect()
}

fn is_exact<E>(fit: &Fit<E>) {
    assert!(fit.stiffness.largest < 1e-7 && fit.dissipation.largest < 1e-7);
    assert_eq!(fit.quality, Quality::Good);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn an_iwan_element_dissipates_what_its_sliders_do(
        chi in -0.8..2.0_f64, beta in 0.0..3.0_f64, force in 1.0..1e4_f64, stiffness in 1e5..1e9_f64, share in 0.02..3.0_f64,
        spring in 0.0..2.0_f64,
    ) {
        let element = Iwan { slip_force: force, stiffness, chi, beta, spring: spring * stiffness };
        let u = share * element.largest_displacement();
        let [simulated, dissipated] = cycle(&sliders(&element, u), u);
        prop_assert!(apart(element.stiffness(u), simulated) < 1e-6, "{element:?} at {share}: {simulated}");
        prop_assert!(apart(element.dissipation(u), dissipated) < 1e-6, "{element:?} at {share}: {dissipated}");
        let all: f64 = sliders(&element, u).iter().filter(|(most, _)| most.is_finite()).map(|(most, stiffness)| most * stiffness).sum();
        prop_assert!(apart(all, force) < 1e-9);
    }

    #[test]
    fn a_bouc_wen_element_dissipates_what_its_equation_does(
        n in 0.6..4.0_f64, alpha in 0.0..0.5_f64, stiffness in 1e5..1e9_f64, share in 0.05..4.0_f64,
    ) {
        let element = BoucWen { stiffness, alpha, yield_displacement: 1e-5, n };
        let u = share * 1e-5;
        let [simulated, dissipated] = bouc_wen_cycle(&element, u);
        prop_assert!(apart(element.stiffness(u), simulated) < 1e-6, "{element:?} at {share}: {simulated}");
        prop_assert!(apart(element.dissipation(u), dissipated) < 1e-6, "{element:?} at {share}: {dissipated}");
    }

    #[test]
    fn a_known_iwan_element_is_found_again(
        chi in -0.7..1.5_f64, beta in 0.2..3.0_f64, force in 1.0..1e4_f64, stiffness in 1e5..1e9_f64,
    ) {
        // Segalman's element itself, and with a spring beside it.
        for spring in [0.0, 0.5 * stiffness] {
        let known = Iwan { slip_force: force, stiffness, chi, beta, spring };
        let most = known.largest_displacement();
        let fit = iwan(&levels(&known, [0.01 * most, 3.0 * most])).unwrap();
        is_exact(&fit);
        prop_assert!(fit.slips_wholly);
        let found = fit.element;
        prop_assert!((found.spring - spring).abs() < 1e-6 * stiffness);
        for (a, b) in [(found.slip_force, force), (found.stiffness, stiffness), (found.chi + 1.0, chi + 1.0), (found.beta, beta)] {
            prop_assert!(apart(a, b) < 1e-6, "{found:?} for {known:?}");
        }
        }
    }
}

proptest! {
    // Each fit takes a second.
    #![proptest_config(ProptestConfig::with_cases(4))]

    #[test]
    fn a_known_bouc_wen_element_is_found_again(n in 0.6..3.0_f64, alpha in 0.02..0.5_f64, stiffness in 1e5..1e9_f64) {
        let known = BoucWen { stiffness, alpha, yield_displacement: 1e-5, n };
        let fit = bouc_wen(&levels(&known, [1e-7, 1e-4])).unwrap();
        is_exact(&fit);
        let found = fit.element;
        for (a, b) in [(found.stiffness, stiffness), (found.alpha, alpha), (found.yield_displacement, 1e-5), (found.n, n)] {
            prop_assert!(apart(a, b) < 1e-6, "{found:?} for {known:?}");
        }
    }
}

#[test]
fn levels_without_whole_slip_know_three_numbers() {
    let known = Iwan {
        slip_force: 500.0,
        stiffness: 1e7,
        chi: -0.4,
        beta: 1.5,
        spring: 0.0,
    };
    let most = known.largest_displacement();
    let fit = iwan(&levels(&known, [1e-4 * most, 0.5 * most])).unwrap();
    is_exact(&fit);
    assert!(!fit.slips_wholly && fit.element.beta == 0.0);
    assert!(apart(fit.element.stiffness, 1e7) < 1e-6 && (fit.element.chi + 0.4).abs() < 1e-6);
    // Without units: levels in other ones give the element in these.
    let scaled: Vec<Level> = levels(&known, [1e-4 * most, 0.5 * most])
        .into_iter()
        .map(|level| Level {
            amplitude: 1e3 * level.amplitude,
            stiffness: 1e-3 * level.stiffness,
            dissipation: level.dissipation.map(|joules| 1e3 * joules),
        })
        .collect();
    let other = iwan(&scaled).unwrap().element;
    assert!(apart(other.slip_force, fit.element.slip_force) < 1e-6 && apart(other.stiffness, 1e4) < 1e-6);
}

#[test]
fn what_no_element_does_is_a_poor_fit() {
    let known = Iwan {
        slip_force: 500.0,
        stiffness: 1e7,
        chi: -0.4,
        beta: 1.5,
        spring: 0.0,
    };
    let mut found = levels(&known, [1e-7, 1e-5]);
    for level in found.iter_mut().step_by(2) {
        level.dissipation = level.dissipation.map(|joules| 2.0 * joules);
    }
    let fit = iwan(&found).unwrap();
    assert!(fit.quality == Quality::Poor && fit.dissipation.largest > 0.1, "{fit:?}");
    assert_eq!(bouc_wen(&found).unwrap().quality, Quality::Poor);
    // What is below its floor says nothing of dissipation, and is no error.
    found.iter_mut().step_by(2).for_each(|level| level.dissipation = None);
    let fit = iwan(&found).unwrap();
    assert_eq!((fit.levels, fit.levels_with_dissipation), (20, 10));
    is_exact(&fit);

    found.truncate(5);
    assert!(iwan(&found).unwrap_err().to_string().contains("an element needs three"));
    let mut negative = levels(&known, [1e-7, 1e-5]);
    negative[3].dissipation = Some(-1.0);
    assert!(
        bouc_wen(&negative)
            .unwrap_err()
            .to_string()
            .contains("must be positive and finite")
    );
}
