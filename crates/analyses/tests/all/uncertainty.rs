//! Bands from uncertain inputs, on a mass with a spring and a slider, whose backbone is known.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common;

use crate::common::points::{folder, read, scene, set, write};
use crate::common::{fixture, lap};
use analyses::uncertainty::{Spread, Uncertainty};
use analyses::{Error, Run, run_samples};
use faer::Mat;
use joints::Options;
use joints::progress::{Progress, Silent, Stage};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use scenes::Scene;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Mass (kg) and stiffness of its spring (N/m).
const MASS: f64 = 2.0;
const SPRING: f64 = 4e4;
/// The slider: stiffness (N/m), friction coefficient, preload (N).
const STIFFNESS: f64 = 5e4;
const MU: f64 = 0.2;
const PRELOAD: f64 = 50.0;
pub(crate) const MU_PATH: &str = "interfaces.surface.parameters.sets.0.mu";
const STIFFNESS_PATH: &str = "interfaces.surface.parameters.sets.0.curves.elastic.tangential_stiffness.0";

/// Amplitude at which the slider begins to slip (m).
pub(crate) fn onset() -> f64 {
    MU * PRELOAD / STIFFNESS
}

/// The mass on its spring with the slider.
pub(crate) fn slider(test: &str, uncertain: &Value) -> Value {
    let path = folder(test).join("slider.npz");
    let of = |value: f64| Mat::from_fn(1, 1, |_, _| value);
    write(&path, &of(SPRING), &of(MASS), &[(7, 1)]);
    let mut given = scene(
        &path,
        &[7],
        &[set([STIFFNESS, STIFFNESS, 2e6], MU, PRELOAD)],
        &json!([[7, 1, 1.0]]),
    );
    let onset = onset();
    given["analyses"] = json!({
        "modes": { "number": 1 },
        "backbone": {
            "amplitudes": 5, "vertices_per_quarter": 64, "tolerance": 1e-12,
            "amplitude_from": 0.5 * onset, "amplitude_to": 8.0 * onset,
        },
    });
    given["uncertain"] = uncertain.clone();
    given
}

/// Frequency (Hz) and damping ratio of a slider's mass at a displacement: secant stiffness, and area of the parallelogram.
pub(crate) fn closed_form(stiffness: f64, mu: f64, x: f64) -> [f64; 2] {
    let limit = mu * PRELOAD;
    let slip = limit / stiffness;
    let (secant, area) = match x > slip {
        true => (SPRING + limit / x, 4.0 * limit * (x - slip)),
        false => (SPRING + stiffness, 0.0),
    };
    [(secant / MASS).sqrt() / TAU, area / (2.0 * PI * secant * x * x)]
}

fn go(given: &Value, samples: usize) -> (Run, Uncertainty) {
    run_samples(&read(given).unwrap(), samples, None, &Options::default(), &Silent).unwrap()
}

fn close(found: Option<f64>, expected: f64, within: f64, what: &str) {
    let found = found.unwrap();
    assert!(
        (found - expected).abs() <= within,
        "{what}: {found} instead of {expected} within {within}"
    );
}

#[test]
fn bands_of_one_input_are_the_backbones_of_its_quantiles() {
    let distribution = json!({ "normal": { "sd": 0.02 }, "between": [0.1, 0.3] });
    for method in ["latin-hypercube", "sobol"] {
        let mut given = slider(
            method,
            &json!({ "parameters": { MU_PATH: distribution }, "method": method }),
        );
        // A corner of the loop falls on a vertex: round-off decides on which side of it the polygon is differentiated.
        given["analyses"]["backbone"]["vertices_per_quarter"] = json!(256);
        let (run, found) = go(&given, 256);
        assert_eq!((found.samples, found.failed, found.runs), (256, 0, 256));
        let bands = &found.modes[0].bands;
        // The linearised mode first, and then the amplitudes of the scene's own backbone.
        assert_eq!(bands.len(), 1 + run.amplitudes().len());
        assert!(bands[0].frequency_hz.sd.unwrap() < 1e-9 && bands[0].damping_ratio.nominal.is_none());
        let z = 1.644_853_626_951_472_7;
        for band in &bands[3..] {
            let x = band.response_displacement;
            assert!((x - band.modal_amplitude / MASS.sqrt()).abs() < 1e-12 * x);
            assert!(x > 0.3 * PRELOAD / STIFFNESS, "all of them slip");
            let at = [MU - 0.02 * z, MU, MU + 0.02 * z].map(|mu| closed_form(STIFFNESS, mu, x));
            for (which, spread) in [&band.frequency_hz, &band.damping_ratio].into_iter().enumerate() {
                let mut expected = at.map(|values| values[which]);
                expected.sort_by(f64::total_cmp);
                let width = expected[2] - expected[0];
                for (quantile, value) in spread.quantiles.iter().zip(expected) {
                    // Interpolation between amplitudes that are a factor of two apart takes part in it.
                    close(*quantile, value, 0.05 * width + 1e-3 * value, "quantile");
                }
                assert_eq!(spread.samples, 256);
                close(spread.nominal, at[1][which], 1e-3 * at[1][which], "nominal");
                // Linear propagation, with the derivative of the closed form.
                let slope = (closed_form(STIFFNESS, 1.0001 * MU, x)[which] - at[1][which]) / (1e-4 * MU);
                let linear = spread.linear.unwrap();
                close(Some(linear.sd), slope.abs() * 0.02, 0.02 * slope.abs() * 0.02, "linear");
                assert_eq!(spread.shares[0].share, 1.0);
                // Samples spread as the line says, but for its curvature.
                close(spread.sd, linear.sd, 0.05 * linear.sd, "sd");
                let half = spread.of_first_half[2].unwrap() - spread.quantiles[2].unwrap();
                let error = spread.half_widths[1].unwrap();
                assert!(error > 0.0 && half.abs() < 3.0 * error);
            }
        }
    }
}

#[test]
fn nine_of_ten_truths_lie_within_bands_of_ninety_percent() {
    let given = slider(
        "coverage",
        &json!({ "parameters": {
        MU_PATH: { "lognormal": { "cov": 0.15 } },
        STIFFNESS_PATH: { "uniform": [0.8 * STIFFNESS, 1.25 * STIFFNESS] },
    } }),
    );
    let (_, found) = go(&given, 300);
    let mut random = Pcg64::seed_from_u64(20);
    let truths: Vec<[f64; 2]> = (0..1000)
        .map(|_| {
            // By the sum of twelve uniform numbers, so that nothing is shared with what is tested.
            let normal = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let spread = (1.0 + 0.15_f64.powi(2)).ln().sqrt();
            [
                STIFFNESS * (0.8 + 0.45 * random.random::<f64>()),
                MU * (spread * normal).exp(),
            ]
        })
        .collect();
    for band in &found.modes[0].bands[1..] {
        let inside = |spread: &Spread, which: usize| {
            let [low, _, high] = spread.quantiles;
            let within = |[stiffness, mu]: &&[f64; 2]| {
                let value = closed_form(*stiffness, *mu, band.response_displacement)[which];
                low.unwrap_or(0.0) <= value && value <= high.unwrap_or(0.0)
            };
            truths.iter().filter(within).count()
        };
        let frequency = inside(&band.frequency_hz, 0);
        assert!(
            (870..=930).contains(&frequency),
            "{frequency} at {}",
            band.response_displacement
        );
        // Where some samples slip and others do not, the band of damping begins at zero.
        let damping = inside(&band.damping_ratio, 1);
        assert!(damping >= 870, "{damping} at {}", band.response_displacement);
    }
}

/// Interrupts after some finished loops.
struct Impatient(AtomicUsize);

impl Progress for Impatient {
    fn fraction(&self, stage: Stage, _: f64) {
        if stage == Stage::Ensemble {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn interrupted(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 60
    }
}

#[test]
fn neither_threads_nor_an_interruption_change_a_bit() {
    let given = slider(
        "bits",
        &json!({ "parameters": {
        MU_PATH: { "normal": { "cov": 0.1 } },
        STIFFNESS_PATH: { "triangular": [4e4, 5e4, 7e4] },
    }, "correlations": [[MU_PATH, STIFFNESS_PATH, -0.4]], "seed": 7 }),
    );
    let scene = read(&given).unwrap();
    let on = |threads: usize, options: &Options, progress: &dyn Progress| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run_samples(&scene, 30, None, options, progress))
    };
    let (_, one) = on(1, &Options::default(), &Silent).unwrap();
    let (_, three) = on(3, &Options::default(), &Silent).unwrap();
    assert_eq!(one, three);
    let cache = Options::cached(folder("bits").join("cache"));
    let stopped = on(2, &cache, &Impatient(AtomicUsize::new(0)));
    assert!(matches!(stopped, Err(Error::Solver(cqsma_solver::Error::Interrupted))));
    let counting = Impatient(AtomicUsize::new(0));
    let finishes = Finishes(&counting);
    let (run, resumed) = on(2, &cache, &finishes).unwrap();
    assert_eq!(one, resumed);
    let all = 30 * 7;
    let again = counting.0.load(Ordering::Relaxed);
    assert!(
        again > 0 && again < all - 10,
        "{again} of {all} loops were computed again"
    );
    run.checkpoints.remove();
    // Another seed is another table, and a seed that is asked for stands for that of the scene.
    let (_, other) = run_samples(&scene, 30, Some(8), &Options::default(), &Silent).unwrap();
    assert_ne!(one.variants, other.variants);
    assert_eq!((one.seed, other.seed), (7, 8));
}

/// Counts, and never interrupts.
struct Finishes<'a>(&'a Impatient);

impl Progress for Finishes<'_> {
    fn fraction(&self, stage: Stage, done: f64) {
        self.0.fraction(stage, done);
    }
}

#[test]
fn sobols_indices_are_shares_of_the_variance() {
    let given = slider(
        "indices",
        &json!({ "parameters": {
        MU_PATH: { "normal": { "cov": 0.03 } },
        STIFFNESS_PATH: { "normal": { "cov": 0.06 } },
    }, "method": "sobol", "sobol_indices": true }),
    );
    let (_, found) = go(&given, 256);
    assert_eq!(found.runs, 256 * 4);
    let bands = &found.modes[0].bands;
    // Stuck: the stiffness alone matters. Sliding: of the frequency, friction alone.
    for (band, place) in [(&bands[0], 0), (&bands[1], 0), (&bands[5], 1)] {
        let indices = &band.frequency_hz.indices;
        assert_eq!(
            indices.iter().map(|i| i.parameter.path()).collect::<Vec<_>>(),
            [STIFFNESS_PATH, MU_PATH]
        );
        assert!(
            (indices[place].first - 1.0).abs() < 0.03 && (indices[place].total - 1.0).abs() < 0.1,
            "{indices:?}"
        );
        assert!(
            indices[1 - place].first.abs() < 0.03 && indices[1 - place].total < 0.03,
            "{indices:?}"
        );
        assert_eq!(band.frequency_hz.shares[0].parameter, indices[place].parameter);
        assert!(band.frequency_hz.shares[0].share > 0.99);
    }
    // Of the damping both, which for so small deviations add up, by the closed form's slopes.
    let band = &bands[4];
    let at = |stiffness: f64, mu: f64| closed_form(stiffness, mu, band.response_displacement)[1];
    let parts = [
        (at(1.01 * STIFFNESS, MU) - at(STIFFNESS, MU)) * 6.0,
        (at(STIFFNESS, 1.01 * MU) - at(STIFFNESS, MU)) * 3.0,
    ];
    let all = parts[0].powi(2) + parts[1].powi(2);
    for (index, part) in band.damping_ratio.indices.iter().zip(parts) {
        let expected = part * part / all;
        let [low, high] = index.first_interval;
        assert!(
            low < high && (index.first - expected).abs() < 0.15,
            "{index:?} {expected}"
        );
        let linear = band
            .damping_ratio
            .shares
            .iter()
            .find(|s| s.parameter == index.parameter)
            .unwrap();
        assert!((linear.share - expected).abs() < 0.05, "{linear:?} {expected}");
    }
}

#[test]
fn a_sample_that_fails_is_a_row_with_its_reason() {
    let mut given = lap(&fixture("lap.sti"), 1.0, &json!({}));
    given["interfaces"]["surface"]["parameters"]["sets"][0]["gap"] = json!(0.0);
    given["analyses"]["backbone"]["amplitudes"] = json!(2);
    given["uncertain"] = json!({ "parameters": {
        "interfaces.surface.parameters.sets.0.gap": { "uniform": ["0 mm", "120 mm"] },
    } });
    let (_, found) = go(&given, 8);
    let reasons: Vec<&String> = found.variants.iter().filter_map(|v| v.failure.as_ref()).collect();
    assert_eq!((found.variants.len(), found.failed), (8, reasons.len()));
    assert!((2..8).contains(&found.failed), "{}", found.failed);
    for variant in &found.variants {
        let beyond = variant.inputs[0] > 0.0633;
        assert_eq!(variant.failure.is_some(), beyond, "{:?}", variant.inputs);
    }
    assert!(reasons[0].contains("smallest gap"), "{}", reasons[0]);
    assert_eq!(found.modes[0].bands[1].frequency_hz.samples, 8 - found.failed);
}

#[test]
fn inputs_that_change_the_structure_are_reduced_anew() {
    let mut given = json!({
        "units": { "length": "mm", "mass": "t", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": "quick", "element_order": "linear" }, "interfaces": { "gap": "flat", "law": { "friction": "lumped" } },
        "analyses": {},
    });
    given["uncertain"] = json!({ "parameters": {
        "model.material.density": { "uniform": ["7.8 g/cm^3", "7.9 g/cm^3"] },
    }, "law_error": 1 });
    let scene = read(&given).unwrap();
    let (run, found) = run_samples(&scene, 2, None, &Options::default(), &Silent).unwrap();
    assert_eq!(found.inputs[0].unit, "kg/m^3");
    // All masses are in proportion.
    let nominal = run.frequencies[0];
    for variant in &found.variants {
        assert!((7800.0..7900.0).contains(&variant.inputs[0]));
        let expected = nominal * (found.inputs[0].nominal / variant.inputs[0]).sqrt();
        assert!((variant.curves[0].linear_frequency_hz / expected - 1.0).abs() < 1e-6);
    }
    let linear = found.modes[0].bands[0].frequency_hz.linear.unwrap();
    let expected = nominal * 0.5 * found.inputs[0].sd / found.inputs[0].nominal;
    assert!((linear.sd / expected - 1.0).abs() < 1e-3);
}

/// The error of the law is an input of every scene whose law is a sum over asperities, unless the scene says otherwise.
#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_the_error_of_the_law_is_in_the_bands_by_default() {
    let beam = |uncertain: Value| {
        json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
            "model": { "refinement": "quick", "element_order": "linear" },
            "interfaces": { "gap": "flat", "mu": 0.2, "law": { "friction": "lumped" } },
            "analyses": {},
            "uncertain": uncertain,
        })
    };
    let mu = json!({ "interfaces.mu": { "uniform": [0.18, 0.22] } });
    let height = "interfaces.scale.asperity_height";
    let by_default = go(&beam(json!({ "parameters": mu })), 9).1;
    let [of_mu, of_law] = by_default.inputs.as_slice() else {
        panic!("{:?}", by_default.inputs)
    };
    assert_eq!(
        (of_mu.parameter.path(), of_law.parameter.path()),
        ("interfaces.mu", height)
    );
    assert!(of_mu.assumption.is_none() && by_default.left_out.is_none());
    assert!(
        of_law
            .assumption
            .as_ref()
            .unwrap()
            .contains("a factor of 1.5 on the stiffness")
    );
    // The edges of ninety percent of a lognormal distribution.
    close(
        Some(of_law.quantiles[2] / of_law.quantiles[0]),
        (2.0 * 1.644_853_6 * 1.5_f64.ln()).exp(),
        1e-4,
        "edges",
    );
    // The very bands of who writes it out.
    let mut written = mu.clone();
    written[height] = json!({ "lognormal": { "factor": 1.5 } });
    let written = go(&beam(json!({ "parameters": written })), 9).1;
    assert_eq!(written.modes, by_default.modes);
    assert!(written.left_out.is_none() && written.inputs[1].assumption.is_none());
    let spread = |found: &Uncertainty| found.modes[0].bands[0].frequency_hz.sd.unwrap();
    let without = go(&beam(json!({ "parameters": mu, "law_error": 1 })), 9).1;
    assert_eq!(without.inputs.len(), 1);
    assert!(
        without
            .left_out
            .as_ref()
            .unwrap()
            .contains("error of the traction law is not in the bands")
    );
    let smaller = go(&beam(json!({ "parameters": mu, "law_error": 1.1 })), 9).1;
    println!("{} {} {}", spread(&without), spread(&smaller), spread(&by_default));
    assert!(10.0 * spread(&without) < spread(&smaller) && 2.0 * spread(&smaller) < spread(&by_default));
    // Numbers that are given have no such error, and none can be added.
    let of_slider = |more: Value| {
        let mut uncertain = json!({ "parameters": { MU_PATH: { "normal": { "cov": 0.1 } } } });
        uncertain
            .as_object_mut()
            .unwrap()
            .extend(more.as_object().unwrap().clone());
        slider("law-error", &uncertain)
    };
    let found = go(&of_slider(json!({})), 3).1;
    assert!(found.inputs.len() == 1 && found.left_out.is_none());
    let error = read(&of_slider(json!({ "law_error": 1.5 }))).unwrap_err().to_string();
    assert!(
        error.contains("1.5 does nothing") && error.contains("leave it out"),
        "{error}"
    );
}

fn refused(uncertain: &Value) -> String {
    let given = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "uncertain": uncertain,
    });
    read(&given).unwrap_err().to_string()
}

#[test]
fn what_cannot_be_sampled_is_refused_with_a_remedy() {
    let of_mu = |distribution: Value| json!({ "parameters": { "interfaces.mu": distribution } });
    let three = |pairs: Value| {
        let normal = json!({ "normal": { "cov": 0.05 } });
        json!({
            "parameters": { "interfaces.mu": normal, "bolts.load": normal, "interfaces.scale.gap": normal },
            "correlations": pairs,
        })
    };
    for (given, expected) in [
        (json!({ "parameters": {} }), "there are none"),
        (
            of_mu(json!({ "normal": { "mean": 0.1, "sd": 0.05 } })),
            "the distribution reaches -0.13",
        ),
        (
            of_mu(json!({ "normal": { "mean": 0.1, "sd": 0.05 } })),
            "truncate it with \"between\": [LOW, HIGH]",
        ),
        (of_mu(json!({})), "there are 0 distributions"),
        (
            of_mu(json!({ "normal": { "sd": 0.01 }, "uniform": [0.1, 0.2] })),
            "there are 2 distributions",
        ),
        (of_mu(json!({ "normal": {} })), "either sd or cov"),
        (of_mu(json!({ "normal": { "sd": "1 N" } })), "normal.sd"),
        (of_mu(json!({ "uniform": [0.3, 0.1] })), "does not rise"),
        (of_mu(json!({ "lognormal": { "factor": 0.9 } })), "must be above 1"),
        (of_mu(json!({ "tightening": "torque-wrench" })), "the load of a bolt"),
        (
            of_mu(json!({ "uniform": [0.1, 0.2], "alpha_a": 2.0 })),
            "alpha_a belongs to tightening",
        ),
        (
            of_mu(json!({ "normal": { "sd": 0.01 }, "between": [0.8, 0.9] })),
            "no values between",
        ),
        (
            json!({ "parameters": { "friction": { "uniform": [0.1, 0.2] } } }),
            "no number that the physics depends on",
        ),
        (
            json!({ "parameters": { "interfaces.mu": { "uniform": [0.1, 0.2] } }, "confidence": 1.0 }),
            "between 0 and 1",
        ),
        (
            json!({ "parameters": { "interfaces.mu": { "gaussian": {} } } }),
            "unknown field `gaussian`",
        ),
        (
            three(json!([
                ["interfaces.mu", "bolts.load", 0.9],
                ["interfaces.mu", "interfaces.scale.gap", -0.9],
                ["bolts.load", "interfaces.scale.gap", 0.9]
            ])),
            "eigenvalue",
        ),
        (
            three(json!([["interfaces.mu", "interfaces.mu", 0.5]])),
            "correlated with itself",
        ),
        (
            three(json!([["interfaces.mu", "interfaces.scale.asperity_height", 0.5]])),
            "has no distribution",
        ),
        (three(json!([["interfaces.mu", "bolts.load", 1.5]])), "between -1 and 1"),
        (
            json!({ "parameters": { "interfaces.mu": { "uniform": [0.1, 0.2] } }, "law_error": 0.9 }),
            "at least 1",
        ),
        (
            json!({ "parameters": { "interfaces.scale.asperity_height": { "uniform": [0.8, 1.2] } }, "law_error": 1.2 }),
            "a distribution of its own",
        ),
    ] {
        let message = refused(&given);
        assert!(message.contains(expected), "{given}: {message}");
    }
    let mut correlated = three(json!([["interfaces.mu", "bolts.load", 0.5]]));
    correlated["sobol_indices"] = json!(true);
    assert!(refused(&correlated).contains("independent"));
    let plain: Scene = common::beam("plain");
    let error = run_samples(&plain, 10, None, &Options::default(), &Silent).unwrap_err();
    assert!(error.to_string().contains("how well it is known"), "{error}");
}

#[test]
fn values_of_distributions_have_the_units_of_the_scene() {
    let read_in = |units: Value, load: Value, sd: Value| {
        let given = json!({
            "units": units, "structure": { "benchmark": "brake-reuss-beam" },
            "uncertain": { "parameters": {
                "bolts.load": { "normal": { "mean": load, "sd": sd } },
                "interfaces.scale.gap": { "lognormal": { "factor": 1.2 } },
            } },
        });
        read(&given).unwrap().uncertain.unwrap()
    };
    let si = read_in(
        json!({ "length": "m", "mass": "kg", "time": "s" }),
        json!(12e3),
        json!(600.0),
    );
    // Forces in t mm/s^2 are newtons.
    let mm = read_in(
        json!({ "length": "mm", "mass": "t", "time": "s" }),
        json!("12 kN"),
        json!(600.0),
    );
    assert_eq!(si, mm);
    let g = read_in(
        json!({ "length": "m", "mass": "g", "time": "s" }),
        json!(12e6),
        json!("0.6 kN"),
    );
    assert_eq!(si, g);
}

#[test]
fn a_method_of_tightening_is_its_factor_at_two_standard_deviations() {
    let given = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" }, "bolts": { "load": 9000.0 },
        "uncertain": { "parameters": { "bolts.load": { "tightening": "torque-wrench" } } },
    });
    let scene = read(&given).unwrap();
    let [mean, sd] = scene.uncertain.as_ref().unwrap().marginals(&scene).unwrap()[0].moments();
    // alpha_A = 2: 12 kN over 6 kN.
    assert!((mean / 9000.0 - 1.0).abs() < 1e-12 && (sd / 1500.0 - 1.0).abs() < 1e-9);
    let largest = scene.uncertain.unwrap().marginals(&common::beam("x")).unwrap()[0];
    assert!((largest.quantile(0.5) / common::beam("x").bolts.load.si() - 1.0).abs() < 1e-12);
}
