//! Cases of the Brake-Reuss beam that learn from others, beside the same cases with the whole joint.
#![expect(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "measurements")]

use analyses::cases::{CaseMode, CasePoint, CaseStructure, ErrorBounds, as_case};
use analyses::hyper_reduced::{Training, TrainingCase};
use brake_reuss_beam::BrakeReussBenchmark;
use joint_model::Benchmark;
use joints::Options;
use joints::progress::Silent;
use scenes::Scene;
use serde_json::{Value, json};
use std::time::Instant;

static BENCHMARKS: [&dyn Benchmark; 1] = [&BrakeReussBenchmark];

/// What the results that were not learned from must keep to.
const GOAL: ErrorBounds = ErrorBounds {
    frequency: 5e-4,
    damping: 1e-2,
};

/// Anything goes.
const ALL: ErrorBounds = ErrorBounds {
    frequency: f64::INFINITY,
    damping: f64::INFINITY,
};

/// Friction coefficient, bolt load (N) and, of scenes with the measured gap, the factor of the gap.
type Place = (f64, f64, f64);

/// The beam with these loops.
fn scene(refinement: &str, gap: &str, friction: &str, loops: &Value, (mu, load, factor): Place) -> Scene {
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": refinement },
        "interfaces": {
            "mu": mu,
            "gap": gap,
            "scale": if gap == "flat" { json!({}) } else { json!({ "gap": factor }) },
            "law": { "friction": friction },
            "points_per_direction": 2,
        },
        "bolts": { "load": load },
        "analyses": { "backbone": loops },
    });
    as_case(&Scene::from_value(scene, "test", "test", &BENCHMARKS).unwrap())
}

/// Cases on one structure.
struct Site<'a> {
    structure: &'a CaseStructure,
    scene: &'a dyn Fn(Place) -> Scene,
}

fn structure_of(scene: &Scene) -> CaseStructure {
    CaseStructure::try_new(scene, &Options::default(), &Silent).unwrap()
}

impl Site<'_> {
    fn training_case(&self, place: Place) -> (Vec<CaseMode>, TrainingCase) {
        let case = (self.scene)(place);
        let interface = self.structure.interface(&case, None).unwrap();
        self.structure.training_case(&case, &interface, &Silent).unwrap()
    }

    fn train(&self, places: &[Place]) -> Training {
        let training_cases = places.iter().map(|place| self.training_case(*place).1).collect();
        let case = (self.scene)(places[0]);
        let interface = self.structure.interface(&case, None).unwrap();
        self.structure.train(&case, &interface, training_cases).unwrap()
    }

    fn whole(&self, place: Place) -> Vec<CaseMode> {
        let case = (self.scene)(place);
        let interface = self.structure.interface(&case, None).unwrap();
        self.structure.backbones(&case, &interface, &Silent).unwrap()
    }

    fn by_few(&self, training: &Training, borne: ErrorBounds, place: Place) -> Vec<CaseMode> {
        let case = (self.scene)(place);
        let interface = self.structure.interface(&case, None).unwrap();
        self.structure
            .backbones_by(training, borne, &case, &interface, &Silent)
            .unwrap()
    }
}

fn points(modes: &[CaseMode]) -> impl Iterator<Item = CasePoint> {
    modes
        .iter()
        .flat_map(|mode| &mode.amplitudes)
        .map(|point| *point.as_ref().unwrap())
}

/// Errors of frequency and, where both have it, damping ratio.
fn errors(few: &CasePoint, whole: &CasePoint) -> (f64, Option<f64>) {
    let (few, whole) = (few.point, whole.point);
    let damping = few.damping_ratio.zip(whole.damping_ratio);
    (
        (few.frequency_hz / whole.frequency_hz - 1.0).abs(),
        damping.map(|(few, whole)| (few / whole - 1.0).abs()),
    )
}

#[test]
fn cases_that_learn_keep_to_the_errors_that_are_borne_or_are_those_of_the_whole_joint() {
    let loops = json!({ "amplitudes": 4, "amplitude_from": 3e-5, "amplitude_to": 1e-3, "vertices_per_quarter": 3 });
    let of = |place| scene("quick", "flat", "lumped", &loops, place);
    let structure = structure_of(&of((0.2, 12e3, 1.0)));
    let site = Site {
        structure: &structure,
        scene: &of,
    };
    let corners = [
        (0.1, 8e3),
        (0.4, 8e3),
        (0.1, 16e3),
        (0.4, 16e3),
        (0.2, 12e3),
        (0.2, 8e3),
        (0.2, 16e3),
    ];
    let corners = corners.map(|(mu, load)| (mu, load, 1.0));
    // A case that teaches has the results of any case.
    assert_eq!(site.training_case(corners[4]).0, site.whole(corners[4]));
    let training = site.train(&corners);
    let (mode, sizes) = training.sizes().next().unwrap();
    let [coordinates, few, all] = sizes.unwrap();
    assert_eq!((mode, all), (1, 592));
    assert!(coordinates < 60 && few < all / 3, "{coordinates} {few} {all}");
    let (mut found_with_few, mut checked) = (0, 0);
    for place in [(0.15, 10e3, 1.0), (0.3, 13e3, 1.0)] {
        let (whole, few) = (site.whole(place), site.by_few(&training, GOAL, place));
        assert_eq!(whole[0].linear_frequency_hz, few[0].linear_frequency_hz);
        for (few, whole) in points(&few).zip(points(&whole)) {
            checked += 1;
            let Some(estimate) = few.estimate else {
                assert_eq!(few, whole);
                continue;
            };
            found_with_few += 1;
            assert!(estimate.is_within(GOAL.frequency, GOAL.damping));
            let (frequency, damping) = errors(&few, &whole);
            assert!(
                frequency < GOAL.frequency && damping.is_none_or(|own| own < GOAL.damping),
                "{few:?} {whole:?}"
            );
            assert_eq!(few.point.damping_ratio.is_some(), whole.point.damping_ratio.is_some());
            let seen = few.point.first_harmonic.response_motion / whole.point.first_harmonic.response_motion - 1.0;
            assert!(seen.abs() < 1e-3, "{seen}");
        }
        // Nothing is borne: all are those of the whole joint, to the last bit.
        let none = ErrorBounds {
            frequency: 1e-9,
            damping: 1e-9,
        };
        assert_eq!(site.by_few(&training, none, place), whole);
    }
    assert!(2 * found_with_few > checked, "{found_with_few} of {checked}");
}

#[test]
fn a_case_unlike_those_learned_from_is_told_by_its_estimates() {
    let loops = json!({ "amplitudes": 3, "amplitude_from": 1e-4, "amplitude_to": 1e-3, "vertices_per_quarter": 3 });
    // The factor of the gap opens half of the interface.
    let of = |place| scene("quick", "measured", "lumped", &loops, place);
    let structure = structure_of(&of((0.2, 12e3, 1.0)));
    let site = Site {
        structure: &structure,
        scene: &of,
    };
    let training = site.train(&[(0.2, 12e3, 0.0), (0.3, 12e3, 0.0), (0.2, 15e3, 0.0)]);
    let other = (0.2, 8e3, 1.5);
    let (whole, few) = (site.whole(other), site.by_few(&training, ALL, other));
    let mut refused = 0;
    for (few, whole) in points(&few).zip(points(&whole)) {
        let Some(estimate) = few.estimate else { continue };
        let (frequency, damping) = errors(&few, &whole);
        let is_off = frequency > GOAL.frequency || damping.is_some_and(|own| own > GOAL.damping);
        println!("errors {frequency:.1e} {damping:?}, {estimate:?}");
        if is_off {
            assert!(
                !estimate.is_within(GOAL.frequency, GOAL.damping),
                "{estimate:?} {frequency} {damping:?}"
            );
            refused += 1;
        }
    }
    assert!(refused > 0, "the case is not unlike enough");
    // So the goal is kept.
    for (few, whole) in points(&site.by_few(&training, GOAL, other)).zip(points(&whole)) {
        let (frequency, damping) = errors(&few, &whole);
        assert!(frequency <= GOAL.frequency && damping.is_none_or(|own| own <= GOAL.damping));
    }
}

#[test]
fn another_interface_than_that_learned_from_is_refused() {
    let loops = json!({ "amplitudes": 2, "amplitude_from": 3e-4, "amplitude_to": 6e-4, "vertices_per_quarter": 2 });
    let of = |place| scene("quick", "flat", "lumped", &loops, place);
    let structure = structure_of(&of((0.2, 12e3, 1.0)));
    let site = Site {
        structure: &structure,
        scene: &of,
    };
    let training = site.train(&[(0.2, 12e3, 1.0), (0.3, 12e3, 1.0)]);
    let mut case = of((0.25, 12e3, 1.0));
    case.analyses.modes.followed = vec![1, 2];
    let interface = site.structure.interface(&case, None).unwrap();
    let found = site.structure.backbones_by(&training, ALL, &case, &interface, &Silent);
    let message = found.unwrap_err().to_string();
    assert!(message.contains("mode 2 was not learned"), "{message}");
    let mut case = of((0.25, 12e3, 1.0));
    case.interfaces.points_per_direction = 3;
    let interface = site.structure.interface(&case, None).unwrap();
    let found = site.structure.backbones_by(&training, ALL, &case, &interface, &Silent);
    let message = found.unwrap_err().to_string();
    assert!(
        message.contains("the interface that was trained on") && message.contains("592"),
        "{message}"
    );
}

/// A measurement: cases that were learned from, and cases beside them.
struct Measured {
    title: &'static str,
    refinement: &'static str,
    gap: &'static str,
    friction: &'static str,
    mu: [f64; 3],
    load: [f64; 3],
    factors: &'static [f64],
    held_out: &'static [Place],
}

/// Friction and bolt load within what was learned.
const BESIDE: [Place; 9] = [
    (0.12, 9.5e3, 1.0),
    (0.25, 13e3, 1.0),
    (0.17, 15e3, 1.0),
    (0.33, 11e3, 1.0),
    (0.2, 11e3, 1.0),
    (0.14, 10e3, 1.0),
    (0.3, 14e3, 1.0),
    (0.15, 15e3, 1.0),
    (0.35, 9e3, 1.0),
];

/// Friction, bolt load and gap.
const OF_GAP: [Place; 10] = [
    (0.09, 7e3, 0.6),
    (0.25, 15e3, 1.1),
    (0.4, 5e3, 0.9),
    (0.06, 15e3, 0.1),
    (0.17, 9e3, 0.5),
    (0.1, 12e3, 1.0),
    (0.3, 6e3, 0.4),
    (0.5, 14e3, 1.3),
    (0.07, 5e3, 0.2),
    (0.2, 10e3, 1.0),
];

fn measure(of: &Measured) {
    let loops = json!({ "amplitudes": 8, "vertices_per_quarter": 4 });
    let make = |place| scene(of.refinement, of.gap, of.friction, &loops, place);
    let structure = structure_of(&make(of.held_out[0]));
    let site = Site {
        structure: &structure,
        scene: &make,
    };
    // What comes before the loops: one that sticks takes next to nothing.
    let none = json!({ "amplitudes": 1, "amplitude_from": 1e-7, "amplitude_to": 2e-7, "vertices_per_quarter": 4 });
    let no_loops = |place| scene(of.refinement, of.gap, of.friction, &none, place);
    let before_loops = Site {
        structure: &structure,
        scene: &no_loops,
    };
    let places: Vec<Place> = (of.factors.iter())
        .flat_map(|factor| of.load.map(|load| of.mu.map(|mu| (mu, load, *factor))))
        .flatten()
        .collect();
    let began = Instant::now();
    let training = site.train(&places);
    let to_train = began.elapsed().as_secs_f64();
    let sizes = training.sizes().map(|(_, sizes)| sizes.unwrap()).collect::<Vec<_>>();
    let (mut worst, mut kept, mut too_small, mut of_damping) = ([0.0_f64; 4], 0, 0, 0);
    let (mut all, mut largest) = (0, 0.0_f64);
    let (mut seconds, mut times) = ([0.0; 4], 0);
    for place in of.held_out {
        let clock = |times: &mut f64, run: &dyn Fn() -> Vec<CaseMode>| {
            let began = Instant::now();
            let found = run();
            *times += began.elapsed().as_secs_f64();
            found
        };
        let whole = clock(&mut seconds[0], &|| site.whole(*place));
        let few = clock(&mut seconds[1], &|| site.by_few(&training, ALL, *place));
        clock(&mut seconds[2], &|| site.by_few(&training, GOAL, *place));
        clock(&mut seconds[3], &|| before_loops.whole(*place));
        times += 1;
        for (few, whole) in points(&few).zip(points(&whole)) {
            all += 1;
            let Some(estimate) = few.estimate else { continue };
            let (frequency, damping) = errors(&few, &whole);
            let is_kept = estimate.is_within(GOAL.frequency, GOAL.damping);
            kept += usize::from(is_kept);
            of_damping += usize::from(damping.is_some());
            let own = [frequency, damping.unwrap_or(0.0)];
            let first = if is_kept { 0 } else { 2 };
            for (worst, own) in worst[first..first + 2].iter_mut().zip(own) {
                *worst = worst.max(own);
            }
            let ratio = (frequency / estimate.frequency)
                .max(damping.map_or(0.0, |own| own / estimate.damping.unwrap_or(f64::MIN_POSITIVE)));
            too_small += usize::from(ratio > 1.0);
            largest = largest.max(ratio);
        }
    }
    println!(
        "| {} | {} | {sizes:?} | {all}, {of_damping} | {kept} | {:.1e}, {:.1e} | {:.1e}, {:.1e} | {too_small}, {largest:.2} | {to_train:.1} s | {:.3}, {:.3}, {:.3}, {:.3} s |",
        of.title,
        places.len(),
        worst[0],
        worst[1],
        worst[2],
        worst[3],
        seconds[3] / f64::from(times),
        seconds[0] / f64::from(times),
        seconds[1] / f64::from(times),
        seconds[2] / f64::from(times),
    );
}

#[test]
#[ignore = "takes minutes; a measurement"]
fn cases_held_out_beside_the_whole_joint() {
    println!(
        "| scene | cases learned from | coordinates beside the mode, points, of | held out, with damping | within the goal by estimate | their largest errors | those \
         of the others | estimates too small, largest ratio | to train | per case: before the loops, whole, few alone, with the goal |"
    );
    let small = ([0.1, 0.2, 0.4], [8e3, 12e3, 16e3]);
    let wide = ([0.05, 0.17, 0.6], [4e3, 9e3, 16e3]);
    let plain = |title, refinement, friction| Measured {
        title,
        refinement,
        gap: "flat",
        friction,
        mu: small.0,
        load: small.1,
        factors: &[1.0],
        held_out: &BESIDE,
    };
    for of in [
        plain("148 elements, flat", "quick", "lumped"),
        Measured {
            mu: wide.0,
            load: wide.1,
            gap: "measured",
            factors: &[0.0, 0.75, 1.5],
            held_out: &OF_GAP,
            ..plain("148 elements, gap 0 to 1.5", "quick", "lumped")
        },
        plain("588 elements, flat", "default", "lumped"),
        plain(
            "588 elements, flat, friction of single asperities",
            "default",
            "resolved",
        ),
        plain("1196 elements, flat", "fine", "lumped"),
    ] {
        measure(&of);
    }
}
