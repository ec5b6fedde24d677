mod adhesion;
mod asperities;
mod authors_points;
mod batches;
mod bins;
mod closed_forms;
mod derivatives;
pub(crate) mod described;
mod dual;
mod elastic_plastic;
mod elementary;
mod fits;
mod fitted_points;
mod foundation;
mod friction;
mod greenwood_williamson;
mod invariants;
mod kinks;
mod linearised;
mod oracle;
mod radii;
mod refusals;
mod registry;
mod resolved;
mod resolved_properties;
mod slip_limit;
mod tables;

use proptest::prelude::*;
use proptest::test_runner::{TestCaseResult, TestRunner};

use crate::friction::rule::Memory;
use crate::*;

/// Steel as used for the beam of the method paper, section 4.1.
const STEEL: ElasticPair = ElasticPair {
    youngs_modulus: 192.85e9,
    poisson_ratio: 0.29,
};

fn normal_fit() -> NormalFit {
    NormalFit {
        a: 15.2,
        b: 2.2,
        c: -0.9,
        d: 0.3,
        e: 0.9,
        u_ref: 1e-6,
        t_ref: 1.0,
        range: Some([1e-7, 1e-5]),
    }
}

fn tangential_fit(ends: TangentialEnds) -> TangentialFit {
    TangentialFit {
        a: 29.0,
        b: 1.4,
        c: 0.3,
        d: 0.6,
        u_ref: 1e-6,
        k_ref: 1.0,
        range: Some([1e-7, 1e-5]),
        ends,
    }
}

/// Different along x and y.
fn fitted() -> FittedCurves {
    let y = TangentialFit {
        a: 29.3,
        d: 0.8,
        ..tangential_fit(TangentialEnds::Constant)
    };
    FittedCurves::try_new(normal_fit(), [tangential_fit(TangentialEnds::Mindlin), y]).unwrap()
}

fn elastic() -> ElasticCurves {
    ElasticCurves::try_new(2e12, [1.5e12, 1e12]).unwrap()
}

/// Heights that fall off exponentially, as a quantile function of the gaps below a tallest peak of `30 sigma`.
fn exponential_gaps(sigma: f64, n: usize) -> GapDistribution {
    let tallest = 30.0;
    let gaps: Vec<f64> = (0..=n).map(|i| tallest * i as f64 / n as f64).collect();
    // P(gap < s) = P(height > tallest - s), up to the normalisation over 0..tallest.
    let scale = 1.0 / -(-tallest).exp_m1();
    let mut probabilities: Vec<f64> = gaps
        .iter()
        .map(|s| scale * (-tallest).exp() * s.exp_m1())
        .map(|p| p.min(1.0))
        .collect();
    probabilities[n] = 1.0;
    let gaps: Vec<f64> = gaps.iter().map(|s| s * sigma).collect();
    GapDistribution::try_from_quantiles(&probabilities, &gaps).unwrap()
}

/// A population like that of a ground surface, with different radii.
fn population() -> AsperityPopulation {
    let n = 200;
    let probabilities: Vec<f64> = (0..=n).map(|i| f64::from(i) / f64::from(n)).collect();
    let values: Vec<f64> = probabilities
        .iter()
        .map(|p| 28e-6 * (0.35 * p.powf(0.4) + 0.3 * p.powi(6)))
        .collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, &values).unwrap();
    AsperityPopulation::try_new(gaps, 1.4e6, [1.2e-3, 1.5e-3]).unwrap()
}

/// Heights with an exponential upper tail, for which the curves are closed forms.
fn greenwood_williamson() -> GreenwoodWilliamsonCurves {
    let surface = GreenwoodWilliamsonSurface {
        heights: HeightDistribution::Exponential { scale: 2e-6 },
        reference_height: 9e-6,
        asperity_density: 1.4e6,
        radii: [1.2e-3, 1.5e-3],
    };
    GreenwoodWilliamsonCurves::try_new(surface, STEEL, TangentialReading::Mindlin).unwrap()
}

fn asperities(reading: TangentialReading) -> AsperitySumCurves {
    AsperitySumCurves::try_new(population(), STEEL, reading).unwrap()
}

fn table() -> Tabulated<AsperitySumCurves> {
    Tabulated::try_new(
        asperities(TangentialReading::Mindlin),
        [1e-8, 3e-5],
        TableOptions::default(),
    )
    .unwrap()
}

fn law<C: ContactCurves>(curves: C, mu: f64, history: HistoryRule) -> FrictionalLaw<PointParameters<C>> {
    FrictionalLaw::try_new(
        PointParameters::uniform(curves, 1),
        PointParameters::uniform(mu, 1),
        history,
    )
    .unwrap()
}

/// The fitted curves as vector registers evaluate them.
fn rough(curves: FittedCurves, mu: f64, history: HistoryRule) -> RoughLaw {
    let points = FittedPoints::new(&PointParameters::uniform(curves, 1));
    RoughLaw::try_new(points, PointParameters::uniform(mu, 1), history).unwrap()
}

/// All rules: the tests of any rule are about these.
fn histories() -> impl Iterator<Item = HistoryRule> + Clone {
    HISTORY_RULES.iter().map(|row| row.rule)
}

/// Any of the rules.
fn any_history() -> impl Strategy<Value = HistoryRule> {
    prop::sample::select(histories().collect::<Vec<_>>())
}

/// Of a property test: the number of cases, and where failures are kept.
fn config(cases: u32, file: &'static str, name: Option<&'static str>) -> ProptestConfig {
    ProptestConfig {
        cases,
        source_file: Some(file),
        test_name: name,
        ..ProptestConfig::default()
    }
}

/// Panics with the smallest input on which a property does not hold.
fn hold<S: Strategy>(config: ProptestConfig, strategy: &S, property: impl Fn(S::Value) -> TestCaseResult) {
    if let Err(error) = TestRunner::new(config).run(strategy, property) {
        panic!("{error}");
    }
}

fn memory(history: HistoryRule) -> Memory {
    history.needs().memory
}

/// A begin state that [`crate::testing::begin_state`] made with tractions as its memory, for any rule: stretches are
/// those of 1e12 Pa/m.
fn remembered(history: HistoryRule, [x, y, n, t_x, t_y]: [f64; 5]) -> [f64; 5] {
    match memory(history) {
        Memory::Traction => [x, y, n, t_x, t_y],
        Memory::Stretch => [x, y, n, 1e-12 * t_x, 1e-12 * t_y],
    }
}

fn relative(a: f64, b: f64) -> f64 {
    if a == b {
        0.0
    } else {
        (a - b).abs() / a.abs().max(b.abs())
    }
}

/// The example that the README shows is the one that is compiled.
#[test]
fn readme_shows_the_example() {
    let example = include_str!("../../examples/loop.rs");
    let code = example.split_once("\nuse contact_laws").unwrap().1;
    assert!(include_str!("../../README.md").contains(code));
}

/// Content of a file of the reference folder, or `None` with a note when the folder is not there.
fn reference(file: &str) -> Option<serde_json::Value> {
    let Some(folder) = std::env::var_os("BRB_REFERENCE") else {
        println!("skipped the comparison with {file}: BRB_REFERENCE is not set");
        return None;
    };
    // The variable may be relative to the workspace, while tests run in the crate's folder.
    let workspace = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = workspace.join(folder).join(file);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    Some(serde_json::from_str(&text).unwrap())
}

/// The measured population of a real interface.
fn measured_population() -> Option<AsperityPopulation> {
    let data = reference("brb_surface.json")?;
    let values = data["asperity_gap_quantiles"]["values"].as_array().unwrap();
    let values: Vec<f64> = values.iter().map(|v| v.as_f64().unwrap()).collect();
    let last = values.len() - 1;
    let probabilities: Vec<f64> = (0..=last).map(|i| i as f64 / last as f64).collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, &values).unwrap();
    let number = |name: &str| data[name].as_f64().unwrap();
    let radius = number("effective_radius");
    Some(AsperityPopulation::try_new(gaps, number("asperities_per_area"), [radius; 2]).unwrap())
}
