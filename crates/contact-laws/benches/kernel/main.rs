//! Time per batch: kind of law, with and without tangent and along a direction, mix of regimes, number of points.

mod workload;

use std::hint::black_box;

use contact_laws::*;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use workload::{Batch, Path, asperity_sums, fitted_curves};

const N: usize = 15_000;
/// Stick, slip and open points in turn.
const MIXES: [(&str, [usize; 3]); 4] = [
    ("stick", [1, 0, 0]),
    ("slip", [0, 1, 0]),
    ("mixed", [5, 3, 2]),
    ("open", [0, 0, 1]),
];
/// Fitted range, as fits have it.
const RANGE: Option<[f64; 2]> = Some([1e-7, 1e-4]);

/// How steel yields.
const STEEL: Yield = Yield {
    strength: 330e6,
    tangent_modulus: 620e6,
    curves: YieldCurves::Published,
};

type Laws = Vec<(&'static str, Box<dyn TractionLaw>)>;

fn friction<C: PointCurves + 'static>(curves: C) -> Result<Box<dyn TractionLaw>, Error> {
    let mu = PointParameters::uniform(0.2, curves.len());
    Ok(Box::new(FrictionalLaw::try_new(curves, mu, HistoryRule::Incremental)?))
}

fn end_point() -> AsperityFriction {
    AsperityFriction::StickSlip(HistoryRule::EndPoint)
}

/// Asperities of a measured surface in 12 bins.
fn resolved(friction: AsperityFriction, yielding: Option<Yield>) -> Result<Box<dyn TractionLaw>, Error> {
    let direct = asperity_sums()?;
    let asperity = Asperity::try_new(*direct.material(), direct.population().radii()[0], yielding)?;
    let bins = AsperityBins::gauss(asperity, direct.population(), 8, 1e-5, &[0.5])?;
    let (bins, mu) = (
        PointParameters::try_indexed(bins, vec![0; N])?,
        PointParameters::uniform(0.2, N),
    );
    Ok(Box::new(ResolvedLaw::try_new(bins, mu, friction, Cone::Circle)?))
}

fn laws() -> Result<Laws, Error> {
    let curves = fitted_curves(N, RANGE)?;
    let direct = asperity_sums()?;
    let table = Tabulated::try_new(direct.clone(), [1e-8, 1e-4], TableOptions::default())?;
    let foundation = FoundationLaw::of_curves(
        PointParameters::uniform(direct.clone(), N),
        PointParameters::uniform(0.2, N),
        direct.material().mindlin_ratio(),
        64,
        1e-5,
    )?;
    Ok(vec![
        ("fitted", friction(FittedPoints::<f64>::new(&curves))?),
        ("fitted-f32", friction(FittedPoints::<f32>::new(&curves))?),
        ("fitted-std", friction(curves)?),
        ("table", friction(PointParameters::uniform(table, N))?),
        ("direct", friction(PointParameters::uniform(direct, N))?),
        (
            "elastic",
            friction(PointParameters::uniform(ElasticCurves::try_new(2e12, [1.5e12; 2])?, N))?,
        ),
        ("foundation-64", Box::new(foundation)),
        ("resolved-12", resolved(end_point(), None)?),
        ("resolved-12-yield", resolved(end_point(), Some(STEEL))?),
        (
            "resolved-12-radii-8",
            resolved(AsperityFriction::Annuli(HistoryRule::EndPoint, 8), None)?,
        ),
    ])
}

fn kinds(criterion: &mut Criterion) {
    let laws = laws().unwrap_or_else(|error| panic!("{error}"));
    let mut group = criterion.benchmark_group("kernel");
    group.throughput(Throughput::Elements(N as u64)).sample_size(20);
    for (mix, shares) in MIXES {
        for (name, law) in &laws {
            let mut batch = Batch::new(N, shares, law.info().n_state());
            // Loaded before, as in a prestressed joint: what has yielded unloads and reloads.
            batch.press(&**law);
            for (label, tangent) in [("traction", false), ("tangent", true)] {
                group.bench_function(BenchmarkId::new(format!("{name}/{label}"), mix), |b| {
                    b.iter(|| black_box(batch.evaluate(&**law, tangent)));
                });
            }
            group.bench_function(BenchmarkId::new(format!("{name}/derivative"), mix), |b| {
                b.iter(|| black_box(batch.derivative(&**law)));
            });
        }
    }
    group.finish();
}

fn sizes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("size");
    group.sample_size(20);
    for n in [1, 64, N, 1_000_000] {
        let law = fitted_curves(n, RANGE)
            .and_then(|curves| friction(FittedPoints::<f64>::new(&curves)))
            .unwrap_or_else(|error| panic!("{error}"));
        let mut batch = Batch::new(n, [5, 3, 2], law.info().n_state());
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::new("fitted", n), |b| {
            b.iter(|| black_box(batch.evaluate(&*law, true)));
        });
    }
    group.finish();
}

/// A period of a sine along the surface, from the steps of it one by one and followed at once; its amplitude is a share of what gross slip takes.
fn paths(criterion: &mut Criterion) {
    const POINTS: usize = 256;
    const STEPS: usize = 64;
    let laws = laws().unwrap_or_else(|error| panic!("{error}"));
    let mut group = criterion.benchmark_group("path");
    group
        .throughput(Throughput::Elements((POINTS * STEPS) as u64))
        .sample_size(20);
    for (name, law) in laws
        .iter()
        .filter(|(name, _)| ["fitted", "foundation-64"].contains(name))
    {
        for (label, share) in [("little", 0.03), ("half", 0.5), ("gross", 3.0)] {
            let mut path = Path::new(&**law, POINTS, STEPS, share);
            group.bench_function(BenchmarkId::new(format!("{name}/steps"), label), |b| {
                b.iter(|| black_box(path.step_by_step(&**law)));
            });
            group.bench_function(BenchmarkId::new(format!("{name}/followed"), label), |b| {
                b.iter(|| black_box(path.follow(&**law)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, kinds, sizes, paths);
criterion_main!(benches);
