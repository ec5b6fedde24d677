//! The quadrature-point kernel, law by law.

use anyhow::Result;
use contact_laws::workload::{Batch, LoadStoreFloor, asperity_sums, fitted_curves};
use contact_laws::{
    FittedPoints, FrictionalLaw, HistoryRule, PointCurves, PointParameters, TableOptions, Tabulated, TractionLaw,
};
use serde_json::{Map, Value, json};
use std::hint::black_box;
use std::time::Instant;

/// Points of the kernel benchmark: 588 elements of 25 points, rounded.
const POINTS: usize = 15_000;

/// Rounds in which every kernel is timed once.
const ROUNDS: usize = 15;

/// Evaluations in a row that are timed as one.
const EVALUATIONS: u32 = 20;

/// Interferences that a fit covers (m), about those of the points.
const RANGE: [f64; 2] = [1e-7, 1e-4];

/// Parameters that the fitted law reads per point.
const N_COLUMNS: usize = 21;

fn friction<C: PointCurves + 'static>(curves: C) -> Result<Box<dyn TractionLaw>> {
    let mu = PointParameters::uniform(0.2, curves.len());
    Ok(Box::new(FrictionalLaw::try_new(curves, mu, HistoryRule::Incremental)?))
}

/// One timed kernel: its name in the figures and in the table, the law, and whether the tangent is asked for.
struct Kernel<'a> {
    key: &'static str,
    title: &'static str,
    law: &'a dyn TractionLaw,
    tangent: bool,
}

/// Nanoseconds per point.
pub(super) fn figures() -> Result<(Value, String)> {
    let curves = fitted_curves(POINTS, Some(RANGE))?;
    let fitted = friction(FittedPoints::<f64>::new(&curves))?;
    let single = friction(FittedPoints::<f32>::new(&curves))?;
    let standard = friction(curves)?;
    let table = Tabulated::try_new(asperity_sums()?, [1e-8, 1e-4], TableOptions::default())?;
    let table = friction(PointParameters::uniform(table, POINTS))?;
    let floor = LoadStoreFloor::<N_COLUMNS>::new(POINTS);
    let kernels = [
        ("fitted_ns", "fitted, tractions", &*fitted, false),
        ("fitted_tangent_ns", "fitted, tangent", &*fitted, true),
        ("std_ns", "fitted by std functions, tangent", &*standard, true),
        ("table_ns", "table, tangent", &*table, true),
        ("f32_ns", "fitted in f32, tangent", &*single, true),
        ("load_store_floor_ns", "load and store alone, tangent", &floor, true),
    ]
    .map(|(key, title, law, tangent)| Kernel {
        key,
        title,
        law,
        tangent,
    });

    let mut text = format!(
        "{POINTS} points, {}, minimum and median of {ROUNDS} rounds, ns per point\n",
        contact_laws::instruction_set()
    );
    let mut mix = |name: &str, shares| {
        let times = time(&kernels, shares);
        text += &format!("\n{name}\n");
        let (mut figures, mut medians) = (Map::new(), Map::new());
        for (kernel, (minimum, median)) in kernels.iter().zip(&times) {
            text += &format!("  {:34} {minimum:8.2} {median:8.2}\n", kernel.title);
            figures.insert(kernel.key.into(), json!(minimum));
            medians.insert(kernel.key.into(), json!(median));
        }
        let [_, (tangent, _), (standard, _), _, _, (floor, _)] = times;
        let (over_floor, speedup) = (tangent / floor, standard / tangent);
        text += &format!("  fitted over floor {over_floor:.2}, std over fitted {speedup:.2}\n");
        figures.insert("fitted_tangent_over_floor".into(), json!(over_floor));
        figures.insert("std_over_fitted_tangent".into(), json!(speedup));
        figures.insert("median".into(), Value::Object(medians));
        figures
    };
    // These figures stand for the kernel: every point evaluates the whole law.
    let mut figures = mix("stick_and_slip", [1, 1, 0]);
    let mixes = json!({
        "stick": mix("stick", [1, 0, 0]),
        "slip": mix("slip", [0, 1, 0]),
        "mixed_with_open": mix("mixed_with_open", [5, 3, 2]),
        "open": mix("open", [0, 0, 1]),
    });

    let difference = |law: &dyn TractionLaw| {
        let (mut ours, mut reference) = (Batch::new(POINTS, [5, 3, 2], 5), Batch::new(POINTS, [5, 3, 2], 5));
        ours.evaluate(law, true);
        reference.evaluate(&*standard, true);
        ours.difference(&reference)
    };
    let (error, single_error) = (difference(&*fitted), difference(&*single));
    text += &format!("\nlargest relative difference to std: {error:.1e}, in f32 {single_error:.1e}\n");
    figures.insert("points".into(), json!(POINTS));
    figures.insert("rounds".into(), json!(ROUNDS));
    figures.insert("max_relative_error".into(), json!(error));
    figures.insert("f32_max_relative_error".into(), json!(single_error));
    figures.insert("mixes".into(), mixes);
    Ok((Value::Object(figures), text))
}

/// Minimum and median time of each kernel in ns per point.
fn time(kernels: &[Kernel<'_>; 6], mix: [usize; 3]) -> [(f64, f64); 6] {
    let mut batches = [(); 6].map(|()| Batch::new(POINTS, mix, 5));
    let mut times = [const { Vec::new() }; 6];
    for _ in 0..ROUNDS {
        for ((kernel, batch), times) in kernels.iter().zip(&mut batches).zip(&mut times) {
            let start = Instant::now();
            for _ in 0..EVALUATIONS {
                black_box(batch.evaluate(kernel.law, kernel.tangent));
            }
            let evaluated = f64::from(EVALUATIONS) * POINTS as f64;
            times.push(start.elapsed().as_secs_f64() * 1e9 / evaluated);
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        (times[0], times[ROUNDS / 2])
    })
}
